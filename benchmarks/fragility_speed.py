"""Time the fits against pyFragility and statsmodels in one run; prints one JSON object.

The other programs come from requirements-fragility.txt, in an environment of their own. With the
argument `table` only the fit of 10^6 demand rows is measured (its memory is that of the process).
"""

import json
import resource
import sys
import time
import warnings
from collections.abc import Callable

import numpy as np
import pandas as pd

from skewbridge.fragility.old_likelihood.bootstrap import (
    parametric_counts,
    record_weights,
    refit_exceedance,
)
from skewbridge.fragility.methods.cloud import fit_cloud
from skewbridge.fragility.methods.ida import fit_capacities
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.limit_states import LimitState

# own data: 8 stripes of 40 runs
IM = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3])
N = np.full(8, 40.0)
K = np.array([0, 0, 1, 5, 23, 30, 34, 40.0])
REFITS = 100_000
VARIANTS, RUNS = 500, 2000
THRESHOLDS = (0.004, 0.007, 0.01, 0.015, 0.025, 0.04, 0.06, 0.1)


def best_of(action: Callable[[], object], repeats: int = 5) -> float:
    """Return the shortest of several times in s."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def compare() -> dict[str, float]:
    """Measure single fits and refits of all programs on the same data."""
    import pyFragility
    import statsmodels.api as sm

    design = sm.add_constant(np.log(IM))
    table = np.column_stack([K, N - K])
    family = sm.families.Binomial(link=sm.families.links.Probit())
    theirs = pyFragility.fit_msa(IM, K, N)

    def theirs_with_profiles() -> None:
        fit = pyFragility.fit_msa(IM, K, N)
        for name in fit.param_names:
            fit.profile_interval(name)

    ours = fit_stripes(IM, N, K)
    start = np.array([ours.predictor.a0, ours.predictor.a1])
    p = fit_p(start)

    def our_refits() -> None:
        counts = parametric_counts(p, N, REFITS, np.random.default_rng(0))
        refit_exceedance(np.log(IM), np.broadcast_to(N, counts.shape), counts, start)

    def statsmodels_refits() -> None:
        rng = np.random.default_rng(0)
        for counts in parametric_counts(p, N, 100, rng):
            sm.GLM(np.column_stack([counts, N - counts]), design, family=family).fit()

    runs_im = np.repeat(IM, 40)
    runs_hit = np.concatenate([np.arange(40) < k for k in K]).astype(float)
    record = np.tile(np.arange(40), 8)

    def our_record_bootstrap() -> None:
        weights = record_weights(record, 1000, np.random.default_rng(0))
        refit_exceedance(np.log(runs_im), weights, weights * runs_hit, start)

    clustered = pyFragility.fit_msa(runs_im, runs_hit, np.ones(320), cluster=record)
    rng = np.random.default_rng(1)
    x = np.exp(rng.uniform(-2, 0.5, 320))
    y = 0.03 * x * np.exp(0.4 * rng.normal(size=320))
    capacity = np.exp(0.4 * rng.normal(size=40))
    stop = (capacity > 1.4).astype(float)
    capacity = np.minimum(capacity, 1.4)
    return {
        "fit_and_profiles_ours_ms": 1e3 * best_of(lambda: fit_stripes(IM, N, K), 20),
        "fit_and_profiles_pyfragility_ms": 1e3 * best_of(theirs_with_profiles),
        "fit_ours_ms": 1e3 * best_of(lambda: fit_stripes(IM, N, K, interval=False), 20),
        "fit_pyfragility_ms": 1e3 * best_of(lambda: pyFragility.fit_msa(IM, K, N)),
        "fit_statsmodels_ms": 1e3 * best_of(lambda: sm.GLM(table, design, family=family).fit()),
        "refit_ours_us": 1e6 * best_of(our_refits, 3) / REFITS,
        "refit_pyfragility_us": 1e3
        * best_of(lambda: theirs.bootstrap(n_boot=1000, resample="parametric"), 2),
        "refit_statsmodels_us": 1e4 * best_of(statsmodels_refits, 2),
        "record_bootstrap_1000_ours_s": best_of(our_record_bootstrap, 3),
        "record_bootstrap_1000_pyfragility_s": best_of(
            lambda: clustered.bootstrap(n_boot=1000, resample="nonparametric"), 1
        ),
        "cloud_320_ours_ms": 1e3 * best_of(lambda: fit_cloud(x, y, 0.02), 20),
        "cloud_320_pyfragility_ms": 1e3 * best_of(lambda: pyFragility.fit_cloud(x, y, 0.02)),
        "ida_40_with_profiles_ours_ms": 1e3 * best_of(lambda: fit_capacities(capacity, stop), 20),
        "ida_40_pyfragility_ms": 1e3 * best_of(lambda: pyFragility.fit_ida(capacity, stop > 0)),
    }


def fit_p(params: np.ndarray) -> np.ndarray:
    """Return the fitted probabilities of the stripes."""
    from skewbridge.fragility.old_likelihood.links import probability

    return probability(params[0] + params[1] * np.log(IM))


def large_table() -> dict[str, float]:
    """Fit 500 variants x 8 limit states, 2000 runs each, by cloud and by exceedance."""
    rng = np.random.default_rng(2)
    rows = VARIANTS * RUNS
    im = np.tile(np.exp(rng.uniform(np.log(0.1), np.log(1.5), RUNS)), VARIANTS)
    number = np.repeat(np.arange(VARIANTS), RUNS)
    demands = pd.DataFrame(
        {
            "variant": pd.Categorical.from_codes(number, [f"v{i:03d}" for i in range(VARIANTS)]),
            "bridge": "osb1",
            "abutment": "contact_friction",
            "skew_deg": number % 61,
            "gap_mm": 51,
            "friction": 0.5,
            "motion_id": np.tile([f"m{i:04d}" for i in range(RUNS)], VARIANTS),
            "scale": 1.0,
            "incidence_deg": 0.0,
            "status": "ok",
            "im_saavg_rotd50_g": im,
            "column_drift_ratio": 0.03 * im * np.exp(0.4 * rng.normal(size=rows)),
        }
    )
    states = [
        LimitState(
            component="column_drift",
            name=f"level_{number}",
            demand="column_drift_ratio",
            threshold=threshold,
            dispersion=0.35,
            unit="ratio",
            collapse="exceeds",
            citation="benchmark",
        )
        for number, threshold in enumerate(THRESHOLDS)
    ]
    start = time.perf_counter()
    curves = fit_study(demands, states, "im_saavg_rotd50_g")
    return {
        "table_rows": rows,
        "table_fits": len(curves),
        "table_ok": int((curves["status"] == "ok").sum()),
        "table_s": time.perf_counter() - start,
        "table_peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    """Measure and print."""
    if sys.argv[1:] == ["table"]:
        found = large_table()
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = compare()
        found["profiles_ratio"] = (
            found["fit_and_profiles_pyfragility_ms"] / found["fit_and_profiles_ours_ms"]
        )
        found["refit_ratio"] = found["refit_pyfragility_us"] / found["refit_ours_us"]
    json.dump(found, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
