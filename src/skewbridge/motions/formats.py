"""File formats of recorded motions: PEER, CSMIP/CESMD, K-NET/KiK-net, columns, bare values.

Each format has a function that recognises its text and one that reads it. A new format is a pair
of such functions and a row of `MOTION_FORMATS`.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.units import G_MPS2, GAL

UNIT_FACTORS: Final = {"g": G_MPS2, "cm/s2": GAL, "m/s2": 1.0}
_SPELLINGS: Final = {
    "cm/s/s": "cm/s2", "cm/s^2": "cm/s2", "cm/sec2": "cm/s2", "cm/sec/sec": "cm/s2",
    "gal": "cm/s2", "m/s/s": "m/s2", "m/s^2": "m/s2", "m/sec2": "m/s2",
}  # fmt: skip
# ASSUME values without a unit are in g, as in nearly all public files; a message states it.
DEFAULT_UNIT: Final = "g"
HEADER_WIDTH: Final = 300  # no header line is longer; the rest of a longer one is not searched
MAX_TOKEN: Final = 400  # longer than any line of any format; keeps the pattern below fast
MAX_MAGNITUDE: Final = 1.0e12  # counts of an instrument stay below 2^31

FLOAT: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"

_PLAIN = re.compile(r"[0-9eEdD+\-.,;\s]*")
_NUMBER = re.compile(FLOAT)
_RUN = re.compile(rf"(?:{FLOAT})(?:[+-](?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?)*")
_DECIMAL_COMMA = re.compile(r"\d,\d")
_SEPARATORS = str.maketrans(",;", "  ")


class DtMissingError(InputError):
    """The file holds values only: the time step must come from the caller or the index."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Given:
    """Properties of a file stated by the caller or the index; dt_s and unit override the header.

    Attributes:
        unit: One of ``g``, ``cm/s2``, ``m/s2``; other common spellings are converted.
        channel: Channel of a file with several, counted from 1.
        dt_s_if_missing: Time step in s of a file that does not state it.
        unit_if_missing: Unit of a file that does not state it.
    """

    dt_s: float | None = None
    unit: str | None = None
    channel: int | None = None
    dt_s_if_missing: float | None = None
    unit_if_missing: str | None = None

    def __post_init__(self) -> None:
        for name in ("unit", "unit_if_missing"):
            unit = getattr(self, name)
            if unit is None:
                continue
            unit = _SPELLINGS.get(unit.strip().lower(), unit.strip().lower())
            if unit not in UNIT_FACTORS:
                raise InputError(f"unit must be one of {', '.join(UNIT_FACTORS)}, got {unit!r}")
            object.__setattr__(self, name, unit)
        for dt_s in (self.dt_s, self.dt_s_if_missing):
            if dt_s is not None and not (np.isfinite(dt_s) and dt_s > 0.0):
                raise InputError(f"dt_s must be positive, got {dt_s}")
        if self.channel is not None and self.channel < 1:
            raise InputError(f"channel must be 1 or more, got {self.channel}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """One acceleration component read from one file.

    Attributes:
        accel_mps2: Accelerations in m/s2, shape (npts,).
        unit: Unit of the values in the file.
        sha256: Digest of the bytes of the file.
        azimuth_deg: Compass direction, nan if the header has none.
        warnings: Doubts about the values; errors under strict checks.
        notes: Assumptions of the reader, such as the unit.
    """

    path: Path
    format: str
    accel_mps2: Vector
    dt_s: float
    unit: str
    sha256: str = ""
    event: str = ""
    station: str = ""
    azimuth_deg: float = float("nan")
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def messages(self) -> tuple[str, ...]:
        """Warnings and notes."""
        return (*self.warnings, *self.notes)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FileContent:
    """Content of a file, values in its own unit, shape (npts,).

    Attributes:
        dt_s: Time step in s, None if the file does not state it; likewise the unit.
        is_calibrated: Whether the format itself sets the unit, so that a given one does not count.
        direction: Compass direction as the header writes it.
        warnings: Doubts about the values.
        notes: Assumptions of the reader.
    """

    format: str
    values: Vector
    dt_s: float | None = None
    unit: str | None = None
    is_calibrated: bool = False
    event: str = ""
    station: str = ""
    direction: str = ""
    warnings: Sequence[str] = ()
    notes: Sequence[str] = ()


def fault_in(path: Path, problem: str, line: int | None = None) -> InputError:
    """Return the error of a file of motions, with its name and the line of the problem."""
    if line is None:
        return InputError(f"{path.name}: {problem}", file=str(path))
    return InputError(f"{path.name}, line {line}: {problem}", file=str(path), line=line)


def trace_of(lines: list[str], path: Path, given: Given) -> Trace:
    """Return the component in the lines of a file of any format.

    Raises:
        InputError: The lines are not an acceleration; the message names the file.
        DtMissingError: Neither the caller nor the file states the time step.
    """
    read = next(read for recognises, read in MOTION_FORMATS if recognises(lines, path))
    content = read(lines, path, given)
    dt_s, warnings = _time_step(given, content.dt_s, path)
    unit, notes = content.unit or DEFAULT_UNIT, []
    if not content.is_calibrated:
        unit, notes = _unit(given, content.unit)
    return Trace(
        path=path,
        format=content.format,
        accel_mps2=content.values * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        event=content.event,
        station=content.station,
        azimuth_deg=_azimuth_deg(content.direction),
        warnings=(*warnings, *content.warnings),
        notes=(*notes, *content.notes),
    )


def _unit(given: Given, in_file: str | None) -> tuple[str, list[str]]:
    """Return the unit (given, of the file, given for files without one, g) and notes about it."""
    if given.unit is not None:
        clash = in_file is not None and in_file != given.unit
        note = f"unit {given.unit} as given" + (f", the header says {in_file}" if clash else "")
        return given.unit, [note] if clash or in_file is None else []
    if in_file is not None:
        clash = given.unit_if_missing not in {None, in_file}
        return in_file, [f"unit {in_file} as the header says"] if clash else []
    if given.unit_if_missing is not None:
        return given.unit_if_missing, [f"unit {given.unit_if_missing} as given"]
    return DEFAULT_UNIT, [f"no unit in the file: {DEFAULT_UNIT} taken"]


def _time_step(given: Given, in_file: float | None, path: Path) -> tuple[float, list[str]]:
    """Return the time step to use and warnings about it."""
    if given.dt_s is not None:
        clash = in_file is not None and abs(in_file / given.dt_s - 1.0) > 1.0e-6
        return given.dt_s, [f"dt {given.dt_s} s as given, the file says {in_file}"] if clash else []
    dt_s = given.dt_s_if_missing if in_file is None else in_file
    if dt_s is None:
        raise DtMissingError(
            f"{path.name}: values only, give the time step (--dt-s, or dt_s in index.csv)",
            file=str(path),
        )
    return dt_s, []


def _channel(given: Given, count: int, path: Path) -> int:
    """Return the channel of a file to read, from 1."""
    if given.channel is None and count > 1:
        raise fault_in(path, f"{count} channels, say which (channel 1 to {count})")
    channel = given.channel or 1
    if channel > count:
        raise fault_in(path, f"channel {channel} of {count}")
    return channel


def _azimuth_deg(text: str) -> float:
    """Return a compass direction written as degrees or as N, E, S, W; nan if it is neither."""
    letters = {"N": 0.0, "E": 90.0, "S": 180.0, "W": 270.0, "NS": 0.0, "EW": 90.0}
    cleaned = text.strip().upper().replace("-", "")
    if cleaned in letters:
        return letters[cleaned]
    return float(cleaned) if cleaned.isdigit() and int(cleaned) <= 360 else float("nan")


def _first_unit(units: Sequence[tuple[re.Pattern[str], str]], text: str) -> str | None:
    """Return the unit of the first pattern that a text has."""
    return next((unit for pattern, unit in units if pattern.search(text)), None)


def _fortran_float(text: str) -> float:
    """Return one number; a D may mark its exponent."""
    return float(text.upper().replace("D", "E"))


def _head(lines: list[str], count: int) -> list[str]:
    return [line[:HEADER_WIDTH] for line in lines[:count]]


def parse_numbers(lines: Sequence[str], path: Path, first_line: int = 1) -> Vector:
    """Return every number of some lines, in order; `InputError` names file and line of a bad one.

    Numbers are separated by blanks, commas or semicolons; Fortran ``D`` exponents and numbers that
    touch at a sign (``.12E-01-.76E-02``) are also read.
    """
    text = "\n".join(lines)
    if "." not in text and _DECIMAL_COMMA.search(text):
        raise fault_in(path, "decimal comma in the values")
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


def _read_peer(lines: list[str], path: Path, _given: Given) -> FileContent:
    sizes = _peer_sizes(lines)
    if sizes is None:
        if any(re.search(r"[A-Za-z]{3}", line) for line in _head(lines, _PEER_HEADER_LINES)):
            raise fault_in(path, "no NPTS and DT in the header")
        raise fault_in(path, "no header with NPTS and DT: name it .acc and give dt_s")
    row, npts, dt_s = sizes
    header = _head(lines, row)
    for line in header:
        if _NOT_ACCELERATION.search(line):
            raise fault_in(path, f"not an acceleration: {line.strip()!r}")
    # The title lines (event, station) may contain anything: units are in the last lines.
    units = filter(None, (_first_unit(_PEER_UNITS, line) for line in reversed(header[1:])))
    rows = takewhile(lambda line: not _PEER_FOOTER.match(line[:HEADER_WIDTH]), lines[row + 1 :])
    data = list(rows)
    values = parse_numbers(data, path, first_line=row + 2)
    warnings: list[str] = []
    if values.size > npts:
        if values.size - npts >= len(data[0].split()):
            raise fault_in(path, f"NPTS = {npts}, but {values.size} values")
        warnings.append(f"NPTS = {npts}, {values.size} values: cut to NPTS")
    elif values.size < npts:
        # A last value without the exponent of all others is cut: `-.31` of `-.3141593E-02`.
        last = " ".join(data[-3:]).upper().split()
        if len(last) > 1 and "E" in last[0] and "E" not in last[-1]:
            raise fault_in(path, "the file ends inside a number")
        warnings.append(f"NPTS = {npts}, {values.size} values: truncated file?")
    titles = (
        match
        for line in header[:3]
        for pattern in _PEER_TITLES
        if (match := pattern.fullmatch(line.strip()))
    )
    title = next(titles, None)
    event, station, azimuth = title.group("event", "station", "azimuth") if title else ("",) * 3
    return FileContent(
        format="peer_at2",
        values=values[:npts],
        dt_s=dt_s,
        unit=next(units, None),
        warnings=warnings,
        event=event.strip(),
        station=station.strip(),
        direction=azimuth,
    )


def _peer_sizes(lines: list[str]) -> tuple[int, int, float] | None:
    """Return row, NPTS and DT of the header line with the sizes."""
    for row, line in enumerate(_head(lines, _PEER_HEADER_LINES)):
        for pattern in _PEER_SIZES:
            if match := pattern.search(line):
                return row, int(match["npts"]), _fortran_float(match["dt"])
    return None


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
    head = " ".join(_head(lines, 2)).upper()
    return head.lstrip().startswith("CORRECTED ACCELEROGRAM") or (
        path.suffix.lower() == ".v2" and any(map(_CSMIP_BLOCK.match, _head(lines, 200)))
    )


def _read_csmip(lines: list[str], path: Path, given: Given) -> FileContent:
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
    sizes = (int(layout["per_line"]), int(layout["width"])) if layout else _CSMIP_DEFAULT_LAYOUT
    per_line, width = (max(size, 1) for size in sizes)
    rows = (line.rstrip() for line in lines[start + 1 : start + 1 + -(-npts // per_line)])
    # The columns may touch: blanks are put between them.
    spaced = [" ".join(row[i : i + width] for i in range(0, len(row), width)) for row in rows]
    values = parse_numbers(spaced, path, first_line=start + 2)
    header = lines[blocks[channel - 2][0] if channel > 1 else 0 : start]
    title = next(
        (n for n, line in enumerate(header) if "CORRECTED ACCELEROGRAM" in line.upper()), 0
    )
    text = [line.strip() for line in _head(header[title:], 25)]
    directions = (match["direction"] for line in text if (match := _CSMIP_CHANNEL.search(line)))
    truncated = f"header says {npts} points, {values.size} found: truncated file?"
    return FileContent(
        format="csmip_v2",
        values=values[:npts],
        dt_s=_fortran_float(block["dt"]),
        unit="cm/s2" if re.search("cm/sec", block["rest"], re.IGNORECASE) else None,
        event="".join(text[2:3]),
        station="".join(text[6:7]),
        direction=next(directions, ""),
        warnings=[truncated] if values.size < npts else [],
    )


# ---- K-NET and KiK-net of NIED, Japan (.EW, .NS, .UD): counts with a scale factor. The counts
# carry the offset of the instrument: the mean is subtracted, as NIED asks.

_KNET_HEADER_LINES: Final = 17
# source: NIED KiK-net manual: 1 to 3 borehole, 4 to 6 surface; N-S, E-W, U-D in turn
_KNET_CHANNELS: Final = {"1": "N-S", "2": "E-W", "4": "N-S", "5": "E-W"}
_KNET_PEAK_TOLERANCE: Final = 0.01


def _is_knet(lines: list[str], _path: Path) -> bool:
    head = "\n".join(_head(lines, _KNET_HEADER_LINES))
    return "Scale Factor" in head and "Sampling Freq" in head


def _read_knet(lines: list[str], path: Path, _given: Given) -> FileContent:
    head = "\n".join(_head(lines, _KNET_HEADER_LINES))

    def value(key: str) -> str:
        match = re.search(rf"^{re.escape(key)}\s+(.*)$", head, re.MULTILINE)
        return match[1].strip() if match else ""

    scale = re.search(rf"Scale Factor\s+({FLOAT})\(gal\)\s*/\s*({FLOAT})", head)
    frequency = re.search(rf"Sampling Freq\(Hz\)\s+({FLOAT})\s*Hz", head)
    if scale is None or frequency is None:
        missing = "Scale Factor" if scale is None else "Sampling Freq"
        raise fault_in(path, f"no {missing} in the header")
    frequency_hz, range_gal, counts_per_range = (
        _fortran_float(text) for text in (frequency[1], scale[1], scale[2])
    )
    if not (
        0.0 < frequency_hz <= MAX_MAGNITUDE
        and 0.0 < range_gal <= MAX_MAGNITUDE
        and 1.0 <= counts_per_range <= MAX_MAGNITUDE
    ):
        raise fault_in(path, "sampling and scale must be positive")
    memo = (n + 1 for n, line in enumerate(lines[:_KNET_HEADER_LINES]) if line[:5] == "Memo.")
    start = next(memo, _KNET_HEADER_LINES)
    counts = parse_numbers(lines[start:], path, first_line=start + 1)
    if counts.size == 0:
        raise fault_in(path, "no values")
    accel_gal = (counts - counts.mean()) * (range_gal / counts_per_range)
    warnings: list[str] = []
    if peak := re.search(rf"Max\. Acc\. \(gal\)\s+({FLOAT})", head):
        peak_gal, header_gal = float(np.abs(accel_gal).max()), _fortran_float(peak[1])
        if abs(peak_gal - header_gal) > _KNET_PEAK_TOLERANCE * header_gal:
            warnings.append(f"peak is {peak_gal:.4g} gal, the header says {header_gal:.4g}: cut?")
    direction = value("Dir.")
    return FileContent(
        format="knet",
        values=accel_gal,
        dt_s=1.0 / frequency_hz,
        unit="cm/s2",
        is_calibrated=True,
        event=value("Origin Time"),
        station=value("Station Code"),
        direction=_KNET_CHANNELS.get(direction, direction),
        warnings=warnings,
        notes=["instrument offset (mean) taken off"],
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


def _is_columns(lines: list[str], _path: Path) -> bool:
    """Return whether columns start within the first lines, the first of them a time.

    In two columns the times only have to rise, so that a gap is reported later; in more columns
    the steps must be equal, or the bare values of other formats would pass.
    """
    start = _first_row_of_columns(lines)
    if start is None:
        return False
    rows = [line for line in _head(lines[start:], _COLUMNS_PROBE_LINES) if line.strip()]
    matches = [match for row in rows if (match := _COLUMNS_ROW.fullmatch(row))]
    counts = {_column_count(row) for row in rows}
    if len(rows) < 3 or len(matches) < len(rows) or len(counts) > 1:
        return False
    steps = np.diff([_fortran_float(match["time"]) for match in matches])
    uneven = float(steps.max() - steps.min())
    return bool((steps > 0.0).all()) and (counts == {2} or uneven <= 0.02 * float(steps.mean()))


def _read_columns(lines: list[str], path: Path, given: Given) -> FileContent:
    start = _first_row_of_columns(lines) or 0
    rows = [(number, line) for number, line in enumerate(lines[start:], start + 1) if line.strip()]
    count = _column_count(rows[0][1])
    values = parse_numbers([line for _, line in rows], path, first_line=start + 1)
    if values.size != count * len(rows):
        bad = next((n for n, line in rows if _column_count(line) != count), rows[-1][0])
        raise fault_in(path, f"{count} columns expected", bad)
    table = values.reshape(-1, count)
    channel = _channel(given, count - 1, path)
    dt_s, warnings = _step_of_times(table[:, 0], rows, path)
    return FileContent(
        format="two_column" if count == 2 else f"{count}_columns",
        values=table[:, channel],
        dt_s=dt_s,
        unit=_first_unit(_COLUMNS_UNITS, " ".join(_head(lines, start))),
        warnings=warnings if given.dt_s is None else [],
    )


def _first_row_of_columns(lines: list[str]) -> int | None:
    head = enumerate(_head(lines, _COLUMNS_HEADER_LINES))
    return next((n for n, line in head if _COLUMNS_ROW.fullmatch(line)), None)


def _column_count(line: str) -> int:
    return len([cell for cell in _COLUMNS_SEPARATOR.split(line[:HEADER_WIDTH]) if cell])


def _step_of_times(
    time_s: Vector, rows: list[tuple[int, str]], path: Path
) -> tuple[float, list[str]]:
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
        raise fault_in(
            path,
            f"the time column jumps from {time_s[worst]:g} to {time_s[worst + 1]:g} s, "
            f"steps of {mean_s:g} s expected",
            rows[worst + 1][0],
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


def _read_values(lines: list[str], path: Path, _given: Given) -> FileContent:
    return FileContent(format="values", values=parse_numbers(lines, path))


#: Functions that recognise and read each format; the first that recognises a file reads it, and
#: the last one accepts any text.
MOTION_FORMATS: Final[
    tuple[
        tuple[Callable[[list[str], Path], bool], Callable[[list[str], Path, Given], FileContent]],
        ...,
    ]
] = (
    (_is_knet, _read_knet),
    (_is_csmip, _read_csmip),
    (_is_peer, _read_peer),
    (_is_columns, _read_columns),
    (lambda _lines, _path: True, _read_values),
)
