"""Geometry of a built model as plain data, for drawings and replays."""

from collections.abc import Generator
from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.handles import BridgeModel, PlanVector
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

type Position = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A line between two points at rest in m, in a group of the energy balance."""

    group: str
    tag: int
    ends: tuple[Position, Position]


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactPlace:
    """Position and law of a contact unit.

    Attributes:
        surface: Position of the pair on the closed line at rest, in m.
        normal: Outward normal of the surface (direction of its force on the deck), in plan.
        tangent: First direction of its friction force; the force on the deck has the other sign.
    """

    name: str
    side: str
    surface: Position
    normal: PlanVector
    tangent: PlanVector
    gap_m: float
    friction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry:
    """Geometry of a variant, for drawings.

    Attributes:
        members: All lines with a length, and zero-length springs as points (equal ends).
        fixed: Positions of fully or partly fixed nodes.
        deck_outline: Corners of the deck in plan, counter-clockwise.
    """

    title: str
    members: tuple[Member, ...]
    contacts: tuple[ContactPlace, ...]
    fixed: tuple[Position, ...]
    deck_outline: tuple[PlanVector, ...]


def model_geometry(variant: Variant, options: ModelOptions | None = None) -> ModelGeometry:
    """Build a variant and return its geometry."""
    with domain():
        model = build(variant, options or ModelOptions())
        return ModelGeometry(
            title=model.variant.slug,
            members=tuple(_elements(model)),
            contacts=contact_places(model),
            fixed=tuple(map(_place, ops.getFixedNodes())),
            # each end lists its corners along its tangent: together they go once around
            deck_outline=tuple(
                corner.plan_m for end in reversed(model.abutments) for corner in end.corners
            ),
        )


def contact_places(model: BridgeModel) -> tuple[ContactPlace, ...]:
    """Return the places of the contacts of a built model; empty without contacts."""
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


def _place(node: int) -> Position:
    x, y, z = ops.nodeCoord(node)
    return float(x), float(y), float(z)


def _elements(model: BridgeModel) -> Generator[Member]:
    for group, tags in model.energy_elements.items():
        for tag in tags:
            i, j = ops.eleNodes(tag)
            yield Member(group=group, tag=tag, ends=(_place(i), _place(j)))


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutCorner:
    """A corner of the deck: ``left`` or ``right``, ``acute`` or ``obtuse``, position at rest."""

    side: str
    kind: str
    plan_m: PlanVector

    @property
    def column(self) -> str:
        """Start of the names of its displacement columns in the histories."""
        return f"abutment_{self.side}_{self.kind}"


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactLayout:
    """Deck corners in order around it, and contacts; `contact_column` starts their columns."""

    corners: tuple[LayoutCorner, ...]
    contacts: tuple[ContactPlace, ...]


def contact_column(name: str) -> str:
    """Return the start of the names of the history columns of a contact."""
    return f"contact_{name.replace(' ', '_')}"


def contact_layout(model: BridgeModel) -> ContactLayout | None:
    """Return the layout of a model, None for a model without contacts."""
    if model.contacts is None:
        return None
    left, right = (
        [
            LayoutCorner(side=abutment.side, kind=corner.kind, plan_m=corner.plan_m)
            for corner in sorted(abutment.corners, key=lambda corner: corner.plan_m[1])
        ]
        for abutment in model.abutments
    )
    return ContactLayout(corners=(*left, *reversed(right)), contacts=contact_places(model))
