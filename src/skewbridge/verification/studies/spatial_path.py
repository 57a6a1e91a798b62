"""Figure 3 of the paper: the three-dimensional unit under a square and two triangular waves."""

from itertools import product
from math import hypot
from typing import Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.contact import Coupling, Scheme
from skewbridge.verification.references.driven_unit import (
    PAPER_LAW,
    drive_unit,
    figure_3,
    follow_law,
    path_work_j,
)
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

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
    path = figure_3(_ROWS_PER_S)
    forces = drive_unit(PAPER_LAW, path, substeps=2).forces_n
    for time, exact in EXACT_N.items():
        found = forces[round(time * _ROWS_PER_S)]
        for axis, name in enumerate("xy"):
            text = f"F{name} at {time:g} s (N)"
            study.absolute(text, found[axis], exact[axis], 0.01 * LIMIT_N, _SOURCE)
    study.relative("total work (J)", path_work_j(path, forces), EXACT_WORK_J, 2e-3, _SOURCE)
    for (start, end), exact_work in INTERVAL_WORK_J.items():
        rows = slice(round(start * _ROWS_PER_S) - 1, round(end * _ROWS_PER_S) + 1)
        work = path_work_j(path[rows], forces[rows])
        study.relative(f"work from {start} to {end} s (J)", work, exact_work, 2e-3, _SOURCE)
    _check_cone(study, forces)
    study.tables["schemes"] = _compare_schemes(study)
    study.figures["histories"] = _histories(path[::5], forces[::5])
    study.figures["planes"] = _planes(path[::5], forces[::5])


def _check_cone(study: Study, forces: Array) -> None:
    closed = forces[:, 2] > 0.0
    limits = np.where(closed, 1500.0 + 0.3 * forces[:, 2], 0.0)
    excess = np.hypot(forces[:, 0], forces[:, 1]) - limits
    # The square wave jumps within one row: that row is left out on both sides.
    steady = np.ones(len(closed), dtype=bool)
    jumps = np.flatnonzero(np.diff(closed))
    for shift in (0, 1, 2):
        steady[np.minimum(jumps + shift, len(closed) - 1)] = False
    beyond = max(0.0, float(excess[steady].max())) / LIMIT_N
    study.at_most("force beyond the cone over the limit", beyond, 1e-6, "cone")
    loose = float(np.abs(forces[~closed & steady, :2]).max())
    study.at_most("friction while open (N)", loose, 0.0, "no friction")
    study.states("closing decides", "vector", loose)


def _compare_schemes(study: Study) -> pd.DataFrame:
    """Compare schemes and couplings at 1 ms steps without sub-steps."""
    path = figure_3(1000)
    exact = follow_law(PAPER_LAW, path, substeps=20)
    directions = np.sign(np.diff(path[:, 1:], axis=0).round(9))
    events = int(np.count_nonzero(np.any(np.diff(directions, axis=0) != 0.0, axis=1)))
    rows: list[tuple[str, str, float, float, float]] = []
    for scheme, coupling in product(_SCHEMES, _COUPLINGS):
        forces = drive_unit(PAPER_LAW, path, substeps=1, scheme=scheme, coupling=coupling).forces_n
        error = np.hypot(*(forces - exact)[:, :2].T) / LIMIT_N
        # One step at each opening, closing and reversal is a matter of timing.
        kept = error[np.argsort(error)[: -3 * events]]
        rms, work = float(np.sqrt(np.mean(kept**2))), path_work_j(path, forces)
        largest = max(hypot(x, y) for x, y, _ in forces) / LIMIT_N
        case = f"{scheme}, {coupling}"
        case += " (the paper's way)" if (scheme, coupling) == _PAPER_WAY else ""
        study.states("limit in every direction", case, largest)
        claim = "elastic springs too" if scheme == "elastic" else "components are coupled"
        study.states(claim, case, rms)
        rows.append((scheme, coupling, rms, work / EXACT_WORK_J - 1.0, largest))
        if (scheme, coupling) == ("vector", "extrapolated"):
            study.at_most("RMS error at 1 ms steps over the limit", rms, 0.01, _SOURCE)
            study.relative("work at 1 ms steps (J)", work, EXACT_WORK_J, 2e-3, _SOURCE)
        else:
            study.report(f"{scheme}, {coupling}: RMS error at 1 ms steps", rms, 0.0, _SOURCE)
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
