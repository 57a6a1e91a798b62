"""Statuses of an analysis."""

from typing import Final, Literal, get_args

type Status = Literal["ok", "collapse", "numerical_failure", "timeout", "crash", "invalid_input"]

STATUSES: Final[tuple[Status, ...]] = get_args(Status.__value__)
OK: Final = "ok"
COLLAPSE: Final = "collapse"
#: Statuses with a result; a collapse is a result.
RAN: Final[tuple[Status, ...]] = (OK, COLLAPSE)
#: Statuses without a usable result; the row keeps the peaks up to the failure.
FAILED: Final[tuple[Status, ...]] = tuple(status for status in STATUSES if status not in RAN)
