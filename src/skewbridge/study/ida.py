"""Incremental dynamic analysis: a search for the capacity of each motion."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isclose, sqrt
from pathlib import Path
from typing import Final

from skewbridge.demands.completeness import BEYOND_MODEL, completed
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import LEVEL_MEASURE, bracket_capacity
from skewbridge.motions.record import SuiteMotion
from skewbridge.study.batch import Row, analysed_row, row_of_task
from skewbridge.study.journal import open_journal
from skewbridge.study.task import Task, run_key

#: Time that a worker waits while other workers write to the journal.
_PATIENCE_S: Final = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Target of an IDA (demand and its limit) and the range of Sa_avg tried, in g."""

    demand: str
    threshold: float
    low_g: float
    high_g: float

    def limits(self, motion: SuiteMotion) -> tuple[float, float]:
        """Return the factors of the lowest and highest level."""
        at_1_g = motion.measures[LEVEL_MEASURE] / motion.scale
        return self.low_g / at_1_g, self.high_g / at_1_g

    def first_factor(self, motion: SuiteMotion) -> float:
        """Return the first factor of the search."""
        low, high = self.limits(motion)
        return sqrt(low * high)

    def exceeds(self, row: Row) -> bool:
        """Return whether an analysis exceeds the limit; a failed or incomplete one does as well.

        The search then continues at lower levels, where the model is valid.
        """
        is_complete = completed(row["status"], row.get(BEYOND_MODEL) or "")
        return bool(not is_complete or row[self.demand] >= self.threshold)


def search_capacity(
    search: Search,
    done: Mapping[str, Row],
    journal: Path,
    task: Task,
    first_key: str,
    log_folder: Path,
) -> list[Row]:
    """Return the rows of all analyses that bracket the capacity of one motion.

    Those in `done`, by `run_key`, are not repeated. Each further one is written to the journal at
    once, so that a killed search can resume. The batch gives the first task with its key, and
    writes its row, which marks the search as done.
    """
    rows: list[Row] = []

    def exceeds(factor: float) -> bool:
        # rounding in the first factor must not give the first analysis another key
        is_first = isclose(factor, task.motion.scale, rel_tol=1e-12)
        trial = task if is_first else at_factor(task, factor)
        key = run_key(trial)
        if key in done:
            row = row_of_task(done[key], trial, key)
        else:
            row = analysed_row(trial, key, log_folder)
            if key != first_key:
                with open_journal(journal, _PATIENCE_S) as lines:
                    lines.append(row)
        rows.append(row)
        return search.exceeds(row)

    bracket_capacity(exceeds, limits=search.limits(task.motion))
    return rows


def at_factor(task: Task, factor: float) -> Task:
    """Return an analysis with another factor of its motion."""
    motion = task.motion
    measures = scaled_measures(motion.measures, factor / motion.scale)
    return replace(task, motion=replace(motion, scale=factor, measures=measures))
