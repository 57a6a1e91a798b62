"""`skewbridge fit`: one JSON object, the row of an error, exit codes."""

import json

import numpy as np
import pandas as pd
import pytest

from cli_json import run
from fragility_tables import IM, synthetic_demands


@pytest.fixture
def write(tmp_path):
    def save(data):
        path = tmp_path / "data.json"
        path.write_text(json.dumps(data), encoding="utf-8")
        return path

    return save


def test_stripes_from_json(write):
    path = write({"im": [0.2, 0.4, 0.6, 0.8], "n": [20] * 4, "k": [0, 4, 12, 18]})
    code, found = run("fit", path, "--method", "stripes")
    assert code == 0
    assert found["status"] == "ok"
    assert found["ci_theta"][0] < found["theta"] < found["ci_theta"][1]
    assert found["n_runs"] == 80


@pytest.mark.parametrize(
    ("data", "method", "row", "text"),
    [
        ({"im": [0.3, 0.5], "n": [20, 20], "k": [1, 21]}, "stripes", 1, "0<=k<=n (row 1)"),
        ({"im": [0.0, 0.5], "n": [20, 20], "k": [1, 2]}, "stripes", 0, "im must be > 0"),
        ({"im": [0.1, None], "n": [20, 20], "k": [1, 2]}, "stripes", 1, "im must be > 0"),
        ({"im": [0.1, "x"], "n": [20, 20], "k": [1, 2]}, "stripes", 1, "must be a number"),
        ({"im": [0.1, -0.2], "edp": [1, 1], "threshold": 1}, "cloud", 1, "im must be > 0"),
        ({"im": [0.1, 0.2], "edp": [1, 0], "threshold": 1}, "cloud", 1, "edp must be > 0"),
        ({"im": [0.1, 0.2], "edp": [1, 1], "threshold": -1}, "cloud", 0, "threshold must"),
        ({"capacity": [1, float("nan")]}, "ida", 1, "capacity must be > 0"),
        ({"capacity": [1, 2], "censored": [0, 2]}, "ida", 1, "censored must be 0 or 1"),
        ({"lower": [0.5, 0.7], "upper": [0.6, 0.7]}, "ida", 1, "upper must be above lower"),
        ({"lower": [0.5, -0.1], "upper": [0.6, 0.7]}, "ida", 1, "lower must be >= 0"),
        ({"im": [0.1, 0.2], "n": [20], "k": [1, 2]}, "stripes", 1, "differ in length"),
        ({"im": [0.1, 0.2], "k": [1, 2]}, "stripes", None, "need a column 'n'"),
        ({}, "stripes", None, "need a column 'im'"),
    ],
)
def test_bad_data_exits_two_with_the_row(write, data, method, row, text):
    code, found = run("fit", write(data), "--method", method)
    assert code == 2
    assert found["status"] == "error"
    assert found["row"] == row
    assert text in found["message"]
    assert "data.json: " in found["message"]
    assert found["file"].endswith("data.json")


@pytest.mark.parametrize(
    ("data", "method", "status"),
    [
        ({"im": [0.5, 0.5], "n": [20, 20], "k": [5, 6]}, "stripes", "single_level"),
        ({"im": [0.5] * 4, "edp": [1, 2, 3, 4], "threshold": 2}, "cloud", "single_level"),
        ({"im": [0.2, 0.4], "n": [20, 20], "k": [0, 0]}, "stripes", "no_exceedance"),
        ({"im": [0.2, 0.4], "n": [20, 20], "k": [0, 20]}, "stripes", "complete_separation"),
        ({"capacity": [1, 1, 1]}, "ida", "zero_dispersion"),
        ({"capacity": [1, 2], "censored": [1, 1]}, "ida", "all_censored"),
    ],
)
def test_degenerate_data_exits_zero_with_its_status(write, data, method, status):
    code, found = run("fit", write(data), "--method", method)
    assert (code, found["status"]) == (0, status)
    if status != "zero_dispersion":
        assert found["theta"] is None


def test_spellings_of_published_data_sets_are_understood(write):
    _, first = run(
        "fit", write({"capacity": [1, 2, 3, 3], "right_censored": [0, 0, 0, 1]}), "--method", "ida"
    )
    _, second = run(
        "fit", write({"capacity": [1, 2, 3, 3], "censored": [0, 0, 0, 1]}), "--method", "ida"
    )
    assert first == second
    data = {"bracket_lo": [0.4, 0.8, 0.6], "bracket_hi": [0.7, 1.0, "inf"]}
    assert run("fit", write(data), "--method", "ida")[1]["status"] == "ok"
    x = np.array([0.1, 0.2, 0.5, 0.9])
    y = np.array([0.01, 0.03, 0.05, 0.1])
    logs = {"ln_im": list(np.log(x)), "ln_edp": list(np.log(y)), "threshold": 0.04}
    plain = {"im": list(x), "edp": list(y), "threshold": 0.04}
    found = [run("fit", write(data), "--method", "cloud")[1]["theta"] for data in (logs, plain)]
    assert found[0] == pytest.approx(found[1])


def test_a_collapse_flag_in_a_cloud_censors_the_demand(write):
    rng = np.random.default_rng(0)
    im = np.exp(rng.uniform(-2, 0.7, 60))
    edp = 0.03 * im * np.exp(0.3 * rng.normal(size=60))
    fall = im * np.exp(0.4 * rng.normal(size=60)) > 1.2
    data = {
        "im": list(im),
        "edp": list(edp),
        "threshold": 0.03,
        "collapse": fall.astype(int).tolist(),
    }
    _, found = run("fit", write(data), "--method", "cloud")
    assert (found["method"], found["n_censored"]) == ("cloud_tobit", fall.sum())
    # a collapsed run exceeds: as if its demand were known to be above the threshold
    above = np.where(fall, np.maximum(edp, 0.03), edp).tolist()
    data = {"im": list(im), "edp": above, "threshold": 0.03, "censored": fall.astype(int).tolist()}
    _, same = run("fit", write(data), "--method", "cloud")
    assert same["theta"] == found["theta"]
    code, refused = run("fit", write(data), "--method", "cloud", "--model", "ols")
    assert code == 2
    assert f"would leave out {fall.sum()} censored demands" in refused["message"]


def test_demands_at_or_above_a_value_are_censored_on_request(write):
    data = {"im": [0.1, 0.2, 0.3, 0.5, 0.8], "edp": [0.011, 0.018, 0.034, 0.05, 0.09]}
    path = write(data | {"threshold": 0.03})
    _, found = run("fit", path, "--method", "cloud", "--censor-above", 0.05)
    assert found["n_censored"] == 2
    data |= {"edp": [0.011, 0.018, 0.034, 0.05, 0.05], "censored": [0, 0, 0, 1, 1]}
    _, same = run("fit", write(data | {"threshold": 0.03}), "--method", "cloud")
    assert same["theta"] == found["theta"]


def test_a_table_of_runs_obeys_status_and_motions(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    table.loc[14, "status"] = "collapse"
    path = tmp_path / "demands.parquet"
    table.to_parquet(path)
    options = ["--im", IM, "--edp", "column_drift_ratio", "--threshold", 0.01]
    code, found = run("fit", path, "--method", "cloud", *options)
    assert code == 0
    assert (found["n_runs"], found["n_censored"], found["n_records"]) == (16, 1, 16)
    assert found["n_unknown"] == 0
    code, found = run("fit", path, "--method", "stripes", *options)
    assert found["status"] in {"ok", "complete_separation"}
    code, found = run("fit", path, "--method", "cloud", "--im", "sa", *options[2:])
    assert "no column 'sa'" in found["message"]
    table.assign(status="ok").to_parquet(path)
    code, found = run("fit", path, "--method", "cloud", *options[:4], "--threshold", 9.0)
    assert (code, found["status"], found["theta"]) == (0, "no_exceedance", None)


def test_a_demand_of_zero_is_left_censored(tmp_path):
    """Under weak motions the deck does not reach the wall: the demand is known to be small."""
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=40)
    path = tmp_path / "demands.parquet"
    options = ["--im", IM, "--edp", "abutment_passive_m", "--threshold", 0.05]
    touched = table["abutment_passive_m"].where(table[IM] > 0.2, 0.0)
    table.assign(abutment_passive_m=touched).to_parquet(path)
    _, found = run("fit", path, "--method", "cloud", *options)
    assert (found["status"], found["n_runs"]) == ("ok", 40)
    assert found["n_censored"] >= (table[IM] <= 0.2).sum()
    table.to_parquet(path)
    _, full = run("fit", path, "--method", "cloud", *options)
    assert found["theta"] == pytest.approx(full["theta"], rel=0.05)


def test_unknown_outcomes_that_decide_the_median_are_refused_unless_accepted(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=40)
    strong = (table[IM] > 0.3) & (table.index % 2 == 0)
    half = table["column_drift_ratio"].where(~strong, 0.5 * table["column_drift_ratio"])
    table = table.assign(column_drift_ratio=half, status=np.where(strong, "timeout", "ok"))
    path = tmp_path / "demands.parquet"
    table.to_parquet(path)
    options = [
        "--method",
        "stripes",
        "--im",
        IM,
        "--edp",
        "column_drift_ratio",
        "--threshold",
        0.015,
    ]
    _, found = run("fit", path, *options)
    assert (found["status"], found["theta"]) == ("bounds_too_wide", None)
    assert found["n_unknown"] > 2
    assert found["theta_all_exceed"] < found["theta_none_exceed"]
    _, found = run("fit", path, *options, "--accept-bounds")
    assert found["status"] == "ok"
    assert "unknown_outcomes" in found["warnings"]


def test_a_missing_demand_in_a_table_of_runs_names_its_row(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text("im,edp\n0.1,1\n0.2,2\n0.3,\n0.4,4\n", encoding="utf-8")
    options = ["--im", "im", "--edp", "edp", "--threshold", 2]
    code, found = run("fit", path, "--method", "cloud", *options)
    assert (code, found["row"], found["column"]) == (2, 2, "edp")
    path.write_text("im,edp\n0.1,1\n0.2,2\n-0.3,3\n0.4,4\n", encoding="utf-8")
    code, found = run("fit", path, "--method", "cloud", *options)
    assert (code, found["row"], found["column"]) == (2, 2, "im")


def test_csv_columns_and_a_missing_cell(tmp_path):
    path = tmp_path / "stripes.csv"
    path.write_text("im,n,k\n0.2,20,1\n0.4,20,9\n0.8,20,17\n", encoding="utf-8")
    code, found = run("fit", path, "--method", "stripes")
    assert (code, found["status"]) == (0, "ok")
    path.write_text("im,n,k\n0.2,20,1\n0.4,,9\n0.8,20,17\n", encoding="utf-8")
    code, found = run("fit", path, "--method", "stripes")
    assert (code, found["row"]) == (2, 1)
    path.write_text("lower,upper\n0.2,0.4\n0.5,0.8\n0.6,\n", encoding="utf-8")
    assert run("fit", path, "--method", "ida")[1]["status"] == "ok"


def test_censored_demands_choose_tobit(write):
    data = {
        "im": [0.1, 0.2, 0.3, 0.5, 0.8],
        "edp": [0.011, 0.018, 0.034, 0.05, 0.05],
        "censored": [0, 0, 0, 0, 1],
        "threshold": 0.03,
    }
    _, found = run("fit", write(data), "--method", "cloud")
    assert (found["method"], found["n_censored"]) == ("cloud_tobit", 1)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--method", "magic"], "is not one of 'stripes', 'ida', 'cloud'"),
        (["--method", "cloud", "--model", "modified"], "model must be one of ols, tobit"),
        (["--method", "stripes", "--link", "logit"], "--link must be probit, got 'logit'"),
        (["--method", "stripes", "--level", "1.5"], "level must be within"),
        (["--method", "cloud", "--capacity-dispersion", "-1"], "capacity_dispersion"),
        (["--method", "stripes", "--model", "tobit"], "--model needs --method cloud"),
        (["--method", "ida", "--capacity-dispersion", "0.3"], "--capacity-dispersion needs"),
        (["--method", "stripes", "--capacity-dispersion", "0.3"], "needs --method cloud"),
        (["--method", "stripes", "--censor-above", "0.3"], "--censor-above needs"),
        (["--method", "cloud", "--where", "skew_deg == 3"], "No such option: --where"),
        (["--method", "cloud", "--goodness"], "No such option: --goodness"),
    ],
)
def test_wrong_removed_and_unsuitable_options_are_refused(write, options, text):
    path = write({"im": [0.2, 0.4], "n": [20, 20], "k": [1, 9], "edp": [1, 2], "threshold": 1})
    code, found = run("fit", path, *options)
    assert code == 2
    assert text in found["message"]


def repeated_runs(tmp_path, **changes):
    table = synthetic_demands(
        skews=(0,), gaps=(51,), frictions=(50,), motions=24, scales=(0.6, 1.0, 1.6)
    )
    path = tmp_path / "runs.parquet"
    table.assign(**changes).to_parquet(path)
    return path, ["--im", IM, "--edp", "column_drift_ratio", "--threshold", 0.015]


def test_intervals_are_by_motion_where_motions_repeat(tmp_path):
    path, options = repeated_runs(tmp_path)
    cloud = ["--method", "cloud", *options]
    _, plain = run("fit", path, *cloud)
    _, wide = run("fit", path, *cloud, "--capacity-dispersion", 0.5)
    assert wide["beta"] == pytest.approx(np.hypot(plain["beta"], 0.5 / plain["b"]))
    assert wide["ci_beta"][0] > plain["ci_beta"][1]
    assert wide["ci_method"] == plain["ci_method"] == "jackknife"
    _, stripes = run("fit", path, "--method", "stripes", *options)
    assert (stripes["ci_method"], stripes["n_records"]) == ("jackknife", 24)
    assert stripes["ci_theta"][0] < stripes["theta"] < stripes["ci_theta"][1]
    _, ida = run("fit", path, "--method", "ida", *options)
    assert (ida["method"], ida["n_runs"]) == ("ida_interval", 24)
    assert ida["theta"] == pytest.approx(stripes["theta"], rel=0.1)


def test_ols_refuses_runs_that_did_not_complete(tmp_path):
    path, options = repeated_runs(tmp_path)
    table = pd.read_parquet(path)[lambda t: t["scale"] == 1.0]
    strong = table["column_drift_ratio"] > 0.02
    table.assign(status=np.where(strong, "collapse", "ok")).to_parquet(path)
    cloud = ["--method", "cloud", *options]
    code, refused = run("fit", path, *cloud, "--model", "ols")
    assert (code, refused["status"]) == (2, "error")
    assert "would leave out" in refused["message"]
    _, tobit = run("fit", path, *cloud, "--model", "tobit")
    assert tobit["n_censored"] == strong.sum()


@pytest.mark.parametrize("name", ["missing.json", "broken.json", "data.txt"])
def test_unreadable_files_are_one_sentence(tmp_path, name):
    path = tmp_path / name
    if name != "missing.json":
        path.write_text("{not json", encoding="utf-8")
    code, found = run("fit", path, "--method", "stripes")
    assert code == 2
    assert name in found["message"]
