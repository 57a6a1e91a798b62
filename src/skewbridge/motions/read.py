"""Read motions from files of any supported format, check values, and join two components."""

import hashlib
import math
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

import numpy as np
from pydantic import BaseModel

from skewbridge.errors import InputError
from skewbridge.files.text import checked, read_bytes, read_yaml
from skewbridge.motions import formats, p695
from skewbridge.motions.formats import DtMissingError, Stated, Trace, fault_in, trace_of
from skewbridge.motions.intensity import orbit_rotd50, peak_g
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.units import G_MPS2

MAX_FILE_BYTES: Final = 64_000_000
MIN_SAMPLES: Final = 10
# ASSUME no horizontal record exceeds 4 g (the largest published ones are near 3 g): more is a
# unit error; a motion below 0.002 g does not matter for a bridge.
PGA_LIMITS_G: Final = (0.002, 4.0)
_SAY_UNIT: Final = (
    "State it in the column unit of index.csv, which "
    "`skewbridge motions check DIR --write --unit UNIT` writes for files without a unit"
)
#: Start of warnings about a pair.
_TWO_RECORDS: Final = "two different records?"
#: A time step (s), or a sampling rate (Hz, or a time step), in a header.
_STEP: Final = re.compile(
    r"(?i)(?:\bdt\b|\btime step|\binterval)[^\d\n]{0,12}?(0?\.\d+)"
    r"|\bsampl\w* (?:rate|freq\w*)[^\d\n]{0,12}?(\d*\.?\d+)"
)
_STEP_TOLERANCE: Final = 0.01  # a rounded step or rate
_FOREIGN: Final = (
    (b"PK\x03\x04", "a zip archive or spreadsheet: unpack it, or save it as CSV"),
    (b"\x1f\x8b", "a gzip archive: unpack it first"),
    (b"%PDF", "a PDF"),
    (b"\xff\xfe", "UTF-16 text: save it as UTF-8"),
    (b"\xfe\xff", "UTF-16 text: save it as UTF-8"),
    (b"version https://git-lfs", "a git-LFS pointer: fetch the real file"),
    (b"2 CORRECTED ACCEL", "an SMC file, which is not read: get the COSMOS file (.V2c)"),
    (b"1 UNCORRECTED ACCEL", "an uncorrected accelerogram: get the corrected one"),
    (b"UNCORRECTED ACCEL", "an uncorrected accelerogram (V1): get the corrected one (V2)"),
    (b"<", "a web page (a log-in page saved as a record?)"),
)

# The waveforms of WAHO, a record of the paper, can't be redistributed. A file with its name must
# have the published peak; without such a file a surrogate of the same earthquake is used.
# source: PEER NGA-West2 flatfile, RSN 811 (Loma Prieta 1989, WAHO), RotD50 PGA
WAHO_PGA_ROTD50_G: Final = 0.53730
WAHO_TOLERANCE: Final = 0.02
_WAHO = re.compile(r"RSN0*811(?!\d)|(?<![A-Z])WAHO?(?![A-Z])", re.IGNORECASE)
# source: Loma Prieta 1989, Capitola (FEMA P-695 far-field 12101 = NGA RSN 752); of 47 public pairs
# the one nearest to the published WAHO RotD50 spectrum (sd of ln ratio 0.41, a loose match).
SURROGATE_FILES: Final = ("121011.txt", "121012.txt")
SURROGATE_FACTOR: Final = 0.93
SURROGATE_ID: Final = "surrogate_for_WAHO_capitola_x0.93"

# Vertical components (UP, DWN, V) are not used: a motion has two horizontal ones.
_VERTICAL = re.compile(r"[-_.](UP|UD|DWN|DN|V|VER|VERT|Z|H?3)$|[a-z0-9](DWN|-UP)$", re.IGNORECASE)
_NIED = re.compile(r"\.(?P<end>EW|NS|UD)(?P<sensor>[12]?)", re.IGNORECASE)
# Endings that distinguish the components of one motion, the most specific first.
_ENDINGS: Final = (
    # azimuth: TAR090, E06140
    re.compile(
        r"(?:(?<=[A-Za-z_.\-])|(?<=[A-Za-z]\d)|(?<=[A-Za-z]\d{2})|(?<=[A-Za-z]\d{3}))"
        r"(?P<end>[0-3]\d{2})$"
    ),
    re.compile(r"(?<=.)(?P<end>[NS]\d{2}[EW])$", re.IGNORECASE),  # bearing: TAFT_N21E, TAFT_S69E
    re.compile(r"[-_.](?P<end>H?[12NEXY]|EW|NS|FN|FP|L|T|LONG|TRAN)$", re.IGNORECASE),
    re.compile(r"(?<=\d)(?P<end>[12])$"),  # FEMA P-695: 120111, 120112
)


class PairError(InputError):
    """The time steps or first times of two components differ."""


class FalseClaimError(InputError):
    """A motion has the name of the WAHO record of the paper, but a different PGA."""


def split_name(path: Path) -> tuple[str, str]:
    """Return the motion name and the component ending ('' without one) of a file name."""
    if match := _NIED.fullmatch(path.suffix):  # K-NET and KiK-net: component in the suffix
        sensor = {"1": "_borehole", "2": "_surface"}.get(match["sensor"], "")
        return path.stem + sensor, match["end"].lower()
    stem = path.stem
    for pattern in _ENDINGS:
        if match := pattern.search(stem):
            return stem[: match.start("end")].rstrip("-_. "), match["end"].lower()
    return stem, ""


def is_vertical(path: Path) -> bool:
    """Return whether a file name denotes a vertical component."""
    return path.suffix.lower().startswith(".ud") or bool(_VERTICAL.search(path.stem))


def motion_name(first: Path, second: Path) -> str:
    """Return the motion name of both files; if it differs, the name of the first file."""
    name, _ = split_name(first)
    return name if split_name(second)[0] == name else first.stem


def read_trace(path: Path, stated: Stated | None = None) -> Trace:
    """Read one component; `DtMissingError` if it has no time step, `InputError` if unusable."""
    lines = _text_of(read_bytes(path, MAX_FILE_BYTES), path).splitlines()
    header = "\n".join(lines[: formats.MAX_HEADER_LINES])
    step_or_rate = _step_or_rate(header)
    try:
        trace = trace_of(lines, path, stated or Stated())
    except DtMissingError:
        if step_or_rate is None:
            raise
        number, words = step_or_rate
        step_s = number if number < 1.0 else 1.0 / number
        trace = trace_of(lines, path, replace(stated or Stated(), dt_s_if_missing=step_s))
        trace = replace(trace, notes=(f"dt = {step_s:g} s by the header: {words}", *trace.notes))
    event, station = (
        "".join(letter if letter.isprintable() else " " for letter in text).strip()[:100]
        for text in (trace.event, trace.station)
    )
    warnings, notes = [*trace.warnings, *doubts(trace)], trace.notes
    given_s = stated and stated.dt_s is None and stated.dt_s_if_missing
    if given_s and given_s != trace.dt_s:
        notes = (f"dt = {trace.dt_s:g} s of the file is used, not {given_s:g} s", *notes)
    # a known format has its step in the header
    if step_or_rate is not None and re.search("column|values", trace.format):
        number, words = step_or_rate
        if min(abs(trace.dt_s * number - 1.0), abs(number / trace.dt_s - 1.0)) >= _STEP_TOLERANCE:
            warnings.append(f"dt = {trace.dt_s:g} s is used, but the header states {words}")
    return replace(trace, warnings=tuple(warnings), notes=notes, event=event, station=station)


def _step_or_rate(header: str) -> tuple[float, str] | None:
    """Return the time step (s) or sampling rate (Hz) that a header states, and its words."""
    match = _STEP.search(header)
    return (float(match[1] or match[2]), match[0]) if match else None


def _text_of(content: bytes, path: Path) -> str:
    if not content.strip():
        raise fault_in(path, "the file is empty")
    for start, problem in _FOREIGN:
        if content.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(start):
            raise fault_in(path, problem)
    if b"\0" in content:
        raise fault_in(path, "the file is binary, but text is needed")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def doubts(trace: Trace) -> list[str]:
    """Return warnings about the values of a component; `InputError` if it is unusable."""
    npts, pga_g, dt_s = trace.accel_mps2.size, peak_g(trace.accel_mps2), trace.dt_s
    (low_s, high_s), (smallest_g, largest_g) = formats.DT_LIMITS_S, PGA_LIMITS_G
    odd_step = f"dt = {dt_s:g} s is outside {low_s} to {high_s} s: state it in s"
    too_strong = f"PGA = {pga_g:.4g} g with values in {trace.unit} is above {largest_g} g"
    for problem, applies in {
        "the file has no values": npts == 0,
        odd_step: not low_s <= dt_s <= high_s,
        f"the file has {npts} values but needs at least {MIN_SAMPLES}": npts < MIN_SAMPLES,
        "all values are zero": pga_g == 0.0,
        f"{too_strong}: wrong unit? {_SAY_UNIT}": pga_g > largest_g,
    }.items():
        if applies:
            raise fault_in(trace.path, problem)
    offset = abs(float(trace.accel_mps2.mean())) / float(np.abs(trace.accel_mps2).max())
    second_g = np.sort(np.abs(trace.accel_mps2))[-2] / G_MPS2
    velocity_mps = np.abs(np.cumsum(trace.accel_mps2)) * dt_s
    share = float(velocity_mps[-1] / max(velocity_mps.max(), np.finfo(float).tiny))
    findings = {
        f"PGA = {pga_g:.3g} g is below {smallest_g} g: wrong unit? {_SAY_UNIT}": pga_g < smallest_g,
        # ASSUME the largest value is at most twice the next one (public records: up to 1.35 times)
        f"one value is {pga_g:.3g} g, the next {second_g:.3g} g: spike?": pga_g > 2.0 * second_g,
        f"the mean is {offset:.1%} of the PGA: baseline not corrected?": offset > 0.02,
        f"the final velocity is {share:.0%} of the PGV: baseline not corrected?": share > 0.25,
    }
    return [warning for warning, applies in findings.items() if applies]


def is_doubt(message: str) -> bool:
    """Return whether a message about a motion doubts its files; it then asks a question."""
    return "?" in message


def read_motion(
    first: Path, second: Path, stated: Stated | None = None, *, motion_id: str | None = None
) -> GroundMotion:
    """Read the files of component 1 (bridge x at incidence 0) and 2 (bridge y) as one motion.

    Without a `motion_id`, the motion is named by `motion_name`. Instead of files, a suite of
    `p695.SUITES` and a record number name a recorded pair.
    """
    if str(first) in p695.SUITES and str(second).isdecimal():
        return p695.read_record(str(first), int(str(second)))
    trace_1, trace_2 = (read_trace(path, stated) for path in (first, second))
    return join_traces(trace_1, trace_2, motion_id=motion_id or motion_name(first, second))


def _unlike_starts(*traces: Trace) -> str:
    """Return the problem of records with time columns that do not begin together; else ''."""
    timed = [trace for trace in traces if math.isfinite(trace.start_s)]
    for other in timed:
        if abs(timed[0].start_s - other.start_s) > 0.5 * other.dt_s:
            starts = (f"{trace.start_s:g} s in {trace.path.name}" for trace in (timed[0], other))
            return f"times begin at {' and '.join(starts)}: cut both to the same first time"
    return ""


def join_traces(first: Trace, second: Trace, *, motion_id: str) -> GroundMotion:
    """Return the motion of two components; zeros are added at the end of the shorter one.

    Raises `PairError` for different time steps or first times, `InputError` for a vertical
    component, and the error of `refuse_false_waho`.
    """
    for trace in (first, second):
        if trace.is_vertical:
            text = f"the header states a vertical component ({trace.direction!r})"
            raise fault_in(trace.path, f"{text}, but a motion needs two horizontal ones")
    pair, problem = (first, second), _unlike_starts(first, second)
    if abs(first.dt_s / second.dt_s - 1.0) > 1.0e-6:
        steps = " and ".join(f"{trace.dt_s} s in {trace.path.name}" for trace in pair)
        problem = f"dt is {steps}; the steps must be equal"
    if problem:
        raise PairError(f"motion {motion_id}: {problem}", motion_id=motion_id)
    sizes = [trace.accel_mps2.size for trace in pair]
    messages = [f"{trace.path.name}: {text}" for trace in pair for text in trace.messages]
    npts = max(sizes)
    if sizes[0] != sizes[1]:
        messages.append(f"lengths {sizes[0]} and {sizes[1]}: zeros added at the end of the shorter")
    for name in ("event", "station"):
        value_1, value_2 = (getattr(trace, name) for trace in pair)
        if value_1 and value_2 and value_1.casefold() != value_2.casefold():
            messages.append(f"{_TWO_RECORDS} Their {name}s differ: {value_1} and {value_2}")
    # ASSUME components of one record have lengths within 20 % of each other
    if npts > 1.2 * min(sizes):
        messages.append(f"{_TWO_RECORDS} Their lengths differ: {min(sizes)} and {npts} points")
    azimuths_deg = [trace.azimuth_deg for trace in pair]
    endings = {split_name(trace.path)[1] for trace in pair}
    if math.isnan(sum(azimuths_deg)) and len(endings) == 2 and min(map(len, endings)) >= 3:
        # of the file names: 090 and 360, n21e and s69e
        azimuths_deg = [replace(first, direction=ending).azimuth_deg for ending in sorted(endings)]
    # ASSUME components are within 10 degrees of a right angle (Lucerne 1992: 85 degrees)
    if abs((azimuths_deg[0] - azimuths_deg[1]) % 180.0 - 90.0) > 10.0:
        text = f"azimuths {azimuths_deg[0]:g} and {azimuths_deg[1]:g} are not at right angles"
        is_copy = azimuths_deg[0] == azimuths_deg[1]  # perhaps of the header only
        messages.append(text if is_copy else f"{_TWO_RECORDS} Their {text}")
    names = [trace.path.name for trace in pair if is_vertical(trace.path)]
    messages += [f"vertical component? By its name, {name} is one" for name in names]
    if np.array_equal(np.abs(first.accel_mps2), np.abs(second.accel_mps2)):
        messages.append("one component twice? Both components have the same values, up to the sign")
    # ASSUME both components start together; the shorter one was cut at its end
    padded = [np.pad(trace.accel_mps2, (0, npts - trace.accel_mps2.size)) for trace in pair]
    motion = GroundMotion(
        motion_id=motion_id,
        dt_s=first.dt_s,
        accel_1_mps2=padded[0],
        accel_2_mps2=padded[1],
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


class SupportRecord(BaseModel, extra="forbid", frozen=True):
    """One record of a file of support motions, along x or y of the bridge."""

    support: str  #: `left`, `right`, or `bent 1` and so on, from left to right
    direction: Literal["x", "y"]
    record: Path  #: file, relative to the file that names it
    factor: float = 1.0  #: -1 for a record that is positive against the axis


def read_support_motions(path: Path) -> dict[str, GroundMotion]:
    """Return the motion of each support from a YAML list of `SupportRecord`.

    Raises `InputError` for a support without one of its directions, or with two records of one, and
    for records of different first times. A shorter record has a message.
    """
    records = checked(list[SupportRecord], read_yaml(path), path)
    if not records:
        raise InputError(f"{path.name}: list at least one record")
    traces: dict[tuple[str, str], Trace] = {}
    for record in records:
        component = record.support, record.direction
        if component in traces:
            raise InputError(f"{path.name}: {record.support} has two records along {component[1]}")
        trace = read_trace(path.parent / record.record)
        traces[component] = replace(trace, accel_mps2=record.factor * trace.accel_mps2)
    motions: dict[str, GroundMotion] = {}
    for support in dict.fromkeys(record.support for record in records):
        along_x, along_y = (traces.get((support, direction)) for direction in "xy")
        if along_x is None or along_y is None:
            raise InputError(f"{path.name}: {support} needs a record along x and one along y")
        motions[support] = join_traces(along_x, along_y, motion_id=f"{path.stem} {support}")
    if problem := _unlike_starts(*traces.values()):
        raise InputError(f"{path.name}: {problem}")
    longest_s = max(motion.duration_s for motion in motions.values())
    for support, motion in motions.items():
        if longest_s - motion.duration_s > motion.dt_s:
            text = f"{support}: records end at {motion.duration_s:g} s, others at {longest_s:g} s: "
            text += "cut off? It goes on at its last velocity"
            motions[support] = replace(motion, messages=(*motion.messages, text))
    return motions


def earlier_record(
    names: dict[tuple[object, ...], str], name: str, samples: Iterable[Vector], *details: object
) -> str:
    """Return the name in ``names`` of an equal record; add the record and return '' if none is."""
    key = (*(hash(values.tobytes()) for values in samples), *details)
    first = names.setdefault(key, name)
    return "" if first == name else first


def refuse_false_waho(motion: GroundMotion) -> None:
    """Raise `FalseClaimError` if the RotD50 PGA of a motion named WAHO is off by over 2 %."""
    names = (motion.motion_id, motion.station, *motion.files)
    if SURROGATE_ID in names or not any(_WAHO.search(name) for name in names):
        return
    pga_g = orbit_rotd50(*motion.components) / G_MPS2
    if abs(pga_g / WAHO_PGA_ROTD50_G - 1.0) > WAHO_TOLERANCE:
        claim = f"motion {motion.motion_id} claims to be the WAHO record, but its RotD50 PGA is "
        published = f"{WAHO_PGA_ROTD50_G:.4f} g (tolerance {WAHO_TOLERANCE:.0%})"
        text = f"{claim}{pga_g:.4f} g; the published one is {published}. Give it another name."
        raise FalseClaimError(text, motion_id=motion.motion_id)


def files_digest(*paths: Path) -> str:
    """Return the SHA-256 of the bytes of files, joined in the given order (`cat A B`)."""
    return hashlib.sha256(b"".join(read_bytes(path, MAX_FILE_BYTES) for path in paths)).hexdigest()
