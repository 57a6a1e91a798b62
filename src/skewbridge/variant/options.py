"""Modelling options of a variant that are not data of the bridge: section ``model``.

Each field is a key of the configuration; every numeric one can be an axis of the grid.
"""

from math import cos, radians
from pathlib import Path
from typing import Annotated, Final, Literal, get_args

from pydantic import Field
from pydantic.dataclasses import dataclass

from skewbridge.files.text import OPTIONS, Flag, Number, Whole, read_mapping
from skewbridge.units import MM

Fibers = Annotated[Whole, Field(ge=1, le=200)]
# fewer than three on a circle have different bending stiffness about different axes
Wedges = Annotated[Whole, Field(ge=3, le=200)]
#: Axes of every variant with their limits, keyed by name.
AXES_TABLE: Final = read_mapping(Path(__file__).with_name("axes.yaml"))
LARGEST_SKEW_DEG: Final[float] = AXES_TABLE["skew_deg"]["high"]
_Factor = Annotated[Number, Field(ge=1.0e-3, le=1.0e3)]
#: Direction of a joint gap: normal to the backwall, or along the bridge.
type GapMeasured = Literal["normal", "longitudinal"]
#: Properties of the backfill that skew reduces.
type BackfillSkew = Literal["strength", "strength_and_stiffness", "none"]
type FrictionAt = Literal["all", "walls", "keys"]
type RayleighKind = Literal["mass_and_stiffness", "stiffness"]
type HingeRule = Literal["sdc", "paulay_priestley"]
type ShearModel = Literal["ucsd_tests", "sdc_expected", "sdc_nominal", "kowalsky_priestley"]
DEFAULT_SHEAR_MODEL: Final[ShearModel] = "ucsd_tests"
#: Column of the demands table with shear / capacity, keyed by shear model.
SHEAR_MODEL_DEMANDS: Final[dict[ShearModel, str]] = {
    model: f"column_shear_dcr_{model}" for model in get_args(ShearModel.__value__)
}


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class ModelOptions:
    """Modelling options of one analysis, with the defaults of the default study."""

    arrays: Literal["rigid", "corotational"] = Field(default="rigid")
    """arms from the deck end: rigid, or corotational (paper)"""
    column_integration: Literal["hinge_radau", "lobatto5"] = Field(default="hinge_radau")
    """column plasticity: hinges (hinge_rule), or distributed (paper)"""
    hinge_rule: HingeRule = Field(default="sdc")
    """hinge length 0.08 L + 0.022 fye db (sdc: >= 0.044 fye db), unless in the bridge file"""
    # source: Rahman & Mackie, section 4
    transverse_gap_mm: Number = Field(default=6.4, ge=0.0, le=1.0e5)
    """gap at each exterior shear key"""
    gap_measured: GapMeasured = Field(default="normal")
    """gap_mm normal to the backwall, or along the bridge"""
    cohesion_n: Number = Field(default=0.0, ge=0.0, le=1.0e9)
    """cohesion of a backwall"""
    # two points at the corners have three times the rotational stiffness of the wall
    backwall_points: Whole = Field(default=3, ge=3, le=41)
    """contact points of a backwall, corners included"""
    normal_stiffness_factor: _Factor = Field(default=1.0)
    """factor on the normal penalty"""
    tangent_stiffness_factor: _Factor = Field(default=1.0)
    """factor on the tangential penalty"""
    # ASSUME backwalls and keys have no inertia: their light masses between a stiff contact and the
    # soil would rattle at any time step, with an impact force v sqrt(kn m) that grows with the
    # penalty (docs/theory/analysis.md)
    wall_mass: Flag = Field(default=False)
    """include the mass of walls and keys (scheme paper)"""
    # ASSUME compacted backfill softened by strong shaking: 100 to 200 m/s
    backfill_vs_mps: Number | None = Field(default=150.0, ge=0.0, le=2.0e3)
    """shear wave velocity for radiation at walls; null (scheme paper): 10 % of critical"""
    # source: Wang et al. (1998), Earthquake Spectra 14(2); Boulanger et al. (1999), J. Geotech.
    # Geoenviron. Eng. 125(9): radiation damping parallel to the elastic part of p-y springs
    backfill_dashpot: Literal["series", "parallel"] = Field(default="series")
    """wall dashpot in series with the plastic backfill, or parallel to it (paper)"""
    # ASSUME a pushed backwall returns slowly: this adds 0.04 % to the backbone at 76 mm, 5e6 would
    # add 7 %
    wall_restoring_n_per_m: Number = Field(default=3.0e4, ge=1.0, le=1.0e9)
    """spring returning a pushed backwall, at zero skew"""
    backfill: Literal["hyperbolic", "sdc"] = Field(default="hyperbolic")
    """hyperbolic curve, or bilinear curve of SDC 2.0"""
    backfill_skew: BackfillSkew = Field(default="strength")
    """skew reduces the strength of the backfill, also its stiffness (scheme paper), or neither"""
    backfill_height_exponent: Number = Field(default=1.5, ge=1.0, le=2.0)
    """power of the wall height in the strength of UCSD backfill (scheme paper: 1)"""
    # ASSUME the backfill is uniform along the wall
    backfill_variation: Number = Field(default=0.0, ge=0.0, le=0.9)
    """relative change of backfill from middle to wall ends at skew 60 (Kaviani: 0.3)"""
    keys: Literal["sacrificial", "monolithic"] = Field(default="sacrificial")
    """backbone of the exterior shear keys"""
    key_frame: Literal["skewed", "deck_edge"] = Field(default="deck_edge")
    """normal of the keys: along the abutment line (scheme paper), or across the deck's edge"""
    key_along_face: Literal["backbone", "elastic"] = Field(default="backbone")
    """force of keys along their face: limited by strength, or elastic (scheme paper)"""
    friction_at: FrictionAt = Field(default="all")
    """contacts with friction"""
    # source: PyPBEE 8fed5bb, modelInputParameters.tcl: bents of bridges A to C are parallel to the
    # abutments, their columns keep the transverse spacing
    bent_skew: Literal["abutment", "square"] = Field(default="abutment")
    """bents: parallel to the abutments, or square to the deck"""
    bent_skew_deg: Number | None = Field(default=None, ge=-LARGEST_SKEW_DEG, le=LARGEST_SKEW_DEG)
    """skew of all bents; null: set by bent_skew"""
    # ASSUME the columns of a skewed bent stay under the same girders
    column_spacing: Literal["normal", "along_bent"] = Field(default="normal")
    """column spacing normal to the deck's axis, or along a skewed bent"""
    # ASSUME webs and slabs spread the dead load of the deck evenly over the width of the caps
    cap_load: Literal["spread", "middle"] = Field(default="spread")
    """dead load of the deck on a cap: over its width, or in the middle"""
    foundation: Literal["springs", "fixed"] = Field(default="springs")
    """column bases on springs of the bridge file, or rigid"""
    embankment_mass: Flag = Field(default=False)
    """embankment mass over its critical length moves with the abutment (model spring)"""
    rayleigh: RayleighKind = Field(default="mass_and_stiffness")
    """Rayleigh damping of deck and columns; support motions always use stiffness"""
    # ASSUME the pads of a deck end yield together: it rotates too little for them to differ
    pads: Literal["two", "each"] = Field(default="two")
    """two equivalent elements per deck end, or one per pad"""
    # ASSUME pads do not slide on their seats
    pad_strength_factor: _Factor = Field(default=1.0)
    """factor on the yield force of pads"""
    pad_stiffness_factor: _Factor = Field(default=1.0)
    """factor on the shear stiffness of pads"""
    concrete_strength_factor: _Factor = Field(default=1.0)
    """factor on the strength of column concrete (modulus: its root)"""
    steel_strength_factor: _Factor = Field(default=1.0)
    """factor on the yield strength of bars and hoops"""
    damping_factor: _Factor = Field(default=1.0)
    """factor on the damping ratio of the bridge file"""
    deck_mass_factor: _Factor = Field(default=1.0)
    """factor on mass and weight of the deck"""
    backfill_strength_factor: _Factor = Field(default=1.0)
    """factor on the strength of backfill and wing walls"""
    backfill_stiffness_factor: _Factor = Field(default=1.0)
    """factor on the stiffness of backfill and wing walls"""
    key_strength_factor: _Factor = Field(default=1.0)
    """factor on the forces of shear keys"""
    gap_offset_mm: Number = Field(default=0.0, ge=-1.0e3, le=1.0e3)
    """added to the gap of the variant; the sum is at least 0"""
    # ASSUME a core whose hoops have broken keeps 0.2 of its strength, bars that broke carry nothing
    fiber_end: Literal["loss", "none"] = Field(default="loss")
    """column fibers at their ultimate strain: lose strength, or not"""
    shear_failure: Literal["flag", "degrade"] = Field(default="flag")
    """column at its shear capacity: recorded in beyond_model, or loses strength"""
    column_fibers: tuple[Fibers, Wedges, Fibers] = Field(default=(5, 20, 1))
    """rings of the core, wedges (and bars), rings of the cover"""
    deck_elements_per_span: Whole = Field(default=4, ge=1, le=64)
    """elastic elements per span"""
    shear_model: ShearModel = Field(default=DEFAULT_SHEAR_MODEL)
    """shear capacity: UCSD model with the mean of tests, Caltrans (design), or UCSD (2000)"""
    elastic_columns: Flag = Field(default=False)
    """cracked elastic columns, for hand checks"""
    # Prediction is better if the steps resolve the contact, as the steps in contact do: at most
    # 2.5 % of the friction work is above the limit; with `lagged` it is 5 to 11 % at walls
    # (docs/theory/analysis.md).
    coupling: Literal["lagged", "extrapolated"] = Field(default="extrapolated")
    """friction bound from the last (paper) or the predicted normal force"""

    @property
    def transverse_gap_m(self) -> float:
        """Gap at each exterior shear key."""
        return self.transverse_gap_mm * MM

    def normal_gap_m(self, gap_mm: float, skew_deg: float) -> float:
        """Return the opening of a joint at rest normal to its faces, including the offset."""
        cosine = cos(radians(skew_deg)) if self.gap_measured == "longitudinal" else 1.0
        return max(gap_mm * MM * cosine + self.gap_offset_mm * MM, 0.0)

    def skew_of_bents_deg(self, skew_deg: float) -> float:
        """Return the skew of the bents in degrees for a skew of the abutments."""
        if self.bent_skew_deg is not None:
            return self.bent_skew_deg
        return skew_deg if self.bent_skew == "abutment" else 0.0
