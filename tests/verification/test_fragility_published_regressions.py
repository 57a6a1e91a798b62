"""Clouds, systems and regressions against published numbers, within their tolerance."""

import numpy as np
import pytest

from reference_data import fragility_case as case
from skewbridge.errors import InputError
from skewbridge.fragility.exports import annual_frequency
from skewbridge.fragility.fits import fit_cloud
from skewbridge.fragility.likelihood import NormalKernel, maximise
from skewbridge.fragility.system import _failures


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
    assert fit.as_json()["ln_a"] == pytest.approx(expected["ln_a"], rel=1e-8)
    assert fit.as_json()["b"] == pytest.approx(expected["b"], rel=1e-10)
    assert fit.as_json()["sigma"] == pytest.approx(expected["beta_d_im"], rel=1e-8)
    assert fit.theta == pytest.approx(expected["theta"], rel=1e-6)
    assert fit.beta == pytest.approx(expected["zeta"], rel=1e-6)


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


def test_series_system_of_two_is_the_bivariate_integral():
    given, expected = case("system_series_two_components")
    for rho in given["rho"]:
        first = _failures(
            np.log([given["theta"]]),
            np.array([given["beta"]]),
            np.array([[[1.0, rho], [rho, 1.0]]]),
            2**16,
            1,
        )
        found = [np.mean(np.min(first, axis=0) <= np.log(im)) for im in given["im"]]
        # error of quasi-random points
        assert found == pytest.approx(expected["p_union"][str(rho)], abs=3e-4)


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
