"""The one way from a YAML file to checked values: what is wrong becomes a sentence per finding."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import TypeAdapter, ValidationError

from skewbridge.errors import InputError


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


def checked[T](kind: type[T], raw: Any, where: str) -> T:
    """Return plain values as an instance of a pydantic model or dataclass.

    Args:
        kind: What they must be.
        raw: Values as YAML or a command line gives them.
        where: What the message says they are, for example a file name.

    Raises:
        InputError: One line per finding: key, limit, value given.
    """
    try:
        return TypeAdapter(kind).validate_python(raw)
    except ValidationError as error:
        lines = [explain(finding) for finding in error.errors()]
        if len(lines) == 1:
            raise InputError(f"{where}: {lines[0]}") from None
        raise InputError("\n  ".join([f"{where} has {len(lines)} errors:", *lines])) from None


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
    where = ".".join(str(part) for part in finding["loc"]) or "top level"
    if finding["type"] in {"extra_forbidden", "unexpected_keyword_argument"}:
        return f"{where}: unknown key"
    if finding["type"] in {"missing", "missing_keyword_only_argument", "missing_argument"}:
        return f"{where}: is missing"
    message, given = finding["msg"].removeprefix("Value error, "), finding["input"]
    if isinstance(given, dict):
        return f"{where}: {message}"
    hint = ""
    if isinstance(given, str) and finding["type"].endswith(("_type", "_parsing")):
        hint = " (it is text; a number with an exponent is written like 2.0e+7)"
    return f"{where}: {message}, got {given!r}{hint}"
