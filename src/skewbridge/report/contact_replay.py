"""Replay of the contacts of a run in plan, as a self-contained page: closures, slip, forces."""

from html import escape
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from skewbridge.bridge.geometry import ModelGeometry, contact_column
from skewbridge.report.appearance import VARIANT_COLOURS
from skewbridge.units import KN

type Points = NDArray[np.float64]

FRAMES: Final = 300
_LONGEST_ARROW: Final = 0.18  # of the deck's length, for the largest force of the run
_DISP_SHARE: Final = 0.08  # of the deck's length, for the largest displacement of the run
_KEY_SHARE: Final = 0.06  # of the deck's length, length of a shear key in the picture
_NEAR_LIMIT: Final = 0.98  # share of the friction limit that counts as slipping
_OPEN, _STICK, _SLIP = "#b8b8b8", VARIANT_COLOURS[1], VARIANT_COLOURS[2]
_FORCE: Final = VARIANT_COLOURS[3]


def replay_page(layout: ModelGeometry, histories: pd.DataFrame, *, title: str) -> str:
    """Return the page: a plan with a time slider over the number of closed contacts.

    It opens at the first contact. Displacements and gaps have the same exaggeration, so that deck
    and wall touch in the picture where they touch in the analysis. The histories are those of
    `analysis.peaks.histories_of` of the same run.
    """
    scene = _Scene(layout, histories)
    rows = _frame_rows(scene.time_s, scene.closed)
    start = int(scene.closed[rows].any(axis=1).argmax())  # 0 without any contact
    figure = make_subplots(rows=2, cols=1, row_heights=[0.75, 0.25], vertical_spacing=0.14)
    *plan, cursor = scene.traces(rows[start])
    rest = _line(scene.rest, "at rest", "#999999", 2, dash="dot")
    count = go.Scattergl(
        x=scene.time_s, y=scene.closed.sum(axis=1), line_shape="hv", line_color=_STICK,
        showlegend=False,
    )  # fmt: skip
    figure.add_traces([rest, *plan], rows=1, cols=1)
    figure.add_traces([count, cursor], rows=2, cols=1)
    animated = [*range(1, 1 + len(plan)), len(plan) + 2]
    figure.frames = [
        go.Frame(name=f"{scene.time_s[row]:.2f}", data=scene.traces(row), traces=animated)
        for row in rows
    ]
    _arrange(figure, scene, title, start)
    return figure.to_html(include_plotlyjs=True, full_html=True, auto_play=False)


class _Scene:
    """Positions in the picture, states and forces of the contacts at every row of the histories.

    Arrays of positions have the shape (rows, points, 2).
    """

    def __init__(self, layout: ModelGeometry, histories: pd.DataFrame) -> None:
        self.contacts, corners = layout.contacts, layout.corners
        self.time_s: Points = histories["t_s"].to_numpy()
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
        self.scale = _round_down(_DISP_SHARE * length_m / largest_m)
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
            # a contact moves as its place on the straight end of the deck between two corners
            first, second = at_rest[self.ends[contact.side]]
            share = (surface - first) @ (second - first) / ((second - first) @ (second - first))
            row[self.ends[contact.side]] = 1.0 - share, share
        self.points = surfaces + self.scale * (weights @ moves)
        # the surface that a contact faces is as far from the deck as the contact is open
        self.surfaces = self.points - self.scale * openings_m[..., None] * normals
        force_kn = self.normal_kn[..., None] * normals - self.friction_kn[..., None] * tangents
        self.tips = self.points + self.m_per_kn * force_kn * self.closed[..., None]
        self.tangents, self.key_m = tangents, 0.5 * _KEY_SHARE * length_m * tangents

    def traces(self, row: int) -> list[go.Scatter]:
        """Return deck, walls, keys, forces and contacts at one row, and the cursor in time."""
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

    def _wall(self, row: int, side: str, is_key: NDArray[np.bool_]) -> Points:
        """Return a backwall as long as the deck's end, through the surfaces of its contacts."""
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


def _broken(*lines: Points) -> Points:
    """Return the points of one line that consists of separate pieces."""
    pieces = [each for line in lines for each in (line, np.full((1, 2), np.nan))]
    return np.vstack([np.empty((0, 2)), *pieces])


def _closed(corners: Points) -> Points:
    return np.concatenate([corners, corners[..., :1, :]], axis=-2)


def _line(
    points: Points, name: str, colour: str, width: int, dash: str = "solid", **more: Any
) -> go.Scatter:
    look, (x, y) = {"color": colour, "width": width, "dash": dash}, points.T
    return go.Scatter(x=x, y=y, mode="lines", line=look, name=name, hoverinfo="skip", **more)


def _frame_rows(time_s: Points, closed: NDArray[np.bool_]) -> list[int]:
    """Return the rows shown: evenly spaced, and no opening or closing between them is lost."""
    even = np.linspace(0, len(time_s) - 1, FRAMES).astype(int)
    changed = np.flatnonzero((closed[1:] != closed[:-1]).any(axis=1)) + 1
    first_after = changed[np.unique(np.searchsorted(even, changed), return_index=True)[1]]
    return sorted({*even.tolist(), *first_after.tolist()})


def _round_down(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (5.0, 2.0, 1.0) if step * power <= value))


def _arrange(figure: go.Figure, scene: _Scene, title: str, start: int) -> None:
    """Label the axes, and add the slider and the buttons."""
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
