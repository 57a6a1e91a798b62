"""Dead load by hand: reactions of the deck as a continuous beam."""

import numpy as np

from skewbridge.bridge.catalogue.data import BentData, BridgeData
from skewbridge.units import KN


def continuous_reactions_n(spans_m: tuple[float, ...], load_n_per_m: float) -> list[float]:
    """Return the support reactions of a prismatic continuous beam under a uniform load.

    Spans and reactions stand from left to right.

    References:
        Clapeyron's equation of three moments.
    """
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
    """Return the weight of one column."""
    column = bridge.column
    return column.gross_area_m2 * column.unit_weight_kn_per_m3 * KN * bent.clear_height_m


def deck_reaction_n(bridge: BridgeData, bent_number: int) -> float:
    """Return the part of the deck's line load that a bent carries, numbered from 0."""
    line = bridge.deck.line_load_kn_per_m * KN
    return continuous_reactions_n(bridge.spans_m, line)[bent_number + 1]


def column_axial_n(bridge: BridgeData, bent_number: int) -> float:
    """Return the axial force at the base of each column of a bent."""
    bent, deck = bridge.bents[bent_number], deck_reaction_n(bridge, bent_number)
    return (deck + bent.cap_weight_kn * KN) / bent.columns + column_weight_n(bridge, bent)


def abutment_reactions_n(bridge: BridgeData) -> tuple[float, float]:
    """Return the reactions of the left and the right abutment, end diaphragms included."""
    line = bridge.deck.line_load_kn_per_m * KN
    reactions = continuous_reactions_n(bridge.spans_m, line)
    diaphragm = bridge.deck.diaphragm_weight_kn * KN
    return reactions[0] + diaphragm, reactions[-1] + diaphragm


def total_weight_n(bridge: BridgeData) -> float:
    """Return the weight of deck, diaphragms, caps and columns."""
    deck = bridge.deck
    line = deck.line_load_kn_per_m * KN * bridge.length_m + 2 * deck.diaphragm_weight_kn * KN
    bents = sum(
        bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent)
        for bent in bridge.bents
    )
    return line + bents
