"""Recovery steps: the sequence of solution strategies for a step that does not converge."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from skewbridge.analysis.settings import OpenSeesCommand

# ASSUME a (sub-)step without a solution after 15 iterations needs the next recovery step
MAX_ITERATIONS: Final = 15


@dataclass(frozen=True, slots=True, kw_only=True)
class RecoveryStep:
    """One solution strategy for a step; the first one is used for all steps that need no other."""

    algorithm: OpenSeesCommand  # arguments of the algorithm command
    #: number of equal sub-steps; a multiple of the number in the previous recovery step, so that a
    #: recovery step can continue where the previous one stopped
    substeps: int = 1
    #: tolerance of a looser convergence test, or 0 for the tolerance of the settings
    tolerance_j: float = 0.0
    max_iterations: int = MAX_ITERATIONS  #: iterations after which it fails

    @property
    def description(self) -> str:
        """Algorithm, sub-steps and looser tolerance, for tables."""
        words = [str(self.algorithm[0])]
        if self.substeps > 1:
            words.append(f"{self.substeps} sub-steps")
        if self.tolerance_j:
            words.append(f"test {self.tolerance_j:g} J")
        return ", ".join(words)


# The force of a shear key jumps when the key breaks: no displacement of its node is in equilibrium,
# however small the step, and the iteration alternates across the jump. This tolerance accepts the
# step and changes no demand; 100 J would change a drift by 4 %.
LOOSE_J: Final = 0.1

# The line search needs the fewest iterations; KrylovNewton solves most stick-slip cycles
# that the line search does not solve.
RECOVERY_STEPS: Final = (
    RecoveryStep(algorithm=("NewtonLineSearch",)),
    RecoveryStep(algorithm=("KrylovNewton",)),
    RecoveryStep(algorithm=("NewtonLineSearch",), tolerance_j=LOOSE_J),
    RecoveryStep(algorithm=("KrylovNewton",), substeps=4),
    RecoveryStep(algorithm=("NewtonLineSearch",), substeps=4, tolerance_j=LOOSE_J),
    RecoveryStep(algorithm=("NewtonLineSearch",), substeps=20, tolerance_j=LOOSE_J),
    RecoveryStep(algorithm=("Broyden", 20), substeps=100, tolerance_j=LOOSE_J),
)
# Far from contact the columns change slowly, so the tangent of an earlier step is used. It is
# renewed after a step that took two iterations. The looser test changes no demand.
REUSE: Final = RecoveryStep(
    algorithm=("ModifiedNewton", "-factoronce"), tolerance_j=0.1, max_iterations=6
)


@dataclass(slots=True, kw_only=True)
class Effort:
    """Cost of the steps so far; iterations include those of failures."""

    iterations: int = 0
    failures: int = 0  # how often a recovery step did not converge
    substeps: int = 0  # steps shorter than the regular one
    #: number of (sub-)steps by the recovery step in which they converged
    steps_by_rung: Counter[int] = field(default_factory=Counter[int])

    @property
    def highest_rung(self) -> int:
        """Largest index in `RECOVERY_STEPS` that a converged (sub-)step needed; 0 without steps."""
        return max(self.steps_by_rung, default=0)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of (sub-)steps that converged in each recovery step."""
        return tuple(self.steps_by_rung[number] for number in range(len(RECOVERY_STEPS)))


def steps_as_text(steps_by_rung: Iterable[int]) -> str:
    """Return the text of column ``steps_by_rung``: (sub-)steps of each recovery step from 0."""
    return " ".join(map(str, steps_by_rung))


def steps_from_text(text: str) -> list[int]:
    """Return the numbers in the text of column ``steps_by_rung``; empty if the text is empty."""
    return [int(steps) for steps in text.split()]


def loosened_share(text: str) -> float:
    """Return the share of (sub-)steps with a looser test, from a text of ``steps_by_rung``."""
    counts = steps_from_text(text)
    loose = [n for step, n in zip(RECOVERY_STEPS, counts, strict=False) if step.tolerance_j]
    return sum(loose) / max(sum(counts), 1)


def recovery_shares(steps_by_rung: Iterable[Sequence[int]]) -> list[dict[str, Any]]:
    """Return numbers and shares of steps and analyses, one row per recovery step.

    ``steps_by_rung`` has the (sub-)steps of each analysis in each recovery step. ``analyses``
    counts those that needed this recovery step but no higher one.
    """
    analyses = list(steps_by_rung)
    highest = [max((n for n, steps in enumerate(row) if steps), default=0) for row in analyses]
    totals = [sum(row[n] for row in analyses if n < len(row)) for n in range(len(RECOVERY_STEPS))]
    return [
        {
            "rung": number,
            "attempt": step.description,
            "steps": totals[number],
            "steps_share": totals[number] / max(sum(totals), 1),
            "analyses": highest.count(number),
            "analyses_share": highest.count(number) / max(len(analyses), 1),
        }
        for number, step in enumerate(RECOVERY_STEPS)
    ]
