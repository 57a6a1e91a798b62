"""Superstructure: plan of the skewed deck ends, elastic spine, masses, dead load and reactions.

Positive skew turns the abutment lines counter-clockwise from the transverse axis. The origin is
at the middle of the deck; heights are measured from the soffit. All dead loads are nodal loads.
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from math import cos, radians, sin
from typing import Literal

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BentData, BridgeData, DeckData
from skewbridge.bridge.handles import BridgeModel, PlanVector, TagAllocator
from skewbridge.bridge.section import shear_modulus_pa
from skewbridge.errors import SolutionError
from skewbridge.units import G_MPS2, GPA, KN

type Side = Literal["left", "right"]
#: Line of the pads, or outer face of the end diaphragm, where walls and keys touch it.
type Line = Literal["bearing", "outer"]


@dataclass(frozen=True, slots=True)
class DeckEnd:
    """One end of the deck in plan, with signed skew.

    The bearing lines cross the centreline ``length_m`` apart. ``thickness_m`` is the thickness of
    the end diaphragm, normal to its faces.
    """

    side: Side
    length_m: float
    skew_deg: float
    width_m: float
    thickness_m: float

    @property
    def skew_rad(self) -> float:
        """Signed skew in rad."""
        return radians(self.skew_deg)

    @property
    def sign(self) -> float:
        """+1 at the right end, -1 at the left."""
        return 1.0 if self.side == "right" else -1.0

    @property
    def normal(self) -> PlanVector:
        """Outward normal of the end face."""
        return (self.sign * cos(self.skew_rad), self.sign * sin(self.skew_rad))

    @property
    def inward(self) -> PlanVector:
        """Normal of the backwall, towards the deck."""
        return (-self.normal[0], -self.normal[1])

    @property
    def tangent(self) -> PlanVector:
        """The normal turned by +90 degrees: along the wall."""
        return (-self.normal[1], self.normal[0])

    @property
    def wall_length_m(self) -> float:
        """Length of the end face along the wall."""
        return self.width_m / cos(self.skew_rad)

    @property
    def acute_sign(self) -> float:
        """+1 if the acute corner is at the end of the tangent, else -1; zero skew is positive."""
        return 1.0 if self.skew_rad < 0.0 else -1.0

    def point(self, line: Line, along_m: float) -> PlanVector:
        """Return a point of the joint, ``along_m`` from the centreline along the wall."""
        # ASSUME the pads are under the middle of the end diaphragm
        faces, (x, y) = {"bearing": 0.0, "outer": 0.5}[line], self.tangent
        offset = faces * self.thickness_m * self.sign / cos(self.skew_rad)
        return self.sign * self.length_m / 2 + offset + along_m * x, along_m * y

    def wall_stations(self, count: int) -> list[float]:
        """Return increasing, equally spaced positions (m) along the wall, including corners."""
        half = self.wall_length_m / 2
        return [half * (2 * i / (count - 1) - 1) for i in range(count)]


def tributary_shares(count: int) -> list[float]:
    """Return the share of the wall for each of equally spaced points, including the corners.

    With three or more points, springs with these shares have the rotational stiffness of a
    continuous wall. With half a spacing at each corner, five points would be 12 % stiffer.
    """
    inner = 1.0 / (count - 1)
    shares = [inner / 2 if i in (0, count - 1) else inner for i in range(count)]
    if count > 2:
        # moved inwards from each corner so that the sum of share x position^2 is 1 / 12
        moved = inner / (12 * (1 - inner))
        for corner, next_to_it in ((0, 1), (-1, -2)):
            shares[corner] -= moved
            shares[next_to_it] += moved
    return shares


def continuous_reactions_n(spans_m: tuple[float, ...], load_n_per_m: float) -> list[float]:
    """Return the reactions in N of a continuous beam under uniform load (three-moment equation)."""
    count = len(spans_m)
    moments = np.zeros(count + 1)
    if count > 1:
        left, right = np.array(spans_m[:-1]), np.array(spans_m[1:])
        matrix = np.diag(2 * (left + right))
        matrix += np.diag(right[:-1], 1) + np.diag(right[:-1], -1)
        moments[1:-1] = np.linalg.solve(matrix, load_n_per_m * (left**3 + right**3) / 4)
    reactions = np.zeros(count + 1)
    for i, span in enumerate(spans_m):
        tilt = (moments[i + 1] - moments[i]) / span
        reactions[i] += load_n_per_m * span / 2 - tilt
        reactions[i + 1] += load_n_per_m * span / 2 + tilt
    return reactions.tolist()


def column_weight_n(bridge: BridgeData, bent: BentData) -> float:
    """Return the weight of one column in N."""
    column = bridge.column_of(bent)
    return column.outline.area_m2 * column.unit_weight_kn_per_m3 * KN * bent.clear_height_m


def deck_reactions_n(bridge: BridgeData) -> list[float]:
    """Return the reactions in N of abutments and bents to the deck's weight, left to right."""
    reactions = continuous_reactions_n(bridge.spans_m, bridge.deck.line_load_kn_per_m * KN)
    for end in (0, -1):
        reactions[end] += bridge.deck.diaphragm_weight_kn * KN
    return reactions


def column_axial_n(bridge: BridgeData, bent_number: int) -> float:
    """Return the dead-load axial force in N at the base of each column of a bent (0, 1, ...)."""
    bent, deck = bridge.bents[bent_number], deck_reactions_n(bridge)[bent_number + 1]
    return (deck + bent.cap_weight_kn * KN) / bent.columns + column_weight_n(bridge, bent)


def total_weight_n(bridge: BridgeData) -> float:
    """Return the weight in N of deck, diaphragms, caps and columns."""
    bents = sum(
        bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent)
        for bent in bridge.bents
    )
    return sum(deck_reactions_n(bridge)) + bents


# A spine node within this distance of the mass centre is used as the node there.
NEAR_M = 0.05


@dataclass(slots=True, kw_only=True)
class Deck:
    """The built spine with nodes from left to right; bents add their elements and dead load.

    Nodal loads are positive downward; moments are the fixed-end moments about x and y.
    """

    nodes: list[int]
    bent_nodes: list[int]
    centre_node: int
    elements: list[int]
    loads_n: dict[int, float] = field(default_factory=lambda: defaultdict(float))
    moments_nm: dict[int, tuple[float, float]] = field(default_factory=dict)


def mass_centre_m(bridge: BridgeData) -> float:
    """Return x in m of the mass centre of deck, caps and upper halves of the columns."""
    line = bridge.deck.line_load_kn_per_m * KN * bridge.length_m
    total, moment = line + 2 * bridge.deck.diaphragm_weight_kn * KN, 0.0
    for x, bent in zip(bridge.bent_positions_m, bridge.bents, strict=True):
        weight = bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent) / 2
        total += weight
        moment += weight * x
    return moment / total


def spine_points_m(bridge: BridgeData, elements_per_span: int) -> dict[float, float]:
    """Return the deck length lumped at each spine node, keyed by increasing x coordinate.

    Every span has equal elements. A node added at the mass centre has no mass.
    """
    points: dict[float, float] = {}
    start = -bridge.length_m / 2
    shares = lumping_shares(elements_per_span)
    for span in bridge.spans_m:
        element = span / elements_per_span
        for i, share in enumerate(shares):
            # the last point of a span must equal the first of the next exactly
            x = start + span if i == elements_per_span else start + i * element
            points[x] = points.get(x, 0.0) + share * element
        start += span
    centre = mass_centre_m(bridge)
    if min(abs(x - centre) for x in points) > NEAR_M:
        points[centre] = 0.0
    return dict(sorted(points.items()))


def lumping_shares(elements: int) -> list[float]:
    """Return horizontal masses at the nodes of equal elements, in units of one element's mass.

    Gregory's end-corrected weights have the total, centre and moment of inertia of the continuous
    mass. With half an element at each end node, a deck of 8 elements has 3 % more rotational
    inertia.

    References:
        Davis and Rabinowitz (1984), Methods of Numerical Integration, section 2.9.
    """
    shares = [1.0] * (elements + 1)
    if elements == 1:
        return [0.5, 0.5]
    for i, correction in enumerate((-5 / 8, 1 / 6, -1 / 24)):
        shares[i] += correction
        shares[-1 - i] += correction
    return shares


def build_spine(bridge: BridgeData, elements_per_span: int, tags: TagAllocator) -> Deck:
    """Create the spine with its masses and dead loads.

    The local y axis is in plan: Iy is for vertical bending, Iz for bending in plan.
    """
    deck = bridge.deck
    points = spine_points_m(bridge, elements_per_span)
    x = list(points)
    nodes = [tags.node() for _ in x]
    for node, position in zip(nodes, x, strict=True):
        ops.node(node, position, 0.0, deck.centroid_above_soffit_m)
    # ASSUME the prestressed deck stays elastic and uncracked (SDC 1.7 section 5.6)
    transformation = tags.transformation()
    ops.geomTransf("Linear", transformation, 0.0, 0.0, 1.0)
    modulus = deck.elastic_modulus_gpa * GPA
    inertias = (deck.torsion_constant_m4, deck.inertia_vertical_m4, deck.inertia_transverse_m4)
    section = (deck.area_m2, modulus, shear_modulus_pa(modulus), *inertias)
    elements = [tags.element() for _ in x[1:]]
    for element, ends in zip(elements, pairwise(nodes), strict=True):
        ops.element("elasticBeamColumn", element, *ends, *section, transformation)

    def nearest(position: float) -> int:
        return min(zip(nodes, x, strict=True), key=lambda point: abs(point[1] - position))[0]

    spine = Deck(
        nodes=nodes,
        bent_nodes=[nearest(position) for position in bridge.bent_positions_m],
        centre_node=nearest(mass_centre_m(bridge)),
        elements=elements,
    )
    _add_line_load(spine, deck, x)
    _add_deck_masses(spine, deck, list(points.values()))
    return spine


def _add_line_load(spine: Deck, deck: DeckData, x_m: list[float]) -> None:
    """Add the line load as fixed-end forces, so that reactions do not depend on the mesh."""
    load = deck.line_load_kn_per_m * KN
    for (i, j), (a, b) in zip(pairwise(spine.nodes), pairwise(x_m), strict=True):
        length = b - a
        for node, sign in ((i, 1.0), (j, -1.0)):
            spine.loads_n[node] += load * length / 2
            add_moment(spine, node, about_y_nm=sign * load * length**2 / 12)
    for node in (spine.nodes[0], spine.nodes[-1]):
        spine.loads_n[node] += deck.diaphragm_weight_kn * KN


def _add_deck_masses(spine: Deck, deck: DeckData, lengths_m: list[float]) -> None:
    # ASSUME the deck's mass is uniform over its width and depth
    across, upright = deck.width_m**2 / 12, deck.depth_m**2 / 12
    for node, length in zip(spine.nodes, lengths_m, strict=True):
        weight = deck.line_load_kn_per_m * KN * length
        if node in (spine.nodes[0], spine.nodes[-1]):
            weight += deck.diaphragm_weight_kn * KN
        mass = weight / G_MPS2
        # half elements at the nodes give far better vertical bending modes of the spans
        lifted = spine.loads_n[node] / G_MPS2
        turning = (mass * (across + upright), mass * upright, mass * across)
        ops.mass(node, mass, mass, lifted, *turning)


def add_moment(spine: Deck, node: int, *, about_x_nm: float = 0.0, about_y_nm: float = 0.0) -> None:
    """Add a fixed-end moment of the dead load at a node."""
    x, y = spine.moments_nm.get(node, (0.0, 0.0))
    spine.moments_nm[node] = (x + about_x_nm, y + about_y_nm)


def add_weight(spine: Deck, node: int, weight_n: float, mass_kg: float) -> None:
    """Add dead load and translational mass at a node.

    Used for caps and columns, whose rotational inertia follows from the positions of their nodes.
    """
    spine.loads_n[node] += weight_n
    before = [float(ops.nodeMass(node, dof)) for dof in range(1, 7)]
    ops.mass(node, *(value + mass_kg for value in before[:3]), *before[3:])


GRAVITY_STEPS = 5
_TOLERANCE_M = 1.0e-10


class GravityError(SolutionError):
    """The gravity analysis of a model did not converge."""


def hold_dead_load(
    loads_n: Mapping[int, float],
    moments_nm: Mapping[int, tuple[float, float]],
    tags: TagAllocator,
) -> None:
    """Apply and hold downward loads and moments about x and y at nodes; set the time to zero.

    The loads are nodal because the corotational transformation ignores element loads. Raises
    `GravityError` if there is no equilibrium.
    """
    open_linear_pattern(tags)
    for node, load_n in loads_n.items():
        ops.load(node, 0.0, 0.0, -load_n, *moments_nm.get(node, (0.0, 0.0)), 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", _TOLERANCE_M, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / GRAVITY_STEPS)
    ops.analysis("Static", "-noWarnings")
    if ops.analyze(GRAVITY_STEPS) != 0:
        raise GravityError("the gravity analysis did not converge: no equilibrium under dead load")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def open_linear_pattern(tags: TagAllocator) -> None:
    """Open a load pattern that grows with time; loads created afterwards belong to it."""
    series = tags.series()
    ops.timeSeries("Linear", series)
    ops.pattern("Plain", tags.pattern(), series)


def column_axial_forces_n(model: BridgeModel) -> list[float]:
    """Return the compression in N at the base of every column, from the element forces."""
    return [float(ops.eleResponse(column.element, "force")[2]) for column in model.columns]


def support_reactions_n(model: BridgeModel) -> list[float]:
    """Return the vertical reaction in N of each abutment (left, right)."""
    ops.reactions()
    return [
        sum(float(ops.nodeReaction(bearing.seat_node, 3)) for bearing in abutment.bearings)
        for abutment in model.abutments
    ]
