"""statsmodels and scipy as oracles: independent code for the same formulas.

Tolerances: 1e-8 where both solve a smooth problem to convergence, 1e-5 where statsmodels stops a
numerical optimiser.
"""

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
import statsmodels.formula.api as smf
from scipy import stats
from statsmodels.miscmodels.ordinal_model import OrderedModel
from statsmodels.stats.anova import AnovaRM
from statsmodels.stats.diagnostic import het_breuschpagan

from fragility_tables import synthetic_demands
from skewbridge.fragility.old_joint.by_motion import jackknife_covariance
from skewbridge.fragility.old_joint.mixed import MixedData, fit_mixed
from skewbridge.fragility.old_joint.probit import fit_probit
from skewbridge.fragility.methods.cloud import fit_cloud, fit_line
from skewbridge.fragility.methods.ida import fit_brackets
from skewbridge.fragility.methods.ordered import fit_ordered
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.methods.system import JointDemand, series_system
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import factor_summary

LINKS = {
    "probit": sm.families.links.Probit(),
    "logit": sm.families.links.Logit(),
    "cloglog": sm.families.links.CLogLog(),
}
IM = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3])
N = np.array([20, 25, 20, 30, 20, 20, 15, 20])
K = np.array([0, 1, 3, 9, 11, 14, 13, 19])


@pytest.mark.parametrize("link", LINKS)
def test_stripes_agree_with_a_binomial_glm(link):
    design = sm.add_constant(np.log(IM))
    glm = sm.GLM(
        np.column_stack([K, N - K]), design, family=sm.families.Binomial(link=LINKS[link])
    ).fit(tol=1e-14, maxiter=200)
    fit = fit_stripes(IM, N, K, link=link)
    assert [fit.predictor.a0, fit.predictor.a1] == pytest.approx(list(glm.params), rel=1e-8)
    assert fit.loglik == pytest.approx(glm.llf, rel=1e-9)
    assert fit.goodness.deviance == pytest.approx(glm.deviance, rel=1e-8)


def test_cloud_tests_agree_with_ols_diagnostics():
    rng = np.random.default_rng(3)
    x = rng.uniform(-2.3, 0.4, 60)
    y = -3.5 + 1.1 * x + 0.1 * x**2 + 0.3 * rng.normal(size=60)
    line = fit_line(x, y)
    ols = sm.OLS(y, sm.add_constant(x)).fit()
    assert [line.ln_a, line.b] == pytest.approx(list(ols.params), rel=1e-10)
    assert line.r2 == pytest.approx(ols.rsquared, rel=1e-10)
    assert line.cook_max == pytest.approx(float(np.max(ols.get_influence().cooks_distance[0])))
    assert line.scatter_p == pytest.approx(het_breuschpagan(ols.resid, ols.model.exog)[1])
    square = sm.OLS(y, np.column_stack([np.ones(60), x, x**2])).fit()
    assert line.curvature == pytest.approx(square.params[2], rel=1e-9)
    assert line.curvature_p == pytest.approx(square.pvalues[2], rel=1e-7)
    assert fit_cloud(np.exp(x), np.exp(y), 0.03).loglik == pytest.approx(ols.llf, rel=1e-10)


def test_brackets_agree_with_scipy():
    lower = np.array([0.2, 0.3, 0.3, 0.4, 0.5, 0.6, 0.6, 0.8, 0.9])
    upper = np.array([0.3, 0.4, 0.5, 0.5, 0.7, 0.7, 0.9, 1.0, np.inf])
    data = stats.CensoredData(interval=np.column_stack([lower, upper])[:-1], right=[lower[-1]])
    shape, _, scale = stats.lognorm.fit(data, floc=0)
    fit = fit_brackets(lower, upper)
    assert fit.theta == pytest.approx(scale, rel=2e-4)  # scipy's simplex tolerance
    assert fit.beta == pytest.approx(shape, rel=2e-4)


def test_ordered_probit_agrees_with_statsmodels():
    im = np.array([0.2, 0.4, 0.6, 0.9, 1.3])
    counts = np.array([[18, 2, 0, 0], [12, 6, 2, 0], [7, 6, 5, 2], [2, 5, 7, 6], [1, 2, 5, 12]])
    rows = [
        (x, s)
        for x, row in zip(im, counts, strict=True)
        for s, n in enumerate(row)
        for _ in range(n)
    ]
    frame = pd.DataFrame(rows, columns=["im", "state"])
    model = OrderedModel(frame["state"], np.log(frame[["im"]]), distr="probit")
    found = model.fit(method="bfgs", disp=False, gtol=1e-8)
    cuts = model.transform_threshold_params(found.params.to_numpy())[1:-1]
    slope = float(found.params.iloc[0])
    fit = fit_ordered(im, counts)
    assert fit.beta == pytest.approx(1 / slope, rel=1e-5)
    assert fit.theta == pytest.approx(np.exp(cuts / slope), rel=1e-5)


def test_probit_over_axes_agrees_with_statsmodels():
    rng = np.random.default_rng(5)
    motion = np.repeat(np.arange(30), 6)
    ln_im = np.repeat(rng.uniform(-2, 0.4, 30), 6)
    skew = np.tile([0.0, 0.25, 0.5, 0.5, 0.75, 1.0], 30)
    eta = 1.0 + 2.0 * ln_im + 0.5 * skew + np.repeat(0.5 * rng.normal(size=30), 6)
    y = (rng.normal(size=180) < eta).astype(float)
    design = np.column_stack([np.ones(180), ln_im, skew])
    model = sm.Probit(y, design)
    fit = fit_probit(design, y, motion)
    assert fit.sums.params == pytest.approx(model.fit(disp=False).params, rel=1e-6)
    robust = model.fit(
        disp=False, cov_type="cluster", cov_kwds={"groups": motion, "use_correction": False}
    )
    bread = np.linalg.inv(np.sum(fit.sums.information, axis=0))
    sandwich = bread @ fit.sums.score.T @ fit.sums.score @ bread
    assert np.sqrt(np.diag(sandwich)) == pytest.approx(robust.bse, rel=1e-5)
    # the jackknife by motion is larger: the sandwich is too small for few clusters
    jackknife = jackknife_covariance(fit.sums.one_left_out()[0])
    excess = np.sqrt(np.diag(jackknife) / np.diag(sandwich))
    assert np.all((excess > 1.0) & (excess < 1.3))


def test_mixed_model_agrees_with_statsmodels():
    rng = np.random.default_rng(7)
    motion = np.repeat(np.arange(24), 6)
    kept = rng.uniform(size=motion.size) < 0.8  # not every variant under every motion
    motion, skew = motion[kept], np.tile(np.arange(6) / 5.0, 24)[kept]
    ln_im = rng.uniform(-2, 0.4, 24)[motion]
    y = 0.3 + 1.1 * ln_im + 0.2 * skew + 0.3 * rng.normal(size=24)[motion]
    y += 0.1 * rng.normal(size=y.size)
    design = np.column_stack([np.ones(y.size), ln_im, skew])
    seen = np.ones(y.size, dtype=bool)
    fit = fit_mixed(MixedData(design=design, lower=y, seen=seen, motion=motion))
    theirs = sm.MixedLM(y, design, groups=motion).fit(reml=False)
    assert fit.sums.params == pytest.approx(theirs.fe_params, rel=1e-4)
    assert fit.sigma**2 == pytest.approx(theirs.scale, rel=1e-3)
    assert fit.tau**2 == pytest.approx(float(np.asarray(theirs.cov_re)[0, 0]), rel=1e-3)
    information = np.linalg.inv(np.sum(fit.sums.information, axis=0))
    errors = np.sqrt(np.diag(information))
    assert errors == pytest.approx(np.asarray(theirs.bse_fe), rel=1e-3)


def test_factors_agree_with_repeated_measures_of_statsmodels():
    table = synthetic_demands(motions=8)
    table["ln_d"] = np.log(table["deck_rotation_rad"])
    factors = ["skew_deg", "gap_mm", "friction"]
    theirs = AnovaRM(table, "ln_d", "motion_id", within=factors).fit().anova_table
    ours = factor_summary(table, ["deck_rotation_rad"]).set_index("factor")
    for factor in factors:
        assert ours.loc[factor, "f"] == pytest.approx(theirs.loc[factor, "F Value"])
    # with two values there is nothing to correct
    for factor in factors[1:]:
        assert ours.loc[factor, "p_value"] == pytest.approx(theirs.loc[factor, "Pr > F"])
        assert ours.loc[factor, "dof_error"] == theirs.loc[factor, "Den DF"] == 7


def test_the_pooled_effect_is_that_of_a_mixed_model():
    table = synthetic_demands(motions=12)
    # a motion that is felt in all cells, so that its variance is not at its bound of zero
    felt = 0.01 * table["motion_id"].str[1:].astype(float) * (table["friction"] == 0.5)
    table["deck_disp_m"] *= np.exp(felt)
    keys = ["motion_id", "skew_deg", "gap_mm"]
    pairs = table.pivot_table("deck_disp_m", keys, "friction").reset_index()
    pairs["change"] = np.log(pairs[0.5] / pairs[0.0])
    mixed = smf.mixedlm(
        "change ~ C(skew_deg, Sum)*C(gap_mm, Sum)", pairs, groups=pairs["motion_id"]
    ).fit()
    effects = paired_effects(table, ["deck_disp_m"])
    ours = effects[(effects["axis"] == "friction") & (effects["scope"] == "pooled")].iloc[0]
    assert np.log(ours["ratio"]) == pytest.approx(mixed.params["Intercept"], rel=1e-6)
    reach = np.log(ours["ci_high"] / ours["ratio"]) / stats.t.ppf(0.95, 11)
    assert reach == pytest.approx(mixed.bse["Intercept"], rel=1e-4)


def test_system_of_five_agrees_with_simulation():
    size = 5
    correlation = np.full((size, size), 0.5) + 0.5 * np.eye(size)
    joint = JointDemand(
        theta=np.array([0.5, 0.6, 0.7, 0.9, 1.2]), beta=np.full(size, 0.5), correlation=correlation
    )
    im = np.array([0.3, 0.5, 0.8])
    found = series_system(im, joint)
    z = np.log(im[:, None] / joint.theta) / joint.beta
    normal = stats.multivariate_normal(mean=np.zeros(size), cov=correlation, seed=1)
    assert found == pytest.approx(1 - normal.cdf(-z), abs=3e-5)  # scipy's own is 1e-5
