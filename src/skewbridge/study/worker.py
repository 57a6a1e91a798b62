"""What a worker process runs: one analysis and its row, whatever becomes of it.

A worker imports this module and what stands below it: no tables, no pools of workers.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.demands.columns import key_values
from skewbridge.demands.demand_columns import DEMAND_COLUMNS, INTENSITY_COLUMNS
from skewbridge.study.heartbeat import heartbeat
from skewbridge.study.orphans import end_with
from skewbridge.study.task import Task, analyse_task, no_result

type Row = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Desk:
    """Where a worker leaves what is not a result.

    Attributes:
        log_folder: For the solver's messages, in a file named after motion and key.
        heartbeats: For the sign of life of the process.
        owner_pid: The process that the results are for; when it ends, so does the worker.
    """

    log_folder: Path
    heartbeats: Path
    owner_pid: int


#: Makes the rows of a task with a key.
type Work = Callable[[Task, str, Desk], list[Row]]

_WITHOUT_RESULT: Final = ("invalid_input", "crash")
_NO_DEMANDS: Final = {column.name: math.nan for column in DEMAND_COLUMNS}


def one_analysis(task: Task, key: str, desk: Desk) -> list[Row]:
    """Return the one row of the analysis that a task describes."""
    return [analysed_row(task, key, desk)]


def analysed_row(task: Task, key: str, desk: Desk) -> Row:
    """Run one analysis in this process and return its row of the demands table.

    Args:
        task: The analysis.
        key: Its `run_key`; it is the caller's, whose sources may be older than this process.
        desk: Where messages and signs of life go.
    """
    desk.log_folder.mkdir(parents=True, exist_ok=True)
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    log = desk.log_folder / f"{task.motion.motion.motion_id}_{key}.log"
    outcome = analyse_task(task, log, heartbeat(desk.heartbeats).go_on)
    if log.is_file() and log.stat().st_size == 0:  # OpenSees had nothing to say
        log.unlink()
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    if outcome["status"] in _WITHOUT_RESULT:
        outcome = {**_NO_DEMANDS, **outcome}
    return of_task({**outcome, **times}, task, key)


def numbered(work: Work, number: int, task: Task, key: str, desk: Desk) -> tuple[int, list[Row]]:
    """Return the rows of a task with its number, by which an unordered stream is sorted.

    The process tells what it is at, and ends with its owner.
    """
    hush_exit_message()
    end_with(desk.owner_pid)
    sign = heartbeat(desk.heartbeats)
    sign.begin(key)
    rows = work(task, key, desk)
    sign.begin("")
    return number, rows


def crashed_row(task: Task, key: str, reason: str) -> Row:
    """Return the row of an analysis that has ended its process, or stood still."""
    crash = no_result("crash", reason)
    times = {"wall_s": math.nan, "cpu_s": math.nan}
    return of_task({**_NO_DEMANDS, **crash, **times}, task, key)


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
