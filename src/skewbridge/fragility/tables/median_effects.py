"""Paired effects on median capacities: ratios of theta with the motions drawn jointly."""

from collections.abc import Sequence
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_lines
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.effects import effect_table
from skewbridge.fragility.tables.key_columns import motion_codes
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import check_demands
from skewbridge.fragility.tables.paired_runs import (
    ended_apart,
    pair_counts,
    pair_groups,
    usable_pairs,
)

_MIN_MOTIONS: Final = 5


def paired_capacity_effects(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return the paired ratios of the cloud median theta along every axis of a study.

    theta of both variants is fitted to the same motions; a bootstrap replicate draws motions once
    for both, so that what the motions share cancels in the ratio. A limit state that no run of
    one of the variants exceeds (or every run) has no ratio.

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
            effect = _ratio(part, state, im_column, settings)
            if effect is not None:
                name = f"{state.component}/{state.name}"
                rows.append(pair | {"demand": name, "quantity": "median_capacity"} | effect)
    return effect_table(demands, rows)


def _ratio(
    part: pd.DataFrame, state: LimitState, im_column: str, settings: FitSettings
) -> dict[str, Any] | None:
    """Return ratio and interval, or None where a variant has no median."""
    top, bottom, usable = usable_pairs(part, state.demand)
    ends = {"to": top, "from": bottom}
    for values in ends.values():
        above = values[usable] > state.threshold
        if not np.any(above) or np.all(above):
            return None
    motions = motion_codes(part[usable])
    if np.unique(motions).size < _MIN_MOTIONS:
        return None
    x = np.log(part[f"{im_column}_to"].to_numpy(dtype=np.float64)[usable])
    weights = record_weights(motions, settings.bootstrap, settings.seed)
    weights = np.vstack([np.ones(motions.size), weights])
    theta = {
        end: refit_lines(x, np.log(values[usable]), weights, np.log(state.threshold)).theta
        for end, values in ends.items()
    }
    with np.errstate(invalid="ignore"):
        ratio = theta["to"] / theta["from"]
    good = np.isfinite(ratio) & (ratio > 0.0)
    if not good[0]:
        return None
    tail = 0.5 * (1.0 - settings.effect_confidence)
    low, high = nan, nan
    if np.mean(good) > 0.95:
        # basic interval on the logarithm: theta is a ratio, and its replicates are skewed
        log_low, log_high = np.quantile(np.log(ratio[good]), [tail, 1.0 - tail])
        low = float(ratio[0] ** 2 / np.exp(log_high))
        high = float(ratio[0] ** 2 / np.exp(log_low))
    return {
        "ratio": float(ratio[0]),
        "from_mean": float(theta["from"][0]),
        "ci_low": low,
        "ci_high": high,
        "level": settings.effect_confidence,
        "margin": settings.margin,
        "n_motions": int(np.unique(motions).size),
        "n_discordant": int(np.sum(ended_apart(part))),
        **pair_counts(part, usable),
    }
