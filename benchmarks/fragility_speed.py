"""Time the fits: prints one JSON object.

Without argument against pyFragility, which is installed in an environment of its own from
requirements-fragility.txt; `rows`: fits of 10^6 demand rows; `tables`: all tables of 24 variants
under 100 motions.
"""

import json
import resource
import sys
import time
from collections.abc import Callable

import numpy as np
import pandas as pd

from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.fits import fit_cloud, fit_stripes
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables

# own data: 8 stripes of 40 runs
IM = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3])
N = np.full(8, 40.0)
K = np.array([0, 0, 1, 5, 23, 30, 34, 40.0])
THRESHOLDS = (0.004, 0.007, 0.01, 0.015, 0.025, 0.04, 0.06, 0.1)
SETTINGS = FitSettings()


def best_of(action: Callable[[], object], repeats: int) -> float:
    """Return the shortest of several times in ms."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def single_fits() -> dict[str, float]:
    """Measure fits with both profile intervals of both programs on the same data."""
    import pyFragility

    def theirs() -> None:
        fit = pyFragility.fit_msa(IM, K, N)
        for name in fit.param_names:
            fit.profile_interval(name)

    rng = np.random.default_rng(1)
    x = np.exp(rng.uniform(-2, 0.5, 320))
    y = 0.03 * x * np.exp(0.4 * rng.normal(size=320))
    found = {
        "stripes_ours_ms": best_of(lambda: fit_stripes(IM, N, K), 20),
        "stripes_pyfragility_ms": best_of(theirs, 5),
        "cloud_ours_ms": best_of(lambda: fit_cloud(x, y, 0.02), 20),
        "cloud_pyfragility_ms": best_of(lambda: pyFragility.fit_cloud(x, y, 0.02), 20),
    }
    return found | {"ratio": found["stripes_pyfragility_ms"] / found["stripes_ours_ms"]}


def demands(variants: int, runs: int) -> tuple[pd.DataFrame, list[LimitState]]:
    """Return a synthetic demands table and eight states of column drift."""
    rng = np.random.default_rng(2)
    number = np.repeat(np.arange(variants), runs)
    im = np.tile(np.exp(rng.uniform(np.log(0.1), np.log(1.5), runs)), variants)
    table = pd.DataFrame(
        {
            "variant": pd.Categorical.from_codes(number, [f"v{i:04d}" for i in range(variants)]),
            "bridge": "osb1",
            "abutment": "contact_friction",
            "skew_deg": number % 6 * 12.0,
            "gap_mm": number // 6 % 2 * 26.0 + 25.0,
            "friction": number // 12 * 0.5,
            "motion_id": np.tile([f"m{i:04d}" for i in range(runs)], variants),
            "scale": 1.0,
            "incidence_deg": 0.0,
            "status": "ok",
            SETTINGS.im: im,
            "column_drift_ratio": 0.03 * im * np.exp(0.4 * rng.normal(size=number.size)),
        }
    )
    states = [
        LimitState(
            component="column_drift",
            name=f"level_{place}",
            demand="column_drift_ratio",
            threshold=threshold,
            dispersion=0.35,
        )
        for place, threshold in enumerate(THRESHOLDS)
    ]
    return table, states


def main() -> None:
    """Measure and print."""
    what = sys.argv[1] if sys.argv[1:] else "single"
    if what == "single":
        found = single_fits()
    else:
        table, states = demands(500, 2000) if what == "rows" else demands(24, 100)
        start = time.process_time()
        curves = (
            fit_study(table, states)
            if what == "rows"
            else fragility_tables(table, states, SETTINGS)["curves"]
        )
        found = {
            "rows": len(table),
            "ok": int((curves["status"] == "ok").sum()),
            "cpu_s": time.process_time() - start,
            "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        }
    sys.stdout.write(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
