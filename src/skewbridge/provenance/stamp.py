"""Where a file comes from, written into the file itself and read from it again."""

import json
import re
import struct
import zlib
from collections.abc import Mapping
from html import escape, unescape
from pathlib import Path
from typing import Final

import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.errors import InputError
from skewbridge.provenance.files import written_aside
from skewbridge.provenance.tables import encoded, texts_of, write_table

#: Key of a JSON object, identifier of an SVG or HTML element, keyword of a PNG text.
MARK: Final = "skewbridge-provenance"
_PNG_START: Final = b"\x89PNG\r\n\x1a\n"
_PNG_LAST: Final = struct.pack(">I", 0) + b"IEND"
_ELEMENTS: Final = {
    ".svg": (f'<desc id="{MARK}">', "</desc>", r"<svg\b[^>]*>"),
    ".html": (f'<template id="{MARK}">', "</template>", r"<head\b[^>]*>"),
}


def stamp(path: Path, metadata: Mapping[str, str]) -> None:
    """Write into a file, or into all files of a folder, where it comes from.

    Parquet, JSON objects, PNG, SVG and HTML take it; other files are left as they are.

    Args:
        path: The file or folder.
        metadata: Texts by name; they replace those of the same name.
    """
    if path.is_dir():
        for file in sorted(path.iterdir()):
            stamp(file, metadata)
        return
    match path.suffix:
        case ".parquet":
            table = pq.read_table(path)
            found = {**(table.schema.metadata or {}), **encoded(metadata)}
            write_table(table.replace_schema_metadata(found), path)
        case ".json":
            content = json.loads(path.read_text(encoding="utf-8"))
            if isinstance(content, dict):
                content[MARK] = dict(metadata)
                _replace(path, json.dumps(content, indent=1).encode())
        case ".png":
            _replace(path, _png_with(path.read_bytes(), json.dumps(dict(metadata)).encode()))
        case ".svg" | ".html":
            _replace(path, _marked(path, json.dumps(dict(metadata))).encode())
        case _:
            pass


def read_stamp(path: Path) -> dict[str, str]:
    """Return what a file tells of where it comes from, by name.

    Raises:
        InputError: No such file, or one that tells nothing.
    """
    try:
        found = _read(path)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise InputError(f"cannot read {path}: {error}", file=str(path)) from None
    if not found:
        raise InputError(
            f"{path} does not say where it comes from: no skewbridge wrote it, or one before "
            "results were marked",
            file=str(path),
        )
    return found


def _read(path: Path) -> dict[str, str]:
    match path.suffix:
        case ".parquet":
            return texts_of(pq.read_schema(path))
        case ".json":
            content = json.loads(path.read_text(encoding="utf-8"))
            return content.get(MARK, {}) if isinstance(content, dict) else {}
        case ".png":
            content = path.read_bytes()
            at = content.find(b"tEXt" + MARK.encode() + b"\0")
            if at < 0:
                return {}
            (length,) = struct.unpack(">I", content[at - 4 : at])
            return json.loads(content[at + 4 + len(MARK) + 1 : at + 4 + length])
        case ".svg" | ".html" as kind:
            before, behind, _ = _ELEMENTS[kind]
            text = path.read_text(encoding="utf-8")
            inside = text.partition(before)[2].partition(behind)[0]
            return json.loads(unescape(inside)) if inside else {}
        case _:
            with path.open("rb"):  # a file that is not there is told first
                return {}


def _replace(path: Path, content: bytes) -> None:
    with written_aside(path) as part:
        part.write_bytes(content)


def _marked(path: Path, said: str) -> str:
    """Return an SVG or HTML text with the element first in its root or head."""
    before, behind, root = _ELEMENTS[path.suffix]
    text = path.read_text(encoding="utf-8")
    text = re.sub(f"\n{re.escape(before)}.*?{re.escape(behind)}", "", text, count=1, flags=re.S)
    opening = re.search(root, text)
    if opening is None:
        raise ValueError(f"{path} has no {root}")
    at = opening.end()
    return f"{text[:at]}\n{before}{escape(said)}{behind}{text[at:]}"


def _png_with(content: bytes, said: bytes) -> bytes:
    """Return a PNG with one text chunk of ours before its last chunk."""
    # source: PNG specification (third edition), 11.3.3.2 tEXt, 5.3 chunk layout
    if not content.startswith(_PNG_START):
        raise ValueError("no PNG")
    keyword = b"tEXt" + MARK.encode() + b"\0"
    if (old := content.find(keyword)) >= 0:
        (length,) = struct.unpack(">I", content[old - 4 : old])
        content = content[: old - 4] + content[old + 4 + length + 4 :]
    data = keyword + said
    chunk = struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    at = content.rindex(_PNG_LAST)
    return content[:at] + chunk + content[at:]
