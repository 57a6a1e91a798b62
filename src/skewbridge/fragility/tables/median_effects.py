"""Paired effects on median capacities: ratios of theta with the motions drawn jointly."""

from collections.abc import Sequence
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_lines
from skewbridge.fragility.tables.effects import (
    AXES,
    EFFECT_COLUMNS,
    EFFECT_LEVEL,
    MARGIN,
    EffectSettings,
    run_pairs,
    verdict_of,
)
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import COLLAPSE, OK, check_demands

_MIN_MOTIONS: Final = 5


def paired_capacity_effects(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    *,
    level: float = EFFECT_LEVEL,
    margin: float = MARGIN,
    bootstrap: int = 1999,
    seed: int = 20240501,
) -> pd.DataFrame:
    """Return the paired ratios of the cloud median theta along skew, gap and friction.

    theta of both variants is fitted to the same motions; a bootstrap replicate draws motions once
    for both, so that what the motions share cancels in the ratio. A limit state that no run of
    one of the variants exceeds (or every run) has no ratio.

    Args:
        demands: Table in the contract of results/demands.parquet.
        limit_states: Limit states.
        im_column: Intensity measure, at the level of the run.
        level: Confidence level.
        margin: Relative change that counts as negligible.
        bootstrap: Replicates of the record bootstrap.
        seed: Of the record bootstrap.

    Returns:
        Rows with the columns of `EFFECT_COLUMNS`, scope ``variant``.

    Raises:
        InputError: A column is missing or a value unusable.
    """
    options = EffectSettings(level=level, margin=margin, replicates=bootstrap, seed=seed)
    columns = list(dict.fromkeys(state.demand for state in limit_states))
    check_demands(demands, im_column, columns)
    rows: list[dict[str, Any]] = []
    for axis in AXES:
        others = [name for name in AXES if name != axis]
        pairs = run_pairs(demands, axis, [*columns, im_column])
        keys = ["bridge", "abutment", "from_value", "to_value", *others]
        for key, part in pairs.groupby(keys, sort=True):
            fixed = dict(zip(keys, key, strict=True))
            for state in limit_states:
                effect = _ratio(part, state, im_column, options)
                if effect is not None:
                    name = f"{state.component}/{state.name}"
                    rows.append(
                        {"axis": axis, "scope": "variant", "demand": name}
                        | {"quantity": "median_capacity"}
                        | fixed
                        | effect
                    )
    return pd.DataFrame(rows, columns=list(EFFECT_COLUMNS))


def _ratio(
    part: pd.DataFrame, state: LimitState, im_column: str, options: EffectSettings
) -> dict[str, Any] | None:
    """Return ratio and interval, or None where a variant has no median."""
    ends = {end: part[f"{state.demand}_{end}"].to_numpy(dtype=np.float64) for end in ("to", "from")}
    finished = ((part["status_to"] == OK) & (part["status_from"] == OK)).to_numpy()
    usable = finished & (ends["to"] > 0.0) & (ends["from"] > 0.0)
    for values in ends.values():
        above = values[usable] > state.threshold
        if not np.any(above) or np.all(above):
            return None
    motions, codes = np.unique(part["motion_id"].to_numpy(dtype=str)[usable], return_inverse=True)
    if motions.size < _MIN_MOTIONS:
        return None
    x = np.log(part[f"{im_column}_to"].to_numpy(dtype=np.float64)[usable])
    weights = record_weights(codes, options.replicates, np.random.default_rng(options.seed))
    weights = np.vstack([np.ones(codes.size), weights])
    theta = {
        end: refit_lines(x, np.log(values[usable]), weights, np.log(state.threshold), 0.0).theta
        for end, values in ends.items()
    }
    with np.errstate(invalid="ignore"):
        ratio = theta["to"] / theta["from"]
    good = np.isfinite(ratio) & (ratio > 0.0)
    if not good[0]:
        return None
    tail = 0.5 * (1.0 - options.level)
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
        "level": options.level,
        "n_motions": int(motions.size),
        "n_left_out": int(np.sum(~usable)),
        "n_discordant": int((part["status_to"] != part["status_from"]).sum()),
        "n_collapse_from": int((part["status_from"] == COLLAPSE).sum()),
        "n_collapse_to": int((part["status_to"] == COLLAPSE).sum()),
        "verdict": verdict_of(low, high, options.margin),
    }
