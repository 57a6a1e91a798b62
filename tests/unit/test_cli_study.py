"""Commands about the study: what they answer and how they refuse."""

import json
import logging
from pathlib import Path

import pytest
from reference_pages import ROOT
from typer.testing import CliRunner

from skewbridge.cli import build_app
from skewbridge.cli.options import config_of, folder_of
from skewbridge.demands.columns import COLUMNS
from skewbridge.errors import InputError
from skewbridge.study.analyses import JobProgress, StudySetup
from skewbridge.study.config import load_config
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.journal import open_journal
from skewbridge.study.session import for_terminal
from skewbridge.study.task import run_key
from skewbridge.variant.grid import expand_grid

runner = CliRunner()
BASE = ROOT / "config/config.yaml"
COLUMN_NAMES = [column.name for column in COLUMNS]


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
    told = answer("study", "retry", "--study", str(failed_study))
    assert told["analyses"] == [{"variant": "v", "motion": "m", "status": "crash"}]
    assert answer("study", "retry", "--study", str(failed_study))["forgotten"] == 0
    refused = runner.invoke(build_app(), ["study", "retry", "--status", "ok"])
    assert refused.exit_code == 2
    assert "must be failed or one of" in refused.stderr


def test_journals_are_counted_and_compacted(failed_study: Path) -> None:
    counted = {"analyses": 2, "repeated": 0, "outdated": 0, "damaged": 1}
    config = ("--study", str(failed_study))
    assert answer("study", "journal", *config) == counted | {"compacted": False}
    assert answer("study", "journal", "--compact", *config) == counted | {"compacted": True}
    assert answer("study", "journal", *config)["damaged"] == 0


def test_a_study_is_named_by_its_folder_or_its_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("motions: {count: 2}")
    (tmp_path / "config/mine.yaml").write_text("results: results/mine\ngrid: {skew_deg: [30]}")
    (tmp_path / "config/states.yaml").write_text("- not a configuration")
    monkeypatch.chdir(tmp_path)
    mine = Path("config/mine.yaml")
    assert config_of(None) == config_of(Path("results")) == Path("config/config.yaml")
    assert config_of(mine) == config_of(Path("results/mine/")) == mine
    assert folder_of(None) == Path("results")
    assert folder_of(mine) == folder_of(Path("results/mine")) == Path("results/mine")
    with pytest.raises(InputError, match=r"no file in config/ with .results: elsewhere"):
        config_of(Path("elsewhere"))
    (tmp_path / "config/copy.yaml").write_text("results: results/mine")
    with pytest.raises(InputError, match="2 files in config/"):
        config_of(Path("results/mine"))


def test_a_mistyped_key_gets_a_suggestion(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text("model: {bakfill: sdc}\ngird: {}\n")
    result = runner.invoke(build_app(), ["plan", "--config", str(path)])
    assert "model.bakfill: unknown key (did you mean model.backfill?)" in result.stderr
    assert "gird: unknown key (did you mean grid?)" in result.stderr


def test_new_gap_repeats_no_finished_analysis(tmp_path: Path) -> None:
    axes = "skew_deg: [0], gap_mm: [25], friction: [0.5]"
    grid = f"grid: {{bridge: [osb1], abutment: [contact_friction], {axes}}}\n"
    config = tmp_path / "mine.yaml"
    config.write_text(f"results: {tmp_path}/results\n{grid}motions: {{count: 2}}\n")
    slug = next(iter(expand_grid(load_config(config, base=BASE).grid))).slug
    study = load_config(config, base=BASE)
    prepare_motions(study)
    tasks = StudySetup.of(study).tasks(slug)
    keys = dict(zip(map(run_key, tasks), ("ok", "timeout"), strict=True))
    with open_journal(tmp_path / "results/journal/v.jsonl") as journal:
        for key, status in keys.items():
            row = {"run_key": key, "status": status, "variant": slug, "motion_id": "m"}
            row |= {"cpu_s": 2.0, "recovery_rung": 0, "collapse_criterion": "budget"}
            journal.append(dict.fromkeys(COLUMN_NAMES) | row)
    config.write_text(config.read_text().replace("[25]", "[25, 51]"))
    found = answer("status", "--config", str(config))
    assert {name: found[name] for name in ("variants", "analyses", "done", "failed", "left")} == {
        "variants": 2, "analyses": 4, "done": 2, "failed": 1, "left": 2,
    }  # fmt: skip
    last = found["last_failure"]
    assert (last["variant"], last["status"], last["reason"]) == (slug, "timeout", "budget")
    failed = answer("status", "--failed", "--config", str(config))
    assert [row["command"] for row in failed["analyses"]] == [
        f"skewbridge run --row {key} --out row_{key}" for key in list(keys)[1:]
    ]


def test_a_run_tells_how_far_each_variant_is(capsys: pytest.CaptureFixture[str]) -> None:
    terminal = logging.StreamHandler()
    terminal.addFilter(for_terminal)
    logger = logging.getLogger("skewbridge")
    logger.setLevel(logging.INFO)
    logger.addHandler(terminal)
    try:
        with JobProgress("osb1_v", ["a", "b", "c", "d", "e", "f"], 4) as progress:
            progress.advance({"run_key": "a", "status": "ok"})
            progress.advance({"run_key": "of a search", "status": "ok"})
        logging.getLogger("skewbridge.other").info("for the log file alone")
    finally:
        logger.removeHandler(terminal)
    told = capsys.readouterr().err
    assert "osb1_v: 5 of 6 analyses done (4 of them before), " in told
    assert "min left" in told
    assert "per minute" in told
    assert "for the log file" not in told
