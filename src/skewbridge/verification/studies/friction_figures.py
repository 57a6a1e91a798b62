"""Figures 11 and 12 of the paper, drawn from two analyses of the same motion."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from skewbridge.analysis.result import AnalysisResult
from skewbridge.units import KN, MM
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.figure_style import dots, label, legend, panel, panels
from skewbridge.verification.studies.friction_pairs import draw_pair
from skewbridge.verification.studies.half_cycles import HalfCycle
from skewbridge.verification.studies.paper_motions import PaperMotion

type Histories = Mapping[str, NDArray[np.float64]]
type Pair = tuple[AnalysisResult, AnalysisResult]
"""With friction, without."""


def histories_of(result: AnalysisResult) -> Histories:
    """Return the histories of a result that was asked for them."""
    return result.histories or {}


def displacement_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw the displacement of the mass centre along both axes."""
    figure, axes = panels(2, 1, height_in=3.8, sharex=True)
    tables = [histories_of(result) for result in pair]
    for axis, column, name in (
        (axes[0, 0], "deck_ux_m", "longitudinal (mm)"),
        (axes[1, 0], "deck_uy_m", "transverse (mm)"),
    ):
        draw_pair(axis, *((table["t_s"], table[column] / MM) for table in tables))
        label(axis, "", name)
    axes[1, 0].set_xlabel("time (s)", fontsize=8)
    legend(axes[0, 0], loc="upper right")
    figure.suptitle(f"OSB1, mass centre, skew 0; {motion.label}", fontsize=9)
    return figure


def hysteresis_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw force against displacement of both abutments along both axes."""
    figure, axes = panels(2, 2, height_in=5.0)
    tables = [histories_of(result) for result in pair]
    for row, (axis_name, direction) in enumerate((("longitudinal", "x"), ("transverse", "y"))):
        for axis, side in zip(axes[row], ("left", "right"), strict=True):
            start = f"abutment_{side}_{direction}"
            curves = [(t[f"{start}_m"] / MM, t[f"{start}_kn"] * KN / 1e6) for t in tables]
            draw_pair(axis, *curves)
            label(axis, "displacement (mm)", "force (MN)", f"{side} abutment, {axis_name}")
    legend(axes[0, 0], loc="best")
    figure.suptitle(f"OSB1, skew 0; {motion.label}", fontsize=9)
    return figure


def cycle_figure(cycles: list[HalfCycle], motion: PaperMotion) -> Figure:
    """Draw what friction changes per half cycle against how much the axes coincide."""
    figure, axis = panel(height_in=3.0)
    for has_contact, colour, text in (
        (True, style.BLUE, "backwall in contact"),
        (False, style.ORANGE, "no backwall contact"),
    ):
        chosen = [cycle for cycle in cycles if cycle.has_contact is has_contact]
        change_mm = [(cycle.peak_with_m - cycle.peak_without_m) / MM for cycle in chosen]
        together = [cycle.together for cycle in chosen]
        dots(axis, together, change_mm, colour, text, ms=5, alpha=0.8)
    axis.axhline(0.0, color="0.4", lw=0.6)
    x = "both axes together: max |ux uy| of the half cycle / (max |ux| max |uy|)"
    label(axis, x, "change of transverse\npeak by friction (mm)")
    legend(axis)
    figure.suptitle(f"OSB1, skew 0, transverse half cycles; {motion.label}", fontsize=9)
    return figure
