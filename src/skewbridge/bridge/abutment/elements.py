"""Springs of wall, wing wall and key: materials, and zeroLength elements in the skewed frame."""

from collections.abc import Sequence
from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.abutment.backfill import Passive
from skewbridge.bridge.catalogue.data import KeyData
from skewbridge.bridge.deck_plan import PlanVector
from skewbridge.bridge.handles import SpringHandle
from skewbridge.bridge.tags import TagAllocator
from skewbridge.units import KN, MM

# The gap materials want a gap: far below any displacement that matters.
NO_GAP_M = 1.0e-6
_NEVER_M = 1.0e3  # an elastic gap spring would yield at this deformation
_CHORDS = 30  # of a hyperbola: within 0.1 % of it
_PLATEAU_SLOPE = 1.0e-5  # of the initial stiffness: a tangent of zero would be one of either sign
_NO_TENSION = 1.0e-6  # of the ultimate force, at which the spring cracks and opens
_FAR_M = 10.0  # a curve ends at this deformation
# source: defaults of the OpenSees manual for an unpinched Hysteretic spring without damage
NO_PINCHING = (1.0, 1.0)
NO_DAMAGE = (0.0, 0.0)


def turned(direction: PlanVector) -> PlanVector:
    """Return a plan direction turned by +90 degrees."""
    return (-direction[1], direction[0])


def passive_material(passive: Passive, gap_m: float, tags: TagAllocator) -> int:
    """Create a spring that resists closing (negative deformation) beyond a gap."""
    # ASSUME the soil keeps its indentation: it unloads as stiff as at first, then a gap opens
    # behind the wall
    material = tags.material()
    stiffness, ultimate = passive.stiffness_n_per_m, passive.ultimate_n
    if passive.failure_ratio == 0.0:
        gap = max(gap_m, NO_GAP_M)
        ops.uniaxialMaterial("ElasticPPGap", material, stiffness, -ultimate, -gap, 0.0, "damage")
        return material
    # A plastic curve of any shape, without tension. HyperbolicGapMaterial does not end at the
    # ultimate force, and jumps on reloading after a trial that overshot. The gap is the start of
    # the curve: what is closed of it stays closed like soil that was pushed, and the spring meets
    # the soil where it did. (A material around this one would evaluate it outside of an element,
    # which OpenSees 3.8 does not survive.)
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
    ops.uniaxialMaterial("ASDConcrete1D", material, stiffness, *curve)
    return material


def plastic_material(stiffness_n_per_m: float, strength_n: float, tags: TagAllocator) -> int:
    """Create an elastic-perfectly-plastic spring."""
    material = tags.material()
    ops.uniaxialMaterial("ElasticPP", material, stiffness_n_per_m, strength_n / stiffness_n_per_m)
    return material


def elastic_material(
    stiffness_n_per_m: float,
    tags: TagAllocator,
    *,
    dashpot_n_s_per_m: float = 0.0,
    compression_n_per_m: float | None = None,
) -> int:
    """Create an elastic spring, with a dashpot beside it.

    Its stiffness in compression (negative deformation) may be another one.
    """
    material = tags.material()
    negative = stiffness_n_per_m if compression_n_per_m is None else compression_n_per_m
    ops.uniaxialMaterial("Elastic", material, stiffness_n_per_m, dashpot_n_s_per_m, negative)
    return material


def gap_material(stiffness_n_per_m: float, gap_m: float, tags: TagAllocator) -> int:
    """Create a stiff spring that acts when a gap closes (negative deformation)."""
    material = tags.material()
    yield_n, gap = -_NEVER_M * stiffness_n_per_m, -max(gap_m, NO_GAP_M)
    ops.uniaxialMaterial("ElasticPPGap", material, stiffness_n_per_m, yield_n, gap, 0.0, "noDamage")
    return material


def key_material(key: KeyData, tags: TagAllocator) -> int:
    """Create the backbone of a shear key, the same in both directions."""
    material = tags.material()
    points = [
        value
        for force, disp in zip(key.force_kn, key.displacement_mm, strict=True)
        for value in (force * KN, disp * MM)
    ]
    mirrored = [-value for value in points]
    ops.uniaxialMaterial("Hysteretic", material, *points, *mirrored, *NO_PINCHING, *NO_DAMAGE)
    return material


def key_stiffness_n_per_m(key: KeyData) -> float:
    """Return the initial stiffness of a key."""
    return key.force_kn[0] * KN / (key.displacement_mm[0] * MM)


def damping_n_s_per_m(ratio: float, stiffness_n_per_m: float, mass_kg: float) -> float:
    """Return the dashpot of a ratio of critical on a mass held by a spring."""
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
    """Create a fixed node; at the pads' top if its place is given in plan."""
    node = tags.node()
    ops.node(node, *place_m, *[0.0] * (3 - len(place_m)))
    ops.fix(node, 1, 1, 1, 1, 1, 1)
    return node


def plane_node(plan_m: PlanVector, mass_kg: float, tags: TagAllocator) -> int:
    """Create a node at the pads' top that moves in plan only."""
    node = tags.node()
    ops.node(node, *plan_m, 0.0)
    ops.fix(node, 0, 0, 1, 1, 1, 1)
    if mass_kg > 0.0:
        ops.mass(node, mass_kg, mass_kg, 0.0, 0.0, 0.0, 0.0)
    return node
