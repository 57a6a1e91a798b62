"""Profile-likelihood intervals of ln theta and beta for any two-parameter kernel of this package.

References:
    Venzon and Moolgavkar (1988), Applied Statistics 37(1):87-94: the end of a profile interval as
    the root of two equations, here solved for the four ends of (theta, beta) at once.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.newton import Kernel, Maximum, Restricted, maximise

_ITERATIONS: Final = 25
_TOLERANCE: Final = 1e-11


@dataclass(frozen=True, slots=True)
class ProfileEnds:
    """Ends of the intervals of ln theta and of the slope a1 = 1/beta."""

    ln_theta: tuple[float, float]
    slope: tuple[float, float]


def chi_square_quantile(level: float) -> float:
    """Return the drop of twice the log-likelihood that bounds an interval in large samples."""
    return float(special.chdtri(1.0, 1.0 - level))


def student_quantile(n: int, level: float) -> float:
    """Return the drop for a line through n demands whose scatter is estimated with it.

    2 [l_max - l_profile] = n ln(1 + t^2/(n - 2)) holds exactly for a coefficient of a
    least-squares line: the interval is then that of Student's t with n - 2 degrees of freedom.
    """
    t = float(special.stdtrit(n - 2, 0.5 + 0.5 * level))
    return n * float(np.log1p(t**2 / (n - 2)))


def profile_ends(
    kernel: Kernel, maximum: Maximum, quantile: float, flat_intercept: float | None
) -> ProfileEnds:
    """Return the profile intervals {psi: 2 [l_max - l_profile(psi)] <= quantile}.

    The kernel is that of (a0, a1) in a0 + a1 ln x, its maximum a batch of one with a1 > 0;
    ``flat_intercept`` is the best a0 at a1 = 0, None if the likelihood vanishes there.

    Returns:
        Ends; those of ln theta may be infinite and the lower end of the slope zero: then the
        data do not bound the median or the dispersion on that side.
    """
    # The profile of ln theta falls away from its maximum on both sides (theta is a ratio of linear
    # functions and the log-likelihood is concave), so each end is the only crossing on its side.
    target = float(maximum.loglik[0]) - 0.5 * quantile
    bounded = _bounded_ends(kernel, target, flat_intercept)
    ends = np.array([-np.inf, np.inf, 0.0, np.inf])
    found, good = _venzon_moolgavkar(kernel, maximum, target, quantile, np.flatnonzero(bounded))
    ends[bounded] = found
    for index in np.flatnonzero(bounded)[~good]:
        ends[index] = _bracketed_end(kernel, maximum, target, int(index))
    low, high, slope_low, slope_high = (float(end) for end in ends)
    return ProfileEnds((low, high), (slope_low, slope_high))


def _bounded_ends(kernel: Kernel, target: float, flat_intercept: float | None) -> NDArray[np.bool_]:
    """Return which of (ln theta low, high, slope low, high) the data bound."""
    if flat_intercept is None:
        return np.ones(4, dtype=np.bool_)
    flat = kernel.derivatives(np.array([[flat_intercept, 0.0], [0.0, 0.0]])).loglik
    origin_inside = bool(flat[1] >= target)
    flat_inside = bool(flat[0] >= target)
    return np.array(
        [
            not (origin_inside or (flat_inside and flat_intercept > 0.0)),
            not (origin_inside or (flat_inside and flat_intercept < 0.0)),
            not flat_inside,
            True,
        ]
    )


def _venzon_moolgavkar(
    kernel: Kernel, maximum: Maximum, target: float, quantile: float, which: NDArray[np.intp]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Solve l = target and dl/d(nuisance) = 0 by Newton for the ends named by ``which``."""
    is_theta = which < 2
    side = np.where(which % 2 == 0, -1.0, 1.0)
    a0, a1 = maximum.params[0]
    centre = np.where(is_theta, -a0 / a1, a1)
    psi, nuisance = _ends_of_ellipse(maximum.params[0], maximum.covariance[0], quantile)
    psi, nuisance = psi[which], nuisance[which]
    # Far from the data terms vanish or overflow: what is not finite in the end is not good.
    with np.errstate(all="ignore"):
        residual = np.full(psi.size, np.inf)
        for _ in range(_ITERATIONS):
            gap, slope, matrix = _end_equations(kernel, psi, nuisance, is_theta, target)
            residual = np.abs(gap) + slope**2 / np.abs(matrix[:, 1, 1])
            if np.all(residual < _TOLERANCE * (1.0 + abs(target))):
                break
            det = matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0]
            det = np.where(det == 0.0, np.inf, det)
            step_psi = -(matrix[:, 1, 1] * gap - matrix[:, 0, 1] * slope) / det
            step_nuisance = -(matrix[:, 0, 0] * slope - matrix[:, 1, 0] * gap) / det
            positive = np.where(is_theta, nuisance, psi)
            step_positive = np.where(is_theta, step_nuisance, step_psi)
            shrink = np.where(
                step_positive < -0.7 * positive,
                0.7 * positive / np.maximum(-step_positive, 1e-300),
                1.0,
            )
            psi, nuisance = psi + shrink * step_psi, nuisance + shrink * step_nuisance
    good = (
        (residual < 1e-8 * (1.0 + abs(target)))
        & (side * (psi - centre) > 0.0)
        & (np.where(is_theta, nuisance, psi) > 0.0)
    )
    return psi, good


def _ends_of_ellipse(
    params: FloatArray, covariance: FloatArray, quantile: float
) -> tuple[FloatArray, FloatArray]:
    """Return the four ends, with their nuisance, if the log-likelihood were quadratic.

    For ln theta these are Fieller's: the tangents from the origin to the ellipse of confidence.
    """
    a0, a1 = params
    q = min(quantile, 0.6 * a1**2 / covariance[1, 1])  # keeps the tangents in a1 > 0
    quadratic = a1**2 - q * covariance[1, 1]
    linear = a0 * a1 - q * covariance[0, 1]
    constant = a0**2 - q * covariance[0, 0]
    root = np.sqrt(max(linear**2 - quadratic * constant, 0.0))
    psi = (-linear + np.array([-root, root])) / quadratic
    normal = np.stack([np.ones(2), psi])
    spread = covariance @ normal
    shift = (params @ normal) / np.sum(normal * spread, axis=0)
    nuisance = np.maximum(a1 - shift * spread[1], 0.2 * a1)
    size = np.sqrt(quantile * covariance[1, 1])
    slope = np.array([max(a1 - size, 0.3 * a1), a1 + size])
    intercept = a0 + covariance[0, 1] / covariance[1, 1] * (slope - a1)
    return np.concatenate([psi, slope]), np.concatenate([nuisance, intercept])


def _end_equations(
    kernel: Kernel,
    psi: FloatArray,
    nuisance: FloatArray,
    is_theta: NDArray[np.bool_],
    target: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return l - target, dl/d nuisance and the Jacobian of both by (psi, nuisance)."""
    a = np.where(
        is_theta[:, None],
        np.stack([-nuisance * psi, nuisance], axis=1),
        np.stack([nuisance, psi], axis=1),
    )
    now = kernel.derivatives(a)
    g0, g1 = now.score[:, 0], now.score[:, 1]
    h00, h01, h11 = now.hessian[:, 0, 0], now.hessian[:, 0, 1], now.hessian[:, 1, 1]
    l_psi = np.where(is_theta, -nuisance * g0, g1)
    l_nuisance = np.where(is_theta, g1 - psi * g0, g0)
    mixed = np.where(is_theta, -g0 - nuisance * (h01 - psi * h00), h01)
    second = np.where(is_theta, psi**2 * h00 - 2.0 * psi * h01 + h11, h00)
    rows = [np.stack([l_psi, l_nuisance], axis=1), np.stack([mixed, second], axis=1)]
    return now.loglik - target, l_nuisance, np.stack(rows, axis=1)


def _bracketed_end(kernel: Kernel, maximum: Maximum, target: float, index: int) -> float:
    """Find one end by expansion and Brent's method on the profile itself (slow, always works)."""
    a0, a1 = (float(value) for value in maximum.params[0])
    is_theta, side = index < 2, -1.0 if index % 2 == 0 else 1.0
    centre = -a0 / a1 if is_theta else float(np.log(a1))
    near: dict[str, float] = {}

    def excess(psi: float) -> float:
        if is_theta:
            base, direction, start = np.zeros(2), [-psi, 1.0], a1
        else:  # start with the median unchanged
            slope = np.exp(psi)
            base, direction, start = slope * np.array([a0 / a1, 1.0]), [1.0, 0.0], 0.0
        along = Restricted(kernel, base, np.array([direction]))
        # the nuisance of the last psi is closer than that of the maximum
        begin = np.array([[near.get("nuisance", start)]])
        best = maximise(along, begin, covariance=False)
        near["nuisance"] = float(best.params[0, 0])
        return float(best.loglik[0]) - target

    step = 0.1 / a1 if is_theta else 0.1
    inner, outer = centre, centre + side * step
    while excess(outer) > 0.0:
        step *= 2.0
        inner, outer = outer, outer + side * step
        if step > 1e6:
            return side * np.inf if is_theta or side > 0 else 0.0
    root = float(optimize.brentq(excess, inner, outer, xtol=1e-13))
    return root if is_theta else float(np.exp(root))
