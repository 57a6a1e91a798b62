"""Lines through clouds: censored, with collapses, with uneven scatter, with a plateau."""

import numpy as np
import pytest
from scipy import stats

from skewbridge.fragility.methods.cloud import fit_cloud
from skewbridge.fragility.methods.cloud_models import fit_heteroscedastic, fit_modified_cloud
from skewbridge.fragility.methods.plateau import fit_plateau
from skewbridge.fragility.methods.tobit import fit_tobit
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Runs, outcomes_of
from skewbridge.fragility.tables.variant_exceedance import fit_uncertain_capacity


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
