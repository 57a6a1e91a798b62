"""Exceptions of which a command prints only the message, without a traceback."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any, Final

#: Exit codes of commands and scripts.
EXIT_FAILED: Final = 1
EXIT_BAD_INPUT: Final = 2
MOST_FAULTS: Final = 20  # faults listed in one message


class InputError(ValueError):
    """Invalid input, found before any work starts.

    The message names the field (or file and line), the value given and the limit. The command
    line prints only this message and exits with code 2.
    """

    def __init__(self, message: str, **details: Any) -> None:
        super().__init__(message)
        self.details = details  # added to the JSON output of a command


def listed(heading: str, texts: Sequence[str]) -> str:
    """Return a heading, at most `MOST_FAULTS` texts below it, and the number of texts left out."""
    omitted = [f"... and {len(texts) - MOST_FAULTS} more"] if len(texts) > MOST_FAULTS else []
    return "\n  ".join([heading, *texts[:MOST_FAULTS], *omitted])


def raise_all(faults: Iterable[InputError]) -> None:
    """Raise one `InputError` with a line per fault and the details of the first; none if empty."""
    errors = list(faults)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        messages = [text for error in errors for text in error.details.get("faults", [str(error)])]
        text = listed(f"{len(messages)} faults:", messages)
        raise InputError(text, **{**errors[0].details, "faults": messages})


def did_you_mean(word: object, words: Iterable[str]) -> str:
    """Return ` (did you mean NAME?)` with the known name closest to `word`, or an empty text."""
    names_by_lowercase = {str(name).lower(): name for name in words}
    nearest = get_close_matches(str(word).lower(), names_by_lowercase, n=1)
    return f" (did you mean {names_by_lowercase[nearest[0]]}?)" if nearest else ""


class SolutionError(RuntimeError):
    """A numerical solution was not completed.

    The command line prints only the message and exits with code 1.
    """
