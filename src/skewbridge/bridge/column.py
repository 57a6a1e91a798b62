"""Reinforced concrete columns: fiber sections, elements, and the data to judge them."""

from math import ceil, cos, pi, sin, sqrt

import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BridgeData, ColumnData
from skewbridge.bridge.dead_load import column_axial_n
from skewbridge.bridge.fibers import (
    bar_material,
    concrete_material,
    core_materials,
    lasting_core_material,
)
from skewbridge.bridge.handles import ColumnHandle
from skewbridge.bridge.hinge import bent_capacity, hinge_length_m, shear_span_m
from skewbridge.bridge.materials import STEELS, cover_concrete
from skewbridge.bridge.moment_curvature import MomentCurvature, section_response
from skewbridge.bridge.shear_capacity import ShearSection
from skewbridge.bridge.shear_failure import build_shear_section, shear_loss
from skewbridge.bridge.tags import TagAllocator
from skewbridge.errors import InputError
from skewbridge.units import GPA, MM, MPA
from skewbridge.variant.options import ModelOptions

LOBATTO_POINTS = 5  # source: usual choice for force-based columns; the paper gives no number
HINGE_RADAU_SECTIONS = 6  # OpenSees numbers the points of HingeRadau 1 to 6


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
        # a fifth of the strength: half of the rings and wedges resolve it as well
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

    A fiber stands where its ring keeps its second moment of area, so that a coarse mesh is as
    stiff as a fine one. Rings inside have fewer fibers, in proportion to their radius and alike in
    all four quarters.
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
    inertia, polar = _cracked_inertias_m4(column)
    shear = shear_modulus_pa(modulus)
    ops.section("Elastic", section, modulus, area, inertia, inertia, shear, polar)
    return section


def _cracked_inertias_m4(column: ColumnData) -> tuple[float, float]:
    """Return the cracked second moment of area and torsion constant."""
    gross = gross_inertia_m4(column)
    return column.cracked_stiffness_ratio * gross, column.torsion_ratio * 2 * gross


def build_integration(
    bridge: BridgeData, bent_number: int, options: ModelOptions, tags: TagAllocator
) -> tuple[int, tuple[int, ...]]:
    """Create the beam integration shared by the columns of a bent, numbered from 0.

    A pinned base never yields, so its hinge carries the elastic section (no change of demands).
    A loss of shear strength is that of the top section.

    Returns:
        Tag, and the integration points where plastic curvature is read.

    Raises:
        InputError: Distributed plasticity with a loss of shear strength, which needs a hinge.
    """
    column, is_pinned = bridge.column, bridge.base == "pinned"
    fiber = build_fiber_section(column, options, tags)
    integration = tags.integration()
    if options.column_integration == "lobatto5":
        if options.shear_failure == "degrade":
            raise InputError("option shear_failure: degrade needs column_integration hinge_radau")
        ops.beamIntegration("Lobatto", integration, fiber, LOBATTO_POINTS)
        return integration, (LOBATTO_POINTS,) if is_pinned else (1, LOBATTO_POINTS)
    elastic = build_elastic_section(column, tags)
    length = hinge_length_m(bridge, bent_number, options.hinge_rule)
    base, top = elastic if is_pinned else fiber, fiber
    if options.shear_failure == "degrade":
        section = column_shear_section(bridge, bent_number)
        loss = shear_loss(bridge, bent_number, section, options.hinge_rule)
        top = build_shear_section(fiber, loss, length, tags)
    ops.beamIntegration("HingeRadau", integration, base, length, top, length, elastic)
    return integration, (HINGE_RADAU_SECTIONS,) if is_pinned else (1, HINGE_RADAU_SECTIONS)


def build_elastic_column(
    column: ColumnData, nodes: tuple[int, int], transformation: int, tags: TagAllocator
) -> int:
    """Create a cracked elastic column and return its tag."""
    element = tags.element()
    modulus = column.elastic_modulus_gpa * GPA
    inertia, polar = _cracked_inertias_m4(column)
    section = (column.gross_area_m2, modulus, shear_modulus_pa(modulus), polar, inertia, inertia)
    ops.element("elasticBeamColumn", element, *nodes, *section, transformation)
    return element


def column_handle(
    bridge: BridgeData,
    bent_number: int,
    *,
    element: int,
    nodes: tuple[int, int],
    hinge_sections: tuple[int, ...],
    options: ModelOptions,
) -> ColumnHandle:
    """Return the handle of a column with its yield point and shear data."""
    column, capacity = bridge.column, bent_capacity(bridge, bent_number, options.hinge_rule)
    curve = section_response(column, column_axial_n(bridge, bent_number))
    height = bridge.bents[bent_number].clear_height_m
    return ColumnHandle(
        element=element,
        base_node=nodes[0],
        top_node=nodes[1],
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
    """Return what the shear strength of the columns of a bent, numbered from 0, depends on."""
    curve = section_response(bridge.column, column_axial_n(bridge, bent_number))
    return shear_section(bridge.column, shear_span_m(bridge, bent_number), curve)


def shear_section(column: ColumnData, span_m: float, curve: MomentCurvature) -> ShearSection:
    """Return what the shear strength of a column depends on."""
    gross = column.gross_area_m2
    return ShearSection(
        diameter_m=column.diameter_m,
        core_diameter_m=column.hoop_circle_m,
        cover_m=column.cover_to_hoop_m + column.hoop_diameter_mm * MM / 2,
        hoop_area_m2=column.hoop_area_mm2 * MM**2,
        hoop_spacing_m=column.hoop_spacing_mm * MM,
        hoop_yield_pa=column.hoop_yield_mpa * MPA,
        concrete_strength_pa=column.concrete_strength_mpa * MPA,
        expected_hoop_yield_pa=STEELS[column.steel].yield_pa,
        expected_concrete_strength_pa=column.expected_concrete_strength_mpa * MPA,
        longitudinal_ratio=column.bar_count * column.bar_area_mm2 * MM**2 / gross,
        shear_span_m=span_m,
        neutral_axis_depth_m=curve.neutral_axis_depth_m,
    )
