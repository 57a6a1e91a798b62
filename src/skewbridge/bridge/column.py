"""Hand calculation of columns: hinges, displacement capacity, shear strength and its loss."""

from dataclasses import dataclass
from math import isclose, radians, tan
from typing import Literal

import numpy as np

from skewbridge.bridge.catalogue.columns import ColumnData, FloatArray
from skewbridge.bridge.catalogue.data import AbutmentData, Base, BridgeData
from skewbridge.bridge.section import (
    MomentCurvature,
    ShearSection,
    hoop_strength_n,
    section_response,
    shear_modulus_pa,
    shear_strength,
    steel_of,
)
from skewbridge.bridge.weights import column_axial_n, deck_reactions_n
from skewbridge.units import GPA, MM, MPA
from skewbridge.variant.options import DEFAULT_SHEAR_MODEL, HingeRule, ShearModel

CRACK_ANGLE_DEG = 65.0  # source: Elwood and Moehle (2005)
SHEAR_AREA_RATIO = 0.8  # source: Caltrans SDC 1.7 section 3.6.2, effective over gross area
# ASSUME a broken column keeps a tenth of its shear strength: friction and hoops across the crack
RESIDUAL_SHEAR = 0.1
RIGID = 1e3  # rotational stiffness of supports / torsional stiffness of the deck


@dataclass(frozen=True, slots=True, kw_only=True)
class BentCapacity:
    """Displacement capacity under dead load of each column of a bent, whose columns are equal.

    The displacement is normal to the bent, along it, or in any direction; bents count from 1. The
    shear span is from a hinge to the point of contraflexure; the axial force is at the base.
    """

    bent: int
    direction: Literal["all", "normal", "along"]
    column: ColumnData
    base: Base
    clear_height_m: float
    shear_span_m: float
    axial_n: float
    curve: MomentCurvature
    hinge_length_m: float
    yield_disp_m: float
    capacity_m: float

    def p_delta_ratio(self, disp_m: float) -> float:
        """Return dead load x offset of the point of contraflexure / plastic moment."""
        offset_m = disp_m * self.shear_span_m / self.clear_height_m
        return self.axial_n * offset_m / self.curve.plastic_moment_nm

    @property
    def hinge_length_by(self) -> str:
        """Origin of the hinge length: ``rule``, or the bridge ``file``."""
        return "rule" if self.column.hinge_length_m is None else "file"

    @property
    def shear(self) -> ShearSection:
        """Inputs of the shear strength."""
        direction = int(self.direction == "along")
        return shear_section(self.column, self.shear_span_m, self.curve, direction)


def bent_capacity(
    bridge: BridgeData, bent_number: int, hinge_rule: HingeRule = "sdc", direction: int = 0
) -> BentCapacity:
    """Return the displacement capacity of a bent (0, 1, ...), normal (0) to it or along it (1).

    References:
        Caltrans SDC 1.7 section 3.1.3.
    """
    bent = bridge.bents[bent_number]
    column, base, height_m = bridge.column_of(bent), bridge.base_of(bent), bent.clear_height_m
    is_round = column.outline.is_round
    axial_n = column_axial_n(bridge, bent_number)
    curve = section_response(column, axial_n, 0 if is_round else direction)
    spans = [shear_span_m(bridge, bent_number, side, hinge_rule) for side in (0, 1)]
    is_equal, span = is_round and isclose(*spans), spans[direction]
    hinges = 1 if span >= height_m else 2
    hinge = hinge_length_m(column, span, hinge_rule)
    # curvatures grow linearly with the distance from the point of contraflexure
    elastic = curve.yield_curvature_per_m * height_m**2 * (3 - height_m / span) / 6
    rotation = hinge * (curve.ultimate_curvature_per_m - curve.yield_curvature_per_m)
    return BentCapacity(
        bent=bent_number + 1,
        direction="all" if is_equal else ("normal", "along")[direction],
        column=column,
        base=base,
        clear_height_m=height_m,
        shear_span_m=span,
        axial_n=axial_n,
        curve=curve,
        hinge_length_m=hinge,
        yield_disp_m=elastic,
        capacity_m=elastic + rotation * (height_m - hinges * hinge / 2),
    )


def shear_span_m(
    bridge: BridgeData, bent_number: int, direction: int, hinge_rule: HingeRule = "sdc"
) -> float:
    """Return the height (m) of zero moment above a fixed base, or the height if it is pinned.

    It is at mid-height, except at bearings in bending normal to a bent below them, and along a bent
    of a single column (`single_column_spans_m`).
    """
    bent = bridge.bents[bent_number]
    if bridge.base_of(bent) == "pinned":
        return bent.clear_height_m
    if direction == 1 and (ratio := bridge.column_of(bent).shear_span_ratio) is not None:
        return ratio * bent.clear_height_m
    if direction == 1 and bent.columns == 1:
        return single_column_spans_m(bridge, hinge_rule)[bent_number]
    if direction == 0 and bent_number in bridge.bents_with_bearings:
        return bent.clear_height_m + bent.cap_depth_m  # ASSUME bearings transfer no moment
    return bent.clear_height_m / 2  # ASSUME symmetric double curvature


def single_column_spans_m(bridge: BridgeData, hinge_rule: HingeRule) -> dict[int, float]:
    """Return the height (m) of zero moment along bents of one fixed column, by bent number.

    Each column is at its displacement capacity under a load at the centroid of the deck. Its base
    has a plastic hinge; its top bends as far as the deck resists rolling, by its elastic torsion
    and the ends, until the top yields or the pads of a seat lift off.
    """
    deck, half_m = bridge.deck, bridge.length_m / 2
    twist_nm = shear_modulus_pa(deck.elastic_modulus_gpa * GPA) * deck.torsion_constant_m4
    twist_nm /= np.diff([-half_m, *bridge.bent_positions_m, half_m])
    torsion_nm = np.diag(np.append(twist_nm, 0.0) + np.append(0.0, twist_nm))
    torsion_nm -= np.diag(twist_nm, 1) + np.diag(twist_nm, -1)
    # torque on the deck at ends and bents: without rolling, its decrease with rolling, its limits
    # ASSUME ends and bents of several columns do not roll; a single pinned column does not resist
    start_nm, slope_nm, low_nm, high_nm = springs = np.zeros((4, len(torsion_nm)))
    slope_nm += RIGID * twist_nm.max()
    high_nm += np.inf
    for end, data in zip((0, -1), bridge.ends.values(), strict=True):
        if isinstance(data, AbutmentData):
            radius_m = data.pads.spacing_m * np.sqrt((data.pads.count**2 - 1) / 12)
            high_nm[end] = max(deck_reactions_n(bridge)[end], 0.0) * radius_m
    low_nm -= high_nm
    columns: dict[int, tuple[float, float]] = {}  # height of the load above the base, Mp
    for number, bent in enumerate(bridge.bents):
        if bent.columns > 1:
            continue
        place, column, height_m = number + 1, bridge.column_of(bent), bent.clear_height_m
        springs[:, place] = 0.0
        if bridge.base_of(bent) == "pinned":
            continue
        direction = int(not column.outline.is_round)
        curve = section_response(column, column_axial_n(bridge, number), direction)
        plastic_nm, yield_per_m = curve.plastic_moment_nm, curve.yield_curvature_per_m
        hinge_m = hinge_length_m(column, height_m / 2, hinge_rule)
        hinge_rotation = hinge_m * (curve.ultimate_curvature_per_m - yield_per_m)
        load_m = height_m + deck.centroid_above_soffit_m
        load_m += bent.cap_depth_m if number in bridge.bents_with_bearings else 0.0
        # slope-deflection: top moment = Mp + 2 E I / H (rotation of the hinge - rolling) <= Mp
        slope_nm[place] = 2 * plastic_nm / yield_per_m * load_m / height_m**2
        high_nm[place] = plastic_nm * (2 * load_m / height_m - 1)
        start_nm[place] = high_nm[place] + slope_nm[place] * hinge_rotation
        columns[number] = load_m, plastic_nm
    torques_nm = _torques_nm(torsion_nm, springs)
    return {
        number: float(load_m / (1 + torques_nm[number + 1] / plastic_nm))
        for number, (load_m, plastic_nm) in columns.items()
    }


def _torques_nm(torsion_nm: FloatArray, springs: FloatArray) -> FloatArray:
    """Return the torques on a shaft of stiffness ``torsion_nm`` by springs with limits.

    Newton's method on a convex energy, without steps beyond the minimum along their direction.
    """
    start_nm, slope_nm, *limits_nm = springs
    rotation = np.zeros(len(start_nm))

    def torques_nm(rotation: FloatArray) -> FloatArray:
        return np.clip(start_nm - slope_nm * rotation, *limits_nm)

    for _ in range(300):  # a few are enough for usual bridges
        is_free = (torque_nm := torques_nm(rotation)) == start_nm - slope_nm * rotation
        tangent_nm = torsion_nm + np.diag(np.where(is_free, slope_nm, slope_nm / RIGID**2))
        change = np.linalg.solve(tangent_nm, torque_nm - torsion_nm @ rotation)
        while change @ (torques_nm(rotation + change) - torsion_nm @ (rotation + change)) < 0.0:
            change /= 2
        rotation += change
        if np.abs(change).max() < 1e-12:
            break
    return torques_nm(rotation)


def bent_directions(
    bridge: BridgeData, bent_number: int, hinge_rule: HingeRule = "sdc"
) -> tuple[BentCapacity, BentCapacity]:
    """Return the capacities of a bent normal to it and along it (one object if they are equal)."""
    normal = bent_capacity(bridge, bent_number, hinge_rule)
    if normal.direction == "all":
        return normal, normal
    return normal, bent_capacity(bridge, bent_number, hinge_rule, 1)


def bent_capacities(bridge: BridgeData, hinge_rule: HingeRule = "sdc") -> list[BentCapacity]:
    """Return the displacement capacities of all bents under a rigid deck, in each direction."""
    pairs = [bent_directions(bridge, number, hinge_rule) for number in range(len(bridge.bents))]
    return [bent for pair in pairs for bent in pair[: 1 if pair[0] is pair[1] else 2]]


def hinge_length_m(column: ColumnData, shear_span_m: float, rule: HingeRule) -> float:
    """Return the length of the plastic hinges in m, from the bridge file if given, or by a rule.

    Rules: 0.08 x span + 0.022 fye db (yield MPa, bar diameter mm); ``sdc``: at least 0.044 fye db.

    References:
        Caltrans SDC 1.7 section 7.6.2, equation 7.25; Paulay and Priestley (1992), Seismic Design
        of Reinforced Concrete and Masonry Buildings, equation 3.39.
    """
    if column.hinge_length_m is not None:
        return column.hinge_length_m
    penetration_m = 0.022 * steel_of(column).yield_pa / MPA * column.bar_diameter_mm * MM
    by_rule_m = 0.08 * shear_span_m + penetration_m
    return max(by_rule_m, 2 * penetration_m) if rule == "sdc" else by_rule_m


def shear_section(
    column: ColumnData, span_m: float, curve: MomentCurvature, direction: int = 0
) -> ShearSection:
    """Return the shear-strength inputs of a column for a shear span and moment-curvature curve."""
    outline, hoops = column.outline, column.hoops
    return ShearSection(
        depth_m=outline.sizes_m[direction],
        gross_area_m2=outline.area_m2,
        cover_m=column.cover_to_hoop_m + column.hoop_diameter_mm * MM / 2,
        hoop_area_m2=hoops.shear_area_m2[direction],
        hoop_depth_m=hoops.shear_depth_m[direction],
        hoop_ratio=hoops.shear_ratio[direction],
        hoop_spacing_m=column.hoop_spacing_mm * MM,
        hoop_yield_pa=column.hoop_yield_mpa * MPA,
        concrete_strength_pa=column.concrete_strength_mpa * MPA,
        expected_hoop_yield_pa=steel_of(column).yield_pa,
        expected_concrete_strength_pa=column.expected_concrete_strength_mpa * MPA,
        longitudinal_ratio=column.steel_area_m2 / outline.area_m2,
        shear_span_m=span_m,
        neutral_axis_depth_m=curve.neutral_axis_depth_m,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ShearLoss:
    """Shear force-deformation backbone of a column in one direction.

    The column fails at the force ``strength_n`` and the shear deformation ``elastic_m``; its shear
    deformation is ``residual_m`` where the strength is residual. ``failure_drift_ratio`` is the
    flexural drift at failure in a push, or at the displacement capacity without failure.
    """

    strength_n: float
    elastic_m: float
    failure_drift_ratio: float
    residual_m: float


def shear_loss(bent: BentCapacity, shear_model: ShearModel = DEFAULT_SHEAR_MODEL) -> ShearLoss:
    """Return the shear backbone of a column of a bent, with a linear loss of strength.

    It fails when its flexural shear, M(phi) / shear span, reaches the capacity at the same
    ductility; else the strength is the capacity at the ultimate curvature. The shear falls to zero
    at the drift of axial failure, but not below the residual strength.

    References:
        Elwood and Moehle (2005), Earthquake Spectra 21(1), 71-89: drift at axial failure; Elwood
        (2004), Can. J. Civ. Eng. 31(5), 846-859: linear loss.
    """
    curve, height_m, section = bent.curve, bent.clear_height_m, bent.shear
    phi_y, yield_drift = curve.yield_curvature_per_m, bent.yield_disp_m / height_m
    plastic_ratio = (curve.curvature_per_m - phi_y) / (curve.ultimate_curvature_per_m - phi_y)
    drift = np.minimum(curve.curvature_per_m / phi_y, 1.0) * yield_drift
    drift += np.maximum(plastic_ratio, 0.0) * (bent.capacity_m / height_m - yield_drift)
    ductilities = drift / yield_drift, curve.curvature_per_m / phi_y
    capacity = shear_strength(section, shear_model, bent.axial_n, *ductilities)
    shear = curve.moment_nm / bent.shear_span_m
    has_failed = shear >= capacity
    failure = int(has_failed.argmax()) if has_failed.any() else -1
    strength_n = float(shear[failure] if has_failed.any() else capacity[failure])
    area_m2 = SHEAR_AREA_RATIO * section.gross_area_m2
    shear_pa = shear_modulus_pa(bent.column.elastic_modulus_gpa * GPA)
    elastic_m = strength_n * height_m / (shear_pa * area_m2)
    loss_m = (axial_failure_drift(section, bent.axial_n) - float(drift[failure])) * height_m
    return ShearLoss(
        strength_n=strength_n,
        elastic_m=elastic_m,
        failure_drift_ratio=float(drift[failure]),
        # never steeper than the elastic branch
        residual_m=elastic_m + (1.0 - RESIDUAL_SHEAR) * max(loss_m, elastic_m),
    )


def axial_failure_drift(section: ShearSection, axial_n: float) -> float:
    """Return the drift ratio at which a column that failed in shear loses its axial load.

    References:
        Elwood and Moehle (2005), equation 3.
    """
    slope = tan(radians(CRACK_ANGLE_DEG))
    hoops_n = hoop_strength_n(section.as_expected)
    return 0.04 * (1.0 + slope**2) / (slope + axial_n / (hoops_n * slope))
