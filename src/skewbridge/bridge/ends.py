"""Ends of a bridge by kind: seat abutment, integral end on piles, fixed end and roller.

A kind is a class of data in `skewbridge.bridge.catalogue.data` and a row of `KINDS`. Only seats
have the abutment model of the variant with its gap and friction; the other kinds cannot unseat.

An `integral` end is a diaphragm cast with the deck. The fill resists only pushing, along the normal
of the skewed face and without a gap; wing walls resist along the face, as behind a seat. Two
springs stand for the piles, so far apart that they have the rotational stiffness of all pile heads.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, Final

import openseespy.opensees as ops

from skewbridge.bridge.abutments import (
    Wall,
    build_arms,
    build_joint,
    hold_wall_point,
    pad_stations,
    placed,
    support_deck_end,
)
from skewbridge.bridge.backfill import Passive
from skewbridge.bridge.catalogue.data import IntegralData
from skewbridge.bridge.frame import Blueprint, End
from skewbridge.bridge.handles import AbutmentHandle, TagAllocator
from skewbridge.bridge.plan import Line, PlanVector
from skewbridge.bridge.springs import (
    PLASTIC_OVER_INITIAL,
    elastic_material,
    elastic_part_n_per_m,
    grounded_node,
    plane_node,
    plastic_material,
    spring_element,
)
from skewbridge.units import KN


@dataclass(frozen=True, slots=True)
class EndKind:
    """Functions that build an end: its supports before the dead load, its springs after it."""

    support: Callable[[End, Blueprint], Any]
    build: Callable[[Any], AbutmentHandle]


def _support_integral(end: End, blueprint: Blueprint) -> Wall:
    """Create the piles of an integral end and the stiff arms to them and to the fill."""
    plan, node, options, tags = end.plan, end.node, blueprint.options, blueprint.tags
    data = end.abutment
    if not isinstance(data, IntegralData):
        raise TypeError(f"{data.type} is not integral")
    piles, stations = data.piles, pad_stations(data.piles, plan)
    arm = sqrt(sum(along_m**2 for along_m in stations) / len(stations))
    # ASSUME the resultant of the fill and the heads of the piles are at the level of the soffit
    lines: dict[Line, list[float]] = {
        "bearing": [-arm, arm],
        "outer": plan.wall_stations(options.backwall_points),
    }
    points, arms = build_arms(plan, node, lines, options, tags)
    lateral = Passive(
        stiffness_n_per_m=piles.count / 2 * piles.lateral_kn_per_m * KN,
        ultimate_n=piles.count / 2 * piles.lateral_strength_kn * KN,
        failure_ratio=0.0,
    )
    elements: list[int] = []
    holders: list[int] = []

    def hold(deck_node: int, stiffness: Mapping[int, float]) -> None:
        """Hold a node by elastic springs in degrees of freedom of the end's axes."""
        ground, element = grounded_node(ops.nodeCoord(deck_node), tags), tags.element()
        materials = [elastic_material(value, tags) for value in stiffness.values()]
        springs = ("-mat", *materials, "-dir", *stiffness)
        axes = ("-orient", *plan.normal, 0.0, *plan.tangent, 0.0)
        ops.element("zeroLength", element, ground, deck_node, *springs, *axes)
        elements.append(element)
        holders.append(ground)

    for along_m in (-arm, arm):
        top = points["bearing", along_m]
        hold(top, {3: piles.count / 2 * piles.vertical_mn_per_m * 1e6})
        elements += _pile_springs((holders[-1], top), plan.normal, lateral, piles.dashpot_s, tags)
    # ASSUME the heads of the piles are cast into the diaphragm and turn with it
    rotational = piles.count * piles.rotational_mnm_per_rad * 1e6
    hold(node, {4: rotational, 5: rotational})
    handle = AbutmentHandle(
        **placed(plan, node, points),
        is_seat=False,
        holders=tuple(holders),
        links=tuple(arms),
        other_springs=tuple(elements),
    )
    fields: dict[str, Any] = {"blueprint": blueprint, "data": data, "handle": handle}
    return Wall(end=plan, points=points, **fields)


def _pile_springs(
    nodes: tuple[int, int],
    normal: PlanVector,
    lateral: Passive,
    dashpot_s: float,
    tags: TagAllocator,
) -> list[int]:
    """Create the lateral springs of pile heads; return their elements.

    As behind a wall, a dashpot acts on the elastic part of the resistance, so that spring and
    dashpot together never exceed the strength.
    """
    # ASSUME a pile resists along both axes of the face independently
    if dashpot_s == 0.0:
        sides = ([plastic_material(lateral, tags)], [plastic_material(lateral, tags)])
        return [spring_element(nodes, normal, *sides, tags)[0].element]
    between = plane_node(ops.nodeCoord(nodes[0]), 0.0, tags)
    yielding = lateral.scaled(1.0, PLASTIC_OVER_INITIAL)
    sides = ([plastic_material(yielding, tags)], [plastic_material(yielding, tags)])
    elastic = elastic_part_n_per_m(lateral)
    dashpot = dashpot_s * lateral.stiffness_n_per_m
    waves = ([elastic_material(elastic, tags, dashpot)], [elastic_material(elastic, tags, dashpot)])
    return [
        spring_element((nodes[0], between), normal, *sides, tags)[0].element,
        spring_element((between, nodes[1]), normal, *waves, tags)[0].element,
    ]


def _build_integral(wall: Wall) -> AbutmentHandle:
    """Create fill and wing walls; the points of the diaphragm are the wall."""
    # ASSUME the fill has no pressure at rest
    springs, links, nodes = [], list(wall.handle.other_springs), []
    for along_m, share, passive in wall.wall_parts():
        point_m = wall.end.point("outer", along_m)
        nodes.append(wall.points["outer", along_m])
        pair = grounded_node(point_m, wall.tags), nodes[-1]
        fill, _, between = hold_wall_point(wall, pair, share, passive, has_stem=False)
        springs.append(fill)
        links += between
    # the wing walls are in the elements of the fill, and `modes_of` must not hold them
    return replace(
        wall.handle,
        wall_nodes=tuple(nodes),
        wall_springs=tuple(springs),
        other_springs=tuple(links),
    )


def _support_fixed(end: End, blueprint: Blueprint) -> AbutmentHandle:
    ops.fix(end.node, 1, 1, 1, 1, 1, 1)
    return AbutmentHandle(**placed(end.plan, end.node, {}), is_seat=False, holders=(end.node,))


def _support_roller(end: End, blueprint: Blueprint) -> AbutmentHandle:
    """Hold both ends of the bearing line vertically, also against uplift."""
    plan, stations = end.plan, end.plan.wall_stations(2)
    lines: dict[Line, list[float]] = {"bearing": stations, "outer": stations}
    points, arms = build_arms(plan, end.node, lines, blueprint.options, blueprint.tags)
    supported = tuple(points["bearing", along_m] for along_m in stations)
    for node in supported:
        ops.fix(node, 0, 0, 1, 0, 0, 0)
    fields = placed(plan, end.node, points)
    return AbutmentHandle(**fields, is_seat=False, holders=supported, links=tuple(arms))


def _finished(handle: AbutmentHandle) -> AbutmentHandle:
    return handle


#: How the ends of each type of data are built.
KINDS: Final[Mapping[str, EndKind]] = {
    "seat": EndKind(support_deck_end, build_joint),
    "integral": EndKind(_support_integral, _build_integral),
    "fixed": EndKind(_support_fixed, _finished),
    "roller": EndKind(_support_roller, _finished),
}
