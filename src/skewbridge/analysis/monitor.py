"""Reads the model after each converged step into one row of plain numbers.

Reading is the only thing done while the analysis runs: rows go into one growing array, and the
demands are computed from it afterwards, a column at a time.
"""

from array import array
from collections.abc import Iterable

import numpy as np
import openseespy.opensees as ops

from skewbridge.analysis.trace import DISP, SECTION, Follower, Layout, Trace
from skewbridge.bridge.handles import BridgeModel


class Monitor:
    """Reads a model into rows; the forces of the pads, which only histories show, on request."""

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
            # What stands behind an open contact is no force of the deck: not worth a call.
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

    def trace(self) -> Trace:
        """Return all rows read so far."""
        rows = np.frombuffer(self._values, dtype=np.float64).reshape(-1, self.layout.width)
        return Trace(layout=self.layout, rows=rows)


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
    """Return the contact unit in front of each spring element that has one."""
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
    """Return the deck-side nodes of the abutments where rigid links hold them to their centre."""
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
