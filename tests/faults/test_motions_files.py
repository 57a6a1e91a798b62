"""Broken motion files: the verdict of each (random changes: `test_mutated_inputs`)."""

from pathlib import Path

import pytest

from bad_motion_files import MOTION_FILES
from skewbridge.errors import InputError
from skewbridge.motions.check import check_paths
from skewbridge.motions.formats import Given
from skewbridge.motions.read import read_trace


@pytest.fixture(scope="module")
def bad_folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("badinput")
    for name, (content, _) in MOTION_FILES.items():
        (path / name).write_bytes(content)
    return path


@pytest.mark.parametrize("together", ["folder", "files"])
def test_each_file_gets_its_expected_verdict(bad_folder, together):
    paths = [bad_folder] if together == "folder" else [bad_folder / name for name in MOTION_FILES]
    found = {Path(item.file).name: item.verdict for item in check_paths(paths)}
    assert found == {name: verdict for name, (_, verdict) in MOTION_FILES.items()}


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
