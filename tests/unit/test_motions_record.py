"""A ground motion as the analyses see it, and the PEER files it is read from."""

from pathlib import Path

import numpy as np
import pytest

from skewbridge.errors import InputError
from skewbridge.motions.check import check_paths
from skewbridge.motions.folder import group_by_name, list_motions
from skewbridge.motions.formats import Trace
from skewbridge.motions.intensity import housner_intensity, motion_measures
from skewbridge.motions.read import doubts, read_motion, read_trace
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


@pytest.mark.parametrize(("offset", "is_doubtful"), [(0.03, True), (-0.03, True), (0.01, False)])
def test_offset_of_either_sign_gets_a_warning(offset, is_doubtful):
    wave = np.tile([1.0, -1.0], 500) + offset
    trace = Trace(path=Path("a.csv"), format="csv", accel_mps2=wave, dt_s=0.01, unit="m/s2")
    assert any("mean is" in doubt for doubt in doubts(trace)) is is_doubtful


def test_components_of_different_events_get_a_warning(tmp_path):
    kobe = AT2.replace("Some Quake", "Kobe").replace("Some Station, 90", "Takatori, 0")
    files = [_write(tmp_path / "A.AT2", VALUES_G), _write(tmp_path / "B.AT2", VALUES_G, kobe)]
    found = check_paths(files)
    assert {check.verdict for check in found} == {"warn"}
    assert all("two different records?" in " ".join(check.messages) for check in found)


def test_one_value_per_pair_is_the_mean_of_its_components():
    """1 m/s2 to and fro for 2 s: CAV 2 m/s, Arias pi/(2 g) x 2; the other component is still."""
    accel = np.array([1.0, -1.0] * 100 + [1.0])
    motion = GroundMotion(
        motion_id="m", dt_s=0.01, accel_1_mps2=accel, accel_2_mps2=np.zeros_like(accel)
    )
    found = motion_measures(motion, None)
    assert found["im_cav_mps"] == pytest.approx(1.0)
    assert found["im_arias_mps"] == pytest.approx(0.5 * np.pi / (2.0 * 9.80665) * 2.0)
    twice = motion_measures(motion.with_components(accel, 3.0 * accel), None)
    assert twice["im_cav_mps"] == pytest.approx((2.0 + 6.0) / 2.0)


def test_the_median_over_directions_of_a_straight_motion_is_that_of_the_cosine():
    """Peaks 3 m/s2 and 3 x 0.21 s = 0.63 m/s along one axis: cos 45 degrees of them."""
    accel = np.array([0.0, *[3.0] * 21, 0.0])
    motion = GroundMotion(
        motion_id="m", dt_s=0.01, accel_1_mps2=accel, accel_2_mps2=np.zeros_like(accel)
    )
    found = motion_measures(motion, None)
    assert found["im_pga_rotd50_g"] == pytest.approx(3.0 * np.sqrt(0.5) / 9.80665, rel=0.01)
    assert found["im_pgv_rotd50_mps"] == pytest.approx(0.63 * np.sqrt(0.5), rel=0.01)


def test_the_spectrum_intensity_of_a_blow_is_its_velocity_times_the_range_of_periods():
    """A blow of 0.6 m/s: an oscillator swings to v/w exp[-xi/w_d atan(w_d/xi)] at any period."""
    dt_s, xi = 0.0005, 0.05
    accel = np.zeros(6001)
    accel[1] = 0.6 / dt_s
    damped = np.sqrt(1.0 - xi**2)
    reached = 0.6 * np.exp(-xi / damped * np.arctan(damped / xi))
    assert housner_intensity(accel, dt_s) == pytest.approx(reached * (2.5 - 0.1), rel=1e-3)
