"""`skewbridge export`: curves as other tools and papers take them."""

import json
import re
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from cli_json import answer
from fragility_tables import FAILURES, two_mode_runs
from fragility_tables import curves_of as fitted_curves
from skewbridge.fragility.exports import chosen_curves, measure_names, variant_in_words
from skewbridge.fragility.union import curve_probability

NRML = "{http://openquake.org/xmlns/nrml/0.5}"
PGA = "im_pga_rotd50_g"


def curves_of(im="im_saavg_rotd50_g"):
    """Return curves of four variants, two states and two methods, of which cloud is preferred."""
    cases = product((0, 30), (0.0, 0.5), (0.01, 0.025), ("cloud", "exceedance"))
    table = pd.DataFrame(cases, columns=["skew_deg", "friction", "threshold", "method"])
    skew, friction = table["skew_deg"], table["friction"]
    table["variant"] = [f"osb1_cf_skew{s:02d}_gap051_mu{100 * f:03.0f}"
                        for s, f in zip(skew, friction, strict=True)]  # fmt: skip
    is_cloud = table["method"] == "cloud"
    theta = 30.0 * table["threshold"] * np.cos(np.radians(skew)) ** 0.5
    theta *= (1 + 0.1 * friction) * np.where(is_cloud, 1.0, 1.1)
    given = {
        "bridge": "osb1", "abutment": "contact_friction", "gap_mm": 51, "im": im,
        "component": "column_drift", "demand": "column_drift_ratio", "capacity_dispersion": 0.35,
        "citation": "test", "status": "ok", "theta_low": 0.9 * theta, "theta_high": 1.1 * theta,
        "beta": 0.35, "beta_total": np.hypot(0.35, 0.35), "beta_total_low": 0.4,
        "beta_total_high": 0.6, "methods_differ": skew == 30, "n_exceed": 9, "n_runs": 30,
    }  # fmt: skip
    names = table["threshold"].map({0.01: "slight", 0.025: "moderate"})
    return table.assign(theta=theta, limit_state=names, preferred=is_cloud, **given)


def with_hole(curves):
    """Return curves in reversed order, of which the first variant lacks the mildest state."""
    hole = (curves["variant"] == curves["variant"].iloc[0]) & (curves["limit_state"] == "slight")
    curves.loc[hole, ["status", "theta", "beta", "beta_total"]] = ["all_exceed", *[np.nan] * 3]
    return curves.iloc[::-1]


@pytest.fixture
def export(tmp_path):
    def write(curves, file_format, name, *options, refused=""):
        curves.to_parquet(tmp_path / "curves.parquet")
        out = tmp_path / name
        given = ("--format", file_format, "--out", out, *options)
        code = 2 if refused else 0
        report = answer("export", tmp_path / "curves.parquet", *given, code=code)
        assert refused in report.get("message", "")
        return out, report

    return write


def test_nrml_has_mean_and_deviation_of_the_lognormal_and_a_file_per_set_of_states(export):
    curves = curves_of("im_sa_1p000_rotd50_g")
    out, report = export(curves, "nrml", "fragility.xml")
    assert (report["curves"], report["models"][0]["crossing"]) == (8, [])
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
    _, report = export(with_hole(curves_of(PGA)), "nrml", "fragility.xml")
    assert {model["functions"] for model in report["models"]} == {1, 3}
    assert report["curves"] == 7
    models = [ElementTree.parse(name).getroot()[0] for name in report["files"]]
    states = {model[1].text: len(model) - 2 for model in models}
    assert states == {"slight moderate": 3, "moderate": 1}
    assert any("fragility.xml was not written" in note for note in report["notes"])


def test_names_have_only_characters_that_the_other_program_accepts(export):
    """pelicun cuts names at a hyphen; OpenQuake accepts no dot and 75 characters."""
    curves = curves_of(PGA)
    first, second = curves["variant"].unique()[:2]
    names = {first: f"{first}_hinge-length-m0p75", second: f"{second}_hinge_length-m0p75{'x' * 60}"}
    curves["variant"] = curves["variant"].replace(names)
    ids = pd.read_csv(export(curves, "pelicun", "fragility.csv")[0])["ID"]
    assert ids.is_unique
    assert not ids.str.contains("-").any()
    root = ElementTree.parse(export(curves, "nrml", "fragility.xml")[0]).getroot()
    ids = [each.get("id") for each in root.iter(f"{NRML}fragilityFunction")]
    assert len(set(ids)) == 4
    assert all(re.fullmatch(r"[A-Za-z0-9_:-]{1,75}", each) for each in ids)
    assert f"{first}_hinge-length-m0p75:column_drift" in ids


def test_pelicun_keeps_the_number_of_a_state_where_a_milder_one_has_no_estimate(export):
    curves = with_hole(curves_of(PGA))
    out, report = export(curves, "pelicun", "fragility.csv")
    name = f"{curves['variant'].iloc[-1]}.column_drift"
    assert (report["holes"], report["left_out"]) == ([{"id": name, "missing": ["slight"]}], 1)
    table = pd.read_csv(out).set_index("ID")
    named = table[["Demand-Type", "Demand-Directional", "LS2-Family"]].to_numpy().tolist()
    assert named == [["Peak Ground Acceleration", 1, "lognormal"]] * 4
    hole, others = table.loc[name], table.drop(name)
    assert np.isnan(hole["LS1-Theta_0"])
    assert hole["LS2-Theta_0"] > 0
    assert (others["LS1-Theta_0"] < others["LS2-Theta_0"]).all()
    names = json.loads(out.with_suffix(".json").read_text())
    assert names.pop("_GeneralInformation")["References"] == ["test"]
    assert set(names) == set(table.index)
    assert "LS1 slight (all_exceed)" in names[name]["Comments"]
    assert names[name]["LimitStates"]["LS2"]["DS1"]["Reference"] == "test"


def test_latex_names_variants_in_words_and_marks_differing_methods(export):
    out, report = export(curves_of(), "latex", "curves.tex")
    assert "lacks what comes from median_effects.parquet, joint.parquet" in report["notes"][-1]
    text = out.read_text()
    assert "& skew 30 deg, gap 51 mm, friction 0.5 & column drift, slight &" in text
    lines = [line for line in text.splitlines() if line.startswith("osb1")]
    assert all((" * &" in line) == ("skew 30" in line) for line in lines)
    # axes that the abutment model lacks are left out
    row = {"abutment": "roller", "skew_deg": 22.5, "gap_mm": 0, "friction": 0.0}
    assert variant_in_words(row) == "skew 22.5 deg"


def test_preferred_curves_are_exported_with_one_row_where_there_is_no_estimate(export):
    curves = curves_of()
    first = (curves["variant"] == curves["variant"].iloc[0]) & (curves["limit_state"] == "slight")
    curves.loc[first, "preferred"] = curves.loc[first, "method"] == "exceedance"
    # rows without an estimate keep their status
    curves["status"] = np.where(curves["limit_state"] == "moderate", "no_exceedance", "ok")
    table = pd.read_csv(export(curves, "csv", "curves.csv")[0])
    assert table["method"].value_counts().to_dict() == {"cloud": 7, "exceedance": 1}
    assert table["status"].value_counts().to_dict() == {"ok": 4, "no_exceedance": 4}
    curves["preferred"] = (curves["method"] == "cloud") & (curves["limit_state"] == "slight")
    chosen = chosen_curves(curves)
    assert (len(chosen), set(chosen["method"])) == (8, {"cloud"})


def test_states_of_several_demands_are_no_damage_scale(export):
    """Shear and flexural failure do not follow each other: each has a function of its own."""
    curves = curves_of()
    modes = curves["limit_state"].map({"slight": "shear", "moderate": "flexure"})
    demands = modes.map({"shear": "column_shear_dcr", "flexure": "drift_over_capacity"})
    failure = {"component": "column_failure", "limit_state": modes, "demand": demands}
    curves = curves.assign(**failure, threshold=1.0)
    _, report = export(curves, "nrml", "curves")
    assert [model["limit_states"] for model in report["models"]] == [["flexure"], ["shear"]]
    assert report["files"][0].endswith("curves_column_failure_flexure.xml")
    table = pd.read_csv(export(curves, "pelicun", "curves.csv")[0])
    assert len(table) == 8
    assert "LS2-Theta_0" not in table
    assert table["ID"].str.endswith(("column_failure_shear", "column_failure_flexure")).all()
    # curves of one demand that cross within the range are reported
    curves = curves_of(PGA)
    curves.loc[curves["limit_state"] == "moderate", ["theta", "beta_total"]] = [0.32, 1.2]
    _, report = export(curves, "nrml", "curves.xml")
    assert len(report["models"][0]["crossing"]) == 4
    assert any("curves cross in 4 functions" in note for note in report["notes"])


def test_formats_and_options_that_do_not_fit_are_refused(export):
    export(curves_of("im_sa_t1_rotd50_g"), "nrml", "out", refused="has no name in OpenQuake")
    export(curves_of(PGA), "xlsx", "out", refused="must be one of nrml, pelicun, csv, latex")
    bad = curves_of(PGA).astype({"beta": object}).replace({"beta": {0.35: "x"}})
    export(bad, "nrml", "out", refused="beta")
    published = curves_of(PGA).rename(columns={"variant": "row"})  # as in table.csv
    export(published, "csv", "out", refused="the table of curves has no column 'variant'")
    assert measure_names("im_pgv_rotd50_mps")[:2] == ("PGV", 100.0)
    assert measure_names("im_arias_mps")[0] == ""


@pytest.fixture(scope="module", name="failures")
def _failures():
    """Curves of column failure; some variants fail in both modes."""
    table = pd.concat([two_mode_runs(seed, 24) for seed in range(12)], ignore_index=True)
    return fitted_curves(table, FAILURES)


def test_a_union_of_failure_modes_keeps_its_probabilities_in_every_format(export, failures):
    found = failures[failures["preferred"] & (failures["limit_state"] == "any")]
    unions = found[found["model"] == "union"].set_index("variant").to_dict("index")
    assert 2 < len(unions) < 12
    im = np.geomspace(0.05, 3.0, 80)
    # OpenQuake interpolates linearly between discrete levels
    _, report = export(failures.assign(im=PGA), "nrml", "curves.xml")
    functions = {
        function.get("id"): function
        for file in report["files"]
        for function in ElementTree.parse(file).getroot().iter(f"{NRML}fragilityFunction")
    }
    table = pd.read_csv(export(failures.assign(im=PGA), "pelicun", "curves.csv")[0], index_col="ID")
    for name, row in unions.items():
        expected = curve_probability(im, row)
        function = functions[f"{name}:column_failure_any"]
        assert function.get("format") == "discrete"
        levels, poes = (np.array(part.text.split(), dtype=float) for part in function)
        assert np.all(np.diff(levels) > 0.0)
        read = np.interp(im, levels, poes, left=0.0)
        np.testing.assert_allclose(read, expected, atol=5e-5)
        # pelicun accepts strictly increasing points from 0 to 1 and prints them with 6 digits
        state = table.loc[f"{name}.column_failure_any"]
        assert state["LS1-Family"] == "multilinear_CDF"
        points = [[float(value) for value in part.split(",")]
                  for part in state["LS1-Theta_0"].split("|")]  # fmt: skip
        assert all(np.all(np.diff([float(f"{v:g}") for v in part]) > 0.0) for part in points)
        assert (points[1][0], points[1][-1]) == (0.0, 1.0)
        np.testing.assert_allclose(np.interp(im, *points), expected, atol=5e-5)
        for mode in ("shear", "flexure"):
            if (other := functions.get(f"{name}:column_failure_{mode}")) is not None:
                assert other.get("format") == "continuous"
                own = failures.query("variant == @name and limit_state == @mode and preferred")
                assert np.all(read >= curve_probability(im, own.iloc[0].to_dict()) - 5e-5)


def test_an_exported_csv_is_exported_again_as_its_curves(export, failures):
    for curves in (with_hole(curves_of(PGA)), failures.assign(im=PGA)):
        table, _ = export(curves, "csv", "table.csv")
        for file_format in ("nrml", "pelicun", "latex", "csv"):
            out, report = export(curves, file_format, "direct.csv")
            direct = {path: Path(path).read_text() for path in report["files"]}
            again = answer("export", table, "--format", file_format, "--out", out)
            assert again == report
            assert {path: Path(path).read_text() for path in again["files"]} == direct


def test_exports_flag_medians_outside_the_motions(export, failures):
    beyond = failures["variant"].isin(["v003", "v007"]) & (failures["status"] == "ok")
    failures = failures.assign(extrapolated=beyond)
    outside = failures[failures["preferred"] & beyond]
    names, count = set(outside["variant"]), len(outside)
    assert count > 2
    table = pd.read_csv(export(failures, "csv", "curves.csv")[0])
    assert set(table.loc[table["extrapolated"], "variant"]) == names
    files = {}
    for form in ("csv", "nrml", "pelicun"):
        files[form], report = export(failures.assign(im=PGA), form, f"curves.{form}")
        assert any(f"{count} medians are extrapolated" in note for note in report["notes"])
    described = json.loads(files["pelicun"].with_suffix(".json").read_text()).items()
    flagged = {key.partition(".")[0] for key, text in described if "extrapolated" in str(text)}
    assert flagged == names
    assert export(failures, "latex", "table.tex")[0].read_text().count(" † &") == count
