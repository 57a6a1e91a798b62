"""Median, dispersion and intervals of a curve that is not lognormal, read off the curve itself."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import optimize

from skewbridge.fragility.likelihood.fit import FITTED, FragilityFit, common_warnings, exp_end
from skewbridge.fragility.likelihood.intervals import normal_quantile
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.parts import CurvePoints

SEARCH: Final = 12.0  # half-width, in ln x, of the search for x16, x50, x84
_GRID: Final = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # of theta, for the table of the curve


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedCurve:
    """A fitted curve of any shape.

    Attributes:
        method: Name of the method.
        curve: P(exceed) of (parameters, ln x).
        params: Fitted parameters, shape (p,).
        covariance: Their covariance, shape (p, p).
        loglik: Log-likelihood at the fit.
        warnings: Warnings to keep.
        limits: Range of ln x in which the curve rises, if that is not everywhere.
    """

    method: str
    curve: Callable[[FloatArray, FloatArray], FloatArray]
    params: FloatArray
    covariance: FloatArray
    loglik: float
    warnings: tuple[str, ...] = ()
    limits: Callable[[FloatArray], tuple[float, float]] | None = None


def read_curve(fitted: FittedCurve, x: FloatArray, level: float) -> FragilityFit:
    """Read x16, x50, x84 off a curve and carry the covariance of its parameters over numerically.

    Args:
        fitted: The curve.
        x: Logarithms of the intensities.
        level: Confidence level of the delta-method intervals.
    """
    curve, params = fitted.curve, fitted.params
    middle = float(np.mean(x))

    def quantiles(p: FloatArray) -> FloatArray | None:
        out: list[float] = []
        for share in (0.16, 0.5, 0.84):

            def excess(ln_x: float, share: float = share) -> float:
                return float(curve(p, np.array([ln_x]))[0]) - share

            low, high = fitted.limits(p) if fitted.limits else (middle - SEARCH, middle + SEARCH)
            if excess(low) * excess(high) > 0.0:
                return None
            out.append(float(optimize.brentq(excess, low, high, xtol=1e-12)))
        return np.array(out)

    found = quantiles(params)
    if found is None or np.max(np.abs(found - middle)) > 2.0 * SEARCH:
        return FragilityFit(
            method=fitted.method, status="curve_unbounded", n_runs=x.size, level=level
        )
    to_pair = np.array([[0.0, 1.0, 0.0], [-0.5, 0.0, 0.5]])
    ln_theta, beta = to_pair @ found
    jacobian = np.zeros((2, params.size))
    for j in range(params.size):
        step = 1e-5 * max(abs(float(params[j])), 1e-2)
        ends = []
        for sign in (1.0, -1.0):
            moved = params.copy()
            moved[j] += sign * step
            shifted = quantiles(moved)
            ends.append(to_pair @ (found if shifted is None else shifted))
        jacobian[:, j] = (ends[0] - ends[1]) / (2.0 * step)
    out = jacobian @ fitted.covariance @ jacobian.T
    z = normal_quantile(level)
    theta = float(np.exp(ln_theta))
    reach = [
        exp_end(z * float(np.sqrt(v)) / by) for v, by in zip(np.diag(out), (1, beta), strict=True)
    ]
    ci_theta = (theta / reach[0], theta * reach[0])
    grid = theta * np.array(_GRID)
    points = CurvePoints(
        x16=float(np.exp(found[0])),
        x50=theta,
        x84=float(np.exp(found[2])),
        curve_im=tuple(grid.tolist()),
        curve_p=tuple(curve(params, np.log(grid)).tolist()),
    )
    return FragilityFit(
        method=fitted.method,
        status=FITTED,
        theta=theta,
        beta=float(beta),
        var_ln_theta=float(out[0, 0]),
        cov_ln_theta_beta=float(out[0, 1]),
        var_beta=float(out[1, 1]),
        ci_theta=ci_theta,
        ci_beta=(float(beta / reach[1]), float(beta * reach[1])),
        ci_method="delta",
        level=level,
        loglik=float(fitted.loglik),
        n_runs=int(x.size),
        warnings=(*common_warnings(theta, ci_theta, np.exp(x), x.size), *fitted.warnings),
        points=points,
    )
