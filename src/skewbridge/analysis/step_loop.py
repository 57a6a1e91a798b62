"""Step loop of all response histories: solver, step sizes, contact updates and ending."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from os import devnull
from pathlib import Path
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.recovery import LADDER, Attempt, NoConvergenceError, Stepper
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.contact import ContactError, ContactSet
from skewbridge.statuses import Status

type Progress = Callable[[float, float], None]
_STEPS_PER_REPORT: Final = 50
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """End of a response history."""

    status: Status = "ok"  # status, as in the demands table
    collapse_criterion: str = ""  # name of the demand that exceeded its limit, or empty
    message: str = ""  # reason for an early end, or empty


class StepLoop(Stepper):
    """Advances the model in the open domain by regular steps, subdivided near contact events.

    Creating it starts a history: the contacts take the state under gravity as a state at rest.

    Args:
        contacts: Contacts of the model, updated after each converged (sub-)step; or None.
        settings: Step, integrator and iteration budget.
        set_far: Called with True when steps far from contact begin, with False when they end.
        longest_s: Longest time (s) between two readings of the model; 0: read after every step.
    """

    def __init__(
        self,
        contacts: ContactSet | None,
        settings: AnalysisSettings,
        set_far: Callable[[bool], None] = lambda _: None,
        longest_s: float = LONGEST_S,
    ) -> None:
        super().__init__(settings, set_far)
        self._contacts, self._longest_s = contacts, longest_s
        self._size_s, self._attempt = settings.dt_s, LADDER[0]
        self._calm_s = inf  # time since the deck last swung
        self._in_contact, self._finest = settings.contact_halvings, settings.event_halvings
        self._steps, self._reported, self._progress = 0, 0, None
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
        self._steps, self._progress = steps, progress
        configure_solver(self._settings)
        self.start()
        try:
            for size_s in self.committed(steps):
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

    def check_effort(self, done: int) -> None:
        """Report the progress; raise `TimeoutError` above the budget of iterations."""
        budget = self._settings.mean_iterations * self._steps
        if self.effort.iterations > budget:
            raise TimeoutError(f"more than {budget:.0f} iterations")
        if self._progress is not None and done - self._reported >= _STEPS_PER_REPORT:
            self._reported, dt_s = done, self._settings.dt_s
            self._progress(done * dt_s, self._steps * dt_s)

    def halvings(self, least: int) -> int:
        """Return how often to halve the regular step to resolve contacts, at least ``least``."""
        contacts, finest = self._contacts, self._finest
        if contacts is None or finest == 0:
            return least
        halvings = least
        if contacts.is_any_closed:
            self._adapt(contacts)
            halvings = max(least, self._in_contact)
        elif self._calm_s < SWING_S:
            halvings = max(least, self._settings.contact_halvings)
        if halvings < finest:
            longest_s = contacts.time_to_change_s() / LOOK_AHEAD
            while halvings < finest and self._settings.dt_s / 2**halvings > longest_s:
                halvings += 1
        return halvings

    def is_far(self) -> bool:
        """Return whether all contacts are open, so that an earlier tangent may be reused."""
        contacts = self._contacts
        return self._settings.reuse_tangent and contacts is not None and not contacts.is_any_closed

    def together(self, size_s: float) -> int:
        """Return how many steps of this size fit before a contact could close; 1 near contact."""
        contacts, settings = self._contacts, self._settings
        if contacts is None or contacts.is_any_closed:
            return 1
        if size_s < settings.dt_s / 2**settings.contact_halvings:
            return 1
        count = int(min(self._longest_s, contacts.time_to_closing_s(MAX_ACCEL_MPS2)) / size_s)
        # without event steps, the last step before a closing is single: it predicts the friction
        return count if self._finest > 0 else count - 1

    def _adapt(self, contacts: ContactSet) -> None:
        """Halve the step in contact if the friction error is too large; double it if it is small.

        After a contact opens or closes, steps restart at the finest size.
        """
        friction_error, allowed = contacts.friction_error, self._settings.max_friction_error
        if contacts.changes:
            self._in_contact = self._finest
        elif friction_error > allowed:
            self._in_contact = min(self._in_contact + 1, self._finest)
        elif friction_error < _GROW * allowed:
            self._in_contact = max(self._in_contact - 1, self._settings.contact_halvings)

    def set_test(self, attempt: Attempt) -> None:
        """Set the convergence test of an attempt for the present size."""
        self._attempt = attempt
        set_test(self._settings, self._size_s, attempt)

    def prepare(self, size_s: float) -> None:
        """Set test and contacts for (sub-)steps of a size."""
        self._size_s = size_s
        set_test(self._settings, size_s, self._attempt)
        if self._contacts is not None:
            self._contacts.prepare(size_s)


@contextmanager
def solver_log(path: Path | None) -> Generator[None]:
    """Write OpenSees messages to ``path`` inside the block (None: discard); discard later ones."""
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
    ops.logFile(devnull if path is None else str(path), "-noEcho")
    try:
        yield
    finally:
        ops.logFile(devnull, "-noEcho")


def configure_solver(settings: AnalysisSettings) -> None:
    """Set the solver of all attempts (symmetric, as the tangent is) and the convergence test."""
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    set_test(settings, settings.dt_s)


def set_test(settings: AnalysisSettings, step_s: float, attempt: Attempt = LADDER[0]) -> None:
    """Set the convergence test of an attempt for steps of ``step_s``."""
    # the unknowns may be velocities: OpenSees tests their product with the unbalanced forces
    tolerance = max(attempt.tolerance_j, settings.tolerance_j) / settings.increment_s(step_s)
    ops.test("EnergyIncr", tolerance, attempt.max_iterations or settings.max_iterations)
