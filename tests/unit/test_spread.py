"""Fits and effects spread over processes: the tables of one process, in the same order."""

import os
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.demands.columns import demands_for
from skewbridge.fragility.old_joint.table import joint_table
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import factor_summary
from skewbridge.fragility.tables.limit_states import LimitState, load_limit_states
from skewbridge.fragility.tables.median_effects import paired_capacity_effects
from skewbridge.fragility.tables.ordered_curves import ordered_curves
from skewbridge.fragility.tables.spread import spread
from skewbridge.fragility.tables.system_curves import system_curves

STATES = Path(__file__).parents[2] / "config" / "limit_states.yaml"
COMPONENTS = ("unseating", "abutment_active")

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


def _many(rows: pd.DataFrame) -> list[str]:
    """Demands enough for other processes."""
    names = [name for name in demands_for("effect", rows.columns) if (rows[name] > 0.0).all()]
    return names * (1 + 24 // len(names))


def _joint(rows: pd.DataFrame, jobs: int) -> pd.DataFrame:
    """All limit states, whose demands are what is spread."""
    states = [state for state in load_limit_states(STATES) if state.demand in rows.columns]
    return joint_table(rows, states, IM, fit_study(rows, states[:1], IM), jobs=jobs)


@pytest.mark.parametrize(
    "fit",
    [
        lambda rows, states, jobs: fit_study(rows, states, IM, jobs=jobs),
        lambda rows, states, jobs: ordered_curves(rows, states, IM, jobs=jobs),
        lambda rows, states, jobs: system_curves(rows, states, IM, jobs=jobs),
        lambda rows, states, jobs: paired_capacity_effects(rows, states, IM, jobs=jobs),
        lambda rows, _, jobs: _joint(rows, jobs),
        lambda rows, _, jobs: factor_summary(rows, _many(rows), jobs=jobs),
        lambda rows, _, jobs: paired_effects(rows, ["unseating_m", "deck_disp_m"], jobs=jobs),
    ],
    ids=["curves", "ordered", "systems", "medians", "joint", "factors", "effects"],
)
def test_two_processes_make_the_table_of_one(fit: Fit, demands: pd.DataFrame) -> None:
    states = [state for state in load_limit_states(STATES) if state.component in COMPONENTS]
    alone = fit(demands, states, 1)
    assert len(alone) > 10
    pd.testing.assert_frame_equal(fit(demands, states, 2), alone, check_exact=True)
