"""Ordered probit: several limit states of one demand, one dispersion; the curves never cross.

P(DS >= l | x) = Phi(a0_l + a1 ln x), theta_l = exp(-a0_l/a1), beta = 1/a1.

References:
    McCullagh (1980), JRSS B 42(2):109-142; Porter, Kennedy and Bachman (2007), Earthquake Spectra
    23(2):471-489, for the crossing of separately fitted curves.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.censored import Brackets, Sum, Tails
from skewbridge.fragility.old_likelihood.fit import FITTED, FLATTEST_SLOPE
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.newton import Derivatives, maximise
from skewbridge.fragility.old_likelihood.validate import positive, require


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderedFit:
    """Curves with a common dispersion.

    Attributes:
        status: ``ok``, or why there is no estimate.
        theta: Medians, shape (L,), increasing.
        beta: Common dispersion.
        covariance: Of (ln theta_1 .. ln theta_L, beta), shape (L+1, L+1).
        loglik: Log-likelihood without multinomial coefficients.
        common_beta_p: p-value of the likelihood ratio to curves with dispersions of their own; NaN
            where those have no estimate.
    """

    status: str
    theta: FloatArray
    beta: float
    covariance: FloatArray
    loglik: float
    common_beta_p: float = np.nan


class OrderedKernel:
    """Multinomial counts over ordered states; parameters (a0_1 .. a0_L, a1) or (.., a1_1 .. a1_L).

    Args:
        ln_im: Shape (J,).
        counts: Runs that end in state 0 .. L, shape (J, L + 1).
        common: One slope for all states; else each has its own, and the likelihood is zero where
            curves cross at an intensity of the data.
    """

    def __init__(self, ln_im: FloatArray, counts: FloatArray, *, common: bool = True) -> None:
        self._common = common
        last = counts.shape[1] - 1
        slopes = 1 if common else last

        def design(state: int, rows: NDArray[np.intp]) -> FloatArray:
            found = np.zeros((rows.size, last + slopes))
            found[:, state - 1] = 1.0
            found[:, -1 if common else last + state - 1] = ln_im[rows]
            return found

        ends = [np.flatnonzero(counts[:, state] > 0.0) for state in range(last + 1)]
        self._weights = [counts[rows, state] for state, rows in enumerate(ends)]
        self._none, self._all = Tails.of(design(1, ends[0])), Tails.of(design(last, ends[last]))
        self._between = [
            Brackets.of(upper=design(state, ends[state]), lower=design(state + 1, ends[state]))
            for state in range(1, last)
        ]

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate the batch; minus infinity where the intercepts are out of order."""
        total = Sum(params)
        total.add_tail(self._none, self._weights[0], -1.0)
        for brackets, weights in zip(self._between, self._weights[1:-1], strict=True):
            total.add_interval(brackets, weights)
        total.add_tail(self._all, self._weights[-1], 1.0)
        loglik = total.loglik
        if self._common:
            ordered = np.all(np.diff(params[:, :-1], axis=1) < 0.0, axis=1)
            loglik = np.where(ordered, loglik, -np.inf)
        return Derivatives(loglik, total.score, total.hessian)


def fit_ordered(im: ArrayLike, counts: ArrayLike) -> OrderedFit:
    """Fit an ordered probit to counts of the worst limit state reached.

    ``counts`` are the runs per intensity that end in no, the first, .. the last limit state, shape
    (J, L + 1), ``im`` has shape (J,).

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
    total = np.sum(table, axis=1)
    above = np.cumsum(table[:, ::-1], axis=1)[:, ::-1]

    blank = OrderedFit(
        status=FITTED,
        theta=np.full(states, np.nan),
        beta=np.nan,
        covariance=np.full((states + 1, states + 1), np.nan),
        loglik=np.nan,
    )
    if np.any(np.sum(table, axis=0) == 0.0):
        return replace(blank, status="empty_state")
    # One curve with an estimate is enough: its overlap bounds the common slope.
    found = {existence.binomial_status(x, total, above[:, state]) for state in range(1, states + 1)}
    if FITTED not in found:
        return replace(blank, status=sorted(found)[0])
    share = np.sum(above[:, 1:], axis=0) / np.sum(total)
    start = np.append(special.ndtri(share), 0.0)
    best = maximise(OrderedKernel(x, table), start[None, :])
    params = best.params[0]
    slope = float(params[-1])
    if not bool(best.converged[0]):
        return replace(blank, status=existence.NOT_CONVERGED)
    if slope <= FLATTEST_SLOPE:
        return replace(blank, status=existence.NON_INCREASING)
    jacobian = np.zeros((states + 1, states + 1))
    jacobian[:states, :states] = -np.eye(states) / slope
    jacobian[:states, -1] = params[:-1] / slope**2
    jacobian[-1, -1] = -1.0 / slope**2
    return replace(
        blank,
        theta=np.exp(-params[:-1] / slope),
        beta=1.0 / slope,
        covariance=jacobian @ best.covariance[0] @ jacobian.T,
        loglik=float(best.loglik[0]),
        common_beta_p=_common_beta_p(x, table, params, float(best.loglik[0])),
    )


def _common_beta_p(x: FloatArray, counts: FloatArray, params: FloatArray, loglik: float) -> float:
    """Return the p-value of the likelihood ratio of free slopes to a common one."""
    states = counts.shape[1] - 1
    total = np.sum(counts, axis=1)
    above = np.cumsum(counts[:, ::-1], axis=1)[:, ::-1]
    alone = {existence.binomial_status(x, total, above[:, i + 1]) for i in range(states)}
    if states < 2 or alone != {FITTED}:
        return float("nan")
    start = np.concatenate([params[:-1], np.full(states, params[-1])])
    free = maximise(OrderedKernel(x, counts, common=False), start[None, :], covariance=False)
    if not bool(free.converged[0]):
        return float("nan")
    ratio = max(2.0 * (float(free.loglik[0]) - loglik), 0.0)
    return float(special.chdtrc(states - 1, ratio))


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
