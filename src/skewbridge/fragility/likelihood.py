"""Normal likelihood of observed, left-, right- and interval-censored values, and its maximum.

`NormalKernel` serves every fit: a cloud with censored demands (Tobit), capacities from incremental
analysis, brackets of capacities, and counts of exceedance (the capacity of a run is below its
intensity if the run exceeds, else above it). Every term is concave: a maximum is unique.

Sources: the parameterisation, z = h y - X delta with h = 1/sigma, Olsen (1978), Econometrica 46(5);
censored regression, Tobin (1958), Econometrica 26(1):24-36.
"""

from typing import Final, NamedTuple

import numpy as np
from scipy import special

from skewbridge.files.tables import Floats, Index, Mask

HALF_LOG_2PI: Final = 0.5 * np.log(2.0 * np.pi)
_SQRT_2_OVER_PI: Final = np.sqrt(2.0 / np.pi)
_DECREMENT_TOLERANCE: Final = 1e-10  # the last Newton step leaves about its square
_MAX_ITERATIONS: Final = 80
_MAX_HALVINGS: Final = 40
_PROFILE_TOLERANCE: Final = 1e-11


def mills_ratio(eta: Floats) -> Floats:
    """Return phi/Phi(eta) as sqrt(2/pi)/erfcx(-eta/sqrt 2), without underflow or cancellation."""
    return np.asarray(_SQRT_2_OVER_PI / special.erfcx(-eta / np.sqrt(2.0)))


def log_normal_tail(eta: Floats) -> tuple[Floats, Floats]:
    """Return ln Phi(eta) and phi/Phi(eta); the error function is evaluated only once."""
    ratio = mills_ratio(eta)
    with np.errstate(divide="ignore"):
        log_p = np.where(ratio > 0.0, -0.5 * eta * eta - HALF_LOG_2PI - np.log(ratio), 0.0)
    return log_p, ratio


def log_normal_interval(lower: Floats, upper: Floats) -> Floats:
    """Return ln[Phi(upper) - Phi(lower)] without cancellation; -inf where ``upper <= lower``."""
    sign = np.copysign(1.0, -lower)  # an interval above zero is mirrored
    a, b = np.minimum(sign * lower, sign * upper), np.maximum(sign * lower, sign * upper)
    log_cdf_a, log_cdf_b = special.log_ndtr(a), special.log_ndtr(b)
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = log_cdf_b + np.log(-np.expm1(np.minimum(log_cdf_a - log_cdf_b, 0.0)))
    return np.where(upper > lower, inside, -np.inf)


class Derivatives(NamedTuple):
    """Log-likelihood at R parameter vectors with its first and second derivatives."""

    loglik: Floats  # shape (R,), minus infinity outside the parameter space
    score: Floats  # shape (R, p)
    hessian: Floats  # shape (R, p, p)


def row_products(first: Floats, second: Floats) -> Floats:
    """Return the outer product of each pair of rows of two (J, p) arrays, shape (J, p p)."""
    return (first[:, :, None] * second[:, None, :]).reshape(-1, first.shape[1] ** 2)


class NormalKernel:
    """Log-likelihood: sum of ln f(y) over observed rows and ln P(lower <= Y <= upper) over others.

    The parameters are (delta_1..delta_q, h). Y has the mean X delta/h and the standard deviation
    1/h. Each observed row adds ln h (Jacobian), without which h would have no maximum; with
    observed rows, the log-likelihood is minus infinity for h <= 0. If X is a column of -1, the
    parameters are (a0, a1) with z = a0 + a1 y.
    """

    def __init__(
        self,
        covariates: Floats,  # X, shape (n, q)
        lower: Floats,  # lower bounds of Y, shape (n,); minus infinity if left-censored
        upper: Floats,  # upper bounds; equal to `lower` if observed, infinity if right-censored
        weights: Floats | None = None,  # shape (n,), or (R, n) for R replicates
        upper_covariates: Floats | None = None,  # X of upper bounds, if different; none observed
    ) -> None:
        self.weights = np.ones(lower.size) if weights is None else weights
        upper_x = covariates if upper_covariates is None else upper_covariates
        is_observed = (lower == upper) & (upper_covariates is None)
        has_low, has_high = np.isfinite(lower) & ~is_observed, np.isfinite(upper) & ~is_observed
        low, high = np.column_stack([-covariates, lower]), np.column_stack([-upper_x, upper])
        only_hi, only_low = np.flatnonzero(has_low & ~has_high), np.flatnonzero(has_high & ~has_low)
        #: Design of the rows with one finite bound, negated if right-censored, and its products.
        self._tail = np.vstack([-low[only_hi], high[only_low]])
        self._tail_tail = row_products(self._tail, self._tail)
        self._w_tail = self.weights[..., np.append(only_hi, only_low)]
        between = np.flatnonzero(has_low & has_high)
        self._w_between = self.weights[..., between]
        self._low, self._high = low[between], high[between]
        self._low_low, self._high_high = (row_products(x, x) for x in (self._low, self._high))
        self._cross = row_products(self._low, self._high) + row_products(self._high, self._low)
        self._any_observed = bool(is_observed.any())
        # z = (-x, residual of y about a line) @ onto @ params: residuals avoid cancellation
        x, y, w = covariates[is_observed], lower[is_observed], self.weights[..., is_observed]
        line = np.linalg.lstsq(x, y)[0] if y.size else np.zeros(x.shape[1])
        self._onto = np.eye(line.size + 1)
        self._onto[:-1, -1] = -line
        rows = np.column_stack([-x, y - x @ line])
        self._count, sums = np.sum(w, axis=-1), w @ row_products(rows, rows)
        self._sums = sums.reshape(*w.shape[:-1], line.size + 1, line.size + 1)

    def derivatives(self, params: Floats, rows: Index | None = None) -> Derivatives:
        """Return log-likelihoods and derivatives of replicates ``rows`` (or all) at ``params``."""
        shape, weights = params.shape, [self._w_tail, self._w_between, self._sums, self._count]
        if self.weights.ndim == 2 and rows is not None:
            weights = [values[rows] for values in weights]
        w_tail, w_between, sums, count = weights
        h = params[:, -1]
        loglik, score, hessian = np.zeros(shape[0]), np.zeros(shape), np.zeros((*shape, shape[1]))
        if self._any_observed:
            safe_h = np.where(h > 0.0, h, 1.0)
            projected = params @ self._onto.T
            product = np.einsum("...ij,...j->...i", sums, projected)
            loglik += count * (np.log(safe_h) - HALF_LOG_2PI) - 0.5 * np.sum(projected * product, 1)
            score -= product @ self._onto
            score[:, -1] += count / safe_h
            hessian -= self._onto.T @ sums @ self._onto
            hessian[:, -1, -1] -= count / safe_h**2
        if len(self._tail):
            u = params @ self._tail.T
            log_p, ratio = log_normal_tail(u)
            loglik += np.sum(w_tail * log_p, axis=1)
            score += (w_tail * ratio) @ self._tail
            hessian -= ((w_tail * (ratio * (u + ratio))) @ self._tail_tail).reshape(hessian.shape)
        if len(self._low):
            zu, zl = params @ self._high.T, params @ self._low.T
            log_p = log_normal_interval(zl, zu)
            log_terms, scale = log_p, -log_p
            if not (possible := np.isfinite(log_p)).all():
                # parameters that give a bracket no probability get minus infinity
                log_terms = np.where(w_between > 0.0, log_p, 0.0)
                scale = np.where(possible, scale, -np.inf)
            pu, pl = (np.exp(scale - 0.5 * z * z - HALF_LOG_2PI) for z in (zu, zl))
            loglik += np.sum(w_between * log_terms, axis=1)
            score += (w_between * pu) @ self._high - (w_between * pl) @ self._low
            curvature = (w_between * (pl * (zl - pl))) @ self._low_low
            curvature += (w_between * (pu * pl)) @ self._cross
            curvature -= (w_between * (pu * (zu + pu))) @ self._high_high
            hessian += curvature.reshape(hessian.shape)
        if self._any_observed:
            loglik = np.where(h > 0.0, loglik, -np.inf)
        return Derivatives(loglik, score, hessian)


class Maximum(NamedTuple):
    """Maxima of a batch of R log-likelihoods."""

    params: Floats  # shape (R, p)
    loglik: Floats  # shape (R,)
    covariance: Floats  # inverse observed information, shape (R, p, p); NaN where singular
    converged: Mask  # shape (R,)


def _newton_step(hessian: Floats, score: Floats) -> Floats:
    """Return the Newton steps of a batch; a step is zero if its Hessian is singular."""
    try:
        step = np.linalg.solve(-hessian, score[..., None])[..., 0]
    except np.linalg.LinAlgError:
        step = np.zeros_like(score)
        regular = np.linalg.det(hessian) != 0.0
        step[regular] = np.linalg.solve(-hessian[regular], score[regular][..., None])[..., 0]
    return np.where(np.isfinite(step).all(axis=1, keepdims=True), step, 0.0)


def maximise(kernel: "NormalKernel | _Profiles", start: Floats) -> Maximum:
    """Maximise R concave log-likelihoods from ``start`` (R, p) by Newton steps with halving."""
    params = np.array(start, dtype=np.float64)
    active = np.arange(len(params))
    converged = np.zeros(active.size, dtype=np.bool_)
    current = kernel.derivatives(params, active)
    loglik, hessian = current.loglik.copy(), current.hessian.copy()
    for _ in range(_MAX_ITERATIONS):
        step = _newton_step(current.hessian, current.score)
        decrement = np.sum(step * current.score, axis=1)
        is_done = (decrement < _DECREMENT_TOLERANCE) & (decrement >= 0.0)
        required = current.loglik - 1e-12 * (1.0 + np.abs(current.loglik))
        trial = kernel.derivatives(params[active] + step, active)
        failed = np.flatnonzero(~(trial.loglik >= required))
        for _ in range(_MAX_HALVINGS):
            if failed.size == 0:
                break
            step[failed] *= 0.5
            halved = kernel.derivatives(params[active[failed]] + step[failed], active[failed])
            for values, halved_values in zip(trial, halved, strict=True):
                values[failed] = halved_values
            failed = failed[~(halved.loglik >= required[failed])]
        step[failed] = 0.0
        params[active] += step
        loglik[active], hessian[active] = trial.loglik, trial.hessian
        converged[active] = is_done & np.isfinite(trial.loglik)
        is_done[failed] = True
        active = active[~is_done]
        if active.size == 0:
            break
        current = Derivatives(*(values[~is_done] for values in trial))
    inverse = np.full_like(hessian, np.nan)
    with np.errstate(all="ignore"):
        is_regular = np.linalg.det(-hessian) > 0.0
    inverse[is_regular] = np.linalg.inv(-hessian[is_regular])
    return Maximum(params, loglik, inverse, converged)


def drop_of(level: float, n: int | None = None) -> float:
    """Return the drop of twice the log-likelihood at the ends of a profile interval.

    Without ``n`` it is the large-sample value (chi-square). With ``n`` it is the exact value for a
    coefficient of a line through n demands with estimated scatter.
    """
    if n is None:
        return float(special.chdtri(1.0, 1.0 - level))
    # 2 [l_max - l_profile] = n ln(1 + t^2/(n - 2)) is exact for least squares
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * level))
    return n * float(np.log1p(t**2 / (n - 2)))


def profile_ends(
    kernel: NormalKernel, maximum: Maximum, drop: float, intercepts: Floats, slope: int = 1
) -> Floats:
    """Return the profile intervals {psi: 2 [l_max - l_profile(psi)] <= drop}, shape (J + 1, 2).

    The first J rows are the intervals of ln theta of the states, the last row is the interval of
    the common beta = 1/a1. Ends that the data do not bound are infinite. The predictor of a state
    is params @ intercept + a1 ln x, so ln theta = -params @ intercept/a1; ``intercepts`` (J, p) are
    0 at the position ``slope`` of a1. All ends are found together by bracketed Newton's method.
    """
    params, a1 = maximum.params[0], float(maximum.params[0, slope])
    profiles = _Profiles(kernel, params, intercepts, slope)
    target = float(maximum.loglik[0]) - 0.5 * drop
    middles = np.append(-intercepts @ params / a1, np.log(a1))
    gradients = np.vstack([-intercepts, np.eye(params.size)[slope]]) / a1
    gradients[:-1, slope] = -middles[:-1] / a1
    variance = np.einsum("kp,pq,kq->k", gradients, maximum.covariance[0], gradients)
    width = np.sqrt(drop * np.where(np.isfinite(variance) & (variance > 0.0), variance, 0.01))
    width[-1] = min(width[-1], 2.0)
    side, centre = np.tile([-1.0, 1.0], middles.size), np.repeat(middles, 2)
    # ASSUME an end farther than this from the estimate of ln theta or ln beta is unbounded
    limit = np.repeat([*np.full(len(intercepts), 40.0 / a1 + 20.0), 30.0], 2)
    offset = np.minimum(np.repeat(width, 2), limit)  # distance from the maximum
    low, high = np.zeros(offset.size), np.full(offset.size, np.inf)  # bracket of the end
    is_unbounded = np.zeros(offset.size, dtype=np.bool_)
    for _ in range(_MAX_ITERATIONS):
        loglik, rate = profiles.evaluate(centre + side * offset)
        value = loglik - target
        is_inside = value > 0.0
        is_unbounded = is_inside & (offset == limit)
        if np.all(is_done := is_unbounded | (np.abs(value) < _PROFILE_TOLERANCE)):
            break
        low, high = np.where(is_inside, offset, low), np.where(is_inside, high, offset)
        # the root of the drop is nearly linear in psi
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(drop - 2.0 * value, 0.0))
            newton = offset + (root - np.sqrt(drop)) * root / (side * rate)
        newton = np.where(newton > low, np.minimum(newton, np.minimum(3.0 * offset, limit)), np.nan)
        between = np.where(np.isfinite(high), 0.5 * (low + high), np.minimum(2.0 * offset, limit))
        offset = np.where(is_done, offset, np.where(newton < high, newton, between))
    ends = np.where(is_unbounded, side * np.inf, centre + side * offset).reshape(-1, 2)
    ends[-1] = np.exp(-ends[-1, ::-1])
    return ends


class _Profiles:
    """Profile likelihoods of ln theta of J states and of ln a1, two rows each (both ends)."""

    # Each row maximises the log-likelihood under one constraint, normal @ params = right. The
    # constraint determines one parameter (its factor in `normal` is 1); the others are free.

    def __init__(self, kernel: NormalKernel, best: Floats, intercepts: Floats, slope: int) -> None:
        self._kernel, self._slope, self._eye = kernel, slope, np.eye(best.size)
        slope_axis = self._eye[slope]
        self._normals = np.vstack([np.repeat(intercepts, 2, axis=0), slope_axis, slope_axis])
        self._determined = self._eye[np.argmax(self._normals == 1.0, axis=1)]
        # moving along these directions (all intercepts equally, or the slope) satisfies any
        # constraint at a finite likelihood
        shift = np.any(intercepts == 1.0, axis=0).astype(np.float64)
        self._shifts = np.vstack([np.tile(shift, (2 * len(intercepts), 1)), slope_axis, slope_axis])
        self._params = np.tile(best, (len(self._normals), 1))
        self._score = np.empty_like(self._params)

    def derivatives(self, params: Floats, rows: Index) -> Derivatives:
        """Return log-likelihoods and derivatives by free ``params`` for interval ends ``rows``."""
        onto = self._onto[rows]
        full = self._kernel.derivatives(self._offset[rows] + (onto @ params[:, :, None])[..., 0])
        self._score[rows] = full.score
        score = (full.score[:, None, :] @ onto)[:, 0]
        hessian = np.swapaxes(onto, 1, 2) @ full.hessian @ onto
        return Derivatives(full.loglik, score, hessian - self._fixed[rows])

    def evaluate(self, psi: Floats) -> tuple[Floats, Floats]:
        """Return the profile log-likelihoods at ``psi`` and their derivatives, (rows,) each."""
        normals, right_side = self._normals, np.zeros(psi.size)
        normals[:-2, self._slope] = psi[:-2]
        right_side[-2:] = np.exp(psi[-2:])
        self._offset = right_side[:, None] * self._determined
        self._onto = self._eye - self._determined[:, :, None] * normals[:, None, :]
        start = self._shifted(right_side)
        while True:
            # a unit Hessian for parameters that are not free keeps the matrix regular
            self._fixed = ~np.any(self._onto, axis=1)[:, :, None] * self._eye
            maximum = maximise(self, start)
            self._params = self._offset + (self._onto @ maximum.params[:, :, None])[..., 0]
            is_falling = self._params[:, self._slope] < 0.0
            if not np.any(is_falling):
                break
            # falling curves are excluded: hold the slope at zero, its limit
            self._onto[is_falling, :, self._slope] = self._params[is_falling, self._slope] = 0.0
            start = self._shifted(right_side)
        rate = -np.sum(self._determined * self._score, axis=1) * self._params[:, self._slope]
        rate[-2:] *= -1.0
        return maximum.loglik, rate

    def _shifted(self, right: Floats) -> Floats:
        """Return the last parameters moved along `_shifts` so that normals @ params = ``right``."""
        violation = right - np.sum(self._normals * self._params, axis=1)
        distance = violation / np.sum(self._normals * self._shifts, axis=1)
        return self._params + distance[:, None] * self._shifts
