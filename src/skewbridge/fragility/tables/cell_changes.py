"""Changes of one demand from one value of an axis to another, in cells: pairs of variants."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan, sqrt
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skewbridge.demands.demand_columns import Difference
from skewbridge.fragility.old_likelihood.censored_means import motion_contributions
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.motion_means import MotionMeans, TTest
from skewbridge.fragility.tables.paired_runs import PairFacts


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """The changes of one demand in some pairs of runs, as ln ratio or as difference.

    Attributes:
        values: Change, or its bound; only where ``used``.
        side: 0 exact, 1 at least, -1 at most so large.
        used: Pairs that say something.
        discordant: Pairs left out in which one side alone has nothing to compare.
        reference: Demand at from_value.
    """

    values: FloatArray
    side: NDArray[np.int_]
    used: NDArray[np.bool_]
    discordant: NDArray[np.bool_]
    reference: FloatArray

    @classmethod
    def of(
        cls, top: FloatArray, bottom: FloatArray, facts: PairFacts, difference: Difference | None
    ) -> Self:
        """Return the changes of a demand in some pairs.

        Args:
            top: Demand at to_value.
            bottom: Demand at from_value.
            facts: What became of the runs.
            difference: Unit of the difference; None for the logarithm of the ratio.
        """
        side = facts.side
        if difference is None:
            there = [np.isfinite(values) & (values > 0.0) for values in (top, bottom)]
        else:
            there = [np.isfinite(values) for values in (top, bottom)]
        used = (side != 2) & there[0] & there[1]
        values = np.full(top.size, nan)
        if difference is None:
            values[used] = np.log(top[used] / bottom[used])
        else:
            values[used] = (top[used] - bottom[used]) * difference.per_unit
        return cls(
            values=values,
            side=side,
            used=used,
            discordant=there[0] != there[1],
            reference=bottom,
        )

    def counts(self, facts: PairFacts) -> dict[str, Any]:
        """Return how large the reference is, and the counts of the pairs."""
        exact = self.used & (self.side == 0) & (self.reference > 0.0)
        logs = np.log(self.reference[exact])
        return {
            "from_mean": float(np.exp(logs.mean())) if logs.size else nan,
            "n_motions": int(np.unique(facts.motions[self.used]).size),
            "n_bounds": int(np.sum(self.used & (self.side != 0))),
            "n_discordant": int(np.sum(self.discordant)),
            **facts.counts(self.used),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class CellMeans:
    """The mean changes of all cells on one scale.

    Attributes:
        tests: Estimate of each cell; NaN where fewer than three motions have an exact change.
        joint: The cells that have an estimate, together.
        shrunk: Estimate of each cell drawn towards their average; NaN where it has none.
    """

    tests: tuple[TTest, ...]
    joint: MotionMeans
    shrunk: FloatArray

    @classmethod
    def of(cls, cells: Sequence[Changes], motions: Sequence[NDArray[np.int_]], count: int) -> Self:
        """Estimate the means.

        Args:
            cells: Changes of each cell.
            motions: Number of the motion of each pair, by cell.
            count: Motions of the study.
        """
        found = [_estimate(cell, own, count) for cell, own in zip(cells, motions, strict=True)]
        tests = tuple(test for test, _, _ in found)
        good = [i for i, test in enumerate(tests) if np.isfinite(test.value)]
        exact = set[int]().union(*(own for _, _, own in found))
        joint = MotionMeans(
            means=np.array([tests[i].value for i in good]),
            contributions=np.array([found[i][1] for i in good]).reshape(len(good), count).T,
            motions=len(exact),
        )
        shrunk = np.full(len(cells), nan)
        shrunk[good] = joint.shrunk()
        return cls(tests=tests, joint=joint, shrunk=shrunk)


def _estimate(
    cell: Changes, motions: NDArray[np.int_], count: int
) -> tuple[TTest, FloatArray, set[int]]:
    """Return estimate, contributions of the motions, and the motions with an exact change."""
    used = cell.used
    mean, each = motion_contributions(cell.values[used], cell.side[used], motions[used], count)
    exact = {int(motion) for motion in motions[used & (cell.side == 0)]}
    n = np.unique(motions[used]).size
    error = sqrt(float(each @ each) * n / max(n - 1, 1)) if np.isfinite(mean) else nan
    return TTest(value=mean, error=error, dof=len(exact) - 1), each, exact
