"""Probability that a column fails in any mode, from the curves of its failure modes.

Mode i fails at the intensity ln x_i = ln theta_i + beta_i e_i, with standard normal e_i. The column
fails at the smaller of both intensities. With u_i = ln(x/theta_i)/beta_i,

    P(any) = Phi(u_1) + Phi(u_2) - Phi_2(u_1, u_2; rho)

is at least as large as each Phi(u_i), and at most their sum. This curve is not lognormal. The
demands of both modes are correlated from motion to motion, and their capacities are independent, so
rho = rho_demands s_1 s_2, with s_i = record-to-record / total dispersion.

Source: the bivariate normal distribution by Owen (1956), Ann. Math. Stat. 27(4):1075-1090.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import special

from skewbridge.files.tables import Floats

#: Columns of the curve of a union: median and dispersion of both modes, and their correlation.
UNION_COLUMNS: Final = (
    "theta_shear", "beta_shear", "theta_flexure", "beta_flexure", "mode_correlation",
)  # fmt: skip
#: Smallest number of runs with known demands of both modes for a correlation.
MIN_COMPLETE: Final = 4
_HALVINGS: Final = 60
_TINY: Final = 1e-300  # replaces zero as a divisor
_LARGEST_RHO: Final = 1.0 - 1e-12


class Union(NamedTuple):
    """R unions of two failure modes, for example from all runs and without each motion."""

    ln_theta: Floats  # shape (2, R)
    beta: Floats  # shape (2, R)
    rho: Floats  # correlation of the intensities of failure, shape (R,)

    @classmethod
    def of(cls, ln_theta: Floats, records: Floats, totals: Floats, rho: Floats) -> Self:
        """Return unions of modes with dispersions ``totals`` (2, R).

        ``rho`` (R,) is the correlation of the demands, whose dispersions are ``records`` (2, R).
        """
        # ASSUME the capacities of both modes are independent of each other and of the demands
        shares = np.divide(records, totals, out=np.zeros_like(totals), where=totals > 0.0)
        return cls(ln_theta, totals, rho * np.prod(shares, axis=0))

    def probability(self, ln_im: Floats) -> Floats:
        """Return P(any) at ln intensities whose shape broadcasts with (R,)."""
        modes = zip(self.ln_theta, self.beta, strict=True)
        return any_of([(ln_im - mean) / beta for mean, beta in modes], self.rho)

    def quantile(self, z: float) -> Floats:
        """Return ln of the intensity at which P(any) = Phi(z), shape (R,)."""
        p = float(special.ndtr(z))
        # the larger of both probabilities is between p/2 and p
        limits = (float(special.ndtri(share * p)) for share in (0.5, 1.0))
        low, high = (np.min(self.ln_theta + limit * self.beta, axis=0) for limit in limits)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            above = self.probability(middle) > p
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return 0.5 * (low + high)

    def columns(self) -> dict[str, float]:
        """Return medians, dispersions and correlation of the two modes of the first union."""
        medians, dispersions = np.exp(self.ln_theta[:, 0]), self.beta[:, 0]
        values = *np.column_stack([medians, dispersions]).ravel(), self.rho[0]
        return dict(zip(UNION_COLUMNS, map(float, values), strict=True))

    def summary(self) -> tuple[Floats, Floats]:
        """Return ln of the median and half of the ln range from 16 to 84 %, shape (R,) each."""
        low, middle, high = (self.quantile(z) for z in (-1.0, 0.0, 1.0))
        return middle, 0.5 * (high - low)


def any_of(u: Sequence[Floats], rho: Floats) -> Floats:
    """Return P(any) of one or two modes with probabilities Phi(u_i) and correlation ``rho``."""
    p = [special.ndtr(z) for z in u]
    if len(u) == 1:
        return p[0]
    p_sum = p[0] + p[1]
    return np.clip(p_sum - _both(u[0], u[1], rho), np.maximum(*p), np.minimum(p_sum, 1.0))


def _both(u: Floats, v: Floats, rho: Floats) -> Floats:
    """Return the bivariate normal probability Phi_2(u, v; rho)."""
    u, v = (np.where(z == 0.0, _TINY, z) for z in (u, v))
    rho = np.clip(rho, -_LARGEST_RHO, _LARGEST_RHO)
    sqrt_rest = np.sqrt(1.0 - rho**2)
    total = np.where((u > 0.0) == (v > 0.0), 0.0, -0.5)
    for first, second in ((u, v), (v, u)):
        with np.errstate(over="ignore"):
            slope = (second - rho * first) / (first * sqrt_rest)
        total = total + 0.5 * special.ndtr(first) - special.owens_t(first, slope)
    return total


def union_curve(row: Mapping[str, Any] | pd.DataFrame) -> Union | None:
    """Return the union of a curve, or of n curves, from `UNION_COLUMNS`; None for lognormals."""
    if any(name not in row for name in UNION_COLUMNS):
        return None
    t_1, beta_1, t_2, beta_2, rho = (np.asarray(row[n], dtype=np.float64) for n in UNION_COLUMNS)
    if not np.all(np.isfinite(t_1 + t_2)):
        return None
    return Union(np.log([t_1, t_2]), np.array([beta_1, beta_2]), rho)


def curve_probability(im: ArrayLike, row: Mapping[str, Any]) -> Floats:
    """Return P(exceeds | IM) of a row of curves, with the shape of ``im``.

    The curve is lognormal with theta and beta_total (beta if there is no slope), or a union.
    """
    ln_im = np.log(np.asarray(im, dtype=np.float64))
    if (union := union_curve(row)) is not None:
        return union.probability(ln_im)
    beta = row["beta"] if pd.isna(row["beta_total"]) else row["beta_total"]
    return special.ndtr((ln_im - np.log(row["theta"])) / beta)


def correlation(first: Floats, second: Floats, weights: Floats) -> Floats:
    """Return R correlations of residuals (R, n) with run weights (R, n); NaN: unknown residual."""
    known = np.isfinite(first[0]) & np.isfinite(second[0])
    if np.sum(known) < MIN_COMPLETE:
        return np.zeros(len(weights))
    w = weights[:, known]
    count = np.maximum(np.sum(w, axis=1), 1.0)[:, None]
    a, b = (e[:, known] - np.sum(w * e[:, known], axis=1)[:, None] / count for e in (first, second))
    covariance, *variances = (np.sum(w * x * y, axis=1) for x, y in ((a, b), (a, a), (b, b)))
    with np.errstate(divide="ignore", invalid="ignore"):
        rho = covariance / np.sqrt(variances[0] * variances[1])
    return np.clip(np.nan_to_num(rho), -1.0, 1.0)
