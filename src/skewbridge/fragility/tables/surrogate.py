"""Analysis of variance of ln demand with the motion as block."""

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.validate import require_all
from skewbridge.fragility.tables.beyond_model import is_complete
from skewbridge.fragility.tables.key_columns import varying_axes


def anova(demands: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return the type-II analysis of variance of ln demand with the motion as block.

    Factors are the axes (as categories) and their two-way products; a main effect is
    compared with the model of all terms that do not contain it.

    Returns:
        Rows term, sum_sq, dof, f, p_value, partial_eta2 = SS/(SS + SS residual).
    """
    table = _usable(demands, column)
    y = _within(np.log(table[column].to_numpy(dtype=np.float64))[:, None], table)[:, 0]
    factors = varying_axes(table)
    parts = {name: _dummies(table[name]) for name in factors}
    for first, second in combinations(factors, 2):
        both = parts[first][:, :, None] * parts[second][:, None, :]
        parts[f"{first}:{second}"] = both.reshape(y.size, -1)
    parts = {name: _within(value, table) for name, value in parts.items()}
    full, rank = _residual(y, list(parts.values()))
    blocks = int(np.max(_block_codes(table))) + 1
    dof = y.size - blocks - rank
    rows: list[dict[str, Any]] = []
    for term, own in parts.items():
        margin = [
            v for name, v in parts.items() if not set(term.split(":")) <= set(name.split(":"))
        ]
        without, low = _residual(y, margin)
        within, high = _residual(y, [*margin, own])
        explained, steps = without - within, high - low
        ratio = explained / steps / (full / dof) if dof > 0 and full > 0.0 else np.nan
        rows.append(
            {
                "term": term,
                "sum_sq": explained,
                "dof": steps,
                "f": ratio,
                "p_value": float(special.fdtrc(steps, dof, ratio)) if ratio == ratio else np.nan,
                "partial_eta2": explained / (explained + full) if full > 0.0 else np.nan,
            }
        )
    rows.append({"term": "residual", "sum_sq": full, "dof": dof})
    return pd.DataFrame(rows)


def _usable(demands: pd.DataFrame, column: str) -> pd.DataFrame:
    used = is_complete(demands) & demands[column].notna().to_numpy()
    table = demands[used].reset_index(drop=True)
    good = table[column].to_numpy(dtype=np.float64) > 0.0
    if table.empty:
        good = np.zeros(1, dtype=np.bool_)
    require_all(good, column, "must be > 0 in completed runs")
    return table


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


def _dummies(values: pd.Series) -> FloatArray:
    levels = sorted(values.unique())
    return np.column_stack([(values == level).to_numpy(dtype=np.float64) for level in levels[1:]])


def _residual(y: FloatArray, parts: Sequence[FloatArray]) -> tuple[float, int]:
    """Return the residual sum of squares and the rank of a model."""
    if not parts:
        return float(y @ y), 0
    matrix = np.hstack(parts)
    solution, _, rank, _ = np.linalg.lstsq(matrix, y, rcond=None)
    left = y - matrix @ solution
    return float(left @ left), int(rank)
