"""Broken motion files and an index that is not trusted (random changes: `test_mutated_inputs`)."""

import os
from pathlib import Path

import numpy as np
import pytest

from motions_files import at2_text, index_of, make_pairs, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions import suite
from skewbridge.motions.check import check_paths
from skewbridge.motions.formats import Given
from skewbridge.motions.levels import MotionsConfig
from skewbridge.motions.read import SURROGATE_FACTOR, SURROGATE_FILES, read_motion, read_trace
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.motions.suite import prepare_suite
from skewbridge.study.analyses import StudySetup
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import motions_digest, prepare_motions
from skewbridge.study.task import run_key
from skewbridge.units import G_MPS2
from skewbridge.verification.studies.paper_runs import waho

# --- one file with one quirk, and its verdict

DT_S = 0.02
RECORD_G = shaken_g(0, 400)
GOOD = at2_text(RECORD_G, DT_S)
HEAD, VALUES = "".join(GOOD.splitlines(keepends=True)[:4]), GOOD.split("SEC\n")[1]


def columns(dt_s, decimals):
    """Return time and acceleration in two columns."""
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
    "03_no_final_newline.AT2": (GOOD.rstrip("\n"), "ok"),
    # A download that broke off between two lines.
    "20_npts_too_big.AT2": (changed("NPTS=    400", "NPTS=    500"), "warn"),
    # One that broke off within a number.
    "22_truncated_token.AT2": (GOOD[:-33], "error"),
    "23_nan.AT2": (replaced_value("NaN"), "error"),
    # Fortran writes stars where a number does not fit its columns.
    "24_stars.AT2": (replaced_value("*" * 14), "error"),
    "26_empty.AT2": ("", "error"),
    "27_header_only.AT2": (HEAD, "error"),
    "29_dt_zero.AT2": (changed("DT= 0.0200", "DT= 0.0000"), "error"),
    "30_cms2_said_g.AT2": (at2_text(980.665 * RECORD_G, DT_S), "error"),
    # Values cannot show that m/s2 was labelled g: 1.5 g is a strong record.
    "32_ms2_said_g_small.AT2": (at2_text(5.0 * RECORD_G, DT_S), "ok"),
    "33_vt2.VT2": (
        changed("ACCELERATION TIME SERIES IN UNITS OF G", "VELOCITY TIME SERIES IN UNITS OF CM/S"),
        "error",
    ),
    "34_offset.AT2": (at2_text(RECORD_G + 0.05, DT_S), "warn"),
    "35_html.AT2": ("<!DOCTYPE html><html><body>Please sign in</body></html>\n", "error"),
    "37_zip.AT2": ("PK\x03\x04\x14\x00\x00\x00", "error"),
    "38_bom_utf8.AT2": ("\ufeff" + GOOD, "ok"),
    "39_all_zero.AT2": (at2_text(np.zeros(400), DT_S), "error"),
    # Components of different length are a pair, of different time step they are none.
    "50_pair_len_h1.AT2": (GOOD, "ok"),
    "51_pair_len_h2.AT2": (at2_text(RECORD_G[:398], DT_S), "ok"),
    "52_pair_dt_h2.AT2": (at2_text(RECORD_G, 0.01), "pair_error"),
    "60_two_col.txt": (columns(0.02, 4), "ok"),
    # A time column with three decimals cannot show a step of 0.0025 s.
    "61_two_col_rounded_time.txt": (columns(0.0025, 3), "warn"),
    "63_one_col.txt": ("".join(f"{value:.6e}\n" for value in RECORD_G), "needs_dt"),
    "64_opensees.acc": (" ".join(f"{value:.6e}" for value in RECORD_G), "needs_dt"),
}


@pytest.mark.parametrize("together", ["folder", "files"])
def test_each_file_gets_its_expected_verdict(tmp_path, together):
    for name, (text, _) in FILES.items():
        (tmp_path / name).write_bytes(text.encode())
    paths = [tmp_path] if together == "folder" else [tmp_path / name for name in FILES]
    found = {Path(item.file).name: item.verdict for item in check_paths(paths)}
    assert found == {name: verdict for name, (_, verdict) in FILES.items()}


@pytest.mark.parametrize(
    "text",
    ["1" * 3_000_000 + "x", " " * 3_000_000 + "NPTS", "NPTS= 1" + " " * 3_000_000, "-" * 10**6],
    ids=["digits", "blanks", "blanks after NPTS", "signs"],
)  # fmt: skip
def test_very_long_lines_are_refused_quickly(tmp_path, text):
    for name in ("long.AT2", "long.txt", "long.V2"):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError):
            read_trace(tmp_path / name, Given(dt_s=0.01))


def test_unreadable_paths_are_input_errors(tmp_path):
    with pytest.raises(InputError, match="no_such"):
        read_trace(tmp_path / "no_such.AT2")
    with pytest.raises(InputError):
        read_trace(tmp_path)


# --- an index that came with someone's motions


@pytest.fixture
def refuse(tmp_path):
    """Return a function that changes an index of two motions, which then must be refused."""
    folder = tmp_path / "motions"
    folder.mkdir()
    index = index_of(folder, make_pairs(folder, 2))
    (tmp_path / "secret_h1.AT2").write_text(at2_text(shaken_g(5)))

    def check(message, old="", new=""):
        index.write_text(index.read_text().replace(old, new) if old else index.read_text())
        with pytest.raises(InputError, match=message):
            prepare_suite(folder, t1_s=0.7)

    check.folder = folder
    return check


@pytest.mark.parametrize(
    "name",
    [
        "../secret_h1.AT2", "sub/../../secret_h1.AT2", "{outside}", "C:/secret_h1.AT2",
        "..\\secret_h1.AT2", "\\\\server\\share\\x.AT2", "~/x.AT2", "",
    ],
)  # fmt: skip
def test_paths_out_of_the_folder_are_refused(refuse, name):
    outside = refuse.folder.parent / "secret_h1.AT2"
    refuse("line 3", "q1_h1.AT2", name.format(outside=outside))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("q1,", "../up,"), "line 3"),
        (("q1,", f"{'x' * 9000},"), "line 3"),
        (("q1,", "q0,"), "twice"),
        (("file_2", "fil_2"), "column"),
    ],
    ids=["folder in a name", "long name", "name twice", "no column"],
)
def test_bad_names_in_the_index_are_refused(refuse, change, message):
    refuse(message, *change)


def test_an_absolute_path_is_refused_in_a_folder_given_by_a_relative_one(refuse, monkeypatch):
    """Such an index would not serve where the folder is copied to."""
    monkeypatch.chdir(refuse.folder.parent)
    refuse.folder.joinpath("index.csv").write_text(
        (refuse.folder / "index.csv").read_text().replace("q1_h1", f"{refuse.folder}/q1_h1")
    )
    with pytest.raises(InputError, match=r"line 3.*leads out"):
        prepare_suite(Path(refuse.folder.name), t1_s=0.7)


def test_links_out_of_the_folder_and_missing_files_are_refused(refuse):
    (refuse.folder / "link.AT2").symlink_to(refuse.folder.parent / "secret_h1.AT2")
    refuse("leads out", "q1_h1.AT2", "link.AT2")
    (refuse.folder / "q0_h2.AT2").unlink()
    refuse(r"q0_h2\.AT2.* missing")


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("scale", -1), ("scale", "x"), ("scale", "inf"), ("dt_s", 0), ("unit", "furlong"),
        ("magnitude", "big"), ("sha256", "0" * 64),
    ],
)  # fmt: skip
def test_bad_value_in_the_index_is_refused_by_name(tmp_path, column, value):
    """A digest is wrong where the file was changed."""
    index_of(tmp_path, make_pairs(tmp_path, 1), **{column: [value]})
    file = r"q0_h1\.AT2.*" if column == "sha256" else ""
    with pytest.raises(InputError, match=file + column):
        prepare_suite(tmp_path, t1_s=0.7)


def test_nan_in_a_record_is_named_with_its_line(tmp_path):
    (first, _), *_ = make_pairs(tmp_path, 1)
    lines = first.read_text().splitlines()
    lines[6] = lines[6][:30] + "            NaN" + lines[6][45:]
    first.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"q0_h1\.AT2, line 7: 'NaN'"):
        prepare_suite(tmp_path, t1_s=0.7)


def test_waho_with_the_published_peak_is_accepted(tmp_path):
    # one direction only: RotD50 is the peak over sqrt 2
    values = shaken_g(1)
    values *= 0.5373 * np.sqrt(2.0) / np.abs(values).max()
    (tmp_path / "RSN811_LOMAP_WAH000.AT2").write_text(at2_text(values))
    (tmp_path / "RSN811_LOMAP_WAH090.AT2").write_text(at2_text(1e-6 * values))
    assert prepare_suite(tmp_path, t1_s=0.7)["motion_id"][0] == "RSN811_LOMAP_WAH"


def test_false_waho_is_replaced_by_the_named_surrogate(tmp_path, monkeypatch):
    folder, false = tmp_path / "surrogate", tmp_path / "false"
    folder.mkdir()
    false.mkdir()
    stand_in_g = shaken_g(1), shaken_g(2)
    for name, values in zip(SURROGATE_FILES, stand_in_g, strict=True):
        rows = (f"{0.01 * i:.4f} {value:.8e}" for i, value in enumerate(values))
        (folder / name).write_text("\n".join(rows))
    for azimuth in (0, 90):
        text = at2_text(shaken_g(azimuth), azimuth=azimuth)
        (false / f"RSN811_LOMAP_WAH{azimuth:03d}.AT2").write_text(text)
    with pytest.raises(InputError, match="claims to be the WAHO"):
        read_motion(*sorted(false.glob("*.AT2")))
    assert {item.verdict for item in check_paths([false])} == {"error"}
    monkeypatch.setenv("SKEWBRIDGE_RECORDS", f"{false}{os.pathsep}{folder}")
    used = waho()
    assert not used.is_paper_record
    assert "surrogate" in used.label
    assert "surrogate" in used.motion.motion_id
    pga_g = orbit_rotd50(used.motion.accel_1_mps2, used.motion.accel_2_mps2) / G_MPS2
    assert pga_g == pytest.approx(SURROGATE_FACTOR * orbit_rotd50(*stand_in_g), rel=1e-3)


# --- a file removed while a study runs: one message, no partial or lost results


class Study:
    """A study of three motions, and its steps."""

    def __init__(self, tmp_path):
        self.motions = tmp_path / "motions"
        self.motions.mkdir()
        make_pairs(self.motions, 3)
        motions = MotionsConfig(folder=str(self.motions), count=None)
        self.config = StudyConfig(results=str(tmp_path / "results"), motions=motions)
        self.folder = StudyFolder(tmp_path / "results")

    def remove(self):
        """Remove a component of the second motion."""
        (self.motions / "q1_h2.AT2").unlink()

    def prepare(self):
        prepare_motions(self.config)

    def digest(self):
        return motions_digest(self.config, self.folder.motions_digest)

    def keys(self):
        tasks = StudySetup.of(self.config).tasks("osb1_cf_skew30_gap051_mu050")
        return [run_key(each) for each in tasks]


@pytest.fixture
def study(tmp_path):
    return Study(tmp_path)


def test_motion_removed_between_check_and_reading_is_named(study):
    """Analyses read the prepared motions; the next start of the study names the missing file."""
    study.prepare()
    study.digest()
    before, keys = study.folder.suite.read_bytes(), study.keys()
    study.remove()
    message = r"^motion q1: 1 component file\(s\) found \(q1_h1.AT2\), 2 needed[^\n]*$"
    for step in (study.prepare, study.digest):
        with pytest.raises(InputError, match=message):
            step()
    assert study.keys() == keys
    assert study.folder.suite.read_bytes() == before
    assert [path.name for path in study.folder.suite.parent.glob(".*")] == []


def test_motion_removed_while_the_folder_is_listed_is_named(study, monkeypatch):
    listed = suite.files_below

    def and_removed(where):
        found = listed(where)
        study.remove()
        return found

    monkeypatch.setattr(suite, "files_below", and_removed)
    with pytest.raises(InputError, match=r"q1_h2\.AT2 cannot be read: No such file"):
        study.digest()
    assert not study.folder.motions_digest.exists()
