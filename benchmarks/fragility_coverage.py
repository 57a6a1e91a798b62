"""Coverage of the intervals of fits, from simulations of the sampling plans in use.

`python benchmarks/fragility_coverage.py [replicates]` measures all plans and stores the shares.
"""

import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.effects import median_effects
from skewbridge.fragility.fits import fit_brackets, fit_capacities, fit_cloud, fit_stripes
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.settings import FitSettings

THETA, BETA = 1.0, 0.4
IM: Final = "im_saavg_rotd50_g"
SETTINGS: Final = FitSettings(im=IM)
SEED: Final = 20240501
STATES: Final = [
    LimitState(
        component="deck",
        name=name,
        demand="deck_disp_m",
        threshold=threshold,
        dispersion=0.35,
        collapse="peak",
    )
    for name, threshold in (("slight", 1.0), ("moderate", 1.6))
]
#: Ratio of the capacity with friction to that without, in the pairs of `_runs`.
RATIO: Final = 0.93

type Hits = Mapping[str, bool]
type Plan = Callable[[np.random.Generator], Hits]


def _hits(fit: Any) -> Hits:
    """Return whether the intervals of a fit contain the truth; empty without an estimate."""
    if fit.status != "ok":
        return {}
    ends = {"theta": (fit.ci_theta, THETA), "beta": (fit.ci_beta, BETA)}
    return {name: low <= truth <= high for name, ((low, high), truth) in ends.items()}


def _stripes(levels: int, runs: int) -> Plan:
    im = np.exp(np.linspace(np.log(0.4), np.log(2.5), levels))

    def simulate(rng: np.random.Generator) -> Hits:
        capacity = THETA * np.exp(BETA * rng.normal(size=(levels, runs)))
        return _hits(fit_stripes(im, np.full(levels, runs), np.sum(capacity <= im[:, None], 1)))

    return simulate


def _capacities(runs: int, *, brackets: bool = False) -> Plan:
    im = np.append(np.exp(np.linspace(np.log(0.4), np.log(2.5), 8)), np.inf)

    def simulate(rng: np.random.Generator) -> Hits:
        capacity = THETA * np.exp(BETA * rng.normal(size=runs))
        if not brackets:
            limit = 1.23  # 30 % of the capacities lie above
            return _hits(fit_capacities(np.minimum(capacity, limit), capacity > limit))
        place = np.searchsorted(im, capacity)
        return _hits(fit_brackets(np.append(0.0, im)[place], im[place]))

    return simulate


def _cloud(motions: int, censored: float = 0.0, repeats: int = 1) -> Plan:
    def simulate(rng: np.random.Generator) -> Hits:
        x = rng.uniform(np.log(0.2), np.log(3.0), (motions, repeats))
        own = (
            0.6 if repeats > 1 else 0.0
        )  # share of the variance that differs between the runs of a motion
        scatter = np.sqrt(1.0 - own) * rng.normal(size=(motions, 1))
        scatter = scatter + np.sqrt(own) * rng.normal(size=x.shape)
        ln_d = (x + BETA * scatter).ravel()
        limit = np.where(
            rng.random(ln_d.size) < 2.0 * censored, rng.normal(0.0, 0.8, ln_d.size), 9.9
        )
        low, high = np.exp(np.minimum(ln_d, limit)), np.exp(np.where(ln_d > limit, np.inf, ln_d))
        codes = np.repeat(np.arange(motions), repeats) if repeats > 1 else None
        return _hits(fit_cloud(np.exp(x.ravel()), low, THETA, high, motions=codes))

    return simulate


def _runs(rng: np.random.Generator, motions: int, repeats: int, cells: int = 1) -> pd.DataFrame:
    """Return the demands of a study; with repeats or cells, runs of a motion share most scatter.

    ``cells`` above 1 is the number of pairs of variants with friction 0 and 0.5.
    """
    x = rng.uniform(np.log(0.2), np.log(3.0), (motions, repeats))
    common = rng.normal(size=(motions, 1)) if cells > 1 or repeats > 1 else 0.0
    response = 0.06 * rng.normal(size=(motions, 1))  # effect of friction under each motion
    parts: list[pd.DataFrame] = []
    for number in range(cells if cells == 1 else 2 * cells):
        rubbing = number % 2
        own = 1.0 if cells == 1 and repeats == 1 else 0.2
        scatter = np.sqrt(1.0 - own**2) * common + own * rng.normal(size=x.shape)
        ln_d = x + BETA * scatter + rubbing * (response - np.log(RATIO))
        parts.append(
            pd.DataFrame(
                {
                    "variant": f"v{number:02d}",
                    "bridge": "b",
                    "abutment": "a",
                    "skew_deg": float(number // 2),
                    "friction": 0.5 * rubbing,
                    "motion_id": np.repeat([f"m{m:03d}" for m in range(motions)], repeats),
                    "scale": np.tile(np.arange(repeats) + 1.0, motions),
                    "incidence_deg": 0.0,
                    "status": "ok",
                    IM: np.exp(x.ravel()),
                    "deck_disp_m": np.exp(ln_d.ravel()),
                }
            )
        )
    return pd.concat(parts, ignore_index=True)


def _study(motions: int, method: str, repeats: int = 1) -> Plan:
    truth = {"theta": THETA, "beta": BETA, "beta_total": float(np.hypot(BETA, 0.35))}

    def simulate(rng: np.random.Generator) -> Hits:
        models = fit_models(_runs(rng, motions, repeats), STATES, SETTINGS)
        curves = fit_study(models, STATES, SETTINGS)
        row = curves[(curves["method"] == method) & (curves["limit_state"] == "slight")].iloc[0]
        if row["status"] != "ok":
            return {}
        return {n: row[f"{n}_low"] <= value <= row[f"{n}_high"] for n, value in truth.items()}

    return simulate


def _medians(motions: int, cells: int = 12) -> Plan:
    def simulate(rng: np.random.Generator) -> Hits:
        runs, axes = _runs(rng, motions, 1, cells), ["friction"]
        models = fit_models(runs, STATES[:1], SETTINGS, further=axes)
        table = median_effects(models, STATES[:1], SETTINGS, axes=axes)
        row = table[table["scope"] == "pooled"].iloc[0]
        return {"ratio": row["ci_low"] <= RATIO <= row["ci_high"]}

    return simulate


SAMPLING_PLANS: Final[dict[str, Plan]] = {
    "stripes 8 x 20": _stripes(8, 20),
    "capacities 40, 30 % censored": _capacities(40),
    "same records 8 x 20, brackets": _capacities(20, brackets=True),
    "cloud 32, exact": _cloud(32),
    "cloud 60, 20 % right-censored": _cloud(60, censored=0.2),
    "cloud 32 motions x 3, jackknife": _cloud(32, repeats=3),
    "study 64, cloud": _study(64, "cloud"),
    "study 64, exceedance, common slope": _study(64, "exceedance"),
    "study 32 x 3, exceedance, jackknife": _study(32, "exceedance", repeats=3),
    "pooled median effect, 12 cells x 16 (90 %)": _medians(16),
    "pooled median effect, 12 cells x 32 (90 %)": _medians(32),
}


def measure_coverage(plan: str, replicates: int, seed: int = SEED) -> dict[str, Any]:
    """Return the share of replicates whose interval contains the truth, by parameter."""
    rng = np.random.default_rng(seed)
    hits = pd.DataFrame([SAMPLING_PLANS[plan](rng) for _ in range(replicates)])
    shares = hits.dropna().astype(float).mean().round(4).to_dict()
    usable = float(hits.notna().all(axis=1).mean())
    return {"plan": plan, "replicates": replicates, "usable": usable, **shares}


def main() -> None:
    """Measure every plan and store the shares."""
    replicates = int(sys.argv[1]) if sys.argv[1:] else 500
    rows: list[dict[str, Any]] = []
    for plan in SAMPLING_PLANS:
        begin = time.process_time()
        rows.append(measure_coverage(plan, replicates))
        sys.stderr.write(f"{rows[-1]} {time.process_time() - begin:.0f} s\n")
    out = Path(__file__).with_suffix(".json")
    out.write_text(json.dumps({"seed": SEED, "rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
