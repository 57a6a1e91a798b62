"""Properties of synthetic motions for any scenario."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skewbridge.errors import InputError
from skewbridge.motions.synthesis.bssa14 import target_spectrum
from skewbridge.motions.synthesis.ddk18 import Scenario
from skewbridge.motions.synthesis.generate import SynthesisOptions, synthesize

SCENARIOS = st.builds(
    Scenario,
    magnitude=st.floats(6.5, 7.9),
    distance_km=st.floats(1.0, 31.0),
    vs30_mps=st.floats(150.0, 1500.0),
    mechanism=st.sampled_from(["strike_slip", "reverse"]),
    ztor_km=st.just(0.0),
    pulse=st.sampled_from(["none", "all", "probability"]),
)


@settings(max_examples=8, deadline=None)
@given(scenario=SCENARIOS, seed=st.integers(0, 10**6), index=st.integers(0, 500))
def test_any_scenario_gives_a_finite_and_repeatable_motion(scenario, seed, index):
    options = SynthesisOptions(dt_s=0.02)
    one = synthesize(scenario, index=index, seed=seed, options=options)
    two = synthesize(scenario, index=index, seed=seed, options=options)
    np.testing.assert_array_equal(one.accel_1_mps2, two.accel_1_mps2)
    np.testing.assert_array_equal(one.accel_2_mps2, two.accel_2_mps2)
    assert 0.0 < np.abs(one.accel_1_mps2).max() < 100.0


def test_motions_of_one_seed_differ():
    scenario = Scenario(magnitude=7.0, distance_km=10.0, vs30_mps=400.0)
    first, second = (synthesize(scenario, index=i, seed=1) for i in (0, 1))
    size = min(first.npts, second.npts)
    assert abs(np.corrcoef(first.accel_1_mps2[:size], second.accel_1_mps2[:size])[0, 1]) < 0.5


def test_target_of_a_motion_does_not_depend_on_the_others():
    scenario = Scenario(magnitude=7.0, distance_km=10.0, vs30_mps=400.0)
    alone = target_spectrum(scenario, seed=4, index=37)
    in_order = [target_spectrum(scenario, seed=4, index=i) for i in range(38)][37]
    np.testing.assert_array_equal(alone, in_order)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("magnitude", 6.4), ("magnitude", 8.5), ("magnitude", float("nan")), ("distance_km", 40.0),
        ("vs30_mps", 138.0), ("vs30_mps", 2017.0), ("vs30_mps", float("nan")),
        ("ztor_km", -1.0),
    ],
)  # fmt: skip
def test_scenario_outside_the_model_is_refused_by_name(field, value):
    fields = {"magnitude": 7.0, "distance_km": 10.0, "vs30_mps": 2016.0}
    Scenario(**fields)
    with pytest.raises(InputError, match=field):
        Scenario(**fields | {field: value})
