"""Simulated studies: coverage of effect intervals and errors of family-wise verdicts.

`python benchmarks/effect_simulations.py` repeats the stored simulations; a test repeats a few.

A simulated study has two skews, two gaps and two frictions. ln demand = line in ln intensity +
effects + scatter of the motion + response of the motion to each axis + scatter of the run. The
scatter is that of the default study (paired ratios: 3 to 10 %, part of it common to all variants).
Each run has a random limit: a run whose demand exceeds it collapses, and its demand is recorded up
to the limit. The limits are chosen so that 0, 5 or 20 % of the pairs are bounds.
"""

import json
import sys
from collections.abc import Mapping
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from common import share_of
from scipy import special

from skewbridge.demands.validity import BEYOND_MODEL
from skewbridge.files.tables import Floats
from skewbridge.fragility.effects import AT_LEAST, AT_MOST, Pairs, demand_effects, effect_table
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.verdicts import HIGHER, LOWER

SIMULATIONS: Final = 500
SEED: Final = 20261122
BOUNDS: Final = (0.0, 0.05, 0.2)
MOTIONS: Final = (16, 32)
LEVELS: Final = (0.90, 0.95)
SETTINGS: Final = FitSettings()
GRID: Final = {"skew_deg": (0.0, 60.0), "gap_mm": (25.0, 51.0), "friction": (0.0, 0.5)}
DRIFT: Final = "column_drift_ratio"
#: Scatter of a run within its motion, by demand.
RUN_SCATTER: Final = {DRIFT: 0.03, "deck_disp_m": 0.04, "unseating_m": 0.07}
#: Axis of the pairs; the other axes identify a pair of variants.
AXIS: Final = "friction"
#: Change of ln demand along each axis at ``REFERENCE_G``, in the studies of coverage.
EFFECTS: Final = {"skew_deg": 0.16, "gap_mm": 0.03, "friction": -0.04}
REFERENCE_G: Final = 0.4
#: Change of the effects per unit of ln intensity, in the studies of effects at an intensity.
SLOPE: Final = -0.10
#: Standard deviations of ln demand between motions and of the ln limit between runs.
MOTION_SCATTER: Final = 0.35
LIMIT_SCATTER: Final = 0.6


type Share = dict[str, Any]


def shares_of(hits: Mapping[str, list[bool]], motions: int, bounds: float) -> list[Share]:
    """Return one row per outcome: its share of the simulations with 95 % bounds."""
    rows: list[Share] = []
    for what, values in sorted(hits.items()):
        share, low, high = share_of(values)
        case = {"what": what, "motions": motions, "bounds": bounds}
        rows.append(case | {"share": share, "low": low, "high": high, "simulations": len(values)})
    return rows


def simulate(
    motions: int,
    effects: Mapping[str, float],
    slope: float,
    ln_limit: float,
    rng: np.random.Generator,
    *,
    bridge: str = "simulated",
) -> Pairs:
    """Return the pairs of a study along `AXIS`; limits of collapse have the median ``ln_limit``."""
    shape = (motions, *(len(values) for values in GRID.values()))
    x = np.log(0.1) + np.log(20.0) * rng.random(motions)
    common = x + MOTION_SCATTER * rng.normal(size=motions)
    ln_demands: dict[str, Floats] = {}
    for name, scatter in RUN_SCATTER.items():
        # heavier tails than the normal distribution, with the same variance
        ln_demand = scatter * rng.standard_t(6, size=shape) / np.sqrt(1.5)
        ln_demand += (common + 0.2 * rng.normal(size=motions)).reshape(-1, 1, 1, 1)
        for place, axis in enumerate(GRID, start=1):
            # the effect of each axis differs between motions
            change = effects[axis] + slope * (x - np.log(REFERENCE_G))
            change += 0.7 * scatter * rng.normal(size=motions)
            np.moveaxis(ln_demand, place, -1)[..., 1] += change.reshape(-1, 1, 1)
        ln_demands[name] = ln_demand
    # a collapse reduces all demands of a run by the same factor
    limit = ln_limit + LIMIT_SCATTER * rng.normal(size=shape)
    over = np.maximum(ln_demands[DRIFT] - limit, 0.0)
    runs = {name: np.exp(values - over) for name, values in ln_demands.items()}
    runs |= {"complete": over == 0.0, "status": np.where(over > 0.0, "collapse", "ok")}
    runs |= {BEYOND_MODEL: np.zeros(shape, dtype=np.bool_)}
    runs |= {SETTINGS.im: np.broadcast_to(np.exp(x).reshape(-1, 1, 1, 1), shape)}
    others = [name for name in GRID if name != AXIS]
    cells = np.array(list(product(*(GRID[name] for name in others))) * motions)
    place = 1 + list(GRID).index(AXIS)
    table = pd.DataFrame(
        {"motion_id": np.repeat([f"m{k:03d}" for k in range(motions)], len(cells) // motions)}
        | {"bridge": bridge, "abutment": "contact_friction"}
        | {name: cells[:, k] for k, name in enumerate(others)}
        | {
            f"{name}_{end}": np.take(values, value, place).ravel()
            for name, values in runs.items()
            for value, end in enumerate(("from", "to"))
        }
    )
    model = {"bridge": bridge, "abutment": "contact_friction", "axis": AXIS}
    start, to = GRID[AXIS]
    return Pairs(model | {"from_value": start, "to_value": to}, table)


@cache
def limit_of(bounds: float) -> float:
    """Return the ln limit at which the share ``bounds`` of the pairs are bounds."""
    if bounds == 0.0:
        return np.inf
    low, high = np.log(0.5), np.log(100.0)
    for _ in range(12):
        middle = 0.5 * (low + high)
        pairs = simulate(3000, EFFECTS, 0.0, middle, np.random.default_rng(1))
        share = np.isin(pairs.side, (AT_LEAST, AT_MOST)).mean()
        low, high = (middle, high) if share > bounds else (low, middle)
    return 0.5 * (low + high)


def effects_of(
    pairs: Pairs, demands: list[str]
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return rows of effects on some demands (pooled first), and rows of effects by intensity."""
    reference = {(pairs.labels["bridge"], pairs.labels["abutment"]): REFERENCE_G}
    return demand_effects(pairs, names=demands, settings=SETTINGS, reference_im=reference)


def holds(row: Mapping[str, Any], dof: int, truth: float) -> dict[float, bool]:
    """Return by level whether the interval of an effect contains the true ln ratio."""
    low, high = np.log([row["ci_low"], row["ci_high"]])
    half, middle = 0.5 * (high - low), 0.5 * (low + high)
    t = {level: special.stdtrit(dof, 0.5 + 0.5 * level) for level in LEVELS}
    distance = abs(truth - middle)
    return {level: bool(distance <= half * t[level] / t[LEVELS[0]]) for level in LEVELS}


def pooled_effects(motions: int, bounds: float, simulations: int, seed: int) -> list[Share]:
    """Return how often intervals of pooled effects contain the true effect."""
    rng = np.random.default_rng(seed)
    hits: dict[str, list[bool]] = {}
    for _ in range(simulations):
        pairs = simulate(motions, EFFECTS, 0.0, limit_of(bounds), rng)
        row = effects_of(pairs, [DRIFT])[0][0]
        for level, hit in holds(row, row["dof"], EFFECTS[AXIS]).items():
            hits.setdefault(f"coverage {level:.0%}, pooled effect", []).append(hit)
    return shares_of(hits, motions, bounds)


def effects_at_intensities(motions: int, bounds: float, simulations: int, seed: int) -> list[Share]:
    """Return how often intervals of slopes and of effects at an intensity contain the truth."""
    rng = np.random.default_rng(seed)
    hits: dict[str, list[bool]] = {}
    places = {0: "lowest", 4: "middle", 8: "highest", 9: "reference"}
    for _ in range(simulations):
        pairs = simulate(motions, EFFECTS, SLOPE, limit_of(bounds), rng)
        (pooled, *_), by_intensity = effects_of(pairs, [DRIFT])
        ends = {"ci_low": np.exp(pooled["slope_low"]), "ci_high": np.exp(pooled["slope_high"])}
        for level, hit in holds(ends, pooled["dof"] - 1, SLOPE).items():
            hits.setdefault(f"coverage {level:.0%}, slope", []).append(hit)
        for k, place in places.items():
            row = by_intensity[k]
            truth = EFFECTS[AXIS] + SLOPE * np.log(row["im"] / REFERENCE_G)
            for level, hit in holds(row, row["n_motions"] - 2, truth).items():
                hits.setdefault(f"coverage {level:.0%}, at the {place} intensity", []).append(hit)
    return shares_of(hits, motions, bounds)


def family_errors(motions: int, bounds: float, simulations: int, seed: int) -> list[Share]:
    """Return how often any effect is called lower or higher although all equal the margin.

    Both for the family-wise verdicts and for the verdicts of single intervals.
    """
    rng = np.random.default_rng(seed)
    at_margin = dict.fromkeys(GRID, 0.0) | {"friction": float(np.log1p(SETTINGS.margin))}
    rows: list[dict[str, Any]] = []
    for number in range(simulations):
        limit = limit_of(bounds)
        pairs = simulate(motions, at_margin, 0.0, limit, rng, bridge=str(number))
        rows += effects_of(pairs, list(RUN_SCATTER))[0]
    found = effect_table(pd.DataFrame(columns=list(GRID)), rows)
    found = found[found["scope"] == "variant"]
    wrong = {
        f"type I at the margin, any {name}": found[name].isin([LOWER, HIGHER])
        for name in ("verdict", "verdict_family")
    }
    hits = {what: list(rows.groupby(found["bridge"]).any()) for what, rows in wrong.items()}
    return shares_of(hits, motions, bounds)


STUDIES: Final = (pooled_effects, effects_at_intensities, family_errors)


def main() -> None:
    """Simulate all cases and store them."""
    rows: list[Share] = []
    for motions, bounds, study in product(MOTIONS, BOUNDS, STUDIES):
        rows += study(motions, bounds, SIMULATIONS, SEED)
        sys.stderr.write(f"{study.__name__}, {motions} motions, {bounds:.0%} bounds\n")
    rows.sort(key=lambda row: (row["what"], row["motions"], row["bounds"]))
    out = Path(__file__).with_suffix(".json")
    out.write_text(json.dumps({"seed": SEED, "rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
