"""Commands about the study: what they answer and how they refuse."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from skewbridge.cli import build_app
from skewbridge.report.reference_pages import ROOT
from skewbridge.study.config import load_config

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
