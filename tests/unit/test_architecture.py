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


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_earlier_packages(path: Path) -> None:
    package = path.relative_to(PACKAGE).parts[0]
    allowed = set(ORDER[: ORDER.index(package) + 1])
    own = (name for name in imported_names(path) if name.startswith("skewbridge."))
    assert {name.split(".")[1] for name in own} <= allowed


def test_imports_form_no_cycle() -> None:
    """Imports inside functions count as well; a cycle raises `CycleError` with its modules."""
    modules = {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): path
        for path in PACKAGE.rglob("*.py")
    }
    modules = {name.removesuffix(".__init__"): path for name, path in modules.items()}
    graph = {name: (imported_names(p) & modules.keys()) - {name} for name, p in modules.items()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(modules)


# --- files for other tools, and functions that nothing uses


ROOT = Path(__file__).parents[2]


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
