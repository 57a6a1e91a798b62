"""Fragility from counts of exceedance per intensity level (multiple stripes, or single runs)."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.fit import (
    FEW_MIXED_STRIPES,
    FITTED,
    FLATTEST_SLOPE,
    FragilityFit,
    common_warnings,
    estimated,
)
from skewbridge.fragility.old_likelihood.links import (
    FloatArray,
    LinkTerms,
    half_width,
    link_terms,
    predictor,
)
from skewbridge.fragility.old_likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.old_likelihood.parts import (
    Goodness,
    MedianBound,
    Predictor,
    Proportions,
    Separation,
)
from skewbridge.fragility.old_likelihood.profile import chi_square_quantile, profile_ends
from skewbridge.fragility.old_likelihood.validate import as_column, positive, require, same_length
from skewbridge.fragility.settings import DEFAULTS, FitSettings


def fit_stripes(
    im: ArrayLike,
    n: ArrayLike,
    k: ArrayLike,
    *,
    link: str = "probit",
    settings: FitSettings = DEFAULTS,
    n_records: int | None = None,
    interval: bool = True,
) -> FragilityFit:
    """Fit a fragility curve to k of n exceedances at each intensity, by maximum likelihood.

    l(a) = sum k ln F(eta) + (n - k) ln(1 - F(eta)), eta = a0 + a1 ln x; theta is the median and
    beta = (ln x84 - ln x16)/2, which for the probit link are exp(-a0/a1) and 1/a1.

    Args:
        im: Intensities, positive, any order, shape (J,); levels may repeat.
        n: Runs at each; stripes without runs are dropped with a warning.
        k: Runs that exceed, 0 <= k <= n. Fractions (uncertain capacity) make the likelihood a
            quasi-likelihood: no interval is given, take the record bootstrap.
        link: probit (default), logit or cloglog.
        settings: Level of the intervals and dispersion assumed for one-sided bounds.
        n_records: Motions behind the runs, if fewer than runs.
        interval: False leaves out the profile intervals.

    Returns:
        The fit; its status comes from the existence test, which runs first.

    Raises:
        InputError: A value is missing, not positive, or k is outside 0..n; names the row.

    References:
        Baker (2015), Earthquake Spectra 31(1):579-599, Eq. 11.
    """
    terms_of = link_terms(link)
    x, runs, exceed = positive(im, "im"), as_column(n, "n"), as_column(k, "k")
    same_length(im=x, n=runs, k=exceed)
    require(np.isfinite(runs) & (runs >= 0.0), "n", "must be >= 0 and finite", runs)
    require((exceed >= 0.0) & (exceed <= runs), "k", "must satisfy 0<=k<=n", exceed)
    kept = runs > 0.0
    warnings = [] if np.all(kept) else ["stripes_without_runs"]
    x, runs, exceed = x[kept], runs[kept], exceed[kept]
    total = round(float(np.sum(runs)))
    ln_im = np.log(x)
    status = existence.binomial_status(ln_im, runs, exceed) if total else existence.NO_RUNS
    unfitted = FragilityFit(
        method="stripes",
        status=status,
        n_runs=total,
        level=settings.confidence,
        warnings=tuple(warnings),
        predictor=Predictor(link=link),
    )
    if total == 0:
        return unfitted
    if status != FITTED:
        return _with_bounds(unfitted, ln_im, (runs, exceed), link, settings.assumed_beta)
    middle = predictor(0.5, link)
    design = np.column_stack([np.ones_like(ln_im), ln_im])
    offset = None if middle == 0.0 else np.full(x.size, middle)
    kernel = BinomialKernel(design, runs, exceed, link, offset)
    flat = predictor(float(np.sum(exceed) / np.sum(runs)), link) - middle
    best = maximise(kernel, np.array([[flat, 0.0]]))
    a0, a1 = (float(value) for value in best.params[0])
    line = Predictor(a0=a0 + middle, a1=a1, link=link)
    if not bool(best.converged[0]) or a1 <= FLATTEST_SLOPE:
        reason = existence.NON_INCREASING if bool(best.converged[0]) else existence.NOT_CONVERGED
        return replace(unfitted, status=reason, predictor=line)
    if link == "logit":
        line = replace(line, beta_equiv_pi_sqrt3=float(np.pi / np.sqrt(3.0) / a1))
    whole = bool(np.all(exceed == np.round(exceed)))
    wanted = interval and whole
    drop = chi_square_quantile(settings.confidence)
    ends = profile_ends(kernel, best, drop, flat) if wanted else None
    fit = estimated(unfitted, best.params[0], best.covariance[0], ends, half_width(link))
    warnings += common_warnings(fit.theta, fit.ci_theta, x, n_records or total)
    warnings += _overlap_warnings(x, runs, exceed)
    if not whole:
        warnings.append("fractional_counts_no_interval")
    kernel_loglik = float(best.loglik[0])
    ways = special.gammaln(runs + 1.0) - special.gammaln(exceed + 1.0)
    ways -= special.gammaln(runs - exceed + 1.0)
    loglik = kernel_loglik + (float(np.sum(ways)) if whole else 0.0)
    terms = terms_of(design @ best.params[0] + middle)
    return replace(
        fit,
        loglik=loglik,
        warnings=tuple(warnings),
        predictor=line,
        goodness=_goodness(terms, design, (runs, exceed), (kernel_loglik, loglik)),
    )


def _with_bounds(
    fit: FragilityFit,
    ln_im: FloatArray,
    counts: tuple[FloatArray, FloatArray],
    link: str,
    assumed_beta: float,
) -> FragilityFit:
    """Add what the data (runs and exceedances) still say where no estimate exists."""
    n, k = counts
    low, high = existence.clopper_pearson(k, n, fit.level)
    shares = Proportions(p_lower=tuple(low.tolist()), p_upper=tuple(high.tolist()))
    if fit.status in (existence.NO_EXCEEDANCE, existence.ALL_EXCEED):
        exceed = fit.status == existence.ALL_EXCEED
        bounds = {
            beta: existence.median_bound(ln_im, n, beta=beta, level=fit.level, exceed=exceed)
            for beta in sorted({0.3, 0.4, 0.6, assumed_beta})
        }
        bound = MedianBound(
            side="upper" if exceed else "lower",
            level=fit.level,
            theta_given_beta=bounds,
            assumed_beta=assumed_beta,
        )
        return replace(fit, proportions=shares, bound=bound)
    if fit.status == existence.SINGLE_LEVEL:
        total, hits = float(np.sum(n)), float(np.sum(k))
        ends = existence.clopper_pearson(np.array([hits]), np.array([total]), fit.level)
        median = existence.single_level_median(float(ln_im[0]), total, hits, assumed_beta, link)
        shares = replace(
            shares,
            p=hits / total,
            p_ci=(float(ends[0][0]), float(ends[1][0])),
            theta_given_beta={f"{assumed_beta:g}": median},
        )
    if fit.status in (existence.COMPLETE_SEPARATION, existence.QUASI_SEPARATION):
        hi0, lo1 = float(np.max(ln_im[n - k > 0.0])), float(np.min(ln_im[k > 0.0]))
        a0, a1 = existence.firth(ln_im, n, k, link)
        bounds = existence.separated_bounds(ln_im, n, k, beta=assumed_beta, level=fit.level)
        separation = Separation(
            theta_interval=(float(np.exp(hi0)), float(np.exp(lo1))),
            theta_midpoint_log=float(np.exp(0.5 * (hi0 + lo1))),
            theta_bounds_given_beta={f"{assumed_beta:g}": bounds},
            firth={"theta": float(np.exp((predictor(0.5, link) - a0) / a1)), "beta": 1.0 / a1},
        )
        return replace(fit, proportions=shares, separation=separation)
    return replace(fit, proportions=shares)


def _overlap_warnings(x: FloatArray, n: FloatArray, k: FloatArray) -> list[str]:
    """Warn where the transition from none to all is seen by few stripes (or single runs)."""
    levels, index = np.unique(x, return_inverse=True)
    runs, exceed = np.bincount(index, n), np.bincount(index, k)
    if np.max(runs) > 1.0:
        mixed = int(np.sum((exceed > 0.0) & (exceed < runs)))
        return ["few_mixed_stripes"] if mixed < FEW_MIXED_STRIPES else []
    first, last = np.min(levels[exceed > 0.0]), np.max(levels[exceed < runs])
    overlap = int(np.sum((levels >= first) & (levels <= last)))
    return ["small_overlap"] if overlap < 2 * FEW_MIXED_STRIPES else []


def _goodness(
    terms: LinkTerms,
    design: FloatArray,
    counts: tuple[FloatArray, FloatArray],
    logliks: tuple[float, float],
) -> Goodness:
    """Judge a fit by its counts (runs and exceedances) and log-likelihoods (kernel and whole)."""
    n, k = counts
    p = np.exp(terms.log_p)
    remain = n - k
    deviance = 2.0 * np.sum(
        special.xlogy(k, k / n)
        - k * terms.log_p
        + special.xlogy(remain, remain / n)
        - remain * terms.log_q
    )
    pearson = np.sum((k - n * p) ** 2 / np.maximum(n * p * np.exp(terms.log_q), 1e-300))
    dof = int(n.size - 2)
    grouped = dof > 0 and bool(np.max(n) > 1.0)
    return Goodness(
        deviance=float(deviance),
        deviance_dof=dof,
        deviance_p=float(special.chdtrc(dof, deviance)) if grouped else None,
        link_p=_link_p(terms, design, n, k),
        pearson=float(pearson),
        loglik_kernel=logliks[0],
        aic=4.0 - 2.0 * logliks[1],
    )


def _link_p(terms: LinkTerms, design: FloatArray, n: FloatArray, k: FloatArray) -> float | None:
    """Return the p-value of the score test of (ln x - mean)^2 added to the predictor.

    References:
        Rao (1948), Proc. Cambridge Phil. Soc. 44(1):50-57: score test; Pregibon (1980), Applied
        Statistics 29(1):15-24: test of the link.
    """
    score = k * terms.d_log_p + (n - k) * terms.d_log_q
    information = -(k * terms.d2_log_p + (n - k) * terms.d2_log_q)
    square = (design[:, 1] - np.mean(design[:, 1])) ** 2
    weighted = design * information[:, None]
    own = np.linalg.solve(design.T @ weighted, weighted.T @ square)
    extra = square - design @ own
    variance = float(information @ extra**2)
    if not variance > 1e-9:
        return None
    return float(special.chdtrc(1, float(score @ extra) ** 2 / variance))
