"""Steps that do not converge: what is tried, in order, as data."""

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
        loosening: Factor on the tolerance of the convergence test.
    """

    algorithm: Command
    substeps: int = 1
    loosening: float = 1.0


# A broken shear key unloads with a jump of force: no displacement of its light node is in
# equilibrium there, however small the step, and the iteration goes to and fro across the jump.
# 1e7 times the tolerance, 0.1 J, lets it pass and changes no demand.
LOOSE: Final = 1.0e7

# KrylovNewton is cheapest, the line search gets over cycles of stick and slip that it does not.
LADDER: Final = (
    Attempt(algorithm=("KrylovNewton",)),
    Attempt(algorithm=("NewtonLineSearch",)),
    Attempt(algorithm=("NewtonLineSearch",), loosening=LOOSE),
    Attempt(algorithm=("KrylovNewton",), substeps=4),
    Attempt(algorithm=("NewtonLineSearch",), substeps=4, loosening=LOOSE),
    Attempt(algorithm=("NewtonLineSearch",), substeps=20, loosening=LOOSE),
    Attempt(algorithm=("Broyden", 20), substeps=100, loosening=LOOSE),
)
HELD_STEPS: Final = 20


@dataclass(slots=True, kw_only=True)
class Effort:
    """What the steps have cost so far; iterations include those of failed attempts."""

    iterations: int = 0
    failed_attempts: int = 0
    substeps: int = 0  # beyond the regular steps
    highest_rung: int = 0


@dataclass(slots=True, kw_only=True)
class Stepper:
    """Advances the domain by regular steps, climbing the ladder where one does not converge.

    Attributes:
        integrator: Arguments of the integrator command.
        dt_s: Regular step.
        loosen: Called with the factor on the tolerance where an attempt starts or ends.
        max_iterations: Cost of an attempt that failed.
        before: Called with the size of a (sub-)step that is retried, before each attempt.
        after: Called with the size of each converged (sub-)step.
        ladder: What to try.
        effort: What the steps have cost so far.
    """

    integrator: Command
    dt_s: float
    loosen: Callable[[float], None]
    max_iterations: int
    before: Callable[[float], None]
    after: Callable[[float], None]
    ladder: Sequence[Attempt] = LADDER
    effort: Effort = field(default_factory=Effort, init=False)
    # Regular steps still to be taken as the last difficult one was.
    _held: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        ops.algorithm(*self.ladder[0].algorithm)
        ops.integrator(*self.integrator)

    def step(self) -> bool:
        """Advance one regular step; False when the whole ladder failed."""
        if ops.analyze(1, self.dt_s) == 0:
            self.effort.iterations += ops.testIter()
            self.after(self.dt_s)
            if self._held > 0:
                self._held -= 1
                if self._held == 0:
                    self._use(self.ladder[0])
            return True
        self._count_failure()
        rung = self._climb()
        if rung is not None and self.ladder[rung].substeps == 1:
            # What stopped this step often stops the next ones: each failure would restart Houbolt.
            self._held = HELD_STEPS
            return True
        self._held = 0
        self._use(self.ladder[0])
        # Houbolt keeps what a failed step left behind: a retry without this is silently wrong.
        ops.integrator(*self.integrator)
        self.before(self.dt_s)
        return rung is not None

    def _climb(self) -> int | None:
        """Take the step by the ladder; return the rung that ended it."""
        finest = self.ladder[-1].substeps
        left = finest  # of the step, in parts of the finest rung
        for rung, attempt in enumerate(self.ladder[1:], start=1):
            part = finest // attempt.substeps
            self._use(attempt)
            ops.integrator(*self.integrator)
            left -= part * self._take(left // part, self.dt_s / attempt.substeps)
            if attempt.substeps > 1 or left == 0:
                self.effort.highest_rung = max(self.effort.highest_rung, rung)
            if left == 0:
                return rung
        return None

    def _use(self, attempt: Attempt) -> None:
        self.loosen(attempt.loosening)
        ops.algorithm(*attempt.algorithm)

    def _take(self, count: int, size_s: float) -> int:
        """Take equal steps until one fails; return how many were taken."""
        self.before(size_s)
        for taken in range(count):
            if ops.analyze(1, size_s) != 0:
                self._count_failure()
                return taken
            self.effort.iterations += ops.testIter()
            self.effort.substeps += size_s < self.dt_s
            self.after(size_s)
        return count

    def _count_failure(self) -> None:
        self.effort.failed_attempts += 1
        self.effort.iterations += self.max_iterations
