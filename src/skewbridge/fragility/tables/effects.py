"""Paired effects of the axes of a study: change of demand under the same motions.

The record-to-record scatter cancels in the ratio of one motion's demands, so a few per cent are
seen with 16 motions where an unpaired comparison would need hundreds.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import nan, sqrt
from typing import Any, Final, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.demands.columns import column_of, demands_for
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.motion_means import TTest
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.cell_changes import CellMeans, Changes
from skewbridge.fragility.tables.key_columns import (
    KEY_COLUMNS,
    axis_names,
    need_columns,
)
from skewbridge.fragility.tables.paired_runs import PairFacts, ends_of, pair_groups
from skewbridge.fragility.tables.spread import spread
from skewbridge.fragility.tables.verdicts import DIFFERENCE, RATIO, VERDICTS, judged
from skewbridge.variant.axes import AXES, Axis, axes_of


def effect_columns(axes: Sequence[Axis]) -> dict[str, str]:
    """Return names and meanings of the columns of the effects of a study with these axes."""
    return {
        "bridge": "catalogue entry",
        "abutment": "abutment model",
        "demand": "demand column, or component/limit_state for a median capacity",
        "quantity": "demand | median_capacity",
        "axis": " | ".join(axis.name for axis in axes),
        "from_value": "value of the axis in the denominator",
        "to_value": "value of the axis in the numerator",
        **{
            axis.name: f"{axis.title} of both variants; NaN where it is the axis or pooled over"
            for axis in axes
        },
        "scope": "pooled (average of all pairs of variants) | variant (one pair of variants)",
        "ratio": "geometric mean over the motions of the paired ratio",
        "ci_low": "lower end of its interval (Student's t over motions)",
        "ci_high": "upper end",
        "level": "confidence level",
        "margin": "relative change that counts as negligible",
        "shrunk_ratio": "the ratio drawn towards the pooled one as far as the pairs of variants "
        "differ by chance (empirical Bayes)",
        "difference": "mean difference, of demands that are judged by it",
        "difference_low": "lower end of its interval",
        "difference_high": "upper end",
        "difference_margin": "difference that counts as negligible",
        "shrunk_difference": "the difference drawn towards the pooled one",
        "unit": "unit of the difference",
        "judged_by": "ratio | difference: what the verdict is of",
        "verdict": "; ".join(f"{name}: {meaning}" for name, meaning in VERDICTS.items()),
        "direction": "-1 or 1 where the interval excludes no change, else 0",
        "verdict_family": "the verdict that holds together with those of all rows of the same "
        "bridge, abutment, axis, scope and quantity (Holm)",
        "n_cells": "pairs of variants averaged, of a pooled row",
        "p_cells": "F test of the effect being the same in all of these pairs, on the scale that "
        "is judged",
        "from_mean": "geometric mean of the demand at from_value: how large it is at all",
        "scatter": "standard deviation over motions, on the scale that is judged (ln ratio, or "
        "difference)",
        "dof": "degrees of freedom of the interval: motions with an exact change, less 1",
        "n_motions": "motions with a usable pair",
        "n_pairs": "pairs of runs",
        "n_bounds": "pairs that count as a bound: one side collapsed, failed or went beyond the "
        "model",
        "n_left_out": "pairs left out of what is judged: both sides ended early, or a demand is "
        "zero and has no ratio",
        "n_discordant": "of these, pairs in which one side alone has nothing to compare",
        "n_beyond_model": "pairs in which a column failed beyond the model",
        "n_collapse_from": "collapsed runs at from_value",
        "n_collapse_to": "collapsed runs at to_value",
    }


EFFECT_COLUMNS: Final = effect_columns(AXES)


def paired_effects(
    demands: pd.DataFrame,
    columns: Sequence[str] | None = None,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the paired changes of demand along every axis of a study, pooled ones first.

    Two variants of one bridge and abutment model that differ in one axis only are paired run by run
    (same motion, scale and incidence); the smallest value of the axis is the reference. The ratio
    is the geometric mean over motions (a motion counts once, however often it ran). A pooled row is
    the average over all such pairs of variants, each with the same weight. A pair in which one side
    collapsed, failed or went beyond the model counts as a bound of the change (Tobit).

    By default the demand columns are those with the role ``effect`` that the table has. ``jobs`` is
    the number of processes.

    Returns:
        Rows with the columns `effect_columns`.

    Raises:
        InputError: A column is missing, or a run occurs twice.
    """
    names = list(demands_for("effect", demands.columns) if columns is None else columns)
    need_columns(demands, (*KEY_COLUMNS, *names))
    found = spread(
        partial(_pair_rows, names=names, settings=settings),
        pair_groups(demands, names, scope="pooled"),
        jobs,
    )
    table = effect_table(demands, [row for rows in found for row in rows])
    return table.sort_values("scope", kind="stable", ignore_index=True)  # "pooled" < "variant"


def effect_table(demands: pd.DataFrame, rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return judged rows of effects, with the columns of the axes of the study.

    A row without ``judged_by`` is judged by its ratio; without ``dof``, its motions less one.
    """
    columns = list(effect_columns(axes_of(map(str, demands.columns))))
    table = pd.DataFrame(rows, columns=columns)
    for name, usual in (("judged_by", RATIO), ("unit", "")):
        table[name] = table[name].astype(object).fillna(usual).astype(str)
    table["dof"] = table["dof"].fillna(table["n_motions"] - 1)
    for name in ("n_cells", "n_bounds"):
        table[name] = table[name].astype("Int64")
    return judged(table)[columns]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pairs:
    """All pairs from one value of an axis to another, and each pair of variants by itself.

    ``told`` says which values they are, ``facts`` what became of the runs, ``cells`` has the other
    axes of each pair of variants, its rows and their facts.
    """

    told: Mapping[str, Any]
    facts: PairFacts
    cells: Sequence[tuple[dict[str, Any], NDArray[np.intp], PairFacts]]

    @classmethod
    def of(cls, told: Mapping[str, Any], part: pd.DataFrame) -> Self:
        facts, others = PairFacts.of(part), axis_names(part)
        groups = part.groupby(others, sort=True, dropna=False).indices if others else {(): None}
        cells: list[tuple[dict[str, Any], NDArray[np.intp], PairFacts]] = []
        for key, found in groups.items():
            values = key if isinstance(key, tuple) else (key,)
            own = np.arange(len(part)) if found is None else np.asarray(found, dtype=np.intp)
            place: dict[str, Any] = dict(zip(others, values, strict=True))
            cells.append((place, own, facts.at(own)))
        return cls(told=told, facts=facts, cells=cells)


def _pair_rows(
    group: tuple[Mapping[str, Any], pd.DataFrame], *, names: Sequence[str], settings: FitSettings
) -> list[dict[str, Any]]:
    """Return the rows of all demands of the pairs from one value of an axis to another."""
    pairs = _Pairs.of(*group)
    return [
        row for name in names for row in _effects(pairs, ends_of(group[1], name), name, settings)
    ]


def demand_effects(
    pair: Mapping[str, Any], part: pd.DataFrame, name: str, settings: FitSettings
) -> Iterator[dict[str, Any]]:
    """Yield the pooled row of one demand and those of the pairs of variants, for `effect_table`.

    Args:
        pair: Columns that all rows share: bridge, abutment, axis, from_value, to_value, scope.
        part: Pairs of `run_pairs`.
        name: The demand.
        settings: Level and margins.
    """
    return _effects(_Pairs.of(pair, part), ends_of(part, name), name, settings)


def _effects(
    pairs: _Pairs, ends: tuple[FloatArray, FloatArray], name: str, settings: FitSettings
) -> Iterator[dict[str, Any]]:
    """Yield the pooled row of one demand and those of the pairs of variants."""
    top, bottom = ends
    column = column_of(name)
    difference = None if column is None else column.difference
    judged_by = RATIO if difference is None else DIFFERENCE
    told = {
        **pairs.told,
        "demand": name,
        "quantity": "demand",
        "level": settings.effect_confidence,
        "margin": settings.relative_margin(name),
        "judged_by": judged_by,
    }
    if difference is not None:
        told |= {
            "unit": difference.unit,
            "difference_margin": settings.margins.get(name, difference.margin),
        }
    count = int(pairs.facts.motions.max()) + 1
    changes: dict[str, list[Changes]] = {}
    scales: dict[str, CellMeans] = {}
    for scale in dict.fromkeys((RATIO, judged_by)):
        unit = difference if scale == DIFFERENCE else None
        changes[scale] = [
            Changes.of(top[own], bottom[own], facts, unit) for _, own, facts in pairs.cells
        ]
        codes = [facts.motions for _, _, facts in pairs.cells]
        scales[scale] = CellMeans.of(changes[scale], codes, count)
    joint = scales[judged_by].joint
    yield {
        **told,
        **_estimates({scale: found.joint.average() for scale, found in scales.items()}, told),
        "n_cells": joint.means.size,
        "p_cells": joint.difference().p_value,
        **Changes.of(top, bottom, pairs.facts, difference).counts(pairs.facts),
    }
    for cell, (place, _, facts) in enumerate(pairs.cells):
        shrunk = {scale: found.shrunk[cell] for scale, found in scales.items()}
        yield {
            **told,
            "scope": "variant",
            **place,
            **_estimates({scale: found.tests[cell] for scale, found in scales.items()}, told),
            "shrunk_ratio": float(np.exp(shrunk[RATIO])),
            "shrunk_difference": shrunk.get(DIFFERENCE, nan),
            **changes[judged_by][cell].counts(facts),
        }


def _estimates(tests: Mapping[str, TTest], told: Mapping[str, Any]) -> dict[str, Any]:
    """Return ratio and difference with their intervals, from the tests on both scales."""
    ratio, judged_by = tests[RATIO], tests[told["judged_by"]]
    low, high = ratio.interval(told["level"])
    found = {
        "ratio": float(np.exp(ratio.value)),
        "ci_low": float(np.exp(low)),
        "ci_high": float(np.exp(high)),
        "scatter": judged_by.error * sqrt(judged_by.dof + 1),
        "dof": judged_by.dof,
    }
    if DIFFERENCE in tests:
        low, high = tests[DIFFERENCE].interval(told["level"])
        found |= {
            "difference": tests[DIFFERENCE].value,
            "difference_low": low,
            "difference_high": high,
        }
    return found
