"""The stochastic model against published values, and against the ground-motion model it targets.

Parameters: values of the unit test of NHERI-SimCenter smelt (BSD-2), an implementation of Dabaghi
and Der Kiureghian (2018), Earthquake Engineering and Structural Dynamics 47:1369-1393, for
M 6.5, 10 km, Vs30 760 m/s, strike-slip, s = 26 km. Medians: Boore et al. (2014), pygmm as oracle.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from skewbridge.motions import synthesis
from skewbridge.motions.intensity import pair_psa
from skewbridge.motions.synthesis import BSSA_PERIODS_S, DT_S, Scenario, synthesize
from skewbridge.units import G_MPS2

SMELT = Scenario(magnitude=6.5, distance_km=10.0, vs30_mps=760.0, rupture_to_site_km=26.0)
FOUR_DIGITS = 6e-4  # half a unit of the fourth digit of the published values
TEST_PERIODS_S = [0.1, 0.2, 0.5, 1.0, 2.0, 3.0]
NO_PULSE = {"magnitude": 6.75, "distance_km": 20.0}
PULSE = {"magnitude": 7.0, "distance_km": 5.0, "pulse": "all", "rupture_to_site_km": 25.0}
MEDIANS_G = ((NO_PULSE, [0.300, 0.478, 0.214, 0.107, 0.0589, 0.0434]),
             (PULSE, [0.520, 0.858, 0.624, 0.360, 0.278, 0.181]))  # fmt: skip


def test_regression_transforms_and_modulation_reproduce_the_published_values():
    normals = synthesis.mean_normals(SMELT)
    published = [4.5267, 2.1629, 1.0427, 1.5920, 1.7794, 0.0068, -0.0772,
                 3.9270, 2.3581, 0.9721, 1.5534, 1.9106, -0.2490, -0.0181]  # fmt: skip
    np.testing.assert_allclose(normals, published, atol=6e-5)
    parameters = synthesis.transform(normals)
    assert parameters.pulse is None
    _check(parameters.components[0], [92.45, 8.696, 2.837, 4.914, 5.926, -0.0496, 0.136])
    _check(parameters.components[1], [50.76, 10.571, 2.6435, 4.728, 6.757, -0.0847, 0.1424])
    parameters = synthesis.transform(synthesis.mean_normals(replace(SMELT, pulse="all")))
    pulse = parameters.pulse._asdict()
    published = {"peak_cm_s": 44.00, "period_s": 1.7189, "oscillations": 2.2567,
                 "phase_rad": np.pi, "peak_time_s": 5.2785}  # fmt: skip
    assert pulse == pytest.approx(published, rel=FOUR_DIGITS)
    _check(parameters.components[0], [125.14, 8.040, 3.550, 5.507, 4.312, -0.0602, 0.1555])
    _check(parameters.components[1], [110.07, 7.729, 3.381, 5.310, 5.059, -0.0736, 0.1309])
    for given, published in (
        ((12.0, 14.0, 3.9, 5.7), (2.1516, 0.1082, 4.8923, 0.0375)),
        ((9.0, 15.2, 3.9, 5.5), (4.4321, 0.0970, 4.0577, 0.0324)),
    ):
        fit = synthesis.fit_modulation(*given)
        found = (fit.power, fit.decay_per_s, fit.peak_s, fit.amplitude_g)
        np.testing.assert_allclose(found, published, atol=6e-5)


def _check(background, published):
    # the published digits of the last two are three
    np.testing.assert_allclose(background[:5], published[:5], rtol=FOUR_DIGITS)
    np.testing.assert_allclose(background[5:], published[5:], atol=6e-5)


def test_components_have_their_arias_intensity_and_pulses_their_amplitude():
    rng = np.random.default_rng(5)
    parameters = synthesis.draw_parameters(SMELT, rng)
    *pair_g, _ = synthesis.simulate_background(parameters, SMELT, rng, 0.01)
    for accel_g, drawn in zip(pair_g, parameters.components, strict=True):
        # pi / (2 g) times the integral of the square of g times the values, with the model's g
        arias_cm_s = np.pi / 2.0 * 981.0 * np.trapezoid(accel_g**2, dx=0.01)
        assert arias_cm_s == pytest.approx(drawn.arias_cm_s, rel=1e-6)
    # at phase 0 the velocity peaks near Vp at the centre; it ends at zero by construction
    given = {"peak_cm_s": 50.0, "period_s": 2.0, "oscillations": 2.4}
    pulse = synthesis.Pulse(**given, phase_rad=0.0, peak_time_s=5.0)
    time_s = np.arange(0, 10, 0.001)
    accel_g = synthesis.pulse_acceleration(pulse, time_s)
    velocity_cm_s = 981.0 * cumulative_trapezoid(accel_g, time_s, initial=0)
    centre = 0.5 * (1 + 1) * 50.0  # 0.5 Vp cos(0) (1 + cos 0), less the small Dr term
    assert np.abs(velocity_cm_s).max() == pytest.approx(centre, rel=0.05)
    assert abs(velocity_cm_s[-1]) < 0.02
    displacement_cm = cumulative_trapezoid(velocity_cm_s, time_s, initial=0)
    assert abs(displacement_cm[-1]) < 0.01 * np.abs(displacement_cm).max()


def test_ground_motion_model_agrees_with_pygmm_and_its_correlation_with_published_values():
    # section 4.2 of the motions page: correlation with 1 s, Baker and Jayaram (2008)
    periods_s = [0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0]
    published = [0.416, 0.279, 0.444, 0.573, 0.749, 0.895, 1.0, 0.852, 0.749, 0.609, 0.444]
    np.testing.assert_allclose(synthesis.baker_jayaram_correlation(periods_s)[6], published,
                               atol=6e-4)  # fmt: skip
    assert np.linalg.eigvalsh(synthesis.baker_jayaram_correlation(BSSA_PERIODS_S)).min() > 0.0
    pygmm = pytest.importorskip("pygmm")
    names = ("magnitude", "distance_km", "vs30_mps"), ("mag", "dist_jb", "v_s30")
    places = ((7.0, 10.0, 400.0), (6.5, 30.0, 250.0))
    for (name, code), place in product((("strike_slip", "SS"), ("reverse", "RS")), places):
        given, theirs = (dict(zip(each, place, strict=True)) for each in names)
        ours = Scenario(**given, mechanism=name)
        scenario = pygmm.Scenario(**theirs, mechanism=code, region="global")
        theirs = pygmm.BooreStewartSeyhanAtkinson2014(scenario)
        expected = theirs.interp_spec_accels(BSSA_PERIODS_S), theirs.interp_ln_stds(BSSA_PERIODS_S)
        np.testing.assert_allclose(synthesis.bssa14(ours, BSSA_PERIODS_S), expected, rtol=1e-9)


def test_120_calibrated_motions_follow_the_ground_motion_model():
    scenario = Scenario(**NO_PULSE, vs30_mps=400.0)
    motions = [synthesize(scenario, index=i, seed=1) for i in range(120)]
    spectra = [pair_psa(*motion.components, motion.dt_s, TEST_PERIODS_S) for motion in motions]
    log_50, log_100 = np.log(np.array(spectra) / G_MPS2).swapaxes(0, 1)
    median_g, sigma = synthesis.bssa14(scenario, TEST_PERIODS_S)
    for ratio, low, high in (
        (np.exp(log_50.mean(axis=0)) / median_g, 0.90, 1.10),
        (log_50.std(axis=0, ddof=1) / sigma, 0.80, 1.15),
        (np.exp((log_100 - log_50).mean(axis=0)), 1.15, 1.35),
    ):
        assert np.all((ratio > low) & (ratio < high))
    correlations = [np.corrcoef(each.accel_1_mps2, each.accel_2_mps2)[0, 1] for each in motions]
    assert abs(np.mean(correlations)) < 0.05


@pytest.mark.parametrize(("scenario", "published_g"), MEDIANS_G, ids=["no pulse", "pulse"])
def test_uncalibrated_medians_are_those_of_another_implementation(scenario, published_g):
    """Section 3.3 of the motions page, medians of 200 and 100 motions of a prototype. Three
    standard errors of a median of 60 with a dispersion of 0.6: 23 %."""
    scenario, rng = Scenario(**scenario, vs30_mps=400.0), np.random.default_rng(1)
    ln_psa = []
    for _ in range(60):
        parameters = synthesis.draw_parameters(scenario, rng)
        a_1_g, a_2_g, start_s = synthesis.simulate_background(parameters, scenario, rng, DT_S)
        if parameters.pulse:
            time_s = np.arange(a_1_g.size) * DT_S - start_s
            a_1_g = a_1_g + synthesis.pulse_acceleration(parameters.pulse, time_s)
        ln_psa.append(np.log(pair_psa(a_1_g, a_2_g, DT_S, TEST_PERIODS_S).rotd50_mps2))
    np.testing.assert_allclose(np.exp(np.mean(ln_psa, axis=0)), published_g, rtol=0.23)
