"""Intervals and verdicts that remain valid when a study looks at its results after every round.

A study that stops once its effects are decided looks at each of them up to ``most`` motions. Every
look uses a part of the error probability; the parts add up to that of one interval. The ends of
all intervals of an effect hold together with the level of the study (repeated intervals), so its
verdict keeps its error whenever and why the study stops.

References:
    Lan and DeMets (1983), Biometrika 70(3):659-663: spending of the error probability.
    Kim and DeMets (1987), Biometrika 74(1):149-154: spending in proportion to a power of time.
    Armitage, McPherson and Rowe (1969), J. R. Stat. Soc. A 132(2):235-244: the integration.
    Jennison and Turnbull (1989), J. R. Stat. Soc. B 51(3):305-361: repeated intervals.
    Pocock (1977), Biometrika 64(2):191-199: Student's t at the levels of the normal boundary.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import optimize, special

from skewbridge.files.tables import Floats
from skewbridge.fragility.verdicts import DIFFERENCES, NEEDED_COLUMNS, RATIOS, judged

#: Power of time in the spending of the error probability: 1 spends evenly over the motions.
SPENDING_POWER: Final = 1.0
# ASSUME a fifth of the error probability covers what the boundary leaves out: few motions, tails
# heavier than normal, bounds. source: benchmarks/sequential_verdicts.py; without it 5.4 to 6.6 %
# of the simulated verdicts were wrong at the margin, in place of 5 %
SPENT: Final = 0.8
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(120)
#: Standard deviations below which a path is not followed.
_FAR: Final = 8.0
_SLOPES: Final = ("slope", "slope_low", "slope_high")
#: Columns that name a cell: an effect, pooled or of one pair of variants.
CELL: Final = ("bridge", "abutment", "quantity", "demand", "axis", "from_value", "to_value")

ROUND_COLUMNS: Final[dict[str, str]] = {
    "round": "round after which the cell was looked at",
    "analyses": "analyses of the study up to then",
    **{name: NEEDED_COLUMNS[name] for name in CELL},
    "scope": "pooled",
    "ratio": "paired ratio",
    "ci_low": "lower end of its interval, valid at every look",
    "ci_high": "upper end of its interval",
    "difference": "mean difference, of demands judged by it",
    "difference_low": "lower end of its interval",
    "difference_high": "upper end of its interval",
    "verdict": "verdict at this look",
    "n_motions": "motions with a usable pair",
    "needed": "motions that decide it with probability 0.8 if effect and scatter stay the same",
    "asked": "whether the next round was to decide it",
}


def levels_at(motions: Floats, looks: Sequence[int], level: float) -> Floats:
    """Return the level of the interval at the look with each number of motions.

    ``motions`` has shape (n,), ``looks`` rise; ``level`` is the two-sided level of all intervals of
    an effect together. Numbers between two looks have the level of the earlier one, and those below
    the first look its level: counting too little information makes intervals wider.
    """
    levels = look_levels(tuple(number / looks[-1] for number in looks), level)
    look = np.searchsorted(np.asarray(looks) - 1e-6, motions, side="right") - 1
    return np.asarray(levels)[np.clip(look, 0, len(looks) - 1)]


@lru_cache(maxsize=64)
def look_levels(times: tuple[float, ...], level: float) -> tuple[float, ...]:
    """Return the two-sided level of the interval at each look.

    On either side, the probability that any of the intervals up to time t leaves out the true value
    is (1 - level)/2 times t**`SPENDING_POWER` times `SPENT`. ``times`` are shares of the
    information, rising to 1, and ``level`` is that of all intervals together.
    """
    shares = np.diff(np.asarray(times) ** SPENDING_POWER, prepend=0.0)
    spent = SPENT * 0.5 * (1.0 - level) * shares
    steps = np.sqrt(np.diff(times, prepend=0.0))
    # paths of a Brownian motion that have not crossed: places and their probabilities
    at, mass = np.zeros(1), np.ones(1)
    levels: list[float] = []
    for time, step, alpha in zip(times, steps, spent, strict=True):
        far = _FAR * np.sqrt(time)
        end = float(optimize.brentq(_crossing_error, 0.0, far, args=(at, mass, step, alpha)))
        levels.append(float(1.0 - 2.0 * special.ndtr(-end / np.sqrt(time))))
        new = 0.5 * (end + far) * _NODES + 0.5 * (end - far)
        density = np.exp(-0.5 * ((new[:, None] - at) / step) ** 2) / (step * np.sqrt(2.0 * np.pi))
        at, mass = new, 0.5 * (end + far) * _WEIGHTS * (density @ mass)
    return tuple(levels)


def _crossing_error(end: float, at: Floats, mass: Floats, step: float, alpha: float) -> float:
    """Return the probability that a path crosses an end in one step, minus the one wanted."""
    return float(mass @ special.ndtr((at - end) / step)) - alpha


def at_looks(table: pd.DataFrame, looks: Sequence[int], per_motion: float = 1.0) -> pd.DataFrame:
    """Return a table of effects with the intervals and verdicts of its looks.

    Every row is looked at with the motions that both of its variants have. A pooled row whose pairs
    of variants have unequal numbers counts as having their mean, weighted by the share of each pair
    in the variance; so do its degrees of freedom. The column ``level`` is the two-sided level that
    all looks together keep, and on return that of the look of the row. ``looks`` are motions,
    rising; ``per_motion`` those of one variant.
    """
    if table.empty:
        return table
    motions, dof = _information(table, per_motion)
    levels = levels_at(motions, looks, float(table["level"].iloc[0]))
    with np.errstate(invalid="ignore"):
        level = table["level"].to_numpy(np.float64)
        before = special.stdtrit(table["dof"].to_numpy(np.float64), 0.5 + 0.5 * level)
        wider = special.stdtrit(np.maximum(dof, 1.0), 0.5 + 0.5 * levels) / before
    columns: dict[str, Any] = {"level": levels}
    for names in (RATIOS, DIFFERENCES, _SLOPES):
        values = table[list(names)].to_numpy(np.float64).T
        with np.errstate(divide="ignore", over="ignore"):
            values = np.log(values) if names == RATIOS else values
            ends = values[0] + (values[1:] - values[0]) * wider
            ends = np.exp(ends) if names == RATIOS else ends
        columns |= dict(zip(names[1:], ends, strict=True))
    return judged(table.assign(**columns))[list(table.columns)]


def _information(table: pd.DataFrame, per_motion: float) -> tuple[Floats, Floats]:
    """Return the motions and the degrees of freedom that the look of each row counts with."""
    own, cell = table[table["scope"] == "variant"], list(CELL)
    motions, dof = own["n_pairs"] / per_motion, own["dof"].clip(lower=1)
    variance = own["scatter"].fillna(0.0) ** 2 / (own["dof"] + 1.0).clip(lower=1.0)
    weight = variance + 1e-12 + 1e-6 * variance.max()
    parts = own[cell].assign(weight=weight, motions=weight * motions, dof=weight * dof)
    sums = parts.groupby(cell, dropna=False).sum()
    means = sums[["motions", "dof"]].div(sums["weight"], axis=0)
    of_cell = table[cell].merge(means.reset_index(), on=cell, how="left")
    of_cell.index = table.index
    of_cell.loc[own.index, "motions"] = motions
    of_cell.loc[own.index, "dof"] = own["dof"]
    dof = np.minimum(of_cell["dof"].to_numpy(np.float64), table["dof"].to_numpy(np.float64))
    return of_cell["motions"].to_numpy(np.float64), dof


def kept(table: pd.DataFrame, history: pd.DataFrame) -> pd.DataFrame:
    """Return a table of effects with the narrowest interval of all looks so far.

    All intervals of a cell hold together, so their common part does too, and a verdict once reached
    is not lost. Where they have no common part, the last one stays. ``table`` are the effects at
    the last look, ``history`` has keys and interval ends of the earlier ones (`ROUND_COLUMNS`).
    """
    if history.empty:
        return table
    keys, columns = [*CELL, "scope"], {}
    for low, high in (RATIOS[1:], DIFFERENCES[1:]):
        numbers = history.astype({low: np.float64, high: np.float64})
        common = numbers.groupby(keys, dropna=False).agg({low: "max", high: "min"}).reset_index()
        other = table[keys].merge(common, on=keys, how="left")
        last = table[[low, high]].to_numpy(np.float64).T
        ends = np.fmax(last[0], other[low].to_numpy()), np.fmin(last[1], other[high].to_numpy())
        columns |= dict(zip((low, high), np.where(ends[0] <= ends[1], ends, last), strict=True))
    return judged(table.assign(**columns))[list(table.columns)]


def runs_per_motion(demands: pd.DataFrame) -> float:
    """Return the runs of a variant under one motion: angles of incidence times levels."""
    return len(demands) / len(demands[["variant", "motion_id"]].drop_duplicates())


def rounds_table(plans: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return the cells of the plans of all rounds, with the columns `ROUND_COLUMNS`."""
    cells = [
        {**cell, "round": plan["round"] - 1, "analyses": plan["analyses_before"]}
        for plan in plans
        for cell in plan["cells"]
    ]
    return pd.DataFrame(cells, columns=list(ROUND_COLUMNS))
