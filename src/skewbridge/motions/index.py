"""The list of motions in a folder: `index.csv`, or the pairs found by file name."""

import math
import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.motions.formats.trace import Given, Trace
from skewbridge.motions.pairing import group_by_name, pair_by_header, refuse_unpaired
from skewbridge.motions.read import read_trace
from skewbridge.motions.record import NUMBER_FIELDS
from skewbridge.reading import shortened
from skewbridge.reading.files import shown_path
from skewbridge.reading.tables import read_csv

MAX_FILES: Final = 50_000
MAX_MOTIONS: Final = 20_000
INDEX_NAME: Final = "index.csv"
# Anything else in a folder of motions (notes, tables) is left alone.
SUFFIXES: Final = (
    ".at2", ".v2", ".ew", ".ns", ".ew1", ".ns1", ".ew2", ".ns2", ".knet", ".acc", ".g3", ".th",
    ".thf", ".dat", ".txt", ".csv",
)  # fmt: skip
_ANY_TEXT: Final = (".txt", ".csv", ".dat")
_NUMBERS: Final = re.compile(rb"\s*[-+.\d][-+.,;\seEdD\d]*")
_NOT_MOTIONS: Final = frozenset({"index.csv", "manifest.csv", "expected.csv", "readme.txt"})
COLUMNS: Final = (
    "motion_id", "file_1", "file_2", "channel_1", "channel_2", "event", "magnitude", "distance_km",
    "vs30_mps", "station", "azimuth_1_deg", "azimuth_2_deg", "unit", "dt_s", "npts", "sha256",
    "scale", "scale_t1_s", "scale_low_g", "scale_high_g", "licence", "source",
)  # fmt: skip
_NUMERIC: Final = (*NUMBER_FIELDS, "scale", "scale_t1_s", "scale_low_g", "scale_high_g")
#: It names logs and stands in tables and figures.
_NAME: Final = re.compile(r"\w[\w .+(),&@-]{0,99}")
MAX_NAME: Final = 255
_REQUIRED: Final = ("motion_id", "file_1", "file_2")


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexEntry:
    """One motion of a folder; what is unknown is nan or empty.

    Attributes not named here are those of `GroundMotion`.

    Attributes:
        file_1: File of component 1 (bridge x at incidence 0).
        file_2: File of component 2.
        given_1: Time step, unit and channel of file 1 where the index has them.
        given_2: The same of file 2.
        sha256: Expected digest of the files; empty: not checked.
        scale: Factor of the study; nan: computed.
        scale_t1_s: Period the factor was made with; nan: any.
        scale_low_g: Lowest level the factor was made for; nan: any.
        scale_high_g: Highest level the factor was made for; nan: any.
    """

    motion_id: str
    file_1: Path
    file_2: Path
    given_1: Given
    given_2: Given
    event: str = ""
    magnitude: float = float("nan")
    distance_km: float = float("nan")
    vs30_mps: float = float("nan")
    station: str = ""
    azimuth_1_deg: float = float("nan")
    azimuth_2_deg: float = float("nan")
    sha256: str = ""
    scale: float = float("nan")
    scale_t1_s: float = float("nan")
    scale_low_g: float = float("nan")
    scale_high_g: float = float("nan")
    source: str = ""

    @property
    def components(self) -> tuple[tuple[Path, Given], tuple[Path, Given]]:
        """Each file with what the index knows of it."""
        return (self.file_1, self.given_1), (self.file_2, self.given_2)


def list_motions(folder: Path) -> list[IndexEntry]:
    """Return the motions of a folder, by its `index.csv` or, without one, by file name and header.

    Raises:
        InputError: No folder, no motions, an unpaired file, a broken index.
    """
    if not is_folder(folder):
        raise InputError(f"motions folder {shown_path(folder)} does not exist", folder=str(folder))
    index = folder / INDEX_NAME
    if index.is_file():
        return read_index(index)
    entries = [
        IndexEntry(motion_id=name, file_1=first, file_2=second, given_1=Given(), given_2=Given())
        for name, (first, second) in _pairs(motion_files(folder)).items()
    ]
    if not entries:
        raise InputError(f"no motions in {shown_path(folder)}", folder=str(folder))
    return entries


def _pairs(paths: list[Path]) -> dict[str, tuple[Path, Path]]:
    """Return the pairs by file name; what is left over, by the headers."""
    pairs: dict[str, tuple[Path, Path]] = {}
    left: dict[str, list[Path]] = {}
    for name, files in group_by_name(paths).items():
        if len(files) == 2:
            pairs[name] = (files[0], files[1])
        else:
            left[name] = files
    traces: list[Trace] = []
    for name, files in left.items():
        try:
            traces += [read_trace(path) for path in files]
        except InputError:
            refuse_unpaired(name, files)
    by_header = pair_by_header(traces)
    paired = {trace.path for pair in by_header.values() for trace in pair}
    stations = {trace.station for pair in by_header.values() for trace in pair}
    vertical = {
        trace.path
        for trace in traces
        if math.isnan(trace.azimuth_deg) and trace.station in stations
    }
    for name, files in left.items():
        if not paired.union(vertical).issuperset(files):
            refuse_unpaired(name, files)
    pairs |= {name: (one.path, two.path) for name, (one, two) in by_header.items()}
    return dict(sorted(pairs.items()))


def motion_files(folder: Path) -> list[Path]:
    """Return the files of a folder and its sub-folders that look like motions, sorted by path.

    Velocities and displacements of a PEER download (`.VT2`, `.DT2`), its search results and text
    files that start with text are not motions.
    """
    return [
        path
        for path in files_below(folder)
        if path.suffix.lower() in SUFFIXES
        and path.name.lower() not in _NOT_MOTIONS
        and not any(part.startswith(("_", ".")) for part in path.relative_to(folder).parts)
        and (path.suffix.lower() not in _ANY_TEXT or _starts_with_numbers(path))
    ]


def is_folder(path: Path) -> bool:
    """Say whether there is such a folder, for any text as its name."""
    try:
        return path.is_dir()
    except OSError:
        return False


def files_below(folder: Path) -> list[Path]:
    """Return the files of a folder and its sub-folders, sorted by path.

    Raises:
        InputError: More than any folder of motions has, or a folder that cannot be read.
    """
    try:
        files = [path for path in islice(folder.rglob("*"), MAX_FILES + 1) if path.is_file()]
    except OSError as error:
        raise InputError(f"{shown_path(folder)}: {error.strerror}", folder=str(folder)) from None
    if len(files) > MAX_FILES:
        raise InputError(
            f"{shown_path(folder)} has more than {MAX_FILES} files: name the folder of the motions",
            folder=str(folder),
        )
    return sorted(files)


def _starts_with_numbers(path: Path) -> bool:
    """Say whether a line of nothing but numbers is among the first ten."""
    try:
        with path.open("rb") as stream:
            lines = stream.read(4096).splitlines()[:10]
    except OSError:
        return True  # the reader will say what is wrong
    return any(_NUMBERS.fullmatch(line) for line in lines)


def read_index(index: Path) -> list[IndexEntry]:
    """Return the entries of an `index.csv`, in its order.

    Raises:
        InputError: Missing columns, a repeated motion, a value that is no number, a file outside
            the folder; the message names the row.
    """
    table = read_index_table(index)
    repeated = table["motion_id"][table["motion_id"].duplicated()]
    if not repeated.empty:
        told = f"{index}: motion {shortened(repeated.iloc[0])} is listed twice"
        raise InputError(told, file=str(index))
    rows: list[dict[str, str]] = table.to_dict("records")  # pyright: ignore[reportAssignmentType]
    return [_entry(row, index, number) for number, row in enumerate(rows, start=2)]


def read_index_table(index: Path) -> pd.DataFrame:
    """Return the text of an `index.csv` cell by cell, with the columns a motion needs.

    Raises:
        InputError: No table, a missing column, no rows.
    """
    table = read_csv(index, dtype=str, keep_default_na=False)
    missing = [name for name in _REQUIRED if name not in table.columns]
    if missing:
        raise InputError(f"{index}: column(s) {', '.join(missing)} missing", file=str(index))
    if len(table) > MAX_MOTIONS:
        raise InputError(f"{index}: {len(table)} motions, at most {MAX_MOTIONS}", file=str(index))
    if table.empty:
        raise InputError(f"{index}: no motions listed", file=str(index))
    return table


def _entry(row: dict[str, str], index: Path, line: int) -> IndexEntry:
    where = f"{index.name}, line {line}"

    def number(name: str) -> float:
        text = row.get(name, "").strip()
        try:
            value = float(text) if text else float("nan")
        except ValueError:
            value = math.inf
        if math.isinf(value):
            raise InputError(
                f"{where}: {name} must be a number, got {shortened(text)}", file=str(index)
            )
        return value

    def known(channel_column: str) -> Given:
        channel = number(channel_column)
        if not (math.isnan(channel) or channel.is_integer()):
            raise InputError(f"{where}: {channel_column} must be whole, got {channel}")
        return Given(
            dt_s=None if math.isnan(dt_s) else dt_s,
            unit=row.get("unit") or None,
            channel=None if math.isnan(channel) else int(channel),
        )

    motion_id = row["motion_id"].strip()
    if not _NAME.fullmatch(motion_id):
        raise InputError(
            f"{where}: motion_id must be 1 to 100 letters, digits, blanks or any of _.+-(),&@ and "
            f"begin with a letter, digit or _, got {shortened(motion_id)}",
            file=str(index),
        )
    numbers = {name: number(name) for name in _NUMERIC}
    for name in ("scale", "dt_s"):
        if numbers[name] <= 0.0:
            raise InputError(
                f"{where}: {name} must be positive, got {numbers[name]}", file=str(index)
            )
    dt_s = numbers.pop("dt_s")
    return IndexEntry(
        motion_id=motion_id,
        file_1=inside_folder(index.parent, row["file_1"], where),
        file_2=inside_folder(index.parent, row["file_2"], where),
        given_1=known("channel_1"),
        given_2=known("channel_2"),
        event=row.get("event", ""),
        station=row.get("station", ""),
        sha256=row.get("sha256", "").strip().lower(),
        source="; ".join(text for text in (row.get("licence", ""), row.get("source", "")) if text),
        **numbers,
    )


def inside_folder(folder: Path, name: str, where: str) -> Path:
    """Return the path of a file named by an index, which must stay inside the index's folder.

    Raises:
        InputError: An absolute path, one that climbs out, a link that leads out, no such file.
    """
    name = name.strip()
    if not name or not name.isprintable() or len(name) > MAX_NAME:
        raise InputError(f"{where}: no file name: {shortened(name)}")
    relative = Path(name.replace("\\", "/"))
    drive = len(name) > 1 and name[1] == ":"
    if relative.is_absolute() or drive or ".." in relative.parts:
        raise InputError(f"{where}: {shortened(name)} is not inside the folder of the index")
    path = folder / relative
    if any(len(part.encode()) > MAX_NAME for part in relative.parts):
        raise InputError(f"{where}: {shortened(name)} is listed but missing", file=name)
    if not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{where}: {shortened(name)} leads out of the folder of the index")
    if not path.is_file():
        raise InputError(f"{where}: {shortened(name)} is listed but missing", file=name)
    return path
