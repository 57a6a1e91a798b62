"""Figures of one bridge: its model, static pushes, column sections, and required seat lengths."""

from contextlib import suppress
from dataclasses import replace
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.analysis.bridge_check import seat_demand_aashto_m, seat_demand_sdc_m
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import ModelGeometry
from skewbridge.bridge.section import MomentCurvature, ShearSection, shear_strength
from skewbridge.errors import InputError
from skewbridge.fragility.rates import GAP, Decision
from skewbridge.report.appearance import (
    STYLE,
    VARIANT_COLOURS,
    bridge_unit,
    plain_log_ticks,
    shear_model_name,
    shown_unit,
)
from skewbridge.units import KN, MM, MN
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS
from skewbridge.variant.variant import ABUTMENTS

# palette of Okabe and Ito, distinct for every kind of colour vision
COLOURS: Final = {
    "deck": "#0072B2",
    "columns": "#D55E00",
    "bearings": "#009E73",
    "backfill": "#E69F00",
    "contact": "#CC79A7",
    "links": "#999999",
}
#: Names of groups in legends, if they differ.
_GROUP_NAMES: Final = {"backfill": "backfill, keys, piles"}
#: Lines of the rules of codes.
_DASHES: Final = ((0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)), "-")
_GAP_SCALE: Final = 20.0  # exaggeration of the drawn gaps
_NORMAL_M: Final = 2.0  # length of the arrows that show contact normals
_AROUND_M: Final = 2.5  # margin around a drawn abutment or model


def model_figure(geometry: ModelGeometry) -> Figure:
    """Return plan, elevation and right abutment of a model as a figure; gaps are exaggerated."""
    unit, per_m = bridge_unit()
    lengths = ("surfaces", "gaps_m", "fixed", "deck_outline")
    geometry = replace(
        geometry,
        members={group: per_m * ends for group, ends in geometry.members.items()},
        **{name: per_m * getattr(geometry, name) for name in lengths},
    )
    figure = Figure(figsize=(11, 7.5), layout="constrained")
    panels = figure.subplot_mosaic("pp;ea", height_ratios=(3, 4), width_ratios=(3, 2))
    plan_axes, elevation, end_axes = panels["p"], panels["e"], panels["a"]
    for axes in (plan_axes, end_axes):
        _draw_plan(axes, geometry, per_m * _NORMAL_M)
        axes.set(xlabel=f"x, longitudinal ({unit})", ylabel=f"y, transverse ({unit})")
    plan_axes.margins(0.03, 0.10)
    _draw_members(elevation, geometry, [0, 2])
    elevation.set(xlabel=f"x, longitudinal ({unit})", ylabel=f"z ({unit})")
    elevation.set_title("elevation (heights stretched)", fontsize=10)
    corners = geometry.deck_outline
    right_corners = corners[corners[:, 0] > corners[:, 0].mean()]
    margin = per_m * _AROUND_M
    low, high = right_corners.min(axis=0) - margin, right_corners.max(axis=0) + margin
    end_axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    end_axes.set_title("right abutment", fontsize=10)
    gap_text = f"; gaps exaggerated {_GAP_SCALE:g} times" if len(geometry.gaps_m) else ""
    figure.suptitle(f"{geometry.title}{gap_text}")
    entries = [axes.get_legend_handles_labels() for axes in (plan_axes, elevation)]
    unique = {label: handle for pair in entries for handle, label in zip(*pair, strict=True)}
    style: dict[str, Any] = {"loc": "outside lower center", "frameon": False}
    figure.legend(unique.values(), unique.keys(), ncols=len(unique), **style)
    return figure


def _draw_plan(axes: Axes, geometry: ModelGeometry, normal_length: float) -> None:
    outline = geometry.deck_outline[[*range(len(geometry.deck_outline)), 0]]
    axes.fill(*outline.T, color=COLOURS["deck"], alpha=0.10, linewidth=0)
    axes.plot(*outline.T, color=COLOURS["deck"], linewidth=1, alpha=0.5)
    _draw_members(axes, geometry, [0, 1])
    if len(geometry.gaps_m):
        starts = geometry.surfaces - _GAP_SCALE * geometry.gaps_m[:, None] * geometry.normals
        style = {"arrowstyle": "->", "color": COLOURS["contact"]}
        for start, tip in zip(starts, starts + normal_length * geometry.normals, strict=True):
            axes.annotate("", xytext=start[:2], xy=tip[:2], arrowprops=style)
        label = "contact surface and its normal"
        axes.plot(*starts.T[:2], "s", color=COLOURS["contact"], markersize=4, label=label)
    axes.set_aspect("equal")


def _draw_members(axes: Axes, geometry: ModelGeometry, plane: list[int]) -> None:
    """Draw line elements, zero-length springs and supports, projected on the plane of two axes."""
    for group in COLOURS:
        if not len(ends := geometry.members[group]):
            continue
        is_line = (ends[:, 0] != ends[:, 1]).any(axis=1)
        width, zorder = 2.2 if group in ("deck", "columns") else 1.0, 1 if group == "links" else 2
        style: dict[str, Any] = {"color": COLOURS[group], "label": _GROUP_NAMES.get(group, group)}
        # breaks join the lines into one, so that the legend has one entry
        breaks = np.full((int(is_line.sum()), 1, 3), np.nan)
        lines = np.concatenate([ends[is_line], breaks], axis=1).reshape(-1, 3)
        if len(lines):
            axes.plot(*lines[:, plane].T, linewidth=width, zorder=zorder, **style)
        if len(points := ends[~is_line, 0]) and group not in ("links", "contact"):
            axes.plot(*points[:, plane].T, "o", markersize=3.5, **style)
    ground = geometry.fixed[:, plane].T
    axes.plot(*ground, "^", color="black", markersize=3, label="ground", zorder=0)


def ladder_figure(curves: pd.DataFrame, *, title: str) -> Figure:
    """Return force against displacement of pushes of an abutment, one panel per direction.

    ``curves`` has the columns abutment, angle_deg, disp_m and force_kn. Each abutment model has a
    thinner line than the one before, so that overlaid lines are visible.
    """
    directions = list(curves.groupby("angle_deg"))
    rows = -(-len(directions) // 3)
    figure = Figure(figsize=(11.4, 3.2 * rows + 0.8), layout="constrained")
    panels = figure.subplots(rows, 3, sharex=True, squeeze=False)
    (length_unit, per_mm), (force_unit, per_mn) = shown_unit("mm"), shown_unit("MN")
    for panel, (angle_deg, pushes) in zip(panels.flat, directions, strict=False):
        for abutment, push in pushes.groupby("abutment", sort=False):
            model_number = list(ABUTMENTS).index(str(abutment))
            colour, width = list(COLOURS.values())[model_number], 3.6 - 0.6 * model_number
            x, y = push["disp_m"] * per_mm / MM, push["force_kn"] * per_mn / KN
            panel.plot(x, y, label=abutment, color=colour, linewidth=width)
        panel.set_title(f"push at {angle_deg:g} degrees from x", fontsize=10)
        panel.set_ylim(bottom=0.0)
    for panel in panels[-1]:
        panel.set_xlabel(f"displacement along the push ({length_unit})")
    figure.supylabel(f"force along the push ({force_unit})")
    figure.suptitle(title, parse_math=False)
    lines, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(lines, names, loc="outside lower center", ncols=len(names), frameon=False)
    return figure


def column_figure(
    curve: MomentCurvature, shear: ShearSection, axial_n: float, *, title: str
) -> Figure:
    """Return a figure of moment-curvature, also idealised, and shear strength over ductility.

    The axial force follows the title.
    """
    figure = Figure(figsize=(10, 4), layout="constrained")
    bend_axes, strength_axes = figure.subplots(1, 2)
    (bend_unit, per_m), (moment_unit, moment) = shown_unit("1/m"), shown_unit("MNm")
    (shear_unit, force), (axial_unit, per_kn) = shown_unit("MN"), shown_unit("kN")
    moment, force, orange = moment / MN, force / MN, "#D55E00"
    curvature, moments = per_m * curve.curvature_per_m, moment * curve.moment_nm
    bend_axes.plot(curvature, moments, color="#0072B2", label="section")
    knee, end = per_m * curve.yield_curvature_per_m, per_m * curve.ultimate_curvature_per_m
    plateau = moment * curve.plastic_moment_nm
    bend_axes.plot([0.0, knee, end], [0.0, plateau, plateau], "--", color=orange, label="idealised")
    first_yield = per_m * curve.first_yield_curvature_per_m, moment * curve.first_yield_moment_nm
    bend_axes.plot(*first_yield, "o", color=orange, label="first yield")
    labels = {"xlabel": f"curvature ({bend_unit})", "ylabel": f"moment ({moment_unit})"}
    bend_axes.set(**labels, xlim=(0, None), ylim=(0, None))
    bend_axes.legend(frameon=False, loc="lower right")
    ductility = np.linspace(1.0, 15.0, 141)
    for (model, demand), colour in zip(SHEAR_MODEL_DEMANDS.items(), VARIANT_COLOURS, strict=False):
        strength = force * shear_strength(shear, model, axial_n, ductility, ductility)
        strength_axes.plot(ductility, strength, color=colour, label=shear_model_name(demand))
    plastic = force * curve.plastic_moment_nm / shear.shear_span_m
    strength_axes.axhline(plastic, color=orange, linestyle="--", label="plastic shear Mp / L")
    label = "displacement ductility (Kowalsky and Priestley: curvature)"
    strength_axes.set(xlabel=label, ylabel=f"shear ({shear_unit})", ylim=(0, None), xlim=(1, 15))
    strength_axes.legend(framealpha=1.0, fontsize=9)  # lines may run behind it
    figure.suptitle(f"{title}, {per_kn * axial_n / KN:.0f} {axial_unit}", parse_math=False)
    return figure


def with_codes(decision: Decision, bridge: str) -> Decision:
    """Add the seat lengths of AASHTO and SDC to a decision, if the bridge is known.

    The lengths are for the seat with the largest gap, which the bridge file may state. If it states
    the gaps of all seats, the largest one replaces the gap of the study.
    """
    table = decision.table
    with suppress(InputError):
        description = load_structure(bridge).description
        seats = description.end_seats_m
        stated_mm = [description.gaps_mm[end] for end in seats if end in description.gaps_mm]
        takes_gap = len(stated_mm) < len(seats) or not seats
        gap_mm = np.maximum(takes_gap * table[GAP], max(stated_mm, default=0.0))
        lengths = table.filter(regex=r"^(seat|hazus)_m").columns
        more_m = (gap_mm - table[GAP]) / 1000.0
        table = table.assign(**{name: table[name] + more_m for name in lengths})
        table[GAP] = table[GAP] if takes_gap else gap_mm
        gap_m = gap_mm / 1000.0
        aashto = [
            max((seat_demand_aashto_m(description, end, skew) for end in seats), default=np.nan)
            for skew in table["skew_deg"]
        ]
        sdc = [seat_demand_sdc_m(description, demand_m) for demand_m in table["sdc_demand_m"]]
        shortest_m = min(description.end_seats_m.values(), default=np.nan)
        table = table.assign(aashto_m=aashto + gap_m, sdc_m=sdc + gap_m, present_m=shortest_m)
    return decision._replace(table=table)


@mpl.rc_context(STYLE)
def decision_figure(decision: Decision, title: str) -> Figure:
    """Draw needed seat lengths with the rules of codes, and rates of column failure, over skew."""
    unit, factor = shown_unit("mm")
    unit_per_m, table = 1000.0 * factor, decision.table
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    seats, columns = figure.subplots(1, 2)
    end_gaps = sorted({table[GAP].min(), table[GAP].max()})
    for gap, colour in zip(end_gaps, VARIANT_COLOURS, strict=False):
        rows = table[table[GAP] == gap]
        for axes, name, scale in ((seats, "seat_m", unit_per_m), (columns, "column_rate", 1.0)):
            if name in rows:
                low, middle, high = (scale * rows[f"{name}{end}"] for end in ("_low", "", "_high"))
                label = f"gap {factor * gap:.3g} {unit}, {100 * decision.level:g} % interval"
                axes.fill_between(rows["skew_deg"], low, high, color=colour, alpha=0.18, lw=0)
                axes.plot(rows["skew_deg"], middle, color=colour, lw=2.0, label=label)
    rows = table[table[GAP] == end_gaps[-1]]
    rules = {
        "hazus_m": "Hazus 6.1 factor on skew 0",
        "aashto_m": "AASHTO 4.7.4.4, 1.5 N",
        "sdc_m": "SDC 1.7, 7.8.3",
        "present_m": "seat of the bridge",
    }
    for (name, label), dashes in zip(rules.items(), _DASHES, strict=True):
        if name in rows:
            line = {"ls": dashes, "color": "0.25", "lw": 1.2, "label": label}
            seats.plot(rows["skew_deg"], unit_per_m * rows[name], **line)
    columns.axhline(decision.target, color="#b3202c", lw=1.2, label="target rate")
    labels = f"Seat length, normal ({unit})", "Annual rate of column failure"
    for axes, text in zip((seats, columns), labels, strict=True):
        axes.set(yscale="log", xlabel="Skew (deg)", ylabel=text)
    plain_log_ticks(seats.yaxis)
    legend = dict(zip(*seats.get_legend_handles_labels()[::-1], strict=True))
    legend |= dict(zip(*columns.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(legend.values(), legend, loc="outside lower center", ncols=3, fontsize=8)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure
