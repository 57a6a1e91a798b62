"""Published, classical and own cases of `tests/data/fragility_cases.json`, each with its source.

Tolerances are those of the cases: 1e-6 on estimates (they were confirmed with 50 digits), 1e-4 on
standard errors (some references differentiate numerically), 1e-5 on interval ends.
"""

import numpy as np
import pytest

from reference_data import fragility_case as case
from skewbridge.errors import InputError
from skewbridge.fragility.exchange import risk
from skewbridge.fragility.likelihood.links import probability
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.methods import axis_probit as designs
from skewbridge.fragility.methods import cloud, cloud_models, dispersion, goodness, system
from skewbridge.fragility.methods.ida import fit_brackets, fit_capacities
from skewbridge.fragility.methods.ordered import fit_ordered
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.tables.limit_states import convolved_curve
from skewbridge.fragility.tables.surrogate import sobol

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
        assert fit.details[key] == pytest.approx(expected[key], rel=1e-6)
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
        unbiased = fit.details["beta_unbiased_n_minus_1"]
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
        assert fit.details[key] == pytest.approx(expected[key], rel=1e-6)
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
    assert fit.details[key] == pytest.approx(expected[key], rel=1e-5)
    limit = "p_upper" if side == "lower" else "p_lower"
    wanted = expected[f"{limit}95_clopper_pearson_each"]
    assert fit.details[limit] == pytest.approx([wanted] * 3, rel=1e-6)


def test_complete_separation_gives_an_interval_and_a_labelled_firth_estimate():
    given, expected = case("deg_complete_separation")
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == "complete_separation"
    assert np.isnan(fit.theta)
    assert fit.details["theta_interval"] == pytest.approx(expected["theta_interval"], rel=1e-12)
    assert fit.details["firth"] == pytest.approx(expected["firth"], rel=1e-5)


def test_single_level_gives_a_median_only_for_an_assumed_dispersion():
    given, expected = case("deg_single_level")
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == "single_level"
    assert np.isnan(fit.theta)
    assert fit.details["theta_given_beta"] == pytest.approx(expected["theta_given_beta"])


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
    assert fit.details["theta_lower95_given_beta"] == pytest.approx(
        expected["theta_lower95_given_beta"], rel=1e-5
    )
    given, expected = case("deg_ida_identical")
    fit = fit_capacities(given["capacity"], given["right_censored"])
    assert (fit.status, fit.theta, fit.beta) == ("zero_dispersion", 1.0, 0.0)
    assert fit.ci_method == ""


def test_norris_regression_is_certified_to_ten_digits():
    given, expected = case("cloud_nist_norris")
    fit = cloud.fit_cloud(np.exp(given["ln_im"]), np.exp(given["ln_edp"]), given["threshold"])
    assert fit.details["ln_a"] == pytest.approx(expected["ln_a"], rel=1e-8)
    assert fit.details["b"] == pytest.approx(expected["b"], rel=1e-10)
    assert fit.details["sigma"] == pytest.approx(expected["beta_d_im"], rel=1e-8)
    assert fit.theta == pytest.approx(expected["theta"], rel=1e-6)
    assert fit.beta == pytest.approx(expected["zeta"], rel=1e-6)


def test_degenerate_clouds_get_their_status_or_error():
    given, expected = case("deg_cloud_negative_slope")
    fit = cloud.fit_cloud(given["im"], given["edp"], given["threshold"])
    assert fit.status == "non_increasing"
    assert fit.details["b"] == pytest.approx(expected["b"], rel=1e-6)
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
    assert fit.details["b"] == pytest.approx(expected["b"], rel=1e-6)
    assert fit.details["sigma"] == pytest.approx(expected["beta_d_im_nc"], rel=1e-6)
    assert fit.details["collapse_a0"] == pytest.approx(expected[f"{link}_a0"], rel=1e-6)
    assert fit.details["collapse_a1"] == pytest.approx(expected[f"{link}_a1"], rel=1e-6)
    x = np.array(expected["im_grid"])
    line = (fit.details["ln_a"] + fit.details["b"] * np.log(x)) - np.log(given["threshold"])
    falls = probability(fit.details["collapse_a0"] + fit.details["collapse_a1"] * np.log(x), link)
    p = probability(line / fit.details["sigma"]) * (1 - falls) + falls
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
        assert fit.details[key] == pytest.approx(expected[key], rel=1e-6)
    assert fit.loglik == pytest.approx(expected["loglik"], rel=1e-6)
    assert fit.details["lr"] == pytest.approx(expected["LR"], rel=1e-6)
    assert fit.details["lr_p"] == pytest.approx(expected["LR_p"], rel=1e-6)


def test_convolution_of_demand_and_capacity_is_the_closed_form():
    given, expected = case("convolution_demand_capacity")
    arguments = {
        "ln_a": given["ln_a"],
        "b": given["b"],
        "sigma": given["beta_d"],
        "capacity": given["capacity_median"],
        "capacity_dispersion": given["beta_c"],
    }
    theta, beta, p = convolved_curve(np.array(given["im"]), **arguments)
    assert theta == pytest.approx(expected["theta"], rel=1e-9)
    assert beta == pytest.approx(expected["beta"], rel=1e-9)
    assert p == pytest.approx(expected["p"], rel=1e-9)  # ten digits are given
    wider = convolved_curve(
        np.array(given["im"]), **arguments, model_dispersion=given["beta_model"]
    )
    assert wider[1] == pytest.approx(expected["beta_with_model"], rel=1e-9)


def test_series_system_of_two_is_the_bivariate_integral():
    given, expected = case("system_series_two_components")
    for rho in given["rho"]:
        joint = system.JointDemand(
            theta=np.array(given["theta"]),
            beta=np.array(given["beta"]),
            correlation=np.array([[1.0, rho], [rho, 1.0]]),
        )
        curve = system.series_system(np.array(given["im"]), joint)
        assert curve.p == pytest.approx(expected["p_union"][str(rho)], abs=1e-8)
        assert curve.lower == pytest.approx(expected["lower_max"], abs=1e-8)
        assert curve.upper == pytest.approx(expected["upper_indep"], abs=1e-8)


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
    # the case scales the gap by 0.0508 m, as designs does
    z = designs.scaled_design(
        np.array(given["skew_deg"], dtype=float),
        np.array(given["gap_m"]) * 1000,
        np.array(given["mu"]),
    )
    full = designs.fit_design(x, z, y, interactions=("skew:ln_im",))
    plain = designs.fit_design(x, z, y)
    assert full.coefficients == pytest.approx(expected["probit"], rel=1e-6)
    assert full.se == pytest.approx(expected["probit_se_expected_info"], rel=1e-4)
    assert full.loglik == pytest.approx(expected["loglik"], rel=1e-6)
    assert plain.coefficients == pytest.approx(expected["no_interaction"], rel=1e-6)
    statistic, dof, p_value = designs.likelihood_ratio(full, plain)
    assert (statistic, dof) == (pytest.approx(expected["LR_interaction"], rel=1e-6), 1)
    assert p_value == pytest.approx(expected["LR_p"], rel=1e-6)
    at = full.curve_at({"skew": 0.75, "gap": np.log(0.5), "friction": 0.5})
    assert at == pytest.approx(expected["theta_beta_skew45_gap1in_mu0p5"], rel=1e-6)
    origin = full.curve_at({"skew": 0.0, "gap": 0.0, "friction": 0.0})
    assert origin == pytest.approx(expected["theta_beta_skew0_gap2in_mu0"], rel=1e-6)
    logit = designs.fit_design(x, z, y, interactions=("skew:ln_im",), link="logit")
    assert logit.coefficients == pytest.approx(expected["logit"], rel=1e-6)
    assert logit.loglik == pytest.approx(expected["logit_loglik"], rel=1e-6)


def test_sobol_indices_of_ishigami():
    _, expected = case("sobol_ishigami")

    def ishigami(x):
        return np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])

    first, total = sobol(ishigami, [-np.pi] * 3, [np.pi] * 3)
    assert first == pytest.approx(expected["S1"], abs=0.02)
    assert total == pytest.approx(expected["ST"], abs=0.02)


def test_dispersions_and_risk_reproduce_their_formulas():
    given, expected = case("beta_total_fema_p695")
    assert dispersion.total_dispersion(*given.values()) == pytest.approx(
        expected["beta_total"], rel=1e-9
    )
    given, expected = case("beta_rtr_fema_p695")
    found = dispersion.default_record_dispersion(np.array(given["mu_T"]))
    assert found == pytest.approx(expected["beta_rtr"], rel=1e-12)
    given, expected = case("risk_maf_power_law")
    # wide enough that nothing is left outside; few points, for each segment is integrated exactly
    im = np.geomspace(1e-3, 1e5, 12)
    rate = given["k0"] * im ** -given["k"]
    found = risk.annual_frequency(given["theta"], given["beta"], im, rate)
    assert found.frequency == pytest.approx(expected["maf"], rel=1e-8)
    assert found.probability_50y == pytest.approx(expected["p50yr"], rel=1e-8)
