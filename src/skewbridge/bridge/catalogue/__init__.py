"""Catalogue of bridges: format of their files, inheritance, validation and JSON schema.

A number is written with its source as ``{v: 5.64, src: "a: paper, section 5"}``. The source
classes are a (the paper), b (a document at hand), c (a named report from memory), d (engineering
rule) and calc (computed from other numbers); without one it is b. A list of numbers is one such
mapping with a list as ``v``. ``extends: NAME`` starts from another bridge: mappings are merged,
other values are replaced.
A fixed base without ``foundation`` gets the springs of `TYPICAL_FOUNDATION`, and ``foundation:
null`` is rigid ground.

The file of a bridge is looked up by name in ``config/bridges/`` of the working folder, then in the
catalogue of the package. A path that ends in ``.yaml`` can name any other file.
"""

import re
from collections.abc import Mapping
from functools import cache, reduce
from pathlib import Path
from typing import Any, Final

from skewbridge.bridge.catalogue.columns import over_default
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.errors import InputError, did_you_mean
from skewbridge.files.text import checked, read_mapping, shortened, shown_path

__all__ = [
    "BridgeData", "bridge_names", "bridge_schema", "load_bridge", "own_bridge_files",
]  # fmt: skip

FOLDER: Final = Path(__file__).parent
#: Bridges of the user, next to the configuration.
OWN_FOLDER: Final = Path("config/bridges")
#: Pattern of the name of a bridge; its file in these folders has the same name.
NAME_PATTERN: Final = r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}"
MAX_PARENTS: Final = 10
#: Bridge with the foundation springs of fixed bases whose file has none: one column of 1.68 m.
TYPICAL_FOUNDATION: Final = "bridge_a"
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
    """Return a bridge from its name or file (cached); an `InputError` names file, key and limit."""
    return _loaded(_file(name))


def _file(name: str | Path) -> Path:
    """Return the file of a bridge: the path itself, or the first file with its name."""
    if isinstance(name, Path) or name.endswith((".yaml", ".yml")):
        try:
            return Path(name).resolve()
        except (OSError, ValueError):
            raise InputError(f"{shown_path(Path(name))} is not a file name") from None
    found = _named(name, OWN_FOLDER)
    if name.endswith(".py"):
        raise InputError(f"{shortened(name)}: a script has no data of deck, columns and abutments")
    if found is None:
        own = sorted(path.stem for path in OWN_FOLDER.glob("*.yaml"))
        known = (*bridge_names(), *own)
        raise InputError(
            f"bridge must be one of {', '.join(known)}, got {shortened(name)}"
            f"{did_you_mean(name, known)}"
        )
    return found


@cache
def _loaded(path: Path) -> BridgeData:
    sources: dict[str, str] = {}
    trees = (tree for _, tree in reversed(_with_parents(path)))
    merged = reduce(_overlay, trees)
    if "foundation" not in merged and "fixed" in _bases(merged):
        # ASSUME a fixed base without springs of its own has the footing of a similar column: rigid
        # ground is too stiff
        typical = read_mapping(FOLDER / f"{TYPICAL_FOUNDATION}.yaml")
        merged["foundation"] = typical["foundation"]
    plain = _strip(merged, "", sources, path)
    raw = {**plain, "name": path.stem, "sources": sources}
    return checked(BridgeData, raw, Path(path.name))


def _bases(tree: Mapping[str, Any]) -> list[Any]:
    """Return the bases of a bridge and of its bents in the raw content of a file."""
    bents = tree.get("bents")
    parts = [tree, *(bents if isinstance(bents, list) else ())]
    return [part.get("base") for part in parts if isinstance(part, Mapping)]


def own_bridge_files(name: str) -> list[Path]:
    """Return the files of a bridge and its parents that are outside the package."""
    files = (path for path, _ in _with_parents(_file(name)))
    return [path for path in files if path.parent != FOLDER.resolve()]


def _with_parents(path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Return path and content of the files of a bridge and all its parents, the bridge first."""
    found: list[tuple[Path, dict[str, Any]]] = []
    while True:
        tree = read_mapping(path)
        parent = tree.pop("extends", None)
        found.append((path, tree))
        if parent is None:
            return found
        base = _named(f"{parent}", path.parent, without=tuple(seen for seen, _ in found))
        if base is None:
            message = f"{path.name}: extends: no other bridge is named {shortened(parent)}"
            raise InputError(message, file=path.name)
        if len(found) > MAX_PARENTS:
            raise InputError(f"{path.name}: extends: the chain has over {MAX_PARENTS} bridges")
        path = base


def _named(name: str, folder: Path, without: tuple[Path, ...] = ()) -> Path | None:
    """Return the file of a bridge: the first one in the given, user's and package's folders.

    Returns None if no folder has it, or if the name could be a path outside these folders.
    """
    if not re.fullmatch(NAME_PATTERN, name):
        return None
    paths = (
        (place / f"{name}.yaml").resolve() for place in dict.fromkeys((folder, OWN_FOLDER, FOLDER))
    )
    return next((path for path in paths if path.is_file() and path not in without), None)


def _overlay(base: Mapping[str, Any], top: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``base`` overridden by ``top``; a number and its source are replaced together."""
    merged = dict(base)
    for key, value in top.items():
        below = merged.get(key)
        if key == "column" and isinstance(value, dict) and isinstance(below, dict):
            merged[key] = over_default(below, value)
            continue
        deeper = isinstance(value, dict) and "v" not in value and isinstance(below, dict)
        merged[key] = _overlay(below, value) if deeper and below is not None else value
    return merged


def _strip(node: Any, where: str, sources: dict[str, str], path: Path) -> Any:
    """Return the tree with plain values; add the source of each number to ``sources``."""
    if isinstance(node, dict):
        if "v" in node:
            source = node.get("src", "")
            is_text = isinstance(source, str) and re.fullmatch(SOURCE_PATTERN, source)
            if unknown := set(node) - {"v", "src"}:
                key = f"{where}.{min(unknown)}"
                raise InputError(f"{path.name}: {key}: unknown key; a number has v and src")
            if not is_text:
                raise InputError(
                    f"{path.name}: {where}: src must be 'LETTER: text', where LETTER is "
                    f"{SOURCE_LETTERS}; got {shortened(source)}",
                    file=path.name,
                )
            sources[where] = f"b: {source}" if re.fullmatch(_UNCLASSED, source) else source
            return node["v"]
        return {
            key: _strip(value, f"{where}.{key}".lstrip("."), sources, path)
            for key, value in node.items()
        }
    if isinstance(node, list):
        return [_strip(item, f"{where}.{i}", sources, path) for i, item in enumerate(node)]
    if isinstance(node, int | float) and not isinstance(node, bool):
        raise InputError(
            f"{path.name}: {where}: the number {node:g} has no source; write {{v: {node:g}, src: "
            f"'LETTER: text'}}, in the unit of the key, where LETTER is {SOURCE_LETTERS}",
            file=path.name,
        )
    return node


def bridge_schema() -> dict[str, Any]:
    """Return the JSON schema of a bridge file; keys may be omitted only with ``extends``."""
    schema = BridgeData.model_json_schema()
    kinds: dict[str, Any] = schema["$defs"]
    for part in (schema, *kinds.values()):
        if "properties" in part:
            part["properties"] = {
                name: _with_source(field, kinds) for name, field in part["properties"].items()
            }
    needed = [name for name in schema.pop("required") if name not in {"name", "sources"}]
    for part in kinds.values():
        part.pop("required", None)
    for name in ("name", "sources"):
        del schema["properties"][name]
    schema["properties"]["extends"] = {
        "type": "string",
        "description": "name of the bridge that this one starts from",
    }
    schema["anyOf"] = [{"required": ["extends"]}, {"required": needed}]
    return schema


def _with_source(field: dict[str, Any], kinds: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a field in the file: a number becomes a value with its source."""
    known = [option for option in field.get("anyOf", [field]) if option.get("type") != "null"]
    if not _is_number(known[0], kinds):
        return field
    source = {"type": "string", "pattern": f"^{SOURCE_PATTERN}$"}
    return {
        "type": "object",
        "properties": {"v": known[0], "src": source},
        "required": ["v", "src"],
        "additionalProperties": False,
    }


def _is_number(field: dict[str, Any], kinds: dict[str, Any]) -> bool:
    kind = kinds[field["$ref"].rsplit("/", 1)[1]] if "$ref" in field else field
    if kind.get("type") == "array":
        return _is_number(kind.get("items") or kind["prefixItems"][0], kinds)
    return kind.get("type") in {"number", "integer"}
