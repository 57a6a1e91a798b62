"""Numbers out of text files written by forty years of Fortran."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.record import Vector

MAX_TOKEN: Final = 400  # longer than any line of any format; keeps the pattern below fast
MAX_MAGNITUDE: Final = 1.0e12  # counts of an instrument stay below 2^31

FLOAT: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"

_PLAIN = re.compile(r"[0-9eEdD+\-.,;\s]*")
_NUMBER = re.compile(FLOAT)
_RUN = re.compile(rf"(?:{FLOAT})(?:[+-](?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?)*")
_DECIMAL_COMMA = re.compile(r"\d,\d")
_SEPARATORS = str.maketrans(",;", "  ")


def fortran_float(text: str) -> float:
    """Return one number, whose exponent may be marked by a D."""
    return float(text.upper().replace("D", "E"))


def parse_numbers(lines: Sequence[str], path: Path, first_line: int = 1) -> Vector:
    """Return every number of some lines, in order.

    Blanks, commas and semicolons separate; Fortran ``D`` exponents and numbers run together at a
    sign (``.12E-01-.76E-02``) are understood.

    Raises:
        InputError: Something that is not a finite number, with file and line.
    """
    text = "\n".join(lines)
    if "." not in text and _DECIMAL_COMMA.search(text):
        raise InputError(f"{path.name}: decimal comma in the values", file=str(path))
    if _PLAIN.fullmatch(text):
        tokens = text.translate(_SEPARATORS).replace("D", "E").replace("d", "e").split()
        try:
            values = np.array(tokens, dtype=np.float64)
        except ValueError:
            pass
        else:
            if (np.abs(values) <= MAX_MAGNITUDE).all():  # also refuses inf
                return values
    found: list[float] = []
    for offset, line in enumerate(lines):
        for token in line.translate(_SEPARATORS).split():
            found.extend(_split(token, path, first_line + offset))
    return np.array(found, dtype=np.float64)


def _split(token: str, path: Path, line: int) -> list[float]:
    """Return the numbers of one blank-free token."""
    if len(token) > MAX_TOKEN or not _RUN.fullmatch(token):
        raise InputError(
            f"{path.name}, line {line}: {token[:40]!r} is not a number", file=str(path), line=line
        )
    values = [fortran_float(number) for number in _NUMBER.findall(token)]
    if max(map(abs, values)) > MAX_MAGNITUDE:
        raise InputError(
            f"{path.name}, line {line}: {token[:40]!r} is too large", file=str(path), line=line
        )
    return values
