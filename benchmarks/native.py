"""Our contact unit compared with the native element of OpenSees, on the same rigid skew deck.

Processor time of whole runs with ``zeroLengthContactASDimplex`` over that with parameter updates,
taken in turn, with the same step and algorithm, and the difference of the peaks. The native element
needs an unsymmetric solver, which costs nothing for three equations. Prints one JSON object:
    python benchmarks/native.py [--repeats 3]
"""

import sys
from typing import Any

import numpy as np
from common import cpu_s, interleaved, options, ratio, show

from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import run_deck
from skewbridge.verification.studies.spatial_path import IMPLICIT, run_native_deck

DT_S = 1.0e-4


def measure(name: str, repeats: int) -> dict[str, Any]:
    """Return the ratio of processor times of a case and the differences of its peaks (percent)."""
    case = deck_case(name, dt_s=DT_S)
    ours, (t_s, q) = run_deck(case), run_native_deck(name, IMPLICIT, DT_S)
    if t_s[-1] < case.duration_s - DT_S:
        sys.exit(f"the native element stops converging in {name}")
    works = {
        "native": lambda: cpu_s(lambda: run_native_deck(name, IMPLICIT, DT_S))[1],
        "ours": lambda: cpu_s(lambda: run_deck(case))[1],
    }
    seconds = interleaved(works, repeats)
    peaks = dict(zip(("ux_m", "uy_m", "theta_rad"), np.abs(q).max(axis=0), strict=True))
    found = ours.peaks()
    return {
        "friction": case.friction,
        "native_over_ours": ratio(seconds["native"], seconds["ours"]),
        "peaks_native_against_ours_percent": {
            name: 100.0 * (float(peak) / found[name] - 1.0) for name, peak in peaks.items()
        },
    }


if __name__ == "__main__":
    repeats = options(__doc__, repeats=3).repeats
    show({"dt_s": DT_S, "cases": {name: measure(name, repeats) for name in ("C3", "C5")}})
