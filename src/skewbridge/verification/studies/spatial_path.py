"""The unit in space: figure 3 of the paper, and the order of convergence of the couplings.

`run` drives the unit by a square and two triangular waves. `run_orders` compares both couplings on
smooth paths and on a frictional deck, over a range of time steps.
"""

from itertools import product
from math import hypot, pi
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from skewbridge.contact import Coupling, Scheme
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import pulse_of, run_deck, run_opensees
from skewbridge.verification.references.driven_unit import PAPER_LAW
from skewbridge.verification.references.live_model import Array, rms
from skewbridge.verification.registry import Study
from skewbridge.verification.studies import figure_style as style

LIMIT_N: Final = 4500.0
_ROWS_PER_S: Final = 2000
_SOURCE: Final = "radial return, exact in time (docs/theory/verification.md)"

# source: radial return integrated with dt = 1e-5 s; forces (x, y) in N.
EXACT_N: Final = {
    1.5: (-2700.0, 3600.0),
    2.0: (-2700.0, -3600.0),
    3.76: (1001.0, -1334.7),
    4.4: (2700.0, -3600.0),
    4.6: (2927.09, 3417.92),
    4.9: (2700.0, 3600.0),
    6.5: (-2700.0, 3600.0),
    7.4: (2700.0, 3600.0),
    9.0: (2700.0, -3600.0),
    9.2: (-2696.72, -3602.46),
    11.6: (2700.0, 3600.0),
}
EXACT_WORK_J: Final = 42030.64
INTERVAL_WORK_J: Final = {
    (1.25, 2.5): 9069.97,
    (3.75, 5.0): 9069.97,
    (6.25, 7.5): 9183.37,
    (8.75, 10.0): 9183.37,
}
_SCHEMES: Final[tuple[Scheme, ...]] = ("vector", "componentwise", "elastic")
_PAPER_WAY: Final = ("componentwise", "lagged")
_COUPLINGS: Final[tuple[Coupling, ...]] = ("extrapolated", "lagged")


def run(study: Study) -> None:
    """Run the study."""
    # The square wave takes one row to jump: short rows keep its timing.
    path = unit.figure_3(_ROWS_PER_S)
    forces = unit.drive_unit(PAPER_LAW, path, substeps=2).forces_n
    for time, exact in EXACT_N.items():
        found = forces[round(time * _ROWS_PER_S)]
        for axis, name in enumerate("xy"):
            text = f"F{name} at {time:g} s (N)"
            study.absolute(text, found[axis], exact[axis], 0.01 * LIMIT_N, _SOURCE)
    study.relative("total work (J)", unit.path_work_j(path, forces), EXACT_WORK_J, 2e-3, _SOURCE)
    for (start, end), exact_work in INTERVAL_WORK_J.items():
        rows = slice(round(start * _ROWS_PER_S) - 1, round(end * _ROWS_PER_S) + 1)
        work = unit.path_work_j(path[rows], forces[rows])
        study.relative(f"work from {start} to {end} s (J)", work, exact_work, 2e-3, _SOURCE)
    closed, friction_n = forces[:, 2] > 0.0, np.hypot(*forces[:, :2].T)
    # The square wave jumps within one row: that row is left out on both sides.
    steady = np.ones(len(closed), dtype=bool)
    jumps = np.flatnonzero(np.diff(closed))
    for shift in (0, 1, 2):
        steady[np.minimum(jumps + shift, len(closed) - 1)] = False
    excess = friction_n - np.where(closed, 1500.0 + 0.3 * forces[:, 2], 0.0)
    beyond = max(0.0, float(excess[steady].max())) / LIMIT_N
    study.at_most("force beyond the cone over the limit", beyond, 1e-6, "cone")
    loose = float(np.abs(forces[~closed & steady, :2]).max())
    study.at_most("friction while open (N)", loose, 0.0, "no friction")
    study.states("closing decides", "vector", loose)
    study.tables["schemes"] = _compare_schemes(study)
    study.figures["histories"] = _histories(path[::5], forces[::5])
    study.figures["planes"] = _planes(path[::5], forces[::5])


def _compare_schemes(study: Study) -> pd.DataFrame:
    """Compare schemes and couplings at 1 ms steps without sub-steps."""
    path = unit.figure_3(1000)
    exact = unit.follow_law(PAPER_LAW, path, substeps=20)
    directions = np.sign(np.diff(path[:, 1:], axis=0).round(9))
    events = int(np.count_nonzero(np.any(np.diff(directions, axis=0) != 0.0, axis=1)))
    rows: list[tuple[str, str, float, float, float]] = []
    for scheme, coupling in product(_SCHEMES, _COUPLINGS):
        forces = unit.drive_unit(
            PAPER_LAW, path, substeps=1, scheme=scheme, coupling=coupling
        ).forces_n
        error = np.hypot(*(forces - exact)[:, :2].T) / LIMIT_N
        # One step at each opening, closing and reversal is a matter of timing.
        kept = error[np.argsort(error)[: -3 * events]]
        error_ratio, work = rms(kept), unit.path_work_j(path, forces)
        largest = max(hypot(x, y) for x, y, _ in forces) / LIMIT_N
        case = f"{scheme}, {coupling}"
        case += " (the paper's way)" if (scheme, coupling) == _PAPER_WAY else ""
        study.states("limit in every direction", case, largest)
        claim = "elastic springs too" if scheme == "elastic" else "components are coupled"
        study.states(claim, case, error_ratio)
        rows.append((scheme, coupling, error_ratio, work / EXACT_WORK_J - 1.0, largest))
        if (scheme, coupling) == ("vector", "extrapolated"):
            study.at_most("RMS error at 1 ms steps over the limit", error_ratio, 0.01, _SOURCE)
            study.relative("work at 1 ms steps (J)", work, EXACT_WORK_J, 2e-3, _SOURCE)
        else:
            study.report(
                f"{scheme}, {coupling}: RMS error at 1 ms steps", error_ratio, 0.0, _SOURCE
            )
    errors = ["rms_error_ratio", "work_error_ratio", "largest_force_ratio"]
    return pd.DataFrame(rows, columns=["scheme", "coupling", *errors])


def _histories(path: Array, forces: Array) -> Figure:
    names = ("displacement (m)", "friction (kN)", "force (kN)")
    figure, axes = style.time_panels(*names, height_in=5.2)
    moved, friction, total = axes
    t = path[:, 0]
    for column, (name, colour) in enumerate((("x", style.BLUE), ("y", style.ORANGE)), start=1):
        style.line(moved, t, path[:, column], colour, f"u{name}")
        style.line(friction, t, forces[:, column - 1] / 1000, colour, f"F{name}")
    style.line(moved, t, 10.0 * path[:, 3], style.GREEN, "10 uz")
    times = list(EXACT_N)
    for axis, text in enumerate(("exact", "")):
        values = [EXACT_N[time][axis] / 1000 for time in times]
        style.dots(friction, times, values, style.BLACK, text, ms=3)
    style.line(total, t, forces[:, 2] / 1000, style.GREEN, "N")
    style.line(total, t, np.hypot(*forces[:, :2].T) / 1000, style.PINK, "|F|")
    for axis, place in zip(axes, ("lower right", "upper left", "upper left"), strict=True):
        style.legend(axis, ncols=3, loc=place)
    return figure


def _planes(path: Array, forces: Array) -> Figure:
    figure, axes = style.panels(1, 3, height_in=2.7)
    for column, (name, colour) in enumerate((("x", style.BLUE), ("y", style.ORANGE))):
        style.line(axes[0, column], path[:, column + 1], forces[:, column] / 1000, colour)
        style.label(axes[0, column], f"u{name} (m)", f"F{name} (kN)")
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    cone = axes[0, 2]
    style.line(cone, 4.5 * np.cos(angle), 4.5 * np.sin(angle), style.GREY, "cone")
    style.dots(cone, forces[:, 0] / 1000, forces[:, 1] / 1000, style.PINK, marker=".", ms=2.5)
    cone.set_aspect("equal")
    style.label(cone, "Fx (kN)", "Fy (kN)")
    style.legend(cone, loc="center", bbox_to_anchor=(0.5, 0.3))
    return figure


type PathKind = Literal["closed", "opening and closing", "reversals"]

# Paths and deck of the study of the couplings, with the titles of their panels.
_KINDS: Final[dict[PathKind, str]] = {
    "closed": "path that stays closed",
    "opening and closing": "path that opens and closes",
    "reversals": "path with reversals",
}
_DECK: Final = "deck C5"
_ROWS: Final = (125, 250, 500, 1000, 2000, 4000)
_DECK_STEPS: Final = (0.2, 0.1, 0.05, 0.02, 0.01)
_DECK_S: Final = 0.6
_COLOURS: Final = {
    "extrapolated": style.BLUE,
    "lagged": style.ORANGE,
    "extrapolated, sub-steps": style.GREEN,
}


def run_orders(study: Study) -> None:
    """Run the study of the couplings."""
    paths: list[dict[str, Any]] = [
        {"study": kind, "coupling": coupling, "rows": rows, "step": 1.0 / rows}
        | {"error_ratio": path_error(rows, coupling, kind)}
        for kind, coupling, rows in product(_KINDS, _COUPLINGS, _ROWS)
    ]
    table = pd.DataFrame([*paths, *_deck_errors()])
    source = "radial return on a fine grid"
    for (kind, coupling), group in table.groupby(["study", "coupling"]):
        order = _order(group)
        if kind == "closed" and coupling == "extrapolated":
            at_1000 = float(group.loc[group["rows"] == 1000, "error_ratio"].iloc[0])
            study.at_most("closed path, 1000 rows per period: RMS error", at_1000, 0.012, source)
            study.holds("closed path: order at least 0.9", truth=order >= 0.9, source=source)
        study.report(f"{kind}, {coupling}: order", order, 1.0, source)
    study.figures["order"] = _order_figure(table)
    study.tables["errors"] = table


def smooth_path(rows: int, kind: PathKind) -> Array:
    """Return two periods of 1 s of a curve in space.

    Args:
        rows: Rows per period.
        kind: `closed` stays closed, `opening and closing` opens once per period, `reversals`
            stays closed and moves back and forth on a slightly curved line.
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
    """Return the RMS error of the friction over the largest limit."""
    path = smooth_path(rows, kind)
    # The reference follows the smooth curve, not the chords between the rows.
    parts = max(1, 64000 // rows)
    fine = unit.follow_law(PAPER_LAW, smooth_path(rows * parts, kind))[::parts]
    forces = unit.drive_unit(PAPER_LAW, path, substeps=1, coupling=coupling).forces_n
    limit = PAPER_LAW.cohesion_n + PAPER_LAW.friction * float(fine[:, 2].max())
    return unit.rms_n((forces - fine)[:, :2]) / limit


def _deck_errors() -> list[dict[str, Any]]:
    exact = run_deck(deck_case("C5", solver="penalty", dt_s=2.5e-4, duration_s=_DECK_S))
    scale = np.abs(exact.q).max(axis=0)
    rows: list[dict[str, Any]] = []
    for step in _DECK_STEPS:
        dt = step / deck_case("C5").contact_frequency_rad_per_s
        for coupling, parts in (("extrapolated", 1), ("lagged", 1), ("extrapolated", 8)):
            case = deck_case("C5", dt_s=dt, duration_s=_DECK_S, coupling=coupling)
            found = run_opensees(case, pulse_of(case), parts_on_change=parts)
            q = np.array([np.interp(exact.t_s, found.t_s, column) for column in found.q.T]).T
            name = coupling if parts == 1 else f"{coupling}, sub-steps"
            row = {"study": _DECK, "coupling": name, "rows": 0, "step": step}
            rows.append(row | {"error_ratio": rms((q - exact.q) / scale)})
    return rows


def _order(group: pd.DataFrame) -> float:
    """Return the slope of the error in the step, both logarithmic."""
    slope, _ = np.polyfit(np.log(group["step"]), np.log(group["error_ratio"]), 1)
    return float(slope)


def _order_figure(table: pd.DataFrame) -> Figure:
    figure, axes = style.panels(2, 2, height_in=5.2)
    titles = {**_KINDS, _DECK: "frictional deck C5"}
    for axis, (kind, title) in zip(np.ravel(axes), titles.items(), strict=True):
        part = table[table["study"] == kind]
        for coupling, group in part.groupby("coupling"):
            x, y = group["step"], group["error_ratio"]
            name, colour = f"{coupling}: {_order(group):.2f}", _COLOURS[str(coupling)]
            style.line(axis, x, y, colour, name, marker="o", ms=3)
        steps = np.array([part["step"].min(), part["step"].max()])
        least = part["error_ratio"].min()
        style.line(axis, steps, least * steps / steps[0] / 2, style.GREY, lw=0.8)
        axis.set(xscale="log", yscale="log")
        axis.set_ylim(least / 4, part["error_ratio"].max() * 30)
        axis.xaxis.set_minor_formatter(NullFormatter())
        of_x = "step x contact frequency (-)" if kind == _DECK else "step / period (-)"
        style.label(axis, of_x, "RMS error (-)", title)
        style.legend(axis, title="order of convergence", title_fontsize=7, loc="upper left")
    return figure
