"""The contact unit in space: figure 3, order of the couplings, native element of OpenSees.

`run` drives the unit by a square and two triangular waves. `run_orders` compares both couplings on
smooth paths and on a frictional deck, over a range of time steps. `run_native` compares paths and
decks with the contact element of OpenSees, `zeroLengthContactASDimplex` (Akan, Petracca, Camata,
Spacone and Lai 2020). This element iterates friction within the step, with a constant coefficient
and without cohesion; its gap is the distance between its nodes. If it converges, it is an
independent solution of the same equations.
"""

from itertools import product
from math import pi
from typing import Any, Final, Literal

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.contact import ContactLaw, Coupling, Scheme
from skewbridge.units import KN
from skewbridge.verification.references import deck_solvers as solvers
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import pulse_of, run_deck, run_opensees
from skewbridge.verification.references.driven_unit import PAPER_LAW
from skewbridge.verification.references.live_model import Array, clean_domain, rms
from skewbridge.verification.registry import Panel, Row, Study, drawn

LIMIT_N: Final = 4500.0
_ROWS_PER_S: Final = 2000
# source: radial return integrated with dt = 1e-5 s gave the forces and works in the table
_FORCES_AT_S: Final = (1.5, 2.0, 3.76, 4.4, 4.6, 4.9, 6.5, 7.4, 9.0, 9.2, 11.6)
_SCHEMES: Final[tuple[Scheme, ...]] = ("vector", "componentwise", "elastic")
_COUPLINGS: Final[tuple[Coupling, ...]] = ("extrapolated", "lagged")


def run(study: Study) -> None:
    """Run the study of figure 3."""
    # The square wave jumps within one row: short rows keep its timing.
    path = unit.figure_3(_ROWS_PER_S)
    forces = unit.drive_unit(PAPER_LAW, path, substeps=2).forces_n
    for time, (axis, name) in product(_FORCES_AT_S, enumerate("xy")):
        found = forces[round(time * _ROWS_PER_S), axis]
        study.tabulated(f"F{name} at {time:g} s (N)", found)
    study.tabulated("total work (J)", unit.path_work_j(path, forces))
    for start, end in ((1.25, 2.5), (3.75, 5.0), (6.25, 7.5), (8.75, 10.0)):
        rows = slice(round(start * _ROWS_PER_S) - 1, round(end * _ROWS_PER_S) + 1)
        work = unit.path_work_j(path[rows], forces[rows])
        study.tabulated(f"work from {start} to {end} s (J)", work)
    closed, friction_n = forces[:, 2] > 0.0, np.hypot(*forces[:, :2].T)
    # The rows around each jump of the square wave are left out.
    steady = np.ones(len(closed), dtype=bool)
    for jump in np.flatnonzero(np.diff(closed)).tolist():
        steady[jump : jump + 3] = False
    excess = friction_n - np.where(closed, 1500.0 + 0.3 * forces[:, 2], 0.0)
    beyond = max(0.0, float(excess[steady].max())) / LIMIT_N
    study.at_most("excess of force over the cone / limit", beyond, 1e-6, "cone")
    loose = float(np.abs(forces[~closed & steady, :2]).max())
    study.at_most("friction while open (N)", loose, 0.0, "no friction")
    study.states("closing decides", "vector", loose)
    _compare_schemes(study)
    _draw(study, path[::5], forces[::5] / KN)


def _compare_schemes(study: Study) -> None:
    """Compare schemes and couplings with steps of 1 ms that are not divided."""
    path, source = unit.figure_3(1000), "radial return on a fine grid"
    exact = unit.follow_law(PAPER_LAW, path, substeps=20)
    directions = np.sign(np.diff(path[:, 1:], axis=0).round(9))
    events = int(np.count_nonzero(np.any(np.diff(directions, axis=0) != 0.0, axis=1)))
    for scheme, coupling in product(_SCHEMES, _COUPLINGS):
        options: Any = {"scheme": scheme, "coupling": coupling}
        forces = unit.drive_unit(PAPER_LAW, path, substeps=1, **options).forces_n
        error = np.hypot(*(forces - exact)[:, :2].T) / LIMIT_N
        # Leave out the 3 largest errors per opening, closing or reversal: they depend on timing.
        error_ratio = rms(np.sort(error)[: -3 * events])
        largest = float(np.hypot(*forces[:, :2].T).max()) / LIMIT_N
        name = f"{scheme}, {coupling}"
        case = f"{name} (as in the paper)" if name == "componentwise, lagged" else name
        study.states("limit in every direction", case, largest)
        claim = "elastic springs too" if scheme == "elastic" else "components are coupled"
        study.states(claim, case, error_ratio)
        if name == "vector, extrapolated":
            study.at_most("RMS error at 1 ms steps / limit", error_ratio, 0.01, source)
            study.tabulated("work at 1 ms steps (J)", unit.path_work_j(path, forces))
        else:
            study.report(f"{name}: RMS error at 1 ms steps / limit", error_ratio, 0.0, source)


def _draw(study: Study, path: Array, forces_kn: Array) -> None:
    """Draw displacements and forces over time, and the loops in their planes."""
    t, (fx, fy, fz) = path[:, 0], forces_kn.T
    moves = {"x": (t, path[:, 1]), "y": (t, path[:, 2]), "10 uz": (t, 10.0 * path[:, 3])}
    total = {"N": (t, fz), "|F|": (t, np.hypot(fx, fy))}
    over_time = [
        Panel("time (s)", "displacement (m)", moves),
        Panel("time (s)", "friction (kN)", {"x": (t, fx), "y": (t, fy)}),
        Panel("time (s)", "force (kN)", total),
    ]
    study.figures["histories"] = drawn(over_time, height_in=5.2)
    turns = np.linspace(0.0, 2.0 * pi, 181)
    cone = LIMIT_N / KN * np.cos(turns), LIMIT_N / KN * np.sin(turns)
    dots = {"ls": "none", "marker": ".", "ms": 2.5}
    planes = [
        Panel("ux (m)", "Fx (kN)", {"x": (path[:, 1], fx)}),
        Panel("uy (m)", "Fy (kN)", {"y": (path[:, 2], fy)}),
        Panel("Fx (kN)", "Fy (kN)", {"cone": cone, "|F|": (fx, fy, dots)}, "", {"aspect": "equal"}),
    ]
    study.figures["planes"] = drawn(planes, columns=3, height_in=2.9)


type PathKind = Literal["closed", "opening and closing", "reversals"]
# Paths of the study of the couplings, with the titles of their panels.
_KINDS: Final[dict[PathKind, str]] = {
    "closed": "path that stays closed",
    "opening and closing": "path that opens and closes",
    "reversals": "path with reversals",
}
_DECK: Final = "deck C5"
_DECK_S: Final = 0.6


def run_orders(study: Study) -> None:
    """Run the study of the order of the couplings."""
    rows: list[Row] = [
        {"study": kind, "coupling": coupling, "rows": rows, "step": 1.0 / rows}
        | {"error_ratio": path_error(rows, coupling, kind)}
        for kind, coupling, rows in product(_KINDS, _COUPLINGS, (125, 250, 500, 1000, 2000, 4000))
    ]
    exact = run_deck(deck_case("C5", solver="penalty", dt_s=2.5e-4, duration_s=_DECK_S))
    scale = np.abs(exact.q).max(axis=0)
    couplings = (("extrapolated", 1), ("lagged", 1), ("extrapolated", 8))
    for step, (coupling, parts) in product((0.2, 0.1, 0.05, 0.02, 0.01), couplings):
        dt_s = step / deck_case("C5").contact_frequency_rad_per_s
        case = deck_case("C5", dt_s=dt_s, duration_s=_DECK_S, coupling=coupling)
        found = run_opensees(case, pulse_of(case), parts_on_change=parts)
        q = np.array([np.interp(exact.t_s, found.t_s, column) for column in found.q.T]).T
        name = coupling if parts == 1 else f"{coupling}, sub-steps"
        row = {"study": _DECK, "coupling": name, "rows": 0, "step": step}
        rows.append(row | {"error_ratio": rms((q - exact.q) / scale)})
    study.tables["errors"] = table = pd.DataFrame(rows)
    source = "radial return on a fine grid"
    panels: dict[str, dict[str, Any]] = {kind: {} for kind in (*_KINDS, _DECK)}
    for (kind, coupling), group in table.groupby(["study", "coupling"]):
        # slope of ln error over ln step
        order = float(np.polyfit(np.log(group["step"]), np.log(group["error_ratio"]), 1)[0])
        if (kind, coupling) == ("closed", "extrapolated"):
            at_1000 = float(group.loc[group["rows"] == 1000, "error_ratio"].iloc[0])
            study.at_most("closed path, 1000 rows per period: RMS error", at_1000, 0.012, source)
            study.holds("closed path: order at least 0.9", truth=order >= 0.9, source=source)
        study.report(f"{kind}, {coupling}: order", order, 1.0, source)
        panels[str(kind)][str(coupling)] = group["step"], group["error_ratio"], {"marker": "."}
    scales = {"xscale": "log", "yscale": "log"}
    titles = {**_KINDS, _DECK: "frictional deck C5, step x contact frequency"}
    labels = "step / period (-)", "RMS error (-)"
    figure = [Panel(*labels, lines, titles[kind], scales) for kind, lines in panels.items()]
    study.figures["order"] = drawn(figure, columns=2, height_in=5.2)


def smooth_path(rows: int, kind: PathKind) -> Array:
    """Return two periods (1 s each) of a curve in space, with `rows` rows per period.

    The path `closed` stays closed; `opening and closing` opens once per period; `reversals` stays
    closed and moves back and forth on a slightly curved line.
    """
    t = np.linspace(0.0, 2.0, 2 * rows + 1)
    if kind == "reversals":
        x, y = 0.5 * np.sin(2.0 * pi * t), 0.005 * (1.0 - np.cos(4.0 * pi * t))
        return np.column_stack([t, x, y, np.full_like(t, -0.1)])
    x = 0.5 * np.sin(2.0 * pi * t) + 0.2 * np.sin(4.0 * pi * t + 0.4) - 0.2 * np.sin(0.4)
    y = 0.4 * np.sin(2.0 * pi * t + 1.1) - 0.4 * np.sin(1.1)
    z = (-0.10 if kind == "closed" else 0.02) - 0.08 * np.sin(2.0 * pi * t + 0.3)
    return np.column_stack([t, x, y, z])


def path_error(rows: int, coupling: Coupling, kind: PathKind) -> float:
    """Return the RMS error of the friction force / largest friction limit."""
    path = smooth_path(rows, kind)
    # The reference follows the smooth curve, not the chords between the rows.
    parts = max(1, 64000 // rows)
    fine = unit.follow_law(PAPER_LAW, smooth_path(rows * parts, kind))[::parts]
    forces = unit.drive_unit(PAPER_LAW, path, substeps=1, coupling=coupling).forces_n
    limit = PAPER_LAW.cohesion_n + PAPER_LAW.friction * float(fine[:, 2].max())
    return unit.rms_n((forces - fine)[:, :2]) / limit


IMPLICIT: Final = 0
IMPLEX: Final = 1
_NAMES: Final = {IMPLICIT: "implicit", IMPLEX: "IMPL-EX"}
_LAW: Final = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3)
# Case, integration, step in s, and whether it is judged. The friction of the native element is
# first order in the step; in C2 it is still 1.6 to 8 % off at 2e-5 s. The judged case with friction
# is therefore C5 at that step.
_DECK_RUNS: Final = (
    ("C1", IMPLICIT, 1e-4, True),
    ("C1", IMPLEX, 1e-4, False),
    ("C3", IMPLICIT, 1e-4, True),
    ("C2", IMPLICIT, 5e-3, False),
    ("C2", IMPLICIT, 1e-4, False),
    ("C5", IMPLICIT, 1e-4, False),
    ("C5", IMPLICIT, 2e-5, True),
    ("C5", IMPLEX, 1e-4, False),
)
_TOLERANCES: Final = {"ux_m": 0.01, "uy_m": 0.01, "theta_rad": 0.02}
_NATIVE: Final = "zeroLengthContactASDimplex"


def run_native(study: Study) -> None:
    """Run the study of the native element."""
    path = curved_path()
    ours = unit.drive_unit(_LAW, path, substeps=10).forces_n
    limit_n = _LAW.friction * float(ours[:, 2].max())
    native = {each: drive_native(_LAW, path, each, substeps=10) for each in _NAMES}
    errors = {each: unit.rms_n((ours - forces)[:, :2]) / limit_n for each, forces in native.items()}
    text = "RMS difference / limit"
    study.at_most(f"driven path: {text}", errors[IMPLICIT], 0.01, _NATIVE)
    work, exact = (unit.path_work_j(path, forces) for forces in (ours, native[IMPLICIT]))
    study.relative("driven path: work (J)", work, exact, 2e-3, _NATIVE)
    study.report(f"driven path, IMPL-EX: {text}", errors[IMPLEX], 0.0, _NATIVE)
    for name, integration, dt_s, is_judged in _DECK_RUNS:
        case = deck_case(name)
        found, (t_s, q) = run_deck(case).peaks(), run_native_deck(name, integration, dt_s)
        text = f"{name}, {_NAMES[integration]}, dt {dt_s:g} s"
        if not (finished := t_s[-1] >= case.duration_s - case.dt_s):
            study.report(f"{text}: time of failed step (s)", t_s[-1], case.duration_s, _NATIVE)
        for (key, tolerance), peak in zip(_TOLERANCES.items(), np.abs(q).max(axis=0), strict=True):
            limit = tolerance if finished and is_judged else None
            study.relative(f"{text}: peak {key}", found[key], peak, limit, _NATIVE)


def curved_path(rows_per_period: int = 1000) -> Array:
    """Return a smooth path in space that opens and closes."""
    t = np.linspace(0.0, 2.0, 2 * rows_per_period + 1)
    x, y = 0.5 * np.sin(2.0 * pi * t), 0.4 * np.sin(4.0 * pi * t + 0.7) - 0.4 * np.sin(0.7)
    return np.column_stack([t, x, y, 0.03 - 0.08 * np.sin(pi * t + 0.4)])


def drive_native(law: ContactLaw, path: Array, integration: int, substeps: int = 1) -> Array:
    """Drive the native element along a path; return forces as in `PathResult`, (rows, 3)."""
    forces = np.zeros((len(path), 3))
    with clean_domain(3, 3):
        unit.support_nodes(law.gap_m)
        _native_contact(2, (unit.SURFACE, unit.BODY), law, (0.0, 0.0, 1.0), integration)
        unit.drive_body(path, system="FullGeneral")
        ops.analyze(1)
        ops.integrator("LoadControl", 1.0 / substeps)
        for row in range(1, len(path)):
            ops.analyze(substeps)
            fx, fy, fz = ops.eleForce(2)[3:6]
            forces[row] = (fx, fy, -fz)
    return forces


def _native_contact(
    tag: int, nodes: tuple[int, int], law: ContactLaw, normal: tuple[float, ...], integration: int
) -> None:
    stiffness = (law.kn_n_per_m, law.kt_n_per_m, law.friction)
    orientation = ("-orient", *normal, "-intType", integration)
    ops.element(_NATIVE, tag, *nodes, *stiffness, *orientation)


def run_native_deck(name: str, integration: int, dt_s: float = 1e-4) -> tuple[Array, Array]:
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
            _native_contact(tag, (wall, corner), law, (float(nx), float(ny), 0.0), integration)
        times, _ = solvers.excite_deck(case, pulse_of(case), system="FullGeneral")
        q = [[0.0, 0.0, 0.0]]
        while len(q) < len(times) and ops.analyze(1, case.dt_s) == 0:
            q.append(ops.nodeDisp(solvers.CENTRE))
    return times[: len(q)], np.array(q)
