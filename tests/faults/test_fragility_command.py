"""`skewbridge fit` and `export`: one JSON object, the row of an error, exit codes."""

import json
import re
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm
from typer.testing import CliRunner

from fragility_tables import IM, synthetic_demands
from skewbridge.cli import build_app
from skewbridge.errors import InputError
from skewbridge.fragility.exchange.foreign import read_foreign
from skewbridge.fragility.exchange.measures import openquake_measure
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.limit_states import limit_states_of

DRIFT = limit_states_of(
    [
        {
            "component": "column_drift",
            "demand": "column_drift_ratio",
            "unit": "percent",
            "dispersion": 0.35,
            "citation": "test",
            "states": {"slight": 1.0, "moderate": 2.5},
        }
    ]
)


def run(*arguments):
    result = CliRunner().invoke(build_app(), [*map(str, arguments), "--json"])
    return result.exit_code, json.loads(result.stdout)


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
    ],
)
def test_wrong_options_name_the_choice(write, options, text):
    path = write({"im": [0.2, 0.4], "n": [20, 20], "k": [1, 9], "edp": [1, 2], "threshold": 1})
    code, found = run("fit", path, *options)
    assert code == 2
    assert text in found["message"]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--method", "stripes", "--model", "tobit"], "--model is of --method cloud"),
        (["--method", "cloud", "--link", "logit"], "--link is of --method stripes"),
        (["--method", "ida", "--capacity-dispersion", "0.3"], "--capacity-dispersion is of"),
        (["--method", "stripes", "--capacity-dispersion", "0.3"], "needs the demand of every run"),
        (["--method", "stripes", "--censor-above", "0.3"], "are of --model tobit"),
    ],
)
def test_options_that_a_method_lacks_are_refused_and_not_dropped(write, options, text):
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


def curves_file(tmp_path, im=IM):
    table = synthetic_demands(skews=(0, 30), gaps=(51,), motions=30).rename(columns={IM: im})
    path = tmp_path / "curves.parquet"
    fit_study(table, DRIFT, im).to_parquet(path)
    return path, pd.read_parquet(path)


def test_nrml_carries_the_lognormal_back(tmp_path):
    path, curves = curves_file(tmp_path, "im_sa_1p000_rotd50_g")
    out = tmp_path / "fragility.xml"
    code, report = run("export", path, "--format", "nrml", "--out", out)
    assert code == 0
    assert report["curves"] == 8
    space = {"n": "http://openquake.org/xmlns/nrml/0.5"}
    model = ElementTree.parse(out).getroot().find("n:fragilityModel", space)
    assert model.find("n:limitStates", space).text.split() == ["slight", "moderate"]
    functions = model.findall("n:fragilityFunction", space)
    assert len(functions) == 4
    assert functions[0].find("n:imls", space).get("imt") == "SA(1)"
    cloud = curves[(curves["method"] == "cloud") & (curves["limit_state"] == "moderate")]
    first = cloud.sort_values("variant").iloc[0]
    params = functions[0].findall("n:params", space)[1]
    mean, deviation = float(params.get("mean")), float(params.get("stddev"))
    sigma = np.sqrt(np.log1p((deviation / mean) ** 2))
    assert sigma == pytest.approx(first["beta_total"], rel=1e-6)
    assert mean * np.exp(-0.5 * sigma**2) == pytest.approx(first["theta"], rel=1e-6)


def test_pelicun_table_has_one_row_per_component(tmp_path):
    path, _ = curves_file(tmp_path, "im_pga_rotd50_g")
    out = tmp_path / "fragility.csv"
    run("export", path, "--format", "pelicun", "--out", out)
    table = pd.read_csv(out)
    assert len(table) == 4
    assert set(table["Demand-Type"]) == {"Peak Ground Acceleration"}
    assert set(table["LS1-Family"]) == {"lognormal"}
    assert (table["LS1-Theta_0"] < table["LS2-Theta_0"]).all()
    assert set(table["Demand-Directional"]) == {1}


def test_limit_states_keep_their_number_where_a_milder_one_has_no_estimate(tmp_path):
    path, curves = curves_file(tmp_path, "im_pga_rotd50_g")
    first = curves["variant"].iloc[0]
    hole = (curves["variant"] == first) & (curves["limit_state"] == "slight")
    curves.loc[hole, ["status", "theta", "beta", "beta_total"]] = ["all_exceed", *[np.nan] * 3]
    curves.iloc[::-1].to_parquet(path)  # the order of the rows is that of nothing
    out = tmp_path / "fragility.csv"
    _, report = run("export", path, "--format", "pelicun", "--out", out)
    name = f"{first}.column_drift"
    assert report["holes"] == [{"id": name, "missing": ["slight"]}]
    assert report["left_out"] == 1
    row = pd.read_csv(out).set_index("ID").loc[name]
    assert np.isnan(row["LS1-Theta_0"])
    assert row["LS2-Theta_0"] > 0
    told = json.loads((tmp_path / "fragility.json").read_text())[name]
    assert told["LimitStates"]["LS2"]["DS1"]["Description"].startswith("moderate")
    assert "LS1 slight (all_exceed)" in told["Comments"]
    assert told["LimitStates"]["LS2"]["DS1"]["Reference"] == "test"


def test_nrml_drops_no_curve_and_names_the_files_that_it_wrote(tmp_path):
    path, curves = curves_file(tmp_path, "im_pga_rotd50_g")
    first = curves["variant"].iloc[0]
    hole = (curves["variant"] == first) & (curves["limit_state"] == "slight")
    curves.loc[hole, "status"] = "all_exceed"
    curves.iloc[::-1].to_parquet(path)
    out = tmp_path / "fragility.xml"
    _, report = run("export", path, "--format", "nrml", "--out", out)
    assert {model["functions"] for model in report["models"]} == {1, 3}
    assert report["curves"] == 7
    states = {}
    for name in report["files"]:
        model = ElementTree.parse(name).getroot()[0]
        states[model[1].text] = len(model) - 2
    assert states == {"slight moderate": 3, "moderate": 1}
    assert any("fragility.xml was not written" in note for note in report["notes"])


def test_curves_over_a_range_and_factors_of_skew(tmp_path):
    path, curves = curves_file(tmp_path)
    out = tmp_path / "p.csv"
    run("export", path, "--format", "csv", "--out", out, "--im-range", 0.1, 2, "--points", 7)
    long = pd.read_csv(out)
    one = curves[(curves["method"] == "cloud") & (curves["status"] == "ok")].iloc[0]
    same = (long["variant"] == one["variant"]) & (long["limit_state"] == one["limit_state"])
    u = np.log(long.loc[same, "intensity"] / one["theta"]) / one["beta_total"]
    assert long.loc[same, "probability"].to_numpy() == pytest.approx(norm.cdf(u), rel=1e-9)
    run("export", path, "--format", "csv", "--out", out, "--im-range", 0.1, 2, "--wide")
    assert pd.read_csv(out).shape == (50, 9)
    run("export", path, "--format", "csv", "--out", out, "--wide")
    assert pd.read_csv(out)["column_drift.slight.theta"].notna().all()
    run("export", path, "--format", "csv", "--out", out, "--skew-factors")
    factors = pd.read_csv(out)
    assert len(factors) == 4
    assert factors["hazus_factor"].to_numpy() == pytest.approx(np.sqrt(np.cos(np.pi / 6)))
    assert (factors["theta"] / factors["theta_straight"]).to_numpy() == pytest.approx(
        factors["factor"]
    )


def test_workbook_and_paper_table(tmp_path):
    path, _ = curves_file(tmp_path)
    out = tmp_path / "curves.xlsx"
    options = ("--im-range", 0.1, 2, "--skew-factors")
    code, _ = run("export", path, "--format", "xlsx", "--out", out, *options)
    assert code == 0
    with ZipFile(out) as book:
        sheets = book.read("xl/workbook.xml").decode()
    assert re.findall('sheet name="([^"]+)"', sheets) == [
        "curves", "probabilities", "skew factors", "notes",
    ]  # fmt: skip
    tex = tmp_path / "curves.tex"
    run("export", path, "--format", "latex", "--out", tex)
    assert r"\beta_\mathrm{total}" in tex.read_text()
    code, found = run("export", path, "--format", "latex", "--out", tex, "--wide")
    assert code == 2
    assert "csv and xlsx" in found["message"]


def test_plain_table_keeps_the_rows_without_estimate_and_their_status(tmp_path):
    path, curves = curves_file(tmp_path)
    out = tmp_path / "curves.csv"
    run("export", path, "--format", "csv", "--out", out, "--method", "exceedance")
    table = pd.read_csv(out)
    assert len(table) == (curves["method"] == "exceedance").sum()
    assert "status" in table


def test_hazard_table_adds_annual_frequencies(tmp_path):
    path, _ = curves_file(tmp_path)
    hazard, out = tmp_path / "hazard.csv", tmp_path / "curves.csv"
    im = np.geomspace(1e-3, 1e3, 20)
    pd.DataFrame({"im": im, "rate": 1e-4 * im**-2.5}).to_csv(hazard, index=False)
    run("export", path, "--format", "csv", "--out", out, "--hazard", hazard)
    first = pd.read_csv(out).query("status == 'ok'").iloc[0]
    beta = first["beta_total"]
    wanted = 1e-4 * first["theta"] ** -2.5 * np.exp(0.5 * (2.5 * beta) ** 2)
    assert first["annual_frequency"] == pytest.approx(wanted, rel=1e-4)  # ends of the table
    short = np.geomspace(0.05, 0.5, 8)
    pd.DataFrame({"im": short, "rate": 1e-4 * short**-2.5}).to_csv(hazard, index=False)
    run("export", path, "--format", "csv", "--out", out, "--hazard", hazard)
    cut = pd.read_csv(out).query("status == 'ok'").iloc[0]
    part = cut["annual_frequency"]
    assert part + cut["annual_frequency_above_least"] < wanted
    assert part + cut["annual_frequency_above_most"] > 0.99 * wanted
    assert 0 < cut["probability_at_first_level"] < 0.05
    pd.DataFrame({"im": im, "rate": im}).to_csv(hazard, index=False)
    code, found = run("export", path, "--format", "csv", "--out", out, "--hazard", hazard)
    assert code == 2
    assert "rate must not increase (rows" in found["message"]


def test_export_refuses_what_the_other_tool_cannot_name(tmp_path):
    path, _ = curves_file(tmp_path, "im_sa_t1_rotd50_g")
    code, found = run("export", path, "--format", "nrml", "--out", tmp_path / "x.xml")
    assert code == 2
    assert "has no name in OpenQuake" in found["message"]
    assert openquake_measure("im_pgv_rotd50_mps") == ("PGV", 100.0)


def test_a_table_of_somebody_else_is_read_and_fitted(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=30)
    theirs = pd.DataFrame(
        {
            "record": table["motion_id"],
            "PGA": table[IM],
            "drift_pct": 100 * table["column_drift_ratio"],
        }
    )
    path = tmp_path / "theirs.csv"
    theirs.to_csv(path, index=False)
    columns = {"motion_id": "record", "im_pga_rotd50_g": "PGA", "column_drift_ratio": "drift_pct"}
    ours = read_foreign(path, columns, factors={"column_drift_ratio": 0.01})
    fitted = fit_study(ours, DRIFT, "im_pga_rotd50_g").iloc[0]
    direct = fit_study(table, DRIFT, IM).iloc[0]
    assert fitted["theta"] == pytest.approx(direct["theta"])


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"PGA": [0.1, 0.0]}, "im_pga_g must be > 0 and finite (row 1)"),
        ({"drift": ["1", "much"]}, "drift must be a number, got 'much' (row 1)"),
        ({"status": ["ok", "fine"]}, "status 'fine' is not known (row 1)"),
        ({"record": ["a", "a"]}, "row 1 repeats"),
    ],
)
def test_a_bad_foreign_table_names_row_and_column(tmp_path, change, text):
    data = {"record": ["a", "b"], "PGA": [0.1, 0.2], "drift": ["0.1", "0.2"], "status": ["ok"] * 2}
    path = tmp_path / "theirs.csv"
    pd.DataFrame(data | change).to_csv(path, index=False)
    columns = {
        "motion_id": "record",
        "im_pga_g": "PGA",
        "column_drift_ratio": "drift",
        "status": "status",
    }
    with pytest.raises(InputError) as caught:
        read_foreign(path, columns)
    assert text in str(caught.value)


def test_a_foreign_table_is_fitted_through_its_file_of_columns(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=30)
    ours, theirs = tmp_path / "ours.parquet", tmp_path / "theirs.csv"
    table.to_parquet(ours)
    drift = 100 * table["column_drift_ratio"]
    pd.DataFrame({"rec": table["motion_id"], "sa": table[IM], "pct": drift}).to_csv(theirs)
    columns = tmp_path / "columns.yaml"
    columns.write_text(
        f"columns: {{motion_id: rec, {IM}: sa, column_drift_ratio: pct}}\n"
        "factors: {column_drift_ratio: 0.01}\n",
        encoding="utf-8",
    )
    options = ["--method", "cloud", "--im", IM, "--edp", "column_drift_ratio", "--threshold", 0.02]
    _, first = run("fit", ours, *options)
    _, second = run("fit", theirs, *options, "--columns", columns)
    assert second["theta"] == pytest.approx(first["theta"])
    columns.write_text("column: {}\n", encoding="utf-8")
    code, found = run("fit", theirs, *options, "--columns", columns)
    assert code == 2
    assert "columns.yaml" in found["message"]
