"""Tables of text: CSV with one header line, every row as wide as it."""

import csv
import io
import warnings
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.reading.files import read_text, shortened, shown_path

MAX_CSV_BYTES: Final = 64_000_000
MAX_CELLS: Final = 5_000_000
MAX_COLUMNS: Final = 2_000
# source: OWASP, CSV injection: cells that spreadsheets take for formulas
_FORMULA_STARTS: Final = ("=", "+", "-", "@", "\t", "\r")


def read_csv(path: Path, **options: Any) -> pd.DataFrame:
    """Return a CSV table.

    Args:
        path: The file, UTF-8.
        options: Of `pandas.read_csv`, for the types of the cells.

    Raises:
        InputError: The file cannot be read or is too large, a column stands twice, or a row has
            more or fewer cells than the header; names the line.
    """
    text, shown = read_text(path, MAX_CSV_BYTES), shown_path(path)
    try:
        _refuse_ragged(text)
        with warnings.catch_warnings():  # of blank cells beyond the header
            warnings.simplefilter("ignore", pd.errors.ParserWarning)
            return pd.read_csv(io.StringIO(text), index_col=False, **options)
    except (ValueError, csv.Error, OverflowError) as error:
        told = " ".join(str(error).split())
        raise InputError(f"{shown} is not a table: {told}", file=str(path)) from None


def records_of(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a table, each by the names of the columns."""
    return [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]


def no_formula(value: Any) -> Any:
    """Return a cell that a spreadsheet takes for no formula: such a text gets a ``'``."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value


def _refuse_ragged(text: str) -> None:
    """Refuse a header with a name twice and rows of another width; blank rows do not count."""
    rows = csv.reader(io.StringIO(text), skipinitialspace=True, strict=True)
    header = next((row for row in rows if row), None)
    if header is None:
        raise ValueError("it is empty")
    names = [name.strip() for name in header]
    twice = next((name for name in names if name and names.count(name) > 1), None)
    if len(names) > MAX_COLUMNS:
        raise ValueError(f"{len(names)} columns, at most {MAX_COLUMNS} are read")
    if twice is not None:
        raise ValueError(f"the column {shortened(twice)} stands twice")
    cells = 0
    for row in rows:
        cells += len(row)
        if cells > MAX_CELLS:
            raise ValueError(f"more than {MAX_CELLS} cells")
        if row and len(row) != len(names) and any(cell.strip() for cell in row[len(names) :]):
            raise ValueError(f"line {rows.line_num} has {len(row)} cells, the header {len(names)}")
        if row and len(row) < len(names):
            raise ValueError(f"line {rows.line_num} has {len(row)} cells, the header {len(names)}")
