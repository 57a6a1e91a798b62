"""Digests of sources, values and versions: equal digests mean equal results."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

#: Folder of the package.
PACKAGE: Final = Path(__file__).parents[1]
#: Sources that an analysis executes. The key of an analysis contains their digest, so that an edit
#: runs all analyses again. Readers of motions, scheduling and journals are not among them: the
#: accelerations themselves are part of the key.
ENGINE: Final = (
    "errors.py",
    "statuses.py",
    "units.py",
    "reading",
    "variant",
    "motions/record.py",
    "contact",
    "bridge",
    "analysis",
    "study/task.py",
)
#: Bridges are digested by their numbers (`analysis.keys.bridge_digest`), for studies that use them.
_CATALOGUE: Final = Path("bridge", "catalogue")


def layer_digest(parts: Sequence[str], package: Path = PACKAGE) -> str:
    """Return 16 hex digits over all sources and data files of some parts of the package.

    Args:
        parts: Packages or files, relative to the package.
        package: Folder of the package.

    Raises:
        FileNotFoundError: A part does not exist.
    """
    digest = hashlib.sha256()
    for part in parts:
        for path in _files(package / part):
            name = path.relative_to(package)
            if name.parent == _CATALOGUE and name.suffix == ".yaml":
                continue
            digest.update(f"\n{name.as_posix()}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def engine_digest() -> str:
    """Return the digest of the sources that an analysis executes."""
    return layer_digest(ENGINE)


def _files(part: Path) -> Iterable[Path]:
    if part.is_file():
        return [part]
    if not part.is_dir():
        raise FileNotFoundError(f"{part} is not a part of the package")
    return sorted(
        path
        for path in part.rglob("*")
        if path.is_file()
        and path.suffix != ".pyc"
        and not path.name.endswith("~")
        and not any(name.startswith(".") for name in path.relative_to(part).parts)
    )


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
