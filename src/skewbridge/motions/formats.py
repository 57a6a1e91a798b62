"""File formats of recorded motions: PEER, CSMIP/CESMD, K-NET/KiK-net, columns, bare values.

Each format has a function that recognises its text and one that reads it. A new format is a pair
of such functions and a row of `FORMATS`.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.trace import (
    FLOAT,
    HEADER_WIDTH,
    MAX_MAGNITUDE,
    UNIT_FACTORS,
    Given,
    Trace,
    azimuth_deg,
    channel_of,
    dt_of,
    fortran_float,
    parse_numbers,
    unit_of,
)
from skewbridge.units import G_MPS2, GAL


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A file format.

    Attributes:
        recognises: Whether some lines of a file at a path are of this format.
        read: Reader of the lines.
    """

    recognises: Callable[[list[str], Path], bool]
    read: Callable[[list[str], Path, Given], Trace]


# ---- PEER acceleration files (.AT2): NGA-West2 and the older strong-motion database. Header lines
# vary in number, case and blanks: the line with NPTS and DT is searched for, the values follow it.

_PEER_HEADER_LINES: Final = 12
_PEER_SIZES = (
    re.compile(
        rf"NPTS\s*[=:]\s*(?P<npts>\d{{1,9}})\s*,?\s*DT\s*[=:]\s*(?P<dt>{FLOAT})", re.IGNORECASE
    ),
    re.compile(rf"^\s*(?P<npts>\d{{1,9}})\s+(?P<dt>{FLOAT})\s+NPTS\s*,\s*DT", re.IGNORECASE),
)
_NOT_ACCELERATION = re.compile(r"\b(VELOCITY|DISPLACEMENT)\b.*(UNITS|SERIES|HISTORY)", re.I)
_PEER_UNITS = (
    (re.compile(r"UNITS OF G\b|\bin g\b|\(g\)", re.IGNORECASE), "g"),
    (re.compile(r"\bCM/S(EC)?(\*\*2|\^2|2|/S(EC)?)", re.IGNORECASE), "cm/s2"),
    (re.compile(r"\bM/S(EC)?(\*\*2|\^2|2|/S(EC)?)", re.IGNORECASE), "m/s2"),
)
_PEER_TITLES = (
    re.compile(
        r"(?P<event>[^,]+),\s*[\d/ ]+,\s*(?P<station>.*),\s*(?P<azimuth>-?\d{1,3}|[A-Z]{1,3})"
    ),
    # the older database: EVENT 5/19/40 0439, STATION, 180 (USGS STATION 117)
    re.compile(
        r"(?P<event>[^,]+?)\s+\d+/\d+/\d+[^,]*,\s*(?P<station>.*),\s*(?P<azimuth>\d{1,3})\b.*"
    ),
)
_PEER_FOOTER = re.compile(r"^\s*\*+\s*end\b", re.IGNORECASE)
_AT2_VALUES_PER_LINE: Final = 5


def _is_peer(lines: list[str], path: Path) -> bool:
    return _peer_sizes(lines) is not None or path.suffix.lower() in {".at2", ".vt2", ".dt2"}


def _read_peer(lines: list[str], path: Path, given: Given) -> Trace:
    sizes = _peer_sizes(lines)
    if sizes is None:
        if not any(
            re.search(r"[A-Za-z]{3}", line[:HEADER_WIDTH]) for line in lines[:_PEER_HEADER_LINES]
        ):
            raise InputError(
                f"{path.name}: no header with NPTS and DT: name it .acc and give dt_s",
                file=str(path),
            )
        raise InputError(f"{path.name}: no NPTS and DT in the header", file=str(path))
    row, npts, dt_header_s = sizes
    header = [line[:HEADER_WIDTH] for line in lines[:row]]
    for line in header:
        if _NOT_ACCELERATION.search(line):
            raise InputError(f"{path.name}: not an acceleration: {line.strip()!r}", file=str(path))
    # The title lines (event, station) may contain anything: units are in the last lines.
    units = (
        unit
        for line in reversed(header[1:])
        for pattern, unit in _PEER_UNITS
        if pattern.search(line)
    )
    unit, notes = unit_of(given, next(units, None))
    dt_s, warnings = dt_of(given, dt_header_s, path)
    data = list(
        takewhile(lambda line: not _PEER_FOOTER.match(line[:HEADER_WIDTH]), lines[row + 1 :])
    )
    values = parse_numbers(data, path, first_line=row + 2)
    if values.size > npts:
        if values.size - npts >= len(data[0].split()):
            raise InputError(
                f"{path.name}: NPTS = {npts}, but {values.size} values", file=str(path)
            )
        warnings.append(f"NPTS = {npts}, {values.size} values: cut to NPTS")
        values = values[:npts]
    elif values.size < npts:
        # A last value without the exponent of all others is cut: `-.31` of `-.3141593E-02`.
        last = " ".join(data[-3:]).upper().split()
        if len(last) > 1 and "E" in last[0] and "E" not in last[-1]:
            raise InputError(f"{path.name}: the file ends inside a number", file=str(path))
        warnings.append(f"NPTS = {npts}, {values.size} values: truncated file?")
    event, station, azimuth = _peer_title(header)
    return Trace(
        path=path,
        format="peer_at2",
        accel_mps2=values * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=tuple(warnings),
        notes=tuple(notes),
        event=event,
        station=station,
        azimuth_deg=azimuth,
    )


def _peer_sizes(lines: list[str]) -> tuple[int, int, float] | None:
    """Return row, NPTS and DT of the header line with the sizes."""
    for row, line in enumerate(lines[:_PEER_HEADER_LINES]):
        for pattern in _PEER_SIZES:
            if match := pattern.search(line[:HEADER_WIDTH]):
                return row, int(match["npts"]), fortran_float(match["dt"])
    return None


def _peer_title(header: list[str]) -> tuple[str, str, float]:
    """Return event, station and azimuth of `EVENT, 1/17/1994, STATION, 90`, where so written."""
    for line in header[:3]:
        for pattern in _PEER_TITLES:
            if match := pattern.fullmatch(line.strip()):
                event, station, azimuth = match.group("event", "station", "azimuth")
                return event.strip(), station.strip(), azimuth_deg(azimuth)
    return "", "", float("nan")


def at2_text(motion: GroundMotion, component: int) -> str:
    """Return one component (1 or 2) as the text of a PEER file, in g with 8 digits."""
    azimuth = (motion.azimuth_1_deg, motion.azimuth_2_deg)[component - 1]
    if not np.isfinite(azimuth):
        azimuth = (360.0, 90.0)[component - 1]
    accel_g = motion.components[component - 1] / G_MPS2
    # Smaller numbers would need a three-digit exponent.
    values = np.where(np.abs(accel_g) < 1.0e-20, 0.0, accel_g)
    cells = [f"{value:15.7E}" for value in values.tolist()]
    per_line = _AT2_VALUES_PER_LINE
    rows = ["".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line)]
    return "\n".join(
        [
            "SYNTHETIC MOTION IN THE FORMAT OF THE PEER NGA STRONG MOTION DATABASE",
            f"{motion.event.replace(',', ';')}, 1/1/2000, {motion.station}, {azimuth:.0f}",
            "ACCELERATION TIME SERIES IN UNITS OF G",
            f"NPTS= {motion.npts:6d}, DT= {motion.dt_s:.6g} SEC",
            *rows,
            "",
        ]
    )


def write_at2(motion: GroundMotion, folder: Path) -> tuple[Path, Path]:
    """Write both components as `<motion_id>_h1.AT2` and `_h2.AT2`; return their paths."""
    paths = tuple(folder / f"{motion.motion_id}_h{component}.AT2" for component in (1, 2))
    writable_folder(folder)
    for component, path in enumerate(paths, start=1):
        path.write_text(at2_text(motion, component), encoding="ascii", newline="\n")
    return paths[0], paths[1]


# ---- CSMIP/CESMD corrected data (.V2): acceleration blocks of fixed-width columns. A file may hold
# several channels, each with its own 45-line header; velocities and displacements are skipped.

_CSMIP_BLOCK = re.compile(
    r"^\s*(?P<npts>\d{1,9})\s+points\s+of\s+accel\w*\s+data\s+equally\s+spaced\s+at\s+"
    rf"(?P<dt>{FLOAT})\s*sec(?P<rest>.*)$",
    re.IGNORECASE,
)
_CSMIP_LAYOUT = re.compile(r"\((?P<per_line>\d{1,2})f(?P<width>\d{1,2})\.\d+\)", re.IGNORECASE)
_CSMIP_CHANNEL = re.compile(r"CHAN\s*\d+:\s*(?P<direction>\w+)", re.IGNORECASE)
_CSMIP_DEFAULT_LAYOUT: Final = (8, 10)  # source: CSMIP report OSMS 85-03, format 8F10.3


def _is_csmip(lines: list[str], path: Path) -> bool:
    """Return whether the file calls itself a corrected accelerogram, or is named so."""
    head = " ".join(line[:HEADER_WIDTH] for line in lines[:2]).upper()
    return head.lstrip().startswith("CORRECTED ACCELEROGRAM") or (
        path.suffix.lower() == ".v2"
        and any(_CSMIP_BLOCK.match(line[:HEADER_WIDTH]) for line in lines[:200])
    )


def _read_csmip(lines: list[str], path: Path, given: Given) -> Trace:
    blocks = [
        (row, match)
        for row, line in enumerate(lines)
        if (match := _CSMIP_BLOCK.match(line[:HEADER_WIDTH]))
    ]
    if not blocks:
        raise InputError(f"{path.name}: no acceleration block", file=str(path))
    channel = channel_of(given, len(blocks), path)
    start, block = blocks[channel - 1]
    npts = int(block["npts"])
    layout = _CSMIP_LAYOUT.search(block["rest"])
    sizes = (int(layout["per_line"]), int(layout["width"])) if layout else _CSMIP_DEFAULT_LAYOUT
    per_line, width = (max(size, 1) for size in sizes)
    rows = (line.rstrip() for line in lines[start + 1 : start + 1 + -(-npts // per_line)])
    # The columns may touch: blanks are put between them.
    spaced = [" ".join(row[i : i + width] for i in range(0, len(row), width)) for row in rows]
    values = parse_numbers(spaced, path, first_line=start + 2)
    dt_s, warnings = dt_of(given, fortran_float(block["dt"]), path)
    if values.size < npts:
        warnings.append(f"header says {npts} points, {values.size} found: truncated file?")
    in_file = "cm/s2" if re.search("cm/sec", block["rest"], re.IGNORECASE) else None
    unit, notes = unit_of(given, in_file)
    header = lines[blocks[channel - 2][0] if channel > 1 else 0 : start]
    title = next(
        (n for n, line in enumerate(header) if "CORRECTED ACCELEROGRAM" in line.upper()), 0
    )
    text = [line[:HEADER_WIDTH].strip() for line in header[title : title + 25]]
    directions = (match["direction"] for line in text if (match := _CSMIP_CHANNEL.search(line)))
    return Trace(
        path=path,
        format="csmip_v2",
        accel_mps2=values[:npts] * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        event="".join(text[2:3]),
        station="".join(text[6:7]),
        azimuth_deg=azimuth_deg(next(directions, "")),
        warnings=tuple(warnings),
        notes=tuple(notes),
    )


# ---- K-NET and KiK-net of NIED, Japan (.EW, .NS, .UD): counts with a scale factor. The counts
# carry the offset of the instrument: the mean is subtracted, as NIED asks.

_KNET_HEADER_LINES: Final = 17
# source: NIED KiK-net manual: 1 to 3 borehole, 4 to 6 surface; N-S, E-W, U-D in turn
_KNET_CHANNELS: Final = {"1": "N-S", "2": "E-W", "4": "N-S", "5": "E-W"}
_KNET_PEAK_TOLERANCE: Final = 0.01


def _is_knet(lines: list[str], path: Path) -> bool:
    head = "\n".join(line[:HEADER_WIDTH] for line in lines[:_KNET_HEADER_LINES])
    return "Scale Factor" in head and "Sampling Freq" in head


def _read_knet(lines: list[str], path: Path, given: Given) -> Trace:
    head = "\n".join(line[:HEADER_WIDTH] for line in lines[:_KNET_HEADER_LINES])

    def value(key: str) -> str:
        match = re.search(rf"^{re.escape(key)}\s+(.*)$", head, re.MULTILINE)
        return match[1].strip() if match else ""

    scale = re.search(rf"Scale Factor\s+({FLOAT})\(gal\)\s*/\s*({FLOAT})", head)
    if scale is None:
        raise InputError(f"{path.name}: no Scale Factor in the header", file=str(path))
    frequency = re.search(rf"Sampling Freq\(Hz\)\s+({FLOAT})\s*Hz", head)
    if frequency is None:
        raise InputError(f"{path.name}: no Sampling Freq in the header", file=str(path))
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
    memo = (n + 1 for n, line in enumerate(lines[:_KNET_HEADER_LINES]) if line[:5] == "Memo.")
    start = next(memo, _KNET_HEADER_LINES)
    counts = parse_numbers(lines[start:], path, first_line=start + 1)
    if counts.size == 0:
        raise InputError(f"{path.name}: no values", file=str(path))
    accel_gal = (counts - counts.mean()) * (range_gal / counts_per_range)
    if peak := re.search(rf"Max\. Acc\. \(gal\)\s+({FLOAT})", head):
        peak_gal, header_gal = float(np.abs(accel_gal).max()), fortran_float(peak[1])
        if abs(peak_gal - header_gal) > _KNET_PEAK_TOLERANCE * header_gal:
            warnings.append(f"peak is {peak_gal:.4g} gal, the header says {header_gal:.4g}: cut?")
    direction = value("Dir.")
    return Trace(
        path=path,
        format="knet",
        accel_mps2=accel_gal * GAL,
        dt_s=dt_s,
        unit="cm/s2",
        event=value("Origin Time"),
        station=value("Station Code"),
        azimuth_deg=azimuth_deg(_KNET_CHANNELS.get(direction, direction)),
        warnings=tuple(warnings),
        notes=("instrument offset (mean) taken off",),
    )


# ---- Columns of text or CSV: time and accelerations, with or without header lines. Of several
# accelerations the channel selects one. The time step comes from the whole time column, so that
# rounded times do no harm; a gap or a step back in time is refused.

_COLUMNS_HEADER_LINES: Final = 10
_COLUMNS_PROBE_LINES: Final = 8
_COLUMNS_ROW = re.compile(rf"\s*(?P<time>{FLOAT})(?:(?:\s*[,;]\s*|\s+){FLOAT})+\s*[,;]?\s*")
_COLUMNS_SEPARATOR = re.compile(r"[\s,;]+")
_COLUMNS_UNITS: Final = (
    (re.compile(r"cm\s*/\s*s|cm_s_?2\b|\bgals?\b|_cmps2\b|_gal\b", re.IGNORECASE), "cm/s2"),
    (re.compile(r"m\s*/\s*s|m_s_?2\b|_mps2\b", re.IGNORECASE), "m/s2"),
    (re.compile(r"\bg\b|_g\b", re.IGNORECASE), "g"),
)


def _is_columns(lines: list[str], path: Path) -> bool:
    """Return whether columns start within the first lines, the first of them a time.

    In two columns the times only have to rise, so that a gap is reported later; in more columns
    the steps must be equal, or the bare values of other formats would pass.
    """
    start = _first_row_of_columns(lines)
    if start is None:
        return False
    probed = lines[start : start + _COLUMNS_PROBE_LINES]
    rows = [line[:HEADER_WIDTH] for line in probed if line.strip()]
    matches = [match for row in rows if (match := _COLUMNS_ROW.fullmatch(row))]
    counts = {_column_count(row) for row in rows}
    if len(rows) < 3 or len(matches) < len(rows) or len(counts) > 1:
        return False
    steps = np.diff([fortran_float(match["time"]) for match in matches])
    uneven = float(steps.max() - steps.min())
    return bool((steps > 0.0).all()) and (counts == {2} or uneven <= 0.02 * float(steps.mean()))


def _read_columns(lines: list[str], path: Path, given: Given) -> Trace:
    start = _first_row_of_columns(lines) or 0
    header = " ".join(line[:HEADER_WIDTH] for line in lines[:start])
    rows = [(number, line) for number, line in enumerate(lines[start:], start + 1) if line.strip()]
    count = _column_count(rows[0][1])
    values = parse_numbers([line for _, line in rows], path, first_line=start + 1)
    if values.size != count * len(rows):
        bad = next((n for n, line in rows if _column_count(line) != count), rows[-1][0])
        raise InputError(
            f"{path.name}, line {bad}: {count} columns expected", file=str(path), line=bad
        )
    table = values.reshape(-1, count)
    channel = channel_of(given, count - 1, path)
    step_s, warnings = _time_step(table[:, 0], rows, path)
    dt_s, clashes = dt_of(given, step_s, path)
    in_file = next((unit for pattern, unit in _COLUMNS_UNITS if pattern.search(header)), None)
    unit, notes = unit_of(given, in_file)
    return Trace(
        path=path,
        format="two_column" if count == 2 else f"{count}_columns",
        accel_mps2=table[:, channel] * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=tuple(clashes if given.dt_s is not None else warnings),
        notes=tuple(notes),
    )


def _first_row_of_columns(lines: list[str]) -> int | None:
    head = enumerate(lines[:_COLUMNS_HEADER_LINES])
    return next((n for n, line in head if _COLUMNS_ROW.fullmatch(line[:HEADER_WIDTH])), None)


def _column_count(line: str) -> int:
    return len([cell for cell in _COLUMNS_SEPARATOR.split(line[:HEADER_WIDTH]) if cell])


def _time_step(time_s: Vector, rows: list[tuple[int, str]], path: Path) -> tuple[float, list[str]]:
    """Return the time step of a column of times, with a warning if they are rounded."""
    steps_s = np.diff(time_s)
    mean_s = float(time_s[-1] - time_s[0]) / max(steps_s.size, 1)
    decimals = max(_decimals_of_time(line) for _, line in rows[:100])
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
    tolerance_s = quantum_s / steps_s.size
    # The number with the fewest digits within the tolerance
    rounded = (float(f"{mean_s:.{digits}g}") for digits in range(1, 16))
    step_s = next((value for value in rounded if abs(value - mean_s) <= tolerance_s), mean_s)
    if off_s.max(initial=0.0) > 1.0e-3 * mean_s:
        return step_s, [f"time column rounded to {decimals} decimals: dt = {step_s:g} s taken"]
    return step_s, []


def _decimals_of_time(line: str) -> int:
    match = _COLUMNS_ROW.fullmatch(line[:HEADER_WIDTH])
    if match is None:
        return 0
    mantissa, _, exponent = match["time"].upper().replace("D", "E").partition("E")
    digits = len(mantissa.partition(".")[2]) - (int(exponent) if exponent else 0)
    return min(max(digits, 0), 15)


# ---- Values only: one column, or the OpenSees .acc/.g3 layout with any number per line. The time
# step must be given; the unit is g unless given.


def _read_values(lines: list[str], path: Path, given: Given) -> Trace:
    values = parse_numbers(lines, path)
    dt_s, _ = dt_of(given, None, path)
    unit, notes = unit_of(given, None)
    return Trace(
        path=path,
        format="values",
        accel_mps2=values * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        notes=tuple(notes),
    )


#: The first that recognises a file reads it; the last one accepts any text.
FORMATS: Final = (
    Format(recognises=_is_knet, read=_read_knet),
    Format(recognises=_is_csmip, read=_read_csmip),
    Format(recognises=_is_peer, read=_read_peer),
    Format(recognises=_is_columns, read=_read_columns),
    Format(recognises=lambda lines, path: True, read=_read_values),
)
