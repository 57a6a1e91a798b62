"""Fragility curves by the values of one axis, averaged over all other axes: table and figure."""

from collections.abc import Collection, Mapping
from itertools import cycle
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy import special

from skewbridge.demands.validity import with_derived_columns
from skewbridge.files.tables import Floats, records_of
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.limit_states import COLUMN_FAILURE, HEADLINE_STATES, LimitState
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.union import curve_probability, union_curve
from skewbridge.fragility.verdicts import OK, RATIOS
from skewbridge.report import appearance
from skewbridge.report.answer import short_names
from skewbridge.report.appearance import STYLE, groups_of, in_words
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
    """Return the axis with the largest pooled effect on some demands or states of one model.

    Without such an effect it is the axis with the largest effect on anything else, or the first
    axis with several values in ``table``.
    """
    pooled = effects[(effects["scope"] == "pooled") & (effects["status"] == OK)]
    pooled = pooled[pooled["ratio"] > 0.0]
    of_names = pooled[pooled["demand"].isin(names)]
    rows = of_names if len(of_names) else pooled
    if len(rows):
        sizes = np.abs(np.log(rows["ratio"].to_numpy(np.float64)))
        return axis(str(rows["axis"].iloc[int(sizes.argmax())]))
    axes = axes_of(table.columns)
    return next((candidate for candidate in axes if table[candidate.name].nunique() > 1), axes[0])


def with_system(curves: pd.DataFrame, system: pd.DataFrame) -> pd.DataFrame:
    """Return the preferred curves of all components and of the whole bridge."""
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
    return pd.concat([curves, bridge_curves[bridge_curves["preferred"]]], ignore_index=True)


def pooled_curves(curves: pd.DataFrame, medians: pd.DataFrame) -> pd.DataFrame:
    """Return the curves of each state at each value of its axis with the largest effect.

    theta and the ends of its interval are geometric means over the variants with a curve, and the
    betas are means. All variants have the same motions; the interval is that of equal errors, so
    it is not too narrow. ``ratio`` is the paired ratio of medians to the first value. ``curves``
    are from `with_system`, ``medians`` are the effects on median capacities.

    A failure mode of columns with the same curve as any failure has no row.
    """
    rows: list[dict[str, Any]] = []
    for (bridge, abutment, component), group in groups_of(curves, STATE[:3]):
        effects = medians[(medians["bridge"] == bridge) & (medians["abutment"] == abutment)]
        names = set(component + "/" + group["limit_state"])
        lead = lead_axis(effects, HEADLINE_STATES if component == WHOLE_BRIDGE else names, group)
        effects = effects[(effects["scope"] == "pooled") & (effects["axis"] == lead.name)]
        ratios = {(row["demand"], row["to_value"]): row for row in records_of(effects)}
        for (state,), curves_of_state in groups_of(group, ["limit_state"]):
            if curves_of_state["preferred"].any():
                of_state = {"bridge": bridge, "abutment": abutment, "component": component}
                rows += _by_value(curves_of_state, of_state | {"limit_state": state}, lead, ratios)
    table = pd.DataFrame(rows, columns=[*STATE, *_VALUE_COLUMNS])
    same = ["bridge", "abutment", "component", "value", "theta", "beta_total", "n_exceed"]
    is_mode = (table["component"] == COLUMN_FAILURE) & (table["limit_state"] != "any")
    return table[~(is_mode & table.duplicated(same, keep=False))]


def main_curves(pooled: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the rows of the leading curves: column failure, unseating, the whole bridge."""
    component = pooled["component"]
    kinds = {
        COLUMN_FAILURE: (component == COLUMN_FAILURE) & (pooled["limit_state"] == "any"),
        "unseating": component.str.contains("unseating"),
        WHOLE_BRIDGE: component == WHOLE_BRIDGE,
    }
    return {name: pooled[rows] for name, rows in kinds.items() if rows.any()}


_VALUE_COLUMNS: Final = (
    *("axis", "value", "theta", "theta_low", "theta_high", "beta", "beta_total", "level"),
    *("n_exceed", "n_runs", "n_curves", "n_variants", "n_extrapolated", *RATIOS),
)


def _by_value(
    curves: pd.DataFrame, state: dict[str, Any], lead: Axis, ratios: Mapping[Any, Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Return the rows of one state, one per value of the axis with a curve."""
    rows: list[dict[str, Any]] = []
    for value, at_value in curves.groupby(lead.name):
        with_curve, runs = at_value[at_value["preferred"]], at_value.drop_duplicates("variant")
        names = ["theta", "theta_low", "theta_high"]
        means = np.exp(np.log(with_curve[names].astype(float)).mean()) if len(with_curve) else {}
        row = {**state, "axis": lead.name, "value": value, **means}
        row |= {name: with_curve[name].mean() for name in ("beta", "beta_total", "level")}
        row |= {name: runs[name].sum() for name in ("n_exceed", "n_runs")}
        row |= {"n_curves": len(with_curve), "n_variants": len(runs)}
        row["n_extrapolated"] = int(with_curve["extrapolated"].eq(other=True).sum())
        effect = ratios.get((f"{state['component']}/{state['limit_state']}", value), {})
        if effect.get("status") == OK:
            row |= {name: effect[name] for name in RATIOS}
        elif rows and len(with_curve):  # a system has no table of effects
            row["ratio"] = row["theta"] / rows[0]["theta"]
        if len(with_curve):
            rows.append(row)
    return rows


def state_text(row: Mapping[Any, Any]) -> str:
    """Return component and state of a row of curves with its capacity, unless the name has it."""
    component, state, demand = row["component"], row["limit_state"], row.get("demand", "")
    words = f"{in_words(component)}, {in_words(state)}"
    if component == COLUMN_FAILURE:
        return in_words(component) if state == "any" else words
    if not demand or "dcr" in state:
        return words
    return f"{words} ({appearance.threshold_text(demand, row['threshold'])})"


def three_digits(value: float) -> str:
    """Return a number with three significant digits, such as ``1.60``."""
    return f"{value:#.3g}".rstrip(".")


def value_words(row: Mapping[str, Any], unit: str) -> str:
    """Return a value with its median, and the ratio of medians to the first value."""
    text = f"{appearance.value_text(axis(row['axis']), row['value'])}: "
    text += f"{three_digits(row['theta'])} {unit}{' †' * (row['n_extrapolated'] > 0)}"
    if np.isfinite(row["ratio"]):
        text += f", × {three_digits(row['ratio'])}"
        if np.isfinite(row["ci_low"]):
            text += f" [{', '.join(three_digits(row[end]) for end in RATIOS[1:])}]"
    return text + variants_text(row)


def variants_text(row: Mapping[str, Any]) -> str:
    """Return how many variants have a curve; empty if all have one."""
    are_missing = row["n_curves"] < row["n_variants"]
    return f" ({row['n_curves']}/{row['n_variants']} variants)" if are_missing else ""


@mpl.rc_context(STYLE)
def curves_figure(
    table: pd.DataFrame, curves: pd.DataFrame, demands: pd.DataFrame, columns: int = 3
) -> Figure:
    """Draw pooled curves with bands, one panel per bridge, abutment model and state.

    Ticks are the runs with a known outcome: at the top those that exceed the state, at the bottom
    those that do not. ``table`` is from `pooled_curves`, ``curves`` from `with_system`.
    """
    groups = groups_of(table, STATE)
    rows = -(-len(groups) // columns)
    columns = -(-len(groups) // rows)
    lines = 2 + table.groupby(list(STATE)).size().max()
    height = (1.9 + _LINE_IN * lines) * rows + 0.2
    figure = Figure(figsize=(3.4 * max(columns, 2) + 0.3, height), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    im_column, demands = str(curves["im"].iloc[0]), with_derived_columns(demands)
    im = np.geomspace(0.7 * demands[im_column].min(), 1.3 * demands[im_column].max(), 160)
    names = short_names(curves)
    for axes, (state, own) in zip(panels.flat, groups, strict=False):
        same = (curves[list(STATE)] == list(state)).all(axis=1)
        fits = curves[same]
        words = state_text(records_of(fits)[0])
        several = len(names) > 1
        title = f"{names[state[:2]]}: {words}" if several else words[:1].upper() + words[1:]
        _draw_panel(axes, own, fits, demands, im)
        lead = axis(own["axis"].iloc[0])
        name_lines(axes, title, f"median by {lead.label.lower()}:")
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
    """Draw the curves of one state at the intensities ``im``."""
    lead, unit = axis(of_state["axis"].iloc[0]), appearance.unit_of(str(fits["im"].iloc[0]))
    # a value has the same colour in panels in which other values have no curve
    values = sorted(fits[lead.name].unique())
    colours = dict(zip(values, cycle(appearance.VARIANT_COLOURS), strict=False))
    for row in records_of(of_state):
        color = colours[row["value"]]
        at_value = fits[fits["preferred"] & (fits[lead.name] == row["value"])]
        curves = [np.vstack(curve_values(im, fit)) for fit in records_of(at_value)]
        mean = np.mean(special.ndtri(np.clip(curves, _SURE, 1.0 - _SURE)), axis=0)
        p, low, high = special.ndtr(mean)
        axes.fill_between(im, low, high, color=color, alpha=0.15, linewidth=0)
        axes.plot(im, p, color=color, linewidth=1.6, label=value_words(row, unit))
        if fits["demand"].iloc[0]:
            runs = demands[demands["variant"].isin(at_value["variant"])]
            outcomes = _outcomes(runs, records_of(at_value)[0])
            for hit, y, marker in zip(outcomes, (1.03, -0.03), (2, 3), strict=True):
                x = runs.loc[hit, str(fits["im"].iloc[0])]
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
