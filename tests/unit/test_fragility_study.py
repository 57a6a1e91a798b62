"""Fits of whole studies: statuses, failed runs, repeated motions, limit states."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curve_rows import CURVE_COLUMNS
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.limit_states import (
    load_limit_states,
)
from skewbridge.fragility.tables.outcomes import outcomes_of

CONFIG = Path(__file__).parents[2] / "config" / "limit_states.yaml"
STATES = load_limit_states(CONFIG)
ONE = {"skews": (0,), "gaps": (51,), "frictions": (50,)}


def states(component):
    return [state for state in STATES if state.component == component]


def row(curves, component, name, method):
    found = curves[
        (curves["component"] == component)
        & (curves["limit_state"] == name)
        & (curves["method"] == method)
    ]
    assert len(found) == 1
    return found.iloc[0]


def test_every_variant_state_and_method_has_one_row_with_the_contract_columns():
    table = synthetic_demands()
    curves = fit_study(table, STATES, IM)
    assert list(curves.columns) == list(CURVE_COLUMNS)
    assert len(curves) == 12 * len(STATES) * 2
    key = ["variant", "component", "limit_state", "method"]
    assert not curves.duplicated(key).any()
    estimated = curves["status"] == "ok"
    assert curves.loc[estimated, ["theta", "beta", "theta_low"]].notna().all(axis=None)
    assert curves.loc[~estimated, ["theta", "beta", "theta_low"]].isna().all(axis=None)


def test_capacity_protected_column_is_no_exceedance_and_never_a_median():
    table = synthetic_demands(**ONE)
    table["column_shear_dcr"] = np.minimum(table["column_shear_dcr"], 0.9)
    curves = fit_study(table, states("column_shear"), IM)
    for method in ("cloud", "exceedance"):
        found = row(curves, "column_shear", "dcr_100", method)
        assert found["status"] == "no_exceedance"
        assert np.isnan(found["theta"])
        assert found["n_exceed"] == 0
    assert row(curves, "column_shear", "dcr_100", "exceedance")["theta_bound_low"] > 0


def test_collapse_by_drift_is_no_shear_failure_but_exceeds_every_drift():
    table = synthetic_demands(**ONE)
    table.loc[table[IM].idxmax(), "status"] = "collapse"
    curves = fit_study(table, states("column_shear") + states("column_drift"), IM)
    assert row(curves, "column_shear", "dcr_100", "exceedance")["status"] == "no_exceedance"
    drift = row(curves, "column_drift", "complete", "exceedance")
    assert drift["n_exceed"] == 1
    assert drift["n_collapse"] == 1
    assert drift["n_unknown"] == 0


def test_saturating_demand_is_flagged_by_the_curvature_test():
    table = synthetic_demands(**ONE)
    im = table[IM].to_numpy()
    scatter = np.random.default_rng(2).normal(size=im.size) * 0.02
    table["column_shear_dcr"] = 0.9 * im / (im + 0.15) * np.exp(scatter)
    found = row(fit_study(table, states("column_shear"), IM), "column_shear", "dcr_065", "cloud")
    assert "saturating" in found["warnings"].split(";")
    assert found["curvature_p"] < 0.05


def test_truth_of_the_generator_lies_in_the_intervals():
    table = synthetic_demands(**ONE, motions=200, seed=8)
    found = row(fit_study(table, states("column_drift"), IM), "column_drift", "moderate", "cloud")
    assert found["theta_low"] < 0.025 / 0.035 < found["theta_high"]
    assert found["beta_low"] < np.hypot(0.35, 0.03) < found["beta_high"]
    assert found["beta_total"] == pytest.approx(np.hypot(found["beta"], 0.35 / found["b"]))


def test_unknown_outcomes_are_counted_and_bounded_and_can_refuse_the_headline():
    table = synthetic_demands(**ONE, motions=40)
    middle = table.index[18:24:2]
    table.loc[middle, "status"] = ["timeout", "numerical_failure", "crash"]
    table.loc[middle, "column_drift_ratio"] = 0.004
    found = row(
        fit_study(table, states("column_drift"), IM), "column_drift", "slight", "exceedance"
    )
    assert found["n_unknown"] == 3
    assert "unknown_above_5_percent" in found["warnings"]
    assert found["status"] == "bounds_too_wide"
    assert np.isnan(found["theta"])
    assert found["theta_all_exceed"] < found["theta_none_exceed"]
    accepted = fit_study(table, states("column_drift"), IM, FitSettings(accept_bounds=True))
    again = row(accepted, "column_drift", "slight", "exceedance")
    assert again["status"] == "ok"
    assert again["theta"] == again["theta_exclude"]


def test_a_failed_run_that_exceeded_already_is_known():
    table = synthetic_demands(**ONE)
    last = table[IM].idxmax()
    table.loc[last, "status"] = "numerical_failure"
    state = states("column_drift")[0]
    inside = np.zeros(len(table), dtype=bool)
    status = table["status"].to_numpy(dtype=str)
    judged = outcomes_of(table[state.demand].to_numpy(), status, inside, state)
    assert judged.exceed[last]
    assert not judged.unknown.any()


def test_peak_of_a_failed_run_enters_the_cloud_as_a_lower_bound():
    table = synthetic_demands(**ONE, motions=40)
    state = states("column_drift")[:1]
    whole = fit_study(table, state, IM).iloc[0]
    cut = table.copy()
    strong = cut[IM].nlargest(4).index
    cut.loc[strong, "status"] = "timeout"
    cut.loc[strong, "column_drift_ratio"] *= 0.8
    found = fit_study(cut, state, IM).iloc[0]
    assert found["model"] == "cloud_tobit"
    assert found["ci_method"] == "profile"
    assert found["theta"] == pytest.approx(whole["theta"], rel=0.1)


def test_repeated_motions_switch_the_interval_to_motions():
    table = synthetic_demands(**ONE, scales=(0.5, 1.0, 2.0), motions=20)
    curves = fit_study(table, states("column_drift"), IM)
    exceedance = row(curves, "column_drift", "moderate", "exceedance")
    assert exceedance["ci_method"] == "record_bootstrap"
    assert (exceedance["n_runs"], exceedance["n_records"]) == (60, 20)
    assert row(curves, "column_drift", "moderate", "cloud")["ci_method"] == "record_bootstrap"
    brackets = row(curves, "column_drift", "moderate", "ida_interval")
    assert brackets["ci_method"] == "profile"
    assert brackets["theta_high"] > exceedance["theta"]


def test_failed_runs_of_repeated_motions_keep_the_interval_by_motion():
    table = synthetic_demands(**ONE, scales=(0.5, 1.0, 2.0), motions=20)
    table.loc[[5, 30], "status"] = "timeout"
    found = row(fit_study(table, states("column_drift"), IM), "column_drift", "slight", "cloud")
    assert found["model"] == "cloud_tobit"
    assert found["ci_method"] == "record_bootstrap"
    assert found["theta_low"] < found["theta"] < found["theta_high"]


def test_fits_repeat_exactly_and_do_not_depend_on_the_order_of_rows():
    table = synthetic_demands(skews=(0, 30), gaps=(51,), scales=(0.7, 1.4))
    mixed = table.sample(frac=1.0, random_state=4).sort_values(["variant", "motion_id", "scale"])
    first = fit_study(table, states("column_drift"), IM)
    second = fit_study(
        mixed.sort_values(["variant", "motion_id", "scale"]), states("column_drift"), IM
    )
    pd.testing.assert_frame_equal(first, second)


def test_zero_demands_have_no_logarithm_and_say_so():
    table = synthetic_demands(**ONE)
    table.loc[3, "unseating_m"] = 0.0
    curves = fit_study(table, states("unseating"), IM)
    assert row(curves, "unseating", "moderate", "cloud")["status"] == "non_positive_demand"
    assert row(curves, "unseating", "moderate", "exceedance")["n_runs"] == 16


def test_a_demand_that_the_model_lacks_is_not_applicable():
    table = synthetic_demands(**ONE).assign(bearing_disp_m=np.nan)
    curves = fit_study(table, states("bearing"), IM)
    assert set(curves["status"]) == {"not_applicable"}


@pytest.mark.parametrize(
    ("column", "value", "text"),
    [
        (IM, np.nan, "im_saavg_rotd50_g must be > 0 and finite, got nan in row 5"),
        (IM, 0.0, "must be > 0 and finite"),
        ("column_drift_ratio", -0.1, "column_drift_ratio must be >= 0 and finite"),
        ("column_drift_ratio", np.nan, "column_drift_ratio is missing"),
        ("status", "fine", "status must be one of"),
    ],
)
def test_bad_values_name_row_and_column(column, value, text):
    table = synthetic_demands(**ONE)
    table.loc[5, column] = value
    with pytest.raises(InputError) as caught:
        fit_study(table, states("column_drift"), IM)
    assert text in str(caught.value)
    assert caught.value.details["row"] == 5


def test_a_missing_column_is_named():
    table = synthetic_demands(**ONE).drop(columns="deck_disp_m")
    with pytest.raises(InputError, match="no column 'deck_disp_m'"):
        fit_study(table, states("deck_displacement"), IM)


def test_the_three_treatments_are_there_though_no_known_run_exceeds():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=20)
    table["column_drift_ratio"] *= 0.008 / table["column_drift_ratio"].max()
    table.loc[table.index[-4:], "status"] = "crash"
    found = row(fit_study(table, STATES, IM), "column_drift", "slight", "cloud")
    assert found["status"] == "no_exceedance"
    assert found["n_unknown"] == 4
    assert np.isnan(found["theta_exclude"])
    assert np.isnan(found["theta_none_exceed"])
    assert table[IM].min() < found["theta_all_exceed"] < 3 * table[IM].max()
    assert "unknown_outcomes" in found["warnings"]


def test_states_beyond_a_plateau_are_told_by_what_limits_the_demand():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=24)
    rng = np.random.default_rng(0)
    free = 0.9 * table[IM] ** 0.7
    for name, most in (("column_shear_dcr", 0.55), ("column_shear_kn", 3200.0)):
        hinge = np.minimum(free / 0.55, 1.0) * most
        table[name] = hinge * np.exp(0.03 * rng.normal(size=len(table)))
    curves = fit_study(table, STATES, IM)
    beyond = row(curves, "column_shear", "dcr_080", "cloud")
    assert (beyond["status"], beyond["mechanism"]) == ("no_exceedance", "plastic_hinge")
    assert "limited by the plastic hinge: it saturates at 0.55" in beyond["reach"]
    assert beyond["plateau"] == pytest.approx(0.55, rel=0.05)
    assert "saturating" in row(curves, "column_shear", "dcr_050", "cloud")["warnings"]
    assert row(curves, "column_shear", "dcr_050", "cloud")["reach"] == ""
    weak = row(curves, "column_drift", "complete", "cloud")
    assert weak["mechanism"] == "weak_motions"


@pytest.mark.parametrize(("motions", "is_tested"), [(3, False), (4, True)])
def test_four_completed_runs_are_enough_to_test_the_line(motions, is_tested):
    table = synthetic_demands(**ONE, motions=motions)
    middle = replace(states("column_drift")[0], threshold=table["column_drift_ratio"].median())
    found = row(fit_study(table, [middle], IM), "column_drift", middle.name, "cloud")
    assert np.isfinite(found["normal_p"]) is np.bool_(is_tested)
