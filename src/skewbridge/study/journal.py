"""The journal of a job: append-only, one JSON line per finished analysis.

A study that was killed repeats nothing that stands in any journal of its folder, however its
analyses were shared out among jobs. A journal is never a declared output of a rule, so Snakemake
does not delete it.
"""

import fcntl
import json
import os
import time
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from skewbridge.errors import InputError
from skewbridge.study.folder import StudyFolder

#: Raised by one when a column changes its meaning; lines in another form are not used.
JOURNAL_FORMAT: Final = 2
_FORMAT_KEY: Final = "journal_format"
#: Between two attempts to lock a journal.
POLL_S: Final = 0.5


def read_journals(folder: StudyFolder) -> dict[str, dict[str, Any]]:
    """Return the rows of all journals of a study by `run_key`."""
    return {key: row for path in folder.journals for key, row in read_journal(path).items()}


def read_journal(path: Path) -> dict[str, dict[str, Any]]:
    """Return the rows of a journal by `run_key`; the last line of a key wins.

    A line cut short by a kill and a line in another form (see `outdated_lines`) are passed over:
    their analyses simply run again.
    """
    return {
        row["run_key"]: row
        for row in _lines(path)
        if row.pop(_FORMAT_KEY, 1) == JOURNAL_FORMAT and "run_key" in row
    }


def outdated_lines(path: Path) -> int:
    """Return how many lines of a journal another version of the program wrote."""
    return sum(row.get(_FORMAT_KEY, 1) != JOURNAL_FORMAT for row in _lines(path))


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    if not path.exists():
        return
    with path.open(encoding="utf-8") as lines:
        for line in lines:
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            if isinstance(row, dict):
                yield row


class JournalWriter:
    """Appends rows to a journal that it holds the lock of."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def append(self, row: Mapping[str, Any]) -> None:
        """Write one row and make sure that it is on the disk."""
        # One write call per line; the newline in front closes a line that a kill cut short.
        marked = {_FORMAT_KEY: JOURNAL_FORMAT, **row}
        line = "\n" + json.dumps(marked, allow_nan=True) + "\n"
        os.write(self._descriptor, line.encode())
        os.fsync(self._descriptor)


@contextmanager
def open_journal(path: Path, patience_s: float = 0.0) -> Generator[JournalWriter]:
    """Open a journal for writing, alone.

    Args:
        path: The journal.
        patience_s: How long to wait for the process that writes it.

    Raises:
        InputError: Another process runs the same job in the same folder.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        _lock(descriptor, path, patience_s)
        yield JournalWriter(descriptor)
    finally:
        os.close(descriptor)


def _lock(descriptor: int, path: Path, patience_s: float) -> None:
    """Lock a journal against other processes, those on other nodes of a cluster, too.

    NFS (from version 4 without a daemon, Linux) makes a lock of the whole file by `fcntl` of it. It
    is not asked for by `fcntl` here, since that one ends when this process closes any descriptor of
    the file, as reading the journals does.
    """
    until_s = time.monotonic() + patience_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() >= until_s:
                raise InputError(
                    f"{path} is being written by another process; end that study first"
                ) from None
        except OSError as error:
            raise InputError(
                f"{path} cannot be locked ({error.strerror}): put the folder of the study on a "
                "file system with locks, such as NFSv4 or Lustre mounted with the option flock"
            ) from None
        time.sleep(POLL_S)
