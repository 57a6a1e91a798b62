"""Sources: what each process loads, what an edit reruns, and none of a rule is missing."""

import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner

import skewbridge
from cli_json import invoke
from skewbridge.cli import COMMANDS, build_app
from skewbridge.files.digests import ENGINE, digest_of, layer_digest
from skewbridge.study.jobs import RECIPES

PACKAGE = Path(skewbridge.__file__).parent
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
    "units.py": (ALL, set()),
    "errors.py": (ALL, set()),
    "files/tables.py": ({*ANALYSING, *FITS, *PAGES}, {ANALYSES}),
    "variant/variant.py": ({ANALYSES, *ANALYSING}, set()),
    "variant/options.py": ({ANALYSES, *ANALYSING, *FITS}, set()),
    "fragility/settings.py": ({*FITS, *PAGES}, {ANALYSES, "analyse", "prepare_motions"}),
    "study/config.py": ({"report"}, ALL - PAGES),
    "motions/record.py": ({ANALYSES, *ANALYSING, "prepare_motions"}, {"fit_fragility"}),
    "motions/formats.py": ({"prepare_motions"}, {ANALYSES, "analyse", *FITS}),
    "motions/synthesis/ddk18.py": ({"prepare_motions", "verification"}, {ANALYSES, *FITS}),
    "contact/law.py": ({ANALYSES, *ANALYSING, *VERIFYING}, {"prepare_motions", "fit_fragility"}),
    "bridge/weights.py": ({ANALYSES, *ANALYSING}, {"prepare_motions", "fit_fragility"}),
    "analysis/peaks.py": ({ANALYSES, *ANALYSING}, {"prepare_motions", "fit_fragility"}),
    "demands/columns.csv": ({"analyse", "collect_demands", *FITS, *PAGES}, {ANALYSES}),
    "fragility/effects.py": (
        {*FITS, *PAGES, "verification"},
        {ANALYSES, "analyse", "collect_demands"},
    ),
    "study/journal.py": (ANALYSING, {ANALYSES, "fit_fragility"}),
    "study/jobs.py": (set(), ALL),
    "study/repeats.py": ({"sensitivity"}, ALL - {"sensitivity"}),
    "study/analyses.py": ({*ANALYSING, "verification"}, {ANALYSES}),
    "study/modelling_choices.py": ({"modelling_choices", *PAGES}, {"analyse"}),
    "report/checks.py": ({"fit_fragility", *PAGES}, {ANALYSES, *ANALYSING}),
    "report/run_figures.py": ({*PAGES, "verification"}, {ANALYSES, *ANALYSING, *FITS}),
    "report/page.py": (PAGES, ALL - PAGES),
    "report/templates/report.html.j2": (PAGES, ALL - PAGES),
    "verification/registry.py": (VERIFYING, ALL - VERIFYING),
    "verification/studies/published.py": ({"verification"}, ALL - {"verification"}),
    "files/text.py": (ALL, set()),
    "cli/output.py": (set(), ALL),
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package."""
    folder = tmp_path_factory.mktemp("sources") / "skewbridge"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def digests(package: Path) -> dict[str, str]:
    return {name: layer_digest(parts, package) for name, parts in PARTS.items()}


BEFORE = digests(PACKAGE)


def test_every_package_is_edited_below() -> None:
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert {name.split("/")[0] for name in EDITS if "/" in name} == folders


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
    # numbers that differ in the last bit have other keys
    assert digest_of(0.1 + 0.2) != digest_of(0.3)
    assert digest_of(("a", 1)) == digest_of(("a", 1))


# --- workers and the command line load no package that they do not use


#: Needed by the main process (tables, statistics, figures), by no worker and by no help text.
HEAVY = ("pandas", "scipy", "pyarrow", "matplotlib", "seaborn", "jinja2", "snakemake")
#: The help is text alone.
NOT_FOR_HELP = (*HEAVY, "numpy", "openseespy", "joblib", "yaml", "rich.console")


def loaded_by(code: str) -> set[str]:
    """Names of all modules that a fresh interpreter has loaded after running some code."""
    listed = [sys.executable, "-c", f"{code}\nimport sys\nprint('LOADED', *sys.modules)"]
    done = subprocess.run(listed, capture_output=True, text=True, check=True)
    return set(done.stdout.split("LOADED", 1)[1].split())


def test_a_worker_loads_the_engine_only_and_a_process_that_draws_no_solver() -> None:
    """The pool unpickles `study.batch`; `study.task` is the analysis, `transient` its steps."""
    loaded = loaded_by("import skewbridge.study.batch")
    parts = {f"skewbridge.{name}" for name in ("study.batch", "study.task", "analysis.transient")}
    assert parts <= loaded
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
still = np.full(4, 0.01)
motion = GroundMotion(motion_id="m", dt_s=0.01, accel_1_mps2=still, accel_2_mps2=still)
values = {"skew_deg": 30, "gap_mm": 51, "friction": 0.5}
task = Task(variant=Variant.at("osb1", "contact_friction", values), incidence_deg=0.0,
    motion=SuiteMotion(motion=motion, scale=1.0, measures={}),
    settings=AnalysisSettings(), options=ModelOptions())
row = analyse_task(task, Path("/dev/null"), lambda *_: None)
assert row["status"] == "ok", row
"""


def test_an_analysis_loads_only_modules_that_are_in_its_key() -> None:
    """Imports inside functions count; the digests themselves are made by the caller."""
    loaded = loaded_by(ANALYSIS)
    assert loaded.isdisjoint(set(HEAVY) - {"scipy"})  # its root finder, for moment-curvature
    names = (name.removeprefix("skewbridge.") for name in loaded if name.startswith("skewbridge."))
    files = [file for name in names if (file := PACKAGE / f"{name.replace('.', '/')}.py").exists()]
    inside = [PACKAGE / part for part in ENGINE]
    outside = [file for file in files if not {file, *file.parents} & set(inside)]
    assert len(files) >= 34
    assert outside == [PACKAGE / "files/digests.py"]


def test_help_loads_no_numbers() -> None:
    """The list of commands is shown without loading any of them."""
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
    commands = command.commands.values() if isinstance(command, TyperGroup) else [command]
    for each in commands:
        example = (each.help or "").split("Example: skewbridge ")[1]
        words = shlex.split(example)[2 if isinstance(command, TyperGroup) else 1 :]
        each.make_context("", words)
    assert COMMANDS[name][1] in shown


def test_a_mistyped_command_gets_a_suggestion_and_the_version_is_shown() -> None:
    result = invoke("rnu")
    assert result.exit_code == 2
    assert "'run'" in result.stderr
    assert invoke("--version").stdout.startswith("skewbridge 0.")
