"""The options that name one variant on the command line."""

from typing import Annotated

import typer

from skewbridge.errors import InputError
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.variant import Variant

BridgeOption = Annotated[str, typer.Option("--bridge", help="Name in the catalogue, e.g. osb1.")]
AbutmentOption = Annotated[
    str,
    typer.Option("--abutment", help=f"One of {', '.join(ABUTMENTS).replace('_', '-')}."),
]
SkewOption = Annotated[int, typer.Option("--skew-deg", help="Whole degrees, -60 to 60.")]
GapOption = Annotated[int, typer.Option("--gap-mm", help="Longitudinal gap, whole millimetres.")]
FrictionOption = Annotated[
    float, typer.Option("--friction", help="Coulomb coefficient, in hundredths.")
]

HUNDREDTHS = 100
_ROUNDING = 1e-9


def variant_of(bridge: str, abutment: str, skew_deg: int, gap_mm: int, friction: float) -> Variant:
    """Return the variant that the options name.

    Raises:
        InputError: A value is outside its limits, or the friction is not in whole hundredths.
    """
    hundredths = friction * HUNDREDTHS
    if not abs(hundredths - round(hundredths)) < _ROUNDING * HUNDREDTHS:
        raise InputError(f"friction must be in whole hundredths, got {friction}")
    return Variant(
        bridge=bridge,
        abutment=abutment.replace("-", "_"),
        skew_deg=skew_deg,
        gap_mm=gap_mm,
        friction_pct=round(hundredths),
    )
