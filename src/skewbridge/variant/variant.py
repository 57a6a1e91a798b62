"""One bridge of the grid and its integer-coded name."""

import re
from dataclasses import dataclass, replace
from typing import Final

from skewbridge.errors import InputError
from skewbridge.variant.abutments import ABUTMENTS, AbutmentTraits

MAX_SKEW_DEG: Final = 60
MAX_GAP_MM: Final = 999
MAX_FRICTION_PCT: Final = 150

_NAMES: Final = {traits.code: name for name, traits in ABUTMENTS.items()}
_SLUG = re.compile(
    rf"(?P<bridge>[a-z][a-z0-9_]*)_(?P<code>{'|'.join(_NAMES)})"
    r"_skew(?P<skew>m?\d{2})_gap(?P<gap>\d{3})_mu(?P<mu>\d{3})"
)


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Variant:
    """One bridge of the grid, in whole numbers so that names and keys never depend on floats.

    Attributes:
        bridge: Name of a catalogue entry, for example ``osb1``.
        abutment: Abutment model, a name in `skewbridge.variant.abutments`.
        skew_deg: Skew of the abutment line from the transverse axis, whole degrees, -60 to 60.
        gap_mm: Initial longitudinal joint gap, whole millimetres.
        friction_pct: Coulomb coefficient at the contacts, whole hundredths.

    Raises:
        InputError: A value is outside its limits.
    """

    bridge: str
    abutment: str
    skew_deg: int
    gap_mm: int
    friction_pct: int

    def __post_init__(self) -> None:
        if self.abutment not in ABUTMENTS:
            raise InputError(
                f"abutment must be one of {', '.join(ABUTMENTS)}, got {self.abutment!r}"
            )
        for field, value, low, high in (
            ("skew_deg", self.skew_deg, -MAX_SKEW_DEG, MAX_SKEW_DEG),
            ("gap_mm", self.gap_mm, 0, MAX_GAP_MM),
            ("friction (hundredths)", self.friction_pct, 0, MAX_FRICTION_PCT),
        ):
            if not low <= value <= high:
                raise InputError(f"{field} must be within {low}..{high}, got {value}")

    @property
    def friction(self) -> float:
        """Coulomb coefficient."""
        return self.friction_pct / 100

    @property
    def traits(self) -> AbutmentTraits:
        """Traits of the abutment model."""
        return ABUTMENTS[self.abutment]

    @property
    def slug(self) -> str:
        """Name of the variant, for example ``osb1_cf_skew30_gap051_mu050``."""
        skew = f"{'m' if self.skew_deg < 0 else ''}{abs(self.skew_deg):02d}"
        place = f"{self.bridge}_{self.traits.code}_skew{skew}"
        return f"{place}_gap{self.gap_mm:03d}_mu{self.friction_pct:03d}"

    def normalised(self) -> "Variant":
        """Return the variant with the axes set to zero that its abutment model does not have."""
        return replace(
            self,
            gap_mm=self.gap_mm if "gap_mm" in self.traits.axes else 0,
            friction_pct=self.friction_pct if self.traits.has_friction else 0,
        )


def parse_slug(slug: str) -> Variant:
    """Return the variant that a slug names.

    Raises:
        InputError: The text is not a slug.
    """
    match = _SLUG.fullmatch(slug)
    if match is None:
        raise InputError(
            f"not a variant name: {slug!r} (expected e.g. osb1_cf_skew30_gap051_mu050)"
        )
    return Variant(
        bridge=match["bridge"],
        abutment=_NAMES[match["code"]],
        skew_deg=int(match["skew"].replace("m", "-")),
        gap_mm=int(match["gap"]),
        friction_pct=int(match["mu"]),
    )
