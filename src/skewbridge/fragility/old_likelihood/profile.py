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

from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.newton import Kernel, Maximum, Restricted, maximise

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
    ends[bounded], good = _venzon_moolgavkar(kernel, maximum, quantile, np.flatnonzero(bounded))
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
    kernel: Kernel, maximum: Maximum, quantile: float, which: NDArray[np.intp]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the ends named by ``which`` by Newton from those of an ellipse, and which are found.

    The points with l = target form a closed convex curve in the plane of a = (a0, a1). At the ends
    of a1 dl/da0 = 0; at those of ln theta = -a0/a1 a ray touches the curve: a . dl/da = 0.
    """
    a = _points_of_ellipse(maximum.params[0], maximum.covariance[0], quantile)[which]
    is_theta, target = which < 2, float(maximum.loglik[0]) - 0.5 * quantile
    residual = np.full(which.size, np.inf)
    # Far from the data terms vanish or overflow: what is not finite in the end is not good.
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            now = kernel.derivatives(a)
            along = np.where(is_theta[:, None], a, np.array([1.0, 0.0]))
            turned = (now.hessian @ along[:, :, None])[:, :, 0]
            gap, slope = now.loglik - target, np.sum(along * now.score, axis=1)
            residual = np.abs(gap) + slope**2 / np.abs(np.sum(along * turned, axis=1))
            if np.all(residual < _TOLERANCE * (1.0 + abs(target))):
                break
            tilted = turned + is_theta[:, None] * now.score  # gradient of ``slope``
            det = now.score[:, 0] * tilted[:, 1] - now.score[:, 1] * tilted[:, 0]
            det = np.where(det == 0.0, np.inf, det)
            first = (slope * now.score[:, 1] - gap * tilted[:, 1]) / det
            second = (gap * tilted[:, 0] - slope * now.score[:, 0]) / det
            # a1 stays positive: no step takes more than 0.7 of it
            part = 0.7 / np.maximum(-second / a[:, 1], 0.7)
            a = a + part[:, None] * np.stack([first, second], axis=1)
    side = np.where(which % 2 == 0, -1.0, 1.0)
    ends, centre = (
        np.where(is_theta, -point[:, 0] / point[:, 1], point[:, 1]) for point in (a, maximum.params)
    )
    good = (residual < 1e-8 * (1.0 + abs(target))) & (side * (ends - centre) > 0.0)
    return ends, good & (a[:, 1] > 0.0)


def _points_of_ellipse(params: FloatArray, covariance: FloatArray, quantile: float) -> FloatArray:
    """Return where the four ends would be, shape (4, 2), if the log-likelihood were quadratic.

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
    points = [np.concatenate([-psi * nuisance, intercept]), np.concatenate([nuisance, slope])]
    return np.stack(points, axis=1)


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
