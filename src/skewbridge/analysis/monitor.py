"""Reads the model after each converged step into one row of plain numbers.

Reading is the only thing done while the analysis runs: rows go into one growing array, and the
demands are computed from it afterwards, a column at a time.
"""

from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.bridge.handles import BridgeModel, SpringHandle

type Series = NDArray[np.float64]

_DISP = 6  # components of a node
_END_FORCES = 12  # of a column, base first
_SECTION = 4  # deformations: axial, about z, about y, torsion


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Where the readings stand in a row: time first, then nodes, columns, springs, contacts.

    Attributes:
        nodes: Nodes read, each with 6 displacements; fixed nodes are left out.
        columns: Element tags of the columns, each with 12 end forces.
        sections: (element, integration point) of the hinges, each with 4 deformations.
        springs: Elements whose basic forces are read, with the number of components.
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
        return self._contact_start + 4 * self.units

    @property
    def _column_start(self) -> int:
        return 3 + _DISP * len(self.nodes)

    @property
    def _section_start(self) -> int:
        return self._column_start + _END_FORCES * len(self.columns)

    @property
    def _spring_start(self) -> int:
        return self._section_start + _SECTION * len(self.sections)

    @property
    def _bearing_start(self) -> int:
        return self._spring_start + sum(count for _, count in self.springs)

    @property
    def _contact_start(self) -> int:
        return self._bearing_start + 2 * len(self.bearings)

    def node(self, tag: int) -> int:
        """Return where the displacements of a node start."""
        return 3 + _DISP * self.nodes.index(tag)

    def column(self, element: int) -> int:
        """Return where the end forces of a column start."""
        return self._column_start + _END_FORCES * self.columns.index(element)

    def section(self, element: int, point: int) -> int:
        """Return where the deformations of a hinge section start."""
        return self._section_start + _SECTION * self.sections.index((element, point))

    def spring(self, handle: SpringHandle) -> int:
        """Return where the force of a spring stands."""
        start = self._spring_start
        for element, count in self.springs:
            if element == handle.element:
                return start + handle.component
            start += count
        raise KeyError(handle.element)

    def bearing(self, element: int) -> int:
        """Return where the shear forces of a pad start.

        Raises:
            KeyError: The pads were not read.
        """
        if element not in self.bearings:
            raise KeyError(element)
        return self._bearing_start + 2 * self.bearings.index(element)

    def openings(self) -> slice:
        """Return where the openings of the contact units stand."""
        return slice(self._contact_start, self._contact_start + self.units)

    def normals(self) -> slice:
        """Return where the normal forces of the contact units stand."""
        return slice(self._contact_start + self.units, self._contact_start + 2 * self.units)

    def tangentials(self) -> slice:
        """Return where the friction forces of the contact units stand, two per unit."""
        return slice(self._contact_start + 2 * self.units, self.width)


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
            return np.zeros((len(self.rows), _DISP))
        start = self.layout.node(node)
        values = self.rows[:, start : start + _DISP]
        return values - values[0]

    def column_forces(self, element: int) -> NDArray[np.float64]:
        """Global end forces of a column, shape (n, 12)."""
        start = self.layout.column(element)
        return self.rows[:, start : start + _END_FORCES]

    def section(self, element: int, point: int) -> NDArray[np.float64]:
        """Deformations of a hinge section, shape (n, 4)."""
        start = self.layout.section(element, point)
        return self.rows[:, start : start + _SECTION]

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


class Monitor:
    """Reads a model into rows.

    Args:
        model: Handles of the model.
        bearings: Whether to read the forces of the pads, which only histories show.
    """

    def __init__(self, model: BridgeModel, *, bearings: bool = False) -> None:
        self.layout = _layout(model, bearings=bearings)
        self._contacts = model.contacts
        self._values = array("d")
        self._sections = tuple((e, str(point)) for e, point in self.layout.sections)
        self._springs = tuple(element for element, _ in self.layout.springs)

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
            row += response(element, "section", point, "deformation")
        for element in self._springs:
            row += force(element)
        for element in layout.bearings:
            row += ops.eleForce(element)[_DISP : _DISP + 2]
        contacts = self._contacts
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

    @property
    def count(self) -> int:
        """Number of rows read."""
        return len(self._values) // self.layout.width

    def rows(self, numbers: Sequence[int]) -> NDArray[np.float64]:
        """Return a copy of some rows, counted from 1, shape (len(numbers), width)."""
        first, width = numbers[0], self.layout.width
        block = np.array(self._values[(first - 1) * width :]).reshape(-1, width)
        return block[np.subtract(numbers, first)]

    def trace(self) -> Trace:
        """Return all rows read so far."""
        rows = np.frombuffer(self._values, dtype=np.float64).reshape(-1, self.layout.width)
        return Trace(layout=self.layout, rows=rows)


def _layout(model: BridgeModel, *, bearings: bool) -> Layout:
    springs = _unique(
        handle.element
        for abutment in model.abutments
        for handle in (*abutment.wall_springs, *abutment.key_springs, *abutment.wing_springs)
    )
    return Layout(
        nodes=tuple(node for node in _unique(_nodes(model)) if len(ops.getFixedDOFs(node)) < _DISP),
        columns=tuple(column.element for column in model.columns),
        sections=tuple(
            (column.element, point) for column in model.columns for point in column.hinge_sections
        ),
        springs=tuple((element, len(ops.basicForce(element))) for element in springs),
        bearings=tuple(
            bearing.element
            for abutment in model.abutments
            for bearing in abutment.bearings
            if bearings
        ),
        units=0 if model.contacts is None else len(model.contacts.units),
        centre_node=model.deck_centre_node,
    )


def _nodes(model: BridgeModel) -> Iterable[int]:
    yield model.deck_centre_node
    yield from model.deck_mass_nodes
    for column in model.columns:
        yield from (column.base_node, column.top_node)
    for abutment in model.abutments:
        yield abutment.centre_node
        yield from (corner.node for corner in abutment.corners)
        yield from (bearing.deck_node for bearing in abutment.bearings)
        yield from (*abutment.wall_nodes, *abutment.key_nodes)
        for spring in (*abutment.wall_springs, *abutment.key_springs, *abutment.wing_springs):
            yield from spring.nodes
    if model.contacts is not None:
        for unit in model.contacts.units:
            yield from (unit.node_i, unit.node_j)


def _unique(tags: Iterable[int]) -> tuple[int, ...]:
    return tuple(dict.fromkeys(tags))
