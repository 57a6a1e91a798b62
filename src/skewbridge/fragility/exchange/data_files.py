"""Columns of numbers from JSON, CSV and parquet files; CSV files for spreadsheets."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.conditions import rows_where
from skewbridge.provenance.tables import read_frame
from skewbridge.reading import read_json
from skewbridge.reading.files import shown_path
from skewbridge.reading.tables import no_formula, read_csv


def read_table(path: Path) -> pd.DataFrame:
    """Read a parquet table, or CSV whatever its ending.

    Raises:
        InputError: The file cannot be read, or is a table of another version of this program.
    """
    return read_frame(path) if path.suffix == ".parquet" else read_csv(path)


def read_data(path: Path, where: str | None = None) -> pd.DataFrame | Mapping[str, Any]:
    """Read a JSON object of columns, or a CSV or parquet table.

    Raises:
        InputError: The file cannot be read, is of another kind, or the condition is wrong.
    """
    data: Any
    if path.suffix == ".json":
        data = read_json(path)
    elif path.suffix in {".csv", ".parquet"}:
        data = read_table(path)
    else:
        raise InputError(f"{shown_path(path)}: expected .json, .csv or .parquet", file=str(path))
    if isinstance(data, list) and all(isinstance(row, dict) for row in data):
        data = pd.DataFrame(data)
    if not isinstance(data, dict | pd.DataFrame):
        raise InputError(f"{shown_path(path)} must hold an object of columns", file=str(path))
    return data if where is None else select_rows(data, where)


def select_rows(data: pd.DataFrame | Mapping[str, Any], where: str | None) -> pd.DataFrame:
    """Return the rows of a table that a condition selects, all without one.

    Raises:
        InputError: The data are no table, the condition is wrong or selects nothing.
    """
    if isinstance(data, pd.DataFrame) and where is None:
        return data
    if where is None or not isinstance(data, pd.DataFrame):
        raise InputError("--where needs a table (CSV or parquet)")
    return rows_where(data, where)


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a CSV file in which no text is a formula to a spreadsheet: such texts get a ``'``.

    Raises:
        OSError: The file cannot be written.
    """
    texts = frame.select_dtypes(exclude=["number", "bool"]).columns
    safe = {name: frame[name].map(no_formula) for name in texts}
    named = {name: no_formula(str(name)) for name in frame.columns}
    frame.assign(**safe).rename(columns=named).to_csv(path, index=False)
