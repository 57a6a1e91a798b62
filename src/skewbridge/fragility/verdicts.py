"""Tables of effects: columns, verdicts against margins, motions needed to decide them.

References:
    Schuirmann (1987), J. Pharmacokin. Biopharm. 15(6):657-680: two one-sided tests.
    Holm (1979), Scand. J. Stat. 6(2):65-70: claims that hold together.
"""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from math import ceil, isfinite, nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.files.tables import Floats, Mask
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, models_of
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.variant.axes import AXES, Axis

LOWER: Final = "lower"
HIGHER: Final = "higher"
NEGLIGIBLE: Final = "negligible"
DETECTABLE: Final = "detectable"
UNDECIDED: Final = "undecided"
#: All verdicts with their meaning; the first that applies is given.
VERDICTS: Final = {
    LOWER: "the interval lies below the margin",
    HIGHER: "the interval lies above the margin",
    NEGLIGIBLE: "the interval lies inside the margin",
    DETECTABLE: "the interval excludes no change; whether the change exceeds the margin is open",
    UNDECIDED: "none of these",
}
_IN_ORDER: Final = (LOWER, HIGHER, NEGLIGIBLE, DETECTABLE)
#: Verdicts that place an effect against its margin.
DECIDED: Final = (LOWER, HIGHER, NEGLIGIBLE)
OK: Final = "ok"
NOT_ESTIMABLE: Final = "not_estimable"
NO_CURVE: Final = "no_curve"
#: Ratio of the ends of an interval above which a ratio is not an answer.
MAX_WIDTH: Final = 10.0
#: Largest share of pairs with a demand on one side only, for `NEGLIGIBLE`.
MAX_DISCORDANT: Final = 0.05
RATIO: Final = "ratio"
DIFFERENCE: Final = "difference"
DEMAND: Final = "demand"
MEDIAN_CAPACITY: Final = "median_capacity"
RATIOS: Final = ("ratio", "ci_low", "ci_high")
DIFFERENCES: Final = ("difference", "difference_low", "difference_high")


def effect_columns(axes: Sequence[Axis]) -> dict[str, str]:
    """Return names and descriptions of the columns of effects of a study with these axes."""
    return {
        "bridge": "catalogue entry",
        "abutment": "abutment model",
        "demand": "demand column, or component/limit_state of a median",
        "quantity": f"{DEMAND} | {MEDIAN_CAPACITY}",
        "axis": " | ".join(axis.name for axis in axes),
        "from_value": "value of the axis in the denominator",
        "to_value": "value of the axis in the numerator",
        **{
            axis.name: f"{axis.title} of both variants; NaN if pooled or the axis of the effect"
            for axis in axes
        },
        "scope": "pooled (average of all pairs of variants) | variant (one pair of variants)",
        "status": f"{OK} | {NOT_ESTIMABLE} (no interval, or wider than a factor of {MAX_WIDTH:g}) "
        f"| {NO_CURVE} (of medians: no variant has a curve with an estimate)",
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
        "judged_by": f"{RATIO} | {DIFFERENCE}: quantity of the verdict",
        "verdict": "; ".join(f"{name}: {meaning}" for name, meaning in VERDICTS.items()),
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
        "n_exceed_from": "of medians: runs at from_value known to exceed the state",
        "n_exceed_to": "of medians: runs at to_value known to exceed the state",
        "n_unknown_from": "of medians: runs at from_value with an unknown outcome",
        "n_unknown_to": "of medians: runs at to_value with an unknown outcome",
        "n_without_curve": "of the medians (two per pair of variants), those without a curve",
        "n_extrapolated": "of the medians, those that fewer than three motions reach (or undercut)",
        "ratio_all_exceed": "ratio of the medians if all unknown outcomes exceed",
        "ratio_none_exceed": "ratio of the medians if no unknown outcome exceeds",
    }


#: Columns that count runs and curves behind medians; missing in effects on demands.
MEDIAN_COUNTS: Final = (
    *("n_exceed_from", "n_exceed_to", "n_unknown_from", "n_unknown_to"),
    *("n_without_curve", "n_extrapolated"),
)


EFFECT_COLUMNS: Final = effect_columns(AXES)


def described_as_effects(names: str) -> dict[str, str]:
    """Return columns, separated by blanks, with their descriptions in the tables of effects."""
    return {name: EFFECT_COLUMNS[name] for name in names.split()}


#: Probability that the needed motions decide an effect of the size estimated now.
POWER: Final = 0.8
#: Upper limit of the search; an effect that needs more lies on the margin.
MOST_MOTIONS: Final = 1000
DECIDED_NOW: Final = "decided"
MORE: Final = "more motions"
ON_MARGIN: Final = "on the margin"
UNKNOWN: Final = "unknown"
NEEDED_COLUMNS: Final[dict[str, str]] = {
    **described_as_effects("bridge abutment demand quantity"),
    "axis": "axis of the effect, pooled over all others",
    **described_as_effects("from_value to_value"),
    "verdict": "verdict with the motions of the study",
    "forecast": f"{DECIDED_NOW} | {MORE} | {ON_MARGIN} (more than {MOST_MOTIONS} motions) | "
    f"{UNKNOWN} (no interval)",
    "n_motions": "motions of the suite",
    "needed_motions": f"motions that decide with probability {POWER:g}, if effect and scatter stay "
    "the same",
    "more_analyses": "additional analyses over all variants",
    "more_core_hours": "core-hours of these analyses",
}


def judged(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of effects with status, verdict, direction and family-wise verdict.

    The verdict follows from the interval of the row; a ratio whose interval is wider than a factor
    of 10 is set to NaN. A family contains the rows of one bridge, abutment model, axis, scope and
    quantity, either of the headline demands and states or of the others: its family-wise verdicts
    hold jointly. For each kind of claim (outside the margin, inside it, direction) the p-values are
    adjusted after Holm: any claim is wrong with a probability of at most 1 - level, or half of that
    for one-sided claims.
    """
    wide = ~(table["ci_high"] <= MAX_WIDTH * table["ci_low"])
    table = table.assign(**{name: table[name].mask(wide) for name in RATIOS})
    plain = (table["judged_by"] == DIFFERENCE).to_numpy()
    columns = [table[n].to_numpy(dtype=np.float64) for n in (*RATIOS, *DIFFERENCES)]
    with np.errstate(divide="ignore"):
        value, low, high = np.where(plain, columns[3:], np.log(columns[:3]))
    margin, limit = (table[n].to_numpy(np.float64) for n in ("margin", "difference_margin"))
    below, above = (np.where(plain, sign * limit, np.log1p(sign * margin)) for sign in (-1, 1))
    possible, zero = may_be_negligible(table), np.zeros_like(value)
    headline = table["demand"].isin((*demands_for("headline"), *HEADLINE_STATES))
    keys = (*BRIDGE_COLUMNS, "axis", "scope", "quantity")
    family = [*(table[name].astype(str) for name in keys), headline]
    tail = 1.0 - table["level"].to_numpy(dtype=np.float64)
    refused = "status" in table and (table["status"] == NO_CURVE).to_numpy()
    p_values = _p_values(table, value, low, high, below, above)
    outside, inside, direction = (
        p.groupby(family, group_keys=False).transform(_holm).to_numpy() <= tail * share
        for p, share in zip(p_values, (0.5, 0.5, 1.0), strict=True)
    )
    claims = [outside & (value < 0.0), outside & (value > 0.0), inside & possible, direction]
    return table.assign(
        status=np.where(np.isnan(low), np.where(refused, NO_CURVE, NOT_ESTIMABLE), OK),
        verdict=verdicts_of(low, below, zero, above, high, possible=possible),
        direction=np.select([high < 0.0, low > 0.0], [-1, 1], default=0),
        verdict_family=np.select(claims, _IN_ORDER, default=UNDECIDED),
    )


def may_be_negligible(table: pd.DataFrame) -> Mask:
    """Return for each effect whether enough of its pairs have a demand on both sides."""
    # ASSUME the changes of complete pairs do not describe pairs in which one side has no demand
    return (table["n_discordant"] <= MAX_DISCORDANT * table["n_pairs"]).to_numpy(dtype=np.bool_)


def verdicts_of(
    low: Floats, below: Floats, zero: Floats, above: Floats, high: Floats, *, possible: Mask
) -> NDArray[np.str_]:
    """Return the verdicts of intervals against margins; ``possible``: may be negligible."""
    inside = (low >= below) & (high <= above) & possible
    claims = [high < below, low > above, inside, (low > zero) | (high < zero)]
    return np.select(claims, _IN_ORDER, default=UNDECIDED)


def _p_values(table: pd.DataFrame, *scale: Floats) -> list[pd.Series]:
    """Return p-values of Student's t: outside the margin, inside it, direction (two-sided)."""
    # by ln ratio or difference; the error is that of the interval on the side in question
    value, low, high, below, above = scale
    dof = np.maximum(table["dof"].to_numpy(dtype=np.float64), 1.0)
    t = special.stdtrit(dof, 0.5 + 0.5 * table["level"].to_numpy(dtype=np.float64))

    def sides(first: Floats | float, second: Floats | float) -> list[Floats]:
        """Return the p-values of lying below the first limit, and above the second."""
        pairs = (value - first, high - value), (second - value, value - low)
        with np.errstate(divide="ignore", invalid="ignore"):  # 1/2 for no distance and no error
            steps = [np.where(away == 0.0, 0.0, t * away / reach) for away, reach in pairs]
        return [special.stdtr(dof, step) for step in steps]

    outside, inside = np.minimum(*sides(below, above)), np.maximum(*sides(above, below))
    direction = np.minimum(1.0, 2.0 * np.minimum(*sides(0.0, 0.0)))
    known = np.isfinite(low) & np.isfinite(high)
    return [pd.Series(np.where(known, p, nan), table.index) for p in (outside, inside, direction)]


def _holm(p: pd.Series) -> pd.Series:
    """Return p-values adjusted after Holm; missing ones do not count, equal claims count once."""
    # two states that the same runs reach (shear failure and any failure of a column) are one claim
    distinct = np.unique(p.dropna().to_numpy())
    adjusted = np.minimum(1.0, np.maximum.accumulate(distinct * np.arange(distinct.size, 0, -1)))
    return p.map(dict(zip(distinct.tolist(), adjusted.tolist(), strict=True))).astype(np.float64)


def needed_motions(effects: pd.DataFrame, demands: pd.DataFrame) -> pd.DataFrame:
    """Return `NEEDED_COLUMNS` of each pooled effect on a headline demand or on a median."""
    of_demand = effects["demand"].isin(demands_for("headline"))
    asked = of_demand | (effects["quantity"] == MEDIAN_CAPACITY)
    headline = effects[asked & (effects["scope"] == "pooled")]
    rows: list[dict[Any, Any]] = []
    for model, runs in models_of(demands):
        suite = int(runs["motion_id"].nunique())
        cpu_s = float(runs["cpu_s"].mean()) if "cpu_s" in runs else nan
        of_model = (headline[list(BRIDGE_COLUMNS)] == pd.Series(model)).all(axis=1)
        for row in headline[of_model].to_dict("records"):
            exact = motions_to_decide(row)
            # motions without an exact pair stay as frequent as they are now
            needed = ceil(exact * suite / (row["dof"] + 1)) if isfinite(exact) else exact
            more = max(needed - suite, 0) * len(runs) / suite
            forecast = MORE if isfinite(needed) else UNKNOWN if np.isnan(needed) else ON_MARGIN
            if row["verdict"] in DECIDED:
                forecast, more = DECIDED_NOW, 0.0
            costs = {"more_analyses": more, "more_core_hours": more * cpu_s / 3600}
            costs["needed_motions"] = needed
            row |= {name: cost if isfinite(cost) else nan for name, cost in costs.items()}
            rows.append(row | {"forecast": forecast, "n_motions": suite})
    return pd.DataFrame(rows, columns=list(NEEDED_COLUMNS))


def motions_to_decide(effect: Mapping[Any, Any], power: float = POWER) -> float:
    """Return the number of motions with an exact pair that decide an effect.

    With this probability their interval lies inside the margin for an effect inside it, or beyond
    the margin on its side; infinite for an effect on the margin, NaN without an interval.
    """
    if effect["judged_by"] == DIFFERENCE:
        value, above = effect["difference"], effect["difference_margin"]
        below = -above
    else:
        value = np.log(effect["ratio"])
        below, above = np.log1p(-effect["margin"]), np.log1p(effect["margin"])
    if not isfinite(value) or not isfinite(effect["scatter"]):
        return nan
    numbers = range(3, MOST_MOTIONS + 1)
    scatter, tail = max(effect["scatter"], 1e-12), 0.5 * (1.0 - effect["level"])

    def is_enough(motions: int) -> bool:
        steps = np.sqrt(motions) / scatter
        return _power(motions - 1, (below - value) * steps, (above - value) * steps, tail) >= power

    first = bisect_left(numbers, True, key=is_enough)
    return float(numbers[first]) if first < len(numbers) else np.inf


def _power(dof: int, below: float, above: float, tail: float) -> float:
    """Return the probability that an interval lies on the side of the margin of the effect."""
    # `below` and `above` are distances from the effect to the margins in standard errors
    t = special.stdtrit(dof, 1.0 - tail)
    if below > 0.0 or above < 0.0:  # one test: noncentral t; beyond 30 errors it is certain
        return float(1.0 - special.nctdtr(dof, min(max(below, -above), 30.0), t))
    # two tests at once: normal in the mean, chi in the scatter of the sample, by its quantiles
    quantiles = (np.arange(400) + 0.5) / 400
    reach = t * np.sqrt(special.chdtri(dof, quantiles) / dof)
    inside = special.ndtr(above - reach) - special.ndtr(below + reach)
    return float(np.mean(np.maximum(inside, 0.0)))
