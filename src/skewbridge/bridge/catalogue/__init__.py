"""Catalogue of bridges: format of their files, inheritance, validation and JSON schema.

A number is written with its source as ``{v: 5.64, src: "a: paper, section 5"}``, or alone if the
file has a ``source`` for all its numbers. It may be text with a unit: ``150 ft``. The source
classes are a (the paper), b (a document at hand), c (a named report from memory), d (engineering
rule) and calc (computed from other numbers); without one it is b. A list of numbers is one such
mapping with a list as ``v``. ``extends: NAME`` starts from another bridge: mappings are merged,
other values are replaced. Rules give what is missing (`skewbridge.bridge.catalogue.drawing`).
``abutments`` has the data of each end, with its ``type``; in a file that extends another, an end
with a different type inherits nothing.
A fixed base without ``foundation`` gets the springs of bridge_a, and ``foundation: null`` is rigid
ground.

The file of a bridge is looked up by name in ``config/bridges/`` of the working folder, then in the
catalogue of the package. A path that ends in ``.yaml`` can name any other file.
"""

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from skewbridge.bridge.catalogue.columns import over_default
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.catalogue.drawing import (
    DRAWN,
    RULES,
    Completed,
    completed,
    overruled,
    value_at,
)
from skewbridge.errors import InputError, did_you_mean
from skewbridge.files.text import read_mapping, shortened, shown_path
from skewbridge.units import quantity, unit_in_name

__all__ = [
    "BridgeData", "bridge_names", "bridge_schema", "load_bridge", "own_bridge_files",
    "read_bridge",
]  # fmt: skip

FOLDER: Final = Path(__file__).resolve().parent
#: Bridges of the user, next to the configuration.
OWN_FOLDER: Final = Path("config/bridges")
#: Pattern of the name of a bridge; its file in these folders has the same name.
NAME_PATTERN: Final = r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}"
MAX_PARENTS: Final = 10
# without a class; not a class without a text, nor another letter in its place
_UNCLASSED: Final = r"(?!(\w|calc)\s*(:|$))\S.*"
SOURCE_PATTERN: Final = rf"((a|b|c|d|calc): \S.*|{_UNCLASSED})"
SOURCE_LETTERS: Final = (
    "a (the paper), b (a document at hand), c (a named report from memory), d (an engineering "
    "rule) or calc (computed from the other numbers), or a text of class b without a letter"
)


def bridge_names() -> tuple[str, ...]:
    """Return the names of the bridges in the catalogue."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def load_bridge(name: str | Path) -> BridgeData:
    """Return a bridge from its name or file, cached until an edit.

    An `InputError` names file, key and limit.
    """
    return read_bridge(name).bridge


def _file(name: str | Path) -> Path:
    """Return the file of a bridge: the path itself, or the first file with its name."""
    if isinstance(name, Path) or name.endswith((".yaml", ".yml")):
        try:
            return Path(name).resolve()
        except (OSError, ValueError):
            raise InputError(f"{shown_path(Path(name))} is not a file name") from None
    path = _named(name, OWN_FOLDER)
    if name.endswith(".py"):
        raise InputError(f"{shortened(name)} is a script: a bridge file (.yaml) is needed")
    if path is None:
        user_names = sorted(path.stem for path in OWN_FOLDER.glob("*.yaml"))
        names = (*bridge_names(), *user_names)
        raise InputError(
            f"bridge must be one of {', '.join(names)}, got {shortened(name)}"
            f"{did_you_mean(name, names)}"
        )
    return path


def read_bridge(name: str | Path) -> Completed:
    """Return a bridge with the origin of its numbers (drawing, rule, parent); see `load_bridge`."""
    path = _file(name)
    return _loaded(path, _last_change_ns(path))


def _last_change_ns(path: Path) -> int:
    """Return the last change of files near a bridge of the user: an edit counts in a session."""
    if path.parent == FOLDER:
        return 0
    # parents are near it, too; reading them each time would cost more than the bridge
    files = (file for folder in (path.parent, OWN_FOLDER) for file in folder.glob("*.y*ml"))
    try:
        return max((file.stat().st_mtime_ns for file in files), default=0)
    except OSError:  # the reader of the file has the message
        return 0


@cache
def _loaded(path: Path, _change_ns: int) -> Completed:
    sources: dict[str, str] = {}
    files = _with_parents(path)
    bridge_tree, *_ = trees = _by_end(files)
    merged: dict[str, Any] = {}
    for tree in reversed(trees):
        for key in overruled(tree):
            parent_key, _, name = key.rpartition(".")
            if isinstance(section := value_at(merged, parent_key), dict):
                section.pop(name, None)
        merged = _overlay(merged, tree)
    plain = _strip(merged, "", sources, path)
    raw = {**plain, "name": path.stem, "sources": sources}
    inherited = frozenset(key for key in sources if value_at(bridge_tree, key) is None)
    return completed(raw, path)._replace(inherited=inherited)


def _by_end(layers: list[tuple[Path, dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the data of each file; if any has ``abutments``, an ``abutment`` becomes two ends."""
    trees = [tree for _, tree in layers]
    if any("abutments" in tree for tree in trees):
        for path, tree in layers:
            if {"abutment", "abutments"} <= tree.keys():
                message = f"{path.name}: give either abutment or abutments, not both"
                raise InputError(message, file=path.name)
            if "abutment" in tree:
                seat = {"type": "seat"} | tree.pop("abutment")
                tree["abutments"] = {"left": seat, "right": seat}
    return trees


def own_bridge_files(name: str) -> list[Path]:
    """Return the files of a bridge and its parents that are outside the package."""
    files = (path for path, _ in _with_parents(_file(name)))
    return [path for path in files if path.parent != FOLDER]


def _with_parents(path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Return path and content of the files of a bridge and all its parents, the bridge first."""
    layers: list[tuple[Path, dict[str, Any]]] = []
    while True:
        tree = read_mapping(path)
        parent = tree.pop("extends", None)
        if (source := tree.pop("source", None)) is not None:
            tree = _sourced(tree, "", source)
        layers.append((path, tree))
        if parent is None:
            return layers
        parent_path = _named(f"{parent}", path.parent, excluded=tuple(file for file, _ in layers))
        if parent_path is None:
            message = f"{path.name}: extends: no other bridge is named {shortened(parent)}"
            raise InputError(message, file=path.name)
        if len(layers) > MAX_PARENTS:
            raise InputError(f"{path.name}: more than {MAX_PARENTS} bridges are linked by extends")
        path = parent_path


def _named(name: str, folder: Path, excluded: tuple[Path, ...] = ()) -> Path | None:
    """Return the first file of a bridge in a folder, the user's or the package's, or None."""
    if not re.fullmatch(NAME_PATTERN, name):
        return None
    paths = (
        (root / f"{name}.yaml").resolve() for root in dict.fromkeys((folder, OWN_FOLDER, FOLDER))
    )
    return next((path for path in paths if path.is_file() and path not in excluded), None)


def _sourced(node: Any, name: str, source: Any) -> Any:
    """Return nested data in which numbers and quantities without a source get ``source``."""
    if isinstance(node, dict):
        has_src = "v" in node and "src" in node
        return node if has_src else {key: _sourced(v, key, source) for key, v in node.items()}
    items = node if isinstance(node, list) else [node]
    if items and all(_is_quantity(item, name) for item in items):
        return {"v": node, "src": source}
    return [_sourced(item, name, source) for item in node] if isinstance(node, list) else node


def _is_quantity(value: Any, name: str) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number or (isinstance(value, str) and unit_in_name(name) is not None)


def _overlay(base: Mapping[str, Any], top: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``base`` overridden by ``top``; a number and its source are replaced together."""
    merged = dict(base)
    for key, value in top.items():
        base_value = merged.get(key)
        merged[key] = value
        if not isinstance(value, dict) or "v" in value or not isinstance(base_value, dict):
            continue
        base_type = base_value.get("type", "seat")
        if key == "column":
            merged[key] = over_default(base_value, value)
        elif value.get("type", base_type) == base_type:  # a part of another type has other keys
            merged[key] = _overlay(base_value, value)
    return merged


def _strip(node: Any, where: str, sources: dict[str, str], path: Path) -> Any:
    """Return nested data with plain values; add the source of each number to ``sources``."""
    if isinstance(node, dict):
        if "v" in node:
            source = node.get("src", "")
            is_valid = isinstance(source, str) and re.fullmatch(SOURCE_PATTERN, source)
            if unknown := set(node) - {"v", "src"}:
                key = f"{where}.{min(unknown)}"
                raise InputError(f"{path.name}: {key}: unknown key; a number has only v and src")
            if not is_valid:
                raise InputError(
                    f"{path.name}: {where}: src must be 'LETTER: text', where LETTER is "
                    f"{SOURCE_LETTERS}; got {shortened(source)}",
                    file=path.name,
                )
            sources[where] = f"b: {source}" if re.fullmatch(_UNCLASSED, source) else source
            return _plain(node["v"], where, path)
        return {
            key: _strip(value, f"{where}.{key}".lstrip("."), sources, path)
            for key, value in node.items()
        }
    if isinstance(node, list):
        return [_strip(item, f"{where}.{i}", sources, path) for i, item in enumerate(node)]
    if isinstance(node, int | float) and not isinstance(node, bool):
        raise InputError(
            f"{path.name}: {where}: the number {node:g} has no source; give source: TEXT at the "
            f"top level for all numbers, or {{v: {node:g}, src: "
            f"'LETTER: text'}}, in the unit of the key, where LETTER is {SOURCE_LETTERS}",
            file=path.name,
        )
    return node


def _plain(value: Any, where: str, path: Path) -> Any:
    """Return a value in the unit of its key; a quantity is text such as ``150 ft``."""
    unit = unit_in_name(where)
    if isinstance(value, list):
        return [_plain(item, where, path) for item in value]
    if not isinstance(value, str) or unit is None:
        return value
    try:
        return quantity(value, unit)
    except ValueError as error:
        raise InputError(f"{path.name}: {where}: {error}, got {shortened(value)}") from None


def bridge_schema() -> dict[str, Any]:
    """Return the JSON schema of a bridge file; keys may be omitted only with ``extends``."""
    schema = BridgeData.model_json_schema()
    definitions: dict[str, Any] = schema["$defs"]
    for shape in (schema, *definitions.values()):
        for name, field in shape.get("properties", {}).items():
            options = [
                option for option in field.get("anyOf", [field]) if option.get("type") != "null"
            ]
            if _is_number(options[0], definitions):
                shape["properties"][name] = _in_file(options[0])
    by_rule = {rule.key.partition(".")[0] for rule in RULES} - {"deck", "abutment"}
    optional = {"name", "sources", "base", *by_rule}  # base and column: not without bents
    needed = [name for name in schema.pop("required") if name not in optional]
    for name, shape in definitions.items():
        shape.pop("required", None)
        definitions[name] = _in_file(shape) if _is_number(shape, definitions) else shape
    for name in ("name", "sources"):
        del schema["properties"][name]
    for key, limits in DRAWN.items():
        targets = [schema]
        *section_names, final_key = key.split(".")
        for name in section_names:
            empty_section = {"type": "object", "properties": {}, "additionalProperties": False}
            fields = [
                shape["items"]
                if name == "*"
                else shape["properties"].setdefault(name, empty_section)
                for shape in targets
            ]
            targets = [shape for field in fields for shape in _shapes(field, definitions)]
        is_text = isinstance(limits, str)
        value_range = {} if is_text else {"minimum": limits[0], "maximum": limits[1]}
        for shape in targets:
            field = {"type": "string"} if is_text else _in_file({"type": "number", **value_range})
            shape["properties"][final_key] = field
    texts = (
        ("extends", "bridge that this one starts from"),
        ("source", "source of all numbers without one"),
    )
    schema["properties"] |= {key: {"type": "string", "description": words} for key, words in texts}
    schema["anyOf"] = [{"required": ["extends"]}, {"required": needed}]
    return schema


def _shapes(field: dict[str, Any], definitions: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the schemas of a field's alternatives, for example one per shape of a column."""
    if "$ref" in field:
        return _shapes(definitions[field["$ref"].rsplit("/", 1)[1]], definitions)
    options = [option for option in field.get("anyOf", ()) if option.get("type") != "null"]
    return [shape for option in options for shape in _shapes(option, definitions)] or [field]


def _in_file(number: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of a number: alone, as text with a unit, or with its source."""
    if "$ref" in number:
        return number
    text_pattern = {} if number["type"] == "array" else {"pattern": r"^\d.*\D$"}
    types = [number["type"], *(["string"] if text_pattern else [])]
    return (
        number
        | text_pattern
        | {
            "type": [*types, "object"],
            "properties": {
                "v": number | text_pattern | {"type": types},
                "src": {"type": "string", "pattern": f"^{SOURCE_PATTERN}$"},
            },
            "required": ["v", "src"],
            "additionalProperties": False,
        }
    )


def _is_number(field: dict[str, Any], definitions: dict[str, Any]) -> bool:
    schema = definitions[field["$ref"].rsplit("/", 1)[1]] if "$ref" in field else field
    if schema.get("type") == "array":
        return _is_number(schema.get("items") or schema["prefixItems"][0], definitions)
    return schema.get("type") in {"number", "integer"}
