"""Ordered probit: several limit states of one demand, one dispersion; the curves never cross.

P(DS >= l | x) = Phi(a0_l + a1 ln x), theta_l = exp(-a0_l/a1), beta = 1/a1.

References:
    McCullagh (1980), JRSS B 42(2):109-142; Porter, Kennedy and Bachman (2007), Earthquake Spectra
    23(2):471-489, for the crossing of separately fitted curves.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.censored import add_terms, log_normal_interval, normal_density
from skewbridge.fragility.likelihood.fit import FITTED, FLATTEST_SLOPE
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.newton import Derivatives, maximise
from skewbridge.fragility.likelihood.validate import positive, require


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderedFit:
    """Curves with a common dispersion.

    Attributes:
        status: ``ok``, or why there is no estimate.
        theta: Medians, shape (L,), increasing.
        beta: Common dispersion.
        covariance: Of (ln theta_1 .. ln theta_L, beta), shape (L+1, L+1).
        loglik: Log-likelihood without multinomial coefficients.
    """

    status: str
    theta: FloatArray
    beta: float
    covariance: FloatArray
    loglik: float


class OrderedKernel:
    """Multinomial counts over ordered states; parameters (a0_1 .. a0_L, a1).

    Args:
        ln_im: Shape (J,).
        counts: Runs that end in state 0 .. L, shape (J, L + 1).
    """

    def __init__(self, ln_im: FloatArray, counts: FloatArray) -> None:
        self._x, self._counts = ln_im, counts
        self._states = counts.shape[1] - 1

    def _design(self, state: int) -> FloatArray:
        design = np.zeros((self._x.size, self._states + 1))
        design[:, state - 1] = 1.0
        design[:, -1] = self._x
        return design

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate the batch; minus infinity where the intercepts are out of order."""
        loglik = np.zeros(params.shape[0])
        score, hessian = np.zeros(params.shape), np.zeros((*params.shape, params.shape[1]))
        for state in range(self._states + 1):
            w = self._counts[:, state]
            if state in (0, self._states):
                design = self._design(max(state, 1))
                sign = -1.0 if state == 0 else 1.0
                u = sign * (params @ design.T)
                ratio = np.sqrt(2.0 / np.pi) / special.erfcx(-u / np.sqrt(2.0))
                loglik += np.sum(w * special.log_ndtr(u), axis=1)
                add_terms(score, hessian, design, sign * w * ratio, -w * ratio * (u + ratio))
                continue
            upper, lower = self._design(state), self._design(state + 1)
            zu, zl = params @ upper.T, params @ lower.T
            log_p = log_normal_interval(zl, zu)
            pu, pl = normal_density(zu, log_p), normal_density(zl, log_p)
            loglik += np.sum(np.where(w > 0.0, w * log_p, 0.0), axis=1)
            add_terms(score, hessian, upper, w * pu, -w * pu * (zu + pu))
            add_terms(score, hessian, lower, -w * pl, w * pl * (zl - pl))
            cross = np.einsum("rj,jp,jq->rpq", w * pu * pl, upper, lower)
            hessian += cross + np.swapaxes(cross, 1, 2)
        ordered = np.all(np.diff(params[:, :-1], axis=1) < 0.0, axis=1)
        return Derivatives(np.where(ordered, loglik, -np.inf), score, hessian)


def fit_ordered(im: ArrayLike, counts: ArrayLike) -> OrderedFit:
    """Fit an ordered probit to counts of the worst limit state reached.

    Args:
        im: Intensities, shape (J,).
        counts: Runs per intensity that end in no, the first, .. the last limit state,
            shape (J, L + 1).

    Raises:
        InputError: An intensity is not positive or a count negative; names the row.
    """
    x = np.log(positive(im, "im"))
    table = np.asarray(counts, dtype=np.float64)
    if table.ndim != 2 or table.shape[0] != x.size or table.shape[1] < 2:
        raise InputError(
            f"counts must have {x.size} rows and a column per state, got shape {table.shape}",
            column="counts",
        )
    require(np.all(table >= 0.0, axis=1), "counts", "must be >= 0", np.min(table, axis=1))
    states = table.shape[1] - 1
    blank = np.full(states, np.nan)
    total = np.sum(table, axis=1)
    above = np.cumsum(table[:, ::-1], axis=1)[:, ::-1]

    def refused(status: str) -> OrderedFit:
        matrix = np.full((states + 1, states + 1), np.nan)
        return OrderedFit(status=status, theta=blank, beta=np.nan, covariance=matrix, loglik=np.nan)

    if np.any(np.sum(table, axis=0) == 0.0):
        return refused("empty_state")
    # One curve with an estimate is enough: its overlap bounds the common slope.
    found = {existence.binomial_status(x, total, above[:, state]) for state in range(1, states + 1)}
    if FITTED not in found:
        return refused(sorted(found)[0])
    share = np.sum(above[:, 1:], axis=0) / np.sum(total)
    start = np.append(special.ndtri(share), 0.0)
    best = maximise(OrderedKernel(x, table), start[None, :])
    params = best.params[0]
    slope = float(params[-1])
    if not bool(best.converged[0]):
        return refused("not_converged")
    if slope <= FLATTEST_SLOPE:
        return refused(existence.NON_INCREASING)
    jacobian = np.zeros((states + 1, states + 1))
    jacobian[:states, :states] = -np.eye(states) / slope
    jacobian[:states, -1] = params[:-1] / slope**2
    jacobian[-1, -1] = -1.0 / slope**2
    return OrderedFit(
        status=FITTED,
        theta=np.exp(-params[:-1] / slope),
        beta=1.0 / slope,
        covariance=jacobian @ best.covariance[0] @ jacobian.T,
        loglik=float(best.loglik[0]),
    )


def crossing(
    theta: FloatArray, beta: FloatArray, im_low: float, im_high: float
) -> list[tuple[int, int, float]]:
    """Return where separately fitted curves of successive limit states cross inside a range.

    Returns:
        (first, second, intensity) per crossing; curves of equal dispersion never cross.
    """
    found: list[tuple[int, int, float]] = []
    for first in range(theta.size - 1):
        second = first + 1
        difference = 1.0 / beta[first] - 1.0 / beta[second]
        if difference == 0.0:
            continue
        offset = np.log(theta[first]) / beta[first] - np.log(theta[second]) / beta[second]
        # equal dispersions but for rounding cross where no intensity is
        at = float(np.exp(np.clip(offset / difference, -700.0, 700.0)))
        if im_low <= at <= im_high:
            found.append((first, second, at))
    return found
