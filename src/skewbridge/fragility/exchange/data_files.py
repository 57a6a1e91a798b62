"""Columns of numbers from JSON, CSV and parquet files."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from skewbridge.errors import InputError


def read_data(path: Path, where: str | None = None) -> pd.DataFrame | Mapping[str, Any]:
    """Read a JSON object of columns, or a CSV or parquet table.

    Raises:
        InputError: The file cannot be read, is of another kind, or the condition is wrong.
    """
    try:
        if path.suffix == ".json":
            data: Any = json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix == ".parquet":
            data = pd.read_parquet(path)
        elif path.suffix == ".csv":
            data = pd.read_csv(path)
        else:
            raise InputError(f"{path.name}: expected .json, .csv or .parquet")
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot read {path}: {error}") from error
    if isinstance(data, list):
        data = pd.DataFrame(data)
    if not isinstance(data, dict | pd.DataFrame):
        raise InputError(f"{path.name} must hold an object of columns")
    if where is None:
        return data
    if not isinstance(data, pd.DataFrame):
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
