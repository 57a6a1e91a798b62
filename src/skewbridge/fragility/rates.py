"""Annual rates of limit states and systems, and effects of the axes on them.

A rate is the integral of the probability of the demand model over a hazard curve; without a model,
of the lognormal curve with theta and beta_total, or of a union.
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
from skewbridge.fragility.effects import STEP, Medians, effect_row, variant_pairs
from skewbridge.fragility.fits import ALL_EXCEED, BOUNDS_TOO_WIDE, FITTED, NO_EXCEEDANCE
from skewbridge.fragility.hazard import HazardCurve, LogRate
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.motion_means import completed
from skewbridge.fragility.outcomes import TREATMENTS
from skewbridge.fragility.paper_table import chosen_curves
from skewbridge.fragility.settings import EFFECT_CONFIDENCE, FitSettings
from skewbridge.fragility.union import any_of, union_curve

SYSTEM: Final = "system"
YEARS: Final = 50.0
_ENDS: Final = ("", "_low", "_high")
_STATE: Final = ["variant", "component", "limit_state"]
_BOUNDS: Final = ["theta_bound_low", "theta_bound_high", "theta_bound_beta"]


def rate_columns(rates: Sequence[float]) -> Row:
    """Return the columns of an annual rate with its interval, and of the 50-year probability."""
    row = {f"annual_rate{end}": float(rate) for end, rate in zip(_ENDS, rates, strict=True)}
    years = [float(-np.expm1(-YEARS * rate)) for rate in row.values()]
    return row | {f"probability_50y{end}": p for end, p in zip(_ENDS, years, strict=True)}


def exceedance(curve: StateCurve, ln_im: Floats) -> Floats:
    """Return P(exceeds) of R curves, shape (k, R), at ln im (k, 1).

    It is that of the demand models if there are any: their scatter may grow with the intensity.
    """
    if curve.points:
        u = [point.score(s.threshold, s.dispersion, ln_im) for point, s in curve.points]
        return any_of(u, np.zeros(1) if curve.modes is None else curve.modes.rho)
    if curve.modes is not None:
        return curve.modes.probability(ln_im)
    return special.ndtr((ln_im - curve.ln_theta) / curve.total)


def curve_rate(curve: StateCurve, hazard: HazardCurve, ln_factor: float = 0.0) -> LogRate:
    """Return the ln rate of R curves with medians times exp(ln_factor); NaN without a curve."""
    wide = curve.total if curve.modes is None else curve.modes.beta
    narrow = float(np.nanmin(wide, initial=9.0))
    return hazard.rate(lambda ln_im: exceedance(curve, ln_im - ln_factor), narrow)


def _lognormal(theta: float, beta: float, hazard: HazardCurve) -> float:
    """Return the annual rate of one lognormal curve."""
    curve = StateCurve(np.log([theta]), np.array([nan]), np.array([beta]))
    return curve_rate(curve, hazard).value


def state_columns(curve: Row, model: StateCurve | None, hazard: HazardCurve) -> Row:
    """Return the columns of rate, interval and shares of a row of table `curves`.

    ``model`` has its curve by the demand model with replicates. Without it, the interval is that of
    theta. A state with wide bounds has the rates of its bounds; a state that no run, or every run,
    exceeds has the rate of the bound of its median.
    """
    status, rate_ends = curve["status"], (nan, nan, nan)
    row: Row = {name: curve[name] for name in ("status", "method", "im", "level")}
    bound_beta = np.hypot(curve["theta_bound_beta"], np.nan_to_num(curve["capacity_dispersion"]))
    if status == FITTED:
        wide = curve["beta"] if pd.isna(curve["beta_total"]) else curve["beta_total"]
        used = StateCurve(np.log([curve["theta"]]), np.array([nan]), np.array([wide]))
        used = used._replace(modes=union_curve(curve))
        if model is not None and curve["method"] == METHODS[0]:
            used = model
            rate_ends = curve_rate(model, hazard).interval(curve["level"])
        else:  # ASSUME the dispersion is known
            thetas = (curve[name] for name in ("theta", "theta_high", "theta_low"))
            middle, *ends = (_lognormal(theta, wide, hazard) for theta in thetas)
            rate = curve_rate(used, hazard).value
            rate_ends = rate, *(rate * end / middle for end in ends)
        p = exceedance(used, np.log(hazard.levels[[0, -1]])[:, None])[:, 0]
        row |= hazard.shares(partial(curve_rate, used), p, curve["im_low"], curve["im_high"])
    elif status == BOUNDS_TOO_WIDE and model is not None:
        # the interval of the model, widened to the bounds with the dispersion of the capacity
        extra = np.maximum(model.total[0] ** 2 - model.beta[0] ** 2, 0.0)
        rate, low, high = curve_rate(model, hazard).interval(curve["level"])
        bounds = [
            (curve[f"theta_{n}"], np.hypot(curve[f"beta_{n}"], extra**0.5)) for n in TREATMENTS
        ]
        factors = [1.0, *(_lognormal(*bound, hazard) / rate for bound in bounds)]
        rate_ends = nan, low * np.nanmin(factors), high * np.nanmax(factors)
    # ASSUME a bound of a median has the slope 1 for the dispersion of its capacity
    elif status == NO_EXCEEDANCE:
        rate_ends = nan, 0.0, _lognormal(curve["theta_bound_low"], bound_beta, hazard)
    elif status == ALL_EXCEED:
        least = _lognormal(curve["theta_bound_high"], bound_beta, hazard)
        rate_ends = nan, least, float(hazard.rates[0, 0])
    return row | rate_columns(rate_ends)


def with_bounds(curves: pd.DataFrame) -> pd.DataFrame:
    """Return curves in which bounds of medians, which one method gives, are in all methods."""
    names = [name for name in _BOUNDS if name in curves]
    largest = curves.groupby(_STATE)[names].transform("max")
    return curves.assign(**{name: largest[name] for name in names})


def rates_of_curves(curves: pd.DataFrame, joint: pd.DataFrame, hazard: HazardCurve) -> pd.DataFrame:
    """Return the columns of `state_columns`, indexed as ``curves``; ``joint`` may be empty."""
    key = ["bridge", "abutment", "component", "limit_state"]
    usable = joint[joint["modes"].notna()]
    models = {tuple(row[n] for n in key): JointModel(row) for row in records_of(usable)}
    rows: list[Row] = []
    table = curves.reindex(columns=list(dict.fromkeys([*curves, *CURVE_COLUMNS])))
    for row in records_of(table):
        model = models.get(tuple(row[n] for n in key))
        curve = model.curve(row) if model else None
        has = curve is not None and np.isfinite(curve.ln_theta[0])
        rows.append(state_columns(row, curve if has else None, hazard))
    return pd.DataFrame(rows, curves.index)


def rate_table(
    curves: pd.DataFrame, joint: pd.DataFrame, system: pd.DataFrame, hazard: HazardCurve
) -> pd.DataFrame:
    """Return table `rates`: one row per variant and limit state, then per degree of the system.

    ``system`` has the columns `rate` and `shares` of `system_curves` with a hazard.
    """
    chosen, columns = chosen_curves(with_bounds(curves)), demand_table.variant_columns(curves)
    states = chosen[[*columns, *_STATE[1:]]].join(rates_of_curves(chosen, joint, hazard))
    rows = records_of(states)
    for row in records_of(system):
        place = {name: row[name] for name in (*columns, "limit_state", "status", "level")}
        place |= {"component": SYSTEM, "method": SYSTEM, "im": hazard.im}
        has = isinstance(row["rate"], LogRate)
        rate_ends = row["rate"].interval(row["level"]) if has else (nan, nan, nan)
        rows.append(place | (row["shares"] if has else {}) | rate_columns(rate_ends))
    return pd.DataFrame(rows, columns=list(demand_table.described("rates")))


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

    Pairs of variants are those of `median_effects`; those of a system have the same components. A
    pooled row is their geometric mean.
    """
    known = [] if system is None else records_of(system)
    systems = {(row["variant"], row["limit_state"]): row for row in known}
    # the states, then the degrees of the system as texts
    both = [*states, *dict.fromkeys(row["limit_state"] for row in known)]
    rows: list[Row] = []
    for of_bridge in models:
        blocks = demand_table.block_names(of_bridge.runs)
        motions = of_bridge.runs["motion_id"].nunique()
        medians = Medians(of_bridge, states, settings, curves)
        for axis in axes or demand_table.varying_axes(of_bridge.variants):
            for place, scope, start, end in _changes(medians, axis, both, hazard, systems):
                change = end.minus(start)
                row = effect_row(change.jackknifed, settings, blocks=blocks)
                ends = change.interval(EFFECT_CONFIDENCE)
                row |= dict(zip(("ratio", "ci_low", "ci_high"), ends, strict=True))
                row |= {"direction": int(ends[1] > 1.0) - int(ends[2] < 1.0), "scope": scope}
                row |= {"from_rate": start.value, "to_rate": end.value, "n_motions": motions}
                rows.append(place | row)
    table = pd.DataFrame(rows, columns=list(demand_table.described("rate_effects")))
    return table.sort_values("scope", kind="stable", ignore_index=True)


def _changes(
    medians: Medians,
    axis: str,
    states: Sequence[LimitState | str],
    hazard: HazardCurve,
    systems: Mapping[tuple[str, str], Row],  # keys: variant, degree
) -> list[tuple[Row, str, LogRate, LogRate]]:
    """Return place, scope and both ln rates of pairs that differ in one axis, and their means."""
    variants = medians.models.variants

    @cache
    def rate_of(state: LimitState | str, number: int) -> LogRate | None:
        if isinstance(state, str):
            rate = systems.get((variants["variant"].iloc[number], state), {}).get("rate")
            return rate if isinstance(rate, LogRate) else None
        curve = medians.curve(state, number)
        return None if curve is None else curve_rate(curve, hazard)

    def is_usable(state: LimitState | str, cell: Row) -> bool:
        if isinstance(state, str):
            names = (cell["variant_from"], cell["variant_to"])
            return len({systems[name, state]["components"] for name in names}) == 1
        # ASSUME a ratio is worth reporting if at least one of both variants has a curve
        return medians.without_curve(cell, state) != 2

    others, pairs = variant_pairs(variants, axis)
    changes: list[tuple[Row, str, LogRate, LogRate]] = []
    for step, cells in pairs.groupby(list(STEP)):
        for state in states:
            key = (SYSTEM, state) if isinstance(state, str) else (state.component, state.name)
            place = medians.models.place | {
                "axis": axis,
                **dict(zip([*STEP, *_STATE[1:]], (*step, *key), strict=True)),
            }
            rated: list[tuple[Row, str, LogRate, LogRate]] = []
            for cell in records_of(cells):
                start, end = rate_of(state, cell["number_from"]), rate_of(state, cell["number_to"])
                if start and end and is_usable(state, cell):
                    values = {name: cell[name] for name in others}
                    rated.append((place | values, "variant", start, end))
            if rated:
                means = _mean([pair[2] for pair in rated]), _mean([pair[3] for pair in rated])
                changes.append((place | {"n_cells": len(rated)}, "pooled", *means))
                changes += rated
    return changes


def _mean(rates: Sequence[LogRate]) -> LogRate:
    """Return the mean of ln rates."""
    logs = np.mean([completed(rate.logs) for rate in rates], axis=0)
    fractiles = np.mean([rate.fractiles for rate in rates], axis=0)
    return LogRate(logs, fractiles, rates[0].quantiles)
