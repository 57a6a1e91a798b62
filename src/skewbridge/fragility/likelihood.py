"""Normal likelihood of observed, left-, right- and interval-censored values, and its maximum.

One kernel serves every fit: a cloud with censored demands (Tobit), capacities of an incremental
analysis, brackets of capacities, and counts of exceedance (a run that exceeds at x has its capacity
below x, one that does not above). Every term is concave in the parameters, so the maximum is unique
where it exists.

References:
    Olsen (1978), Econometrica 46(5): the parameterisation, z = h y - X delta with h = 1/sigma.
    Tobin (1958), Econometrica 26(1):24-36: censored regression.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.columns import FloatArray

HALF_LOG_2PI: Final = 0.5 * np.log(2.0 * np.pi)
_SQRT_2_OVER_PI: Final = np.sqrt(2.0 / np.pi)
_DECREMENT_TOLERANCE: Final = 1e-10  # the last Newton step squares it
_MAX_ITERATIONS: Final = 80
_MAX_HALVINGS: Final = 40


def mills_ratio(eta: FloatArray) -> FloatArray:
    """Return phi/Phi(eta) = sqrt(2/pi)/erfcx(-eta/sqrt 2), which neither underflows nor cancels."""
    return np.asarray(_SQRT_2_OVER_PI / special.erfcx(-eta / np.sqrt(2.0)))


def log_normal_interval(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return ln[Phi(upper) - Phi(lower)], as a difference of logarithms in the lower tail.

    Minus infinity where ``upper <= lower``.
    """
    flip = lower > 0.0
    a = np.where(flip, -upper, lower)
    b = np.where(flip, -lower, upper)
    log_a, log_b = special.log_ndtr(a), special.log_ndtr(b)
    with np.errstate(divide="ignore", invalid="ignore"):
        out = log_b + np.log(-np.expm1(np.minimum(log_a - log_b, 0.0)))
    return np.where(upper > lower, out, -np.inf)


@dataclass(frozen=True, slots=True)
class Derivatives:
    """Log-likelihood of R parameter vectors with its derivatives.

    Attributes:
        loglik: Shape (R,); minus infinity outside the parameter space.
        score: First derivatives, shape (R, p).
        hessian: Second derivatives, shape (R, p, p), negative definite at a maximum.
    """

    loglik: FloatArray
    score: FloatArray
    hessian: FloatArray


class Kernel(Protocol):
    """A log-likelihood of p parameters that can be evaluated in batches."""

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate at ``params`` (R, p); ``rows`` are their numbers in the batch of replicates."""
        ...


def _products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return x y' of the rows of two designs of shape (J, p), shape (J, p p)."""
    return (first[:, :, None] * second[:, None, :]).reshape(-1, first.shape[1] ** 2)


@dataclass(frozen=True, slots=True)
class _Rows:
    """Rows of one kind: linear predictors z = design params, and the numbers of the rows."""

    design: FloatArray
    products: FloatArray
    index: NDArray[np.intp]

    @classmethod
    def of(cls, design: FloatArray, index: NDArray[np.intp]) -> Self:
        return cls(design, _products(design, design), index)


class NormalKernel:
    """Sum over rows of ln f(y) where observed, else of ln P(lower <= Y <= upper).

    The parameters are (delta_1..delta_q, h) with the mean of Y equal to X delta/h and its standard
    deviation 1/h. With observed rows the log-likelihood is minus infinity for h <= 0; the Jacobian
    ln h per observed row is part of it: without it there is no maximum in h.

    Args:
        covariates: X, shape (n, q). Column -1 in place of 1 gives parameters (a0, a1) with
            z = a0 + a1 y.
        lower: Lower ends of Y, shape (n,); minus infinity where left-censored.
        upper: Upper ends; equal to ``lower`` where observed, infinity where right-censored.
        weights: How often each row counts, shape (n,) or (R, n) for R replicates.
        upper_covariates: X of the upper ends if they differ, shape (n, q) (ordered states).
        observed: Rows that are observed, shape (n,); by default those with equal ends.
    """

    def __init__(
        self,
        covariates: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        weights: FloatArray | None = None,
        upper_covariates: FloatArray | None = None,
        observed: NDArray[np.bool_] | None = None,
    ) -> None:
        self.weights = np.ones(lower.size) if weights is None else weights
        above = covariates if upper_covariates is None else upper_covariates
        seen = (lower == upper) if observed is None else observed
        low, high = np.isfinite(lower) & ~seen, np.isfinite(upper) & ~seen

        def design(x: FloatArray, y: FloatArray, mask: NDArray[np.bool_]) -> FloatArray:
            return np.column_stack([-x[mask], y[mask]])

        index = [np.flatnonzero(mask) for mask in (low & ~high, high & ~low, low & high)]
        self._right = _Rows.of(design(covariates, lower, low & ~high), index[0])
        self._left = _Rows.of(design(above, upper, high & ~low), index[1])
        self._both_low = _Rows.of(design(covariates, lower, low & high), index[2])
        self._both_high = _Rows.of(design(above, upper, low & high), index[2])
        self._any_observed = bool(seen.any())
        first, second = self._both_high.design, self._both_low.design
        self._cross = _products(first, second) + _products(second, first)
        self._count, self._onto, self._sums = self._squares(
            covariates[seen], lower[seen], self.weights[..., seen]
        )

    @staticmethod
    def _squares(
        x: FloatArray, y: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return count, basis and sums of the quadratic form of the observed rows.

        The residuals are z = d onto params with d = (-x, residual of y about a line), so that
        nothing cancels where the scatter is small.
        """
        size = x.shape[1] + 1
        line = np.linalg.lstsq(x, y)[0] if y.size else np.zeros(size - 1)
        onto = np.eye(size)
        onto[:-1, -1] = -line
        rows = np.column_stack([-x, y - x @ line])
        sums = (weights @ _products(rows, rows)).reshape(*weights.shape[:-1], size, size)
        return np.sum(weights, axis=-1), onto, sums

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate the batch; see `Kernel`."""
        each = self.weights.ndim == 2 and rows is not None
        weights = self.weights[rows] if each else self.weights
        h = params[:, -1]
        inside = (h > 0.0) | (not self._any_observed)
        safe_h = np.where(inside, h, 1.0)
        loglik = np.zeros(h.size)
        score = np.zeros(params.shape)
        hessian = np.zeros((*params.shape, params.shape[1]))
        sums, count = (self._sums[rows], self._count[rows]) if each else (self._sums, self._count)
        if self._any_observed:
            turned = params @ self._onto.T
            product = np.einsum("...ij,...j->...i", sums, turned)
            loglik += count * (np.log(safe_h) - HALF_LOG_2PI) - 0.5 * np.sum(turned * product, 1)
            score -= product @ self._onto
            score[:, -1] += count / safe_h
            hessian -= self._onto.T @ sums @ self._onto
            hessian[:, -1, -1] -= count / safe_h**2
        for part, sign in ((self._right, -1.0), (self._left, 1.0)):
            if part.index.size:
                w = weights[..., part.index]
                u = sign * (params @ part.design.T)
                ratio = mills_ratio(u)
                with np.errstate(divide="ignore"):
                    log_p = np.where(ratio > 0.0, -0.5 * u * u - HALF_LOG_2PI - np.log(ratio), 0.0)
                loglik += np.sum(w * log_p, axis=1)
                score += (sign * w * ratio) @ part.design
                hessian += ((-w * ratio * (u + ratio)) @ part.products).reshape(hessian.shape)
        if self._both_low.index.size:
            w = weights[..., self._both_low.index]
            zu, zl = params @ self._both_high.design.T, params @ self._both_low.design.T
            log_p = log_normal_interval(zl, zu)
            # a step to where a bracket has no probability is refused: finite derivatives suffice
            scale = np.where(np.isfinite(log_p), -log_p, -np.inf)
            pu, pl = (np.exp(-0.5 * z * z - HALF_LOG_2PI + scale) for z in (zu, zl))
            loglik += np.sum(w * np.where(w > 0.0, log_p, 0.0), axis=1)
            score += (w * pu) @ self._both_high.design - (w * pl) @ self._both_low.design
            second = (-w * pu * (zu + pu)) @ self._both_high.products
            second += (w * pl * (zl - pl)) @ self._both_low.products + (w * pu * pl) @ self._cross
            hessian += second.reshape(hessian.shape)
        return Derivatives(np.where(inside, loglik, -np.inf), score, hessian)


def exceedance_kernel(ln_im: FloatArray, exceed: FloatArray, remain: FloatArray) -> NormalKernel:
    """Return the kernel of counts of exceedance: eta = a0 + a1 ln x, parameters (a0, a1).

    A run that exceeds at x has its capacity at or below x, one that does not above x.

    Args:
        ln_im: ln of the intensities, shape (J,).
        exceed: Runs that exceed, shape (J,) or (R, J); fractions are allowed.
        remain: Runs that do not.

    References:
        Baker (2015), Earthquake Spectra 31(1):579-599, Eq. 11 (without the binomial coefficient).
    """
    size, inf = ln_im.size, np.full(ln_im.size, np.inf)
    rows = [np.any(np.atleast_2d(counts) > 0.0, axis=0) for counts in (exceed, remain)]
    return NormalKernel(
        -np.ones((int(rows[0].sum() + rows[1].sum()), 1)),
        np.concatenate([-inf[:size][rows[0]], ln_im[rows[1]]]),
        np.concatenate([ln_im[rows[0]], inf[rows[1]]]),
        np.concatenate([exceed[..., rows[0]], remain[..., rows[1]]], axis=-1),
    )


@dataclass(frozen=True, slots=True)
class Maximum:
    """Maxima of a batch.

    Attributes:
        params: Shape (R, p).
        loglik: Shape (R,).
        covariance: Inverse observed information, shape (R, p, p); NaN where singular.
        converged: Shape (R,).
    """

    params: FloatArray
    loglik: FloatArray
    covariance: FloatArray
    converged: NDArray[np.bool_]


def maximise(kernel: Kernel, start: FloatArray, *, covariance: bool = True) -> Maximum:
    """Maximise a batch of concave log-likelihoods from ``start`` (R, p) by halved Newton steps."""
    params = np.array(start, dtype=np.float64)
    total = params.shape[0]
    active = np.arange(total)
    converged = np.zeros(total, dtype=np.bool_)
    loglik = np.full(total, -np.inf)
    hessian = np.zeros((total, params.shape[1], params.shape[1]))
    now = kernel.derivatives(params, active)
    for _ in range(_MAX_ITERATIONS):
        step = _newton_step(now)
        decrement = np.sum(step * now.score, axis=1)
        trial, accepted = _step_uphill(kernel, params, active, step, now)
        done = (decrement < _DECREMENT_TOLERANCE) & (decrement >= 0.0)
        loglik[active] = trial.loglik
        hessian[active] = trial.hessian
        converged[active] = done
        stay = ~done & accepted
        active = active[stay]
        if active.size == 0:
            break
        now = Derivatives(trial.loglik[stay], trial.score[stay], trial.hessian[stay])
    inverse = np.full_like(hessian, np.nan)
    if covariance:
        with np.errstate(all="ignore"):
            good = np.all(np.isfinite(hessian), axis=(1, 2))
            good[good] = np.linalg.det(-hessian[good]) > 0.0
        inverse[good] = np.linalg.inv(-hessian[good])
    return Maximum(params, loglik, inverse, converged)


def _newton_step(now: Derivatives) -> FloatArray:
    hessian, score = now.hessian, now.score
    if score.shape[1] == 1:
        return score / np.where(hessian[:, 0] < 0.0, -hessian[:, 0], np.inf)
    if score.shape[1] == 2:  # closed form: by far the most frequent case
        a, b, d = hessian[:, 0, 0], hessian[:, 0, 1], hessian[:, 1, 1]
        det = a * d - b * b
        det = np.where(det > 0.0, det, np.inf)
        first = (d * score[:, 0] - b * score[:, 1]) / -det
        second = (a * score[:, 1] - b * score[:, 0]) / -det
        return np.stack([first, second], axis=1)
    step = np.zeros_like(score)
    with np.errstate(all="ignore"):
        good = np.all(np.isfinite(hessian), axis=(1, 2)) & (np.abs(np.linalg.det(hessian)) > 0.0)
    step[good] = np.linalg.solve(-hessian[good], score[good][..., None])[..., 0]
    return step


def _step_uphill(
    kernel: Kernel,
    params: FloatArray,
    active: NDArray[np.intp],
    step: FloatArray,
    now: Derivatives,
) -> tuple[Derivatives, NDArray[np.bool_]]:
    """Move ``params[active]`` along the step, halved until the log-likelihood does not fall."""
    origin = params[active]
    params[active] = origin + step
    trial = kernel.derivatives(params[active], active)
    slack = 1e-12 * (1.0 + np.abs(now.loglik))
    failed = np.flatnonzero(~(trial.loglik >= now.loglik - slack))
    factor = 1.0
    for _ in range(_MAX_HALVINGS):
        if failed.size == 0:
            break
        factor *= 0.5
        params[active[failed]] = origin[failed] + factor * step[failed]
        again = kernel.derivatives(params[active[failed]], active[failed])
        trial.loglik[failed] = again.loglik
        trial.score[failed] = again.score
        trial.hessian[failed] = again.hessian
        failed = failed[~(again.loglik >= now.loglik[failed] - slack[failed])]
    accepted = np.ones(active.size, dtype=np.bool_)
    accepted[failed] = False
    params[active[failed]] = origin[failed]
    return trial, accepted


def chi_square_drop(level: float) -> float:
    """Return the drop of twice the log-likelihood that bounds an interval in large samples."""
    return float(special.chdtri(1.0, 1.0 - level))


def student_drop(n: int, level: float) -> float:
    """Return the drop for a line through n demands whose scatter is estimated with it.

    2 [l_max - l_profile] = n ln(1 + t^2/(n - 2)) holds exactly for a coefficient of a least-squares
    line: the interval is then that of Student's t with n - 2 degrees of freedom.
    """
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * level))
    return n * float(np.log1p(t**2 / (n - 2)))


@dataclass(frozen=True, slots=True)
class ProfileEnds:
    """Ends of the profile intervals of ln theta of J states and of their common beta = 1/a1."""

    ln_theta: list[tuple[float, float]]
    beta: tuple[float, float]


@dataclass(frozen=True, slots=True)
class MedianTerm:
    """The predictor of one state: eta = params @ intercept + a1 ln x, so ln theta = -intercept/a1.

    Attributes:
        position: Position of the parameter that the state determines (a0 of the state).
        intercept: Coefficients of the parameters in the intercept, shape (p,), 0 at the slope and
            not 0 at ``position``.
    """

    position: int
    intercept: FloatArray


def profile_ends(
    kernel: Kernel, maximum: Maximum, drop: float, terms: Sequence[MedianTerm], slope: int = 1
) -> ProfileEnds:
    """Return the profile intervals {psi: 2 [l_max - l_profile(psi)] <= drop}.

    All ends are found together by Newton's method inside brackets: the derivative of a profile is
    the score along psi at the best nuisance parameters.

    Args:
        kernel: Log-likelihood of p parameters.
        maximum: Its maximum, a batch of one with a1 > 0.
        drop: Drop of twice the log-likelihood at the ends.
        terms: The states whose medians are profiled.
        slope: Position of the slope a1.

    Returns:
        The ends; those of ln theta may be infinite and the upper end of beta too: then the data do
        not bound the median or the dispersion on that side.
    """
    best, covariance = maximum.params[0], maximum.covariance[0]
    a1 = float(best[slope])
    profiles = _Profiles(kernel, best, float(maximum.loglik[0]) - 0.5 * drop, terms, slope)
    middles = np.array([-float(term.intercept @ best) / a1 for term in terms] + [np.log(a1)])
    gradients = np.array([-term.intercept / a1 for term in terms] + [np.zeros(best.size)])
    gradients[:-1, slope] = -middles[:-1] / a1
    gradients[-1, slope] = 1.0 / a1
    variance = np.einsum("kp,pq,kq->k", gradients, covariance, gradients)
    width = np.sqrt(drop * np.where(np.isfinite(variance) & (variance > 0.0), variance, 0.01))
    side = np.tile([-1.0, 1.0], middles.size)
    centre = np.repeat(middles, 2)
    # ASSUME a median further away than this, or a dispersion beyond a factor e^30, is not bounded
    reach = np.repeat([*(40.0 / a1 + 20.0 for _ in terms), 30.0], 2)
    step = np.repeat([*width[:-1], min(width[-1], 2.0)], 2)
    inner, outer = centre.copy(), centre + side * step
    value, rate = profiles.evaluate(outer)
    while np.any(outside := (value > 0.0) & (np.abs(outer - centre) < reach)):
        step = np.where(outside, 2.0 * step, step)
        inner = np.where(outside, outer, inner)
        outer = np.where(outside, outer + side * step, outer)
        value, rate = profiles.evaluate(outer)
    endless = value > 0.0
    psi, low, high = outer.copy(), inner, outer.copy()  # zero between low (inside) and high
    for _ in range(_MAX_ITERATIONS):
        if np.all(endless | (np.abs(value) < 1e-10)):
            break
        # the root of the drop is nearly linear in psi
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(drop - 2.0 * value, 0.0))
            newton = psi + (root - np.sqrt(drop)) * root / rate
        between = (side * newton > side * low) & (side * newton < side * high)
        psi = np.where(endless, psi, np.where(between, newton, 0.5 * (low + high)))
        value, rate = profiles.evaluate(psi)
        low, high = np.where(value > 0.0, psi, low), np.where(value > 0.0, high, psi)
    ends = np.where(endless, side * np.inf, psi).reshape(-1, 2)
    return ProfileEnds(
        [(float(low), float(high)) for low, high in ends[:-1]],
        (float(np.exp(-ends[-1, 1])), float(np.exp(-ends[-1, 0]))),
    )


class _Profiles:
    """Profiles of ln theta of J states (2 rows each) and of ln a1 (2 rows), less a target.

    The parameters of a row are base + nuisance @ free: the nuisance parameters are all but one, the
    intercept of the state (which ln theta and the others determine) or a1 itself.
    """

    def __init__(
        self,
        kernel: Kernel,
        best: FloatArray,
        target: float,
        terms: Sequence[MedianTerm],
        slope: int,
    ) -> None:
        p, rows = best.size, 2 * len(terms) + 2
        self._kernel, self._target, self._slope, self._best = kernel, target, slope, best
        self._bound = np.array([t.position for t in terms for _ in range(2)] + [slope, slope])
        self._scale = np.ones(rows)
        self._nuisance = np.empty((rows, p - 1))
        self._free = np.zeros((rows, p - 1, p))
        self._slope_row = np.zeros(rows, dtype=np.intp)  # place of a1 among the nuisance parameters
        for row in range(rows):
            others = [i for i in range(p) if i != self._bound[row]]
            self._nuisance[row] = best[others]
            self._free[row, np.arange(p - 1), others] = 1.0
            if row < rows - 2:
                term = terms[row // 2]
                self._scale[row] = term.intercept[term.position]
                # intercept = -a1 psi: the bound parameter follows from the others
                self._free[row, :, term.position] -= term.intercept[others] / self._scale[row]
                self._slope_row[row] = others.index(slope)
        self._medians = np.arange(rows - 2)

    def evaluate(self, psi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the profiles at ``psi`` and their derivatives, shape (rows,)."""
        rows, free = self._medians, self._free.copy()
        base = np.zeros((psi.size, free.shape[2]))
        base[-2:, self._slope] = np.exp(psi[-2:])
        slopes = self._slope_row[rows]
        free[rows, slopes, self._bound[rows]] -= psi[:-2] / self._scale[rows]
        t = self._nuisance
        now = self._at(base, free, t)
        if np.any(lost := ~np.isfinite(now.loglik)):
            # intercepts out of order: move all others by as much as the bound one
            params = base + np.einsum("rq,rqp->rp", t, free)
            moved = params[np.arange(psi.size), self._bound] - self._best[self._bound]
            shift = np.where(lost, moved, 0.0)[:, None] * np.ones_like(t)
            shift[rows, slopes] = 0.0
            t = t + shift
            now = self._at(base, free, t)
        for _ in range(_MAX_ITERATIONS):
            score = np.einsum("rqp,rp->rq", free, now.score)
            curve = -(free @ now.hessian @ np.swapaxes(free, 1, 2))
            # far from the data a direction may be flat: the ridge keeps the step finite
            ridge = 1e-12 + 1e-11 * np.trace(curve, axis1=1, axis2=2)
            curve = curve + ridge[:, None, None] * np.eye(t.shape[1])
            with np.errstate(all="ignore"):
                step = np.linalg.solve(curve, score[:, :, None])[:, :, 0]
            if np.all(np.sum(step * score, axis=1) < 1e-11):
                break
            new, factor = t + step, np.ones(psi.size)
            # a falling curve is excluded: the best rising one is flat
            new[rows, slopes] = np.maximum(new[rows, slopes], 0.0)
            trial = self._at(base, free, new)
            while np.any(fallen := ~(trial.loglik >= now.loglik - 1e-10)) and factor.min() > 1e-9:
                factor = np.where(fallen, 0.5 * factor, factor)
                new = t + factor[:, None] * step
                new[rows, slopes] = np.maximum(new[rows, slopes], 0.0)
                trial = self._at(base, free, new)
            stuck = np.all(np.abs(new - t) <= 1e-14 * (1.0 + np.abs(t)))
            t, now = new, trial
            if stuck:
                break
        self._nuisance = np.where(np.isfinite(t), t, self._nuisance)
        self._nuisance[rows, slopes] = np.maximum(self._nuisance[rows, slopes], 1e-6)
        along = now.score[np.arange(psi.size), self._bound]
        rate = np.concatenate(
            [
                -t[rows, slopes] / self._scale[rows] * along[:-2],
                base[-2:, self._slope] * along[-2:],
            ]
        )
        return now.loglik - self._target, rate

    def _at(self, base: FloatArray, free: FloatArray, t: FloatArray) -> Derivatives:
        return self._kernel.derivatives(base + np.einsum("rq,rqp->rp", t, free))
