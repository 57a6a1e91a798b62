"""Stored simulations of pooled effects, effects at an intensity and verdicts, some repeated."""

import json
from itertools import product
from pathlib import Path

import pytest
from effect_simulations import BOUNDS, MOTIONS, STUDIES

STORED = Path(__file__).parents[2] / "benchmarks" / "effect_simulations.json"
ROWS = json.loads(STORED.read_text())["rows"]
VERDICTS = ("verdict_family", "verdict")


def rows_of(start):
    return [row for row in ROWS if row["what"].startswith(start)]


def test_every_case_is_simulated_with_and_without_bounds():
    for start in ("coverage 90%, pooled", "coverage 95%, at the", "type I at the margin"):
        cases = {(row["motions"], row["bounds"]) for row in rows_of(start)}
        assert cases == set(product(MOTIONS, BOUNDS))
    assert all(row["simulations"] >= 500 for row in ROWS)


@pytest.mark.parametrize(("level", "low", "high"), [("95%", 0.92, 0.98), ("90%", 0.87, 0.93)])
def test_intervals_of_effects_cover(level, low, high):
    for row in rows_of(f"coverage {level}"):
        assert low <= row["share"] <= high, row


def test_no_row_of_a_family_is_called_changed_at_the_margin_too_often():
    family, alone = (rows_of(f"type I at the margin, any {name}") for name in VERDICTS)
    assert all(row["low"] <= 0.05 for row in family)
    # verdicts of single intervals are wrong much more often
    assert min(row["share"] for row in alone if row["what"].endswith("verdict")) > 0.2


@pytest.mark.parametrize("study", STUDIES)
def test_simulations_run_again(study):
    rows = study(16, 0.05, 12, 1)
    assert {row["what"] for row in rows} <= {row["what"] for row in ROWS}
    assert all(row["simulations"] == 12 for row in rows)
