"""Checks of motion files before use: one verdict per file, and an index on request."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from skewbridge.errors import InputError
from skewbridge.files.tables import records_of
from skewbridge.files.text import file_fault, shown_path
from skewbridge.motions.folder import (
    INDEX_NAME,
    IndexEntry,
    files_below,
    index_row,
    is_folder,
    list_motions,
    motion_files,
    motion_of_files,
    pair_files,
    read_index_table,
    write_index,
)
from skewbridge.motions.formats import DtMissingError, Given, Trace
from skewbridge.motions.intensity import peak_g
from skewbridge.motions.read import (
    DIFFERENT_RECORDS,
    PairError,
    motion_name,
    read_trace,
    split_name,
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

    def noted(self, message: str, verdict: FileVerdict | None = None) -> "FileCheck":
        """Return the check with another message, and with a verdict if one is given."""
        return replace(self, verdict=verdict or self.verdict, messages=(*self.messages, message))


def check_paths(
    paths: list[Path], given: Given | None = None, *, strict: bool = False
) -> list[FileCheck]:
    """Check files and folders; files that form pairs by name are also checked as pairs.

    A folder with an `index.csv` is compared with it; `InputError` if that or a path is unreadable.
    If `strict`, warnings are errors.
    """
    doubtful: FileVerdict = "error" if strict else "warn"
    checks: list[FileCheck] = []
    loose: list[Path] = []
    for path in paths:
        if path.is_file():
            loose.append(path)
        elif not is_folder(path):
            raise InputError(f"{shown_path(path)} does not exist", file=str(path))
        elif (path / INDEX_NAME).is_file():
            for entry in list_motions(path):
                files = [_check_file(*each, doubtful)[0] for each in entry.components]
                made = FileCheck(file=str(path / entry.motion_id), verdict="ok")
                checks += _check_entry(entry, files or [made], doubtful)
        else:
            checks += _check_files(_files_of(path), given, doubtful, of_study=True)
    return checks + _check_files(loose, given, doubtful)


def write_folder_index(folder: Path, given: Given | None = None) -> Path:
    """Write the `index.csv` of a folder, or update the digests of an existing one.

    The time step and unit given for files that have none are stored where the index has none.
    `InputError` for a motion that can't be read or an unpaired file.
    """
    index, given = folder / INDEX_NAME, given or Given()
    missing = {"dt_s_if_missing": given.dt_s_if_missing, "unit_if_missing": given.unit_if_missing}
    cells: dict[str, dict[str, object]] = {}
    if index.is_file():
        cells = {row["motion_id"]: row for row in records_of(read_index_table(index))}
    rows: list[dict[str, object]] = []
    for listed in list_motions(folder):
        files = [(path, replace(stated, **missing)) for path, stated in listed.components]
        entry = listed.model_copy(update={"sha256": "", "components": tuple(files)})
        row = index_row(read_entry(entry), [path for path, _ in files], folder)
        units = {read_trace(*component).unit for component in files}
        row |= {"unit": units.pop() if len(units) == 1 else "", "source": ""}
        old = cells.get(entry.motion_id, {}).items()
        kept = {name: text for name, text in old if text and name not in {"npts", "sha256"}}
        rows.append(row | kept)
    write_index(index, rows)
    return index


def _files_of(folder: Path) -> list[Path]:
    files = motion_files(folder)
    if not files:
        raise file_fault(folder, " has no motions")
    # A velocity or displacement next to its acceleration is not a mistake.
    stems = {path.stem.lower() for path in files}
    others = (path for path in files_below(folder) if path.suffix.lower() in {".vt2", ".dt2"})
    return sorted([*files, *(path for path in others if path.stem.lower() not in stems)])


def _check_file(
    path: Path, given: Given | None, doubtful: FileVerdict
) -> tuple[FileCheck, Trace | None]:
    """Return the check of one file, and the component that it has."""
    try:
        trace = read_trace(path, given)
    except InputError as error:
        verdict = "needs_dt" if isinstance(error, DtMissingError) else "error"
        return FileCheck(file=str(path), verdict=verdict, messages=(str(error),)), None
    check = FileCheck(
        file=str(path),
        verdict=doubtful if trace.warnings else "ok",
        format=trace.format,
        dt_s=trace.dt_s,
        npts=int(trace.accel_mps2.size),
        pga_g=peak_g(trace.accel_mps2),
        messages=trace.messages,
    )
    return check, trace


def _check_files(
    paths: list[Path], given: Given | None, doubtful: FileVerdict, *, of_study: bool = False
) -> list[FileCheck]:
    """Check files without an index, those of a motion also together."""
    found = {path: _check_file(path, given, doubtful) for path in paths}
    checks = {path: check for path, (check, _) in found.items()}
    traces = {path: trace for path, (_, trace) in found.items() if trace is not None}
    if len(paths) == len(traces) == 2:  # two files are given as a pair
        pairs, alone = [tuple(sorted(traces))], set[Path]()
    else:
        named, left = pair_files(traces, traces.__getitem__)
        pairs, alone = list(named.values()), {path for files in left.values() for path in files}
    first: Path | None = None
    for path in traces:  # a second component without a first belongs to the first before it
        ending = split_name(path)[1]
        if ending == "h1":
            first = path
        elif ending == "h2" and path in alone and first is not None:
            pairs.append((first, path))
            alone -= {first, path}
    for pair in pairs:
        entry = motion_of_files(motion_name(*pair), pair, given)
        together = _check_entry(entry, [checks[path] for path in pair], doubtful)
        checks |= dict(zip(pair, together, strict=True))
    for path in alone if of_study else ():
        checks[path] = checks[path].noted("no second component found: a study needs pairs")
    return list(checks.values())


def _check_entry(
    entry: IndexEntry, checks: list[FileCheck], doubtful: FileVerdict
) -> list[FileCheck]:
    """Return the checks of the files of a motion with what is wrong with the motion.

    A motion that is generated from its number has one check, which names no file.
    """
    if not all(check.passes for check in checks):
        return checks
    try:
        motion = read_entry(entry)
    except PairError as error:
        return [*checks[:-1], checks[-1].noted(str(error), "pair_error")]
    except InputError as error:
        return [check.noted(str(error), "error") for check in checks]
    if not entry.components:
        pga_g = max(map(peak_g, motion.components))
        made = {"format": "made", "dt_s": motion.dt_s, "npts": motion.npts, "pga_g": pga_g}
        return [replace(check, **made) for check in checks]
    known = {text for check in checks for text in check.messages}
    names = [path.name for path, _ in reversed(entry.components)]
    for text in motion.messages:
        if text.partition(": ")[2] not in known:
            verdict = doubtful if text.startswith(DIFFERENT_RECORDS) else None
            checks = [
                check.noted(f"with {other}: {text}", verdict)
                for check, other in zip(checks, names, strict=True)
            ]
    return checks
