"""Paired effects on median capacities: ratios of theta with the motions drawn jointly."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.fragility.likelihood.bootstrap import record_weights, student_reach
from skewbridge.fragility.likelihood.fit import exp_end
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL
from skewbridge.fragility.tables.effects import effect_table
from skewbridge.fragility.tables.key_columns import motion_codes
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import (
    CensoredDemands,
    Outcomes,
    check_demands,
    outcomes_of,
)
from skewbridge.fragility.tables.paired_runs import (
    ended_apart,
    pair_counts,
    pair_groups,
)
from skewbridge.fragility.tables.variant_cloud import refit_censored

_MIN_MOTIONS: Final = 5


def paired_capacity_effects(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return the paired ratios of the cloud median theta along every axis of a study.

    theta of both variants is fitted to the same motions; a bootstrap replicate draws motions once
    for both, so that what the motions share cancels in the ratio. Runs that collapsed, failed or
    went beyond the model are demands known only to exceed a value (Tobit). A limit state that no
    run of one of the variants is known to exceed (or every run) has no ratio.

    Returns:
        Rows with the columns of `effect_columns`, scope ``variant``.

    Raises:
        InputError: A column is missing or a value unusable.
    """
    columns = list(dict.fromkeys(state.demand for state in limit_states))
    check_demands(demands, im_column, columns)
    rows: list[dict[str, Any]] = []
    for pair, part in pair_groups(demands, [*columns, im_column]):
        for state in limit_states:
            effect = capacity_ratio(part, state, im_column, settings)
            if effect is not None:
                name = f"{state.component}/{state.name}"
                rows.append(pair | {"demand": name, "quantity": "median_capacity"} | effect)
    return effect_table(demands, rows)


def capacity_ratio(
    part: pd.DataFrame, state: LimitState, im_column: str, settings: FitSettings
) -> dict[str, Any] | None:
    """Return ratio of medians and interval of some pairs, or None where a side has no median.

    Args:
        part: Pairs of `run_pairs` of one pair of variants, with the demand and the intensity.
        state: The limit state.
        im_column: The intensity.
        settings: Level, margin, bootstrap.
    """
    ends = {name: _End.of(part, name, state, im_column) for name in ("to", "from")}
    usable = ends["to"].usable & ends["from"].usable
    for end in ends.values():
        known = end.outcomes.exceed[usable]
        if not np.any(known) or np.all(known):
            return None
    motions = motion_codes(part[usable])
    count = int(np.unique(motions).size)
    if count < _MIN_MOTIONS:
        return None
    weights = record_weights(motions, settings.bootstrap, settings.seed)
    weights = np.vstack([np.ones(motions.size), weights])
    theta = {name: end.medians(usable, state.threshold, weights) for name, end in ends.items()}
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = theta["to"] / theta["from"]
        logs = np.log(ratio)
    if not np.isfinite(logs[0]):
        return None
    reach = exp_end(student_reach(logs[1:], count, settings.effect_confidence))
    low, high = (float(ratio[0]) / reach, float(ratio[0]) * reach)
    return {
        "ratio": float(ratio[0]),
        "from_mean": float(theta["from"][0]),
        "ci_low": low if np.isfinite(reach) else nan,
        "ci_high": high if np.isfinite(reach) else nan,
        "level": settings.effect_confidence,
        "margin": settings.margin,
        "n_motions": count,
        "n_discordant": int(np.sum(ended_apart(part) & ~usable)),
        **pair_counts(part, usable),
    }


@dataclass(frozen=True, slots=True)
class _End:
    """One side of the pairs, arrays of shape (n,): intensities, outcomes, demands of a line.

    ``usable`` are the runs that left a positive demand.
    """

    im: FloatArray
    outcomes: Outcomes
    data: CensoredDemands
    usable: NDArray[np.bool_]

    @classmethod
    def of(cls, part: pd.DataFrame, name: str, state: LimitState, im_column: str) -> "_End":
        """Return the side ``to`` or ``from`` of a table of pairs."""
        demand = part[f"{state.demand}_{name}"].to_numpy(dtype=np.float64)
        outcomes = outcomes_of(
            demand,
            part[f"status_{name}"].to_numpy(dtype=str),
            part[f"{BEYOND_MODEL}_{name}"].to_numpy(dtype=np.bool_),
            state,
        )
        data = outcomes.censored(state.threshold)
        im = part[f"{im_column}_{name}"].to_numpy(dtype=np.float64)
        return cls(im, outcomes, data, data.used)

    def medians(
        self, usable: NDArray[np.bool_], threshold: float, weights: FloatArray
    ) -> FloatArray:
        """Return the medians of the weighted replicates, the data first; NaN without a line."""
        complete = self.outcomes.complete & usable
        if np.sum(complete) < _MIN_MOTIONS or np.ptp(self.im[complete]) == 0.0:
            return np.full(weights.shape[0], nan)
        kept = CensoredDemands(self.data.lower[usable], self.data.upper[usable], usable[usable])
        return refit_censored(self.im[usable], kept, threshold, weights).theta
