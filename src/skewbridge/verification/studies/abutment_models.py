"""OSB1 under all abutment models, with skew, and OSB2S: what the choice of model changes.

The paper's section 6 announces these comparisons; the statements on skew are those of its
introduction (after Wu et al. and Maragakis and Jennings).
"""

from typing import Final

import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.result import AnalysisResult
from skewbridge.statuses import RAN
from skewbridge.units import MM
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
    _skew_statements(study, runs)
    rough, smooth = with_and_without(
        lambda variant: analysis(variant, motion), bridge="osb2s", skew_deg=20
    )
    for demand in _DEMANDS:
        text = f"OSB2S (surrogate), skew 20: {demand}, friction 0.5 against 0"
        study.report(text, rough.demands[demand], smooth.demands[demand], "paper, section 6")
    for skew in SKEWS_DEG:
        study.figures[f"skew{skew:02d}"] = _figure(runs, skew, motion)
    study.tables["demands"] = _table(runs)


def _skew_statements(study: Study, runs: Runs) -> None:
    source = "paper, section 1 and 3.2"
    straight, skewed = (1e3 * runs["contact", s].demands["deck_rotation_rad"] for s in SKEWS_DEG)
    text = "without friction the skewed deck rotates, the straight one hardly"
    turns = f"({skewed:.2f} against {straight:.2f} mrad)"
    study.holds(f"{text} {turns}", truth=skewed > 2.0 * straight, source=source)
    plain, found = (runs["contact_friction", skew].demands for skew in SKEWS_DEG)
    rotation, unseating = "deck_rotation_rad", "unseating_m"
    text = f"{rotation} with friction, skew 30 against 0"
    study.report(text, found[rotation], plain[rotation], source)
    text = "skew 30: the acute corner moves farthest from its seat (m)"
    study.relative(text, found["acute_corner_unseating_m"], found[unseating], 1e-12, source)
    study.report(f"{unseating}, skew 30 against 0", found[unseating], plain[unseating], source)


def _table(runs: Runs) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {"abutment": abutment, "skew_deg": skew, "status": result.status}
            | {demand: result.demands[demand] for demand in _DEMANDS}
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
