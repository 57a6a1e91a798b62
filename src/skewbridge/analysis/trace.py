"""What was read in an analysis: rows of plain numbers and the meaning of their columns."""

from dataclasses import dataclass
from itertools import accumulate
from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.bridge.handles import SpringHandle

type Series = NDArray[np.float64]

DISP: Final = 6  # components of a node
END_FORCES: Final = 12  # of a column, base first
SECTION: Final = 4  # deformations: axial, about z, about y, torsion


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
    """

    nodes: tuple[int, ...]
    columns: tuple[int, ...]
    sections: tuple[tuple[int, int], ...]
    springs: tuple[tuple[int, int], ...]
    bearings: tuple[int, ...]
    units: int
    centre_node: int

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return self._start("end")

    def _start(self, part: str) -> int:
        """Return where a part of the row starts."""
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

    def openings(self) -> slice:
        """Return where the openings of the contact units stand."""
        return slice(self._start("openings"), self._start("normals"))

    def normals(self) -> slice:
        """Return where the normal forces of the contact units stand."""
        return slice(self._start("normals"), self._start("tangentials"))

    def tangentials(self) -> slice:
        """Return where the friction forces of the contact units stand, two per unit."""
        return slice(self._start("tangentials"), self._start("end"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """Everything read in an analysis; row 0 is the state under gravity.

    Attributes:
        layout: Meaning of the columns.
        rows: Readings, shape (steps + 1, layout.width).
    """

    layout: Layout
    rows: NDArray[np.float64]

    @property
    def time_s(self) -> Series:
        """Times of the rows."""
        return self.rows[:, 0]

    @property
    def centre_accel_mps2(self) -> NDArray[np.float64]:
        """Acceleration of the deck's mass centre relative to the ground, shape (n, 2)."""
        return self.rows[:, 1:3]

    def disp(self, node: int) -> NDArray[np.float64]:
        """Displacements and rotations of a node since gravity, shape (n, 6)."""
        if node not in self.layout.nodes:
            return np.zeros((len(self.rows), DISP))
        start = self.layout.node(node)
        values = self.rows[:, start : start + DISP]
        return values - values[0]

    def column_forces(self, element: int) -> NDArray[np.float64]:
        """Global end forces of a column, shape (n, 12)."""
        start = self.layout.column(element)
        return self.rows[:, start : start + END_FORCES]

    def section(self, element: int, point: int) -> NDArray[np.float64]:
        """Deformations of a hinge section, shape (n, 4)."""
        start = self.layout.section(element, point)
        return self.rows[:, start : start + SECTION]

    def spring_force(self, handle: SpringHandle) -> Series:
        """Force of a spring."""
        return self.rows[:, self.layout.spring(handle)]

    def bearing_force(self, element: int) -> NDArray[np.float64]:
        """Shear forces of a pad along x and y, resisting the deck, shape (n, 2)."""
        start = self.layout.bearing(element)
        return self.rows[:, start : start + 2]

    @property
    def openings_m(self) -> NDArray[np.float64]:
        """Openings of the contact units, shape (n, units)."""
        return self.rows[:, self.layout.openings()]

    @property
    def normals_n(self) -> NDArray[np.float64]:
        """Normal forces of the contact units, compression positive, shape (n, units)."""
        return self.rows[:, self.layout.normals()]

    @property
    def tangentials_n(self) -> NDArray[np.float64]:
        """Friction forces of the contact units, shape (n, units, 2)."""
        values = self.rows[:, self.layout.tangentials()]
        return values.reshape(len(values), self.layout.units, 2)
