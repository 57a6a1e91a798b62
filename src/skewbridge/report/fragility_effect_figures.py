"""Figures of the paired effects: the verdict map and the ratios with their intervals."""

from collections.abc import Hashable, Mapping, Sequence
from itertools import cycle
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter

from skewbridge.fragility.tables.verdicts import HIGHER, LOWER, RATIO
from skewbridge.report.axis_layout import MARKS, named_value, short_value, shown_axes
from skewbridge.report.fragility_style import STYLE, note
from skewbridge.report.verdict_style import (
    LEGEND,
    change_text,
    demand_name,
    margin_text,
    verdict_style,
)
from skewbridge.variant.axes import Axis, axes_of

_MOST: Final = 0.95  # of the intervals lie within the axis of ratios
_LEGEND_COLUMNS: Final = 6
_RATIO_RANGE: Final = (0.5, 2.0)
_RATIO_TICKS: Final = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5, 2.0)
_FINE_TICKS: Final = tuple(round(0.05 * i, 2) for i in range(14, 28))
_ROW_IN: Final = 0.42  # height of a demand in the figure of ratios, and the least of one ratio
_MARK_IN: Final = 0.0525
_WIDE_LABEL: Final = 8  # letters that fit under one column of the verdict map
_COLUMN_LETTERS: Final = 11  # the same in the small size
_SMALL_SIZE: Final = 7.5


def verdict_map(effects: pd.DataFrame, axis: str = "friction") -> Figure:
    """Draw for every demand and variant the verdict on the effect of the axis, with the effect.

    Args:
        effects: Table of `skewbridge.fragility.tables.effects.paired_effects`.
        axis: Column of the axis that differs.
    """
    table = _pairs_along(effects, axis)
    others = _other_axes(effects, axis)
    keys = ["bridge", "abutment", *(other.name for other in others), "from_value", "to_value"]
    columns = table[keys].drop_duplicates().sort_values(keys).reset_index(drop=True)
    rows = list(dict.fromkeys(table["demand"]))
    found = table.set_index([*keys, "demand"])
    labels = _column_labels(columns, others)
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        width = 2.6 + 0.72 * len(columns)
        figure = Figure(figsize=(max(width, 5.0), 1.9 + 0.3 * len(rows)), layout="constrained")
        axes = figure.subplots()
        for x, key in enumerate(columns.itertuples(index=False, name=None)):
            for y, demand in enumerate(rows):
                _verdict_cell(axes, x, y, found.loc[(*key, demand)])
        axes.set_xlim(-0.5, len(columns) - 0.5)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        margins = table.drop_duplicates("demand").to_dict("records")
        ratios = [item for item in margins if item["judged_by"] == RATIO]
        usual = margin_text(ratios[0]) if ratios else ""
        axes.set_yticks(range(len(rows)), [_row_label(item, usual) for item in margins])
        axes.set_xticks(range(len(columns)), labels)
        axes.tick_params(length=0)
        if any(len(line) > _WIDE_LABEL for label in labels for line in label.split("\n")):
            axes.tick_params(axis="x", labelsize=_SMALL_SIZE)
        for spine in axes.spines.values():
            spine.set_visible(False)
        change = f"{_listed(columns['from_value'])} to {_listed(columns['to_value'])}"
        title = f"Change of demand, {_label(axis).lower()} {change}, same motions"
        title = fill(title, 24 + 10 * len(columns))
        figure.suptitle(title, x=0.01, ha="left", fontsize=10)
        handles = verdict_patches(usual)
        figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    return figure


def paired_ratios(effects: pd.DataFrame, axis: str = "friction") -> Figure:
    """Draw the paired ratios of every demand with their intervals against the margin.

    Demands that are judged by their differences are left out. Colours tell apart the values of the
    first other axis that varies, marks those of the second; with the first axis itself, colours
    tell the values that it is changed to.

    Args:
        effects: Table of `skewbridge.fragility.tables.effects.paired_effects`.
        axis: Column of the axis that differs.
    """
    table = _pairs_along(effects, axis)
    table = table[table["ratio"].notna() & (table["judged_by"] == RATIO)]
    if table.empty:
        return note(f"No pair of variants that differ in {axis} only is judged by a ratio")
    demands = list(dict.fromkeys(table["demand"]))
    told = _told_apart(effects, axis)
    others = [other.name for other in _other_axes(effects, axis)]
    order = list(dict.fromkeys([*told, *others]))
    looks = _looks(table, told)
    per_demand = len(table) / len(demands)
    with mpl.rc_context(STYLE):
        row_in = max(_ROW_IN, _MARK_IN * per_demand)
        figure = Figure(figsize=(6.2, 1.7 + row_in * len(demands)), layout="constrained")
        axes = figure.subplots()
        margin = float(table["margin"].iloc[0])
        axes.axvspan(1 - margin, 1 + margin, color="#cfe3f5", zorder=0)
        axes.axvline(1.0, color="#777777", linewidth=0.8)
        reach = _ratio_range(table)
        for y, demand in enumerate(demands):
            part = table[table["demand"] == demand].sort_values(order)
            offsets = np.linspace(-0.32, 0.32, len(part)) if len(part) > 1 else [0.0]
            for offset, item in zip(offsets, part.to_dict("records"), strict=True):
                look = {kind: shown[item[name]] for name, (kind, shown) in looks.items()}
                _ratio_mark(axes, item, y + offset, look, reach)
            _name_ratios_beyond(axes, part["ratio"], y, reach)
        _scale_ratios(axes, reach)
        axes.set_yticks(range(len(demands)), [demand_name(name) for name in demands])
        axes.set_ylim(len(demands) - 0.5, -0.5)
        axes.grid(axis="y", visible=False)
        start = table["from_value"].iloc[0]
        ends = _listed(table["to_value"])
        level = 100 * float(table["level"].iloc[0])
        axes.set_xlabel(f"Demand at {_label(axis).lower()} {ends} over demand at {start:g}")
        axes.set_title(
            f"Same motions, geometric mean and {level:g} % interval", loc="left", fontsize=9
        )
        handles = [
            _legend_mark(part, look, axis if name == "to_value" else name, value)
            for name, (part, shown) in looks.items()
            for value, look in shown.items()
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=_LEGEND_COLUMNS)
    return figure


def _legend_mark(part: str, look: Any, axis: str, value: float) -> Line2D:
    style: dict[str, Any] = {"marker": "o", "color": "#444444", part: look}
    return Line2D([], [], linestyle="", label=named_value(axes_of([axis])[0], value), **style)


def _looks(table: pd.DataFrame, told: Sequence[str]) -> dict[str, tuple[str, dict[float, Any]]]:
    """Return which part of a mark the values of a column have, and how it looks."""
    looks: dict[str, tuple[str, dict[float, Any]]] = {}
    for name, part in zip(told, ("color", "marker"), strict=False):
        values = sorted(table[name].unique())
        shown = sns.color_palette("viridis", len(values) + 1) if part == "color" else cycle(MARKS)
        looks[name] = part, dict(zip(values, shown, strict=False))
    return looks


def verdict_patches(margin: str) -> list[Patch]:
    """Return the entries of a legend for the verdicts; ``margin`` may be empty."""
    return [
        Patch(
            facecolor=style.fill,
            edgecolor="#9a9a9a",
            label=f"{style.sign} {style.words(margin)}",
        )
        for style in LEGEND
    ]


def _row_label(item: Mapping[Hashable, Any], usual: str) -> str:
    name, margin = demand_name(str(item["demand"])), margin_text(item)
    if item["judged_by"] == RATIO:
        return name if margin == usual else f"{name}, ±{margin}"
    return f"{name} ({item['unit']}), ±{margin.removesuffix(' ' + item['unit'])}"


def _pairs_along(effects: pd.DataFrame, axis: str) -> pd.DataFrame:
    return effects[(effects["axis"] == axis) & (effects["scope"] == "variant")]


def _other_axes(effects: pd.DataFrame, axis: str) -> list[Axis]:
    """Return the axes that tell apart the pairs along one axis."""
    pairs = effects[effects["scope"] == "variant"]
    return [other for other in shown_axes(pairs) if other.name != axis]


def _label(axis: str) -> str:
    return axes_of([axis])[0].label_with_unit


def _told_apart(effects: pd.DataFrame, axis: str) -> list[str]:
    """Return the columns whose values have colours and marks of their own."""
    own = _pairs_along(effects, axis)
    others = [other.name for other in _other_axes(effects, axis)]
    varying = [name for name in others if own[name].nunique() > 1]
    first = ["to_value"] if axis == shown_axes(effects)[0].name else []
    return [*first, *varying][:2] or others[:1]


def _scale_ratios(axes: Axes, reach: tuple[float, float]) -> None:
    axes.set_xscale("log")
    low, high = reach
    axes.set_xlim(low, high)
    ticks = _FINE_TICKS if low > _FINE_TICKS[0] and high < _FINE_TICKS[-1] else _RATIO_TICKS
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(NullLocator())


def _listed(values: pd.Series) -> str:
    return ", ".join(f"{value:g}" for value in sorted(values.unique()))


def _verdict_cell(axes: Axes, x: int, y: int, item: pd.Series) -> None:
    style = verdict_style(item)
    corner = x - 0.48, y - 0.46
    axes.add_patch(Rectangle(corner, 0.96, 0.92, facecolor=style.fill, edgecolor="#ffffff"))
    bold = "bold" if item["verdict"] in (LOWER, HIGHER) else "normal"
    change = change_text(item)
    if item["judged_by"] != RATIO:  # the label of the row has the unit
        change = change.removesuffix(f" {item['unit']}")
    text = f"{style.sign} {change}"
    axes.text(
        x, y, text, ha="center", va="center", color=style.ink,
        fontsize=_SMALL_SIZE, fontweight=bold,
    )  # fmt: skip


def _ratio_range(table: pd.DataFrame) -> tuple[float, float]:
    """Return the range of the axis: as far as most intervals reach, at most half to double."""
    ends = [table[name].fillna(table["ratio"]) for name in ("ci_low", "ci_high")]
    margin = float(table["margin"].iloc[0])
    low = min(float(ends[0].quantile(1.0 - _MOST)), 1 - 2 * margin)
    high = max(float(ends[1].quantile(_MOST)), 1 + 2 * margin)
    return max(low / 1.02, _RATIO_RANGE[0]), min(high * 1.02, _RATIO_RANGE[1])


def _ratio_mark(
    axes: Axes,
    item: Mapping[Hashable, Any],
    y: float,
    look: Mapping[str, Any],
    reach: tuple[float, float],
) -> None:
    """Draw a ratio with its interval; beyond the axis as an arrow."""
    low, high = reach
    ratio = float(item["ratio"])
    axes.plot([item["ci_low"], item["ci_high"]], [y, y], color=look["color"], lw=1.4)
    beyond = ">" if ratio > high else "<" if ratio < low else ""
    style: dict[str, Any] = {"marker": "o", "ms": 3.2, **look}
    if beyond:
        style |= {"marker": beyond, "ms": 5.0}
    axes.plot(float(np.clip(ratio, low, high)), y, clip_on=not beyond, **style)


def _name_ratios_beyond(
    axes: Axes, ratios: pd.Series, y: float, reach: tuple[float, float]
) -> None:
    """Write beside the axis which ratios of a demand lie beyond it."""
    low, high = reach
    told: list[str] = []
    for beyond, arrow in ((ratios[ratios < low], "◀"), (ratios[ratios > high], "▶")):
        if not beyond.empty:
            ends = dict.fromkeys(f"{end:.2g}" for end in (beyond.min(), beyond.max()))
            told.append(f"{arrow} {' to '.join(ends)}")
    if told:
        across = axes.get_yaxis_transform()
        axes.text(1.02, y, "\n".join(told), transform=across, va="center", fontsize=7)


def _column_labels(columns: pd.DataFrame, others: Sequence[Axis]) -> list[str]:
    out: list[str] = []
    several = columns["to_value"].nunique() > 1
    for item in columns.to_dict("records"):
        texts = [short_value(axis, item[axis.name], others) for axis in others]
        if several:
            texts.append(f"→ {item['to_value']:g}")
        if columns["bridge"].nunique() > 1:
            texts.append(str(item["bridge"]))
        out.append("\n".join(fill(text, _COLUMN_LETTERS) for text in texts))
    return out
