"""Normal log-likelihood of observed, right-, left- and interval-censored values (one kernel).

The parameterisation is that of Olsen (1978), Econometrica 46(5): standardised residuals are
linear in the parameters, z = h y - X delta with h = 1/sigma, so that every term is concave.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.old_likelihood.links import HALF_LOG_2PI, FloatArray, probit_side
from skewbridge.fragility.old_likelihood.newton import Derivatives, row_products


@dataclass(frozen=True, slots=True)
class Tails:
    """Rows known on one side: their design and its products, for many evaluations."""

    design: FloatArray
    products: FloatArray

    @classmethod
    def of(cls, design: FloatArray) -> Self:
        """Return the rows of a design of shape (J, p)."""
        return cls(design, row_products(design, design))


@dataclass(frozen=True, slots=True)
class Brackets:
    """Rows known to lie between two ends: both designs, and x y' + y x' of the two."""

    upper: Tails
    lower: Tails
    cross: FloatArray

    @classmethod
    def of(cls, upper: FloatArray, lower: FloatArray) -> Self:
        """Return the rows of two designs of shape (J, p)."""
        cross = row_products(upper, lower) + row_products(lower, upper)
        return cls(Tails.of(upper), Tails.of(lower), cross)


@dataclass(frozen=True, slots=True)
class _Squares:
    """The observed rows: their log-likelihood is a quadratic form in the parameters.

    The residuals are z = d onto params with rows d = (-x, residual of y about a line), so that
    nothing cancels where the scatter is small.

    Attributes:
        onto: Shape (p, p).
        sums: Sum of w d d' over the rows, shape (p, p) or (R, p, p).
        curve: The same of the parameters, onto' sums onto.
        count: Sum of w, shape () or (R,).
    """

    onto: FloatArray
    sums: FloatArray
    curve: FloatArray
    count: FloatArray

    @classmethod
    def of(cls, covariates: FloatArray, y: FloatArray, weights: FloatArray) -> Self:
        """Return the sums over rows of the design and their observed values."""
        size = covariates.shape[1] + 1
        line = np.linalg.lstsq(covariates, y)[0]
        onto = np.eye(size)
        onto[:-1, -1] = -line
        rows = np.column_stack([-covariates, y - covariates @ line])
        sums = (weights @ row_products(rows, rows)).reshape(*weights.shape[:-1], size, size)
        return cls(onto, sums, onto.T @ sums @ onto, np.sum(weights, axis=-1))

    def at(self, rows: NDArray[np.intp]) -> Self:
        """Return the sums of some replicates."""
        return replace(self, sums=self.sums[rows], curve=self.curve[rows], count=self.count[rows])

    def add_to(self, total: "Sum", params: FloatArray, h: FloatArray) -> None:
        """Add ln h - z^2/2 - ln(2 pi)/2 of the rows."""
        turned = params @ self.onto.T
        product = np.einsum("...ij,...j->...i", self.sums, turned)
        total.loglik += self.count * (np.log(h) - HALF_LOG_2PI)
        total.loglik -= 0.5 * np.sum(turned * product, axis=1)
        total.score -= product @ self.onto
        total.score[:, -1] += self.count / h
        total.hessian -= self.curve
        total.hessian[:, -1, -1] -= self.count / h**2


class CensoredKernel:
    """Sum over rows of ln f(y) if observed, else of ln P(lower < Y <= upper).

    Args:
        covariates: X, shape (J, q); the mean of Y is X delta sigma.
        lower: Lower ends in the space of Y, shape (J,); minus infinity where left-censored.
        upper: Upper ends; equal to ``lower`` where observed, infinity where right-censored.
        weights: Shape (J,) or (R, J): record weights of a bootstrap.

    The parameters are (delta_1..delta_q, h); the log-likelihood is minus infinity for h <= 0.
    The Jacobian ln h per observed row is part of it: without it there is no maximum in h.
    """

    def __init__(
        self,
        covariates: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        weights: FloatArray | None = None,
    ) -> None:
        self.weights = np.ones(lower.size) if weights is None else weights
        observed = lower == upper
        both = ~observed & np.isfinite(lower) & np.isfinite(upper)
        right = ~observed & np.isfinite(lower) & ~np.isfinite(upper)
        left = ~observed & ~np.isfinite(lower) & np.isfinite(upper)

        def design(mask: NDArray[np.bool_], ends: FloatArray) -> FloatArray:
            return np.column_stack([-covariates[mask], ends[mask]])

        self._rows = [np.flatnonzero(mask) for mask in (right, left, both)]
        self._right, self._left = Tails.of(design(right, lower)), Tails.of(design(left, upper))
        self._both = Brackets.of(design(both, upper), design(both, lower))
        self._observed = _Squares.of(
            covariates[observed], lower[observed], self.weights[..., observed]
        )

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate the batch; see `skewbridge.fragility.old_likelihood.newton.Kernel`."""
        weights = self.weights
        if weights.ndim == 2 and rows is not None:
            weights = weights[rows]
        total = Sum(params)
        h = params[:, -1]
        inside = h > 0.0
        safe_h = np.where(inside, h, 1.0)

        squares = self._observed
        if self.weights.ndim == 2 and rows is not None:
            squares = squares.at(rows)
        squares.add_to(total, params, safe_h)
        right, left, both = self._rows
        if right.size:
            total.add_tail(self._right, weights[..., right], -1.0)
        if left.size:
            total.add_tail(self._left, weights[..., left], 1.0)
        if both.size:
            total.add_interval(self._both, weights[..., both])
        loglik = np.where(inside, total.loglik, -np.inf)
        return Derivatives(loglik, total.score, total.hessian)


class Sum:
    """Log-likelihood of R parameter vectors (R, p) with its derivatives, summed term by term."""

    def __init__(self, params: FloatArray) -> None:
        self._params = params
        self.loglik = np.zeros(params.shape[0])
        self.score = np.zeros(params.shape)
        self.hessian = np.zeros((*params.shape, params.shape[1]))

    def add(self, rows: Tails, d1: FloatArray, d2: FloatArray) -> None:
        """Add sum d1 x and sum d2 x x' over the rows x of a design to score and Hessian."""
        self.score += d1 @ rows.design
        self.hessian += (d2 @ rows.products).reshape(self.hessian.shape)

    def add_tail(self, rows: Tails, weights: FloatArray, sign: float) -> None:
        """Add sum w ln Phi(sign z) over the rows, z = design params."""
        u = sign * (self._params @ rows.design.T)
        log_p, first, second = probit_side(u)
        self.loglik += np.sum(weights * log_p, axis=1)
        self.add(rows, sign * weights * first, weights * second)

    def add_interval(self, rows: Brackets, weights: FloatArray) -> None:
        """Add sum w ln[Phi(z_upper) - Phi(z_lower)] over the rows."""
        zu, zl = self._params @ rows.upper.design.T, self._params @ rows.lower.design.T
        log_p = log_normal_interval(zl, zu)
        pu, pl = normal_density(zu, log_p), normal_density(zl, log_p)
        self.loglik += np.sum(weights * np.where(weights > 0.0, log_p, 0.0), axis=1)
        self.add(rows.upper, weights * pu, -weights * pu * (zu + pu))
        self.add(rows.lower, -weights * pl, weights * pl * (zl - pl))
        self.hessian += ((weights * pu * pl) @ rows.cross).reshape(self.hessian.shape)


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


def normal_density(z: FloatArray, log_probability: FloatArray) -> FloatArray:
    """Return phi(z)/P; 0 where P is 0.

    Where a bracket has no probability the log-likelihood is minus infinity and a Newton step to
    there is refused: the derivatives only have to be finite.
    """
    scale = np.where(np.isfinite(log_probability), -log_probability, -np.inf)
    return np.exp(-0.5 * z * z - HALF_LOG_2PI + scale)
