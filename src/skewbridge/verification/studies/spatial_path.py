"""The contact unit in space: figure 3 and the order of the couplings.

`run` drives the unit by a square and two triangular waves. `run_orders` compares both couplings on
smooth paths and on a frictional deck, over a range of time steps.
"""

from itertools import product
from math import pi
from typing import Any, Final, Literal

import numpy as np
import pandas as pd

from skewbridge.contact import Coupling, Scheme
from skewbridge.units import KN
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import pulse_of, run_deck, run_opensees
from skewbridge.verification.references.driven_unit import PAPER_LAW
from skewbridge.verification.references.live_model import Array, rms
from skewbridge.verification.registry import Panel, Row, Study, drawn

LIMIT_N: Final = 4500.0
_ROWS_PER_S: Final = 2000
# source: radial return integrated with dt = 1e-5 s gave the forces and works in the table
_FORCES_AT_S: Final = (1.5, 2.0, 3.76, 4.4, 4.6, 4.9, 6.5, 7.4, 9.0, 9.2, 11.6)
_SCHEMES: Final[tuple[Scheme, ...]] = ("vector", "componentwise", "elastic")
_COUPLINGS: Final[tuple[Coupling, ...]] = ("extrapolated", "lagged")


def run(study: Study) -> None:
    """Run the study of figure 3: a contact unit on a path in space."""
    # The square wave jumps within one row: short rows keep its timing.
    path = unit.figure_3(_ROWS_PER_S)
    forces = unit.drive_unit(PAPER_LAW, path, substeps=2).forces_n
    for time, (axis, name) in product(_FORCES_AT_S, enumerate("xy")):
        force_n = forces[round(time * _ROWS_PER_S), axis]
        study.tabulated(f"F{name} at {time:g} s (N)", force_n)
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
    largest_excess = max(0.0, float(excess[steady].max())) / LIMIT_N
    study.at_most("excess of force over the cone / limit", largest_excess, 1e-6, "cone")
    open_force = float(np.abs(forces[~closed & steady, :2]).max())
    study.at_most("friction while open (N)", open_force, 0.0, "no friction")
    study.states("closing decides", "vector", open_force)
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
    t, (fx, fy, fz) = path[:, 0], forces_kn.T
    moves = {"x": (t, path[:, 1]), "y": (t, path[:, 2]), "10 uz": (t, 10.0 * path[:, 3])}
    total = {"N": (t, fz), "|F|": (t, np.hypot(fx, fy))}
    over_time = [
        Panel("time (s)", "displacement (m)", moves),
        Panel("time (s)", "friction (kN)", {"x": (t, fx), "y": (t, fy)}),
        Panel("time (s)", "force (kN)", total),
    ]
    study.figures["histories"] = drawn(over_time, height_in=5.2)
    angles = np.linspace(0.0, 2.0 * pi, 181)
    cone = LIMIT_N / KN * np.cos(angles), LIMIT_N / KN * np.sin(angles)
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
    """Report how errors of both couplings decrease with the time step (order of accuracy)."""
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
        history = run_opensees(case, pulse_of(case), parts_on_change=parts)
        q = np.array([np.interp(exact.t_s, history.t_s, column) for column in history.q.T]).T
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
    """Return two periods (1 s each) of a curve in space, with `rows` rows per period."""
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
    fine_forces = unit.follow_law(PAPER_LAW, smooth_path(rows * parts, kind))[::parts]
    forces = unit.drive_unit(PAPER_LAW, path, substeps=1, coupling=coupling).forces_n
    limit = PAPER_LAW.cohesion_n + PAPER_LAW.friction * float(fine_forces[:, 2].max())
    return unit.rms_n((forces - fine_forces)[:, :2]) / limit
