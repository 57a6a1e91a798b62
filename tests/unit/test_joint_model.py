"""Joint models over the axes: terms, states, left-out variants, and prediction inside the range."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fragility_tables import IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.fits import fit_cloud
from skewbridge.fragility.joint import (
    JOINT_COLUMNS,
    AxisRange,
    JointModel,
    joint_table,
    predict_states,
)
from skewbridge.fragility.limit_states import load_limit_states, with_column_failure
from skewbridge.fragility.settings import FitSettings
from skewbridge.study.predict_check import CHECK_COLUMNS, check_predict, inner_variants

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
DRIFT = [s for s in STATES if s.component == "column_drift"]
SETTINGS = FitSettings(im=IM)
GRID = {"skews": (0, 20, 40, 60), "gaps": (0, 25, 51), "frictions": (0, 50), "motions": 24}
SMALL = {"skews": (0, 30, 60), "gaps": (51,), "frictions": (0, 50), "motions": 16}


def shifted(table, effect):
    """Multiply the drift of every run by the exponential of an effect of its axes."""
    return table.assign(column_drift_ratio=table["column_drift_ratio"] * np.exp(effect(table)))


def clouds(table, states):
    """Return cloud medians of the variants as the table of curves has them."""
    rows = []
    for variant, part in table.groupby("variant"):
        for state in states:
            fit = fit_cloud(part[IM], part[state.demand], state.threshold)
            rows.append(
                {
                    "variant": variant,
                    "component": state.component,
                    "limit_state": state.name,
                    "method": "cloud",
                    "status": fit.status,
                    "theta": fit.theta,
                    "var_ln_theta": fit.var_ln_theta,
                }
            )
    return pd.DataFrame(rows)


def ready(table, states):
    return prepared(table, list({state.demand for state in states}), SETTINGS).table


def joint(table, states=DRIFT, curves=None):
    return joint_table(ready(table, states), states, curves, SETTINGS)


def row_of(table, name="moderate", curves=None):
    found = joint(table, curves=curves).query("limit_state == @name")
    assert len(found) == 1
    return found.iloc[0].to_dict()


def test_medians_between_the_variants_follow_the_generator():
    """The generator is quadratic in skew, linear in the gap, with friction acting at high skew."""

    def effect(t):
        skew, gap = t["skew_deg"] / 60.0, t["gap_mm"] / 50.8
        return 0.3 * skew**2 + 0.1 * gap + 0.4 * skew * t["friction"]

    table = shifted(synthetic_demands(**GRID), effect)
    row = row_of(table, curves=clouds(table, DRIFT))
    model = JointModel.of_row(row)
    point = {"skew_deg": 45.0, "gap_mm": 40.0, "friction": 0.3}
    origin = {"skew_deg": 0.0, "gap_mm": 0.0, "friction": 0.0}
    ratio, low, high = model.ratio(origin, point, 0.9)
    assert ratio == pytest.approx(np.exp(-effect(point) / row["slope"]), rel=0.02)
    assert low < ratio < high
    assert {"skew_deg:skew_deg", "skew_deg:friction"} < set(row["terms"].split(";"))
    assert row["status"] == "ok"
    assert row["loo_variants"] == 24
    assert row["loo_error"] < 0.03
    assert row["loo_error"] <= row["loo_error_max"]


def test_balanced_medians_equal_two_stage_least_squares():
    table = synthetic_demands(**SMALL)
    row = row_of(table)
    model = JointModel.of_row(row)
    ln_d = np.log(table["column_drift_ratio"]).to_numpy().reshape(-1, 16)
    ln_im = np.log(table[IM]).to_numpy().reshape(-1, 16)[0]
    axes = table[["skew_deg", "friction"]].to_numpy().reshape(-1, 16, 2)[:, 0]
    matrix = np.array([model.vector(dict(zip(SMALL_AXES, each, strict=True))) for each in axes])
    mean = ln_d.mean(axis=1)
    effects = np.linalg.lstsq(matrix, mean, rcond=None)[0]
    line = stats.linregress(ln_im, ln_d.mean(axis=0))
    for each, vector in zip(axes, matrix, strict=True):
        level = vector @ effects - line.slope * ln_im.mean()
        expected = np.exp((np.log(0.025) - level) / line.slope)
        theta = model.median(dict(zip(SMALL_AXES, each, strict=True)))[0]
        assert theta == pytest.approx(expected, rel=1e-8)


SMALL_AXES = ("skew_deg", "friction")


def test_states_of_a_component_share_dispersion_and_slope():
    rows = joint(synthetic_demands(**SMALL)).query("status == 'ok'")
    assert len(rows) >= 2
    assert rows["beta"].nunique() == rows["beta_total"].nunique() == rows["slope"].nunique() == 1
    assert rows["theta"].is_monotonic_increasing
    first = rows.iloc[0]
    total = np.hypot(first["beta"], first["capacity_dispersion"] / first["slope"])
    assert first["beta_total"] == pytest.approx(total)
    assert first["beta_total_low"] < first["beta_total"] < first["beta_total_high"]
    assert first["beta_low"] * first["beta_high"] == pytest.approx(first["beta"] ** 2)


def test_negative_skews_count_by_size_unless_the_study_has_both_signs():
    model = JointModel.of_row(row_of(synthetic_demands(**SMALL | {"skews": (0, -30, -60)})))
    assert model.axis_range.limits["skew_deg"] == (0.0, 60.0)
    point = {"friction": 0.5}
    assert model.median(point | {"skew_deg": -45.0}) == model.median(point | {"skew_deg": 45.0})
    both = shifted(
        synthetic_demands(**SMALL | {"skews": (-45, 0, 45)}), lambda t: 0.3 * t["skew_deg"] / 60.0
    )
    row = row_of(both)
    model = JointModel.of_row(row)
    assert model.axis_range.limits["skew_deg"] == (-45.0, 45.0)
    apart = model.ratio(point | {"skew_deg": -45.0}, point | {"skew_deg": 45.0}, 0.95)
    assert apart[0] == pytest.approx(np.exp(-0.45 / row["slope"]), rel=0.03)


def test_collapsed_runs_are_right_censored():
    """Without the collapsed runs, which are the strongest, the median would be too large."""
    whole = synthetic_demands(**SMALL | {"motions": 60, "skews": (0, 30)})
    fallen = whole["column_drift_ratio"] > 0.03
    assert 0.1 < fallen.mean() < 0.3
    cut = whole.assign(
        status=np.where(fallen, "collapse", "ok"),
        column_drift_ratio=np.minimum(whole["column_drift_ratio"], 0.03),
    )
    peak = [s for s in DRIFT if s.name == "moderate"]
    full, censored, dropped = (joint(table, peak).iloc[0] for table in (whole, cut, whole[~fallen]))
    assert censored["n_right_censored"] == fallen.sum()
    assert censored["theta"] == pytest.approx(full["theta"], rel=0.05)
    assert censored["beta"] == pytest.approx(full["beta"], rel=0.1)
    assert dropped["theta"] > 1.1 * full["theta"]


def test_demands_of_zero_are_left_censored():
    table = synthetic_demands(**SMALL)
    weak = table["column_drift_ratio"] < 0.006
    zero = table.assign(column_drift_ratio=table["column_drift_ratio"].where(~weak, 0.0))
    full, censored = row_of(table), row_of(zero)
    assert censored["status"] == "ok"
    assert censored["n_left_censored"] >= weak.sum() > 0
    assert censored["theta"] == pytest.approx(full["theta"], rel=0.05)


def test_runs_without_a_demand_are_ignored():
    whole = synthetic_demands(**SMALL)
    lost = whole.index[[3, 40]]
    crashed = whole.copy()
    crashed.loc[lost, "status"] = "crash"
    crashed.loc[lost, "column_drift_ratio"] = np.nan
    for name in ("theta", "beta", "n_right_censored", "n_runs"):
        assert row_of(crashed)[name] == pytest.approx(row_of(whole.drop(lost))[name], rel=1e-9)


def test_models_are_per_bridge_and_abutment_with_the_axes_they_have():
    friction = synthetic_demands(**SMALL)
    roller = friction[friction["friction"] == 0.0].assign(
        abutment="roller", gap_mm=0, variant=lambda t: t["variant"].str.replace("_cf_", "_ro_")
    )
    other = friction.assign(bridge="osb2", variant=friction["variant"] + "x")
    other["column_drift_ratio"] *= 2.0
    found = joint(pd.concat([friction, roller, other], ignore_index=True))
    assert list(found.columns) == list(JOINT_COLUMNS)
    own = found.query("limit_state == 'slight'").set_index(["bridge", "abutment"])
    first, second = ("osb1", "contact_friction"), ("osb2", "contact_friction")
    assert set(own.index) == {first, second, ("osb1", "roller")}
    assert list(json.loads(own.loc[("osb1", "roller"), "axis_ranges"])) == ["skew_deg"]
    ratio = own.loc[second, "theta"] / own.loc[first, "theta"]
    assert ratio == pytest.approx(0.5 ** (1.0 / own.loc[first, "slope"]), rel=1e-6)


def test_states_without_an_estimate_have_a_status():
    table = synthetic_demands(**SMALL)
    found = joint(table).set_index("limit_state")
    assert found.loc["complete", "status"] == "no_exceedance"
    assert np.isnan(found.loc["complete", "theta"])
    flat = table.assign(column_drift_ratio=3e-4 / table["column_drift_ratio"])
    assert "non_increasing" in set(joint(flat)["status"])
    assert set(joint(table.assign(column_drift_ratio=1.0))["status"]) == {"all_exceed"}
    alone = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    assert {"no_axis_varies", "no_exceedance"} >= set(joint(alone)["status"])
    few = joint(synthetic_demands(**SMALL | {"motions": 4}))
    assert "ok" not in set(few["status"])


def test_large_errors_of_left_out_variants_are_not_ok():
    table = synthetic_demands(**SMALL)
    curves = clouds(table, DRIFT)
    assert row_of(table, curves=curves)["status"] == "ok"
    wrong = curves.assign(theta=curves["theta"] * 1.5)
    row = row_of(table, curves=wrong)
    assert row["status"] == "prediction_error_above_25_percent"
    assert row["loo_error"] == pytest.approx(1.0 / 3.0, abs=0.05)


def test_points_outside_the_range_are_refused_by_name():
    variants = pd.DataFrame({"skew_deg": [0, 60], "gap_mm": [51, 51]})
    axes = AxisRange.of_variants(variants, ["skew_deg", "gap_mm"])
    axes.check({"skew_deg": -60.0, "gap_mm": 51.0, "friction": 0.7})  # friction: not of this model
    axes.check({"skew_deg": 30.0})
    for values, words in (
        ({"skew_deg": 61.0}, r"skew_deg must be within 0\.\.60"),
        ({"skew_deg": 10.0, "gap_mm": 40.0}, r"gap_mm must be within 51\.\.51"),
        ({"gap_mm": 51.0}, "skew_deg is missing"),
        ({"skew_deg": 10.0, "soil": 1.0}, "soil is not an axis"),
    ):
        with pytest.raises(InputError, match=words):
            axes.check(values)


def test_prediction_has_both_probabilities_and_never_crosses(tmp_path):
    table = synthetic_demands(**SMALL)
    capacity = table["column_drift_ratio"] / 0.02
    table = table.assign(drift_over_capacity=capacity)
    two = pd.concat([table, table.assign(bridge="osb2", variant=table["variant"] + "x")])
    states = with_column_failure(DRIFT, [*table.columns, "column_failure_ratio"])
    joint(two, states).to_parquet(tmp_path / "joint.parquet")
    point = {"skew_deg": 22.5, "friction": 0.25}
    rows = {
        (row["component"], row["state"]): row
        for row in predict_states(tmp_path, point, bridge="osb1", at=0.5)
    }
    assert {("column_failure", "flexure"), ("column_failure", "any")} < set(rows)
    slight, moderate = (rows["column_drift", name] for name in ("slight", "moderate"))
    for row in (slight, moderate):
        for p, beta in (("p", "beta_total"), ("p_records", "beta")):
            expected = stats.norm.cdf(np.log(0.5 / row["theta"]) / row[beta])
            assert row[p] == pytest.approx(expected)
        assert row["ci_theta"][0] < row["theta"] < row["ci_theta"][1]
    assert slight["p"] > moderate["p"]
    with pytest.raises(InputError, match="bridge must be one of osb1, osb2; is missing"):
        predict_states(tmp_path, point)
    with pytest.raises(InputError, match="skew_deg must be within"):
        predict_states(tmp_path, {"skew_deg": 70.0}, bridge="osb1")


def test_inner_variants_are_inside_the_grid_and_not_among_its_variants():
    grid = {"skew_deg": [0, 30, 60], "gap_mm": [25, 51], "friction": [0.0, 0.5]}
    points = inner_variants(grid)
    assert [point["friction"] for point in points] == [0.25, 0.125, 0.375]
    assert points[0] == {"skew_deg": 30.0, "gap_mm": 38.0, "friction": 0.25}
    for own in (grid, {"skew_deg": [0, 30, 60], "gap_mm": [51]}, {"friction": [0.0, 0.5, 1.0]}):
        found = inner_variants(own)
        assert len({tuple(point.items()) for point in found}) == 3
        for point in found:
            assert any(value not in own[name] for name, value in point.items())
            assert all(min(own[name]) <= value <= max(own[name]) for name, value in point.items())
    with pytest.raises(InputError, match="has one variant"):
        inner_variants({"skew_deg": [30]})


def test_prediction_inside_the_grid_agrees_with_analyses_under_the_same_motions():
    def effect(t):
        return 0.3 * t["skew_deg"] / 60.0 - 0.2 * t["friction"]

    study = shifted(synthetic_demands(**SMALL | {"motions": 32}), effect)
    whole = synthetic_demands(skews=(15, 45), gaps=(51,), frictions=(25,), motions=32)
    inner = shifted(whole, effect)
    inner = inner[inner["motion_id"].isin([f"m{number:02d}" for number in range(0, 32, 2)])]
    found = check_predict(joint(study), ready(study, DRIFT), ready(inner, DRIFT), DRIFT, SETTINGS)
    assert list(found.columns) == list(CHECK_COLUMNS)
    compared = found[found["status"] == "ok"]
    assert {"slight", "moderate"} <= set(compared["limit_state"])
    assert compared["error"].abs().max() < 0.04
    # the scatter from motion to motion is larger than the errors: it is the same in both medians
    assert compared["se_analysed"].min() > 2.0 * compared["error"].abs().max()
    assert set(found["status"]) == {"ok", "no_exceedance"}
    with pytest.raises(InputError, match="the study has no runs of other"):
        check_predict(
            joint(study),
            ready(study, DRIFT),
            ready(inner.assign(motion_id="other"), DRIFT),
            DRIFT,
            SETTINGS,
        )
