"""Response spectra and intensity measures against closed forms."""

import numpy as np
import pytest

from skewbridge.motions.intensity import arias_build_up, cav, velocity
from skewbridge.motions.spectrum import component_psa, pair_psa
from skewbridge.units import G_MPS2


def test_step_input_doubles_less_damping():
    """PSA of a unit step from rest is 1 + exp(-pi xi / sqrt(1 - xi^2)) = 1.854467893."""
    damped_period_s = 1.0 / np.sqrt(1.0 - 0.05**2)
    psa = component_psa(np.ones(2000), damped_period_s / 1000.0, 1.0)
    assert psa[0] == pytest.approx(1.854467893, rel=1e-9)


def test_linear_polarisation_follows_the_cosine():
    """RotD(phi) = |cos(phi - phi0)|: the median is 1/sqrt 2 of the largest; 1 degree grid: 1e-4."""
    rng = np.random.default_rng(3)
    accel = rng.standard_normal(3000)
    psa = pair_psa(accel, 1.7 * accel, 0.01, [0.5, 2.0])
    np.testing.assert_allclose(psa.rotd100_mps2 / psa.psa_1_mps2, 1.972308292, rtol=1e-4)
    np.testing.assert_allclose(psa.rotd50_mps2 / psa.psa_1_mps2, 1.394632568, rtol=1e-4)


def test_sine_train_has_its_closed_form_measures():
    """PGV = 2 A/w from rest, Arias = pi/(2 g) A^2 T/2, CAV = 2 A T/pi; dt/T0 = 1e-3: 1e-4."""
    dt_s, period_s, cycles = 0.0005, 0.5, 10
    time_s = np.arange(round(cycles * period_s / dt_s) + 1) * dt_s
    accel = 0.3 * G_MPS2 * np.sin(2 * np.pi * time_s / period_s)
    assert np.abs(accel).max() == pytest.approx(0.3 * G_MPS2, rel=1e-4)
    assert np.abs(velocity(accel, dt_s)).max() == pytest.approx(0.4682330468, rel=1e-4)
    assert arias_build_up(accel, dt_s)[-1] == pytest.approx(3.465956205, rel=1e-4)
    assert cav(accel, dt_s) == pytest.approx(9.364660936, rel=1e-4)
