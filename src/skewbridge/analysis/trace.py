"""Records of a model during an analysis: rows of numbers, and the layout of their columns.

During the analysis, recorders of OpenSees write binary files. Demands are computed from the rows
afterwards, one column at a time.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from errno import ENOSPC
from itertools import accumulate
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Literal

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.bridge.handles import BridgeModel, Point, SpringHandle

type Series = NDArray[np.float64]

DISP: Final = 6  # components of a node
END_FORCES: Final = 12  # end forces of a column, base first
SECTION: Final = 4  # deformations of a section: axial, about z, about y, torsion
STEP_ROUNDING: Final = 1.0e-6  # rounding of a time that is a sum of steps, over the step


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Columns of a row of records: time first, then nodes, columns, springs, contacts.

    Attributes:
        nodes: Nodes with 6 displacements each; fixed nodes are left out.
        columns: Element tags of the columns, each with 12 end forces.
        sections: (element, integration point) of the hinges, each with 4 deformations.
        springs: Elements whose basic forces are recorded, with the number of components.
        bearings: Elements of the pads, each with 2 global shear forces at the deck's end.
        units: Number of contact units, each with opening, normal and two friction forces.
        centre_node: Node whose relative acceleration (x, y) is recorded.
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
        """Return the first column of the shear forces of a pad."""
        return self._start("bearings") + 2 * self.bearings.index(element)

    def contacts(self, part: Literal["openings", "normals", "tangentials"]) -> slice:
        """Return the columns of a part of the records of the contact units."""
        ends = {"openings": "normals", "normals": "tangentials", "tangentials": "end"}
        return slice(self._start(part), self._start(ends[part]))

    def disp(self, rows: Series, place: int | Point) -> Series:
        """Return the displacements of a node or point in rows, (n, 6); a fixed node has none."""
        if isinstance(place, Point):
            return moved_with(self.disp(rows, place.node), place.arm_m)
        if place not in self.nodes:
            return np.zeros((len(rows), DISP))
        start = self.node(place)
        return rows[:, start : start + DISP]


def moved_with(node: Series, arm_m: tuple[float, float, float]) -> Series:
    """Return the displacements of a point that moves rigidly with a node, both (n, 6).

    Rotations are small, as in a rigid link.
    """
    moved = node.copy()
    moved[:, :3] += np.cross(node[:, 3:], arm_m)
    return moved


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseTrace:
    """All records of an analysis by the layout; row 0 is the state under gravity."""

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

    def disp(self, place: int | Point) -> Series:
        """Displacements and rotations of a node or point since gravity, shape (n, 6)."""
        values = self.position(place)
        return values - values[0]

    def under_gravity_m(self, place: int | Point) -> tuple[float, float]:
        """Plan displacement of a node or point under gravity, from which all others count."""
        x, y = self.layout.disp(self.rows[:1], place)[0, :2].tolist()
        return x, y

    def position(self, place: int | Point) -> Series:
        """Displacements and rotations of a node or point since before gravity, shape (n, 6)."""
        return self.layout.disp(self.rows, place)

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


class Recorder:
    """Records the domain in binary files, one row per committed step.

    The files are in a temporary folder that goes with this object. Reading the same values from
    Python in every step would cost four times as much.
    """

    def __init__(self) -> None:
        self._folder = TemporaryDirectory(prefix="skewbridge-", ignore_cleanup_errors=True)
        self._widths: dict[str, int] = {}
        self._is_open, self._rows = True, 0

    def nodes(self, name: str, nodes: Iterable[int], dofs: int, response: str) -> None:
        """Record a response of the first degrees of freedom of some nodes."""
        tags = tuple(nodes)
        self._widths[name] = dofs * len(tags)
        if tags:
            components = range(1, dofs + 1)
            file = ("-binary", str(self.path(name)), "-time")
            ops.recorder("Node", *file, "-node", *tags, "-dof", *components, response)

    def elements(self, name: str, elements: Iterable[int], *response: str) -> None:
        """Record a response of some elements; `ValueError` if one lacks it (else it is silent)."""
        tags = tuple(elements)
        widths = [len(ops.eleResponse(tag, *response)) for tag in tags]
        if not all(widths):
            raise ValueError(f"element {tags[widths.index(0)]} has no response {response}")
        self._widths[name] = sum(widths)
        if tags:
            file = ("-binary", str(self.path(name)), "-time")
            ops.recorder("Element", *file, "-ele", *tags, *response)

    def record(self) -> None:
        """Record the committed state, which no step of this analysis has made."""
        ops.record()

    def close(self) -> None:
        """Stop recording."""
        if self._is_open:
            ops.remove("recorders")
            self._is_open = False

    def read(self, name: str) -> tuple[Series, Series]:
        """Return times, shape (n,), and values, shape (n, components); `OSError` if incomplete."""
        self.close()
        width = self._widths[name]
        if not width:
            return np.zeros(0), np.zeros((0, 0))
        # a row is the time, the values and a line feed
        row = np.dtype([("values", np.float64, (width + 1,)), ("end", np.uint8)])
        path = self.path(name)
        rows = path.stat().st_size // row.itemsize
        self._rows = self._rows or rows
        if rows != self._rows or rows * row.itemsize != path.stat().st_size:
            raise OSError(ENOSPC, f"the record of {name} is incomplete, disk full?", str(path))
        table = np.fromfile(path, dtype=row)["values"]
        return table[:, 0], table[:, 1:]

    def path(self, name: str) -> Path:
        """Return the file of a record."""
        return Path(self._folder.name) / name


class Monitor:
    """Records a model; the forces of the pads, which only histories need, on request.

    Whoever needs more adds it to `recorder` before `start`.
    """

    def __init__(self, model: BridgeModel, *, bearings: bool = False) -> None:
        self.layout = layout = _layout(model, bearings=bearings)
        self.recorder = recorder = Recorder()
        self._units = () if model.contacts is None else model.contacts.units
        self._trace: ResponseTrace | None = None
        self._is_last_kept = True
        recorder.nodes("accelerations", (layout.centre_node,), 2, "accel")
        recorder.nodes("displacements", layout.nodes, DISP, "disp")
        recorder.elements("columns", layout.columns, "force")
        for element, point in layout.sections:
            response = ("section", str(point), "deformation")
            recorder.elements(f"section {element} {point}", (element,), *response)
        recorder.elements("springs", (element for element, _ in layout.springs), "basicForce")
        recorder.elements("bearings", layout.bearings, "force")
        units = tuple(unit.element for unit in self._units)
        recorder.elements("contact deformations", units, "deformation")
        recorder.elements("contact forces", units, "basicForce")

    def start(self) -> None:
        """Record the state under gravity as the first row."""
        self.recorder.record()

    def drop_last(self) -> None:
        """Leave the last row out of the trace."""
        self._is_last_kept = False

    def extra(self, name: str) -> Series:
        """Return a record that was added, with the rows of the trace."""
        return self.recorder.read(name)[1][: len(self.trace().rows)]

    def trace(self) -> ResponseTrace:
        """Stop recording and return all rows."""
        if self._trace is None:
            self._trace = ResponseTrace(layout=self.layout, rows=self._rows())
        return self._trace

    def _rows(self) -> Series:
        layout, read = self.layout, self.recorder.read
        time_s, accelerations = read("accelerations")
        rows = np.zeros((len(time_s), layout.width))
        rows[:, 0], rows[:, 1:3] = time_s, accelerations
        parts = [read(name)[1] for name in ("displacements", "columns")]
        parts += [read(f"section {e} {point}")[1][:, :SECTION] for e, point in layout.sections]
        parts.append(read("springs")[1])
        if layout.bearings:
            forces = read("bearings")[1].reshape(len(time_s), len(layout.bearings), -1)
            parts.append(forces[:, :, DISP : DISP + 2].reshape(len(time_s), -1))
        if units := len(self._units):
            moved = read("contact deformations")[1].reshape(len(time_s), units, -1)
            forces = read("contact forces")[1].reshape(len(time_s), units, -1)
            parts.append(moved[:, :, 0] + [unit.gap_m for unit in self._units])
            parts.append(-forces[:, :, 0])
            tangential = np.zeros((len(time_s), units, 2))
            tangential[:, :, : forces.shape[2] - 1] = forces[:, :, 1:3]
            parts.append(tangential.reshape(len(time_s), -1))
        at = 3
        for part in parts:
            if part.size:
                rows[:, at : at + part.shape[1]] = part
                at += part.shape[1]
        return rows if self._is_last_kept else rows[:-1]


def _layout(model: BridgeModel, *, bearings: bool) -> Layout:
    nodes = dict.fromkeys(_nodes(model))
    springs = dict.fromkeys(spring.element for end in model.abutments for spring in end.springs)
    return Layout(
        nodes=tuple(node for node in nodes if len(ops.getFixedDOFs(node)) < DISP),
        columns=tuple(column.element for column in model.columns),
        sections=tuple(
            (column.element, point) for column in model.columns for point in column.hinge_sections
        ),
        springs=tuple((element, len(ops.basicForce(element))) for element in springs),
        bearings=tuple(pad.element for end in model.abutments for pad in end.bearings if bearings),
        units=0 if model.contacts is None else len(model.contacts.units),
        centre_node=model.deck_centre_node,
    )


def _nodes(model: BridgeModel) -> Iterable[int]:
    yield model.deck_centre_node
    yield from model.deck_masses_kg
    for column in model.columns:
        yield from (column.base_node, column.top.node)
    for abutment in model.abutments:
        yield abutment.centre.node
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
