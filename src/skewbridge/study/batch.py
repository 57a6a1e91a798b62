"""Analyses and searches of an IDA in worker processes; rows are written to journals at once.

A worker process imports this module and the packages below it: no tables.
"""

import logging
import math
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from importlib import import_module
from math import isclose, sqrt
from pathlib import Path
from typing import Any, Final

from skewbridge.demands.columns import DEMAND_COLUMNS, INTENSITY_COLUMNS, SUITE, key_values
from skewbridge.demands.validity import (
    BEYOND_MODEL,
    COLUMN_FAILURE_RATIO,
    COMPLETE,
    column_failure_ratio,
    completed,
)
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import LEVEL_MEASURE, bracket_capacity
from skewbridge.motions.record import SuiteMotion
from skewbridge.study.journal import JournalWriter, Row, open_journal
from skewbridge.study.processes import (
    PARENT_VARIABLE,
    end_with_parent,
    hush_exit_message,
    stopped_workers_ended,
)
from skewbridge.study.task import Task, analyse_task, no_result, run_key
from skewbridge.variant.random_properties import DRAW_PREFIX

logger = logging.getLogger(__name__)

#: Makes the rows of a task with a key; the folder is for messages of the solver.
type Work = Callable[[Task, str, Path], list[Row]]
#: A task with its number and its key.
type Pending = tuple[int, Task, str]

_NO_DEMANDS: Final = {column.name: math.nan for column in DEMAND_COLUMNS}
#: One thread in each worker: more threads would compete with the other workers.
_ONE_THREAD: Final = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
)


#: Time that a worker waits while other workers write to the journal.
_PATIENCE_S: Final = 60.0


# ---- Rows of the demands table, made in a worker


class Alarm:
    """Ends this process by SIGALRM when it takes no step for some time.

    Time during which the machine sleeps does not count.
    """

    limit_s: float = 0.0

    @classmethod
    def restart(cls, *_: object) -> None:
        """Restart the timer; call this at every step. Without a limit it does nothing."""
        if cls.limit_s:
            signal.setitimer(signal.ITIMER_REAL, cls.limit_s)


def analysed_row(task: Task, key: str, log_folder: Path) -> Row:
    """Run one analysis in this process and return its row of the demands table.

    The parent made the key: its sources may be older than this process.
    """
    log_folder.mkdir(parents=True, exist_ok=True)
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    log = log_folder / f"{task.motion.motion.motion_id}_{key}.log"
    outcome = analyse_task(task, log, Alarm.restart)
    if log.is_file() and log.stat().st_size == 0:  # OpenSees wrote no message
        log.unlink()
    if outcome["status"] in ("invalid_input", "crash"):
        outcome = _NO_DEMANDS | outcome
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    return row_of_task(outcome | times, task, key)


def row_of_task(row: Row, task: Task, key: str) -> Row:
    """Return a row with the columns that identify its analysis and those derived from others."""
    motion = task.motion
    return {
        **row,
        COMPLETE: bool(completed(row["status"], row.get(BEYOND_MODEL) or "")),
        COLUMN_FAILURE_RATIO: float(column_failure_ratio(row)),
        **key_values(task.variant, motion.motion.motion_id, motion.scale, task.incidence_deg),
        SUITE: motion.suite,
        **{f"{DRAW_PREFIX}{name}": value for name, value in task.draw.items()},
        **{column.name: motion.measures[column.name] for column in INTENSITY_COLUMNS},
        "run_key": key,
    }


def _guarded(
    work: Work | None, task: Task, key: str, log_folder: Path, no_progress_s: float
) -> list[Row]:
    """Return the rows of a task in a worker process that ends with its parent or when it hangs."""
    hush_exit_message()
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C
    Alarm.limit_s = no_progress_s
    Alarm.restart()
    try:
        return work(task, key, log_folder) if work else [analysed_row(task, key, log_folder)]
    finally:
        Alarm.limit_s = 0.0
        signal.setitimer(signal.ITIMER_REAL, 0.0)


# ---- Incremental dynamic analysis: a search for the capacity of each motion


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Target of an IDA (demand and its limit) and the range of Sa_avg tried, in g."""

    demand: str
    threshold: float
    low_g: float
    high_g: float

    def limits(self, motion: SuiteMotion) -> tuple[float, float]:
        """Return the factors of the lowest and highest level."""
        at_1_g = motion.measures[LEVEL_MEASURE] / motion.scale
        return self.low_g / at_1_g, self.high_g / at_1_g

    def first_factor(self, motion: SuiteMotion) -> float:
        """Return the first factor of the search."""
        low, high = self.limits(motion)
        return sqrt(low * high)

    def exceeds(self, row: Row) -> bool:
        """Return whether an analysis exceeds the limit; a failed or incomplete one does as well.

        The search then continues at lower levels, where the model is valid.
        """
        is_complete = completed(row["status"], row.get(BEYOND_MODEL) or "")
        return bool(not is_complete or row[self.demand] >= self.threshold)


def search_capacity(
    search: Search,
    done: Mapping[str, Row],
    journal: Path,
    task: Task,
    first_key: str,
    log_folder: Path,
) -> list[Row]:
    """Return the rows of all analyses that bracket the capacity of one motion.

    Those in `done`, by `run_key`, are not repeated. Each further one is written to the journal at
    once, so that a killed search can resume. The batch gives the first task with its key, and
    writes its row, which marks the search as done.
    """
    rows: list[Row] = []

    def exceeds(factor: float) -> bool:
        # rounding in the first factor must not give the first analysis another key
        is_first = isclose(factor, task.motion.scale, rel_tol=1e-12)
        trial = task if is_first else at_factor(task, factor)
        key = run_key(trial)
        if key in done:
            row = row_of_task(done[key], trial, key)
        else:
            row = analysed_row(trial, key, log_folder)
            if key != first_key:
                with open_journal(journal, _PATIENCE_S) as lines:
                    lines.append(row)
        rows.append(row)
        return search.exceeds(row)

    bracket_capacity(exceeds, limits=search.limits(task.motion))
    return rows


def at_factor(task: Task, factor: float) -> Task:
    """Return an analysis with another factor of its motion."""
    motion = task.motion
    measures = scaled_measures(motion.measures, factor / motion.scale)
    return replace(task, motion=replace(motion, scale=factor, measures=measures))


# ---- The pool


@dataclass(frozen=True, slots=True, kw_only=True)
class Workers:
    """Number of worker processes, and the time without a step after which a worker is ended."""

    count: int
    no_progress_s: float = 120.0


def run_tasks(
    tasks: Sequence[Task],
    journal: JournalWriter,
    done: Mapping[str, Row],
    *,
    workers: Workers,
    log_folder: Path,
    on_finished: Callable[[Row], None],
    search: Work | None = None,
) -> list[Row]:
    """Run the tasks without a row in the journals, and return the rows of all tasks in order.

    A worker that dies (a fault inside the solver) or hangs affects only its analysis: it is tried
    once more alone, and where that ends a second worker it is recorded with status ``crash``.

    Args:
        tasks: Tasks of any variants, in the order in which to start them.
        journal: Open journal for the new rows.
        done: Rows that the journals have already, by `run_key`.
        workers: The worker processes.
        log_folder: Folder for the messages of the solver, in a folder of each variant.
        on_finished: Called with each new row.
        search: Makes the rows of a task that begins a search, whatever the journals have. By
            default a task is one analysis, run if it is new.
    """
    every = [(number, task, run_key(task)) for number, task in enumerate(tasks)]
    rows: dict[int, list[Row]] = {}
    if search is None:
        rows = {n: [row_of_task(done[key], task, key)] for n, task, key in every if key in done}

    def finish(number: int, new: list[Row]) -> None:
        rows[number] = new
        for row in new:
            if row["run_key"] in done:
                continue
            # a search has already written the rows that it added
            if row["run_key"] == every[number][2]:
                journal.append(row)
            on_finished(row)

    with stopped_workers_ended(workers.no_progress_s) as ended:
        pool = _Pool(workers=workers, log_folder=log_folder, search=search, ended=ended)
        try:
            while pending := [item for item in every if item[0] not in rows]:
                try:
                    for number, new in pool.stream(pending):
                        finish(number, new)
                except BrokenProcessPool:
                    left = [item for item in pending if item[0] not in rows]
                    for number, new in pool.one_by_one(left[: workers.count + 1]):
                        finish(number, new)
        finally:
            # at once: a worker that is stopped or hangs would never end
            _loky().get_reusable_executor(reuse=True).shutdown(kill_workers=True)
    return [row for number in range(len(tasks)) for row in rows[number]]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pool:
    """The workers of a batch; `ended` has the processes ended because they had been stopped."""

    workers: Workers
    log_folder: Path
    search: Work | None
    ended: set[int] = field(default_factory=set[int])

    def stream(self, pending: Sequence[Pending]) -> Iterator[tuple[int, list[Row]]]:
        """Yield rows of finished tasks with their numbers; `BrokenProcessPool` if a worker died."""
        executor = _loky().get_reusable_executor(
            max_workers=min(self.workers.count, len(pending)),
            env={**_ONE_THREAD, PARENT_VARIABLE: str(os.getpid())},
            initializer=end_with_parent,
        )
        limit_s = self.workers.no_progress_s
        futures = {
            executor.submit(
                _guarded, self.search, task, key, self.log_folder / task.variant.slug, limit_s
            ): number
            for number, task, key in pending
        }
        for future in as_completed(futures):
            yield futures[future], future.result()

    def one_by_one(self, suspects: Sequence[Pending]) -> Iterable[tuple[int, list[Row]]]:
        """Yield the rows of tasks that may have ended a worker, one worker per task.

        Workers take the tasks in their order, so that the first ones without rows were under way.
        """
        logger.warning(
            "a worker died; the %d analyses in progress are repeated one at a time", len(suspects)
        )
        alone = replace(self, workers=replace(self.workers, count=1))
        for number, task, key in suspects:
            ended_before = len(self.ended)
            try:
                yield number, next(alone.stream([(0, task, key)]))[1]
            except BrokenProcessPool as error:
                hung = len(self.ended) > ended_before or signal.SIGALRM.name in str(error)
                reason = "two worker processes died in this analysis"
                if hung:
                    reason = f"no progress for {self.workers.no_progress_s:g} s"
                row = _NO_DEMANDS | no_result("crash", reason)
                row |= {"wall_s": math.nan, "cpu_s": math.nan}
                yield number, [row_of_task(row, task, key)]


def _loky() -> Any:
    return import_module("joblib.externals.loky")  # by name, because it is untyped
