"""Outcome of each run for one demand and its limit states: exceeded, not exceeded or unknown.

A run that ended early is never dropped: its demand lies above its peak so far (right-censored). A
column failure decides only the states of its mode, a collapse those with `collapse: exceeds`. A
demand of zero (a wall that was not touched) lies below a small limit (left-censored).
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.demands import validity
from skewbridge.files.tables import Floats, Mask
from skewbridge.fragility.fits import ALL_EXCEED, FITTED, NO_EXCEEDANCE
from skewbridge.fragility.limit_states import COLLAPSE_EXCEEDS, LimitState, States
from skewbridge.fragility.lines import Lines, fit_lines
from skewbridge.statuses import COLLAPSE

#: Treatments of unknown outcomes: left out, all exceeding, none exceeding.
TREATMENTS: Final[tuple[str, ...]] = ("exclude", "all_exceed", "none_exceed")
# ASSUME where a demand is zero in some run (the deck did not reach a wall or key), demands below a
# tenth of the mildest state count only as small
_SMALL_SHARE: Final = 0.1


@dataclass(frozen=True, slots=True)
class DemandOutcomes:
    """Outcomes of n runs for one demand, arrays of shape (n,)."""

    lower: Floats  # lower end; 0 where left-censored, NaN where the run has no demand
    upper: Floats  # equal to ``lower`` where known, infinity where the run ended early
    complete: Mask  # whether the demand is a peak over the whole motion
    demand: str  # column of the demands table
    governing: "DemandOutcomes | None" = None  # of the mode of failure whose line applies

    @property
    def behind_line(self) -> "DemandOutcomes":
        """Outcomes through which the line goes: these, or those of the governing mode."""
        return self if self.governing is None else self.governing

    @property
    def used(self) -> Mask:
        """Runs with information about the line, shape (n,)."""
        lower, upper = self.behind_line.lower, self.behind_line.upper
        return np.isfinite(lower) & ((lower > 0.0) | np.isfinite(upper))

    @property
    def is_bound(self) -> Mask:
        """Runs in use whose demand is only a bound, shape (n,)."""
        return self.used & (self.behind_line.lower != self.behind_line.upper)

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
        used, data = self.used, self.behind_line
        with np.errstate(divide="ignore"):
            return np.log(data.lower[used]), np.log(data.upper[used])

    def lines(self, ln_im: Floats, weights: Floats) -> Lines:
        """Return the lines of ln demand on ln intensity (n,) for weights of the runs (R, n)."""
        used = self.used
        return fit_lines(ln_im[used], *self.ln_ends, weights[:, used])

    def treated(self, state: LimitState, treatment: str) -> "DemandOutcomes":
        """Return the outcomes with the unknown ones excluded, or all, or none exceeding."""
        unknown, c = self.unknown(state), state.threshold

        def changed(data: "DemandOutcomes") -> "DemandOutcomes":
            lower, upper = {
                "exclude": (np.nan, data.upper),
                "all_exceed": (np.nextafter(c, np.inf), np.inf),
                "none_exceed": (np.minimum(np.nan_to_num(data.lower), c), c),
            }[treatment]
            ends = np.where(unknown, lower, data.lower), np.where(unknown, upper, data.upper)
            return replace(data, lower=ends[0], upper=ends[1])

        governing = None if self.governing is None else changed(self.governing)
        return replace(changed(self), governing=governing)


def end_counts(table: pd.DataFrame) -> dict[str, int]:
    """Return the number of collapsed runs and of those in which a column failed."""
    return {
        "n_collapse": int(np.sum(table["status"] == COLLAPSE)),
        "n_beyond_model": int(np.sum(validity.is_beyond_model(table))),
    }


def demand_outcomes(table: pd.DataFrame, states: States, im: str | None = None) -> DemandOutcomes:
    """Return the outcomes of the runs of a table for the demand that some states share.

    Given the intensity measure, the line of a failure of a column in any mode is that of the mode
    with the smallest median, unless the line of the larger demand over capacity has a smaller one.
    """
    demand, state = states[0].demand, states[0]
    outcomes = _outcomes(table, states, demand)
    if im is None or demand != validity.COLUMN_FAILURE_RATIO:
        return outcomes
    # the larger of a ratio that saturates and one that grows follows no line: a line through all
    # of it can put the failure in any mode above that in one mode
    modes = [name for name in validity.FAILURE_DEMANDS.values() if name in table]
    data = [outcomes, *(_outcomes(table, states, name) for name in modes)]
    data = [each for each in data if each.status(state) == FITTED]
    ln_im, one = np.log(table[im].to_numpy(dtype=np.float64)), np.ones((1, len(table)))
    medians = [each.lines(ln_im, one).ln_theta(state.threshold)[0] for each in data]
    order = np.argsort(medians, kind="stable")  # NaN last
    weakest = data[order[0]] if data else outcomes
    return outcomes if weakest is outcomes else replace(outcomes, governing=weakest)


def _outcomes(table: pd.DataFrame, states: States, demand: str) -> DemandOutcomes:
    """Return the outcomes of the runs for one demand and the capacities of some states."""
    complete = validity.is_complete(table)
    peak = table[demand].to_numpy(dtype=np.float64)
    decided = np.zeros(peak.size)
    exceeding = [s.threshold for s in states if s.collapse == COLLAPSE_EXCEEDS]
    if exceeding:
        # ASSUME a collapsed bridge exceeds every limit state without `collapse: peak`
        collapsed = (table["status"] == COLLAPSE).to_numpy(dtype=np.bool_)
        decided[collapsed & ~complete] = np.nextafter(max(exceeding), np.inf)
    # ASSUME a column that failed has passed the states of its own mode at 1 and above
    failed = [s.threshold for s in states if s.threshold >= 1.0]
    names = validity.FAILURE_DEMANDS.items()
    modes = [kind for kind, name in names if demand in (name, validity.COLUMN_FAILURE_RATIO)]
    if failed and modes:
        decided[np.isin(validity.failure_kinds(table), modes)] = np.nextafter(max(failed), np.inf)
    lower = np.where(complete, peak, np.maximum(np.nan_to_num(peak), decided))
    upper = np.where(complete, peak, np.inf)
    if np.any(complete & (peak == 0.0)):
        positive, mildest = peak[complete & (peak > 0.0)], min(s.threshold for s in states)
        limit = min(max(np.min(positive, initial=np.inf), _SMALL_SHARE * mildest), mildest)
        small = complete & (peak < limit)
        lower, upper = np.where(small, 0.0, lower), np.where(small, limit, upper)
    return DemandOutcomes(lower, upper, complete, demand)


def states_by_demand(states: States) -> dict[tuple[str, str], list[LimitState]]:
    """Return the states of each component and demand by rising threshold."""
    groups: dict[tuple[str, str], list[LimitState]] = {}
    for state in sorted(states, key=lambda state: state.threshold):
        groups.setdefault((state.component, state.demand), []).append(state)
    return {key: groups[key] for key in ((state.component, state.demand) for state in states)}
