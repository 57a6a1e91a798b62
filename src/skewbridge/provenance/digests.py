"""Digests of sources and of analyses: what must be computed again, and what need not."""

import ast
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

PACKAGE: Final = Path(__file__).parents[1]

#: What the result of an analysis depends on. The order of the rooms forbids anything later.
ENGINE_ROOMS: Final = ("units", "contact", "bridge", "analysis")


@cache
def source_digest(*rooms: str) -> str:
    """Return 12 hex digits over the meaning of the sources of the named modules or subpackages.

    Python files count as syntax trees without docstrings and comments, so that prose can be
    edited without a rerun; data files (CSV, JSON) count as bytes. The catalogue of bridges does
    not count: each analysis depends on its own bridge only.

    Raises:
        FileNotFoundError: A room has no source.
    """
    digest = hashlib.sha256()
    for room in sorted(rooms):
        folder = PACKAGE / room
        files = sorted(folder.rglob("*")) if folder.is_dir() else [PACKAGE / f"{room}.py"]
        for path in files:
            if path.suffix in {".py", ".csv", ".json"}:
                digest.update(path.relative_to(PACKAGE).as_posix().encode())
                digest.update(_meaning(path))
    return digest.hexdigest()[:12]


def digest_of(*parts: object) -> str:
    """Return 16 hex digits over the `repr` of plain values (numbers, text, tuples of them)."""
    return hashlib.sha256("\n".join(repr(part) for part in parts).encode()).hexdigest()[:16]


def canonical(value: Any) -> Any:
    """Return mappings and sequences as sorted, nested tuples, fit for `digest_of`."""
    if isinstance(value, Mapping):
        return tuple((str(key), canonical(value[key])) for key in sorted(value))
    if isinstance(value, Sequence) and not isinstance(value, str):
        return tuple(canonical(item) for item in value)
    return value


def _meaning(path: Path) -> bytes:
    if path.suffix != ".py":
        return path.read_bytes()
    tree = ast.parse(path.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                node.body = node.body[1:] or [ast.Pass()]
    return ast.dump(tree).encode()
