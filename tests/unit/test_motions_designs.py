"""Stripes, unscaled cloud and the search for a record's capacity."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motions_files import make_pairs
from skewbridge.errors import InputError
from skewbridge.motions.levels import (
    LEVEL_MEASURE,
    bracket_capacity,
    most_trials,
    striped,
)
from skewbridge.motions.suite import prepare_suite, read_suite, write_suite

#: Factors between which the searches look.
LIMITS = (0.1, 10.0)


@pytest.fixture
def suite(tmp_path):
    make_pairs(tmp_path, 3)
    return prepare_suite(tmp_path, t1_s=0.7)


def test_scaled_motions_reach_their_stripe(suite):
    low_g = suite[LEVEL_MEASURE].median()
    table = striped(suite, [low_g, 2 * low_g], factor_limits=(1e-3, 1e3))
    np.testing.assert_allclose(table["scale"] * table[LEVEL_MEASURE], table["stripe_g"])
    assert len(table) == 6
    assert not table.duplicated(["motion_id", "scale"]).any()


def test_factors_outside_the_limits_are_left_out_and_counted(suite):
    level_g = suite[LEVEL_MEASURE].iloc[0]
    table = striped(suite, [level_g], factor_limits=(0.999, 1.001))
    assert list(table["motion_id"]) == ["q0"]
    assert table["scale"].tolist() == [1.0]
    assert table.attrs["left_out"] == 2
    known = suite.assign(**{LEVEL_MEASURE: [0.2, 0.4, 100.0]})
    table = striped(known, [0.1, 1.0])
    assert table[["motion_id", "scale"]].to_numpy().tolist() == [
        ["q0", 0.5], ["q1", 0.25], ["q1", 2.5],
    ]  # fmt: skip


def test_unreachable_stripes_are_refused(suite):
    with pytest.raises(InputError, match="no motion reaches"):
        striped(suite, [1e4])


def test_parquet_preserves_a_striped_suite(suite, tmp_path):
    table = striped(suite, [0.1, 0.2], factor_limits=(1e-3, 1e3))
    write_suite(table, tmp_path / "stripes.parquet")
    back = read_suite(tmp_path / "stripes.parquet")
    assert [item.motion.motion_id for item in back] == ["q0", "q1", "q2"] * 2
    levels_g = [item.measures[LEVEL_MEASURE] for item in back]
    np.testing.assert_allclose(levels_g, [0.1] * 3 + [0.2] * 3)


def searched(capacity: float, limits: tuple[float, float], tolerance: float = 0.01):
    """Return the bracket of a capacity and the number of analyses of the search."""
    trials: list[float] = []

    def exceeds(scale: float) -> bool:
        trials.append(scale)
        return scale >= capacity

    return bracket_capacity(exceeds, limits=limits, tolerance=tolerance), len(trials)


@settings(max_examples=200, deadline=None)
@given(st.floats(0.05, 20.0), st.floats(1.001, 1e3), st.floats(1e-4, 0.5))
def test_search_takes_at_most_the_forecast_analyses(capacity, ratio, tolerance):
    limits = (0.1, 0.1 * ratio)
    _, analyses = searched(capacity, limits, tolerance)
    assert analyses <= most_trials(limits, tolerance)


@settings(max_examples=200, deadline=None)
@given(capacity=st.floats(1e-3, 1e3))
def test_bracket_contains_any_capacity_within_ten_analyses(capacity):
    (lower, upper), analyses = searched(capacity, LIMITS)
    assert analyses <= most_trials(LIMITS) == 10
    assert lower <= capacity <= upper
    if 0.1 < capacity <= 10.0:
        assert upper / lower <= 1.01
    else:
        assert lower == 0.0 or math.isinf(upper)
