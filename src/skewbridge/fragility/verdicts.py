"""Verdicts of effects against their margins, and the motions needed to decide them.

References:
    Schuirmann (1987), J. Pharmacokin. Biopharm. 15(6):657-680: two one-sided tests.
    Holm (1979), Scand. J. Stat. 6(2):65-70: claims that hold together.
"""

from bisect import bisect_left
from collections.abc import Mapping
from math import ceil, isfinite, nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.fragility.columns import FloatArray
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, models_of
from skewbridge.fragility.limit_states import HEADLINE_STATES

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

#: Probability that the needed motions decide an effect of the size estimated now.
POWER: Final = 0.8
#: Upper limit of the search; an effect that needs more lies on the margin.
MOST_MOTIONS: Final = 1000
DECIDED_NOW: Final = "decided"
MORE: Final = "more motions"
ON_MARGIN: Final = "on the margin"
UNKNOWN: Final = "unknown"
NEEDED_COLUMNS: Final[dict[str, str]] = {
    "bridge": "catalogue entry",
    "abutment": "abutment model",
    "demand": "demand column, or component/limit_state of a median",
    "quantity": f"{DEMAND} | {MEDIAN_CAPACITY}",
    "axis": "axis of the effect, pooled over all others",
    "from_value": "value of the axis in the denominator",
    "to_value": "value of the axis in the numerator",
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
    adjusted after Holm: the probability that any claim is wrong is at most 1 - level, or half of
    that for one-sided claims.
    """
    wide = ~(table["ci_high"] <= MAX_WIDTH * table["ci_low"])
    table = table.assign(**{name: table[name].mask(wide) for name in RATIOS})
    value, low, high, below, above = scale = _on_scale(table)
    possible = may_be_negligible(table)
    headline = table["demand"].isin((*demands_for("headline"), *HEADLINE_STATES))
    keys = (*BRIDGE_COLUMNS, "axis", "scope", "quantity")
    family = [*(table[name].astype(str) for name in keys), headline]
    tail = 1.0 - table["level"].to_numpy(dtype=np.float64)
    holds = {
        claim: p.groupby(family, group_keys=False).transform(_holm).to_numpy() <= tail * share
        for claim, (p, share) in _p_values(table, *scale).items()
    }
    sides = [holds["outside"] & (value < 0.0), holds["outside"] & (value > 0.0)]
    claims = [*sides, holds["inside"] & possible, holds["direction"]]
    zero = np.zeros_like(value)
    return table.assign(
        status=np.where(np.isnan(low), NOT_ESTIMABLE, OK),
        verdict=verdicts_of(low, below, zero, above, high, possible=possible),
        direction=np.select([high < 0.0, low > 0.0], [-1, 1], default=0),
        verdict_family=np.select(claims, _IN_ORDER, default=UNDECIDED),
    )


def may_be_negligible(table: pd.DataFrame) -> NDArray[np.bool_]:
    """Return for each effect whether enough of its pairs have a demand on both sides."""
    # ASSUME the changes of complete pairs do not describe pairs in which one side has no demand
    return (table["n_discordant"] <= MAX_DISCORDANT * table["n_pairs"]).to_numpy(dtype=np.bool_)


def verdicts_of(
    low: FloatArray,
    below: FloatArray,
    zero: FloatArray,
    above: FloatArray,
    high: FloatArray,
    *,
    possible: NDArray[np.bool_],
) -> NDArray[np.str_]:
    """Return the verdicts of intervals against margins; ``possible``: may be negligible."""
    inside = (low >= below) & (high <= above) & possible
    claims = [high < below, low > above, inside, (low > zero) | (high < zero)]
    return np.select(claims, _IN_ORDER, default=UNDECIDED)


def _on_scale(table: pd.DataFrame) -> tuple[FloatArray, ...]:
    """Return estimate, interval ends and margins around zero: ln ratio, or the difference."""
    plain = (table["judged_by"] == DIFFERENCE).to_numpy()
    columns = [table[n].to_numpy(dtype=np.float64) for n in (*RATIOS, *DIFFERENCES)]
    with np.errstate(divide="ignore"):
        value, low, high = np.where(plain, columns[3:], np.log(columns[:3]))
    margin, limit = (table[n].to_numpy(np.float64) for n in ("margin", "difference_margin"))
    below, above = (np.where(plain, sign * limit, np.log1p(sign * margin)) for sign in (-1, 1))
    return value, low, high, below, above


def _p_values(table: pd.DataFrame, *scale: FloatArray) -> dict[str, tuple[pd.Series, float]]:
    """Return p-values of Student's t by kind of claim, and the share of 1 - level for its test."""
    # the error is that of the interval on the side in question; `scale` is as by `_on_scale`
    value, low, high, below, above = scale
    dof = np.maximum(table["dof"].to_numpy(dtype=np.float64), 1.0)
    t = special.stdtrit(dof, 0.5 + 0.5 * table["level"].to_numpy(dtype=np.float64))

    def sides(first: FloatArray | float, second: FloatArray | float) -> list[FloatArray]:
        """Return the p-values of lying below the first limit, and above the second."""
        pairs = (value - first, high - value), (second - value, value - low)
        with np.errstate(divide="ignore", invalid="ignore"):  # 1/2 for no distance and no error
            steps = [np.where(away == 0.0, 0.0, t * away / reach) for away, reach in pairs]
        return [special.stdtr(dof, step) for step in steps]

    claims = {
        "outside": (np.minimum(*sides(below, above)), 0.5),
        "inside": (np.maximum(*sides(above, below)), 0.5),
        "direction": (np.minimum(1.0, 2.0 * np.minimum(*sides(0.0, 0.0))), 1.0),
    }
    known = np.isfinite(low) & np.isfinite(high)
    return {
        claim: (pd.Series(np.where(known, p, nan), index=table.index), share)
        for claim, (p, share) in claims.items()
    }


def _holm(p: pd.Series) -> pd.Series:
    """Return p-values adjusted after Holm; missing ones do not count, equal claims count once."""
    # two states that the same runs reach (shear failure and any failure of a column) are one claim
    distinct = np.unique(p.dropna().to_numpy())
    steps = np.arange(distinct.size, 0, -1)
    adjusted = np.minimum(1.0, np.maximum.accumulate(distinct * steps))
    return p.map(dict(zip(distinct.tolist(), adjusted.tolist(), strict=True))).astype(np.float64)


def needed_motions(effects: pd.DataFrame, demands: pd.DataFrame) -> pd.DataFrame:
    """Return `NEEDED_COLUMNS` of each pooled effect on a headline demand or on a median."""
    asked = effects["demand"].isin(demands_for("headline")) | (
        effects["quantity"] == MEDIAN_CAPACITY
    )
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
            costs = {"needed_motions": needed, "more_analyses": more}
            costs["more_core_hours"] = more * cpu_s / 3600
            row |= {name: cost if isfinite(cost) else nan for name, cost in costs.items()}
            rows.append(row | {"forecast": forecast, "n_motions": suite})
    return pd.DataFrame(rows, columns=list(NEEDED_COLUMNS))


def motions_to_decide(effect: Mapping[Any, Any], power: float = POWER) -> float:
    """Return the number of motions with an exact pair that decide an effect.

    It is the smallest number with which the interval, with this probability, lies inside the
    margin for an effect inside it, or beyond the margin on the side of the effect; infinite for an
    effect on the margin, NaN without an interval.
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
