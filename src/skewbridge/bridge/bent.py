"""Bents of the model: integral caps, fiber columns, bases and foundation springs.

A bent may be skewed like the abutments. Cap, columns, their sections and the springs below them
turn with it: the first axis of a bent is normal to it, the second along it.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, cos, radians, sin, sqrt

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.catalogue.columns import ColumnData
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.catalogue.drawing import is_concrete
from skewbridge.bridge.column import RESIDUAL_SHEAR, BentCapacity, bent_directions, shear_loss
from skewbridge.bridge.handles import ColumnCapacity, ColumnHandle, Point, TagAllocator
from skewbridge.bridge.plan import PlanVector, turned
from skewbridge.bridge.section import (
    Concrete,
    core_concrete,
    cover_concrete,
    shear_modulus_pa,
    steel_of,
)
from skewbridge.bridge.spine import Spine, add_moment, add_weight
from skewbridge.bridge.springs import grounded_springs
from skewbridge.bridge.weights import column_weight_n, deck_reactions_n
from skewbridge.contact.element import uniaxial
from skewbridge.errors import InputError
from skewbridge.units import G_MPS2, GPA, KN
from skewbridge.variant.options import ModelOptions

RIGID_TWIST = 100.0  # torsion constant of a cap / its polar moment
RIGID_BENDING = 1000.0  # factor on the vertical bending stiffness of a cap


def build_bents(
    bridge: BridgeData, spine: Spine, skew_deg: float, options: ModelOptions, tags: TagAllocator
) -> tuple[tuple[ColumnHandle, ...], tuple[int, ...]]:
    """Create caps, columns and bases with their weights; return columns and foundation springs.

    ``skew_deg`` is the skew of the bents; ``bridge`` comes from `built_bridge` for this skew.
    """
    normal = (cos(radians(skew_deg)), sin(radians(skew_deg)))
    in_bent, level = tags.transformation(), tags.transformation()
    # a column ends at the soffit, rigidly connected to its node at the deck's centroid
    soffit = (0.0, 0.0, -bridge.deck.centroid_above_soffit_m)
    offset = ("-jntOffset", 0.0, 0.0, 0.0)
    ops.geomTransf("PDelta", in_bent, *normal, 0.0, *offset, *soffit)
    ops.geomTransf("Linear", level, 0.0, 0.0, 1.0)
    columns: list[ColumnHandle] = []
    foundations: list[int] = []
    for number, (bent, x) in enumerate(zip(bridge.bents, bridge.bent_positions_m, strict=True)):
        capacities = bent_directions(bridge, number, options.hinge_rule)
        is_pinned = bridge.base_of(bent) == "pinned"
        vertical, below, height_m = in_bent, soffit, bent.clear_height_m
        if number in bridge.bents_with_bearings:
            # the cap is a line at its top, where the bearings are; the column ends at its soffit
            pads_m = bent.pads.height_m if bent.pads else 0.0
            vertical, below = tags.transformation(), (0.0, 0.0, pads_m - bent.cap_depth_m)
            height_m += bent.cap_depth_m
            ops.geomTransf("PDelta", vertical, *normal, 0.0, *offset, *below)
            spine.bent_nodes[number] = cap = tags.node()
            ops.node(cap, x, 0.0, -pads_m)
            # inertia about its own axis, below the bearings: without it, the trapezoidal rule is
            # unstable in this rotation when decks collide
            inertia = bent.cap_weight_kn * KN / G_MPS2
            inertia *= bent.cap_width_m**2 / 12 + bent.cap_depth_m**2 / 3
            ops.mass(cap, 0.0, 0.0, 0.0, inertia, inertia, inertia)
        integration, hinges = build_integration(capacities, options, tags)
        has_hinges = options.column_integration == "hinge_radau"
        model_hinge_m = capacities[0].hinge_length_m if has_hinges else None
        joints = _build_cap(bridge, number, spine, (x, normal), level, tags)
        if options.cap_load == "spread" and len(joints) > 1:
            _spread_deck_load(bridge, number, spine, joints, normal)
        for joint, _ in joints:
            base = tags.node()
            ops.node(base, *ops.nodeCoord(joint)[:2], -height_m)
            foundations.extend(_support(bridge, base, is_pinned, normal, options, tags))
            element = tags.element()
            numerics = (vertical, integration, "-iter", *COLUMN_ITERATIONS)
            ops.element("forceBeamColumn", element, base, joint, *numerics)
            columns.append(
                ColumnHandle(
                    element=element,
                    base_node=base,
                    top=Point(joint, below),
                    clear_height_m=bent.clear_height_m,
                    hinge_sections=hinges,
                    capacities=(
                        _handle_of(capacities[0], model_hinge_m),
                        _handle_of(capacities[1], model_hinge_m),
                    ),
                    normal=normal,
                    bent=number,
                    shear_model=options.shear_model,
                    is_pinned=is_pinned,
                    is_elastic=options.elastic_columns,
                    loses_shear_strength=options.shear_failure == "degrade",
                )
            )
            # ASSUME the base section, which governs, carries the whole weight of the column;
            # half of its mass moves with the cap
            weight_n = column_weight_n(bridge, bent)
            add_weight(spine, joint, weight_n, weight_n / 2 / G_MPS2)
    return tuple(columns), tuple(foundations)


def _handle_of(bent: BentCapacity, model_hinge_m: float | None) -> ColumnCapacity:
    return ColumnCapacity(
        hinge_ratio=(model_hinge_m or bent.hinge_length_m) / bent.hinge_length_m,
        yield_curvature_per_m=bent.curve.yield_curvature_per_m,
        yield_drift_ratio=bent.yield_disp_m / bent.clear_height_m,
        drift_capacity_ratio=bent.capacity_m / bent.clear_height_m,
        shear=bent.shear,
    )


def _build_cap(
    bridge: BridgeData,
    bent_number: int,
    spine: Spine,
    middle: tuple[float, PlanVector],
    transformation: int,
    tags: TagAllocator,
) -> list[tuple[int, float]]:
    """Create the cap of a bent; return its node above each column, and position (m) along it.

    ``middle`` is x (m) of the middle of the cap, and the normal of the bent.
    """
    bent, deck, centre = bridge.bents[bent_number], bridge.deck, spine.bent_nodes[bent_number]
    add_weight(spine, centre, bent.cap_weight_kn * KN, bent.cap_weight_kn * KN / G_MPS2)
    # the cap of a steel deck is of concrete, like its columns
    concrete = deck if is_concrete(deck.elastic_modulus_gpa) else bridge.column_of(bent)
    modulus = concrete.elastic_modulus_gpa * GPA
    width, depth = bent.cap_width_m, bent.cap_depth_m
    # ASSUME webs and slabs between the columns carry the column moments directly into the deck:
    # an integral cap does not twist relative to the deck
    torsion = RIGID_TWIST * width * depth * (width**2 + depth**2) / 12
    i_vertical = width * depth**3 / 12
    if bent.columns > 2:
        # ASSUME webs spread the deck's load over all columns, so the cap does not bend vertically;
        # otherwise the middle column, below the spine, would carry nearly all of it
        i_vertical *= RIGID_BENDING
    joints: list[tuple[int, float]] = []
    x_m, normal = middle
    for number in range(bent.columns):
        along_m = (number - (bent.columns - 1) / 2) * bent.column_spacing_m
        node = centre if along_m == 0.0 else tags.node()
        if node != centre:
            x, y = (along_m * component for component in turned(normal))
            ops.node(node, x_m + x, y, float(ops.nodeCoord(centre, 3)))
        joints.append((node, along_m))
    # ASSUME a cap bends in plan by its own section; with a rigid one OSB1 moves 1 to 2 % less
    inertias = (torsion, i_vertical, depth * width**3 / 12)
    section = (width * depth, modulus, shear_modulus_pa(modulus), *inertias)
    for (i, _), (j, _) in pairwise(_along_cap(centre, joints)):
        spine.elements.append(tags.element())
        ops.element("elasticBeamColumn", spine.elements[-1], i, j, *section, transformation)
    return joints


def _along_cap(centre: int, joints: list[tuple[int, float]]) -> list[tuple[int, float]]:
    return sorted({(centre, 0.0), *joints}, key=lambda joint: joint[1])


def _spread_deck_load(
    bridge: BridgeData,
    bent_number: int,
    spine: Spine,
    joints: list[tuple[int, float]],
    normal: PlanVector,
) -> None:
    """Spread the dead load of the deck over the length of a cap.

    The spine applies it at the middle, which would bend the cap and push the column bases apart.
    This adds the fixed-end forces of a uniform load and subtracts the load at the middle.
    """
    bent, length_m = bridge.bents[bent_number], bridge.deck.width_m / normal[0]
    load_n = deck_reactions_n(bridge)[bent_number + 1] + bent.cap_weight_kn * KN
    centre = spine.bent_nodes[bent_number]
    nodes = _along_cap(centre, joints)
    spine.loads_n[centre] -= load_n
    per_m = load_n / length_m
    stations_m = (-length_m / 2, *(along_m for _, along_m in nodes), length_m / 2)
    for i, (node, along_m) in enumerate(nodes):
        # each side of the node: the whole overhang at an end of the cap, else half the span
        for sign, neighbour_m, is_end in (
            (-1.0, stations_m[i], i == 0),
            (1.0, stations_m[i + 2], i == len(nodes) - 1),
        ):
            part_m = abs(neighbour_m - along_m)
            spine.loads_n[node] += per_m * part_m / (1.0 if is_end else 2.0)
            moment_nm = per_m * part_m**2 / (2.0 if is_end else 12.0)
            about_x_nm, about_y_nm = (-sign * moment_nm * component for component in normal)
            add_moment(spine, node, about_x_nm=about_x_nm, about_y_nm=about_y_nm)


def _support(
    bridge: BridgeData,
    base: int,
    is_pinned: bool,
    normal: PlanVector,
    options: ModelOptions,
    tags: TagAllocator,
) -> list[int]:
    """Fix a base, or create and return its springs; a pinned base still resists torsion."""
    bends = 0 if is_pinned else 1
    if options.foundation == "fixed" or bridge.foundation is None:
        ops.fix(base, 1, 1, 1, bends, bends, 1)
        return []
    # The fields of the foundation are in the order of the degrees of freedom.
    fields = enumerate(bridge.foundation.model_dump().values(), start=1)
    stiffness = {dof: 1e6 * value for dof, value in fields if bends or dof not in (4, 5)}
    return [grounded_springs(base, stiffness, normal, tags)[0]]


# --- materials of the fibers

# source: Kent and Park (1971), J. Struct. Div. ASCE 97(7), 1969-1990: crushed core keeps 0.2 fc
RESIDUAL_CORE = 0.2


def core_materials(column: ColumnData, tags: TagAllocator, *, has_end: bool) -> list[int]:
    """Create confined concrete as one or two parallel materials; return their tags.

    With ``has_end``, a fiber that has exceeded Mander's ultimate strain (first hoop rupture) keeps
    0.2 of its strength; the first material holds the strength that is lost.
    """
    core = core_concrete(column)
    crushed_pa = float(core.stress_pa(core.ultimate_strain))
    if not has_end:
        return [concrete_material(core, crushed_pa, tags)]
    kept_pa = RESIDUAL_CORE * core.peak_pa
    residual = concrete_material(core, kept_pa, tags, share=RESIDUAL_CORE)
    lost = concrete_material(core, crushed_pa - kept_pa, tags, share=1.0 - RESIDUAL_CORE)
    return [uniaxial(tags, "MinMax", lost, "-min", -core.ultimate_strain), residual]


def concrete_material(
    concrete: Concrete, crushed_pa: float, tags: TagAllocator, *, share: float = 1.0
) -> int:
    """Create Concrete01 with a share of the strength and the initial modulus of a Mander curve.

    It ends at the stress ``crushed_pa``, and is above the Mander curve by less than 8 %.
    """
    peak_pa = share * concrete.peak_pa
    # ASSUME the initial stiffness matters more than the strain at the peak
    peak_strain = 2 * peak_pa / (share * concrete.modulus_pa)
    points = (-peak_pa, -peak_strain, -crushed_pa, -concrete.ultimate_strain)
    return uniaxial(tags, "Concrete01", *points)


def bar_material(column: ColumnData, tags: TagAllocator, *, has_end: bool) -> int:
    """Create the material of the longitudinal bars and return its tag.

    With ``has_end``, bars break at the reduced ultimate strain and buckle when the hoops break.
    """
    steel = steel_of(column)
    backbone = (steel.yield_pa, steel.modulus_pa, steel.hardening_ratio)
    # source: transition parameters recommended in the OpenSees manual for Steel02
    bar = uniaxial(tags, "Steel02", *backbone, 18.5, 0.925, 0.15)
    if not has_end:
        return bar
    # ASSUME hoops prevent buckling until they break; then the bars buckle at once
    limits = ("-min", -core_concrete(column).ultimate_strain, "-max", steel.rupture_strain)
    return uniaxial(tags, "MinMax", bar, *limits)


# --- sections and beam integration

PLATEAU = 100.0  # deformation at the end of the residual branch / at its start
# ASSUME pinched loops: reloading passes through 0.4 of the force at 0.5 of the deformation
PINCHING = (0.5, 0.4)
ELASTIC_POINTS = 3  # exact for an elastic column
LOBATTO_POINTS = 5  # source: usual choice for force-based columns; the paper gives no number
# Iterations and tolerance (work in J) of the equilibrium of a column between its sections. Dividing
# the tolerance by 1000 changes no demand by 1e-8.
COLUMN_ITERATIONS = (10, 1.0e-2)


def build_fiber_section(column: ColumnData, options: ModelOptions, tags: TagAllocator) -> int:
    """Create the fiber section of a column and return its tag; torsion is elastic."""
    has_end = options.fiber_end == "loss"
    cover = concrete_material(cover_concrete(column), 0.0, tags)
    bar = bar_material(column, tags, has_end=has_end)
    core = core_materials(column, tags, has_end=has_end)
    rings, wedges, cover_rings = options.column_fibers
    section = tags.section()
    shear_pa = shear_modulus_pa(column.elastic_modulus_gpa * GPA)
    torsion_nm2 = column.torsion_ratio * shear_pa * column.outline.torsion_m4  # cracked
    ops.section("Fiber", section, "-GJ", torsion_nm2)
    core_mesh, cover_mesh, bars = column.fibers(rings, wedges, cover_rings)
    # the core material that remains has a fifth of the strength, so half the mesh is enough
    coarse = column.core.fibers(ceil(rings / 2), max(3, ceil(wedges / 2)))
    parts = [*zip(core, (core_mesh, coarse), strict=False), (cover, cover_mesh), (bar, bars)]
    for material, fibers in parts:
        for y, z, area_m2 in fibers:
            ops.fiber(y, z, area_m2, material)
    return section


def _elastic_section(column: ColumnData, tags: TagAllocator) -> int:
    section, shape, modulus = tags.section(), column.outline, column.elastic_modulus_gpa * GPA
    normal, along = (column.cracked_stiffness_ratio * shape.inertia_m4(k) for k in (0, 1))
    polar, shear = column.torsion_ratio * shape.torsion_m4, shear_modulus_pa(modulus)
    # bending about z moves the column along y, which is along the bent
    ops.section("Elastic", section, modulus, shape.area_m2, along, normal, shear, polar)
    return section


def _shear_section(
    fiber: int, capacities: Sequence[BentCapacity], options: ModelOptions, tags: TagAllocator
) -> int:
    """Add the loss of shear strength to the fiber section of a hinge; return the new section tag.

    The two directions fail independently: an oblique resultant can reach 1.41 times the strength.
    """
    normal, along = capacities
    # ASSUME the hinge normal to the bent in both directions: an integration has one length
    hinge_m = normal.hinge_length_m
    normal_shear = _shear_material(normal, hinge_m, options, tags)
    is_equal = along is normal
    along_shear = normal_shear if is_equal else _shear_material(along, hinge_m, options, tags)
    section = tags.section()
    ops.section("Aggregator", section, along_shear, "Vy", normal_shear, "Vz", "-section", fiber)
    return section


def _shear_material(
    bent: BentCapacity, hinge_m: float, options: ModelOptions, tags: TagAllocator
) -> int:
    loss = shear_loss(bent, options.shear_model)
    residual = RESIDUAL_SHEAR * loss.strength_n
    points = (
        (loss.strength_n, loss.elastic_m / hinge_m),
        (residual, loss.residual_m / hinge_m),
        (residual, PLATEAU * loss.residual_m / hinge_m),
    )
    branch = [value for point in points for value in point]
    backbone = (*branch, *(-value for value in branch))
    return uniaxial(tags, "Hysteretic", *backbone, *PINCHING, 0.0, 0.0)


def build_integration(
    capacities: Sequence[BentCapacity], options: ModelOptions, tags: TagAllocator
) -> tuple[int, tuple[int, ...]]:
    """Create the beam integration of the columns of a bent (capacities normal to it and along it).

    Hinges are integrated as in HingeRadau; sections between them, and the hinge at a pinned base,
    are elastic (`elastic_points`). Returns its tag and the numbers of the sections where plastic
    curvature is read. `InputError` for shear failure with distributed plasticity.
    """
    bent = capacities[0]
    column, is_pinned = bent.column, bent.base == "pinned"
    integration, is_degrading = tags.integration(), options.shear_failure == "degrade"
    if options.elastic_columns:
        ops.beamIntegration("Lobatto", integration, _elastic_section(column, tags), ELASTIC_POINTS)
        return integration, ()
    fiber = build_fiber_section(column, options, tags)
    if options.column_integration == "lobatto5":
        if is_degrading:
            raise InputError("`shear_failure: degrade` requires `column_integration: hinge_radau`")
        ops.beamIntegration("Lobatto", integration, fiber, LOBATTO_POINTS)
        return integration, (LOBATTO_POINTS,) if is_pinned else (1, LOBATTO_POINTS)
    elastic = _elastic_section(column, tags)
    top = _shear_section(fiber, capacities, options, tags) if is_degrading else fiber
    ratio = bent.hinge_length_m / bent.clear_height_m
    positions, weights = elastic_points(ratio, is_pinned=is_pinned)
    sections, hinge_numbers = [elastic] * len(positions), (len(positions) + 1,)
    if not is_pinned:
        sections, positions, weights = [fiber, *sections], [0.0, *positions], [ratio, *weights]
        hinge_numbers = (1, len(positions) + 1)
    sections, positions, weights = [*sections, top], [*positions, 1.0], [*weights, ratio]
    rule = (len(sections), *sections, *positions, *weights)
    ops.beamIntegration("UserDefined", integration, *rule)
    return integration, hinge_numbers


def elastic_points(hinge_ratio: float, *, is_pinned: bool) -> tuple[list[float], list[float]]:
    """Return positions (from the base) and weights of the elastic sections, divided by the height.

    The flexibility of an elastic part integrates quadratic functions at most: two points that match
    the first four moments of HingeRadau's points (hinges ``hinge_ratio`` long) give the same
    result.

    References:
        Scott and Fenves (2006), J. Struct. Eng. 132(2), 244-252: HingeRadau. Golub and Welsch
        (1969), Math. Comp. 23: Gauss rules from moments.
    """
    middle = 1.0 - 8.0 * hinge_ratio
    half_spacing = middle / (2.0 * sqrt(3.0))
    radau = 8.0 / 3.0 * hinge_ratio
    positions = np.array([0.0, radau, 0.5 - half_spacing, 0.5 + half_spacing, 1.0 - radau])
    weights = np.array([hinge_ratio, 3.0 * hinge_ratio, middle / 2, middle / 2, 3.0 * hinge_ratio])
    if not is_pinned:
        positions, weights = positions[1:], weights[1:]
    moments = [float(weights @ positions**power) for power in range(4)]
    hankel = [moments[:2], moments[1:3]]
    roots = np.roots([1.0, *np.linalg.solve(hankel, [-moments[2], -moments[3]])[::-1]])
    if np.iscomplexobj(roots) or not ((roots > 0.0) & (roots < 1.0)).all():
        return positions.tolist(), weights.tolist()  # hinges too long for a two-point rule
    points = np.sort(roots)
    shares = np.linalg.solve([[1.0, 1.0], points.tolist()], moments[:2])
    return points.tolist(), shares.tolist()
