"""Ends of a bridge by kind, and joints inside it.

A kind of end (seat abutment, integral end on piles, fixed end, roller) is a class of data in
`skewbridge.bridge.catalogue.data` and a row of `KINDS`. Only seats have the abutment model of the
variant with its gap and friction; the other kinds cannot unseat. An `integral` end is a diaphragm
cast with the deck. The fill resists only pushing, along the normal of the skewed face and without a
gap; wing walls resist along the face, as behind a seat. Two springs stand for the piles, so far
apart that they have the rotational stiffness of all pile heads.

At a joint, two deck ends face each other, on the cap of a bent or at a hinge. The decks meet in
contact units at the same points along their faces. At a bent, both rest on pads on the cap; at a
hinge, one deck rests on a ledge of the other. Cables may hold the decks together. A deck without
joint may rest on pads on the cap of a bent.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import sqrt
from typing import Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.abutments import (
    Points,
    Wall,
    arm_transformation,
    bearing_point,
    bearing_stations,
    build_arm,
    build_arms,
    build_bearings,
    hold_wall_point,
    pad_stations,
    placed,
    support_deck_end,
)
from skewbridge.bridge.backfill import Passive
from skewbridge.bridge.catalogue.data import IntegralData, PadData
from skewbridge.bridge.frame import BearingLine, Blueprint, End, InnerJoint
from skewbridge.bridge.handles import (
    AbutmentHandle,
    BearingHandle,
    JointHandle,
    PadsHandle,
    Point,
    SeatHandle,
    TagAllocator,
)
from skewbridge.bridge.plan import DeckEnd, PlanVector, tributary_shares, turned
from skewbridge.bridge.springs import (
    NO_GAP_M,
    PLASTIC_OVER_INITIAL,
    elastic_material,
    elastic_part_n_per_m,
    grounded_node,
    grounded_springs,
    penalties,
    plane_node,
    plastic_material,
    spring_element,
)
from skewbridge.contact.element import uniaxial
from skewbridge.errors import InputError
from skewbridge.units import KN, MM


def support_joint(inner: InnerJoint, blueprint: Blueprint) -> Callable[[], JointHandle]:
    """Build stiff arms and pads of both deck ends; return a function that joins them at rest."""
    options, tags, pads = blueprint.options, blueprint.tags, inner.data.pads
    points_of_ends: list[Points] = []
    bearings: list[BearingHandle] = []
    tops_and_bottoms: list[tuple[Point, Point]] = []
    links: list[int] = []
    # no arm to a seat is vertical
    level = arm_transformation((0.0, 0.0, 1.0), options, tags)
    for end, node, support in zip(inner.ends, inner.nodes, inner.holders, strict=True):
        seats = [] if support is None else bearing_stations(pads, end, options)
        faces = end.wall_stations(options.backwall_points)
        points, arms = build_arms(end, node, seats, faces, options, tags)
        points_of_ends.append(points)
        links += arms
        if support is not None:
            seat_at = partial(_seat_node, support, level, tags, links)
            bearings += build_bearings(end, points, pads, options, tags, seat_at=seat_at)
            tops_and_bottoms += _pads(end, node, support, pads)
    handle = PadsHandle(bearings=tuple(bearings), pads=tuple(tops_and_bottoms), links=tuple(links))
    return partial(_build_inner_joint, inner, blueprint, points_of_ends, handle)


def _seat_node(
    support: int, level: int, tags: TagAllocator, links: list[int], place_m: Sequence[float]
) -> int:
    """Create a node below a pad that moves with a cap or a ledge; add its arm to ``links``."""
    # ASSUME a cap or a ledge is rigid between its middle and the pads
    seat, arm = build_arm(support, place_m, level, tags)
    links.append(arm)
    return seat


def support_on_bent(line: BearingLine, blueprint: Blueprint) -> PadsHandle:
    """Build the pads between a deck and the cap of a bent, with stiff arms to them."""
    options, tags, plan, pads = blueprint.options, blueprint.tags, line.plan, line.pads
    points, arms = build_arms(
        plan, line.node, bearing_stations(pads, plan, options), [], options, tags
    )
    # arms along the cap are square to its normal
    along = arm_transformation((*plan.normal, 0.0), options, tags)

    def seat_at(place_m: Sequence[float]) -> int:
        is_cap = np.allclose(place_m, ops.nodeCoord(line.cap), atol=1e-6)
        return line.cap if is_cap else _seat_node(line.cap, along, tags, arms, place_m)

    return PadsHandle(
        bearings=build_bearings(plan, points, pads, options, tags, seat_at=seat_at),
        pads=tuple(_pads(plan, line.node, line.cap, pads)),
        links=tuple(arms),
    )


def require_no_uplift(name: str, bearings: Iterable[BearingHandle], remedy: str = "") -> None:
    """Raise an `InputError` if a deck at rest is above its pads."""
    for pad in bearings:
        if ops.nodeDisp(pad.deck_node, 3) > ops.nodeDisp(pad.seat_node, 3):
            raise InputError(f"{name}: a deck lifts off its pads under dead load{remedy}")


def _build_inner_joint(
    inner: InnerJoint, blueprint: Blueprint, points: Sequence[Points], supports: PadsHandle
) -> JointHandle:
    """Build the contacts and cables between two decks at rest."""
    variant, options, contacts = blueprint.variant, blueprint.options, blueprint.contacts
    data, (left, right) = inner.data, inner.ends
    if contacts is None:
        raise TypeError("an inner joint needs a ContactSet")
    remedy = "; for a hinge, put the ledge on the other deck"
    require_no_uplift(inner.name, supports.bearings, remedy)
    gap_mm = variant.gap_mm if data.gap_mm is None else data.gap_mm
    gap_m = options.normal_gap_m(gap_mm, left.skew_deg)
    friction = variant.friction if data.friction is None else data.friction
    # the outer faces coincide, with opposite tangents
    stations = left.wall_stations(options.backwall_points)
    opposite = reversed(right.wall_stations(options.backwall_points))
    pairs = [
        (points[0]["outer", along_m], points[1]["outer", opposite_m])
        for along_m, opposite_m in zip(stations, opposite, strict=True)
    ]
    shares, tangent = tributary_shares(len(stations)), (*turned(left.normal), 0.0)
    # ASSUME decks are as stiff at their ends as over their length; the mass that meets is that of
    # the lighter end node, as for the masses of walls
    mass_kg = min(float(ops.nodeMass(node, 1)) for node in inner.nodes)
    units: list[int] = []
    for number, (pair, share) in enumerate(zip(pairs, shares, strict=True), start=1):
        kn, kt = penalties(share * inner.axial_n_per_m, share * mass_kg, options)
        units.append(
            contacts.add(
                *pair,
                (*left.normal, 0.0),
                gap_m,
                friction,
                kn=kn,
                kt=kt,
                tangent=tangent,
                name=f"{inner.name} {number}",
            )
        )
    return JointHandle(
        name=inner.name,
        gap_m=gap_m,
        seats=tuple(_seats(inner, points, gap_m)),
        units=tuple(units),
        bearings=supports.bearings,
        pads=supports.pads,
        restrainers=tuple(_restrain(inner, (pairs[0], pairs[-1]), blueprint.tags)),
        links=supports.links,
    )


def _restrain(inner: InnerJoint, pairs: Sequence[tuple[int, int]], tags: TagAllocator) -> list[int]:
    if (cables := inner.data.restrainers) is None:
        return []
    per_corner = cables.count / 2 * KN
    stiffness_and_yield = per_corner * cables.stiffness_kn_per_m, per_corner * cables.yield_kn
    slack_m, elements = max(cables.slack_mm * MM, NO_GAP_M), list[int]()
    for pair in pairs:
        spring = uniaxial(tags, "ElasticPPGap", *stiffness_and_yield, slack_m, 0.0, "damage")
        elements.append(spring_element(pair, inner.ends[0].normal, [spring], [], tags)[0].element)
    return elements


def _below(point_m: tuple[float, float, float], support: int) -> Point:
    x, y, z = (float(x_j - x_i) for x_j, x_i in zip(point_m, ops.nodeCoord(support), strict=True))
    return Point(support, (x, y, z))


def _seats(inner: InnerJoint, points: Sequence[Points], gap_m: float) -> list[SeatHandle]:
    # on a cap, the middle of the gap is the end of both seats
    length_m = inner.data.seat_width_m - gap_m / (1.0 if None in inner.holders else 2.0)
    return [
        SeatHandle(
            corner=end_points["outer", along_m],
            holder=_below(end.point("outer", along_m), holder),
            normal=end.normal,
            support_length_m=length_m,
        )
        for end, end_points, holder in zip(inner.ends, points, inner.holders, strict=True)
        if holder is not None
        for along_m in end.wall_stations(2)
    ]


def _pads(end: DeckEnd, node: int, support: int, pads: PadData) -> list[tuple[Point, Point]]:
    return [
        (bearing_point(end, node, along_m), _below(end.point("bearing", along_m), support))
        for along_m in pad_stations(pads, end)
    ]


#: Builds the supports of an end; it returns a function that adds the springs under dead load.
type EndBuilder = Callable[[End, Blueprint], Callable[[], AbutmentHandle]]


def _integral(end: End, blueprint: Blueprint) -> Callable[[], AbutmentHandle]:
    """Create the piles of an integral end and the stiff arms to them and to the fill."""
    plan, node, options, tags = end.plan, end.node, blueprint.options, blueprint.tags
    data = end.abutment
    if not isinstance(data, IntegralData):
        raise TypeError(f"end {plan.name}: type must be integral, got {data.type}")
    piles, stations = data.piles, pad_stations(data.piles, plan)
    arm = sqrt(sum(along_m**2 for along_m in stations) / len(stations))
    # ASSUME the resultant of the fill and the heads of the piles are at the level of the soffit
    faces = plan.wall_stations(options.backwall_points)
    points, arms = build_arms(plan, node, [-arm, arm], faces, options, tags)
    lateral = Passive(
        stiffness_n_per_m=piles.count / 2 * piles.lateral_kn_per_m * KN,
        ultimate_n=piles.count / 2 * piles.lateral_strength_kn * KN,
        failure_ratio=0.0,
    )
    elements: list[int] = []
    heads: list[int] = []
    holders: list[int] = []
    vertical = piles.count / 2 * piles.vertical_mn_per_m * 1e6
    for along_m in (-arm, arm):
        top = points["bearing", along_m]
        element, ground = grounded_springs(top, {3: vertical}, plan.normal, tags)
        head, *waves = _pile_springs((ground, top), plan.normal, lateral, piles.dashpot_s, tags)
        holders.append(ground)
        heads.append(head)
        elements += [element, head, *waves]
    # ASSUME the heads of the piles are cast into the diaphragm and turn with it
    rotational = piles.count * piles.rotational_mnm_per_rad * 1e6
    element, ground = grounded_springs(node, {4: rotational, 5: rotational}, plan.normal, tags)
    handle = AbutmentHandle(
        **placed(plan, node, points),
        is_seat=False,
        holders=(*holders, ground),
        links=tuple(arms),
        ground_elements=tuple(heads),
        other_springs=(*elements, element),
    )
    wall = Wall(blueprint=blueprint, data=data, end=plan, points=points, handle=handle)
    return partial(_build_integral, wall)


def _pile_springs(
    nodes: tuple[int, int],
    normal: PlanVector,
    lateral: Passive,
    dashpot_s: float,
    tags: TagAllocator,
) -> list[int]:
    """Create the lateral springs of pile heads; return their elements, the grounded one first.

    As behind a wall, a dashpot acts on the elastic part of the resistance, so that spring and
    dashpot together never exceed the strength.
    """
    # ASSUME a pile resists along both axes of the face independently
    if dashpot_s == 0.0:
        sides = [plastic_material(lateral, tags)], [plastic_material(lateral, tags)]
        return [spring_element(nodes, normal, *sides, tags)[0].element]
    middle_node = plane_node(ops.nodeCoord(nodes[0]), 0.0, tags)
    yielding = lateral.scaled(1.0, PLASTIC_OVER_INITIAL)
    sides = [plastic_material(yielding, tags)], [plastic_material(yielding, tags)]
    elastic, dashpot = elastic_part_n_per_m(lateral), dashpot_s * lateral.stiffness_n_per_m
    waves = [elastic_material(elastic, tags, dashpot)], [elastic_material(elastic, tags, dashpot)]
    return [
        spring_element((nodes[0], middle_node), normal, *sides, tags)[0].element,
        spring_element((middle_node, nodes[1]), normal, *waves, tags)[0].element,
    ]


def _build_integral(wall: Wall) -> AbutmentHandle:
    """Create fill and wing walls behind the diaphragm, whose deck nodes are the wall nodes."""
    # ASSUME the fill has no pressure at rest
    springs, links, nodes = [], list(wall.handle.other_springs), []
    for along_m, share, passive in wall.wall_parts():
        point_m = wall.end.point("outer", along_m)
        nodes.append(wall.points["outer", along_m])
        pair = grounded_node(point_m, wall.tags), nodes[-1]
        fill, _, wall_links = hold_wall_point(wall, pair, share, passive, has_stem=False)
        springs.append(fill)
        links += wall_links
    # the wing walls are in the elements of the fill, and `modes_of` must not hold them
    return replace(
        wall.handle,
        wall_nodes=tuple(nodes),
        wall_springs=tuple(springs),
        ground_elements=(*wall.handle.ground_elements, *(fill.element for fill in springs)),
        other_springs=tuple(links),
    )


def _fixed(end: End, blueprint: Blueprint) -> Callable[[], AbutmentHandle]:
    ops.fix(end.node, 1, 1, 1, 1, 1, 1)
    fields = placed(end.plan, end.node, {})
    return lambda: AbutmentHandle(**fields, is_seat=False, holders=(end.node,))


def _roller(end: End, blueprint: Blueprint) -> Callable[[], AbutmentHandle]:
    """Hold both ends of the bearing line vertically, also against uplift."""
    plan, stations = end.plan, end.plan.wall_stations(2)
    options, tags = blueprint.options, blueprint.tags
    points, arms = build_arms(plan, end.node, stations, stations, options, tags)
    supported = tuple(points["bearing", along_m] for along_m in stations)
    for node in supported:
        ops.fix(node, 0, 0, 1, 0, 0, 0)
    fields = placed(plan, end.node, points)
    return lambda: AbutmentHandle(**fields, is_seat=False, holders=supported, links=tuple(arms))


#: Builder of each type of end, by the ``type`` of its data.
KINDS: Final[Mapping[str, EndBuilder]] = {
    "seat": support_deck_end, "integral": _integral, "fixed": _fixed, "roller": _roller,
}  # fmt: skip
