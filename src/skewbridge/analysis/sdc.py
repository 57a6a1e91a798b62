"""Checks of the seismic design criteria: displacement capacity, P-Delta and seat width."""

from collections.abc import Mapping
from math import cos, degrees, radians, sin

import numpy as np
from numpy.typing import NDArray

from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.column import bent_capacities
from skewbridge.units import FOOT, INCH, KN
from skewbridge.variant.variant import Variant

P_DELTA_LIMIT = 0.20  # source: Caltrans SDC 1.7 section 4.2
MINIMUM_SEAT_M = 30 * INCH  # source: Caltrans SDC 1.7 section 7.8.3
SEAT_ALLOWANCE_M = 4 * INCH  # source: same, beyond movements and demand
# ASSUME prestress shortening, creep, shrinkage and temperature together take 1/1000 of the length
SHORTENING_RATIO = 1.0e-3
SEISMIC_SEAT_FACTOR = 1.5  # source: AASHTO LRFD table 4.7.4.4-1, higher zones


def support_length_m(variant: Variant, bridge: BridgeData) -> float:
    """Return the length of deck on the seat at rest, normal to it: the seat less the gap.

    References:
        AASHTO LRFD figure 4.7.4.4-1: N is the overlap of girder and seat.
    """
    return bridge.abutment.seat_width_m - variant.normalised().normal_gap_m()


def seat_demand_sdc_m(bridge: BridgeData, unseating_m: float) -> float:
    """Return the required support length normal to the bearing line.

    References:
        Caltrans SDC 1.7 section 7.8.3.
    """
    movement = SHORTENING_RATIO * bridge.length_m / 2
    return max(movement + unseating_m + SEAT_ALLOWANCE_M, MINIMUM_SEAT_M)


def seat_demand_aashto_m(bridge: BridgeData, skew_rad: float) -> float:
    """Return 1.5 N with the skew factor, N = (8 + 0.02 L + 0.08 H)(1 + 0.000125 S^2) inches.

    L is the length of deck to the next joint and H the mean column height, both in ft; S the skew
    in degrees.

    References:
        AASHTO LRFD Bridge Design Specifications 4.7.4.4.
    """
    heights = [bent.clear_height_m for bent in bridge.bents]
    height_ft = sum(heights) / len(heights) / FOOT if heights else 0.0
    length_ft = bridge.length_m / FOOT
    skew = 1.0 + 0.000125 * degrees(skew_rad) ** 2
    return SEISMIC_SEAT_FACTOR * (8.0 + 0.02 * length_ft + 0.08 * height_ft) * skew * INCH


def capacity_rows(bridge: BridgeData) -> list[dict[str, object]]:
    """Return the capacities of the bents of a bridge by the Caltrans SDC, a row per bent.

    The P-Delta ratio is that at the displacement capacity. ``disp_at_p_delta_limit_m`` is the
    displacement at which the ratio reaches its limit.
    """
    rows: list[dict[str, object]] = []
    for bent in bent_capacities(bridge):
        ratio = bent.p_delta_ratio(bent.capacity_m)
        rows.append(
            {
                "bent": bent.bent,
                "hinge_length_m": bent.hinge_length_m,
                "hinge_length_by": bent.hinge_length_by,
                "axial_kn": bent.axial_n / KN,
                "plastic_moment_knm": bent.curve.plastic_moment_nm / KN,
                "yield_disp_m": bent.yield_disp_m,
                "capacity_m": bent.capacity_m,
                "p_delta_ratio": ratio,
                "p_delta_limit": P_DELTA_LIMIT,
                "disp_at_p_delta_limit_m": P_DELTA_LIMIT * bent.capacity_m / ratio,
                "ok": ratio <= P_DELTA_LIMIT,
            }
        )
    return rows


def sdc_rows(
    variant: Variant, deck_disp_m: float, corners_m: Mapping[str, float]
) -> list[dict[str, object]]:
    """Return the table of checks of one variant: rows of check, demand, capacity, ratio, ok.

    The corners are named as in `corner_moves_m`, which gives their outward displacements.
    """
    bridge = load_bridge(variant.bridge)
    support, skew = support_length_m(variant, bridge), radians(variant.skew_deg)
    checks: list[tuple[str, float, float]] = []  # name, demand, capacity
    for bent in bent_capacities(bridge):
        ratio, name = bent.p_delta_ratio(deck_disp_m), f"bent {bent.bent}"
        hinge = f"hinge {bent.hinge_length_m:.3f} m by {bent.hinge_length_by}"
        checks.append((f"{name} displacement, {hinge} (m)", deck_disp_m, bent.capacity_m))
        checks.append((f"{name} P-Delta ratio", ratio, P_DELTA_LIMIT))
    for corner, unseating_m in corners_m.items():
        checks.append((f"{corner} seat, SDC (m)", seat_demand_sdc_m(bridge, unseating_m), support))
    checks.append(("seat, AASHTO 1.5 N (m)", seat_demand_aashto_m(bridge, skew), support))
    return [
        {
            "check": name,
            "demand": demand,
            "capacity": limit,
            "ratio": demand / limit,
            "ok": demand <= limit,
        }
        for name, demand, limit in checks
    ]


def summary_row(
    variant: Variant, deck_disp_m: float, acute_m: float, worst_m: float
) -> dict[str, object]:
    """Return the ratios of demand to capacity of one variant, in one row.

    The outward moves, normal to the seat, are those of the worse acute and of the worst corner.
    """
    bridge = load_bridge(variant.bridge)
    bents, support = bent_capacities(bridge), support_length_m(variant, bridge)
    aashto_m = seat_demand_aashto_m(bridge, radians(variant.skew_deg))
    return {
        "variant": variant.slug,
        "disp_ratio": max((deck_disp_m / bent.capacity_m for bent in bents), default=0.0),
        "p_delta_ratio": max((bent.p_delta_ratio(deck_disp_m) for bent in bents), default=0.0),
        "seat_acute_ratio": seat_demand_sdc_m(bridge, acute_m) / support,
        "seat_worst_ratio": seat_demand_sdc_m(bridge, worst_m) / support,
        "seat_aashto_ratio": aashto_m / support,
    }


def corner_moves_m(
    variant: Variant, histories: Mapping[str, NDArray[np.float64]]
) -> dict[str, float]:
    """Return the largest outward move of each deck corner, normal to its seat.

    The histories are those of a single analysis; a corner is named ``left acute``, for example.
    """
    skew = radians(variant.skew_deg)
    moves: dict[str, float] = {}
    for side, sign in (("left", -1.0), ("right", 1.0)):
        for kind in ("acute", "obtuse"):
            name = f"abutment_{side}_{kind}"
            along = cos(skew) * histories[f"{name}_x_m"] + sin(skew) * histories[f"{name}_y_m"]
            moves[f"{side} {kind}"] = max(0.0, float(np.max(-sign * along)))
    return moves
