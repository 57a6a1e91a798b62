"""Intervals, doubts and defaults against closed forms and plain numerical derivatives."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from skewbridge.contact.law import ContactLaw
from skewbridge.fragility.likelihood.existence import clopper_pearson
from skewbridge.fragility.methods.goodness import lilliefors
from skewbridge.fragility.methods.ida import fit_capacities
from skewbridge.fragility.methods.ordered import fit_ordered
from skewbridge.fragility.settings import FitSettings
from skewbridge.motions.examine import doubts
from skewbridge.motions.formats.trace import Trace


@pytest.mark.parametrize("level", [0.8, 0.95])
def test_complete_capacities_have_the_intervals_of_a_normal_sample(level):
    capacity = np.array([0.9, 1.3, 1.1, 1.8, 0.7, 1.5])
    exact = fit_capacities(capacity, None, FitSettings(confidence=level)).exact
    y = np.log(capacity)
    mean = stats.t.interval(level, y.size - 1, y.mean(), stats.sem(y))
    assert exact.ci_theta_exact == pytest.approx(np.exp(mean))
    quantiles = stats.chi2.ppf([0.5 * (1 + level), 0.5 * (1 - level)], y.size - 1)
    assert exact.ci_beta_exact == pytest.approx(np.sqrt(5 * y.var(ddof=1) / quantiles))
    assert exact.beta_unbiased_n_minus_1 == pytest.approx(y.std(ddof=1))


def test_the_covariance_of_an_ordered_fit_is_the_inverse_of_its_curvature():
    im = np.array([0.1, 0.2, 0.4, 0.8, 1.6])
    counts = np.array([[9, 1, 0], [7, 2, 1], [4, 4, 2], [2, 3, 5], [0, 2, 8]])
    fit = fit_ordered(im, counts)
    at = np.append(np.log(fit.theta), fit.beta)

    def loglik(values: np.ndarray) -> float:
        above = stats.norm.cdf((np.log(im)[:, None] - values[:-1]) / values[-1])
        bounds = np.column_stack([np.ones(im.size), above, np.zeros(im.size)])
        return float(np.sum(counts * np.log(-np.diff(bounds, axis=1))))

    step = 1e-4
    curvature = np.empty((at.size, at.size))
    for i, j in product(range(at.size), repeat=2):
        ends = [
            a * b * loglik(at + step * (a * np.eye(at.size)[i] + b * np.eye(at.size)[j]))
            for a, b in product((-1, 1), repeat=2)
        ]
        curvature[i, j] = -sum(ends) / (4 * step**2)
    assert loglik(at) == pytest.approx(fit.loglik)
    np.testing.assert_allclose(fit.covariance, np.linalg.inv(curvature), rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize(("offset", "is_told"), [(0.03, True), (-0.03, True), (0.01, False)])
def test_an_offset_of_either_sign_is_told(offset, is_told):
    wave = np.tile([1.0, -1.0], 500)
    trace = Trace(
        path=Path("a.csv"), format="csv", accel_mps2=wave + offset, dt_s=0.01, unit="m/s2"
    )
    assert any("mean is" in doubt for doubt in doubts(trace)) is is_told


def test_a_contact_of_which_nothing_is_said_has_no_friction_no_cohesion_and_no_gap():
    law = ContactLaw(kn_n_per_m=1e9, kt_n_per_m=1e9)
    assert (law.friction, law.cohesion_n, law.gap_m, law.gap_closing_m) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_distance_from_a_normal_distribution_is_that_of_either_side(sign):
    """An exponential sample: its largest distance lies above on one side, below on the other."""
    values = sign * np.random.default_rng(2).exponential(size=25)
    scaled = (values - values.mean()) / values.std(ddof=1)
    assert lilliefors(values).distance == pytest.approx(stats.kstest(scaled, "norm").statistic)


@pytest.mark.parametrize(("k", "n"), [(1, 20), (7, 20), (19, 20), (2, 3)])
def test_limits_of_a_proportion_are_those_of_the_exact_binomial_test(k, n):
    low, high = clopper_pearson(np.array([float(k)]), np.array([float(n)]), 0.9)
    expected = stats.binomtest(k, n).proportion_ci(0.9, method="exact")
    assert (low[0], high[0]) == pytest.approx((expected.low, expected.high))
