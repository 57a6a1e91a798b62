"""How far a study is: a live bar in a terminal, one line a minute in a log."""

import logging
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from skewbridge.demands.suspect import LIMITS, SuspectLimits, reasons
from skewbridge.statuses import FAILED
from skewbridge.study.journal import JournalContent
from skewbridge.study.session import PROGRESS_LOG

logger = logging.getLogger(__name__)

progress_logger = logging.getLogger(PROGRESS_LOG)

LOG_INTERVAL_S: Final = 60.0
CRASH: Final = "crash"
SHOWN_CRASHES: Final = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyState:
    """What of a study is done.

    Attributes:
        variants: Bridge variants.
        analyses: Analyses in all.
        done: Analyses with a row, whatever its status.
        failed: Those without a usable result.
        cpu_s: Processor time of the finished analyses.
        rungs: Analyses by the highest recovery rung they used.
        statuses: Analyses by status.
        suspect: Analyses that someone should look at.
        notes: What is to be said of lines of the journals that do not count, and of analyses that
            ended their workers.
    """

    variants: int
    analyses: int
    done: int
    failed: int
    cpu_s: float
    rungs: dict[int, int] = field(default_factory=dict[int, int])
    statuses: dict[str, int] = field(default_factory=dict[str, int])
    suspect: int = 0
    notes: tuple[str, ...] = ()

    @property
    def left(self) -> int:
        """Analyses still to run."""
        return self.analyses - self.done


def study_state(
    run_keys: Mapping[str, Sequence[str]], content: JournalContent, limits: SuspectLimits = LIMITS
) -> StudyState:
    """Count the finished analyses of a study.

    Args:
        run_keys: Keys of the analyses by variant name.
        content: What the journals of the study hold.
        limits: What is suspect.
    """
    found = content.rows
    rows = [found[key] for keys in run_keys.values() for key in keys if key in found]
    return StudyState(
        variants=len(run_keys),
        analyses=sum(len(keys) for keys in run_keys.values()),
        done=len(rows),
        failed=sum(row["status"] in FAILED for row in rows),
        cpu_s=sum(row["cpu_s"] for row in rows if row["cpu_s"] == row["cpu_s"]),
        rungs=_counts(row["recovery_rung"] for row in rows),
        statuses=_counts(row["status"] for row in rows),
        suspect=sum(bool(reasons(row, limits)) for row in rows),
        notes=(*content.sentences, *_crash_notes(rows)),
    )


class StudyProgress:
    """Shows the progress of one part of a study, which may be the whole.

    Args:
        state: What of the part was done when it began.
        name: Name of the part.
        run_keys: Its planned analyses by variant; what a search adds to them does not count.
    """

    def __init__(self, state: StudyState, name: str, run_keys: Mapping[str, Sequence[str]]) -> None:
        self._keys = frozenset(key for keys in run_keys.values() for key in keys)
        self._name = name
        self._state = state
        self._began_s = self._logged_s = time.monotonic()
        self._new = 0
        console = Console(stderr=True)
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task(name, total=state.analyses, completed=state.done, rate="")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()
        self._log()

    def advance(self, row: Mapping[str, Any]) -> None:
        """Count one finished analysis."""
        log_failure(row)
        if row["run_key"] in self._keys:
            self._new += 1
            self._bar.update(self._task, advance=1, rate=f"{self.rate_per_min:.1f}/min")
        if time.monotonic() - self._logged_s > LOG_INTERVAL_S:
            self._log()

    @property
    def rate_per_min(self) -> float:
        """Analyses per minute since the part began."""
        return self._new / max(time.monotonic() - self._began_s, 1e-9) * 60

    def _log(self) -> None:
        self._logged_s = time.monotonic()
        left = self._state.left - self._new
        eta = f", {left / self.rate_per_min:.0f} min left" if self._new and left else ""
        # a bar in a terminal says the same
        (progress_logger if self._bar.disable else logger).info(
            "%s: %d of %d analyses done%s%s%s",
            self._name,
            self._state.analyses - left,
            self._state.analyses,
            f" ({self._state.done} of them before)" if self._state.done else "",
            f", {self.rate_per_min:.1f} per minute" if self._new else "",
            eta,
        )


def log_failure(row: Mapping[str, Any]) -> None:
    """Warn of an analysis without a usable result, and say how to repeat it by itself."""
    if row["status"] in FAILED:
        logger.warning(failure_note(row))


def failure_note(row: Mapping[str, Any]) -> str:
    """Return what became of an analysis, and the command that repeats it by itself."""
    return (
        f"{row['variant']} under {row['motion_id']}: {row['status']} "
        f"({row['collapse_criterion']}); alone: {run_command(row)}"
    )


def run_command(row: Mapping[str, Any]) -> str:
    """Return the command that repeats one analysis by itself."""
    return f"skewbridge run --row {row['run_key']} --out row_{row['run_key']}"


def _crash_notes(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return what is to be said of analyses that ended or stopped their workers."""
    notes = [failure_note(row) for row in rows if row["status"] == CRASH]
    if len(notes) > SHOWN_CRASHES:
        notes[SHOWN_CRASHES:] = [f"and {len(notes) - SHOWN_CRASHES} more with status {CRASH}"]
    return [*notes, "`skewbridge study retry` lets the study try them again."] if notes else []


def _counts(values: Iterable[Any]) -> dict[Any, int]:
    return dict(sorted(Counter(values).items()))
