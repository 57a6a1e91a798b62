"""Paired effects: what is found, what is left out, what is decided."""

from pathlib import Path

import numpy as np
import pytest

from fragility_tables import IM, synthetic_demands, verdict_of
from skewbridge.errors import InputError
from skewbridge.fragility.joint.shares import axis_shares
from skewbridge.fragility.tables.effects import (
    EFFECT_COLUMNS,
    paired_effects,
)
from skewbridge.fragility.tables.factors import factor_summary
from skewbridge.fragility.tables.im_quality import rank_measures
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.fragility.tables.median_effects import paired_capacity_effects

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")


def friction_rows(effects, demand, scope="variant"):
    return effects[
        (effects["demand"] == demand)
        & (effects["axis"] == "friction")
        & (effects["scope"] == scope)
    ]


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (1.06, 1.2, "higher"),
        (0.8, 0.94, "lower"),
        (0.96, 1.04, "negligible"),
        (1.01, 1.04, "negligible"),  # the direction is known, and the size does not count
        (1.01, 1.2, "detectable"),
        (0.9, 0.99, "detectable"),
        (0.96, 1.06, "undecided"),
        (0.9, 1.1, "undecided"),
        (np.nan, np.nan, "undecided"),
    ],
)
def test_an_interval_has_the_first_verdict_that_holds(low, high, verdict):
    assert verdict_of(low, high) == verdict


def test_effect_of_the_generator_is_found_and_nothing_else():
    effects = paired_effects(synthetic_demands())
    assert list(effects.columns) == list(EFFECT_COLUMNS)
    rotation = friction_rows(effects, "deck_rotation_rad")
    assert len(rotation) == 6
    assert set(rotation["direction"]) == {-1}
    assert rotation["ratio"].to_numpy() == pytest.approx(np.exp(-0.1), abs=0.04)
    pooled = friction_rows(effects, "deck_rotation_rad", "pooled").iloc[0]
    # 96 ratios of 3 % x root 2 scatter: standard error 0.4 %
    assert pooled["ratio"] == pytest.approx(np.exp(-0.1), abs=0.012)
    assert set(friction_rows(effects, "deck_disp_m")["verdict"]) == {"negligible"}


def test_pairing_sees_what_an_unpaired_comparison_cannot():
    table = synthetic_demands(skews=(0,), gaps=(51,), friction_effect=-0.04)
    rotation = friction_rows(paired_effects(table), "deck_rotation_rad").iloc[0]
    assert rotation["ci_high"] < 1.0
    groups = table.groupby("friction")["deck_rotation_rad"]
    logs = groups.apply(lambda d: np.log(d).std(ddof=1)).to_numpy()
    unpaired = 1.7 * np.sqrt(np.sum(logs**2) / 16)  # standard error of the log ratio
    assert unpaired > 10 * (rotation["ci_high"] - rotation["ci_low"]) / 2


def test_result_does_not_depend_on_the_order_of_rows():
    table = synthetic_demands(skews=(0, 30), gaps=(51,))
    first = paired_effects(table)
    second = paired_effects(table.sample(frac=1.0, random_state=1))
    assert first["ci_low"].to_numpy() == pytest.approx(second["ci_low"].to_numpy(), rel=1e-12)


def test_a_zero_is_left_out_and_counted_and_ended_runs_are_bounds():
    table = synthetic_demands(skews=(0,), gaps=(51,))
    table.loc[0, "status"] = "timeout"
    table.loc[1, "status"] = "collapse"
    table.loc[2, "deck_disp_m"] = 0.0
    found = friction_rows(paired_effects(table), "deck_disp_m").iloc[0]
    assert (found["n_motions"], found["n_bounds"], found["dof"]) == (15, 2, 12)
    assert (found["n_left_out"], found["n_discordant"]) == (1, 1)
    assert found["n_collapse_from"] == 1
    # the others agree within 5 %, which says nothing about the one without a ratio
    assert (found["ci_low"] > 0.95) & (found["ci_high"] < 1.05)
    assert found["verdict"] == "undecided"


def test_no_effect_at_all_has_an_interval_of_no_width():
    table = synthetic_demands(skews=(0,), gaps=(51,), run_scatter=0.0)
    found = friction_rows(paired_effects(table), "deck_disp_m").iloc[0]
    assert (found["ratio"], found["ci_low"], found["ci_high"]) == pytest.approx((1, 1, 1))
    assert found["verdict"] == "negligible"


def test_a_demand_that_is_always_zero_is_undecided():
    table = synthetic_demands(skews=(0,), gaps=(51,)).assign(friction_force_kn=0.0)
    found = friction_rows(paired_effects(table, ["friction_force_kn"]), "friction_force_kn")
    assert found.iloc[0]["verdict"] == "undecided"
    assert found.iloc[0]["n_motions"] == 0


def test_a_doubled_run_is_refused():
    table = synthetic_demands(skews=(0,), gaps=(51,))
    doubled = table.loc[[*table.index, 0]]
    with pytest.raises(InputError, match="occurs twice"):
        paired_effects(doubled)


def test_median_capacities_are_compared_on_the_same_motions():
    table = synthetic_demands(skews=(0,), gaps=(51,), run_scatter=0.01)
    table.loc[table["friction"] == 0.5, "column_drift_ratio"] *= 1.2
    drift = [state for state in STATES if state.component == "column_drift"]
    found = paired_capacity_effects(table, drift, IM).set_index("demand")
    moderate = found.loc["column_drift/moderate"]
    assert moderate["ratio"] == pytest.approx(1 / 1.2, rel=0.03)
    assert (moderate["verdict"], moderate["direction"]) == ("lower", -1)
    assert "column_drift/complete" not in found.index  # no run exceeds: no median to compare


def test_factors_and_sobol_rank_the_axes_as_generated():
    table = synthetic_demands()
    found = factor_summary(table, ["deck_rotation_rad"]).set_index("factor")
    assert found.loc["skew_deg", "partial_eta2"] > found.loc["friction", "partial_eta2"] > 0.5
    assert found.loc["gap_mm", "p_value"] > 0.01
    shares = axis_shares(table, "deck_rotation_rad", IM, seed=1)
    assert shares.axes == ("skew_deg", "gap_mm", "friction")
    assert shares.scatter == pytest.approx(0.03, rel=0.2)
    # variances of 0.4 u and 0.1 u over uniform ranges 0..0.75 and 0..0.5
    assert shares.first_order[0] == pytest.approx(0.09 / (0.09 + 0.01), abs=0.05)
    # mean of 16 runs of 3 % scatter: about 1.5 % expected
    assert shares.worst_prediction < 0.05


def test_measures_are_ranked_with_a_probability_of_being_best():
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=40)
    rng = np.random.default_rng(0)
    table["im_poor_g"] = table[IM] * np.exp(0.6 * rng.normal(size=len(table)))
    table["im_bad_g"] = 0.0
    motions = table[["motion_id"]].assign(
        magnitude=rng.uniform(5, 7.5, len(table)), distance_km=rng.uniform(2, 60, len(table))
    )
    found = rank_measures(table, "column_drift_ratio", motions=motions).set_index("im")
    assert list(found.index[:2]) == [IM, "im_poor_g"]
    assert found.loc[IM, "p_best_efficiency"] > 0.99
    assert found.loc["im_bad_g", "status"] == "non_positive_im"
    assert found.loc[IM, "relative_sufficiency_nats"] == 0.0
    assert found.loc[IM, "p_magnitude"] > 0.01


def test_a_single_axis_has_all_of_the_variance():
    table = synthetic_demands(seed=4)
    table = table[(table["skew_deg"] == 0) & (table["gap_mm"] == table["gap_mm"].min())]
    shares = axis_shares(table, "column_drift_ratio", IM, seed=1)
    assert shares.axes == ("friction",)
    assert shares.first_order.tolist() == [1.0]
