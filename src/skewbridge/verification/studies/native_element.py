"""Cross-check with the contact element of OpenSees, `zeroLengthContactASDimplex`.

It iterates friction within the step, for a constant coefficient and without cohesion; its gap is
the distance of its nodes. Where it converges it is an independent solution of the same equations.

References:
    Akan, Petracca, Camata, Spacone and Lai (2020), the authors of the element.
"""

from dataclasses import dataclass
from math import pi
from typing import Final

import numpy as np
import openseespy.opensees as ops
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.contact import ContactLaw
from skewbridge.verification.references.cases import C1, C2, C3, C5, NamedCase, deck_case
from skewbridge.verification.references.deck_solvers import (
    CENTRE,
    CORNER_NODES,
    WALL_NODES,
    build_deck,
    excite_deck,
    make_deck,
    prepare_analysis,
    pulse_of,
    rigid_links,
    run_deck,
)
from skewbridge.verification.references.driven_unit import (
    drive_node,
    drive_unit,
    path_work_j,
    rms_n,
)
from skewbridge.verification.references.live_model import Array, clean_domain
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

IMPLICIT: Final = 0
IMPLEX: Final = 1
_NAMES: Final = {IMPLICIT: "implicit", IMPLEX: "IMPL-EX"}
_LAW: Final = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3)
# The friction of the native element is of first order in the step and still 1.6 to 8 % off for C2
# at 2e-5 s; so the frictional case judged is C5, at the smaller step.
_JUDGED: Final = (("C1", 1e-4), ("C3", 1e-4), ("C5", 2e-5))
_DECK_RUNS: Final = (
    (C1, IMPLICIT, 1e-4),
    (C1, IMPLEX, 1e-4),
    (C3, IMPLICIT, 1e-4),
    (C2, IMPLICIT, 5e-3),
    (C2, IMPLICIT, 1e-4),
    (C5, IMPLICIT, 1e-4),
    (C5, IMPLICIT, 2e-5),
    (C5, IMPLEX, 1e-4),
)
_SOURCE: Final = "zeroLengthContactASDimplex"


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeDeck:
    """Response of the deck with native contacts up to the last step that converged."""

    t_s: Array
    q: Array

    @property
    def time_reached_s(self) -> float:
        """Time of the last step that converged."""
        return float(self.t_s[-1])


def run(study: Study) -> None:
    """Run the study."""
    paths = [_compare_paths(study, integration) for integration in _NAMES]
    decks = [row for deck_run in _DECK_RUNS for row in _compare_decks(study, *deck_run)]
    study.tables["paths"] = pd.DataFrame(paths)
    study.tables["decks"] = pd.DataFrame(decks)
    study.figures["decks"] = _figure()


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
        drive_node(2, path, system="FullGeneral")
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
    ours = drive_unit(_LAW, path, substeps=10).forces_n
    native = drive_native(_LAW, path, integration, substeps=10)
    limit = _LAW.friction * float(ours[:, 2].max())
    error = rms_n((ours - native)[:, :2]) / limit
    if integration == IMPLICIT:
        study.at_most("driven path: RMS difference over the limit", error, 0.01, _SOURCE)
        work, exact = path_work_j(path, ours), path_work_j(path, native)
        study.relative("driven path: work (J)", work, exact, 2e-3, _SOURCE)
    else:
        study.report("driven path, IMPL-EX: RMS difference over the limit", error, 0.0, _SOURCE)
    return {"integration": _NAMES[integration], "rms_difference_ratio": error}


def run_native_deck(named: NamedCase, integration: int, dt_s: float = 1e-4) -> NativeDeck:
    """Run an elastic deck case with native contacts until a step does not converge."""
    case = deck_case(named, dt_s=dt_s)
    deck = make_deck(case)
    kn, kt = case.normal_stiffness_n_per_m, case.kt_n_per_m
    law = ContactLaw(kn_n_per_m=kn, kt_n_per_m=kt, friction=case.friction)
    with clean_domain():
        build_deck(deck, wall_offset_m=case.gap_normal_m)
        rigid_links(case)
        for k, nodes in enumerate(zip(WALL_NODES, CORNER_NODES, strict=True)):
            nx, ny = deck.normal_rows[k, :2].tolist()
            _native_contact(100 + k, nodes, law, (nx, ny, 0.0), integration)
        times, _ = excite_deck(case, pulse_of(case))
        prepare_analysis(case.integrator, system="FullGeneral")
        q = np.zeros((len(times), 3))
        for k in range(1, len(times)):
            if ops.analyze(1, case.dt_s) != 0:
                return NativeDeck(t_s=times[:k], q=q[:k])
            q[k] = ops.nodeDisp(CENTRE)
    return NativeDeck(t_s=times, q=q)


def _compare_decks(
    study: Study, named: NamedCase, integration: int, dt_s: float
) -> list[dict[str, float | str]]:
    case = deck_case(named)
    ours, native = run_deck(case), run_native_deck(named, integration, dt_s)
    name = _NAMES[integration]
    finished = native.time_reached_s >= case.duration_s - case.dt_s
    if not finished:
        text = f"{named.name}, {name}, dt {dt_s:g} s: stops converging at (s)"
        study.report(text, native.time_reached_s, case.duration_s, _SOURCE)
    found, peaks = ours.peaks(), np.abs(native.q).max(axis=0)
    is_judged = finished and integration == IMPLICIT and (named.name, dt_s) in _JUDGED
    run = {"case": named.name, "integration": name, "dt_s": dt_s}
    rows: list[dict[str, float | str]] = []
    for key, value, tolerance in zip(
        ("ux_m", "uy_m", "theta_rad"), peaks.tolist(), (0.01, 0.01, 0.02), strict=True
    ):
        text = f"{named.name}, {name}, dt {dt_s:g} s: peak {key}"
        study.relative(text, found[key], value, tolerance if is_judged else None, _SOURCE)
        row = {"quantity": key, "ours": found[key], "native": value}
        rows.append(run | row | {"time_reached_s": native.time_reached_s})
    return rows


def _figure() -> Figure:
    title = "case C5, elastic penalty"
    figure, axes = style.time_panels("uy (mm)", "theta (mrad)", height_in=4.2, title=title)
    ours, native = run_deck(deck_case(C5)), run_native_deck(C5, IMPLICIT, 2e-5)
    for column, axis in enumerate(axes, start=1):
        style.line(
            axis, native.t_s, 1e3 * native.q[:, column], style.BLUE, "native element", lw=2.2
        )
        style.line(axis, ours.t_s, 1e3 * ours.q[:, column], style.ORANGE, "parameter updates")
    style.legend_above(figure, axes[0])
    return figure
