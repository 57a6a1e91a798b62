"""Properties of spectra and measures for any motion, and of synthetic motions for any scenario."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from skewbridge.errors import InputError
from skewbridge.motions.intensity import component_psa, motion_measures, pair_psa, scaled_measures
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.synthesis import Scenario, synthesize, target_spectrum


def _motion(seed: int, npts: int = 600) -> GroundMotion:
    rng = np.random.default_rng(seed)
    pair = rng.standard_normal((2, npts)) * np.hanning(npts) * rng.uniform(0.5, 2.0, (2, 1))
    return GroundMotion(motion_id="m", dt_s=0.01, accel_1_mps2=pair[0], accel_2_mps2=pair[1])


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6), scale=st.floats(0.01, 20.0))
def test_measures_scale_with_the_motion(seed, scale):
    motion = _motion(seed)
    expected = motion_measures(motion.scaled(scale), 0.7)
    assert scaled_measures(motion_measures(motion, 0.7), scale) == pytest.approx(expected, rel=1e-9)


@settings(max_examples=60)
@given(
    st.integers(0, 10**6), st.sampled_from([0.05, 0.4, 2.0, 7.5]), st.sampled_from([1.0, 0.3, 0.01])
)
def test_reduced_orbit_gives_the_median_of_the_full_orbit(seed, period_s, ratio):
    motion = _motion(seed)
    pair = (motion.accel_1_mps2, ratio * motion.accel_2_mps2)
    turned = [np.cos(a) * pair[0] + np.sin(a) * pair[1] for a in np.deg2rad(np.arange(180))]
    full = [component_psa(accel, 0.01, period_s)[0] for accel in turned]
    psa = pair_psa(*pair, 0.01, period_s)
    assert psa.rotd50_mps2[0] == pytest.approx(np.median(full), rel=1e-9)
    assert psa.rotd100_mps2[0] == pytest.approx(np.max(full), rel=1e-9)


def test_filter_agrees_with_an_ode_solver():
    """The recursion is exact for piecewise linear input; the solver is held to 1e-9."""
    accel, dt_s, omega, xi = _motion(7, npts=60).accel_1_mps2, 0.01, 2 * np.pi / 0.6, 0.05
    peak_m, state = 0.0, np.zeros(2)
    for i in range(accel.size - 1):

        def rate(t, y, i=i):
            p = accel[i] + (accel[i + 1] - accel[i]) * t / dt_s
            return [y[1], -p - 2 * xi * omega * y[1] - omega**2 * y[0]]

        state = solve_ivp(rate, (0, dt_s), state, rtol=1e-11, atol=1e-15).y[:, -1]
        peak_m = max(peak_m, abs(state[0]))
    assert component_psa(accel, dt_s, 0.6)[0] == pytest.approx(omega**2 * peak_m, rel=1e-8)


SCENARIOS = st.builds(
    Scenario, magnitude=st.floats(6.5, 7.9), distance_km=st.floats(1.0, 31.0),
    vs30_mps=st.floats(150.0, 1500.0), mechanism=st.sampled_from(["strike_slip", "reverse"]),
    pulse=st.sampled_from(["none", "all"]),
)  # fmt: skip


@settings(max_examples=8)
@given(scenario=SCENARIOS, seed=st.integers(0, 10**6), index=st.integers(0, 500))
def test_any_scenario_gives_a_finite_and_repeatable_motion(scenario, seed, index):
    one = synthesize(scenario, index=index, seed=seed)
    two = synthesize(scenario, index=index, seed=seed)
    np.testing.assert_array_equal(one.components, two.components)
    assert 0.0 < np.abs(one.accel_1_mps2).max() < 100.0


def test_motions_of_one_seed_differ_and_a_scenario_outside_the_model_is_refused():
    scenario = Scenario(magnitude=7.0, distance_km=10.0, vs30_mps=400.0)
    first, second = (synthesize(scenario, index=i, seed=1) for i in (0, 1))
    size = min(first.npts, second.npts)
    assert abs(np.corrcoef(first.accel_1_mps2[:size], second.accel_1_mps2[:size])[0, 1]) < 0.5
    in_order = [target_spectrum(scenario, seed=4, index=i) for i in range(38)]
    np.testing.assert_array_equal(target_spectrum(scenario, seed=4, index=37), in_order[37])
    fields = {"magnitude": 7.0, "distance_km": 10.0, "vs30_mps": 2016.0}
    Scenario(**fields)
    for field, value in (
        ("magnitude", 6.4), ("magnitude", 8.5), ("magnitude", np.nan), ("distance_km", 40.0),
        ("vs30_mps", 138.0), ("vs30_mps", 2017.0), ("vs30_mps", np.nan),
    ):  # fmt: skip
        with pytest.raises(InputError, match=field):
            Scenario(**fields | {field: value})
