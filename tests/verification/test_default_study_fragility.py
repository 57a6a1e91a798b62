"""Fragility of the stored demands of the default study: reached states, and pooled medians."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.effects import median_effects
from skewbridge.fragility.joint import joint_table
from skewbridge.fragility.limit_states import load_limit_states, with_column_failure
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.system import system_curves

ROOT = Path(__file__).parents[2]
IM = "im_saavg_rotd50_g"
SETTINGS = FitSettings(im=IM)
#: States that some run of one bridge reached and no run of the other.
NOT_REACHED = {
    "osb1": {"column_shear/dcr_080", "column_shear/dcr_100", "column_failure/shear"},
    "osb1_fixed_era1": {"column_drift/slight", "column_drift/complete", "column_failure/flexure"},
}


@pytest.fixture(scope="module")
def study():
    """Demands, limit states, rows that fits use, curves, pooled medians and joint models."""
    raw = pd.read_parquet(ROOT / "tests" / "data" / "default_study_demands.parquet")
    columns = {*raw.columns, "column_failure_ratio"}
    states = with_column_failure(load_limit_states(ROOT / "config" / "limit_states.yaml"), columns)
    rows = prepared(raw, list(dict.fromkeys(state.demand for state in states)), SETTINGS).table
    curves = fit_study(rows, states, SETTINGS)
    medians = median_effects(rows, states, SETTINGS, curves=curves)
    joint = joint_table(rows, states, SETTINGS)
    found = {"raw": raw, "states": states, "rows": rows, "curves": curves}
    return SimpleNamespace(**found, medians=medians, joint=joint)


def keys(table):
    return table["component"] + "/" + table["limit_state"]


def test_components_have_states_that_runs_reach_and_no_estimates_of_others(study):
    """A component whose every state is out of reach of the model is not offered."""
    largest = study.raw.max(numeric_only=True)
    states = [state for state in study.states if state.demand in study.raw]
    reached = {state.component for state in states if largest[state.demand] > state.threshold}
    assert len(reached) > 7
    assert reached == {state.component for state in states}
    assert "column_residual_drift_ratio" in study.raw
    assert "column_residual_drift_ratio" not in {state.demand for state in study.states}
    raw, states = study.raw, study.states
    systems = system_curves(study.rows, states, SETTINGS)
    for bridge, known in NOT_REACHED.items():
        # every demand of these runs, also those at the moment of a failure
        largest = raw[raw["bridge"] == bridge].max(numeric_only=True)
        beyond = {s.key for s in states if s.demand in raw and largest[s.demand] <= s.threshold}
        assert known <= beyond
        for table in (study.curves, study.joint):
            fitted = table[(table["bridge"] == bridge) & (table["status"] == "ok")]
            assert len(fitted) >= 10
            assert not set(keys(fitted)) & beyond
        medians = study.medians
        effects = medians[(medians["bridge"] == bridge) & (medians["status"] == "ok")]
        assert len(effects) > 20
        assert not set(effects["demand"]) & beyond
        for system in systems[systems["bridge"] == bridge].to_dict("records"):
            for part in filter(None, system["components"].split(";")):
                component, _, state = part.rstrip(")").partition(" (")
                assert f"{component}/{state or system['limit_state']}" not in beyond


def test_a_column_failure_of_one_mode_decides_no_state_of_the_other(study):
    raw, curves = study.raw, study.curves
    for bridge, kind, column, state in (
        ("osb1", "flexure", "column_shear_dcr", "dcr_100"),
        ("osb1_fixed_era1", "shear", "column_drift_ratio", "complete"),
    ):
        part = raw[(raw["bridge"] == bridge) & (raw["beyond_model"] == kind)]
        assert len(part) > 30
        found = curves[(curves["bridge"] == bridge) & (curves["demand"] == column)]
        found = found[found["limit_state"] == state]
        assert (found["n_exceed"] == 0).all()
        assert (found["n_beyond_model"] > 0).any()
        assert (found["status"] == "no_exceedance").all()
        assert found["reach"].str.contains("largest").all()


def test_a_column_is_as_strong_in_any_mode_as_in_the_only_one_reached(study):
    for table, index in ((study.curves, ["variant", "method"]), (study.joint, ["bridge"])):
        fitted = table.query("component == 'column_failure' and status == 'ok'")
        for name in ("theta", "beta_total"):
            wide = fitted.pivot(index=index, columns="limit_state", values=name)
            assert wide.count().min() > 0
            pd.testing.assert_series_equal(
                wide["any"], wide["shear"].fillna(wide["flexure"]), check_names=False, rtol=1e-12
            )
    pooled = study.medians.query("scope == 'pooled' and status == 'ok'")
    means = pooled.pivot(index=["bridge", "axis", "to_value"], columns="demand", values="from_mean")
    for mode in ("shear", "flexure"):
        both = means[["column_failure/any", f"column_failure/{mode}"]].dropna()
        assert len(both) > 0
        assert (both.iloc[:, 0] <= both.iloc[:, 1] * (1.0 + 1e-12)).all()


def test_medians_and_their_ratios_state_the_runs_and_curves_behind_them(study):
    raw, medians = study.raw, study.medians
    curves = study.curves.assign(demand=keys(study.curves))
    estimated = curves[curves["preferred"].astype(bool)].set_index(["variant", "demand"]).index
    axes = ["skew_deg", "gap_mm", "friction"]
    variants = raw.drop_duplicates("variant").set_index(["bridge", *axes])["variant"]
    for row in medians[medians["scope"] == "variant"].to_dict("records"):
        missing = 0
        for value in (row["from_value"], row["to_value"]):
            place = [value if name == row["axis"] else row[name] for name in axes]
            key = variants[(row["bridge"], *place)], row["demand"]
            missing += key not in estimated
        assert row["n_without_curve"] == missing
        assert (row["status"] == "no_curve") == (missing == 2) == np.isnan(row["ratio"])
    pooled = medians[medians["scope"] == "pooled"]
    none = pooled["n_without_curve"] == 2 * pooled["n_cells"]
    assert ((pooled["status"] == "no_curve") == none).all()
    cloud = curves[(curves["method"] == "cloud") & (curves["status"] == "ok")]
    assert (0.99 * cloud["theta_all_exceed"] <= cloud["theta"]).all()
    assert (cloud["theta"] <= 1.01 * cloud["theta_none_exceed"]).all()
    found = curves[curves["status"] == "ok"]
    for row in found.to_dict("records"):
        im = raw.loc[raw["variant"] == row["variant"], IM]
        reached = min((im >= row["theta"]).sum(), (im <= row["theta"]).sum())
        assert row["extrapolated"] == (reached < 3)
    states = keys(found[found["extrapolated"].astype(bool)])
    assert "column_failure/any" in set(states[found["bridge"] == "osb1"])
    assert not set(states) & {"unseating/slight", "column_curvature/moderate"}


# --- medians against code written here
@pytest.mark.parametrize(
    ("bridge", "axis", "key", "column", "threshold"),
    [
        ("osb1", "skew_deg", "column_drift/slight", "column_drift_ratio", 0.01),
        ("osb1", "gap_mm", "column_drift/slight", "column_drift_ratio", 0.01),
        ("osb1_fixed_era1", "friction", "bearing/slight", "bearing_disp_m", 0.05),
    ],
)
def test_pooled_ratios_agree_with_paired_means_and_the_line_of_motion_means(
    study, bridge, axis, key, column, threshold
):
    """Motions that are complete in all variants: balanced data, for which both have closed forms.

    The drift of the effect with intensity, which the closed form neglects, is below 0.03.
    """
    part = study.rows[study.rows["bridge"] == bridge]
    whole = part.groupby("motion_id")["complete"].transform("all")
    part = part[whole].reset_index(drop=True)
    state = [state for state in study.states if state.key == key]
    ours = median_effects(part, state, SETTINGS).query("scope == 'pooled' and axis == @axis")
    ours = ours.sort_values("to_value").iloc[-1]
    ln_demand = part.assign(y=np.log(part[column]), x=np.log(part[IM]))
    ends = [part[axis].min(), part[axis].max()]
    at_ends = [ln_demand[part[axis] == end].groupby("motion_id")["y"].mean() for end in ends]
    shift = (at_ends[1] - at_ends[0]).to_numpy()
    means = ln_demand.groupby("motion_id")[["x", "y"]].mean().to_numpy()

    def ratio(kept):
        return -np.mean(shift[kept]) / np.polyfit(*means[kept].T, 1)[0]

    every = np.arange(shift.size)
    left_out = np.array([ratio(every != motion) for motion in every])
    share = (left_out - left_out.mean()) ** 2
    error = np.sqrt((every.size - 1) / every.size * np.sum(share))
    freedom = min(every.size - 2, 3.0 * np.sum(share) ** 2 / np.sum(share**2))
    reach = stats.t.ppf(0.95, freedom) * error
    assert np.log(ours["ratio"]) == pytest.approx(ratio(every >= 0), abs=0.02)
    assert 0.5 * np.log(ours["ci_high"] / ours["ci_low"]) == pytest.approx(reach, rel=0.15)
    assert ours["n_effective_motions"] == pytest.approx(freedom / 3.0, rel=0.5)
