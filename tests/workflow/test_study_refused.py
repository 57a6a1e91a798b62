"""Faults that stop a study before any analysis, and the form of the rules."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from skewbridge.study.products import RECIPES
from small_study import ROOT, SNAKEMAKE, copy_sources, run


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources in which nothing has run."""
    folder = tmp_path_factory.mktemp("refused") / "tree"
    copy_sources(folder)
    return folder


def rule_blocks() -> dict[str, str]:
    """Texts of all rules by name."""
    text = "".join(path.read_text() for path in sorted((ROOT / "workflow/rules").glob("*.smk")))
    blocks = re.split(r"^(?:rule|checkpoint) (\w+):", text, flags=re.MULTILINE)[1:]
    return dict(zip(blocks[::2], blocks[1::2], strict=True))


def test_every_input_made_by_a_rule_is_in_the_digest_of_its_reader() -> None:
    """What a rule reads of others is in its recipe, directly or through another one.

    The gate is only an input to come first: where it alone has changed, journals have everything.
    """
    blocks = rule_blocks()
    assert set(blocks) == set(RECIPES)

    def behind(rule: str) -> set[str]:
        after = set(RECIPES[rule].after)
        return after.union(*map(behind, after))

    for name, block in blocks.items():
        inputs = set(re.findall(r"rules\.(\w+)\.output", block))
        assert inputs - {"verify_contact"} <= behind(name), name
        assert f'made_from=MADE_FROM["{name}"]' in block
    assert "rules.verify_contact" in blocks["analyse"]
    # Snakemake forgets a job behind one that runs if all that it reads of that one is ancient
    assert "ancient(rules." not in "".join(blocks.values())


def test_every_rule_has_a_docstring_and_resources() -> None:
    for name, block in rule_blocks().items():
        assert re.match(r'\n    """[A-Z][^"]+\."""\n', block), name
        for directive in ("log:", "benchmark:", "resources:", "mem_mb=", "runtime="):
            assert directive in block, (name, directive)


def test_the_workflow_changes_no_setting_of_snakemake() -> None:
    text = "".join(path.read_text() for path in (ROOT / "workflow").rglob("*.smk"))
    text += (ROOT / "workflow/Snakefile").read_text() + (ROOT / "Snakefile").read_text()
    assert not re.search(r"workflow\.\w+_settings(\.\w+)* *[-|]?=", text)
    assert not re.search(r"config\[.*\] *=|signal\.", text)


@pytest.mark.parametrize("asked", [("-n",), ("--dag",), ("--summary",)])
def test_snakemake_answers_without_a_number_of_cores(tree: Path, asked: tuple[str, ...]) -> None:
    done = subprocess.run(
        [str(SNAKEMAKE), *asked, "--configfile", "config/smoke.yaml"],
        cwd=tree,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "analyse" in done.stdout + done.stderr


def test_a_copied_configuration_has_results_of_its_own(tree: Path) -> None:
    shutil.copy(tree / "config/smoke.yaml", tree / "config/mine.yaml")
    done = subprocess.run(
        [str(SNAKEMAKE), "-n", "--configfile", "config/mine.yaml"],
        cwd=tree,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "output: results/mine/report.html" in done.stdout + done.stderr
    assert "results/smoke" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("grdi: {gap_mm: [25]}", "grdi: unknown key"),
        ("figures: {font: Nowhere Sans}", "figures.font must be sans-serif, serif, monospace or"),
        ("results: Snakefile", "cannot write to the folder 'Snakefile'"),
        ("motions: {folder: nowhere}", "motions folder nowhere does not exist"),
    ],
)
def test_bad_configuration_stops_before_any_work(tree: Path, override: str, words: str) -> None:
    done = run(tree, "-n", over=override, check=False)
    assert done.returncode != 0
    assert words in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_a_configuration_that_is_not_there_is_named() -> None:
    command = ["bash", "workflow/study.sh", "no_folder", "1", "config/nowhere.yaml"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "study: there is no configuration config/nowhere.yaml\n"


def test_a_faulty_motion_stops_the_study_before_any_analysis(tree: Path, tmp_path: Path) -> None:
    folder = tmp_path / "records"
    folder.mkdir()
    first, second = sorted((ROOT / "motions").rglob("*.AT2"))[:2]
    shutil.copy(first, folder)
    head, _, _ = second.read_text().rstrip().rpartition(" ")
    (folder / second.name).write_text(f"{head} NaN\n")
    over = f"motions: {{folder: {folder}, count: 1}}"
    done = run(tree, "--until", "prepare_motions", over=over, check=False)
    assert done.returncode != 0
    assert second.name in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_the_workflow_passes_the_linter_but_for_environments(tree: Path) -> None:
    """One environment for all rules is the project's choice: made by `make setup`, locked."""
    done = run(tree, "--lint", check=False)
    findings = [
        line.strip()
        for line in (done.stdout + done.stderr).splitlines()
        if line.startswith("    * ")
    ]
    allowed = "Specify a conda environment or container for each rule"
    assert [finding for finding in findings if allowed not in finding] == []
