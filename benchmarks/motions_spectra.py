"""Time of response spectra compared with pyRotd (RotD50 of a pair) and eqsig (one component).

One run measures all programs on the same record (a pair of 16,400 points at 0.005 s, 111 periods
from 0.01 to 20 s, 5 % damping), with the shortest time of several repeats. Prints one JSON object.
The other programs are installed in a separate environment from requirements-motions.txt.
"""

import eqsig
import numpy as np
import pyrotd
from common import best_of, show

from skewbridge.motions.intensity import component_psa, pair_psa

NPTS, DT_S = 16_400, 0.005
PERIODS_S = np.geomspace(0.01, 20.0, 111)
REPEATS = 5


def record() -> tuple[np.ndarray, np.ndarray]:
    """Return two components in m/s2 of filtered noise under an envelope."""
    rng = np.random.default_rng(8883)
    time_s = np.arange(NPTS) * DT_S
    envelope = (time_s / 12.0) ** 2 * np.exp(-(time_s - 12.0) / 6.0)
    kernel = np.exp(-np.arange(400) * DT_S * 4.0) * np.sin(np.arange(400) * DT_S * 20.0)
    noise = rng.standard_normal((2, NPTS))
    pair = [envelope * np.convolve(row, kernel)[:NPTS] for row in noise]
    return pair[0] / np.abs(pair[0]).max() * 3.0, pair[1] / np.abs(pair[1]).max() * 2.0


def compared() -> dict[str, float | str]:
    """Return the times (s) of all programs and the largest difference of RotD50 from pyRotd."""
    one, two = record()

    def rotated() -> np.ndarray:
        return pyrotd.calc_rotated_spec_accels(
            DT_S, one, two, 1.0 / PERIODS_S, 0.05, percentiles=[50]
        ).spec_accel

    ours_s = best_of(lambda: pair_psa(one, two, DT_S, PERIODS_S), REPEATS)
    ours_component_s = best_of(lambda: component_psa(one, DT_S, PERIODS_S), REPEATS)
    pool_s = best_of(rotated, REPEATS)
    pyrotd.processes = 1
    single_s = best_of(rotated, REPEATS)
    eqsig_s = best_of(
        lambda: eqsig.sdof.pseudo_response_spectra(one, DT_S, PERIODS_S, 0.05), REPEATS
    )

    long = PERIODS_S >= 10 * DT_S
    mine = pair_psa(one, two, DT_S, PERIODS_S).rotd50_mps2
    difference = np.abs(rotated() / mine - 1.0)[long & (PERIODS_S < 5.0)].max()
    return {
        "benchmark": "motions_spectra",
        "npts": NPTS,
        "periods": int(PERIODS_S.size),
        "rotd50_s": ours_s,
        "rotd50_pyrotd_all_cores_s": pool_s,
        "rotd50_pyrotd_one_process_s": single_s,
        "rotd50_times_faster_than_pyrotd": min(pool_s, single_s) / ours_s,
        "component_s": ours_component_s,
        "component_eqsig_s": eqsig_s,
        "component_times_faster_than_eqsig": eqsig_s / ours_component_s,
        "largest_difference_to_pyrotd_0p05_to_5_s": float(difference),
    }


if __name__ == "__main__":
    show(compared())
