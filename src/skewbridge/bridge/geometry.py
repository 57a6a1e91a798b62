"""The geometry of a built model as plain data, for drawing."""

from collections.abc import Generator
from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.handles import BridgeModel, PlanVector
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

type Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A line between two points.

    Attributes:
        group: ``columns, deck, bearings, backfill, contact, links`` or ``rigid links``.
        tag: Element tag; 0 for rigid links.
        ends: Positions at rest in m.
    """

    group: str
    tag: int
    ends: tuple[Point, Point]


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactPlace:
    """Where a contact unit stands, on which side.

    Attributes:
        surface: Position of the pair on the closed line at rest, in m.
        normal: Outward normal of the surface (direction of its force on the deck), in plan.
        tangent: First direction of its friction force; the force on the deck has the other sign.
        gap_m: Initial gap.
        friction: Coulomb coefficient.
    """

    name: str
    side: str
    surface: Point
    normal: PlanVector
    tangent: PlanVector
    gap_m: float
    friction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry:
    """What a drawing needs.

    Attributes:
        title: Variant name.
        members: All lines with a length, and zero-length springs as points (equal ends).
        contacts: Contact pairs.
        fixed: Positions of fully or partly fixed nodes.
        deck_outline: Corners of the deck in plan, counter-clockwise.
    """

    title: str
    members: tuple[Member, ...]
    contacts: tuple[ContactPlace, ...]
    fixed: tuple[Point, ...]
    deck_outline: tuple[PlanVector, ...]


def model_geometry(variant: Variant, options: ModelOptions | None = None) -> ModelGeometry:
    """Build a variant and return its geometry.

    Raises:
        InputError: Bad bridge or variant.
    """
    with domain():
        model = build(variant, options or ModelOptions())
        return ModelGeometry(
            title=model.variant.slug,
            members=(*_elements(model), *_rigid_links()),
            contacts=contact_places(model),
            fixed=tuple(map(_place, ops.getFixedNodes())),
            # each end lists its corners along its tangent: together they go once around
            deck_outline=tuple(
                corner.plan_m for end in reversed(model.abutments) for corner in end.corners
            ),
        )


def contact_places(model: BridgeModel) -> tuple[ContactPlace, ...]:
    """Return where the contacts of a built model stand, none for a model without."""
    if model.contacts is None:
        return ()
    return tuple(
        ContactPlace(
            name=unit.name,
            side=abutment.side,
            surface=_place(unit.node_j),
            normal=(unit.normal[0], unit.normal[1]),
            tangent=(unit.tangents[0][0], unit.tangents[0][1]),
            gap_m=unit.gap_m,
            friction=unit.friction,
        )
        for abutment in model.abutments
        for index in (*abutment.wall_units, *abutment.key_units)
        for unit in (model.contacts.units[index],)
    )


def _place(node: int) -> Point:
    x, y, z = ops.nodeCoord(node)
    return float(x), float(y), float(z)


def _elements(model: BridgeModel) -> Generator[Member]:
    for group, tags in model.energy_elements.items():
        for tag in tags:
            i, j = ops.eleNodes(tag)
            yield Member(group=group, tag=tag, ends=(_place(i), _place(j)))


def _rigid_links() -> Generator[Member]:
    """Yield links from each retained node to its followers."""
    for retained in ops.getRetainedNodes() or []:
        followers = ops.getConstrainedNodes(retained) or []
        for node in [followers] if isinstance(followers, int) else followers:
            yield Member(group="rigid links", tag=0, ends=(_place(retained), _place(node)))
