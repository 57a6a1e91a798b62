"""The sign of life of a worker: a small file, written anew as its analysis goes on."""

import json
import os
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

#: No more often than this: on a shared disk a write costs more than a step.
_EVERY_S: Final = 0.5
_BYTES: Final = 128


@dataclass(frozen=True, slots=True, kw_only=True)
class Beat:
    """What a worker is at.

    Attributes:
        run_key: The analysis; empty between two of them.
        time_s: Time of the motion that it has reached, or less.
        number: Counts the beats of the worker.
    """

    run_key: str = ""
    time_s: float = 0.0
    number: int = 0


class Heartbeat:
    """Writes the sign of life of this process.

    Args:
        folder: Where the workers of a batch write, each to a file named by its process.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / str(os.getpid())
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT, 0o644)
        self._run_key, self._number, self._written_s = "", 0, 0.0

    def begin(self, run_key: str) -> None:
        """Tell that an analysis begins; an empty key that it has ended."""
        self._run_key = run_key
        self._write(0.0)

    def go_on(self, time_s: float, _duration_s: float) -> None:
        """Tell that the analysis goes on; to be called often."""
        if time.monotonic() - self._written_s > _EVERY_S:
            self._write(time_s)

    def _write(self, time_s: float) -> None:
        self._written_s = time.monotonic()
        self._number += 1
        beat = {"run_key": self._run_key, "time_s": round(time_s, 3), "number": self._number}
        # In place and of one length: no room is needed for it on a full disk.
        os.pwrite(self._descriptor, json.dumps(beat).ljust(_BYTES).encode(), 0)


@cache
def heartbeat(folder: Path) -> Heartbeat:
    """Return the heartbeat of this process in a folder."""
    return Heartbeat(folder)


def beats(folder: Path) -> dict[int, Beat]:
    """Return what the workers of a batch are at, by process."""
    found: dict[int, Beat] = {}
    for path in folder.glob("[0-9]*"):
        try:
            found[int(path.name)] = Beat(**json.loads(path.read_bytes()))
        except (OSError, ValueError, TypeError):  # just begun, or half written
            continue
    return found
