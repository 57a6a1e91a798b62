"""Checks of a bridge: dead load and modes before a study, and seismic design criteria."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, pairwise, product
from math import inf
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.analysis.modal import (
    ModalResult,
    conditioning_period_s,
    periods_of_file,
    standing_bridge,
)
from skewbridge.bridge.catalogue import read_bridge
from skewbridge.bridge.catalogue.drawing import (
    TABLES,
    Completed,
    Formula,
    is_concrete,
    placed,
    places,
    value_at,
)
from skewbridge.bridge.column import BentCapacity, bent_capacities
from skewbridge.bridge.frame import Description
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.section import sdc_shear_strength
from skewbridge.bridge.structures import CatalogueBridge
from skewbridge.errors import InputError
from skewbridge.units import FOOT, G_MPS2, INCH, KN, MM, MPA
from skewbridge.variant.axes import axis
from skewbridge.variant.variant import Variant

#: Limit of axial force under dead load / expected strength of the gross section.
#: source: AASHTO Guide Specifications for LRFD Seismic Bridge Design, 8.7.2, ductile columns
AXIAL_LOAD_LIMIT: Final = 0.2
P_DELTA_LIMIT: Final = 0.20  # source: Caltrans SDC 1.7 section 4.2
OVERSTRENGTH: Final = 1.2  # source: Caltrans SDC 1.7 section 4.3.1, of the plastic moment
SHEAR_RESISTANCE: Final = 0.9  # source: Caltrans SDC 1.7 section 3.6.1
ABUTMENT_CLAUSE: Final = "Caltrans SDC 1.7 section 7.8.3 (abutments)"
HINGE_CLAUSE: Final = "Caltrans SDC 1.7 section 7.2.5.4 (hinges)"
AASHTO_CLAUSE: Final = "AASHTO LRFD 4.7.4.4 (1.5 N)"
MINIMUM_SEAT_M: Final = 30 * INCH  # source: `ABUTMENT_CLAUSE`
MINIMUM_HINGE_M: Final = 24 * INCH  # source: `HINGE_CLAUSE`
SEAT_ALLOWANCE_M: Final = 4 * INCH  # source: both; added to movements and demand
# ASSUME prestress shortening, creep, shrinkage and temperature together shorten the deck by 1/1000,
# half at each end unless one is held
SHORTENING_RATIO: Final = 1.0e-3
SEISMIC_SEAT_FACTOR: Final = 1.5  # source: AASHTO LRFD table 4.7.4.4-1, higher zones
#: Column of the demands table: length of the deck on its seats at rest (AASHTO figure 4.7.4.4-1).
SUPPORT: Final = "support_length_m"
#: Usual ranges: formula, ends of the ranges, and the words for a formula.
_USUAL: Final = [(Formula(text), limits) for text, limits in TABLES["usual"].items()]
#: Change of a rule's value above which an inherited number is stale.
_STALE: Final = 0.1
DIRECTIONS: Final = {"x": "longitudinal", "y": "transverse", "z": "vertical", "rz": "in plan"}


def check_bridge(name: str) -> dict[str, Any]:
    """Build a bridge with open gaps at zero skew, apply its dead load and check it.

    Returns weight, reactions, periods and sources; ``findings`` (sentences on what would cause
    trouble in a study), ``modes``, ``bents``, numbers ``derived`` by rules, with the rules, and
    keys ``inherited`` from the bridge that the file extends.
    """
    structure, at_rest = load_structure(name), standing_bridge(name)
    filled = read_bridge(name) if isinstance(structure, CatalogueBridge) else None
    periods_s = {direction: at_rest.period_s(direction) for direction in DIRECTIONS}
    left, right = at_rest.abutment_reaction_kn
    inherited = sorted(filled.inherited - filled.derived.keys()) if filled else []
    bents = capacity_rows(bent_capacities(filled.bridge)) if filled else []
    findings = [finding for row in bents for finding in bent_findings(row)]
    findings += [
        f"the bridge is a mechanism ({words}): its period is infinite"
        for direction, words in DIRECTIONS.items()
        if periods_s[direction] == inf
    ]
    findings += [
        f"the deck lifts off the {side} abutment under dead load"
        for side, force_kn in (("left", left), ("right", right))
        if force_kn <= 0.0
    ]
    description = structure.description
    findings += doubts(filled) if filled else _unit_doubts(description, at_rest)
    findings += _seat_findings(description)
    return {
        "bridge": structure.name,
        "title": description.title,
        "length_m": description.length_m,
        "weight_kn": at_rest.weight_kn,
        "reaction_left_kn": left,
        "reaction_right_kn": right,
        **{f"period_{direction}_s": period_s for direction, period_s in periods_s.items()},
        "t1_of_the_model_s": conditioning_period_s(at_rest),
        "t1_of_the_file_s": structure.t1_s,
        "sources": "" if filled is None else _sources(filled, inherited),
        "findings": findings + periods_of_file(name, at_rest),
        "modes": at_rest.modes,
        "bents": bents,
        "inherited": inherited,
        "derived": [
            {"number": key, "value": value_at(filled.bridge, key), "rule": rule.src}
            for key, rule in filled.derived.items()
        ]
        if filled
        else [],
    }


def _sources(filled: Completed, inherited: Sequence[str]) -> str:
    sources = filled.bridge.sources
    stated_keys = sources.keys() - filled.derived.keys() - filled.inherited
    kinds = Counter(sources[key].split(":", 1)[0] for key in stated_keys)
    counts = [*(f"{kinds[kind]} {kind}" for kind in sorted(kinds)), f"{len(inherited)} inherited"]
    return ", ".join([*counts, f"{len(filled.derived)} by rule"])


# --- doubts about numbers: swapped, mistyped, in another unit, or inherited


def doubts(filled: Completed) -> list[str]:
    """Return a sentence for each number, or ratio of numbers, of a bridge file that looks wrong."""
    text = "has no effect: the file has the numbers that follow from it"
    unused = [f"{key} {text}" for key in filled.unused()]
    return [*unused, *_outside_ranges(filled), *_unlike_rules(filled)]


def _unit_doubts(bridge: Description, at_rest: ModalResult) -> Iterator[str]:
    """Yield a sentence for each value of a bridge script that suggests a wrong unit."""
    per_m2 = at_rest.weight_kn / (bridge.length_m * bridge.width_m)
    size_values = (bridge.length_m,), (bridge.width_m,), (per_m2,), bridge.bent_heights_m
    gaps_mm = tuple(filter(None, bridge.gaps_mm.values()))
    mass_ratios = (at_rest.mass_t * G_MPS2 / at_rest.weight_kn,) if at_rest.weight_kn else ()
    values = (conditioning_period_s(at_rest),), *size_values, gaps_mm, mass_ratios
    for (name, (low, high)), stated_values in zip(TABLES["script"].items(), values, strict=True):
        if outside := [value for value in stated_values if not low <= value <= high]:
            text = f"is outside the usual {low:g} to {high:g}: check units, masses and loads"
            yield f"{name} = {outside[0]:.3g} {text}"


def _outside_ranges(filled: Completed) -> Iterator[str]:
    tree = {**filled.bridge.model_dump(exclude={"sources"}), "bridge": filled.bridge}
    for formula, row in _USUAL:
        limits = [limit for limit in row if not isinstance(limit, str)]
        ranges = list(zip(limits[::2], limits[1::2], strict=True))
        outside: dict[tuple[str, float], list[str]] = {}
        for section, keys in _placed_keys(tree, formula.needs):
            known = {
                need: filled.drawn.get(key, value_at(tree, key))
                for need, key in zip(formula.needs, keys, strict=True)
            }
            for value in np.ravel(formula.value(known.get)):
                if value is not None and not any(low <= value <= high for low, high in ranges):
                    outside.setdefault((section, float(value)), keys)
        for (_, value), keys in sorted(outside.items()):
            range_text = " or ".join(
                f"{low:g} to {high:g}" if low < high else f"{low:g}" for low, high in ranges
            )
            text = f"= {value:.3g} is outside the usual {range_text}"
            if limits != row:
                yield f"{row[-1]} {text} ({', '.join(keys)})"
            else:
                rule = filled.derived.get(keys[0])
                yield f"{keys[0]} {text}" + (f" (by rule, {rule.src})" if rule else "")


def _placed_keys(tree: Mapping[str, Any], needs: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Yield section and keys of a formula for each end, joint, bent, and column of a bent."""
    is_of_bents = any("*" in key for key in needs)
    is_of_columns = any(key.startswith("column.") for key in needs)
    with_own = [n for n, bent in enumerate(tree["bents"]) if bent["column"] and is_of_columns]
    for section, number in places(tree, needs):
        keys = [placed(key, section, number) for key in needs]
        bents = [n for n in with_own if not is_of_bents or n == number]
        if not (is_of_bents and bents):
            yield section, keys
        for bent in bents:
            yield section, [re.sub(r"^column\b", f"bents.{bent}.column", key) for key in keys]


def _unlike_rules(filled: Completed) -> Iterator[str]:
    """Yield a sentence on each number far from its rule, and on inherited ones that are stale."""
    edited = filled.bridge.sources.keys() - filled.inherited - filled.derived.keys()
    stale: list[str] = []
    unusual = [] if is_concrete(filled.bridge.deck.elastic_modulus_gpa) else TABLES["concrete"]
    # a cap below bearings is not as deep as the deck
    unusual = {*unusual, *(f"bents.{n}.cap_depth_m" for n in filled.bridge.bents_with_bearings)}
    for key, (value, rule) in filled.by_rule().items():
        if rule.within is None or key in filled.derived or unusual & {key, rule.key}:
            continue
        values = np.ravel(value_at(filled.bridge, key))
        if not all(values) or not np.all(value):  # no weight, for example of a cap, is a choice
            continue
        factors = values / np.ravel(value)
        worst = float(factors[np.abs(np.log(factors)).argmax()])
        if not 1 / rule.within <= worst <= rule.within:
            rule_text = ", ".join(f"{number:.4g}" for number in np.ravel(value))
            worst = float(f"{worst:.2g}")
            yield f"{key} is {worst:g} times {rule_text}, the value of its rule ({rule.src})"
        is_edited = any(f"{new}.".startswith(f"{old}.") for old in rule.follows for new in edited)
        if key in filled.inherited and is_edited and np.abs(factors - 1.0).max() > _STALE:
            stale.append(f"{key} ({np.ravel(value).max():.4g} by its rule)")
    if stale:
        text = "numbers are inherited although inputs of their rules have changed: state them"
        yield f"{text}: {', '.join(stale)}"


def _seat_findings(bridge: Description) -> Iterator[str]:
    gap_mm = axis("gap_mm").usual  # of a seat that takes that of the variant
    gaps_m = {end: bridge.gaps_mm.get(end, gap_mm) * MM for end in bridge.seats_m}
    for end, length_m in bridge.support_lengths_m(gaps_m).items():
        sdc = ABUTMENT_CLAUSE, MINIMUM_SEAT_M
        if end not in bridge.end_kinds:
            sdc = HINGE_CLAUSE, MINIMUM_HINGE_M
        for clause, least_m in (sdc, (AASHTO_CLAUSE, seat_demand_aashto_m(bridge, end, 0.0))):
            if length_m < least_m:
                text = f"below {least_m:.3g} m by {clause}; check the edition that applies"
                seat = f"the {end} seat of {bridge.seats_m[end]:.4g} m"
                lost_mm = (bridge.seats_m[end] - length_m) / MM  # half of the gap on a cap
                yield f"{seat} less {lost_mm:.4g} mm of gap leaves {length_m:.4g} m, {text}"


def capacity_rows(bents: Iterable[BentCapacity]) -> list[dict[str, Any]]:
    """Return dead loads and capacities of bents by the Caltrans SDC, one row per bent.

    Shear strengths and ``p_delta_ratio`` are at the displacement capacity: ``shear_strength_kn``
    is nominal and forecasts failure, ``design_strength_kn`` and 1.2 Mp / L are for design.
    """
    rows: list[dict[str, Any]] = []
    for bent in bents:
        column, plastic_moment_knm = bent.column, bent.curve.plastic_moment_nm / KN
        plastic_kn = plastic_moment_knm / bent.shear_span_m
        strength_kn = column.expected_concrete_strength_mpa * MPA * column.outline.area_m2 / KN
        ductility, ratio = bent.capacity_m / bent.yield_disp_m, bent.p_delta_ratio(bent.capacity_m)
        nominal_kn = float(sdc_shear_strength(bent.shear, bent.axial_n, ductility)) / KN
        row: dict[str, Any] = {
            "bent": bent.bent,
            "direction": bent.direction,
            "hinge_length_m": bent.hinge_length_m,
            "hinge_length_by": bent.hinge_length_by,
            "axial_kn": bent.axial_n / KN,
            "axial_load_ratio": bent.axial_n / KN / strength_kn,
            "axial_load_limit": AXIAL_LOAD_LIMIT,
            "plastic_moment_knm": plastic_moment_knm,
            "plastic_shear_kn": plastic_kn,
            "shear_strength_kn": nominal_kn,
            "overstrength_shear_kn": OVERSTRENGTH * plastic_kn,
            "design_strength_kn": SHEAR_RESISTANCE * nominal_kn,
            "yield_disp_m": bent.yield_disp_m,
            "capacity_m": bent.capacity_m,
            "p_delta_ratio": ratio,
            "p_delta_limit": P_DELTA_LIMIT,
            "disp_at_p_delta_limit_m": P_DELTA_LIMIT * bent.capacity_m / ratio,
        }
        rows.append({**row, "ok": not any(bent_findings(row))})
    return rows


def bent_findings(row: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each limit that a row of `capacity_rows` exceeds."""
    factors = {"overstrength": OVERSTRENGTH, "resistance": SHEAR_RESISTANCE}
    for demand, (capacity, text) in TABLES["bents"].items():
        if row[demand] > row[capacity]:
            yield f"{_name(row)}: {text.format(**row, **factors)}"


def _name(bent: Mapping[str, Any]) -> str:
    direction = "" if bent["direction"] == "all" else f" ({bent['direction']})"
    return f"bent {bent['bent']}{direction}"


def seat_demand_sdc_m(
    bridge: Description, unseating_m: float, minimum_m: float = MINIMUM_SEAT_M
) -> float:
    """Return the support length (m), normal to the bearing line, that an unseating requires.

    References:
        Caltrans SDC 1.7 sections 7.8.3, abutments, and 7.2.5.4, hinges.
    """
    half_m = bridge.length_m / 2
    joints_m = sorted(x for place, x in bridge.joints_m.items() if place.startswith("bent"))
    sides = {"left": -half_m, "right": half_m}.items()
    held_m = {x for end, x in sides if bridge.end_kinds[end] in ("integral", "fixed")}
    moving_m = max(
        right - left if {left, right} & held_m else (right - left) / 2
        for left, right in pairwise((-half_m, *joints_m, half_m))
    )
    return max(SHORTENING_RATIO * moving_m + unseating_m + SEAT_ALLOWANCE_M, minimum_m)


def seat_demand_aashto_m(bridge: Description, seat: str, skew_deg: float) -> float:
    """Return the support length 1.5 N in m that an end or inner joint requires.

    N = (8 + 0.02 L + 0.08 H)(1 + 0.000125 S^2) inches: length L of the deck to the next joint (of
    both decks at a hinge) and mean height H of its columns (at a joint: of its bent, or of the
    bents next to a hinge) in ft; skew S in degrees, that of the variant unless the file has one.

    References:
        AASHTO LRFD Bridge Design Specifications 4.7.4.4.
    """
    half_m = bridge.length_m / 2
    heights_m = dict(zip(accumulate(bridge.spans_m[:-1]), bridge.bent_heights_m, strict=True))
    heights_m = {round(x - half_m, 6): height_m for x, height_m in heights_m.items()}
    joints_m = {f"joint {n}": round(x, 6) for n, x in enumerate(bridge.joints_m.values(), start=1)}
    places_m = {"left": -half_m, **joints_m, "right": half_m}
    at_m = places_m[seat]
    left_m, right_m = _neighbours(places_m.values(), at_m)
    length_m = right_m - left_m
    if at_m in heights_m:
        length_m = max(at_m - left_m, right_m - at_m)
        left_m = right_m = at_m
    elif seat in joints_m:
        left_m, right_m = _neighbours(heights_m, at_m)
    nearby_m = [height_m for x, height_m in heights_m.items() if left_m <= x <= right_m]
    height_ft = sum(nearby_m) / max(len(nearby_m), 1) / FOOT
    skew_factor = 1.0 + 0.000125 * bridge.skews_deg.get(seat, skew_deg) ** 2
    length_in = 8.0 + 0.02 * length_m / FOOT + 0.08 * height_ft
    return SEISMIC_SEAT_FACTOR * length_in * skew_factor * INCH


def _neighbours(places_m: Iterable[float], at_m: float) -> tuple[float, float]:
    """Return the next place (m) on the left and on the right, or the place itself."""
    left = max((x for x in places_m if x < at_m), default=at_m)
    return left, min((x for x in places_m if x > at_m), default=at_m)


def sdc_rows(
    variant: Variant,
    run: Mapping[str, Any],
    bents: Iterable[Mapping[str, Any]],
    histories: Mapping[str, NDArray[np.float64]],
) -> list[dict[str, object]]:
    """Return the SDC design checks of one analysis, one row per check.

    ``run`` is its row of the demands table. Drifts of ``histories`` are limited to the peaks in
    this row, which end at the failure of a column.
    """
    bridge = load_structure(variant.bridge).description
    # the deck moves more than the columns if it turns, or slides on the pads of a joint
    drift, share = float(run["column_drift_ratio"]), float(run.get("drift_over_capacity", inf))
    rows: list[dict[str, object]] = []

    def compare(check: str, demand: float, capacity: float) -> None:
        ratio, ok = demand / capacity, demand <= capacity
        rows.append(
            {"check": check, "demand": demand, "capacity": capacity, "ratio": ratio, "ok": ok}
        )

    for bent in bents:
        name = _name(bent)
        number = bent["bent"] - 1
        first = sum(bridge.bent_columns[:number]) + 1
        columns = range(first, first + bridge.bent_columns[number])
        drifts = [float(np.max(histories[f"column_{n}_drift_ratio"])) for n in columns]
        disp_m = min(drift, max(drifts)) * bridge.bent_heights_m[number]
        disp_m = min(disp_m, share * bent["capacity_m"])
        check = f"{name} displacement, hinge by {bent['hinge_length_by']} (m)"
        compare(check, disp_m, bent["capacity_m"])
        ratio = P_DELTA_LIMIT * disp_m / bent["disp_at_p_delta_limit_m"]
        compare(f"{name} P-Delta ratio", ratio, P_DELTA_LIMIT)
        shears_kn = bent["overstrength_shear_kn"], bent["design_strength_kn"]
        factors = f"{OVERSTRENGTH:g} Mp/L, {SHEAR_RESISTANCE:g} Vn"
        compare(f"{name} column shear, {factors} (kN)", *shears_kn)
    corners_m = corner_moves_m(bridge, histories, float(run[SUPPORT]))
    for corner, (unseating_m, length_m) in corners_m.items():
        compare(f"{corner} seat, SDC (m)", seat_demand_sdc_m(bridge, unseating_m), length_m)
    aashto_m = {
        seat: seat_demand_aashto_m(bridge, seat, variant.skew_deg) for seat in bridge.seats_m
    }
    ends = [(aashto_m[corner.split()[0]], length_m) for corner, (_, length_m) in corners_m.items()]
    if ends:
        worst = max(ends, key=lambda end: end[0] / end[1])
        compare("seat, AASHTO 1.5 N (m)", *worst)
    for joint, (unseating_m, length_m) in joint_moves_m(bridge, histories).items():
        demand_m = seat_demand_sdc_m(bridge, unseating_m, MINIMUM_HINGE_M)
        compare(f"{joint} seat, SDC (m)", demand_m, length_m)
        compare(f"{joint} seat, AASHTO 1.5 N (m)", aashto_m[joint], length_m)
    return rows


def corner_moves_m(
    bridge: Description, histories: Mapping[str, NDArray[np.float64]], shortest_m: float
) -> dict[str, tuple[float, float]]:
    """Return the largest unseating and the support at rest (m) of each corner (``left acute``).

    The support is ``shortest_m`` in a model without contacts.
    """
    openings = {end: f"contact_{end}_backwall_1_opening_m" for end in bridge.end_seats_m}
    gaps_m = {end: float(histories[name][0]) for end, name in openings.items() if name in histories}
    lengths_m = dict.fromkeys(openings, shortest_m) | bridge.support_lengths_m(gaps_m)
    moves: dict[str, tuple[float, float]] = {}
    for (end, length_m), kind in product(lengths_m.items(), ("acute", "obtuse")):
        if (unseating_m := histories.get(f"abutment_{end}_{kind}_unseating_m")) is None:
            raise InputError("the run is from an earlier version: repeat it")
        moves[f"{end} {kind}"] = max(0.0, float(np.max(unseating_m))), length_m
    return moves


def joint_moves_m(
    bridge: Description, histories: Mapping[str, NDArray[np.float64]]
) -> dict[str, tuple[float, float]]:
    """Return the largest unseating and the support at rest (m) of each joint inside the bridge."""
    numbers = range(1, len(bridge.joints_m) + 1)
    gaps_m = {f"joint {n}": float(histories[f"contact_joint_{n}_1_opening_m"][0]) for n in numbers}
    return {
        joint: (max(0.0, float(np.max(histories[f"joint{number}_unseating_m"]))), length_m)
        for number, (joint, length_m) in enumerate(bridge.support_lengths_m(gaps_m).items(), 1)
    }
