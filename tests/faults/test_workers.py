"""Workers that die or hang, and journals: a study continues and reports."""

import errno
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import psutil
import pytest

from fake_work import searched, signalled, slow
from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import LEVEL_MEASURE, MotionsConfig
from skewbridge.study.batch import Workers, run_tasks, search_limits
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import forget, open_journal, read_content
from skewbridge.study.processes import PARENT_VARIABLE
from skewbridge.study.task import run_key
from small_study import wait_for
from study_parts import task_of, wave

STILL_S = 2.0
DIED, STILL = "two worker processes died in this analysis", "no progress for 2 s"
signals = partial(signalled, first=None)
CHILD = (
    "import os, time; from skewbridge.study.processes import end_with_parent;"
    "end_with_parent(); print(os.getpid(), flush=True); time.sleep(60)"
)
PARENT = "import subprocess, sys; subprocess.run([sys.executable, '-c', sys.argv[1]])"
ROWS = [
    {"run_key": "a", "variant": "w", "status": "ok", "column_shear_kn": 1234.5, "cpu_s": math.nan},
    {"run_key": "b", "variant": "v", "status": "crash", "column_shear_kn": 5.0, "cpu_s": 0.1},
]


def task(number):
    return task_of(wave(f"pulse{number}", duration_s=0.6, number=number))


def batch(folder, work, count=2, tasks=(), *, done=None, still_s=STILL_S, on_finished=id):
    """Rows of five analyses, or of the tasks, which are those of the journal."""
    path = folder / "v.jsonl"
    keyed = {run_key(each): each for each in tasks or map(task, range(1, 6))}
    given = {"log_folder": folder, "on_finished": on_finished, "search": work}
    workers = Workers(count=count, no_progress_s=still_s)
    with open_journal(path) as journal:
        by_key = run_tasks(keyed, journal, done or {}, workers=workers, **given)
    rows = [row for key in keyed for row in by_key[key]]
    written = read_content([path, *folder.glob("*_searches.jsonl")]).rows
    assert all(row["status"] == written[row["run_key"]]["status"] for row in rows)
    return rows


@pytest.mark.parametrize(
    ("work", "count", "reason"),
    [
        # with one worker, which is not the process that asks for it, and with two
        (partial(signals, sent=signal.SIGKILL), 1, DIED),
        (partial(signals, sent=signal.SIGSEGV), 2, DIED),
        (partial(signals, sent=signal.SIGSTOP), 2, STILL),
    ],
)
def test_an_analysis_that_ends_two_workers_or_stops_one_is_a_crash(work, count, reason, tmp_path):
    rows = batch(tmp_path, partial(work, motion_id="pulse3"), count)
    assert [row["status"] for row in rows] == ["ok", "ok", "crash", "ok", "ok"]
    assert rows[2]["collapse_criterion"] == reason
    assert not [each for each in psutil.Process().children() if each.status() == "stopped"]


def test_progress_or_a_worker_killed_once_cost_nothing_and_an_absurd_motion_has_a_reason(tmp_path):
    (row,) = batch(tmp_path, None, 1, [task_of(replace(wave(), scale=1e6))])
    assert row["status"] == "invalid_input"
    assert "peak acceleration" in row["collapse_criterion"]
    once = partial(signalled, motion_id="pulse3", sent=signal.SIGKILL, first=tmp_path / "first")
    for work, tasks in ((partial(slow, seconds=1.5 * STILL_S), [task(1), task(2)]), (once, ())):
        assert {row["status"] for row in batch(tmp_path, work, 2, tasks)} == {"ok"}


@pytest.mark.parametrize("code", [errno.EROFS, errno.EACCES, errno.ENOSPC, errno.ENOENT])
def test_missing_semaphores_are_named_and_finished_rows_need_none(tmp_path, monkeypatch, code):
    (row,) = batch(tmp_path, None, 1, [task(1)])
    # what the library asks of the system for the locks of its queues
    refuse = Mock(side_effect=OSError(code, os.strerror(code)))
    monkeypatch.setattr("joblib.externals.loky.backend.synchronize._SemLock", refuse)
    text = rf"cannot start worker processes: .* /dev/shm: {os.strerror(code)}; make /dev/shm"
    with pytest.raises(InputError, match=text):
        batch(tmp_path, None, 1, [task(2)])
    assert batch(tmp_path, None, 1, [task(1)], done={row["run_key"]: row}) == [row]


def test_an_unfinished_search_resumes_from_its_journal(tmp_path):
    at_1_g = task(1).motion.measures[LEVEL_MEASURE]
    levels_g = (0.5 * at_1_g, 1.5 * at_1_g)
    ida = MotionsConfig(ida_demand="deck_disp_m", ida_threshold=1.0, level_range_g=levels_g)
    factor = math.sqrt(math.prod(search_limits(ida, task(1).motion)))
    measures = scaled_measures(task(1).motion.measures, factor)
    first = replace(task(1), motion=replace(task(1).motion, scale=factor, measures=measures))
    own, trials = tmp_path / "v.jsonl", tmp_path / "v_searches.jsonl"

    def run():
        """Keys of the search, and how many analyses it took."""
        done, new = read_content([own, trials]).rows, []
        work = partial(searched, ida, done, trials)
        given = {"done": done, "on_finished": new.append, "still_s": 600.0}
        return [row["run_key"] for row in batch(tmp_path, work, 2, [first], **given)], len(new)

    keys, ran = run()
    assert ran == len(keys) > 5
    assert list(read_content([own]).rows) == keys[:1]
    assert list(read_content([trials]).rows) == keys[1:]
    own.unlink()  # as after a kill in the midst of it
    assert run() == (keys, 1)


def test_a_worker_ends_with_its_parent_even_when_stopped_and_at_once_without_one():
    gone = (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    for stopped in (False, True):
        parent = subprocess.Popen([sys.executable, "-c", PARENT, CHILD], stdout=subprocess.PIPE)
        worker = int(parent.stdout.readline())
        if stopped:
            os.kill(worker, signal.SIGSTOP)
        parent.kill()
        parent.wait()
        assert wait_for(lambda pid=worker: not psutil.pid_exists(pid)
                        or psutil.Process(pid).status() in gone, 30)  # fmt: skip
    late = "from skewbridge.study import processes; processes.end_with_parent()"
    for parent, code in ((os.getpid(), 0), (1, 3)):
        environment = {**os.environ, PARENT_VARIABLE: str(parent)}
        done = subprocess.run([sys.executable, "-c", late], env=environment, check=False)
        assert done.returncode == code


def test_a_successor_waits_for_its_predecessor_and_missing_locks_are_named(tmp_path, monkeypatch):
    """As on a cluster, where a job comes back while another node still runs it."""
    path = tmp_path / "v.jsonl"

    def succeed():
        with open_journal(path, 60.0) as journal:
            journal.append({"run_key": "a"})

    with ThreadPoolExecutor() as other:
        with open_journal(path):
            second = other.submit(succeed)
            for wait_s in (0.1, 0.6):
                with pytest.raises(TimeoutError):
                    second.result(timeout=wait_s)
                # reading the file in the same process frees no lock
                assert read_content([path]).rows == {}
        second.result(timeout=60.0)
    assert set(read_content([path]).rows) == {"a"}
    no_locks = Mock(side_effect=OSError(errno.ENOLCK, "No locks available"))
    monkeypatch.setattr("fcntl.flock", no_locks)
    message = r"cannot be locked \(No locks available\): .*NFSv4"
    with pytest.raises(InputError, match=message), open_journal(tmp_path / "v.jsonl", 60.0):
        pass


def written(path, rows):
    with open_journal(path) as journal:
        list(map(journal.append, rows))
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
        assert content.counts["damaged"] == (not complete and bool(whole[first:end].strip()))
        written(journal, [{"run_key": "c", "status": "ok"}])
        assert "c" in read_content([journal]).rows


def test_no_altered_byte_puts_another_row_into_the_study_and_garbage_is_passed_over(journal):
    whole = written(journal, ROWS)
    expected = as_text(read_content([journal]).rows)
    for place in range(len(whole)):
        for value in (0x0A, 0x31, 0xFF, whole[place] ^ 1):
            journal.write_bytes(whole[:place] + bytes([value]) + whole[place + 1 :])
            content = read_content([journal])
            found = as_text(content.rows)
            assert found.items() <= expected.items()
            assert len(found) == 2 or content.counts["damaged"]
    journal.unlink()
    first = written(journal, ROWS[:1])
    for garbage in (b"\xff\xfe\x80", b"[" * 20000, b"\x00" * 4096, b'{"run_key": "x"', b"7"):
        journal.write_bytes(first + garbage + b"\n")
        written(journal, ROWS[1:])
        content = read_content([journal])
        assert (set(content.rows), content.counts["damaged"]) == ({"a", "b"}, 1)
        assert "1 line(s) cut short or altered" in content.sentences[0]


def test_failed_analyses_are_forgotten_with_their_tables_and_other_lines_are_kept(journal):
    written(journal, [*ROWS, {**ROWS[1], "column_shear_kn": 6.0}])
    journal.write_bytes(journal.read_bytes() + b"\xff\n")
    folder = StudyFolder(journal.parents[1])
    before = read_content([journal])
    assert forget(folder, ("timeout",)) == []
    after = read_content([journal])
    assert (before.counts["damaged"], after.counts["damaged"]) == (1, 0)
    assert journal.read_bytes().count(b"\n") == len(after.rows)
    assert as_text(after.rows) == as_text(before.rows)
    assert after.rows["b"]["column_shear_kn"] == 6.0
    journal.unlink()
    written(journal, ROWS)
    stays, *gone = map(folder.variant_demands, "wv")
    gone += [folder.report, folder.demands, folder.round_demands(2, "v")]
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


def test_a_full_disk_leaves_the_journal_as_it_was_and_read_only_results_are_one_sentence(journal):
    before = written(journal, ROWS[:1])
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    # a size that files cannot exceed cuts a write like a disk that becomes full
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 20, hard))
    try:
        with pytest.raises(InputError, match=r"write the journal .*: File too large; its finished"):
            written(journal, ROWS[1:])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert journal.read_bytes() == before
    # whoever runs the test: root gives up its rights for a while
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "results"
        folder.mkdir(0o555)
        folder.parent.chmod(0o555)
        os.seteuid(user or 65534)
        try:
            with pytest.raises(InputError, match=r"write to the folder .* Permission denied"):
                writable_folder(folder)
            with pytest.raises(InputError, match=r"cannot write the journal .* Permission denied"):
                open_journal(folder / "v.jsonl").__enter__()
        finally:
            os.seteuid(user)
            folder.parent.chmod(0o755)
