"""Series system of components: the bridge reaches a limit state when any component does.

References:
    Nielson and DesRoches (2007), EESD 36(6):823-839, for bridge systems from joint demand models.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import interpolate, special

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood.bootstrap import Replicates
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.normal_union import FEW_POINTS, union, union_of_each

_NEVER: Final = -40.0  # standardised intensity at which a component does not fail
_REACH: Final = (-1.4, -0.7, 0.0, 0.7, 1.4)  # probits at which a replicate is evaluated
_WIDE: Final = 201  # intensities of the bounds of a system
_WITHIN: Final = 17  # of its curve, where the bounds leave more than `_TAIL` open
_TAIL: Final = 1e-3
_BETWEEN: Final = 200  # probits at which a curve is compared with its lognormal

type Lognormal = tuple[float, float, float]  # theta, beta, largest distance in probability


@dataclass(frozen=True, slots=True, kw_only=True)
class JointDemand:
    """Demand models of the components of a system over the same runs; R of them at once.

    Attributes:
        theta: Medians, shape (m,) or (R, m).
        beta: Dispersions with those of the capacities, of the same shape.
        correlation: Of the standardised ln(D/C), shape (m, m) or (R, m, m).
    """

    theta: FloatArray
    beta: FloatArray
    correlation: FloatArray

    @property
    def first(self) -> "JointDemand":
        """The first of R models: that of the data, where the others are replicates."""
        return JointDemand(theta=self.theta[0], beta=self.beta[0], correlation=self.correlation[0])


def residual_correlation(x: FloatArray, y: FloatArray, weights: FloatArray) -> FloatArray:
    """Correlate the residuals of the components about their lines, shape (R, m, m).

    The covariance of ln D itself contains the trend with intensity and inflates every dispersion.

    Args:
        x: ln intensity, shape (n,).
        y: ln demand, shape (n, m); NaN where a demand is known only to exceed a value: such a run
            takes no part in the correlations of that component.
        weights: How often each run enters each replicate, shape (R, n).
    """
    m = y.shape[1]
    i, j = np.tril_indices(m, -1)
    seen = np.isfinite(y)
    both = (seen[:, i] & seen[:, j]).astype(np.float64)
    x = (x - np.mean(x))[:, None]
    y = np.where(seen, y - np.mean(y, axis=0, where=seen, keepdims=True), 0.0)

    def products(first: FloatArray, second: FloatArray) -> FloatArray:
        """Return the sums of products about the means of every pair, shape (R, pairs)."""
        sums = [weights @ (values * both) for values in (first * second, first, second)]
        return sums[0] - sums[1] * sums[2] / total

    total = weights @ both
    with np.errstate(divide="ignore", invalid="ignore"):
        by_x = [products(x, values) for values in (y[:, i], y[:, j])]
        about_x = products(x, np.broadcast_to(x, both.shape))
        first, second = (
            products(values, values) - own**2 / about_x
            for values, own in zip((y[:, i], y[:, j]), by_x, strict=True)
        )
        shared = products(y[:, i], y[:, j]) - by_x[0] * by_x[1] / about_x
        rho = np.where(np.sum(both, axis=0) < 4, 0.0, shared / np.sqrt(first * second))
    out = np.broadcast_to(np.eye(m), (weights.shape[0], m, m)).copy()
    out[:, i, j] = out[:, j, i] = np.clip(np.nan_to_num(rho), -1.0, 1.0)
    # components observed in different runs: the nearest matrix that is a correlation
    values, vectors = np.linalg.eigh(out)
    root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    root /= np.linalg.norm(root, axis=2, keepdims=True)
    return root @ np.swapaxes(root, 1, 2)


def joint_demand(
    lines: Sequence[Replicates], capacity_dispersion: Sequence[float], correlation: FloatArray
) -> JointDemand:
    """Join the lines of the components, R fits of each, and the correlation of their residuals.

    R_ij = S_ij/sqrt[(S_ii + c_i^2)(S_jj + c_j^2)] for independent capacities of dispersion c.

    Args:
        lines: Per component, with slopes.
        capacity_dispersion: c of each.
        correlation: Of the residuals, shape (R, m, m).
    """
    # ASSUME capacities of components independent of each other and of the demands
    wide = [r.widened(c).beta for r, c in zip(lines, capacity_dispersion, strict=True)]
    beta = np.stack(wide, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.nan_to_num(np.stack([r.beta for r in lines], axis=1) / beta)
    scaled = correlation * share[:, :, None] * share[:, None, :]
    scaled[:, np.arange(beta.shape[1]), np.arange(beta.shape[1])] = 1.0
    theta = np.stack([r.theta for r in lines], axis=1)
    return JointDemand(theta=theta, beta=beta, correlation=scaled)


def series_system(im: FloatArray, joint: JointDemand) -> FloatArray:
    """Return P(union) = 1 - Phi_m(-z; R), z_i = ln(x/theta_i)/beta_i.

    Two components by quadrature (1e-12); more by separation of variables on a lattice whose points
    are common to all intensities, so that the curve is smooth.
    """
    return union(_standardised(im[:, None], joint.theta, joint.beta), joint.correlation)


def system_bounds(im: FloatArray, joint: JointDemand) -> tuple[FloatArray, FloatArray]:
    """Return P(any) if the components were fully correlated, and if they were independent."""
    p = special.ndtr(_standardised(im[:, None], joint.theta, joint.beta))
    return np.max(p, axis=1), 1.0 - np.prod(1.0 - p, axis=1)


def contributions(im: FloatArray, joint: JointDemand) -> FloatArray:
    """Return (P - P without component i)/P, shape (n, m): what retrofitting it could save."""
    z = _standardised(im[:, None], joint.theta, joint.beta)
    m = joint.theta.size
    rest = np.where(np.eye(m, dtype=np.bool_), _NEVER, z[:, None]).reshape(-1, m)
    without = union(rest, joint.correlation).reshape(-1, m)
    return 1.0 - without / np.maximum(union(z, joint.correlation), 1e-300)[:, None]


def replicate_medians(
    joint: JointDemand, theta: float, beta: float
) -> tuple[FloatArray, FloatArray]:
    """Return ln median and dispersion of the systems of R models near a known one, shape (R,).

    The curve of each is read at five intensities about (theta, beta) of the known system and taken
    as linear in between on the scale of the probit, on which systems are nearly straight.
    """
    ln_x = np.log(theta) + beta * np.array(_REACH)
    z = _standardised(np.exp(ln_x)[:, None, None], joint.theta, joint.beta)
    p = np.stack([union_of_each(row, joint.correlation, FEW_POINTS) for row in z], axis=1)
    probit = special.ndtri(np.clip(p, 1e-12, 1.0 - 1e-12))
    line = np.stack([_crossing(ln_x, probit, level) for level in (-1.0, 0.0, 1.0)])
    return line[1], 0.5 * (line[2] - line[0])


def _crossing(ln_x: FloatArray, probit: FloatArray, level: float) -> FloatArray:
    """Return where curves of shape (R, k) reach a level; beyond their ends, the end piece."""
    at = np.clip(np.sum(probit < level, axis=1), 1, ln_x.size - 1)
    rows = np.arange(probit.shape[0])
    low, high = probit[rows, at - 1], probit[rows, at]
    rise = np.maximum(high - low, 1e-9)
    return ln_x[at - 1] + (level - low) / rise * (ln_x[at] - ln_x[at - 1])


def _standardised(im: FloatArray, theta: FloatArray, beta: FloatArray) -> FloatArray:
    """Return ln(x/theta)/beta; far below zero where a component has no rising line."""
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.log(im / theta) / beta
    return np.where(np.isfinite(theta) & np.isfinite(beta) & (beta > 0.0), z, _NEVER)


def lognormals(joint: JointDemand) -> tuple[Lognormal, Lognormal, Lognormal]:
    """Return `lognormal_of_system` of a system, and if its components were one or independent."""
    lowest, reach = float(np.min(joint.theta)), float(np.exp(4.0 * np.max(joint.beta)))
    wide = np.geomspace(lowest / reach, lowest * reach, _WIDE)
    together, apart = system_bounds(wide, joint)
    within = wide[(apart > _TAIL) & (together < 1.0 - _TAIL)]
    im = np.geomspace(within[0], within[-1], _WITHIN)
    return (
        lognormal_of_system(im, series_system(im, joint)),
        lognormal_of_system(wide, together),
        lognormal_of_system(wide, apart),
    )


def lognormal_of_system(im: FloatArray, p: FloatArray) -> Lognormal:
    """Return theta and beta of a lognormal through x16, x50, x84 and the largest |dP| to it.

    Raises:
        InputError: The curve does not span 16 to 84 % within its intensities.
    """
    ends = np.array([special.ndtr(-1.0), 0.5, special.ndtr(1.0)])
    if p[0] > ends[0] or p[-1] < ends[2]:
        raise InputError(f"the system curve spans {p[0]:.3g}..{p[-1]:.3g}, not 0.16..0.84")
    probit = special.ndtri(p)
    with np.errstate(invalid="ignore"):
        rising = np.isfinite(probit) & (np.diff(probit, prepend=-np.inf) > 0.0)
    probit = probit[rising]
    curve = interpolate.PchipInterpolator(probit, np.log(im[rising]))
    x16, x50, x84 = curve(special.ndtri(ends))
    beta = 0.5 * (x84 - x16)
    between = np.linspace(float(probit[0]), float(probit[-1]), _BETWEEN)
    away = special.ndtr((curve(between) - x50) / beta) - special.ndtr(between)
    return float(np.exp(x50)), float(beta), float(np.max(np.abs(away)))
