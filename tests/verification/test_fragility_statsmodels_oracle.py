"""statsmodels and scipy as oracles: independent code for the same formulas.

Tolerances: 1e-8 where both solve a smooth problem to convergence, 1e-5 where statsmodels stops a
numerical optimiser. Of stripes: 1e-6 on estimates, 1e-4 on standard errors, which are those of
the observed information.
"""

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
from scipy import stats
from statsmodels.miscmodels.ordinal_model import OrderedModel
from statsmodels.stats.diagnostic import het_breuschpagan

from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.fits import fit_cloud
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.lines import tested_line as line_with_tests
from skewbridge.fragility.mixed import MixedData, fit_mixed
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.system import _failures


def test_cloud_tests_agree_with_ols_diagnostics():
    rng = np.random.default_rng(3)
    x = rng.uniform(-2.3, 0.4, 60)
    y = -3.5 + 1.1 * x + 0.1 * x**2 + 0.3 * rng.normal(size=60)
    line = line_with_tests(x, y)
    ols = sm.OLS(y, sm.add_constant(x)).fit()
    assert [line.ln_a, line.b] == pytest.approx(list(ols.params), rel=1e-10)
    assert line.r2 == pytest.approx(ols.rsquared, rel=1e-10)
    assert line.scatter_p == pytest.approx(het_breuschpagan(ols.resid, ols.model.exog)[1])
    square = sm.OLS(y, np.column_stack([np.ones(60), x, x**2])).fit()
    assert line.curvature == pytest.approx(square.params[2], rel=1e-9)
    assert line.curvature_p == pytest.approx(square.pvalues[2], rel=1e-7)
    assert fit_cloud(np.exp(x), np.exp(y), 0.03).loglik == pytest.approx(ols.llf, rel=1e-10)


def test_states_with_one_slope_are_the_ordered_probit_of_statsmodels():
    rng = np.random.default_rng(3)
    im = np.exp(rng.uniform(-2.0, 0.7, 90))
    demand = 0.3 * im * np.exp(0.5 * rng.normal(size=90))
    frame = pd.DataFrame({"x": np.log(im), "state": np.searchsorted([0.1, 0.2, 0.4], demand)})
    model = OrderedModel(frame["state"], frame[["x"]], distr="probit")
    found = model.fit(method="bfgs", disp=False, gtol=1e-8)
    cuts = model.transform_threshold_params(found.params.to_numpy())[1:-1]
    slope = float(found.params.iloc[0])
    given = {"component": "c", "demand": "d_m", "dispersion": 0.0}
    states = [LimitState(name=str(c), threshold=c, **given) for c in (0.1, 0.2, 0.4)]
    runs = {"im_x_g": im, "d_m": demand, "status": "ok", "variant": "v", "bridge": "b"}
    runs |= {"motion_id": [f"m{number}" for number in range(90)], "abutment": "a"}
    runs = pd.DataFrame(runs).assign(scale=1.0, incidence_deg=0.0)
    curves = fit_study(runs, states, FitSettings(im="im_x_g"))
    ours = curves[curves["method"] == "exceedance"]
    assert ours["beta"].to_numpy() == pytest.approx(1 / slope, rel=1e-5)
    assert ours["theta"].to_numpy() == pytest.approx(np.exp(cuts / slope), rel=1e-5)
    assert ours["loglik"].iloc[0] == pytest.approx(found.llf, rel=1e-8)


def test_mixed_model_agrees_with_statsmodels():
    rng = np.random.default_rng(7)
    motion = np.repeat(np.arange(24), 6)
    kept = rng.uniform(size=motion.size) < 0.8  # not every variant under every motion
    motion, skew = motion[kept], np.tile(np.arange(6) / 5.0, 24)[kept]
    ln_im = rng.uniform(-2, 0.4, 24)[motion]
    y = 0.3 + 1.1 * ln_im + 0.2 * skew + 0.3 * rng.normal(size=24)[motion]
    y += 0.1 * rng.normal(size=y.size)
    design = np.column_stack([np.ones(y.size), ln_im, skew])
    fit = fit_mixed(MixedData(design=design, lower=y, upper=y, motion=motion))
    theirs = sm.MixedLM(y, design, groups=motion).fit(reml=False)
    assert fit.delta == pytest.approx(theirs.fe_params, rel=1e-4)
    assert fit.sigma**2 == pytest.approx(theirs.scale, rel=1e-3)
    assert fit.tau**2 == pytest.approx(float(np.asarray(theirs.cov_re)[0, 0]), rel=1e-3)
    information = np.linalg.inv(np.sum(fit.information, axis=0))
    errors = np.sqrt(np.diag(information))[:3]
    assert errors == pytest.approx(np.asarray(theirs.bse_fe), rel=1e-3)


@pytest.mark.parametrize(("size", "rho"), [(5, 0.5), (9, 0.6), (3, 1.0)])
def test_quasi_random_systems_agree_with_scipy(size, rho):
    theta, beta = np.linspace(0.5, 1.2, size), np.full(size, 0.5)
    correlation = np.full((size, size), rho) + (1.0 - rho) * np.eye(size)
    failures = _failures(np.log(theta)[None], beta[None], correlation[None], 2**16, 1)
    first = np.min(failures, axis=0)
    normal = stats.multivariate_normal(np.zeros(size), correlation, allow_singular=True, seed=1)
    for im in (0.3, 0.5, 0.8):
        expected = 1.0 - normal.cdf(-np.log(im / theta) / beta)
        assert np.mean(first <= np.log(im)) == pytest.approx(expected, abs=1e-3)
