"""Tests of a fit whose p-values are simulated, for ``skewbridge fit --goodness``."""

from dataclasses import replace

import numpy as np

from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.parts import SimulatedTests
from skewbridge.fragility.methods.goodness import (
    ProbitStripes,
    deviance_p_value,
    isotonic_p_value,
    lilliefors,
)


def with_stripe_tests(
    fit: FragilityFit, im: FloatArray, n: FloatArray, k: FloatArray
) -> FragilityFit:
    """Add the tests of a probit fit to stripes against its own samples; others stay as they are.

    The deviance is tested where a level has several runs, the curve against any increasing one
    always.
    """
    line, goodness = fit.predictor, fit.goodness
    if fit.status != FITTED or line is None or goodness is None or line.link != "probit":
        return fit
    levels, index = np.unique(im[n > 0.0], return_inverse=True)
    runs, exceed = (np.bincount(index, values[n > 0.0]) for values in (n, k))
    fitted = ProbitStripes(
        ln_im=np.log(levels), n=runs, params=np.array([line.a0, line.a1], dtype=np.float64)
    )
    ratio, p = isotonic_p_value(fitted, exceed, goodness.loglik_kernel)
    grouped = np.max(runs) > 1.0 and levels.size == np.sum(n > 0.0)
    tests = SimulatedTests(
        deviance_p_simulated=deviance_p_value(fitted, goodness.deviance) if grouped else None,
        isotonic_lr=ratio,
        isotonic_p=p,
    )
    return replace(fit, tests=tests)


def with_normal_test(fit: FragilityFit, x: FloatArray, y: FloatArray) -> FragilityFit:
    """Add Lilliefors' test of the residuals of y = ln demand about the line on x = ln intensity."""
    if fit.line is None or np.isnan(fit.line.sigma):
        return fit
    return with_lilliefors(fit, y - fit.line.ln_a - fit.line.b * x)


def with_lilliefors(fit: FragilityFit, values: FloatArray) -> FragilityFit:
    """Add Lilliefors' test that values (ln capacities, residuals) are normal; four or more."""
    if values.size < 4 or np.ptp(values) <= 1e-12:
        return fit
    found = lilliefors(values)
    tests = SimulatedTests(
        lilliefors_d=found.distance,
        lilliefors_d_05=found.critical_05,
        lilliefors_d_10=found.critical_10,
        lilliefors_p=found.p_value,
    )
    return replace(fit, tests=tests)
