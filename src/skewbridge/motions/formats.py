"""Readers of recorded motions: PEER, CSMIP/CESMD, K-NET/KiK-net, columns, values alone.

Each format has a function that recognises its text and one that reads it. A new format is a pair
of such functions and a row of `MOTION_FORMATS`.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.units import G_MPS2, GAL

UNIT_FACTORS: Final = {"g": G_MPS2, "cm/s2": GAL, "m/s2": 1.0}
_SPELLINGS: Final = {"sec": "s", "^": "", "/s/s": "/s2", "gal": "cm/s2"}
# ASSUME values without a unit are in g, as in nearly all public files; a message states it.
DEFAULT_UNIT: Final = "g"
HEADER_WIDTH: Final = 300  # characters searched per header line; no format has longer lines
MAX_TOKEN: Final = 400  # longer than any line of any format; keeps the pattern below fast
MAX_MAGNITUDE: Final = 1.0e12  # counts of an instrument stay below 2^31

FLOAT: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"

_PLAIN = re.compile(r"[0-9eEdD+\-.,;\s]*")
_NUMBER = re.compile(FLOAT)
_RUN = re.compile(rf"(?:{FLOAT})(?:[+-](?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?)*")
_DECIMAL_COMMA = re.compile(r"\d,\d")
_SEPARATORS = str.maketrans(",;", "  ")


class DtMissingError(InputError):
    """The file has no time step; the caller or the index must give it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Given:
    """Properties of a file from the caller or the index; dt_s and unit override the header."""

    dt_s: float | None = None
    unit: str | None = None  # one of `UNIT_FACTORS`; other common spellings are converted
    channel: int | None = None  # channel of a file with several channels, from 1
    dt_s_if_missing: float | None = None  # time step of a file that does not state one
    unit_if_missing: str | None = None

    def __post_init__(self) -> None:
        for name in ("unit", "unit_if_missing"):
            if (unit := getattr(self, name)) is not None:
                unit = unit.strip().lower()
                for spelling, usual in _SPELLINGS.items():
                    unit = unit.replace(spelling, usual)
                if unit not in UNIT_FACTORS:
                    raise InputError(f"unit must be one of {', '.join(UNIT_FACTORS)}, got {unit!r}")
                object.__setattr__(self, name, unit)
        for dt_s in (self.dt_s, self.dt_s_if_missing):
            if dt_s is not None and not 0.0 < dt_s < np.inf:
                raise InputError(f"dt_s must be positive, got {dt_s}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """One acceleration component read from one file.

    The readers of the formats keep the unit of the file; `trace_of` converts the values to m/s2.
    A reader sets dt_s to nan and unit to an empty text if the file does not state them.
    """

    path: Path
    format: str
    accel_mps2: Vector  # shape (npts,)
    dt_s: float = math.nan
    unit: str = ""  # unit of the values in the file
    is_calibrated: bool = False  # the format defines the unit; a given unit is ignored
    sha256: str = ""  # SHA-256 of the bytes of the file
    event: str = ""
    station: str = ""
    azimuth_deg: float = math.nan  # compass direction, nan if the header has none
    warnings: tuple[str, ...] = ()  # doubts about the values; errors under strict checks
    notes: tuple[str, ...] = ()  # assumptions of the reader, such as the unit

    @property
    def messages(self) -> tuple[str, ...]:
        """Warnings and notes."""
        return (*self.warnings, *self.notes)


def fault_in(path: Path, problem: str, line: int | None = None) -> InputError:
    """Return an `InputError` that names the motion file, the line (if given) and the problem."""
    if line is None:
        return InputError(f"{path.name}: {problem}", file=str(path))
    return InputError(f"{path.name}, line {line}: {problem}", file=str(path), line=line)


def trace_of(lines: list[str], path: Path, given: Given) -> Trace:
    """Return the component in m/s2 from the lines of a file; raises the errors of `read_trace`."""
    read = next(read for recognises, read in MOTION_FORMATS if recognises(lines, path))
    trace = read(lines, path, given)
    dt_s, warnings = trace.dt_s, trace.warnings
    if given.dt_s is not None:
        dt_s = given.dt_s
        if abs(trace.dt_s / dt_s - 1.0) > 1.0e-6:
            warnings = (f"the given dt = {dt_s} s replaces {trace.dt_s} s in the file", *warnings)
    elif math.isnan(dt_s):
        if given.dt_s_if_missing is None:
            text = f"{path.name} has no time step; give it (--dt-s, or dt_s in index.csv)"
            raise DtMissingError(text, file=str(path))
        dt_s = given.dt_s_if_missing
    unit, notes = (trace.unit, []) if trace.is_calibrated else _unit(given, trace.unit)
    return replace(
        trace,
        accel_mps2=trace.accel_mps2 * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=warnings,
        notes=(*notes, *trace.notes),
    )


def _unit(given: Given, in_file: str) -> tuple[str, list[str]]:
    """Return the first unit of: given, in the file, given if missing, g; and notes on it."""
    unit = given.unit or in_file or given.unit_if_missing
    if unit is None:
        return DEFAULT_UNIT, [f"the file states no unit: {DEFAULT_UNIT} is assumed"]
    if unit != in_file:
        return unit, [f"the given unit {unit} is used" + (f", not {in_file}" if in_file else "")]
    overrides = given.unit is None and given.unit_if_missing not in {None, unit}
    return unit, [f"unit {unit} of the header is used"] if overrides else []


def _channel(given: Given, count: int, path: Path) -> int:
    if given.channel is None and count > 1:
        raise fault_in(path, f"the file has {count} channels: name one (channel 1 to {count})")
    channel = given.channel or 1
    if channel > count:
        raise fault_in(path, f"there is no channel {channel}; the file has {count}")
    return channel


def _azimuth_deg(text: str) -> float:
    """Return the compass direction in degrees from a number or letters; nan for other text."""
    letters = {"N": "0", "E": "90", "S": "180", "W": "270", "NS": "0", "EW": "90"}
    cleaned = text.strip().upper().replace("-", "")
    degrees = letters.get(cleaned, cleaned)
    return float(degrees) if degrees.isdecimal() and int(degrees) <= 360 else math.nan


def _first_unit(units: Sequence[tuple[re.Pattern[str], str]], text: str) -> str:
    """Return the unit of the first pattern found in a text; empty if none is found."""
    return next((unit for pattern, unit in units if pattern.search(text)), "")


def _fortran_float(text: str) -> float:
    """Return the number in a text; the exponent may be marked by D."""
    return float(text.upper().replace("D", "E"))


def _head(lines: list[str], count: int) -> list[str]:
    return [line[:HEADER_WIDTH] for line in lines[:count]]


def parse_numbers(lines: Sequence[str], path: Path, first_line: int = 1) -> Vector:
    """Return all numbers in lines, in order; `InputError` names file and line of a bad number.

    Numbers are separated by blanks, commas or semicolons; Fortran ``D`` exponents and numbers that
    touch at a sign (``.12E-01-.76E-02``) are also read.
    """
    text = "\n".join(lines)
    if "." not in text and _DECIMAL_COMMA.search(text):
        raise fault_in(path, "the values have decimal commas; use points")
    if _PLAIN.fullmatch(text):
        tokens = text.translate(_SEPARATORS).replace("D", "E").replace("d", "e").split()
        try:
            values = np.array(tokens, dtype=np.float64)
        except ValueError:
            pass
        else:
            if (np.abs(values) <= MAX_MAGNITUDE).all():  # also refuses inf
                return values
    numbers: list[float] = []
    for line, text in enumerate(lines, start=first_line):
        for token in text.translate(_SEPARATORS).split():
            problem, values = "is not a number", []
            if len(token) <= MAX_TOKEN and _RUN.fullmatch(token):
                problem = "is too large"
                values = [_fortran_float(number) for number in _NUMBER.findall(token)]
            if not values or max(map(abs, values)) > MAX_MAGNITUDE:
                raise fault_in(path, f"{token[:40]!r} {problem}", line)
            numbers += values
    return np.array(numbers, dtype=np.float64)


# ---- PEER acceleration files (.AT2): NGA-West2 and the older strong-motion database. Header lines
# vary in number, case and blanks: the values follow the line with NPTS and DT.

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


def _is_peer(lines: list[str], path: Path) -> bool:
    return _peer_sizes(lines) is not None or path.suffix.lower() in {".at2", ".vt2", ".dt2"}


def _read_peer(lines: list[str], path: Path, _given: Given) -> Trace:
    sizes = _peer_sizes(lines)
    if sizes is None:
        raise fault_in(path, "no header with NPTS and DT; rename bare values to .acc and give dt_s")
    row, npts, dt_s = sizes
    header = _head(lines, row)
    if other := next(filter(_NOT_ACCELERATION.search, header), None):
        raise fault_in(path, f"not an acceleration: {other.strip()!r}")
    # The title lines (event, station) may contain anything: units are in the last lines.
    units = filter(None, (_first_unit(_PEER_UNITS, line) for line in reversed(header[1:])))
    rows = takewhile(lambda line: not _PEER_FOOTER.match(line[:HEADER_WIDTH]), lines[row + 1 :])
    data = list(rows)
    values = parse_numbers(data, path, first_line=row + 2)
    warnings: tuple[str, ...] = ()
    if values.size > npts:
        if values.size - npts >= len(data[0].split()):
            raise fault_in(path, f"NPTS = {npts}, but the file has {values.size} values")
        warnings = (f"NPTS = {npts}, but there are {values.size} values: cut to NPTS",)
    elif values.size < npts:
        # If only the last value lacks an exponent, it is truncated: `-.31` of `-.3141593E-02`.
        last = " ".join(data[-3:]).upper().split()
        if len(last) > 1 and "E" in last[0] and "E" not in last[-1]:
            raise fault_in(path, "the file ends inside a number")
        warnings = (f"NPTS = {npts}, but there are {values.size} values: truncated file?",)
    titles = (pattern.fullmatch(line.strip()) for line in header[:3] for pattern in _PEER_TITLES)
    title = next(filter(None, titles), None)
    event, station, azimuth = title.group("event", "station", "azimuth") if title else ("",) * 3
    return Trace(
        path=path,
        format="peer_at2",
        accel_mps2=values[:npts],
        dt_s=dt_s,
        unit=next(units, ""),
        warnings=warnings,
        event=event.strip(),
        station=station.strip(),
        azimuth_deg=_azimuth_deg(azimuth),
    )


def _peer_sizes(lines: list[str]) -> tuple[int, int, float] | None:  # row, NPTS, DT
    for row, line in enumerate(_head(lines, 12)):
        for pattern in _PEER_SIZES:
            if match := pattern.search(line):
                return row, int(match["npts"]), _fortran_float(match["dt"])
    return None


def at2_text(motion: GroundMotion, component: int) -> str:
    """Return one component (1 or 2) as the text of a PEER file, in g with 8 digits."""
    azimuth = (motion.azimuth_1_deg, motion.azimuth_2_deg)[component - 1]
    if not math.isfinite(azimuth):
        azimuth = (360.0, 90.0)[component - 1]
    accel_g = motion.components[component - 1] / G_MPS2
    # Smaller numbers would need a three-digit exponent.
    values = np.where(np.abs(accel_g) < 1.0e-20, 0.0, accel_g).tolist()
    rows = [
        "".join(f"{value:15.7E}" for value in values[i : i + 5]) for i in range(0, len(values), 5)
    ]
    head = (
        "SYNTHETIC MOTION IN THE FORMAT OF THE PEER NGA STRONG MOTION DATABASE",
        f"{motion.event.replace(',', ';')}, 1/1/2000, {motion.station}, {azimuth:.0f}",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        f"NPTS= {motion.npts:6d}, DT= {motion.dt_s:.6g} SEC",
    )
    return "\n".join([*head, *rows, ""])


def write_at2(motion: GroundMotion, folder: Path) -> tuple[Path, Path]:
    """Write both components as `<motion_id>_h1.AT2` and `_h2.AT2`; return their paths."""
    writable_folder(folder)
    first, second = (folder / f"{motion.motion_id}_h{component}.AT2" for component in (1, 2))
    for component, path in enumerate((first, second), start=1):
        path.write_text(at2_text(motion, component), encoding="ascii", newline="\n")
    return first, second


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
    """Return whether a file is a corrected accelerogram, by its first lines or its suffix .v2."""
    head = " ".join(_head(lines, 2)).upper()
    return head.lstrip().startswith("CORRECTED ACCELEROGRAM") or (
        path.suffix.lower() == ".v2" and any(map(_CSMIP_BLOCK.match, _head(lines, 200)))
    )


def _read_csmip(lines: list[str], path: Path, given: Given) -> Trace:
    blocks = [
        (row, match)
        for row, line in enumerate(lines)
        if (match := _CSMIP_BLOCK.match(line[:HEADER_WIDTH]))
    ]
    if not blocks:
        raise fault_in(path, "no acceleration block")
    channel = _channel(given, len(blocks), path)
    start, block = blocks[channel - 1]
    npts = int(block["npts"])
    layout = _CSMIP_LAYOUT.search(block["rest"])
    sizes = map(int, layout.groups()) if layout else _CSMIP_DEFAULT_LAYOUT
    per_line, width = (max(size, 1) for size in sizes)
    rows = (line.rstrip() for line in lines[start + 1 : start + 1 + -(-npts // per_line)])
    # The columns may touch: blanks are put between them.
    spaced = [" ".join(row[i : i + width] for i in range(0, len(row), width)) for row in rows]
    values = parse_numbers(spaced, path, first_line=start + 2)
    header = lines[blocks[channel - 2][0] if channel > 1 else 0 : start]
    titles = (n for n, line in enumerate(header) if "CORRECTED ACCELEROGRAM" in line.upper())
    text = [line.strip() for line in _head(header[next(titles, 0) :], 25)]
    direction = next(filter(None, map(_CSMIP_CHANNEL.search, text)), None)
    truncated = f"the header states {npts} points, the file has {values.size}: truncated?"
    return Trace(
        path=path,
        format="csmip_v2",
        accel_mps2=values[:npts],
        dt_s=_fortran_float(block["dt"]),
        unit="cm/s2" if re.search("cm/sec", block["rest"], re.IGNORECASE) else "",
        event="".join(text[2:3]),
        station="".join(text[6:7]),
        azimuth_deg=_azimuth_deg(direction["direction"]) if direction else math.nan,
        warnings=(truncated,) if values.size < npts else (),
    )


# ---- K-NET and KiK-net of NIED, Japan (.EW, .NS, .UD): counts with a scale factor. The counts
# include the offset of the instrument: the mean is subtracted, as NIED recommends.

_KNET_HEADER_LINES: Final = 17
# source: NIED KiK-net manual: 1 to 3 borehole, 4 to 6 surface; N-S, E-W, U-D in turn
_KNET_CHANNELS: Final = {"1": "N-S", "2": "E-W", "4": "N-S", "5": "E-W"}
_KNET_SCALE = re.compile(rf"({FLOAT})\(gal\)\s*/\s*({FLOAT})")


def _is_knet(lines: list[str], _path: Path) -> bool:
    head = "\n".join(_head(lines, _KNET_HEADER_LINES))
    return "Scale Factor" in head and "Sampling Freq" in head


def _read_knet(lines: list[str], path: Path, _given: Given) -> Trace:
    head = {line[:18].strip(): line[18:].strip() for line in _head(lines, _KNET_HEADER_LINES)}
    scale = _KNET_SCALE.match(head.get("Scale Factor", ""))
    frequency = re.match(rf"({FLOAT})\s*Hz", head.get("Sampling Freq(Hz)", ""))
    if scale is None or frequency is None:
        missing = "Scale Factor" if scale is None else "Sampling Freq"
        raise fault_in(path, f"the header has no {missing}")
    numbers = [_fortran_float(text) for text in (frequency[1], *scale.groups())]
    if not all(0.0 < number <= MAX_MAGNITUDE for number in numbers) or numbers[2] < 1.0:
        raise fault_in(path, "the sampling frequency and the scale factor must be positive")
    frequency_hz, range_gal, counts_per_range = numbers
    memo = (n + 1 for n, line in enumerate(lines[:_KNET_HEADER_LINES]) if line[:5] == "Memo.")
    start = next(memo, _KNET_HEADER_LINES)
    counts = parse_numbers(lines[start:], path, first_line=start + 1)
    if counts.size == 0:
        raise fault_in(path, "no values")
    accel_gal = (counts - counts.mean()) * (range_gal / counts_per_range)
    stated, peak_gal = re.match(FLOAT, head.get("Max. Acc. (gal)", "")), np.abs(accel_gal).max()
    header_gal = _fortran_float(stated[0]) if stated else peak_gal
    truncated = f"the peak is {peak_gal:.4g} gal, but {header_gal:.4g} in the header: truncated?"
    is_truncated = abs(peak_gal - header_gal) > 0.01 * header_gal
    direction = head.get("Dir.", "")
    return Trace(
        path=path,
        format="knet",
        accel_mps2=accel_gal,
        dt_s=1.0 / frequency_hz,
        unit="cm/s2",
        is_calibrated=True,
        event=head.get("Origin Time", ""),
        station=head.get("Station Code", ""),
        azimuth_deg=_azimuth_deg(_KNET_CHANNELS.get(direction, direction)),
        warnings=(truncated,) if is_truncated else (),
        notes=("the instrument offset (mean) was removed",),
    )


# ---- Columns of text or CSV: time and accelerations, with or without header lines. The channel
# selects one of several accelerations. The time step comes from the whole time column, so rounded
# times do no harm; a gap or a step back in time is refused.

_COLUMNS_ROW = re.compile(rf"\s*(?P<time>{FLOAT})(?:(?:\s*[,;]\s*|\s+){FLOAT})+\s*[,;]?\s*")
_COLUMNS_SEPARATOR = re.compile(r"[\s,;]+")
_COLUMNS_UNITS: Final = (
    (re.compile(r"cm\s*/\s*s|cm_s_?2\b|\bgals?\b|_cmps2\b|_gal\b", re.IGNORECASE), "cm/s2"),
    (re.compile(r"m\s*/\s*s|m_s_?2\b|_mps2\b", re.IGNORECASE), "m/s2"),
    (re.compile(r"\bg\b|_g\b", re.IGNORECASE), "g"),
)


def _is_columns(lines: list[str], _path: Path) -> bool:
    # With two columns the times need only increase: a gap is reported later. With more columns the
    # steps must be equal, because files of bare values would otherwise match.
    start = _first_row_of_columns(lines)
    if start is None:
        return False
    rows = [line for line in _head(lines[start:], 8) if line.strip()]
    matches = [match for row in rows if (match := _COLUMNS_ROW.fullmatch(row))]
    counts = {_column_count(row) for row in rows}
    if len(rows) < 3 or len(matches) < len(rows) or len(counts) > 1:
        return False
    steps = np.diff([_fortran_float(match["time"]) for match in matches])
    uneven = float(steps.max() - steps.min())
    return bool((steps > 0.0).all()) and (counts == {2} or uneven <= 0.02 * float(steps.mean()))


def _read_columns(lines: list[str], path: Path, given: Given) -> Trace:
    start = _first_row_of_columns(lines) or 0
    rows = [(number, line) for number, line in enumerate(lines[start:], start + 1) if line.strip()]
    count = _column_count(rows[0][1])
    values = parse_numbers([line for _, line in rows], path, first_line=start + 1)
    if values.size != count * len(rows):
        bad = next((n for n, line in rows if _column_count(line) != count), rows[-1][0])
        raise fault_in(path, f"the row must have {count} columns", bad)
    table = values.reshape(-1, count)
    channel = _channel(given, count - 1, path)
    dt_s, warnings = _step_of_times(table[:, 0], rows, path)
    return Trace(
        path=path,
        format="two_column" if count == 2 else f"{count}_columns",
        accel_mps2=table[:, channel],
        dt_s=dt_s,
        unit=_first_unit(_COLUMNS_UNITS, " ".join(_head(lines, start))),
        warnings=warnings if given.dt_s is None else (),
    )


def _first_row_of_columns(lines: list[str]) -> int | None:
    head = enumerate(_head(lines, 10))
    return next((n for n, line in head if _COLUMNS_ROW.fullmatch(line)), None)


def _column_count(line: str) -> int:
    return len([cell for cell in _COLUMNS_SEPARATOR.split(line[:HEADER_WIDTH]) if cell])


def _step_of_times(
    time_s: Vector, rows: list[tuple[int, str]], path: Path
) -> tuple[float, tuple[str, ...]]:
    """Return the time step of a time column, and a warning if the times are rounded."""
    steps_s = np.diff(time_s)
    mean_s = float(time_s[-1] - time_s[0]) / max(steps_s.size, 1)
    decimals = max(_decimals_of_time(line) for _, line in rows[:100])
    quantum_s = 10.0**-decimals
    off_s = np.abs(steps_s - mean_s)
    # Rounding changes a time by up to half a unit of its last digit, a step by a whole one.
    allowed_s = min(1.01 * quantum_s, 0.9 * mean_s) + 1.0e-3 * mean_s
    if mean_s <= 0.0 or (steps_s <= 0.0).any() or off_s.max(initial=0.0) > allowed_s:
        worst = int(np.argmax(np.where(steps_s <= 0.0, np.inf, off_s)))
        jump = f"the time column jumps from {time_s[worst]:g} to {time_s[worst + 1]:g} s"
        raise fault_in(path, f"{jump}; every step must be {mean_s:g} s", rows[worst + 1][0])
    # the number with the fewest digits within the tolerance
    rounded = (float(f"{mean_s:.{digits}g}") for digits in range(1, 16))
    allowed_s = quantum_s / steps_s.size
    step_s = next((value for value in rounded if abs(value - mean_s) <= allowed_s), mean_s)
    if off_s.max(initial=0.0) > 1.0e-3 * mean_s:
        return step_s, (f"times are rounded to {decimals} decimals: dt = {step_s:g} s is used",)
    return step_s, ()


def _decimals_of_time(line: str) -> int:
    match = _COLUMNS_ROW.fullmatch(line[:HEADER_WIDTH])
    if match is None:
        return 0
    mantissa, _, exponent = match["time"].upper().replace("D", "E").partition("E")
    digits = len(mantissa.partition(".")[2]) - int(exponent or 0)
    return min(max(digits, 0), 15)


# ---- Values only: one column, or the OpenSees .acc/.g3 layout with any number per line. The time
# step must be given; the unit is g unless given.


def _read_values(lines: list[str], path: Path, _given: Given) -> Trace:
    return Trace(path=path, format="values", accel_mps2=parse_numbers(lines, path))


type _Recognise = Callable[[list[str], Path], bool]
type _Read = Callable[[list[str], Path, Given], Trace]
#: Functions that recognise and read each format. The first format that recognises a file is used;
#: the last one accepts any text.
MOTION_FORMATS: Final[tuple[tuple[_Recognise, _Read], ...]] = (
    (_is_knet, _read_knet),
    (_is_csmip, _read_csmip),
    (_is_peer, _read_peer),
    (_is_columns, _read_columns),
    (lambda _lines, _path: True, _read_values),
)
