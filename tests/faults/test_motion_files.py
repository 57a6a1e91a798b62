"""Broken motion files and an index that is not trusted (random changes: `test_bad_files`)."""

import os
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from motions_files import at2_text, index_of, make_pairs, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions import check, formats, intensity, levels, suite
from skewbridge.motions.read import SURROGATE_FACTOR, SURROGATE_FILES, read_motion, read_trace
from skewbridge.study import analyses, inputs, task
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.units import G_MPS2
from skewbridge.verification.studies.paper_runs import waho

DT_S = 0.02
RECORD_G = shaken_g(0, 400)
GOOD = at2_text(RECORD_G, DT_S)
HEAD = "".join(GOOD.splitlines(keepends=True)[:4])


def columns(dt_s, decimals):
    rows = enumerate(RECORD_G)
    return "".join(f"{i * dt_s + 1e-9:.{decimals}f} {value:.6e}\n" for i, value in rows)


def changed(old, new):
    assert old in GOOD
    return GOOD.replace(old, new, 1)


def replaced_value(token):
    """Return the good file with another text in the columns of its eighth value."""
    start = len(HEAD) + 76 + 30
    return GOOD[:start] + token.rjust(15) + GOOD[start + 15 :]


FILES = {
    "00_good.AT2": (GOOD, "ok"),
    "01_crlf.AT2": (GOOD.replace("\n", "\r\n"), "ok"),
    "02_blank_tail.AT2": (GOOD + "\n  \n\n", "ok"),
    # A download that broke off between two lines.
    "20_npts_too_big.AT2": (changed("NPTS=    400", "NPTS=    500"), "warn"),
    # One that broke off within a number.
    "22_truncated_token.AT2": (GOOD[:-33], "error"), "23_nan.AT2": (replaced_value("NaN"), "error"),
    # Fortran writes stars where a number does not fit its columns.
    "24_stars.AT2": (replaced_value("*" * 14), "error"),
    "27_header_only.AT2": (HEAD, "error"),
    "29_dt_zero.AT2": (changed("DT= 0.0200", "DT= 0.0000"), "error"),
    "30_cms2_said_g.AT2": (at2_text(980.665 * RECORD_G, DT_S), "error"),
    # Values cannot show that m/s2 was labelled g: 1.5 g is a strong record.
    "32_ms2_said_g_small.AT2": (at2_text(5.0 * RECORD_G, DT_S), "ok"),
    "33_spike.AT2": (replaced_value("3.0"), "warn"),
    "34_offset.AT2": (at2_text(RECORD_G + 0.05, DT_S), "warn"),
    "35_html.AT2": ("<!DOCTYPE html><html><body>Please sign in</body></html>\n", "error"),
    "38_bom.AT2": ("\ufeff" + GOOD, "ok"),
    "39_all_zero.AT2": (at2_text(np.zeros(400), DT_S), "error"),
    # Components of different length are a pair, of different time step they are none.
    "50_pair_len_h1.AT2": (GOOD, "ok"),
    "51_pair_len_h2.AT2": (at2_text(RECORD_G[:398], DT_S), "ok"),
    "52_pair_dt_h2.AT2": (at2_text(RECORD_G, 0.01), "pair_error"),
    "60_two_col.txt": (columns(0.02, 4), "ok"),
    "59_spectrum.csv": ("Period,PSA\n" + columns(0.02, 4), "error"),
    "58_blank.ASC": ("\ufeff \n", "error"),
    # A time column with three decimals cannot show a step of 0.0025 s.
    "61_two_col_rounded_time.txt": (columns(0.0025, 3), "warn"),
    "63_one_col.txt": ("".join(f"{value:.6e}\n" for value in RECORD_G), "needs_dt"),
    "64_opensees.acc": (" ".join(f"{value:.6e}" for value in RECORD_G), "needs_dt"),
}  # fmt: skip


def test_each_file_gets_its_expected_verdict(tmp_path):
    for name, (text, _) in FILES.items():
        (tmp_path / name).write_bytes(text.encode())
    for paths in ([tmp_path], [tmp_path / name for name in FILES]):
        found = {Path(item.file).name: item.verdict for item in check.check_paths(paths)}
        assert found == {name: verdict for name, (_, verdict) in FILES.items()}


def test_very_long_lines_are_refused_quickly_and_unreadable_paths_are_input_errors(tmp_path):
    long = " " * 3_000_000
    texts = ("1" * 3_000_000 + "x", f"{long}NPTS", f"NPTS= 1{long}", "-" * 10**6)
    for name, text in product(("long.AT2", "long.txt", "long.V2"), texts):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError):
            read_trace(tmp_path / name, formats.Stated(dt_s=0.01))
    (tmp_path / "nan.AT2").write_text(FILES["23_nan.AT2"][0])
    for name, message in (("no_such.AT2", "no_such"), (".", "."), ("nan.AT2", "line 6: 'NaN'")):
        with pytest.raises(InputError, match=message):
            read_trace(tmp_path / name)


def test_a_bad_index_is_refused_by_line_and_name(tmp_path, monkeypatch):
    (folder := tmp_path / "motions").mkdir()
    pairs = make_pairs(folder, 2)
    index = index_of(folder, pairs)
    good, secret = index.read_text(), tmp_path / "secret_h1.AT2"
    secret.write_text(at2_text(shaken_g(5)))
    (folder / "link.AT2").symlink_to(secret)

    def refuse(message, old="", new="", folder=folder):
        if old:
            index.write_text(good.replace(old, new))
        with pytest.raises(InputError, match=message):
            suite.prepare_suite(folder, t1_s=0.7)

    for name in (
        "../secret_h1.AT2", "sub/../../secret_h1.AT2", "C:/secret_h1.AT2", "..\\secret_h1.AT2",
        "\\\\server\\share\\x.AT2", "~/x.AT2", "", str(secret),
    ):  # fmt: skip
        refuse("line 3", "q1_h1.AT2", name)
    refuse("line 3", "q1,", "../up,")
    refuse("line 3", "q1,", f"{'x' * 9000},")
    refuse("twice", "q1,", "q0,")
    refuse("column", "file_2", "fil_2")
    for name in ("units", "dt", "scale_factor", "Scale", "channel1"):
        index_of(folder, pairs, **{name: [1.0] * 2})
        refuse(f"unknown column '{name}'.*scale, unit")
    refuse("is outside", "q1_h1.AT2", "link.AT2")
    # an absolute path would not serve where the folder is copied to
    monkeypatch.chdir(tmp_path)
    refuse(r"line 3.*is outside", "q1_h1", f"{folder}/q1_h1", Path(folder.name))
    scales = (("scale", value) for value in (-1, "x", "inf"))
    for column, value in (*scales, ("dt_s", 0), ("unit", "furlong"), ("magnitude", "big")):
        index_of(folder, pairs, **{column: [value] * 2})
        refuse(rf"index\.csv, line 2: .*{column}")
    # the digest of a file that was changed, and a missing file
    index_of(folder, pairs, sha256=["0" * 64] * 2)
    refuse(r"q0_h1\.AT2.*sha256")
    (folder / "q0_h2.AT2").unlink()
    refuse(r"q0_h2\.AT2.* does not exist", "q0,", "q0,")


def test_waho_of_the_published_peak_is_accepted_and_a_false_one_replaced(tmp_path, monkeypatch):
    # one direction only: RotD50 is the peak over sqrt 2
    values = shaken_g(1)
    values *= 0.5373 * np.sqrt(2.0) / np.abs(values).max()
    (tmp_path / "RSN811_LOMAP_WAH000.AT2").write_text(at2_text(values))
    (tmp_path / "RSN811_LOMAP_WAH090.AT2").write_text(at2_text(1e-6 * values))
    assert suite.prepare_suite(tmp_path, t1_s=0.7)["motion_id"][0] == "RSN811_LOMAP_WAH"
    (folder := tmp_path / "surrogate").mkdir()
    (false := tmp_path / "false").mkdir()
    stand_in_g = shaken_g(1), shaken_g(2)
    for name, values in zip(SURROGATE_FILES, stand_in_g, strict=True):
        rows = (f"{0.01 * i:.4f} {value:.8e}" for i, value in enumerate(values))
        (folder / name).write_text("\n".join(rows))
    for azimuth in (0, 90):
        text = at2_text(shaken_g(azimuth), azimuth=azimuth)
        (false / f"RSN811_LOMAP_WAH{azimuth:03d}.AT2").write_text(text)
    with pytest.raises(InputError, match="claims to be the WAHO"):
        read_motion(*sorted(false.glob("*.AT2")))
    assert {item.verdict for item in check.check_paths([false])} == {"error"}
    monkeypatch.setenv("SKEWBRIDGE_RECORDS", f"{false}{os.pathsep}{folder}")
    used = waho()
    assert not used.is_paper_record
    assert all("surrogate" in text for text in (used.label, used.motion.motion_id))
    pga_g = intensity.orbit_rotd50(used.motion.accel_1_mps2, used.motion.accel_2_mps2) / G_MPS2
    assert pga_g == pytest.approx(SURROGATE_FACTOR * intensity.orbit_rotd50(*stand_in_g), rel=1e-3)


def test_a_motion_removed_while_it_is_listed_or_later_is_named(tmp_path, monkeypatch):
    """Analyses read the prepared motions; the next start of the study names the missing file."""
    motions, folder = tmp_path / "motions", StudyFolder(tmp_path / "results")
    motions.mkdir()
    make_pairs(motions, 3)
    given = levels.MotionsConfig(folder=str(motions), count=None)
    config = StudyConfig(results=str(folder.root), motions=given)
    component, listed = motions / "q1_h2.AT2", suite.files_below
    text = component.read_text()

    def keys():
        tasks = analyses.StudySetup.of(config).tasks("osb1_cf_skew30_gap051_mu050")
        return [task.run_key(each) for each in tasks]

    def digest(_config):
        return inputs.motions_digest(config, folder.motions_digest)

    def and_removed(where):
        found = listed(where)
        component.unlink()
        return found

    with monkeypatch.context() as patch:
        patch.setattr(suite, "files_below", and_removed)
        with pytest.raises(InputError, match=r"q1_h2\.AT2 cannot be read: No such file"):
            digest(config)
    assert not folder.motions_digest.exists()
    component.write_text(text)
    inputs.prepare_motions(config)
    digest(config)
    before, keys_before = folder.suite.read_bytes(), keys()
    component.unlink()
    component.with_name("q9_h1.AT2").write_text(text)
    message = r"^2 faults:\n  motion q1 has 1 component file\(s\) \(q1_h1.AT2\) [^\n]*\n  motion q9"
    for step in (inputs.prepare_motions, digest):
        with pytest.raises(InputError, match=message):
            step(config)
    assert keys() == keys_before
    assert folder.suite.read_bytes() == before
    assert [path.name for path in folder.suite.parent.glob(".*")] == []
