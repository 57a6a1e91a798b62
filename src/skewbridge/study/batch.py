"""Analyses in one pool of workers, each finished one written to the journal at once."""

import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

from joblib import Parallel, delayed

from skewbridge.study.guard import Guard, Workers
from skewbridge.study.journal import JournalWriter
from skewbridge.study.keys import run_key
from skewbridge.study.task import Task
from skewbridge.study.worker import Desk, Row, Work, crashed_row, numbered, of_task, one_analysis

logger = logging.getLogger(__name__)

#: A task with its number and its key.
type Pending = tuple[int, Task, str]


def run_tasks(
    tasks: Sequence[Task],
    journal: JournalWriter,
    done: Mapping[str, Row],
    *,
    workers: Workers,
    log_folder: Path,
    on_finished: Callable[[Row], None],
    search: Callable[[Task], Work] | None = None,
) -> list[Row]:
    """Run what the journals do not have, and return the rows of all tasks in their order.

    A worker that dies (a fault inside the solver) costs its own analysis only: it is tried once
    more alone, and where that ends a second worker it is recorded with status ``crash``. So is, at
    once, an analysis that stands still; its worker is ended.

    Args:
        tasks: What is needed, in the order in which to begin it; of any variants.
        journal: Open journal for the new rows.
        done: Rows that the journals have already, by `run_key`.
        workers: The worker processes.
        log_folder: Where each analysis leaves the solver's messages, in a folder of its variant.
        on_finished: Called with each new row.
        search: Where a task is the beginning of several analyses: gives what to do with it,
            whatever the journals have. By default a task is one analysis, run if it is new.

    Raises:
        InputError: The journal cannot be written.
    """
    keys = [run_key(task) for task in tasks]
    rows: dict[int, list[Row]] = {}
    if search is None:
        rows = {
            number: [of_task(done[key], tasks[number], key)]
            for number, key in enumerate(keys)
            if key in done
        }

    def finish(number: int, found: list[Row]) -> None:
        rows[number] = found
        for row in found:
            if row["run_key"] in done:
                continue
            if row["run_key"] == keys[number]:  # what a search adds, it has written itself
                journal.append(row)
            on_finished(row)

    heartbeats = journal.path.with_suffix(".workers")
    with Guard(heartbeats, workers.no_progress_s) as guard:
        pool = _Pool(workers.count, log_folder, heartbeats, guard, search)
        try:
            while pending := [
                (number, task, key)
                for number, (task, key) in enumerate(zip(tasks, keys, strict=True))
                if number not in rows
            ]:
                try:
                    for number, found in pool.stream(pending):
                        finish(number, found)
                except BrokenProcessPool:
                    left = [each for each in pending if each[0] not in rows]
                    for number, found in pool.blamed(left):
                        finish(number, found)
        finally:
            _end_workers()
    return [row for number in range(len(tasks)) for row in rows[number]]


def _end_workers() -> None:
    """End the workers at once: one that is stopped or hangs would never come to its end."""
    loky = import_module("joblib.externals.loky")  # by name, because it is untyped
    loky.get_reusable_executor(reuse=True).shutdown(kill_workers=True)


@dataclass(frozen=True, slots=True)
class _Pool:
    """The workers of a batch, and what to do when one of them is gone."""

    count: int
    log_folder: Path
    heartbeats: Path
    guard: Guard
    search: Callable[[Task], Work] | None

    def stream(self, pending: Sequence[Pending]) -> Iterator[tuple[int, list[Row]]]:
        """Yield the rows of tasks as they are finished, with their numbers."""
        # Two workers even for one task at a time: with one, joblib would run it in this process,
        # which a fault inside the solver would end. Tasks go singly: at the end no worker has
        # several.
        parallel = Parallel(
            n_jobs=max(2, self.count),
            pre_dispatch=1 if self.count == 1 else "2 * n_jobs",
            batch_size=1,
            backend="loky",
            return_as="generator_unordered",
        )
        yield from parallel(
            delayed(numbered)(
                one_analysis if self.search is None else self.search(task),
                number,
                task,
                key,
                Desk(
                    log_folder=self.log_folder / task.variant.slug,
                    heartbeats=self.heartbeats,
                    owner_pid=os.getpid(),
                ),
            )
            for number, task, key in pending
        )

    def blamed(self, left: Sequence[Pending]) -> Iterator[tuple[int, list[Row]]]:
        """Yield the rows of those tasks that may have broken the pool.

        Args:
            left: The tasks without rows, in the order in which they were begun.
        """
        begun = self.guard.under_way()
        if hung := [each for each in left if each[2] in self.guard.ended]:
            for number, task, key in hung:
                yield number, [crashed_row(task, key, self.guard.ended[key])]
            return
        # A worker may also die before it begins, when it takes the task in.
        suspects = [each for each in left if each[2] in begun] or left[: self.count + 1]
        logger.warning("a worker died; the %d analyses under way run alone", len(suspects))
        alone = replace(self, count=1)
        for number, task, key in suspects:
            try:
                yield number, next(alone.stream([(0, task, key)]))[1]
            except BrokenProcessPool:
                self.guard.under_way()
                reason = self.guard.ended.get(key, "two worker processes died in it")
                yield number, [crashed_row(task, key, reason)]
