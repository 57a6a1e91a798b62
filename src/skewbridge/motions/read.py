"""Read any supported motion file: what the format is, is found out from its text."""

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Final, Protocol

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.examine import doubts, refuse_impossible
from skewbridge.motions.formats import columns, csmip_v2, knet, peer_at2, values
from skewbridge.motions.formats.trace import Given, Trace
from skewbridge.motions.pairing import motion_name
from skewbridge.motions.paper_records import refuse_false_waho
from skewbridge.motions.record import GroundMotion
from skewbridge.reading import read_bytes

MAX_TITLE: Final = 100  # characters of an event or a station
MAX_FILE_BYTES: Final = 64_000_000


class PairError(InputError):
    """Two components, each good in itself, that can't be of one motion."""


class Format(Protocol):
    """What a module of `formats` offers; a new format is a new module and a place in `FORMATS`."""

    def recognises(self, lines: list[str], path: Path) -> bool:
        """Say whether the text is of this format."""
        ...

    def read(self, lines: list[str], path: Path, given: Given) -> Trace:
        """Read the text."""
        ...


# The first that recognises a file reads it; the last one takes any.
FORMATS: Final[tuple[Format, ...]] = (knet, csmip_v2, peer_at2, columns, values)

_FOREIGN: Final = (
    (b"PK\x03\x04", "a zip archive: unpack it first"),
    (b"\x1f\x8b", "a gzip archive: unpack it first"),
    (b"%PDF", "a PDF"),
    (b"version https://git-lfs", "a git-LFS pointer: fetch the real file"),
    (b"<", "a web page (a log-in page saved as a record?)"),
)


def read_trace(path: Path, given: Given | None = None, *, strict: bool = False) -> Trace:
    """Read one component; strictly, what would only be a warning is refused.

    Raises:
        InputError: The file can't be read as an acceleration; the message names it.
        DtMissingError: The file holds values only and no time step is given.
    """
    content = read_bytes(path, MAX_FILE_BYTES)
    lines = _text_of(content, path).splitlines()
    module = next(module for module in FORMATS if module.recognises(lines, path))
    trace = module.read(lines, path, given or Given())
    if trace.accel_mps2.size == 0:
        raise InputError(f"{path.name}: no values", file=str(path))
    refuse_impossible(trace)
    warnings = (*trace.warnings, *doubts(trace))
    if strict and warnings:
        raise InputError(f"{path.name}: {'; '.join(warnings)}", file=str(path))
    return replace(
        trace,
        sha256=hashlib.sha256(content).hexdigest(),
        warnings=warnings,
        event=_plain(trace.event),
        station=_plain(trace.station),
    )


def read_motion(
    first: Path,
    second: Path,
    given: Given | None = None,
    *,
    motion_id: str | None = None,
    strict: bool = False,
) -> GroundMotion:
    """Read the files of component 1 (bridge x at incidence 0) and 2 (bridge y) as one motion.

    Without a `motion_id` it is named by what the file names share.

    Raises:
        InputError: A file can't be read, or the time steps differ.
    """
    one, two = (read_trace(path, given, strict=strict) for path in (first, second))
    return join_traces(one, two, motion_id=motion_id or motion_name(first, second))


def join_traces(first: Trace, second: Trace, *, motion_id: str) -> GroundMotion:
    """Return the motion of two components; the shorter one gets zeros at its end.

    Raises:
        PairError: The time steps differ.
        FalseClaimError: The motion claims to be the WAHO record and is not.
    """
    if abs(first.dt_s / second.dt_s - 1.0) > 1.0e-6:
        raise PairError(
            f"motion {motion_id}: dt of {first.path.name} is {first.dt_s} s, "
            f"of {second.path.name} {second.dt_s} s; they must be equal",
            motion_id=motion_id,
        )
    sizes = (first.accel_mps2.size, second.accel_mps2.size)
    messages = [
        f"{trace.path.name}: {text}" for trace in (first, second) for text in trace.messages
    ]
    if sizes[0] != sizes[1]:
        messages.append(f"lengths {sizes[0]} and {sizes[1]}: zeros added at the end of the shorter")
    if doubt := different_records(first, second):
        messages.append(doubt)
    npts = max(sizes)
    motion = GroundMotion(
        motion_id=motion_id,
        dt_s=first.dt_s,
        # ASSUME both components start together; the shorter one was cut at its end
        accel_1_mps2=np.pad(first.accel_mps2, (0, npts - sizes[0])),
        accel_2_mps2=np.pad(second.accel_mps2, (0, npts - sizes[1])),
        event=first.event,
        station=first.station,
        azimuth_1_deg=first.azimuth_deg,
        azimuth_2_deg=second.azimuth_deg,
        sha256=files_digest(first.path, second.path),
        files=(first.path.name, second.path.name),
        messages=tuple(messages),
    )
    refuse_false_waho(motion)
    return motion


# ASSUME components of one record have lengths within 20 % of each other
_LENGTH_RATIO: Final = 1.2


def different_records(first: Trace, second: Trace) -> str:
    """Return a warning if two components seem to be of different records, else an empty text."""
    for name, one, other in (
        ("events", first.event, second.event),
        ("stations", first.station, second.station),
    ):
        if one and other and one.casefold() != other.casefold():
            return f"two different records? Their {name} differ: {one} and {other}"
    sizes = sorted(trace.accel_mps2.size for trace in (first, second))
    if sizes[1] > _LENGTH_RATIO * sizes[0]:
        return f"two different records? Their lengths differ: {sizes[0]} and {sizes[1]} points"
    return ""


def files_digest(*paths: Path) -> str:
    """Return the SHA-256 of the bytes of some files, one after the other (as of `cat A B`)."""
    return hashlib.sha256(b"".join(read_bytes(path, MAX_FILE_BYTES) for path in paths)).hexdigest()


def _plain(text: str) -> str:
    """Return a text of a header as tables and figures may show it."""
    return "".join(sign if sign.isprintable() else " " for sign in text).strip()[:MAX_TITLE]


def _text_of(content: bytes, path: Path) -> str:
    if not content.strip():
        raise InputError(f"{path.name}: empty file", file=str(path))
    for start, what in _FOREIGN:
        if content.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(start):
            raise InputError(f"{path.name}: {what}", file=str(path))
    if b"\0" in content:
        raise InputError(f"{path.name}: a binary file", file=str(path))
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")
