"""The hard set in small: what it runs, how it counts, and that a failure is named."""

from dataclasses import replace

import pytest

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.units import G_MPS2
from skewbridge.verification.studies import hard_set
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.hard_set import (
    PGA_G,
    HardSet,
    run_hard_set,
    strongest_motions,
)

ONE = HardSet(bridges=("osb1",), abutments=("roller",), skews_deg=(0,), motion_count=1, processes=1)


def test_the_whole_set_has_every_bridge_abutment_and_skew():
    variants = HardSet().variants()
    assert len(variants) == 45
    assert len({variant.slug for variant in variants}) == 45


def test_the_motions_are_the_strongest_and_reach_the_peak():
    motions = strongest_motions(3, PGA_G)
    assert len({motion.motion_id for motion in motions}) == 3
    for motion in motions:
        peak_g = orbit_rotd50(motion.accel_1_mps2, motion.accel_2_mps2) / G_MPS2
        assert peak_g == pytest.approx(1.2)


def shortened(monkeypatch, **changes):
    """Let the set run a few seconds of its motion."""
    plain = hard_set.AnalysisSettings
    monkeypatch.setattr(hard_set, "AnalysisSettings", lambda: plain(**changes))


def test_a_sound_analysis_counts(monkeypatch):
    shortened(monkeypatch, duration_s=3.0)
    study = Study("hard-set")
    run_hard_set(study, ONE)
    (row,) = study.comparisons
    assert (row.value, row.reference, row.is_passed) == (1.0, 1.0, True)
    assert study.tables["statuses"]["analyses"].tolist() == [1]


def test_a_run_that_was_broken_off_goes_on(monkeypatch, tmp_path):
    """Of two analyses one is kept, the line of the other was cut short by the kill."""
    shortened(monkeypatch, duration_s=1.0)
    chosen = replace(ONE, skews_deg=(0, 30))
    whole = Study("hard-set", tmp_path)
    run_hard_set(whole, chosen)
    kept = tmp_path / "hard-set.jsonl"
    first, second = filter(None, kept.read_text().splitlines())
    kept.write_text(f"{first}\n{second[:100]}")

    analysed, row = [], hard_set._row
    monkeypatch.setattr(
        hard_set, "Parallel", lambda **_: lambda calls: (f(*a) for f, a, _ in calls)
    )
    monkeypatch.setattr(hard_set, "_row", lambda *task: analysed.append(task[0].slug) or row(*task))
    monkeypatch.setattr(hard_set, "REPORT_EACH", 1)
    told = []
    again = Study("hard-set", tmp_path, told.append)
    run_hard_set(again, chosen)
    assert len(analysed) == 1
    assert analysed[0] in told[0]
    assert told[0].startswith("2 of 2 analyses, 0 min left")
    assert again.tables["rows"].equals(whole.tables["rows"])


def test_it_says_what_each_rung_carried(monkeypatch):
    shortened(monkeypatch, duration_s=0.5)
    study = Study("hard-set")
    run_hard_set(study, ONE)
    rungs = study.tables["rungs"].set_index("rung")
    assert rungs["analyses"][0] == 1
    assert rungs["steps"][0] >= 0.5 / AnalysisSettings().dt_s
    assert rungs["steps_share"].sum() == pytest.approx(1.0)


def test_a_failure_is_counted_and_named(monkeypatch):
    shortened(monkeypatch, duration_s=3.0, max_iterations=2, mean_iterations=1.0)
    study = Study("hard-set")
    run_hard_set(study, replace(ONE))
    (row,) = study.comparisons
    assert row.value == 0.0
    assert not row.is_passed
    assert study.tables["rows"]["motion_id"].iloc[0] in row.quantity
    assert "timeout" in row.quantity
