"""The whole study in a copied tree: killed, resumed, run again, changed."""

import json
import re
import shutil
import signal
import subprocess
from pathlib import Path

import pandas as pd
import psutil
import pyarrow.parquet as pq
import pytest

from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.study.processes import LOCK_NAME
from small_study import (
    SNAKEMAKE,
    TIMES,
    command,
    copy_sources,
    journal_keys,
    planned_jobs,
    run,
    wait_for,
)

SLUGS = ("osb1_cf_skew30_gap025_mu000", "osb1_cf_skew30_gap025_mu050")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished smoke study whose first run was killed after its first analysis."""
    tree = tmp_path_factory.mktemp("study") / "tree"
    copy_sources(tree)
    smoke = tree / "config/smoke.yaml"
    text = smoke.read_text().replace("duration_s: 10.0", "duration_s: 6.0")
    smoke.write_text(f"results: results\n{text}")
    process = subprocess.Popen(
        command("--configfile", "config/smoke.yaml"),
        cwd=tree,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    assert wait_for(lambda: (tree / "results/journal").exists() and journal_keys(tree), 240)
    family = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert wait_for(
        lambda: not any(p.is_running() and p.status() != "zombie" for p in family), 30
    ), "children of a killed study go on"
    (tree / "killed.json").write_text(json.dumps(journal_keys(tree)))
    # The same command again; its locks are the tree's, so that those of the killed run are stale.
    resumed = subprocess.Popen(
        command("--configfile", "config/smoke.yaml"),
        cwd=tree,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    lock = tree / ".snakemake" / LOCK_NAME
    assert wait_for(lambda: lock.read_text() == str(resumed.pid), 120)
    second = run(tree, over="results: elsewhere", check=False)
    (tree / "second.log").write_text(second.stdout + second.stderr)
    smoke.write_text(smoke.read_text() + "# a note\n")
    said, _ = resumed.communicate()
    (tree / "resumed.log").write_text(said)
    if resumed.returncode != 0:
        pytest.fail(said)
    shutil.rmtree(tree / "elsewhere")
    return tree


def test_a_second_run_in_the_tree_stops_with_one_sentence(study: Path) -> None:
    """Whatever folder it writes to."""
    said = (study / "second.log").read_text().strip().splitlines()
    assert said[-1].startswith(f"another study is running in {study} (process ")
    assert "Traceback" not in "".join(said)


def test_a_configuration_edited_meanwhile_is_reported(study: Path) -> None:
    said = (study / "resumed.log").read_text()
    assert "config/smoke.yaml was edited while the study ran" in said
    assert "config/config.yaml was edited" not in said


def test_a_killed_study_repeats_nothing_that_finished(study: Path) -> None:
    finished = json.loads((study / "killed.json").read_text())
    keys = journal_keys(study)
    assert finished
    assert len(keys) == len(set(keys)) == 6
    assert set(finished) <= set(keys)


def test_the_report_is_one_self_contained_page(study: Path) -> None:
    page = (study / "results/report.html").read_text()
    assert page.count("data:image/webp;base64,") >= 4
    assert 'src="http' not in page
    # addresses inside the vendored library are texts of its messages
    assert 'href="http' not in re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)


def test_every_analysis_has_a_row_with_a_status(study: Path) -> None:
    demands = pd.read_parquet(study / "results/demands.parquet")
    assert len(demands) == 6
    assert demands["status"].isin(["ok", "collapse"]).all()
    assert json.loads((study / "results/checks.json").read_text())["passed"]


def test_parquet_files_tell_where_they_come_from(study: Path) -> None:
    for name in ("demands", "fragility/curves", "fragility/effects"):
        metadata = pq.read_schema(study / f"results/{name}.parquet").metadata
        assert metadata[b"openseespy_version"]
        assert metadata[b"git_commit"]


def test_running_again_does_nothing(study: Path) -> None:
    assert planned_jobs(study) == set()


def test_modelling_choices_are_made_on_request_only(study: Path) -> None:
    assert planned_jobs(study, "", "choices") == {"modelling_choices", "choices"}
    outdated = study / "results/modelling_choices.parquet"
    write_frame(pd.DataFrame({"name": ["keys"]}), outdated, provenance(rule_digest="another"))
    try:
        assert planned_jobs(study) == set()
    finally:
        outdated.unlink()


def test_workers_and_the_growth_of_a_grid_leave_the_tables_as_they_are(study: Path) -> None:
    """The study again: half of its grid on one core, then all with two workers for a variant."""
    tables = ["demands.parquet", *(f"demands/{slug}.parquet" for slug in SLUGS)]
    half = "{results: again, grid: {friction: [0.0]}}"
    done = run(study, "--", "again/demands.parquet", over=half, cores=1)
    assert (done.stdout + done.stderr).count("rule analyse:") == 1
    first = journal_keys(study, "again")
    two = ("--set-threads", "analyse=2")
    done = run(study, *two, "--", "again/demands.parquet", over="results: again")
    assert (done.stdout + done.stderr).count("rule analyse:") == 1
    assert len(first) == 3
    assert journal_keys(study, "again")[:3] == first
    assert sorted(journal_keys(study, "again")) == sorted(journal_keys(study))
    for name in tables:
        found, expected = (pd.read_parquet(study / root / name) for root in ("again", "results"))
        pd.testing.assert_frame_equal(
            found.drop(columns=TIMES), expected.drop(columns=TIMES), check_exact=True
        )
    skewbridge = [str(SNAKEMAKE.parent / "skewbridge"), "status", "--json", "--study"]
    merged = (study / "config/smoke.yaml").read_text().replace("results: results", "results: again")
    (study / "merged.yaml").write_text(merged)
    state = subprocess.run(
        [*skewbridge, "merged.yaml"], cwd=study, capture_output=True, text=True, check=True
    )
    expected = {"variants": 2, "analyses": 6, "done": 6, "left": 0}
    assert json.loads(state.stdout).items() >= expected.items()
    shutil.rmtree(study / "again")


@pytest.fixture(scope="module")
def copy(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The finished study in a tree copied without the times of its files, to be edited."""
    tree = tmp_path_factory.mktemp("copy") / "tree"
    shutil.copytree(study, tree, copy_function=shutil.copy)
    for path in sorted(tree.rglob("*"), reverse=True):
        path.touch()  # folders with sources last, results first
    return tree


def jobs_after(tree: Path, edits: dict[str, tuple[str, str]], over: str = "") -> set[str]:
    """Jobs planned after texts in files are replaced; the files are as before afterwards.

    The target itself is left out. An empty text stands for the end of the file.
    """
    before = {name: (tree / name).read_text() for name in edits}
    try:
        for name, (old, new) in edits.items():
            assert old in before[name]
            text = before[name].replace(old, new) if old else before[name] + new
            (tree / name).write_text(text)
        return planned_jobs(tree, over) - {"study"}
    finally:
        for name, text in before.items():
            (tree / name).write_text(text)


ANALYSES = {"analyse", "collect_demands", "sensitivity", "friction_pair"}
FITS = {"fit_fragility", "figures", "report"}


def test_a_copied_tree_runs_nothing(copy: Path) -> None:
    assert planned_jobs(copy) == set()


def test_notes_and_comments_run_nothing(copy: Path) -> None:
    names = (
        "motions/README.md",
        "config/config.yaml",
        "config/limit_states.yaml",
        "src/skewbridge/bridge/catalogue/osb1.yaml",
        "workflow/scripts/analyse.py",
    )
    assert jobs_after(copy, dict.fromkeys(names, ("", "\n# a comment\n"))) == set()


def test_a_changed_limit_state_reruns_fits_and_report(copy: Path) -> None:
    jobs = jobs_after(copy, {"config/limit_states.yaml": ("dcr_050: 0.5", "dcr_050: 0.55")})
    assert jobs == FITS


def test_edited_mechanics_rerun_analyses_fits_and_report(copy: Path) -> None:
    jobs = jobs_after(copy, {"src/skewbridge/contact/law.py": ("", "\nEXTRA = 1.0\n")})
    assert jobs == ANALYSES | FITS | {"verify_contact"}


def test_a_corrected_period_prepares_the_motions_again(copy: Path) -> None:
    period = {"src/skewbridge/bridge/catalogue/osb1.yaml": ("t1_s: {v: 0.7192", "t1_s: {v: 0.75")}
    assert jobs_after(copy, period) == ANALYSES | FITS | {"prepare_motions"}


def test_another_version_of_the_solver_reruns_the_analyses(copy: Path) -> None:
    """The version is that of the installed package: here the answer about it is another one."""
    patch = copy / "patch"
    patch.mkdir()
    (patch / "sitecustomize.py").write_text(
        "import importlib.metadata as m\n"
        "found = m.version\n"
        "m.version = lambda name: '9.9' if name == 'openseespy' else found(name)\n"
    )
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("PYTHONPATH", str(patch))
        jobs = planned_jobs(copy)
    assert jobs >= ANALYSES | {"verify_contact"}
    assert "prepare_motions" not in jobs


def test_an_edited_bridge_reruns_the_studies_that_use_it(copy: Path) -> None:
    """The study has osb1, and no bridge that extends it."""
    files = "src/skewbridge/bridge/catalogue/osb1{}.yaml"
    child = {files.format("_fixed"): ("base: fixed", "base: pinned")}
    assert jobs_after(copy, child) == set()
    parent = {files.format(""): ("base: pinned", "base: fixed")}
    assert jobs_after(copy, parent) == ANALYSES | FITS


def test_a_study_is_written_into_its_configured_folder(study: Path) -> None:
    done = run(study, "-n", over="results: elsewhere/mine")
    assert "output: elsewhere/mine/report.html" in done.stdout + done.stderr
    assert "results/" not in done.stdout + done.stderr
    shutil.rmtree(study / "elsewhere")
