"""Existence of the maximum-likelihood estimate, and bounds where it does not exist.

References:
    Albert and Anderson (1984), Biometrika 71(1):1-10: separation in binary regression.
    Clopper and Pearson (1934), Biometrika 26(4):404-413: exact binomial limits.
    Firth (1993), Biometrika 80(1):27-38: penalised likelihood that always has a maximum.
"""

from typing import Final

import numpy as np
from scipy import optimize, special

from skewbridge.fragility.columns import FloatArray
from skewbridge.fragility.likelihood import mills_ratio

#: Status of a fit that has an estimate (not the status of an analysis).
FITTED: Final = "ok"
NO_EXCEEDANCE: Final = "no_exceedance"
ALL_EXCEED: Final = "all_exceed"
SINGLE_LEVEL: Final = "single_level"
COMPLETE_SEPARATION: Final = "complete_separation"
QUASI_SEPARATION: Final = "quasi_separation"
NON_INCREASING: Final = "non_increasing"
NOT_APPLICABLE: Final = "not_applicable"
NOT_CONVERGED: Final = "not_converged"
NO_RUNS: Final = "no_runs"


def binomial_status(ln_im: FloatArray, n: FloatArray, k: FloatArray) -> str:
    """Return the status of stripes with n > 0, arrays of shape (J,); k may be fractions.

    With hi0 the largest level having a non-exceedance and lo1 the smallest having an exceedance:
    hi0 < lo1 is complete separation, hi0 = lo1 quasi-separation; the mirror image is
    ``non_increasing``, as is a unique estimate with a negative slope.
    """
    if np.sum(k) <= 0.0:
        return NO_EXCEEDANCE
    if np.sum(n - k) <= 0.0:
        return ALL_EXCEED
    if np.ptp(ln_im) == 0.0:
        return SINGLE_LEVEL
    with_none, with_some = ln_im[n - k > 0.0], ln_im[k > 0.0]
    if np.max(with_none) < np.min(with_some):
        return COMPLETE_SEPARATION
    if np.max(with_none) == np.min(with_some):
        return QUASI_SEPARATION
    if np.max(with_some) <= np.min(with_none):
        return NON_INCREASING
    return FITTED


def clopper_pearson(k: FloatArray, n: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
    """Return the exact limits of a proportion; one-sided where none or all exceed."""
    tail = np.where((k <= 0.0) | (k >= n), 1.0 - level, (1.0 - level) / 2.0)
    low = np.where(k <= 0.0, 0.0, special.betaincinv(np.maximum(k, 1e-9), n - k + 1.0, tail))
    high = np.where(k >= n, 1.0, special.betaincinv(k + 1.0, np.maximum(n - k, 1e-9), 1.0 - tail))
    return low, high


def median_bound(
    ln_im: FloatArray, n: FloatArray, *, beta: float, level: float, exceed: bool
) -> float:
    """Return theta with P(data | theta, beta) = 1 - level: an upper bound where all ``exceed``."""
    sign = 1.0 if exceed else -1.0

    def excess(ln_theta: float) -> float:
        eta = sign * (ln_im - ln_theta) / beta
        return float(np.sum(n * special.log_ndtr(eta)) - np.log(1.0 - level))

    middle, reach = float(np.mean(ln_im)), float(np.ptp(ln_im)) + 40.0 * beta
    root = optimize.brentq(excess, middle - reach, middle + reach, xtol=1e-13)
    return float(np.exp(root))


def separated_bounds(
    ln_im: FloatArray, n: FloatArray, k: FloatArray, *, beta: float, level: float
) -> tuple[float, float]:
    """Return the one-sided bounds, by the likelihood ratio, of the median of separated data."""

    def loglik(ln_theta: float) -> float:
        eta = (ln_im - ln_theta) / beta
        return float(np.sum(k * special.log_ndtr(eta) + (n - k) * special.log_ndtr(-eta)))

    low, high = float(np.min(ln_im)) - 8.0 * beta, float(np.max(ln_im)) + 8.0 * beta
    best = optimize.minimize_scalar(lambda t: -loglik(t), bounds=(low, high), method="bounded")
    middle, target = float(best.x), loglik(float(best.x)) - 0.5 * float(special.ndtri(level)) ** 2
    ends = (
        optimize.brentq(lambda t: loglik(t) - target, middle, middle + side * beta, xtol=1e-12)
        for side in (-40.0, 40.0)
    )
    first, last = map(float, np.exp(list(ends)))
    return first, last


def firth(ln_im: FloatArray, n: FloatArray, k: FloatArray) -> tuple[float, float]:
    """Return (a0, a1) that maximise l + 0.5 ln|I|, with I the expected information."""
    centre, scale = float(np.mean(ln_im)), float(np.std(ln_im))
    design = np.column_stack([np.ones_like(ln_im), (ln_im - centre) / scale])

    def negative(a: FloatArray) -> float:
        eta = design @ a
        # phi^2/(Phi(eta) Phi(-eta)) by Mills ratios, which do not underflow
        weight = n * mills_ratio(eta) * mills_ratio(-eta)
        sign, log_determinant = np.linalg.slogdet(design.T @ (weight[:, None] * design))
        loglik = np.sum(k * special.log_ndtr(eta) + (n - k) * special.log_ndtr(-eta))
        return np.inf if sign <= 0 else -float(loglik) - 0.5 * float(log_determinant)

    start = np.array([0.0, 1.0])
    a0, a1 = optimize.fmin(negative, start, xtol=1e-10, ftol=1e-13, maxiter=4000, disp=False)
    return float(a0 - a1 * centre / scale), float(a1 / scale)
