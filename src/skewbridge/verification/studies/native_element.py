"""Cross-check with the contact element of OpenSees, `zeroLengthContactASDimplex`.

It iterates friction within the step, for a constant coefficient and without cohesion; its gap is
the distance of its nodes. Where it converges it is an independent solution of the same equations.

References:
    Akan, Petracca, Camata, Spacone and Lai (2020), the authors of the element.
"""

from math import pi
from typing import Final, NamedTuple

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.contact import ContactLaw
from skewbridge.verification.references import deck_solvers as solvers
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.live_model import Array, clean_domain
from skewbridge.verification.registry import Study

IMPLICIT: Final = 0
IMPLEX: Final = 1
_NAMES: Final = {IMPLICIT: "implicit", IMPLEX: "IMPL-EX"}
_LAW: Final = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3)
# The friction of the native element is of first order in the step and still 1.6 to 8 % off for C2
# at 2e-5 s; so the frictional case judged is C5, at the smaller step.
_JUDGED: Final = (("C1", 1e-4), ("C3", 1e-4), ("C5", 2e-5))
_DECK_RUNS: Final = (
    ("C1", IMPLICIT, 1e-4),
    ("C1", IMPLEX, 1e-4),
    ("C3", IMPLICIT, 1e-4),
    ("C2", IMPLICIT, 5e-3),
    ("C2", IMPLICIT, 1e-4),
    ("C5", IMPLICIT, 1e-4),
    ("C5", IMPLICIT, 2e-5),
    ("C5", IMPLEX, 1e-4),
)
_SOURCE: Final = "zeroLengthContactASDimplex"


class NativeDeck(NamedTuple):
    """Response of the deck with native contacts up to the last step that converged."""

    t_s: Array
    q: Array


def run(study: Study) -> None:
    """Run the study."""
    paths = [_compare_paths(study, integration) for integration in _NAMES]
    decks = [row for deck_run in _DECK_RUNS for row in _compare_decks(study, *deck_run)]
    study.tables["paths"] = pd.DataFrame(paths)
    study.tables["decks"] = pd.DataFrame(decks)


def curved_path(rows_per_period: int = 1000) -> Array:
    """Return a smooth path in space that opens and closes."""
    t = np.linspace(0.0, 2.0, 2 * rows_per_period + 1)
    x, y = 0.5 * np.sin(2.0 * pi * t), 0.4 * np.sin(4.0 * pi * t + 0.7) - 0.4 * np.sin(0.7)
    return np.column_stack([t, x, y, 0.03 - 0.08 * np.sin(pi * t + 0.4)])


def drive_native(law: ContactLaw, path: Array, integration: int, substeps: int = 1) -> Array:
    """Drive the native element along a path; return forces like those of `drive_unit`."""
    forces = np.zeros((len(path), 3))
    with clean_domain():
        ops.model("basic", "-ndm", 3, "-ndf", 3)
        for node in (1, 2, 3, 4):
            ops.node(node, 0.0, 0.0, law.gap_m if node == 2 else 0.0)
        for node, fixed in ((1, (1, 1, 1)), (3, (1, 1, 1)), (4, (0, 1, 1))):
            ops.fix(node, *fixed)
        ops.uniaxialMaterial("Elastic", 1, 1.0)
        ops.element("zeroLength", 1, 3, 4, "-mat", 1, "-dir", 1)
        _native_contact(2, (1, 2), law, (0.0, 0.0, 1.0), integration)
        unit.drive_node(2, path, system="FullGeneral")
        ops.analyze(1)
        ops.integrator("LoadControl", 1.0 / substeps)
        for row in range(1, len(path)):
            ops.analyze(substeps)
            fx, fy, fz = ops.eleForce(2)[3:6]
            forces[row] = (fx, fy, -fz)
    return forces


def _native_contact(
    tag: int,
    nodes: tuple[int, int],
    law: ContactLaw,
    normal: tuple[float, float, float],
    integration: int,
) -> None:
    """Define a native contact element between two nodes."""
    stiffness = (law.kn_n_per_m, law.kt_n_per_m, law.friction)
    orientation = ("-orient", *normal, "-intType", integration)
    ops.element("zeroLengthContactASDimplex", tag, *nodes, *stiffness, *orientation)


def _compare_paths(study: Study, integration: int) -> dict[str, float | str]:
    path = curved_path()
    ours = unit.drive_unit(_LAW, path, substeps=10).forces_n
    native = drive_native(_LAW, path, integration, substeps=10)
    limit = _LAW.friction * float(ours[:, 2].max())
    error = unit.rms_n((ours - native)[:, :2]) / limit
    if integration == IMPLICIT:
        study.at_most("driven path: RMS difference over the limit", error, 0.01, _SOURCE)
        work, exact = unit.path_work_j(path, ours), unit.path_work_j(path, native)
        study.relative("driven path: work (J)", work, exact, 2e-3, _SOURCE)
    else:
        study.report("driven path, IMPL-EX: RMS difference over the limit", error, 0.0, _SOURCE)
    return {"integration": _NAMES[integration], "rms_difference_ratio": error}


def run_native_deck(name: str, integration: int, dt_s: float = 1e-4) -> NativeDeck:
    """Run an elastic deck case with native contacts until a step does not converge."""
    case = deck_case(name, dt_s=dt_s)
    deck = solvers.make_deck(case)
    kn, kt = case.normal_stiffness_n_per_m, case.kt_n_per_m
    law = ContactLaw(kn_n_per_m=kn, kt_n_per_m=kt, friction=case.friction)
    with clean_domain():
        solvers.build_deck(deck, wall_offset_m=case.gap_normal_m)
        solvers.rigid_links(case)
        nodes = zip(solvers.WALL_NODES, solvers.CORNER_NODES, strict=True)
        for k, pair in enumerate(nodes):
            nx, ny = deck.normal_rows[k, :2].tolist()
            _native_contact(100 + k, pair, law, (nx, ny, 0.0), integration)
        times, _ = solvers.excite_deck(case, solvers.pulse_of(case), system="FullGeneral")
        q = np.zeros((len(times), 3))
        for k in range(1, len(times)):
            if ops.analyze(1, case.dt_s) != 0:
                return NativeDeck(times[:k], q[:k])
            q[k] = ops.nodeDisp(solvers.CENTRE)
    return NativeDeck(times, q)


def _compare_decks(
    study: Study, name: str, integration: int, dt_s: float
) -> list[dict[str, float | str]]:
    case = deck_case(name)
    found, native = solvers.run_deck(case).peaks(), run_native_deck(name, integration, dt_s)
    reached_s, text = float(native.t_s[-1]), f"{name}, {_NAMES[integration]}, dt {dt_s:g} s"
    finished = reached_s >= case.duration_s - case.dt_s
    if not finished:
        study.report(f"{text}: stops converging at (s)", reached_s, case.duration_s, _SOURCE)
    is_judged = finished and integration == IMPLICIT and (name, dt_s) in _JUDGED
    rows: list[dict[str, float | str]] = []
    for key, peak, tolerance in zip(
        ("ux_m", "uy_m", "theta_rad"), np.abs(native.q).max(axis=0), (0.01, 0.01, 0.02), strict=True
    ):
        limit = tolerance if is_judged else None
        study.relative(f"{text}: peak {key}", found[key], peak, limit, _SOURCE)
        run = {"case": name, "integration": _NAMES[integration], "dt_s": dt_s, "quantity": key}
        values = {"ours": found[key], "native": float(peak), "time_reached_s": reached_s}
        rows.append(run | values)
    return rows
