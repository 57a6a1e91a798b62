"""`roller`: vertical support only, at both ends of the skewed bearing line.

`simplified`: besides, a rigid bar of deck width with a gap and a bilinear spring at each end.

References:
    Aviram, Mackie and Stojadinovic (2008), PEER 2008/03.
"""

from skewbridge.bridge.abutment.backfill import (
    sdc_backfill,
    skew_reduction,
    variation_factors,
    wing_wall,
)
from skewbridge.bridge.abutment.elements import (
    grounded_node,
    passive_material,
    plastic_material,
    spring_element,
)
from skewbridge.bridge.abutment.parts import SideContext, SideParts


def build_roller(_context: SideContext) -> SideParts:
    """Leave the deck end free on its supports."""
    return SideParts()


def build_simplified(context: SideContext) -> SideParts:
    """Create bar ends with half of the backfill and half of the transverse resistance each."""
    end, data, tags = context.end, context.data, context.tags
    parts = SideParts()
    straight = sdc_backfill(data.wall_width_m, data.wall_height_m)
    longitudinal = straight.scaled(0.5 * skew_reduction(end.skew_rad))
    # ASSUME the transverse springs act at once, as in the published model
    transverse = wing_wall(data).scaled(0.5)
    ends = [-end.wall_length_m / 2, end.wall_length_m / 2]
    factors = variation_factors(
        ends, end.skew_rad, context.options.backfill_variation, end.acute_sign
    )
    for along, factor in zip(ends, factors, strict=True):
        deck_node = context.arrays.at("outer", along)
        ground = grounded_node(end.point("outer", along), tags)
        nodes = (ground, deck_node)
        soil = passive_material(longitudinal.scaled(factor), context.gap_m, tags)
        wing = plastic_material(transverse.stiffness_n_per_m, transverse.ultimate_n, tags)
        wall_spring, wing_spring = spring_element(nodes, end.inward, [soil], [wing], tags)
        parts.wall_springs.append(wall_spring)
        parts.key_springs.append(wing_spring)
    return parts
