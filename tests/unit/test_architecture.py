"""The packages depend on each other in one direction."""

import ast
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import skewbridge

PACKAGE = Path(skewbridge.__file__).parent
ORDER = (
    "errors", "statuses", "units", "files", "variant", "motions", "contact", "bridge", "analysis",
    "demands", "fragility", "study", "report", "verification", "cli",
)  # fmt: skip
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE)


@cache
def imported_names(path: Path) -> set[str]:
    """Return the modules, and names of modules, that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


def imported_packages(path: Path) -> set[str]:
    return {name.split(".")[1] for name in imported_names(path) if name.startswith("skewbridge.")}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_earlier_packages(path: Path) -> None:
    package = path.relative_to(PACKAGE).parts[0]
    allowed = set(ORDER[: ORDER.index(package) + 1])
    assert imported_packages(path) <= allowed


def test_imports_form_no_cycle() -> None:
    """Imports inside functions count as well; a cycle raises `CycleError` with its modules."""
    modules = {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(
            ".__init__"
        ): path
        for path in PACKAGE.rglob("*.py")
    }
    graph = {
        name: (imported_names(path) & modules.keys()) - {name} for name, path in modules.items()
    }
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(modules)
