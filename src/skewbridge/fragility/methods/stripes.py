"""Fragility from counts of exceedance per intensity level (multiple stripes, or single runs)."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.fit import (
    DEFAULT_LEVEL,
    FEW_MIXED_STRIPES,
    FLATTEST_SLOPE,
    OK,
    FragilityFit,
    common_warnings,
    exp_end,
    lognormal_covariance,
)
from skewbridge.fragility.likelihood.links import FloatArray, link_terms, predictor
from skewbridge.fragility.likelihood.newton import BinomialKernel, Maximum, maximise
from skewbridge.fragility.likelihood.profile import profile_ends
from skewbridge.fragility.likelihood.validate import as_column, positive, require, same_length


def fit_stripes(
    im: ArrayLike,
    n: ArrayLike,
    k: ArrayLike,
    *,
    link: str = "probit",
    level: float = DEFAULT_LEVEL,
    assumed_beta: float = 0.4,
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
        level: Confidence level of the profile intervals.
        assumed_beta: Dispersion for one-sided bounds where no estimate exists.
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
    status = existence.binomial_status(ln_im, runs, exceed) if total else existence.NO_EXCEEDANCE

    def refused(reason: str, details: dict[str, Any]) -> FragilityFit:
        return FragilityFit(
            method="stripes",
            status=reason,
            n_runs=total,
            level=level,
            warnings=tuple(warnings),
            details={"link": link, **details},
        )

    if total == 0:
        return refused("no_runs", {})
    if status != OK:
        return refused(
            status, _what_is_known(status, ln_im, runs, exceed, link, level, assumed_beta)
        )
    middle = predictor(0.5, link)
    spread = 0.5 * (predictor(special.ndtr(1.0), link) - predictor(special.ndtr(-1.0), link))
    design = np.column_stack([np.ones_like(ln_im), ln_im])
    offset = None if middle == 0.0 else np.full(x.size, middle)
    kernel = BinomialKernel(design, runs, exceed, link, offset)
    flat = predictor(float(np.sum(exceed) / np.sum(runs)), link) - middle
    best = maximise(kernel, np.array([[flat, 0.0]]))
    a0, a1 = (float(value) for value in best.params[0])
    if not bool(best.converged[0]):
        return refused("not_converged", {"a0": a0 + middle, "a1": a1})
    if a1 <= FLATTEST_SLOPE:
        return refused(existence.NON_INCREASING, {"a0": a0 + middle, "a1": a1})
    whole = bool(np.all(exceed == np.round(exceed)))
    ends: dict[str, Any] = {}
    if interval and whole:
        found = profile_ends(kernel, best, level, flat)
        low, high = found.slope
        ends = {
            "ci_theta": (exp_end(found.ln_theta[0]), exp_end(found.ln_theta[1])),
            "ci_beta": (spread / high, spread / low if low > 0.0 else np.inf),
            "ci_method": "profile",
        }
    theta = float(np.exp(-a0 / a1))
    records = total if n_records is None else n_records
    warnings += common_warnings(theta, ends.get("ci_theta", (np.nan, np.nan)), x, records)
    warnings += _overlap_warnings(x, runs, exceed)
    if not whole:
        warnings.append("fractional_counts_no_interval")
    variance = lognormal_covariance(best.params[0], best.covariance[0], spread)
    details = _goodness(kernel, terms_of(design @ best.params[0] + middle), runs, exceed)
    details |= {"link": link, "a0": a0 + middle, "a1": a1}
    if link == "logit":
        details["beta_equiv_pi_sqrt3"] = float(np.pi / np.sqrt(3.0) / a1)
    constant = _log_binomial(runs, exceed) if whole else 0.0
    return FragilityFit(
        method="stripes",
        status=OK,
        theta=theta,
        beta=spread / a1,
        var_ln_theta=variance[0],
        cov_ln_theta_beta=variance[1],
        var_beta=variance[2],
        level=level,
        loglik=float(best.loglik[0]) + constant,
        n_runs=total,
        warnings=tuple(warnings),
        details={
            **details,
            "loglik_kernel": float(best.loglik[0]),
            "aic": 4.0 - 2.0 * (float(best.loglik[0]) + constant),
        },
        **ends,
    )


def fit_maximum(ln_im: FloatArray, n: FloatArray, k: FloatArray, start: FloatArray) -> Maximum:
    """Fit a batch of probit curves: ``n`` and ``k`` of shape (R, J), shared intensities (J,)."""
    design = np.column_stack([np.ones_like(ln_im), ln_im])
    kernel = BinomialKernel(design, n, k)
    return maximise(kernel, np.tile(start, (k.shape[0], 1)), covariance=False)


def _what_is_known(
    status: str,
    ln_im: FloatArray,
    n: FloatArray,
    k: FloatArray,
    link: str,
    level: float,
    assumed_beta: float,
) -> dict[str, Any]:
    """Return the bounds that the data still give where no estimate exists."""
    percent = f"{100 * level:g}"
    low, high = existence.clopper_pearson(k, n, level)
    known: dict[str, Any] = {"p_lower": low.tolist(), "p_upper": high.tolist()}
    if status in (existence.NO_EXCEEDANCE, existence.ALL_EXCEED):
        side = "lower" if status == existence.NO_EXCEEDANCE else "upper"
        known["assumed_beta"] = assumed_beta
        known[f"theta_{side}{percent}_given_beta"] = {
            f"{beta:g}": existence.median_bound(
                ln_im, n, beta=beta, level=level, exceed=side == "upper"
            )
            for beta in sorted({0.3, 0.4, 0.6, assumed_beta})
        }
    if status == existence.SINGLE_LEVEL:
        total, exceed = float(np.sum(n)), float(np.sum(k))
        bounds = existence.clopper_pearson(np.array([exceed]), np.array([total]), level)
        known |= {
            "p": exceed / total,
            "p_ci": [float(bounds[0][0]), float(bounds[1][0])],
            "theta_given_beta": {
                f"{assumed_beta:g}": existence.single_level_median(
                    float(ln_im[0]), total, exceed, assumed_beta, link
                )
            },
        }
    if status in (existence.COMPLETE_SEPARATION, existence.QUASI_SEPARATION):
        hi0, lo1 = float(np.max(ln_im[n - k > 0.0])), float(np.min(ln_im[k > 0.0]))
        known["theta_interval"] = [float(np.exp(hi0)), float(np.exp(lo1))]
        known["theta_midpoint_log"] = float(np.exp(0.5 * (hi0 + lo1)))
        a0, a1 = existence.firth(ln_im, n, k, link)
        middle = predictor(0.5, link)
        known["firth"] = {"theta": float(np.exp((middle - a0) / a1)), "beta": 1.0 / a1}
    return known


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
    kernel: BinomialKernel, terms: Any, n: FloatArray, k: FloatArray
) -> dict[str, float | int]:
    """Return deviance, Pearson statistic and AIC; valid tests only for expected counts >= 1."""
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
    return {
        "deviance": float(deviance),
        "deviance_dof": dof,
        "deviance_p": float(special.chdtrc(dof, deviance)) if dof > 0 else float("nan"),
        "pearson": float(pearson),
    }


def _log_binomial(n: FloatArray, k: FloatArray) -> float:
    terms = special.gammaln(n + 1.0) - special.gammaln(k + 1.0) - special.gammaln(n - k + 1.0)
    return float(np.sum(terms))
