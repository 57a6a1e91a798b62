"""An index that came with someone's motions is not trusted."""

import os

import numpy as np
import pytest

from motions_files import at2_text, index_of, make_pairs, shaken_g
from skewbridge.errors import InputError
from skewbridge.motions.check import check_paths
from skewbridge.motions.read import SURROGATE_FACTOR, SURROGATE_FILES, read_motion
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.motions.suite import prepare_suite
from skewbridge.units import G_MPS2
from skewbridge.verification.studies.paper_runs import waho


@pytest.fixture
def indexed(tmp_path):
    folder = tmp_path / "motions"
    folder.mkdir()
    pairs = make_pairs(folder, 2)
    (tmp_path / "secret_h1.AT2").write_text(at2_text(shaken_g(5)))
    return folder, index_of(folder, pairs)


@pytest.mark.parametrize(
    "name",
    [
        "../secret_h1.AT2",
        "sub/../../secret_h1.AT2",
        "{outside}",
        "C:/secret_h1.AT2",
        "..\\secret_h1.AT2",
        "\\\\server\\share\\x.AT2",
        "~/x.AT2",
        "",
    ],
)
def test_paths_out_of_the_folder_are_refused(indexed, name):
    folder, index = indexed
    name = name.format(outside=folder.parent / "secret_h1.AT2")
    index.write_text(index.read_text().replace("q1_h1.AT2", name))
    with pytest.raises(InputError, match="line 3"):
        prepare_suite(folder, t1_s=0.7)


@pytest.mark.parametrize("name", ["../up", "x" * 9000])
def test_names_of_motions_that_lead_out_of_the_folder_are_refused(indexed, name):
    folder, index = indexed
    index.write_text(index.read_text().replace("q1,", f"{name},"))
    with pytest.raises(InputError, match="line 3"):
        prepare_suite(folder, t1_s=0.7)


def test_links_out_of_the_folder_are_refused(indexed):
    folder, index = indexed
    (folder / "link.AT2").symlink_to(folder.parent / "secret_h1.AT2")
    index.write_text(index.read_text().replace("q1_h1.AT2", "link.AT2"))
    with pytest.raises(InputError, match="leads out"):
        prepare_suite(folder, t1_s=0.7)


def test_missing_file_is_named(indexed):
    folder, _ = indexed
    (folder / "q1_h2.AT2").unlink()
    with pytest.raises(InputError, match=r"q1_h2\.AT2.* missing"):
        prepare_suite(folder, t1_s=0.7)


def test_changed_file_is_detected_by_its_digest(tmp_path):
    pairs = make_pairs(tmp_path, 1)
    index_of(tmp_path, pairs, sha256=["0" * 64])
    with pytest.raises(InputError, match=r"q0_h1\.AT2.*sha256"):
        prepare_suite(tmp_path, t1_s=0.7)


def test_nan_in_a_record_is_named_with_its_line(tmp_path):
    (first, _), *_ = make_pairs(tmp_path, 1)
    lines = first.read_text().splitlines()
    lines[6] = lines[6][:30] + "            NaN" + lines[6][45:]
    first.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"q0_h1\.AT2, line 7: 'NaN'"):
        prepare_suite(tmp_path, t1_s=0.7)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("file_2", "fil_2"), "column"),
        (("q1,", "q0,"), "twice"),
    ],
)
def test_broken_index_is_refused(indexed, change, message):
    folder, index = indexed
    index.write_text(index.read_text().replace(*change))
    with pytest.raises(InputError, match=message):
        prepare_suite(folder, t1_s=0.7)


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("scale", -1), ("scale", "x"), ("scale", "inf"), ("dt_s", 0), ("unit", "furlong"),
        ("magnitude", "big"),
    ],
)  # fmt: skip
def test_bad_number_in_the_index_is_refused_by_name(tmp_path, column, value):
    index_of(tmp_path, make_pairs(tmp_path, 1), **{column: [value]})
    with pytest.raises(InputError, match=column):
        prepare_suite(tmp_path, t1_s=0.7)


def test_waho_with_the_published_peak_is_accepted(tmp_path):
    # one direction only: RotD50 is the peak over sqrt 2
    values = shaken_g(1)
    values *= 0.5373 * np.sqrt(2.0) / np.abs(values).max()
    (tmp_path / "RSN811_LOMAP_WAH000.AT2").write_text(at2_text(values))
    (tmp_path / "RSN811_LOMAP_WAH090.AT2").write_text(at2_text(1e-6 * values))
    assert prepare_suite(tmp_path, t1_s=0.7)["motion_id"][0] == "RSN811_LOMAP_WAH"


def test_false_waho_is_replaced_by_the_named_surrogate(tmp_path, monkeypatch):
    folder = tmp_path / "surrogate"
    folder.mkdir()
    stand_in_g = shaken_g(1), shaken_g(2)
    for name, values in zip(SURROGATE_FILES, stand_in_g, strict=True):
        rows = (f"{0.01 * i:.4f} {value:.8e}" for i, value in enumerate(values))
        (folder / name).write_text("\n".join(rows))
    false = tmp_path / "false"
    false.mkdir()
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
