"""Analyses in a pool of worker processes; each finished row is written to the journal at once."""

import logging
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from skewbridge.study.journal import JournalWriter
from skewbridge.study.processes import PARENT_VARIABLE, end_with_parent, stopped_workers_ended
from skewbridge.study.task import Task, run_key
from skewbridge.study.worker import Row, Work, crashed_row, guarded, one_analysis, row_of_task

logger = logging.getLogger(__name__)

#: A task with its number and its key.
type Pending = tuple[int, Task, str]

#: One thread in each worker: more threads would compete with the other workers.
_ONE_THREAD: Final = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
)


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
        search: Function that makes the rows of a task which is the beginning of several analyses,
            whatever the journals have. By default a task is one analysis, run if it is new.
    """
    keys = [run_key(task) for task in tasks]
    rows: dict[int, list[Row]] = {}
    if search is None:
        rows = {
            number: [row_of_task(done[key], tasks[number], key)]
            for number, key in enumerate(keys)
            if key in done
        }

    def finish(number: int, new: list[Row]) -> None:
        rows[number] = new
        for row in new:
            if row["run_key"] in done:
                continue
            # a search has already written the rows that it added
            if row["run_key"] == keys[number]:
                journal.append(row)
            on_finished(row)

    with stopped_workers_ended(workers.no_progress_s) as ended:
        pool = _Pool(workers=workers, log_folder=log_folder, search=search, ended=ended)
        try:
            while pending := [
                (number, task, key)
                for number, (task, key) in enumerate(zip(tasks, keys, strict=True))
                if number not in rows
            ]:
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
        count = min(self.workers.count, len(pending))
        executor = _loky().get_reusable_executor(
            max_workers=count,
            env={**_ONE_THREAD, PARENT_VARIABLE: str(os.getpid())},
            initializer=end_with_parent,
        )
        futures = {
            executor.submit(
                guarded,
                self.search or one_analysis,
                task,
                key,
                self.log_folder / task.variant.slug,
                self.workers.no_progress_s,
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
                yield number, [crashed_row(task, key, reason)]


def _loky() -> Any:
    return import_module("joblib.externals.loky")  # by name, because it is untyped
