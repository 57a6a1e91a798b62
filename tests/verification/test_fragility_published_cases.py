"""Published, classical and own cases of `tests/data/fragility_cases.json`, each with its source.

Tolerances are those of the cases: 1e-6 on estimates (they were confirmed with 50 digits), 1e-4 on
standard errors (some references differentiate numerically), 1e-5 on interval ends.
"""

import numpy as np
import pytest

from reference_data import fragility_case as case
from skewbridge.errors import InputError
from skewbridge.fragility.fits import fit_brackets, fit_capacities, fit_stripes
from skewbridge.fragility.lines import lilliefors

MSA = (
    "msa_wood_b1_existing",
    "msa_wood_b1_retrofit",
    "msa_wood_b2_retrofit",
    "msa_wood_b3_existing",
    "msa_wood_b4_retrofit",
    "msa_bliss_beetle_probit",
    "deg_stripe_with_n_zero",
)
CAPACITIES = (
    "ida_locomotive_right_censored",
    "ida_12_complete",
    "ida_12_censored_at_1p5",
    "ida_reliawiki_10",
)
BRACKETS = ("ida_interval_censored_R", "ida_same_records_on_stripes")


def ends(values):
    return [np.inf if value in ("inf", None) else value for value in values]


@pytest.mark.parametrize("name", MSA)
def test_stripes_reproduce_the_case(name):
    given, expected = case(name)
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == "ok"
    for key in ("theta", "beta"):
        assert getattr(fit, key) == pytest.approx(expected[key], rel=1e-6)
    for key in ("a0", "a1", "deviance", "pearson", "aic", "loglik_kernel"):
        assert fit.as_json()[key] == pytest.approx(expected[key], rel=1e-6)
    assert fit.loglik == pytest.approx(expected["loglik"], rel=1e-6)
    assert fit.se_ln_theta == pytest.approx(expected["se_ln_theta"], rel=1e-4)
    assert fit.se_beta == pytest.approx(expected["se_beta"], rel=1e-4)
    assert fit.cov_ln_theta_beta == pytest.approx(expected["cov_lntheta_beta"], rel=1e-4)
    assert fit.ci_theta == pytest.approx(ends(expected["profile95_theta"]), rel=1e-5)
    assert fit.ci_beta == pytest.approx(ends(expected["profile95_beta"]), rel=1e-5)
    assert set(expected.get("warnings", [])) <= set(fit.warnings)


@pytest.mark.parametrize("name", CAPACITIES)
def test_capacities_reproduce_the_case(name):
    given, expected = case(name)
    fit = fit_capacities(given["capacity"], given["right_censored"])
    assert fit.status == expected["status"]
    assert fit.theta == pytest.approx(expected["theta"], rel=1e-6)
    assert fit.beta == pytest.approx(expected["beta"], rel=1e-6)
    assert fit.loglik == pytest.approx(expected["loglik_lnspace"], rel=1e-6)
    assert fit.se_ln_theta == pytest.approx(expected["se_ln_theta"], rel=1e-4)
    assert fit.se_beta == pytest.approx(expected["se_beta"], rel=1e-4)
    # of complete samples it is zero, and the reference shows its rounding
    assert fit.cov_ln_theta_beta == pytest.approx(expected["cov_lntheta_beta"], rel=1e-4, abs=1e-9)
    if "beta_unbiased_n_minus_1" in expected:
        unbiased = fit.as_json()["beta_unbiased_n_minus_1"]
        assert unbiased == pytest.approx(expected["beta_unbiased_n_minus_1"], rel=1e-6)


@pytest.mark.parametrize("name", BRACKETS)
def test_brackets_reproduce_the_case(name):
    given, expected = case(name)
    lower = given.get("bracket_lo", given.get("im_no_exceed"))
    fit = fit_brackets(lower, ends(given.get("bracket_hi", given.get("im_exceed"))))
    assert fit.theta == pytest.approx(expected["theta"], rel=2e-6)
    assert fit.beta == pytest.approx(expected["beta"], rel=2e-6)
    assert fit.se_ln_theta == pytest.approx(expected["se_ln_theta"], rel=2e-4)
    assert fit.se_beta == pytest.approx(expected["se_beta"], rel=2e-4)


def test_independent_binomial_errors_are_too_small_for_the_same_records():
    given, expected = case("ida_same_records_on_stripes")
    naive = fit_stripes(given["stripes"], [given["n"]] * 5, given["k"])
    assert naive.theta == pytest.approx(expected["naive_msa_theta"], rel=1e-6)
    assert naive.beta == pytest.approx(expected["naive_msa_beta"], rel=1e-6)
    assert naive.se_ln_theta == pytest.approx(expected["naive_msa_se_ln_theta"], rel=1e-4)
    assert naive.se_ln_theta < 0.7 * expected["se_ln_theta"]


@pytest.mark.parametrize("name", ["deg_all_zero", "deg_all_one"])
def test_nothing_or_everything_exceeding_gives_a_bound(name):
    given, expected = case(name)
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == expected["status"]
    assert np.isnan(fit.theta)
    assert np.isnan(fit.beta)
    side = "lower" if name == "deg_all_zero" else "upper"
    key = f"theta_{side}95_given_beta"
    assert fit.as_json()[key] == pytest.approx(expected[key], rel=1e-5)
    limit = "p_upper" if side == "lower" else "p_lower"
    wanted = expected[f"{limit}95_clopper_pearson_each"]
    assert fit.as_json()[limit] == pytest.approx([wanted] * 3, rel=1e-6)


def test_complete_separation_gives_an_interval_and_a_labelled_firth_estimate():
    given, expected = case("deg_complete_separation")
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == "complete_separation"
    assert np.isnan(fit.theta)
    assert fit.as_json()["theta_interval"] == pytest.approx(expected["theta_interval"], rel=1e-12)
    assert fit.as_json()["firth"] == pytest.approx(expected["firth"], rel=1e-5)


def test_single_level_gives_a_median_only_for_an_assumed_dispersion():
    given, expected = case("deg_single_level")
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == "single_level"
    assert np.isnan(fit.theta)
    assert fit.as_json()["theta_given_beta"] == pytest.approx(expected["theta_given_beta"])


@pytest.mark.parametrize("name", ["deg_k_gt_n", "deg_im_nonpositive", "deg_nan"])
def test_bad_stripes_are_refused_with_the_row(name):
    given, expected = case(name)
    with pytest.raises(InputError) as caught:
        fit_stripes(given["im"], given["n"], given["k"])
    assert str(caught.value).startswith(expected["error"])


def test_degenerate_capacities_get_their_status():
    given, expected = case("deg_ida_all_censored")
    fit = fit_capacities(given["capacity"], given["right_censored"])
    assert fit.status == "all_censored"
    assert fit.as_json()["theta_lower95_given_beta"] == pytest.approx(
        expected["theta_lower95_given_beta"], rel=1e-5
    )
    given, expected = case("deg_ida_identical")
    fit = fit_capacities(given["capacity"], given["right_censored"])
    assert (fit.status, fit.theta, fit.beta) == ("zero_dispersion", 1.0, 0.0)
    assert fit.ci_method == ""


def test_lilliefors_distance_and_critical_values():
    given, expected = case("gof_lilliefors_12")
    distance, critical_05, critical_10 = lilliefors(np.log(given["capacity"]))
    assert distance == pytest.approx(expected["D"], rel=1e-9)
    assert critical_05 == pytest.approx(expected["D_crit_05"], rel=1e-9)
    assert critical_10 == pytest.approx(expected["D_crit_10"], rel=1e-9)
