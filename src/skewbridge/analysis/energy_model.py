"""What the energy balance asks of a live model: masses, elastic stiffness, who holds a wall."""

from collections.abc import Iterable

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.analysis.trace import DISP
from skewbridge.bridge.handles import BridgeModel

type Matrix = NDArray[np.float64]


def masses_by_node(nodes: Iterable[int]) -> dict[int, Matrix]:
    """Return the six masses (kg, kg m2) of each node that has any."""
    masses = {node: np.array(ops.nodeMass(node), dtype=np.float64) for node in nodes}
    return {node: mass for node, mass in masses.items() if mass.any()}


def elastic_stiffness(element: int) -> Matrix:
    """Return the global stiffness of an elastic beam-column in N, m and rad, shape (12, 12).

    Its basic deformations: axial, two rotations about z, two about y, twist.
    """
    first, last = (np.array(ops.nodeCoord(node)) for node in ops.eleNodes(element))
    length = float(np.linalg.norm(last - first))
    x, y, z = (np.array(ops.eleResponse(element, f"{axis}axis")) for axis in "xyz")
    none, up, across = np.zeros(3), y / length, z / length
    basic = np.array(
        [
            np.concatenate((-x, none, x, none)),
            np.concatenate((up, z, -up, none)),
            np.concatenate((up, none, -up, z)),
            np.concatenate((-across, y, across, none)),
            np.concatenate((-across, none, across, y)),
            np.concatenate((none, -x, none, x)),
        ]
    )
    return basic.T @ np.reshape(ops.eleResponse(element, "basicStiffness"), (6, 6)) @ basic


def held_by_contacts(model: BridgeModel) -> dict[int, tuple[int, ...]]:
    """Return the springs to the ground that hold each massless node of a contact, by node.

    What they take is what the contact gives: there is nothing else at such a node.
    """
    nodes = {unit.node_i for unit in model.contacts.units} if model.contacts else set[int]()
    groups, at_node = model.energy_elements, dict[int, list[int]]()
    for element in ops.getEleTags():
        for node in nodes.intersection(ops.eleNodes(element)):
            at_node.setdefault(node, []).append(element)
    springs, contacts = set(groups["backfill"]), set(groups["contact"])
    grounded = {
        element
        for element in springs
        if any(len(ops.getFixedDOFs(node)) == DISP for node in ops.eleNodes(element))
    }
    return {
        node: tuple(element for element in elements if element in grounded)
        for node, elements in at_node.items()
        if not any(ops.nodeMass(node)) and contacts.union(grounded).issuperset(elements)
    }
