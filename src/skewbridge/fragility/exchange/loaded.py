"""The tables of a study as data frames that tell their units and where they come from."""

import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.demands.columns import unit_of
from skewbridge.errors import InputError
from skewbridge.provenance.tables import frame_of, read_table, texts_of

#: What must be equal in all tables of one study.
_OF_THE_STUDY: Final = ("config_digest", "suite_digest", "git_commit", "skewbridge_version")
_UNIT: Final = b"unit"
#: Columns of a table of fits that are values of its intensity measure.
_MEDIAN: Final = re.compile(r"theta(_(?!bound_beta)\w+)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """What a study found.

    Every frame has ``attrs["units"]``, units by column, ratios and words left out, and
    ``attrs["provenance"]``, texts by name. Medians have the unit of their intensity measure.

    Attributes:
        folder: Of the study.
        demands: A row per analysis.
        fragility: Tables of the fits by name: curves, effects, joint ...
    """

    folder: Path
    demands: pd.DataFrame
    fragility: dict[str, pd.DataFrame] = field(default_factory=dict[str, pd.DataFrame])


def load_results(folder: Path) -> Results:
    """Read the demands of a study and all tables of its fits.

    Warns (`UserWarning`) when tables are of different configurations, motions, commits or versions.

    Raises:
        InputError: The folder has no demands, or a table is damaged or of another version.
    """
    demands = _frame(demands_file(folder))
    fits = {file.stem: _frame(file) for file in sorted(folder.glob("fragility/*.parquet"))}
    mixed = _differences({"demands": demands, **fits})
    if mixed:
        warnings.warn(f"{folder}: tables of different origin: {'; '.join(mixed)}", stacklevel=3)
    return Results(folder=folder, demands=demands, fragility=fits)


def demands_file(folder: Path) -> Path:
    """Return the demands of a study.

    Raises:
        InputError: The folder has none.
    """
    path = folder / "demands.parquet"
    if not path.is_file():
        raise InputError(
            f"{folder} has no demands.parquet: give the folder of a study that has run"
        )
    return path


def _frame(path: Path) -> pd.DataFrame:
    table = read_table(path)
    schema, frame = table.schema, frame_of(table)
    told = {name: (schema.field(name).metadata or {}).get(_UNIT, b"") for name in schema.names}
    units = {name: unit.decode() or unit_of(name) for name, unit in told.items()}
    measures = {unit_of(str(name)) for name in frame["im"].dropna()} if "im" in frame else set()
    if len(measures) == 1:
        of_measure = measures.pop()
        units |= {name: of_measure for name in units if _MEDIAN.fullmatch(name)}
    frame.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    frame.attrs["provenance"] = texts_of(schema)
    return frame


def _differences(frames: dict[str, pd.DataFrame]) -> list[str]:
    """Return in words in what tables differ that should not."""
    said: list[str] = []
    for name in _OF_THE_STUDY:
        found: dict[str, list[str]] = {}
        for table, frame in frames.items():
            found.setdefault(frame.attrs["provenance"].get(name, "not told"), []).append(table)
        if len(found) > 1:
            said.append(
                f"{name} "
                + ", ".join(f"{value[:12]} ({', '.join(own)})" for value, own in found.items())
            )
    return said
