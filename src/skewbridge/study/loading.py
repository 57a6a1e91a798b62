"""Reading the configuration: YAML in, typed sections out, findings in words."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ValidationError

from skewbridge.errors import InputError
from skewbridge.study.config import StudyConfig


def parse_config(raw: Mapping[str, Any]) -> StudyConfig:
    """Return the validated configuration.

    Args:
        raw: The mapping as Snakemake or YAML gives it.

    Raises:
        InputError: A key is unknown or a value is outside its limits; every finding is one line
            with the key, the limit and the value given.
    """
    try:
        return StudyConfig.model_validate(dict(raw))
    except ValidationError as error:
        lines = [_explain(finding) for finding in error.errors()]
        raise InputError(
            "the configuration has {} error{}:\n  {}".format(
                len(lines), "s" if len(lines) > 1 else "", "\n  ".join(lines)
            )
        ) from None


def load_config(path: Path, base: Path | None = None) -> StudyConfig:
    """Read a configuration file, merged over a base file as Snakemake merges ``--configfile``.

    Raises:
        InputError: The file is missing, no YAML mapping, or invalid.
    """
    raw = _read_yaml(base) if base is not None and base != path else {}
    return parse_config(_merged(raw, _read_yaml(path)))


def key_table() -> list[dict[str, str]]:
    """Return one row per configuration key: key, default, meaning."""
    rows: list[dict[str, str]] = []
    for section, info in StudyConfig.model_fields.items():
        model = info.annotation
        if isinstance(model, type) and issubclass(model, BaseModel):
            for name, field in model.model_fields.items():
                default = yaml.safe_dump(field.default, default_flow_style=True).split("\n")[0]
                rows.append(
                    {
                        "key": f"{section}.{name}",
                        "default": default,
                        "meaning": field.description or "",
                    }
                )
    return rows


def _explain(finding: Any) -> str:
    where = ".".join(str(part) for part in finding["loc"])
    given = finding["input"]
    if finding["type"] == "extra_forbidden":
        return f"{where}: unknown key"
    message = finding["msg"].removeprefix("Value error, ")
    hint = ""
    if isinstance(given, str) and finding["type"].endswith(("_type", "_parsing")):
        hint = " (it is text; a number with an exponent is written like 2.0e+7)"
    return f"{where}: {message}, got {given!r}{hint}"


def _read_yaml(path: Path) -> dict[str, Any]:
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read the configuration {str(path)!r}: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise InputError(f"{path}: not valid YAML: {error}") from None
    if raw is None:
        return {}
    if not isinstance(raw, dict):
        raise InputError(f"{path}: expected keys and values, got {type(raw).__name__}")
    return raw


def _merged(base: dict[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    out = dict(base)
    for key, value in over.items():
        old = out.get(key)
        out[key] = (
            _merged(old, value) if isinstance(old, dict) and isinstance(value, Mapping) else value
        )
    return out
