"""The whole study in a copied tree: killed, resumed, run again, changed."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import psutil
import pyarrow.parquet as pq
import pytest

ROOT = Path(__file__).parents[2]
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", ".uv", ".snakemake", "results", ".*_cache", ".hypothesis", "__pycache__"
)
SNAKEMAKE = Path(sys.executable).parent / "snakemake"


def command(*arguments: str) -> list[str]:
    return [str(SNAKEMAKE), "-j2", "--rerun-incomplete", *arguments]


def run(
    tree: Path, *arguments: str, over: str = "", check: bool = True
) -> subprocess.CompletedProcess[str]:
    """Run Snakemake on the small study, with YAML text merged over its configuration."""
    (tree / "over.yaml").write_text(over or "{}")
    configuration = ["--configfile", "config/smoke.yaml", "over.yaml"]
    done = subprocess.run(
        command(*arguments, *configuration), cwd=tree, capture_output=True, text=True, check=False
    )
    if check and done.returncode != 0:
        pytest.fail(f"{done.stdout}\n{done.stderr}")
    return done


def planned_jobs(tree: Path, over: str = "") -> set[str]:
    """Names of the rules that a dry run would execute, with the variant where there is one."""
    text = run(tree, "-n", over=over)
    jobs, rule = set(), ""
    for line in (text.stdout + text.stderr).splitlines():
        words = line.split()
        if len(words) == 2 and words[0] in {"rule", "localrule"}:
            rule = words[1].rstrip(":")
            jobs.add(rule)
        elif words[:1] == ["wildcards:"]:
            jobs.add(f"{rule} {words[1].removeprefix('variant=')}")
    return jobs


def journal_keys(tree: Path) -> list[str]:
    return [
        json.loads(line)["run_key"]
        for path in sorted((tree / "results/journal").glob("*.jsonl"))
        for line in path.read_text().splitlines()
        if line.strip()
    ]


def wait_for(condition: Callable[[], object], seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.2)
    return False


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished smoke study whose first run was killed after its first analysis."""
    tree = tmp_path_factory.mktemp("study") / "tree"
    shutil.copytree(ROOT, tree, ignore=LEFT_OUT)
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
    # As `make study` does it: the lock that the killed run left behind is stale.
    script = ["bash", "workflow/study.sh", str(SNAKEMAKE.parent), "2", "config/smoke.yaml"]
    resumed = subprocess.run(script, cwd=tree, capture_output=True, text=True, check=False)
    if resumed.returncode != 0:
        pytest.fail(f"{resumed.stdout}\n{resumed.stderr}")
    return tree


def test_a_killed_study_repeats_nothing_that_finished(study: Path) -> None:
    finished = json.loads((study / "killed.json").read_text())
    keys = journal_keys(study)
    assert finished
    assert len(keys) == len(set(keys)) == 6
    assert set(finished) <= set(keys)


def test_the_report_is_one_self_contained_page(study: Path) -> None:
    page = (study / "results/report.html").read_text()
    assert page.count("data:image/svg+xml;base64,") >= 4
    assert 'src="http' not in page
    assert 'href="http' not in page


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


def test_one_more_gap_runs_only_the_new_variants(study: Path) -> None:
    jobs = planned_jobs(study, "grid: {gap_mm: [25, 51]}")
    variants = {job for job in jobs if job.startswith("analyse_variant ")}
    assert variants == {
        "analyse_variant osb1_cf_skew30_gap051_mu000",
        "analyse_variant osb1_cf_skew30_gap051_mu050",
    }


def test_a_changed_limit_state_reruns_the_fits_and_what_follows(study: Path) -> None:
    path = study / "config/limit_states.yaml"
    before = path.read_text()
    path.write_text(before + "\n# edited\n")
    try:
        jobs = planned_jobs(study)
    finally:
        path.write_text(before)
        os.utime(path, (0, 0))
    assert "fit_fragility" in jobs
    assert "report" in jobs
    assert not any(job.startswith(("analyse", "prepare", "collect", "paired")) for job in jobs)


def test_edited_mechanics_rerun_the_analyses_and_edited_prose_does_not(study: Path) -> None:
    path = study / "src/skewbridge/contact/law.py"
    before = path.read_text()
    try:
        path.write_text(before + "\n# a comment\n")
        assert planned_jobs(study) == set()
        path.write_text(before + "\nEXTRA = 1.0\n")
        assert "analyse_variant osb1_cf_skew30_gap025_mu050" in planned_jobs(study)
    finally:
        path.write_text(before)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("grdi: {gap_mm: [25]}", "grdi: unknown key"),
        ("grid: {skew_deg: [75]}", "less than or equal to 60, got 75"),
        ("grid: {gap_mm: [-5]}", "greater than or equal to 0, got -5"),
        ("grid: {friction: [-0.1]}", "greater than or equal to 0, got -0.1"),
        ("model: {cohesion_n: 2e7}", "it is text"),
        ("grid: {skew_deg: []}", "at least 1 item"),
        ("grid: {bridge: [osb7]}", "osb7"),
    ],
)
def test_bad_configuration_stops_before_any_work(study: Path, override: str, words: str) -> None:
    done = run(study, "-n", over=override, check=False)
    assert done.returncode != 0
    assert words in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.parametrize("fault", ["missing", "nan", "dt"])
def test_a_faulty_motion_stops_the_study_before_any_analysis(
    study: Path, tmp_path: Path, fault: str
) -> None:
    folder = tmp_path / "records"
    folder.mkdir()
    first, second = sorted((ROOT / "motions").rglob("*.AT2"))[:2]
    for path in (first, second):
        shutil.copy(path, folder)
    text = (folder / second.name).read_text()
    if fault == "missing":
        (folder / second.name).unlink()
    elif fault == "nan":
        head, _, _ = text.rstrip().rpartition(" ")
        (folder / second.name).write_text(f"{head} NaN\n")
    else:
        (folder / second.name).write_text(text.replace("DT=", "DT=  1", 1))
    done = run(
        study,
        "--until",
        "prepare_motions",
        over=f"motions: {{folder: {folder}, count: 1}}",
        check=False,
    )
    assert done.returncode != 0
    assert second.name in done.stdout + done.stderr or first.name in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_the_workflow_passes_the_linter_but_for_environments(study: Path) -> None:
    """One environment for all rules is the project's choice: made by `make setup`, locked."""
    done = run(study, "--lint", check=False)
    findings = [
        line.strip()
        for line in (done.stdout + done.stderr).splitlines()
        if line.startswith("    * ")
    ]
    allowed = "Specify a conda environment or container for each rule"
    assert [finding for finding in findings if allowed not in finding] == []
