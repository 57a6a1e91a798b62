"""Time of fits compared with pyFragility 0.2; prints one JSON object.

pyFragility is installed in a separate environment from requirements-fragility.txt. `tables.py`
measures whole tables of any number of rows.
"""

import numpy as np
from common import best_of, show

from skewbridge.fragility.fits import fit_cloud, fit_stripes

# made-up data: 8 stripes of 40 runs
IM = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3])
N = np.full(8, 40.0)
K = np.array([0, 0, 1, 5, 23, 30, 34, 40.0])


def single_fits() -> dict[str, float]:
    """Time the fits of both programs, with both profile intervals, on the same data."""
    import pyFragility

    def theirs() -> None:
        fit = pyFragility.fit_msa(IM, K, N)
        for name in fit.param_names:
            fit.profile_interval(name)

    rng = np.random.default_rng(1)
    x = np.exp(rng.uniform(-2, 0.5, 320))
    y = 0.03 * x * np.exp(0.4 * rng.normal(size=320))
    found = {
        "stripes_ours_ms": 1e3 * best_of(lambda: fit_stripes(IM, N, K), 20),
        "stripes_pyfragility_ms": 1e3 * best_of(theirs, 5),
        "cloud_ours_ms": 1e3 * best_of(lambda: fit_cloud(x, y, 0.02), 20),
        "cloud_pyfragility_ms": 1e3 * best_of(lambda: pyFragility.fit_cloud(x, y, 0.02), 20),
    }
    return found | {"ratio": found["stripes_pyfragility_ms"] / found["stripes_ours_ms"]}


if __name__ == "__main__":
    show(single_fits())
