"""Rules that judge statements of the paper, and the rows that report the verdicts."""

import pandas as pd
import pytest
import yaml
from reference_pages import ROOT

from cli_json import invoke, run
from skewbridge.errors import InputError
from skewbridge.verification import registry, statements
from skewbridge.verification.registry import COLUMNS, Study
from skewbridge.verification.statements import RULES, STATEMENTS, Run, Verdict
from skewbridge.verification.studies.paper_runs import SCALES

X = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


@pytest.mark.parametrize(
    ("rule", "numbers", "outcome"),
    [
        *yaml.safe_load((ROOT / "tests/unit/statement_rules.yaml").read_text()),
        # an increase disagrees under any record
        *(("reduced by", (value, 1.0, 0.015, 0.035, same_record), outcome)
          for value, same_record, outcome in (
              (0.975, True, "agrees"), (1.025, True, "disagrees"), (0.9, True, "disagrees"),
              (0.998, True, "disagrees"), (0.9, False, "undecidable"), (1.1, False, "disagrees"))),
        ("grows", (X, [2.0, 1.0, 4.0, 3.0, 6.0, 5.0]), "agrees"),
        ("grows", (X, [-value for value in X]), "disagrees"),
        ("grows", (X[:3], X[:3]), "undecidable"),
        ("grows", (X, [3.0, 1.0, 5.0, 2.0, 6.0, 1.5]), "undecidable"),  # not significant
        pytest.param(
            "grows", (X, [1.0] * 6), "undecidable",
            marks=pytest.mark.filterwarnings("ignore:An input array is constant"),
        ),
    ],
)  # fmt: skip
def test_each_rule_has_one_outcome(rule, numbers, outcome):
    given = {}
    if rule == "reduced by":
        *numbers, given["same_record"] = numbers
    assert RULES[rule](*numbers, **given).outcome == outcome


def test_every_statement_names_a_study_a_number_and_its_place_in_the_paper():
    table = pd.DataFrame(list(STATEMENTS.values()))
    assert set(table["study"]) <= registry.STUDIES.keys()
    assert (table["number"].astype(bool) & table["place"].str.match("section [2-5]")).all()
    assert not table[["claim", "study", "number"]].duplicated().any()


def test_statement_without_verdict_is_left_open_with_the_reason():
    study = Study("fig7-8")
    study.states("skew deck rotates", "gap 3 mm", 2.0)
    rows = {row["quantity"]: row for row in study.statement_rows("the study stopped")}
    assert len(rows) == sum(found.study == "fig7-8" for found in STATEMENTS.values())
    names = ("skew deck rotates", "test forces", "acute corner moves away")
    rotates, forces, corner = (rows[STATEMENTS[name].claim] for name in names)
    assert rotates["outcome"] == "agrees"
    assert "not public" in forces["reason"]
    assert corner["reason"] == "the study stopped"
    with pytest.raises(KeyError):
        study.states("no such statement", "", 1.0)


def verify(monkeypatch, folder, *, truth):
    def run_study(name, *_):
        study = Study(name)
        study.holds("the model works", truth=truth, source="closed form")
        study.report("not compared", 2.0, 1.0, "table")
        study.states("transverse peak", "skew 0", 1.2, 1.0)
        study.states("in phase differs most", "skew 0", X[:3], X[:3])
        return study

    monkeypatch.setattr(registry, "run_study", run_study)
    return run("verify", "restitution", "--out", folder)


def test_disagreement_is_reported_and_only_a_failed_check_fails(monkeypatch, tmp_path):
    code, (check, _, peak, open_row) = verify(monkeypatch, tmp_path, truth=True)
    assert (code, list(check)) == (0, list(COLUMNS))
    assert "no limit" in invoke("verify", "restitution", "--out", tmp_path).stdout
    assert set(COLUMNS) < set(peak)
    assert (peak["outcome"], peak["value"]) == ("disagrees", pytest.approx(1.2))
    assert peak["reason"] == "transverse peak: changes by +20.0%"
    assert open_row["value"] is None
    table, checks = (pd.read_parquet(tmp_path / f"{n}.parquet") for n in ("statements", "studies"))
    assert table["outcome"].tolist() == ["disagrees", "undecidable"]
    assert checks["quantity"].tolist() == ["the model works", "not compared"]
    assert verify(monkeypatch, tmp_path, truth=False)[0] == 1


def test_long_studies_run_only_when_named(monkeypatch, tmp_path):
    ran = []
    monkeypatch.setattr(registry, "run_study", lambda name, *_: ran.append(name) or Study(name))
    registry.run_studies([], tmp_path)
    assert ran == list(registry.STUDIES)
    registry.run_studies(["accuracy"], tmp_path)
    assert ran[-1] == "accuracy"
    with pytest.raises(InputError, match=r"published-skew, .*accuracy"):
        registry.run_studies(["nothing"], tmp_path)


def runs(outcomes: str, others: str = "") -> dict[Run, Verdict | None]:
    """Verdicts by their first letter, - without the premise: scales from 0.95 on, other motions."""
    names = {"a": "agrees", "d": "disagrees", "u": "undecidable"}
    keys = [Run(f"scale {scale:g}", scale) for scale in SCALES[: len(outcomes)]]
    keys += [Run(f"syn{number:03d}") for number in range(len(others))]
    return {key: None if sign == "-" else Verdict(names[sign], "a number", 0.9, 1.0)
            for key, sign in zip(keys, outcomes + others, strict=True)}  # fmt: skip


@pytest.mark.parametrize(
    ("scales", "others", "outcome"),
    [
        ("aaaaaaa", "aaaaa", "agrees"), ("aaaaaaa", "aaaad", "agrees"),  # 11 of 12
        ("aaaaaaa", "aaadd", "undecidable"), ("aaaaaad", "", "undecidable"),  # 10 of 12, 6 of 7
        ("aaaaaau", "aaaau", "undecidable"), ("ddddddd", "ddddu", "disagrees"),
        # runs without the premise do not count
        ("aaaaaaa", "-----", "agrees"), ("aaaaaa-", "-----", "undecidable"),
        ("-------", "-----", "undecidable"),
    ],
)  # fmt: skip
def test_nine_in_ten_runs_decide_a_case(scales, others, outcome):
    assert statements.over_runs(runs(scales, others)).outcome == outcome


def test_runs_of_a_case_become_one_row_that_counts_those_that_agree():
    found = statements.over_runs(runs("aaaaadu", "aad--"))
    assert (found.scales, found.motions) == ((7, 5), (3, 2))
    assert (found.value, found.reference) == (0.9, 1.0)
    assert "5 of 7 scales, 2 of 3 other motions" in found.reason
    assert "only 3 of 7 runs meet the premise" in statements.over_runs(runs("aaa----")).reason
    study = Study("fig10")
    for scale in SCALES:
        run = Run(f"scale {scale:g}", scale)
        study.states("transverse peak", "skew 0", 0.9, 1.0, run=run)
        study.states("several contacts", "skew 0", 9, run=run, premise=scale > 1.0)
    rows = {row["quantity"]: row for row in study.statement_rows() if row["case"]}
    assert len(rows) == 2
    peak, contacts = (rows[STATEMENTS[n].claim] for n in ("transverse peak", "several contacts"))
    assert (peak["outcome"], peak["scales"], peak["scales_agree"]) == ("agrees", 7, 7)
    assert (contacts["outcome"], contacts["scales"]) == ("undecidable", 3)
