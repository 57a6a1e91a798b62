"""The one likelihood engine: concave log-likelihoods and a batched Newton method.

Every model of this package is a sum of log-concave terms in linear predictors of its parameters, so
the maximum is unique where it exists and Newton with the observed information finds it. A batch
of R parameter vectors is treated at once: bootstrap replicates, ends of profile intervals.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.old_likelihood.links import (
    FloatArray,
    LinkTerms,
    link_terms,
    probit_side,
)

_DECREMENT_TOLERANCE: Final = 1e-10  # the last Newton step squares it
_MAX_ITERATIONS: Final = 80
_MAX_HALVINGS: Final = 40


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
        """Evaluate at ``params`` (R, p); ``rows`` names their replicates in the batch."""
        ...


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


def row_products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return x y' of the rows of two designs of shape (J, p), shape (J, p p)."""
    return (first[:, :, None] * second[:, None, :]).reshape(-1, first.shape[1] ** 2)


class BinomialKernel:
    """Binomial counts over a linear predictor: sum k ln F(eta) + (n - k) ln(1 - F(eta)).

    Args:
        design: Shape (J, p).
        n: Trials, shape (J,) or (R, J); need not be whole (record weights).
        k: Exceedances, same shape, 0 <= k <= n; fractions allowed.
        link: Name of the link.
        offset: Added to the predictor, shape (J,).

    References:
        Baker (2015), Earthquake Spectra 31(1):579-599, Eq. 11 (without the binomial coefficient).
    """

    def __init__(
        self,
        design: FloatArray,
        n: FloatArray,
        k: FloatArray,
        link: str = "probit",
        offset: FloatArray | None = None,
    ) -> None:
        self.design = design
        self.exceed = k
        self.remain = n - k
        self.offset = offset
        self._terms: Callable[[FloatArray], LinkTerms] = link_terms(link)
        # single runs exceed or do not: half of the terms would be multiplied by zero
        single = link == "probit" and bool(np.all((k == 0.0) | (k == n)))
        self._sign = np.where(k > 0.0, 1.0, -1.0) if single else None
        self._products = row_products(design, design)

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate the batch; see `Kernel`."""
        k, m = self.exceed, self.remain
        if k.ndim == 2 and rows is not None:
            k, m = k[rows], m[rows]
        eta = params @ self.design.T
        if self.offset is not None:
            eta = eta + self.offset
        size = params.shape[1]
        if self._sign is not None:
            sign = self._sign if k.ndim == 1 or rows is None else self._sign[rows]
            runs = k + m
            log_p, first, second = probit_side(sign * eta)
            return Derivatives(
                np.sum(runs * log_p, axis=1),
                (runs * sign * first) @ self.design,
                ((runs * second) @ self._products).reshape(-1, size, size),
            )
        terms = self._terms(eta)
        return Derivatives(
            np.sum(k * terms.log_p + m * terms.log_q, axis=1),
            (k * terms.d_log_p + m * terms.d_log_q) @ self.design,
            ((k * terms.d2_log_p + m * terms.d2_log_q) @ self._products).reshape(-1, size, size),
        )


class Restricted:
    """A kernel at parameters = base + t directions, a function of t.

    Args:
        kernel: The log-likelihood of p parameters.
        base: Shape (p,), or (R, p) if each replicate has its own.
        directions: Shape (q, p).
    """

    def __init__(self, kernel: Kernel, base: FloatArray, directions: FloatArray) -> None:
        self._kernel, self._base, self._directions = kernel, base, directions

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate at t = ``params``, shape (R, q)."""
        base = self._base if rows is None or self._base.ndim == 1 else self._base[rows]
        full = self._kernel.derivatives(base + params @ self._directions)
        across = self._directions.T
        along = self._directions @ full.hessian @ across
        return Derivatives(full.loglik, full.score @ across, along)


def maximise(kernel: Kernel, start: FloatArray, *, covariance: bool = True) -> Maximum:
    """Maximise a batch of concave log-likelihoods by Newton steps with halving.

    ``start`` has shape (R, p) and lies inside the parameter space; ``covariance`` asks for the
    inverse of the observed information at the maximum.

    Returns:
        The maxima; ``converged`` is False where no maximum was reached.
    """
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
    inverse = _inverse(-hessian) if covariance else np.empty((0, 0, 0))
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
    if score.shape[1] == 3:
        return _step_of_three(hessian, score)
    step = np.zeros_like(score)
    good = np.all(np.isfinite(hessian), axis=(1, 2)) & (np.abs(np.linalg.det(hessian)) > 0.0)
    step[good] = np.linalg.solve(-hessian[good], score[good][..., None])[..., 0]
    return step


def _step_of_three(hessian: FloatArray, score: FloatArray) -> FloatArray:
    """Return the steps of three parameters by cofactors: solvers of many small systems are slow."""
    a, b, c, d, e, f = (
        hessian[:, i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    )
    x, y, z = score.T
    with np.errstate(all="ignore"):
        first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
        fourth, fifth, sixth = a * f - c * c, b * c - a * e, a * d - b * b
        det = a * first + b * second + c * third
        total = [
            first * x + second * y + third * z,
            second * x + fourth * y + fifth * z,
            third * x + fifth * y + sixth * z,
        ]
        step = np.stack(total, axis=1) / -det[:, None]
    return np.where((np.isfinite(det) & (det != 0.0))[:, None], step, 0.0)


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


def _inverse(information: FloatArray) -> FloatArray:
    """Return the inverses; NaN where the information is singular."""
    out = np.full_like(information, np.nan)
    with np.errstate(all="ignore"):
        good = np.all(np.isfinite(information), axis=(1, 2))
        good[good] = np.linalg.det(information[good]) > 0.0
    out[good] = np.linalg.inv(information[good])
    return out
