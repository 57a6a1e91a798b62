"""Where the contacts of a model are in plan, as plain data for figures and replays."""

from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.bridge.handles import BridgeModel, PlanVector


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutCorner:
    """A corner of the deck.

    Attributes:
        side: ``left`` or ``right``.
        kind: ``acute`` or ``obtuse``.
        plan_m: Position at rest.
    """

    side: str
    kind: str
    plan_m: PlanVector

    @property
    def column(self) -> str:
        """Start of the names of its displacement columns in the histories."""
        return f"abutment_{self.side}_{self.kind}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutContact:
    """A contact unit.

    Attributes:
        name: Name of the unit.
        side: Abutment.
        is_key: Whether it stands at a shear key rather than at the backwall.
        plan_m: Position at rest.
        normal: Direction of its normal force on the deck.
        tangent: First direction of its friction force; the history has the sign of slip, the
            force on the deck the other.
        gap_m: Initial gap.
        friction: Coulomb coefficient.
    """

    name: str
    side: str
    is_key: bool
    plan_m: PlanVector
    normal: PlanVector
    tangent: PlanVector
    gap_m: float
    friction: float

    @property
    def column(self) -> str:
        """Start of the names of its columns in the histories."""
        return contact_column(self.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactLayout:
    """Deck outline and contacts of one model in plan.

    Attributes:
        corners: The four corners of the deck, in order around it.
        contacts: All contact units.
    """

    corners: tuple[LayoutCorner, ...]
    contacts: tuple[LayoutContact, ...]


def contact_column(name: str) -> str:
    """Return how the history columns of a contact start."""
    return f"contact_{name.replace(' ', '_')}"


def contact_layout(model: BridgeModel) -> ContactLayout | None:
    """Return the layout of a model with contacts, else None."""
    if model.contacts is None:
        return None
    contacts = [
        LayoutContact(
            name=unit.name,
            side=abutment.side,
            is_key=index in abutment.key_units,
            plan_m=_plan_m(unit.node_j),
            normal=(unit.normal[0], unit.normal[1]),
            tangent=(unit.tangents[0][0], unit.tangents[0][1]),
            gap_m=unit.gap_m,
            friction=unit.friction,
        )
        for abutment in model.abutments
        for index in (*abutment.wall_units, *abutment.key_units)
        for unit in (model.contacts.units[index],)
    ]
    left, right = (
        [
            LayoutCorner(side=abutment.side, kind=corner.kind, plan_m=corner.plan_m)
            for corner in sorted(abutment.corners, key=lambda corner: corner.plan_m[1])
        ]
        for abutment in model.abutments
    )
    return ContactLayout(corners=(*left, *reversed(right)), contacts=tuple(contacts))


def _plan_m(node: int) -> PlanVector:
    x, y, _ = ops.nodeCoord(node)
    return float(x), float(y)
