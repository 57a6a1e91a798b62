"""Typed data of a bridge, as frozen pydantic models.

The names of fields include the units of the YAML files; `skewbridge.bridge` converts them to SI
when it builds the model.
"""

import math
from itertools import accumulate
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from skewbridge.bridge.catalogue.columns import AnyColumn, ColumnData, over_default
from skewbridge.bridge.catalogue.quantities import (
    Distance,
    Factor,
    Gigapascals,
    Inertia,
    Kilonewtons,
    LineLoad,
    Metres,
    Millimetres,
    Part,
    Ratio,
    Seconds,
    Span,
    SquareMetres,
    Stiffness,
    Tonnes,
    Weight,
)

type Base = Literal["pinned", "fixed"]


class DeckData(Part, frozen=True):
    """Superstructure: a prismatic spine at the centroid.

    ``inertia_vertical_m4`` is for vertical bending, ``inertia_transverse_m4`` for bending in plan.
    """

    width_m: Metres
    depth_m: Metres
    area_m2: SquareMetres
    inertia_vertical_m4: Inertia
    inertia_transverse_m4: Inertia
    torsion_constant_m4: Inertia
    centroid_above_soffit_m: Metres
    elastic_modulus_gpa: Gigapascals
    line_load_kn_per_m: LineLoad
    diaphragm_weight_kn: Weight
    diaphragm_thickness_m: Metres
    soffit_height_m: Metres

    @model_validator(mode="after")
    def _centroid_inside(self) -> Self:
        if self.centroid_above_soffit_m >= self.depth_m:
            raise ValueError(f"centroid_above_soffit_m must be below depth_m = {self.depth_m:g}")
        return self


class FoundationData(Part, frozen=True):
    """Springs under every column base; rotational springs act about the global axes."""

    kx_mn_per_m: Stiffness
    ky_mn_per_m: Stiffness
    kz_mn_per_m: Stiffness
    krx_mnm_per_rad: Stiffness
    kry_mnm_per_rad: Stiffness
    krz_mnm_per_rad: Stiffness


class BentData(Part, frozen=True):
    """One bent: columns equally spaced about the centreline, under an integral cap.

    A bent of one column needs no ``column_spacing_m``. ``column`` and ``base`` are those of the
    bridge if None; in the file, keys of ``column`` replace single keys of the bridge's column.
    """

    columns: Annotated[int, Field(ge=1, le=8)]
    column_spacing_m: Distance = 0.0
    clear_height_m: Metres
    cap_width_m: Metres
    cap_depth_m: Metres
    cap_weight_kn: Weight
    column: AnyColumn | None = None
    base: Base | None = None

    @model_validator(mode="after")
    def _spaced(self) -> Self:
        if self.columns > 1 and self.column_spacing_m == 0.0:
            raise ValueError(f"column_spacing_m is missing or 0: {self.columns} columns need it")
        return self


class BackfillData(Part, frozen=True):
    """Passive resistance behind one backwall, at zero skew.

    With ``rule: ucsd`` the values are per metre of wall at ``reference_height_m``; stiffness is
    proportional to height. With ``rule: k50`` they are totals of a wall: the hyperbola has this
    secant stiffness at half strength, and ends at ``ultimate_closure_ratio`` times wall height.
    """

    rule: Literal["ucsd", "k50"]
    stiffness_mn_per_m: Stiffness
    ultimate_kn: Kilonewtons
    failure_ratio: Ratio
    reference_height_m: Metres
    ultimate_closure_ratio: Factor


class PadData(Part, frozen=True):
    """Elastomeric pads of one abutment, equally spaced across the deck."""

    count: Annotated[int, Field(ge=2, le=30)]
    spacing_m: Metres
    shear_stiffness_kn_per_m: Stiffness
    yield_force_kn: Kilonewtons
    hardening_ratio: Annotated[float, Field(ge=1.0e-4, le=0.9)]
    vertical_stiffness_mn_per_m: Stiffness
    height_m: Metres


class KeyData(Part, frozen=True):
    """Backbone of one exterior shear key at three points; the last force is residual strength."""

    displacement_mm: tuple[Millimetres, Millimetres, Millimetres]
    force_kn: tuple[Kilonewtons, Kilonewtons, Kilonewtons]

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        first, peak, last = self.displacement_mm
        if not first < peak < last:
            raise ValueError(f"displacement_mm must increase, got {self.displacement_mm}")
        return self


class AbutmentData(Part, frozen=True):
    """Data of an abutment, the same at both ends of a bridge."""

    wall_width_m: Metres
    wall_height_m: Metres
    wall_thickness_m: Metres
    seat_width_m: Metres
    key_mass_t: Tonnes
    backfill: BackfillData
    pads: PadData
    sacrificial_key: KeyData
    monolithic_key: KeyData
    wing_length_ratio: Factor
    wing_participation: Factor
    wing_effectiveness: Factor
    embankment_slope_ratio: Factor
    embankment_height_m: Metres

    @model_validator(mode="after")
    def _backfill_softens(self) -> Self:
        """Reject a secant stiffness that is smaller at half strength than at the end."""
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


class DampingData(Part, frozen=True):
    """Rayleigh damping of deck and columns: one ratio at two periods."""

    ratio: Annotated[float, Field(gt=0.0, lt=0.5)]
    long_period_s: Seconds
    short_period_s: Seconds


class BridgeData(Part, frozen=True):
    """One bridge of the catalogue.

    Attributes:
        details: ``surrogate`` if deck or reinforcement are not published, else ``published``.
        t1_s: Conditioning period: geometric mean of the longitudinal and transverse periods of
            the gap-open model with pads at zero skew.
        base: Column bases, ``pinned`` (torsion fixed) or ``fixed``, unless a bent has its own.
        column: Column of all bents that have none of their own.
        foundation: Springs under the bases; None is rigid ground.
        sources: Source class and text of every number, keyed by the path of the number in the file.
    """

    name: str
    title: Annotated[str, Field(min_length=1, max_length=200)]
    details: Literal["surrogate", "published"]
    t1_s: Seconds
    spans_m: Annotated[tuple[Span, ...], Field(min_length=1, max_length=12)]
    base: Base
    deck: DeckData
    bents: tuple[BentData, ...]
    column: AnyColumn
    foundation: FoundationData | None = None
    abutment: AbutmentData
    damping: DampingData
    sources: dict[str, str]

    @property
    def length_m(self) -> float:
        """Total length."""
        return math.fsum(self.spans_m)

    @property
    def bent_positions_m(self) -> list[float]:
        """Positions of the bents along x, origin at the middle of the deck."""
        return list(accumulate(self.spans_m[:-1], initial=-self.length_m / 2))[1:]

    def column_of(self, bent: BentData) -> ColumnData:
        """Return the column of a bent."""
        return bent.column or self.column

    def base_of(self, bent: BentData) -> Base:
        """Return the base of the columns of a bent."""
        return bent.base or self.base

    @property
    def bases(self) -> str:
        """Bases of all bents in words."""
        return " and ".join(sorted({self.base_of(bent) for bent in self.bents} or {self.base}))

    @model_validator(mode="before")
    @classmethod
    def _columns_of_bents(cls, raw: Any) -> Any:
        """Complete the column of a bent from that of the bridge."""
        bents = raw.get("bents") if isinstance(raw, dict) else None
        if not isinstance(bents, list) or not isinstance(raw.get("column"), dict):
            return raw
        own = [isinstance(bent, dict) and isinstance(bent.get("column"), dict) for bent in bents]
        filled = [
            {**bent, "column": over_default(raw["column"], bent["column"])} if has_own else bent
            for bent, has_own in zip(bents, own, strict=True)
        ]
        return {**raw, "bents": filled}

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
            column = self.column_of(bent)
            width_m = column.outline.sizes_m[1]
            line_m = (bent.columns - 1) * bent.column_spacing_m + width_m
            if line_m > self.deck.width_m:
                raise ValueError(
                    f"bents.{number}: the columns span {line_m:g} m, more than deck.width_m = "
                    f"{self.deck.width_m:g} (column_spacing_m, diameter_m)"
                )
            if bent.columns > 1 and bent.column_spacing_m < width_m:
                raise ValueError(
                    f"bents.{number}.column_spacing_m must exceed the column width {width_m:g}"
                )
            if (column.hinge_length_m or 0.0) > bent.clear_height_m / 2:
                raise ValueError(
                    f"column.hinge_length_m exceeds half of bents.{number}.clear_height_m"
                )
        pads = self.abutment.pads
        if (pads.count - 1) * pads.spacing_m > self.deck.width_m:
            raise ValueError("abutment.pads: (count - 1) x spacing_m exceeds deck.width_m")
        return self
