"""What makes the result of an analysis suspect: limits on what its row tells about the solution.

A suspect row is not wrong; someone should look at it. The limits change no analysis, so that they
are applied where the rows are collected, and never stand in the key of an analysis.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass as plain_dataclass
from operator import neg
from typing import Any, Final

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.reading import Number, Whole

SUSPECT: Final = "suspect"  # the column
SEPARATOR: Final = "; "  # of the reasons, each of which ends with its number


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class SuspectLimits:
    """Largest values that are not suspect: section ``suspect`` of the configuration.

    Eleven variants under 8 s of the suite's motions at 0.8 and 1.2 g have no step beyond rung 0,
    make no energy at contacts, at most 0.9 % of excess over the cone and at most a tenth of the
    weight at one contact.
    """

    max_loosened_ratio: Number = Field(
        default=0.01,
        ge=0.0,
        le=1.0,
        description="share of the steps that met only the looser convergence test",
    )
    max_rung: Whole = Field(
        default=4, ge=0, description="highest rung of the recovery ladder on which a step converged"
    )
    max_energy_residual: Number = Field(
        default=0.01, gt=0.0, description="energy not accounted for, over the input"
    )
    max_contact_energy: Number = Field(
        default=0.01, gt=0.0, description="energy made at the contacts, over the input"
    )
    max_cone_excess: Number = Field(
        default=0.03,
        gt=0.0,
        description="share of the friction work on backwalls, or on keys, above the local limit",
    )
    max_contact_weights: Number = Field(
        default=0.5,
        gt=0.0,
        description="normal force of one contact, over the weight of the bridge",
    )
    max_houbolt_failures: Whole = Field(
        default=2,
        ge=0,
        description="failed attempts under Houbolt, each of which restarts it as the trapezoidal "
        "rule and so makes energy at contacts",
    )


LIMITS: Final = SuspectLimits()


@plain_dataclass(frozen=True, slots=True)
class _Reason:
    """One reason: its name, the column and the limit that it comes from, and its number."""

    name: str
    column: str
    limit: str
    form: str = ".1%"
    size: Callable[[float], float] = float


_REASONS: Final = (
    _Reason("loosened test, share of the steps", "loosened_ratio", "max_loosened_ratio", ".2%"),
    _Reason("recovery rung", "recovery_rung", "max_rung", ".0f"),
    _Reason("energy residual", "energy_residual_ratio", "max_energy_residual", size=abs),
    _Reason("energy made at contacts", "contact_energy_ratio", "max_contact_energy", size=neg),
    _Reason("excess over the cone on backwalls", "cone_excess_wall_ratio", "max_cone_excess"),
    _Reason("excess over the cone on keys", "cone_excess_key_ratio", "max_cone_excess"),
    _Reason("contact force over weight", "contact_force_ratio", "max_contact_weights", ".2f"),
    _Reason("failed attempts under Houbolt", "houbolt_failures", "max_houbolt_failures", ".0f"),
)


def reasons(row: Mapping[str, Any], limits: SuspectLimits) -> str:
    """Return why a row of the demands table is suspect, joined by `SEPARATOR`; empty if it is not.

    What a row does not know (it kept no energy balance) makes it not suspect.
    """
    found: list[str] = []
    for reason in _REASONS:
        value = row.get(reason.column)
        if value is not None and reason.size(value) > getattr(limits, reason.limit):
            found.append(f"{reason.name} {reason.size(value):{reason.form}}")
    return SEPARATOR.join(found)


def reasons_in(texts: Iterable[str]) -> list[dict[str, Any]]:
    """Return how often each reason stands in a column of reasons, and where it is worst.

    Args:
        texts: The column, as `reasons` wrote it.

    Returns:
        By reason: ``reason``, ``rows`` (how many), ``worst`` (its number as written) and ``at``
        (its place in the column).
    """
    found: dict[str, list[tuple[float, str, int]]] = {reason.name: [] for reason in _REASONS}
    for at, text in enumerate(texts):
        for part in filter(None, text.split(SEPARATOR)):
            name, number = part.rsplit(" ", 1)
            found[name].append((float(number.removesuffix("%")), number, at))
    return [
        {"reason": name, "rows": len(places), "worst": worst, "at": at}
        for name, places in found.items()
        if places
        for _, worst, at in [max(places)]
    ]
