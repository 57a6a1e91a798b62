"""Seat abutments: the builder of each model in `skewbridge.variant.variant`."""

from collections.abc import Callable, Mapping
from typing import Final

from skewbridge.bridge.abutment.contact import build_contact
from skewbridge.bridge.abutment.parts import SideContext, SideParts
from skewbridge.bridge.abutment.springs import build_roller, build_simplified, build_spring

BUILDERS: Final[Mapping[str, Callable[[SideContext], SideParts]]] = {
    "roller": build_roller,
    "simplified": build_simplified,
    "spring": build_spring,
    "contact": build_contact,
    "contact_friction": build_contact,
}
