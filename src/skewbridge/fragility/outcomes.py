"""Outcome of each run for one demand and its limit states: exceeded, not exceeded or unknown.

A run that ended early is never dropped: its demand lies above its peak so far (right-censored). A
column failure decides only the states of its own mode, a collapse the states that say so. A demand
of zero (a wall that was not touched) lies below a small limit (left-censored).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.demands.completeness import failure_kinds, is_complete
from skewbridge.fragility.columns import FloatArray
from skewbridge.fragility.limit_states import (
    ANY_FAILURE_DEMAND,
    COLLAPSE_EXCEEDS,
    FAILURE_DEMANDS,
    LimitState,
)
from skewbridge.statuses import COLLAPSE

#: Treatments of runs whose outcome is unknown.
TREATMENTS: Final[tuple[str, ...]] = ("exclude", "all_exceed", "none_exceed")
# ASSUME where a demand is zero in some run (the deck did not reach a wall or key), demands below a
# tenth of the mildest state say only that they are small
_SMALL_SHARE: Final = 0.1


@dataclass(frozen=True, slots=True)
class DemandOutcomes:
    """Outcomes of n runs for one demand, arrays of shape (n,).

    Attributes:
        lower: Lower end of the demand; 0 where left-censored, NaN where the run has no demand.
        upper: Upper end; equal to ``lower`` where the demand is known, infinity where the run ended
            early.
        complete: Whether the demand is a peak over the whole motion.
    """

    lower: FloatArray
    upper: FloatArray
    complete: NDArray[np.bool_]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Runs that say something about the demand, shape (n,)."""
        return np.isfinite(self.lower) & ((self.lower > 0.0) | np.isfinite(self.upper))

    def exceed(self, state: LimitState) -> NDArray[np.bool_]:
        """Return which runs are known to exceed a state, shape (n,)."""
        return np.nan_to_num(self.lower, nan=-np.inf) > state.threshold

    def unknown(self, state: LimitState) -> NDArray[np.bool_]:
        """Return which runs neither exceed a state nor are known not to exceed it, shape (n,)."""
        below = np.isfinite(self.upper) & (self.upper <= state.threshold)
        return ~self.exceed(state) & ~below

    def treated(self, state: LimitState, treatment: str) -> "DemandOutcomes":
        """Return the outcomes with the unknown ones excluded, or all, or none exceeding."""
        unknown, c = self.unknown(state), state.threshold
        if treatment == "exclude":
            return replace(self, lower=np.where(unknown, np.nan, self.lower))
        lower = np.nan_to_num(self.lower, nan=0.0)
        if treatment == "all_exceed":
            return replace(
                self,
                lower=np.where(unknown, np.nextafter(c, np.inf), self.lower),
                upper=np.where(unknown, np.inf, self.upper),
            )
        return replace(
            self,
            lower=np.where(unknown, np.minimum(lower, c), self.lower),
            upper=np.where(unknown, c, self.upper),
        )


def demand_outcomes(table: pd.DataFrame, states: Sequence[LimitState]) -> DemandOutcomes:
    """Return the outcomes of the runs of one variant for the demand that some states share."""
    demand = states[0].demand
    peak = table[demand].to_numpy(dtype=np.float64)
    complete = is_complete(table)
    decided = np.zeros(peak.size)
    exceeding = [s.threshold for s in states if s.collapse == COLLAPSE_EXCEEDS]
    if exceeding:
        # ASSUME a collapsed bridge exceeds every limit state that does not say `collapse: peak`
        collapsed = (table["status"] == COLLAPSE).to_numpy() & ~complete
        decided = np.where(collapsed, np.nextafter(max(exceeding), np.inf), decided)
    # ASSUME a column that failed has passed the states of its own mode at 1 and above
    failed = [s.threshold for s in states if s.threshold >= 1.0]
    kinds = failure_kinds(table)
    modes = [kind for kind, name in FAILURE_DEMANDS.items() if name == demand]
    if demand == ANY_FAILURE_DEMAND:
        modes = list(FAILURE_DEMANDS)
    if failed and modes:
        of_mode = np.isin(kinds, modes)
        decided = np.where(of_mode, np.nextafter(max(failed), np.inf), decided)
    lower = np.where(complete, peak, np.maximum(np.nan_to_num(peak, nan=0.0), decided))
    upper = np.where(complete, peak, np.inf)
    if np.any(complete & (peak == 0.0)):
        positive, mildest = peak[complete & (peak > 0.0)], min(s.threshold for s in states)
        limit = max(float(np.min(positive, initial=np.inf)), _SMALL_SHARE * mildest)
        limit = min(limit, mildest)
        small = complete & (peak < limit)
        lower, upper = np.where(small, 0.0, lower), np.where(small, limit, upper)
    return DemandOutcomes(lower, upper, complete)


def states_by_demand(states: Sequence[LimitState]) -> dict[tuple[str, str], list[LimitState]]:
    """Return the states of each component and demand by rising threshold."""
    groups: dict[tuple[str, str], list[LimitState]] = {}
    for state in sorted(states, key=lambda state: state.threshold):
        groups.setdefault((state.component, state.demand), []).append(state)
    order = dict.fromkeys((state.component, state.demand) for state in states)
    return {key: groups[key] for key in order}
