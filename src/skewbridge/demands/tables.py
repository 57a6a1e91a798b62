"""Parquet files of the demands table."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from skewbridge.analysis.suspect import SUSPECT, SuspectLimits, reasons
from skewbridge.demands.schema import to_table
from skewbridge.provenance.digests import digest_of
from skewbridge.provenance.tables import provenance, write_joined, write_table


def write_demands(
    rows: Iterable[Mapping[str, Any]], path: Path, metadata: Mapping[str, str]
) -> None:
    """Write rows of the demands table to a parquet file.

    Raises:
        ValueError: The rows do not fit the schema.
    """
    write_table(to_table(rows, metadata), path)


def write_study(
    rows_of: Iterable[tuple[Path, Sequence[Mapping[str, Any]]]],
    output: Path,
    limits: SuspectLimits,
    run_keys: Iterable[str],
) -> None:
    """Write the demands of every variant, and all of them in one table, and say what is suspect.

    Args:
        rows_of: File and rows of each variant, in the order of their names; held are those of one
            row group.
        output: Parquet file with all rows.
        limits: What is suspect.
        run_keys: Keys of all rows.

    Raises:
        ValueError: A row is there twice or does not fit the schema.
    """
    made_with = provenance()

    def written() -> Iterator[pa.Table]:
        for path, rows in rows_of:
            judged = [{**row, SUSPECT: reasons(row, limits)} for row in rows]
            digest = _analyses_digest(row["run_key"] for row in rows)
            table = to_table(judged, made_with | {"analyses_digest": digest})
            write_table(table, path)
            yield table

    write_joined(written(), output, made_with | {"analyses_digest": _analyses_digest(run_keys)})


def _analyses_digest(run_keys: Iterable[str]) -> str:
    """Return the digest of the analyses, whatever the order in which they ran."""
    return digest_of(*sorted(run_keys))
