"""Effects of the axes of a study on demands and median capacities under the same motions.

Record-to-record scatter cancels in the ratio of two demands under one motion. Effects of a few per
cent can therefore be detected with 16 motions; an unpaired comparison would need hundreds. The
scatter also cancels in the ratio of two medians, both from one demand model of the bridge
(`demand_model`). The error of a ratio comes from a jackknife that leaves each motion, or all
motions of an event, out of all variants (Bell and McCaffrey 2002, see `fits`).
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from math import isfinite, nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.demands.columns import EVENT, Difference, column_of, demands_for
from skewbridge.demands.validity import is_complete
from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row, records_of
from skewbridge.fragility import demand_table, motion_means, verdicts
from skewbridge.fragility.demand_model import BridgeModels, StateCurve
from skewbridge.fragility.fits import FITTED, MAX_BOUNDS_RATIO
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.motion_means import Jackknifed, average, by_motion
from skewbridge.fragility.outcomes import outcomes_by_state
from skewbridge.fragility.settings import DEFAULTS, EFFECT_CONFIDENCE, FitSettings
from skewbridge.variant.axes import axes_of

#: A pair of runs gives the exact change, a lower bound, an upper bound or no information.
EXACT: Final = 0
AT_LEAST: Final = 1
AT_MOST: Final = -1
UNKNOWN: Final = 2
#: Number of intensities in the table of effects by intensity, without the reference intensity.
_INTENSITIES: Final = 9
#: Smallest number of motions common to both variants for a ratio of medians.
MIN_MOTIONS: Final = 5
STEP: Final = ("from_value", "to_value")
#: Scopes of rows in the order of the tables of effects.
_SCOPES: Final = ("pooled", "by_value", "variant")

INTENSITY_COLUMNS: Final = demand_table.described("intensity_effects")


class Pairs:
    """All n pairs of runs with two values of an axis, for one bridge and abutment model.

    The peaks of a run that ended early (collapse, failed analysis, failed column) are lower bounds
    of its demands. ``labels``: bridge, abutment, axis and its values; ``table``: see `run_pairs`.
    """

    def __init__(self, labels: Mapping[str, Any], table: pd.DataFrame) -> None:
        self.labels, self.table = labels, table
        names = [name for name in demand_table.axis_names(table) if name != labels["axis"]]
        groups = table.groupby([*demand_table.BRIDGE_COLUMNS, *names], dropna=False)
        cells: dict[Any, Any] = groups.indices
        #: For each pair of variants (cell): values of the other axes, and numbers of its rows.
        self.cells = [
            (dict(zip(names, key[2:], strict=True)), np.asarray(rows, dtype=np.intp))
            for key, rows in cells.items()
        ]
        self.motions = demand_table.motion_codes(table)
        #: Number of the block (event or motion) of each row, shape (n,), and names of the blocks.
        self.block = demand_table.block_codes(table)
        self.names = demand_table.block_names(table)
        complete_to, complete_from = (table[f"complete_{end}"].to_numpy() for end in ("to", "from"))
        conditions = [complete_to & complete_from, complete_from, complete_to]
        #: Kind of change or bound of each pair: `EXACT`, `AT_LEAST`, `AT_MOST`, `UNKNOWN`, (n,).
        self.side = np.select(conditions, [EXACT, AT_LEAST, AT_MOST], default=UNKNOWN)

    def ends(self, name: str) -> tuple[Floats, Floats]:
        """Return the values of a column at to_value and at from_value, shape (n,) each."""
        values_to, values_from = (self.table[f"{name}_{end}"] for end in ("to", "from"))
        return values_to.to_numpy(dtype=np.float64), values_from.to_numpy(dtype=np.float64)

    def changes(self, name: str, difference: Difference | None) -> tuple[Floats, Mask]:
        """Return the changes of a demand (n,): ln ratios, or differences given ``difference``.

        Changes are NaN in pairs that give neither a change nor a bound. The second array (n,) is
        True for pairs in which only one run has a usable demand (for ratios: a positive one).
        """
        demands = self.ends(name)
        lower_limit = 0.0 if difference is None else -np.inf
        has_to, has_from = (np.isfinite(demand) & (demand > lower_limit) for demand in demands)
        is_used = (self.side != UNKNOWN) & has_to & has_from
        demand_to, demand_from = (np.where(is_used, demand, nan) for demand in demands)
        if difference is None:
            return np.log(demand_to / demand_from), has_to != has_from
        return (demand_to - demand_from) * difference.per_unit, has_to != has_from

    def means(self, values: Floats, x: Floats | None = None) -> list[Jackknifed]:
        """Return means of ``values`` (n,), or lines on ``x``: average of cells, then each cell."""
        is_finite = np.isfinite(values if x is None else values + x)
        cells: list[Jackknifed] = []
        for _, rows in self.cells:
            finite = rows[is_finite[rows]]
            data = (values[finite], self.side[finite], self.motions[finite], len(self.names))
            cells.append(by_motion(*data, None if x is None else x[finite], self.block[finite]))
        return [average(cells), *cells]

    def counts(self, rows: Index, is_used: Mask, discordant: Mask) -> dict[str, int]:
        """Return the counts ``n_...`` of the pairs ``rows``, without n_cells; masks are (n,)."""
        counted = {"n_discordant": discordant, "n_bounds": is_used & (self.side != EXACT)}
        counts = {name: int(np.count_nonzero(values[rows])) for name, values in counted.items()}
        motions = np.unique(self.motions[rows][is_used[rows]])
        return counts | {"n_motions": motions.size, "n_pairs": rows.size}


def run_pairs(demands: pd.DataFrame, axis: str, columns: Sequence[str]) -> pd.DataFrame:
    """Pair each run with the otherwise identical run at the reference value of ``axis``.

    Each pair has one row with bridge, abutment, other axes, motion_id, scale, incidence_deg, event
    if known, from_value and to_value. ``complete`` (bool) and ``columns`` of its runs have the
    endings ``_from`` and ``_to``. An `InputError` names a run that occurs twice.
    """
    other_axes = [name for name in demand_table.axis_names(demands) if name != axis]
    loading = [*demand_table.LOADING_COLUMNS, *({EVENT} & set(demands))]
    key = [*demand_table.BRIDGE_COLUMNS, *other_axes, *loading]
    table = demands[[*key, axis, *columns]].assign(complete=is_complete(demands))
    is_unique = ~table.duplicated([*key, axis]).to_numpy()
    if not is_unique.all():
        row = demands.index[int(np.argmin(is_unique))]
        raise InputError(f"the run of row {row} occurs twice in the demands: remove one", row=row)
    return _paired(table, axis, other_axes, loading)


def all_pairs(demands: pd.DataFrame, columns: Sequence[str]) -> Iterator[Pairs]:
    """Yield the `run_pairs` of each bridge, abutment model, axis and pair of its values."""
    for model, rows in demand_table.models_of(demands):
        for axis in demand_table.varying_axes(rows):
            for step, runs in run_pairs(rows, axis, columns).groupby(list(STEP)):
                yield Pairs(model | {"axis": axis} | dict(zip(STEP, step, strict=True)), runs)


def _paired(
    table: pd.DataFrame, axis: str, other_axes: Sequence[str], loading: Sequence[str] = ()
) -> pd.DataFrame:
    """Join each row with the otherwise identical row at the reference value of ``axis``."""
    group = [*demand_table.BRIDGE_COLUMNS, *other_axes]
    start = table.groupby(group, dropna=False)[axis].transform(demand_table.reference_value)
    reference = table[table[axis] == start].rename(columns={axis: "from_value"})
    others = table[table[axis] != start].rename(columns={axis: "to_value"})
    key = [*group, *loading]
    return others.merge(reference, on=key, suffixes=("_to", "_from"), validate="many_to_one")


def variant_pairs(variants: pd.DataFrame, axis: str) -> tuple[list[str], pd.DataFrame]:
    """Return the other axes, and the pairs of variants of a bridge that differ in one axis only.

    A pair has the numbers and names of its variants: ``number_to``, ``number_from``,
    ``variant_to`` and ``variant_from``. The one nearest to zero is the reference.
    """
    other_axes = [name for name in demand_table.axis_names(variants) if name != axis]
    table = variants[["variant", *demand_table.BRIDGE_COLUMNS, *other_axes, axis]]
    return other_axes, _paired(table.assign(number=np.arange(len(table))), axis, other_axes)


class EffectTables(NamedTuple):
    """Tables of effects on demands."""

    effects: pd.DataFrame  # table `effects`, pooled rows first
    intensities: pd.DataFrame  # table `intensity_effects`, for demands judged by their ratio


def effect_tables(
    demands: pd.DataFrame,
    columns: Sequence[str] | None = None,  # None: all demand columns with the role `effect`
    settings: FitSettings = DEFAULTS,
    *,
    reference_im: Mapping[tuple[str, str], float] | None = None,  # keys: bridge, abutment
    jobs: int = 1,
) -> EffectTables:
    """Return the paired changes of demand along every axis of a study.

    Runs are paired as in `run_pairs`. The ratio is the geometric mean over motions. A pooled row is
    the average over all pairs of variants. A pair in which one run ended early gives a bound
    (Tobit). Slopes are NaN without the intensity measure. The table ``intensities`` includes the
    intensity ``reference_im``. An `InputError` names a missing column, or a run that occurs twice.
    """
    names = list(demands_for("effect", demands.columns) if columns is None else columns)
    demand_table.need_columns(demands, (*demand_table.KEY_COLUMNS, *names))
    paired = [name for name in dict.fromkeys([*names, settings.im]) if name in demands.columns]
    ims = reference_im or {}
    effects_of_pairs = partial(demand_effects, names=names, settings=settings, reference_im=ims)
    tables = demand_table.spread(effects_of_pairs, all_pairs(demands, paired), jobs)
    effects = effect_table(demands, [row for rows, _ in tables for row in rows])
    by_intensity = [row for _, rows in tables for row in rows]
    return EffectTables(effects, pd.DataFrame(by_intensity, columns=list(INTENSITY_COLUMNS)))


def effect_table(demands: pd.DataFrame, rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return effects with verdicts, pooled rows first; ``judged_by`` defaults to the ratio."""
    columns = list(demand_table.described("effects", axes_of(map(str, demands.columns))))
    table = pd.DataFrame(rows, columns=columns)
    for name, default in (("judged_by", verdicts.RATIO), ("unit", "")):
        table[name] = table[name].astype(object).fillna(default).astype(str)
    for name in ("n_cells", "n_bounds", *verdicts.MEDIAN_COUNTS):
        table[name] = table[name].astype("Int64")
    for name in ("interaction", "largest_motion"):
        table[name] = table[name].astype(object).fillna("").astype(str)
    table["p_interaction"] = verdicts.adjusted(table, table["p_interaction"])
    order = table["scope"].map(_SCOPES.index).astype(np.int64).sort_values(kind="stable").index
    return verdicts.with_verdicts(table).loc[order, columns].reset_index(drop=True)


def effect_row(
    estimate: Jackknifed,  # ln ratio, shape ()
    *,
    blocks: Sequence[str],  # names of the motions or events of the jackknife
    line: Jackknifed | None = None,  # line of ln ratio on ln intensity, shape (2,)
    difference: Jackknifed | None = None,  # for demands judged by the difference, shape ()
) -> dict[str, Any]:
    """Return the columns of an effect: ratio, slope and difference with intervals, scatter, dof."""
    level, tested = EFFECT_CONFIDENCE, difference or estimate
    ends = np.exp([estimate.estimate, *estimate.interval(level)])
    row = dict(zip(verdicts.RATIOS, ends.tolist(), strict=True)) | {"level": level}
    if line is not None:
        ends = (line.estimate, *line.interval(level), line.p_value())
        names = ("slope", "slope_low", "slope_high", "p_slope")
        row |= {name: float(end[1]) for name, end in zip(names, ends, strict=True)}
    if difference is not None:
        ends = (difference.estimate, *difference.interval(level))
        row |= dict(zip(verdicts.DIFFERENCES, map(float, ends), strict=True))
    dof, square = float(tested.dof), tested.influence**2
    row |= {"scatter": float(tested.error) * max(dof + 1.0, 0.0) ** 0.5, "dof": dof}
    # the last influences may be those of priors
    of_motions = tested.influence[: len(blocks)]
    row["n_effective_motions"] = float(motion_means.effective_number(of_motions))
    if (total := np.sum(square)) > 0.0:
        first = int(np.argmax(square[: len(blocks)]))
        row |= {"largest_share": square[first] / total, "largest_motion": blocks[first]}
    return row


def demand_effects(
    pairs: Pairs,
    *,
    names: Sequence[str],
    settings: FitSettings,
    reference_im: Mapping[tuple[str, str], float],
) -> tuple[list[Row], list[Row]]:
    """Return rows of `effects` and of `intensity_effects` for the demands ``names`` of pairs."""
    rows: list[Row] = []
    by_intensity: list[Row] = []
    has_im = f"{settings.im}_from" in pairs.table
    im = pairs.ends(settings.im)[1] if has_im else np.full(pairs.side.size, nan)
    ln_im = np.log(np.where(im > 0.0, im, nan))
    cells = [({"scope": "variant", **labels}, cell_rows) for labels, cell_rows in pairs.cells]
    scopes = [({"scope": "pooled"}, np.arange(im.size)), *cells]
    for name in names:
        column, reference = column_of(name), pairs.ends(name)[1]
        difference = None if column is None else column.difference
        ratios, discordant = pairs.changes(name, None)
        means, lines = pairs.means(ratios), pairs.means(ratios, ln_im)
        is_used, differences = np.isfinite(ratios), None
        common = {**pairs.labels, "demand": name, "margin": settings.relative_margin(name)}
        common["quantity"] = verdicts.DEMAND
        if difference is not None:
            changes, discordant = pairs.changes(name, difference)
            is_used, differences = np.isfinite(changes), pairs.means(changes)
            common |= {"judged_by": verdicts.DIFFERENCE, "unit": difference.unit}
            common["difference_margin"] = settings.margins.get(name, difference.margin)
        is_exact = is_used & (pairs.side == EXACT)
        estimates = zip(means, lines, differences or [None] * len(means), strict=True)
        for (labels, cell_rows), (mean, line, change) in zip(scopes, estimates, strict=True):
            exact = cell_rows[is_exact[cell_rows]]
            positive = reference[exact][reference[exact] > 0.0]
            row = {**common, **labels, **pairs.counts(cell_rows, is_used, discordant)}
            row |= effect_row(mean, blocks=pairs.names, line=line, difference=change)
            row["from_mean"] = float(np.exp(np.log(positive).mean())) if positive.size else nan
            if exact.size:
                row |= {"im_low": float(im[exact].min()), "im_high": float(im[exact].max())}
            rows.append(row)
        pooled = rows[-len(scopes)]
        judged_cells = (differences or means)[1:]
        pooled["n_cells"] = sum(bool(np.isfinite(cell.estimate)) for cell in judged_cells)
        if difference is None:
            im_of_model = reference_im.get((pooled.get("bridge", ""), pooled.get("abutment", "")))
            exact = np.flatnonzero(is_exact & (reference > 0.0) & np.isfinite(ln_im))
            x, y = ln_im[exact], np.log(reference[exact])
            trend = np.polyfit(x, y, 1) if np.unique(x).size > 1 else np.full(2, nan)
            by_intensity += _by_intensity(pooled, lines[0], trend, im_of_model)
    return rows, by_intensity


def _by_intensity(
    pooled: Mapping[str, Any], line: Jackknifed, trend: Floats, reference_im: float | None
) -> list[dict[Any, Any]]:
    # `line`: effect on ln intensity; `trend` (2,): line of ln demand at from_value on ln intensity
    low, high = pooled.get("im_low", nan), pooled.get("im_high", nan)
    if not np.all(np.isfinite(line.estimate)) or not low < high:
        return []
    im = np.geomspace(low, high, _INTENSITIES)
    if reference_im is not None:
        im = np.append(im, np.clip(reference_im, low, high))
    effect = line.combined(np.stack([np.ones(im.size), np.log(im)]))
    logs = np.stack([effect.estimate, *effect.interval(pooled["level"])])
    logs[:, ~(logs[2] - logs[1] <= np.log(verdicts.MAX_WIDTH))] = nan
    below, zero, above = np.log1p(np.outer([-1.0, 0.0, 1.0], np.full(im.size, pooled["margin"])))
    possible = np.repeat(verdicts.may_be_negligible(pd.DataFrame([pooled])), im.size)
    verdict = verdicts.verdicts_of(logs[1], below, zero, above, logs[2], possible=possible)
    ln_demand, is_reference = np.polyval(trend, np.log(im)), np.arange(im.size) == _INTENSITIES
    columns = {name: pooled[name] for name in INTENSITY_COLUMNS if name in pooled}
    columns |= dict(zip(verdicts.RATIOS, np.exp(logs), strict=True))
    columns |= {"im": im, "verdict": verdict}
    columns |= {"from_demand": np.exp(ln_demand), "to_demand": np.exp(ln_demand + logs[0])}
    columns |= {"at_reference": is_reference, "clipped": is_reference & (im != reference_im)}
    columns["n_motions"] = int(np.count_nonzero(effect.exact))
    return pd.DataFrame(columns).to_dict("records")


def median_effects(
    models: Sequence[BridgeModels],
    limit_states: States,
    settings: FitSettings = DEFAULTS,
    *,
    curves: pd.DataFrame | None = None,
    axes: Sequence[str] = (),
) -> pd.DataFrame:
    """Return the ratios of median capacities along every axis, with pooled ratios first.

    Pairs of variants (cells) are those of `variant_pairs`. Each variant needs five motions, and
    some of its runs, but not all, must exceed the state. A pooled row is the average of ln ratio
    over the pairs; rows with the scope ``by_value`` are averages at one value of another axis.
    If ``curves`` are given, a ratio needs at least one variant that has a curve, and unknown
    outcomes may change it by 15 % at most. ``axes`` are the ``further`` columns of `fit_models`;
    only their effects are then returned.
    """
    rows: list[Row] = []
    for bridge in models:
        medians = Medians(bridge, limit_states, settings.margin, curves)
        for axis in axes or demand_table.varying_axes(bridge.variants):
            rows += medians.rows(axis, limit_states)
    return effect_table(models[0].runs, rows)


def _doubts(rows: Sequence[Row]) -> Row:
    """Return the doubts in the mean ratio of pairs of variants: curves that lack, ln change."""
    missing, change = (sum(row[name] for row in rows) for name in ("n_without_curve", "change"))
    return {"n_without_curve": missing, "change": change / len(rows)}


def _is_withheld(row: Row, pairs: int) -> bool:
    """Return whether the mean ratio of ``pairs`` pairs of variants is withheld for its `_doubts`.

    ``change`` is the change of its logarithm by unknown outcomes.
    """
    # ASSUME a ratio of medians is worth reporting if at least one of them has a curve and
    # unknown outcomes, treated equally in all variants, change it by no more than 15 %
    missing = row["n_without_curve"]
    is_wide = missing > 0 and not abs(row["change"]) <= np.log(MAX_BOUNDS_RATIO)
    return is_wide or missing == 2 * pairs


class Medians:
    """Medians of all variants of one bridge and abutment model, and the ratios between them."""

    def __init__(
        self, models: BridgeModels, states: States, margin: float, curves: pd.DataFrame | None
    ) -> None:
        self.models, self._margin, runs = models, margin, models.runs
        self._variants = records_of(models.variants)
        self._blocks = demand_table.block_names(runs)
        self._motion = demand_table.motion_codes(runs)
        self._im = runs[models.im].to_numpy(dtype=np.float64)
        self._rows = [np.flatnonzero(models.variant == v) for v in range(len(models.variants))]
        self._outcomes = outcomes_by_state(runs, states)
        #: For each state of a variant: whether it has a curve, and the change of its ln median if
        #: unknown outcomes do not exceed instead of exceed; empty if curves are not given.
        self._has_curve: dict[Any, bool] = {}
        self._change: dict[Any, float] = {}
        if curves is not None:
            keys = ["variant", "component", "limit_state"]
            self._has_curve = curves.groupby(keys)["preferred"].any().to_dict()
            by_model = curves[curves["method"] == "cloud"].set_index(keys)
            change = by_model["theta_none_exceed"] / by_model["theta_all_exceed"]
            self._change = change.astype(np.float64).map(np.log).to_dict()

    def rows(self, axis: str, states: States) -> list[Row]:
        """Return the rows of `median_effects` for the effects of an axis on medians of states."""
        variants = self.models.variants
        other_axes, pairs = variant_pairs(variants, axis)
        steps = [records_of(cells) for _, cells in pairs.groupby(list(STEP))]
        effects: list[Row] = []
        for cells, state in product(steps, states):
            keys = {**self.models.labels, "quantity": verdicts.MEDIAN_CAPACITY, "axis": axis}
            keys |= {"demand": state.key, "margin": self._margin}
            keys |= {name: float(cells[0][name]) for name in STEP}
            ratios: list[tuple[Jackknifed, Row]] = []
            for cell in cells:
                if (ratio := self._ratio(cell, state)) is not None:
                    values = {name: float(cell[name]) for name in other_axes}
                    ratios.append((ratio[0], {**keys, **values, axis: nan, **ratio[1]}))
            if ratios:
                effects += self._effects(keys, ratios, other_axes)
        return effects

    def _effects(
        self, keys: Row, ratios: list[tuple[Jackknifed, Row]], other_axes: Sequence[str]
    ) -> list[Row]:
        """Return the pooled row, rows by value of another axis, and a row per pair of variants."""
        pooled = self._average("pooled", keys, ratios)
        by_value: list[Row] = []
        tests: list[tuple[float, str]] = []
        for name in other_axes:
            values = sorted({row[name] for _, row in ratios})
            if len(values) < 2:
                continue
            groups = [[pair for pair in ratios if pair[1][name] == value] for value in values]
            means = [average([ratio for ratio, _ in group]) for group in groups]
            tests += [(float(mean.minus(means[0]).p_value()), name) for mean in means[1:]]
            for value, group in zip(values, groups, strict=True):
                by_value.append(self._average("by_value", keys | {name: value}, group))
        # each value of each other axis is tested against the first value: Bonferroni
        tests = [test for test in tests if isfinite(test[0])]
        p_value, name = min(tests, default=(nan, ""))
        return [
            pooled | {"p_interaction": len(tests) * p_value, "interaction": name},
            *by_value,
            *(self._row("variant", pair, row, 1) for pair, row in ratios),
        ]

    def _average(self, scope: str, keys: Row, ratios: list[tuple[Jackknifed, Row]]) -> Row:
        rows = [row for _, row in ratios]
        row: Row = {**keys, "n_cells": len(rows), "n_motions": int(np.max(self._motion)) + 1}
        for name in ("n_bounds", "n_discordant", "n_pairs", "n_extrapolated"):
            row[name] = sum(of_pair[name] for of_pair in rows)
        row["im_low"] = min(of_pair["im_low"] for of_pair in rows)
        row["im_high"] = max(of_pair["im_high"] for of_pair in rows)
        row["from_mean"] = float(np.exp(np.mean(np.log([r["from_mean"] for r in rows]))))
        row |= _doubts(rows)
        return self._row(scope, average([ratio for ratio, _ in ratios]), row, len(rows))

    def _row(self, scope: str, ratio: Jackknifed, row: Row, pairs: int) -> Row:
        if _is_withheld(row, pairs):
            level = EFFECT_CONFIDENCE
            return row | {"scope": scope, "status": verdicts.NO_CURVE, "level": level}
        return row | {"scope": scope} | effect_row(ratio, blocks=self._blocks)

    def withheld(self, cells: Sequence[Mapping[Any, Any]], state: LimitState) -> bool:
        """Return whether the mean ratio of pairs of variants has the status `NO_CURVE`."""
        return _is_withheld(_doubts([self._pair_doubts(cell, state) for cell in cells]), len(cells))

    def _ratio(self, cell: Mapping[Any, Any], state: LimitState) -> tuple[Jackknifed, Row] | None:
        numbers = cell["number_from"], cell["number_to"]
        start, end = (self.curve(state, number) for number in numbers)
        if start is None or end is None:
            return None
        thetas = np.exp([start.ln_theta[0], end.ln_theta[0]]).tolist()
        runs = [self._rows[number] for number in numbers]
        ranges = [motion_means.covered_range(self._im[rows], self._motion[rows]) for rows in runs]
        columns: Row = {"from_mean": thetas[0], "im_low": min(thetas), "im_high": max(thetas)}
        is_bound = self._outcomes[state].is_bound
        columns |= {"n_bounds": max(int(np.sum(is_bound[rows])) for rows in runs)}
        columns |= {"n_discordant": 0, "n_pairs": min(rows.size for rows in runs)}
        columns["n_motions"] = min(np.unique(self._motion[rows]).size for rows in runs)
        inside = [low <= x <= high for x, (low, high) in zip(thetas, ranges, strict=True)]
        columns["n_extrapolated"] = inside.count(False)
        return end.ln_ratio(start), columns | self._pair_doubts(cell, state)

    def _pair_doubts(self, cell: Mapping[Any, Any], state: LimitState) -> Row:
        """Return how many variants of a pair lack a curve, and the change by unknown outcomes.

        Without curves, the number is NaN. A missing curve for other doubts is an infinite change.
        """
        keys = [(str(cell[f"variant_{n}"]), state.component, state.name) for n in ("from", "to")]
        lacks_curve = [not self._has_curve.get(key, True) for key in keys]
        changes = [self._change.get(key, 0.0) for key in keys]
        for i, change in enumerate(changes):
            if lacks_curve[i] and abs(change) <= np.log(MAX_BOUNDS_RATIO):
                changes[i] = np.inf
        missing = sum(lacks_curve) if self._has_curve else nan
        return {"n_without_curve": missing, "change": changes[1] - changes[0]}

    def curve(self, state: LimitState, number: int) -> StateCurve | None:
        """Return the curve of a state in a variant; None if it is not used in ratios."""
        rows = self._rows[number]
        if np.unique(self._motion[rows]).size < MIN_MOTIONS:
            return None
        if self._outcomes[state].of(rows).status(state) != FITTED:
            return None
        curve = self.models.curve(state, self._variants[number])
        return None if isinstance(curve, str) else curve
