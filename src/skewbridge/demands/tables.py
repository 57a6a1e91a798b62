"""The demands table as an Arrow table and as parquet files."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
    """Return the rows as a sorted Arrow table.

    Args:
        rows: Rows with every column of the schema; a demand that was never reached is None.
        provenance: Texts for the file metadata.

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


def write_demands(
    rows: Iterable[Mapping[str, Any]], path: Path, metadata: Mapping[str, str]
) -> None:
    """Write rows of the demands table to a parquet file.

    Raises:
        ValueError: The rows do not fit the schema.
    """
    write_table(to_table(rows, metadata), path)


def write_variant(rows: Sequence[Mapping[str, Any]], path: Path, limits: SuspectLimits) -> None:
    """Write the demands of one variant, and mark the rows that are suspect.

    Args:
        rows: Rows of its analyses.
        path: Parquet file.
        limits: Limits above which a row is suspect.

    Raises:
        ValueError: A row occurs twice or does not fit the schema.
    """
    judged = [{**row, SUSPECT: reasons(row, limits)} for row in rows]
    digest = _analyses_digest(row["run_key"] for row in rows)
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
    metadata = provenance(analyses_digest=_analyses_digest(keys))
    write_joined(map(_variant_table, _by_variant(paths)), output, metadata)


def _by_variant(paths: Sequence[Path]) -> Iterator[list[Path]]:
    """Yield the tables of each variant: one, or one of every round that it took part in."""
    for _, of_variant in groupby(paths, key=lambda path: path.name):
        yield list(of_variant)


def _variant_table(paths: Sequence[Path]) -> pa.Table:
    tables = list(map(read_table, paths))
    if len(tables) == 1:
        return tables[0]
    return pa.concat_tables(tables).sort_by([(name, "ascending") for name in KEY])


def _analyses_digest(run_keys: Iterable[str]) -> str:
    """Return the digest of the analyses, independent of their order."""
    return digest_of(*sorted(run_keys))
