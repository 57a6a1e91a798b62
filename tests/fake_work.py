"""What a worker may be told to do instead of an analysis: end or stop its process, or nothing."""

import os
import signal
from pathlib import Path

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
