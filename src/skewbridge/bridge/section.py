"""Column section without OpenSees: materials, moment-curvature and shear strength."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from skewbridge.bridge.catalogue.columns import ColumnData, FloatArray
from skewbridge.errors import InputError
from skewbridge.units import GPA, KN, KSI, MPA, PSI
from skewbridge.variant.options import ShearModel

STRIPS = 160  # across the section; half as many change moments by less than 0.1 %
POINTS = 120  # of a moment-curvature curve, up to the largest curvature tried
STRAIN_TOLERANCE = 1e-10


def shear_modulus_pa(modulus_pa: float) -> float:
    """Return the shear modulus E / 2.4 in Pa (Poisson's ratio 0.2)."""
    return modulus_pa / 2.4


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Reinforcing steel with its expected strength, bilinear up to the rupture strain."""

    yield_pa: float
    modulus_pa: float = 200e9
    hardening_ratio: float = 0.01  # source: 1 % is usual
    rupture_strain: float = 0.06  # source: Caltrans SDC 1.7 section 3.2.3, #11 and larger


STEELS: Final = {
    # source: Caltrans SDC 1.7 section 3.2.3, expected A706 values
    "a706": Steel(yield_pa=469e6),
    # source: Caltrans SDC 1.7 table 3.2.1 older bars: expected 1.2 times the nominal 276 MPa
    "grade40": Steel(yield_pa=331e6),
    # source: PyPBEE examples, bridges A-C: A706 with mean properties
    "kaviani": Steel(yield_pa=476.7e6, modulus_pa=201.3e9),
}


# source: Caltrans SDC 1.7 section 3.2.3, reduced ultimate strain of #10 (32.3 mm) and smaller bars
THIN_BAR_STRAIN = 0.09
LARGEST_THIN_BAR_MM = 32.5


def steel_of(column: ColumnData) -> Steel:
    """Return the reinforcing steel of a column."""
    steel = STEELS[column.steel]
    is_thin = column.bar_diameter_mm <= LARGEST_THIN_BAR_MM
    return replace(
        steel,
        yield_pa=column.steel_strength_factor * steel.yield_pa,
        rupture_strain=THIN_BAR_STRAIN if is_thin else steel.rupture_strain,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Concrete:
    """Stress-strain curve of Mander's model (Popovics), positive in compression.

    ``modulus_pa`` is the initial tangent; the curve ends at spalling or first hoop rupture.
    """

    peak_pa: float
    peak_strain: float
    modulus_pa: float
    ultimate_strain: float

    def stress_pa(self, strain: ArrayLike) -> FloatArray:
        """Return the stress in Pa; it is zero in tension and above the ultimate strain.

        References:
            Mander, Priestley and Park (1988), J. Struct. Eng. 114(8), 1804-1826, eq. 3-6.
        """
        ratio = np.maximum(np.asarray(strain, dtype=np.float64), 0.0) / self.peak_strain
        secant = self.peak_pa / self.peak_strain
        power = self.modulus_pa / (self.modulus_pa - secant)
        curve = self.peak_pa * ratio * power / (power - 1.0 + ratio**power)
        return np.where(ratio * self.peak_strain > self.ultimate_strain, 0.0, curve)


def cover_concrete(column: ColumnData) -> Concrete:
    """Return the unconfined concrete with its expected strength."""
    return Concrete(
        peak_pa=column.expected_concrete_strength_mpa * MPA,
        peak_strain=0.002,  # source: SDC 1.7 section 3.2.6
        modulus_pa=column.elastic_modulus_gpa * GPA,
        ultimate_strain=0.005,  # source: SDC 1.7 section 3.2.6
    )


def core_concrete(column: ColumnData) -> Concrete:
    """Return the concrete confined by hoops with expected yield strength, after Mander.

    Ultimate strain by the simplified energy balance: 0.004 + 1.4 rho_s f_yh eps_su / f_cc.

    References:
        Mander, Priestley and Park (1988), eq. 5; Priestley, Seible and Calvi (1996), Seismic Design
        and Retrofit of Bridges, eq. 5.14.
    """
    unconfined, hoops = cover_concrete(column), column.hoops
    yield_pa = steel_of(column).yield_pa
    pressure_ratios = [ratio * yield_pa / unconfined.peak_pa for ratio in hoops.confining]
    peak_pa = unconfined.peak_pa * confined_strength_ratio(
        min(pressure_ratios), max(pressure_ratios)
    )
    peak_strain = unconfined.peak_strain * (1.0 + 5.0 * (peak_pa / unconfined.peak_pa - 1.0))
    ultimate_strain = 0.004 + 1.4 * (hoops.volume_ratio * yield_pa) * THIN_BAR_STRAIN / peak_pa
    return Concrete(
        peak_pa=peak_pa,
        peak_strain=peak_strain,
        modulus_pa=unconfined.modulus_pa,
        ultimate_strain=max(ultimate_strain, peak_strain),
    )


def confined_strength_ratio(lowest: float, highest: float) -> float:
    """Return confined / unconfined strength from two lateral pressures / unconfined strength.

    References:
        Mander, Priestley and Park (1988), eq. 29, for equal pressures; Chang and Mander (1994),
        NCEER-94-0006, for unequal ones.
    """
    if lowest == highest:
        return float(-1.254 + 2.254 * np.sqrt(1.0 + 7.94 * highest) - 2.0 * highest)
    ratio, mean = lowest / highest, (lowest + highest) / 2
    factor_a = 6.8886 - (0.6069 + 17.275 * ratio) * np.exp(-4.989 * ratio)
    factor_b = 4.5 / (5.0 / factor_a * (0.9849 - 0.6306 * np.exp(-3.8939 * ratio)) - 0.1) - 5.0
    return float(1.0 + factor_a * mean * (0.1 + 0.9 / (1.0 + factor_b * mean)))


@dataclass(frozen=True, slots=True, kw_only=True)
class MomentCurvature:
    """Moment-curvature curve under constant axial force, up to the ultimate curvature.

    The idealised curve of equal area has its corner at the yield curvature and its plateau at the
    plastic moment; the neutral axis depth at the corner is from the compression face.
    """

    curvature_per_m: FloatArray
    moment_nm: FloatArray
    first_yield_curvature_per_m: float
    first_yield_moment_nm: float
    yield_curvature_per_m: float
    plastic_moment_nm: float
    ultimate_curvature_per_m: float
    neutral_axis_depth_m: float


@lru_cache(maxsize=32)
def section_response(column: ColumnData, axial_n: float, direction: int = 0) -> MomentCurvature:
    """Return the moment-curvature curve of a column, bent normal to the bent (0) or along it (1).

    References:
        Caltrans SDC 1.7 section 3.3.1 for the equal-area idealisation through the first yield.
    """
    from scipy.optimize import brentq  # its import takes longer than a short analysis

    section, size_m = _Section(column, direction), column.outline.sizes_m[direction]
    points: list[tuple[float, float, float, float]] = []
    for phi in np.geomspace(2e-5, 0.25, POINTS) / size_m:
        points.append(section.point(phi, axial_n))
        if points[-1][3] >= 0.0:
            if len(points) == 1:
                raise InputError(
                    f"a column carries {axial_n / KN:.0f} kN, more than its section can: "
                    "check the weights and the column of the bridge file"
                )
            ultimate = brentq(lambda phi: section.point(phi, axial_n)[3], points[-2][0], phi)
            points[-1] = section.point(float(ultimate), axial_n)
            break
    curvature, moment, neutral_depth_m, _ = np.array(points).T
    # of the bar farthest from the neutral axis, in compression under large axial forces
    strain = curvature * (section.highest_bar_m + np.abs(neutral_depth_m - size_m / 2))
    first_yield = float(np.interp(section.yield_strain, strain, curvature))
    first_moment = float(np.interp(first_yield, curvature, moment))
    stiffness = first_moment / first_yield
    whole_curve = np.concatenate(([0.0], curvature)), np.concatenate(([0.0], moment))
    area = np.trapezoid(whole_curve[1], whole_curve[0])
    # area = Mp phi_u - Mp^2 / (2 k): the smaller root is the plateau
    ultimate = curvature[-1]
    plateau = stiffness * (ultimate - np.sqrt(ultimate**2 - 2 * area / stiffness))
    yield_curvature = float(plateau / stiffness)
    return MomentCurvature(
        curvature_per_m=whole_curve[0],
        moment_nm=whole_curve[1],
        first_yield_curvature_per_m=first_yield,
        first_yield_moment_nm=first_moment,
        yield_curvature_per_m=yield_curvature,
        plastic_moment_nm=float(plateau),
        ultimate_curvature_per_m=float(ultimate),
        neutral_axis_depth_m=float(np.interp(yield_curvature, curvature, neutral_depth_m)),
    )


class _Section:
    """Strips of core and cover parallel to the neutral axis, and bars; compression at the top."""

    def __init__(self, column: ColumnData, direction: int) -> None:
        self._core, self._cover = core_concrete(column), cover_concrete(column)
        self._steel = steel_of(column)
        outline, core = column.outline, column.core
        self._half_m, self._core_half_m = (line.sizes_m[direction] / 2 for line in (outline, core))
        edges = np.linspace(-self._half_m, self._half_m, STRIPS + 1)
        self._height_m = (edges[1:] + edges[:-1]) / 2
        self._core_m2 = np.diff(core.area_below(direction, edges))
        self._cover_m2 = np.diff(outline.area_below(direction, edges)) - self._core_m2
        self._bar_height_m = column.bars_m[:, 1 - direction]
        self._bar_m2 = column.bar_area_mm2 * 1e-6
        self.highest_bar_m = float(self._bar_height_m.max())
        self.yield_strain = self._steel.yield_pa / self._steel.modulus_pa

    def resultants(self, centre: float, phi: float) -> tuple[float, float]:
        """Return axial force (N) and moment (N m) at a strain of the centre and curvature (1/m)."""
        strain = centre + phi * self._height_m
        core_n = self._core_m2 * self._core.stress_pa(strain)
        core_n += self._cover_m2 * self._cover.stress_pa(strain)
        bar_strain = centre + phi * self._bar_height_m
        elastic = np.clip(bar_strain, -self.yield_strain, self.yield_strain)
        hardening = self._steel.hardening_ratio * (bar_strain - elastic)
        bar_n = self._bar_m2 * (self._steel.modulus_pa * (elastic + hardening))
        bar_n -= self._bar_m2 * self._core.stress_pa(bar_strain)  # displaced concrete
        axial = float(core_n.sum() + bar_n.sum())
        return axial, float((core_n * self._height_m).sum() + (bar_n * self._bar_height_m).sum())

    def point(self, phi: float, axial_n: float) -> tuple[float, float, float, float]:
        """Return curvature, moment, neutral axis depth, and a positive number after failure.

        The section fails at an ultimate strain, or when it cannot carry the axial force.
        """
        centre, missing_n = self._centre_strain(phi, axial_n)
        core = centre + phi * self._core_half_m - self._core.ultimate_strain
        bar = phi * self.highest_bar_m - centre - self._steel.rupture_strain
        depth_m = self._half_m + centre / phi
        return phi, self.resultants(centre, phi)[1], depth_m, max(core, bar, missing_n)

    def _centre_strain(self, phi: float, axial_n: float) -> tuple[float, float]:
        """Return the strain of the centre that balances a force, and the missing force if none."""
        from scipy.optimize import brentq

        half_strain = phi * self._half_m
        # from all strains below -0.02 (tension) to all strains above 0.002
        lowest, highest = -half_strain - 0.02, 0.002 + half_strain

        def excess_n(centre: float) -> float:
            return self.resultants(centre, phi)[0] - axial_n

        if excess_n(highest) < 0.0:  # with few bars, a section softens before the upper limit
            highest = max(np.linspace(lowest, highest, STRIPS).tolist(), key=excess_n)
        for limit, missing_n in ((lowest, excess_n(lowest)), (highest, -excess_n(highest))):
            if missing_n > 0.0:
                return limit, missing_n
        return float(brentq(excess_n, lowest, highest, xtol=STRAIN_TOLERANCE)), -np.inf


# --- shear strength in one direction, without a resistance factor


@dataclass(frozen=True, slots=True, kw_only=True)
class ShearSection:
    """Inputs of the shear strength of a column in one direction.

    ``hoop_area_m2`` x yield x ``hoop_depth_m`` / spacing is the force across a crack of 45 degrees:
    pi/2 A_b and D' for a circle, all legs and the effective depth for a rectangle. Strengths are
    specified ones unless ``expected``; the neutral axis depth is at yield under dead load.
    """

    depth_m: float
    gross_area_m2: float
    cover_m: float
    hoop_area_m2: float
    hoop_depth_m: float
    hoop_ratio: float
    hoop_spacing_m: float
    hoop_yield_pa: float
    concrete_strength_pa: float
    expected_hoop_yield_pa: float
    expected_concrete_strength_pa: float
    longitudinal_ratio: float
    shear_span_m: float
    neutral_axis_depth_m: float

    @property
    def as_expected(self) -> "ShearSection":
        """The section with expected instead of specified strengths."""
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
    """Return the shear strength in N; each model uses one of the two ductilities."""
    if model == "ucsd_tests":
        return MEASURED_OVER_UCSD * kowalsky_priestley_strength(
            section, axial_n, displacement_ductility, UCSD_DISPLACEMENT_DUCTILITIES
        )
    if model == "kowalsky_priestley":
        return kowalsky_priestley_strength(section, axial_n, curvature_ductility)
    inputs = section.as_expected if model == "sdc_expected" else section
    return sdc_shear_strength(inputs, axial_n, displacement_ductility)


def sdc_shear_strength(
    section: ShearSection, axial_n: ArrayLike, displacement_ductility: ArrayLike
) -> FloatArray:
    """Return the Caltrans shear strength Vc + Vs of a plastic hinge in N, from specified strengths.

    Compression is positive. Under a tension P, Vc is multiplied by exp(P / (500 psi A)).

    References:
        Caltrans Seismic Design Criteria 1.7 section 3.6 and 2.0 section 5.3.7 (both: no Vc under
        tension); rectangles: AASHTO Guide Specifications for LRFD Seismic Bridge Design
        8.6.2-8.6.3. ATC-32 (1996), quoted by Kowalsky and Priestley (2000), eq. 2: factor 1 + P /
        (500 psi A).
    """
    force_n = np.asarray(axial_n, dtype=np.float64)
    ductility = np.maximum(np.asarray(displacement_ductility, dtype=np.float64), 1.0)
    hoop_pressure_ksi = min(section.hoop_ratio * section.hoop_yield_pa / KSI, 0.35)
    factor_1 = np.clip(hoop_pressure_ksi / 0.150 + 3.67 - ductility, 0.3, 3.0)
    gross_m2 = section.gross_area_m2
    axial_psi = force_n / gross_m2 / PSI
    # ASSUME tension reduces Vc at first as in ATC-32, then exponentially: with its straight line Vc
    # reaches zero, and a column with few hoops keeps almost no capacity
    factor_2 = np.where(
        axial_psi < 0.0,
        np.exp(np.minimum(axial_psi, 0.0) / 500.0),
        np.minimum(1.0 + axial_psi / 2000.0, 1.5),
    )
    root_psi = np.sqrt(section.concrete_strength_pa / PSI)  # the criteria are written in psi
    stress_psi = np.minimum(factor_1 * factor_2 * root_psi, 4.0 * root_psi)
    effective_m2 = 0.8 * gross_m2
    hoops_n = min(hoop_strength_n(section), 8.0 * root_psi * PSI * effective_m2)
    return stress_psi * PSI * effective_m2 + hoops_n


def hoop_strength_n(section: ShearSection) -> float:
    """Return Vs = A f_yh d / s in N, with A = pi/2 A_b and d = D' for a circular column."""
    force_n = section.hoop_area_m2 * section.hoop_yield_pa
    return force_n * section.hoop_depth_m / section.hoop_spacing_m


#: Mean ratio of measured to computed shear strength (`kowalsky_priestley_strength`, undegraded) of
#: 33 circular columns that failed in shear; its coefficient of variation is 0.14. For the Caltrans
#: strength the mean is 1.40 and the coefficient 0.20.
#: source: ACI 369 circular column database (Ghannoum and Sivaramakrishnan 2012); the test
#: `test_default_shear_strength_is_the_mean_of_tests` has the columns and repeats the calculation
# ASSUME the same mean for rectangles
MEASURED_OVER_UCSD: Final = 0.99
#: Displacement ductilities between which the concrete contribution decreases.
#: source: CUMBIA (Montejo and Kowalsky 2007), assessment: 0.37 - 0.04 mu, between 0.29 and 0.05
# ASSUME loading in one direction, as in the tests; in two it decreases from 1 to 7 (same source)
UCSD_DISPLACEMENT_DUCTILITIES: Final = (2.0, 8.0)


def kowalsky_priestley_strength(
    section: ShearSection,
    axial_n: ArrayLike,
    ductility: ArrayLike,
    degrades_between: tuple[float, float] = (3.0, 15.0),
) -> FloatArray:
    """Return the revised UCSD shear strength (N) of a column of expected strength.

    The concrete contribution decreases between two ductilities (default: of curvature).

    References:
        Kowalsky and Priestley (2000), ACI Structural Journal 97(3), 388-396, single curvature and
        cracks at 30 degrees; Priestley, Verma and Xiao (1994), J. Struct. Eng. 120(8), 2310-2329,
        for rectangles.
    """
    axial = np.asarray(axial_n, dtype=np.float64)
    alpha = np.clip(3.0 - section.shear_span_m / section.depth_m, 1.0, 1.5)
    beta = min(0.5 + 20.0 * section.longitudinal_ratio, 1.0)
    gamma = np.interp(np.asarray(ductility, dtype=np.float64), degrades_between, (0.29, 0.05))
    root_mpa = np.sqrt(section.expected_concrete_strength_pa / MPA)
    concrete = alpha * beta * gamma * root_mpa * MPA * 0.8 * section.gross_area_m2
    depth = section.depth_m - section.neutral_axis_depth_m
    hoop_n = section.hoop_area_m2 * section.expected_hoop_yield_pa
    truss = hoop_n * (depth - section.cover_m) / np.tan(np.radians(30.0)) / section.hoop_spacing_m
    strut = np.maximum(axial, 0.0) * depth / (2.0 * section.shear_span_m)
    return concrete + truss + strut
