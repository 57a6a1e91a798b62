"""Outcome of each run for one demand and its limit states: exceeded, not exceeded or unknown.

A run that ended early is never dropped: its demand lies above its peak so far (right-censored). A
column failure decides only the states of its mode, a collapse those with `collapse: exceeds`. A
demand of zero (a wall that was not touched) lies below a small limit (left-censored).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.demands.completeness import (
    COLUMN_FAILURE_RATIO,
    FAILURE_DEMANDS,
    failure_kinds,
    is_beyond_model,
    is_complete,
)
from skewbridge.fragility.columns import Floats, Mask
from skewbridge.fragility.fits import ALL_EXCEED, FITTED, NO_EXCEEDANCE
from skewbridge.fragility.limit_states import COLLAPSE_EXCEEDS, LimitState, States
from skewbridge.fragility.lines import Lines, fit_lines
from skewbridge.statuses import COLLAPSE

#: Treatments of runs whose outcome is unknown, with their meaning.
TREATMENTS: Final = {
    "exclude": "with unknown outcomes left out",
    "all_exceed": "if all unknown outcomes exceed",
    "none_exceed": "if no unknown outcome exceeds",
}
# ASSUME where a demand is zero in some run (the deck did not reach a wall or key), demands below a
# tenth of the mildest state count only as small
_SMALL_SHARE: Final = 0.1
_MIN_RUNS: Final = 3


@dataclass(frozen=True, slots=True)
class DemandOutcomes:
    """Outcomes of n runs for one demand, arrays of shape (n,)."""

    lower: Floats  # lower end; 0 where left-censored, NaN where the run has no demand
    upper: Floats  # equal to ``lower`` where known, infinity where the run ended early
    complete: Mask  # whether the demand is a peak over the whole motion

    @property
    def used(self) -> Mask:
        """Runs with information about the demand, shape (n,)."""
        return np.isfinite(self.lower) & ((self.lower > 0.0) | np.isfinite(self.upper))

    def exceed(self, state: LimitState) -> Mask:
        """Return which runs are known to exceed a state, shape (n,)."""
        return np.nan_to_num(self.lower, nan=-np.inf) > state.threshold

    def unknown(self, state: LimitState) -> Mask:
        """Return which runs neither exceed a state nor are known not to exceed it, shape (n,)."""
        below = np.isfinite(self.upper) & (self.upper <= state.threshold)
        return ~self.exceed(state) & ~below

    def counts(self, state: LimitState) -> dict[str, int]:
        """Return the numbers of runs that exceed a state and of those with unknown outcome."""
        exceed, unknown = np.sum(self.exceed(state)), np.sum(self.unknown(state))
        return {"n_exceed": int(exceed), "n_unknown": int(unknown)}

    def status(self, state: LimitState) -> str:
        """Return whether a state can have a median: not if no run, or every run, exceeds it."""
        # ASSUME a study states no median that no run reached, or that every run passed
        exceed = self.exceed(state)
        if not np.any(exceed):
            return NO_EXCEEDANCE
        return ALL_EXCEED if np.all(exceed | self.unknown(state)) else FITTED

    @property
    def ln_ends(self) -> tuple[Floats, Floats]:
        """Logarithms of lower and upper ends of the runs in use."""
        with np.errstate(divide="ignore"):
            return np.log(self.lower[self.used]), np.log(self.upper[self.used])

    def lines(self, ln_im: Floats, weights: Floats) -> Lines:
        """Return the lines of ln demand on ln intensity (n,) for weights of the runs (R, n)."""
        used = self.used
        if np.sum(used) < _MIN_RUNS:
            return Lines.blank(weights.shape[0])
        return fit_lines(ln_im[used], *self.ln_ends, weights[:, used])

    def treated(self, state: LimitState, treatment: str) -> "DemandOutcomes":
        """Return the outcomes with the unknown ones excluded, or all, or none exceeding."""
        unknown, c = self.unknown(state), state.threshold
        lower, upper = {
            "exclude": (np.nan, self.upper),
            "all_exceed": (np.nextafter(c, np.inf), np.inf),
            "none_exceed": (np.minimum(np.nan_to_num(self.lower), c), c),
        }[treatment]
        ends = np.where(unknown, lower, self.lower), np.where(unknown, upper, self.upper)
        return DemandOutcomes(*ends, self.complete)


def end_counts(table: pd.DataFrame) -> dict[str, int]:
    """Return the number of collapsed runs and of those in which a column failed."""
    return {
        "n_collapse": int(np.sum(table["status"] == COLLAPSE)),
        "n_beyond_model": int(np.sum(is_beyond_model(table))),
    }


def demand_outcomes(table: pd.DataFrame, states: States) -> DemandOutcomes:
    """Return the outcomes of the runs of a table for the demand that some states share."""
    demand, complete = states[0].demand, is_complete(table)
    peak = table[demand].to_numpy(dtype=np.float64)
    decided = np.zeros(peak.size)
    exceeding = [s.threshold for s in states if s.collapse == COLLAPSE_EXCEEDS]
    if exceeding:
        # ASSUME a collapsed bridge exceeds every limit state without `collapse: peak`
        collapsed = (table["status"] == COLLAPSE).to_numpy(dtype=np.bool_)
        decided[collapsed & ~complete] = np.nextafter(max(exceeding), np.inf)
    # ASSUME a column that failed has passed the states of its own mode at 1 and above
    failed = [s.threshold for s in states if s.threshold >= 1.0]
    names = FAILURE_DEMANDS.items()
    modes = [kind for kind, name in names if demand in (name, COLUMN_FAILURE_RATIO)]
    if failed and modes:
        decided[np.isin(failure_kinds(table), modes)] = np.nextafter(max(failed), np.inf)
    lower = np.where(complete, peak, np.maximum(np.nan_to_num(peak), decided))
    upper = np.where(complete, peak, np.inf)
    if np.any(complete & (peak == 0.0)):
        positive, mildest = peak[complete & (peak > 0.0)], min(s.threshold for s in states)
        limit = min(max(np.min(positive, initial=np.inf), _SMALL_SHARE * mildest), mildest)
        small = complete & (peak < limit)
        lower, upper = np.where(small, 0.0, lower), np.where(small, limit, upper)
    return DemandOutcomes(lower, upper, complete)


def states_by_demand(states: States) -> dict[tuple[str, str], list[LimitState]]:
    """Return the states of each component and demand by rising threshold."""
    groups: dict[tuple[str, str], list[LimitState]] = {}
    for state in sorted(states, key=lambda state: state.threshold):
        groups.setdefault((state.component, state.demand), []).append(state)
    return {key: groups[key] for key in ((state.component, state.demand) for state in states)}
