"""Plastic hinges of the columns: length, and displacement capacity of the bents."""

from dataclasses import dataclass

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.gravity import column_axial_n
from skewbridge.bridge.materials import steel_of
from skewbridge.bridge.moment_curvature import section_response
from skewbridge.units import MM, MPA
from skewbridge.variant.options import HingeRule


@dataclass(frozen=True, slots=True, kw_only=True)
class BentCapacity:
    """Displacement capacity of a bent by its plastic hinges, columns under dead load.

    The bent is numbered from the left, 1 and up; moment, axial force and hinge are those of one
    column. The capacity is the displacement at the ultimate curvature.
    """

    bent: int
    plastic_moment_nm: float
    axial_n: float
    hinge_length_m: float
    yield_disp_m: float
    capacity_m: float

    def p_delta_ratio(self, disp_m: float) -> float:
        """Return dead load times demand over plastic moment."""
        return self.axial_n * disp_m / self.plastic_moment_nm


def shear_span_m(bridge: BridgeData, bent_number: int) -> float:
    """Return the length from a plastic hinge to the point of contraflexure.

    The bent number counts from 0.
    """
    # ASSUME a pinned column bends in single, a fixed one in symmetric double curvature
    height_m = bridge.bents[bent_number].clear_height_m
    return height_m if bridge.base == "pinned" else height_m / 2


def hinge_length_m(bridge: BridgeData, bent_number: int, rule: HingeRule = "sdc") -> float:
    """Return the length of the plastic hinges of a bent, from the bridge file or else by a rule.

    Both rules are 0.08 L + 0.022 fye db (MPa, mm) with the shear span L. Rule ``sdc`` has the lower
    limit 0.044 fye db, which governs short spans.

    References:
        Caltrans SDC 1.7 section 7.6.2, equation 7.25; Paulay and Priestley (1992), Seismic Design
        of Reinforced Concrete and Masonry Buildings, equation 3.39, without the lower limit.
    """
    column = bridge.column
    if column.hinge_length_m is not None:
        return column.hinge_length_m
    penetration_m = 0.022 * steel_of(column).yield_pa / MPA * column.bar_diameter_mm * MM
    by_rule = 0.08 * shear_span_m(bridge, bent_number) + penetration_m
    return max(by_rule, 2 * penetration_m) if rule == "sdc" else by_rule


def hinge_length_source(bridge: BridgeData) -> str:
    """Return the origin of the hinge lengths of a bridge: ``rule`` or its ``file``."""
    return "rule" if bridge.column.hinge_length_m is None else "file"


def bent_capacity(
    bridge: BridgeData, bent_number: int, hinge_rule: HingeRule = "sdc"
) -> BentCapacity:
    """Return the displacement capacity of a bent (numbered from 0) under a rigid deck.

    A pinned column is a cantilever from the base, a fixed one two cantilevers of half its height.

    References:
        Caltrans SDC 1.7 section 3.1.3.
    """
    axial_n = column_axial_n(bridge, bent_number)
    curve = section_response(bridge.column, axial_n)
    parts = 1 if bridge.base == "pinned" else 2
    span = shear_span_m(bridge, bent_number)
    hinge = hinge_length_m(bridge, bent_number, hinge_rule)
    elastic = curve.yield_curvature_per_m * span**2 / 3
    rotation = hinge * (curve.ultimate_curvature_per_m - curve.yield_curvature_per_m)
    return BentCapacity(
        bent=bent_number + 1,
        plastic_moment_nm=curve.plastic_moment_nm,
        axial_n=axial_n,
        hinge_length_m=hinge,
        yield_disp_m=parts * elastic,
        capacity_m=parts * (elastic + rotation * (span - hinge / 2)),
    )


def bent_capacities(bridge: BridgeData) -> list[BentCapacity]:
    """Return the displacement capacities of all bents under a rigid deck."""
    return [bent_capacity(bridge, number) for number in range(len(bridge.bents))]
