"""Hazard curves from files, annual rates of limit states, and their effects."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import integrate
from scipy.stats import norm

from cli_json import answer, invoke
from fragility_tables import FAILURES, IM, SETTINGS, STATES, ready, synthetic_demands, two_mode_runs
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.demand_table import intensity_change
from skewbridge.fragility.hazard import hazard_curve, measure_column, read_hazard
from skewbridge.fragility.joint import JointModel, joint_table
from skewbridge.fragility.rates import curve_rate, decision, rate_effects, rate_table, target_rate
from skewbridge.fragility.system import system_curves
from skewbridge.fragility.union import curve_probability
from skewbridge.study.config import MEASURES, parse_config
from skewbridge.study.inputs import axis_warnings
from skewbridge.study.results import joint_rows

PGA = "im_pga_rotd50_g"
TABLE = """im,rate,rate_p16,rate_p84
0.03,0.3,0.2,0.4\n0.1,0.05,0.03,0.08\n0.4,4e-3,2e-3,7e-3\n1.5,2e-4,8e-5,4e-4\n4.0,9e-6,3e-6,2e-5
"""
CAPACITIES = """
- {component: column_drift, demand: column_drift_ratio, unit: percent, dispersion: 0.35,
   citation: test, states: {moderate: 2.5}}
- {component: unseating, demand: unseating_m, unit: mm, dispersion: 0.35, citation: test,
   states: {slight: 114.0}}
"""


@pytest.fixture(name="file")
def _file(tmp_path):
    def write(text, name="hazard.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def curve_of(path, measures=MEASURES, usual=IM):
    return hazard_curve(path, measures, usual)


def openquake(kind, imt, poes, sites=1, time="investigation_time=50.0, "):
    head = f"#,,,,\"generated_by='OpenQuake engine 3.23', kind='{kind}', {time}imt='{imt}'\"\n"
    return head + "lon,lat,depth,poe-0.1,poe-0.5,poe-1.5\n" + f"-120,36,0,{poes}\n" * sites


def usgs(xlabel="Ground Motion (g)", component="Total"):
    curve = {"component": component, "values": {"xs": [0.1, 0.5, 1.5], "ys": [0.02, 1e-3, 0.0]}}
    item = {"imt": {"value": "SA1P0", "display": "1.0 Second"}, "data": [curve]}
    return json.dumps({"response": {"metadata": {"xlabel": xlabel}, "hazardCurves": [item]}})


def test_every_format_gives_levels_in_the_unit_of_the_column_and_annual_rates(file):
    plain = curve_of(file(TABLE))
    assert (plain.im, *plain.quantiles, *plain.rates[:, 1]) == (IM, 0.16, 0.84, 0.05, 0.03, 0.08)
    file(openquake("mean", "SA(1.0)", "1.0,0.5,0.01"), "oq/hazard_curve-mean-SA_1.csv")
    file(openquake("quantile-0.5", "SA(1.0)", "0.9,0.4,0.0"), "oq/quantile_curve-0.5.csv")
    for name in ("map-mean", "curve-rlz-000"):
        file("#,kind='mean'\nlon,lat,PGA-0.1\n0,0,1\n", f"oq/hazard_{name}_1.csv")  # not read
    folder = file(openquake("mean", "PGV", "0.9,0.5,0.1"), "oq/hazard_curve-mean-PGV_1.csv").parent
    pgv, sa = sorted(read_hazard(folder), key=lambda each: each.im)
    assert pgv.levels == pytest.approx([0.001, 0.005, 0.015])
    # a probability of one has no rate: the level is left out
    assert sa.rates[0] == pytest.approx(-np.log1p([-0.5, -0.01]) / 50.0)
    assert [curve_of(folder, usual=name).im for name in (IM, pgv.im)] == [sa.im, pgv.im]
    older = {"imt": {"value": "PGA"}, "xlabel": "Ground Motion (g)", "xvalues": [0.1, 0.5]}
    older = [{"metadata": older, "data": [{"component": "Total", "yvalues": [0.02, 1e-3]}]}]
    for text, name, measure, rates in (
        ("PGV (cm/s) , Rate\n50,0.001\n10,0.02\n", "hazard.csv", "im_pgv_rotd50_mps", [0.02, 1e-3]),
        (usgs(), "hazard.json", "im_sa_1p000_rotd50_g", [0.02, 1e-3]),
        (json.dumps({"response": older}), "old.json", PGA, [0.02, 1e-3]),
        ("name,lon,lat,0.1,0.5\nA,-120,36,0.02,0.001\n", "PGA/curves.csv", PGA, None),
        ("name,lon,lat,10,50\nA,0,0,0.02,0.001\n", "PGV.csv", "im_pgv_rotd50_mps", None),
    ):
        (found,) = read_hazard(file(text, name))
        assert (found.im, found.levels.tolist()) == (measure, [0.1, 0.5])
        assert rates in (None, found.rates[0].tolist())
    names = {"SA(0.2 s)": "im_sa_0p200_", "SA0P2": "im_sa_0p200_", "AvgSA": "im_saavg_rot",
             "Sa_avg": "im_saavg_rot", "Arias": "", "im_cav_mps": "im_cav_mps"}  # fmt: skip
    assert {name: measure_column(name)[:12] for name in names} == names


BAD = {
    "im,rate\n0.1,0.01\n0.2,0.02\n": "rate must not increase with the intensity (row 1)",
    "im,rate\n0.1,0.1\n0.3,0.01\n0.2,0.001\n": "im must increase (row 2)",
    "im,rate\n0.1,0.1\n0.2,\n0.4,0.001\n": "rate is not a number (row 1)",
    "im,rate\n98.1,0.1\n490,0.01\n": "im must be at most 20 g or m/s (rows 0, 1)",
    "im,rate\n0.1,0.01\n": "at least two intensities",
    "PGA,rate\n0.1,0.01\n0.2,0.001\n": "the unit of PGA is missing: write PGA (g)",
    "PGA (cm/s),rate\n0.1,0.01\n0.2,0.001\n": "PGA cannot have the unit cm/s",
    "PGA (cm/s2),rate\n10,0.01\n20,0.001\n": "is not a measure with its unit, such as",
    "im,poe\n0.1,0.01\n0.2,0.001\n": "the columns must be an intensity",
    "im,rate,upper\n0.1,0.01,1\n0.2,0.001,1\n": "'upper' is not a fractile such as rate_p16",
    "im,rate,rate_p100\n0.1,0.01,1\n0.2,0.001,1\n": "must be above 0 and below 1, got 1",
    "im,rate,rate_p16,rate_p84\n1,0.1,0.2,0.1\n2,0.01,0.02,0.01\n": "grow with the fractile",
    "im,rate,rate_p84\n0.1,0.01,1\n0.2,0.001,1\n": "one fractile (84 %) gives no interval",
    "SA(0.2) (g),rate\n0.1,0.01\n0.2,0.001\n": "give the hazard of a measure of the study: im_pga",
    "name,lon,lat,0.1,0.2\nA,0,0,1,0.1\nB,0,0,1,0.1\n": "has the hazard of 2 sites",
    "name,lon,lat,0.1,0.2\nA,0,0,1,0.1\n": "name the file or its folder after the measure",
    openquake("mean", "PGA", "0.5,0.1,0.01", sites=2): "has the hazard of 2 sites",
    openquake("mean", "PGA", "0.5,0.1,0.01", time=""): "must give investigation_time",
    openquake("mean", "PGA", "1.5,0.1,0.01"): "poe must be within 0..1",
    openquake("quantile-0.15", "PGA", "0.5,0.1,0.01"): "has fractiles only",
    usgs(xlabel="Ground Motion"): "the unit of SA1P0 is missing",
    usgs(component="Fault"): "SA1P0 must have one curve of the component Total, got 0",
    usgs().replace("[0.1, 0.5, 1.5]", "[0.1, 0.5]"): "there are 2 intensities and 3 rates",
    "{}": "has no hazard curve",
}  # fmt: skip


@pytest.mark.parametrize(("text", "words"), BAD.items(), ids=range(len(BAD)))
def test_bad_hazard_gives_one_error_that_names_the_file(file, text, words):
    path = file(text, "site.json" if text.startswith("{") else "site.csv")
    with pytest.raises(InputError) as caught:
        curve_of(path)
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(path))


def test_rates_that_look_like_probabilities_in_50_years_are_doubted(file, caplog):
    levels = np.geomspace(0.01, 2.0, 12)
    for a_g, levels_g in ((0.2, levels), (0.6, levels), (0.6, levels[5:])):
        x = np.log(levels_g / a_g)
        rates = np.exp(-2.2 * x - 0.17 * x**2) / 475  # up to 1.6 per year at 0.01 g
        for values, count in ((rates, 0), (1.0 - np.exp(-50 * rates), 1)):
            caplog.clear()
            table = pd.DataFrame({"im": levels_g, "rate": values})
            curve_of(file(table.to_csv(index=False)))
            assert caplog.text.count("looks like a probability in many years") == count
    site = str(file("im,rate\n0.15,0.5\n0.3,0.1\n0.5,0.02\n"))
    two = {"bridge": ["osb1", "osb1_fixed_era1"]}
    text, of_t1 = axis_warnings(parse_config({"hazard": {"file": site}, "grid": two}))
    assert of_t1.endswith("bridges have 0.719 s, 0.467 s: run a study for each, or use Sa(1.0 s)")
    assert text.startswith("hazard.csv: 0.02 per year at 0.5 looks like")
    site = str(file("SA(1.0) (g),rate\n0.15,0.02\n0.5,0.001\n"))
    assert not [*axis_warnings(parse_config({"hazard": {"file": site}, "grid": two}))]
    # a hazard sets the measure of the curves before any analysis
    path = str(file("SA(1.0) (g),rate\n0.1,0.01\n0.2,0.001\n"))
    assert parse_config({"hazard": {"file": path}}).fragility.im == "im_sa_1p000_rotd50_g"
    plain = str(file("im,rate\n0.1,0.01\n0.2,0.001\n", "plain.csv"))
    assert parse_config({"hazard": {"file": plain}, "fragility": {"im": PGA}}).fragility.im == PGA
    with pytest.raises(InputError, match="give the hazard of a measure of the study"):
        parse_config({"hazard": {"file": str(file("SA(0.3) (g),rate\n0.1,0.01\n0.2,1e-3\n"))}})


def rates_of(rows, states, hazard):
    models = fit_models(rows, states, SETTINGS)
    curves = fit_study(models, states, SETTINGS)
    system = system_curves(models, states, SETTINGS, hazard=hazard)
    table = rate_table(curves, models, states, system, hazard)
    further = {"curves": curves, "system": system}
    return curves, table, rate_effects(models, states, hazard, SETTINGS, **further)


def quadrature(probability, hazard):
    """Return int P |dH| by adaptive quadrature between the points of a hazard curve."""
    x, h = np.log(hazard.levels), np.log(hazard.rates[0])

    def density(t, i):
        k = (h[i] - h[i + 1]) / (x[i + 1] - x[i])
        return probability(np.exp(t)) * k * np.exp(h[i] - k * (t - x[i]))

    error = {"epsabs": 0.0, "epsrel": 1e-10, "limit": 200}
    return sum(integrate.quad(density, x[i], x[i + 1], i, **error)[0] for i in range(x.size - 1))


def test_rates_agree_with_independent_quadrature(file):
    hazard = curve_of(file(TABLE))
    rows = ready(pd.concat([two_mode_runs(n, 24) for n in range(6)], ignore_index=True), FAILURES)
    curves, table, _ = rates_of(rows, FAILURES, hazard)
    keys = ["variant", "component", "limit_state"]
    fitted = curves[curves["preferred"] & (curves["status"] == "ok")].merge(table, on=keys)
    assert len(fitted) > 8
    assert (fitted["theta_flexure"].notna()).any()
    for row in fitted.to_dict("records"):
        expected = quadrature(lambda im, row=row: curve_probability(im, row), hazard)
        assert row["annual_rate"] == pytest.approx(expected, rel=1e-6)
        assert row["annual_rate_low"] < row["annual_rate"] < row["annual_rate_high"]
        assert row["probability_50y"] == pytest.approx(-np.expm1(-50.0 * expected))
        last = curve_probability(4.0, row) * 9e-6
        assert row["share_outside_low"] == pytest.approx(last / (expected + last), rel=1e-5)
    # a curve that starts at 0.2 g lacks at most the stated share
    x = np.array([0.2, *hazard.levels[2:]])
    logs = [np.interp(np.log(x), np.log(hazard.levels), row) for row in np.log(hazard.rates)]
    cut = rates_of(rows, FAILURES, replace(hazard, levels=x, rates=np.exp(logs)))[1]
    lost, said = 1.0 - cut["annual_rate"] / table["annual_rate"], cut["share_below"]
    assert 0.1 < lost.max() < said.max() < 0.6
    assert (lost.dropna() <= said[lost.notna()] + 1e-3).all()
    assert table["share_below"].max() < 0.1 * said.max()
    # no state is exceeded more often than the lowest intensity, here far above all medians
    mean = replace(hazard, rates=hazard.rates[:1], quantiles=hazard.quantiles[:0])
    high = rates_of(rows, FAILURES, replace(mean, levels=20.0 * hazard.levels))[1]
    assert (high["annual_rate_high"].round(9) == 0.3).sum() > 2
    assert high["annual_rate_high"].max() == pytest.approx(0.3)
    limit = np.sqrt(0.2 * 0.4) * 2.0 ** (0.5 * norm.ppf(0.975) / norm.ppf(0.84))
    assert hazard.highest_rate(0.95) == pytest.approx(limit)
    # fractiles of the hazard widen intervals
    narrow, wide = rates_of(rows, FAILURES, mean)[1].dropna(), table.dropna()
    assert narrow["annual_rate"].tolist() == pytest.approx(wide["annual_rate"].tolist())
    assert (wide["annual_rate_high"] > narrow["annual_rate_high"]).all()
    assert (wide["annual_rate_low"] < narrow["annual_rate_low"]).all()


def test_states_without_an_estimate_have_bounds_and_effects_are_paired(file):
    hazard = curve_of(file(TABLE))
    states = [state for state in STATES if state.component in ("unseating", "column_drift")]
    rows = ready(synthetic_demands(motions=24, frictions=(50,), skew_effect=0.0), states)
    rows["unseating_m"] *= np.exp(0.15 * rows["skew_deg"] / 30.0)
    curves, table, effects = rates_of(rows, states, hazard)
    none = table[table["status"] == "no_exceedance"]
    is_bound = none["annual_rate"].isna() & (none["annual_rate_low"] == 0.0)
    assert (is_bound & none["annual_rate_high"].between(1e-7, 1e-2)).sum() == len(none) > 0
    # fractiles of the hazard widen bounds, and intervals of fits to outcomes
    mean = replace(hazard, rates=hazard.rates[:1], quantiles=hazard.quantiles[:0])
    (models,) = fit_models(rows, states, SETTINGS)
    given = curves.assign(method="exceedance"), [models], states, pd.DataFrame()
    narrow, wide = (rate_table(*given, of_site).fillna(0.0) for of_site in (mean, hazard))
    assert (wide["annual_rate_high"] > 1.2 * narrow["annual_rate_high"]).all()
    assert (wide["annual_rate_low"] <= narrow["annual_rate_low"]).all()
    pooled = effects[effects["scope"] == "pooled"].set_index(["component", "limit_state", "axis"])
    skew = pooled.loc[("unseating", "slight", "skew_deg")].set_index("to_value")
    fitted = table.query("component == 'unseating' and limit_state == 'slight'")
    at = fitted.pivot_table(index="gap_mm", columns="skew_deg", values="annual_rate")
    assert skew.loc[45.0, "ratio"] == pytest.approx(np.exp(np.log(at[45] / at[0]).mean()), rel=1e-9)
    assert skew.loc[45.0, "direction"] == 1
    state = states[-4]
    # pairs of variants are those of the medians: all, if unknown outcomes do not change the ratio
    one = curves["variant"] == curves["variant"].iloc[0]
    for doubt, kept in ((1.5, 8), (np.where(one, 1.0, 1.5), 0)):
        few = curves.assign(preferred=one, theta_none_exceed=doubt, theta_all_exceed=1.0)
        few = rate_effects([models], states, hazard, SETTINGS, curves=few, axes=["skew_deg"])
        assert (few.query("scope == 'pooled'")["n_cells"] == 2).sum() == kept
    bent = rows[rows["variant"] == rows["variant"].iloc[0]].reset_index(drop=True)
    bent["unseating_m"] *= np.maximum(bent[IM] / 0.4, 1.0) ** 1.5
    # rates are of the model, not of its curve, also with one variant; panels cross the bend
    for runs, rel in ((rows, 1e-6), (bent, 1e-4)):
        (one,), found = fit_models(runs, states, SETTINGS), rates_of(runs, states, hazard)[1]
        values = one.variants.iloc[0]
        point = one.fit(state).model.at(values)

        def probability(im, at=point):
            return norm.cdf(at.score(state.threshold, state.dispersion, np.array(np.log(im)))[0])

        keys = ["variant", "component", "limit_state"]
        rate = found.set_index(keys).loc[(values["variant"], state.component, state.name)]
        assert rate["annual_rate"] == pytest.approx(quadrature(probability, hazard), rel=rel)
    # the scatter of motions cancels: the ratio is far more certain than a rate
    width = np.log(fitted["annual_rate_high"] / fitted["annual_rate_low"]).min()
    assert np.log(skew["ci_high"] / skew["ci_low"]).max() < 0.4 * width
    # one hazard curve for the measures of two bridges
    both = pd.concat([rows, rows.assign(**{IM: 1.26 * rows[IM]})])
    assert intensity_change(both, (), IM) == f"{IM} differs by up to 26% under one motion"
    assert intensity_change(rows, (), IM) == ""
    # a system fails at least as often as any of its components
    is_system = table["component"] == "system"
    system = table[is_system].set_index(["variant", "limit_state"])["annual_rate"]
    parts = table[~is_system].groupby(["variant", "limit_state"])["annual_rate"].max().dropna()
    assert (system.reindex(parts.index) >= 0.99 * parts).all()
    variants = curves[["variant", "bridge", "abutment", "skew_deg", "gap_mm", "friction"]]
    lost = variants.drop_duplicates().assign(limit_state="slight", level=0.9, theta_bound=0.1)
    lost["status"] = ["no_component"] * 2 + ["all_exceed"] * (len(lost) - 2)
    without = rate_table(curves, [models], states, lost, hazard).query("component == 'system'")
    assert without["annual_rate"].isna().tolist() == [True] * len(lost)
    assert without["annual_rate_low"].fillna(0.0).gt(0.0).tolist()[1:3] == [False, True]
    wide = curves.assign(status="bounds_too_wide")
    wide = rate_table(wide, [models], states, pd.DataFrame(), hazard)
    is_ordered = wide["annual_rate_low"] < wide["annual_rate_high"]
    assert is_ordered[wide["annual_rate_high"].notna()].all()
    assert wide["annual_rate"].isna().all()


def test_ratios_of_systems_need_the_same_components(file):
    states = [state for state in STATES if state.component in ("unseating", "column_drift")]
    runs = synthetic_demands(skews=(0, 45), gaps=(25, 51), frictions=(50,), motions=16)
    runs = ready(runs.assign(event=runs["motion_id"].str[-1]), states)
    assert runs["event"].nunique() == 10
    hazard, lacks = curve_of(file(TABLE)), (runs["skew_deg"] == 0) & (runs["gap_mm"] == 51)
    results: list[pd.DataFrame] = []
    for without in (lacks & False, lacks, runs["skew_deg"] == 0):
        # where no run reaches unseating, the system is the drift alone
        demand = runs["unseating_m"].where(~without, 1e-3 * runs["unseating_m"])
        effects = rates_of(runs.assign(unseating_m=demand), states, hazard)[2]
        assert set(effects["n_motions"]) == {16}
        system = effects.query("component == 'system' and limit_state == 'slight'")
        assert (system["ratio"].notna() == (system["status"] == "ok").to_numpy()).all()
        keys = ["axis", "scope", "gap_mm", "skew_deg"]
        results.append(system.set_index(system[keys].fillna(-1.0).apply(tuple, axis=1)))
    same, one, both = results
    along_skew = [("skew_deg", "variant", gap, -1.0) for gap in (25.0, 51.0)]
    pooled = [(axis, "pooled", -1.0, -1.0) for axis in ("skew_deg", "gap_mm")]
    assert same["status"].eq("ok").all()
    assert same.loc[[pooled[0]], "n_cells"].item() == 2
    # the pair with equal components remains, and the pooled row has only this pair
    assert one["status"].loc[along_skew].tolist() == ["ok", "different_components"]
    assert [*one["reason"].loc[along_skew[1:]]] == ["only osb1_cf_skew45_gap051_mu050: unseating"]
    assert one["reason"].loc[pooled].tolist() == ["1 of 2 pairs have different components"] * 2
    assert one["n_cells"].loc[pooled].tolist() == [1, 1]
    assert one["ratio"].loc[[pooled[0]]].item() == one["ratio"].loc[[along_skew[0]]].item()
    # along skew no pair remains; along the gap each pair has equal components, but the pairs have
    # not: the mean is of the system with more components
    assert both["status"].loc[pooled].tolist() == ["different_components", "ok"]
    assert both["n_cells"].loc[pooled].tolist() == [0, 1]
    assert both["reason"].loc[[pooled[1]]].item() == "1 of 2 pairs have other components"
    along_gap = ("gap_mm", "variant", -1.0, 45.0)
    assert both["ratio"].loc[[pooled[1]]].item() == both["ratio"].loc[[along_gap]].item()


def test_commands_give_rates_for_the_measure_of_the_hazard(file, tmp_path, monkeypatch):
    demands = synthetic_demands(motions=12, frictions=(50,))
    demands["unseating_m"] *= 1.0 + demands["skew_deg"] / 90.0
    tables, study = (tmp_path / "demands.parquet", tmp_path / "other.parquet"), tmp_path / "study"
    demands.to_parquet(tables[0])
    demands.assign(unseating_m=1.1 * demands["unseating_m"]).to_parquet(tables[1])
    given = ("--hazard", site := file(TABLE))
    file(CAPACITIES, "config/limit_states.yaml")
    monkeypatch.chdir(tmp_path)
    # an intensity im is that of the table
    plain, pga = file("im,rate\n0.1,0.01\n2.0,0.0001\n", "plain.csv"), tmp_path / "pga.csv"
    one_gap = demands.query("gap_mm == 51").filter(regex=f"^(?!im_|gap|variant)|^{IM}$")
    one_gap.rename(columns={IM: PGA}).to_csv(pga)
    pga = answer("statistics", pga, "--hazard", plain, "--out", tmp_path / "pga")
    assert (pga["im"], pga["tables"]["rates"] > 0) == (PGA, True)
    report = answer("statistics", tables[0], *given, "--out", study)
    rates = pd.read_parquet(study / "fragility/rates.parquet")
    assert report["tables"]["rates"] == len(rates) == rates["im"].eq(IM).sum() > 0
    # predictions at a variant of the study are its rates
    at = ("--skew-deg", 30, "--gap-mm", 51, "--friction", 0.5, "--hazard", site)
    own = rates.query("skew_deg == 30 and gap_mm == 51 and component != 'system'")
    own = own.set_index(["component", "limit_state"])
    names = ["annual_rate", "annual_rate_low", "annual_rate_high", "share_outside_low"]
    for row in answer("predict", "--study", study, *at)["rows"]:
        expected = own.loc[(row["component"], row["state"]), names].tolist()
        assert [row[name] for name in names] == pytest.approx(expected)
    # a curve that ends at weak intensities gives no rate: its lack is reported or refused
    short = file("im,rate\n0.1,0.01\n0.2,0.005\n", "short.csv")
    shown = invoke("predict", "--study", study, *at[:-1], short, "--at", 0.6)
    assert "lacks intensities above the hazard curve" in shown.stderr
    assert re.search(r"shares of a rate:.* 89%", shown.stderr)
    given_short = ("--axis", "friction=0.5", "--out", tmp_path / "none")
    for command, words in (
        (("decide", short, "--study", study, *given_short), "curve ends at 0.005 per year, above"),
        (("decide", plain, "--study", tmp_path / "pga", *given_short), "no column gap_mm: add it"),
        (("predict", "--study", tmp_path / "pga", *at[:-2]), "gap_mm is not an axis: give skew_"),
    ):
        assert words in answer(*command, code=2)["message"]
    compared = answer("compare", *tables, *given)["rates"]
    pooled = {row["component"]: row for row in compared if row["scope"] == "pooled"}
    assert pooled["unseating"]["ci_low"] > 1.1
    assert pooled["column_drift"]["ratio"] == pytest.approx(1.0, abs=1e-6)
    # the seat that decide finds is exceeded at the target rate
    target = 1.0 - np.exp(-50.0 * 1e-3)
    other = ("--bridge", "osb1", "--probability-50y", target, "--axis", "friction=0.5")
    decide = ("decide", site, "--study", study, *other, "--out", tmp_path / "chart")
    needs = pd.DataFrame(answer(*decide)["rows"]).query("gap_mm == 51")
    changes = {"demands": {"unseating_m": 0.001}, "fragility/curves": {"status": "bounds_too_wide"}}
    for path, change in ((study / f"{name}.parquet", change) for name, change in changes.items()):
        write_frame(read_frame(path).assign(**change), path, {})
    printed = r"(?s)intensity: im_.*curve \(\w+ \d.*extrapolated: 65 of 65 lengths"
    assert re.search(printed, invoke(*decide).stderr)
    assert needs["seat_m"].is_monotonic_increasing
    assert (needs["seat_m_low"] < needs["seat_m"]).all()
    # AASHTO LRFD 4.7.4.4 grows by 0.000125 S^2, the gap is added
    aashto = needs.set_index("skew_deg")["aashto_m"] - 0.051
    assert aashto[45.0] / aashto[0.0] == pytest.approx(1.0 + 0.000125 * 45.0**2)
    middle = needs[needs["skew_deg"] == 30.0].iloc[0]
    (row,) = (row for row in joint_rows(study) if row["component"] == "unseating")
    mode = json.loads(row["modes"])[0] | {"threshold": middle["support_m"], "dispersion": 0.0}
    model = JointModel(row | {"modes": json.dumps([mode])})
    values = {"skew_deg": 30.0, "gap_mm": 51.0, "friction": 0.5}
    assert curve_rate(model.curve(values), curve_of(site)).value == pytest.approx(1e-3, rel=5e-3)
    assert "leave it out" in answer(*decide, "--axis", "skew_deg=30", code=2)["message"]
    # as if columns failed too often at every gap above some skew
    seats = decision(joint_rows(study), curve_of(site), 1e-3, {"friction": 0.5})
    for below_deg, words in ((40.0, "skews of 41.25, 45 deg"), (0.0, "any skew")):
        gaps_mm = seats.table["gap_mm"].where(seats.table["skew_deg"] < below_deg)
        failing = seats._replace(table=seats.table.assign(gap_from_mm=gaps_mm))
        monkeypatch.setattr("skewbridge.fragility.rates.decision", lambda *_, it=failing: it)
        printed = invoke(*decide).stderr
        assert f"above the target at every gap for {words}\n" in printed
        assert f"written: {tmp_path / 'chart' / 'decision.csv'}, " in printed


def test_the_factor_of_hazus_is_on_skew_0_of_the_study(file):
    states = [state for state in STATES if state.component == "unseating"][:1]
    hazus = {}
    for first in (0, 15):
        demands = ready(synthetic_demands(motions=12, skews=(first, 30), gaps=(25,)), states)
        models = fit_models(demands, states, SETTINGS)
        rows = joint_table(models, states, SETTINGS).to_dict("records")
        table = decision(rows, curve_of(file(TABLE)), 1e-3, {"friction": 0.5}).table
        assert table["seat_m"].notna().all()
        hazus[first] = table.set_index("skew_deg")[["hazus_m", "seat_m"]]
    assert hazus[15]["hazus_m"].isna().all()  # nothing is extrapolated to skew 0
    assert hazus[0].loc[0.0, "hazus_m"] == pytest.approx(hazus[0].loc[0.0, "seat_m"])
    assert hazus[0]["hazus_m"].is_monotonic_increasing
    with pytest.raises(InputError, match="probability_50y must"):
        target_rate(2.0)
