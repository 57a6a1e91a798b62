"""Variants of bridges for the tests of the model."""

from skewbridge.variant.variant import Variant


def variant(
    skew_deg: int = 30, abutment: str = "contact_friction", bridge: str = "osb1"
) -> Variant:
    """Return a variant with a gap of 51 mm and friction 0.5."""
    return Variant(bridge=bridge, abutment=abutment, skew_deg=skew_deg, gap_mm=51, friction_pct=50)
