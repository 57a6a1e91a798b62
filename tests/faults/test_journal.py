"""A journal survives kills and two writers."""

import errno
import math
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest

from skewbridge.errors import InputError
from skewbridge.study.journal import open_journal, read_content


def test_a_line_cut_by_a_kill_costs_only_itself(tmp_path: Path) -> None:
    path = tmp_path / "v.jsonl"
    with open_journal(path) as journal:
        journal.append({"run_key": "a", "value": 1.5})
    path.write_text(path.read_text() + '{"run_key": "b", "val')
    with open_journal(path) as journal:
        journal.append({"run_key": "c", "value": math.nan})
    rows = read_content([path]).rows
    assert set(rows) == {"a", "c"}
    assert rows["a"]["value"] == 1.5
    assert math.isnan(rows["c"]["value"])


def test_a_second_writer_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "v.jsonl"
    with (
        open_journal(path),
        pytest.raises(InputError, match="being written by another process"),
        open_journal(path),
    ):
        pass


def test_an_empty_study_has_an_empty_journal(tmp_path: Path) -> None:
    assert read_content([tmp_path / "none.jsonl"]).rows == {}


def test_a_successor_waits_for_the_end_of_its_predecessor(tmp_path: Path) -> None:
    """As on a cluster, where a job comes back while another node still runs it."""
    path = tmp_path / "v.jsonl"

    def succeed() -> None:
        with open_journal(path, 60.0) as journal:
            journal.append({"run_key": "a"})

    first = ExitStack()
    first.enter_context(open_journal(path))
    with ThreadPoolExecutor() as other:
        second = other.submit(succeed)
        with pytest.raises(TimeoutError):
            second.result(timeout=0.1)
        assert read_content([path]).rows == {}  # reading the file in the same process frees no lock
        with pytest.raises(TimeoutError):
            second.result(timeout=0.6)
        first.close()
        second.result(timeout=60.0)
    assert set(read_content([path]).rows) == {"a"}


def test_a_file_system_without_locks_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_locks(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    with (
        pytest.raises(InputError, match=r"cannot be locked \(No locks available\): .*NFSv4"),
        open_journal(tmp_path / "v.jsonl", 60.0),
    ):
        pass
