"""One model over the axes: its terms, what it says of states and left-out variants, its box."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.joint.columns import JOINT_COLUMNS
from skewbridge.fragility.joint.model import JointModel
from skewbridge.fragility.joint.table import joint_table
from skewbridge.fragility.joint.terms import box_of
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.limit_states import load_limit_states

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
DRIFT = [s for s in STATES if s.component == "column_drift" and s.name in ("slight", "moderate")]
SETTINGS = FitSettings(bootstrap=199)
GRID = {"skews": (0, 20, 40, 60), "gaps": (0, 25, 51), "frictions": (0, 50), "motions": 24}


def shifted(table, effect):
    """Multiply the drift of every run by the exponential of an effect of its axes."""
    return table.assign(column_drift_ratio=table["column_drift_ratio"] * np.exp(effect(table)))


def joint(table, states=DRIFT):
    return joint_table(table, states, IM, fit_study(table, states, IM, SETTINGS), SETTINGS)


def best(table, name="moderate"):
    found = joint(table).query("preferred and limit_state == @name")
    assert len(found) == 1
    return found.iloc[0].to_dict()


def test_medians_between_the_variants_follow_the_generator():
    """Quadratic in skew, linear in a gap that may be closed, with friction acting at high skew."""

    def effect(t):
        skew, gap = t["skew_deg"] / 60.0, t["gap_mm"] / 50.8
        return 0.3 * skew**2 + 0.1 * gap + 0.4 * skew * t["friction"]

    table = shifted(synthetic_demands(**GRID), effect)
    row = best(table)
    model = JointModel.of_row(row)
    place = {"skew_deg": 45.0, "gap_mm": 40.0, "friction": 0.3}
    origin = {"skew_deg": 0.0, "gap_mm": 0.0, "friction": 0.0}
    # demand grows with slope 1 in intensity, so medians fall by what the demand grows by
    fall = model.ratio(origin, place, 0.9)
    assert fall[0] == pytest.approx(np.exp(-effect(place) / row["slope"]), rel=0.02)
    assert fall[1] < fall[0] < fall[2]
    low, high = model.ci_beta
    assert low < model.beta < high
    assert low * high == pytest.approx(model.beta**2)
    assert not row["log_gap"]
    assert "skew_deg:skew_deg" in row["terms"].split(";")
    assert "skew_deg:friction" in row["terms"].split(";")
    assert row["loo_error"] < 0.02
    assert row["loo_variants"] == 24
    assert row["se_bootstrap"] == pytest.approx(row["se_ln_theta"], rel=0.3)


def test_a_gap_enters_by_its_logarithm_where_that_predicts_better():
    grid = GRID | {"gaps": (6, 25, 51, 100), "skews": (0, 30)}
    table = shifted(synthetic_demands(**grid), lambda t: 0.3 * np.log(t["gap_mm"]))
    assert best(table)["log_gap"]


def test_the_slope_of_a_demand_may_differ_between_variants():
    grid = GRID | {"gaps": (51,)}
    table = synthetic_demands(**grid)
    steep = 1.0 + 0.4 * (table["skew_deg"] / 60.0)
    table["column_drift_ratio"] *= table[IM] ** (steep - 1.0)
    row = best(table)
    assert "skew_deg:ln_im" in row["model_terms"]
    assert row["loo_error"] < 0.02


def test_negative_skews_count_by_size_unless_both_signs_are_there():
    one = synthetic_demands(**GRID | {"skews": (0, -30, -60)})
    model = JointModel.of_row(best(one))
    assert model.box.limits["skew_deg"] == (0.0, 60.0)
    place = {"gap_mm": 25.0, "friction": 0.5}
    assert model.median(place | {"skew_deg": -45.0}) == model.median(place | {"skew_deg": 45.0})
    both = shifted(
        synthetic_demands(**GRID | {"skews": (-45, 0, 45)}), lambda t: 0.3 * t["skew_deg"] / 60.0
    )
    model = JointModel.of_row(best(both))
    assert model.box.limits["skew_deg"] == (-45.0, 45.0)
    apart = model.ratio(place | {"skew_deg": -45.0}, place | {"skew_deg": 45.0}, 0.95)
    assert apart[0] == pytest.approx(np.exp(-0.45), rel=0.03)


def test_collapsed_runs_are_demands_above_their_last_value():
    """The strongest runs collapse at drift 0.03: left out they would make the bridge stronger."""
    whole = synthetic_demands(**GRID | {"gaps": (51,), "motions": 80, "skews": (0, 30)})
    fallen = whole["column_drift_ratio"] > 0.03
    assert 0.1 < fallen.mean() < 0.3
    cut = whole.assign(
        status=np.where(fallen, "collapse", "ok"),
        column_drift_ratio=np.minimum(whole["column_drift_ratio"], 0.03),
    )
    full, censored = best(whole), best(cut)
    assert censored["n_censored"] == fallen.sum()
    assert censored["n_exceed"] == full["n_exceed"]
    assert censored["theta"] == pytest.approx(full["theta"], rel=0.05)
    assert censored["beta"] == pytest.approx(full["beta"], rel=0.1)
    dropped = best(whole[~fallen])
    assert dropped["theta"] > 1.1 * full["theta"]


def test_a_run_that_left_no_demand_says_nothing():
    whole = synthetic_demands(**GRID | {"gaps": (51,), "skews": (0, 30)})
    lost = whole.index[[3, 40]]
    crashed = whole.copy()
    crashed.loc[lost, "status"] = "crash"
    crashed.loc[lost, "column_drift_ratio"] = np.nan
    tables = [
        joint(table).set_index(["source", "limit_state"]) for table in (crashed, whole.drop(lost))
    ]
    for name in ("theta", "beta", "n_censored"):
        found, expected = (table.loc[("demand", "moderate"), name] for table in tables)
        assert found == pytest.approx(expected, rel=1e-9)


def test_bridges_and_abutments_have_models_of_their_own_with_the_axes_they_have():
    friction = synthetic_demands(**GRID | {"gaps": (25, 51), "skews": (0, 30, 60)})
    roller = friction[(friction["gap_mm"] == 51) & (friction["friction"] == 0.0)].assign(
        abutment="roller", gap_mm=0, variant=lambda t: t["variant"].str.replace("_cf_", "_ro_")
    )
    other = friction.assign(bridge="osb2", variant=friction["variant"] + "x")
    other["column_drift_ratio"] *= 2.0
    found = joint(pd.concat([friction, roller, other], ignore_index=True)).query("preferred")
    assert list(found.columns) == list(JOINT_COLUMNS)
    own = found.query("limit_state == 'slight'").set_index(["bridge", "abutment"])
    assert set(own.index) == {
        ("osb1", "contact_friction"),
        ("osb1", "roller"),
        ("osb2", "contact_friction"),
    }
    assert list(json.loads(own.loc[("osb1", "roller"), "box"])) == ["skew_deg"]
    ratio = (
        own.loc[("osb2", "contact_friction"), "theta"]
        / own.loc[("osb1", "contact_friction"), "theta"]
    )
    slope = own.loc[("osb1", "contact_friction"), "slope"]
    assert ratio == pytest.approx(0.5 ** (1.0 / slope), rel=1e-6)


def test_states_without_exceedance_or_logarithm_say_so():
    table = synthetic_demands(**GRID | {"gaps": (51,)})
    complete = [s for s in STATES if (s.component, s.name) == ("column_drift", "complete")]
    table.loc[table[IM] < 0.2, "column_drift_ratio"] = 0.0
    found = joint(table, [*DRIFT, *complete]).set_index(["limit_state", "source"])
    assert found.loc[("moderate", "demand"), "status"] == "non_positive_demand"
    assert found.loc[("moderate", "exceedance"), "preferred"]
    assert found.loc[("complete", "exceedance"), "status"] == "no_exceedance"
    assert not found.loc["complete", "preferred"].any()
    alone = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,))
    assert set(joint(alone)["status"]) == {"no_axis_varies"}


def test_few_motions_have_no_model():
    assert "ok" not in set(joint(synthetic_demands(motions=4))["status"])


def test_a_place_outside_the_box_is_refused_by_name():
    box = box_of(pd.DataFrame({"skew_deg": [0, 60], "gap_mm": [51, 51]}), ["skew_deg", "gap_mm"])
    box.check({"skew_deg": -60.0, "gap_mm": 51.0, "friction": 0.7})  # no axis of this model
    box.check({"skew_deg": 30.0})
    for values, words in (
        ({"skew_deg": 61.0}, r"skew_deg must be within 0\.\.60"),
        ({"skew_deg": 10.0, "gap_mm": 40.0}, r"gap_mm must be within 51\.\.51"),
        ({"gap_mm": 51.0}, "skew_deg is missing"),
        ({"skew_deg": 10.0, "soil": 1.0}, "soil is no axis"),
    ):
        with pytest.raises(InputError, match=words):
            box.check(values)
