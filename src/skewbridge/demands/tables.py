"""Parquet files of the demands table."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from skewbridge.analysis.suspect import SUSPECT, SuspectLimits, reasons
from skewbridge.demands.schema import to_table
from skewbridge.provenance.digests import digest_of
from skewbridge.provenance.tables import provenance, read_table, write_table


def write_demands(
    rows: Iterable[Mapping[str, Any]], path: Path, metadata: Mapping[str, str]
) -> None:
    """Write rows of the demands table to a parquet file.

    Raises:
        ValueError: The rows do not fit the schema.
    """
    write_table(to_table(rows, metadata), path)


def collect_demands(parts: Iterable[Path], output: Path, limits: SuspectLimits) -> None:
    """Join the demands of all variants into one table, check it, and say what is suspect.

    Raises:
        InputError: A part was written by another version of the program.
        ValueError: A row is there twice or does not fit the schema.
    """
    tables = [read_table(path) for path in parts]
    digests = [(table.schema.metadata or {}).get(b"analyses_digest", b"") for table in tables]
    rows = [{**row, SUSPECT: reasons(row, limits)} for table in tables for row in table.to_pylist()]
    digest = digest_of(*(part.decode() for part in digests))
    write_demands(rows, output, provenance(analyses_digest=digest))
