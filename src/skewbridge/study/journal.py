"""The journal of a job: append-only, one JSON line per finished analysis, with its checksum.

A killed study resumes without repeating the analyses in its journals. A journal is never a declared
output of a rule, so that Snakemake does not delete it.
"""

import fcntl
import json
import os
import re
import time
import zlib
from collections import Counter
from collections.abc import Collection, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from skewbridge.errors import InputError
from skewbridge.files.text import written_aside
from skewbridge.study.folder import StudyFolder

type Row = dict[str, Any]

#: Version of the format, increased when a column changes meaning; older lines are ignored.
JOURNAL_FORMAT: Final = 3
_FORMAT_KEY: Final = "journal_format"
#: The last entry of a line: the CRC-32 of the line without this entry, which detects altered bytes.
_CHECKSUM: Final = re.compile(rb', "crc32": "([0-9a-f]{8})"\}$')
#: Time between two attempts to lock a journal.
POLL_S: Final = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class JournalContent:
    """Content of the journals of a study; unused lines are only counted."""

    rows: dict[str, Row]  # by `run_key`; the last line of a key counts
    counts: Counter[str]  # outdated (other version), damaged (cut short or altered)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Messages about lines that are not used."""
        kinds = {"outdated": "of another version of skewbridge", "damaged": "cut short or altered"}
        return tuple(
            f"The journals hold {self.counts[name]} line(s) {kind}, which are ignored: their "
            "analyses run again (`skewbridge study retry` removes the lines)."
            for name, kind in kinds.items()
            if self.counts[name]
        )


def read_content(paths: Sequence[Path]) -> JournalContent:
    """Return the content of journals; missing files count as empty."""
    rows: dict[str, Row] = {}
    counts: Counter[str] = Counter(outdated=0, damaged=0)
    for path in paths:
        content = path.read_bytes() if path.exists() else b""
        for line in filter(bytes.strip, content.split(b"\n")):
            row = _row(line)
            if row is None:
                counts["damaged"] += 1
            elif row.pop(_FORMAT_KEY, 1) != JOURNAL_FORMAT or "run_key" not in row:
                counts["outdated"] += 1
            else:
                rows[row["run_key"]] = row
    return JournalContent(rows=rows, counts=counts)


def _row(line: bytes) -> Row | None:
    """Return the row stored in a line; None if the line was altered or contains no row."""
    checksum = _CHECKSUM.search(line)
    body = line if checksum is None else line[: checksum.start()] + b"}"
    if checksum is not None and int(checksum[1], 16) != zlib.crc32(body):
        return None
    try:
        row = json.loads(body)
    except (ValueError, RecursionError):
        return None
    # A line without a checksum is of an older version, or was cut short.
    is_whole = isinstance(row, dict) and (checksum or row.get(_FORMAT_KEY, 1) != JOURNAL_FORMAT)
    return row if is_whole else None


def _line(row: Mapping[str, Any]) -> bytes:
    body = json.dumps({_FORMAT_KEY: JOURNAL_FORMAT, **row}, allow_nan=True).encode()
    return body[:-1] + f', "crc32": "{zlib.crc32(body):08x}"}}\n'.encode()


class JournalWriter:
    """Writer of an open journal, which holds its lock."""

    def __init__(self, descriptor: int, path: Path) -> None:
        self._descriptor = descriptor
        self.path: Final = path

    def append(self, row: Mapping[str, Any]) -> None:
        """Write one row to the disk; if this fails, restore the journal and raise `InputError`."""
        size = os.fstat(self._descriptor).st_size
        # The leading newline ends a line that a kill cut short.
        line = b"\n" + _line(row)
        try:
            while line:
                line = line[os.write(self._descriptor, line) :]
            os.fsync(self._descriptor)
        except OSError as error:
            os.ftruncate(self._descriptor, size)
            advice = "its finished analyses are kept"
            problem = f"cannot write the journal {self.path}: {error.strerror}; {advice}"
            raise InputError(f"{problem}: free disk space and run the same command again") from None


@contextmanager
def open_journal(path: Path, patience_s: float = 0.0) -> Generator[JournalWriter]:
    """Lock a journal and open it for writing.

    `InputError` if another process holds the lock after `patience_s`, or it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    except OSError as error:
        raise InputError(f"cannot write the journal {path}: {error.strerror}") from None
    try:
        _lock(descriptor, path, patience_s)
        yield JournalWriter(descriptor, path)
    finally:
        os.close(descriptor)


def _lock(descriptor: int, path: Path, patience_s: float) -> None:
    # flock also locks against other nodes of a cluster (NFS 4 makes it a lock of the file). A lock
    # by fcntl would end when this process closes any descriptor of the file, also after reading.
    until_s = time.monotonic() + patience_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() >= until_s:
                problem = "is being written by another process: end that study or wait for it"
                raise InputError(f"{path} {problem}") from None
        except OSError as error:
            raise InputError(
                f"{path} cannot be locked ({error.strerror}): put the folder of the study on a "
                "file system with locks, such as NFSv4 or Lustre mounted with the option flock"
            ) from None
        time.sleep(POLL_S)


def forget(folder: StudyFolder, statuses: Collection[str]) -> list[Row]:
    """Remove analyses with the given statuses from the journals and return their rows.

    Only the last line of each other key is kept. The page and the demands files with the removed
    rows are deleted, because Snakemake reruns only the jobs whose outputs are missing.
    `InputError` if the study runs.
    """
    rows = read_content(folder.journals).rows.values()
    removed = [row for row in rows if row["status"] in statuses]
    with ExitStack() as locks:
        for path in folder.journals:
            locks.enter_context(open_journal(path))
        for path in folder.journals:
            with written_aside(path) as temporary:
                stored = read_content([path]).rows.values()
                lines = [_line(row) for row in stored if row.get("status") not in statuses]
                temporary.write_bytes(b"".join(lines))
    if removed:
        variants = {row["variant"] for row in removed}
        demands_files = [path for name in variants for path in folder.demands_files(name)]
        for path in (folder.report, folder.demands, *demands_files):
            path.unlink(missing_ok=True)
    return removed
