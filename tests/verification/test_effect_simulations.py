"""The stored simulations of pooled effects and verdicts, and a few of them again."""

import json
from itertools import product
from pathlib import Path

import pytest
from effect_simulations import COLLAPSES, MOTIONS, factor_errors, family_errors, pooled_effects

STORED = Path(__file__).parents[2] / "benchmarks" / "effect_simulations.json"
ROWS = json.loads(STORED.read_text())["rows"]


def of(start):
    return [row for row in ROWS if row["what"].startswith(start)]


def test_all_was_simulated_with_and_without_collapses():
    for start in ("coverage", "type I at the margin", "type I of the factor", "type I of p_cells"):
        told = {(row["motions"], row["collapse"]) for row in of(start)}
        assert told == set(product(MOTIONS, COLLAPSES))
    assert all(row["simulations"] >= 500 for row in ROWS)


def test_intervals_of_pooled_effects_cover():
    rows = of("coverage")
    assert all(row["low"] <= 0.98 and row["high"] >= 0.92 for row in rows)
    assert all(0.92 <= row["share"] <= 0.98 for row in rows)


def test_no_cell_of_a_family_is_called_changed_at_the_margin_too_often():
    family, alone = of("type I at the margin, any verdict_family"), of("type I at the margin")
    assert all(row["low"] <= 0.05 for row in family)
    # each by itself shouts in every other study
    single = [row["share"] for row in alone if row not in family]
    assert min(single) > 0.3


def test_factor_and_interaction_tests_keep_their_level():
    for row in of("type I of the factor"):
        assert 0.03 <= row["share"] <= 0.07, row
    for row in of("type I of p_cells"):
        assert 0.02 <= row["share"] <= 0.08, row


@pytest.mark.parametrize("study", [pooled_effects, family_errors, factor_errors])
def test_the_simulation_runs_again(study):
    rows = study(16, 0.05, 12, 1)
    assert {row.what for row in rows} <= {row["what"] for row in ROWS}
    assert all(row.simulations == 12 for row in rows)
