"""Workers that die or hang, and the lock of a tree: the study continues and reports them."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import psutil
import pytest

from fake_work import hanging, searched, signalled, slow
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import LEVEL_MEASURE
from skewbridge.study.batch import Search, Workers, run_tasks
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.processes import PARENT_VARIABLE, worker_processes
from study_parts import task_of, wave

STILL_S = 2.0


def task(number):
    return task_of(wave(f"pulse{number}", duration_s=0.6, number=number))


def batch(folder, work, count=2, tasks=(), **options):
    """Rows of five analyses, or of the tasks, which are those of the journal."""
    path = folder / "v.jsonl"
    with open_journal(path) as journal:
        rows = run_tasks(
            tasks or [task(number) for number in range(1, 6)],
            journal,
            options.get("done", {}),
            workers=Workers(count=count, no_progress_s=options.get("still_s", STILL_S)),
            log_folder=folder,
            on_finished=options.get("on_finished", lambda _row: None),
            search=work,
        )
    written = read_content([path, *folder.glob("*_searches.jsonl")]).rows
    assert {row["run_key"]: row["status"] for row in rows}.items() <= {
        key: row["status"] for key, row in written.items()
    }.items()
    return rows


def ends(pid):
    """Whether a process ends, waited for."""
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        if not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.parametrize(("sent", "count"), [(signal.SIGKILL, 1), (signal.SIGSEGV, 2)])
def test_an_analysis_that_ends_two_workers_is_a_crash(sent, count, tmp_path):
    """With one worker, which is not the process that asks for it, and with two."""
    rows = batch(tmp_path, partial(signalled, motion_id="pulse3", sent=sent, first=None), count)
    assert [row["status"] for row in rows] == ["ok", "ok", "crash", "ok", "ok"]
    assert rows[2]["collapse_criterion"] == "two worker processes died in this analysis"


def test_a_motion_with_an_absurd_value_is_a_row_with_a_reason(tmp_path):
    (row,) = batch(tmp_path, None, 1, [task_of(replace(wave(), scale=1e6))])
    assert row["status"] == "invalid_input"
    assert "peak acceleration" in row["collapse_criterion"]


def test_a_worker_that_is_killed_once_costs_nothing(tmp_path):
    once = partial(signalled, motion_id="pulse3", sent=signal.SIGKILL, first=tmp_path / "first")
    assert {row["status"] for row in batch(tmp_path, once)} == {"ok"}


@pytest.mark.parametrize(
    "work", [partial(signalled, sent=signal.SIGSTOP, first=None), hanging], ids=["stopped", "hangs"]
)
def test_a_worker_without_progress_is_ended_and_its_analysis_recorded(work, tmp_path):
    """Stopped, or in a loop of compiled code that runs no Python and takes no step."""
    rows = batch(tmp_path, partial(work, motion_id="pulse3"))
    assert [row["status"] for row in rows] == ["ok", "ok", "crash", "ok", "ok"]
    assert rows[2]["collapse_criterion"] == "no progress for 2 s"
    stopped = [each for each in psutil.Process().children() if each.status() == "stopped"]
    assert not stopped


def test_an_unfinished_search_resumes_from_its_journal(tmp_path):
    at_1_g = task(1).motion.measures[LEVEL_MEASURE]
    search = Search(demand="deck_disp_m", threshold=1.0, low_g=0.5 * at_1_g, high_g=1.5 * at_1_g)
    factor = search.first_factor(task(1).motion)
    measures = scaled_measures(task(1).motion.measures, factor)
    first = replace(task(1), motion=replace(task(1).motion, scale=factor, measures=measures))
    own, trials = tmp_path / "v.jsonl", tmp_path / "v_searches.jsonl"

    def run():
        """Keys of the search, and how many analyses it took."""
        done, new = read_content([own, trials]).rows, []
        work = partial(searched, search, done, trials)
        given = {"done": done, "on_finished": new.append, "still_s": 600.0}
        rows = batch(tmp_path, work, 2, [first], **given)
        return [row["run_key"] for row in rows], len(new)

    keys, ran = run()
    assert ran == len(keys) > 5
    assert list(read_content([own]).rows) == keys[:1]
    assert list(read_content([trials]).rows) == keys[1:]
    own.unlink()  # as after a kill in the midst of it
    assert run() == (keys, 1)


CHILD = (
    "import os, time; from skewbridge.study.processes import end_with_parent;"
    "end_with_parent(); print(os.getpid(), flush=True); time.sleep(60)"
)
PARENT = "import subprocess, sys; subprocess.run([sys.executable, '-c', sys.argv[1]])"


@pytest.mark.parametrize("stopped", [False, True])
def test_a_worker_ends_with_its_parent_even_when_stopped(stopped):
    parent = subprocess.Popen([sys.executable, "-c", PARENT, CHILD], stdout=subprocess.PIPE)
    worker = int(parent.stdout.readline())
    if stopped:
        os.kill(worker, signal.SIGSTOP)
    parent.kill()
    parent.wait()
    assert ends(worker)


def test_a_process_without_its_parent_ends_at_once():
    late = "from skewbridge.study import processes; processes.end_with_parent()"
    for parent, code in ((os.getpid(), 0), (1, 3)):
        environment = {**os.environ, PARENT_VARIABLE: str(parent)}
        done = subprocess.run([sys.executable, "-c", late], env=environment, check=False)
        assert done.returncode == code


PARENT_OF_A_POOL = """
import sys
from functools import partial
from pathlib import Path
from fake_work import slow
from test_workers import batch
batch(Path(sys.argv[1]), partial(slow, seconds=300.0))
"""


def test_a_worker_ends_whose_parent_is_killed_during_its_start(tmp_path):
    """The parent is killed as soon as it has a worker, which has loaded nothing yet."""
    folders = os.pathsep.join([str(Path(__file__).parent), str(Path(__file__).parents[1])])
    parent = psutil.Popen(
        [sys.executable, "-c", PARENT_OF_A_POOL, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": folders},
    )
    workers = []
    while not workers:
        assert parent.poll() is None
        workers = [child for child in parent.children() if "popen_loky" in "".join(child.cmdline())]
    parent.kill()
    parent.wait()
    assert all(ends(worker.pid) for worker in workers)


def test_an_analysis_that_makes_progress_is_not_ended(tmp_path):
    rows = batch(tmp_path, partial(slow, seconds=1.5 * STILL_S))
    assert {row["status"] for row in rows} == {"ok"}


def test_only_workers_count_as_such_where_none_of_them_begins():
    """Those that were stopped before they began have no sign of life; other children are let be."""
    names = ("popen_loky_posix", "something_else")
    children = [
        subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()", name], stdin=-1)
        for name in names
    ]
    try:
        assert children[0].pid in {each.pid for each in worker_processes()}
        assert children[1].pid not in {each.pid for each in worker_processes()}
    finally:
        for child in children:
            child.communicate()


HOLD = (
    "import sys, time; from pathlib import Path;"
    "from skewbridge.errors import InputError; from skewbridge.study.processes import hold_tree\n"
    "try:\n    hold_tree(Path(sys.argv[1]))\n"
    "except InputError as error:\n    sys.exit(str(error))\n"
    "print('held', flush=True); sys.stdin.read()"
)


def holder(folder):
    return subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_the_lock_ends_with_its_process(tmp_path):
    folder = tmp_path / ".snakemake"
    first = holder(folder)
    assert first.stdout.readline() == "held\n"
    second = holder(folder)
    _, printed = second.communicate()
    assert second.returncode == 1
    assert f"another study is running in {tmp_path} (process {first.pid})" in printed
    assert "Traceback" not in printed
    first.kill()
    first.wait()
    third = holder(folder)
    assert third.stdout.readline() == "held\n"
    third.communicate()
