"""`skewbridge export`: curves as other tools and papers take them, and what cannot be."""

import json
import re
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from cli_json import run
from fragility_tables import DRIFT, IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.exchange.curve_tables import Sampling
from skewbridge.fragility.exchange.measures import openquake_measure
from skewbridge.fragility.tables.curves import fit_study


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


def test_names_of_curves_have_signs_that_the_other_program_takes(tmp_path):
    """pelicun cuts names at a hyphen; OpenQuake takes no dot and 75 signs."""
    path, curves = curves_file(tmp_path, "im_pga_rotd50_g")
    first, second = curves["variant"].unique()[:2]
    names = {first: f"{first}_hinge-length-m0p75", second: f"{second}_hinge_length-m0p75{'x' * 60}"}
    curves.assign(variant=curves["variant"].replace(names)).to_parquet(path)
    run("export", path, "--format", "pelicun", "--out", tmp_path / "fragility.csv")
    ids = pd.read_csv(tmp_path / "fragility.csv")["ID"]
    assert ids.is_unique
    assert not ids.str.contains("-").any()
    run("export", path, "--format", "nrml", "--out", tmp_path / "fragility.xml")
    root = ElementTree.parse(tmp_path / "fragility.xml").getroot()
    space = "{http://openquake.org/xmlns/nrml/0.5}"
    ids = [each.get("id") for each in root.iter(f"{space}fragilityFunction")]
    assert len(set(ids)) == 4
    assert all(re.fullmatch(r"[A-Za-z0-9_:-]{1,75}", each) for each in ids)
    assert f"{first}_hinge-length-m0p75:column_drift" in ids


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
    assert list(long.columns) == [
        *("variant", "bridge", "abutment", "skew_deg", "gap_mm", "friction"),
        *("component", "limit_state", "method", "im", "intensity", "probability"),
    ]
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


@pytest.mark.parametrize(
    ("low", "high", "count"),
    [(0.1, 2.0, 1), (0.0, 2.0, 7), (2.0, 0.1, 7), (0.1, 0.1, 7), (0.1, np.inf, 7)],
)
def test_a_range_of_intensities_rises_above_zero_and_has_two_points(low, high, count):
    with pytest.raises(InputError, match="must rise above 0"):
        Sampling(low, high, count)
    assert Sampling(0.1, 2.0, 2).count == 2
