"""Figures of fragility: curves, demands against intensity, effects, modelling choices."""

from collections import Counter
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.demands.validity import is_complete, with_derived_columns
from skewbridge.files.tables import Floats, records_of
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.paper_table import chosen_curves
from skewbridge.fragility.union import curve_probability, union_curve
from skewbridge.fragility.verdicts import CELL, DECIDED
from skewbridge.report import appearance
from skewbridge.report.answer import model_name
from skewbridge.report.appearance import (
    STYLE,
    VariantLayout,
    in_words,
    plain_log_ticks,
    shown_label,
)
from skewbridge.variant.axes import Axis, axes_of

#: Largest number of runs whose marks are drawn as vectors.
MAX_VECTOR_RUNS: Final = 5000
_LEGEND_COLUMN_IN: Final = 1.75
_TITLE_PAD_PT: Final = 6.0  # between a panel and its title
_NOTE_LINE_PT: Final = 9.0  # height of a line of notes between panel and title
_NAME_ROOM: Final = 0.05  # height of the name of a state / height of a panel
_FAR_BELOW: Final = 300.0  # demands below the mildest state / this are drawn at the bottom
_NO_MARKER: Final[dict[str, Any]] = {"marker": ""}
_CROSSED: Final = (0.1, 0.3, 0.5, 0.7, 0.9)  # P at which the curve of an exceedance fit has crosses
_COLOURS: Final = {"choice": appearance.VARIANT_COLOURS[0], "axis": appearance.VARIANT_COLOURS[1]}
_KINDS: Final = {"choice": "choice of the modeller", "axis": "axis of the study"}
COMPARED_KINDS: Final = tuple(_KINDS)
_SKEW_MARKS: Final = {"skew": "s", "skew_part": "o", "skew_remainder": "D", "skew_extra": "o"}
_SKEW_TICKS_PCT: Final = (-80, -50, -30, -20, -10, 0, 10, 20, 30, 50, 100, 200, 400)
LINEAR_PCT: Final = 5.0  # the scale is linear up to here, then logarithmic
_TICKS_PCT: Final = (2, 5, 20, 100, 500)
_LEAST_PCT: Final = 6.0  # smallest range of a panel on each side


# --- curves and clouds


def shown_curves(curves: pd.DataFrame) -> pd.DataFrame:
    """Return one row per variant and state: the preferred curve, or else a bracketed median.

    If a variant and state have neither, they have no row.
    """
    return chosen_curves(curves[curves["preferred"] | curves["theta_bracket_low"].notna()])


def curve_values(im: Floats, row: Mapping[Any, Any]) -> tuple[Floats, Floats]:
    """Return P(exceeds | IM) of a row of curves, shape of ``im``, and its band, shape (2, n).

    The curve includes record-to-record and capacity dispersion. The band is the pointwise
    interval of ln(im/theta)/beta_total, transformed by the normal distribution function.
    """
    # ASSUME dispersion of the capacity and slope are known, so beta_total varies with beta only;
    # near its curve, a union of failure modes varies like the lognormal curve of its row
    beta = float(row["beta_total"])
    slope, p = row["beta"] / beta, curve_probability(im, row)
    eta = np.log(im / row["theta"]) / beta
    if union_curve(row) is not None:
        eta = special.ndtri(np.clip(p, 1e-15, 1.0 - 1e-15))
    variance = row["var_ln_theta"] + 2.0 * eta * row["cov_ln_theta_beta"] * slope
    variance = np.maximum(variance + eta**2 * row["var_beta"] * slope**2, 0.0)
    reach = special.ndtri(0.5 + 0.5 * row["level"]) * np.sqrt(variance) / beta
    return p, special.ndtr(eta + np.array([[-1.0], [1.0]]) * reach)


@mpl.rc_context(STYLE)
def fragility_curves(curves: pd.DataFrame, demands: pd.DataFrame, component: str) -> Figure:
    """Draw the preferred curves of a component and the outcomes of the runs.

    Each row of panels is a limit state with a curve or a bracketed median. The columns are the
    panels of `VariantLayout`. Curves in `VariantLayout.banded` have bands; curves of exceedance
    fits have crosses. If the outcomes are separated, a bar at P = 0.5 spans the interval of the
    median. Ticks are runs with a known outcome: runs that exceed the state are at the top, runs
    that do not are at the bottom. An open diamond is the median of the other method, if the medians
    of the two methods differ. States that no run reached are listed at the top. ``curves`` must
    have a preferred curve or a bracketed median of the component.
    """
    rows = curves[curves["component"] == component]
    table, demands = shown_curves(rows), with_derived_columns(demands)
    runs = dict(tuple(demands.groupby("variant")))
    names = [name for name in rows["limit_state"].unique() if (table["limit_state"] == name).any()]
    im_column = str(table["im"].iloc[0])
    grid = np.geomspace(0.7 * demands[im_column].min(), 1.3 * demands[im_column].max(), 160)
    layout = VariantLayout(rows)
    columns = layout.panels(rows)
    bands = f" ({layout.banded_text})" if layout.banded_text else ""
    title = f"{in_words(component).capitalize()}, {100 * table['level'].iloc[0]:g} % bands{bands}"
    head = [title, *states_out_of_reach(rows, demands)]
    size = 2.6 * len(columns) + 0.9, 2.1 * len(names) + 0.74 + 0.16 * len(head)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(names), len(columns), squeeze=False, sharex=True, sharey=True)
    for row, name in zip(panels, names, strict=True):
        parts = [part[part["limit_state"] == name] for _, part in columns]
        panels_of_state = zip(row, parts, strict=True)
        notes = [_curve_panel(*each, runs, grid, layout) for each in panels_of_state]
        for axes, lines, (title, _) in zip(row, notes, columns, strict=True):
            axes.text(1.0, 1.02, "\n".join(lines), transform=axes.transAxes, ha="right",
                      va="bottom", fontsize=7, color="#333333", linespacing=1.1)  # fmt: skip
            if name == names[0]:
                pad = _TITLE_PAD_PT + _NOTE_LINE_PT * max(map(len, notes))
                axes.set_title(title, fontsize=9, pad=pad)
        state = parts[0].iloc[0]
        capacity = appearance.threshold_text(str(state["demand"]), float(state["threshold"]))
        row[0].set_ylabel(f"P(exceeds | IM)\n{in_words(name)}: {capacity}")
    for axes in panels[-1]:
        axes.set_xlabel(shown_label(im_column)[0])
    panels[0, 0].set(xscale="log", ylim=(-0.06, 1.06))
    plain_log_ticks(panels[0, 0].xaxis)
    _add_legend(figure, [*layout.handles(), *_curve_handles(table)])
    figure.suptitle("\n".join(head), x=0.01, ha="left", fontsize=9)
    return figure


def states_out_of_reach(rows: pd.DataFrame, demands: pd.DataFrame) -> list[str]:
    """Return one sentence for each state that no run exceeds, with the largest demand."""
    largest = demands.groupby("variant").max(numeric_only=True)
    sentences: list[str] = []
    for name, own in rows.groupby("limit_state", sort=False):
        if (own["reach"] != "").all():
            peaks = largest[own["demand"].iloc[0]].reindex(own["variant"]).to_numpy()
            sentences.append(f"{in_words(name)}, no curve: {own['reach'].iloc[peaks.argmax()]}")
    return sentences


def _curve_panel(
    axes: Axes, rows: pd.DataFrame, runs: dict[Any, pd.DataFrame], im: Floats, layout: VariantLayout
) -> list[str]:
    """Draw the curves of a state in a panel; return notes on missing and extrapolated curves.

    ``rows`` are the fits of the panel, ``runs`` maps variants to demands, ``im`` are abscissas.
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
                axes.plot(ends, [0.5, 0.5], color=color, lw=4.0, alpha=0.6, solid_capstyle="butt")
                continue
            p, (low, high) = curve_values(im, item)
            if values in layout.banded:
                axes.fill_between(im, low, high, color=color, alpha=0.15, linewidth=0)
            axes.plot(im, p, **style | _NO_MARKER)
            if item["method"] == "exceedance":
                at = np.searchsorted(p, [each for each in _CROSSED if each < p[-1]])
                axes.plot(im[at], p[at], "x", ms=6.0, mew=1.2, color=color)
            other = own.loc[~own["preferred"], "theta"].dropna().head(1)
            if item["methods_differ"] and len(other):
                medians = [item["theta"], other.iloc[0]]
                axes.plot(medians, [0.5, 0.5], "-", color=color, linewidth=0.8)
                axes.plot(medians[1], 0.5, "D", ms=4.5, mfc="white", mec=color, zorder=4)
    is_drawn = rows.groupby("variant")["preferred"].transform("any")
    missing = rows[~is_drawn].drop_duplicates("variant")
    reasons = Counter(
        "no run exceeds" if reach else in_words(status)
        for reach, status in zip(missing["reach"], missing["status"], strict=True)
    )
    total = rows["variant"].nunique()
    notes = [f"{n} of {total} without a curve: {reason}" for reason, n in reasons.most_common()]
    if outside := int((rows["preferred"] & rows["extrapolated"].eq(other=True)).sum()):
        notes.append(f"{outside} of {total} medians extrapolated")
    return notes


def _outcomes(runs: pd.DataFrame, item: Mapping[Any, Any]) -> tuple[Any, Any]:
    """Return masks (n,) of runs known to exceed a state, and of runs known not to exceed it."""
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
    """Return legend entries for the marks (cross, diamond, bar) of the drawn fits."""
    drawn = table[table["preferred"]]
    marks: tuple[tuple[Any, str, dict[str, Any]], ...] = (
        ((drawn["method"] == "exceedance").any(), "exceedance fit", {"marker": "x", "ms": 6.0}),
        (drawn["methods_differ"].any(), "median, other method",
         {"marker": "D", "ms": 4.5, "mfc": "white", "lw": 0.8}),
        (len(drawn) < len(table), "median in this range",
         {"lw": 4.0, "alpha": 0.6, "solid_capstyle": "butt"}),
    )  # fmt: skip
    grey = "#39434a"  # in the figure, a mark has the colour of its line
    return [Line2D([], [], color=grey, label=label, **look) for on, label, look in marks if on]


def least_shown(demands: pd.DataFrame, curves: pd.DataFrame, demand: str) -> float | None:
    """Return the lower end of the axis of a demand; None if no demand is above it."""
    values = demands[demand]
    positive = values[values > 0.0]
    mildest = curves.loc[curves["demand"] == demand, "threshold"].min()
    least = max(float(positive.min()), mildest / _FAR_BELOW) if len(positive) else np.inf
    return least if (values >= least).any() else None


@mpl.rc_context(STYLE)
def demand_clouds(demands: pd.DataFrame, curves: pd.DataFrame, demand: str) -> Figure:
    """Draw demand against intensity on log-log axes, with fitted lines and thresholds.

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
    layout = VariantLayout(demands)
    columns = layout.panels(demands)
    figure = Figure(figsize=(2.6 * len(columns) + 0.9, 3.3), layout="constrained")
    panels = figure.subplots(1, len(columns), squeeze=False, sharex=True, sharey=True)[0]
    any_below, is_large = (demands[demand] < least).any(), len(demands) > MAX_VECTOR_RUNS
    for axes, (title, own) in zip(panels, columns, strict=True):
        for _, part, style in layout.lines(own):
            look = style | {"linestyle": "", "rasterized": is_large}
            _cloud_points(axes, part, im_column, demand, least, look)
            line = fits[fits["variant"].isin(part["variant"])].head(1)
            if len(line) and np.isfinite(line["b"].iloc[0]):
                x = np.geomspace(part[im_column].min(), part[im_column].max(), 41)
                fit = line.iloc[0]
                y = factor * np.exp(fit["ln_a"]) * x ** fit["b"]
                if np.isfinite(fit["knot"]):
                    y = y * np.maximum(x / fit["knot"], 1.0) ** (fit["b_above"] - fit["b"])
                axes.plot(x, y, **style | _NO_MARKER)
        for threshold in thresholds.values():
            axes.axhline(threshold, color="#555555", lw=0.8, ls=(0, (1, 2)), zorder=1)
        axes.set_title(title, fontsize=9, pad=_TITLE_PAD_PT + _NOTE_LINE_PT * any_below)
        if below := int((own[demand] < least).sum()):
            limit = appearance.threshold_text(demand, least / factor)
            text = f"{below} of {len(own)} analyses below {limit}"
            axes.text(0.5, 1.02, text, transform=axes.transAxes, fontsize=7, ha="center")
        axes.set_xlabel(shown_label(im_column)[0])
    im, top = demands[im_column], max([demands[demand].max(), *thresholds.values()])
    panels[0].set(xscale="log", yscale="log", ylabel=label)
    panels[0].set(xlim=(im.min() / 1.15, im.max() * 1.15), ylim=(least / 1.8, 1.6 * top))
    plain_log_ticks(panels[0].xaxis)
    plain_log_ticks(panels[0].yaxis)
    low, high = np.log(panels[-1].get_ylim())
    height = -np.inf
    for name, threshold in sorted(thresholds.items(), key=lambda item: item[1]):
        place = (np.log(threshold) - low) / (high - low)
        if place >= 0.0:  # keep the names apart
            height = max(place, height + _NAME_ROOM)
            panels[-1].text(1.02, height, in_words(name), transform=panels[-1].transAxes,
                            fontsize=7, color="#333333", va="center")  # fmt: skip
    _add_legend(figure, layout.handles(marks=True))
    return figure


def _cloud_points(
    axes: Axes, part: pd.DataFrame, im: str, demand: str, least: float, look: dict[str, Any]
) -> None:
    """Draw the runs of one line style as filled marks, open marks or marks at the bottom."""
    x, y, complete, bottom = part[im], part[demand], is_complete(part), least / 1.5
    tick: dict[str, Any] = {"marker": 2}  # matplotlib's marker of a tick upward
    down: dict[str, Any] = {"marker": "v"}
    done, early, small = complete & (y >= least), ~complete, complete & (y < least)
    bounds = y[early].clip(lower=bottom)
    axes.plot(x[done], y[done], ms=2.8, alpha=0.6, mew=0, **look)
    axes.plot(x[early], bounds, ms=3.6, mfc="none", mew=0.8, **look)
    axes.plot(x[early], bounds, ms=6.5, mew=0.9, **look | tick)
    at_bottom = np.full(int(small.sum()), bottom)
    axes.plot(x[small], at_bottom, ms=3, mew=0, alpha=0.5, **look | down)


def _add_legend(figure: Figure, handles: Sequence[Line2D]) -> None:
    columns = min(len(handles), int(figure.get_figwidth() / _LEGEND_COLUMN_IN) or 1)
    columns = -(-len(handles) // -(-len(handles) // columns))  # rows of equal length
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, handlelength=3.2)


# --- effects and modelling choices


@mpl.rc_context(STYLE)
def effects_by_intensity(intensities: pd.DataFrame, im_label: str) -> Figure:
    """Draw the effect of each axis on the headline demands, with its band, against intensity.

    Dots are at the reference intensity of the bridge. If that is outside the range of the pairs, an
    open dot is at the nearest end of the range.
    """
    names = demands_for("headline", intensities["demand"])
    along = axes_of(intensities["axis"])
    size = 2.9 * len(along) + 0.9, 1.9 * len(names) + 0.9
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(names), len(along), squeeze=False, sharex=True, sharey="row")
    for row, name in zip(panels, names, strict=True):
        own = intensities[intensities["demand"] == name]
        for axes, axis in zip(row, along, strict=True):
            _intensity_panel(axes, own[own["axis"] == axis.name], axis)
        row[0].set_ylabel(fill(f"Ratio of {appearance.demand_name(name).lower()}", 24))
    for top, bottom, axis in zip(panels[0], panels[-1], along, strict=True):
        top.legend(fontsize=7, loc="best")
        top.set_title(axis.label, fontsize=9)
        bottom.set_xlabel(im_label)
    panels[0, 0].set_xscale("log")
    plain_log_ticks(panels[0, 0].xaxis)
    level = 100 * float(intensities["level"].iloc[0])
    title = f"Effect by intensity with {level:g} % band, same motions, all variants"
    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def _intensity_panel(axes: Axes, rows: pd.DataFrame, changed: Axis) -> None:
    axes.axhline(1.0, color="#777777", linewidth=0.8)
    colours = appearance.VARIANT_COLOURS
    changes = appearance.groups_of(rows, ["from_value", "to_value"])
    for i, (ends, own) in enumerate(changes):
        line, colour = own.sort_values("im"), colours[i % len(colours)]
        if len(changes) - i <= appearance.MAX_BANDS:  # the largest changes
            band = line["im"], line["ci_low"], line["ci_high"]
            axes.fill_between(*band, color=colour, alpha=0.18, lw=0)
        label = " to ".join(appearance.value_text(changed, value) for value in ends)
        dash = ("-", "--", ":", "-.")[i % 4]
        axes.plot(line["im"], line["ratio"], dash, color=colour, label=label)
        for item in records_of(own[own["at_reference"]]):
            inside = "white" if item["clipped"] else colour
            axes.plot(item["im"], item["ratio"], "o", ms=5, color=colour, mfc=inside)


@mpl.rc_context(STYLE)
def widths_by_analyses(rounds: pd.DataFrame) -> Figure:
    """Draw interval half-widths of the headline effects against the number of analyses.

    A dot marks the round of the verdict; effects without a dot are undecided. Columns of the table:
    `fragility.verdicts.ROUND_COLUMNS`.
    """
    rounds = rounds.assign(width=50.0 * np.log(rounds["ci_high"] / rounds["ci_low"]))
    kinds = {"demand": "Demands", "median_capacity": "Median capacities"}
    styles = {each.verdict: each for each in appearance.STYLES.values() if each.verdict in DECIDED}
    dot: dict[str, Any] = {"marker": "o", "ls": "", "ms": 5, "mec": "#39434a"}
    figure = Figure(figsize=(6.8, 3.0), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, (kind, title) in zip(panels, kinds.items(), strict=True):
        for _, own in rounds[rounds["quantity"] == kind].groupby(list(CELL), sort=False):
            line = own.sort_values("round")
            axes.plot(line["analyses"], line["width"], color="#b9c0c5", linewidth=0.8)
            for first in records_of(line[line["verdict"].isin(DECIDED)].head(1)):
                fill_colour = styles[first["verdict"]].fill
                axes.plot(first["analyses"], first["width"], color=fill_colour, **dot)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("Analyses of the study")
    panels[0].set(yscale="log", ylabel="Half-width of the interval (%)")
    plain_log_ticks(panels[0].yaxis)
    handles = [Line2D([], [], color=each.fill, label=each.text, **dot) for each in styles.values()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    return figure


def _ranked(choices: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return a dict from the label of a headline demand to its rows, smallest change first.

    Added columns: ``bar`` (choice or axis with its values), ``percent`` (change of the demand),
    ``text`` (that change as text) and ``size`` (|ln ratio|, or -1 without a pair).
    """
    # imported here: it loads the solver, and few studies compare choices
    from skewbridge.study.modelling_choices import CHOICES

    labels = {choice.key: choice.label for choice in CHOICES}
    labels |= {each.name: each.label for each in axes_of(choices["name"])}
    percent = 100.0 * (choices["ratio"] - 1.0)
    change = choices["from_value"] + " → " + choices["to_value"]
    texts = percent.map("{:+.1f} %".format).replace({"-0.0 %": "0.0 %", "+0.0 %": "0.0 %"})
    some = ", " + choices["n"].astype(str) + " of " + choices["n_pairs"].astype(str)
    texts += some.where(choices["n"] < choices["n_pairs"], "")
    rows = choices.assign(
        bar=choices["name"].map(labels) + " " + change,
        change=change,
        percent=percent,
        text=texts.where(choices["n"] > 0, "no pair"),
        size=choices["ratio"].map(np.log).abs().where(choices["n"] > 0, -1.0),
    ).sort_values("size", kind="stable")
    demands = demands_for("headline", choices["demand"].unique())
    return {appearance.demand_name(demand): rows[rows["demand"] == demand] for demand in demands}


@mpl.rc_context(STYLE)
def tornado(choices: pd.DataFrame) -> Figure:
    """Draw the changes of each headline demand by the choices and axes, sorted by size.

    All ``choices`` must belong to one bridge with one abutment model.
    """
    ranked = _ranked(choices)
    bars, rows = max(map(len, ranked.values())), -(-len(ranked) // 2)
    figure = Figure(figsize=(12.5, rows * (0.21 * bars + 0.95) + 0.4), layout="constrained")
    panels = list(figure.subplots(rows, 2, squeeze=False).flat)
    for panel, (label, own) in zip(panels, ranked.items(), strict=False):
        _tornado_panel(panel, own)
        panel.set_title(label, loc="left", fontsize=10, fontweight="bold")
    for panel in panels[len(ranked) :]:
        panel.axis("off")
    handles = [Patch(color=_COLOURS[kind], label=text) for kind, text in _KINDS.items()]
    figure.legend(handles=handles, loc="outside upper right", ncols=2)
    return figure


def _tornado_panel(panel: Axes, rows: pd.DataFrame) -> None:
    rows = rows.assign(place=np.arange(len(rows)))
    known = rows[rows["n"] > 0]
    reach = max([_LEAST_PCT, *(1.3 * known["percent"].abs())])
    panel.barh(known["place"], known["percent"], height=0.72, color=known["kind"].map(_COLOURS))
    ends = (100.0 * (known[["lowest", "highest"]] - 1.0)).clip(-reach, reach)
    panel.hlines(known["place"], ends["lowest"], ends["highest"], color="#333333", linewidth=0.8)
    for place, text in zip(rows["place"], rows["text"], strict=True):
        across = panel.get_yaxis_transform()
        panel.text(1.01, place, text, transform=across, va="center", fontsize=7.5)
    panel.set_yticks(rows["place"], rows["bar"], fontsize=8)
    panel.set(ylim=(-0.6, len(rows) - 0.4), xlabel="change of the demand (%)")
    panel.axvline(0.0, color="black", linewidth=0.8)
    panel.set_xscale("symlog", linthresh=LINEAR_PCT)
    panel.set_xlim(-reach, reach)
    ticks = [tick for tick in _TICKS_PCT if tick <= reach]
    places = [*(-tick for tick in reversed(ticks)), 0, *ticks]
    panel.set_xticks(places, [f"{tick:+d}" if tick else "0" for tick in places], fontsize=8)
    panel.xaxis.set_minor_locator(NullLocator())
    panel.grid(visible=False, axis="y")


def choice_findings(choices: pd.DataFrame) -> list[str]:
    """Return one sentence per headline demand on choices that change it more than friction does."""
    found: list[str] = []
    for label, rows in _ranked(choices).items():
        of_friction = rows[(rows["name"] == "friction") & (rows["n"] > 0)].sort_index()
        for friction in records_of(of_friction.head(1)):
            larger = rows[(rows["kind"] == "choice") & (rows["size"] > friction["size"])]
            largest = records_of(larger.iloc[::-1].drop_duplicates("name"))
            sizes = ", ".join(f"{row['bar']} ({row['text']})" for row in largest)
            found.append(
                f"{label}: friction {friction['change']} changes it by {friction['text']}; "
                + (f"larger changes: {sizes}." if sizes else "no choice changes it more.")
            )
    return found


@mpl.rc_context(STYLE)
def skew_parts(rows: pd.DataFrame) -> Figure:
    """Draw the effect of the largest skew on the headline demands with its parts, by bridge."""
    is_extra = rows["kind"] == "skew_extra"
    rows = rows.assign(name=rows["name"].mask(is_extra, rows["name"] + ", not in total"))
    models = appearance.groups_of(rows, ["bridge", "abutment"])
    names, colours = list(rows["name"].unique()), appearance.VARIANT_COLOURS
    demands = demands_for("headline", rows["demand"].unique())
    size = 4.6 * len(models) + 1.4, 0.17 * (len(names) + 2) * len(demands) + 0.9
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(1, len(models), squeeze=False, sharex=True, sharey=True)[0]
    places = {
        (demand, name): (len(names) + 2) * block + place
        for block, demand in enumerate(demands)
        for place, name in enumerate(names)
    }
    for panel, ((bridge, abutment), own) in zip(panels, models, strict=True):
        counted = own[["n", "n_pairs"]].max()
        motions = f"{counted['n']} of {counted['n_pairs']} motions"
        panel.set_title(f"{model_name(bridge, abutment)} ({motions})", loc="left", fontsize=9)
        across = panel.get_yaxis_transform()
        for row in records_of(own[own["demand"].isin(demands)]):
            kind, y = row["kind"], places[row["demand"], row["name"]]
            is_sum = kind in ("skew", "skew_remainder")
            shade = "black" if is_sum else colours[names.index(row["name"]) - 1]
            inside = "white" if kind == "skew_extra" else shade
            panel.plot([row["ci_low"], row["ci_high"]], [y, y], color=shade, linewidth=1.2)
            panel.plot(row["ratio"], y, _SKEW_MARKS[kind], color=shade, mfc=inside, ms=4.5)
            panel.text(1.01, y, _skew_text(row), transform=across, va="center", fontsize=7)
        for demand in demands:
            label, top = appearance.demand_name(demand), places[demand, names[0]] - 1
            panel.text(0.0, top, label, transform=across, va="center", fontsize=8, weight="bold",
                       bbox={"color": "white", "pad": 1.0})  # fmt: skip
        panel.axvline(1.0, color="black", linewidth=0.8)
        panel.set(xscale="log", xlabel="change of the demand (%)")
    panels[0].set_yticks(list(places.values()), [name for _, name in places], fontsize=7.5)
    panels[0].set_ylim(max(places.values()) + 0.7, -1.7)
    low, high = panels[0].get_xlim()
    step = 10 if high < 2.5 * low else 50  # keep the labels apart
    ticks = [t for t in _SKEW_TICKS_PCT if t % step == 0 and low <= 1.0 + t / 100.0 <= high]
    panels[0].set_xticks([1.0 + t / 100.0 for t in ticks], [f"{t:+d}" if t else "0" for t in ticks])
    panels[0].xaxis.set_minor_locator(NullLocator())
    return figure


def _skew_text(row: Mapping[Any, Any]) -> str:
    interval = appearance.interval_text(row).removesuffix(" %")
    return f"{appearance.change_text(row)} ({interval})" if row["n"] else "no motion"


def skew_findings(rows: pd.DataFrame) -> list[str]:
    """Return one sentence per bridge: effects of skew on headline demands and largest parts."""
    rows = rows[(rows["n"] > 0) & rows["demand"].isin(demands_for("headline"))]
    found: dict[str, list[str]] = {}
    for (bridge, demand), own in appearance.groups_of(rows, ["bridge", "demand"]):
        sizes = own.loc[own["kind"] == "skew_part", "ratio"].map(np.log).abs()
        shown = own[(own["kind"] == "skew") | own.index.isin(sizes.nlargest(1).index)]
        texts = [f"{row['name']} {appearance.change_text(row)}" for row in records_of(shown)]
        name = appearance.demand_name(demand).lower()
        found.setdefault(bridge, []).append(f"{name} {', largest part '.join(texts)}")
    return [f"{bridge}: {'; '.join(texts)}." for bridge, texts in found.items()]
