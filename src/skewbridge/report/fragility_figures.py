"""Fragility curves over their runs and clouds of demand: tables in, matplotlib figures out."""

from collections import Counter
from collections.abc import Mapping
from operator import itemgetter
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.demands.columns import label_of
from skewbridge.demands.completeness import is_beyond_model, is_complete
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.old_likelihood.intervals import curve, curve_band
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.tables.beyond_model import is_of_column
from skewbridge.fragility.tables.limit_states import COLLAPSE_EXCEEDS
from skewbridge.report.axis_layout import VariantLayout, line_of, threshold_text
from skewbridge.report.fragility_style import STYLE, note, plain_log_ticks, plain_number
from skewbridge.report.sampled_runs import sample_note, sampled_runs
from skewbridge.statuses import COLLAPSE

_LEGEND_COLUMNS: Final = 4
_ABOVE_ZERO: Final = 1e-300
_TITLE_PAD_PT: Final = 6.0  # between a panel and its title
_NOTE_LINE_PT: Final = 9.0  # for each line of a note between the two
_NAME_ROOM: Final = 0.05  # part of the height of a panel that the name of a state takes
_FAR_BELOW: Final = 300.0  # parts of the first limit state: a demand below is as good as none


def fragility_curves(
    curves: pd.DataFrame, demands: pd.DataFrame, component: str, method: str = "cloud"
) -> Figure:
    """Draw the curves of a component with their bands, over the runs they come from.

    A row of panels per limit state with at least one curve or bracketed median, a column as
    `VariantLayout` has it. Where the outcomes are separated a bar at P = 0.5 spans the levels
    between which the median lies, a thin line its one-sided bounds for the assumed dispersion.
    Ticks at the bottom are runs that do not exceed, at the top runs that do (collapse included,
    where the limit state counts it); a run beyond the model has none where its outcome is unknown.
    The band is the pointwise interval of the curve; a thin line is one with a warning (saturating
    demand, extrapolated median). The dispersion is the total one, that of the capacity included.

    Args:
        curves: Table of `skewbridge.fragility.tables.curves.fit_study`.
        demands: The demands it was fitted to.
        component: Component to draw.
        method: ``cloud``, ``exceedance`` or ``ida_interval``.
    """
    table = curves[(curves["component"] == component) & (curves["method"] == method)]
    told = (table["status"] == FITTED) | table["theta_bracket_low"].notna()
    names = list(dict.fromkeys(table.loc[told, "limit_state"]))
    if not names:
        found = ", ".join(_counted(table["status"])) or "no rows"
        return note(f"No fragility curve of {component}: {found}")
    im_column = str(table["im"].iloc[0])
    im = demands[im_column].to_numpy(dtype=np.float64)
    grid = np.geomspace(0.7 * im.min(), 1.3 * im.max(), 160)
    layout = VariantLayout.of(table)
    columns = layout.panels(table)
    with mpl.rc_context(STYLE):
        size = 2.6 * len(columns) + 0.9, 2.1 * len(names) + 0.9
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(names), len(columns), squeeze=False, sharex=True, sharey=True)
        above = 0
        for row, name in zip(panels, names, strict=True):
            for axes, (_, own) in zip(row, columns, strict=True):
                part = own[own["limit_state"] == name]
                lines = _curve_panel(axes, part, demands, grid, layout)
                above = max(above, lines) if name == names[0] else above
                axes.set_xscale("log")
                axes.set_ylim(-0.06, 1.06)
            state = table[table["limit_state"] == name].iloc[0]
            capacity = threshold_text(str(state["demand"]), float(state["threshold"]))
            row[0].set_ylabel(f"P(exceeds | IM)\n{str(name).replace('_', ' ')}: {capacity}")
        for axes, (title, _) in zip(panels[0], columns, strict=True):
            axes.set_title(title, fontsize=9, pad=_TITLE_PAD_PT + _NOTE_LINE_PT * above)
        for axes in panels[-1]:
            axes.set_xlabel(label_of(im_column))
        plain_log_ticks(panels[-1, 0].xaxis)
        _add_legend(figure, layout)
        title = f"{component.replace('_', ' ').capitalize()}: {method} fits"
        level = float(table["level"].iloc[0])
        figure.suptitle(f"{title}, {100 * level:g} % bands", x=0.01, ha="left", fontsize=10)
    return figure


def demand_clouds(demands: pd.DataFrame, curves: pd.DataFrame, demand: str) -> Figure:
    """Draw demand over the intensity of the fits, log-log, with fitted lines and thresholds.

    Runs that did not complete are drawn open, at their peak so far. Of a large study a sample of
    the runs is drawn, and the figure says so. The axis of the demand shows what matters beside the
    limit states; how many runs lie below it stands in the panel.

    Args:
        demands: Demands table.
        curves: Fits, for lines and thresholds of this demand.
        demand: Demand column.
    """
    fits = curves[(curves["demand"] == demand) & (curves["method"] == "cloud")]
    thresholds = dict(zip(fits["limit_state"], fits["threshold"], strict=True))
    im_column = str(curves["im"].iloc[0])
    layout, shown = VariantLayout.of(demands), sampled_runs(demands)
    columns = layout.panels(shown)
    least = _least_shown(demands[demand], thresholds)
    if not (demands[demand] >= max(least, _ABOVE_ZERO)).any():
        return note(f"{label_of(demand)}: in no analysis above {plain_number(least)}")
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.6 * len(columns) + 0.9, 3.3), layout="constrained")
        if said := sample_note(len(shown), len(demands)):
            figure.suptitle(said, x=0.01, ha="left", fontsize=9)
        panels = figure.subplots(1, len(columns), squeeze=False, sharex=True, sharey=True)[0]
        told = _count_below(shown[demand], least)
        for axes, (title, own) in zip(panels, columns, strict=True):
            for part, style in layout.lines(own):
                _cloud_points(axes, part[part[demand] >= least], demand, im_column, style)
                line = fits[fits["variant"].isin(part["variant"])].head(1)
                _cloud_line(axes, line, part[im_column], style)
            _draw_thresholds(axes, thresholds)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_title(title, fontsize=9, pad=_TITLE_PAD_PT + _NOTE_LINE_PT * bool(told))
            if below := _count_below(own[demand], least):
                axes.text(0.5, 1.02, below, transform=axes.transAxes, fontsize=7, ha="center")
            axes.set_xlabel(label_of(im_column))
        panels[0].set_ylabel(label_of(demand))
        plain_log_ticks(panels[0].xaxis)
        im = demands[im_column]
        panels[0].set_xlim(im.min() / 1.15, im.max() * 1.15)
        panels[0].set_ylim(least / 1.3, max([demands[demand].max(), *thresholds.values()]) * 1.6)
        plain_log_ticks(panels[0].yaxis)
        _name_thresholds(panels[-1], thresholds)
        _add_legend(figure, layout, marks=True)
    return figure


def _least_shown(values: pd.Series, thresholds: Mapping[str, float]) -> float:
    """Return the smallest demand that is drawn, which lies not far below the first state."""
    positive = values[values > 0.0]
    smallest = float(positive.min()) if len(positive) else 0.0
    return max(smallest, min(thresholds.values(), default=0.0) / _FAR_BELOW)


def _count_below(values: pd.Series, least: float) -> str:
    """Return what is said of the runs below the axis; empty where there is none."""
    below = int((~(values >= least)).sum())
    return f"{below} of {len(values)} analyses below {plain_number(least)}" if below else ""


def _add_legend(figure: Figure, layout: VariantLayout, *, marks: bool = False) -> None:
    handles = layout.handles(marks=marks)
    columns = min(len(handles), _LEGEND_COLUMNS)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, handlelength=3.2)


def _curve_panel(
    axes: Axes, part: pd.DataFrame, demands: pd.DataFrame, grid: FloatArray, layout: VariantLayout
) -> int:
    """Draw the curves of one state; return how many lines above the panel tell what is missing."""
    missing: list[str] = []
    for item in part.to_dict("records"):
        style = layout.style_of(item)
        runs = demands[demands["variant"] == item["variant"]]
        above = runs[item["demand"]] > item["threshold"]
        if item["collapse_rule"] == COLLAPSE_EXCEEDS:
            above |= runs["status"] == COLLAPSE
        beyond = is_beyond_model(runs)
        above |= beyond & is_of_column(item["demand"])
        below = ~above & ~beyond
        x = runs[item["im"]]
        for hit, height, marker in ((above, 1.03, 2), (below, -0.03, 3)):
            axes.plot(x[hit], np.full(int(hit.sum()), height), marker=marker, ls="", ms=3,
                      color=style["color"], alpha=0.5)  # fmt: skip
        if item["status"] != "ok":
            missing.append(str(item["status"]))
            _median_bracket(axes, item, grid, style["color"])
            continue
        theta, beta, level = item["theta"], total_dispersion(item), item["level"]
        # ASSUME the dispersion of the capacity and the slope are known: beta_total varies with beta
        slope = item["beta"] / beta
        both = item["cov_ln_theta_beta"] * slope
        covariance = np.array([[item["var_ln_theta"], both], [both, item["var_beta"] * slope**2]])
        low, high = curve_band(grid, theta=theta, beta=beta, covariance=covariance, level=level)
        axes.fill_between(grid, low, high, color=style["color"], alpha=0.10, linewidth=0)
        flagged = "saturating" in item["warnings"] or "extrapolated" in item["warnings"]
        line = line_of(style)
        if flagged:
            line |= {"linewidth": 0.6 * line["linewidth"], "alpha": 0.7}
        axes.plot(grid, curve(grid, theta, beta), **line)
    said = _missing_lines(missing)
    text = "\n".join(said)
    look: dict[str, Any] = {"fontsize": 7, "color": "#333333", "linespacing": 1.1}
    axes.text(1.0, 1.02, text, transform=axes.transAxes, ha="right", va="bottom", **look)
    return len(said)


def total_dispersion(item: Mapping[Any, Any]) -> float:
    """Return the dispersion of a curve: with that of the capacity, where the fit knows it."""
    total = float(item["beta_total"])
    return total if np.isfinite(total) else float(item["beta"])


def _median_bracket(axes: Axes, item: Mapping[Any, Any], grid: FloatArray, color: str) -> None:
    """Draw where a median without an estimate lies: bracket of the levels, one-sided bounds."""
    low, high = item["theta_bracket_low"], item["theta_bracket_high"]
    if np.isfinite(low) and np.isfinite(high):
        axes.plot([low, high], [0.5, 0.5], color=color, linewidth=4.0, alpha=0.6,
                  solid_capstyle="butt")  # fmt: skip
    ends = [item["theta_bound_low"], item["theta_bound_high"]]
    if not np.any(np.isfinite(ends)):
        return
    shown = [grid[0] if np.isnan(ends[0]) else ends[0], grid[-1] if np.isnan(ends[1]) else ends[1]]
    axes.plot(np.clip(shown, grid[0], grid[-1]), [0.5, 0.5], color=color, linewidth=0.9)
    for end, marker in zip(ends, ("|", "|"), strict=True):
        if grid[0] <= end <= grid[-1]:
            axes.plot([end], [0.5], marker, color=color, ms=6)


def _cloud_points(
    axes: Axes, part: pd.DataFrame, demand: str, im_column: str, style: Mapping[str, Any]
) -> None:
    done = is_complete(part)
    x, y = part[im_column].to_numpy(), part[demand].to_numpy()
    colour, mark = style["color"], style["marker"]
    axes.plot(x[done], y[done], mark, ms=2.8, color=colour, alpha=0.6, markeredgewidth=0)
    axes.plot(x[~done], y[~done], "^", ms=4, color=colour, markerfacecolor="none")


def _cloud_line(axes: Axes, fit: pd.DataFrame, im: pd.Series, style: Mapping[str, Any]) -> None:
    if fit.empty or not np.isfinite(fit["b"].iloc[0]) or im.empty:
        return
    x = np.geomspace(im.min(), im.max(), 2)
    axes.plot(x, np.exp(fit["ln_a"].iloc[0]) * x ** fit["b"].iloc[0], **line_of(style))


def _draw_thresholds(axes: Axes, thresholds: Mapping[str, float]) -> None:
    for threshold in thresholds.values():
        axes.axhline(threshold, color="#555555", linewidth=0.8, linestyle=(0, (1, 2)), zorder=1)


def _name_thresholds(axes: Axes, thresholds: Mapping[str, float]) -> None:
    """Name the limit states beside a panel, those that lie close with room between them."""
    low, high = np.log(axes.get_ylim())
    last = -np.inf
    for name, threshold in sorted(thresholds.items(), key=itemgetter(1)):
        place = (np.log(threshold) - low) / (high - low)
        if place < 0.0:
            continue
        last = max(place, last + _NAME_ROOM)
        axes.text(
            1.02,
            last,
            name.replace("_", " "),
            transform=axes.transAxes,
            fontsize=7,
            color="#333333",
            va="center",
        )


def _missing_lines(statuses: list[str]) -> list[str]:
    """Return for each reason how many curves are missing."""
    counts = Counter(name.replace("_", " ") for name in statuses)
    return [f"no curve of {count}: {name}" for name, count in counts.most_common()]


def _counted(names: pd.Series) -> list[str]:
    return [f"{count} × {name}" for name, count in names.value_counts().items()]
