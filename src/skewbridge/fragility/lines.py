"""Regression lines of ln demand on ln intensity, and tests of their assumptions.

Sources: Cornell et al. (2002), J. Struct. Eng. 128(4):526-533; studentised test of Breusch and
Pagan, Koenker (1981), J. Econometrics 17(1):107-112; normality, Lilliefors (1967), JASA
62(318):399-402.
"""

from dataclasses import dataclass
from math import nan
from typing import Final, NamedTuple

import numpy as np
from scipy import special

from skewbridge.files.tables import Floats, Mask
from skewbridge.fragility.likelihood import NormalKernel, maximise

#: Smallest slope 1/beta of a curve: with beta above 50 it is flat over any range of intensities.
FLATTEST_SLOPE: Final = 0.02
TEST_LEVEL: Final = 0.05


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines ln D = ln a + b ln x + e, one per set of run weights; arrays of shape (R,)."""

    ln_a: Floats
    b: Floats  # NaN if no line can be fitted or the slope is not positive
    sigma: Floats  # standard deviation of e

    def ln_theta(self, threshold: float) -> Floats:
        """Return ln of the intensity at which each line reaches a threshold, shape (R,)."""
        return (np.log(threshold) - self.ln_a) / self.b

    def beta(self, capacity_dispersion: float = 0.0) -> Floats:
        """Return the dispersion of ln intensity, including capacity dispersion, shape (R,)."""
        return np.hypot(self.sigma, capacity_dispersion) / self.b


def fit_lines(x: Floats, lower: Floats, upper: Floats, weights: Floats) -> Lines:
    """Fit one line per set of weights: least squares, or Tobit if some demands are censored.

    ``x`` (n,) is ln intensity. ``lower`` and ``upper`` (n,) are the ln bounds of each demand: equal
    if it is known, infinite on the side on which it is censored. ``weights`` (R, n) states how
    often each run counts. A line is NaN if fewer than three demands are known, if the known demands
    are at a single intensity, or if its slope is not positive.
    """
    is_known, x_known = lower == upper, x[lower == upper]
    if x_known.size < 3 or (x_known.size < x.size and np.ptp(x_known) == 0.0):
        return Lines(*np.full((3, weights.shape[0]), np.nan))
    if np.all(is_known):
        centre_x, centre_y = float(np.mean(x)), float(np.mean(lower))
        u, v = x - centre_x, lower - centre_y
        terms = np.column_stack([np.ones_like(u), u, v, u * u, u * v, v * v])
        total, su, sv, suu, suv, svv = (weights @ terms).T
        with np.errstate(divide="ignore", invalid="ignore"):
            mean_u, mean_v = su / total, sv / total
            sxx, sxy = suu - total * mean_u**2, suv - total * mean_u * mean_v
            syy = svv - total * mean_v**2
            b = np.where((sxx > 1e-9) & (sxy > 0.0), sxy / sxx, np.nan)
            sigma = np.sqrt(np.maximum(syy - b * sxy, 0.0) / np.maximum(total - 2.0, 1.0))
        return Lines(mean_v + centre_y - b * (mean_u + centre_x), b, sigma)
    design, start = np.column_stack([np.ones(x.size), x]), tobit_start(x, lower, is_known)
    if weights.shape[0] > 1:  # the line through all runs is close to the line of each replicate
        start = maximise(NormalKernel(design, lower, upper), start, covariance=False).params
    kernel = NormalKernel(design, lower, upper, weights)
    best = maximise(kernel, np.tile(start, (weights.shape[0], 1)), covariance=False)
    a0, a1, h = best.params.T
    is_valid = best.converged & (a1 > FLATTEST_SLOPE)
    with np.errstate(divide="ignore", invalid="ignore"):
        return Lines(*(np.where(is_valid, values, np.nan) for values in (a0 / h, a1 / h, 1.0 / h)))


def tobit_start(x: Floats, y: Floats, is_known: Mask) -> Floats:
    """Return start values (delta_0, delta_1, h) from the line through the known demands, (1, 3)."""
    slope, intercept = np.polyfit(x[is_known], y[is_known], 1)
    h = 1.0 / max(float(np.std(y[is_known] - intercept - slope * x[is_known])), 1e-3)
    return np.array([[h * intercept, h * slope, h]])


class TestedLine(NamedTuple):
    """Least-squares line ln D = ln_a + b ln x + e with the tests of its assumptions."""

    ln_a: float
    b: float
    sigma: float  # standard deviation of e, n - 2 in the denominator
    n: int
    mean_x: float  # mean of ln x
    sxx: float  # sum of squares of ln x about its mean
    r2: float
    curvature: float  # coefficient of an additional term (ln x - mean)^2
    curvature_p: float  # p-value of the F test of this term (exact, one degree of freedom)
    scatter_p: float  # p-value of the studentised Breusch-Pagan test of constant scatter

    @property
    def warnings(self) -> list[str]:
        """Warnings about curvature and changing scatter that are significant at `TEST_LEVEL`."""
        names: list[str] = []
        if self.curvature_p < TEST_LEVEL:
            names.append("saturating" if self.curvature < 0.0 else "curved")
        if self.scatter_p < TEST_LEVEL:
            names.append("heteroscedastic")
        return names


def tested_line(x: Floats, y: Floats) -> TestedLine:
    """Fit and test the least-squares line of y = ln demand (n,) on x = ln intensity (n,)."""
    n, mean_x, mean_y = x.size, float(np.mean(x)), float(np.mean(y))
    u, v = x - mean_x, y - mean_y
    sxx, syy = float(u @ u), float(v @ v)
    b = float(u @ v) / sxx
    residual = v - b * u
    sse = float(residual @ residual)
    sigma = float(np.sqrt(sse / (n - 2))) if n > 2 else nan
    r2 = 1.0 - sse / syy if syy > 0.0 else nan
    centred = residual**2 - np.mean(residual**2)  # studentised Breusch-Pagan test
    total = sxx * float(centred @ centred)
    scatter_p = float(special.chdtrc(1, n * float(u @ centred) ** 2 / total)) if total else nan
    curvature = curvature_p = nan  # coefficient and p-value of an additional term in u^2
    u2_residual = u**2 - np.mean(u**2)
    u2_residual = u2_residual - (float(u2_residual @ u) / sxx) * u
    size = float(u2_residual @ u2_residual)
    if n >= 4 and size > 1e-12 * sxx**2 and sse > 0.0:
        curvature = float(u2_residual @ residual) / size
        explained = curvature**2 * size
        unexplained = max(sse - explained, 1e-300)
        curvature_p = float(special.fdtrc(1, n - 3, explained / (unexplained / (n - 3))))
    tests = curvature, curvature_p, scatter_p
    return TestedLine(mean_y - b * mean_x, b, sigma, n, mean_x, sxx, r2, *tests)


def lilliefors(values: Floats) -> tuple[float, float, float]:
    """Return the Lilliefors distance of a sample from normality, and its 5 and 10 % limits.

    Kolmogorov-Smirnov p-values are not valid if mean and deviation are estimated from the sample.
    """
    n = values.size
    p = special.ndtr(np.sort((values - np.mean(values)) / np.std(values, ddof=1)))
    steps = np.arange(n) / n
    distance = float(max(np.max(p - steps), np.max(steps + 1.0 / n - p)))
    scale = float(np.sqrt(n) - 0.01 + 0.85 / np.sqrt(n))
    return distance, 0.895 / scale, 0.819 / scale  # source: FEMA P-58, test at 5 and 10 %
