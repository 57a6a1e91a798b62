"""Style of the figures: panels, colours and dashes by variant, ticks, units, samples of runs."""

import re
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import product
from textwrap import fill
from typing import Any, Final, Self

import numpy as np
import pandas as pd
from matplotlib.axis import Axis as DrawnAxis
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from skewbridge.demands.columns import label_of, unit_of
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.units import FOOT, INCH, KIP, KN, MM, MN, Units
from skewbridge.variant.axes import Axis, axes_of

#: Colours of variants, runs and motions in the order of their values, on the page too. They differ
#: in lightness for every kind of colour vision and are no colours of verdicts.
VARIANT_COLOURS: Final = (
    *("#3b2f6b", "#1a9a78", "#b8860b", "#8f4a86"),
    *("#6b7378", "#7fb069", "#7a5230", "#111111"),
)
STYLE: Final[Any] = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "font.size": 9,
    "legend.frameon": False,
}
#: Largest number of runs in a figure.
MAX_SHOWN_RUNS: Final = 5000
#: Largest number of bands in a panel.
MAX_BANDS: Final = 2
#: Marks of the runs in a cloud.
MARKS: Final = ("o", "s", "D", "P", "X", "*")
DASHES: Final = ("-", (0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)))
_WIDEST, _THINNEST = 2.3, 1.0  # lines in points; later lines are thinner, so that both are visible
_LEAST_SHOWN: Final = 3  # panels, dashes and colours have an axis each, constant ones included
_PANEL_LETTERS: Final = 34  # width of the title of a panel
_MANY: Final = 2000.0  # ratio of the ends of an axis above which only decades have ticks

#: Colours of the axes in the sketch of the page.
AXIS_COLOURS: Final = dict(zip(("skew", "gap", "friction"), VARIANT_COLOURS[1:4], strict=True))
#: Units that have another name in US units, with the factor to it.
US_UNITS: Final = {
    "m": ("in", 1.0 / INCH),
    "mm": ("in", MM / INCH),
    "kN": ("kip", KN / KIP),
    "MN": ("kip", MN / KIP),
}
_US_DIGITS: Final = 3  # of a value of the grid that is not a round number in US units
_UNITS: ContextVar[str] = ContextVar("units", default="si")

type Values = tuple[float, ...]


@contextmanager
def shown_in(units: Units) -> Generator[None]:
    """Show all numbers of figures and page in these units; tables stay in SI."""
    token = _UNITS.set(units)
    try:
        yield
    finally:
        _UNITS.reset(token)


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit in which numbers are shown, and the factor to it."""
    return US_UNITS.get(unit, (unit, 1.0)) if _UNITS.get() == "us" else (unit, 1.0)


def shown_length(length_m: float) -> str:
    """Return a length of a bridge in m or ft."""
    return f"{length_m / FOOT:.1f} ft" if _UNITS.get() == "us" else f"{length_m:.1f} m"


def shown_label(column: str) -> tuple[str, float]:
    """Return the label of a column with the shown unit, and the factor to that unit."""
    unit = unit_of(column)
    shown, factor = shown_unit(unit)
    return label_of(column).replace(f"({unit})", f"({shown})"), factor


def plain_log_ticks(axis: DrawnAxis) -> None:
    """Label a logarithmic axis with plain numbers at 1, 2 and 5, over many decades at 1 only."""
    low, high = axis.get_view_interval()
    many = high > _MANY * low > 0.0
    axis.set_major_locator(LogLocator(subs=(1.0,) if many else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(plain_number))
    axis.set_minor_locator(NullLocator())


def plain_number(value: float, _position: int = 0) -> str:
    """Return a number of an axis without an exponent: 0.00002."""
    return np.format_float_positional(value, precision=2, fractional=False, trim="-")


def sampled_runs(demands: pd.DataFrame) -> pd.DataFrame:
    """Return all runs, or `MAX_SHOWN_RUNS` of them drawn at random, in their order."""
    if len(demands) <= MAX_SHOWN_RUNS:
        return demands
    return demands.sample(MAX_SHOWN_RUNS, random_state=DEFAULTS.seed).sort_index()


def shown_axes(table: pd.DataFrame) -> tuple[Axis, ...]:
    """Return the axes that the figures of a table name, in the order of the axis table.

    These are the axes that vary in it, and constant ones up to a total of three.
    """
    present = axes_of(table.columns)
    constant = [axis for axis in present if table[axis.name].nunique() < 2]
    kept = max(_LEAST_SHOWN - (len(present) - len(constant)), 0)
    left_out = {axis.name for axis in constant[kept:]}
    return tuple(axis for axis in present if axis.name not in left_out)


def plain_label(column: str) -> str:
    """Return the label of a column without the marks of its formula."""
    return re.sub(r"\$|\\mathrm|[{}_]", "", label_of(column).replace(r"\,", " "))


def value_text(axis: Axis, value: float) -> str:
    """Return a value of an axis with its unit, such as ``30°`` or ``51 mm``."""
    if axis.unit in ("-", "deg"):
        return f"{value:g}" + ("°" if axis.unit == "deg" else "")
    shown, factor = shown_unit(axis.unit)
    return f"{value:g} {shown}" if factor == 1.0 else f"{factor * value:.{_US_DIGITS}g} {shown}"


def in_words(name: object) -> str:
    """Return a component, limit state or status in words: ``DCR 1.00`` for ``dcr_100``."""
    return re.sub(r"\bdcr (\d)(\d\d)\b", r"DCR \1.\2", str(name).replace("_", " "))


def threshold_text(demand: str, threshold: float) -> str:
    """Return the capacity of a limit state in the unit that engineers use."""
    value, unit = shown_value(demand, threshold)
    return f"{value:.3g}{unit}"


def shown_value(demand: str, value: float) -> tuple[float, str]:
    """Return a value of a demand in the unit that engineers use, and that unit after a space."""
    if demand.endswith("drift_ratio"):
        return 100.0 * value, " %"
    unit = unit_of(demand)
    per_unit, small = {"m": (1000.0, "mm"), "rad": (1000.0, "mrad")}.get(unit, (1.0, unit))
    shown, factor = shown_unit(small)
    return factor * per_unit * value, f" {shown}".rstrip()


def named_value(axis: Axis, value: float) -> str:
    """Return a value of an axis with its name, such as ``gap 51 mm``."""
    return f"{axis.symbol or axis.label.lower()} {value_text(axis, value)}"


def variant_text(axes: Iterable[Axis], row: Mapping[Any, Any] | pd.Series) -> str:
    """Return the values of a variant on some axes, such as ``skew 30°, gap 51 mm``."""
    return ", ".join(named_value(axis, row[axis.name]) for axis in axes)


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantLayout:
    """Panels and line styles of the variants in a table.

    The first axis shown has a panel per value, the second dashes and marks, the third a colour and
    a width. Every further axis multiplies the panels: no axis is averaged over.
    """

    panel_axes: tuple[Axis, ...]
    line_axes: tuple[Axis, ...]
    styles: Mapping[Values, Mapping[str, Any]]

    @classmethod
    def of(cls, table: pd.DataFrame) -> Self:
        """Return the layout of a table with a column per axis."""
        shown = shown_axes(table)
        lines = shown[1:_LEAST_SHOWN]
        values = [sorted(table[axis.name].unique()) for axis in lines]
        count = max(len(values[-1]), 2) if values else 2
        styles: dict[Values, Mapping[str, Any]] = {}
        widths = np.linspace(_WIDEST, _THINNEST, count)
        for key in product(*(enumerate(own) for own in values)):
            shade = key[-1][0] if key else 0
            pattern = key[0][0] if len(key) > 1 else 0
            styles[tuple(value for _, value in key)] = {
                "color": VARIANT_COLOURS[shade % len(VARIANT_COLOURS)],
                "linewidth": float(widths[shade]),
                "linestyle": DASHES[pattern % len(DASHES)],
                "marker": MARKS[pattern % len(MARKS)],
            }
        panels = (*shown[:1], *shown[_LEAST_SHOWN:])
        return cls(panel_axes=panels, line_axes=lines, styles=styles)

    @property
    def banded(self) -> tuple[Values, ...]:
        """Line styles whose curves have bands: more than `MAX_BANDS` in a panel hide each other."""
        return tuple(self.styles)[:MAX_BANDS]

    @property
    def banded_text(self) -> str:
        """Variants whose curves have bands; empty where all have."""
        if len(self.styles) <= MAX_BANDS:
            return ""
        return " and ".join(_joined(self.line_axes, values) for values in self.banded)

    def values_of(self, row: Mapping[Any, Any]) -> Values:
        """Return the values of the line axes of a variant, given its values by column."""
        return tuple(row[axis.name] for axis in self.line_axes)

    def panels(self, table: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
        """Return title and rows of every panel."""
        return [
            (fill(_joined(self.panel_axes, values), _PANEL_LETTERS), part)
            for values, part in _groups(table, self.panel_axes)
        ]

    def lines(self, table: pd.DataFrame) -> Iterator[tuple[pd.DataFrame, Mapping[str, Any]]]:
        """Yield the rows of every line style with the style."""
        for values, part in _groups(table, self.line_axes):
            yield part, self.styles[values]

    def handles(self, *, marks: bool = False) -> list[Line2D]:
        """Return the entries of the legend, those of a cloud with the marks of its points."""
        return [
            Line2D([], [], label=_joined(self.line_axes, values), ms=4.0,
                   **(style if marks else line_of(style)))
            for values, style in self.styles.items()
        ]  # fmt: skip


def line_of(style: Mapping[str, Any]) -> dict[str, Any]:
    """Return a style for lines alone."""
    return {**style, "marker": ""}


def groups_of(table: pd.DataFrame, columns: Sequence[str]) -> list[tuple[Any, pd.DataFrame]]:
    """Return the rows with equal values in some columns, in the order of their first rows."""
    return list(table.groupby(list(columns), sort=False))


def _groups(table: pd.DataFrame, axes: Sequence[Axis]) -> list[tuple[Any, pd.DataFrame]]:
    return list(table.groupby([axis.name for axis in axes])) if axes else [((), table)]


def _joined(axes: Sequence[Axis], values: Sequence[Any]) -> str:
    return ", ".join(map(named_value, axes, values))
