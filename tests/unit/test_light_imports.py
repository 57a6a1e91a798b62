"""Workers and the command line start without packages that they do not use."""

import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner

import skewbridge
from skewbridge.cli import COMMANDS, build_app
from skewbridge.files.digests import ENGINE

PACKAGE = Path(skewbridge.__file__).parent

#: Needed by the main process (tables, statistics, figures), by no worker and by no help text.
HEAVY = ("pandas", "scipy", "pyarrow", "plotly", "matplotlib", "seaborn", "jinja2", "snakemake")
#: The help is text alone.
NOT_FOR_HELP = (*HEAVY, "numpy", "openseespy", "joblib", "yaml", "rich.console")


def loaded_by(code: str) -> set[str]:
    """Names of all modules that a fresh interpreter has loaded after running some code."""
    listed = f"{code}\nimport sys\nprint('LOADED', *sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", listed], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split("LOADED", 1)[1].split())


@pytest.mark.parametrize(
    "module", ["skewbridge.study.batch", "skewbridge.study.task", "skewbridge.analysis.transient"]
)
def test_a_worker_loads_the_engine_only(module: str) -> None:
    """The pool unpickles `study.batch`; `study.task` is the analysis, `transient` its steps."""
    loaded = loaded_by(f"import {module}")
    assert module in loaded
    assert loaded.isdisjoint(HEAVY)


ANALYSIS = """
import numpy as np
from pathlib import Path
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.study.task import Task, analyse_task
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import parse_slug
still = np.full(4, 0.01)
motion = GroundMotion(motion_id="m", dt_s=0.01, accel_1_mps2=still, accel_2_mps2=still)
task = Task(variant=parse_slug("osb1_cf_skew30_gap051_mu050"), incidence_deg=0.0,
    motion=SuiteMotion(motion=motion, scale=1.0, measures={}),
    settings=AnalysisSettings(), options=ModelOptions())
row = analyse_task(task, Path("/dev/null"), lambda *_: None)
assert row["status"] == "ok", row
"""


def test_an_analysis_loads_only_modules_that_are_in_its_key() -> None:
    """Imports inside functions count; the digests themselves are made by the caller."""
    loaded = loaded_by(ANALYSIS)
    assert loaded.isdisjoint(HEAVY)
    names = (name.removeprefix("skewbridge.") for name in loaded if name.startswith("skewbridge."))
    files = [file for name in names if (file := PACKAGE / f"{name.replace('.', '/')}.py").exists()]
    inside = [PACKAGE / part for part in ENGINE]
    outside = [file for file in files if not {file, *file.parents} & set(inside)]
    assert len(files) > 40
    assert outside == [PACKAGE / "files/digests.py"]


def test_the_processes_that_draw_figures_load_no_solver() -> None:
    assert "openseespy.opensees" not in loaded_by("import skewbridge.report.study_figures")


@pytest.mark.parametrize(
    ("arguments", "forbidden"),
    [
        (["--help"], (*NOT_FOR_HELP, "pydantic")),
        (["motions", "--help"], (*HEAVY, "numpy", "openseespy", "joblib")),
    ],
)
def test_help_loads_no_numbers(arguments: list[str], forbidden: tuple[str, ...]) -> None:
    """The list of commands is shown without loading any of them."""
    loaded = loaded_by(
        "import sys\nfrom skewbridge.cli import main\n"
        f"sys.argv = ['skewbridge', *{arguments}]\n"
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


def test_a_mistyped_command_gets_a_suggestion() -> None:
    result = CliRunner().invoke(build_app(), ["rnu"])
    assert result.exit_code == 2
    assert "'run'" in result.stderr
