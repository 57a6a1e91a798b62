"""Statistics of any table of demands, predictions from what they write, the table of a paper."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from fragility_tables import IM, synthetic_demands
from skewbridge.cli import build_app
from skewbridge.fragility.joint import JOINT_COLUMNS
from skewbridge.fragility.paper_table import PAPER_COLUMNS

LIMIT_STATES = """\
- component: column_drift
  demand: column_drift_ratio
  unit: percent
  dispersion: 0.35
  citation: a test
  states: {slight: 1.0, moderate: 2.5}
- component: shear_key
  demand: shear_key_disp_m
  unit: mm
  dispersion: 0.0
  citation: a test
  states: {slight: 25.0}
"""
#: What a table of demands needs; everything else may lack.
NEEDED = ["skew_deg", "gap_mm", "friction", "motion_id", "status", IM, "column_drift_ratio"]


@pytest.fixture(scope="module")
def app():
    return build_app()


@pytest.fixture(scope="module")
def written(app, tmp_path_factory):
    """A bare table of somebody else's runs, and what the command makes of it."""
    folder = tmp_path_factory.mktemp("statistics")
    demands = synthetic_demands(motions=14, skews=(0, 30, 60), gaps=(0, 51))
    demands[NEEDED].to_csv(folder / "runs.csv", index=False)
    (folder / "states.yaml").write_text(LIMIT_STATES)
    given = ["statistics", str(folder / "runs.csv"), "--out", str(folder / "out"), "--json"]
    found = CliRunner().invoke(app, [*given, "--limit-states", str(folder / "states.yaml")])
    assert found.exit_code == 0, found.output
    return folder, json.loads(found.stdout)


def predict(app, folder, *options):
    where = ["predict", "--study", str(folder), "--json", *options]
    found = CliRunner().invoke(app, where)
    return found.exit_code, json.loads(found.stdout)


PLACE = ("--skew-deg", "45", "--gap-mm", "40", "--friction", "0.3")


def test_every_table_is_written_and_missing_demands_are_listed(written):
    folder, report = written
    names = {path.name for path in (folder / "out").iterdir()}
    parquet = ("curves", "effects", "intensity_effects", "joint", "median_effects", "system")
    assert {*(f"{name}.parquet" for name in parquet), "table.csv", "table.tex"} <= names
    assert report["left_out"] == ["shear_key/slight (shear_key_disp_m)"]
    curves = pd.read_parquet(folder / "out" / "curves.parquet")
    assert report["status"] == curves["status"].value_counts().to_dict()
    effects = pd.read_parquet(folder / "out" / "effects.parquet")
    assert report["verdict"] == effects["verdict_family"].value_counts().to_dict()
    assert (report["rejected_rows"], report["notes"]) == (0, [])
    assert report["tables"]["curves"] == len(curves)
    joint = pd.read_parquet(folder / "out" / "joint.parquet")
    assert list(joint.columns) == list(JOINT_COLUMNS)


def test_predictions_are_those_of_the_joint_model(app, written):
    folder, _ = written
    code, found = predict(app, folder / "out", *PLACE, "--at", "0.6")
    assert code == 0
    assert [row["state"] for row in found["rows"]] == ["slight", "moderate"]
    for row in found["rows"]:
        assert row["ci_theta"][0] < row["theta"] < row["ci_theta"][1]
        assert row["beta_total"] == pytest.approx(np.hypot(row["beta"], 0.35), rel=0.1)
        assert 0.0 < row["p"] < 1.0
        assert 0.0 <= row["loo_error"] < 0.05
    # the generator: ln drift = ln 0.035 + ln im + 0.35 z, whatever the axes
    assert found["rows"][0]["theta"] == pytest.approx(0.01 / 0.035, rel=0.3)
    one = predict(app, folder / "out", *PLACE, "--component", "column_drift", "--state", "slight")
    assert [row["state"] for row in one[1]["rows"]] == ["slight"]
    assert one[1]["rows"][0]["p"] is None


def test_leave_one_out_error_is_not_an_error_message(app, written, tmp_path):
    table = pd.read_parquet(written[0] / "out" / "joint.parquet")
    table.assign(loo_error=np.nan).to_parquet(tmp_path / "joint.parquet")
    found = CliRunner().invoke(app, ["predict", "--study", str(tmp_path), *PLACE])
    assert found.exit_code == 0
    assert "nan" not in found.stdout
    assert found.stderr.startswith("left out: error of theta")


def test_a_folder_of_a_study_serves_as_well(app, written, tmp_path):
    folder, _ = written
    (tmp_path / "fragility").mkdir()
    (tmp_path / "fragility" / "joint.parquet").write_bytes(
        (folder / "out" / "joint.parquet").read_bytes()
    )
    assert predict(app, tmp_path, *PLACE) == predict(app, folder / "out", *PLACE)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--skew-deg", "61", "--gap-mm", "40", "--friction", "0.3"), "skew_deg must be within"),
        (("--skew-deg", "45", "--gap-mm", "60", "--friction", "0.3"), "gap_mm must be within"),
        (("--skew-deg", "45", "--gap-mm", "40"), "friction is missing"),
        ((*PLACE, "--bridge", "osb7"), "bridge must be one of"),
        ((*PLACE, "--abutment", "roller"), "abutment must be one of"),
        ((*PLACE, "--state", "total"), "limit_state must be one of"),
        ((*PLACE, "--at", "0"), "at must be > 0"),
        ((*PLACE, "--axis", "soil=1"), "soil is not an axis"),
    ],
)
def test_values_outside_the_study_are_refused(app, written, options, words):
    code, found = predict(app, written[0] / "out", *options)
    assert code == 2
    assert words in found["message"]


def test_a_folder_without_models_is_named(app, tmp_path):
    code, found = predict(app, tmp_path, *PLACE)
    assert code == 2
    assert "skewbridge statistics" in found["message"]
    assert "--study" in found["message"]


def test_rows_without_an_intensity_are_rejected_one_by_one(app, written, tmp_path):
    folder, first = written
    table = pd.read_csv(folder / "runs.csv")
    table.loc[5, IM] = np.nan
    table.to_csv(tmp_path / "runs.csv", index=False)
    given = ["statistics", str(tmp_path / "runs.csv"), "--out", str(tmp_path / "out"), "--json"]
    found = CliRunner().invoke(app, [*given, "--limit-states", str(folder / "states.yaml")])
    assert found.exit_code == 0, found.output
    report = json.loads(found.stdout)
    assert report["rejected_rows"] == 1
    assert "row 5" in report["notes"][0]
    assert report["tables"]["curves"] == first["tables"]["curves"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t.drop(columns="status"), "no column 'status'"),
        (lambda t: t.assign(status="fine"), "status"),
        (lambda t: t.drop(columns=["column_drift_ratio"]), "none of the demands"),
        (lambda t: t.drop(columns=[IM]), "at least one im_ column"),
        (lambda t: t.rename(columns={IM: "im_a_g"}).assign(im_b_g=1.0), "--im"),
        (lambda t: pd.concat([t, t]), "repeats"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused(app, written, tmp_path, change, words):
    change(pd.read_csv(written[0] / "runs.csv")).to_csv(tmp_path / "bad.csv", index=False)
    given = ["statistics", str(tmp_path / "bad.csv"), "--out", str(tmp_path / "out"), "--json"]
    found = CliRunner().invoke(app, [*given, "--limit-states", str(written[0] / "states.yaml")])
    assert found.exit_code == 2, found.output
    assert words in json.loads(found.stdout)["message"]


def test_the_table_of_a_paper_has_variants_and_joint_rows_with_ratios(written):
    folder, _ = written
    table = pd.read_csv(folder / "out" / "table.csv")
    assert list(table.columns) == list(PAPER_COLUMNS)
    slight = table[table["limit_state"] == "slight"]
    assert len(slight) == 13  # 12 variants and the joint model
    joint = slight[slight["row"] == "joint"].iloc[0]
    for name in ("skew", "gap", "friction"):
        low, middle, high = (joint[f"{name}_ratio{end}"] for end in ("_low", "", "_high"))
        assert low < middle < high
        assert low < 1.0 < high  # the generator: no axis acts on the drift
    variants = slight[slight["row"] != "joint"]
    # each axis: the smallest value has nothing to be compared with
    assert variants["friction_ratio"].notna().sum() == 6
    assert variants["skew_ratio"].notna().sum() == 8
    tex = (folder / "out" / "table.tex").read_text(encoding="utf-8")
    assert tex.count(r"\\") == len(table) + 1
    assert "& skew 60 deg, gap 51 mm, friction 0.5 & column drift, slight &" in tex
    assert r"\usepackage{booktabs,longtable}" in tex
    assert variants.groupby(["skew_deg", "gap_mm", "friction"]).ngroups == len(variants)
    assert joint[["skew_deg", "gap_mm", "friction"]].isna().all()


def test_joint_rows_compare_the_ends_of_an_axis_at_the_middle_of_the_others(app, written, tmp_path):
    """Friction 0 to 0.5 at skew 30 degrees, where it counts half as much as at 60 degrees."""
    demands = synthetic_demands(motions=14, skews=(0, 30, 60), gaps=(0, 51))
    demands["column_drift_ratio"] *= np.exp(0.02 * demands["skew_deg"] * demands["friction"])
    demands[NEEDED].to_csv(tmp_path / "runs.csv", index=False)
    given = ["statistics", str(tmp_path / "runs.csv"), "--out", str(tmp_path / "out"), "--json"]
    states = ["--limit-states", str(written[0] / "states.yaml")]
    assert CliRunner().invoke(app, [*given, *states]).exit_code == 0
    table = pd.read_csv(tmp_path / "out" / "table.csv")
    row = table[(table["row"] == "joint") & (table["limit_state"] == "slight")].iloc[0]
    middle = ("--skew-deg", "30", "--gap-mm", "25.5", "--state", "slight")
    medians = [
        predict(app, tmp_path / "out", *middle, "--friction", friction)[1]["rows"][0]["theta"]
        for friction in ("0", "0.5")
    ]
    assert row["friction_ratio"] == pytest.approx(medians[1] / medians[0], rel=1e-5)
    # the generator: demands grow by exp(0.02 x 30 x 0.5), medians fall as much
    assert row["friction_ratio"] == pytest.approx(np.exp(-0.3), rel=0.1)


def test_fit_prints_the_table_of_a_paper(app, written, tmp_path):
    folder, _ = written
    source = synthetic_demands(motions=14, skews=(0, 30, 60), gaps=(0, 51))
    source.to_parquet(tmp_path / "demands.parquet")
    given = ["fit", str(tmp_path / "demands.parquet"), "--paper-table", "--json"]
    found = CliRunner().invoke(app, [*given, "--limit-states", str(folder / "states.yaml")])
    assert found.exit_code == 0, found.output
    rows = json.loads(found.stdout)["rows"]
    assert {row["row"] for row in rows} >= {"joint"}
    assert set(rows[0]) == set(PAPER_COLUMNS)


def test_tables_of_the_command_are_those_of_the_rules():
    """Both call the same module."""
    root = Path(__file__).parents[2]
    text = (root / "workflow" / "scripts" / "fit_fragility.py").read_text(encoding="utf-8")
    assert "skewbridge.fragility.study_tables import" in text
