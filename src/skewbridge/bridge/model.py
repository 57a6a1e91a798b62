"""The OpenSees domain, and the model of a bridge variant or of one abutment in it."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.abutment import BUILDERS
from skewbridge.bridge.abutment.parts import SideContext, side_handle
from skewbridge.bridge.abutment.supports import (
    build_arms,
    build_pads,
    build_vertical_supports,
    pad_stations,
    pad_supports,
)
from skewbridge.bridge.bent import build_bents
from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.deck import DeckEnd, Line, Side, build_spine, deck_end
from skewbridge.bridge.gravity import abutment_reactions_n, hold_dead_load
from skewbridge.bridge.handles import AbutmentHandle, BridgeModel, TagAllocator
from skewbridge.contact import ContactSet
from skewbridge.units import G_MPS2, MM
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Blueprint:
    """The variant to build, with the data that its parts share while they are built."""

    variant: Variant  # normalised
    bridge: BridgeData
    options: ModelOptions
    tags: TagAllocator
    contacts: ContactSet | None  # still empty; None for models without contact


def build(variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build a variant in the open domain, at rest under its dead load.

    The joints are built last, because dead load rotates the deck ends and a gap is the opening at
    rest.
    Axes that the abutment model does not have are ignored.

    Returns:
        Handles, valid until the domain closes.

    Raises:
        InputError: No such bridge, or bad data in its file.
        DomainError: The domain is not fresh.
        GravityError: The model does not carry its weight.
    """
    plan = blueprint(variant, options)
    spine = build_spine(plan.bridge, options.deck_elements_per_span, plan.tags)
    columns, foundations = build_bents(plan.bridge, spine, options, plan.tags)
    ends = (
        build_supports("left", spine.nodes[0], plan),
        build_supports("right", spine.nodes[-1], plan),
    )
    hold_dead_load(spine.loads_n, spine.moments_nm, plan.tags)
    sides = left, right = build_joint(ends[0], plan), build_joint(ends[1], plan)
    column_elements = tuple(column.element for column in columns)
    springs = {spring.element for side in sides for spring in side.springs}
    others = {element for side in sides for element in side.other_springs}
    units = plan.contacts.units if plan.contacts else ()
    return BridgeModel(
        variant=plan.variant,
        bridge=plan.bridge,
        options=plan.options,
        deck_nodes=tuple(spine.nodes),
        deck_centre_node=spine.centre_node,
        deck_masses_kg=dict(spine.masses_kg),
        dead_loads_n=dict(spine.loads_n),
        dead_moments_nm=spine.moments_nm,
        columns=columns,
        abutments=sides,
        contacts=plan.contacts,
        energy_elements={
            "columns": column_elements,
            "deck": tuple(spine.elements),
            "bearings": tuple(bearing.element for side in sides for bearing in side.bearings),
            "backfill": tuple(sorted(springs | others)),
            "contact": tuple(unit.element for unit in units),
            "links": (*foundations, *left.links, *right.links),
        },
        damping_elements=(*spine.elements, *column_elements),
        tags=plan.tags,
    )


def blueprint(variant: Variant, options: ModelOptions) -> Blueprint:
    """Return the blueprint of a variant for the open domain.

    `contact` has the contact units of `contact_friction`, never updated.
    """
    if ops.getNodeTags():
        raise DomainError("build() works inside `with domain():`, once per domain")
    variant, tags, contacts = variant.normalised(), TagAllocator(), None
    if variant.traits.has_contacts:
        is_updated = variant.traits.has_friction
        contacts = ContactSet(tags, update=is_updated, coupling=options.coupling)
    bridge = scaled_bridge(load_bridge(variant.bridge), options)
    return Blueprint(variant=variant, bridge=bridge, options=options, tags=tags, contacts=contacts)


def scaled_bridge(bridge: BridgeData, options: ModelOptions) -> BridgeData:
    """Return a bridge with the factors of the options on materials, mass, pads and keys.

    Those on damping and backfill act where they enter the model.
    """
    column, deck, abutment = bridge.column, bridge.deck, bridge.abutment
    concrete, steel = options.concrete_strength_factor, options.steel_strength_factor
    mass, pads = options.deck_mass_factor, abutment.pads
    columns = {
        "concrete_strength_mpa": concrete * column.concrete_strength_mpa,
        "expected_concrete_strength_mpa": concrete * column.expected_concrete_strength_mpa,
        "elastic_modulus_gpa": sqrt(concrete) * column.elastic_modulus_gpa,
        "steel_strength_factor": steel * column.steel_strength_factor,
        "hoop_yield_mpa": steel * column.hoop_yield_mpa,
    }
    decks = {
        "line_load_kn_per_m": mass * deck.line_load_kn_per_m,
        "diaphragm_weight_kn": mass * deck.diaphragm_weight_kn,
    }
    # ASSUME a softer rubber leaves the vertical stiffness, which hardly moves demands
    rubber = {
        "shear_stiffness_kn_per_m": options.pad_stiffness_factor * pads.shear_stiffness_kn_per_m,
        "yield_force_kn": options.pad_strength_factor * pads.yield_force_kn,
    }
    keys = {
        name: key.model_copy(
            update={"force_kn": tuple(options.key_strength_factor * f for f in key.force_kn)}
        )
        for name, key in (
            ("sacrificial_key", abutment.sacrificial_key),
            ("monolithic_key", abutment.monolithic_key),
        )
    }
    bents = [
        bent.model_copy(update={"cap_weight_kn": mass * bent.cap_weight_kn})
        for bent in bridge.bents
    ]
    joint = {"pads": pads.model_copy(update=rubber), **keys}
    return bridge.model_copy(
        update={
            "column": column.model_copy(update=columns),
            "deck": deck.model_copy(update=decks),
            "bents": tuple(bents),
            "abutment": abutment.model_copy(update=joint),
        }
    )


def build_supports(side: Side, deck_node: int, plan: Blueprint) -> SideContext:
    """Build the points of the joint at an end node of the spine, and their supports."""
    bridge, deck = plan.bridge, plan.bridge.deck
    end = deck_end(
        side, bridge.length_m, plan.variant.skew_deg, deck.width_m, deck.diaphragm_thickness_m
    )
    arms = build_arms(end, deck_node, _stations(end, plan), plan.options, plan.tags)
    pads = bridge.abutment.pads
    has_pads = plan.variant.traits.has_pads
    if has_pads:
        bearings = build_pads(end, arms, pads, plan.options, plan.tags)
    else:
        bearings = build_vertical_supports(end, arms, pads, plan.tags)
    half = end.wall_length_m / 2
    return SideContext(
        end=end,
        arms=arms,
        bearings=bearings,
        pad_stations_m=tuple(pad_stations(pads, end)) if has_pads else (-half, half),
        data=bridge.abutment,
        options=plan.options,
        tags=plan.tags,
        gap_m=max(
            plan.variant.normal_gap_m(plan.options.gap_measured) + plan.options.gap_offset_mm * MM,
            0.0,
        ),
        friction=plan.variant.friction,
        contacts=plan.contacts,
    )


def build_joint(context: SideContext, plan: Blueprint) -> AbutmentHandle:
    """Build the joint between a deck end at rest and its abutment: walls, keys and their gaps."""
    return side_handle(context, BUILDERS[plan.variant.abutment](context))


def _stations(end: DeckEnd, plan: Blueprint) -> dict[Line, list[float]]:
    """Return the positions along the wall at which each line needs nodes."""
    half, traits = end.wall_length_m / 2, plan.variant.traits
    corners = [-half, half]
    walls = end.wall_stations(plan.options.backwall_points) if traits.has_wall_points else corners
    pads = corners
    if traits.has_pads:
        pads = pad_supports(plan.bridge.abutment.pads, end, plan.options)
    return {"bearing": pads, "outer": walls}


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentModel:
    """A right abutment under a connector at the deck's centroid, which moves without rotating."""

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

    ``guide`` is called with the connector and the allocator before the dead load, to hold the deck
    end in plan if the abutment does not.
    """
    plan = blueprint(variant, options)
    bridge, tags = plan.bridge, plan.tags
    load_n = abutment_reactions_n(bridge)[1]
    # ASSUME the deck's inertia at an abutment is that of the dead load it carries
    mass_kg = load_n / G_MPS2
    connector = tags.node()
    ops.node(connector, bridge.length_m / 2, 0.0, bridge.deck.centroid_above_soffit_m)
    ops.fix(connector, 0, 0, 0, 1, 1, 1)
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
