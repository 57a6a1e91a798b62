"""The demands table as Arrow and parquet see it, and the key of its rows."""

from collections.abc import Iterable, Mapping
from typing import Any, Final

import pyarrow as pa

from skewbridge.analysis.suspect import SUSPECT
from skewbridge.demands.columns import COLUMNS, axis_column
from skewbridge.demands.demand_columns import Column
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import AXES, axes_of
from skewbridge.variant.variant import Variant

KEY: Final = ("variant", "motion_id", "scale", "incidence_deg")
_TYPES: Final = {"text": pa.string(), "integer": pa.int64(), "number": pa.float64()}


def columns_with(present: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns of the table: those of every study, and the further axes of this one.

    Args:
        present: Names that a row has; the modelling options among them are axes.
    """
    known = {column.name for column in COLUMNS}
    extra = tuple(axis_column(axis) for axis in axes_of(present) if axis.name not in known)
    after = 1 + next(i for i, column in enumerate(COLUMNS) if column.name == AXES[-1].name)
    return (*COLUMNS[:after], *extra, *COLUMNS[after:])


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


def key_values(
    variant: Variant, motion_id: str, scale: float, incidence_deg: float
) -> dict[str, Any]:
    """Return the key columns of one analysis."""
    return {
        "variant": variant.slug,
        "bridge": variant.bridge_name,
        "abutment": variant.abutment,
        **variant.values(),
        "motion_id": motion_id,
        "scale": scale,
        "incidence_deg": incidence_deg,
    }


def to_table(rows: Iterable[Mapping[str, Any]], provenance: Mapping[str, str]) -> pa.Table:
    """Return the rows as a sorted Arrow table.

    Args:
        rows: Rows with every column of the schema; a demand that was never reached is None. What
            is suspect is decided where rows are collected: all have that column, or none.
        provenance: Texts for the file metadata.

    Raises:
        ValueError: A row lacks a column, has one too many, an unknown status, or its key twice.
    """
    ordered = sorted(rows, key=lambda row: tuple(row[name] for name in KEY))
    is_judged = not ordered or SUSPECT in ordered[0]
    columns = [
        column
        for column in columns_with(ordered[0] if ordered else ())
        if is_judged or column.name != SUSPECT
    ]
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
