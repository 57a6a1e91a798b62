"""Demand over intensity and axes with the motion as block: surrogate, Sobol indices.

ln D = motion effect (and b ln x, which the motion absorbs where it ran at one level) + main effects
+ interactions of the axes. Prefer it to the exceedance model wherever the demand is continuous: it
uses more than 0 or 1.

References:
    Sobol (2001), Math. Comput. Simul. 55:271-280; Saltelli et al. (2010), for the indices.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pandas as pd
from scipy import stats

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.validate import require_all
from skewbridge.fragility.methods.axis_probit import scaled_axes
from skewbridge.fragility.tables.beyond_model import is_complete
from skewbridge.fragility.tables.key_columns import axis_names, varying_axes


@dataclass(frozen=True, slots=True, kw_only=True)
class Surrogate:
    """ln demand as a function of the scaled axes, relative to the motion's mean.

    Attributes:
        terms: Names of the terms.
        coefficients: Shape (p,).
        scatter: Residual standard deviation of ln D within a motion.
    """

    terms: tuple[str, ...]
    coefficients: FloatArray
    scatter: float

    def relative(self, axes: Mapping[str, FloatArray]) -> FloatArray:
        """Return ln D minus the motion effect at scaled axis values."""
        return _columns(self.terms, axes) @ self.coefficients


def surrogate_terms(names: Sequence[str]) -> tuple[str, ...]:
    """Return the terms of the surrogate: main effects first, the first axis (skew) squared.

    Interactions are those of the first axis with every other.
    """
    # ASSUME the other axes act alike on each other's levels: their products are left out
    if not names:
        return ()
    first, *others = names
    return (first, f"{first}:{first}", *others, *(f"{first}:{name}" for name in others))


def fit_surrogate(demands: pd.DataFrame, column: str) -> Surrogate:
    """Fit the surrogate by least squares within blocks (motion, scale and incidence).

    Runs that did not complete are left out.

    Returns:
        The surrogate with the terms of `surrogate_terms`; one that the variants of the table
        cannot tell from those before it is dropped.

    Raises:
        InputError: A demand is not positive, or no two variants share a motion.
    """
    table = _usable(demands, column)
    axes = _scaled(table)
    kept: tuple[str, ...] = ()
    for term in surrogate_terms(axis_names(table)):
        x = _within(_columns((*kept, term), axes), table)
        if np.linalg.matrix_rank(x) == len(kept) + 1:
            kept = (*kept, term)
    if not kept:
        raise InputError("no two variants of the table share a motion")
    x = _within(_columns(kept, axes), table)
    y = _within(np.log(table[column].to_numpy(dtype=np.float64))[:, None], table)[:, 0]
    coefficients = np.linalg.inv(x.T @ x) @ (x.T @ y)
    residual = y - x @ coefficients
    dof = y.size - len(kept) - int(np.max(_block_codes(table))) - 1
    return Surrogate(
        terms=kept,
        coefficients=coefficients,
        scatter=float(np.sqrt(residual @ residual / max(dof, 1))),
    )


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


def surrogate_sobol(surrogate: Surrogate, demands: pd.DataFrame, seed: int) -> pd.DataFrame:
    """Return the Sobol indices of ln demand over the box of the axes of a table."""
    names = varying_axes(demands)
    box = {
        name: (float(demands[name].min()), float(demands[name].max()))
        for name in axis_names(demands)
    }

    def value(x: FloatArray) -> FloatArray:
        full = {name: np.full(x.shape[-1], low) for name, (low, _) in box.items()}
        full |= {name: x[i] for i, name in enumerate(names)}
        return surrogate.relative(scaled_axes(full))

    low, high = [box[name][0] for name in names], [box[name][1] for name in names]
    first, total = sobol(value, low, high, seed=seed)
    return pd.DataFrame({"factor": names, "first_order": first, "total_order": total})


def leave_one_variant_out(demands: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return how well the surrogate predicts each variant from all others.

    Returns:
        Rows variant and error, predicted over observed geometric mean minus 1.
    """
    table = _usable(demands, column)
    y = np.log(table[column].to_numpy(dtype=np.float64))
    rows: list[dict[str, Any]] = []
    for variant in sorted(table["variant"].unique()):
        out = (table["variant"] == variant).to_numpy()
        try:
            model = fit_surrogate(table[~out], column)
        except InputError:
            continue  # without this variant the terms cannot be told apart
        relative = y - model.relative(_scaled(table))
        block = pd.Series(relative[~out]).groupby(_key(table[~out])).mean()
        level = block.reindex(_key(table[out])).to_numpy(dtype=np.float64)
        error = float(np.expm1(np.nanmean(level - relative[out])))
        rows.append({"variant": variant, "error": error})
    return pd.DataFrame(rows, columns=["variant", "error"])


def _usable(demands: pd.DataFrame, column: str) -> pd.DataFrame:
    used = is_complete(demands) & demands[column].notna().to_numpy()
    table = demands[used].reset_index(drop=True)
    good = table[column].to_numpy(dtype=np.float64) > 0.0
    if table.empty:
        good = np.zeros(1, dtype=np.bool_)
    require_all(good, column, "must be > 0 in completed runs")
    return table


def _scaled(table: pd.DataFrame) -> dict[str, FloatArray]:
    return scaled_axes({name: table[name].to_numpy(dtype=np.float64) for name in axis_names(table)})


def _columns(terms: Sequence[str], axes: Mapping[str, FloatArray]) -> FloatArray:
    return np.column_stack(
        [np.prod([axes[name] for name in term.split(":")], axis=0) for term in terms]
    )


def _key(table: pd.DataFrame) -> pd.Index:
    return pd.Index(
        table["motion_id"].astype(str)
        + "|"
        + table["scale"].map("{:.12g}".format)
        + "|"
        + table["incidence_deg"].map("{:g}".format)
    )


def _block_codes(table: pd.DataFrame) -> Any:
    return np.unique(_key(table).to_numpy(dtype=str), return_inverse=True)[1]


def _within(values: FloatArray, table: pd.DataFrame) -> FloatArray:
    """Subtract the mean of each block."""
    codes = _block_codes(table)
    count = np.bincount(codes)
    means = np.stack([np.bincount(codes, column) / count for column in values.T], axis=1)
    return values - means[codes]
