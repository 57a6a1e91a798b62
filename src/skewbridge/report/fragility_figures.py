"""Figures of fragility: curves by the values of one axis, clouds, effects, modelling choices."""

from collections.abc import Collection, Mapping
from itertools import compress, cycle, groupby
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.demands.validity import is_complete, with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, records_of
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, reference_value
from skewbridge.fragility.exports import three_digits, with_interval
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.limit_states import COLUMN_FAILURE, HEADLINE_STATES, LimitState
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.system import averaged
from skewbridge.fragility.union import curve_probability, union_curve
from skewbridge.fragility.verdicts import OK, RATIOS
from skewbridge.report import appearance
from skewbridge.report.answer import short_names
from skewbridge.variant.axes import Axis, axes_of, axis

#: Component name of the series system of all components of a bridge.
WHOLE_BRIDGE: Final = "whole_bridge"
STATE: Final = (*BRIDGE_COLUMNS, "component", "limit_state")
_LINE_IN: Final = 0.17  # height of a line of text above a panel
_SURE: Final = 1e-12  # smallest probability that is transformed to a normal variate


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
    half_width = special.ndtri(0.5 + 0.5 * row["level"]) * np.sqrt(variance) / beta
    return p, special.ndtr(eta + np.array([[-1.0], [1.0]]) * half_width)


def lead_axis(effects: pd.DataFrame, names: Collection[str], table: pd.DataFrame) -> Axis:
    """Return the axis with the largest pooled effect on the demands or states ``names``.

    Without such an effect it is the axis with the largest of all ``effects``, or the first axis
    with several values in ``table``.
    """
    pooled = effects[(effects["scope"] == "pooled") & (effects["status"] == OK)]
    pooled = pooled[pooled["ratio"] > 0.0]
    of_names = pooled[pooled["demand"].isin(names)]
    rows = of_names if len(of_names) else pooled
    if len(rows):
        sizes = np.abs(np.log(rows["ratio"].to_numpy(np.float64)))
        return axis(str(rows["axis"].iloc[int(sizes.argmax())]))
    if not (axes := axes_of(table.columns)):
        text = "figures need a column of an axis, such as skew_deg, in the demands"
        raise InputError(f"{text}: add it, with one value if nothing varies")
    return next((candidate for candidate in axes if table[candidate.name].nunique() > 1), axes[0])


def with_system(curves: pd.DataFrame, system: pd.DataFrame) -> pd.DataFrame:
    """Return the curves of all components and of the whole bridge.

    Degrees of damage of a bridge with the same curves become one, such as ``moderate to complete``.
    """
    numbers = ["variant", "status", "theta", "beta", "n_exceed"]
    merged: list[pd.DataFrame] = []
    for _, model in system.groupby(list(BRIDGE_COLUMNS), sort=False):
        states = appearance.groups_of(model, ["limit_state"])
        for _, same in groupby(states, lambda state: state[1][numbers].to_csv(index=False)):
            (first, rows), *others = [(name, rows) for (name,), rows in same]
            merged.append(rows.replace({first: f"{first} to {others[-1][0]}"}) if others else rows)
    system = pd.concat([system.head(0), *merged])
    width = 2.0 * special.ndtri(0.5 + 0.5 * system["level"].astype(float))
    # ASSUME normal errors of ln theta and beta without correlation: the table has intervals only
    bridge_curves = system.assign(
        component=WHOLE_BRIDGE,
        demand="",
        threshold=np.nan,
        im=curves["im"].iloc[0],
        preferred=system["status"] == FITTED,
        beta_total=system["beta"],
        var_ln_theta=(np.log(system["theta_high"] / system["theta_low"]) / width) ** 2,
        var_beta=((system["beta_high"] - system["beta_low"]) / width) ** 2,
        cov_ln_theta_beta=0.0,
    )
    return pd.concat([curves, bridge_curves], ignore_index=True)


def pooled_curves(curves: pd.DataFrame, medians: pd.DataFrame) -> pd.DataFrame:
    """Return the curves of each state at each value of its axis with the largest effect.

    theta and the ends of its interval are geometric means over the variants with a curve, and the
    betas are means. The interval is not too narrow: averaging its ends takes the errors of all
    variants, which share their motions, as fully correlated. ``ratio`` is the paired ratio of
    medians to the first value; for the whole bridge, of pairs of variants with the same components
    (`averaged`). ``curves`` are from `with_system`, ``medians`` are effects on medians. A failure
    mode of columns with the same curve as any failure has no row.
    """
    groups: list[pd.DataFrame] = []
    for (bridge, abutment, component), group in appearance.groups_of(curves, STATE[:3]):
        effects = medians[(medians["bridge"] == bridge) & (medians["abutment"] == abutment)]
        names = set(component + "/" + group["limit_state"])
        main = lead_axis(effects, HEADLINE_STATES if component == WHOLE_BRIDGE else names, group)
        groups.append(group.assign(axis=main.name, value=group[main.name].astype(float)))
    rows = pd.concat(groups)
    rows["order"] = rows.groupby(list(STATE), sort=False).ngroup()
    keys, thetas = ["order", "value", *STATE, "axis"], ["theta", "theta_low", "theta_high"]
    with_curve = rows[rows["preferred"]]
    with np.errstate(divide="ignore"):  # an interval of few runs can start at 0
        logs = {name: np.log(with_curve[name].astype(float)) for name in thetas}
    flags = with_curve["extrapolated"].eq(other=True)
    fits = with_curve.assign(**logs, n_extrapolated=flags).groupby(keys)
    means = fits[[*thetas, "beta", "beta_total", "level"]].mean()
    means[thetas] = np.exp(means[thetas])
    means = means.assign(n_curves=fits.size(), n_extrapolated=fits["n_extrapolated"].sum())
    variants = rows.drop_duplicates([*STATE, "variant"]).groupby(keys)
    counts = variants[["n_exceed", "n_runs"]].sum().astype(int).assign(n_variants=variants.size())
    table = means.join(counts).reset_index()
    effects = medians[(medians["scope"] == "pooled") & (medians["status"] == OK)]
    effects = effects.rename(columns={"to_value": "value"}).astype({"value": float})
    table["demand"] = table["component"] + "/" + table["limit_state"]
    same_effect = [*BRIDGE_COLUMNS, "demand", "axis", "value"]
    table = table.merge(effects[[*same_effect, *RATIOS]], how="left", on=same_effect)
    system_ratios = _system_ratios(rows[rows["component"] == WHOLE_BRIDGE])
    table = table.merge(system_ratios, how="left", on=["order", "value"])
    table["ratio"] = table["ratio"].fillna(table["ratio_of_systems"])
    table["n_different"] = table["n_different"].fillna(0).astype(int)
    table = table.drop(columns=["order", "demand", "ratio_of_systems"])
    key_columns = ["bridge", "abutment", "component", "value", "theta", "beta_total", "n_exceed"]
    is_mode = (table["component"] == COLUMN_FAILURE) & (table["limit_state"] != "any")
    return table[~(is_mode & table.duplicated(key_columns, keep=False))]


def main_curves(pooled: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the rows of the leading curves: column failure, unseating, the whole bridge."""
    component = pooled["component"]
    kinds = {
        COLUMN_FAILURE: (component == COLUMN_FAILURE) & (pooled["limit_state"] == "any"),
        "unseating": component.str.contains("unseating"),
        WHOLE_BRIDGE: component == WHOLE_BRIDGE,
    }
    return {name: pooled[rows] for name, rows in kinds.items() if rows.any()}


def _system_ratios(systems: pd.DataFrame) -> pd.DataFrame:
    """Return mean ratios of system medians to that at the `reference_value` of the leading axis.

    ``systems`` include those without a curve; they have no table of effects. ``n_different`` is the
    number of pairs of variants that are left out because of their components, see `averaged`, or of
    variants with other components.
    """
    rows: list[tuple[Any, ...]] = []
    for order, all_values in systems.astype({"theta": float}).groupby("order"):
        group = all_values[all_values["preferred"]]
        row_of = {row["variant"]: row for row in records_of(group)}
        lead = all_values["axis"].iloc[0]
        others = [axis.name for axis in axes_of(map(str, group)) if axis.name != lead]
        is_first = group["value"] == reference_value(all_values["value"])
        pairs = group[is_first].merge(
            group[~is_first], on=["order", *others], suffixes=("_from", "")
        )
        for value, at_value in group.groupby("value"):
            names = pairs.loc[pairs["value"] == value, ["variant_from", "variant"]].to_numpy()
            of_value = [(row_of[first], row_of[second]) for first, second in names]
            used_pairs = list(compress(of_value, averaged(of_value)))
            logs = [np.log(row["theta"] / first["theta"]) for first, row in used_pairs]
            ratio = float(np.exp(np.mean(logs))) if logs else np.nan
            n_others = len(at_value) - at_value["components"].value_counts().iloc[0]
            rows.append((order, value, ratio, max(len(of_value) - len(used_pairs), n_others)))
    names = {"order": int, "value": float, "ratio_of_systems": float, "n_different": int}
    return pd.DataFrame(rows, columns=list(names)).astype(names)


def state_text(row: Mapping[Any, Any]) -> str:
    """Return component and state of a row of curves with its capacity, unless the name has it."""
    component, state, demand = row["component"], row["limit_state"], row.get("demand", "")
    words = f"{appearance.in_words(component)}, {appearance.in_words(state)}"
    if component == COLUMN_FAILURE:
        return appearance.in_words(component) if state == "any" else words
    if not demand or "dcr" in state:
        return words
    return f"{words} ({appearance.threshold_text(demand, row['threshold'])})"


def value_words(row: Mapping[str, Any], unit: str) -> str:
    """Return text on a value of an axis: its median, and the ratio to that at the first value."""
    text = f"{appearance.value_text(axis(row['axis']), row['value'])}: "
    text += f"{three_digits(row['theta'])} {unit}{' †' * (row['n_extrapolated'] > 0)}"
    if np.isfinite(row["ratio"]):
        text += f", × {with_interval([row[name] for name in RATIOS])}"
    return text + variants_text(row)


def variants_text(row: Mapping[str, Any]) -> str:
    """Return how many variants have a curve, if not all; ‡ if their components differ."""
    are_missing = row["n_curves"] < row["n_variants"]
    text = f" ({row['n_curves']}/{row['n_variants']} variants)" if are_missing else ""
    return text + " ‡" * (row["n_different"] > 0)


@mpl.rc_context(appearance.STYLE)
def curves_figure(
    table: pd.DataFrame, curves: pd.DataFrame, demands: pd.DataFrame, columns: int = 3
) -> Figure:
    """Draw pooled curves with bands, one panel per bridge, abutment model and state.

    Ticks are the runs with a known outcome: at the top those that exceed the state, at the bottom
    those that do not. ``table`` is from `pooled_curves`, ``curves`` from `with_system`.
    """
    groups = appearance.groups_of(table, STATE)
    rows = -(-len(groups) // columns)
    columns = -(-len(groups) // rows)
    height = (1.9 + _LINE_IN * (2 + table.groupby(list(STATE)).size().max())) * rows + 0.2
    figure = Figure(figsize=(3.4 * max(columns, 2) + 0.3, height), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    im_column, demands = str(curves["im"].iloc[0]), with_derived_columns(demands)
    im = np.geomspace(0.7 * demands[im_column].min(), 1.3 * demands[im_column].max(), 160)
    names = short_names(curves)
    for axes, (state, state_curves) in zip(panels.flat, groups, strict=False):
        is_state = (curves[list(STATE)] == list(state)).all(axis=1)
        fits = curves[is_state]
        words = state_text(records_of(fits)[0])
        is_shared = len(names) > 1
        title = f"{names[state[:2]]}: {words}" if is_shared else words[:1].upper() + words[1:]
        _draw_panel(axes, state_curves, fits, demands, im)
        colour_axis = axis(state_curves["axis"].iloc[0])
        name_lines(axes, title, f"median by {colour_axis.label.lower()}:")
        axes.set_xlabel(appearance.shown_label(im_column)[0])
        axes.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel("P(exceeds | IM)")
    for axes in panels.flat[len(groups) :]:
        axes.remove()
    panels[0, 0].set(xscale="log", ylim=(-0.06, 1.06), xlim=(im[0], im[-1]))
    appearance.plain_log_ticks(panels[0, 0].xaxis)
    return figure


def _draw_panel(
    axes: Axes, of_state: pd.DataFrame, fits: pd.DataFrame, demands: pd.DataFrame, im: Floats
) -> None:
    colour_axis, unit = axis(of_state["axis"].iloc[0]), appearance.unit_of(str(fits["im"].iloc[0]))
    # a value has the same colour in panels in which other values have no curve
    values = sorted(fits[colour_axis.name].unique())
    colours = dict(zip(values, cycle(appearance.VARIANT_COLOURS), strict=False))
    for row in records_of(of_state):
        color = colours[row["value"]]
        at_value = fits[fits["preferred"] & (fits[colour_axis.name] == row["value"])]
        curves = [np.vstack(curve_values(im, fit)) for fit in records_of(at_value)]
        mean = np.mean(special.ndtri(np.clip(curves, _SURE, 1.0 - _SURE)), axis=0)
        p, low, high = special.ndtr(mean)
        axes.fill_between(im, low, high, color=color, alpha=0.15, linewidth=0)
        axes.plot(im, p, color=color, linewidth=1.6, label=value_words(row, unit))
        if fits["demand"].iloc[0]:
            runs = demands[demands["variant"].isin(at_value["variant"])]
            outcomes = _outcomes(runs, records_of(at_value)[0])
            for is_known, y, marker in zip(outcomes, (1.03, -0.03), (2, 3), strict=True):
                x = runs.loc[is_known, str(fits["im"].iloc[0])]
                axes.plot(x, np.full(len(x), y), marker=marker, ls="", ms=3, color=color, alpha=0.4)


def name_lines(axes: Axes, *titles: str) -> None:
    """Write titles and the names of the lines above a panel, where they hide nothing."""
    style: dict[str, Any] = {"fontsize": 7.5, "title_fontsize": 9, "handlelength": 1.2}
    style |= {"title": "\n".join(fill(title, 44) for title in titles), "labelspacing": 0.2}
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), alignment="left", **style)


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


#: Largest number of runs whose marks are drawn as vectors.
MAX_VECTOR_RUNS: Final = 5000
_NAME_ROOM: Final = 0.05  # height of the name of a state / height of a panel
_FAR_BELOW: Final = 300.0  # demands below the mildest state / this are drawn at the bottom
_COLOURS: Final = {"choice": appearance.VARIANT_COLOURS[0], "axis": appearance.VARIANT_COLOURS[1]}
_KINDS: Final = {"choice": "choice of the modeller", "axis": "axis of the study"}
LINEAR_PCT: Final = 5.0  # the scale is linear up to here, then logarithmic
_TICKS_PCT: Final = (2, 5, 20, 100, 500)
_LEAST_PCT: Final = 6.0  # smallest range of a panel on each side


# --- demands against intensity


def least_shown(demands: pd.DataFrame, curves: pd.DataFrame, demand: str) -> float | None:
    """Return the lower end of the axis of a demand; None if no demand is above it."""
    values = demands[demand]
    positive = values[values > 0.0]
    mildest = curves.loc[curves["demand"] == demand, "threshold"].min()
    lowest = max(float(positive.min()), mildest / _FAR_BELOW) if len(positive) else np.inf
    return lowest if (values >= lowest).any() else None


@mpl.rc_context(appearance.STYLE)
def demand_clouds(
    demands: pd.DataFrame, curves: pd.DataFrame, effects: pd.DataFrame, demand: str
) -> Figure:
    """Draw demand against intensity on log-log axes, with fitted lines and thresholds.

    Colours are the values of the axis with the largest effect on the demand; a line is the mean of
    the fits over the other axes. Open marks with a tick upward are runs that ended early: the
    demand is a lower bound. Marks at the bottom are demands of zero, or far below the mildest
    state. All rows are of one bridge with one abutment model.
    """
    demands = with_derived_columns(demands)
    label, factor = appearance.shown_label(demand)
    fits = curves[(curves["demand"] == demand) & (curves["method"] == "cloud")]
    lowest = factor * (least_shown(demands, fits, demand) or 1.0)
    demands = demands.assign(**{demand: factor * demands[demand]})
    thresholds = dict(zip(fits["limit_state"], factor * fits["threshold"], strict=True))
    im_column, colour_axis = str(curves["im"].iloc[0]), lead_axis(effects, {demand}, demands)
    pooled = effects[(effects["scope"] == "pooled") & (effects["axis"] == colour_axis.name)]
    changes = {row["to_value"]: row for row in records_of(pooled[pooled["demand"] == demand])}
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    is_large = len(demands) > MAX_VECTOR_RUNS
    colours = cycle(appearance.VARIANT_COLOURS)
    for (value, runs), color in zip(demands.groupby(colour_axis.name), colours, strict=False):
        _cloud_points(axes, runs, im_column, demand, lowest, {"color": color, "ls": "",
                      "marker": "o", "rasterized": is_large})  # fmt: skip
        name = appearance.value_text(colour_axis, float(str(value)))
        if (change := changes.get(value, {})).get("status") == OK:
            name += f": {appearance.change_text(change)} ({appearance.interval_text(change)})"
        lines = fits[fits["variant"].isin(runs["variant"])].drop_duplicates("variant")
        x = np.geomspace(runs[im_column].min(), runs[im_column].max(), 41)
        means = [_fitted_line(x, row) for row in records_of(lines[np.isfinite(lines["b"])])]
        if means:
            mean = factor * np.exp(np.mean(means, axis=0))
            axes.plot(x, mean, color=color, linewidth=1.6, label=name)
        else:
            axes.plot([], [], "o", ms=4, color=color, label=name)
    for threshold in thresholds.values():
        axes.axhline(threshold, color="#555555", lw=0.8, ls=(0, (1, 2)), zorder=1)
    im, top = demands[im_column], max([demands[demand].max(), *thresholds.values()])
    axes.set(xscale="log", yscale="log", xlabel=appearance.shown_label(im_column)[0], ylabel=label)
    axes.set(xlim=(im.min() / 1.15, im.max() * 1.15), ylim=(lowest / 1.8, 1.6 * top))
    appearance.plain_log_ticks(axes.xaxis)
    appearance.plain_log_ticks(axes.yaxis)
    name_lines(axes, f"{len(demands)} analyses, colours by {colour_axis.label.lower()}:")
    low, high = np.log(axes.get_ylim())
    height = -np.inf
    for name, threshold in sorted(thresholds.items(), key=lambda item: item[1]):
        relative_height = (np.log(threshold) - low) / (high - low)
        if relative_height >= 0.0:  # keep the names apart
            height = max(relative_height, height + _NAME_ROOM)
            axes.text(1.01, height, appearance.in_words(name), transform=axes.transAxes,
                      fontsize=8, color="#333333", va="center")  # fmt: skip
    return figure


def _fitted_line(im: Floats, fit: Mapping[Any, Any]) -> Floats:
    """Return ln demand of a cloud fit at intensities, shape of ``im``."""
    change = (fit["b_above"] - fit["b"]) * np.maximum(np.log(im / fit["knot"]), 0.0)
    return fit["ln_a"] + fit["b"] * np.log(im) + np.nan_to_num(change)  # NaN: no knot


def _cloud_points(
    axes: Axes, runs: pd.DataFrame, im: str, demand: str, lowest: float, style: dict[str, Any]
) -> None:
    """Draw the runs of one colour as filled marks, open marks or marks at the bottom."""
    x, y, complete, bottom = runs[im], runs[demand], is_complete(runs), lowest / 1.5
    tick: dict[str, Any] = {"marker": 2}  # matplotlib's marker of a tick upward
    triangle: dict[str, Any] = {"marker": "v"}
    is_shown, ended_early, is_low = complete & (y >= lowest), ~complete, complete & (y < lowest)
    bounds = y[ended_early].clip(lower=bottom)
    axes.plot(x[is_shown], y[is_shown], ms=2.8, alpha=0.6, mew=0, **style)
    axes.plot(x[ended_early], bounds, ms=3.6, mfc="none", mew=0.8, **style)
    axes.plot(x[ended_early], bounds, ms=6.5, mew=0.9, **style | tick)
    at_bottom = np.full(int(is_low.sum()), bottom)
    axes.plot(x[is_low], at_bottom, ms=3, mew=0, alpha=0.5, **style | triangle)


# --- effects and modelling choices


@mpl.rc_context(appearance.STYLE)
def effects_by_intensity(intensities: pd.DataFrame, im_label: str) -> Figure:
    """Draw the effect of each axis on the headline demands, with its band, against intensity.

    Dots are at the reference intensity of the bridge. If that is outside the range of the pairs, an
    open dot is at the nearest end of the range.
    """
    names = demands_for("headline", intensities["demand"])
    axes_shown = axes_of(intensities["axis"])
    size_in = 2.9 * len(axes_shown) + 0.9, 1.9 * len(names) + 0.9
    figure = Figure(figsize=size_in, layout="constrained")
    panels = figure.subplots(len(names), len(axes_shown), squeeze=False, sharex=True, sharey="row")
    for row, name in zip(panels, names, strict=True):
        demand_rows = intensities[intensities["demand"] == name]
        for axes, step_axis in zip(row, axes_shown, strict=True):
            _intensity_panel(axes, demand_rows[demand_rows["axis"] == step_axis.name], step_axis)
        row[0].set_ylabel(fill(f"Ratio of {appearance.demand_name(name).lower()}", 24))
    for top, bottom, step_axis in zip(panels[0], panels[-1], axes_shown, strict=True):
        top.legend(fontsize=7, loc="best")
        top.set_title(step_axis.label, fontsize=9)
        bottom.set_xlabel(im_label)
    panels[0, 0].set_xscale("log")
    appearance.plain_log_ticks(panels[0, 0].xaxis)
    level = 100 * float(intensities["level"].iloc[0])
    title = f"Effect by intensity with {level:g} % band, same motions, all variants"
    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def _intensity_panel(axes: Axes, rows: pd.DataFrame, changed_axis: Axis) -> None:
    axes.axhline(1.0, color="#777777", linewidth=0.8)
    colours = appearance.VARIANT_COLOURS
    changes = appearance.groups_of(rows, ["from_value", "to_value"])
    for i, (values, effect) in enumerate(changes):
        line, colour = effect.sort_values("im"), colours[i % len(colours)]
        if len(changes) - i <= appearance.MAX_BANDS:  # the largest changes
            band = line["im"], line["ci_low"], line["ci_high"]
            axes.fill_between(*band, color=colour, alpha=0.18, lw=0)
        label = " to ".join(appearance.value_text(changed_axis, value) for value in values)
        dash = ("-", "--", ":", "-.")[i % 4]
        axes.plot(line["im"], line["ratio"], dash, color=colour, label=label)
        for item in records_of(effect[effect["at_reference"]]):
            inside = "white" if item["clipped"] else colour
            axes.plot(item["im"], item["ratio"], "o", ms=5, color=colour, mfc=inside)


def _ranked(choices: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return a dict from the label of a headline demand to its rows, smallest change first.

    Added columns: ``bar`` (choice or axis with its values), ``percent`` (change of the demand),
    ``text`` (that change as text) and ``size`` (|ln ratio|, or -1 without a pair).
    """
    # imported here: it loads the solver, and few studies compare choices
    from skewbridge.study.modelling_choices import CHOICES

    labels = {choice.key: choice.label for choice in CHOICES}
    labels |= {varied.name: varied.label for varied in axes_of(choices["name"])}
    percent = 100.0 * (choices["ratio"] - 1.0)
    change = choices["from_value"] + " → " + choices["to_value"]
    texts = percent.map("{:+.1f} %".format).replace({"-0.0 %": "0.0 %", "+0.0 %": "0.0 %"})
    n_of_pairs = ", " + choices["n"].astype(str) + " of " + choices["n_pairs"].astype(str)
    texts += n_of_pairs.where(choices["n"] < choices["n_pairs"], "")
    rows = choices.assign(
        bar=choices["name"].map(labels) + " " + change,
        change=change,
        percent=percent,
        text=texts.where(choices["n"] > 0, "no pair"),
        size=choices["ratio"].map(np.log).abs().where(choices["n"] > 0, -1.0),
    ).sort_values("size", kind="stable")
    demands = demands_for("headline", choices["demand"].unique())
    return {appearance.demand_name(demand): rows[rows["demand"] == demand] for demand in demands}


@mpl.rc_context(appearance.STYLE)
def tornado(choices: pd.DataFrame) -> Figure:
    """Draw the changes of each headline demand by the choices and axes, sorted by size.

    All ``choices`` must belong to one bridge with one abutment model.
    """
    ranked = _ranked(choices)
    bars, rows = max(map(len, ranked.values())), -(-len(ranked) // 2)
    figure = Figure(figsize=(12.5, rows * (0.21 * bars + 0.95) + 0.4), layout="constrained")
    panels = list(figure.subplots(rows, 2, squeeze=False).flat)
    for panel, (label, choices_of_demand) in zip(panels, ranked.items(), strict=False):
        _tornado_panel(panel, choices_of_demand)
        panel.set_title(label, loc="left", fontsize=10, fontweight="bold")
    for panel in panels[len(ranked) :]:
        panel.axis("off")
    handles = [Patch(color=_COLOURS[kind], label=text) for kind, text in _KINDS.items()]
    figure.legend(handles=handles, loc="outside upper right", ncols=2)
    return figure


def _tornado_panel(panel: Axes, rows: pd.DataFrame) -> None:
    rows = rows.assign(place=np.arange(len(rows)))
    paired = rows[rows["n"] > 0]
    limit = max([_LEAST_PCT, *(1.3 * paired["percent"].abs())])
    panel.barh(paired["place"], paired["percent"], height=0.72, color=paired["kind"].map(_COLOURS))
    spans = (100.0 * (paired[["lowest", "highest"]] - 1.0)).clip(-limit, limit)
    panel.hlines(paired["place"], spans["lowest"], spans["highest"], color="#333333", linewidth=0.8)
    for y, text in zip(rows["place"], rows["text"], strict=True):
        row_transform = panel.get_yaxis_transform()
        panel.text(1.01, y, text, transform=row_transform, va="center", fontsize=7.5)
    panel.set_yticks(rows["place"], rows["bar"], fontsize=8)
    panel.set(ylim=(-0.6, len(rows) - 0.4), xlabel="change of the demand (%)")
    panel.axvline(0.0, color="black", linewidth=0.8)
    panel.set_xscale("symlog", linthresh=LINEAR_PCT)
    panel.set_xlim(-limit, limit)
    ticks = [tick for tick in _TICKS_PCT if tick <= limit]
    all_ticks = [*(-tick for tick in reversed(ticks)), 0, *ticks]
    panel.set_xticks(all_ticks, [f"{tick:+d}" if tick else "0" for tick in all_ticks], fontsize=8)
    panel.xaxis.set_minor_locator(NullLocator())
    panel.grid(visible=False, axis="y")


def choice_findings(choices: pd.DataFrame) -> list[str]:
    """Return one sentence per headline demand on choices that change it more than friction does."""
    sentences: list[str] = []
    for label, rows in _ranked(choices).items():
        friction_rows = rows[(rows["name"] == "friction") & (rows["n"] > 0)].sort_index()
        for friction in records_of(friction_rows.head(1)):
            larger = rows[(rows["kind"] == "choice") & (rows["size"] > friction["size"])]
            largest = records_of(larger.iloc[::-1].drop_duplicates("name"))
            sizes = ", ".join(f"{row['bar']} ({row['text']})" for row in largest)
            sentences.append(
                f"{label}: friction {friction['change']} changes it by {friction['text']}; "
                + (f"larger changes: {sizes}." if sizes else "no choice changes it more.")
            )
    return sentences
