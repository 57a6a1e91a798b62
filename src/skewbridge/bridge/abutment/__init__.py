"""Seat abutments: a builder for each model of `skewbridge.variant.abutments`."""

from collections.abc import Callable, Mapping
from typing import Final

from skewbridge.bridge.abutment.contact import build_contact
from skewbridge.bridge.abutment.parts import SideContext, SideParts
from skewbridge.bridge.abutment.simplified import build_roller, build_simplified
from skewbridge.bridge.abutment.spring import build_spring

BUILDERS: Final[Mapping[str, Callable[[SideContext], SideParts]]] = {
    "roller": build_roller,
    "simplified": build_simplified,
    "spring": build_spring,
    "contact": build_contact,
    "contact_friction": build_contact,
}
