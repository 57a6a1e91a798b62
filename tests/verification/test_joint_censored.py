"""Mixed model with censored demands: closed forms, and the likelihood by brute force."""

import numpy as np
import pytest
from scipy import special

from skewbridge.fragility.mixed import MixedData, fit_mixed, without_each_motion
from skewbridge.fragility.motion_means import jackknife_covariance

MOTIONS, VARIANTS = 14, 5


def data(high, low=-np.inf, seed=3):
    """Return runs of a known model, censored above ``high`` and below ``low``."""
    rng = np.random.default_rng(seed)
    motion = np.repeat(np.arange(MOTIONS), VARIANTS)
    ln_im = np.linspace(-2.0, 0.5, MOTIONS)[motion]
    axis = np.tile(np.arange(VARIANTS) / (VARIANTS - 1.0), MOTIONS)
    y = 1.05 * ln_im + 0.3 * axis + 0.3 * rng.normal(size=MOTIONS)[motion]
    y += 0.08 * rng.normal(size=y.size)
    design = np.column_stack([np.ones(y.size), ln_im, axis])
    lower = np.where(y < low, -np.inf, np.minimum(y, high))
    upper = np.where(y > high, np.inf, np.maximum(y, low))
    return MixedData(design=design, lower=lower, upper=upper, motion=motion)


def without(runs, motion):
    """Return the runs of all other motions."""
    kept, codes = runs.motion != motion, runs.motion - (runs.motion > motion)
    ends = {"lower": runs.lower[kept], "upper": runs.upper[kept]}
    return MixedData(design=runs.design[kept], motion=codes[kept], **ends)


def log_likelihood(runs, parameters):
    """Sum over motions of the integral over the random effect, on a fine grid."""
    delta, (tau, sigma) = parameters[:-2], np.exp(parameters[-2:])
    u, step = np.linspace(-10.0 * tau, 10.0 * tau, 8001, retstep=True)
    total = 0.0
    for motion in range(MOTIONS):
        own = runs.motion == motion
        fitted = (runs.design[own] @ delta)[:, None] + u
        lower, upper = runs.lower[own][:, None], runs.upper[own][:, None]
        z = (np.where(np.isinf(lower), upper, lower) - fitted) / sigma
        density = -0.5 * z**2 - np.log(sigma) - 0.5 * np.log(2 * np.pi)
        tail = special.log_ndtr(np.where(np.isinf(upper), -z, z))
        terms = np.sum(np.where(lower == upper, density, tail), axis=0)
        terms += -0.5 * (u / tau) ** 2 - np.log(tau) - 0.5 * np.log(2 * np.pi)
        total += special.logsumexp(terms) + np.log(step)
    return total


@pytest.mark.parametrize(
    ("high", "low"), [(9.0, -9.0), (0.1, -np.inf), (-0.4, -np.inf), (0.1, -1.5), (9.0, -1.2)]
)
def test_estimate_is_the_maximum_of_the_brute_force_likelihood(high, low):
    """In the third case, all runs of some motions are right-censored."""
    runs = data(high, low)
    fit = fit_mixed(runs)
    at, steps = fit.parameters, 1e-4 * np.eye(5)
    middle = log_likelihood(runs, at)
    assert np.sum(fit.logliks) == pytest.approx(middle, abs=1e-8)
    pairs = [(log_likelihood(runs, at + h), log_likelihood(runs, at - h)) for h in steps]
    gradient = np.array([up - down for up, down in pairs]) / 2e-4
    curvature = np.array([up - 2 * middle + down for up, down in pairs]) / 1e-8
    information = np.sum(fit.information, axis=0)
    assert np.diag(information) == pytest.approx(-curvature, rel=1e-3)
    # within 0.1 % of a standard error of the maximum
    assert np.all(np.abs(gradient) < 1e-3 * np.sqrt(-curvature))
    assert np.sum(fit.score, axis=0) == pytest.approx(0.0, abs=1e-5)
    # expected values are beyond the bounds of censored demands
    right, left = np.isinf(runs.upper), np.isinf(runs.lower)
    assert np.all(fit.expected[right] > runs.lower[right])
    assert np.all(fit.expected[left] < runs.upper[left])
    assert fit.expected[~(right | left)] == pytest.approx(runs.lower[~(right | left)])


def test_jackknife_equals_independent_fits_without_each_motion():
    runs = data(0.1, -1.5)
    quick = without_each_motion(runs, fit_mixed(runs))
    exact = np.stack([fit_mixed(without(runs, motion)).parameters for motion in range(MOTIONS)])
    errors = [np.sqrt(np.diag(jackknife_covariance(values))) for values in (quick, exact)]
    assert errors[0] == pytest.approx(errors[1], rel=1e-3)
    assert quick == pytest.approx(exact, abs=0.02 * np.min(errors[1]))
