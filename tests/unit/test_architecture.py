"""Imports in one direction; what an edit reruns; what processes load; nothing is unused."""

import ast
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
import typer
import yaml
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner
from vulture import Vulture

import skewbridge
from cli_json import invoke
from skewbridge.cli import COMMANDS, build_app
from skewbridge.files.digests import ENGINE, digest_of, layer_digest
from skewbridge.study.jobs import RECIPES

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
# Called by pydantic and by the command line, which find them by their decorators.
REGISTERED = ["@model_validator", "@field_validator", "@*.callback", "@*.command", "@command"]
#: Reads bridges, which are digested by their numbers, and writes to the log only.
PERIODS_IN_LOG = "analysis/modal.py"
#: Configuration, which is digested by its values, and scheduling, which changes no result.
NOT_IN_RESULTS = {
    "__init__.py", "fragility/settings.py", "analysis/settings.py",
    "motions/levels.py", "study/config.py", "study/folder.py", "study/inputs.py",
    "study/processes.py", "study/jobs.py",
}  # fmt: skip
#: Needed by the main process (tables, statistics, figures), by no worker and by no help text.
HEAVY = ("pandas", "scipy", "pyarrow", "matplotlib", "seaborn", "jinja2", "snakemake")
#: The help is text alone.
NOT_FOR_HELP = (*HEAVY, "numpy", "openseespy", "joblib", "yaml", "rich.console")


@cache
def imported_names(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_earlier_packages(path: Path) -> None:
    allowed = set(ORDER[: ORDER.index(path.relative_to(PACKAGE).parts[0]) + 1])
    own = (name for name in imported_names(path) if name.startswith("skewbridge."))
    assert {name.split(".")[1] for name in own} <= allowed


def test_imports_form_no_cycle() -> None:
    """Imports inside functions count as well; a cycle raises `CycleError` with its modules."""
    graph = {name: (imported_names(p) & PATHS.keys()) - {name} for name, p in PATHS.items()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(PATHS)


def sources(rule: str) -> set[str]:
    """Return the sources in the digest of a rule, which has those of the rules before it."""
    recipe = RECIPES[rule]
    return set(recipe.sources).union(*(sources(before) for before in recipe.after))


@pytest.mark.parametrize("rule", RECIPES)
def test_no_source_of_a_rule_is_missing(rule: str) -> None:
    """Of all modules that its script imports directly or through others, also in functions."""
    parts, unread = sources(rule), set(NOT_IN_RESULTS)
    if rule == "prepare_motions":
        unread |= {PERIODS_IN_LOG, "bridge/catalogue/__init__.py"}
    found: set[str] = set()
    left = imported_names(ROOT / f"workflow/scripts/{rule}.py") & PATHS.keys()
    while left:
        found.add(name := left.pop())
        if PATHS[name].relative_to(PACKAGE).as_posix() not in unread:
            left |= (imported_names(PATHS[name]) & PATHS.keys()) - found
    files = {PATHS[name].relative_to(PACKAGE).as_posix() for name in found} - unread
    files = {file for file in files if not file.endswith("__init__.py")}
    missing = {file for file in files if not any(f"{file}/".startswith(f"{p}/") for p in parts)}
    assert not missing


def test_hooks_have_the_locked_versions_and_the_drawn_workflow_its_rules() -> None:
    locked = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(), re.M))
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    names = [each["repo"].rsplit("/")[-1].removesuffix("-pre-commit") for each in hooks]
    assert [each["rev"] for each in hooks] == [f"v{locked[name]}" for name in names]
    # `make docs` draws it from the rule graph of Snakemake.
    texts = re.findall(r">([a-z_]+)</text>", (ROOT / "docs/images/rules.svg").read_text())
    in_rounds = {"plan_round", "analyse_round", "collect_rounds"}
    assert set(texts) == RECIPES.keys() - {"verification", "modelling_choices"} - in_rounds


def test_every_function_is_reached() -> None:
    """Tests do not count as users; what is listed in pyproject.toml waits for its command."""
    allowed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["vulture"]
    search = Vulture(ignore_names=allowed["ignore_names"], ignore_decorators=REGISTERED)
    search.scavenge([str(ROOT / name) for name in allowed["paths"]])
    # Rules and templates are no Python files; registry and conf.py name functions in texts.
    files = ("docs/conf.py", "workflow/Snakefile", "src/skewbridge/verification/studies.yaml")
    named = [*map(ROOT.joinpath, files), *ROOT.glob("workflow/**/*.smk"), *PACKAGE.rglob("*.j2")]
    words = set(re.findall(r"\w+", "".join(path.read_text() for path in named)))
    unused = [
        f"{Path(item.filename).relative_to(ROOT)}: {item.name}"
        for item in search.get_unused_code(min_confidence=60)
        if item.typ in {"function", "class", "method", "property"} and item.name not in words
    ]
    assert not unused


ANALYSES = "the analyses themselves"
PARTS = {ANALYSES: ENGINE, **{rule: recipe.sources for rule, recipe in RECIPES.items()}}
#: Rules that list or run analyses; all but the last look at the journals, which say what is new.
ANALYSING = {"analyse", "sensitivity", "modelling_choices"}
FITS = {"fit_fragility"}
PAGES = {"figures", "report"}
VERIFYING = {"verify_contact", "verification"}
ALL = {ANALYSES, *RECIPES}

#: A module or data file of every package: what its edit changes, and what it leaves alone. The
#: rules that follow in the workflow run again too; here it is the digest of each alone.
EDITS: dict[str, tuple[set[str], set[str]]] = {
    "files/tables.py": ({*ANALYSING, *FITS, *PAGES}, {ANALYSES}),
    "fragility/settings.py": ({*FITS, *PAGES}, {ANALYSES, "analyse", "prepare_motions"}),
    "study/config.py": ({"report"}, ALL - PAGES),
    "motions/record.py": ({ANALYSES, *ANALYSING, "prepare_motions"}, {"fit_fragility"}),
    "motions/synthesis.py": ({"prepare_motions", "verification"}, {ANALYSES, *FITS}),
    "contact/law.py": ({ANALYSES, *ANALYSING, *VERIFYING}, {"prepare_motions", "fit_fragility"}),
    "demands/columns.csv": ({"analyse", "collect_demands", *FITS, *PAGES}, {ANALYSES}),
    "fragility/effects.py": ({*FITS, *PAGES, "verification"}, {ANALYSES, "collect_demands"}),
    "study/journal.py": (ANALYSING, {ANALYSES, "fit_fragility"}), "study/jobs.py": (set(), ALL),
    "study/repeats.py": ({"sensitivity"}, ALL - {"sensitivity"}),
    "study/modelling_choices.py": ({"modelling_choices", *PAGES}, {"analyse"}),
    "report/page.py": (PAGES, ALL - PAGES), "report/templates/report.html.j2": (PAGES, ALL - PAGES),
    "verification/registry.py": (VERIFYING, ALL - VERIFYING),
    "cli/output.py": (set(), ALL),
}  # fmt: skip


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sources") / "skewbridge"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def digests(package: Path) -> dict[str, str]:
    return {name: layer_digest(parts, package) for name, parts in PARTS.items()}


BEFORE = digests(PACKAGE)


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_changes_the_digests_of_dependent_rules(tree, name):
    path = tree / name
    text = path.read_text()
    path.write_text(text + "\n\nADDED = 1.0\n")
    after = digests(tree)
    path.write_text(text)
    changed = {rule for rule in BEFORE if BEFORE[rule] != after[rule]}
    must, must_not = EDITS[name]
    assert must <= changed
    assert not must_not & changed


def test_bridges_are_digested_by_their_numbers_caches_not_at_all_and_parts_must_exist(tree):
    bridge = tree / "bridge/catalogue/osb1.yaml"
    bridge.write_text(bridge.read_text() + "# a note\n")
    cache = tree / "contact/__pycache__"
    cache.mkdir()
    (cache / "law.cpython-312.pyc").write_bytes(b"x")
    assert digests(tree) == BEFORE
    with pytest.raises(FileNotFoundError, match="cellar"):
        layer_digest(("contact", "cellar"), tree)
    assert digest_of(0.1 + 0.2) != digest_of(0.3)  # numbers that differ in the last bit


def loaded_by(code: str) -> set[str]:
    listed = [sys.executable, "-c", f"{code}\nimport sys\nprint('LOADED', *sys.modules)"]
    return set(subprocess.check_output(listed, text=True).split("LOADED", 1)[1].split())


def test_a_worker_loads_the_engine_only_and_a_process_that_draws_no_solver() -> None:
    """The pool unpickles `study.batch`; `study.task` is the analysis, `transient` its steps."""
    loaded = loaded_by("import skewbridge.study.batch")
    assert {"skewbridge.study.task", "skewbridge.analysis.transient"} <= loaded
    assert loaded.isdisjoint(HEAVY)
    assert "openseespy.opensees" not in loaded_by("import skewbridge.report.study_figures")


ANALYSIS = """
import numpy as np
from pathlib import Path
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.study.task import Task, analyse_task
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
motion = GroundMotion(motion_id="m", dt_s=0.01, **dict.fromkeys(
    ("accel_1_mps2", "accel_2_mps2"), np.full(4, 0.01)))
values = {"skew_deg": 30, "gap_mm": 51, "friction": 0.5}
task = Task(variant=Variant.at("osb1", "contact_friction", values), incidence_deg=0.0,
    motion=SuiteMotion(motion=motion, scale=1.0, measures={}),
    settings=AnalysisSettings(), options=ModelOptions())
row = analyse_task(task, Path("/dev/null"), lambda *_: None)
assert row["status"] == "ok", row
"""


def test_an_analysis_loads_only_modules_that_are_in_its_key() -> None:
    loaded = loaded_by(ANALYSIS)
    assert loaded.isdisjoint(set(HEAVY) - {"scipy"})  # its root finder, for moment-curvature
    names = (name.removeprefix("skewbridge.") for name in loaded if name.startswith("skewbridge."))
    files = [file for name in names if (file := PACKAGE / f"{name.replace('.', '/')}.py").exists()]
    inside = [PACKAGE / part for part in ENGINE]
    outside = [file for file in files if not {file, *file.parents} & set(inside)]
    assert len(files) >= 34
    assert outside == [PACKAGE / "files/digests.py"]


def test_help_loads_no_numbers_and_the_version_is_shown() -> None:
    assert invoke("--version").stdout.startswith("skewbridge 0.")
    of_group = (*HEAVY, "numpy", "openseespy", "joblib")
    cases = {"'--help'": (*NOT_FOR_HELP, "pydantic"), "'motions', '--help'": of_group}
    for arguments, forbidden in cases.items():
        loaded = loaded_by(
            "import sys\nfrom skewbridge.cli import main\n"
            f"sys.argv = ['skewbridge', {arguments}]\n"
            "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        )
        assert loaded.isdisjoint(forbidden)


@pytest.mark.parametrize("name", list(COMMANDS))
def test_the_summary_in_the_help_is_that_of_the_command(name: str) -> None:
    """The list of commands is written by hand, because it is shown without importing them."""
    app = get_command(build_app())
    _, command, _ = app.resolve_command(typer.Context(app), [name])
    assert (command.help or "").splitlines()[0] == COMMANDS[name][1]
    shown = CliRunner().invoke(build_app(), [name, "--help"], terminal_width=300).stdout
    for each in command.commands.values() if isinstance(command, TyperGroup) else [command]:
        example = (each.help or "").split("Example: skewbridge ")[1].split(" > ")[0]
        each.make_context("", shlex.split(example)[2 if isinstance(command, TyperGroup) else 1 :])
    assert COMMANDS[name][1] in shown
