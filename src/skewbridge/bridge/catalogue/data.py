"""The typed form of a bridge: pydantic models at this edge, frozen afterwards.

Fields carry the engineers' units of the YAML files in their names; `skewbridge.bridge` converts
them where they enter the model.
"""

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, model_validator

type Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
type NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
type Ratio = Annotated[float, Field(gt=0.0, le=1.0)]


class _Part(BaseModel, frozen=True, extra="forbid"):
    """Frozen, and without unknown keys."""


class DeckData(_Part, frozen=True):
    """Superstructure: a prismatic spine at the centroid.

    ``inertia_vertical_m4`` bends in the vertical plane, ``inertia_transverse_m4`` in plan.
    """

    width_m: Positive
    depth_m: Positive
    area_m2: Positive
    inertia_vertical_m4: Positive
    inertia_transverse_m4: Positive
    torsion_constant_m4: Positive
    centroid_above_soffit_m: Positive
    elastic_modulus_gpa: Positive
    line_load_kn_per_m: Positive
    diaphragm_weight_kn: NotNegative
    diaphragm_thickness_m: Positive
    soffit_height_m: Positive

    @model_validator(mode="after")
    def _centroid_inside(self) -> Self:
        if self.centroid_above_soffit_m >= self.depth_m:
            raise ValueError(f"centroid_above_soffit_m must be below depth_m = {self.depth_m:g}")
        return self


class FoundationData(_Part, frozen=True):
    """Springs under every column base; rotations about the global axes."""

    kx_mn_per_m: Positive
    ky_mn_per_m: Positive
    kz_mn_per_m: Positive
    krx_mnm_per_rad: Positive
    kry_mnm_per_rad: Positive
    krz_mnm_per_rad: Positive


class BentData(_Part, frozen=True):
    """One bent: columns equally spaced about the centreline, under an integral cap."""

    columns: Annotated[int, Field(ge=1, le=8)]
    column_spacing_m: NotNegative
    clear_height_m: Positive
    cap_width_m: Positive
    cap_depth_m: Positive
    cap_weight_kn: NotNegative


class ColumnData(_Part, frozen=True):
    """The circular reinforced concrete column that all bents of a bridge share.

    ``hinge_length_m`` overrides the length of the plastic hinges of all bents, which otherwise
    follows from their height and base (`skewbridge.bridge.hinge`).
    """

    diameter_m: Positive
    cover_to_hoop_m: Positive
    bar_count: Annotated[int, Field(ge=6, le=200)]
    bar_area_mm2: Positive
    bar_diameter_mm: Positive
    hoop_area_mm2: Positive
    hoop_diameter_mm: Positive
    hoop_spacing_mm: Positive
    concrete_strength_mpa: Positive
    expected_concrete_strength_mpa: Positive
    elastic_modulus_gpa: Positive
    steel: Literal["a706", "grade40", "kaviani"]
    hoop_yield_mpa: Positive
    hinge_length_m: Positive | None = None
    cracked_stiffness_ratio: Ratio
    torsion_ratio: Ratio
    unit_weight_kn_per_m3: Positive

    @property
    def gross_area_m2(self) -> float:
        """Area of the concrete section."""
        return math.pi * self.diameter_m**2 / 4

    @property
    def hoop_circle_m(self) -> float:
        """Diameter of the hoop centre line."""
        return self.diameter_m - 2 * self.cover_to_hoop_m - 1e-3 * self.hoop_diameter_mm

    @property
    def bar_circle_m(self) -> float:
        """Diameter of the circle through the longitudinal bars."""
        return self.hoop_circle_m - 1e-3 * (self.hoop_diameter_mm + self.bar_diameter_mm)

    @model_validator(mode="after")
    def _bars_fit(self) -> Self:
        if self.bar_circle_m <= 0.0:
            raise ValueError("cover_to_hoop_m leaves no room for the bars in diameter_m")
        pitch_mm = 1e3 * math.pi * self.bar_circle_m / self.bar_count
        needed_mm = self.bar_diameter_mm + 25.0  # source: 1 in clear between bars, ACI 318 25.2.1
        if pitch_mm < needed_mm:
            limit = math.floor(1e3 * math.pi * self.bar_circle_m / needed_mm)
            raise ValueError(
                f"bar_count {self.bar_count} does not fit: at most {limit} bars on the circle"
            )
        return self


class BackfillData(_Part, frozen=True):
    """Passive resistance behind one backwall, at zero skew.

    ``rule: ucsd`` takes per metre of wall width at ``reference_height_m`` (linear in height);
    ``rule: k50`` takes totals and finds the hyperbola through the half-strength stiffness and the
    ultimate force at ``ultimate_closure_ratio`` times the wall height.
    """

    rule: Literal["ucsd", "k50"]
    stiffness_mn_per_m: Positive
    ultimate_kn: Positive
    failure_ratio: Ratio
    reference_height_m: Positive
    ultimate_closure_ratio: Positive


class PadData(_Part, frozen=True):
    """Elastomeric pads of one abutment, equally spaced across the deck."""

    count: Annotated[int, Field(ge=2, le=30)]
    spacing_m: Positive
    shear_stiffness_kn_per_m: Positive
    yield_force_kn: Positive
    hardening_ratio: Ratio
    vertical_stiffness_mn_per_m: Positive
    height_m: Positive

    def with_strength(self, factor: float) -> Self:
        """Return pads that yield at a multiple of their force."""
        return self.model_copy(update={"yield_force_kn": factor * self.yield_force_kn})


class KeyData(_Part, frozen=True):
    """Backbone of one exterior shear key, three points; the last force stays as residual."""

    displacement_mm: tuple[Positive, Positive, Positive]
    force_kn: tuple[Positive, Positive, Positive]

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        first, peak, last = self.displacement_mm
        if not first < peak < last:
            raise ValueError(f"displacement_mm must increase, got {self.displacement_mm}")
        return self


class AbutmentData(_Part, frozen=True):
    """Both abutments of a bridge."""

    wall_width_m: Positive
    wall_height_m: Positive
    wall_thickness_m: Positive
    seat_width_m: Positive
    key_mass_t: Positive
    backfill: BackfillData
    pads: PadData
    sacrificial_key: KeyData
    monolithic_key: KeyData
    wing_length_ratio: Positive
    wing_participation: Positive
    wing_effectiveness: Positive
    embankment_slope_ratio: Positive
    embankment_height_m: Positive

    @model_validator(mode="after")
    def _backfill_softens(self) -> Self:
        """Refuse a half-strength stiffness below the secant at the end: the curve would stiffen."""
        soil = self.backfill
        end_m = soil.ultimate_closure_ratio * self.wall_height_m
        least = 1e-3 * soil.ultimate_kn / end_m
        if soil.rule == "k50" and soil.stiffness_mn_per_m < least:
            raise ValueError(
                f"backfill.stiffness_mn_per_m must be at least {least:.4g} with rule k50 "
                "(ultimate_kn over ultimate_closure_ratio x wall_height_m), "
                f"got {soil.stiffness_mn_per_m:g}"
            )
        return self


class DampingData(_Part, frozen=True):
    """Rayleigh damping of deck and columns: one ratio at two periods."""

    ratio: Annotated[float, Field(gt=0.0, lt=0.5)]
    long_period_s: Positive
    short_period_s: Positive


class BridgeData(_Part, frozen=True):
    """One bridge of the catalogue.

    Attributes:
        name: File name without ending.
        title: One line for tables and figures.
        details: ``surrogate`` where deck or reinforcement are not published, else ``published``.
        t1_s: Conditioning period: geometric mean of the longitudinal and transverse periods of
            the gap-open model with pads at zero skew.
        spans_m: Lengths, left to right.
        base: Column bases, ``pinned`` (torsion fixed) or ``fixed``.
        sources: Path of every number in the file -> source class and text.
    """

    name: str
    title: str
    details: Literal["surrogate", "published"]
    t1_s: Positive
    spans_m: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=12)]
    base: Literal["pinned", "fixed"]
    deck: DeckData
    bents: tuple[BentData, ...]
    column: ColumnData
    foundation: FoundationData | None = None
    abutment: AbutmentData
    damping: DampingData
    sources: dict[str, str]

    @property
    def length_m(self) -> float:
        """Total length."""
        return math.fsum(self.spans_m)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.bents) != len(self.spans_m) - 1:
            raise ValueError(f"bents: {len(self.spans_m)} spans need {len(self.spans_m) - 1} bents")
        for number, bent in enumerate(self.bents):
            if bent.clear_height_m > self.deck.soffit_height_m:
                raise ValueError(
                    f"bents.{number}.clear_height_m {bent.clear_height_m:g} is taller than the "
                    f"deck: soffit_height_m is {self.deck.soffit_height_m:g}"
                )
            line_m = (bent.columns - 1) * bent.column_spacing_m + self.column.diameter_m
            if line_m > self.deck.width_m:
                raise ValueError(f"bents.{number}: columns span {line_m:g} m, deck width_m is less")
            if bent.columns > 1 and bent.column_spacing_m < self.column.diameter_m:
                raise ValueError(
                    f"bents.{number}.column_spacing_m must exceed the column diameter_m"
                )
            if (self.column.hinge_length_m or 0.0) > bent.clear_height_m / 2:
                raise ValueError(
                    f"column.hinge_length_m exceeds half of bents.{number}.clear_height_m"
                )
        pads = self.abutment.pads
        if (pads.count - 1) * pads.spacing_m > self.deck.width_m:
            raise ValueError("abutment.pads reach beyond deck.width_m")
        return self
