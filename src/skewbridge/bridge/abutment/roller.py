"""`roller`: vertical support only, at both ends of the skewed bearing line."""

from skewbridge.bridge.abutment.parts import SideContext, SideParts
from skewbridge.bridge.abutment.supports import build_vertical_supports


def build_roller(context: SideContext) -> SideParts:
    """Create the supports of one side."""
    return SideParts(bearings=build_vertical_supports(context))
