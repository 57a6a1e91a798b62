"""Suspect analyses: limits on the quality of a solution, and the rows that exceed them.

A suspect row is not wrong, but someone should look at it. The limits change no analysis, so they
are applied where rows are collected and are not part of the key of an analysis.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass as plain_dataclass
from operator import neg, pos
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.files.checking import Number, Whole

if TYPE_CHECKING:
    import pandas as pd

SUSPECT: Final = "suspect"  # column of the demands table with the reasons
SEPARATOR: Final = "; "  # between reasons


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class SuspectLimits:
    """Largest values that are not suspect: section ``suspect`` of the configuration.

    For comparison, eleven variants under 8 s of the suite's motions at 0.8 and 1.2 g need no
    recovery step and make no energy at contacts. Their excess over the cone is at most 0.9 %, and
    the force of one contact at most a tenth of the weight.
    """

    max_loosened_ratio: Number = Field(
        default=0.01, ge=0.0, le=1.0, description="share of steps that met only the looser test"
    )
    max_rung: Whole = Field(default=4, ge=0, description="highest recovery step")
    max_energy_residual: Number = Field(
        default=0.01, gt=0.0, description="energy not accounted for, over the input"
    )
    max_contact_energy: Number = Field(
        default=0.01, gt=0.0, description="energy made at the contacts, over the input"
    )
    max_cone_excess: Number = Field(
        default=0.03, gt=0.0, description="share of the friction work above the limit"
    )
    max_contact_weights: Number = Field(
        default=0.5, gt=0.0, description="normal force of one contact over the weight of the bridge"
    )
    max_houbolt_failures: Whole = Field(
        default=2, ge=0, description="failed attempts under Houbolt"
    )


LIMITS: Final = SuspectLimits()


@plain_dataclass(frozen=True, slots=True)
class _Check:
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
    """Return why a row of the demands table is suspect, joined by `SEPARATOR`; empty if it is not.

    A value that the row lacks (it kept no energy balance) does not make it suspect.
    """
    return SEPARATOR.join(
        f"{check.reason} {check.size(value):{check.form}}"
        for check in _CHECKS
        if (value := row.get(check.column)) is not None
        and check.size(value) > getattr(limits, check.limit)
    )


def count_reasons(table: "pd.DataFrame", limits: SuspectLimits) -> list[dict[str, Any]]:
    """Return each reason that applies: ``reason``, ``rows`` (number), ``worst``, ``at``."""
    counts: list[dict[str, Any]] = []
    for check in _CHECKS:
        if check.column not in table:
            continue
        sizes = check.size(table[check.column].to_numpy(dtype=np.float64))
        rows = int((sizes > getattr(limits, check.limit)).sum())
        if rows:
            at = int(np.nanargmax(sizes))
            worst = f"{sizes[at]:{check.form}}"
            counts.append({"reason": check.reason, "rows": rows, "worst": worst, "at": at})
    return counts
