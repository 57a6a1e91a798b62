"""The list of motions in a folder: `index.csv`, or the pairs found by file name."""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.motions.folders import inside_folder, is_folder, motion_files
from skewbridge.motions.formats.trace import Given, Trace
from skewbridge.motions.pairing import group_by_name, pair_by_header, refuse_unpaired
from skewbridge.motions.read import read_trace
from skewbridge.motions.record import NUMBER_FIELDS
from skewbridge.reading import read_csv, records_of, shortened, shown_path

MAX_MOTIONS: Final = 20_000
INDEX_NAME: Final = "index.csv"
COLUMNS: Final = (
    "motion_id", "file_1", "file_2", "channel_1", "channel_2", "event", "magnitude", "distance_km",
    "vs30_mps", "station", "azimuth_1_deg", "azimuth_2_deg", "unit", "dt_s", "npts", "sha256",
    "scale", "scale_t1_s", "scale_low_g", "scale_high_g", "licence", "source", "made_from_number",
)  # fmt: skip
_NUMERIC: Final = (*NUMBER_FIELDS, "scale", "scale_t1_s", "scale_low_g", "scale_high_g")
#: It names logs and stands in tables and figures.
_NAME: Final = re.compile(r"\w[\w .+(),&@-]{0,99}")
_REQUIRED: Final = ("motion_id", "file_1", "file_2")
#: Where an index has a number instead of files: the motion is made, by the rule of the suite.
MADE_FROM: Final = "made_from_number"


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexEntry:
    """One motion of a folder; what is unknown is nan or empty.

    Attributes not named here are those of `GroundMotion`.

    Attributes:
        file_1: File of component 1 (bridge x at incidence 0); None of a motion that is made.
        file_2: File of component 2.
        given_1: Time step, unit and channel of file 1 where the index has them.
        given_2: The same of file 2.
        made_from_number: Number of a motion that is made by the rule of the default suite, see
            `synthesis.embedded`; None of a motion in files.
        sha256: Expected digest of the files; empty: not checked.
        scale: Factor of the study; nan: computed.
        scale_t1_s: Period the factor was made with; nan: any.
        scale_low_g: Lowest level the factor was made for; nan: any.
        scale_high_g: Highest level the factor was made for; nan: any.
    """

    motion_id: str
    file_1: Path | None
    file_2: Path | None
    given_1: Given
    given_2: Given
    made_from_number: int | None = None
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
    def components(self) -> tuple[tuple[Path, Given], ...]:
        """Each file with what the index knows of it; none of a motion that is made."""
        if self.file_1 is None or self.file_2 is None:
            return ()
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
    return [_entry(row, index, number) for number, row in enumerate(records_of(table), start=2)]


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

    def whole(name: str) -> int | None:
        value = number(name)
        if math.isnan(value):
            return None
        if not value.is_integer():
            raise InputError(f"{where}: {name} must be whole, got {value}")
        return int(value)

    def known(channel_column: str) -> Given:
        return Given(
            dt_s=None if math.isnan(dt_s) else dt_s,
            unit=row.get("unit") or None,
            channel=whole(channel_column),
        )

    def file(name: str) -> Path | None:
        return None if made is not None else inside_folder(index.parent, row[name], where)

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
    made = whole(MADE_FROM)
    if made is not None and (made < 1 or row["file_1"].strip() or row["file_2"].strip()):
        raise InputError(
            f"{where}: {MADE_FROM} is a number from 1 in place of files, got {made}",
            file=str(index),
        )
    return IndexEntry(
        motion_id=motion_id,
        file_1=file("file_1"),
        file_2=file("file_2"),
        made_from_number=made,
        given_1=known("channel_1"),
        given_2=known("channel_2"),
        event=row.get("event", ""),
        station=row.get("station", ""),
        sha256=row.get("sha256", "").strip().lower(),
        source="; ".join(text for text in (row.get("licence", ""), row.get("source", "")) if text),
        **numbers,
    )
