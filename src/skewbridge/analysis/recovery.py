"""Steps that do not converge: what is tried, in order, as data."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.settings import Command


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """One way to get over a step.

    Attributes:
        algorithm: Arguments of the algorithm command.
        substeps: Equal parts that the step is cut into; each rung's number is a multiple of the
            one before, so that a rung can go on from where the last one stopped.
        tolerance_j: Tolerance of the convergence test where it is looser than the usual one.
    """

    algorithm: Command
    substeps: int = 1
    tolerance_j: float = 0.0


# A broken shear key unloads with a jump of force: no displacement of its node is in
# equilibrium there, however small the step, and the iteration goes to and fro across the jump.
# This much lets it pass and changes no demand; a hundred joules would (4 % of a drift).
LOOSE_J: Final = 0.1

# The line search takes the fewest iterations; KrylovNewton gets over most cycles of stick and slip
# that it does not.
LADDER: Final = (
    Attempt(algorithm=("NewtonLineSearch",)),
    Attempt(algorithm=("KrylovNewton",)),
    Attempt(algorithm=("NewtonLineSearch",), tolerance_j=LOOSE_J),
    Attempt(algorithm=("KrylovNewton",), substeps=4),
    Attempt(algorithm=("NewtonLineSearch",), substeps=4, tolerance_j=LOOSE_J),
    Attempt(algorithm=("NewtonLineSearch",), substeps=20, tolerance_j=LOOSE_J),
    Attempt(algorithm=("Broyden", 20), substeps=100, tolerance_j=LOOSE_J),
)
HELD_STEPS: Final = 20
# A regular step is cut into at most 2^16 parts: the settings ask for 2^11 at most.
MAX_HALVINGS: Final = 16
_FINEST: Final = 2**MAX_HALVINGS


@dataclass(slots=True, kw_only=True)
class Effort:
    """What the steps have cost so far; iterations include those of failed attempts."""

    iterations: int = 0
    failed_attempts: int = 0
    substeps: int = 0  # steps shorter than the regular one
    # (Sub-)steps that converged on each rung of the ladder.
    steps_by_rung: Counter[int] = field(default_factory=Counter[int])

    @property
    def highest_rung(self) -> int:
        """Highest rung on which a step converged."""
        return max(self.steps_by_rung, default=0)


@dataclass(slots=True, kw_only=True)
class Stepper:
    """Advances the domain by regular steps, climbing the ladder where one does not converge.

    A step in which something happens is made in parts: halves, quarters, and so on.

    Attributes:
        integrator: Arguments of the integrator command.
        dt_s: Regular step.
        halvings: Called before each (sub-)step with the fewest halvings of the regular step that
            lead no further than to its end or to the next multiple of the sub-step; returns how
            often to halve, that number or more.
        loosen: Called with the tolerance of an attempt where one starts or ends.
        max_iterations: Cost of an attempt that failed.
        before: Called with the size of the coming (sub-)step where it differs from the last one,
            and before each retry.
        after: Called with the size of each converged (sub-)step; whether the history goes on.
        ladder: What to try.
        effort: What the steps have cost so far.
    """

    integrator: Command
    dt_s: float
    halvings: Callable[[int], int]
    loosen: Callable[[float], None]
    max_iterations: int
    before: Callable[[float], None]
    after: Callable[[float], bool]
    ladder: Sequence[Attempt] = LADDER
    effort: Effort = field(default_factory=Effort, init=False)
    # Steps still to be taken as the last difficult one was.
    _held: int = field(default=0, init=False)
    _rung: int = field(default=0, init=False)  # in use
    _size_s: float = field(default=0.0, init=False)  # of the last (sub-)step

    def __post_init__(self) -> None:
        ops.algorithm(*self.ladder[0].algorithm)
        ops.integrator(*self.integrator)

    def step(self) -> bool:
        """Advance one regular step; False when the whole ladder failed at a part of it."""
        done = 0  # in parts of the regular step that is halved as often as ever
        while done < _FINEST:
            fits = MAX_HALVINGS - ((done & -done).bit_length() - 1 if done else MAX_HALVINGS)
            halvings = self.halvings(fits)
            if not self._advance(self.dt_s / 2**halvings):
                return False
            done += _FINEST >> halvings
        return True

    def _advance(self, size_s: float) -> bool:
        """Take one step of a size, by the ladder if it does not converge."""
        if size_s != self._size_s:
            self._size_s = size_s
            self.before(size_s)
        if ops.analyze(1, size_s) == 0:
            self._count_step(size_s)
            if self._held > 0:
                self._held -= 1
                if self._held == 0:
                    self._use(0)
            return self.after(size_s)
        self._count_failure()
        rung, goes_on = self._climb(size_s)
        if rung is not None and self.ladder[rung].substeps == 1:
            # What stopped this step often stops the next ones.
            self._held = HELD_STEPS
            return goes_on
        self._held = 0
        self._use(0)
        self._start_anew()
        self.before(size_s)
        return goes_on and rung is not None

    def _climb(self, size_s: float) -> tuple[int | None, bool]:
        """Take the step by the ladder; return the rung that ended it and whether to go on."""
        finest = self.ladder[-1].substeps
        left, goes_on = finest, True  # of the step, in parts of the finest rung
        for rung, attempt in enumerate(self.ladder[1:], start=1):
            part = finest // attempt.substeps
            self._use(rung)
            self._start_anew()
            taken, goes_on = self._take(left // part, size_s / attempt.substeps)
            left -= part * taken
            if left == 0 or not goes_on:
                return rung, goes_on
        return None, goes_on

    def _start_anew(self) -> None:
        """Make integrator and equations forget a failed step.

        Houbolt keeps what it left behind, and with rigid links the equations of any integrator do:
        a retry without this is silently wrong (accelerations of hundreds of m/s2 at OSB1).
        """
        ops.integrator(*self.integrator)
        ops.domainChange()

    def _use(self, rung: int) -> None:
        self._rung, attempt = rung, self.ladder[rung]
        self.loosen(attempt.tolerance_j)
        ops.algorithm(*attempt.algorithm)

    def _take(self, count: int, size_s: float) -> tuple[int, bool]:
        """Take equal steps until one fails; return how many, and whether the history goes on."""
        self.before(size_s)
        for taken in range(count):
            if ops.analyze(1, size_s) != 0:
                self._count_failure()
                return taken, True
            self._count_step(size_s)
            if not self.after(size_s):
                return taken + 1, False
        return count, True

    def _count_step(self, size_s: float) -> None:
        self.effort.iterations += ops.testIter()
        self.effort.substeps += size_s < self.dt_s
        self.effort.steps_by_rung[self._rung] += 1

    def _count_failure(self) -> None:
        self.effort.failed_attempts += 1
        self.effort.iterations += self.max_iterations
