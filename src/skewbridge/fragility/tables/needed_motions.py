"""How many motions a study needs before its headline answers are decided, and what they cost."""

from collections.abc import Iterator
from math import isfinite, nan
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.fragility.tables.key_columns import BRIDGE_COLUMNS, models_of
from skewbridge.fragility.tables.verdicts import DECIDED, DIFFERENCE

#: Chance that so many motions decide, if the effect is as large as it looks now.
POWER: Final = 0.8
#: More than anybody has: the effect lies on the margin.
MOST_MOTIONS: Final = 1000
DECIDED_NOW: Final = "decided"
MORE: Final = "more motions"
ON_MARGIN: Final = "on the margin"
UNKNOWN: Final = "unknown"
NEEDED_COLUMNS: Final[dict[str, str]] = {
    "bridge": "catalogue entry",
    "abutment": "abutment model",
    "demand": "headline demand",
    "axis": "axis whose effect is asked for, pooled over all others",
    "from_value": "value of the axis in the denominator",
    "to_value": "value of the axis in the numerator",
    "verdict": "verdict of now",
    "forecast": f"{DECIDED_NOW} | {MORE} | {ON_MARGIN} (no "
    f"number will do) | {UNKNOWN} (no interval)",
    "n_motions": "motions of now",
    "needed_motions": f"motions with which the interval excludes or holds the margin, with a "
    f"chance of {POWER:g}, if effect and scatter stay as they are",
    "more_analyses": "analyses that are missing, of all variants of the model",
    "more_core_hours": "their cost at the mean of the finished ones",
}


def needed_motions(effects: pd.DataFrame, demands: pd.DataFrame) -> pd.DataFrame:
    """Return for every pooled effect on a headline demand how many motions would decide it.

    The interval narrows with the root of the number of motions; it decides once the distance of the
    effect from the nearer end of the margin is t(level) + t(power) standard errors.

    Args:
        effects: Table of `paired_effects`.
        demands: Demands that it was made from; ``cpu_s`` says what an analysis costs.

    Returns:
        Rows with the columns `NEEDED_COLUMNS`.
    """
    headline = effects["demand"].isin(demands_for("headline")) & (effects["scope"] == "pooled")
    rows = list(_forecasts(effects[headline], demands))
    return pd.DataFrame(rows, columns=list(NEEDED_COLUMNS))


def _forecasts(headline: pd.DataFrame, demands: pd.DataFrame) -> Iterator[dict[str, Any]]:
    for model, own in models_of(demands):
        per_motion = len(own) / own["motion_id"].nunique()
        cpu_s = float(own["cpu_s"].mean()) if "cpu_s" in own else nan
        of_model = (headline[list(BRIDGE_COLUMNS)] == pd.Series(model)).all(axis=1)
        for row in headline[of_model].to_dict("records"):
            told = {str(name): row[name] for name in NEEDED_COLUMNS if name in row}
            needed = motions_to_decide(row)
            decided = row["verdict"] in DECIDED
            more = 0.0 if decided else max(needed - row["n_motions"], 0.0) * per_motion
            yield told | {
                "forecast": _forecast(needed, decided=decided),
                "needed_motions": needed if isfinite(needed) else nan,
                "more_analyses": more if isfinite(more) else nan,
                "more_core_hours": more * cpu_s / 3600 if isfinite(more) else nan,
            }


def motions_to_decide(effect: dict[Any, Any]) -> float:
    """Return with how many motions an effect is decided; infinite if on the margin, NaN if unknown.

    Args:
        effect: A row of `paired_effects`.
    """
    if effect["judged_by"] == DIFFERENCE:
        value, reach = effect["difference"], effect["difference_margin"]
        ends = -reach, reach
    else:
        value = np.log(effect["ratio"])
        ends = np.log1p(-effect["margin"]), np.log1p(effect["margin"])
    distance = min(abs(value - end) for end in ends)
    if not isfinite(distance) or not isfinite(effect["scatter"]):
        return nan
    tail = 0.5 * (1.0 - effect["level"])
    motions = np.arange(3.0, MOST_MOTIONS + 1.0)
    steps = special.stdtrit(motions - 1, 1.0 - tail) + special.stdtrit(motions - 1, POWER)
    enough = steps * effect["scatter"] / np.sqrt(motions) <= distance
    return float(motions[np.argmax(enough)]) if enough.any() else np.inf


def _forecast(needed: float, *, decided: bool) -> str:
    if decided:
        return DECIDED_NOW
    if np.isnan(needed):
        return UNKNOWN
    return MORE if isfinite(needed) else ON_MARGIN
