"""Ranges of the numbers in a bridge file, and its columns.

Each shape of columns is one class here, named in `AnyColumn`; no other code knows the shapes.
Sections are symmetric about both of their axes. A pair of numbers is for the directions normal to
the bent and along it; fibers and points have y along the bent and z normal to it, as in OpenSees.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from operator import sub
from typing import Annotated, Any, Final, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidatorFunctionWrapHandler, WrapValidator, model_validator

from skewbridge.units import MM

# These limits are wider than any real bridge. They detect wrong units, and numbers so large that
# their powers would overflow in the solver.
type Metres = Annotated[float, Field(ge=1.0e-3, le=1.0e3)]
type Distance = Annotated[float, Field(ge=0.0, le=50.0)]
# ASSUME a larger or smaller column, bar, weight or cable has a wrong unit
type Depth = Annotated[float, Field(ge=0.1, le=10.0)]
type Width = Annotated[float, Field(ge=0.1, le=40.0)]
type Cover = Annotated[float, Field(ge=1.0e-3, le=0.5)]
type BarSize = Annotated[float, Field(ge=3.0, le=100.0)]
type HoopSpacing = Annotated[float, Field(ge=3.0, le=2.0e3)]
type Span = Annotated[float, Field(ge=1.0, le=500.0)]
type SquareMetres = Annotated[float, Field(ge=1.0e-3, le=1.0e3)]
type Inertia = Annotated[float, Field(ge=1.0e-6, le=1.0e6)]
type Millimetres = Annotated[float, Field(ge=0.1, le=1.0e4)]
type SquareMillimetres = Annotated[float, Field(ge=1.0, le=1.0e5)]
type Gigapascals = Annotated[float, Field(ge=0.1, le=1.0e3)]
type Megapascals = Annotated[float, Field(ge=1.0, le=2.0e3)]
type Kilonewtons = Annotated[float, Field(ge=1.0e-3, le=1.0e7)]
type Weight = Annotated[float, Field(ge=0.0, le=1.0e5)]
type LineLoad = Annotated[float, Field(ge=0.1, le=1.0e5)]
type UnitWeight = Annotated[float, Field(ge=1.0, le=100.0)]
type Tonnes = Annotated[float, Field(ge=1.0e-3, le=1.0e4)]
type Stiffness = Annotated[float, Field(ge=1.0e-3, le=1.0e9)]
type Seconds = Annotated[float, Field(ge=1.0e-2, le=60.0)]
type Factor = Annotated[float, Field(ge=1.0e-3, le=1.0e2)]
type Ratio = Annotated[float, Field(ge=1.0e-4, le=1.0)]


class Part(BaseModel, frozen=True, extra="forbid"):
    """Frozen model that rejects unknown keys."""


# --- columns

type FloatArray = NDArray[np.float64]
type Pair = tuple[float, float]
#: y, z (m) and area (m2) of each fiber.
type Fibers = list[tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class Outline:
    """Circle, rectangle (``corner_m`` 0), or oblong with round ends of diameter ``corner_m``."""

    sizes_m: Pair
    corner_m: float = 0.0

    @property
    def is_round(self) -> bool:
        """Whether the outline is a circle."""
        return self.sizes_m[0] == self.sizes_m[1] == self.corner_m

    @property
    def length_m(self) -> float:
        """Perimeter."""
        return math.pi * self.corner_m + 2 * (sum(self.sizes_m) - 2 * self.corner_m)

    @property
    def area_m2(self) -> float:
        """Enclosed area."""
        round_m2 = math.pi * self.corner_m**2 / 4
        return round_m2 + (self.sizes_m[0] * self.sizes_m[1] - self.corner_m * self.corner_m)

    def inertia_m4(self, direction: int) -> float:
        """Return the inertia for bending normal to the bent (``direction`` 0) or along it (1)."""
        size, across, corner_m = self.sizes_m[direction], self.sizes_m[1 - direction], self.corner_m
        flat = size - corner_m
        arcs = math.pi * corner_m**2 * flat**2 / 16 + corner_m**3 * flat / 6  # of two semicircles
        i_middle = ((across - corner_m) * size**3 + corner_m * flat**3) / 12
        return math.pi * corner_m**4 / 64 + (i_middle + arcs)

    @property
    def torsion_m4(self) -> float:
        """Torsion constant A^4 / (4 pi^2 Ip), at most 9 % off for rectangles (Saint-Venant)."""
        polar = self.inertia_m4(0) + self.inertia_m4(1)
        return polar if self.is_round else self.area_m2**4 / (4 * math.pi**2 * polar)

    def inset(self, *by_m: float) -> "Outline":
        """Return the outline with both sizes reduced by the sum of ``by_m``."""
        sizes = (*self.sizes_m, self.corner_m)
        depth_m, width_m, corner_m = (reduce(sub, by_m, size) for size in sizes)
        return Outline((depth_m, width_m), corner_m if self.corner_m else 0.0)

    def area_below(self, direction: int, height_m: FloatArray) -> FloatArray:
        """Return the area (m2) below heights (m above the centre, in the direction of bending)."""
        size, across, corner_m = self.sizes_m[direction], self.sizes_m[1 - direction], self.corner_m
        flat = (size - corner_m) / 2

        def inside(half: float) -> FloatArray:
            return np.clip(height_m, -half, half) + half

        area = (across - corner_m) * inside(size / 2) + corner_m * inside(flat)
        if corner_m:
            upper = _disc_below(np.maximum(height_m - flat, 0.0), corner_m / 2)
            upper -= _disc_below(np.zeros(1), corner_m / 2)
            area += _disc_below(np.minimum(height_m + flat, 0.0), corner_m / 2) + upper
        return area

    def points(self, count: int) -> FloatArray:
        """Return points (y, z in m) at nearly equal distances on the outline, shape (n, 2)."""
        depth, width = self.sizes_m
        if self.is_round:
            angle_rad = 2 * np.pi * (np.arange(count) + 0.5) / count
            return self.corner_m / 2 * np.column_stack((np.cos(angle_rad), np.sin(angle_rad)))
        if self.corner_m:
            angles = np.linspace(0.0, np.pi, 361)
            y, z = (width - depth) / 2 + depth / 2 * np.sin(angles), depth / 2 * np.cos(angles)
            y, z = np.array([0.0, *-y, *y, 0.0]), np.array([z[0], *z, *-z, z[0]])
            s_m = np.append(0.0, np.hypot(np.diff(y), np.diff(z)).cumsum())
            along_m = (np.arange(count) + 0.5) / count * s_m[-1]
            return np.column_stack((np.interp(along_m, s_m, y), np.interp(along_m, s_m, z)))
        half = count // 2
        steps = min(max(round(half * width / (width + depth)), 1), half - 1)
        edge, side = (np.linspace(-0.5, 0.5, n, endpoint=False) for n in (steps, half - steps))
        half_outline = np.array([*((y, -0.5) for y in edge), *((0.5, z) for z in side)])
        return np.vstack((half_outline, -half_outline)) * (width, depth)

    def fibers(self, rings: int, wedges: int, core: "Outline | None" = None) -> Fibers:
        """Return fibers of the area, or only of the cover outside ``core``.

        Circles have rings of wedges, rectangles two rows per ring (one in the cover).
        """
        (depth, width), end_m, core_m = self.sizes_m, self.corner_m, core.corner_m if core else 0.0
        flat = width - end_m
        if self.is_round:
            return _rings(core_m / 2, end_m / 2, rings, wedges)
        # the two halves of a disc, with as many fibers, are at the ends
        disc = _rings(core_m / 2, end_m / 2, rings, 4 * math.ceil(wedges / 4)) if end_m else []
        fibers = [(y + math.copysign(flat / 2, y), z, area) for y, z, area in disc]
        if core is None:
            return fibers + _block((0.0, 0.0), (flat, depth), (2 * rings, 2 * rings))
        core_z, core_y = core.sizes_m
        rows = _block((0.0, (depth + core_z) / 4), (flat, (depth - core_z) / 2), (wedges, rings))
        if not end_m:
            side_block = ((width + core_y) / 4, 0.0), ((width - core_y) / 2, core_z)
            rows += _block(*side_block, (rings, wedges))
        return fibers + [(sign * y, sign * z, area) for sign in (1, -1) for y, z, area in rows]


def _disc_below(height_m: FloatArray, radius: float) -> FloatArray:
    y = np.clip(height_m, -radius, radius)
    return y * np.sqrt(radius**2 - y**2) + radius**2 * (np.arcsin(y / radius) + np.pi / 2)


def _circle(radius_m: float, area_m2: float, count: int) -> Fibers:
    angles = [2 * math.pi * (number + 0.5) / count for number in range(count)]
    area = area_m2 / count
    return [(radius_m * math.cos(angle), radius_m * math.sin(angle), area) for angle in angles]


def _rings(inner_m: float, outer_m: float, rings: int, wedges: int) -> Fibers:
    """Return fibers of an annulus in rings of equal thickness, fewer fibers in inner rings.

    The fibers of a ring are at the radius that preserves its second moment: a coarse mesh is as
    stiff as a fine one.
    """
    fibers: Fibers = []
    for ring in range(rings):
        low_m, high_m = (inner_m + (outer_m - inner_m) * edge / rings for edge in (ring, ring + 1))
        area_m2 = math.pi * (high_m**2 - low_m**2)
        count = min(wedges, max(8, 4 * math.ceil(wedges * high_m / outer_m / 4)))
        fibers += _circle(math.sqrt((low_m**2 + high_m**2) / 2), area_m2, count)
    return fibers


def _block(centre_m: Pair, sizes_m: Pair, counts: tuple[int, int]) -> Fibers:
    """Return fibers of a rectangle along y and z that preserve its second moments of area."""
    y, z = (
        centre + size / math.sqrt(max(count**2 - 1, 1)) * (np.arange(count) - (count - 1) / 2)
        for centre, size, count in zip(centre_m, sizes_m, counts, strict=True)
    )
    area = sizes_m[0] * sizes_m[1] / (counts[0] * counts[1])
    return [(across, along, area) for across in y.tolist() for along in z.tolist()]


class Hoops(NamedTuple):
    """Confinement and shear resistance by the hoops of a column."""

    confining: Pair  # effective steel ratios: times the yield strength, the pressures on the core
    volume_ratio: float  # volume of hoops over that of the core
    shear_area_m2: Pair  # area of steel across a crack in one layer of hoops
    shear_depth_m: Pair  # height of a crack of 45 degrees: Vs = area x yield x depth / spacing
    shear_ratio: Pair  # ratio that the concrete contribution of the shear strength depends on


class ColumnData(Part, ABC, frozen=True):
    """Data that all shapes of reinforced concrete columns share.

    ``hinge_length_m`` replaces the rule for the hinge length (`skewbridge.bridge.column`), and
    ``shear_span_ratio`` the height of zero moment along the bent / clear height (fixed bases);
    ``hoop_area_mm2`` is the area of one leg.
    """

    shape: str
    cover_to_hoop_m: Cover
    bar_count: Annotated[int, Field(ge=6, le=200)]
    bar_area_mm2: SquareMillimetres
    bar_diameter_mm: BarSize
    hoop_area_mm2: SquareMillimetres
    hoop_diameter_mm: BarSize
    hoop_spacing_mm: HoopSpacing
    concrete_strength_mpa: Megapascals
    expected_concrete_strength_mpa: Megapascals
    elastic_modulus_gpa: Gigapascals
    steel: Literal["a706", "grade40", "kaviani"]
    steel_strength_factor: Factor = 1.0
    hoop_yield_mpa: Megapascals
    hinge_length_m: Metres | None = None
    shear_span_ratio: Annotated[float, Field(ge=0.5, le=2.0)] | None = None
    cracked_stiffness_ratio: Ratio
    torsion_ratio: Ratio
    unit_weight_kn_per_m3: UnitWeight

    @property
    @abstractmethod
    def outline(self) -> Outline:
        """Outline of the section."""

    @property
    @abstractmethod
    def hoops(self) -> Hoops:
        """Confinement and shear resistance by hoops and ties."""

    @property
    def core(self) -> Outline:
        """Outline of the core: the centre line of the hoop."""
        return self.outline.inset(2 * self.cover_to_hoop_m, 1e-3 * self.hoop_diameter_mm)

    @property
    def bar_line(self) -> Outline:
        """Outline through the centres of the longitudinal bars."""
        return self.core.inset(1e-3 * (self.hoop_diameter_mm + self.bar_diameter_mm))

    @property
    def steel_area_m2(self) -> float:
        """Area of all longitudinal bars."""
        return self.bar_count * self.bar_area_mm2 * MM**2

    def fibers(self, rings: int, wedges: int, cover_rings: int) -> tuple[Fibers, Fibers, Fibers]:
        """Return the fibers of core, cover and bars."""
        core, bar_line = self.core, self.bar_line
        bars = [(y, z, self.steel_area_m2 / self.bar_count) for y, z in self.bars_m.tolist()]
        if self.outline.is_round:
            bars = _circle(bar_line.corner_m / 2, self.steel_area_m2, min(self.bar_count, wedges))
        return core.fibers(rings, wedges), self.outline.fibers(cover_rings, wedges, core), bars

    @property
    def bars_m(self) -> FloatArray:
        """Centres of the bars (y, z), shape (n, 2)."""
        return self.bar_line.points(self.bar_count)

    @model_validator(mode="after")
    def _bars_fit(self) -> Self:
        bar_line = self.bar_line
        if min(bar_line.sizes_m) <= 0.0:
            raise ValueError(
                "cover_to_hoop_m, hoop_diameter_mm and bar_diameter_mm leave no room for the bars"
            )
        needed_mm = self.bar_diameter_mm + 25.0  # source: 1 in clear between bars, ACI 318 25.2.1
        if self.bar_count > (limit := math.floor(1e3 * bar_line.length_m / needed_mm)):
            raise ValueError(
                f"bar_count {self.bar_count} is too large: at most {limit} bars fit along the hoop"
                " (bar_diameter_mm, hoop_diameter_mm, cover_to_hoop_m, diameter_m)"
            )
        if self.bar_count % 2 and not bar_line.is_round:
            raise ValueError(f"bar_count must be even, got {self.bar_count}")
        return self

    def _round_hoops(self, shear_area_m2: Pair, shear_depth_m: Pair) -> Hoops:
        """Return the effect of hoops that confine the core like a circle.

        References:
            Mander, Priestley and Park (1988), J. Struct. Eng. 114(8), 1804-1826, eq. 12-19.
        """
        circle_m, spacing_mm = self.core.sizes_m[0], self.hoop_spacing_mm
        clear_m = 1e-3 * (spacing_mm - self.hoop_diameter_mm)
        core_ratio = self.steel_area_m2 / self.core.area_m2
        arching = max(1.0 - clear_m / (2 * circle_m), 0.0) ** 2 / (1.0 - core_ratio)
        rho = 4 * self.hoop_area_mm2 * 1e-6 / (circle_m * 1e-3 * spacing_mm)
        pressure = 0.5 * arching * rho
        return Hoops((pressure, pressure), rho, shear_area_m2, shear_depth_m, (rho, rho))


# ASSUME the effective depth of a section with bars along all faces is 0.8 of its depth
# source: ACI 318-14 section 11.5.4.2
EFFECTIVE_DEPTH: Final = 0.8


class CircularColumn(ColumnData, frozen=True):
    """Circular column with circular hoops or a spiral."""

    shape: Literal["circular"] = "circular"
    diameter_m: Depth

    @property
    def outline(self) -> Outline:
        """Circle of the column's diameter."""
        return Outline((self.diameter_m, self.diameter_m), self.diameter_m)

    @property
    def hoops(self) -> Hoops:
        """Circular hoops: Vs = pi/2 A_b f_yh D' / s."""
        area_m2 = (np.pi / 2) * (self.hoop_area_mm2 * MM**2)
        return self._round_hoops((area_m2, area_m2), self.core.sizes_m)


class OblongColumn(ColumnData, frozen=True):
    """Rectangle between two semicircles, with a hoop and equally spaced bars along its outline.

    ``width_m`` is along the bent, ``depth_m`` the diameter; ``cross_ties`` are across the straight
    part.
    """

    shape: Literal["oblong"] = "oblong"
    width_m: Width
    depth_m: Depth
    cross_ties: Annotated[int, Field(ge=0, le=100)] = 0

    @property
    def outline(self) -> Outline:
        """Rectangle between two semicircles."""
        return Outline((self.depth_m, self.width_m), self.depth_m)

    @property
    def hoops(self) -> Hoops:
        """Hoop and cross ties, which confine at most as well as the hoops of a circular column."""
        # ASSUME cross ties confine the straight part like the ends; the ends resist shear like one
        # circular hoop, and along the bent only the straight sides resist it
        leg_m2, core, ties = self.hoop_area_mm2 * MM**2, self.core, self.cross_ties
        areas_m2 = (math.pi / 2 + ties) * leg_m2, 2 * leg_m2
        hoops = self._round_hoops(areas_m2, (core.sizes_m[0], EFFECTIVE_DEPTH * self.width_m))
        share = min((2 + ties) / 2 * core.sizes_m[0] / core.sizes_m[1], 1.0)
        volume_m2 = (core.length_m + ties * core.sizes_m[0]) * leg_m2 / (MM * self.hoop_spacing_mm)
        return hoops._replace(
            confining=(share * hoops.confining[0], hoops.confining[1]),
            volume_ratio=min(volume_m2 / core.area_m2, hoops.volume_ratio),
        )

    @model_validator(mode="after")
    def _is_oblong(self) -> Self:
        if self.width_m <= self.depth_m:
            raise ValueError(f"width_m must exceed depth_m {self.depth_m:g}, got {self.width_m:g}")
        return self


class RectangularColumn(ColumnData, frozen=True):
    """Rectangular column or wall pier with bars along all faces and in the corners.

    ``width_m`` is along the bent; ``tie_legs`` counts legs of hoop and ties along width and depth.
    """

    shape: Literal["rectangular"] = "rectangular"
    width_m: Width
    depth_m: Depth
    tie_legs: tuple[Annotated[int, Field(ge=2, le=100)], Annotated[int, Field(ge=2, le=100)]]

    @property
    def outline(self) -> Outline:
        """Rectangle of the column's depth and width."""
        return Outline((self.depth_m, self.width_m))

    @property
    def hoops(self) -> Hoops:
        """Rectangular hoop and ties; every leg holds a bar, at equal distances.

        References:
            Mander, Priestley and Park (1988), eq. 20-23; shear ratio: AASHTO Guide Specifications
            for LRFD Seismic Bridge Design 8.6.2.
        """
        sizes_m, core_m, legs = self.outline.sizes_m, self.core.sizes_m, self.tie_legs[::-1]
        spacing_m = MM * self.hoop_spacing_mm
        clear_spacing_m = spacing_m - MM * self.hoop_diameter_mm
        areas_m2 = [count * self.hoop_area_mm2 * MM**2 for count in legs]
        core_m2, effectiveness = self.core.area_m2, 1.0
        for bar_row_m, count in zip(self.bar_line.sizes_m[::-1], legs, strict=True):
            clear_m = max(bar_row_m / (count - 1) - self.bar_diameter_mm * MM, 0.0)
            effectiveness -= 2 * (count - 1) * clear_m**2 / (6 * core_m2)
        for size_m in core_m:
            effectiveness = max(effectiveness, 0.0) * max(1.0 - clear_spacing_m / (2 * size_m), 0.0)
        effectiveness /= 1.0 - self.steel_area_m2 / core_m2
        ratios = [areas_m2[k] / (spacing_m * core_m[1 - k]) for k in (0, 1)]
        shear = [2 * areas_m2[k] / (spacing_m * sizes_m[1 - k]) for k in (0, 1)]
        return Hoops(
            confining=(effectiveness * ratios[0], effectiveness * ratios[1]),
            volume_ratio=sum(ratios),
            shear_area_m2=(areas_m2[0], areas_m2[1]),
            shear_depth_m=(EFFECTIVE_DEPTH * sizes_m[0], EFFECTIVE_DEPTH * sizes_m[1]),
            shear_ratio=(shear[0], shear[1]),
        )


def _of_its_shape(raw: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    """Return the column of a mapping; errors are about the keys of its own shape only."""
    if isinstance(raw, ColumnData):
        return handler(raw)
    if not isinstance(raw, Mapping):
        raise ValueError("must contain keys and values")
    shapes, shape = _shapes(), _shape_of(raw)
    if shape not in shapes:
        raise ValueError(f"shape must be one of {', '.join(shapes)}, got {shape!r}")
    for key in sorted(raw.keys() - shapes[shape].model_fields.keys()):
        if owners := [name for name, kind in shapes.items() if key in kind.model_fields]:
            raise ValueError(f"{key} is not a key of shape {shape}, only of {' and '.join(owners)}")
    return shapes[shape].model_validate(raw)


#: Column of any shape, circular if its ``shape`` is absent.
type AnyColumn = Annotated[
    CircularColumn | RectangularColumn | OblongColumn, WrapValidator(_of_its_shape)
]


def _shapes() -> dict[str, type[ColumnData]]:
    return {kind.model_fields["shape"].default: kind for kind in ColumnData.__subclasses__()}


def _shape_of(raw: Mapping[str, Any]) -> str:
    return str(raw.get("shape", "circular"))


def over_default(default: Mapping[str, Any], column: Mapping[str, Any]) -> dict[str, Any]:
    """Return a column with the keys it lacks from a default column, if its shape has them."""
    shape, shapes = _shape_of({**default, **column}), _shapes()
    if shape != _shape_of(default) and shape in shapes:
        default = {key: default[key] for key in default.keys() & shapes[shape].model_fields.keys()}
    return {**default, **column}
