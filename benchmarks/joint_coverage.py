"""Coverage of the intervals of the joint model at the default design.

`python benchmarks/joint_coverage.py` repeats the stored simulation (3 to 4 CPU-minutes); a test
reads its numbers and repeats a few replicates.
"""

import json
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from common import share_of
from joblib import Parallel, delayed

from skewbridge.files.tables import records_of
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.joint import JointModel, joint_table
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.settings import FitSettings

SEED: Final = 20261122
REPLICATES: Final = 500
MOTIONS: Final = 32
LEVELS_G: Final = (0.1, 1.5)
IM: Final = "im_saavg_rotd50_g"
DEMAND: Final = "column_drift_ratio"
AXES: Final = {"skew_deg": (0.0, 30.0, 60.0), "gap_mm": (25.0, 51.0), "friction": (0.0, 0.5)}
# source: results of the default study with 16 motions (drift, deck displacement, keys): slope 1.05,
# scatter 0.26 between motions and 0.05 to 0.11 within
SLOPE: Final = 1.05
TAU: Final = 0.26
SIGMA: Final = 0.08
MEDIAN_G: Final = 0.6
COLLAPSES: Final = (0.0, 0.05, 0.2)
PLACES: Final[dict[str, dict[str, float]]] = {
    "corner": {"skew_deg": 0.0, "gap_mm": 25.0, "friction": 0.0},
    "far corner": {"skew_deg": 60.0, "gap_mm": 51.0, "friction": 0.5},
    "between": {"skew_deg": 45.0, "gap_mm": 40.0, "friction": 0.3},
}
STATE: Final = LimitState(
    component="column_drift", name="simulated", demand=DEMAND, threshold=0.01, dispersion=0.35
)


def ln_effect(place: dict[str, Any]) -> Any:
    """Return the effect of skew (quadratic), gap, friction and skew x friction on ln demand."""
    skew, gap = place["skew_deg"] / 60.0, place["gap_mm"] / 50.8
    friction = place["friction"]
    return 0.10 * skew + 0.15 * skew**2 + 0.04 * gap - 0.08 * friction + 0.05 * skew * friction


def design() -> pd.DataFrame:
    """Return the runs of the default design without demands."""
    rows = [
        dict(zip(AXES, values, strict=True)) | {"variant": f"v{number:02d}"}
        for number, values in enumerate(product(*AXES.values()))
    ]
    motions = pd.DataFrame({"motion": range(MOTIONS)})
    table = pd.DataFrame(rows).merge(motions, how="cross")
    return table.assign(
        bridge="simulated",
        abutment="contact_friction",
        motion_id="m" + table["motion"].astype(str),
        scale=1.0,
        incidence_deg=0.0,
    )


def simulated(table: pd.DataFrame, collapse: float, rng: np.random.Generator) -> pd.DataFrame:
    """Return the design with demands; a run collapses if its demand exceeds a limit.

    ``collapse`` is the share of runs that collapse; their demand is recorded up to the limit.
    """
    low, high = np.log(LEVELS_G)
    share = (np.arange(MOTIONS) + rng.uniform(size=MOTIONS)) / MOTIONS
    ln_im = low + (high - low) * rng.permutation(share)
    u = TAU * rng.normal(size=MOTIONS)
    motion = table["motion"].to_numpy()
    y = SLOPE * (ln_im[motion] - np.log(MEDIAN_G)) + ln_effect(table) + u[motion]
    y = y + np.log(STATE.threshold) + SIGMA * rng.normal(size=len(table))
    limit = np.inf if collapse == 0.0 else float(np.quantile(y, 1.0 - collapse))
    return table.assign(
        **{
            IM: np.exp(ln_im[motion]),
            DEMAND: np.exp(np.minimum(y, limit)),
            "status": np.where(y > limit, "collapse", "ok"),
        }
    )


def truth(place: dict[str, float]) -> float:
    """Return the true ln median at a place (values of the axes)."""
    return float(np.log(MEDIAN_G) - ln_effect(place) / SLOPE)


def measure(collapse: float, replicates: int, seed: int) -> list[dict[str, Any]]:
    """Return coverage of the 95 % intervals for one share of collapses, one row per quantity."""
    rng = np.random.default_rng(seed)
    table, settings = design(), FitSettings(im=IM)
    beta = float(np.hypot(TAU, SIGMA) / SLOPE)
    true = {name: float(np.exp(truth(place))) for name, place in PLACES.items()}
    true |= {"beta": beta, "beta_total": float(np.hypot(beta, STATE.dispersion / SLOPE))}
    hits: dict[str, list[bool]] = {name: [] for name in true}
    errors: dict[str, list[float]] = {name: [] for name in true}
    for _ in range(replicates):
        found = joint_table(simulated(table, collapse, rng), [STATE], None, settings)
        for row in records_of(found[found["status"] == FITTED]):
            model = JointModel(row)
            estimates = {name: model.median(place) for name, place in PLACES.items()}
            for name in ("beta", "beta_total"):
                estimates[name] = row[name], row[f"{name}_low"], row[f"{name}_high"]
            for name, (estimate, low, high) in estimates.items():
                hits[name].append(low <= true[name] <= high)
                errors[name].append(float(np.log(estimate / true[name])))
    rows: list[dict[str, Any]] = []
    for name, values in hits.items():
        coverage, low, high = share_of(values)
        row = {"collapse": collapse, "quantity": name, "coverage": coverage, "low": low}
        row |= {"high": high, "replicates": len(values)}
        row |= {"bias": float(np.mean(errors[name])), "scatter": float(np.std(errors[name]))}
        rows.append(row)
    return rows


def main() -> None:
    jobs = (delayed(measure)(share, REPLICATES, SEED) for share in COLLAPSES)
    rows = [row for part in Parallel(n_jobs=len(COLLAPSES))(jobs) for row in part]
    study = {
        "seed": SEED,
        "replicates": REPLICATES,
        "motions": MOTIONS,
        "variants": len(design()) // MOTIONS,
        "nominal": 0.95,
        "rows": rows,
    }
    out = Path(__file__).with_suffix(".json")
    out.write_text(json.dumps(study, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
