"""What a worker may be told to do instead of an analysis: end or stop its process, or nothing."""

import os
import signal
from pathlib import Path

from skewbridge.study import capacity_search
from skewbridge.study.capacity_search import Known, Search
from skewbridge.study.task import Task, no_result
from skewbridge.study.worker import Desk, Row, of_task


def done_at_once(task: Task, key: str, _desk: Desk) -> list[Row]:
    """Return a row without an analysis."""
    return [of_task({**no_result("ok", ""), "cpu_s": 0.0}, task, key)]


def signalled(
    task: Task, key: str, desk: Desk, *, motion_id: str, sent: signal.Signals, first: Path | None
) -> list[Row]:
    """Send a signal to the own process in one of the analyses.

    Args:
        task: The analysis.
        key: Its key.
        desk: Not used.
        motion_id: Where to do it.
        sent: The signal.
        first: If given, it is done only until this file is there.
    """
    if task.motion.motion.motion_id == motion_id and not (first and first.exists()):
        if first:
            first.touch()
        os.kill(os.getpid(), sent)
    return done_at_once(task, key, desk)


def searched(task: Task, key: str, desk: Desk, *, search: Search, known: Known) -> list[Row]:
    """Search a capacity without analyses; the demand is the factor."""

    def row_of(trial: Task, trial_key: str, _desk: Desk) -> Row:
        row = {**no_result("ok", ""), "cpu_s": 0.0, search.demand: trial.motion.scale}
        return of_task(row, trial, trial_key)

    capacity_search.analysed_row = row_of  # of this worker, which ends with the batch
    return capacity_search.search_capacity(search, known, task, key, desk)
