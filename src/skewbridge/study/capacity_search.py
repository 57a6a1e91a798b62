"""Incremental dynamic analysis: a search per motion instead of given factors."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Final

from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import bracket_capacity
from skewbridge.motions.record import SuiteMotion
from skewbridge.statuses import OK
from skewbridge.study.keys import run_key
from skewbridge.study.task import Task
from skewbridge.study.worker import Desk, Row, analysed_row, of_task

SEARCH_IM: Final = "im_saavg_rotd50_g"


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """What an incremental dynamic analysis looks for.

    Attributes:
        demand: Column of the demands table.
        threshold: Its limit; a collapse exceeds it whatever the demand.
        low_g: Lowest Sa_avg tried.
        high_g: Highest Sa_avg tried.
    """

    demand: str
    threshold: float
    low_g: float
    high_g: float

    def limits(self, motion: SuiteMotion) -> tuple[float, float]:
        """Return the factors of the lowest and highest level."""
        at_1_g = motion.measures[SEARCH_IM] / motion.scale
        return self.low_g / at_1_g, self.high_g / at_1_g

    def first_factor(self, motion: SuiteMotion) -> float:
        """Return the factor that the search begins with."""
        low, high = self.limits(motion)
        return sqrt(low * high)

    def exceeds(self, row: Row) -> bool:
        """Return whether an analysis exceeds the limit.

        A collapse does, and so does an analysis without a usable end or beyond the model: the
        search then goes on at lower levels, where it can be believed, and the fit sees the row with
        its own status.
        """
        is_complete = row["status"] == OK and not row.get(BEYOND_MODEL)
        return not is_complete or bool(row[self.demand] >= self.threshold)


def search_capacity(
    search: Search, known: Mapping[str, Row], task: Task, _key: str, desk: Desk
) -> list[Row]:
    """Return the rows of all analyses that it took to bracket the capacity of one motion.

    Args:
        search: What to look for.
        known: Rows of earlier analyses by `run_key`; they are not repeated.
        task: The first analysis of the search; this and what follows is given by the batch.
        desk: Where messages and signs of life go.
    """
    rows: list[Row] = []

    def exceeds(factor: float) -> bool:
        trial = _at(task, factor)
        key = run_key(trial)
        found = known.get(key)
        row = analysed_row(trial, key, desk) if found is None else of_task(found, trial, key)
        rows.append(row)
        return search.exceeds(row)

    bracket_capacity(exceeds, limits=search.limits(task.motion))
    return rows


def _at(task: Task, factor: float) -> Task:
    motion = task.motion
    measures = scaled_measures(motion.measures, factor / motion.scale)
    return replace(task, motion=replace(motion, scale=factor, measures=measures))
