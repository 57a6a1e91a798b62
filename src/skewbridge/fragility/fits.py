"""Lognormal fragility curves fitted to counts, capacities or a cloud of demands.

References:
    Baker (2015), Earthquake Spectra 31(1):579-599: counts of exceedance, Eq. 11.
    Vamvatsikos and Cornell (2002), EESD 31(3):491-514: capacities of incremental analyses.
    Turnbull (1976), JRSS B 38(3):290-295: interval censoring.
    Cornell, Jalayer, Hamburger and Foutch (2002), J. Struct. Eng. 128(4):526-533: cloud.
    Fieller (1954), JRSS B 16(2):175-185: interval of a ratio.
    Pregibon (1980), Applied Statistics 29(1):15-24: test of the link.
    Bell and McCaffrey (2002), Survey Methodology 28(2):169-181: jackknife by motion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import nan
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from skewbridge.fragility import existence, likelihood, motion_means
from skewbridge.fragility.columns import FloatArray, as_column, positive, require, same_length
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.lines import (
    FLATTEST_SLOPE,
    Lines,
    TestedLine,
    fit_lines,
    lilliefors,
    tested_line,
    tobit_start,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings

WIDE_CI_RATIO: Final = 3.0
FEW_RECORDS: Final = 10
FEW_MIXED_STRIPES: Final = 3
ALL_CENSORED: Final = "all_censored"
SLOPE_NOT_SIGNIFICANT: Final = "slope_not_significant"


@dataclass(frozen=True, slots=True, kw_only=True)
class FragilityFit:
    """A lognormal fragility curve P = Phi(ln(x/theta)/beta), or the reason why there is none."""

    method: str  #: Estimator, for example ``stripes`` or ``cloud_ols``.
    status: str  #: ``ok``, or why there is no estimate: then the parameters are NaN.
    theta: float = nan  #: Median, in the unit of the intensity measure.
    beta: float = nan  #: Dispersion of the logarithm.
    var_ln_theta: float = nan  #: Variance of ln theta.
    cov_ln_theta_beta: float = nan  #: Covariance of ln theta and beta.
    var_beta: float = nan  #: Variance of beta.
    ci_theta: tuple[float, float] = (nan, nan)  #: 0 and infinity are unbounded ends.
    ci_beta: tuple[float, float] = (nan, nan)
    ci_method: str = ""  #: ``profile``, ``fieller`` or ``jackknife``; empty without interval.
    level: float = DEFAULTS.confidence  #: Confidence level of the intervals.
    loglik: float = nan  #: Log-likelihood at the maximum (with binomial coefficients).
    n_runs: int = 0  #: Runs in the fit.
    warnings: tuple[str, ...] = ()  #: Names of what a reader must know.
    details: Mapping[str, Any] = field(default_factory=dict)  #: Further results by name.
    line: TestedLine | None = None  #: Least-squares line behind a cloud fit, with its tests.

    def without_estimate(self, status: str) -> "FragilityFit":
        """Return the fit with a status in place of median, dispersion and intervals."""
        kept = ("method", "level", "n_runs", "warnings", "details", "line")
        return FragilityFit(status=status, **{name: getattr(self, name) for name in kept})

    @property
    def se_ln_theta(self) -> float:
        """Standard error of ln theta."""
        return float(np.sqrt(self.var_ln_theta))

    @property
    def se_beta(self) -> float:
        """Standard error of beta."""
        return float(np.sqrt(self.var_beta))

    def as_json(self) -> dict[str, Any]:
        """Return the object that `skewbridge fit --json` prints."""
        names = "status theta beta cov_ln_theta_beta ci_theta ci_beta ci_method level loglik n_runs"
        values = {name: getattr(self, name) for name in (*names.split(), "method", "warnings")}
        values |= {**self.details, "se_ln_theta": self.se_ln_theta, "se_beta": self.se_beta}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}


def estimated(
    blank: FragilityFit,
    params: FloatArray,
    covariance: FloatArray,
    ends: FloatArray | None,
    widening: float = 1.0,
) -> FragilityFit:
    """Return a fit with the estimate of (a0, a1): ln theta = -a0/a1 and beta = widening/a1.

    Its covariance follows by the delta method; ``ends`` (2, 2) are those of ln theta and of 1/a1.
    """
    a0, a1 = params.tolist()
    jacobian = np.array([[-1.0 / a1, a0 / a1**2], [0.0, -widening / a1**2]])
    variance = (jacobian @ covariance @ jacobian.T).tolist()
    (low, high), of_beta = np.full((2, 2), nan) if ends is None else ends
    return replace(
        blank,
        theta=motion_means.exp_end(-a0 / a1),
        beta=widening / a1,
        var_ln_theta=variance[0][0],
        cov_ln_theta_beta=variance[0][1],
        var_beta=variance[1][1],
        ci_theta=(motion_means.exp_end(low), motion_means.exp_end(high)),
        ci_beta=tuple((widening * of_beta).tolist()),
        ci_method="" if ends is None else "profile",
    )


def jackknifed(fit: FragilityFit, ln_theta: FloatArray, beta: FloatArray) -> FragilityFit:
    """Replace interval and covariance by those of the jackknife, from fits without each motion."""
    good = np.isfinite(ln_theta) & np.isfinite(beta) & (beta > 0.0)
    if np.sum(good) < motion_means.MIN_VALUES:
        return replace(fit, warnings=(*fit.warnings, "too_few_motions_for_an_interval"))
    covariance = motion_means.jackknife_covariance(
        np.column_stack([ln_theta[good], np.log(beta[good])])
    )
    extra = () if np.mean(good) > 0.95 else ("jackknife_without_estimate",)
    t = float(special.stdtrit(good.size - 2, 0.5 + 0.5 * fit.level))
    of_theta, of_beta = (
        motion_means.exp_end(t * sd) for sd in np.sqrt(np.diag(covariance)).tolist()
    )
    return replace(
        fit,
        ci_theta=(fit.theta / of_theta, fit.theta * of_theta),
        ci_beta=(fit.beta / of_beta, fit.beta * of_beta),
        ci_method="jackknife",
        var_ln_theta=float(covariance[0, 0]),
        cov_ln_theta_beta=float(covariance[0, 1]) * fit.beta,
        var_beta=float(covariance[1, 1]) * fit.beta**2,
        warnings=(*fit.warnings, *extra),
    )


def common_warnings(
    theta: float, ci_theta: tuple[float, float], im: FloatArray, n_records: int
) -> list[str]:
    """Return the warnings that every method shares."""
    low, high = ci_theta
    narrow = np.isnan(low) or (low > 0.0 and high / low <= WIDE_CI_RATIO)
    found = {
        "median_extrapolated": theta > np.max(im) or theta < np.min(im),
        "wide_ci": not narrow,
        "fewer_than_10_records": n_records < FEW_RECORDS,
    }
    return [name for name, applies in found.items() if applies]


def fit_stripes(
    im: ArrayLike,
    n: ArrayLike,
    k: ArrayLike,
    *,
    settings: FitSettings = DEFAULTS,
    n_records: int | None = None,
    interval: bool = True,
) -> FragilityFit:
    """Fit a fragility curve to k of n exceedances at each intensity, by maximum likelihood.

    l(a) = sum k ln Phi(eta) + (n - k) ln Phi(-eta), eta = a0 + a1 ln x; theta = exp(-a0/a1) and
    beta = 1/a1. The existence test runs first and gives the status.

    Args:
        im: Intensities, positive, any order, shape (J,); levels may repeat.
        n: Runs at each; stripes without runs are dropped with a warning.
        k: Runs that exceed. Fractions (uncertain capacity) leave no interval.
        settings: Level of the intervals and dispersion assumed for one-sided bounds.
        n_records: Motions behind the runs, if fewer than runs.
        interval: False leaves out the profile intervals.

    Raises:
        InputError: A value is missing, not positive, or k is outside 0..n; names the row.
    """
    x, runs, exceed = positive(im, "im"), as_column(n, "n"), as_column(k, "k")
    same_length(im=x, n=runs, k=exceed)
    require(np.isfinite(runs) & (runs >= 0.0), "n", "must be >= 0 and finite", runs)
    require((exceed >= 0.0) & (exceed <= runs), "k", "must satisfy 0<=k<=n", exceed)
    kept = runs > 0.0
    x, runs, exceed = x[kept], runs[kept], exceed[kept]
    total, ln_im = round(float(np.sum(runs))), np.log(x)
    status = existence.binomial_status(ln_im, runs, exceed) if total else existence.NO_RUNS
    blank = FragilityFit(method="stripes", status=status, n_runs=total, level=settings.confidence)
    if not np.all(kept):
        blank = replace(blank, warnings=("stripes_without_runs",))
    if total == 0:
        return blank
    if status != FITTED:
        return replace(blank, details=_stripe_bounds(status, ln_im, runs, exceed, settings))
    kernel = likelihood.exceedance_kernel(ln_im, exceed, runs - exceed)
    # line through the probits of the shares, which are kept off 0 and 1
    line = np.polyfit(ln_im, special.ndtri((exceed + 0.5) / (runs + 1.0)), 1, w=np.sqrt(runs))
    whole = bool(np.all(exceed == np.round(exceed)))
    fit = _maximised(
        blank, kernel, line[::-1], x, n_records=n_records or total, interval=interval and whole
    )
    if fit.status != FITTED:
        return fit
    warnings = [*fit.warnings, *_overlap_warnings(x, runs, exceed)]
    loglik = fit.loglik
    if whole:
        ways = special.gammaln(runs + 1.0) - special.gammaln(exceed + 1.0)
        loglik += float(np.sum(ways - special.gammaln(runs - exceed + 1.0)))
    else:
        warnings.append("fractional_counts_no_interval")
    eta = fit.details["a0"] + fit.details["a1"] * ln_im
    details = {**fit.details, "loglik_kernel": fit.loglik, "aic": 4.0 - 2.0 * loglik}
    details |= _stripe_goodness(eta, ln_im, runs, exceed)
    return replace(fit, loglik=loglik, warnings=tuple(warnings), details=details)


def _maximised(
    blank: FragilityFit,
    kernel: likelihood.NormalKernel,
    start: FloatArray,
    im: FloatArray,
    *,
    n_records: int,
    interval: bool = True,
    flattest: float = FLATTEST_SLOPE,
) -> FragilityFit:
    """Complete a fit with parameters (a0, a1): estimate, profile intervals and warnings."""
    best = likelihood.maximise(kernel, start[None])
    a0, a1 = best.params[0].tolist()
    blank = replace(blank, details={**blank.details, "a0": a0, "a1": a1})
    if not best.converged[0]:
        return replace(blank, status=existence.NOT_CONVERGED)
    if a1 <= flattest:
        return replace(blank, status=existence.NON_INCREASING)
    ends = None
    if interval:
        drop = likelihood.chi_square_drop(blank.level)
        ends = likelihood.profile_ends(kernel, best, drop, np.array([[1.0, 0.0]]))
    fit = estimated(blank, best.params[0], best.covariance[0], ends)
    warnings = (*fit.warnings, *common_warnings(fit.theta, fit.ci_theta, im, n_records))
    return replace(fit, loglik=float(best.loglik[0]), warnings=warnings)


def _stripe_bounds(
    status: str, ln_im: FloatArray, n: FloatArray, k: FloatArray, settings: FitSettings
) -> dict[str, Any]:
    """Return the bounds that counts give where no estimate exists."""
    level, beta = settings.confidence, settings.assumed_beta
    low, high = existence.clopper_pearson(k, n, level)
    details: dict[str, Any] = {"p_lower": low.tolist(), "p_upper": high.tolist()}
    if status in (existence.NO_EXCEEDANCE, existence.ALL_EXCEED):
        exceed = status == existence.ALL_EXCEED
        return details | _median_bound(ln_im, n, settings, 0.3, 0.4, 0.6, exceed=exceed)
    if status == existence.SINGLE_LEVEL:
        total, hits = np.sum(n, keepdims=True), np.sum(k, keepdims=True)
        p, ends = float(hits[0] / total[0]), existence.clopper_pearson(hits, total, level)
        median = float(np.exp(ln_im[0] - beta * special.ndtri(p)))
        details |= {"p": p, "p_ci": [float(end[0]) for end in ends]}
        details["theta_given_beta"] = {f"{beta:g}": median}
    if status in (existence.COMPLETE_SEPARATION, existence.QUASI_SEPARATION):
        hi0, lo1 = float(np.max(ln_im[n - k > 0.0])), float(np.min(ln_im[k > 0.0]))
        a0, a1 = existence.firth(ln_im, n, k)
        firth = {"theta": float(np.exp(-a0 / a1)), "beta": 1.0 / a1}
        low, high = existence.separated_bounds(ln_im, n, k, beta=beta, level=level)
        details |= _bracket(hi0, lo1) | {
            "theta_midpoint_log": float(np.exp(0.5 * (hi0 + lo1))),
            "theta_bounds_given_beta": {f"{beta:g}": [low, high]},
            "firth": firth,
            **{f"{name}_firth": value for name, value in firth.items()},
            **{"theta_bound_low": low, "theta_bound_high": high, "theta_bound_beta": beta},
        }
    return details


def _bracket(low: float, high: float) -> dict[str, Any]:
    """Return the bracket of the median of separated data from its ends of ln intensity."""
    ends = [float(np.exp(low)), float(np.exp(high))]
    return {"theta_interval": ends, "theta_bracket_low": ends[0], "theta_bracket_high": ends[1]}


def _median_bound(
    ln_im: FloatArray, n: FloatArray, settings: FitSettings, *betas: float, exceed: bool
) -> dict[str, Any]:
    """Return one-sided bounds of the median where no run (or every run) exceeds, by dispersion."""
    level, assumed = settings.confidence, settings.assumed_beta
    bounds = {
        f"{beta:g}": existence.median_bound(ln_im, n, beta=beta, level=level, exceed=exceed)
        for beta in sorted({*betas, assumed})
    }
    side, end = ("upper", "high") if exceed else ("lower", "low")
    return {
        "assumed_beta": assumed,
        f"theta_{side}{100 * level:g}_given_beta": bounds,
        f"theta_bound_{end}": bounds[f"{assumed:g}"],
        "theta_bound_beta": assumed,
    }


def _overlap_warnings(x: FloatArray, n: FloatArray, k: FloatArray) -> list[str]:
    """Warn where few stripes (or single runs) show the transition from none to all."""
    levels, index = np.unique(x, return_inverse=True)
    runs, exceed = np.bincount(index, n), np.bincount(index, k)
    if np.max(runs) > 1.0:
        mixed = int(np.sum((exceed > 0.0) & (exceed < runs)))
        return ["few_mixed_stripes"] if mixed < FEW_MIXED_STRIPES else []
    first, last = np.min(levels[exceed > 0.0]), np.max(levels[exceed < runs])
    overlap = int(np.sum((levels >= first) & (levels <= last)))
    return ["small_overlap"] if overlap < 2 * FEW_MIXED_STRIPES else []


def _stripe_goodness(
    eta: FloatArray, ln_im: FloatArray, n: FloatArray, k: FloatArray
) -> dict[str, Any]:
    """Return deviance, Pearson's statistic and the score test of a curvature in the predictor."""
    log_p, log_q, remain = special.log_ndtr(eta), special.log_ndtr(-eta), n - k
    p, most = np.exp(log_p), special.xlogy(k, k / n) + special.xlogy(remain, remain / n)
    deviance = 2.0 * float(np.sum(most - k * log_p - remain * log_q))
    pearson = float(np.sum((k - n * p) ** 2 / np.maximum(n * p * np.exp(log_q), 1e-300)))
    dof = int(n.size - 2)
    up, down = likelihood.mills_ratio(eta), likelihood.mills_ratio(-eta)
    score = k * up - remain * down
    information = k * up * (eta + up) + remain * down * (down - eta)
    square = (ln_im - np.mean(ln_im)) ** 2
    design = np.column_stack([np.ones_like(ln_im), ln_im])
    weighted = design * information[:, None]
    extra = square - design @ np.linalg.solve(design.T @ weighted, weighted.T @ square)
    variance = float(information @ extra**2)
    details: dict[str, Any] = {"deviance": deviance, "deviance_dof": dof, "pearson": pearson}
    if dof > 0 and bool(np.max(n) > 1.0):
        details["deviance_p"] = float(special.chdtrc(dof, deviance))
    if variance > 1e-9:
        details["link_p"] = float(special.chdtrc(1, float(score @ extra) ** 2 / variance))
    return details


def fit_capacities(
    capacity: ArrayLike, censored: ArrayLike | None = None, settings: FitSettings = DEFAULTS
) -> FragilityFit:
    """Fit a lognormal distribution to capacities, some of them censored on the right.

    l = sum over observed [ln phi(z) - ln beta] + sum over censored ln Phi(-z),
    z = ln(IM/theta)/beta. ``beta`` is the maximum-likelihood value; the details of a complete
    sample hold the unbiased one and the exact t and chi-square intervals.

    Args:
        capacity: Intensity at which the limit state is reached, or the last one tried.
        censored: 1 where it was not reached there; None means none.
        settings: Level of the intervals and dispersion assumed for one-sided bounds.

    Raises:
        InputError: A value is missing or not positive; names the row.
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
        bound = _median_bound(y, np.ones(y.size), settings, exceed=False)
        return replace(blank, status=ALL_CENSORED, details=bound)
    if np.ptp(seen) == 0.0 and seen.size == y.size:
        # Equal capacities usually mean a grid too coarse: they are brackets, not values.
        return replace(blank, status="zero_dispersion", theta=float(np.exp(seen[0])), beta=0.0)
    if np.ptp(seen) == 0.0 and np.all(y[is_censored] <= seen[0]):
        return replace(blank, status="unbounded_likelihood")
    details: dict[str, Any] = {}
    if not np.any(is_censored):
        n, tail = y.size, 0.5 * (1.0 - settings.confidence)
        sd, mean = float(np.std(y, ddof=1)), float(np.mean(y))
        reach = float(special.stdtrit(n - 1, 1.0 - tail)) * sd / np.sqrt(n)
        chi2 = [float(special.chdtri(n - 1, share)) for share in (tail, 1.0 - tail)]
        details = {
            "beta_unbiased_n_minus_1": sd,
            "ci_theta_exact": [float(np.exp(mean - reach)), float(np.exp(mean + reach))],
            "ci_beta_exact": [sd * float(np.sqrt((n - 1) / each)) for each in chi2],
        }
        if n >= 4:
            names = ("lilliefors_d", "lilliefors_d_05", "lilliefors_d_10")
            details |= dict(zip(names, lilliefors(y), strict=True))
    blank = replace(blank, details=details)
    return _fit_distribution(blank, y, np.where(is_censored, np.inf, y), values)


def fit_brackets(
    lower: ArrayLike, upper: ArrayLike, settings: FitSettings = DEFAULTS
) -> FragilityFit:
    """Fit a lognormal distribution to capacities in brackets (lower, upper].

    l = sum ln[Phi(z_upper) - Phi(z_lower)]: for stripes on which the same motions run at every
    level, and for any grid or search wider than 2 % of theta.

    Args:
        lower: Largest intensity below the first exceedance; 0 if the first level exceeds already.
        upper: Intensity of the first exceedance; infinity, NaN or None if never reached.
        settings: Level of the intervals and dispersion assumed for one-sided bounds.

    Raises:
        InputError: ``lower`` is missing or negative, or not below ``upper``; names the row.
    """
    low, high = as_column(lower, "lower"), as_column(upper, "upper")
    same_length(lower=low, upper=high)
    high = np.where(np.isnan(high), np.inf, high)
    require(np.isfinite(low) & (low >= 0.0), "lower", "must be >= 0 and finite", low)
    require(high > low, "upper", "must be above lower", high)
    with np.errstate(divide="ignore"):
        y_low, y_high = np.log(low), np.log(high)
    level, size = settings.confidence, low.size
    blank = FragilityFit(method="ida_interval", status=FITTED, n_runs=size, level=level)
    has_low, has_high = np.isfinite(y_low), np.isfinite(y_high)
    if not (np.any(has_low) and np.any(has_high)):
        exceed = bool(np.any(has_high))
        ends, status = (y_high, existence.ALL_EXCEED) if exceed else (y_low, ALL_CENSORED)
        bound = _median_bound(ends, np.ones(low.size), settings, exceed=exceed)
        return replace(blank, status=status, details=bound)
    if (first := float(np.max(y_low))) <= (last := float(np.min(y_high))):
        status = existence.COMPLETE_SEPARATION if first < last else existence.QUASI_SEPARATION
        return replace(blank, status=status, details=_bracket(first, last))
    if not np.any(has_low & has_high) and np.max(y_high[has_high]) <= np.min(y_low[has_low]):
        return replace(blank, status=existence.NON_INCREASING)
    return _fit_distribution(blank, y_low, y_high, np.append(low[low > 0.0], high[has_high]))


def brackets_of_runs(
    im: FloatArray, exceed: FloatArray, record: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, int]:
    """Return per record the bracket of the first exceedance over its levels.

    ``im``, ``exceed`` (0 or 1) and ``record`` are intensity, outcome and number of the motion of
    each run, shape (n,). A later level that does not exceed again does not move the bracket.

    Returns:
        Lower ends, upper ends (0 and infinity where open), number of non-monotone records.
    """
    # ASSUME the first crossing is the capacity
    records, codes = np.unique(record, return_inverse=True)
    lower, upper = np.zeros(records.size), np.full(records.size, np.inf)
    hit = exceed > 0.0
    np.minimum.at(upper, codes[hit], im[hit])
    below = ~hit & (im < upper[codes])
    np.maximum.at(lower, codes[below], im[below])
    odd = np.unique(codes[~hit & (im > upper[codes])]).size
    return lower, upper, odd


def _fit_distribution(
    blank: FragilityFit, lower: FloatArray, upper: FloatArray, im: FloatArray
) -> FragilityFit:
    """Maximise over (a0, a1), z = a0 + a1 ln x, and complete the blank fit."""
    censored = ~(np.isfinite(lower) & np.isfinite(upper))
    blank = replace(blank, details={**blank.details, "n_censored": int(np.sum(censored))})
    kernel = likelihood.NormalKernel(-np.ones((lower.size, 1)), lower, upper)
    guess = np.where(np.isfinite(upper), upper, lower)
    spread = max(float(np.std(guess)), 0.05)
    start = np.array([-float(np.mean(guess)) / spread, 1.0 / spread])
    # a falling curve gives brackets no probability
    flattest = FLATTEST_SLOPE if np.all(censored) else 0.0
    fit = _maximised(blank, kernel, start, im, n_records=lower.size, flattest=flattest)
    return replace(fit, details={**fit.details, "mu": float(np.log(fit.theta))})


def fit_cloud(
    im: ArrayLike,
    edp: ArrayLike,
    threshold: float,
    upper: ArrayLike | None = None,
    *,
    capacity_dispersion: float = 0.0,
    settings: FitSettings = DEFAULTS,
    motions: NDArray[np.intp] | None = None,
) -> FragilityFit:
    """Fit a fragility curve to a cloud of demands: ln D = ln a + b ln x + e.

    theta = exp((ln c - ln a)/b) and beta = sqrt(s^2 + dispersion^2)/b. Without censored demands by
    least squares with Fieller's interval; otherwise by maximum likelihood (Tobit) with profile
    intervals in which Student's t(n - 2), n the observed demands, replaces the normal quantile:
    without censoring it is Fieller's. Where motions repeat, by the jackknife by motion.

    Args:
        im: Intensities, shape (n,), positive.
        edp: Demands in the unit of ``threshold``, or their lower ends; 0 where left-censored.
        threshold: Median capacity c.
        upper: Upper ends of the demands: equal to ``edp`` where observed, infinity where the run
            ended early, a limit where only an upper end is known. None: all observed.
        capacity_dispersion: Dispersion of the capacity.
        settings: Confidence level.
        motions: Number of the motion of each run; None: one run per motion.

    Returns:
        The fit. ``slope_not_significant``: Fieller's set is unbounded; ``saturating`` or
        ``curved``: by the curvature test; ``heteroscedastic``: by that of Breusch and Pagan.

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    values, low = positive(im, "im"), as_column(edp, "edp")
    high = low if upper is None else as_column(upper, "upper")
    same_length(im=values, edp=low, upper=high)
    observed = low == high
    usable = np.isfinite(low) & (low >= 0.0) & (high > 0.0) & ((low > 0.0) | ~observed)
    require(usable, "edp", "must be > 0 and finite", low)
    require(high >= low, "upper", "must not be below edp", high)
    limit = as_column([threshold], "threshold")
    require(np.isfinite(limit) & (limit > 0.0), "threshold", "must be > 0 and finite", limit)
    informative = (low > 0.0) | np.isfinite(high)
    with np.errstate(divide="ignore"):
        x, y_low, y_high = (np.log(each[informative]) for each in (values, low, high))
    lines, codes = None, np.arange(x.size) if motions is None else motions[informative]
    if np.unique(codes).size < x.size:
        lines = fit_lines(x, y_low, y_high, motion_means.motion_weights(codes)[1:])
    capacity = float(limit[0]), capacity_dispersion
    return fit_cloud_states(x, y_low, y_high, [capacity], settings, lines)[0]


def fit_cloud_states(
    x: FloatArray,
    low: FloatArray,
    high: FloatArray,
    capacities: Sequence[tuple[float, float]],
    settings: FitSettings,
    lines: Lines | None = None,
) -> list[FragilityFit]:
    """Fit one line to a cloud and return the curve of each state, as `fit_cloud` does.

    ``x``, ``low`` and ``high`` (n,) are ln of the intensities and of the ends of the demands,
    ``capacities`` median and dispersion of each state, ``lines`` those without each motion where
    motions repeat.
    """
    seen = low == high
    n_motions = x.size if lines is None else lines.b.size
    censored = not bool(np.all(seen))
    method, level = "cloud_tobit" if censored else "cloud_ols", settings.confidence
    blank = FragilityFit(method=method, status=FITTED, n_runs=x.size, level=level)
    if np.sum(seen) < 3 or np.ptp(x[seen]) == 0.0:
        status = "too_few_runs" if np.sum(seen) < 3 else existence.SINGLE_LEVEL
        return [replace(blank, status=status)] * len(capacities)
    line = tested_line(x[seen], low[seen])
    blank = replace(blank, line=line)
    if censored:
        fits = _fit_tobit(blank, (x, low, high), capacities, interval=lines is None)
    else:
        fits = [_fit_least_squares(blank, line, *capacity) for capacity in capacities]
    for j, (fit, (threshold, dispersion)) in enumerate(zip(fits, capacities, strict=True)):
        if fit.status != FITTED:
            continue
        if lines is not None:
            fit = jackknifed(fit, lines.ln_theta(threshold), lines.beta(dispersion))
        names = common_warnings(fit.theta, fit.ci_theta, np.exp(x), n_motions) + line.warnings
        if not np.any(low >= np.log(threshold)):
            names.append("no_exceedance_observed")
        fits[j] = replace(fit, warnings=(*fit.warnings, *names))
    return fits


def _fit_least_squares(
    blank: FragilityFit, line: TestedLine, threshold: float, dispersion: float
) -> FragilityFit:
    """Complete a cloud fit without censored demands; intervals after Fieller and delta method."""
    values = {k: v for k, v in line._asdict().items() if k not in ("n", "mean_x", "sxx")}
    details = {name: value for name, value in values.items() if not np.isnan(value)}
    n, ln_c = line.n, float(np.log(threshold))
    unfitted = replace(blank, details=details)
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * blank.level))
    if line.b <= 0.0:
        return replace(unfitted, status=existence.NON_INCREASING)
    if line.sigma <= 1e-12:
        return replace(unfitted, status="zero_dispersion")
    if line.b**2 <= t**2 * line.sigma**2 / line.sxx:
        return replace(unfitted, status=SLOPE_NOT_SIGNIFICANT)
    beta = float(np.hypot(line.sigma, dispersion)) / line.b
    ln_theta = (ln_c - line.ln_a) / line.b
    away = ln_theta - line.mean_x
    relative = line.sigma**2 / line.sxx / line.b**2  # relative variance of b
    # beta = sqrt(s^2 + c^2)/b: its derivative by s is s/(beta b^2), by b it is -beta/b
    var_s = line.sigma**2 / (2.0 * (n - 2))
    var_beta = (line.sigma / (beta * line.b**2)) ** 2 * var_s + beta**2 * relative
    maximum = line.sigma * np.sqrt((n - 2) / n)  # maximum-likelihood value
    rise = ln_c - (line.ln_a + line.b * line.mean_x)
    a = line.b**2 - t**2 * line.sigma**2 / line.sxx
    constant = rise**2 - t**2 * line.sigma**2 / n
    root = float(np.sqrt(max((line.b * rise) ** 2 - a * constant, 0.0)))
    ends = [line.mean_x + (line.b * rise + sign * root) / a for sign in (-1.0, 1.0)]
    reach = t * float(np.sqrt(var_beta)) / beta
    return replace(
        unfitted,
        theta=motion_means.exp_end(ln_theta),
        beta=beta,
        var_ln_theta=line.sigma**2 / line.b**2 / n + relative * away**2,
        cov_ln_theta_beta=beta * relative * away,
        var_beta=var_beta,
        loglik=float(-n * (likelihood.HALF_LOG_2PI + np.log(maximum) + 0.5)),
        ci_theta=(motion_means.exp_end(ends[0]), motion_means.exp_end(ends[1])),
        ci_beta=(float(beta * np.exp(-reach)), float(beta * np.exp(reach))),
        ci_method="fieller",
    )


def _fit_tobit(
    blank: FragilityFit,
    cloud: tuple[FloatArray, FloatArray, FloatArray],
    capacities: Sequence[tuple[float, float]],
    *,
    interval: bool,
) -> list[FragilityFit]:
    """Complete the cloud fits of some states with censored demands (ln intensity, ends of ln D)."""
    # with (d0, d1, h) of z = h ln D - d0 - d1 ln x the predictor is (d0 - h ln c) + d1 ln x
    x, low, high = cloud
    seen = low == high
    kernel = likelihood.NormalKernel(np.column_stack([np.ones(x.size), x]), low, high)
    best = likelihood.maximise(kernel, tobit_start(x, low, seen))
    d0, d1, h = best.params[0].tolist()
    if not bool(best.converged[0]):
        return [replace(blank, status=existence.NOT_CONVERGED)] * len(capacities)
    details = {"ln_a": d0 / h, "b": d1 / h, "sigma": 1.0 / h, "n_censored": int(np.sum(~seen))}
    blank = replace(blank, details=details, loglik=float(best.loglik[0]))
    if d1 <= FLATTEST_SLOPE:
        return [replace(blank, status=existence.NON_INCREASING, loglik=nan)] * len(capacities)
    terms = np.array([[1.0, 0.0, -np.log(c)] for c, _ in capacities])
    ends = None
    if interval:
        drop = likelihood.student_drop(int(np.sum(seen)), blank.level)
        ends = likelihood.profile_ends(kernel, best, drop, terms)
    fits: list[FragilityFit] = []
    for j, (term, (_, dispersion)) in enumerate(zip(terms, capacities, strict=True)):
        onto = np.array([term, [0.0, 1.0, 0.0]])
        params, covariance = onto @ best.params[0], onto @ best.covariance[0] @ onto.T
        widening = float(np.sqrt(1.0 + (h * dispersion) ** 2))
        own = None if ends is None else ends[[j, -1]]
        fits.append(estimated(blank, params, covariance, own, widening))
    return fits
