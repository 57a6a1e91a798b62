"""Typed data of a bridge, as frozen pydantic models.

The names of fields include the units of the YAML files; `skewbridge.bridge` converts them to SI
when it builds the model.
"""

import math
import re
from itertools import accumulate, pairwise
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, Field, model_validator

# These limits are wider than any real bridge. They detect wrong units, and numbers so large that
# their powers would overflow in the solver.
type Metres = Annotated[float, Field(ge=1.0e-3, le=1.0e3)]
type Distance = Annotated[float, Field(ge=0.0, le=1.0e3)]
type Span = Annotated[float, Field(ge=1.0, le=500.0)]
type SquareMetres = Annotated[float, Field(ge=1.0e-3, le=1.0e3)]
type Inertia = Annotated[float, Field(ge=1.0e-6, le=1.0e6)]
type Millimetres = Annotated[float, Field(ge=0.1, le=1.0e4)]
type SquareMillimetres = Annotated[float, Field(ge=1.0, le=1.0e5)]
type Gigapascals = Annotated[float, Field(ge=0.1, le=1.0e3)]
type Megapascals = Annotated[float, Field(ge=1.0, le=2.0e3)]
type Kilonewtons = Annotated[float, Field(ge=1.0e-3, le=1.0e7)]
type Weight = Annotated[float, Field(ge=0.0, le=1.0e6)]
type LineLoad = Annotated[float, Field(ge=0.1, le=1.0e5)]
type UnitWeight = Annotated[float, Field(ge=1.0, le=100.0)]
type Tonnes = Annotated[float, Field(ge=1.0e-3, le=1.0e4)]
type Stiffness = Annotated[float, Field(ge=1.0e-3, le=1.0e9)]
type Seconds = Annotated[float, Field(ge=1.0e-2, le=60.0)]
type Factor = Annotated[float, Field(ge=1.0e-3, le=1.0e2)]
type Ratio = Annotated[float, Field(ge=1.0e-4, le=1.0)]
type Skew = Annotated[float, Field(ge=-60.0, le=60.0)]
type Gap = Annotated[float, Field(ge=0.0, le=1.0e3)]


class _Part(BaseModel, frozen=True, extra="forbid"):
    """Frozen model that rejects unknown keys."""


class DeckData(_Part, frozen=True):
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


class FoundationData(_Part, frozen=True):
    """Springs under every column base; rotational springs act about the global axes."""

    kx_mn_per_m: Stiffness
    ky_mn_per_m: Stiffness
    kz_mn_per_m: Stiffness
    krx_mnm_per_rad: Stiffness
    kry_mnm_per_rad: Stiffness
    krz_mnm_per_rad: Stiffness


class BentData(_Part, frozen=True):
    """One bent: columns equally spaced about the centreline, under an integral cap.

    A bent of one column needs no ``column_spacing_m``.
    """

    columns: Annotated[int, Field(ge=1, le=8)]
    column_spacing_m: Distance = 0.0
    clear_height_m: Metres
    cap_width_m: Metres
    cap_depth_m: Metres
    cap_weight_kn: Weight

    @model_validator(mode="after")
    def _spaced(self) -> Self:
        if self.columns > 1 and self.column_spacing_m == 0.0:
            raise ValueError(f"column_spacing_m is missing or 0: {self.columns} columns need it")
        return self


_OTHER_SHAPE: Final = re.compile(r"width|depth|breadth|height|side|thick|shape|section|flare|taper")


class ColumnData(_Part, frozen=True):
    """Circular reinforced concrete column, the same in all bents of a bridge.

    ``hinge_length_m`` sets the length of the plastic hinges of all bents; by default it is computed
    from their height and base (`skewbridge.bridge.column`). ``steel_strength_factor`` multiplies
    the yield strength of ``steel``.
    """

    diameter_m: Metres
    cover_to_hoop_m: Metres
    bar_count: Annotated[int, Field(ge=6, le=200)]
    bar_area_mm2: SquareMillimetres
    bar_diameter_mm: Millimetres
    hoop_area_mm2: SquareMillimetres
    hoop_diameter_mm: Millimetres
    hoop_spacing_mm: Millimetres
    concrete_strength_mpa: Megapascals
    expected_concrete_strength_mpa: Megapascals
    elastic_modulus_gpa: Gigapascals
    steel: Literal["a706", "grade40", "kaviani"]
    steel_strength_factor: Factor = 1.0
    hoop_yield_mpa: Megapascals
    hinge_length_m: Metres | None = None
    cracked_stiffness_ratio: Ratio
    torsion_ratio: Ratio
    unit_weight_kn_per_m3: UnitWeight

    @property
    def gross_area_m2(self) -> float:
        """Area of the concrete section."""
        return math.pi * self.diameter_m**2 / 4

    @property
    def gross_inertia_m4(self) -> float:
        """Second moment of area of the gross section."""
        return math.pi * self.diameter_m**4 / 64

    @property
    def hoop_circle_m(self) -> float:
        """Diameter of the hoop centre line."""
        return self.diameter_m - 2 * self.cover_to_hoop_m - 1e-3 * self.hoop_diameter_mm

    @property
    def bar_circle_m(self) -> float:
        """Diameter of the circle through the longitudinal bars."""
        return self.hoop_circle_m - 1e-3 * (self.hoop_diameter_mm + self.bar_diameter_mm)

    @model_validator(mode="before")
    @classmethod
    def _is_circular(cls, raw: Any) -> Any:
        keys = sorted(raw.keys() - cls.model_fields.keys()) if isinstance(raw, dict) else ()
        if others := ", ".join(filter(_OTHER_SHAPE.search, keys)):
            text = "the only shape is a circle with diameter_m; the height is in bents"
            raise ValueError(f"unknown key {others}: {text}")
        return raw

    @model_validator(mode="after")
    def _bars_fit(self) -> Self:
        if self.bar_circle_m <= 0.0:
            raise ValueError("cover_to_hoop_m leaves no room for the bars in diameter_m")
        pitch_mm = 1e3 * math.pi * self.bar_circle_m / self.bar_count
        needed_mm = self.bar_diameter_mm + 25.0  # source: 1 in clear between bars, ACI 318 25.2.1
        if pitch_mm < needed_mm:
            limit = math.floor(1e3 * math.pi * self.bar_circle_m / needed_mm)
            raise ValueError(
                f"bar_count {self.bar_count} is too large: at most {limit} bars fit on the circle"
            )
        return self


class BackfillData(_Part, frozen=True):
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


class PadData(_Part, frozen=True):
    """Elastomeric pads of one abutment, equally spaced across the deck."""

    count: Annotated[int, Field(ge=2, le=30)]
    spacing_m: Metres
    shear_stiffness_kn_per_m: Stiffness
    yield_force_kn: Kilonewtons
    hardening_ratio: Annotated[float, Field(ge=1.0e-4, le=0.9)]
    vertical_stiffness_mn_per_m: Stiffness
    height_m: Metres


class KeyData(_Part, frozen=True):
    """Backbone of one exterior shear key at three points; the last force is residual strength."""

    displacement_mm: tuple[Millimetres, Millimetres, Millimetres]
    force_kn: tuple[Kilonewtons, Kilonewtons, Kilonewtons]

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        first, peak, last = self.displacement_mm
        if not first < peak < last:
            raise ValueError(f"displacement_mm must increase, got {self.displacement_mm}")
        return self


class WallData(_Part, frozen=True):
    """Wall and fill at one end of a bridge.

    Attributes:
        skew_deg: Own skew of the end; None: the skew of the variant.
    """

    skew_deg: Skew | None = None
    wall_width_m: Metres
    wall_height_m: Metres
    wall_thickness_m: Metres
    backfill: BackfillData
    wing_length_ratio: Factor
    wing_participation: Factor
    wing_effectiveness: Factor

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


class AbutmentData(WallData, frozen=True):
    """Seat abutment: pads, a gap to the backwall, and exterior shear keys.

    ``gap_mm`` is the own gap of this end; None: the gap of the variant.
    """

    type: Literal["seat"] = "seat"
    gap_mm: Gap | None = None
    seat_width_m: Metres
    key_mass_t: Tonnes
    pads: PadData
    sacrificial_key: KeyData
    monolithic_key: KeyData
    embankment_slope_ratio: Factor
    embankment_height_m: Metres


class PileData(_Part, frozen=True):
    """Piles of an integral end, equally spaced across the deck; stiffnesses are of one head.

    The lateral resistance is the same in all directions, elastic up to its strength.
    """

    count: Annotated[int, Field(ge=1, le=60)]
    spacing_m: Metres
    lateral_kn_per_m: Stiffness
    lateral_strength_kn: Kilonewtons
    vertical_mn_per_m: Stiffness
    rotational_mnm_per_rad: Stiffness


class IntegralData(WallData, frozen=True):
    """End diaphragm cast with the deck, on piles, against the fill; the wall is the diaphragm."""

    type: Literal["integral"]
    piles: PileData


class FixedData(_Part, frozen=True):
    """Deck end that cannot move."""

    type: Literal["fixed"]
    skew_deg: Skew | None = None


class RollerData(_Part, frozen=True):
    """Deck end that is held vertically at both ends of its bearing line, and free in plan."""

    type: Literal["roller"]
    skew_deg: Skew | None = None


type EndData = Annotated[
    AbutmentData | IntegralData | FixedData | RollerData, Field(discriminator="type")
]


class EndsData(_Part, frozen=True):
    """Ends of a bridge that differ."""

    left: EndData
    right: EndData


class RestrainerData(_Part, frozen=True):
    """Cables across a joint: elastic to yield, in tension only, after their slack."""

    count: Annotated[int, Field(ge=2, le=100)]
    stiffness_kn_per_m: Stiffness
    yield_kn: Kilonewtons
    slack_mm: Gap = 0.0


class JointData(_Part, frozen=True):
    """Joint inside a bridge, at a bent or in a span.

    Attributes:
        at: ``bent 1``, counted from the left: both decks rest on its cap.
        from_left_m: Distance of an in-span hinge from the left end of the bridge.
        ledge: Deck whose ledge carries the other one at a hinge.
        skew_deg: Own skew; None: that of the bent, or of the variant at a hinge.
        gap_mm: Own gap; None: the gap of the variant. The same for ``friction``.
        seat_width_m: From the middle of the joint to the edge of the cap, or width of the ledge.
        pads: Pads below one deck end.
    """

    at: Annotated[str, Field(pattern=r"^bent [1-9]\d?$")] | None = None
    from_left_m: Span | None = None
    ledge: Literal["left", "right"] = "left"
    skew_deg: Skew | None = None
    gap_mm: Gap | None = None
    friction: Annotated[float, Field(ge=0.0, le=2.0)] | None = None
    seat_width_m: Metres
    pads: PadData
    restrainers: RestrainerData | None = None

    @property
    def bent(self) -> int | None:
        """Number of its bent (0, 1, ...), or None for a hinge."""
        return int(self.at.split()[1]) - 1 if self.at else None


class DampingData(_Part, frozen=True):
    """Rayleigh damping of deck and columns: one ratio at two periods."""

    ratio: Annotated[float, Field(gt=0.0, lt=0.5)]
    long_period_s: Seconds
    short_period_s: Seconds


class BridgeData(_Part, frozen=True):
    """One bridge of the catalogue.

    Attributes:
        details: ``surrogate`` if deck or reinforcement are not published, else ``published``.
        t1_s: Conditioning period: geometric mean of the longitudinal and transverse periods of
            the gap-open model with pads at zero skew.
        base: Column bases, ``pinned`` (torsion fixed) or ``fixed``.
        foundation: Springs under the bases; None is rigid ground.
        abutment: Data of two equal seat abutments; otherwise ``abutments`` has both ends.
        sources: Source class and text of every number, keyed by the path of the number in the file.
    """

    name: str
    title: Annotated[str, Field(min_length=1, max_length=200)]
    details: Literal["surrogate", "published"]
    t1_s: Seconds
    spans_m: Annotated[tuple[Span, ...], Field(min_length=1, max_length=12)]
    base: Literal["pinned", "fixed"]
    deck: DeckData
    bents: tuple[BentData, ...]
    column: ColumnData
    foundation: FoundationData | None = None
    abutment: AbutmentData | None = None
    abutments: EndsData | None = None
    joints: tuple[JointData, ...] = ()
    damping: DampingData
    sources: dict[str, str]

    @property
    def length_m(self) -> float:
        """Total length."""
        return math.fsum(self.spans_m)

    @property
    def ends(self) -> dict[str, EndData]:
        """Data of the left and the right end, by name."""
        both = self.abutments
        left, right = (both.left, both.right) if both else (self.abutment, self.abutment)
        return {name: end for name, end in (("left", left), ("right", right)) if end is not None}

    @property
    def seats(self) -> dict[str, AbutmentData]:
        """Data of the seat ends, by name."""
        return {name: end for name, end in self.ends.items() if isinstance(end, AbutmentData)}

    @property
    def bent_positions_m(self) -> list[float]:
        """Positions of the bents along x, origin at the middle of the deck."""
        return list(accumulate(self.spans_m[:-1], initial=-self.length_m / 2))[1:]

    @property
    def joint_positions_m(self) -> list[float]:
        """Positions of the inner joints along x, origin at the middle of the deck."""
        bents, start = self.bent_positions_m, -self.length_m / 2
        return [
            start + (each.from_left_m or 0.0) if each.bent is None else bents[each.bent]
            for each in self.joints
        ]

    @property
    def jointed_bents(self) -> set[int]:
        """Numbers (0, 1, ...) of the bents below a joint."""
        return {each.bent for each in self.joints if each.bent is not None}

    def _check_joints(self) -> None:
        for number, joint in enumerate(self.joints):
            where = f"joints.{number}"
            if (joint.at is None) == (joint.from_left_m is None):
                raise ValueError(f"{where}: give either at or from_left_m")
            if joint.bent is not None and joint.bent >= len(self.bents):
                raise ValueError(f"{where}.at: the bridge has {len(self.bents)} bents")
            if joint.bent is not None and self.base == "pinned":
                raise ValueError(f"{where}.at: a bent below a joint needs base: fixed")
            if (joint.pads.count - 1) * joint.pads.spacing_m > self.deck.width_m:
                raise ValueError(f"{where}.pads: (count - 1) x spacing_m exceeds deck.width_m")
        for number in self.jointed_bents:
            bent = self.bents[number]
            if bent.clear_height_m + bent.cap_depth_m > self.deck.soffit_height_m:
                raise ValueError(
                    f"bents.{number}: column and cap below the joint are taller than the deck"
                )
        places = [-self.length_m / 2, *self.joint_positions_m, self.length_m / 2]
        hinges = [x for x, joint in zip(places[1:], self.joints, strict=False) if not joint.at]
        supports = [places[0], *self.bent_positions_m, places[-1]]
        if any(b - a < 1.0 for a, b in pairwise(places)) or any(
            abs(x - support) < 1.0 for x in hinges for support in supports
        ):
            raise ValueError(
                "joints: list them from left to right, at least 1 m apart and from supports"
            )

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
                raise ValueError(
                    f"bents.{number}: the columns span {line_m:g} m, more than deck.width_m = "
                    f"{self.deck.width_m:g}"
                )
            if bent.columns > 1 and bent.column_spacing_m < self.column.diameter_m:
                raise ValueError(
                    f"bents.{number}.column_spacing_m must exceed the column diameter_m"
                )
            if (self.column.hinge_length_m or 0.0) > bent.clear_height_m / 2:
                raise ValueError(
                    f"column.hinge_length_m exceeds half of bents.{number}.clear_height_m"
                )
        self._check_joints()
        if (self.abutment is None) == (self.abutments is None):
            raise ValueError(
                "abutment or abutments: give abutment for two equal seats, or abutments with left "
                "and right"
            )
        for name, end in self.ends.items():
            part = getattr(end, "pads", getattr(end, "piles", None))
            if part is not None and (part.count - 1) * part.spacing_m > self.deck.width_m:
                where = "abutment" if self.abutment else f"abutments.{name}"
                kind = "pads" if end.type == "seat" else "piles"
                raise ValueError(f"{where}.{kind}: (count - 1) x spacing_m exceeds deck.width_m")
        return self
