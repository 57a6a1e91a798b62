"""Cutting, resampling, padding: what they keep and what they say."""

import numpy as np
import pytest

from motions_files import make_pairs
from skewbridge.errors import InputError
from skewbridge.motions.conditioning import (
    Conditioning,
    cut_to_strongest,
    effect_on_measures,
    remove_mean,
    resampled,
    trim_quiet_ends,
)
from skewbridge.motions.intensity import displacement, velocity
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.spectrum import pair_psa
from skewbridge.motions.suite import prepare_suite
from skewbridge.motions.synthesis.ddk18 import Scenario
from skewbridge.motions.synthesis.generate import synthesize


@pytest.fixture(scope="module")
def motion() -> GroundMotion:
    scenario = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
    return synthesize(scenario, index=0, seed=2023)


def test_default_conditioning_changes_nothing(motion):
    assert Conditioning().apply(motion) is motion


def test_cut_motion_ends_at_rest_with_zeros_after_it(motion):
    cut = cut_to_strongest(motion, 20.0, 5.0)
    assert cut.npts == 2500
    for accel in (cut.accel_1_mps2, cut.accel_2_mps2):
        assert np.all(accel[-500:] == 0.0)
        speed, disp = velocity(accel, cut.dt_s), displacement(accel, cut.dt_s)
        assert abs(speed[-1]) < 1e-9 * np.abs(speed).max()
        assert abs(disp[-1]) < 1e-9 * np.abs(disp).max()


def test_cut_keeps_the_strongest_window(motion):
    assert effect_on_measures(motion, cut_to_strongest(motion, 20.0, 5.0))["arias_ratio"] > 0.95
    assert effect_on_measures(motion, cut_to_strongest(motion, 5.0, 0.0))["arias_ratio"] < 0.9


def test_trimming_quiet_ends_preserves_the_spectrum(motion):
    effect = effect_on_measures(motion, trim_quiet_ends(motion))
    ratios = np.array([value for name, value in effect.items() if name.startswith("psa")])
    # the displacement left at the new end is taken off: felt at 2 and 3 s only
    np.testing.assert_allclose(ratios[:-2], 1.0, atol=0.002)
    np.testing.assert_allclose(ratios[-2:], 1.0, atol=0.02)
    assert trim_quiet_ends(motion).duration_s < 0.8 * motion.duration_s


def test_finer_time_step_keeps_values_and_long_periods(motion):
    fine = resampled(motion, 0.005)
    assert fine.dt_s == pytest.approx(0.005)
    # the filter takes the tenth next to Nyquist, where a record has little
    lost = fine.accel_1_mps2[::2][: motion.npts] - motion.accel_1_mps2
    assert np.sum(lost**2) < 1e-3 * np.sum(motion.accel_1_mps2**2)
    before = pair_psa(motion.accel_1_mps2, motion.accel_2_mps2, motion.dt_s, [0.2, 1.0])
    after = pair_psa(fine.accel_1_mps2, fine.accel_2_mps2, fine.dt_s, [0.2, 1.0])
    # straight lines between samples lose (pi dt/T)^2 / 3 = 0.8 % at dt/T = 1/20
    np.testing.assert_allclose(after.rotd50_mps2, before.rotd50_mps2, rtol=1e-2)


def test_coarser_time_step_does_not_alias():
    time_s = np.arange(4000) * 0.005
    high = np.sin(2 * np.pi * 45.0 * time_s) * np.hanning(4000)  # above the new Nyquist of 25 Hz
    low = np.sin(2 * np.pi * 2.0 * time_s) * np.hanning(4000)
    motion = GroundMotion(motion_id="m", dt_s=0.005, accel_1_mps2=high, accel_2_mps2=low)
    coarse = resampled(motion, 0.02)
    assert np.abs(coarse.accel_1_mps2).max() < 1e-3
    np.testing.assert_allclose(coarse.accel_2_mps2, low[::4], atol=1e-3)


def test_mean_is_removed(motion):
    offset = motion.with_components(motion.accel_1_mps2 + 0.3, motion.accel_2_mps2)
    assert abs(remove_mean(offset).accel_1_mps2.mean()) < 1e-12


def test_conditioned_motion_has_a_message_and_another_digest(motion):
    done = Conditioning(shaking_s=10.0, free_vibration_s=2.0).apply(motion)
    assert done.sha256 != motion.sha256
    assert "of the Arias intensity left" in done.messages[-1]
    assert done.duration_s == pytest.approx(12.0, abs=0.011)


def test_suite_can_be_conditioned(tmp_path):
    make_pairs(tmp_path, 1)
    plain = prepare_suite(tmp_path, t1_s=0.7)
    padded = prepare_suite(tmp_path, t1_s=0.7, conditioning=Conditioning(free_vibration_s=3.0))
    assert padded["npts"][0] == plain["npts"][0] + 300
    assert padded["sha256"][0] != plain["sha256"][0]


@pytest.mark.parametrize(
    "what",
    [
        Conditioning(dt_s=-0.01),
        Conditioning(dt_s=0.00314159265),
        Conditioning(shaking_s=0.0),
        Conditioning(free_vibration_s=-1.0),
        Conditioning(shaking_s=20.0, free_vibration_s=-1.0),
    ],
)
def test_invalid_conditioning_is_refused(motion, what):
    with pytest.raises(InputError):
        what.apply(motion)


@pytest.mark.parametrize("dt_s", [0.0, -0.01, np.nan, np.inf])
def test_a_time_step_is_a_positive_number(motion, dt_s):
    with pytest.raises(InputError, match="dt_s must be positive"):
        resampled(motion, dt_s)
