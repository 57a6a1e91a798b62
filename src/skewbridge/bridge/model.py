"""Model of a bridge variant, or of one abutment, built in the OpenSees domain."""

from collections.abc import Callable
from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.abutments import build_joint, support_deck_end
from skewbridge.bridge.assembly import (
    DomainError,
    assemble,
    blueprint_of,
    domain,
    hold_dead_load,
    require_empty_domain,
)
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import AbutmentData
from skewbridge.bridge.frame import Blueprint, BridgeModel, End
from skewbridge.bridge.handles import AbutmentHandle, TagAllocator
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.structures import built_bridge, deck_ends
from skewbridge.bridge.weights import deck_reactions_n
from skewbridge.errors import InputError
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

__all__ = [
    "AbutmentModel", "DomainError", "build", "build_abutment", "column_axial_forces_n", "domain",
    "support_reactions_n",
]  # fmt: skip


def build(variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build a variant in the open domain, at rest under its dead load; see `assemble`."""
    return assemble(load_structure(variant.bridge).build, variant, options)


def column_axial_forces_n(model: BridgeModel) -> list[float]:
    """Return the compression in N at the base of every column, from the element forces."""
    return [float(ops.eleResponse(column.element, "force")[2]) for column in model.columns]


def support_reactions_n(model: BridgeModel) -> list[float]:
    """Return the vertical reaction in N of each abutment, left to right."""
    ops.reactions()
    return [
        sum(float(ops.nodeReaction(node, 3)) for node in abutment.holders)
        for abutment in model.abutments
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentModel:
    """Model of a right abutment; the connector node is at the deck's centroid and cannot rotate."""

    blueprint: Blueprint
    handle: AbutmentHandle
    connector: int


def build_abutment(
    variant: Variant,
    options: ModelOptions,
    *,
    guide: Callable[[int, TagAllocator], None] | None = None,
) -> AbutmentModel:
    """Build the right abutment of a variant in the open domain, at rest under its dead load.

    ``guide`` is called with connector and tags before the dead load: it can restrain the deck end
    in plan.
    """
    require_empty_domain()
    blueprint = blueprint_of(variant, options, TagAllocator())
    tags, skew_deg = blueprint.tags, blueprint.variant.skew_deg
    bridge, connector = built_bridge(load_bridge(variant.bridge), options, skew_deg), tags.node()
    plan = deck_ends(bridge, skew_deg)[-1]
    data = bridge.ends[plan.name]
    if not isinstance(data, AbutmentData):
        raise InputError(
            f"{bridge.name}: only a seat can be pushed alone, the {plan.name} end is {data.type}"
        )
    load_n = deck_reactions_n(bridge)[-1]
    # ASSUME the deck mass at an abutment is the mass of the dead load on it
    mass_kg = load_n / G_MPS2
    ops.node(connector, *plan.middle_m, bridge.deck.centroid_above_soffit_m)
    ops.fix(connector, 0, 0, 0, 1, 1, 1)
    ops.mass(connector, mass_kg, mass_kg, mass_kg, 0.0, 0.0, 0.0)
    end = End(node=connector, plan=plan, abutment=data)
    joint = support_deck_end(end, blueprint)
    if guide is not None:
        guide(connector, tags)
    hold_dead_load({connector: load_n}, {}, tags)
    return AbutmentModel(blueprint=blueprint, handle=build_joint(joint), connector=connector)
