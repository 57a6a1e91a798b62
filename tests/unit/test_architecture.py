"""Packages depend on each other in one direction; nothing is unused; files for other tools."""

import ast
import re
import tomllib
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
import yaml
from vulture import Vulture

import skewbridge
from skewbridge.study.jobs import RECIPES
from skewbridge.variant.variant import ABUTMENTS

PACKAGE = Path(skewbridge.__file__).parent
ORDER = (
    "errors", "statuses", "units", "files", "variant", "motions", "contact", "bridge", "analysis",
    "demands", "fragility", "study", "report", "verification", "cli",
)  # fmt: skip
ROOT = Path(__file__).parents[2]
#: Files of all modules by their names.
PATHS = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in PACKAGE.rglob("*.py")
}
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


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_earlier_packages(path: Path) -> None:
    package = path.relative_to(PACKAGE).parts[0]
    allowed = set(ORDER[: ORDER.index(package) + 1])
    own = (name for name in imported_names(path) if name.startswith("skewbridge."))
    assert {name.split(".")[1] for name in own} <= allowed


def test_imports_form_no_cycle() -> None:
    """Imports inside functions count as well; a cycle raises `CycleError` with its modules."""
    graph = {name: (imported_names(p) & PATHS.keys()) - {name} for name, p in PATHS.items()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(PATHS)


# --- no source of a rule is missing


#: Reads bridges, which are digested by their numbers, and writes to the log only.
PERIODS_IN_LOG = "analysis/modal.py"
#: Configuration, which is digested by its values, and scheduling, which changes no result.
NOT_IN_RESULTS = {
    "__init__.py", "fragility/settings.py", "analysis/settings.py",
    "motions/levels.py", "study/config.py", "study/folder.py", "study/inputs.py",
    "study/processes.py", "study/jobs.py",
}  # fmt: skip


def closure(script: Path) -> set[str]:
    """Return all modules that a script imports directly or through others, also in functions."""
    boundaries = set(NOT_IN_RESULTS)
    if script.stem == "prepare_motions":
        boundaries |= {PERIODS_IN_LOG, "bridge/catalogue/__init__.py"}
    found: set[str] = set()
    left = imported_names(script) & PATHS.keys()
    while left:
        name = left.pop()
        found.add(name)
        if PATHS[name].relative_to(PACKAGE).as_posix() not in boundaries:
            left |= (imported_names(PATHS[name]) & PATHS.keys()) - found
    return {PATHS[name].relative_to(PACKAGE).as_posix() for name in found}


def sources(rule: str) -> set[str]:
    """Return the sources in the digest of a rule, which has those of the rules before it."""
    recipe = RECIPES[rule]
    return set(recipe.sources).union(*(sources(before) for before in recipe.after))


@pytest.mark.parametrize("rule", RECIPES)
def test_no_source_of_a_rule_is_missing(rule: str) -> None:
    parts = sources(rule)
    missing = {
        name
        for name in closure(ROOT / f"workflow/scripts/{rule}.py") - NOT_IN_RESULTS
        if not any(name == part or name.startswith(f"{part}/") for part in parts)
        and not name.endswith("__init__.py")
        and not (rule == "prepare_motions" and name == PERIODS_IN_LOG)
    }
    assert not missing


def test_no_module_compares_with_the_name_of_an_abutment_model() -> None:
    """The paper's studies may name the paper's models; drawings name groups of elements."""
    may_name = ("verification/", "report/bridge_figures.py")
    for path in PATHS.values():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Compare):
                texts = {part.value for part in ast.walk(node) if isinstance(part, ast.Constant)}
                is_named = texts & set(ABUTMENTS)
                place = path.relative_to(PACKAGE).as_posix()
                assert not is_named or place.startswith(may_name), ast.unparse(node)


# --- files for other tools, and functions that nothing uses


def test_files_for_other_tools_name_the_workflow_versions_and_rules() -> None:
    settings = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert set(settings) == {"mandatory-flags", "software-stack-deployment", "report"}
    assert set(settings["mandatory-flags"]) == {"desc", "flags"}
    assert set(settings["software-stack-deployment"]) == {"conda", "apptainer", "apptainer+conda"}
    assert "snakemake workflow" in (ROOT / "README.md").read_text()
    assert all((ROOT / name).is_file() for name in ("workflow/Snakefile", "config/README.md"))
    locked = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(), re.M))
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    names = [each["repo"].rsplit("/")[-1].removesuffix("-pre-commit") for each in hooks]
    assert [each["rev"] for each in hooks] == [f"v{locked[name]}" for name in names]
    # `make docs` draws it from the rule graph of Snakemake.
    texts = re.findall(r">([a-z_]+)</text>", (ROOT / "docs/images/rules.svg").read_text())
    on_request = {"verification", "modelling_choices"}
    in_rounds = {"plan_round", "analyse_round", "collect_rounds"}
    assert set(texts) == RECIPES.keys() - on_request - in_rounds


KINDS = {"function", "class", "method", "property"}
# Called by pydantic and by the command line, which find them by their decorators.
REGISTERED = ["@model_validator", "@field_validator", "@*.callback", "@*.command", "@command"]


def test_every_function_is_reached() -> None:
    """Tests do not count as users; what is listed in pyproject.toml waits for its command."""
    allowed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["vulture"]
    search = Vulture(ignore_names=allowed["ignore_names"], ignore_decorators=REGISTERED)
    search.scavenge([str(ROOT / name) for name in allowed["paths"]])
    # Rules and templates are no Python files; registry and conf.py name functions in texts.
    named = [
        ROOT / "docs/conf.py",
        ROOT / "workflow/Snakefile",
        *(ROOT / "workflow").rglob("*.smk"),
        ROOT / "src/skewbridge/verification/registry.py",
        *(ROOT / "src/skewbridge").rglob("*.j2"),
    ]
    words = set(re.findall(r"\w+", "".join(path.read_text() for path in named)))
    unused = [
        f"{Path(item.filename).relative_to(ROOT)}: {item.name}"
        for item in search.get_unused_code(min_confidence=60)
        if item.typ in KINDS and item.name not in words
    ]
    assert not unused
