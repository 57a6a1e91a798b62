"""Checks of motion files before use: one verdict per file, and an index on request."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from skewbridge.errors import InputError
from skewbridge.files.tables import records_of
from skewbridge.files.text import shown_path
from skewbridge.motions.folder import (
    INDEX_NAME,
    IndexEntry,
    files_below,
    index_row,
    is_folder,
    list_motions,
    motion_files,
    pairs_among,
    read_index_table,
    write_index,
)
from skewbridge.motions.formats import DtMissingError, Given, Trace
from skewbridge.motions.intensity import peak_g
from skewbridge.motions.read import (
    PairError,
    different_records,
    is_vertical,
    join_traces,
    motion_name,
    read_trace,
)
from skewbridge.motions.suite import read_entry

type FileVerdict = Literal["ok", "warn", "error", "needs_dt", "pair_error"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FileCheck:
    """Result of the check of one file; what the file does not give is None.

    Attributes:
        verdict: ``ok``, ``warn`` (usable, but doubtful), ``error`` (unusable), ``needs_dt``
            (values only: the time step must be given) or ``pair_error`` (does not match its other
            component).
    """

    file: str
    verdict: FileVerdict
    format: str | None = None
    dt_s: float | None = None
    npts: int | None = None
    pga_g: float | None = None
    messages: tuple[str, ...] = ()

    @property
    def passes(self) -> bool:
        """Whether the file can be used."""
        return self.verdict in ("ok", "warn")


def check_paths(
    paths: list[Path], given: Given | None = None, *, strict: bool = False
) -> list[FileCheck]:
    """Check files and folders; files that form pairs by name are also checked as pairs.

    A folder with an `index.csv` is compared with it; `InputError` if that or a path is unreadable.
    If `strict`, warnings are errors.
    """
    checks: list[FileCheck] = []
    loose: list[Path] = []
    for path in paths:
        if is_folder(path):
            if (path / INDEX_NAME).is_file():
                checks.extend(_check_index(path, strict=strict))
            else:
                checks.extend(_check_files(_files_of(path), given, strict=strict, of_study=True))
        elif path.is_file():
            loose.append(path)
        else:
            raise InputError(f"{shown_path(path)} does not exist", file=str(path))
    return checks + _check_files(loose, given, strict=strict)


def write_folder_index(folder: Path, given: Given | None = None) -> Path:
    """Write the `index.csv` of a folder, or update the digests of an existing one.

    The time step and unit given for files that have none are stored where the index has none.
    `InputError` for a motion that can't be read or an unpaired file.
    """
    given = given or Given()
    missing = {"dt_s_if_missing": given.dt_s_if_missing, "unit_if_missing": given.unit_if_missing}
    index = folder / INDEX_NAME
    cells: dict[str, dict[str, object]] = {}
    if index.is_file():
        cells = {row["motion_id"]: row for row in records_of(read_index_table(index))}
    rows: list[dict[str, object]] = []
    for listed in list_motions(folder):
        entry = replace(
            listed,
            sha256="",
            components=tuple(
                (path, replace(stated, **missing)) for path, stated in listed.components
            ),
        )
        row = index_row(read_entry(entry), [path for path, _ in entry.components], folder)
        old = cells.get(entry.motion_id, {}).items()
        kept = {name: text for name, text in old if text and name not in {"npts", "sha256"}}
        units = {read_trace(*component).unit for component in entry.components}
        unit = units.pop() if len(units) == 1 else ""
        rows.append({**row, "unit": unit, "source": "", **kept})
    write_index(index, rows)
    return index


def _files_of(folder: Path) -> list[Path]:
    files = motion_files(folder)
    if not files:
        raise InputError(f"no motions in {shown_path(folder)}", folder=str(folder))
    # A velocity or displacement next to its acceleration is not a mistake.
    stems = {path.stem.lower() for path in files}
    stray = [
        path
        for path in files_below(folder)
        if path.suffix.lower() in {".vt2", ".dt2"} and path.stem.lower() not in stems
    ]
    return sorted([*files, *stray])


def _check_files(
    paths: list[Path], given: Given | None, *, strict: bool, of_study: bool = False
) -> list[FileCheck]:
    doubtful: FileVerdict = "error" if strict else "warn"
    checks: dict[Path, FileCheck] = {}
    traces: dict[Path, Trace] = {}
    for path in paths:
        try:
            trace = read_trace(path, given)
        except InputError as error:
            verdict = "needs_dt" if isinstance(error, DtMissingError) else "error"
            checks[path] = FileCheck(file=str(path), verdict=verdict, messages=(str(error),))
        else:
            traces[path] = trace
            checks[path] = FileCheck(
                file=str(path),
                verdict=doubtful if trace.warnings else "ok",
                format=trace.format,
                dt_s=trace.dt_s,
                npts=int(trace.accel_mps2.size),
                pga_g=peak_g(trace.accel_mps2),
                messages=trace.messages,
            )
    pairs = pairs_among(list(traces.values()), given_as_pair=len(paths) == 2)
    for first, second in pairs:
        _check_pair(first, second, checks)
    if of_study:
        paired = {trace.path for pair in pairs for trace in pair}
        for path in traces:
            if path not in paired and not is_vertical(path):
                checks[path] = _with(checks[path], "no second component found: a study needs pairs")
    return list(checks.values())


def _check_pair(first: Trace, second: Trace, checks: dict[Path, FileCheck]) -> None:
    """Add errors and messages of joining two components to their checks."""
    try:
        motion = join_traces(first, second, motion_id=motion_name(first.path, second.path))
    except PairError as error:
        checks[second.path] = _with(checks[second.path], str(error), "pair_error")
    except InputError as error:
        for trace in (first, second):
            checks[trace.path] = _with(checks[trace.path], str(error), "error")
    else:
        doubt = different_records(first, second)
        for message in motion.messages[len(first.messages) + len(second.messages) :]:
            for one, other in ((first, second), (second, first)):
                verdict = "warn" if message == doubt and checks[one.path].passes else None
                text = f"with {other.path.name}: {message}"
                checks[one.path] = _with(checks[one.path], text, verdict)


def _with(check: FileCheck, message: str, verdict: FileVerdict | None = None) -> FileCheck:
    return replace(check, verdict=verdict or check.verdict, messages=(*check.messages, message))


def _check_index(folder: Path, *, strict: bool) -> list[FileCheck]:
    checks: list[FileCheck] = []
    for entry in list_motions(folder):
        if not entry.components:
            checks.append(_check_made(entry, folder))
            continue
        pair = [
            check
            for path, given in entry.components
            for check in _check_files([path], given, strict=strict)
        ]
        if all(check.passes for check in pair):
            try:
                motion = read_entry(entry)
            except InputError as error:
                verdict = "pair_error" if isinstance(error, PairError) else "error"
                pair = [_with(check, str(error), verdict) for check in pair]
            else:
                old = {text for check in pair for text in check.messages}
                new = [m for m in motion.messages if m.partition(": ")[2] not in old]
                pair = [replace(check, messages=(*check.messages, *new)) for check in pair]
        checks.extend(pair)
    return checks


def _check_made(entry: IndexEntry, folder: Path) -> FileCheck:
    """Generate a motion that the index has a number of, and compare its digest."""
    name = str(folder / entry.motion_id)
    try:
        motion = read_entry(entry)
    except InputError as error:
        return FileCheck(file=name, verdict="error", messages=(str(error),))
    return FileCheck(
        file=name,
        verdict="ok",
        format="made",
        dt_s=motion.dt_s,
        npts=motion.npts,
        pga_g=max(map(peak_g, motion.components)),
    )
