"""Moment-curvature of a circular reinforced concrete column, without a finite element domain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from skewbridge.bridge.catalogue.data import ColumnData
from skewbridge.bridge.materials import STEELS, Steel, core_concrete, cover_concrete

type FloatArray = NDArray[np.float64]

STRIPS = 160  # across the diameter: moments change by less than 0.1 % when halved


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


@dataclass(frozen=True, slots=True)
class _Strips:
    """Strips parallel to the neutral axis: height above the centre, areas of core and cover."""

    height_m: FloatArray
    core_m2: FloatArray
    cover_m2: FloatArray
    bar_height_m: FloatArray
    bar_m2: FloatArray


def moment_curvature(column: ColumnData, axial_n: float, *, points: int = 120) -> MomentCurvature:
    """Return the curve of a column section under an axial force.

    Concrete follows Mander's curves (confined core, spalling cover), steel is bilinear as in the
    fiber model.

    Args:
        column: The section.
        axial_n: Compression, positive.
        points: Curvatures evaluated.

    References:
        Caltrans SDC 1.7 section 3.3.1 for the equal-area idealisation through the first yield.
    """
    strips = _strips(column)
    steel = STEELS[column.steel]
    curvature = np.geomspace(2e-5, 0.25, points) / column.diameter_m
    moment = np.empty(points)
    axis = np.empty(points)
    last = points
    for i, phi in enumerate(curvature):
        centre = _centre_strain(strips, column, steel, phi, axial_n)
        moment[i] = _resultants(strips, column, steel, centre, phi)[1]
        axis[i] = column.diameter_m / 2 + centre / phi
        if _is_ultimate(strips, column, steel, centre, phi):
            last = i + 1
            break
    curvature, moment, axis = curvature[:last], moment[:last], axis[:last]
    tension = _bar_tension(strips, curvature, axis - column.diameter_m / 2)
    yield_strain = steel.yield_pa / steel.modulus_pa
    first = float(np.interp(yield_strain, tension, curvature))
    first_moment = float(np.interp(first, curvature, moment))
    stiffness = first_moment / first
    full = np.concatenate(([0.0], curvature)), np.concatenate(([0.0], moment))
    area = trapezoid(full[1], full[0])
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


def _strips(column: ColumnData) -> _Strips:
    radius, core = column.diameter_m / 2, column.hoop_circle_m / 2
    edges = np.linspace(-radius, radius, STRIPS + 1)
    whole = np.diff(_area_below(edges, radius))
    inner = np.diff(_area_below(edges, core))
    angle = 2 * np.pi * (np.arange(column.bar_count) + 0.5) / column.bar_count
    return _Strips(
        height_m=(edges[1:] + edges[:-1]) / 2,
        core_m2=inner,
        cover_m2=whole - inner,
        bar_height_m=column.bar_circle_m / 2 * np.sin(angle),
        bar_m2=np.full(column.bar_count, column.bar_area_mm2 * 1e-6),
    )


def _area_below(height: FloatArray, radius: float) -> FloatArray:
    y = np.clip(height, -radius, radius)
    return y * np.sqrt(radius**2 - y**2) + radius**2 * (np.arcsin(y / radius) + np.pi / 2)


def _resultants(
    strips: _Strips, column: ColumnData, steel: Steel, centre: float, phi: float
) -> tuple[float, float]:
    """Axial force and moment (compression positive, compressed side up)."""
    strain = centre + phi * strips.height_m
    force = strips.core_m2 * core_concrete(column).stress_pa(strain)
    force += strips.cover_m2 * cover_concrete(column).stress_pa(strain)
    bar_strain = centre + phi * strips.bar_height_m
    bar = strips.bar_m2 * _bilinear(steel, bar_strain)
    bar -= strips.bar_m2 * core_concrete(column).stress_pa(bar_strain)  # displaced concrete
    axial = float(force.sum() + bar.sum())
    return axial, float((force * strips.height_m).sum() + (bar * strips.bar_height_m).sum())


def _bilinear(steel: Steel, strain: FloatArray) -> FloatArray:
    yield_strain = steel.yield_pa / steel.modulus_pa
    elastic = np.clip(strain, -yield_strain, yield_strain)
    return steel.modulus_pa * (elastic + steel.hardening_ratio * (strain - elastic))


def _centre_strain(
    strips: _Strips, column: ColumnData, steel: Steel, phi: float, axial_n: float
) -> float:
    def unbalance(centre: float) -> float:
        return _resultants(strips, column, steel, centre, phi)[0] - axial_n

    half = phi * column.diameter_m / 2
    # between every fiber well in tension and the face at the peak of the confined curve
    return float(brentq(unbalance, -half - 0.02, 0.002 + half, xtol=1e-10))


def _is_ultimate(
    strips: _Strips, column: ColumnData, steel: Steel, centre: float, phi: float
) -> bool:
    core_face = centre + phi * column.hoop_circle_m / 2
    tension = phi * float(strips.bar_height_m.max()) - centre
    return core_face >= core_concrete(column).ultimate_strain or tension >= steel.rupture_strain


def _bar_tension(strips: _Strips, curvature: FloatArray, axis_offset: FloatArray) -> FloatArray:
    """Tension strain of the farthest bar; ``axis_offset`` is centre strain over curvature."""
    return curvature * (float(strips.bar_height_m.max()) - axis_offset)
