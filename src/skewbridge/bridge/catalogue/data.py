"""Typed data of a bridge, as frozen pydantic models.

The names of fields include the units of the YAML files; `skewbridge.bridge` converts them to SI
when it builds the model.
"""

import math
import re
from itertools import accumulate, pairwise
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from skewbridge.bridge.catalogue.columns import (
    AnyColumn,
    ColumnData,
    Depth,
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
    over_default,
)
from skewbridge.errors import InputError
from skewbridge.variant.options import LARGEST_SKEW_DEG

type Skew = Annotated[float, Field(ge=-LARGEST_SKEW_DEG, le=LARGEST_SKEW_DEG)]
type Gap = Annotated[float, Field(ge=0.0, le=1.0e3)]
type Base = Literal["pinned", "fixed"]
#: ASSUME a taller column, in widths, has a wrong unit: AASHTO LRFD 5.6.4.3 ends at about 25
_LARGEST_SLENDERNESS: Final = 40.0
_ROUNDING: Final = 1.0 + 1.0e-9  # numbers by rule have ten digits


class DeckData(Part, frozen=True):
    """Superstructure: a prismatic spine at the centroid.

    ``inertia_vertical_m4`` is for vertical bending, ``inertia_transverse_m4`` for bending in plan.
    """

    width_m: Annotated[float, Field(ge=0.5, le=100.0)]
    depth_m: Annotated[float, Field(ge=0.05, le=20.0)]
    area_m2: SquareMetres
    inertia_vertical_m4: Inertia
    inertia_transverse_m4: Inertia
    torsion_constant_m4: Inertia
    centroid_above_soffit_m: Metres
    elastic_modulus_gpa: Gigapascals
    line_load_kn_per_m: LineLoad
    diaphragm_weight_kn: Weight
    diaphragm_thickness_m: Depth
    soffit_height_m: Metres

    @model_validator(mode="after")
    def _centroid_inside(self) -> Self:
        if self.centroid_above_soffit_m >= self.depth_m:
            text = f"centroid_above_soffit_m must be below depth_m = {self.depth_m:g}"
            raise ValueError(f"{text}, got {self.centroid_above_soffit_m:g}")
        return self


class FoundationData(Part, frozen=True):
    """Springs under every column base: x normal to the bent, y along it, z up."""

    kx_mn_per_m: Stiffness
    ky_mn_per_m: Stiffness
    kz_mn_per_m: Stiffness
    krx_mnm_per_rad: Stiffness
    kry_mnm_per_rad: Stiffness
    krz_mnm_per_rad: Stiffness


class PadData(Part, frozen=True):
    """Elastomeric pads in one bearing line, equally spaced across the deck.

    ``yield_force_kn`` of a pad is the force of the hardening branch at zero displacement (Qd of an
    isolator): a pad yields at yield_force_kn / (1 - hardening_ratio).
    """

    count: Annotated[int, Field(ge=2, le=30)]
    spacing_m: Metres
    shear_stiffness_kn_per_m: Stiffness
    yield_force_kn: Kilonewtons
    hardening_ratio: Annotated[float, Field(ge=1.0e-4, le=0.9)]
    vertical_stiffness_mn_per_m: Stiffness
    height_m: Metres


class BentData(Part, frozen=True):
    """One bent: columns equally spaced about the centreline, under an integral cap.

    ``column`` and ``base`` are those of the bridge if None; in the file, ``column`` needs only the
    keys that differ. With ``pads``, the deck runs over the bent on bearings, not cast with the cap.
    """

    columns: Annotated[int, Field(ge=1, le=8)]
    column_spacing_m: Distance = 0.0
    clear_height_m: Metres
    cap_width_m: Metres
    cap_depth_m: Metres
    cap_weight_kn: Weight
    column: AnyColumn | None = None
    base: Base | None = None
    pads: PadData | None = None

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


class KeyData(Part, frozen=True):
    """Backbone of an exterior shear key: end of initial branch, strength, residual strength."""

    displacement_mm: tuple[Millimetres, Millimetres, Millimetres]
    force_kn: tuple[Kilonewtons, Kilonewtons, Kilonewtons]

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        initial, peak, residual = self.displacement_mm
        if not initial < peak < residual:
            raise ValueError(f"displacement_mm must increase, got {self.displacement_mm}")
        return self


class WallData(Part, frozen=True):
    """Wall and fill at one end of a bridge."""

    skew_deg: Skew | None = None  # own skew of the end; None: the skew of the variant
    wall_width_m: Metres
    wall_height_m: Metres
    wall_thickness_m: Metres
    backfill: BackfillData
    wing_length_ratio: Factor
    wing_participation: Factor
    wing_effectiveness: Factor

    @model_validator(mode="after")
    def _backfill_softens(self) -> Self:
        """Reject a secant stiffness that is smaller at half strength than at full strength."""
        soil = self.backfill
        ultimate_m = soil.ultimate_closure_ratio * self.wall_height_m
        secant_mn_per_m = 1e-3 * soil.ultimate_kn / ultimate_m
        if soil.rule == "k50" and soil.stiffness_mn_per_m < secant_mn_per_m:
            raise ValueError(
                f"backfill.stiffness_mn_per_m must be at least {secant_mn_per_m:.4g} with rule k50 "
                "(ultimate_kn over ultimate_closure_ratio x wall_height_m), "
                f"got {soil.stiffness_mn_per_m:g}"
            )
        return self


class AbutmentData(WallData, frozen=True):
    """Seat abutment: pads, a gap to the backwall, and exterior shear keys.

    ``gap_mm`` replaces the gap of the variant at this end, unless it is None. ``keys_at`` is the
    side of the bridge with a shear key; all models but `simplified` use it.
    """

    type: Literal["seat"] = "seat"
    keys_at: Literal["both", "+y", "-y", "none"] = "both"
    gap_mm: Gap | None = None
    seat_width_m: Metres
    key_mass_t: Tonnes
    pads: PadData
    sacrificial_key: KeyData
    monolithic_key: KeyData
    embankment_slope_ratio: Factor
    embankment_height_m: Metres


class PileData(Part, frozen=True):
    """Piles of an integral end, equally spaced across the deck; stiffnesses are of one head.

    The lateral resistance is the same in all directions, elastic up to its strength. A dashpot of
    ``dashpot_s`` times the lateral stiffness acts on its elastic part.
    """

    count: Annotated[int, Field(ge=1, le=60)]
    spacing_m: Metres
    lateral_kn_per_m: Stiffness
    lateral_strength_kn: Kilonewtons
    vertical_mn_per_m: Stiffness
    rotational_mnm_per_rad: Stiffness
    dashpot_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0


class IntegralData(WallData, frozen=True):
    """End diaphragm cast with the deck, on piles, against the fill; the wall is the diaphragm."""

    type: Literal["integral"]
    piles: PileData


class HeldData(Part, frozen=True):
    """Deck end that cannot move, or is held vertically at both ends of its bearing line only."""

    type: Literal["fixed", "roller"]
    skew_deg: Skew | None = None


type EndData = Annotated[AbutmentData | IntegralData | HeldData, Field(discriminator="type")]


class EndsData(Part, frozen=True):
    """Left and right end of a bridge whose ends differ."""

    left: EndData
    right: EndData


class RestrainerData(Part, frozen=True):
    """Cables across a joint: elastic to yield, in tension only, after their slack."""

    count: Annotated[int, Field(ge=2, le=100)]
    stiffness_kn_per_m: Annotated[float, Field(ge=100.0, le=1.0e6)]
    yield_kn: Annotated[float, Field(ge=50.0, le=1.0e4)]
    slack_mm: Gap = 0.0


_BENT: Final = r"^bent [1-9]\d?$"


def _of_bent(location: Any) -> Any:
    if not re.match(_BENT, f"{location}"):
        raise ValueError("must be a bent such as 'bent 1' (from_left_m: a hinge in a span)")
    return location


class JointData(Part, frozen=True):
    """Joint inside a bridge, at a bent or in a span."""

    #: ``bent 1``, counted from the left: both decks rest on its cap
    at: Annotated[str, Field(pattern=_BENT), BeforeValidator(_of_bent)] | None = None
    from_left_m: Span | None = None  # distance of an in-span hinge from the left end of the bridge
    ledge: Literal["left", "right"] = "left"  # deck whose ledge carries the other one at a hinge
    skew_deg: Skew | None = None  # own skew; None: that of the bent, or of the variant at a hinge
    #: own gap; None: the gap of the variant. The same for ``friction``, in models with friction.
    gap_mm: Gap | None = None
    friction: Annotated[float, Field(ge=0.0, le=2.0)] | None = None
    #: from the middle of the joint to the edge of the cap, or width of the ledge
    seat_width_m: Metres
    pads: PadData  # pads below one deck end
    restrainers: RestrainerData | None = None

    @property
    def bent(self) -> int | None:
        """Index of the bent at which the joint is (0 for ``bent 1``), or None for a hinge."""
        return int(self.at.split()[1]) - 1 if self.at else None


class DampingData(Part, frozen=True):
    """Rayleigh damping of deck and columns: one ratio at two periods."""

    ratio: Annotated[float, Field(gt=0.0, lt=0.5)]
    long_period_s: Seconds
    short_period_s: Seconds


class BridgeData(Part, frozen=True):
    """Data of one bridge, in the units of its file."""

    name: str
    title: Annotated[str, Field(min_length=1, max_length=200)]
    #: ``surrogate`` if deck or reinforcement are not published, else ``published``
    details: Literal["surrogate", "published"]
    #: conditioning period: geometric mean of the longitudinal and transverse periods of the
    #: gap-open model with pads at zero skew
    t1_s: Seconds
    spans_m: Annotated[tuple[Span, ...], Field(min_length=1, max_length=12)]
    base: Base  # column bases, ``pinned`` (torsion fixed) or ``fixed``, unless a bent has its own
    deck: DeckData
    bents: tuple[BentData, ...]
    #: column of all bents that have none of their own; None only without bents
    column: AnyColumn | None = None
    foundation: FoundationData | None = None  # springs under the bases; None is rigid ground
    #: data of two equal seat abutments; otherwise ``abutments`` has both ends
    abutment: AbutmentData | None = None
    abutments: EndsData | None = None
    joints: tuple[JointData, ...] = ()
    damping: DampingData
    #: source class and text of every number, keyed by the path of the number in the file
    sources: dict[str, str]

    @property
    def length_m(self) -> float:
        """Total length."""
        return math.fsum(self.spans_m)

    @property
    def ends(self) -> dict[str, EndData]:
        """Data of the left and the right end, by name."""
        ends = self.abutments
        left, right = (ends.left, ends.right) if ends else (self.abutment, self.abutment)
        return {name: end for name, end in (("left", left), ("right", right)) if end is not None}

    @property
    def seats(self) -> dict[str, AbutmentData]:
        """Data of the seat ends, by name."""
        return {name: end for name, end in self.ends.items() if isinstance(end, AbutmentData)}

    @property
    def seat(self) -> AbutmentData:
        """Data of the first seat abutment; raises `InputError` if there is none."""
        for seat in self.seats.values():
            return seat
        raise InputError(f"bridge {self.name} must have a seat abutment")

    @property
    def bent_positions_m(self) -> list[float]:
        """Positions of the bents along x, origin at the middle of the deck."""
        return list(accumulate(self.spans_m[:-1], initial=-self.length_m / 2))[1:]

    def column_of(self, bent: BentData) -> ColumnData:
        """Return the column of a bent."""
        column = bent.column or self.column
        assert column is not None  # `_consistent`
        return column

    def base_of(self, bent: BentData) -> Base:
        """Return the base of the columns of a bent."""
        return bent.base or self.base

    @model_validator(mode="before")
    @classmethod
    def _columns_of_bents(cls, raw: Any) -> Any:
        bents = raw.get("bents") if isinstance(raw, dict) else None
        if not isinstance(bents, list) or not isinstance(raw.get("column"), dict):
            return raw
        flags = [isinstance(bent, dict) and isinstance(bent.get("column"), dict) for bent in bents]
        filled = [
            {**bent, "column": over_default(raw["column"], bent["column"])} if has_column else bent
            for bent, has_column in zip(bents, flags, strict=True)
        ]
        return {**raw, "bents": filled}

    @property
    def joint_positions_m(self) -> list[float]:
        """Positions of the inner joints along x, origin at the middle of the deck."""
        bents, start = self.bent_positions_m, -self.length_m / 2
        return [
            start + (joint.from_left_m or 0.0) if joint.bent is None else bents[joint.bent]
            for joint in self.joints
        ]

    @property
    def jointed_bents(self) -> set[int]:
        """Numbers (0, 1, ...) of the bents below a joint."""
        return {joint.bent for joint in self.joints if joint.bent is not None}

    @property
    def bents_with_bearings(self) -> set[int]:
        """Numbers (0, 1, ...) of the bents whose cap carries bearings, under a joint or a deck."""
        return self.jointed_bents | {i for i, bent in enumerate(self.bents) if bent.pads}

    def _check_width(self, key: str, points: PadData | PileData) -> None:
        line_m, width_m = (points.count - 1) * points.spacing_m, self.deck.width_m
        if line_m > width_m:
            raise ValueError(
                f"{key}: (count - 1) x spacing_m = {line_m:.4g} exceeds deck.width_m = {width_m:g}"
            )

    def _check_bearings(self) -> None:
        for number in sorted(self.bents_with_bearings):
            bent, key = self.bents[number], f"bents.{number}"
            if self.base_of(bent) == "pinned":
                raise ValueError(f"{key}: a bent with bearings on its cap needs base: fixed")
            if bent.pads and number in self.jointed_bents:
                raise ValueError(f"{key}.pads: the joint at this bent has the pads")
            if bent.pads:
                self._check_width(f"{key}.pads", bent.pads)
            height_m, soffit_m = bent.clear_height_m + bent.cap_depth_m, self.deck.soffit_height_m
            if height_m > soffit_m * _ROUNDING:
                raise ValueError(
                    f"{key}: clear_height_m + cap_depth_m = {height_m:.4g} below bearings must be "
                    f"at most deck.soffit_height_m = {soffit_m:g}"
                )

    def _check_joints(self) -> None:
        for number, joint in enumerate(self.joints):
            joint_key = f"joints.{number}"
            if (joint.at is None) == (joint.from_left_m is None):
                raise ValueError(f"{joint_key}: give either at or from_left_m, not both or neither")
            if joint.bent is not None and joint.bent >= len(self.bents):
                raise ValueError(
                    f"{joint_key}.at: must be one of the {len(self.bents)} bents, got {joint.at}"
                )
            if joint.bent is not None:
                cap_m = self.bents[joint.bent].cap_width_m
                if joint.seat_width_m > cap_m / 2 * _ROUNDING:
                    raise ValueError(
                        f"{joint_key}.seat_width_m must be at most half of bents.{joint.bent}."
                        f"cap_width_m = {cap_m:g}, got {joint.seat_width_m:g}"
                    )
            self._check_width(f"{joint_key}.pads", joint.pads)
        ends_m = [-self.length_m / 2, *self.joint_positions_m, self.length_m / 2]
        hinges = [x for x, joint in zip(ends_m[1:], self.joints, strict=False) if not joint.at]
        supports = [ends_m[0], *self.bent_positions_m, ends_m[-1]]
        if any(right - left < 1.0 for left, right in pairwise(ends_m)) or any(
            abs(x - support) < 1.0 for x in hinges for support in supports
        ):
            supports_m = ", ".join(f"{support - ends_m[0]:g}" for support in supports)
            raise ValueError(
                "joints: list them from left to right, at least 1 m apart, and from_left_m at "
                f"least 1 m from each support ({supports_m} m)"
            )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.bents) != len(self.spans_m) - 1:
            raise ValueError(f"bents: {len(self.spans_m)} spans need {len(self.spans_m) - 1} bents")
        if self.bents and self.column is None:
            raise ValueError("column: is missing, but there are bents")
        for number, bent in enumerate(self.bents):
            if bent.clear_height_m > self.deck.soffit_height_m * _ROUNDING:
                raise ValueError(
                    f"bents.{number}.clear_height_m {bent.clear_height_m:g} is taller than the "
                    f"deck: soffit_height_m is {self.deck.soffit_height_m:g}"
                )
            column = self.column_of(bent)
            largest_m = _LARGEST_SLENDERNESS * min(column.outline.sizes_m)
            if bent.clear_height_m > largest_m:
                raise ValueError(
                    f"bents.{number}.clear_height_m must be at most {_LARGEST_SLENDERNESS:g} x the "
                    f"column width = {largest_m:.4g}, got {bent.clear_height_m:g}"
                )
            width_m = column.outline.sizes_m[1]
            row_width_m = (bent.columns - 1) * bent.column_spacing_m + width_m
            if row_width_m > self.deck.width_m:
                raise ValueError(
                    f"bents.{number}: the columns span {row_width_m:g} m, more than deck.width_m = "
                    f"{self.deck.width_m:g} (column_spacing_m, diameter_m); outriggers need an "
                    "OpenSeesPy script"
                )
            if bent.columns > 1 and bent.column_spacing_m < width_m:
                raise ValueError(
                    f"bents.{number}.column_spacing_m must be at least the column width "
                    f"{width_m:g}, got {bent.column_spacing_m:g}"
                )
            if (length_m := column.hinge_length_m or 0.0) > bent.clear_height_m / 2:
                raise ValueError(
                    f"column.hinge_length_m must be at most half of bents.{number}.clear_height_m "
                    f"= {bent.clear_height_m:g}, got {length_m:g}"
                )
        self._check_joints()
        self._check_bearings()
        if (self.abutment is None) == (self.abutments is None):
            raise ValueError(
                "abutment or abutments: give abutment for two equal seats, or abutments with left "
                "and right"
            )
        for name, end in self.ends.items():
            for kind in {"pads", "piles"} & type(end).model_fields.keys():
                end_key = "abutment" if self.abutment else f"abutments.{name}"
                self._check_width(f"{end_key}.{kind}", getattr(end, kind))
        return self
