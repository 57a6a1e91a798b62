"""Single fits: degenerate data, intervals by hand, jackknife by motion, systems, further axes."""

import numpy as np
import pytest
from scipy import optimize, stats

from fragility_tables import IM, SETTINGS, STATES, models_of, states_of, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility import fits, likelihood
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.fits import fit_cloud, fit_stripes
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.motion_means import motion_weights
from skewbridge.fragility.system import averaged, difference, system_curves, system_members

ONE = {"skews": (0,), "gaps": (51,), "frictions": (50,)}
DEMAND = "deck_disp_m"


@pytest.mark.parametrize(
    ("k", "status"),
    [([0, 7, 20, 20], "quasi_separation"), ([0, 3, 12, 20], "ok"), ([0, 0, 1, 0], "ok")]
    + [(k, "non_increasing") for k in ([20, 20, 0, 0], [20, 9, 0, 0], [15, 12, 9, 3], [10] * 4)],
)
def test_every_kind_of_stripes_has_its_status(k, status):
    fit = fit_stripes([0.2, 0.4, 0.6, 0.8], [20] * 4, k)
    assert fit.status == status
    assert np.isnan(fit.theta) == (status != "ok")


def test_separated_data_have_firth_estimates_and_bounds_of_the_likelihood():
    fit = fit_stripes([0.3, 0.5, 0.8], [20] * 3, [0, 7, 20])
    assert fit.details["firth"] == pytest.approx({"theta": 0.53463, "beta": 0.19540}, abs=1e-5)
    assert fit.details["theta_interval"] == pytest.approx([0.5, 0.5])
    # with two levels the fit is saturated: the penalised counts are (k + c)/(n + 2c) at both
    a0, a1 = fits.firth(np.log([0.3, 0.6]), np.array([10.0, 10]), np.array([0.0, 10]))
    assert (np.exp(-a0 / a1), 1 / a1) == pytest.approx((0.424264, 0.188502), abs=1e-5)
    x, n = np.array([-0.37, -0.31, -0.16, 0.08, 0.14, 0.36]), np.full(6, 1000.0)
    a0, a1 = fits.firth(x, n, np.where(x > 0.0, n, 0.0))
    assert -0.16 < -a0 / a1 < 0.08
    assert 0.0 < a1 < 100.0
    im = np.array([0.2, 0.3, 0.5, 0.7, 0.9])
    details = fit_stripes(im, np.ones(5), [0, 0, 0, 1, 1]).details
    low, high = details["theta_bound_low"], details["theta_bound_high"]
    assert details["theta_interval"] == pytest.approx([0.5, 0.7])
    assert low < 0.5 < 0.7 < high

    def loglik(theta):
        p = stats.norm.cdf(np.log(im / theta) / 0.4)
        return np.sum(np.log(np.where(im > 0.6, p, 1 - p)))

    best = max(loglik(theta) for theta in np.geomspace(0.3, 1.2, 2000))
    for end in (low, high):
        assert 2 * (best - loglik(end)) == pytest.approx(1.6449**2, rel=1e-3)


def test_stripes_without_runs_and_medians_beyond_them_have_warnings():
    fit = fit_stripes([0.2, 0.5, 0.8, 1.1], [0, 20, 20, 20], [0, 7, 12, 17])
    assert (fit.warnings[0], fit.n_runs) == ("stripes_without_runs", 60)
    fit = fit_stripes([1.0, 1.5, 2.0], [60, 48, 45], [0, 2, 2])
    assert {"median_extrapolated", "wide_ci"} <= set(fit.warnings)
    with pytest.raises(InputError, match="k must be whole"):
        fit_stripes([0.2, 0.4], [20, 20], [0.4, 4.0])


def test_ends_of_the_profile_of_a_state_are_those_of_a_direct_search():
    """States whose intercepts nearly coincide: one run lies between them."""
    rng, ln_im = np.random.default_rng(3), np.linspace(-2.0, 0.5, 30)
    latent = ln_im + 0.7 * rng.normal(size=30)
    passed = np.digitize(latent, np.sort(latent)[[15, 25, 26]])
    eye = -np.eye(3)
    kernel = likelihood.NormalKernel(
        eye[np.minimum(passed, 2)], np.where(passed == 3, -np.inf, ln_im),
        np.where(passed > 0, ln_im, np.inf), upper_covariates=eye[np.maximum(passed - 1, 0)],
    )  # fmt: skip
    best = likelihood.maximise(kernel, np.array([[1.0, -0.5, -0.7, 1.0]]))
    drop, first = likelihood.drop_of(0.95), best.params[0]
    ends = likelihood.profile_ends(kernel, best, drop, np.eye(4)[:-1], slope=3)[:-1]
    finite = [(state, end) for state, own in enumerate(ends) for end in own if np.isfinite(end)]
    assert len(finite) >= 5
    for state, end in finite:

        def excess(others, state=state, end=end):
            params = np.insert(others, state, -others[-1] * end)
            return 2.0 * float(best.loglik[0] - kernel.derivatives(params[None]).loglik[0])

        shift = -end * first[-1] - first[state]
        start = np.delete(first + shift * np.array([1.0, 1.0, 1.0, 0.0]), state)
        how = {"method": "Nelder-Mead", "options": {"xatol": 1e-8, "fatol": 1e-9}}
        assert optimize.minimize(excess, start, **how).fun == pytest.approx(drop, abs=1e-4)


def test_brackets_take_the_first_crossing_and_need_information():
    im, record = np.tile([0.2, 0.4, 0.6], 3), np.repeat([0, 1, 2], 3)
    hit = np.array([0, 1, 0, 0, 0, 0, 1, 1, 1.0])
    fit = fits.fit_first_exceedances(im, hit, record, SETTINGS)
    assert fit.theta == fits.fit_brackets([0.2, 0.6, 0.0], [0.4, np.inf, 0.2]).theta
    assert fit.details["n_non_monotone"] == 1
    for last, status in ((0.9, "unbounded_likelihood"), (1.4, "ok")):
        assert fits.fit_capacities([1.0, 1.0, last], [0, 0, 1]).status == status
    for low, high, status in (
        ([0.4, 0.4], [0.7, 0.7], "complete_separation"),
        ([0.4, 0.7], [0.7, 1.0], "quasi_separation"),
        ([0.0, 0.0], [0.7, 1.0], "all_exceed"),
        ([0.7, 1.0], [None, None], "all_censored"),
        ([0.0, 1.2], [0.7, None], "non_increasing"),
    ):
        assert fits.fit_brackets(low, high).status == status


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_distance_from_a_normal_sample_is_that_of_either_side(sign):
    values = sign * np.random.default_rng(2).exponential(size=25)
    scaled = (values - values.mean()) / values.std(ddof=1)
    assert fits.lilliefors(values)[0] == pytest.approx(stats.kstest(scaled, "norm").statistic)


@pytest.mark.parametrize(("k", "n"), [(1, 20), (7, 20), (19, 20), (2, 3)])
def test_limits_of_a_proportion_are_those_of_the_exact_binomial_test(k, n):
    low, high = fits.clopper_pearson(np.array([float(k)]), np.array([float(n)]), 0.9)
    expected = stats.binomtest(k, n).proportion_ci(0.9, method="exact")
    assert (low[0], high[0]) == pytest.approx((expected.low, expected.high))


def test_flat_falling_and_exact_clouds_are_refused():
    rng = np.random.default_rng(1)
    im, noise = np.exp(rng.uniform(-2, 0, 12)), np.exp(rng.normal(size=12))
    assert fit_cloud(im, 0.02 * noise, 0.03).status in {"slope_not_significant", "non_increasing"}
    assert fit_cloud([0.3, 0.3, 0.3], [0.01, 0.02, 0.03], 0.02).status == "single_level"
    assert fit_cloud([0.3, 0.4], [0.01, 0.02], 0.02).status == "too_few_runs"
    assert fit_cloud(im, 0.02 * im, 0.01).status == "zero_dispersion"
    edp = [0.01, 0.02, 0.03, 0.02, 0.05, 0.05]
    upper, alone = [*edp[:4], np.inf, np.inf], [0.3, 0.3, 0.3, 0.3, 0.6, 0.9]
    assert fit_cloud(alone, edp, 0.03, upper).status in {"too_few_runs", "single_level"}
    assert fit_cloud(np.exp([0.0, 0.5, 1.0]), [0.01, 0.0171, 0.03], 0.03).status == "ok"


@pytest.mark.parametrize("side", ["above", "below"])
def test_censoring_removes_the_bias_of_clipped_demands(side):
    rng = np.random.default_rng(4)
    im = np.exp(rng.uniform(-2.3, 0.4, 400))
    edp = 0.03 * im * np.exp(0.4 * rng.normal(size=400))
    if side == "above":
        lower, upper = np.minimum(edp, 0.02), np.where(edp < 0.02, edp, np.inf)
    else:
        lower, upper = np.where(edp > 0.008, edp, 0.0), np.maximum(edp, 0.008)
    censored = fit_cloud(im, lower, 0.015, upper)
    assert censored.ci_theta[0] < 0.5 < censored.ci_theta[1]
    assert censored.ci_beta[0] < 0.4 < censored.ci_beta[1]
    clipped = fit_cloud(im, lower if side == "above" else upper, 0.015)
    assert clipped.details["b"] < 0.85 < censored.details["b"]


def test_variance_of_beta_is_that_of_slope_and_scatter():
    """beta = s/b of independent s and b: var beta / beta^2 = 1/[2(n - 2)] + var b / b^2."""
    rng, im = np.random.default_rng(3), np.exp(np.linspace(-4.0, 0.5, 60))
    edp = 0.03 * im**1.5 * np.exp(0.3 * rng.normal(size=60))
    line = stats.linregress(np.log(im), np.log(edp))
    relative = 1.0 / (2.0 * (60 - 2)) + (line.stderr / line.slope) ** 2
    fit = fit_cloud(im, edp, 0.03 * np.exp(-4.5))
    assert fit.var_beta / fit.beta**2 == pytest.approx(relative, rel=1e-6)


def test_the_profile_of_a_line_is_that_of_student_where_hardly_anything_is_censored():
    rng = np.random.default_rng(3)
    im = np.exp(rng.uniform(-2, 0.5, 40))
    edp = 0.02 * im * np.exp(0.3 * rng.normal(size=40))
    plain = fit_cloud(im, edp, 0.02)
    # a run known to lie above next to nothing does not count
    far = fit_cloud(np.append(im, 1.0), np.append(edp, 1e-9), 0.02, np.append(edp, np.inf))
    assert far.ci_theta == pytest.approx(plain.ci_theta, rel=1e-6)
    assert far.beta == pytest.approx(plain.beta * np.sqrt(38 / 40), rel=1e-6)


@pytest.mark.parametrize(("bend", "names"), [(-0.2, ["saturating"]), (0.2, ["curved"]), (0, [])])
def test_a_bent_line_has_a_warning(bend, names):
    x = np.linspace(-2, 1, 40)
    noise = 0.05 * np.tile([1.0, -1.0], 20)
    assert fits.tested_line(x, 1.1 * x + bend * x**2 + noise).warnings == names


def test_weights_leave_out_one_motion_or_group_at_a_time():
    weights = motion_weights(np.array([4, 4, 7, 9]))
    assert weights.tolist() == [[1, 1, 1, 1], [0, 0, 1, 1], [1, 1, 0, 1], [1, 1, 1, 0]]
    rng = np.random.default_rng(8)
    motions, scatter = np.repeat(np.arange(400), 2), rng.normal(size=400)
    weights = motion_weights(motions)
    assert weights.shape == (101, 800)
    assert np.all(np.sum(weights[1:] == 0.0, axis=0) == 1)
    np.testing.assert_array_equal(weights[:, 0::2], weights[:, 1::2])
    im = np.exp(rng.uniform(-2.0, 0.5, 800))
    edp = 0.02 * im * np.exp(0.3 * scatter[motions] + 0.1 * rng.normal(size=800))
    fit = fit_cloud(im, edp, 0.01, motions=motions)
    x, y = np.log(im), np.log(edp)
    rest = [motions != motion for motion in range(400)]
    without = [fits.cloud_line(x[rows], y[rows], y[rows], tobit=False) for rows in rest]
    without = np.array([(np.log(0.01) - ln_a) / b for ln_a, b, _ in without])
    error = np.sqrt(399 / 400 * np.sum((without - without.mean()) ** 2))
    assert fit.as_json()["se_ln_theta"] == pytest.approx(error, rel=0.15)
    assert fit_cloud(im, edp, 0.01, motions=np.arange(800)).ci_method == "fieller"
    # a replicate without a slope has no line
    flat = np.array([-1.0, 0.0, 2.0, 3.0]), np.zeros(4), np.zeros(4)
    assert np.all(np.isnan([fits.cloud_line(*flat, tobit=tobit) for tobit in (False, True)]))


def test_intervals_by_motion_are_those_of_the_jackknife_written_out():
    table = synthetic_demands(**ONE, scales=(0.5, 1.0, 2.0), motions=12)
    codes = np.unique(table["motion_id"], return_inverse=True)[1]
    fit = fit_cloud(table[IM], table[DEMAND], 0.15, motions=codes)
    logs = np.log(table[[IM, DEMAND]].to_numpy())
    fitted = [np.polyfit(*logs[codes != motion].T, 1) for motion in range(12)]
    values = np.array([(np.log(0.15) - ln_a) / b for b, ln_a in fitted])
    squares = np.square(values - np.log(fit.theta))
    assert fit.ci_method == "jackknife"
    # degrees of freedom: M - 2, or less if few motions have most of the variance
    freedom = min(10.0, 3.0 * np.sum(squares) ** 2 / np.sum(squares**2))
    reach = stats.t.ppf(0.975, freedom) * np.sqrt(11 / 12 * np.sum(squares))
    assert fit.ci_theta[1] / fit.theta == pytest.approx(np.exp(reach))


def systems(table, states=STATES):
    return system_curves(models_of(table, states), states, SETTINGS).set_index("limit_state")


def test_a_system_has_a_bound_or_no_curve_if_one_of_its_components_has():
    table = synthetic_demands(**ONE, motions=30)
    table["bearing_disp_m"] += 1.0
    found = systems(table)
    assert found.loc["moderate", ["status", "n_exceed"]].tolist() == ["all_exceed", 30]
    assert np.isnan(found.loc["moderate", "theta"])
    # below 0.5 in all of 30 runs: the median is hardly above the weakest of them
    assert found.loc["moderate", "theta_bound"] == pytest.approx(table[IM].min(), rel=0.15)
    assert found.loc["moderate", "left_out"].startswith("bearing: exceeded in every run")
    assert found.loc["extensive", "status"] == "ok"
    models = models_of(synthetic_demands(**ONE, motions=30), STATES)
    curves = fit_study(models, STATES, SETTINGS)
    plain = system_curves(models, STATES, SETTINGS).set_index("limit_state")
    at = system_curves(models, STATES, SETTINGS, curves=curves).set_index("limit_state")
    assert set(at["withheld"]) == {""}
    # the deck decides nothing, unless its median could be far smaller; the bearing always does
    for component, bound, status in (
        *(("deck_displacement", 0.9, "ok"), ("deck_displacement", 0.1, "bounds_too_wide")),
        *(("deck_displacement", np.nan, "bounds_too_wide"), ("bearing", 1.0, "bounds_too_wide")),
    ):
        is_lost = (curves["component"] == component) & (curves["status"] == "ok")
        lost = curves.assign(status=curves["status"].mask(is_lost, "bounds_too_wide"))
        lost.loc[is_lost, "theta_all_exceed"] *= bound
        found = system_curves(models, STATES, SETTINGS, curves=lost).set_index("limit_state")
        assert found.loc["moderate", ["status", "withheld"]].tolist() == [status, component]
        same = found["status"] == "ok"
        assert found.loc[same, "theta"].tolist() == plain.loc[same, "theta"].tolist()
        assert found.loc[~same, "theta"].isna().all()
        assert found.loc["extensive", ["status", "withheld"]].tolist() == ["ok", ""]


def test_a_mean_over_pairs_of_systems_has_the_components_of_most_pairs():
    names = ("a;b", "a;b"), ("a", "a"), ("a;b;c", "a;b;c"), ("a;b", "a"), ("a;b", "a;b"), ("", "")
    pairs = [({"variant": "v", "components": one}, {"variant": "w", "components": other})
             for one, other in names]  # fmt: skip
    assert averaged(pairs) == [True, False, False, False, True, False]
    # of as many pairs, those with more components
    assert (averaged(pairs[:4]), averaged(pairs[3:4])) == ([False, False, True, False], [False])
    assert (difference(*pairs[3]), difference(*pairs[0])) == ("only v: b", "")


def test_a_system_is_weaker_than_its_weakest_component_and_equals_a_single_one():
    system = systems(synthetic_demands(**ONE, motions=30))
    assert set(system.index) == {"slight", "moderate", "extensive", "complete"}
    usable = system[system["status"] == "ok"]
    assert len(usable) >= 2
    assert (usable["theta_independent"] <= usable["theta"] * 1.01).all()
    assert (usable["theta"] <= usable["theta_correlated"] * 1.002).all()
    table = synthetic_demands(**ONE, motions=40)
    mild, *_, severe = states_of("column_drift")
    found, undamaged = (systems(table, [state]).iloc[0] for state in (mild, severe))
    fit = fit_cloud(table[IM], table["column_drift_ratio"], 0.01, capacity_dispersion=0.35)
    assert (found["theta"], found["beta"]) == pytest.approx((fit.theta, fit.beta), rel=5e-3)
    assert undamaged["status"] in {"no_component", "no_exceedance"}
    assert np.isnan(undamaged["theta"])


def test_a_system_has_no_secondary_component_beyond_moderate_damage():
    members = system_members([state for state in STATES if state.system_degree])
    taken = {name: {s.component: s.name for s in own} for name, own in members.items()}
    assert list(taken) == ["slight", "moderate", "extensive", "complete"]
    secondary = {"shear_key", "bearing", "abutment_passive", "deck_displacement"}
    for degree in ("extensive", "complete"):
        assert secondary.isdisjoint(taken[degree])
    drift = states_of("column_drift")
    turned = [
        LimitState(component="other", name=n, demand=s.demand, threshold=s.threshold, dispersion=0)
        for s, n in zip(drift, ("moderate", "slight"), strict=False)
    ]
    with pytest.raises(InputError, match="rank the damage degree"):
        system_members([*drift[:2], *turned])


def test_a_system_names_the_components_without_a_line_and_the_reason():
    table = synthetic_demands(**ONE, motions=24)
    table["bearing_disp_m"] = 0.015 / table[IM]
    table["abutment_passive_m"] = np.nan
    found = systems(table).loc["slight"]
    assert found["status"] == "ok"
    assert "bearing: demand does not grow" in found["left_out"]
    assert "abutment_passive: too few complete runs" in found["left_out"]
