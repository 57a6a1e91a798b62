"""Seat abutments: deck end on its supports, and the joint of each abutment model.

Stiff arms run from the end node of the spine to the tops of the pads on the bearing line, and to
the points of the outer face of the end diaphragm that touch walls and keys. All these points are at
the level of the soffit.

`roller` has only vertical supports at both ends of the skewed bearing line. `simplified` adds a
rigid bar of deck width with a gap and a bilinear spring at each end. `spring` has pads, gap springs
of the backfill, shear keys, wing walls and embankment. Each exterior key is between the deck
(behind the transverse gap) and the body of the abutment. The wing walls hold this body along the
wall, and it may carry the mass of the embankment.

In `contact` and `contact_friction` the deck meets backwall and keys through contact units. The
parts in series at each point along the backwall are ground, backfill and wing-wall springs, wall
node, contact unit and deck. At each key they are ground, key spring, key node, contact unit and
deck. Only the contact units have gaps.

References:
    Aviram, Mackie and Stojadinovic (2008), PEER 2008/03; Zhang and Makris (2002); Rahman and
    Mackie, section 4 of the paper (figure 9).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from typing import Any, Final

import openseespy.opensees as ops

from skewbridge.bridge.backfill import (
    SOIL_KG_PER_M3,
    Passive,
    radiation_n_s_per_m,
    reduced_for_skew,
    sdc_backfill,
    skew_reduction,
    variation_factors,
    wall_backfill,
    wing_share,
    wing_wall,
)
from skewbridge.bridge.catalogue.data import AbutmentData, KeyData, PadData, PileData, WallData
from skewbridge.bridge.frame import Blueprint, End
from skewbridge.bridge.handles import (
    AbutmentHandle,
    BearingHandle,
    CornerHandle,
    Point,
    SpringHandle,
    TagAllocator,
)
from skewbridge.bridge.plan import DeckEnd, Line, PlanVector, tributary_shares, turned
from skewbridge.bridge.springs import (
    NORMAL_OVER_NEIGHBOUR,
    damping_n_s_per_m,
    elastic_material,
    elastic_part_n_per_m,
    gap_material,
    grounded_node,
    key_face_material,
    key_material,
    key_stiffness_n_per_m,
    passive_material,
    penalties,
    plane_node,
    plastic_material,
    plastic_part,
    spring_element,
)
from skewbridge.contact.element import uniaxial
from skewbridge.units import KN, TONNE
from skewbridge.variant.options import ModelOptions

# Far stiffer than the deck's end element (1e10 N/m), soft enough for double precision. A modulus
# 100 times smaller needs 8 to 15 % more iterations.
ARM_MODULUS_PA = 2.5e13
ARM_AREA_M2 = 10.0
ARM_INERTIA_M4 = 10.0

#: Nodes of the joint at one deck end, keyed by line and position along the wall.
type Points = dict[tuple[Line, float], int]


def build_arms(
    end: DeckEnd,
    deck_node: int,
    bearing_m: Sequence[float],
    outer_m: Sequence[float],
    options: ModelOptions,
    tags: TagAllocator,
) -> tuple[Points, list[int]]:
    """Create nodes on the bearing line and the outer face, and stiff arms to them; return both.

    ``bearing_m`` and ``outer_m`` are positions along the wall from its middle.
    """
    # no arm is parallel to the normal of the wall
    transformation = arm_transformation((*end.normal, 0.0), options, tags)
    points: Points = {}
    arms: list[int] = []
    stations: dict[Line, Sequence[float]] = {"bearing": bearing_m, "outer": outer_m}
    for line, positions in stations.items():
        for along_m in positions:
            point_m = end.point(line, along_m)
            points[line, along_m], element = build_arm(deck_node, point_m, transformation, tags)
            arms.append(element)
    return points, arms


def arm_transformation(
    plane: tuple[float, float, float], options: ModelOptions, tags: TagAllocator
) -> int:
    """Create the transformation of arms that are not parallel to the vector ``plane``."""
    transformation = tags.transformation()
    geometry = "Corotational" if options.arrays == "corotational" else "Linear"
    ops.geomTransf(geometry, transformation, *plane)
    return transformation


def build_arm(
    holder: int, position_m: Sequence[float], transformation: int, tags: TagAllocator
) -> tuple[int, int]:
    """Create a node and a stiff arm to it from the node ``holder``; return tags of node and arm."""
    node, element = tags.node(), tags.element()
    ops.node(node, *position_m)
    ops.fix(node, 0, 0, 0, 1, 1, 1)
    # the nodes do not rotate: each arm has a ball joint there, and no torsion
    section = (ARM_AREA_M2, ARM_MODULUS_PA, 1.0, 1.0, ARM_INERTIA_M4, ARM_INERTIA_M4)
    ball_joint = ("-releasez", 2, "-releasey", 2)
    ops.element("elasticBeamColumn", element, holder, node, *section, transformation, *ball_joint)
    return node, element


# ASSUME bending and twisting of a pad are too soft to matter
PAD_ROTATION_NM_PER_RAD = 1.0e5
# source: PyPBEE, no nonlinear hardening of the pads
PAD_HARDENING = (0.0, 3.0)  # ratio of the nonlinear hardening, and its exponent


def pad_stations(pads: PadData | PileData, end: DeckEnd) -> list[float]:
    """Return positions (m) of the pads along the wall from its middle, equally spaced."""
    # their spacing is given across the deck
    skew_stretch = end.wall_length_m / end.width_m
    middle_index = (pads.count - 1) / 2
    return [(i - middle_index) * pads.spacing_m * skew_stretch for i in range(pads.count)]


def bearing_stations(
    pads: PadData | PileData, end: DeckEnd, options: ModelOptions, *, has_pads: bool = True
) -> list[float]:
    """Return positions (m) along the wall of all pads, two equivalent pads, or two supports."""
    if not has_pads:
        return [-end.wall_length_m / 2, end.wall_length_m / 2]
    stations = pad_stations(pads, end)
    if options.pads == "each":
        return stations
    radius_m = sqrt(sum(along_m**2 for along_m in stations) / len(stations))
    return [-radius_m, radius_m]


def build_bearings(
    end: DeckEnd,
    points: Points,
    pads: PadData,
    options: ModelOptions,
    tags: TagAllocator,
    *,
    has_pads: bool = True,
    seat_at: Callable[[Sequence[float]], int] | None = None,
) -> tuple[BearingHandle, ...]:
    """Create pads, or vertical supports, from seat nodes up to the deck nodes of the bearing line.

    Seat nodes are fixed, unless ``seat_at`` creates them. Vertical springs are elastic in
    compression and open in tension.
    """
    is_one_per_pad = has_pads and options.pads == "each"
    pad_count, height_m = (1, pads.height_m) if is_one_per_pad else (pads.count / 2, 0.0)
    axial = uniaxial(tags, "ENT", pad_count * (pads.vertical_stiffness_mn_per_m * 1e6))
    if not has_pads:
        kind, arguments = "zeroLength", ("-mat", axial, "-dir", 3)
    elif is_one_per_pad:
        bend = elastic_material(PAD_ROTATION_NM_PER_RAD, tags)
        shear = pads.shear_stiffness_kn_per_m * KN, pads.yield_force_kn * KN
        springs = ("-P", axial, "-T", bend, "-My", bend, "-Mz", bend, "-orient", *end.normal, 0.0)
        kind = "elastomericBearingPlasticity"
        arguments = (*shear, pads.hardening_ratio, *PAD_HARDENING, *springs)
    else:
        # ASSUME the pads do not resist rotation: their stiffness is too small to matter
        # axial force along z, shear along x and y of the model
        axes = ("-orient", 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
        kind, arguments = "zeroLengthSection", (_pad_section(pads, pad_count, axial, tags), *axes)
    handles: list[BearingHandle] = []
    for deck_node in (node for (line, _), node in points.items() if line == "bearing"):
        x, y, z = ops.nodeCoord(deck_node)
        seat_m = (x, y, z - height_m)
        seat = grounded_node(seat_m, tags) if seat_at is None else seat_at(seat_m)
        element = tags.element()
        ops.element(kind, element, seat, deck_node, *arguments)
        handles.append(BearingHandle(element=element, seat_node=seat, deck_node=deck_node))
    return tuple(handles)


def _pad_section(pads: PadData, pad_count: float, vertical: int, tags: TagAllocator) -> int:
    """Create the section of several pads: a vertical material, and shear with a yield circle.

    Its shear equals that of the bearing element, as a plastic and an elastic spring in parallel.
    """
    plastic_ratio = 1.0 - pads.hardening_ratio
    stiffness = pad_count * pads.shear_stiffness_kn_per_m * KN
    hardening = stiffness * pads.hardening_ratio / plastic_ratio
    shear_section, section = tags.section(), tags.section()
    strength_n, directions = pad_count * pads.yield_force_kn * KN / plastic_ratio, ("Vy", "Vz")
    ops.section("Bidirectional", shear_section, stiffness, strength_n, 0.0, hardening, *directions)
    ops.section("Aggregator", section, vertical, "P", "-section", shear_section)
    return section


CONCRETE_KG_PER_M3 = 2400.0  # source: usual density of reinforced concrete


@dataclass(frozen=True, kw_only=True)
class Wall:
    """Deck end on its supports before walls and keys exist, with the data to build them."""

    blueprint: Blueprint
    data: WallData
    end: DeckEnd
    points: Points
    handle: AbutmentHandle

    @property
    def options(self) -> ModelOptions:
        """Modelling options of the variant."""
        return self.blueprint.options

    @property
    def tags(self) -> TagAllocator:
        """Tag allocator of the domain."""
        return self.blueprint.tags

    @property
    def wing(self) -> Passive:
        """Transverse resistance of the wing walls."""
        return self.soil(wing_wall(self.data))

    def soil(self, passive: Passive) -> Passive:
        """Return a soil resistance multiplied by the backfill factors of the options."""
        options = self.options
        return passive.scaled(options.backfill_strength_factor, options.backfill_stiffness_factor)

    def wall_parts(self) -> list[tuple[float, float, Passive]]:
        """Return for each wall point its position (m), share of the wall and backfill curve."""
        options, end = self.options, self.end
        exponent = options.backfill_height_exponent
        curve_options = options.backfill, self.end.skew_rad, exponent, options.backfill_skew
        backfill = self.soil(wall_backfill(self.data, *curve_options))
        stations = end.wall_stations(options.backwall_points)
        shares = tributary_shares(len(stations))
        factors = variation_factors(end, stations, options.backfill_variation)
        return [
            (along_m, share, backfill.scaled(share * factor))
            for along_m, share, factor in zip(stations, shares, factors, strict=True)
        ]

    def dashpot_n_s_per_m(self, stiffness_n_per_m: float, mass_kg: float, share: float) -> float:
        """Return the dashpot coefficient (N s/m) between a share of the wall and the backfill."""
        vs_mps = self.options.backfill_vs_mps
        if vs_mps is None:
            return damping_n_s_per_m(stiffness_n_per_m, mass_kg)
        return share * radiation_n_s_per_m(self.data, vs_mps)

    def moving_mass_kg(self, mass_kg: float) -> float:
        """Return the mass of a wall or key node: the given mass, or zero without ``wall_mass``."""
        return mass_kg if self.options.wall_mass else 0.0

    @property
    def wall_mass_kg(self) -> float:
        """Mass of the backwall."""
        data = self.data
        volume_m3 = self.end.wall_length_m * data.wall_height_m * data.wall_thickness_m
        return volume_m3 * CONCRETE_KG_PER_M3


@dataclass(frozen=True, kw_only=True)
class Joint(Wall):
    """Deck end on the pads of a seat, before walls and keys are added."""

    data: AbutmentData

    @property
    def key(self) -> KeyData:
        """Backbone of the shear keys, selected by the option ``keys``."""
        is_monolithic = self.options.keys == "monolithic"
        return self.data.monolithic_key if is_monolithic else self.data.sacrificial_key

    def key_spring(self, nodes: tuple[int, int], inward: PlanVector) -> SpringHandle:
        """Create the springs of a key normal to and along its face; return the normal spring."""
        stiffness, mass_kg = key_stiffness_n_per_m(self.key), self.key_mass_kg
        dashpot = damping_n_s_per_m(stiffness, mass_kg)
        dashpot_material = elastic_material(0.0, self.tags, dashpot)
        across = [key_material(self.key, self.tags), dashpot_material]
        # ASSUME along its face a key is elastic up to the same strength, independent of the force
        # across it: a broken key gets friction from its residual force only, below the strength
        if self.options.key_along_face == "backbone":
            along = [key_face_material(self.key, self.tags), dashpot_material]
        else:
            along = [elastic_material(stiffness, self.tags, dashpot)]
        return spring_element(nodes, inward, across, along, self.tags)[0]

    @property
    def key_mass_kg(self) -> float:
        """Mass of one exterior key."""
        return self.data.key_mass_t * TONNE

    def add_contact(
        self,
        nodes: tuple[int, int],
        inward: PlanVector,
        gap_m: float,
        penalties_n_per_m: tuple[float, float],
        friction: float,
        name: str,
        cohesion_n: float = 0.0,
    ) -> int:
        """Create the contact unit between a wall or key node and a deck node; return its index."""
        contacts = self.blueprint.contacts
        if contacts is None:
            raise TypeError("the contact abutment needs a ContactSet")
        return contacts.add(
            *nodes,
            (*inward, 0.0),
            gap_m,
            friction,
            cohesion_n,
            kn=penalties_n_per_m[0],
            kt=penalties_n_per_m[1],
            tangent=(*turned(inward), 0.0),
            name=f"{self.end.name} {name}",
        )


def support_deck_end(end: End, blueprint: Blueprint) -> Callable[[], AbutmentHandle]:
    """Build arms and bearings at an end node of a deck; return a function that adds the rest.

    It builds walls, keys and their gaps between the deck end at rest and its abutment.
    """
    variant, options, tags = blueprint.variant, blueprint.options, blueprint.tags
    traits, data, deck_node = variant.traits, end.abutment, end.node
    if not isinstance(data, AbutmentData):
        raise TypeError(f"end {end.plan.name}: type must be seat, got {data.type}")
    plan = end.plan
    bearing_m = bearing_stations(data.pads, plan, options, has_pads=traits.has_pads)
    outer_face = plan.wall_stations(options.backwall_points if traits.has_pads else 2)
    points, arms = build_arms(plan, deck_node, bearing_m, outer_face, options, tags)
    bearings = build_bearings(plan, points, data.pads, options, tags, has_pads=traits.has_pads)
    pads = pad_stations(data.pads, plan) if traits.has_pads else bearing_m
    end_gap_mm = data.gap_mm if "gap_mm" in traits.axes else None
    gap_mm = variant.gap_mm if end_gap_mm is None else end_gap_mm
    handle = AbutmentHandle(
        **placed(plan, deck_node, points),
        gap_m=options.normal_gap_m(gap_mm, plan.skew_deg),
        seat_width_m=data.seat_width_m,
        bearings=bearings,
        pads=tuple(bearing_point(plan, deck_node, along_m) for along_m in pads),
        holders=tuple(bearing.seat_node for bearing in bearings),
        links=tuple(arms),
    )
    joint = Joint(blueprint=blueprint, data=data, end=plan, points=points, handle=handle)
    return partial(BUILDERS[variant.abutment], joint)


def bearing_point(end: DeckEnd, deck_node: int, along_m: float) -> Point:
    """Return a point of the bearing line at the soffit, rigidly connected to the deck."""
    z_m = float(ops.nodeCoord(deck_node, 3))
    x, y = end.tangent
    return Point(deck_node, (along_m * x, along_m * y, end.soffit_m - z_m))


def placed(end: DeckEnd, deck_node: int, points: Points) -> dict[str, Any]:
    """Return position fields of an `AbutmentHandle`; a corner without point is at the deck node."""
    corners = tuple(
        CornerHandle(
            node=points.get(("outer", along_m), deck_node),
            side=end.name,
            kind="acute" if along_m * end.acute_sign > 0.0 else "obtuse",
            plan_m=end.point("outer", along_m)[:2],
        )
        for along_m in end.wall_stations(2)
    )
    return {
        "side": end.name,
        "normal": end.normal,
        "tangent": end.tangent,
        "centre": bearing_point(end, deck_node, 0.0),
        "corners": corners,
    }


def _build_simplified(joint: Joint) -> AbutmentHandle:
    """Create the springs at both deck corners, each with half of the resistance."""
    end, tags = joint.end, joint.tags
    zero_skew, skew_rule = joint.soil(sdc_backfill(joint.data)), joint.options.backfill_skew
    soil_curve = reduced_for_skew(zero_skew, joint.end.skew_rad, skew_rule).scaled(0.5)
    # ASSUME the transverse springs have no gap, as in the published model
    wing_curve = joint.wing.scaled(0.5)
    corners_m = end.wall_stations(2)
    factors = variation_factors(end, corners_m, joint.options.backfill_variation)
    springs: list[tuple[SpringHandle, SpringHandle]] = []
    for along_m, factor in zip(corners_m, factors, strict=True):
        nodes = grounded_node(end.point("outer", along_m), tags), joint.points["outer", along_m]
        soil = passive_material(soil_curve.scaled(factor), joint.handle.gap_m, tags)
        wing = plastic_material(wing_curve, tags)
        springs.append(spring_element(nodes, end.inward, [soil], [wing], tags))
    walls, wings = zip(*springs, strict=True)
    return replace(joint.handle, wall_springs=walls, key_springs=wings)


def _build_spring(joint: Joint) -> AbutmentHandle:
    """Create the gap springs of the backfill, and connect the keys to the abutment body."""
    end, tags = joint.end, joint.tags
    springs: list[SpringHandle] = []
    for along_m, _, passive in joint.wall_parts():
        nodes = grounded_node(end.point("outer", along_m), tags), joint.points["outer", along_m]
        soil = passive_material(passive, joint.handle.gap_m, tags)
        springs.append(spring_element(nodes, end.inward, [soil], [], tags)[0])
    body, wing = _build_body(joint)
    handle = replace(joint.handle, wall_springs=tuple(springs), wing_springs=(wing,))
    return _build_keys(joint, handle, body=body)


def embankment_mass_kg(data: AbutmentData) -> float:
    """Return the mass in kg over the critical length, 0.7 sqrt(slope ratio x width x height).

    References:
        Zhang and Makris (2002), Earthquake Eng. Struct. Dyn. 31, section on critical length.
    """
    width_m, height_m = data.wall_width_m, data.embankment_height_m
    length_m = 0.7 * sqrt(data.embankment_slope_ratio * width_m * height_m)
    # ASSUME a trapezoid with side slopes of 1 / slope ratio, moving as one body
    area_m2 = width_m * height_m + height_m**2 / data.embankment_slope_ratio
    return length_m * area_m2 * SOIL_KG_PER_M3


def _build_body(joint: Joint) -> tuple[int, SpringHandle]:
    """Create the node of the abutment body and its springs; return it and its wing-wall spring."""
    end, data, tags = joint.end, joint.data, joint.tags
    embankment_kg = embankment_mass_kg(data) if joint.options.embankment_mass else 0.0
    mass_kg = joint.wall_mass_kg + embankment_kg
    # ASSUME across the wall the body has the initial stiffness of the whole wall at zero skew
    across_n_per_m = sum(passive.stiffness_n_per_m for _, _, passive in joint.wall_parts())
    if joint.options.backfill_skew == "strength_and_stiffness":
        across_n_per_m /= skew_reduction(joint.end.skew_rad)
    moving_kg = joint.moving_mass_kg(joint.wall_mass_kg) + embankment_kg
    body = plane_node(end.point("outer", 0.0), moving_kg, tags)
    ground = grounded_node(end.point("outer", 0.0), tags)
    wing = joint.wing
    dashpot = joint.dashpot_n_s_per_m(wing.stiffness_n_per_m, mass_kg, wing_share(data))
    along_wall = [plastic_material(wing, tags), elastic_material(0.0, tags, dashpot)]
    dashpot = joint.dashpot_n_s_per_m(across_n_per_m, mass_kg, 1.0)
    across_wall = [elastic_material(across_n_per_m, tags, dashpot)]
    wing_spring, _ = spring_element((ground, body), end.tangent, along_wall, across_wall, tags)
    return body, wing_spring


def _build_contact(joint: Joint) -> AbutmentHandle:
    end, gap_m, options, tags = joint.end, joint.handle.gap_m, joint.options, joint.tags
    friction = joint.blueprint.variant.friction * (options.friction_at != "keys")
    units: list[int] = []
    wall_nodes: list[int] = []
    wall_points: list[tuple[SpringHandle, SpringHandle, tuple[int, ...]]] = []
    for point_number, (along_m, share, passive) in enumerate(joint.wall_parts(), start=1):
        mass_kg = joint.moving_mass_kg(joint.wall_mass_kg * share)
        # The penalty of a point is proportional to its soil stiffness: the soil spreads the force.
        penalty = penalties(passive.stiffness_n_per_m, mass_kg, options)
        wall = plane_node(end.point("outer", along_m), mass_kg, tags)
        ground = grounded_node(end.point("outer", along_m), tags)
        wall_points.append(hold_wall_point(joint, (ground, wall), share, passive))
        nodes, name = (wall, joint.points["outer", along_m]), f"backwall {point_number}"
        cohesion_n = options.cohesion_n * share
        units.append(
            joint.add_contact(nodes, end.inward, gap_m, penalty, friction, name, cohesion_n)
        )
        wall_nodes.append(wall)
    wall_springs, wing_springs, links = zip(*wall_points, strict=True)
    handle = replace(
        joint.handle,
        wall_units=tuple(units),
        wall_nodes=tuple(wall_nodes),
        wall_springs=wall_springs,
        wing_springs=wing_springs,
        other_springs=tuple(element for elements in links for element in elements),
    )
    return _build_keys(joint, handle, body=None)


def hold_wall_point(
    joint: Wall, nodes: tuple[int, int], share: float, passive: Passive, *, has_stem: bool = True
) -> tuple[SpringHandle, SpringHandle, tuple[int, ...]]:
    """Create the backfill, stem and wing-wall springs between ground and a wall node.

    Returns the springs of backfill and wing walls, and tags of elements between wall and fill.
    """
    end, tags, mass_kg = joint.end, joint.tags, joint.wall_mass_kg * share
    # in proportion to the strength of the soil
    reduction = skew_reduction(joint.end.skew_rad, joint.options.backfill_skew)
    restoring = joint.options.wall_restoring_n_per_m * reduction * share
    stiffness, wing = passive.stiffness_n_per_m, joint.wing.scaled(share)
    # ASSUME towards the deck the stem of the wall has the initial stiffness of the soil: shaking
    # alone does not push the wall into the gap
    dashpot = joint.dashpot_n_s_per_m(stiffness, mass_kg, share)
    wing_ratio = share * wing_share(joint.data)
    wing_dashpot = joint.dashpot_n_s_per_m(wing.stiffness_n_per_m, mass_kg, wing_ratio)
    # ASSUME waves of the wing walls leave parallel to their plastic springs
    along = [plastic_material(wing, tags), elastic_material(restoring, tags, wing_dashpot)]
    is_parallel = joint.options.backfill_dashpot == "parallel"
    parallel = dashpot if is_parallel else 0.0
    stem = stiffness if has_stem else 0.0
    stem_spring = elastic_material(stem + restoring, tags, parallel, compression_n_per_m=restoring)
    links: tuple[int, ...] = ()
    if is_parallel:
        across = [passive_material(passive, 0.0, tags), stem_spring]
    else:
        # The waves leave through the elastic part, in series with the plastic part, so the force of
        # spring and dashpot never exceeds the strength of the soil. Without tension in the plastic
        # part their sum is never tension.
        ground, wall = nodes
        nodes = ground, plane_node(ops.nodeCoord(wall), 0.0, tags)
        elastic = [elastic_material(elastic_part_n_per_m(passive), tags, dashpot)]
        along_tie = [elastic_material(NORMAL_OVER_NEIGHBOUR * wing.stiffness_n_per_m, tags)]
        link, _ = spring_element((nodes[1], wall), end.inward, elastic, along_tie, tags)
        links = (link.element,)
        across = [*plastic_part(passive, tags), stem_spring]
    return *spring_element(nodes, end.inward, across, along, tags), links


def _build_keys(joint: Joint, handle: AbutmentHandle, body: int | None) -> AbutmentHandle:
    """Create the exterior keys: on the ground with contacts, or on a body with gap springs."""
    end, options, tags = joint.end, joint.options, joint.tags
    friction = joint.blueprint.variant.friction * (options.friction_at != "walls")
    mass_kg = joint.moving_mass_kg(joint.key_mass_kg)
    penalty = penalties(key_stiffness_n_per_m(joint.key), mass_kg, options)
    springs: list[SpringHandle] = []
    key_nodes: list[int] = []
    units: list[int] = []
    gap_elements: list[int] = []
    # ASSUME the face of a key is parallel to the edge of the deck
    x, y = end.tangent if options.key_frame == "skewed" else turned(end.outward)
    for sign in (-1.0, 1.0):  # start and end of the tangent
        side = "+y" if sign * end.outward[0] > 0.0 else "-y"
        if joint.data.keys_at not in ("both", side):
            continue
        along_m, inward = sign * end.wall_length_m / 2, (-sign * x, -sign * y)
        node = plane_node(end.point("outer", along_m), mass_kg, tags)
        # the body does not rotate: its middle moves like its part at the key
        support = grounded_node(end.point("outer", along_m), tags) if body is None else body
        springs.append(joint.key_spring((support, node), inward))
        key_nodes.append(node)
        nodes = node, joint.points["outer", along_m]
        if body is None:
            contact = nodes, inward, options.transverse_gap_m, penalty, friction, f"key {side}"
            units.append(joint.add_contact(*contact))
        else:
            material = gap_material(penalty[0], options.transverse_gap_m, tags)
            gap_elements.append(spring_element(nodes, inward, [material], [], tags)[0].element)
    return replace(
        handle,
        key_springs=tuple(springs),
        key_nodes=tuple(key_nodes),
        key_units=tuple(units),
        other_springs=(*handle.other_springs, *gap_elements),
    )


#: Builder of each abutment model in `skewbridge.variant.variant`.
BUILDERS: Final[Mapping[str, Callable[[Joint], AbutmentHandle]]] = {
    "roller": lambda joint: joint.handle,
    "simplified": _build_simplified,
    "spring": _build_spring,
    "contact": _build_contact,
    "contact_friction": _build_contact,
}
