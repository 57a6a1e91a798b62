"""Likelihood of a linear model with random effects of motions and bounds instead of some values.

    y = X delta + s (u_g + e),   s = exp(gamma w),   u_g ~ N(0, tau^2),   e ~ N(0, sigma^2)

g is the motion of a run, at one incidence; the scatter grows with the variable w if gamma > 0. A
value y is known, right-censored (larger than a bound) or left-censored (smaller). The likelihood of
a motion is integrated over u_g by Gauss-Legendre panels. Newton's method maximises the product of
these likelihoods and of normal priors about zero of gamma and some coefficients.

Sources: the model, Laird and Ware (1982), Biometrics 38(4):963-974; information of incomplete data,
Louis (1982), JRSS B 44(2):226-233; estimates without a group by one Newton step, Pregibon (1981),
Ann. Stat. 9(4):705-724.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from skewbridge.files.tables import Floats, Index
from skewbridge.fragility.likelihood import log_normal_tail, mills_ratio

# Nodes and weights for integration by panels, and for integrals with a normal density.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_NORMAL_NODES, _HERMITE = np.polynomial.hermite_e.hermegauss(5)
_NORMAL_WEIGHTS: Final = _HERMITE * np.exp(0.5 * _NORMAL_NODES**2)
_DECREMENT: Final = 1e-10  # the step with a smaller gain of log-likelihood is the last
# smallest standard deviation / standard deviation of the least-squares residuals
_SMALLEST_SHARE: Final = 0.01
_THINNEST: Final = 1e-10  # smallest eigenvalue of a scaled matrix that counts as regular
#: Range of the share of a variance that remains if a group is left out.
_SHARES: Final = (0.2, 2.0)
# ASSUME scatter changes by a factor of about exp(0.5) or less per unit of the growth variable;
# without this prior, a run beside values without scatter would have all of it
_GROWTH: Final = 0.5
#: Largest change of gamma if a group is left out.
_LARGEST_GROWTH: Final = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedData:
    """Data of the n runs of a mixed model, arrays of shape (n,)."""

    design: Floats  # X, shape (n, p)
    lower: Floats  # lower bound of y; -inf if y is left-censored
    upper: Floats  # upper bound; equal to `lower` if y is known, inf if it is right-censored
    motion: Index  # number of the motion and incidence of each run, 0 .. G - 1
    #: 1 / variance of the prior of each coefficient of X, shape (p,); 0: no prior.
    precision: Floats
    growth: Floats  # w; all zero: constant scatter

    @property
    def bound(self) -> Floats:
        """Value of y, or its only finite bound, shape (n,)."""
        return np.where(np.isfinite(self.lower), self.lower, self.upper)


@dataclass(frozen=True, slots=True)
class MixedFit:
    """A fitted mixed model; the m = p + 3 parameters are delta, gamma, ln tau and ln sigma."""

    parameters: Floats  # shape (m,)
    score: Floats  # first derivatives of the log-likelihood of each motion, shape (G, m)
    information: Floats  # negative second derivatives of it, shape (G, m, m)
    logliks: Floats  # log-likelihood of each motion, shape (G,)
    precision: Floats  # of the prior of each parameter, shape (m,); infinite if it is held

    def without_groups(self, group: Index) -> Floats:
        """Return the parameters without each group of motions, shape (B, m).

        ``group`` (G,) is the number of the group of each motion, 0 .. B - 1. One Newton step is
        exact for delta if all values are known and the standard deviations do not change.
        """
        count, size = int(np.max(group)) + 1, self.parameters.size
        score, information = np.zeros((count, size)), np.zeros((count, size, size))
        np.add.at(score, group, self.score)
        np.add.at(information, group, self.information)
        is_held = ~np.isfinite(self.precision)
        score[:, is_held], information[:, is_held], information[:, :, is_held] = 0.0, 0.0, 0.0
        total = np.sum(information, axis=0) + np.diag(np.where(is_held, 1.0, self.precision))
        # delta and the scatter in separate steps: a motion far from the others changes both, but
        # delta hardly depends on the scatter
        remaining, delta = total - information, slice(0, size - 3)
        steps = np.zeros((count, size))
        pairs = zip(score[:, delta], remaining[:, delta, delta], strict=True)
        steps[:, delta] = np.stack([_uphill(-g, matrix) for g, matrix in pairs])
        growth_steps = -score[:, -3] / remaining[:, -3, -3]
        steps[:, -3] = np.clip(growth_steps, -_LARGEST_GROWTH, _LARGEST_GROWTH)
        # a variance is a mean over motions: its change is linear in the variance
        mean = np.diag(total)[-2:] * (1.0 - 1.0 / count)
        shares = 1.0 - 2.0 * score[:, -2:] / np.maximum(mean, count)
        steps[:, -2:] = 0.5 * np.log(np.clip(shares, *_SHARES))
        steps[:, is_held] = 0.0
        return self.parameters + steps


def predictive_loglik(data: MixedData, group: Index, left_out: Floats) -> float:
    """Return the summed log-likelihood of groups of motions, each by the fit without this group.

    See `MixedFit.without_groups` for ``group`` (G,) and ``left_out`` (B, m).
    """
    run_groups, total = group[data.motion], 0.0
    for number, parameters in enumerate(left_out):
        in_group = run_groups == number
        columns = ("design", "lower", "upper", "growth")
        runs: dict[str, Floats] = {name: getattr(data, name)[in_group] for name in columns}
        motion = np.unique(data.motion[in_group], return_inverse=True)[1]
        group_data = replace(data, motion=motion, **runs)
        total += float(np.sum(_likelihood(group_data)(parameters)[2]))
    return total


def fit_mixed(data: MixedData, start: Floats | None = None, steps: int = 100) -> MixedFit:
    """Fit the model by maximum likelihood; some values must be known.

    ``start`` (m,) are the first parameters of at most ``steps`` Newton steps.
    """
    likelihood = _likelihood(data)
    initial, floor = _first_parameters(data)
    precision = np.concatenate([data.precision, [_GROWTH**-2.0, 0.0, 0.0]])
    if not np.any(data.growth):
        precision[-3] = np.inf
    if np.bincount(data.motion).max() == 1:  # scatter between motions is that of runs
        precision[-2], initial[-2] = np.inf, floor
    is_held = ~np.isfinite(precision)
    prior = np.where(is_held, 0.0, precision)

    def at(parameters: Floats) -> MixedFit:
        bounded = parameters.copy()
        bounded[-2:] = np.maximum(parameters[-2:], floor)
        return MixedFit(bounded, *likelihood(bounded), precision)

    def value(fit: MixedFit) -> float:
        return float(np.sum(fit.logliks) - 0.5 * prior @ fit.parameters**2)

    fit = at(initial if start is None else np.where(is_held, initial, start))
    for _ in range(steps):
        score = np.sum(fit.score, axis=0) - prior * fit.parameters
        information = np.sum(fit.information, axis=0) + np.diag(prior)
        # a standard deviation stays at its floor if the data favour a smaller value
        fixed = is_held.copy()
        fixed[-2:] |= (fit.parameters[-2:] <= floor) & (score[-2:] <= 0.0)
        score[fixed], information[fixed], information[:, fixed] = 0.0, 0.0, 0.0
        information[fixed, fixed] = 1.0
        step = np.where(fixed, 0.0, _uphill(score, information))
        step /= max(1.0, float(np.max(np.abs(step[-3:]))))
        gain, trial, current = float(score @ step), fit, value(fit)
        for _ in range(30):
            trial = at(fit.parameters + step)
            if value(trial) >= current - _DECREMENT * max(1.0, abs(current)):
                break
            step = 0.5 * step
        fit = trial
        if gain < _DECREMENT:
            break
    at_floor = np.append(np.zeros(initial.size - 2, dtype=np.bool_), fit.parameters[-2:] <= floor)
    return replace(fit, precision=np.where(at_floor, np.inf, precision))


def _first_parameters(data: MixedData) -> tuple[Floats, float]:
    """Return start values (m,) from least squares, and the smallest ln tau and ln sigma."""
    sqrt_precision, y = np.sqrt(data.precision), data.bound
    rows = np.vstack([data.design, np.diag(sqrt_precision)[sqrt_precision > 0.0]])
    right_side = np.append(y, np.zeros(np.count_nonzero(sqrt_precision)))
    delta = np.linalg.lstsq(rows, right_side, rcond=None)[0]
    residual = y - data.design @ delta
    mean = np.bincount(data.motion, residual) / np.bincount(data.motion)
    scatter = max(float(np.sqrt(np.mean(residual**2))), 1e-12)
    tau = float(np.sqrt(np.mean(mean**2)))
    sigma = float(np.sqrt(np.mean((residual - mean[data.motion]) ** 2)))
    ln_deviations = np.log(np.maximum([tau, sigma], _SMALLEST_SHARE * scatter))
    return np.concatenate([delta, [0.0], ln_deviations]), float(np.log(_SMALLEST_SHARE * scatter))


def _uphill(score: Floats, information: Floats) -> Floats:
    """Return Newton's step (m,), reversed in directions in which the log-likelihood is convex."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(information)), 1e-300))
    values, vectors = np.linalg.eigh(information * scale[:, None] * scale)
    inverse = 1.0 / np.maximum(np.abs(values), _THINNEST)
    return scale * (vectors @ (inverse * (vectors.T @ (scale * score))))


def _likelihood(data: MixedData) -> Callable[[Floats], tuple[Floats, Floats, Floats]]:
    """Return a function of the parameters: score, information and log-likelihood by motion.

    The shapes for G motions are (G, m), (G, m, m) and (G,).
    """
    censored = np.bincount(data.motion, data.lower != data.upper) > 0.0
    # integrals of motions without and with censored runs
    masks = [mask for mask in (~censored, censored) if np.any(mask)]
    integrals = [_Integrals(data, np.flatnonzero(mask)) for mask in masks]
    order = np.argsort(np.concatenate([integral.motions for integral in integrals]))

    def at(parameters: Floats) -> tuple[Floats, Floats, Floats]:
        results = zip(*(integral.at(parameters) for integral in integrals), strict=True)
        score, information, logliks = (np.concatenate(result)[order] for result in results)
        return score, information, logliks

    return at


class _Integrals:
    """Integrals over the random effect u: for motions with censored runs, or for all others."""

    def __init__(self, data: MixedData, motions: Index) -> None:
        self.motions = motions
        runs = np.flatnonzero(np.isin(data.motion, motions))
        runs = runs[np.argsort(data.motion[runs], kind="stable")]
        self._motion = np.searchsorted(motions, data.motion[runs])
        self._first = np.flatnonzero(np.diff(self._motion, prepend=-1))  # first run of each motion
        self._known = data.lower[runs] == data.upper[runs]
        self._design, self._bound = data.design[runs], data.bound[runs]
        self._growth = data.growth[runs]
        self._sign = np.where(np.isinf(data.upper[runs]), 1.0, -1.0)

    def _sums(self, rows: Floats) -> Floats:
        """Return the sums by motion of values of runs, shape (G, ...)."""
        return np.add.reduceat(rows, self._first, axis=0)

    def at(self, parameters: Floats) -> tuple[Floats, Floats, Floats]:
        """Return score (G, m), information (G, m, m) and log-likelihood (G,) of each motion."""
        delta, gamma, (tau, sigma) = parameters[:-3], parameters[-3], np.exp(parameters[-2:])
        shrunk = np.exp(-gamma * self._growth)
        excess = shrunk * (self._design @ delta - self._bound)
        known_terms = np.column_stack([np.ones_like(excess), self._growth, -excess / sigma**2])
        count, sum_w, pull = self._sums(self._known[:, None] * known_terms).T
        variance = 1.0 / (1.0 / tau**2 + count / sigma**2)  # of u given the known values
        u, weights = self._panels(variance * pull, variance, excess, sigma)
        # f(t), ln of the density of a known value or of the probability of a bound, at each node,
        # with its derivative and minus its second derivative
        t = self._sign[:, None] * (excess[:, None] + u[self._motion]) / sigma
        f, slope, curve, bounds = -0.5 * t**2, -t, np.ones_like(t), ~self._known
        f[bounds], slope[bounds] = log_normal_tail(t[bounds])
        curve[bounds] = slope[bounds] * (t[bounds] + slope[bounds])
        log_p = self._sums(f) - 0.5 * (u / tau) ** 2
        highest = np.max(log_p, axis=1, keepdims=True)
        weights = weights * np.exp(log_p - highest)
        total_weight = np.sum(weights, axis=1, keepdims=True)
        weights /= total_weight
        loglik = np.log(total_weight[:, 0]) + highest[:, 0] - np.log(tau) - gamma * sum_w
        loglik -= count * np.log(sigma) + 0.5 * (count + 1.0) * np.log(2.0 * np.pi)

        # score at each node, shape (G, m, Q), and the mean of the information there, (G, m, m)
        at_node = np.empty((u.shape[0], parameters.size, u.shape[1]))
        information = np.zeros((u.shape[0], parameters.size, parameters.size))
        # derivative of t by (delta, gamma)
        signed = np.column_stack([shrunk[:, None] * self._design, -self._growth * excess])
        signed *= self._sign[:, None] / sigma
        p = weights[self._motion]
        curvature = np.sum(p * curve, axis=1)[:, None] * signed
        for motion, (first, last) in enumerate(pairwise([*self._first, len(signed)])):
            at_node[motion, :-2] = signed[first:last].T @ slope[first:last]
            information[motion, :-2, :-2] = curvature[first:last].T @ signed[first:last]
        at_node[:, -3] -= sum_w[:, None]
        at_node[:, -2] = (u / tau) ** 2 - 1.0
        at_node[:, -1] = -self._sums(t * slope) - count[:, None]
        by_growth = self._sums((self._growth * np.sum(p * slope, axis=1))[:, None] * signed)
        information[:, -3, :-2] += by_growth
        information[:, :-3, -3] += by_growth[:, :-1]
        by_sigma = self._sums(np.sum(p * (slope - curve * t), axis=1)[:, None] * signed)
        information[:, :-2, -1] = information[:, -1, :-2] = by_sigma
        information[:, -2, -2] = 2.0 * np.sum(weights * (u / tau) ** 2, axis=1)
        information[:, -1, -1] = self._sums(np.sum(p * (curve * t**2 - t * slope), axis=1))
        score = np.einsum("gmq,gq->gm", at_node, weights)
        at_node -= score[:, :, None]
        at_node *= np.sqrt(weights)[:, None, :]
        return score, information - at_node @ np.swapaxes(at_node, 1, 2), loglik

    def _panels(
        self, mean: Floats, variance: Floats, excess: Floats, sigma: float
    ) -> tuple[Floats, Floats]:
        """Return nodes and weights of the integrals over u, shape (G, Q) each.

        ``excess`` (n,) is the fitted value of each run minus its known value or bound.
        """
        mode, prior, curve = mean.copy(), np.sqrt(variance), 1.0 / variance
        if np.all(self._known):  # a normal density times a polynomial of degree 4
            return mode[:, None] + prior[:, None] * _NORMAL_NODES, prior[:, None] * _NORMAL_WEIGHTS
        for _ in range(25):
            t = self._sign * (excess + mode[self._motion]) / sigma
            ratio = np.where(self._known, 0.0, mills_ratio(t))
            slope = self._sums(self._sign * ratio) / sigma - (mode - mean) / variance
            curve = self._sums(ratio * (t + ratio)) / sigma**2 + 1.0 / variance
            step = np.clip(slope / curve, -4.0 * prior, 4.0 * prior)
            mode = mode + step
            if np.all(np.abs(step) < 0.01 * prior):
                break
        # Panels end at multiples of the width of the integrand about its mode, and at multiples of
        # sigma about the extreme bounds of censored values, where the integrand changes fastest.
        # The integrand is log-concave and more curved than the prior, so its tails are not wider.
        inner = 7.0 / np.sqrt(curve)
        outer = np.maximum(7.0 * prior, inner)
        limits = [mode, mode - outer, mode + outer]
        for width in (inner, inner + (outer - inner) / 3.0, inner * 2.5 / 7.0):
            limits += [mode - width, mode + width]
        for sign, extreme in ((1.0, np.maximum), (-1.0, np.minimum)):
            censored = ~self._known & (self._sign == sign)
            if np.any(censored):
                edge = mode - sign * outer
                extreme.at(edge, self._motion[censored], -excess[censored])
                edges = [edge + share * sign * sigma for share in (-6.0, -1.0, 4.0)]
                limits += [np.clip(border, mode - outer, mode + outer) for border in edges]
        borders = np.sort(np.stack(limits, axis=1), axis=1)
        half_width, middle = 0.5 * np.diff(borders), 0.5 * (borders[:, 1:] + borders[:, :-1])
        u = middle[:, :, None] + half_width[:, :, None] * _NODES
        shape = (mean.size, -1)
        return u.reshape(shape), (half_width[:, :, None] * _WEIGHTS).reshape(shape)
