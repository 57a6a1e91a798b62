"""Published, classical and own cases of `tests/data/fragility_cases.json`, each with its source.

Tolerances are those of the cases: 1e-6 on estimates (they were confirmed with 50 digits), 1e-4 on
standard errors (some references differentiate numerically), 1e-5 on interval ends.
"""

import numpy as np
import pytest

from reference_data import fragility_case as case
from skewbridge.errors import InputError
from skewbridge.fragility.exports import annual_frequency
from skewbridge.fragility.fits import fit_brackets, fit_capacities, fit_cloud, fit_stripes
from skewbridge.fragility.likelihood import NormalKernel, maximise
from skewbridge.fragility.lines import lilliefors

MSA = (
    "msa_wood_b1_existing", "msa_wood_b1_retrofit", "msa_wood_b2_retrofit", "msa_wood_b3_existing",
    "msa_wood_b4_retrofit", "msa_bliss_beetle_probit", "deg_stripe_with_n_zero",
)  # fmt: skip
CAPACITIES = (
    "ida_locomotive_right_censored", "ida_12_complete", "ida_12_censored_at_1p5",
    "ida_reliawiki_10",
)  # fmt: skip
BRACKETS = ("ida_interval_censored_R", "ida_same_records_on_stripes")


def ends(values):
    return [np.inf if value in ("inf", None) else value for value in values]


def assert_errors(fit, expected, tolerance=1e-4):
    assert fit.se_ln_theta == pytest.approx(expected["se_ln_theta"], rel=tolerance)
    assert fit.se_beta == pytest.approx(expected["se_beta"], rel=tolerance)


@pytest.mark.parametrize("name", MSA)
def test_stripes_reproduce_the_case(name):
    given, expected = case(name)
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == "ok"
    for key in ("theta", "beta", "loglik"):
        assert getattr(fit, key) == pytest.approx(expected[key], rel=1e-6)
    for key in ("a0", "a1", "deviance", "pearson", "aic", "loglik_kernel"):
        assert fit.as_json()[key] == pytest.approx(expected[key], rel=1e-6)
    assert fit.cov_ln_theta_beta == pytest.approx(expected["cov_lntheta_beta"], rel=1e-4)
    assert_errors(fit, expected)
    assert fit.ci_theta == pytest.approx(ends(expected["profile95_theta"]), rel=1e-5)
    assert fit.ci_beta == pytest.approx(ends(expected["profile95_beta"]), rel=1e-5)
    assert set(expected.get("warnings", [])) <= set(fit.warnings)


@pytest.mark.parametrize("name", CAPACITIES)
def test_capacities_reproduce_the_case(name):
    given, expected = case(name)
    fit = fit_capacities(given["capacity"], given["right_censored"])
    assert fit.status == expected["status"]
    wanted = [expected[name] for name in ("theta", "beta", "loglik_lnspace")]
    assert [fit.theta, fit.beta, fit.loglik] == pytest.approx(wanted, rel=1e-6)
    assert_errors(fit, expected)
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
    wanted = expected["theta"], expected["beta"]
    assert (fit.theta, fit.beta) == pytest.approx(wanted, rel=2e-6)
    assert_errors(fit, expected, 2e-4)


def test_independent_binomial_errors_are_too_small_for_the_same_records():
    given, expected = case("ida_same_records_on_stripes")
    naive = fit_stripes(given["stripes"], [given["n"]] * 5, given["k"])
    wanted = expected["naive_msa_theta"], expected["naive_msa_beta"]
    assert (naive.theta, naive.beta) == pytest.approx(wanted, rel=1e-6)
    assert naive.se_ln_theta == pytest.approx(expected["naive_msa_se_ln_theta"], rel=1e-4)
    assert naive.se_ln_theta < 0.7 * expected["se_ln_theta"]


@pytest.mark.parametrize(
    ("name", "side", "limit"),
    [("deg_all_zero", "lower", "upper"), ("deg_all_one", "upper", "lower")],
)
def test_nothing_or_everything_exceeding_gives_a_bound(name, side, limit):
    given, expected = case(name)
    fit = fit_stripes(given["im"], given["n"], given["k"])
    assert fit.status == expected["status"]
    assert np.isnan([fit.theta, fit.beta]).all()
    key = f"theta_{side}95_given_beta"
    assert fit.as_json()[key] == pytest.approx(expected[key], rel=1e-5)
    wanted = expected[f"p_{limit}95_clopper_pearson_each"]
    assert fit.as_json()[f"p_{limit}"] == pytest.approx([wanted] * 3, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "status", "estimates"),
    [
        (
            "deg_complete_separation",
            "complete_separation",
            {"theta_interval": 1e-12, "firth": 1e-5},
        ),
        ("deg_single_level", "single_level", {"theta_given_beta": 1e-6}),
        ("deg_ida_all_censored", "all_censored", {"theta_lower95_given_beta": 1e-5}),
    ],
)
def test_degenerate_data_have_a_status_and_labelled_estimates(name, status, estimates):
    given, expected = case(name)
    fit = (
        fit_capacities(given["capacity"], given["right_censored"])
        if "capacity" in given
        else fit_stripes(given["im"], given["n"], given["k"])
    )
    assert (fit.status, np.isnan(fit.theta)) == (status, True)
    for key, tolerance in estimates.items():
        assert fit.as_json()[key] == pytest.approx(expected[key], rel=tolerance)


@pytest.mark.parametrize("name", ["deg_k_gt_n", "deg_im_nonpositive", "deg_nan"])
def test_bad_stripes_are_refused_with_the_row(name):
    given, expected = case(name)
    with pytest.raises(InputError) as caught:
        fit_stripes(given["im"], given["n"], given["k"])
    assert str(caught.value).startswith(expected["error"])


def test_identical_capacities_have_no_dispersion():
    given, _ = case("deg_ida_identical")
    fit = fit_capacities(given["capacity"], given["right_censored"])
    assert (fit.status, fit.theta, fit.beta) == ("zero_dispersion", 1.0, 0.0)
    assert fit.ci_method == ""


def test_lilliefors_distance_and_critical_values():
    given, expected = case("gof_lilliefors_12")
    wanted = [expected[name] for name in ("D", "D_crit_05", "D_crit_10")]
    assert lilliefors(np.log(given["capacity"])) == pytest.approx(wanted, rel=1e-9)


# --- clouds, systems and regressions


def probit(design, y):
    """Return the maximum over the coefficients of a probit, from capacities below or above 0."""
    exceed = y > 0.0
    kernel = NormalKernel(
        -design[:, 1:],
        np.where(exceed, -np.inf, design[:, 0]),
        np.where(exceed, design[:, 0], np.inf),
        upper_covariates=-design[:, 1:],
    )
    start = np.zeros((1, design.shape[1]))
    best = maximise(kernel, start)
    order = [design.shape[1] - 1, *range(design.shape[1] - 1)]
    return best.params[0, order], best.covariance[0][np.ix_(order, order)], best.loglik[0]


def test_norris_regression_is_certified_to_ten_digits():
    given, expected = case("cloud_nist_norris")
    fit = fit_cloud(np.exp(given["ln_im"]), np.exp(given["ln_edp"]), given["threshold"])
    found, wanted = fit.as_json(), (expected["ln_a"], expected["beta_d_im"])
    assert found["b"] == pytest.approx(expected["b"], rel=1e-10)
    assert (found["ln_a"], found["sigma"]) == pytest.approx(wanted, rel=1e-8)
    assert (fit.theta, fit.beta) == pytest.approx((expected["theta"], expected["zeta"]), rel=1e-6)


def test_degenerate_clouds_get_their_status_or_error():
    given, expected = case("deg_cloud_negative_slope")
    fit = fit_cloud(given["im"], given["edp"], given["threshold"])
    assert fit.status == "non_increasing"
    assert fit.as_json()["b"] == pytest.approx(expected["b"], rel=1e-6)
    assert np.isnan(fit.beta)
    given, _ = case("deg_cloud_edp_zero_or_nan")
    with pytest.raises(InputError) as caught:
        fit_cloud(given["im"], given["edp"], given["threshold"])
    assert str(caught.value).startswith("edp must be > 0 and finite (rows 0, 2)")


def test_probit_of_several_covariates_reproduces_greene():
    given, expected = case("glm_spector_probit_logit")
    x, y = np.array(given["X"]), np.array(given["y"], dtype=float)
    constant = int(np.flatnonzero(np.ptp(x, axis=0) == 0.0)[0])
    order = [constant, *(i for i in range(4) if i != constant)]
    params, covariance, loglik = probit(x[:, order], y)
    assert params == pytest.approx(np.array(expected["probit"])[order], rel=1e-6)
    errors = np.array(expected["probit_se"])[order]
    assert np.sqrt(np.diag(covariance)) == pytest.approx(errors, rel=1e-4)
    assert loglik == pytest.approx(expected["probit_loglik"], rel=1e-6)


def test_annual_frequency_reproduces_its_formula():
    given, expected = case("risk_maf_power_law")
    # wide enough that nothing is left outside; few points, for each segment is integrated exactly
    im = np.geomspace(1e-3, 1e5, 12)
    rate = given["k0"] * im ** -given["k"]
    found = annual_frequency(given["theta"], given["beta"], im, rate)
    assert found["annual_frequency"] == pytest.approx(expected["maf"], rel=1e-8)
    assert found["probability_50y"] == pytest.approx(expected["p50yr"], rel=1e-8)
