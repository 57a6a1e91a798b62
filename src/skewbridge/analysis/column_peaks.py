"""Demands on the columns; pure functions of the trace.

Displacements are relative to the ground and counted from the state under gravity.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skewbridge.analysis.series import peak
from skewbridge.analysis.trace import Trace
from skewbridge.bridge.handles import ColumnHandle
from skewbridge.bridge.shear_capacity import kowalsky_priestley_strength, sdc_shear_strength
from skewbridge.units import KN

type Series = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelEnd:
    """Where the response leaves what the model of the columns can say.

    Attributes:
        mode: ``shear`` or ``flexure``; empty if it never does.
        time_s: Time of the first row in that state, nan if there is none.
        rows: Number of rows up to and with it; all of them if there is none.
    """

    mode: str
    time_s: float
    rows: int


def model_end(columns: Sequence[ColumnHandle], trace: Trace) -> ModelEnd:
    """Return when the first column reaches its capacity, and in which mode.

    In shear at a demand over capacity of 1, unless the model has the loss of shear strength in it;
    in flexure when the drift reaches the displacement capacity of the bent. Elastic columns, which
    have no strength, have no such end.
    """
    reached: list[tuple[int, str]] = []
    for column in columns:
        if column.is_elastic:
            continue
        ratios = {"flexure": drift_over_capacity(column, trace)}
        if not column.loses_shear_strength:
            ratios["shear"] = column_shear_dcr(column, trace)
        for mode, ratio in ratios.items():
            failed = ratio >= 1.0
            if failed.any():
                reached.append((int(failed.argmax()), mode))
    if not reached:
        return ModelEnd(mode="", time_s=float("nan"), rows=len(trace.rows))
    # of two in the same step, the brittle one
    row, mode = min(reached, key=lambda end: (end[0], end[1] != "shear"))
    return ModelEnd(mode=mode, time_s=float(trace.time_s[row]), rows=row + 1)


def column_demands(columns: Sequence[ColumnHandle], trace: Trace) -> dict[str, float]:
    """Return the column demands of the table, peaks over columns and time."""
    shears = [column_shear_n(column, trace) for column in columns]
    drifts = [column_drift(column, trace) for column in columns]
    bases = [column_base_shear_n(column, trace) for column in columns]
    return {
        "column_shear_x_kn": peak(shear[:, 0] for shear in shears) / KN,
        "column_shear_y_kn": peak(shear[:, 1] for shear in shears) / KN,
        "column_shear_kn": peak(np.hypot(*shear.T) for shear in shears) / KN,
        "column_base_shear_kn": peak(np.hypot(*base.T) for base in bases) / KN,
        "column_shear_dcr": peak(column_shear_dcr(column, trace) for column in columns),
        "column_drift_ratio": peak(drifts),
        "drift_over_capacity": peak(drift_over_capacity(column, trace) for column in columns),
        "column_curvature_ductility": peak(
            curvature_ductility(column, trace) for column in columns
        ),
        "column_residual_drift_ratio": peak(drift[-1:] for drift in drifts),
    }


def column_base_shear_n(column: ColumnHandle, trace: Trace) -> NDArray[np.float64]:
    """Return the horizontal force at the base of a column, x and y, shape (n, 2)."""
    return trace.column_forces(column.element)[:, :2]


def column_shear_n(column: ColumnHandle, trace: Trace) -> NDArray[np.float64]:
    """Return the shear of a column's sections, x and y, with the sign of the base force, (n, 2).

    A section stands square to the leaning chord, so the axial force has a share across it: the
    shear is V + P theta, equal to the sum of the end moments over the height.
    """
    top, base = trace.position(column.top_node), trace.position(column.base_node)
    chord = (top - base)[:, :2] / column.clear_height_m
    axial = trace.column_forces(column.element)[:, 2:3]
    # the base pushes back against the lean: where P-Delta adds, force and chord differ in sign
    return column_base_shear_n(column, trace) - axial * chord


def column_drift(column: ColumnHandle, trace: Trace) -> Series:
    """Return top minus base displacement, resultant, over the clear height, shape (n,)."""
    relative = trace.disp(column.top_node)[:, :2] - trace.disp(column.base_node)[:, :2]
    return np.hypot(*relative.T) / column.clear_height_m


def drift_over_capacity(column: ColumnHandle, trace: Trace) -> Series:
    """Return the drift over the displacement capacity of the bent per clear height, shape (n,)."""
    return column_drift(column, trace) / column.drift_capacity_ratio


def column_shear_dcr(column: ColumnHandle, trace: Trace) -> Series:
    """Return the section's shear over its capacity at the same time, shape (n,).

    The capacity follows the axial force of the moment and the largest ductility so far (of
    displacement or of curvature, by the model of the capacity): concrete that has dilated does
    not heal.
    """
    axial = trace.column_forces(column.element)[:, 2]
    # ASSUME the hinge region governs over the whole height: these columns are short.
    if column.shear_model == "kowalsky_priestley":
        ductility = np.maximum.accumulate(curvature_ductility(column, trace))
        capacity = kowalsky_priestley_strength(column.shear, axial, ductility)
    else:
        ductility = np.maximum.accumulate(column_drift(column, trace)) / column.yield_drift_ratio
        capacity = sdc_shear_strength(column.shear, axial, ductility)
    return np.hypot(*column_shear_n(column, trace).T) / capacity


def curvature_ductility(column: ColumnHandle, trace: Trace) -> Series:
    """Return the largest resultant curvature of the hinges over the yield curvature, (n,)."""
    largest = np.zeros(len(trace.rows))
    for point in column.hinge_sections:
        deformation = trace.section(column.element, point)
        largest = np.maximum(largest, np.hypot(deformation[:, 1], deformation[:, 2]))
    return largest / column.yield_curvature_per_m
