"""Ground motions: formats of files, suites, factors, stripes, searches and cuts."""

import hashlib
import math
import re
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motions_files as made
from motions_files import at2_text, cosmos_text, esm_text, make_pairs, rows_of, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions import intensity, levels
from skewbridge.motions.check import check_paths
from skewbridge.motions.folder import group_by_name, list_motions
from skewbridge.motions.formats import DtMissingError, Stated, Trace
from skewbridge.motions.intensity import pair_psa
from skewbridge.motions.read import read_motion, read_trace
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import prepare_suite, read_entry, read_suite, striped, write_suite
from skewbridge.motions.synthesis import Scenario, synthesize
from skewbridge.units import G_MPS2

RECORD_G = shaken_g(1, 50)
SI = RECORD_G * G_MPS2
GAL = shaken_g(7, 400) * 980.665
IN_G = "ACCELERATION TIME SERIES IN UNITS OF G\n"
HISTORY = "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=15 Hz\n"
PLAIN = f"{IN_G}NPTS= 50, DT= .01 SEC\n"
FIVE = rows_of(RECORD_G, 5, "{:15.7E}")
RATIOS = st.floats(1.001, 1e3) | st.just(100.0)


def test_a_cut_before_the_end_of_the_strong_shaking_is_reported():
    """Constant acceleration: the Arias intensity grows linearly; the peak is in the tail."""
    accel = np.ones(1001)
    motion = _motion(accel_1_mps2=accel, accel_2_mps2=0.0 * accel)
    assert "60% of the Arias intensity is after duration_s = 4 " in intensity.cut_warning(motion, 4)
    assert not intensity.cut_warning(motion, 9.6)
    assert not intensity.cut_warning(motion, None)
    accel[990] = 1.1
    late = motion.with_components(accel, 0.0 * accel)
    assert "(unscaled peak until then 0.102 of 0.112 g)" in intensity.cut_warning(late, 9.7)


def _motion(**changes: object) -> GroundMotion:
    fields = {"dt_s": 0.01, "accel_1_mps2": [1.0, 2.0], "accel_2_mps2": [-1.0, 3.0]}
    return GroundMotion(motion_id="m", **(fields | changes))


class Reader:
    def __init__(self, folder: Path):
        self.folder = folder

    def file(self, name: str, text: str | bytes) -> Path:
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return self.folder / name

    def __call__(self, name: str, text: str, **stated: object) -> Trace:
        return read_trace(self.file(name, text), Stated(**stated))

    def refuses(self, words: str, name: str, text: str, **stated: object) -> None:
        path, given = self.file(name, text), Stated(**stated)
        with pytest.raises(InputError, match=words):
            read_trace(path, given)


@pytest.fixture
def read(tmp_path):
    return Reader(tmp_path)


def test_motions_are_rotated_and_scaled_keep_their_metadata_and_must_be_possible():
    np.testing.assert_array_equal(_motion().along_axes(90.0), [[1.0, -3.0], [1.0, 2.0]])
    twice = _motion(event="quake").scaled(2.0)
    assert twice.event == "quake"
    np.testing.assert_array_equal(twice.accel_1_mps2, [2.0, 4.0])
    with pytest.raises(InputError, match="scale"):
        _motion().scaled(0.0)
    wrong = ([1.0], [1.0, np.nan], [1.0, 2.0, 3.0])
    for changes in ({"dt_s": 0.0}, *({"accel_2_mps2": np.array(values)} for values in wrong)):
        with pytest.raises(InputError, match="motion m"):
            _motion(**changes)


@pytest.mark.parametrize(
    ("first", "second", "name"),
    [
        ("RSN6_IMPVALL.I_I-ELC180.AT2", "RSN6_IMPVALL.I_I-ELC270.AT2", "RSN6_IMPVALL.I_I-ELC"),
        ("RSN181_H-E06140.AT2", "RSN181_H-E06230.AT2", "RSN181_H-E06"),
        ("RSN1231_CHY080-E.AT2", "RSN1231_CHY080-N.AT2", "RSN1231_CHY080"),
        *(("120111.txt", "120112.txt", "12011"), ("syn_h1.AT2", "syn_h2.AT2", "syn")),
        *(("X_L.AT2", "X_T.AT2", "X"), ("TAFT-N55W.txt", "TAFT-S35W.txt", "TAFT")),
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


def test_measures_are_means_of_components_or_medians_over_directions():
    """1 m/s2 to and fro for 2 s: CAV 2 m/s, Arias pi/(2 g) x 2; the other component is still."""
    accel = np.array([1.0, -1.0] * 100 + [1.0])
    motion = _motion(accel_1_mps2=accel, accel_2_mps2=np.zeros_like(accel))
    found = intensity.motion_measures(motion, None)
    measures = [found[f"im_{name}"] for name in ("cav_mps", "arias_mps", "d5_75_s", "d5_95_s")]
    assert measures == pytest.approx([1.0, 0.5 * np.pi / (2.0 * 9.80665) * 2.0, 1.4, 1.8])
    twice = intensity.motion_measures(motion.with_components(accel, 3.0 * accel), None)
    assert twice["im_cav_mps"] == pytest.approx((2.0 + 6.0) / 2.0)
    # Peaks 3 m/s2 and 3 x 0.21 s = 0.63 m/s along one axis: cos 45 degrees of them.
    accel = np.array([0.0, *[3.0] * 21, 0.0])
    found = intensity.motion_measures(_motion(accel_1_mps2=accel, accel_2_mps2=0.0 * accel), None)
    assert found["im_pga_rotd50_g"] == pytest.approx(3.0 * np.sqrt(0.5) / 9.80665, rel=0.01)
    assert found["im_pgv_rotd50_mps"] == pytest.approx(0.63 * np.sqrt(0.5), rel=0.01)
    # A blow of 0.6 m/s: an oscillator swings to v/w exp[-xi/w_d atan(w_d/xi)] at any period.
    dt_s, xi = 0.0005, 0.05
    accel = np.zeros(6001)
    accel[1] = 0.6 / dt_s
    damped = np.sqrt(1.0 - xi**2)
    swing = 0.6 * np.exp(-xi / damped * np.arctan(damped / xi))
    assert intensity.housner_intensity(accel, dt_s) == pytest.approx(swing * (2.5 - 0.1), rel=1e-3)


def _with(values: np.ndarray, start: int, *numbers: float) -> np.ndarray:
    changed = values.copy()
    changed[start : start + len(numbers)] = numbers
    return changed


def _times(values, separator=",", dt_s=0.01):
    return "\n".join(f"{i * dt_s:.3f}{separator}{value:.8e}" for i, value in enumerate(values))


def _at2(head: str, values: str) -> str:
    return "PEER STRONG MOTION DATABASE RECORD\nA, 1/1/2000, B, 90\n" + head + values + "\n"


def _peer(npts: int = 50, values: str = FIVE) -> str:
    return _at2(PLAIN.replace("50", str(npts)), values)


COUNTS = np.round(RECORD_G * 980.665 * 8388608 / 2000).astype(int)
COUNTS += round(1234 - COUNTS.mean())
MM_S2 = _with(shaken_g(7, 403) * 9806.65, 20, -12345.6, -13456.7)
GEONET = made.geonet_text({"N28W": MM_S2, "S62W": -0.5 * MM_S2, "Up": 0.1 * MM_S2})
LINES = GEONET.split("\n")
CSMIP = "\n".join(made.v2_text(factor * RECORD_G * 980.665) for factor in (1, -2))
CSV = "time_s,h1_g,h2_g\n" + "\n".join(f"{i * 0.01:.2f},{v:.8e},{-2 * v:.8e}"
                                       for i, v in enumerate(RECORD_G))  # fmt: skip
COSMOS = "".join(
    cosmos_text(factor * GAL, azimuth=azimuth, quantity=quantity)
    for factor, azimuth in ((1.0, 0), (-2.0, 270))  # 0 is unknown
    for quantity in ("acceleration", "velocity", "displacement")
)
TIMED = _times(RECORD_G, " ").split("\n")


def _formats():
    """Yield name, text and stated values of a file, then values, last digit, facts of the header.
    Files of PEER, CSMIP, K-NET, ESM, COSMOS and GeoNet in all their layouts."""
    facts = {"dt_s": 0.01, "event": "A", "station": "B", "azimuth_deg": 90.0}
    for head, values in (
        (f"{IN_G}NPTS=     50, DT=   .0100 SEC,\n", FIVE),
        (f"{IN_G}NPTS= 50, DT= .01000SEC,   4 POLE @  50.0 HZ\n", FIVE),
        (f"{IN_G}NPTS=   50, dt=  .01000\n", FIVE),
        (PLAIN.replace(IN_G, HISTORY), FIVE),
        ("The units are (g)\n50 0.0100 NPTS, DT\n", FIVE),
        (PLAIN, FIVE.replace("E", "D")),
        (PLAIN, FIVE.replace("E", "")),  # Fortran reads 1.0-3
        (PLAIN, rows_of(RECORD_G, 1, "{:15.7E}")),
        (PLAIN, rows_of(RECORD_G, 8, "{:.7E},")),
        (PLAIN, rows_of(RECORD_G, 5, "{:+.7E}")),  # run together
        (PLAIN, f"{FIVE}\n*** End data ***"),
    ):
        yield "a.AT2", _at2(head, values), {}, SI, 0.0, facts
    facts = {"format": "csmip_v2", "station": "TEST STATION", "azimuth_deg": 270.0}
    cm_s2 = _with(RECORD_G * 98.0665, 3, -1234.123)
    yield "a.V2", made.v2_text(cm_s2), {}, 0.01 * cm_s2, 6e-6, facts
    cm_s2 = _with(RECORD_G * 98.0665, 3, -12.632701)
    text = made.v2_text(cm_s2, "{:10.6f}", "at  .010 sec, in cm/sec2. (8f10.6)")
    yield "a.V2", text, {}, 0.01 * cm_s2, 6e-6, facts
    line = "AT  .010 SEC.  (UNITS: M/SEC/SEC) (8F10.6)"
    yield "a.V2", made.v2_text(SI, "{:10.6f}", line), {}, SI, 6e-7, {"unit": "m/s2"}
    for name, text in (("a.V2", CSMIP), ("a.csv", CSV)):
        yield name, text, {"channel": 2}, -2.0 * SI, 6e-6, {}
    rows = [f"{i * 10},{v:.8e}" for i, v in enumerate(RECORD_G)]
    numbered = [f"{i},{i * 0.01:.2f},{v:.8e}" for i, v in enumerate(RECORD_G)]
    for head, lines in (
        ("time (ms),acc (g)", rows), (",time,acc (g)", numbered),
        ("time (ms),acc (g),vel,disp", [f"{row},0.1,0.2" for row in rows]),
    ):  # fmt: skip
        yield "a.csv", "\n".join([head, *lines]), {}, SI, 1e-6, {"dt_s": 0.01}
    facts = {"format": "knet", "azimuth_deg": 0.0, "warnings": ()}
    yield "a.NS2", made.knet_text(COUNTS), {}, SI - SI.mean(), 3e-6, facts
    facts = {"format": "esm", "dt_s": 0.005, "unit": "cm/s2", "azimuth_deg": 90.0}
    facts |= {"event": "EMSC-1", "station": "XX.ABC", "notes": ()}
    yield "a.ASC", esm_text(GAL), {}, 0.01 * GAL, 6e-9, facts
    facts = {"format": "cosmos", "dt_s": 0.005, "azimuth_deg": 90.0}
    facts |= {"event": "Record of Test Quake", "station": "Statn No: 37-11 Code:XX-ABC"}
    for layout, digit, unit, in_gal in (
        (("(1E15.6)", 1, "{:15.6e}"), 1e-7, None, 1.0),
        (("(8F10.5)", 8, "{:10.5f}"), 1e-5, (-999, -999, "cm/s^2 (4)"), 1.0),
        (("(10F8.3)", 10, "{:8.3f}"), 1e-3, (1, 10, "gal(10)"), 1.0),
        (("(6F13.9)", 6, "{:13.9f}"), 1e-9, (1, 2, "g(02)"), 980.665),
        (("(8F10.4)", 8, "{:10.4f}"), 1e-4, (1, 11, "mg(11)"), 0.980665),
    ):
        given = GAL / in_gal
        if layout[0] == "(10F8.3)":
            given = _with(given, 10, -510.123, -610.25)
        text, scale = cosmos_text(given, layout=layout, unit=unit), 0.01 * in_gal
        yield "a.acc.V2c", text, {"unit_if_missing": "m/s2"}, scale * given, scale * digit, facts
    yield "a.V2C", COSMOS, {"channel": 2}, -0.02 * GAL, 1e-9, {"azimuth_deg": 270.0}
    facts = {"format": "geonet_v2a", "dt_s": 0.02, "station": "ABC"}
    facts |= {"event": "2016 November 13         11:02:56 UT"}
    for name, channel in product(("a.V2A", "a.txt"), (1, 2)):
        values, azimuth = ((1e-3 * MM_S2, 332.0), (-5e-4 * MM_S2, 242.0))[channel - 1]
        yield name, GEONET, {"channel": channel}, values, 6e-5, facts | {"azimuth_deg": azimuth}


@pytest.mark.parametrize("case", [*_formats()], ids=lambda case: case[0])
def test_every_format_has_values_in_si_and_the_facts_of_its_header(read, case):
    name, text, stated, values, last_digit, facts = case
    trace = read(name, text, **stated)
    relative = 1e-6 if trace.format == "cosmos" else 1e-7
    np.testing.assert_allclose(trace.accel_mps2, values, rtol=relative, atol=last_digit)
    assert {fact: getattr(trace, fact) for fact in facts} == facts


@pytest.mark.parametrize("case", [
    ("NPTS = 20, but the file has 50", "a.AT2", _peer(20)),
    ("inside a number", "a.AT2", _peer(60, FIVE.rsplit(maxsplit=1)[0] + "  -.3141")),
    ("UTF-16 text: save it as UTF-8", "a.AT2", _peer().encode("utf-16")),
    # without a digit in front, as Fortran writes: ,1492465E-03
    ("decimal commas: write points", "a.AT2", _peer(values=re.sub(r"\d\.", ",", FIVE))),
    (r"rename bare values to \.acc, give", "a.AT2", FIVE),
    *(("not an acceleration", "a.AT2", _at2(PLAIN.replace(IN_G, f"(UNITS: {unit}\n"), FIVE))
      for unit in ("CM/S)", "CM)", "M/S)", "CM/SEC)", "INCHES) DISPLACEMENT")),
    ("2 channels", "a.V2", CSMIP), ("no channel 3: the file has 2", "a.V2", CSMIP, 3),
    ("2 channels", "a.csv", CSV), ("no channel 3: the file has 2", "a.csv", CSV, 3),
    ("decimal comma", "a.csv", "\n".join(TIMED).replace(" ", ";").replace(".", ",")),
    # a hole, a step back, a missing value in the column of time
    *(("line 2[012]", "a.txt", "\n".join([*TIMED[:20], *rows, *TIMED[22:]]))
      for rows in ([], ["0.21 1.0", "0.20 1.0"], ["0.20"])),
    ("NDATA = 399, but the file has 400", "a.ASC", esm_text(GAL, NDATA="399")),
    ("DATA_TYPE must be ACCELERATION", "a.ASC", esm_text(GAL, DATA_TYPE="VELOCITY", UNITS="cm/s")),
    ("DATA_TYPE must be", "a.ASC", esm_text(GAL, DATA_TYPE="ACCELERATION RESPONSE SPECTRUM")),
    ("not an acceleration by its header: 'cm/s'", "a.ASC", esm_text(GAL, UNITS="cm/s")),
    ("SAMPLING_INTERVAL_S", "a.ASC", esm_text(GAL, SAMPLING_INTERVAL_S="")),
    (r"2 channels \(1 HNE, 2 270\)", "a.V2C", COSMOS),
    ("not an acceleration", "a.V2c", cosmos_text(GAL, quantity="velocity")),
    ("unknown unit 'counts", "a.V2c", cosmos_text(GAL, unit=(1, 50, "counts (50)"))),
    ("but 2 s in all", "a.V2c", cosmos_text(GAL, 0.005).replace("5.000000", "0.005000")),
    *(row for name in ("a.V2A", "a.txt") for row in (
        (r"3 channels \(1 N28W, 2 S62W, 3 Up\)", name, GEONET),
        ("truncated", name, "\n".join(LINES[:125]), 1),
        ("uncorrected", name, "Un" + GEONET[0].lower() + GEONET[1:]))),
    ("SMC file, which is not read: get", "a.smc", "2 CORRECTED ACCELEROGRAM\n" + FIVE),
    (r"uncorrected accelerogram \(V1\)", "a.V1", "UN" + made.v2_text(RECORD_G)),
    ("first number is the count", "a.txt", "50\n" + rows_of(RECORD_G, 1, "{:.6e}")),
    # a separator of thousands, and a step in the first line
    ("line 4: the row must have 1 column,", "a.txt", "unit: gal\n1.0\n200.5\n-1,234.5\n3.0\n"),
    ("line 2: the row must have 1 column,", "a.txt", "0.01\n" + FIVE),
    *(("not an acceleration by its name", name, "\n".join(TIMED))
      for name in ("vel_090.txt", "RSN1_000_DISP.csv", "a.displ.txt")),
], ids=lambda case: case[0])  # fmt: skip
def test_a_wrong_file_is_refused_with_its_fault(read, case):
    words, name, text, channel = (*case, None)[:4]
    read.refuses(words, name, text, channel=channel)


@pytest.mark.parametrize("case", [
    ("warnings", "cut to NPTS", "a.AT2", _peer(47), {}, SI[:47]),
    ("notes", "not g", "a.AT2", _peer(), {"unit": "m/s2"}, RECORD_G),
    ("warnings", "0.003", "a.txt", _times(RECORD_G, " ", 0.003), {"dt_s": 0.0025}, SI),
    ("warnings", "NDATA = 420, but the file has 400", "a.ASC", esm_text(GAL, NDATA="420"), {},
     0.01 * GAL),
    ("warnings", "truncated", "a.V2c", "\n".join(cosmos_text(GAL).split("\n")[:-40]), {},
     0.01 * GAL[:362]),
    ("warnings", "2 values are -999", "a.csv", "t,a (gal)\n" + _times(_with(GAL, 20, -999, -999)),
     {}, 0.01 * _with(GAL, 20, -999, -999)),
    ("warnings", "gal and 50: truncated?", "a.NS",
     made.knet_text(COUNTS).replace("(s)  1", "(s)  3"), {}, SI - SI.mean()),
    # in the second component
    *(("warnings", "truncated", name, "\n".join(LINES[:150]), {"channel": 2}, -5e-4 * MM_S2[:150])
      for name in ("a.V2A", "a.txt")),
], ids=lambda case: case[1])  # fmt: skip
def test_a_doubtful_file_is_read_with_a_message(read, case):
    kind, words, name, text, stated, values = case
    trace = read(name, text, **stated)
    assert any(words in message for message in getattr(trace, kind))
    np.testing.assert_allclose(trace.accel_mps2, values, rtol=1e-6, atol=6e-5)
    assert trace.dt_s == stated.get("dt_s", trace.dt_s)


def test_index_names_the_channels_of_one_file(read):
    name = f"{'a' * 200}/{'b' * 99}/all.V2"  # a path may be longer than each of its names
    (read.folder / name).parent.mkdir(parents=True)
    read.file(name, "\n".join(made.v2_text(RECORD_G * f) for f in (980.665, 200.0, -500.0)))
    index = f"motion_id,file_1,file_2,channel_1,channel_2\nbridge,{name},{name},1,3\n"
    read.file("index.csv", index)
    motion = read_entry(list_motions(read.folder)[0])
    np.testing.assert_allclose(motion.components, [SI, -5.0 * RECORD_G], atol=6e-6)


@pytest.mark.parametrize("per_line", [1, 5, 50])
def test_bare_values_need_a_time_step_and_are_not_read_as_a_table(read, per_line):
    text = rows_of(RECORD_G, per_line, "{:.8e} ")
    with pytest.raises(DtMissingError):
        read("a.acc", text)
    trace = read("a.acc", text, dt_s=0.005)
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-7)
    assert any("no unit" in text for text in trace.notes)
    for header in ("Sampling rate: 200", "dt = .005", "interval (s) 0.005"):
        assert read("a.acc", f"{header} .\n{text}").dt_s == 0.005
        found = [read("a.acc", f"{header} .\n{text}", dt_s=dt_s) for dt_s in (0.005, 0.01)]
        doubt = f"dt = 0.01 s is used, but the header states {header}"
        assert [trace.warnings for trace in found] == [(), (doubt,)]
    trace = read("a.AT2", _at2(PLAIN, FIVE), dt_s_if_missing=0.02)
    assert trace.notes[0] == "dt = 0.01 s of the file is used, not 0.02 s"
    rising = np.arange(60) ** 1.5 * 1e-4  # a slow start: the first number of each line rises
    trace = read("a.acc", rows_of(rising, per_line, "{:15.7e}"), dt_s=0.01)
    np.testing.assert_allclose(trace.accel_mps2, rising * G_MPS2, rtol=1e-6)


def test_components_of_unrelated_names_are_paired_by_their_headers(read):
    """Files of CSMIP, COSMOS and ESM; the third channel is vertical."""
    for channel, direction, azimuth, letter in (
        (14, "UP", 400, "Z"), (15, "360", 360, "N"), (24, "270", 90, "E"),
    ):  # fmt: skip
        text = made.v2_text(RECORD_G * 980.665, channel=f"{channel}: {direction}")
        read.file(f"CHAN{channel}.V2", text)
        cosmos = cosmos_text(GAL, azimuth=azimuth, scnl="ABC.HN.XX.--")
        read.file(f"ABC.1000hyfh.HN{letter}.--.acc.V2c", cosmos)
        text = esm_text(GAL, stream=f"HN{letter}")
        read.file(f"HI.ABC..HN{letter}.D.20190728.160908.C.ACC.ASC", text)
    found = {e.motion_id: [path.name for path, _ in e.components]
             for e in list_motions(read.folder)}  # fmt: skip
    assert sorted(found.values()) == [
        ["ABC.1000hyfh.HNE.--.acc.V2c", "ABC.1000hyfh.HNN.--.acc.V2c"],
        ["CHAN15.V2", "CHAN24.V2"],
        [f"HI.ABC..HN{letter}.D.20190728.160908.C.ACC.ASC" for letter in "EN"],
    ]
    assert any("TEST_STATION" in name for name in found)
    assert {check.verdict for check in check_paths([read.folder])} <= {"ok", "warn"}


VERTICAL_FILES = {
    "a.V2": lambda up: made.v2_text(RECORD_G * 980.665, channel=f"1: {up}"),
    "a.AT2": lambda up: at2_text(RECORD_G).replace("Station, 90", f"Station, {up}"),
    "old.AT2": lambda up: _peer().replace("A, 1/1/2000, B, 90", f"A 5/19/40 0439, B, {up} (X)"),
    "a.csv": lambda up: f"time (s),{up} (g)\n" + _times(RECORD_G),
    "b.csv": lambda up: f"time,acc_{up}\n" + _times(RECORD_G),
    "a.acc": lambda up: f"{up}\n" + rows_of(RECORD_G, 1, "{:.6e}"),
    "a.V2A": lambda up: made.geonet_text({up: 9806.65 * RECORD_G}),
    "a.ASC": lambda up: esm_text(GAL, 0.01, stream=up),
    "a.V2c": lambda up: cosmos_text(GAL, 0.01, azimuth=0, scnl=f"A.{up}.XX.--"),
}


@pytest.mark.parametrize("name", VERTICAL_FILES)
@pytest.mark.parametrize("direction", ["UP", "Up", "-UP", "Z", "V", "VERT", "HNZ", "DWN", "U-D"])
def test_a_channel_whose_header_says_vertical_is_no_component(read, name, direction):
    if name in {"old.AT2", "a.V2", "a.V2c"} and not direction.isalpha():
        direction = "Vert"
    if name == "old.AT2" and direction in {"Z", "V", "HNZ"}:
        direction = "UD"
    read.file(name, VERTICAL_FILES[name](direction))
    read.file("other.AT2", at2_text(RECORD_G))
    for files in (f"{name},other.AT2", f"other.AT2,{name}"):
        read.file("index.csv", f"motion_id,file_1,file_2,dt_s\nm,{files},0.01\n")
        (entry,) = list_motions(read.folder)
        with pytest.raises(InputError, match=rf"{name}: the header states a vertical.*{direction}"):
            read_entry(entry)
        assert {check.verdict for check in check_paths([read.folder])} == {"error"}


#: Headers of a column by its unit, with the unit in m/s2.
ACCELERATION_HEADERS = {
    ("g", 9.80665): ["", "time,accel_g", "m_south,a_g", "# time acceleration"],
    ("m/s2", 1.0): [
        "time_s;accel_mps2", "time_s,acc_m_s2", "t (s),a_g (m/s2)", "t [s],üg [m/s²]", "t,a_g m/s2",
        "t,acc_ms2", "t,a (metres per second squared)", "t,g\n(s),(m/sec2)", "t,a (m/s*s)",
    ],
    ("%g", 0.0980665): ["t,acc (%g)"],
    ("mm/s2", 1e-3): ["time (s),a (mm/s2)"], ("mg", 9.80665e-3): ["t,a (mg)", "t,a (milli-g)"],
    ("in/s2", 0.0254): ["t,a (in/s2)"], ("ft/s2", 0.3048): ["t,a (ft/sec2)", "t,a (feet/s/s)"],
    ("cm/s2", 0.01): [
        "time (s),acc (cm/s2)", "t,a (cm/s^2)", "t,a (cm/s/s)", "t,a (cm/sec/sec)", "t,a (gal)",
        "t,a [cm/sec^2]", "t,a (CM/SEC**2)", "t,a_cmps2", "t,acc_cm_s2", "t (s), a (cm/s2)",
        "velocity model of X\nt,accel (cm/s2)", "t,a (cm/s²)", "t,a (cm s-2)", "t,a cm·s⁻²",
        "PGV 12 cm/s, PGD 3 cm\nt,a (cm/sec2)", "# units: cm/s2\ntime acc", "t;Gals",
        "Vs30 = 760 m/s\nt,a_gal", "time_s,acc_cm_s2",
    ],
}  # fmt: skip
SMOOTH = np.array(
    [np.sin(np.arange(400) / 9.0), np.sin(np.arange(400) / 7.0), np.cos(np.arange(400) / 5.0)]
).T * np.hanning(400)[:, None]  # fmt: skip


def _table(values, *, header="", separator=" "):
    rows = [separator.join(f"{value:.6f}" for value in row) for row in values]
    return header + "\n".join(rows) + "\n"


@pytest.mark.parametrize("columns", [2, 3, 6])
@pytest.mark.parametrize("header", ["", "title\n", "NS EW UD\n", "400 0.01\n"])
@pytest.mark.parametrize("separator", [" ", ","])
def test_columns_without_time_are_channels_and_never_one_series(read, columns, header, separator):
    values = np.hstack([SMOOTH, -2.0 * SMOOTH])[:, :columns] * 0.1
    text = _table(values, header=header, separator=separator)
    read.refuses(f"{columns} (numbers per line|channels)", "a.txt", text, dt_s=0.01)
    for channel in range(1, columns + 1):
        trace = read("a.txt", text, dt_s=0.01, channel=channel)
        np.testing.assert_allclose(trace.accel_mps2, values[:, channel - 1] * G_MPS2, atol=1e-5)
    read.refuses(f"no channel {columns + 1}", "a.txt", text, dt_s=0.01, channel=columns + 1)
    cut = text.rstrip("\n").rpartition(separator)[0]
    words = f"(row must have {columns} columns|header states 400)"
    read.refuses(words, "b.txt", cut, dt_s=0.01, channel=1)


def test_only_even_times_are_a_time_column(read):
    """The first eight values of a record can rise as evenly as a time."""
    rising = np.sin(np.arange(400) / 60.0)[:, None] * [1.0, 0.5]
    for count, channel in ((2, 1), (2, 2), (3, 2)):
        values = np.hstack([rising, SMOOTH])[:, :count] * 0.1
        trace = read("a.txt", _table(values), dt_s=0.005, channel=channel)
        np.testing.assert_allclose(trace.accel_mps2, values[:, channel - 1] * G_MPS2, atol=1e-5)
    times = np.cumsum(np.random.default_rng(1).uniform(0.001, 0.03, 400))
    text = _table(np.column_stack([times, SMOOTH]))
    read.refuses("time column", "a.txt", text, dt_s=0.01, channel=2)
    rows = zip(np.arange(400) * 0.0025, _table(SMOOTH).splitlines(), strict=True)  # rounded
    trace = read("a.txt", "\n".join(f"{time:.3f} {row}" for time, row in rows), channel=2)
    np.testing.assert_allclose(trace.accel_mps2, SMOOTH[:, 1] * G_MPS2, atol=1e-5)
    assert trace.dt_s == 0.0025
    # a time that begins at its step, and counts of an instrument, are no header
    counts = np.round(RECORD_G * 1000).astype(int) + 50
    rows = [f"{0.01 * i:.2f} {value}" for i, value in enumerate(counts, 1)]
    trace = read("a.txt", "\n".join(rows), unit="mg")
    np.testing.assert_allclose(trace.accel_mps2, counts * G_MPS2 / 1000)
    assert trace.dt_s == 0.01


@pytest.mark.parametrize("per_line", [1, 2, 3, 4, 5, 7, 8, 10])
@pytest.mark.parametrize("seed", range(3))
def test_one_series_of_several_values_per_line_is_no_table(read, per_line, seed):
    """Lines of 2 or 3 numbers need a count, or a shorter last line, to be one series."""
    series = np.convolve(shaken_g(seed, 401), np.hanning(9), mode="same")
    for header in ("", "401 0.01\n"):
        text = header + rows_of(series, per_line, "{:15.7e}")
        if not header and per_line in {2, 3} and len(series) % per_line == 0:
            read.refuses("numbers per line", "a.txt", text, dt_s=0.01)
            continue
        trace = read("a.txt", text, dt_s=0.01)
        np.testing.assert_allclose(trace.accel_mps2, series * G_MPS2, atol=1e-6)
    if per_line > 3:
        text = rows_of(series[:400], per_line, "{:15.7e}")
        read.refuses(r"not channels: remove|must have", "b.txt", text, dt_s=0.01, channel=1)


@pytest.mark.parametrize("title", ["", "A title, 1940\n", "A title\nNPTS DT\n"])
@pytest.mark.parametrize(
    "count", ["50 0.01", "  50   .0100  ", "50, 0.01", "0.01 50", "50 1.0E-02 record of B",
              "NPTS 50 DT 0.01", "NPTS: 50; DT: 0.01", "npts=50 dt=0.01"],
)  # fmt: skip
def test_a_line_with_count_and_step_is_a_header(read, title, count):
    is_peer = "=" in count or ":" in count  # such a header is PEER's, which has no time column
    bodies = [rows_of(RECORD_G, per_line, "{:15.7e}") for per_line in (1, 5)]
    for body in (*bodies, *([] if is_peer else ["\n".join(TIMED)])):
        text = f"{title}{count}\n{body}\n"
        trace = read("a.txt", text)
        np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)
        assert (trace.dt_s, trace.accel_mps2.size) == (0.01, 50)
        if not is_peer:
            wrong = text.replace("50", "61", 1)
            read.refuses("states 61 values, but the file has 50", "a.txt", wrong)


@pytest.mark.parametrize(
    ("header", "unit", "in_si"),
    [(header, *unit) for unit, headers in ACCELERATION_HEADERS.items() for header in headers],
)
def test_two_columns_take_their_unit_from_the_header(read, header, unit, in_si):
    trace = read("a.csv", f"{header}\n{_times(SI / in_si, ', ')}".lstrip("\n"))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-7)
    assert (trace.format, trace.unit, trace.dt_s) == ("two_column", unit, 0.01)


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".acc", ".bbp"])
@pytest.mark.parametrize("header", [
    "Time (s),Velocity (cm/s)", "Time (s),Displacement (cm)", "t (s),v (m/s)", "t,u (mm)",
    "t,u [m]", "t,u (in)", "t,v (in/s)", "t,v (ft/sec)", "time,velocity", "time,disp",
    "time_s,vel_mps", "time_s,v_cm_s", "time_s,d_m", "time_s,d_mm", "time_s,d_cm", "t,Displ.",
    "t,v (cm/sec)", "# units: cm/s\ntime h1", "VELOCITY IN CM/SEC\ntime h1", "units: m\nt,h1",
    "t,veloc [mm/s]", "t,cm", "t,h1 (inches)", "time,v (kine)",
])  # fmt: skip
def test_velocities_and_displacements_are_refused_by_their_header(read, header, suffix):
    body = rows_of(RECORD_G, 1, "{:.6e}") if suffix == ".acc" else _times(RECORD_G)
    for unit in (None, "cm/s2"):
        read.refuses("not an acceleration", f"a{suffix}", f"{header}\n{body}", dt_s=0.01, unit=unit)


def test_each_column_has_its_own_quantity_and_direction(read):
    table = np.column_stack([0.01 * np.arange(400), 98.0 * SMOOTH])
    head = "# Sim stat=ABC\n#    time(sec)      N-S({0})      E-W({0})      U-D({0})\n"
    text = _table(table, header=head.format("cm/s/s"))
    first, second, up = (read("a.bbp", text, channel=n) for n in (1, 2, 3))
    assert (first.azimuth_deg, second.azimuth_deg, up.is_vertical) == (0.0, 90.0, True)
    np.testing.assert_allclose(second.accel_mps2, 0.98 * SMOOTH[:, 1], atol=1e-7)
    for code in (401, 402):
        assert read("up.V2c", cosmos_text(GAL, azimuth=code, scnl="A.B.C.D")).is_vertical
    # also with a separator at the end of each line
    ended = "time,NS (gal),EW (gal),UD (gal),\n" + _table(table, separator=",").replace("\n", ",\n")
    assert [read("a.csv", ended, channel=n).is_vertical for n in (1, 2, 3)] == [False, False, True]
    for unit in ("cm/s", "cm", "m/s", "m"):
        text = _table(table, header=head.format(unit))
        read.refuses("not an acceleration", "a.vel.bbp", text, channel=1)
    header = "Time (s),Accel (cm/s2),Velocity (cm/s),Displ (cm)\n"
    text = _table(table, header=header, separator=",")
    assert read("a.csv", text, channel=1).unit == "cm/s2"
    for channel in (2, 3):
        read.refuses("not an acceleration", "a.csv", text, channel=channel)


def test_an_unknown_format_is_refused_with_the_list_of_formats(read):
    for text in ("no numbers\n" * 30, "line\n" * 11 + _times(RECORD_G)):
        read.refuses(r"unknown format.*at most 10 header lines.*PEER.*columns", "a.txt", text)
    trace = read("a.txt", "line\n" * 10 + _times(RECORD_G))
    np.testing.assert_allclose(trace.accel_mps2, SI, rtol=1e-6)


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
    # a suite is limited to a count, and cut
    make_pairs(tmp_path, 9)
    three = prepare_suite(tmp_path, count=3, t1_s=0.7)
    with pytest.raises(InputError, match=r"count = 10, but .* has 9"):
        prepare_suite(tmp_path, count=10, t1_s=0.7)
    cut = prepare_suite(tmp_path, count=3, t1_s=0.7, shaking_s=3.0)
    assert cut["npts"][0] == 300 < three["npts"][0]
    assert cut["sha256"][0] != three["sha256"][0]
    # a window of their length changes nothing
    pd.testing.assert_frame_equal(prepare_suite(tmp_path, count=3, t1_s=0.7, shaking_s=4.0), three)


def test_a_record_under_two_names_is_reported_but_not_of_other_levels(tmp_path, caplog):
    pairs = make_pairs(tmp_path, 2)
    for copied, original in zip(pairs[1], pairs[0], strict=True):
        copied.write_bytes(original.read_bytes())
    for scale, count in (([1.25, 2.5], 0), ([1.25, 1.25], 1), (["", ""], 2)):
        made.index_of(tmp_path, pairs, scale=scale)
        stored = prepare_suite(tmp_path, t1_s=0.7)["messages"]
        assert stored.str.contains("samples of motion q0: does").tolist() == [False, count > 0]
        assert caplog.text.count("motion q1: the samples of motion q0") == count
    notes = [text for check in check_paths([tmp_path]) for text in check.messages]
    assert sum(text.startswith("same samples as") for text in notes) == 2


def test_index_gives_metadata_and_a_factor_that_overrides_the_computed_one(tmp_path):
    made.index_of(tmp_path, make_pairs(tmp_path, 2), scale=[1.25, ""])
    scales = prepare_suite(tmp_path, t1_s=0.7, bands_g=((0.3, 0.3001),))
    assert scales["scale"][0] == 1.25
    assert (scales["scale"] * scales["im_saavg_rotd50_g"])[1] == pytest.approx(0.3, rel=1e-3)
    pairs = make_pairs(tmp_path, 1)
    made.index_of(
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


def test_blocks_interleave_an_incomplete_one_fills_the_range_and_levels_lie_in_bands():
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
    # two thirds of the levels of three bands are where two of them overlap
    motions = levels.MotionsConfig(bands=levels.BandsConfig(medians_g=(0.4, 0.4, 1.6), ratio=1.5))
    bands_g = levels.bands_around(motions, motions.bands.medians_g)
    assert bands_g == ((0.4 / 1.5, 0.4 * 1.5), (0.4 / 1.5, 0.4 * 1.5), (1.6 / 1.5, 2.25))
    own_g = np.random.default_rng(1).lognormal(-0.5, 0.4, 48)
    levels_g = own_g * levels.block_factors(own_g, bands_g)
    low, high = levels_g[levels_g < 1.0], levels_g[levels_g > 1.0]
    assert (low.size, high.size) == (32, 16)
    assert 0.4 / 1.5 <= low.min() < low.max() <= 0.6
    assert 1.6 / 1.5 <= high.min() < high.max() <= 2.25
    # strong motions have the high levels
    order, own_order = (np.argsort(values.reshape(6, 8)) for values in (levels_g, own_g))
    np.testing.assert_array_equal(order, own_order)
    first_g = own_g * levels.block_factors(own_g, bands_g, ((0.1, 1.0),))
    np.testing.assert_array_equal(first_g[8:], levels_g[8:])
    np.testing.assert_allclose(np.sort(first_g[:8]), 0.1 * 10 ** ((np.arange(8) + 0.5) / 8))
    of_trials = levels.MotionsConfig(bands=levels.BandsConfig(ratio=1.5))
    assert levels.bands_around(of_trials, (0.4, 9.0)) == bands_g[:1]
    for config, medians_g in ((of_trials, (0.01,)), (motions, (0.4, 9.0))):
        with pytest.raises(InputError, match="outside level_range_g"):
            levels.bands_around(config, medians_g)


def test_pairs_are_found_among_other_files_and_ordered_by_the_index(tmp_path):
    pairs = make_pairs(tmp_path, 2)
    (tmp_path / "notes.txt").write_text("Downloaded on Monday.\n")
    (tmp_path / "table.csv").write_text("RSN,PGA\nRSN6,0.2\n")
    (tmp_path / "_SearchResults.csv").write_text("1,2\n3,4\n")
    (tmp_path / "q0_h1.VT2").write_text("velocity\n")
    (tmp_path / "q0_UP.AT2").write_text("vertical\n")
    for ending in ("NS", "EW"):  # 17 lines of header
        (tmp_path / f"q2_{ending}.txt").write_text(made.knet_text(COUNTS))
    assert [entry.motion_id for entry in list_motions(tmp_path)] == ["q0", "q1", "q2"]
    made.index_of(tmp_path, pairs[::-1])
    assert [entry.motion_id for entry in list_motions(tmp_path)] == ["q1", "q0"]


def test_components_differ_in_length_and_never_in_their_step(tmp_path):
    (first, second), *_ = make_pairs(tmp_path, 1)
    first.write_text(at2_text(shaken_g(0, 390)))
    motion = read_motion(first, second)
    assert motion.npts == 400
    assert not motion.accel_1_mps2[-10:].any()
    second.write_text(at2_text(shaken_g(0), 0.02))
    with pytest.raises(InputError, match=r"0\.01 s in q0_h1\.AT2 and 0\.02 s in q0_h2\.AT2"):
        read_motion(first, second)
    (first := tmp_path / "a.txt").write_text(_times(RECORD_G))
    (second := tmp_path / "b.txt").write_text(_times(RECORD_G).split("\n", 5)[5])
    with pytest.raises(InputError, match=r"begin at 0 s in a\.txt and 0\.05 s in b\.txt: cut both"):
        read_motion(first, second)


KOBE = at2_text(RECORD_G).replace("Quake", "Kobe").replace("Station, 90", "Takatori, 0")
BARE = _times(shaken_g(1)), _times(shaken_g(2))


def _turned(*azimuths: int) -> list[str]:
    return [at2_text(shaken_g(n), 0.01, azimuth) for n, azimuth in enumerate(azimuths, 1)]


@pytest.mark.parametrize(
    ("names", "texts", "words"),
    [
        (("A.AT2", "B.AT2"), (at2_text(RECORD_G), KOBE), r"different records\?"),
        (("q_000.txt", "q_090.txt"), BARE, ""),
        (("TCU052.txt", "TCU065.txt"), BARE, "different records?.*azimuths 52 and 65 are not"),
        (("q_000.AT2", "q_090.AT2"), _turned(0, 180), "records?.*azimuths 0 and 180 are not"),
        (("LCN260.AT2", "LCN345.AT2"), _turned(260, 345), ""),
        (("q_000.txt", "q_090.txt"), [_times(RECORD_G), _times(-RECORD_G)], "component twice"),
        (("q_1.txt", "q_UP.txt"), BARE, r"vertical component\? By its name, q_UP\.txt is one"),
    ],
)
def test_events_and_directions_in_headers_or_names_are_compared(read, names, texts, words):
    found = check_paths([read.file(*each) for each in zip(names, texts, strict=True)])
    assert {check.verdict for check in found} == {"warn" if words else "ok"}
    assert all(re.search(words, " ".join(check.messages)) for check in found)


def test_scaled_motions_reach_their_stripe_unless_their_factor_is_outside_limits(tmp_path, caplog):
    make_pairs(tmp_path, 3)
    three = prepare_suite(tmp_path, t1_s=0.7)
    low_g = three[levels.LEVEL_MEASURE].median()
    table = striped(three, [low_g, 2 * low_g])
    write_suite(table, tmp_path / "stripes.parquet")
    back = read_suite(tmp_path / "stripes.parquet")
    assert [item.motion.motion_id for item in back] == ["q0", "q1", "q2"] * 2
    levels_g = [item.measures[levels.LEVEL_MEASURE] for item in back]
    np.testing.assert_allclose(levels_g, [low_g] * 3 + [2 * low_g] * 3)
    known = three.assign(**{levels.LEVEL_MEASURE: [0.2, 0.4, 100.0]})
    rows = striped(known, [0.1, 1.0])[["motion_id", "scale"]].to_numpy().tolist()
    assert rows == [["q0", 0.5], ["q1", 0.25], ["q1", 2.5]]
    assert "3 of 6 scaled motions are left out" in caplog.text
    with pytest.raises(InputError, match="no motion reaches"):
        striped(three, [1e4])


@settings(max_examples=400)
@given(st.floats(1e-3, 1e3), RATIOS)
def test_a_search_brackets_any_capacity_in_the_forecast_analyses(capacity, ratio):
    trials: list[float] = []

    def exceeds(scale: float) -> bool:
        trials.append(scale)
        return scale >= capacity

    limits = low, high = 0.1, 0.1 * ratio
    lower, upper = levels.bracket_capacity(exceeds, limits=limits)
    assert len(trials) <= levels.most_trials(limits)
    assert lower <= capacity <= upper
    if low < capacity <= high:
        assert upper / lower <= 1.0 + levels.IDA_TOLERANCE
    else:
        assert lower == 0.0 or math.isinf(upper)
    assert levels.most_trials((0.1, 10.0)) == 10


def test_a_motion_ends_when_the_slowest_oscillator_has_decayed():
    pulse = np.zeros(6000)
    pulse[100] = 1.0
    motion = GroundMotion(motion_id="m", dt_s=0.01, accel_1_mps2=pulse, accel_2_mps2=pulse)
    assert intensity.shaken_s(motion, 1.0, None) == motion.duration_s
    for ratio in (0.5, 0.25):
        # after a pulse, exp(-0.05 (2 pi / 3 s) t) of the peak in the first quarter of a period
        decayed_s = 1.0 + 0.75 + math.log(1.0 / ratio) / (0.05 * 2.0 * math.pi / 3.0)
        assert decayed_s - 1.5 < intensity.shaken_s(motion, 1.0, ratio) <= decayed_s


def test_cut_and_trimmed_motions_keep_the_strongest_window_and_the_spectrum_and_end_at_rest():
    scenario = Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
    motion = synthesize(scenario, index=0, seed=2023)
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
    cuts = [intensity.cut_to_strongest(motion, shaking_s, 0.0) for shaking_s in (20.0, 5.0)]
    whole, most, part = (intensity.pair_arias_build_up(each)[-1] for each in (motion, *cuts))
    assert most > 0.95 * whole
    assert part < 0.9 * whole
    done = intensity.strongest_part(motion, 10.0)
    assert done.sha256 != motion.sha256
    assert "of the Arias intensity kept" in done.messages[-1]
    assert done.duration_s == pytest.approx(10.0, abs=0.011)
    periods_s = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
    both = (motion, intensity.trim_quiet_ends(motion))
    before, after = (pair_psa(*each.components, each.dt_s, periods_s).rotd50_mps2 for each in both)
    ratios = after / before
    # the displacement left at the new end is taken off: felt at 2 and 3 s only
    np.testing.assert_allclose(ratios[:-2], 1.0, atol=0.002)
    np.testing.assert_allclose(ratios[-2:], 1.0, atol=0.02)
    assert intensity.trim_quiet_ends(motion).duration_s < 0.8 * motion.duration_s
