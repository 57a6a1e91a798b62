"""Invariants of the pure functions of the bridge package."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skewbridge.bridge.abutment.backfill import Passive
from skewbridge.bridge.deck import deck_end, tributary_shares

SKEWS = st.floats(-60.0, 60.0)


@given(st.floats(1e6, 1e9), st.floats(1e5, 1e8), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_passive_force_grows_below_its_initial_stiffness(stiffness, ultimate, ratio, closure_m):
    passive = Passive(stiffness_n_per_m=stiffness, ultimate_n=ultimate, failure_ratio=ratio)
    less, more = passive.force_n([closure_m, 1.1 * closure_m])
    assert 0.0 <= less <= more * (1 + 1e-12)
    assert less <= stiffness * closure_m * (1 + 1e-12)
    assert passive.force_n(-closure_m) == 0.0


@given(SKEWS, st.floats(5.0, 30.0), st.floats(0.2, 2.0), st.integers(2, 12))
def test_opposite_skews_and_opposite_ends_mirror_each_other(skew_deg, width_m, thickness_m, count):
    right, left, mirrored = (
        deck_end(side, 80.0, sign * skew_deg, width_m, thickness_m)
        for side, sign in (("right", 1), ("left", 1), ("right", -1))
    )
    assert np.dot(right.normal, right.tangent) == pytest.approx(0.0, abs=1e-12)
    for along in right.wall_stations(count):
        x, y = right.point("outer", along)
        assert left.point("outer", along) == pytest.approx((-x, -y), abs=1e-9)
        assert mirrored.point("outer", -along) == pytest.approx((x, -y), abs=1e-9)
    edges = [right.point("outer", along)[1] for along in right.wall_stations(count)]
    assert edges[0] == pytest.approx(-width_m / 2)
    assert edges[-1] == pytest.approx(width_m / 2)
    assert sum(tributary_shares(count)) == pytest.approx(1.0)
