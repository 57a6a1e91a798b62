"""Fragility from a cloud of demands: log-log regression, its tests and Fieller's interval.

ln D = ln a + b ln x + e, s^2 = SSE/(n - 2); theta = exp((ln c - ln a)/b) and beta = s/b.

References:
    Cornell, Jalayer, Hamburger and Foutch (2002), J. Struct. Eng. 128(4):526-533.
    Fieller (1954), JRSS B 16(2):175-185, for the interval of a ratio.
    Koenker (1981), J. Econometrics 17(1):107-112, for the studentised Breusch-Pagan test.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit, common_warnings, exp_end
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.parts import LineFit
from skewbridge.fragility.old_likelihood.validate import as_column, positive, require, same_length
from skewbridge.fragility.settings import DEFAULTS, FitSettings

TEST_LEVEL = 0.05  # of the tests of curvature and of constant scatter
SATURATING = "saturating"
CURVED = "curved"
SLOPE_NOT_SIGNIFICANT = "slope_not_significant"


def fit_line(x: FloatArray, y: FloatArray) -> LineFit:
    """Fit the line to x = ln intensity (not constant) and y = ln demand, both of shape (n,)."""
    n = x.size
    u, v = x - np.mean(x), y - np.mean(y)
    sxx = float(u @ u)
    b = float(u @ v) / sxx
    residual = v - b * u
    sse = float(residual @ residual)
    s2 = sse / (n - 2) if n > 2 else float("nan")
    syy = float(v @ v)
    leverage = 1.0 / n + u**2 / sxx
    scale = s2 if s2 > 0.0 else 1.0
    cook = residual**2 / (2.0 * scale) * leverage / np.maximum((1.0 - leverage) ** 2, 1e-12)
    curvature, curvature_p = _curvature(u, residual, sse)
    return LineFit(
        ln_a=float(np.mean(y)) - b * float(np.mean(x)),
        b=b,
        sigma=float(np.sqrt(s2)),
        n=n,
        mean_x=float(np.mean(x)),
        sxx=sxx,
        r2=1.0 - sse / syy if syy > 0.0 else float("nan"),
        curvature=curvature,
        curvature_p=curvature_p,
        scatter_p=_breusch_pagan(u, residual),
        cook_max=float(np.max(cook)),
    )


def fit_cloud(
    im: ArrayLike,
    edp: ArrayLike,
    threshold: float,
    *,
    capacity_dispersion: float = 0.0,
    settings: FitSettings = DEFAULTS,
    n_records: int | None = None,
) -> FragilityFit:
    """Fit a fragility curve to a cloud of runs that all completed.

    Args:
        im: Intensities, shape (n,), positive.
        edp: Demands in the unit of ``threshold``, shape (n,), positive.
        threshold: Median capacity c.
        capacity_dispersion: Dispersion of the capacity; beta = sqrt(s^2 + dispersion^2)/b.
        settings: Confidence level.
        n_records: Motions behind the runs, if fewer than runs.

    Returns:
        The fit; theta with Fieller's interval, beta with a delta-method interval of its logarithm.
        Statuses: ``single_level`` (constant intensity), ``non_increasing`` (b <= 0),
        ``slope_not_significant`` (Fieller's set is unbounded), ``zero_dispersion``. Warnings name
        ``saturating`` or ``curved`` (curvature test), ``heteroscedastic`` (Breusch-Pagan).

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    x, y, ln_c = cloud_columns(im, edp, threshold)
    n = int(x.size)
    blank = FragilityFit(method="cloud_ols", status=FITTED, n_runs=n, level=settings.confidence)
    if n < 3 or np.ptp(x) == 0.0:
        return replace(blank, status=existence.too_little(x))
    line = fit_line(x, y)
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * settings.confidence))
    unfitted = replace(blank, line=line)
    if line.b <= 0.0:
        return replace(unfitted, status=existence.NON_INCREASING)
    if line.sigma <= 1e-12:
        return replace(unfitted, status="zero_dispersion")
    if line.b**2 <= t**2 * line.sigma**2 / line.sxx:
        return replace(unfitted, status=SLOPE_NOT_SIGNIFICANT)
    beta = float(np.hypot(line.sigma, capacity_dispersion)) / line.b
    ln_theta = (ln_c - line.ln_a) / line.b
    ends = fieller(line, ln_c, t)
    variance = _delta_covariance(line, ln_theta, beta)
    reach = t * np.sqrt(variance[2]) / beta
    theta = exp_end(ln_theta)
    ci_theta = (exp_end(ends[0]), exp_end(ends[1]))
    records = n if n_records is None else n_records
    warnings = common_warnings(theta, ci_theta, np.exp(x), records) + line_warnings(line)
    if np.max(y) <= ln_c:
        warnings.append("no_exceedance_observed")
    sigma = line.sigma * np.sqrt((n - 2) / n)  # maximum-likelihood value, for the log-likelihood
    return replace(
        unfitted,
        theta=theta,
        beta=beta,
        var_ln_theta=variance[0],
        cov_ln_theta_beta=variance[1],
        var_beta=variance[2],
        ci_theta=ci_theta,
        ci_beta=(float(beta * np.exp(-reach)), float(beta * np.exp(reach))),
        ci_method="fieller",
        loglik=-n * (0.5 * np.log(2.0 * np.pi) + np.log(sigma) + 0.5),
        warnings=tuple(warnings),
    )


def cloud_columns(
    im: ArrayLike, edp: ArrayLike, threshold: float, collapse: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, float]:
    """Return ln im, ln edp and ln threshold after checking them.

    Raises:
        InputError: Names the rows that are missing or not positive; the demand of a run flagged
            as collapse may be anything and becomes NaN if it is unusable.
    """
    x, d = positive(im, "im"), as_column(edp, "edp")
    same_length(im=x, edp=d)
    usable = np.isfinite(d) & (d > 0.0)
    flagged = np.zeros(d.size, dtype=np.bool_) if collapse is None else collapse > 0.0
    rule = "must be > 0 and finite for records not flagged as collapse"
    require(usable | flagged, "edp", rule, d)
    limit = as_column([threshold], "threshold")
    require(np.isfinite(limit) & (limit > 0.0), "threshold", "must be > 0 and finite", limit)
    return np.log(x), np.log(np.where(usable, d, np.nan)), float(np.log(limit[0]))


def fieller(line: LineFit, ln_c: float, t: float) -> tuple[float, float]:
    """Return Fieller's interval of ln theta; needs b^2 > t^2 s^2 / Sxx."""
    rise = ln_c - (line.ln_a + line.b * line.mean_x)
    a = line.b**2 - t**2 * line.sigma**2 / line.sxx
    half = line.b * rise
    constant = rise**2 - t**2 * line.sigma**2 / line.n
    root = float(np.sqrt(max(half**2 - a * constant, 0.0)))
    return line.mean_x + (half - root) / a, line.mean_x + (half + root) / a


def line_warnings(line: LineFit) -> list[str]:
    """Return the warnings of the tests of a straight line and of constant scatter."""
    found: list[str] = []
    if line.curvature_p < TEST_LEVEL:
        found.append(SATURATING if line.curvature < 0.0 else CURVED)
    if line.scatter_p < TEST_LEVEL:
        found.append("heteroscedastic")
    return found


def _delta_covariance(line: LineFit, ln_theta: float, beta: float) -> tuple[float, float, float]:
    """Return var ln theta, cov(ln theta, beta), var beta of the regression estimates."""
    away = ln_theta - line.mean_x
    var_b = line.sigma**2 / line.sxx
    relative = var_b / line.b**2
    var_ln_theta = line.sigma**2 / line.b**2 / line.n + relative * away**2
    # beta = sqrt(s^2 + c^2)/b: its derivative by s is s/(beta b^2), by b it is -beta/b
    var_s = line.sigma**2 / (2.0 * (line.n - 2))
    var_beta = (line.sigma / (beta * line.b**2)) ** 2 * var_s + beta**2 * relative
    return float(var_ln_theta), float(beta * relative * away), float(var_beta)


def _curvature(u: FloatArray, residual: FloatArray, sse: float) -> tuple[float, float]:
    """Return the coefficient of u^2 added to the line and the p-value of its F test."""
    n = u.size
    extra = u**2 - np.mean(u**2)
    extra = extra - (float(extra @ u) / float(u @ u)) * u
    size = float(extra @ extra)
    if n < 4 or size <= 1e-12 * float(u @ u) ** 2 or sse <= 0.0:
        return float("nan"), float("nan")
    coefficient = float(extra @ residual) / size
    explained = coefficient**2 * size
    left = max(sse - explained, 1e-300)
    return coefficient, float(special.fdtrc(1, n - 3, explained / (left / (n - 3))))


def _breusch_pagan(u: FloatArray, residual: FloatArray) -> float:
    squared = residual**2
    centred = squared - np.mean(squared)
    total = float(centred @ centred)
    if total <= 0.0:
        return float("nan")
    r2 = float(u @ centred) ** 2 / (float(u @ u) * total)
    return float(special.chdtrc(1, u.size * r2))
