"""The abutment models as data: one row of traits each.

A new model needs a row here, a builder in `skewbridge.bridge.abutment`, and its line in the table
of builders there.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentTraits:
    """Facts about an abutment model that the rest of the package uses.

    Attributes:
        code: Two letters in the names of variants.
        description: Continuation of "the abutments are modelled".
        axes: Axes of the model in addition to skew, by their names in `skewbridge.variant.axes`;
            the others count as zero.
        backfill: Curve of the backfill: that of the ``option`` backfill, always ``sdc``, or
            ``none``.
        without_friction: Model with the same equations but without friction, or empty.
        has_pads: Whether elastomeric pads carry the deck end, rather than plain vertical supports.
        has_wall_points: Whether soil or contacts are at points along the whole backwall, rather
            than only at the deck corners.
        has_contacts: Whether deck, backwall and keys meet in contact units.
        has_body: Whether the keys are on a body, which may carry the mass of the embankment.
    """

    code: str
    description: str
    axes: frozenset[str] = frozenset()
    backfill: Literal["option", "sdc", "none"] = "option"
    without_friction: str = ""
    has_pads: bool = False
    has_wall_points: bool = False
    has_contacts: bool = False
    has_body: bool = False

    @property
    def has_friction(self) -> bool:
        """Whether the contacts carry friction."""
        return "friction" in self.axes


def lacking_axes(abutment: str) -> frozenset[str]:
    """Return the axes of other abutment models that one lacks; none for a foreign model."""
    axes = frozenset[str]().union(*(traits.axes for traits in ABUTMENTS.values()))
    return axes - ABUTMENTS[abutment].axes if abutment in ABUTMENTS else frozenset()


#: From the simplest to the most complete.
ABUTMENTS: Final[Mapping[str, AbutmentTraits]] = {
    "roller": AbutmentTraits(code="ro", description="on rollers", backfill="none"),
    "simplified": AbutmentTraits(
        code="si",
        description="as one bilinear spring with a gap at each corner of the deck",
        axes=frozenset({"gap_mm"}),
        backfill="sdc",
    ),
    "spring": AbutmentTraits(
        code="sp",
        description="as elastomeric pads, backfill springs behind the joint gap and exterior "
        "shear keys, without contact",
        axes=frozenset({"gap_mm"}),
        has_pads=True,
        has_wall_points=True,
        has_body=True,
    ),
    "contact": AbutmentTraits(
        code="co",
        description="as elastomeric pads, backfill and exterior shear keys that the deck "
        "meets in frictionless contact",
        axes=frozenset({"gap_mm"}),
        has_pads=True,
        has_wall_points=True,
        has_contacts=True,
    ),
    "contact_friction": AbutmentTraits(
        code="cf",
        description="as elastomeric pads, backfill and exterior shear keys that the deck "
        "meets in contact with Coulomb friction",
        axes=frozenset({"gap_mm", "friction"}),
        without_friction="contact",
        has_pads=True,
        has_wall_points=True,
        has_contacts=True,
    ),
}
