"""The modules and data files that a script or a module runs: found by following its imports."""

import ast
import re
from functools import cache
from pathlib import Path
from typing import Final

PACKAGE: Final = Path(__file__).parents[1]
#: The bridges stay outside: each is digested by its numbers, for the studies that use it.
APART: Final = Path("bridge", "catalogue")
_NO_DATA: Final = frozenset({".py", ".pyc"})


def closure(root: Path | str, package: Path = PACKAGE) -> tuple[Path, ...]:
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

    Raises:
        FileNotFoundError: The root has no source.
        ValueError: A module uses a relative import.
    """
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
            for name in _imported_names(path.read_bytes(), package.name):
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


@cache
def _imported_names(source: bytes, package: str) -> frozenset[str]:
    """Return the dotted names inside the package that a module imports or names in a text."""
    spelled = re.compile(rf"({package}(?:\.\w+)+)(\.?)(?::\w+)?")
    names: set[str] = set()
    queue: list[ast.AST] = [ast.parse(source)]
    while queue:
        node = queue.pop()
        if isinstance(node, ast.If) and _for_types_only(node.test):
            queue += node.orelse
            continue
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            if node.level or node.module is None:
                raise ValueError("relative imports are not followed: import by the full name")
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = spelled.fullmatch(node.value)
            names |= {f"{text[1]}.*"} if text else set()
        queue += ast.iter_child_nodes(node)
    return frozenset(name for name in names if name.split(".")[0] == package)


def _for_types_only(test: ast.expr) -> bool:
    name = test.id if isinstance(test, ast.Name) else getattr(test, "attr", "")
    return name == "TYPE_CHECKING"
