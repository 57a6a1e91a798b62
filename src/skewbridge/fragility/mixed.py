"""Normal model with a random effect by motion, in which some values are censored.

y = X delta + u_g + e with u_g ~ N(0, tau^2) of motion g and e ~ N(0, sigma^2) of the run. A value
is known, right-censored (larger than a bound) or left-censored (smaller). The likelihood of a
motion is integrated over u_g by Gauss-Legendre panels; Newton's method maximises it over delta,
ln tau and ln sigma.

References:
    Laird and Ware (1982), Biometrics 38(4):963-974, for the model; Louis (1982), JRSS B
    44(2):226-233, for the information of incomplete data; Bell and McCaffrey (2002), Survey
    Methodology 28(2):169-181: with few clusters the jackknife variance is not biased low.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from skewbridge.files.tables import Floats, Index, Mask
from skewbridge.fragility.likelihood import log_normal_tail, mills_ratio, row_products

# Panels of the integral: nodes of each, and their ends in widths about the mode and in sigma about
# the bounds of censored values, where the integrand changes fastest.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_NORMAL_NODES, _HERMITE = np.polynomial.hermite_e.hermegauss(5)
_NORMAL_WEIGHTS: Final = _HERMITE * np.exp(0.5 * _NORMAL_NODES**2)
_REACH: Final = 7.0
_SHOULDER: Final = 2.5
_EDGE: Final = (-6.0, -1.0, 4.0)
_MODE_STEPS: Final = 25
_ROUNDS: Final = 100
_HALVINGS: Final = 30
_DECREMENT: Final = 1e-10  # of the log-likelihood; the step after it leaves some 1e-20
_REFIT_DECREMENT: Final = 1e-4
# smallest standard deviation, as a share of the scatter of the least-squares residuals
_SMALLEST_SHARE: Final = 1e-4
_THINNEST: Final = 1e-10


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedData:
    """Runs of a mixed model, arrays of shape (n,)."""

    design: Floats  # columns of X, shape (n, p)
    lower: Floats  # lower bound of y; -inf where y is left-censored
    upper: Floats  # equal to `lower` where y is known, inf where it is right-censored
    motion: Index  # number of the motion of each run, 0 .. G - 1

    @property
    def bound(self) -> Floats:
        """Value of y, or its only finite bound, shape (n,)."""
        return np.where(np.isfinite(self.lower), self.lower, self.upper)


@dataclass(frozen=True, slots=True)
class MixedFit:
    """A fitted mixed model; parameters are delta, ln tau and ln sigma, m = p + 2."""

    parameters: Floats  # shape (m,)
    score: Floats  # first derivatives of the log-likelihood by motion, shape (G, m)
    information: Floats  # its negative second derivatives by motion, shape (G, m, m)
    logliks: Floats  # log-likelihood by motion, shape (G,)
    expected: Floats  # y; its conditional expectation where it is censored, shape (n,)

    @property
    def delta(self) -> Floats:
        """Coefficients of X, shape (p,)."""
        return self.parameters[:-2]

    @property
    def tau(self) -> float:
        """Standard deviation between motions."""
        return float(np.exp(self.parameters[-2]))

    @property
    def sigma(self) -> float:
        """Standard deviation within motions."""
        return float(np.exp(self.parameters[-1]))


def fit_mixed(data: MixedData) -> MixedFit:
    """Fit the mixed model by maximum likelihood; some values must be known."""
    start, floor = _first_parameters(data)
    every = np.ones(int(np.max(data.motion)) + 1, dtype=np.bool_)
    return _maximised(_Likelihood(data), start, floor, every, _DECREMENT)


def without_each_motion(data: MixedData, fit: MixedFit) -> Floats:
    """Return the parameters of the fits without each motion, shape (G, m).

    The start is exact for delta at fixed tau and sigma where all values are known, and for tau and
    sigma where few motions have any leverage.
    """
    likelihood, (_, floor) = _Likelihood(data), _first_parameters(data)
    total, count = np.sum(fit.information, axis=0), fit.score.shape[0]
    held = np.diag(total)[-2:] * (1.0 - 1.0 / count)
    rows: list[Floats] = []
    for motion, (score, information) in enumerate(zip(fit.score, fit.information, strict=True)):
        delta = fit.delta - _uphill(score[:-2], (total - information)[:-2, :-2])
        share = 1.0 - 2.0 * score[-2:] / np.maximum(held, count)
        deviations = fit.parameters[-2:] + 0.5 * np.log(np.clip(share, 0.2, 2.0))
        start, others = np.concatenate([delta, deviations]), np.arange(count) != motion
        rows.append(_maximised(likelihood, start, floor, others, _REFIT_DECREMENT).parameters)
    return np.stack(rows)


def _maximised(
    likelihood: "_Likelihood", start: Floats, floor: float, motions: Mask, decrement: float
) -> MixedFit:
    """Return the fit to some motions by Newton's method."""
    # `floor` bounds ln tau and ln sigma; a step that gains less than `decrement` is the last one

    def at(parameters: Floats) -> MixedFit:
        return likelihood.at(np.append(parameters[:-2], np.maximum(parameters[-2:], floor)))

    fit = at(start)
    for _ in range(_ROUNDS):
        score = np.sum(fit.score[motions], axis=0)
        information = np.sum(fit.information[motions], axis=0)
        loglik = float(np.sum(fit.logliks[motions]))
        # a standard deviation that the data push to zero stays at its floor
        for place in (-2, -1):
            if fit.parameters[place] <= floor and score[place] <= 0.0:
                score[place], information[place], information[:, place] = 0.0, 0.0, 0.0
                information[place, place] = 1.0
        step = _uphill(score, information)
        step /= max(1.0, float(np.max(np.abs(step[-2:]))))
        gain, trial = float(score @ step), fit
        for _ in range(_HALVINGS):
            trial = at(fit.parameters + step)
            if np.sum(trial.logliks[motions]) >= loglik - _DECREMENT * max(1.0, abs(loglik)):
                break
            step = 0.5 * step
        fit = trial
        if gain < decrement:
            break
    return fit


def outer_by(codes: Index, values: Floats, count: int) -> Floats:
    """Return the sums of x x' over the rows x (n, p) of each code, shape (count, p, p)."""
    order = np.argsort(codes, kind="stable")
    ends = np.cumsum(np.bincount(codes, minlength=count))[:-1]
    return np.stack([part.T @ part for part in np.split(values[order], ends)])


def _first_parameters(data: MixedData) -> tuple[Floats, float]:
    """Return least-squares parameters and the floor of ln tau and ln sigma."""
    x, y = data.design, data.bound
    delta = np.linalg.lstsq(x, y, rcond=None)[0]
    residual = y - x @ delta
    mean = np.bincount(data.motion, residual) / np.bincount(data.motion)
    scatter = max(float(np.sqrt(np.mean(residual**2))), 1e-12)
    floor = float(np.log(_SMALLEST_SHARE * scatter))
    tau = float(np.sqrt(np.mean(mean**2)))
    sigma = float(np.sqrt(np.mean((residual - mean[data.motion]) ** 2)))
    deviations = np.log(np.maximum([tau, sigma], _SMALLEST_SHARE * scatter))
    return np.concatenate([delta, deviations]), floor


def _uphill(score: Floats, information: Floats) -> Floats:
    """Return Newton's step; directions in which the log-likelihood is convex are turned round."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(information)), 1e-300))
    values, vectors = np.linalg.eigh(information * scale[:, None] * scale)
    inverse = 1.0 / np.maximum(np.abs(values), _THINNEST)
    return scale * (vectors @ (inverse * (vectors.T @ (scale * score))))


class _Likelihood:
    """Log-likelihood of the data by motion, with first and second derivatives."""

    def __init__(self, data: MixedData) -> None:
        self._values, self._count = data.bound, int(np.max(data.motion)) + 1
        censored = np.bincount(data.motion, data.lower != data.upper) > 0.0
        # motions without and with censored runs, their runs and their integrals
        self._parts: list[tuple[Mask, Mask, _Integrals]] = []
        for motions in (~censored, censored):
            if np.any(motions):
                runs = motions[data.motion]
                self._parts.append((motions, runs, _Integrals(data, runs)))

    def at(self, parameters: Floats) -> MixedFit:
        """Return the log-likelihood, its derivatives and expected values at parameters (m,)."""
        shape = self._count, parameters.size
        fit = MixedFit(
            parameters,
            score=np.empty(shape),
            information=np.empty((*shape, parameters.size)),
            logliks=np.empty(self._count),
            expected=self._values.copy(),
        )
        for motions, runs, part in self._parts:
            found = part.at(parameters)
            fit.score[motions], fit.information[motions], fit.logliks[motions] = found[:3]
            fit.expected[runs] = found[3]
        return fit


class _Integrals:
    """Integrals over the effect u of some motions, without any censored run or with some each."""

    def __init__(self, data: MixedData, runs: Mask) -> None:
        lower, upper, design = data.lower[runs], data.upper[runs], data.design[runs]
        motions, motion = np.unique(data.motion[runs], return_inverse=True)
        known, count = lower == upper, motions.size
        x, y = design[known], lower[known]
        sums = outer_by(motion[known], np.column_stack([np.ones(y.size), x, y]), count)
        self._n, self._x, self._y = sums[:, 0, 0], sums[:, 0, 1:-1], sums[:, 0, -1]
        self._xx, self._xy, self._yy = sums[:, 1:-1, 1:-1], sums[:, 1:-1, -1], sums[:, -1, -1]
        self._values, self._rows = data.bound[runs], np.flatnonzero(~known)  # of censored runs
        self._design, self._bound = design[~known], self._values[~known]
        self._sign = np.where(np.isinf(upper[~known]), 1.0, -1.0)
        self._motion = motion[~known]
        #: Sums over the censored rows of each motion, shape (G, h), and x x' of these rows.
        self._sum = (np.arange(count)[:, None] == self._motion).astype(np.float64)
        self._products = row_products(self._design, self._design)

    def at(self, parameters: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return score, information and log-likelihood by motion, and expected values of runs."""
        delta, (tau, sigma) = parameters[:-2], np.exp(parameters[-2:])
        residual = self._y - self._x @ delta
        square = self._yy - 2.0 * self._xy @ delta
        square = np.maximum(square + np.einsum("p,gpq,q->g", delta, self._xx, delta), 0.0)
        variance = 1.0 / (1.0 / tau**2 + self._n / sigma**2)  # of u given the known values
        mean = variance * residual / sigma**2
        above = self._design @ delta - self._bound
        u, weights = self._panels(mean, variance, above, sigma)
        t = self._sign[:, None] * (above[:, None] + u[self._motion]) / sigma
        tails, ratio = log_normal_tail(t)
        log_p = self._sum @ tails - 0.5 * (u - mean[:, None]) ** 2 / variance[:, None]
        highest = np.max(log_p, axis=1, keepdims=True)
        weights = weights * np.exp(log_p - highest)
        whole = np.sum(weights, axis=1, keepdims=True)
        weights /= whole
        loglik = np.log(whole[:, 0]) + highest[:, 0] - self._n * np.log(sigma) - np.log(tau)
        loglik += 0.5 * (mean**2 / variance - square / sigma**2)
        loglik -= 0.5 * (self._n + 1.0) * np.log(2.0 * np.pi)

        # score at each node, shape (G, m, Q), and the mean of the information there, (G, m, m)
        squares = square[:, None] - 2.0 * residual[:, None] * u + self._n[:, None] * u**2
        pull = (self._xy - self._xx @ delta) / sigma**2
        at_node = np.empty((u.shape[0], parameters.size, u.shape[1]))
        at_node[:, :-2] = pull[:, :, None] - (self._x / sigma**2)[:, :, None] * u[:, None, :]
        at_node[:, -2] = (u / tau) ** 2 - 1.0
        at_node[:, -1] = squares / sigma**2 - self._n[:, None]
        held = np.zeros((u.shape[0], parameters.size, parameters.size))
        held[:, :-2, :-2] = self._xx / sigma**2
        held[:, :-2, -1] = 2.0 * (at_node[:, :-2] @ weights[:, :, None])[:, :, 0]
        held[:, -2, -2] = 2.0 * np.sum(weights * (u / tau) ** 2, axis=1)
        held[:, -1, -1] = 2.0 * np.sum(weights * squares, axis=1) / sigma**2
        expected = self._values.copy()
        if self._rows.size:
            p, curve = weights[self._motion], ratio * (t + ratio)
            signed = self._design * self._sign[:, None] / sigma
            for column, values in enumerate(signed.T):
                at_node[:, column] += self._sum @ (values[:, None] * ratio)
            at_node[:, -1] -= self._sum @ (t * ratio)
            of_rows = self._products * np.sum(p * curve, axis=1)[:, None]
            held[:, :-2, :-2] += (self._sum @ of_rows).reshape(self._xx.shape) / sigma**2
            cross = np.sum(p * (ratio - curve * t), axis=1)
            held[:, :-2, -1] += self._sum @ (signed * cross[:, None])
            held[:, -1, -1] += self._sum @ np.sum(p * (curve * t**2 - t * ratio), axis=1)
            moved = u[self._motion] + sigma * self._sign[:, None] * ratio
            expected[self._rows] = self._design @ delta + np.sum(p * moved, axis=1)
        held[:, -1, :-2] = held[:, :-2, -1]
        score = (at_node @ weights[:, :, None])[:, :, 0]
        apart = (at_node - score[:, :, None]) * np.sqrt(weights)[:, None, :]
        return score, held - apart @ np.swapaxes(apart, 1, 2), loglik, expected

    def _panels(
        self, mean: Floats, variance: Floats, above: Floats, sigma: float
    ) -> tuple[Floats, Floats]:
        """Return nodes and weights of the integrals over u, shapes (G, Q)."""
        # `above` is the fitted value of each censored run less its bound, shape (h,)
        mode, prior, curve = mean.copy(), np.sqrt(variance), 1.0 / variance
        if self._rows.size == 0:  # the integrand is normal times a polynomial of degree 4
            return mode[:, None] + prior[:, None] * _NORMAL_NODES, prior[:, None] * _NORMAL_WEIGHTS
        for _ in range(_MODE_STEPS):
            t = self._sign * (above + mode[self._motion]) / sigma
            ratio = mills_ratio(t)
            slope = self._sum @ (self._sign * ratio) / sigma - (mode - mean) / variance
            curve = self._sum @ (ratio * (t + ratio)) / sigma**2 + 1.0 / variance
            step = np.clip(slope / curve, -4.0 * prior, 4.0 * prior)
            mode = mode + step
            if np.all(np.abs(step) < 0.01 * prior):
                break
        # the integrand is log-concave and at least as curved as the prior: its tails are no wider
        near = _REACH / np.sqrt(curve)
        far = np.maximum(_REACH * prior, near)
        ends = [mode, mode - far, mode + far]
        for width in (near, near + (far - near) / 3.0, near * _SHOULDER / _REACH):
            ends += [mode - width, mode + width]
        for sign, extreme in ((1.0, np.maximum), (-1.0, np.minimum)):
            censored = self._sign == sign
            if np.any(censored):
                edge = mode - sign * far
                extreme.at(edge, self._motion[censored], -above[censored])
                edges = [edge + share * sign * sigma for share in _EDGE]
                ends += [np.clip(each, mode - far, mode + far) for each in edges]
        borders = np.sort(np.stack(ends, axis=1), axis=1)
        half, middle = 0.5 * np.diff(borders), 0.5 * (borders[:, 1:] + borders[:, :-1])
        u = middle[:, :, None] + half[:, :, None] * _NODES
        shape = (mean.size, -1)
        return u.reshape(shape), (half[:, :, None] * _WEIGHTS).reshape(shape)
