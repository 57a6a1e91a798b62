"""Ground motions: formats of files, suites, factors, stripes, searches and cuts."""

import hashlib
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motions_files import (
    at2_text,
    cosmos_text,
    esm_text,
    geonet_text,
    index_of,
    make_pairs,
    rows_of,
    shaken_g,
)
from skewbridge.errors import InputError
from skewbridge.motions import intensity, levels
from skewbridge.motions.check import check_paths
from skewbridge.motions.folder import group_by_name, list_motions
from skewbridge.motions.formats import DtMissingError, Stated, Trace
from skewbridge.motions.intensity import pair_psa
from skewbridge.motions.read import doubts, read_motion, read_trace
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import prepare_suite, read_entry, read_suite, write_suite
from skewbridge.motions.synthesis import Scenario, synthesize
from skewbridge.units import G_MPS2


def _motion(**changes: object) -> GroundMotion:
    first, second = np.array([1.0, 2.0]), np.array([-1.0, 3.0])
    fields = {"motion_id": "m", "dt_s": 0.01, "accel_1_mps2": first, "accel_2_mps2": second}
    return GroundMotion(**(fields | changes))


def test_motions_are_rotated_and_scaled_and_keep_their_metadata():
    ax, ay = _motion().along_axes(90.0)
    np.testing.assert_array_equal(ax, [1.0, -3.0])
    np.testing.assert_array_equal(ay, [1.0, 2.0])
    twice = _motion(event="quake").scaled(2.0)
    assert twice.event == "quake"
    np.testing.assert_array_equal(twice.accel_1_mps2, [2.0, 4.0])
    with pytest.raises(InputError, match="scale"):
        _motion().scaled(0.0)


@pytest.mark.parametrize(
    "changes",
    [{"dt_s": 0.0}]
    + [{"accel_2_mps2": values} for values in ([1.0], [1.0, np.nan], [1.0, 2.0, 3.0])],
)
def test_impossible_motion_is_refused(changes):
    with pytest.raises(InputError, match="motion m"):
        _motion(**{name: np.array(value) for name, value in changes.items()})


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


@pytest.mark.parametrize(("offset", "is_doubtful"), [(0.03, True), (-0.03, True), (0.01, False)])
def test_offset_of_either_sign_gets_a_warning(offset, is_doubtful):
    wave = np.tile([1.0, -1.0], 500) + offset
    trace = Trace(path=Path("a.csv"), format="csv", accel_mps2=wave, dt_s=0.01, unit="m/s2")
    assert any("mean is" in doubt for doubt in doubts(trace)) is is_doubtful


def test_components_of_different_events_get_a_warning(tmp_path):
    text = at2_text(RECORD_G)
    kobe = text.replace("Quake", "Kobe").replace("Station, 90", "Takatori, 0")
    found = check_paths([_file(tmp_path, "A.AT2", text), _file(tmp_path, "B.AT2", kobe)])
    assert {check.verdict for check in found} == {"warn"}
    assert all("two different records?" in " ".join(check.messages) for check in found)


def test_measures_are_means_of_components_or_medians_over_directions():
    """1 m/s2 to and fro for 2 s: CAV 2 m/s, Arias pi/(2 g) x 2; the other component is still."""
    accel = np.array([1.0, -1.0] * 100 + [1.0])
    motion = _motion(accel_1_mps2=accel, accel_2_mps2=np.zeros_like(accel))
    found = intensity.motion_measures(motion, None)
    assert found["im_cav_mps"] == pytest.approx(1.0)
    assert found["im_arias_mps"] == pytest.approx(0.5 * np.pi / (2.0 * 9.80665) * 2.0)
    twice = intensity.motion_measures(motion.with_components(accel, 3.0 * accel), None)
    assert twice["im_cav_mps"] == pytest.approx((2.0 + 6.0) / 2.0)
    # Peaks 3 m/s2 and 3 x 0.21 s = 0.63 m/s along one axis: cos 45 degrees of them.
    accel = np.array([0.0, *[3.0] * 21, 0.0])
    found = intensity.motion_measures(_motion(accel_1_mps2=accel, accel_2_mps2=0.0 * accel), None)
    assert found["im_pga_rotd50_g"] == pytest.approx(3.0 * np.sqrt(0.5) / 9.80665, rel=0.01)
    assert found["im_pgv_rotd50_mps"] == pytest.approx(0.63 * np.sqrt(0.5), rel=0.01)


def test_the_spectrum_intensity_of_a_blow_is_its_velocity_times_the_range_of_periods():
    """A blow of 0.6 m/s: an oscillator swings to v/w exp[-xi/w_d atan(w_d/xi)] at any period."""
    dt_s, xi = 0.0005, 0.05
    accel = np.zeros(6001)
    accel[1] = 0.6 / dt_s
    damped = np.sqrt(1.0 - xi**2)
    reached = 0.6 * np.exp(-xi / damped * np.arctan(damped / xi))
    assert intensity.housner_intensity(accel, dt_s) == pytest.approx(
        reached * (2.5 - 0.1), rel=1e-3
    )


# --- formats of files


RECORD_G = shaken_g(1, 50)
SI = RECORD_G * G_MPS2


def _file(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def _at2(head: str, values: str) -> str:
    return "PEER STRONG MOTION DATABASE RECORD\nA, 1/1/2000, B, 90\n" + head + values + "\n"


IN_G = "ACCELERATION TIME SERIES IN UNITS OF G\n"
PLAIN = f"{IN_G}NPTS= 50, DT= .01 SEC\n"
FIVE = rows_of(RECORD_G, 5, "{:15.7E}")


def _peer(folder: Path, npts: int = 50, values: str = FIVE) -> Path:
    return _file(folder, "a.AT2", _at2(PLAIN.replace("50", str(npts)), values))


@pytest.mark.parametrize(
    ("head", "values"),
    [
        (f"{IN_G}NPTS=     50, DT=   .0100 SEC,\n", FIVE),
        (f"{IN_G}NPTS= 50, DT= .01000SEC,   4 POLE @  50.0 HZ\n", FIVE),
        (f"{IN_G}NPTS=   50, dt=  .01000\n", FIVE),
        (
            "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=15 Hz\n"
            "NPTS=  50, DT= .01000 SEC\n",
            FIVE,
        ),
        ("The units are (g)\n50 0.0100 NPTS, DT\n", FIVE),
        pytest.param(PLAIN, FIVE.replace("E", "D"), id="D exponent"),
        pytest.param(PLAIN, rows_of(RECORD_G, 1, "{:15.7E}"), id="one per line"),
        pytest.param(PLAIN, rows_of(RECORD_G, 8, "{:.7E},"), id="commas"),
        pytest.param(PLAIN, rows_of(RECORD_G, 5, "{:+.7E}"), id="run together"),
        pytest.param(PLAIN, f"{FIVE}\n*** End data ***", id="footer"),
    ],
)
def test_headers_and_layouts_of_peer_files_read_alike(tmp_path, head, values):
    trace = read_trace(_file(tmp_path, "a.AT2", _at2(head, values)))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-7)
    found = (trace.dt_s, trace.event, trace.station, trace.azimuth_deg)
    assert found == (0.01, "A", "B", 90.0)


def test_surplus_values_are_cut_and_other_counts_or_missing_headers_refused(tmp_path):
    trace = read_trace(_peer(tmp_path, 47))
    assert trace.accel_mps2.size == 47
    assert any("cut to NPTS" in text for text in trace.warnings)
    with pytest.raises(InputError, match="NPTS = 20, but the file has 50"):
        read_trace(_peer(tmp_path, 20))
    cut = _peer(tmp_path, 60, rows_of(RECORD_G[:-1], 5, "{:15.7E}") + "  -.3141")
    with pytest.raises(InputError, match="inside a number"):
        read_trace(cut)
    with pytest.raises(InputError, match=r"rename bare values to \.acc and give"):
        read_trace(_file(tmp_path, "a.AT2", FIVE))


def test_given_values_override_the_file_with_a_note_and_those_if_missing_do_not(tmp_path):
    trace = read_trace(_peer(tmp_path), Stated(unit="m/s2"))
    np.testing.assert_allclose(trace.accel_mps2, RECORD_G, rtol=1e-6)
    assert any("not g" in text for text in trace.notes)
    rows = "\n".join(f"{i * 0.003:.3f} {v:.8e}" for i, v in enumerate(RECORD_G))
    trace = read_trace(_file(tmp_path, "a.txt", rows), Stated(dt_s=0.0025))
    assert trace.dt_s == 0.0025
    assert any("0.003" in text for text in trace.warnings)
    known = Stated(dt_s_if_missing=0.005, unit_if_missing="gal")
    trace = read_trace(_peer(tmp_path), known)
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)
    assert (trace.dt_s, trace.unit, trace.notes) == (0.01, "g", ("unit g of the header is used",))
    bare = read_trace(_file(tmp_path, "a.acc", rows_of(980.665 * RECORD_G, 5, "{:.8e} ")), known)
    np.testing.assert_allclose(bare.accel_mps2, SI, rtol=1e-7)
    assert (bare.dt_s, bare.unit) == (0.005, "cm/s2")


V2_LINE = "   50 POINTS OF ACCEL DATA EQUALLY SPACED AT  .010 SEC.  (UNITS: CM/SEC/SEC)"
V2_HEAD = ["CORRECTED ACCELEROGRAM   TEST", "UNCORRECTED DATA", "TEST QUAKE", *["x"] * 3,
           "TEST STATION", "CHAN  1: 270", *["x"] * 17, *["    0    1"] * 20]  # fmt: skip


def _v2(line: str, values: str) -> str:
    return "\n".join([*V2_HEAD, line, values, "    1 POINTS OF VELOC DATA", "     1.000"])


@pytest.mark.parametrize(
    ("line", "per_line", "form"),
    [
        (V2_LINE, 8, "{:10.3f}"),
        ("   50 points of accel data equally spaced at  .010 sec, in cm/sec2. (8f10.6)", 8,
         "{:10.6f}"),
    ],
)  # fmt: skip
def test_csmip_v2_is_read_by_column_width(tmp_path, line, per_line, form):
    cm_s2 = RECORD_G * 98.0665
    cm_s2[3] = -1234.123 if form == "{:10.3f}" else -12.632701  # fills its ten columns
    text = _v2(line, rows_of(cm_s2, per_line, form))
    trace = read_trace(_file(tmp_path, "a.V2", text))
    np.testing.assert_allclose(trace.accel_mps2, cm_s2 * 0.01, atol=6e-6)
    assert (trace.format, trace.station, trace.azimuth_deg) == ("csmip_v2", "TEST STATION", 270.0)


def test_a_file_of_several_channels_needs_a_channel(tmp_path):
    cm_s2 = RECORD_G * 980.665
    csmip = "\n".join(_v2(V2_LINE, rows_of(each, 8, "{:10.3f}")) for each in (cm_s2, -2 * cm_s2))
    rows = [f"{i * 0.01:.2f},{v:.8e},{-2 * v:.8e}" for i, v in enumerate(RECORD_G)]
    for name, text in (("a.V2", csmip), ("a.csv", "time_s,h1_g,h2_g\n" + "\n".join(rows))):
        path = _file(tmp_path, name, text)
        with pytest.raises(InputError, match="2 channels"):
            read_trace(path)
        second = read_trace(path, Stated(channel=2)).accel_mps2
        np.testing.assert_allclose(second, -2 * SI, atol=6e-6)
        with pytest.raises(InputError, match="no channel 3; the file has 2"):
            read_trace(path, Stated(channel=3))


def test_index_names_the_channels_of_one_file(tmp_path):
    parts = [_v2(V2_LINE, rows_of(RECORD_G * f, 8, "{:10.3f}")) for f in (980.665, 200.0, -500.0)]
    (tmp_path / "all.V2").write_text("\n".join(parts))
    (tmp_path / "index.csv").write_text(
        "motion_id,file_1,file_2,channel_1,channel_2\nbridge,all.V2,all.V2,1,3\n"
    )
    motion = read_entry(list_motions(tmp_path)[0])
    np.testing.assert_allclose(motion.accel_1_mps2, SI, atol=6e-6)
    np.testing.assert_allclose(motion.accel_2_mps2, -5.0 * RECORD_G, atol=6e-6)


@pytest.mark.parametrize(
    ("given", "unit"), [("GAL", "cm/s2"), ("cm/s^2", "cm/s2"), ("G", "g"), ("m/s/s", "m/s2")]
)
def test_common_spellings_of_units_are_accepted(given, unit):
    assert Stated(unit=given).unit == unit


@pytest.mark.parametrize(
    ("header", "unit"),
    [("time,accel_g", "g"), ("t (s), a (cm/s2)", "cm/s2"), ("time_s;accel_mps2", "m/s2"),
     ("time_s,acc_cm_s2", "cm/s2"), ("time_s,acc_m_s2", "m/s2"), ("m_south,a_g", "g"),
     ("# time acceleration", "g"), (None, "g")],
)  # fmt: skip
def test_two_columns_take_their_unit_from_the_header(tmp_path, header, unit):
    factor = {"g": 1.0, "cm/s2": 980.665, "m/s2": 9.80665}[unit]
    rows = "\n".join(f"{i * 0.01:.2f}, {v * factor:.8e}" for i, v in enumerate(RECORD_G))
    trace = read_trace(_file(tmp_path, "a.csv", rows if header is None else f"{header}\n{rows}"))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-7)
    assert (trace.format, trace.unit, trace.dt_s) == ("two_column", unit, 0.01)


@pytest.mark.parametrize("replacement", [[], ["0.21 1.0", "0.20 1.0"], ["0.20"]])
def test_broken_time_column_is_refused_with_its_line(tmp_path, replacement):
    """A hole, a step back, a missing value."""
    rows = [f"{i * 0.01:.2f} {v:.8e}" for i, v in enumerate(RECORD_G)]
    commas = "\n".join(row.replace(" ", ";").replace(".", ",") for row in rows)
    with pytest.raises(InputError, match="decimal comma"):
        read_trace(_file(tmp_path, "a.csv", commas))
    rows[20:22] = replacement
    with pytest.raises(InputError, match=r"line 2[012]"):
        read_trace(_file(tmp_path, "a.txt", "\n".join(rows)))


@pytest.mark.parametrize("per_line", [1, 5, 50])
def test_bare_values_need_a_time_step_and_are_not_read_as_a_table(tmp_path, per_line):
    path = _file(tmp_path, "a.acc", rows_of(RECORD_G, per_line, "{:.8e} "))
    with pytest.raises(DtMissingError):
        read_trace(path)
    trace = read_trace(path, Stated(dt_s=0.005))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-7)
    assert any("no unit" in text for text in trace.notes)
    rising = np.arange(60) ** 1.5 * 1e-4  # a slow start: the first number of each line rises
    path = _file(tmp_path, "a.acc", rows_of(rising, per_line, "{:15.7e}"))
    accel_mps2 = read_trace(path, Stated(dt_s=0.01)).accel_mps2
    np.testing.assert_allclose(accel_mps2, rising * G_MPS2, rtol=1e-6)


def test_knet_counts_become_gal_about_their_mean(tmp_path):
    counts = np.round(RECORD_G * 980.665 * 8388608 / 2000).astype(int) + 1234
    counts += round(1234 - counts.mean())
    head = "\n".join(
        ["Origin Time       2000/01/01 00:00:00", "Station Code      ABC001"]
        + ["Lat.   1"] * 8
        + ["Sampling Freq(Hz) 100Hz", "Duration Time(s)  1", "Dir.              4",
           "Scale Factor      2000(gal)/8388608"]
        + [f"Max. Acc. (gal)   {np.abs(RECORD_G - RECORD_G.mean()).max() * 980.665:.3f}"]
        + ["Last Correction   2000/01/01 00:00:00", "Memo.             "]
    )  # fmt: skip
    trace = read_trace(_file(tmp_path, "a.NS2", head + "\n" + rows_of(counts, 8, "{:9d}")))
    np.testing.assert_allclose(trace.accel_mps2, SI - SI.mean(), atol=3e-6)
    assert (trace.format, trace.azimuth_deg, trace.warnings) == ("knet", 0.0, ())


def test_components_with_unrelated_names_are_paired_by_header(tmp_path):
    """One station by its channels, as CSMIP names them: 360 and 270 degrees, and up."""
    for channel, direction in ((14, "UP"), (15, "360"), (24, "270")):
        text = _v2(V2_LINE, rows_of(RECORD_G * 980.665, 8, "{:10.3f}"))
        text = text.replace("CHAN  1: 270", f"CHAN {channel}: {direction}")
        _file(tmp_path, f"CHAN{channel}.V2", text)
    (entry,) = list_motions(tmp_path)
    assert [path.name for path, _ in entry.components] == ["CHAN15.V2", "CHAN24.V2"]
    assert "TEST_STATION" in entry.motion_id


GAL_VALUES = shaken_g(7, 400) * 980.665


def test_esm_file_has_unit_step_event_and_azimuth_in_its_header(tmp_path):
    trace = read_trace(_file(tmp_path, "a.ASC", esm_text(GAL_VALUES)))
    np.testing.assert_allclose(trace.accel_mps2, GAL_VALUES * 0.01, atol=6e-9)
    assert (trace.format, trace.dt_s, trace.unit, trace.azimuth_deg) == ("esm", 0.005, "cm/s2", 90)
    assert (trace.event, trace.station, trace.notes) == ("EMSC-1", "XX.ABC", ())
    short = read_trace(_file(tmp_path, "a.ASC", esm_text(GAL_VALUES, NDATA="420")))
    assert any("NDATA = 420, but the file has 400" in text for text in short.warnings)
    for changes, message in (
        ({"NDATA": "399"}, "NDATA = 399, but the file has 400"),
        ({"DATA_TYPE": "VELOCITY", "UNITS": "cm/s"}, "not an acceleration: DATA_TYPE"),
        ({"DATA_TYPE": "ACCELERATION RESPONSE SPECTRUM"}, "not an acceleration"),
        ({"UNITS": "cm/s"}, "not an acceleration: 'cm/s'"),
        ({"SAMPLING_INTERVAL_S": ""}, "SAMPLING_INTERVAL_S"),
    ):
        with pytest.raises(InputError, match=message):
            read_trace(_file(tmp_path, "a.ASC", esm_text(GAL_VALUES, **changes)))


@pytest.mark.parametrize(
    ("layout", "unit", "factor"),
    [
        (("(1E15.6)", 1, "{:15.6e}"), None, 1.0),
        (("(8F10.5)", 8, "{:10.5f}"), (-999, -999, "cm/s^2 (4)"), 1.0),
        # numbers that touch
        (("(10F8.3)", 10, "{:8.3f}"), (1, 10, "gal(10)"), 2.0),
        (("(6F13.9)", 6, "{:13.9f}"), (1, 2, "g(02)"), 1.0 / 980.665),
        (("(8F10.4)", 8, "{:10.4f}"), (1, 11, "mg(11)"), 1.0 / 0.980665),
    ],
)
def test_cosmos_file_states_unit_step_and_layout(tmp_path, layout, unit, factor):
    given = GAL_VALUES * factor
    if layout[0] == "(10F8.3)":
        given[10:12] = -510.123, -610.25
    text = cosmos_text(given, layout=layout, unit=unit)
    trace = read_trace(_file(tmp_path, "a.acc.V2c", text), Stated(unit_if_missing="m/s2"))
    decimals = {"(8F10.5)": 5, "(10F8.3)": 3, "(6F13.9)": 9, "(8F10.4)": 4}.get(layout[0], 7)
    scale = {2: 9.80665, 11: 9.80665e-3}.get(unit[1] if unit else 4, 0.01)
    np.testing.assert_allclose(
        trace.accel_mps2, given * scale, rtol=1e-6, atol=scale * 10**-decimals
    )
    assert (trace.format, trace.dt_s, trace.azimuth_deg) == ("cosmos", 0.005, 90.0)
    assert (trace.event, trace.station) == ("Record of Test Quake", "Statn No: 37-11 Code:XX-ABC")


def test_only_the_accelerations_of_a_cosmos_file_are_channels(tmp_path):
    quantities = ("acceleration", "velocity", "displacement")
    text = "".join(
        cosmos_text(factor * GAL_VALUES, azimuth=azimuth, quantity=quantity)
        for factor, azimuth in ((1.0, 0), (-2.0, 270))  # 0 is unknown
        for quantity in quantities
    )
    path = _file(tmp_path, "a.V2C", text)
    with pytest.raises(InputError, match=r"2 channels \(1 HNE, 2 270\)"):
        read_trace(path)
    second = read_trace(path, Stated(channel=2))
    np.testing.assert_allclose(second.accel_mps2, -0.02 * GAL_VALUES, rtol=1e-6, atol=1e-9)
    assert second.azimuth_deg == 270.0
    for text, message in (
        (cosmos_text(GAL_VALUES, quantity="velocity"), "not an acceleration"),
        (cosmos_text(GAL_VALUES, unit=(1, 50, "counts (50)")), "'counts.*is not read"),
        (cosmos_text(GAL_VALUES, 0.005).replace("5.000000", "0.005000"), "do not last 2 s"),
    ):
        with pytest.raises(InputError, match=message):
            read_trace(_file(tmp_path, "a.V2c", text))
    cut = cosmos_text(GAL_VALUES).split("\n")[:-40]
    assert "truncated" in read_trace(_file(tmp_path, "a.V2c", "\n".join(cut))).warnings[0]


@pytest.mark.parametrize("name", ["a.V2A", "a.txt"])
def test_geonet_components_are_accelerations_in_mm_s2(tmp_path, name):
    mm_s2 = shaken_g(7, 403) * 9806.65
    mm_s2[20:22] = -12345.6, -13456.7  # fill their columns
    components = {"N28W": mm_s2, "S62W": -0.5 * mm_s2, "Up": 0.1 * mm_s2}
    text = geonet_text(components)
    path = _file(tmp_path, name, text)
    with pytest.raises(InputError, match=r"3 channels \(1 N28W, 2 S62W, 3 Up\)"):
        read_trace(path)
    for channel, azimuth in ((1, 332.0), (2, 242.0)):
        trace = read_trace(path, Stated(channel=channel))
        expected = 1e-3 * [*components.values()][channel - 1]
        np.testing.assert_allclose(trace.accel_mps2, expected, atol=6e-5)
        assert (trace.format, trace.dt_s, trace.azimuth_deg) == ("geonet_v2a", 0.02, azimuth)
        assert (trace.event, trace.station) == ("2016 November 13         11:02:56 UT", "ABC")
    lines = text.split("\n")
    path = _file(tmp_path, name, "\n".join(lines[:150]))  # in the second component
    assert "truncated" in read_trace(path, Stated(channel=2)).warnings[0]
    with pytest.raises(InputError, match="truncated"):
        read_trace(_file(tmp_path, name, "\n".join(lines[:125])), Stated(channel=1))
    with pytest.raises(InputError, match="uncorrected"):
        read_trace(_file(tmp_path, name, "Un" + text[0].lower() + text[1:]))


def test_esm_and_cosmos_components_are_paired_by_their_headers(tmp_path):
    for letter, azimuth in (("E", 90), ("N", 360), ("Z", 400)):
        text = esm_text(GAL_VALUES, stream=f"HN{letter}")
        _file(tmp_path, f"HI.ABC..HN{letter}.D.20190728.160908.C.ACC.ASC", text)
        cosmos = cosmos_text(GAL_VALUES, azimuth=azimuth, scnl=f"ABC.HN{letter}.XX.--")
        _file(tmp_path, f"ABC.1000hyfh.HN{letter}.--.acc.V2c", cosmos)
    found = [[path.name for path, _ in entry.components] for entry in list_motions(tmp_path)]
    assert sorted(".".join(name.split(".")[-1:]) for pair in found for name in pair) == [
        "ASC", "ASC", "V2c", "V2c",
    ]  # fmt: skip
    assert not any("HNZ" in name for pair in found for name in pair)
    assert {check.verdict for check in check_paths([tmp_path])} <= {"ok", "warn"}


VERTICAL_FILES = {
    "a.V2": lambda up: _v2(V2_LINE, rows_of(RECORD_G * 980.665, 8, "{:10.3f}")).replace(
        "CHAN  1: 270", f"CHAN  1: {up}"
    ),
    "a.AT2": lambda up: at2_text(RECORD_G).replace("Station, 90", f"Station, {up}"),
    "old.AT2": lambda up: _at2(PLAIN, FIVE).replace(
        "A, 1/1/2000, B, 90", f"A 5/19/40 0439, B, {up} (X)"
    ),
    "a.csv": lambda up: f"time (s),{up} (g)\n" + _time_rows(RECORD_G),
    "b.csv": lambda up: f"time,acc_{up}\n" + _time_rows(RECORD_G),
    "a.acc": lambda up: f"{up}\n" + rows_of(RECORD_G, 1, "{:.6e}"),
    "a.V2A": lambda up: geonet_text({up: 9806.65 * RECORD_G}),
    "a.ASC": lambda up: esm_text(GAL_VALUES, 0.01, stream=up),
    "a.V2c": lambda up: cosmos_text(GAL_VALUES, 0.01, azimuth=0, scnl=f"A.{up}.XX.--"),
}


def _time_rows(values):
    return "\n".join(f"{i * 0.01:.2f},{value:.8e}" for i, value in enumerate(values))


@pytest.mark.parametrize("name", VERTICAL_FILES)
@pytest.mark.parametrize("direction", ["UP", "Up", "-UP", "Z", "V", "VERT", "HNZ", "DWN", "U-D"])
def test_a_channel_whose_header_says_vertical_is_no_component(tmp_path, name, direction):
    if name in {"old.AT2", "a.V2", "a.V2c"} and not direction.isalpha():
        direction = "Vert"
    if name == "old.AT2" and direction in {"Z", "V", "HNZ"}:
        direction = "UD"
    _file(tmp_path, name, VERTICAL_FILES[name](direction))
    _file(tmp_path, "other.AT2", at2_text(RECORD_G))
    for first, second in ((name, "other.AT2"), ("other.AT2", name)):
        (tmp_path / "index.csv").write_text(
            f"motion_id,file_1,file_2,dt_s\nm,{first},{second},0.01\n"
        )
        (entry,) = list_motions(tmp_path)
        with pytest.raises(InputError, match=rf"{name}: the header states a vertical.*{direction}"):
            read_entry(entry)
        assert {check.verdict for check in check_paths([tmp_path])} == {"error"}


@pytest.mark.parametrize("azimuth", [400, 401, 402])
def test_vertical_orientation_codes_of_cosmos_are_no_component(tmp_path, azimuth):
    path = _file(tmp_path, "a.V2c", cosmos_text(GAL_VALUES, 0.01, azimuth, "A.B.C.D"))
    other = _file(tmp_path, "b.V2c", cosmos_text(GAL_VALUES, 0.01, 90))
    assert math.isnan(read_trace(path).azimuth_deg)
    with pytest.raises(InputError, match=r"a\.V2c: the header states a vertical"):
        read_motion(other, path)


# --- numbers without a known format


SMOOTH = np.array(
    [np.sin(np.arange(400) / 9.0), np.sin(np.arange(400) / 7.0), np.cos(np.arange(400) / 5.0)]
).T * np.hanning(400)[:, None]  # fmt: skip


def _table(values, *, header="", separator=" "):
    rows = [separator.join(f"{value:.6f}" for value in row) for row in values]
    return header + "\n".join(rows) + "\n"


@pytest.mark.parametrize("columns", [2, 3, 6])
@pytest.mark.parametrize("header", ["", "title\n", "NS EW UD\n", "400 0.01\n"])
@pytest.mark.parametrize("separator", [" ", ","])
def test_columns_without_time_are_channels_and_never_one_series(
    tmp_path, columns, header, separator
):
    values = np.hstack([SMOOTH, -2.0 * SMOOTH])[:, :columns] * 0.1
    path = _file(tmp_path, "a.txt", _table(values, header=header, separator=separator))
    with pytest.raises(InputError, match=f"{columns} (numbers per line|channels)"):
        read_trace(path, Stated(dt_s=0.01))
    for channel in range(1, columns + 1):
        trace = read_trace(path, Stated(dt_s=0.01, channel=channel))
        np.testing.assert_allclose(trace.accel_mps2, values[:, channel - 1] * G_MPS2, atol=1e-5)
    with pytest.raises(InputError, match=f"no channel {columns + 1}"):
        read_trace(path, Stated(dt_s=0.01, channel=columns + 1))
    cut = path.read_text().rstrip("\n").rpartition(separator)[0]
    with pytest.raises(InputError, match=f"(row must have {columns} columns|header states 400)"):
        read_trace(_file(tmp_path, "b.txt", cut), Stated(dt_s=0.01, channel=1))


def test_a_rising_first_component_is_no_time_column(tmp_path):
    """The first eight values of a record can rise as evenly as a time."""
    rising = np.sin(np.arange(400) / 60.0)[:, None] * [1.0, 0.5]
    for count, channel in ((2, 1), (2, 2), (3, 2)):
        values = np.hstack([rising, SMOOTH])[:, :count] * 0.1
        path = _file(tmp_path, "a.txt", _table(values))
        trace = read_trace(path, Stated(dt_s=0.005, channel=channel))
        np.testing.assert_allclose(trace.accel_mps2, values[:, channel - 1] * G_MPS2, atol=1e-5)


def test_an_uneven_time_column_is_no_channel(tmp_path):
    times = np.cumsum(np.random.default_rng(1).uniform(0.001, 0.03, 400))
    path = _file(tmp_path, "a.txt", _table(np.column_stack([times, SMOOTH])))
    with pytest.raises(InputError, match="time column"):
        read_trace(path, Stated(dt_s=0.01, channel=2))
    rows = zip(np.arange(400) * 0.0025, _table(SMOOTH).splitlines(), strict=True)  # rounded
    path = _file(tmp_path, "a.txt", "\n".join(f"{time:.3f} {row}" for time, row in rows))
    trace = read_trace(path, Stated(channel=2))
    np.testing.assert_allclose(trace.accel_mps2, SMOOTH[:, 1] * G_MPS2, atol=1e-5)
    assert trace.dt_s == 0.0025


@pytest.mark.parametrize("per_line", [1, 2, 3, 4, 5, 7, 8, 10])
@pytest.mark.parametrize("seed", range(3))
def test_one_series_of_several_values_per_line_is_no_table(tmp_path, per_line, seed):
    """Lines of 2 or 3 numbers need a count, or a shorter last line, to be one series."""
    series = np.convolve(shaken_g(seed, 401), np.hanning(9), mode="same")
    for header in ("", "401 0.01\n"):
        path = _file(tmp_path, "a.txt", header + rows_of(series, per_line, "{:15.7e}"))
        if not header and per_line in {2, 3} and len(series) % per_line == 0:
            with pytest.raises(InputError, match="numbers per line"):
                read_trace(path, Stated(dt_s=0.01))
            continue
        trace = read_trace(path, Stated(dt_s=0.01))
        np.testing.assert_allclose(trace.accel_mps2, series * G_MPS2, atol=1e-6)
    if per_line > 3:
        with pytest.raises(InputError, match=r"have no channels|must have"):
            read_trace(_file(tmp_path, "b.txt", rows_of(series[:400], per_line, "{:15.7e}")),
                       Stated(dt_s=0.01, channel=1))  # fmt: skip


@pytest.mark.parametrize("title", ["", "A title, 1940\n", "A title\nNPTS DT\n"])
@pytest.mark.parametrize(
    "count", ["50 0.01", "  50   .0100  ", "50, 0.01", "0.01 50", "50 1.0E-02 record of B",
              "NPTS 50 DT 0.01", "NPTS: 50; DT: 0.01", "npts=50 dt=0.01"],
)  # fmt: skip
@pytest.mark.parametrize("layout", ["one", "five", "time"])
def test_a_line_with_count_and_step_is_a_header(tmp_path, title, count, layout):
    times = [f"{0.01 * i:.2f} {value:.7e}" for i, value in enumerate(RECORD_G)]
    body = {
        "one": rows_of(RECORD_G, 1, "{:15.7e}"),
        "five": rows_of(RECORD_G, 5, "{:15.7e}"),
        "time": "\n".join(times),
    }[layout]
    is_peer = "=" in count or ":" in count
    if is_peer and layout == "time":
        return  # such a header is PEER's, which has no time column
    trace = read_trace(_file(tmp_path, "a.txt", f"{title}{count}\n{body}\n"))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)
    assert (trace.dt_s, trace.accel_mps2.size) == (0.01, 50)
    if not is_peer:
        wrong = f"{title}{count}\n{body}\n".replace("50", "61", 1)
        with pytest.raises(InputError, match="states 61 values, the file has 50"):
            read_trace(_file(tmp_path, "a.txt", wrong))


def test_values_that_look_like_a_count_are_values(tmp_path):
    """Counts of an instrument, and a time column that begins at its step."""
    counts = np.round(RECORD_G * 1000).astype(int) + 50
    rows = [f"{0.01 * i:.2f} {value}" for i, value in enumerate(counts, 1)]
    trace = read_trace(_file(tmp_path, "a.txt", "\n".join(rows)), Stated(unit="mg"))
    np.testing.assert_allclose(trace.accel_mps2, counts * G_MPS2 / 1000)
    assert trace.dt_s == 0.01
    path = _file(tmp_path, "a.txt", "50\n" + rows_of(RECORD_G, 1, "{:.6e}"))
    with pytest.raises(InputError, match="first number is the count"):
        read_trace(path, Stated(dt_s=0.01, unit="cm/s2"))


ACCELERATION_HEADERS = [
    "time (s),acc (cm/s2)", "t,a (cm/s^2)", "t,a (cm/s/s)", "t,a (cm/sec/sec)", "t,a (gal)",
    "t,a [cm/sec^2]", "t,a (CM/SEC**2)", "t,a_cmps2", "t,acc_cm_s2", "Vs30 = 760 m/s\nt,a_gal",
    "velocity model of X\nt,accel (cm/s2)", "t,a (cm/s²)", "t,a (cm s-2)", "t,a cm·s⁻²",
    "PGV 12 cm/s, PGD 3 cm\nt,a (cm/sec2)", "# units: cm/s2\ntime acc", "t;Gals",
]  # fmt: skip
OTHER_HEADERS = [
    "Time (s),Velocity (cm/s)", "Time (s),Displacement (cm)", "t (s),v (m/s)", "t,u (mm)",
    "t,u [m]", "t,u (in)", "t,v (in/s)", "t,v (ft/sec)", "time,velocity", "time,disp",
    "time_s,vel_mps", "time_s,v_cm_s", "time_s,d_m", "time_s,d_mm", "time_s,d_cm", "t,Displ.",
    "t,v (cm/sec)", "# units: cm/s\ntime h1", "VELOCITY IN CM/SEC\ntime h1", "units: m\nt,h1",
    "t,veloc [mm/s]", "t,cm", "t,h1 (inches)", "time,v (kine)",
]  # fmt: skip


@pytest.mark.parametrize("header", ACCELERATION_HEADERS)
def test_accelerations_in_cm_s2_are_recognised_by_their_header(tmp_path, header):
    text = f"{header}\n{_time_rows(980.665 * RECORD_G)}"
    trace = read_trace(_file(tmp_path, "a.csv", text))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".acc", ".bbp"])
@pytest.mark.parametrize("header", OTHER_HEADERS)
def test_velocities_and_displacements_are_refused_by_their_header(tmp_path, header, suffix):
    body = rows_of(RECORD_G, 1, "{:.6e}") if suffix == ".acc" else _time_rows(RECORD_G)
    path = _file(tmp_path, f"a{suffix}", f"{header}\n{body}")
    for unit in (None, "cm/s2"):
        with pytest.raises(InputError, match="not an acceleration"):
            read_trace(path, Stated(dt_s=0.01, unit=unit))


def test_each_column_has_its_own_quantity_and_direction(tmp_path):
    times = 0.01 * np.arange(400)
    table = np.column_stack([times, 98.0 * SMOOTH])
    head = "# Sim stat=ABC\n#    time(sec)      N-S({0})      E-W({0})      U-D({0})\n"
    path = _file(tmp_path, "a.bbp", _table(table, header=head.format("cm/s/s")))
    first, second, up = (read_trace(path, Stated(channel=n)) for n in (1, 2, 3))
    assert (first.azimuth_deg, second.azimuth_deg, up.is_vertical) == (0.0, 90.0, True)
    np.testing.assert_allclose(second.accel_mps2, 0.98 * SMOOTH[:, 1], atol=1e-7)
    for unit in ("cm/s", "cm", "m/s", "m"):
        path = _file(tmp_path, "a.vel.bbp", _table(table, header=head.format(unit)))
        with pytest.raises(InputError, match="not an acceleration"):
            read_trace(path, Stated(channel=1))
    header = "Time (s),Accel (cm/s2),Velocity (cm/s),Displ (cm)\n"
    path = _file(tmp_path, "a.csv", _table(table, header=header, separator=","))
    assert read_trace(path, Stated(channel=1)).unit == "cm/s2"
    for channel in (2, 3):
        with pytest.raises(InputError, match="not an acceleration"):
            read_trace(path, Stated(channel=channel))


@pytest.mark.parametrize("units", ["CM/S", "CM", "M/S", "CM/SEC", "INCHES"])
def test_a_peer_file_in_a_unit_of_another_quantity_is_refused(tmp_path, units):
    text = _at2(PLAIN.replace("ACCELERATION TIME SERIES IN UNITS OF G", f"(UNITS: {units})"), FIVE)
    with pytest.raises(InputError, match="not an acceleration"):
        read_trace(_file(tmp_path, "a.AT2", text.replace("INCHES)", "INCHES) DISPLACEMENT")))


@pytest.mark.parametrize(
    ("unit", "in_si"), [("mm/s2", 1e-3), ("in/s2", 0.0254), ("ft/sec2", 0.3048), ("mg", 9.80665e-3)]
)
def test_other_units_of_acceleration_are_converted(tmp_path, unit, in_si):
    text = f"time (s),a ({unit})\n{_time_rows(SI / in_si)}"
    np.testing.assert_allclose(read_trace(_file(tmp_path, "a.csv", text)).accel_mps2, SI, rtol=1e-6)
    assert Stated(unit=unit).unit == unit.replace("sec", "s")


def test_an_unknown_format_is_refused_with_the_list_of_formats(tmp_path):
    for text in ("no numbers\n" * 30, "line\n" * 11 + _time_rows(RECORD_G)):
        with pytest.raises(InputError, match=r"unknown format.*at most 10 header lines") as caught:
            read_trace(_file(tmp_path, "a.txt", text))
        for name in ("PEER", "CSMIP", "COSMOS", "GeoNet", "ESM", "K-NET", "columns"):
            assert name in str(caught.value)
    trace = read_trace(_file(tmp_path, "a.txt", "line\n" * 10 + _time_rows(RECORD_G)))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)


# --- suites of motions: files of a folder, factors, stripes, searches, cuts


def test_parquet_preserves_the_suite_of_a_folder_bit_for_bit(tmp_path):
    (first, second), *_ = make_pairs(tmp_path, 2)
    suite = prepare_suite(tmp_path, t1_s=0.7)
    assert list(suite["motion_id"]) == ["q0", "q1"]
    assert np.isfinite(suite[list(intensity.IM_COLUMNS)]).all(axis=None)
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


def test_a_suite_is_limited_to_a_count_that_changes_no_factor_and_cut(tmp_path):
    make_pairs(tmp_path, 9)
    all_motions = prepare_suite(tmp_path, t1_s=0.7)
    three = prepare_suite(tmp_path, count=3, t1_s=0.7)
    assert list(three["scale"]) == list(all_motions["scale"][:3])
    with pytest.raises(InputError, match=r"count = 10, but .* has 9"):
        prepare_suite(tmp_path, count=10, t1_s=0.7)
    cut = prepare_suite(tmp_path, count=3, t1_s=0.7, shaking_s=3.0)
    assert cut["npts"][0] == 300 < three["npts"][0]
    assert cut["sha256"][0] != three["sha256"][0]


def test_factor_of_the_index_overrides_the_computed_one(tmp_path):
    index_of(tmp_path, make_pairs(tmp_path, 2), scale=[1.25, ""])
    scales = prepare_suite(tmp_path, t1_s=0.7, bands_g=((0.3, 0.3001),))
    assert scales["scale"][0] == 1.25
    assert (scales["scale"] * scales["im_saavg_rotd50_g"])[1] == pytest.approx(0.3, rel=1e-3)


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
    factors = levels.block_factors(own_g, ((0.1, 1.5),))
    shares = np.log(own_g * factors / 0.1) / np.log(15.0)
    for block, offset in ((slice(0, 8), 1 / 2), (slice(8, 16), 1 / 4)):
        np.testing.assert_allclose(np.sort(shares[block]), (np.arange(8) + offset) / 8)
        assert (np.argsort(shares[block]) == np.argsort(own_g[block])).all()
    np.testing.assert_allclose(np.sort(shares[16:]), (np.arange(4) + 3 / 4) / 4)
    np.testing.assert_array_equal(levels.block_factors(own_g[:16], ((0.1, 1.5),)), factors[:16])
    # the sequence of van der Corput
    blocks_g = levels.block_factors([1.0] * 56, ((0.1, 1.5),)).reshape(7, 8)
    offsets = np.array([[0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]]).T
    expected_g = 0.1 * 15.0 ** ((np.arange(8) + offsets) / 8)
    np.testing.assert_allclose(blocks_g, expected_g, rtol=1e-14)  # by way of logarithms


def test_levels_lie_in_bands_around_medians() -> None:
    """Two thirds of the levels of three bands are where two of them overlap."""
    motions = levels.MotionsConfig(bands=levels.BandsConfig(medians_g=(0.4, 0.4, 1.6), ratio=1.5))
    bands_g = levels.bands_around(motions, motions.bands.medians_g)
    assert bands_g == ((0.4 / 1.5, 0.4 * 1.5), (0.4 / 1.5, 0.4 * 1.5), (1.6 / 1.5, 2.25))
    own_g = np.random.default_rng(1).lognormal(-0.5, 0.4, 48)
    levels_g = own_g * levels.block_factors(own_g, bands_g)
    low = np.sort(levels_g[levels_g < 1.0])
    assert (low.size, levels_g.size) == (32, 48)
    assert (low.min() >= 0.4 / 1.5, low.max() <= 0.6) == (True, True)
    assert levels_g[levels_g > 1.0].min() >= 1.6 / 1.5
    assert levels_g.max() <= 2.25
    for start in range(0, 48, 8):  # strong motions have the high levels
        part = slice(start, start + 8)
        assert (np.argsort(levels_g[part]) == np.argsort(own_g[part])).all()
    first_g = own_g * levels.block_factors(own_g, bands_g, ((0.1, 1.0),))
    np.testing.assert_array_equal(first_g[8:], levels_g[8:])
    np.testing.assert_allclose(np.sort(first_g[:8]), 0.1 * 10 ** ((np.arange(8) + 0.5) / 8))
    with pytest.raises(InputError, match="no median"):
        levels.bands_around(motions, (0.01,))


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
    with pytest.raises(InputError, match=r"0\.01 s in q0_h1\.AT2 and 0\.02 s in q0_h2\.AT2"):
        read_motion(first, second)


# --- stripes and the search of a capacity


@pytest.fixture
def three(tmp_path):
    make_pairs(tmp_path, 3)
    return prepare_suite(tmp_path, t1_s=0.7)


def test_scaled_motions_reach_their_stripe_and_are_preserved_by_parquet(three, tmp_path):
    low_g = three[levels.LEVEL_MEASURE].median()
    table = levels.striped(three, [low_g, 2 * low_g], factor_limits=(1e-3, 1e3))
    np.testing.assert_allclose(table["scale"] * table[levels.LEVEL_MEASURE], table["stripe_g"])
    assert len(table) == 6
    assert not table.duplicated(["motion_id", "scale"]).any()
    write_suite(table, tmp_path / "stripes.parquet")
    back = read_suite(tmp_path / "stripes.parquet")
    assert [item.motion.motion_id for item in back] == ["q0", "q1", "q2"] * 2
    levels_g = [item.measures[levels.LEVEL_MEASURE] for item in back]
    np.testing.assert_allclose(levels_g, [low_g] * 3 + [2 * low_g] * 3)


def test_factors_outside_the_limits_are_left_out_and_counted(three, caplog):
    level_g = three[levels.LEVEL_MEASURE].iloc[0]
    table = levels.striped(three, [level_g], factor_limits=(0.999, 1.001))
    assert table[["motion_id", "scale"]].to_numpy().tolist() == [["q0", 1.0]]
    assert "2 of 3 scaled motions are left out" in caplog.text
    known = three.assign(**{levels.LEVEL_MEASURE: [0.2, 0.4, 100.0]})
    rows = levels.striped(known, [0.1, 1.0])[["motion_id", "scale"]].to_numpy().tolist()
    assert rows == [["q0", 0.5], ["q1", 0.25], ["q1", 2.5]]
    with pytest.raises(InputError, match="no motion reaches"):
        levels.striped(three, [1e4])


RATIOS, TOLERANCES = st.floats(1.001, 1e3) | st.just(100.0), st.floats(1e-4, 0.5) | st.just(0.01)


@settings(max_examples=400)
@given(st.floats(1e-3, 1e3), RATIOS, TOLERANCES)
def test_a_search_brackets_any_capacity_in_the_forecast_analyses(capacity, ratio, tolerance):
    trials: list[float] = []

    def exceeds(scale: float) -> bool:
        trials.append(scale)
        return scale >= capacity

    limits = low, high = 0.1, 0.1 * ratio
    lower, upper = levels.bracket_capacity(exceeds, limits=limits, tolerance=tolerance)
    assert len(trials) <= levels.most_trials(limits, tolerance)
    assert lower <= capacity <= upper
    if low < capacity <= high:
        assert upper / lower <= 1.0 + tolerance
    else:
        assert lower == 0.0 or math.isinf(upper)
    assert levels.most_trials((0.1, 10.0)) == 10


# --- cut motions


@pytest.fixture(scope="module")
def motion() -> GroundMotion:
    scenario = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
    return synthesize(scenario, index=0, seed=2023)


def test_cut_motion_ends_at_rest_with_zeros_after_it(motion):
    cut = intensity.cut_to_strongest(motion, 20.0, 5.0)
    assert cut.npts == 2500
    for accel in cut.components:
        assert np.all(accel[-500:] == 0.0)
        speed, disp = intensity.velocity(accel, cut.dt_s), intensity.displacement(accel, cut.dt_s)
        assert abs(speed[-1]) < 1e-9 * np.abs(speed).max()
        assert abs(disp[-1]) < 1e-9 * np.abs(disp).max()
    for impossible in ((0.0, 0.0), (20.0, -1.0)):
        with pytest.raises(InputError):
            intensity.cut_to_strongest(motion, *impossible)


def test_cut_keeps_the_strongest_window_with_a_message_and_another_digest(motion):
    cuts = [intensity.cut_to_strongest(motion, shaking_s, 0.0) for shaking_s in (20.0, 5.0)]
    whole, most, part = (intensity.pair_arias_build_up(each)[-1] for each in (motion, *cuts))
    assert most > 0.95 * whole
    assert part < 0.9 * whole
    done = intensity.strongest_part(motion, 10.0)
    assert done.sha256 != motion.sha256
    assert "of the Arias intensity kept" in done.messages[-1]
    assert done.duration_s == pytest.approx(10.0, abs=0.011)


def test_trimming_quiet_ends_preserves_the_spectrum(motion):
    periods_s = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
    both = (motion, intensity.trim_quiet_ends(motion))
    before, after = (pair_psa(*each.components, each.dt_s, periods_s).rotd50_mps2 for each in both)
    ratios = after / before
    # the displacement left at the new end is taken off: felt at 2 and 3 s only
    np.testing.assert_allclose(ratios[:-2], 1.0, atol=0.002)
    np.testing.assert_allclose(ratios[-2:], 1.0, atol=0.02)
    assert intensity.trim_quiet_ends(motion).duration_s < 0.8 * motion.duration_s
