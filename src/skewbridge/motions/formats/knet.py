"""K-NET and KiK-net of NIED, Japan (`.EW`, `.NS`, `.UD`): counts with a scale factor.

The counts carry the offset of the instrument: the mean is taken off, as NIED asks for.
"""

import re
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.formats.numbers import FLOAT, MAX_MAGNITUDE, fortran_float, parse_numbers
from skewbridge.motions.formats.trace import HEADER_WIDTH, Given, Trace, azimuth_deg, dt_of
from skewbridge.units import GAL

NAME: Final = "knet"
HEADER_LINES: Final = 17
# source: NIED KiK-net manual: 1 to 3 borehole, 4 to 6 surface; N-S, E-W, U-D in turn
_CHANNELS: Final = {"1": "N-S", "2": "E-W", "4": "N-S", "5": "E-W"}
_PEAK_TOLERANCE: Final = 0.01


def recognises(lines: list[str], path: Path) -> bool:
    """Say whether the header has the NIED keys."""
    head = "\n".join(line[:HEADER_WIDTH] for line in lines[:HEADER_LINES])
    return "Scale Factor" in head and "Sampling Freq" in head


def read(lines: list[str], path: Path, given: Given) -> Trace:
    """Read a K-NET or KiK-net file.

    Raises:
        InputError: A broken header or value.
    """
    head = "\n".join(line[:HEADER_WIDTH] for line in lines[:HEADER_LINES])
    scale = _search(rf"Scale Factor\s+({FLOAT})\(gal\)\s*/\s*({FLOAT})", head, path)
    frequency = _search(rf"Sampling Freq\(Hz\)\s+({FLOAT})\s*Hz", head, path)
    frequency_hz, range_gal, counts_per_range = (
        fortran_float(text) for text in (frequency[1], scale[1], scale[2])
    )
    if not (
        0.0 < frequency_hz <= MAX_MAGNITUDE
        and 0.0 < range_gal <= MAX_MAGNITUDE
        and 1.0 <= counts_per_range <= MAX_MAGNITUDE
    ):
        raise InputError(f"{path.name}: sampling and scale must be positive", file=str(path))
    dt_s, warnings = dt_of(given, 1.0 / frequency_hz, path)
    start = next(
        (number + 1 for number, line in enumerate(lines[:HEADER_LINES]) if line[:5] == "Memo."),
        HEADER_LINES,
    )
    counts = parse_numbers(lines[start:], path, first_line=start + 1)
    if counts.size == 0:
        raise InputError(f"{path.name}: no values", file=str(path))
    accel_gal = (counts - counts.mean()) * (range_gal / counts_per_range)
    if peak := re.search(rf"Max\. Acc\. \(gal\)\s+({FLOAT})", head):
        found_gal, said_gal = float(np.abs(accel_gal).max()), fortran_float(peak[1])
        if abs(found_gal - said_gal) > _PEAK_TOLERANCE * said_gal:
            warnings.append(f"peak is {found_gal:.4g} gal, the header says {said_gal:.4g}: cut?")
    direction = _value("Dir.", head)
    return Trace(
        path=path,
        format=NAME,
        accel_mps2=accel_gal * GAL,
        dt_s=dt_s,
        unit="cm/s2",
        event=_value("Origin Time", head),
        station=_value("Station Code", head),
        azimuth_deg=azimuth_deg(_CHANNELS.get(direction, direction)),
        warnings=tuple(warnings),
        notes=("instrument offset (mean) taken off",),
    )


def _search(pattern: str, head: str, path: Path) -> re.Match[str]:
    match = re.search(pattern, head)
    if match is None:
        raise InputError(f"{path.name}: no {pattern.split('\\s')[0]} in the header", file=str(path))
    return match


def _value(key: str, head: str) -> str:
    match = re.search(rf"^{re.escape(key)}\s+(.*)$", head, re.MULTILINE)
    return match[1].strip() if match else ""
