"""One abutment with the deck end it supports, without the bridge: the paper's sub-structure."""

from collections.abc import Callable
from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.abutment.arrays import LINK_NM_PER_RAD
from skewbridge.bridge.abutment.elements import elastic_material, grounded_node
from skewbridge.bridge.dead_load import abutment_reactions_n
from skewbridge.bridge.gravity import hold_dead_load
from skewbridge.bridge.handles import AbutmentHandle
from skewbridge.bridge.model import blueprint, build_joint, build_supports
from skewbridge.bridge.tags import TagAllocator
from skewbridge.contact import ContactSet
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentModel:
    """A right abutment under a connector node that stands for the deck.

    Attributes:
        handle: The abutment.
        connector: Node at the deck's centroid; moves in plan without turning.
        contacts: Its contact units, or None.
        tags: Allocator.
    """

    handle: AbutmentHandle
    connector: int
    contacts: ContactSet | None
    tags: TagAllocator


def build_abutment(
    variant: Variant,
    options: ModelOptions,
    *,
    guide: Callable[[int, TagAllocator], None] | None = None,
) -> AbutmentModel:
    """Build the right abutment of a variant in the open domain, at rest under its dead load.

    Args:
        variant: What to build.
        options: How.
        guide: Called with the connector and the allocator before the dead load, to hold in plan a
            deck end that nothing else holds there.
    """
    plan = blueprint(variant, options)
    bridge, tags = plan.bridge, plan.tags
    load_n = abutment_reactions_n(bridge)[1]
    # ASSUME the deck's inertia at an abutment is that of the dead load it carries
    mass_kg = load_n / G_MPS2
    connector = tags.node()
    ops.node(connector, bridge.length_m / 2, 0.0, bridge.deck.centroid_above_soffit_m)
    _hold_rotation(connector, tags)
    ops.mass(connector, mass_kg, mass_kg, mass_kg, 0.0, 0.0, 0.0)
    supports = build_supports("right", connector, plan)
    if guide is not None:
        guide(connector, tags)
    hold_dead_load({connector: load_n}, {}, tags)
    return AbutmentModel(
        handle=build_joint(supports, plan),
        connector=connector,
        contacts=plan.contacts,
        tags=tags,
    )


def _hold_rotation(connector: int, tags: TagAllocator) -> None:
    """Hold the rotations of the connector by stiff springs.

    Not by fixing: a retained node of a rigid link with single-point constraints of its own takes
    every increment more than once under the Transformation handler (seen in OpenSees 3.8).
    """
    ground, element = grounded_node(ops.nodeCoord(connector), tags), tags.element()
    stiff = elastic_material(LINK_NM_PER_RAD, tags)
    springs = ("-mat", stiff, stiff, stiff, "-dir", 4, 5, 6)
    ops.element("zeroLength", element, ground, connector, *springs)
