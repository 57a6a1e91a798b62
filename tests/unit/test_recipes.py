"""The digest of each rule has the sources of everything that its script imports."""

import ast
from pathlib import Path

import pytest

import skewbridge
from skewbridge.study.products import RECIPES

PACKAGE = Path(skewbridge.__file__).parent
SCRIPTS = Path(__file__).parents[2] / "workflow" / "scripts"
#: Reads bridges, which are digested by their numbers, and writes to the log only.
PERIODS_IN_LOG = "analysis/modal.py"
#: Configuration, which is digested by its values, and scheduling, which changes no result.
NOT_IN_RESULTS = {
    "__init__.py",
    "fragility/settings.py",
    "analysis/settings.py",
    "analysis/accuracy.py",
    "motions/levels.py",
    "study/config.py",
    "study/folder.py",
    "study/inputs.py",
    "study/processes.py",
    "study/products.py",
    "study/session.py",
}


def module_path(name: str) -> Path | None:
    path = PACKAGE.parent / name.replace(".", "/")
    paths = [path.with_suffix(".py"), path / "__init__.py"]
    return next((path for path in paths if path.is_file()), None)


def imported(path: Path) -> set[Path]:
    """Return the modules of the package that a file imports, also inside functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("skewbridge"):
            names |= {str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)}
    return {found for name in names if (found := module_path(name))}


def closure(script: Path) -> set[str]:
    """Return all modules that a script imports directly or through others."""
    boundaries = set(NOT_IN_RESULTS)
    if script.stem == "prepare_motions":
        boundaries |= {PERIODS_IN_LOG, "bridge/catalogue/__init__.py"}
    found: set[Path] = set()
    left = imported(script)
    while left:
        path = left.pop()
        found.add(path)
        if path.relative_to(PACKAGE).as_posix() not in boundaries:
            left |= imported(path) - found
    return {path.relative_to(PACKAGE).as_posix() for path in found}


def sources(rule: str) -> set[str]:
    """Return the sources in the digest of a rule, which has those of the rules before it."""
    recipe = RECIPES[rule]
    return set(recipe.sources).union(*(sources(before) for before in recipe.after))


@pytest.mark.parametrize("rule", RECIPES)
def test_no_source_of_a_rule_is_missing(rule: str) -> None:
    parts = sources(rule)
    missing = {
        name
        for name in closure(SCRIPTS / f"{rule}.py") - NOT_IN_RESULTS
        if not any(name == part or name.startswith(f"{part}/") for part in parts)
        and not name.endswith("__init__.py")
        and not (rule == "prepare_motions" and name == PERIODS_IN_LOG)
    }
    assert not missing
