"""Readers of recorded motions: PEER, CSMIP, COSMOS, GeoNet, ESM, K-NET, columns, values alone.

Each format is a row of `MOTION_FORMATS`: a function that recognises its text and a reader.
"""

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import takewhile
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass as checked_dataclass

from skewbridge.errors import InputError
from skewbridge.motions.record import Vector
from skewbridge.units import FOOT, G_MPS2, GAL, INCH, MM

UNIT_FACTORS: Final = {
    "g": G_MPS2, "cm/s2": GAL, "m/s2": 1.0, "mm/s2": MM, "in/s2": INCH, "ft/s2": FOOT,
    "mg": 1.0e-3 * G_MPS2, "%g": 1.0e-2 * G_MPS2,
}  # fmt: skip
# ASSUME values without a unit are in g, as in nearly all public files; a message states it.
DEFAULT_UNIT: Final = "g"
NO_UNIT: Final = "the file states no unit"
HEADER_WIDTH: Final = 300  # characters searched per header line; no format has longer lines
MAX_TOKEN: Final = 400  # longer than any line of any format; keeps the pattern below fast
_MISSING: Final = (-999.0, -9999.0)
MAX_MAGNITUDE: Final = 1.0e12  # counts of an instrument stay below 2^31
MAX_HEADER_LINES: Final = 10  # before the numbers of a file without a known format
DT_LIMITS_S: Final = (1.0e-4, 0.2)

_EXPONENT: Final = r"(?:[EeDd][+-]?\d+)?"
#: A number; Fortran may omit the letter of the exponent after a decimal point: 1.0-3.
FLOAT: Final = rf"[+-]?(?:(?:\d+\.\d*|\.\d+)(?:[+-]\d{{1,3}}(?![.\d])|{_EXPONENT})|\d+{_EXPONENT})"

_PLAIN = re.compile(r"[0-9eEdD+\-.,;\s]*")
_NUMBER = re.compile(FLOAT)
_RUN = re.compile(rf"{FLOAT}(?:(?=[+-]){FLOAT})*")
_DECIMAL_COMMA = re.compile(r"[\d\s+-],\d")
_SEPARATORS = str.maketrans(",;", "  ")


def _known_unit(text: str) -> str:
    if (unit := _usual_units(text.strip())) not in UNIT_FACTORS:
        raise ValueError(f"must be one of {', '.join(UNIT_FACTORS)}")
    return unit


#: One of `UNIT_FACTORS`; other common spellings are converted.
Unit = Annotated[str, AfterValidator(_known_unit)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]


class DtMissingError(InputError):
    """The file has no time step; the caller or the index must give it."""


@checked_dataclass(frozen=True, slots=True, kw_only=True)
class Stated:
    """Properties of a file stated by the caller or the index; dt_s and unit override the header."""

    dt_s: Positive | None = None
    unit: Unit | None = None
    channel: int | None = None  # channel of a file with several channels, from 1
    dt_s_if_missing: Positive | None = None  # time step of a file that does not state one
    unit_if_missing: Unit | None = None


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
    event: str = ""
    station: str = ""
    direction: str = ""  # of the component, as in the header: an azimuth, N-S, HNE, Up
    start_s: float = math.nan  # first value of a time column
    warnings: tuple[str, ...] = ()  # doubts about the values; errors under strict checks
    notes: tuple[str, ...] = ()  # assumptions of the reader, such as the unit

    @property
    def messages(self) -> tuple[str, ...]:
        """Warnings and notes of the reader."""
        return (*self.warnings, *self.notes)

    @property
    def azimuth_deg(self) -> float:
        """Compass direction in degrees; nan if the header has none."""
        cleaned = self.direction.strip().upper().replace("-", "")
        if match := re.fullmatch(r"([NS])(\d{1,2})([EW])", cleaned):  # S62W
            start, turn, end = match.groups()
            sign = 1.0 if (start == "N") == (end == "E") else -1.0
            return ((0.0 if start == "N" else 180.0) + sign * float(turn)) % 360.0
        if re.fullmatch("[A-Z]{2}[NE]", cleaned):  # HNE: band, instrument and direction
            cleaned = cleaned[-1]
        letters = {"N": "0", "E": "90", "S": "180", "W": "270", "NS": "0", "EW": "90"}
        degrees = letters.get(cleaned, cleaned)
        return float(degrees) if degrees.isdecimal() and int(degrees) <= 360 else math.nan

    @property
    def is_vertical(self) -> bool:
        """Whether the header states a vertical direction."""
        return bool(_VERTICAL.search(self.direction.replace("-", "").replace("_", " ")))


def fault_in(path: Path, problem: str, line: int | None = None) -> InputError:
    """Return an `InputError` that names the motion file, the line (if given) and the problem."""
    if line is None:
        return InputError(f"{path.name}: {problem}", file=str(path))
    return InputError(f"{path.name}, line {line}: {problem}", file=str(path), line=line)


def trace_of(lines: list[str], path: Path, stated: Stated) -> Trace:
    """Return the component in m/s2 from the lines of a file; raises the errors of `read_trace`."""
    reader = next(reader for _, recognises, reader in MOTION_FORMATS if recognises(lines, path))
    trace = reader(lines, path, stated)
    dt_s, warnings = trace.dt_s, trace.warnings
    if not (trace.unit or stated.unit) and _OTHER_NAME.search(path.name.lower()):
        text = "not an acceleration by its name: if it is one, state its unit in index.csv"
        raise fault_in(path, text)
    if missing := int(np.isin(trace.accel_mps2, _MISSING).sum()):
        warnings = (f"{missing} values are -999 or -9999: missing values?", *warnings)
    if stated.dt_s is not None:
        dt_s = stated.dt_s
        if abs(trace.dt_s / dt_s - 1.0) > 1.0e-6:
            warnings = (f"the given dt = {dt_s} s replaces {trace.dt_s} s in the file", *warnings)
    elif math.isnan(dt_s):
        if stated.dt_s_if_missing is None:
            advice = "in a first line as dt = 0.01, or with --dt-s of skewbridge motions"
            text = f"{path.name} has no time step: state it in index.csv, {advice}"
            raise DtMissingError(text, file=str(path))
        dt_s = stated.dt_s_if_missing
    unit, notes = (trace.unit, []) if trace.is_calibrated else _unit(stated, trace.unit)
    return replace(
        trace,
        accel_mps2=trace.accel_mps2 * UNIT_FACTORS[unit],
        dt_s=dt_s,
        unit=unit,
        warnings=warnings,
        notes=(*notes, *trace.notes),
    )


def _unit(stated: Stated, in_file: str) -> tuple[str, list[str]]:
    """Return the unit (`Stated.unit`, else ``in_file``, `unit_if_missing` or g) and notes on it."""
    unit = stated.unit or in_file or stated.unit_if_missing
    if unit is None:
        return DEFAULT_UNIT, [f"{NO_UNIT}: {DEFAULT_UNIT} is assumed"]
    if unit != in_file:
        return unit, [f"the given unit {unit} is used" + (f", not {in_file}" if in_file else "")]
    overrides = stated.unit is None and stated.unit_if_missing not in {None, unit}
    return unit, [f"unit {unit} of the header is used"] if overrides else []


def _channel(stated: Stated, directions: Sequence[str], path: Path) -> int:
    count = len(directions)
    if stated.channel is None and count > 1:
        channels = ", ".join(f"{n} {text}".strip() for n, text in enumerate(directions, 1))
        where = "channel_1 and channel_2 in index.csv"
        raise fault_in(path, f"the file has {count} channels ({channels}): choose two with {where}")
    channel = stated.channel or 1
    if channel > count:
        raise fault_in(path, f"there is no channel {channel}: the file has {count}")
    return channel - 1


# ---- Units, quantities and directions in headers

_LENGTH: Final = "(?:[cm]?m|in|ft)"
_USUAL_UNITS: Final = (
    (r"sec(?:ond)?s?", "s"), (r"inch(?:es)?", "in"), (r"\*\*|[\^{}]", ""), (r"\s+per\s+", "/"),
    (r"(?<![a-z])(?:(c)enti|(m)illi)?met(?:er|re)s?(?=\s*/)", r"\1\2m"), (r"\s+squared", "2"),
    (r"/\s*s\s*\*\s*s(?![a-z])", "/s2"),
    (r"f(?:ee|oo)t(?=\s*/)", "ft"), (r"milli-?g(?![a-z])", "mg"),
    (r"\s*/\s*s", "/s"), ("/s/s", "/s2"), (rf"(?<![a-z])({_LENGTH})[ .*_]?s-2", r"\1/s2"),
    # cmps2, cm_s_2, ms2
    (rf"(?<![a-z])({_LENGTH})(?:(?:p|_per_|_)s_?(2?)|s(2))(?![a-z0-9])", r"\1/s\2\3"),
    (r"(?<![a-z])gals?(?![a-z])", "cm/s2"),
)  # fmt: skip
_STATED: Final = r"(?<![a-z0-9/.%])(?<!\d )"  # not after a number, as in Vs30 = 760 m/s
_ACCELERATION_UNIT = re.compile(rf"{_STATED}({_LENGTH}/s2|[m%]?g)(?![a-z0-9/]|\s*=)")
_VELOCITY_UNIT = re.compile(rf"{_STATED}(?:{_LENGTH}/s|kines?)(?![a-z0-9/])")
_OTHER_WORD: Final = r"(?<![a-z])(?:vel(?:oc\w*)?|disp(?:l\w*)?)(?![a-z])"
_OTHER_NAME = re.compile(rf"{_OTHER_WORD}|\.[vd]t2$")
_OTHER_QUANTITY = re.compile(
    rf"{_STATED}[cm]m(?![a-z0-9/])|[(\[]\s*{_LENGTH}\s*[)\]]|_{_LENGTH}(?![a-z0-9/_])"
    rf"|^\W*{_LENGTH}\W*$|units?\W*(?:of\W+)?(?:m|ft)(?![a-z0-9/])|{_OTHER_WORD}"
)
_ACCELERATION_WORD = re.compile(r"(?<![a-z])acc(?:n|el[a-z]*)?(?![a-z])")
_VERTICAL = re.compile(
    r"(?<![a-z])(?:up|down|dw?n|ud?|d|u d|v|vert?|vertical|z|az|acc?z|[a-z][ghln]z)(?![a-z])", re.I
)


def _usual_units(text: str) -> str:
    """Return a text in lower case with the usual spelling of units: cm/s2 for cm/sec/sec, gal."""
    text = text.lower().translate(str.maketrans("²⁻·", "2-."))
    for pattern, unit in _USUAL_UNITS:
        text = re.sub(pattern, unit, text)
    return text


def _unit_in(texts: Iterable[str], path: Path) -> str:
    """Return the unit of acceleration in header texts, the most specific first; empty if none.

    Raises `InputError` if the first text with a quantity states a velocity or displacement.
    """
    is_acceleration = False
    for text in texts:
        plain = _usual_units(text)
        if units := [*_ACCELERATION_UNIT.finditer(plain)]:
            # in a_g (m/s2), g is part of the symbol
            in_brackets = [match for match in units if plain[: match.start()].endswith(("(", "["))]
            return max((match[1] for match in in_brackets or units), key=len)
        word = _ACCELERATION_WORD.search(plain)
        not_accel = _VELOCITY_UNIT.search(plain) or (word is None and _OTHER_QUANTITY.search(plain))
        if not_accel and not is_acceleration:
            raise fault_in(path, f"not an acceleration by its header: {text.strip()[:80]!r}")
        is_acceleration |= word is not None
    return ""


def _fortran_float(text: str) -> float:
    return float(_with_exponent(text))


def _with_exponent(text: str) -> str:
    """Return a number of Fortran with the letter E before its exponent."""
    return re.sub(r"(?<=[\d.])(?=[+-])", "E", text.upper().replace("D", "E"))


def _first_number(text: str | None) -> float:
    match = _NUMBER.match(text or "")
    return _fortran_float(match[0]) if match else math.nan


def _counted(
    values: Vector, name: str, count: int, path: Path, per_line: int = 1
) -> tuple[Vector, tuple[str, ...]]:
    """Return at most ``count`` values, which a header states, and a warning if it is wrong."""
    text = f"{name} = {count}, but the file has {values.size} values"
    if values.size - count >= per_line:
        raise fault_in(path, f"{text}: correct {name}")
    doubt = f"cut to {name}" if values.size > count else "truncated file?"
    return values[:count], (f"{text}: {doubt}",) if values.size != count else ()


def _head(lines: list[str], count: int) -> list[str]:
    return [line[:HEADER_WIDTH] for line in lines[:count]]


def parse_numbers(lines: Sequence[str], path: Path, first_line: int = 1) -> Vector:
    """Return all numbers in lines, in order; `InputError` names file and line of a bad number.

    Numbers are separated by blanks, commas or semicolons; Fortran ``D`` exponents and numbers that
    touch at a sign (``.12E-01-.76E-02``) are also read.
    """
    text = "\n".join(lines)
    if "." not in text and _DECIMAL_COMMA.search(text):
        raise fault_in(path, "the values have decimal commas: write points")
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
                problem = f"is above {MAX_MAGNITUDE:g}"
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
_PEER_TITLES = (
    re.compile(
        r"(?P<event>[^,]+),\s*[\d/ ]+,\s*(?P<station>.*),\s*"
        r"(?P<direction>-?(?:\d{1,3}|[A-Z]{1,3}|(?i:u-?d|up|down|vert(?:ical)?)))"
    ),
    # the older database: EVENT 5/19/40 0439, STATION, 180 (USGS STATION 117)
    re.compile(
        r"(?P<event>[^,]+?)\s+\d+/\d+/\d+[^,]*,\s*(?P<station>.*),\s*"
        r"(?P<direction>\d{1,3}|(?i:up|ud|down|dwn|vert(?:ical)?))\b.*"
    ),
)
_PEER_FOOTER = re.compile(r"^\s*\*+\s*end\b", re.IGNORECASE)


def _is_peer(lines: list[str], path: Path) -> bool:
    return _peer_sizes(lines) is not None or path.suffix.lower() in {".at2", ".vt2", ".dt2"}


def _read_peer(lines: list[str], path: Path, _stated: Stated) -> Trace:
    sizes = _peer_sizes(lines)
    if sizes is None:
        raise fault_in(path, "no header with NPTS and DT: rename bare values to .acc, give dt_s")
    row, npts, dt_s = sizes
    header = _head(lines, row)
    # The title lines (event, station) may contain anything: units are in the last lines.
    unit = _unit_in(reversed(header[1:]), path)
    rows = takewhile(lambda line: not _PEER_FOOTER.match(line[:HEADER_WIDTH]), lines[row + 1 :])
    data = list(rows)
    all_values = parse_numbers(data, path, first_line=row + 2)
    per_line = len("".join(data[:1]).split())
    values, warnings = _counted(all_values, "NPTS", npts, path, per_line)
    # If only the last value lacks an exponent, it is truncated: `-.31` of `-.3141593E-02`.
    tokens = " ".join(data[-3:]).upper().split() if values.size < npts else []
    if len(tokens) > 1 and "E" in tokens[0] and "E" not in tokens[-1]:
        raise fault_in(path, "the file ends inside a number: get the whole file")
    titles = (pattern.fullmatch(line.strip()) for line in header[:3] for pattern in _PEER_TITLES)
    title = next(filter(None, titles), None)
    texts = {name: text.strip() for name, text in title.groupdict().items()} if title else {}
    fields: Any = {"dt_s": dt_s, "unit": unit, "warnings": warnings, **texts}
    return Trace(path=path, format="peer_at2", accel_mps2=values, **fields)


def _peer_sizes(lines: list[str]) -> tuple[int, int, float] | None:  # row, NPTS, DT
    for row, line in enumerate(_head(lines, 12)):
        for pattern in _PEER_SIZES:
            if match := pattern.search(line):
                return row, int(match["npts"]), _fortran_float(match["dt"])
    return None


# ---- Blocks of fixed-width numbers, which may touch: CSMIP, COSMOS and GeoNet. A file may have
# several channels. Velocities and displacements are skipped.


class _Block(NamedTuple):
    """Header of the acceleration block of one channel."""

    row: int  # line of the first values, from 0
    npts: int
    layout: str  # Fortran format of the values
    dt_s: float
    unit: str
    event: str
    station: str
    direction: str


def _trace_of_block(
    blocks: list[_Block], lines: list[str], path: Path, stated: Stated, **fields: Any
) -> Trace:
    """Return the component of the stated channel; ``fields`` are further fields of `Trace`."""
    block = blocks[_channel(stated, [b.direction for b in blocks], path)]
    all_values = _fixed_width(lines, block.row, block.npts, block.layout, path)
    values, warnings = _counted(all_values, "NPTS", block.npts, path)
    texts = ("unit", "event", "station", "direction")
    fields |= {name: getattr(block, name).strip() for name in texts}
    return Trace(path=path, accel_mps2=values, dt_s=block.dt_s, warnings=warnings, **fields)


def _fixed_width(lines: list[str], row: int, count: int, layout: str, path: Path) -> Vector:
    """Return `count` numbers from a row (from 0) on, with a Fortran format such as (8f10.3)."""
    sizes = re.findall(r"(?i)\(\s*(\d{0,2})[a-z](\d{1,2})", layout + _CSMIP_LAYOUT)[0]
    per_line, width = (max(int(size or 1), 1) for size in sizes)
    rows = (line.rstrip() for line in lines[row : row + -(-count // per_line)])
    spaced = [" ".join(text[i : i + width] for i in range(0, len(text), width)) for text in rows]
    return parse_numbers(spaced, path, first_line=row + 1)[:count]


# CSMIP/CESMD corrected data (.V2): each channel has its own 45-line header.

_CSMIP_BLOCK = re.compile(
    r"^\s*(?P<npts>\d{1,9})\s+points\s+of\s+accel\w*\s+data\s+equally\s+spaced\s+at\s+"
    rf"(?P<dt>{FLOAT})\s*sec(?P<rest>.*)$",
    re.IGNORECASE,
)
_CSMIP_CHANNEL = re.compile(r"CHAN\s*\d+:\s*(-?\w+)", re.IGNORECASE)
_CSMIP_LAYOUT: Final = "(8F10.3)"  # source: CSMIP report OSMS 85-03


def _is_csmip(lines: list[str], path: Path) -> bool:
    header = " ".join(_head(lines, 2)).upper()
    return header.lstrip().startswith("CORRECTED ACCELEROGRAM") or (
        path.suffix.lower() == ".v2" and any(map(_CSMIP_BLOCK.match, _head(lines, 200)))
    )


def _read_csmip(lines: list[str], path: Path, stated: Stated) -> Trace:
    blocks: list[_Block] = []
    previous = 0
    for row, line in enumerate(lines):
        if (match := _CSMIP_BLOCK.match(line[:HEADER_WIDTH])) is None:
            continue
        titles = (n for n in range(previous, row) if "CORRECTED ACCELEROGRAM" in lines[n].upper())
        header = _head(lines[next(titles, previous) : row], 25)
        direction = "".join(_CSMIP_CHANNEL.findall("\n".join(header))[:1])
        unit = _unit_in([match["rest"]], path)
        size_and_step = int(match["npts"]), match["rest"], _fortran_float(match["dt"])
        event, station = "".join(header[2:3]), "".join(header[6:7])
        blocks.append(_Block(row + 1, *size_and_step, unit, event, station, direction))
        previous = row
    if not blocks:
        raise fault_in(path, "the file has no block of accelerations: truncated?")
    return _trace_of_block(blocks, lines, path, stated, format="csmip_v2")


# COSMOS files of CESMD (.V2c): text, integers, reals, comments and a block of values.
# source: COSMOS Strong Motion Data Format 1.20 (2001), headers and tables of units and orientations

_COSMOS_HEADER = re.compile(r"^\s*(\d{1,4})\s+(?:integer|real)-header values.*format(.*)$", re.I)
_COSMOS_BLOCK = re.compile(
    r"^\s*(?P<npts>\d{1,9})\s+(?P<quantity>[a-z ]*?)\s*pts,\s*approx\s+(?P<length>[\d.]+)\s*secs?,"
    r"\s*units\s*=(?P<unit>.*?),\s*format\s*=(?P<layout>.*)$",
    re.IGNORECASE,
)
_COSMOS_CHANNEL = re.compile(r"sta cha[^:]*:\s*(\w+)|<scnl>[^.\s]*\.(\w+)", re.IGNORECASE)
_COSMOS_UNITS: Final = {2: "g", 4: "cm/s2", 7: "in/s2", 10: "cm/s2", 11: "mg"}
_COSMOS_VERTICAL: Final = {400: "Up", 401: "Down", 402: "Vertical"}


def _read_cosmos(lines: list[str], path: Path, stated: Stated) -> Trace:
    blocks: list[_Block] = []
    title, problem = 0, "the file has no block of values: truncated?"
    for row, line in enumerate(_head(lines, len(lines))):
        title = row if "(format v" in line.lower() else title
        if (match := _COSMOS_BLOCK.match(line)) is None:
            continue
        headers = ((n, _COSMOS_HEADER.match(lines[n][:HEADER_WIDTH])) for n in range(title, row))
        arrays = [_fixed_width(lines, n + 1, int(m[1]), m[2], path) for n, m in headers if m]
        if len(arrays) != 2 or arrays[0].size < 54 or arrays[1].size < 62:
            raise fault_in(path, "the block has no integer or real header: truncated?", row + 1)
        parameter, unit_code, azimuth = (int(arrays[0][n]) for n in (1, 2, 53))
        npts, dt_s = int(match["npts"]), float(arrays[1][61]) * 1.0e-3
        length_s = float(match["length"])  # rounded
        if not match["quantity"].lower().startswith("accel") or parameter not in {1, -999}:
            problem = f"not an acceleration: {line.strip()!r}"
        elif not (unit := _COSMOS_UNITS.get(unit_code) or _unit_in([match["unit"]], path)):
            problem = f"unknown unit {match['unit'].strip()!r}; known: {', '.join(UNIT_FACTORS)}"
        elif abs(npts * dt_s - length_s) > 1.0 + 0.01 * length_s:
            problem = f"the header states {npts} points of {dt_s:g} s, but {length_s:g} s in all"
        else:
            compass = str(azimuth) if 1 <= azimuth <= 360 else _COSMOS_VERTICAL.get(azimuth, "")
            names = _COSMOS_CHANNEL.findall("\n".join(lines[title:row]))
            directions = [compass, *(text for pair in names for text in pair if text)]
            direction = next(filter(_VERTICAL.search, directions), compass or directions[-1])
            event, station = lines[title + 1], lines[title + 4]
            fields = (npts, match["layout"], dt_s, unit, event, station, direction)
            blocks.append(_Block(row + 1, *fields))
    if not blocks:
        raise fault_in(path, problem)
    return _trace_of_block(blocks, lines, path, stated, format="cosmos", is_calibrated=True)


# GeoNet of GNS Science, New Zealand (.V2A): for each of three components 16 lines of text, 40
# integers, 60 reals, and the accelerations (mm/s2), velocities and displacements, ten per line.
# source: GNS Science, accelerogram data files, standard format (2008)


def _is_geonet(lines: list[str], _path: Path) -> bool:
    top = [line.strip().lower() for line in _head(lines, 13)]
    expected = zip(top[9::3], ("number of points", "component"), strict=False)
    return len(top) == 13 and "accelerogram" in top[0] and all(a.startswith(b) for a, b in expected)


def _read_geonet(lines: list[str], path: Path, stated: Stated) -> Trace:
    if lines[0].strip().lower().startswith("uncorrected"):
        raise fault_in(path, "the accelerogram is uncorrected: use the corrected one (.V2A)")
    blocks: list[_Block] = []
    start = 0
    while any(line.strip() for line in lines[start : start + 20]):
        sizes = _fixed_width(lines, start + 16, 40, "(10I8)", path)[33:36]
        real_header = _fixed_width(lines, start + 20, 60, "(10F8.0)", path)
        is_valid = sizes.size == 3 and real_header.size == 60 and sizes[0] > 0.0 <= sizes.min()
        if not (is_valid and sizes.max() < 1.0e9 and _is_geonet(lines[start:], path)):
            raise fault_in(path, "no valid header of a component: truncated?", start + 1)
        station, direction = ("".join(lines[start + n].split()[1:2]) for n in (1, 12))
        fields = (int(sizes[0]), "(10F8.1)", float(real_header[25]), "mm/s2", lines[start + 7])
        blocks.append(_Block(start + 26, *fields, station, direction))
        start += 26 + sum(-(-int(size) // 10) for size in sizes)
    return _trace_of_block(blocks, lines, path, stated, format="geonet_v2a", is_calibrated=True)


# ---- ESM and ITACA, Europe and Italy (.ASC): 64 header lines KEY: VALUE and one value per line.


def _read_esm(lines: list[str], path: Path, _stated: Stated) -> Trace:
    header = list(takewhile(lambda line: ":" in line, _head(lines, 100)))
    texts = {key: text.strip() for key, _, text in (line.partition(":") for line in header)}
    if (quantity := texts.get("DATA_TYPE", "")) != "ACCELERATION":
        raise fault_in(path, f"DATA_TYPE must be ACCELERATION, got {quantity!r}")
    dt_s, npts = (_first_number(texts.get(key)) for key in ("SAMPLING_INTERVAL_S", "NDATA"))
    if math.isnan(dt_s + npts):
        raise fault_in(path, "the header needs SAMPLING_INTERVAL_S and NDATA")
    all_values = parse_numbers(lines[len(header) :], path, first_line=len(header) + 1)
    values, warnings = _counted(all_values, "NDATA", round(npts), path)
    name = texts.get("EVENT_ID") or f"{texts['EVENT_NAME']} {texts.get('EVENT_DATE_YYYYMMDD')}"
    station = f"{texts.get('NETWORK', '')}.{texts.get('STATION_CODE', '')}"
    fields: Any = {"event": name, "station": station, "direction": texts.get("STREAM", "")}
    fields |= {"dt_s": dt_s, "unit": _unit_in([texts.get("UNITS", "")], path)}
    return Trace(path=path, format="esm", accel_mps2=values, warnings=warnings, **fields)


# ---- K-NET and KiK-net of NIED, Japan (.EW, .NS, .UD): counts with a scale factor. The counts
# include the offset of the instrument: the mean is subtracted, as NIED recommends.

_KNET_HEADER_LINES: Final = 17
# source: NIED KiK-net manual: 1 to 3 borehole, 4 to 6 surface; N-S, E-W, U-D in turn
_KNET_CHANNELS: Final = dict(zip("123456", ("N-S", "E-W", "U-D") * 2, strict=True))
_KNET_SCALE = re.compile(rf"({FLOAT})\(gal\)\s*/\s*({FLOAT})")


def _read_knet(lines: list[str], path: Path, _stated: Stated) -> Trace:
    entries = {line[:18].strip(): line[18:].strip() for line in _head(lines, _KNET_HEADER_LINES)}
    names = ("Sampling Freq(Hz)", "Duration Time(s)", "Max. Acc. (gal)")
    frequency_hz, duration_s, header_gal = (_first_number(entries.get(name)) for name in names)
    scale = _KNET_SCALE.match(entries.get("Scale Factor", ""))
    range_gal, counts_per_range = map(_fortran_float, scale.groups()) if scale else (0.0, 0.0)
    header_values = (frequency_hz, range_gal, counts_per_range)
    if not all(0.0 < n <= MAX_MAGNITUDE for n in header_values) or counts_per_range < 1.0:
        text = "the header needs a Sampling Freq(Hz) and a Scale Factor (gal / counts) above zero"
        raise fault_in(path, text)
    memo_rows = (n + 1 for n, line in enumerate(lines[:_KNET_HEADER_LINES]) if line[:5] == "Memo.")
    start = next(memo_rows, _KNET_HEADER_LINES)
    counts = parse_numbers(lines[start:], path, first_line=start + 1)
    if counts.size == 0:
        raise fault_in(path, "the file has no values after its header")
    accel_gal = (counts - counts.mean()) * (range_gal / counts_per_range)
    peak_gal, npts = np.abs(accel_gal).max(), duration_s * frequency_hz
    is_truncated = abs(peak_gal - header_gal) > 0.01 * header_gal
    is_truncated |= counts.size < npts - frequency_hz
    states = f"the header states {header_gal:.4g} gal and {npts:.0f} values"
    truncated = f"{states}, the file has {peak_gal:.4g} gal and {counts.size}: truncated?"
    direction = entries.get("Dir.", "")
    return Trace(
        path=path,
        format="knet",
        accel_mps2=accel_gal,
        dt_s=1.0 / frequency_hz,
        unit="cm/s2",
        is_calibrated=True,
        event=entries.get("Origin Time", ""),
        station=entries.get("Station Code", ""),
        direction=_KNET_CHANNELS.get(direction, direction),
        warnings=(truncated,) if is_truncated else (),
        notes=("the instrument offset (mean) was removed",),
    )


# ---- Numbers below at most `MAX_HEADER_LINES` lines: columns with or without time, or one series
# with any number of values per line. The header may state the unit, and a line the count and step.
# The time step comes from the whole time column, so rounded times do no harm; a gap or a step back
# is refused.

_DATA = re.compile(r"(?=\D*\d)\s*[-+.\d][-+.,;\sEeDd\d]*")
_COLUMNS_ROW = re.compile(rf"\s*(?P<time>{FLOAT})(?:(?:\s*[,;]\s*|\s+){FLOAT})+\s*[,;]?\s*")
_COLUMNS_SEPARATOR = re.compile(r"[\s,;]+")
_TIME = re.compile(r"t(?:ime)?(?![a-z])", re.IGNORECASE)
_MILLISECONDS = re.compile(r"(?i)(?<![a-z])m(?:illi-?)?s(?:ec\w*)?(?![a-z0-9])")
_CELL_SEPARATORS: Final = (r"\s*[,;\t]\s*", r"\s{2,}", r"[\s,;]+")
_COUNT_AND_STEP = (  # 3500 0.01, perhaps followed by text; 0.01 3500; NPTS 3500 DT 0.01
    re.compile(rf"\s*(?P<npts>\d{{2,9}})[\s,;]+(?P<dt>{FLOAT})(?:[\s,;].*)?"),
    re.compile(rf"\s*(?P<dt>{FLOAT})[\s,;]+(?P<npts>\d{{2,9}})(?:[\s,;].*)?"),
    re.compile(rf"(?i).*\b(?:npts?|points)\W+(?P<npts>\d{{2,9}})\W.*\bdt\W+(?P<dt>{FLOAT}).*"),
)
# ASSUME values of one series differ less from the next one than from those one line apart, by this
# factor; values of several components the other way. Noise is within both limits.
SERIES_RATIO: Final = 0.7


@dataclass(frozen=True, slots=True)
class _Table:
    """Lines of numbers and the header above them."""

    header: list[str]
    rows: list[tuple[int, str]]  # line number from 1 and text, without blank lines
    npts: int | None = None  # number of values in the header
    dt_s: float = math.nan

    @property
    def columns(self) -> int:
        """Number of columns of the first row."""
        return _column_count(self.rows[0][1])

    def cells(self, column: int) -> list[str]:
        """Return the header texts above a column (from 0), from the last header line upwards."""
        texts: list[str] = []
        for line in reversed(self.header):
            line = re.sub(r"\s+([(\[])", r"\1", line.strip(" \t#%!\"'").rstrip(",; \t"))
            splits = (re.split(separator, line) for separator in _CELL_SEPARATORS)
            texts += next(([row[column]] for row in splits if len(row) == self.columns), [])
        return texts


def _table_of(lines: list[str]) -> _Table | None:
    """Return the lines of numbers and their header; None if it exceeds `MAX_HEADER_LINES`."""
    header = _head(lines, MAX_HEADER_LINES + 2)
    rows = (n for n, line in enumerate(header[: MAX_HEADER_LINES + 1]) if _DATA.fullmatch(line))
    if (start := next(rows, None)) is None:
        return None
    npts, dt_s = None, math.nan
    # A row of two numbers is a count and a step if the next row is of another kind, or at time 0.
    a, b = (_COLUMNS_SEPARATOR.split(line.strip()) for line in (*header, "")[start:][:2])
    is_unlike = len(a) != len(b) or (
        len(a) == 2 and ((a[0].isdigit() and not b[0].isdigit()) or not b[0].strip("0.+-"))
    )
    for row, line in enumerate(header[: start + is_unlike]):
        match = next(filter(None, (pattern.fullmatch(line) for pattern in _COUNT_AND_STEP)), None)
        if match and DT_LIMITS_S[0] <= _fortran_float(match["dt"]) <= DT_LIMITS_S[1]:
            npts, dt_s, start = int(match["npts"]), _fortran_float(match["dt"]), max(start, row + 1)
    rows = [(n, line) for n, line in enumerate(lines[start:], start + 1) if line.strip()]
    return _Table(header[:start], rows, npts, dt_s) if rows else None


def _has_time(table: _Table) -> bool:
    """Return whether column 1 is named time, is evenly spaced, or rises and is one of two columns.

    Gaps and backward steps are refused later, by `_step_of_times`.
    """
    rows = [line[:HEADER_WIDTH] for _, line in table.rows[:1000]]
    matches = [_COLUMNS_ROW.fullmatch(row) for row in rows]
    if len(rows) < 3 or not all(matches[:8]) or len({*map(_column_count, rows[:8])}) > 1:
        return False
    times_s = np.array([_fortran_float(match["time"]) for match in matches if match])
    steps_s, first_s = np.diff(times_s), times_s[:8]
    if any(map(_TIME.match, table.cells(0))):
        return bool((steps_s >= 0.0).mean() >= 0.9)
    line_s = np.linspace(first_s[0], first_s[-1], first_s.size)
    is_even = np.abs(first_s - line_s).max() <= 0.6 * (line_s[1] - line_s[0])
    is_rising = (steps_s[:7] > 0.0).all() and (steps_s > 0.0).mean() >= 0.9
    return bool(is_rising and (is_even or table.columns == 2))


def _read_numbers(lines: list[str], path: Path, stated: Stated) -> Trace:
    if (table := _table_of(lines)) is None:
        formats = ", ".join(name for name, _, _ in MOTION_FORMATS)
        text = f"unknown format: no numbers after at most {MAX_HEADER_LINES} header lines"
        raise fault_in(path, f"{text}. Formats that are read: {formats}")
    if any(re.match(r"(?i)(period|freq)", cell) for cell in table.cells(0)):
        raise fault_in(path, "looks like a spectrum: a record of accelerations is needed")
    time_at = [any(map(_TIME.match, table.cells(column))) for column in range(table.columns)]
    if time_at[:2] == [False, True] and len(time_at) > 2:  # numbers of the rows before the times
        lines = [re.sub(r"^\s*[^\s,;]*[\s,;]+", "", line) for line in lines]
        return _read_numbers(lines, path, stated)
    rows, count, dt_s, npts = table.rows, table.columns, table.dt_s, table.npts
    start = rows[0][0]
    values, warnings, shift = parse_numbers(lines[start - 1 :], path, start), (), 0
    has_time = _has_time(table)
    is_table = has_time or _are_channels(table, values, stated, path)
    if npts is None and not is_table and values[0] in {values.size - 1, values.size - 2}:
        raise fault_in(path, "the first number is the count of the others: remove it", start)
    if (is_table or count == 1) and values.size != count * len(rows):
        bad_line = next((n for n, line in rows if _column_count(line) != count), rows[-1][0])
        text = f"the row must have {count} column{'s' * (count > 1)}, as the first has"
        raise fault_in(path, text, bad_line)
    if is_table:
        series = values.reshape(-1, count)
    else:
        series = values[:npts, None] if npts and values.size - npts < count else values[:, None]
    if npts not in (None, len(series)):
        text = f"the header states {npts} values, but the file has {len(series)}"
        raise fault_in(path, f"{text}: correct the header")
    if has_time:
        dt_s, warnings = _step_of_times(series[:, 0], rows, path)
        unit_s = 1.0e-3 if any(map(_MILLISECONDS.search, table.cells(0))) else 1.0
        dt_s, series = dt_s * unit_s, series * np.array([unit_s, *[1.0] * (count - 1)])
        if abs(table.dt_s / dt_s - 1.0) > 0.01:
            text = f"dt is {table.dt_s:g} s in the header, {dt_s:g} s in the times"
            raise fault_in(path, f"{text}: correct one")
        warnings, shift = warnings if stated.dt_s is None else (), 1
    width = series.shape[1]
    cells = [table.cells(column) if width == count else [] for column in range(shift, width)]
    # The text above a single column may be a title.
    names = ([text for text in texts if width > 1 or len(text.split()) < 3] for texts in cells)
    directions = [re.split(r"[(\[]", "".join(texts[:1]))[0].strip() for texts in names]
    others = [bool(re.match(_OTHER_WORD, name.lower())) for name in directions]
    if stated.channel is None and others.count(False) == 1 and directions[others.index(False)]:
        stated = replace(stated, channel=others.index(False) + 1)  # beside its integrals
    channel = _channel(stated, directions, path)
    return Trace(
        path=path,
        format={1 + shift: "two_column", 1: "values"}.get(width, f"{width}_columns"),
        accel_mps2=series[:, channel + shift],
        dt_s=dt_s,
        unit=_unit_in([*cells[channel], *reversed(table.header)], path),
        direction=directions[channel],
        start_s=float(series[0, 0]) if has_time else math.nan,
        warnings=warnings,
    )


def _are_channels(table: _Table, values: Vector, stated: Stated, path: Path) -> bool:
    """Return whether columns without a time column are channels, not parts of one series."""
    count, rows = table.columns, table.rows
    matrix = values[: values.size // count * count].reshape(-1, count)
    if count == 1 or (table.npts and 0 <= values.size - table.npts < count):
        return False
    change = np.abs(np.diff(matrix, axis=0)).mean() if len(matrix) > 1 else math.inf
    ratio = float(change / max(np.abs(np.diff(values)).mean(), 1.0e-300))
    if stated.channel is not None or table.npts == len(matrix):
        if count > 3 and ratio > 1.0 / SERIES_RATIO:
            remedy = "correct the header" if stated.channel is None else "remove the channel number"
            text = f"the {count} columns look like consecutive values of one series, not channels"
            raise fault_in(path, f"{text}: {remedy}")
        if (np.diff(matrix[:, 0]) >= 0.0).all() and matrix[0, 0] < matrix[-1, 0]:
            raise fault_in(path, "column 1 rises: the steps of a time column must be equal")
        return True
    is_table = {_column_count(line) for _, line in rows} == {count}
    if table.npts is None and ((is_table and count <= 3) or ratio < SERIES_RATIO):
        text = f"{count} numbers per line without times may be components or one series:"
        advice = "give channel_1 and channel_2 in index.csv, or write one value per line"
        raise fault_in(path, f"{text} {advice}")
    return False


def _column_count(line: str) -> int:
    return len([cell for cell in _COLUMNS_SEPARATOR.split(line) if cell])


def _step_of_times(
    time_s: Vector, rows: list[tuple[int, str]], path: Path
) -> tuple[float, tuple[str, ...]]:
    """Return the time step of a time column, and a warning if the times are rounded."""
    steps_s = np.diff(time_s)
    mean_s = float(time_s[-1] - time_s[0]) / max(steps_s.size, 1)
    matches = filter(None, (_NUMBER.match(line.lstrip()) for _, line in rows[:100]))
    exponents = [Decimal(_with_exponent(match[0])).as_tuple().exponent for match in matches]
    decimals = min(-min([0, *(e for e in exponents if isinstance(e, int))]), 15)
    quantum_s = 10.0**-decimals
    error_s = np.abs(steps_s - mean_s)
    # Rounding changes a time by up to half a unit of its last digit, a step by a whole one.
    allowed_s = min(1.01 * quantum_s, 0.9 * mean_s) + 1.0e-3 * mean_s
    if mean_s <= 0.0 or (steps_s <= 0.0).any() or error_s.max(initial=0.0) > allowed_s:
        worst = int(np.argmax(np.where(steps_s <= 0.0, np.inf, error_s)))
        problem = f"the time column jumps from {time_s[worst]:g} to {time_s[worst + 1]:g} s"
        advice = f"every step must be {np.median(steps_s):g} s: fill the gap or resample"
        raise fault_in(path, f"{problem}; {advice}", rows[worst + 1][0])
    # the number with the fewest digits within the tolerance
    candidates = (float(f"{mean_s:.{digits}g}") for digits in range(1, 16))
    allowed_s = quantum_s / steps_s.size
    step_s = next((value for value in candidates if abs(value - mean_s) <= allowed_s), mean_s)
    if error_s.max(initial=0.0) > 1.0e-3 * mean_s:
        return step_s, (f"times are rounded to {decimals} decimals: dt = {step_s:g} s is used",)
    return step_s, ()


type _Recognise = Callable[[list[str], Path], bool]
type _Read = Callable[[list[str], Path, Stated], Trace]


def _begins(pattern: str) -> _Recognise:
    return lambda lines, _: bool(re.match(pattern, "\n".join(_head(lines, 17)), re.I | re.S))


#: Name of each format, and the functions that recognise and read it. The first format that
#: recognises a file is used; the last one accepts any text.
MOTION_FORMATS: Final[tuple[tuple[str, _Recognise, _Read], ...]] = (
    ("K-NET and KiK-net", _begins("(?=.*Sampling Freq).*Scale Factor"), _read_knet),
    ("ESM and ITACA ASCII (.ASC)", _begins("EVENT_NAME:"), _read_esm),
    ("COSMOS (.V2c)", _begins(r"[^\n]*\(format v"), _read_cosmos),
    ("GeoNet (.V2A)", _is_geonet, _read_geonet),
    ("CSMIP (.V2)", _is_csmip, _read_csmip),
    ("PEER (.AT2)", _is_peer, _read_peer),
    ("columns of numbers", lambda _lines, _path: True, _read_numbers),
)
