"""What each axis does to a demand: Sobol indices of its model over the axes, and its prediction.

References:
    Sobol (2001), Math. Comput. Simul. 55:271-280; Saltelli et al. (2010), for the indices.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pandas as pd
from scipy import stats

from skewbridge.fragility.old_joint.fits import JointFit, fit_demand
from skewbridge.fragility.old_joint.runs import joint_runs
from skewbridge.fragility.old_joint.surface import Surface
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.tables.beyond_model import is_complete


@dataclass(frozen=True, slots=True, kw_only=True)
class Shares:
    """Shares of the axes in ln demand, in the order of ``axes``.

    Attributes:
        axes: The axes that differ.
        first_order: Sobol indices of first order.
        total_order: Total Sobol indices.
        scatter: Scatter of ln demand within motions about the model.
        worst_prediction: Largest relative error for a variant that was left out; NaN without one.
    """

    axes: tuple[str, ...]
    first_order: FloatArray
    total_order: FloatArray
    scatter: float
    worst_prediction: float


def axis_shares(part: pd.DataFrame, column: str, im_column: str, seed: int) -> Shares | None:
    """Return the shares of the axes of one bridge and abutment model, None without a model.

    ``part`` are its rows; a run that did not complete has a demand above its last value.
    """
    runs = joint_runs(part.reset_index(drop=True), im_column)
    demand = np.nan_to_num(runs.demand(column), nan=0.0)
    seen = is_complete(part) & part[column].notna().to_numpy()
    fit = fit_demand(runs, demand, seen, seen | (demand > 0.0))
    if fit.surface is None or not runs.box.limits:
        return None
    first, total = sobol(*_relative(fit, fit.surface, runs.ln_im), seed=seed)
    errors = np.abs(np.expm1(fit.level_error if fit.level_error is not None else np.empty(0)))
    errors = errors[np.isfinite(errors)]
    return Shares(
        axes=tuple(runs.box.limits),
        first_order=first,
        total_order=total,
        scatter=fit.sigma,
        worst_prediction=float(np.max(errors)) if errors.size else np.nan,
    )


def _relative(
    fit: JointFit, surface: Surface, ln_im: FloatArray
) -> tuple[Callable[[FloatArray], FloatArray], list[float], list[float]]:
    """Return ln demand at the mean ln intensity as a function of the axes, and their limits."""
    names = list(surface.box.limits)
    params = np.empty(0) if fit.sums is None else fit.sums.params
    middle = float(np.mean(ln_im))

    def value(x: FloatArray) -> FloatArray:
        points = pd.DataFrame(dict(zip(names, x.reshape(len(names), -1), strict=True)))
        own = Surface(variants=points, box=surface.box, terms=surface.terms)
        each = np.arange(len(points))
        return (own.design(np.full(len(points), middle), each) @ params).reshape(x.shape[1:])

    low, high = zip(*surface.box.limits.values(), strict=True)
    return value, list(low), list(high)


def sobol(
    function: Callable[[FloatArray], FloatArray],
    low: Sequence[float],
    high: Sequence[float],
    *,
    n: int = 4096,
    seed: int,
) -> tuple[FloatArray, FloatArray]:
    """Return first-order and total Sobol indices over a box with uniform inputs.

    The function maps inputs of shape (d, n) to values of shape (n,); n is a power of two.
    """
    if len(low) == 1:  # all of the variance is its; scipy fails on a single input
        return np.ones(1), np.ones(1)
    inputs = [stats.uniform(loc=a, scale=b - a) for a, b in zip(low, high, strict=True)]
    # the stubs of scipy do not know that a frozen distribution has a ppf
    found = stats.sobol_indices(
        func=function, n=n, dists=cast(Any, inputs), rng=np.random.default_rng(seed)
    )
    return np.asarray(found.first_order), np.asarray(found.total_order)
