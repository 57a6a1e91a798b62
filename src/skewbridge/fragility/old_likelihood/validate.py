"""Checks of columns of numbers: an error names the row and the column."""

from collections.abc import Iterable, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.reading import shortened


def as_column(values: ArrayLike, name: str) -> FloatArray:
    """Return the values as a column of numbers; None and text that is no number become errors.

    Raises:
        InputError: A value is no number; names the row and the column.
    """
    if isinstance(values, np.ndarray) and values.dtype.kind in "fiub":
        return values.astype(np.float64)
    items = as_list(values, name)
    out = np.empty(len(items))
    for row, item in enumerate(items):
        try:
            out[row] = np.nan if item is None else float(item)
        except (TypeError, ValueError, OverflowError) as error:
            told = f"must be a number, got {shortened(item)}"
            raise row_error(name, row, told) from error
    return out


def as_list(values: object, name: str) -> Sequence[Any]:
    """Return the values of a column one by one.

    Raises:
        InputError: It is a single value or a mapping.
    """
    if isinstance(values, str | dict) or not isinstance(values, Iterable):
        raise InputError(f"{name} must be a list of numbers, got {shortened(values)}", column=name)
    return list(cast("Iterable[Any]", values))


def require(good: NDArray[np.bool_], name: str, rule: str, values: FloatArray) -> None:
    """Raise an error that names every row in which ``good`` is False.

    Raises:
        InputError: Some row is not good.
    """
    bad = np.flatnonzero(~good)
    if bad.size == 0:
        return
    shown = ", ".join(str(row) for row in bad[:10]) + (" ..." if bad.size > 10 else "")
    plural = "rows" if bad.size > 1 else "row"
    raise InputError(
        f"{name} {rule} ({plural} {shown}); got {values[bad[0]]:g}",
        row=int(bad[0]),
        rows=[int(row) for row in bad],
        column=name,
    )


def require_all(
    good: NDArray[np.bool_], name: str, rule: str, values: FloatArray | None = None
) -> None:
    """Raise an error that names the first row in which ``good`` is False, and its value if given.

    Raises:
        InputError: Some row is not good.
    """
    if not np.all(good):
        row = int(np.argmin(good))
        shown = "" if values is None else f", got {values[row]:g}"
        raise InputError(f"{name} {rule} (row {row}){shown}", row=row, column=name)


def row_error(name: str, row: int, text: str) -> InputError:
    """Return an error about one row of one column."""
    return InputError(f"{name} {text} (row {row})", row=row, rows=[row], column=name)


def positive(values: ArrayLike, name: str) -> FloatArray:
    """Return a column whose values are all positive and finite.

    Raises:
        InputError: Some value is not; names the rows.
    """
    column = as_column(values, name)
    require(np.isfinite(column) & (column > 0.0), name, "must be > 0 and finite", column)
    return column


def same_length(**columns: FloatArray) -> int:
    """Return the common length of the columns.

    Raises:
        InputError: They differ, or there are no rows.
    """
    lengths = {name: column.size for name, column in columns.items()}
    if len(set(lengths.values())) != 1:
        text = ", ".join(f"{name} has {size}" for name, size in lengths.items())
        raise InputError(f"columns differ in length: {text}", row=min(lengths.values()))
    size = next(iter(lengths.values()))
    if size == 0:
        raise InputError(f"no rows in {', '.join(lengths)}", row=0)
    return size
