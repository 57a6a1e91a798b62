"""Means and regression lines over motions, with jackknife intervals.

The motion is the random unit: each motion has the same weight, however many runs it has, and every
error comes from estimates without one motion (jackknife). Bounds are censored values (Tobit).

Sources: the iteration, Dempster, Laird and Rubin (1977), J. R. Stat. Soc. B 39(1):1-38; jackknife,
Efron and Stein (1981), Ann. Stat. 9(3):586-596; jackknife of groups, Kott (2001), J. Official
Statistics 17(4):521-526; interval of a ratio, Fieller (1954), J. R. Stat. Soc. B 16(2):175-185.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.files.tables import Floats, Index, Mask
from skewbridge.fragility.likelihood import mills_ratio

# ASSUME the jackknife variance from 100 groups of motions is close enough to that of all motions
_MAX_BLOCKS: Final = 200
_GROUPS: Final = 100
_ROUNDING: Final = 1e-12  # smaller changes of a logarithm are due to rounding
_MAX_LOG: Final = 700.0  # exp() of a larger value overflows a double
#: Smallest number of estimates without one motion for an interval.
MIN_VALUES: Final = 4
# ASSUME a median is within the intensities of a study if at least three motions reach it and at
# least three do not exceed it
MIN_BEYOND: Final = 3
#: Smallest number of motions with an exact value for a mean; a line needs one more.
MIN_EXACT: Final = 3
_MAX_ITERATIONS: Final = 2000
_TOLERANCE: Final = 1e-8  # largest change of a coefficient / scatter
_SINGULAR: Final = 1e-10  # determinant of the normal equations over the product of their diagonal


def exp_end(value: float) -> float:
    """Return exp(value), or infinity if it would overflow a double."""
    return inf if value >= _MAX_LOG else float(np.exp(value))


def covered_range(im: Floats, motions: Index) -> tuple[float, float]:
    """Return the smallest and largest median that is not extrapolated; low > high if none is."""
    codes = np.unique(motions, return_inverse=True)[1]
    lowest, highest = np.full((2, codes.max() + 1), [[inf], [-inf]])
    np.minimum.at(lowest, codes, im)
    np.maximum.at(highest, codes, im)
    if lowest.size < MIN_BEYOND:
        return inf, -inf
    return float(np.sort(lowest)[MIN_BEYOND - 1]), float(np.sort(highest)[-MIN_BEYOND])


def grouped(blocks: NDArray[Any]) -> Index:
    """Return numbers 0 .. B - 1 of blocks (n,); more than 200 are joined to 100 (Kott 2001)."""
    codes = np.unique(blocks, return_inverse=True)[1]
    return codes % _GROUPS if codes.max(initial=-1) >= _MAX_BLOCKS else codes


def motion_weights(motions: Index) -> Floats:
    """Return run weights 0 or 1 (1 + M, n): all runs, then all runs except those of each motion.

    See `grouped` for more than 200 motions.
    """
    codes = grouped(motions)
    return (codes != np.arange(-1, codes.max(initial=-1) + 1)[:, None]).astype(np.float64)


def jackknife_covariance(values: Floats) -> Floats:
    """Return the covariance (q, q) of q estimates from their values without each motion, (M, q)."""
    deviation = values - np.mean(values, axis=0)
    return deviation.T @ deviation * (len(values) - 1) / len(values)


def effective_number(influence: Floats) -> Floats:
    """Return how many motions of equal influence would give a variance of the same precision.

    ``influence`` has the shape (M, ...). The number is 1 / sum of squared shares in the variance.
    """
    square = influence**2
    with np.errstate(invalid="ignore"):
        return np.sum(square, axis=0) ** 2 / np.sum(square**2, axis=0)


@dataclass(frozen=True, slots=True)
class Jackknifed:
    """An estimate of shape (...), with the influence of each of M motions."""

    estimate: Floats
    #: (n - 1)/n times the change if a motion is left out, (M, ...); zero if it has no value.
    influence: Floats
    present: Mask  # motions with a value (exact or bound), shape (M,)
    exact: Mask  # motions with an exact value, shape (M,): their number gives the dof
    parameters: int  # 1 for means, 2 for lines
    #: Number of last rows of ``influence`` that are errors from priors, not from motions.
    priors: int = 0
    #: Influence on ln of the slope by which the estimate is divided, (M, ...); zero: no division.
    of_slope: Floats = field(default_factory=lambda: np.zeros(1))

    @classmethod
    def of(cls, values: Floats, present: Mask, exact: Mask, parameters: int) -> Self:
        """Return the jackknife of ``values`` (1 + M, ...): of all motions, then without each."""
        count = max(int(np.count_nonzero(present)), 1)
        influence = np.zeros_like(values[1:])
        influence[present] = (values[0] - values[1:][present]) * (count - 1) / count
        return cls(np.asarray(values[0]), influence, present, exact, parameters)

    @classmethod
    def of_replicates(cls, logs: Floats, priors: int = 0) -> Self:
        """Return the jackknife of an estimate of two parameters from all runs and R - 1 replicates.

        ``logs`` has the shape (R, ...). The last ``priors`` replicates differ from the estimate by
        one standard error from a prior; the others are without one block each. A block that does
        not change the estimate is not counted: it has no run, or there is no estimate without it.
        """
        values, last = completed(logs), len(logs) - priors
        changes = ~np.isclose(values[1:last], values[0], rtol=0.0, atol=_ROUNDING)
        counts = np.any(changes, axis=tuple(range(1, values.ndim)))
        left_out = cls.of(values[:last], counts, counts, 2)
        # `error` multiplies the sum of squares by the inverse of this share
        share = 1.0 - 1.0 / max(np.count_nonzero(counts), 2)
        of_priors = (values[last:] - values[0]) * share**0.5
        influence = np.concatenate([left_out.influence, of_priors])
        return replace(left_out, influence=influence, priors=priors)

    @classmethod
    def of_ratio(cls, logs: Floats, ln_slopes: Floats, priors: int) -> Self:
        """Return the jackknife of a shift of demand divided by the slope of demand.

        ``logs`` and ``ln_slopes`` are the R estimates, as in `of_replicates`.
        """
        shift, slope = cls.of_replicates(np.column_stack([logs, ln_slopes]), priors).columns()
        return replace(shift, of_slope=slope.influence)

    def columns(self) -> list[Self]:
        """Return each of q estimates, shape (q,), with the same motions present."""
        pairs = zip(self.estimate, self.influence.T, strict=True)
        return [replace(self, estimate=value, influence=influence) for value, influence in pairs]

    @property
    def dof(self) -> Floats:
        """Degrees of freedom of the error, shape (...); fewer if a few motions have most of it.

        For normal influences, E v^4 = 3 (E v^2)^2: three effective motions for each degree of
        freedom of Satterthwaite's (1946) variance.
        """
        # at most the number of motions with an exact value minus the number of parameters
        # ASSUME the errors from priors, which are known, do not raise the dof (conservative)
        of_motions = self.influence[: len(self.influence) - self.priors]
        full_dof = int(np.count_nonzero(self.exact)) - self.parameters
        return np.fmin(3.0 * effective_number(of_motions), full_dof)

    def _covariance(self, first: Floats, second: Floats) -> Floats:
        """Return the covariance of two estimates from their influences, shape (...)."""
        count = np.count_nonzero(self.present)
        return np.sum(first * second, axis=0) * count / max(count - 1, 1)

    @property
    def covariance(self) -> Floats:
        """Covariance (q, q) of an estimate of shape (q,)."""
        return self._covariance(self.influence[:, :, None], self.influence[:, None, :])

    @property
    def error(self) -> Floats:
        """Standard error, shape (...)."""
        return np.sqrt(self._covariance(self.influence, self.influence))

    def interval(self, level: float) -> tuple[Floats, Floats]:
        """Return both ends of Student's t interval, (...) each; NaN below 2 degrees of freedom.

        A ratio, shift / slope, has the interval of Fieller (1954): the values v for which the error
        of shift - v slope allows zero. It is infinite if the slope may be zero.
        """
        dof = self.dof
        t = special.stdtrit(np.where(dof >= 2.0, dof, nan), 0.5 + 0.5 * level)
        covariance = self._covariance(self.influence, self.of_slope)
        of_slope = self._covariance(self.of_slope, self.of_slope)
        return fieller_ends(self.estimate, t, self.error**2, covariance, of_slope)

    def exp_interval(self, level: float) -> tuple[float, float, float]:
        """Return exp of an estimate of shape () and of both ends of its interval."""
        low, high = self.interval(level)
        return exp_end(float(self.estimate)), exp_end(float(low)), exp_end(float(high))

    def p_value(self) -> Floats:
        """Return the two-sided p-value for a true value of zero, shape (...)."""
        dof = np.where(self.dof >= 2.0, self.dof, nan)
        of_shift = self.influence + self.estimate * self.of_slope
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.abs(self.estimate) / np.sqrt(self._covariance(of_shift, of_shift))
            return 2.0 * special.stdtr(dof, -t)

    def minus(self, other: Self) -> Self:
        """Return the difference to another estimate from the same motions and with its slope."""
        influence, of_slope = self.influence - other.influence, self.of_slope + other.of_slope
        change = self.estimate - other.estimate
        return replace(self, estimate=change, influence=influence, of_slope=0.5 * of_slope)

    def combined(self, weights: Floats) -> Self:
        """Return k linear combinations of an estimate of shape (p,), with ``weights`` (p, k)."""
        return replace(self, estimate=self.estimate @ weights, influence=self.influence @ weights)


def fieller_ends(
    estimate: Floats, t: Floats, variance: Floats, covariance: Floats, of_slope: Floats
) -> tuple[Floats, Floats]:
    """Return both ends of the interval of a ratio, shift / slope; infinite if unbounded.

    ``t`` is the quantile of Student's t, ``variance`` that of the ratio, ``of_slope`` the variance
    of ln slope and ``covariance`` the covariance of both.
    """
    # roots d = estimate - end of d^2 = t^2 (variance + 2 covariance d + of_slope d^2)
    square = 1.0 - t**2 * of_slope
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = t**2 * covariance / square
        reach = t * np.sqrt((t * covariance) ** 2 + square * variance) / square
    low, high = (np.where(square <= 0.0, sign * inf, centre + sign * reach) for sign in (1.0, -1.0))
    return estimate - low, estimate - high


def completed(logs: Floats) -> Floats:
    """Return estimates (R, ...) with missing ones replaced by the first, which has all runs."""
    # ASSUME a block has no influence if there is no estimate without it
    return np.where(np.isfinite(logs), logs, logs[0])


def average(cells: Sequence[Jackknifed]) -> Jackknifed:
    """Return the unweighted average over the pairs of variants (cells) that have an estimate."""
    # all cells share the motions, so the error comes from the averaged influence of each motion
    with_estimate = [cell for cell in cells if np.all(np.isfinite(cell.estimate))]
    if not with_estimate:
        return cells[0]
    exact = np.logical_or.reduce([cell.exact for cell in with_estimate])
    means = {
        name: np.mean([getattr(cell, name) for cell in with_estimate], axis=0)
        for name in ("estimate", "influence", "of_slope")
    }
    return replace(with_estimate[0], **means, present=exact, exact=exact)


def by_motion(
    values: Floats,  # values or bounds, shape (n,)
    bound: NDArray[np.int_],  # 0: exact value, 1: lower bound, -1: upper bound; shape (n,)
    motions: Index,  # number of the motion of each value
    count: int,  # number of blocks, including those without a value
    x: Floats | None = None,  # independent variable(s) of the line, shape (n,) or (n, q)
    block: Index | None = None,  # number of the block of each value, 0 .. count - 1
) -> Jackknifed:
    """Return the mean over motions, shape (), or the line on ``x``: value at x = 0 and slopes.

    The jackknife leaves out blocks: events, or motions if ``block`` is None. The estimate is NaN if
    fewer than three blocks (four for a line) have exact values, or if one of them decides a slope.
    """
    block = motions if block is None else block
    design = np.column_stack([np.ones(values.size), *([] if x is None else [x])])
    parameters = design.shape[1]
    present, exact = np.zeros((2, count), dtype=np.bool_)
    present[block] = True
    exact[block[bound == 0]] = True
    coefficients = np.full((1 + count, parameters), np.nan)
    if np.count_nonzero(exact) >= MIN_EXACT + parameters - 1:
        weights = (block != np.arange(-1, count)[:, None]) / np.bincount(motions)[motions]
        coefficients = bounded_regression(design, values, bound, weights)
    estimates = coefficients[:, 0] if x is None else coefficients
    return Jackknifed.of(estimates, present, exact, parameters)


def bounded_regression(
    design: Floats, values: Floats, bound: NDArray[np.int_], weights: Floats
) -> Floats:
    """Return the coefficients of a normal regression for each of R sets of weights, shape (R, p).

    Without bounds this is weighted least squares. A bound is replaced by its expected value for
    the current line and scatter, iteratively. The scatter has the divisor (sum of weights - p); it
    would otherwise be too small with few motions. All coefficients are NaN if the exact values do
    not determine every line. The first column of ``design`` (n, p) is one. See `by_motion` for
    ``values`` and ``bound``. The shape of ``weights`` is (R, n).
    """
    (n, p), exact = design.shape, bound == 0
    products = (design[:, :, None] * design[:, None, :]).reshape(n, p * p)
    exact_xx = (weights[:, exact] @ products[exact]).reshape(-1, p, p)
    scale = np.prod(np.diagonal(exact_xx, axis1=1, axis2=2), axis=1)
    if np.any(np.linalg.det(exact_xx) <= _SINGULAR * scale):
        return np.full((len(weights), p), np.nan)
    # subtract the mean of the exact values to avoid cancellation in squares
    centre = np.mean(values[exact]) * np.eye(1, p)[0]
    u = values - centre[0]
    inverse = np.linalg.inv((weights @ products).reshape(-1, p, p))
    limits, sign, at_bounds = u[~exact], bound[~exact], design[~exact]
    expected = np.broadcast_to(u, weights.shape).copy()
    dof = np.maximum(weights.sum(axis=1) - p, 0.5)
    # the floor keeps the scatter positive if all exact values agree
    floor = 1e-9 * (1.0 + float(np.max(np.abs(values))))
    scatter = np.maximum(np.sqrt(weights[:, exact] @ u[exact] ** 2 / exact_xx[:, 0, 0]), floor)
    coefficients = np.zeros((len(weights), p))
    for _ in range(_MAX_ITERATIONS):
        mean = coefficients @ at_bounds.T
        z = sign * (limits - mean) / scatter[:, None]
        ratio = mills_ratio(-z)
        expected[:, ~exact] = mean + sign * scatter[:, None] * ratio
        variance = np.maximum(1.0 + z * ratio - ratio**2, 0.0) * scatter[:, None] ** 2
        new_coefficients = np.einsum("rij,rj->ri", inverse, (weights * expected) @ design)
        squares = np.sum(weights * (expected - new_coefficients @ design.T) ** 2, axis=1)
        squares += np.sum(weights[:, ~exact] * variance, axis=1)
        change = np.max(np.abs((new_coefficients - coefficients) / scatter[:, None]))
        coefficients, scatter = new_coefficients, np.maximum(np.sqrt(squares / dof), floor)
        if change < _TOLERANCE:
            break
    return coefficients + centre
