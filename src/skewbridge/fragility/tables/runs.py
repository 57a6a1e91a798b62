"""The runs of one variant, and what unknown outcomes do to its fits."""

from dataclasses import dataclass, replace
from math import inf
from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.likelihood.bootstrap import Replicates
from skewbridge.fragility.likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.outcomes import Outcomes

MAX_UNKNOWN_SHARE: Final = 0.05
# ASSUME a median is worth printing if unknown outcomes can move it by 15 % at most.
MAX_BOUNDS_RATIO: Final = 1.15  # of the medians when unknown outcomes all, or none, exceed
BOUNDS_TOO_WIDE: Final = "bounds_too_wide"


@dataclass(frozen=True, slots=True, kw_only=True)
class Runs:
    """The runs of one variant, arrays of shape (n,).

    Attributes:
        im: Intensity of each run.
        status: Its status.
        records: Number of its motion, 0 .. m - 1.
    """

    im: FloatArray
    status: NDArray[np.str_]
    records: NDArray[np.intp]

    @property
    def repeated(self) -> bool:
        """Whether some motion ran more than once."""
        return int(np.max(self.records)) + 1 < self.records.size


def bootstrapped(fit: FragilityFit, again: Replicates) -> FragilityFit:
    """Replace interval and covariance by those of the replicates that have an estimate."""
    theta, beta = again.theta, again.beta
    ci_theta, ci_beta = again.intervals(fit.level)
    good = np.isfinite(theta) & (theta > 0.0) & np.isfinite(beta)
    lacking = float(1.0 - np.mean(good & (beta > 0.0)))
    covariance = np.cov(np.log(theta[good]), beta[good])
    extra = ("bootstrap_without_estimate",) if lacking > MAX_UNKNOWN_SHARE else ()
    return replace(
        fit,
        ci_theta=ci_theta,
        ci_beta=ci_beta,
        ci_method="record_bootstrap",
        var_ln_theta=float(covariance[0, 0]),
        cov_ln_theta_beta=float(covariance[0, 1]),
        var_beta=float(covariance[1, 1]),
        warnings=(*fit.warnings, *extra),
    )


def judge_unknown(
    fit: FragilityFit,
    bounds: dict[str, FragilityFit],
    outcomes: Outcomes,
    settings: FitSettings,
) -> tuple[FragilityFit, dict[str, float]]:
    """Attach the three fits and refuse a headline number that unknown outcomes decide."""
    numbers: dict[str, float] = {}
    for name, bound in bounds.items():
        numbers[f"theta_{name}"], numbers[f"beta_{name}"] = bound.theta, bound.beta
    share = float(np.mean(outcomes.unknown))
    if share == 0.0:
        return fit, numbers
    warnings = [*fit.warnings, "unknown_outcomes"]
    if share > MAX_UNKNOWN_SHARE:
        warnings.append("unknown_above_5_percent")
    fit = replace(fit, warnings=tuple(warnings))
    if fit.status != FITTED:
        return fit, numbers
    pair = (bounds["all_exceed"].theta, bounds["none_exceed"].theta)
    ratio = max(pair) / min(pair) if all(np.isfinite(pair)) else inf
    if ratio > MAX_BOUNDS_RATIO and not settings.accept_bounds:
        fit = fit.without_estimate(BOUNDS_TOO_WIDE)
    return fit, numbers
