"""Replacements of an analysis in a worker: end or stop its process, or do nothing."""

import ctypes
import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path

from skewbridge.study import ida
from skewbridge.study.batch import Alarm, Row, row_of_task
from skewbridge.study.ida import Search
from skewbridge.study.task import Task, no_result


def done_at_once(task: Task, key: str, _log_folder: Path) -> list[Row]:
    """Return a row without an analysis."""
    return [row_of_task({**no_result("ok", ""), "cpu_s": 0.0}, task, key)]


def signalled(
    task: Task,
    key: str,
    log_folder: Path,
    *,
    motion_id: str,
    sent: signal.Signals,
    first: Path | None,
) -> list[Row]:
    """Send a signal to the own process in one of the analyses.

    Args:
        task: The analysis.
        key: Its key.
        log_folder: Not used.
        motion_id: Where to do it.
        sent: The signal.
        first: If given, it is done only until this file is there.
    """
    if task.motion.motion.motion_id == motion_id and not (first and first.exists()):
        if first:
            first.touch()
        os.kill(os.getpid(), sent)
    return done_at_once(task, key, log_folder)


def searched(
    search: Search, done: Mapping[str, Row], journal: Path, task: Task, key: str, log_folder: Path
) -> list[Row]:
    """Search a capacity without analyses; the demand is the factor."""

    def row_of(trial: Task, trial_key: str, _log_folder: Path) -> Row:
        row = {**no_result("ok", ""), "cpu_s": 0.0, search.demand: trial.motion.scale}
        return row_of_task(row, trial, trial_key)

    ida.analysed_row = row_of  # of this worker, which ends with the batch
    return ida.search_capacity(search, done, journal, task, key, log_folder)


def hanging(task: Task, key: str, log_folder: Path, *, motion_id: str) -> list[Row]:
    """Block every signal that Python could handle and wait for ever in one of the analyses."""
    if task.motion.motion.motion_id == motion_id:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        ctypes.CDLL(None).sleep(600)
    return done_at_once(task, key, log_folder)


def slow(task: Task, key: str, log_folder: Path, *, seconds: float) -> list[Row]:
    """Take steps for some time."""
    ends_s = time.monotonic() + seconds
    while time.monotonic() < ends_s:
        time.sleep(0.1)
        Alarm.restart()
    return done_at_once(task, key, log_folder)
