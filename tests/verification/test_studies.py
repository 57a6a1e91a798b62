"""Studies of many analyses: strong motions, published curves, the paper's bridges."""

from dataclasses import replace
from itertools import product
from math import inf, nan
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest

from fragility_tables import runs_of_one_variant
from skewbridge.analysis import step_loop
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.fragility.limit_states import hazus_factor
from skewbridge.motions.intensity import orbit_rotd50
from skewbridge.study import task
from skewbridge.units import G_MPS2
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.verification.registry import Study, run_study
from skewbridge.verification.statements import STATEMENTS
from skewbridge.verification.studies import bridge_friction, published, strong_motions
from skewbridge.verification.studies.paper_runs import strongest_motions

ROLLER = GridConfig(bridge=("osb1",), abutment=("roller",), skew_deg=(0,), friction=(0.0,))
ONE = replace(strong_motions.STRESS_CASES, grid=ROLLER, motion_count=1, processes=1)
# motions cut to 2 s of shaking beyond their tapers; two of them, friction alone
SHORT = {"window_s": 2.1, "processes": 1}
PLACE = GridConfig(bridge=("osb1",), skew_deg=(0,), gap_mm=(25,))
TINY = replace(strong_motions.ACCURACY, grid=PLACE, motion_count=2, **SHORT)
BOTH = ("default", "reference")
PUBLISHED = published.published_curves()
T_S = np.linspace(0.0, 4.0, 401)


def test_the_hard_set_is_whole_and_reaches_its_peak_and_analyses_count_if_they_end_well(
    tmp_path, monkeypatch
):
    assert len(expand_grid(strong_motions.STRESS_CASES.grid)) == 45
    motions = strongest_motions(3, strong_motions.STRESS_CASES.pga_g)
    assert len({motion.motion_id for motion in motions}) == 3
    for motion in motions:
        assert orbit_rotd50(motion.accel_1_mps2, motion.accel_2_mps2) / G_MPS2 == pytest.approx(1.2)
    for mean_iterations, sound in ((step_loop.MEAN_ITERATIONS, 1.0), (1, 0.0)):
        monkeypatch.setattr(step_loop, "MEAN_ITERATIONS", mean_iterations)
        study = Study("hard-set", tmp_path / f"{sound}")
        strong_motions.run(study, ONE, AnalysisSettings(duration_s=3.0))
        (row,) = study.comparisons
        assert (row["value"], row["reference"], row["pass"]) == (sound, 1.0, bool(sound))
        rungs = study.tables["rungs"].set_index("rung")
        assert (rungs["analyses"].sum(), rungs["steps_share"].sum()) == (1, pytest.approx(1.0))
        motion_id = study.tables["rows"]["motion_id"].iloc[0]
        assert sound or all(word in row["quantity"] for word in (motion_id, "timeout"))


def test_resume_of_the_accuracy_repeats_only_the_line_cut_short(monkeypatch, tmp_path):
    first = Study("accuracy", tmp_path)
    strong_motions.run_pairs(first, TINY, ("fast", "default"))
    table = first.tables["ratios"]
    assert len(table) == 2 * len(strong_motions.DEMANDS)  # one place, and all of them
    assert set(table["count"]) == {2}
    assert (tmp_path / "accuracy.jsonl").read_text().count('"run_key"') == 8
    summary, failed = first.comparisons[-2:]
    assert summary["value"] == pytest.approx(table["difference_percent"].abs().max())
    assert "largest difference of 8 pooled ratios" in summary["quantity"]
    assert failed["value"] == 0.0
    journal = tmp_path / "accuracy.jsonl"
    journal.write_bytes(journal.read_bytes().rstrip()[:-20])  # as a kill leaves the last line
    analyse, lines = Mock(wraps=task.analyse), []
    monkeypatch.setattr(strong_motions, "REPORT_EACH", 1)
    monkeypatch.setattr(task, "analyse", analyse)
    second = Study("accuracy", tmp_path, lines.append)
    strong_motions.run_pairs(second, TINY, ("fast", "default"))
    ((variant, *_), _), *others = analyse.call_args_list
    assert not others
    assert lines[0].startswith(f"8 of 8 analyses; last: {variant.slug}")
    assert second.tables["ratios"].equals(table)
    assert second.comparisons == first.comparisons


def judged(demand, changes, refinement=strong_motions.STEPS[0]):
    """Return whether the largest change of a demand and the share above its limit pass."""
    study = Study("convergence")
    table = pd.DataFrame(dict.fromkeys(strong_motions.CHANGES, 0.0), index=range(len(changes)))
    strong_motions.judge_changes(study, table.assign(**{demand: changes}), refinement)
    rows = [row for row in study.comparisons if row["quantity"].startswith(demand)]
    assert all(row["pass"] for row in study.comparisons if row not in rows)
    return [row["pass"] for row in rows if row["tolerance"] is not None]


def test_changes_are_judged_by_their_size_and_their_share():
    for demand, changes, passed in (
        ("column_shear_kn", [0.01] * 20, [True, True]),
        ("column_shear_kn", [-0.014] + [0.0] * 19, [True, True]),  # one case of twenty
        ("column_shear_kn", [0.016] + [0.0] * 19, [False, True]),  # by more than half
        ("column_shear_kn", [0.014, -0.014] + [0.0] * 18, [True, False]),
        ("column_shear_kn", [inf] + [0.0] * 19, [False, True]),
        ("deck_rotation_rad", [0.03] * 20, [True, True]),
        ("deck_rotation_rad", [0.031] + [0.0] * 19, [False, True]),  # without exception
        ("slip_work_kj", [0.5] * 20, []),
    ):
        assert judged(demand, changes) == passed
        # those of the reference itself are only reported
        assert judged(demand, changes, strong_motions.STEPS[1]) == []
    # changes up to the floor count as none
    exact = pd.Series([1.0e-3, 1.0e-3, 0.0, nan, 1.0e-3])
    values = pd.Series([1.09e-3, 1.2e-3, 0.9e-4, nan, nan])
    found = strong_motions.relative_changes("deck_rotation_rad", values, exact)
    assert found.tolist() == pytest.approx([0.0, 0.2, 0.0, 0.0, inf])
    found = strong_motions.relative_changes("unseating_m", values, exact)
    assert found.iloc[0] == pytest.approx(0.09)


def made_up(ratios, **values):
    """Peaks that grow by a ratio per accuracy and motion wherever there is friction."""
    grid = GridConfig(bridge=("osb1",), **values)
    sizes = dict(zip(BOTH, (1.0, 2.0), strict=True))
    rows = []
    for ((accuracy, motion), ratio), place in product(ratios.items(), expand_grid(grid)):
        row = {name: getattr(place, name) for name in ("skew_deg", "gap_mm", "friction_pct")}
        size = sizes[accuracy] * (ratio if place.friction_pct else 1.0)
        row |= {"numerics": accuracy, "motion_id": motion}
        rows.append(row | dict.fromkeys(strong_motions.DEMANDS, size))
    return pd.DataFrame(rows)


def test_ratios_are_geometric_means_over_motions_and_over_places():
    ratios = dict(zip(product(BOTH, "ab"), (1.2, 0.9, 1.1, 0.9), strict=True))
    table = strong_motions.pooled_ratios(made_up(ratios, skew_deg=(0, 30, 60)), BOTH)
    pooled = table[table["place"] == strong_motions.ALL_PLACES]
    steps = set(zip(pooled["axis"], pooled["from_value"], pooled["to_value"], strict=True))
    skews = {("skew_deg", 0, 30), ("skew_deg", 30, 60)}  # neighbours only
    assert steps == {("friction_pct", 0, 50), ("gap_mm", 25, 51)} | skews
    friction = table[table["axis"] == "friction_pct"]
    assert len(friction) == len(strong_motions.DEMANDS) * (6 + 1)
    assert set(pooled.loc[pooled["axis"] == "friction_pct", "count"]) == {12}
    assert "skew_deg 30, gap_mm 25" in set(friction["place"])
    assert friction["ratio"].to_numpy() == pytest.approx((1.2 * 0.9) ** 0.5)
    assert friction["exact_ratio"].to_numpy() == pytest.approx((1.1 * 0.9) ** 0.5)
    difference = 100 * ((1.2 / 1.1) ** 0.5 - 1)
    assert friction["difference_percent"].to_numpy() == pytest.approx(difference)
    assert table.loc[table["axis"] != "friction_pct", "ratio"].to_numpy() == pytest.approx(1.0)
    # a motion without the demand is left out of both
    peaks = made_up(dict.fromkeys(product(BOTH, "ab"), 1.5), skew_deg=(0,), gap_mm=(25,))
    last = peaks.index[(peaks["numerics"] == "reference") & (peaks["motion_id"] == "b")][0]
    peaks.loc[last, "unseating_m"] = 0.0
    table = strong_motions.pooled_ratios(peaks, BOTH)
    counts = table[table["place"] == strong_motions.ALL_PLACES].set_index("demand")["count"]
    assert counts.to_dict() == dict.fromkeys(strong_motions.DEMANDS, 2) | {"unseating_m": 1}


def test_medians_of_demands_that_follow_the_published_line_are_the_published_ones():
    """40 runs whose demands are the capacities of era 3 at the published medians, with scatter."""
    random = np.random.default_rng(5)
    im = np.geomspace(0.05, 2.5, 40)
    demands = runs_of_one_variant("osb1_cf_skew00_gap025_mu050", "osb1", 0, im)
    demands["beyond_model"] = ""
    era = PUBLISHED[(PUBLISHED["era"] == 3) & (PUBLISHED["state"] == "slight")]
    for row in era.to_dict("records"):
        if row["component"] in published.DEMANDS:
            capacity = row["capacity"] * (0.0254 if row["unit"] == "in" else 1.0)
            demand = capacity * im / row["median_g"] * np.exp(0.3 * random.standard_normal(im.size))
            demands[published.WHOLE + published.DEMANDS[row["component"]]] = demand
    for name in published.DEMANDS.values():  # columns fail at once
        demands[name] = 1e-3
    curves = PUBLISHED[PUBLISHED["era"] == 3]
    found = published.medians(curves, demands, 3, published.NONE)
    assert found["theta_bound"].isna().any()
    table = published.compared(PUBLISHED, found).set_index(["component", "state"])
    slight = table.xs("slight", level="state")
    assert slight["ratio"].drop(published.SYSTEM).to_numpy() == pytest.approx(1.0, rel=0.15)
    assert (slight["ratio_low"] < slight["ratio"]).all()
    # the smaller capacity of the curve lowers the median by as much as the line is steep
    change = published.Change(name="capacity", capacity="capacity_of_curve")
    lower = published.medians(curves, demands, 3, change).set_index(["component", "state"])
    key = "unseating", "slight"
    assert lower.loc[key, "theta"] / table.loc[key, "theta"] == pytest.approx(1 / 1.5, rel=0.1)
    # a state that no run reaches has a lower bound of its median
    demands[[f"{published.WHOLE}{name}" for name in published.DEMANDS.values()]] *= 1e-3
    found = published.medians(curves, demands, 3, published.NONE)
    found = found[found["component"] != published.SYSTEM]
    assert found["theta"].isna().all()
    # 40 runs up to 2.5 g, assumed dispersion 0.4
    assert found["theta_bound"].between(1.0, 2.5).all()


def test_a_change_explains_a_ratio_if_it_closes_half_of_its_distance_from_the_range():
    assert published.outside(1.0) == published.outside(1.33) == 0.0
    assert published.outside(0.75 / 2.0) == pytest.approx(np.log(2.0))
    rows = [
        ("bearing", "none", 1.1), ("bearing", "gap", 1.0),
        ("unseating", "none", 1.33 * 2.0), ("unseating", "gap", 1.33 * 1.3),
        ("unseating", "bridge", 1.33 * 1.8), ("column_curvature", "none", 1.33 * 2.0),
        ("column_curvature", "gap", 1.33 * 1.6), ("column_curvature", "bridge", np.nan),
    ]  # fmt: skip
    table = pd.DataFrame(rows, columns=["component", "change", "ratio"])
    found = published.explanations(table.assign(era=3, state="slight")).set_index("component")
    reasons = {"bearing": ["none", True], "unseating": ["gap", True]}
    reasons["column_curvature"] = ["gap", False]
    assert found[["change", "is_explained"]].T.to_dict("list") == reasons


def test_effects_of_skew_are_those_of_demands_that_grow_by_a_fifth():
    """24 motions, of which one has not the demand of one column."""
    random = np.random.default_rng(3)
    im = np.geomspace(0.05, 2.5, 24)
    parts = []
    for skew, factor in ((0, 1.0), (60, 1.2)):
        variant = f"bridge_b_cf_skew{skew:02d}_gap025_mu050"
        part = runs_of_one_variant(variant, "bridge_b", skew, im).assign(choice="none")
        for name in sorted({*published.COMPARED, *published.DEMANDS.values()}):
            scatter = np.exp(0.02 * random.standard_normal(im.size))
            part[f"{published.WHOLE}{name}"] = factor * 8.0 * im * scatter
        parts.append(part)
    table = pd.concat(parts, ignore_index=True)
    factors = published.median_factors(table).set_index("demand")
    assert factors.loc["column_curvature/moderate", "ratio"] == pytest.approx(1 / 1.2, rel=0.03)
    lacks = (table["motion_id"] == "m00") & (table["skew_deg"] == 60)
    table.loc[lacks, f"{published.WHOLE}abutment_passive_m"] = 0.0
    found = published.demand_ratios(table)
    assert set(found["demand"]) == set(published.COMPARED)
    assert (found["skew_deg"] == 60).all()
    assert found["ratio"].to_numpy() == pytest.approx(1.2, rel=0.03)
    assert (found["ratio_low"] < 1.2 * 1.03).all()
    assert (found["ratio_high"] > 1.2 * 0.97).all()
    count = found.set_index("demand")["n_motions"]
    assert (count["abutment_passive_m"], count["unseating_m"]) == (23, 24)
    # Hazus tables round 0.983, 0.931, 0.841 and 0.707 for 15, 30, 45 and 60 degrees
    factors = [hazus_factor(skew) for skew in (0, 15, 30, 45, -60)]
    assert factors == pytest.approx([1.0, 0.983, 0.931, 0.841, 0.707], abs=5e-4)


def test_half_cycles_lie_between_zero_crossings_and_notice_contact():
    plain, no_contact = np.sin(2 * np.pi * T_S), np.zeros(T_S.size, dtype=bool)
    both = np.column_stack([plain, plain])
    smooth = bridge_friction.DeckMotion(both, no_contact)
    cycles = bridge_friction.half_cycles((smooth._replace(disp_m=0.9 * both), smooth), 0)
    assert cycles["change"].tolist() == pytest.approx([-0.1] * 8)
    assert cycles["together"].tolist() == pytest.approx([1.0] * 8)
    assert not cycles["has_contact"].any()
    both *= np.where(T_S < 2.0, 1.0, 0.1)[:, None]  # small half cycles are left out
    rough = bridge_friction.DeckMotion(both, (T_S > 0.2) & (T_S < 0.3))
    cycles = bridge_friction.half_cycles((rough, smooth._replace(disp_m=both)), 1)
    assert cycles["has_contact"].tolist() == [True, False, False, False]
    # changes between sticking and slipping count while closed
    normal = np.array([[0.0], [10.0], [10.0], [10.0], [10.0], [0.0], [10.0]])
    friction = np.array([[0.0], [5.0], [2.0], [5.0], [5.0], [0.0], [1.0]])
    assert bridge_friction.stick_slip_changes(normal, friction, 0.5) == 2


@pytest.mark.slow
@pytest.mark.parametrize("study", ["fig10", "fig11-12", "friction-source", "ladder"])
def test_dynamic_study_passes_and_judges_its_statements(study):
    found = run_study(study)
    assert not [row["quantity"] for row in found.comparisons if not row["pass"]]
    assert bool(found.figures) is (study != "friction-source")  # that one is no figure of the paper
    judged = {row["quantity"] for row in found.statement_rows() if row["case"]}
    assert judged >= {row.claim for row in STATEMENTS.values() if row.study == study}
