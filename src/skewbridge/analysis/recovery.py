"""Recovery of steps that do not converge: the sequence of solution attempts."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import openseespy.opensees as ops

from skewbridge.analysis.settings import OpenSeesCommand


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """One solution strategy for a step (a recovery step).

    Attributes:
        algorithm: Arguments of the algorithm command.
        substeps: Number of equal sub-steps; a multiple of the number in the previous recovery
            step, so that a recovery step can continue where the previous one stopped.
        tolerance_j: Tolerance of a looser convergence test, or 0 for the tolerance of the settings.
        max_iterations: Iterations after which the attempt fails; None: as in the settings.
    """

    algorithm: OpenSeesCommand
    substeps: int = 1
    tolerance_j: float = 0.0
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


@dataclass(slots=True, kw_only=True)
class Stepper:
    """Advances the domain by regular steps, and by recovery steps if one does not converge.

    A step in which contacts change is divided into halves, quarters, and so on.

    Attributes:
        integrator: Arguments of the integrator command.
        dt_s: Regular step.
        halvings: Called before each (sub-)step with the smallest number of halvings that keeps
            sub-steps at multiples of their size and inside the regular step; returns the number to
            use, at least as large.
        is_far: Called before each (sub-)step of at most `coarse` halvings; returns whether it is
            far from contact, so that it may use the tangent of an earlier step.
        set_far: Called with True when steps far from contact begin, with False when they end.
        set_test: Called at the start of each attempt to set its convergence test.
        max_iterations: Iterations counted for a failed attempt without its own limit.
        before: Called with the size of the next (sub-)step when the size changes, and before
            each retry.
        after: Called with the size of each converged (sub-)step; returns whether to continue.
        coarse: Largest number of halvings of a step that may use an earlier tangent.
        together: Called with the size of the next step if it is unchanged; returns how many such
            steps may be made before `after` is called.
        ladder: The attempts, in order.
        effort: Cost of the steps so far.
    """

    integrator: OpenSeesCommand
    dt_s: float
    halvings: Callable[[int], int]
    is_far: Callable[[], bool]
    set_far: Callable[[bool], None]
    set_test: Callable[[Attempt], None]
    max_iterations: int
    before: Callable[[float], None]
    after: Callable[[float], bool]
    coarse: int = 0
    together: Callable[[float], int] = lambda _: 1
    ladder: Sequence[Attempt] = LADDER
    effort: Effort = field(default_factory=Effort, init=False)
    # Number of next steps that keep the attempt that solved the last difficult step.
    _held: int = field(default=0, init=False)
    _rung: int = field(default=0, init=False)  # recovery step in use
    _size_s: float = field(default=0.0, init=False)  # size of the last (sub-)step
    _reuses: bool = field(default=False, init=False)  # REUSE is in use
    _is_fresh: bool = field(default=False, init=False)  # its tangent need not be renewed

    def __post_init__(self) -> None:
        ops.algorithm(*self.ladder[0].algorithm)
        ops.integrator(*self.integrator)

    def step(self, most: int = 1) -> int:
        """Advance at least one and at most `most` regular steps; return their number.

        It is 0 if all recovery steps failed at a part of a step, or if `after` ended the run.
        """
        done = 0  # progress in the smallest parts of a regular step
        while done == 0 or done % _FINEST:
            within = done % _FINEST
            fits = MAX_HALVINGS - ((within & -within).bit_length() - 1 if within else MAX_HALVINGS)
            halvings = self.halvings(fits)
            part, size_s = _FINEST >> halvings, self.dt_s / 2**halvings
            is_far = halvings <= self.coarse and self._held == 0 and self.is_far()
            made, continues = 0, True
            is_ready = self._is_fresh if is_far else self._held == 0 and not self._reuses
            if is_ready and size_s == self._size_s:
                left = (most * _FINEST - done) // part
                made, continues = self._take_together(min(left, self.together(size_s)))
            if made == 0:
                made, continues = 1, self._advance(size_s, is_far=is_far)
            if not continues:
                return 0
            done += made * part
        return done // _FINEST

    def _take_together(self, count: int) -> tuple[int, bool]:
        """Make up to `count` steps of the last size, with the return values of `_take`."""
        if count < 2:
            return 0, True
        size_s, before_s = self._size_s, ops.getTime()
        is_done = ops.analyze(count, size_s) == 0
        made = count if is_done else round((ops.getTime() - before_s) / size_s)
        self._is_fresh = self._reuses and is_done and ops.testIter() < 2
        # estimate: one iteration per step with an old tangent, otherwise as in the last step
        self.effort.iterations += made if self._reuses or not is_done else made * ops.testIter()
        self.effort.substeps += made * (size_s < self.dt_s)
        self.effort.steps_by_rung[0] += made
        if not is_done and self._reuses:
            self._count_failure(REUSE)
            self._reset()
        continues = made == 0 or self.after(made * size_s)
        self.before(size_s)
        if is_done or self._reuses or not continues:
            return made, continues
        return made + 1, self._recover(size_s)

    def _advance(self, size_s: float, *, is_far: bool) -> bool:
        """Make one (sub-)step, by recovery steps if needed; return whether to continue."""
        if size_s != self._size_s:
            self._size_s = size_s
            self._is_fresh = False
            self.before(size_s)
        if is_far and self._reuse(size_s):
            return self.after(size_s)
        if self._reuses:
            self._reuses = False
            self.set_far(False)
            self._use(0)
        if ops.analyze(1, size_s) == 0:
            self._count_step(size_s)
            if self._held > 0:
                self._held -= 1
                if self._held == 0:
                    self._use(0)
            return self.after(size_s)
        return self._recover(size_s)

    def _recover(self, size_s: float) -> bool:
        """Make a step by recovery steps after its first attempt; return whether to continue."""
        self._count_failure(self.ladder[self._rung])
        rung, continues = self._climb(size_s)
        if rung is not None and self.ladder[rung].substeps == 1:
            # The difficulty of this step often affects the next ones.
            self._held = HELD_STEPS
            return continues
        self._held = 0
        self._use(0)
        self._reset()
        self.before(size_s)
        return continues and rung is not None

    def _reuse(self, size_s: float) -> bool:
        """Try a step with the tangent of an earlier step; return whether it converged."""
        if not (self._reuses and self._is_fresh):
            if not self._reuses:
                self.set_far(True)
                self.set_test(REUSE)
            ops.algorithm(*REUSE.algorithm)
            self._reuses = True
        if ops.analyze(1, size_s) != 0:
            self._count_failure(REUSE)
            self._is_fresh = False
            self._reset()
            self.before(size_s)
            return False
        self._is_fresh = ops.testIter() < 2
        self._count_step(size_s)
        return True

    def _climb(self, size_s: float) -> tuple[int | None, bool]:
        """Return the recovery step that solved the step, or None, and whether to continue."""
        finest = self.ladder[-1].substeps
        left, continues = finest, True  # rest of the step, in parts of the finest attempt
        for rung, attempt in enumerate(self.ladder[1:], start=1):
            part = finest // attempt.substeps
            self._use(rung)
            self._reset()
            taken, continues = self._take(left // part, size_s / attempt.substeps)
            left -= part * taken
            if left == 0 or not continues:
                return rung, continues
        return None, continues

    def _reset(self) -> None:
        """Reset integrator and equations after a failed step.

        Houbolt keeps values of the failed step. With rigid links, the equations of every integrator
        keep them too. A retry without a reset is silently wrong (accelerations of hundreds of m/s2
        at OSB1).
        """
        ops.integrator(*self.integrator)
        ops.domainChange()

    def _use(self, rung: int) -> None:
        self._rung, attempt = rung, self.ladder[rung]
        self.set_test(attempt)
        ops.algorithm(*attempt.algorithm)

    def _take(self, count: int, size_s: float) -> tuple[int, bool]:
        """Make equal steps until one fails; return their number and whether to continue."""
        self.before(size_s)
        for taken in range(count):
            if ops.analyze(1, size_s) != 0:
                self._count_failure(self.ladder[self._rung])
                return taken, True
            self._count_step(size_s)
            if not self.after(size_s):
                return taken + 1, False
        return count, True

    def _count_step(self, size_s: float) -> None:
        self.effort.iterations += ops.testIter()
        self.effort.substeps += size_s < self.dt_s
        self.effort.steps_by_rung[self._rung] += 1

    def _count_failure(self, attempt: Attempt) -> None:
        self.effort.failed_attempts += 1
        self.effort.iterations += attempt.max_iterations or self.max_iterations


def steps_as_text(steps_by_rung: Iterable[int]) -> str:
    """Return the text of column ``steps_by_rung``: (sub-)steps of each recovery step from 0."""
    return " ".join(map(str, steps_by_rung))


def steps_from_text(text: str) -> list[int]:
    """Return the numbers in the text of column ``steps_by_rung``; empty if the text is empty."""
    return [int(steps) for steps in text.split()]


def rung_shares(steps_by_rung: Iterable[Sequence[int]]) -> list[dict[str, Any]]:
    """Return numbers and shares of steps and analyses for each recovery step.

    Args:
        steps_by_rung: For each analysis, its (sub-)steps in each recovery step; may be empty.

    Returns:
        One row per recovery step: ``rung``, ``attempt`` (description), ``steps`` and
        ``steps_share`` ((sub-)steps that converged at it), ``analyses`` and ``analyses_share``
        (analyses that needed it but no higher one).
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
