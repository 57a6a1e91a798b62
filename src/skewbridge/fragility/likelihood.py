"""Normal likelihood of observed, left-, right- and interval-censored values, and its maximum.

One kernel serves every fit: a cloud with censored demands (Tobit), capacities of an incremental
analysis, brackets of capacities, and counts of exceedance (a run that exceeds at x has its capacity
below x, one that does not above). Every term is concave in the parameters, so the maximum is unique
where it exists.

References:
    Olsen (1978), Econometrica 46(5): the parameterisation, z = h y - X delta with h = 1/sigma.
    Tobin (1958), Econometrica 26(1):24-36: censored regression.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.columns import FloatArray

HALF_LOG_2PI: Final = 0.5 * np.log(2.0 * np.pi)
_SQRT_2_OVER_PI: Final = np.sqrt(2.0 / np.pi)
_DECREMENT_TOLERANCE: Final = 1e-10  # the last Newton step squares it
_MAX_ITERATIONS: Final = 80
_MAX_HALVINGS: Final = 40
_PROFILE_TOLERANCE: Final = 1e-11


def mills_ratio(eta: FloatArray) -> FloatArray:
    """Return phi/Phi(eta) = sqrt(2/pi)/erfcx(-eta/sqrt 2), which neither underflows nor cancels."""
    return np.asarray(_SQRT_2_OVER_PI / special.erfcx(-eta / np.sqrt(2.0)))


def log_normal_tail(eta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ln Phi(eta) and phi/Phi(eta), from one scaled error function."""
    ratio = mills_ratio(eta)
    with np.errstate(divide="ignore"):
        log_p = np.where(ratio > 0.0, -0.5 * eta * eta - HALF_LOG_2PI - np.log(ratio), 0.0)
    return log_p, ratio


def log_normal_interval(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return ln[Phi(upper) - Phi(lower)] without cancellation; -inf where ``upper <= lower``."""
    flip = lower > 0.0
    a = np.where(flip, -upper, lower)
    b = np.where(flip, -lower, upper)
    log_a, log_b = special.log_ndtr(a), special.log_ndtr(b)
    with np.errstate(divide="ignore", invalid="ignore"):
        out = log_b + np.log(-np.expm1(np.minimum(log_a - log_b, 0.0)))
    return np.where(upper > lower, out, -np.inf)


class Derivatives(NamedTuple):
    """Log-likelihood of R parameter vectors with its first and second derivatives."""

    loglik: FloatArray  # shape (R,), minus infinity outside the parameter space
    score: FloatArray  # shape (R, p)
    hessian: FloatArray  # shape (R, p, p)


def _products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return x y' of the rows of two designs of shape (J, p), shape (J, p p)."""
    return (first[:, :, None] * second[:, None, :]).reshape(-1, first.shape[1] ** 2)


class NormalKernel:
    """Sum over rows of ln f(y) where observed, else of ln P(lower <= Y <= upper).

    The parameters are (delta_1..delta_q, h) with the mean of Y equal to X delta/h and its standard
    deviation 1/h. With observed rows the log-likelihood is minus infinity for h <= 0; the Jacobian
    ln h per observed row is part of it: without it there is no maximum in h. A column -1 of X in
    place of 1 gives parameters (a0, a1) with z = a0 + a1 y.
    """

    def __init__(
        self,
        covariates: FloatArray,  # X, shape (n, q)
        lower: FloatArray,  # lower ends of Y, shape (n,); minus infinity where left-censored
        upper: FloatArray,  # equal to `lower` where observed, infinity where right-censored
        weights: FloatArray | None = None,  # (n,), or (R, n) for R replicates
        upper_covariates: FloatArray | None = None,  # of ordered states; then no row is observed
    ) -> None:
        self.weights = np.ones(lower.size) if weights is None else weights
        above = covariates if upper_covariates is None else upper_covariates
        seen = (lower == upper) & (upper_covariates is None)
        has_low, has_high = np.isfinite(lower) & ~seen, np.isfinite(upper) & ~seen
        low, high = np.column_stack([-covariates, lower]), np.column_stack([-above, upper])
        tails = ((-1.0, low, has_low & ~has_high), (1.0, high, has_high & ~has_low))
        #: Sign, numbers of the rows, design and its products of rows with one end.
        self._tails = [
            (sign, np.flatnonzero(rows), design[rows], _products(design[rows], design[rows]))
            for sign, design, rows in tails
            if np.any(rows)
        ]
        self._between = np.flatnonzero(has_low & has_high)
        self._low, self._high = low[self._between], high[self._between]
        self._low_low, self._high_high = (_products(x, x) for x in (self._low, self._high))
        self._cross = _products(self._low, self._high) + _products(self._high, self._low)
        self._any_observed = bool(seen.any())
        self._count, self._onto, self._sums = self._squares(
            covariates[seen], lower[seen], self.weights[..., seen]
        )

    @staticmethod
    def _squares(
        x: FloatArray, y: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return count, basis and sums of the quadratic form of the observed rows."""
        # z = d onto params with d = (-x, residual of y about a line): nothing cancels.
        size = x.shape[1] + 1
        line = np.linalg.lstsq(x, y)[0] if y.size else np.zeros(size - 1)
        onto = np.eye(size)
        onto[:-1, -1] = -line
        rows = np.column_stack([-x, y - x @ line])
        sums = (weights @ _products(rows, rows)).reshape(*weights.shape[:-1], size, size)
        return np.sum(weights, axis=-1), onto, sums

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate at ``params`` (R, p); ``rows`` are their numbers in the batch of replicates."""
        weights, sums, count = self.weights, self._sums, self._count
        if weights.ndim == 2 and rows is not None:
            weights, sums, count = weights[rows], sums[rows], count[rows]
        h = params[:, -1]
        loglik, score = np.zeros(h.size), np.zeros(params.shape)
        hessian = np.zeros((*params.shape, params.shape[1]))
        if self._any_observed:
            safe_h = np.where(h > 0.0, h, 1.0)
            turned = params @ self._onto.T
            product = np.einsum("...ij,...j->...i", sums, turned)
            loglik += count * (np.log(safe_h) - HALF_LOG_2PI) - 0.5 * np.sum(turned * product, 1)
            score -= product @ self._onto
            score[:, -1] += count / safe_h
            hessian -= self._onto.T @ sums @ self._onto
            hessian[:, -1, -1] -= count / safe_h**2
        for sign, index, design, products in self._tails:
            w = weights[..., index]
            u = sign * (params @ design.T)
            log_p, ratio = log_normal_tail(u)
            loglik += np.sum(w * log_p, axis=1)
            w = w * ratio
            score += (sign * w) @ design
            hessian -= ((w * (u + ratio)) @ products).reshape(hessian.shape)
        if self._between.size:
            w = weights[..., self._between]
            zu, zl = params @ self._high.T, params @ self._low.T
            log_p = log_normal_interval(zl, zu)
            # a step to where a bracket has no probability is refused: finite derivatives suffice
            scale = np.where(np.isfinite(log_p), -log_p, -np.inf)
            pu, pl = (np.exp(-0.5 * z * z - HALF_LOG_2PI + scale) for z in (zu, zl))
            loglik += np.sum(w * np.where(w > 0.0, log_p, 0.0), axis=1)
            score += (w * pu) @ self._high - (w * pl) @ self._low
            second = (-w * pu * (zu + pu)) @ self._high_high + (w * pu * pl) @ self._cross
            second += (w * pl * (zl - pl)) @ self._low_low
            hessian += second.reshape(hessian.shape)
        if self._any_observed:
            loglik = np.where(h > 0.0, loglik, -np.inf)
        return Derivatives(loglik, score, hessian)


def exceedance_kernel(ln_im: FloatArray, exceed: FloatArray, remain: FloatArray) -> NormalKernel:
    """Return the kernel of counts of exceedance: eta = a0 + a1 ln x, parameters (a0, a1).

    It is Eq. 11 of Baker (2015), see `fits`, without the binomial coefficient; arrays (J,).
    """
    inf, counts = np.full(ln_im.size, np.inf), np.append(exceed, remain)
    lower, upper = np.append(-inf, ln_im), np.append(ln_im, inf)
    some = counts > 0.0
    return NormalKernel(-np.ones((int(some.sum()), 1)), lower[some], upper[some], counts[some])


class Maximum(NamedTuple):
    """Maxima of a batch of R log-likelihoods."""

    params: FloatArray  # shape (R, p)
    loglik: FloatArray  # shape (R,)
    covariance: FloatArray  # inverse observed information, shape (R, p, p); NaN where singular
    converged: NDArray[np.bool_]  # shape (R,)


def maximise(kernel: NormalKernel, start: FloatArray, *, covariance: bool = True) -> Maximum:
    """Maximise a batch of concave log-likelihoods from ``start`` (R, p) by halved Newton steps."""
    params = np.array(start, dtype=np.float64)
    active = np.arange(len(params))
    converged = np.zeros(active.size, dtype=np.bool_)
    now = kernel.derivatives(params, active)
    loglik, hessian = now.loglik.copy(), now.hessian.copy()
    for _ in range(_MAX_ITERATIONS):
        step = np.zeros_like(now.score)
        with np.errstate(all="ignore"):
            determinant = np.linalg.det(now.hessian)
        good = np.isfinite(determinant) & (determinant != 0.0)
        step[good] = np.linalg.solve(-now.hessian[good], now.score[good][..., None])[..., 0]
        decrement = np.sum(step * now.score, axis=1)
        done = (decrement < _DECREMENT_TOLERANCE) & (decrement >= 0.0)
        least = now.loglik - 1e-12 * (1.0 + np.abs(now.loglik))
        trial = kernel.derivatives(params[active] + step, active)
        failed = np.flatnonzero(~(trial.loglik >= least))
        for _ in range(_MAX_HALVINGS):
            if failed.size == 0:
                break
            step[failed] *= 0.5
            again = kernel.derivatives(params[active[failed]] + step[failed], active[failed])
            for values, new in zip(trial, again, strict=True):
                values[failed] = new
            failed = failed[~(again.loglik >= least[failed])]
        step[failed] = 0.0
        params[active] += step
        loglik[active], hessian[active] = trial.loglik, trial.hessian
        converged[active] = done & np.isfinite(trial.loglik)
        done[failed] = True
        active = active[~done]
        if active.size == 0:
            break
        now = Derivatives(*(values[~done] for values in trial))
    inverse = np.full_like(hessian, np.nan)
    if covariance:
        with np.errstate(all="ignore"):
            good = np.linalg.det(-hessian) > 0.0
        inverse[good] = np.linalg.inv(-hessian[good])
    return Maximum(params, loglik, inverse, converged)


def chi_square_drop(level: float) -> float:
    """Return the drop of twice the log-likelihood that bounds an interval in large samples."""
    return float(special.chdtri(1.0, 1.0 - level))


def student_drop(n: int, level: float) -> float:
    """Return the drop for a line through n demands whose scatter is estimated with it."""
    # 2 [l_max - l_profile] = n ln(1 + t^2/(n - 2)) is exact for a coefficient of least squares
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * level))
    return n * float(np.log1p(t**2 / (n - 2)))


def profile_ends(
    kernel: NormalKernel, maximum: Maximum, drop: float, intercepts: FloatArray, slope: int = 1
) -> FloatArray:
    """Return the profile intervals {psi: 2 [l_max - l_profile(psi)] <= drop}, shape (J + 1, 2).

    They are those of ln theta of each state, then of the common beta = 1/a1; infinite where the
    data do not bound that side. All ends are found together by Newton's method inside brackets: the
    derivative of a profile is the Lagrange multiplier of the constraint that fixes psi.
    The predictor of a state is params @ intercept + a1 ln x, so ln theta = -params @ intercept/a1;
    ``intercepts`` (J, p) are 0 at the position ``slope`` of a1.
    """
    best, a1 = maximum.params[0], float(maximum.params[0, slope])
    profiles = _Profiles(kernel, best, float(maximum.loglik[0]) - 0.5 * drop, intercepts, slope)
    middles = np.append(-intercepts @ best / a1, np.log(a1))
    gradients = np.vstack([-intercepts, np.eye(best.size)[slope]]) / a1
    gradients[:-1, slope] = -middles[:-1] / a1
    variance = np.einsum("kp,pq,kq->k", gradients, maximum.covariance[0], gradients)
    width = np.sqrt(drop * np.where(np.isfinite(variance) & (variance > 0.0), variance, 0.01))
    width[-1] = min(width[-1], 2.0)
    side, centre = np.tile([-1.0, 1.0], middles.size), np.repeat(middles, 2)
    # ASSUME a median further away than this, or a dispersion beyond a factor e^30, is not bounded
    reach = np.repeat([*np.full(len(intercepts), 40.0 / a1 + 20.0), 30.0], 2)
    away = np.minimum(np.repeat(width, 2), reach)  # distance from the maximum
    low, high = np.zeros(away.size), np.full(away.size, np.inf)  # the end lies between
    endless = np.zeros(away.size, dtype=np.bool_)
    for _ in range(_MAX_ITERATIONS):
        value, rate = profiles.evaluate(centre + side * away)
        inside = value > 0.0
        endless = inside & (away == reach)
        if np.all(done := endless | (np.abs(value) < _PROFILE_TOLERANCE)):
            break
        low, high = np.where(inside, away, low), np.where(inside, high, away)
        # the root of the drop is nearly linear in psi
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(drop - 2.0 * value, 0.0))
            newton = away + (root - np.sqrt(drop)) * root / (side * rate)
        newton = np.where(newton > low, np.minimum(newton, np.minimum(3.0 * away, reach)), np.nan)
        between = np.where(np.isfinite(high), 0.5 * (low + high), np.minimum(2.0 * away, reach))
        away = np.where(done, away, np.where(newton < high, newton, between))
    ends = np.where(endless, side * np.inf, centre + side * away).reshape(-1, 2)
    ends[-1] = np.exp(-ends[-1, ::-1])
    return ends


class _Profiles:
    """Profiles of ln theta of J states (2 rows each) and of ln a1 (2 rows), less a target."""

    # a row maximises the log-likelihood under the constraint normal @ params = right

    def __init__(
        self,
        kernel: NormalKernel,
        best: FloatArray,
        target: float,
        intercepts: FloatArray,
        slope: int,
    ) -> None:
        self._kernel, self._target, self._slope = kernel, target, slope
        axis = np.eye(best.size)[slope]
        self._normals = np.vstack([np.repeat(intercepts, 2, axis=0), axis, axis])
        # along these directions every constraint has a solution of finite likelihood: all
        # intercepts move alike, or the slope
        shift = np.any(intercepts == 1.0, axis=0).astype(np.float64)
        self._shifts = np.vstack([np.tile(shift, (2 * len(intercepts), 1)), axis, axis])
        self._params = np.tile(best, (len(self._normals), 1))
        self._now = kernel.derivatives(self._params)

    def evaluate(self, psi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the profiles at ``psi`` and their derivatives, shape (rows,)."""
        normals, right = self._normals.copy(), np.zeros(psi.size)
        normals[:-2, self._slope] = psi[:-2]
        right[-2:] = np.exp(psi[-2:])
        loglik, multiplier = self._maximise(normals, right, np.zeros(psi.size, dtype=np.bool_))
        falling = self._params[:, self._slope] < 0.0
        if np.any(falling):  # a falling curve is excluded: the best rising one is flat
            loglik, multiplier = self._maximise(normals, right, falling)
        rate = -multiplier * self._params[:, self._slope]
        rate[-2:] *= -1.0
        return loglik - self._target, rate

    def _maximise(
        self, normals: FloatArray, right: FloatArray, flat: NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray]:
        """Move the parameters to the maxima; return log-likelihoods and Lagrange multipliers."""
        # the slope stays at zero in the rows `flat`
        params, now = self._params, self._now
        if np.any(flat):
            params[flat, self._slope] = normals[flat, self._slope] = 0.0
            now = self._kernel.derivatives(params)
        miss = right - np.sum(normals * params, axis=1)
        multiplier = np.zeros(right.size)
        for number in range(_MAX_ITERATIONS):
            score, information = now.score.copy(), -now.hessian
            score[flat, self._slope] = 0.0
            information[flat, self._slope] = information[flat, :, self._slope] = 0.0
            # far from the data a direction may be flat: the ridge keeps the step finite
            ridge = 1e-12 + 1e-11 * np.trace(information, axis1=1, axis2=2)
            information += ridge[:, None, None] * np.eye(params.shape[1])
            solved = np.linalg.solve(information, np.stack([score, normals], axis=2))
            of_score, of_normal = solved[:, :, 0], solved[:, :, 1]
            multiplier = np.sum(normals * of_score, axis=1) - miss
            multiplier /= np.sum(normals * of_normal, axis=1)
            step = of_score - multiplier[:, None] * of_normal
            gain = np.sum(step * (score - multiplier[:, None] * normals), axis=1)
            if number and np.all(gain < _PROFILE_TOLERANCE):
                break
            trial = self._kernel.derivatives(params + step)
            if number == 0:  # from outside the constraint: any finite value will do
                lost = ~np.isfinite(trial.loglik)
                if np.any(lost):
                    along = miss / np.sum(normals * self._shifts, axis=1)
                    step = np.where(lost[:, None], along[:, None] * self._shifts, step)
                    trial = self._kernel.derivatives(params + step)
                miss = np.zeros(right.size)
            else:
                while np.any(fallen := ~(trial.loglik >= now.loglik - 1e-10)):
                    step = np.where(fallen[:, None], 0.5 * step, step)
                    trial = self._kernel.derivatives(params + step)
                    if np.max(np.abs(step)) < 1e-14:
                        break
            if number and np.all(np.abs(step) <= 1e-14 * (1.0 + np.abs(params))):
                break
            params, now = params + step, trial
        self._params, self._now = params, now
        return now.loglik, multiplier
