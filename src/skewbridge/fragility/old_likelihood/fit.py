"""The result of a fit: parameters, covariance, intervals, status and warnings."""

from dataclasses import dataclass, fields, replace
from math import inf, nan
from typing import Any, Final

import numpy as np

from skewbridge.fragility.old_likelihood.links import MAX_LOG, FloatArray
from skewbridge.fragility.old_likelihood.parts import (
    CollapseFit,
    CurvePoints,
    ExactIntervals,
    Goodness,
    LineFit,
    MedianBound,
    Part,
    Predictor,
    Proportions,
    RunCounts,
    ScatterTrend,
    Separation,
    SimulatedTests,
)
from skewbridge.fragility.old_likelihood.profile import ProfileEnds
from skewbridge.fragility.settings import DEFAULTS

#: Status of a fit that has an estimate (not the status of an analysis).
FITTED: Final = "ok"
WIDE_CI_RATIO: Final = 3.0
FEW_RECORDS: Final = 10
FEW_MIXED_STRIPES: Final = 3
# A curve with beta above 50 does not rise over any range of intensities.
FLATTEST_SLOPE: Final = 0.02
_ESTIMATE: Final = (
    "theta", "beta", "var_ln_theta", "cov_ln_theta_beta", "var_beta", "ci_theta", "ci_beta",
    "ci_method", "loglik",
)  # fmt: skip
_HEADLINE: Final = (
    "status", "theta", "beta", "se_ln_theta", "se_beta", "cov_ln_theta_beta", "ci_theta", "ci_beta",
    "ci_method", "level", "loglik", "n_runs", "method", "warnings",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class FragilityFit:
    """A lognormal fragility curve P = Phi(ln(x/theta)/beta), or the reason why there is none.

    Attributes:
        method: How it was fitted, for example ``stripes`` or ``cloud_ols``.
        status: ``ok``, or a status of `..likelihood.existence`; unless ``ok`` the
            parameters are NaN (a limit that is known, such as zero dispersion, excepted).
        theta: Median, in the unit of the intensity measure.
        beta: Dispersion of the logarithm.
        var_ln_theta: Variance of ln theta.
        cov_ln_theta_beta: Covariance of ln theta and beta.
        var_beta: Variance of beta.
        ci_theta: Ends of the interval of theta; 0 and infinity are unbounded ends.
        ci_beta: Ends of the interval of beta.
        ci_method: ``profile``, ``fieller``, ``record_bootstrap`` ...; empty without interval.
        level: Confidence level of the intervals.
        loglik: Log-likelihood at the maximum (with binomial coefficients).
        n_runs: Runs that entered the fit.
        warnings: Names of what a reader must know.
        line ... tests: What else the method gives, see `..likelihood.parts`; None if it does not.
    """

    method: str
    status: str
    theta: float = nan
    beta: float = nan
    var_ln_theta: float = nan
    cov_ln_theta_beta: float = nan
    var_beta: float = nan
    ci_theta: tuple[float, float] = (nan, nan)
    ci_beta: tuple[float, float] = (nan, nan)
    ci_method: str = ""
    level: float = DEFAULTS.confidence
    loglik: float = nan
    n_runs: int = 0
    warnings: tuple[str, ...] = ()
    line: LineFit | None = None
    predictor: Predictor | None = None
    goodness: Goodness | None = None
    bound: MedianBound | None = None
    separation: Separation | None = None
    proportions: Proportions | None = None
    exact: ExactIntervals | None = None
    collapse: CollapseFit | None = None
    scatter: ScatterTrend | None = None
    points: CurvePoints | None = None
    counts: RunCounts | None = None
    tests: SimulatedTests | None = None

    def without_estimate(self, status: str) -> "FragilityFit":
        """Return the fit with a status in place of median, dispersion and intervals."""
        blank = {item.name: item.default for item in fields(self) if item.name in _ESTIMATE}
        return replace(self, **(blank | {"status": status}))

    @property
    def se_ln_theta(self) -> float:
        """Standard error of ln theta."""
        return float(np.sqrt(self.var_ln_theta))

    @property
    def se_beta(self) -> float:
        """Standard error of beta."""
        return float(np.sqrt(self.var_beta))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of (ln theta, beta), shape (2, 2)."""
        off = self.cov_ln_theta_beta
        return np.array([[self.var_ln_theta, off], [off, self.var_beta]])

    def as_json(self) -> dict[str, Any]:
        """Return the object that `skewbridge fit --json` prints."""
        found: dict[str, Any] = {name: getattr(self, name) for name in _HEADLINE}
        for part in (getattr(self, item.name) for item in fields(self)):
            found |= part.as_json() if isinstance(part, Part) else {}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in found.items()}


def exp_end(value: float) -> float:
    """Return the exponential of the end of an interval, infinite where a double is too small."""
    return float(np.exp(value)) if value < MAX_LOG else float("inf")


def estimated(
    blank: FragilityFit,
    params: FloatArray,
    covariance: FloatArray,
    ends: ProfileEnds | None,
    spread: float = 1.0,
) -> FragilityFit:
    """Return a fit with median, dispersion, covariance and intervals filled in.

    The covariance of (a0, a1) is carried over to (ln theta, beta) by the delta method.

    ``params`` are (a0, a1) with ln theta = -a0/a1 and beta = spread/a1, a1 > 0; ``covariance`` is
    theirs, and ``spread`` is 1 for the probit link.
    """
    a0, a1 = (float(value) for value in params)
    jacobian = np.array([[-1.0 / a1, a0 / a1**2], [0.0, -spread / a1**2]])
    variance = jacobian @ covariance @ jacobian.T
    fit = replace(
        blank,
        theta=exp_end(-a0 / a1),
        beta=spread / a1,
        var_ln_theta=float(variance[0, 0]),
        cov_ln_theta_beta=float(variance[0, 1]),
        var_beta=float(variance[1, 1]),
    )
    if ends is None:
        return fit
    low, high = ends.slope
    return replace(
        fit,
        ci_theta=(exp_end(ends.ln_theta[0]), exp_end(ends.ln_theta[1])),
        ci_beta=(spread / high, spread / low if low > 0.0 else inf),
        ci_method="profile",
    )


def common_warnings(
    theta: float, ci_theta: tuple[float, float], im: FloatArray, n_records: int
) -> list[str]:
    """Return the warnings that every method shares.

    ``median_extrapolated``: theta outside the range of the intensities;
    ``wide_ci``: the ends of the interval differ by more than a factor of 3;
    ``fewer_than_10_records``.
    """
    found: list[str] = []
    if theta > np.max(im) or theta < np.min(im):
        found.append("median_extrapolated")
    low, high = ci_theta
    if not np.isnan(low) and not (low > 0.0 and high / low <= WIDE_CI_RATIO):
        found.append("wide_ci")
    if n_records < FEW_RECORDS:
        found.append("fewer_than_10_records")
    return found
