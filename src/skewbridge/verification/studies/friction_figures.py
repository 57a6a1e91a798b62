"""Figures 11 and 12 of the paper, drawn from two analyses of the same motion."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from skewbridge.analysis.result import AnalysisResult
from skewbridge.units import KN, MM
from skewbridge.verification.studies.figure_style import BLUE, ORANGE, label, legend, panels
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
    for axis, column, name in (
        (axes[0, 0], "deck_ux_m", "longitudinal (mm)"),
        (axes[1, 0], "deck_uy_m", "transverse (mm)"),
    ):
        for result, text, colour, width in reversed(_styled(pair)):
            table = histories_of(result)
            axis.plot(table["t_s"], table[column] / MM, color=colour, lw=width, label=text)
        label(axis, "", name)
    label(axes[1, 0], "time (s)", "transverse (mm)")
    legend(axes[0, 0], loc="upper right")
    figure.suptitle(f"OSB1, mass centre, skew 0; {motion.label}", fontsize=9)
    return figure


def hysteresis_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw force against displacement of both abutments along both axes."""
    figure, axes = panels(2, 2, height_in=5.0)
    for row, direction in enumerate(("x", "y")):
        for place, side in enumerate(("left", "right")):
            axis = axes[row, place]
            for result, text, colour, width in reversed(_styled(pair)):
                table = histories_of(result)
                start = f"abutment_{side}_{direction}"
                axis.plot(
                    *(table[f"{start}_m"] / MM, table[f"{start}_kn"] * KN / 1e6),
                    color=colour,
                    lw=width,
                    label=text,
                )
            axis_name = "longitudinal" if direction == "x" else "transverse"
            label(axis, "displacement (mm)", "force (MN)", f"{side} abutment, {axis_name}")
    legend(axes[0, 0], loc="best")
    figure.suptitle(f"OSB1, skew 0; {motion.label}", fontsize=9)
    return figure


def _styled(pair: Pair) -> list[tuple[AnalysisResult, str, str, float]]:
    return [(pair[0], "friction 0.5", BLUE, 1.0), (pair[1], "no friction", ORANGE, 0.8)]


def cycle_figure(cycles: list[HalfCycle], motion: PaperMotion) -> Figure:
    """Draw what friction changes per half cycle against how much the axes coincide."""
    figure, axes = panels(1, 1, height_in=3.0)
    axis = axes[0, 0]
    for has_contact, colour, text in (
        (True, BLUE, "backwall in contact"),
        (False, ORANGE, "no backwall contact"),
    ):
        chosen = [cycle for cycle in cycles if cycle.has_contact is has_contact]
        axis.plot(
            [cycle.together for cycle in chosen],
            [(cycle.peak_with_m - cycle.peak_without_m) / MM for cycle in chosen],
            "o",
            color=colour,
            ms=5,
            alpha=0.8,
            label=text,
        )
    axis.axhline(0.0, color="0.4", lw=0.6)
    label(
        axis,
        "both axes together: max |ux uy| of the half cycle / (max |ux| max |uy|)",
        "change of transverse\npeak by friction (mm)",
    )
    legend(axis)
    figure.suptitle(f"OSB1, skew 0, transverse half cycles; {motion.label}", fontsize=9)
    return figure
