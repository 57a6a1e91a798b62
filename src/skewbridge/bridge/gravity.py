"""Dead load: reactions of the deck by hand calculation, and its application to a model."""

from collections.abc import Mapping

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BentData, BridgeData
from skewbridge.bridge.handles import BridgeModel, TagAllocator
from skewbridge.errors import SolutionError
from skewbridge.units import KN


def continuous_reactions_n(spans_m: tuple[float, ...], load_n_per_m: float) -> list[float]:
    """Return the reactions of a continuous beam under a uniform load, by three moments."""
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


def deck_reactions_n(bridge: BridgeData) -> list[float]:
    """Return the weight of deck and end diaphragms on abutments and bents, left to right."""
    reactions = continuous_reactions_n(bridge.spans_m, bridge.deck.line_load_kn_per_m * KN)
    for end in (0, -1):
        reactions[end] += bridge.deck.diaphragm_weight_kn * KN
    return reactions


def column_axial_n(bridge: BridgeData, bent_number: int) -> float:
    """Return the axial force at the base of each column of a bent (numbered from 0)."""
    bent, deck = bridge.bents[bent_number], deck_reactions_n(bridge)[bent_number + 1]
    return (deck + bent.cap_weight_kn * KN) / bent.columns + column_weight_n(bridge, bent)


def total_weight_n(bridge: BridgeData) -> float:
    """Return the weight of deck, diaphragms, caps and columns."""
    bents = sum(
        bent.cap_weight_kn * KN + bent.columns * column_weight_n(bridge, bent)
        for bent in bridge.bents
    )
    return sum(deck_reactions_n(bridge)) + bents


GRAVITY_STEPS = 5
_TOLERANCE_M = 1.0e-10


class GravityError(SolutionError):
    """A model found no equilibrium under its own weight."""


def hold_dead_load(
    loads_n: Mapping[int, float],
    moments_nm: Mapping[int, tuple[float, float]],
    tags: TagAllocator,
) -> None:
    """Apply downward loads and moments about x and y by node, and hold them; time is then zero.

    Nodal, because the corotational transformation ignores element loads. `GravityError` if there is
    no equilibrium.
    """
    open_linear_pattern(tags)
    for node, load_n in loads_n.items():
        ops.load(node, 0.0, 0.0, -load_n, *moments_nm.get(node, (0.0, 0.0)), 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", _TOLERANCE_M, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / GRAVITY_STEPS)
    ops.analysis("Static", "-noWarnings")
    if ops.analyze(GRAVITY_STEPS) != 0:
        raise GravityError("the gravity analysis did not converge: no equilibrium under dead load")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def open_linear_pattern(tags: TagAllocator) -> None:
    """Open a load pattern that grows with time; it takes the loads created afterwards."""
    series = tags.series()
    ops.timeSeries("Linear", series)
    ops.pattern("Plain", tags.pattern(), series)


def column_axial_forces_n(model: BridgeModel) -> list[float]:
    """Return the compression at the base of every column, from the element forces."""
    return [float(ops.eleResponse(column.element, "force")[2]) for column in model.columns]


def support_reactions_n(model: BridgeModel) -> list[float]:
    """Return the vertical force on each abutment (left, right) from its supports."""
    ops.reactions()
    return [
        sum(float(ops.nodeReaction(bearing.seat_node, 3)) for bearing in abutment.bearings)
        for abutment in model.abutments
    ]
