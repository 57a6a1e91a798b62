"""Cutting and padding: what they keep and what they say."""

import numpy as np
import pytest

from motions_files import make_pairs
from skewbridge.errors import InputError
from skewbridge.motions.conditioning import (
    cut_to_strongest,
    effect_on_measures,
    strongest_part,
    trim_quiet_ends,
)
from skewbridge.motions.intensity import displacement, velocity
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import prepare_suite
from skewbridge.motions.synthesis.ddk18 import Scenario
from skewbridge.motions.synthesis.generate import synthesize


@pytest.fixture(scope="module")
def motion() -> GroundMotion:
    scenario = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
    return synthesize(scenario, index=0, seed=2023)


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


def test_a_cut_motion_has_a_message_and_another_digest(motion):
    done = strongest_part(motion, 10.0)
    assert done.sha256 != motion.sha256
    assert "of the Arias intensity left" in done.messages[-1]
    assert done.duration_s == pytest.approx(10.0, abs=0.011)


def test_suite_can_be_cut(tmp_path):
    make_pairs(tmp_path, 1)
    whole = prepare_suite(tmp_path, t1_s=0.7)
    cut = prepare_suite(tmp_path, t1_s=0.7, shaking_s=3.0)
    assert cut["npts"][0] == 300 < whole["npts"][0]
    assert cut["sha256"][0] != whole["sha256"][0]


@pytest.mark.parametrize(("shaking_s", "free_vibration_s"), [(0.0, 0.0), (20.0, -1.0)])
def test_impossible_lengths_are_refused(motion, shaking_s, free_vibration_s):
    with pytest.raises(InputError):
        cut_to_strongest(motion, shaking_s, free_vibration_s)
