"""What the figures of a study are drawn from, and the cases that each of its figures stands for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.tables.paper_table import METHODS
from skewbridge.motions.record import SuiteMotion
from skewbridge.report.choice_figures import tornado_text
from skewbridge.study.friction_pair import FrictionPair
from skewbridge.variant.axes import axes_of

#: Parts of the report that figures stand in.
EFFECTS, CURVES, CLOUDS, CHOICES, HISTORIES, MOTIONS = SECTIONS = (
    "effects",
    "curves",
    "clouds",
    "choices",
    "histories",
    "motions",
)


@dataclass(frozen=True, kw_only=True)
class StudyTables:
    """What the figures are drawn from.

    Attributes:
        demands: Demands table.
        curves: Fits.
        effects: Paired effects.
        suite: Motions as applied.
        pair: Histories of one bridge without and with friction; None where the study has none.
        choices: Modelling choices; None before `make choices`.
    """

    demands: pd.DataFrame
    curves: pd.DataFrame
    effects: pd.DataFrame
    suite: Sequence[SuiteMotion]
    pair: FrictionPair | None
    choices: pd.DataFrame | None = None

    @property
    def runs(self) -> Mapping[str, pd.DataFrame]:
        """Histories of the pair by friction."""
        return {} if self.pair is None else self.pair.by_friction

    def of_model(self, bridge: str, abutment: str) -> "StudyTables":
        """Return the tables of one bridge with one abutment model."""
        own = {
            name: table[(table["bridge"] == bridge) & (table["abutment"] == abutment)]
            for name, table in vars(self).items()
            if isinstance(table, pd.DataFrame)
        }
        return replace(self, **own)


def effect_cases(tables: StudyTables) -> list[dict[str, str]]:
    """Return a case per axis along which variants are paired, the last of the axis table first."""
    table = tables.effects
    paired = [axis for axis in axes_of(table.columns) if (table["axis"] == axis.name).any()]
    said = {name: _percent(table, name) for name in ("level", "margin")}
    return [{"axis": axis.name, "axis_words": axis.title, **said} for axis in reversed(paired)]


def curve_cases(tables: StudyTables) -> list[dict[str, str]]:
    """Return a case per component of a limit state that has a curve, by its first method.

    The methods have the order of the table that a paper prints.
    """
    drawn = tables.curves[tables.curves["status"] == FITTED]
    rank = {method: place for place, method in enumerate(METHODS)}
    found: list[dict[str, str]] = []
    for component, own in drawn.groupby("component", sort=False):
        method = min(own["method"], key=lambda name: rank.get(name, len(rank)))
        words = str(component).replace("_", " ")
        texts = {"component": str(component), "component_words": words, "method": str(method)}
        found.append({**texts, "level": _percent(own, "level")})
    return found


def cloud_cases(tables: StudyTables) -> list[dict[str, str]]:
    """Return a case per demand that a limit state is set on."""
    names = dict.fromkeys(map(str, tables.curves["demand"]))
    return [{"demand": name, "label": label_of(name)} for name in names if name in tables.demands]


def choice_cases(tables: StudyTables) -> list[dict[str, str]]:
    """Return the one case of the tornado, where modelling choices were compared."""
    table = tables.choices
    return [] if table is None or table.empty else [{"choice_text": tornado_text(table)}]


def pair_cases(tables: StudyTables) -> list[dict[str, str]]:
    """Return the one case of the histories without and with friction, where there are any."""
    if tables.pair is None:
        return []
    variant = tables.pair.variants[0]
    place = f"skew {variant.skew_deg} degrees, gap {variant.gap_mm} mm"
    return [{"place": f"{place}, motion {tables.pair.motion_id}"}]


def _percent(table: pd.DataFrame, column: str) -> str:
    return f"{100 * float(table[column].iloc[0]):g} %" if len(table) else ""
