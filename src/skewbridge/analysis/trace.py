"""Records of a model during an analysis.

OpenSees recorders write binary files during the analysis. Demands are computed from the files
afterwards, one quantity at a time.
"""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from itertools import accumulate, pairwise
from typing import Any, BinaryIO, Final, cast

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.handles import Point, SpringHandle
from skewbridge.bridge.script_units import UnitSystem

type Series = NDArray[np.float64]

DISP: Final = 6  # displacement components of a node
STEP_ROUNDING: Final = 1.0e-6  # rounding error of a sum of steps, divided by the step


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseTrace:
    """All records of an analysis, n rows each; row 0 is the state under gravity."""

    time_s: Series  # times of the rows
    #: acceleration of the deck's mass centre relative to the ground, (n, 2)
    centre_accel_mps2: Series
    #: displacements and rotations of each node from the unloaded state, (n, 6). Nodes that are not
    #: recorded are fixed.
    nodes: Mapping[int, Series]
    #: global end forces of columns and other plastic elements, base first, (n, 12)
    columns: Mapping[int, Series]
    #: axial strain and curvatures about z, y, ... of each element and integration point.
    sections: Mapping[tuple[int, int], Series]
    springs: Mapping[int, Series]  # basic forces of each spring element, (n, components)
    #: forces along x and y of each pad element, and of fill and piles of integral ends, (n, 2)
    bearings: Mapping[int, Series]
    normals_n: Series  # normal forces of the contact units, compression positive, (n, units)
    tangentials_n: Series  # friction forces of the contact units along t1 and t2, (n, units, 2)
    _disps: dict[int | Point, Series] = field(default_factory=dict[int | Point, Series], init=False)

    def at(self, rows: slice | list[int] | NDArray[np.bool_]) -> "ResponseTrace":
        """Return the trace of the selected rows."""

        def cut(record: Any) -> Any:
            if isinstance(record, dict):
                return {key: series[rows] for key, series in cast(dict[Any, Any], record).items()}
            return record[rows]

        selected = {item.name: cut(getattr(self, item.name)) for item in fields(self) if item.init}
        return ResponseTrace(**selected)

    def position(self, node_or_point: int | Point) -> Series:
        """Return displacements and rotations of a node or point from the unloaded state, (n, 6)."""
        if isinstance(node_or_point, Point):
            disp = self.position(node_or_point.node).copy()
            *_, turn_x, turn_y, turn_z = disp.T
            x, y, z = node_or_point.arm_m
            disp[:, 0] += turn_y * z - turn_z * y
            disp[:, 1] += turn_z * x - turn_x * z
            disp[:, 2] += turn_x * y - turn_y * x
            return disp
        recorded = self.nodes.get(node_or_point)
        return np.zeros((len(self.time_s), DISP)) if recorded is None else recorded

    def disp(self, node_or_point: int | Point) -> Series:
        """Return displacements and rotations of a node or point from the gravity state, (n, 6)."""
        if node_or_point not in self._disps:
            values = self.position(node_or_point)
            self._disps[node_or_point] = values - values[0]
        return self._disps[node_or_point]

    def spring_force(self, handle: SpringHandle) -> Series:
        """Return the force of a spring (N), shape (n,)."""
        return self.springs[handle.element][:, handle.component]


def at_regular_steps(time_s: Series, dt_s: float) -> NDArray[np.bool_]:
    """Return a mask, shape (n,), of the ends of regular steps and the last row.

    Histories use these rows; peaks use all rows.
    """
    steps = time_s / dt_s
    is_regular = np.abs(steps - np.round(steps)) < STEP_ROUNDING
    is_regular[-1] = True
    return is_regular


class Recorder:
    """Records the domain in binary files, one row per committed step and one file per response.

    The files are in memory: cheaper than files on disk, and a process that is killed leaves none.
    Reading the domain from Python would cost four times as much.
    """

    def __init__(self, units: UnitSystem | None = None) -> None:
        self._units = units
        # number of components by tag, for each response (a tuple that starts with Node or Element)
        self._widths: dict[tuple[str, ...], dict[int, int]] = {}
        self._files: dict[tuple[str, ...], BinaryIO] = {}
        self._records: dict[tuple[str, ...], tuple[Series, dict[int, Series]]] = {}

    def nodes(self, nodes: Iterable[int], response: str) -> None:
        """Record a response of nodes, 6 components each."""
        self._widths.setdefault(("Node", response), {}).update(dict.fromkeys(nodes, DISP))

    def elements(self, elements: Iterable[int], *response: str) -> None:
        """Record a response of elements; raise `ValueError` if an element does not have it."""
        widths = self._widths.setdefault(("Element", *response), {})
        for tag in elements:
            widths[tag] = len(ops.eleResponse(tag, *response))
            if not widths[tag]:
                raise ValueError(f"element {tag} has no response {response}")

    def start(self) -> None:
        """Start recording; the first row is the committed state."""
        dofs = ("-dof", *range(1, DISP + 1))
        for key, widths in self._widths.items():
            if not widths:
                self._records[key] = np.zeros(0), {}
                continue
            kind, *response = key
            self._files[key] = file = os.fdopen(os.memfd_create(" ".join(key)), "rb")
            tags = ("-node", *widths, *dofs) if kind == "Node" else ("-ele", *widths)
            path = f"/proc/self/fd/{file.fileno()}"
            ops.recorder(kind, "-binary", path, "-time", *tags, *response)
        ops.record()

    def read(self, kind: str, *response: str) -> tuple[Series, dict[int, Series]]:
        """Stop recording; return times, shape (n,), and values of each tag, (n, components).

        Both are empty for a response (``Node`` or ``Element``) without tags.
        """
        if self._files:
            ops.remove("recorders")
            self._records |= {key: self._record(key, file) for key, file in self._files.items()}
            self._files.clear()
        return self._records[kind, *response]

    def _record(self, key: tuple[str, ...], file: BinaryIO) -> tuple[Series, dict[int, Series]]:
        widths = self._widths[key]
        # a row is the time, the values and a line feed
        layout = np.dtype([("values", np.float64, (sum(widths.values()) + 1,)), ("end", np.uint8)])
        with file:
            rows = np.fromfile(file, layout)["values"]
        offsets = list(accumulate(widths.values(), initial=1))
        records = {
            tag: np.ascontiguousarray(rows[:, start:end])
            for tag, (start, end) in zip(widths, pairwise(offsets), strict=True)
        }
        if self._units is not None:
            for record in records.values():
                record *= self._units.record_factors(key, record.shape[1])
        return rows[:, 0].copy(), records


class Monitor:
    """Records a model. ``bearings`` adds forces of pads and piles, which only histories need.

    Further responses can be added to `recorder` before `start`.

    Attributes:
        nodes: Nodes whose displacements are recorded: all except fully fixed nodes.
        recorder: Recorder of all responses.
    """

    def __init__(self, model: BridgeModel, *, bearings: bool = False) -> None:
        nodes = dict.fromkeys(_nodes(model))
        self.nodes = tuple(node for node in nodes if len(ops.getFixedDOFs(node)) < DISP)
        self.recorder = recorder = Recorder(model.frame.units)
        self._model, self._trace = model, None
        self._is_last_kept = True
        abutments = model.abutments
        self._pads = tuple(
            element
            for abutment in abutments
            for element in (*(pad.element for pad in abutment.bearings), *abutment.ground_elements)
            if bearings
        )
        self._springs = {spring.element for abutment in abutments for spring in abutment.springs}
        self._units = () if model.contacts is None else model.contacts.units
        recorder.nodes((model.frame.centre_node,), "accel")
        recorder.nodes(self.nodes, "disp")
        recorder.elements(model.frame.elements["columns"], "force")
        for column in model.columns:
            for point in column.hinge_sections:
                recorder.elements((column.element,), "section", str(point), "deformation")
        recorder.elements(self._pads, "force")
        recorder.elements(sorted(self._springs), "basicForce")
        recorder.elements((unit.element for unit in self._units), "basicForce")

    def start(self) -> None:
        """Record the state under gravity as the first row."""
        self.recorder.start()

    def drop_last(self) -> None:
        """Omit the last row from the trace."""
        self._is_last_kept = False

    def extra(self, kind: str, *response: str) -> dict[int, Series]:
        """Return a response of each node or element, with the same rows as the trace."""
        rows, found = len(self.trace().time_s), self.recorder.read(kind, *response)[1]
        return {tag: values[:rows] for tag, values in found.items()}

    def trace(self) -> ResponseTrace:
        """Stop recording and return all rows."""
        if self._trace is None:
            trace = self._read()
            self._trace = trace if self._is_last_kept else trace.at(slice(-1))
        return self._trace

    def _read(self) -> ResponseTrace:
        model, read = self._model, self.recorder.read
        time_s, positions = read("Node", "disp")
        forces, basic = read("Element", "force")[1], read("Element", "basicForce")[1]
        contacts = np.zeros((len(time_s), len(self._units), 3))
        for index, unit in enumerate(self._units):
            contacts[:, index] = basic[unit.element][:, :3]
        return ResponseTrace(
            time_s=time_s,
            centre_accel_mps2=read("Node", "accel")[1][model.frame.centre_node][:, :2],
            nodes=positions,
            columns={element: forces[element] for element in model.frame.elements["columns"]},
            sections={
                (column.element, point): read("Element", "section", str(point), "deformation")[1][
                    column.element
                ]
                for column in model.columns
                for point in column.hinge_sections
            },
            springs={element: basic[element] for element in self._springs},
            bearings={pad: forces[pad][:, DISP : DISP + 2] for pad in self._pads},
            normals_n=-contacts[:, :, 0],
            tangentials_n=contacts[:, :, 1:],
        )


def _nodes(model: BridgeModel) -> Iterable[int]:
    yield model.frame.centre_node
    yield from model.frame.loads.masses_kg
    for element in (*model.frame.elements["columns"], *model.frame.elements["deck"]):
        yield from ops.eleNodes(element)  # a script may have nodes without mass
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
    for line in model.inner_pads:
        for bearing in line.bearings:
            yield from (bearing.seat_node, bearing.deck_node)
        for pad in line.pads:
            yield from (point.node for point in pad)
    for joint in model.joints:
        yield from (seat.holder.node for seat in joint.seats)
    if model.contacts is not None:
        for unit in model.contacts.units:
            yield from (unit.node_i, unit.node_j)
