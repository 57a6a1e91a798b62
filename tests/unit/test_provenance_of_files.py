"""Every artefact has its provenance, and whether it is still what would be made."""

import json
import logging
import os
import platform
import signal
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
from skewbridge.files.digests import engine_digest, layer_digest, provenance
from skewbridge.files.tables import figure_metadata, read_frame, read_stamp, stamp, write_frame
from skewbridge.study import products
from skewbridge.study.config import load_config
from skewbridge.study.products import RECIPES, made_from, rule_digest
from skewbridge.study.session import script_session

ROOT = Path(__file__).parents[2]
SAID = {"rule": "fit_fragility", "title": 'a <script> & "quotes"', "rule_digest": "0" * 16}
FRAME = pd.DataFrame({"theta": [0.5, 0.7]})
RULE = "collect_demands"
runner = CliRunner()


@pytest.fixture(autouse=True)
def in_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def artefact(folder: Path, ending: str, metadata: dict[str, str] | None = None) -> Path:
    """Write a small file of each kind; figures have their provenance when they are saved."""
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
        figure.savefig(path, metadata=figure_metadata(metadata or {}))
    return path


@pytest.mark.parametrize("ending", [".parquet", ".json", ".html"])
def test_a_later_stamp_replaces_an_earlier_one(tmp_path, ending):
    path = artefact(tmp_path, ending)
    stamp(path, {"rule": "an older one, longer than the newer"})
    once = path.stat().st_size
    stamp(path, SAID)
    assert SAID.items() <= read_stamp(path).items()
    stamp(path, {"rule": "an older one, longer than the newer"})
    if ending != ".parquet":  # there, names that are not given again stay
        assert path.stat().st_size == once
    assert read_stamp(path)["rule"] == "an older one, longer than the newer"


@pytest.mark.parametrize("ending", [".svg", ".png"])
def test_a_figure_has_its_provenance_in_the_metadata_of_its_format(tmp_path, ending):
    path = artefact(tmp_path, ending, SAID)
    before = path.read_bytes()
    stamp(path, {"rule": "another"})
    assert path.read_bytes() == before
    assert read_stamp(path) == SAID


def test_the_content_of_a_file_is_kept(tmp_path):
    image, table, content = (artefact(tmp_path, end) for end in (".png", ".parquet", ".json"))
    before = imread(image)
    for path in (image, table, content):
        stamp(path, SAID)
    np.testing.assert_array_equal(imread(image), before)
    pd.testing.assert_frame_equal(read_frame(table), FRAME)
    assert read_stamp(table)["made_for"] == "another digest"
    assert json.loads(content.read_text())["passed"]


@pytest.mark.parametrize("name", ["rows.csv", "list.json"])
def test_a_format_without_metadata_is_left_as_it_is(tmp_path, name):
    path = tmp_path / name
    path.write_text("[1, 2]")
    stamp(path, SAID)
    assert path.read_text() == "[1, 2]"
    with pytest.raises(InputError, match="has no provenance"):
        read_stamp(path)


@pytest.mark.parametrize("name", ["missing.parquet", "broken.parquet", "broken.json", "none.csv"])
def test_a_file_that_cannot_be_read_is_bad_input(tmp_path, name):
    if name.startswith("broken"):
        (tmp_path / name).write_text("{{")
    with pytest.raises(InputError, match=name):
        read_stamp(tmp_path / name)


def test_the_machine_is_described_without_its_name():
    told = provenance()
    assert {"git_commit", "git_dirty", "processor", "processors", "openseespy_version"} <= set(told)
    text = json.dumps(told)
    assert platform.node() not in text
    assert str(Path.cwd()) not in text


def job(folder: Path, table: Path, **made: str) -> SimpleNamespace:
    """What Snakemake gives the script of a rule."""
    sources = layer_digest(RECIPES[RULE].sources)
    return SimpleNamespace(
        rule=RULE,
        threads=1,
        log=[folder / "rule.log"],
        input={},
        output=Named(table),
        # as merged over the shipped configuration
        config={"motions": {"count": 3}, "uncertainty": {"enabled": True}},
        params=SimpleNamespace(
            results=str(folder), made_from={"sources": sources, "motions": "suite", **made}
        ),
    )


class Named(list):
    """Outputs as Snakemake has them: a list whose items may have names."""

    def __init__(self, table: Path) -> None:
        super().__init__([str(table)])
        self.named = {"table": str(table)}

    def items(self):
        return self.named.items()


def test_a_script_stamps_its_outputs_when_it_is_through(tmp_path):
    table = tmp_path / "table.parquet"
    given = job(tmp_path, table, suspect="x")
    with script_session(given) as own:
        assert own.outputs == {"table": table}
        assert own.folder.root == tmp_path
        write_frame(FRAME, table, {})
    told = read_stamp(table)
    assert told["rule_digest"] == rule_digest(given.params.made_from)
    assert told["suite_digest"] == "suite"
    assert {"config_digest", "openseespy_version", "git_commit"} <= set(told)


def test_a_script_whose_sources_were_edited_meanwhile_stops(tmp_path, capsys):
    given = job(tmp_path, tmp_path / "table.parquet", sources="as they were")
    with pytest.raises(SystemExit) as stopped, script_session(given):
        pytest.fail("it began")
    assert stopped.value.code == 2
    assert "the sources were edited while the study ran" in capsys.readouterr().err


def test_a_script_without_messages_leaves_no_log_not_even_that_of_the_last_run(tmp_path):
    table, log = tmp_path / "table.parquet", tmp_path / "rule.log"
    for message in ("17 rows left out", ""):
        with script_session(job(tmp_path, table)):
            write_frame(FRAME, table, {})
            if message:
                logging.getLogger("skewbridge.fit").info(message)
        assert log.exists() == bool(message)


@pytest.mark.parametrize(
    ("error", "code"),
    [(InputError("bad input"), 2), (SolutionError("checks failed"), 1), (None, 130)],
)
def test_a_failed_script_ends_with_its_message_and_code(tmp_path, capsys, error, code):
    # A shell starts background processes with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def fail():
        if error:
            raise error
        os.kill(os.getpid(), signal.SIGINT)

    with (
        pytest.raises(SystemExit) as stopped,
        script_session(job(tmp_path, tmp_path / "none.parquet")),
    ):
        fail()
    signal.signal(signal.SIGINT, before)
    assert stopped.value.code == code
    assert capsys.readouterr().err == f"{error or 'interrupted; finished analyses are kept'}\n"


@pytest.fixture
def of_study(tmp_path, monkeypatch) -> Path:
    """A table of a study whose workflow would make it again the same."""
    table = tmp_path / "table.parquet"
    given = job(tmp_path, table)
    with script_session(given):
        write_frame(FRAME, table, {})
    monkeypatch.setattr(products, "made_from", lambda _: {RULE: given.params.made_from})
    return table


def answered(path: Path, config: str = "") -> tuple[int, dict]:
    named = path.parent / "study.yaml"
    named.write_text(config or "motions: {count: 3}")
    arguments = ["provenance", str(path), "--study", str(named), "--json"]
    result = runner.invoke(build_app(), arguments)
    return result.exit_code, json.loads(result.stdout)


def test_a_table_is_current_until_its_rule_would_make_another(of_study, monkeypatch):
    code, answer = answered(of_study)
    assert (code, answer["current"], answer["differences"]) == (0, True, [])
    code, answer = answered(of_study, "motions: {count: 3}\nfigures: {width_mm: 85}")
    assert (code, answer["current"], answer["differences"]) == (0, True, ["config_digest"])
    made = {"motions": "suite", "sources": "edited"}
    monkeypatch.setattr(products, "made_from", lambda _: {RULE: made})
    code, answer = answered(of_study)
    assert (code, answer["current"], answer["differences"]) == (1, False, ["rule_digest"])


def test_a_file_of_another_configuration_asks_for_it(of_study, monkeypatch):
    monkeypatch.setattr(products, "made_from", lambda _: {RULE: {"motions": "others"}})
    result = runner.invoke(build_app(), ["provenance", str(of_study)])
    assert result.exit_code == 1
    assert "compared with config/config.yaml" in result.stderr
    assert "--study" in result.stderr


@pytest.mark.parametrize(("engine", "code"), [(None, 0), ("of older sources", 1)])
def test_a_result_of_one_run_is_current_while_the_engine_is(tmp_path, engine, code):
    path = tmp_path / "histories.parquet"
    digest = engine or engine_digest()
    write_frame(FRAME, path, provenance(run_key="k", engine_digest=digest))
    assert answered(path)[0] == code


def test_a_file_without_provenance_is_bad_input(tmp_path):
    path = tmp_path / "old.parquet"
    write_frame(FRAME, path, provenance())
    assert answered(path)[0] == 2
    assert answered(tmp_path / "none.png")[0] == 2


def studied(folder: Path, text: str = "") -> dict[str, dict[str, str]]:
    config = folder / "mine.yaml"
    config.write_text(f"results: {folder}/results\nmotions: {{count: 2}}\n{text}")
    return made_from(load_config(config, base=ROOT / "config/config.yaml"))


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("", set()),
        ("batches: {no_progress_s: 7}", set()),
        ("figures: {width_mm: 85}", {"figures", "report"}),
        ("sensitivity: {rows: 1}", {"sensitivity", "report"}),
        (
            "fragility: {margin: 0.07}",
            {
                *("fit_fragility", "check_predict", "figures", "report"),
                *("plan_round", "collect_rounds"),
            },
        ),
        (  # the plans of rounds read the new demands
            "model: {cohesion_n: 5.0}",
            set(RECIPES)
            - {"prepare_motions", "verify_contact", "verification"}
            - {"plan_round", "collect_rounds"},
        ),
    ],
)
def test_a_key_of_the_configuration_changes_the_rules_that_use_it(tmp_path, text, changed):
    before, after = studied(tmp_path), studied(tmp_path, text)
    assert {rule for rule in before if before[rule] != after[rule]} == changed
