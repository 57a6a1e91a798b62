"""Digests of sources, values and files: two that are equal stand for the same result."""

import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from skewbridge.provenance.closure import PACKAGE, closure
from skewbridge.provenance.syntax import SourceMemory

_READ: Final = SourceMemory()


@cache
def source_digest(
    root: Path | str,
    *,
    package: Path = PACKAGE,
    shown: bool = False,
    memory: SourceMemory = _READ,
) -> str:
    """Return 16 hex digits over the meaning of everything that a script or module runs.

    Python files count as syntax trees without docstrings and comments, so that prose can be
    edited without a rerun; data files count as bytes.

    Args:
        root: A Python file, or the dotted name of a module of the package.
        package: Folder of the package.
        shown: Whether text that is only shown counts, for what draws figures or writes pages.
        memory: Reads the sources.

    Raises:
        FileNotFoundError: The root has no source.
    """
    digest = hashlib.sha256()
    for path in closure(root, package, memory):
        inside = path.is_relative_to(package)
        name = path.relative_to(package).as_posix() if inside else path.name
        content = path.read_bytes()
        if path.suffix == ".py":
            said = memory.content(content, package.name)
            content = (said.meaning_shown if shown else said.meaning).encode()
        digest.update(name.encode())
        digest.update(content)
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


@cache
def opensees_version() -> str:
    """Return the version of the solver."""
    return version("openseespy")
