"""Stored simulations of verdicts and intervals at stopping; one case is repeated in part."""

import json
from itertools import product
from pathlib import Path

from effect_simulations import BOUNDS
from sequential_verdicts import EFFECTS, verdicts_at_stopping

STORED = Path(__file__).parents[2] / "benchmarks" / "sequential_verdicts.json"
ROWS = json.loads(STORED.read_text())["rows"]


def test_every_case_of_demands_is_simulated():
    rows = [row for row in ROWS if row["kind"] == "demand"]
    cases = {(row["bounds"], row["effect_margins"]) for row in rows}
    assert cases == set(product(BOUNDS, EFFECTS))
    assert all(row["simulations"] >= 500 for row in rows)


def test_no_verdict_at_stopping_is_wrong_too_often():
    """The 95 % bounds of the share do not lie above 5 %."""
    wrong = [row for row in ROWS if row["what"].startswith("wrong")]
    assert len(wrong) >= 21
    assert all(row["low"] <= 0.05 for row in wrong)
    assert max(row["share"] for row in wrong) > 0.02  # at the margin they are not rare


def test_intervals_at_stopping_cover():
    """The 95 % bounds of the share do not lie below 90 %."""
    covered = [row for row in ROWS if row["what"] == "interval covers"]
    assert all(row["high"] >= 0.90 for row in covered)


def test_clear_effects_are_decided_early():
    for row in ROWS:
        if row["what"] == "decided" and row["kind"] == "demand" and row["effect_margins"] != 1.0:
            assert row["share"] > 0.95
            assert row["mean_motions"] < 20


def test_simulations_run_again():
    rows = verdicts_at_stopping("demand", 0.0, 0.0, 10, 1)
    assert {row["what"] for row in rows} == {
        *("wrong: lower", "wrong: higher"),
        *("interval covers", "decided"),
    }
    assert all(row["simulations"] == 10 for row in rows)
