"""Check motion files before use, and write their index."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from skewbridge.errors import InputError
from skewbridge.files.tables import records_of
from skewbridge.files.text import file_fault, shown_path
from skewbridge.motions import folder, read
from skewbridge.motions.formats import NO_UNIT, DtMissingError, Stated
from skewbridge.motions.intensity import peak_g
from skewbridge.motions.suite import read_entries, read_entry

#: ``warn``: usable, but doubtful; ``error``: unusable; ``needs_dt``: the file has no time step, so
#: it must be given; ``pair_error``: the file does not match the second component of its motion;
#: ``not_read``: another file of the folder; ``left_out``: the same for a note, velocity or
#: displacement.
type FileVerdict = Literal["ok", "warn", "error", "needs_dt", "pair_error", "not_read", "left_out"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FileCheck:
    """Result of the check of one file; values that could not be read are None."""

    file: str
    verdict: FileVerdict
    format: str | None = None
    dt_s: float | None = None
    npts: int | None = None
    pga_g: float | None = None
    messages: tuple[str, ...] = ()

    @property
    def passes(self) -> bool:
        """Whether the file can be used, or is left out on purpose."""
        return self.verdict in ("ok", "warn", "not_read", "left_out")

    def noted(self, message: str, verdict: FileVerdict | None = None) -> "FileCheck":
        """Return the check with one more message, and with a new verdict if one is given."""
        return replace(self, verdict=verdict or self.verdict, messages=(*self.messages, message))


def check_paths(
    paths: list[Path], stated: Stated | None = None, *, strict: bool = False
) -> list[FileCheck]:
    """Check files and folders; the two components of a motion are also checked together.

    A folder with an `index.csv`, or this file, is checked against it. Other files of a folder are
    listed as not read. If `strict` is true, warnings are errors.
    Raises `InputError` for a missing path, an unreadable index or a folder without motions.
    """
    checker = _Checker("error" if strict else "warn")
    checks: list[FileCheck] = []
    single_files: list[Path] = []
    for given in paths:
        path = given.parent if given.name == folder.INDEX_NAME and given.is_file() else given
        if path.is_file():
            single_files.append(path)
        elif not folder.is_folder(path):
            raise InputError(f"{shown_path(path)} does not exist", file=str(path))
        elif (path / folder.INDEX_NAME).is_file():
            entries = folder.list_motions(path)
            for entry in entries:
                checks += checker.of_motion(entry, path)
            listed_files = [file for entry in entries for file, _ in entry.components]
            checks += _unread(path, listed_files, f"not listed in {folder.INDEX_NAME}")
        elif files := folder.motion_files(path):
            # Velocity or displacement files next to the acceleration are not an error.
            stems, all_files = {file.stem.lower() for file in files}, folder.files_below(path)
            integrals = (file for file in all_files if file.suffix.lower() in {".vt2", ".dt2"})
            files += [file for file in integrals if file.stem.lower() not in stems]
            checks += checker.of_files(sorted(files), stated, of_study=True)
            checks += _unread(path, files, "no reader recognises its suffix or its text")
        else:
            raise file_fault(path, " has no file of a motion in a known format")
    return checks + checker.of_files(single_files, stated)


def write_folder_index(root: Path, stated: Stated | None = None) -> Path:
    """Write the `index.csv` of a folder, or update the digests of an existing one.

    The given time step and unit are used for files that do not state them. Other values of an
    existing index are kept. Raises `InputError` for an unreadable motion or an unpaired file.
    """
    index, stated = root / folder.INDEX_NAME, stated or Stated()
    assumed = {"dt_s_if_missing": stated.dt_s_if_missing, "unit_if_missing": stated.unit_if_missing}
    cells: dict[str, dict[str, object]] = {}
    if index.is_file():
        cells = {row["motion_id"]: row for row in records_of(folder.read_index_table(index))}
    rows, entries = list[dict[str, object]](), list[folder.IndexEntry]()
    for entry in folder.list_motions(root):
        files = tuple((path, replace(stated, **assumed)) for path, stated in entry.components)
        entries.append(entry.model_copy(update={"sha256": "", "components": files}))
    for entry, motion in zip(entries, read_entries(entries), strict=True):
        row = folder.index_row(motion, [path for path, _ in entry.components], root)
        traces = [read.read_trace(*component) for component in entry.components]
        units = {trace.unit for trace in traces}
        if len(units) > 1 and any("given unit" in note for t in traces for note in t.notes):
            text = f"files in {' and '.join(sorted(units))}, but an index row has one unit"
            text = f"{text}: write it into the file without one"
            raise InputError(f"motion {entry.motion_id}: {text}")
        is_assumed = any(note.startswith(NO_UNIT) for t in traces for note in t.notes)
        row |= {"unit": units.pop() if len(units) == 1 and not is_assumed else "", "source": ""}
        old_cells = cells.get(entry.motion_id, {}).items()
        filled = {name: text for name, text in old_cells if text and name not in {"npts", "sha256"}}
        rows.append(row | filled)
    folder.write_index(index, rows)
    return index


class _Checker:
    """Checks of files and pairs, which know the records checked before."""

    def __init__(self, if_doubtful: FileVerdict) -> None:
        self._if_doubtful: FileVerdict = if_doubtful
        self._names: dict[tuple[object, ...], str] = {}

    def of_file(self, path: Path, stated: Stated | None) -> FileCheck:
        """Return the check of one file without the second component of its motion."""
        try:
            trace = read.read_trace(path, stated)
        except InputError as error:
            verdict = "needs_dt" if isinstance(error, DtMissingError) else "error"
            return FileCheck(file=str(path), verdict=verdict, messages=(str(error),))
        check = FileCheck(
            file=str(path),
            verdict=self._if_doubtful if trace.warnings else "ok",
            format=trace.format,
            dt_s=trace.dt_s,
            npts=int(trace.accel_mps2.size),
            pga_g=peak_g(trace.accel_mps2),
            messages=trace.messages,
        )
        equal_record = read.earlier_record(self._names, str(path), [trace.accel_mps2], trace.dt_s)
        return check.noted(f"same samples as {equal_record}") if equal_record else check

    def of_files(
        self, paths: list[Path], stated: Stated | None, *, of_study: bool = False
    ) -> list[FileCheck]:
        """Return the checks of ``paths``, which have no index, in this order; two paths are a pair.

        If ``of_study``, the checks of unpaired files have a note that a study does not use them.
        """
        is_pair = len(paths) == 2 and not of_study
        paired = {"": tuple(sorted(paths))} if is_pair else folder.pair_files(paths)[0]
        pairs, last_h1 = list(paired.values()), None
        for path in paths:
            ending = read.split_name(path)[1]
            last_h1 = path if ending == "h1" else last_h1
            # an h2 file without a partner belongs to the last h1 file before it
            if ending == "h2" and last_h1 and not any(path in pair for pair in paired.values()):
                pairs.append((last_h1, path))
        checks: dict[Path, FileCheck] = {}
        for pair in pairs:
            motion = folder.motion_of_files(read.motion_name(*pair), pair, stated)
            checks |= dict(zip(pair, self.of_motion(motion, Path()), strict=True))
        for path in (path for path in paths if path not in checks):
            checks[path] = self.of_file(path, stated)
            if of_study and checks[path].passes:
                is_vertical = read.is_vertical(path) or read.read_trace(path, stated).is_vertical
                reason = "vertical component: a study does not use it"
                unpaired = "no second component found: a study needs pairs"
                checks[path] = checks[path].noted(reason if is_vertical else unpaired)
        return [checks[path] for path in paths]

    def of_motion(self, entry: folder.IndexEntry, root: Path) -> list[FileCheck]:
        """Return checks of both files of a motion, also as a pair, or one of a generated motion."""
        checks = [self.of_file(*component) for component in entry.components]
        if not all(check.passes for check in checks):
            return checks
        generated = FileCheck(file=str(root / entry.motion_id), verdict="ok")
        checks = checks or [generated]
        try:
            motion = read_entry(entry)
        except read.PairError as error:
            return [*checks[:-1], checks[-1].noted(str(error), "pair_error")]
        except InputError as error:
            return [check.noted(str(error), "error") for check in checks]
        if not entry.components:
            fields = {"dt_s": motion.dt_s, "npts": motion.npts}
            pga_g = max(map(peak_g, motion.components))
            return [replace(generated, format="made", pga_g=pga_g, **fields)]
        messages = {text for check in checks for text in check.messages}
        names = [path.name for path, _ in reversed(entry.components)]
        for text in motion.messages:
            if text.partition(": ")[2] not in messages:
                verdict = self._if_doubtful if read.is_doubt(text) else None
                checks = [
                    check.noted(f"with {other_name}: {text}", verdict)
                    for check, other_name in zip(checks, names, strict=True)
                ]
        return checks


def _unread(root: Path, used_files: list[Path], reason: str) -> list[FileCheck]:
    used, checks = {path.resolve() for path in used_files}, list[FileCheck]()
    for path in folder.files_below(root):
        name, letters = path.name.lower(), {level[0] for level in path.relative_to(root).parts}
        if path.resolve() in used or name == folder.INDEX_NAME or "." in letters:
            continue
        is_integral = name.endswith((".vt2", ".dt2")) and path.stem in {file.stem for file in used}
        is_note = name in folder.NOT_MOTIONS or name.endswith((".md", ".png")) or "_" in letters
        verdict = "left_out" if is_integral or is_note else "not_read"
        checks.append(FileCheck(file=str(path), verdict=verdict, messages=(f"not read: {reason}",)))
    return checks
