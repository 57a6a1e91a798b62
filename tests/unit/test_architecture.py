"""The rooms depend on each other in one direction."""

import ast
from pathlib import Path

import pytest

from skewbridge.study.provenance import PACKAGE

ORDER = (
    "errors",
    "units",
    "study",
    "motions",
    "contact",
    "bridge",
    "analysis",
    "demands",
    "fragility",
    "report",
    "cli",
)
# Verification stands beside the analyses; only the command line and the scripts call it.
VERIFICATION_MAY_USE = ("errors", "units", "study", "motions", "contact", "bridge", "analysis")
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE)


def imported_rooms(path: Path) -> set[str]:
    rooms = set()
    for node in ast.walk(ast.parse(path.read_text())):
        names = (
            [node.module]
            if isinstance(node, ast.ImportFrom) and node.module
            else [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else []
        )
        rooms |= {name.split(".")[1] for name in names if name.startswith("skewbridge.")}
    return rooms


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_earlier_rooms(path: Path) -> None:
    room = path.relative_to(PACKAGE).parts[0]
    if room == "verification":
        allowed = {*VERIFICATION_MAY_USE, "verification"}
    elif room == "cli":
        allowed = {*ORDER, "verification"}
    else:
        allowed = set(ORDER[: ORDER.index(room) + 1])
    assert imported_rooms(path) <= allowed


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_can_be_read_in_one_sitting(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 300
