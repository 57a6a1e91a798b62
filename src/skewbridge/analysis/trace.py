"""Readings of a model during an analysis: rows of numbers, and the layout of their columns.

During the analysis, `Monitor` only appends rows to one growing array. Demands are computed from
the rows afterwards, one column at a time.
"""

from array import array
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Final, Literal

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.bridge.handles import BridgeModel, PlanVector, SpringHandle

type Series = NDArray[np.float64]

DISP: Final = 6  # components of a node
END_FORCES: Final = 12  # end forces of a column, base first
SECTION: Final = 4  # deformations of a section: axial, about z, about y, torsion
STEP_ROUNDING: Final = 1.0e-6  # rounding of a time that is a sum of steps, over the step


@dataclass(frozen=True, slots=True, kw_only=True)
class Follower:
    """A node that moves rigidly with another one at its level.

    Attributes:
        leader: Tag of the other node.
        arm_m: Plan position of the node less that of its leader.
    """

    leader: int
    arm_m: PlanVector


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Columns of a row of readings: time first, then nodes, columns, springs, contacts.

    Attributes:
        nodes: Nodes read, each with 6 displacements; fixed nodes are left out.
        columns: Element tags of the columns, each with 12 end forces.
        sections: (element, integration point) of the hinges, each with 4 deformations.
        springs: Elements whose basic forces are read, with the number of components; zero while
            the contact in front of them is open.
        bearings: Elements of the pads, each with 2 global shear forces at the deck's end.
        units: Number of contact units, each with opening, normal and two friction forces.
        centre_node: Node whose relative acceleration (x, y) is read.
        followers: Nodes that are not read because they follow one that is.
    """

    nodes: tuple[int, ...]
    columns: tuple[int, ...]
    sections: tuple[tuple[int, int], ...]
    springs: tuple[tuple[int, int], ...]
    bearings: tuple[int, ...]
    units: int
    centre_node: int
    followers: Mapping[int, Follower] = field(default_factory=dict[int, Follower])

    @property
    def width(self) -> int:
        """Number of values in a row."""
        return self._start("end")

    def _start(self, part: str) -> int:
        sizes = {
            "nodes": 3,  # after time and two accelerations
            "columns": DISP * len(self.nodes),
            "sections": END_FORCES * len(self.columns),
            "springs": SECTION * len(self.sections),
            "bearings": sum(count for _, count in self.springs),
            "openings": 2 * len(self.bearings),
            "normals": self.units,
            "tangentials": self.units,
            "end": 2 * self.units,
        }
        return dict(zip(sizes, accumulate(sizes.values()), strict=True))[part]

    def node(self, tag: int) -> int:
        """Return the first column of the displacements of a node."""
        return self._start("nodes") + DISP * self.nodes.index(tag)

    def column(self, element: int) -> int:
        """Return the first column of the end forces of a bridge column."""
        return self._start("columns") + END_FORCES * self.columns.index(element)

    def section(self, element: int, point: int) -> int:
        """Return the first column of the deformations of a hinge section."""
        return self._start("sections") + SECTION * self.sections.index((element, point))

    def spring(self, handle: SpringHandle) -> int:
        """Return the column of the force of a spring."""
        elements = [element for element, _ in self.springs]
        before = self.springs[: elements.index(handle.element)]
        return self._start("springs") + sum(count for _, count in before) + handle.component

    def bearing(self, element: int) -> int:
        """Return the first column of the shear forces of a pad.

        Raises:
            ValueError: The pads were not read.
        """
        return self._start("bearings") + 2 * self.bearings.index(element)

    def contacts(self, part: Literal["openings", "normals", "tangentials"]) -> slice:
        """Return the columns of a part of the readings of the contact units."""
        ends = {"openings": "normals", "normals": "tangentials", "tangentials": "end"}
        return slice(self._start(part), self._start(ends[part]))

    def disp(self, rows: Series, node: int) -> Series:
        """Return the displacements of a node in rows, shape (n, 6); a fixed node has none."""
        if follower := self.followers.get(node):
            return moved_with(self.disp(rows, follower.leader), follower.arm_m)
        if node not in self.nodes:
            return np.zeros((len(rows), DISP))
        start = self.node(node)
        return rows[:, start : start + DISP]


def moved_with(leader: Series, arm_m: PlanVector) -> Series:
    """Return the displacements of a point that follows a node at its level, both (n, 6).

    Rotations are small, as in a rigid link.
    """
    x, y = arm_m
    moved = leader.copy()
    moved[:, 0] -= y * leader[:, 5]
    moved[:, 1] += x * leader[:, 5]
    moved[:, 2] += y * leader[:, 3] - x * leader[:, 4]
    return moved


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseTrace:
    """Everything read in an analysis; row 0 is the state under gravity.

    Attributes:
        layout: Meaning of the columns.
        rows: Readings, shape (steps + 1, layout.width).
    """

    layout: Layout
    rows: Series

    def first(self, rows: int) -> "ResponseTrace":
        """Return the trace up to a number of rows."""
        return ResponseTrace(layout=self.layout, rows=self.rows[:rows])

    @property
    def time_s(self) -> Series:
        """Times of the rows."""
        return self.rows[:, 0]

    @property
    def centre_accel_mps2(self) -> Series:
        """Acceleration of the deck's mass centre relative to the ground, shape (n, 2)."""
        return self.rows[:, 1:3]

    def disp(self, node: int) -> Series:
        """Displacements and rotations of a node since gravity, shape (n, 6)."""
        values = self.position(node)
        return values - values[0]

    def under_gravity_m(self, node: int) -> tuple[float, float]:
        """Plan displacement of a node under gravity, from which all others count."""
        x, y = self.layout.disp(self.rows[:1], node)[0, :2].tolist()
        return x, y

    def position(self, node: int) -> Series:
        """Displacements and rotations of a node since before gravity, shape (n, 6)."""
        return self.layout.disp(self.rows, node)

    def column_forces(self, element: int) -> Series:
        """Global end forces of a column, shape (n, 12)."""
        start = self.layout.column(element)
        return self.rows[:, start : start + END_FORCES]

    def section(self, element: int, point: int) -> Series:
        """Deformations of a hinge section, shape (n, 4)."""
        start = self.layout.section(element, point)
        return self.rows[:, start : start + SECTION]

    def spring_force(self, handle: SpringHandle) -> Series:
        """Force of a spring."""
        return self.rows[:, self.layout.spring(handle)]

    def bearing_force(self, element: int) -> Series:
        """Shear forces of a pad along x and y, resisting the deck, shape (n, 2)."""
        start = self.layout.bearing(element)
        return self.rows[:, start : start + 2]

    @property
    def openings_m(self) -> Series:
        """Openings of the contact units, shape (n, units)."""
        return self.rows[:, self.layout.contacts("openings")]

    @property
    def normals_n(self) -> Series:
        """Normal forces of the contact units, compression positive, shape (n, units)."""
        return self.rows[:, self.layout.contacts("normals")]

    @property
    def tangentials_n(self) -> Series:
        """Friction forces of the contact units, shape (n, units, 2)."""
        values = self.rows[:, self.layout.contacts("tangentials")]
        return values.reshape(len(values), self.layout.units, 2)


def at_regular_steps(time_s: Series, dt_s: float) -> NDArray[np.bool_]:
    """Return a mask of the rows at the ends of regular steps, and of the last row, shape (n,).

    Histories use these rows, so that their times are equally spaced. Peaks use all rows, including
    the sub-steps in contact and of retries.
    """
    steps = time_s / dt_s
    kept = np.abs(steps - np.round(steps)) < STEP_ROUNDING
    kept[-1] = True
    return kept


class Monitor:
    """Reads a model into rows; the forces of the pads, which only histories need, on request."""

    def __init__(self, model: BridgeModel, *, bearings: bool = False) -> None:
        self.layout = _layout(model, bearings=bearings)
        self._contacts = model.contacts
        self._values = array("d")
        self._sections = tuple((e, str(point)) for e, point in self.layout.sections)
        units = _units_of_springs(model)
        self._springs = tuple(
            (element, units.get(element), (0.0,) * count) for element, count in self.layout.springs
        )

    def read(self, time_s: float) -> list[float]:
        """Read the committed state, keep it and return it as a row of the layout."""
        layout = self.layout
        row = [time_s, *ops.nodeAccel(layout.centre_node)[:2]]
        # Local names: this runs some forty times a step.
        disp, response, force = ops.nodeDisp, ops.eleResponse, ops.basicForce
        for node in layout.nodes:
            row += disp(node)
        for element in layout.columns:
            row += response(element, "force")
        for element, point in self._sections:
            row += response(element, "section", point, "deformation")[:SECTION]
        contacts = self._contacts
        closed = () if contacts is None else contacts.closed
        for element, unit, nothing in self._springs:
            # A spring behind an open contact does not act on the deck: save the call.
            row += force(element) if unit is None or closed[unit] else nothing
        for element in layout.bearings:
            row += ops.eleForce(element)[DISP : DISP + 2]
        if contacts is not None:
            row += contacts.openings_m
            row += contacts.normals_n
            for pair in contacts.tangentials_n:
                row += pair
        self._values.extend(row)
        return row

    def drop_last(self) -> None:
        """Forget the last row read."""
        del self._values[-self.layout.width :]

    def trace(self) -> ResponseTrace:
        """Return all rows read so far."""
        rows = np.frombuffer(self._values, dtype=np.float64).reshape(-1, self.layout.width)
        return ResponseTrace(layout=self.layout, rows=rows)


def _layout(model: BridgeModel, *, bearings: bool) -> Layout:
    followers = _followers(model)
    nodes = dict.fromkeys(node for node in _nodes(model) if node not in followers)
    springs = dict.fromkeys(spring.element for end in model.abutments for spring in end.springs)
    return Layout(
        nodes=tuple(node for node in nodes if len(ops.getFixedDOFs(node)) < DISP),
        followers=followers,
        columns=tuple(column.element for column in model.columns),
        sections=tuple(
            (column.element, point) for column in model.columns for point in column.hinge_sections
        ),
        springs=tuple((element, len(ops.basicForce(element))) for element in springs),
        bearings=tuple(pad.element for end in model.abutments for pad in end.bearings if bearings),
        units=0 if model.contacts is None else len(model.contacts.units),
        centre_node=model.deck_centre_node,
    )


def _units_of_springs(model: BridgeModel) -> dict[int, int]:
    """Return the contact unit in series with each spring element that has one."""
    return {
        spring.element: unit
        for abutment in model.abutments
        for springs, units in (
            (abutment.wall_springs, abutment.wall_units),
            (abutment.key_springs, abutment.key_units),
        )
        for spring, unit in zip(springs, units, strict=False)
    }


def _followers(model: BridgeModel) -> dict[int, Follower]:
    """Return the deck-side nodes of the abutments that are rigidly linked to their centre."""
    if model.options.arrays != "rigid":
        return {}
    followers: dict[int, Follower] = {}
    for abutment in model.abutments:
        x, y, _ = ops.nodeCoord(abutment.centre_node)
        nodes = [corner.node for corner in abutment.corners]
        nodes += [bearing.deck_node for bearing in abutment.bearings]
        if model.contacts is not None:
            units = (*abutment.wall_units, *abutment.key_units)
            nodes += [model.contacts.units[unit].node_j for unit in units]
        for node in nodes:
            at_x, at_y, _ = ops.nodeCoord(node)
            followers[node] = Follower(leader=abutment.centre_node, arm_m=(at_x - x, at_y - y))
        followers.pop(abutment.centre_node, None)
    return followers


def _nodes(model: BridgeModel) -> Iterable[int]:
    yield model.deck_centre_node
    yield from model.deck_masses_kg
    for column in model.columns:
        yield from (column.base_node, column.top_node)
    for abutment in model.abutments:
        yield abutment.centre_node
        yield from (corner.node for corner in abutment.corners)
        yield from (bearing.deck_node for bearing in abutment.bearings)
        yield from (*abutment.wall_nodes, *abutment.key_nodes)
        for spring in abutment.springs:
            yield from spring.nodes
        for element in abutment.other_springs:
            yield from ops.eleNodes(element)
    if model.contacts is not None:
        for unit in model.contacts.units:
            yield from (unit.node_i, unit.node_j)
