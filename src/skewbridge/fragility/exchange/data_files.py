"""Columns of numbers from JSON, CSV and parquet files."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.provenance.tables import read_frame


def read_table(path: Path) -> pd.DataFrame:
    """Read a parquet table, or CSV whatever its ending.

    Raises:
        InputError: The file cannot be read, or is a table of another version of this program.
    """
    if path.suffix == ".parquet":
        return read_frame(path)
    try:
        return pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read {path}: {error}") from error


def read_data(path: Path, where: str | None = None) -> pd.DataFrame | Mapping[str, Any]:
    """Read a JSON object of columns, or a CSV or parquet table.

    Raises:
        InputError: The file cannot be read, is of another kind, or the condition is wrong.
    """
    data: Any
    if path.suffix == ".json":
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"cannot read {path}: {error}") from error
    elif path.suffix in {".csv", ".parquet"}:
        data = read_table(path)
    else:
        raise InputError(f"{path.name}: expected .json, .csv or .parquet")
    if isinstance(data, list):
        data = pd.DataFrame(data)
    if not isinstance(data, dict | pd.DataFrame):
        raise InputError(f"{path.name} must hold an object of columns")
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
    if "@" in where or "__" in where:
        raise InputError(f"--where may only compare columns with values, got {where!r}")
    try:
        chosen = data.query(where, engine="python")
    except Exception as error:  # pandas raises whatever its parser meets
        raise InputError(f"--where {where!r}: {error}") from error
    if chosen.empty:
        raise InputError(f"--where {where!r} selects no row of {len(data)}")
    return chosen
