"""Coverage of the joint model: the stored simulation, and a few of its replicates repeated."""

import json
from pathlib import Path

import joint_coverage
import numpy as np
import pytest

STUDY = json.loads(Path(joint_coverage.__file__).with_suffix(".json").read_text())
ROWS = STUDY["rows"]


def test_the_stored_study_is_large_enough_and_at_the_default_design():
    assert STUDY["replicates"] >= 500
    assert STUDY["motions"] >= 32
    assert STUDY["variants"] == 12
    assert {row["collapse"] for row in ROWS} == {0.0, 0.05, 0.2}
    assert all(row["replicates"] == STUDY["replicates"] for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['quantity']}, {row['collapse']:.0%}")
def test_intervals_cover_at_their_level(row):
    """The binomial 95 % bounds of the coverage meet 92 to 98 %."""
    assert row["high"] >= 0.92
    assert row["low"] <= 0.98


def test_medians_are_unbiased_with_collapses():
    for row in ROWS:
        if not row["quantity"].startswith("beta"):
            assert abs(row["bias"]) < 0.02


def test_replicates_agree_with_the_stored_simulation():
    found = joint_coverage.measure(0.05, 8, STUDY["seed"])
    assert len(found) == 5
    stored = {row["quantity"]: row for row in ROWS if row["collapse"] == 0.05}
    for row in found:
        assert row["coverage"] >= 0.5
        assert row["scatter"] < 3.0 * stored[row["quantity"]]["scatter"]
        assert np.isfinite(row["bias"])
