"""Single models: degenerate data, intervals, bootstrap, goodness, frequency content."""

import numpy as np
import pytest
from scipy import stats

from skewbridge.errors import InputError
from skewbridge.fragility.exchange import risk
from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_exceedance, refit_lines
from skewbridge.fragility.likelihood.fit import FragilityFit
from skewbridge.fragility.likelihood.intervals import percentile_interval
from skewbridge.fragility.likelihood.links import probability
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.likelihood.profile import (
    _bracketed_end,
    chi_square_quantile,
    profile_ends,
)
from skewbridge.fragility.methods import goodness, system
from skewbridge.fragility.methods.cloud import fit_cloud
from skewbridge.fragility.methods.cloud_models import fit_heteroscedastic, fit_modified_cloud
from skewbridge.fragility.methods.ida import brackets_of_runs, fit_brackets, fit_capacities
from skewbridge.fragility.methods.ordered import crossing, fit_ordered
from skewbridge.fragility.methods.plateau import fit_plateau
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.methods.tobit import fit_tobit
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.frequency_content import fourier_ratio, mean_period_s
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Runs, outcomes_of
from skewbridge.fragility.tables.variant_exceedance import fit_uncertain_capacity


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


def test_flat_and_falling_clouds_are_refused():
    rng = np.random.default_rng(1)
    im = np.exp(rng.uniform(-2, 0, 12))
    noise = np.exp(rng.normal(size=12))
    assert fit_cloud(im, 0.02 * noise, 0.03).status in {"slope_not_significant", "non_increasing"}
    assert fit_cloud([0.3, 0.3, 0.3], [0.01, 0.02, 0.03], 0.02).status == "single_level"
    assert fit_cloud([0.3, 0.4], [0.01, 0.02], 0.02).status == "too_few_runs"
    assert fit_cloud(im, 0.02 * im, 0.01).status == "zero_dispersion"


def test_censoring_removes_the_bias_that_clipping_makes():
    rng = np.random.default_rng(4)
    im = np.exp(rng.uniform(-2.3, 0.4, 400))
    edp = 0.03 * im * np.exp(0.4 * rng.normal(size=400))
    limit = 0.02
    clipped = fit_cloud(im, np.minimum(edp, limit), 0.015)
    censored = fit_tobit(im, np.minimum(edp, limit), 0.015, np.where(edp < limit, edp, np.inf))
    assert censored.ci_theta[0] < 0.5 < censored.ci_theta[1]
    assert censored.ci_beta[0] < 0.4 < censored.ci_beta[1]
    assert clipped.line.b < 0.8 < censored.line.b


def test_few_collapses_are_separated_and_say_so():
    im = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    edp = [0.01, 0.021, 0.029, 0.042, 0.05, None]
    fit = fit_modified_cloud(im, edp, 0.03, [0, 0, 0, 0, 0, 1])
    assert fit.status == "complete_separation"
    assert fit.collapse.part == "collapse"


def test_beta_is_as_uncertain_as_slope_and_scatter_are():
    """beta = s/b of independent s and b: var beta / beta^2 = 1/[2(n - 2)] + var b / b^2."""
    rng = np.random.default_rng(3)
    im = np.exp(np.linspace(-4.0, 0.5, 60))
    edp = 0.03 * im**1.5 * np.exp(0.3 * rng.normal(size=60))
    # collapses at the strong end only, where they change nothing around the median
    collapse = np.isin(np.arange(60), [50, 53, 55, 57, 59]).astype(float)
    calm = collapse == 0.0
    line = stats.linregress(np.log(im[calm]), np.log(edp[calm]))
    relative = 1.0 / (2.0 * (55 - 2)) + (line.stderr / line.slope) ** 2
    threshold = 0.03 * np.exp(-4.5)
    fit = fit_cloud(im[calm], edp[calm], threshold)
    assert fit.var_beta / fit.beta**2 == pytest.approx(relative, rel=1e-6)
    joined = fit_modified_cloud(im, edp, threshold, collapse)
    assert joined.var_beta / joined.beta**2 == pytest.approx(relative, rel=1e-3)
    assert joined.var_ln_theta == pytest.approx(fit.var_ln_theta, rel=1e-3)


def test_scatter_that_vanishes_at_one_end_has_no_maximum():
    im = np.exp(np.linspace(-2, 0.4, 12))
    noise = np.array([0, 0, 0, 0, 0, 0, 0, 0.01, -0.1, 0.3, -0.6, 0.9])
    fit = fit_heteroscedastic(im, 0.03 * im * np.exp(noise), 0.015)
    assert fit.status == "unbounded_likelihood"
    assert fit_heteroscedastic(im[:5], im[:5], 0.2).status == "too_few_runs"


def test_constant_scatter_is_not_called_heteroscedastic():
    rng = np.random.default_rng(6)
    im = np.exp(rng.uniform(-2.3, 0.4, 200))
    edp = 0.03 * im * np.exp(0.4 * rng.normal(size=200))
    fit = fit_heteroscedastic(im, edp, 0.015)
    assert fit.scatter.lr_p > 0.01
    assert fit.theta == pytest.approx(0.5, rel=0.1)
    plain = fit_cloud(im, edp, 0.015)
    assert fit.var_ln_theta == pytest.approx(plain.var_ln_theta, rel=0.1)


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


def test_equal_components_fail_together():
    joint = system.JointDemand(
        theta=np.full(3, 0.8), beta=np.full(3, 0.4), correlation=np.ones((3, 3))
    )
    im = np.array([0.4, 0.8, 1.2])
    alone = probability(np.log(im / 0.8) / 0.4)
    assert system.series_system(im, joint) == pytest.approx(alone, abs=2e-4)  # jitter of the factor


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


def runs_against(im, edp, capacity, dispersion):
    status = np.full(im.size, "ok")
    state = LimitState(
        component="c", name="s", demand="d_m", threshold=capacity, dispersion=dispersion
    )
    beyond = np.zeros(im.size, dtype=bool)
    runs = Runs(im=im, status=status, beyond=beyond, records=np.arange(im.size))
    return runs, outcomes_of(edp, status, beyond, state), state


def test_uncertain_capacity_widens_the_curve_by_its_dispersion_over_the_slope():
    rng = np.random.default_rng(12)
    im = np.exp(rng.uniform(-2.5, 1.0, 1500))
    edp = 0.03 * im**1.2 * np.exp(0.35 * rng.normal(size=1500))
    fit = fit_uncertain_capacity(*runs_against(im, edp, 0.02, 0.4), FitSettings(bootstrap=199))
    assert fit.ci_method == "record_bootstrap"
    truth = (2 / 3) ** (1 / 1.2), np.hypot(0.35, 0.4) / 1.2
    assert fit.ci_theta[0] < truth[0] < fit.ci_theta[1]
    assert fit.ci_beta[0] < truth[1] < fit.ci_beta[1]
    plain = fit_uncertain_capacity(*runs_against(im, edp, 0.02, 0.0), FitSettings(bootstrap=99))
    assert plain.beta < fit.beta
    none = fit_uncertain_capacity(*runs_against(im, edp, 99.0, 0.0), FitSettings())
    assert none.status == "no_exceedance"


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


def test_a_line_without_censoring_has_the_same_interval_by_likelihood_as_by_student():
    rng = np.random.default_rng(3)
    im = np.exp(rng.uniform(-2, 0.5, 14))
    edp = 0.02 * im * np.exp(0.3 * rng.normal(size=14))
    assert fit_tobit(im, edp, 0.02).ci_theta == pytest.approx(
        fit_cloud(im, edp, 0.02).ci_theta, rel=1e-6
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_demand_that_a_hinge_limits_levels_off_and_a_straight_one_does_not(seed):
    rng = np.random.default_rng(seed)
    im = np.exp(np.linspace(-2.3, 0.3, 24))
    free = 0.9 * im**0.7 * np.exp(0.2 * rng.normal(size=24))
    limited = np.minimum(free, 0.5) * np.exp(0.03 * rng.normal(size=24))
    plateau = fit_plateau(im, limited)
    assert plateau.found
    assert plateau.level == pytest.approx(0.5, rel=0.04)
    assert plateau.top < 0.6
    assert not fit_plateau(im, free).found
