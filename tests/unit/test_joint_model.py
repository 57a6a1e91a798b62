"""Joint models over the axes, statistics of any table of demands, the table of a paper."""

import json
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import fragility_tables as made
import skewbridge
from cli_json import answer, invoke
from fragility_tables import DRIFT_ENTRY, FAILURES, IM, SETTINGS, synthetic_demands
from skewbridge.demands.validity import FAILURE_DEMANDS
from skewbridge.errors import InputError
from skewbridge.files.tables import write_frame
from skewbridge.fragility import demand_table
from skewbridge.fragility.exports import PAPER_COLUMNS, paper_table, with_interval
from skewbridge.fragility.joint import JOINT_COLUMNS, JointModel, joint_table
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.study_tables import write_tables

ROOT = Path(__file__).parents[2]
DRIFT = made.states_of("column_drift")
GRID = {"skews": (0, 20, 40, 60), "gaps": (0, 25, 51), "frictions": (0, 50), "motions": 24}
SMALL = {"skews": (0, 30, 60), "gaps": (51,), "frictions": (0, 50), "motions": 16}
KEY_ENTRY = DRIFT_ENTRY | {
    "component": "shear_key", "demand": "shear_key_disp_m", "unit": "mm", "states": {"slight": 25.0}
}  # fmt: skip
#: What a table of demands needs; everything else may lack.
NEEDED = ["skew_deg", "gap_mm", "friction", "motion_id", "status", IM, "column_drift_ratio"]
DEMANDS = synthetic_demands(motions=14, skews=(0, 30, 60), gaps=(0, 51))
PLACE = ("--skew-deg", "45", "--gap-mm", "40", "--friction", "0.3")


def shifted(table, effect):
    return table.assign(column_drift_ratio=table["column_drift_ratio"] * np.exp(effect(table)))


def joint(table, states=DRIFT):
    return joint_table(made.models_of(table, states), states, SETTINGS)


def row_of(table, name="moderate"):
    found = joint(table).query("limit_state == @name")
    assert len(found) == 1
    return found.iloc[0].to_dict()


def test_medians_between_the_variants_follow_the_generator():
    """The generator is quadratic in skew, linear in the gap, with friction acting at high skew."""

    def effect(t):
        skew, gap = t["skew_deg"] / 60.0, t["gap_mm"] / 50.8
        return 0.3 * skew**2 + 0.1 * gap + 0.4 * skew * t["friction"]

    row = row_of(shifted(synthetic_demands(**GRID), effect))
    model = JointModel(row)
    point = {"skew_deg": 45.0, "gap_mm": 40.0, "friction": 0.3}
    ratio, low, high = model.median(point, {"skew_deg": 0.0, "gap_mm": 0.0, "friction": 0.0}, 0.9)
    assert ratio == pytest.approx(np.exp(-effect(point) / row["slope"]), rel=0.02)
    assert low < ratio < high
    terms = {"skew_deg=40", "skew_deg=60:friction=0.5", "skew_deg:friction", "gap_mm=25:ln_im"}
    assert terms < set(row["terms"].split(";"))
    assert row["status"] == "ok"
    assert row["loo_error"] < 0.03


def test_negative_skews_count_by_size_unless_the_study_has_both_signs():
    model = JointModel(row_of(synthetic_demands(**SMALL | {"skews": (0, -30, -60)})))
    assert model.axis_range.limits["skew_deg"] == (0.0, 60.0)
    minus, plus = ({"friction": 0.5, "skew_deg": skew} for skew in (-45.0, 45.0))
    assert model.median(minus) == model.median(plus)
    both = synthetic_demands(**SMALL | {"skews": (-45, 0, 45)})
    row = row_of(shifted(both, lambda t: 0.3 * t["skew_deg"] / 60.0))
    model = JointModel(row)
    assert model.axis_range.limits["skew_deg"] == (-45.0, 45.0)
    apart = model.median(plus, minus, 0.95)
    assert apart[0] == pytest.approx(np.exp(-0.45 / row["slope"]), rel=0.03)


def test_demands_of_zero_are_left_censored():
    table = synthetic_demands(**SMALL)
    drift = table["column_drift_ratio"]
    assert (drift < 0.006).any()
    full = row_of(table)
    censored = row_of(table.assign(column_drift_ratio=drift.mask(drift < 0.006, 0.0)))
    assert (censored["status"], censored["theta"]) == ("ok", pytest.approx(full["theta"], rel=0.05))


def test_models_are_per_bridge_and_abutment_with_the_axes_they_have():
    friction = synthetic_demands(**SMALL)
    roller = friction[friction["friction"] == 0.0].assign(abutment="roller", gap_mm=0)
    roller["variant"] = roller["variant"].str.replace("_cf_", "_ro_")
    other = friction.assign(bridge="osb2", variant=friction["variant"] + "x")
    other["column_drift_ratio"] *= 2.0
    found = joint(pd.concat([friction, roller, other], ignore_index=True))
    assert list(found.columns) == list(JOINT_COLUMNS)
    own = found.query("limit_state == 'slight'").set_index(["bridge", "abutment"])
    first, second = ("osb1", "contact_friction"), ("osb2", "contact_friction")
    assert set(own.index) == {first, second, ("osb1", "roller")}
    assert list(json.loads(own.loc[("osb1", "roller"), "axis_ranges"])) == ["skew_deg"]
    ratio = own.loc[second, "theta"] / own.loc[first, "theta"]
    # the slope of the first variant and of the middle differ by the drift
    assert ratio == pytest.approx(0.5 ** (1.0 / own.loc[first, "slope"]), rel=0.02)


def test_states_without_an_estimate_or_with_large_errors_have_a_status():
    table = synthetic_demands(**SMALL)
    drift, found = table["column_drift_ratio"], joint(table).set_index("limit_state")
    assert found.loc[["moderate", "complete"], "status"].tolist() == ["ok", "no_exceedance"]
    assert np.isnan(found.loc["complete", "theta"])
    assert "non_increasing" in set(joint(table.assign(column_drift_ratio=3e-4 / drift))["status"])
    exact = joint(table.assign(column_drift_ratio=0.03 * table[IM]))["status"]
    assert "zero_dispersion" in set(exact)
    assert set(joint(table.assign(column_drift_ratio=1.0))["status"]) == {"all_exceed"}
    alone = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    assert {"no_axis_varies", "no_exceedance"} >= set(joint(alone)["status"])
    assert "ok" not in set(joint(synthetic_demands(**SMALL | {"motions": 4}))["status"])
    whole = synthetic_demands(**SMALL | {"gaps": (25, 51)})
    diagonal = whole[(whole["skew_deg"] == 0) == (whole["gap_mm"] == 25)]
    assert set(joint(diagonal)["status"]) == {"axes_change_together", "no_exceedance"}
    odd = table["variant"] == table["variant"].iloc[-1]
    row = row_of(table.assign(column_drift_ratio=drift.mask(odd, 1.6 * drift)))
    assert row["status"] == "prediction_error_above_25_percent"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("statistics")
    (folder / "states.yaml").write_text(json.dumps([DRIFT_ENTRY, KEY_ENTRY]))
    return folder, statistics(DEMANDS[NEEDED], folder, folder)


def statistics(table, folder, of_states, code=0):
    table.to_csv(folder / "runs.csv", index=False)
    states = ("--limit-states", of_states / "states.yaml")
    return answer("statistics", folder / "runs.csv", "--out", folder / "out", *states, code=code)


def predict(folder, *options, code=0):
    return answer("predict", "--study", folder, *options, code=code)


def table_of(folder, name):
    return pd.read_parquet(folder / "out" / "fragility" / f"{name}.parquet")


def test_predictions_are_those_of_the_joint_model(written, tmp_path):
    folder = written[0] / "out"
    found = predict(folder, *PLACE, "--at", "0.6")
    assert [row["state"] for row in found["rows"]] == ["slight", "moderate"]
    for row in found["rows"]:
        assert row["ci_theta"][0] < row["theta"] < row["ci_theta"][1]
        assert row["beta_total"] == pytest.approx(np.hypot(row["beta"], 0.35), rel=0.1)
        z = np.log(0.6 / row["theta"]) / np.array([row["beta_total"], row["beta"]])
        assert [row["p"], row["p_records"]] == pytest.approx(stats.norm.cdf(z))
        assert 0.0 <= row["loo_error"] < 0.05
    # the generator: ln drift = ln 0.035 + ln im + 0.35 z, whatever the axes
    assert found["rows"][0]["theta"] == pytest.approx(0.01 / 0.035, rel=0.3)
    assert [row["p"] for row in predict(folder, *PLACE)["rows"]] == [None, None]
    # only the joint models are needed, as in the folder of a study
    write_tables({"joint": table_of(written[0], "joint")}, tmp_path / "fragility")
    assert predict(tmp_path, *PLACE) == predict(folder, *PLACE)


def test_values_outside_the_motions_are_flagged(written):
    """The motions of the table have 0.1 to 1.5 g; three of them exceed a value inside."""
    folder = written[0] / "out"
    by_motion = np.sort(DEMANDS.groupby("motion_id")[IM].first())
    low, high = by_motion[2], by_motion[-3]
    for at in (0.9 * low, 1.01 * low, 0.99 * high, 1.01 * high):
        for row in predict(folder, *PLACE, "--at", f"{at:.6f}")["rows"]:
            assert row["p_extrapolated"] == (not low <= at <= high)
            assert row["extrapolated"] == (not low <= row["theta"] <= high)
    printed = invoke("predict", "--study", folder, *PLACE, "--at", "9")
    assert "fewer than three motions" in printed.stderr
    for name in ("joint", "system", "curves"):
        table = table_of(written[0], name).query("status == 'ok'")
        assert len(table)
        assert table["im_low"].gt(0.1).all()
        inside = table["theta"].between(table["im_low"], table["im_high"])
        assert table["extrapolated"].astype(bool).tolist() == (~inside).tolist()


def test_predicted_failure_in_any_mode_is_the_union_of_the_modes(tmp_path):
    rng, table = np.random.default_rng(8), synthetic_demands(**SMALL | {"motions": 14})
    x, scatter = np.log(table[IM]), 0.25 * rng.normal(size=(2, 14))
    motion, skew = table["motion_id"].str[1:].astype(int), table["skew_deg"] / 60.0
    # skew weakens one mode and strengthens the other
    for name, b, theta, sign, own in (
        ("column_shear_dcr", 0.6, 0.9, 0.3, scatter[0]),
        ("drift_over_capacity", 1.1, 1.0, -0.3, scatter[1]),
    ):
        table[name] = np.exp(b * (x - np.log(theta)) + sign * skew + own[motion])
    table["column_failure_ratio"] = table[[*FAILURE_DEMANDS.values()]].max(axis=1)
    rows = joint(table, FAILURES)
    assert (rows["status"] == "ok").all()
    write_tables({"joint": rows}, tmp_path / "fragility")
    for skew_deg, at in product((0, 45), np.geomspace(0.05, 3.0, 8)):
        options = ("--skew-deg", skew_deg, "--friction", "0.2", "--at", f"{at:.6f}")
        found = {row["state"]: row for row in predict(tmp_path, *options)["rows"]}
        *modes, any_mode = (found[name] for name in ("shear", "flexure", "any"))
        for name in ("p", "p_records"):
            p = [mode[name] for mode in modes]
            assert max(p) <= any_mode[name] <= sum(p) + 1e-12
        assert any_mode["theta"] < min(mode["theta"] for mode in modes)
        assert any_mode["ci_theta"][0] < any_mode["theta"] < any_mode["ci_theta"][1]
    assert rows[rows["limit_state"] == "any"].iloc[0]["loo_error"] < 0.05


def test_states_whose_curves_are_withheld_have_no_prediction(written, tmp_path, caplog):
    """All strong runs stop early, below the larger drift: its median is a guess of the model."""
    strong = DEMANDS[IM] > 0.5
    ended = DEMANDS[NEEDED].assign(status=np.where(strong, "numerical_failure", "ok"))
    ended.loc[strong, "column_drift_ratio"] = 0.02
    ended.loc[ended.index[strong][0], ["status", "column_drift_ratio"]] = "ok", 0.03
    statistics(ended, tmp_path, written[0])
    curves, joint = table_of(tmp_path, "curves"), table_of(tmp_path, "joint")
    assert (curves.query("limit_state == 'moderate'")["status"] == "bounds_too_wide").any()
    assert not curves.query("limit_state == 'moderate' and preferred").size
    status = joint.query("component == 'column_drift'").set_index("limit_state")["status"]
    assert status.to_dict() == {"slight": "ok", "moderate": "bounds_too_wide"}
    found = predict(tmp_path / "out", *PLACE)["rows"]
    assert [(row["state"], row["n_withheld"]) for row in found] == [("slight", 0)]
    assert "no curve in any variant (bounds_too_wide): column_drift moderate" in caplog.text
    paper = pd.read_csv(tmp_path / "out" / "fragility" / "table.csv")
    assert set(paper["limit_state"]) == {"slight"}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--skew-deg", "61", *PLACE[2:]), "skew_deg must be within"),
        ((*PLACE, "--gap-mm", "60"), "gap_mm must be within"),
        ((*PLACE, "--axis", "gap-mm=25"), "gap_mm is given by its option and by --axis"),
        (PLACE[:4], "friction is missing"),
        ((*PLACE, "--bridge", "osb7"), "bridge must be one of"),
        ((*PLACE, "--at", "0"), "at must be > 0"),
        ((*PLACE, "--axis", "soil=1"), "soil is not an axis"),
        ((*PLACE, "--study", Path(__file__).parent), "skewbridge statistics"),
    ],
)
def test_values_outside_the_study_and_folders_without_models_are_refused(written, options, words):
    assert words in predict(written[0] / "out", *options, code=2)["message"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t.drop(columns="status"), "no column 'status'"),
        (lambda t: t.assign(status="fine"), "status must be one of ok, collapse, numerical"),
        (lambda t: t.rename(columns={"friction": "Friction "}), "did you mean friction?"),
        (lambda t: t.rename(columns={"motion_id": "shaking"}), "'friction', 'shaking', 'status'"),
        (lambda t: t.assign(column_drift_ratio=np.inf), "give a collapsed run the status collapse"),
        (lambda t: t.drop(columns=["column_drift_ratio"]), "none of the demands"),
        (lambda t: t.drop(columns=[IM]), "an intensity column im_"),
        (lambda t: t.rename(columns={IM: "im_a_g"}).assign(im_b_g=1.0), "--im"),
        (lambda t: pd.concat([t, t]), "repeats"),
        (lambda t: t.assign(friction=50), "friction must be within 0..1.5 (rows 0, 1"),
        (lambda t: t.assign(beyond_model="yes"), "beyond_model must be shear or flexure, or empty"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused(written, tmp_path, change, words):
    found = statistics(change(DEMANDS[NEEDED]), tmp_path, written[0], code=2)
    assert words in found["message"]


def test_statistics_outside_a_study_folder_are_a_study_with_report(tmp_path, monkeypatch):
    """The limit states are those of the package; load, plot, predict and compare accept it."""
    monkeypatch.chdir(tmp_path)
    two = synthetic_demands(motions=14, skews=(0, 60), gaps=(0, 51))
    two[NEEDED].set_index(["skew_deg", "motion_id"]).to_parquet("runs.parquet")
    report = answer("statistics", "runs.parquet", "--out=theirs", "--report", "--units=us")
    assert "shear_key/slight (shear_key_disp_m)" in report["left_out"]
    study = skewbridge.load("theirs")
    assert (len(study.demands), set(study.demands["bridge"])) == (len(two), {"foreign"})
    assert study.demands.attrs["units"][IM] == "g"
    assert study.demands.attrs["provenance"]["statistics_of"] == "runs.parquet"
    curves = study.fragility["curves"]
    packaged = load_limit_states(ROOT / "config" / "limit_states.yaml")
    drift = {state.name: state.threshold for state in packaged if state.demand == NEEDED[-1]}
    assert dict(zip(curves["limit_state"], curves["threshold"], strict=True)) == drift
    assert predict("theirs", *PLACE)["rows"]
    names = [row["name"] for row in answer("study", "plot", "--study", "theirs")["figures"]]
    assert "foreign_foreign_curves_column_drift" in names
    assert all(Path(f"theirs/figures/{name}.svg").is_file() for name in names)
    assert report["status"] == curves["status"].value_counts().to_dict()
    assert report["verdict"] == study.fragility["effects"].verdict_family.value_counts().to_dict()
    page = Path(report["report"]).read_text(encoding="utf-8")
    for absent in ("undefined", "nan ", 'id="quality"', "No median capacity of"):
        assert absent not in page.split("<script")[0]
    assert all(text in page for text in ("2.01\u00a0in", "14 motions, Sa"))  # scaled or not
    # written again with own limit states, but never over the demands of a study
    Path("own.yaml").write_text(json.dumps([DRIFT_ENTRY | {"component": "own"}]))
    answer("statistics", "theirs/demands.parquet", "--out=theirs", "--limit-states=own.yaml")
    same = answer("compare", "theirs", "runs.parquet")
    assert (same["counts"]["pairs"], same["counts"]["equal_pairs"]) == (len(two), len(two))
    assert {row["demand"] for row in same["medians_by_state"]} == {"own/slight", "own/moderate"}
    write_frame(two, tmp_path / "study" / "demands.parquet", {"config_digest": "a"})
    found = answer("statistics", "runs.parquet", "--out", "study", code=2)["message"]
    assert "study is the folder of a study with demands: choose another" in found
    assert len(pd.read_parquet("study/demands.parquet").columns) == len(two.columns)
    two.query("skew_deg == 0 and gap_mm == 0 and friction == 0")[NEEDED[3:]].to_csv("one.csv")
    found = answer("statistics", "one.csv", "--out", "one", "--report", code=2)["message"]
    assert "figures need a column of an axis" in found


def test_all_columns_of_a_study_are_kept_and_drift_in_per_cent_is_reported(written, tmp_path):
    table = DEMANDS.assign(suspect="", steps_by_rung="9", wall_s=1.5, column_drift_ratio=5.0)
    table.loc[3, "suspect"] = "energy residual"
    report = statistics(table, tmp_path, written[0])
    kept = pd.read_parquet(tmp_path / "out" / "demands.parquet")
    assert set(table.columns) <= set(kept.columns)
    same = ["suspect", "run_key"]
    assert kept[same].to_numpy().tolist() == table[same].to_numpy().tolist()
    (text,) = report["warnings"]
    assert "column_drift_ratio is up to 5 in completed runs" in text
    assert demand_table.percent_notes("unseating_m", np.array([0.0, 9.0])) == []
    assert "metres are needed" in demand_table.percent_notes("unseating_m", np.array([38.0]))[0]
    (text,) = demand_table.percent_notes("column_drift_ratio", np.array([0.0, 0.01, 0.0]))
    assert "is 0 in 2 completed runs: give failed runs their status" in text
    no_columns = DEMANDS.assign(column_drift_ratio=0.0)
    assert demand_table.prepared(no_columns, ["column_drift_ratio"], SETTINGS).notes.empty


def test_the_table_of_a_paper_has_variants_and_joint_rows_with_ratios(written):
    folder, _ = written
    table = pd.read_csv(folder / "out" / "fragility" / "table.csv")
    assert list(table.columns) == list(PAPER_COLUMNS)
    slight, axes = table[table["limit_state"] == "slight"], ["skew_deg", "gap_mm", "friction"]
    (joint,) = slight[slight["row"] == "joint"].to_dict("records")
    for name in ("skew", "gap", "friction"):
        low, middle, high = (joint[f"{name}_ratio{end}"] for end in ("_low", "", "_high"))
        assert low < middle < high
        assert low < 1.0 < high  # the generator: no axis acts on the drift
    assert np.isnan([joint[name] for name in axes]).all()
    variants = slight[slight["row"] != "joint"]
    assert variants.groupby(axes).ngroups == len(variants) == 12
    # each axis: the smallest value has nothing to be compared with
    assert variants[["friction_ratio", "skew_ratio"]].notna().sum().tolist() == [6, 8]
    # a joint row counts all runs, also those without information on the demand, which no fit uses
    curves, medians, fits = (table_of(folder, n) for n in ("curves", "median_effects", "joint"))
    paper = paper_table(curves, medians, fits)
    counts = paper.query("limit_state == 'slight'").groupby("method")[["n_exceed", "n_runs"]].sum()
    assert counts.loc["joint"].tolist() == counts.drop("joint").sum().tolist()
    assert with_interval([1.0, 0.26, 1.1]) == "1.00 [0.260, 1.10]"
    tex = (folder / "out" / "fragility" / "table.tex").read_text(encoding="utf-8")
    assert tex.count(r"\\") == len(table) + 1


def test_joint_rows_compare_the_ends_of_an_axis_at_the_middle_of_the_others(written, tmp_path):
    """Friction 0 to 0.5 at skew 30 degrees, where it counts half as much as at 60 degrees."""
    demands = shifted(DEMANDS[NEEDED], lambda t: 0.02 * t["skew_deg"] * t["friction"])
    statistics(demands, tmp_path, written[0])
    table = pd.read_csv(tmp_path / "out" / "fragility" / "table.csv")
    row = table.query("row == 'joint' and limit_state == 'slight'").iloc[0]
    middle = ("--skew-deg", "30", "--gap-mm", "25.5", "--friction")
    medians = [predict(tmp_path / "out", *middle, friction)["rows"][0]["theta"]
               for friction in ("0", "0.5")]  # fmt: skip
    assert row["friction_ratio"] == pytest.approx(medians[1] / medians[0], rel=1e-5)
    # the generator: demands grow by exp(0.02 x 30 x 0.5), medians fall as much
    assert row["friction_ratio"] == pytest.approx(np.exp(-0.3), rel=0.1)
    # skews of both signs without 0 are compared with each other
    for values, ends in (((-30, 30), (30, -30)), ((-30, 0, 60), (0, 60)), ((51,), (51, 51))):
        assert (demand_table.reference_value(values), demand_table.farthest_value(values)) == ends


def test_median_demands_at_an_intensity_are_those_of_regressions(tmp_path):
    demands = synthetic_demands(skews=(0, 60), gaps=(51,), motions=24, scales=(0.7, 1.4))
    write_frame(demands, tmp_path / "demands.parquet", {})
    study = skewbridge.load(tmp_path)
    found = study.at("column_drift_ratio", im=0.5, skew_deg=[0, 60], friction=0.5)
    assert found[["skew_deg", "friction"]].to_numpy().tolist() == [[0.0, 0.5], [60.0, 0.5]]
    for row in found.to_dict("records"):
        runs = demands[demands["variant"] == row["variant"]]
        logs = np.log([runs[IM] / 0.5, runs["column_drift_ratio"]])
        # both runs of a motion have one residual: the errors are those of 24 motions
        x, y = logs.T.reshape(24, 2, 2).mean(axis=1).T
        line = stats.linregress(x, y)
        width = stats.t.ppf(0.975, 22) * line.intercept_stderr
        scatter = np.std(y - line.slope * x, ddof=2)
        ends = [np.log(row[name] / row["median"]) for name in ("ci_low", "ci_high", "p16", "p84")]
        assert np.log(row["median"]) == pytest.approx(line.intercept, abs=0.03)
        assert ends == pytest.approx([-width, width, -scatter, scatter], rel=0.25)
    far = study.at("deck_disp_m", 2.5)  # above all runs
    assert far["extrapolated"].all()
    assert (far.attrs["units"]["im"], far.attrs["units"]["p84"]) == ("g", "m")
    with pytest.raises(InputError, match="skew_deg must be one of 0, 60; got 45"):
        study.at("deck_disp_m", 0.5, skew_deg=45)
