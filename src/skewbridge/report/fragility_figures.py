"""Figures of fragility: curves of the states of a component, demands against intensity."""

from collections import Counter
from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from scipy import special

from skewbridge.demands.validity import is_complete, with_derived_columns
from skewbridge.files.tables import Floats, records_of
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.verdicts import OK
from skewbridge.report.answer import change_name
from skewbridge.report.axis_layout import (
    STYLE,
    VariantLayout,
    in_words,
    line_of,
    plain_log_ticks,
    sampled_runs,
    shown_label,
    threshold_text,
)
from skewbridge.report.verdict_style import verdict_style

_LEGEND_COLUMN_IN: Final = 1.75
_TITLE_PAD_PT: Final = 6.0  # between a panel and its title
_NOTE_LINE_PT: Final = 9.0  # for each line of a note between the two
_NAME_ROOM: Final = 0.05  # part of the height of a panel that the name of a state takes
_FAR_BELOW: Final = 300.0  # parts of the mildest state below which a demand is drawn at the bottom
_UP: Final = 2  # matplotlib's marker of a tick upward
_CROSSED: Final = (0.1, 0.3, 0.5, 0.7, 0.9)  # P at which the curve of an exceedance fit has crosses
_GREY: Final = "#39434a"  # of legend entries that stand for lines of any colour


def shown_curves(curves: pd.DataFrame) -> pd.DataFrame:
    """Return one row per variant and state: the preferred curve, else a bracketed median.

    Pairs of variant and state with neither are left out.
    """
    usable = curves[curves["preferred"] | curves["theta_bracket_low"].notna()]
    first = usable.sort_values("preferred", ascending=False, kind="stable")
    return first.drop_duplicates(["variant", "component", "limit_state"]).sort_index()


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


def fragility_curves(
    curves: pd.DataFrame, demands: pd.DataFrame, medians: pd.DataFrame, component: str
) -> Figure:
    """Draw the preferred curves of a component, the runs behind them, and the ratios of medians.

    A row of panels per limit state with a curve or a bracketed median, a column as in
    `VariantLayout`; the curves of `VariantLayout.banded` have bands, those of exceedance fits
    crosses. A bar at P = 0.5 spans the intensities between which the median of separated outcomes
    lies. Ticks at the bottom are runs that do not exceed, at the top runs that do; a run with an
    unknown outcome has none. An open diamond is the median of the other method where the medians of
    cloud and exceedance differ. States that no run reached are listed at the top. The last column
    has the paired ratios of the medians of the cloud fits, averaged over all variants, with their
    intervals; a note above it names medians without a curve and extrapolated ones.
    The curves have a usable row of the component; the effects on medians may be empty.
    """
    rows = curves[curves["component"] == component]
    table, demands = shown_curves(rows), with_derived_columns(demands)
    runs = dict(tuple(demands.groupby("variant")))
    drawn = dict(zip(table.index, records_of(table), strict=True))
    names = [
        name for name in dict.fromkeys(rows["limit_state"]) if (table.limit_state == name).any()
    ]
    im_column = str(table["im"].iloc[0])
    im = demands[im_column].to_numpy(dtype=np.float64)
    grid = np.geomspace(0.7 * im.min(), 1.3 * im.max(), 160)
    layout = VariantLayout.of(rows)
    columns = layout.panels(rows)
    out_of_reach = states_out_of_reach(rows, demands)
    ratios = pooled_ratios(medians, component)
    with mpl.rc_context(STYLE):
        height = 2.1 * len(names) + 0.9 + 0.16 * len(out_of_reach)
        widths = [2.6] * len(columns) + [3.4] * (not ratios.empty)
        figure = Figure(figsize=(sum(widths) + 0.9, height), layout="constrained")
        grid_of_panels = figure.add_gridspec(len(names), len(widths), width_ratios=widths)
        first: Axes | None = None
        for place, name in enumerate(names):
            row = []
            for column in range(len(columns)):
                first = figure.add_subplot(
                    grid_of_panels[place, column], sharex=first, sharey=first
                )
                first.tick_params(labelleft=column == 0, labelbottom=name == names[-1])
                row.append(first)
            notes = [
                _curve_panel(axes, part[part["limit_state"] == name], drawn, runs, grid, layout)
                for axes, (_, part) in zip(row, columns, strict=True)
            ]
            for axes, lines, (title, _) in zip(row, notes, columns, strict=True):
                _write_above(axes, "\n".join(lines))
                if name == names[0]:
                    pad = _TITLE_PAD_PT + _NOTE_LINE_PT * max(map(len, notes))
                    axes.set_title(title, fontsize=9, pad=pad)
                if name == names[-1]:
                    axes.set_xlabel(shown_label(im_column)[0])
            state = table[table["limit_state"] == name].iloc[0]
            capacity = threshold_text(str(state["demand"]), float(state["threshold"]))
            row[0].set_ylabel(f"P(exceeds | IM)\n{in_words(name)}: {capacity}")
            own = ratios[ratios["demand"] == f"{component}/{name}"]
            if not own.empty:
                panel = figure.add_subplot(grid_of_panels[place, len(columns)])
                _ratio_panel(panel, own, with_title=name == names[0])
        assert first is not None
        first.set_xscale("log")
        first.set_ylim(-0.06, 1.06)
        plain_log_ticks(first.xaxis)
        _add_legend(figure, [*layout.handles(), *_curve_handles(table)])
        bands = f"{100 * table['level'].iloc[0]:g} % bands"
        if layout.banded_text:
            bands += f" ({layout.banded_text})"
        title = f"{in_words(component).capitalize()}, {bands}"
        figure.suptitle("\n".join([title, *out_of_reach]), x=0.01, ha="left", fontsize=9)
    return figure


def pooled_ratios(medians: pd.DataFrame, component: str) -> pd.DataFrame:
    """Return the pooled effects on the medians of a component that have an estimate.

    Added is ``all_cells``, the number of pairs of variants that the change has in the study.
    """
    own = medians["demand"].astype(str).str.startswith(f"{component}/")
    chosen = medians[own & (medians["scope"] == "pooled") & (medians["status"] == OK)]
    if chosen.empty:
        return chosen
    # ASSUME some state has an estimate in every pair of variants
    change = ["axis", "from_value", "to_value"]
    all_cells = medians.groupby(change)["n_cells"].max().rename("all_cells")
    return chosen.merge(all_cells.reset_index(), on=change)


def median_notes(ratios: pd.DataFrame) -> list[str]:
    """Return what limits some medians of the ratios of `pooled_ratios`; empty if nothing does."""
    notes = {"n_without_curve": "no curve", "n_extrapolated": "extrapolated"}
    counts = ratios.reindex(columns=list(notes)).fillna(0)  # missing in earlier versions
    return [text for name, text in notes.items() if (counts[name] > 0).any()]


def _ratio_panel(axes: Axes, rows: pd.DataFrame, *, with_title: bool) -> None:
    """Draw the ratio of medians of each change of an axis as a point with its interval.

    The rows have ``all_cells``, the number of pairs of variants that the change has in the study.
    """
    changes: list[str] = []
    for item in records_of(rows):
        change = change_name(item["axis"], item["from_value"], item["to_value"])
        if item["n_cells"] < item["all_cells"]:
            change += f"\n{item['n_cells']} of {item['all_cells']} pairs"
        changes.append(change)
    margin = float(rows["margin"].iloc[0])
    axes.axvspan(1.0 - margin, 1.0 + margin, color="#e9edf0", zorder=0)
    axes.axvline(1.0, color="#6b7378", linewidth=0.8)
    for y, item in enumerate(rows.to_dict("records")):
        axes.plot([item["ci_low"], item["ci_high"]], [y, y], color="#39434a", linewidth=1.4)
        axes.plot(item["ratio"], y, "o", ms=6, mec="#39434a", mfc=verdict_style(item).fill)
    axes.set_yticks(range(len(changes)), changes, fontsize=8)
    axes.set_ylim(len(changes) - 0.4, -0.6)
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, 0.9), max(high, 1.1))
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(visible=False, axis="y")
    notes = median_notes(rows)
    _write_above(axes, f"some medians: {', '.join(notes)}" if notes else "")
    if with_title:
        title = f"Ratio of medians, {100 * rows['level'].iloc[0]:g} % interval"
        axes.set_title(title, fontsize=9, pad=_TITLE_PAD_PT + _NOTE_LINE_PT * bool(notes))


def _write_above(axes: Axes, note: str) -> None:
    """Write a note of one or more lines at the right above a panel."""
    axes.text(1.0, 1.02, note, transform=axes.transAxes, ha="right", va="bottom", fontsize=7,
              color="#333333", linespacing=1.1)  # fmt: skip


def _curve_handles(table: pd.DataFrame) -> list[Line2D]:
    """Return the entries of the legend for marks that the drawn fits of a component have."""
    drawn = table[table["preferred"]]
    handles: list[Line2D] = []
    if (drawn["method"] == "exceedance").any():
        handles.append(Line2D([], [], color=_GREY, marker="x", ms=6.0, label="exceedance fit"))
    if drawn["methods_differ"].any():
        handles.append(Line2D([], [], color=_GREY, marker="D", ms=4.5, mfc="white", lw=0.8,
                              label="median, other method"))  # fmt: skip
    if not table["preferred"].all():
        handles.append(Line2D([], [], color=_GREY, lw=4.0, alpha=0.6, solid_capstyle="butt",
                              label="median in this range"))  # fmt: skip
    return handles


def states_out_of_reach(rows: pd.DataFrame, demands: pd.DataFrame) -> list[str]:
    """Return a sentence per state that no run of a component exceeds, with the largest demand."""
    sentences: list[str] = []
    largest = demands.groupby("variant").max(numeric_only=True)
    for name, own in rows.groupby("limit_state", sort=False):
        if (own["reach"] != "").all():
            variants = own["variant"]
            peak = largest[own["demand"].iloc[0]].reindex(variants).to_numpy()
            sentences.append(f"{in_words(name)}, no curve: {own['reach'].iloc[int(peak.argmax())]}")
    return sentences


def methods_note(rows: pd.DataFrame) -> str:
    """Return how far the medians of both methods differ in the flagged rows; empty without any."""
    flagged = rows[rows["methods_differ"]]
    if flagged.empty:
        return ""
    changes = 100.0 * (flagged["methods_ratio"] - 1.0)
    texts = dict.fromkeys(f"{change:+.0f}" for change in (changes.min(), changes.max()))
    curves = f"{len(flagged)} curves: " if len(flagged) > 1 else ""
    return f"{curves}exceedance median {' to '.join(texts)} %\nagainst the cloud median"


def _curve_panel(
    axes: Axes,
    rows: pd.DataFrame,
    drawn: Mapping[Any, Mapping[str, Any]],
    runs: Mapping[Any, pd.DataFrame],
    grid: Floats,
    layout: VariantLayout,
) -> list[str]:
    """Draw the curves of one state in a panel; return the lines above it.

    ``rows`` are the fits of the panel, ``drawn`` the rows of `shown_curves` by index, and ``runs``
    the demands by variant.
    """
    shown = rows[rows.index.isin(list(drawn))]
    missing = rows[~rows["variant"].isin(shown.loc[shown["preferred"], "variant"])]
    missing = missing.drop_duplicates("variant")
    for item in (drawn[place] for place in shown.index):
        key = layout.values_of(item)
        style = layout.styles[key]
        own = runs[item["variant"]]
        x = own[item["im"]].to_numpy()
        for hit, height, marker in zip(_outcomes(own, item), (1.03, -0.03), (2, 3), strict=True):
            axes.plot(x[hit], np.full(int(hit.sum()), height), marker=marker, ls="", ms=3,
                      color=style["color"], alpha=0.5)  # fmt: skip
        if not item["preferred"]:
            ends = [item["theta_bracket_low"], item["theta_bracket_high"]]
            axes.plot(ends, [0.5, 0.5], color=style["color"], linewidth=4.0, alpha=0.6,
                      solid_capstyle="butt")  # fmt: skip
            continue
        values, (low, high) = curve_values(grid, item)
        if key in layout.banded:
            axes.fill_between(grid, low, high, color=style["color"], alpha=0.15, linewidth=0)
        axes.plot(grid, values, **line_of(style))
        if item["method"] == "exceedance":
            at = np.searchsorted(values, [p for p in _CROSSED if p < values[-1]])
            axes.plot(grid[at], values[at], "x", ms=6.0, mew=1.2, color=style["color"])
        if item["methods_differ"]:
            other = rows[(rows["variant"] == item["variant"]) & ~rows["preferred"]]
            medians = [item["theta"], *other["theta"].dropna().head(1)]
            axes.plot(medians, [0.5] * len(medians), "-", color=style["color"], linewidth=0.8)
            axes.plot(medians[1:], [0.5] * (len(medians) - 1), "D", ms=4.5, mfc="white",
                      mec=style["color"], zorder=4)  # fmt: skip
    reasons = Counter(
        "no run exceeds" if reach else in_words(status)
        for reach, status in zip(missing["reach"], missing["status"], strict=True)
    )
    total = rows["variant"].nunique()
    lines = [f"{n} of {total} without a curve: {reason}" for reason, n in reasons.most_common()]
    return [*lines, *methods_note(shown[shown["preferred"]]).splitlines()]


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
    Of a large study a sample of the runs is drawn, as stated at the top.
    """
    demands = with_derived_columns(demands)
    label, factor = shown_label(demand)
    demands = demands.assign(**{demand: factor * demands[demand]})
    fits = curves[(curves["demand"] == demand) & (curves["method"] == "cloud")]
    shifted = fits["ln_a"] + np.log(factor)
    fits = fits.assign(threshold=factor * fits["threshold"], ln_a=shifted)
    thresholds = dict(zip(fits["limit_state"], fits["threshold"], strict=True))
    im_column = str(curves["im"].iloc[0])
    layout, shown = VariantLayout.of(demands), sampled_runs(demands)
    columns = layout.panels(shown)
    least = least_shown(demands, fits, demand) or 1.0
    bottom = least / 1.5
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.6 * len(columns) + 0.9, 3.3), layout="constrained")
        if len(shown) < len(demands):
            note = f"{len(shown)} of {len(demands)} runs, drawn at random; fits are of all runs"
            figure.suptitle(note, x=0.01, ha="left", fontsize=9)
        panels = figure.subplots(1, len(columns), squeeze=False, sharex=True, sharey=True)[0]
        any_below = (shown[demand] < least).any()
        for axes, (title, own) in zip(panels, columns, strict=True):
            for part, style in layout.lines(own):
                _cloud_points(axes, part, (im_column, demand), (least, bottom), style)
                line = fits[fits["variant"].isin(part["variant"])].head(1)
                if len(line) and np.isfinite(line["b"].iloc[0]):
                    x = np.geomspace(part[im_column].min(), part[im_column].max(), 2)
                    y = np.exp(line["ln_a"].iloc[0]) * x ** line["b"].iloc[0]
                    axes.plot(x, y, **line_of(style))
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
        panels[0].set_ylim(bottom / 1.2, max([demands[demand].max(), *thresholds.values()]) * 1.6)
        plain_log_ticks(panels[0].xaxis)
        plain_log_ticks(panels[0].yaxis)
        _name_thresholds(panels[-1], thresholds)
        _add_legend(figure, layout.handles(marks=True))
    return figure


def _cloud_points(
    axes: Axes,
    part: pd.DataFrame,
    columns: Sequence[str],
    ends: tuple[float, float],
    style: Mapping[str, Any],
) -> None:
    """Draw the runs of one line style: filled, open with a tick upward, or at the bottom."""
    least, bottom = ends
    x, y = (part[name].to_numpy() for name in columns)
    complete, seen = is_complete(part), y >= least
    look: dict[str, Any] = {"color": style["color"], "ls": ""}
    done, early = complete & seen, ~complete
    bounds = np.maximum(y[early], bottom)
    axes.plot(x[done], y[done], style["marker"], ms=2.8, alpha=0.6, mew=0, **look)
    axes.plot(x[early], bounds, style["marker"], ms=3.6, mfc="none", mew=0.8, **look)
    axes.plot(x[early], bounds, marker=_UP, ms=6.5, mew=0.9, **look)
    small = complete & (y < least)
    axes.plot(x[small], np.full(int(small.sum()), bottom), "v", ms=3, mew=0, alpha=0.5, **look)


def _name_thresholds(axes: Axes, thresholds: Mapping[str, float]) -> None:
    """Write the names of the limit states at the right of a panel, with room between them."""
    low, high = np.log(axes.get_ylim())
    last = -np.inf
    for name, threshold in sorted(thresholds.items(), key=itemgetter(1)):
        height = (np.log(threshold) - low) / (high - low)
        if height < 0.0:
            continue
        last = max(height, last + _NAME_ROOM)
        axes.text(1.02, last, in_words(name), transform=axes.transAxes, fontsize=7,
                  color="#333333", va="center")  # fmt: skip


def _add_legend(figure: Figure, handles: list[Line2D]) -> None:
    columns = min(len(handles), int(figure.get_figwidth() / _LEGEND_COLUMN_IN) or 1)
    columns = -(-len(handles) // -(-len(handles) // columns))  # rows of equal length
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, handlelength=3.2)
