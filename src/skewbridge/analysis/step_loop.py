"""Step loop of all response histories: solver, step sizes, recovery, contact updates and ending."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.recovery import RECOVERY_STEPS, REUSE, Effort, RecoveryStep
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.contact import ContactError, ContactSet
from skewbridge.statuses import Status

type Progress = Callable[[float, float], None]
_STEPS_PER_REPORT: Final = 50
#: Next steps that keep the recovery step that solved a difficult step.
HELD_STEPS: Final = 5
# A regular step is divided into at most 2^16 parts; the settings need at most 2^11.
MAX_HALVINGS: Final = 16
_FINEST: Final = 2**MAX_HALVINGS
# An accelerating pair closes earlier than its speed predicts, hence a margin of half a step.
LOOK_AHEAD: Final = 1.5
# Halving the step divides the friction error by 4, so the step is doubled when the error is below
# this share of the allowed error.
_GROW: Final = 0.2
# The deck counts as swinging if an opening was below this share of its gap within this time.
# Regular steps of 10 ms would then change peaks between contacts by more than 1 %.
SWING_SHARE: Final = 0.75
SWING_S: Final = 0.3
# ASSUME the closing speed of a pair grows by at most this acceleration: until the earliest possible
# closing, steps are made without reading the contacts
MAX_ACCEL_MPS2: Final = 20.0
LONGEST_S: Final = 0.08
# Budget of iterations per regular step of the history: analyses of the default study need 2 to 5,
# the strongest of the convergence study 10.
MEAN_ITERATIONS: Final = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """End of a response history."""

    status: Status = "ok"  # status, as in the demands table
    collapse_criterion: str = ""  # name of the demand that exceeded its limit, or empty
    message: str = ""  # reason for an early end, or empty


class NoConvergenceError(Exception):
    """All recovery steps failed in a (sub-)step."""


class StepLoop:
    """Advances the model in the open domain by regular steps, subdivided near contact events.

    Steps in which contacts change are halved repeatedly; recovery steps follow if a step does not
    converge. Creating a loop starts a history: the contacts take the state under gravity as a state
    at rest.

    Args:
        contacts: Contacts of the model, updated after each converged (sub-)step; or None.
        settings: Steps, integrator and tolerance.
        set_far: Called with True when steps far from contact begin, with False when they end.
        longest_s: Longest time (s) between two readings of the model; 0: read after every step.
    """

    recovery_steps: Sequence[RecoveryStep] = RECOVERY_STEPS

    def __init__(
        self,
        contacts: ContactSet | None,
        settings: AnalysisSettings,
        set_far: Callable[[bool], None] = lambda _: None,
        longest_s: float = LONGEST_S,
    ) -> None:
        self.effort = Effort()
        self._contacts, self._settings, self._set_far = contacts, settings, set_far
        self._longest_s = longest_s
        self._number = 0  # recovery step in use
        self._held = 0  # number of next steps that keep it
        self._reuses = False  # REUSE is in use
        self._is_fresh = False  # its tangent need not be renewed
        self._size_s = 0.0  # size of the last (sub-)step
        self._calm_s = inf  # time since the deck last swung
        self._coarse = self._in_contact = settings.contact_halvings
        self._at_event = settings.event_halvings
        if contacts is not None:
            contacts.start_from_rest()

    def run(
        self, steps: int, read: Callable[[], Ending | None], progress: Progress | None = None
    ) -> Ending:
        """Run all regular steps or until an early end; return the ending.

        Args:
            steps: Number of regular steps.
            read: Called after each (sub-)step, or each group of steps made in one OpenSees call,
                and its contact update; returns an ending to stop the history, else None.
            progress: Called about every 50 steps with the time reached and the duration (s).
        """
        configure_solver(self._settings)
        self.start()
        try:
            for size_s in self.committed(steps, progress):
                if self._contacts is not None:
                    self._contacts.after_step(size_s)
                    is_swing = self._contacts.least_opening_ratio < SWING_SHARE
                    self._calm_s = 0.0 if is_swing else self._calm_s + size_s
                if (ending := read()) is not None:
                    return ending
        except (ContactError, NoConvergenceError) as error:
            return Ending(status="numerical_failure", message=str(error))
        except TimeoutError as error:
            return Ending(status="timeout", message=str(error))
        return Ending()

    def start(self) -> None:
        """Define algorithm, integrator and analysis of the domain."""
        ops.algorithm(*self.recovery_steps[0].algorithm)
        ops.integrator(*self._settings.integrator_command)
        ops.analysis("Transient", "-noWarnings")

    def committed(self, steps: int, progress: Progress | None = None) -> Generator[float]:
        """Make regular steps; yield the size (s) of each converged (sub-)step or group of steps.

        Raises `NoConvergenceError` if all recovery steps failed, and `TimeoutError` above the
        budget of iterations.
        """
        dt_s, budget, reported = self._settings.dt_s, MEAN_ITERATIONS * steps, 0
        done_parts = 0  # in the smallest parts of a regular step
        while done_parts < steps * _FINEST:
            offset = done_parts % _FINEST
            least = MAX_HALVINGS - ((offset & -offset).bit_length() - 1 if offset else MAX_HALVINGS)
            halvings = self.halvings(least)
            step_parts, size_s = _FINEST >> halvings, dt_s / 2**halvings
            is_far = halvings <= self._coarse and self._held == 0 and self._is_far()
            is_ready = self._is_fresh if is_far else self._held == 0 and not self._reuses
            n_made = 0
            if is_ready and size_s == self._size_s:
                count = min((steps * _FINEST - done_parts) // step_parts, self._together(size_s))
                if count > 1:
                    n_made = yield from self._take_together(count, size_s)
            if n_made == 0:
                n_made = 1
                yield from self._advance(size_s, is_far=is_far)
            done_parts += n_made * step_parts
            if done_parts % _FINEST == 0:
                if self.effort.iterations > budget:
                    raise TimeoutError(f"more than {budget} iterations, {MEAN_ITERATIONS} per step")
                if progress is not None and done_parts // _FINEST - reported >= _STEPS_PER_REPORT:
                    reported = done_parts // _FINEST
                    progress(reported * dt_s, steps * dt_s)

    # --- sizes of the steps

    def halvings(self, at_least: int) -> int:
        """Return how often to halve the regular step to resolve contacts, at least ``at_least``."""
        contacts, finest = self._contacts, self._at_event
        if contacts is None or finest == 0:
            return at_least
        halvings = at_least
        if contacts.is_any_closed:
            self._adapt(contacts)
            halvings = max(at_least, self._in_contact)
        elif self._calm_s < SWING_S:
            halvings = max(at_least, self._coarse)
        if halvings < finest:
            longest_s = contacts.time_to_change_s() / LOOK_AHEAD
            while halvings < finest and self._settings.dt_s / 2**halvings > longest_s:
                halvings += 1
        return halvings

    def _adapt(self, contacts: ContactSet) -> None:
        """Halve the step in contact if the friction error is too large; double it if it is small.

        After a contact opens or closes, steps restart at the finest size.
        """
        friction_error, limit = contacts.friction_error, self._settings.max_friction_error
        if contacts.changes:
            self._in_contact = self._at_event
        elif friction_error > limit:
            self._in_contact = min(self._in_contact + 1, self._at_event)
        elif friction_error < _GROW * limit:
            self._in_contact = max(self._in_contact - 1, self._coarse)

    def _is_far(self) -> bool:
        """Return whether all contacts are open, so that an earlier tangent may be reused."""
        contacts = self._contacts
        return self._settings.reuse_tangent and contacts is not None and not contacts.is_any_closed

    def _together(self, size_s: float) -> int:
        """Return how many steps of this size fit before a contact could close; 1 near contact."""
        contacts = self._contacts
        if contacts is None or contacts.is_any_closed:
            return 1
        if size_s < self._settings.dt_s / 2**self._coarse:
            return 1
        count = int(min(self._longest_s, contacts.time_to_closing_s(MAX_ACCEL_MPS2)) / size_s)
        # without event steps, the last step before a closing is single: it predicts the friction
        return count if self._at_event > 0 else count - 1

    # --- solution of the steps

    def _take_together(self, count: int, size_s: float) -> Generator[float, None, int]:
        """Make up to ``count`` steps in one call; yield their time (s), return their number."""
        before_s = ops.getTime()
        is_done = ops.analyze(count, size_s) == 0
        n_made = count if is_done else round((ops.getTime() - before_s) / size_s)
        self._is_fresh = self._reuses and is_done and ops.testIter() < 2
        # estimate: one iteration per step with an old tangent, otherwise as in the last step
        self.effort.iterations += n_made if self._reuses or not is_done else n_made * ops.testIter()
        self.effort.substeps += n_made * (size_s < self._settings.dt_s)
        self.effort.steps_by_rung[0] += n_made
        if not is_done and self._reuses:
            self._count_failure(REUSE)
            self._reset()
        if n_made:
            yield n_made * size_s
        if is_done and self._contacts is not None:  # the test is still set
            self._contacts.prepare(size_s)
            return n_made
        self.prepare(size_s)
        if self._reuses:
            return n_made
        yield from self._recover(size_s)
        return n_made + 1

    def _advance(self, size_s: float, *, is_far: bool) -> Generator[float]:
        """Advance the analysis by one time step of ``size_s``, with recovery steps if it fails."""
        if size_s != self._size_s:
            self._size_s = size_s
            self._is_fresh = False
            self.prepare(size_s)
        if is_far and self._reuse(size_s):
            yield size_s
            return
        if self._reuses:
            self._reuses = False
            self._set_far(False)
            self._use(0, size_s)
        if ops.analyze(1, size_s) != 0:
            yield from self._recover(size_s)
            return
        self._count_step(size_s)
        if self._held > 0:
            self._held -= 1
            if self._held == 0:
                self._use(0, size_s)
        yield size_s

    def _reuse(self, size_s: float) -> bool:
        """Try a step with the tangent of an earlier step; return whether it converged."""
        if not (self._reuses and self._is_fresh):
            if not self._reuses:
                self._set_far(True)
                set_test(self._settings, size_s, REUSE)
            ops.algorithm(*REUSE.algorithm)
            self._reuses = True
        if ops.analyze(1, size_s) != 0:
            self._count_failure(REUSE)
            self._is_fresh = False
            self._reset()
            self.prepare(size_s)
            return False
        self._is_fresh = ops.testIter() < 2
        self._count_step(size_s)
        return True

    def _recover(self, size_s: float) -> Generator[float]:
        """Complete a failed step by the next recovery steps; each starts where the last stopped."""
        self._count_failure(self.recovery_steps[self._number])
        finest = self.recovery_steps[-1].substeps
        remaining = finest  # rest of the step, in parts of the finest recovery step
        for number, step in enumerate(self.recovery_steps[1:], start=1):
            part_s = size_s / step.substeps
            self._use(number, part_s)
            self._reset()
            self.prepare(part_s)
            while remaining and ops.analyze(1, part_s) == 0:
                remaining -= finest // step.substeps
                self._count_step(part_s)
                yield part_s
            if remaining:
                self._count_failure(step)
                continue
            if step.substeps == 1:
                self._held = HELD_STEPS  # the difficulty often affects the next steps
                return
            break
        self._held = 0
        self._use(0, size_s)
        self._reset()
        self.prepare(size_s)
        if remaining:
            raise NoConvergenceError("no recovery step converged")

    def _reset(self) -> None:
        """Reset integrator and equations, which keep values of a failed step.

        A retry without a reset is silently wrong (accelerations of hundreds of m/s2 at OSB1).
        """
        ops.integrator(*self._settings.integrator_command)
        ops.domainChange()

    def _use(self, number: int, size_s: float) -> None:
        self._number, step = number, self.recovery_steps[number]
        set_test(self._settings, size_s, step)
        ops.algorithm(*step.algorithm)

    def prepare(self, size_s: float) -> None:
        """Set the convergence test, and tell contacts the size of the next (sub-)steps (s)."""
        step = REUSE if self._reuses else self.recovery_steps[self._number]
        set_test(self._settings, size_s, step)
        if self._contacts is not None:
            self._contacts.prepare(size_s)

    def _count_step(self, size_s: float) -> None:
        self.effort.iterations += ops.testIter()
        self.effort.substeps += size_s < self._settings.dt_s
        self.effort.steps_by_rung[self._number] += 1

    def _count_failure(self, step: RecoveryStep) -> None:
        self.effort.failures += 1
        self.effort.iterations += step.max_iterations


def configure_solver(settings: AnalysisSettings) -> None:
    """Set the solver of all recovery steps (symmetric, as the tangent is), and the usual test."""
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    set_test(settings, settings.dt_s)


def set_test(
    settings: AnalysisSettings, step_s: float, recovery_step: RecoveryStep = RECOVERY_STEPS[0]
) -> None:
    """Set the convergence test of a recovery step for steps of ``step_s``."""
    # the unknowns may be velocities: OpenSees tests their product with the unbalanced forces
    tolerance = max(recovery_step.tolerance_j, settings.tolerance_j) / settings.increment_s(step_s)
    ops.test("EnergyIncr", tolerance, recovery_step.max_iterations)
