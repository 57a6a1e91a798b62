"""Joints inside a bridge: two deck ends that face each other, on the cap of a bent or at a hinge.

The decks meet in contact units at the same points along their faces. At a bent, both rest on pads
on the cap; at a hinge, one rests on a ledge of the other. Cables may hold them together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import openseespy.opensees as ops

from skewbridge.bridge.abutments import (
    Points,
    arm_transformation,
    bearing_point,
    bearing_stations,
    build_arm,
    build_arms,
    build_bearings,
    normal_gap_m,
    pad_stations,
)
from skewbridge.bridge.frame import Blueprint, InnerJoint
from skewbridge.bridge.handles import BearingHandle, JointHandle, Point, SeatHandle, TagAllocator
from skewbridge.bridge.plan import Line, tributary_shares, turned
from skewbridge.bridge.springs import NO_GAP_M, penalties, spring_element
from skewbridge.contact.element import uniaxial
from skewbridge.errors import InputError
from skewbridge.units import KN, MM


@dataclass(frozen=True, kw_only=True)
class Supported:
    """Inner joint on its pads, before the contacts and cables that are built at rest."""

    inner: InnerJoint
    blueprint: Blueprint
    points: tuple[Points, Points]
    bearings: tuple[BearingHandle, ...]
    links: tuple[int, ...]


def support_joint(inner: InnerJoint, blueprint: Blueprint) -> Supported:
    """Build stiff arms and pads of both deck ends of a joint."""
    options, tags, pads = blueprint.options, blueprint.tags, inner.data.pads
    points_of_ends: list[Points] = []
    bearings: list[BearingHandle] = []
    links: list[int] = []
    # no arm to a seat is vertical
    level = arm_transformation((0.0, 0.0, 1.0), options, tags)
    for end, node, support in zip(inner.ends, inner.nodes, inner.holders, strict=True):
        seats = [] if support is None else bearing_stations(pads, end, options)
        lines: dict[Line, list[float]] = {
            "bearing": seats,
            "outer": end.wall_stations(options.backwall_points),
        }
        points, arms = build_arms(end, node, lines, options, tags)
        points_of_ends.append(points)
        links += arms
        if support is None:
            continue

        seat_at = partial(_seat_node, support, level, tags, links)
        bearings += build_bearings(end, points, pads, options, tags, seat_at=seat_at)
    first, second = points_of_ends
    return Supported(
        inner=inner,
        blueprint=blueprint,
        points=(first, second),
        bearings=tuple(bearings),
        links=tuple(links),
    )


def _seat_node(
    support: int, level: int, tags: TagAllocator, links: list[int], place_m: Sequence[float]
) -> int:
    """Create a node below a pad that moves with a cap or a ledge; add its arm to ``links``."""
    # ASSUME a cap or a ledge is rigid between its middle and the pads
    seat, arm = build_arm(support, place_m, level, tags)
    links.append(arm)
    return seat


def build_inner_joint(joint: Supported) -> JointHandle:
    """Build the contacts and cables between two decks at rest."""
    inner, variant, options = joint.inner, joint.blueprint.variant, joint.blueprint.options
    data, (left, right), contacts = inner.data, inner.ends, joint.blueprint.contacts
    if contacts is None:
        raise TypeError("an inner joint needs a ContactSet")
    if data.gap_mm is None and "gap_mm" not in variant.traits.axes:
        raise InputError(f"{inner.name} needs gap_mm: abutment model {variant.abutment} has no gap")
    for pad in joint.bearings:
        if ops.nodeDisp(pad.deck_node, 3) > ops.nodeDisp(pad.seat_node, 3):
            raise InputError(
                f"{inner.name}: a deck lifts off its pads under dead load; for a hinge, put the "
                "ledge on the other deck"
            )
    gap_m = normal_gap_m(variant.gap_mm if data.gap_mm is None else data.gap_mm, left, options)
    friction = variant.friction if data.friction is None else data.friction
    # the outer faces coincide, with opposite tangents
    stations = left.wall_stations(options.backwall_points)
    opposite = reversed(right.wall_stations(options.backwall_points))
    pairs = [
        (joint.points[0]["outer", along_m], joint.points[1]["outer", opposite_m])
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
        seats=tuple(_seats(joint, gap_m)),
        units=tuple(units),
        bearings=joint.bearings,
        pads=tuple(_pads(inner)),
        restrainers=tuple(_restrain(joint, (pairs[0], pairs[-1]))),
        links=joint.links,
    )


def _restrain(joint: Supported, pairs: Sequence[tuple[int, int]]) -> list[int]:
    cables, tags = joint.inner.data.restrainers, joint.blueprint.tags
    if cables is None:
        return []
    half = cables.count / 2 * KN
    numbers = half * cables.stiffness_kn_per_m, half * cables.yield_kn
    slack_m, elements = max(cables.slack_mm * MM, NO_GAP_M), list[int]()
    for pair in pairs:
        spring = uniaxial(tags, "ElasticPPGap", *numbers, slack_m, 0.0, "damage")
        normal = joint.inner.ends[0].normal
        elements.append(spring_element(pair, normal, [spring], [], tags)[0].element)
    return elements


def _below(point_m: tuple[float, float, float], support: int) -> Point:
    x, y, z = (float(x_j - x_i) for x_j, x_i in zip(point_m, ops.nodeCoord(support), strict=True))
    return Point(support, (x, y, z))


def _seats(joint: Supported, gap_m: float) -> list[SeatHandle]:
    inner = joint.inner
    # on a cap, the middle of the gap is the end of both seats
    length_m = inner.data.seat_width_m - gap_m / (1.0 if None in inner.holders else 2.0)
    return [
        SeatHandle(
            corner=points["outer", along_m],
            holder=_below(end.point("outer", along_m), holder),
            normal=end.normal,
            support_length_m=length_m,
        )
        for end, points, holder in zip(inner.ends, joint.points, inner.holders, strict=True)
        if holder is not None
        for along_m in end.wall_stations(2)
    ]


def _pads(inner: InnerJoint) -> list[tuple[Point, Point]]:
    return [
        (bearing_point(end, node, along_m), _below(end.point("bearing", along_m), support))
        for end, node, support in zip(inner.ends, inner.nodes, inner.holders, strict=True)
        if support is not None
        for along_m in pad_stations(inner.data.pads, end)
    ]
