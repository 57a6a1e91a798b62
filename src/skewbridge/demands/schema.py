"""The demands table as Arrow and parquet see it."""

from collections.abc import Iterable, Mapping
from typing import Any, Final

import pyarrow as pa

from skewbridge.demands.columns import COLUMNS, KEY, columns_with
from skewbridge.demands.demand_columns import Column
from skewbridge.statuses import STATUSES

_TYPES: Final = {
    "text": pa.string(),
    "integer": pa.int64(),
    "number": pa.float64(),
    "boolean": pa.bool_(),
}


def demands_schema(
    provenance: Mapping[str, str] | None = None, columns: Iterable[Column] = COLUMNS
) -> pa.Schema:
    """Return the Arrow schema: unit and description per field, provenance for the file."""
    fields = [
        pa.field(
            column.name,
            _TYPES[column.kind],
            metadata={"unit": column.unit, "description": column.description},
        )
        for column in columns
    ]
    metadata: dict[bytes | str, bytes | str] = dict((provenance or {}).items())
    return pa.schema(fields, metadata=metadata)


def to_table(rows: Iterable[Mapping[str, Any]], provenance: Mapping[str, str]) -> pa.Table:
    """Return the rows as a sorted Arrow table.

    Args:
        rows: Rows with every column of the schema; a demand that was never reached is None.
        provenance: Texts for the file metadata.

    Raises:
        ValueError: A row lacks a column, has one too many, an unknown status, or its key twice.
    """
    ordered = sorted(rows, key=lambda row: tuple(row[name] for name in KEY))
    columns = columns_with(ordered[0] if ordered else ())
    names = [column.name for column in columns]
    keys = [tuple(row[name] for name in KEY) for row in ordered]
    if len(set(keys)) != len(keys):
        raise ValueError(
            f"an analysis is there twice: {next(k for k in keys if keys.count(k) > 1)}"
        )
    for row, key in zip(ordered, keys, strict=True):
        if set(row) != set(names):
            raise ValueError(f"row {key}: wrong columns {sorted(set(row) ^ set(names))}")
        if row["status"] not in STATUSES:
            raise ValueError(f"row {key}: unknown status {row['status']!r}")
    schema = demands_schema(provenance, columns)
    return pa.table({name: [row[name] for row in ordered] for name in names}, schema=schema)
