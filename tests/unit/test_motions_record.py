"""A ground motion as the analyses see it, and the PEER files it is read from."""

from pathlib import Path

import numpy as np
import pytest

from skewbridge.errors import InputError
from skewbridge.motions.check import check_paths
from skewbridge.motions.index import list_motions
from skewbridge.motions.pairing import group_by_name
from skewbridge.motions.read import read_motion, read_trace
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2

AT2 = """PEER NGA STRONG MOTION DATABASE RECORD
Some Quake, 1/17/1994, Some Station, 90
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=     12, DT=   .0100 SEC,   0 POLE @    30.00000 HZ,  -5 POLE @      .05000
"""
VALUES_G = [0.0, 0.1, -0.1, 0.2, -0.2, 0.05, -0.05, 0.01, -0.01, 0.0, 0.0, 0.0]


def _write(path: Path, values_g: list[float], header: str = AT2) -> Path:
    path.write_text(header + "\n".join(f"{value: .7E}" for value in values_g) + "\n")
    return path


def _motion(**changes: object) -> GroundMotion:
    fields = {
        "motion_id": "m",
        "dt_s": 0.01,
        "accel_1_mps2": np.array([1.0, 2.0]),
        "accel_2_mps2": np.array([-1.0, 3.0]),
    }
    return GroundMotion(**(fields | changes))


def test_at2_values_come_in_si_with_header_metadata(tmp_path):
    trace = read_trace(_write(tmp_path / "A090.AT2", VALUES_G))
    np.testing.assert_allclose(trace.accel_mps2, np.array(VALUES_G) * G_MPS2)
    assert (trace.dt_s, trace.event, trace.station) == (0.01, "Some Quake", "Some Station")
    assert trace.azimuth_deg == 90.0


def test_shorter_component_is_padded_with_zeros_and_a_message(tmp_path):
    first = _write(tmp_path / "A000.AT2", VALUES_G)
    second = _write(tmp_path / "A090.AT2", VALUES_G[:11], AT2.replace("12", "11"))
    motion = read_motion(first, second)
    assert motion.npts == 12
    assert motion.accel_2_mps2[-1] == 0.0
    assert any("zeros added" in message for message in motion.messages)


def test_components_of_different_dt_are_refused_by_name(tmp_path):
    first = _write(tmp_path / "A000.AT2", VALUES_G)
    second = _write(tmp_path / "A090.AT2", VALUES_G, AT2.replace(".0100", ".0200"))
    with pytest.raises(InputError, match=r"A000\.AT2 is 0\.01 s, of A090\.AT2 0\.02 s"):
        read_motion(first, second)


def test_incidence_90_rotates_component_1_to_y():
    ax, ay = _motion().along_axes(90.0)
    np.testing.assert_array_equal(ax, [1.0, -3.0])
    np.testing.assert_array_equal(ay, [1.0, 2.0])


def test_rotation_keeps_the_resultant():
    motion = _motion()
    ax, ay = motion.along_axes(33.0)
    np.testing.assert_allclose(
        np.hypot(ax, ay), np.hypot(motion.accel_1_mps2, motion.accel_2_mps2), rtol=1e-14
    )


@pytest.mark.parametrize(
    "changes",
    [
        {"dt_s": 0.0},
        {"accel_2_mps2": np.array([1.0])},
        {"accel_2_mps2": np.array([1.0, np.nan])},
        {"accel_2_mps2": np.array([1.0, 2.0, 3.0])},
    ],
)
def test_impossible_motion_is_refused(changes):
    with pytest.raises(InputError, match="motion m"):
        _motion(**changes)


def test_scaling_keeps_metadata_and_refuses_zero():
    motion = _motion(event="quake")
    assert motion.scaled(2.0).event == "quake"
    np.testing.assert_array_equal(motion.scaled(2.0).accel_1_mps2, [2.0, 4.0])
    with pytest.raises(InputError, match="scale"):
        motion.scaled(0.0)


@pytest.mark.parametrize(
    ("first", "second", "name"),
    [
        ("RSN6_IMPVALL.I_I-ELC180.AT2", "RSN6_IMPVALL.I_I-ELC270.AT2", "RSN6_IMPVALL.I_I-ELC"),
        ("RSN181_H-E06140.AT2", "RSN181_H-E06230.AT2", "RSN181_H-E06"),
        ("RSN1231_CHY080-E.AT2", "RSN1231_CHY080-N.AT2", "RSN1231_CHY080"),
        ("120111.txt", "120112.txt", "12011"),
        ("syn_h1.AT2", "syn_h2.AT2", "syn"),
        ("AKT0139608110312.EW", "AKT0139608110312.NS", "AKT0139608110312"),
        ("AKTH019608110312.EW2", "AKTH019608110312.NS2", "AKTH019608110312_surface"),
    ],
)
def test_components_are_paired_by_name_up_to_the_azimuth(first, second, name):
    pairs = group_by_name([Path(second), Path(first), Path("RSN181_H-E06-UP.AT2"), Path("X.UD2")])
    assert pairs == {name: [Path(first), Path(second)]}


@pytest.mark.parametrize(
    ("folders", "names"), [(("2010", "2011"), ["2010_A", "2011_A"]), (("2010/x", "2011/x"), ["A"])]
)
def test_equal_file_names_in_several_folders_lose_no_pair(folders, names):
    files = [Path(folder, name) for folder in folders for name in ("A090.AT2", "A180.AT2")]
    groups = group_by_name(files)
    assert list(groups) == names
    assert sorted(path for group in groups.values() for path in group) == files


def test_unpaired_component_is_named(tmp_path):
    (tmp_path / "A090.AT2").touch()
    with pytest.raises(InputError, match=r"A090\.AT2.*2 needed"):
        list_motions(tmp_path)


def test_components_of_different_events_get_a_warning(tmp_path):
    kobe = AT2.replace("Some Quake", "Kobe").replace("Some Station, 90", "Takatori, 0")
    files = [_write(tmp_path / "A.AT2", VALUES_G), _write(tmp_path / "B.AT2", VALUES_G, kobe)]
    found = check_paths(files)
    assert {check.verdict for check in found} == {"warn"}
    assert all("two different records?" in " ".join(check.messages) for check in found)
