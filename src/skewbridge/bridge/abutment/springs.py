"""The abutment models `roller`, `simplified` and `spring`, which have no contact units.

`roller` has only vertical supports at both ends of the skewed bearing line. `simplified` adds a
rigid bar of deck width with a gap and a bilinear spring at each end. `spring` has pads, gap springs
of the backfill, shear keys, wing walls and embankment: each exterior key is between the deck
(behind the transverse gap) and the body of the abutment, which the wing walls hold along the wall
and which may carry the mass of the embankment.

References:
    Aviram, Mackie and Stojadinovic (2008), PEER 2008/03; Zhang and Makris (2002).
"""

from math import sqrt

from skewbridge.bridge.abutment.backfill import (
    SOIL_KG_PER_M3,
    sdc_backfill,
    skew_reduction,
    variation_factors,
    wing_wall,
)
from skewbridge.bridge.abutment.elements import (
    elastic_material,
    gap_material,
    grounded_node,
    key_stiffness_n_per_m,
    normal_penalty,
    passive_material,
    plane_node,
    plastic_material,
    spring_element,
)
from skewbridge.bridge.abutment.parts import SideContext, SideParts


def build_roller(_context: SideContext) -> SideParts:
    """Add nothing: the deck end is free on its supports."""
    return SideParts()


def build_simplified(context: SideContext) -> SideParts:
    """Create the springs at both ends of the bar, each with half of the resistance."""
    end, data, tags = context.end, context.data, context.tags
    parts = SideParts()
    straight = context.soil(sdc_backfill(data.wall_width_m, data.wall_height_m))
    longitudinal = straight.scaled(0.5 * skew_reduction(end.skew_rad))
    # ASSUME the transverse springs have no gap, as in the published model
    transverse = context.soil(wing_wall(data)).scaled(0.5)
    ends = [-end.wall_length_m / 2, end.wall_length_m / 2]
    factors = variation_factors(
        ends, end.skew_rad, context.options.backfill_variation, end.acute_sign
    )
    for along, factor in zip(ends, factors, strict=True):
        deck_node = context.arms.at("outer", along)
        ground = grounded_node(end.point("outer", along), tags)
        nodes = (ground, deck_node)
        soil = passive_material(longitudinal.scaled(factor), context.gap_m, tags)
        wing = plastic_material(transverse.stiffness_n_per_m, transverse.ultimate_n, tags)
        wall_spring, wing_spring = spring_element(nodes, end.inward, [soil], [wing], tags)
        parts.wall_springs.append(wall_spring)
        parts.key_springs.append(wing_spring)
    return parts


def build_spring(context: SideContext) -> SideParts:
    """Create the springs of one side."""
    parts = SideParts()
    _build_backfill(context, parts)
    body = _build_body(context, parts)
    for sign in (-1.0, 1.0):
        _build_key(context, parts, body, sign)
    return parts


def embankment_mass_kg(context: SideContext) -> float:
    """Return the mass of the critical length of the embankment, 0.7 sqrt(S B H).

    References:
        Zhang and Makris (2002), Earthquake Eng. Struct. Dyn. 31, section on critical length.
    """
    data = context.data
    width, height = data.wall_width_m, data.embankment_height_m
    length = 0.7 * sqrt(data.embankment_slope_ratio * width * height)
    # ASSUME a trapezoid with side slopes of 1 / slope ratio, moving as one body
    area = width * height + height**2 * data.embankment_slope_ratio
    return length * area * SOIL_KG_PER_M3


def _build_backfill(context: SideContext, parts: SideParts) -> None:
    end, tags = context.end, context.tags
    for along, _, passive in context.wall_parts():
        ground = grounded_node(end.point("outer", along), tags)
        nodes = (ground, context.arms.at("outer", along))
        material = passive_material(passive, context.gap_m, tags)
        parts.wall_springs.append(spring_element(nodes, end.inward, [material], [], tags)[0])


def _build_body(context: SideContext, parts: SideParts) -> int:
    """Create the abutment's body: wing walls along the wall, stiff across it."""
    end, data, tags = context.end, context.data, context.tags
    embankment_kg = embankment_mass_kg(context) if context.options.embankment_mass else 0.0
    mass_kg = context.wall_mass_kg + embankment_kg
    wing = context.soil(wing_wall(data))
    # ASSUME across the wall the body is held by its initial backfill stiffness
    across = context.wall_parts()[0][2].stiffness_n_per_m / skew_reduction(end.skew_rad)
    moving_kg = context.moving_mass_kg(context.wall_mass_kg) + embankment_kg
    body = plane_node(end.point("outer", 0.0), moving_kg, tags)
    ground = grounded_node(end.point("outer", 0.0), tags)
    along_wall = [
        plastic_material(wing.stiffness_n_per_m, wing.ultimate_n, tags),
        elastic_material(
            0.0, tags, dashpot_n_s_per_m=context.wing_dashpot_n_s_per_m(wing, mass_kg)
        ),
    ]
    across_it = [
        elastic_material(
            across, tags, dashpot_n_s_per_m=context.wall_dashpot_n_s_per_m(across, mass_kg)
        )
    ]
    spring, _ = spring_element((ground, body), end.tangent, along_wall, across_it, tags)
    parts.wing_springs.append(spring)
    return body


def _build_key(context: SideContext, parts: SideParts, body: int, sign: float) -> None:
    """Create one key on the body, and the gap between the key and the corner of the deck."""
    end, tags, mass_kg = context.end, context.tags, context.moving_mass_kg(context.key_mass_kg)
    along = sign * end.wall_length_m / 2
    inward = context.key_inward_normal(sign)
    deck_node = context.arms.at("outer", along)
    node = plane_node(end.point("outer", along), mass_kg, tags)
    # the body moves without turning: its middle represents its part at the key
    holder = context.key_spring((body, node), inward)
    penalty = normal_penalty(key_stiffness_n_per_m(context.key), mass_kg, context.options)
    material = gap_material(penalty, context.options.transverse_gap_m, tags)
    gap, _ = spring_element((node, deck_node), inward, [material], [], tags)
    parts.key_springs.append(holder)
    parts.other_springs.append(gap.element)
    parts.key_nodes.append(node)
