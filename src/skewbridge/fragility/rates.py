"""Annual rates of limit states and systems, their changes with the axes, and seats for a target.

A rate is the exceedance probability integrated over a hazard curve. The probability is from the
demand model or, without one, from the lognormal curve with theta and beta_total or a union. The
intervals of rates and of their ratios are from the jackknife over motions, as for medians. Both
rates of a ratio are for the same motions and the same hazard.

The support length needed at rest is the displacement that a deck corner exceeds with the target
rate; the seat is longer by the gap. Code rules are in `bridge_check`, Hazus in `limit_states`.
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
from itertools import compress, product
from math import inf, nan
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Row, records_of
from skewbridge.fragility import demand_table
from skewbridge.fragility.curves import CURVE_COLUMNS, METHODS
from skewbridge.fragility.demand_model import SKEW, BridgeModels, StateCurve
from skewbridge.fragility.effects import STEP, Medians, variant_pairs
from skewbridge.fragility.exports import chosen_curves
from skewbridge.fragility.fits import ALL_EXCEED, BOUNDS_TOO_WIDE, FITTED, NO_EXCEEDANCE
from skewbridge.fragility.hazard import HazardCurve, LogRate
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.limit_states import COLUMN_FAILURE, LimitState, States, hazus_factor
from skewbridge.fragility.motion_means import completed
from skewbridge.fragility.outcomes import TREATMENTS
from skewbridge.fragility.settings import ASSUMED_BETA, EFFECT_CONFIDENCE, FitSettings
from skewbridge.fragility.system import averaged, difference
from skewbridge.fragility.union import any_of, union_curve
from skewbridge.fragility.verdicts import NOT_ESTIMABLE, OK, RATIOS

SYSTEM: Final = "system"
#: Status of the ratio of two systems that do not have the same components.
DIFFERENT_COMPONENTS: Final = "different_components"
YEARS: Final = 50.0
_ENDS: Final = ("", "_low", "_high")
#: Columns of `HazardCurve.shares` with missing shares of a rate, and their meaning.
_LACKING: Final = {
    "share_below": "below the hazard curve, up to",
    "share_outside_low": "above the hazard curve, at least",
}
# ASSUME a rate that lacks less than 5 % needs no note
_WORTH_A_NOTE: Final = 0.05
_STATE: Final = ["variant", "component", "limit_state"]


def rate_columns(rates: Sequence[float], hazard: HazardCurve, level: float) -> Row:
    """Return the columns of an annual rate with its interval, and of the 50-year probability.

    No rate of the hazard curve is above that of its lowest intensity, where the interval ends.
    """
    ends = zip(_ENDS, np.minimum(rates, hazard.highest_rate(level)), strict=True)
    row = {f"annual_rate{end}": float(rate) for end, rate in ends}
    years = [float(-np.expm1(-YEARS * rate)) for rate in row.values()]
    return row | {f"probability_50y{end}": p for end, p in zip(_ENDS, years, strict=True)}


def exceedance(curve: StateCurve, ln_im: Floats) -> Floats:
    """Return P(exceeds) of R curves, shape (k, R), at ln im (k, 1).

    Demand models are used if the curve has any, because their scatter may grow with intensity.
    """
    if curve.points:
        u = [point.score(s.threshold, s.dispersion, ln_im) for point, s in curve.points]
        return any_of(u, np.zeros(1) if curve.modes is None else curve.modes.rho)
    if curve.modes is not None:
        return curve.modes.probability(ln_im)
    return special.ndtr((ln_im - curve.ln_theta) / curve.total)


def curve_rate(curve: StateCurve, hazard: HazardCurve, ln_factor: float = 0.0) -> LogRate:
    """Return ln annual rates of the R replicates of a curve, medians times exp(ln_factor)."""
    beta = curve.total if curve.modes is None else curve.modes.beta
    narrowest = float(np.nanmin(beta, initial=9.0))
    rate = hazard.rate(lambda ln_im: exceedance(curve, ln_im - ln_factor), narrowest)
    return rate._replace(priors=curve.priors)


def rate_shares(curve: StateCurve, hazard: HazardCurve, low: float, high: float) -> Row:
    """Return the shares of the rate of a curve, with the range of the motions; see `shares`."""
    p_last = float(exceedance(curve, np.log(hazard.levels[-1:])[:, None])[0, 0])
    return hazard.shares(partial(curve_rate, curve), p_last, low, high)


def lacking_notes(rows: Sequence[Row]) -> list[str]:
    """Return notes on states whose rates lack intensities outside the hazard curve."""
    notes: list[str] = []
    for column, words in _LACKING.items():
        shares: dict[str, float] = {}
        for row in rows:
            name = f"{row['component']} {row.get('limit_state', row.get('state'))}"
            shares[name] = max(shares.get(name, 0.0), row.get(column, 0.0))
        if lacking := [f"{name} {s:.0%}" for name, s in shares.items() if s > _WORTH_A_NOTE]:
            text = f"annual_rate lacks intensities {words} these shares of a rate"
            notes.append(f"{text}: {', '.join(lacking)}")
    return notes


def _lognormal(theta: float, beta: float) -> StateCurve:
    return StateCurve(np.log([theta]), np.array([nan]), np.array([beta]))


def state_columns(curve: Row, model: StateCurve | None, hazard: HazardCurve) -> Row:
    """Return the columns of rate, interval and shares of a row of table `curves`.

    ``model`` has the curve of the row by the demand model, with replicates. Without it, the
    interval follows from that of theta. There is only an interval, no rate, if unknown outcomes
    change the median too much, or if no run or every run exceeds the state.
    """
    status, rate_ends = curve["status"], (nan, nan, nan)
    row: Row = {name: curve[name] for name in ("status", "method", "im", "level")}
    bound_beta = np.hypot(ASSUMED_BETA, np.nan_to_num(curve["capacity_dispersion"]))

    def rate_of(theta: float, beta: float) -> LogRate:
        return curve_rate(_lognormal(theta, beta), hazard)

    if status == FITTED:
        beta_total = curve["beta"] if pd.isna(curve["beta_total"]) else curve["beta_total"]
        if model is not None and curve["method"] == METHODS[0]:
            for_rates = model
            rate_ends = curve_rate(model, hazard).interval(curve["level"])
        else:  # ASSUME the dispersion is known
            for_rates = _lognormal(curve["theta"], beta_total)._replace(modes=union_curve(curve))
            thetas = (curve[name] for name in ("theta", "theta_high", "theta_low"))
            centre, *ends = (rate_of(theta, beta_total).value for theta in thetas)
            factors = ends[0] / centre, ends[1] / centre
            rate_ends = curve_rate(for_rates, hazard).interval(curve["level"], factors)
        row |= rate_shares(for_rates, hazard, curve["im_low"], curve["im_high"])
    elif status == BOUNDS_TOO_WIDE and model is not None:
        # the interval of the model, widened to the bounds with the dispersion of the capacity
        capacity = np.maximum(model.total[0] ** 2 - model.beta[0] ** 2, 0.0) ** 0.5
        rate, low, high = curve_rate(model, hazard).interval(curve["level"])
        bounds = [(curve[f"theta_{n}"], np.hypot(curve[f"beta_{n}"], capacity)) for n in TREATMENTS]
        factors = [1.0, *(rate_of(*bound).value / rate for bound in bounds)]
        rate_ends = nan, low * np.nanmin(factors), high * np.nanmax(factors)
    # ASSUME a bound of a median has the slope 1 for the dispersion of its capacity
    elif status == NO_EXCEEDANCE:
        bound = rate_of(curve["theta_bound_low"], bound_beta)
        rate_ends = nan, 0.0, bound.interval(curve["level"], (1.0, 1.0))[2]
    elif status == ALL_EXCEED:
        bound = rate_of(curve["theta_bound_high"], bound_beta)
        rate_ends = nan, bound.interval(curve["level"], (1.0, 1.0))[1], inf
    return row | rate_columns(rate_ends, hazard, curve["level"])


def rates_of_curves(
    curves: pd.DataFrame, models: Iterable[BridgeModels], states: States, hazard: HazardCurve
) -> pd.DataFrame:
    """Return the columns of `state_columns`, indexed as ``curves``."""
    variants = {v["variant"]: (model, v) for model in models for v in records_of(model.variants)}
    of_key = {(state.component, state.name): state for state in states}
    rows: list[Row] = []
    table = curves.reindex(columns=list(dict.fromkeys([*curves, *CURVE_COLUMNS])))
    for row in records_of(table):
        model, values = variants[row["variant"]]
        curve = model.curve(of_key[row["component"], row["limit_state"]], values)
        rows.append(state_columns(row, None if isinstance(curve, str) else curve, hazard))
    return pd.DataFrame(rows, curves.index)


def rate_table(
    curves: pd.DataFrame,
    models: Iterable[BridgeModels],
    states: States,
    system: pd.DataFrame,
    hazard: HazardCurve,
) -> pd.DataFrame:
    """Return table `rates`: rows per variant and limit state, then per system degree of damage.

    ``system`` has the columns `rate` and `shares` of `system_curves` with a hazard.
    """
    # bounds of medians, which one method gives, apply to all methods
    bounds = [f"theta_bound_{name}" for name in ("low", "high")]
    largest = curves.groupby(_STATE)[bounds].transform("max")
    chosen = chosen_curves(curves.assign(**{name: largest[name] for name in bounds}))
    columns = demand_table.variant_columns(curves)
    rated = chosen[[*columns, *_STATE[1:]]].join(rates_of_curves(chosen, models, states, hazard))
    rows = records_of(rated)
    for row in records_of(system):
        keys = {name: row[name] for name in (*columns, "limit_state", "status", "level")}
        keys |= {"component": SYSTEM, "method": SYSTEM, "im": hazard.im}
        if isinstance(rate := row.get("rate"), LogRate):
            rated = row["shares"] | rate_columns(rate.interval(row["level"]), hazard, row["level"])
        else:
            bound = {"theta_bound_high": row.get("theta_bound"), "capacity_dispersion": 0.0}
            rated = state_columns(keys | bound, None, hazard)
        rows.append(keys | rated)
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

    Variants are paired as in `median_effects`. A pooled row has geometric means of pairs. Systems
    are compared if they have the same components; all other pairs have no ratio and a reason. The
    pooled row of systems has only the pairs with the components of most pairs.
    """
    system_rows = [] if system is None else records_of(system)
    systems = {(row["variant"], row["limit_state"]): row for row in system_rows}
    # the states, then the degrees of the system as texts
    all_states = [*states, *dict.fromkeys(row["limit_state"] for row in system_rows)]
    rows: list[Row] = []
    for of_bridge in models:
        motions = of_bridge.runs["motion_id"].nunique()
        medians = Medians(of_bridge, states, settings.margin, curves)

        @cache
        def rate_of(state: LimitState, number: int, medians: Medians = medians) -> LogRate | None:
            curve = medians.curve(state, number)
            return None if curve is None else curve_rate(curve, hazard)

        for axis in axes or demand_table.varying_axes(of_bridge.variants):
            for keys, rates in _changes(medians, axis, all_states, rate_of, systems):
                row: Row = {"level": EFFECT_CONFIDENCE, "direction": 0, "n_motions": motions}
                if rates:
                    start, end = rates
                    row |= {"from_rate": start.value, "to_rate": end.value}
                    ends = end.minus(start).interval(EFFECT_CONFIDENCE)
                    if np.all(np.isfinite(ends)):
                        row |= dict(zip(RATIOS, ends, strict=True))
                        row["direction"] = int(ends[1] > 1.0) - int(ends[2] < 1.0)
                    else:
                        row["status"] = NOT_ESTIMABLE
                rows.append(keys | row)
    table = pd.DataFrame(rows, columns=list(demand_table.described("rate_effects")))
    return table.sort_values("scope", kind="stable", ignore_index=True)


def _changes(
    medians: Medians,
    axis: str,
    states: Sequence[LimitState | str],
    rate_of: Callable[[LimitState, int], LogRate | None],  # of a variant, by its number
    systems: Mapping[tuple[str, str], Row],  # keys: variant, degree
) -> list[tuple[Row, list[LogRate]]]:
    """Return table columns and both ln rates of pairs of variants that differ in ``axis``.

    The mean over the pairs comes first. Pairs of systems with different components have no rates.
    """
    other_axes, pairs = variant_pairs(medians.models.variants, axis)
    changes: list[tuple[Row, list[LogRate]]] = []
    for (step, group), state in product(pairs.groupby(list(STEP)), states):
        key = (SYSTEM, state) if isinstance(state, str) else (state.component, state.name)
        keys = medians.models.labels | {"axis": axis, "status": OK, "reason": ""}
        keys |= dict(zip([*STEP, *_STATE[1:]], (*step, *key), strict=True))
        cells, both = records_of(group), list[list[Row]]()
        if isinstance(state, str):
            names = [(cell["variant_from"], cell["variant_to"]) for cell in cells]
            both = [[systems[name, state] for name in pair] for pair in names]
            rates = [[system.get("rate") for system in pair] for pair in both]
        else:
            numbers = [(cell["number_from"], cell["number_to"]) for cell in cells]
            rates = [[rate_of(state, number) for number in pair] for pair in numbers]
        reasons = [difference(*pair) for pair in both] or [""] * len(cells)
        logs = [[rate for rate in pair if isinstance(rate, LogRate)] for pair in rates]
        rated = [i for i, reason in enumerate(reasons) if len(logs[i]) == 2 and not reason]
        if isinstance(state, str):
            shown, used = rated, list(compress(rated, averaged([both[i] for i in rated])))
            has_mean = bool(used)
        else:
            used, shown = rated, [i for i in rated if not medians.withheld([cells[i]], state)]
            has_mean = bool(rated) and not medians.withheld([cells[i] for i in rated], state)
        pooled = keys | {"scope": "pooled", "n_cells": len(used)}
        left_out = {"different": sum(map(bool, reasons)), "other": len(rated) - len(used)}
        if texts := [f"{n} of {len(cells)} pairs have {word}" for word, n in left_out.items() if n]:
            pooled["reason"] = f"{', '.join(texts)} components"
        if has_mean:
            changes.append((pooled, [_mean([logs[i][end] for i in used]) for end in (0, 1)]))
        elif any(reasons):
            changes.append((pooled | {"status": DIFFERENT_COMPONENTS}, []))
        rows = [keys | {"scope": "variant"} | {n: cell[n] for n in other_axes} for cell in cells]
        changes += [(rows[i], logs[i]) for i in shown]
        different = [(i, {"reason": reason}) for i, reason in enumerate(reasons) if reason]
        changes += [(rows[i] | {"status": DIFFERENT_COMPONENTS} | r, []) for i, r in different]
    return changes


def _mean(rates: Sequence[LogRate]) -> LogRate:
    logs = np.mean([completed(rate.logs) for rate in rates], axis=0)
    fractiles = np.mean([rate.fractiles for rate in rates], axis=0)
    return rates[0]._replace(logs=logs, fractiles=fractiles)


GAP: Final = "gap_mm"
#: Support lengths (m) that are compared.
_LENGTHS_M: Final = np.geomspace(0.02, 4.0, 24)
_SKEWS, _GAPS = 13, 5  # points over the range of the study
_COLUMN: Final = ("column_rate", "column_rate_low", "column_rate_high")
#: Annual rate of the displacement demand of SDC: 5 % in 50 years.
SDC_RATE: Final = float(-np.log1p(-0.05) / YEARS)


class Decision(NamedTuple):
    """Seat lengths for a target rate, and rates of column failure, over skew and gap."""

    table: pd.DataFrame  # one row per skew and gap
    target: float  # annual rate
    values: Mapping[str, float]  # values of the other axes
    level: float
    notes: list[str]  # of `lacking_notes`, on unseating at the needed lengths and column failure


def target_rate(probability_50y: float) -> float:
    """Return the target rate (1/year) from a probability in 50 years."""
    if not 0.0 < probability_50y < 1.0:
        raise InputError(f"probability_50y must be above 0 and below 1, got {probability_50y:g}")
    return float(-np.log1p(-probability_50y) / YEARS)


def decision(
    rows: Sequence[Row],  # of table `joint`, of one bridge and abutment model
    hazard: HazardCurve,
    target: float,  # annual rate
    axis_values: Mapping[str, float],  # values of axes except skew and gap; the middle of others
) -> Decision:
    """Return support length and seat needed, and the rate of column failure, over skew and gap.

    An `InputError` states that the study has no unseating model, a single skew or no gap, that a
    value is on an axis of the table, or that the hazard curve ends above the target.
    """
    if fixed := [name for name in (SKEW, GAP) if name in axis_values]:
        raise InputError(f"--axis {fixed[0]}: leave it out, the table has all values of this axis")
    if (last := hazard.rates[0, -1]) >= target:
        text = f"ends at {last:.3g} per year, above the target of {target:.3g}"
        raise InputError(f"the hazard curve {text}: add larger intensities", column="rate")
    row_of = {f"{row['component']}/{row['limit_state']}": row for row in rows}
    unseating = next((row for row in rows if row["component"] == "unseating"), None)
    if unseating is None:
        raise InputError("no state of unseating has a curve: see the status in joint.parquet")
    (mode,) = json.loads(unseating["modes"])
    # ASSUME the length of the seat is known: no dispersion of the capacity
    modes = ([{**mode, "threshold": length, "dispersion": 0.0}] for length in _LENGTHS_M)
    seats = [JointModel({**unseating, "modes": json.dumps(of_seat)}) for of_seat in modes]
    axes, failure = seats[0].axis_range, row_of.get(f"{COLUMN_FAILURE}/any")
    column = None if failure is None else JointModel(failure)
    if SKEW not in axes.varying:
        raise InputError("the study has one skew, but needs two or more: add to grid.skew_deg")
    if GAP not in (limits := axes.limits):
        raise InputError(f"a seat includes the gap, but the study has no column {GAP}: add it")
    values = {name: middle for name, middle in axes.middle.items() if name not in (SKEW, GAP)}
    values |= axis_values
    gaps = np.unique(np.linspace(*limits[GAP], _GAPS))
    skews = np.linspace(*limits[SKEW], _SKEWS)
    axes.check({SKEW: skews[0], GAP: gaps[0], **values})
    # ln of the intensity exceeded with this rate; NaN outside the hazard curve
    ln_rates, ln_levels = np.log(hazard.rates[0]), np.log(hazard.levels)
    ln_sdc_im = np.interp(-np.log(SDC_RATE), -ln_rates, ln_levels, nan, nan)
    rows_out: list[Row] = []
    shares: list[Row] = []
    for gap_mm in map(float, gaps):
        # the factor of Hazus is on skew 0: without it in the study, there is no such length
        has_straight = limits[SKEW][0] <= 0.0
        at_zero = [seat.curve({SKEW: 0.0, GAP: gap_mm, **values}) for seat in seats * has_straight]
        for skew_deg in map(float, skews):
            position = {SKEW: skew_deg, GAP: gap_mm}
            curves = [seat.curve(position | values) for seat in seats]
            interval = _length(curves, hazard, target).interval(unseating["level"])
            row: Row = {f"support_m{end}": v for end, v in zip(_ENDS, interval, strict=True)}
            row |= {name.replace("support", "seat"): v + gap_mm / 1000.0 for name, v in row.items()}
            # the median at which the needed length is exceeded
            medians = np.exp([curve.ln_theta[0] for curve in curves])
            median = float(np.interp(interval[0], _LENGTHS_M, medians))
            im_range = unseating["im_low"], unseating["im_high"]
            row["extrapolated"] = not im_range[0] <= median <= im_range[1]
            if np.isfinite(interval[0]):
                seat_curve = curves[int(np.searchsorted(_LENGTHS_M, interval[0]))]
                state = {"component": "unseating", "limit_state": "at the length"}
                shares.append(state | rate_shares(seat_curve, hazard, *im_range))
            row["hazus_m"] = np.nan
            if at_zero:
                ln_factor = float(np.log(hazus_factor(skew_deg)))
                hazus = _length(at_zero, hazard, target, ln_factor).value
                row["hazus_m"] = hazus + gap_mm / 1000.0
            # SDC: displacement demand at 5 % in 50 years
            ln_length = np.interp(ln_sdc_im, np.log(medians), np.log(_LENGTHS_M))
            row["sdc_demand_m"] = float(np.exp(ln_length))
            if column is not None:
                curve = column.curve(position | values)
                rate = curve_rate(curve, hazard).interval(column.level)
                rate = np.minimum(rate, hazard.highest_rate(column.level))
                row |= dict(zip(_COLUMN, rate, strict=True))
                state = {"component": COLUMN_FAILURE, "limit_state": "any"}
                shares.append(state | rate_shares(curve, hazard, *im_range))
            rows_out.append(position | row)
    table = pd.DataFrame(rows_out)
    if column is not None:
        allowed = table.groupby(SKEW)[[GAP, *_COLUMN]].apply(_allowed_gaps, target)
        table = table.join(allowed, on=SKEW)
    return Decision(table, target, values, float(unseating["level"]), lacking_notes(shares))


def _allowed_gaps(of_skew: pd.DataFrame, target: float) -> pd.Series:
    """Return the smallest and largest gap with a rate of column failure of at most the target.

    ``of_skew`` has the gaps and rates of one skew. The ``certain_gap_..`` use the upper ends of the
    intervals of the rates. NaN: no gap in the range of the study.
    """
    fine_gaps, row = np.linspace(of_skew[GAP].min(), of_skew[GAP].max(), 201), dict[str, float]()
    for name, rate in (("gap", _COLUMN[0]), ("certain_gap", _COLUMN[2])):
        ln_rate = np.interp(fine_gaps, of_skew[GAP], np.log(of_skew[rate]))
        allowed = fine_gaps[ln_rate <= np.log(target)]
        ends = (allowed[0], allowed[-1]) if allowed.size else (np.nan, np.nan)
        row |= dict(zip((f"{name}_from_mm", f"{name}_to_mm"), ends, strict=True))
    return pd.Series(row)


def _length(
    curves: Sequence[StateCurve], hazard: HazardCurve, target: float, ln_factor: float = 0.0
) -> LogRate:
    """Return ln of the displacement (m) of a deck corner that is exceeded with the target rate.

    ``curves`` give the probability to exceed each of `_LENGTHS_M`; NaN outside these lengths.
    """
    rates, ln_lengths = [curve_rate(c, hazard, ln_factor) for c in curves], np.log(_LENGTHS_M)
    logs, fractiles = (
        np.array([np.interp(-np.log(target), -r, ln_lengths, nan, nan) for r in np.transpose(logs)])
        for logs in ([rate.logs for rate in rates], [rate.fractiles for rate in rates])
    )
    return rates[0]._replace(logs=logs, fractiles=fractiles)
