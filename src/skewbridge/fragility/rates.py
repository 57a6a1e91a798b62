"""Annual rates of limit states and systems, and effects of the axes on them.

A rate is the integral of a fragility curve (theta and beta_total, or a union) over a hazard curve.
Its interval, and that of a ratio of rates, are from the jackknife over motions, as for medians. A
ratio is for the same motions and the same hazard.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, partial
from math import nan
from typing import Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.files.tables import Floats, Row, records_of
from skewbridge.fragility import demand_table
from skewbridge.fragility.curves import CURVE_COLUMNS, METHODS
from skewbridge.fragility.demand_model import BridgeModels, StateCurve
from skewbridge.fragility.effects import effect_row
from skewbridge.fragility.fits import ALL_EXCEED, BOUNDS_TOO_WIDE, FITTED, NO_EXCEEDANCE
from skewbridge.fragility.hazard import HazardCurve, LogRate
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.outcomes import TREATMENTS, demand_outcomes
from skewbridge.fragility.paper_table import chosen_curves
from skewbridge.fragility.settings import EFFECT_CONFIDENCE, FitSettings
from skewbridge.fragility.union import curve_probability, union_curve

SYSTEM: Final = "system"
YEARS: Final = 50.0
_ENDS: Final = ("", "_low", "_high")
_LEAST_MOTIONS: Final = 5  # as for ratios of medians
_STEP: Final = ("from_value", "to_value")
_STATE: Final = ("variant", "component", "limit_state")
_BOUNDS: Final = ["theta_bound_low", "theta_bound_high", "theta_bound_beta"]
_STEP_SIZE: Final = 1e-4  # of ln theta and beta, for derivatives


def rate_columns(rates: Sequence[float]) -> Row:
    """Return the columns of an annual rate with its interval, and of the 50-year probability."""
    row = {f"annual_rate{end}": float(rate) for end, rate in zip(_ENDS, rates, strict=True)}
    years = [float(-np.expm1(-YEARS * rate)) for rate in row.values()]
    return row | {f"probability_50y{end}": p for end, p in zip(_ENDS, years, strict=True)}


def curve_rate(hazard: HazardCurve, curve: StateCurve) -> LogRate:
    """Return the ln rate of the curves of a state, from all runs and without each block."""
    narrow = curve.total if curve.modes is None else curve.modes.beta
    return hazard.rate(partial(_probability, curve), float(np.nanmin(narrow)))


def _probability(curve: StateCurve, ln_im: Floats) -> Floats:
    if curve.modes is not None:
        return curve.modes.probability(ln_im)
    return special.ndtr((ln_im - curve.ln_theta) / curve.total)


def _lognormal(theta: float, beta: float, hazard: HazardCurve) -> LogRate:
    def probability(ln_im: Floats) -> Floats:
        return special.ndtr((ln_im - np.log(theta)) / beta)

    return hazard.rate(probability, beta)


def _of_row(curve: Row, hazard: HazardCurve) -> LogRate:
    """Return the ln rate of a row of table `curves`, without replicates."""
    union = union_curve(curve)
    if union is None:
        return _lognormal(curve["theta"], _total(curve), hazard)
    narrow = float(np.min(union.beta))
    return hazard.rate(lambda ln_im: curve_probability(np.exp(ln_im), curve), narrow)


def _total(curve: Row) -> float:
    return curve["beta"] if pd.isna(curve["beta_total"]) else curve["beta_total"]


def state_columns(
    curve: Row,  # row of table `curves`
    model: StateCurve | None,  # its curve by the demand model, with replicates
    hazard: HazardCurve,
    level: float,
) -> Row:
    """Return the columns of rate, interval and shares of a limit state in a variant.

    A state with wide bounds has the rates of its bounds, and one that no run (or every run) exceeds
    that of the bound of its median.
    """
    status, found = curve["status"], (nan, nan, nan)
    row: Row = {"status": status, "method": curve["method"], "im": curve["im"], "level": level}
    capacity = float(np.nan_to_num(curve["capacity_dispersion"]))
    # ASSUME a bound of a median has the slope 1 for the dispersion of its capacity
    wide = float(np.hypot(curve["theta_bound_beta"], capacity))
    of_bounds = partial(_lognormal, beta=wide, hazard=hazard)
    if status == FITTED:
        rate = _of_row(curve, hazard)
        if model is not None and curve["method"] == METHODS[0]:
            found = curve_rate(hazard, model).interval(level)
        else:
            found = _with_variance(curve, rate, hazard, level)
        p = curve_probability(hazard.levels[[0, -1]], curve)
        covered = curve["im_low"], curve["im_high"]
        row |= hazard.shares(partial(_of_row, curve), p, *covered)
    elif status == BOUNDS_TOO_WIDE and model is not None:
        extra = np.sqrt(np.maximum(model.total[0] ** 2 - model.beta[0] ** 2, 0.0))
        own, factors = curve_rate(hazard, model).interval(level), list[float]()
        for name in TREATMENTS:
            beta = float(np.hypot(curve[f"beta_{name}"], extra))
            factors.append(_lognormal(curve[f"theta_{name}"], beta, hazard).value / own[0])
        # the interval of the model, widened to the bounds
        found = nan, own[1] * min(1.0, *factors), own[2] * max(1.0, *factors)
    elif status == NO_EXCEEDANCE:
        found = nan, 0.0, of_bounds(curve["theta_bound_low"]).value
    elif status == ALL_EXCEED:
        found = nan, of_bounds(curve["theta_bound_high"]).value, hazard.rates[0, 0]
    return row | rate_columns(found)


def _with_variance(
    curve: Row, rate: LogRate, hazard: HazardCurve, level: float
) -> tuple[float, float, float]:
    """Return a rate with its interval from the variances of ln theta and beta (delta method)."""
    theta, total = curve["theta"], _total(curve)
    steps = (theta, total), (theta * np.exp(_STEP_SIZE), total), (theta, total + _STEP_SIZE)
    logs = [_lognormal(*each, hazard).logs[0] for each in steps]
    slope = (logs[1] - logs[0]) / _STEP_SIZE
    of_beta = (logs[2] - logs[0]) / _STEP_SIZE * curve["beta"] / total
    variance = slope**2 * curve["var_ln_theta"] + of_beta**2 * curve["var_beta"]
    variance += 2.0 * slope * of_beta * curve["cov_ln_theta_beta"]
    factor = float(np.exp(special.ndtri(0.5 + 0.5 * level) * np.sqrt(variance)))
    return rate.value, rate.value / factor, rate.value * factor


def with_bounds(curves: pd.DataFrame) -> pd.DataFrame:
    """Return curves in which bounds of medians, which one method gives, are in all methods."""
    names = [name for name in _BOUNDS if name in curves]
    largest = curves.groupby(list(_STATE))[names].transform("max")
    return curves.assign(**{name: largest[name] for name in names})


def rates_of_curves(curves: pd.DataFrame, joint: pd.DataFrame, hazard: HazardCurve) -> pd.DataFrame:
    """Return the columns of `state_columns` of curves, indexed as ``curves``.

    ``joint`` is the table next to them, possibly empty; without it, intervals are from variances.
    """
    names = ["bridge", "abutment", "component", "limit_state"]
    models = {
        tuple(row[name] for name in names): JointModel(row)
        for row in records_of(joint[joint["modes"].notna()])
    }
    rows: list[Row] = []
    columns = dict.fromkeys([*curves, *CURVE_COLUMNS])
    for row in records_of(curves.reindex(columns=list(columns))):
        model = models.get(tuple(row[name] for name in names))
        curve = model.curve(row) if model else None
        found = None if curve is None or np.isnan(curve.ln_theta[0]) else curve
        rows.append(state_columns(row, found, hazard, row["level"]))
    return pd.DataFrame(rows, curves.index)


def rate_table(
    curves: pd.DataFrame, joint: pd.DataFrame, system: pd.DataFrame, hazard: HazardCurve
) -> pd.DataFrame:
    """Return table `rates`: one row per variant and limit state, then per degree of the system.

    ``system`` has the columns `rate` and `shares` of `system_curves` with a hazard.
    """
    chosen, columns = chosen_curves(with_bounds(curves)), demand_table.variant_columns(curves)
    places = chosen[[*columns, *_STATE[1:]]]
    states = places.join(rates_of_curves(chosen, joint, hazard))
    rows: list[Row] = []
    for row in records_of(system):
        place = {name: row[name] for name in (*columns, "limit_state", "status", "level")}
        place |= {"component": SYSTEM, "method": SYSTEM, "im": hazard.im}
        has = isinstance(row["rate"], LogRate)
        found = row["rate"].interval(row["level"]) if has else (nan, nan, nan)
        rows.append(place | (row["shares"] if has else {}) | rate_columns(found))
    rows = [*records_of(states), *rows]
    return pd.DataFrame(rows, columns=list(demand_table.described("rates")))


def _effects(
    models: BridgeModels,
    states: Sequence[LimitState | str],  # a text is a degree of damage of the system
    hazard: HazardCurve,
    settings: FitSettings,
    axis: str,
    *,
    fitted: frozenset[tuple[str, ...]] | None,  # variant, component, state with a curve; None: all
    system: Mapping[tuple[str, str], LogRate],  # keys: variant, degree
) -> list[Row]:
    """Return the effects of an axis on the rates of one bridge, pooled and of pairs of variants."""
    variants, blocks = models.variants, demand_table.block_names(models.runs)

    @cache
    def rate_of(state: LimitState | str, number: int) -> LogRate | None:
        values = records_of(variants)[number]
        if isinstance(state, str):
            return system.get((values["variant"], state))
        runs, curve = models.runs[models.variant == number], models.curve(state, values)
        enough = runs["motion_id"].nunique() >= _LEAST_MOTIONS
        if not enough or demand_outcomes(runs, [state]).status(state) != FITTED:
            return None
        return None if isinstance(curve, str) else curve_rate(hazard, curve)

    def row(scope: str, start: LogRate, end: LogRate) -> Row:
        change = end.minus(start)
        found = {"scope": scope, "n_motions": len(blocks)}
        found |= {"from_rate": start.value, "to_rate": end.value}
        found |= effect_row(change.jackknifed, settings, blocks=blocks)
        ratio, low, high = change.interval(EFFECT_CONFIDENCE)
        found |= {"ratio": ratio, "ci_low": low, "ci_high": high}
        return found | {"direction": int(low > 1.0) - int(high < 1.0)}

    names = list(dict.fromkeys([*demand_table.axis_names(variants), axis]))
    others = [name for name in names if name != axis]
    rows: list[Row] = []
    for step, cells in _pairs(variants, axis, others).groupby(list(_STEP)):
        place = models.place | {"axis": axis, **dict(zip(_STEP, step, strict=True))}
        for state in states:
            key = (SYSTEM, state) if isinstance(state, str) else (state.component, state.name)
            # ASSUME a ratio is worth reporting if at least one of both variants has a curve
            usable = [
                cell
                for cell in records_of(cells)
                if fitted is None or key[0] == SYSTEM
                or {(cell[f"variant_{end}"], *key) for end in ("from", "to")} & fitted
            ]  # fmt: skip
            ends = [[rate_of(state, cell[f"number_{end}"]) for end in ("from", "to")]
                    for cell in usable]  # fmt: skip
            both = [(cell, a, b) for cell, (a, b) in zip(usable, ends, strict=True) if a and b]
            own = place | dict(zip(_STATE[1:], key, strict=True))
            if both:
                means = _mean([a for _, a, _ in both]), _mean([b for *_, b in both])
                rows.append(own | {"n_cells": len(both)} | row("pooled", *means))
            for cell, a, b in both:
                rows.append(own | {n: cell[n] for n in others} | row("variant", a, b))
    return rows


def _pairs(variants: pd.DataFrame, axis: str, others: Sequence[str]) -> pd.DataFrame:
    """Return the pairs of variants that differ in one axis, each with the smallest value of it."""
    keys = [*demand_table.BRIDGE_COLUMNS, *others]
    table = variants[["variant", *keys, axis]].assign(number=np.arange(len(variants)))
    lowest = table.groupby(keys, dropna=False)[axis].transform("min")
    pairs = table.merge(table[table[axis] == lowest], on=keys, suffixes=("_to", "_from"))
    pairs = pairs.rename(columns={f"{axis}_from": _STEP[0], f"{axis}_to": _STEP[1]})
    return pairs[pairs[_STEP[1]] > pairs[_STEP[0]]]


def _mean(rates: Sequence[LogRate]) -> LogRate:
    """Return the mean of ln rates; a block without an estimate has no influence."""
    logs = [np.where(np.isfinite(rate.logs), rate.logs, rate.logs[0]) for rate in rates]
    fractiles = np.mean([rate.fractiles for rate in rates], axis=0)
    return LogRate(np.mean(logs, axis=0), fractiles, rates[0].quantiles)


def rate_effects(
    models: Iterable[BridgeModels],
    states: States,
    hazard: HazardCurve,
    settings: FitSettings,
    *,
    curves: pd.DataFrame | None = None,  # a ratio then needs a variant with a curve
    system: pd.DataFrame | None = None,  # as for `rate_table`
    axes: Sequence[str] = (),  # only the effects of these columns, which distinguish variants
) -> pd.DataFrame:
    """Return table `rate_effects`: ratios of annual rates along every axis, pooled rows first.

    Pairs of variants are those of `median_effects`; a pooled row is their geometric mean.
    """
    rates, fitted = dict[tuple[str, str], LogRate](), None
    degrees: list[str] = []
    if system is not None:
        rated = records_of(system[[isinstance(rate, LogRate) for rate in system["rate"]]])
        rates = {(row["variant"], row["limit_state"]): row["rate"] for row in rated}
        degrees = list(dict.fromkeys(map(str, system["limit_state"])))
    if curves is not None:
        has = curves[curves["preferred"] & (curves["status"] == FITTED)]
        fitted = frozenset(zip(*(has[name] for name in _STATE), strict=True))
    rows = [
        row
        for each in models
        for axis in axes or demand_table.varying_axes(each.variants)
        for row in _effects(
            each, [*states, *degrees], hazard, settings, axis, fitted=fitted, system=rates
        )
    ]
    table = pd.DataFrame(rows, columns=list(demand_table.described("rate_effects")))
    return table.sort_values("scope", kind="stable", ignore_index=True)
