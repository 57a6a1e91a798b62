"""Every artefact says where it comes from, and whether it is still what would be made."""

import json
import logging
import platform
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from typer.testing import CliRunner

from skewbridge.cli import build_app
from skewbridge.errors import InputError, SolutionError
from skewbridge.provenance.digests import source_digest
from skewbridge.provenance.stamp import read_stamp, stamp
from skewbridge.provenance.tables import provenance, read_frame, write_frame
from skewbridge.study import origin
from skewbridge.study.keys import ANALYSIS_MODULE
from skewbridge.study.made_for import CONFIG_KEY, TOLD_TO, tell_rules
from skewbridge.study.session import script_session

SAID = {"rule": "fit_fragility", "title": 'a <script> & "quotes"', "rule_digest": "0" * 16}
FRAME = pd.DataFrame({"theta": [0.5, 0.7]})
runner = CliRunner()


def artefact(folder: Path, ending: str) -> Path:
    """Write a small file of each kind."""
    path = folder / f"file{ending}"
    if ending == ".parquet":
        write_frame(FRAME, path, {"made_for": "another digest"})
    elif ending == ".json":
        path.write_text('{"passed": true}')
    elif ending == ".html":
        path.write_text('<!doctype html>\n<html lang="en"><head>\n<title>t</title></head></html>')
    else:
        figure = Figure(figsize=(1, 1))
        figure.subplots().plot([0, 1])
        figure.savefig(path)
    return path


@pytest.mark.parametrize("ending", [".parquet", ".json", ".html", ".svg", ".png"])
def test_a_file_tells_what_was_written_into_it_and_what_was_written_last(tmp_path, ending):
    path = artefact(tmp_path, ending)
    stamp(path, {"rule": "an older one, longer than the newer"})
    once = path.stat().st_size
    stamp(path, SAID)
    told = read_stamp(path)
    assert SAID.items() <= told.items()
    stamp(path, {"rule": "an older one, longer than the newer"})
    if ending != ".parquet":  # there, names that are not given again stay
        assert path.stat().st_size == once
    assert read_stamp(path)["rule"] == "an older one, longer than the newer"


def test_what_a_file_holds_stays(tmp_path):
    image, table, content = (artefact(tmp_path, end) for end in (".png", ".parquet", ".json"))
    before = imread(image)
    stamp(tmp_path, SAID)
    np.testing.assert_array_equal(imread(image), before)
    pd.testing.assert_frame_equal(read_frame(table), FRAME)
    assert read_stamp(table)["made_for"] == "another digest"
    assert json.loads(content.read_text())["passed"]


@pytest.mark.parametrize("name", ["rows.csv", "list.json"])
def test_a_format_without_a_place_for_it_is_left_as_it_is(tmp_path, name):
    path = tmp_path / name
    path.write_text("[1, 2]")
    stamp(path, SAID)
    assert path.read_text() == "[1, 2]"
    with pytest.raises(InputError, match="does not say"):
        read_stamp(path)


@pytest.mark.parametrize("name", ["missing.parquet", "broken.parquet", "broken.json", "none.csv"])
def test_a_file_that_cannot_be_read_is_bad_input(tmp_path, name):
    if name.startswith("broken"):
        (tmp_path / name).write_text("{{")
    with pytest.raises(InputError, match=name):
        read_stamp(tmp_path / name)


def test_the_machine_is_told_without_its_name():
    told = provenance()
    assert {"git_commit", "git_dirty", "processor", "processors", "openseespy_version"} <= set(told)
    text = json.dumps(told)
    assert platform.node() not in text
    assert str(Path.cwd()) not in text


def rules(**params):
    config = {"grid": {"gap_mm": [25]}, "results": "here", **params.pop("config", {})}
    tell_rules(config, {"fit": params, "part": {}}, "suite")
    return config[CONFIG_KEY]


def test_the_digest_of_a_rule_is_that_of_its_parameters_without_places():
    first = rules(level=0.9, results=lambda _: "here")
    assert first["rules"].keys() == {"fit"}
    assert rules(level=0.9, results=lambda _: "there", config={"results": "there"}) == first
    assert rules(level=0.95)["rules"] != first["rules"]
    other_bridge = rules(level=0.9, config={"grid": {"gap_mm": [51]}})
    assert other_bridge["rules"] == first["rules"]
    assert other_bridge["config_digest"] != first["config_digest"]


def job(folder: Path, table: Path, rule: str = "fit") -> SimpleNamespace:
    log = folder / "rule.log"
    return SimpleNamespace(rule=rule, log=[log], output=[table], config={CONFIG_KEY: rules(x=1)})


def test_a_script_marks_its_outputs_when_it_is_through(tmp_path):
    table = tmp_path / "table.parquet"
    with script_session(job(tmp_path, table)):
        write_frame(FRAME, table, {})
    told = read_stamp(table)
    assert told["rule_digest"] == rules(x=1)["rules"]["fit"]
    assert told["suite_digest"] == "suite"
    assert {"config_digest", "openseespy_version", "git_commit"} <= set(told)


def test_a_script_without_messages_leaves_no_log_not_even_that_of_the_last_run(tmp_path):
    table, log = tmp_path / "table.parquet", tmp_path / "rule.log"
    for message in ("17 rows left out", ""):
        with script_session(job(tmp_path, table)):
            write_frame(FRAME, table, {})
            if message:
                logging.getLogger("skewbridge.fit").info(message)
        assert log.exists() == bool(message)


def test_what_failed_ends_with_its_sentence_and_its_code(tmp_path, capsys):
    for error, code in ((InputError("bad input"), 2), (SolutionError("checks failed"), 1)):
        with (
            pytest.raises(SystemExit) as stopped,
            script_session(job(tmp_path, tmp_path / "none.parquet")),
        ):
            raise error
        assert stopped.value.code == code
        assert str(error) in capsys.readouterr().err


@pytest.fixture
def of_study(tmp_path, monkeypatch) -> Path:
    """A table of a study whose workflow would make it from the parameter x = 1."""
    table = tmp_path / "table.parquet"
    with script_session(job(tmp_path, table)):
        write_frame(FRAME, table, {})
    monkeypatch.setattr(origin, "present", lambda _config: rules(x=1))
    return table


def answered(path: Path) -> tuple[int, dict]:
    result = runner.invoke(build_app(), ["provenance", str(path), "--json"])
    return result.exit_code, json.loads(result.stdout)


def test_a_table_is_current_until_its_rule_would_make_another(of_study, monkeypatch):
    code, answer = answered(of_study)
    assert (code, answer["current"], answer["differences"]) == (0, True, [])
    monkeypatch.setattr(origin, "present", lambda _: rules(x=1, config={"fragility": {"level": 1}}))
    code, answer = answered(of_study)
    assert (code, answer["current"], answer["differences"]) == (0, True, ["config_digest"])
    monkeypatch.setattr(origin, "present", lambda _config: rules(x=2))
    code, answer = answered(of_study)
    assert (code, answer["current"], answer["differences"]) == (1, False, ["rule_digest"])


def test_a_file_of_another_configuration_asks_for_it(of_study, monkeypatch):
    monkeypatch.setattr(origin, "present", lambda _: rules(x=2, config={"fragility": {"level": 1}}))
    result = runner.invoke(build_app(), ["provenance", str(of_study)])
    assert result.exit_code == 1
    assert "compared with config/config.yaml" in result.stderr
    assert "name another study with --study" in result.stderr


@pytest.mark.parametrize(("engine", "code"), [(None, 0), ("of older sources", 1)])
def test_a_result_of_one_run_is_current_while_the_engine_is(tmp_path, engine, code):
    path = tmp_path / "histories.parquet"
    digest = engine or source_digest(ANALYSIS_MODULE)
    write_frame(FRAME, path, provenance(run_key="k", engine_digest=digest))
    assert answered(path)[0] == code


def test_a_file_that_says_too_little_is_bad_input(tmp_path):
    path = tmp_path / "old.parquet"
    write_frame(FRAME, path, provenance())
    assert answered(path)[0] == 2
    assert answered(tmp_path / "none.png")[0] == 2


def test_the_workflow_tells_what_it_would_make(tmp_path, monkeypatch):
    root = Path(__file__).parents[2]
    monkeypatch.chdir(root)
    monkeypatch.delenv(TOLD_TO, raising=False)
    told = origin.present(Path("config/smoke.yaml"))
    assert {"collect_demands", "fit_fragility", "figures", "report"} <= told["rules"].keys()
    bad = tmp_path / "bad.yaml"
    bad.write_text("grid: {gap_mm: [-1]}")
    with pytest.raises(InputError, match="gap_mm"):
        origin.present(bad)


def test_without_a_workflow_nothing_can_be_compared(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="no Snakefile here"):
        origin.present(Path("config/smoke.yaml"))
