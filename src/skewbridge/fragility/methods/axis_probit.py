"""Parameterised fragility: one curve over intensity and the axes of a study.

eta = c0 + c1 ln x + sum c_j z_j + sum d_j z_j ln x (and products of two z); at axis values z
theta = exp(-(c0 + c z)/(c1 + d z)), beta = 1/(c1 + d z).

References:
    Ghosh, Padgett and Duenas-Osorio (2013), Probabilistic Engineering Mechanics 34:189-199, for
    parameterised curves.
    Liang and Zeger (1986), Biometrika 73(1):13-22, for errors robust to clusters.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.likelihood.links import FloatArray, half_width, link_terms, predictor
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise
from skewbridge.variant.axes import axes_of

LN_IM: Final = "ln_im"
REFERENCE_GAP_MM: Final = 50.8  # 2 in


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisProbitFit:
    """A fitted parameterised curve.

    Attributes:
        status: ``ok``, ``separation`` (no estimate) or ``slope_not_positive`` (in the box).
        terms: Names of the terms: ``1``, ``ln_im``, ``skew_deg``, ``skew_deg:ln_im`` ...
        coefficients: Shape (p,).
        se: Standard errors from the expected information.
        se_cluster: Standard errors robust to clusters; NaN without clusters.
        covariance: Cluster-robust where there are clusters, else model-based.
        loglik: Log-likelihood.
        link: Link.
    """

    status: str
    terms: tuple[str, ...]
    coefficients: FloatArray
    se: FloatArray
    se_cluster: FloatArray
    covariance: FloatArray
    loglik: float
    link: str

    def curve_at(self, axes: Mapping[str, float]) -> tuple[float, float]:
        """Return theta and beta at scaled axis values, for example ``{"skew_deg": 0.5}``."""
        level, slope = _level_and_slope(self.terms, self.coefficients, axes)
        theta = float(np.exp((predictor(0.5, self.link) - level) / slope))
        return theta, half_width(self.link) / slope


def scaled_axes(values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return axis values as variables of a model, by axis.

    The joint gap by its logarithm, ln(gap/50.8 mm), or as gap/50.8 mm where one is zero; friction
    as it is, every other axis as the share of its largest value (skew/60 degrees).
    """
    out: dict[str, FloatArray] = {}
    for axis in axes_of(values):
        value = values[axis.name]
        if axis.name == "gap_mm":
            # ASSUME the effect of a gap goes with its logarithm, unless a joint is closed
            share = value / REFERENCE_GAP_MM
            out[axis.name] = np.log(share) if np.all(value > 0.0) else share
        elif axis.unit == "-" or not 0.0 < axis.high < np.inf:
            out[axis.name] = value
        else:
            out[axis.name] = value / axis.high
    return out


def fit_axis_probit(
    ln_im: FloatArray,
    axes: Mapping[str, FloatArray],
    exceed: FloatArray,
    *,
    interactions: Sequence[str] = (),
    link: str = "probit",
    clusters: NDArray[np.intp] | None = None,
) -> AxisProbitFit:
    """Fit the parameterised curve to single runs.

    Args:
        ln_im: Logarithms of the intensities, shape (n,).
        axes: Scaled axis values by name, shape (n,) each.
        exceed: 0 or 1, shape (n,).
        interactions: Products, for example ``("skew_deg:ln_im", "skew_deg:friction")``.
        link: probit, logit or cloglog.
        clusters: Number of the motion of each run, for robust errors.

    Returns:
        The fit. Existence is tested first by linear programming; a slope that is not positive
        everywhere in the box of the data gives status ``slope_not_positive``.
    """
    terms = ("1", LN_IM, *axes, *interactions)
    matrix = _matrix(terms, ln_im, axes)
    empty = np.full(len(terms), np.nan)
    blank = AxisProbitFit(
        status=FITTED,
        terms=terms,
        coefficients=empty,
        se=empty,
        se_cluster=empty,
        covariance=np.full((len(terms), len(terms)), np.nan),
        loglik=np.nan,
        link=link,
    )
    if separated(matrix, exceed):
        return replace(blank, status="separation")
    kernel = BinomialKernel(matrix, np.ones(ln_im.size), exceed, link)
    best = maximise(kernel, np.zeros((1, len(terms))))
    if not bool(best.converged[0]):
        return replace(blank, status="not_converged")
    coefficients = best.params[0]
    fit = replace(blank, coefficients=coefficients, loglik=float(best.loglik[0]))
    if not _slope_positive(terms, coefficients, axes):
        return replace(fit, status="slope_not_positive")
    values = link_terms(link)(matrix @ coefficients)
    p = np.exp(values.log_p)
    weight = (p * values.d_log_p) ** 2 / np.maximum(p * np.exp(values.log_q), 1e-300)
    expected = np.linalg.inv(matrix.T @ (matrix * weight[:, None]))
    fit = replace(fit, se=np.sqrt(np.diag(expected)), covariance=expected)
    if clusters is None:
        return fit
    per_run = matrix * (exceed * values.d_log_p + (1.0 - exceed) * values.d_log_q)[:, None]
    covariance = cluster_covariance(best.covariance[0], per_run, clusters)
    return replace(fit, se_cluster=np.sqrt(np.diag(covariance)), covariance=covariance)


def cluster_covariance(
    bread: FloatArray, scores: FloatArray, clusters: NDArray[np.intp]
) -> FloatArray:
    """Return bread (sum of outer products of the clusters' scores) bread, times G/(G - 1).

    ``bread`` is the inverse observed information, shape (p, p); scores have shape (n, p), one row
    per run, clusters shape (n,).
    """
    count = int(np.max(clusters)) + 1
    sums = np.zeros((count, scores.shape[1]))
    np.add.at(sums, clusters, scores)
    return bread @ (sums.T @ sums) @ bread * count / (count - 1)


def likelihood_ratio(full: AxisProbitFit, reduced: AxisProbitFit) -> tuple[float, int, float]:
    """Return statistic, degrees of freedom and p-value of the terms that ``reduced`` lacks.

    With motions that repeat over the variants the p-value is too small: then compare a coefficient
    with its cluster-robust error.
    """
    if not set(reduced.terms) < set(full.terms):
        raise InputError("likelihood ratio needs nested models")
    statistic = 2.0 * (full.loglik - reduced.loglik)
    dof = len(full.terms) - len(reduced.terms)
    return statistic, dof, float(special.chdtrc(dof, max(statistic, 0.0)))


def separated(matrix: FloatArray, exceed: FloatArray) -> bool:
    """Return whether some linear predictor separates the outcomes, by linear programming.

    The estimate exists iff no c has s_i x_i c >= 0 for all i, with > 0 for some, s = +-1.

    References:
        Albert and Anderson (1984); Konis (2007), for the linear programme.
    """
    signed = matrix * np.where(exceed > 0.0, 1.0, -1.0)[:, None]
    found = optimize.linprog(
        -np.sum(signed, axis=0),
        A_ub=-signed,
        b_ub=np.zeros(signed.shape[0]),
        bounds=(-1.0, 1.0),
        method="highs",
    )
    return found.fun is None or -float(found.fun) > 1e-8 * signed.shape[0]


def _matrix(terms: Sequence[str], ln_im: FloatArray, axes: Mapping[str, FloatArray]) -> FloatArray:
    columns = {"1": np.ones_like(ln_im), LN_IM: ln_im, **axes}
    out: list[FloatArray] = []
    for term in terms:
        value = np.ones_like(ln_im)
        for name in term.split(":"):
            if name not in columns:
                raise InputError(
                    f"term {term!r}: unknown variable {name!r} (known: {', '.join(columns)})"
                )
            value = value * columns[name]
        out.append(value)
    return np.column_stack(out)


def _level_and_slope(
    terms: Sequence[str], coefficients: FloatArray, axes: Mapping[str, float]
) -> tuple[float, float]:
    level = slope = 0.0
    for term, coefficient in zip(terms, coefficients, strict=True):
        names = term.split(":")
        value = float(coefficient)
        value *= float(np.prod([axes[name] for name in names if name not in ("1", LN_IM)]))
        level, slope = (level, slope + value) if LN_IM in names else (level + value, slope)
    return level, slope


def _slope_positive(
    terms: Sequence[str], coefficients: FloatArray, axes: Mapping[str, FloatArray]
) -> bool:
    """Check the corners of the box: the slope is multilinear, so they hold its extremes."""
    ends = [(float(np.min(values)), float(np.max(values))) for values in axes.values()]
    return all(
        _level_and_slope(terms, coefficients, dict(zip(axes, corner, strict=True)))[1] > 0.0
        for corner in product(*ends)
    )
