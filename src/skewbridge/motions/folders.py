"""Files in a folder of motions: which of them look like motions, and none outside the folder."""

import re
from itertools import islice
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.reading import shortened, shown_path

MAX_FILES: Final = 50_000
# Anything else in a folder of motions (notes, tables) is left alone.
SUFFIXES: Final = (
    ".at2", ".v2", ".ew", ".ns", ".ew1", ".ns1", ".ew2", ".ns2", ".knet", ".acc", ".g3", ".th",
    ".thf", ".dat", ".txt", ".csv",
)  # fmt: skip
_ANY_TEXT: Final = (".txt", ".csv", ".dat")
_NUMBERS: Final = re.compile(rb"\s*[-+.\d][-+.,;\seEdD\d]*")
_NOT_MOTIONS: Final = frozenset({"index.csv", "manifest.csv", "expected.csv", "readme.txt"})
MAX_NAME: Final = 255


def motion_files(folder: Path) -> list[Path]:
    """Return the files of a folder and its sub-folders that look like motions, sorted by path.

    Velocities and displacements of a PEER download (`.VT2`, `.DT2`), its search results and text
    files that start with text are not motions.
    """
    return [
        path
        for path in files_below(folder)
        if path.suffix.lower() in SUFFIXES
        and path.name.lower() not in _NOT_MOTIONS
        and not any(part.startswith(("_", ".")) for part in path.relative_to(folder).parts)
        and (path.suffix.lower() not in _ANY_TEXT or _starts_with_numbers(path))
    ]


def is_folder(path: Path) -> bool:
    """Say whether there is such a folder, for any text as its name."""
    try:
        return path.is_dir()
    except OSError:
        return False


def files_below(folder: Path) -> list[Path]:
    """Return the files of a folder and its sub-folders, sorted by path.

    Raises:
        InputError: More than any folder of motions has, or a folder that cannot be read.
    """
    try:
        files = [path for path in islice(folder.rglob("*"), MAX_FILES + 1) if path.is_file()]
    except OSError as error:
        raise InputError(f"{shown_path(folder)}: {error.strerror}", folder=str(folder)) from None
    if len(files) > MAX_FILES:
        raise InputError(
            f"{shown_path(folder)} has more than {MAX_FILES} files: name the folder of the motions",
            folder=str(folder),
        )
    return sorted(files)


def _starts_with_numbers(path: Path) -> bool:
    """Say whether a line of nothing but numbers is among the first ten."""
    try:
        with path.open("rb") as stream:
            lines = stream.read(4096).splitlines()[:10]
    except OSError:
        return True  # the reader will say what is wrong
    return any(_NUMBERS.fullmatch(line) for line in lines)


def inside_folder(folder: Path, name: str, where: str) -> Path:
    """Return the path of a file named by an index, which must stay inside the index's folder.

    Raises:
        InputError: An absolute path, one that climbs out, a link that leads out, no such file.
    """
    name = name.strip()
    if not name or not name.isprintable() or len(name) > MAX_NAME:
        raise InputError(f"{where}: no file name: {shortened(name)}")
    relative = Path(name.replace("\\", "/"))
    drive = len(name) > 1 and name[1] == ":"
    if relative.is_absolute() or drive or ".." in relative.parts:
        raise InputError(f"{where}: {shortened(name)} is not inside the folder of the index")
    path = folder / relative
    if any(len(part.encode()) > MAX_NAME for part in relative.parts):
        raise InputError(f"{where}: {shortened(name)} is listed but missing", file=name)
    if not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{where}: {shortened(name)} leads out of the folder of the index")
    if not path.is_file():
        raise InputError(f"{where}: {shortened(name)} is listed but missing", file=name)
    return path
