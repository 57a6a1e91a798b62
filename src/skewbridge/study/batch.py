"""Analyses and IDA searches in worker processes; rows are written to journals immediately.

A worker process imports this module, which therefore imports neither pandas nor pyarrow.
"""

import logging
import math
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from math import isclose
from pathlib import Path
from typing import Any, Final

from skewbridge.demands import validity
from skewbridge.demands.columns import DEMAND_COLUMNS, EVENT, INTENSITY_COLUMNS, SUITE, key_values
from skewbridge.errors import InputError
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import LEVEL_MEASURE, MotionsConfig, bracket_capacity
from skewbridge.motions.record import SuiteMotion
from skewbridge.study import processes
from skewbridge.study.journal import JournalWriter, Row, open_journal
from skewbridge.study.task import Task, analyse_task, no_result, run_key
from skewbridge.variant.random_properties import draw_columns

logger = logging.getLogger(__name__)

#: Function of a task, its key and the folder for solver messages; returns the rows of the task.
type Work = Callable[[Task, str, Path], list[Row]]

_NO_DEMANDS: Final = {column.name: math.nan for column in DEMAND_COLUMNS}


# ---- Rows of the demands table, made in a worker


def restart_alarm(*_: object) -> None:
    """Restart the timer (if any) that ends a worker by SIGALRM after some time without a step."""
    limit_s = signal.getitimer(signal.ITIMER_REAL)[1]
    signal.setitimer(signal.ITIMER_REAL, limit_s, limit_s)


def analysed_row(task: Task, key: str, log_folder: Path) -> Row:
    """Run one analysis in this process; ``key`` comes from the parent process."""
    log_folder.mkdir(parents=True, exist_ok=True)
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    log = log_folder / f"{task.motion.motion.motion_id}_{key}.log"
    outcome = analyse_task(task, log, restart_alarm)
    if log.is_file() and log.stat().st_size == 0:  # OpenSees wrote no message
        log.unlink()
    if outcome["status"] in ("invalid_input", "crash"):
        outcome = _NO_DEMANDS | outcome
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    return row_of_task(outcome | times, task, key)


def row_of_task(row: Row, task: Task, key: str) -> Row:
    """Return a row with columns added that identify its analysis or are derived from it."""
    motion, failure = task.motion, row.get(validity.BEYOND_MODEL) or ""
    return {
        **row,
        validity.COMPLETE: bool(validity.completed(row["status"], failure)),
        **key_values(task.variant, motion.motion.motion_id, motion.scale, task.incidence_deg),
        SUITE: motion.suite,
        EVENT: "" if "synthetic" in motion.motion.source else motion.motion.event,
        **draw_columns(task.draw),
        **{column.name: motion.measures[column.name] for column in INTENSITY_COLUMNS},
        "run_key": key,
    }


def _guarded(
    work: Work | None, log_folder: Path, no_progress_s: float, task: Task, key: str
) -> list[Row]:
    """Return the rows of a task; the worker that runs it ends with its parent or when it hangs."""
    processes.hush_exit_message()
    processes.end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C
    signal.setitimer(signal.ITIMER_REAL, no_progress_s, no_progress_s)
    try:
        return work(task, key, log_folder) if work else [analysed_row(task, key, log_folder)]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


# ---- Incremental dynamic analysis: a search for the capacity of each motion


def search_limits(ida: MotionsConfig, motion: SuiteMotion) -> tuple[float, float]:
    """Return the scale factors of a motion at the lowest and highest level of a search."""
    at_1_g = motion.measures[LEVEL_MEASURE] / motion.scale
    low_g, high_g = ida.level_range_g
    return low_g / at_1_g, high_g / at_1_g


def search_capacity(
    ida: MotionsConfig,
    done: Mapping[str, Row],
    journal: Path,
    task: Task,
    first_key: str,
    log_folder: Path,
) -> list[Row]:
    """Return the rows of all analyses that bracket the capacity of one motion.

    Analyses in `done` (by `run_key`) are not repeated. New rows are written to the journal, except
    the row of the first task, which the caller writes to mark the search as done. A failed or
    incomplete analysis counts as an exceedance.
    """
    rows: list[Row] = []

    def exceeds(factor: float) -> bool:
        # rounding of the first factor must not change the key of the first analysis
        is_first = isclose(factor, task.motion.scale, rel_tol=1e-12)
        trial = task if is_first else at_factor(task, factor)
        key = run_key(trial)
        if key in done:
            row = row_of_task(done[key], trial, key)
        else:
            row = analysed_row(trial, key, log_folder)
            if key != first_key:
                with open_journal(journal, patience_s=60.0) as writer:  # other searches write to it
                    writer.append(row)
        rows.append(row)
        return not row[validity.COMPLETE] or row[ida.ida_demand] >= ida.ida_threshold

    bracket_capacity(exceeds, limits=search_limits(ida, task.motion))
    return rows


def at_factor(task: Task, factor: float) -> Task:
    """Return a copy of a task with a different scale factor of its motion."""
    motion = task.motion
    measures = scaled_measures(motion.measures, factor / motion.scale)
    return replace(task, motion=replace(motion, scale=factor, measures=measures))


# ---- The pool


@dataclass(frozen=True, slots=True)
class Workers:
    """Number of worker processes, and the time without a step after which a worker is ended."""

    count: int = 1
    no_progress_s: float = 120.0


def run_tasks(
    tasks: Mapping[str, Task],  # by `run_key`, in the order in which to start them
    journal: JournalWriter,  # for the new rows
    done: Mapping[str, Row],  # rows already in the journals, by `run_key`
    *,
    workers: Workers,
    log_folder: Path,  # for the messages of the solver
    on_finished: Callable[[Row], None],  # called with each new row
    search: Work | None = None,  # IDA search of a task; None: one analysis per task
) -> dict[str, list[Row]]:
    """Run the tasks without a row in the journals; return the rows of each task (dict by key).

    An analysis whose worker dies or hangs is repeated by itself; a second time it is a ``crash``.
    With ``search``, all tasks run; a search skips the analyses that are in the journals.
    """
    rows = {key: [done[key]] for key in tasks if key in done and search is None}
    if len(rows) == len(tasks):
        return rows
    work = partial(_guarded, search, log_folder, workers.no_progress_s)

    def keep(key: str, rows_of_task: list[Row]) -> None:
        rows[key] = rows_of_task
        for row in rows_of_task:
            if row["run_key"] in done:
                continue
            if row["run_key"] == key:  # a search has already written the rows that it added
                journal.append(row)
            on_finished(row)

    def run(keys: Sequence[str], count: int) -> None:
        for key, rows_of_task in in_workers(work, {key: tasks[key] for key in keys}, count):
            keep(key, rows_of_task)

    def run_alone(key: str) -> None:
        """Run a task that may have ended a worker; record a crash if it ends a second worker."""
        ended_before = len(ended)
        try:
            run([key], 1)
        except BrokenProcessPool as error:
            is_hung = len(ended) > ended_before or signal.SIGALRM.name in str(error)
            crash_text = "two worker processes died in this analysis"
            reason = f"no progress for {workers.no_progress_s:g} s" if is_hung else crash_text
            row = _NO_DEMANDS | no_result("crash", reason) | {"wall_s": math.nan, "cpu_s": math.nan}
            keep(key, [row_of_task(row, tasks[key], key)])

    with processes.stopped_workers_ended(workers.no_progress_s) as ended:
        try:
            while pending := [key for key in tasks if key not in rows]:
                try:
                    run(pending, workers.count)
                except BrokenProcessPool:
                    # Workers take tasks in order: the first tasks without rows were in progress.
                    unfinished = [key for key in pending if key not in rows][: workers.count + 1]
                    text = "a worker died: the %d analyses in progress are repeated one at a time"
                    logger.warning(text, len(unfinished))
                    for key in unfinished:
                        run_alone(key)
        finally:
            # by force: a worker that is stopped or hangs would never end
            _executor(reuse=True).shutdown(kill_workers=True)
    return rows


def in_workers(
    work: Callable[[Task, str], list[Row]], tasks: Mapping[str, Task], count: int
) -> Iterator[tuple[str, list[Row]]]:
    """Yield rows and keys of finished tasks; raise `BrokenProcessPool` if a worker died."""
    # one thread in each worker: more threads would compete with the other workers
    env = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    executor = _executor(
        max_workers=min(count, len(tasks)),
        env=env | {processes.PARENT_VARIABLE: str(os.getpid())},
        initializer=processes.end_with_parent,
    )
    keys = {executor.submit(work, task, key): key for key, task in tasks.items()}
    for future in as_completed(keys):
        yield keys[future], future.result()


def _executor(**options: Any) -> Any:
    """Return the pool of worker processes; its semaphores are files in shared memory."""
    loky = import_module("joblib.externals.loky")  # by name, because it is untyped
    try:
        return loky.get_reusable_executor(**options)
    except OSError as error:
        problem = f"no semaphore can be created in shared memory, /dev/shm: {error.strerror}"
        remedy = "make /dev/shm writable and run the same command again"
        raise InputError(f"cannot start worker processes: {problem}; {remedy}") from None
