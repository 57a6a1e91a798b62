"""The one way from a YAML file to checked values: what is wrong becomes a sentence per finding."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import yaml
from pydantic import Field, TypeAdapter, ValidationError
from pydantic_core import ArgsKwargs

from skewbridge.errors import InputError

#: Numbers that text is not taken for: "2e7", which YAML 1.1 reads as text, must not pass.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True)]

_UNKNOWN: Final = {"extra_forbidden", "unexpected_keyword_argument"}
_MISSING: Final = {"missing", "missing_keyword_only_argument", "missing_argument"}
_NO_KEYS: Final = {"dataclass_type", "model_type", "model_attributes_type", "dict_type"}


def read_yaml(path: Path) -> Any:
    """Return the plain content of a YAML file, None if it is empty.

    Raises:
        InputError: The file cannot be read or is no YAML.
    """
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}", file=str(path)) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not valid YAML: {error}", file=str(path)) from None


def read_mapping(path: Path) -> dict[str, Any]:
    """Return the keys and values of a YAML file, none if it is empty.

    Raises:
        InputError: The file cannot be read, is no YAML, or has no keys at the top.
    """
    raw = read_yaml(path)
    if raw is None:
        return {}
    if not isinstance(raw, dict):
        raise InputError(f"{path}: keys and values are needed at the top", file=str(path))
    return raw


def checked[T](kind: type[T], raw: Any, where: str | Path) -> T:
    """Return plain values as an instance of a pydantic model or dataclass.

    Args:
        kind: What they must be.
        raw: Values as YAML or a command line gives them.
        where: What the message says they are; a path is a file, and named in the details, too.

    Raises:
        InputError: One line per finding: key, limit, value given.
    """
    try:
        return TypeAdapter(kind).validate_python(raw)
    except ValidationError as error:
        lines = [explain(finding) for finding in _without_echoes(error.errors())]
        text = f"{where}: {lines[0]}"
        if len(lines) > 1:
            text = "\n  ".join([f"{where} has {len(lines)} errors:", *lines])
        details = {"file": str(where)} if isinstance(where, Path) else {}
        raise InputError(text, **details) from None


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping with another laid over it, key by key; lists and values replace."""
    out = dict(base)
    for key, value in over.items():
        below: Any = out.get(key)
        both = isinstance(below, Mapping) and isinstance(value, Mapping)
        out[key] = merged(below, value) if both else value
    return out


def explain(finding: Any) -> str:
    """Return one finding of pydantic in words: key, limit, value given."""
    where = ".".join(str(part) for part in finding["loc"])
    said, kind, given = _in_words(finding), finding["type"], finding["input"]
    if kind not in _UNKNOWN | _MISSING and not isinstance(given, Mapping | ArgsKwargs):
        said += f", got {given!r}".removesuffix(".0")
    if isinstance(given, str) and kind in {"float_type", "float_parsing", "int_type"}:
        said += " (it is text; a number with an exponent is written like 2.0e+7)"
    return f"{where}: {said}" if where else said


def _in_words(finding: Any) -> str:
    if finding["type"] in _UNKNOWN:
        return "unknown key"
    if finding["type"] in _MISSING:
        return "is missing"
    if finding["type"] in _NO_KEYS:
        return "keys and values are needed"
    message = finding["msg"].removeprefix("Value error, ").replace("valid tuple", "list")
    return re.sub(r"^(Input|Tuple|List) should", "must", message).replace(" after validation", "")


def _without_echoes(findings: Sequence[Any]) -> list[Any]:
    """Leave out that a list is too short where its items are already found to be wrong."""
    places = [finding["loc"] for finding in findings]
    return [
        finding
        for finding in findings
        if finding["type"] != "too_short"
        or not any(len(p) > len(at := finding["loc"]) and p[: len(at)] == at for p in places)
    ]
