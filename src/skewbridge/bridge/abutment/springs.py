"""Springs of wall, wing wall and key: materials, and zeroLength elements in the skewed frame."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.abutment.backfill import Passive
from skewbridge.bridge.catalogue.data import KeyData
from skewbridge.bridge.deck_plan import PlanVector
from skewbridge.bridge.tags import TagAllocator
from skewbridge.units import KN, MM

# The hyperbolic material wants a gap: far below any displacement that matters.
NO_GAP_M = 1.0e-6
# source: defaults of the OpenSees manual for an unpinched Hysteretic spring without damage
NO_PINCHING = (1.0, 1.0)
NO_DAMAGE = (0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Local axes of a spring element in plan: ``x`` and, 90 degrees further, ``y``."""

    x: PlanVector

    @property
    def y(self) -> PlanVector:
        """Second local axis."""
        return (-self.x[1], self.x[0])


def passive_material(passive: Passive, gap_m: float, tags: TagAllocator) -> int:
    """Create a spring that resists closing (negative deformation) beyond a gap."""
    # ASSUME the soil keeps its indentation: on unloading a gap opens behind the wall
    material = tags.material()
    gap = max(gap_m, NO_GAP_M)
    stiffness, ultimate = passive.stiffness_n_per_m, passive.ultimate_n
    if passive.failure_ratio == 0.0:
        ops.uniaxialMaterial(*("ElasticPPGap", material, stiffness, -ultimate, -gap, 0.0, "damage"))
    else:
        ops.uniaxialMaterial(
            *("HyperbolicGapMaterial", material, stiffness, stiffness),
            *(passive.failure_ratio, -ultimate, -gap),
        )
    return material


def plastic_material(stiffness_n_per_m: float, strength_n: float, tags: TagAllocator) -> int:
    """Create an elastic-perfectly-plastic spring."""
    material = tags.material()
    ops.uniaxialMaterial("ElasticPP", material, stiffness_n_per_m, strength_n / stiffness_n_per_m)
    return material


def elastic_material(stiffness_n_per_m: float, tags: TagAllocator) -> int:
    """Create an elastic spring."""
    material = tags.material()
    ops.uniaxialMaterial("Elastic", material, stiffness_n_per_m)
    return material


def gap_material(stiffness_n_per_m: float, gap_m: float, tags: TagAllocator) -> int:
    """Create a stiff spring that acts when a gap closes (negative deformation)."""
    material = tags.material()
    never = -1.0e3 * stiffness_n_per_m
    ops.uniaxialMaterial(
        *("ElasticPPGap", material, stiffness_n_per_m, never, -max(gap_m, NO_GAP_M)),
        *(0.0, "noDamage"),
    )
    return material


def stop_material(stiffness_n_per_m: float, tags: TagAllocator) -> int:
    """Create an elastic spring that acts in tension (positive deformation) only."""
    material = tags.material()
    never = 1.0e3 * stiffness_n_per_m
    ops.uniaxialMaterial(
        *("ElasticPPGap", material, stiffness_n_per_m, never, NO_GAP_M, 0.0, "noDamage")
    )
    return material


def key_material(key: KeyData, tags: TagAllocator) -> int:
    """Create the backbone of a shear key, the same in both directions."""
    material = tags.material()
    points = [
        value
        for force, disp in zip(key.force_kn, key.displacement_mm, strict=True)
        for value in (force * KN, disp * MM)
    ]
    ops.uniaxialMaterial(
        *("Hysteretic", material, *points, *(-value for value in points)),
        *NO_PINCHING,
        *NO_DAMAGE,
    )
    return material


def key_stiffness_n_per_m(key: KeyData) -> float:
    """Return the initial stiffness of a key."""
    return key.force_kn[0] * KN / (key.displacement_mm[0] * MM)


def dashpot_material(
    ratio: float, stiffness_n_per_m: float, mass_kg: float, tags: TagAllocator
) -> int | None:
    """Create a dashpot of a ratio of critical on a mass held by a spring; None without."""
    if ratio == 0.0:
        return None
    material = tags.material()
    coefficient = 2 * ratio * sqrt(stiffness_n_per_m * mass_kg)
    ops.uniaxialMaterial("Viscous", material, coefficient, 1.0)
    return material


def spring_element(
    nodes: tuple[int, int],
    frame: Frame,
    along_x: Sequence[int | None],
    along_y: Sequence[int | None],
    tags: TagAllocator,
) -> int:
    """Create a zeroLength element with materials along its local axes, in the order given."""
    kept_x = [material for material in along_x if material is not None]
    kept_y = [material for material in along_y if material is not None]
    element = tags.element()
    ops.element(
        *("zeroLength", element, *nodes, "-mat", *kept_x, *kept_y),
        *("-dir", *[1] * len(kept_x), *[2] * len(kept_y)),
        *("-doRayleigh", 0, "-orient", *frame.x, 0.0, *frame.y, 0.0),
    )
    return element


def grounded_node(plan_m: PlanVector, height_m: float, tags: TagAllocator) -> int:
    """Create a fixed node."""
    node = tags.node()
    ops.node(node, *plan_m, height_m)
    ops.fix(node, 1, 1, 1, 1, 1, 1)
    return node


def plane_node(plan_m: PlanVector, height_m: float, mass_kg: float, tags: TagAllocator) -> int:
    """Create a node that moves in plan only."""
    node = tags.node()
    ops.node(node, *plan_m, height_m)
    ops.fix(node, 0, 0, 1, 1, 1, 1)
    if mass_kg > 0.0:
        ops.mass(node, mass_kg, mass_kg, 0.0, 0.0, 0.0, 0.0)
    return node
