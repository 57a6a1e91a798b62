"""Studies as a whole: system curves, crossing curves."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fragility_tables import IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.tables.curve_rows import CURVE_COLUMNS
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.im_quality import measure_table, rank_measures
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.fragility.tables.ordered_curves import ordered_curves
from skewbridge.fragility.tables.system_curves import system_curves, system_members

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
        assert "column_shear (dcr_100)" in item["components"].split(";")


def test_system_names_what_it_leaves_out():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    table["bearing_disp_m"] = np.nan
    table.loc[2, "unseating_m"] = 0.0
    table.loc[15, "status"] = "collapse"
    found = system_curves(table, STATES, IM).set_index("limit_state").loc["slight"]
    reasons = set(found["left_out"].split(";"))
    assert reasons == {"bearing: demand missing", "unseating: zero demand"}
    assert (found["n_collapse"], found["n_runs"]) == (1, 16)


def test_a_component_that_does_not_grow_with_intensity_leaves_the_system_to_the_others():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=24)
    table["bearing_disp_m"] = 0.05 / table[IM]
    found = system_curves(table, STATES, IM).set_index("limit_state").loc["slight"]
    assert found["status"] == "ok"
    assert "bearing: demand does not grow" in found["left_out"]


def test_system_medians_count_collapses_and_lie_between_their_bounds():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=32)
    whole = system_curves(table, STATES, IM).set_index("limit_state").loc["moderate"]
    strong = table["column_drift_ratio"] > 0.03
    fallen = table.assign(status=np.where(strong, "collapse", "ok"))
    demands = [name for name in table if name.startswith(("column_", "deck_", "unseating"))]
    for name in demands:  # the peak so far
        fallen.loc[strong, name] *= 0.3
    found = system_curves(fallen, STATES, IM).set_index("limit_state").loc["moderate"]
    assert found["n_collapse"] == strong.sum() > 3
    assert found["theta"] == pytest.approx(whole["theta"], rel=0.08)
    assert found["theta_low"] < found["theta"] < found["theta_high"]
    assert found["beta_low"] < found["beta"] < found["beta_high"]
    assert found["theta_independent"] <= found["theta"] <= found["theta_correlated"]


def test_a_component_takes_part_with_its_next_more_severe_state():
    members = system_members([state for state in STATES if state.system_degree])
    taken = {name: {s.component: s.name for s in own} for name, own in members.items()}
    assert list(taken) == ["slight", "moderate", "extensive", "complete"]
    assert taken["extensive"]["shear_key"] == "complete"
    assert all(own["column_shear"] == "dcr_100" for own in taken.values())
    assert "bearing" not in taken["complete"]
    backwards = [state("column_drift", "slight"), state("column_drift", "moderate")]
    turned = [
        replace(s, component="other", name=n)
        for s, n in zip(backwards, ("moderate", "slight"), strict=True)
    ]
    with pytest.raises(InputError, match="different orders"):
        system_members([*backwards, *turned])


def test_system_that_no_run_damages_has_no_median():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    found = system_curves(table, [state("column_drift", "complete")], IM).iloc[0]
    assert found["status"] == "no_exceedance"
    assert np.isnan(found["theta"])


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


def test_states_with_one_dispersion_do_not_cross_and_are_compared_with_their_own():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=60)
    drift = [s for s in STATES if s.component == "column_drift"][:2]
    found = ordered_curves(table, drift, IM)
    assert list(found["method"].unique()) == ["ordered"]
    assert list(found["status"]) == ["ok", "ok"]
    assert found["beta"].nunique() == 1
    assert found["theta"].is_monotonic_increasing
    assert 0.01 < found["common_beta_p"].iloc[0] <= 1.0
    assert set(found.columns) <= set(CURVE_COLUMNS)
    # Wald's intervals are even about ln theta and ln beta, 1.96 standard errors wide on each side
    for name, variance in (
        ("theta", found["var_ln_theta"]),
        ("beta", found["var_beta"] / found["beta"] ** 2),
    ):
        low, high = (np.log(found[f"{name}_{end}"] / found[name]) for end in ("low", "high"))
        np.testing.assert_allclose(high, 1.959964 * np.sqrt(variance), rtol=1e-6)
        np.testing.assert_allclose(low, -high)
    alone = ordered_curves(table, [drift[0], state("column_drift", "complete")], IM)
    assert list(alone["status"]) == ["single_state", "empty_state"]


def test_measures_are_ranked_per_bridge_and_abutment_and_judged_by_motion():
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    rng = np.random.default_rng(4)
    names = sorted(table["motion_id"].unique())
    motions = pd.DataFrame(
        {
            "motion_id": names,
            "magnitude": rng.uniform(6, 8, len(names)),
            "distance_km": rng.uniform(5, 40, len(names)),
        }
    )
    noise = dict(zip(names, np.exp(rng.normal(size=len(names))), strict=True))
    table["im_pga_rotd50_g"] = table[IM] * table["motion_id"].map(noise)
    found = measure_table(table, motions)
    assert found.groupby("demand")["im"].first().eq(IM).all()
    assert {"p_magnitude", "effect_ln_distance", "p_best_proficiency"} <= set(found.columns)
    doubled = measure_table(pd.concat([table, table]), motions)
    assert doubled["p_magnitude"].to_numpy() == pytest.approx(found["p_magnitude"].to_numpy())


def test_measures_that_one_motion_leaves_without_a_line_are_listed_with_the_reason():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(0, 50), motions=1)
    found = measure_table(table, table[["motion_id"]])
    assert set(found["status"]) == {"single_level"}
    assert found["proficiency"].isna().all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sufficiency_is_the_p_value_of_the_line_of_the_residual_on_the_magnitude(sign):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=12)
    demand = np.log(table["deck_disp_m"])
    line = stats.linregress(np.log(table[IM]), demand)
    residual = demand - line.intercept - line.slope * np.log(table[IM])
    rng = np.random.default_rng(5)
    magnitude = 7.0 + sign * (residual - residual.mean()) + 0.3 * rng.normal(size=12)
    motions = table[["motion_id"]].assign(magnitude=magnitude, distance_km=10.0)
    found = rank_measures(
        table.assign(im_flat_g=0.3, im_none_g=0.0), "deck_disp_m", motions=motions
    ).set_index("im")
    expected = stats.linregress(magnitude, residual)
    assert found.loc[IM, "p_magnitude"] == pytest.approx(expected.pvalue)
    assert found.loc["im_flat_g", "status"] == "single_level"
    assert found.loc["im_none_g", "status"] == "non_positive_im"
