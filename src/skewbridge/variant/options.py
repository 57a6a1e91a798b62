"""Modelling options of a variant that are not data of the bridge: section ``model``.

Each field is a key of the configuration; every numeric one can be an axis of the grid.
"""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.files.checking import Number, Whole
from skewbridge.units import MM

Fibers = Annotated[Whole, Field(ge=1, le=200)]
# fewer than three on a circle do not resist bending alike about all axes
Wedges = Annotated[Whole, Field(ge=3, le=200)]
Penalty = Annotated[Number, Field(ge=1.0e-3, le=1.0e18)]
_Factor = Annotated[Number, Field(ge=1.0e-3, le=1.0e3)]
#: How a joint gap is meant: normal to the backwall, or along the bridge.
type GapMeasured = Literal["normal", "longitudinal"]
type FrictionAt = Literal["all", "walls", "keys"]
type HingeRule = Literal["sdc", "paulay_priestley"]
type ShearModel = Literal["sdc_expected", "sdc_nominal", "kowalsky_priestley"]


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ModelOptions:
    """Modelling options of one analysis; the defaults are those of the default study."""

    arrays: Literal["rigid", "corotational"] = Field(
        default="rigid",
        description="stiff arms from the deck end to pads, walls and keys: for small rotations "
        "(rigid), or corotational as in the paper",
    )
    column_integration: Literal["hinge_radau", "lobatto5"] = Field(
        default="hinge_radau",
        description="column plasticity: hinge_radau (hinges of the length of hinge_rule) or "
        "lobatto5 (distributed, as in the paper)",
    )
    hinge_rule: HingeRule = Field(
        default="sdc",
        description="length of the plastic hinges, unless the bridge's file gives it: 0.08 L + "
        "0.022 fye db, at least 0.044 fye db (sdc), or without this limit",
    )
    # source: Rahman & Mackie, section 4
    transverse_gap_mm: Number = Field(
        default=6.4, ge=0.0, le=1.0e5, description="gap at each exterior shear key"
    )
    gap_measured: GapMeasured = Field(
        default="normal",
        description="whether gap_mm is the opening at rest normal to the backwall, or along the "
        "bridge (the normal opening is then gap_mm times the cosine of the skew)",
    )
    cohesion_n: Number = Field(
        default=0.0,
        ge=0.0,
        le=1.0e9,
        description="cohesion of the backwall contact, total per wall, shared by its points",
    )
    backwall_points: Whole = Field(
        default=3, ge=2, le=41, description="contact points along one backwall, corners included"
    )
    normal_stiffness_n_per_m: Penalty | None = Field(
        default=None,
        description="contact penalty per wall point; null applies the rule",
    )
    tangent_stiffness_n_per_m: Penalty | None = Field(
        default=None, description="tangential penalty; null applies the rule"
    )
    normal_stiffness_factor: _Factor = Field(
        default=1.0, description="factor on the normal penalty, for studies of its effect"
    )
    tangent_stiffness_factor: _Factor = Field(
        default=1.0, description="factor on the tangential penalty, for studies of its effect"
    )
    # ASSUME a backwall and a key follow deck and soil without inertia of their own: their light
    # masses between a stiff contact and the soil would rattle at any step, with an impact force
    # v sqrt(kn m) that grows with the penalty (docs/theory/analysis.md)
    wall_mass: bool = Field(
        default=False,
        strict=True,
        description="whether backwall and key nodes have mass, as in scheme paper",
    )
    # ASSUME walls and keys radiate into the soil: 10 % of critical
    wall_dashpot_ratio: Number = Field(
        default=0.10,
        ge=0.0,
        le=1.0,
        description="damping ratio of the dashpots behind walls and keys, for their mass on soil "
        "or backbone (radiation)",
    )
    # ASSUME a pushed backwall returns slowly: this adds 0.4 % to the backbone at 76 mm, 5e6 would
    # add 7 %
    wall_restoring_n_per_m: Number = Field(
        default=3.0e5,
        ge=1.0,
        le=1.0e9,
        description="weak elastic spring that returns a pushed backwall, per wall at zero skew "
        "(reduced like the backfill)",
    )
    backfill: Literal["hyperbolic", "sdc"] = Field(
        default="hyperbolic", description="hyperbolic curve, or the bilinear one of SDC 2.0"
    )
    # ASSUME the backfill is uniform along the wall
    backfill_variation: Number = Field(
        default=0.0,
        ge=0.0,
        le=0.9,
        description="relative change of backfill strength and stiffness from the middle to the "
        "ends of a wall skewed at 60 degrees, linear in skew; 0.3 is Kaviani's",
    )
    keys: Literal["sacrificial", "monolithic"] = Field(
        default="sacrificial", description="exterior shear keys that break, or do not"
    )
    key_frame: Literal["skewed", "deck_edge"] = Field(
        default="deck_edge",
        description="normal of the keys across the deck's edge, or along the skewed abutment line "
        "(scheme paper)",
    )
    friction_at: FrictionAt = Field(
        default="all",
        description="contacts that have the friction of the variant",
    )
    # ASSUME webs and slabs bring the dead load of the deck evenly over its width onto the caps
    cap_load: Literal["spread", "middle"] = Field(
        default="spread",
        description="dead load of the deck on the cap of a bent: evenly over the deck's width, or "
        "in the middle as in spine models",
    )
    # ASSUME column bases are on rigid ground
    foundation: Literal["fixed", "springs"] = Field(
        default="fixed",
        description="column bases on rigid ground, or on the springs of the bridge's file",
    )
    embankment_mass: bool = Field(
        default=False,
        strict=True,
        description="whether the critical length of the embankment moves with the abutment "
        "(abutment model spring)",
    )
    damping_ratio: Number | None = Field(
        default=None,
        ge=1.0e-3,
        le=0.5,
        description="Rayleigh damping of deck and columns at the two periods of the bridge's file; "
        "null for the ratio of the file",
    )
    # ASSUME the pads of a deck end yield together: it turns too little for them to differ
    pads: Literal["two", "each"] = Field(
        default="two",
        description="one bearing element per pad, or two cheaper elements per deck end with the "
        "stiffness of all pads, including rotation",
    )
    # ASSUME pads do not slide on their seats
    pad_strength_factor: _Factor = Field(
        default=1.0,
        description="factor on the yield force of pads",
    )
    pad_stiffness_factor: _Factor = Field(
        default=1.0, description="factor on the shear stiffness of pads"
    )
    concrete_strength_factor: _Factor = Field(
        default=1.0,
        description="factor on the strength of column concrete; its modulus follows the root",
    )
    steel_strength_factor: _Factor = Field(
        default=1.0, description="factor on the yield strength of bars and hoops"
    )
    damping_factor: _Factor = Field(default=1.0, description="factor on the damping ratio")
    deck_mass_factor: _Factor = Field(
        default=1.0, description="factor on mass and weight of deck, diaphragms and caps"
    )
    backfill_strength_factor: _Factor = Field(
        default=1.0, description="factor on the strength of backfill and wing walls"
    )
    backfill_stiffness_factor: _Factor = Field(
        default=1.0, description="factor on the stiffness of backfill and wing walls"
    )
    key_strength_factor: _Factor = Field(
        default=1.0, description="factor on the forces of shear keys"
    )
    gap_offset_mm: Number = Field(
        default=0.0,
        ge=-1.0e3,
        le=1.0e3,
        description="opening of the joints at rest minus that of the variant; none opens below 0",
    )
    # ASSUME a core whose hoops have broken keeps 0.2 of its strength, bars that broke carry nothing
    fiber_end: Literal["loss", "none"] = Field(
        default="loss",
        description="column fibers at the ultimate strain: the core drops to 0.2 of its strength "
        "and bars break or buckle (loss), or nothing changes (none)",
    )
    shear_failure: Literal["flag", "degrade"] = Field(
        default="flag",
        description="column at its shear capacity: recorded in beyond_model (flag), or with a "
        "softening section at the top (degrade)",
    )
    column_fibers: tuple[Fibers, Wedges, Fibers] = Field(
        default=(5, 20, 1),
        description="rings of the core, wedges of its outer ring, rings of the cover; bars are "
        "lumped into as many fibers as wedges",
    )
    deck_elements_per_span: Whole = Field(
        default=4, ge=1, le=64, description="elastic elements per span"
    )
    shear_model: ShearModel = Field(
        default="sdc_expected",
        description="shear capacity in column_shear_dcr: Caltrans criteria with expected or "
        "nominal materials (displacement ductility), or Kowalsky and Priestley (expected "
        "materials, curvature ductility)",
    )
    elastic_columns: bool = Field(
        default=False,
        strict=True,
        description="cracked elastic columns, for hand checks and modal comparisons",
    )
    # Prediction is better where steps resolve the contact, as the steps in contact do: at most
    # 2.4 % of the friction work is above the limit; with `lagged` it is 5 to 11 % at walls
    # (docs/theory/analysis.md).
    coupling: Literal["lagged", "extrapolated"] = Field(
        default="extrapolated",
        description="friction bound of a step from the last committed normal force (as in the "
        "paper), or from the one predicted at its end",
    )

    def has_friction_at(self, place: Literal["walls", "keys"]) -> bool:
        """Whether the contacts of a place have the variant's friction."""
        return self.friction_at in ("all", place)

    @property
    def transverse_gap_m(self) -> float:
        """Gap at each exterior shear key."""
        return self.transverse_gap_mm * MM
