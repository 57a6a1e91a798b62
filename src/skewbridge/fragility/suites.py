"""Effects by suite of ground motions, their differences between suites, and medians by suite.

Every suite is analysed alone. The motions of two suites are different events, so the error of a
difference is the root of the sum of the squared errors; its interval is that of Welch (1947),
Biometrika 34, 28-35.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.demands.columns import SUITE
from skewbridge.files.tables import records_of
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.effects import EFFECT_COLUMNS, effect_tables
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.verdicts import OK, RATIOS

#: Name of all suites together.
ALL_SUITES: Final = "all"
DEPENDS: Final = "depends on the motions"
NO_DIFFERENCE: Final = "no difference shown"
#: A difference of more standard errors counts; one in 20 does so by chance.
LARGEST_ERRORS: Final = 2.0
_EFFECT: Final = ("bridge", "abutment", "axis", "from_value", "to_value", "quantity", "demand")
#: Columns of the table of suites.
SUITE_COLUMNS: Final[dict[str, str]] = {
    **{name: EFFECT_COLUMNS[name] for name in _EFFECT},
    SUITE: f"suite of the motions; {ALL_SUITES}: all motions together",
    "against": "suite that this one is compared with; empty for the effect itself",
    "ratio": "pooled ratio of the effect; in a comparison the effect of this suite over the other",
    "ci_low": "lower end of its interval",
    "ci_high": "upper end of its interval",
    "level": "confidence level of the interval",
    "standard_errors": "difference of the ln effects over its standard error; NaN for an effect",
    "verdict": f"{DEPENDS} (more than {LARGEST_ERRORS:g} standard errors) | {NO_DIFFERENCE}; empty "
    "for an effect",
    "n_motions": "motions behind the effect; of a comparison in both suites",
}
#: Columns of the table of medians by suite.
SUITE_CURVE_COLUMNS: Final = (
    *("variant", "bridge", "abutment", "component", "limit_state", SUITE),
    *("method", "theta", "theta_low", "theta_high", "beta", "level", "n_records", "status"),
)


def suite_names(demands: pd.DataFrame) -> list[str]:
    """Return the suites of a demands table, in its order; none where it does not name them."""
    return list(dict.fromkeys(demands[SUITE].astype(str))) if SUITE in demands else []


def suite_tables(
    rows: pd.DataFrame,
    states: Sequence[LimitState],
    demands: Sequence[str],
    settings: FitSettings,
    *,
    together: Sequence[pd.DataFrame],
    jobs: int = 1,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the effects by suite with their differences, and the medians by suite.

    The demands table is checked; without two suites both tables are empty. ``together`` are the
    effects of all suites together, on medians and on demands.
    """
    names, columns = suite_names(rows), list(SUITE_COLUMNS)
    if len(names) < 2:
        return pd.DataFrame(columns=columns), pd.DataFrame(columns=list(SUITE_CURVE_COLUMNS))
    tables: dict[str, Sequence[pd.DataFrame]] = {}
    curves: list[pd.DataFrame] = []
    for name in names:
        part = rows[rows[SUITE] == name].reset_index(drop=True)
        tables[name] = (
            median_effects(part, states, settings, jobs=jobs),
            effect_tables(part, demands, settings, jobs=jobs).effects,
        )
        fitted = fit_study(part, states, settings, jobs=jobs).assign(**{SUITE: name})
        curves.append(fitted[fitted["preferred"].to_numpy(dtype=bool)])
    effects = [
        row | {SUITE: name, "against": ""}
        for name, parts in (*tables.items(), (ALL_SUITES, together))
        for table in parts
        for row in records_of(table[(table["scope"] == "pooled") & (table["status"] == OK)])
    ]
    if not effects:
        return pd.DataFrame(columns=columns), pd.DataFrame(columns=list(SUITE_CURVE_COLUMNS))
    table = pd.DataFrame(effects).assign(verdict="", standard_errors=np.nan)
    compared: list[dict[str, Any]] = []
    for _, part in table.groupby(list(_EFFECT), sort=False):
        records = {row[SUITE]: row for row in records_of(part)}
        pairs = combinations([name for name in names if name in records], 2)
        compared += [_compared(records[one], records[other]) for one, other in pairs]
    joined = pd.concat([table, pd.DataFrame(compared)], ignore_index=True)
    return joined[columns], pd.concat(curves, ignore_index=True)[list(SUITE_CURVE_COLUMNS)]


def _compared(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Return the difference between the effects of two suites, as a ratio of ratios."""
    errors, degrees = zip(*(_error(row) for row in (other, one)), strict=True)
    variances = np.square(errors)
    error = float(np.sqrt(variances.sum()))
    # source: Welch and Satterthwaite
    dof = float(variances.sum() ** 2 / np.sum(variances**2 / np.array(degrees)))
    change = float(np.log(other["ratio"] / one["ratio"]))
    reach = float(special.stdtrit(dof, 0.5 + 0.5 * one["level"])) * error
    ends = np.exp([change, change - reach, change + reach])
    away = abs(change) / error if error > 0.0 else np.inf
    return {
        **{name: one[name] for name in _EFFECT},
        SUITE: other[SUITE],
        "against": one[SUITE],
        **dict(zip(RATIOS, ends.tolist(), strict=True)),
        "level": one["level"],
        "standard_errors": away,
        "verdict": DEPENDS if away > LARGEST_ERRORS else NO_DIFFERENCE,
        "n_motions": int(one["n_motions"]) + int(other["n_motions"]),
    }


def _error(row: dict[str, Any]) -> tuple[float, float]:
    """Return the standard error of ln ratio behind a Student interval, and its degrees."""
    dof = float(row["dof"])
    t = float(special.stdtrit(dof, 0.5 + 0.5 * row["level"]))
    return float(np.log(row["ci_high"] / row["ci_low"]) / (2.0 * t)), dof
