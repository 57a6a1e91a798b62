"""The suite: what a folder becomes, and the one factor of each motion."""

import hashlib

import numpy as np
import pytest

from motions_files import at2_text, index_of, make_pairs, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions.folder import list_motions
from skewbridge.motions.intensity import IM_COLUMNS
from skewbridge.motions.levels import LEVEL_RANGE_G, block_factors, block_targets
from skewbridge.motions.suite import prepare_suite, read_suite, write_suite


def test_folder_without_index_is_paired_by_name(tmp_path):
    make_pairs(tmp_path, 3)
    suite = prepare_suite(tmp_path, t1_s=0.7)
    assert list(suite["motion_id"]) == ["q0", "q1", "q2"]
    assert np.isfinite(suite[list(IM_COLUMNS)]).all(axis=None)


def test_parquet_preserves_the_suite_bit_for_bit(tmp_path):
    make_pairs(tmp_path, 2)
    suite = prepare_suite(tmp_path, t1_s=0.7)
    write_suite(suite, tmp_path / "suite.parquet")
    back = read_suite(tmp_path / "suite.parquet")
    assert [item.motion.motion_id for item in back] == ["q0", "q1"]
    for item, (_, row) in zip(back, suite.iterrows(), strict=True):
        np.testing.assert_array_equal(item.motion.accel_1_mps2, row["accel_1_mps2"])
        assert item.scale == row["scale"]
        assert item.measures["im_pga_rotd50_g"] == row["im_pga_rotd50_g"] * row["scale"]
        assert item.measures["im_arias_mps"] == pytest.approx(row["im_arias_mps"] * item.scale**2)


def test_digest_covers_both_files_in_order(tmp_path):
    (first, second), *_ = make_pairs(tmp_path, 1)
    expected = hashlib.sha256(first.read_bytes() + second.read_bytes()).hexdigest()
    assert prepare_suite(tmp_path, t1_s=0.7)["sha256"][0] == expected


def test_factor_does_not_depend_on_the_count(tmp_path):
    make_pairs(tmp_path, 9)
    all_motions = prepare_suite(tmp_path, t1_s=0.7)
    three = prepare_suite(tmp_path, count=3, t1_s=0.7)
    assert list(three["scale"]) == list(all_motions["scale"][:3])


def test_factor_of_the_index_overrides_the_computed_one(tmp_path):
    pairs = make_pairs(tmp_path, 2)
    index_of(tmp_path, pairs, scale=[1.25, ""])
    scales = prepare_suite(tmp_path, t1_s=0.7)["scale"]
    assert scales[0] == 1.25
    assert scales[1] != 1.25


def test_factor_of_the_index_applies_only_to_its_period(tmp_path):
    pairs = make_pairs(tmp_path, 2)
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


def test_count_above_the_number_of_motions_is_refused(tmp_path):
    make_pairs(tmp_path, 2)
    with pytest.raises(InputError, match=r"count = 3, but .* has 2"):
        prepare_suite(tmp_path, count=3, t1_s=0.7)


def test_two_blocks_interleave_and_an_incomplete_block_fills_the_range_alone():
    own_g = np.random.default_rng(1).lognormal(-1.0, 0.5, 20)
    factors = block_factors(own_g, (0.1, 1.5))
    shares = np.log(own_g * factors / 0.1) / np.log(15.0)
    for block, offset in ((slice(0, 8), 1 / 2), (slice(8, 16), 1 / 4)):
        np.testing.assert_allclose(np.sort(shares[block]), (np.arange(8) + offset) / 8)
        assert (np.argsort(shares[block]) == np.argsort(own_g[block])).all()
    np.testing.assert_allclose(np.sort(shares[16:]), (np.arange(4) + 3 / 4) / 4)
    np.testing.assert_array_equal(block_factors(own_g[:16], (0.1, 1.5)), factors[:16])


def test_offsets_of_blocks_are_the_van_der_corput_sequence():
    for block, offset in enumerate((0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875)):
        share = (np.arange(8) + offset) / 8
        np.testing.assert_array_equal(block_targets(block, 8, (0.1, 1.5)), 0.1 * 15.0**share)


def test_order_of_the_index_is_the_order_of_the_suite(tmp_path):
    pairs = make_pairs(tmp_path, 3)
    index_of(tmp_path, pairs[::-1])
    assert [entry.motion_id for entry in list_motions(tmp_path)] == ["q2", "q1", "q0"]


def test_motions_in_sub_folders_are_found(tmp_path):
    for name in ("kobe", "chichi"):
        (tmp_path / name).mkdir()
        make_pairs(tmp_path / name, 1)
    found = list_motions(tmp_path)
    assert len({entry.motion_id for entry in found}) == 2
    assert {entry.components[0][0].parent.name for entry in found} == {"kobe", "chichi"}


def test_other_files_in_the_folder_are_ignored(tmp_path):
    make_pairs(tmp_path, 2)
    (tmp_path / "notes.txt").write_text("Downloaded on Monday.\n")
    (tmp_path / "table.csv").write_text("RSN,PGA\nRSN6,0.2\n")
    (tmp_path / "_SearchResults.csv").write_text("1,2\n3,4\n")
    (tmp_path / "q0_h1.VT2").write_text("velocity\n")
    (tmp_path / "q0_UP.AT2").write_text("vertical\n")
    assert [entry.motion_id for entry in list_motions(tmp_path)] == ["q0", "q1"]


def test_messages_of_the_readers_are_logged(tmp_path, caplog):
    (first, _), *_ = make_pairs(tmp_path, 1)
    first.write_text(at2_text(shaken_g(0, 390)))
    prepare_suite(tmp_path, t1_s=0.7)
    assert "zeros added" in caplog.text
