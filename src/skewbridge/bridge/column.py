"""Reinforced concrete columns: fibers, sections, elements, shear failure and capacity data."""

from dataclasses import dataclass, replace
from math import ceil, cos, pi, radians, sin, sqrt, tan

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BridgeData, ColumnData
from skewbridge.bridge.gravity import column_axial_n
from skewbridge.bridge.handles import ColumnHandle, Point, TagAllocator
from skewbridge.bridge.hinge import bent_capacity, hinge_length_m, shear_span_m
from skewbridge.bridge.materials import Concrete, core_concrete, cover_concrete, steel_of
from skewbridge.bridge.moment_curvature import MomentCurvature, section_response
from skewbridge.bridge.shear_capacity import ShearSection, hoop_strength_n, shear_strength
from skewbridge.errors import InputError
from skewbridge.units import GPA, MM, MPA
from skewbridge.variant.options import HingeRule, ModelOptions, ShearModel

# source: Kent and Park (1971), J. Struct. Div. ASCE 97(7), 1969-1990: crushed core keeps 0.2 fc
RESIDUAL_CORE = 0.2


def core_materials(column: ColumnData, tags: TagAllocator) -> tuple[int, int]:
    """Create confined concrete that crushes, as two parallel materials; return their tags.

    Once its strain has passed the ultimate strain of Mander's energy balance (the first hoop
    breaks), a fiber keeps 0.2 of its strength at any strain. The first material is the part that
    is lost, the second the part that remains.
    """
    core = core_concrete(column)
    crushed_pa = float(core.stress_pa(core.ultimate_strain))
    kept_pa = RESIDUAL_CORE * core.peak_pa
    kept = concrete_material(_part(core, RESIDUAL_CORE), kept_pa, tags)
    lost = concrete_material(_part(core, 1.0 - RESIDUAL_CORE), crushed_pa - kept_pa, tags)
    ended = tags.material()
    ops.uniaxialMaterial("MinMax", ended, lost, "-min", -core.ultimate_strain)
    return ended, kept


def lasting_core_material(column: ColumnData, tags: TagAllocator) -> int:
    """Create confined concrete that never crushes and return its tag."""
    core = core_concrete(column)
    return concrete_material(core, float(core.stress_pa(core.ultimate_strain)), tags)


def bar_material(column: ColumnData, tags: TagAllocator, *, has_end: bool) -> int:
    """Create the longitudinal bars and return the tag of their material.

    With ``has_end``, a bar breaks at the reduced ultimate tensile strain and buckles at the strain
    that breaks the hoops; a broken or buckled bar carries no force.
    """
    steel = steel_of(column)
    material = tags.material()
    backbone = (steel.yield_pa, steel.modulus_pa, steel.hardening_ratio)
    # source: transition parameters recommended in the OpenSees manual for Steel02
    ops.uniaxialMaterial("Steel02", material, *backbone, 18.5, 0.925, 0.15)
    if not has_end:
        return material
    ended = tags.material()
    # ASSUME bars are held by the hoops as long as the core is, and buckle at once without them
    limits = ("-min", -core_concrete(column).ultimate_strain, "-max", steel.rupture_strain)
    ops.uniaxialMaterial("MinMax", ended, material, *limits)
    return ended


def concrete_material(concrete: Concrete, crushed_pa: float, tags: TagAllocator) -> int:
    """Create Concrete01 with the strength, initial modulus and ultimate strain of a Mander curve.

    The initial slope of its parabola is twice the strength over the peak strain, and the peak
    strain is chosen to match the initial modulus. The parabola is then above the Mander curve by
    less than 8 % of the strength.
    """
    material = tags.material()
    # ASSUME the initial stiffness matters more than the strain at the peak
    peak_strain = 2 * concrete.peak_pa / concrete.modulus_pa
    points = (-concrete.peak_pa, -peak_strain, -crushed_pa, -concrete.ultimate_strain)
    ops.uniaxialMaterial("Concrete01", material, *points)
    return material


def _part(concrete: Concrete, share: float) -> Concrete:
    """Return a concrete with a share of the strength and stiffness at the same strains."""
    return replace(
        concrete, peak_pa=share * concrete.peak_pa, modulus_pa=share * concrete.modulus_pa
    )


CRACK_ANGLE_DEG = 65.0  # source: Elwood and Moehle (2005)
SHEAR_AREA_RATIO = 0.8  # source: Caltrans SDC 1.7 section 3.6.2, effective over gross area
# ASSUME a broken column keeps a tenth of its shear strength: friction and hoops across the crack
RESIDUAL_SHEAR = 0.1
PLATEAU = 100.0  # length of the residual branch, in times the deformation where it starts
# ASSUME pinched loops: on reloading, 0.5 of the deformation at 0.4 of the force
PINCHING = (0.5, 0.4)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShearLoss:
    """Backbone of the shear of a column, the same in all directions.

    Attributes:
        strength_n: Shear at which the column fails.
        elastic_m: Shear deformation of the whole column there.
        failure_drift_ratio: Flexural drift at which a monotonic push reaches the strength; the
            displacement capacity's if it never does.
        residual_m: Shear deformation at which the residual strength is reached.
    """

    strength_n: float
    elastic_m: float
    failure_drift_ratio: float
    residual_m: float


def shear_loss(
    bridge: BridgeData,
    bent_number: int,
    section: ShearSection,
    hinge_rule: HingeRule = "sdc",
    shear_model: ShearModel = "sdc_expected",
) -> ShearLoss:
    """Return the linear degradation of shear strength of a column of a bent (numbered from 0).

    The column fails where the shear of its flexural response, M(phi) over the shear span, reaches
    the capacity at the same ductility, under dead load. If it never does, the strength is the
    capacity at the ultimate curvature. From there the shear falls linearly to zero at the drift of
    axial failure, but not below the residual.

    References:
        Elwood and Moehle (2005), Earthquake Spectra 21(1), 71-89: drift at axial failure; Elwood
        (2004), Can. J. Civ. Eng. 31(5), 846-859: straight loss between the two drifts.
    """
    axial_n = column_axial_n(bridge, bent_number)
    curve = section_response(bridge.column, axial_n)
    span, height = shear_span_m(bridge, bent_number), bridge.bents[bent_number].clear_height_m
    hinge = hinge_length_m(bridge, bent_number, hinge_rule)
    yielded = curve.yield_curvature_per_m
    plastic = np.maximum(curve.curvature_per_m - yielded, 0.0)
    elastic_drift = np.minimum(curve.curvature_per_m, yielded) * span / 3
    drift = elastic_drift + plastic * hinge * (1.0 - hinge / 2 / span)
    ductilities = drift / (yielded * span / 3), curve.curvature_per_m / yielded
    capacity = shear_strength(section, shear_model, axial_n, *ductilities)
    shear = curve.moment_nm / span
    fails = shear >= capacity
    at = int(fails.argmax()) if fails.any() else -1
    strength = float(shear[at] if fails.any() else capacity[at])
    area_m2 = SHEAR_AREA_RATIO * section.gross_area_m2
    elastic_m = strength * height / (bridge.column.elastic_modulus_gpa * GPA / 2.4 * area_m2)
    lost_m = (axial_failure_drift(section, axial_n) - float(drift[at])) * height
    return ShearLoss(
        strength_n=strength,
        elastic_m=elastic_m,
        failure_drift_ratio=float(drift[at]),
        # never steeper than the elastic branch
        residual_m=elastic_m + (1.0 - RESIDUAL_SHEAR) * max(lost_m, elastic_m),
    )


def axial_failure_drift(section: ShearSection, axial_n: float) -> float:
    """Return the drift at which a column that failed in shear loses its axial load.

    References:
        Elwood and Moehle (2005), equation 3; the force of the hoops across a crack is
        pi/2 A_b f_yh, as in the shear strength of circular columns.
    """
    slope = tan(radians(CRACK_ANGLE_DEG))
    hoops_n = hoop_strength_n(section.as_expected)
    return 0.04 * (1.0 + slope**2) / (slope + axial_n / (hoops_n * slope))


def build_shear_section(fiber: int, loss: ShearLoss, tributary_m: float, tags: TagAllocator) -> int:
    """Add the shear response to the fiber section of a length of column; return the new tag.

    The two directions fail independently, so an oblique resultant can reach 1.41 times the
    strength.
    """
    material, section = tags.material(), tags.section()
    residual = RESIDUAL_SHEAR * loss.strength_n
    points = (
        (loss.strength_n, loss.elastic_m / tributary_m),
        (residual, loss.residual_m / tributary_m),
        (residual, PLATEAU * loss.residual_m / tributary_m),
    )
    branch = [value for point in points for value in point]
    opposite = [-value for value in branch]
    ops.uniaxialMaterial("Hysteretic", material, *branch, *opposite, *PINCHING, 0.0, 0.0)
    ops.section("Aggregator", section, material, "Vy", material, "Vz", "-section", fiber)
    return section


ELASTIC_POINTS = 3  # exact for an elastic column
LOBATTO_POINTS = 5  # source: usual choice for force-based columns; the paper gives no number
# Iterations and tolerance (work, J) of the equilibrium of a column between its sections; a
# thousandth of the tolerance changes no demand by 1e-8.
COLUMN_ITERATIONS = (10, 1.0e-2)


def shear_modulus_pa(modulus_pa: float) -> float:
    """Return E / 2.4 (Poisson's ratio 0.2)."""
    return modulus_pa / 2.4


def gross_inertia_m4(column: ColumnData) -> float:
    """Return the second moment of area of the gross section."""
    return pi * column.diameter_m**4 / 64


def build_fiber_section(column: ColumnData, options: ModelOptions, tags: TagAllocator) -> int:
    """Create the fiber section of a column and return its tag.

    Concrete01 for confined core and spalling cover, Steel02 for the bars; torsion is elastic.
    """
    has_end = options.fiber_end == "loss"
    cover_tag = concrete_material(cover_concrete(column), 0.0, tags)
    bar_tag = bar_material(column, tags, has_end=has_end)
    rings, wedges, cover_rings = options.column_fibers
    section = tags.section()
    shear = shear_modulus_pa(column.elastic_modulus_gpa * GPA)
    torsion_nm2 = column.torsion_ratio * shear * 2 * gross_inertia_m4(column)  # cracked
    ops.section("Fiber", section, "-GJ", torsion_nm2)
    core_m, radius_m = column.hoop_circle_m / 2, column.diameter_m / 2
    if has_end:
        ending, kept = core_materials(column, tags)
        _add_rings(ending, (0.0, core_m), rings, wedges)
        # this part has a fifth of the strength: half the rings and wedges are enough
        _add_rings(kept, (0.0, core_m), ceil(rings / 2), max(3, ceil(wedges / 2)))
    else:
        _add_rings(lasting_core_material(column, tags), (0.0, core_m), rings, wedges)
    _add_rings(cover_tag, (core_m, radius_m), cover_rings, wedges)
    steel_m2 = column.bar_count * column.bar_area_mm2 * MM**2
    bars = min(column.bar_count, wedges)
    _add_circle(bar_tag, column.bar_circle_m / 2, steel_m2, bars)
    return section


def _add_rings(material: int, radii_m: tuple[float, float], rings: int, wedges: int) -> None:
    """Fill a ring of the section with fibers, in rings of equal thickness.

    Each fiber is at the radius that preserves the second moment of area of its ring, so that a
    coarse mesh is as stiff as a fine one. Inner rings have fewer fibers, in proportion to their
    radius and the same in all four quadrants.
    """
    inner_m, outer_m = radii_m
    for ring in range(rings):
        low_m, high_m = (inner_m + (outer_m - inner_m) * edge / rings for edge in (ring, ring + 1))
        area_m2 = pi * (high_m**2 - low_m**2)
        count = min(wedges, max(8, 4 * ceil(wedges * high_m / outer_m / 4)))
        _add_circle(material, sqrt((low_m**2 + high_m**2) / 2), area_m2, count)


def _add_circle(material: int, radius_m: float, area_m2: float, count: int) -> None:
    """Put equal fibers on a circle."""
    for number in range(count):
        angle = 2 * pi * (number + 0.5) / count
        y, z = radius_m * cos(angle), radius_m * sin(angle)
        ops.fiber(y, z, area_m2 / count, material)


def build_elastic_section(column: ColumnData, tags: TagAllocator) -> int:
    """Create the cracked elastic section of a column and return its tag."""
    section = tags.section()
    modulus, area = column.elastic_modulus_gpa * GPA, column.gross_area_m2
    gross = gross_inertia_m4(column)
    inertia, polar = column.cracked_stiffness_ratio * gross, column.torsion_ratio * 2 * gross
    shear = shear_modulus_pa(modulus)
    ops.section("Elastic", section, modulus, area, inertia, inertia, shear, polar)
    return section


def build_integration(
    bridge: BridgeData, bent_number: int, options: ModelOptions, tags: TagAllocator
) -> tuple[int, tuple[int, ...]]:
    """Create the beam integration shared by the columns of a bent, numbered from 0.

    Plastic hinges are integrated as by HingeRadau. The sections between them are elastic, and so is
    the hinge at a pinned base, which never yields: `elastic_points` replaces them by two. The top
    section carries the loss of shear strength.

    Returns:
        Tag, and the integration points where plastic curvature is read; none if elastic.

    Raises:
        InputError: Distributed plasticity with a loss of shear strength, which needs a hinge.
    """
    column, is_pinned = bridge.column, bridge.base == "pinned"
    if options.elastic_columns:
        section, integration = build_elastic_section(column, tags), tags.integration()
        ops.beamIntegration("Lobatto", integration, section, ELASTIC_POINTS)
        return integration, ()
    fiber = build_fiber_section(column, options, tags)
    integration = tags.integration()
    if options.column_integration == "lobatto5":
        if options.shear_failure == "degrade":
            raise InputError("option shear_failure: degrade needs column_integration hinge_radau")
        ops.beamIntegration("Lobatto", integration, fiber, LOBATTO_POINTS)
        return integration, (LOBATTO_POINTS,) if is_pinned else (1, LOBATTO_POINTS)
    elastic = build_elastic_section(column, tags)
    length = hinge_length_m(bridge, bent_number, options.hinge_rule)
    top = fiber
    if options.shear_failure == "degrade":
        section = column_shear_section(bridge, bent_number)
        rules = options.hinge_rule, options.shear_model
        loss = shear_loss(bridge, bent_number, section, *rules)
        top = build_shear_section(fiber, loss, length, tags)
    ratio = length / bridge.bents[bent_number].clear_height_m
    places, weights = elastic_points(ratio, is_pinned=is_pinned)
    sections, ends = [elastic] * len(places), (len(places) + 1,)
    if not is_pinned:
        sections, places, weights = [fiber, *sections], [0.0, *places], [ratio, *weights]
        ends = (1, len(places) + 1)
    sections, places, weights = [*sections, top], [*places, 1.0], [*weights, ratio]
    rule = (len(sections), *sections, *places, *weights)
    ops.beamIntegration("UserDefined", integration, *rule)
    return integration, ends


def elastic_points(hinge_ratio: float, *, is_pinned: bool) -> tuple[list[float], list[float]]:
    """Return places and weights of the elastic sections of a column, over its height from the base.

    The flexibility of an elastic part is an integral of at most quadratic functions: two points
    with the first four moments of all elastic points of HingeRadau give the same.

    Args:
        hinge_ratio: Length of each plastic hinge over the height.
        is_pinned: Whether the hinge at the base is elastic as well.

    References:
        Scott and Fenves (2006), J. Struct. Eng. 132(2), 244-252: HingeRadau. Golub and Welsch
        (1969), Math. Comp. 23: Gauss rules from moments.
    """
    inner = 1.0 - 8.0 * hinge_ratio
    apart = inner / (2.0 * sqrt(3.0))
    third = 8.0 / 3.0 * hinge_ratio
    places = np.array([0.0, third, 0.5 - apart, 0.5 + apart, 1.0 - third])
    weights = np.array([hinge_ratio, 3.0 * hinge_ratio, inner / 2, inner / 2, 3.0 * hinge_ratio])
    if not is_pinned:
        places, weights = places[1:], weights[1:]
    moments = [float(weights @ places**power) for power in range(4)]
    hankel = [moments[:2], moments[1:3]]
    roots = np.roots([1.0, *np.linalg.solve(hankel, [-moments[2], -moments[3]])[::-1]])
    if np.iscomplexobj(roots) or not ((roots > 0.0) & (roots < 1.0)).all():
        return places.tolist(), weights.tolist()  # hinges so long that the rule has no two points
    two = np.sort(roots)
    shares = np.linalg.solve([[1.0, 1.0], two.tolist()], moments[:2])
    return two.tolist(), shares.tolist()


def column_handle(
    bridge: BridgeData,
    bent_number: int,
    *,
    element: int,
    base_node: int,
    top: Point,
    hinge_sections: tuple[int, ...],
    options: ModelOptions,
) -> ColumnHandle:
    """Return the handle of a column with its yield point and shear data."""
    column, capacity = bridge.column, bent_capacity(bridge, bent_number, options.hinge_rule)
    curve = section_response(column, column_axial_n(bridge, bent_number))
    height = bridge.bents[bent_number].clear_height_m
    return ColumnHandle(
        element=element,
        base_node=base_node,
        top=top,
        clear_height_m=height,
        hinge_sections=hinge_sections,
        yield_curvature_per_m=curve.yield_curvature_per_m,
        yield_drift_ratio=capacity.yield_disp_m / height,
        drift_capacity_ratio=capacity.capacity_m / height,
        shear=column_shear_section(bridge, bent_number),
        shear_model=options.shear_model,
        is_elastic=options.elastic_columns,
        loses_shear_strength=options.shear_failure == "degrade",
    )


def column_shear_section(bridge: BridgeData, bent_number: int) -> ShearSection:
    """Return the shear data of the columns of a bent (numbered from 0)."""
    curve = section_response(bridge.column, column_axial_n(bridge, bent_number))
    return shear_section(bridge.column, shear_span_m(bridge, bent_number), curve)


def shear_section(column: ColumnData, span_m: float, curve: MomentCurvature) -> ShearSection:
    """Return the shear data of a column with a shear span and a moment-curvature."""
    gross = column.gross_area_m2
    return ShearSection(
        diameter_m=column.diameter_m,
        core_diameter_m=column.hoop_circle_m,
        cover_m=column.cover_to_hoop_m + column.hoop_diameter_mm * MM / 2,
        hoop_area_m2=column.hoop_area_mm2 * MM**2,
        hoop_spacing_m=column.hoop_spacing_mm * MM,
        hoop_yield_pa=column.hoop_yield_mpa * MPA,
        concrete_strength_pa=column.concrete_strength_mpa * MPA,
        expected_hoop_yield_pa=steel_of(column).yield_pa,
        expected_concrete_strength_pa=column.expected_concrete_strength_mpa * MPA,
        longitudinal_ratio=column.bar_count * column.bar_area_mm2 * MM**2 / gross,
        shear_span_m=span_m,
        neutral_axis_depth_m=curve.neutral_axis_depth_m,
    )
