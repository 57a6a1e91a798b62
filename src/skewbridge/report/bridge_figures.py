"""Figures of one bridge: its model, static pushes, column sections."""

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.bridge.geometry import Member, ModelGeometry
from skewbridge.bridge.section import MomentCurvature, ShearSection, shear_strength
from skewbridge.files.tables import Floats
from skewbridge.report.appearance import VARIANT_COLOURS, shear_model_name
from skewbridge.units import KN, MM
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
_GAP_SCALE: Final = 20.0  # exaggeration of the drawn gaps
_NORMAL_M: Final = 2.0  # length of the arrows that show contact normals
_HEAD_M: Final = 0.35
_AROUND_M: Final = 2.5  # margin around a drawn abutment or model


def model_figure(geometry: ModelGeometry) -> Figure:
    """Return plan, elevation and right abutment of a model as a figure; gaps are exaggerated."""
    figure = Figure(figsize=(11, 7.5), layout="constrained")
    panels = figure.subplot_mosaic("pp;ea", height_ratios=(3, 4), width_ratios=(3, 2))
    plan_axes, elevation, end_axes = panels["p"], panels["e"], panels["a"]
    for axes in (plan_axes, end_axes):
        _draw_plan(axes, geometry)
    plan_axes.margins(0.03, 0.10)
    _draw_members(elevation, geometry, [0, 2])
    elevation.set(xlabel="x, longitudinal (m)", ylabel="z (m)")
    elevation.set_title("elevation (heights stretched)", fontsize=10)
    corners = np.array(geometry.deck_outline)
    right = corners[corners[:, 0] > corners[:, 0].mean()]
    low, high = right.min(axis=0) - _AROUND_M, right.max(axis=0) + _AROUND_M
    end_axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    end_axes.set_title("right abutment", fontsize=10)
    gap_text = f"; gaps exaggerated {_GAP_SCALE:g} times" if geometry.contacts else ""
    figure.suptitle(f"{geometry.title}{gap_text}")
    entries = [axes.get_legend_handles_labels() for axes in (plan_axes, elevation)]
    unique = {label: handle for pair in entries for handle, label in zip(*pair, strict=True)}
    style: dict[str, Any] = {"loc": "outside lower center", "frameon": False}
    figure.legend(unique.values(), unique.keys(), ncols=len(unique), **style)
    return figure


def _draw_plan(axes: Axes, geometry: ModelGeometry) -> None:
    outline = np.array([*geometry.deck_outline, geometry.deck_outline[0]])
    axes.fill(*outline.T, color=COLOURS["deck"], alpha=0.10, linewidth=0)
    axes.plot(*outline.T, color=COLOURS["deck"], linewidth=1, alpha=0.5)
    _draw_members(axes, geometry, [0, 1])
    if geometry.contacts:
        starts, normals = _contacts(geometry)
        style = {"arrowstyle": "->", "color": COLOURS["contact"]}
        for start, tip in zip(starts, starts + _NORMAL_M * normals, strict=True):
            axes.annotate("", xytext=start[:2], xy=tip[:2], arrowprops=style)
        label = "contact surface and its normal"
        axes.plot(*starts.T[:2], "s", color=COLOURS["contact"], markersize=4, label=label)
    axes.set(xlabel="x, longitudinal (m)", ylabel="y, transverse (m)", aspect="equal")


def _contacts(geometry: ModelGeometry) -> tuple[Floats, Floats]:
    """Return points on contact surfaces with exaggerated gaps, and their normals, each (n, 3)."""
    normals = np.array([(*contact.normal, 0.0) for contact in geometry.contacts])
    gaps_m = np.array([contact.gap_m for contact in geometry.contacts])
    surfaces = np.array([contact.surface for contact in geometry.contacts])
    return surfaces - _GAP_SCALE * gaps_m[:, None] * normals, normals


def _draw_members(axes: Axes, geometry: ModelGeometry, plane: list[int]) -> None:
    """Draw line elements, zero-length springs and supports, projected on the plane of two axes."""
    for group, members in _by_group(geometry).items():
        ends = np.array([member.ends for member in members])
        is_line = (ends[:, 0] != ends[:, 1]).any(axis=1)
        width, order = 2.2 if group in ("deck", "columns") else 1.0, 1 if group == "links" else 2
        style: dict[str, Any] = {"color": COLOURS[group], "label": group}
        # breaks join the lines into one, so that the legend has one entry
        breaks = np.full((int(is_line.sum()), 1, 3), np.nan)
        lines = np.concatenate([ends[is_line], breaks], axis=1).reshape(-1, 3)
        if len(lines):
            axes.plot(*lines[:, plane].T, linewidth=width, zorder=order, **style)
        if len(points := ends[~is_line, 0]) and group not in ("links", "contact"):
            axes.plot(*points[:, plane].T, "o", markersize=3.5, **style)
    if geometry.fixed:
        ground = np.array(geometry.fixed)[:, plane].T
        axes.plot(*ground, "^", color="black", markersize=3, label="ground", zorder=0)


def _by_group(geometry: ModelGeometry) -> dict[str, list[Member]]:
    groups = {group: [m for m in geometry.members if m.group == group] for group in COLOURS}
    return {group: members for group, members in groups.items() if members}


def model_page(geometry: ModelGeometry) -> str:
    """Return a self-contained page with a three-dimensional view of the model.

    The view shows nodes, groups of elements, and contacts with their normals and gaps.
    """
    x, y = zip(*geometry.deck_outline, strict=True)
    soffit = go.Mesh3d(
        x=x, y=y, z=[0.0] * len(x), i=[0, 0], j=[1, 2], k=[2, 3], color=COLOURS["deck"],
        opacity=0.15, name="soffit", showlegend=True, hoverinfo="skip",
    )  # fmt: skip
    groups = [item for item in _by_group(geometry).items() if item[0] != "contact"]
    figure = go.Figure([soffit, *(_group_trace(group, members) for group, members in groups)])
    if geometry.contacts:
        surfaces, normals = _contacts(geometry)
        tips, tangents = surfaces + _NORMAL_M * normals, normals[:, [1, 0, 2]] * (1.0, -1.0, 0.0)
        barbs = [tips - _HEAD_M * (normals + turn * tangents) for turn in (1.0, -1.0)]
        breaks = np.full_like(tips, np.nan)
        arrows = np.stack([surfaces, tips, barbs[0], tips, barbs[1], breaks], axis=1)
        text = [
            f"{contact.name}<br>gap {contact.gap_m / MM:.1f} mm, friction {contact.friction:g}"
            for contact in geometry.contacts
        ]
        name, colour = f"contacts (gaps {_GAP_SCALE:g}x)", COLOURS["contact"]
        marker = {"size": 4, "symbol": "square", "color": colour}
        figure.add_trace(_trace(name, surfaces, text, mode="markers", marker=marker))
        line = {"color": colour, "width": 3}
        figure.add_trace(_trace("contact normals", arrows, mode="lines", line=line))
    marker = {"size": 3, "symbol": "diamond", "color": "black"}
    ground = np.array(geometry.fixed)
    figure.add_trace(_trace("ground", ground, mode="markers", marker=marker))
    # axes of equal scale, and a camera at the side that shows the whole bridge, however long
    eye = {"x": 0.5, "y": -2.2, "z": 1.3}
    points = np.array([*(end for m in geometry.members for end in m.ends), *geometry.fixed])
    low, high = points.min(axis=0) - _AROUND_M, points.max(axis=0) + _AROUND_M
    sizes = 2.6 * (high - low) / (high - low).max()  # in units of plotly's camera
    names = zip("xyz", ("x (m)", "y (m)", "z (m)"), low, high, strict=True)
    figure.update_layout(
        title=geometry.title,
        scene={
            **{f"{name}axis": {"title": title, "range": [a, b]} for name, title, a, b in names},
            "aspectmode": "manual",
            "aspectratio": dict(zip("xyz", sizes.tolist(), strict=True)),
            "camera": {"eye": eye, "projection": {"type": "orthographic"}},
        },
        legend={"itemsizing": "constant", "orientation": "h", "y": 0.0},
        margin={"l": 0, "r": 0, "t": 50, "b": 0},
    )
    return str(figure.to_html(include_plotlyjs=True, full_html=True))


def _group_trace(group: str, members: list[Member]) -> go.Scatter3d:
    """Return the trace of a group of members: lines with marked ends, or points for springs."""
    ends = np.array([[*member.ends, [np.nan] * 3] for member in members])
    text: list[str] = []
    for member in members:
        label = f"{group} {member.tag}" if member.tag else group
        text += [*(f"{label}<br>({x:.2f}, {y:.2f}, {z:.2f}) m" for x, y, z in member.ends), ""]
    line = {"color": COLOURS[group], "width": 6 if group in ("deck", "columns") else 3}
    return _trace(group, ends, text, mode="lines+markers", marker={"size": 2.5}, line=line)


def _trace(name: str, points: Floats, text: list[str] | None = None, **style: Any) -> go.Scatter3d:
    """Return a trace through points; pointing at a point shows its ``text``."""
    x, y, z = points.reshape(-1, 3).T
    hover = "text" if text else "skip"
    return go.Scatter3d(x=x, y=y, z=z, name=name, text=text, hoverinfo=hover, **style)


def ladder_figure(curves: pd.DataFrame, *, title: str) -> Figure:
    """Return a figure of pushes (abutment, angle_deg, disp_m, force_kn), one panel per direction.

    Later abutment models have thinner lines, so that overlaid lines are visible.
    """
    directions = list(curves.groupby("angle_deg"))
    rows = -(-len(directions) // 3)
    figure = Figure(figsize=(11.4, 3.2 * rows + 0.8), layout="constrained")
    panels = figure.subplots(rows, 3, sharex=True, squeeze=False)
    for panel, (angle_deg, pushes) in zip(panels.flat, directions, strict=False):
        for abutment, line in pushes.groupby("abutment", sort=False):
            model_number = list(ABUTMENTS).index(str(abutment))
            colour, width = list(COLOURS.values())[model_number], 3.6 - 0.6 * model_number
            x, y = line["disp_m"] / MM, line["force_kn"] / KN
            panel.plot(x, y, label=abutment, color=colour, linewidth=width)
        panel.set_title(f"push at {angle_deg:g} degrees from x", fontsize=10)
        panel.set_ylim(bottom=0.0)
    for panel in panels[-1]:
        panel.set_xlabel("displacement along the push (mm)")
    figure.supylabel("force along the push (MN)")
    figure.suptitle(title, parse_math=False)
    lines, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(lines, names, loc="outside lower center", ncols=len(names), frameon=False)
    return figure


def column_figure(
    curve: MomentCurvature, shear: ShearSection, axial_n: float, *, title: str
) -> Figure:
    """Return a figure of moment-curvature, also idealised, and shear strength over ductility."""
    figure = Figure(figsize=(10, 4), layout="constrained")
    bend_axes, strength_axes = figure.subplots(1, 2)
    bend_axes.plot(curve.curvature_per_m, curve.moment_nm / 1e6, color="#0072B2", label="section")
    knee, end = curve.yield_curvature_per_m, curve.ultimate_curvature_per_m
    plateau, orange = curve.plastic_moment_nm / 1e6, "#D55E00"
    bend_axes.plot([0.0, knee, end], [0.0, plateau, plateau], "--", color=orange, label="idealised")
    first = curve.first_yield_curvature_per_m, curve.first_yield_moment_nm / 1e6
    bend_axes.plot(*first, "o", color=orange, label="first yield")
    bend_axes.set(xlabel="curvature (1/m)", ylabel="moment (MNm)", xlim=(0, None), ylim=(0, None))
    bend_axes.legend(frameon=False, loc="lower right")
    ductility = np.linspace(1.0, 15.0, 141)
    for (model, demand), colour in zip(SHEAR_MODEL_DEMANDS.items(), VARIANT_COLOURS, strict=False):
        strength_mn = shear_strength(shear, model, axial_n, ductility, ductility) / 1e6
        strength_axes.plot(ductility, strength_mn, color=colour, label=shear_model_name(demand))
    demand = curve.plastic_moment_nm / shear.shear_span_m / 1e6
    strength_axes.axhline(demand, color=orange, linestyle="--", label="plastic shear Mp / L")
    words = "displacement ductility (Kowalsky and Priestley: curvature)"
    strength_axes.set(xlabel=words, ylabel="shear (MN)", ylim=(0, None), xlim=(1, 15))
    strength_axes.legend(frameon=False, fontsize=9)
    figure.suptitle(title, parse_math=False)
    return figure
