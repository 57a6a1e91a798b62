"""Suppression of the message that OpenSees writes to stderr at the end of a process."""

import atexit
import os
import sys
from functools import cache


@cache
def hush_exit_message() -> None:
    """Let the process end without OpenSees' message; calling it again does nothing.

    The message is written while the C++ library is torn down, after Python has ended: what Python
    itself has to say (tracebacks too) is out by then.
    """
    atexit.register(_close_stderr)


def _close_stderr() -> None:
    sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    os.close(nowhere)
