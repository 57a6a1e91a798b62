"""OpenSees domain and the model of a bridge variant, or of one abutment, built in it."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, radians, sqrt
from typing import Any

import openseespy.opensees as ops

from skewbridge.bridge.abutments import build_joint, support_deck_end
from skewbridge.bridge.bent import build_bents
from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.deck import build_spine, deck_reactions_n, hold_dead_load
from skewbridge.bridge.handles import AbutmentHandle, Blueprint, BridgeModel, TagAllocator
from skewbridge.contact import ContactSet
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


class DomainError(RuntimeError):
    """The domain already contains a model."""


@contextmanager
def domain() -> Generator[None]:
    """Open the only OpenSees domain of the process: empty on entry, wiped on exit."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    try:
        yield
    finally:
        ops.wipe()


def build(variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build the model of a variant in the open domain, at rest under its dead load.

    The joints are built after the dead load is applied, because the dead load rotates the deck ends
    and gaps are openings at rest. Axes that the abutment model does not have are ignored.

    Returns:
        Handles of the model, valid until the domain closes.

    Raises:
        InputError: The bridge does not exist, or its file has invalid data.
        DomainError: The domain already contains a model.
        GravityError: The gravity analysis does not converge.
    """
    plan = blueprint(variant, options)
    spine = build_spine(plan.bridge, options.deck_elements_per_span, plan.tags)
    skew_deg = options.skew_of_bents_deg(plan.variant.skew_deg)
    columns, foundations = build_bents(plan.bridge, spine, skew_deg, options, plan.tags)
    left_end = support_deck_end("left", spine.nodes[0], plan)
    right_end = support_deck_end("right", spine.nodes[-1], plan)
    hold_dead_load(spine.loads_n, spine.moments_nm, plan.tags)
    sides = left, right = build_joint(left_end), build_joint(right_end)
    column_elements = tuple(column.element for column in columns)
    springs = {spring.element for side in sides for spring in side.springs}
    others = {element for side in sides for element in side.other_springs}
    units = plan.contacts.units if plan.contacts else ()
    return BridgeModel(
        **vars(plan),
        deck_nodes=tuple(spine.nodes),
        deck_centre_node=spine.centre_node,
        deck_masses_kg={node: ops.nodeMass(node, 1) for node in spine.loads_n},
        dead_loads_n=dict(spine.loads_n),
        dead_moments_nm=spine.moments_nm,
        columns=columns,
        abutments=sides,
        energy_elements={
            "columns": column_elements,
            "deck": tuple(spine.elements),
            "bearings": tuple(bearing.element for side in sides for bearing in side.bearings),
            "backfill": tuple(sorted(springs | others)),
            "contact": tuple(unit.element for unit in units),
            "links": (*foundations, *left.links, *right.links),
        },
        damping_elements=(*spine.elements, *column_elements),
    )


def blueprint(variant: Variant, options: ModelOptions) -> Blueprint:
    """Return the blueprint of a variant for the open domain.

    Abutment model `contact` has the contact units of `contact_friction` but never updates them.
    """
    if ops.getNodeTags():
        raise DomainError("call build() inside `with domain():`, once per domain")
    variant, tags, contacts = variant.normalised(), TagAllocator(), None
    if variant.traits.has_contacts:
        is_updated = variant.traits.has_friction
        contacts = ContactSet(tags, update=is_updated, coupling=options.coupling)
    bridge = built_bridge(load_bridge(variant.bridge), options, variant.skew_deg)
    return Blueprint(variant=variant, bridge=bridge, options=options, tags=tags, contacts=contacts)


def built_bridge(bridge: BridgeData, options: ModelOptions, skew_deg: float = 0.0) -> BridgeData:
    """Return a bridge with materials, mass, pads and keys multiplied by the option factors.

    Bents of a skewed bridge get the column spacing along the bent and the weight of their longer
    cap. The factors on damping and backfill are applied where damping and backfill are computed.
    """
    # the cap of a skewed bent ends at the edges of the deck
    stretch = 1.0 / cos(radians(options.skew_of_bents_deg(skew_deg)))
    spacing = stretch if options.column_spacing == "normal" else 1.0
    concrete, steel = options.concrete_strength_factor, options.steel_strength_factor
    mass, key = options.deck_mass_factor, {"force_kn": options.key_strength_factor}
    column = {
        "concrete_strength_mpa": concrete,
        "expected_concrete_strength_mpa": concrete,
        "elastic_modulus_gpa": sqrt(concrete),
        "steel_strength_factor": steel,
        "hoop_yield_mpa": steel,
    }
    factors = {
        "column": column,
        "deck": {"line_load_kn_per_m": mass, "diaphragm_weight_kn": mass},
        "bents": {
            "cap_weight_kn": mass * stretch,
            "column_spacing_m": spacing,
            "column": column,
        },
        "abutment": {
            # ASSUME a softer rubber keeps its vertical stiffness, which hardly affects demands
            "pads": {
                "shear_stiffness_kn_per_m": options.pad_stiffness_factor,
                "yield_force_kn": options.pad_strength_factor,
            },
            "sacrificial_key": key,
            "monolithic_key": key,
        },
    }
    return _scaled(bridge, factors)


def _scaled(value: Any, factors: Any) -> Any:
    """Return a number, tuple items or the named fields of a part, multiplied by the factors."""
    if value is None:
        return None
    if isinstance(value, tuple):
        return tuple(_scaled(item, factors) for item in value)
    if isinstance(factors, dict):
        update = {name: _scaled(getattr(value, name), each) for name, each in factors.items()}
        return value.model_copy(update=update)
    return factors * value


@dataclass(frozen=True, kw_only=True)
class AbutmentModel(Blueprint):
    """Model of a right abutment; the connector node is at the deck's centroid and cannot rotate."""

    handle: AbutmentHandle
    connector: int


def build_abutment(
    variant: Variant,
    options: ModelOptions,
    *,
    guide: Callable[[int, TagAllocator], None] | None = None,
) -> AbutmentModel:
    """Build the right abutment of a variant in the open domain, at rest under its dead load.

    ``guide`` is called with the connector and the tag allocator before the dead load is applied. It
    can restrain the deck end in plan in directions in which the abutment does not.
    """
    plan = blueprint(variant, options)
    bridge, connector = plan.bridge, plan.tags.node()
    load_n = deck_reactions_n(bridge)[-1]
    # ASSUME the deck mass at an abutment is the mass of the dead load on it
    mass_kg = load_n / G_MPS2
    ops.node(connector, bridge.length_m / 2, 0.0, bridge.deck.centroid_above_soffit_m)
    ops.fix(connector, 0, 0, 0, 1, 1, 1)
    ops.mass(connector, mass_kg, mass_kg, mass_kg, 0.0, 0.0, 0.0)
    joint = support_deck_end("right", connector, plan)
    if guide is not None:
        guide(connector, plan.tags)
    hold_dead_load({connector: load_n}, {}, plan.tags)
    return AbutmentModel(**vars(plan), handle=build_joint(joint), connector=connector)
