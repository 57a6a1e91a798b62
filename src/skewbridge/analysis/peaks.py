"""Response histories of an analysis, and their peaks (demands), computed from the trace.

Displacements are relative to the ground and counted from the state under gravity.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from skewbridge.analysis.trace import ResponseTrace, Series
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.handles import AbutmentHandle, ColumnHandle, JointHandle, SpringHandle
from skewbridge.bridge.model import contact_column
from skewbridge.contact.law import UnitLedger
from skewbridge.units import KJ, KN
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS, ShearModel


def demands(
    model: BridgeModel,
    trace: ResponseTrace,
    ground_accel_mps2: Series,
    energy_ratios: Mapping[str, float],
) -> dict[str, float]:
    """Return the demand columns of the demands table: peaks over the trace.

    ``ground_accel_mps2`` is along x and y, shape (n, 2). Totals of the contacts cover the entire
    analysis.
    """
    return {
        **column_demands(model.columns, trace),
        **_deck_demands(model, trace, ground_accel_mps2),
        **_abutment_demands(model, trace),
        **_joint_demands(model, trace),
        **_force_demands(model, trace),
        **_contact_demands(model),
        **energy_ratios,
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelEnd:
    """First failure of a column, after which the bridge model is no longer valid."""

    mode: str  # ``shear`` or ``flexure``; empty if no column fails
    time_s: float  # time of the first row with a failed column; nan if no column fails
    rows: int  # number of rows up to and including the failure; all rows if no column fails


def model_end(columns: Sequence[ColumnHandle], trace: ResponseTrace) -> ModelEnd:
    """Return the first failure of a column.

    Shear: demand / capacity 1, unless the model loses shear strength. Flexure: drift at the
    displacement capacity of the bent. Elastic columns do not fail.
    """
    failures: list[tuple[int, str]] = []
    for column in columns:
        if column.is_elastic:
            continue
        ratios = {"flexure": drift_over_capacity(column, trace)}
        if not column.loses_shear_strength:
            ratios["shear"] = column_shear_dcr(column, trace)
        for mode, ratio in ratios.items():
            failed = ratio >= 1.0
            if failed.any():
                failures.append((int(failed.argmax()), mode))
    if not failures:
        return ModelEnd(mode="", time_s=float("nan"), rows=len(trace.time_s))
    # if both occur in the same step, report the brittle failure
    row, mode = min(failures, key=lambda failure: (failure[0], failure[1] != "shear"))
    return ModelEnd(mode=mode, time_s=float(trace.time_s[row]), rows=row + 1)


def column_demands(columns: Sequence[ColumnHandle], trace: ResponseTrace) -> dict[str, float]:
    """Return the column demands: peaks over all columns and times."""
    shears = [column_shear_n(column, trace) for column in columns]
    drifts = [column_drift(column, trace) for column in columns]
    base_shears = [column_base_shear_n(column, trace) for column in columns]

    by_model = [shear_ratios(column, trace, SHEAR_MODEL_DEMANDS) for column in columns]

    def stated(ratios: Sequence[Series]) -> float:
        """Return the peak over columns with a known capacity; nan if no column has one."""
        stated_ratios = [ratio for ratio in ratios if not np.isnan(ratio).all()]
        return peak(stated_ratios) if stated_ratios or not ratios else nan

    return {
        "column_shear_x_kn": peak(shear[:, 0] for shear in shears) / KN,
        "column_shear_y_kn": peak(shear[:, 1] for shear in shears) / KN,
        "column_shear_kn": peak(np.hypot(*shear.T) for shear in shears) / KN,
        "column_base_shear_kn": peak(np.hypot(*base.T) for base in base_shears) / KN,
        "column_shear_dcr": stated(
            [ratios[column.shear_model] for column, ratios in zip(columns, by_model, strict=True)]
        ),
        **{
            name: stated([ratios[model] for ratios in by_model])
            for model, name in SHEAR_MODEL_DEMANDS.items()
        },
        "column_drift_ratio": peak(drifts),
        "drift_over_capacity": stated([drift_over_capacity(column, trace) for column in columns]),
        "column_curvature_ductility": stated(
            [curvature_ductility(column, trace) for column in columns]
        ),
        "column_residual_drift_ratio": peak(drift[-1:] for drift in drifts),
    }


def column_base_shear_n(column: ColumnHandle, trace: ResponseTrace) -> Series:
    """Return the horizontal force at the base of a column along x and y (N), shape (n, 2)."""
    return trace.columns[column.element][:, :2]


def column_shear_n(column: ColumnHandle, trace: ResponseTrace) -> Series:
    """Return the section shear of a column along x and y (N), shape (n, 2).

    It has the sign of the base force and is V + P theta: the axial force has a component along a
    section normal to the inclined chord.
    """
    top, base = trace.position(column.top), trace.position(column.base_node)
    chord = (top - base)[:, :2] / column.clear_height_m
    axial = trace.columns[column.element][:, 2:3]
    # base force and chord have opposite signs where P-Delta increases the shear
    return column_base_shear_n(column, trace) - axial * chord


def column_drift(column: ColumnHandle, trace: ResponseTrace) -> Series:
    """Return resultant relative displacement / clear height, without foundation rotation, (n,)."""
    return np.hypot(*_drifts(column, trace).T)


def _drifts(column: ColumnHandle, trace: ResponseTrace) -> Series:
    relative = trace.disp(column.top)[:, :2] - trace.disp(column.foot)[:, :2]
    return relative / column.clear_height_m


def _ratio(column: ColumnHandle, vectors: Series, limits: Sequence[float | Series]) -> Series:
    """Return the resultant of components / limits, normal to the bent and along it, shape (n,)."""
    # ASSUME an ellipse between the two directions, a circle for equal limits
    # source: Umehara and Jirsa (1984), J. Struct. Eng. 110(3), 605-618, shear of rectangles
    (x, y), (move_x, move_y) = column.normal, vectors.T
    return np.hypot((move_x * x + move_y * y) / limits[0], (move_y * x - move_x * y) / limits[1])


def drift_over_capacity(column: ColumnHandle, trace: ResponseTrace) -> Series:
    """Return the ratio of column drift to the drift capacity of its bent, shape (n,)."""
    return over_capacity(column, _drifts(column, trace))


def over_capacity(column: ColumnHandle, drifts: Series) -> Series:
    """Return the ratio of drifts along x and y, (n, 2), to the drift capacity, shape (n,)."""
    limits = [capacity.drift_capacity_ratio for capacity in column.capacities]
    return _ratio(column, drifts, limits)


def column_shear_dcr(column: ColumnHandle, trace: ResponseTrace) -> Series:
    """Return the ratio of section shear to shear capacity at the same time, shape (n,)."""
    return shear_ratios(column, trace, (column.shear_model,))[column.shear_model]


def shear_ratios(
    column: ColumnHandle, trace: ResponseTrace, models: Iterable[ShearModel]
) -> dict[ShearModel, Series]:
    """Return the ratio of section shear to capacity, shape (n,), for each shear strength model.

    The capacity depends on the axial force and the largest ductility so far, because dilated
    concrete does not recover.
    """
    axial = trace.columns[column.element][:, 2]
    yields = [capacity.yield_drift_ratio for capacity in column.capacities]
    # ASSUME the hinge region governs over the whole height: these columns are short.
    ductilities = (
        np.maximum.accumulate(_ratio(column, _drifts(column, trace), yields)),
        np.maximum.accumulate(curvature_ductility(column, trace)),
    )
    shear = column_shear_n(column, trace)
    return {
        model: _ratio(
            column,
            shear,
            [
                capacity.shear_strength_n(model, axial, *ductilities)
                for capacity in column.capacities
            ],
        )
        for model in models
    }


def curvature_ductility(column: ColumnHandle, trace: ResponseTrace) -> Series:
    """Return the largest resultant hinge curvature over yield curvature, shape (n,).

    The model has one hinge length, that normal to the bent.
    """
    normal, along = column.capacities
    largest = np.full(len(trace.time_s), 0.0 * normal.yield_curvature_per_m)  # nan if not stated
    for point in column.hinge_sections:
        _, about_z, about_y, *_ = trace.sections[column.element, point].T
        ratio_y = about_y / normal.yield_curvature_per_m
        ratio_z = about_z / along.yield_curvature_per_m
        # ASSUME a hinge of the length along the bent rotates as the hinge of the model
        plastic_share = 1.0 - 1.0 / np.maximum(np.hypot(ratio_z, ratio_y), 1.0)
        ratio_z *= 1.0 + (along.hinge_ratio - 1.0) * plastic_share
        largest = np.maximum(largest, np.hypot(ratio_z, ratio_y))
    return largest


def _deck_demands(model: BridgeModel, trace: ResponseTrace, ground: Series) -> dict[str, float]:
    x, y, *_, rotation = trace.disp(model.frame.centre_node).T
    return {
        "deck_disp_x_m": peak([x]),
        "deck_disp_y_m": peak([y]),
        "deck_disp_m": peak([np.hypot(x, y)]),
        "deck_rotation_rad": peak([rotation]),
        "deck_accel_mps2": peak([np.hypot(*(trace.centre_accel_mps2 + ground).T)]),
    }


def _abutment_demands(model: BridgeModel, trace: ResponseTrace) -> dict[str, float]:
    abutments = model.abutments
    push_histories = [_wall_push_m(abutment, trace) for abutment in abutments]
    pad_disps = [trace.disp(pad) for abutment in abutments for pad in abutment.pads]
    pad_disps += [
        trace.disp(top) - trace.disp(bottom)
        for line in model.inner_pads
        for top, bottom in line.pads
    ]
    return {
        "abutment_passive_m": highest(push_histories),
        "abutment_active_m": highest(-push for push in push_histories),
        "abutment_transverse_m": peak(_transverse_m(abutment, trace) for abutment in abutments),
        "bearing_disp_m": peak(np.hypot(pad_disp[:, 0], pad_disp[:, 1]) for pad_disp in pad_disps),
        "bearing_uplift_m": highest(
            (trace.position(bearing.deck_node) - trace.position(bearing.seat_node))[:, 2]
            for end in (*abutments, *model.inner_pads)
            for bearing in end.bearings
        ),
        # a bridge without seats cannot unseat
        **{
            name: highest(unseating_m(seat, trace, kind) for seat in model.seats)
            if model.seats
            else nan
            for name, kind in (("unseating_m", None), ("acute_corner_unseating_m", "acute"))
        },
    }


def _joint_demands(model: BridgeModel, trace: ResponseTrace) -> dict[str, float]:
    """Return unseating and closures of the inner joints, and the worst unseating of all."""
    demands: dict[str, float] = {}
    all_ledgers = model.contacts.ledger() if model.contacts else []
    for joint in model.joints:
        demands[f"{joint.column}_unseating_m"] = highest([joint_unseating_m(joint, trace)])
        ledgers = [all_ledgers[unit] for unit in joint.units]
        demands[f"{joint.column}_closures"] = _sum(ledgers, "closures")
    unseatings = [value for name, value in demands.items() if name.endswith("_m")]
    return {"joint_unseating_m": max(unseatings), **demands} if unseatings else {}


def joint_unseating_m(joint: JointHandle, trace: ResponseTrace) -> Series:
    """Return the largest outward displacement of a deck corner on its cap or ledge, shape (n,)."""
    return np.maximum.reduce(
        [
            -_along(seat.normal, trace.disp(seat.corner) - trace.disp(seat.holder))
            for seat in joint.seats
        ]
    )


def _transverse_m(abutment: AbutmentHandle, trace: ResponseTrace) -> Series:
    """Return the largest displacement of walls and keys along the abutment (m), shape (n,)."""
    # ASSUME a key is part of the abutment, even after it broke
    nodes = (*abutment.wall_nodes, *abutment.key_nodes)
    if nodes:
        return np.maximum.reduce([np.abs(_along(abutment.tangent, trace.disp(n))) for n in nodes])
    displacements = [
        np.abs(_along(abutment.tangent, _deformation(spring, trace)))
        for spring in abutment.key_springs
    ]
    return np.maximum.reduce([np.zeros(len(trace.time_s)), *displacements])


def _deformation(spring: SpringHandle, trace: ResponseTrace) -> Series:
    return trace.disp(spring.nodes[1]) - trace.disp(spring.nodes[0])


def _along(direction: Sequence[float], disp: Series) -> Series:
    return disp[:, 0] * direction[0] + disp[:, 1] * direction[1]


def unseating_m(abutment: AbutmentHandle, trace: ResponseTrace, kind: str | None = None) -> Series:
    """Return the displacement of a deck corner away from the backwall, normal to the seat, (n,).

    ``kind`` is ``acute`` or ``obtuse``; None: the larger value.
    """
    displacements = [
        -_along(abutment.normal, trace.disp(corner.node))
        for corner in abutment.corners
        if kind is None or corner.kind == kind
    ]
    return np.maximum.reduce(displacements)


def _wall_push_m(abutment: AbutmentHandle, trace: ResponseTrace) -> Series:
    """Return the displacement of backwall points into the fill (m), shape (n, points).

    Without wall nodes, it is the closure of each wall spring minus the gap, at least 0.
    """
    if abutment.wall_nodes:
        return np.column_stack(
            [_along(abutment.normal, trace.disp(node)) for node in abutment.wall_nodes]
        )
    pushes = [
        _along(abutment.normal, _deformation(spring, trace)) - abutment.gap_m
        for spring in abutment.wall_springs
    ]
    return np.maximum(np.column_stack(pushes), 0.0) if pushes else np.zeros((len(trace.time_s), 1))


def _force_demands(model: BridgeModel, trace: ResponseTrace) -> dict[str, float]:
    abutments = model.abutments
    frictions: list[Series] = []
    for abutment in abutments:
        if abutment.wall_units:
            on_wall = trace.tangentials_n[:, list(abutment.wall_units)].sum(axis=1)
            frictions.append(np.hypot(*on_wall.T))
        frictions += [np.hypot(*trace.tangentials_n[:, unit].T) for unit in abutment.key_units]
    key_forces = [force for abutment in abutments for force in key_forces_n(abutment, trace)]
    wall_forces = [backfill_force_n(abutment, trace) for abutment in abutments]
    return {
        "shear_key_force_kn": peak(key_forces) / KN,
        "shear_key_disp_m": peak(
            move for abutment in abutments for move in _key_deformations_m(abutment, trace)
        ),
        "backwall_force_kn": highest(wall_forces) / KN,
        "friction_force_kn": peak(frictions) / KN,
        "contact_force_ratio": highest([trace.normals_n.max(axis=1, initial=0.0)]) / model.weight_n,
    }


def wall_force_n(abutment: AbutmentHandle, trace: ResponseTrace) -> Series:
    """Return the normal force (N) of the deck on a backwall, compression positive, shape (n,)."""
    if abutment.wall_units:
        return trace.normals_n[:, list(abutment.wall_units)].sum(axis=1)
    return backfill_force_n(abutment, trace)


def backfill_force_n(abutment: AbutmentHandle, trace: ResponseTrace) -> Series:
    """Return the force (N) of the deck on the backfill through one backwall, shape (n,).

    It excludes dashpot and impact spikes of the wall, and is zero without contact.
    """
    total = np.zeros(len(trace.time_s))
    for spring in abutment.wall_springs:
        sign = np.sign(np.dot(spring.direction, abutment.normal))
        total += sign * trace.spring_force(spring)
    if abutment.wall_units:
        total[~_closed(trace, abutment.wall_units)] = 0.0
    return total


def key_forces_n(abutment: AbutmentHandle, trace: ResponseTrace) -> list[Series]:
    """Return the force of each shear key (N), shape (n,); it is zero without contact."""
    forces = [np.abs(trace.spring_force(spring)) for spring in abutment.key_springs]
    for force, unit in zip(forces, abutment.key_units, strict=False):
        force[~_closed(trace, (unit,))] = 0.0
    return forces


def _key_deformations_m(abutment: AbutmentHandle, trace: ResponseTrace) -> list[Series]:
    """Return the deformation of each shear key or transverse spring along its normal (m), (n,)."""
    return [
        np.abs(_along(spring.direction, _deformation(spring, trace)))
        for spring in abutment.key_springs
    ]


def _closed(trace: ResponseTrace, units: Sequence[int]) -> NDArray[np.bool_]:
    return (trace.normals_n[:, list(units)] > 0.0).any(axis=1)


def _contact_demands(model: BridgeModel) -> dict[str, float]:
    """Return the contact columns of the demands table; all zero for a model without contacts.

    Closures and peaks of single contacts depend on the time step; times, impulses and work converge
    (docs/theory/analysis.md).
    """
    units = [] if model.contacts is None else model.contacts.ledger()
    walls_and_keys = (
        [units[index] for abutment in model.abutments for index in getattr(abutment, unit_lists)]
        for unit_lists in ("wall_units", "key_units")
    )
    return {
        "contact_closures": _sum(units, "closures"),
        "contact_time_s": _sum(units, "contact_time_s"),
        "contact_max_penetration_m": max((unit.max_penetration_m for unit in units), default=0.0),
        "friction_impulse_kns": _sum(units, "friction_impulse_ns") / KN,
        "slip_work_kj": _sum(units, "slip_work_j") / KJ,
        "cone_violation_ratio": max((unit.cone_violation_ratio for unit in units), default=0.0),
        "cone_excess_ratio": max(_share(group, "excess_work_j") for group in walls_and_keys),
        "cone_work_over_10pct_ratio": _share(units, "work_over_10_j"),
    }


def _sum(units: Sequence[UnitLedger], field: str) -> float:
    return float(sum(getattr(unit, field) for unit in units))


def _share(units: Sequence[UnitLedger], field: str) -> float:
    """Return the sum of a field of contact units / their friction work; 0 without such work."""
    total = _sum(units, "friction_work_j")
    return _sum(units, field) / total if total > 0.0 else 0.0


def peak(series: Iterable[Series]) -> float:
    """Return the largest absolute value of all series, or 0 without series."""
    return max((float(np.abs(values).max()) for values in series), default=0.0)


def highest(series: Iterable[Series]) -> float:
    """Return the largest value of all series, at least 0."""
    return max((0.0, *(float(values.max()) for values in series)))


def histories_of(
    model: BridgeModel, trace: ResponseTrace, ground_accel_mps2: Series
) -> dict[str, Series]:
    """Return the history columns, each of shape (n,); the first row is the state under gravity.

    The force of an abutment is positive if it opposes a positive displacement of the deck.
    """
    disp = trace.disp(model.frame.centre_node)

    def largest(history_of: Callable[[ColumnHandle, ResponseTrace], Series]) -> Series:
        """Return the largest known value of all columns in each row; 0 without columns."""
        series = [history_of(column, trace) for column in model.columns]
        magnitudes = [np.hypot(*history.T) if history.ndim == 2 else history for history in series]
        return np.fmax.reduce(magnitudes or [np.zeros(len(trace.time_s))])

    table: dict[str, Series] = {
        "t_s": trace.time_s,
        **_plan("ground_a{}_mps2", ground_accel_mps2),
        **_plan("deck_u{}_m", disp),
        "deck_rot_rad": disp[:, 5],
        "column_shear_kn": largest(column_shear_n) / KN,
        "column_base_shear_kn": largest(column_base_shear_n) / KN,
        "column_shear_dcr": largest(column_shear_dcr),
    }
    for number, column in enumerate(model.columns, start=1):
        table |= _plan(f"column_{number}_shear_{{}}_kn", column_shear_n(column, trace) / KN)
        table[f"column_{number}_axial_kn"] = trace.columns[column.element][:, 2] / KN
        table[f"column_{number}_drift_ratio"] = column_drift(column, trace)
    for abutment in model.abutments:
        name = f"abutment_{abutment.side}"
        pads_n = _force_n((pad.element for pad in abutment.bearings), trace)
        table |= {
            **_plan(f"{name}_{{}}_m", trace.disp(abutment.centre)),
            **_plan(f"{name}_{{}}_kn", _joint_force_n(model, abutment, trace, pads_n) / KN),
            **_plan(f"{name}_pads_{{}}_kn", pads_n / KN),
            f"{name}_wall_kn": wall_force_n(abutment, trace) / KN,
            f"{name}_backfill_kn": backfill_force_n(abutment, trace) / KN,
        }
        for kind in ("", "_acute", "_obtuse") if abutment.is_seat else ():
            table[f"{name}{kind}_unseating_m"] = unseating_m(abutment, trace, kind[1:] or None)
        for corner in abutment.corners:
            table |= _plan(f"{name}_{corner.kind}_{{}}_m", trace.disp(corner.node))
    for joint in model.joints:
        table[f"{joint.column}_unseating_m"] = joint_unseating_m(joint, trace)
    for index, unit in enumerate(model.contacts.units if model.contacts else ()):
        name = contact_column(unit.name)
        slip_and_opening = trace.disp(unit.node_j) - trace.disp(unit.node_i)
        table[f"{name}_opening_m"] = unit.gap_m + slip_and_opening[:, :3] @ np.array(unit.normal)
        table[f"{name}_normal_kn"] = trace.normals_n[:, index] / KN
        table[f"{name}_friction_1_kn"] = trace.tangentials_n[:, index, 0] / KN
        table[f"{name}_friction_2_kn"] = trace.tangentials_n[:, index, 1] / KN
    return {name: np.array(values) for name, values in table.items()}


def _plan(name: str, vectors: Series) -> dict[str, Series]:
    """Return vectors (n, 2) as the columns ``name`` with x and y in place of the braces."""
    return {name.format(axis): vectors[:, k] for k, axis in enumerate("xy")}


def _force_n(elements: Iterable[int], trace: ResponseTrace) -> Series:
    """Return the force (N) of pads, supports, fill or piles along x and y, shape (n, 2)."""
    return sum((trace.bearings[element] for element in elements), np.zeros((len(trace.time_s), 2)))


def _joint_force_n(
    model: BridgeModel, abutment: AbutmentHandle, trace: ResponseTrace, pads_n: Series
) -> Series:
    """Return the force (N) of an end on the deck along x and y, (n, 2); nan for a fixed end.

    A seat has pads plus contacts or springs; an integral end has fill, wing walls and piles.
    """
    if not abutment.is_seat:
        # ASSUME nobody needs the reaction of a fixed end, which is not recorded
        return _force_n(abutment.ground_elements, trace) + (0.0 if abutment.links else nan)
    total = pads_n.copy()
    units = (*abutment.wall_units, *abutment.key_units)
    contacts = model.contacts.units if model.contacts else ()
    for index in units:
        unit = contacts[index]
        total -= np.outer(trace.normals_n[:, index], unit.normal[:2])
        for k, tangent in enumerate(unit.tangents):
            total += np.outer(trace.tangentials_n[:, index, k], tangent[:2])
    # wing walls of `spring` are in series with its keys
    for spring in () if units else (*abutment.wall_springs, *abutment.key_springs):
        total += np.outer(trace.spring_force(spring), spring.direction)
    return total
