"""Single models: degenerate data, intervals, bootstrap, goodness, frequency content."""

import numpy as np
import pytest

from skewbridge.errors import InputError
from skewbridge.fragility.exchange import risk
from skewbridge.fragility.old_likelihood import existence, profile
from skewbridge.fragility.old_likelihood.bootstrap import record_weights, refit_exceedance, refit_lines
from skewbridge.fragility.old_likelihood.fit import FragilityFit
from skewbridge.fragility.old_likelihood.intervals import percentile_interval
from skewbridge.fragility.old_likelihood.links import probability
from skewbridge.fragility.old_likelihood.newton import BinomialKernel, Restricted, maximise
from skewbridge.fragility.old_likelihood.profile import (
    _bracketed_end,
    chi_square_quantile,
    profile_ends,
)
from skewbridge.fragility.methods import goodness, system
from skewbridge.fragility.methods.ida import brackets_of_runs, fit_brackets, fit_capacities
from skewbridge.fragility.methods.ordered import crossing, fit_ordered
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.report.run_figures import fourier_ratio, mean_period_s


@pytest.mark.parametrize(
    ("k", "status"),
    [
        ([0, 0, 0, 0], "no_exceedance"),
        ([20, 20, 20, 20], "all_exceed"),
        ([0, 0, 20, 20], "complete_separation"),
        ([0, 7, 20, 20], "quasi_separation"),
        ([20, 20, 0, 0], "non_increasing"),
        ([20, 9, 0, 0], "non_increasing"),
        ([15, 12, 9, 3], "non_increasing"),
        ([10, 10, 10, 10], "non_increasing"),
        ([0, 3, 12, 20], "ok"),
        ([0, 0, 1, 0], "ok"),
    ],
)
def test_every_kind_of_stripes_has_its_status(k, status):
    fit = fit_stripes([0.2, 0.4, 0.6, 0.8], [20] * 4, k)
    assert fit.status == status
    assert np.isnan(fit.theta) == (status != "ok")


def test_quasi_separation_gives_the_firth_estimate_under_its_name():
    fit = fit_stripes([0.3, 0.5, 0.8], [20] * 3, [0, 7, 20])
    assert fit.separation.firth == pytest.approx({"theta": 0.53463, "beta": 0.19540}, abs=1e-5)
    assert fit.separation.theta_interval == pytest.approx((0.5, 0.5))


def test_firth_of_two_levels_is_the_closed_form():
    # with two levels the fit is saturated: the penalised counts are (k + c)/(n + 2c) at both
    a0, a1 = existence.firth(np.log([0.3, 0.6]), np.array([10.0, 10]), np.array([0.0, 10]))
    assert np.exp(-a0 / a1) == pytest.approx(0.424264, abs=1e-5)
    assert 1 / a1 == pytest.approx(0.188502, abs=1e-5)


def test_stripes_without_runs_are_dropped_with_a_warning():
    fit = fit_stripes([0.2, 0.5, 0.8, 1.1], [0, 20, 20, 20], [0, 7, 12, 17])
    assert fit.warnings[0] == "stripes_without_runs"
    assert fit.n_runs == 60


def test_fractional_counts_give_an_estimate_without_interval():
    fit = fit_stripes([0.2, 0.4, 0.6, 0.8], [20] * 4, [0.4, 4.2, 11.7, 17.3])
    assert fit.status == "ok"
    assert fit.ci_method == ""
    assert "fractional_counts_no_interval" in fit.warnings


def test_every_link_has_its_median_at_one_half():
    for link in ("probit", "logit", "cloglog"):
        fit = fit_stripes([0.2, 0.4, 0.6, 0.8, 1], [40] * 5, [2, 9, 19, 30, 36], link=link)
        # three shapes through the same data: close in the middle, not equal
        assert fit.theta == pytest.approx(0.58, abs=0.04)
        assert fit.beta == pytest.approx(0.53, abs=0.08)
        assert fit.ci_theta[0] < fit.theta < fit.ci_theta[1]


def test_bracketed_and_direct_ends_of_the_profile_agree():
    x = np.log([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
    design = np.column_stack([np.ones(8), x])
    k = np.array([0, 1, 3, 6, 10, 14, 17, 19.0])
    kernel = BinomialKernel(design, np.full(8, 20.0), k)
    best = maximise(kernel, np.zeros((1, 2)))
    ends = profile_ends(kernel, best, chi_square_quantile(0.95), 0.0)
    target = float(best.loglik[0]) - 0.5 * 3.841458820694124
    slow = [_bracketed_end(kernel, best, target, index) for index in range(4)]
    assert [*ends.ln_theta, *ends.slope] == pytest.approx(slow, rel=1e-9)


def test_long_intervals_need_no_search(monkeypatch: pytest.MonkeyPatch):
    """With few exceedances theta may be a thousand times larger; Newton still finds that end."""
    slow = profile._bracketed_end
    searched: list[int] = []
    monkeypatch.setattr(profile, "_bracketed_end", lambda *args: searched.append(args[3]))
    ln_im = np.log(np.geomspace(0.1, 1.5, 30))
    design = np.column_stack([np.ones(30), ln_im])
    long = 0
    for seed in range(20):
        noise = 0.6 * np.random.default_rng(seed).normal(size=30)
        kernel = BinomialKernel(design, np.ones(30), (ln_im + noise > 0.1).astype(float))
        best = maximise(kernel, np.zeros((1, 2)))
        level = Restricted(kernel, np.zeros(2), np.eye(2)[:1])
        flat = float(maximise(level, np.zeros((1, 1))).params[0, 0])
        ends = profile_ends(kernel, best, chi_square_quantile(0.95), flat)
        target = float(best.loglik[0]) - 0.5 * chi_square_quantile(0.95)
        if 5.0 < ends.ln_theta[1] < np.inf:
            long += 1
            assert ends.ln_theta[1] == pytest.approx(slow(kernel, best, target, 1), rel=1e-9)
    assert long >= 5
    assert 1 not in searched


def test_capacities_with_no_information_get_their_status():
    assert fit_capacities([1.0, 1.0, 0.9], [0, 0, 1]).status == "unbounded_likelihood"
    assert fit_capacities([1.0, 1.0, 1.4], [0, 0, 1]).status == "ok"
    assert fit_brackets([0.4, 0.4], [0.7, 0.7]).status == "complete_separation"
    assert fit_brackets([0.4, 0.7], [0.7, 1.0]).status == "quasi_separation"
    assert fit_brackets([0.0, 0.0], [0.7, 1.0]).status == "all_exceed"
    assert fit_brackets([0.7, 1.0], [None, None]).status == "all_censored"
    assert fit_brackets([0.0, 1.2], [0.7, None]).status == "non_increasing"


def test_brackets_take_the_first_crossing_and_count_resurrections():
    im = np.array([0.2, 0.4, 0.6, 0.2, 0.4, 0.6, 0.2, 0.4, 0.6])
    hit = np.array([0, 1, 0, 0, 0, 0, 1, 1, 1.0])
    lower, upper, odd = brackets_of_runs(im, hit, np.repeat([0, 1, 2], 3))
    assert list(lower) == [0.2, 0.6, 0.0]
    assert list(upper) == [0.4, np.inf, 0.2]
    assert odd == 1


def test_exact_intervals_accompany_complete_capacities():
    fit = fit_capacities([0.9, 1.3, 1.1, 1.8, 0.7, 1.5, 1.2, 2.2])
    low, high = fit.exact.ci_theta_exact
    assert low < fit.ci_theta[0] < fit.theta < fit.ci_theta[1] < high


def test_ordered_fits_never_cross_and_free_fits_are_checked():
    theta, beta = np.array([0.3, 0.5]), np.array([0.3, 0.6])
    found = crossing(theta, beta, 0.01, 5.0)
    assert len(found) == 1
    assert found[0][2] == pytest.approx(0.18, abs=0.005)
    assert crossing(theta, np.array([0.4, 0.4]), 0.01, 5.0) == []
    assert fit_ordered([0.2, 0.4], [[5, 0, 0], [0, 0, 5]]).status == "empty_state"


def test_bootstrap_p_value_of_a_good_fit_is_not_small():
    im, n, k = [0.2, 0.4, 0.6, 0.8, 1.0], np.full(5, 20.0), [1, 5, 11, 15, 18]
    fit = fit_stripes(im, n, k)
    params = np.array([fit.predictor.a0, fit.predictor.a1])
    fitted = goodness.ProbitStripes(ln_im=np.log(im), n=n, params=params, replicates=99)
    assert goodness.deviance_p_value(fitted, fit.goodness.deviance) > 0.2
    kernel = fit.goodness.loglik_kernel
    _, isotonic = goodness.isotonic_p_value(fitted, np.array(k, float), kernel)
    assert isotonic > 0.2


def test_lack_of_fit_is_seen():
    im, n, k = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2], np.full(6, 200.0), [2, 90, 95, 100, 110, 198]
    fit = fit_stripes(im, n, k)
    params = np.array([fit.predictor.a0, fit.predictor.a1])
    fitted = goodness.ProbitStripes(ln_im=np.log(im), n=n, params=params, replicates=99)
    _, p = goodness.isotonic_p_value(fitted, np.array(k, float), fit.goodness.loglik_kernel)
    assert p <= 0.02


def test_record_bootstrap_draws_all_runs_of_a_motion_together():
    weights = record_weights(np.array([0, 0, 1, 2, 2]), 50, np.random.default_rng(0))
    assert np.all(weights[:, 0] == weights[:, 1])
    assert np.all(weights[:, 3] == weights[:, 4])
    assert np.all(weights[:, 0] + weights[:, 2] + weights[:, 3] == 3)


def test_separated_replicates_are_kept_as_limits():
    x = np.log([0.2, 0.4, 0.6])
    n = np.full((3, 3), 5.0)
    found = refit_exceedance(x, n, np.array([[0, 0, 5.0], [0, 0, 0], [1, 2, 4]]))
    assert found.theta[0] == pytest.approx(np.sqrt(0.24))
    assert found.beta[0] == 0.0
    assert found.theta[1] == np.inf
    assert found.separated == pytest.approx(2 / 3)
    assert percentile_interval(found.theta, 0.95)[1] == np.inf


def test_system_bounds_hold_and_shares_name_the_weak_component():
    rng = np.random.default_rng(2)
    im = np.exp(rng.uniform(-2, 0.4, 80))
    common = rng.normal(size=80)
    demand = np.column_stack(
        [im * np.exp(0.3 * common), 0.4 * im * np.exp(0.2 * common + 0.2 * rng.normal(size=80))]
    )
    x, y, once = np.log(im), np.log(demand), np.ones((1, 80))
    lines = [refit_lines(x, y[:, i], once, np.log(0.5)) for i in range(2)]
    correlation = system.residual_correlation(x, y, once)
    joint = system.joint_demand(lines, [0.35, 0.35], correlation).first
    # residual correlation, not that of ln D, which the common trend would bring near 1
    assert 0.2 < joint.correlation[0, 1] < 0.6
    im = np.geomspace(0.05, 3, 60)
    p = system.series_system(im, joint)
    parts = probability(np.log(im[:, None] / joint.theta) / joint.beta)
    assert np.all(np.max(parts, axis=1) <= p + 1e-12)
    assert np.all(p <= 1 - np.prod(1 - parts, axis=1) + 1e-12)
    share = system.contributions(im, joint)
    assert np.all(share[:, 0] > share[:, 1])
    theta, beta, worst = system.lognormal_of_system(im, p)
    assert theta < joint.theta.min()
    assert beta < 1
    assert worst < 0.05


@pytest.mark.parametrize("count", [3, 5, 9])
def test_equally_correlated_components_as_by_quadrature(count: int):
    """P(all Z_i <= h_i) = E prod Phi[(h_i - sqrt(r) T)/sqrt(1 - r)] for a common correlation r."""
    rho, theta = 0.6, np.linspace(0.6, 1.4, count)
    joint = system.JointDemand(
        theta=theta,
        beta=np.full(count, 0.4),
        correlation=np.full((count, count), rho) + (1 - rho) * np.eye(count),
    )
    im = np.array([0.3, 0.5, 0.7, 1.0])
    t, weights = np.polynomial.hermite_e.hermegauss(80)
    limit = -np.log(im[:, None] / theta) / 0.4
    below = probability((limit[..., None] - np.sqrt(rho) * t) / np.sqrt(1 - rho))
    expected = 1 - np.prod(below, axis=1) @ weights / np.sqrt(2 * np.pi)
    # three times the measured error of the lattice (docs/theory/fragility.md)
    assert system.series_system(im, joint) == pytest.approx(expected, abs=1e-5)


def test_equal_components_fail_together():
    joint = system.JointDemand(
        theta=np.full(3, 0.8), beta=np.full(3, 0.4), correlation=np.ones((3, 3))
    )
    im = np.array([0.4, 0.8, 1.2])
    alone = probability(np.log(im / 0.8) / 0.4)
    assert system.series_system(im, joint) == pytest.approx(alone, abs=1e-9)  # jitter of the factor


def test_frequency_outside_the_hazard_table_is_named():
    found = risk.annual_frequency(0.8, 0.4, [0.1, 1.0], [1e-2, 1e-4])
    assert found.above == 1e-4
    assert found.below < 1e-6
    with pytest.raises(InputError, match=r"im must increase \(row 1\)"):
        risk.annual_frequency(0.8, 0.4, [0.5, 0.3], [1e-2, 1e-3])


def test_mean_period_of_a_decaying_sine():
    t = np.arange(0, 30, 0.01)
    wave = np.sin(2 * np.pi * t / 0.8) * np.exp(-0.05 * t)
    assert mean_period_s(wave, 0.01) == pytest.approx(0.8, rel=0.05)
    with pytest.raises(InputError, match="constant"):
        mean_period_s(np.ones(100), 0.01)


def test_fourier_ratio_shows_a_removed_component():
    t = np.arange(0, 40, 0.01)
    slow, fast = np.sin(2 * np.pi * t / 2.0), np.sin(2 * np.pi * t / 0.5)
    ratio = fourier_ratio(slow + 0.5 * fast, slow + fast, 0.01, np.array([0.5, 2.0]))
    assert ratio == pytest.approx([1.0, 0.5], rel=0.03)


def test_json_of_a_fit_has_the_keys_of_the_contract():
    keys = (
        "status theta beta se_ln_theta se_beta cov_ln_theta_beta ci_theta ci_beta loglik n_runs "
        "warnings"
    )
    assert set(keys.split()) <= set(FragilityFit(method="x", status="ok").as_json())


def test_bounds_of_separated_data_hold_the_bracket_and_match_the_likelihood():
    im = np.array([0.2, 0.3, 0.5, 0.7, 0.9])
    fit = fit_stripes(im, np.ones(5), [0, 0, 0, 1, 1])
    low, high = fit.separation.theta_bounds_given_beta["0.4"]
    assert fit.separation.theta_interval == pytest.approx((0.5, 0.7))
    assert low < 0.5 < 0.7 < high

    def loglik(theta):
        p = probability(np.log(im / theta) / 0.4)
        return np.sum(np.log(np.where(im > 0.6, p, 1 - p)))

    best = max(loglik(theta) for theta in np.geomspace(0.3, 1.2, 2000))
    for end in (low, high):
        assert 2 * (best - loglik(end)) == pytest.approx(1.6449**2, rel=1e-3)


def test_deviance_of_single_runs_has_no_p_value_and_a_curved_predictor_is_seen():
    rng = np.random.default_rng(5)
    x = np.sort(rng.uniform(-2, 1, 3000))
    k = (rng.uniform(size=3000) < probability(1.5 * x)).astype(float)
    single = fit_stripes(np.exp(x), np.ones(3000), k).goodness
    assert single.deviance_p is None
    assert single.link_p > 0.01
    k = (rng.uniform(size=3000) < probability(1.5 * x + 0.8 * x**2)).astype(float)
    assert fit_stripes(np.exp(x), np.ones(3000), k).goodness.link_p < 1e-6
    grouped = fit_stripes([0.2, 0.4, 0.6, 0.8], [20] * 4, [0, 4, 12, 18]).goodness
    assert 0 < grouped.deviance_p < 1
