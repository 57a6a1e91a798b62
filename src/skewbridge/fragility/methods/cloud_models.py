"""Two extensions of the cloud whose curves are not lognormal: collapse, and scatter that varies.

Both report theta = x50 and beta = (ln x84 - ln x16)/2 of their curve (16 and 84 % exactly, for a
lognormal curve 0.9945 of its beta), and the curve itself.

References:
    Jalayer, Ebrahimian, Miano, Manfredi and Sezen (2017), EESD 46(15):2639-2663: modified cloud.
    Harvey (1976), Econometrica 44(3):461-465: multiplicative heteroscedasticity.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, special

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit, common_warnings, exp_end
from skewbridge.fragility.old_likelihood.intervals import normal_quantile
from skewbridge.fragility.old_likelihood.links import HALF_LOG_2PI, FloatArray, probability
from skewbridge.fragility.old_likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.old_likelihood.parts import CollapseFit, CurvePoints, LineFit, ScatterTrend
from skewbridge.fragility.old_likelihood.validate import as_column, require, same_length
from skewbridge.fragility.methods.cloud import cloud_columns, fit_line, line_warnings
from skewbridge.fragility.settings import DEFAULTS

_SEARCH: Final = 12.0  # half-width, in ln x, of the search for x16, x50, x84
_GRID: Final = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # of theta, for the table of the curve
_MIN_RUNS: Final = 10  # below, scatter that vanishes at one end makes the likelihood unbounded
_MAX_SPREAD: Final = 8.0  # of ln sigma over the runs; beyond, it does vanish


def fit_modified_cloud(
    im: ArrayLike,
    edp: ArrayLike,
    threshold: float,
    collapse: ArrayLike,
    *,
    level: float = DEFAULTS.confidence,
    collapse_link: str = "logit",
) -> FragilityFit:
    """Fit demand and collapse apart and join them: P = P(D > c | NC)(1 - Pc) + Pc.

    P(D > c | NC) = Phi[(ln a + b ln x - ln c)/s] by least squares on the runs without collapse, Pc
    a logistic (or probit) curve in ln x: five parameters.

    ``collapse`` is 1 where the run collapsed (its demand may be anything), ``collapse_link`` is
    logit (as published) or probit.

    Returns:
        The fit. The existence of the collapse curve is tested first: its status is returned where
        it does not exist (few collapses are usually separated).

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    flags = as_column(collapse, "collapse")
    require((flags == 0.0) | (flags == 1.0), "collapse", "must be 0 or 1", flags)
    same_length(im=np.asarray(im, dtype=object), collapse=flags)
    x, y, ln_c = cloud_columns(im, edp, threshold, flags)
    calm = flags == 0.0
    n = int(x.size)
    blank = FragilityFit(method="cloud_modified", status=FITTED, n_runs=n, level=level)
    if np.sum(calm) < 3 or np.ptp(x[calm]) == 0.0:
        return replace(blank, status=existence.too_little(x, 0))
    line = fit_line(x[calm], y[calm])
    status = existence.binomial_status(x, np.ones(n), flags)
    if status != FITTED or line.b <= 0.0:
        falling = line.b <= 0.0
        return replace(
            blank,
            status=existence.NON_INCREASING if falling else status,
            line=line,
            collapse=CollapseFit(part="demand" if falling else "collapse"),
        )
    design = np.column_stack([np.ones(n), x])
    best = maximise(BinomialKernel(design, np.ones(n), flags, collapse_link), np.zeros((1, 2)))
    alpha = best.params[0]
    if alpha[1] <= 0.0:
        return replace(
            blank, status=existence.NON_INCREASING, collapse=CollapseFit(part="collapse")
        )

    def curve(p: FloatArray, ln_x: FloatArray) -> FloatArray:
        demand = special.ndtr((p[0] + p[1] * ln_x - ln_c) / p[2])
        falls = probability(p[3] + p[4] * ln_x, collapse_link)
        return demand * (1.0 - falls) + falls

    params = np.array([line.ln_a, line.b, line.sigma, *alpha])
    covariance = np.zeros((5, 5))
    covariance[:3, :3] = _line_covariance(line.n, line.mean_x, line.sxx, line.sigma)
    covariance[3:, 3:] = best.covariance[0]
    sigma = line.sigma * np.sqrt((line.n - 2) / line.n)
    demand_loglik = -line.n * (HALF_LOG_2PI + np.log(sigma) + 0.5)
    fitted = FittedCurve(
        method="cloud_modified",
        curve=curve,
        params=params,
        covariance=covariance,
        loglik=demand_loglik + float(best.loglik[0]),
        warnings=(*line_warnings(line), "curve_not_lognormal"),
    )
    collapse_fit = CollapseFit(
        n_collapse=int(np.sum(flags)),
        collapse_a0=float(alpha[0]),
        collapse_a1=float(alpha[1]),
        collapse_link=collapse_link,
    )
    return replace(read_curve(fitted, x, level), line=line, collapse=collapse_fit)


def fit_heteroscedastic(
    im: ArrayLike, edp: ArrayLike, threshold: float, *, level: float = DEFAULTS.confidence
) -> FragilityFit:
    """Fit ln D ~ N(ln a + b ln x, sigma(x)^2) with ln sigma(x) = g0 + g1 ln x by likelihood.

    The likelihood-ratio statistic of g1 = 0 and its p-value stand in the ``scatter`` part; where
    g1 is not zero the curve Phi[(ln a + b ln x - ln c)/sigma(x)] is not lognormal.

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    x, y, ln_c = cloud_columns(im, edp, threshold)
    n = int(x.size)
    blank = FragilityFit(method="cloud_heteroscedastic", status=FITTED, n_runs=n, level=level)
    if n < _MIN_RUNS or np.ptp(x) == 0.0:
        return replace(blank, status=existence.too_little(x, _MIN_RUNS))
    found = _harvey(x, y)
    if found is None:
        return replace(blank, status="unbounded_likelihood")
    params, covariance, loglik, plain = found
    ratio = 2.0 * (loglik - plain)
    line = LineFit(ln_a=float(params[0]), b=float(params[1]))
    scatter = ScatterTrend(
        g0=float(params[2]),
        g1=float(params[3]),
        loglik_homoscedastic=plain,
        lr=ratio,
        lr_p=float(special.chdtrc(1, max(ratio, 0.0))),
    )
    if params[1] <= 0.0:
        return replace(blank, status=existence.NON_INCREASING, line=line, scatter=scatter)

    def curve(p: FloatArray, ln_x: FloatArray) -> FloatArray:
        return np.asarray(special.ndtr((p[0] + p[1] * ln_x - ln_c) / np.exp(p[2] + p[3] * ln_x)))

    def rising(p: FloatArray) -> tuple[float, float]:
        # the scatter overtakes the mean where ln a + b ln x - ln c = b/g1
        turn = (p[1] / p[3] - p[0] + ln_c) / p[1] if p[3] != 0.0 else np.inf
        middle = float((ln_c - p[0]) / p[1])
        low = max(middle - _SEARCH, float(turn)) if p[3] < 0.0 else middle - _SEARCH
        high = min(middle + _SEARCH, float(turn)) if p[3] > 0.0 else middle + _SEARCH
        return low, high

    fitted = FittedCurve(
        method="cloud_heteroscedastic",
        curve=curve,
        params=params,
        covariance=covariance,
        loglik=loglik,
        warnings=("curve_not_lognormal",),
        limits=rising,
    )
    return replace(read_curve(fitted, x, level), line=line, scatter=scatter)


def _harvey(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, float, float] | None:
    """Return (ln a, b, g0, g1), their covariance, the log-likelihood and that with g1 = 0.

    None where the scatter vanishes at one end, so that the likelihood has no maximum.
    """
    design = np.column_stack([np.ones_like(x), x])
    line, *_ = np.linalg.lstsq(design, y, rcond=None)
    residual = y - design @ line
    g = np.array([0.5 * np.log(np.mean(residual**2)), 0.0])
    plain = _loglik(residual, design @ g)
    gram = np.linalg.inv(design.T @ design)
    loglik = plain
    for _ in range(500):  # Fisher scoring; block-diagonal information
        if np.ptp(design @ g) > _MAX_SPREAD:
            return None
        weight = np.exp(-2.0 * (design @ g))
        line = np.linalg.solve((design.T * weight) @ design, (design.T * weight) @ y)
        residual = y - design @ line
        step = 0.5 * gram @ (design.T @ (residual**2 * weight - 1.0))
        factor = 1.0
        while _loglik(residual, design @ (g + factor * step)) < _loglik(residual, design @ g):
            factor *= 0.5
            if factor < 1e-6:
                break
        g = g + factor * step
        loglik = _loglik(residual, design @ g)
        if np.max(np.abs(step)) < 1e-13:
            break
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = np.linalg.inv((design.T * np.exp(-2.0 * (design @ g))) @ design)
    covariance[2:, 2:] = 0.5 * gram
    return np.concatenate([line, g]), covariance, loglik, plain


def _loglik(residual: FloatArray, ln_sigma: FloatArray) -> float:
    scaled = residual * np.exp(-ln_sigma)
    return float(-np.sum(0.5 * scaled**2 + ln_sigma + HALF_LOG_2PI))


def _line_covariance(n: int, mean_x: float, sxx: float, s: float) -> FloatArray:
    """Return the covariance of (ln a, b, s) of a least-squares line."""
    var_b = s**2 / sxx
    return np.array(
        [
            [s**2 / n + mean_x**2 * var_b, -mean_x * var_b, 0.0],
            [-mean_x * var_b, var_b, 0.0],
            [0.0, 0.0, s**2 / (2.0 * (n - 2))],
        ]
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedCurve:
    """A fitted curve P(exceed) of any shape, of p parameters and ln x.

    ``limits`` gives the range of ln x in which the curve rises, if that is not everywhere.
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

    ``x`` are the logarithms of the intensities.
    """
    curve, params = fitted.curve, fitted.params
    middle = float(np.mean(x))

    def quantiles(p: FloatArray) -> FloatArray | None:
        out: list[float] = []
        for share in (0.16, 0.5, 0.84):

            def excess(ln_x: float, share: float = share) -> float:
                return float(curve(p, np.array([ln_x]))[0]) - share

            low, high = fitted.limits(p) if fitted.limits else (middle - _SEARCH, middle + _SEARCH)
            if excess(low) * excess(high) > 0.0:
                return None
            out.append(float(optimize.brentq(excess, low, high, xtol=1e-12)))
        return np.array(out)

    blank = FragilityFit(method=fitted.method, status="curve_unbounded", n_runs=x.size, level=level)
    found = quantiles(params)
    if found is None or np.max(np.abs(found - middle)) > 2.0 * _SEARCH:
        return blank
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
    reach = [exp_end(z * float(np.sqrt(out[i, i])) / by) for i, by in enumerate((1, beta))]
    ci_theta = (theta / reach[0], theta * reach[0])
    grid = theta * np.array(_GRID)
    points = CurvePoints(
        x16=float(np.exp(found[0])),
        x50=theta,
        x84=float(np.exp(found[2])),
        curve_im=tuple(grid.tolist()),
        curve_p=tuple(curve(params, np.log(grid)).tolist()),
    )
    return replace(
        blank,
        status=FITTED,
        theta=theta,
        beta=float(beta),
        var_ln_theta=float(out[0, 0]),
        cov_ln_theta_beta=float(out[0, 1]),
        var_beta=float(out[1, 1]),
        ci_theta=ci_theta,
        ci_beta=(float(beta / reach[1]), float(beta * reach[1])),
        ci_method="delta",
        loglik=float(fitted.loglik),
        warnings=(*common_warnings(theta, ci_theta, np.exp(x), x.size), *fitted.warnings),
        points=points,
    )
