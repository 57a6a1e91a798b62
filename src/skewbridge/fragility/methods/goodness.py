"""Goodness of fit: Lilliefors for capacities and residuals, bootstrap deviance for stripes.

A Kolmogorov-Smirnov p-value is wrong once parameters were fitted, and the chi-square p-value of
a deviance is wrong where expected counts are below about one: both are simulated here.

References:
    Lilliefors (1967), JASA 62(318):399-402; the critical value 0.895/(sqrt m - 0.01 + 0.85/sqrt m)
    at 5 % is that of Porter, Kennedy and Bachman (2007), Earthquake Spectra 23(2), and FEMA P-58.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import optimize, special

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import parametric_counts
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise

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


def lilliefors(values: FloatArray, *, simulations: int = 4000, seed: int = 20240501) -> Lilliefors:
    """Test whether values (logarithms of capacities, residuals) are normal.

    Args:
        values: Shape (n,), n >= 4.
        simulations: Normal samples behind the p-value.
        seed: Of the simulation.
    """
    n = values.size
    distance = float(_distance(values[None, :])[0])
    rng = np.random.default_rng(seed)
    simulated = _distance(rng.normal(size=(simulations, n)))
    scale = np.sqrt(n) - 0.01 + 0.85 / np.sqrt(n)
    return Lilliefors(
        distance=distance,
        critical_05=float(_CRITICAL[0.05] / scale),
        critical_10=float(_CRITICAL[0.10] / scale),
        p_value=float((1 + np.sum(simulated >= distance)) / (simulations + 1)),
    )


def _distance(samples: FloatArray) -> FloatArray:
    n = samples.shape[1]
    mean = np.mean(samples, axis=1, keepdims=True)
    spread = np.std(samples, axis=1, ddof=1, keepdims=True)
    p = special.ndtr(np.sort((samples - mean) / spread, axis=1))
    steps = np.arange(n) / n
    return np.maximum(np.max(p - steps, axis=1), np.max(steps + 1.0 / n - p, axis=1))


def deviance_p_value(
    ln_im: FloatArray,
    n: FloatArray,
    params: FloatArray,
    deviance: float,
    *,
    replicates: int = 999,
    seed: int = 20240501,
) -> float:
    """Return the parametric-bootstrap p-value of the deviance of a probit fit to stripes.

    Args:
        ln_im: Logarithms of the intensities, shape (J,).
        n: Runs, shape (J,).
        params: (a0, a1) of the fit.
        deviance: Its deviance.
        replicates: Samples drawn from the fitted curve; those without an estimate count as
            fitting perfectly.
        seed: Of the samples.
    """
    design = np.column_stack([np.ones_like(ln_im), ln_im])
    p = special.ndtr(design @ params)
    k = parametric_counts(p, n, replicates, np.random.default_rng(seed))
    runs = np.broadcast_to(n, k.shape)
    good = existence.batch_exists(ln_im, runs, k)
    kernel = BinomialKernel(design, runs[good], k[good])
    start = np.tile(params, (int(np.sum(good)), 1))
    best = maximise(kernel, start, covariance=False)
    simulated = 2.0 * (_saturated(runs[good], k[good]) - best.loglik)
    return float((1 + np.sum(simulated >= deviance)) / (replicates + 1))


def isotonic_p_value(
    ln_im: FloatArray,
    n: FloatArray,
    k: FloatArray,
    params: FloatArray,
    loglik: float,
    *,
    replicates: int = 299,
    seed: int = 20240501,
) -> tuple[float, float]:
    """Test a probit curve against any increasing curve (pool adjacent violators).

    Args:
        ln_im: Logarithms of the intensities, shape (J,), increasing.
        n: Runs, shape (J,).
        k: Exceedances, shape (J,).
        params: (a0, a1) of the probit fit.
        loglik: Its log-likelihood without binomial coefficients.
        replicates: Samples drawn from the fitted curve.
        seed: Of the samples.

    Returns:
        The likelihood-ratio statistic and its parametric-bootstrap p-value.
    """
    statistic = 2.0 * (_isotonic(n, k) - loglik)
    design = np.column_stack([np.ones_like(ln_im), ln_im])
    p = special.ndtr(design @ params)
    draws = parametric_counts(p, n, replicates, np.random.default_rng(seed))
    runs = np.broadcast_to(n, draws.shape)
    good = existence.batch_exists(ln_im, runs, draws)
    kernel = BinomialKernel(design, runs[good], draws[good])
    best = maximise(kernel, np.tile(params, (int(np.sum(good)), 1)), covariance=False)
    free = np.array([_isotonic(n, row) for row in draws[good]])
    simulated = 2.0 * (free - best.loglik)
    return float(statistic), float((1 + np.sum(simulated >= statistic)) / (replicates + 1))


def _isotonic(n: FloatArray, k: FloatArray) -> float:
    p = optimize.isotonic_regression(k / n, weights=n).x
    return float(np.sum(special.xlogy(k, p) + special.xlogy(n - k, 1.0 - p)))


def _saturated(n: FloatArray, k: FloatArray) -> FloatArray:
    terms = special.xlogy(k, k / n) + special.xlogy(n - k, (n - k) / n)
    return np.asarray(np.sum(terms, axis=1), dtype=np.float64)
