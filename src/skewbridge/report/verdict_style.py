"""Colours, signs and words of the verdicts, the same in the page and in the figures.

The hue is the direction (blue lower, vermilion higher), the depth the distance of the effect from
its margin. All common kinds of colour blindness distinguish the two hues (Okabe and Ito 2008), and
a sign repeats the meaning of the colour.
"""

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.fragility.verdicts import (
    DETECTABLE,
    DIFFERENCE,
    HIGHER,
    LOWER,
    NEGLIGIBLE,
    NO_CURVE,
    NOT_ESTIMABLE,
    OK,
    UNDECIDED,
)
from skewbridge.report.axis_layout import in_words, shown_unit

#: Effects in units of the margin from which a colour is deeper.
DEPTHS: Final = (2.0, 5.0)

type Row = Mapping[Any, Any] | pd.Series


class VerdictStyle(NamedTuple):
    """Appearance of one verdict."""

    name: str  # of its class in the page
    sign: str
    fill: str  # colour of the cell
    ink: str  # colour of its text
    verdict: str
    text: str  # of the legend; ``{margin}`` holds the margin

    def words(self, margin: str = "") -> str:
        """Return the words of the legend, with a margin or with "the margin"."""
        if margin:
            return self.text.format(margin=margin)
        return self.text.replace("±{margin}", "{margin}").format(margin="the margin")


_DARK, _LIGHT = "#1c2226", "#ffffff"
_LOWER_TEXT, _HIGHER_TEXT = "lower by over {margin}", "higher by over {margin}"
_OPEN_TEXT: Final = "{}, may or may not exceed {{margin}}"
STYLES: Final = {
    style.name: style
    for style in (
        VerdictStyle("lower3", "▼", "#00466e", _LIGHT, LOWER, _LOWER_TEXT),
        VerdictStyle("lower2", "▼", "#0072b2", _LIGHT, LOWER, _LOWER_TEXT),
        VerdictStyle("lower1", "▼", "#6db3dc", _DARK, LOWER, _LOWER_TEXT),
        VerdictStyle("down", "▽", "#cfe5f3", _DARK, DETECTABLE, _OPEN_TEXT.format("lower")),
        VerdictStyle("within", "=", "#e3e7ea", _DARK, NEGLIGIBLE, "within ±{margin}"),
        VerdictStyle("up", "△", "#fbdcc5", _DARK, DETECTABLE, _OPEN_TEXT.format("higher")),
        VerdictStyle("higher1", "▲", "#f0a06a", _DARK, HIGHER, _HIGHER_TEXT),
        VerdictStyle("higher2", "▲", "#b84f00", _LIGHT, HIGHER, _HIGHER_TEXT),
        VerdictStyle("higher3", "▲", "#7a3400", _LIGHT, HIGHER, _HIGHER_TEXT),
        VerdictStyle(
            "undecided", "?", "#ffffff", "#4a545c", UNDECIDED, "inconclusive with these motions"
        ),
        VerdictStyle(NOT_ESTIMABLE, "–", "#f4f4f4", "#596168", UNDECIDED, "not estimable"),
    )
}
#: Entries of a legend: one for each class.
LEGEND: Final = tuple(
    STYLES[name]
    for name in ("lower2", "down", "within", "up", "higher2", "undecided", NOT_ESTIMABLE)
)


def verdict_style(item: Row) -> VerdictStyle:
    """Return the style of a row of effects: by family-wise verdict, direction and size."""
    if item["status"] != OK:
        return STYLES[NOT_ESTIMABLE]
    verdict = str(item["verdict_family"])
    if verdict in (LOWER, HIGHER):
        size = abs(in_margins(item)[1])
        return STYLES[f"{verdict}{1 + sum(size >= depth for depth in DEPTHS)}"]
    if verdict == DETECTABLE:
        return STYLES["down" if in_margins(item)[1] < 0.0 else "up"]
    return STYLES["within" if verdict == NEGLIGIBLE else UNDECIDED]


def in_margins(item: Row) -> tuple[float, float, float]:
    """Return lower end, estimate and upper end of an effect in units of the margin on their side.

    Ratios count by their logarithms.
    """
    if item.get("judged_by") == DIFFERENCE:
        names = ("difference_low", "difference", "difference_high")
        low, value, high = (float(item[name]) / item["difference_margin"] for name in names)
        return low, value, high
    logs = [np.log(item[name]) for name in ("ci_low", "ratio", "ci_high")]
    below, above = -np.log1p(-item["margin"]), np.log1p(item["margin"])
    low, value, high = (float(x / (below if x < 0.0 else above)) for x in logs)
    return low, value, high


def demand_name(demand: str) -> str:
    """Return the label of a demand without its unit, or component and state in words."""
    if "/" in demand:
        component, state = in_words(demand).split("/")
        return f"{component.capitalize()}, {state}"
    return label_of(demand).split(" (")[0]


def change_text(item: Row) -> str:
    """Return an effect as it is judged: in per cent, or in its unit."""
    if item.get("status") == NO_CURVE:
        return "no curve"
    if item.get("status") == NOT_ESTIMABLE:
        return "not estimable"
    if item.get("judged_by") == DIFFERENCE:
        unit, factor = shown_unit(str(item["unit"]))
        return signed(factor * float(item["difference"]), f" {unit}")
    return signed(100.0 * (float(item["ratio"]) - 1.0), " %")


def interval_text(item: Row) -> str:
    """Return the interval of the effect as it is judged: in per cent, or in its unit."""
    if item.get("judged_by") == DIFFERENCE:
        shown, factor = shown_unit(str(item["unit"]))
        low, high, unit = item["difference_low"], item["difference_high"], f" {shown}"
    else:
        low, high, unit, factor = item["ci_low"] - 1.0, item["ci_high"] - 1.0, " %", 100.0
    if not (np.isfinite(low) and np.isfinite(high)):
        return "no interval"
    return f"{signed(factor * low, unit).removesuffix(unit)} to {signed(factor * high, unit)}"


def margin_text(item: Row) -> str:
    """Return the margin of a row with its unit, without sign."""
    if item.get("judged_by") == DIFFERENCE:
        unit, factor = shown_unit(str(item["unit"]))
        return f"{factor * item['difference_margin']:.3g} {unit}"
    return f"{100 * item['margin']:g} %"


def signed(value: float, unit: str) -> str:
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
