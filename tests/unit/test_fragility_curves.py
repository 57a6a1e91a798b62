"""Curves of a study: limit states, outcomes of runs, statuses, unknown outcomes and axes."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pyarrow.parquet import read_schema
from scipy import stats

import fragility_tables as made
from fragility_tables import FAILURES, IM, SETTINGS, STATES, curves_of, states_of, synthetic_demands
from skewbridge.demands.columns import DEMAND_COLUMNS, demands_for
from skewbridge.errors import InputError
from skewbridge.fragility import limit_states, study_tables
from skewbridge.fragility.curves import CURVE_COLUMNS, fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.effects import median_effects
from skewbridge.fragility.exports import export_curves
from skewbridge.fragility.joint import joint_table
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.system import system_curves
from skewbridge.fragility.union import Union, curve_probability

ONE = {"skews": (0,), "gaps": (51,), "frictions": (50,)}
NEW = "transverse_gap_mm"
ENTRY = {
    "component": "deck", "demand": "deck_disp_m", "unit": "mm", "dispersion": 0.35,
    "citation": "somebody", "states": {"slight": 102.0},
}  # fmt: skip


def row(curves, component, name, method="cloud"):
    found = curves.query("component == @component and limit_state == @name and method == @method")
    assert len(found) == 1
    return found.iloc[0]


def strongest(table, count):
    return table[IM].nlargest(count).index


def test_every_variant_state_and_method_has_one_row_in_any_order_of_the_runs():
    table = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,))
    curves = curves_of(table, STATES)
    assert list(curves.columns) == [name for name in CURVE_COLUMNS if name in curves]
    assert len(curves) == 2 * len(STATES) * 2
    assert not curves.duplicated(["variant", "component", "limit_state", "method"]).any()
    known = curves[["theta", "beta", "theta_low", "beta_total"]].notna()
    assert known.eq(curves["status"] == "ok", axis=0).all(axis=None)
    slope = curves.groupby(["variant", "component", "limit_state"])["b"].transform("max")
    total = np.hypot(curves["beta"], curves["capacity_dispersion"] / slope)  # of both methods
    fitted = curves[curves["status"] == "ok"]
    assert fitted["beta_total"].to_numpy() == pytest.approx(total[fitted.index].to_numpy())
    mixed = curves_of(table.sample(frac=1.0, random_state=4), STATES)
    pd.testing.assert_frame_equal(curves, mixed, rtol=1e-7)


def test_saturating_and_missing_demands_are_flagged_and_not_applicable():
    table = synthetic_demands(**ONE, motions=40).assign(bearing_disp_m=np.nan)
    im = table[IM].to_numpy()
    noise = np.exp(0.02 * np.random.default_rng(2).normal(size=im.size))
    table["column_shear_dcr"] = 0.9 * im / (im + 0.15) * noise
    found = row(curves_of(table, states_of("column_shear")), "column_shear", "dcr_065")
    assert "saturating" in found["warnings"].split(";")
    assert found["b_above"] < 0.7 * found["b"]
    assert 0.1 < found["knot"] < 1.0
    # D = 0.9 x / (x + 0.15) is 0.65 at x = 0.39; a straight line gives 0.32
    assert found["theta"] == pytest.approx(0.39, rel=0.1)
    assert set(curves_of(table, states_of("bearing"))["status"]) == {"not_applicable"}


def test_states_of_one_demand_never_cross_though_their_scatter_differs():
    table, rng = synthetic_demands(**ONE, motions=200, seed=3), np.random.default_rng(0)
    im = table[IM].to_numpy()
    # 'moderate' is reached with a wide scatter about 0.45 g, 'slight' with a small one about 0.4 g
    slight = im * np.exp(0.2 * rng.normal(size=200)) > 0.4
    moderate = slight & (im * np.exp(0.9 * rng.normal(size=200)) > 0.45)
    table["column_drift_ratio"] = np.where(moderate, 0.03, np.where(slight, 0.015, 0.005))
    curves = curves_of(table, states_of("column_drift")[:2])
    for method in ("cloud", "exceedance"):
        found = curves[curves["method"] == method]
        assert set(found["status"]) == {"ok"}
        assert found["beta"].nunique() == found["beta_total"].nunique() == 1
        assert found["theta"].is_monotonic_increasing


def test_methods_that_disagree_are_flagged_and_all_variants_have_one_method():
    table = synthetic_demands(**ONE, motions=120)
    assert not curves_of(table, states_of("column_drift")[:1])["methods_differ"].any()
    # a plateau below the state and a jump above it: no line, but a clear transition
    im = table[IM].to_numpy()
    noise = np.exp(0.1 * np.random.default_rng(1).normal(size=im.size))
    other = table.assign(variant="other", skew_deg=30)
    other["column_drift_ratio"] = np.where(im * noise > 0.8, 0.012, 0.006)
    found = curves_of(pd.concat([table, other]), states_of("column_drift")[:1])
    assert found.groupby("variant")["methods_differ"].first()["other"]
    other = found.query("variant == 'other' and method == 'exceedance'").iloc[0]
    assert other["theta"] == pytest.approx(0.8, rel=0.06)
    assert set(found.loc[found["preferred"], "method"]) == {"cloud"}
    assert found["preferred"].sum() == 2


def test_the_loss_of_the_column_has_states_for_each_mode_and_for_any():
    table = synthetic_demands(**ONE, motions=40)
    table["drift_over_capacity"] = table["column_drift_ratio"] / 0.05
    by_drift = table["drift_over_capacity"] >= 1.0
    by_shear = table.index.isin(strongest(table, 8)) & ~by_drift
    table["beyond_model"] = np.select([by_drift, by_shear], ["flexure", "shear"], "")
    tables = study_tables.fragility_tables(table, STATES, SETTINGS)
    found = tables["curves"].query("component == 'column_failure' and method == 'cloud'")
    counts = found.set_index("limit_state")["n_exceed"].to_dict()
    modes = {"shear": by_shear, "flexure": by_drift, "any": by_drift | by_shear}
    assert counts == {name: runs.sum() for name, runs in modes.items()}
    assert set(tables["joint"].query("component == 'column_failure'")["limit_state"]) <= {*counts}


@pytest.mark.parametrize("rho", [-0.9, 0.0, 0.3, 0.99])
def test_the_union_of_two_modes_is_their_bivariate_normal_distribution(rho):
    ln_theta, beta = np.log([[0.8, 2.0], [1.1, 0.6]]), np.array([[0.4, 0.5], [0.3, 1.1]])
    union = Union(ln_theta, beta, np.full(2, rho))
    survive = stats.multivariate_normal(cov=[[1.0, rho], [rho, 1.0]]).cdf
    for ln_im in np.log([0.05, 0.5, 0.8, 1.1, 2.0, 3.0]):
        expected = [1.0 - survive(-u) for u in ((ln_im - ln_theta) / beta).T]
        assert union.probability(ln_im) == pytest.approx(expected, abs=1e-6)
    for z in (-2.0, 0.0, 1.0):
        p = union.probability(union.quantile(z))
        assert p == pytest.approx(np.full(2, stats.norm.cdf(z)), abs=1e-12)


def test_any_failure_is_the_union_of_both_modes_with_their_own_capacities():
    """Uncorrelated modes with known lines and capacity dispersions 0.15 and 0.35."""
    rng, table = np.random.default_rng(4), synthetic_demands(**ONE, motions=60)
    x, scatter = np.log(table[IM].to_numpy()), 0.25 * rng.normal(size=(2, 60))
    table["column_shear_dcr"] = np.exp(0.6 * (x - np.log(0.9)) + scatter[0])
    table["drift_over_capacity"] = np.exp(1.1 * (x - np.log(1.1)) + scatter[1])
    table["column_failure_ratio"] = table[["column_shear_dcr", "drift_over_capacity"]].max(axis=1)
    curves = curves_of(table, FAILURES)
    shear, flexure, found = (row(curves, "column_failure", s.name) for s in FAILURES)
    for mode, b, capacity in ((shear, 0.6, 0.15), (flexure, 1.1, 0.35)):
        assert mode["beta_total"] == pytest.approx(np.hypot(0.25, capacity) / b, rel=0.15)
    assert (found["model"], abs(found["mode_correlation"]) < 0.2) == ("union", True)
    # theta and beta_total of the row are median and spread of this curve
    ends = found["theta"] * np.exp(found["beta_total"] * np.array([-1.0, 0.0, 1.0]))
    low, middle, high = curve_probability(ends, found)
    assert middle == pytest.approx(0.5, abs=1e-9)
    assert (low, high) == pytest.approx(stats.norm.cdf([-1.0, 1.0]), abs=0.02)
    assert found["theta"] < min(shear["theta"], flexure["theta"])
    assert found["theta_low"] < found["theta"] < found["theta_high"]
    # the jackknife leaves each motion out of both modes
    without = [curves_of(table[table["motion_id"] != m], FAILURES) for m in table["motion_id"]]
    ln_theta = np.log([row(each, "column_failure", "any")["theta"] for each in without])
    squares = (ln_theta - ln_theta.mean()) ** 2
    error = np.sqrt(found["var_ln_theta"])
    # by one Newton step instead of independent fits
    assert error == pytest.approx(np.sqrt(59.0 * np.mean(squares)), rel=0.05)
    t = stats.t.ppf(0.975, min(58.0, 3.0 * np.sum(squares) ** 2 / np.sum(squares**2)))
    assert np.log(found["theta_high"] / found["theta"]) == pytest.approx(t * error, rel=0.02)
    # the system contains both modes
    states = [replace(state, degree="complete") for state in FAILURES[2:]]
    system = system_curves(made.models_of(table, FAILURES), states, SETTINGS).iloc[0]
    assert system["components"] == "column_failure (any)"
    assert system["theta"] == pytest.approx(found["theta"], rel=2e-3)
    assert system["beta"] == pytest.approx(found["beta_total"], rel=5e-3)


def test_covariances_have_the_errors_of_the_intervals():
    """Errors from priors count once in both, not with the factor of the jackknife."""
    table, slight = synthetic_demands(motions=8), states_of("column_drift")[0]
    (models,), curves = fit_models(table, [slight], SETTINGS), curves_of(table, [slight])
    for values in models.variants.to_dict("records"):
        curve = models.curve(slight, values)
        found = row(curves[curves["variant"] == values["variant"]], slight.component, slight.name)
        logs = np.column_stack([curve.ln_theta, np.log(curve.beta)])
        last = len(logs) - curve.priors
        assert (len(logs[1:last]), curve.priors > 0) == (8, True)
        without_motions = (logs[1:last] - logs[0]) * np.sqrt(7.0 / 8.0)
        changes = np.vstack([without_motions, logs[last:] - logs[0]]) * [1.0, found["beta"]]
        names = ("var_ln_theta", "cov_ln_theta_beta", "var_beta")
        expected = (changes.T @ changes)[np.triu_indices(2)]
        assert [found[name] for name in names] == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_one_method_is_preferred_for_both_modes():
    curves = curves_of(pd.concat([made.two_mode_runs(seed, 24) for seed in range(30)]), FAILURES)
    keys = ["variant", "limit_state"]
    both = curves[curves["status"] == "ok"].groupby(keys).filter(lambda rows: len(rows) > 1)
    preferred = both[both["preferred"]].groupby("variant")["method"].nunique()
    assert len(preferred)
    assert (preferred == 1).all()
    # effects, rates and `predict` use the demand model: fits to outcomes do not replace it
    is_open = "method == 'cloud' and status == 'bounds_too_wide'"
    withheld = curves.query(is_open)[keys].merge(curves.query("method == 'exceedance'"))
    assert (withheld["status"] == "ok").any()
    assert not withheld["preferred"].any()


def test_a_collapse_exceeds_every_state_and_a_column_failure_gives_the_peak_so_far():
    table = synthetic_demands(**ONE)
    last = strongest(table, 1)
    table.loc[last, "status"] = "collapse"
    table.loc[last, "shear_key_disp_m"] = 0.001
    chosen = [s for name in ("column_drift", "column_shear", "shear_key") for s in states_of(name)]
    curves = curves_of(table, chosen)
    drift = row(curves, "column_drift", "complete", "exceedance")
    assert (drift["n_exceed"], drift["n_unknown"]) == (1, 0)
    assert row(curves, "column_shear", "dcr_100")["status"] == "no_exceedance"
    assert row(curves, "shear_key", "slight", "exceedance")["n_unknown"] == 1
    table = synthetic_demands(**ONE, motions=40)
    ended = strongest(table, 3)
    cut = table.assign(beyond_model=np.where(table.index.isin(ended), "shear", ""))
    cut.loc[ended, "unseating_m"] = 0.001, 0.2, 0.2
    curves = curves_of(cut, states_of("unseating"))
    slight = row(curves, "unseating", "slight", "exceedance")
    assert (slight["n_unknown"], slight["n_beyond_model"]) == (1, 3)
    assert row(curves, "unseating", "extensive", "exceedance")["n_unknown"] == 3
    assert row(curves, "unseating", "slight")["model"] == "mixed_tobit"


def test_only_bridges_with_inner_joints_have_curves_of_their_unseating():
    plain, jointed = (synthetic_demands(bridge=name, **ONE) for name in ("osb1", "bridge_a"))
    both = pd.concat([plain, jointed.assign(joint_unseating_m=jointed["unseating_m"])])
    states = [*states_of("unseating"), *states_of("joint_unseating")]
    tables = study_tables.fragility_tables(both.reset_index(drop=True), states, SETTINGS)
    curves = tables["curves"].set_index(["bridge", "component"]).sort_index()
    assert set(curves.loc[("osb1", "joint_unseating"), "status"]) == {"not_applicable"}
    own, fitted = (curves.loc[("bridge_a", s.component), "theta"] for s in (states[0], states[-1]))
    assert fitted.tolist() == pytest.approx(own.tolist(), rel=1e-6, nan_ok=True)
    without = study_tables.fragility_tables(plain, states, SETTINGS)
    assert set(without["curves"]["component"]) == {"unseating", "column_failure"}
    assert tables["input_notes"].empty
    assert without["input_notes"].empty


def test_a_demand_at_the_threshold_does_not_exceed_it_and_few_unknown_runs_are_allowed():
    given = {"component": "c", "name": "s", "demand": "d_m", "threshold": 0.1, "dispersion": 0.0}
    state = limit_states.LimitState(**given)
    peaks = [0.1, np.nextafter(0.1, 1.0), np.nan, 0.2]
    status = ["ok", "ok", "timeout", "numerical_failure"]
    found = demand_outcomes(pd.DataFrame({"d_m": peaks, "status": status}), [state])
    assert found.exceed(state).tolist() == [False, True, False, True]
    assert found.unknown(state).tolist() == [False, False, True, False]
    for runs in (20, 19):
        table = synthetic_demands(motions=runs, skews=(0,), gaps=(25,), frictions=(0,))
        table.loc[0, ["status", "deck_disp_m"]] = ["timeout", 0.0]
        for warnings in curves_of(table, states_of("deck_displacement")[:1])["warnings"]:
            assert "unknown_outcomes" in warnings
            assert ("unknown_above_5_percent" in warnings) is (runs == 19)


def test_a_missing_demand_rejects_only_its_run_and_equal_motions_are_reported():
    def notes(table):
        return prepared(table, ["column_drift_ratio"], SETTINGS).notes["kind"].value_counts()

    table = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,))
    table.loc[5, "column_drift_ratio"] = np.nan
    table.loc[table["skew_deg"] == 30, "column_drift_ratio"] = np.nan
    assert notes(table)["missing_demand"] == 17
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    twice = pd.concat([table, table.assign(motion_id=table["motion_id"] + "_b")])
    assert notes(twice)["equal_motions"] == 16
    assert notes(table).empty
    # with effects on demands of runs that are not under the same shaking
    scaled = table.assign(**{IM: table[IM].mask(table["skew_deg"] == 30, 1.5 * table[IM])})
    assert notes(scaled)["percent"] == 1
    for value in (-0.1, np.inf):
        table.loc[5, "column_drift_ratio"] = value
        with pytest.raises(InputError, match="drift_ratio must be >= 0 and finite") as caught:
            notes(table)
        assert caught.value.details["row"] == 5


def test_a_column_of_a_new_axis_is_an_axis_of_every_table(tmp_path):
    """Two variants of skew, two of a new axis; demands are a tenth smaller at its second value."""
    narrow = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,), motions=20)
    wide = narrow.assign(variant=narrow["variant"] + "_tg025")
    demands = list(demands_for("effect", wide.columns))
    noise = np.exp(0.01 * np.random.default_rng(3).normal(size=len(wide)))
    wide[demands] = wide[demands].mul(0.9 * noise, axis=0)
    table = pd.concat([narrow.assign(**{NEW: 6.0}), wide.assign(**{NEW: 25.0})], ignore_index=True)
    states = states_of("column_drift")
    models = made.models_of(table, states)
    assert joint_table(models, states[:2], SETTINGS)["terms"].str.contains(NEW).all()
    assert set(median_effects(models, states[:2], SETTINGS)["axis"]) == {"skew_deg", NEW}
    assert set(system_curves(models, states, SETTINGS)[NEW]) == {6.0, 25.0}
    found = made.paired_effects(table).query("axis == @NEW and scope == 'pooled'")
    assert set(found["demand"]) == set(demands)
    assert found["ratio"].to_numpy() == pytest.approx(0.9, abs=0.02)
    source, out = tmp_path / "curves.parquet", tmp_path / "curves.csv"
    fit_study(models, states[:2], SETTINGS).to_parquet(source)
    export_curves(source, "csv", out)
    assert set(pd.read_csv(out)[NEW]) == {6.0, 25.0}


def test_every_column_of_every_table_has_a_description_and_every_demand_its_unit(tmp_path):
    table = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,), motions=12)
    for name, frame in study_tables.fragility_tables(table, STATES, SETTINGS).items():
        path = tmp_path / f"{name}.parquet"
        study_tables.write_described(frame, path, study_tables.DESCRIPTIONS[name])
        for field in read_schema(path):
            assert (field.metadata or {}).get(b"description"), f"{name}.{field.name}"
    names = {"-": "ratio", "m/s2": "mps2"}
    for column in (each for each in DEMAND_COLUMNS if "effect" in each.roles):
        assert limit_states.demand_unit(column.name) == names.get(column.unit, column.unit.lower())
    assert limit_states.demand_unit("strain_percent") == "percent"


SHEAR = "column_shear_dcr_"
STRONGEST = "kowalsky_priestley"
DEFAULT_STUDY = Path(__file__).parents[1] / "data" / "default_study_demands.parquet"


def shear_curves(table):
    """Return curves, and medians, statuses, methods by variant (row) and shear model (column)."""
    rows = prepared(table, [], SETTINGS).table
    states = limit_states.with_column_failure([], rows.columns)
    of_study = fit_study(fit_models(rows, states, SETTINGS), states, SETTINGS)
    curves = study_tables.shear_model_curves(rows, of_study, SETTINGS)
    names = ("theta", "status", "method")
    return curves, *(curves.pivot(index="variant", columns="limit_state", values=n) for n in names)


def whole_motion_ratios(seed, plateau, scatter):
    """Return the shear-critical bridge of the default study with ratios over the whole motion. The
    stored demands end at the failure. After it, the shear is near a plateau: the columns have
    yielded in flexure."""
    table = pd.read_parquet(DEFAULT_STUDY)
    table = table[table["bridge"] == "osb1_fixed_era1"].reset_index(drop=True)
    is_failed, motions = table["beyond_model"] == "shear", table["motion_id"].unique()
    scattered = dict(zip(motions, np.random.default_rng(seed).normal(size=32), strict=True))
    peaks = plateau * np.exp(scatter * table["motion_id"].map(scattered))
    ratio = table["column_shear_dcr"].where(~is_failed, np.maximum(peaks, 1.001))
    factors = {"ucsd_tests": 1.0, "sdc_expected": 1.13, "sdc_nominal": 1.28, STRONGEST: 0.72}
    ratios = {f"{SHEAR}{name}": factor * ratio for name, factor in factors.items()}
    return table.assign(status="ok", complete=table["beyond_model"] == "", **ratios)


@pytest.mark.parametrize(
    ("seed", "plateau", "scatter"), [(1, 1.6, 0.2), (3, 1.6, 0.2), (0, 1.3, 0.05)]
)
def test_medians_under_shear_models_have_the_order_of_the_capacities(seed, plateau, scatter):
    table = whole_motion_ratios(seed, plateau, scatter)
    curves, theta, status, method = shear_curves(table)
    for weak, strong in pairwise(("sdc_nominal", "sdc_expected", "ucsd_tests", STRONGEST)):
        estimated = (status[[weak, strong]] == "ok").all(axis=1)
        # equal if the same runs exceed and both medians are from the exceedance fit
        assert (theta[weak] <= (1.0 + 1e-9) * theta[strong])[estimated].all()
    assert (theta.notna() == (status == "ok")).all(axis=None)
    assert status["sdc_nominal"].eq("ok").sum() >= 7
    assert method.nunique(axis=1).eq(1).all()
    # a failure in the model of the study bounds the ratio of no other model
    assert curves["n_unknown"].eq(0).all()
    assert curves["n_censored"].equals(curves["n_exceed"])
    exceed = curves.groupby("limit_state")["n_exceed"].sum().to_dict()
    assert exceed == {name: (table[f"{SHEAR}{name}"] > 1.0).sum() for name in exceed}


def test_early_stops_bound_the_ratios_of_all_shear_models_and_the_study_has_its_medians():
    table = whole_motion_ratios(0, 1.3, 0.05)
    stopped = table.index[table["beyond_model"] == ""][:5]
    table.loc[stopped, ["status", "complete"]] = ["timeout", False]
    curves = shear_curves(table)[0]
    assert (curves["n_censored"] - curves["n_exceed"]).sum() == 4 * 5
    tables = study_tables.fragility_tables(whole_motion_ratios(0, 2.0, 0.3), [], SETTINGS)
    study = tables["curves"].query("limit_state == 'shear' and method == 'cloud'")
    own = tables["shear_models"].query("limit_state == 'ucsd_tests'")
    names = ["variant", "theta", "theta_low", "theta_high", "beta_total", "n_exceed", "status"]
    assert own["preferred"].sum() >= 7
    pd.testing.assert_frame_equal(*(t[names].reset_index(drop=True) for t in (own, study)))


def test_medians_against_the_order_of_the_capacities_or_without_ratios_are_not_estimated():
    table = synthetic_demands(skews=(0,), gaps=(25,), frictions=(50,), motions=9)
    strong, is_last = 0.6 * table[IM], table[IM] == table[IM].max()
    strong *= np.where(np.arange(len(table)) % 2, 1.02, 0.98)  # the fit needs some scatter
    # much weaker for small motions only: its line is flatter and crosses 1 at a larger intensity
    weak = strong * np.maximum(1.001, (0.35 / table[IM]) ** 0.8)
    table[f"{SHEAR}sdc_expected"] = strong.mask(is_last, 1.01)
    table[f"{SHEAR}sdc_nominal"] = weak.mask(is_last, 1.02)
    table[f"{SHEAR}{STRONGEST}"] = 0.1
    curves, _, status, _ = shear_curves(table)
    expected = {STRONGEST: "no_exceedance", "sdc_expected": study_tables.NOT_ORDERED,
                "sdc_nominal": study_tables.NOT_ORDERED}  # fmt: skip
    assert status.iloc[0].to_dict() == expected
    gone = ["theta", "beta", "beta_total", "beta_low", "theta_low", "theta_high"]
    assert curves[[*gone, "var_ln_theta", "var_beta"]].isna().all(axis=None)
    assert not curves[["preferred", "extrapolated"]].any(axis=None)
    # without the ratios of all models there are no curves
    table = synthetic_demands(skews=(0,), gaps=(25,)).assign(beyond_model="shear")
    table = table.assign(**{f"{SHEAR}sdc_expected": 0.5, f"{SHEAR}sdc_nominal": 0.6})
    curves = shear_curves(table)[0]
    assert curves.empty
    assert list(curves) == list(study_tables.DESCRIPTIONS["shear_models"])


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"unit": "kn"}, "is a unit of force, but deck_disp_m has one of length, got"),
        ({"unit": "furlong"}, "unit: must be one of m, mm, in, ft, kn"),
        ({"states": {"slight": -1.0}}, "states.slight.median: must be greater than 0, got -1"),
        ({"states": {"slight": "2e7"}}, "Write a number with an exponent like 2.0e+7"),
        ({"dispersion": 3.0}, "dispersion: must be less than or equal to 2, got 3"),
        ({"dispersion": None}, "states.slight.dispersion: is missing"),
        ({"colapse": "peak"}, "colapse: unknown key"),
        ({"collapse": "maybe"}, "collapse: must be 'exceeds' or 'peak', got 'maybe'"),
        ({"demand": "deck"}, "does not end with a unit; known units: m, mm, in, ft, kn, kip"),
    ],
)
def test_wrong_limit_state_names_entry_and_key(change, text):
    with pytest.raises(InputError, match=r"^limit state entry 1") as caught:
        limit_states.limit_states_of([ENTRY | change])
    assert text in str(caught.value)


def test_a_demand_brings_its_unit_by_its_row_of_columns_or_the_end_of_its_name():
    for demand, unit, threshold in (
        *((column.name, column.unit.replace("-", "ratio"), 102.0) for column in DEMAND_COLUMNS),
        ("moment_knm", "kNm", 102.0), ("deck_speed_mps", "m/s", 102.0),
        ("column_shear_kn", "kip", 102.0 * 4.4482216152605), ("my_dcr", "%", 1.02),
    ):  # fmt: skip
        (state,) = limit_states.limit_states_of([ENTRY | {"demand": demand, "unit": unit}])
        assert state.threshold == pytest.approx(threshold)


def test_doubled_or_no_states_are_refused_and_tiny_dispersions_flagged_as_likely_unit_slips():
    with pytest.raises(InputError, match="deck/slight is defined twice"):
        limit_states.limit_states_of([ENTRY, ENTRY])
    with pytest.raises(InputError, match="no limit states to fit"):
        curves_of(synthetic_demands(**ONE), [])
    (state,) = limit_states.limit_states_of([ENTRY | {"dispersion": 0.0025}])
    assert state.warnings == ("small_capacity_dispersion",)


@pytest.fixture(scope="module")
def many_variants() -> pd.DataFrame:
    table = synthetic_demands(motions=10, gaps=(10, 25, 51), frictions=(0, 25, 50))
    first = table["variant"] == table["variant"].iloc[0]
    status = table["status"].mask(first & (table["unseating_m"] > 0.15), "collapse")
    return table.assign(status=status, collapse_criterion="")


def _effects(models, _, own, jobs):
    return made.paired_effects(models[0].runs, ["unseating_m", "deck_disp_m"], own, jobs=jobs)


@pytest.mark.parametrize("fit", [fit_study, system_curves, joint_table, _effects])
def test_two_processes_give_the_table_of_one(fit, many_variants) -> None:
    states = [*states_of("unseating"), *states_of("abutment_passive")]
    rows = made.ready(many_variants, states)
    models = {n: fit_models(rows, states, SETTINGS, jobs=n) for n in (1, 2)}
    alone, parallel = (fit(models[n], states, SETTINGS, jobs=n) for n in (1, 2))
    assert len(alone) > 3
    pd.testing.assert_frame_equal(parallel, alone, check_exact=True)
