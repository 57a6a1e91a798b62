"""Weights of a bridge of the catalogue, its hand reactions, and the lumping along its deck.

Heights are measured from the soffit; x is from the middle of the deck.
"""

import numpy as np

from skewbridge.bridge.catalogue.data import BentData, BridgeData
from skewbridge.units import KN


def continuous_reactions_n(spans_m: tuple[float, ...], load_n_per_m: float) -> list[float]:
    """Return the reactions in N of a continuous beam under uniform load (three-moment equation)."""
    count = len(spans_m)
    moments = np.zeros(count + 1)
    if count > 1:
        left, right = np.array(spans_m[:-1]), np.array(spans_m[1:])
        matrix = np.diag(2 * (left + right))
        matrix += np.diag(right[:-1], 1) + np.diag(right[:-1], -1)
        moments[1:-1] = np.linalg.solve(matrix, load_n_per_m * (left**3 + right**3) / 4)
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
    reactions = continuous_reactions_n(bridge.spans_m, bridge.deck.line_load_kn_per_m * KN)
    for end in (0, -1):
        reactions[end] += bridge.deck.diaphragm_weight_kn * KN
    return reactions


def column_axial_n(bridge: BridgeData, bent_number: int) -> float:
    """Return the dead-load axial force in N at the base of each column of a bent (0, 1, ...)."""
    bent, deck = bridge.bents[bent_number], deck_reactions_n(bridge)[bent_number + 1]
    return (deck + bent.cap_weight_kn * KN) / bent.columns + column_weight_n(bridge, bent)


def total_weight_n(bridge: BridgeData) -> float:
    """Return the weight in N of deck, diaphragms, caps and columns."""
    bents = sum(
        bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent)
        for bent in bridge.bents
    )
    return sum(deck_reactions_n(bridge)) + bents


# A spine node within this distance of the mass centre is used as the node there.
NEAR_M = 0.05


def mass_centre_m(bridge: BridgeData) -> float:
    """Return x in m of the mass centre of deck, caps and upper halves of the columns."""
    line = bridge.deck.line_load_kn_per_m * KN * bridge.length_m
    total, moment = line + 2 * bridge.deck.diaphragm_weight_kn * KN, 0.0
    for x, bent in zip(bridge.bent_positions_m, bridge.bents, strict=True):
        weight = bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent) / 2
        total += weight
        moment += weight * x
    return moment / total


def spine_points_m(bridge: BridgeData, elements_per_span: int) -> dict[float, float]:
    """Return the deck length lumped at each spine node, keyed by increasing x coordinate.

    Every span has equal elements. A node added at the mass centre has no mass.
    """
    points: dict[float, float] = {}
    start = -bridge.length_m / 2
    shares = lumping_shares(elements_per_span)
    for span in bridge.spans_m:
        element = span / elements_per_span
        for i, share in enumerate(shares):
            # the last point of a span must equal the first of the next exactly
            x = start + span if i == elements_per_span else start + i * element
            points[x] = points.get(x, 0.0) + share * element
        start += span
    centre = mass_centre_m(bridge)
    if min(abs(x - centre) for x in points) > NEAR_M:
        points[centre] = 0.0
    return dict(sorted(points.items()))


def lumping_shares(elements: int) -> list[float]:
    """Return horizontal masses at the nodes of equal elements, in units of one element's mass.

    Gregory's end-corrected weights have the total, centre and moment of inertia of the continuous
    mass. With half an element at each end node, a deck of 8 elements has 3 % more rotational
    inertia.

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
