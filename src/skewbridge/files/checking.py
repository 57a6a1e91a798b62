"""Checks of plain values against a pydantic class, with one sentence per finding."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError
from pydantic_core import ArgsKwargs

from skewbridge.errors import InputError, did_you_mean
from skewbridge.files.text import shortened, shown_path

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True)]


def _flag(value: Any) -> Any:
    return {"true": True, "false": False}.get(value, value) if isinstance(value, str) else value


#: True or false; as text too, because `snakemake --config` passes values within braces as text.
Flag = Annotated[bool, BeforeValidator(_flag), Field(strict=True)]
#: Path of a file or folder.
FileName = Annotated[str, Field(min_length=1, max_length=1000, pattern=r"^[^\x00-\x1f]+$")]

MOST_LINES: Final = 20  # findings of one message

_UNKNOWN: Final = {"extra_forbidden", "unexpected_keyword_argument"}
_MISSING: Final = {"missing", "missing_keyword_only_argument", "missing_argument"}
_NO_KEYS: Final = {"dataclass_type", "model_type", "model_attributes_type", "dict_type"}


def checked[T](kind: type[T], raw: Any, where: str | Path) -> T:
    """Return plain values as an instance of a pydantic model or dataclass.

    Raises:
        InputError: One line per finding: source `where`, key, limit, value given.
    """
    adapter = TypeAdapter(kind)
    try:
        return adapter.validate_python(raw)
    except ValidationError as error:
        findings = _without_echoes(error.errors())
        is_unknown = any(finding["type"] in _UNKNOWN for finding in findings)
        schema = adapter.json_schema() if is_unknown else {}
        keys = list(_keys(schema, schema.get("$defs", {})))
        lines = [_explain(finding, keys) for finding in findings]
        source = shown_path(where) if isinstance(where, Path) else where
        text = f"{source}: {lines[0]}"
        if len(lines) > 1:
            more = [f"... and {len(lines) - MOST_LINES} more"] if len(lines) > MOST_LINES else []
            listed = [f"{source} has {len(lines)} errors:", *lines[:MOST_LINES], *more]
            text = "\n  ".join(listed)
        details = {"file": str(where)} if isinstance(where, Path) else {}
        raise InputError(text, **details) from None


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping updated by another, level by level; lists and values are replaced."""
    out = dict(base)
    for key, value in over.items():
        below: Any = out.get(key)
        both = isinstance(below, Mapping) and isinstance(value, Mapping)
        out[key] = merged(below, value) if both else value
    return out


def _keys(schema: Mapping[str, Any], classes: Mapping[str, Any], above: str = "") -> Iterator[str]:
    """Yield all keys of a JSON schema, with the keys above them."""
    for branch in (schema, *schema.get("anyOf", ()), *schema.get("allOf", ())):
        name = branch.get("$ref", "").rsplit("/", 1)[-1]
        for key, inner in classes.get(name, branch).get("properties", {}).items():
            yield above + key
            yield from _keys(inner, classes, f"{above}{key}.")


def _explain(finding: Any, keys: Sequence[str]) -> str:
    """Return one finding of pydantic in words: key, limit, value given."""
    where = ".".join(
        str(part)
        if isinstance(part, int) or (part.isidentifier() and len(part) < 60)
        else shortened(part)
        for part in finding["loc"]
    )
    kind, given = finding["type"], finding["input"]
    if kind in _UNKNOWN:
        words = f"unknown key{did_you_mean(where, keys)}"
    elif kind in _MISSING:
        words = "is missing"
    elif kind in _NO_KEYS:
        words = "keys and values are needed"
    else:
        message = finding["msg"].removeprefix("Value error, ").replace("valid tuple", "list")
        words = re.sub(r"^(Input|Tuple|List|String) should", "must", message)
        words = words.replace(" after validation", "")
    if kind not in _UNKNOWN | _MISSING and not isinstance(given, Mapping | ArgsKwargs):
        words += f", got {shortened(given)}".removesuffix(".0")
    if isinstance(given, str) and kind in {"float_type", "float_parsing", "int_type"}:
        words += " (it is text; a number with an exponent is written like 2.0e+7; within"
        words += " braces `snakemake --config` passes text only: use a file and --configfile)"
    return f"{where}: {words}" if where else words


def _without_echoes(findings: Sequence[Any]) -> list[Any]:
    """Drop the finding that a list is too short if its items are already reported as wrong."""
    locations = [finding["loc"] for finding in findings]
    return [
        finding
        for finding in findings
        if finding["type"] != "too_short"
        or not any(len(p) > len(at := finding["loc"]) and p[: len(at)] == at for p in locations)
    ]
