"""The packages depend on each other in one direction."""

import ast
from pathlib import Path

import pytest

import skewbridge

PACKAGE = Path(skewbridge.__file__).parent
ORDER = (
    "errors",
    "statuses",
    "reading",
    "units",
    "provenance",
    "variant",
    "motions",
    "contact",
    "bridge",
    "analysis",
    "demands",
    "fragility",
    "study",
    "report",
    "cli",
)
# Verification stands beside the analyses; only the command line and the scripts call it.
VERIFICATION_MAY_USE = ORDER[: ORDER.index("analysis") + 1]
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE)


def imported_packages(path: Path) -> set[str]:
    packages = set()
    for node in ast.walk(ast.parse(path.read_text())):
        names = (
            [node.module]
            if isinstance(node, ast.ImportFrom) and node.module
            else [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else []
        )
        packages |= {name.split(".")[1] for name in names if name.startswith("skewbridge.")}
    return packages


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_earlier_packages(path: Path) -> None:
    package = path.relative_to(PACKAGE).parts[0]
    if package == "verification":
        allowed = {*VERIFICATION_MAY_USE, "verification"}
    elif package == "cli":
        allowed = {*ORDER, "verification"}
    else:
        allowed = set(ORDER[: ORDER.index(package) + 1])
    assert imported_packages(path) <= allowed


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_can_be_read_in_one_sitting(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 300


def test_references_know_nothing_of_the_studies_that_use_them() -> None:
    for path in (PACKAGE / "verification" / "references").rglob("*.py"):
        assert "verification.studies" not in path.read_text(), path
        assert "verification.registry" not in path.read_text(), path
