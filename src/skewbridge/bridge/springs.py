"""Springs of abutments and contact penalties; functions that create an object return its tag."""

from collections.abc import Mapping, Sequence
from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.backfill import Passive
from skewbridge.bridge.catalogue.data import KeyData
from skewbridge.bridge.handles import SpringHandle, TagAllocator
from skewbridge.bridge.plan import PlanVector, turned
from skewbridge.bridge.section import FloatArray
from skewbridge.contact.element import uniaxial
from skewbridge.units import KN, MM
from skewbridge.variant.options import ModelOptions

# Gap materials need a positive gap; this one is far below any displacement of interest.
NO_GAP_M = 1.0e-6
_NEVER_M = 1.0e3  # yield deformation of an elastic gap spring, never reached
_CHORDS = 30  # chords that replace a hyperbola, with an error of at most 0.1 %
# Slope of the plateau / initial stiffness; rounding could make a zero slope negative.
_PLATEAU_SLOPE = 1.0e-5
_NO_TENSION = 1.0e-6  # tensile force at which the spring opens / ultimate force
_FAR_M = 10.0  # deformation at the end of a curve
# ASSUME a light key, or a wall without radiation, is damped: without damping it would rattle
DAMPING_RATIO = 0.10
#: Post-yield / initial stiffness of a key along its face. A static analysis needs a positive value;
#: over 100 mm of slip the force grows by at most 1 % of the strength.
KEY_FACE_HARDENING = 1.0e-3


def passive_material(passive: Passive, gap_m: float, tags: TagAllocator) -> int:
    """Create a backfill spring, which resists closing (negative deformation) behind a gap."""
    # ASSUME the soil stays indented: it unloads with its initial stiffness, then a gap opens
    # behind the wall
    stiffness, ultimate_n = passive.stiffness_n_per_m, passive.ultimate_n
    if passive.failure_ratio == 0.0:
        gap = max(gap_m, NO_GAP_M)
        return uniaxial(tags, "ElasticPPGap", stiffness, -ultimate_n, -gap, 0.0, "damage")
    return _indented_material(*passive.polygon(_CHORDS), stiffness, gap_m, ("-tangent",), tags)


def _indented_material(
    polygon_m: FloatArray,
    polygon_n: FloatArray,
    stiffness: float,
    gap_m: float,
    tangent: tuple[str, ...],
    tags: TagAllocator,
) -> int:
    """Create a plastic spring without tension from closures (m) and forces (N) of first loading.

    It unloads with ``stiffness`` (N/m), the initial one. Without the flag ``-tangent``, the solver
    uses this stiffness too.
    """
    # ASDConcrete1D takes a plastic curve of any shape, without tension. HyperbolicGapMaterial does
    # not end at the ultimate force, and jumps when it reloads after a trial that overshot. The gap
    # is the first branch of the curve. Its closed part stays closed, like soil that was pushed, so
    # the wall meets the soil again where it left it. (A wrapper material would evaluate this one
    # outside an element, which crashes OpenSees 3.8.)
    ultimate_n = polygon_n[-1]
    opening_n = _NO_TENSION * ultimate_n
    start_m, start_n = ([0.0, opening_n / stiffness], [0.0, opening_n]) if gap_m > 0.0 else ([], [])
    closures = [*start_m, *(gap_m + polygon_m).tolist(), _FAR_M]
    forces = [*start_n, *polygon_n.tolist(), ultimate_n + _PLATEAU_SLOPE * stiffness * _FAR_M]
    if gap_m > 0.0:
        forces[len(start_n)] = opening_n  # at the end of the gap
    compression = ("-Ce", *closures, "-Cs", *forces)
    undamaged = ("-Cd", *[0.0] * len(closures))
    opening_branch = ("-Te", 0.0, opening_n / stiffness, _FAR_M, "-Ts", 0.0, opening_n, opening_n)
    curve = (*compression, *undamaged, *opening_branch, "-Td", 0.0, 0.0, 1.0)
    return uniaxial(tags, "ASDConcrete1D", stiffness, *curve, *tangent)


# A backfill in two parts in series: the plastic part unloads this many times stiffer than the
# whole, so most elastic deformation is in the elastic part, on which the radiation dashpot acts.
# With 3 instead of 5, unseating under strong motions changes by at most 3 %.
PLASTIC_OVER_INITIAL = 5.0
# ASSUME flowing soil is slightly viscous: 0.8 % of the strength at 1 m/s, 1.6 % at 4 m/s. This
# slows the return of a pushed wall, which would otherwise close its contact three times as often.
FLOW_RATIO, FLOW_EXPONENT = 0.008, 0.5


def elastic_part_n_per_m(passive: Passive) -> float:
    """Return the stiffness (N/m) of the elastic spring in series with `plastic_part`."""
    return passive.stiffness_n_per_m / (1.0 - 1.0 / PLASTIC_OVER_INITIAL)


def plastic_part(passive: Passive, tags: TagAllocator) -> list[int]:
    """Create the parallel materials of the plastic part of a backfill: soil and viscous flow.

    In series with a spring of `elastic_part_n_per_m`, the soil has the backbone of ``passive``.
    """
    initial_n_per_m, ultimate_n = passive.stiffness_n_per_m, passive.ultimate_n
    flow = uniaxial(tags, "Viscous", FLOW_RATIO * ultimate_n, FLOW_EXPONENT)
    stiffness = PLASTIC_OVER_INITIAL * initial_n_per_m
    if passive.failure_ratio == 0.0:
        soil = (stiffness, -ultimate_n, -NO_GAP_M, 0.0, "damage")
        return [uniaxial(tags, "ElasticPPGap", *soil), flow]
    closures_m, forces_n = passive.polygon(_CHORDS)
    plastic_m = closures_m - forces_n / elastic_part_n_per_m(passive)
    # With the tangent of the plateau, the iteration overshoots by metres where a contact opens.
    return [_indented_material(plastic_m, forces_n, stiffness, 0.0, (), tags), flow]


def plastic_material(passive: Passive, tags: TagAllocator) -> int:
    """Create an elastic-perfectly-plastic spring, the same in both directions."""
    stiffness = passive.stiffness_n_per_m
    return uniaxial(tags, "ElasticPP", stiffness, passive.ultimate_n / stiffness)


def elastic_material(
    stiffness_n_per_m: float,
    tags: TagAllocator,
    dashpot_n_s_per_m: float = 0.0,
    *,
    compression_n_per_m: float | None = None,
) -> int:
    """Create an elastic spring with a dashpot and, if given, another compressive stiffness."""
    compression = stiffness_n_per_m if compression_n_per_m is None else compression_n_per_m
    return uniaxial(tags, "Elastic", stiffness_n_per_m, dashpot_n_s_per_m, compression)


def gap_material(stiffness_n_per_m: float, gap_m: float, tags: TagAllocator) -> int:
    """Create a stiff elastic spring that acts once a gap is closed (negative deformation)."""
    yield_n, closed_at_m = -_NEVER_M * stiffness_n_per_m, -max(gap_m, NO_GAP_M)
    return uniaxial(tags, "ElasticPPGap", stiffness_n_per_m, yield_n, closed_at_m, 0.0, "noDamage")


def key_material(key: KeyData, tags: TagAllocator) -> int:
    """Create the spring normal to a shear key's face, with the same backbone in both directions."""
    points = [
        value
        for force_kn, disp_mm in zip(key.force_kn, key.displacement_mm, strict=True)
        for value in (force_kn * KN, disp_mm * MM)
    ]
    mirrored = [-value for value in points]
    # source: defaults of the OpenSees manual for an unpinched spring without damage
    return uniaxial(tags, "Hysteretic", *points, *mirrored, 1.0, 1.0, 0.0, 0.0)


def key_face_material(key: KeyData, tags: TagAllocator) -> int:
    """Create the spring of a key along its face: its initial stiffness up to its strength."""
    # Not Hysteretic or MultiLinear: if a trial returns to the committed strain, they keep stress or
    # tangent of the previous trial, and the solver finds no equilibrium.
    stiffness, strength_n = key_stiffness_n_per_m(key), key.force_kn[1] * KN
    return uniaxial(tags, "Steel01", strength_n, stiffness, KEY_FACE_HARDENING)


def key_stiffness_n_per_m(key: KeyData) -> float:
    """Return the initial stiffness of a key in N/m."""
    return key.force_kn[0] * KN / (key.displacement_mm[0] * MM)


def damping_n_s_per_m(stiffness_n_per_m: float, mass_kg: float) -> float:
    """Return the dashpot coefficient (N s/m) of a key or wall: `DAMPING_RATIO` of critical."""
    return 2 * DAMPING_RATIO * sqrt(stiffness_n_per_m * mass_kg)


def spring_element(
    nodes: tuple[int, int],
    direction: PlanVector,
    along_x: Sequence[int],
    along_y: Sequence[int],
    tags: TagAllocator,
) -> tuple[SpringHandle, SpringHandle]:
    """Create a zeroLength element with materials along and normal to a plan direction.

    Returns the handles of the first spring along the direction and of the first normal to it.
    """
    materials, local = [*along_x, *along_y], [1] * len(along_x) + [2] * len(along_y)
    normal_axis = turned(direction)
    axes = (*direction, 0.0, *normal_axis, 0.0)
    element = tags.element()
    springs = ("-mat", *materials, "-dir", *local, "-doRayleigh", 0, "-orient", *axes)
    ops.element("zeroLength", element, *nodes, *springs)
    return (
        SpringHandle(element=element, component=0, direction=direction, nodes=nodes),
        SpringHandle(element=element, component=len(along_x), direction=normal_axis, nodes=nodes),
    )


def grounded_node(place_m: Sequence[float], tags: TagAllocator) -> int:
    """Create a node fixed in all degrees of freedom."""
    node = tags.node()
    ops.node(node, *place_m)
    ops.fix(node, 1, 1, 1, 1, 1, 1)
    return node


def grounded_springs(
    node: int, stiffness: Mapping[int, float], axis: PlanVector, tags: TagAllocator
) -> tuple[int, int]:
    """Hold a node by elastic springs to the ground; return the element and its fixed node.

    ``stiffness`` (N/m or N m/rad) is keyed by degree of freedom; 1 is along ``axis`` in plan.
    """
    ground, element = grounded_node(ops.nodeCoord(node), tags), tags.element()
    materials = [elastic_material(value, tags) for value in stiffness.values()]
    axes = ("-orient", *axis, 0.0, *turned(axis), 0.0)
    ops.element("zeroLength", element, ground, node, "-mat", *materials, "-dir", *stiffness, *axes)
    return element, ground


def plane_node(place_m: Sequence[float], mass_kg: float, tags: TagAllocator) -> int:
    """Create a node that moves only in plan."""
    node = tags.node()
    ops.node(node, *place_m)
    ops.fix(node, 0, 0, 1, 1, 1, 1)
    if mass_kg > 0.0:
        ops.mass(node, mass_kg, mass_kg, 0.0, 0.0, 0.0, 0.0)
    return node


# A penalty spring 50 times stiffer than the adjacent spring softens the two in series by 2 %.
NORMAL_OVER_NEIGHBOUR = 50.0
# ASSUME with wall_mass the frequency of a contact may reach 3 rad per step of 5 ms (the paper's
# step). With Houbolt at that step and OSB1 at zero skew, changing the motion by one millionth
# changed demands by 5 % at 4.6 rad, and by one millionth at 3.2 rad.
NOMINAL_STEP_S = 0.005
MAX_RADIANS_PER_STEP = 3.0
# ASSUME the tangential penalty is 5 times softer than the normal one. If it is much softer,
# friction does not reach its limit in a short contact and depends on the time step; if stiffer,
# friction acts without sliding. results/sensitivity.parquet varies it by factors of 0.5 and 2.
NORMAL_OVER_TANGENT = 5.0


def penalties(
    neighbour_n_per_m: float, mass_kg: float, options: ModelOptions
) -> tuple[float, float]:
    """Return the normal and the tangential penalty of a contact in N/m.

    They follow from the stiffness in series with the contact and the mass between both.
    """
    normal = NORMAL_OVER_NEIGHBOUR * neighbour_n_per_m
    if mass_kg > 0.0:
        normal = min(normal, mass_kg * (MAX_RADIANS_PER_STEP / NOMINAL_STEP_S) ** 2)
    tangential = normal / NORMAL_OVER_TANGENT
    return options.normal_stiffness_factor * normal, options.tangent_stiffness_factor * tangential
