"""Order of convergence in the time step of the two couplings, on paths and on a frictional deck."""

from itertools import product
from math import pi
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from skewbridge.contact import Coupling
from skewbridge.verification.references.cases import C5, deck_case
from skewbridge.verification.references.deck_model import pulse_of
from skewbridge.verification.references.deck_solvers import run_deck, run_opensees
from skewbridge.verification.references.driven_unit import PAPER_LAW, drive_unit, follow_law
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

type PathKind = Literal["closed", "opening and closing", "reversals"]

_KINDS: Final[tuple[PathKind, ...]] = ("closed", "opening and closing", "reversals")
_ROWS: Final = (125, 250, 500, 1000, 2000, 4000)
_COUPLINGS: Final[tuple[Coupling, ...]] = ("extrapolated", "lagged")
_DECK_STEPS: Final = (0.2, 0.1, 0.05, 0.02, 0.01)
_DECK_DURATION_S: Final = 0.6
_PARTS: Final = 8
_COLOURS: Final = {
    "extrapolated": style.BLUE,
    "lagged": style.ORANGE,
    "extrapolated, sub-steps": style.GREEN,
}


def run(study: Study) -> None:
    """Run the study."""
    table = pd.DataFrame([*_path_errors(), *_deck_errors()])
    source = "radial return on a fine grid"
    for (kind, coupling), group in table.groupby(["study", "coupling"]):
        order = _order(group)
        if kind == "closed" and coupling == "extrapolated":
            at_1000 = float(group.loc[group["rows"] == 1000, "error_ratio"].iloc[0])
            study.at_most("closed path, 1000 rows per period: RMS error", at_1000, 0.012, source)
            study.holds("closed path: order at least 0.9", truth=order >= 0.9, source=source)
        study.report(f"{kind}, {coupling}: order", order, 1.0, source)
    study.figures["order"] = _figure(table)
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


def path_error(rows: int, coupling: Coupling, kind: PathKind, substeps: int = 1) -> float:
    """Return the RMS error of the friction over the largest limit."""
    path = smooth_path(rows, kind)
    # The reference follows the smooth curve, not the chords between the rows.
    parts = max(1, 64000 // rows)
    fine = follow_law(PAPER_LAW, smooth_path(rows * parts, kind))[::parts]
    forces = drive_unit(PAPER_LAW, path, substeps=substeps, coupling=coupling).forces_n
    limit = PAPER_LAW.cohesion_n + PAPER_LAW.friction * float(fine[:, 2].max())
    return float(np.sqrt(np.mean(np.sum((forces - fine)[:, :2] ** 2, axis=1)))) / limit


def _path_errors() -> list[dict[str, Any]]:
    return [
        {"study": kind, "coupling": coupling, "rows": rows, "step": 1.0 / rows}
        | {"error_ratio": path_error(rows, coupling, kind)}
        for kind, coupling, rows in product(_KINDS, _COUPLINGS, _ROWS)
    ]


def _deck_errors() -> list[dict[str, Any]]:
    exact = run_deck(deck_case(C5, solver="penalty", dt_s=2.5e-4, duration_s=_DECK_DURATION_S))
    scale = np.abs(exact.q).max(axis=0)
    rows: list[dict[str, Any]] = []
    for step in _DECK_STEPS:
        dt = step / deck_case(C5).contact_frequency_rad_per_s
        for coupling, parts in (("extrapolated", 1), ("lagged", 1), ("extrapolated", _PARTS)):
            case = deck_case(C5, dt_s=dt, duration_s=_DECK_DURATION_S, coupling=coupling)
            found = run_opensees(case, pulse_of(case), parts_on_change=parts)
            q = np.array([np.interp(exact.t_s, found.t_s, column) for column in found.q.T]).T
            error = float(np.sqrt(np.mean(((q - exact.q) / scale) ** 2)))
            name = coupling if parts == 1 else f"{coupling}, sub-steps"
            row = {"study": "deck C5", "coupling": name, "rows": 0, "step": step}
            rows.append(row | {"error_ratio": error})
    return rows


def _order(group: pd.DataFrame) -> float:
    """Return the slope of the error in the step, both logarithmic."""
    slope, _ = np.polyfit(np.log(group["step"]), np.log(group["error_ratio"]), 1)
    return float(slope)


def _figure(table: pd.DataFrame) -> Figure:
    figure, axes = style.panels(2, 2, height_in=5.2)
    titles = {
        "closed": "path that stays closed",
        "opening and closing": "path that opens and closes",
        "reversals": "path with reversals",
        "deck C5": "frictional deck C5",
    }
    for axis, (kind, title) in zip(np.ravel(axes), titles.items(), strict=True):
        part = table[table["study"] == kind]
        for coupling, group in part.groupby("coupling"):
            x, y = group["step"], group["error_ratio"]
            name, colour = f"{coupling}: {_order(group):.2f}", _COLOURS[str(coupling)]
            style.line(axis, x, y, colour, name, marker="o", ms=3)
        steps = np.array([part["step"].min(), part["step"].max()])
        least = part["error_ratio"].min()
        style.line(axis, steps, least * steps / steps[0] / 2, style.GREY, lw=0.8)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_ylim(least / 4, part["error_ratio"].max() * 30)
        axis.xaxis.set_minor_formatter(NullFormatter())
        of_x = "step x contact frequency (-)" if kind == "deck C5" else "step / period (-)"
        style.label(axis, of_x, "RMS error (-)", title)
        style.legend(axis, title="order of convergence", title_fontsize=7, loc="upper left")
    return figure
