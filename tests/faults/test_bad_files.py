"""Files that are too large, too deep, cut or altered: refused in one sentence that names them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mutation import BOMB
from skewbridge.bridge.catalogue import load_bridge_file
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame, read_table, stamp, write_frame
from skewbridge.files.text import read_csv, read_json, read_yaml
from skewbridge.fragility.fit_data import read_data
from skewbridge.motions.folder import list_motions
from skewbridge.motions.read import read_trace


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a: 1\nb: \xff\n", "line 2: byte 0xff is not UTF-8"),
        (b"a: 1\nb: 2\na: 3\n", "line 1: the key 'a' appears twice, in lines 1 and 3"),
        (b"[" * 100_000, "nested more than 30 levels"),
        (BOMB.encode(), "more than 20000 values"),
        (b"a: &a [*a]\n", "nested more than 30 levels"),
        (b"a: " + b"9" * 5000, "at most 30 digits"),
        (b"a: 0x" + b"f" * 5000, "at most 30 digits"),
        (b"1: a\n", "a key must be text"),
        (b"? [a]\n: b\n", "a key must be text"),
        (b"a: !!python/name:os.system x\n", "tags such as"),
        (b"a: !!timestamp 2020-13-45\n", "tags such as"),
        (b"x" * 300_000, "at most 200000 are read"),
        (b"a: [1\n", "not valid YAML"),
    ],
)
def test_document_over_the_limits_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "file.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_yaml(path)
    assert "file.yaml" in str(caught.value)
    assert words in str(caught.value)


def test_aliases_are_expanded_and_dates_are_text(tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_text("a: &a {x: 1}\nb: {<<: *a, y: 2}\nc: *a\nd: 2020-01-31\n", encoding="utf-8")
    assert read_yaml(path) == {
        "a": {"x": 1},
        "b": {"x": 1, "y": 2},
        "c": {"x": 1},
        "d": "2020-01-31",
    }


@pytest.mark.parametrize(
    ("read", "text", "words"),
    [
        (read_json, '{"a": ' * 100_000, "nested too deeply"),
        (read_json, '{"a": 1, "a": 2}', "'a' appears twice"),
        (read_json, '{"a": ' + "9" * 5000 + "}", "at most 30 digits"),
        (read_json, "{", "line 1, column 2"),
        (read_csv, "a,b\n1,2\n3\n", "line 3 has 1 cells, the header 2"),
        (read_csv, "a,b\n1,2,3\n", "line 2 has 3 cells"),
        (read_csv, "a,a\n1,2\n", "'a' appears twice"),
        (read_csv, "", "it is empty"),
        (read_csv, 'a,b\n"1,2\n', "not a table"),
    ],
)
def test_json_over_the_limits_and_ragged_tables_are_refused(
    tmp_path: Path, read: Callable[[Path], object], text: str, words: str
) -> None:
    path = tmp_path / "file"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read(path)


@pytest.mark.parametrize("name", ["x" * 100_000, "a/" * 3000, "nul\0", "no/such/file", ""])
def test_absurd_file_name_is_refused(name: str) -> None:
    for read in (read_yaml, read_table, read_trace, load_bridge_file, read_data, list_motions):
        with pytest.raises(InputError) as caught:
            read(Path(f"{name}.yaml"))
        assert len(str(caught.value)) < 300


@pytest.mark.parametrize("marked", [False, True])
def test_damaged_table_is_never_read_as_another(tmp_path: Path, *, marked: bool) -> None:
    """Pages carry checksums: a flipped byte changes no number in silence."""
    path = tmp_path / "t.parquet"
    table = pd.DataFrame({"a": np.linspace(0.0, 1.0, 50), "b": [f"text {i}" for i in range(50)]})
    write_frame(table, path, {"made_by": "tests"})
    if marked:
        stamp(path, {"rule": "fit_fragility"})
    content = path.read_bytes()
    for place in range(0, len(content), 7):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x10]) + content[place + 1 :])
        try:
            found = read_frame(path)
        except InputError:
            continue
        shared = [name for name in ("a", "b") if name in found]
        pd.testing.assert_frame_equal(found[shared], table[shared], check_dtype=False)
    for length in range(0, len(content), 97):
        path.write_bytes(content[:length])
        with pytest.raises(InputError, match=r"t\.parquet"):
            read_frame(path)
