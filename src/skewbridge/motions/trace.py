"""One acceleration component as read from a file: values, time step, unit, header."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.record import Vector
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
    """Properties of a file stated by the caller or the index.

    Attributes:
        dt_s: Time step in s; overrides the header.
        unit: One of ``g``, ``cm/s2``, ``m/s2`` (other common spellings are converted); overrides
            the header.
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
        path: The file.
        format: Name of the file format.
        accel_mps2: Accelerations in m/s2, shape (npts,).
        dt_s: Time step in s.
        unit: Unit of the values in the file.
        sha256: Digest of the bytes of the file.
        event: Earthquake of the header.
        station: Station of the header.
        azimuth_deg: Compass direction, nan if the header has none.
        warnings: Doubts about the values; errors under strict reading.
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
    warnings: tuple[str, ...] = field(default=())
    notes: tuple[str, ...] = field(default=())

    @property
    def messages(self) -> tuple[str, ...]:
        """Warnings and notes."""
        return (*self.warnings, *self.notes)


def unit_of(given: Given, in_file: str | None) -> tuple[str, list[str]]:
    """Return the unit to use and notes about it.

    The first that is known of: the given unit, that of the file, that given for files without
    one, g.
    """
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


def dt_of(given: Given, in_file: float | None, path: Path) -> tuple[float, list[str]]:
    """Return the time step to use and warnings about it.

    Raises:
        DtMissingError: Neither the caller nor the file states it.
    """
    if given.dt_s is not None:
        clash = in_file is not None and abs(in_file / given.dt_s - 1.0) > 1.0e-6
        return given.dt_s, [f"dt {given.dt_s} s as given, the file says {in_file}"] if clash else []
    if in_file is not None:
        return in_file, []
    if given.dt_s_if_missing is not None:
        return given.dt_s_if_missing, []
    raise DtMissingError(
        f"{path.name}: values only, give the time step (--dt-s, or dt_s in index.csv)",
        file=str(path),
    )


def channel_of(given: Given, count: int, path: Path) -> int:
    """Return the channel of a file to read, from 1.

    Raises:
        InputError: The file has several and none is chosen, or fewer than the chosen number.
    """
    if given.channel is None and count > 1:
        raise InputError(
            f"{path.name}: {count} channels, say which (channel 1 to {count})", file=str(path)
        )
    channel = given.channel or 1
    if channel > count:
        raise InputError(f"{path.name}: channel {channel} of {count}", file=str(path))
    return channel


def azimuth_deg(text: str) -> float:
    """Return a compass direction written as degrees or as N, E, S, W; nan if it is neither."""
    letters = {"N": 0.0, "E": 90.0, "S": 180.0, "W": 270.0, "NS": 0.0, "EW": 90.0}
    cleaned = text.strip().upper().replace("-", "")
    if cleaned in letters:
        return letters[cleaned]
    return float(cleaned) if cleaned.isdigit() and int(cleaned) <= 360 else float("nan")


def fortran_float(text: str) -> float:
    """Return one number; a D may mark its exponent."""
    return float(text.upper().replace("D", "E"))


def parse_numbers(lines: Sequence[str], path: Path, first_line: int = 1) -> Vector:
    """Return every number of some lines, in order.

    Numbers are separated by blanks, commas or semicolons; Fortran ``D`` exponents and numbers that
    touch at a sign (``.12E-01-.76E-02``) are also read.

    Raises:
        InputError: Something that is not a finite number; names file and line.
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
    for line, text in enumerate(lines, start=first_line):
        for token in text.translate(_SEPARATORS).split():
            problem, values = "is not a number", []
            if len(token) <= MAX_TOKEN and _RUN.fullmatch(token):
                problem, values = "is too large", [fortran_float(n) for n in _NUMBER.findall(token)]
            if not values or max(map(abs, values)) > MAX_MAGNITUDE:
                message = f"{path.name}, line {line}: {token[:40]!r} {problem}"
                raise InputError(message, file=str(path), line=line)
            found += values
    return np.array(found, dtype=np.float64)
