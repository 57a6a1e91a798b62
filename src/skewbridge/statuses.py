"""What can become of an analysis: the one list of statuses."""

from typing import Final, Literal, get_args

type Status = Literal["ok", "collapse", "numerical_failure", "timeout", "crash", "invalid_input"]

STATUSES: Final[tuple[Status, ...]] = get_args(Status.__value__)
OK: Final = "ok"
COLLAPSE: Final = "collapse"
#: The analysis ran to a result; a collapse is one.
RAN: Final[tuple[Status, ...]] = (OK, COLLAPSE)
#: Without a usable result; the row keeps its peaks so far.
FAILED: Final[tuple[Status, ...]] = tuple(status for status in STATUSES if status not in RAN)
