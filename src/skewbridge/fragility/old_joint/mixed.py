"""Demand over intensity and axes with the motion as random effect, some demands censored.

y = X delta + u_i + e with u_i ~ N(0, tau^2) of motion i and e ~ N(0, sigma^2) of the run; y is
known, or known only to exceed a value. The likelihood of a motion is integrated over u_i by
Gauss-Legendre panels about its mode and about its highest censored value; without censored runs it
has a closed form.

References:
    Laird and Ware (1982), Biometrics 38(4):963-974, for the model and the updates of the variances;
    Louis (1982), JRSS B 44(2):226-233, for the information of incomplete data.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.old_joint.by_motion import MotionSums
from skewbridge.fragility.old_likelihood.links import FloatArray, mills_ratio

# Panels of the integral: nodes of each, and where they end, in widths about the mode and in sigma
# about the highest censored value.
_NODES: Final = 8
_REACH: Final = 7.0
_SHOULDER: Final = 2.5
_EDGE: Final = (-6.0, -1.0, 4.0)
_NEWTON_STEPS: Final = 20
_SAFE_ROUNDS: Final = 6
_ROUNDS: Final = 200
_TOLERANCE: Final = 1e-5
_SMALLEST_VARIANCE: Final = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedData:
    """Runs of a mixed model, arrays of shape (n,).

    Attributes:
        design: Columns of X, shape (n, p).
        lower: Value of y, or the value that it exceeds.
        seen: Whether y is known.
        motion: Number of the motion of each run, 0 .. G - 1.
    """

    design: FloatArray
    lower: FloatArray
    seen: NDArray[np.bool_]
    motion: NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedFit:
    """A fitted mixed model.

    Attributes:
        tau: Standard deviation between motions.
        sigma: Standard deviation within motions.
        sums: Estimate with the share of each motion in score, information and squares.
        expected: y, in place of a censored value its expectation, shape (n,).
    """

    tau: float
    sigma: float
    sums: MotionSums
    expected: FloatArray


def fit_mixed(data: MixedData) -> MixedFit:
    """Fit the mixed model by maximum likelihood; variances by expectation and maximisation."""
    x, motion = data.design, data.motion
    params = np.linalg.lstsq(x, data.lower, rcond=None)[0]
    residual = data.lower - x @ params
    count = np.bincount(motion)
    mean = np.bincount(motion, residual) / count
    tau2 = max(float(np.mean(mean**2)), _SMALLEST_VARIANCE)
    sigma2 = max(float(np.mean((residual - mean[motion]) ** 2)), _SMALLEST_VARIANCE)
    seen, hidden = _Seen(data), _Hidden(data)
    whole = _Seen(replace(data, seen=np.ones_like(data.seen)))
    found = _posterior(seen, hidden, params, tau2, sigma2)
    for turn in range(_ROUNDS):
        # a step as if nothing were censored never overshoots; Newton's is quick at the end
        information = found.information if turn >= _SAFE_ROUNDS else whole.lost(tau2, sigma2)[1]
        step = np.linalg.pinv(np.sum(information, axis=0), hermitian=True)
        step = step @ np.sum(found.score, axis=0)
        params = params + step
        new_tau2 = max(float(np.mean(found.u_square)), _SMALLEST_VARIANCE)
        new_sigma2 = max(float(np.sum(found.e_square)) / motion.size, _SMALLEST_VARIANCE)
        moved = max(
            abs(np.log(new_tau2 / tau2)),
            abs(np.log(new_sigma2 / sigma2)),
            float(np.max(np.abs(x @ step))) / np.sqrt(tau2 + sigma2),
        )
        tau2, sigma2 = new_tau2, new_sigma2
        found = _posterior(seen, hidden, params, tau2, sigma2)
        if moved < _TOLERANCE:
            break
    expected = data.lower.copy()
    expected[hidden.rows] = found.hidden_mean
    left = expected - x @ params
    scale = 1.0 / count
    sums = MotionSums(
        params=params,
        score=found.score,
        information=found.information,
        squares=found.r_square * scale,
        slopes=sum_by(motion, x * left[:, None]) * scale[:, None],
        products=outer_by(motion, x) * scale[:, None, None],
    )
    tau, sigma = float(np.sqrt(tau2)), float(np.sqrt(sigma2))
    return MixedFit(tau=tau, sigma=sigma, sums=sums, expected=expected)


def sum_by(codes: NDArray[np.intp], values: FloatArray, count: int | None = None) -> FloatArray:
    """Return the sums of values (n, p) over the rows of each code, shape (count, p)."""
    size = int(np.max(codes, initial=-1)) + 1 if count is None else count
    return np.stack([np.bincount(codes, column, minlength=size) for column in values.T], axis=1)


def outer_by(codes: NDArray[np.intp], values: FloatArray, count: int | None = None) -> FloatArray:
    """Return the sums of x x' over the rows x (n, p) of each code, shape (count, p, p)."""
    size = int(np.max(codes, initial=-1)) + 1 if count is None else count
    order = np.argsort(codes, kind="stable")
    ends = np.cumsum(np.bincount(codes, minlength=size))[:-1]
    return np.stack([part.T @ part for part in np.split(values[order], ends)])


class _Seen:
    """Sums over the known demands of each motion."""

    def __init__(self, data: MixedData) -> None:
        self.count = int(np.max(data.motion)) + 1
        motion, x, y = data.motion[data.seen], data.design[data.seen], data.lower[data.seen]
        whole = outer_by(motion, np.column_stack([x, y]), self.count)
        self.n = np.bincount(motion, minlength=self.count).astype(np.float64)
        self.xx, self.xy, self.yy = whole[:, :-1, :-1], whole[:, :-1, -1], whole[:, -1, -1]
        self.x = sum_by(motion, x, self.count)
        self.y = np.bincount(motion, y, minlength=self.count)

    def lost(self, tau2: float, sigma2: float) -> tuple[FloatArray, FloatArray]:
        """Return the posterior variance of u, and the information that its scatter leaves."""
        variance = 1.0 / (1.0 / tau2 + self.n / sigma2)
        outer = self.x[:, :, None] * self.x[:, None, :]
        return variance, (self.xx - (variance / sigma2)[:, None, None] * outer) / sigma2


class _Hidden:
    """Censored demands, one row each."""

    def __init__(self, data: MixedData) -> None:
        self.rows = np.flatnonzero(~data.seen)
        self.x, self.lower = data.design[self.rows], data.lower[self.rows]
        self.motions, self.code = np.unique(data.motion[self.rows], return_inverse=True)


@dataclass(frozen=True, slots=True)
class _Posterior:
    """Score and information by motion, and expectations given the data, at given parameters.

    ``u_square`` of u^2, ``e_square`` and ``r_square`` the sums of e^2 and (u + e)^2 over the runs
    of a motion; ``hidden_mean`` of the censored y.
    """

    score: FloatArray
    information: FloatArray
    u_square: FloatArray
    e_square: FloatArray
    r_square: FloatArray
    hidden_mean: FloatArray


def _posterior(
    seen: _Seen, hidden: _Hidden, params: FloatArray, tau2: float, sigma2: float
) -> _Posterior:
    residual = seen.y - seen.x @ params
    square = np.maximum(
        seen.yy - 2.0 * seen.xy @ params + np.einsum("p,gpq,q->g", params, seen.xx, params), 0.0
    )
    variance, information = seen.lost(tau2, sigma2)  # by Louis' identity
    mean = variance * residual / sigma2
    whole = seen.xy - seen.xx @ params
    found = _Posterior(
        score=(whole - seen.x * mean[:, None]) / sigma2,
        information=information,
        u_square=mean**2 + variance,
        e_square=square - 2.0 * mean * residual + seen.n * (mean**2 + variance),
        r_square=square,
        hidden_mean=np.zeros(hidden.rows.size),
    )
    if hidden.rows.size:
        _integrate(seen, hidden, params, (whole, mean, variance, square, residual), sigma2, found)
    return found


def _integrate(
    seen: _Seen,
    hidden: _Hidden,
    params: FloatArray,
    known: tuple[FloatArray, ...],
    sigma2: float,
    found: _Posterior,
) -> None:
    """Put in the motions with censored runs, by quadrature over their random effect."""
    which, code, sigma = hidden.motions, hidden.code, float(np.sqrt(sigma2))
    whole, mean, variance, square, residual = (values[which] for values in known)
    above = hidden.x @ params - hidden.lower
    count = which.size

    def slopes(u: FloatArray) -> tuple[FloatArray, FloatArray]:
        t = (above + u[code]) / sigma
        ratio = mills_ratio(t)
        first = np.bincount(code, ratio, minlength=count) / sigma - (u - mean) / variance
        second = np.bincount(code, ratio * (t + ratio), minlength=count) / sigma2 + 1.0 / variance
        return first, second

    mode = mean.copy()
    for _ in range(_NEWTON_STEPS):
        first, second = slopes(mode)
        mode = mode + first / second
    width = 1.0 / np.sqrt(slopes(mode)[1])
    edge = np.full(count, -np.inf)
    np.maximum.at(edge, code, -above)
    u, weights = _panels(mode, width, np.sqrt(variance), edge, sigma)
    t = (above[:, None] + u[code]) / sigma
    ratio = mills_ratio(t)
    ln_tail = special.log_ndtr(t)
    log_p = sum_by(code, ln_tail, count) - 0.5 * (u - mean[:, None]) ** 2 / variance[:, None]
    p = weights * np.exp(log_p - np.max(log_p, axis=1, keepdims=True))
    p /= np.sum(p, axis=1, keepdims=True)

    first, second = np.sum(p * u, axis=1), np.sum(p * u * u, axis=1)
    p_run, tail = p[code], sigma * ratio
    found.u_square[which] = second
    found.hidden_mean[:] = hidden.x @ params + np.sum(p_run * (u[code] + tail), axis=1)
    e_run = np.sum(p_run * (1.0 - t * ratio), axis=1) * sigma2
    e_known = square - 2.0 * first * residual + seen.n[which] * second
    found.e_square[which] = e_known + np.bincount(code, e_run, minlength=count)
    r_run = e_run + np.sum(p_run * (u[code] ** 2 + 2.0 * u[code] * tail), axis=1)
    found.r_square[which] = square + np.bincount(code, r_run, minlength=count)
    # score of the complete data at each node; its scatter over the nodes is lost information
    size = params.size
    at_node = whole[:, None, :] - seen.x[which][:, None, :] * u[:, :, None]
    pull = (hidden.x[:, None, :] * tail[:, :, None]).reshape(code.size, -1)
    at_node = (at_node + sum_by(code, pull, count).reshape(count, -1, size)) / sigma2
    score = np.einsum("gq,gqp->gp", p, at_node)
    apart = at_node - score[:, None, :]
    curve = np.sqrt(np.sum(p_run * ratio * (t + ratio), axis=1))
    held = seen.xx[which] + outer_by(code, hidden.x * curve[:, None], count)
    found.score[which] = score
    found.information[which] = held / sigma2 - np.einsum("gq,gqp,gqr->gpr", p, apart, apart)


def _panels(
    mode: FloatArray, width: FloatArray, prior_width: FloatArray, edge: FloatArray, sigma: float
) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of an integral over u, shapes (G, Q): no end cuts any mass.

    ``edge`` is where the highest of a motion's censored values lies: there its probability rises
    from 0 to 1 within a few ``sigma``.
    """
    low, near = mode - _REACH * width, mode + _REACH * width
    far = np.maximum(mode + _REACH * prior_width, near)
    breaks = [low, mode - _SHOULDER * width, mode, mode + _SHOULDER * width, near, far]
    breaks += [near + (far - near) / 3.0]
    breaks += [np.clip(edge + share * sigma, low, far) for share in _EDGE]
    ends = np.sort(np.stack(breaks), axis=0)
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    half, middle = 0.5 * np.diff(ends, axis=0), 0.5 * (ends[1:] + ends[:-1])
    u = middle[:, :, None] + half[:, :, None] * nodes
    return np.concatenate(list(u), axis=1), np.concatenate(list(half[:, :, None] * weights), axis=1)
