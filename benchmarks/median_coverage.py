"""Coverage of intervals of pooled median effects and predictions in simulated studies.

Studies have three skews, two gaps and two frictions. In incomplete blocks, each motion runs all
skews in two of the four cells of gap and friction; with two orientations, in the two others at the
second. The effect of skew scatters from motion to motion, and between orientations, equally in all
cells. The largest effects of all axes drift with ln intensity. All scatter doubles over the range
of intensities. Runs with the largest demands are censored. Usage: median_coverage.py [replicates]
"""

import json
import sys
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pandas as pd

from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.effects import median_effects
from skewbridge.fragility.joint import JointModel, joint_table
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.settings import FitSettings

IM, DEMAND, MOTIONS = "im_saavg_rotd50_g", "column_drift_ratio", 32
SETTINGS = FitSettings(im=IM)
SHIFTS = {"skew_deg": {0: 0.0, 30: 0.05, 60: 0.12}, "gap_mm": {25: 0.0, 51: 0.03},
          "friction": {0.0: 0.0, 0.5: -0.04}}  # fmt: skip
CASES = {
    "no_drift": {"drift": 0.0},
    "drift": {"drift": 0.02},
    "blocks": {"drift": 0.02, "blocks": True},
    "orientations": {"drift": 0.02, "blocks": True, "angles": (0.0, 90.0)},
    "one_motion_5x": {"drift": 0.0, "wild": 5.0},
}
STATE = LimitState(component="c", name="s", demand=DEMAND, threshold=0.02, dispersion=0.35)
LN_IM = np.linspace(np.log(0.1), np.log(1.5), MOTIONS)
LARGEST = {"skew_deg": 60, "gap_mm": 51, "friction": 0.5}  # values whose effects drift


def ln_median(values, drift):
    """Return the ln intensity at which the median demand reaches the threshold.

    The effects and drifts of the levels are interpolated linearly.
    """
    shift = sum(
        np.interp(values[axis], [*SHIFTS[axis]], [*SHIFTS[axis].values()]) for axis in SHIFTS
    )
    drifts = [
        np.interp(values[a], [*SHIFTS[a]], [v == LARGEST[a] for v in SHIFTS[a]]) for a in SHIFTS
    ]
    middle = LN_IM.mean()
    return (np.log(STATE.threshold / 0.035) - shift + drift * sum(drifts) * middle) / (
        1.0 + drift * sum(drifts)
    )


def effect(axis, start, end, drift):
    """Return the true difference of two ln medians, averaged over the values of other axes."""
    others = [name for name in SHIFTS if name != axis]
    cells = [
        dict(zip(others, cell, strict=True)) for cell in product(*(SHIFTS[name] for name in others))
    ]
    at = [[ln_median({**cell, axis: value}, drift) for value in (start, end)] for cell in cells]
    return float(np.mean(np.diff(at)))


def study(rng, *, drift, blocks=False, wild=1.0, even=False, angles=(0.0,), drifting=LARGEST):
    """Return demands of one simulated study; the slope of ln demand on ln intensity is 1.

    Demands of skewed bridges scatter more than those of straight ones, unless ``even``. The largest
    effects of the axes ``drifting`` drift.
    """
    x = LN_IM
    scale = 2.0 ** ((x - x.mean()) / np.ptp(x))
    scale[rng.integers(MOTIONS)] *= wild
    cells = list(product(SHIFTS["gap_mm"], SHIFTS["friction"]))
    pairs = list(combinations(cells, 2))
    of_motion, rows = 0.3 * rng.normal(size=MOTIONS), []
    for m, (place, angle) in product(range(MOTIONS), enumerate(angles)):
        common = of_motion[m] + (0.2 * rng.normal() if len(angles) > 1 else 0.0)
        of_skew = {skew: 0.12 * rng.normal() * (skew > 0 or even) for skew in SHIFTS["skew_deg"]}
        pair = pairs[m % 6]
        others = [cell for cell in cells if cell not in pair]
        for gap, friction in (others if place else pair) if blocks else cells:
            for skew, shift in SHIFTS["skew_deg"].items():
                at = {"skew_deg": skew, "gap_mm": gap, "friction": friction}
                drifts = sum(at[axis] == LARGEST[axis] for axis in drifting)
                y = np.log(0.035) + x[m] + shift + drift * drifts * (x[m] - x.mean())
                y += SHIFTS["gap_mm"][gap] + SHIFTS["friction"][friction]
                y += scale[m] * (common + of_skew[skew] + 0.05 * rng.normal())
                rows.append((skew, gap, friction, f"m{m:02d}", angle, np.exp(x[m]), np.exp(y)))
    names = ["skew_deg", "gap_mm", "friction", "motion_id", "incidence_deg", IM, DEMAND]
    table = pd.DataFrame(rows, columns=names)
    limit = table[DEMAND].quantile(0.85)
    ended = table[DEMAND] > limit
    status = np.where(ended, "numerical_failure", "ok")
    key = table[names[:3]].astype(str).agg("_".join, axis=1)
    table = table.assign(variant=key, bridge="b", abutment="contact_friction", status=status)
    table[DEMAND] = np.where(ended, limit, table[DEMAND])
    return table.assign(scale=1.0, complete=~ended)


def covered(rng, case):
    """Return whether the 90 % intervals of one study cover the true values."""
    rows = study(rng, **CASES[case])
    models = fit_models(rows, [STATE], SETTINGS)
    found = median_effects(models, [STATE], SETTINGS).query("scope == 'pooled'")
    drift, inside = CASES[case]["drift"], {}
    for row in found.to_dict("records"):
        truth = effect(row["axis"], row["from_value"], row["to_value"], drift)
        low, high = np.log([row["ci_low"], row["ci_high"]])
        name = f"{row['axis']}_{row['to_value']:g}"
        inside[name], inside[f"{name}_width"] = low <= truth <= high, 0.5 * (high - low)
    joint = joint_table(models, [STATE], SETTINGS).iloc[0].to_dict()
    point = {"skew_deg": 30.0, "gap_mm": 38.0, "friction": 0.25}
    _, low, high = JointModel(joint).median(point, level=0.9)
    truth = ln_median(point, drift)
    return inside | {"predict": np.log(low) <= truth <= np.log(high)}


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    results = {}
    for case in CASES:
        rng = np.random.default_rng(45)
        table = pd.DataFrame([covered(rng, case) for _ in range(count)]).astype(float)
        results[case] = table.mean().round(4).to_dict() | {"replicates": count}
    text = json.dumps(results, indent=1)
    Path(__file__).with_suffix(".json").write_text(text + "\n", encoding="utf-8")
