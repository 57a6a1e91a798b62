"""PEER acceleration files (.AT2): NGA-West2 and the older strong-motion database.

Header lines vary in number, case and blanks; the one with NPTS and DT is searched for, everything
after it is data.
"""

import re
from itertools import takewhile
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.motions.formats.numbers import FLOAT, fortran_float, parse_numbers
from skewbridge.motions.formats.trace import (
    HEADER_WIDTH,
    UNIT_FACTORS,
    Given,
    Trace,
    azimuth_deg,
    dt_of,
    unit_of,
)

NAME: Final = "peer_at2"
HEADER_LINES: Final = 12

_SIZES = (
    re.compile(
        rf"NPTS\s*[=:]\s*(?P<npts>\d{{1,9}})\s*,?\s*DT\s*[=:]\s*(?P<dt>{FLOAT})", re.IGNORECASE
    ),
    re.compile(rf"^\s*(?P<npts>\d{{1,9}})\s+(?P<dt>{FLOAT})\s+NPTS\s*,\s*DT", re.IGNORECASE),
)
_NOT_ACCELERATION = re.compile(r"\b(VELOCITY|DISPLACEMENT)\b.*(UNITS|SERIES|HISTORY)", re.I)
_UNITS = (
    (re.compile(r"UNITS OF G\b|\bin g\b|\(g\)", re.IGNORECASE), "g"),
    (re.compile(r"\bCM/S(EC)?(\*\*2|\^2|2|/S(EC)?)", re.IGNORECASE), "cm/s2"),
    (re.compile(r"\bM/S(EC)?(\*\*2|\^2|2|/S(EC)?)", re.IGNORECASE), "m/s2"),
)
_TITLES = (
    re.compile(
        r"(?P<event>[^,]+),\s*[\d/ ]+,\s*(?P<station>.*),\s*(?P<azimuth>-?\d{1,3}|[A-Z]{1,3})"
    ),
    # the older database: EVENT 5/19/40 0439, STATION, 180 (USGS STATION 117)
    re.compile(
        r"(?P<event>[^,]+?)\s+\d+/\d+/\d+[^,]*,\s*(?P<station>.*),\s*(?P<azimuth>\d{1,3})\b.*"
    ),
)
_FOOTER = re.compile(r"^\s*\*+\s*end\b", re.IGNORECASE)


def recognises(lines: list[str], path: Path) -> bool:
    """Say whether the text looks like a PEER file, whatever its name."""
    return _sizes(lines) is not None or path.suffix.lower() in {".at2", ".vt2", ".dt2"}


def read(lines: list[str], path: Path, given: Given) -> Trace:
    """Read a PEER acceleration file.

    Raises:
        InputError: Not an acceleration file, no NPTS and DT, broken values.
    """
    found = _sizes(lines)
    if found is None:
        if not any(re.search(r"[A-Za-z]{3}", line[:HEADER_WIDTH]) for line in lines[:HEADER_LINES]):
            raise InputError(
                f"{path.name}: no header with NPTS and DT: name it .acc and give dt_s",
                file=str(path),
            )
        raise InputError(f"{path.name}: no NPTS and DT in the header", file=str(path))
    row, npts, dt_header_s = found
    header = [line[:HEADER_WIDTH] for line in lines[:row]]
    for line in header:
        if _NOT_ACCELERATION.search(line):
            raise InputError(f"{path.name}: not an acceleration: {line.strip()!r}", file=str(path))
    unit, notes = unit_of(given, _unit(header))
    dt_s, warnings = dt_of(given, dt_header_s, path)
    data = list(takewhile(lambda line: not _FOOTER.match(line[:HEADER_WIDTH]), lines[row + 1 :]))
    values = parse_numbers(data, path, first_line=row + 2)
    if values.size > npts:
        if values.size - npts >= len(data[0].split()):
            raise InputError(
                f"{path.name}: NPTS = {npts}, but {values.size} values", file=str(path)
            )
        warnings.append(f"NPTS = {npts}, {values.size} values: cut to NPTS")
        values = values[:npts]
    elif values.size < npts:
        _refuse_cut_number(data, path)
        warnings.append(f"NPTS = {npts}, {values.size} values: truncated file?")
    event, station, azimuth = _title(header)
    return Trace(
        path=path,
        format=NAME,
        accel_mps2=values * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=tuple(warnings),
        notes=tuple(notes),
        event=event,
        station=station,
        azimuth_deg=azimuth,
    )


def _sizes(lines: list[str]) -> tuple[int, int, float] | None:
    for row, line in enumerate(lines[:HEADER_LINES]):
        for pattern in _SIZES:
            if match := pattern.search(line[:HEADER_WIDTH]):
                return row, int(match["npts"]), fortran_float(match["dt"])
    return None


def _unit(header: list[str]) -> str | None:
    # The title lines (event, station) may hold anything: units stand in the last lines.
    lines = reversed(header[1:])
    found = (unit for line in lines for pattern, unit in _UNITS if pattern.search(line))
    return next(found, None)


def _refuse_cut_number(data: list[str], path: Path) -> None:
    """Refuse a last value without the exponent all others have: `-.31` of `-.3141593E-02`."""
    tokens = " ".join(data[-3:]).split()
    if len(tokens) > 1 and "E" in tokens[0].upper() and "E" not in tokens[-1].upper():
        raise InputError(f"{path.name}: the file ends inside a number", file=str(path))


def _title(header: list[str]) -> tuple[str, str, float]:
    """Return event, station and azimuth of `EVENT, 1/17/1994, STATION, 90`, where so written."""
    for line in header[:3]:
        for pattern in _TITLES:
            if match := pattern.fullmatch(line.strip()):
                event, station, azimuth = match.group("event", "station", "azimuth")
                return event.strip(), station.strip(), azimuth_deg(azimuth)
    return "", "", float("nan")
