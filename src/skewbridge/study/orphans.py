"""No process of a killed study goes on: each one ends when the process it works for is gone."""

import ctypes
import os
import signal
import sys
import threading
import time
from contextlib import suppress
from functools import cache
from typing import Final

import psutil

POLL_S: Final = 1.0
EXIT_ORPHANED: Final = 3
EXIT_INTERRUPTED: Final = 130
_CURSOR_ON: Final = "\x1b[?25h"
# source: linux/prctl.h
_PR_SET_PDEATHSIG: Final = 1


@cache
def end_with(pid: int) -> threading.Thread:
    """End this process, at once, as soon as another process has ended.

    A killed parent cannot tell its children, and an orphan would write beside its successor.
    Where that process is the parent and the system is Linux, the kernel does it, of a stopped or
    busy process, too. Calling it again for the same process does nothing.

    Args:
        pid: The process to watch.

    Returns:
        The watching thread.
    """

    def watch() -> None:
        try:
            owner = psutil.Process(pid)
            while owner.is_running() and owner.status() != psutil.STATUS_ZOMBIE:
                time.sleep(POLL_S)
        except psutil.NoSuchProcess:
            pass
        os._exit(EXIT_ORPHANED)

    if sys.platform == "linux" and pid == os.getppid():
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    thread = threading.Thread(target=watch, name=f"end-with-{pid}", daemon=True)
    thread.start()
    return thread


def end_all_on_interrupt(message: str) -> None:
    """Let Ctrl-C end this process and all that it has started, at once, with one sentence.

    Nothing is lost by that: files are written whole or not at all, and a journal line by line.
    Where Ctrl-C is ignored, as in the background of a script, it stays so.

    Args:
        message: The sentence.
    """

    def end(*_: object) -> None:
        shown = _CURSOR_ON if sys.stderr.isatty() else ""  # a progress bar hides the cursor
        os.write(2, f"{shown}\n{message}\n".encode())
        for child in psutil.Process().children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                child.kill()
        os._exit(EXIT_INTERRUPTED)

    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
        signal.signal(signal.SIGINT, end)


def workflow_pid() -> int:
    """Return the nearest ancestor that runs the workflow, or else the parent."""
    for ancestor in psutil.Process().parents():
        try:
            if any("snakemake" in part for part in ancestor.cmdline()[:3]):
                return ancestor.pid
        except psutil.Error:
            break
    return os.getppid()
