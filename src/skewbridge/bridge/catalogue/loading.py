"""Reading a bridge file: sources beside numbers, inheritance, validation.

A number is written with its source as ``{v: 5.64, src: "a: paper, section 5"}``; the classes are
a (the paper), b (found text), c (recollection of a named report), d (engineering rule), calc
(computed from the others). A list of numbers takes one such mapping with a list as ``v``.
``extends: NAME`` starts from another file of the same folder; mappings merge, the rest replaces.
"""

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

import yaml
from pydantic import ValidationError

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.errors import InputError

FOLDER: Final = Path(__file__).parent
_SOURCE = re.compile(r"(a|b|c|d|calc): \S.*")


def bridge_names() -> tuple[str, ...]:
    """Return the names of the catalogue."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


@cache
def load_bridge(name: str) -> BridgeData:
    """Return a bridge of the catalogue, or of a YAML file if `name` is a path.

    Raises:
        InputError: Unknown name, or a bad file; names file, key and limit.
    """
    if name.endswith((".yaml", ".yml")):
        return load_bridge_file(Path(name))
    if name not in bridge_names():
        raise InputError(f"bridge must be one of {', '.join(bridge_names())}, got {name!r}")
    return load_bridge_file(FOLDER / f"{name}.yaml")


def load_bridge_file(path: Path) -> BridgeData:
    """Return the bridge in a file.

    Raises:
        InputError: The file is missing, not YAML, or breaks a limit; names file, key and limit.
    """
    sources: dict[str, str] = {}
    plain = _strip(_merged(path), "", sources, path)
    try:
        return BridgeData.model_validate({**plain, "name": path.stem, "sources": sources})
    except ValidationError as error:
        lines = [
            f"{path.name}: {'.'.join(str(part) for part in item['loc']) or 'file'}: {item['msg']}"
            + (f", got {item['input']!r}" if isinstance(item["input"], str | int | float) else "")
            for item in error.errors()
        ]
        raise InputError("; ".join(lines), file=path.name) from error


def _merged(path: Path) -> dict[str, Any]:
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise InputError(f"{path.name}: cannot be read as YAML: {error}", file=path.name) from error
    if not isinstance(tree, dict):
        raise InputError(f"{path.name}: a mapping is needed at the top", file=path.name)
    parent = tree.pop("extends", None)
    if parent is None:
        return tree
    beside = path.parent / f"{parent}.yaml"
    base = beside if beside.exists() else FOLDER / f"{parent}.yaml"
    if base == path or not base.exists():
        raise InputError(f"{path.name}: extends: no other bridge {parent!r}", file=path.name)
    return _overlay(_merged(base), tree)


def _overlay(base: Mapping[str, Any], top: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in top.items():
        below = merged.get(key)
        deeper = isinstance(value, dict) and "v" not in value and isinstance(below, dict)
        merged[key] = _overlay(below, value) if deeper and below is not None else value
    return merged


def _strip(node: Any, where: str, sources: dict[str, str], path: Path) -> Any:
    """Return the tree with plain values, and collect the sources by path."""
    if isinstance(node, dict):
        if "v" in node:
            source = node.get("src", "")
            if set(node) - {"v", "src"} or not _SOURCE.fullmatch(str(source)):
                raise InputError(
                    f"{path.name}: {where}: src must be '<a|b|c|d|calc>: text', got {source!r}",
                    file=path.name,
                )
            sources[where] = str(source)
            return node["v"]
        return {
            key: _strip(value, f"{where}.{key}".lstrip("."), sources, path)
            for key, value in node.items()
        }
    if isinstance(node, list):
        return [_strip(item, f"{where}.{i}", sources, path) for i, item in enumerate(node)]
    if isinstance(node, int | float) and not isinstance(node, bool):
        raise InputError(
            f"{path.name}: {where}: the number {node:g} has no source ({{v: .., src: ..}})",
            file=path.name,
        )
    return node
