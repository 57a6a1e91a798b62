"""The model of a variant: the one way into the OpenSees domain."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Final

import openseespy.opensees as ops

from skewbridge.bridge.abutment.arrays import Arrays, Line, build_arrays
from skewbridge.bridge.abutment.contact import build_contact
from skewbridge.bridge.abutment.parts import SideContext, SideParts, side_handle
from skewbridge.bridge.abutment.roller import build_roller
from skewbridge.bridge.abutment.simplified import build_simplified
from skewbridge.bridge.abutment.spring import build_spring
from skewbridge.bridge.abutment.supports import pad_stations
from skewbridge.bridge.bent import Bents, build_bents
from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.deck import Deck, build_spine
from skewbridge.bridge.deck_plan import DeckEnd, Side, deck_end
from skewbridge.bridge.handles import AbutmentHandle, BridgeModel
from skewbridge.bridge.tags import TagAllocator
from skewbridge.contact import ContactSet
from skewbridge.units import MM
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

LADDER: Final[dict[str, Callable[[SideContext], SideParts]]] = {
    "roller": build_roller,
    "simplified": build_simplified,
    "spring": build_spring,
    "contact": build_contact,
    "contact_friction": build_contact,
}
CONTACT_MODELS: Final = ("contact", "contact_friction")


class DomainError(RuntimeError):
    """A model was asked for in a domain that has one."""


@contextmanager
def domain() -> Generator[None]:
    """Own the one OpenSees domain of the process: empty on entry, wiped on exit."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    try:
        yield
    finally:
        ops.wipe()


def build(variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build a variant in the open domain, without gravity.

    Args:
        variant: Bridge, abutment model, skew, gap and friction; axes that the abutment model does
            not have are ignored.
        options: Modelling choices.

    Returns:
        Handles, valid until the domain closes.

    Raises:
        InputError: No such bridge, or bad data in its file.
        DomainError: The domain is not fresh.
    """
    require_fresh_domain()
    variant = variant.normalised()
    bridge = load_bridge(variant.bridge)
    tags = TagAllocator()
    spine = build_spine(bridge, options.deck_elements_per_span, tags)
    bents = build_bents(bridge, spine, options, tags)
    contacts = build_contact_set(variant, options, tags)
    sides: list[tuple[AbutmentHandle, SideParts, Arrays]] = []
    ends: list[tuple[Side, int]] = [("left", spine.nodes[0]), ("right", spine.nodes[-1])]
    for side, node in ends:
        sides.append(build_side(side, node, variant, bridge, options, tags, contacts))
    return _assemble(variant, bridge, options, tags, spine, bents, sides, contacts)


def require_fresh_domain() -> None:
    """Refuse to build into a domain that has nodes."""
    if ops.getNodeTags():
        raise DomainError("build() works inside `with domain():`, once per domain")


def build_contact_set(
    variant: Variant, options: ModelOptions, tags: TagAllocator
) -> ContactSet | None:
    """Return the empty contact set of a variant; None for models without contact.

    `contact` has the elements of `contact_friction`, never updated.
    """
    if variant.abutment not in CONTACT_MODELS:
        return None
    has_friction = variant.abutment == "contact_friction"
    return ContactSet(tags, update=has_friction, coupling=options.coupling)


def build_side(
    side: Side,
    deck_node: int,
    variant: Variant,
    bridge: BridgeData,
    options: ModelOptions,
    tags: TagAllocator,
    contacts: ContactSet | None,
) -> tuple[AbutmentHandle, SideParts, Arrays]:
    """Build one abutment under an end node of the spine."""
    deck = bridge.deck
    end = deck_end(
        side, bridge.length_m, variant.skew_deg, deck.width_m, deck.diaphragm_thickness_m
    )
    arrays = build_arrays(
        end, deck_node, _stations(end, bridge, variant.abutment, options), options, tags
    )
    context = SideContext(
        end=end,
        arrays=arrays,
        data=bridge.abutment,
        options=options,
        tags=tags,
        gap_m=variant.gap_mm * MM,  # ASSUME measured normal to the wall
        friction=variant.friction,
        contacts=contacts,
    )
    parts = LADDER[variant.abutment](context)
    return side_handle(context, parts), parts, arrays


def _stations(
    end: DeckEnd, bridge: BridgeData, abutment: str, options: ModelOptions
) -> dict[Line, list[float]]:
    """Return where each array needs nodes."""
    half = end.wall_length_m / 2
    corners = [-half, half]
    has_pads = abutment in ("spring", *CONTACT_MODELS)
    return {
        "inner": corners,
        "bearing": pad_stations(bridge.abutment.pads, end) if has_pads else corners,
        "outer": end.wall_stations(options.backwall_points) if has_pads else corners,
    }


def _assemble(
    variant: Variant,
    bridge: BridgeData,
    options: ModelOptions,
    tags: TagAllocator,
    spine: Deck,
    bents: Bents,
    sides: list[tuple[AbutmentHandle, SideParts, Arrays]],
    contacts: ContactSet | None,
) -> BridgeModel:
    left, right = (handle for handle, *_ in sides)
    columns = tuple(column.element for column in bents.columns)
    springs = {
        spring.element
        for abutment in (left, right)
        for spring in (*abutment.wall_springs, *abutment.key_springs, *abutment.wing_springs)
    }
    others = {element for abutment in (left, right) for element in abutment.other_springs}
    return BridgeModel(
        variant=variant,
        bridge=bridge,
        options=options,
        deck_nodes=tuple(spine.nodes),
        deck_centre_node=spine.centre_node,
        deck_mass_nodes=tuple(spine.masses_kg),
        deck_masses_kg=tuple(spine.masses_kg.values()),
        wall_masses_kg={k: v for _, parts, _ in sides for k, v in parts.masses_kg.items()},
        dead_loads_n=dict(spine.loads_n),
        dead_moments_nm=spine.moments_nm,
        deck_elements=tuple(spine.elements),
        columns=bents.columns,
        abutments=(left, right),
        contacts=contacts,
        energy_elements={
            "columns": columns,
            "deck": tuple(spine.elements),
            "bearings": tuple(b.element for a in (left, right) for b in a.bearings),
            "backfill": tuple(sorted(springs | others)),
            "contact": tuple(unit.element for unit in contacts.units) if contacts else (),
            "links": (*bents.foundations, *(e for *_, arrays in sides for e in arrays.links)),
        },
        damping_elements=(*spine.elements, *columns),
        tags=tags,
    )
