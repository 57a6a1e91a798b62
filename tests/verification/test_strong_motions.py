"""Studies under strong motions: cases, pooling, verdicts, and resuming from the journal."""

from dataclasses import replace
from itertools import product
from math import inf, nan

import pandas as pd
import pytest

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.units import G_MPS2
from skewbridge.verification.registry import Study
from skewbridge.verification.studies import strong_motions
from skewbridge.verification.studies.paper_runs import strongest_motions
from skewbridge.verification.studies.strong_motions import (
    ACCURACY,
    ALL_PLACES,
    CHANGES,
    CONVERGENCE,
    DEMANDS,
    HARD_SET,
    PGA_G,
    REFINEMENTS,
    compare_with_finer,
    judge_changes,
    pairs,
    pooled_ratios,
    relative_changes,
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


def test_the_hard_set_has_every_bridge_abutment_and_skew():
    assert len({variant.slug for variant in HARD_SET.variants()}) == len(HARD_SET.variants()) == 45


def test_motions_are_the_strongest_and_reach_the_peak():
    motions = strongest_motions(3, PGA_G)
    assert len({motion.motion_id for motion in motions}) == 3
    for motion in motions:
        peak_g = orbit_rotd50(motion.accel_1_mps2, motion.accel_2_mps2) / G_MPS2
        assert peak_g == pytest.approx(1.2)


@pytest.mark.parametrize(
    ("changes", "sound"), [({}, 1.0), ({"max_iterations": 2, "mean_iterations": 1.0}, 0.0)]
)
def test_analyses_of_the_hard_set_count_if_they_end_well(changes, sound):
    study, settings = Study("hard-set"), AnalysisSettings(duration_s=3.0, **changes)
    run_hard_set(study, ONE, settings)
    (row,) = study.comparisons
    assert (row.value, row.reference, row.is_passed) == (sound, 1.0, bool(sound))
    failed = f"{study.tables['rows']['motion_id'].iloc[0]}: timeout"
    assert study.tables["statuses"]["analyses"].tolist() == [1]
    rungs = study.tables["rungs"].set_index("rung")
    assert rungs["analyses"].sum() == 1
    assert rungs["steps_share"].sum() == pytest.approx(1.0)
    assert sound or all(word in row.quantity for word in failed.split(": "))


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
    journal = tmp_path / "accuracy.jsonl"
    journal.write_bytes(journal.read_bytes().rstrip()[:-20])  # as a kill leaves the last line
    slugs, lines, analyse = [], [], strong_motions.analyse
    monkeypatch.setattr(strong_motions, "REPORT_EACH", 1)
    monkeypatch.setattr(
        strong_motions, "analyse", lambda *given: slugs.append(given[0].slug) or analyse(*given)
    )
    second = Study("accuracy", tmp_path, lines.append)
    run_accuracy(second, TINY, ("fast", "default"))
    assert len(slugs) == 1
    assert lines[0].startswith(f"8 of 8 analyses, 0 min left; last: {slugs[0]}")
    assert second.tables["ratios"].equals(table)
    assert second.comparisons == first.comparisons


def judged(demand, changes, refinement=REFINEMENTS[0]):
    """Return whether the largest change of a demand and the share above its limit pass."""
    study = Study("convergence")
    table = pd.DataFrame(dict.fromkeys(CHANGES, 0.0), index=range(len(changes)))
    judge_changes(study, table.assign(**{demand: changes}), refinement)
    rows = [row for row in study.comparisons if row.quantity.startswith(demand)]
    assert all(row.is_passed for row in study.comparisons if row not in rows)
    return [row.is_passed for row in rows if row.tolerance is not None]


@pytest.mark.parametrize(
    ("demand", "changes", "passed"),
    [
        ("column_shear_kn", [0.01] * 20, [True, True]),
        ("column_shear_kn", [-0.014] + [0.0] * 19, [True, True]),  # one case of twenty
        ("column_shear_kn", [0.016] + [0.0] * 19, [False, True]),  # by more than half
        ("column_shear_kn", [0.014, -0.014] + [0.0] * 18, [True, False]),
        ("column_shear_kn", [inf] + [0.0] * 19, [False, True]),
        ("deck_rotation_rad", [0.03] * 20, [True, True]),
        ("deck_rotation_rad", [0.031] + [0.0] * 19, [False, True]),  # without exception
        ("slip_work_kj", [0.5] * 20, []),
    ],
)
def test_changes_are_judged_by_their_size_and_their_share(demand, changes, passed):
    assert judged(demand, changes) == passed


def test_changes_of_the_reference_itself_are_reported_only():
    assert judged("column_shear_kn", [0.5] * 20, REFINEMENTS[1]) == []


def test_changes_up_to_the_floor_count_as_none():
    exact = pd.Series([1.0e-3, 1.0e-3, 0.0, nan, 1.0e-3])
    values = pd.Series([1.09e-3, 1.2e-3, 0.9e-4, nan, nan])
    found = relative_changes("deck_rotation_rad", values, exact)
    assert found.tolist() == pytest.approx([0.0, 0.2, 0.0, 0.0, inf])
    assert relative_changes("unseating_m", values, exact).iloc[0] == pytest.approx(0.09)


def test_each_case_is_compared_with_finer_steps_and_meshes():
    one = replace(
        CONVERGENCE, bridges=("osb1",), skews_deg=(30,), gaps_mm=(25,), motion_count=1, window_s=2.1
    )
    meshes = [each for each in REFINEMENTS if each.kind == "mesh"]
    study = Study("convergence-mesh")
    compare_with_finer(study, replace(one, processes=1), meshes)
    changes = study.tables["changes"].set_index("against")
    assert list(changes.index) == ["9 wall points", "17 wall points", "fine fibers"]
    assert (changes["numerics"] == "default").all()
    # every mesh changes the forces a little
    assert (changes["column_shear_kn"].abs() > 0.0).all()
    assert (changes["column_shear_kn"].abs() < 0.01).all()


def test_accuracy_pairs_neighbours_on_every_axis():
    found = pairs(ACCURACY["accuracy"])
    axes = ("friction_pct", "gap_mm", "skew_deg")
    assert [sum(name == axis for name, *_ in found) for axis in axes] == [6, 6, 8]
    for axis, before, after in found:
        assert replace(before, **{axis: getattr(after, axis)}) == after
        assert getattr(after, axis) > getattr(before, axis)


BOTH = ("default", "reference")


def made_up(chosen, ratios):
    """Return peaks that grow by a ratio per motion and accuracy wherever there is friction."""
    size = {"default": 1.0, "reference": 2.0}
    return {
        (accuracy, variant, motion): dict.fromkeys(
            DEMANDS, size[accuracy] * (ratio if variant.friction_pct else 1.0)
        )
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
