"""Catalogue of bridges: format of their files, inheritance, validation and JSON schema.

A number is written with its source as ``{v: 5.64, src: "a: paper, section 5"}``. The source
classes are a (the paper), b (a document at hand), c (a named report from memory), d (engineering
rule) and calc (computed from other numbers); without one it is b. A list of numbers is one such
mapping with a list as ``v``. ``extends: NAME`` starts from another bridge: mappings are merged,
other values are replaced.
``abutments`` has the data of each end, with its ``type``; in a file that extends another, an end of
another type starts anew. An integral end gets the numbers of ``defaults/integral.yaml``.
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
PILE_SPACING_M: Final = 2.4  # ASSUME a pile of an integral end per 8 ft, as under usual girders
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
    merged = reduce(_overlay, reversed(_by_end(_with_parents(path))))
    if merged.get("base") == "fixed" and "foundation" not in merged:
        # ASSUME a fixed base without springs of its own has the footing of a similar column: rigid
        # ground is too stiff
        typical = read_mapping(FOLDER / f"{TYPICAL_FOUNDATION}.yaml")
        merged["foundation"] = typical["foundation"]
    ends, deck = merged.get("abutments"), merged.get("deck")
    if isinstance(ends, dict) and isinstance(deck, dict):
        for name, end in ends.items():
            if isinstance(end, dict) and end.get("type") == "integral":
                ends[name] = _integral(end, deck)
    plain = _strip(merged, "", sources, path)
    raw = {**plain, "name": path.stem, "sources": sources}
    return checked(BridgeData, raw, Path(path.name))


def _by_end(layers: list[tuple[Path, dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the trees; if one has ``abutments``, ``abutment`` of the others becomes both ends."""
    trees = [tree for _, tree in layers]
    if any("abutments" in tree for tree in trees):
        for path, tree in layers:
            if {"abutment", "abutments"} <= tree.keys():
                message = f"{path.name}: abutment and abutments: give only one of them"
                raise InputError(message, file=path.name)
            if "abutment" in tree:
                both = {"type": "seat"} | tree.pop("abutment")
                tree["abutments"] = {"left": both, "right": both}
    return trees


def _integral(given: dict[str, Any], deck: dict[str, Any]) -> dict[str, Any]:
    """Return an integral end with the numbers that it does not give, for the deck of its file."""
    end = read_mapping(FOLDER / "defaults" / "integral.yaml")
    sizes = {"width": "width_m", "height": "depth_m", "thickness": "diaphragm_thickness_m"}
    for size, key in sizes.items():
        if key in deck:
            end[f"wall_{size}_m"] = deck[key] | {"src": f"calc: deck.{key}"}
    width_m = deck.get("width_m", {}).get("v")
    if isinstance(width_m, int | float):
        rule = {"v": max(2, round(width_m / PILE_SPACING_M)), "src": "d: about 8 ft apart"}
        number = (given.get("piles") or {}).get("count", rule)
        end["piles"]["count"] = number
        end["piles"]["spacing_m"] = {
            "v": round(width_m / max(2, int(number["v"])), 4), "src": "calc: deck.width_m / count"
        }  # fmt: skip
    return _overlay(end, given)


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
        merged[key] = value
        if isinstance(value, dict) and "v" not in value and isinstance(below, dict):
            usual = below.get("type", "seat")
            if value.get("type", usual) == usual:  # a part of another type has other keys
                merged[key] = _overlay(below, value)
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
