"""Checks of columns of numbers; errors name the row and the column."""

from collections.abc import Iterable, Sized
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.errors import InputError
from skewbridge.files.text import shortened

type Floats = NDArray[np.float64]
type Mask = NDArray[np.bool_]
#: Numbers of rows, motions or variants.
type Index = NDArray[np.intp]
#: A row of a table by column.
type Row = dict[str, Any]


def as_column(values: ArrayLike, name: str) -> Floats:
    """Return a list of numbers as a column, None as NaN; an `InputError` names row and column."""
    if isinstance(values, np.ndarray) and values.dtype.kind in "fiub":
        return values.astype(np.float64)
    if isinstance(values, str | dict) or not isinstance(values, Iterable):
        raise InputError(f"{name} must be a list of numbers, got {shortened(values)}", column=name)
    items = list(cast("Iterable[Any]", values))
    out = np.empty(len(items))
    for row, item in enumerate(items):
        try:
            out[row] = np.nan if item is None else float(item)
        except (TypeError, ValueError, OverflowError) as error:
            text = f"{name} must be a number, got {shortened(item)} (row {row})"
            raise InputError(text, row=row, rows=[row], column=name) from error
    return out


def require(good: Mask, name: str, rule: str, values: Floats | None = None) -> None:
    """Check a rule for a column; the `InputError` names the rows that break it, and a value."""
    if np.all(good):
        return
    bad = np.flatnonzero(~good).tolist()
    rows = ", ".join(map(str, bad[:10])) + (" ..." if len(bad) > 10 else "")
    shown = "" if values is None else f"; got {values[bad[0]]:g}"
    text = f"{name} {rule} (row{'s' if len(bad) > 1 else ''} {rows}){shown}"
    raise InputError(text, row=bad[0], rows=bad, column=name)


def positive(values: ArrayLike, name: str) -> Floats:
    """Return a column of positive and finite values; an `InputError` names the rows of others."""
    column = as_column(values, name)
    require(np.isfinite(column) & (column > 0.0), name, "must be > 0 and finite", column)
    return column


def same_length(**columns: Sized) -> None:
    """Check that columns have the same length and rows; an `InputError` names their lengths."""
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) != 1:
        text = ", ".join(f"{name} has {size}" for name, size in lengths.items())
        raise InputError(f"columns differ in length: {text}", row=min(lengths.values()))
    if not min(lengths.values()):
        raise InputError(f"no rows in {', '.join(lengths)}", row=0)
