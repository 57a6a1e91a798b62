"""Analyses in one pool of workers, each finished one written to the journal at once."""

import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from joblib import Parallel, delayed

from skewbridge.study.journal import JournalWriter
from skewbridge.study.keys import run_key
from skewbridge.study.task import Task
from skewbridge.study.worker import Row, Work, crashed_row, numbered, of_task, one_analysis

logger = logging.getLogger(__name__)


def run_tasks(
    tasks: Sequence[Task],
    journal: JournalWriter,
    done: Mapping[str, Row],
    *,
    n_jobs: int,
    log_folder: Path,
    on_finished: Callable[[Row], None],
    search: Callable[[Task], Work] | None = None,
) -> list[Row]:
    """Run what the journals do not have, and return the rows of all tasks in their order.

    A worker that dies (a fault inside the solver) costs its own analysis only: it is tried once
    more alone and then recorded with status ``crash``.

    Args:
        tasks: What is needed, in the order in which to begin it; of any variants.
        journal: Open journal for the new rows.
        done: Rows that the journals have already, by `run_key`.
        n_jobs: Worker processes.
        log_folder: Where each analysis leaves the solver's messages, in a folder of its variant.
        on_finished: Called with each new row.
        search: Where a task is the beginning of several analyses: gives what to do with it,
            whatever the journals have. By default a task is one analysis, run if it is new.
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
            if row["run_key"] not in done:
                journal.append(row)
                on_finished(row)

    while pending := [
        (number, task, key)
        for number, (task, key) in enumerate(zip(tasks, keys, strict=True))
        if number not in rows
    ]:
        try:
            for number, found in _stream(pending, n_jobs, log_folder, search):
                finish(number, found)
        except BrokenProcessPool:
            left = [each for each in pending if each[0] not in rows][: n_jobs + 1]
            logger.warning("a worker died; the %d analyses under way run alone", len(left))
            for number, task, key in left:
                finish(number, _alone(task, key, log_folder, search))
    return [row for number in range(len(tasks)) for row in rows[number]]


def _stream(
    pending: Sequence[tuple[int, Task, str]],
    n_jobs: int,
    log_folder: Path,
    search: Callable[[Task], Work] | None,
) -> Iterator[tuple[int, list[Row]]]:
    # Two workers even for one task at a time: with one, joblib would run it in this process, which
    # a fault inside the solver would end. Tasks go singly: at the end no worker has several.
    parallel = Parallel(
        n_jobs=max(2, n_jobs),
        pre_dispatch=1 if n_jobs == 1 else "2 * n_jobs",
        batch_size=1,
        backend="loky",
        return_as="generator_unordered",
    )
    yield from parallel(
        delayed(numbered)(
            one_analysis if search is None else search(task),
            number,
            task,
            key,
            log_folder / task.variant.slug,
            os.getpid(),
        )
        for number, task, key in pending
    )


def _alone(
    task: Task, key: str, log_folder: Path, search: Callable[[Task], Work] | None
) -> list[Row]:
    try:
        return next(_stream([(0, task, key)], 1, log_folder, search))[1]
    except BrokenProcessPool:
        return [crashed_row(task, key)]
