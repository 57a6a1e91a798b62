"""Curves of a study: outcomes of runs, statuses, states of one demand, unknown outcomes, axes."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from pyarrow.parquet import read_schema

from fragility_tables import (
    IM,
    SETTINGS,
    STATES,
    curves_of,
    paired_effects,
    ready,
    states_of,
    synthetic_demands,
)
from skewbridge.demands.columns import DEMAND_COLUMNS, demands_for
from skewbridge.errors import InputError
from skewbridge.fragility.curves import CURVE_COLUMNS, fit_study
from skewbridge.fragility.demand_table import prepared, read_foreign
from skewbridge.fragility.exports import export_curves
from skewbridge.fragility.fit_data import FitOptions, fit_file
from skewbridge.fragility.joint import joint_table
from skewbridge.fragility.limit_states import LimitState, demand_unit
from skewbridge.fragility.measures import rank_measures
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.outcomes import demand_outcomes
from skewbridge.fragility.study_tables import (
    DESCRIPTIONS,
    fragility_tables,
    shear_model_medians,
    write_described,
)
from skewbridge.fragility.system import system_curves
from skewbridge.study.ida import Search
from skewbridge.variant import axes

ONE = {"skews": (0,), "gaps": (51,), "frictions": (50,)}
NEW = "transverse_gap_mm"


def row(curves, component, name, method="cloud"):
    """Return the one row of a state and method."""
    found = curves[
        (curves["component"] == component)
        & (curves["limit_state"] == name)
        & (curves["method"] == method)
    ]
    assert len(found) == 1
    return found.iloc[0]


def failed(table, rows, kind="shear", factor=0.8):
    """End runs at the failure of a column, with peaks below the final ones."""
    table = table.assign(beyond_model="")
    table.loc[rows, "beyond_model"] = kind
    for name in ("column_drift_ratio", "unseating_m", "deck_disp_m", "column_shear_dcr"):
        table.loc[rows, name] *= factor
    return table


def strongest(table, count):
    return table[IM].nlargest(count).index


# --- rows and statuses


def test_every_variant_state_and_method_has_one_row():
    curves = curves_of(synthetic_demands(skews=(0, 30)), STATES)
    assert list(curves.columns) == [name for name in CURVE_COLUMNS if name in curves]
    assert len(curves) == 8 * len(STATES) * 2
    assert not curves.duplicated(["variant", "component", "limit_state", "method"]).any()
    estimated = curves["status"] == "ok"
    for name in ("theta", "beta", "theta_low", "beta_total"):
        assert (curves[name].notna() == estimated).all(), name


def test_a_state_that_no_run_reached_has_no_median_and_names_the_largest_demand():
    table = synthetic_demands(**ONE)
    table["column_shear_dcr"] = np.minimum(table["column_shear_dcr"], 0.9)
    curves = curves_of(table, states_of("column_shear"))
    for method in ("cloud", "exceedance"):
        found = row(curves, "column_shear", "dcr_100", method)
        assert (found["status"], found["n_exceed"]) == ("no_exceedance", 0)
        assert np.isnan(found["theta"])
        assert "state at 1" in found["reach"]
    assert row(curves, "column_shear", "dcr_100", "exceedance")["theta_bound_low"] > 0


def test_the_generator_lies_within_the_intervals():
    table = synthetic_demands(**ONE, motions=200, seed=8)
    found = row(curves_of(table, states_of("column_drift")), "column_drift", "moderate")
    assert found["theta_low"] < 0.025 / 0.035 < found["theta_high"]
    assert found["beta_low"] < np.hypot(0.35, 0.03) < found["beta_high"]
    assert found["beta_total"] == pytest.approx(np.hypot(found["beta"], 0.35 / found["b"]))
    assert found["beta_total_low"] < found["beta_total"] < found["beta_total_high"]


def test_a_saturating_demand_is_flagged():
    table = synthetic_demands(**ONE)
    im = table[IM].to_numpy()
    noise = np.exp(0.02 * np.random.default_rng(2).normal(size=im.size))
    table["column_shear_dcr"] = 0.9 * im / (im + 0.15) * noise
    found = row(curves_of(table, states_of("column_shear")), "column_shear", "dcr_065")
    assert "saturating" in found["warnings"].split(";")
    assert found["curvature_p"] < 0.05


def test_a_demand_that_the_model_lacks_is_not_applicable():
    table = synthetic_demands(**ONE).assign(bearing_disp_m=np.nan)
    assert set(curves_of(table, states_of("bearing"))["status"]) == {"not_applicable"}


@pytest.mark.parametrize(("motions", "is_tested"), [(3, False), (4, True)])
def test_four_completed_runs_are_enough_to_test_the_line(motions, is_tested):
    table = synthetic_demands(**ONE, motions=motions)
    middle = replace(states_of("column_drift")[0], threshold=table["column_drift_ratio"].median())
    found = row(curves_of(table, [middle]), "column_drift", middle.name)
    assert bool(np.isfinite(found["normal_p"])) is is_tested


def test_fits_do_not_depend_on_the_order_of_rows():
    table = synthetic_demands(skews=(0, 30), gaps=(51,), scales=(0.7, 1.4))
    first = curves_of(table, states_of("column_drift"))
    second = curves_of(table.sample(frac=1.0, random_state=4), states_of("column_drift"))
    pd.testing.assert_frame_equal(first, second, rtol=1e-7)


# --- states of one demand


def test_states_of_one_demand_never_cross_though_their_scatter_differs():
    table = synthetic_demands(**ONE, motions=200, seed=3)
    rng = np.random.default_rng(0)
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


def test_methods_that_disagree_are_flagged_and_one_of_them_is_preferred():
    table = synthetic_demands(**ONE, motions=120)
    agreed = curves_of(table, states_of("column_drift")[:1])
    assert not agreed["methods_differ"].any()
    assert agreed.loc[agreed["preferred"], "method"].tolist() == ["cloud"]
    # a plateau below the state and a jump above it: no line, but a clear transition
    im = table[IM].to_numpy()
    noise = np.exp(0.1 * np.random.default_rng(1).normal(size=im.size))
    table["column_drift_ratio"] = np.where(im * noise > 0.8, 0.012, 0.0095)
    found = curves_of(table, states_of("column_drift")[:1])
    assert found["methods_differ"].all()
    assert found.loc[found["preferred"], "method"].tolist() == ["exceedance"]
    assert abs(np.log(found["methods_ratio"].iloc[0])) > np.log(1.15)
    preferred = found[found["preferred"]].iloc[0]
    assert preferred["theta"] == pytest.approx(0.8, rel=0.06)


# --- runs that ended early


def test_a_column_failure_decides_only_the_states_of_its_own_mode():
    table = synthetic_demands(**ONE, motions=40)
    # flexure ended two runs at a shear ratio of 0.3, below every state of column_shear
    cut = failed(table, strongest(table, 2), "flexure")
    cut.loc[strongest(table, 2), "column_shear_dcr"] = 0.3
    curves = curves_of(cut, states_of("column_shear"))
    for method in ("cloud", "exceedance"):
        found = row(curves, "column_shear", "dcr_100", method)
        assert (found["status"], found["n_exceed"], found["n_unknown"]) == ("no_exceedance", 0, 2)
    own = failed(table, strongest(table, 2), "shear", factor=0.1)
    found = row(curves_of(own, states_of("column_shear")), "column_shear", "dcr_100")
    assert (found["n_exceed"], found["n_beyond_model"]) == (2, 2)
    drift = row(curves_of(own, states_of("column_drift")), "column_drift", "complete")
    assert (drift["status"], drift["n_exceed"]) == ("no_exceedance", 0)


def test_the_loss_of_the_column_has_states_for_each_mode_and_for_any():
    table = synthetic_demands(**ONE, motions=40)
    table["drift_over_capacity"] = table["column_drift_ratio"] / 0.05
    table = table.assign(beyond_model="")
    by_drift = table["drift_over_capacity"] >= 1.0
    by_shear = table.index.isin(strongest(table, 8)) & ~by_drift
    table.loc[by_drift, "beyond_model"] = "flexure"
    table.loc[by_shear, "beyond_model"] = "shear"
    tables = fragility_tables(table, STATES, SETTINGS)
    found = tables["curves"].query("component == 'column_failure' and method == 'cloud'")
    counts = found.set_index("limit_state")["n_exceed"].to_dict()
    assert counts == {
        "shear": by_shear.sum(),
        "flexure": by_drift.sum(),
        "any": (by_drift | by_shear).sum(),
    }
    assert set(tables["joint"].query("component == 'column_failure'")["limit_state"]) <= {*counts}


def test_other_components_know_a_failed_run_only_by_its_peak():
    table = synthetic_demands(**ONE, motions=40)
    cut = failed(table, strongest(table, 3))
    cut.loc[strongest(table, 1), "unseating_m"] = 0.001
    cut.loc[strongest(table, 3)[1:], "unseating_m"] = 0.2
    curves = curves_of(cut, states_of("unseating"))
    slight = row(curves, "unseating", "slight", "exceedance")
    assert (slight["n_unknown"], slight["n_beyond_model"]) == (1, 3)
    assert row(curves, "unseating", "extensive", "exceedance")["n_unknown"] == 3
    assert row(curves, "unseating", "slight")["model"] == "cloud_tobit"


def test_a_collapse_exceeds_every_state_unless_the_peak_decides():
    table = synthetic_demands(**ONE)
    last = strongest(table, 1)
    table.loc[last, "status"] = "collapse"
    table.loc[last, "shear_key_disp_m"] = 0.001
    chosen = [s for name in ("column_drift", "column_shear", "shear_key") for s in states_of(name)]
    curves = curves_of(table, chosen)
    drift = row(curves, "column_drift", "complete", "exceedance")
    assert (drift["n_exceed"], drift["n_collapse"], drift["n_unknown"]) == (1, 1, 0)
    assert row(curves, "column_shear", "dcr_100")["status"] == "no_exceedance"
    assert row(curves, "shear_key", "slight", "exceedance")["n_unknown"] == 1


def test_a_peak_so_far_enters_the_cloud_as_a_lower_bound():
    table = synthetic_demands(**ONE, motions=40)
    state = states_of("column_drift")[:1]
    whole = curves_of(table, state).iloc[0]
    for factor in (0.8, 0.05):
        found = curves_of(failed(table, strongest(table, 4), factor=factor), state).iloc[0]
        assert (found["model"], found["ci_method"]) == ("cloud_tobit", "profile")
        assert found["n_censored"] == 4
    assert found["theta_exclude"] == pytest.approx(whole["theta"], rel=0.1)


def test_a_demand_at_the_threshold_does_not_exceed_it_and_one_above_is_known():
    state = LimitState(
        component="c", name="s", demand="d_m", threshold=0.1, dispersion=0.0, citation="test"
    )
    peaks = [0.1, np.nextafter(0.1, 1.0), np.nan, 0.2]
    status = ["ok", "ok", "timeout", "numerical_failure"]
    found = demand_outcomes(pd.DataFrame({"d_m": peaks, "status": status}), [state])
    assert found.exceed(state).tolist() == [False, True, False, True]
    assert found.unknown(state).tolist() == [False, False, True, False]


def test_a_demand_of_zero_is_left_censored():
    table = synthetic_demands(**ONE, motions=60)
    table["unseating_m"] *= 0.4
    whole = row(curves_of(table, states_of("unseating")), "unseating", "slight")
    table.loc[table["unseating_m"] < 0.01, "unseating_m"] = 0.0
    found = row(curves_of(table, states_of("unseating")), "unseating", "slight")
    assert (found["status"], found["model"]) == ("ok", "cloud_tobit")
    assert found["n_censored"] >= (table["unseating_m"] == 0.0).sum() > 5
    assert found["theta"] == pytest.approx(whole["theta"], rel=0.05)


def test_unknown_outcomes_are_bounded_and_can_refuse_the_median():
    table = synthetic_demands(**ONE, motions=40)
    middle = table.index[18:24:2]
    table.loc[middle, "status"] = ["timeout", "numerical_failure", "crash"]
    table.loc[middle, "column_drift_ratio"] = 0.004
    drift = states_of("column_drift")
    found = row(curves_of(table, drift), "column_drift", "slight", "exceedance")
    assert (found["n_unknown"], found["status"]) == (3, "bounds_too_wide")
    assert "unknown_above_5_percent" in found["warnings"]
    assert np.isnan(found["theta"])
    assert found["theta_all_exceed"] < found["theta_none_exceed"]
    accepted = fit_study(ready(table, drift), drift, replace(SETTINGS, accept_bounds=True))
    again = row(accepted, "column_drift", "slight", "exceedance")
    assert again["status"] == "ok"
    assert again["theta"] == pytest.approx(again["theta_exclude"])


@pytest.mark.parametrize(("runs", "is_many"), [(20, False), (19, True)])
def test_one_unknown_run_in_twenty_is_not_yet_many(runs, is_many):
    table = synthetic_demands(motions=runs, skews=(0,), gaps=(25,), frictions=(0,))
    table.loc[0, "status"] = "timeout"
    table.loc[0, "deck_disp_m"] = 0.0
    for warnings in curves_of(table, states_of("deck_displacement")[:1])["warnings"]:
        assert "unknown_outcomes" in warnings
        assert ("unknown_above_5_percent" in warnings) is is_many


def test_repeated_motions_have_the_intervals_of_motions():
    table = synthetic_demands(**ONE, scales=(0.5, 1.0, 2.0), motions=20)
    table.loc[[5, 30], "status"] = "timeout"
    curves = curves_of(table, states_of("column_drift"))
    for method in ("cloud", "exceedance"):
        found = row(curves, "column_drift", "slight", method)
        assert found["ci_method"] == "jackknife"
        assert (found["n_runs"], found["n_records"]) == (60, 20)
        assert found["theta_low"] < found["theta"] < found["theta_high"]
    brackets = row(curves, "column_drift", "slight", "ida_interval")
    assert brackets["theta"] == pytest.approx(found["theta"], rel=0.15)


# --- input


@pytest.mark.parametrize(
    ("column", "value", "text"),
    [
        ("column_drift_ratio", -0.1, "column_drift_ratio must be >= 0 and finite"),
        ("column_drift_ratio", np.inf, "column_drift_ratio must be >= 0 and finite"),
        ("status", "fine", "status must be one of"),
    ],
)
def test_impossible_values_name_row_and_column(column, value, text):
    table = synthetic_demands(**ONE)
    table.loc[5, column] = value
    with pytest.raises(InputError) as caught:
        prepared(table, ["column_drift_ratio"], SETTINGS)
    assert text in str(caught.value)
    assert caught.value.details["row"] == 5


@pytest.mark.parametrize("value", [np.nan, 0.0])
def test_a_row_without_intensity_is_rejected_alone_and_listed(value):
    table = synthetic_demands(**ONE)
    table.loc[5, IM] = value
    found = prepared(table, ["column_drift_ratio"], SETTINGS)
    assert len(found.table) == len(table) - 1
    assert found.notes[["kind", "row", "column"]].values.tolist() == [["rejected_row", 5, IM]]


def test_a_missing_demand_rejects_only_its_run_and_a_variant_full_of_them_is_listed():
    table = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,))
    table.loc[5, "column_drift_ratio"] = np.nan
    curves = curves_of(table, states_of("column_drift"))
    assert curves["n_missing"].max() == 1
    assert "ok" in set(curves["status"])
    table.loc[table["skew_deg"] == 30, "column_drift_ratio"] = np.nan
    found = prepared(table, ["column_drift_ratio"], SETTINGS)
    assert (found.notes["kind"] == "missing_demand").sum() == 17


def test_motions_entered_twice_are_reported():
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    twice = pd.concat([table, table.assign(motion_id=table["motion_id"] + "_b")])
    notes = prepared(twice, ["column_drift_ratio"], SETTINGS).notes
    assert (notes["kind"] == "equal_motions").sum() == 16
    assert prepared(table, ["column_drift_ratio"], SETTINGS).notes.empty


def test_a_missing_column_is_named():
    table = synthetic_demands(**ONE).drop(columns="deck_disp_m")
    with pytest.raises(InputError, match="no column 'deck_disp_m'"):
        prepared(table, ["deck_disp_m"], SETTINGS)


@pytest.mark.parametrize("beyond", ["", None])
def test_tables_with_and_without_the_column_of_failures_are_fitted_alike(beyond):
    table = synthetic_demands(**ONE)
    states = states_of("unseating")
    pd.testing.assert_frame_equal(
        curves_of(table.assign(beyond_model=beyond), states), curves_of(table, states)
    )


def test_foreign_tables_can_name_the_runs_in_which_a_column_failed(tmp_path):
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
    assert set(curves_of(read, states_of("column_drift")[:1])["n_beyond_model"]) == {1}


def test_a_file_of_runs_is_fitted_with_the_failed_ones_censored(tmp_path):
    path = tmp_path / "runs.csv"
    table = synthetic_demands(**ONE, motions=40)
    failed(table, strongest(table, 4), factor=0.9).to_csv(path, index=False)
    options = FitOptions(method="cloud", im=IM, edp="column_drift_ratio", threshold=0.01)
    assert fit_file(path, options).details["n_censored"] == 4


def test_a_capacity_search_continues_below_a_run_in_which_a_column_failed():
    search = Search(demand="unseating_m", threshold=0.1, low_g=0.1, high_g=2.0)
    inside = {"status": "ok", "beyond_model": "", "unseating_m": 0.05}
    assert not search.exceeds(inside)
    assert search.exceeds(inside | {"beyond_model": "shear"})


# --- systems and measures with failed runs


def test_measures_leave_failed_runs_out_and_systems_count_them():
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    last = table[table[IM] == table[IM].max()].index
    cut, kept = failed(table, last, factor=0.01), table.drop(index=last)
    pd.testing.assert_frame_equal(
        rank_measures(cut, "deck_disp_m"), rank_measures(kept, "deck_disp_m")
    )
    system = system_curves(ready(cut, STATES), STATES, SETTINGS)
    assert (system["n_beyond_model"] == 1).all()
    assert (system["n_runs"] == 16).all()


# --- a further axis


@pytest.fixture
def with_new_axis(monkeypatch):
    """Two variants of skew, two of a new axis; demands are a tenth smaller at its second value."""
    if not axes.axes_of([NEW]):
        gap = next(axis for axis in axes.AXES if axis.name == "gap_mm")
        new = replace(gap, name=NEW, code="tg", title="the transverse gap")
        monkeypatch.setattr(axes, "AXES", (*axes.AXES, new))
    narrow = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,), motions=20)
    wide = narrow.assign(variant=narrow["variant"] + "_tg025")
    noise = np.exp(0.01 * np.random.default_rng(3).normal(size=len(wide)))
    for column in demands_for("effect", wide.columns):
        wide[column] *= 0.9 * noise
    return pd.concat([narrow.assign(**{NEW: 6.0}), wide.assign(**{NEW: 25.0})], ignore_index=True)


def test_a_column_of_a_new_axis_is_an_axis_of_every_table(with_new_axis, tmp_path):
    states = states_of("column_drift")[:2]
    rows = ready(with_new_axis, states)
    curves = fit_study(rows, states, SETTINGS)
    joint = joint_table(rows, states, curves, SETTINGS)
    assert joint["terms"].str.contains(NEW).all()
    assert set(median_effects(rows, states, SETTINGS)["axis"]) == {"skew_deg", NEW}
    system_states = [state for state in STATES if state.component == "column_drift"]
    assert set(system_curves(rows, system_states, SETTINGS)[NEW]) == {6.0, 25.0}
    effects = paired_effects(with_new_axis, settings=SETTINGS)
    found = effects[(effects["axis"] == NEW) & (effects["scope"] == "pooled")]
    assert set(found["demand"]) == set(demands_for("effect", with_new_axis.columns))
    assert found["ratio"].to_numpy() == pytest.approx(0.9, abs=0.02)
    source, out = tmp_path / "curves.parquet", tmp_path / "curves.csv"
    curves.to_parquet(source)
    export_curves(source, "csv", out)
    assert set(pd.read_csv(out)[NEW]) == {6.0, 25.0}


# --- descriptions and units


def test_every_column_of_every_table_has_a_description(tmp_path):
    table = synthetic_demands(skews=(0, 30), gaps=(51,), motions=12)
    suite = table[["motion_id"]].drop_duplicates().assign(magnitude=7.0, distance_km=8.0)
    tables = fragility_tables(table, STATES, SETTINGS, suite)
    for name, frame in tables.items():
        path = tmp_path / f"{name}.parquet"
        write_described(frame, path, DESCRIPTIONS[name])
        for field in read_schema(path):
            assert (field.metadata or {}).get(b"description"), f"{name}.{field.name}"


def test_the_unit_of_every_demand_is_that_of_its_column():
    names = {"-": "ratio", "m/s2": "mps2"}
    limited = [c for c in DEMAND_COLUMNS if "effect" in c.roles]
    assert [demand_unit(c.name) for c in limited] == [
        names.get(c.unit, c.unit.lower()) for c in limited
    ]
    assert demand_unit("strain_percent") == "percent"


def test_a_shear_model_with_a_smaller_capacity_fails_at_a_smaller_intensity() -> None:
    table = synthetic_demands(skews=(0,), gaps=(25,), frictions=(0.5,))
    ratio = table["column_shear_dcr"] / table["column_shear_dcr"].median()
    names = {"sdc_expected": 0.9, "sdc_nominal": 1.2, "kowalsky_priestley": 0.3}
    table = table.assign(
        beyond_model="shear",
        **{f"column_shear_dcr_{name}": factor * ratio for name, factor in names.items()},
    )
    found = shear_model_medians(table).set_index("limit_state")
    assert found.loc["sdc_nominal", "theta"] < found.loc["sdc_expected", "theta"]
    # a demand of the whole history is known although the study ended the run at its own failure
    assert set(found["n_unknown"]) == set(found["n_beyond_model"]) == {0}
    assert shear_model_medians(
        table.drop(columns=[f"column_shear_dcr_{name}" for name in names])
    ).empty
