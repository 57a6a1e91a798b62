"""Fragility from capacities: one intensity per motion at which the limit state is first reached.

Complete samples, samples censored on the right (the analysis stopped before the limit state) and
samples known only to lie in a bracket (any searched or gridded incremental analysis) share the
likelihood of `skewbridge.fragility.likelihood.censored`.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.censored import CensoredKernel
from skewbridge.fragility.likelihood.fit import (
    DEFAULT_LEVEL,
    FLATTEST_SLOPE,
    OK,
    FragilityFit,
    common_warnings,
    exp_end,
    lognormal_covariance,
)
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.newton import maximise
from skewbridge.fragility.likelihood.profile import profile_ends
from skewbridge.fragility.likelihood.validate import as_column, positive, require, same_length

ALL_CENSORED: Final = "all_censored"


def fit_capacities(
    capacity: ArrayLike,
    censored: ArrayLike | None = None,
    *,
    level: float = DEFAULT_LEVEL,
    assumed_beta: float = 0.4,
) -> FragilityFit:
    """Fit a lognormal distribution to capacities, some of them censored on the right.

    l = sum over observed [ln phi(z) - ln beta] + sum over censored ln Phi(-z),
    z = ln(IM/theta)/beta; the level of censoring is each record's own.

    Args:
        capacity: Intensity at which the limit state is reached, or the last one tried.
        censored: 1 where it was not reached there; None means none.
        level: Confidence level of the profile intervals.
        assumed_beta: Dispersion for the bound of theta when every record is censored.

    Returns:
        The fit. ``beta`` is the maximum-likelihood value, consistent with its covariance; for a
        complete sample ``beta_unbiased_n_minus_1`` and the exact t and chi-square intervals
        stand in the details.

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
    reason, known = OK, dict[str, Any]()
    if seen.size == 0:
        reason = ALL_CENSORED
        bound = existence.median_bound(
            y, np.ones(y.size), beta=assumed_beta, level=level, exceed=False
        )
        known = {f"theta_lower{100 * level:g}_given_beta": {f"{assumed_beta:g}": bound}}
    elif np.ptp(seen) == 0.0 and seen.size == y.size:
        # Equal capacities usually mean a grid too coarse: they are brackets, not values.
        reason = "zero_dispersion"
        known = {"theta": float(np.exp(seen[0])), "beta": 0.0}
    elif np.ptp(seen) == 0.0 and np.all(y[is_censored] <= seen[0]):
        reason = "unbounded_likelihood"
    upper = np.where(is_censored, np.inf, y)
    if reason != OK:
        return _refused("ida", reason, y.size, level, known)
    details = {} if np.any(is_censored) else _exact_intervals(y, level)
    details["n_censored"] = int(np.sum(is_censored))
    return _fit("ida", y, upper, values, level, details)


def fit_brackets(
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    level: float = DEFAULT_LEVEL,
    assumed_beta: float = 0.4,
) -> FragilityFit:
    """Fit a lognormal distribution to capacities known to lie in (lower, upper].

    l = sum ln[Phi(z_upper) - Phi(z_lower)]. The right likelihood for stripes on which the same
    motions run at every level, and for any grid or search wider than 2 % of theta.

    Args:
        lower: Largest intensity below the first exceedance; 0 if the first level exceeds already.
        upper: Intensity of the first exceedance; infinity, NaN or None if never reached.
        level: Confidence level of the profile intervals.
        assumed_beta: Dispersion for one-sided bounds.

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
    n = int(low.size)
    ones = np.ones(n)
    if not np.any(np.isfinite(y_high)):
        bound = existence.median_bound(y_low, ones, beta=assumed_beta, level=level, exceed=False)
        known = {f"theta_lower{100 * level:g}_given_beta": {f"{assumed_beta:g}": bound}}
        return _refused("ida_interval", ALL_CENSORED, n, level, known)
    if not np.any(np.isfinite(y_low)):
        bound = existence.median_bound(y_high, ones, beta=assumed_beta, level=level, exceed=True)
        known = {f"theta_upper{100 * level:g}_given_beta": {f"{assumed_beta:g}": bound}}
        return _refused("ida_interval", existence.ALL_EXCEED, n, level, known)
    if first <= last:
        kind = "complete" if first < last else "quasi"
        known = {"theta_interval": [float(np.exp(first)), float(np.exp(last))]}
        return _refused("ida_interval", f"{kind}_separation", n, level, known)
    finite = np.isfinite(y_low) & np.isfinite(y_high)
    if not np.any(finite) and np.max(y_high[np.isfinite(y_high)]) <= np.min(
        y_low[np.isfinite(y_low)]
    ):
        return _refused("ida_interval", existence.NON_INCREASING, n, level, {})
    im = np.concatenate([low[low > 0.0], high[np.isfinite(high)]])
    return _fit("ida_interval", y_low, y_high, im, level, {"n_censored": int(np.sum(~finite))})


def brackets_of_runs(
    im: FloatArray, exceed: FloatArray, record: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, int]:
    """Return per record the bracket of the first exceedance over its levels.

    A later level that does not exceed again (resurrection) does not move the bracket; the number
    of such records is returned.

    Args:
        im: Intensity of each run, shape (J,).
        exceed: 0 or 1, shape (J,).
        record: Integer code of the motion of each run, shape (J,).

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


def _fit(
    method: str,
    lower: FloatArray,
    upper: FloatArray,
    im: FloatArray,
    level: float,
    details: dict[str, Any],
) -> FragilityFit:
    """Maximise over (a0, a1), z = a0 + a1 ln x."""
    kernel = CensoredKernel(-np.ones((lower.size, 1)), lower, upper)
    guess = np.where(np.isfinite(upper), upper, lower)
    spread = max(float(np.std(guess)), 0.05)
    best = maximise(kernel, np.array([[-float(np.mean(guess)) / spread, 1.0 / spread]]))
    a0, a1 = (float(value) for value in best.params[0])
    bracketed = bool(np.any(np.isfinite(lower) & np.isfinite(upper)))
    if a1 <= FLATTEST_SLOPE and not bracketed:
        return _refused(method, existence.NON_INCREASING, lower.size, level, details)
    if not bool(best.converged[0]):
        return _refused(method, "not_converged", lower.size, level, details)
    flat = None
    if not bracketed:
        share = float(np.mean(np.isfinite(upper)))
        flat = float(special.ndtri(share))
    ends = profile_ends(kernel, best, level, flat)
    theta = exp_end(-a0 / a1)
    ci_theta = (exp_end(ends.ln_theta[0]), exp_end(ends.ln_theta[1]))
    variance = lognormal_covariance(best.params[0], best.covariance[0])
    return FragilityFit(
        method=method,
        status=OK,
        theta=theta,
        beta=1.0 / a1,
        var_ln_theta=variance[0],
        cov_ln_theta_beta=variance[1],
        var_beta=variance[2],
        ci_theta=ci_theta,
        ci_beta=(1.0 / ends.slope[1], 1.0 / ends.slope[0] if ends.slope[0] > 0.0 else np.inf),
        ci_method="profile",
        level=level,
        loglik=float(best.loglik[0]),
        n_runs=int(lower.size),
        warnings=tuple(common_warnings(theta, ci_theta, im, int(lower.size))),
        details=details | {"mu": -a0 / a1, "a0": a0, "a1": a1},
    )


def _exact_intervals(y: FloatArray, level: float) -> dict[str, Any]:
    """Return the unbiased dispersion of a complete sample with t and chi-square intervals."""
    n = y.size
    sd = float(np.std(y, ddof=1))
    tail = 0.5 * (1.0 - level)
    reach = float(special.stdtrit(n - 1, 1.0 - tail)) * sd / np.sqrt(n)
    mean = float(np.mean(y))
    chi2 = special.chdtri(n - 1, np.array([tail, 1.0 - tail]))
    return {
        "beta_unbiased_n_minus_1": sd,
        "ci_theta_exact": [float(np.exp(mean - reach)), float(np.exp(mean + reach))],
        "ci_beta_exact": [float(sd * np.sqrt((n - 1) / q)) for q in chi2],
    }


def _refused(method: str, status: str, n: int, level: float, known: dict[str, Any]) -> FragilityFit:
    limit = {name: known.pop(name) for name in ("theta", "beta") if name in known}
    return FragilityFit(method=method, status=status, n_runs=n, level=level, details=known, **limit)
