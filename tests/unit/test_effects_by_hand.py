"""Intervals and verdicts of the paired effects against plain loops, limits at their exact value."""

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.median_effects import paired_capacity_effects
from skewbridge.fragility.tables.outcomes import outcomes_of

MANY = FitSettings(bootstrap=20_000)
DEMAND = "deck_disp_m"


def pairs(ln_ratios) -> pd.DataFrame:
    """Return a study of two variants, friction 0 and 0.5, with these ratios of a demand."""
    table = synthetic_demands(motions=len(ln_ratios), skews=(0,), gaps=(25,), run_scatter=0.0)
    rubbing = table["friction"] > 0.0
    plain = table.loc[~rubbing, DEMAND].to_numpy()
    table.loc[rubbing, DEMAND] = plain * np.exp(ln_ratios)
    return table


def state(threshold: float) -> LimitState:
    return LimitState(
        component="deck",
        name="state",
        demand=DEMAND,
        threshold=threshold,
        dispersion=0.0,
        unit="m",
        citation="a test",
    )


def median_ratio(x, top, bottom, threshold: float) -> float:
    """Return the ratio of the medians of two log-log lines."""
    theta = []
    for values in (top, bottom):
        slope, start = np.polyfit(x, np.log(values), 1)
        theta.append((np.log(threshold) - start) / slope)
    return theta[0] - theta[1]


def test_the_interval_of_a_median_ratio_does_not_lean_the_way_of_its_replicates():
    """Replicates that reach far down say that the ratio may lie far up; percentiles would not."""
    settings = FitSettings(bootstrap=2_000)
    # one motion in the middle with a large ratio: replicates have it once, never, or often
    values = np.array([0.0, 0.02, -0.01, 0.01, 0.0, -0.02, 1.5, 0.0, 0.02, -0.01, 0.0, 0.01])
    table = pairs(values)
    threshold = 0.1
    found = paired_capacity_effects(table, [state(threshold)], IM, settings).iloc[0]
    ends = [table[table["friction"] == mu].sort_values("motion_id") for mu in (0.5, 0.0)]
    x = np.log(ends[0][IM].to_numpy())
    top, bottom = (each[DEMAND].to_numpy() for each in ends)
    middle = median_ratio(x, top, bottom, threshold)
    rng = np.random.default_rng(99)
    replicates = []
    for _ in range(2_000):
        drawn = rng.integers(0, x.size, x.size)
        if np.unique(drawn).size > 1:
            replicates.append(median_ratio(x[drawn], top[drawn], bottom[drawn], threshold))
    tail = 0.5 * (1.0 - found["level"])
    low, high = np.quantile(replicates, [tail, 1.0 - tail])
    assert found["ratio"] == pytest.approx(np.exp(middle))
    reach = {
        "replicates": (middle - low, high - middle),
        "interval": (middle - np.log(found["ci_low"]), np.log(found["ci_high"]) - middle),
    }
    leaning = np.argmax(reach["replicates"])
    assert reach["replicates"][leaning] > 1.5 * reach["replicates"][1 - leaning]
    assert reach["interval"][leaning] < 1.05 * reach["interval"][1 - leaning]


def test_the_interval_of_a_median_ratio_reaches_as_far_as_its_error():
    """Ratios scattered by s at a slope of 1: the error of ln theta is s / sqrt(n) at the mean."""
    n, s = 20, 0.1
    values = np.random.default_rng(7).normal(size=n)
    values = s * (values - values.mean()) / values.std(ddof=1)
    table = pairs(values)
    threshold = float(np.exp(np.log(table.loc[table["friction"] == 0.0, DEMAND]).mean()))
    found = paired_capacity_effects(table, [state(threshold)], IM, MANY).iloc[0]
    expected = 1.73 * s / np.sqrt(n)  # between the normal's 1.645 and Student's 1.73, slope 1
    for end in ("ci_low", "ci_high"):
        assert abs(np.log(found[end] / found["ratio"])) == pytest.approx(expected, rel=0.25)


def test_a_demand_at_the_threshold_does_not_exceed_it():
    demand = np.array([0.1, np.nextafter(0.1, 1.0), np.nan])
    status = np.array(["ok", "ok", "timeout"])
    found = outcomes_of(demand, status, np.zeros(3, dtype=bool), state(0.1))
    assert found.exceed.tolist() == [False, True, False]
    assert found.unknown.tolist() == [False, False, True]


@pytest.mark.parametrize(("runs", "is_many"), [(20, False), (19, True)])
def test_one_unknown_run_in_twenty_is_not_yet_many(runs, is_many):
    table = synthetic_demands(motions=runs, skews=(0,), gaps=(25,), frictions=(0,))
    table.loc[0, "status"] = "timeout"
    table.loc[0, DEMAND] = 0.0
    curves = fit_study(table, [state(0.15)], IM, FitSettings(bootstrap=99))
    for warnings in curves["warnings"]:
        assert "unknown_outcomes" in warnings
        assert ("unknown_above_5_percent" in warnings) is is_many
