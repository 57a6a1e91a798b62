"""Appearance of figures and page: units and names of values, layout of variants, verdicts.

The hue of a verdict shows its direction (blue lower, vermilion higher). The two hues are distinct
in all common kinds of colour blindness (Okabe and Ito 2008), and a sign repeats the meaning.
"""

import re
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from importlib.resources import files
from inspect import isroutine
from typing import Any, Final, NamedTuple

import jinja2
import numpy as np
import pandas as pd
import yaml
from matplotlib.axis import Axis as DrawnAxis
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from skewbridge.demands.columns import label_of, unit_of
from skewbridge.fragility import verdicts
from skewbridge.units import Units, us_unit
from skewbridge.variant.axes import Axis, axes_of
from skewbridge.variant.variant import lacking_axes

#: Colours of variants, runs and motions in the order of their values, in figures and on the page.
#: They differ in lightness for every kind of colour vision, and from the colours of verdicts.
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
#: Templates of texts: figures by kind, answer (``sentences``) and page (``page``).
TEXTS: Final[Mapping[str, Mapping[str, str]]] = yaml.safe_load(
    (files("skewbridge.report") / "captions.yaml").read_text("utf-8")
)
#: Largest number of bands in a panel: more would hide each other.
MAX_BANDS: Final = 2
_MANY: Final = 2000.0  # ratio of the ends of an axis above which only decades have ticks
_LEAST_SHOWN: Final = 3  # number of axes that name a variant, even if constant

_UNITS: ContextVar[str] = ContextVar("units", default="si")

type Row = Mapping[Any, Any] | pd.Series


# --- units and words of values


@contextmanager
def shown_in(units: Units) -> Generator[None]:
    """Show numbers of figures and page in these units inside the context; tables stay in SI."""
    token = _UNITS.set(units)
    try:
        yield
    finally:
        _UNITS.reset(token)


def shown_unit(unit: str, name: str = "") -> tuple[str, float]:
    """Return the unit in which numbers are shown, and the factor to it; see `us_unit`."""
    return us_unit(unit, name) if _UNITS.get() == "us" else (unit, 1.0)


def bridge_unit() -> tuple[str, float]:
    """Return the unit of the lengths of a bridge, m or ft, and the factor from m."""
    return shown_unit("m", "length")


def shown_length(length_m: float) -> str:
    """Return a length of a bridge in m or ft."""
    unit, per_m = bridge_unit()
    return f"{per_m * length_m:.1f} {unit}"


def shown_label(column: str) -> tuple[str, float]:
    """Return the label of a column with the shown unit, and the factor to that unit."""
    unit = unit_of(column)
    display_unit, factor = shown_unit(unit)
    return label_of(column).replace(f"({unit})", f"({display_unit})"), factor


def plain_label(column: str) -> str:
    """Return the label of a column without LaTeX markup."""
    return re.sub(r"\$|\\mathrm|[{}_]", "", label_of(column).replace(r"\,", " "))


def demand_name(demand: str) -> str:
    """Return the label of a demand without its unit."""
    return label_of(demand).split(" (")[0]


def shear_model_name(demand: str) -> str:
    """Return the name of the shear model of a demand: ``SDC, expected materials``."""
    return label_of(demand).partition(", ")[2]


def in_words(name: object) -> str:
    """Return a component, limit state or status in words: ``DCR 1.00`` for ``dcr_100``."""
    return re.sub(r"\bdcr (\d)(\d\d)\b", r"DCR \1.\2", str(name).replace("_", " "))


def shown_value(demand: str, value: float) -> tuple[float, str]:
    """Return a demand converted to its display unit (%, mm, mrad), and a space with that unit."""
    if demand.endswith("drift_ratio"):
        return 100.0 * value, " %"
    unit = unit_of(demand)
    per_unit, display_unit = {"m": (1000.0, "mm"), "rad": (1000.0, "mrad")}.get(unit, (1.0, unit))
    shown, factor = shown_unit(display_unit)
    return factor * per_unit * value, f" {shown}".rstrip()


def with_unit(text: str, name: str) -> str:
    """Return a number in text form with the unit of its column, if it has one."""
    return f"{text} {unit_of(name)}".rstrip()


def number(value: float, digits: int = 3) -> str:
    """Return a number with significant digits, without an exponent if it is large."""
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text


def threshold_text(demand: str, threshold: float) -> str:
    """Return the capacity of a limit state in its display unit as text."""
    value, unit = shown_value(demand, threshold)
    return f"{number(value)}{unit}"


def reach_text(row: Row) -> str:
    """Return the largest demand of a variant, and the capacity that no run reaches, as text."""
    # `reach` has the largest demand in the unit of the table
    demand, (largest,) = row["demand"], re.findall(r"largest ([^,]+),", row["reach"])
    largest, state = (threshold_text(demand, float(v)) for v in (largest, row["threshold"]))
    return f"{demand_name(demand)}: largest {largest}, state at {state}"


def value_text(axis: Axis, value: float) -> str:
    """Return a value of an axis with its unit, such as ``30°`` or ``51 mm``."""
    if axis.unit in ("-", "deg"):
        return f"{value:g}" + ("°" if axis.unit == "deg" else "")
    display_unit, factor = shown_unit(axis.unit)
    return f"{value:g} {display_unit}" if factor == 1.0 else f"{factor * value:.3g} {display_unit}"


def named_value(axis: Axis, value: float) -> str:
    """Return a value of an axis with its name, such as ``gap 51 mm``."""
    return f"{axis.symbol or axis.label.lower()} {value_text(axis, value)}"


def variant_text(axes: Iterable[Axis], row: Row) -> str:
    """Return the values of a variant on those axes that it has, such as ``skew 30°, gap 51 mm``."""
    lacking = lacking_axes(str(row["abutment"]))
    return ", ".join(named_value(axis, row[axis.name]) for axis in axes if axis.name not in lacking)


def shown_axes(table: pd.DataFrame) -> tuple[Axis, ...]:
    """Return the axes that vary in a table; if fewer than three do, constant axes are added."""
    axes = axes_of(table.columns)
    constant = [axis for axis in axes if table[axis.name].nunique() < 2]
    n_constant = max(_LEAST_SHOWN - (len(axes) - len(constant)), 0)
    left_out = {axis.name for axis in constant[n_constant:]}
    return tuple(axis for axis in axes if axis.name not in left_out)


def templates(*namespaces: Mapping[str, Any]) -> jinja2.Environment:
    """Return the environment of all templates; functions of modules serve as functions and filters.

    ``namespaces`` are ``vars(module)``; of equal names, the last one counts.
    """
    autoescape = jinja2.select_autoescape(("html.j2", "css.j2"), default_for_string=False)
    texts = jinja2.DictLoader({f"{name}.html.j2": text for name, text in TEXTS["page"].items()})
    loader = jinja2.ChoiceLoader([jinja2.PackageLoader("skewbridge.report"), texts])
    environment = jinja2.Environment(
        loader=loader, autoescape=autoescape, undefined=jinja2.StrictUndefined
    )
    for namespace in namespaces:
        functions = {name: value for name, value in namespace.items() if isroutine(value)}
        environment.globals.update(functions)
        environment.filters.update(functions)
    return environment


def one_line(environment: jinja2.Environment, text: str, **values: Any) -> str:
    """Return a template filled in with values, as one line of text."""
    return " ".join(environment.from_string(text).render(values).split())


def groups_of(table: pd.DataFrame, columns: Sequence[str]) -> list[tuple[Any, pd.DataFrame]]:
    """Return the groups of rows with equal values in some columns, each with these values."""
    return list(table.groupby(list(columns), sort=False))


# --- ticks of figures


def plain_log_ticks(axis: DrawnAxis) -> None:
    """Label a logarithmic axis with plain numbers at 1, 2 and 5 (over many decades only at 1)."""
    low, high = axis.get_view_interval()
    many_decades = high > _MANY * low > 0.0

    def plain(value: float, _position: int) -> str:
        return np.format_float_positional(value, precision=2, fractional=False, trim="-")

    axis.set_major_locator(LogLocator(subs=(1.0,) if many_decades else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(plain))
    axis.set_minor_locator(NullLocator())


# --- verdicts


class VerdictStyle(NamedTuple):
    """Appearance of one verdict."""

    name: str  # CSS class on the page
    sign: str
    fill: str  # background colour
    ink: str  # text colour
    text: str  # text of the legend


_DARK, _LIGHT = "#1c2226", "#ffffff"
_OPEN_TEXT: Final = "may or may not exceed the margin"
STYLES: Final = {
    style.name: style
    for style in (
        VerdictStyle(verdicts.LOWER, "▼", "#0072b2", _LIGHT, "lower by more than the margin"),
        VerdictStyle("down", "▽", "#cfe5f3", _DARK, f"lower, {_OPEN_TEXT}"),
        VerdictStyle("within", "=", "#e3e7ea", _DARK, "within the margin"),
        VerdictStyle("up", "△", "#fbdcc5", _DARK, f"higher, {_OPEN_TEXT}"),
        VerdictStyle(verdicts.HIGHER, "▲", "#b84f00", _LIGHT, "higher by more than the margin"),
        VerdictStyle(
            verdicts.UNDECIDED, "?", "#ffffff", "#4a545c", "inconclusive with these motions"
        ),
        VerdictStyle(verdicts.NOT_ESTIMABLE, "–", "#f4f4f4", "#596168", "not estimable"),
    )
}


def verdict_style(effect: Row) -> VerdictStyle:
    """Return the style of an effect, which depends on its family-wise verdict and direction."""
    if effect["status"] != verdicts.OK:
        return STYLES[verdicts.NOT_ESTIMABLE]
    verdict = str(effect["verdict_family"])
    direction = "down" if _change(effect)[0][0] < 0.0 else "up"
    names = {verdicts.NEGLIGIBLE: "within", verdicts.DETECTABLE: direction}
    return STYLES[names.get(verdict, verdict)]


def change_text(effect: Row) -> str:
    """Return the size of an effect: the ratio as a change in per cent, or the difference."""
    if effect.get("status") in (verdicts.NO_CURVE, verdicts.NOT_ESTIMABLE):
        return in_words(effect["status"])
    (value, *_), unit = _change(effect)
    return _signed(value, unit)


def interval_text(effect: Row) -> str:
    """Return the interval of an effect: in per cent for a ratio, in its unit for a difference."""
    (_, *limits), unit = _change(effect)
    if not np.isfinite(limits).all():
        return "no interval"
    low, high = (_signed(limit, unit) for limit in limits)
    return f"{low.removesuffix(unit)} to {high}"


def _change(item: Row) -> tuple[list[float], str]:
    """Return an effect with the ends of its interval, and their unit (per cent for a ratio)."""
    if item.get("judged_by") == verdicts.DIFFERENCE:
        unit, factor = shown_unit(str(item["unit"]))
        return [factor * float(item[name]) for name in verdicts.DIFFERENCES], f" {unit}"
    return [100.0 * (float(item[name]) - 1.0) for name in verdicts.RATIOS], " %"


def margin_text(effect: Row) -> str:
    """Return the margin of an effect with its unit, without a sign."""
    if effect.get("judged_by") == verdicts.DIFFERENCE:
        unit, factor = shown_unit(str(effect["unit"]))
        return f"{factor * effect['difference_margin']:.3g} {unit}"
    return f"{100 * effect['margin']:g} %"


def _signed(value: float, unit: str) -> str:
    """Return a number with its sign and unit, with up to two decimals for small numbers."""
    if not np.isfinite(value):
        return "–"
    digits = 2
    if abs(value) > 9.5:
        digits = 0
    elif abs(value) > 0.95 or unit == " %":
        digits = 1
    # adding zero turns a rounded -0.0 into 0.0
    return f"{round(value, digits) + 0:+.{digits}f}{unit}"
