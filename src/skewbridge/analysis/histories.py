"""Table of the histories of an analysis: one column per quantity, with its unit in the name."""

from collections.abc import Callable

import numpy as np

from skewbridge.analysis.peaks import (
    backfill_force_n,
    column_base_shear_n,
    column_drift,
    column_shear_dcr,
    column_shear_n,
    unseating_m,
    wall_force_n,
)
from skewbridge.analysis.trace import ResponseTrace, Series
from skewbridge.bridge.geometry import contact_column
from skewbridge.bridge.handles import AbutmentHandle, BridgeModel, ColumnHandle
from skewbridge.units import KN


def histories_of(
    model: BridgeModel, trace: ResponseTrace, ground_accel_mps2: Series
) -> dict[str, Series]:
    """Return the history columns, each of shape (n,); the first row is the state under gravity.

    Forces of an abutment are those of all its parts on the deck (contacts, springs and pads),
    positive when they oppose a positive displacement, so that they plot as hysteresis loops.
    """
    disp = trace.disp(model.deck_centre_node)

    def largest(of_column: Callable[[ColumnHandle, ResponseTrace], Series]) -> Series:
        """Return the largest of all columns in each row; zero for a single span, without any."""
        series = [of_column(column, trace) for column in model.columns]
        sizes = [np.hypot(*each.T) if each.ndim == 2 else each for each in series]
        return np.maximum.reduce([np.zeros(len(trace.time_s)), *sizes])

    table: dict[str, Series] = {
        "t_s": trace.time_s,
        "ground_ax_mps2": ground_accel_mps2[:, 0],
        "ground_ay_mps2": ground_accel_mps2[:, 1],
        "deck_ux_m": disp[:, 0],
        "deck_uy_m": disp[:, 1],
        "deck_rot_rad": disp[:, 5],
        "column_shear_kn": largest(column_shear_n) / KN,
        "column_base_shear_kn": largest(column_base_shear_n) / KN,
        "column_shear_dcr": largest(column_shear_dcr),
    }
    for number, column in enumerate(model.columns, start=1):
        shear = column_shear_n(column, trace) / KN
        table[f"column_{number}_shear_x_kn"] = shear[:, 0]
        table[f"column_{number}_shear_y_kn"] = shear[:, 1]
        table[f"column_{number}_axial_kn"] = trace.columns[column.element][:, 2] / KN
        table[f"column_{number}_drift_ratio"] = column_drift(column, trace)
    for abutment in model.abutments:
        table |= _abutment_columns(model, abutment, trace)
    if model.contacts is not None:
        for index, unit in enumerate(model.contacts.units):
            name = contact_column(unit.name)
            moved = trace.disp(unit.node_j) - trace.disp(unit.node_i)
            table[f"{name}_opening_m"] = unit.gap_m + moved[:, :3] @ np.array(unit.normal)
            table[f"{name}_normal_kn"] = trace.normals_n[:, index] / KN
            table[f"{name}_friction_1_kn"] = trace.tangentials_n[:, index, 0] / KN
            table[f"{name}_friction_2_kn"] = trace.tangentials_n[:, index, 1] / KN
    return {name: np.array(values) for name, values in table.items()}


def abutment_force_n(model: BridgeModel, abutment: AbutmentHandle, trace: ResponseTrace) -> Series:
    """Return the force of an abutment on the deck along x and y, shape (n, 2).

    Positive against a positive displacement of the deck.
    """
    total = pads_force_n(abutment, trace)
    if model.contacts is not None:
        units = model.contacts.units
        for index in (*abutment.wall_units, *abutment.key_units):
            unit = units[index]
            total -= np.outer(trace.normals_n[:, index], unit.normal[:2])
            for k, tangent in enumerate(unit.tangents):
                total += np.outer(trace.tangentials_n[:, index, k], tangent[:2])
        return total
    for spring in abutment.springs:
        total += np.outer(trace.spring_force(spring), spring.direction)
    return total


def pads_force_n(abutment: AbutmentHandle, trace: ResponseTrace) -> Series:
    """Return the part of `abutment_force_n` that comes from the pads (or supports)."""
    total = np.zeros((len(trace.time_s), 2))
    for bearing in abutment.bearings:
        total += trace.bearings[bearing.element]
    return total


def _abutment_columns(
    model: BridgeModel, abutment: AbutmentHandle, trace: ResponseTrace
) -> dict[str, Series]:
    disp = trace.disp(abutment.centre)
    force = abutment_force_n(model, abutment, trace) / KN
    pads = pads_force_n(abutment, trace) / KN
    name = f"abutment_{abutment.side}"
    table = {
        f"{name}_x_m": disp[:, 0],
        f"{name}_y_m": disp[:, 1],
        f"{name}_x_kn": force[:, 0],
        f"{name}_y_kn": force[:, 1],
        f"{name}_pads_x_kn": pads[:, 0],
        f"{name}_pads_y_kn": pads[:, 1],
        f"{name}_wall_kn": wall_force_n(abutment, trace) / KN,
        f"{name}_backfill_kn": backfill_force_n(abutment, trace) / KN,
        f"{name}_unseating_m": unseating_m(abutment, trace),
    }
    for corner in abutment.corners:
        moved = trace.disp(corner.node)
        table[f"{name}_{corner.kind}_x_m"] = moved[:, 0]
        table[f"{name}_{corner.kind}_y_m"] = moved[:, 1]
    return table
