"""Effects of the axes of a study on demands under the same motions, pooled and by intensity.

The record-to-record scatter cancels in the ratio of one motion's demands, so a few per cent are
detected with 16 motions where an unpaired comparison would need hundreds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import nan
from typing import Any, Final, NamedTuple, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.demands.columns import column_of, demands_for
from skewbridge.demands.completeness import BEYOND_MODEL, is_beyond_model, is_complete
from skewbridge.demands.demand_columns import Difference
from skewbridge.errors import InputError
from skewbridge.fragility import demand_table, verdicts
from skewbridge.fragility.columns import FloatArray
from skewbridge.fragility.motion_means import Jackknifed, average, by_motion
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.statuses import COLLAPSE
from skewbridge.variant.axes import AXES, Axis, axes_of

#: What a pair shows of the change of a demand: the change, a lower or an upper bound, or nothing.
EXACT: Final = 0
AT_LEAST: Final = 1
AT_MOST: Final = -1
UNKNOWN: Final = 2
_VERDICTS: Final = "; ".join(f"{name}: {meaning}" for name, meaning in verdicts.VERDICTS.items())
#: Intensities of the table of effects by intensity, without the reference intensity.
_INTENSITIES: Final = 9


def effect_columns(axes: Sequence[Axis]) -> dict[str, str]:
    """Return names and descriptions of the columns of effects of a study with these axes."""
    return {
        "bridge": "catalogue entry",
        "abutment": "abutment model",
        "demand": "demand column, or component/limit_state of a median",
        "quantity": f"{verdicts.DEMAND} | {verdicts.MEDIAN_CAPACITY}",
        "axis": " | ".join(axis.name for axis in axes),
        "from_value": "value of the axis in the denominator",
        "to_value": "value of the axis in the numerator",
        **{
            axis.name: f"{axis.title} of both variants; NaN if pooled or the axis of the effect"
            for axis in axes
        },
        "scope": "pooled (average of all pairs of variants) | variant (one pair of variants)",
        "status": f"{verdicts.OK} | {verdicts.NOT_ESTIMABLE} (no interval, or wider than "
        f"a factor of {verdicts.MAX_WIDTH:g})",
        "ratio": "geometric mean over motions of the paired ratio",
        "ci_low": "lower end of its interval, Student's t over motions (-)",
        "ci_high": "upper end of its interval (-)",
        "level": "confidence level of the intervals",
        "margin": "negligible relative change",
        "difference": "mean difference, of demands judged by it (in `unit`)",
        "difference_low": "lower end of its interval (in `unit`)",
        "difference_high": "upper end of its interval (in `unit`)",
        "difference_margin": "negligible difference (in `unit`)",
        "unit": "unit of the difference",
        "judged_by": f"{verdicts.RATIO} | {verdicts.DIFFERENCE}: quantity of the verdict",
        "verdict": _VERDICTS,
        "direction": "-1 or 1 where the interval excludes no change, else 0",
        "verdict_family": "verdict for all comparisons of the family (Holm)",
        "im_low": "smallest intensity of a pair with an exact change",
        "im_high": "largest intensity of a pair with an exact change",
        "slope": "slope of the paired ln ratios on ln intensity",
        "slope_low": "lower end of its interval, clustered by motion (-)",
        "slope_high": "upper end of its interval (-)",
        "p_slope": "p-value of that slope",
        "n_cells": "pairs of variants in a pooled row",
        "from_mean": "mean demand (geometric), or median capacity, at from_value",
        "scatter": "standard deviation over motions of ln ratio or difference",
        "dof": "degrees of freedom of the interval",
        "n_motions": "motions with a usable pair",
        "n_pairs": "pairs of runs",
        "n_bounds": "pairs that give a bound: one run ended early",
        "n_left_out": "unused pairs: both ended early, or a zero demand",
        "n_discordant": "of these, with a demand on one side only",
        "n_beyond_model": "pairs in which a column failed",
        "n_collapse_from": "collapsed runs at from_value",
        "n_collapse_to": "collapsed runs at to_value",
    }


EFFECT_COLUMNS: Final = effect_columns(AXES)
INTENSITY_COLUMNS: Final[dict[str, str]] = {
    **{
        name: EFFECT_COLUMNS[name]
        for name in ("bridge", "abutment", "demand", "axis", "from_value", "to_value")
    },
    "im": "intensity",
    "ratio": "ratio at this intensity, by regression",
    "ci_low": "lower end of its interval at this intensity, clustered by motion (-)",
    "ci_high": "upper end of its interval (-)",
    "level": "confidence level of the intervals",
    "from_demand": "demand at from_value and this intensity",
    "to_demand": "from_demand times ratio",
    "n_motions": "motions with an exact change",
    "verdict": _VERDICTS,
    "at_reference": "true at the reference intensity of the bridge",
    "clipped": "true if the reference is outside the range of the pairs",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """All n pairs of runs from one value of an axis to another, of one bridge and abutment model.

    A run that collapsed, failed or lost a column has peaks up to then, so its demands are at least
    so large.
    """

    place: Mapping[str, Any]  # bridge, abutment, axis, from_value and to_value
    table: pd.DataFrame  # of `run_pairs`
    #: For each pair of variants the values of the other axes, and the numbers of its rows.
    cells: Sequence[tuple[Mapping[str, Any], NDArray[np.intp]]]
    motions: NDArray[np.intp]  # number of the motion
    count: int  # of motions
    side: NDArray[np.int_]  # `EXACT`, `AT_LEAST`, `AT_MOST` or `UNKNOWN`
    counted: dict[str, NDArray[np.bool_]]  # columns that count pairs, by name

    @classmethod
    def of(cls, place: Mapping[str, Any], table: pd.DataFrame) -> Self:
        """Return the pairs of `run_pairs` with the values of ``place``."""
        names = other_axes(table, str(place["axis"]))
        groups = table.groupby(names, sort=True, dropna=False).indices if names else {}
        cells: list[tuple[Mapping[str, Any], NDArray[np.intp]]] = []
        for key, rows in groups.items():
            values = key if isinstance(key, tuple) else (key,)
            cells.append((dict(zip(names, values, strict=True)), np.asarray(rows, dtype=np.intp)))
        (top, bottom), (status_to, status_from), (failed_to, failed_from) = (
            (table[f"{name}_to"].to_numpy(), table[f"{name}_from"].to_numpy())
            for name in ("complete", "status", BEYOND_MODEL)
        )
        motions, known = demand_table.motion_codes(table), [top & bottom, bottom, top]
        return cls(
            place=place,
            table=table,
            cells=cells or [({}, np.arange(len(table)))],
            motions=motions,
            count=int(motions.max()) + 1,
            side=np.select(known, [EXACT, AT_LEAST, AT_MOST], default=UNKNOWN),
            counted={
                "n_beyond_model": failed_to | failed_from,
                "n_collapse_from": status_from == COLLAPSE,
                "n_collapse_to": status_to == COLLAPSE,
            },
        )

    def ends(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return a column at to_value and at from_value, each of shape (n,)."""
        to, start = (self.table[f"{name}_{end}"] for end in ("to", "from"))
        return to.to_numpy(dtype=np.float64), start.to_numpy(dtype=np.float64)

    def counts(
        self, rows: NDArray[np.intp], used: NDArray[np.bool_], discordant: NDArray[np.bool_]
    ) -> dict[str, int]:
        """Return the columns ``n_`` of some pairs, except n_cells; arrays are of all n pairs."""
        counted = self.counted | {
            "n_bounds": used & (self.side != EXACT),
            "n_left_out": ~used,
            "n_discordant": discordant,
        }
        return {
            "n_motions": int(np.unique(self.motions[rows][used[rows]]).size),
            "n_pairs": int(rows.size),
            **{name: int(np.count_nonzero(values[rows])) for name, values in counted.items()},
        }


def other_axes(table: pd.DataFrame, axis: str) -> list[str]:
    """Return the axis columns of a table, except one."""
    return [name for name in demand_table.axis_names(table) if name != axis]


def run_pairs(demands: pd.DataFrame, axis: str, columns: Sequence[str]) -> pd.DataFrame:
    """Pair the runs of variants that differ in ``axis`` only, the smallest value as reference.

    Returns:
        One row per pair: bridge, abutment, other axes, motion_id, scale, incidence_deg, from_value,
        to_value; status, beyond_model, complete (truth values) and columns by ``_from``, ``_to``.

    Raises:
        InputError: A run occurs twice.
    """
    group = [*demand_table.BRIDGE_COLUMNS, *other_axes(demands, axis)]
    key = [*group, *demand_table.LOADING_COLUMNS]
    table = demands[[*key, axis, "status", *columns]].assign(
        **{BEYOND_MODEL: is_beyond_model(demands), "complete": is_complete(demands)}
    )
    once = ~table.duplicated([*key, axis]).to_numpy()
    if not once.all():
        row = demands.index[int(np.argmin(once))]
        raise InputError(f"the run of row {row} occurs twice in the demands table", row=row)
    lowest = table.groupby(group, dropna=False)[axis].transform("min")
    reference = table[table[axis] == lowest].rename(columns={axis: "from_value"})
    others = table[table[axis] > lowest].rename(columns={axis: "to_value"})
    return others.merge(reference, on=key, suffixes=("_to", "_from"), validate="many_to_one")


class EffectTables(NamedTuple):
    """Effects on demands."""

    effects: pd.DataFrame  # columns `effect_columns`, pooled rows first
    intensities: pd.DataFrame  # columns `INTENSITY_COLUMNS`, of demands judged by their ratio


def effect_tables(
    demands: pd.DataFrame,
    columns: Sequence[str] | None = None,  # None: those with the role `effect` that the table has
    settings: FitSettings = DEFAULTS,
    *,
    reference_im: Mapping[tuple[str, str], float] | None = None,  # by bridge and abutment
    jobs: int = 1,
) -> EffectTables:
    """Return the paired changes of demand along every axis of a study.

    Two variants of one bridge and abutment model that differ in one axis only are paired run by run
    (same motion, scale and incidence); the smallest value of the axis is the reference. The ratio
    is the geometric mean over motions. A pooled row is the average over all such pairs of variants.
    A pair in which one run collapsed, failed or lost a column counts as a bound (Tobit).
    Slopes need the intensity measure; effects by intensity are given at ``reference_im`` as well.

    Raises:
        InputError: A column is missing, or a run occurs twice.
    """
    names = list(demands_for("effect", demands.columns) if columns is None else columns)
    demand_table.need_columns(demands, (*demand_table.KEY_COLUMNS, *names))
    im = [settings.im] if settings.im in demands.columns else []
    paired = list(dict.fromkeys([*names, *im]))
    pairs = (
        Pairs.of(model | {"axis": axis, "from_value": start, "to_value": end}, part)
        for model, rows in demand_table.models_of(demands)
        for axis in demand_table.varying_axes(rows)
        for (start, end), part in run_pairs(rows, axis, paired).groupby(["from_value", "to_value"])
    )
    at = reference_im or {}
    rows_of = partial(demand_effects, names=names, settings=settings, reference_im=at)
    found = demand_table.spread(rows_of, pairs, jobs)
    effects = effect_table(demands, [row for rows, _ in found for row in rows])
    by_intensity = [row for _, rows in found for row in rows]
    return EffectTables(effects, pd.DataFrame(by_intensity, columns=list(INTENSITY_COLUMNS)))


def effect_table(demands: pd.DataFrame, rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return judged rows of effects, pooled ones first; usually they are judged by the ratio."""
    columns = list(effect_columns(axes_of(map(str, demands.columns))))
    table = pd.DataFrame(rows, columns=columns)
    for name, usual in (("judged_by", verdicts.RATIO), ("unit", "")):
        table[name] = table[name].astype(object).fillna(usual).astype(str)
    for name in ("n_cells", "n_bounds"):
        table[name] = table[name].astype("Int64")
    return verdicts.judged(table)[columns].sort_values("scope", kind="stable", ignore_index=True)


def effect_row(
    estimate: Jackknifed, settings: FitSettings, *, line: Jackknifed | None = None
) -> dict[str, Any]:
    """Return ratio, scatter and slope of an effect from ln ratio () and its line on ln IM (2,)."""
    level = settings.effect_confidence
    ends = (estimate.estimate, *estimate.interval(level))
    row = dict(zip(verdicts.RATIOS, map(float, np.exp(ends)), strict=True))
    row |= {"level": level, **_scatter(estimate)}
    if line is not None:
        ends = (line.estimate, *line.interval(level), line.p_value())
        names = ("slope", "slope_low", "slope_high", "p_slope")
        row |= {name: float(end[1]) for name, end in zip(names, ends, strict=True)}
    return row


def _scatter(estimate: Jackknifed) -> dict[str, Any]:
    """Return the scatter over motions and the degrees of freedom of a mean."""
    scatter = float(estimate.error) * max(estimate.dof + 1, 0) ** 0.5
    return {"scatter": scatter, "dof": estimate.dof}


class _Changes(NamedTuple):
    """Changes of a demand in pairs of runs, arrays of shape (n,)."""

    values: FloatArray  # ln ratio or difference, NaN where not used
    used: NDArray[np.bool_]  # pairs that give a change or a bound
    discordant: NDArray[np.bool_]  # pairs with a demand on one side only

    @classmethod
    def of(cls, pairs: Pairs, name: str, difference: Difference | None) -> "_Changes":
        """Return the differences of a demand, or its ln ratios where ``difference`` is None."""
        ends = pairs.ends(name)
        least = 0.0 if difference is None else -np.inf
        has_top, has_bottom = (np.isfinite(end) & (end > least) for end in ends)
        used = (pairs.side != UNKNOWN) & has_top & has_bottom
        top, bottom = (np.where(used, end, nan) for end in ends)
        by_ratio = difference is None
        values = np.log(top / bottom) if by_ratio else (top - bottom) * difference.per_unit
        return cls(values, used, has_top != has_bottom)

    def estimates(self, pairs: Pairs, x: FloatArray | None = None) -> list[Jackknifed]:
        """Return the pooled mean and those of the pairs of variants, or their lines over x."""
        known = self.used if x is None else self.used & np.isfinite(x)
        cells: list[Jackknifed] = []
        for _, rows in pairs.cells:
            own = rows[known[rows]]
            data = (self.values[own], pairs.side[own], pairs.motions[own], pairs.count)
            cells.append(by_motion(*data, None if x is None else x[own]))
        return [average(cells), *cells]


def demand_effects(
    pairs: Pairs,
    *,
    names: Sequence[str],
    settings: FitSettings,
    reference_im: Mapping[tuple[str, str], float],
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the rows of `effect_table`, and those by intensity, of some demands of some pairs."""
    rows: list[dict[str, Any]] = []
    by_intensity: list[dict[str, Any]] = []
    has_im = f"{settings.im}_from" in pairs.table
    im = pairs.ends(settings.im)[1] if has_im else np.full(pairs.side.size, nan)
    ln_im = np.log(np.where(im > 0.0, im, nan))
    places: list[tuple[Mapping[str, Any], NDArray[np.intp]]] = [
        ({"scope": "pooled"}, np.arange(im.size)),
        *(({"scope": "variant", **place}, own) for place, own in pairs.cells),
    ]
    for name in names:
        column, reference = column_of(name), pairs.ends(name)[1]
        difference = None if column is None else column.difference
        ratios = _Changes.of(pairs, name, None)
        changes = ratios if difference is None else _Changes.of(pairs, name, difference)
        exact = changes.used & (pairs.side == EXACT)
        means, lines = ratios.estimates(pairs), ratios.estimates(pairs, ln_im)
        differences = None if difference is None else changes.estimates(pairs)
        shared = {**pairs.place, "demand": name, "margin": settings.relative_margin(name)}
        shared["quantity"] = verdicts.DEMAND
        if difference is not None:
            shared |= {"judged_by": verdicts.DIFFERENCE, "unit": difference.unit}
            shared["difference_margin"] = settings.margins.get(name, difference.margin)
        for cell, (place, own) in enumerate(places):
            row = {**shared, **place, **effect_row(means[cell], settings, line=lines[cell])}
            if differences is not None:
                mean = differences[cell]
                ends = (mean.estimate, *mean.interval(settings.effect_confidence))
                row |= dict(zip(verdicts.DIFFERENCES, map(float, ends), strict=True))
                row |= _scatter(mean)
            known = own[exact[own]]
            positive = reference[known][reference[known] > 0.0]
            row |= {
                "from_mean": float(np.exp(np.log(positive).mean())) if positive.size else nan,
                "im_low": float(im[known].min()) if known.size else nan,
                "im_high": float(im[known].max()) if known.size else nan,
                **pairs.counts(own, changes.used, changes.discordant),
            }
            rows.append(row)
        pooled = rows[-len(places)]
        judged_cells = (differences or means)[1:]
        pooled["n_cells"] = sum(bool(np.isfinite(cell.estimate)) for cell in judged_cells)
        if difference is None:
            at = reference_im.get((pooled.get("bridge", ""), pooled.get("abutment", "")))
            known = np.flatnonzero(exact & (reference > 0.0) & np.isfinite(ln_im))
            x, y = ln_im[known], np.log(reference[known])
            level = np.polyfit(x, y, 1) if np.unique(x).size > 1 else np.full(2, nan)
            by_intensity += _by_intensity(pooled, lines[0], level, at)
    return rows, by_intensity


def _by_intensity(
    pooled: Mapping[str, Any], line: Jackknifed, level: FloatArray, reference_im: float | None
) -> list[dict[Any, Any]]:
    """Return the rows of `INTENSITY_COLUMNS` of a pooled effect, also at ``reference_im``."""
    # `line` is its regression on ln intensity, `level` (2,) that of ln demand at from_value
    low, high = pooled["im_low"], pooled["im_high"]
    if not np.all(np.isfinite(line.estimate)) or not low < high:
        return []
    im = np.geomspace(low, high, _INTENSITIES)
    if reference_im is not None:
        im = np.append(im, np.clip(reference_im, low, high))
    effect = line.combined(np.stack([np.ones(im.size), np.log(im)]))
    value = np.stack([effect.estimate, *effect.interval(pooled["level"])])
    value[:, ~(value[2] - value[1] <= np.log(verdicts.MAX_WIDTH))] = nan
    below, zero, above = np.log1p(np.outer([-1.0, 0.0, 1.0], np.full(im.size, pooled["margin"])))
    possible = np.repeat(verdicts.may_be_negligible(pd.DataFrame([pooled])), im.size)
    found = verdicts.verdicts_of(value[1], below, zero, above, value[2], possible=possible)
    ln_demand, last = np.polyval(level, np.log(im)), np.arange(im.size) == _INTENSITIES
    columns = {
        **{name: pooled[name] for name in INTENSITY_COLUMNS if name in pooled},
        **dict(zip(verdicts.RATIOS, np.exp(value), strict=True)),
        "im": im,
        "from_demand": np.exp(ln_demand),
        "to_demand": np.exp(ln_demand + value[0]),
        "n_motions": int(np.count_nonzero(effect.exact)),
        "verdict": found,
        "at_reference": last,
        "clipped": last & (im != reference_im),
    }
    return pd.DataFrame(columns).to_dict("records")
