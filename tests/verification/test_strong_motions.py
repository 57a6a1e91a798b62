"""Studies under strong motions: cases, pooling, verdicts, and resuming from the journal."""

from dataclasses import replace
from itertools import product

import pytest

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.units import G_MPS2
from skewbridge.verification import registry
from skewbridge.verification.studies import strong_motions
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_runs import strongest_motions
from skewbridge.verification.studies.strong_motions import (
    ACCURACY,
    ALL_PLACES,
    DEMANDS,
    HARD_SET,
    PGA_G,
    pairs,
    pooled_ratios,
    run_accuracy,
    run_hard_set,
)

ONE = replace(
    HARD_SET, bridges=("osb1",), abutments=("roller",), skews_deg=(0,), motion_count=1, processes=1
)
# two motions cut to 2 s of shaking beyond their tapers, friction alone, coarse against default
TINY = replace(
    ACCURACY["accuracy"],
    skews_deg=(0,),
    gaps_mm=(25,),
    motion_count=2,
    window_s=2.1,
    processes=1,
)


def test_hard_set_has_every_bridge_abutment_and_skew():
    assert len({variant.slug for variant in HARD_SET.variants()}) == len(HARD_SET.variants()) == 45


def test_motions_are_the_strongest_and_reach_the_peak():
    motions = strongest_motions(3, PGA_G)
    assert len({motion.motion_id for motion in motions}) == 3
    for motion in motions:
        peak_g = orbit_rotd50(motion.accel_1_mps2, motion.accel_2_mps2) / G_MPS2
        assert peak_g == pytest.approx(1.2)


def test_sound_analysis_counts_and_each_rung_is_reported():
    study = Study("hard-set")
    run_hard_set(study, ONE, AnalysisSettings(duration_s=3.0))
    (row,) = study.comparisons
    assert (row.value, row.reference, row.is_passed) == (1.0, 1.0, True)
    assert study.tables["statuses"]["analyses"].tolist() == [1]
    rungs = study.tables["rungs"].set_index("rung")
    assert rungs["analyses"][0] == 1
    assert rungs["steps"][0] >= 3.0 / AnalysisSettings().dt_s
    assert rungs["steps_share"].sum() == pytest.approx(1.0)


def test_failed_analysis_is_counted_and_named():
    study = Study("hard-set")
    settings = AnalysisSettings(duration_s=3.0, max_iterations=2, mean_iterations=1.0)
    run_hard_set(study, ONE, settings)
    (row,) = study.comparisons
    assert row.value == 0.0
    assert not row.is_passed
    assert study.tables["rows"]["motion_id"].iloc[0] in row.quantity
    assert "timeout" in row.quantity


def cut_short(path):
    """Cut the last line of a journal as a kill does."""
    path.write_bytes(path.read_bytes().rstrip()[:-20])


def noted(monkeypatch):
    """Note the variant of each analysis."""
    slugs, analyse = [], strong_motions.analyse

    def note(variant, *args):
        slugs.append(variant.slug)
        return analyse(variant, *args)

    monkeypatch.setattr(strong_motions, "analyse", note)
    return slugs


def test_resume_of_the_accuracy_repeats_only_the_line_cut_short(monkeypatch, tmp_path):
    first = Study("accuracy", tmp_path)
    run_accuracy(first, TINY, ("fast", "default"))
    table = first.tables["ratios"]
    assert len(table) == 2 * len(DEMANDS)  # one place, and all of them
    assert set(table["count"]) == {2}
    assert (tmp_path / "accuracy.jsonl").read_text().count('"run_key"') == 8
    summary, failed = first.comparisons[-2:]
    assert summary.value == pytest.approx(table["difference_percent"].abs().max())
    assert "largest difference of 8 pooled ratios" in summary.quantity
    assert failed.value == 0.0
    cut_short(tmp_path / "accuracy.jsonl")
    monkeypatch.setattr(strong_motions, "REPORT_EACH", 1)
    slugs, lines = noted(monkeypatch), []
    second = Study("accuracy", tmp_path, lines.append)
    run_accuracy(second, TINY, ("fast", "default"))
    assert len(slugs) == 1
    assert lines[0].startswith(f"8 of 8 analyses, 0 min left; last: {slugs[0]}")
    assert second.tables["ratios"].equals(table)
    assert second.comparisons == first.comparisons


def test_accuracy_pairs_neighbours_on_every_axis():
    found = pairs(ACCURACY["accuracy"])
    assert len(ACCURACY["accuracy"].variants()) == 12
    assert {axis: sum(name == axis for name, *_ in found) for axis, *_ in found} == {
        "friction_pct": 6,
        "gap_mm": 6,
        "skew_deg": 8,
    }
    for axis, before, after in found:
        same = {"friction_pct", "gap_mm", "skew_deg"} - {axis}
        assert all(getattr(before, name) == getattr(after, name) for name in same)
        assert getattr(after, axis) > getattr(before, axis)


BOTH = ("default", "reference")


def made_up(chosen, ratios):
    """Return peaks that grow by a ratio per motion and accuracy wherever there is friction."""
    return {
        (accuracy, variant, motion): dict.fromkeys(DEMANDS, ratio if variant.friction_pct else 1.0)
        for (accuracy, motion), ratio in ratios.items()
        for variant in chosen.variants()
    }


def test_ratios_are_geometric_means_over_motions_and_over_places():
    chosen = replace(ACCURACY["accuracy"], skews_deg=(0, 30))
    ratios = dict(zip(product(BOTH, "ab"), (1.2, 0.9, 1.1, 0.9), strict=True))
    table = pooled_ratios(chosen, made_up(chosen, ratios), "ab", BOTH)
    friction = table[table["axis"] == "friction_pct"]
    assert len(friction) == len(DEMANDS) * (4 + 1)
    assert set(friction.loc[friction["place"] == ALL_PLACES, "count"]) == {8}
    assert friction["ratio"].to_numpy() == pytest.approx((1.2 * 0.9) ** 0.5)
    assert friction["exact_ratio"].to_numpy() == pytest.approx((1.1 * 0.9) ** 0.5)
    difference = 100 * ((1.2 / 1.1) ** 0.5 - 1)
    assert friction["difference_percent"].to_numpy() == pytest.approx(difference)
    others = table[table["axis"] != "friction_pct"]
    assert others["ratio"].to_numpy() == pytest.approx(1.0)


def test_motion_without_the_demand_is_left_out_of_both():
    chosen = replace(ACCURACY["accuracy"], skews_deg=(0,), gaps_mm=(25,))
    found = made_up(chosen, dict.fromkeys(product(BOTH, "ab"), 1.5))
    found["reference", chosen.variants()[0], "b"]["unseating_m"] = 0.0
    table = pooled_ratios(chosen, found, "ab", BOTH).query(f"place == '{ALL_PLACES}'")
    assert table.set_index("demand")["count"].to_dict() == {
        demand: 1 if demand == "unseating_m" else 2 for demand in DEMANDS
    }


def test_long_studies_run_only_when_named(monkeypatch, tmp_path):
    ran = []

    def run(name, kept, _report_progress):
        ran.append((name, kept))
        return Study(name, kept)

    monkeypatch.setattr(registry, "run_study", run)
    registry.run_studies([], tmp_path)
    assert [name for name, _ in ran] == list(registry.STUDIES)
    registry.run_studies(["accuracy"], tmp_path)
    assert ran[-1] == ("accuracy", tmp_path)
    with pytest.raises(InputError, match="accuracy-whole"):
        registry.run_studies(["nothing"], tmp_path)
