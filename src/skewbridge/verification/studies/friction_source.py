"""Where the effect of friction comes from: walls, keys, or both; a straight and a skewed bridge."""

from typing import Final

import pandas as pd
from matplotlib.figure import Figure

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.statuses import RAN
from skewbridge.variant.options import FrictionAt, ModelOptions
from skewbridge.verification.judgement import decided
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.bridge_statements import history_change
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.friction_pairs import (
    DURATION_S,
    histories_of,
    paper_variant,
)
from skewbridge.verification.studies.paper_motions import PaperMotion, waho

SKEWS_DEG: Final = (0, 30)
PLACES: Final[tuple[FrictionAt, ...]] = ("all", "walls", "keys")
DEMANDS: Final = {
    "column_shear_kn": "column shear",
    "column_drift_ratio": "drift",
    "deck_disp_m": "displacement",
    "deck_disp_y_m": "transverse displ.",
    "deck_rotation_rad": "rotation",
    "unseating_m": "unseating",
    "abutment_passive_m": "passive",
}
_FREE: Final = {"walls": "key", "keys": "backwall"}
_WITHOUT: Final = "without friction, this model"
# A deck that does not turn has no rotation to compare with.
_LEAST: Final = {"deck_rotation_rad": 1e-4}

type Runs = dict[str, AnalysisResult]


def run(study: Study) -> None:
    """Run the study."""
    motion = waho()
    tables: list[pd.DataFrame] = []
    for skew in SKEWS_DEG:
        runs = _runs(motion, skew)
        _check(study, skew, runs)
        table = _changes(skew, runs)
        for row in table.to_dict("records"):
            text = f"skew {skew}, friction at {row['friction_at']}: {row['demand']}"
            study.report(text, row["value"], row["without"], _WITHOUT)
        tables.append(table)
        _judge(study, f"OSB1, skew {skew}{motion.stand_in}", runs)
    study.tables["changes"] = pd.concat(tables, ignore_index=True)
    study.figures["changes"] = _figure(study.tables["changes"], motion)


def _runs(motion: PaperMotion, skew_deg: int) -> Runs:
    """Return the analyses by place of friction, and without."""
    variant = paper_variant(skew_deg=skew_deg)
    plain = paper_variant(skew_deg=skew_deg, friction_pct=0)
    cases = {place: (variant, ModelOptions(friction_at=place)) for place in PLACES}
    settings, excitation = AnalysisSettings(duration_s=DURATION_S), Excitation(motion=motion.motion)
    return {
        place: analyse(case, excitation, settings, options, histories=True)
        for place, (case, options) in (cases | {"none": (plain, ModelOptions())}).items()
    }


def _check(study: Study, skew: int, runs: Runs) -> None:
    """Check that the analyses are whole, and that contacts without friction have none."""
    has_run = all(found.status in RAN for found in runs.values())
    text = f"skew {skew}: every analysis ends with status ok or collapse"
    study.holds(text, truth=has_run, source="this model")
    for place, free in _FREE.items():
        largest_kn = max(
            (float(abs(column).max()) for column in _friction(runs[place], free)), default=0.0
        )
        text = f"skew {skew}, friction at {place}: friction at a {free} (kN)"
        study.at_most(text, largest_kn, 0.0, "no friction there")


def _friction(result: AnalysisResult, kind: str) -> list[Array]:
    return [
        column
        for name, column in histories_of(result).items()
        if kind in name and name.endswith(("friction_1_kn", "friction_2_kn"))
    ]


def _changes(skew: int, runs: Runs) -> pd.DataFrame:
    """Return each demand with friction at each place, without, and the change."""
    plain = runs["none"].whole_history
    rows = [
        {
            "skew_deg": skew,
            "friction_at": place,
            "demand": demand,
            "value": runs[place].whole_history[demand],
            "without": plain[demand],
        }
        for place in PLACES
        for demand in DEMANDS
        if plain[demand] > _LEAST.get(demand, 0.0)
    ]
    return pd.DataFrame(rows).assign(change=lambda table: table["value"] / table["without"] - 1.0)


def _judge(study: Study, case: str, runs: Runs) -> None:
    """Judge whether it is the walls that change the transverse response."""
    everywhere, walls, keys = (
        history_change((runs[place], runs["none"]), "deck_uy_m") for place in PLACES
    )
    reason = (
        f"RMS change of the transverse displacement {everywhere:.1%}; walls alone {walls:.1%}, "
        f"keys alone {keys:.1%}"
    )
    study.states("backwall makes it", case, decided(walls > keys, reason, walls, keys))


def _figure(table: pd.DataFrame, motion: PaperMotion) -> Figure:
    """Draw the change of each demand by the place of friction."""
    figure, axes = style.panels(1, len(SKEWS_DEG), height_in=3.4, sharey=True)
    colours = (style.BLACK, style.BLUE, style.ORANGE)
    names = list(DEMANDS)
    for axis, skew in zip(axes[0], SKEWS_DEG, strict=True):
        for number, (place, colour) in enumerate(zip(PLACES, colours, strict=True)):
            part = table[(table["skew_deg"] == skew) & (table["friction_at"] == place)]
            heights = [names.index(demand) + 0.25 * (number - 1) for demand in part["demand"]]
            axis.barh(heights, 100.0 * part["change"], height=0.22, color=colour, label=place)
        axis.axvline(0.0, color=style.BLACK, lw=0.6)
        axis.set_yticks(range(len(names)), list(DEMANDS.values()))
        style.label(axis, "change by friction (%)", "", f"skew {skew}")
    axes[0, 0].invert_yaxis()
    style.legend(axes[0, 0], title="friction at", title_fontsize=7)
    figure.suptitle(f"OSB1, friction 0.5; {motion.label}", fontsize=9)
    return figure
