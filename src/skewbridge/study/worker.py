"""Worker processes: an analysis and its row, ended by the system when it hangs.

A worker imports this module and the packages below it: no tables, no pools of workers.
"""

import math
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

from skewbridge.demands.columns import SUITE, key_values
from skewbridge.demands.completeness import (
    BEYOND_MODEL,
    COLUMN_FAILURE_RATIO,
    COMPLETE,
    column_failure_ratio,
    completed,
)
from skewbridge.demands.demand_columns import DEMAND_COLUMNS, INTENSITY_COLUMNS
from skewbridge.study.journal import Row
from skewbridge.study.processes import end_with_parent, hush_exit_message
from skewbridge.study.task import Task, analyse_task, no_result
from skewbridge.variant.random_properties import DRAW_PREFIX

#: Makes the rows of a task with a key; the folder is for messages of the solver.
type Work = Callable[[Task, str, Path], list[Row]]

_WITHOUT_RESULT: Final = ("invalid_input", "crash")
_NO_DEMANDS: Final = {column.name: math.nan for column in DEMAND_COLUMNS}


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


def guarded(work: Work, task: Task, key: str, log_folder: Path, no_progress_s: float) -> list[Row]:
    """Return the rows of a task in a worker process that ends with its parent or when it hangs."""
    hush_exit_message()
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C
    Alarm.limit_s = no_progress_s
    Alarm.restart()
    try:
        return work(task, key, log_folder)
    finally:
        Alarm.limit_s = 0.0
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def one_analysis(task: Task, key: str, log_folder: Path) -> list[Row]:
    """Return the one row of the analysis that a task describes."""
    return [analysed_row(task, key, log_folder)]


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
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    if outcome["status"] in _WITHOUT_RESULT:
        outcome = {**_NO_DEMANDS, **outcome}
    return row_of_task({**outcome, **times}, task, key)


def crashed_row(task: Task, key: str, reason: str) -> Row:
    """Return the row of an analysis that ended its process."""
    crash = no_result("crash", reason)
    times = {"wall_s": math.nan, "cpu_s": math.nan}
    return row_of_task({**_NO_DEMANDS, **crash, **times}, task, key)


def row_of_task(row: Row, task: Task, key: str) -> Row:
    """Return a row with the columns that identify its analysis and those derived from others."""
    return {**row, **derived_columns(row), **identity_of(task, key)}


def derived_columns(row: Row) -> Row:
    """Return the columns of a row that follow from others; they are never read from a journal."""
    return {
        COMPLETE: bool(completed(row["status"], row.get(BEYOND_MODEL) or "")),
        COLUMN_FAILURE_RATIO: float(column_failure_ratio(row)),
    }


def identity_of(task: Task, key: str) -> Row:
    """Return the columns of a row that identify its analysis, with its `run_key`."""
    motion = task.motion
    return {
        **key_values(task.variant, motion.motion.motion_id, motion.scale, task.incidence_deg),
        SUITE: motion.suite,
        **{f"{DRAW_PREFIX}{name}": value for name, value in task.draw.items()},
        **{column.name: motion.measures[column.name] for column in INTENSITY_COLUMNS},
        "run_key": key,
    }
