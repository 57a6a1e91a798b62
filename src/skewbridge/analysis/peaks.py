"""The demands of an analysis from what was read while it ran; pure functions of the trace.

Displacements are relative to the ground and counted from the state under gravity.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from skewbridge.analysis.column_peaks import column_demands
from skewbridge.analysis.contact_sums import contact_demands
from skewbridge.analysis.series import highest, peak
from skewbridge.analysis.trace import Trace, moved_with
from skewbridge.bridge.handles import (
    AbutmentHandle,
    BridgeModel,
    PlanVector,
    SpringHandle,
)
from skewbridge.units import KN

type Series = NDArray[np.float64]


def demands(
    model: BridgeModel,
    trace: Trace,
    ground_accel_mps2: Series,
    energy_ratios: Mapping[str, float],
) -> dict[str, float]:
    """Return the demand columns of the table, peaks over the trace.

    Totals of the contacts are those of the whole analysis, whatever part of it the trace is.

    The ground acceleration is that along x and y at the times of the trace, shape (n, 2); the
    energy columns are nan when no balance was kept.
    """
    return {
        **column_demands(model.columns, trace),
        **_deck_demands(model, trace, ground_accel_mps2),
        **_abutment_demands(model, trace),
        **_force_demands(model, trace),
        **contact_demands(model),
        **energy_ratios,
    }


def along(direction: PlanVector, disp: NDArray[np.float64]) -> Series:
    """Return the plan displacement along a direction, shape (n,)."""
    return disp[:, 0] * direction[0] + disp[:, 1] * direction[1]


def unseating_m(abutment: AbutmentHandle, trace: Trace, kind: str | None = None) -> Series:
    """Return the largest move of a deck corner away from the backwall, normal to the seat.

    Of the ``acute`` or ``obtuse`` corner if its kind is given, else of both, shape (n,).
    """
    moves = [
        -along(abutment.normal, trace.disp(corner.node))
        for corner in abutment.corners
        if kind is None or corner.kind == kind
    ]
    return np.maximum.reduce(moves)


def wall_push_m(abutment: AbutmentHandle, trace: Trace) -> NDArray[np.float64]:
    """Return how far the points of a backwall are pushed into the fill, shape (n, points).

    Without wall nodes: what is left of the closing of the springs after the gap, never negative.
    """
    if abutment.wall_nodes:
        return np.column_stack(
            [along(abutment.normal, trace.disp(node)) for node in abutment.wall_nodes]
        )
    pushes = [
        along(abutment.normal, _deformation(spring, trace)) - abutment.gap_m
        for spring in abutment.wall_springs
    ]
    return np.maximum(np.column_stack(pushes), 0.0) if pushes else np.zeros((len(trace.rows), 1))


def wall_force_n(abutment: AbutmentHandle, trace: Trace) -> Series:
    """Return the normal force between deck and one backwall, compression positive, shape (n,)."""
    if abutment.wall_units:
        return trace.normals_n[:, list(abutment.wall_units)].sum(axis=1)
    return backfill_force_n(abutment, trace)


def backfill_force_n(abutment: AbutmentHandle, trace: Trace) -> Series:
    """Return what the deck passes through one backwall into the backfill, shape (n,).

    Unlike the contact force it leaves out the dashpot of the wall and, where the wall has a mass,
    the spikes of impacts on it. Zero while the deck does not touch the wall.
    """
    total = np.zeros(len(trace.rows))
    for spring in abutment.wall_springs:
        sign = np.sign(np.dot(spring.direction, abutment.normal))
        total += sign * trace.spring_force(spring)
    if abutment.wall_units:
        total[~_closed(trace, abutment.wall_units)] = 0.0
    return total


def key_forces_n(abutment: AbutmentHandle, trace: Trace) -> list[Series]:
    """Return the force of each shear key while the deck touches it, each of shape (n,)."""
    forces = [np.abs(trace.spring_force(spring)) for spring in abutment.key_springs]
    for force, unit in zip(forces, abutment.key_units, strict=False):
        force[~_closed(trace, (unit,))] = 0.0
    return forces


def key_deformations_m(abutment: AbutmentHandle, trace: Trace) -> list[Series]:
    """Return how far each shear key is pushed along its normal, never negative, each shape (n,).

    Without key nodes: what is left of the closing of the transverse springs after the gap.
    """
    gap_m = 0.0 if abutment.key_nodes else abutment.transverse_gap_m
    moves = [
        along(spring.direction, _deformation(spring, trace)) for spring in abutment.key_springs
    ]
    return [np.maximum(np.abs(move) - gap_m, 0.0) for move in moves]


def _closed(trace: Trace, units: Sequence[int]) -> NDArray[np.bool_]:
    return (trace.normals_n[:, list(units)] > 0.0).any(axis=1)


def _deck_demands(model: BridgeModel, trace: Trace, ground: Series) -> dict[str, float]:
    disp = trace.disp(model.deck_centre_node)
    return {
        "deck_disp_x_m": peak([disp[:, 0]]),
        "deck_disp_y_m": peak([disp[:, 1]]),
        "deck_disp_m": peak([np.hypot(disp[:, 0], disp[:, 1])]),
        "deck_rotation_rad": peak([disp[:, 5]]),
        "deck_accel_mps2": peak([np.hypot(*(trace.centre_accel_mps2 + ground).T)]),
    }


def _abutment_demands(model: BridgeModel, trace: Trace) -> dict[str, float]:
    abutments = model.abutments
    pushes = [wall_push_m(abutment, trace) for abutment in abutments]
    pads = [
        moved_with(trace.disp(abutment.centre_node), arm_m)
        for abutment in abutments
        for arm_m in abutment.pad_offsets_m
    ]
    return {
        "abutment_passive_m": highest(pushes),
        "abutment_active_m": highest(-push for push in pushes),
        "abutment_transverse_m": peak(_transverse_m(abutment, trace) for abutment in abutments),
        "bearing_disp_m": peak(np.hypot(pad[:, 0], pad[:, 1]) for pad in pads),
        "unseating_m": highest(unseating_m(abutment, trace) for abutment in abutments),
        "acute_corner_unseating_m": highest(
            unseating_m(abutment, trace, "acute") for abutment in abutments
        ),
    }


def _transverse_m(abutment: AbutmentHandle, trace: Trace) -> Series:
    """Return the largest movement of walls and keys along the abutment line, shape (n,)."""
    # ASSUME a key is part of the abutment: one that broke and is dragged along counts
    nodes = (*abutment.wall_nodes, *abutment.key_nodes)
    if nodes:
        moves = [np.abs(along(abutment.tangent, trace.disp(node))) for node in nodes]
        return np.maximum.reduce(moves)
    moves = [
        np.abs(along(abutment.tangent, _deformation(spring, trace))) - abutment.transverse_gap_m
        for spring in (*abutment.key_springs, *abutment.wing_springs)
    ]
    return np.maximum.reduce([np.zeros(len(trace.rows)), *moves])


def _deformation(spring: SpringHandle, trace: Trace) -> Series:
    """Return the displacement of the deck side less that of the ground side, shape (n, 6)."""
    return trace.disp(spring.nodes[1]) - trace.disp(spring.nodes[0])


def _force_demands(model: BridgeModel, trace: Trace) -> dict[str, float]:
    abutments = model.abutments
    friction: list[Series] = []
    for abutment in abutments:
        if abutment.wall_units:
            on_wall = trace.tangentials_n[:, list(abutment.wall_units)].sum(axis=1)
            friction.append(np.hypot(*on_wall.T))
        friction += [np.hypot(*trace.tangentials_n[:, unit].T) for unit in abutment.key_units]
    keys = [force for abutment in abutments for force in key_forces_n(abutment, trace)]
    walls = [backfill_force_n(abutment, trace) for abutment in abutments]
    return {
        "shear_key_force_kn": peak(keys) / KN,
        "shear_key_disp_m": peak(
            move for abutment in abutments for move in key_deformations_m(abutment, trace)
        ),
        "backwall_force_kn": highest(walls) / KN,
        "friction_force_kn": peak(friction) / KN,
        "contact_force_ratio": highest([trace.normals_n.max(axis=1, initial=0.0)]) / model.weight_n,
    }
