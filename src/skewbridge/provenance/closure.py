"""The modules and data files that a script or a module runs: found by following its imports."""

from functools import cache
from pathlib import Path
from typing import Final

from skewbridge.provenance.syntax import SourceMemory

PACKAGE: Final = Path(__file__).parents[1]
#: The bridges stay outside: each is digested by its numbers, for the studies that use it.
APART: Final = Path("bridge", "catalogue")
_NO_DATA: Final = frozenset({".py", ".pyc"})


def closure(
    root: Path | str, package: Path = PACKAGE, memory: SourceMemory | None = None
) -> tuple[Path, ...]:
    """Return the files that the result of a script or module depends on, sorted.

    These are its own file, every module of the package that it imports (at the top or inside a
    function, directly or through others, with the `__init__` of every package on the way), and
    their data. Imports for the type checker alone do not count. A text that is the dotted name of
    a module counts as an import, and that of a package as one of all its modules, because such
    names are imported at run time. A data file (a template, a table) belongs to every module of
    the package folder that it lies in, or whose folder without modules holds it.

    Args:
        root: A Python file, or the dotted name of a module of the package.
        package: Folder of the package.
        memory: Reads the sources.

    Raises:
        FileNotFoundError: The root has no source.
        ValueError: A module uses a relative import.
    """
    memory = memory or SourceMemory()
    if isinstance(root, str):
        queue = [*_files_named(root, package)]
        wanted = package.joinpath(*root.split(".")[1:])
        if queue[-1] not in {wanted.with_suffix(".py"), wanted / "__init__.py"}:
            raise FileNotFoundError(f"{root} is no module of {package}")
    else:
        queue = [root]
    modules: set[Path] = set()
    while queue:
        path = queue.pop()
        if path not in modules:
            modules.add(path)
            for name in memory.content(path.read_bytes(), package.name).names:
                queue += _files_named(name, package)
    folders = {path.parent for path in modules if path.is_relative_to(package)}
    data = {file for folder in folders - {package / APART} for file in _data_files(folder)}
    return tuple(sorted(modules | data))


@cache
def _files_named(dotted: str, package: Path) -> tuple[Path, ...]:
    """Return the files of a dotted name: of the packages on the way, and of the module."""
    folder = package
    files = [folder / "__init__.py"]
    for part in dotted.removesuffix(".*").split(".")[1:]:
        if (folder / part / "__init__.py").is_file():
            folder /= part
            files.append(folder / "__init__.py")
        else:
            module = folder / f"{part}.py"
            # what follows are names inside the module
            return (*files, module) if module.is_file() else tuple(files)
    return (*files, *folder.rglob("*.py")) if dotted.endswith(".*") else tuple(files)


@cache
def _data_files(folder: Path) -> tuple[Path, ...]:
    files: list[Path] = []
    for path in folder.iterdir():
        if path.name.startswith((".", "__pycache__")) or path.name.endswith("~"):
            continue
        if path.is_dir():
            if not (path / "__init__.py").exists():
                files += _data_files(path)
        elif path.suffix not in _NO_DATA:
            files.append(path)
    return tuple(files)
