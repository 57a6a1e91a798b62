"""Verdicts from effects and margins, valid at every look of a study, and needed motions.

A study that stops once its effects are decided tests each effect several times (looks). Every look
uses a part of the error probability of one interval. All intervals of an effect hold jointly at the
level of the study, so the error probability of a verdict is valid whenever the study stops.

Sources: two one-sided tests, Schuirmann (1987), J. Pharmacokin. Biopharm. 15(6):657-680; claims
that hold together, Holm (1979), Scand. J. Stat. 6(2):65-70; spending of the error probability, Lan
and DeMets (1983), Biometrika 70(3):659-663, Kim and DeMets (1987), Biometrika 74(1):149-154; its
integration, Armitage, McPherson and Rowe (1969), J. R. Stat. Soc. A 132(2):235-244; repeated
intervals, Jennison and Turnbull (1989), J. R. Stat. Soc. B 51(3):305-361; Student's t at the levels
of the normal boundary, Pocock (1977), Biometrika 64(2):191-199.
"""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import ceil, isfinite, nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import optimize, special

from skewbridge.demands.columns import demands_for
from skewbridge.files.tables import Floats, Mask
from skewbridge.fragility import motion_means
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, described, models_of
from skewbridge.fragility.limit_states import HEADLINE_STATES

LOWER: Final = "lower"
HIGHER: Final = "higher"
NEGLIGIBLE: Final = "negligible"
DETECTABLE: Final = "detectable"
UNDECIDED: Final = "undecided"
#: Order of precedence; `UNDECIDED` if none applies.
_IN_ORDER: Final = (LOWER, HIGHER, NEGLIGIBLE, DETECTABLE)
#: Verdicts that state whether the effect is inside or outside its margin.
DECIDED: Final = (LOWER, HIGHER, NEGLIGIBLE)
OK: Final = "ok"
NOT_ESTIMABLE: Final = "not_estimable"
NO_CURVE: Final = "no_curve"
#: Largest upper end / lower end of the interval of a reported ratio.
MAX_WIDTH: Final = 10.0
#: Largest share of pairs with a positive demand in one run only, for `NEGLIGIBLE`.
MAX_DISCORDANT: Final = 0.05
RATIO: Final = "ratio"
DIFFERENCE: Final = "difference"
DEMAND: Final = "demand"
MEDIAN_CAPACITY: Final = "median_capacity"
RATIOS: Final = ("ratio", "ci_low", "ci_high")
DIFFERENCES: Final = ("difference", "difference_low", "difference_high")
#: Columns with counts of curves; missing in effects on demands.
MEDIAN_COUNTS: Final = ("n_without_curve", "n_extrapolated")
MORE: Final = "more motions"
# ASSUME a fifth of the error probability covers what the boundary neglects: few motions, tails
# heavier than normal, bounds. source: benchmarks/sequential_verdicts.py; without this reserve, 5.4
# to 6.6 % of the simulated verdicts at the margin were wrong instead of 5 %
SPENT: Final = 0.8
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(120)
#: Paths are integrated down to minus this number of standard deviations.
_FAR: Final = 8.0
#: Columns that identify a pooled effect.
CELL: Final = ("bridge", "abutment", "quantity", "demand", "axis", "from_value", "to_value")

ROUND_COLUMNS: Final = described("rounds")


def with_verdicts(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of effects with status, verdict, direction and family-wise verdict.

    The verdict follows from the interval of the row; a ratio whose interval is wider than a factor
    of 10 is set to NaN. A family contains the rows of one bridge, abutment model, axis, scope and
    quantity. Headline demands and states are in one family, all others in a second family. The
    family-wise verdicts of a family hold jointly: for each kind of claim (outside the margin,
    inside it, direction) the p-values are adjusted by Holm's method. The probability of any wrong
    claim of a kind is at most (1 - level)/2, or 1 - level for the direction.
    """
    is_wide = ~(table["ci_high"] <= MAX_WIDTH * table["ci_low"])
    table = table.assign(**{name: table[name].mask(is_wide) for name in RATIOS})
    is_linear = (table["judged_by"] == DIFFERENCE).to_numpy()
    columns = [table[n].to_numpy(dtype=np.float64) for n in (*RATIOS, *DIFFERENCES)]
    with np.errstate(divide="ignore"):
        value, low, high = np.where(is_linear, columns[3:], np.log(columns[:3]))
    margin, limit = (table[n].to_numpy(np.float64) for n in ("margin", "difference_margin"))
    below, above = (np.where(is_linear, sign * limit, np.log1p(sign * margin)) for sign in (-1, 1))
    possible, zero = may_be_negligible(table), np.zeros_like(value)
    tail = 1.0 - table["level"].to_numpy(dtype=np.float64)
    is_withheld = "status" in table and (table["status"] == NO_CURVE).to_numpy()
    p_values = _p_values(table, value, low, high, below, above)
    outside, inside, direction = (
        adjusted(table, p).to_numpy() <= tail * share
        for p, share in zip(p_values, (0.5, 0.5, 1.0), strict=True)
    )
    claims = [outside & (value < 0.0), outside & (value > 0.0), inside & possible, direction]
    return table.assign(
        status=np.where(np.isnan(low), np.where(is_withheld, NO_CURVE, NOT_ESTIMABLE), OK),
        verdict=verdicts_of(low, below, zero, above, high, possible=possible),
        direction=np.select([high < 0.0, low > 0.0], [-1, 1], default=0),
        verdict_family=np.select(claims, _IN_ORDER, default=UNDECIDED),
    )


def adjusted(table: pd.DataFrame, p: "pd.Series[float]") -> "pd.Series[float]":
    """Return the p-values of effects, adjusted for their families by Holm's method."""
    keys = [table[name].astype(str) for name in (*BRIDGE_COLUMNS, "axis", "scope", "quantity")]
    headline = table["demand"].isin((*demands_for("headline"), *HEADLINE_STATES))
    # a state with the same runs as a headline state (the only failure mode) is the same claim
    headline = headline.groupby([*keys, p], dropna=False).transform("any")
    return p.astype(np.float64).groupby([*keys, headline], group_keys=False).transform(holm)


def may_be_negligible(table: pd.DataFrame) -> Mask:
    """Return False for effects with too many pairs in which only one run has a positive demand."""
    # ASSUME the changes in other pairs do not represent pairs in which one run has no demand
    return (table["n_discordant"] <= MAX_DISCORDANT * table["n_pairs"]).to_numpy(dtype=np.bool_)


def verdicts_of(
    low: Floats, below: Floats, zero: Floats, above: Floats, high: Floats, *, possible: Mask
) -> NDArray[np.str_]:
    """Return verdicts from interval ends and margins; `NEGLIGIBLE` is allowed if ``possible``."""
    is_inside = (low >= below) & (high <= above) & possible
    claims = [high < below, low > above, is_inside, (low > zero) | (high < zero)]
    return np.select(claims, _IN_ORDER, default=UNDECIDED)


def _p_values(table: pd.DataFrame, *scale: Floats) -> list[pd.Series]:
    """Return p-values of t tests of three claims: outside the margin, inside it, direction.

    ``scale``: effect (ln ratio or difference), its interval ends, and both margins, (n,) each.
    """
    # each test uses the half-width of the interval on its side; that of direction is two-sided
    value, low, high, below, above = scale
    dof = np.maximum(table["dof"].to_numpy(dtype=np.float64), 1.0)
    t = special.stdtrit(dof, 0.5 + 0.5 * table["level"].to_numpy(dtype=np.float64))

    def sides(first: Floats | float, second: Floats | float) -> list[Floats]:
        """Return the p-values of the claims "below the first limit" and "above the second"."""
        gaps = (value - first, high - value), (second - value, value - low)
        with np.errstate(divide="ignore", invalid="ignore"):  # p = 1/2 at the limit
            t_values = [np.where(gap == 0.0, 0.0, t * gap / half_width) for gap, half_width in gaps]
        return [special.stdtr(dof, step) for step in t_values]

    outside, inside = np.minimum(*sides(below, above)), np.maximum(*sides(above, below))
    direction = np.minimum(1.0, 2.0 * np.minimum(*sides(0.0, 0.0)))
    finite = np.isfinite(low) & np.isfinite(high)
    return [pd.Series(np.where(finite, p, nan), table.index) for p in (outside, inside, direction)]


def holm(p: pd.Series) -> pd.Series:
    """Return p-values adjusted by Holm's method; NaN is ignored, equal values count once."""
    # two states exceeded in the same runs (shear failure and any failure of a column) are one claim
    distinct = np.unique(p.dropna().to_numpy())
    adjusted = np.minimum(1.0, np.maximum.accumulate(distinct * np.arange(distinct.size, 0, -1)))
    return p.map(dict(zip(distinct.tolist(), adjusted.tolist(), strict=True))).astype(np.float64)


def needed_motions(effects: pd.DataFrame, demands: pd.DataFrame) -> pd.DataFrame:
    """Return the table `needed_motions` for pooled effects on headline demands and on medians."""
    is_headline = effects["demand"].isin(demands_for("headline"))
    is_reported = is_headline | (effects["quantity"] == MEDIAN_CAPACITY)
    headline = effects[is_reported & (effects["scope"] == "pooled")]
    rows: list[dict[Any, Any]] = []
    for model, runs in models_of(demands):
        suite = int(runs["motion_id"].nunique())
        cpu_s = float(runs["cpu_s"].mean()) if "cpu_s" in runs else nan
        is_of_model = (headline[list(BRIDGE_COLUMNS)] == pd.Series(model)).all(axis=1)
        for row in headline[is_of_model].to_dict("records"):
            pairs = motions_to_decide(row)
            # assume that the share of motions without an exact pair stays the same
            n_motions = ceil(pairs * suite / (row["dof"] + 1)) if isfinite(pairs) else pairs
            more_runs = np.ceil(max(n_motions - suite, 0) * len(runs) / suite)
            forecast = MORE if isfinite(n_motions) else "on the margin"
            if row["verdict"] in DECIDED:
                forecast, more_runs, n_motions = "decided", 0.0, nan
            elif np.isnan(n_motions):
                forecast = "unknown"
            costs = {"more_analyses": more_runs, "more_core_hours": more_runs * cpu_s / 3600}
            costs["needed_motions"] = n_motions
            row |= {name: cost if isfinite(cost) else nan for name, cost in costs.items()}
            rows.append(row | {"forecast": forecast, "n_motions": suite})
    return pd.DataFrame(rows, columns=list(described("needed_motions")))


def motions_to_decide(effect: Mapping[Any, Any], power: float = 0.8) -> float:
    """Return the number of motions with an exact pair that decide an effect of the present size.

    With this number, the interval is inside (outside) the margin with probability ``power`` if the
    effect is inside (outside) it. The number is infinite if more than 1000 motions are needed,
    because the effect is on the margin. It is NaN if there is no interval.
    """
    if effect["judged_by"] == DIFFERENCE:
        value, above = effect["difference"], effect["difference_margin"]
        below = -above
    else:
        value = np.log(effect["ratio"])
        below, above = np.log1p(-effect["margin"]), np.log1p(effect["margin"])
    if not isfinite(value) or not isfinite(effect["scatter"]):
        return nan
    candidates = range(3, 1001)
    scatter, tail = max(effect["scatter"], 1e-12), 0.5 * (1.0 - effect["level"])

    def is_enough(motions: int) -> bool:
        steps = np.sqrt(motions) / scatter
        return _power(motions - 1, (below - value) * steps, (above - value) * steps, tail) >= power

    position = bisect_left(candidates, True, key=is_enough)
    return float(candidates[position]) if position < len(candidates) else np.inf


def _power(dof: int, below: float, above: float, tail: float) -> float:
    """Return the probability that the interval is on the same side of the margins as the effect."""
    # `below` and `above` are distances from the effect to the margins in standard errors
    t = special.stdtrit(dof, 1.0 - tail)
    if below > 0.0 or above < 0.0:  # one test: noncentral t, certain above 30 standard errors
        return float(1.0 - special.nctdtr(dof, min(max(below, -above), 30.0), t))
    # two tests at once: the mean is normal; average over quantiles of the sample scatter (chi)
    quantiles = (np.arange(400) + 0.5) / 400
    half_widths = t * np.sqrt(special.chdtri(dof, quantiles) / dof)
    inside = special.ndtr(above - half_widths) - special.ndtr(below + half_widths)
    return float(np.mean(np.maximum(inside, 0.0)))


def levels_at(motions: Floats, looks: Sequence[int], level: float) -> Floats:
    """Return the level of the interval for each number of motions, shape (n,).

    ``looks`` are increasing numbers of motions; ``level`` is the two-sided level of all intervals
    of an effect jointly. A number between two looks has the level of the earlier look. A number
    below the first look has the level of the first look. Both rules only make intervals wider.
    """
    levels = look_levels(tuple(number / looks[-1] for number in looks), level)
    look = np.searchsorted(np.asarray(looks) - 1e-6, motions, side="right") - 1
    return np.asarray(levels)[np.clip(look, 0, len(looks) - 1)]


@lru_cache(maxsize=64)
def look_levels(times: tuple[float, ...], level: float) -> tuple[float, ...]:
    """Return the two-sided level of the interval at each look.

    On either side, the probability that any of the intervals up to time t excludes the true value
    is (1 - level)/2 times t times `SPENT`. ``times`` are shares of the information, increasing to
    1; ``level`` is the joint level of all intervals.
    """
    shares = np.diff(times, prepend=0.0)
    spent, steps = SPENT * 0.5 * (1.0 - level) * shares, np.sqrt(shares)
    # paths of a Brownian motion that have not crossed the boundary: positions and probabilities
    x, mass = np.zeros(1), np.ones(1)
    levels: list[float] = []
    for time, step, alpha in zip(times, steps, spent, strict=True):
        lowest = _FAR * np.sqrt(time)
        boundary = float(optimize.brentq(_crossing_error, 0.0, lowest, args=(x, mass, step, alpha)))
        levels.append(float(1.0 - 2.0 * special.ndtr(-boundary / np.sqrt(time))))
        x_new = 0.5 * (boundary + lowest) * _NODES + 0.5 * (boundary - lowest)
        density = np.exp(-0.5 * ((x_new[:, None] - x) / step) ** 2) / (step * np.sqrt(2.0 * np.pi))
        x, mass = x_new, 0.5 * (boundary + lowest) * _WEIGHTS * (density @ mass)
    return tuple(levels)


def _crossing_error(boundary: float, x: Floats, mass: Floats, step: float, alpha: float) -> float:
    """Return P(a path from positions ``x`` crosses ``boundary`` in one step) - ``alpha``."""
    return float(mass @ special.ndtr((x - boundary) / step)) - alpha


def at_looks(table: pd.DataFrame, looks: Sequence[int], per_motion: float = 1.0) -> pd.DataFrame:
    """Return a table of effects with intervals and verdicts that hold at every look of a study.

    The present look of a row follows from the number of motions that both its variants have. For a
    pooled row, this number is the mean over its pairs of variants, weighted by the share of each
    pair in the variance. Its degrees of freedom are averaged in the same way. The column ``level``
    is the joint two-sided level of all looks on input, and the level of the row's look on return.
    ``looks`` are increasing numbers of motions; ``per_motion`` is that of `runs_per_motion`.
    """
    if table.empty:
        return table
    motions, dof = _information(table, per_motion)
    levels = levels_at(motions, looks, float(table["level"].iloc[0]))
    old_dof, level, scatter = table[["dof", "level", "scatter"]].to_numpy(np.float64).T
    columns: dict[str, Any] = {"level": levels}
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        t_before = special.stdtrit(old_dof, 0.5 + 0.5 * level)
        t = special.stdtrit(np.maximum(dof, 1.0), 0.5 + 0.5 * levels)
        is_ratio = (table["quantity"] == MEDIAN_CAPACITY).to_numpy()
        variance = np.where(is_ratio, scatter**2 / (old_dof + 1.0), nan)
        for names in (RATIOS, DIFFERENCES, ("slope", "slope_low", "slope_high")):
            values = table[list(names)].to_numpy(np.float64).T
            values = np.log(values) if names == RATIOS else values
            ends = _with_quantile(values, t_before, t, variance)
            ends = np.exp(ends) if names == RATIOS else ends
            columns |= dict(zip(names[1:], ends, strict=True))
    return with_verdicts(table.assign(**columns))[list(table.columns)]


def _with_quantile(
    values: Floats, t_before: Floats, t: Floats, variance: Floats
) -> tuple[Floats, Floats]:
    """Return the ends of intervals with another quantile of Student's t.

    ``values`` (3, n) are estimates and both ends with ``t_before``. ``variance`` (n,) is that of a
    ratio of medians, and NaN for estimates with a symmetric interval.
    """
    to_lower, to_upper = np.abs(values[1:] - values[0])
    product = to_lower * to_upper / t_before**2  # the variance, if the interval is symmetric
    # `fieller_ends`, solved for the variance of ln slope and for its covariance with the ratio
    square = np.where(product > 0.0, np.fmin(variance / product, 1.0), 1.0)
    covariance = 0.5 * square * (to_lower - to_upper) / t_before**2
    of_slope = (1.0 - square) / t_before**2
    return motion_means.fieller_ends(values[0], t, square * product, covariance, of_slope)


def _information(table: pd.DataFrame, per_motion: float) -> tuple[Floats, Floats]:
    """Return the number of motions and the degrees of freedom of each row, shape (n,) each."""
    pairs, cell = table[table["scope"] == "variant"], list(CELL)
    motions, dof = pairs["n_pairs"] / per_motion, pairs["dof"].clip(lower=1)
    variance = pairs["scatter"].fillna(0.0) ** 2 / (pairs["dof"] + 1.0).clip(lower=1.0)
    weight = variance + 1e-12 + 1e-6 * variance.max()
    weighted = pairs[cell].assign(weight=weight, motions=weight * motions, dof=weight * dof)
    sums = weighted.groupby(cell, dropna=False).sum()
    weighted_means = sums[["motions", "dof"]].div(sums["weight"], axis=0)
    by_row = table[cell].merge(weighted_means.reset_index(), on=cell, how="left")
    by_row.index = table.index
    by_row.loc[pairs.index, "motions"] = motions
    by_row.loc[pairs.index, "dof"] = pairs["dof"]
    dof = np.minimum(by_row["dof"].to_numpy(np.float64), table["dof"].to_numpy(np.float64))
    return by_row["motions"].to_numpy(np.float64), dof


def kept(table: pd.DataFrame, history: pd.DataFrame) -> pd.DataFrame:
    """Return a table of effects with the intersection of the intervals of all looks so far.

    All intervals of an effect hold jointly, so their intersection holds too, and a verdict once
    reached is kept. If the intersection is empty, the interval of the last look is used. ``table``
    has the effects at the last look, ``history`` (`ROUND_COLUMNS`) the intervals of earlier looks.
    """
    if history.empty:
        return table
    keys, columns = [*CELL, "scope"], {}
    for low, high in (RATIOS[1:], DIFFERENCES[1:]):
        earlier = history.astype({low: np.float64, high: np.float64})
        overlap = earlier.groupby(keys, dropna=False).agg({low: "max", high: "min"}).reset_index()
        merged = table[keys].merge(overlap, on=keys, how="left")
        now = table[[low, high]].to_numpy(np.float64).T
        ends = np.fmax(now[0], merged[low].to_numpy()), np.fmin(now[1], merged[high].to_numpy())
        columns |= dict(zip((low, high), np.where(ends[0] <= ends[1], ends, now), strict=True))
    return with_verdicts(table.assign(**columns))[list(table.columns)]


def runs_per_motion(demands: pd.DataFrame) -> float:
    """Return the number of runs of a variant under one motion: angles of incidence times levels."""
    return len(demands) / len(demands[["variant", "motion_id"]].drop_duplicates())


def rounds_table(plans: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return the table `rounds`: one row per effect and round of motions, from the stored plans."""
    rounds = [({"round": p["round"] - 1, "analyses": p["analyses_before"]}, p) for p in plans]
    cells = [cell | counts for counts, plan in rounds for cell in plan["cells"]]
    return pd.DataFrame(cells, columns=list(ROUND_COLUMNS))
