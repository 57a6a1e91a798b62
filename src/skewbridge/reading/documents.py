"""YAML and JSON as plain values, within limits that no file of ours comes near.

A file of a few lines can name a tree of 10^9 values (aliases of aliases), a number of a million
digits or a thousand levels: each is refused before it is built.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar, Final

import yaml

from skewbridge.errors import InputError
from skewbridge.reading.files import read_text, shortened, shown_path

MAX_BYTES: Final = 200_000  # the largest file of ours has 12 000
MAX_JSON_BYTES: Final = 16_000_000
MAX_DEPTH: Final = 30
MAX_NODES: Final = 20_000
MAX_DIGITS: Final = 30  # of an integer: 64 bits need 19
MAX_NUMBER_TEXT: Final = 100  # of any number
_TEXT_ALL_THE_SAME: Final = {"timestamp", "value", "yaml"}


class _Loader(yaml.SafeLoader):
    """Plain values only; a date is text."""

    yaml_implicit_resolvers: ClassVar[Any] = {
        first: [kind for kind in kinds if kind[0].rpartition(":")[2] not in _TEXT_ALL_THE_SAME]
        for first, kinds in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }


class _Tally:
    """Values and levels of a document as its aliases spread it, counted while it is read."""

    def __init__(self) -> None:
        self._nodes = 0
        self._open: list[tuple[str | None, int]] = []  # anchor, nodes before it
        self._heights: list[int] = [0]  # levels below each open collection
        self._anchors: dict[str, tuple[int, int]] = {}

    def take(self, event: Any) -> None:
        """Count one event of the parser.

        Raises:
            ValueError: Too many values or levels, a tag, an alias inside what it names.
        """
        if isinstance(event, yaml.CollectionEndEvent):
            anchor, before = self._open.pop()
            height = self._heights.pop() + 1
            self._add(anchor, self._nodes - before, height)
        elif isinstance(event, yaml.CollectionStartEvent):
            self._refuse_tag(event)
            self._open.append((event.anchor, self._nodes))
            self._heights.append(0)
            self._grow(1, 0)
        elif isinstance(event, yaml.ScalarEvent):
            self._refuse_tag(event)
            self._grow(1, 0)
            self._add(event.anchor, 1, 0)
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._anchors:
                raise ValueError(f"*{event.anchor} names nothing before it, or what it stands in")
            nodes, height = self._anchors[event.anchor]
            self._grow(nodes, height)
            self._add(None, nodes, height)

    def _grow(self, nodes: int, height: int) -> None:
        self._nodes += nodes
        if self._nodes > MAX_NODES:
            raise ValueError(f"more than {MAX_NODES} values, aliases counted as what they name")
        if len(self._open) + height > MAX_DEPTH:
            raise ValueError(f"nested more than {MAX_DEPTH} levels deep")

    def _add(self, anchor: str | None, nodes: int, height: int) -> None:
        self._heights[-1] = max(self._heights[-1], height)
        if anchor is not None:
            self._anchors[anchor] = (nodes, height)

    def _refuse_tag(self, event: Any) -> None:
        if event.tag is not None:
            raise ValueError(f"tags such as {shortened(event.tag)} are not taken")


def parse_yaml(text: str, where: str, **details: object) -> Any:
    """Return the plain value of a YAML text, None if it is empty.

    Args:
        text: The text.
        where: What the message says it is.
        details: Particulars of the error.

    Raises:
        InputError: No YAML, a key that stands twice or is no text, or more than the limits of
            this module allow; names the line.
    """
    line = 0
    try:
        tally = _Tally()
        for event in yaml.parse(text, Loader=_Loader):
            line = event.start_mark.line + 1 if event.start_mark else line
            tally.take(event)
        loader = _Loader(text)
        node = loader.get_single_node()
        for found in _nodes_of(node):
            line = found.start_mark.line + 1
            _refuse_node(found)
        return None if node is None else loader.construct_document(node)
    except yaml.YAMLError as error:
        raise InputError(f"{where} is not valid YAML: {_on_one_line(error)}", **details) from None
    except (ValueError, OverflowError) as error:
        raise InputError(f"{where}, line {line}: {error}", **details, line=line) from None


def read_yaml(path: Path) -> Any:
    """Return the plain content of a YAML file, None if it is empty.

    Raises:
        InputError: The file cannot be read, is too large, or as `parse_yaml`.
    """
    return parse_yaml(read_text(path, MAX_BYTES), shown_path(path), file=str(path))


def read_mapping(path: Path) -> dict[str, Any]:
    """Return the keys and values of a YAML file, none if it is empty.

    Raises:
        InputError: As `read_yaml`, or the file has no keys at the top.
    """
    raw = read_yaml(path)
    if raw is None:
        return {}
    if not isinstance(raw, dict):
        shown = shown_path(path)
        raise InputError(f"{shown}: keys and values are needed at the top", file=str(path))
    return raw


def read_json(path: Path) -> Any:
    """Return the content of a JSON file.

    Raises:
        InputError: The file cannot be read, is too large, no JSON, too deep, or has a key twice.
    """
    text, shown = read_text(path, MAX_JSON_BYTES), shown_path(path)
    try:
        return json.loads(text, object_pairs_hook=_distinct, parse_int=_whole)
    except json.JSONDecodeError as error:
        told = f"{error.msg} in line {error.lineno}, column {error.colno}"
        raise InputError(f"{shown} is not valid JSON: {told}", file=str(path)) from None
    except RecursionError:
        raise InputError(f"{shown}: nested too deeply", file=str(path)) from None
    except ValueError as error:
        raise InputError(f"{shown}: {error}", file=str(path)) from None


def _nodes_of(top: Any) -> Iterator[Any]:
    """Yield every node of a document once."""
    waiting, seen = [] if top is None else [top], set[int]()
    while waiting:
        node = waiting.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        yield node
        if isinstance(node, yaml.SequenceNode):
            waiting.extend(node.value)
        elif isinstance(node, yaml.MappingNode):
            waiting.extend(part for pair in node.value for part in pair)


def _refuse_node(node: Any) -> None:
    """Refuse a key that is no text or stands twice, and a number of more digits than any has."""
    kind = node.tag.rpartition(":")[2]
    if isinstance(node, yaml.ScalarNode) and kind in ("int", "float"):
        _refuse_digits(node.value, whole=kind == "int")
    if not isinstance(node, yaml.MappingNode):
        return
    first: dict[str, int] = {}
    for key, _ in node.value:
        key_kind = key.tag.rpartition(":")[2]
        if key_kind == "merge":
            continue
        if key_kind != "str":
            told = shortened(key.value) if isinstance(key, yaml.ScalarNode) else "a list or mapping"
            raise ValueError(f"a key must be text, got {told}: put it in quotation marks")
        if key.value in first:
            raise ValueError(
                f"the key {shortened(key.value)} stands twice, "
                f"in the lines {first[key.value]} and {key.start_mark.line + 1}"
            )
        first[key.value] = key.start_mark.line + 1


def _refuse_digits(text: str, *, whole: bool) -> None:
    digits = sum(sign.isalnum() for sign in text)
    if len(text) > MAX_NUMBER_TEXT or (whole and digits > MAX_DIGITS):
        limit = f"{MAX_DIGITS} digits" if whole else f"{MAX_NUMBER_TEXT} characters"
        raise ValueError(f"a number of {digits} digits, at most {limit} are taken")


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the key {shortened(twice)} stands twice")
    return found


def _whole(text: str) -> int:
    _refuse_digits(text, whole=True)
    return int(text)


def _on_one_line(error: yaml.YAMLError) -> str:
    """Return what a parser found and where, without the excerpt of the text."""
    mark = getattr(error, "problem_mark", None)
    problem = getattr(error, "problem", None) or " ".join(str(error).split())
    shown = "".join(sign if sign.isprintable() else "?" for sign in problem)[:200]
    return shown if mark is None else f"{shown} in line {mark.line + 1}, column {mark.column + 1}"
