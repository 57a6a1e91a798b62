"""Model of a bridge variant, or of one abutment, built in the OpenSees domain; its geometry."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.abutments import support_deck_end
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
from skewbridge.bridge.section import FloatArray
from skewbridge.bridge.structures import built_bridge, deck_ends
from skewbridge.bridge.weights import deck_reactions_n
from skewbridge.errors import InputError
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

__all__ = [
    "AbutmentModel", "DomainError", "ModelGeometry", "build", "build_abutment",
    "column_axial_forces_n", "contact_column", "domain", "model_geometry", "support_reactions_n",
]  # fmt: skip


def build(variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build a variant in the open domain, at rest under its dead load; see `assemble`."""
    require_empty_domain()
    bridge = load_structure(variant.bridge)
    bridge.description.gaps_m(variant.normalised(), options)
    return assemble(bridge.build, variant, options)


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
    build_joint = support_deck_end(end, blueprint)
    if guide is not None:
        guide(connector, tags)
    hold_dead_load({connector: load_n}, {}, tags)
    return AbutmentModel(blueprint=blueprint, handle=build_joint(), connector=connector)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry:
    """Geometry of a variant at rest, for drawings; positions in m."""

    title: str
    #: both ends of all elements of each group in the energy balance, shape (n, 2, 3); the ends of
    #: zero-length springs are equal
    members: Mapping[str, FloatArray]
    #: positions of the contact units (both nodes: they do not show the gap), shape (n, 3)
    surfaces: FloatArray
    normals: FloatArray  # outward normals of these surfaces: force on the deck, shape (n, 3)
    gaps_m: FloatArray  # gaps of the units, shape (n,)
    fixed: FloatArray  # positions of fully or partly fixed nodes, shape (n, 3)
    deck_outline: FloatArray  # corners of the deck in plan, counter-clockwise, shape (n, 2)


def model_geometry(variant: Variant, options: ModelOptions) -> ModelGeometry:
    """Build a variant and return its geometry."""
    with domain():
        model = build(variant, options)
        units = model.contacts.units if model.contacts else ()
        ends = reversed(model.abutments)  # corners along the tangent: right, then left end
        return ModelGeometry(
            title=model.variant.slug,
            members={
                group: np.array([list(map(ops.nodeCoord, ops.eleNodes(tag))) for tag in tags])
                for group, tags in model.energy_elements.items()
            },
            surfaces=np.array([ops.nodeCoord(unit.node_j) for unit in units]),
            normals=np.array([unit.normal for unit in units]),
            gaps_m=np.array([unit.gap_m for unit in units]),
            fixed=np.array(list(map(ops.nodeCoord, ops.getFixedNodes()))),
            deck_outline=np.array([corner.plan_m for end in ends for corner in end.corners]),
        )


def contact_column(name: str) -> str:
    """Return the prefix of the history columns of a contact."""
    return f"contact_{name.replace(' ', '_')}"
