"""Validity of rows: column failures, peaks of the whole motion, limits of suspect analyses.

After the failure of a column the model of the bridge no longer holds, so the demands of such a run
are peaks up to the failure. They are lower bounds of the peaks over the whole motion, as are those
of a run that collapsed or stopped early.

A suspect row is not wrong, but someone should look at it. The limits change no analysis, so they
are applied where rows are collected and are not part of the key of an analysis.
"""

from collections.abc import Callable, Mapping
from operator import neg, pos
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from skewbridge.files.text import OPTIONS, Number, Whole
from skewbridge.statuses import OK

if TYPE_CHECKING:
    import pandas as pd

#: Column of the demands table with the failure mode of a column; empty where none failed.
BEYOND_MODEL: Final = "beyond_model"
#: Demand over capacity of a column by failure mode; a column fails at 1.
FAILURE_DEMANDS: Final = {"shear": "column_shear_dcr", "flexure": "drift_over_capacity"}
#: Column of the demands table that is true where all demands are peaks of the whole motion.
COMPLETE: Final = "complete"
#: Column of the demands table with the demand over capacity of a column, whatever the mode.
COLUMN_FAILURE_RATIO: Final = "column_failure_ratio"
#: Column of the demands table with the reasons to doubt a row.
SUSPECT: Final = "suspect"


def failure_kinds(table: "pd.DataFrame") -> NDArray[np.str_]:
    """Return the failure mode in each row, shape (n,); empty if none, or without `BEYOND_MODEL`."""
    if BEYOND_MODEL not in table.columns:
        return np.full(len(table), "", dtype=np.str_)
    return table[BEYOND_MODEL].fillna("").to_numpy(dtype=str)


def is_beyond_model(table: "pd.DataFrame") -> NDArray[np.bool_]:
    """Return for each row whether a column failed, shape (n,)."""
    return np.asarray(failure_kinds(table) != "", dtype=np.bool_)


def completed(status: ArrayLike, failure_kind: ArrayLike) -> NDArray[np.bool_]:
    """Return whether demands are peaks of the whole motion: by status, no column failure."""
    return np.asarray((np.asarray(status) == OK) & (np.asarray(failure_kind) == ""), dtype=np.bool_)


def is_complete(table: "pd.DataFrame") -> NDArray[np.bool_]:
    """Return for each row whether its demands are peaks over the whole motion, shape (n,).

    This follows from the status and the failure of columns. A row is also incomplete if its table
    has the column `COMPLETE` and it is false there.
    """
    derived = completed(table["status"].to_numpy(), failure_kinds(table))
    if COMPLETE not in table.columns:
        return derived
    return derived & table[COMPLETE].ne(other=False).to_numpy(dtype=np.bool_, na_value=True)


def column_failure_ratio(table: "pd.DataFrame | Mapping[str, Any]") -> NDArray[np.float64]:
    """Return the larger known demand over capacity of a column in shear or flexure, shape (n,)."""
    names = FAILURE_DEMANDS.values()
    return np.fmax(*(np.asarray(table.get(name, np.nan), float) for name in names))


def with_derived_columns(table: "pd.DataFrame") -> "pd.DataFrame":
    """Return a table with `COMPLETE` and `COLUMN_FAILURE_RATIO`, which older and foreign ones lack.

    The latter is added where a demand over capacity of columns is known.
    """
    derived: dict[str, Any] = {}
    if COMPLETE not in table.columns:
        derived[COMPLETE] = is_complete(table)
    has_ratios = any(name in table for name in FAILURE_DEMANDS.values())
    if COLUMN_FAILURE_RATIO not in table.columns and has_ratios:
        derived[COLUMN_FAILURE_RATIO] = column_failure_ratio(table)
    return table.assign(**derived)


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class SuspectLimits:
    """Largest values that are not suspect: section ``suspect`` of the configuration.

    For comparison, eleven variants under 8 s of the suite's motions at 0.8 and 1.2 g need no
    recovery step and make no energy at contacts. Their excess over the cone is at most 0.9 %, and
    the force of one contact at most a tenth of the weight.
    """

    max_loosened_ratio: Number = Field(default=0.01, ge=0.0, le=1.0)
    """share of steps that met only the looser test"""
    max_rung: Whole = Field(default=4, ge=0)
    """highest recovery step"""
    max_energy_residual: Number = Field(default=0.01, gt=0.0)
    """energy not accounted for, over the input"""
    max_contact_energy: Number = Field(default=0.01, gt=0.0)
    """energy made at the contacts, over the input"""
    max_cone_excess: Number = Field(default=0.03, gt=0.0)
    """share of the friction work above the limit"""
    max_contact_weights: Number = Field(default=0.5, gt=0.0)
    """normal force of one contact over the weight of the bridge"""
    max_houbolt_failures: Whole = Field(default=2, ge=0)
    """failed attempts under Houbolt"""


LIMITS: Final = SuspectLimits()


class _Check(NamedTuple):
    """One limit of `SuspectLimits`, its column of the demands table, and the function compared."""

    reason: str
    column: str
    limit: str
    form: str = ".1%"
    size: Callable[[Any], Any] = pos


_CHECKS: Final = (
    _Check("loosened test, share of the steps", "loosened_ratio", "max_loosened_ratio", ".2%"),
    _Check("recovery rung", "recovery_rung", "max_rung", ".0f"),
    _Check("energy residual", "energy_residual_ratio", "max_energy_residual", size=abs),
    _Check("energy made at contacts", "contact_energy_ratio", "max_contact_energy", size=neg),
    _Check("excess over the cone on backwalls", "cone_excess_wall_ratio", "max_cone_excess"),
    _Check("excess over the cone on keys", "cone_excess_key_ratio", "max_cone_excess"),
    _Check("contact force over weight", "contact_force_ratio", "max_contact_weights", ".2f"),
    _Check("failed attempts under Houbolt", "houbolt_failures", "max_houbolt_failures", ".0f"),
)


def reasons(row: Mapping[str, Any], limits: SuspectLimits) -> str:
    """Return why a row is suspect, joined by "; "; empty if it is not. Values may be missing."""
    return "; ".join(
        f"{check.reason} {check.size(value):{check.form}}"
        for check in _CHECKS
        if (value := row.get(check.column)) is not None
        and check.size(value) > getattr(limits, check.limit)
    )


def count_reasons(table: "pd.DataFrame", limits: SuspectLimits) -> list[dict[str, Any]]:
    """Return each reason that applies: ``reason``, ``rows`` (number), ``worst``, ``at``."""
    counts: list[dict[str, Any]] = []
    for check in (check for check in _CHECKS if check.column in table):
        sizes = check.size(table[check.column].to_numpy(dtype=np.float64))
        rows = int((sizes > getattr(limits, check.limit)).sum())
        if rows:
            at = int(np.nanargmax(sizes))
            worst = f"{sizes[at]:{check.form}}"
            counts.append({"reason": check.reason, "rows": rows, "worst": worst, "at": at})
    return counts
