"""Series system of components: the bridge reaches a limit state when any component does.

References:
    Nielson and DesRoches (2007), EESD 36(6):823-839, for bridge systems from joint demand models.
    Plackett (1954), Biometrika 41(3/4):351-360, for the bivariate normal integral.
    Genz (1992), J. Comput. Graph. Stat. 1(2):141-149, for more components.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.methods.cloud import fit_line

POINTS: Final = 5003  # of the lattice for three or more components: error about 2e-5
_JITTER: Final = 1e-10  # makes a singular correlation (equal components) factorisable
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)


@dataclass(frozen=True, slots=True, kw_only=True)
class JointDemand:
    """Demand models of the components of a system over the same runs.

    Attributes:
        theta: Medians, shape (m,).
        beta: Dispersions with those of the capacities, shape (m,).
        correlation: Of the standardised ln(D/C), shape (m, m).
    """

    theta: FloatArray
    beta: FloatArray
    correlation: FloatArray


def joint_demand(
    im: FloatArray, demands: FloatArray, capacity: FloatArray, capacity_dispersion: FloatArray
) -> JointDemand:
    """Fit the components' log-log lines and correlate their residuals.

    R_ij = S_ij/sqrt[(S_ii + c_i^2)(S_jj + c_j^2)] for independent capacities of dispersion c.
    S is the covariance of the residuals: that of ln D itself contains the trend with intensity
    and inflates every dispersion.

    ``demands`` are positive, shape (n, m), ``im`` has shape (n,), median capacities and their
    dispersions have shape (m,).
    """
    x, y = np.log(im), np.log(demands)
    lines = [fit_line(x, y[:, i]) for i in range(y.shape[1])]
    for i, line in enumerate(lines):
        if not line.b > 0.0:
            raise InputError(
                f"component {i}: demand does not grow with intensity (b = {line.b:.3g})",
                column=str(i),
            )
    a, b = np.array([line.ln_a for line in lines]), np.array([line.b for line in lines])
    residual = y - a - np.outer(x, b)
    scatter = residual.T @ residual / (x.size - 2)
    # ASSUME capacities of components independent of each other and of the demands
    spread = np.sqrt(np.diag(scatter) + capacity_dispersion**2)
    correlation = scatter / np.outer(spread, spread)
    np.fill_diagonal(correlation, 1.0)
    return JointDemand(
        theta=np.exp((np.log(capacity) - a) / b), beta=spread / b, correlation=correlation
    )


def series_system(im: FloatArray, joint: JointDemand) -> FloatArray:
    """Return P(union) = 1 - Phi_m(-z; R), z_i = ln(x/theta_i)/beta_i.

    Two components by quadrature (1e-12); more by separation of variables on a lattice whose points
    are common to all intensities, so that the curve is smooth.
    """
    return _union(np.log(im[:, None] / joint.theta) / joint.beta, joint.correlation)


def contributions(im: FloatArray, joint: JointDemand) -> FloatArray:
    """Return (P - P without component i)/P, shape (n, m): what retrofitting it could save."""
    z = np.log(im[:, None] / joint.theta) / joint.beta
    m = joint.theta.size
    union = _union(z, joint.correlation)
    without = np.zeros((im.size, m))
    for i in range(m if m > 1 else 0):
        rest = [j for j in range(m) if j != i]
        without[:, i] = _union(z[:, rest], joint.correlation[np.ix_(rest, rest)])
    return 1.0 - without / np.maximum(union, 1e-300)[:, None]


def lognormal_of_system(im: FloatArray, p: FloatArray) -> tuple[float, float, float]:
    """Return theta and beta of a lognormal through x16, x50, x84 and the largest |dP| to it.

    Raises:
        InputError: The curve does not span 16 to 84 % within its intensities.
    """
    ends = np.array([special.ndtr(-1.0), 0.5, special.ndtr(1.0)])
    if p[0] > ends[0] or p[-1] < ends[2]:
        raise InputError(f"the system curve spans {p[0]:.3g}..{p[-1]:.3g}, not 0.16..0.84")
    x16, x50, x84 = np.interp(special.ndtri(ends), special.ndtri(p), np.log(im))
    beta = 0.5 * (x84 - x16)
    fitted = special.ndtr((np.log(im) - x50) / beta)
    return float(np.exp(x50)), float(beta), float(np.max(np.abs(fitted - p)))


def bivariate_upper(h: FloatArray, k: FloatArray, rho: float) -> FloatArray:
    """Return P(Z1 <= h, Z2 <= k) of a standard bivariate normal, by Plackett's integral."""
    top = float(np.arcsin(np.clip(rho, -1.0, 1.0)))
    angle = 0.5 * top * (_NODES + 1.0)
    sine, square = np.sin(angle), np.maximum(np.cos(angle) ** 2, 1e-300)
    exponent = -(h[:, None] ** 2 - 2.0 * h[:, None] * k[:, None] * sine + k[:, None] ** 2)
    integral = np.exp(exponent / (2.0 * square)) @ _WEIGHTS * 0.5 * top
    return special.ndtr(h) * special.ndtr(k) + integral / (2.0 * np.pi)


def _union(z: FloatArray, correlation: FloatArray) -> FloatArray:
    m = z.shape[1]
    if m == 1:
        return np.asarray(special.ndtr(z[:, 0]))
    if m == 2:
        return 1.0 - bivariate_upper(-z[:, 0], -z[:, 1], float(correlation[0, 1]))
    return np.array([1.0 - _all_below(-row, correlation) for row in z])


def _all_below(limit: FloatArray, correlation: FloatArray) -> float:
    """Return P(Z_i <= limit_i for all i) by Genz's separation of variables."""
    m = limit.size
    order = np.argsort(limit)  # the most restrictive first: less variance
    matrix = correlation[np.ix_(order, order)] + _JITTER * np.eye(m)
    root, top = np.linalg.cholesky(matrix), limit[order]
    # Richtmyer's lattice with the tent transform
    primes = np.array([n for n in range(2, 12 * m + 20) if all(n % d for d in range(2, n))])
    step = np.sqrt(primes[: m - 1].astype(np.float64)) % 1.0
    points = np.abs(2.0 * (np.outer(np.arange(1, POINTS + 1), step) % 1.0) - 1.0)
    e = np.full(POINTS, special.ndtr(top[0] / root[0, 0]))
    product = e.copy()
    y = np.zeros((POINTS, m - 1))
    for i in range(1, m):
        y[:, i - 1] = special.ndtri(np.clip(points[:, i - 1] * e, 1e-300, 1.0 - 1e-16))
        e = special.ndtr((top[i] - y[:, :i] @ root[i, :i]) / root[i, i])
        product *= e
    return float(np.mean(product))
