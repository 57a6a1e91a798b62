"""Parquet files of the demands table."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from skewbridge.analysis.suspect import SUSPECT, SuspectLimits, reasons
from skewbridge.demands.schema import to_table
from skewbridge.provenance.digests import digest_of
from skewbridge.provenance.tables import provenance, write_table


def write_demands(
    rows: Iterable[Mapping[str, Any]], path: Path, metadata: Mapping[str, str]
) -> None:
    """Write rows of the demands table to a parquet file.

    Raises:
        ValueError: The rows do not fit the schema.
    """
    write_table(to_table(rows, metadata), path)


def write_study(
    rows_of: Mapping[Path, Sequence[Mapping[str, Any]]], output: Path, limits: SuspectLimits
) -> None:
    """Write the demands of every variant, and all of them in one table, and say what is suspect.

    Args:
        rows_of: Rows by the file of their variant.
        output: Parquet file with all rows.
        limits: What is suspect.

    Raises:
        ValueError: A row is there twice or does not fit the schema.
    """
    judged = {
        path: [{**row, SUSPECT: reasons(row, limits)} for row in rows]
        for path, rows in rows_of.items()
    }
    for path, rows in judged.items():
        write_demands(rows, path, provenance(analyses_digest=_analyses_digest(rows)))
    every = [row for rows in judged.values() for row in rows]
    write_demands(every, output, provenance(analyses_digest=_analyses_digest(every)))


def _analyses_digest(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the digest of the analyses, whatever the order in which they ran."""
    return digest_of(*sorted(row["run_key"] for row in rows))
