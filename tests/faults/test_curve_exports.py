"""`skewbridge export`: curves as other tools and papers take them."""

import json
import re
from itertools import product
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from cli_json import run
from skewbridge.errors import InputError
from skewbridge.fragility.exports import CsvContent, measure_names
from skewbridge.fragility.paper_table import chosen_curves, variant_in_words

IM = "im_saavg_rotd50_g"
NRML = "{http://openquake.org/xmlns/nrml/0.5}"


def curves_table(im=IM):
    """Return curves of four variants, two states and two methods, of which cloud is preferred."""
    rows = []
    for (skew, friction), (state, capacity), method in product(
        product((0, 30), (0.0, 0.5)),
        (("slight", 0.01), ("moderate", 0.025)),
        ("cloud", "exceedance"),
    ):
        theta = 0.3 * (capacity / 0.01) * np.cos(np.radians(skew)) ** 0.5 * (1 + 0.1 * friction)
        theta *= 1.1 if method == "exceedance" else 1.0
        rows.append(
            {
                "variant": f"osb1_cf_skew{skew:02d}_gap051_mu{round(100 * friction):03d}",
                "bridge": "osb1",
                "abutment": "contact_friction",
                "skew_deg": skew,
                "gap_mm": 51,
                "friction": friction,
                "component": "column_drift",
                "limit_state": state,
                "demand": "column_drift_ratio",
                "threshold": capacity,
                "capacity_dispersion": 0.35,
                "citation": "test",
                "method": method,
                "preferred": method == "cloud",
                "status": "ok",
                "im": im,
                "theta": theta,
                "theta_low": 0.9 * theta,
                "theta_high": 1.1 * theta,
                "beta": 0.35,
                "beta_total": np.hypot(0.35, 0.35),
                "beta_total_low": 0.4,
                "beta_total_high": 0.6,
                "methods_differ": skew == 30,
                "n_exceed": 9,
                "n_runs": 30,
            }
        )
    return pd.DataFrame(rows)


def curves_file(tmp_path, im=IM):
    path = tmp_path / "curves.parquet"
    curves_table(im).to_parquet(path)
    return path, pd.read_parquet(path)


def test_nrml_has_mean_and_deviation_of_the_lognormal(tmp_path):
    path, curves = curves_file(tmp_path, "im_sa_1p000_rotd50_g")
    out = tmp_path / "fragility.xml"
    code, report = run("export", path, "--format", "nrml", "--out", out)
    assert code == 0
    assert report["curves"] == 8
    assert report["models"][0]["crossing"] == []
    model = ElementTree.parse(out).getroot().find(f"{NRML}fragilityModel")
    assert model.find(f"{NRML}limitStates").text.split() == ["slight", "moderate"]
    functions = model.findall(f"{NRML}fragilityFunction")
    assert len(functions) == 4
    assert functions[0].find(f"{NRML}imls").get("imt") == "SA(1)"
    cloud = curves[(curves["method"] == "cloud") & (curves["limit_state"] == "moderate")]
    first = cloud.sort_values("variant").iloc[0]
    params = functions[0].findall(f"{NRML}params")[1]
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


def test_names_have_only_characters_that_the_other_program_accepts(tmp_path):
    """pelicun cuts names at a hyphen; OpenQuake accepts no dot and 75 characters."""
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
    ids = [each.get("id") for each in root.iter(f"{NRML}fragilityFunction")]
    assert len(set(ids)) == 4
    assert all(re.fullmatch(r"[A-Za-z0-9_:-]{1,75}", each) for each in ids)
    assert f"{first}_hinge-length-m0p75:column_drift" in ids


def test_limit_states_keep_their_number_where_a_milder_one_has_no_estimate(tmp_path):
    path, curves = curves_file(tmp_path, "im_pga_rotd50_g")
    first = curves["variant"].iloc[0]
    hole = (curves["variant"] == first) & (curves["limit_state"] == "slight")
    curves.loc[hole, ["status", "theta", "beta", "beta_total"]] = ["all_exceed", *[np.nan] * 3]
    curves.iloc[::-1].to_parquet(path)  # the order of the rows has no meaning
    out = tmp_path / "fragility.csv"
    _, report = run("export", path, "--format", "pelicun", "--out", out)
    name = f"{first}.column_drift"
    assert report["holes"] == [{"id": name, "missing": ["slight"]}]
    assert report["left_out"] == 1
    row = pd.read_csv(out).set_index("ID").loc[name]
    assert np.isnan(row["LS1-Theta_0"])
    assert row["LS2-Theta_0"] > 0
    described = json.loads((tmp_path / "fragility.json").read_text())[name]
    assert described["LimitStates"]["LS2"]["DS1"]["Description"].startswith("moderate")
    assert "LS1 slight (all_exceed)" in described["Comments"]
    assert described["LimitStates"]["LS2"]["DS1"]["Reference"] == "test"


def test_dlml_folder_has_curves_general_information_and_references(tmp_path):
    path, _ = curves_file(tmp_path, "im_pga_rotd50_g")
    _, report = run("export", path, "--format", "dlml", "--out", tmp_path / "library")
    assert report["files"] == [
        str(tmp_path / f"library/fragility.{end}") for end in ("csv", "json")
    ]
    described = json.loads((tmp_path / "library/fragility.json").read_text())
    about = described.pop("_GeneralInformation")
    assert about["ComponentGroups"] == ["column_drift"]
    assert about["References"] == ["test"]
    assert set(described) == set(pd.read_csv(tmp_path / "library/fragility.csv")["ID"])


def test_nrml_writes_a_file_per_set_of_states(tmp_path):
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


def test_probabilities_over_a_range_and_skew_factors(tmp_path):
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
    curves.assign(var_ln_theta=0.01).to_parquet(path)
    run("export", path, "--format", "csv", "--out", out, "--skew-factors")
    factors = pd.read_csv(out)
    assert len(factors) == 4
    width = np.log(factors["factor_high"] / factors["factor_low"])
    assert width.to_numpy() == pytest.approx(2 * 1.645 * np.sqrt(0.02), rel=1e-3)
    assert factors["hazus_factor"].to_numpy() == pytest.approx(np.sqrt(np.cos(np.pi / 6)))
    assert (factors["theta"] / factors["theta_straight"]).to_numpy() == pytest.approx(
        factors["factor"]
    )
    assert set(factors["interval"]) == {"independent"}


def test_skew_factors_have_the_paired_interval_and_scale_capacities_of_pelicun(tmp_path):
    path, curves = curves_file(tmp_path)
    straight = curves.loc[curves["skew_deg"] == 0].iloc[0]
    pair = straight[["bridge", "abutment", "gap_mm", "friction"]].to_dict() | {
        "demand": f"{straight['component']}/{straight['limit_state']}",
        **{"scope": "variant", "status": "ok", "axis": "skew_deg", "from_value": 0.0},
        **{"to_value": 30.0, "skew_deg": np.nan, "ratio": 0.9, "ci_low": 0.8, "ci_high": 1.0},
    }
    pd.DataFrame([pair]).to_parquet(tmp_path / "median_effects.parquet")
    out = tmp_path / "factors.csv"
    run("export", path, "--format", "csv", "--out", out, "--skew-factors")
    factors = pd.read_csv(out)
    paired = factors[factors["interval"] == "paired"]
    assert len(paired) == 1
    width = paired["factor_high"] / paired["factor_low"]
    assert width.to_numpy() == pytest.approx(1.0 / 0.8)
    scaling = tmp_path / "scaling.json"
    run("export", path, "--format", "pelicun", "--out", scaling, "--skew-factors")
    found = json.loads(scaling.read_text())["30"]
    assert set(found) == {"factor", "low", "high"}
    values = [float(text[1:]) for states in found["factor"].values() for text in states.values()]
    assert sorted(values) == pytest.approx(sorted(factors["factor"]), rel=1e-5)
    curves_out = tmp_path / "pelicun.csv"
    run("export", path, "--format", "pelicun", "--out", curves_out)
    known = {f"{name}-0-1" for name in pd.read_csv(curves_out)["ID"]}
    assert set(found["factor"]) <= known
    assert all(key.startswith("LS") for states in found["low"].values() for key in states)


def test_latex_names_variants_in_words_and_marks_differing_methods(tmp_path):
    path, _ = curves_file(tmp_path)
    tex = tmp_path / "curves.tex"
    run("export", path, "--format", "latex", "--out", tex)
    text = tex.read_text()
    assert r"\beta_\mathrm{total}" in text
    assert "& skew 30 deg, gap 51 mm, friction 0.5 & column drift, slight &" in text
    assert "osb1_cf" not in text.replace(r"\_", "_")
    lines = [line for line in text.splitlines() if line.startswith("osb1")]
    assert all((" * &" in line) == ("skew 30" in line) for line in lines)
    code, found = run("export", path, "--format", "latex", "--out", tex, "--im-range", 0.1, 2)
    assert code == 2
    assert "need --format csv" in found["message"]


def test_variants_in_words_leave_out_axes_that_the_abutment_model_lacks():
    row = {"abutment": "roller", "skew_deg": 22.5, "gap_mm": 0, "friction": 0.0}
    assert variant_in_words(row) == "skew 22.5 deg"
    assert variant_in_words(row | {"abutment": "foreign"}) == "skew 22.5 deg, gap 0 mm, friction 0"


def test_formats_and_options_that_were_removed_are_refused_with_advice(tmp_path):
    path, _ = curves_file(tmp_path)
    code, found = run("export", path, "--format", "xlsx", "--out", tmp_path / "curves.xlsx")
    assert code == 2
    assert "spreadsheets open csv" in found["message"]
    options = ("--hazard", path, "--skew-factors")
    code, found = run("export", path, "--format", "csv", "--out", tmp_path / "x.csv", *options)
    assert code == 2
    assert "a csv is one table" in found["message"]


def test_preferred_curves_are_exported_unless_a_method_is_given(tmp_path):
    path, curves = curves_file(tmp_path)
    first = (curves["variant"] == curves["variant"].iloc[0]) & (curves["limit_state"] == "slight")
    curves.loc[first, "preferred"] = curves.loc[first, "method"] == "exceedance"
    curves.to_parquet(path)
    out = tmp_path / "curves.csv"
    run("export", path, "--format", "csv", "--out", out)
    assert pd.read_csv(out)["method"].value_counts().to_dict() == {"cloud": 7, "exceedance": 1}
    run("export", path, "--format", "csv", "--out", out, "--method", "cloud")
    assert set(pd.read_csv(out)["method"]) == {"cloud"}
    code, found = run("export", path, "--format", "csv", "--out", out, "--method", "ida_interval")
    assert code == 2
    assert "no curves of method 'ida_interval'" in found["message"]


def test_a_state_without_an_estimate_has_one_row():
    curves = curves_table()
    curves["preferred"] &= curves["limit_state"] == "slight"
    chosen = chosen_curves(curves)
    assert len(chosen) == 8
    assert set(chosen["method"]) == {"cloud"}


def test_states_of_several_demands_are_no_damage_scale(tmp_path):
    """Shear and flexural failure do not follow each other: each has a function of its own."""
    curves = curves_table()
    modes = curves["limit_state"].map({"slight": "shear", "moderate": "flexure"})
    demands = modes.map({"shear": "column_shear_dcr", "flexure": "drift_over_capacity"})
    failure = {"component": "column_failure", "limit_state": modes, "demand": demands}
    path = tmp_path / "curves.parquet"
    curves.assign(**failure, threshold=1.0).to_parquet(path)
    _, report = run("export", path, "--format", "nrml", "--out", tmp_path / "curves.xml")
    assert [model["limit_states"] for model in report["models"]] == [["flexure"], ["shear"]]
    run("export", path, "--format", "pelicun", "--out", tmp_path / "curves.csv")
    table = pd.read_csv(tmp_path / "curves.csv")
    assert len(table) == 8
    assert "LS2-Theta_0" not in table
    assert table["ID"].str.endswith(("column_failure_shear", "column_failure_flexure")).all()


def test_curves_that_cross_within_the_range_are_reported(tmp_path):
    path, curves = curves_file(tmp_path, "im_pga_rotd50_g")
    severe = curves["limit_state"] == "moderate"
    curves.loc[severe, ["theta", "beta_total"]] = [0.32, 1.2]
    curves.to_parquet(path)
    _, report = run("export", path, "--format", "nrml", "--out", tmp_path / "curves.xml")
    assert len(report["models"][0]["crossing"]) == 4
    assert any("curves cross in 4 functions" in note for note in report["notes"])


def test_csv_keeps_rows_without_an_estimate_and_their_status(tmp_path):
    path, curves = curves_file(tmp_path)
    reached = (curves["method"] != "exceedance") | (curves["limit_state"] == "slight")
    curves.assign(status=np.where(reached, "ok", "no_exceedance")).to_parquet(path)
    out = tmp_path / "curves.csv"
    run("export", path, "--format", "csv", "--out", out, "--method", "exceedance")
    table = pd.read_csv(out)
    assert table["status"].value_counts().to_dict() == {"ok": 4, "no_exceedance": 4}


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
    assert measure_names("im_pgv_rotd50_mps")[:2] == ("PGV", 100.0)
    assert measure_names("im_arias_mps")[0] == ""


@pytest.mark.parametrize(
    ("low", "high", "count"),
    [(0.1, 2.0, 1), (0.0, 2.0, 7), (2.0, 0.1, 7), (0.1, 0.1, 7), (0.1, np.inf, 7)],
)
def test_a_range_of_intensities_rises_above_zero_and_has_two_points(low, high, count):
    with pytest.raises(InputError, match="must rise above 0"):
        CsvContent(im_range=(low, high), points=count)
    assert CsvContent(im_range=(0.1, 2.0), points=2).points == 2
