"""Paired effects: what is found, what is left out, what is decided."""

from pathlib import Path

import numpy as np
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.tables.im_quality import rank_measures
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.fragility.tables.median_effects import paired_capacity_effects

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")


def test_median_capacities_are_compared_on_the_same_motions():
    table = synthetic_demands(skews=(0,), gaps=(51,), run_scatter=0.01)
    table.loc[table["friction"] == 0.5, "column_drift_ratio"] *= 1.2
    drift = [state for state in STATES if state.component == "column_drift"]
    found = paired_capacity_effects(table, drift, IM).set_index("demand")
    moderate = found.loc["column_drift/moderate"]
    assert moderate["ratio"] == pytest.approx(1 / 1.2, rel=0.03)
    assert (moderate["verdict"], moderate["direction"]) == ("lower", -1)
    assert "column_drift/complete" not in found.index  # no run exceeds: no median to compare


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
