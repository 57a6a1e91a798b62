"""Coverage of the intervals of fits: a stored study, of which plans run again here."""

import json
from pathlib import Path

import pytest
from fragility_coverage import SAMPLING_PLANS, measure_coverage
from scipy import stats

STORED = Path(__file__).parents[2] / "benchmarks" / "fragility_coverage.json"


@pytest.mark.parametrize("plan", ["same records 8 x 20, brackets", "cloud 60, 20 % right-censored"])
def test_intervals_cover_95_percent(plan):
    found = measure_coverage(plan, 300, seed=11)
    # three standard errors of 300 replicates are 3.8 %
    assert found["theta"] == pytest.approx(0.95, abs=0.038)
    assert found["beta"] == pytest.approx(0.95, abs=0.038)


def test_the_stored_study_has_every_plan_and_covers_at_its_level():
    rows = {row["plan"]: row for row in json.loads(STORED.read_text(encoding="utf-8"))["rows"]}
    assert set(rows) == set(SAMPLING_PLANS)
    for name, row in rows.items():
        low, high = (0.87, 0.93) if "90 %" in name else (0.92, 0.98)
        tried = round(row["usable"] * row["replicates"])
        for parameter in {"theta", "beta", "beta_total", "ratio"} & row.keys():
            share = stats.binomtest(round(row[parameter] * tried), tried).proportion_ci(0.95)
            assert share.low <= high, (name, parameter)
            assert share.high >= low, (name, parameter)
