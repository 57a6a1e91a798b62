"""Parquet files of the demands table, written whole or not at all."""

import os
import platform
import subprocess
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.demands.schema import to_table
from skewbridge.provenance.digests import PACKAGE, digest_of


def provenance(**digests: str) -> dict[str, str]:
    """Return what a result depends on: versions, commit, and the digests given."""
    packages = ("openseespy", "numpy", "scipy", "pandas", "pyarrow", "skewbridge")
    return {
        # not the bare name: "pandas" is a key that pandas writes itself
        "python_version": platform.python_version(),
        **{f"{name}_version": version(name) for name in packages},
        "git_commit": _git_commit(),
        **digests,
    }


def write_demands(
    rows: Iterable[Mapping[str, Any]], path: Path, metadata: Mapping[str, str]
) -> None:
    """Write rows of the demands table to a parquet file.

    Raises:
        ValueError: The rows do not fit the schema.
    """
    write_parquet(to_table(rows, metadata), path)


def write_parquet(table: pa.Table, path: Path) -> None:
    """Write a table under a temporary name, then rename: never a file that is half there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    pq.write_table(table, part)
    part.replace(path)


def write_frame(frame: pd.DataFrame, path: Path, metadata: Mapping[str, str]) -> None:
    """Write a data frame to parquet with provenance in the file metadata."""
    table = pa.Table.from_pandas(frame, preserve_index=False)
    own = {key.encode(): value.encode() for key, value in metadata.items()}
    write_parquet(table.replace_schema_metadata({**(table.schema.metadata or {}), **own}), path)


def read_demands(paths: Iterable[Path]) -> list[dict[str, Any]]:
    """Return the rows of several files of the demands table."""
    return [row for path in paths for row in pq.read_table(path).to_pylist()]


def collect_demands(parts: Iterable[Path], output: Path) -> None:
    """Join the demands of all variants into one table and check it.

    Raises:
        ValueError: A row is there twice or does not fit the schema.
    """
    paths = list(parts)
    digests = [
        (pq.read_schema(path).metadata or {}).get(b"analyses_digest", b"").decode()
        for path in paths
    ]
    write_demands(read_demands(paths), output, provenance(analyses_digest=digest_of(*digests)))


def _git_commit() -> str:
    found = subprocess.run(
        ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"],
        capture_output=True,
        text=True,
        check=False,
    )
    return found.stdout.strip() or "unknown"
