"""Superstructure: the elastic spine at the centroid, integral caps, masses and dead load.

Heights are measured from the soffit. All dead load is nodal.
"""

from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BridgeData, DeckData
from skewbridge.bridge.column import shear_modulus_pa
from skewbridge.bridge.dead_load import column_weight_n
from skewbridge.bridge.tags import TagAllocator
from skewbridge.units import G_MPS2, GPA, KN

# The node at the mass centre may be a spine node this close to it; shorter elements help nobody.
NEAR_M = 0.05


@dataclass(slots=True, kw_only=True)
class Deck:
    """The built spine, while the model grows.

    Attributes:
        nodes: Spine nodes, left to right.
        x_m: Their positions.
        bent_nodes: Spine node of each bent.
        centre_node: Node at the mass centre.
        elements: Spine and cap elements.
        transformation: Of the spine.
        loads_n: Downward dead load by node.
        moments_nm: Fixed-end moments of the dead load about y, by spine node.
        masses_kg: Translational mass by node.
    """

    nodes: list[int]
    x_m: list[float]
    bent_nodes: list[int]
    centre_node: int
    elements: list[int]
    loads_n: dict[int, float] = field(default_factory=lambda: defaultdict(float))
    moments_nm: dict[int, float] = field(default_factory=dict[int, float])
    masses_kg: dict[int, float] = field(default_factory=lambda: defaultdict(float))


def bent_positions_m(bridge: BridgeData) -> list[float]:
    """Return x of the bents, origin at the middle of the deck."""
    x, positions = -bridge.length_m / 2, list[float]()
    for span in bridge.spans_m[:-1]:
        x += span
        positions.append(x)
    return positions


def mass_centre_m(bridge: BridgeData) -> float:
    """Return x of the mass centre of deck, caps and the upper halves of the columns."""
    line = bridge.deck.line_load_kn_per_m * KN * bridge.length_m
    total, moment = line + 2 * bridge.deck.diaphragm_weight_kn * KN, 0.0
    for x, bent in zip(bent_positions_m(bridge), bridge.bents, strict=True):
        weight = bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent) / 2
        total += weight
        moment += weight * x
    return moment / total


def spine_positions_m(bridge: BridgeData, elements_per_span: int) -> list[float]:
    """Return x of the spine nodes: equal parts per span, and the mass centre."""
    x = [-bridge.length_m / 2]
    for span in bridge.spans_m:
        start = x[-1]
        x.extend(start + span * (i + 1) / elements_per_span for i in range(elements_per_span))
    centre = mass_centre_m(bridge)
    if min(abs(position - centre) for position in x) > NEAR_M:
        x.append(centre)
    return sorted(x)


def build_spine(bridge: BridgeData, elements_per_span: int, tags: TagAllocator) -> Deck:
    """Create the spine with its masses and loads.

    A horizontal member with its local y in plan: Iy bends vertically, Iz in plan.
    """
    deck = bridge.deck
    x = spine_positions_m(bridge, elements_per_span)
    nodes = [tags.node() for _ in x]
    for node, position in zip(nodes, x, strict=True):
        ops.node(node, position, 0.0, deck.centroid_above_soffit_m)
    # ASSUME the prestressed deck stays elastic and uncracked (SDC 1.7 section 5.6)
    transformation = tags.transformation()
    ops.geomTransf("Linear", transformation, 0.0, 0.0, 1.0)
    modulus = deck.elastic_modulus_gpa * GPA
    elements: list[int] = []
    for i, j in pairwise(nodes):
        elements.append(tags.element())
        ops.element(
            *("elasticBeamColumn", elements[-1], i, j, deck.area_m2, modulus),
            *(shear_modulus_pa(modulus), deck.torsion_constant_m4),
            *(deck.inertia_vertical_m4, deck.inertia_transverse_m4, transformation),
        )
    centre = mass_centre_m(bridge)
    spine = Deck(
        nodes=nodes,
        x_m=x,
        bent_nodes=[nodes[_nearest(x, position)] for position in bent_positions_m(bridge)],
        centre_node=nodes[_nearest(x, centre)],
        elements=elements,
    )
    _add_deck_masses(spine, deck)
    return spine


def _nearest(x: list[float], position: float) -> int:
    return min(range(len(x)), key=lambda i: abs(x[i] - position))


def _add_deck_masses(spine: Deck, deck: DeckData) -> None:
    lengths = [b - a for a, b in pairwise(spine.x_m)]
    for i, node in enumerate(spine.nodes):
        tributary = 0.5 * ((lengths[i - 1] if i else 0.0) + (lengths[i] if i < len(lengths) else 0))
        weight = deck.line_load_kn_per_m * KN * tributary
        if i in (0, len(lengths)):
            weight += deck.diaphragm_weight_kn * KN
        mass = weight / G_MPS2
        spine.loads_n[node] += weight
        spine.masses_kg[node] += mass
        # ASSUME the deck's mass is spread over its width and depth; over its tributary length only
        # for rotation in plan, where the deck moves as a rigid body
        across, along = deck.width_m**2 / 12, tributary**2 / 12
        upright = deck.depth_m**2 / 12
        ops.mass(
            *(node, mass, mass, mass),
            *(mass * (across + upright), mass * upright, mass * (across + along)),
        )
    _add_fixed_end_moments(spine, deck, lengths)


def _add_fixed_end_moments(spine: Deck, deck: DeckData, lengths: list[float]) -> None:
    """Complete the lumped line load by its end moments, so that reactions do not feel the mesh."""
    for i, node in enumerate(spine.nodes):
        left = lengths[i - 1] if i else 0.0
        right = lengths[i] if i < len(lengths) else 0.0
        load = deck.line_load_kn_per_m * KN
        spine.moments_nm[node] = load * (right**2 - left**2) / 12


def add_weight(spine: Deck, node: int, weight_n: float, mass_kg: float) -> None:
    """Put further dead load and translational mass on a node.

    Called for caps and columns, whose rotational inertia comes from their positions.
    """
    spine.loads_n[node] += weight_n
    spine.masses_kg[node] += mass_kg
    before = [float(ops.nodeMass(node, dof)) for dof in range(1, 7)]
    ops.mass(node, *(value + mass_kg for value in before[:3]), *before[3:])
