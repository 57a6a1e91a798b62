"""Figures of fragility: curves of the states of a component, demands against intensity."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy import special

from skewbridge.demands.validity import is_complete, with_derived_columns
from skewbridge.files.tables import Floats, records_of
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.paper_table import chosen_curves
from skewbridge.report.appearance import (
    STYLE,
    VariantLayout,
    in_words,
    plain_log_ticks,
    shown_label,
    threshold_text,
)

#: Largest number of runs whose marks are drawn as vectors.
MAX_VECTOR_RUNS: Final = 5000
_LEGEND_COLUMN_IN: Final = 1.75
_TITLE_PAD_PT: Final = 6.0  # between a panel and its title
_NOTE_LINE_PT: Final = 9.0  # for each line of a note between the two
_NAME_ROOM: Final = 0.05  # part of the height of a panel that the name of a state takes
_FAR_BELOW: Final = 300.0  # parts of the mildest state below which a demand is drawn at the bottom
_UP: Final = 2  # matplotlib's marker of a tick upward
_NO_MARKER: Final[dict[str, Any]] = {"marker": ""}
_CROSSED: Final = (0.1, 0.3, 0.5, 0.7, 0.9)  # P at which the curve of an exceedance fit has crosses
_GREY: Final = "#39434a"  # of legend entries that stand for lines of any colour


def shown_curves(curves: pd.DataFrame) -> pd.DataFrame:
    """Return one row per variant and state: the preferred curve, else a bracketed median.

    Pairs of variant and state with neither are left out.
    """
    return chosen_curves(curves[curves["preferred"] | curves["theta_bracket_low"].notna()])


def curve_values(im: Floats, row: Mapping[Any, Any]) -> tuple[Floats, Floats]:
    """Return P(exceeds | IM) of a row of curves, shape of ``im``, and its band, shape (2, n).

    The curve includes record-to-record and capacity dispersion. The band is the pointwise
    interval of ln(im/theta)/beta_total, carried through the normal distribution.
    """
    # ASSUME dispersion of the capacity and slope are known, so beta_total varies with beta only
    beta = float(row["beta_total"])
    slope = row["beta"] / beta
    eta = np.log(im / row["theta"]) / beta
    variance = row["var_ln_theta"] + 2.0 * eta * row["cov_ln_theta_beta"] * slope
    variance = np.maximum(variance + eta**2 * row["var_beta"] * slope**2, 0.0)
    reach = special.ndtri(0.5 + 0.5 * row["level"]) * np.sqrt(variance) / beta
    return special.ndtr(eta), special.ndtr(eta + np.array([[-1.0], [1.0]]) * reach)


def fragility_curves(curves: pd.DataFrame, demands: pd.DataFrame, component: str) -> Figure:
    """Draw the preferred curves of a component and the runs behind them.

    A row of panels per limit state with a curve or a bracketed median, a column as in
    `VariantLayout`; the curves of `VariantLayout.banded` have bands, those of exceedance fits
    crosses. A bar at P = 0.5 spans the intensities between which the median of separated outcomes
    lies. Ticks at the bottom are runs that do not exceed, at the top runs that do; a run with an
    unknown outcome has none. An open diamond is the median of the other method where the medians of
    cloud and exceedance differ. States that no run reached are listed at the top.
    The curves have a usable row of the component.
    """
    rows = curves[curves["component"] == component]
    table, demands = shown_curves(rows), with_derived_columns(demands)
    runs = dict(tuple(demands.groupby("variant")))
    names = [name for name in rows["limit_state"].unique() if (table["limit_state"] == name).any()]
    im_column = str(table["im"].iloc[0])
    grid = np.geomspace(0.7 * demands[im_column].min(), 1.3 * demands[im_column].max(), 160)
    layout = VariantLayout.of(rows)
    columns = layout.panels(rows)
    bands = f" ({layout.banded_text})" if layout.banded_text else ""
    title = f"{in_words(component).capitalize()}, {100 * table['level'].iloc[0]:g} % bands{bands}"
    head = [title, *states_out_of_reach(rows, demands)]
    with mpl.rc_context(STYLE):
        size = 2.6 * len(columns) + 0.9, 2.1 * len(names) + 0.74 + 0.16 * len(head)
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(names), len(columns), squeeze=False, sharex=True, sharey=True)
        for row, name in zip(panels, names, strict=True):
            parts = [part[part["limit_state"] == name] for _, part in columns]
            notes = [
                _curve_panel(axes, part, runs, grid, layout)
                for axes, part in zip(row, parts, strict=True)
            ]
            for axes, lines, (title, _) in zip(row, notes, columns, strict=True):
                axes.text(1.0, 1.02, "\n".join(lines), transform=axes.transAxes, ha="right",
                          va="bottom", fontsize=7, color="#333333", linespacing=1.1)  # fmt: skip
                if name == names[0]:
                    pad = _TITLE_PAD_PT + _NOTE_LINE_PT * max(map(len, notes))
                    axes.set_title(title, fontsize=9, pad=pad)
            state = parts[0].iloc[0]
            capacity = threshold_text(str(state["demand"]), float(state["threshold"]))
            row[0].set_ylabel(f"P(exceeds | IM)\n{in_words(name)}: {capacity}")
        for axes in panels[-1]:
            axes.set_xlabel(shown_label(im_column)[0])
        panels[0, 0].set_xscale("log")
        panels[0, 0].set_ylim(-0.06, 1.06)
        plain_log_ticks(panels[0, 0].xaxis)
        _add_legend(figure, [*layout.handles(), *_curve_handles(table)])
        figure.suptitle("\n".join(head), x=0.01, ha="left", fontsize=9)
    return figure


def states_out_of_reach(rows: pd.DataFrame, demands: pd.DataFrame) -> list[str]:
    """Return a sentence per state that no run of a component exceeds, with the largest demand."""
    largest = demands.groupby("variant").max(numeric_only=True)
    sentences: list[str] = []
    for name, own in rows.groupby("limit_state", sort=False):
        if (own["reach"] != "").all():
            peaks = largest[own["demand"].iloc[0]].reindex(own["variant"]).to_numpy()
            sentences.append(f"{in_words(name)}, no curve: {own['reach'].iloc[peaks.argmax()]}")
    return sentences


def _curve_panel(
    axes: Axes,
    rows: pd.DataFrame,
    runs: Mapping[Any, pd.DataFrame],
    grid: Floats,
    layout: VariantLayout,
) -> list[str]:
    """Draw the curves of one state in a panel; return the lines above it.

    ``rows`` are the fits of the panel, and ``runs`` the demands by variant.
    """
    for values, own, style in layout.lines(rows):
        color = style["color"]
        for item in records_of(shown_curves(own)):
            demands = runs[item["variant"]]
            x = demands[item["im"]].to_numpy()
            for hit, y, marker in zip(_outcomes(demands, item), (1.03, -0.03), (2, 3), strict=True):
                axes.plot(x[hit], np.full(int(hit.sum()), y), marker=marker, ls="", ms=3,
                          color=color, alpha=0.5)  # fmt: skip
            if not item["preferred"]:
                ends = [item["theta_bracket_low"], item["theta_bracket_high"]]
                axes.plot(ends, [0.5, 0.5], color=color, linewidth=4.0, alpha=0.6,
                          solid_capstyle="butt")  # fmt: skip
                continue
            p, (low, high) = curve_values(grid, item)
            if values in layout.banded:
                axes.fill_between(grid, low, high, color=color, alpha=0.15, linewidth=0)
            axes.plot(grid, p, **style | _NO_MARKER)
            if item["method"] == "exceedance":
                at = np.searchsorted(p, [each for each in _CROSSED if each < p[-1]])
                axes.plot(grid[at], p[at], "x", ms=6.0, mew=1.2, color=color)
            other = own.loc[~own["preferred"], "theta"].dropna().head(1)
            if item["methods_differ"] and len(other):
                medians = [item["theta"], other.iloc[0]]
                axes.plot(medians, [0.5, 0.5], "-", color=color, linewidth=0.8)
                axes.plot(medians[1], 0.5, "D", ms=4.5, mfc="white", mec=color, zorder=4)
    missing = rows[~rows.groupby("variant")["preferred"].transform("any")]
    missing = missing.drop_duplicates("variant")
    reasons = Counter(
        "no run exceeds" if reach else in_words(status)
        for reach, status in zip(missing["reach"], missing["status"], strict=True)
    )
    total = rows["variant"].nunique()
    return [f"{n} of {total} without a curve: {reason}" for reason, n in reasons.most_common()]


def _outcomes(runs: pd.DataFrame, item: Mapping[Any, Any]) -> tuple[Any, Any]:
    """Return which runs of a variant are known to exceed a state and known not to, each (n,)."""
    state = LimitState(
        component=item["component"],
        name=item["limit_state"],
        demand=item["demand"],
        threshold=item["threshold"],
        dispersion=item["capacity_dispersion"],
        collapse=item["collapse_rule"],
    )
    outcomes = demand_outcomes(runs, [state])
    exceed = outcomes.exceed(state)
    return exceed, ~exceed & ~outcomes.unknown(state)


def _curve_handles(table: pd.DataFrame) -> list[Line2D]:
    """Return the entries of the legend for marks that the drawn fits of a component have."""
    drawn = table[table["preferred"]]
    marks: tuple[tuple[Any, str, dict[str, Any]], ...] = (
        ((drawn["method"] == "exceedance").any(), "exceedance fit", {"marker": "x", "ms": 6.0}),
        (drawn["methods_differ"].any(), "median, other method",
         {"marker": "D", "ms": 4.5, "mfc": "white", "lw": 0.8}),
        (len(drawn) < len(table), "median in this range",
         {"lw": 4.0, "alpha": 0.6, "solid_capstyle": "butt"}),
    )  # fmt: skip
    return [Line2D([], [], color=_GREY, label=label, **look) for on, label, look in marks if on]


def least_shown(demands: pd.DataFrame, curves: pd.DataFrame, demand: str) -> float | None:
    """Return the lower end of the axis of a demand; None where no demand lies above it."""
    values = demands[demand]
    positive = values[values > 0.0]
    mildest = curves.loc[curves["demand"] == demand, "threshold"].min()
    least = max(float(positive.min()), mildest / _FAR_BELOW) if len(positive) else np.inf
    return least if (values >= least).any() else None


def demand_clouds(demands: pd.DataFrame, curves: pd.DataFrame, demand: str) -> Figure:
    """Draw demand over the intensity of the fits, log-log, with fitted lines and thresholds.

    Open marks with a tick upward are runs that ended early: the demand is a lower bound. Marks at
    the bottom are demands of zero, or far below the mildest state; their number is above the panel.
    """
    demands = with_derived_columns(demands)
    label, factor = shown_label(demand)
    fits = curves[(curves["demand"] == demand) & (curves["method"] == "cloud")]
    least = factor * (least_shown(demands, fits, demand) or 1.0)
    demands = demands.assign(**{demand: factor * demands[demand]})
    thresholds = dict(zip(fits["limit_state"], factor * fits["threshold"], strict=True))
    im_column = str(curves["im"].iloc[0])
    layout = VariantLayout.of(demands)
    columns = layout.panels(demands)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.6 * len(columns) + 0.9, 3.3), layout="constrained")
        panels = figure.subplots(1, len(columns), squeeze=False, sharex=True, sharey=True)[0]
        any_below, is_large = (demands[demand] < least).any(), len(demands) > MAX_VECTOR_RUNS
        for axes, (title, own) in zip(panels, columns, strict=True):
            for _, part, style in layout.lines(own):
                look = style | {"linestyle": "", "rasterized": is_large}
                _cloud_points(axes, part, im_column, demand, least, look)
                line = fits[fits["variant"].isin(part["variant"])].head(1)
                if len(line) and np.isfinite(line["b"].iloc[0]):
                    x = np.geomspace(part[im_column].min(), part[im_column].max(), 2)
                    y = factor * np.exp(line["ln_a"].iloc[0]) * x ** line["b"].iloc[0]
                    axes.plot(x, y, **style | _NO_MARKER)
            for threshold in thresholds.values():
                axes.axhline(threshold, color="#555555", lw=0.8, ls=(0, (1, 2)), zorder=1)
            axes.set_title(title, fontsize=9, pad=_TITLE_PAD_PT + _NOTE_LINE_PT * any_below)
            if below := int((own[demand] < least).sum()):
                limit = threshold_text(demand, least / factor)
                text = f"{below} of {len(own)} analyses below {limit}"
                axes.text(0.5, 1.02, text, transform=axes.transAxes, fontsize=7, ha="center")
            axes.set_xlabel(shown_label(im_column)[0])
        panels[0].set_xscale("log")
        panels[0].set_yscale("log")
        panels[0].set_ylabel(label)
        im = demands[im_column]
        panels[0].set_xlim(im.min() / 1.15, im.max() * 1.15)
        top = max([demands[demand].max(), *thresholds.values()]) * 1.6
        panels[0].set_ylim(least / 1.8, top)
        plain_log_ticks(panels[0].xaxis)
        plain_log_ticks(panels[0].yaxis)
        _name_thresholds(panels[-1], thresholds)
        _add_legend(figure, layout.handles(marks=True))
    return figure


def _cloud_points(
    axes: Axes, part: pd.DataFrame, im: str, demand: str, least: float, look: dict[str, Any]
) -> None:
    """Draw the runs of one line style: filled, open with a tick upward, or at the bottom."""
    x, y, complete, bottom = part[im], part[demand], is_complete(part), least / 1.5
    tick: dict[str, Any] = {"marker": _UP}
    down: dict[str, Any] = {"marker": "v"}
    done, early, small = complete & (y >= least), ~complete, complete & (y < least)
    bounds = y[early].clip(lower=bottom)
    axes.plot(x[done], y[done], ms=2.8, alpha=0.6, mew=0, **look)
    axes.plot(x[early], bounds, ms=3.6, mfc="none", mew=0.8, **look)
    axes.plot(x[early], bounds, ms=6.5, mew=0.9, **look | tick)
    at_bottom = np.full(int(small.sum()), bottom)
    axes.plot(x[small], at_bottom, ms=3, mew=0, alpha=0.5, **look | down)


def _name_thresholds(axes: Axes, thresholds: Mapping[str, float]) -> None:
    """Write the names of the limit states at the right of a panel, with room between them."""
    low, high = np.log(axes.get_ylim())
    last = -np.inf
    for name, threshold in sorted(thresholds.items(), key=lambda item: item[1]):
        height = (np.log(threshold) - low) / (high - low)
        if height < 0.0:
            continue
        last = max(height, last + _NAME_ROOM)
        axes.text(1.02, last, in_words(name), transform=axes.transAxes, fontsize=7,
                  color="#333333", va="center")  # fmt: skip


def _add_legend(figure: Figure, handles: Sequence[Line2D]) -> None:
    columns = min(len(handles), int(figure.get_figwidth() / _LEGEND_COLUMN_IN) or 1)
    columns = -(-len(handles) // -(-len(handles) // columns))  # rows of equal length
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, handlelength=3.2)
