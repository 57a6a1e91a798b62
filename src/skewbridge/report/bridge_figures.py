"""Figures of one bridge: its model, its contacts during a run, static pushes, column sections."""

from html import escape
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from plotly.subplots import make_subplots

from skewbridge.bridge.geometry import Member, ModelGeometry, contact_column
from skewbridge.bridge.section import MomentCurvature, ShearSection, shear_strength
from skewbridge.files.tables import Floats, Mask
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
    plan, elevation, end = panels["p"], panels["e"], panels["a"]
    for axes in (plan, end):
        _draw_plan(axes, geometry)
    plan.margins(0.03, 0.10)
    _draw_members(elevation, geometry, [0, 2])
    elevation.set(xlabel="x, longitudinal (m)", ylabel="z above soffit (m)")
    elevation.set_title("elevation (heights stretched)", fontsize=10)
    corners = np.array(geometry.deck_outline)
    right = corners[corners[:, 0] > corners[:, 0].mean()]
    low, high = right.min(axis=0) - _AROUND_M, right.max(axis=0) + _AROUND_M
    end.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    end.set_title("right abutment", fontsize=10)
    gap_text = f"; gaps exaggerated {_GAP_SCALE:g} times" if geometry.contacts else ""
    figure.suptitle(f"{geometry.title}{gap_text}")
    entries = [axes.get_legend_handles_labels() for axes in (plan, elevation)]
    unique = {label: handle for pair in entries for handle, label in zip(*pair, strict=True)}
    look: dict[str, Any] = {"loc": "outside lower center", "frameon": False}
    figure.legend(unique.values(), unique.keys(), ncols=len(unique), **look)
    return figure


def _draw_plan(axes: Axes, geometry: ModelGeometry) -> None:
    outline = np.array([*geometry.deck_outline, geometry.deck_outline[0]])
    axes.fill(*outline.T, color=COLOURS["deck"], alpha=0.10, linewidth=0)
    axes.plot(*outline.T, color=COLOURS["deck"], linewidth=1, alpha=0.5)
    _draw_members(axes, geometry, [0, 1])
    if geometry.contacts:
        starts, normals = _contacts(geometry)
        look = {"arrowstyle": "->", "color": COLOURS["contact"]}
        for start, tip in zip(starts, starts + _NORMAL_M * normals, strict=True):
            axes.annotate("", xytext=start[:2], xy=tip[:2], arrowprops=look)
        label = "contact surface and its normal"
        axes.plot(*starts.T[:2], "s", color=COLOURS["contact"], markersize=4, label=label)
    axes.set(xlabel="x, longitudinal (m)", ylabel="y, transverse (m)", aspect="equal")


def _contacts(geometry: ModelGeometry) -> tuple[Floats, Floats]:
    """Return points on contact surfaces with exaggerated gaps, and their normals, each (n, 3)."""
    normals = np.array([(*place.normal, 0.0) for place in geometry.contacts])
    gaps_m = np.array([place.gap_m for place in geometry.contacts])
    surfaces = np.array([place.surface for place in geometry.contacts])
    return surfaces - _GAP_SCALE * gaps_m[:, None] * normals, normals


def _draw_members(axes: Axes, geometry: ModelGeometry, plane: list[int]) -> None:
    """Draw line elements, zero-length springs and supports, projected on the plane of two axes."""
    for group, members in _by_group(geometry).items():
        ends = np.array([member.ends for member in members])
        is_line = (ends[:, 0] != ends[:, 1]).any(axis=1)
        wide, order = 2.2 if group in ("deck", "columns") else 1.0, 1 if group == "links" else 2
        look: dict[str, Any] = {"color": COLOURS[group], "label": group}
        # breaks join the lines into one, so that the legend has one entry
        breaks = np.full((int(is_line.sum()), 1, 3), np.nan)
        lines = np.concatenate([ends[is_line], breaks], axis=1).reshape(-1, 3)
        if len(lines):
            axes.plot(*lines[:, plane].T, linewidth=wide, zorder=order, **look)
        if len(points := ends[~is_line, 0]) and group not in ("links", "contact"):
            axes.plot(*points[:, plane].T, "o", markersize=3.5, **look)
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
    groups = [each for each in _by_group(geometry).items() if each[0] != "contact"]
    figure = go.Figure([soffit, *(_group_trace(group, members) for group, members in groups)])
    if geometry.contacts:
        surfaces, normals = _contacts(geometry)
        tips, turned = surfaces + _NORMAL_M * normals, normals[:, [1, 0, 2]] * (1.0, -1.0, 0.0)
        barbs = [tips - _HEAD_M * (normals + turn * turned) for turn in (1.0, -1.0)]
        breaks = np.full_like(tips, np.nan)
        arrows = np.stack([surfaces, tips, barbs[0], tips, barbs[1], breaks], axis=1)
        text = [
            f"{place.name}<br>gap {place.gap_m / MM:.1f} mm, friction {place.friction:g}"
            for place in geometry.contacts
        ]
        name, colour = f"contacts (gaps {_GAP_SCALE:g}x)", COLOURS["contact"]
        mark = {"size": 4, "symbol": "square", "color": colour}
        figure.add_trace(_trace(name, surfaces, text, mode="markers", marker=mark))
        line = {"color": colour, "width": 3}
        figure.add_trace(_trace("contact normals", arrows, mode="lines", line=line))
    mark = {"size": 3, "symbol": "diamond", "color": "black"}
    ground = np.array(geometry.fixed)
    figure.add_trace(_trace("ground", ground, mode="markers", marker=mark))
    # axes of equal scale, and a camera at the side that shows the whole bridge, however long
    eye = {"x": 0.5, "y": -2.2, "z": 1.3}
    points = np.array([*(end for m in geometry.members for end in m.ends), *geometry.fixed])
    low, high = points.min(axis=0) - _AROUND_M, points.max(axis=0) + _AROUND_M
    sizes = 2.6 * (high - low) / (high - low).max()  # in units of plotly's camera
    names = zip("xyz", ("x (m)", "y (m)", "z above soffit (m)"), low, high, strict=True)
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


def _trace(name: str, points: Floats, text: list[str] | None = None, **look: Any) -> go.Scatter3d:
    """Return a trace through points; pointing at a point shows its ``text``."""
    x, y, z = points.reshape(-1, 3).T
    hover = "text" if text else "skip"
    return go.Scatter3d(x=x, y=y, z=z, name=name, text=text, hoverinfo=hover, **look)


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
            place = list(ABUTMENTS).index(str(abutment))
            colour, width = list(COLOURS.values())[place], 3.6 - 0.6 * place
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
    bending, capacity = figure.subplots(1, 2)
    bending.plot(curve.curvature_per_m, curve.moment_nm / 1e6, color="#0072B2", label="section")
    knee, end = curve.yield_curvature_per_m, curve.ultimate_curvature_per_m
    plateau, orange = curve.plastic_moment_nm / 1e6, "#D55E00"
    bending.plot([0.0, knee, end], [0.0, plateau, plateau], "--", color=orange, label="idealised")
    first = curve.first_yield_curvature_per_m, curve.first_yield_moment_nm / 1e6
    bending.plot(*first, "o", color=orange, label="first yield")
    bending.set(xlabel="curvature (1/m)", ylabel="moment (MNm)", xlim=(0, None), ylim=(0, None))
    bending.legend(frameon=False, loc="lower right")
    ductility = np.linspace(1.0, 15.0, 141)
    for (model, demand), colour in zip(SHEAR_MODEL_DEMANDS.items(), VARIANT_COLOURS, strict=False):
        strength_mn = shear_strength(shear, model, axial_n, ductility, ductility) / 1e6
        capacity.plot(ductility, strength_mn, color=colour, label=shear_model_name(demand))
    demand = curve.plastic_moment_nm / shear.shear_span_m / 1e6
    capacity.axhline(demand, color=orange, linestyle="--", label="plastic shear Mp / L")
    words = "displacement ductility (Kowalsky and Priestley: curvature)"
    capacity.set(xlabel=words, ylabel="shear (MN)", ylim=(0, None), xlim=(1, 15))
    capacity.legend(frameon=False, fontsize=9)
    figure.suptitle(title, parse_math=False)
    return figure


# --- replay of the contacts of a run


FRAMES: Final = 300
_LONGEST_ARROW: Final = 0.18  # length of the largest force / length of the deck
_DISP_SHARE: Final = 0.08  # largest drawn displacement / length of the deck
_KEY_SHARE: Final = 0.06  # drawn length of a shear key / length of the deck
_NEAR_LIMIT: Final = 0.98  # share of the friction limit that counts as slipping
_OPEN, _STICK, _SLIP = "#b8b8b8", VARIANT_COLOURS[1], VARIANT_COLOURS[2]
_FORCE: Final = VARIANT_COLOURS[3]


def replay_page(layout: ModelGeometry, histories: pd.DataFrame, *, title: str) -> str:
    """Return a page with an animated plan and the number of closed contacts over time.

    The animation starts at the first contact. Displacements and gaps have the same exaggeration, so
    deck and wall touch in the picture when they touch in the analysis. ``histories`` are from
    `analysis.peaks.histories_of` for the same run.
    """
    scene = _Scene(layout, histories)
    # evenly spaced rows, and the first opening or closing between two of them
    even = np.linspace(0, len(scene.time_s) - 1, FRAMES).astype(int)
    changed = np.flatnonzero((scene.closed[1:] != scene.closed[:-1]).any(axis=1)) + 1
    first_after = changed[np.unique(np.searchsorted(even, changed), return_index=True)[1]]
    rows = sorted({*even.tolist(), *first_after.tolist()})
    start = int(scene.closed[rows].any(axis=1).argmax())  # 0 without any contact
    figure = make_subplots(rows=2, cols=1, row_heights=[0.75, 0.25], vertical_spacing=0.14)
    *plan, cursor = scene.traces(rows[start])
    rest = _line(scene.rest, "at rest", "#999999", 2, dash="dot")
    line, number = {"shape": "hv", "color": _STICK}, scene.closed.sum(axis=1)
    count = go.Scattergl(x=scene.time_s, y=number, line=line, showlegend=False)
    figure.add_traces([rest, *plan], rows=1, cols=1)
    figure.add_traces([count, cursor], rows=2, cols=1)
    animated = [*range(1, 1 + len(plan)), len(plan) + 2]
    figure.frames = [
        go.Frame(name=f"{scene.time_s[row]:.2f}", data=scene.traces(row), traces=animated)
        for row in rows
    ]
    at_once = {"mode": "immediate", "frame": {"duration": 0}}
    play = {"frame": {"duration": 60, "redraw": True}, "fromcurrent": True}
    buttons = (("play", None, play), ("stop", [None], at_once))
    steps = [(frame.name, [frame.name], at_once) for frame in figure.frames]
    slider, menu = (
        [{"label": label, "method": "animate", "args": [*given]} for label, *given in shown]
        for shown in (steps, buttons)
    )
    per_mn = scene.m_per_kn * 1e6 / KN
    figure.update_layout(
        title=f"{escape(title)}<br><sup>displacements and gaps x {scene.scale:g}; 1 MN is "
        f"drawn {per_mn:.2g} m long; contacts: grey open, green sticking, ochre slipping</sup>",
        template="simple_white",
        height=760,
        legend={"orientation": "h", "y": 1.06, "x": 1.0, "xanchor": "right"},
        sliders=[
            {"steps": slider, "active": start, "currentvalue": {"prefix": "t (s) = "},
             "pad": {"t": 40}}
        ],
        updatemenus=[
            {"type": "buttons", "direction": "left", "x": 0.0, "y": 1.06, "buttons": menu}
        ],
    )  # fmt: skip
    figure.update_xaxes(title_text="x (m)", row=1, col=1)
    figure.update_yaxes(title_text="y (m)", scaleanchor="x", scaleratio=1, row=1, col=1)
    figure.update_xaxes(title_text="Time (s)", row=2, col=1)
    figure.update_yaxes(title_text="Contacts closed", row=2, col=1)
    return figure.to_html(include_plotlyjs=True, full_html=True, auto_play=False)


class _Scene:
    """Positions in the picture, states and forces of the contacts at every row of the histories.

    Arrays of positions have the shape (rows, points, 2).
    """

    def __init__(self, layout: ModelGeometry, histories: pd.DataFrame) -> None:
        corners = layout.corners
        # ASSUME one picture of the deck between the abutments: contacts inside it are not drawn
        sides = {corner.side for corner in corners}
        self.contacts = tuple(each for each in layout.contacts if each.side in sides)
        self.time_s: Floats = histories["t_s"].to_numpy()
        self.normal_kn, self.friction_kn, across_kn, openings_m = (
            histories[[f"{contact_column(each.name)}_{end}" for each in self.contacts]].to_numpy()
            for end in ("normal_kn", "friction_1_kn", "friction_2_kn", "opening_m")
        )
        self.closed = self.normal_kn > 0.0
        limit_kn = np.array([contact.friction for contact in self.contacts]) * self.normal_kn
        is_slipping = np.hypot(self.friction_kn, across_kn) >= _NEAR_LIMIT * limit_kn
        self.colours = np.where(self.closed, np.where(is_slipping, _SLIP, _STICK), _OPEN)

        at_rest = np.array([corner.plan_m for corner in corners])
        names = [f"{corner.column}_{axis}_m" for corner in corners for axis in "xy"]
        moves = histories[names].to_numpy().reshape(len(histories), -1, 2)
        length_m = float(np.ptp(at_rest[:, 0]))
        largest_m = max(float(np.abs(moves).max()), 1e-9)
        most = _DISP_SHARE * length_m / largest_m
        steps = 10.0 ** np.floor(np.log10(most)) * np.array([1.0, 2.0, 5.0])
        self.scale = float(steps[steps <= most].max())
        self.m_per_kn = _LONGEST_ARROW * length_m / max(float(self.normal_kn.max()), 1e-9)
        self.rest, self.corners = _closed(at_rest), _closed(at_rest + self.scale * moves)

        normals = np.array([contact.normal for contact in self.contacts])
        tangents = np.array([contact.tangent for contact in self.contacts])
        surfaces = np.array([contact.surface[:2] for contact in self.contacts])
        self.ends = {
            side: [place for place, corner in enumerate(corners) if corner.side == side]
            for side in dict.fromkeys(contact.side for contact in self.contacts)
        }
        weights = np.zeros((len(self.contacts), len(corners)))
        for row, contact, surface in zip(weights, self.contacts, surfaces, strict=True):
            # the motion of a contact is interpolated between the two corners of its deck end
            first, second = at_rest[self.ends[contact.side]]
            share = (surface - first) @ (second - first) / ((second - first) @ (second - first))
            row[self.ends[contact.side]] = 1.0 - share, share
        self.points = surfaces + self.scale * (weights @ moves)
        # the opposite surface is at the distance of the opening from the deck
        self.surfaces = self.points - self.scale * openings_m[..., None] * normals
        force_kn = self.normal_kn[..., None] * normals - self.friction_kn[..., None] * tangents
        self.tips = self.points + self.m_per_kn * force_kn * self.closed[..., None]
        self.tangents, self.key_m = tangents, 0.5 * _KEY_SHARE * length_m * tangents

    def traces(self, row: int) -> list[go.Scatter]:
        """Return the traces of deck, walls, keys, forces, contacts and time cursor at one row."""
        points, surfaces = self.points[row], self.surfaces[row]
        is_key = np.array(["key" in contact.name for contact in self.contacts])
        keys, key_m = surfaces[is_key], self.key_m[is_key]
        walls = [self._wall(row, side, is_key) for side in self.ends]
        texts = [
            f"{contact.name}<br>normal {normal:.0f} kN, friction {friction:.0f} kN"
            for contact, normal, friction in zip(
                self.contacts, self.normal_kn[row], self.friction_kn[row], strict=True
            )
        ]
        marks = {"color": self.colours[row], "size": 9, "line": {"color": "#333333", "width": 0.5}}
        cursor = np.array([[self.time_s[row], 0.0], [self.time_s[row], len(points)]])
        return [
            _line(self.corners[row], "deck", "#44617f", 2, fill="toself",
                  fillcolor="rgba(120,150,190,0.25)"),
            _line(_broken(*walls), "backwalls", "#39434a", 6),
            _line(_broken(*np.stack([keys - key_m, keys + key_m], axis=1)), "shear keys",
                  "#7a5230", 9),
            _line(_broken(*np.stack([points, self.tips[row]], axis=1)), "force on the deck",
                  _FORCE, 2),
            go.Scatter(x=points[:, 0], y=points[:, 1], mode="markers", marker=marks, text=texts,
                       hoverinfo="text", name="contacts"),
            _line(cursor, "time", _FORCE, 1, showlegend=False),
        ]  # fmt: skip

    def _wall(self, row: int, side: str, is_key: Mask) -> Floats:
        """Return the line (n, 2) of a backwall, as long as the deck end, through its contacts."""
        own = [place for place, each in enumerate(self.contacts)
               if each.side == side and not is_key[place]]  # fmt: skip
        if not own:
            return np.empty((0, 2))
        along = self.tangents[own[0]]
        line = self.surfaces[row][sorted(own, key=lambda place: self.surfaces[row][place] @ along)]
        reach = np.sort(self.rest[self.ends[side]] @ along)
        ends = line[[0, -1]]
        first, last = ends + np.outer(reach - ends @ along, along)
        return np.vstack([first, line, last])


def _broken(*lines: Floats) -> Floats:
    """Return the lines joined to one array (n, 2), with a row of NaN after each line."""
    pieces = [each for line in lines for each in (line, np.full((1, 2), np.nan))]
    return np.vstack([np.empty((0, 2)), *pieces])


def _closed(corners: Floats) -> Floats:
    return np.concatenate([corners, corners[..., :1, :]], axis=-2)


def _line(
    points: Floats, name: str, colour: str, width: int, dash: str = "solid", **more: Any
) -> go.Scatter:
    look, (x, y) = {"color": colour, "width": width, "dash": dash}, points.T
    return go.Scatter(x=x, y=y, mode="lines", line=look, name=name, hoverinfo="skip", **more)
