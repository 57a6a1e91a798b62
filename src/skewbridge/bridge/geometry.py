"""Geometry of a built model as plain data, for drawings."""

from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.plan import PlanVector, Position
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """Line between two points (m) of the model at rest, with its group in the energy balance."""

    group: str
    ends: tuple[Position, Position]


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactPlace:
    """Position of a contact unit."""

    surface: Position  # position of both nodes of the pair at rest, in m; it does not show the gap
    #: outward normal of the surface (direction of its force on the deck), in plan
    normal: PlanVector
    gap_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry:
    """Geometry of a variant, for drawings."""

    title: str
    members: tuple[Member, ...]  # all elements as lines; zero-length springs have equal ends
    contacts: tuple[ContactPlace, ...]
    fixed: tuple[Position, ...]  # positions of fully or partly fixed nodes
    deck_outline: list[PlanVector]  # corners of the deck in plan, counter-clockwise


def model_geometry(variant: Variant, options: ModelOptions) -> ModelGeometry:
    """Build a variant and return its geometry."""
    with domain():
        return _geometry(build(variant, options))


def _geometry(model: BridgeModel) -> ModelGeometry:
    units = model.contacts.units if model.contacts else ()
    unit_groups = [*((*end.wall_units, *end.key_units) for end in model.abutments),
            *(joint.units for joint in model.joints)]  # fmt: skip
    return ModelGeometry(
        title=model.variant.slug,
        members=tuple(
            Member(group=group, ends=(_place(i), _place(j)))
            for group, tags in model.energy_elements.items()
            for tag in tags
            for i, j in (ops.eleNodes(tag),)
        ),
        contacts=tuple(
            ContactPlace(
                surface=_place(unit.node_j),
                normal=(unit.normal[0], unit.normal[1]),
                gap_m=unit.gap_m,
            )
            for unit in (units[index] for indices in unit_groups for index in indices)
        ),
        fixed=tuple(map(_place, ops.getFixedNodes())),
        # each end lists its corners along its tangent: right, then left is counter-clockwise
        deck_outline=[corner.plan_m for end in reversed(model.abutments) for corner in end.corners],
    )


def contact_column(name: str) -> str:
    """Return the prefix of the history columns of a contact."""
    return f"contact_{name.replace(' ', '_')}"


def _place(node: int) -> Position:
    x, y, z = ops.nodeCoord(node)
    return float(x), float(y), float(z)
