"""Coverage of intervals of annual rates and of effects on rates, in the studies of median_coverage.

True rates are integrals of the true probabilities over the same hazard curve. In the case `uneven`,
demands of skewed bridges scatter more than those of straight ones; a demand model has one scatter
for all variants of a bridge. Usage: rate_coverage.py [replicates]
"""

import json
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from median_coverage import IM, MOTIONS, SETTINGS, SHIFTS, STATE, study
from scipy import special

from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.hazard import HazardCurve
from skewbridge.fragility.rates import rate_effects, rate_table

LEVELS = np.geomspace(0.05, 2.0, 12)
#: Slope of ln H on ln im from -1.5 to -3.5.
RATES = 0.02 * np.exp(-2.5 * np.log(LEVELS / 0.1) - 0.27 * np.log(LEVELS / 0.316) ** 2)
HAZARD = HazardCurve(im=IM, levels=LEVELS, rates=RATES[None], quantiles=np.zeros(0))
CASES = {
    "no_drift": {"drift": 0.0, "even": True},
    "drift": {"drift": 0.02, "even": True},
    "blocks": {"drift": 0.02, "even": True, "blocks": True},
    "uneven": {"drift": 0.0},
}


def true_rate(skew, gap, friction, *, drift, even=False, blocks=False):
    """Return the annual rate of the state in one variant; blocks do not change it."""
    x = np.linspace(np.log(0.1), np.log(1.5), MOTIONS)
    scatter = np.sqrt(0.3**2 + 0.12**2 * (skew > 0 or even) + 0.05**2)

    def probability(ln_im):
        scale = 2.0 ** ((np.clip(ln_im, x[0], x[-1]) - x.mean()) / np.ptp(x))
        y = np.log(0.035) + ln_im + drift * (skew == 60) * (ln_im - x.mean())
        y += SHIFTS["skew_deg"][skew] + SHIFTS["gap_mm"][gap] + SHIFTS["friction"][friction]
        wide = np.hypot(scale * scatter, STATE.dispersion)
        return special.ndtr((y - np.log(STATE.threshold)) / wide)

    return HAZARD.rate(probability, 0.1).value


def covered(rng, case):
    """Return whether the intervals of one study cover the true rates (95 %) and effects (90 %)."""
    rows, inside = study(rng, **CASES[case], drifting=["skew_deg"]), {}
    models = fit_models(rows, [STATE], SETTINGS)
    curves = fit_study(models, [STATE], SETTINGS)
    truth = {key: true_rate(*key, **CASES[case]) for key in product(*SHIFTS.values())}
    table = rate_table(curves, models, [STATE], pd.DataFrame(), HAZARD)
    true = np.array([truth[key] for key in zip(*(table[name] for name in SHIFTS), strict=True)])
    inside["rates"] = (
        table["annual_rate_low"].le(true).mul(table["annual_rate_high"] >= true).mean()
    )
    inside["rates_bias"] = np.log(table["annual_rate"] / true).mean()
    effects = rate_effects(models, [STATE], HAZARD, SETTINGS, curves=curves)
    for row in effects[effects["scope"] == "pooled"].to_dict("records"):
        place = list(SHIFTS).index(row["axis"])
        starts = [key for key in truth if key[place] == row["from_value"]]
        ends = [(*key[:place], row["to_value"], *key[place + 1 :]) for key in starts]
        ratio = np.mean([np.log(truth[b] / truth[a]) for a, b in zip(starts, ends, strict=True)])
        low, middle, high = np.log([row["ci_low"], row["ratio"], row["ci_high"]])
        name = f"{row['axis']}_{row['to_value']:g}"
        inside |= {name: low <= ratio <= high, f"{name}_width": 0.5 * (high - low)}
        inside[f"{name}_bias"] = middle - ratio
    return inside


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    results = {}
    for case in CASES:
        rng = np.random.default_rng(47)
        table = pd.DataFrame([covered(rng, case) for _ in range(count)]).astype(float)
        results[case] = table.mean().round(4).to_dict() | {"replicates": count}
        text = json.dumps(results, indent=1)
        Path(__file__).with_suffix(".json").write_text(text + "\n", encoding="utf-8")
