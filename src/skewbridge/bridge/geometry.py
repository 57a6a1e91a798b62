"""Geometry of a built model as plain data, for drawings and replays."""

from collections.abc import Generator
from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.handles import BridgeModel, CornerHandle, PlanVector
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
class ContactLayout:
    """Deck corners counter-clockwise around it, and contacts (none without contact units)."""

    corners: tuple[CornerHandle, ...]
    contacts: tuple[ContactPlace, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry(ContactLayout):
    """Geometry of a variant, for drawings.

    Attributes:
        members: All lines with a length, and zero-length springs as points (equal ends).
        fixed: Positions of fully or partly fixed nodes.
    """

    title: str
    members: tuple[Member, ...]
    fixed: tuple[Position, ...]

    @property
    def deck_outline(self) -> list[PlanVector]:
        """Corners of the deck in plan, counter-clockwise."""
        return [corner.plan_m for corner in self.corners]


def model_geometry(variant: Variant, options: ModelOptions | None = None) -> ModelGeometry:
    """Build a variant and return its geometry."""
    with domain():
        model = build(variant, options or ModelOptions())
        layout = contact_layout(model)
        return ModelGeometry(
            title=model.variant.slug,
            members=tuple(_members(model)),
            fixed=tuple(map(_place, ops.getFixedNodes())),
            corners=layout.corners,
            contacts=layout.contacts,
        )


def contact_layout(model: BridgeModel) -> ContactLayout:
    """Return corners and contacts of a built model."""
    units = model.contacts.units if model.contacts else ()
    return ContactLayout(
        # each end lists its corners along its tangent: together they go once around
        corners=tuple(corner for end in reversed(model.abutments) for corner in end.corners),
        contacts=tuple(
            ContactPlace(
                name=units[index].name,
                side=abutment.side,
                surface=_place(units[index].node_j),
                normal=(units[index].normal[0], units[index].normal[1]),
                tangent=(units[index].tangents[0][0], units[index].tangents[0][1]),
                gap_m=units[index].gap_m,
                friction=units[index].friction,
            )
            for abutment in model.abutments
            for index in (*abutment.wall_units, *abutment.key_units)
        ),
    )


def contact_column(name: str) -> str:
    """Return the start of the names of the history columns of a contact."""
    return f"contact_{name.replace(' ', '_')}"


def _place(node: int) -> Position:
    x, y, z = ops.nodeCoord(node)
    return float(x), float(y), float(z)


def _members(model: BridgeModel) -> Generator[Member]:
    for group, tags in model.energy_elements.items():
        for tag in tags:
            i, j = ops.eleNodes(tag)
            yield Member(group=group, tag=tag, ends=(_place(i), _place(j)))
