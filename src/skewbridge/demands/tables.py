"""The demands table as an Arrow table and as parquet files."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, Final

import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.demands.columns import COLUMNS, KEY, columns_with
from skewbridge.demands.demand_columns import Column
from skewbridge.demands.suspect import SUSPECT, SuspectLimits, reasons
from skewbridge.files.digests import digest_of, provenance
from skewbridge.files.tables import read_table, write_joined, write_table
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
    """Return the Arrow schema with unit and description of each field and the provenance."""
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
    """Return rows of the demands as a sorted Arrow table with provenance in its metadata.

    Raises:
        ValueError: A row lacks a column, has an unknown column or status, or repeats a key.
    """
    ordered = sorted(rows, key=lambda row: tuple(row[name] for name in KEY))
    columns = columns_with(ordered[0] if ordered else ())
    names = [column.name for column in columns]
    keys = [tuple(row[name] for name in KEY) for row in ordered]
    if len(set(keys)) != len(keys):
        raise ValueError(f"an analysis appears twice: {next(k for k in keys if keys.count(k) > 1)}")
    for row, key in zip(ordered, keys, strict=True):
        if set(row) != set(names):
            raise ValueError(f"row {key}: wrong columns {sorted(set(row) ^ set(names))}")
        if row["status"] not in STATUSES:
            raise ValueError(f"row {key}: unknown status {row['status']!r}")
    schema = demands_schema(provenance, columns)
    return pa.table({name: [row[name] for row in ordered] for name in names}, schema=schema)


def write_variant(rows: Sequence[Mapping[str, Any]], path: Path, limits: SuspectLimits) -> None:
    """Write the demands of one variant, and mark the rows above the limits as suspect.

    Raises:
        ValueError: As `to_table`.
    """
    judged = [{**row, SUSPECT: reasons(row, limits)} for row in rows]
    digest = digest_of(*sorted(row["run_key"] for row in rows))
    write_table(to_table(judged, provenance(analyses_digest=digest)), path)


def join_variants(paths: Sequence[Path], output: Path) -> None:
    """Join the demands of the variants of a study into one table; one of them is held at a time.

    Args:
        paths: Tables of `write_variant`, in the order of the names of the variants; those of the
            rounds of one variant follow each other.
        output: Parquet file.

    Raises:
        ValueError: The tables have different columns.
    """
    keys: list[Any] = []
    for path in paths:
        keys += pq.read_table(path, columns=["run_key"])["run_key"].to_pylist()
    rounds = groupby(paths, key=lambda path: path.name)
    tables = (_sorted_table(list(of_variant)) for _, of_variant in rounds)
    write_joined(tables, output, provenance(analyses_digest=digest_of(*sorted(keys))))


def _sorted_table(paths: Sequence[Path]) -> pa.Table:
    tables = list(map(read_table, paths))
    if len(tables) == 1:
        return tables[0]
    return pa.concat_tables(tables).sort_by([(name, "ascending") for name in KEY])
