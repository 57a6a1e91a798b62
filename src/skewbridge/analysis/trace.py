"""What was read in an analysis: rows of plain numbers and the meaning of their columns."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from skewbridge.bridge.handles import PlanVector, SpringHandle

type Series = NDArray[np.float64]

DISP: Final = 6  # components of a node
END_FORCES: Final = 12  # of a column, base first
SECTION: Final = 4  # deformations: axial, about z, about y, torsion (shear may follow)


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
    """Where the readings stand in a row: time first, then nodes, columns, springs, contacts.

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
        """Numbers in a row."""
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
        """Return where the displacements of a node start."""
        return self._start("nodes") + DISP * self.nodes.index(tag)

    def column(self, element: int) -> int:
        """Return where the end forces of a column start."""
        return self._start("columns") + END_FORCES * self.columns.index(element)

    def section(self, element: int, point: int) -> int:
        """Return where the deformations of a hinge section start."""
        return self._start("sections") + SECTION * self.sections.index((element, point))

    def spring(self, handle: SpringHandle) -> int:
        """Return where the force of a spring stands."""
        elements = [element for element, _ in self.springs]
        before = self.springs[: elements.index(handle.element)]
        return self._start("springs") + sum(count for _, count in before) + handle.component

    def bearing(self, element: int) -> int:
        """Return where the shear forces of a pad start.

        Raises:
            ValueError: The pads were not read.
        """
        return self._start("bearings") + 2 * self.bearings.index(element)

    def contacts(self, part: Literal["openings", "normals", "tangentials"]) -> slice:
        """Return where a part of the readings of the contact units stands."""
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
class Trace:
    """Everything read in an analysis; row 0 is the state under gravity.

    Attributes:
        layout: Meaning of the columns.
        rows: Readings, shape (steps + 1, layout.width).
    """

    layout: Layout
    rows: Series

    def first(self, rows: int) -> "Trace":
        """Return the trace up to a number of rows."""
        return Trace(layout=self.layout, rows=self.rows[:rows])

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
