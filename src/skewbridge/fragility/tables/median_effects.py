"""Paired effects on median capacities: ratios of theta with the motions drawn jointly."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from math import nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.fragility.old_likelihood.bootstrap import shared_weights, student_reach
from skewbridge.fragility.old_likelihood.fit import exp_end
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.effects import effect_table
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import (
    CensoredDemands,
    Outcomes,
    check_demands,
    outcomes_of,
)
from skewbridge.fragility.tables.paired_runs import (
    PairFacts,
    ends_of,
    pair_groups,
)
from skewbridge.fragility.tables.spread import spread
from skewbridge.fragility.tables.variant_cloud import refit_censored

_MIN_MOTIONS: Final = 5


def paired_capacity_effects(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the paired ratios of the cloud median theta along every axis of a study.

    theta of both variants is fitted to the same motions; a bootstrap replicate draws motions once
    for both, so that what the motions share cancels in the ratio. Runs that collapsed, failed or
    went beyond the model are demands known only to exceed a value (Tobit). A limit state that no
    run of one of the variants is known to exceed (or every run) has no ratio.
    ``jobs`` is the number of processes.

    Returns:
        Rows with the columns of `effect_columns`, scope ``variant``.

    Raises:
        InputError: A column is missing or a value unusable.
    """
    columns = list(dict.fromkeys(state.demand for state in limit_states))
    check_demands(demands, im_column, columns)
    found = spread(
        partial(_pair_rows, states=limit_states, im_column=im_column, settings=settings),
        pair_groups(demands, [*columns, im_column]),
        jobs,
    )
    return effect_table(demands, [row for rows in found for row in rows])


def _pair_rows(
    group: tuple[dict[str, Any], pd.DataFrame],
    *,
    states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings,
) -> list[dict[str, Any]]:
    """Return the rows of all limit states of one pair of variants."""
    pair, part = group
    facts, im = PairFacts.of(part), ends_of(part, im_column)
    rows: list[dict[str, Any]] = []
    for state in states:
        effect = _ratio(facts, part, im, state, settings)
        if effect is not None:
            name = f"{state.component}/{state.name}"
            rows.append(pair | {"demand": name, "quantity": "median_capacity"} | effect)
    return rows


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
    return _ratio(PairFacts.of(part), part, ends_of(part, im_column), state, settings)


def _ratio(
    facts: PairFacts,
    part: pd.DataFrame,
    im: tuple[FloatArray, FloatArray],
    state: LimitState,
    settings: FitSettings,
) -> dict[str, Any] | None:
    top, bottom = ends_of(part, state.demand)
    ends = {
        "to": _End.of(top, im[0], (facts.status_to, facts.beyond_to), state),
        "from": _End.of(bottom, im[1], (facts.status_from, facts.beyond_from), state),
    }
    usable = ends["to"].usable & ends["from"].usable
    for end in ends.values():
        known = end.outcomes.exceed[usable]
        if not np.any(known) or np.all(known):
            return None
    motions = facts.motions[usable]
    count = int(np.unique(motions).size)
    if count < _MIN_MOTIONS:
        return None
    drawn = _Drawn(motions.tobytes(), settings.bootstrap, settings.seed)
    theta = {name: end.medians(usable, state.threshold, drawn) for name, end in ends.items()}
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
        "n_discordant": int(np.sum(facts.apart & ~usable)),
        **facts.counts(usable),
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
    def of(
        cls,
        demand: FloatArray,
        im: FloatArray,
        became: tuple[NDArray[np.str_], NDArray[np.bool_]],
        state: LimitState,
    ) -> "_End":
        """Return one side of the pairs; ``became`` are status and beyond_model of its runs."""
        outcomes = outcomes_of(demand, *became, state)
        data = outcomes.censored(state.threshold)
        return cls(im, outcomes, data, data.used)

    def medians(self, usable: NDArray[np.bool_], threshold: float, drawn: "_Drawn") -> FloatArray:
        """Return the medians of the weighted replicates, the data first; NaN without a line."""
        complete = self.outcomes.complete & usable
        if np.sum(complete) < _MIN_MOTIONS or np.ptp(self.im[complete]) == 0.0:
            return np.full(1 + drawn.replicates, nan)
        columns = np.stack([self.im, self.data.lower, self.data.upper])[:, usable]
        return _medians(columns.tobytes(), threshold, drawn)


class _Drawn(NamedTuple):
    """The motions of the runs, as bytes, and how they are drawn."""

    motions: bytes
    replicates: int
    seed: int


@lru_cache(maxsize=8192)  # a variant is in several pairs; 80 MB with 1000 replicates
def _medians(columns: bytes, threshold: float, drawn: _Drawn) -> FloatArray:
    """Return the medians of runs told by their intensities, lower and upper demands."""
    im, lower, upper = np.frombuffer(columns).reshape(3, -1)
    motions = np.frombuffer(drawn.motions, dtype=np.intp)
    weights = shared_weights(motions, drawn.replicates, drawn.seed)
    data = CensoredDemands(lower, upper, np.ones(im.size, dtype=np.bool_))
    return refit_censored(im, data, threshold, weights).theta
