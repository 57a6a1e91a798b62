"""The jobs of a study on a cluster: their size, the forecast of them, what a killed run left."""

from pathlib import Path
from typing import Any

import pytest
import yte

from skewbridge.errors import InputError
from skewbridge.files.checking import merged
from skewbridge.files.text import read_mapping, writable_folder, written_aside
from skewbridge.study.config import parse_config
from skewbridge.study.processes import cancel_left_behind
from skewbridge.study.progress import JobSize, forecast_study

ROOT = Path(__file__).parents[2]


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of programs in place of Slurm's, the only ones that are found."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:/bin:/usr/bin")
    return folder


def program(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def test_the_size_of_a_job_comes_from_the_profile_and_its_environment(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program(programs, "sacct", "exit 1")
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("SKEWBRIDGE_JOB_CORES", "8")
    monkeypatch.setenv("SKEWBRIDGE_JOBS", "7")
    assert JobSize.of_profile("slurm") == JobSize(cores=8, jobs=7)
    assert JobSize.of_profile("profiles/default") is None
    with pytest.raises(InputError, match="no profile 'nowhere'"):
        JobSize.of_profile("nowhere")


def test_a_faulty_profile_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("executor: slurm\njobs: 3\n")
    with pytest.raises(InputError, match="not a valid cluster profile"):
        JobSize.of_profile(str(tmp_path))


def profile() -> dict[str, Any]:
    with (ROOT / "workflow/profiles/slurm/config.yaml").open() as text:
        found = yte.process_yaml(text, require_use_yte=True)
    assert isinstance(found, dict)
    return found


def test_the_status_of_jobs_comes_from_accounting_if_there_is_any(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An account is named only where there is accounting, or the executor would look it up."""
    monkeypatch.setenv("SBATCH_ACCOUNT", "mine")
    program(programs, "sacct", "echo 'Slurm accounting storage is disabled' >&2; exit 1")
    assert profile()["slurm-status-command"] == "squeue"
    assert "slurm_account" not in profile()["default-resources"]
    program(programs, "sacct", "exit 0")
    assert profile()["slurm-status-command"] == "sacct"
    assert profile()["default-resources"]["slurm_account"] == "mine"


def test_only_jobs_of_this_tree_are_cancelled(programs: Path, tmp_path: Path) -> None:
    cancelled = tmp_path / "cancelled"
    listed = "11 skewbridge-aa_1\\n12 skewbridge-bb_2\\n13 a job of mine\\n14 skewbridge-aa_3"
    program(programs, "squeue", f"printf '{listed}\\n'")
    program(programs, "scancel", f'echo "$@" >> {cancelled}')
    cancel_left_behind("skewbridge-aa")
    assert cancelled.read_text() == "11 14\n"
    program(programs, "squeue", "true")
    cancel_left_behind("skewbridge-aa")
    assert cancelled.read_text() == "11 14\n"


@pytest.mark.parametrize(
    ("jobs_at_once", "expected"),
    [
        # 12 variants of 16 analyses of 4 s, 64 s on each of 4 processors
        (100, {"jobs": 12, "job_cores": 4, "job_hours": 0.0, "hours": 0.0}),
        (2, {"jobs": 12, "job_cores": 4, "job_hours": 0.0, "hours": 0.03}),
    ],
)
def test_forecast_of_jobs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs_at_once: int, expected: dict[str, float]
) -> None:
    """A job for each variant."""
    monkeypatch.chdir(ROOT)
    over = {"results": str(tmp_path), "grid": {"bridge": ["osb1"]}, "motions": {"count": 16}}
    config = parse_config(merged(read_mapping(Path("config/config.yaml")), over))
    size = JobSize(cores=4, jobs=jobs_at_once)
    assert forecast_study(config, size).summary.items() >= expected.items()
    assert "jobs" not in forecast_study(config).summary


def test_two_nodes_with_equal_process_ids_write_separate_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "table"
    with written_aside(path) as first:
        first.write_text("first")
        monkeypatch.setattr("socket.gethostname", lambda: "another")
        with written_aside(path) as second:
            second.write_text("second")
        assert first != second
        assert writable_folder(tmp_path) == tmp_path
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_every_rule_of_the_profile_exists() -> None:
    """A misspelt rule would be passed over, and its job would ask for the default."""
    found = profile()
    rules = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    named = {*found["groups"], *found["set-threads"]}
    assert [name for name in sorted(named) if f"rule {name}:" not in rules] == []
