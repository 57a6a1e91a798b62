"""Invariants of functions of the bridge package and of the contact law."""

from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skewbridge.bridge.plan import DeckEnd
from skewbridge.contact import ContactLaw
from skewbridge.contact.law import advance_pair
from skewbridge.verification.references import driven_unit


@given(st.floats(-66.0, 66.0), st.floats(5.0, 30.0), st.floats(0.2, 2.0), st.integers(3, 12))
def test_opposite_skews_and_opposite_ends_mirror_each_other(skew_deg, width_m, thickness_m, count):
    right, left, mirrored = (
        DeckEnd("end", (40.0 * x, 0.0), (x, 0.0), sign * skew_deg, width_m, thickness_m)
        for x, sign in ((1.0, 1), (-1.0, 1), (1.0, -1))
    )
    assert np.dot(right.normal, right.tangent) == pytest.approx(0.0, abs=1e-12)
    for along in right.wall_stations(count):
        x, y, z = right.point("outer", along)
        assert left.point("outer", along) == pytest.approx((-x, -y, z), abs=1e-9)
        assert mirrored.point("outer", -along) == pytest.approx((x, -y, z), abs=1e-9)
    edges = [right.point("outer", along)[1] for along in right.wall_stations(count)]
    assert (edges[0], edges[-1]) == (pytest.approx(-width_m / 2), pytest.approx(width_m / 2))


POSITIONS = st.floats(-1.0, 1.0)
STIFFNESSES = st.floats(1e3, 1e9)
LAWS = st.builds(
    ContactLaw, kn_n_per_m=STIFFNESSES, kt_n_per_m=STIFFNESSES, friction=st.floats(0.0, 1.5),
    cohesion_n=st.floats(0.0, 1e4),
)  # fmt: skip
OPENINGS = st.floats(-0.1, 0.1)


@given(law=LAWS, x=POSITIONS, y=POSITIONS, sx=POSITIONS, sy=POSITIONS, opening=OPENINGS)
def test_the_force_stays_in_the_cone_and_never_pulls(law, x, y, sx, sy, opening):
    state = advance_pair(law, (sx, sy), (x, y), opening)
    size = hypot(*state.force_n)
    assert state.normal_n >= 0.0
    assert size <= (law.cohesion_n + law.friction * state.normal_n) * (1.0 + 1e-12) + 1e-9
    if opening >= 0.0:
        assert (state.normal_n, size) == (0.0, 0.0)


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000), closed=st.booleans())
def test_a_closed_loop_never_gives_energy_away(seed, closed):
    law = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.4, cohesion_n=500.0)
    # a smooth path in space of two seconds that opens and closes
    rng, t = np.random.default_rng(seed), np.linspace(0.0, 2.0, 201)
    phases, shares = rng.uniform(0, 2 * pi, (3, 3)), rng.normal(size=(3, 3))
    harmonics = np.sin(pi * np.arange(1, 4)[:, None] * t + phases[..., None])
    waves = np.einsum("ij,ijk->ki", shares, harmonics)
    path = np.column_stack([t, [0.25, 0.25, 0.04] * (waves - waves[0])])
    if closed:
        path[:, 3] = -0.05
    # The path is periodic: what is not dissipated would come back in the second round.
    twice = np.vstack([path, path[1:] + np.array([2.0, 0.0, 0.0, 0.0])])
    forces, second = driven_unit.follow_law(law, twice), slice(len(path) - 1, None)
    work = driven_unit.path_work_j(twice[second], forces[second])
    stored = np.hypot(*forces[[len(path) - 1, -1], :2].T) ** 2 / (2 * law.kt_n_per_m)
    assert work - float(stored[1] - stored[0]) >= -1e-9 * abs(work) - 1e-6
