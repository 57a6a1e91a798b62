"""The abutment models `contact` and `contact_friction`: backwall and keys behind contact units.

At points along the backwall, corners included: ground - backfill and wing-wall springs - wall node
- contact unit - deck. At both keys: ground - backbone - key node - contact unit - deck. Only the
contact units have gaps.

References:
    Rahman and Mackie, section 4 of the paper (figure 9).
"""

from skewbridge.bridge.abutment.backfill import Passive, skew_reduction, wing_wall
from skewbridge.bridge.abutment.elements import (
    elastic_material,
    grounded_node,
    key_stiffness_n_per_m,
    normal_penalty,
    passive_material,
    plane_node,
    plastic_material,
    spring_element,
    tangent_penalty,
    turned,
)
from skewbridge.bridge.abutment.parts import SideContext, SideParts
from skewbridge.contact import ContactSet


def build_contact(context: SideContext) -> SideParts:
    """Create pads, walls, keys and their contacts on one side."""
    parts = SideParts()
    if context.contacts is None:
        raise TypeError("the contact abutment needs a ContactSet")
    _build_wall(context, context.contacts, parts)
    for sign in (-1.0, 1.0):
        _build_key(context, context.contacts, parts, sign)
    return parts


def _build_wall(context: SideContext, contacts: ContactSet, parts: SideParts) -> None:
    """Create the wall points: independent nodes, each with its share of wall and soil."""
    end, options, tags = context.end, context.options, context.tags
    for along, share, passive in context.wall_parts():
        mass_kg = context.moving_mass_kg(context.wall_mass_kg * share)
        # The penalty of a point is proportional to its soil, so that the soil spreads the force.
        kn = normal_penalty(passive.stiffness_n_per_m, mass_kg, options)
        deck_node = context.arms.at("outer", along)
        wall = plane_node(end.point("outer", along), mass_kg, tags)
        ground = grounded_node(end.point("outer", along), tags)
        _hold_wall_point(context, (ground, wall), share, passive, parts)
        unit = contacts.add(
            wall,
            deck_node,
            (*end.inward, 0.0),
            context.gap_m,
            context.friction * (options.friction_at != "keys"),
            options.cohesion_n * share,
            kn=kn,
            kt=tangent_penalty(kn, options),
            tangent=(*turned(end.inward), 0.0),
            name=f"{end.side} backwall {len(parts.wall_units) + 1}",
        )
        parts.wall_units.append(unit)
        parts.wall_nodes.append(wall)


def _hold_wall_point(
    context: SideContext, nodes: tuple[int, int], share: float, passive: Passive, parts: SideParts
) -> None:
    """Create the springs between ground and a wall node."""
    end, options, tags = context.end, context.options, context.tags
    mass_kg = context.wall_mass_kg * share
    weak = options.wall_restoring_n_per_m * skew_reduction(end.skew_rad) * share
    stiffness, wing = passive.stiffness_n_per_m, context.soil(wing_wall(context.data)).scaled(share)
    # ASSUME towards the deck the stem of the wall is as stiff as the soil initially: shaking
    # alone does not swing the wall into the gap
    leaning = stiffness + weak
    across_n_s_per_m = context.wall_dashpot_n_s_per_m(stiffness, mass_kg, share)
    across = [
        passive_material(passive, 0.0, tags),
        elastic_material(
            leaning, tags, dashpot_n_s_per_m=across_n_s_per_m, compression_n_per_m=weak
        ),
    ]
    along_n_s_per_m = context.wing_dashpot_n_s_per_m(wing, mass_kg, share)
    along = [
        plastic_material(wing.stiffness_n_per_m, wing.ultimate_n, tags),
        elastic_material(weak, tags, dashpot_n_s_per_m=along_n_s_per_m),
    ]
    wall_spring, wing_spring = spring_element(nodes, end.inward, across, along, tags)
    parts.wall_springs.append(wall_spring)
    parts.wing_springs.append(wing_spring)


def _build_key(context: SideContext, contacts: ContactSet, parts: SideParts, sign: float) -> None:
    """Create one exterior key and its contact with the corner of the deck."""
    end, options, tags = context.end, context.options, context.tags
    along = sign * end.wall_length_m / 2
    inward = context.key_inward_normal(sign)
    mass_kg = context.moving_mass_kg(context.key_mass_kg)
    deck_node = context.arms.at("outer", along)
    node = plane_node(end.point("outer", along), mass_kg, tags)
    ground = grounded_node(end.point("outer", along), tags)
    parts.key_springs.append(context.key_spring((ground, node), inward))
    kn = normal_penalty(key_stiffness_n_per_m(context.key), mass_kg, options)
    unit = contacts.add(
        node,
        deck_node,
        (*inward, 0.0),
        options.transverse_gap_m,
        context.friction * (options.friction_at != "walls"),
        kn=kn,
        kt=tangent_penalty(kn, options),
        tangent=(*turned(inward), 0.0),
        name=f"{end.side} key {'+' if sign > 0.0 else '-'}",
    )
    parts.key_units.append(unit)
    parts.key_nodes.append(node)
