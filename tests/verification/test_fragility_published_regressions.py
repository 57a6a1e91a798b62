"""Clouds, systems and regressions against published numbers, within their tolerance."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from reference_data import fragility_case as case
from skewbridge.errors import InputError
from skewbridge.fragility.exchange import risk
from skewbridge.fragility.old_joint.probit import fit_probit
from skewbridge.fragility.old_joint.shares import sobol
from skewbridge.fragility.old_joint.surface import Surface
from skewbridge.fragility.old_joint.terms import box_of
from skewbridge.fragility.old_likelihood.links import probability
from skewbridge.fragility.old_likelihood.newton import BinomialKernel, maximise
from skewbridge.fragility.methods import cloud, cloud_models, system
from skewbridge.fragility.methods.ordered import fit_ordered


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
