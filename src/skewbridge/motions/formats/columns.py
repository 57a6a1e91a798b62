"""Columns of text or CSV: time and acceleration, with or without a header line.

A table of more columns has a component in each; the channel says which. The time step is that of
the whole time column, so that rounded times do no harm; a hole or a step back in it is refused.
"""

import re
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.formats.numbers import FLOAT, fortran_float, parse_numbers
from skewbridge.motions.formats.trace import (
    HEADER_WIDTH,
    UNIT_FACTORS,
    Given,
    Trace,
    channel_of,
    dt_of,
    unit_of,
)
from skewbridge.motions.record import Vector

NAME: Final = "two_column"
HEADER_LINES: Final = 10
_PROBE_LINES: Final = 8
_ROW = re.compile(rf"\s*(?P<time>{FLOAT})(?:(?:\s*[,;]\s*|\s+){FLOAT})+\s*[,;]?\s*")
_SEPARATOR = re.compile(r"[\s,;]+")
_UNITS: Final = (
    (re.compile(r"cm\s*/\s*s|cm_s_?2\b|\bgals?\b|_cmps2\b|_gal\b", re.IGNORECASE), "cm/s2"),
    (re.compile(r"m\s*/\s*s|m_s_?2\b|_mps2\b", re.IGNORECASE), "m/s2"),
    (re.compile(r"\bg\b|_g\b", re.IGNORECASE), "g"),
)


def recognises(lines: list[str], path: Path) -> bool:
    """Say whether columns start within the first lines, the first of them a time.

    Times of two columns only have to rise, so that a hole is found later; those of more columns
    have to rise evenly, or the bare values of other formats would pass for them.
    """
    start = _first_row(lines)
    if start is None:
        return False
    rows = [line[:HEADER_WIDTH] for line in lines[start : start + _PROBE_LINES] if line.strip()]
    matches = [match for row in rows if (match := _ROW.fullmatch(row))]
    counts = {_count(row) for row in rows}
    if len(rows) < 3 or len(matches) < len(rows) or len(counts) > 1:
        return False
    steps = np.diff([fortran_float(match["time"]) for match in matches])
    uneven = float(steps.max() - steps.min())
    return bool((steps > 0.0).all()) and (counts == {2} or uneven <= 0.02 * float(steps.mean()))


def read(lines: list[str], path: Path, given: Given) -> Trace:
    """Read time and one column of accelerations.

    Raises:
        InputError: A row of another number of columns, a hole in the time column, several columns
            and none chosen.
    """
    start = _first_row(lines) or 0
    header = " ".join(line[:HEADER_WIDTH] for line in lines[:start])
    rows = [(number, line) for number, line in enumerate(lines[start:], start + 1) if line.strip()]
    count = _count(rows[0][1])
    values = parse_numbers([line for _, line in rows], path, first_line=start + 1)
    if values.size != count * len(rows):
        bad = next((number for number, line in rows if _count(line) != count), rows[-1][0])
        raise InputError(
            f"{path.name}, line {bad}: {count} columns expected", file=str(path), line=bad
        )
    table = values.reshape(-1, count)
    channel = channel_of(given, count - 1, path)
    step_s, warnings = _time_step(table[:, 0], rows, path)
    dt_s, clashes = dt_of(given, step_s, path)
    said = next((unit for pattern, unit in _UNITS if pattern.search(header)), None)
    unit, notes = unit_of(given, said)
    return Trace(
        path=path,
        format=NAME if count == 2 else f"{count}_columns",
        accel_mps2=table[:, channel] * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=tuple(clashes if given.dt_s is not None else warnings),
        notes=tuple(notes),
    )


def _count(line: str) -> int:
    return len([cell for cell in _SEPARATOR.split(line[:HEADER_WIDTH]) if cell])


def _time_step(time_s: Vector, rows: list[tuple[int, str]], path: Path) -> tuple[float, list[str]]:
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
        raise InputError(
            f"{path.name}, line {line}: the time column jumps from {time_s[worst]:g} to "
            f"{time_s[worst + 1]:g} s, steps of {mean_s:g} s expected",
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
    rows = (n for n, line in enumerate(lines[:HEADER_LINES]) if _ROW.fullmatch(line[:HEADER_WIDTH]))
    return next(rows, None)


def _decimals(line: str) -> int:
    match = _ROW.fullmatch(line[:HEADER_WIDTH])
    if match is None:
        return 0
    mantissa, _, exponent = match["time"].upper().replace("D", "E").partition("E")
    digits = len(mantissa.partition(".")[2]) - (int(exponent) if exponent else 0)
    return min(max(digits, 0), 15)
