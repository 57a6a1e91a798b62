"""Parquet tables with a format version, and provenance in files of several types."""

import json
import re
from collections.abc import Iterable, Mapping, Sized
from html import escape, unescape
from itertools import chain
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import ArrayLike, NDArray

from skewbridge.errors import InputError
from skewbridge.files.text import (
    file_fault,
    no_formula,
    printable,
    read_bytes,
    read_csv,
    shortened,
    write_text,
    written_aside,
)

#: Format version, raised when the meaning of a column changes; other versions are refused.
TABLE_FORMAT: Final = 2
MAX_TABLE_BYTES: Final = 2_000_000_000
MAX_TABLE_CELLS: Final = 200_000_000
_GROUP_ROWS: Final = 65_536
_FORMAT_KEY: Final = "skewbridge_table_format"
#: Key of a JSON object and identifier of an HTML element.
MARK: Final = "skewbridge-provenance"
_ELEMENT: Final = re.compile(rf'\n?<template id="{MARK}">(.*?)</template>', re.S)
_SVG_DESCRIPTION: Final = re.compile(r"<dc:description>(.*?)</dc:description>", re.S)


def write_table(table: pa.Table, path: Path, metadata: Mapping[str, str] | None = None) -> None:
    """Write a table atomically, with its metadata, ``metadata`` and the format version."""
    table_texts = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    write_joined([table], path, table_texts | dict(metadata or {}))


def write_joined(tables: Iterable[pa.Table], path: Path, metadata: Mapping[str, str]) -> None:
    """Write tables with equal columns into one file, atomically, one row group at a time."""
    table_iterator = iter(tables)
    first_table = next(table_iterator)
    schema = first_table.schema.with_metadata({**metadata, _FORMAT_KEY: str(TABLE_FORMAT)})
    with (
        written_aside(path) as temporary,
        pq.ParquetWriter(temporary, schema, compression="zstd", write_page_checksum=True) as writer,
    ):
        row_group: list[pa.Table] = []
        for table in chain([first_table], table_iterator):
            if not table.schema.equals(schema):
                raise ValueError(f"{path.name}: the joined tables have different columns")
            row_group.append(table.replace_schema_metadata(schema.metadata))
            if sum(member.num_rows for member in row_group) >= _GROUP_ROWS:
                writer.write_table(pa.concat_tables(row_group))
                row_group.clear()
        if row_group:
            writer.write_table(pa.concat_tables(row_group))


def write_frame(
    frame: pd.DataFrame,
    path: Path,
    metadata: Mapping[str, str],
    descriptions: Mapping[str, str] | None = None,
) -> None:
    """Write a parquet file with metadata, and column descriptions in the metadata of its fields."""
    table = pa.Table.from_pandas(frame, preserve_index=False)
    texts = descriptions or {}
    fields = [
        field.with_metadata({"description": texts[field.name]}) if field.name in texts else field
        for field in table.schema
    ]
    schema = pa.schema(fields).with_metadata(table.schema.metadata)
    write_table(table.cast(schema), path, metadata)


def texts_of(schema: pa.Schema) -> dict[str, str]:
    """Return the metadata of a schema as a dict, without the entries of pandas and Arrow."""
    texts = {key.decode(): value.decode() for key, value in (schema.metadata or {}).items()}
    return {key: text for key, text in texts.items() if key not in {"pandas", "ARROW:schema"}}


def read_table(path: Path, columns: list[str] | None = None) -> pa.Table:
    """Read ``columns`` (None: all) of a parquet table of this format version, or a foreign one.

    `InputError` if it is missing, not parquet, damaged (checksums), too large, or of another
    version.
    """
    content = pa.BufferReader(read_bytes(path, MAX_TABLE_BYTES))
    try:
        file = pq.ParquetFile(content, page_checksum_verification=True)
        cells = file.metadata.num_rows * file.metadata.num_columns
        if not 0 <= cells <= MAX_TABLE_CELLS:
            raise file_fault(path, f" has {cells} cells, but at most {MAX_TABLE_CELLS} are read")
        table = file.read(columns)
        table.validate(full=True)
    except InputError:
        raise
    except (OSError, ValueError, MemoryError, pa.ArrowException) as error:
        problem = printable(" ".join(str(error).split()))[:200]
        raise file_fault(path, f" is not an intact parquet table: {problem}") from None
    metadata = table.schema.metadata or {}
    default_format = b"1" if b"skewbridge_version" in metadata else str(TABLE_FORMAT).encode()
    table_format = metadata.get(_FORMAT_KEY.encode(), default_format).decode(errors="replace")
    if table_format != str(TABLE_FORMAT):
        raise file_fault(
            path,
            f" was written by another version of skewbridge (table format {table_format}, this "
            f"one reads {TABLE_FORMAT}): run the study again to replace it",
        )
    return table


def read_frame(path: Path, columns: list[str] | None = None) -> pd.DataFrame:
    """Read a parquet table as a data frame; arguments and errors are those of `read_table`."""
    return frame_of(read_table(path, columns))


def read_any(path: Path) -> pd.DataFrame:
    """Read a parquet file, or a CSV file if the suffix is not ``.parquet`` (in any case)."""
    if path.suffix.lower() in {".xlsx", ".xls", ".ods", ".feather", ".arrow", ".gz", ".zip"}:
        raise file_fault(path, " is neither CSV nor parquet: save it as one of them")
    return read_frame(path) if path.suffix.lower() == ".parquet" else read_csv(path)


def frame_of(table: pa.Table) -> pd.DataFrame:
    """Return an Arrow table as a data frame, even if its pandas metadata are damaged."""
    try:
        frame = table.to_pandas()
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, pa.ArrowException):
        # the metadata of pandas in the file are damaged
        frame = table.replace_schema_metadata(None).to_pandas()
    levels = [frame.index.get_level_values(number) for number in range(frame.index.nlevels)]
    frame = frame.reset_index(drop=True)
    for level in reversed(levels):
        if level.name is not None and level.name not in frame:
            frame.insert(0, level.name, level)
    return frame


def records_of(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a table as dictionaries keyed by column name."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a CSV file. Texts that a spreadsheet would read as formulas get a leading ``'``."""
    text_columns = frame.select_dtypes(exclude=["number", "bool"]).columns
    escaped = {name: frame[name].map(no_formula) for name in text_columns}
    headings = {name: no_formula(str(name)) for name in frame.columns}
    frame.assign(**escaped).rename(columns=headings).to_csv(path, index=False)


def figure_metadata(metadata: Mapping[str, str]) -> dict[str, str]:
    """Return provenance as the ``metadata`` of matplotlib's ``savefig``, for PNG and SVG."""
    return {"Description": json.dumps(dict(metadata))}


def stamp(path: Path, metadata: Mapping[str, str]) -> None:
    """Write provenance into a file: Parquet, a JSON object or HTML; other files are left unchanged.

    An older provenance is replaced. Figures get provenance when saved (`figure_metadata`).
    """
    if path.suffix == ".parquet":
        write_table(pq.read_table(path), path, metadata)
    elif path.suffix == ".json":
        content = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(content, dict):
            write_text(path, json.dumps(content | {MARK: dict(metadata)}, indent=1))
    elif path.suffix == ".html":
        text = _ELEMENT.sub("", path.read_text(encoding="utf-8"), count=1)
        head_tag = re.search(r"<head\b[^>]*>", text)
        if head_tag is None:
            raise ValueError(f"{path} has no <head> element")
        element = f'\n<template id="{MARK}">{escape(json.dumps(dict(metadata)))}</template>'
        write_text(path, text[: head_tag.end()] + element + text[head_tag.end() :])


def read_stamp(path: Path) -> dict[str, str]:
    """Return the provenance in a file as a dict; raises `InputError` if there is none."""
    if not path.is_file():
        raise InputError(f"there is no file {path}", file=str(path))
    try:
        texts = _texts_in(path)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise InputError(f"cannot read {path}: {error}", file=str(path)) from None
    if not texts:
        raise file_fault(path, " has no provenance: tables, figures and pages of a study have one")
    return texts


def _texts_in(path: Path) -> dict[str, str]:
    if path.suffix == ".parquet":
        return texts_of(pq.read_schema(path))
    if path.suffix == ".png":
        from PIL import Image

        with Image.open(path) as image:
            return json.loads(image.info.get("Description", "{}"))
    if path.suffix == ".json":
        content = json.loads(path.read_bytes())
        return content.get(MARK, {}) if isinstance(content, dict) else {}
    pattern = {".html": _ELEMENT, ".svg": _SVG_DESCRIPTION}.get(path.suffix)
    match = pattern and pattern.search(path.read_text(encoding="utf-8"))
    return json.loads(unescape(match[1])) if match else {}


# --- checks of numeric columns

type Floats = NDArray[np.float64]
type Mask = NDArray[np.bool_]
#: Indices of rows, motions or variants.
type Index = NDArray[np.intp]
#: Values of a table row, keyed by column name.
type Row = dict[str, Any]


def as_column(values: ArrayLike, name: str) -> Floats:
    """Convert numbers to a float array, None to NaN. An `InputError` names row and column."""
    if isinstance(values, np.ndarray) and values.dtype.kind in "fiub":
        return values.astype(np.float64)
    if isinstance(values, str | dict) or not isinstance(values, Iterable):
        raise InputError(f"{name} must be a list of numbers, got {shortened(values)}", column=name)
    items = list(cast("Iterable[Any]", values))
    floats = np.empty(len(items))
    for row, value in enumerate(items):
        try:
            floats[row] = np.nan if value is None else float(value)
        except (TypeError, ValueError, OverflowError) as error:
            message = f"{name} must be a number, got {shortened(value)} (row {row})"
            raise InputError(message, row=row, rows=[row], column=name) from error
    return floats


def require(is_valid: Mask, name: str, rule: str, values: Floats | None = None) -> None:
    """Raise an `InputError` with the invalid rows of column ``name`` and the first bad value."""
    if np.all(is_valid):
        return
    bad_rows = np.flatnonzero(~is_valid).tolist()
    row_list = ", ".join(map(str, bad_rows[:10])) + (" ..." if len(bad_rows) > 10 else "")
    first_value = "" if values is None else f"; got {values[bad_rows[0]]:g}"
    message = f"{name} {rule} (row{'s' if len(bad_rows) > 1 else ''} {row_list}){first_value}"
    raise InputError(message, row=bad_rows[0], rows=bad_rows, column=name)


def positive(values: ArrayLike, name: str) -> Floats:
    """Return values as floats; an `InputError` names rows that are not positive and finite."""
    column = as_column(values, name)
    require(np.isfinite(column) & (column > 0.0), name, "must be > 0 and finite", column)
    return column


def same_length(**columns: Sized) -> None:
    """Raise an `InputError` if columns have different lengths or no rows."""
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) != 1:
        sizes = ", ".join(f"{name} has {size}" for name, size in lengths.items())
        raise InputError(f"columns differ in length: {sizes}", row=min(lengths.values()))
    if not min(lengths.values()):
        raise InputError(f"no rows in {', '.join(lengths)}", row=0)
