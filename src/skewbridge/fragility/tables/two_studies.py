"""Two studies run by run: what changed where variant, motion, factor, incidence are the same."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.errors import InputError
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.effects import demand_effects, effect_table
from skewbridge.fragility.tables.key_columns import (
    BRIDGE_COLUMNS,
    LOADING_COLUMNS,
    axis_names,
    models_of,
)
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.median_effects import capacity_ratio
from skewbridge.fragility.tables.paired_runs import run_pairs

#: Stands where the tables of effects have an axis; 0 is the first study, 1 the second.
STUDY: Final = "study"


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """The second study over the first.

    Attributes:
        demands: Effects of the demands, pooled rows of each bridge first (`effect_columns`).
        medians: Ratios of theta by variant and limit state.
        counts: Pairs, runs of one study alone, variants and motions in both.
    """

    demands: pd.DataFrame
    medians: pd.DataFrame
    counts: dict[str, int]

    def summed_medians(self) -> list[dict[str, Any]]:
        """Return the ratios of theta over all variants of a bridge, a row per limit state."""
        rows: list[dict[str, Any]] = []
        keys = [*BRIDGE_COLUMNS, "demand"]
        for key, own in self.medians.groupby(keys, sort=False):
            logs = np.log(own["ratio"].to_numpy(dtype=np.float64))
            rows.append(
                {
                    **dict(zip(keys, key, strict=True)),
                    "ratio": float(np.exp(logs.mean())),
                    "lowest": float(np.exp(logs.min())),
                    "highest": float(np.exp(logs.max())),
                    "n_variants": len(own),
                    "n_changed": int((own["direction"] != 0).sum()),
                }
            )
        return rows


def compare_demands(
    first: pd.DataFrame,
    second: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings,
) -> Comparison:
    """Pair the runs of two tables of demands and return the changes from the first to the second.

    Runs are paired where bridge, abutment model, all axes, motion, scale and incidence agree. Pairs
    in which one side collapsed, failed or went beyond the model count as bounds, as in
    `paired_effects`.

    Raises:
        InputError: The tables have no run in common, or a run twice.
    """
    both = pd.concat([first.assign(**{STUDY: 0}), second.assign(**{STUDY: 1})], ignore_index=True)
    shared = set(first.columns) & set(second.columns)
    states = [state for state in limit_states if state.demand in shared]
    names = list(demands_for("effect", sorted(shared)))
    columns = list(dict.fromkeys([*names, *(state.demand for state in states), settings.im]))
    pairs = run_pairs(both, STUDY, columns)
    if pairs.empty:
        raise InputError(_nothing_shared(first, second, axis_names(both)))
    told = {"axis": STUDY, "from_value": 0.0, "to_value": 1.0}
    effects: list[dict[str, Any]] = []
    medians: list[dict[str, Any]] = []
    for model, own in models_of(pairs):
        for name in names:
            effects += demand_effects(model | told | {"scope": "pooled"}, own, name, settings)
        medians += _medians(model | told, own, states, settings)
    found = effect_table(both, effects).sort_values("scope", kind="stable", ignore_index=True)
    variants = [*BRIDGE_COLUMNS, *axis_names(both)]
    return Comparison(
        demands=found,
        medians=effect_table(both, medians),
        counts={
            "pairs": len(pairs),
            "only_first": len(first) - len(pairs),
            "only_second": len(second) - len(pairs),
            "variants": len(pairs[variants].drop_duplicates()),
            "motions": int(pairs["motion_id"].nunique()),
            "equal_pairs": int(_equal(pairs, names).sum()),
        },
    )


def _nothing_shared(first: pd.DataFrame, second: pd.DataFrame, axes: Sequence[str]) -> str:
    """Return why no runs can be paired: what the tables share of variants, motions and loadings."""
    kinds = {
        "variants": [*BRIDGE_COLUMNS, *axes],
        "motions": ["motion_id"],
        "motions with the same scale and incidence": [*LOADING_COLUMNS],
    }
    told: list[str] = []
    for name, columns in kinds.items():
        keys = [
            set(map(tuple, table.reindex(columns=columns).drop_duplicates().to_numpy().tolist()))
            for table in (first, second)
        ]
        told.append(f"{len(keys[0] & keys[1])} {name}")
    return (
        f"the studies have no run in common; they share {', '.join(told)} (the scale of a motion "
        "follows from the number of motions and the range of levels)"
    )


def _medians(
    told: dict[str, Any],
    pairs: pd.DataFrame,
    states: Sequence[LimitState],
    settings: FitSettings,
) -> list[dict[str, Any]]:
    """Return a row per variant and limit state of which both studies have a median."""
    rows: list[dict[str, Any]] = []
    axes = axis_names(pairs)
    parts = pairs.groupby(axes, sort=True, dropna=False) if axes else [((), pairs)]
    for key, part in parts:
        place = told | {"scope": "variant"} | dict(zip(axes, key, strict=True))
        for state in states:
            ratio = capacity_ratio(part, state, settings.im, settings)
            if ratio is not None:
                name = f"{state.component}/{state.name}"
                rows.append(place | {"demand": name, "quantity": "median_capacity"} | ratio)
    return rows


def _equal(pairs: pd.DataFrame, names: Sequence[str]) -> pd.Series:
    """Return the pairs whose demands do not differ at all: likely one and the same analysis."""
    ends = ([f"{name}_{end}" for name in names] for end in ("to", "from"))
    top, bottom = (pairs[own].to_numpy(dtype=np.float64) for own in ends)
    return pd.Series(np.all((top == bottom) | (np.isnan(top) & np.isnan(bottom)), axis=1))
