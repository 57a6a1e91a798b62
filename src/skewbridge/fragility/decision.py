"""Seat length and joint gap that a skew needs for a chosen annual rate, from the joint model.

The support length needed at rest is the outward movement of the deck corner that is exceeded with
the chosen rate; the seat is longer by the gap. Rules of codes are in `bridge_check`, the factor of
Hazus in `limit_states`.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Row
from skewbridge.fragility.demand_model import SKEW, StateCurve
from skewbridge.fragility.hazard import HazardCurve, LogRate
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.limit_states import COLUMN_FAILURE, hazus_factor
from skewbridge.fragility.rates import YEARS, curve_rate

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


def target_rate(probability_50y: float) -> float:
    """Return the target rate (1/year) from a probability in 50 years."""
    if not 0.0 < probability_50y < 1.0:
        raise InputError(f"probability_50y must be within 0..1, got {probability_50y:g}")
    return float(-np.log1p(-probability_50y) / YEARS)


def decision(
    rows: Sequence[Row],  # of table `joint`, of one bridge and abutment model
    hazard: HazardCurve,
    target: float,  # annual rate
    axis_values: Mapping[str, float],  # values of axes except skew and gap; the middle of others
) -> Decision:
    """Return support length and seat needed, and the rate of column failure, over skew and gap.

    An `InputError` states that the study has no unseating model or a single skew.
    """
    row_of = {f"{row['component']}/{row['limit_state']}": row for row in rows}
    unseating = next((row for row in rows if row["component"] == "unseating"), None)
    if unseating is None:
        raise InputError("no limit state of the component unseating has a joint model")
    (mode,) = json.loads(unseating["modes"])
    seats = [
        # ASSUME the length of the seat is known: no dispersion of the capacity
        JointModel(
            {**unseating, "modes": json.dumps([{**mode, "threshold": length, "dispersion": 0.0}])}
        )
        for length in _LENGTHS_M
    ]
    axes, failure = seats[0].axis_range, row_of.get(f"{COLUMN_FAILURE}/any")
    column = None if failure is None else JointModel(failure)
    if SKEW not in axes.varying:
        raise InputError("the study has a single skew; two or more are needed")
    values = {name: middle for name, middle in axes.middle.items() if name not in (SKEW, GAP)}
    values |= axis_values
    limits = axes.limits
    gaps = np.unique(np.linspace(*limits.get(GAP, (0.0, 0.0)), _GAPS))
    skews = np.linspace(*limits[SKEW], _SKEWS)
    axes.check({SKEW: skews[0], GAP: gaps[0], **values})
    rows_out: list[Row] = []
    for gap_mm in map(float, gaps):
        # the factor of Hazus is on skew 0: without it in the study, there is no such length
        has_straight = limits[SKEW][0] <= 0.0
        unskewed = [seat.curve({SKEW: 0.0, GAP: gap_mm, **values}) for seat in seats * has_straight]
        for skew_deg in map(float, skews):
            position = {SKEW: skew_deg, GAP: gap_mm}
            curves = [seat.curve(position | values) for seat in seats]
            length = _length(curves, hazard, target)
            interval = length.interval(unseating["level"])
            row: Row = dict(
                zip(("support_m", "support_m_low", "support_m_high"), interval, strict=True)
            )
            row |= {name.replace("support", "seat"): v + gap_mm / 1000.0 for name, v in row.items()}
            # the median at which the needed length is exceeded
            medians = np.exp([curve.ln_theta[0] for curve in curves])
            median = float(np.interp(interval[0], _LENGTHS_M, medians))
            row["extrapolated"] = not unseating["im_low"] <= median <= unseating["im_high"]
            row["hazus_m"] = np.nan
            if unskewed:
                ln_factor = float(np.log(hazus_factor(skew_deg)))
                hazus = _length(unskewed, hazard, target, ln_factor).value
                row["hazus_m"] = hazus + gap_mm / 1000.0
            # SDC: displacement demand at 5 % in 50 years
            at_sdc = np.interp(hazard.level_of(SDC_RATE), np.log(medians), np.log(_LENGTHS_M))
            row["sdc_demand_m"] = float(np.exp(at_sdc))
            if column is not None:
                rate = curve_rate(column.curve(position | values), hazard).interval(column.level)
                row |= dict(zip(_COLUMN, rate, strict=True))
            rows_out.append(position | row)
    table = pd.DataFrame(rows_out)
    if column is not None:
        allowed = table.groupby(SKEW)[[GAP, *_COLUMN]].apply(_allowed_gaps, target)
        table = table.join(allowed, on=SKEW)
    return Decision(table, target, values, float(unseating["level"]))


def _allowed_gaps(of_skew: pd.DataFrame, target: float) -> pd.Series:
    """Return the smallest and largest gap with which column failure is below the target.

    ``certain`` is by the upper end of the interval of the rate. NaN if no gap of the study is.
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
    """Return ln of the length that is exceeded with the target rate; NaN outside `_LENGTHS_M`."""
    rates = [curve_rate(curve, hazard, ln_factor) for curve in curves]
    logs, fractiles = (
        np.array([_crossing(column, np.log(target)) for column in np.transpose(replicates)])
        for replicates in ([rate.logs for rate in rates], [rate.fractiles for rate in rates])
    )
    return LogRate(logs, fractiles, hazard.quantiles)


def _crossing(ln_rates: Floats, ln_target: float) -> float:
    return float(np.interp(-ln_target, -ln_rates, np.log(_LENGTHS_M), np.nan, np.nan))
