"""What each run says about a limit state: exceeded, not exceeded, or unknown.

A failed run is never dropped in silence. Its peak so far decides where it exceeds already; else
its outcome is unknown and its demand is known only to exceed that peak.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.tables.key_columns import KEY_COLUMNS, need_columns
from skewbridge.fragility.tables.limit_states import COLLAPSE_EXCEEDS, LimitState
from skewbridge.statuses import COLLAPSE, OK, STATUSES


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcomes:
    """Outcomes of the runs of one variant for one limit state, arrays of shape (n,).

    Attributes:
        exceed: True where the limit state is known to be exceeded.
        unknown: True where the outcome is unknown.
        demand: Demand, or its peak so far; NaN where a run left none.
        complete: True where the demand is final (the run ended, without collapse).
    """

    exceed: NDArray[np.bool_]
    unknown: NDArray[np.bool_]
    demand: FloatArray
    complete: NDArray[np.bool_]


def outcomes_of(demand: FloatArray, status: NDArray[np.str_], state: LimitState) -> Outcomes:
    """Judge runs against a limit state by its median capacity.

    Args:
        demand: Peaks (so far), shape (n,).
        status: Status of each run, shape (n,).
        state: The limit state.
    """
    collapsed = status == COLLAPSE
    complete = status == OK
    above = np.nan_to_num(demand, nan=-np.inf) > state.threshold
    # ASSUME a collapsed bridge exceeds every limit state, unless the state says that its peak up
    # to the collapse decides (column shear)
    exceed = above | (collapsed if state.collapse == COLLAPSE_EXCEEDS else False)
    judged = complete | collapsed
    return Outcomes(exceed=exceed, unknown=~judged & ~exceed, demand=demand, complete=complete)


def check_demands(demands: pd.DataFrame, im_column: str, columns: Sequence[str]) -> None:
    """Check the columns of a demands table that a fit uses.

    Raises:
        InputError: A column is missing, a status unknown, an intensity not positive and finite,
            or a completed run has an infinite or negative demand; names row and column.
    """
    need_columns(demands, (*KEY_COLUMNS, im_column, *columns))
    status = demands["status"].to_numpy(dtype=str)
    known = np.isin(status, STATUSES)
    _require(demands, known, "status", f"must be one of {', '.join(STATUSES)}")
    im = demands[im_column].to_numpy(dtype=np.float64)
    _require(demands, np.isfinite(im) & (im > 0.0), im_column, "must be > 0 and finite")
    for column in columns:
        values = demands[column].to_numpy(dtype=np.float64)
        bad = (status == OK) & (np.isinf(values) | (values < 0.0))
        _require(demands, ~bad, column, "must be >= 0 and finite where status is ok")


def _require(demands: pd.DataFrame, good: NDArray[np.bool_], column: str, rule: str) -> None:
    if np.all(good):
        return
    row = int(np.flatnonzero(~good)[0])
    where = f"row {row} ({demands['variant'].iloc[row]}, {demands['motion_id'].iloc[row]})"
    value = demands[column].iloc[row]
    shown = repr(value) if isinstance(value, str) else f"{value:g}"
    raise InputError(f"{column} {rule}, got {shown} in {where}", row=row, column=column)
