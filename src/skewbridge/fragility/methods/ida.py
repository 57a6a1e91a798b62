"""Fragility from capacities: one intensity per motion at which the limit state is first reached.

Complete samples, samples censored on the right (the analysis stopped before the limit state) and
samples known only to lie in a bracket (any searched or gridded incremental analysis) share the
likelihood of `skewbridge.fragility.old_likelihood.censored`.
"""

from dataclasses import replace
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.censored import CensoredKernel
from skewbridge.fragility.old_likelihood.fit import (
    FITTED,
    FLATTEST_SLOPE,
    FragilityFit,
    common_warnings,
    estimated,
)
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.newton import maximise
from skewbridge.fragility.old_likelihood.parts import (
    ExactIntervals,
    MedianBound,
    Predictor,
    RunCounts,
    Separation,
)
from skewbridge.fragility.old_likelihood.profile import chi_square_quantile, profile_ends
from skewbridge.fragility.old_likelihood.validate import as_column, positive, require, same_length
from skewbridge.fragility.settings import DEFAULTS, FitSettings

ALL_CENSORED: Final = "all_censored"


def fit_capacities(
    capacity: ArrayLike,
    censored: ArrayLike | None = None,
    settings: FitSettings = DEFAULTS,
) -> FragilityFit:
    """Fit a lognormal distribution to capacities, some of them censored on the right.

    l = sum over observed [ln phi(z) - ln beta] + sum over censored ln Phi(-z),
    z = ln(IM/theta)/beta; the level of censoring is each record's own.

    Args:
        capacity: Intensity at which the limit state is reached, or the last one tried.
        censored: 1 where it was not reached there; None means none.
        settings: Level of the intervals and dispersion assumed for the bound of theta when every
            record is censored.

    Returns:
        The fit. ``beta`` is the maximum-likelihood value, consistent with its covariance; for a
        complete sample its ``exact`` part holds the unbiased dispersion and the exact t and
        chi-square intervals.

    Raises:
        InputError: A value is missing or not positive; names the row.

    References:
        Vamvatsikos and Cornell (2002), EESD 31(3):491-514; Baker (2015), Eqs. 2 and 3.
    """
    values = positive(capacity, "capacity")
    flags = np.zeros(values.size) if censored is None else as_column(censored, "censored")
    same_length(capacity=values, censored=flags)
    require((flags == 0.0) | (flags == 1.0), "censored", "must be 0 or 1", flags)
    is_censored = flags == 1.0
    y = np.log(values)
    seen = y[~is_censored]
    blank = FragilityFit(method="ida", status=FITTED, n_runs=y.size, level=settings.confidence)
    if seen.size == 0:
        return replace(blank, status=ALL_CENSORED, bound=_bound(y, "lower", settings))
    if np.ptp(seen) == 0.0 and seen.size == y.size:
        # Equal capacities usually mean a grid too coarse: they are brackets, not values.
        return replace(blank, status="zero_dispersion", theta=float(np.exp(seen[0])), beta=0.0)
    if np.ptp(seen) == 0.0 and np.all(y[is_censored] <= seen[0]):
        return replace(blank, status="unbounded_likelihood")
    blank = replace(
        blank,
        exact=None if np.any(is_censored) else _exact_intervals(y, settings.confidence),
        counts=RunCounts(n_censored=int(np.sum(is_censored))),
    )
    return _fit(blank, y, np.where(is_censored, np.inf, y), values)


def fit_brackets(
    lower: ArrayLike,
    upper: ArrayLike,
    settings: FitSettings = DEFAULTS,
) -> FragilityFit:
    """Fit a lognormal distribution to capacities known to lie in (lower, upper].

    l = sum ln[Phi(z_upper) - Phi(z_lower)]. The right likelihood for stripes on which the same
    motions run at every level, and for any grid or search wider than 2 % of theta.

    Args:
        lower: Largest intensity below the first exceedance; 0 if the first level exceeds already.
        upper: Intensity of the first exceedance; infinity, NaN or None if never reached.
        settings: Level of the intervals and dispersion assumed for one-sided bounds.

    Raises:
        InputError: ``lower`` is missing or negative, or not below ``upper``; names the row.

    References:
        Turnbull (1976), JRSS B 38(3):290-295, for interval censoring; the lognormal form is the
        likelihood of R's ``fitdistrplus::fitdistcens``.
    """
    low, high = as_column(lower, "lower"), as_column(upper, "upper")
    same_length(lower=low, upper=high)
    high = np.where(np.isnan(high), np.inf, high)
    require(np.isfinite(low) & (low >= 0.0), "lower", "must be >= 0 and finite", low)
    require(high > low, "upper", "must be above lower", high)
    with np.errstate(divide="ignore"):
        y_low, y_high = np.log(low), np.log(high)
    first, last = float(np.max(y_low)), float(np.min(y_high))
    blank = FragilityFit(
        method="ida_interval", status=FITTED, n_runs=int(low.size), level=settings.confidence
    )
    if not np.any(np.isfinite(y_high)):
        return replace(blank, status=ALL_CENSORED, bound=_bound(y_low, "lower", settings))
    if not np.any(np.isfinite(y_low)):
        return replace(blank, status=existence.ALL_EXCEED, bound=_bound(y_high, "upper", settings))
    if first <= last:
        complete = first < last
        return replace(
            blank,
            status=existence.COMPLETE_SEPARATION if complete else existence.QUASI_SEPARATION,
            separation=Separation(theta_interval=(float(np.exp(first)), float(np.exp(last)))),
        )
    finite = np.isfinite(y_low) & np.isfinite(y_high)
    if not np.any(finite) and np.max(y_high[np.isfinite(y_high)]) <= np.min(
        y_low[np.isfinite(y_low)]
    ):
        return replace(blank, status=existence.NON_INCREASING)
    im = np.concatenate([low[low > 0.0], high[np.isfinite(high)]])
    counts = RunCounts(n_censored=int(np.sum(~finite)))
    return _fit(replace(blank, counts=counts), y_low, y_high, im)


def _bound(
    ln_im: FloatArray, side: Literal["lower", "upper"], settings: FitSettings
) -> MedianBound:
    """Return the bound of the median of records that never (or always) exceed."""
    beta = settings.assumed_beta
    bound = existence.median_bound(
        ln_im, np.ones(ln_im.size), beta=beta, level=settings.confidence, exceed=side == "upper"
    )
    return MedianBound(side=side, level=settings.confidence, theta_given_beta={beta: bound})


def brackets_of_runs(
    im: FloatArray, exceed: FloatArray, record: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, int]:
    """Return per record the bracket of the first exceedance over its levels.

    A later level that does not exceed again (resurrection) does not move the bracket; the number
    of such records is returned.

    All arrays have shape (J,): intensity, 0 or 1, and integer code of the motion of each run.

    Returns:
        Lower ends, upper ends (0 and infinity where open), count of non-monotone records.
    """
    lower, upper, odd = [], [], 0
    for code in np.unique(record):
        # ASSUME the first crossing is the capacity
        rows = record == code
        levels, hit = im[rows], exceed[rows] > 0.0
        first = float(np.min(levels[hit])) if np.any(hit) else np.inf
        below = levels[~hit & (levels < first)]
        odd += int(np.any(~hit & (levels > first)))
        lower.append(float(np.max(below)) if below.size else 0.0)
        upper.append(first)
    return np.array(lower), np.array(upper), odd


def _fit(blank: FragilityFit, lower: FloatArray, upper: FloatArray, im: FloatArray) -> FragilityFit:
    """Maximise over (a0, a1), z = a0 + a1 ln x, and fill in the blank fit."""
    kernel = CensoredKernel(-np.ones((lower.size, 1)), lower, upper)
    guess = np.where(np.isfinite(upper), upper, lower)
    spread = max(float(np.std(guess)), 0.05)
    best = maximise(kernel, np.array([[-float(np.mean(guess)) / spread, 1.0 / spread]]))
    a0, a1 = (float(value) for value in best.params[0])
    bracketed = bool(np.any(np.isfinite(lower) & np.isfinite(upper)))
    if a1 <= FLATTEST_SLOPE and not bracketed:
        return replace(blank, status=existence.NON_INCREASING)
    if not bool(best.converged[0]):
        return replace(blank, status=existence.NOT_CONVERGED)
    flat = None
    if not bracketed:
        share = float(np.mean(np.isfinite(upper)))
        flat = float(special.ndtri(share))
    ends = profile_ends(kernel, best, chi_square_quantile(blank.level), flat)
    fit = estimated(blank, best.params[0], best.covariance[0], ends)
    return replace(
        fit,
        loglik=float(best.loglik[0]),
        warnings=tuple(common_warnings(fit.theta, fit.ci_theta, im, fit.n_runs)),
        predictor=Predictor(a0=a0, a1=a1, mu=-a0 / a1),
    )


def _exact_intervals(y: FloatArray, level: float) -> ExactIntervals:
    """Return the unbiased dispersion of a complete sample with t and chi-square intervals."""
    n = y.size
    sd = float(np.std(y, ddof=1))
    tail = 0.5 * (1.0 - level)
    reach = float(special.stdtrit(n - 1, 1.0 - tail)) * sd / np.sqrt(n)
    mean = float(np.mean(y))
    low, high = (
        float(sd * np.sqrt((n - 1) / special.chdtri(n - 1, share))) for share in (tail, 1.0 - tail)
    )
    return ExactIntervals(
        beta_unbiased_n_minus_1=sd,
        ci_theta_exact=(float(np.exp(mean - reach)), float(np.exp(mean + reach))),
        ci_beta_exact=(low, high),
    )
