"""A journal survives kills, two writers and damage on the disk: no altered row is used."""

import errno
import json
import math
import os
import resource
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import compact_journals, forget, open_journal, read_content


def test_a_successor_waits_for_the_end_of_its_predecessor(tmp_path):
    """As on a cluster, where a job comes back while another node still runs it."""
    path = tmp_path / "v.jsonl"

    def succeed():
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


def test_a_file_system_without_locks_is_reported(tmp_path, monkeypatch):
    def no_locks(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    with (
        pytest.raises(InputError, match=r"cannot be locked \(No locks available\): .*NFSv4"),
        open_journal(tmp_path / "v.jsonl", 60.0),
    ):
        pass


ROWS = [
    {"run_key": "a", "variant": "w", "status": "ok", "column_shear_kn": 1234.5, "cpu_s": math.nan},
    {"run_key": "b", "variant": "v", "status": "crash", "column_shear_kn": 5.0, "cpu_s": 0.1},
]


def written(path, rows):
    with open_journal(path) as journal:
        for row in rows:
            journal.append(row)
    return path.read_bytes()


def as_text(rows):
    return {key: json.dumps(row) for key, row in rows.items()}


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "results" / "journal" / "v.jsonl"


def test_a_journal_cut_at_any_byte_of_its_last_line_loses_that_line_only(journal):
    first = len(written(journal, ROWS[:1]))
    whole = written(journal, ROWS[1:])
    for end in range(first, len(whole)):
        journal.write_bytes(whole[:end])
        content = read_content([journal])
        complete = whole[first:end].strip() == whole[first:].strip()
        assert set(content.rows) == ({"a", "b"} if complete else {"a"})
        assert content.damaged == (not complete and bool(whole[first:end].strip()))
        written(journal, [{"run_key": "c", "status": "ok"}])
        assert "c" in read_content([journal]).rows


def test_no_altered_byte_puts_another_row_into_the_study(journal):
    whole = written(journal, ROWS)
    expected = as_text(read_content([journal]).rows)
    for place in range(len(whole)):
        for value in (0x0A, 0x31, 0xFF, whole[place] ^ 1):
            journal.write_bytes(whole[:place] + bytes([value]) + whole[place + 1 :])
            content = read_content([journal])
            found = as_text(content.rows)
            assert found.items() <= expected.items()
            assert len(found) == 2 or content.damaged


@pytest.mark.parametrize(
    "garbage",
    [b"\xff\xfe\x80\n", b"[" * 20000 + b"\n", b"\x00" * 4096 + b"\n", b'{"run_key": "x"\n', b"7\n"],
)
def test_garbage_in_the_middle_is_counted_and_passed_over(journal, garbage):
    first = written(journal, ROWS[:1])
    journal.write_bytes(first + garbage)
    written(journal, ROWS[1:])
    content = read_content([journal])
    assert (set(content.rows), content.damaged) == ({"a", "b"}, 1)
    assert "1 line(s) cut short or altered" in content.sentences[0]


def test_compaction_keeps_the_last_line_of_every_key(journal):
    written(journal, [*ROWS, {**ROWS[1], "column_shear_kn": 6.0}])
    journal.write_bytes(journal.read_bytes() + b"\xff\n")
    folder = StudyFolder(journal.parents[1])
    before = compact_journals(folder)
    after = read_content([journal])
    assert (before.repeated, before.damaged) == (1, 1)
    assert (after.repeated, after.damaged) == (0, 0)
    assert as_text(after.rows) == as_text(before.rows)
    assert after.rows["b"]["column_shear_kn"] == 6.0


def test_failed_analyses_are_forgotten_with_the_table_that_shows_them(journal):
    written(journal, ROWS)
    folder = StudyFolder(journal.parents[1])
    stays = folder.variant_demands("w")
    gone = [
        folder.report,
        folder.demands,
        folder.variant_demands("v"),
        folder.round_demands(2, "v"),
    ]
    for path in (stays, *gone):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert forget(folder, ("timeout",)) == []
    assert folder.demands.exists()
    with open_journal(journal), pytest.raises(InputError, match="written by another process"):
        forget(folder, ("crash",))
    assert folder.demands.exists()
    assert [row["run_key"] for row in forget(folder, ("crash",))] == ["b"]
    assert set(read_content([journal]).rows) == {"a"}
    assert [path for path in (stays, *gone) if path.exists()] == [stays]


def test_a_line_that_finds_no_room_leaves_the_journal_as_it_was(journal):
    before = written(journal, ROWS[:1])
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    # a size that files cannot exceed cuts a write like a disk that becomes full
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 20, hard))
    try:
        with pytest.raises(InputError, match=r"cannot write the journal .*: File too large; the"):
            written(journal, ROWS[1:])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert journal.read_bytes() == before


def test_read_only_results_are_one_sentence():
    """Whoever runs the test: root gives up its rights for a while."""
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "results"
        folder.mkdir()
        for each in (folder.parent, folder):
            each.chmod(0o555)
        os.seteuid(user or 65534)
        try:
            with pytest.raises(InputError, match=r"write to the folder .* Permission denied"):
                writable_folder(folder)
            with pytest.raises(InputError, match=r"cannot write the journal .* Permission denied"):
                open_journal(folder / "v.jsonl").__enter__()
        finally:
            os.seteuid(user)
            folder.parent.chmod(0o755)
