"""How often the intervals cover the truth: simulation of the sampling plans in use.

`python benchmarks/fragility_coverage.py` reruns the stored study (about 10 minutes), with names of
plans as arguments those alone; a test reruns rows of it.
"""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.fragility.old_likelihood.bootstrap import record_weights, refit_exceedance
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.intervals import normal_quantile
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.cloud import fit_cloud
from skewbridge.fragility.methods.ida import brackets_of_runs, fit_brackets, fit_capacities
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.methods.system import JointDemand, lognormal_of_system, series_system
from skewbridge.fragility.methods.tobit import censored_cloud, fit_tobit
from skewbridge.fragility.tables.limit_states import COLLAPSE_EXCEEDS, LimitState
from skewbridge.fragility.tables.system_curves import system_curves

TRUTH: Final = (1.0, 0.4)
_BOOTSTRAP: Final = 399

SIMULATIONS: Final = 2000
FEWER_SIMULATIONS: Final = 500
# of the default design: motions over these intensities (g), once each
_DESIGN: Final = (0.2, 3.0)
#: Largest demand so far of a run that collapses, as a share of what it would have been.
_PEAK_SHARE: Final = 0.7
_MEDIANS: Final = np.array([1.0, 1.2, 1.3])
_SPREADS: Final = np.array([0.35, 0.40, 0.45])
_CORRELATION: Final = 0.6
SEED: Final = 20240501

type Interval = tuple[float, float]
type Ends = tuple[Interval, Interval]
type Simulation = Callable[[np.random.Generator], Ends | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Coverage:
    """Share of simulations whose interval holds the truth.

    Attributes:
        design: Name of the sampling plan.
        theta: Share for theta.
        beta: Share for beta.
        usable: Share of simulations that had an estimate; the shares refer to them.
        simulations: Number of simulations.
    """

    design: str
    theta: float
    beta: float
    usable: float
    simulations: int


def _stripes(levels: int, runs: int, low: float, high: float, *, wald: bool = False) -> Simulation:
    im = np.exp(np.linspace(np.log(low), np.log(high), levels))
    n = np.full(levels, float(runs))
    p = special.ndtr(np.log(im / TRUTH[0]) / TRUTH[1])

    def simulate(rng: np.random.Generator) -> Ends | None:
        return _ends(fit_stripes(im, n, rng.binomial(runs, p).astype(float)), wald=wald)

    return simulate


def _same_records(runs: int, kind: str) -> Simulation:
    """Every motion runs on all eight stripes: its capacity decides all of them."""
    im = np.exp(np.linspace(np.log(0.4), np.log(2.5), 8))

    def simulate(rng: np.random.Generator) -> Ends | None:
        capacity = TRUTH[0] * np.exp(TRUTH[1] * rng.normal(size=runs))
        hit = (im[None, :] >= capacity[:, None]).astype(float)
        if kind == "interval":
            record = np.repeat(np.arange(runs), im.size)
            lower, upper, _ = brackets_of_runs(np.tile(im, runs), hit.ravel(), record)
            return _ends(fit_brackets(lower, upper))
        n, k = np.full(im.size, float(runs)), np.sum(hit, axis=0)
        fit = fit_stripes(im, n, k, interval=kind == "binomial")
        if kind == "binomial" or fit.status != FITTED:
            return _ends(fit)
        weights = record_weights(np.arange(runs), _BOOTSTRAP, rng)
        start = np.array([fit.predictor.a0, fit.predictor.a1])
        draws = weights @ hit
        again = refit_exceedance(np.log(im), np.broadcast_to(n, draws.shape), draws, start)
        return again.intervals(0.95)

    return simulate


def _capacities(runs: int, censored: float) -> Simulation:
    limit = TRUTH[0] * np.exp(TRUTH[1] * special.ndtri(1.0 - censored)) if censored else np.inf

    def simulate(rng: np.random.Generator) -> Ends | None:
        capacity = TRUTH[0] * np.exp(TRUTH[1] * rng.normal(size=runs))
        beyond = capacity > limit
        return _ends(fit_capacities(np.minimum(capacity, limit), beyond.astype(float)))

    return simulate


def _cloud(runs: int, *, tobit: bool = False) -> Simulation:
    def simulate(rng: np.random.Generator) -> Ends | None:
        im = np.exp(rng.uniform(np.log(0.1), np.log(1.5), runs))
        edp = im * np.exp(TRUTH[1] * rng.normal(size=runs))
        if tobit:
            x, demand, upper = censored_cloud(im, edp, above=TRUTH[0])
            return _ends(fit_tobit(x, demand, TRUTH[0], upper))
        return _ends(fit_cloud(im, edp, TRUTH[0]))

    return simulate


def _designed(motions: int, rng: np.random.Generator) -> FloatArray:
    """Return one intensity per motion, drawn within equal steps of its logarithm."""
    low, high = np.log(_DESIGN)
    return np.exp(low + (high - low) * (np.arange(motions) + rng.uniform(size=motions)) / motions)


def _collapse_demand(share: float, spread: float) -> float:
    """Return the demand above which a share of the runs of the design collapses."""
    rng = np.random.default_rng(0)
    demand = _designed(200_000, rng) * np.exp(spread * rng.normal(size=200_000))
    return float(np.quantile(demand, 1.0 - share)) if share else np.inf


def _collapsing_cloud(motions: int, share: float) -> Simulation:
    """Runs beyond a demand collapse: their demands are known only to exceed the threshold."""
    limit = _collapse_demand(share, TRUTH[1])

    def simulate(rng: np.random.Generator) -> Ends | None:
        im = _designed(motions, rng)
        edp = im * np.exp(TRUTH[1] * rng.normal(size=motions))
        fallen = edp > limit
        if not np.any(fallen):
            return _ends(fit_cloud(im, edp, TRUTH[0]))
        lower = np.where(fallen, np.maximum(_PEAK_SHARE * edp, TRUTH[0]), edp)
        return _ends(fit_tobit(im, lower, TRUTH[0], np.where(fallen, np.inf, lower)))

    return simulate


def _system(motions: int, share: float) -> Simulation:
    """Three correlated components; the first decides the collapse, the others left a peak."""
    limit = _collapse_demand(share, float(_SPREADS[0])) * float(_MEDIANS[0])
    root = np.linalg.cholesky(_CORRELATION * np.ones((3, 3)) + (1.0 - _CORRELATION) * np.eye(3))
    states = [
        LimitState(
            component=f"c{i}",
            name="slight",
            demand=f"d{i}_m",
            threshold=float(median),
            dispersion=0.0,
            collapse="peak" if i else COLLAPSE_EXCEEDS,
        )
        for i, median in enumerate(_MEDIANS)
    ]

    def simulate(rng: np.random.Generator) -> Ends | None:
        im = _designed(motions, rng)
        demand = im[:, None] * np.exp(rng.normal(size=(motions, 3)) @ root.T * _SPREADS)
        fallen = demand[:, 0] > limit
        demand[fallen] *= _PEAK_SHARE
        table = pd.DataFrame(
            {
                "variant": "v",
                "bridge": "b",
                "abutment": "a",
                "motion_id": [f"m{i:02d}" for i in range(motions)],
                "scale": 1.0,
                "incidence_deg": 0.0,
                "status": np.where(fallen, "collapse", "ok"),
                "im_pga_g": im,
                **{f"d{i}_m": demand[:, i] for i in range(3)},
            }
        )
        row = system_curves(table, states, "im_pga_g").iloc[0]
        if row["status"] != FITTED:
            return None
        theta, beta = ((row[f"{name}_low"], row[f"{name}_high"]) for name in ("theta", "beta"))
        return theta, beta

    return simulate


def _system_truth() -> Interval:
    correlation = _CORRELATION * np.ones((3, 3)) + (1.0 - _CORRELATION) * np.eye(3)
    joint = JointDemand(theta=_MEDIANS, beta=_SPREADS, correlation=correlation)
    grid = np.geomspace(0.1, 5.0, 201)
    return lognormal_of_system(grid, series_system(grid, joint))[:2]


SAMPLING_PLANS: Final[dict[str, Simulation]] = {
    "stripes 8 x 10": _stripes(8, 10, 0.4, 2.5),
    "stripes 8 x 20": _stripes(8, 20, 0.4, 2.5),
    "stripes 8 x 20, Wald": _stripes(8, 20, 0.4, 2.5, wald=True),
    "stripes 8 x 40": _stripes(8, 40, 0.4, 2.5),
    "stripes 8 x 40, p up to 0.43": _stripes(8, 40, 0.2, 0.93),
    "stripes 4 x 15": _stripes(4, 15, 0.5, 2.0),
    "single runs, 40 levels": _stripes(40, 1, 0.2, 5.0),
    "same records 8 x 20, binomial profile": _same_records(20, "binomial"),
    "same records 8 x 20, record bootstrap": _same_records(20, "bootstrap"),
    "same records 8 x 20, interval-censored": _same_records(20, "interval"),
    "capacities 20": _capacities(20, 0.0),
    "capacities 20, 30 % censored": _capacities(20, 0.3),
    "capacities 40, 30 % censored": _capacities(40, 0.3),
    "cloud 30, Fieller": _cloud(30),
    "cloud 100, Fieller": _cloud(100),
    "cloud 60, Tobit": _cloud(60, tobit=True),
    **{
        f"design of {motions}, {100 * share:g} % collapse": _collapsing_cloud(motions, share)
        for motions in (16, 32)
        for share in (0.0, 0.05, 0.20)
    },
    **{
        f"system of {motions}, {100 * share:g} % collapse": _system(motions, share)
        for motions in (16, 32)
        for share in (0.0, 0.05, 0.20)
    },
}


def measure_coverage(plan: str, simulations: int, seed: int) -> Coverage:
    """Simulate one sampling plan and count how often its 95 % intervals hold the truth.

    Args:
        plan: A name of `SAMPLING_PLANS`.
        simulations: Number of simulations; the standard error is sqrt(0.95 0.05/simulations).
        seed: Of the simulations.
    """
    rng = np.random.default_rng(seed)
    simulate = SAMPLING_PLANS[plan]
    truths = _system_truth() if plan.startswith("system") else TRUTH
    found = [simulate(rng) for _ in range(simulations)]
    usable = [ends for ends in found if ends is not None]
    hits = np.array(
        [
            [low <= truth <= high for (low, high), truth in zip(ends, truths, strict=True)]
            for ends in usable
        ]
    )
    return Coverage(
        design=plan,
        theta=float(np.mean(hits[:, 0])),
        beta=float(np.mean(hits[:, 1])),
        usable=len(usable) / simulations,
        simulations=simulations,
    )


def _ends(fit: FragilityFit, *, wald: bool = False) -> Ends | None:
    if fit.status != FITTED:
        return None
    return wald_intervals(fit, fit.level) if wald else (fit.ci_theta, fit.ci_beta)


def wald_intervals(
    fit: FragilityFit, level: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return Wald intervals of theta and beta, symmetric in ln theta and ln beta.

    A fast fallback of the profile: coverage 92 to 95 % where the profile has 93.5 to 95.5 %.
    """
    z = normal_quantile(level)
    theta = float(np.exp(z * fit.se_ln_theta))
    beta = float(np.exp(z * fit.se_beta / fit.beta))
    return (fit.theta / theta, fit.theta * theta), (fit.beta / beta, fit.beta * beta)


def simulations_of(plan: str) -> int:
    """Return how many simulations of a plan are stored."""
    return FEWER_SIMULATIONS if plan.startswith(("system", "design")) else SIMULATIONS


def main() -> None:
    """Run the plans named as arguments, all without, and store them beside the others."""
    out = Path(__file__).with_suffix(".json")
    rows = {row["design"]: row for row in json.loads(out.read_text(encoding="utf-8"))["rows"]}
    for plan in sys.argv[1:] or SAMPLING_PLANS:
        begin = time.process_time()
        row = asdict(measure_coverage(plan, simulations_of(plan), SEED))
        rows[plan] = row
        seconds = time.process_time() - begin
        sys.stderr.write(
            f"{plan:45s} theta {row['theta']:.4f} beta {row['beta']:.4f}"
            f" usable {row['usable']:.3f} {seconds:.0f} s\n"
        )
    ordered = [rows[plan] for plan in SAMPLING_PLANS if plan in rows]
    study = {"seed": SEED, "nominal": 0.95, "rows": ordered}
    out.write_text(json.dumps(study, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
