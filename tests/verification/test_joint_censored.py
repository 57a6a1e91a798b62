"""The mixed model with censored demands against its likelihood by brute force."""

import numpy as np
import pytest
from scipy import special

from skewbridge.fragility.joint.mixed import MixedData, fit_mixed

MOTIONS, VARIANTS = 14, 5


def data(limit, seed=3):
    rng = np.random.default_rng(seed)
    motion = np.repeat(np.arange(MOTIONS), VARIANTS)
    ln_im = np.linspace(-2.0, 0.5, MOTIONS)[motion]
    axis = np.tile(np.arange(VARIANTS) / (VARIANTS - 1.0), MOTIONS)
    y = 1.05 * ln_im + 0.3 * axis + 0.3 * rng.normal(size=MOTIONS)[motion]
    y += 0.08 * rng.normal(size=y.size)
    design = np.column_stack([np.ones(y.size), ln_im, axis])
    seen = y < limit
    return MixedData(design=design, lower=np.minimum(y, limit), seen=seen, motion=motion)


def log_likelihood(runs, params, tau, sigma):
    """Sum over motions of the integral over the random effect on a grid without end."""
    u, step = np.linspace(-10.0 * tau, 10.0 * tau, 20001, retstep=True)
    total = 0.0
    for motion in range(MOTIONS):
        own = runs.motion == motion
        z = (runs.lower[own] - runs.design[own] @ params)[:, None] - u
        seen = runs.seen[own][:, None]
        density = -0.5 * (z / sigma) ** 2 - np.log(sigma) - 0.5 * np.log(2 * np.pi)
        terms = np.where(seen, density, special.log_ndtr(-z / sigma))
        whole = np.sum(terms, axis=0) - 0.5 * (u / tau) ** 2 - np.log(tau) - 0.5 * np.log(2 * np.pi)
        total += special.logsumexp(whole) + np.log(step)
    return total


@pytest.mark.parametrize("limit", [9.0, 0.1, -0.4])
def test_the_estimate_is_the_maximum_of_the_likelihood(limit):
    """9: nothing censored; -0.4: 40 % are, and of some motions every run."""
    runs = data(limit)
    fit = fit_mixed(runs)
    at = np.array([*fit.sums.params, np.log(fit.tau), np.log(fit.sigma)])

    def value(x):
        return log_likelihood(runs, x[:3], np.exp(x[3]), np.exp(x[4]))

    steps = 1e-4 * np.eye(5)
    curvature = np.array([value(at + h) - 2 * value(at) + value(at - h) for h in steps]) / 1e-8
    gradient = np.array([value(at + h) - value(at - h) for h in steps]) / 2e-4
    assert np.all(curvature < 0.0)
    # within a hundredth of a standard error of the maximum along every parameter
    assert np.all(np.abs(gradient) < 0.01 * np.sqrt(-curvature))
    information = np.sum(fit.sums.information, axis=0)
    assert np.diag(information) == pytest.approx(-curvature[:3], rel=0.02)
    assert np.sum(fit.sums.score, axis=0) == pytest.approx(0.0, abs=0.05)


def test_censored_demands_are_expected_above_their_value():
    runs = data(-0.4)
    fit = fit_mixed(runs)
    assert np.all(fit.expected[~runs.seen] > runs.lower[~runs.seen])
    assert fit.expected[runs.seen] == pytest.approx(runs.lower[runs.seen])
