"""Replay of the contacts of a run in plan, as a self-contained page: closures, slip, forces."""

from collections.abc import Sequence
from html import escape
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from skewbridge.bridge.geometry import ContactLayout, ContactPlace, contact_column
from skewbridge.report.axis_layout import VARIANT_COLOURS
from skewbridge.units import KN

type Points = NDArray[np.float64]

FRAMES: Final = 300
_LONGEST_ARROW: Final = 0.18  # of the deck's length, for the largest force of the run
_DISP_SHARE: Final = 0.08  # of the deck's length, for the largest displacement of the run
_KEY_SHARE: Final = 0.06  # of the deck's length, length of a shear key in the picture
_NEAR_LIMIT: Final = 0.98  # share of the friction limit that counts as slipping
_OPEN, _STICK, _SLIP = "#b8b8b8", VARIANT_COLOURS[1], VARIANT_COLOURS[2]
_FORCE: Final = VARIANT_COLOURS[3]
_BREAK: Final = np.full((1, 2), np.nan)  # between two lines of one trace


def replay_page(layout: ContactLayout, histories: pd.DataFrame, *, title: str) -> str:
    """Return the page: a plan with a time slider over the number of closed contacts.

    It opens at the first contact. Displacements and gaps have the same exaggeration, so that deck
    and wall touch in the picture where they touch in the analysis. The histories are those of
    `skewbridge.analysis.histories` of the same run.
    """
    scene = _Scene(layout, histories)
    rows = _frame_rows(scene.time_s, scene.closed)
    start = int(scene.closed[rows].any(axis=1).argmax())  # 0 without any contact
    figure = make_subplots(rows=2, cols=1, row_heights=[0.75, 0.25], vertical_spacing=0.14)
    *plan, cursor = scene.traces(rows[start])
    count = go.Scattergl(
        x=scene.time_s, y=scene.closed.sum(axis=1), line_shape="hv", line_color=_STICK,
        showlegend=False,
    )  # fmt: skip
    figure.add_traces([scene.rest(), *plan], rows=1, cols=1)
    figure.add_traces([count, cursor], rows=2, cols=1)
    animated = [*range(1, 1 + len(plan)), len(plan) + 2]
    figure.frames = [
        go.Frame(name=f"{scene.time_s[row]:.2f}", data=scene.traces(row), traces=animated)
        for row in rows
    ]
    _arrange(figure, scene, title, start)
    return figure.to_html(include_plotlyjs=True, full_html=True, auto_play=False)


class _Scene:
    """Positions, states and forces of the contacts at every row of the histories."""

    def __init__(self, layout: ContactLayout, histories: pd.DataFrame) -> None:
        self.layout = layout
        self.time_s: Points = histories["t_s"].to_numpy()
        contacts = layout.contacts
        self.corners = np.array([corner.plan_m for corner in layout.corners])
        names = [f"{corner.column}_{axis}_m" for corner in layout.corners for axis in "xy"]
        self.moves = histories[names].to_numpy().reshape(len(histories), -1, 2)
        self.rest_points = np.array([contact.surface[:2] for contact in contacts])
        self.normal_kn = _columns(histories, contacts, "normal_kn")
        self.friction_kn = _columns(histories, contacts, "friction_1_kn")
        self.closed = self.normal_kn > 0.0
        across_kn = _columns(histories, contacts, "friction_2_kn")
        limit_kn = np.array([contact.friction for contact in contacts]) * self.normal_kn
        at_limit = np.hypot(self.friction_kn, across_kn) >= _NEAR_LIMIT * limit_kn
        self.slipping = self.closed & at_limit
        self.length_m = float(np.ptp(self.corners[:, 0]))
        largest_m = max(float(np.abs(self.moves).max()), 1e-9)
        self.disp_scale = _round_down(_DISP_SHARE * self.length_m / largest_m)
        largest_kn = max(float(self.normal_kn.max()), 1e-9)
        self.metres_per_kn = _LONGEST_ARROW * self.length_m / largest_kn
        self.openings_m = _columns(histories, contacts, "opening_m")
        self.normals = np.array([contact.normal for contact in contacts])
        self.tangents = np.array([contact.tangent for contact in contacts])
        self._weights = np.array([self._along_edge(contact) for contact in contacts])

    def rest(self) -> go.Scatter:
        """Return the outline of the deck at rest."""
        x, y = _closed(self.corners).T
        return go.Scatter(
            x=x, y=y, mode="lines", line={"color": "#999999", "dash": "dot"}, name="at rest"
        )

    def traces(self, row: int) -> list[go.Scatter]:
        """Return deck, walls, keys, forces and contacts at one row, and the cursor in time."""
        corners = self.corners + self.disp_scale * self.moves[row]
        points = self.rest_points + self.disp_scale * (self._weights @ self.moves[row])
        closed, slipping = self.closed[row], self.slipping[row]
        normal_kn, friction_kn = self.normal_kn[row], self.friction_kn[row]
        colours = np.where(closed, np.where(slipping, _SLIP, _STICK), _OPEN)
        force = normal_kn[:, None] * self.normals - friction_kn[:, None] * self.tangents
        tips = points + self.metres_per_kn * force * closed[:, None]
        # the surface that a contact faces is as far from the deck as the contact is open
        surfaces = points - self.disp_scale * self.openings_m[row][:, None] * self.normals
        time_s = self.time_s[row]
        texts = [
            f"{contact.name}<br>normal {normal:.0f} kN, friction {friction:.0f} kN"
            for contact, normal, friction in zip(
                self.layout.contacts, normal_kn, friction_kn, strict=True
            )
        ]
        marks = {"color": colours, "size": 9, "line": {"color": "#333333", "width": 0.5}}
        return [
            _line(_closed(corners), "deck", "#44617f", 2, fill="toself",
                  fillcolor="rgba(120,150,190,0.25)"),
            _line(self._walls(surfaces), "backwalls", "#39434a", 6),
            _line(self._keys(surfaces), "shear keys", "#7a5230", 9),
            _line(_broken_lines(points, tips), "force on the deck", _FORCE, 2),
            go.Scatter(
                x=points[:, 0], y=points[:, 1], mode="markers", marker=marks, text=texts,
                hoverinfo="text", name="contacts",
            ),
            _line(np.array([[time_s, 0.0], [time_s, len(closed)]]), "time", _FORCE, 1,
                  showlegend=False),
        ]  # fmt: skip

    def _walls(self, surfaces: Points) -> Points:
        """Return the lines of the backwalls through the surfaces of their contacts, shape (n, 2).

        Each wall is as long as the end of the deck.
        """
        lines = [_BREAK]
        for side in dict.fromkeys(contact.side for contact in self.layout.contacts):
            own = [
                at
                for at, contact in enumerate(self.layout.contacts)
                if contact.side == side and "key" not in contact.name
            ]
            if own:
                along = self.tangents[own[0]]
                line = surfaces[sorted(own, key=lambda at: float(surfaces[at] @ along))]
                reach = np.sort(self.corners[self._ends(side)] @ along)
                ends = line[[0, -1]]
                first, last = ends + np.outer(reach - ends @ along, along)
                lines += [np.vstack([first, line, last]), _BREAK]
        return np.vstack(lines)

    def _keys(self, surfaces: Points) -> Points:
        """Return a short line along each shear key through the surface of its contact."""
        keys = ["key" in contact.name for contact in self.layout.contacts]
        at, step = surfaces[keys], 0.5 * _KEY_SHARE * self.length_m * self.tangents[keys]
        return _broken_lines(at - step, at + step)

    def _ends(self, side: str) -> list[int]:
        """Return the two corners of the deck at one abutment."""
        return [i for i, corner in enumerate(self.layout.corners) if corner.side == side]

    def _along_edge(self, contact: ContactPlace) -> Points:
        """Return the weights of the corners whose mean moves as the deck does at a contact."""
        ends = self._ends(contact.side)
        first, second = self.corners[ends]
        edge = second - first
        share = float((np.array(contact.surface[:2]) - first) @ edge / (edge @ edge))
        weights = np.zeros(len(self.corners))
        weights[ends] = 1.0 - share, share
        return weights


def _broken_lines(starts: Points, ends: Points) -> Points:
    """Return the points of one line that consists of separate pieces, shape (3 n, 2)."""
    return np.stack([starts, ends, np.full_like(starts, np.nan)], axis=1).reshape(-1, 2)


def _closed(corners: Points) -> Points:
    return np.vstack([corners, corners[:1]])


def _line(points: Points, name: str, colour: str, width: int, **options: Any) -> go.Scatter:
    look, (x, y) = {"color": colour, "width": width}, points.T
    return go.Scatter(x=x, y=y, mode="lines", line=look, name=name, hoverinfo="skip", **options)


def _columns(histories: pd.DataFrame, contacts: Sequence[ContactPlace], end: str) -> Points:
    return np.column_stack(
        [histories[f"{contact_column(contact.name)}_{end}"] for contact in contacts]
    )


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
    per_mn = scene.metres_per_kn * 1e6 / KN
    figure.update_layout(
        title=f"{escape(title)}<br><sup>displacements and gaps x {scene.disp_scale:g}; 1 MN is "
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
