"""OSB1 under all abutment models, with skew, and OSB2S: what the choice of model changes.

The paper's section 6 announces these comparisons; the statements on skew are those of its
section 3.2 (after Wu et al.).
"""

from math import isclose
from typing import Final

import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.result import AnalysisResult
from skewbridge.statuses import RAN
from skewbridge.units import MM
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.verification.judgement import RESOLUTION, decided
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    analysis,
    histories_of,
    paper_variant,
    with_and_without,
)
from skewbridge.verification.studies.paper_motions import PaperMotion, waho

SKEWS_DEG: Final = (0, 30)
# The five models of the paper.
_COLOURS: Final = {
    "roller": style.GREY,
    "simplified": style.PINK,
    "spring": style.GREEN,
    "contact": style.ORANGE,
    "contact_friction": style.BLUE,
}
_WITH_CONTACTS: Final = [name for name, traits in ABUTMENTS.items() if traits.has_contacts]
_WITHOUT: Final = "without friction, this model"
_DEMANDS: Final = (
    "deck_disp_m",
    "deck_rotation_rad",
    "column_shear_kn",
    "column_drift_ratio",
    "unseating_m",
    "acute_corner_unseating_m",
    "bearing_disp_m",
    "backwall_force_kn",
    "shear_key_force_kn",
)

type Runs = dict[tuple[str, int], AnalysisResult]


def run(study: Study) -> None:
    """Run the study."""
    motion = waho()
    runs: Runs = {
        (abutment, skew): analysis(paper_variant(abutment=abutment, skew_deg=skew), motion)
        for abutment in _COLOURS
        for skew in SKEWS_DEG
    }
    text = "OSB1: every abutment model and skew ends with status ok or collapse"
    has_run = all(found.status in RAN for found in runs.values())
    study.holds(text, truth=has_run, source="this model")
    _skew_statements(study, runs, motion)
    rough, smooth = with_and_without(
        lambda variant: analysis(variant, motion), bridge="osb2s", skew_deg=20
    )
    for demand in _DEMANDS:
        text = f"OSB2S (surrogate), skew 20: {demand}, friction 0.5 against 0"
        study.report(text, rough.whole_history[demand], smooth.whole_history[demand], _WITHOUT)
    for skew in SKEWS_DEG:
        study.figures[f"skew{skew:02d}"] = _figure(runs, skew, motion)
    study.tables["demands"] = _table(runs)


def _skew_statements(study: Study, runs: Runs, motion: PaperMotion) -> None:
    """Judge what the paper says of skew, for the models with walls at the corners."""
    for abutment in _WITH_CONTACTS:
        straight, skewed = (runs[abutment, skew].whole_history for skew in SKEWS_DEG)
        case = f"OSB1, {abutment}, skew {SKEWS_DEG[1]}{motion.stand_in}"
        turns = [1e3 * found["deck_rotation_rad"] for found in (skewed, straight)]
        reason = f"rotation {turns[0]:.2f} mrad, {turns[1]:.2f} mrad without skew"
        study.states("skew deck rotates", case, decided(turns[0] > 2.0 * turns[1], reason, *turns))
        acute, worst = skewed["acute_corner_unseating_m"], skewed["unseating_m"]
        reason = f"acute corner {acute / MM:.0f} mm from its seat, worst corner {worst / MM:.0f} mm"
        judged = decided(isclose(acute, worst), reason, acute, worst)
        study.states("acute corner moves away", case, judged)
        lengths = [found["unseating_m"] for found in (skewed, straight)]
        reason = f"unseating {lengths[0] / MM:.0f} mm, {lengths[1] / MM:.0f} mm without skew"
        judged = decided(lengths[0] > (1.0 + RESOLUTION) * lengths[1], reason, *lengths)
        study.states("skew needs longer seats", case, judged)


def _table(runs: Runs) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {"abutment": abutment, "skew_deg": skew, "status": result.status}
            | {demand: result.whole_history[demand] for demand in _DEMANDS}
            for (abutment, skew), result in runs.items()
        ]
    )


def _figure(runs: Runs, skew: int, motion: PaperMotion) -> Figure:
    names = ("longitudinal (mm)", "transverse (mm)", "rotation (mrad)")
    figure, axes = style.time_panels(*names, height_in=5.4)
    columns = {"deck_ux_m": MM, "deck_uy_m": MM, "deck_rot_rad": 1e-3}
    for axis, (column, unit) in zip(axes, columns.items(), strict=True):
        for abutment, colour in _COLOURS.items():
            table = histories_of(runs[abutment, skew])
            text = abutment.replace("_", " ")
            style.line(axis, table["t_s"], table[column] / unit, colour, text, lw=0.9)
        axis.axhline(0.0, color=style.BLACK, lw=0.4)
    style.legend(axes[0], loc="upper right", ncols=5)
    figure.suptitle(f"OSB1, skew {skew}; {motion.label}", fontsize=9)
    return figure
