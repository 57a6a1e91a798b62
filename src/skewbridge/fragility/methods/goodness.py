"""Goodness of fit: Lilliefors for capacities and residuals, bootstrap deviance for stripes.

A Kolmogorov-Smirnov p-value is wrong once parameters were fitted, and the chi-square p-value of
a deviance is wrong where expected counts are below about one: both are simulated here.

References:
    Lilliefors (1967), JASA 62(318):399-402; the critical value 0.895/(sqrt m - 0.01 + 0.85/sqrt m)
    at 5 % is that of Porter, Kennedy and Bachman (2007), Earthquake Spectra 23(2), and FEMA P-58.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from scipy import optimize, special

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import parametric_counts
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.settings import DEFAULTS

_LARGEST_SIMULATED: Final = 100
_CRITICAL: Final = {0.05: 0.895, 0.10: 0.819}  # source: FEMA P-58, Lilliefors test


@dataclass(frozen=True, slots=True, kw_only=True)
class Lilliefors:
    """Distance of a sample from the normal distribution with its own mean and deviation.

    Attributes:
        distance: Largest distance D.
        critical_05: D that 5 % of normal samples exceed.
        critical_10: D that 10 % exceed.
        p_value: Share of simulated normal samples with a larger D.
    """

    distance: float
    critical_05: float
    critical_10: float
    p_value: float


def lilliefors(
    values: FloatArray, *, simulations: int = 4000, seed: int = DEFAULTS.seed
) -> Lilliefors:
    """Test whether values (logarithms of capacities, residuals) are normal.

    Four values or more; the p-value comes from ``simulations`` normal samples.
    """
    n = values.size
    distance = float(_distance(values[None, :])[0])
    # in units of the critical value the distribution no longer depends on the size of the sample
    size = min(n, _LARGEST_SIMULATED)
    simulated = _simulated(size, simulations, seed) * (_scale(size) / _scale(n))
    scale = _scale(n)
    return Lilliefors(
        distance=distance,
        critical_05=float(_CRITICAL[0.05] / scale),
        critical_10=float(_CRITICAL[0.10] / scale),
        p_value=float((1 + np.sum(simulated >= distance)) / (simulations + 1)),
    )


def _scale(n: int) -> float:
    """Return what the distance is multiplied by for its critical values."""
    return float(np.sqrt(n) - 0.01 + 0.85 / np.sqrt(n))


@lru_cache(maxsize=256)
def _simulated(n: int, simulations: int, seed: int) -> FloatArray:
    """Return the distances of normal samples of size n."""
    return _distance(np.random.default_rng(seed).normal(size=(simulations, n)))


def _distance(samples: FloatArray) -> FloatArray:
    n = samples.shape[1]
    mean = np.mean(samples, axis=1, keepdims=True)
    spread = np.std(samples, axis=1, ddof=1, keepdims=True)
    p = special.ndtr(np.sort((samples - mean) / spread, axis=1))
    steps = np.arange(n) / n
    return np.maximum(np.max(p - steps, axis=1), np.max(steps + 1.0 / n - p, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbitStripes:
    """A probit curve fitted to stripes, to be judged by samples drawn from it.

    Attributes:
        ln_im: Logarithms of the intensities, shape (J,), increasing.
        n: Runs, shape (J,).
        params: (a0, a1) of the fit.
        replicates: Samples; those without an estimate count as fitting perfectly.
        seed: Of the samples.
    """

    ln_im: FloatArray
    n: FloatArray
    params: FloatArray
    replicates: int = 999
    seed: int = DEFAULTS.seed

    def samples(self) -> tuple[FloatArray, FloatArray]:
        """Return counts of exceedance, shape (R, J), and the log-likelihoods of their own fits."""
        design = np.column_stack([np.ones_like(self.ln_im), self.ln_im])
        p = special.ndtr(design @ self.params)
        k = parametric_counts(p, self.n, self.replicates, np.random.default_rng(self.seed))
        runs = np.broadcast_to(self.n, k.shape)
        good = existence.batch_exists(self.ln_im, runs, k)
        kernel = BinomialKernel(design, runs[good], k[good])
        start = np.tile(self.params, (int(np.sum(good)), 1))
        return k[good], maximise(kernel, start, covariance=False).loglik

    def p_value(self, statistic: float, simulated: FloatArray) -> float:
        """Return the share of samples with a statistic as large."""
        return float((1 + np.sum(simulated >= statistic)) / (self.replicates + 1))


def deviance_p_value(fitted: ProbitStripes, deviance: float) -> float:
    """Return the parametric-bootstrap p-value of the deviance of a fit."""
    k, loglik = fitted.samples()
    saturated = special.xlogy(k, k / fitted.n) + special.xlogy(fitted.n - k, 1.0 - k / fitted.n)
    return fitted.p_value(deviance, 2.0 * (np.sum(saturated, axis=1) - loglik))


def isotonic_p_value(fitted: ProbitStripes, k: FloatArray, loglik: float) -> tuple[float, float]:
    """Test a probit curve against any increasing curve (pool adjacent violators).

    ``k`` are the exceedances behind the fit, shape (J,), ``loglik`` is without binomial
    coefficients.

    Returns:
        The likelihood-ratio statistic and its parametric-bootstrap p-value.
    """
    statistic = 2.0 * (_isotonic(fitted.n, k) - loglik)
    draws, own = fitted.samples()
    free = np.array([_isotonic(fitted.n, row) for row in draws])
    return statistic, fitted.p_value(statistic, 2.0 * (free - own))


def _isotonic(n: FloatArray, k: FloatArray) -> float:
    p = optimize.isotonic_regression(k / n, weights=n).x
    return float(np.sum(special.xlogy(k, p) + special.xlogy(n - k, 1.0 - p)))
