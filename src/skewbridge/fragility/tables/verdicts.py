"""What an interval of an effect says against a margin: by itself, and among many.

References:
    Schuirmann (1987), J. Pharmacokin. Biopharm. 15(6):657-680: two one-sided tests.
    Holm (1979), Scand. J. Stat. 6(2):65-70: claims that hold together.
"""

from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.old_likelihood.links import FloatArray

LOWER: Final = "lower"
HIGHER: Final = "higher"
NEGLIGIBLE: Final = "negligible"
DETECTABLE: Final = "detectable"
UNDECIDED: Final = "undecided"
#: All of them with what they mean; the first that holds is given.
VERDICTS: Final = {
    LOWER: "the interval lies below the margin",
    HIGHER: "it lies above the margin",
    NEGLIGIBLE: "it lies inside the margin",
    DETECTABLE: "it excludes no change, but not the margin: only the direction is known",
    UNDECIDED: "none of these",
}
#: Verdicts that say how large an effect is against its margin.
DECIDED: Final = (LOWER, HIGHER, NEGLIGIBLE)
#: Largest share of pairs that have no change to compare on one side alone, for `NEGLIGIBLE`.
MAX_DISCORDANT: Final = 0.05
RATIO: Final = "ratio"
DIFFERENCE: Final = "difference"
#: Columns whose values tell apart the families in which verdicts hold together.
FAMILY: Final = ("bridge", "abutment", "axis", "scope", "quantity")


def judged(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of effects with verdict, direction and the verdict in its family.

    The verdict is that of the printed interval. In the family (one bridge, abutment model, axis,
    scope and quantity) it holds together with all others: for each kind of claim (outside the
    margin, inside it, a direction) the p-values are adjusted after Holm, so that with
    the chance 1 - level, or half of it for a claim on one side, not one of the claims is wrong.
    p-values are those of Student's t with the reach of the interval on the side in question.

    ``table`` has ratio, ci_low, ci_high, margin, level, dof, n_discordant and n_pairs;
    difference, difference_low, difference_high and difference_margin where ``judged_by`` says so.
    """
    scales = _on_scale(table)
    value, low, high = (scales[name] for name in ("value", "low", "high"))
    below, above = scales["margin_low"], scales["margin_high"]
    zero = np.zeros_like(value)
    possible = may_be_negligible(table)
    p_values = _p_values(table, scales)
    tail = 1.0 - table["level"].to_numpy(dtype=np.float64)
    family = [table[name].astype(str) for name in FAMILY]
    held = {
        kind: p.groupby(family, group_keys=False).transform(_holm).to_numpy() <= tail * share
        for kind, (p, share) in p_values.items()
    }
    sign = np.sign(value)
    in_family = np.select(
        [
            held["outside"] & (sign < 0),
            held["outside"] & (sign > 0),
            held["inside"] & possible,
            held["direction"],
        ],
        [LOWER, HIGHER, NEGLIGIBLE, DETECTABLE],
        default=UNDECIDED,
    )
    return table.assign(
        verdict=verdicts_of(low, below, zero, above, high, possible=possible),
        direction=np.select([high < 0.0, low > 0.0], [-1, 1], default=0),
        verdict_family=in_family,
    )


def may_be_negligible(table: pd.DataFrame) -> NDArray[np.bool_]:
    """Return for each effect whether its pairs may show that it is negligible."""
    # ASSUME changes of the other pairs say nothing about those in which one side has none
    return (table["n_discordant"] <= MAX_DISCORDANT * table["n_pairs"]).to_numpy()


def verdicts_of(
    low: FloatArray,
    below: FloatArray,
    zero: FloatArray,
    above: FloatArray,
    high: FloatArray,
    *,
    possible: NDArray[np.bool_],
) -> NDArray[np.str_]:
    """Return the verdicts of intervals low..high against margins below..above around no change.

    ``possible`` tells where an effect may be called negligible.
    """
    return np.select(
        [
            high < below,
            low > above,
            (low >= below) & (high <= above) & possible,
            (low > zero) | (high < zero),
        ],
        [LOWER, HIGHER, NEGLIGIBLE, DETECTABLE],
        default=UNDECIDED,
    )


def _on_scale(table: pd.DataFrame) -> dict[str, FloatArray]:
    """Return estimates, interval ends and margins around zero: ln ratio, or the difference."""
    column = {name: table[name].to_numpy(dtype=np.float64) for name in _NUMBERS}
    plain = (table["judged_by"] == DIFFERENCE).to_numpy()
    with np.errstate(divide="ignore"):
        logs = {
            "value": np.log(column["ratio"]),
            "low": np.log(column["ci_low"]),
            "high": np.log(column["ci_high"]),
            "margin_low": np.log1p(-column["margin"]),
            "margin_high": np.log1p(column["margin"]),
        }
    differences = {
        "value": column["difference"],
        "low": column["difference_low"],
        "high": column["difference_high"],
        "margin_low": -column["difference_margin"],
        "margin_high": column["difference_margin"],
    }
    return {name: np.where(plain, differences[name], logs[name]) for name in logs}


_NUMBERS: Final = (
    *("ratio", "ci_low", "ci_high", "margin"),
    *("difference", "difference_low", "difference_high", "difference_margin"),
)


def _p_values(
    table: pd.DataFrame, scales: dict[str, FloatArray]
) -> dict[str, tuple[pd.Series, float]]:
    """Return p-values by kind of claim, and the share of 1 - level that the claim is tested at."""
    value, low, high = (scales[name] for name in ("value", "low", "high"))
    dof = np.maximum(table["dof"].to_numpy(dtype=np.float64), 1.0)
    reach = special.stdtrit(dof, 0.5 + 0.5 * table["level"].to_numpy(dtype=np.float64))

    def below(limit: Any) -> FloatArray:
        """Return the p-value of the claim that the effect is below a limit."""
        return special.stdtr(dof, _steps(value - limit, (high - value) / reach))

    def above(limit: Any) -> FloatArray:
        return special.stdtr(dof, _steps(limit - value, (value - low) / reach))

    inside = np.maximum(below(scales["margin_high"]), above(scales["margin_low"]))
    outside = np.minimum(below(scales["margin_low"]), above(scales["margin_high"]))
    direction = np.minimum(1.0, 2.0 * np.minimum(below(0.0), above(0.0)))
    known = np.isfinite(low) & np.isfinite(high)
    found = {"outside": (outside, 0.5), "inside": (inside, 0.5), "direction": (direction, 1.0)}
    return {
        kind: (pd.Series(np.where(known, p, np.nan), index=table.index), share)
        for kind, (p, share) in found.items()
    }


def _steps(distance: FloatArray, error: FloatArray) -> FloatArray:
    """Return distances in standard errors; 0 for no distance, even without an error."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(distance == 0.0, 0.0, distance / error)


def _holm(p: pd.Series) -> pd.Series:
    """Return p-values adjusted after Holm; those that are missing do not count."""
    ordered = p.dropna().sort_values()
    steps = np.arange(ordered.size, 0, -1)
    adjusted = np.minimum(1.0, np.maximum.accumulate(ordered.to_numpy() * steps))
    return pd.Series(adjusted, index=ordered.index, dtype=np.float64).reindex(p.index)
