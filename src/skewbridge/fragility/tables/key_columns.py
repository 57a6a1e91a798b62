"""The columns that say which run a row is: identity of the variant, its axes, its loading."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL
from skewbridge.variant.axes import axes_of

BRIDGE_COLUMNS: Final = ("bridge", "abutment")
IDENTITY_COLUMNS: Final = ("variant", *BRIDGE_COLUMNS)
LOADING_COLUMNS: Final = ("motion_id", "scale", "incidence_deg")
KEY_COLUMNS: Final = (*IDENTITY_COLUMNS, *LOADING_COLUMNS, "status")


def axis_names(table: pd.DataFrame) -> list[str]:
    """Return the axis columns of a table, in the order of the axis table."""
    return [axis.name for axis in axes_of(map(str, table.columns))]


def varying_axes(table: pd.DataFrame) -> list[str]:
    """Return the axis columns in which the rows of a table differ."""
    return [name for name in axis_names(table) if table[name].nunique() > 1]


def models_of(table: pd.DataFrame) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Yield each bridge with each abutment model, and its rows: nothing is pooled over these."""
    for key, own in table.groupby(list(BRIDGE_COLUMNS), sort=True):
        yield dict(zip(BRIDGE_COLUMNS, key, strict=True)), own


def variant_columns(table: pd.DataFrame) -> list[str]:
    """Return the columns that describe a variant: name, bridge, abutment model and axes."""
    return [*IDENTITY_COLUMNS, *axis_names(table)]


def variant_values(part: pd.DataFrame) -> dict[str, object]:
    """Return the description of the one variant of a part of a table."""
    return {name: part[name].iloc[0] for name in variant_columns(part)}


def variants_of(demands: pd.DataFrame, columns: Sequence[str]) -> Iterator[pd.DataFrame]:
    """Yield the rows of each variant with what a fit takes: key, axes, outcome, ``columns``.

    They are numbered as in the whole table.
    """
    table = demand_columns(demands, columns).reset_index(drop=True)
    for _, part in table.groupby("variant", sort=True):
        yield part


def demand_columns(demands: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """Return key, axes and outcome of the runs with some columns, for another process."""
    known = (*KEY_COLUMNS, *axis_names(demands), BEYOND_MODEL, *columns)
    return demands[[name for name in dict.fromkeys(known) if name in demands.columns]]


def motion_codes(table: pd.DataFrame) -> NDArray[np.intp]:
    """Return the number of the motion of each run, 0 .. m - 1."""
    return np.unique(table["motion_id"].to_numpy(dtype=str), return_inverse=True)[1]


def need_columns(
    table: pd.DataFrame, columns: Iterable[str], what: str = "the demands table"
) -> None:
    """Check that a table has some columns.

    Raises:
        InputError: One is missing; names it.
    """
    for column in columns:
        if column not in table.columns:
            raise InputError(f"{what} has no column {column!r}", column=column)
