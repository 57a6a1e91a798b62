"""The demands table as an Arrow table and as parquet files."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from math import nan
from pathlib import Path
from typing import Any, Final

import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.demands.columns import (
    COLUMNS,
    KEY,
    Column,
    columns_with,
    joint_columns,
    option_columns,
)
from skewbridge.demands.validity import with_suspect
from skewbridge.files.digests import digest_of, provenance
from skewbridge.files.tables import read_table, write_joined, write_table
from skewbridge.statuses import STATUSES

_TYPES: Final = {
    "text": pa.string(),
    "integer": pa.int64(),
    "number": pa.float64(),
    "boolean": pa.bool_(),
}


def demands_schema(columns: Iterable[Column] = COLUMNS) -> pa.Schema:
    """Return the Arrow schema with unit and description in the metadata of each field."""
    fields: list[pa.Field[Any]] = []
    for column in columns:
        texts = {"unit": column.unit, "description": column.description}
        fields.append(pa.field(column.name, _TYPES[column.kind], metadata=texts))
    return pa.schema(fields)


def to_table(rows: Iterable[Mapping[str, Any]], provenance: Mapping[str, str]) -> pa.Table:
    """Return rows of demands as an Arrow table sorted by `KEY`, with provenance as metadata.

    `ValueError` for a wrong column or status, or a repeated key.
    """
    by_key: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        key = tuple(row[name] for name in KEY)
        if key in by_key:
            raise ValueError(f"an analysis appears twice: {key}")
        if row["status"] not in STATUSES:
            raise ValueError(f"row {key}: unknown status {row['status']!r}")
        by_key[key] = dict(row)
    ordered = [by_key[key] for key in sorted(by_key)]
    columns = columns_with(dict.fromkeys(name for row in ordered for name in row))
    names = {column.name for column in columns}
    for row in ordered:
        for column in joint_columns(names):  # an analysis that crashed knows no joints
            row.setdefault(column.name, nan)
        if row.keys() != names:
            wrong_names = sorted(row.keys() ^ names)
            raise ValueError(f"row {row['run_key']}: missing or unknown columns {wrong_names}")
    table = pa.Table.from_pylist(ordered, schema=demands_schema(columns))
    return table.replace_schema_metadata(dict(provenance))


def write_variant(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write the demands of one variant; the column `suspect` states why a row is suspect."""
    digest = digest_of(*sorted(row["run_key"] for row in rows))
    write_table(to_table(map(with_suspect, rows), provenance(analyses_digest=digest)), path)


def join_variants(paths: Sequence[Path], output: Path) -> None:
    """Join the demands of all variants of a study into one file, one variant in memory at a time.

    ``paths`` are files of `write_variant`, sorted by variant. `ValueError` for different columns.
    """
    run_keys = {path: pq.read_table(path, columns=["run_key"])["run_key"] for path in paths}
    keys: list[Any] = [key for column in run_keys.values() for key in column.to_pylist()]
    present = dict.fromkeys(name for path in paths for name in pq.read_schema(path).names)
    optional = demands_schema((*joint_columns(present), *option_columns(present)))
    order = [column.name for column in columns_with(present)]

    def filled(path: Path) -> pa.Table:
        """Return the table of a file with empty columns for joints and options of other bridges."""
        table = read_table(path)
        for field in optional:
            if field.name not in table.column_names:
                table = table.append_column(field, pa.nulls(len(table), field.type))
        return table.select(order) if len(optional) else table

    groups = groupby((path for path in paths if len(run_keys[path])), key=lambda path: path.name)
    tables = (
        pa.concat_tables(map(filled, files)).sort_by([(name, "ascending") for name in KEY])
        for _, files in groups
    )
    write_joined(tables, output, provenance(analyses_digest=digest_of(*sorted(keys))))
