"""The analyses of one variant, in parallel, each finished one written to the journal at once."""

import logging
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, Final

from joblib import Parallel, delayed

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.demands.columns import key_values
from skewbridge.demands.demand_columns import DEMAND_COLUMNS, INTENSITY_COLUMNS
from skewbridge.study.journal import JournalWriter
from skewbridge.study.keys import run_key
from skewbridge.study.orphans import end_with
from skewbridge.study.task import Task, analyse_task, no_result

logger = logging.getLogger(__name__)

type Row = dict[str, Any]
_WITHOUT_RESULT: Final = ("invalid_input", "crash")
_NO_DEMANDS: Final = {column.name: math.nan for column in DEMAND_COLUMNS}

#: Makes the rows of a task: (task, its key, folder of the solver's messages, owner's pid).
type Work = Callable[[Task, str, Path, int], list[Row]]


def run_tasks(
    tasks: Sequence[Task],
    journal: JournalWriter,
    done: Mapping[str, Row],
    *,
    n_jobs: int,
    log_folder: Path,
    on_finished: Callable[[Row], None],
    work: Work | None = None,
) -> list[Row]:
    """Run what the journal does not have, and return the rows of all tasks in their order.

    A worker that dies (a fault inside the solver) costs its own analysis only: it is tried once
    more alone and then recorded with status ``crash``.

    Args:
        tasks: What the variant needs.
        journal: Open journal of the variant.
        done: Rows that the journal has already, by `run_key`.
        n_jobs: Worker processes.
        log_folder: Where each analysis leaves the solver's messages.
        on_finished: Called with each new row.
        work: What to do with each task, whatever the journal has (it may give several rows, a
            search for example); by default the one analysis that it describes, if it is new.
    """
    keys = [run_key(task) for task in tasks]
    rows: dict[int, list[Row]] = {}
    if work is None:
        rows = {
            number: [of_task(done[key], tasks[number], key)]
            for number, key in enumerate(keys)
            if key in done
        }

    work = work or _one_analysis

    def finish(number: int, found: list[Row]) -> None:
        rows[number] = found
        for row in found:
            if row["run_key"] not in done:
                journal.append(row)
                on_finished(row)

    while pending := [
        (number, task, key)
        for number, (task, key) in enumerate(zip(tasks, keys, strict=True))
        if number not in rows
    ]:
        try:
            for number, found in _stream(pending, n_jobs, log_folder, work):
                finish(number, found)
        except BrokenProcessPool:
            left = [each for each in pending if each[0] not in rows][: n_jobs + 1]
            logger.warning("a worker died; the %d analyses under way run alone", len(left))
            for number, task, key in left:
                finish(number, _alone(task, key, log_folder, work))
    return [row for number in range(len(tasks)) for row in rows[number]]


def analysed_row(task: Task, key: str, log_folder: Path, owner_pid: int) -> Row:
    """Run one analysis in this process and return its row of the demands table.

    Args:
        task: The analysis.
        key: Its `run_key`; it is the caller's, whose sources may be older than this process.
        log_folder: Where the solver's messages go, in a file named after motion and key.
        owner_pid: The process that the result is for; when it ends, so does this one.
    """
    hush_exit_message()
    end_with(owner_pid)
    log_folder.mkdir(parents=True, exist_ok=True)
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    outcome = analyse_task(task, log_folder / f"{task.motion.motion.motion_id}_{key}.log")
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    if outcome["status"] in _WITHOUT_RESULT:
        outcome = {**_NO_DEMANDS, **outcome}
    return of_task({**outcome, **times}, task, key)


def of_task(row: Row, task: Task, key: str) -> Row:
    """Return a row as that of a task: which analysis it is, is told by the task alone."""
    return {**row, **identity_of(task, key)}


def identity_of(task: Task, key: str) -> Row:
    """Return the columns of a row that say which analysis it is, with its `run_key`."""
    motion = task.motion
    return {
        **key_values(task.variant, motion.motion.motion_id, motion.scale, task.incidence_deg),
        **{column.name: motion.measures[column.name] for column in INTENSITY_COLUMNS},
        "run_key": key,
    }


def _one_analysis(task: Task, key: str, log_folder: Path, owner_pid: int) -> list[Row]:
    return [analysed_row(task, key, log_folder, owner_pid)]


def _numbered(
    work: Work, number: int, task: Task, key: str, log_folder: Path, owner_pid: int
) -> tuple[int, list[Row]]:
    return number, work(task, key, log_folder, owner_pid)


def _stream(
    pending: Sequence[tuple[int, Task, str]], n_jobs: int, log_folder: Path, work: Work
) -> Iterator[tuple[int, list[Row]]]:
    parallel = Parallel(n_jobs=n_jobs, backend="loky", return_as="generator_unordered")
    yield from parallel(
        delayed(_numbered)(work, number, task, key, log_folder / task.variant.slug, os.getpid())
        for number, task, key in pending
    )


def _alone(task: Task, key: str, log_folder: Path, work: Work) -> list[Row]:
    try:
        # Two workers for one task: with one, joblib would run it in this process.
        return next(_stream([(0, task, key)], 2, log_folder, work))[1]
    except BrokenProcessPool:
        crash = no_result("crash", "the worker process died")
        times = {"wall_s": math.nan, "cpu_s": math.nan}
        return [of_task({**_NO_DEMANDS, **crash, **times}, task, key)]
