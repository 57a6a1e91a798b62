"""Validity of rows of demands: column failures, incomplete runs and suspect analyses.

The model of the bridge is not valid after a column fails, so the demands of such a run are peaks up
to the failure. They are lower bounds of the peaks over the whole motion, as are the demands of a
run that collapsed or stopped early. A suspect row need not be wrong, but should be inspected.
"""

from collections.abc import Callable, Iterable, Mapping
from operator import neg, pos
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.analysis.recovery import loosened_share
from skewbridge.statuses import OK

if TYPE_CHECKING:
    import pandas as pd

#: Column of the demands table with the failure mode of a column; empty where none failed.
BEYOND_MODEL: Final = "beyond_model"
#: Name of the demand/capacity ratio by failure mode of a bridge column; it fails at 1.
FAILURE_DEMANDS: Final = {"shear": "column_shear_dcr", "flexure": "drift_over_capacity"}
#: Column of the demands table that is true if all demands are peaks over the whole motion.
COMPLETE: Final = "complete"
#: Derived column with the larger demand/capacity ratio of both failure modes.
COLUMN_FAILURE_RATIO: Final = "column_failure_ratio"
#: Column of the demands table with the reasons to doubt a row.
SUSPECT: Final = "suspect"


def failure_kinds(table: "pd.DataFrame") -> NDArray[np.str_]:
    """Return the column failure mode of each row, or "" if no column failed, shape (n,)."""
    if BEYOND_MODEL not in table.columns:
        return np.full(len(table), "", dtype=np.str_)
    return table[BEYOND_MODEL].fillna("").to_numpy(dtype=str)


def failed_modes(table: "pd.DataFrame") -> NDArray[np.str_]:
    """Return the column failure mode of each row as `failure_kinds` does, shape (n,).

    In a table without `BEYOND_MODEL`, demands are peaks over the whole motion even if a column
    failed, so the mode is that of the larger demand/capacity ratio if this is at least 1.
    """
    if BEYOND_MODEL in table.columns:
        return failure_kinds(table)
    ratios = [table.get(name, np.zeros(len(table))) for name in FAILURE_DEMANDS.values()]
    ratio_values = np.nan_to_num(np.asarray(ratios, np.float64))
    modes = np.array(list(FAILURE_DEMANDS))[ratio_values.argmax(axis=0)]
    return np.where(ratio_values.max(axis=0) >= 1.0, modes, "")


def is_beyond_model(table: "pd.DataFrame") -> NDArray[np.bool_]:
    """Return for each row whether a column failed, shape (n,)."""
    return np.asarray(failure_kinds(table) != "", dtype=np.bool_)


def completed(status: ArrayLike, failure_kind: ArrayLike) -> NDArray[np.bool_]:
    """Return for each row whether its status is ok and no column failed, shape (n,)."""
    return np.asarray((np.asarray(status) == OK) & (np.asarray(failure_kind) == ""), dtype=np.bool_)


def is_complete(table: "pd.DataFrame") -> NDArray[np.bool_]:
    """Return for each row whether its demands are peaks over the whole motion, shape (n,).

    Status ok, no column failure, and `COMPLETE` (if there is this column) not false.
    """
    derived = completed(table["status"].to_numpy(), failure_kinds(table))
    if COMPLETE not in table.columns:
        return derived
    return derived & table[COMPLETE].ne(other=False).to_numpy(dtype=np.bool_, na_value=True)


def with_derived_columns(table: "pd.DataFrame") -> "pd.DataFrame":
    """Return a table with `COMPLETE` and, if it has `FAILURE_DEMANDS`, `COLUMN_FAILURE_RATIO`."""
    derived: dict[str, Any] = {}
    if COMPLETE not in table.columns:
        derived[COMPLETE] = is_complete(table)
    ratios = [table[name] for name in FAILURE_DEMANDS.values() if name in table]
    if COLUMN_FAILURE_RATIO not in table.columns and ratios:
        derived[COLUMN_FAILURE_RATIO] = np.fmax.reduce(np.asarray(ratios, float))  # ignores NaN
    return table.assign(**derived)


class _Check(NamedTuple):
    """A check of one result of an analysis: a row above the limit is suspect."""

    reason: str
    column: str
    limit: float
    form: str = ".1%"  # format of the size in the reason
    size: Callable[[Any], Any] = pos  # applied to the column before the comparison


MAX_ENERGY_RESIDUAL: Final = 0.01  # of the input energy
# Eleven variants under 8 s of the suite's motions, scaled to 0.8 and 1.2 g, needed no recovery step
# and generated no energy at contacts. At most 0.9 % of their friction work was above the friction
# limit, and the force of one contact was at most a tenth of the weight.
_CHECKS: Final = (
    _Check("share of steps with looser test", "steps_by_rung", 0.01, ".2%", loosened_share),
    _Check("recovery step", "recovery_rung", 4, ".0f"),
    _Check("energy residual", "energy_residual_ratio", MAX_ENERGY_RESIDUAL, size=abs),
    _Check("energy generated at contacts", "contact_energy_ratio", 0.01, size=neg),
    # larger share of the friction work on backwalls and on keys
    _Check("work above friction limit", "cone_excess_ratio", 0.03),
    _Check("contact force / weight", "contact_force_ratio", 0.5, ".2f"),
)
#: Results of an analysis of which the table of demands has only `SUSPECT`.
_ONLY_CHECKED: Final = {"contact_energy_ratio", "contact_force_ratio"}


def with_suspect(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the table of demands: the results of an analysis with `SUSPECT`."""
    shown = {name: value for name, value in row.items() if name not in _ONLY_CHECKED}
    return shown | {SUSPECT: reasons(row)}


def reasons(row: Mapping[str, Any]) -> str:
    """Return the reasons to suspect a row, joined by "; ". Missing values are ignored."""
    return "; ".join(
        f"{check.reason} {check.size(value):{check.form}}"
        for check in _CHECKS
        if (value := row.get(check.column)) is not None and check.size(value) > check.limit
    )


def count_reasons(suspect: Iterable[str]) -> list[dict[str, Any]]:
    """Return for each reason the number of rows, the worst value (text) and its row (``at``).

    ``suspect`` is that column of the table of demands; the most frequent reason is first.
    """
    found: dict[str, list[tuple[float, int, str]]] = {}
    for at, text in enumerate(suspect):
        for reason, _, size in (part.rpartition(" ") for part in text.split("; ") if part):
            found.setdefault(reason, []).append((float(size.rstrip("%")), -at, size))
    counts: list[dict[str, Any]] = []
    for reason, sizes in sorted(found.items(), key=lambda item: -len(item[1])):
        _, at, worst = max(sizes)
        counts.append({"reason": reason, "rows": len(sizes), "worst": worst, "at": -at})
    return counts
