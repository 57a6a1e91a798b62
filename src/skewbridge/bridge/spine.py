"""Elastic spine of the deck with its masses and dead loads, which are all nodal loads."""

from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise
from math import cos, radians

import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BridgeData, DeckData
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.section import shear_modulus_pa
from skewbridge.bridge.weights import mass_centre_m, spine_points_m
from skewbridge.units import G_MPS2, GPA, KN


@dataclass(slots=True, kw_only=True)
class Spine:
    """The built spine with nodes from left to right; bents add their elements and dead load.

    ``decks`` are the nodes between joints; ``bent_nodes`` are in the deck or, below bearings, in
    the cap; ``heavy`` end nodes have a diaphragm. Loads are positive downward.
    """

    nodes: list[int]
    decks: list[list[int]]
    heavy: list[int]
    bent_nodes: list[int]
    centre_node: int
    elements: list[int]
    loads_n: dict[int, float] = field(default_factory=lambda: defaultdict(float))
    moments_nm: dict[int, tuple[float, float]] = field(default_factory=dict)

    def masses_kg(self) -> dict[int, float]:
        """Return the horizontal mass at each loaded node."""
        return {node: float(ops.nodeMass(node, 1)) for node in self.loads_n}


def build_spine(
    bridge: BridgeData, elements_per_span: int, skew_deg: float, tags: TagAllocator
) -> Spine:
    """Create the spine with masses and dead loads; Iy is for vertical bending, Iz in plan."""
    deck = bridge.deck
    deck_points = spine_points_m(bridge, elements_per_span)
    x = [x_m for points in deck_points for x_m in points]
    nodes_by_deck = [[tags.node() for _ in points] for points in deck_points]
    nodes = [node for deck in nodes_by_deck for node in deck]
    for node, position in zip(nodes, x, strict=True):
        ops.node(node, position, 0.0, deck.centroid_above_soffit_m)
    # ASSUME the prestressed deck stays elastic and uncracked (SDC 1.7 section 5.6)
    transformation = tags.transformation()
    ops.geomTransf("Linear", transformation, 0.0, 0.0, 1.0)
    modulus = deck.elastic_modulus_gpa * GPA
    inertias = (deck.torsion_constant_m4, deck.inertia_vertical_m4, deck.inertia_transverse_m4)
    section = (deck.area_m2, modulus, shear_modulus_pa(modulus), *inertias)
    node_pairs = [node_pair for points in nodes_by_deck for node_pair in pairwise(points)]
    elements = [tags.element() for _ in node_pairs]
    for element, end_nodes in zip(elements, node_pairs, strict=True):
        ops.element("elasticBeamColumn", element, *end_nodes, *section, transformation)

    def nearest(position: float) -> int:
        return min(zip(nodes, x, strict=True), key=lambda point: abs(point[1] - position))[0]

    caps = [
        node
        for joint, (left, right) in zip(bridge.joints, pairwise(nodes_by_deck), strict=True)
        if joint.at
        for node in (left[-1], right[0])
    ]
    spine = Spine(
        nodes=nodes,
        decks=nodes_by_deck,
        heavy=[nodes[0], nodes[-1], *caps],
        bent_nodes=[nearest(position) for position in bridge.bent_positions_m],
        centre_node=nearest(mass_centre_m(bridge)),
        elements=elements,
    )
    _add_line_load(spine, deck)
    shares = [share for points in deck_points for share in points.values()]
    _add_deck_masses(spine, deck, shares, skew_deg)
    return spine


def _add_line_load(spine: Spine, deck: DeckData) -> None:
    """Add the line load as fixed-end forces, so that reactions do not depend on the mesh."""
    load_n_per_m = deck.line_load_kn_per_m * KN
    for i, j in (node_pair for nodes in spine.decks for node_pair in pairwise(nodes)):
        length_m = float(ops.nodeCoord(j, 1)) - float(ops.nodeCoord(i, 1))
        for node, sign in ((i, 1.0), (j, -1.0)):
            spine.loads_n[node] += load_n_per_m * length_m / 2
            add_moment(spine, node, about_y_nm=sign * load_n_per_m * length_m**2 / 12)
    for node in spine.heavy:
        spine.loads_n[node] += deck.diaphragm_weight_kn * KN


def _add_deck_masses(spine: Spine, deck: DeckData, lengths_m: list[float], skew_deg: float) -> None:
    # ASSUME the deck's mass is uniform over its depth and its plan, a parallelogram: in plan, its
    # strips turn with the length that they have along the skew
    width_term, depth_term = deck.width_m**2 / 12, deck.depth_m**2 / 12
    skewed_term = width_term / cos(radians(skew_deg)) ** 2
    for node, length_m in zip(spine.nodes, lengths_m, strict=True):
        weight_n = deck.line_load_kn_per_m * KN * length_m
        if node in spine.heavy:
            weight_n += deck.diaphragm_weight_kn * KN
        mass_kg = weight_n / G_MPS2
        # half elements at the nodes give far better vertical bending modes of the spans
        vertical_kg = spine.loads_n[node] / G_MPS2
        about_x, about_y = width_term + depth_term, depth_term
        inertias = (mass_kg * about_x, mass_kg * about_y, mass_kg * skewed_term)
        ops.mass(node, mass_kg, mass_kg, vertical_kg, *inertias)


def add_moment(
    spine: Spine, node: int, *, about_x_nm: float = 0.0, about_y_nm: float = 0.0
) -> None:
    """Add a fixed-end moment of the dead load at a node."""
    x, y = spine.moments_nm.get(node, (0.0, 0.0))
    spine.moments_nm[node] = (x + about_x_nm, y + about_y_nm)


def add_weight(spine: Spine, node: int, weight_n: float, mass_kg: float) -> None:
    """Add dead load and translational mass of a cap or column at a node."""
    spine.loads_n[node] += weight_n
    node_masses = [float(ops.nodeMass(node, dof)) for dof in range(1, 7)]
    ops.mass(node, *(mass + mass_kg for mass in node_masses[:3]), *node_masses[3:])
