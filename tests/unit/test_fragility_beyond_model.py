"""Runs in which a column failed beyond the model: what fits and effects make of them."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.fit_data import FitOptions, fit_file
from skewbridge.fragility.results import read_foreign
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import factor_summary
from skewbridge.fragility.tables.im_quality import rank_measures
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.fragility.tables.median_effects import paired_capacity_effects
from skewbridge.fragility.tables.system_curves import system_curves
from skewbridge.study.capacity_search import Search

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
ONE = {"skews": (0,), "gaps": (51,), "frictions": (50,)}


def states(component):
    return [state for state in STATES if state.component == component]


def failed(table, rows, kind="shear", factor=0.8):
    """Cut runs off at the failure of a column, with peaks below the final ones."""
    table = table.assign(beyond_model="", beyond_model_s=np.nan)
    table.loc[rows, "beyond_model"] = kind
    table.loc[rows, "beyond_model_s"] = 3.0
    for name in ("column_drift_ratio", "unseating_m", "deck_disp_m", "column_shear_dcr"):
        table.loc[rows, name] *= factor
    return table


def row(curves, component, state, method):
    chosen = curves[
        (curves["component"] == component)
        & (curves["limit_state"] == state)
        & (curves["method"] == method)
    ]
    assert len(chosen) == 1
    return chosen.iloc[0]


def strongest(table, count):
    return table[IM].nlargest(count).index


def test_a_failed_column_exceeds_every_state_of_the_column_whatever_its_peak():
    table = synthetic_demands(**ONE)
    rows = strongest(table, 2)
    for kind in ("shear", "flexure"):
        cut = failed(table, rows, kind, factor=0.1)
        curves = fit_study(cut, states("column_shear") + states("column_drift"), IM)
        for component, state in (("column_shear", "dcr_100"), ("column_drift", "complete")):
            found = row(curves, component, state, "exceedance")
            assert (found["n_exceed"], found["n_unknown"], found["n_beyond_model"]) == (2, 0, 2)
        cloud = row(curves, "column_shear", "dcr_100", "cloud")
        assert cloud["model"] in {"cloud_tobit", "cloud_ols"}
        assert cloud["n_exceed"] == 2


def test_a_failed_column_is_censored_at_the_capacity_in_the_cloud():
    table = synthetic_demands(**ONE, motions=40)
    state = states("column_drift")[:1]
    whole = fit_study(table, state, IM).iloc[0]
    found = fit_study(failed(table, strongest(table, 4), factor=0.05), state, IM).iloc[0]
    assert found["model"] == "cloud_tobit"
    assert found["theta"] == pytest.approx(whole["theta"], rel=0.1)


def test_other_components_exceed_where_their_value_does_and_are_unknown_elsewhere():
    table = synthetic_demands(**ONE, motions=40)
    cut = failed(table, strongest(table, 3))
    cut.loc[strongest(table, 1), "unseating_m"] = 0.001
    cut.loc[strongest(table, 3)[1:], "unseating_m"] = 0.2
    curves = fit_study(cut, states("unseating"), IM)
    slight = row(curves, "unseating", "slight", "exceedance")
    assert (slight["n_unknown"], slight["n_beyond_model"]) == (1, 3)
    assert slight["theta_all_exceed"] <= slight["theta_none_exceed"]
    assert row(curves, "unseating", "extensive", "exceedance")["n_unknown"] == 3
    assert row(curves, "unseating", "slight", "cloud")["model"] == "cloud_tobit"


def test_a_collapsed_run_exceeds_as_before_and_its_keys_are_unknown_after_the_column_failed():
    table = synthetic_demands(**ONE)
    last = strongest(table, 1)
    cut = failed(table, last)
    cut.loc[last, "status"] = "collapse"
    cut.loc[last, "shear_key_disp_m"] = 0.001
    curves = fit_study(cut, states("unseating") + states("shear_key"), IM)
    assert row(curves, "unseating", "complete", "exceedance")["n_exceed"] == 1
    assert row(curves, "unseating", "complete", "exceedance")["n_unknown"] == 0
    assert row(curves, "shear_key", "slight", "exceedance")["n_unknown"] == 1


def test_tables_without_the_column_and_with_nothing_in_it_are_fitted_alike():
    table = synthetic_demands(**ONE)
    empty = table.assign(beyond_model="")
    missing = table.assign(beyond_model=None)
    wanted = fit_study(table, STATES, IM)
    for other in (empty, missing):
        pd.testing.assert_frame_equal(fit_study(other, STATES, IM), wanted)
    assert (wanted["n_beyond_model"] == 0).all()


def test_a_pair_with_a_failed_column_on_either_side_is_a_bound_and_counted():
    table = synthetic_demands(skews=(0,), gaps=(51,))
    half = len(table) // 2
    cut = failed(table, [0, 1, half + 1, half + 2], factor=0.01)
    effects = paired_effects(cut, ["deck_disp_m"])
    found = effects[(effects["axis"] == "friction") & (effects["scope"] == "variant")].iloc[0]
    assert (found["n_beyond_model"], found["n_bounds"], found["n_left_out"]) == (3, 2, 1)
    assert (found["n_motions"], found["dof"], found["n_discordant"]) == (15, 12, 0)
    # peaks of a hundredth bound nothing
    assert found["ratio"] == pytest.approx(1.0, abs=0.02)
    assert found["verdict"] == "negligible"


def test_ratios_of_medians_count_a_failed_column_as_a_demand_beyond_the_state():
    table = synthetic_demands(skews=(0,), gaps=(51,))
    last = len(table) // 2 - 1
    drift = states("column_drift")[:1]

    def friction(demands):
        return paired_capacity_effects(demands, drift, IM).query("axis == 'friction'").iloc[0]

    one, whole = friction(failed(table, [last], factor=0.01)), friction(table)
    assert one["ratio"] == pytest.approx(whole["ratio"], rel=0.02)
    assert (one["n_motions"], one["n_left_out"], one["n_beyond_model"]) == (16, 0, 1)
    assert one["n_discordant"] == 0  # no pair without a bound


def test_medians_of_a_bridge_that_collapses_under_strong_motions_are_not_those_of_its_survivors():
    """Without collapses as demands beyond the last value friction seems to cost 13 % less."""
    table = synthetic_demands(skews=(0,), gaps=(51,), motions=32)
    weaker = table["friction"] == 0.5
    table.loc[weaker, "column_drift_ratio"] *= 1.3
    strong = weaker & (table["column_drift_ratio"] > 0.03)
    table.loc[strong, "status"] = "collapse"
    table.loc[strong, "column_drift_ratio"] = 0.03
    found = paired_capacity_effects(table, states("column_drift")[:1], IM)
    effect = found.query("axis == 'friction'").iloc[0]
    assert effect["n_motions"] == 32
    assert effect["n_collapse_to"] == strong.sum() > 2
    assert effect["ratio"] == pytest.approx(1 / 1.3, rel=0.04)


def test_regressions_of_the_demand_leave_the_failed_runs_out_and_the_system_counts_them():
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    last = table[table[IM] == table[IM].max()].index
    cut = failed(table, last, factor=0.01)
    kept = table.drop(index=last)
    tested = ["demand", "factor", "partial_eta2", "p_value"]
    one, other = (factor_summary(table, ["deck_disp_m"]) for table in (cut, kept))
    pd.testing.assert_frame_equal(one[tested], other[tested])
    # the model over the axes takes them as demands above their last value
    assert one["scatter"].to_numpy() == pytest.approx(other["scatter"].to_numpy(), rel=0.2)
    pd.testing.assert_frame_equal(
        rank_measures(cut, "deck_disp_m"), rank_measures(kept, "deck_disp_m")
    )
    system = system_curves(cut, STATES, IM)
    assert (system["n_beyond_model"] == 1).all()
    assert (system["n_runs"] == 16).all()


def test_foreign_tables_may_say_which_runs_went_beyond_their_model(tmp_path):
    path = tmp_path / "runs.csv"
    table = synthetic_demands(**ONE)
    kinds = ["" if number else "shear" for number in range(len(table))]
    pd.DataFrame(
        {
            "record": table["motion_id"],
            "sa": table[IM],
            "drift": table["column_drift_ratio"] * 100,
            "how": kinds,
        }
    ).to_csv(path, index=False)
    names = {"motion_id": "record", IM: "sa", "column_drift_ratio": "drift", "beyond_model": "how"}
    read = read_foreign(path, names)
    assert read["beyond_model"].tolist() == kinds
    curves = fit_study(read, states("column_drift")[:1], IM)
    assert set(curves["n_beyond_model"]) == {1}


def test_a_file_of_runs_is_fitted_with_the_failed_ones_censored(tmp_path):
    path = tmp_path / "runs.csv"
    table = synthetic_demands(**ONE, motions=40)
    failed(table, strongest(table, 4), factor=0.5).to_csv(path, index=False)
    options = FitOptions(method="cloud", im=IM, edp="column_drift_ratio", threshold=0.01)
    found = fit_file(path, options)
    assert found.details["n_censored"] == 4


def test_a_search_for_a_capacity_goes_on_below_a_run_beyond_the_model():
    search = Search(demand="unseating_m", threshold=0.1, low_g=0.1, high_g=2.0)
    inside = {"status": "ok", "beyond_model": "", "unseating_m": 0.05}
    assert not search.exceeds(inside)
    assert search.exceeds(inside | {"beyond_model": "shear"})
