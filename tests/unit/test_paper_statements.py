"""How statements of the paper are judged, and what becomes of the judgements."""

import json

import pandas as pd
import pytest
from typer.testing import CliRunner

from skewbridge.cli import build_app
from skewbridge.verification import registry
from skewbridge.verification.judgement import (
    RESOLUTION,
    at_most,
    cannot_be_told,
    decided,
    grows_with,
    hardly_changed,
    lower,
    more_often,
    reduced_by,
)
from skewbridge.verification.paper import STATEMENTS, statements_of
from skewbridge.verification.studies.comparison import COLUMNS, Study


def test_a_lower_peak_agrees_a_higher_one_does_not_and_a_tiny_change_says_nothing():
    assert lower("peak", 0.9, 1.0).outcome == "agrees"
    assert lower("peak", 1.1, 1.0).outcome == "disagrees"
    assert lower("peak", 1.0 - 0.5 * RESOLUTION, 1.0).outcome == "cannot be told"
    assert lower("peak", 0.1, 0.0).outcome == "cannot be told"


@pytest.mark.parametrize(
    ("value", "outcome"),
    [(0.975, "agrees"), (1.025, "disagrees"), (0.9, "disagrees"), (0.998, "disagrees")],
)
def test_a_reduction_of_a_given_size_is_none_in_the_other_direction(value, outcome):
    judged = reduced_by("peak", value, 1.0, (0.015, 0.035), same_record=True)
    assert judged.outcome == outcome


def test_the_size_of_a_reduction_cannot_be_told_under_another_record_but_an_increase_can():
    limits = (0.015, 0.035)
    smaller = reduced_by("peak", 0.9, 1.0, limits, same_record=False)
    larger = reduced_by("peak", 1.1, 1.0, limits, same_record=False)
    assert (smaller.outcome, larger.outcome) == ("cannot be told", "disagrees")


def test_a_small_change_is_small_in_both_directions():
    assert hardly_changed("peak", 1.04, 1.0).outcome == "agrees"
    assert hardly_changed("peak", 0.94, 1.0).outcome == "disagrees"


def test_a_correlation_above_zero_that_chance_explains_proves_nothing():
    x = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert grows_with("y", x, [2.0, 1.0, 4.0, 3.0, 6.0, 5.0]).outcome == "agrees"
    assert grows_with("y", x, [-value for value in x]).outcome == "disagrees"
    weak = grows_with("y", x, [3.0, 1.0, 5.0, 2.0, 6.0, 1.5])
    assert weak.value is not None
    assert weak.value > 0.0
    assert weak.outcome == "cannot be told"
    assert "p = " in weak.reason
    assert grows_with("y", x[:3], x[:3]).outcome == "cannot be told"


def test_most_of_several_is_tested_for_chance():
    assert more_often("lower", 9, 10).outcome == "agrees"
    assert more_often("lower", 1, 10).outcome == "disagrees"
    assert more_often("lower", 6, 10).outcome == "cannot be told"
    assert more_often("lower", 3, 3).outcome == "cannot be told"


def test_every_statement_names_a_study_and_its_place_in_the_paper():
    for statement in STATEMENTS.values():
        assert statement.study in registry.STUDIES
        assert statement.place.startswith(("section 2", "section 3", "section 4", "section 5"))
    assert len({statement.claim for statement in STATEMENTS.values()}) == len(STATEMENTS)


def test_an_unknown_statement_is_refused():
    with pytest.raises(KeyError):
        Study("fig10").states("no such statement", "", decided(True, ""))


def test_what_a_study_does_not_judge_is_left_open_with_the_reason():
    study = Study("fig7-8")
    study.states("skew deck rotates", "gap 3 mm", at_most("rotation", 1.0, 2.0))
    study.leave_open("the study broke off")
    rows = {row["quantity"]: row for row in study.statement_rows()}
    assert len(rows) == len(statements_of("fig7-8"))
    assert rows[STATEMENTS["skew deck rotates"].claim]["outcome"] == "agrees"
    assert "not public" in rows[STATEMENTS["test forces"].claim]["reason"]
    assert rows[STATEMENTS["longer contact"].claim]["reason"] == "the study broke off"


@pytest.fixture
def short_study(monkeypatch, tmp_path):
    """Replace a study of the registry by one that holds and disagrees at once."""

    def run(name, _kept):
        study = Study(name)
        study.holds("the model works", truth=True, source="closed form")
        study.states("transverse peak", "skew 0", lower("transverse peak", 1.2, 1.0))
        study.states("static push", "skew 0", cannot_be_told("no push"))
        return study

    monkeypatch.setattr(registry, "run_study", run)
    return tmp_path


def test_a_disagreement_is_listed_and_fails_nothing(short_study):
    found = CliRunner().invoke(
        build_app(), ["verify", "fig10", "--out", str(short_study), "--json"]
    )
    assert found.exit_code == 0
    check, peak, push = json.loads(found.stdout)
    assert list(check) == list(COLUMNS)
    assert set(COLUMNS) < set(peak)
    assert peak["outcome"] == "disagrees"
    assert peak["value"] == pytest.approx(1.2)
    assert "+20.0%" in peak["reason"]
    assert push["value"] is None
    table = pd.read_parquet(short_study / "statements.parquet")
    assert table["outcome"].tolist() == ["disagrees", "cannot be told"]
    assert pd.read_parquet(short_study / "studies.parquet")["quantity"].tolist() == [
        "the model works"
    ]


def test_the_terminal_shows_both_tables(short_study):
    found = CliRunner().invoke(build_app(), ["verify", "fig10", "--out", str(short_study)])
    assert found.exit_code == 0
    assert "Verification" in found.stdout
    assert "Statements of the paper" in found.stdout
    assert "disagrees" in found.stdout


def test_a_failed_check_of_the_model_still_fails(monkeypatch, tmp_path):
    def run(name, _kept):
        study = Study(name)
        study.holds("the model works", truth=False, source="closed form")
        return study

    monkeypatch.setattr(registry, "run_study", run)
    found = CliRunner().invoke(build_app(), ["verify", "fig10", "--out", str(tmp_path), "--json"])
    assert found.exit_code == 1
