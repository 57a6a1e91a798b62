"""Paired effects: means over motions, bounds, verdicts, intensities, needed motions, looks."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
from scipy import optimize, special, stats
from statsmodels.stats.multitest import multipletests

from fragility_tables import IM, friction_rows, paired_effects, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility import verdicts
from skewbridge.fragility.effects import effect_row, effect_table, effect_tables
from skewbridge.fragility.motion_means import Jackknifed, average, bounded_regression, by_motion
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import DESCRIPTIONS
from skewbridge.variant.variant import ABUTMENTS

DEMAND = "deck_disp_m"
MODEL = ["bridge", "abutment"]
POWER_ROW = {"judged_by": "ratio", "margin": 0.05, "level": 0.9}
LOOKS = tuple(range(12, 65, 4))


def friction(effects, demand=DEMAND, scope="variant"):
    return effects.query("demand == @demand and axis == 'friction' and scope == @scope")


def friction_cell(table, demand=DEMAND, settings=None):
    return friction(paired_effects(table, [demand], settings or FitSettings()), demand).iloc[0]


def pairs(ln_ratios, **options) -> pd.DataFrame:
    """Return a study of two variants, friction 0 and 0.5, with these ratios of a demand."""
    same = {"skews": (0,), "gaps": (25,), "run_scatter": 0.0}
    table = synthetic_demands(motions=len(ln_ratios), **same, **options)
    rough = table["friction"] > 0.0
    table.loc[rough, DEMAND] = table.loc[~rough, DEMAND].to_numpy() * np.exp(ln_ratios)
    return table


def rows_of(ratios, errors, *, dof=15, margin=0.05, level=0.9, axis="friction", demand="other"):
    reach = stats.t.ppf(0.5 + level / 2, dof) * np.asarray(errors)
    names = ("difference", "difference_low", "difference_high", "difference_margin")
    same = {"bridge": "osb1", "abutment": "contact", "axis": axis, "demand": demand}
    same |= {"scope": "pooled", "quantity": "demand", "judged_by": "ratio", "n_pairs": 16}
    same |= {"n_discordant": 0, "level": level, "margin": margin, "dof": dof}
    ends = {"ci_low": ratios * np.exp(-reach), "ci_high": ratios * np.exp(reach)}
    return pd.DataFrame({"ratio": ratios} | ends).assign(**same, **dict.fromkeys(names, np.nan))


def test_interval_of_a_ratio_is_that_of_student():
    values = np.array([0.10, 0.02, 0.07, 0.16, 0.05])
    row = friction_cell(pairs(values))
    reach = 2.131847 * values.std(ddof=1) / np.sqrt(5)  # t of 4 degrees of freedom at 0.95
    ends = values.mean() + np.array([-reach, reach])
    assert np.log([row["ci_low"], row["ci_high"]]) == pytest.approx(ends, rel=1e-5)
    assert row["scatter"] == pytest.approx(values.std(ddof=1))
    # replicates without one motion give the same interval as values
    values = np.array([0.1, 0.4, 0.2, 0.7, 0.3])
    without = [np.delete(values, k).mean() for k in range(5)]
    replicates = np.array([values.mean(), *without[:3], values.mean(), *without[3:]])
    present = np.array([True, True, True, False, True, True])  # the fourth motion has no value
    mean = Jackknifed.of(replicates, present, present, 1)
    assert mean.interval(0.95) == pytest.approx(stats.t.interval(0.95, 4, 0.34, stats.sem(values)))


def test_means_count_a_motion_once_and_cells_with_the_error_of_the_averaged_motions():
    values, motions = np.array([0.1, 0.3, 0.2, 0.6, 0.5, 0.7]), np.array([0, 0, 1, 2, 2, 4])
    mean = by_motion(values, np.zeros(6, dtype=int), motions, 5)
    own = np.array([0.2, 0.2, 0.55, 0.7])
    assert (mean.estimate, mean.error) == pytest.approx((own.mean(), stats.sem(own)))
    assert (mean.influence[3], mean.dof) == (0.0, 3)
    rng = np.random.default_rng(1)
    table = 0.1 * rng.normal(size=(12, 3)) + rng.normal(size=(12, 1))
    none, motions = np.zeros(12, dtype=int), np.arange(12)
    cells = [by_motion(values, none, motions, 12) for values in table.T]
    empty = by_motion(np.zeros(0), none[:0], motions[:0], 12)
    expected = stats.t.interval(0.9, 11, table.mean(), stats.sem(table.mean(axis=1)))
    assert average([*cells, empty]).interval(0.9) == pytest.approx(expected)
    assert np.isnan(average([empty]).estimate)


def ratio_of_means(slope_scatter):
    """Return pairs of values (400, 2) and the jackknife of the ratio of their means."""
    scatter = np.array([0.15, slope_scatter]) * np.sqrt(400.0)
    normals = np.random.default_rng(5).normal(size=(400, 2))
    values = [0.3, 1.0] + (scatter * normals) @ [[1, 0.4], [0, 1]]
    means = np.vstack([values.mean(axis=0), (values.sum(axis=0) - values) / 399.0])
    return values, Jackknifed.of_ratio(means[:, 0] / means[:, 1], np.log(means[:, 1]), 0)


def test_interval_of_a_ratio_is_that_of_fieller_and_has_it_at_every_look():
    assert ratio_of_means(0.7)[1].interval(0.90) == (-np.inf, np.inf)  # the slope may be zero
    values, ratio = ratio_of_means(0.2)
    (shift, slope), covariance = values.mean(axis=0), np.cov(values.T) / 400.0
    t = stats.t.ppf(0.95, ratio.dof)
    # (shift - v slope)^2 = t^2 var(shift - v slope), Fieller (1954)
    variances = covariance[[1, 0, 0], [1, 1, 0]]
    square, product, constant = [slope**2, slope * shift, shift**2] - t**2 * variances
    ends = (product + np.array([-1.0, 1.0]) * np.sqrt(product**2 - square * constant)) / square
    # the jackknife is linear: an error of the order of 1/400
    assert ratio.interval(0.90) == pytest.approx(ends, rel=0.01)
    distances = np.abs(np.array(ratio.interval(0.90)) - ratio.estimate)
    assert max(distances) > 1.2 * min(distances)
    # the p-value is that of shift = 0, whatever the slope is
    t_of_shift = shift / np.sqrt(covariance[0, 0])
    assert ratio.p_value() == pytest.approx(2.0 * stats.t.sf(t_of_shift, ratio.dof), rel=0.02)
    row = friction_rows((0.1, 0.1))[1] | effect_row(ratio, blocks=list("b" * 400))
    table = effect_table(pd.DataFrame(), [row | {"quantity": verdicts.MEDIAN_CAPACITY}])
    for motions in LOOKS:
        now = verdicts.at_looks(table.assign(n_pairs=motions), LOOKS).iloc[0]
        low, high = ratio.interval(now["level"])
        assert np.log([now["ci_low"], now["ci_high"]]) == pytest.approx([low, high], abs=1e-9)


def test_line_without_bounds_is_that_of_least_squares_without_each_motion():
    rng = np.random.default_rng(4)
    x, motions = rng.normal(size=20), np.repeat(np.arange(10), 2)
    y = 0.2 + 0.3 * x + 0.1 * rng.normal(size=20)
    line = by_motion(y, np.zeros(20, dtype=int), motions, 10, x)
    full = np.polyfit(x, y, 1)[::-1]
    assert line.estimate == pytest.approx(full)
    without = [np.polyfit(x[motions != k], y[motions != k], 1)[::-1] for k in range(10)]
    assert line.error == pytest.approx(np.sqrt(0.9 * np.sum((without - full) ** 2, axis=0)))
    assert (line.dof <= 8).all()
    at_half = line.combined(np.array([[1.0], [0.5]]))
    assert at_half.estimate[0] == pytest.approx(full[0] + 0.5 * full[1])
    for same in ([0.0] * 4, [0.0, 0.0, 0.0, 1.0]):  # a replicate has one intensity
        line = by_motion(y[:4], np.zeros(4, dtype=int), np.arange(4), 4, np.array(same))
        assert np.isnan(line.estimate).all()


def test_regression_with_bounds_is_that_of_maximum_likelihood():
    rng = np.random.default_rng(2)
    x = rng.normal(size=400)
    values = rng.normal(0.3, 1.0, 400) + 0.7 * x
    bound = np.select([values > 1.0, values < -1.0], [1, -1], default=0)
    values, design = np.clip(values, -1.0, 1.0), np.column_stack([np.ones(400), x])

    def minus(parameters):
        z = (values - design @ parameters[:-1]) / np.exp(parameters[-1])
        terms = [stats.norm.logsf(z), stats.norm.logcdf(z)]
        exact = stats.norm.logpdf(z) - parameters[-1]
        return -np.sum(np.select([bound == 1, bound == -1], terms, exact))

    best = optimize.minimize(minus, np.zeros(3)).x[:-1]
    coefficients = bounded_regression(design, values, bound, np.ones((1, 400)))[0]
    # the divisor of a sample instead of that of maximum likelihood: 1/400 of the scatter
    assert coefficients == pytest.approx(best, abs=3e-3)


def test_mean_with_a_bound_solves_the_equations_of_truncated_normals():
    exact, bound = np.array([0.2, 0.5, 0.9]), 0.7
    given = np.ones((4, 1)), np.append(exact, bound), np.array([0, 0, 0, 1]), np.ones((1, 4))
    mean = bounded_regression(*given)[0, 0]

    def moments(scatter):
        above = stats.truncnorm((bound - mean) / scatter, np.inf, loc=mean, scale=scatter)
        return float(above.mean()), float(above.var())

    def missing(scatter):
        middle, variance = moments(scatter)
        squares = np.sum((exact - mean) ** 2) + (middle - mean) ** 2 + variance
        return float(scatter**2 - squares / 3)

    scatter = optimize.brentq(missing, 0.05, 5.0)
    assert mean == pytest.approx((np.sum(exact) + moments(scatter)[0]) / 4, rel=1e-6)
    # three agree, one does not, one is a bound: without the fourth only rounding scatters
    values, bound = np.array([0.1, 0.1, 0.1, 0.5, -0.1]), np.array([0, 0, 0, 0, 1])
    mean = by_motion(values, bound, np.arange(5), 5)
    assert mean.estimate - mean.influence[3] * 5 / 4 == pytest.approx(0.1, abs=1e-6)


def test_an_interval_has_the_first_verdict_that_applies():
    intervals = [
        (1.06, 1.2, "higher"), (0.8, 0.94, "lower"), (0.96, 1.04, "negligible"),
        (1.01, 1.04, "negligible"),  # the direction is clear, the size is negligible
        (1.01, 1.2, "detectable"), (0.9, 0.99, "detectable"), (0.96, 1.06, "undecided"),
        (0.9, 1.0, "undecided"),  # an interval that ends at no change does not exclude it
        (np.nan, np.nan, "undecided"),
    ]  # fmt: skip
    low, high, expected = map(np.array, zip(*intervals, strict=True))
    limits, possible = np.full((low.size, 3), [0.95, 1.0, 1.05]).T, np.full(low.size, True)
    assert (verdicts.verdicts_of(low, *limits, high, possible=possible) == expected).all()


@pytest.mark.parametrize(("apart", "verdict"), [(1, verdicts.NEGLIGIBLE), (2, verdicts.DETECTABLE)])
def test_negligible_needs_a_demand_on_both_sides_of_all_but_one_in_twenty(apart, verdict):
    table = pairs(np.full(20, 0.001))
    table.loc[table.index[table["friction"] > 0.0][:apart], DEMAND] = 0.0
    row = friction_cell(table)
    assert (row["n_discordant"], row["verdict"]) == (apart, verdict)


def test_family_wise_verdicts_are_those_of_holm_and_of_the_interval_in_a_family_of_one():
    rng = np.random.default_rng(3)
    ratios, errors = np.exp(rng.normal(0, 0.1, 40)), rng.uniform(0.01, 0.04, 40)
    table = verdicts.with_verdicts(rows_of(ratios, errors))
    below, above = stats.t.cdf(np.log([ratios / 0.95, 1.05 / ratios]) / errors, 15)
    outside = multipletests(np.minimum(below, above), alpha=0.05, method="holm")[0]
    assert 0 < outside.sum() < table["verdict"].isin(["lower", "higher"]).sum()
    assert table["verdict_family"].isin(["lower", "higher"]).tolist() == outside.tolist()
    for ratio in (0.9, 0.97, 1.0, 1.03, 1.06, 1.2):
        row = verdicts.with_verdicts(rows_of([ratio], [0.015])).iloc[0]
        assert row["verdict_family"] == row["verdict"]
    # intervals wider than a factor of ten are not estimable and weaken no family
    clear, wide = rows_of([1.12], [0.03]), rows_of(np.full(50, 6.77), np.full(50, 1.4))
    table = verdicts.with_verdicts(pd.concat([clear, wide], ignore_index=True))
    assert table["verdict_family"].tolist() == ["higher", *["undecided"] * 50]
    assert table["status"].tolist() == ["ok", *["not_estimable"] * 50]
    assert table.loc[1:, ["ratio", "ci_low", "ci_high"]].isna().to_numpy().all()


@pytest.mark.parametrize(
    ("other", "twins", "weakened"),
    [({}, 0, True), ({}, 1, False), ({"axis": "gap_mm"}, 0, False),
     ({"demand": "unseating_m"}, 0, False), ({"demand": "unseating_m"}, 1, True)],
)  # fmt: skip
def test_families_are_split_by_axis_and_headline(other, twins, weakened):
    """The twin is the same claim under the name of a headline demand."""
    clear = rows_of([1.12], [0.03])
    noise = rows_of(np.linspace(0.99, 1.01, 60), np.full(60, 0.2), **other)
    twin = [clear.assign(demand="unseating_m")] * twins
    table = verdicts.with_verdicts(pd.concat([clear, noise, *twin], ignore_index=True))
    assert table["verdict"][0] == "higher"
    assert (table["verdict_family"][0] != "higher") is weakened


def test_effect_of_the_generator_is_found_and_pooled_rows_are_the_average_of_their_cells():
    table, reference = synthetic_demands(), {("osb1", "contact_friction"): 0.4}
    tables = effect_tables(table, reference_im=reference)
    mixed = effect_tables(table.sample(frac=1.0, random_state=1), reference_im=reference)
    pd.testing.assert_frame_equal(tables.effects, mixed.effects)
    pd.testing.assert_frame_equal(tables.intensities, mixed.intensities)
    effects = tables.effects
    assert list(effects.columns) == list(DESCRIPTIONS["effects"])
    assert effects["scope"].is_monotonic_increasing  # pooled rows first
    rotation = friction(effects, "deck_rotation_rad")
    assert rotation["direction"].tolist() == [-1] * 6
    assert rotation["ratio"].to_numpy() == pytest.approx(np.exp(-0.1), abs=0.04)
    pooled = friction(effects, "deck_rotation_rad", "pooled").iloc[0]
    # 96 ratios of 3 % x root 2 scatter: standard error 0.4 %
    assert pooled["ratio"] == pytest.approx(np.exp(-0.1), abs=0.012)
    pooled, cells = friction(effects, scope="pooled").iloc[0], friction(effects)
    assert set(cells["verdict"]) == {"negligible"}
    assert pooled["n_cells"] == len(cells) == 6
    assert np.log(pooled["ratio"]) == pytest.approx(np.log(cells["ratio"]).mean())
    assert pooled["slope"] == pytest.approx(cells["slope"].mean())
    assert pooled["ci_high"] - pooled["ci_low"] < (cells["ci_high"] - cells["ci_low"]).min()


def test_each_bridge_and_abutment_has_the_effects_it_has_alone():
    parts, demands = [], [DEMAND, "unseating_m"]
    for (seed, bridge), (name, traits) in product(enumerate(("osb1", "osb2s")), ABUTMENTS.items()):
        gaps = (0, 25, 51) if "gap_mm" in traits.axes else (0,)
        given = {"gaps": gaps, "frictions": (0, 50) if traits.has_friction else (0,)}
        given |= {"motions": 8, "bridge": bridge, "abutment": name, "seed": seed}
        parts.append(synthetic_demands(**given))
    table = pd.concat(parts, ignore_index=True)
    effects = paired_effects(table, demands)
    axes = effects.groupby(MODEL)["axis"].unique().map(set)
    assert len(axes) == 10
    for (_, abutment), names in axes.items():
        expected = {"skew_deg"} | ({"gap_mm"} if abutment != "roller" else set())
        assert names == expected | ({"friction"} if abutment == "contact_friction" else set())
    one = "bridge == 'osb2s' and abutment == 'spring'"
    own, alone = effects.query(one), paired_effects(table.query(one), demands)
    pd.testing.assert_frame_equal(alone, own.reset_index(drop=True), check_dtype=False)
    needed = verdicts.needed_motions(effects, table)
    assert set(map(tuple, needed[MODEL].to_numpy())) == set(axes.index)


def test_zeros_are_left_out_and_counted_and_ended_runs_are_bounds():
    table = synthetic_demands(skews=(0,), gaps=(51,))
    table.loc[[0, 1], "status"] = ["timeout", "collapse"]
    table.loc[2, DEMAND] = 0.0
    row = friction_cell(table)
    assert row[["n_motions", "n_bounds", "n_pairs", "n_discordant"]].tolist() == [15, 2, 16, 1]
    assert row["dof"] == pytest.approx(min(12.0, 3.0 * row["n_effective_motions"]))
    # the others agree within 5 %, which says nothing about the pair without a ratio
    assert 0.95 < row["ci_low"] < row["ci_high"] < 1.05
    assert row["verdict"] == "undecided"


def test_no_effect_has_an_interval_of_no_width_and_only_zeros_are_not_estimable():
    table = synthetic_demands(skews=(0,), gaps=(51,), run_scatter=0.0)
    row = friction_cell(table)
    assert (row["ratio"], row["ci_low"], row["ci_high"]) == pytest.approx((1, 1, 1))
    assert row["verdict"] == "negligible"
    row = friction_cell(table.assign(friction_force_kn=0.0), "friction_force_kn")
    assert (row["status"], row["verdict"], row["n_motions"]) == ("not_estimable", "undecided", 0)
    with pytest.raises(InputError, match="occurs twice"):
        paired_effects(table.loc[[*table.index, 0]])


def test_single_demands_have_margins_and_rotation_and_abutments_differences_in_mrad_and_mm():
    table = synthetic_demands(skews=(0,), gaps=(51,), friction_effect=0.0)
    passive, moved = "abutment_passive_m", table["friction"] == 0.5
    table.loc[moved, passive] = table.loc[~moved, passive].to_numpy() + 0.012
    row = friction_cell(table, passive)
    assert (row["judged_by"], row["unit"], row["verdict"]) == ("difference", "mm", "higher")
    assert (row["difference"], row["difference_low"]) == pytest.approx((12.0, 12.0))
    assert 1.0 < row["ci_low"] < row["ratio"] < row["ci_high"]
    rotation = friction_cell(table, "deck_rotation_rad")
    assert (rotation["unit"], rotation["difference_margin"]) == ("mrad", 0.1)
    row = friction_cell(table.assign(abutment_active_m=0.0), "abutment_active_m")
    assert np.isnan(row[["ratio", "slope"]].to_numpy(dtype=float)).all()
    assert (row["difference"], row["verdict"], row["n_motions"]) == (0.0, "negligible", 16)
    assert row["status"] == "ok"
    table = synthetic_demands(skews=(0,), gaps=(51,))
    wide = FitSettings(margin=0.2, margins={"unseating_m": 0.01, "deck_rotation_rad": 100.0})
    names = (DEMAND, "unseating_m", "deck_rotation_rad")
    disp, unseating, rotation = (friction_cell(table, name, wide) for name in names)
    assert (disp["margin"], unseating["margin"]) == (0.2, 0.01)
    assert unseating["verdict"] != "negligible"
    assert rotation["verdict"] == "negligible"


@pytest.mark.parametrize("ended", [{"status": "collapse"}, {"beyond_model": "shear"}])
@pytest.mark.parametrize("demand", [DEMAND, "column_drift_ratio"])
def test_runs_that_end_early_can_take_a_verdict_away(ended, demand):
    table = synthetic_demands(skews=(0,), gaps=(51,), motions=12, seed=5).assign(beyond_model="")
    assert friction_cell(table, demand)["verdict"] == "negligible"
    # three runs with friction ended at 1.3 times the demand without friction
    last = table.index[table["friction"] == 0.5][-3:]
    same = table.index[table["friction"] == 0.0][-3:]
    for name, value in ended.items():
        table.loc[last, name] = value
    table.loc[last, demand] = 1.3 * table.loc[same, demand].to_numpy()
    row = friction_cell(table, demand)
    assert (row["n_bounds"], row["dof"]) == (3, 8)
    assert row["ratio"] > 1.05
    assert row["verdict"] != "negligible"


def sloped(slope, motions=24, seed=6):
    """Return a study in which the effect of friction is 1.3 at 0.4 g, with a slope over ln im."""
    noise = 0.03 * np.random.default_rng(seed).normal(size=motions)
    return pairs(np.log(1.3) + slope * np.log(np.geomspace(0.1, 1.5, motions) / 0.4) + noise)


def test_an_effect_that_depends_on_intensity_has_a_slope_at_a_reference_inside_the_pairs():
    tables = effect_tables(sloped(-0.2), [DEMAND], reference_im={("osb1", "contact_friction"): 0.4})
    row = friction(tables.effects).iloc[0]
    assert row["slope_low"] < -0.2 < row["slope_high"]
    assert row["p_slope"] < 1e-6
    assert (row["im_low"], row["im_high"]) == pytest.approx((0.1, 1.5))
    lines = tables.intensities
    assert list(lines.columns) == list(DESCRIPTIONS["intensity_effects"])
    assert len(lines) == 10
    assert lines["im"][:9].to_numpy() == pytest.approx(np.geomspace(0.1, 1.5, 9))
    truth = 1.3 * (lines["im"] / 0.4) ** -0.2
    assert (lines["ci_low"] < truth).all() & (truth < lines["ci_high"]).all()
    reference = lines[lines["at_reference"]].iloc[0]
    assert (reference["im"], reference["clipped"], reference["verdict"]) == (0.4, False, "higher")
    assert friction(paired_effects(sloped(0.0), [DEMAND])).iloc[0]["p_slope"] > 0.05
    table = sloped(-0.2)
    strongest = table["motion_id"].isin(table.nlargest(8, IM)["motion_id"])
    table.loc[strongest, "status"] = "collapse"  # both runs: these motions enter no pair
    tables = effect_tables(table, [DEMAND], reference_im={("osb1", "contact_friction"): 1.4})
    highest = table.loc[~strongest, IM].max()
    assert tables.effects["im_high"].unique() == pytest.approx([highest])
    assert tables.intensities.iloc[-1][["im", "clipped"]].tolist() == [highest, True]
    tables = effect_tables(sloped(-0.2).drop(columns=IM), [DEMAND])
    assert (tables.effects["ratio"].notna() & tables.effects["slope"].isna()).all()
    assert tables.intensities.empty


def simulated_power(effect, scatter, motions, rng, studies=40_000):
    """Return how often Student's interval decides an effect against a margin of 5 %."""
    mean = effect + scatter / np.sqrt(motions) * rng.normal(size=studies)
    found = scatter * np.sqrt(rng.chisquare(motions - 1, studies) / (motions - 1))
    reach = stats.t.ppf(0.95, motions - 1) * found / np.sqrt(motions)
    low, high = np.log(0.95), np.log(1.05)
    if low <= effect <= high:
        return np.mean((mean - reach >= low) & (mean + reach <= high))
    return np.mean(mean - reach > high) if effect > high else np.mean(mean + reach < low)


@pytest.mark.parametrize("scatter", [0.06, 0.15, 0.3])
@pytest.mark.parametrize("change", [0.0, 0.01, 0.03, 0.08, -0.03, -0.08])
def test_needed_motions_decide_with_a_probability_of_four_in_five(change, scatter):
    effect = np.log1p(change)
    row = POWER_ROW | {"ratio": 1.0 + change, "scatter": scatter}
    motions = verdicts.motions_to_decide(row)
    rng = np.random.default_rng(1)
    if not np.isfinite(motions):
        assert simulated_power(effect, scatter, 1000, rng) < 0.8
        return
    # the power at n and n - 1 motions encloses 0.80, and n is the first with 0.80
    power, less = (simulated_power(effect, scatter, motions - k, rng) for k in (0, 1))
    assert less < 0.81
    assert power > 0.79
    assert power <= 0.82 or motions <= 30


def test_needed_motions_of_demands_and_medians_are_motions_of_the_suite_and_cost_their_analyses():
    few = synthetic_demands(motions=16, run_scatter=0.3, seed=8).assign(cpu_s=36.0)
    few.loc[few["friction"] == 0.5, "unseating_m"] *= 1.03
    few.loc[few["motion_id"].isin(few["motion_id"].unique()[:4]), "status"] = "timeout"
    effects = paired_effects(few, ["unseating_m", "deck_rotation_rad"])
    needed = verdicts.needed_motions(effects, few.iloc[1:])  # analyses are whole numbers
    assert set(needed["demand"]) == {"unseating_m"}
    row = needed.set_index("axis").loc["friction"]
    assert (row["forecast"], row["n_motions"]) == ("more motions", 16)
    exact = verdicts.motions_to_decide(friction(effects, "unseating_m", "pooled").iloc[0].to_dict())
    more = np.ceil(exact * 16 / 12) - 16
    runs = np.ceil(more * (12 - 1 / 16))
    assert (row["needed_motions"], row["more_analyses"]) == (16 + more, runs)
    assert row["more_core_hours"] == pytest.approx(runs / 100)
    # on the margin, without an interval, and of a difference
    assert verdicts.motions_to_decide(POWER_ROW | {"ratio": 1.0501, "scatter": 0.06}) == np.inf
    assert np.isnan(verdicts.motions_to_decide(POWER_ROW | {"ratio": np.nan, "scatter": 0.06}))
    changes = {"judged_by": "difference", "difference": 0.2, "difference_margin": 0.1}
    assert verdicts.motions_to_decide(POWER_ROW | changes | {"scatter": 0.1}) < 15
    table = synthetic_demands(motions=12, run_scatter=0.1).assign(cpu_s=4.0)
    effects = paired_effects(table)
    slight = {"quantity": "median_capacity", "demand": "unseating/slight"}
    median = friction(effects, scope="pooled").assign(**slight)
    needed = verdicts.needed_motions(pd.concat([effects, median], ignore_index=True), table)
    assert "column_shear_dcr" in set(needed["demand"])
    assert needed.set_index("forecast").loc[["decided"], "needed_motions"].isna().all()
    medians = needed[needed["quantity"] == "median_capacity"]
    assert medians["demand"].tolist() == ["unseating/slight"]


def test_levels_of_looks_are_those_of_the_normal_distribution_and_of_the_earlier_look() -> None:
    (level,) = verdicts.look_levels((1.0,), 0.90)
    assert level == pytest.approx(1.0 - verdicts.SPENT * 0.10, abs=1e-9)
    # Spending half of 5 % at half of the time; the second end from the joint distribution.
    first, last = verdicts.look_levels((0.5, 1.0), 0.90)
    ends = [-special.ndtri(0.5 * (1.0 - level)) for level in (first, last)]
    assert ends[0] == pytest.approx(-special.ndtri(verdicts.SPENT * 0.025), abs=1e-6)
    both = stats.multivariate_normal(cov=[[1.0, np.sqrt(0.5)], [np.sqrt(0.5), 1.0]])
    assert 1.0 - both.cdf(ends) == pytest.approx(verdicts.SPENT * 0.05, abs=1e-5)
    levels = verdicts.levels_at(np.array([5.0, 12.0, 15.0, 16.0, 64.0, 70.0]), LOOKS, 0.90)
    assert levels[0] == levels[1] == levels[2] != levels[3]
    assert levels[4] == levels[5]
    assert np.all(levels > 0.90)


@pytest.mark.parametrize("level", [0.80, 0.90, 0.95])
def test_normal_means_cross_their_ends_as_often_as_stated(level: float) -> None:
    times = np.array(LOOKS) / LOOKS[-1]
    ends = -special.ndtri(0.5 * (1.0 - np.array(verdicts.look_levels(tuple(times), level))))
    steps = np.sqrt(np.diff(times, prepend=0.0))
    paths = np.cumsum(steps * np.random.default_rng(1).normal(size=(40_000, times.size)), axis=1)
    crossed = np.any(paths > ends * np.sqrt(times), axis=1).mean()
    assert crossed == pytest.approx(verdicts.SPENT * 0.5 * (1.0 - level), abs=0.004)


def effects(motions: tuple[int, int], scatter: tuple[float, float]) -> pd.DataFrame:
    rows = friction_rows(scatter, motions, ratio=0.9)
    return effect_table(pd.DataFrame(columns=["gap_mm", "friction"]), rows)


def test_interval_at_a_look_has_students_t_and_the_level_of_the_pair_that_scatters() -> None:
    before = effects((16, 16), (0.05, 0.05))
    after = verdicts.at_looks(before, LOOKS)
    level = verdicts.look_levels(tuple(n / 64 for n in LOOKS), 0.90)[1]
    assert after["level"].tolist() == pytest.approx([level] * 3)
    half = np.log(after["ci_high"] / after["ratio"]) / np.log(before["ci_high"] / before["ratio"])
    wider = special.stdtrit(15, 0.5 + 0.5 * level) / special.stdtrit(15, 0.95)
    assert half.tolist() == pytest.approx([wider] * 3)
    assert before["verdict"].iloc[0] == after["verdict"].iloc[0] == "lower"
    # few motions where it scatters, then many
    latest = verdicts.levels_at(np.array([60.0]), LOOKS, 0.90)[0]
    for scatter, expected in (((0.05, 0.001), level), ((0.001, 0.05), latest)):
        found = verdicts.at_looks(effects((16, 64), scatter), LOOKS)["level"].iloc[0]
        assert found == pytest.approx(expected)


def test_a_verdict_once_reached_is_kept() -> None:
    earlier = verdicts.at_looks(effects((16, 16), (0.05, 0.05)), LOOKS)
    later = verdicts.at_looks(effects((20, 20), (0.4, 0.4)), LOOKS)
    assert later["verdict"].iloc[0] == "undecided"
    history = pd.concat([earlier, earlier.assign(ci_low=0.1, ci_high=9.0)])  # two looks
    common = verdicts.kept(later, history[history["scope"] == "pooled"])
    assert common["verdict"].iloc[0] == "lower"
    ends = ["ci_low", "ci_high"]
    assert common[ends].iloc[0].tolist() == earlier[ends].iloc[0].tolist()
    assert common["ci_low"].tolist()[1:] == later["ci_low"].tolist()[1:]
    # without a common part the last interval stays
    apart = earlier.assign(ci_low=2.0, ci_high=2.1)
    assert verdicts.kept(later, apart)["ci_high"].tolist() == later["ci_high"].tolist()
