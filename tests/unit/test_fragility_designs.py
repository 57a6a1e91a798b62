"""Studies as a whole: system curves, factor summary, crossing curves."""

from pathlib import Path

import numpy as np

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.factors import SUMMARY_COLUMNS, factor_summary
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.fragility.tables.system_curves import system_curves

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")


def state(component, name):
    return next(s for s in STATES if (s.component, s.name) == (component, name))


def test_system_is_weaker_than_its_weakest_component():
    table = synthetic_demands(skews=(0, 30), gaps=(51,), motions=30)
    system = system_curves(table, STATES, IM)
    curves = fit_study(table, STATES, IM)
    assert set(system["limit_state"]) == {"slight", "moderate", "extensive", "complete"}
    slight = system[(system["limit_state"] == "slight") & (system["status"] == "ok")]
    assert len(slight) == 4
    for item in slight.to_dict("records"):
        parts = curves[
            (curves["variant"] == item["variant"])
            & (curves["limit_state"] == "slight")
            & (curves["method"] == "cloud")
        ]
        assert item["theta"] < parts["theta"].min()
        assert item["weakest"] in set(parts["component"])
        assert item["max_dp"] < 0.05
        assert "column_shear" not in item["components"]


def test_system_names_what_it_leaves_out():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    table["bearing_disp_m"] = np.nan
    table.loc[2, "unseating_m"] = 0.0
    table.loc[15, "status"] = "collapse"
    found = system_curves(table, STATES, IM).set_index("limit_state").loc["slight"]
    assert set(found["left_out"].split(";")) == {"bearing", "unseating"}
    assert found["n_not_ok"] == 1
    assert found["n_runs"] == 15


def test_system_that_no_run_damages_has_no_median():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    found = system_curves(table, [state("column_drift", "complete")], IM).iloc[0]
    assert found["status"] == "no_exceedance"
    assert np.isnan(found["theta"])


def test_summary_ranks_factors_and_measures_the_prediction():
    table = synthetic_demands()
    table["unseating_m"] = 0.0
    found = factor_summary(table, ["deck_rotation_rad", "deck_disp_m", "unseating_m"])
    assert list(found.columns) == list(SUMMARY_COLUMNS)
    assert set(found["demand"]) == {"deck_rotation_rad", "deck_disp_m"}
    rotation = found[found["demand"] == "deck_rotation_rad"].set_index("factor")
    assert rotation["first_order"].idxmax() == "skew_deg"
    assert rotation.loc["friction", "p_value"] < 1e-6
    assert rotation["worst_prediction"].iloc[0] < 0.05


def test_curves_that_cross_inside_the_range_are_flagged():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=200, seed=3)
    rng = np.random.default_rng(0)
    im = table[IM].to_numpy()
    # 'moderate' is reached with a wide scatter around 0.45 g, 'slight' sharply at 0.4 g
    slight = im * np.exp(0.2 * rng.normal(size=200)) > 0.4
    moderate = slight & (im * np.exp(0.9 * rng.normal(size=200)) > 0.45)
    table["column_drift_ratio"] = np.where(moderate, 0.03, np.where(slight, 0.015, 0.005))
    states = [state("column_drift", "slight"), state("column_drift", "moderate")]
    curves = fit_study(table, states, IM)
    found = curves[curves["method"] == "exceedance"]
    assert set(found["status"]) == {"ok"}
    assert found["warnings"].str.contains("curves_cross").all()
    cloud = fit_study(synthetic_demands(skews=(0,), gaps=(51,)), STATES, IM)
    lines = cloud[(cloud["method"] == "cloud") & (cloud["model"] == "cloud_ols")]
    assert not lines["warnings"].str.contains("curves_cross").any()
