"""Replacements of an analysis in a worker: end or stop its process, or do nothing."""

import os
import time

from skewbridge.study import batch
from skewbridge.study.batch import restart_alarm, row_of_task
from skewbridge.study.task import no_result


def done_at_once(task, key, _log_folder):
    return [row_of_task({**no_result("ok", ""), "cpu_s": 0.0}, task, key)]


def signalled(task, key, log_folder, *, motion_id, sent, first):
    """Send a signal to the own process in one of the analyses, until the file `first` exists."""
    if task.motion.motion.motion_id == motion_id and not (first and first.exists()):
        if first:
            first.touch()
        os.kill(os.getpid(), sent)
    return done_at_once(task, key, log_folder)


def searched(ida, done, journal, task, key, log_folder):
    """Search a capacity without analyses; the demand is the factor."""

    def row_of(trial, trial_key, _log_folder):
        row = {**no_result("ok", ""), "cpu_s": 0.0, ida.ida_demand: trial.motion.scale}
        return row_of_task(row, trial, trial_key)

    batch.analysed_row = row_of  # of this worker, which ends with the batch
    return batch.search_capacity(ida, done, journal, task, key, log_folder)


def slow(task, key, log_folder, *, seconds):
    ends_s = time.monotonic() + seconds
    while time.monotonic() < ends_s:
        time.sleep(0.1)
        restart_alarm()
    return done_at_once(task, key, log_folder)
