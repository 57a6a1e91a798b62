"""Levels of repeated looks, and intervals and verdicts at a look."""

import numpy as np
import pandas as pd
import pytest
from scipy import special

from skewbridge.fragility.effects import effect_table
from skewbridge.fragility.sequential import SPENT, at_looks, kept, levels_at, look_levels

LOOKS = tuple(range(12, 65, 4))


def test_one_look_spends_its_part_of_the_error_probability() -> None:
    assert look_levels((1.0,), 0.90) == pytest.approx((1.0 - SPENT * 0.10,), abs=1e-9)


def test_two_looks_agree_with_the_bivariate_normal_distribution() -> None:
    """Spending half of 5 % at half of the time; the second end from the joint distribution."""
    from scipy.stats import multivariate_normal

    first, last = look_levels((0.5, 1.0), 0.90)
    ends = [-special.ndtri(0.5 * (1.0 - level)) for level in (first, last)]
    assert ends[0] == pytest.approx(-special.ndtri(SPENT * 0.025), abs=1e-6)
    both = multivariate_normal(cov=[[1.0, np.sqrt(0.5)], [np.sqrt(0.5), 1.0]])
    assert 1.0 - both.cdf(ends) == pytest.approx(SPENT * 0.05, abs=1e-5)


@pytest.mark.parametrize("level", [0.80, 0.90, 0.95])
def test_normal_means_cross_their_ends_as_often_as_stated(level: float) -> None:
    times = np.array(LOOKS) / LOOKS[-1]
    ends = -special.ndtri(0.5 * (1.0 - np.array(look_levels(tuple(times), level))))
    steps = np.sqrt(np.diff(times, prepend=0.0))
    paths = np.cumsum(steps * np.random.default_rng(1).normal(size=(40_000, times.size)), axis=1)
    crossed = np.any(paths > ends * np.sqrt(times), axis=1).mean()
    assert crossed == pytest.approx(SPENT * 0.5 * (1.0 - level), abs=0.004)


def test_a_look_between_two_has_the_level_of_the_earlier_one() -> None:
    levels = levels_at(np.array([5.0, 12.0, 15.0, 16.0, 64.0, 70.0]), LOOKS, 0.90)
    assert levels[0] == levels[1] == levels[2]
    assert levels[3] != levels[2]
    assert levels[4] == levels[5]
    assert np.all(levels > 0.90)


def effects(motions: tuple[int, int], scatter: tuple[float, float]) -> pd.DataFrame:
    """Return a pooled effect of -10 % and those of its two pairs of variants."""
    shared = {"bridge": "b", "abutment": "a", "quantity": "demand", "demand": "deck_disp_m"}
    shared |= {"axis": "friction", "from_value": 0.0, "to_value": 0.5, "margin": 0.05}
    shared |= {"level": 0.90, "n_discordant": 0}
    error = np.hypot(*np.divide(scatter, np.sqrt(motions))) / 2.0
    rows = []
    for number, sd, se, place in (
        (max(motions), np.nan, error, {"scope": "pooled", "n_pairs": sum(motions)}),
        (motions[0], scatter[0], scatter[0] / np.sqrt(motions[0]), {"gap_mm": 25.0}),
        (motions[1], scatter[1], scatter[1] / np.sqrt(motions[1]), {"gap_mm": 51.0}),
    ):
        half = special.stdtrit(number - 1, 0.95) * se
        ends = np.exp(np.log(0.9) + np.array([0.0, -half, half]))
        row = dict(zip(("ratio", "ci_low", "ci_high"), ends, strict=True))
        row |= {"scatter": sd, "dof": number - 1, "n_pairs": number, "scope": "variant"}
        rows.append(shared | row | place)
    return effect_table(pd.DataFrame(columns=["gap_mm", "friction"]), rows)


def test_the_interval_at_a_look_has_students_t_at_the_level_of_the_look() -> None:
    before = effects((16, 16), (0.05, 0.05))
    after = at_looks(before, LOOKS)
    level = look_levels(tuple(n / 64 for n in LOOKS), 0.90)[1]
    assert after["level"].tolist() == pytest.approx([level] * 3)
    half = np.log(after["ci_high"] / after["ratio"]) / np.log(before["ci_high"] / before["ratio"])
    wider = special.stdtrit(15, 0.5 + 0.5 * level) / special.stdtrit(15, 0.95)
    assert half.tolist() == pytest.approx([wider] * 3)
    assert before["verdict"].iloc[0] == after["verdict"].iloc[0] == "lower"


def test_unequal_pairs_count_with_the_motions_of_the_pair_that_scatters() -> None:
    even = at_looks(effects((16, 16), (0.05, 0.05)), LOOKS)
    few_where_it_scatters = at_looks(effects((16, 64), (0.05, 0.001)), LOOKS)
    assert few_where_it_scatters["level"].iloc[0] == even["level"].iloc[0]
    many_where_it_scatters = at_looks(effects((16, 64), (0.001, 0.05)), LOOKS)
    assert many_where_it_scatters["level"].iloc[0] == pytest.approx(
        levels_at(np.array([60.0]), LOOKS, 0.90)[0]
    )


def test_a_verdict_once_reached_is_kept() -> None:
    earlier = at_looks(effects((16, 16), (0.05, 0.05)), LOOKS)
    later = at_looks(effects((20, 20), (0.4, 0.4)), LOOKS)
    assert later["verdict"].iloc[0] == "undecided"
    common = kept(later, earlier[earlier["scope"] == "pooled"])
    assert common["verdict"].iloc[0] == "lower"
    assert common["ci_high"].iloc[0] == earlier["ci_high"].iloc[0]
    assert common["ci_low"].tolist()[1:] == later["ci_low"].tolist()[1:]
    # without a common part the last interval stays
    apart = earlier.assign(ci_low=2.0, ci_high=2.1)
    assert kept(later, apart)["ci_high"].tolist() == later["ci_high"].tolist()
