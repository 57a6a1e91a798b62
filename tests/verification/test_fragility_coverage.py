"""Coverage of the intervals: 400 simulations here, 500 or 2000 in the stored study."""

import json
from pathlib import Path

import pytest
from fragility_coverage import SAMPLING_PLANS, measure_coverage, simulations_of
from scipy import stats

STORED = Path(__file__).parents[2] / "benchmarks" / "fragility_coverage.json"


@pytest.mark.parametrize(
    "design",
    ["stripes 8 x 20", "same records 8 x 20, interval-censored", "design of 16, 5 % collapse"],
)
def test_profile_intervals_cover_95_percent(design):
    found = measure_coverage(design, 400, seed=11)
    # three standard errors of 400 simulations are 3.3 %
    assert found.theta == pytest.approx(0.95, abs=0.035)
    assert found.beta == pytest.approx(0.95, abs=0.035)


def test_binomial_profile_fails_where_the_same_records_run_on_every_stripe():
    found = measure_coverage("same records 8 x 20, binomial profile", 200, seed=11)
    assert found.theta < 0.85


def test_stored_study_holds_every_design_and_its_coverage():
    rows = {row["design"]: row for row in json.loads(STORED.read_text(encoding="utf-8"))["rows"]}
    assert set(rows) == set(SAMPLING_PLANS)
    for name, row in rows.items():
        assert row["simulations"] == simulations_of(name)
        if "binomial" in name or "bootstrap" in name or "Wald" in name:
            continue  # there to show what is worse
        for parameter in ("theta", "beta"):
            hits = round(row[parameter] * row["usable"] * row["simulations"])
            tried = round(row["usable"] * row["simulations"])
            bounds = stats.binomtest(hits, tried).proportion_ci(0.95)
            assert bounds.low <= 0.98, name
            assert bounds.high >= 0.92, name
    assert rows["same records 8 x 20, binomial profile"]["theta"] < 0.8
