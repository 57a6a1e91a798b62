"""Broken motion files: each gets its verdict, and none gets past the reader by accident."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bad_motion_files import MOTION_FILES
from motions_files import at2_text, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions.check import check_paths
from skewbridge.motions.read import DT_LIMITS_S, PGA_LIMITS_G, read_trace
from skewbridge.motions.trace import Given
from skewbridge.units import G_MPS2


@pytest.fixture(scope="module")
def bad_folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("badinput")
    for name, (content, _) in MOTION_FILES.items():
        (path / name).write_bytes(content)
    return path


@pytest.mark.parametrize("together", ["folder", "files"])
def test_every_bad_file_gets_its_expected_verdict(bad_folder, together):
    paths = [bad_folder] if together == "folder" else [bad_folder / name for name in MOTION_FILES]
    found = {Path(item.file).name: item.verdict for item in check_paths(paths)}
    assert found == {name: verdict for name, (_, verdict) in MOTION_FILES.items()}


def test_component_with_another_dt_is_found_in_either_order(bad_folder):
    pair = [bad_folder / "50_pair_len_h1.AT2", bad_folder / "52_pair_dt_h2.AT2"]
    for paths in (pair, pair[::-1]):
        verdicts = {Path(item.file).name[:2]: item.verdict for item in check_paths(paths)}
        assert verdicts == {"50": "ok", "52": "pair_error"}


def test_strict_reading_refuses_what_is_only_doubtful(bad_folder):
    path = bad_folder / "20_npts_too_big.AT2"
    assert check_paths([path], strict=True)[0].verdict == "error"
    with pytest.raises(InputError, match="500"):
        read_trace(path, strict=True)


AT2 = at2_text(shaken_g(1, 60))
LINES = AT2.splitlines()
KNET = """Origin Time       2000/01/01 00:00:00
Lat.              38.920
Long.             140.630
Depth. (km)       7
Mag.              5.9
Station Code      ABC001
Station Lat.      39.6069
Station Long.     140.3213
Station Height(m) 34
Record Time       2000/01/01 00:00:10
Sampling Freq(Hz) 100Hz
Duration Time(s)  1
Dir.              E-W
Scale Factor      2000(gal)/8388608
Max. Acc. (gal)   100.0
Last Correction   2000/01/01 00:00:00
Memo.
""" + "\n".join(
    " ".join(f"{round(v * 1e6) + 5000:8d}" for v in shaken_g(2, 64)[i : i + 8])
    for i in range(0, 64, 8)
)
V2 = "\n".join(
    ["CORRECTED ACCELEROGRAM   TEST       CHAN  1: 090", *["text"] * 24, *["    0    1"] * 20]
    + ["   64 POINTS OF ACCEL DATA EQUALLY SPACED AT  .010 SEC.  (UNITS: CM/SEC/SEC)"]
    + ["".join(f"{v * 981:10.3f}" for v in shaken_g(3, 64)[i : i + 8]) for i in range(0, 64, 8)]
)
TWO = "time (s),acceleration (g)\n" + "\n".join(
    f"{i * 0.01:.2f},{v:.6e}" for i, v in enumerate(shaken_g(4, 60))
)
THREE = "time,h1,h2\n" + "\n".join(
    f"{i * 0.01:.2f} {v:.6e} {0.5 * v:.6e}" for i, v in enumerate(shaken_g(6, 60))
)
VALUES = "\n".join(f"{v:.6e}" for v in shaken_g(5, 60))
BASES = {"a.AT2": AT2, "b.EW": KNET, "c.V2": V2, "d.csv": TWO, "e.acc": VALUES, "f.txt": THREE}

NASTY = [
    "NaN", "inf", "-Infinity", "*******", "1e999", "1D5", "1d-400", "1,5", "--", "+-1", "..", "E",
    "0x10", "1_000", "٣", "\x00", "\ufeff", "9" * 500, "1" * 5000 + "x", " " * 999, "\n" * 50,
    "NPTS=", "NPTS= 99999999999999999999, DT= 1e-300 SEC", "DT= 0.0", "DT= -1", "DT= 1E400 SEC",
    "UNITS OF CM/SEC2", "VELOCITY", "points of accel data equally spaced at 0 sec",
    "Scale Factor      0(gal)/0", "Sampling Freq(Hz) 1e400Hz", "Scale Factor 1e300(gal)/1e-300",
    "<html>", "PK\x03\x04", "version https://git-lfs", "1e308", "-1e308", "1e-320", "0", "\t", "\r",
]  # fmt: skip

EDIT = st.tuples(
    st.sampled_from(["insert", "delete", "replace", "cut", "double", "swap", "noise"]),
    st.integers(0, 10**6),
    st.integers(1, 80),
    st.sampled_from(NASTY),
    st.binary(min_size=1, max_size=6),
)


def _edited(content: bytes, edits: list) -> bytes:
    for kind, where, size, token, noise in edits:
        at = where % (len(content) + 1)
        text = token.encode("utf-8", "surrogatepass")
        if kind == "insert":
            content = content[:at] + text + content[at:]
        elif kind == "replace":
            content = content[:at] + text + content[at + len(text) :]
        elif kind == "delete":
            content = content[:at] + content[at + size :]
        elif kind == "cut":
            content = content[:at]
        elif kind == "double":
            content = content[:at] + content[max(at - size, 0) :]
        elif kind == "swap":
            lines = content.split(b"\n")
            i, j = where % len(lines), size % len(lines)
            lines[i], lines[j] = lines[j], lines[i]
            content = b"\n".join(lines)
        else:
            content = content[:at] + noise + content[at:]
    return content


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


def test_unbroken_bases_are_read(folder):
    for name, text in BASES.items():
        (folder / name).write_bytes(text.encode())
        known = Given(
            dt_s=0.01 if name == "e.acc" else None, channel=2 if name == "f.txt" else None
        )
        trace = read_trace(folder / name, known)
        assert trace.accel_mps2.size in {60, 64}


# 2500 files; an example that takes 10 s counts as a hang (they take a millisecond)
@settings(
    max_examples=2500,
    deadline=10_000,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    name=st.sampled_from(sorted(BASES)),
    edits=st.lists(EDIT, min_size=1, max_size=4),
    dt_s=st.sampled_from([None, 0.01]),
    channel=st.sampled_from([None, 1, 2]),
)
def test_mutated_files_end_in_a_sane_record_or_in_our_error(folder, name, edits, dt_s, channel):
    path = folder / name
    path.write_bytes(_edited(BASES[name].encode(), edits))
    try:
        trace = read_trace(path, Given(dt_s=dt_s, channel=channel))
    except InputError:
        return
    assert np.isfinite(trace.accel_mps2).all()
    assert DT_LIMITS_S[0] <= trace.dt_s <= DT_LIMITS_S[1]
    assert 0.0 < np.abs(trace.accel_mps2).max() <= PGA_LIMITS_G[1] * G_MPS2
    assert trace.unit in {"g", "cm/s2", "m/s2"}


@pytest.mark.parametrize(
    "text",
    ["1" * 3_000_000 + "x", " " * 3_000_000 + "NPTS", "NPTS= 1" + " " * 3_000_000, "-" * 10**6],
    ids=["digits", "blanks", "blanks after NPTS", "signs"],
)  # fmt: skip
def test_very_long_lines_do_not_hang(tmp_path, text):
    for name in ("long.AT2", "long.txt", "long.V2"):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError):
            read_trace(tmp_path / name, Given(dt_s=0.01))


def test_unreadable_paths_are_input_errors(tmp_path):
    with pytest.raises(InputError, match="no_such"):
        read_trace(tmp_path / "no_such.AT2")
    with pytest.raises(InputError):
        read_trace(tmp_path)
