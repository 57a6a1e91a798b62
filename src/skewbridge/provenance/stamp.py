"""Provenance of a result: written into its file, and read from it."""

import json
import re
from collections.abc import Mapping
from html import escape, unescape
from pathlib import Path
from typing import Final

import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.errors import InputError
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import encoded, texts_of, write_table

#: Key of a JSON object and identifier of an HTML element.
MARK: Final = "skewbridge-provenance"
_ELEMENT: Final = (f'<template id="{MARK}">', "</template>")
_SVG_DESCRIPTION: Final = re.compile(r"<dc:description>(.*?)</dc:description>", re.S)


def figure_metadata(metadata: Mapping[str, str]) -> dict[str, str]:
    """Return provenance as the argument ``metadata`` of matplotlib's ``savefig``, for PNG and SVG.

    Args:
        metadata: Texts by name.
    """
    return {"Description": json.dumps(dict(metadata))}


def stamp(path: Path, metadata: Mapping[str, str]) -> None:
    """Write provenance into a file: Parquet, a JSON object or HTML; other files are left unchanged.

    Figures have it from `figure_metadata` when they are saved.

    Args:
        path: The file.
        metadata: Texts by name; they replace those of the same name.
    """
    match path.suffix:
        case ".parquet":
            table = pq.read_table(path)
            found = {**(table.schema.metadata or {}), **encoded(metadata)}
            write_table(table.replace_schema_metadata(found), path)
        case ".json":
            content = json.loads(path.read_text(encoding="utf-8"))
            if isinstance(content, dict):
                content[MARK] = dict(metadata)
                write_text(path, json.dumps(content, indent=1))
        case ".html":
            write_text(path, _with_element(path, json.dumps(dict(metadata))))
        case _:
            pass


def read_stamp(path: Path) -> dict[str, str]:
    """Return the provenance in a file, by name.

    Raises:
        InputError: The file does not exist, or it has no provenance.
    """
    try:
        found = _read(path)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise InputError(f"cannot read {path}: {error}", file=str(path)) from None
    if not found:
        raise InputError(
            f"{path} has no provenance: skewbridge did not write it, or a version from before "
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
            from PIL import Image

            with Image.open(path) as image:
                return json.loads(image.info.get("Description", "{}"))
        case ".svg":
            described = _SVG_DESCRIPTION.search(path.read_text(encoding="utf-8"))
            return json.loads(unescape(described[1])) if described else {}
        case ".html":
            before, behind = _ELEMENT
            text = path.read_text(encoding="utf-8")
            inside = text.partition(before)[2].partition(behind)[0]
            return json.loads(unescape(inside)) if inside else {}
        case _:
            with path.open("rb"):  # a missing file is reported as such
                return {}


def _with_element(path: Path, provenance: str) -> str:
    """Return the text of a page with the element first in its head."""
    before, behind = _ELEMENT
    text = path.read_text(encoding="utf-8")
    text = re.sub(f"\n{re.escape(before)}.*?{re.escape(behind)}", "", text, count=1, flags=re.S)
    opening = re.search(r"<head\b[^>]*>", text)
    if opening is None:
        raise ValueError(f"{path} has no head")
    at = opening.end()
    return f"{text[:at]}\n{before}{escape(provenance)}{behind}{text[at:]}"
