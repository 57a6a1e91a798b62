"""Cloud regression in which some demands are known only to exceed a value (Tobit).

References:
    Tobin (1958), Econometrica 26(1):24-36; Martins and Silva (2021), Bulletin of
    Earthquake Engineering 19, for its use with a cloud of demands.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import Replicates
from skewbridge.fragility.old_likelihood.censored import CensoredKernel
from skewbridge.fragility.old_likelihood.fit import (
    FITTED,
    FLATTEST_SLOPE,
    FragilityFit,
    common_warnings,
    estimated,
)
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.newton import Derivatives, Kernel, Restricted, maximise
from skewbridge.fragility.old_likelihood.parts import LineFit, RunCounts
from skewbridge.fragility.old_likelihood.profile import profile_ends, student_quantile
from skewbridge.fragility.old_likelihood.validate import as_column, positive, same_length
from skewbridge.fragility.methods.cloud import cloud_columns
from skewbridge.fragility.settings import DEFAULTS, FitSettings


class ProfiledKernel:
    """A kernel of (a0, a1, h) with h maximised out: a concave kernel of (a0, a1)."""

    def __init__(self, kernel: Kernel, start: float) -> None:
        self._kernel, self._start = kernel, np.array([[start]])

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate at the best h; the Hessian is the Schur complement of its entry."""
        if self._start.shape != (params.shape[0], 1):
            self._start = np.full((params.shape[0], 1), self._start[0, 0])
        base = np.hstack([params, np.zeros_like(self._start)])
        along = Restricted(self._kernel, base, np.eye(3)[2:])
        best = maximise(along, self._start, covariance=False)
        self._start = best.params  # parameters that follow are close to these
        full = self._kernel.derivatives(np.hstack([params, best.params]))
        cross = full.hessian[:, :2, 2]
        schur = cross[:, :, None] * cross[:, None, :] / full.hessian[:, 2, 2][:, None, None]
        return Derivatives(full.loglik, full.score[:, :2], full.hessian[:, :2, :2] - schur)


def fit_tobit(
    im: ArrayLike,
    edp: ArrayLike,
    threshold: float,
    upper: ArrayLike | None = None,
    *,
    capacity_dispersion: float = 0.0,
    settings: FitSettings = DEFAULTS,
    interval: bool = True,
) -> FragilityFit:
    """Fit the log-log line by maximum likelihood with demands censored on the right.

    l = sum over observed [ln phi(z) - ln sigma] + sum over censored ln Phi(-z),
    z = (ln D - ln a - b ln x)/sigma. The parameters are a0 = (ln a - ln c)/sigma,
    a1 = b/sigma and h = 1/sigma, so that theta = exp(-a0/a1) and beta = 1/a1. The intervals are of
    the profile with Student's t(n - 2), n the observed demands (`student_quantile`): without
    censoring that of theta is Fieller's.

    Args:
        im: Intensities, shape (n,).
        edp: Demands; of censored runs the value they are known to exceed.
        threshold: Median capacity c, in the unit of ``edp``.
        upper: Upper end of each demand: above ``edp`` (infinity) where it is known only to exceed
            that value, equal to it where it was observed. None: all observed.
        capacity_dispersion: Dispersion of the capacity; beta = sqrt(sigma^2 + dispersion^2)/b.
        settings: Confidence level of the profile intervals.
        interval: False leaves out the profile intervals.

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    x, y, ln_c = cloud_columns(im, edp, threshold)
    top = y if upper is None else np.log(np.asarray(upper, dtype=np.float64))
    if top.size != x.size:
        raise InputError(
            f"upper needs {x.size} rows, got {top.size}", row=min(top.size, x.size), column="upper"
        )
    n, seen = int(x.size), top == y
    blank = FragilityFit(method="cloud_tobit", status=FITTED, n_runs=n, level=settings.confidence)
    if np.sum(seen) < 3 or np.ptp(x[seen]) == 0.0:
        return replace(blank, status=existence.too_little(x))
    kernel = CensoredKernel(np.column_stack([np.ones(n), x]), y - ln_c, top - ln_c)
    best = maximise(kernel, _start(x, y, seen, ln_c))
    a0, a1, h = (float(value) for value in best.params[0])
    if not bool(best.converged[0]):
        return replace(blank, status=existence.NOT_CONVERGED)
    blank = replace(
        blank,
        line=LineFit(ln_a=a0 / h + ln_c, b=a1 / h, sigma=1.0 / h),
        counts=RunCounts(n_censored=int(np.sum(~seen))),
    )
    if a1 <= FLATTEST_SLOPE:
        return replace(blank, status=existence.NON_INCREASING)
    widen = float(np.sqrt(1.0 + (h * capacity_dispersion) ** 2))
    ends = None
    if interval:
        profiled = ProfiledKernel(kernel, h)
        reduced = maximise(profiled, best.params[:, :2])
        drop = student_quantile(int(np.sum(seen)), settings.confidence)
        level_only = Restricted(profiled, np.zeros(2), np.eye(2)[:1])
        flat = maximise(level_only, np.array([[0.0]]), covariance=False).params[0, 0]
        ends = profile_ends(profiled, reduced, drop, float(flat))
    fit = estimated(blank, best.params[0][:2], best.covariance[0][:2, :2], ends, widen)
    warnings = common_warnings(fit.theta, fit.ci_theta, np.exp(x), n)
    return replace(fit, loglik=float(best.loglik[0]), warnings=tuple(warnings))


def censored_cloud(
    im: ArrayLike,
    edp: ArrayLike,
    censored: ArrayLike | None = None,
    *,
    above: float | None = None,
    discard_below: float | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return intensities, demands and their upper ends for `fit_tobit`.

    Args:
        im: Intensities, shape (n,).
        edp: Demands; of censored runs the value they are known to exceed.
        censored: 1 where the demand is known only to exceed ``edp``.
        above: Also censor demands at or above this value, at this value.
        discard_below: Drop runs with a demand below this value. Off by default: it selects on the
            response, and biases the slope.

    Raises:
        InputError: The columns differ in length, or a value is not positive.
    """
    x, demand = positive(im, "im"), positive(edp, "edp")
    flags = np.zeros(x.size) if censored is None else as_column(censored, "censored")
    same_length(im=x, edp=demand, censored=flags)
    top = np.where(flags > 0.0, np.inf, demand)
    kept = demand >= (0.0 if discard_below is None else discard_below)
    x, demand, top = x[kept], demand[kept], top[kept]
    if above is not None:
        high = demand >= above
        demand, top = np.where(high, above, demand), np.where(high, np.inf, top)
    return x, demand, top


def refit_tobit(
    im: FloatArray, edp: FloatArray, threshold: float, upper: FloatArray, weights: FloatArray
) -> Replicates:
    """Fit R weighted replicates at once.

    ``edp`` of censored runs is the value that they exceed, ``upper`` equals it where observed,
    shape (n,); ``weights`` is how often each run enters each replicate, shape (R, n).
    """
    x, y, top, ln_c = np.log(im), np.log(edp), np.log(upper), float(np.log(threshold))
    design = np.column_stack([np.ones(x.size), x])
    kernel = CensoredKernel(design, y - ln_c, top - ln_c, weights)
    start = np.tile(_start(x, y, top == y, ln_c), (weights.shape[0], 1))
    best = maximise(kernel, start, covariance=False)
    a0, a1, h = best.params.T
    good = best.converged & (a1 > FLATTEST_SLOPE)
    with np.errstate(all="ignore"):
        theta = np.where(good, np.exp(-a0 / a1), np.inf)
        beta = np.where(good, 1.0 / a1, np.inf)
    separated = float(1.0 - np.mean(good))
    return Replicates(theta=theta, beta=beta, separated=separated, slope=a1 / h)


def _start(x: FloatArray, y: FloatArray, seen: NDArray[np.bool_], ln_c: float) -> FloatArray:
    """Return (a0, a1, h) of the line through the observed runs."""
    slope, intercept = np.polyfit(x[seen], y[seen], 1)
    h = 1.0 / max(float(np.std(y[seen] - intercept - slope * x[seen])), 1e-3)
    return np.array([[h * (intercept - ln_c), h * slope, h]])
