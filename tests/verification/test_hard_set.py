"""The hard set in small: what it runs, how it counts, and that a failure is named."""

from dataclasses import replace

import pytest

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


def test_a_failure_is_counted_and_named(monkeypatch):
    shortened(monkeypatch, duration_s=3.0, max_iterations=2, mean_iterations=1.0)
    study = Study("hard-set")
    run_hard_set(study, replace(ONE))
    (row,) = study.comparisons
    assert row.value == 0.0
    assert not row.is_passed
    assert study.tables["rows"]["motion_id"].iloc[0] in row.quantity
    assert "timeout" in row.quantity
