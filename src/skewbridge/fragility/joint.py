"""Joint models: median capacities as functions of the axes of a study.

One model per bridge, abutment model and demand: ln D = terms of the axes + b ln IM + random effect
of the motion + scatter of the run. The slope b is common to all variants. The median of a state
with capacity c is therefore exp((ln c - terms)/b), all variants have the same dispersion, and the
curves of a component do not cross.

In matrix form, y = X delta + u_g + e with u_g ~ N(0, tau^2) for motion g and e ~ N(0, sigma^2) for
the run. A value y is known, right-censored (larger than a bound) or left-censored (smaller). The
likelihood of a motion is integrated over u_g by Gauss-Legendre panels. Newton's method maximises
the product of these likelihoods over delta, ln tau and ln sigma.

Sources: the model, Laird and Ware (1982), Biometrics 38(4):963-974; information of incomplete data,
Louis (1982), JRSS B 44(2):226-233; errors of left-out predictions, Allen (1974), Technometrics
16(1):125-127.
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations
from math import nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row
from skewbridge.fragility import demand_table
from skewbridge.fragility.fits import FITTED, NON_INCREASING, NOT_APPLICABLE
from skewbridge.fragility.likelihood import log_normal_tail, mills_ratio, row_products
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.motion_means import covered_range, jackknife_covariance
from skewbridge.fragility.outcomes import DemandOutcomes, demand_outcomes, states_by_demand
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.union import Union, correlation, reached_modes
from skewbridge.variant.axes import AXES, axis
from skewbridge.variant.variant import lacking_axes

SKEW: Final = "skew_deg"
_CLOUD_COLUMNS: Final = ["variant", "component", "limit_state", "theta", "var_ln_theta"]
_FLATTEST_SLOPE: Final = 1e-3
_STEP: Final = 1e-3  # change of a parameter, for derivatives

# Nodes and weights for integration by panels, and for integrals with a normal density.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_NORMAL_NODES, _HERMITE = np.polynomial.hermite_e.hermegauss(5)
_NORMAL_WEIGHTS: Final = _HERMITE * np.exp(0.5 * _NORMAL_NODES**2)
_DECREMENT: Final = 1e-10  # the step with a smaller gain of log-likelihood is the last
# smallest standard deviation / standard deviation of the least-squares residuals
_SMALLEST_SHARE: Final = 1e-4
_THINNEST: Final = 1e-10  # smallest eigenvalue of a scaled matrix that counts as regular
JOINT_COLUMNS: Final = demand_table.described("joint")


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedData:
    """Data of the n runs of a mixed model, arrays of shape (n,)."""

    design: Floats  # X, shape (n, p)
    lower: Floats  # lower bound of y; -inf if y is left-censored
    upper: Floats  # upper bound; equal to `lower` if y is known, inf if it is right-censored
    motion: Index  # number of the motion of each run, 0 .. G - 1

    @property
    def bound(self) -> Floats:
        """Value of y, or its only finite bound, shape (n,)."""
        return np.where(np.isfinite(self.lower), self.lower, self.upper)


@dataclass(frozen=True, slots=True)
class MixedFit:
    """A fitted mixed model; the m = p + 2 parameters are delta, ln tau and ln sigma."""

    parameters: Floats  # shape (m,)
    score: Floats  # first derivatives of the log-likelihood of each motion, shape (G, m)
    information: Floats  # negative second derivatives of it, shape (G, m, m)
    logliks: Floats  # log-likelihood of each motion, shape (G,)
    expected: Floats  # y, or its conditional expectation if censored, shape (n,)

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
    """Fit the mixed model by maximum likelihood; at least some values must be uncensored."""
    start, floor = _first_parameters(data)
    every = np.ones(int(np.max(data.motion)) + 1, dtype=np.bool_)
    return _maximised(_likelihood(data), start, floor, every, _DECREMENT)


def without_each_motion(data: MixedData, fit: MixedFit) -> Floats:
    """Return the parameters of G fits, each without one motion, shape (G, m).

    Each fit starts from a one-step estimate: exact for delta at fixed tau and sigma if all values
    are known, and close for tau and sigma if no motion has a large influence.
    """
    likelihood, (_, floor) = _likelihood(data), _first_parameters(data)
    total, count = np.sum(fit.information, axis=0), fit.score.shape[0]
    held = np.diag(total)[-2:] * (1.0 - 1.0 / count)
    rows: list[Floats] = []
    for motion, (score, information) in enumerate(zip(fit.score, fit.information, strict=True)):
        delta = fit.delta - _uphill(score[:-2], (total - information)[:-2, :-2])
        share = 1.0 - 2.0 * score[-2:] / np.maximum(held, count)
        deviations = fit.parameters[-2:] + 0.5 * np.log(np.clip(share, 0.2, 2.0))
        start, others = np.concatenate([delta, deviations]), np.arange(count) != motion
        rows.append(_maximised(likelihood, start, floor, others, 1e-4).parameters)
    return np.stack(rows)


def _maximised(
    likelihood: Callable[[Floats], MixedFit],
    start: Floats,
    floor: float,
    motions: Mask,
    decrement: float,
) -> MixedFit:
    """Return the maximum-likelihood fit to the selected motions, by Newton's method."""
    # `floor` is the smallest ln tau and ln sigma; iteration stops at a gain below `decrement`

    def at(parameters: Floats) -> MixedFit:
        return likelihood(np.append(parameters[:-2], np.maximum(parameters[-2:], floor)))

    fit = at(start)
    for _ in range(100):
        score = np.sum(fit.score[motions], axis=0)
        information = np.sum(fit.information[motions], axis=0)
        loglik = float(np.sum(fit.logliks[motions]))
        # hold a standard deviation at its floor if the data favour a smaller value
        for place in (-2, -1):
            if fit.parameters[place] <= floor and score[place] <= 0.0:
                score[place], information[place], information[:, place] = 0.0, 0.0, 0.0
                information[place, place] = 1.0
        step = _uphill(score, information)
        step /= max(1.0, float(np.max(np.abs(step[-2:]))))
        gain, trial = float(score @ step), fit
        for _ in range(30):
            trial = at(fit.parameters + step)
            if np.sum(trial.logliks[motions]) >= loglik - _DECREMENT * max(1.0, abs(loglik)):
                break
            step = 0.5 * step
        fit = trial
        if gain < decrement:
            break
    return fit


def outer_by(codes: Index, values: Floats, count: int) -> Floats:
    """Return the sum of x x' over the rows x of ``values`` (n, p) for each code, (count, p, p)."""
    order = np.argsort(codes, kind="stable")
    ends = np.cumsum(np.bincount(codes, minlength=count))[:-1]
    return np.stack([part.T @ part for part in np.split(values[order], ends)])


def _first_parameters(data: MixedData) -> tuple[Floats, float]:
    """Return start values (m,) from least squares, and the smallest ln tau and ln sigma."""
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
    """Return Newton's step (m,), reversed in directions in which the log-likelihood is convex."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(information)), 1e-300))
    values, vectors = np.linalg.eigh(information * scale[:, None] * scale)
    inverse = 1.0 / np.maximum(np.abs(values), _THINNEST)
    return scale * (vectors @ (inverse * (vectors.T @ (scale * score))))


def _likelihood(data: MixedData) -> Callable[[Floats], MixedFit]:
    """Return the function that evaluates the likelihood and its derivatives at parameters (m,)."""
    values, count = data.bound, int(np.max(data.motion)) + 1
    censored = np.bincount(data.motion, data.lower != data.upper) > 0.0
    # motions without and motions with censored runs: masks of motions and runs, and integrals
    kinds = [motions for motions in (~censored, censored) if np.any(motions)]
    parts = [(m, m[data.motion], _Integrals(data, m[data.motion])) for m in kinds]

    def at(parameters: Floats) -> MixedFit:
        shape = count, parameters.size
        empty = np.empty(shape), np.empty((*shape, parameters.size)), np.empty(count)
        fit = MixedFit(parameters, *empty, values.copy())
        for motions, runs, part in parts:
            found = part.at(parameters)
            fit.score[motions], fit.information[motions], fit.logliks[motions] = found[:3]
            fit.expected[runs] = found[3]
        return fit

    return at


class _Integrals:
    """Integrals over the random effect u: for motions with censored runs, or for all others."""

    def __init__(self, data: MixedData, runs: Mask) -> None:
        lower, upper, design = data.lower[runs], data.upper[runs], data.design[runs]
        motions, motion = np.unique(data.motion[runs], return_inverse=True)
        known, count = lower == upper, motions.size
        x, y = design[known], lower[known]
        sums = outer_by(motion[known], np.column_stack([np.ones(y.size), x, y]), count)
        self._n, self._x, self._y = sums[:, 0, 0], sums[:, 0, 1:-1], sums[:, 0, -1]
        self._xx, self._xy, self._yy = sums[:, 1:-1, 1:-1], sums[:, 1:-1, -1], sums[:, -1, -1]
        self._values, self._rows = data.bound[runs], np.flatnonzero(~known)  # rows: censored runs
        self._design, self._bound = design[~known], self._values[~known]
        self._sign = np.where(np.isinf(upper[~known]), 1.0, -1.0)
        self._motion = motion[~known]
        #: Matrix (G, h) that sums the h censored runs by motion, and x x' of these runs.
        self._sum = (np.arange(count)[:, None] == self._motion).astype(np.float64)
        self._products = row_products(self._design, self._design)

    def at(self, parameters: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return score, information, log-likelihood of each motion, and expected y of each run."""
        delta, (tau, sigma) = parameters[:-2], np.exp(parameters[-2:])
        residual = self._y - self._x @ delta
        square = self._yy - 2.0 * self._xy @ delta
        square = np.maximum(square + np.einsum("p,gpq,q->g", delta, self._xx, delta), 0.0)
        variance = 1.0 / (1.0 / tau**2 + self._n / sigma**2)  # variance of u given the known values
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
        """Return nodes and weights of the integrals over u, shape (G, Q) each."""
        # `above` (h,) is the fitted value of each censored run minus its bound
        mode, prior, curve = mean.copy(), np.sqrt(variance), 1.0 / variance
        if self._rows.size == 0:  # the integrand is a normal density times a polynomial of degree 4
            return mode[:, None] + prior[:, None] * _NORMAL_NODES, prior[:, None] * _NORMAL_WEIGHTS
        for _ in range(25):
            t = self._sign * (above + mode[self._motion]) / sigma
            ratio = mills_ratio(t)
            slope = self._sum @ (self._sign * ratio) / sigma - (mode - mean) / variance
            curve = self._sum @ (ratio * (t + ratio)) / sigma**2 + 1.0 / variance
            step = np.clip(slope / curve, -4.0 * prior, 4.0 * prior)
            mode = mode + step
            if np.all(np.abs(step) < 0.01 * prior):
                break
        # Panels end at multiples of the width of the integrand about its mode, and at multiples of
        # sigma about the extreme bounds of censored values, where the integrand changes fastest.
        # The integrand is log-concave and more curved than the prior, so its tails are not wider.
        near = 7.0 / np.sqrt(curve)
        far = np.maximum(7.0 * prior, near)
        ends = [mode, mode - far, mode + far]
        for width in (near, near + (far - near) / 3.0, near * 2.5 / 7.0):
            ends += [mode - width, mode + width]
        for sign, extreme in ((1.0, np.maximum), (-1.0, np.minimum)):
            censored = self._sign == sign
            if np.any(censored):
                edge = mode - sign * far
                extreme.at(edge, self._motion[censored], -above[censored])
                edges = [edge + share * sign * sigma for share in (-6.0, -1.0, 4.0)]
                ends += [np.clip(each, mode - far, mode + far) for each in edges]
        borders = np.sort(np.stack(ends, axis=1), axis=1)
        half, middle = 0.5 * np.diff(borders), 0.5 * (borders[:, 1:] + borders[:, :-1])
        u = middle[:, :, None] + half[:, :, None] * _NODES
        shape = (mean.size, -1)
        return u.reshape(shape), (half[:, :, None] * _WEIGHTS).reshape(shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisRange:
    """Range of the axes of the variants of one bridge and abutment model.

    The variables of a model are skew/60 degrees, gap/50.8 mm, axes without unit (such as friction)
    unchanged, and all other axes divided by their largest possible value. The absolute value of
    the skew is used unless the study has skews of both signs.
    """

    limits: Mapping[str, tuple[float, float]]  # smallest and largest value of each axis
    signed_skew: bool = False  # True if the study has skews of both signs

    @classmethod
    def of_variants(cls, variants: pd.DataFrame, names: Iterable[str]) -> "AxisRange":
        """Return the range of the named axes over a table with one row per variant."""
        skew = variants[SKEW].to_numpy(dtype=np.float64) if SKEW in variants else np.zeros(1)
        blank = cls(limits={}, signed_skew=bool(np.any(skew > 0.0) and np.any(skew < 0.0)))
        values = {name: blank._counted(name, variants[name].to_numpy(np.float64)) for name in names}
        limits = {name: (float(np.min(v)), float(np.max(v))) for name, v in values.items()}
        finite = {name: ends for name, ends in limits.items() if np.all(np.isfinite(ends))}
        return replace(blank, limits=finite)

    @property
    def varying(self) -> tuple[str, ...]:
        """Axes that differ between the variants."""
        return tuple(name for name, (low, high) in self.limits.items() if low < high)

    @property
    def middle(self) -> dict[str, float]:
        """Middle of the range of each varying axis."""
        return {name: 0.5 * sum(self.limits[name]) for name in self.varying}

    def variables(self, values: Mapping[str, Any]) -> dict[str, Floats]:
        """Return the model variable of each axis, shape (n,), for given values of the axes."""
        found: dict[str, Floats] = {}
        for name in self.varying:
            value = np.atleast_1d(self._counted(name, np.asarray(values[name], dtype=np.float64)))
            scale = 50.8 if name == "gap_mm" else axis(name).high  # 2 in
            is_scaled = axis(name).unit != "-" and 0.0 < scale < np.inf
            found[name] = value / scale if is_scaled else value
        return found

    def check(self, values: Mapping[str, float]) -> None:
        """Check a point; an `InputError` names an axis that is missing, unknown or out of range."""
        possible = {*self.limits, *(each.name for each in AXES)}
        for name in (*self.varying, *values):
            low, high = self.limits.get(name, (-np.inf, np.inf))
            problem = "" if name in possible else "is not an axis of the study"
            if name not in values:
                problem = f"is missing; give a value within {low:g}..{high:g}"
            elif not low - 1e-9 <= self._counted(name, values[name]) <= high + 1e-9:
                problem = f"must be within {low:g}..{high:g}, the range of the study"
                problem += f", got {values[name]:g}"
            if problem:
                raise InputError(f"{name} {problem}", column=name)

    def _counted(self, name: str, value: Any) -> Any:
        return abs(value) if name == SKEW and not self.signed_skew else value


def term_matrix(terms: Sequence[str], variables: Mapping[str, Floats]) -> Floats:
    """Return a column of ones and q terms (products of axes such as ``a:b``), shape (n, 1 + q)."""
    size = next((value.size for value in variables.values()), 1)
    products = [np.prod([variables[name] for name in term.split(":")], axis=0) for term in terms]
    return np.column_stack([np.ones(size), *products])


def term_sets(variables: Mapping[str, Floats]) -> list[tuple[str, ...]]:
    """Return the sets of terms to compare: main effects, alone or with squares and products.

    ``variables`` have the shape (V,), one value per variant. Terms that the variants cannot
    distinguish are left out. A square or product is added only if the model then has fewer
    coefficients than there are variants.
    """
    squares = [f"{name}:{name}" for name, value in variables.items() if np.unique(value).size > 2]
    products = [f"{a}:{b}" for a, b in combinations(variables, 2)]
    sets: list[tuple[str, ...]] = []
    for further in ([], squares, products, [*squares, *products]):
        kept: tuple[str, ...] = ()
        for term in [*variables, *further]:
            matrix = term_matrix((*kept, term), variables)
            if matrix.shape[0] - matrix.shape[1] >= (0 if term in variables else 1):
                kept = (*kept, term) if np.linalg.matrix_rank(matrix) == len(kept) + 2 else kept
        sets.append(kept)
    return list(dict.fromkeys(sets))


class JointModel:
    """A joint model of one limit state, from its row of results/fragility/joint.parquet."""

    def __init__(self, row: Mapping[str, Any]) -> None:
        limits = {name: (low, high) for name, (low, high) in json.loads(row["axis_ranges"]).items()}
        self.axis_range = AxisRange(limits=limits, signed_skew=bool(row["signed_skew"]))
        self.freedom, self.level = int(row["n_motions"]) - 2, float(row["level"])
        #: Terms of each failure mode; one mode if the state is not a union.
        self._terms = [tuple(filter(None, part.split(";"))) for part in row["terms"].split("|")]
        #: For each mode coefficients, ln beta and ln beta_total; for a union then the correlation.
        self._parameters = np.asarray(row["coefficients"], dtype=np.float64)
        if len(self._terms) == 1:
            betas = np.log([float(row["beta"]), float(row["beta_total"])])
            self._parameters = np.append(self._parameters, betas)
        size = self._parameters.size
        #: Covariance of these parameters.
        self.covariance = np.asarray(row["covariance"], dtype=np.float64).reshape(size, size)

    def interval(self, estimate: float, variance: float, level: float) -> tuple[float, float]:
        """Return the interval ends of exp(estimate), given the variance of the estimate."""
        half = special.stdtrit(self.freedom, 0.5 + 0.5 * level) * np.sqrt(variance)
        return float(np.exp(estimate - half)), float(np.exp(estimate + half))

    def unions(
        self, values: Mapping[str, float], parameters: Floats | None = None
    ) -> tuple[Union, Union]:
        """Return the curves at ``values`` with record-to-record and with total dispersion.

        ``parameters`` (K, p) give K curves; the default is the estimate.
        """
        sets = self._parameters[None, :] if parameters is None else parameters
        variables = self.axis_range.variables(values)
        ln_theta: list[Floats] = []
        betas: list[Floats] = []
        start = 0
        for terms in self._terms:
            vector = term_matrix(terms, variables)[0]
            stop = start + vector.size
            ln_theta.append(sets[:, start:stop] @ vector)
            betas.append(np.exp(sets[:, stop : stop + 2].T))
            start = stop + 2
        medians, (records, total) = np.array(ln_theta), np.swapaxes(betas, 0, 1)
        rho = sets[:, -1] if len(betas) > 1 else np.zeros(len(sets))
        return Union(medians, records, rho), Union.of(medians, records, total, rho)

    def logs(self, values: Mapping[str, float], parameters: Floats | None = None) -> Floats:
        """Return ln theta, ln beta and ln beta_total at ``values``, shape (K, 3)."""
        records, total = (each.summary() for each in self.unions(values, parameters))
        return np.column_stack([total[0], np.log(records[1]), np.log(total[1])])

    def gradient(self, values: Mapping[str, float]) -> Floats:
        """Return the derivatives of `logs` with respect to the parameters, shape (p, 3)."""
        steps = _STEP * np.eye(self._parameters.size)
        ends = (self.logs(values, self._parameters + sign * steps) for sign in (1.0, -1.0))
        return np.subtract(*ends) / (2.0 * _STEP)

    def median(
        self,
        values: Mapping[str, float],
        over: Mapping[str, float] | None = None,
        level: float | None = None,
    ) -> tuple[float, float, float]:
        """Return theta at ``values`` with interval ends, divided by theta at ``over`` if given."""
        estimate, slopes = self.logs(values)[0, 0], self.gradient(values)[:, 0]
        if over is not None:
            estimate = estimate - self.logs(over)[0, 0]
            slopes = slopes - self.gradient(over)[:, 0]
        variance = float(slopes @ self.covariance @ slopes)
        return (float(np.exp(estimate)), *self.interval(estimate, variance, level or self.level))


def joint_table(
    demands: pd.DataFrame,
    limit_states: States,
    curves: pd.DataFrame | None,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return table `joint`, with one row per bridge, abutment model and limit state."""
    own = pd.DataFrame(columns=_CLOUD_COLUMNS)
    if curves is not None:
        own = curves.query("method == 'cloud' and status == @FITTED")[_CLOUD_COLUMNS]
    items = (
        (
            model | {"im": settings.im, "level": settings.confidence},
            demand_table.demand_columns(part, [settings.im, demand]),
            states,
            own[own["component"] == component],
        )
        for model, part in demand_table.models_of(demands)
        for (component, demand), states in states_by_demand(limit_states).items()
    )
    rows = demand_table.spread(_rows, items, jobs, least=8)  # ASSUME an item takes about a second
    table = pd.DataFrame([row for part in rows for row in part], columns=list(JOINT_COLUMNS))
    if curves is not None:  # reject a model that cannot be compared with the fit of any variant
        unconfirmed = (table["status"] == FITTED) & table["loo_variants"].eq(0)
        table.loc[unconfirmed, "status"] = "no_variant_estimate"
    return table


def _rows(item: tuple[dict[str, Any], pd.DataFrame, list[LimitState], pd.DataFrame]) -> list[Row]:
    """Return one row per limit state of one demand."""
    model, runs, states, clouds = item
    lacking = lacking_axes(str(model["abutment"]))
    names = [name for name in demand_table.axis_names(runs) if name not in lacking]
    labels = runs["variant"].to_numpy(dtype=str)
    _, first, codes = np.unique(labels, return_index=True, return_inverse=True)
    variants = runs.iloc[first][["variant", *names]].reset_index(drop=True)
    axis_range = AxisRange.of_variants(variants, names)
    outcomes, im = demand_outcomes(runs, states), runs[str(model["im"])].to_numpy(dtype=np.float64)
    motion, ln_im = demand_table.motion_codes(runs), np.log(im)
    low, high = covered_range(im, motion)
    modes = {state: reached_modes(runs, state) or [state] for state in states}
    by_demand: dict[str, list[LimitState]] = {}
    for mode in chain.from_iterable(modes.values()):
        by_demand.setdefault(mode.demand, []).append(mode)
    fits = {
        demand: _fit_demand(demand_outcomes(runs, own), ln_im, motion, codes, axis_range, variants)
        for demand, own in by_demand.items()
    }
    rows: list[Row] = []
    for state in states:
        status = outcomes.status(state)
        row = model | state.columns | outcomes.counts(state) | {"n_variants": len(variants)}
        parts = [(fits[mode.demand], mode) for mode in modes[state]]
        failed = [fit for fit, _ in parts if isinstance(fit, str)]
        row["status"] = failed[0] if status == FITTED and failed else status
        row["axis_ranges"] = json.dumps(dict(axis_range.limits))
        row |= {"signed_skew": axis_range.signed_skew, "im_low": low, "im_high": high}
        if row["status"] == FITTED:
            own = clouds[clouds["limit_state"] == state.name].set_index("variant")
            fitted = [(fit, mode) for fit, mode in parts if not isinstance(fit, str)]
            row |= _estimate(fitted, row, own.reindex(variants["variant"]), motion)
        row["extrapolated"] = row["status"] == FITTED and not low <= row["theta"] <= high
        rows.append(row)
    return rows


class _DemandFit(NamedTuple):
    """Model of ln demand; the columns of X are 1, ln IM and the terms."""

    data: MixedData
    fit: MixedFit
    terms: tuple[str, ...]
    matrix: Floats  # constant and terms of each variant, (V, 1 + q)
    left_out_variant: Floats  # coefficients of fits without one variant, (V, p)
    press: float  # RMS error of ln demand of left-out variants
    motions: Index  # numbers of the G motions of the data
    without: Floats  # parameters without each of these motions, (G, m)
    residuals: Floats  # of all n runs, without each of all M motions; NaN for bounds, (1 + M, n)


def _fit_demand(
    outcomes: DemandOutcomes,
    ln_im: Floats,
    motion: Index,
    variant: Index,
    axis_range: AxisRange,
    variants: pd.DataFrame,
) -> _DemandFit | str:
    """Return the model that predicts left-out variants best, or the reason why there is none."""
    if not axis_range.varying:
        return "no_axis_varies"
    used, (lower, upper) = outcomes.used, outcomes.ln_ends
    known, variant = lower == upper, variant[used]
    count = int(np.max(motion)) + 1
    numbers, motion = np.unique(motion[used], return_inverse=True)
    if np.unique(motion[known]).size < 5:
        return "too_few_motions"
    values = {name: variants[name].to_numpy(dtype=np.float64) for name in axis_range.varying}
    variables = axis_range.variables(values)
    best: _DemandFit | None = None
    for terms in term_sets(variables):
        matrix = term_matrix(terms, variables)
        design = np.insert(matrix[variant], 1, ln_im[used], axis=1)
        if np.linalg.matrix_rank(design[known]) < design.shape[1]:
            continue
        data = MixedData(design=design, lower=lower, upper=upper, motion=motion)
        fit = fit_mixed(data)
        without, press = _without_each_variant(data, fit, variant, len(variants))
        if best is None or press < best.press * (1.0 - 1e-6):
            blank = np.full((1 + count, used.size), nan)
            best = _DemandFit(data, fit, terms, matrix, without, press, numbers, blank, blank)
    if best is None:
        return NOT_APPLICABLE
    left_out = without_each_motion(best.data, best.fit)
    lines = np.tile(best.fit.delta, (1 + count, 1))
    lines[1 + numbers] = left_out[:, :-2]
    best.residuals[:, used] = np.where(known, lower, nan) - lines @ best.data.design.T
    return best._replace(without=left_out)


def _without_each_variant(
    data: MixedData, fit: MixedFit, variant: Index, count: int
) -> tuple[Floats, float]:
    """Return coefficients (V, p) of V fits without one variant, and the RMS prediction error."""
    # generalised least squares; NaN and an infinite error if the other variants do not suffice
    # ASSUME tau, sigma and the expected values of censored demands of the other variants do not
    # change if a variant is left out
    values = np.column_stack([data.design, fit.expected])
    motions, size = int(np.max(data.motion)) + 1, values.shape[1]
    cell = np.zeros((count, motions, size))
    np.add.at(cell, (variant, data.motion), values)
    runs = np.zeros((count, motions))
    np.add.at(runs, (variant, data.motion), 1.0)
    others, left = np.sum(cell, axis=0) - cell, np.sum(runs, axis=0) - runs
    shrinkage = fit.tau**2 / (fit.sigma**2 + left * fit.tau**2)
    products = values.T @ values - outer_by(variant, values, count)
    shrunk = others * np.sqrt(shrinkage)[:, :, None]
    products -= np.swapaxes(shrunk, 1, 2) @ shrunk
    matrix, right = products[:, :-1, :-1], products[:, :-1, -1]
    scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), 1e-300))
    matrix = matrix / scale[:, :, None] / scale[:, None, :]
    sure = np.linalg.eigvalsh(matrix)[:, 0] > _THINNEST
    out = np.full(scale.shape, np.nan)
    out[sure] = np.linalg.solve(matrix[sure], (right / scale)[sure][:, :, None])[:, :, 0]
    out /= scale
    effect = shrinkage * (others[:, :, -1] - np.einsum("vgp,vp->vg", others[:, :, :-1], out))
    error = fit.expected - np.sum(data.design * out[variant], axis=1)
    error -= effect[variant, data.motion]
    return out, float(np.sqrt(np.mean(error**2))) if np.all(sure) else np.inf


def _estimate(
    modes: Sequence[tuple[_DemandFit, LimitState]],
    row: Mapping[str, Any],
    own: pd.DataFrame,  # cloud fits of the V variants
    motion: Index,  # number of the motion of each run, (n,)
) -> Row:
    """Return the table columns of one state, which is the union of one or two modes."""
    fits, single = [fit for fit, _ in modes], len(modes) == 1
    numbers = np.unique(np.concatenate([fit.motions for fit in fits]))
    found: dict[str, Any] = {"terms": "|".join(";".join(fit.terms) for fit in fits)}
    found |= {"n_runs": max(fit.data.motion.size for fit in fits), "n_motions": numbers.size}
    for side, name in (("right", "upper"), ("left", "lower")):
        censored = [np.sum(np.isinf(getattr(fit.data, name))) for fit in fits]
        found[f"n_{side}_censored"] = int(max(censored))
    if single:
        found |= {"slope": float(fits[0].fit.delta[1]), "press": fits[0].press}
        found["capacity_dispersion"] = modes[0][1].dispersion
        found |= {"tau": fits[0].fit.tau, "sigma": fits[0].fit.sigma}
    estimates: list[Floats] = []
    for fit, state in modes:
        motions = fit.motions.size
        one = _state_parameters(fit.fit.parameters[None, :], motions, state)
        each = np.tile(one, (1 + numbers.size, 1))
        left_out = _state_parameters(fit.without, motions - 1, state)
        each[1 + np.searchsorted(numbers, fit.motions)] = left_out
        estimates.append(each)
    if not single:
        rows = np.append(0, 1 + numbers)
        weights = (motion != rows[:, None] - 1).astype(np.float64)
        first, second = (fit.residuals[rows] for fit in fits)
        estimates.append(correlation(first, second, weights)[:, None])
    estimate, *without = np.column_stack(estimates)
    if not (np.all(np.isfinite(estimate)) and np.all(np.isfinite(without))):
        return found | {"status": NON_INCREASING}
    found |= {"beta": float(np.exp(estimate[-2])), "beta_total": float(np.exp(estimate[-1]))}
    found["coefficients"] = (estimate[:-2] if single else estimate).tolist()
    found["covariance"] = jackknife_covariance(np.array(without)).ravel().tolist()
    model = JointModel({**row, **found})
    middle = model.axis_range.middle
    logs, slopes = model.logs(middle)[0], model.gradient(middle)
    for name, value, slope in zip(("theta", "beta", "beta_total"), logs, slopes.T, strict=True):
        found[name] = float(np.exp(value))
        ends = model.interval(value, float(slope @ model.covariance @ slope), model.level)
        found[f"{name}_low"], found[f"{name}_high"] = ends
    ln_theta = np.array([_left_out_medians(*mode) for mode in modes])
    union = model.unions(middle)[1]
    predicted = np.exp(Union(ln_theta, union.beta, union.rho).quantile(0.0))
    error = np.abs(predicted / own["theta"].to_numpy(dtype=np.float64) - 1.0)
    if not (compared := int(np.sum(np.isfinite(error)))):
        return found | {"loo_variants": 0}
    worst = int(np.nanargmax(error))
    found |= {"loo_variants": compared, "loo_error": float(np.nanmedian(error))}
    found |= {"loo_error_max": float(error[worst]), "loo_error_max_variant": str(own.index[worst])}
    found["loo_error_max_se"] = float(np.sqrt(own["var_ln_theta"].iloc[worst]))
    return found | ({"status": "prediction_error_above_25_percent"} if error[worst] > 0.25 else {})


def _left_out_medians(fit: _DemandFit, state: LimitState) -> Floats:
    """Return ln median of each variant, from the fit without that variant, shape (V,)."""
    delta = fit.left_out_variant
    slope = np.where(delta[:, 1] > _FLATTEST_SLOPE, delta[:, 1], nan)
    level = delta[:, 0] + np.sum(delta[:, 2:] * fit.matrix[:, 1:], axis=1)
    return (np.log(state.threshold) - level) / slope


def _state_parameters(parameters: Floats, motions: int, state: LimitState) -> Floats:
    """Return coefficients of ln theta, ln beta and ln beta_total, shape (K, 3 + q)."""
    # `parameters` have the shape (K, m); NaN if the slope is not positive
    slope = parameters[:, 1:2]
    slope = np.where(slope > _FLATTEST_SLOPE, slope, nan)
    level = np.column_stack([np.log(state.threshold) - parameters[:, 0], -parameters[:, 2:-2]])
    # correct the maximum-likelihood variance for two estimated parameters: level and slope
    variance = np.sum(np.exp(2.0 * parameters[:, -2:]), axis=1) * motions / (motions - 2.0)
    total = variance + state.dispersion**2
    spread_terms = 0.5 * np.log(np.column_stack([variance, total])) - np.log(slope)
    return np.column_stack([level / slope, spread_terms])
