"""Shear strength of circular columns, as functions of axial force and ductility.

All functions take scalars or arrays of one shape and return the strength in N without a resistance
factor, so that a whole history can be evaluated at once.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from skewbridge.bridge.section import FloatArray
from skewbridge.units import KSI, MPA, PSI
from skewbridge.variant.options import ShearModel


@dataclass(frozen=True, slots=True, kw_only=True)
class ShearSection:
    """Parameters of the shear strength of a circular column.

    Core and cover end at the hoop centre line; strengths are the specified ones unless expected.
    The neutral axis is that of the idealised flexural strength under dead load.
    """

    diameter_m: float
    core_diameter_m: float
    cover_m: float
    hoop_area_m2: float
    hoop_spacing_m: float
    hoop_yield_pa: float
    concrete_strength_pa: float
    expected_hoop_yield_pa: float
    expected_concrete_strength_pa: float
    longitudinal_ratio: float
    shear_span_m: float
    neutral_axis_depth_m: float

    @property
    def gross_area_m2(self) -> float:
        """Area of the whole section."""
        return np.pi * self.diameter_m**2 / 4

    @property
    def as_expected(self) -> "ShearSection":
        """The section with the expected strengths in place of the specified ones."""
        return replace(
            self,
            hoop_yield_pa=self.expected_hoop_yield_pa,
            concrete_strength_pa=self.expected_concrete_strength_pa,
        )


def shear_strength(
    section: ShearSection,
    model: ShearModel,
    axial_n: ArrayLike,
    displacement_ductility: ArrayLike,
    curvature_ductility: ArrayLike,
) -> FloatArray:
    """Return the strength by a model, which takes one of the two ductilities."""
    if model == "kowalsky_priestley":
        return kowalsky_priestley_strength(section, axial_n, curvature_ductility)
    taken = section.as_expected if model == "sdc_expected" else section
    return sdc_shear_strength(taken, axial_n, displacement_ductility)


def sdc_shear_strength(
    section: ShearSection,
    axial_n: ArrayLike,
    displacement_ductility: ArrayLike,
) -> FloatArray:
    """Return Vc + Vs of the Caltrans criteria in a plastic hinge, with the specified strengths.

    Compression is positive; under tension the share of the concrete falls with the factor
    exp(P / (500 psi A)). A local displacement ductility demand below 1 counts as 1. The strength
    has the broadcast shape of the arguments.

    References:
        Caltrans Seismic Design Criteria 1.7 section 3.6, 2.0 section 5.3.7; they drop the concrete
        at the first tension. ATC-32 (1996), as in Kowalsky and Priestley (2000), eq. 2: 1 +
        P / (500 psi A) under tension.
    """
    axial = np.asarray(axial_n, dtype=np.float64)
    ductility = np.maximum(np.asarray(displacement_ductility, dtype=np.float64), 1.0)
    hoops = 4 * section.hoop_area_m2 / (section.core_diameter_m * section.hoop_spacing_m)
    hoop_pressure_ksi = min(hoops * section.hoop_yield_pa / KSI, 0.35)
    factor_1 = np.clip(hoop_pressure_ksi / 0.150 + 3.67 - ductility, 0.3, 3.0)
    gross = section.gross_area_m2
    stress = axial / gross / PSI
    # ASSUME tension starts to weaken the concrete as in ATC-32 and ends it gradually: the straight
    # line leaves a column with few hoops a capacity that no small change of the force may touch
    factor_2 = np.where(
        stress < 0.0,
        np.exp(np.minimum(stress, 0.0) / 500.0),
        np.minimum(1.0 + stress / 2000.0, 1.5),
    )
    root = np.sqrt(section.concrete_strength_pa / PSI)  # the criteria are written in psi
    stress_psi = np.minimum(factor_1 * factor_2 * root, 4.0 * root)
    effective = 0.8 * gross
    hoops_n = min(hoop_strength_n(section), 8.0 * root * PSI * effective)
    return stress_psi * PSI * effective + hoops_n


def hoop_strength_n(section: ShearSection) -> float:
    """Return Vs = pi/2 A_b f_yh D' / s of a circular column."""
    force_n = (np.pi / 2) * section.hoop_area_m2 * section.hoop_yield_pa
    return force_n * section.core_diameter_m / section.hoop_spacing_m


def kowalsky_priestley_strength(
    section: ShearSection, axial_n: ArrayLike, curvature_ductility: ArrayLike
) -> FloatArray:
    """Return the revised UCSD shear strength of a circular column, with expected materials.

    The axial force is positive in compression; the strength in N has the broadcast shape of the
    arguments.

    References:
        Kowalsky and Priestley (2000), ACI Structural Journal 97(3), 388-396: single curvature,
        crack angle 30 degrees.
    """
    axial = np.asarray(axial_n, dtype=np.float64)
    ductility = np.asarray(curvature_ductility, dtype=np.float64)
    aspect = np.clip(3.0 - section.shear_span_m / section.diameter_m, 1.0, 1.5)
    steel = min(0.5 + 20.0 * section.longitudinal_ratio, 1.0)
    degraded = np.interp(ductility, [3.0, 15.0], [0.29, 0.05])
    root_mpa = np.sqrt(section.expected_concrete_strength_pa / MPA)
    concrete = aspect * steel * degraded * root_mpa * MPA * 0.8 * section.gross_area_m2
    depth = section.diameter_m - section.neutral_axis_depth_m
    hoop_n = (np.pi / 2) * section.hoop_area_m2 * section.expected_hoop_yield_pa
    truss = hoop_n * (depth - section.cover_m) / np.tan(np.radians(30.0)) / section.hoop_spacing_m
    strut = np.maximum(axial, 0.0) * depth / (2.0 * section.shear_span_m)
    return concrete + truss + strut
