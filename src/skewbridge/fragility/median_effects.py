"""Effects of skew, gap and friction on median capacities: pooled, and by pair of variants.

The median of each variant is that of its line of ln demand. Both variants of a pair see the same
motions, so the scatter between motions cancels in the ratio of their medians; its error is that of
the jackknife, in which a motion is left out of all variants (Bell and McCaffrey 2002, see fits).
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility import demand_table
from skewbridge.fragility.columns import FloatArray
from skewbridge.fragility.effects import effect_row, effect_table
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.motion_means import Jackknifed, average
from skewbridge.fragility.outcomes import demand_outcomes, end_counts, states_by_demand
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.verdicts import MEDIAN_CAPACITY

_MIN_MOTIONS: Final = 5


def median_effects(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings = DEFAULTS,
    *,
    axes: Sequence[str] | None = None,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the paired ratios of median capacities along every axis of a study, pooled ones first.

    Two variants of one bridge and abutment model that differ in one axis only form a cell; the
    smallest value of the axis is the reference. A cell counts where some runs of both variants, and
    not all, are known to exceed the state. A pooled row is the average of ln ratio over the cells.
    The columns are `effect_columns`; ``im_low`` and ``im_high`` are the smallest and largest median
    of the cells, at which the ratio applies.
    """
    groups, further = states_by_demand(limit_states).values(), axes or ()
    items = (
        (model, demand_table.demand_columns(part, [settings.im, group[0].demand, *further]), group)
        for model, part in demand_table.models_of(demands)
        for group in groups
    )
    rows = demand_table.spread(partial(_group_rows, settings=settings, axes=axes), items, jobs)
    return effect_table(demands, [row for part in rows for row in part])


def _group_rows(
    item: tuple[Mapping[str, Any], pd.DataFrame, Sequence[LimitState]],
    *,
    settings: FitSettings,
    axes: Sequence[str] | None,
) -> list[dict[str, Any]]:
    """Return the rows of the states of one demand of one bridge and abutment model."""
    description, part, states = item
    model = _Model(part, states, settings, [*demand_table.axis_names(part), *(axes or ())])
    shared = {"quantity": MEDIAN_CAPACITY, "margin": settings.median_margin}
    rows: list[dict[str, Any]] = []
    for axis in demand_table.varying_axes(part) if axes is None else axes:
        for (start, end), pairs in model.cells(axis).items():
            place = {**description, **shared, "axis": axis, "from_value": start, "to_value": end}
            for j, state in enumerate(states):
                place["demand"] = state.key
                ratios = {pair: model.ratio(pair, j) for pair in pairs}
                found = {pair: ratio for pair, ratio in ratios.items() if ratio is not None}
                if not found:
                    continue
                pooled = average([ratio for ratio, _ in found.values()])
                counts = pd.DataFrame([each for _, each in found.values()])
                row = {**place, "scope": "pooled", **effect_row(pooled, settings)}
                row |= {str(name): n for name, n in counts.filter(regex="^n_").sum().items()}
                row |= {"im_low": counts["im_low"].min(), "im_high": counts["im_high"].max()}
                row["from_mean"] = float(np.exp(np.log(counts["from_mean"]).mean()))
                row |= {"n_cells": len(found), "n_motions": int(np.count_nonzero(pooled.exact))}
                rows.append(row)
                for (first, _), (ratio, each) in found.items():
                    others = {k: v for k, v in model.places[first].items() if k != axis}
                    row = {**place, **others, "scope": "variant", **each}
                    rows.append(row | effect_row(ratio, settings))
    return rows


class _Model:
    """The variants of one bridge and abutment model, with their medians for one demand."""

    def __init__(
        self,
        part: pd.DataFrame,
        states: Sequence[LimitState],
        settings: FitSettings,
        names: Sequence[str],
    ) -> None:
        self._part, self._states, self._names = part, states, names
        self._motion = demand_table.motion_codes(part)
        self._ln_im = np.log(part[settings.im].to_numpy(dtype=np.float64))
        keys = part[list(names)].to_numpy(dtype=np.float64)
        places, variant = np.unique(keys, axis=0, return_inverse=True)
        self.places = [dict(zip(names, place, strict=True)) for place in places.tolist()]
        self._rows = [np.flatnonzero(variant.ravel() == v) for v in range(len(places))]
        self._has = np.zeros((len(places), int(self._motion.max()) + 1), dtype=np.bool_)
        self._has[variant.ravel(), self._motion] = True
        self._ended = [end_counts(part.iloc[rows]) for rows in self._rows]
        self._known: dict[tuple[int, int], tuple[FloatArray, dict[str, int]]] = {}

    def cells(self, axis: str) -> dict[tuple[float, float], list[tuple[int, int]]]:
        """Return the pairs of variants (from, to) that differ in one axis only, by their values."""
        groups: dict[tuple[float, ...], list[int]] = {}
        for number, place in enumerate(self.places):
            key = tuple(place[name] for name in self._names if name != axis)
            groups.setdefault(key, []).append(number)
        cells: dict[tuple[float, float], list[tuple[int, int]]] = {}
        for numbers in groups.values():
            first, *others = sorted(numbers, key=lambda number: self.places[number][axis])
            for other in others:
                ends = self.places[first][axis], self.places[other][axis]
                cells.setdefault(ends, []).append((first, other))
        return dict(sorted(cells.items()))

    def ratio(self, pair: tuple[int, int], j: int) -> tuple[Jackknifed, dict[str, float]] | None:
        """Return ln ratio of medians of state j and the columns of its runs; None without one."""
        shared = self._has[pair[0]] & self._has[pair[1]]
        if np.count_nonzero(shared) < _MIN_MOTIONS:
            return None
        (first, counts), (other, others) = self._medians(*pair), self._medians(*pair[::-1])
        values = other[j] - first[j]
        if not np.isfinite(values[0]):
            return None
        # ASSUME no influence where no line remains
        values = np.where(np.isfinite(values), values, values[0])
        ends = np.exp([first[j, 0], other[j, 0]]).tolist()
        start, end = (self._ended[v] for v in pair)
        columns: dict[str, float] = {
            "from_mean": ends[0],
            "im_low": min(ends),
            "im_high": max(ends),
            "n_motions": int(np.count_nonzero(shared)),
            **{name: max(count, others[name]) for name, count in counts.items()},
            "n_pairs": counts["n_pairs"],
            "n_discordant": 0,
            "n_beyond_model": max(start["n_beyond_model"], end["n_beyond_model"]),
            "n_collapse_from": start["n_collapse"],
            "n_collapse_to": end["n_collapse"],
        }
        return Jackknifed.of(values, shared, parameters=2), columns

    def _medians(self, variant: int, partner: int) -> tuple[FloatArray, dict[str, int]]:
        """Return ln medians of a variant under the motions that its partner has too, and counts."""
        # medians (J, 1 + M) of all runs, then without each motion; NaN where a state has none
        has, motions = self._has[partner], self._has.shape[1]
        key = variant, -1 if np.all(has >= self._has[variant]) else partner
        if key not in self._known:
            rows = self._rows[variant]
            rows = rows[has[self._motion[rows]]]
            codes = self._motion[rows]
            outcomes = demand_outcomes(self._part.iloc[rows], self._states)
            used = outcomes.used
            ln_theta = np.full((len(self._states), 1 + motions), np.nan)
            if np.unique(codes[used]).size >= _MIN_MOTIONS:
                without = codes != np.arange(-1, motions)[:, None]
                line = outcomes.lines(self._ln_im[rows], without.astype(np.float64))
                for j, state in enumerate(self._states):
                    if outcomes.status(state) == FITTED:
                        ln_theta[j] = line.ln_theta(state.threshold)
            counts = {
                "n_pairs": rows.size,
                "n_bounds": int(np.sum(used & (outcomes.lower != outcomes.upper))),
                "n_left_out": int(np.sum(~used)),
            }
            self._known[key] = ln_theta, counts
        return self._known[key]
