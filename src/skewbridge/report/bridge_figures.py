"""Figures of one bridge: its model in plan, elevation and 3D, static pushes, column sections."""

from collections.abc import Iterable
from itertools import cycle
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.bridge.geometry import Member, ModelGeometry, Position
from skewbridge.bridge.moment_curvature import MomentCurvature
from skewbridge.bridge.shear_capacity import ShearSection, shear_strength
from skewbridge.units import KN, MM
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.options import ShearModel

type Break = tuple[None, None, None]

# Okabe and Ito's palette: distinct for every kind of colour vision
COLOURS: Final = {
    "deck": "#0072B2",
    "columns": "#D55E00",
    "bearings": "#009E73",
    "backfill": "#E69F00",
    "contact": "#CC79A7",
    "links": "#999999",
}
DEFAULT_GAP_SCALE: Final = 20.0
_BREAK: Final = (None, None, None)  # between two lines of one trace
_NORMAL_M: Final = 2.0  # length of the arrows that show contact normals
_HEAD_M: Final = 0.35
_EYE: Final = {"x": 0.5, "y": -2.2, "z": 1.3}  # from the side of the bridge
_LONGEST: Final = 2.6  # of the axes, in units of plotly's camera
_AROUND_M: Final = 2.5  # shown around the abutment in its own panel


def model_figure(geometry: ModelGeometry, *, gap_scale: float = DEFAULT_GAP_SCALE) -> Figure:
    """Return plan, elevation and one abutment of a model; gaps are drawn to a scale factor."""
    figure = Figure(figsize=(11, 7.5), layout="constrained")
    panels = figure.subplot_mosaic(
        [["plan", "plan"], ["elevation", "end"]], height_ratios=(3, 4), width_ratios=(3, 2)
    )
    plan, elevation, end = panels["plan"], panels["elevation"], panels["end"]
    for axes in (plan, end):
        _draw_plan(axes, geometry, gap_scale)
    plan.margins(0.03, 0.10)
    _draw_members(elevation, geometry, 0, 2)
    elevation.set(xlabel="x, longitudinal (m)", ylabel="z above soffit (m)")
    elevation.set_title("elevation (heights stretched)", fontsize=10)
    corners = np.array(geometry.deck_outline)
    right = corners[corners[:, 0] > 0.0]
    end.set_xlim(right[:, 0].min() - _AROUND_M, right[:, 0].max() + _AROUND_M)
    end.set_ylim(right[:, 1].min() - _AROUND_M, right[:, 1].max() + _AROUND_M)
    end.set_title("right abutment", fontsize=10)
    gap_text = f"; gaps exaggerated {gap_scale:g} times" if geometry.contacts else ""
    figure.suptitle(f"{geometry.title}{gap_text}")
    handles, labels = elevation.get_legend_handles_labels()
    more, names = plan.get_legend_handles_labels()
    unique = dict(zip([*names, *labels], [*more, *handles], strict=True))
    figure.legend(
        unique.values(), unique.keys(), loc="outside lower center", ncols=len(unique), frameon=False
    )
    return figure


def _draw_plan(axes: Axes, geometry: ModelGeometry, gap_scale: float) -> None:
    outline = np.array([*geometry.deck_outline, geometry.deck_outline[0]])
    axes.fill(*outline.T, color=COLOURS["deck"], alpha=0.10, linewidth=0)
    axes.plot(*outline.T, color=COLOURS["deck"], linewidth=1, alpha=0.5)
    _draw_members(axes, geometry, 0, 1)
    for place in geometry.contacts:
        normal = np.array(place.normal)
        start = np.array(place.surface[:2]) - gap_scale * place.gap_m * normal
        look = {"arrowstyle": "->", "color": COLOURS["contact"]}
        tip = start + _NORMAL_M * normal
        axes.annotate("", xytext=(start[0], start[1]), xy=(tip[0], tip[1]), arrowprops=look)
        axes.plot(*start, marker="s", color=COLOURS["contact"], markersize=4, linestyle="none")
    if geometry.contacts:
        axes.plot([], [], "s", color=COLOURS["contact"], label="contact surface and its normal")
    axes.set(xlabel="x, longitudinal (m)", ylabel="y, transverse (m)")
    axes.set_aspect("equal")


def _draw_members(axes: Axes, geometry: ModelGeometry, across: int, up: int) -> None:
    for group, members in _by_group(geometry):
        lines = [m for m in members if m.ends[0] != m.ends[1]]
        for number, member in enumerate(lines):
            a, b = member.ends
            axes.plot(
                [a[across], b[across]],
                [a[up], b[up]],
                color=COLOURS[group],
                linewidth=2.2 if group in ("deck", "columns") else 1.0,
                label=group if number == 0 else None,
                zorder=1 if group == "links" else 2,
            )
        points = [m.ends[0] for m in members if m.ends[0] == m.ends[1]]
        if points and group not in ("links", "contact"):
            place = np.array(points).T
            axes.plot(
                place[across], place[up], "o", color=COLOURS[group], markersize=3.5, label=group
            )
    if geometry.fixed:
        ground = np.array(geometry.fixed).T
        x, y = ground[across], ground[up]
        axes.plot(x, y, "^", color="black", markersize=3, label="ground", zorder=0)


def _by_group(geometry: ModelGeometry) -> Iterable[tuple[str, list[Member]]]:
    groups = {group: [m for m in geometry.members if m.group == group] for group in COLOURS}
    return [(group, members) for group, members in groups.items() if members]


def model_page(geometry: ModelGeometry, *, gap_scale: float = DEFAULT_GAP_SCALE) -> str:
    """Return a self-contained page with the model in space, to turn and to point at.

    It shows nodes, elements by group, and contacts with their normals and gaps.
    """
    x, y = zip(*geometry.deck_outline, strict=True)
    soffit = go.Mesh3d(
        x=x, y=y, z=[0.0] * len(x), i=[0, 0], j=[1, 2], k=[2, 3], color=COLOURS["deck"],
        opacity=0.15, name="soffit", showlegend=True, hoverinfo="skip",
    )  # fmt: skip
    groups = [(group, own) for group, own in _by_group(geometry) if group != "contact"]
    figure = go.Figure([soffit, *(_group_trace(group, members) for group, members in groups)])
    if geometry.contacts:
        surface, text, arrows = _contact_points(geometry, gap_scale)
        name, colour = f"contacts (gaps {gap_scale:g}x)", COLOURS["contact"]
        figure.add_trace(_marks(name, surface, colour, 4, "square", text=text, hoverinfo="text"))
        figure.add_trace(_line_trace("contact normals", arrows, colour, width=3))
    figure.add_trace(_marks("ground", geometry.fixed, "black", 3, "diamond", hoverinfo="skip"))
    figure.update_layout(
        title=geometry.title,
        scene=_scene(geometry),
        legend={"itemsizing": "constant", "orientation": "h", "y": 0.0},
        margin={"l": 0, "r": 0, "t": 50, "b": 0},
    )
    return str(figure.to_html(include_plotlyjs=True, full_html=True))


def _scene(geometry: ModelGeometry) -> dict[str, Any]:
    """Return axes of equal scale and a camera that shows the whole bridge, however long it is."""
    ends = [end for member in geometry.members for end in member.ends]
    points = np.array([*ends, *geometry.fixed])
    low, high = points.min(axis=0) - _AROUND_M, points.max(axis=0) + _AROUND_M
    sizes = _LONGEST * (high - low) / (high - low).max()
    names = zip("xyz", ("x (m)", "y (m)", "z above soffit (m)"), low, high, strict=True)
    return {
        **{f"{name}axis": {"title": title, "range": [a, b]} for name, title, a, b in names},
        "aspectmode": "manual",
        "aspectratio": dict(zip("xyz", sizes.tolist(), strict=True)),
        "camera": {"eye": _EYE, "projection": {"type": "orthographic"}},
    }


def _group_trace(group: str, members: list[Member]) -> go.Scatter3d:
    """Return one group: lines with their ends marked, springs of no length as points."""
    lines: list[Position | Break] = []
    text: list[str] = []
    for member in members:
        label = f"{group} {member.tag}" if member.tag else group
        lines.extend([*member.ends, _BREAK])
        text.extend([f"{label}<br>({x:.2f}, {y:.2f}, {z:.2f}) m" for x, y, z in member.ends])
        text.append("")
    trace = _line_trace(
        group, lines, COLOURS[group], width=6 if group in ("deck", "columns") else 3
    )
    trace.update(mode="lines+markers", marker={"size": 2.5}, text=text, hoverinfo="text")
    return trace


def _line_trace(
    name: str, points: list[Position | Break], colour: str, *, width: int
) -> go.Scatter3d:
    look = {"color": colour, "width": width}
    return go.Scatter3d(**_xyz(points), mode="lines", name=name, line=look, hoverinfo="skip")


def _marks(
    name: str, points: Iterable[Position], colour: str, size: int, symbol: str, **options: Any
) -> go.Scatter3d:
    look = {"size": size, "symbol": symbol, "color": colour}
    return go.Scatter3d(**_xyz(points), mode="markers", name=name, marker=look, **options)


def _contact_points(
    geometry: ModelGeometry, gap_scale: float
) -> tuple[list[Position], list[str], list[Position | Break]]:
    surface: list[Position] = []
    text: list[str] = []
    arrows: list[Position | Break] = []
    for place in geometry.contacts:
        nx, ny = place.normal
        x, y, z = place.surface
        start = (x - gap_scale * place.gap_m * nx, y - gap_scale * place.gap_m * ny, z)
        tip = (start[0] + _NORMAL_M * nx, start[1] + _NORMAL_M * ny, z)
        barbs = [
            (tip[0] - nx * _HEAD_M + turn * ny, tip[1] - ny * _HEAD_M - turn * nx, z)
            for turn in (-_HEAD_M, _HEAD_M)
        ]
        surface.append(start)
        text.append(f"{place.name}<br>gap {place.gap_m / MM:.1f} mm, friction {place.friction:g}")
        arrows.extend([start, tip, barbs[0], tip, barbs[1], _BREAK])
    return surface, text, arrows


def _xyz(points: Iterable[Position | Break]) -> dict[str, list[float | None]]:
    columns = list(zip(*points, strict=True)) or [(), (), ()]
    return {axis: list(values) for axis, values in zip("xyz", columns, strict=True)}


# Okabe and Ito's palette with one line style per model, in the order of the abutment models, so
# that lines on top of each other show
STYLES: Final = (
    {"color": "#999999", "linestyle": "-", "linewidth": 1.5},
    {"color": "#0072B2", "linestyle": "-", "linewidth": 1.5},
    {"color": "#E69F00", "linestyle": "-", "linewidth": 3.0},
    {"color": "#009E73", "linestyle": "--", "linewidth": 2.0},
    {"color": "#D55E00", "linestyle": ":", "linewidth": 2.0},
)


def ladder_figure(curves: pd.DataFrame, *, title: str) -> Figure:
    """Return pushes (abutment, angle_deg, disp_m, force_kn), a panel per direction."""
    angles = sorted(curves["angle_deg"].unique())
    columns = min(3, len(angles))
    rows = -(-len(angles) // columns)
    figure = Figure(figsize=(3.8 * columns, 3.2 * rows + 0.8), layout="constrained")
    panels = np.atleast_1d(figure.subplots(rows, columns, sharex=True)).ravel()
    for panel, angle in zip(panels, angles, strict=False):
        part = curves[curves["angle_deg"] == angle]
        for abutment, style in zip(ABUTMENTS, cycle(STYLES), strict=False):
            line = part[part["abutment"] == abutment]
            if not line.empty:
                panel.plot(line["disp_m"] / MM, line["force_kn"] / KN, label=abutment, **style)
        panel.set_title(f"push at {angle:g} degrees from x", fontsize=10)
        panel.set_ylim(bottom=0.0)
    for panel in panels[len(angles) :]:
        panel.set_visible(False)
    for panel in panels[max(0, len(angles) - columns) : len(angles)]:
        panel.set_xlabel("displacement along the push (mm)")
    figure.supylabel("force along the push (MN)")
    figure.suptitle(title, parse_math=False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=len(labels), frameon=False, fontsize=9
    )
    return figure


def column_figure(
    curve: MomentCurvature, shear: ShearSection, axial_n: float, *, title: str
) -> Figure:
    """Return moment-curvature with its idealisation, and shear strength against ductility."""
    figure = Figure(figsize=(10, 4), layout="constrained")
    bending, capacity = figure.subplots(1, 2)
    bending.plot(curve.curvature_per_m, curve.moment_nm / 1e6, color="#0072B2", label="section")
    knee, end = curve.yield_curvature_per_m, curve.ultimate_curvature_per_m
    plateau = curve.plastic_moment_nm / 1e6
    bending.plot(
        [0.0, knee, end], [0.0, plateau, plateau], "--", color="#D55E00", label="idealised"
    )
    first = curve.first_yield_curvature_per_m, curve.first_yield_moment_nm / 1e6
    bending.plot(*first, "o", color="#D55E00", label="first yield")
    bending.set(xlabel="curvature (1/m)", ylabel="moment (MNm)", xlim=(0, None), ylim=(0, None))
    bending.legend(frameon=False, loc="lower right")
    ductility = np.linspace(1.0, 15.0, 141)
    models: tuple[tuple[str, ShearModel, str], ...] = (
        ("Caltrans, expected; displacement ductility", "sdc_expected", "#0072B2"),
        ("Caltrans, nominal; displacement ductility", "sdc_nominal", "#56B4E9"),
        ("Kowalsky-Priestley; curvature ductility", "kowalsky_priestley", "#009E73"),
    )
    for label, model, colour in models:
        strength_mn = shear_strength(shear, model, axial_n, ductility, ductility) / 1e6
        capacity.plot(ductility, strength_mn, color=colour, label=label)
    demand = curve.plastic_moment_nm / shear.shear_span_m / 1e6
    capacity.axhline(demand, color="#D55E00", linestyle="--", label="plastic shear Mp / L")
    capacity.set(xlabel="ductility", ylabel="shear (MN)", ylim=(0, None), xlim=(1, 15))
    capacity.legend(frameon=False, fontsize=9)
    figure.suptitle(title, parse_math=False)
    return figure
