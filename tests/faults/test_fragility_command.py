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


def test_collapses_choose_the_modified_cloud_and_ols_says_what_it_leaves_out(write):
    rng = np.random.default_rng(0)
    im = np.exp(rng.uniform(-2, 0.7, 60))
    edp = 0.03 * im * np.exp(0.3 * rng.normal(size=60))
    fall = (im * np.exp(0.4 * rng.normal(size=60)) > 1.2).astype(int)
    data = {"im": list(im), "edp": list(edp), "threshold": 0.03, "collapse": fall.tolist()}
    assert run("fit", write(data), "--method", "cloud")[1]["method"] == "cloud_modified"
    _, plain = run("fit", write(data), "--method", "cloud", "--model", "ols")
    assert "collapse_left_out" in plain["warnings"]
    _, tobit = run("fit", write(data), "--method", "cloud", "--model", "tobit")
    assert tobit["n_censored"] == fall.sum()


def test_demands_table_with_condition_obeys_status_and_motions(tmp_path):
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    table.loc[20, "status"] = "collapse"
    path = tmp_path / "demands.parquet"
    table.to_parquet(path)
    options = ["--im", IM, "--edp", "column_drift_ratio", "--threshold", 0.01]
    where = ["--where", "skew_deg == 0 and friction == 0.5"]
    code, found = run("fit", path, "--method", "cloud", *options, *where)
    assert code == 0
    assert found["n_runs"] == 16
    assert found["n_censored"] == 1
    code, found = run("fit", path, "--method", "stripes", *options, *where)
    assert found["status"] in {"ok", "complete_separation"}
    code, found = run("fit", path, "--method", "cloud", *options, "--where", "skew == 3")
    assert code == 2
    assert "skew" in found["message"]
    code, found = run("fit", path, "--method", "cloud", *options, "--where", "skew_deg == 15")
    assert "selects no row" in found["message"]
    code, found = run("fit", path, "--method", "cloud", "--im", "sa", *options[2:])
    assert "no column 'sa'" in found["message"]


def test_row_of_an_error_in_a_selection_is_that_of_the_file(tmp_path):
    path = tmp_path / "runs.csv"
    rows = {"im": [0.1, 0.2, -0.3, 0.4], "edp": [1, 2, 3, 4], "skew": [0, 0, 30, 30]}
    pd.DataFrame(rows).to_csv(path, index=False)
    options = ["--im", "im", "--edp", "edp", "--threshold", 2, "--where", "skew == 30"]
    code, found = run("fit", path, "--method", "cloud", *options)
    assert (code, found["row"]) == (2, 2)
    assert "row 2 of the file" in found["message"]


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
        (["--method", "cloud", "--model", "magic"], "is not one of 'ols', 'tobit'"),
        (["--method", "stripes", "--link", "cauchit"], "is not one of 'probit', 'logit'"),
        (["--method", "stripes", "--level", "1.5"], "level must be within"),
        (["--method", "cloud", "--capacity-dispersion", "-1"], "capacity_dispersion"),
        (["--method", "stripes", "--model", "tobit"], "--model is of --method cloud"),
        (["--method", "cloud", "--link", "logit"], "--link is of --method stripes"),
        (["--method", "ida", "--capacity-dispersion", "0.3"], "--capacity-dispersion is of"),
        (["--method", "stripes", "--capacity-dispersion", "0.3"], "needs the demand of every run"),
        (["--method", "stripes", "--censor-above", "0.3"], "are of --model tobit"),
    ],
)
def test_options_that_are_wrong_or_of_another_method_are_refused(write, options, text):
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


def test_capacity_dispersion_link_and_model_count_for_tables_with_repeated_motions(tmp_path):
    path, options = repeated_runs(tmp_path)
    cloud = ["--method", "cloud", *options]
    _, plain = run("fit", path, *cloud)
    _, wide = run("fit", path, *cloud, "--capacity-dispersion", 0.5)
    assert wide["beta"] == pytest.approx(np.hypot(plain["beta"], 0.5 / plain["b"]))
    assert wide["ci_beta"][0] > plain["ci_beta"][1]
    assert wide["ci_method"] == plain["ci_method"] == "record_bootstrap"
    stripes = ["--method", "stripes", *options]
    _, probit = run("fit", path, *stripes)
    _, logit = run("fit", path, *stripes, "--link", "logit")
    assert (probit["link"], logit["link"]) == ("probit", "logit")
    assert logit["theta"] != probit["theta"]
    assert logit["ci_theta"][0] < logit["theta"] < logit["ci_theta"][1]
    _, wide = run("fit", path, *stripes, "--capacity-dispersion", 0.5)
    assert wide["method"] == "stripes_uncertain_capacity"
    assert wide["beta"] > 1.3 * probit["beta"]
    code, refused = run("fit", path, *cloud, "--model", "heteroscedastic")
    assert code == 2
    assert "motions repeat" in refused["message"]


def test_models_that_would_leave_unfinished_runs_out_are_refused(tmp_path):
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
    _, modified = run("fit", path, *cloud, "--model", "modified")
    assert modified["n_collapse"] == strong.sum()
    table.assign(status=np.where(strong, "crash", "ok")).to_parquet(path)
    code, refused = run("fit", path, *cloud, "--model", "modified")
    assert code == 2
    assert "take tobit" in refused["message"]


def test_tests_of_fit_with_simulated_p_values(write):
    path = write({"im": [0.2, 0.4, 0.6, 0.8], "n": [20] * 4, "k": [0, 4, 12, 18]})
    _, found = run("fit", path, "--method", "stripes", "--goodness")
    assert 0 < found["deviance_p_simulated"] <= 1
    assert 0 < found["isotonic_p"] <= 1
    path = write({"capacity": [0.5, 0.7, 0.8, 0.9, 1.1, 1.4]})
    _, found = run("fit", path, "--method", "ida", "--goodness")
    assert found["lilliefors_d"] < found["lilliefors_d_05"]


@pytest.mark.parametrize("name", ["missing.json", "broken.json", "data.txt"])
def test_unreadable_files_are_one_sentence(tmp_path, name):
    path = tmp_path / name
    if name != "missing.json":
        path.write_text("{not json", encoding="utf-8")
    code, found = run("fit", path, "--method", "stripes")
    assert code == 2
    assert name in found["message"]
