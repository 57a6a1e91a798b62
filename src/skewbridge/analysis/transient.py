"""Nonlinear response history of one variant under one motion, with limits and residual drift."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import dist, hypot, inf, isqrt, nan, pi
from pathlib import Path
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.analysis.bridge_check import capacity_rows
from skewbridge.analysis.energy import EnergyBalance, energy_ratios
from skewbridge.analysis.ground import Excitation, GroundInput, SupportInput
from skewbridge.analysis.modal import apply_rayleigh, damp_columns
from skewbridge.analysis.peaks import (
    ModelEnd,
    demands,
    histories_of,
    model_end,
    over_capacity,
)
from skewbridge.analysis.recovery import MAX_ITERATIONS, Effort
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import Ending, Progress, StepLoop, configure_solver
from skewbridge.analysis.trace import Monitor, at_regular_steps
from skewbridge.bridge.assembly import solver_log
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.handles import AbutmentHandle, ColumnHandle, Point, SeatHandle
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.plan import PlanVector
from skewbridge.contact import ContactError, ContactSet
from skewbridge.statuses import OK, Status
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS, ModelOptions
from skewbridge.variant.variant import Variant

# ASSUME no bridge moves this fast. A diverging solution may still pass the convergence test, with
# forces of any size, so these limits stop it. They are far above real responses and do not define
# collapse.
MAX_STEP_DRIFT: Final = 0.05
MAX_STEP_DISP_M: Final = 0.5
MAX_CONTACT_WEIGHTS: Final = 5.0  # normal force of one contact / weight of the bridge
#: Largest speed of a deck corner on its seat: corners are read when one could have left its seat.
MAX_SEAT_SPEED_MPS: Final = 10.0
_STEPS_PER_PERIOD: Final = 20
MAX_PERIODS: Final = 10
#: Tight because the motion dies out: 1e-3 J would change the drift by 15 %.
TOLERANCE_J: Final = 1.0e-6
#: A column is at rest if its drift changes by less than this in a quarter of a period.
STILL_DRIFT: Final = 1.0e-5
_STEPS_STILL: Final = _STEPS_PER_PERIOD // 4
# Newmark gamma and beta that damp the high modes of penalty springs: only the state at rest
# matters, not the path to it.
_INTEGRATOR: Final = ("Newmark", 1.0, 0.5625)
_PARTS: Final = (1, 4, 16)
# The residual drift is taken from the last state, even after the failure of a column.
_RESIDUAL: Final = "column_residual_drift_ratio"


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalysisResult:
    """Result of one analysis, with the peaks up to its last step."""

    status: Status  # status, as in the demands table
    collapse_criterion: str  # name of the demand that exceeded its limit, or empty
    time_reached_s: float  # time of the last converged step
    duration_s: float  # duration of the analysis if it does not end early
    effort: Effort  # iterations, (sub-)steps and failures
    demands: dict[str, float]  # the demand columns of the table, in their units
    #: the demand columns as peaks over all steps, even after a column failure
    whole_history: dict[str, float]
    support_length_m: float  # of the deck on its seats at rest; nan without seats
    bents: list[dict[str, Any]]  # capacities of the bents, from `capacity_rows`
    model_end: ModelEnd  # first failure of a column; `demands` are the peaks up to this failure
    energy_kj: Mapping[str, float]  # terms of the energy balance; empty without one
    #: columns of the history table at the regular steps, each of shape (steps + 1,), or None
    histories: dict[str, NDArray[np.float64]] | None
    messages: tuple[str, ...]  # reason for an early end, and notes on the demands


def analyse(
    variant: Variant,
    excitation: Excitation,
    settings: AnalysisSettings,
    options: ModelOptions,
    *,
    histories: bool = False,
    log_path: Path | None = None,
    progress: Progress | None = None,
) -> AnalysisResult:
    """Analyse one variant under one two-component motion, or a motion of each support.

    Under support motions there is no energy balance. The same call gives bitwise identical results.
    OpenSees writes to ``log_path``; ``progress`` is called with time and duration. `InputError` if
    an argument is outside its limits.
    """
    ground = GroundInput(excitation, settings)
    options = settings.model_options(options)
    # here: periods that its file does not give need the domain
    load_structure(variant.bridge).description.require_seats(variant.normalised(), options)
    with solver_log(log_path), domain():
        model = build(variant, options)
        if not excitation.supports:
            rayleigh, supports = apply_rayleigh(model), None
            ground.apply(model.tags)
        else:
            rayleigh = apply_rayleigh(model, "stiffness")
            supports = SupportInput(excitation.supports, ground, model)
            supports.apply(model)
        history = _History(model, ground, settings, rayleigh, supports, histories=histories)
        return history.run(progress)


class _History:
    """Response history of a model in the open domain under one ground input."""

    def __init__(
        self,
        model: BridgeModel,
        ground: GroundInput,
        settings: AnalysisSettings,
        rayleigh: tuple[float, float],
        supports: SupportInput | None,
        *,
        histories: bool,
    ) -> None:
        self._model, self._ground, self._settings = model, ground, settings
        self._supports = supports
        self._histories = histories
        self._watch = Watch(model, settings, ground_moves=supports is not None)
        self._stiffness_factor_s = rayleigh[1]
        # a model without contacts is far from contact in the whole history
        self._damp(by_tangent=settings.reuse_tangent and model.contacts is None)
        self._loop = StepLoop(model.contacts, settings, lambda far: self._damp(by_tangent=far))
        self._monitor = Monitor(model, bearings=histories)
        self._energy = None
        if supports is None:
            self._energy = EnergyBalance(
                model, self._monitor, ground.at, rayleigh, settings.integrator_command
            )
        self._monitor.start()

    def run(self, progress: Progress | None) -> AnalysisResult:
        """Run all steps and return the result."""
        ending = self._loop.run(self._ground.steps, self._read, progress)
        energy = {} if self._energy is None else self._energy.terms_kj()
        trace = self._monitor.trace()
        if self._supports is not None:
            trace = self._supports.relative(trace)
        ground = self._ground.at(trace.time_s)
        effort = self._loop.effort
        ratios = energy_ratios(energy)
        all_peaks = demands(self._model, trace, ground, ratios)
        failure, peaks = model_end(self._model.columns, trace), dict(all_peaks)
        if failure.mode:  # the model is not valid after the failure of a column
            valid_rows = failure.rows
            peaks |= demands(self._model, trace.at(slice(valid_rows)), ground[:valid_rows], ratios)
            peaks |= {name: all_peaks[name] for name in (_RESIDUAL, *SHEAR_MODEL_DEMANDS.values())}
        messages = [ending.message] if ending.message else []
        if ending.status == OK and self._supports is not None:
            messages.append("support motions: residual drift at the last step, no energy balance")
        elif ending.status == OK:
            at_rest = drifts_at_rest(self._model, self._settings, self._watch.columns)
            if at_rest.reason:
                messages.append(f"residual drift is taken from the last step: {at_rest.reason}")
            else:
                peaks[_RESIDUAL] = max(at_rest.drifts, default=0.0)
        histories = None
        if self._histories:
            regular_rows = at_regular_steps(trace.time_s, self._settings.dt_s)
            histories = histories_of(self._model, trace.at(regular_rows), ground[regular_rows])
        return AnalysisResult(
            status=ending.status,
            collapse_criterion=ending.collapse_criterion,
            time_reached_s=float(trace.time_s[-1]),
            duration_s=self._ground.duration_s,
            effort=effort,
            demands=peaks,
            whole_history=all_peaks,
            support_length_m=min((s.support_length_m for s in self._model.seats), default=nan),
            bents=capacity_rows(self._model.frame.bents),
            model_end=failure,
            energy_kj=energy,
            histories=histories,
            messages=tuple(messages),
        )

    def _damp(self, *, by_tangent: bool) -> None:
        # ASSUME softening columns have no stiffness damping: it could exceed their strength
        softening = self._watch.softening
        undamaged = [column for column in self._model.columns if column.element not in softening]
        damp_columns(undamaged, self._stiffness_factor_s, by_tangent=by_tangent)

    def _read(self) -> Ending | None:
        """Return an ending if the state after a step exceeds a limit, else None."""
        reason = self._watch.diverged()
        if reason:
            self._monitor.drop_last()
            self._energy = None  # the model is no longer in the state of the last row
            message = f"the solution diverged: {reason}"
            return Ending(status="numerical_failure", message=message)
        if columns := self._watch.softened():
            damp_columns(columns, 0.0, by_tangent=False)
        criterion = self._watch.collapsed()
        return Ending(status="collapse", collapse_criterion=criterion) if criterion else None


class Watch:
    """Compares each step with the limits; create it in the state under gravity.

    ``columns`` give drifts since that state; ``softening`` has the elements of columns that have
    lost strength; ``ground_moves`` is true under support motions.
    `InputError` if a joint gap is at least as wide as its seat.
    """

    def __init__(
        self, model: BridgeModel, settings: AnalysisSettings, *, ground_moves: bool = False
    ) -> None:
        self._settings = settings
        self._max_normal_n = MAX_CONTACT_WEIGHTS * model.weight_n
        self._contacts = model.contacts
        self._deck = _Moved(model.frame.centre_node)
        self._ground = _ground_near(model) if ground_moves else None
        self.columns = tuple(Drift(column) for column in model.columns)
        self.softening: set[int] = set()
        self._loses_fibers = model.options.fiber_end == "loss"
        self._least_softening_ratio = min(
            (
                0.0 if column.loses_shear_strength else capacity.drift_capacity_ratio
                for column in model.columns
                for capacity in column.capacities
            ),
            default=inf,
        )
        seats: list[tuple[str, int, int | Point, AbutmentHandle | SeatHandle]] = [
            ("unseating_m", corner.node, end.holders[0], end)
            for end in model.seats
            for corner in end.corners
        ]
        seats += [
            ("joint_unseating_m", seat.corner, seat.holder, seat)
            for joint in model.joints
            for seat in joint.seats
        ]
        self._seats = tuple(
            (demand, _Moved(corner), _Moved(support), seat.normal, seat.support_length_m)
            for demand, corner, support, seat in seats
        )
        self._drift_ratio = self._disp_m = self._seats_at_s = 0.0

    def diverged(self) -> str:
        """Return the reason why the state is not a solution, or an empty text.

        Call it once after each step, before `collapsed`.
        """
        x, y = self._deck.disp_m()
        if self._ground is not None:
            ground_x, ground_y = self._ground.disp_m()
            x, y = x - ground_x, y - ground_y
        drift, disp_m = 0.0, hypot(x, y)
        for column in self.columns:
            if not (ratio := column.drift_ratio()) <= drift:  # NaN counts
                drift = ratio
        step_drift, step_disp_m = drift - self._drift_ratio, disp_m - self._disp_m
        self._drift_ratio, self._disp_m = drift, disp_m
        # Negated comparisons, so that NaN is caught.
        if not abs(step_drift) <= MAX_STEP_DRIFT:
            return f"drift changed by {step_drift:.3g} in one step"
        if not abs(step_disp_m) <= MAX_STEP_DISP_M:
            return f"the deck moved by {step_disp_m:.3g} m in one step"
        largest = 0.0 if self._contacts is None else self._contacts.largest_normal_n
        if not largest <= self._max_normal_n:
            return f"a contact carries {largest:.3g} N"
        return ""

    def softened(self) -> list[ColumnHandle]:
        """Return the columns that began to soften since the last call; call `diverged` before."""
        if self._drift_ratio < self._least_softening_ratio:
            return []
        columns = [
            lean.column
            for lean in self.columns
            if not (lean.column.is_elastic or lean.column.element in self.softening)
            and (
                (self._loses_fibers and lean.over_capacity())
                or (lean.column.loses_shear_strength and lean.loses_shear_strength())
            )
        ]
        self.softening.update(column.element for column in columns)
        return columns

    def collapsed(self) -> str:
        """Return the name of the demand whose limit is exceeded, or an empty text."""
        if self._drift_ratio >= self._settings.collapse_drift_ratio:
            return "column_drift_ratio"
        if (time_s := ops.getTime()) >= self._seats_at_s:
            smallest_margin_m = inf
            for demand, corner, support, normal, support_m in self._seats:
                (x, y), (below_x, below_y) = corner.disp_m(), support.disp_m()
                moved_m = -((x - below_x) * normal[0] + (y - below_y) * normal[1])
                if moved_m > support_m:
                    return demand
                smallest_margin_m = min(smallest_margin_m, support_m - moved_m)
            self._seats_at_s = time_s + smallest_margin_m / MAX_SEAT_SPEED_MPS
        if self._disp_m > self._settings.collapse_deck_disp_m:
            return "deck_disp_m"
        return ""


class _Moved:
    """Plan displacement of a node or point in the open domain since this object was created."""

    __slots__ = ("_has_arm", "_node", "_x", "_y", "_z", "_zero_x", "_zero_y")

    def __init__(self, node_or_point: int | Point) -> None:
        point = node_or_point if isinstance(node_or_point, Point) else Point(node_or_point)
        self._node, (self._x, self._y, self._z) = point.node, point.arm_m
        self._has_arm = any(point.arm_m)
        self._zero_x = self._zero_y = 0.0
        self._zero_x, self._zero_y = self.disp_m()

    def disp_m(self) -> PlanVector:
        """Return the displacement along x and y, in m."""
        node = self._node
        if not self._has_arm:
            return ops.nodeDisp(node, 1) - self._zero_x, ops.nodeDisp(node, 2) - self._zero_y
        x, y, _, turn_x, turn_y, turn_z = ops.nodeDisp(node)
        x += turn_y * self._z - turn_z * self._y
        y += turn_z * self._x - turn_x * self._z
        return x - self._zero_x, y - self._zero_y


def _ground_near(model: BridgeModel) -> _Moved:
    """Return the fixed node nearest to the mass centre; it moves only under support motions."""
    centre = ops.nodeCoord(model.frame.centre_node)
    fixed = [node for node in ops.getNodeTags() if {1, 2} <= set(ops.getFixedDOFs(node))]
    return _Moved(min(fixed, key=lambda node: dist(centre, ops.nodeCoord(node))))


class Drift:
    """Drift of a column in the open domain since this object was created."""

    __slots__ = ("_base", "_top", "column")

    def __init__(self, column: ColumnHandle) -> None:
        self.column = column
        self._top, self._base = _Moved(column.top), _Moved(column.foot)

    def drift_ratio(self) -> float:
        """Return the displacement of the top relative to the base, divided by the clear height."""
        return hypot(*self._disp_m()) / self.column.clear_height_m

    def over_capacity(self) -> bool:
        """Return whether the drift has reached the displacement capacity, as in `model_end`."""
        drifts = np.array([self._disp_m()]) / self.column.clear_height_m
        return bool(over_capacity(self.column, drifts)[0] >= 1.0)

    def loses_shear_strength(self) -> bool:
        """Return whether a shear spring of the top hinge (its last two terms) softens."""
        top = str(self.column.hinge_sections[-1])
        stiffness = ops.eleResponse(self.column.element, "section", top, "stiffness")
        size = isqrt(len(stiffness))
        return bool(np.reshape(stiffness, (size, size)).diagonal()[-2:].min() <= 0.0)

    def _disp_m(self) -> PlanVector:
        (top_x, top_y), (base_x, base_y) = self._top.disp_m(), self._base.disp_m()
        return top_x - base_x, top_y - base_y


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """Resultant drift ratios of the columns at rest; NaN and a reason if rest is not reached."""

    drifts: tuple[float, ...]
    steps: int
    reason: str = ""


def drifts_at_rest(
    model: BridgeModel, settings: AnalysisSettings, columns: Sequence[Drift]
) -> Rest:
    """Let the model in the open domain come to rest; return the drifts of its columns.

    It vibrates freely from its last state until no column moves, damped by the masses of deck and
    columns (critical at the long period). A static release would fail: open gaps and slipping
    contacts leave nodes without stiffness. The state of the history is lost.
    """
    period_s = model.frame.damping.long_period_s
    # ASSUME the path to rest adds no plastic drift: critical damping leaves no cycles
    factors = (4 * pi / period_s, 0.0, 0.0, 0.0)
    ops.region(model.tags.region(), "-ele", *model.frame.damping.elements, "-rayleigh", *factors)
    configure_solver(settings)
    ops.test("EnergyIncr", min(settings.tolerance_j, TOLERANCE_J), MAX_ITERATIONS)
    ops.algorithm("Newton")
    _forget_accelerations()
    ops.integrator(*_INTEGRATOR)
    ops.analysis("Transient", "-noWarnings")

    def read() -> tuple[float, ...]:
        return tuple(column.drift_ratio() for column in columns)

    history = [read()]
    unknown = (nan,) * len(model.columns)
    for step in range(1, MAX_PERIODS * _STEPS_PER_PERIOD + 1):
        try:
            has_converged = _advance(model.contacts, period_s / _STEPS_PER_PERIOD)
        except ContactError as error:
            return Rest(drifts=unknown, steps=step, reason=str(error))
        if not has_converged:
            return Rest(drifts=unknown, steps=step, reason="a step of free vibration failed")
        history.append(read())
        recent = zip(*history[-_STEPS_STILL - 1 :], strict=True)
        if step > _STEPS_STILL and all(max(drift) - min(drift) < STILL_DRIFT for drift in recent):
            return Rest(drifts=history[-1], steps=step)
    return Rest(
        drifts=unknown, steps=len(history) - 1, reason=f"not at rest after {MAX_PERIODS} periods"
    )


def _forget_accelerations() -> None:
    """Set the accelerations of massless degrees of freedom to zero.

    They oscillate under the trapezoidal rule; the integrator of the free vibration to rest would
    take them as motion.
    """
    for node in ops.getNodeTags():
        for dof in range(1, 7):
            if ops.nodeMass(node, dof) == 0.0:
                ops.setNodeAccel(node, dof, 0.0, "-commit")


def _advance(contacts: ContactSet | None, dt_s: float) -> bool:
    """Make one step, in parts if it does not converge; return whether it converged."""
    for parts in _PARTS:
        part_s = dt_s / parts
        if contacts is not None:
            contacts.prepare(part_s)
        n_done = 0
        while n_done < parts and ops.analyze(1, part_s) == 0:
            n_done += 1
            if contacts is not None:
                contacts.after_step(part_s)
        if n_done == parts:
            return True
        dt_s -= n_done * part_s
        ops.domainChange()  # discard the state that a failed step left in the equations
    return False
