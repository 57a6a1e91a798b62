"""Intervals beside the profile: band of the curve, quantiles of bootstrap replicates."""

import numpy as np
from scipy import special

from skewbridge.fragility.old_likelihood.links import FloatArray


def normal_quantile(level: float) -> float:
    """Return the two-sided standard normal quantile, 1.96 for 0.95."""
    return float(special.ndtri(0.5 + 0.5 * level))


def curve(im: FloatArray, theta: float, beta: float) -> FloatArray:
    """Return P = Phi(ln(x/theta)/beta)."""
    return np.asarray(special.ndtr(np.log(im / theta) / beta))


def curve_band(
    im: FloatArray,
    *,
    theta: float,
    beta: float,
    covariance: FloatArray,
    level: float = 0.95,
) -> tuple[FloatArray, FloatArray]:
    """Return the pointwise band of a curve: Wald on eta = ln(x/theta)/beta, then Phi.

    Var eta = [Var ln theta + 2 eta Cov + eta^2 Var beta]/beta^2 (delta method); the band stays
    inside 0..1 because it is transformed.

    ``covariance`` is that of (ln theta, beta), ``level`` holds at each intensity (not for the
    whole curve).
    """
    eta = np.log(im / theta) / beta
    variance = covariance[0, 0] + 2.0 * eta * covariance[0, 1] + eta**2 * covariance[1, 1]
    reach = normal_quantile(level) * np.sqrt(np.maximum(variance, 0.0)) / beta
    return np.asarray(special.ndtr(eta - reach)), np.asarray(special.ndtr(eta + reach))


def percentile_interval(values: FloatArray, level: float) -> tuple[float, float]:
    """Return the percentile interval of bootstrap replicates; infinities sort to the ends."""
    tail = 0.5 * (1.0 - level)
    # "inverted_cdf" picks a replicate and never interpolates with an infinite one
    ends = np.quantile(values, [tail, 1.0 - tail], method="inverted_cdf")
    return float(ends[0]), float(ends[1])
