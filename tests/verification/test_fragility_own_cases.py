"""Made-up stripes of the kinds met in studies; the expected values come from statsmodels and scipy.

Errors of estimates are those of the observed information. Tolerances: 1e-6 on estimates, 1e-4 on
standard errors (differentiated numerically), 1e-5 on the ends of intervals.
"""

import numpy as np
import pytest
import statsmodels.api as sm
from scipy import optimize, stats

from skewbridge.fragility.fits import fit_stripes


def _many_bins():
    """Many bins with few runs at the upper end, as of analyses binned by intensity."""
    rng = np.random.default_rng(11)
    im = np.arange(1.0, 80.0, 2.0)
    n = np.maximum(1, rng.poisson(150.0 * np.exp(-im / 11.0)))
    return im, n, rng.binomial(n, stats.norm.cdf(np.log(im / 27.0) / 0.6))


STRIPES = {
    "low stripes only": (
        [0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0],
        [40] * 8,
        [0, 0, 1, 3, 8, 11, 13, 18],
    ),
    "full range": ([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8], [20] * 8, [0, 1, 2, 7, 9, 15, 16, 19]),
    "sparse tail": ([1.0, 1.5, 2.0], [60, 48, 45], [0, 2, 2]),
    "many bins": _many_bins(),
}


class ProbitOracle:
    """Log-likelihood of stripes in (ln theta, beta), and its profiles."""

    def __init__(self, im, n, k):
        self.x, self.n, self.k = np.log(im), np.asarray(n), np.asarray(k)
        self.model = sm.GLM(
            np.column_stack([self.k, self.n - self.k]),
            sm.add_constant(self.x),
            family=sm.families.Binomial(link=sm.families.links.Probit()),
        )
        self.fit = self.model.fit(tol=1e-15, maxiter=300)
        a0, a1 = self.fit.params
        self.best = np.array([-a0 / a1, 1.0 / a1])

    def kernel(self, a0, a1):
        eta = a0 + a1 * self.x
        return float(
            np.sum(self.k * stats.norm.logcdf(eta) + (self.n - self.k) * stats.norm.logsf(eta))
        )

    def covariance(self):
        a0, a1 = self.fit.params
        cov = np.linalg.inv(-self.model.hessian(self.fit.params, observed=True))
        jacobian = np.array([[-1.0 / a1, a0 / a1**2], [0.0, -1.0 / a1**2]])
        return jacobian @ cov @ jacobian.T

    def ends(self, profile, best, outer):
        """Return where a profile falls by half the 95 % quantile; infinite where it never does."""
        limit = self.kernel(*self.fit.params) - 0.5 * stats.chi2.ppf(0.95, 1)
        found = []
        for end in outer:
            inside = profile(end) > limit
            found.append(
                np.sign(end - best) * np.inf
                if inside
                else optimize.brentq(lambda at: profile(at) - limit, best, end, xtol=1e-12)
            )
        return found

    def theta_ends(self):
        def profile(ln_theta):
            def loss(slope):
                return -self.kernel(-slope * ln_theta, slope)

            found = optimize.minimize_scalar(
                loss, bounds=(1e-9, 30.0), method="bounded", options={"xatol": 1e-10}
            )
            return -found.fun

        return np.exp(self.ends(profile, self.best[0], self.best[0] + np.array([-8.0, 8.0])))

    def beta_ends(self):
        def profile(slope):
            def loss(a0):
                return -self.kernel(a0, slope)

            return -optimize.minimize_scalar(loss, bracket=(-3.0, 0.0), tol=1e-12).fun

        slope = 1.0 / self.best[1]
        low, high = self.ends(profile, slope, (1e-9, 30.0))
        return [1.0 / high, np.inf if np.isinf(low) else 1.0 / low]


@pytest.mark.parametrize("name", STRIPES)
def test_stripes_agree_with_an_independent_likelihood(name):
    im, n, k = (np.asarray(values, dtype=float) for values in STRIPES[name])
    fit, oracle = fit_stripes(im, n, k), ProbitOracle(im, n, k)
    cov = oracle.covariance()
    assert fit.status == "ok"
    assert (np.log(fit.theta), fit.beta) == pytest.approx(oracle.best, rel=1e-6)
    assert fit.loglik == pytest.approx(oracle.fit.llf, rel=1e-6)
    assert fit.as_json()["deviance"] == pytest.approx(oracle.fit.deviance, rel=1e-6)
    assert fit.as_json()["pearson"] == pytest.approx(oracle.fit.pearson_chi2, rel=1e-6)
    assert fit.as_json()["aic"] == pytest.approx(oracle.fit.aic, rel=1e-6)
    assert fit.se_ln_theta == pytest.approx(np.sqrt(cov[0, 0]), rel=1e-4)
    assert fit.se_beta == pytest.approx(np.sqrt(cov[1, 1]), rel=1e-4)
    assert fit.cov_ln_theta_beta == pytest.approx(cov[0, 1], rel=1e-4)
    assert fit.ci_theta == pytest.approx(tuple(oracle.theta_ends()), rel=1e-5)
    assert fit.ci_beta == pytest.approx(tuple(oracle.beta_ends()), rel=1e-5)
    if name == "sparse tail":
        assert {"median_extrapolated", "wide_ci"} <= set(fit.warnings)
