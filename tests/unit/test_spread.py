"""Fits and effects spread over processes: the tables of one process, in the same order."""

import os
from collections.abc import Callable

import pandas as pd
import pytest

from fragility_tables import SETTINGS, paired_effects, ready, states_of, synthetic_demands
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_table import spread
from skewbridge.fragility.joint import joint_table
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.system import system_curves

type Fit = Callable[[pd.DataFrame, list[LimitState], int], pd.DataFrame]


def test_few_items_stay_in_one_process_and_many_do_not() -> None:
    def process_of(_: int) -> int:  # in here: workers need not find this module
        return os.getpid()

    assert set(spread(process_of, range(10), 2)) == {os.getpid()}
    assert os.getpid() not in spread(process_of, range(50), 2)
    assert spread(str, range(50), 2) == [str(n) for n in range(50)]


@pytest.fixture(scope="module")
def demands() -> pd.DataFrame:
    """27 variants, one of them with collapses."""
    table = synthetic_demands(motions=10, gaps=(10, 25, 51), frictions=(0, 25, 50))
    first = table["variant"] == table["variant"].iloc[0]
    return table.assign(
        status=table["status"].mask(first & (table["unseating_m"] > 0.15), "collapse"),
        collapse_criterion="",
    )


@pytest.mark.parametrize(
    "fit",
    [
        lambda rows, states, jobs: fit_study(rows, states, SETTINGS, jobs=jobs),
        lambda rows, states, jobs: system_curves(rows, states, SETTINGS, jobs=jobs),
        lambda rows, states, jobs: median_effects(rows, states, SETTINGS, jobs=jobs),
        lambda rows, states, jobs: joint_table(rows, states, None, SETTINGS, jobs=jobs),
        lambda rows, _, jobs: paired_effects(rows, ["unseating_m", "deck_disp_m"], jobs=jobs),
    ],
    ids=["curves", "systems", "medians", "joint", "effects"],
)
def test_two_processes_give_the_table_of_one(fit: Fit, demands: pd.DataFrame) -> None:
    states = [*states_of("unseating"), *states_of("abutment_passive")]
    rows = ready(demands, states)
    alone = fit(rows, states, 1)
    assert len(alone) > 3
    pd.testing.assert_frame_equal(fit(rows, states, 2), alone, check_exact=True)
