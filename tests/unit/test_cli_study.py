"""Commands about the study: what they answer and how they refuse."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from skewbridge.cli import build_app
from skewbridge.report.reference_pages import ROOT
from skewbridge.study.config import load_config
from skewbridge.study.journal import open_journal

runner = CliRunner()


@pytest.fixture(autouse=True)
def in_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def answer(*arguments: str) -> dict:
    result = runner.invoke(build_app(), [*arguments, "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def test_the_plan_of_the_default_study_counts_its_analyses() -> None:
    plan = answer("plan")
    count = load_config(ROOT / "config/config.yaml").motions.count
    assert count is not None
    assert plan["variants"] == 24
    assert plan["analyses"] == 24 * count
    assert plan["done"] + plan["left"] == plan["analyses"]
    assert {"failed", "suspect", "core_hours", "eta_s", "disk_mb"} <= set(plan)


def test_the_doctor_finds_a_working_environment() -> None:
    report = answer("doctor")
    assert report["ok"]
    assert report["self_test"] == "passed"


def test_a_bad_configuration_ends_with_2_and_one_message(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text("grid: {skew_deg: [75]}")
    result = runner.invoke(build_app(), ["plan", "--config", str(path), "--json"])
    assert result.exit_code == 2
    assert "got 75" in json.loads(result.stdout)["message"]


def test_a_missing_configuration_is_named(tmp_path: Path) -> None:
    result = runner.invoke(build_app(), ["status", "--config", str(tmp_path / "none.yaml")])
    assert result.exit_code == 2
    assert "none.yaml" in result.stderr


@pytest.fixture
def failed_study(tmp_path: Path) -> Path:
    """A configuration whose journal has a result, a crash and a torn line."""
    config = tmp_path / "mine.yaml"
    config.write_text(f"results: {tmp_path}/results\n")
    path = tmp_path / "results" / "journal" / "v.jsonl"
    with open_journal(path) as journal:
        for key, status in (("a", "ok"), ("b", "crash")):
            row = {"run_key": key, "status": status, "variant": "v", "motion_id": "m"}
            journal.append(row)
    path.write_bytes(path.read_bytes() + b'{"run_key": "c')
    return config


def test_failed_analyses_are_tried_again_on_request(failed_study: Path) -> None:
    told = answer("retry", "--config", str(failed_study))
    assert told["analyses"] == [{"variant": "v", "motion": "m", "status": "crash"}]
    assert answer("retry", "--config", str(failed_study))["forgotten"] == 0
    refused = runner.invoke(build_app(), ["retry", "--status", "ok"])
    assert refused.exit_code == 2
    assert "must be failed or one of" in refused.stderr


def test_journals_are_counted_and_compacted(failed_study: Path) -> None:
    counted = {"analyses": 2, "repeated": 0, "outdated": 0, "damaged": 1}
    config = ("--config", str(failed_study))
    assert answer("journal", *config) == counted | {"compacted": False}
    assert answer("journal", "--compact", *config) == counted | {"compacted": True}
    assert answer("journal", *config)["damaged"] == 0
