"""Our contact unit compared with the native element of OpenSees, on the same rigid skew deck.

Processor time of whole runs with ``zeroLengthContactASDimplex`` over that with parameter updates,
taken in turn, with the same step and algorithm, and the difference of the peaks. The native element
(Akan, Petracca, Camata, Spacone and Lai 2020) iterates friction within the step, with a constant
coefficient and without cohesion; its gap is the distance between its nodes. It needs an unsymmetric
solver, which costs nothing for three equations. Prints one JSON object:
    python benchmarks/native.py [--repeats 3]
"""

import sys
from typing import Any

import numpy as np
import openseespy.opensees as ops
from common import cpu_s, interleaved, options, ratio, show

from skewbridge.contact import ContactLaw
from skewbridge.files.tables import Floats
from skewbridge.verification.references import deck_solvers as solvers
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import pulse_of, run_deck
from skewbridge.verification.references.live_model import clean_domain

DT_S = 1.0e-4
IMPLICIT = 0


def native_contact(
    tag: int, nodes: tuple[int, int], law: ContactLaw, normal: tuple[float, ...], integration: int
) -> None:
    """Create a contact with the native element."""
    stiffness = (law.kn_n_per_m, law.kt_n_per_m, law.friction)
    orientation = ("-orient", *normal, "-intType", integration)
    ops.element("zeroLengthContactASDimplex", tag, *nodes, *stiffness, *orientation)


def run_native_deck(name: str, integration: int, dt_s: float = 1e-4) -> tuple[Floats, Floats]:
    """Run an elastic deck case with native contacts until a step does not converge.

    Returns the times and (ux, uy, theta), shape (n, 3).
    """
    case = deck_case(name, dt_s=dt_s)
    deck, kn = solvers.make_deck(case), case.normal_stiffness_n_per_m
    law = ContactLaw(kn_n_per_m=kn, kt_n_per_m=case.kt_n_per_m, friction=case.friction)
    with clean_domain(2, 3):
        solvers.build_deck(deck, wall_offset_m=case.gap_normal_m)
        solvers.rigid_links(case)
        pairs = zip(solvers.WALL_NODES, solvers.CORNER_NODES, deck.normal_rows, strict=True)
        for tag, (wall, corner, (nx, ny, _)) in enumerate(pairs, start=100):
            native_contact(tag, (wall, corner), law, (float(nx), float(ny), 0.0), integration)
        times, _ = solvers.excite_deck(case, pulse_of(case), system="FullGeneral")
        q = [[0.0, 0.0, 0.0]]
        while len(q) < len(times) and ops.analyze(1, case.dt_s) == 0:
            q.append(ops.nodeDisp(solvers.CENTRE))
    return times[: len(q)], np.array(q)


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
