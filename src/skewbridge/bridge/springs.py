"""Springs of abutments: materials, contact penalties, zeroLength elements and their nodes."""

from collections.abc import Sequence
from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.backfill import Passive
from skewbridge.bridge.catalogue.data import KeyData
from skewbridge.bridge.handles import PlanVector, SpringHandle, TagAllocator
from skewbridge.contact.element import uniaxial
from skewbridge.units import KN, MM
from skewbridge.variant.options import ModelOptions

# Gap materials need a positive gap; this one is far below any displacement of interest.
NO_GAP_M = 1.0e-6
_NEVER_M = 1.0e3  # an elastic gap spring would yield at this deformation
_CHORDS = 30  # chords of a hyperbola: within 0.1 % of it
# Slope of the plateau over the initial stiffness: rounding would give a zero slope either sign.
_PLATEAU_SLOPE = 1.0e-5
_NO_TENSION = 1.0e-6  # share of the ultimate force at which the spring cracks and opens
_FAR_M = 10.0  # a curve ends at this deformation
#: Stiffness of a key along its face beyond its strength, over the initial one: a static analysis
#: needs some, and 100 mm of slip add 1 % of the strength or less.
KEY_FACE_HARDENING = 1.0e-3


def turned(direction: PlanVector) -> PlanVector:
    """Return a plan direction turned by +90 degrees."""
    return (-direction[1], direction[0])


def passive_material(passive: Passive, gap_m: float, tags: TagAllocator) -> int:
    """Create a spring that resists closing (negative deformation) beyond a gap."""
    # ASSUME the soil keeps its indentation: it unloads with its initial stiffness, then a gap
    # opens behind the wall
    stiffness, ultimate = passive.stiffness_n_per_m, passive.ultimate_n
    if passive.failure_ratio == 0.0:
        gap = max(gap_m, NO_GAP_M)
        return uniaxial(tags, "ElasticPPGap", stiffness, -ultimate, -gap, 0.0, "damage")
    # A plastic curve of any shape, without tension. HyperbolicGapMaterial does not end at the
    # ultimate force, and jumps on reloading after a trial that overshot. The gap is the first part
    # of the curve: the closed part of it stays closed, like soil that was pushed, and the spring
    # meets the soil again where it left it. (A wrapper material would evaluate this one outside of
    # an element, which crashes OpenSees 3.8.)
    polygon_m, polygon_n = passive.polygon(_CHORDS)
    none_n = _NO_TENSION * ultimate
    start_m, start_n = ([0.0, none_n / stiffness], [0.0, none_n]) if gap_m > 0.0 else ([], [])
    closures = [*start_m, *(gap_m + polygon_m).tolist(), _FAR_M]
    forces = [*start_n, *polygon_n.tolist(), ultimate + _PLATEAU_SLOPE * stiffness * _FAR_M]
    if gap_m > 0.0:
        forces[len(start_n)] = none_n  # where the gap ends
    compression = ("-Ce", *closures, "-Cs", *forces)
    undamaged = ("-Cd", *[0.0] * len(closures))
    opening = ("-Te", 0.0, none_n / stiffness, _FAR_M, "-Ts", 0.0, none_n, none_n)
    curve = (*compression, *undamaged, *opening, "-Td", 0.0, 0.0, 1.0, "-tangent")
    return uniaxial(tags, "ASDConcrete1D", stiffness, *curve)


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
    """Create an elastic spring with a parallel dashpot.

    The stiffness in compression (negative deformation) may differ.
    """
    negative = stiffness_n_per_m if compression_n_per_m is None else compression_n_per_m
    return uniaxial(tags, "Elastic", stiffness_n_per_m, dashpot_n_s_per_m, negative)


def gap_material(stiffness_n_per_m: float, gap_m: float, tags: TagAllocator) -> int:
    """Create a stiff spring that acts once a gap is closed (negative deformation)."""
    yield_n, gap = -_NEVER_M * stiffness_n_per_m, -max(gap_m, NO_GAP_M)
    return uniaxial(tags, "ElasticPPGap", stiffness_n_per_m, yield_n, gap, 0.0, "noDamage")


def key_material(key: KeyData, tags: TagAllocator) -> int:
    """Create the backbone of a shear key, the same in both directions."""
    points = [
        value
        for force, disp in zip(key.force_kn, key.displacement_mm, strict=True)
        for value in (force * KN, disp * MM)
    ]
    mirrored = [-value for value in points]
    # source: defaults of the OpenSees manual for an unpinched spring without damage
    return uniaxial(tags, "Hysteretic", *points, *mirrored, 1.0, 1.0, 0.0, 0.0)


def key_face_material(key: KeyData, tags: TagAllocator) -> int:
    """Create the spring of a shear key parallel to its face.

    It has the initial stiffness up to the strength, almost zero beyond.
    """
    # Not Hysteretic or MultiLinear: where a trial returns to the committed strain they keep stress
    # or slope of the trial before it, and the solver then finds no equilibrium.
    stiffness, strength_n = key_stiffness_n_per_m(key), key.force_kn[1] * KN
    return uniaxial(tags, "Steel01", strength_n, stiffness, KEY_FACE_HARDENING)


def key_stiffness_n_per_m(key: KeyData) -> float:
    """Return the initial stiffness of a key."""
    return key.force_kn[0] * KN / (key.displacement_mm[0] * MM)


def damping_n_s_per_m(ratio: float, stiffness_n_per_m: float, mass_kg: float) -> float:
    """Return the dashpot coefficient for a damping ratio of a mass on a spring."""
    return 2 * ratio * sqrt(stiffness_n_per_m * mass_kg)


def spring_element(
    nodes: tuple[int, int],
    direction: PlanVector,
    along_x: Sequence[int],
    along_y: Sequence[int],
    tags: TagAllocator,
) -> tuple[SpringHandle, SpringHandle]:
    """Create a zeroLength element with materials along a plan direction and across it.

    Returns:
        The first spring along the direction, and the first across it.
    """
    materials, local = [*along_x, *along_y], [1] * len(along_x) + [2] * len(along_y)
    across = turned(direction)
    axes = (*direction, 0.0, *across, 0.0)
    element = tags.element()
    springs = ("-mat", *materials, "-dir", *local, "-doRayleigh", 0, "-orient", *axes)
    ops.element("zeroLength", element, *nodes, *springs)
    return (
        SpringHandle(element=element, component=0, direction=direction, nodes=nodes),
        SpringHandle(element=element, component=len(along_x), direction=across, nodes=nodes),
    )


def grounded_node(place_m: Sequence[float], tags: TagAllocator) -> int:
    """Create a fixed node; a position given in plan is at the top of the pads."""
    node = tags.node()
    ops.node(node, *place_m, *[0.0] * (3 - len(place_m)))
    ops.fix(node, 1, 1, 1, 1, 1, 1)
    return node


def plane_node(plan_m: PlanVector, mass_kg: float, tags: TagAllocator) -> int:
    """Create a node at the top of the pads that moves only in plan."""
    node = tags.node()
    ops.node(node, *plan_m, 0.0)
    ops.fix(node, 0, 0, 1, 1, 1, 1)
    if mass_kg > 0.0:
        ops.mass(node, mass_kg, mass_kg, 0.0, 0.0, 0.0, 0.0)
    return node


# A penalty spring 50 times stiffer than its neighbour softens the two in series by 2 %.
NORMAL_OVER_NEIGHBOUR = 50.0
# ASSUME with wall_mass the frequency of a contact may reach 3 rad per step of 5 ms (the paper's
# step). With Houbolt at that step and OSB1 at zero skew, a change of the motion by a millionth
# moved demands by 5 % at 4.6 rad, and by a millionth at 3.2 rad.
NOMINAL_STEP_S = 0.005
MAX_RADIANS_PER_STEP = 3.0
# ASSUME the tangential penalty is 5 times softer than the normal one. A much softer one does not
# reach the limit within a short contact, so that friction depends on the time step; a stiffer one
# gives friction without sliding. results/sensitivity.parquet halves and doubles it.
NORMAL_OVER_TANGENT = 5.0


def penalties(
    neighbour_n_per_m: float, mass_kg: float, options: ModelOptions
) -> tuple[float, float]:
    """Return the normal and the tangential penalty of a contact in N/m.

    They follow from the stiffest spring in series with the contact and the mass of the node between
    them (a node without mass sets no limit), unless the options name them.
    """
    normal, tangential = options.normal_stiffness_n_per_m, options.tangent_stiffness_n_per_m
    if normal is None:
        normal = NORMAL_OVER_NEIGHBOUR * neighbour_n_per_m
        if mass_kg > 0.0:
            normal = min(normal, mass_kg * (MAX_RADIANS_PER_STEP / NOMINAL_STEP_S) ** 2)
    if tangential is None:
        tangential = normal / NORMAL_OVER_TANGENT
    return options.normal_stiffness_factor * normal, options.tangent_stiffness_factor * tangential
