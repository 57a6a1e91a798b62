"""Outcome of each run for one demand and its limit states: exceeded, not exceeded or unknown.

A run that ended early is never dropped: its demand is at least the peak it reached (right-
censored). A column failure determines only the states of its own failure mode; a collapse
determines only states with `collapse: exceeds`. If a demand is zero in some run (wall not touched),
small demands are known only to lie below a limit (left-censored).
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.demands import validity
from skewbridge.files.tables import Floats, Index, Mask
from skewbridge.fragility.fits import ALL_EXCEED, FITTED, NO_EXCEEDANCE
from skewbridge.fragility.limit_states import COLLAPSE_EXCEEDS, LimitState, States
from skewbridge.statuses import COLLAPSE

#: Treatments of unknown outcomes.
TREATMENTS: Final[tuple[str, ...]] = ("all_exceed", "none_exceed")
# ASSUME if a demand is zero in some run (the deck did not reach a wall or key), demands below a
# tenth of the mildest threshold are left-censored at that limit
_SMALL_SHARE: Final = 0.1


@dataclass(frozen=True, slots=True)
class DemandOutcomes:
    """Bounds of one demand in n runs, arrays of shape (n,)."""

    lower: Floats  # lower bound; 0 if left-censored, NaN if a complete run has no demand
    upper: Floats  # equal to ``lower`` if known, infinity if the run ended early
    complete: Mask  # True if the demand is a peak over the whole motion

    @property
    def used(self) -> Mask:
        """Runs that the fit of the demand model uses, shape (n,)."""
        return np.isfinite(self.lower) & ((self.lower > 0.0) | np.isfinite(self.upper))

    @property
    def is_bound(self) -> Mask:
        """Used runs whose demand is only a bound, shape (n,)."""
        return self.used & (self.lower != self.upper)

    def of(self, rows: Index) -> "DemandOutcomes":
        """Return the outcomes of the runs with these numbers."""
        return DemandOutcomes(self.lower[rows], self.upper[rows], self.complete[rows])

    def exceed(self, state: LimitState) -> Mask:
        """Return True for runs known to exceed a state, shape (n,)."""
        return np.nan_to_num(self.lower, nan=-np.inf) > state.threshold

    def unknown(self, state: LimitState) -> Mask:
        """Return True for runs that may or may not exceed a state, shape (n,)."""
        is_below = np.isfinite(self.upper) & (self.upper <= state.threshold)
        return ~self.exceed(state) & ~is_below

    def counts(self, state: LimitState) -> dict[str, int]:
        """Return the number of runs known to exceed a state and of runs with unknown outcome."""
        n_exceed, unknown = np.sum(self.exceed(state)), np.sum(self.unknown(state))
        return {"n_exceed": int(n_exceed), "n_unknown": int(unknown)}

    def status(self, state: LimitState) -> str:
        """Return ``ok``, or why a state has no median: no run, or every known run, exceeds it."""
        # ASSUME no median is estimated for a state that no run, or every known run, exceeds
        exceed = self.exceed(state)
        if not np.any(exceed):
            return NO_EXCEEDANCE
        return ALL_EXCEED if np.all(exceed | self.unknown(state)) else FITTED

    def treated(
        self, state: LimitState, treatment: str, where: Mask | bool = True
    ) -> "DemandOutcomes":
        """Return the outcomes after applying one of `TREATMENTS` to the unknown ones ``where``."""
        unknown, limit = self.unknown(state) & where, state.threshold
        lower, upper = {
            "all_exceed": (np.nextafter(limit, np.inf), np.inf),
            "none_exceed": (np.minimum(np.nan_to_num(self.lower), limit), limit),
        }[treatment]
        pair = np.where(unknown, lower, self.lower), np.where(unknown, upper, self.upper)
        return replace(self, lower=pair[0], upper=pair[1])

    def of_peaks(self, peaks: pd.Series, rows: Mask, *, exact: bool) -> "DemandOutcomes":
        """Return the outcomes with ``peaks`` of ``rows`` as exact demands, or as lower bounds."""
        rows = rows & np.isposinf(self.upper)
        if exact:
            return replace(self, upper=np.where(rows & (self.lower > 0.0), self.lower, self.upper))
        known_peaks = np.nan_to_num(peaks.to_numpy(dtype=np.float64), posinf=0.0)
        return replace(self, lower=np.where(rows, known_peaks, self.lower))


def collapsed_runs(table: pd.DataFrame) -> Mask:
    """Return a mask of the runs that collapsed, shape (n,).

    A collapse after the failure of a column decides nothing: the model is not valid after it.
    """
    return (table["status"] == COLLAPSE).to_numpy() & ~validity.is_beyond_model(table)


def demand_outcomes(table: pd.DataFrame, states: States) -> DemandOutcomes:
    """Return the outcomes of all runs of a table for the demand that ``states`` share."""
    demand = states[0].demand
    complete = validity.is_complete(table)
    peak = table[demand].to_numpy(dtype=np.float64)
    minimum = np.zeros(peak.size)
    collapse_thresholds = [s.threshold for s in states if s.collapse == COLLAPSE_EXCEEDS]
    if collapse_thresholds:
        # ASSUME a collapsed bridge exceeds every limit state without `collapse: peak`
        minimum[collapsed_runs(table) & ~complete] = np.nextafter(max(collapse_thresholds), np.inf)
    # ASSUME a failed column has exceeded all states of its own mode with a threshold of at least 1
    passed = [s.threshold for s in states if s.threshold >= 1.0]
    names = validity.FAILURE_DEMANDS.items()
    modes = [kind for kind, name in names if demand in (name, validity.COLUMN_FAILURE_RATIO)]
    if passed and modes:
        minimum[np.isin(validity.failure_kinds(table), modes)] = np.nextafter(max(passed), np.inf)
    lower = np.where(complete, peak, np.maximum(np.nan_to_num(peak, posinf=0.0), minimum))
    upper = np.where(complete, peak, np.inf)
    if np.any(complete & (peak == 0.0)):
        positive, mildest = peak[complete & (peak > 0.0)], min(s.threshold for s in states)
        limit = min(max(np.min(positive, initial=np.inf), _SMALL_SHARE * mildest), mildest)
        is_small = complete & (peak < limit)
        lower, upper = np.where(is_small, 0.0, lower), np.where(is_small, limit, upper)
    return DemandOutcomes(lower, upper, complete)


def outcomes_by_state(table: pd.DataFrame, states: States) -> dict[LimitState, DemandOutcomes]:
    """Return the outcomes of all runs of a table for each state."""
    groups = states_by_demand(states).values()
    outcomes = [(group, demand_outcomes(table, group)) for group in groups]
    return {state: outcome for group, outcome in outcomes for state in group}


def states_by_demand(states: States) -> dict[tuple[str, str], list[LimitState]]:
    """Group states by component and demand; each list is sorted by increasing threshold."""
    groups: dict[tuple[str, str], list[LimitState]] = {}
    for state in sorted(states, key=lambda state: state.threshold):
        groups.setdefault((state.component, state.demand), []).append(state)
    return {key: groups[key] for key in ((state.component, state.demand) for state in states)}
