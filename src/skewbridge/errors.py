"""The exceptions of the package that a command shows to the user as one sentence."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any, Final

MOST_FAULTS: Final = 20  # lines of one message


class InputError(ValueError):
    """Bad input, found before any work started.

    The message names the field (or file and line), the value given and the limit. The command
    line prints it alone and exits with 2.

    Attributes:
        details: Machine-readable particulars, added to the JSON answer of a command.
    """

    def __init__(self, message: str, **details: Any) -> None:
        super().__init__(message)
        self.details = details


def raise_all(faults: Iterable[InputError]) -> None:
    """Raise what is wrong, if anything is: several faults as one, with a line for each.

    Raises:
        InputError: There is a fault; it has the details of the first.
    """
    found = list(faults)
    if len(found) == 1:
        raise found[0]
    if found:
        told = [text for fault in found for text in fault.details.get("faults", [str(fault)])]
        more = [f"... and {len(told) - MOST_FAULTS} more"] if len(told) > MOST_FAULTS else []
        lines = [f"{len(told)} faults:", *told[:MOST_FAULTS], *more]
        raise InputError("\n  ".join(lines), **{**found[0].details, "faults": told})


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """Return ` (did you mean NAME?)` for the known name nearest to a mistyped one, or nothing."""
    near = get_close_matches(str(given), list(known), n=1)
    return f" (did you mean {near[0]}?)" if near else ""


class SolutionError(RuntimeError):
    """A solution could not go on to its end.

    The command line prints the message alone and exits with 1.
    """
