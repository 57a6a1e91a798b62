"""Weights of a bridge of the catalogue, its hand reactions, and the lumping along its deck.

Heights are measured from the soffit; x is from the middle of the deck.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import inf

import numpy as np

from skewbridge.bridge.catalogue.data import BentData, BridgeData, EndData, IntegralData
from skewbridge.units import GPA, KN

# A spine node within this distance of the mass centre is used as the node there.
NEAR_M = 0.05


def continuous_reactions_n(
    spans_m: tuple[float, ...],
    load_n_per_m: float,
    hinges_m: Sequence[float] = (),
    ends_m: tuple[float, float] = (inf, inf),
) -> list[float]:
    """Return the reactions in N of a beam under uniform load (three-moment equation).

    Hinges are at distances from the left end; their rotations are unknowns. ``ends_m`` are
    6 E I / rotational stiffness of both ends: 0 for a clamped end, infinite for a simple support.
    """
    count = len(spans_m)
    moments = np.zeros(count + 1)
    free = [i for i in range(count + 1) if 0 < i < count or ends_m[i > 0] < inf]
    if free:
        left, right = np.append(0.0, spans_m), np.append(spans_m, 0.0)
        matrix = np.diag(2 * (left + right)) + np.diag(spans_m, 1) + np.diag(spans_m, -1)
        matrix[0, 0] += ends_m[0]
        matrix[-1, -1] += ends_m[1]
        matrix = matrix[np.ix_(free, free)]
        angles = load_n_per_m * (left**3 + right**3)[free] / 4
        for hinge in hinges_m:
            starts = np.cumsum((0.0, *spans_m))
            i = min(int(np.searchsorted(starts, hinge - NEAR_M)), count) - 1
            share = (hinge - starts[i]) / spans_m[i]
            row = np.zeros(count + 1)
            row[i : i + 2] = 1.0 - share, share  # of the support moments at the hinge
            row = np.pad(row[free], (0, len(angles) - len(free)))
            matrix = np.block([[matrix, row[:, None]], [row, 0.0]])
            angles = np.append(angles, load_n_per_m * spans_m[i] ** 2 * share * (1.0 - share) / 2)
        moments[free] = np.linalg.solve(matrix, angles)[: len(free)]
    reactions = np.zeros(count + 1)
    for i, span in enumerate(spans_m):
        tilt = (moments[i + 1] - moments[i]) / span
        reactions[i] += load_n_per_m * span / 2 - tilt
        reactions[i + 1] += load_n_per_m * span / 2 + tilt
    return reactions.tolist()


def column_weight_n(bridge: BridgeData, bent: BentData) -> float:
    """Return the weight of one column in N."""
    column = bridge.column_of(bent)
    return column.outline.area_m2 * column.unit_weight_kn_per_m3 * KN * bent.clear_height_m


def deck_reactions_n(bridge: BridgeData) -> list[float]:
    """Return the reactions in N of abutments and bents to the deck's weight, left to right."""
    # ASSUME bearings are in the middle of a joint
    hinges_m = [x_m + bridge.length_m / 2 for x_m in bridge.joint_positions_m]
    line_n_per_m = bridge.deck.line_load_kn_per_m * KN
    left, right = (_end_m(bridge, end) for end in bridge.ends.values())
    reactions = continuous_reactions_n(bridge.spans_m, line_n_per_m, hinges_m, (left, right))
    # ASSUME a hinge in a span has no heavier diaphragm than the deck
    for end in (0, -1, *(number + 1 for number in bridge.jointed_bents for _ in range(2))):
        reactions[end] += bridge.deck.diaphragm_weight_kn * KN
    return reactions


def _end_m(bridge: BridgeData, end: EndData) -> float:
    """Return 6 E I of the deck / rotational stiffness of an end (m), of the moment equations."""
    if not isinstance(end, IntegralData):
        return 0.0 if end.type == "fixed" else inf
    # ASSUME the deck bends only the heads of the piles: the fill has no pressure at rest
    bending_nm2 = bridge.deck.elastic_modulus_gpa * GPA * bridge.deck.inertia_vertical_m4
    return 6.0 * bending_nm2 / (end.piles.count * end.piles.rotational_mnm_per_rad * 1e6)


def column_axial_n(bridge: BridgeData, bent_number: int) -> float:
    """Return the dead-load axial force in N at the base of each column of a bent (0, 1, ...)."""
    bent, deck_n = bridge.bents[bent_number], deck_reactions_n(bridge)[bent_number + 1]
    return (deck_n + bent.cap_weight_kn * KN) / bent.columns + column_weight_n(bridge, bent)


def total_weight_n(bridge: BridgeData) -> float:
    """Return the weight in N of deck, diaphragms, caps and columns."""
    bents = sum(
        bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent)
        for bent in bridge.bents
    )
    return sum(deck_reactions_n(bridge)) + bents


def mass_centre_m(bridge: BridgeData) -> float:
    """Return x in m of the mass centre of deck, caps and upper halves of the columns."""
    line = bridge.deck.line_load_kn_per_m * KN * bridge.length_m
    total, moment_nm = line + 2 * bridge.deck.diaphragm_weight_kn * KN, 0.0
    for x, bent in zip(bridge.bent_positions_m, bridge.bents, strict=True):
        weight_n = bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent) / 2
        if x in bridge.joint_positions_m:
            weight_n += 2 * bridge.deck.diaphragm_weight_kn * KN
        total += weight_n
        moment_nm += weight_n * x
    return moment_nm / total


def spine_points_m(bridge: BridgeData, elements_per_span: int) -> list[dict[float, float]]:
    """Return for each deck the length (m) lumped at its spine nodes, keyed by x (m).

    Every span has equal elements. A node added at the mass centre has no mass.
    """
    decks: list[dict[float, float]] = [{}]
    start, joints = -bridge.length_m / 2, bridge.joint_positions_m
    shares = lumping_shares(elements_per_span)
    for span in bridge.spans_m:
        end = start + span
        hinges = [x for x in joints if start + NEAR_M < x < end - NEAR_M]
        for first, last in pairwise((start, *hinges, end)):
            length = last - first if hinges else span
            element = length / elements_per_span
            for i, share in enumerate(shares):
                # the last point of a span must equal the first of the next exactly
                x = last if i == elements_per_span else first + i * element
                decks[-1][x] = decks[-1].get(x, 0.0) + share * element
            if any(abs(x - last) < NEAR_M for x in joints):
                decks.append({})
        start = end
    centre = mass_centre_m(bridge)
    if min(abs(x - centre) for deck in decks for x in deck) > NEAR_M:
        next(deck for deck in decks if max(deck) > centre)[centre] = 0.0
    return [dict(sorted(deck.items())) for deck in decks]


def lumping_shares(elements: int) -> list[float]:
    """Return horizontal masses at the nodes of equal elements, in units of one element's mass.

    Gregory's weights keep total, centre and moment of inertia; half an element at the ends would
    give 8 elements 3 % more inertia.

    References:
        Davis and Rabinowitz (1984), Methods of Numerical Integration, section 2.9.
    """
    shares = [1.0] * (elements + 1)
    if elements == 1:
        return [0.5, 0.5]
    for i, correction in enumerate((-5 / 8, 1 / 6, -1 / 24)):
        shares[i] += correction
        shares[-1 - i] += correction
    return shares
