"""Invariants of the fits over generated data."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fragility_tables import verdict_of
from skewbridge.fragility.old_joint.probit import separated
from skewbridge.fragility.old_likelihood.bootstrap import refit_exceedance, refit_lines
from skewbridge.fragility.old_likelihood.censored import CensoredKernel
from skewbridge.fragility.old_likelihood.existence import batch_exists, binomial_status
from skewbridge.fragility.old_likelihood.intervals import curve, curve_band
from skewbridge.fragility.old_likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.methods.cloud import fit_cloud
from skewbridge.fragility.methods.ida import fit_brackets, fit_capacities
from skewbridge.fragility.methods.ordered import OrderedKernel
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.methods.tobit import censored_cloud, fit_tobit, refit_tobit

LEVELS = np.array([0.1, 0.2, 0.35, 0.5, 0.8, 1.2])


@st.composite
def stripes(draw):
    n = np.array(draw(st.lists(st.integers(1, 25), min_size=6, max_size=6)), dtype=float)
    k = np.array([draw(st.integers(0, int(m))) for m in n], dtype=float)
    return n, k


@given(stripes())
@settings(max_examples=80, deadline=None)
def test_status_says_whether_an_estimate_exists(data):
    n, k = data
    status = binomial_status(np.log(LEVELS), n, k)
    design = np.column_stack([np.ones(6), np.log(LEVELS)])
    rows = np.repeat(np.arange(6), n.astype(int))
    outcome = np.concatenate(
        [np.arange(int(m)) < int(c) for m, c in zip(n, k, strict=True)]
    ).astype(float)
    # the linear programme knows nothing of levels: independent code for the same question
    assert (status == "ok") == (not separated(design[rows], outcome))
    assert batch_exists(np.log(LEVELS), n[None], k[None])[0] == (status == "ok")


@given(stripes())
@settings(max_examples=80, deadline=None)
def test_interval_holds_the_estimate_and_ends_have_the_deviance(data):
    n, k = data
    fit = fit_stripes(LEVELS, n, k)
    assert (fit.status == "ok") == np.isfinite(fit.theta)
    assume(fit.status == "ok")
    assert fit.ci_theta[0] <= fit.theta <= fit.ci_theta[1]
    assert fit.ci_beta[0] <= fit.beta <= fit.ci_beta[1]
    x = np.log(LEVELS)
    target = fit.goodness.loglik_kernel - 0.5 * 3.841458820694124
    for end in fit.ci_theta:
        if 1e-12 < end < 1e12:
            kernel = BinomialKernel((x - np.log(end))[:, None], n, k)
            best = maximise(kernel, np.array([[1.0]]))
            assert best.loglik[0] == pytest.approx(target, abs=1e-6)
    for end in fit.ci_beta:
        if end < 1e12:
            kernel = BinomialKernel(np.ones((6, 1)), n, k, offset=x / end)
            best = maximise(kernel, np.array([[-np.log(fit.theta) / end]]))
            assert best.loglik[0] == pytest.approx(target, abs=1e-6)


@given(stripes(), st.floats(1e-3, 1e3), st.permutations(range(6)))
@settings(max_examples=60, deadline=None)
def test_unit_of_intensity_scales_theta_and_order_is_nothing(data, factor, order):
    n, k = data
    fit = fit_stripes(LEVELS, n, k)
    order = np.array(order)
    other = fit_stripes(LEVELS[order] * factor, n[order], k[order])
    assert other.status == fit.status
    assume(fit.status == "ok" and fit.beta < 20)
    assert other.theta == pytest.approx(fit.theta * factor, rel=1e-6)
    assert other.beta == pytest.approx(fit.beta, rel=1e-6)
    assert other.ci_beta == pytest.approx(fit.ci_beta, rel=1e-5)


@given(stripes())
@settings(max_examples=40, deadline=None)
def test_single_runs_equal_their_stripes(data):
    n, k = data
    fit = fit_stripes(LEVELS, n, k)
    im = np.repeat(LEVELS, n.astype(int))
    runs = np.concatenate([np.arange(int(m)) < int(c) for m, c in zip(n, k, strict=True)])
    single = fit_stripes(im, np.ones(im.size), runs.astype(float))
    assert single.status == fit.status
    if fit.status == "ok":
        assert single.theta == pytest.approx(fit.theta, rel=1e-6)
        assert single.goodness.loglik_kernel == pytest.approx(fit.goodness.loglik_kernel)


@given(st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_a_batch_of_refits_equals_single_fits(seed):
    rng = np.random.default_rng(seed)
    n = rng.integers(1, 20, (5, 6)).astype(float)
    k = np.floor(n * rng.random((5, 6)) * 1.2).clip(0, n)
    batch = refit_exceedance(np.log(LEVELS), n, k)
    for row in range(5):
        fit = fit_stripes(LEVELS, n[row], k[row], interval=False)
        if fit.status == "ok":
            assert batch.theta[row] == pytest.approx(fit.theta, rel=1e-6)
            assert batch.beta[row] == pytest.approx(fit.beta, rel=1e-6)


@given(st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_weighted_lines_equal_the_line_of_the_repeated_runs(seed):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-2, 0.5, 12)
    y = -3 + 1.1 * x + 0.3 * rng.normal(size=12)
    weights = rng.integers(0, 4, (1, 12)).astype(float)
    rows = np.repeat(np.arange(12), weights[0].astype(int))
    assume(np.unique(rows).size > 3)
    found = refit_lines(x, y, weights, np.log(0.04))
    fit = fit_cloud(np.exp(x[rows]), np.exp(y[rows]), 0.04)
    if fit.status == "ok":
        assert found.theta[0] == pytest.approx(fit.theta, rel=1e-7)
        assert found.beta[0] == pytest.approx(fit.beta, rel=1e-6)


@given(st.integers(0, 10**6), st.floats(0.5, 2.0))
@settings(max_examples=30, deadline=None)
def test_narrow_brackets_approach_the_exact_capacities(seed, theta):
    rng = np.random.default_rng(seed)
    capacity = theta * np.exp(0.4 * rng.normal(size=15))
    exact = fit_capacities(capacity)
    near = fit_brackets(capacity * (1 - 1e-4), capacity * (1 + 1e-4))
    assert near.theta == pytest.approx(exact.theta, rel=1e-5)
    assert near.beta == pytest.approx(exact.beta, rel=1e-4)


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_tobit_without_censoring_is_the_line_by_likelihood(seed):
    rng = np.random.default_rng(seed)
    im = np.exp(rng.uniform(-2, 0.5, 25))
    edp = 0.03 * im * np.exp(0.35 * rng.normal(size=25))
    tobit, line = fit_tobit(im, edp, 0.02), fit_cloud(im, edp, 0.02)
    assert tobit.theta == pytest.approx(line.theta, rel=1e-8)
    # n against n - 2 in the scatter
    assert tobit.beta == pytest.approx(line.beta * np.sqrt(23 / 25), rel=1e-8)
    assert tobit.line.sigma == pytest.approx(line.line.sigma * np.sqrt(23 / 25), rel=1e-8)
    assert (tobit.line.ln_a, tobit.line.b) == pytest.approx((line.line.ln_a, line.line.b), rel=1e-6)


@given(st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_weighted_tobit_equals_tobit_of_the_repeated_runs(seed):
    rng = np.random.default_rng(seed)
    im = np.exp(rng.uniform(-2, 0.5, 20))
    edp = 0.03 * im * np.exp(0.35 * rng.normal(size=20))
    censored = rng.random(20) < 0.2
    weights = rng.integers(0, 3, (1, 20)).astype(float)
    rows = np.repeat(np.arange(20), weights[0].astype(int))
    upper = np.where(censored, np.inf, edp)
    single = fit_tobit(im[rows], edp[rows], 0.02, upper[rows], interval=False)
    assume(single.status == "ok")
    batch = refit_tobit(im, edp, 0.02, upper, weights)
    assert batch.theta[0] == pytest.approx(single.theta, rel=1e-6)
    assert batch.beta[0] == pytest.approx(single.beta, rel=1e-6)


@given(st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_tobit_interval_holds_the_estimate(seed):
    rng = np.random.default_rng(seed)
    im = np.exp(rng.uniform(-2, 0.5, 20))
    edp = 0.03 * im * np.exp(0.35 * rng.normal(size=20))
    x, demand, upper = censored_cloud(im, edp, above=0.03)
    fit = fit_tobit(x, demand, 0.02, upper)
    assume(fit.status == "ok")
    assert fit.ci_theta[0] < fit.theta < fit.ci_theta[1]
    assert fit.ci_beta[0] < fit.beta < fit.ci_beta[1]


@pytest.mark.parametrize("link", ["probit", "logit", "cloglog"])
@given(a0=st.floats(-3, 3), a1=st.floats(0.2, 4))
@settings(max_examples=25, deadline=None)
def test_binomial_derivatives_are_those_of_the_log_likelihood(link, a0, a1):
    x = np.log(LEVELS)
    n, k = np.full(6, 20.0), np.array([0, 2, 5, 9, 15, 20.0])
    kernel = BinomialKernel(np.column_stack([np.ones(6), x]), n, k, link)
    _check_derivatives(kernel, np.array([a0, a1]))


@given(st.floats(-2, 2), st.floats(0.3, 3))
@settings(max_examples=25, deadline=None)
def test_censored_derivatives_are_those_of_the_log_likelihood(delta, h):
    lower = np.array([0.1, -0.5, -np.inf, 0.3, 0.2])
    upper = np.array([0.1, 0.4, 0.2, np.inf, 0.2])
    kernel = CensoredKernel(-np.ones((5, 1)), lower, upper)
    _check_derivatives(kernel, np.array([delta, h]))


@given(st.floats(0.5, 2), st.floats(0.2, 3))
@settings(max_examples=25, deadline=None)
def test_ordered_derivatives_are_those_of_the_log_likelihood(gap, slope):
    counts = np.array([[18, 2, 0], [14, 5, 1], [9, 8, 3], [5, 8, 7], [3, 6, 11], [1, 4, 15.0]])
    kernel = OrderedKernel(np.log(LEVELS), counts)
    _check_derivatives(kernel, np.array([0.7, 0.7 - gap, slope]))


def _check_derivatives(kernel, params):
    at = kernel.derivatives(params[None])
    step = 1e-5
    for j in range(params.size):
        move = np.zeros(params.size)
        move[j] = step
        up, down = (
            kernel.derivatives((params + move)[None]),
            kernel.derivatives((params - move)[None]),
        )
        # central differences: relative error about 1e-8 of the largest term
        slope = (up.loglik[0] - down.loglik[0]) / (2 * step)
        assert at.score[0, j] == pytest.approx(slope, rel=1e-5, abs=1e-5)
        bend = (up.score[0] - down.score[0]) / (2 * step)
        assert at.hessian[0, j] == pytest.approx(bend, rel=1e-5, abs=1e-4)


@given(st.floats(0.1, 3), st.floats(0.1, 1.5), st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_band_holds_the_curve_and_stays_within_probability(theta, beta, seed):
    root = np.random.default_rng(seed).normal(size=(2, 2)) * 0.2
    im = np.geomspace(0.05, 5, 30)
    low, high = curve_band(im, theta=theta, beta=beta, covariance=root @ root.T)
    p = curve(im, theta, beta)
    assert np.all((low >= 0) & (low <= p + 1e-15) & (p <= high + 1e-15) & (high <= 1))


@given(st.floats(0.5, 1.5), st.floats(0.0, 0.5))
@settings(max_examples=60, deadline=None)
def test_a_wider_interval_never_decides_more(middle, reach):
    narrow = verdict_of(middle - reach, middle + reach)
    wide = verdict_of(middle - 2 * reach, middle + 2 * reach)
    weaker = {"undecided", "detectable"} if narrow in {"lower", "higher"} else {"undecided"}
    assert wide == narrow or wide in weaker
