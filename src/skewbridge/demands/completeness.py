"""Completeness of runs: failures of columns, and whether demands are peaks of the whole motion.

After the failure of a column the model of the bridge no longer holds, so the demands of such a run
are peaks up to the failure. They are lower bounds of the peaks over the whole motion, as are those
of a run that collapsed or stopped early.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.statuses import OK

if TYPE_CHECKING:
    import pandas as pd

#: Column of the demands table with the failure mode of a column; empty where none failed.
BEYOND_MODEL: Final = "beyond_model"
#: Demand over capacity of a column by failure mode; a column fails at 1.
FAILURE_DEMANDS: Final = {"shear": "column_shear_dcr", "flexure": "drift_over_capacity"}
#: Column of the demands table that is true where all demands are peaks of the whole motion.
COMPLETE: Final = "complete"
#: Column of the demands table with the demand over capacity of a column, whatever the mode.
COLUMN_FAILURE_RATIO: Final = "column_failure_ratio"


def failure_kinds(table: "pd.DataFrame") -> NDArray[np.str_]:
    """Return the failure mode of a column in each row, or an empty text, shape (n,).

    No column failed in a table without the column `BEYOND_MODEL`.
    """
    if BEYOND_MODEL not in table.columns:
        return np.full(len(table), "", dtype=np.str_)
    return table[BEYOND_MODEL].fillna("").to_numpy(dtype=str)


def is_beyond_model(table: "pd.DataFrame") -> NDArray[np.bool_]:
    """Return for each row whether a column failed, shape (n,)."""
    return np.asarray(failure_kinds(table) != "", dtype=np.bool_)


def completed(status: ArrayLike, failure_kind: ArrayLike) -> NDArray[np.bool_]:
    """Return whether demands are peaks of the whole motion: by status, no column failure."""
    return np.asarray((np.asarray(status) == OK) & (np.asarray(failure_kind) == ""), dtype=np.bool_)


def is_complete(table: "pd.DataFrame") -> NDArray[np.bool_]:
    """Return for each row whether its demands are peaks over the whole motion, shape (n,).

    This follows from the status and the failure of columns. A row is also incomplete if its table
    has the column `COMPLETE` and it is false there.
    """
    derived = completed(table["status"].to_numpy(), failure_kinds(table))
    if COMPLETE not in table.columns:
        return derived
    return derived & table[COMPLETE].ne(other=False).to_numpy(dtype=np.bool_, na_value=True)


def column_failure_ratio(table: "pd.DataFrame | Mapping[str, Any]") -> NDArray[np.float64]:
    """Return the larger demand over capacity of a column, in shear or in flexure, shape (n,).

    Where one of them is unknown it is the other, and NaN where both are.
    """
    unknown = np.full(() if isinstance(table, Mapping) else len(table), np.nan)
    ratios = (np.asarray(table.get(name, unknown), float) for name in FAILURE_DEMANDS.values())
    return np.fmax(*ratios)


def with_derived_columns(table: "pd.DataFrame") -> "pd.DataFrame":
    """Return a demands table with the columns that follow from others, unless it has them.

    Older studies and foreign tables lack `COMPLETE` and `COLUMN_FAILURE_RATIO`; the latter is added
    where a demand over capacity of columns is known.
    """
    derived: dict[str, Any] = {}
    if COMPLETE not in table.columns:
        derived[COMPLETE] = is_complete(table)
    has_ratios = any(name in table for name in FAILURE_DEMANDS.values())
    if COLUMN_FAILURE_RATIO not in table.columns and has_ratios:
        derived[COLUMN_FAILURE_RATIO] = column_failure_ratio(table)
    return table.assign(**derived)
