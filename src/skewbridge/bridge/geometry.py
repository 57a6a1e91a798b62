"""Geometry of a built model as plain data, for drawings."""

from collections.abc import Iterator
from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.handles import CornerHandle
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.plan import PlanVector, Position
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """Line between two points (m) of the model at rest, with its group in the energy balance."""

    group: str
    tag: int
    ends: tuple[Position, Position]


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactPlace:
    """Position and law of a contact unit."""

    name: str
    side: str
    surface: Position  # position of both nodes of the pair at rest, in m; it does not show the gap
    #: outward normal of the surface (direction of its force on the deck), in plan
    normal: PlanVector
    #: first direction of slip; the friction force on the deck is opposite to the slip
    tangent: PlanVector
    gap_m: float
    friction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry:
    """Geometry of a variant, for drawings."""

    title: str
    members: tuple[Member, ...]  # all elements as lines; zero-length springs have equal ends
    contacts: tuple[ContactPlace, ...]
    fixed: tuple[Position, ...]  # positions of fully or partly fixed nodes
    corners: tuple[CornerHandle, ...]  # deck corners, counter-clockwise

    @property
    def deck_outline(self) -> list[PlanVector]:
        """Corners of the deck in plan, counter-clockwise."""
        return [corner.plan_m for corner in self.corners]


def model_geometry(variant: Variant, options: ModelOptions) -> ModelGeometry:
    """Build a variant and return its geometry."""
    with domain():
        return geometry_of(build(variant, options))


def geometry_of(model: BridgeModel) -> ModelGeometry:
    """Return the geometry of a built model at rest."""
    units = model.contacts.units if model.contacts else ()
    return ModelGeometry(
        title=model.variant.slug,
        members=tuple(
            Member(group=group, tag=tag, ends=(_place(i), _place(j)))
            for group, tags in model.energy_elements.items()
            for tag in tags
            for i, j in (ops.eleNodes(tag),)
        ),
        contacts=tuple(
            ContactPlace(
                name=unit.name,
                side=side,
                surface=_place(unit.node_j),
                normal=(unit.normal[0], unit.normal[1]),
                tangent=(unit.tangents[0][0], unit.tangents[0][1]),
                gap_m=unit.gap_m,
                friction=unit.friction,
            )
            for side, indices in _contacts_by_side(model)
            for unit in (units[index] for index in indices)
        ),
        fixed=tuple(map(_place, ops.getFixedNodes())),
        # each end lists its corners along its tangent: right, then left is counter-clockwise
        corners=tuple(corner for end in reversed(model.abutments) for corner in end.corners),
    )


def _contacts_by_side(model: BridgeModel) -> Iterator[tuple[str, tuple[int, ...]]]:
    for end in model.abutments:
        yield end.side, (*end.wall_units, *end.key_units)
    for joint in model.joints:
        yield joint.name, joint.units


def contact_column(name: str) -> str:
    """Return the prefix of the history columns of a contact."""
    return f"contact_{name.replace(' ', '_')}"


def _place(node: int) -> Position:
    x, y, z = ops.nodeCoord(node)
    return float(x), float(y), float(z)
