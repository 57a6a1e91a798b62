"""Checks of a bridge: dead load and modes before a study, and seismic design criteria."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import degrees, inf, nan, radians
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.analysis.modal import conditioning_period_s, periods_of_file, standing_bridge
from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.column import BentCapacity, bent_capacities
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.section import sdc_shear_strength
from skewbridge.bridge.structures import deck_ends
from skewbridge.units import FOOT, INCH, KN, MPA
from skewbridge.variant.variant import Variant

if TYPE_CHECKING:
    import pandas as pd

#: Limit of axial force under dead load / expected strength of the gross section.
#: source: AASHTO Guide Specifications for LRFD Seismic Bridge Design, 8.7.2, ductile columns
AXIAL_LOAD_LIMIT: Final = 0.2
P_DELTA_LIMIT: Final = 0.20  # source: Caltrans SDC 1.7 section 4.2
MINIMUM_SEAT_M: Final = 30 * INCH  # source: Caltrans SDC 1.7 section 7.8.3
SEAT_ALLOWANCE_M: Final = 4 * INCH  # source: same; added to movements and demand
# ASSUME prestress shortening, creep, shrinkage and temperature together shorten the deck by 1/1000
SHORTENING_RATIO: Final = 1.0e-3
SEISMIC_SEAT_FACTOR: Final = 1.5  # source: AASHTO LRFD table 4.7.4.4-1, higher zones
_SUPPORT: Final = "support_length_m"
# columns of the demands table with the smallest value of a column of `capacity_rows`
_LEAST: Final = {"disp_capacity_m": "capacity_m", "p_delta_capacity_m": "disp_at_p_delta_limit_m"}
#: Columns of the demands table with the capacities of the model of each analysis.
CAPACITIES: Final = (_SUPPORT, *_LEAST)
DIRECTIONS: Final = {"x": "longitudinal", "y": "transverse", "z": "vertical", "rz": "in plan"}


def check_bridge(name: str) -> dict[str, Any]:
    """Build a bridge with open gaps at zero skew, apply its dead load and check it.

    Returns:
        Dictionary of weight, reactions, periods and sources of the input numbers; ``findings``:
        sentences on properties that would cause trouble in a study; ``modes``; ``bents``: one row
        per bent with the loads and capacities of one column.
    """
    data, standing = load_bridge(name), standing_bridge(name)
    periods_s = {direction: standing.period_s(direction) for direction in DIRECTIONS}
    left, right = standing.abutment_reaction_kn
    bents = [_bent_row(data, bent) for bent in bent_capacities(data)]
    findings = [finding for row in bents for finding in _bent_findings(row)]
    findings += [
        f"the bridge is a mechanism ({DIRECTIONS[direction]}): its period is infinite"
        for direction, period_s in periods_s.items()
        if period_s == inf
    ]
    findings += [
        f"the deck lifts off the {side} abutment under dead load"
        for side, force_kn in (("left", left), ("right", right))
        if force_kn <= 0.0
    ]
    kinds = Counter(source.split(":", 1)[0] for source in data.sources.values())
    return {
        "bridge": data.name,
        "title": data.title,
        "length_m": data.length_m,
        "weight_kn": standing.weight_kn,
        "reaction_left_kn": left,
        "reaction_right_kn": right,
        **{f"period_{direction}_s": period_s for direction, period_s in periods_s.items()},
        "t1_of_the_model_s": conditioning_period_s(standing),
        "t1_of_the_file_s": data.t1_s,
        "sources": ", ".join(f"{kinds[kind]} {kind}" for kind in sorted(kinds)),
        "findings": findings + periods_of_file(name, standing),
        "modes": standing.modes,
        "bents": bents,
    }


def _bent_row(bridge: BridgeData, bent: BentCapacity) -> dict[str, Any]:
    """Return column loads and capacities, with shear strength at the displacement capacity."""
    column, plastic_moment_knm = bridge.column, bent.curve.plastic_moment_nm / KN
    strength_kn = column.expected_concrete_strength_mpa * MPA * column.gross_area_m2 / KN
    ductility = bent.capacity_m / bent.yield_disp_m
    return {
        "bent": bent.bent,
        "axial_kn": bent.axial_n / KN,
        "axial_load_ratio": bent.axial_n / KN / strength_kn,
        "axial_load_limit": AXIAL_LOAD_LIMIT,
        "plastic_moment_knm": plastic_moment_knm,
        "plastic_shear_kn": plastic_moment_knm / bent.shear_span_m,
        "shear_strength_kn": float(sdc_shear_strength(bent.shear, bent.axial_n, ductility)) / KN,
        "yield_disp_m": bent.yield_disp_m,
        "disp_capacity_m": bent.capacity_m,
        "p_delta_ratio": bent.p_delta_ratio(bent.capacity_m),
        "p_delta_limit": P_DELTA_LIMIT,
    }


def _bent_findings(row: Mapping[str, Any]) -> Iterator[str]:
    bent = f"bent {row['bent']}"
    if row["axial_load_ratio"] > AXIAL_LOAD_LIMIT:
        yield (
            f"{bent}: axial load ratio {row['axial_load_ratio']:.3f} is above "
            f"{AXIAL_LOAD_LIMIT:g} (AASHTO Guide Specifications 8.7.2)"
        )
    if row["plastic_shear_kn"] > row["shear_strength_kn"]:
        yield (
            f"{bent}: the plastic shear of a column, {row['plastic_shear_kn']:.0f} kN, "
            f"is above its design strength at the displacement capacity, "
            f"{row['shear_strength_kn']:.0f} kN (SDC 3.6): it may fail in shear before that "
            "displacement"
        )
    if row["p_delta_ratio"] > P_DELTA_LIMIT:
        yield (
            f"{bent}: P-Delta ratio {row['p_delta_ratio']:.2f} at the displacement "
            f"capacity is above {P_DELTA_LIMIT:g} (SDC 4.2)"
        )


def seat_demand_sdc_m(bridge: BridgeData, unseating_m: float) -> float:
    """Return the required support length normal to the bearing line, in m.

    References:
        Caltrans SDC 1.7 section 7.8.3.
    """
    movement = SHORTENING_RATIO * bridge.length_m / 2
    return max(movement + unseating_m + SEAT_ALLOWANCE_M, MINIMUM_SEAT_M)


def seat_demand_aashto_m(bridge: BridgeData, skew_rad: float) -> float:
    """Return the required support length 1.5 N in m.

    N = (8 + 0.02 L + 0.08 H)(1 + 0.000125 S^2) inches. L is the length of deck to the next joint in
    ft, H is the mean column height in ft, and S is the skew in degrees.

    References:
        AASHTO LRFD Bridge Design Specifications 4.7.4.4.
    """
    heights = [bent.clear_height_m for bent in bridge.bents]
    height_ft = sum(heights) / len(heights) / FOOT if heights else 0.0
    length_ft = bridge.length_m / FOOT
    skew = 1.0 + 0.000125 * degrees(skew_rad) ** 2
    return SEISMIC_SEAT_FACTOR * (8.0 + 0.02 * length_ft + 0.08 * height_ft) * skew * INCH


def capacities_of(model: BridgeModel, bents: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the capacity columns of an analysis from its model and the rows of `capacity_rows`.

    The support length is at rest and normal to the seat, nan without seats. The others are nan
    without bents.

    References:
        AASHTO LRFD figure 4.7.4.4-1: N is the overlap of girder and seat.
    """
    values = {name: [bent[of] for bent in bents] for name, of in _LEAST.items()}
    values[_SUPPORT] = [end.support_length_m for end in model.seats]
    return {name: float(min(values[name], default=nan)) for name in CAPACITIES}


def capacity_rows(bents: Iterable[BentCapacity]) -> list[dict[str, Any]]:
    """Return the capacities of bents by the Caltrans SDC, one row per bent.

    ``p_delta_ratio`` is taken at the displacement capacity. ``disp_at_p_delta_limit_m`` is the
    displacement at which the ratio reaches its limit.
    """
    rows: list[dict[str, Any]] = []
    for bent in bents:
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
    variant: Variant,
    run: Mapping[str, Any],
    bents: Iterable[Mapping[str, Any]],
    corners_m: Mapping[str, float],
) -> list[dict[str, object]]:
    """Return the design checks of one analysis, one row per check.

    Columns: check, demand, capacity, ratio and ok. ``run`` is its row of the demands table, and
    ``bents`` has the capacities of its bents. ``corners_m`` has the outward displacements of the
    deck corners, from `corner_moves_m`.
    """
    bridge, support = load_bridge(variant.bridge), float(run[_SUPPORT])
    deck_disp_m = float(run["deck_disp_m"])
    rows: list[dict[str, object]] = []

    def compare(check: str, demand: float, capacity: float) -> None:
        ratio, ok = demand / capacity, demand <= capacity
        rows.append(
            {"check": check, "demand": demand, "capacity": capacity, "ratio": ratio, "ok": ok}
        )

    for bent in bents:
        name = f"bent {bent['bent']}"
        hinge = f"{bent['hinge_length_m']:.3f} m by {bent['hinge_length_by']}"
        compare(f"{name} displacement, hinge {hinge} (m)", deck_disp_m, bent["capacity_m"])
        ratio = P_DELTA_LIMIT * deck_disp_m / bent["disp_at_p_delta_limit_m"]
        compare(f"{name} P-Delta ratio", ratio, P_DELTA_LIMIT)
    for corner, unseating_m in corners_m.items():
        compare(f"{corner} seat, SDC (m)", seat_demand_sdc_m(bridge, unseating_m), support)
    aashto_m = seat_demand_aashto_m(bridge, radians(variant.skew_deg))
    if bridge.seats:
        compare("seat, AASHTO 1.5 N (m)", aashto_m, support)
    return rows


def summary_row(variant: Variant, runs: "pd.DataFrame") -> dict[str, Any]:
    """Return the demand-to-capacity ratios of one variant, as medians over its analyses.

    ``runs`` are its rows of the demands table. Each demand is divided by the capacity of the same
    analysis. The ratios of columns are nan for a bridge without bents.
    """
    bridge, seats = load_bridge(variant.bridge), ["acute_corner_unseating_m", "unseating_m"]
    seats_m = runs[seats].map(partial(seat_demand_sdc_m, bridge))
    aashto_m, support_m = seat_demand_aashto_m(bridge, radians(variant.skew_deg)), runs[_SUPPORT]
    ratios = {
        "disp_ratio": runs["deck_disp_m"] / runs["disp_capacity_m"],
        "p_delta_ratio": P_DELTA_LIMIT * runs["deck_disp_m"] / runs["p_delta_capacity_m"],
        "seat_acute_ratio": seats_m[seats[0]] / support_m,
        "seat_worst_ratio": seats_m[seats[1]] / support_m,
        "seat_aashto_ratio": aashto_m / support_m,
    }
    return {"variant": variant.slug} | {name: each.median() for name, each in ratios.items()}


def corner_moves_m(
    variant: Variant, histories: Mapping[str, NDArray[np.float64]]
) -> dict[str, float]:
    """Return the largest outward displacement of each deck corner, normal to its seat, in m.

    The histories come from a single analysis; a corner is named ``left acute``, for example.
    """
    bridge = load_bridge(variant.bridge)
    moves: dict[str, float] = {}
    for end in deck_ends(bridge, variant.skew_deg):
        for kind in ("acute", "obtuse") if end.name in bridge.seats else ():
            name, (x, y) = f"abutment_{end.name}_{kind}", end.normal
            along = x * histories[f"{name}_x_m"] + y * histories[f"{name}_y_m"]
            moves[f"{end.name} {kind}"] = max(0.0, float(np.max(-along)))
    return moves
