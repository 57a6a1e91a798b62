"""Blocks: the variants that each motion runs, their balance and levels, the list of analyses."""

from collections import Counter
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from motions_files import index_of, make_pairs
from skewbridge.demands.tables import join_variants
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame
from skewbridge.motions.blocks import assign, placed, planned_runs, unread
from skewbridge.motions.levels import BLOCK, LEVEL_MEASURE, BlocksConfig
from skewbridge.study.analyses import StudySetup, analyse_variant, analyses_s
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import band_medians, medians_of, prepare_motions
from skewbridge.study.rounds import whole_blocks
from skewbridge.study.task import run_key
from skewbridge.variant.grid import GridConfig, cells_of, expand_grid
from study_parts import row_of, study_of, wave, without_workers

LEVELS_G = np.random.default_rng(3).lognormal(size=48)
GRID = {"bridge": ["osb1"], "skew_deg": [0, 60], "gap_mm": [25, 51], "friction": [0.0, 0.5]}
MOTIONS = {"blocks": {}, "incidence_deg": [0.0, 90.0]}


def runs_of(share: float, *, incidences: int = 2, per_motion: int = 1, levels_g=LEVELS_G):
    blocks = BlocksConfig(cells_per_motion=per_motion, complete_share=share)
    return assign(levels_g, 4, incidences, blocks)


def bands(runs: np.ndarray, levels_g: np.ndarray = LEVELS_G) -> np.ndarray:
    """Return the number of runs of each cell by the rank of the level within its group."""
    counts = np.zeros((BLOCK, runs.shape[2]), dtype=int)
    for start in range(0, len(runs), BLOCK):
        counts += runs[start + np.argsort(levels_g[start : start + BLOCK])].sum(axis=1)
    return counts


def pairs(runs: np.ndarray) -> list[int]:
    together = runs.any(axis=1)
    return [int((together[:, a] & together[:, b]).sum()) for a, b in combinations(range(4), 2)]


@pytest.mark.parametrize("per_motion", [1, 2])
def test_two_orientations_of_a_motion_have_different_cells_and_are_balanced(per_motion) -> None:
    runs = runs_of(0.0, per_motion=per_motion)
    assert (runs.sum(axis=(1, 2)) == 2 * per_motion).all()
    assert (runs.any(axis=1).sum(axis=1) == 2 * per_motion).all()  # the cells differ
    assert (runs.sum(axis=0) == 12 * per_motion).all()
    assert (bands(runs) == 3 * per_motion).all()
    if per_motion == 1:
        assert pairs(runs) == [8] * 6  # 16 of the diagonals, 32 of the sides
    else:  # effects of gap and friction are differences under one motion and orientation
        assert [pairs(runs[:, [angle]]) for angle in (0, 1)] == [[8] * 6] * 2


@pytest.mark.parametrize(
    ("incidences", "per_motion", "analyses"), [(2, 1, 120), (1, 1, 72), (1, 2, 112)]
)
def test_a_sixth_of_the_motions_runs_all_cells(incidences, per_motion, analyses) -> None:
    runs = runs_of(1 / 6, incidences=incidences, per_motion=per_motion)
    complete = runs.all(axis=2)
    assert runs.sum() == analyses
    assert (complete.sum(axis=0) == 8 // incidences).all()
    assert np.ptp(runs.sum(axis=0)) == 0  # every cell equally often at each incidence
    assert (np.ptp(bands(runs), axis=1) <= 1).all()
    assert np.ptp(pairs(runs)) <= 3


def test_added_motions_keep_the_cells_of_full_groups_and_a_round_adds_whole_blocks() -> None:
    np.testing.assert_array_equal(runs_of(1 / 6, levels_g=LEVELS_G[:27])[:24], runs_of(1 / 6)[:24])
    assert runs_of(1.0, incidences=1).all()
    bridges = {"a0": "a", "a60": "a", "b0": "b", "b60": "b"}
    assert whole_blocks({"a0": 8, "a60": 12}, bridges) == {"a0": 12, "a60": 12}


@pytest.mark.parametrize("cells", [1, 2, 3, 6, 9])
def test_any_number_of_cells_is_balanced(cells: int) -> None:
    levels_g = np.arange(72.0)
    runs = assign(levels_g, cells, 2, BlocksConfig(complete_share=0.0))
    assert (runs.sum(axis=(1, 2)) == 2).all()
    assert np.ptp(runs.sum(axis=(0, 1))) <= 1
    assert np.ptp(bands(runs, levels_g), axis=1).max() <= 1


def test_motions_run_every_skew_of_their_cells_and_all_cells_of_an_absent_axis() -> None:
    study = parse_config({"grid": GRID, "motions": MOTIONS})
    runs = planned_runs(study.grid, study.motions, unread(24))
    assert sum(map(len, runs.values())) == 2 * (2 * 24 + 4 * 3)
    for slug in runs:
        if "skew00" in slug:
            assert runs[slug] == runs[slug.replace("skew00", "skew60")]
    suites = [*unread(8, "a"), *unread(8, "b")]  # each suite is balanced in itself
    of_both = planned_runs(study.grid, study.motions, suites)
    own = planned_runs(study.grid, study.motions, unread(8, "a"))
    assert {slug: {run for run in of_both[slug] if run[0][0] == "a"} for slug in own} == own
    grid = GridConfig(**GRID | {"abutment": ["roller", "contact_friction"]})
    number, cells = cells_of(grid, ["skew_deg"])
    assert number == 4
    assert cells["osb1_ro_skew00_gap000_mu000"] == [0, 1, 2, 3]
    assert Counter(len(own) for own in cells.values()) == {1: 8, 4: 2}
    assert list(cells) == sorted(variant.slug for variant in expand_grid(grid))


def test_a_study_runs_and_expects_the_analyses_of_its_blocks(tmp_path, monkeypatch) -> None:
    waves = [wave(f"m{n}", number=n) for n in range(1, 9)]
    given = parse_config({"grid": GRID, "motions": MOTIONS})
    setup = study_of(tmp_path, *waves, grid=given.grid, motions=given.motions)
    planned = planned_runs(given.grid, given.motions, placed(waves))
    setup, asked = replace(setup, planned=planned), without_workers(monkeypatch)
    slug = "osb1_cf_skew60_gap025_mu050"
    analyse_variant(setup, slug, tmp_path / "v.parquet")
    done = {(t.motion.motion.motion_id, t.motion.scale, t.incidence_deg) for t in asked}
    assert done == planned[slug]
    assert 0 < len(done) < len(setup.tasks(slug)) == 16
    two = setup.of_motions(0, 2)  # a round has the same blocks
    own = {run for run in planned[slug] if run[0] in ("m1", "m2")}
    assert len(two.planned_tasks(slug)) == len(own)
    full = given.model_copy(update={"motions": replace(given.motions, blocks=None)})
    number = sum(map(len, planned.values()))
    share = analyses_s(given, [10.0] * 8) / analyses_s(full, [10.0] * 8)
    assert share == pytest.approx(number / (8 * 2 * 8))


def test_a_wrong_block_design_is_refused() -> None:
    for motions, words in (
        ({"blocks": {"within": ["width"]}}, "blocks.within: width is not an axis"),
        ({"blocks": {}, "incidence_deg": [0.0, 45.0, 90.0]}, "blocks need 1 or 2 incidence_deg"),
        ({"blocks": {"cells_per_motion": 3}}, "cells_per_motion"),
    ):
        with pytest.raises(InputError, match=words):
            parse_config({"motions": motions})


def levels_of(results: Path) -> list[float]:
    suite = read_frame(results / "motions/suite.parquet")
    return (suite["scale"] * suite[LEVEL_MEASURE]).tolist()


def test_a_pilot_finds_the_medians_and_counts_in_the_study(tmp_path, monkeypatch) -> None:
    """Every demand is 20 times Sa_avg: the medians are 5/20 and, of column failure, 1/20 g."""
    index_of(tmp_path, make_pairs(tmp_path, 24))
    states, results = tmp_path / "states.yaml", tmp_path / "results"
    states.write_text(
        "- {component: unseating, demand: unseating_m, unit: m, dispersion: 0.2, collapse: exceeds,"
        " citation: x, states: {slight: 5.0}, degrees: {slight: slight}}\n"
    )
    motions = {"folder": str(tmp_path), "count": 24, "bands": {"ratio": 1.5}, "blocks": {}}
    fits = {"fragility": {"limit_states": str(states)}}
    study = parse_config(
        {"results": str(results), "grid": GRID | {"skew_deg": [0]}, **fits}
        | {"motions": motions | {"level_range_g": [0.01, 1.0]}}
    )

    def answer(task):
        return row_of(task, value=20.0 * task.motion.measures[LEVEL_MEASURE])

    asked = without_workers(monkeypatch, answer)
    prepare_motions(study)
    assert len(asked) == 8 + 3  # eight motions in one cell, one of them in all four
    medians, levels_g = band_medians(study), levels_of(results)
    steps = (np.arange(8) + 0.5) / 8
    assert sorted(levels_g[:8]) == pytest.approx(0.01 * 100**steps, rel=1e-5)  # 6 digits
    assert medians == pytest.approx([0.25, 0.05], rel=0.34)  # between two of these levels
    away = np.abs(np.log(np.divide.outer(levels_g[8:], medians))) <= np.log(1.5) + 1e-5
    assert (away.sum(axis=0) == [8, 8]).all()
    assert away.any(axis=1).all()
    prepare_motions(study)  # with the medians found
    assert levels_of(results) == levels_g
    setup = StudySetup.of(study)
    paths = {v.slug: tmp_path / f"{v.slug}.parquet" for v in expand_grid(study.grid)}
    for slug, path in paths.items():
        analyse_variant(setup, slug, path)
    keys = [run_key(task) for task in asked]
    assert len(set(keys)) == len(keys) == sum(map(len, setup.planned.values()))
    # a later study may take its levels from this one
    join_variants([*paths.values()], results / "demands.parquet")
    later = parse_config({"motions": {"bands": {"study": str(results)}}, **fits})
    assert band_medians(later) == pytest.approx([0.25, 0.05], rel=0.1)  # more levels are near


def test_medians_separate_exceedance_and_states_out_of_reach_are_left_out() -> None:
    level_g = np.geomspace(0.1, 1.6, 9)
    rows = pd.DataFrame({LEVEL_MEASURE: level_g, "bridge": "b", "bearing_disp_m": 0.0})
    rows = rows.assign(column_shear_dcr=level_g, drift_over_capacity=level_g / 4, status="ok")
    rows = rows.assign(column_curvature_ductility=99.0, unseating_m=0.0, beyond_model="")
    medians = medians_of(parse_config({}), rows)
    # shear and column failure at 1, between two levels; flexure and the others never, or always
    assert medians == pytest.approx([np.sqrt(level_g[6] * level_g[7])] * 2, abs=1e-4)
    weak = rows.assign(column_shear_dcr=level_g * 0.35)  # the largest is 0.56: near its threshold
    assert medians_of(parse_config({}), weak) == pytest.approx([1.6] * 2)
    assert medians_of(parse_config({}), rows.assign(column_shear_dcr=level_g * 0.3)) == ()
