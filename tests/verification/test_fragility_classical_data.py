"""Classical data sets that anybody may print: beetles, locomotives, Norris."""

import numpy as np
import pytest
from scipy import stats

from skewbridge.fragility.fits import fit_brackets, fit_capacities, fit_cloud, fit_stripes

# source: Bliss (1935), Annals of Applied Biology 22:134-167, log10 dose of carbon disulphide
BLISS_LOG10 = [1.6907, 1.7242, 1.7552, 1.7842, 1.8113, 1.8369, 1.8610, 1.8839]
BLISS_N = [59, 60, 62, 56, 63, 59, 62, 60]
BLISS_K = [6, 13, 18, 28, 52, 53, 61, 60]
# source: Nelson (1982), Applied Life Data Analysis: thousand miles to failure of locomotive
# controls, 37 failures of 96, the others taken off test at 135
LOCOMOTIVES = [
    22.5, 37.5, 46, 48.5, 51.5, 53, 54.5, 57.5, 66.5, 68, 69.5, 76.5, 77, 78.5, 80, 81.5, 82, 83,
    84, 91.5, 93.5, 102.5, 107, 108.5, 112.5, 113.5, 116, 117, 118.5, 119, 120, 122.5, 123, 127.5,
    131, 132.5, 134,
]  # fmt: skip
# source: NIST StRD, Norris, certified values
NORRIS_X = [
    0.2, 337.4, 118.2, 884.6, 10.1, 226.5, 666.3, 996.3, 448.6, 777.0, 558.2, 0.4, 0.6, 775.5,
    666.9, 338.0, 447.5, 11.6, 556.0, 228.1, 995.8, 887.6, 120.2, 0.3, 0.3, 556.8, 339.1, 887.2,
    999.0, 779.0, 11.1, 118.3, 229.2, 669.1, 448.9, 0.5,
]  # fmt: skip
NORRIS_Y = [
    0.1, 338.8, 118.1, 888.0, 9.2, 228.1, 668.5, 998.5, 449.1, 778.9, 559.2, 0.3, 0.1, 778.1,
    668.8, 339.3, 448.9, 10.8, 557.7, 228.3, 998.0, 888.8, 119.6, 0.3, 0.6, 557.6, 339.3, 888.0,
    998.5, 778.9, 10.2, 117.6, 228.9, 668.4, 449.2, 0.2,
]  # fmt: skip


def test_beetle_mortality_gives_the_probit_of_the_textbooks():
    fit = fit_stripes(np.power(10.0, BLISS_LOG10), BLISS_N, BLISS_K)
    # Dobson prints -34.935 + 19.728 log10 dose, deviance 10.12; the dose is rounded to 4 digits
    assert fit.details["a0"] == pytest.approx(-34.935, abs=2e-3)
    assert fit.details["a1"] * np.log(10.0) == pytest.approx(19.728, abs=1e-3)
    assert fit.details["deviance"] == pytest.approx(10.12, abs=0.01)


def test_locomotive_controls_give_the_published_lognormal():
    capacity = [*LOCOMOTIVES, *[135.0] * 59]
    fit = fit_capacities(capacity, [0] * 37 + [1] * 59)
    # SAS LIFEREG prints 5.1169 and 0.7055
    assert np.log(fit.theta) == pytest.approx(5.1169, abs=5e-5)
    assert fit.beta == pytest.approx(0.7055, abs=5e-5)


def test_locomotive_controls_agree_with_scipy():
    data = stats.CensoredData(uncensored=LOCOMOTIVES, right=[135.0] * 59)
    shape, _, scale = stats.lognorm.fit(data, floc=0)
    fit = fit_capacities([*LOCOMOTIVES, *[135.0] * 59], [0] * 37 + [1] * 59)
    assert fit.theta == pytest.approx(scale, rel=1e-4)  # scipy stops its simplex at 1e-4
    assert fit.beta == pytest.approx(shape, rel=1e-4)


def test_norris_line_has_the_certified_digits():
    fit = fit_cloud(np.exp(np.array(NORRIS_X) / 200), np.exp(np.array(NORRIS_Y) / 200), 1.0)
    assert fit.line.b == pytest.approx(1.00211681802045, rel=1e-10)
    assert fit.line.ln_a * 200 == pytest.approx(-0.262323073774029, rel=1e-9)
    assert fit.line.sigma * 200 == pytest.approx(0.884796396144373, rel=1e-9)


def test_same_motions_on_every_stripe_widen_the_error_by_half():
    # own data: 20 capacities seen through 5 stripes
    stripes = np.array([0.4, 0.7, 1.0, 1.3, 1.6])
    lower = [0.4] * 3 + [0.7] * 6 + [1.0] * 5 + [1.3] * 3 + [1.6] * 3
    upper = [0.7] * 3 + [1.0] * 6 + [1.3] * 5 + [1.6] * 3 + [np.inf] * 3
    right = fit_brackets(lower, upper)
    naive = fit_stripes(stripes, [20] * 5, [0, 3, 9, 14, 17])
    assert right.theta == pytest.approx(1.0591771455, rel=1e-9)
    assert right.beta == pytest.approx(0.3870035450, rel=1e-8)
    assert right.se_ln_theta == pytest.approx(0.0902852127, rel=1e-6)
    assert naive.se_ln_theta == pytest.approx(0.0596347309, rel=1e-6)
