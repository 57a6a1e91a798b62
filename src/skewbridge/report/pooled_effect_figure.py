"""Figure of the pooled effects: every demand against its own margin, a panel per change."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, StrMethodFormatter

from skewbridge.report.fragility_effect_figures import verdict_patches
from skewbridge.report.fragility_style import STYLE, note
from skewbridge.report.verdict_style import change_text, demand_name, in_margins, verdict_style
from skewbridge.variant.axes import axes_of

_REACH: Final = 8.0  # margins that the axis shows
_PANELS: Final = 4  # in a row


def pooled_effects(effects: pd.DataFrame) -> Figure:
    """Draw the effect of every change of an axis on every demand, averaged over the other axes.

    Ratios and differences share one scale: the effect in units of its margin, ratios by their
    logarithms.

    Args:
        effects: Table of `skewbridge.fragility.tables.effects.paired_effects`.
    """
    table = effects[effects["scope"] == "pooled"]
    if table.empty:
        return note("No two variants differ in one axis only")
    demands = list(dict.fromkeys(table["demand"]))
    changes = list(table.groupby(["axis", "from_value", "to_value"], sort=False))
    across = min(len(changes), _PANELS)
    down = -(-len(changes) // across)
    with mpl.rc_context(STYLE):
        figure = Figure(
            figsize=(2.6 + 2.6 * across, down * (0.9 + 0.27 * len(demands)) + 0.7),
            layout="constrained",
        )
        panels = figure.subplots(down, across, sharey=True, squeeze=False).ravel()
        for axes, (change, part) in zip(panels, changes, strict=False):
            _panel(axes, change, part.set_index("demand").reindex(demands))
        for axes in panels[len(changes) :]:
            axes.set_visible(False)
        for axes in panels[: len(changes)]:
            axes.set_yticks(range(len(demands)), [demand_name(name) for name in demands])
            axes.set_ylim(len(demands) - 0.5, -0.5)
        level = 100 * float(table["level"].iloc[0])
        figure.suptitle(
            f"Effect over its margin with {level:g} % interval, same motions, all variants",
            x=0.01,
            ha="left",
            fontsize=10,
        )
        handles = verdict_patches("")
        figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    return figure


def _panel(axes: Axes, change: Any, part: pd.DataFrame) -> None:
    name, start, end = change
    axis = axes_of([name])[0]
    axes.set_title(f"{axis.label_with_unit} {start:g} to {end:g}", loc="left", fontsize=9)
    axes.axvspan(-1.0, 1.0, color="#e9eff5", zorder=0)
    axes.axvline(0.0, color="#777777", linewidth=0.8)
    for y, item in enumerate(part.to_dict("records")):
        low, value, high = in_margins(item)
        if not np.isfinite(value):
            continue
        ends = np.clip([low, high], -_REACH, _REACH)
        axes.plot(ends, [y, y], color="#555555", lw=1.2)
        shown = float(np.clip(value, -_REACH, _REACH))
        colour = verdict_style(item).fill
        mark = "o" if abs(value) <= _REACH else ">" if value > 0.0 else "<"
        axes.plot(shown, y, mark, color=colour, mec="#555555", mew=0.6, ms=5.5, clip_on=False)
        axes.text(
            1.05,
            y,
            change_text(item),
            transform=axes.get_yaxis_transform(),
            va="center",
            fontsize=7,
        )
    axes.set_xscale("symlog", linthresh=1.0, linscale=1.0)
    axes.set_xlim(-_REACH, _REACH)
    axes.xaxis.set_major_locator(FixedLocator([-_REACH, -1, 0, 1, _REACH]))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(FixedLocator([-4, -2, 2, 4]))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("Effect over margin")
    axes.grid(axis="y", visible=False)
