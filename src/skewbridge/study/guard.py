"""Watches the workers of a batch: one that stands still is ended, so that the study goes on."""

import logging
import os
import shutil
import signal
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

import psutil

from skewbridge.study.heartbeat import Beat, beats

logger = logging.getLogger(__name__)

#: What workers may take to start and load the solver, on a busy machine.
_START_S: Final = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Workers:
    """The worker processes of a batch.

    Attributes:
        count: How many.
        no_progress_s: A worker whose analysis stands still for so long is ended.
    """

    count: int
    no_progress_s: float = 120.0


class Guard:
    """Ends workers of this process that stand still, while it is entered.

    Only time during which this process itself ran counts, so that a machine that was put to sleep
    loses no analysis.

    Args:
        folder: Where the workers write their heartbeats; emptied first, and gone at the end.
        no_progress_s: How long a worker may stand still.
    """

    def __init__(self, folder: Path, no_progress_s: float) -> None:
        self._folder, self._limit_s = folder, no_progress_s
        self._poll_s = min(1.0, no_progress_s / 10.0)
        self._seen: dict[int, Beat] = {}
        self._still_s: dict[int, float] = {}
        self._all_still_s = 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="guard", daemon=True)
        #: Why a worker was ended, by the key of its analysis.
        self.ended: Final[dict[str, str]] = {}

    def __enter__(self) -> Self:
        shutil.rmtree(self._folder, ignore_errors=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        shutil.rmtree(self._folder, ignore_errors=True)

    def under_way(self) -> set[str]:
        """Return the keys of the analyses that workers have begun and not ended, dead ones' too.

        Forgets the workers: to be called when their pool is broken.
        """
        keys = {beat.run_key for beat in beats(self._folder).values()} - {""}
        shutil.rmtree(self._folder, ignore_errors=True)
        return keys

    def _watch(self) -> None:
        while not self._stop.wait(self._poll_s):
            self._look(beats(self._folder))

    def _look(self, now: dict[int, Beat]) -> None:
        """Compare the heartbeats with those of one poll earlier."""
        self._all_still_s = self._all_still_s + self._poll_s if now == self._seen else 0.0
        for pid, beat in now.items():
            stands = beat.run_key and beat == self._seen.get(pid)
            self._still_s[pid] = self._still_s.get(pid, 0.0) + self._poll_s if stands else 0.0
            if self._still_s[pid] >= self._limit_s:
                self.ended[beat.run_key] = f"no progress for {self._limit_s:g} s"
                self._end(pid)
        # Workers that never began, or that wait for one that was stopped between two analyses.
        if self._all_still_s >= self._limit_s + _START_S:
            for pid in worker_pids():
                self._end(pid)
        self._seen = now

    def _end(self, pid: int) -> None:
        self._still_s[pid] = self._all_still_s = 0.0
        try:
            if psutil.Process(pid).ppid() == os.getpid():
                os.kill(pid, signal.SIGKILL)
        except (psutil.NoSuchProcess, ProcessLookupError):
            return
        logger.warning("worker %d made no progress for %g s and was ended", pid, self._limit_s)


def worker_pids() -> list[int]:
    """Return the workers of this process, whether or not they have begun anything."""
    found: list[int] = []
    for child in psutil.Process().children():
        with suppress(psutil.Error):
            if any("popen_loky" in part for part in child.cmdline()):
                found.append(child.pid)
    return found
