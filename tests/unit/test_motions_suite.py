"""Suites of motions: files of a folder, factors, stripes, searches, cuts."""

import hashlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motions_files import at2_text, index_of, make_pairs, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions.conditioning import (
    cut_to_strongest,
    effect_on_measures,
    strongest_part,
    trim_quiet_ends,
)
from skewbridge.motions.folder import list_motions
from skewbridge.motions.intensity import IM_COLUMNS, displacement, velocity
from skewbridge.motions.levels import (
    LEVEL_MEASURE,
    LEVEL_RANGE_G,
    block_factors,
    block_targets,
    bracket_capacity,
    most_trials,
    striped,
)
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import prepare_suite, read_suite, write_suite
from skewbridge.motions.synthesis.ddk18 import Scenario
from skewbridge.motions.synthesis.generate import synthesize


def test_parquet_preserves_the_suite_of_a_folder_bit_for_bit(tmp_path):
    (first, second), *_ = make_pairs(tmp_path, 2)
    suite = prepare_suite(tmp_path, t1_s=0.7)
    assert list(suite["motion_id"]) == ["q0", "q1"]
    assert np.isfinite(suite[list(IM_COLUMNS)]).all(axis=None)
    both = hashlib.sha256(first.read_bytes() + second.read_bytes()).hexdigest()
    assert suite["sha256"][0] == both  # of both files in order
    write_suite(suite, tmp_path / "suite.parquet")
    back = read_suite(tmp_path / "suite.parquet")
    assert [item.motion.motion_id for item in back] == ["q0", "q1"]
    for item, (_, row) in zip(back, suite.iterrows(), strict=True):
        np.testing.assert_array_equal(item.motion.accel_1_mps2, row["accel_1_mps2"])
        assert item.scale == row["scale"]
        assert item.measures["im_pga_rotd50_g"] == row["im_pga_rotd50_g"] * row["scale"]
        assert item.measures["im_arias_mps"] == pytest.approx(row["im_arias_mps"] * item.scale**2)


def test_factor_does_not_depend_on_the_count_which_the_folder_limits(tmp_path):
    make_pairs(tmp_path, 9)
    all_motions = prepare_suite(tmp_path, t1_s=0.7)
    three = prepare_suite(tmp_path, count=3, t1_s=0.7)
    assert list(three["scale"]) == list(all_motions["scale"][:3])
    with pytest.raises(InputError, match=r"count = 10, but .* has 9"):
        prepare_suite(tmp_path, count=10, t1_s=0.7)


def test_factor_of_the_index_overrides_the_computed_one_at_its_period(tmp_path):
    pairs = make_pairs(tmp_path, 2)
    index_of(tmp_path, pairs, scale=[1.25, ""])
    scales = prepare_suite(tmp_path, t1_s=0.7)["scale"]
    assert scales[0] == 1.25 != scales[1]
    index_of(tmp_path, pairs, scale=[1.25, 1.5], scale_t1_s=[0.7, 0.7])
    assert list(prepare_suite(tmp_path, t1_s=0.7)["scale"]) == [1.25, 1.5]
    other = prepare_suite(tmp_path, t1_s=0.8)
    reached_g = other["scale"] * other["im_saavg_rotd50_g"]
    assert not set(other["scale"]) & {1.25, 1.5}
    assert reached_g.between(*LEVEL_RANGE_G).all()


def test_index_metadata_reaches_the_table(tmp_path):
    pairs = make_pairs(tmp_path, 1)
    index_of(
        tmp_path, pairs, event=["Big One"], station=["Array #9"], magnitude=[7.1], vs30_mps=[400],
        azimuth_1_deg=[0], source=["a source"], licence=["a licence"],
    )  # fmt: skip
    row = prepare_suite(tmp_path, t1_s=0.7).iloc[0]
    assert row["station"] == "Array #9"
    assert (row["event"], row["magnitude"], row["vs30_mps"]) == ("Big One", 7.1, 400.0)
    assert np.isnan(row["distance_km"])
    # the files have 90 degrees in both headers
    assert (row["azimuth_1_deg"], row["azimuth_2_deg"]) == (0.0, 90.0)
    assert row["source"] == "a licence; a source"


def test_two_blocks_interleave_and_an_incomplete_block_fills_the_range_alone():
    own_g = np.random.default_rng(1).lognormal(-1.0, 0.5, 20)
    factors = block_factors(own_g, (0.1, 1.5))
    shares = np.log(own_g * factors / 0.1) / np.log(15.0)
    for block, offset in ((slice(0, 8), 1 / 2), (slice(8, 16), 1 / 4)):
        np.testing.assert_allclose(np.sort(shares[block]), (np.arange(8) + offset) / 8)
        assert (np.argsort(shares[block]) == np.argsort(own_g[block])).all()
    np.testing.assert_allclose(np.sort(shares[16:]), (np.arange(4) + 3 / 4) / 4)
    np.testing.assert_array_equal(block_factors(own_g[:16], (0.1, 1.5)), factors[:16])
    # the sequence of van der Corput
    for block, offset in enumerate((0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875)):
        share = (np.arange(8) + offset) / 8
        np.testing.assert_array_equal(block_targets(block, 8, (0.1, 1.5)), 0.1 * 15.0**share)


def test_pairs_are_found_in_sub_folders_among_other_files_and_ordered_by_the_index(tmp_path):
    pairs = make_pairs(tmp_path, 2)
    (tmp_path / "notes.txt").write_text("Downloaded on Monday.\n")
    (tmp_path / "table.csv").write_text("RSN,PGA\nRSN6,0.2\n")
    (tmp_path / "_SearchResults.csv").write_text("1,2\n3,4\n")
    (tmp_path / "q0_h1.VT2").write_text("velocity\n")
    (tmp_path / "q0_UP.AT2").write_text("vertical\n")
    assert [entry.motion_id for entry in list_motions(tmp_path)] == ["q0", "q1"]
    index_of(tmp_path, pairs[::-1])
    assert [entry.motion_id for entry in list_motions(tmp_path)] == ["q1", "q0"]
    for name in ("kobe", "chichi"):
        (tmp_path / "sub" / name).mkdir(parents=True)
        make_pairs(tmp_path / "sub" / name, 1)
    found = list_motions(tmp_path / "sub")
    assert len({entry.motion_id for entry in found}) == 2
    assert {entry.components[0][0].parent.name for entry in found} == {"kobe", "chichi"}


def test_components_differ_in_length_with_a_message_and_never_in_their_step(tmp_path, caplog):
    (first, second), *_ = make_pairs(tmp_path, 1)
    first.write_text(at2_text(shaken_g(0, 390)))
    motion = read_motion(first, second)
    assert motion.npts == 400
    assert not motion.accel_1_mps2[-10:].any()
    prepare_suite(tmp_path, t1_s=0.7)
    assert "zeros added" in caplog.text
    second.write_text(at2_text(shaken_g(0), 0.02))
    with pytest.raises(InputError, match=r"q0_h1\.AT2 is 0\.01 s, of q0_h2\.AT2 0\.02 s"):
        read_motion(first, second)


# --- stripes and the search of a capacity


#: Factors between which the searches look.
LIMITS = (0.1, 10.0)


@pytest.fixture
def three(tmp_path):
    make_pairs(tmp_path, 3)
    return prepare_suite(tmp_path, t1_s=0.7)


def test_scaled_motions_reach_their_stripe_and_are_preserved_by_parquet(three, tmp_path):
    low_g = three[LEVEL_MEASURE].median()
    table = striped(three, [low_g, 2 * low_g], factor_limits=(1e-3, 1e3))
    np.testing.assert_allclose(table["scale"] * table[LEVEL_MEASURE], table["stripe_g"])
    assert len(table) == 6
    assert not table.duplicated(["motion_id", "scale"]).any()
    write_suite(table, tmp_path / "stripes.parquet")
    back = read_suite(tmp_path / "stripes.parquet")
    assert [item.motion.motion_id for item in back] == ["q0", "q1", "q2"] * 2
    levels_g = [item.measures[LEVEL_MEASURE] for item in back]
    np.testing.assert_allclose(levels_g, [low_g] * 3 + [2 * low_g] * 3)


def test_factors_outside_the_limits_are_left_out_and_counted(three, caplog):
    level_g = three[LEVEL_MEASURE].iloc[0]
    table = striped(three, [level_g], factor_limits=(0.999, 1.001))
    assert table[["motion_id", "scale"]].to_numpy().tolist() == [["q0", 1.0]]
    assert "2 of 3 scaled motions are left out" in caplog.text
    known = three.assign(**{LEVEL_MEASURE: [0.2, 0.4, 100.0]})
    rows = striped(known, [0.1, 1.0])[["motion_id", "scale"]].to_numpy().tolist()
    assert rows == [["q0", 0.5], ["q1", 0.25], ["q1", 2.5]]
    with pytest.raises(InputError, match="no motion reaches"):
        striped(three, [1e4])


def searched(capacity: float, limits: tuple[float, float], tolerance: float = 0.01):
    """Return the bracket of a capacity and the number of analyses of the search."""
    trials: list[float] = []

    def exceeds(scale: float) -> bool:
        trials.append(scale)
        return scale >= capacity

    return bracket_capacity(exceeds, limits=limits, tolerance=tolerance), len(trials)


@settings(max_examples=200)
@given(st.floats(0.05, 20.0), st.floats(1.001, 1e3), st.floats(1e-4, 0.5))
def test_search_takes_at_most_the_forecast_analyses(capacity, ratio, tolerance):
    limits = (0.1, 0.1 * ratio)
    _, analyses = searched(capacity, limits, tolerance)
    assert analyses <= most_trials(limits, tolerance)


@settings(max_examples=200)
@given(capacity=st.floats(1e-3, 1e3))
def test_bracket_contains_any_capacity_within_ten_analyses(capacity):
    (lower, upper), analyses = searched(capacity, LIMITS)
    assert analyses <= most_trials(LIMITS) == 10
    assert lower <= capacity <= upper
    if 0.1 < capacity <= 10.0:
        assert upper / lower <= 1.01
    else:
        assert lower == 0.0 or math.isinf(upper)


# --- cut motions


@pytest.fixture(scope="module")
def motion() -> GroundMotion:
    scenario = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
    return synthesize(scenario, index=0, seed=2023)


def test_cut_motion_ends_at_rest_with_zeros_after_it(motion):
    cut = cut_to_strongest(motion, 20.0, 5.0)
    assert cut.npts == 2500
    for accel in cut.components:
        assert np.all(accel[-500:] == 0.0)
        speed, disp = velocity(accel, cut.dt_s), displacement(accel, cut.dt_s)
        assert abs(speed[-1]) < 1e-9 * np.abs(speed).max()
        assert abs(disp[-1]) < 1e-9 * np.abs(disp).max()
    for impossible in ((0.0, 0.0), (20.0, -1.0)):
        with pytest.raises(InputError):
            cut_to_strongest(motion, *impossible)


def test_cut_keeps_the_strongest_window_with_a_message_and_another_digest(motion):
    assert effect_on_measures(motion, cut_to_strongest(motion, 20.0, 5.0))["arias_ratio"] > 0.95
    assert effect_on_measures(motion, cut_to_strongest(motion, 5.0, 0.0))["arias_ratio"] < 0.9
    done = strongest_part(motion, 10.0)
    assert done.sha256 != motion.sha256
    assert "of the Arias intensity left" in done.messages[-1]
    assert done.duration_s == pytest.approx(10.0, abs=0.011)


def test_trimming_quiet_ends_preserves_the_spectrum(motion):
    effect = effect_on_measures(motion, trim_quiet_ends(motion))
    ratios = np.array([value for name, value in effect.items() if name.startswith("psa")])
    # the displacement left at the new end is taken off: felt at 2 and 3 s only
    np.testing.assert_allclose(ratios[:-2], 1.0, atol=0.002)
    np.testing.assert_allclose(ratios[-2:], 1.0, atol=0.02)
    assert trim_quiet_ends(motion).duration_s < 0.8 * motion.duration_s


def test_suite_can_be_cut(tmp_path):
    make_pairs(tmp_path, 1)
    whole = prepare_suite(tmp_path, t1_s=0.7)
    cut = prepare_suite(tmp_path, t1_s=0.7, shaking_s=3.0)
    assert cut["npts"][0] == 300 < whole["npts"][0]
    assert cut["sha256"][0] != whole["sha256"][0]
