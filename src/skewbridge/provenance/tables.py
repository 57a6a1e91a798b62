"""Parquet tables with their provenance and the version of their format."""

import os
import platform
import subprocess
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Final

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.errors import InputError
from skewbridge.provenance.digests import PACKAGE
from skewbridge.provenance.files import written_aside
from skewbridge.reading import read_bytes, shown_path

#: Version of the format, raised when the meaning of a column changes; others are refused.
TABLE_FORMAT: Final = 2
MAX_TABLE_BYTES: Final = 2_000_000_000
MAX_CELLS: Final = 200_000_000
MAX_COLUMNS: Final = 10_000
_GROUP_ROWS: Final = 65_536
_FORMAT_KEY: Final = b"skewbridge_table_format"
_NOT_OURS: Final = frozenset({b"pandas", b"ARROW:schema"})
_PACKAGES: Final = ("openseespy", "numpy", "scipy", "pandas", "pyarrow", "skewbridge")
_CPU_INFO: Final = Path("/proc/cpuinfo")


def provenance(**digests: str) -> dict[str, str]:
    """Return the provenance of a result: versions, commit, machine, and the given digests.

    The machine is described by the kind and number of its processors, without names.
    """
    commit = _git("rev-parse", "--short=12", "HEAD")
    changed = _git("status", "--porcelain", "--untracked-files=no")
    return {
        # not the bare name: "pandas" is a key that pandas writes itself
        "python_version": platform.python_version(),
        **{f"{name}_version": version(name) for name in _PACKAGES},
        "git_commit": commit or "unknown",
        "git_dirty": "unknown" if commit is None else ("yes" if changed else "no"),
        "processor": _processor(),
        "processors": str(os.cpu_count()),
        **digests,
    }


def write_table(table: pa.Table, path: Path) -> None:
    """Write a table atomically, with the version of its format."""
    metadata = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    write_joined([table], path, metadata)


def write_joined(tables: Iterable[pa.Table], path: Path, metadata: Mapping[str, str]) -> None:
    """Write tables of one schema below each other atomically, one row group at a time.

    Args:
        tables: The parts, at least one; only one row group is in memory.
        path: The file.
        metadata: Metadata of the file; the version of the format is added.

    Raises:
        ValueError: The parts have different columns.
    """
    rest = iter(tables)
    first = next(rest)
    own: dict[bytes | str, bytes | str] = {_FORMAT_KEY: str(TABLE_FORMAT)}
    own |= dict(metadata.items())
    schema = first.schema.with_metadata(own)
    with (
        written_aside(path) as aside,
        pq.ParquetWriter(aside, schema, compression="zstd", write_page_checksum=True) as writer,
    ):
        held: list[pa.Table] = []
        for table in chain([first], rest):
            if not table.schema.equals(schema):
                raise ValueError(f"{path.name}: not all parts have the same columns")
            held.append(table.replace_schema_metadata(schema.metadata))
            if sum(each.num_rows for each in held) >= _GROUP_ROWS:
                writer.write_table(pa.concat_tables(held))
                held.clear()
        if held:
            writer.write_table(pa.concat_tables(held))


def write_frame(
    frame: pd.DataFrame,
    path: Path,
    metadata: Mapping[str, str],
    descriptions: Mapping[str, str] | None = None,
) -> None:
    """Write a data frame with provenance in the file metadata and descriptions in its fields."""
    table = pa.Table.from_pandas(frame, preserve_index=False)
    texts = descriptions or {}
    fields = [
        field.with_metadata({"description": texts[field.name]}) if field.name in texts else field
        for field in table.schema
    ]
    table = table.cast(pa.schema(fields).with_metadata(table.schema.metadata))
    found = {**(table.schema.metadata or {}), **encoded(metadata)}
    write_table(table.replace_schema_metadata(found), path)


def encoded(metadata: Mapping[str, str]) -> dict[bytes, bytes]:
    """Return texts by name as the metadata of a file."""
    return {key.encode(): value.encode() for key, value in metadata.items()}


def texts_of(schema: pa.Schema) -> dict[str, str]:
    """Return the metadata of a file by name, without those of pandas and Arrow."""
    entries = (schema.metadata or {}).items()
    return {key.decode(): value.decode() for key, value in entries if key not in _NOT_OURS}


def read_table(path: Path) -> pa.Table:
    """Return a table of this version of the program, or one that another program wrote.

    Raises:
        InputError: The file does not exist, is not parquet, or was written by another version of
            this program in another format; the message states what to do.
    """
    table = _intact_table(path)
    metadata = table.schema.metadata or {}
    unmarked = b"1" if b"skewbridge_version" in metadata else str(TABLE_FORMAT).encode()
    found = metadata.get(_FORMAT_KEY, unmarked).decode(errors="replace")
    if found != str(TABLE_FORMAT):
        raise InputError(
            f"{path} was written by another version of skewbridge (table format {found}, this "
            f"one reads {TABLE_FORMAT}): run the study again to replace it",
            file=str(path),
        )
    return table


def _intact_table(path: Path) -> pa.Table:
    """Return a table as it was written: checksums of pages hold, texts are UTF-8.

    Raises:
        InputError: The file does not exist, is not parquet, is damaged, or has too many cells.
    """
    content = pa.BufferReader(read_bytes(path, MAX_TABLE_BYTES))
    try:
        file = pq.ParquetFile(content, page_checksum_verification=True)
        cells = file.metadata.num_rows * file.metadata.num_columns
        if not 0 <= cells <= MAX_CELLS or file.metadata.num_columns > MAX_COLUMNS:
            problem = f"{shown_path(path)}: {cells} cells, at most {MAX_CELLS} are read"
            raise InputError(problem, file=str(path))
        table = file.read()
        table.validate(full=True)
    except InputError:
        raise
    except (OSError, ValueError, MemoryError, pa.ArrowException) as error:
        problem = "".join(sign if sign.isprintable() else " " for sign in str(error))[:200]
        shown = shown_path(path)
        raise InputError(
            f"{shown} is not an intact parquet table: {problem}", file=str(path)
        ) from None
    return table


def read_frame(path: Path) -> pd.DataFrame:
    """Return a table as `read_table` does, as a data frame.

    Raises:
        InputError: As `read_table`.
    """
    return frame_of(read_table(path))


def frame_of(table: pa.Table) -> pd.DataFrame:
    """Return a table that was read as a data frame."""
    try:
        return table.to_pandas()
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, pa.ArrowException):
        pass  # the metadata of pandas in the file are damaged
    return table.replace_schema_metadata(None).to_pandas()


@cache
def _git(*arguments: str) -> str | None:
    """Return the output of git about the sources, cached; None without git or a repository."""
    try:
        found = subprocess.run(
            ["git", "-C", str(PACKAGE), *arguments], capture_output=True, text=True, check=False
        )
    except OSError:
        return None
    return found.stdout.strip() if found.returncode == 0 else None


def _processor() -> str:
    """Return the kind of the processors, as named by the system."""
    try:
        lines = _CPU_INFO.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()
