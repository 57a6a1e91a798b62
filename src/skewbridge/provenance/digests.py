"""Digests of sources, values and files: two that are equal stand for the same result."""

import ast
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from skewbridge.provenance.closure import PACKAGE, closure

#: Arguments that are only shown: a new label changes figures and pages, and no number.
SHOWN_ARGUMENTS: Final = frozenset({"label", "symbol", "description", "title"})


@cache
def source_digest(root: Path | str, *, package: Path = PACKAGE, shown: bool = False) -> str:
    """Return 16 hex digits over the meaning of everything that a script or module runs.

    Python files count as syntax trees without docstrings and comments, so that prose can be
    edited without a rerun; data files count as bytes.

    Args:
        root: A Python file, or the dotted name of a module of the package.
        package: Folder of the package.
        shown: Whether text that is only shown counts, for what draws figures or writes pages.

    Raises:
        FileNotFoundError: The root has no source.
    """
    digest = hashlib.sha256()
    for path in closure(root, package):
        inside = path.is_relative_to(package)
        name = path.relative_to(package).as_posix() if inside else path.name
        content = path.read_bytes()
        digest.update(name.encode())
        digest.update(_meaning(content, shown) if path.suffix == ".py" else content)
    return digest.hexdigest()[:16]


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


def opensees_version() -> str:
    """Return the version of the solver."""
    return version("openseespy")


@cache
def _meaning(source: bytes, shown: bool) -> bytes:
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                node.body = node.body[1:] or [ast.Pass()]
        elif isinstance(node, ast.Call) and not shown:
            node.keywords = [each for each in node.keywords if each.arg not in SHOWN_ARGUMENTS]
    return hashlib.sha256(ast.dump(tree).encode()).digest()
