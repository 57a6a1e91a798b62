"""Published, classical and own cases of `tests/data/fragility_cases.json`, each with its source.

Tolerances are those of the cases: 1e-6 on estimates (they were confirmed with 50 digits), 1e-4 on
standard errors (some references differentiate numerically), 1e-5 on interval ends.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from reference_data import fragility_case as case
from skewbridge.errors import InputError
from skewbridge.fragility.exchange import risk
from skewbridge.fragility.joint.probit import fit_probit
from skewbridge.fragility.joint.shares import sobol
from skewbridge.fragility.joint.surface import Surface
from skewbridge.fragility.joint.terms import box_of
from skewbridge.fragility.likelihood.links import probability
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.methods import cloud, cloud_models, goodness, system
from skewbridge.fragility.methods.ida import fit_brackets, fit_capacities
from skewbridge.fragility.methods.ordered import fit_ordered
from skewbridge.fragility.methods.stripes import fit_stripes

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
BRACKETS = (
    "ida_interval_censored_R",
    "ida_same_records_on_stripes",
)


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


def test_logit_link_reproduces_the_beetles():
    given, expected = case("msa_bliss_beetle_logit")
    fit = fit_stripes(given["im"], given["n"], given["k"], link="logit")
    for key in ("a0", "a1", "deviance", "beta_equiv_pi_sqrt3"):
        assert fit.as_json()[key] == pytest.approx(expected[key], rel=1e-6)
    assert fit.theta == pytest.approx(expected["theta"], rel=1e-6)


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


def test_norris_regression_is_certified_to_ten_digits():
    given, expected = case("cloud_nist_norris")
    fit = cloud.fit_cloud(np.exp(given["ln_im"]), np.exp(given["ln_edp"]), given["threshold"])
    assert fit.as_json()["ln_a"] == pytest.approx(expected["ln_a"], rel=1e-8)
    assert fit.as_json()["b"] == pytest.approx(expected["b"], rel=1e-10)
    assert fit.as_json()["sigma"] == pytest.approx(expected["beta_d_im"], rel=1e-8)
    assert fit.theta == pytest.approx(expected["theta"], rel=1e-6)
    assert fit.beta == pytest.approx(expected["zeta"], rel=1e-6)


def test_degenerate_clouds_get_their_status_or_error():
    given, expected = case("deg_cloud_negative_slope")
    fit = cloud.fit_cloud(given["im"], given["edp"], given["threshold"])
    assert fit.status == "non_increasing"
    assert fit.as_json()["b"] == pytest.approx(expected["b"], rel=1e-6)
    assert np.isnan(fit.beta)
    given, expected = case("deg_cloud_edp_zero_or_nan")
    with pytest.raises(InputError) as caught:
        cloud.fit_cloud(given["im"], given["edp"], given["threshold"])
    assert str(caught.value).startswith(expected["error"])


@pytest.mark.parametrize("link", ["logit", "probit"])
def test_modified_cloud_reproduces_the_case(link):
    given, expected = case("cloud_modified_collapse")
    fit = cloud_models.fit_modified_cloud(
        given["im"], given["edp"], given["threshold"], given["collapse"], collapse_link=link
    )
    assert fit.as_json()["b"] == pytest.approx(expected["b"], rel=1e-6)
    assert fit.as_json()["sigma"] == pytest.approx(expected["beta_d_im_nc"], rel=1e-6)
    assert fit.as_json()["collapse_a0"] == pytest.approx(expected[f"{link}_a0"], rel=1e-6)
    assert fit.as_json()["collapse_a1"] == pytest.approx(expected[f"{link}_a1"], rel=1e-6)
    x = np.array(expected["im_grid"])
    line = (fit.as_json()["ln_a"] + fit.as_json()["b"] * np.log(x)) - np.log(given["threshold"])
    falls = probability(
        fit.as_json()["collapse_a0"] + fit.as_json()["collapse_a1"] * np.log(x), link
    )
    p = probability(line / fit.as_json()["sigma"]) * (1 - falls) + falls
    assert p == pytest.approx(expected[f"p_{link}"], rel=1e-6)
    if link == "logit":
        assert fit.theta == pytest.approx(expected["median_im"], rel=1e-6)
        assert fit.beta == pytest.approx(expected["beta_equiv"], rel=1e-6)


def test_heteroscedastic_cloud_reproduces_the_case():
    given, expected = case("cloud_heteroscedastic")
    fit = cloud_models.fit_heteroscedastic(
        np.exp(given["ln_im"]), np.exp(given["ln_edp"]), given["threshold"]
    )
    for key in ("ln_a", "b", "g0", "g1", "loglik_homoscedastic"):
        assert fit.as_json()[key] == pytest.approx(expected[key], rel=1e-6)
    assert fit.loglik == pytest.approx(expected["loglik"], rel=1e-6)
    assert fit.as_json()["lr"] == pytest.approx(expected["LR"], rel=1e-6)
    assert fit.as_json()["lr_p"] == pytest.approx(expected["LR_p"], rel=1e-6)


def test_series_system_of_two_is_the_bivariate_integral():
    given, expected = case("system_series_two_components")
    for rho in given["rho"]:
        joint = system.JointDemand(
            theta=np.array(given["theta"]),
            beta=np.array(given["beta"]),
            correlation=np.array([[1.0, rho], [rho, 1.0]]),
        )
        found = system.series_system(np.array(given["im"]), joint)
        assert found == pytest.approx(expected["p_union"][str(rho)], abs=1e-8)


def test_lilliefors_distance_and_critical_values():
    given, expected = case("gof_lilliefors_12")
    found = goodness.lilliefors(np.log(given["capacity"]))
    assert found.distance == pytest.approx(expected["D"], rel=1e-9)
    assert found.critical_05 == pytest.approx(expected["D_crit_05"], rel=1e-9)
    assert found.critical_10 == pytest.approx(expected["D_crit_10"], rel=1e-9)
    assert found.p_value == pytest.approx(expected["p_table"], abs=0.02)  # tables end at 0.99


def test_ordered_probit_reproduces_the_case():
    given, expected = case("ordinal_probit_two_limit_states")
    fit = fit_ordered(given["im"], given["counts_none_ls1_ls2"])
    assert fit.theta == pytest.approx([expected["theta_ls1"], expected["theta_ls2"]], rel=1e-6)
    assert fit.beta == pytest.approx(expected["beta"], rel=1e-6)
    assert fit.loglik == pytest.approx(expected["loglik"], rel=1e-6)


@pytest.mark.parametrize("link", ["probit", "logit"])
def test_glm_of_several_covariates_reproduces_greene(link):
    given, expected = case("glm_spector_probit_logit")
    x, y = np.array(given["X"]), np.array(given["y"], dtype=float)
    best = maximise(BinomialKernel(x, np.ones(y.size), y, link), np.zeros((1, 4)))
    assert best.params[0] == pytest.approx(expected[link], rel=1e-6)
    assert np.sqrt(np.diag(best.covariance[0])) == pytest.approx(expected[f"{link}_se"], rel=1e-4)
    assert best.loglik[0] == pytest.approx(expected[f"{link}_loglik"], rel=1e-6)


def test_parameterised_bridge_reproduces_the_case():
    given, expected = case("glm_parameterised_bridge")
    x, y = np.array(given["ln_im"]), np.array(given["exceed"], dtype=float)
    # the case scales the gap by 0.0508 m, as the joint model does
    variants = pd.DataFrame(
        {
            "skew_deg": np.array(given["skew_deg"], dtype=float),
            "gap_mm": np.array(given["gap_m"]) * 1000,
            "friction": np.array(given["mu"]),
        }
    )
    box = replace(box_of(variants, variants.columns), log_gap=True)
    each = np.arange(x.size)
    plain = Surface(variants=variants, box=box, terms=("skew_deg", "gap_mm", "friction"))
    full = replace(plain, terms=(*plain.terms, "skew_deg:ln_im"))
    fits = {
        name: fit_probit(surface.design(x, each), y, each)
        for name, surface in (("probit", full), ("no_interaction", plain))
    }
    for name, fit in fits.items():
        assert fit.status == "ok"
        assert fit.sums.params == pytest.approx(expected[name], rel=1e-6)
    assert fits["probit"].loglik == pytest.approx(expected["loglik"], rel=1e-6)
    ratio = 2.0 * (fits["probit"].loglik - fits["no_interaction"].loglik)
    assert ratio == pytest.approx(expected["LR_interaction"], rel=1e-6)
    places = pd.DataFrame({"skew_deg": [45.0, 0.0], "gap_mm": [25.4, 50.8], "friction": [0.5, 0.0]})
    at = Surface(variants=places, box=box, terms=full.terms)
    ln_theta, slope = at.medians(fits["probit"].sums.params[None, :], 0.0)
    found = np.column_stack([np.exp(ln_theta[0]), 1.0 / slope[0]])
    assert found[0] == pytest.approx(expected["theta_beta_skew45_gap1in_mu0p5"], rel=1e-6)
    assert found[1] == pytest.approx(expected["theta_beta_skew0_gap2in_mu0"], rel=1e-6)
    design = full.design(x, each)
    kernel = BinomialKernel(design, np.ones(y.size), y, "logit")
    logit = maximise(kernel, np.zeros((1, design.shape[1])))
    assert logit.params[0] == pytest.approx(expected["logit"], rel=1e-6)
    assert logit.loglik[0] == pytest.approx(expected["logit_loglik"], rel=1e-6)


def test_sobol_indices_of_ishigami():
    _, expected = case("sobol_ishigami")

    def ishigami(x):
        return np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])

    first, total = sobol(ishigami, [-np.pi] * 3, [np.pi] * 3, seed=20240501)
    assert first == pytest.approx(expected["S1"], abs=0.02)
    assert total == pytest.approx(expected["ST"], abs=0.02)


def test_annual_frequency_reproduces_its_formula():
    given, expected = case("risk_maf_power_law")
    # wide enough that nothing is left outside; few points, for each segment is integrated exactly
    im = np.geomspace(1e-3, 1e5, 12)
    rate = given["k0"] * im ** -given["k"]
    found = risk.annual_frequency(given["theta"], given["beta"], im, rate)
    assert found.frequency == pytest.approx(expected["maf"], rel=1e-8)
    assert found.probability_50y == pytest.approx(expected["p50yr"], rel=1e-8)
