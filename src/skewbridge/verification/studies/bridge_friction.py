"""Figures 11 and 12 of the paper: OSB1 without skew, with and without friction.

The paper's record is WAHO; whatever stands in for it is named on the figures and in the cases of
the statements. Both the default scheme and the paper's are judged.
"""

from dataclasses import asdict
from typing import Final

import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.settings import Scheme
from skewbridge.units import KN, MM
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.bridge_statements import (
    Pair,
    judge_bridge,
    transverse_cycles,
)
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    analysis,
    draw_pair,
    histories_of,
    with_and_without,
)
from skewbridge.verification.studies.half_cycles import HalfCycle
from skewbridge.verification.studies.paper_motions import PaperMotion, waho

SCHEMES: Final[tuple[Scheme, ...]] = ("default", "paper")
_PAPER: Final = "without friction, this model"
_DEMANDS: Final = (
    "deck_disp_x_m",
    "deck_disp_y_m",
    "deck_disp_m",
    "column_shear_kn",
    "column_drift_ratio",
    "unseating_m",
    "backwall_force_kn",
    "shear_key_force_kn",
)


def run(study: Study) -> None:
    """Run the study."""
    motion = waho()
    for scheme in SCHEMES:
        pair = with_and_without(lambda variant, scheme=scheme: analysis(variant, motion, scheme))
        _report_ratios(study, f"{scheme} scheme", pair)
        _check(study, f"{scheme} scheme", pair)
        judge_bridge(study, f"{scheme} scheme", pair, motion)
        if scheme == SCHEMES[0]:
            _draw(study, pair, motion)


def _draw(study: Study, pair: Pair, motion: PaperMotion) -> None:
    """Draw figures 11 and 12, and what friction changes cycle by cycle."""
    cycles = transverse_cycles(pair)
    study.figures["displacements"] = _displacement_figure(pair, motion)
    study.figures["hysteresis"] = _hysteresis_figure(pair, motion)
    study.figures["cycles"] = _cycle_figure(cycles, motion)
    study.tables["cycles"] = pd.DataFrame(
        [asdict(cycle) | {"change": cycle.change} for cycle in cycles]
    )


def _report_ratios(study: Study, name: str, pair: Pair) -> None:
    """Put the demands with friction beside those without."""
    with_friction, without = (result.whole_history for result in pair)
    for demand in _DEMANDS:
        text = f"{name}: {demand}, friction 0.5 against 0"
        study.report(text, with_friction[demand], without[demand], _PAPER)
    study.report(f"{name}: slip_work_kj", with_friction["slip_work_kj"], 0.0, _PAPER)


def _check(study: Study, name: str, pair: Pair) -> None:
    """Check that the analyses are whole and the walls meet: what is judged rests on it."""
    with_friction, without = (result.whole_history for result in pair)
    is_whole = all(result.status == "ok" for result in pair)
    text = f"{name}: both analyses end with status ok"
    study.holds(text, truth=is_whole, source="this model")
    least_kn = min(with_friction["backwall_force_kn"], without["backwall_force_kn"])
    study.holds(f"{name}: the backwalls close", truth=least_kn > 0.0, source="this motion")


def _displacement_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw the displacement of the mass centre along both axes."""
    figure, axes = style.time_panels("longitudinal (mm)", "transverse (mm)", height_in=3.8)
    tables = [histories_of(result) for result in pair]
    for axis, column in zip(axes, ("deck_ux_m", "deck_uy_m"), strict=True):
        draw_pair(axis, *((table["t_s"], table[column] / MM) for table in tables))
    style.legend(axes[0], loc="upper right")
    figure.suptitle(f"OSB1, mass centre, skew 0; {motion.label}", fontsize=9)
    return figure


def _hysteresis_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw force against displacement of both abutments along both axes."""
    figure, axes = style.panels(2, 2, height_in=5.0)
    tables = [histories_of(result) for result in pair]
    for row, (axis_name, direction) in enumerate((("longitudinal", "x"), ("transverse", "y"))):
        for axis, side in zip(axes[row], ("left", "right"), strict=True):
            start = f"abutment_{side}_{direction}"
            curves = [(t[f"{start}_m"] / MM, t[f"{start}_kn"] * KN / 1e6) for t in tables]
            draw_pair(axis, *curves)
            style.label(axis, "displacement (mm)", "force (MN)", f"{side} abutment, {axis_name}")
    style.legend(axes[0, 0], loc="best")
    figure.suptitle(f"OSB1, skew 0; {motion.label}", fontsize=9)
    return figure


def _cycle_figure(cycles: list[HalfCycle], motion: PaperMotion) -> Figure:
    """Draw what friction changes per half cycle against how much the axes coincide."""
    figure, axis = style.panel(height_in=3.0)
    for has_contact, colour, text in (
        (True, style.BLUE, "backwall in contact"),
        (False, style.ORANGE, "no backwall contact"),
    ):
        chosen = [cycle for cycle in cycles if cycle.has_contact is has_contact]
        change_mm = [(cycle.peak_with_m - cycle.peak_without_m) / MM for cycle in chosen]
        together = [cycle.together for cycle in chosen]
        style.dots(axis, together, change_mm, colour, text, ms=5, alpha=0.8)
    axis.axhline(0.0, color="0.4", lw=0.6)
    x = "both axes together: max |ux uy| of the half cycle / (max |ux| max |uy|)"
    style.label(axis, x, "change of transverse\npeak by friction (mm)")
    style.legend(axis)
    figure.suptitle(f"OSB1, skew 0, transverse half cycles; {motion.label}", fontsize=9)
    return figure
