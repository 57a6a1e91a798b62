"""CSMIP/CESMD corrected data (`.V2`): acceleration blocks of fixed-width columns.

A file may hold several channels, each with its own 45-line header; velocity and displacement
blocks are skipped.
"""

import re
from dataclasses import dataclass
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
    channel_of,
    dt_of,
    unit_of,
)

NAME: Final = "csmip_v2"
_BLOCK = re.compile(
    r"^\s*(?P<npts>\d{1,9})\s+points\s+of\s+accel\w*\s+data\s+equally\s+spaced\s+at\s+"
    rf"(?P<dt>{FLOAT})\s*sec(?P<rest>.*)$",
    re.IGNORECASE,
)
_LAYOUT = re.compile(r"\((?P<per_line>\d{1,2})f(?P<width>\d{1,2})\.\d+\)", re.IGNORECASE)
_UNIT = re.compile(r"cm/sec", re.IGNORECASE)
_CHANNEL = re.compile(r"CHAN\s*\d+:\s*(?P<direction>\w+)", re.IGNORECASE)
_DEFAULT_LAYOUT: Final = (8, 10)  # source: CSMIP report OSMS 85-03, format 8F10.3


@dataclass(frozen=True, slots=True, kw_only=True)
class _Block:
    row: int
    npts: int
    dt_s: float
    unit: str | None
    per_line: int
    width: int


def recognises(lines: list[str], path: Path) -> bool:
    """Say whether the file calls itself a corrected accelerogram, or is named so."""
    head = " ".join(line[:HEADER_WIDTH] for line in lines[:2]).upper()
    return head.lstrip().startswith("CORRECTED ACCELEROGRAM") or (
        path.suffix.lower() == ".v2"
        and any(_BLOCK.match(line[:HEADER_WIDTH]) for line in lines[:200])
    )


def read(lines: list[str], path: Path, given: Given) -> Trace:
    """Read one channel.

    Raises:
        InputError: No acceleration block, several channels and none chosen, broken values.
    """
    blocks = [block for row, line in enumerate(lines) if (block := _block(row, line))]
    if not blocks:
        raise InputError(f"{path.name}: no acceleration block", file=str(path))
    channel = channel_of(given, len(blocks), path)
    block = blocks[channel - 1]
    rows = lines[block.row + 1 : block.row + 1 + -(-block.npts // block.per_line)]
    values = parse_numbers(
        [_columns(line, block.width) for line in rows], path, first_line=block.row + 2
    )
    dt_s, warnings = dt_of(given, block.dt_s, path)
    if values.size < block.npts:
        warnings.append(f"header says {block.npts} points, {values.size} found: truncated file?")
    header = lines[blocks[channel - 2].row if channel > 1 else 0 : block.row]
    unit, notes = unit_of(given, block.unit)
    event, station, azimuth = _title(header)
    return Trace(
        path=path,
        format=NAME,
        accel_mps2=values[: block.npts] * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        event=event,
        station=station,
        azimuth_deg=azimuth,
        warnings=tuple(warnings),
        notes=tuple(notes),
    )


def _block(row: int, line: str) -> _Block | None:
    match = _BLOCK.match(line[:HEADER_WIDTH])
    if match is None:
        return None
    layout = _LAYOUT.search(match["rest"])
    per_line, width = (int(layout["per_line"]), int(layout["width"])) if layout else _DEFAULT_LAYOUT
    return _Block(
        row=row,
        npts=int(match["npts"]),
        dt_s=fortran_float(match["dt"]),
        unit="cm/s2" if _UNIT.search(match["rest"]) else None,
        per_line=max(per_line, 1),
        width=max(width, 1),
    )


def _columns(line: str, width: int) -> str:
    """Return a line with blanks between its fixed-width columns, which may touch."""
    text = line.rstrip()
    return " ".join(text[i : i + width] for i in range(0, len(text), width))


def _title(header: list[str]) -> tuple[str, str, float]:
    """Return event, station and azimuth of a channel header of 25 text lines."""
    start = next(
        (row for row, line in enumerate(header) if "CORRECTED ACCELEROGRAM" in line.upper()), 0
    )
    text = [line[:HEADER_WIDTH].strip() for line in header[start : start + 25]]
    found = (azimuth_deg(match["direction"]) for line in text if (match := _CHANNEL.search(line)))
    event, station = ("".join(text[row : row + 1]) for row in (2, 6))
    return event, station, next(found, float("nan"))
