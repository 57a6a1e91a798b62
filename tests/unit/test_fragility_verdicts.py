"""Verdicts in a family, margins of demands, effects as differences, pairs that are bounds."""

import numpy as np
import pandas as pd
import pytest
from scipy import optimize, stats
from statsmodels.stats.multitest import multipletests

from fragility_tables import synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.censored_means import censored_mean, motion_contributions
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.verdicts import FAMILY, judged, verdicts_of
from skewbridge.reading import checked


def rows_of(ratios, errors, *, dof=15, margin=0.05, level=0.9, axis="friction"):
    """Return rows of ratios with Student's intervals, for `judged`."""
    reach = stats.t.ppf(0.5 + level / 2, dof) * np.asarray(errors)
    logs = np.log(ratios)
    table = pd.DataFrame({"ratio": ratios, "ci_low": np.exp(logs - reach)})
    names = ("difference", "difference_low", "difference_high", "difference_margin")
    return table.assign(
        ci_high=np.exp(logs + reach),
        level=level,
        margin=margin,
        dof=dof,
        judged_by="ratio",
        n_pairs=16,
        n_discordant=0,
        **dict.fromkeys(names, np.nan),
        **(dict.fromkeys(FAMILY, "one") | {"axis": axis}),
    )


def friction_cell(table, demand, settings=None):
    found = paired_effects(table, [demand], settings or FitSettings())
    return found[(found["axis"] == "friction") & (found["scope"] == "variant")].iloc[0]


def test_a_family_of_one_has_the_verdict_of_its_interval():
    for ratio in (0.9, 0.97, 1.0, 1.03, 1.06, 1.2):
        found = judged(rows_of([ratio], [0.015])).iloc[0]
        assert found["verdict_family"] == found["verdict"]


def test_the_family_agrees_with_holm_of_statsmodels():
    rng = np.random.default_rng(3)
    ratios, errors = np.exp(rng.normal(0, 0.1, 40)), rng.uniform(0.01, 0.04, 40)
    found = judged(rows_of(ratios, errors))
    logs = np.log(ratios)
    below = stats.t.cdf((logs - np.log(0.95)) / errors, 15)
    above = stats.t.cdf((np.log(1.05) - logs) / errors, 15)
    outside = multipletests(np.minimum(below, above), alpha=0.05, method="holm")[0]
    assert 0 < outside.sum() < found["verdict"].isin(["lower", "higher"]).sum()
    assert found["verdict_family"].isin(["lower", "higher"]).tolist() == outside.tolist()


def test_other_axes_are_other_families():
    clear = rows_of([1.12], [0.03])
    noise = rows_of(np.full(60, 1.0), np.full(60, 0.2), axis="gap_mm")
    crowd = rows_of(np.full(60, 1.0), np.full(60, 0.2))
    apart = judged(pd.concat([clear, noise], ignore_index=True))
    together = judged(pd.concat([clear, crowd], ignore_index=True))
    assert apart["verdict_family"][0] == "higher"
    assert together["verdict"][0] == "higher"
    assert together["verdict_family"][0] != "higher"


def test_rows_without_an_interval_do_not_weaken_the_family():
    lone = rows_of([1.12], [0.03])
    empty = rows_of(np.full(50, np.nan), np.full(50, np.nan))
    found = judged(pd.concat([lone, empty], ignore_index=True))
    assert found["verdict_family"].tolist() == ["higher", *["undecided"] * 50]


def test_rotation_and_abutments_are_judged_by_their_difference_in_mrad_and_mm():
    table = synthetic_demands(skews=(0,), gaps=(51,), friction_effect=0.0)
    moved = table["friction"] == 0.5
    table.loc[moved, "abutment_passive_m"] = (
        table.loc[~moved, "abutment_passive_m"].to_numpy() + 0.012
    )
    found = friction_cell(table, "abutment_passive_m")
    assert (found["judged_by"], found["unit"], found["verdict"]) == ("difference", "mm", "higher")
    assert found["difference"] == pytest.approx(12.0)
    assert found["difference_low"] == pytest.approx(12.0, abs=1e-6)
    assert found["ratio"] > 1.0  # stands beside it, with its own interval
    assert found["ci_low"] < found["ratio"] < found["ci_high"]
    turned = friction_cell(table, "deck_rotation_rad")
    assert (turned["unit"], turned["difference_margin"]) == ("mrad", 0.1)


def test_zeros_have_a_difference_though_no_ratio():
    table = synthetic_demands(skews=(0,), gaps=(51,)).assign(abutment_active_m=0.0)
    found = friction_cell(table, "abutment_active_m")
    assert np.isnan(found["ratio"])
    assert (found["difference"], found["verdict"], found["n_left_out"]) == (0.0, "negligible", 0)


def test_margins_of_single_demands_beat_the_common_one():
    table = synthetic_demands(skews=(0,), gaps=(51,))
    wide = FitSettings(margin=0.2, margins={"unseating_m": 0.01, "deck_rotation_rad": 100.0})
    assert friction_cell(table, "deck_disp_m", wide)["margin"] == 0.2
    assert friction_cell(table, "unseating_m", wide)["margin"] == 0.01
    assert friction_cell(table, "unseating_m", wide)["verdict"] != "negligible"
    assert friction_cell(table, "deck_rotation_rad", wide)["verdict"] == "negligible"


@pytest.mark.parametrize(
    ("margins", "message"),
    [({"deck_dips_m": 0.1}, "deck_dips_m"), ({"unseating_m": 1.5}, "must be < 1")],
)
def test_a_margin_of_nothing_is_refused(margins, message):
    with pytest.raises(InputError, match=message):
        checked(FitSettings, {"margins": margins}, "fragility")


def collapsing(ratio, seed, limit=1.0):
    """Return a study in which friction raises a demand, and runs past a limit collapse."""
    table = synthetic_demands(skews=(0,), gaps=(51,), motions=40, seed=seed, run_scatter=0.05)
    table.loc[table["friction"] == 0.5, "deck_disp_m"] *= ratio
    over = table["deck_disp_m"] > limit * table["deck_disp_m"].quantile(0.85)
    table.loc[over, "status"] = "collapse"
    table.loc[over, "deck_disp_m"] = table["deck_disp_m"].quantile(0.85)
    return table


def test_collapses_on_one_side_pull_the_effect_to_that_side():
    found = [friction_cell(collapsing(1.5, seed), "deck_disp_m") for seed in range(8)]
    assert all(row["n_bounds"] > 2 for row in found)
    logs = [np.log(row["ratio"]) for row in found]
    # 8 x 40 pairs of 7 % scatter; leaving the bounds out would select the pairs that grew less
    assert np.mean(logs) == pytest.approx(np.log(1.5), abs=0.02)
    assert {row["verdict"] for row in found} == {"higher"}


def test_a_collapse_alone_can_take_a_verdict_away():
    table = synthetic_demands(skews=(0,), gaps=(51,), motions=12, seed=5)
    assert friction_cell(table, "deck_disp_m")["verdict"] == "negligible"
    # three runs with friction collapsed at 1.3 times what they reach without
    ended = table.index[table["friction"] == 0.5][-3:]
    same = table.index[table["friction"] == 0.0][-3:]
    table.loc[ended, "status"] = "collapse"
    table.loc[ended, "deck_disp_m"] = 1.3 * table.loc[same, "deck_disp_m"].to_numpy()
    found = friction_cell(table, "deck_disp_m")
    assert (found["n_bounds"], found["dof"]) == (3, 8)
    assert found["ratio"] > 1.05
    assert found["verdict"] != "negligible"


def test_the_mean_with_bounds_is_that_of_maximum_likelihood():
    rng = np.random.default_rng(2)
    values = rng.normal(0.3, 1.0, 400)
    bound = np.select([values > 1.0, values < -1.0], [1, -1], default=0)
    values = np.clip(values, -1.0, 1.0)

    def minus(parameters):
        z = (values - parameters[0]) / np.exp(parameters[1])
        terms = [stats.norm.logsf(z), stats.norm.logcdf(z)]
        return -np.sum(
            np.select([bound == 1, bound == -1], terms, stats.norm.logpdf(z) - parameters[1])
        )

    best = optimize.minimize(minus, [0.0, 0.0]).x[0]
    found = censored_mean(values, bound, np.ones((1, 400)))[0]
    # the divisor of a sample instead of that of maximum likelihood: 1/400 of the scatter
    assert found == pytest.approx(best, abs=2e-3)


def test_values_that_agree_without_one_motion_have_a_mean_without_it():
    # three agree, one does not, one is a bound: without the fourth nothing scatters but rounding
    values, bound = np.array([0.1, 0.1, 0.1, 0.5, -0.1]), np.array([0, 0, 0, 0, 1])
    mean, each = motion_contributions(values, bound, np.arange(5), 5)
    assert mean - each[3] * 5 / 4 == pytest.approx(0.1, abs=1e-6)


def test_contributions_of_motions_give_the_error_of_a_plain_mean():
    values = np.array([0.1, 0.3, 0.2, 0.6, 0.5, 0.7])
    motions = np.array([0, 0, 1, 2, 2, 4])
    mean, each = motion_contributions(values, np.zeros(6, dtype=int), motions, 5)
    own = np.array([0.2, 0.2, 0.55, 0.7])
    assert mean == pytest.approx(own.mean())
    assert each[3] == 0.0
    assert np.sqrt(np.sum(each**2) * 4 / 3) == pytest.approx(stats.sem(own))


@pytest.mark.parametrize(
    ("low", "high", "possible", "verdict"),
    [
        (-0.3, -0.2, True, "lower"),
        (0.2, 0.3, True, "higher"),
        (-0.1, 0.1, True, "negligible"),
        (-0.1, 0.1, False, "undecided"),
        (0.01, 0.3, True, "detectable"),
        (-0.3, -0.01, True, "detectable"),
        # an interval that ends at no change does not exclude it
        (-0.3, 0.0, True, "undecided"),
        (0.0, 0.3, True, "undecided"),
    ],
)
def test_verdicts_of_intervals_against_a_margin_of_a_tenth(low, high, possible, verdict):
    ends = [np.array([value]) for value in (low, -0.1, 0.0, 0.1, high)]
    assert verdicts_of(*ends, possible=np.array([possible])).tolist() == [verdict]
