"""Recovery of steps that do not converge: the sequence of solution attempts."""

from collections import Counter
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import openseespy.opensees as ops

from skewbridge.analysis.settings import AnalysisSettings, OpenSeesCommand


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """One solution strategy for a step (a recovery step)."""

    algorithm: OpenSeesCommand  # arguments of the algorithm command
    #: number of equal sub-steps; a multiple of the number in the previous recovery step, so that a
    #: recovery step can continue where the previous one stopped
    substeps: int = 1
    #: tolerance of a looser convergence test, or 0 for the tolerance of the settings
    tolerance_j: float = 0.0
    #: iterations after which the attempt fails; None: as in the settings
    max_iterations: int | None = None

    @property
    def description(self) -> str:
        """Algorithm, sub-steps and looser tolerance, for tables."""
        parts = [str(self.algorithm[0])]
        if self.substeps > 1:
            parts.append(f"{self.substeps} sub-steps")
        if self.tolerance_j:
            parts.append(f"test {self.tolerance_j:g} J")
        return ", ".join(parts)


# The force of a shear key jumps when the key breaks: no displacement of its node is in equilibrium,
# however small the step, and the iteration alternates across the jump. This tolerance accepts the
# step and changes no demand; 100 J would change a drift by 4 %.
LOOSE_J: Final = 0.1

# The line search needs the fewest iterations; KrylovNewton solves most stick-slip cycles
# that the line search does not solve.
LADDER: Final = (
    Attempt(algorithm=("NewtonLineSearch",)),
    Attempt(algorithm=("KrylovNewton",)),
    Attempt(algorithm=("NewtonLineSearch",), tolerance_j=LOOSE_J),
    Attempt(algorithm=("KrylovNewton",), substeps=4),
    Attempt(algorithm=("NewtonLineSearch",), substeps=4, tolerance_j=LOOSE_J),
    Attempt(algorithm=("NewtonLineSearch",), substeps=20, tolerance_j=LOOSE_J),
    Attempt(algorithm=("Broyden", 20), substeps=100, tolerance_j=LOOSE_J),
)
# Far from contact the columns change slowly, so the tangent of an earlier step is used. It is
# renewed after a step that took two iterations. The looser test changes no demand.
REUSE: Final = Attempt(
    algorithm=("ModifiedNewton", "-factoronce"), tolerance_j=0.1, max_iterations=6
)
HELD_STEPS: Final = 5
# A regular step is divided into at most 2^16 parts; the settings need at most 2^11.
MAX_HALVINGS: Final = 16
_FINEST: Final = 2**MAX_HALVINGS


@dataclass(slots=True, kw_only=True)
class Effort:
    """Cost of the steps so far; iterations include failed attempts."""

    iterations: int = 0
    failed_attempts: int = 0
    substeps: int = 0  # steps shorter than the regular one
    # Number of (sub-)steps that converged in each recovery step.
    steps_by_rung: Counter[int] = field(default_factory=Counter[int])

    @property
    def highest_rung(self) -> int:
        """Highest recovery step in which a step converged; 0 without steps."""
        return max(self.steps_by_rung, default=0)


class NoConvergenceError(Exception):
    """All recovery steps failed at a part of a step."""


class Stepper:
    """Advances the domain by regular steps, and by recovery steps if one does not converge.

    Steps in which contacts change are halved repeatedly. Methods without an underscore are the
    policy, here that of a model without contacts.
    """

    ladder: Sequence[Attempt] = LADDER

    def __init__(
        self, settings: AnalysisSettings, set_far: Callable[[bool], None] = lambda _: None
    ) -> None:
        """Take a function to call when steps far from contact begin (True) or end (False)."""
        self.effort = Effort()
        self._settings, self._set_far = settings, set_far
        # Number of next steps that keep the attempt that solved the last difficult step.
        self._held = 0
        self._rung = 0  # recovery step in use
        self._last_s = 0.0  # size of the last (sub-)step
        self._reuses = False  # REUSE is in use
        self._is_fresh = False  # its tangent need not be renewed

    def halvings(self, least: int) -> int:
        """Return how often to halve the next step: at least ``least``, to stay inside the step."""
        return least

    def is_far(self) -> bool:
        """Return whether the next (sub-)step may use the tangent of an earlier step."""
        return False

    def together(self, size_s: float) -> int:
        """Return how many steps of an unchanged size may be made in one OpenSees call."""
        return 1

    def set_test(self, attempt: Attempt) -> None:
        """Set the convergence test of an attempt."""

    def prepare(self, size_s: float) -> None:
        """Prepare a (sub-)step of a new size, or a retry."""

    def check_effort(self, done: int) -> None:
        """Check the effort after a number of regular steps."""

    def start(self) -> None:
        """Define algorithm, integrator and analysis of the domain."""
        ops.algorithm(*self.ladder[0].algorithm)
        ops.integrator(*self._settings.integrator_command)
        ops.analysis("Transient", "-noWarnings")

    def committed(self, steps: int) -> Generator[float]:
        """Make regular steps; yield the size (s) of each converged (sub-)step or group of steps.

        Raises `NoConvergenceError` if all recovery steps failed.
        """
        done = 0  # in the smallest parts of a regular step
        while done < steps * _FINEST:
            within = done % _FINEST
            fits = MAX_HALVINGS - ((within & -within).bit_length() - 1 if within else MAX_HALVINGS)
            halvings = self.halvings(fits)
            part, size_s = _FINEST >> halvings, self._settings.dt_s / 2**halvings
            coarse = self._settings.contact_halvings
            is_far = halvings <= coarse and self._held == 0 and self.is_far()
            is_ready = self._is_fresh if is_far else self._held == 0 and not self._reuses
            made = 0
            if is_ready and size_s == self._last_s:
                count = min((steps * _FINEST - done) // part, self.together(size_s))
                if count > 1:
                    made = yield from self._take_together(count, size_s)
            if made == 0:
                made = 1
                yield from self._advance(size_s, is_far=is_far)
            done += made * part
            if done % _FINEST == 0:
                self.check_effort(done // _FINEST)

    def _take_together(self, count: int, size_s: float) -> Generator[float, None, int]:
        """Make up to ``count`` steps of the last size; return their number."""
        before_s = ops.getTime()
        is_done = ops.analyze(count, size_s) == 0
        made = count if is_done else round((ops.getTime() - before_s) / size_s)
        self._is_fresh = self._reuses and is_done and ops.testIter() < 2
        # estimate: one iteration per step with an old tangent, otherwise as in the last step
        self.effort.iterations += made if self._reuses or not is_done else made * ops.testIter()
        self.effort.substeps += made * (size_s < self._settings.dt_s)
        self.effort.steps_by_rung[0] += made
        if not is_done and self._reuses:
            self._count_failure(REUSE)
            self._reset()
        if made:
            yield made * size_s
        self.prepare(size_s)
        if is_done or self._reuses:
            return made
        yield from self._recover(size_s)
        return made + 1

    def _advance(self, size_s: float, *, is_far: bool) -> Generator[float]:
        if size_s != self._last_s:
            self._last_s = size_s
            self._is_fresh = False
            self.prepare(size_s)
        if is_far and self._reuse(size_s):
            yield size_s
            return
        if self._reuses:
            self._reuses = False
            self._set_far(False)
            self._use(0)
        if ops.analyze(1, size_s) != 0:
            yield from self._recover(size_s)
            return
        self._count_step(size_s)
        if self._held > 0:
            self._held -= 1
            if self._held == 0:
                self._use(0)
        yield size_s

    def _recover(self, size_s: float) -> Generator[float]:
        self._count_failure(self.ladder[self._rung])
        solved_by = yield from self._climb(size_s)
        if solved_by and solved_by.substeps == 1:
            # The difficulty of this step often affects the next ones.
            self._held = HELD_STEPS
            return
        self._held = 0
        self._use(0)
        self._reset()
        self.prepare(size_s)
        if solved_by is None:
            raise NoConvergenceError("no attempt at a step converged")

    def _reuse(self, size_s: float) -> bool:
        """Try a step with the tangent of an earlier step; return whether it converged."""
        if not (self._reuses and self._is_fresh):
            if not self._reuses:
                self._set_far(True)
                self.set_test(REUSE)
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

    def _climb(self, size_s: float) -> Generator[float, None, Attempt | None]:
        """Return the recovery step that solved the step, or None."""
        finest = self.ladder[-1].substeps
        left = finest  # rest of the step, in parts of the finest attempt
        for rung, attempt in enumerate(self.ladder[1:], start=1):
            part_s = size_s / attempt.substeps
            self._use(rung)
            self._reset()
            self.prepare(part_s)
            while left:
                if ops.analyze(1, part_s) != 0:
                    self._count_failure(attempt)
                    break
                left -= finest // attempt.substeps
                self._count_step(part_s)
                yield part_s
            else:
                return attempt
        return None

    def _reset(self) -> None:
        """Reset integrator and equations, which keep values of a failed step.

        A retry without a reset is silently wrong (accelerations of hundreds of m/s2 at OSB1).
        """
        ops.integrator(*self._settings.integrator_command)
        ops.domainChange()

    def _use(self, rung: int) -> None:
        self._rung, attempt = rung, self.ladder[rung]
        self.set_test(attempt)
        ops.algorithm(*attempt.algorithm)

    def _count_step(self, size_s: float) -> None:
        self.effort.iterations += ops.testIter()
        self.effort.substeps += size_s < self._settings.dt_s
        self.effort.steps_by_rung[self._rung] += 1

    def _count_failure(self, attempt: Attempt) -> None:
        self.effort.failed_attempts += 1
        self.effort.iterations += attempt.max_iterations or self._settings.max_iterations


def steps_as_text(steps_by_rung: Iterable[int]) -> str:
    """Return the text of column ``steps_by_rung``: (sub-)steps of each recovery step from 0."""
    return " ".join(map(str, steps_by_rung))


def steps_from_text(text: str) -> list[int]:
    """Return the numbers in the text of column ``steps_by_rung``; empty if the text is empty."""
    return [int(steps) for steps in text.split()]


def rung_shares(steps_by_rung: Iterable[Sequence[int]]) -> list[dict[str, Any]]:
    """Return numbers and shares of steps and analyses, one row per recovery step.

    ``steps_by_rung`` has the (sub-)steps of each analysis in each recovery step. ``analyses``
    counts those that needed this recovery step but no higher one.
    """
    counts = list(steps_by_rung)
    highest = [max((rung for rung, n in enumerate(steps) if n), default=0) for steps in counts]
    totals = [
        sum(steps[rung] for steps in counts if rung < len(steps)) for rung in range(len(LADDER))
    ]
    return [
        {
            "rung": rung,
            "attempt": attempt.description,
            "steps": totals[rung],
            "steps_share": totals[rung] / max(sum(totals), 1),
            "analyses": highest.count(rung),
            "analyses_share": highest.count(rung) / max(len(counts), 1),
        }
        for rung, attempt in enumerate(LADDER)
    ]
