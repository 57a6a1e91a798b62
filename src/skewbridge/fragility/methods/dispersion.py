"""Dispersions: combined, pooled over curves (with the test of pooling), moved to a percentile.

References:
    FEMA P-695 (2009), Eqs. 7-2 and 7-5, for total and default dispersion.
    Bartlett (1937), Proc. R. Soc. A 160:268-282, for the equality of variances.
    Porter (2017), A Beginner's Guide to Fragility, Vulnerability and Risk, for the rotation.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise


@dataclass(frozen=True, slots=True, kw_only=True)
class PooledFit:
    """Curves that share one dispersion, and whether the data allow it.

    Attributes:
        theta: Median per curve.
        beta: Common dispersion.
        statistic: Likelihood-ratio (or Bartlett) statistic of a common dispersion.
        dof: Its degrees of freedom.
        p_value: Small values speak against pooling.
    """

    theta: FloatArray
    beta: float
    statistic: float
    dof: int
    p_value: float


def total_dispersion(*parts: float) -> float:
    """Return the square root of the sum of squares (FEMA P-695 Eq. 7-5).

    Raises:
        InputError: A part is negative.
    """
    for part in parts:
        if not part >= 0.0:
            raise InputError(f"dispersion must be >= 0, got {part:g}")
    return float(np.sqrt(np.sum(np.square(parts))))


def default_record_dispersion(ductility: FloatArray) -> FloatArray:
    """Return beta_RTR = 0.1 + 0.1 mu_T, within 0.2 .. 0.4 (FEMA P-695 Eq. 7-2)."""
    return np.clip(0.1 + 0.1 * ductility, 0.2, 0.4)


def rotated_median(theta: float, beta: float, beta_total: float, percentile: float) -> float:
    """Return the median that keeps a percentile in place when the dispersion grows.

    theta' = theta exp[-Phi^-1(p) (beta_total - beta)].
    """
    return float(theta * np.exp(-special.ndtri(percentile) * (beta_total - beta)))


def pool_stripes(curves: Sequence[tuple[FloatArray, FloatArray, FloatArray]]) -> PooledFit:
    """Fit probit curves with a common slope and test it by likelihood ratio (df = J - 1).

    Args:
        curves: (im, n, k) per curve; each needs an estimate of its own.
    """
    if len(curves) < 2:
        raise InputError(f"pooling needs at least 2 curves, got {len(curves)}")
    count = len(curves)
    separate = 0.0
    rows: list[FloatArray] = []
    for j, (im, n, k) in enumerate(curves):
        x = np.log(im)
        own = np.column_stack([np.ones_like(x), x])
        best = maximise(BinomialKernel(own, n, k), np.zeros((1, 2)))
        if not bool(best.converged[0]):
            raise InputError(f"curve {j} has no estimate of its own", row=j)
        separate += float(best.loglik[0])
        dummies = np.zeros((x.size, count + 1))
        dummies[:, j] = 1.0
        dummies[:, -1] = x
        rows.append(dummies)
    kernel = BinomialKernel(
        np.vstack(rows),
        np.concatenate([n for _, n, _ in curves]),
        np.concatenate([k for _, _, k in curves]),
    )
    pooled = maximise(kernel, np.zeros((1, count + 1)))
    slope = float(pooled.params[0, -1])
    statistic = 2.0 * (separate - float(pooled.loglik[0]))
    return PooledFit(
        theta=np.exp(-pooled.params[0, :-1] / slope),
        beta=1.0 / slope,
        statistic=statistic,
        dof=count - 1,
        p_value=float(special.chdtrc(count - 1, max(statistic, 0.0))),
    )


def pool_scatter(s: FloatArray, n: FloatArray) -> tuple[float, float]:
    """Pool residual standard deviations of log-log lines: s^2 = sum (n_i - 2) s_i^2/sum (n_i - 2).

    Returns:
        The pooled value and the p-value of Bartlett's test of equal variances.
    """
    dof = n - 2.0
    total = float(np.sum(dof))
    pooled = float(np.sum(dof * s**2) / total)
    groups = s.size
    raw = total * np.log(pooled) - float(np.sum(dof * np.log(s**2)))
    correction = 1.0 + (float(np.sum(1.0 / dof)) - 1.0 / total) / (3.0 * (groups - 1))
    return float(np.sqrt(pooled)), float(special.chdtrc(groups - 1, max(raw / correction, 0.0)))
