"""Control of processes: end with the parent, end stopped workers, one study per folder."""

import atexit
import ctypes
import fcntl
import logging
import os
import signal
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Final

import psutil

from skewbridge.errors import InputError

logger = logging.getLogger(__name__)

LOCK_NAME: Final = "study.lock"
#: Logger whose lines are shown in the terminal, so that a piped run shows its progress.
PROGRESS_LOG: Final = "skewbridge.progress"
_PR_SET_PDEATHSIG: Final = 1  # source: linux/prctl.h
_EXIT_ORPHANED: Final = 3
_PARENT: Final = os.getppid()
#: Environment variable with the id of the parent process, so that a process also detects a parent
#: that ended before this module was imported.
PARENT_VARIABLE: Final = "SKEWBRIDGE_PARENT"
#: Environment variable with the number of processors of a study on this machine (common.smk).
PROCESSORS: Final = "SKEWBRIDGE_PROCESSORS"
#: Environment variable with the start time of the command and its number of processors
#: (common.smk).
CLOCK: Final = "SKEWBRIDGE_CLOCK"


@cache
def end_with_parent() -> None:
    """Make the kernel end this process when its parent ends, even while it is stopped."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != int(os.environ.get(PARENT_VARIABLE, _PARENT)):  # the parent has ended
        os._exit(_EXIT_ORPHANED)


@cache
def hush_exit_message() -> None:
    """Suppress the message that OpenSees writes to stderr after Python has ended."""

    def close_stderr() -> None:
        sys.stderr.flush()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)

    atexit.register(close_stderr)


@contextmanager
def stopped_workers_ended(limit_s: float) -> Generator[set[int]]:
    """Inside the block, end workers of this process that stay stopped (SIGSTOP) for `limit_s`.

    Only time in which this process runs counts (Ctrl-Z). Yields the ids of the processes ended.
    """
    stopped_s: dict[int, float] = {}
    ended: set[int] = set()
    poll_s = min(0.5, limit_s / 4.0)

    def look(*_: object) -> None:
        for child in worker_processes():
            with suppress(psutil.Error):
                stopped = child.status() == psutil.STATUS_STOPPED
                stopped_s[child.pid] = stopped_s.get(child.pid, 0.0) + poll_s if stopped else 0.0
                if stopped_s[child.pid] >= limit_s and child.pid not in ended:
                    ended.add(child.pid)
                    child.kill()

    before = signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, poll_s, poll_s)
    try:
        yield ended
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def worker_processes() -> list[psutil.Process]:
    """Return the worker processes of this process, including idle workers."""
    workers: list[psutil.Process] = []
    for child in psutil.Process().children():
        with suppress(psutil.Error):
            if any("popen_loky" in argument for argument in child.cmdline()):
                workers.append(child)
    return workers


def hold_tree(folder: Path) -> None:
    """Take the study lock in ``.snakemake``; `InputError` if another study is running there."""
    folder.mkdir(parents=True, exist_ok=True)
    # Kept open until the process ends, because closing it ends the lock. No child inherits it.
    descriptor = os.open(folder / LOCK_NAME, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = os.read(descriptor, 32).decode(errors="replace").strip()
        os.close(descriptor)
        problem = f"another study is running in {folder.parent.resolve()} (process {holder})"
        advice = "wait for it or end it, then run the same command again"
        raise InputError(f"{problem}: {advice}") from None
    with suppress(OSError):  # the process id is only for the message above: ignore a full disk
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, str(os.getpid()).encode(), 0)


def cancel_left_behind(prefix: str) -> None:
    """Cancel Slurm jobs of a killed workflow, whose names start with the prefix."""
    command = ["squeue", "--me", "--noheader", "--format=%i %j"]
    queue = subprocess.run(command, capture_output=True, text=True, check=True)
    names = dict(line.split(maxsplit=1) for line in queue.stdout.splitlines())
    jobs = [job for job, name in names.items() if name.startswith(prefix)]
    if jobs:
        logger.warning("cancelling %d job(s) that an earlier run left behind", len(jobs))
        subprocess.run(["scancel", *jobs], check=True)
