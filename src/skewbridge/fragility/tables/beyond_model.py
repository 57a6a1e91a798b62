"""Runs in which a column failed in a way that the model cannot follow, and what is known of them.

The demands of such a run are peaks up to the failure: the column has failed, and every other demand
is at least its value there.
"""

from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.statuses import OK

#: Column of the demands table that says how a column failed; empty where none did.
BEYOND_MODEL: Final = "beyond_model"
KINDS: Final = ("shear", "flexure")


def is_beyond_model(table: pd.DataFrame) -> NDArray[np.bool_]:
    """Return for each row whether it went past what the model can say.

    No row of a table without the column did.
    """
    return np.asarray(failure_kinds(table) != "", dtype=np.bool_)


def failure_kinds(table: pd.DataFrame) -> NDArray[np.str_]:
    """Return for each row how a column failed, or an empty text."""
    if BEYOND_MODEL not in table.columns:
        return np.full(len(table), "", dtype=np.str_)
    return table[BEYOND_MODEL].fillna("").to_numpy(dtype=str)


def is_of_column(demand: str) -> bool:
    """Return whether a demand is one of the columns, by the name of its column in the table."""
    return demand.startswith("column_")


def is_complete(table: pd.DataFrame) -> NDArray[np.bool_]:
    """Return for each row whether its demands are final: it ended, inside the model."""
    return (table["status"] == OK).to_numpy() & ~is_beyond_model(table)
