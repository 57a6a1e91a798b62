"""Two columns, time and acceleration, as text or CSV, with or without a header line.

The time step is that of the whole column, so that rounded times do no harm; a hole or a step back
in the column is refused.
"""

import itertools
import re
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.motions.formats.numbers import FLOAT, parse_numbers
from skewbridge.motions.formats.trace import (
    HEADER_WIDTH,
    UNIT_FACTORS,
    Given,
    Trace,
    dt_of,
    unit_of,
)

NAME: Final = "two_column"
HEADER_LINES: Final = 10
_PROBE_LINES: Final = 8
_ROW = re.compile(rf"\s*({FLOAT})(?:\s*[,;]\s*|\s+)({FLOAT})\s*[,;]?\s*")
_UNITS: Final = (
    (re.compile(r"cm\s*/\s*s|\bgals?\b|_cmps2\b|_gal\b", re.IGNORECASE), "cm/s2"),
    (re.compile(r"m\s*/\s*s|_mps2\b", re.IGNORECASE), "m/s2"),
    (re.compile(r"\bg\b|_g\b", re.IGNORECASE), "g"),
)


def recognises(lines: list[str], path: Path) -> bool:
    """Say whether two columns start within the first lines, the first of them rising."""
    start = _first_row(lines)
    if start is None:
        return False
    rows = [
        _ROW.fullmatch(line[:HEADER_WIDTH])
        for line in lines[start : start + _PROBE_LINES]
        if line.strip()
    ]
    if len(rows) < 3 or not all(rows):
        return False
    times = [_number(row[1]) for row in rows if row]
    return all(later > earlier for earlier, later in itertools.pairwise(times))


def read(lines: list[str], path: Path, given: Given) -> Trace:
    """Read two columns.

    Raises:
        InputError: A row without two numbers, a hole in the time column.
    """
    start = _first_row(lines) or 0
    header = " ".join(line[:HEADER_WIDTH] for line in lines[:start])
    rows = [(number, line) for number, line in enumerate(lines[start:], start + 1) if line.strip()]
    values = parse_numbers([line for _, line in rows], path, first_line=start + 1)
    if values.size != 2 * len(rows):
        bad = next(
            (number for number, line in rows if not _ROW.fullmatch(line[:HEADER_WIDTH])),
            rows[-1][0],
        )
        msg = f"{path.name}, line {bad}: time and acceleration expected"
        raise InputError(msg, file=str(path), line=bad)
    time_s, accel = values[0::2], values[1::2]
    step_s, warnings = _time_step(time_s, rows, path)
    dt_s, clashes = dt_of(given, step_s, path)
    unit, notes = unit_of(given, _unit(header))
    return Trace(
        path=path,
        format=NAME,
        accel_mps2=accel * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=tuple(clashes if given.dt_s is not None else warnings),
        notes=tuple(notes),
    )


def _time_step(
    time_s: NDArray[np.float64], rows: list[tuple[int, str]], path: Path
) -> tuple[float, list[str]]:
    """Return the time step of a column of times, and whether they are rounded."""
    steps_s = np.diff(time_s)
    mean_s = float(time_s[-1] - time_s[0]) / max(steps_s.size, 1)
    decimals = max(_decimals(line) for _, line in rows[:100])
    quantum_s = 10.0**-decimals
    off_s = np.abs(steps_s - mean_s)
    # A rounded time is off by half a unit of its last digit, a step by a whole one.
    allowed_s = min(1.01 * quantum_s, 0.9 * mean_s) + 1.0e-3 * mean_s
    if mean_s <= 0.0 or (steps_s <= 0.0).any() or off_s.max(initial=0.0) > allowed_s:
        worst = int(np.argmax(np.where(steps_s <= 0.0, np.inf, off_s)))
        line = rows[worst + 1][0]
        msg = (
            f"{path.name}, line {line}: the time column jumps from {time_s[worst]:g} to "
            f"{time_s[worst + 1]:g} s, steps of {mean_s:g} s expected"
        )
        raise InputError(
            msg,
            file=str(path),
            line=line,
        )
    step_s = _shortest_decimal(mean_s, quantum_s / steps_s.size)
    if off_s.max(initial=0.0) > 1.0e-3 * mean_s:
        return step_s, [f"time column rounded to {decimals} decimals: dt = {step_s:g} s taken"]
    return step_s, []


def _shortest_decimal(value: float, tolerance: float) -> float:
    """Return the number with the fewest digits within a tolerance."""
    for digits in range(1, 16):
        rounded = float(f"{value:.{digits}g}")
        if abs(rounded - value) <= tolerance:
            return rounded
    return value


def _first_row(lines: list[str]) -> int | None:
    for number, line in enumerate(lines[:HEADER_LINES]):
        if _ROW.fullmatch(line[:HEADER_WIDTH]):
            return number
    return None


def _decimals(line: str) -> int:
    match = _ROW.fullmatch(line[:HEADER_WIDTH])
    if match is None:
        return 0
    mantissa, _, exponent = match[1].upper().replace("D", "E").partition("E")
    digits = len(mantissa.partition(".")[2]) - (int(exponent) if exponent else 0)
    return min(max(digits, 0), 15)


def _number(text: str) -> float:
    return float(text.upper().replace("D", "E"))


def _unit(header: str) -> str | None:
    for pattern, unit in _UNITS:
        if pattern.search(header):
            return unit
    return None
