"""What a study needs beside the package: Snakefile, rules, configuration, motions."""

import shutil
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.provenance.closure import PACKAGE

#: As in a clone. pyproject.toml puts the same files beside the installed package.
PARTS: Final = (
    "Snakefile",
    "workflow/rules",
    "workflow/scripts",
    "workflow/profiles",
    "config",
    "motions/README.md",
    "motions/index.csv",
    "motions/synthetic",
)
_LEFT_OUT: Final = shutil.ignore_patterns("__pycache__", ".*")


def starter_files(package: Path = PACKAGE) -> Path:
    """Return the folder of the files: beside an installed package, the root of a clone.

    Args:
        package: Folder of the package.

    Raises:
        InputError: They are in neither.
    """
    for folder in (package.parent / "skewbridge_starter", package.parents[1]):
        if all((folder / part).exists() for part in PARTS):
            return folder
    raise InputError(f"the files of a study are not beside {package}: install the package again")


def write_starter(folder: Path) -> list[Path]:
    """Write the files of a study into a folder, which is made where there is none.

    Args:
        folder: May hold other files.

    Returns:
        What was written: files and folders.

    Raises:
        InputError: Something that would be written is there already; nothing is written then.
    """
    source = starter_files()
    there = [part for part in PARTS if (folder / part).exists()]
    if there:
        raise InputError(f"{folder} has {', '.join(there)} already: nothing was written")
    for part in PARTS:
        place = folder / part
        place.parent.mkdir(parents=True, exist_ok=True)
        if (source / part).is_dir():
            shutil.copytree(source / part, place, ignore=_LEFT_OUT)
        else:
            shutil.copy2(source / part, place)
    return [folder / part for part in PARTS]
