"""Fit lognormal fragility curves to counts, capacities or a cloud of demands.

Sources: separation, Albert and Anderson (1984), Biometrika 71(1):1-10; exact binomial limits,
Clopper and Pearson (1934), Biometrika 26(4):404-413; penalised likelihood, Firth (1993), Biometrika
80(1):27-38; counts, Baker (2015), Earthquake Spectra 31(1):579-599, Eq. 11; capacities, Vamvatsikos
and Cornell (2002), EESD 31(3):491-514; brackets, Turnbull (1976), JRSS B 38(3):290-295; cloud,
Cornell et al. (2002), J. Struct. Eng. 128(4):526-533; jackknife by motion, Bell and McCaffrey
(2002), Survey Methodology 28(2):169-181; studentised test of Breusch and Pagan, Koenker (1981),
J. Econometrics 17(1):107-112; normality, Lilliefors (1967), JASA 62(318):399-402.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, special

from skewbridge.files.tables import Floats, Index, Mask, as_column, positive, require, same_length
from skewbridge.fragility import likelihood, motion_means
from skewbridge.fragility.settings import ASSUMED_BETA, DEFAULTS, FitSettings

#: Status of a fit that has an estimate (not the status of an analysis).
FITTED: Final = "ok"
NO_EXCEEDANCE: Final = "no_exceedance"
ALL_EXCEED: Final = "all_exceed"
SINGLE_LEVEL: Final = "single_level"
ZERO_DISPERSION: Final = "zero_dispersion"
COMPLETE_SEPARATION: Final = "complete_separation"
QUASI_SEPARATION: Final = "quasi_separation"
NON_INCREASING: Final = "non_increasing"
NOT_APPLICABLE: Final = "not_applicable"
NOT_CONVERGED: Final = "not_converged"
FEW_MIXED_STRIPES: Final = 3
ALL_CENSORED: Final = "all_censored"
BOUNDS_TOO_WIDE: Final = "bounds_too_wide"
# ASSUME a median is worth reporting if unknown outcomes change it by no more than 15 %
MAX_BOUNDS_RATIO: Final = 1.15
#: Smallest slope 1/beta of a curve: with beta above 50 it is flat over any range of intensities.
FLATTEST_SLOPE: Final = 0.02
_TEST_LEVEL: Final = 0.05  # of the tests of a regression line


@dataclass(frozen=True, slots=True, kw_only=True)
class FragilityFit:
    """A lognormal fragility curve P = Phi(ln(x/theta)/beta), or the reason why there is none."""

    method: str  #: Estimator, for example ``stripes`` or ``cloud_ols``.
    status: str  #: ``ok``, or the reason why theta and beta are NaN.
    theta: float = nan  #: Median, in the unit of the intensity measure.
    beta: float = nan  #: Dispersion of the logarithm.
    var_ln_theta: float = nan  #: Variance of ln theta.
    cov_ln_theta_beta: float = nan  #: Covariance of ln theta and beta.
    var_beta: float = nan  #: Variance of beta.
    ci_theta: tuple[float, float] = (nan, nan)  #: 0 and infinity are unbounded ends.
    ci_beta: tuple[float, float] = (nan, nan)
    ci_method: str = ""  #: ``profile``, ``fieller`` or ``jackknife``; empty: no interval.
    level: float = DEFAULTS.confidence  #: Confidence level of the intervals.
    loglik: float = nan  #: Log-likelihood at the maximum (with binomial coefficients).
    n_runs: int = 0  #: Runs in the fit.
    warnings: tuple[str, ...] = ()  #: Names of warnings.
    details: Mapping[str, Any] = field(default_factory=dict)  #: Further named results.

    def without_estimate(self, status: str) -> "FragilityFit":
        """Return the fit without median, dispersion and intervals, and with this status."""
        kept_fields = ("method", "level", "n_runs", "warnings", "details")
        return FragilityFit(status=status, **{name: getattr(self, name) for name in kept_fields})

    def warned(self, *names: str) -> "FragilityFit":
        """Return the fit with additional warnings."""
        return replace(self, warnings=tuple(dict.fromkeys((*self.warnings, *names))))

    def limited(
        self, bounds: Mapping[str, tuple[float, float]], *, names: Sequence[str] = ()
    ) -> "FragilityFit":
        """Return the fit with ``names`` of warnings; no estimate if bounds differ by > 15 %."""
        fit = self.warned("unknown_outcomes", *names)
        low, high = sorted((bounds["all_exceed"][0], bounds["none_exceed"][0]))
        narrow = 0.0 < low <= high <= MAX_BOUNDS_RATIO * low < inf
        refused = fit.status == FITTED and not narrow
        return fit.without_estimate(BOUNDS_TOO_WIDE) if refused else fit

    def as_json(self) -> dict[str, Any]:
        """Return the object that `skewbridge fit --json` prints."""
        names = "status theta beta cov_ln_theta_beta ci_theta ci_beta ci_method level loglik n_runs"
        values = {name: getattr(self, name) for name in (*names.split(), "method", "warnings")}
        errors = np.sqrt([self.var_ln_theta, self.var_beta]).tolist()
        values |= {**self.details, "se_ln_theta": errors[0], "se_beta": errors[1]}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}


def fits_of_states(
    blanks: Sequence[FragilityFit],
    kernel: likelihood.NormalKernel,
    best: likelihood.Maximum,
    terms: Floats,
    slope: int,
    drop: float | None,
    widening: float = 1.0,
) -> list[FragilityFit]:
    """Return the fits of J states from one maximum: P_j = Phi((a0_j + a1 ln x) / widening).

    Hence ln theta = -a0/a1 and beta = widening/a1. The intercepts a0 are ``terms`` (J, p) times the
    p parameters, and a1 is the parameter at position ``slope``. ``widening`` is sqrt(1 + capacity
    variance / fitted variance). Covariances are from the delta method. Profile intervals use
    ``drop`` (see `drop_of`); None gives no intervals. ``blanks`` are the fits without estimates.
    """
    fits, unit_slope = list(blanks), np.eye(terms.shape[1])[slope]
    intervals = None if drop is None else likelihood.profile_ends(kernel, best, drop, terms, slope)
    for j, no_fit in enumerate(blanks):
        rows = np.stack([terms[j], unit_slope])
        (a0, a1), covariance = (rows @ best.params[0]).tolist(), rows @ best.covariance[0] @ rows.T
        jacobian = np.array([[-1.0 / a1, a0 / a1**2], [0.0, -widening / a1**2]])
        variance = (jacobian @ covariance @ jacobian.T).tolist()
        (low, high), beta_ends = np.full((2, 2), nan) if intervals is None else intervals[[j, -1]]
        fits[j] = replace(
            no_fit,
            theta=motion_means.exp_end(-a0 / a1),
            beta=widening / a1,
            var_ln_theta=variance[0][0],
            cov_ln_theta_beta=variance[0][1],
            var_beta=variance[1][1],
            ci_theta=(motion_means.exp_end(low), motion_means.exp_end(high)),
            ci_beta=tuple((widening * beta_ends).tolist()),
            ci_method="" if intervals is None else "profile",
            loglik=float(best.loglik[0]),
        )
    return fits


def jackknifed(fit: FragilityFit, ln_theta: Floats, beta: Floats, priors: int = 0) -> FragilityFit:
    """Return the fit with jackknife intervals and covariance from R estimates.

    ``ln_theta`` and ``beta`` have the order of `Jackknifed.of_replicates`, with ``priors`` last.
    There is no interval if too few blocks have an influence.
    """
    logs = np.column_stack([ln_theta, np.log(beta)])
    both = motion_means.Jackknifed.of_replicates(logs, priors)
    count, missing = np.sum(both.present), np.sum(~np.isfinite(logs).all(axis=1))
    if count < motion_means.MIN_VALUES:
        refused = fit.without_estimate(fit.status).warned("too_few_motions_for_an_interval")
        return replace(refused, theta=fit.theta, beta=fit.beta, loglik=fit.loglik)
    warning_names = ("jackknife_without_estimate",) if missing >= 0.05 * (count + missing) else ()
    (of_theta, of_beta), covariance = np.array(both.interval(fit.level)).T, both.covariance
    return replace(
        fit.warned(*warning_names),
        ci_theta=tuple(map(motion_means.exp_end, of_theta)),
        ci_beta=tuple(map(motion_means.exp_end, of_beta)),
        ci_method="jackknife",
        var_ln_theta=float(covariance[0, 0]),
        cov_ln_theta_beta=float(covariance[0, 1]) * fit.beta,
        var_beta=float(covariance[1, 1]) * fit.beta**2,
    )


def common_warnings(fit: FragilityFit, im: Floats, n_records: int) -> list[str]:
    """Return the warnings that apply to a fit of any method."""
    low, high = fit.ci_theta
    applying = {
        "median_extrapolated": fit.theta > np.max(im) or fit.theta < np.min(im),
        "wide_ci": not (np.isnan(low) or (low > 0.0 and high / low <= 3.0)),
        "fewer_than_10_records": n_records < 10,
    }
    return [name for name, applies in applying.items() if applies]


def fit_stripes(
    im: ArrayLike,  # intensities, positive, shape (J,)
    n: ArrayLike,  # number of runs at each intensity
    k: ArrayLike,  # number of these runs that exceed the limit state
    *,
    settings: FitSettings = DEFAULTS,
    n_records: int | None = None,  # number of motions, if smaller than the number of runs
    interval: bool = True,  # compute profile-likelihood intervals
) -> FragilityFit:
    """Fit a fragility curve to k exceedances in n runs at each intensity, by maximum likelihood.

    l(a) = sum k ln Phi(eta) + (n - k) ln Phi(-eta), eta = a0 + a1 ln x; theta = exp(-a0/a1) and
    beta = 1/a1. The status is the reason if there is no estimate (`binomial_status`). Intensities
    may repeat. Intensities without runs are dropped with a warning. An `InputError` names the row
    of a value that is missing, not positive, or not a whole number in 0..n.
    """
    x, runs, exceed = positive(im, "im"), as_column(n, "n"), as_column(k, "k")
    same_length(im=x, n=runs, k=exceed)
    require(np.isfinite(runs) & (runs >= 0.0), "n", "must be >= 0 and finite", runs)
    require((exceed >= 0.0) & (exceed <= runs), "k", "must satisfy 0<=k<=n", exceed)
    require(exceed == np.round(exceed), "k", "must be whole numbers", exceed)
    has_runs = runs > 0.0
    x, runs, exceed = x[has_runs], runs[has_runs], exceed[has_runs]
    total, ln_im = round(float(np.sum(runs))), np.log(x)
    status = binomial_status(ln_im, runs, exceed) if total else "no_runs"
    level, names = settings.confidence, () if np.all(has_runs) else ("stripes_without_runs",)
    no_fit = FragilityFit(
        method="stripes", status=status, n_runs=total, level=level, warnings=names
    )
    if status != FITTED:
        return replace(no_fit, details=_stripe_bounds(status, ln_im, runs, exceed, settings))
    inf, counts = np.full(x.size, np.inf), np.append(exceed, runs - exceed)
    low, high, has_hits = np.append(-inf, ln_im), np.append(ln_im, inf), counts > 0.0
    design = -np.ones((int(has_hits.sum()), 1))
    kernel = likelihood.NormalKernel(design, low[has_hits], high[has_hits], counts[has_hits])
    # start: line through the probits of the exceedance shares, which are kept away from 0 and 1
    line = np.polyfit(ln_im, special.ndtri((exceed + 0.5) / (runs + 1.0)), 1, w=np.sqrt(runs))
    maximum = likelihood.maximise(kernel, line[None, ::-1])
    fit = _completed(no_fit, kernel, maximum, x, n_records=n_records or total, interval=interval)
    if fit.status != FITTED:
        return fit
    fit = fit.warned(*_overlap_warnings(x, runs, exceed))
    ln_combinations = special.gammaln(runs + 1.0) - special.gammaln(exceed + 1.0)
    loglik = fit.loglik + float(np.sum(ln_combinations - special.gammaln(runs - exceed + 1.0)))
    details = {**fit.details, "loglik_kernel": fit.loglik}
    return replace(fit, loglik=loglik, details=details)


def _completed(
    no_fit: FragilityFit,
    kernel: likelihood.NormalKernel,
    maximum: likelihood.Maximum,
    im: Floats,
    *,
    n_records: int,
    interval: bool = True,
    flattest: float = FLATTEST_SLOPE,
) -> FragilityFit:
    a0, a1 = maximum.params[0].tolist()
    no_fit = replace(no_fit, details={**no_fit.details, "a0": a0, "a1": a1})
    if not maximum.converged[0]:
        return replace(no_fit, status=NOT_CONVERGED)
    if a1 <= flattest:
        return replace(no_fit, status=NON_INCREASING)
    drop, term = likelihood.drop_of(no_fit.level), np.array([[1.0, 0.0]])
    fit = fits_of_states([no_fit], kernel, maximum, term, 1, drop if interval else None)[0]
    return fit.warned(*common_warnings(fit, im, n_records))


def _stripe_bounds(
    status: str, ln_im: Floats, n: Floats, k: Floats, settings: FitSettings
) -> dict[str, Any]:
    level, beta = settings.confidence, ASSUMED_BETA
    if status in (NO_EXCEEDANCE, ALL_EXCEED):
        exceed = status == ALL_EXCEED
        shares = zip(("p_lower", "p_upper"), clopper_pearson(k, n, level), strict=True)
        bounds = {name: limits.tolist() for name, limits in shares}
        return bounds | _median_bound(ln_im, n, settings, 0.3, 0.4, 0.6, exceed=exceed)
    if status == SINGLE_LEVEL:
        total, exceedances = np.sum(n, keepdims=True), np.sum(k, keepdims=True)
        p, limits = float(exceedances[0] / total[0]), clopper_pearson(exceedances, total, level)
        median = float(np.exp(ln_im[0] - beta * special.ndtri(p)))
        medians = {"theta_given_beta": {f"{beta:g}": median}}
        return {"p": p, "p_ci": [float(limit[0]) for limit in limits], **medians}
    if status not in (COMPLETE_SEPARATION, QUASI_SEPARATION):
        return {}
    a0, a1 = firth(ln_im, n, k)
    theta, dispersion = float(np.exp(-a0 / a1)), 1.0 / a1
    low, high = separated_bounds(ln_im, n, k, beta=beta, level=level)
    return {
        "theta_interval": np.exp([ln_im[n > k].max(), ln_im[k > 0.0].min()]).tolist(),
        "firth": {"theta": theta, "beta": dispersion},
        **{"theta_bound_low": low, "theta_bound_high": high, "theta_bound_beta": beta},
    }


def _median_bound(
    ln_im: Floats, n: Floats, settings: FitSettings, *betas: float, exceed: bool
) -> dict[str, Any]:
    """Return one-sided bounds on theta for ``betas`` and `ASSUMED_BETA`: upper if ``exceed``."""
    level, assumed_beta = settings.confidence, ASSUMED_BETA
    bounds = {
        f"{beta:g}": median_bound(ln_im, n, beta=beta, level=level, exceed=exceed)
        for beta in sorted({*betas, assumed_beta})
    }
    side, end = ("upper", "high") if exceed else ("lower", "low")
    medians = {f"theta_{side}{100 * level:g}_given_beta": bounds, "theta_bound_beta": assumed_beta}
    return medians | {f"theta_bound_{end}": bounds[f"{assumed_beta:g}"]}


def _overlap_warnings(x: Floats, n: Floats, k: Floats) -> list[str]:
    """Return a warning if few stripes have both runs that exceed and runs that do not."""
    levels, index = np.unique(x, return_inverse=True)
    runs, exceed = np.bincount(index, n), np.bincount(index, k)
    if np.max(runs) > 1.0:
        n_mixed = int(np.sum((exceed > 0.0) & (exceed < runs)))
        return ["few_mixed_stripes"] if n_mixed < FEW_MIXED_STRIPES else []
    low, high = np.min(levels[exceed > 0.0]), np.max(levels[exceed < runs])
    overlap = int(np.sum((levels >= low) & (levels <= high)))
    return ["small_overlap"] if overlap < 2 * FEW_MIXED_STRIPES else []


def fit_capacities(
    capacity: ArrayLike, censored: ArrayLike | None = None, settings: FitSettings = DEFAULTS
) -> FragilityFit:
    """Fit a lognormal distribution to capacities, some of which may be right-censored.

    l = sum over observed [ln phi(z) - ln beta] + sum over censored ln Phi(-z),
    z = ln(IM/theta)/beta. ``capacity`` is the intensity at which the limit state is reached. If
    ``censored`` is 1, it is the last intensity tried. ``beta`` is the maximum-likelihood value. If
    no capacity is censored, the details also give the value with n - 1 in the denominator. An
    `InputError` names the row of a value that is missing or not positive.
    """
    values = positive(capacity, "capacity")
    flags = np.zeros(values.size) if censored is None else as_column(censored, "censored")
    same_length(capacity=values, censored=flags)
    require((flags == 0.0) | (flags == 1.0), "censored", "must be 0 or 1", flags)
    is_censored = flags == 1.0
    y = np.log(values)
    known = y[~is_censored]
    no_fit = FragilityFit(method="ida", status=FITTED, n_runs=y.size, level=settings.confidence)
    if known.size and np.ptp(known) == 0.0:
        # Equal capacities usually mean that the grid is too coarse: use brackets instead.
        if known.size == y.size:
            return replace(no_fit, status=ZERO_DISPERSION, theta=float(np.exp(known[0])), beta=0.0)
        if np.all(y[is_censored] <= known[0]):
            return replace(no_fit, status="unbounded_likelihood")
    details: dict[str, Any] = {}
    if not np.any(is_censored):
        details["beta_unbiased_n_minus_1"] = float(np.std(y, ddof=1))
        if y.size >= 4:
            names = ("lilliefors_d", "lilliefors_d_05", "lilliefors_d_10")
            details |= dict(zip(names, lilliefors(y), strict=True))
    no_fit = replace(no_fit, details=details)
    return _fit_distribution(no_fit, y, np.where(is_censored, np.inf, y), values, settings)


def fit_brackets(
    lower: ArrayLike, upper: ArrayLike, settings: FitSettings = DEFAULTS
) -> FragilityFit:
    """Fit a lognormal distribution to capacities in brackets (lower, upper].

    l = sum ln[Phi(z_upper) - Phi(z_lower)]. Use it for stripes with the same motions at every
    level, and for any grid or search with steps wider than 2 % of theta. ``upper`` is the intensity
    of the first exceedance: infinity, NaN or None if no run exceeds. ``lower`` is the largest
    intensity below it, or 0 if there is none. An `InputError` names the row in which ``lower`` is
    missing, negative or not below ``upper``.
    """
    low, high = as_column(lower, "lower"), as_column(upper, "upper")
    same_length(lower=low, upper=high)
    high = np.where(np.isnan(high), np.inf, high)
    require(np.isfinite(low) & (low >= 0.0), "lower", "must be >= 0 and finite", low)
    require(high > low, "upper", "must be above lower", high)
    with np.errstate(divide="ignore"):
        y_low, y_high = np.log(low), np.log(high)
    level, im = settings.confidence, np.append(low[low > 0.0], high[np.isfinite(high)])
    no_fit = FragilityFit(method="ida_interval", status=FITTED, n_runs=low.size, level=level)
    return _fit_distribution(no_fit, y_low, y_high, im, settings)


def first_exceedances(im: Floats, exceeds: Mask, record: Index) -> tuple[Floats, Floats, int]:
    """Return the brackets (lower, upper] of the first exceedance of each motion, and a count.

    ``im``, ``exceeds`` and ``record`` are intensity, outcome and number of the motion of each run,
    shape (n,). The count is of motions that do not exceed at an intensity above their first
    exceedance.
    """
    # ASSUME the first crossing is the capacity
    records, codes = np.unique(record, return_inverse=True)
    lower, upper = np.zeros(records.size), np.full(records.size, np.inf)
    np.minimum.at(upper, codes[exceeds], im[exceeds])
    is_lower = ~exceeds & (im < upper[codes])
    np.maximum.at(lower, codes[is_lower], im[is_lower])
    return lower, upper, int(np.unique(codes[~exceeds & (im > upper[codes])]).size)


def fit_first_exceedances(
    im: Floats, exceed: Floats, record: Index, settings: FitSettings
) -> FragilityFit:
    """Fit the brackets of `first_exceedances`; a warning is added if its count is above 0."""
    lower, upper, n_odd = first_exceedances(im, exceed > 0.0, record)
    fit = fit_brackets(lower, upper, settings)
    fit = replace(fit, details={**fit.details, "n_non_monotone": n_odd})
    return fit.warned("non_monotone_records") if n_odd else fit


def _fit_distribution(
    no_fit: FragilityFit, lower: Floats, upper: Floats, im: Floats, settings: FitSettings
) -> FragilityFit:
    """Fit capacities with ln bounds (n,), or return ``blank`` with the reason as status."""
    has_low, has_high = np.isfinite(lower), np.isfinite(upper)
    if not (np.any(has_low) and np.any(has_high)):
        exceed = bool(np.any(has_high))
        bounds, status = (upper, ALL_EXCEED) if exceed else (lower, ALL_CENSORED)
        details = _median_bound(bounds, np.ones(bounds.size), settings, exceed=exceed)
        return replace(no_fit, status=status, details=details)
    if (low := float(np.max(lower))) <= (high := float(np.min(upper))):
        status = COMPLETE_SEPARATION if low < high else QUASI_SEPARATION
        details = {"theta_interval": np.exp([low, high]).tolist()}
        return replace(no_fit, status=status, details=details)
    if not np.any(has_low & has_high) and np.max(upper[has_high]) <= np.min(lower[has_low]):
        return replace(no_fit, status=NON_INCREASING)
    censored = ~(has_low & has_high)
    no_fit = replace(no_fit, details={**no_fit.details, "n_censored": int(np.sum(censored))})
    kernel = likelihood.NormalKernel(-np.ones((lower.size, 1)), lower, upper)
    guess = np.where(has_high, upper, lower)
    spread = max(float(np.std(guess)), 0.05)
    maximum = likelihood.maximise(kernel, np.array([[-np.mean(guess) / spread, 1.0 / spread]]))
    # finite brackets have no probability under a falling curve, so their slope needs no limit
    flattest = FLATTEST_SLOPE if np.all(censored) else 0.0
    fit = _completed(no_fit, kernel, maximum, im, n_records=lower.size, flattest=flattest)
    return replace(fit, details={**fit.details, "mu": float(np.log(fit.theta))})


def fit_cloud(
    im: ArrayLike,  # intensities, positive, shape (n,)
    edp: ArrayLike,  # demands, or their lower bounds; 0 if left-censored
    threshold: float,  # median capacity c, in the unit of ``edp``
    #: Upper bounds: equal to ``edp`` if observed, infinity if the run ended early.
    upper: ArrayLike | None = None,
    *,
    capacity_dispersion: float = 0.0,
    settings: FitSettings = DEFAULTS,
    motions: Index | None = None,  # number of the motion of each run; None: one run per motion
) -> FragilityFit:
    """Fit a fragility curve to a cloud of demands: ln D = ln a + b ln x + e.

    theta = exp((ln c - ln a)/b) and beta = sqrt(s^2 + dispersion^2)/b. Without censored demands the
    fit is least squares with Fieller's interval. With censored demands, it is maximum likelihood
    (Tobit) with profile intervals that use Student's t(n - 2) for n observed demands. If motions
    repeat, intervals are from the jackknife over motions. If Fieller's interval is unbounded, the
    status is ``slope_not_significant``. The tests of the line add warnings (`TestedLine`). An
    `InputError` names the row of a missing or non-positive value.
    """
    values, low = positive(im, "im"), as_column(edp, "edp")
    high = low if upper is None else as_column(upper, "upper")
    same_length(im=values, edp=low, upper=high)
    observed = low == high
    usable = np.isfinite(low) & (low >= 0.0) & (high > 0.0) & ((low > 0.0) | ~observed)
    require(usable, "edp", "must be > 0 and finite", low)
    require(high >= low, "upper", "must not be below edp", high)
    informative = (low > 0.0) | np.isfinite(high)
    with np.errstate(divide="ignore"):
        cloud = x, y_low, y_high = np.log([column[informative] for column in (values, low, high)])
    is_observed = y_low == y_high
    is_censored = not bool(np.all(is_observed))
    ln_capacity = float(np.log(positive([threshold], "threshold")[0]))
    method, level = "cloud_tobit" if is_censored else "cloud_ols", settings.confidence
    no_fit = FragilityFit(method=method, status=FITTED, n_runs=x.size, level=level)
    if np.sum(is_observed) < 3 or np.ptp(x[is_observed]) == 0.0:
        return replace(no_fit, status="too_few_runs" if np.sum(is_observed) < 3 else SINGLE_LEVEL)
    line = tested_line(x[is_observed], y_low[is_observed])
    tobit = _tobit(*cloud) if is_censored else None
    if tobit is not None:
        line = _tobit_tested(line, cloud, tobit[1])
    omitted = {"n", "mean_x", "sxx"}
    tests = {k: v for k, v in line._asdict().items() if k not in omitted and not np.isnan(v)}
    no_fit = replace(no_fit, details=tests)
    codes = np.arange(x.size) if motions is None else motions[informative]
    subsets = motion_means.motion_weights(codes) > 0.0
    repeated = np.unique(codes).size < x.size
    capacity = ln_capacity, capacity_dispersion
    if tobit is None:
        fit = _fit_least_squares(no_fit, line, *capacity)
    else:
        fit = _fit_tobit(no_fit, cloud, tobit, *capacity, interval=not repeated)
    if fit.status != FITTED:
        return fit
    if repeated:
        a, b, s = np.transpose([cloud_line(*cloud[:, rows], tobit=is_censored) for rows in subsets])
        fit = jackknifed(fit, (ln_capacity - a) / b, np.hypot(s, capacity_dispersion) / b)
    names = common_warnings(fit, np.exp(x), len(subsets) - 1) + line.warnings
    names += [] if np.any(y_low >= ln_capacity) else ["no_exceedance_observed"]
    return fit.warned(*names)


def _tobit_tested(line: "TestedLine", cloud: Floats, maximum: likelihood.Maximum) -> "TestedLine":
    """Return a line with the likelihood-ratio test of curvature of a cloud with censored demands.

    The tests of a line through the observed demands are not valid: high demands are missing.
    """
    tests = dict.fromkeys(("r2", "curvature", "curvature_p", "scatter_p"), nan)
    x, low, high = cloud
    if not np.isnan(line.curvature):
        terms = np.column_stack([np.ones(x.size), x, (x - line.mean_x) ** 2])
        start = np.insert(maximum.params, 2, 0.0, axis=1)
        bent_line = likelihood.maximise(likelihood.NormalKernel(terms, low, high), start)
        if bent_line.converged[0] and maximum.converged[0]:
            gain = max(float(bent_line.loglik[0] - maximum.loglik[0]), 0.0)
            tests["curvature"] = float(bent_line.params[0, 2] / bent_line.params[0, 3])
            tests["curvature_p"] = float(special.chdtrc(1, 2.0 * gain))
    return line._replace(**tests)


def cloud_line(x: Floats, low: Floats, high: Floats, *, tobit: bool) -> tuple[float, float, float]:
    """Return ln a, b and sigma of a cloud of ln demands with these bounds; NaN without a line.

    There is no line if fewer than three demands are known, if the known demands are at a single
    intensity, or if its slope is not positive. The bounds (n,) are equal for known demands.
    """
    is_known = low == high
    if np.sum(is_known) < 3 or np.ptp(x[is_known]) == 0.0:
        return nan, nan, nan
    if not tobit:
        line = tested_line(x, low)
        return line[:3] if line.b > 0.0 else (nan, nan, nan)
    d0, d1, h = (maximum := _tobit(x, low, high)[1]).params[0].tolist()
    is_valid = bool(maximum.converged[0]) and d1 > FLATTEST_SLOPE
    return (d0 / h, d1 / h, 1.0 / h) if is_valid else (nan, nan, nan)


def _tobit(
    x: Floats, low: Floats, high: Floats
) -> tuple[likelihood.NormalKernel, likelihood.Maximum]:
    """Return likelihood and maximum (d0, d1, h = 1/sigma) of a cloud: z = h ln D - d0 - d1 ln x."""
    is_known = low == high
    slope, intercept = np.polyfit(x[is_known], low[is_known], 1)
    h = 1.0 / max(float(np.std(low[is_known] - intercept - slope * x[is_known])), 1e-3)
    kernel = likelihood.NormalKernel(np.column_stack([np.ones(x.size), x]), low, high)
    return kernel, likelihood.maximise(kernel, np.array([[h * intercept, h * slope, h]]))


def _fit_least_squares(
    no_fit: FragilityFit, line: "TestedLine", ln_capacity: float, dispersion: float
) -> FragilityFit:
    """Fit a cloud without censored demands: Fieller's interval for theta, delta method for beta."""
    if line.b <= 0.0:
        return replace(no_fit, status=NON_INCREASING)
    if line.sigma <= 1e-12:
        return replace(no_fit, status=ZERO_DISPERSION)
    n, beta = line.n, float(np.hypot(line.sigma, dispersion)) / line.b
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * no_fit.level))
    ln_theta = (ln_capacity - line.ln_a) / line.b
    distance = ln_theta - line.mean_x
    var_ratio = line.sigma**2 / line.sxx / line.b**2  # relative variance of b
    var_ln_theta = line.sigma**2 / line.b**2 / n + var_ratio * distance**2
    variances = np.array([var_ln_theta, -var_ratio * distance, var_ratio])
    ln_ends = motion_means.fieller_ends(np.array(ln_theta), np.array(t), *variances)
    if np.any(np.isinf(ln_ends)):
        return replace(no_fit, status="slope_not_significant")
    # beta = sqrt(s^2 + c^2)/b: d beta/d s = s/(beta b^2), d beta/d b = -beta/b
    var_s = line.sigma**2 / (2.0 * (n - 2))
    var_beta = (line.sigma / (beta * line.b**2)) ** 2 * var_s + beta**2 * var_ratio
    sigma_ml = line.sigma * np.sqrt((n - 2) / n)  # maximum-likelihood value
    half_width = t * float(np.sqrt(var_beta)) / beta
    return replace(
        no_fit,
        theta=motion_means.exp_end(ln_theta),
        beta=beta,
        var_ln_theta=var_ln_theta,
        cov_ln_theta_beta=beta * var_ratio * distance,
        var_beta=var_beta,
        loglik=float(-n * (likelihood.HALF_LOG_2PI + np.log(sigma_ml) + 0.5)),
        ci_theta=(motion_means.exp_end(float(ln_ends[0])), motion_means.exp_end(float(ln_ends[1]))),
        ci_beta=(float(beta * np.exp(-half_width)), float(beta * np.exp(half_width))),
        ci_method="fieller",
    )


def _fit_tobit(
    no_fit: FragilityFit,
    cloud: Floats,
    tobit: tuple[likelihood.NormalKernel, likelihood.Maximum],
    ln_capacity: float,
    dispersion: float,
    *,
    interval: bool,
) -> FragilityFit:
    """Fit a cloud (ln intensities, lower and upper bounds, shape (3, n)) with censored demands."""
    is_known = cloud[1] == cloud[2]
    kernel, maximum = tobit
    d0, d1, h = maximum.params[0].tolist()
    if not bool(maximum.converged[0]):
        return replace(no_fit, status=NOT_CONVERGED)
    details = {"ln_a": d0 / h, "b": d1 / h, "sigma": 1.0 / h, "n_censored": int(np.sum(~is_known))}
    no_fit = replace(no_fit, details={**no_fit.details, **details})
    if d1 <= FLATTEST_SLOPE:
        return replace(no_fit, status=NON_INCREASING)
    # the predictor is (d0 - h ln c) + d1 ln x
    terms = np.array([[1.0, 0.0, -ln_capacity]])
    drop = likelihood.drop_of(no_fit.level, int(np.sum(is_known))) if interval else None
    widening = float(np.hypot(1.0, h * dispersion))
    return fits_of_states([no_fit], kernel, maximum, terms, 1, drop, widening)[0]


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
        """Significant tests: ``saturating`` or ``curved``, and ``heteroscedastic``."""
        names: list[str] = []
        if self.curvature_p < _TEST_LEVEL:
            names.append("saturating" if self.curvature < 0.0 else "curved")
        if self.scatter_p < _TEST_LEVEL:
            names.append("heteroscedastic")
        return names


def tested_line(x: Floats, y: Floats) -> TestedLine:
    """Fit and test the least-squares line of y = ln demand (n,) on x = ln intensity (n,)."""
    n, mean_x, mean_y = x.size, float(np.mean(x)), float(np.mean(y))
    dx, dy = x - mean_x, y - mean_y
    sxx, syy = float(dx @ dx), float(dy @ dy)
    b = float(dx @ dy) / sxx
    residual = dy - b * dx
    sse = float(residual @ residual)
    sigma = float(np.sqrt(sse / (n - 2))) if n > 2 else nan
    r2 = 1.0 - sse / syy if syy > 0.0 else nan
    centred = residual**2 - np.mean(residual**2)  # studentised Breusch-Pagan test
    scale = sxx * float(centred @ centred)
    scatter_p = float(special.chdtrc(1, n * float(dx @ centred) ** 2 / scale)) if scale else nan
    curvature = curvature_p = nan  # coefficient and p-value of an additional term in u^2
    curved_x = dx**2 - np.mean(dx**2)
    curved_x = curved_x - (float(curved_x @ dx) / sxx) * dx
    curved_sxx = float(curved_x @ curved_x)
    if n >= 4 and curved_sxx > 1e-12 * sxx**2 and sse > 0.0:
        curvature = float(curved_x @ residual) / curved_sxx
        explained = curvature**2 * curved_sxx
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


def binomial_status(ln_im: Floats, n: Floats, k: Floats) -> str:
    """Return the status of k exceedances in n > 0 runs at J intensities: ``ok`` if a fit exists.

    hi0 is the largest intensity with a non-exceedance, lo1 the smallest with an exceedance.
    hi0 < lo1 is complete separation, hi0 = lo1 quasi-separation. If all exceedances are at or below
    all non-exceedances, the status is ``non_increasing``.
    """
    if np.sum(k) <= 0.0:
        return NO_EXCEEDANCE
    if np.sum(n - k) <= 0.0:
        return ALL_EXCEED
    if np.ptp(ln_im) == 0.0:
        return SINGLE_LEVEL
    without_hits, with_hits = ln_im[n - k > 0.0], ln_im[k > 0.0]
    if np.max(without_hits) < np.min(with_hits):
        return COMPLETE_SEPARATION
    if np.max(without_hits) == np.min(with_hits):
        return QUASI_SEPARATION
    if np.max(with_hits) <= np.min(without_hits):
        return NON_INCREASING
    return FITTED


def clopper_pearson(k: Floats, n: Floats, level: float) -> tuple[Floats, Floats]:
    """Return the exact limits of proportions k/n; they are one-sided if k is 0 or n."""
    tail = np.where((k <= 0.0) | (k >= n), 1.0 - level, (1.0 - level) / 2.0)
    low = np.where(k <= 0.0, 0.0, special.betaincinv(np.maximum(k, 1e-9), n - k + 1.0, tail))
    high = np.where(k >= n, 1.0, special.betaincinv(k + 1.0, np.maximum(n - k, 1e-9), 1.0 - tail))
    return low, high


def median_bound(ln_im: Floats, n: Floats, *, beta: float, level: float, exceed: bool) -> float:
    """Return theta with P(all, or no, of n runs exceed) = 1 - level: its upper or lower bound."""
    sign = 1.0 if exceed else -1.0

    def excess(ln_theta: float) -> float:
        eta = sign * (ln_im - ln_theta) / beta
        return float(np.sum(n * special.log_ndtr(eta)) - np.log(1.0 - level))

    middle, width = float(np.mean(ln_im)), float(np.ptp(ln_im)) + 40.0 * beta
    return float(np.exp(optimize.brentq(excess, middle - width, middle + width, xtol=1e-13)))


def separated_bounds(
    ln_im: Floats, n: Floats, k: Floats, *, beta: float, level: float
) -> tuple[float, float]:
    """Return both one-sided likelihood-ratio bounds of theta for separated counts."""

    def loglik(ln_theta: float) -> float:
        eta = (ln_im - ln_theta) / beta
        return float(np.sum(k * special.log_ndtr(eta) + (n - k) * special.log_ndtr(-eta)))

    low, high = float(np.min(ln_im)) - 8.0 * beta, float(np.max(ln_im)) + 8.0 * beta
    best = optimize.minimize_scalar(lambda t: -loglik(t), bounds=(low, high), method="bounded")
    middle, target = float(best.x), loglik(float(best.x)) - 0.5 * float(special.ndtri(level)) ** 2
    roots = (
        optimize.brentq(lambda t: loglik(t) - target, middle, middle + n_betas * beta, xtol=1e-12)
        for n_betas in (-40.0, 40.0)
    )
    theta_low, theta_high = map(float, np.exp(list(roots)))
    return theta_low, theta_high


def firth(ln_im: Floats, n: Floats, k: Floats) -> tuple[float, float]:
    """Return (a0, a1) of `fit_stripes` that maximise l + 0.5 ln|I|; I: expected information."""
    centre, scale = float(np.mean(ln_im)), float(np.std(ln_im))
    design = np.column_stack([np.ones_like(ln_im), (ln_im - centre) / scale])

    def negative(parameters: Floats) -> float:
        eta = design @ parameters
        # phi^2/(Phi(eta) Phi(-eta)) from Mills ratios, which do not underflow
        weight = n * likelihood.mills_ratio(eta) * likelihood.mills_ratio(-eta)
        sign, log_determinant = np.linalg.slogdet(design.T @ (weight[:, None] * design))
        loglik = np.sum(k * special.log_ndtr(eta) + (n - k) * special.log_ndtr(-eta))
        return np.inf if sign <= 0 else -float(loglik) - 0.5 * float(log_determinant)

    a0, a1 = optimize.fmin(negative, [0.0, 1.0], xtol=1e-10, ftol=1e-13, maxiter=4000, disp=False)
    return float(a0 - a1 * centre / scale), float(a1 / scale)
