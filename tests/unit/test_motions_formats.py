"""Readers of each file format on small files."""

from pathlib import Path

import numpy as np
import pytest

from motions_files import shaken_g
from skewbridge.errors import InputError
from skewbridge.motions.folder import list_motions
from skewbridge.motions.formats import DtMissingError, Given
from skewbridge.motions.read import read_trace
from skewbridge.motions.suite import read_entry
from skewbridge.units import G_MPS2

RECORD_G = shaken_g(1, 50)
SI = RECORD_G * G_MPS2


def _file(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def _rows(values, per_line: int, form: str) -> str:
    return "\n".join(
        "".join(form.format(v) for v in values[i : i + per_line])
        for i in range(0, len(values), per_line)
    )


def _at2(head: str, values: str) -> str:
    return "PEER STRONG MOTION DATABASE RECORD\nA, 1/1/2000, B, 90\n" + head + values + "\n"


def _peer(folder: Path, npts: int = 50, values: str = _rows(RECORD_G, 5, "{:15.7E}")) -> Path:
    head = f"ACCELERATION TIME SERIES IN UNITS OF G\nNPTS= {npts}, DT= .01 SEC\n"
    return _file(folder, "a.AT2", _at2(head, values))


@pytest.mark.parametrize(
    "head",
    [
        "ACCELERATION TIME SERIES IN UNITS OF G\nNPTS=     50, DT=   .0100 SEC,\n",
        "ACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 50, DT= .01000SEC,   4 POLE @  50.0 HZ\n",
        "ACCELERATION TIME SERIES IN UNITS OF G\nNPTS=   50, dt=  .01000\n",
        "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=15 Hz\n"
        "NPTS=  50, DT= .01000 SEC\n",
        "The units are (g)\n50 0.0100 NPTS, DT\n",
    ],
)
def test_peer_header_variants_read_alike(tmp_path, head):
    path = _file(tmp_path, "a.AT2", _at2(head, _rows(RECORD_G, 5, "{:15.7E}")))
    trace = read_trace(path)
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)
    assert trace.dt_s == 0.01


@pytest.mark.parametrize(
    ("values", "why"),
    [
        (_rows(RECORD_G, 5, "{:15.7E}").replace("E", "D"), "D exponent"),
        (_rows(RECORD_G, 1, "{:15.7E}"), "one per line"),
        (_rows(RECORD_G, 8, "{:.7E},"), "commas"),
        (_rows(RECORD_G, 5, "{:+.7E}"), "run together"),
        (_rows(RECORD_G, 5, "{:15.7E}") + "\n*** End data ***", "footer"),
    ],
)
def test_peer_value_layouts_read_alike(tmp_path, values, why):
    trace = read_trace(_peer(tmp_path, values=values))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6, err_msg=why)


def test_surplus_values_of_less_than_a_line_are_cut_with_a_warning(tmp_path):
    trace = read_trace(_peer(tmp_path, 47))
    assert trace.accel_mps2.size == 47
    assert any("cut to NPTS" in text for text in trace.warnings)


def test_many_surplus_values_are_refused(tmp_path):
    with pytest.raises(InputError, match="NPTS = 20, but 50"):
        read_trace(_peer(tmp_path, 20))


def test_last_number_without_its_exponent_is_a_cut_file(tmp_path):
    path = _peer(tmp_path, 60, _rows(RECORD_G[:-1], 5, "{:15.7E}") + "  -.3141")
    with pytest.raises(InputError, match="inside a number"):
        read_trace(path)


def test_header_less_at2_asks_for_dt(tmp_path):
    with pytest.raises(InputError, match=r"name it \.acc and give"):
        read_trace(_file(tmp_path, "a.AT2", _rows(RECORD_G, 5, "{:15.7E}")))


def test_given_unit_overrides_the_header_with_a_note(tmp_path):
    trace = read_trace(_peer(tmp_path), Given(unit="m/s2"))
    np.testing.assert_allclose(trace.accel_mps2, RECORD_G, rtol=1e-6)
    assert any("header says g" in text for text in trace.notes)


def test_unit_and_step_if_missing_do_not_override_the_header(tmp_path):
    known = Given(dt_s_if_missing=0.005, unit_if_missing="gal")
    trace = read_trace(_peer(tmp_path), known)
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)
    assert (trace.dt_s, trace.unit, trace.notes) == (0.01, "g", ("unit g as the header says",))
    bare = read_trace(_file(tmp_path, "a.acc", _rows(980.665 * RECORD_G, 5, "{:.8e} ")), known)
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
    text = _v2(line, _rows(cm_s2, per_line, form))
    trace = read_trace(_file(tmp_path, "a.V2", text))
    np.testing.assert_allclose(trace.accel_mps2, cm_s2 * 0.01, atol=6e-6)
    assert (trace.format, trace.station, trace.azimuth_deg) == ("csmip_v2", "TEST STATION", 270.0)


def test_csmip_file_with_two_channels_needs_a_channel(tmp_path):
    one, two = RECORD_G * 980.665, -RECORD_G * 980.665
    text = "\n".join(_v2(V2_LINE, _rows(values, 8, "{:10.3f}")) for values in (one, two))
    path = _file(tmp_path, "a.V2", text)
    with pytest.raises(InputError, match="2 channels"):
        read_trace(path)
    np.testing.assert_allclose(read_trace(path, Given(channel=2)).accel_mps2, two * 0.01, atol=6e-6)
    with pytest.raises(InputError, match="channel 3 of 2"):
        read_trace(path, Given(channel=3))


def test_index_names_the_channels_of_one_file(tmp_path):
    parts = [_v2(V2_LINE, _rows(RECORD_G * f, 8, "{:10.3f}")) for f in (980.665, 200.0, -500.0)]
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
    assert Given(unit=given).unit == unit


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


def test_table_of_several_components_needs_a_channel(tmp_path):
    rows = [f"{i * 0.01:.2f},{v:.8e},{-2 * v:.8e}" for i, v in enumerate(RECORD_G)]
    path = _file(tmp_path, "a.csv", "time_s,h1_g,h2_g\n" + "\n".join(rows))
    with pytest.raises(InputError, match="2 channels, say which"):
        read_trace(path)
    np.testing.assert_allclose(read_trace(path, Given(channel=2)).accel_mps2, -2 * SI, rtol=1e-7)
    with pytest.raises(InputError, match="channel 3 of 2"):
        read_trace(path, Given(channel=3))


def test_bare_values_in_several_columns_are_not_read_as_a_table(tmp_path):
    rising = np.arange(60) ** 1.5 * 1e-4  # a slow start: the first number of each line rises
    path = _file(tmp_path, "a.acc", _rows(rising, 5, "{:15.7e}"))
    np.testing.assert_allclose(
        read_trace(path, Given(dt_s=0.01)).accel_mps2, rising * G_MPS2, rtol=1e-6
    )


@pytest.mark.parametrize("replacement", [[], ["0.21 1.0", "0.20 1.0"], ["0.20"]])
def test_broken_time_column_is_refused_with_its_line(tmp_path, replacement):
    """A hole, a step back, a missing value."""
    rows = [f"{i * 0.01:.2f} {v:.8e}" for i, v in enumerate(RECORD_G)]
    rows[20:22] = replacement
    with pytest.raises(InputError, match=r"line 2[012]"):
        read_trace(_file(tmp_path, "a.txt", "\n".join(rows)))


def test_decimal_comma_is_reported(tmp_path):
    rows = "\n".join(f"{i * 0.01:.2f};{v:.8f}".replace(".", ",") for i, v in enumerate(RECORD_G))
    with pytest.raises(InputError, match="decimal comma"):
        read_trace(_file(tmp_path, "a.csv", rows))


def test_given_dt_overrides_a_time_column_with_a_warning(tmp_path):
    rows = "\n".join(f"{i * 0.003:.3f} {v:.8e}" for i, v in enumerate(RECORD_G))
    trace = read_trace(_file(tmp_path, "a.txt", rows), Given(dt_s=0.0025))
    assert trace.dt_s == 0.0025
    assert any("0.003" in text for text in trace.warnings)


@pytest.mark.parametrize("per_line", [1, 5, 50])
def test_bare_values_need_a_time_step(tmp_path, per_line):
    path = _file(tmp_path, "a.acc", _rows(RECORD_G, per_line, "{:.8e} "))
    with pytest.raises(DtMissingError):
        read_trace(path)
    trace = read_trace(path, Given(dt_s=0.005))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-7)
    assert any("no unit" in text for text in trace.notes)


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
    trace = read_trace(_file(tmp_path, "a.NS2", head + "\n" + _rows(counts, 8, "{:9d}")))
    np.testing.assert_allclose(trace.accel_mps2, SI - SI.mean(), atol=3e-6)
    assert (trace.format, trace.azimuth_deg, trace.warnings) == ("knet", 0.0, ())


def test_components_with_unrelated_names_are_paired_by_header(tmp_path):
    """One station by its channels, as CSMIP names them: 360 and 270 degrees, and up."""
    for channel, direction in ((14, "UP"), (15, "360"), (24, "270")):
        text = _v2(V2_LINE, _rows(RECORD_G * 980.665, 8, "{:10.3f}"))
        text = text.replace("CHAN  1: 270", f"CHAN {channel}: {direction}")
        _file(tmp_path, f"CHAN{channel}.V2", text)
    (entry,) = list_motions(tmp_path)
    assert [path.name for path, _ in entry.components] == ["CHAN15.V2", "CHAN24.V2"]
    assert "TEST_STATION" in entry.motion_id
