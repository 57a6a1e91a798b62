"""Deck corners and contacts of a model in plan, as plain data for replays of its histories."""

from dataclasses import dataclass

from skewbridge.bridge.geometry import ContactPlace, contact_places
from skewbridge.bridge.handles import BridgeModel, PlanVector


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
    """Deck outline and contacts of one model.

    Attributes:
        corners: The four corners of the deck, in order around it.
        contacts: All contact units; `contact_column` gives the start of their history columns.
    """

    corners: tuple[LayoutCorner, ...]
    contacts: tuple[ContactPlace, ...]


def contact_column(name: str) -> str:
    """Return how the history columns of a contact start."""
    return f"contact_{name.replace(' ', '_')}"


def contact_layout(model: BridgeModel) -> ContactLayout | None:
    """Return the layout of a model with contacts, else None."""
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
