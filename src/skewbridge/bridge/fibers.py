"""Materials of the column fibers in OpenSees, with an end at their ultimate strains."""

from dataclasses import replace

import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import ColumnData
from skewbridge.bridge.materials import STEELS, Concrete, core_concrete
from skewbridge.bridge.tags import TagAllocator

# source: Kent and Park (1971), J. Struct. Div. ASCE 97(7), 1969-1990: crushed core keeps 0.2 fc
RESIDUAL_CORE = 0.2


def core_materials(column: ColumnData, tags: TagAllocator) -> tuple[int, int]:
    """Create the confined concrete with an end, as two materials side by side; return their tags.

    A fiber whose strain has passed the ultimate strain of Mander's energy balance (the first hoop
    breaks) keeps 0.2 of its strength from then on, at any strain: the first material is the part
    that ends, the second the part that is kept.
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
    """Create the confined concrete without an end and return its tag."""
    core = core_concrete(column)
    return concrete_material(core, float(core.stress_pa(core.ultimate_strain)), tags)


def bar_material(column: ColumnData, tags: TagAllocator, *, has_end: bool) -> int:
    """Create the longitudinal bars and return the tag of their material.

    With an end, a bar breaks at the reduced ultimate tensile strain and buckles at the strain that
    breaks the hoops; from then on it carries nothing.
    """
    steel = STEELS[column.steel]
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
    """Create Concrete01 with the strength, initial modulus and end of a Mander curve.

    Its parabola starts at twice strength over peak strain. The peak strain is set to meet the
    initial modulus; between, the parabola is then above the curve by less than 8 % of the strength.
    """
    material = tags.material()
    # ASSUME the right initial stiffness matters more than the strain at the peak
    peak_strain = 2 * concrete.peak_pa / concrete.modulus_pa
    points = (-concrete.peak_pa, -peak_strain, -crushed_pa, -concrete.ultimate_strain)
    ops.uniaxialMaterial("Concrete01", material, *points)
    return material


def _part(concrete: Concrete, share: float) -> Concrete:
    """Return a share of a concrete: strength and stiffness, at the same strains."""
    return replace(
        concrete, peak_pa=share * concrete.peak_pa, modulus_pa=share * concrete.modulus_pa
    )
