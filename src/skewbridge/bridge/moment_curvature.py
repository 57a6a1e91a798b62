"""Moment-curvature of circular reinforced concrete columns, computed without OpenSees."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skewbridge.bridge.catalogue.data import ColumnData
from skewbridge.bridge.materials import FloatArray, core_concrete, cover_concrete, steel_of

STRIPS = 160  # across the diameter: moments change by less than 0.1 % when halved
POINTS = 120  # of a curve, to the largest curvature that is tried
STRAIN_TOLERANCE = 1e-10
_ROUNDING = 4 * sys.float_info.epsilon


@dataclass(frozen=True, slots=True, kw_only=True)
class MomentCurvature:
    """A curve under constant axial force, with its idealisation.

    Attributes:
        curvature_per_m: From zero to the ultimate curvature.
        moment_nm: Same length.
        first_yield_curvature_per_m: First bar at its yield strain.
        first_yield_moment_nm: Moment there.
        yield_curvature_per_m: Knee of the elastic-perfectly-plastic curve of equal area.
        plastic_moment_nm: Its plateau.
        ultimate_curvature_per_m: Core concrete or a bar at its ultimate strain.
        neutral_axis_depth_m: At the knee of the idealised curve, from the compression face.
    """

    curvature_per_m: FloatArray
    moment_nm: FloatArray
    first_yield_curvature_per_m: float
    first_yield_moment_nm: float
    yield_curvature_per_m: float
    plastic_moment_nm: float
    ultimate_curvature_per_m: float
    neutral_axis_depth_m: float

    @property
    def curvature_ductility(self) -> float:
        """Ultimate over idealised yield curvature."""
        return self.ultimate_curvature_per_m / self.yield_curvature_per_m


@lru_cache(maxsize=32)
def section_response(column: ColumnData, axial_n: float) -> MomentCurvature:
    """Return the curve of a column section under an axial force, positive in compression.

    It is kept, because each column of each model needs it.

    Concrete follows Mander's curves (confined core, spalling cover), steel is bilinear as in the
    fiber model.

    References:
        Caltrans SDC 1.7 section 3.3.1 for the equal-area idealisation through the first yield.
    """
    section = _Section(column)
    rows: list[tuple[float, float, float]] = []
    for phi in np.geomspace(2e-5, 0.25, POINTS) / column.diameter_m:
        centre = section.centre_strain(phi, axial_n)
        moment_nm = section.resultants(centre, phi)[1]
        rows.append((phi, moment_nm, column.diameter_m / 2 + centre / phi))
        if section.is_ultimate(centre, phi):
            break
    curvature, moment, axis = np.array(rows).T
    # strain of the bar farthest from the neutral axis
    tension = curvature * (section.highest_bar_m - (axis - column.diameter_m / 2))
    first = float(np.interp(section.yield_strain, tension, curvature))
    first_moment = float(np.interp(first, curvature, moment))
    stiffness = first_moment / first
    full = np.concatenate(([0.0], curvature)), np.concatenate(([0.0], moment))
    area = np.trapezoid(full[1], full[0])
    # area = Mp phi_u - Mp^2 / (2 k): the smaller root is the plateau
    end = curvature[-1]
    plateau = stiffness * (end - np.sqrt(end**2 - 2 * area / stiffness))
    knee = float(plateau / stiffness)
    return MomentCurvature(
        curvature_per_m=full[0],
        moment_nm=full[1],
        first_yield_curvature_per_m=first,
        first_yield_moment_nm=first_moment,
        yield_curvature_per_m=knee,
        plastic_moment_nm=float(plateau),
        ultimate_curvature_per_m=float(end),
        neutral_axis_depth_m=float(np.interp(knee, curvature, axis)),
    )


class _Section:
    """Strips of core and cover parallel to the neutral axis, and bars; compressed side up."""

    def __init__(self, column: ColumnData) -> None:
        self._core, self._cover = core_concrete(column), cover_concrete(column)
        self._steel = steel_of(column)
        self._radius_m, self._core_radius_m = column.diameter_m / 2, column.hoop_circle_m / 2
        edges = np.linspace(-self._radius_m, self._radius_m, STRIPS + 1)
        self._height_m = (edges[1:] + edges[:-1]) / 2
        self._core_m2 = np.diff(_area_below(edges, self._core_radius_m))
        self._cover_m2 = np.diff(_area_below(edges, self._radius_m)) - self._core_m2
        angle = 2 * np.pi * (np.arange(column.bar_count) + 0.5) / column.bar_count
        self._bar_height_m = column.bar_circle_m / 2 * np.sin(angle)
        self._bar_m2 = np.full(column.bar_count, column.bar_area_mm2 * 1e-6)
        self.highest_bar_m = float(self._bar_height_m.max())
        self.yield_strain = self._steel.yield_pa / self._steel.modulus_pa

    def resultants(self, centre: float, phi: float) -> tuple[float, float]:
        """Return axial force and moment, compression positive."""
        strain = centre + phi * self._height_m
        force = self._core_m2 * self._core.stress_pa(strain)
        force += self._cover_m2 * self._cover.stress_pa(strain)
        bar_strain = centre + phi * self._bar_height_m
        bar = self._bar_m2 * self._steel_stress_pa(bar_strain)
        bar -= self._bar_m2 * self._core.stress_pa(bar_strain)  # displaced concrete
        axial = float(force.sum() + bar.sum())
        return axial, float((force * self._height_m).sum() + (bar * self._bar_height_m).sum())

    def centre_strain(self, phi: float, axial_n: float) -> float:
        """Return the strain at the centre that balances the axial force."""

        def unbalance(centre: float) -> float:
            return self.resultants(centre, phi)[0] - axial_n

        half = phi * self._radius_m
        # from all fibers well in tension to the face at the peak of the confined curve
        return bracketed_root(unbalance, -half - 0.02, 0.002 + half)

    def is_ultimate(self, centre: float, phi: float) -> bool:
        """Return whether the core or a bar is at its ultimate strain."""
        core_face = centre + phi * self._core_radius_m
        tension = phi * self.highest_bar_m - centre
        return core_face >= self._core.ultimate_strain or tension >= self._steel.rupture_strain

    def _steel_stress_pa(self, strain: FloatArray) -> FloatArray:
        elastic = np.clip(strain, -self.yield_strain, self.yield_strain)
        return self._steel.modulus_pa * (elastic + self._steel.hardening_ratio * (strain - elastic))


def bracketed_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return a root of a function between two points at which its signs differ.

    Brent's method, with the same steps as `scipy.optimize.brentq`, whose import takes longer than
    a short analysis. A softening section may balance at more than one strain, and the root found
    depends on the method.

    References:
        Brent (1973), Algorithms for Minimization without Derivatives, chapter 4.
    """
    before, here = low, high
    f_before, f_here = function(before), function(here)
    across, f_across, last, step = before, f_before, 0.0, 0.0
    while True:
        if f_before != 0.0 and f_here != 0.0 and (f_before > 0.0) != (f_here > 0.0):
            across, f_across = before, f_before
            last = step = here - before
        if abs(f_across) < abs(f_here):
            before, here, across = here, across, here
            f_before, f_here, f_across = f_here, f_across, f_here
        nearest = (STRAIN_TOLERANCE + _ROUNDING * abs(here)) / 2
        half = (across - here) / 2
        if f_here == 0.0 or abs(half) < nearest:
            return here
        trial = float("inf")
        if abs(last) > nearest and abs(f_here) < abs(f_before):
            if before == across:
                trial = -f_here * (here - before) / (f_here - f_before)
            else:
                slope = (f_before - f_here) / (before - here)
                slope_across = (f_across - f_here) / (across - here)
                trial = -f_here * (f_across * slope_across - f_before * slope)
                trial /= slope_across * slope * (f_across - f_before)
        is_safe = 2 * abs(trial) < min(abs(last), 3 * abs(half) - nearest)
        last, step = (step, trial) if is_safe else (half, half)
        before, f_before = here, f_here
        here += step if abs(step) > nearest else np.copysign(nearest, half)
        f_here = function(here)


def _area_below(height: FloatArray, radius: float) -> FloatArray:
    y = np.clip(height, -radius, radius)
    return y * np.sqrt(radius**2 - y**2) + radius**2 * (np.arcsin(y / radius) + np.pi / 2)
