"""Intervals, doubts and defaults against closed forms and plain numerical derivatives."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from skewbridge.contact.law import ContactLaw
from skewbridge.fragility.old_joint.by_motion import MotionSums
from skewbridge.fragility.old_likelihood.bootstrap import refit_exceedance, refit_lines, student_reach
from skewbridge.fragility.old_likelihood.existence import clopper_pearson, firth
from skewbridge.fragility.old_likelihood.parts import LineFit
from skewbridge.fragility.methods.cloud import line_warnings
from skewbridge.fragility.methods.goodness import lilliefors
from skewbridge.fragility.methods.ida import fit_capacities
from skewbridge.fragility.methods.ordered import fit_ordered
from skewbridge.fragility.methods.system import JointDemand, replicate_medians
from skewbridge.fragility.methods.tobit import fit_tobit
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


def test_a_replicate_of_motions_is_the_line_of_the_repeated_motions():
    rng = np.random.default_rng(8)
    x = np.column_stack([np.ones(9), rng.normal(size=9)])
    y = x @ [0.4, 1.3] + 0.5 * rng.normal(size=9)
    params = np.linalg.lstsq(x, y)[0]
    residual = y - x @ params
    products = x[:, :, None] * x[:, None, :]
    sums = MotionSums(
        params=params,
        score=x * residual[:, None],
        information=products,
        squares=residual**2,
        slopes=x * residual[:, None],
        products=products,
    )
    drawn = np.array([0, 2, 1, 3, 0, 1, 1, 1, 0])
    line, scatter = sums.reweighted(drawn[None, :].astype(float))
    rows = np.repeat(np.arange(9), drawn)
    expected, squares, *_ = np.linalg.lstsq(x[rows], y[rows])
    assert line[0] == pytest.approx(expected)
    assert scatter[0] == pytest.approx(squares[0] / (9 - 2))


@pytest.mark.parametrize("motions", [5, 20])
def test_the_reach_of_normal_replicates_is_that_of_a_line_through_the_motions(motions):
    """Replicates of unit scatter: Student's t(m - 2), times sqrt[m/(m - 2)]."""
    values = stats.norm.ppf((np.arange(20000) + 0.5) / 20000)
    expected = stats.t.ppf(0.95, motions - 2) * np.sqrt(motions / (motions - 2))
    assert student_reach(values, motions, 0.9) == pytest.approx(expected, rel=1e-3)


def test_a_replicate_without_a_slope_has_no_median():
    """Demands of 1 throughout: no intensity brings another one."""
    x, weights = np.array([-1.0, 0.0, 2.0, 3.0]), np.ones((1, 4))
    found = refit_lines(x, np.zeros(4), weights, np.log(2.0))
    assert (found.separated, found.theta[0], found.beta[0]) == (1.0, np.inf, np.inf)


def test_a_single_component_is_its_own_system():
    """Lognormal curves are straight on the scale of the probit: nothing is lost in reading them."""
    theta, beta = np.array([[0.5], [0.55], [0.46]]), np.array([[0.40], [0.44], [0.37]])
    joint = JointDemand(theta=theta, beta=beta, correlation=np.ones((3, 1, 1)))
    found = replicate_medians(joint, 0.5, 0.4)
    assert np.exp(found[0]) == pytest.approx(theta[:, 0])
    assert found[1] == pytest.approx(beta[:, 0])


@pytest.mark.parametrize(("p_value", "is_told"), [(0.045, True), (0.055, False)])
def test_a_line_is_doubted_at_the_5_percent_level(p_value, is_told):
    told = line_warnings(LineFit(curvature_p=p_value, curvature=-0.1, scatter_p=p_value))
    assert told == (["saturating", "heteroscedastic"] if is_told else [])


def test_firth_keeps_away_from_curves_so_steep_that_no_information_is_left():
    x = np.array([-0.37, -0.31, -0.16, 0.08, 0.14, 0.36])
    n = np.full(6, 1000.0)
    a0, a1 = firth(x, n, np.where(x > 0.0, n, 0.0))
    assert -0.16 < -a0 / a1 < 0.08
    assert 0.0 < a1 < 100.0


def test_demands_observed_at_one_intensity_have_no_slope():
    edp = [0.01, 0.02, 0.03, 0.02, 0.05, 0.05]
    upper = [*edp[:4], np.inf, np.inf]
    alone = [0.3, 0.3, 0.3, 0.3, 0.6, 0.9]
    assert fit_tobit(alone, edp, 0.03, upper).status == "too_few_runs"
    assert fit_tobit(alone[:4], edp[:4], 0.03).status == "single_level"
    apart = np.exp([0.0, 0.5, 1.0])
    assert fit_tobit(apart, [0.01, 0.02, 0.03], 0.03).status == "ok"


def test_a_replicate_without_an_estimate_leaves_the_others_theirs():
    ln_im, n = np.log([0.2, 0.4, 0.8]), np.full((2, 3), 10.0)
    k = np.array([[1.0, 5.0, 9.0], [0.0, 0.0, 10.0]])  # the second jumps between 0.4 and 0.8
    found = refit_exceedance(ln_im, n, k)
    assert (found.theta[0], found.separated) == (pytest.approx(0.4), 0.5)
    assert found.beta[0] == pytest.approx(np.log(2.0) / stats.norm.ppf(0.9), rel=1e-6)
    assert found.beta[1] == 0.0
