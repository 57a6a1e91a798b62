"""Mean of values of which some are only known to lie above or below a bound (Tobit).

References:
    Tobin (1958), Econometrica 26(1):24-36; Dempster, Laird and Rubin (1977), J. R. Stat. Soc. B
    39(1):1-38, for the iteration.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.old_likelihood.links import FloatArray, mills_ratio

#: A motion needs company: fewer with an exact value, and the mean has no interval.
MIN_EXACT: Final = 3
_MAX_ITERATIONS: Final = 2000
_TOLERANCE: Final = 1e-8  # of the scatter


def censored_mean(values: FloatArray, bound: NDArray[np.int_], weights: FloatArray) -> FloatArray:
    """Return the mean of normal values for each of R sets of weights.

    Without bounds it is the weighted mean. With them each bound counts by its expected value,
    given the mean and the scatter that are found; the scatter has the divisor of a sample, sum of
    weights - 1, without which it is too small with few motions.

    Args:
        values: Values or bounds, shape (n,).
        bound: 0 where the value is exact, 1 where it is at least, -1 where it is at most so much.
        weights: Shape (R, n).

    Returns:
        Shape (R,).
    """
    total = weights.sum(axis=1)
    exact = bound == 0
    if np.all(exact):
        return weights @ values / total
    # sums of the exact values about their own mean, so that nothing cancels
    centre = float(np.mean(values[exact]))
    u = values - centre
    own = weights[:, exact] @ np.stack([np.ones(np.sum(exact)), u[exact], u[exact] ** 2], axis=1)
    count, known, square = own.T
    mean = known / count
    # where all exact values agree, the scatter starts from the bounds
    floor = 1e-9 * (1.0 + float(np.max(np.abs(values))))
    scatter = np.maximum(np.sqrt(np.maximum(square / count - mean**2, 0.0)), floor)
    side = bound[~exact].astype(np.float64)
    beyond, limits = weights[:, ~exact], u[None, ~exact]
    for _ in range(_MAX_ITERATIONS):
        z = side * (limits - mean[:, None]) / scatter[:, None]
        ratio = mills_ratio(-z)
        expected = mean[:, None] + side * scatter[:, None] * ratio
        left = scatter[:, None] ** 2 * np.maximum(1.0 + z * ratio - ratio**2, 0.0)
        new = (known + np.sum(beyond * expected, axis=1)) / total
        squares = np.maximum(square - new * (2.0 * known - new * count), 0.0)
        squares += np.sum(beyond * ((expected - new[:, None]) ** 2 + left), axis=1)
        step = np.max(np.abs(new - mean) / scatter)
        mean = new
        scatter = np.maximum(np.sqrt(squares / np.maximum(total - 1.0, 0.5)), floor)
        if step < _TOLERANCE:
            break
    return mean + centre


def motion_contributions(
    values: FloatArray, bound: NDArray[np.int_], motions: NDArray[np.int_], count: int
) -> tuple[float, FloatArray]:
    """Return the mean over motions, and what each motion adds to its error (jackknife).

    A motion counts once, however many values it has. Without bounds the contribution is
    (value of the motion - mean)/n, so that the sum of squares times n/(n - 1) is the variance of
    the mean; with bounds it follows from the mean without the motion.

    Args:
        values: Values or bounds, shape (n,), as in `censored_mean`.
        bound: Which of them are bounds.
        motions: Number of the motion of each value, 0 .. count - 1.
        count: How many motions there are; those without a value contribute nothing.

    Returns:
        Mean and contributions, shape (count,); NaN and zeros where fewer than three motions have an
        exact value.
    """
    found = np.zeros(count)
    if np.unique(motions[bound == 0]).size < MIN_EXACT:
        return np.nan, found
    present, own, runs = np.unique(motions, return_inverse=True, return_counts=True)
    weights = np.broadcast_to(1.0 / runs[own], (present.size + 1, own.size)).copy()
    weights[1:][np.arange(present.size)[:, None] == own[None, :]] = 0.0
    means = censored_mean(values, bound, weights)
    found[present] = (means[0] - means[1:]) * (present.size - 1) / present.size
    return float(means[0]), found
