"""Means of several cells under the same motions: their average, its interval, how they differ.

The motion is the random unit, the cells are fixed. With every motion in every cell the average and
its error are those of the mixed model with a random motion; the test of the differences is its F
test with the error cell x motion, corrected for unequal scatter of the differences.

References:
    Huynh and Feldt (1976), J. Educ. Stat. 1(1):69-82, and Lecoutre (1991), 16(4):371-372, for the
    correction; Efron and Morris (1975), J. Am. Stat. Assoc. 70:311-319, for the shrinking.
"""

from dataclasses import dataclass
from math import nan, sqrt

import numpy as np
from scipy import special

from skewbridge.fragility.old_likelihood.links import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class TTest:
    """An estimate with Student's error.

    Attributes:
        value: The estimate.
        error: Its standard error.
        dof: Degrees of freedom, motions - 1.
    """

    value: float
    error: float
    dof: int

    def interval(self, level: float) -> tuple[float, float]:
        """Return the two-sided interval; NaN without two degrees of freedom."""
        if self.dof < 2 or np.isnan(self.error):
            return nan, nan
        reach = float(special.stdtrit(self.dof, 0.5 + 0.5 * level)) * self.error
        return self.value - reach, self.value + reach


@dataclass(frozen=True, slots=True, kw_only=True)
class FTest:
    """A test of cells being alike.

    Attributes:
        f: Mean square of the cells over that of cell x motion.
        dof: Degrees of freedom of the cells, corrected.
        dof_error: Of cell x motion, corrected.
        p_value: Probability of a larger f where all cells are alike.
    """

    f: float = nan
    dof: float = nan
    dof_error: float = nan
    p_value: float = nan


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionMeans:
    """The means of C cells over motions.

    Attributes:
        means: Shape (C,).
        contributions: What each motion adds to the error of each mean, shape (M, C); the sum of
            squares times M/(M - 1) is its variance.
        motions: Motions behind the degrees of freedom: those with an exact value.
    """

    means: FloatArray
    contributions: FloatArray
    motions: int

    @classmethod
    def of(cls, values: FloatArray) -> "MotionMeans":
        """Return the means of a full table of values, shape (M, C)."""
        means = values.mean(axis=0)
        return cls(means=means, contributions=(values - means) / len(values), motions=len(values))

    def average(self) -> TTest:
        """Return the average of the cells; its error is the scatter over motions."""
        if not self.means.size:
            return TTest(value=nan, error=nan, dof=0)
        whole = self.contributions.mean(axis=1)
        factor = self.motions / max(self.motions - 1, 1)
        return TTest(
            value=float(self.means.mean()),
            error=sqrt(float(whole @ whole) * factor),
            dof=self.motions - 1,
        )

    def difference(self) -> FTest:
        """Return the test of the means of all cells being equal."""
        cells, motions = self.means.size, self.motions
        if cells < 2 or motions < 3:
            return FTest()
        within = self.contributions - self.contributions.mean(axis=1, keepdims=True)
        # trace and square of the covariance of the cells are those of the smaller product
        small = within if cells <= motions else within.T
        product = small.T @ small * (motions / (motions - 1))
        between = float(np.sum((self.means - self.means.mean()) ** 2))
        trace = float(np.trace(product))
        if trace <= 1e-24:
            return FTest()
        f = between / trace
        rank = cells - 1
        box = trace**2 / (rank * float(np.sum(product**2)))
        rest = rank * (motions - 1 - rank * box)
        epsilon = (motions * rank * box - 2.0) / rest if rest > 0.0 else box
        epsilon = min(1.0, max(epsilon, box))
        dof, dof_error = epsilon * rank, epsilon * rank * (motions - 1)
        return FTest(
            f=f, dof=dof, dof_error=dof_error, p_value=float(special.fdtrc(dof, dof_error, f))
        )

    def shrunk(self) -> FloatArray:
        """Return the means drawn towards their average as far as they differ by chance alone.

        Empirical Bayes: what stays of a difference is 1 - 1/F, nothing where F is below 1.
        """
        average, f = self.means.mean() if self.means.size else nan, self.difference().f
        kept = 1.0 if np.isnan(f) else max(0.0, 1.0 - 1.0 / f) if f > 0.0 else 0.0
        return average + kept * (self.means - average)
