"""Tables of demands and results: reading, import from other programs, and statistics."""

import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from joblib import cpu_count
from pydantic import BaseModel, ConfigDict, Field

from skewbridge.demands.columns import unit_of
from skewbridge.demands.completeness import BEYOND_MODEL, COMPLETE, is_complete
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.errors import InputError
from skewbridge.files.checking import checked
from skewbridge.files.tables import frame_of, read_frame, records_of, texts_of
from skewbridge.files.tables import read_table as read_parquet
from skewbridge.files.text import read_csv, read_yaml, writable_folder
from skewbridge.fragility.columns import as_column, require
from skewbridge.fragility.demand_table import (
    IDENTITY_COLUMNS,
    KEY_COLUMNS,
    LOADING_COLUMNS,
    axis_names,
    need_columns,
    variant_columns,
)
from skewbridge.fragility.limit_states import (
    LimitState,
    load_limit_states,
)
from skewbridge.fragility.paper_table import printed_rows
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.study_tables import PAPER_TABLE, fragility_tables, write_tables
from skewbridge.statuses import OK, STATUSES

#: Provenance that all tables of one study share.
_STUDY_KEYS: Final = ("config_digest", "suite_digest", "git_commit", "skewbridge_version")
_UNIT: Final = b"unit"
#: Columns of a table of fits that are values of its intensity measure.
_MEDIAN: Final = re.compile(r"theta(_(?!bound_beta)\w+)?")
#: Values of columns that a foreign table may lack.
_NEUTRAL: Final[dict[str, Any]] = {
    "bridge": "foreign",
    "abutment": "foreign",
    "scale": 1.0,
    "incidence_deg": 0.0,
    "status": OK,
}
_TEXTS: Final = (*IDENTITY_COLUMNS, "motion_id", "status", "collapse_criterion", BEYOND_MODEL)


def read_table(path: Path) -> pd.DataFrame:
    """Read a parquet table, or CSV with any other suffix.

    Raises:
        InputError: The file cannot be read, or is a table of another version of this program.
    """
    return read_frame(path) if path.suffix == ".parquet" else read_csv(path)


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """Tables of a finished study.

    Every frame has ``attrs["units"]``, units by column without ratios and texts, and
    ``attrs["provenance"]``, texts by name. Medians have the unit of their intensity measure.

    Attributes:
        folder: Folder of the study.
        demands: A row per analysis.
        fragility: Tables of the fits by name: curves, effects, intensity_effects, joint ...
    """

    folder: Path
    demands: pd.DataFrame
    fragility: dict[str, pd.DataFrame] = field(default_factory=dict[str, pd.DataFrame])


def load_results(folder: Path) -> Results:
    """Read the demands of a study and all tables of its fits.

    Warns (`UserWarning`) when tables have different configurations, motions, commits or versions.

    Raises:
        InputError: The folder has no demands, or a table is damaged or of another version.
    """
    demands = _frame(demands_file(folder))
    fits = {file.stem: _frame(file) for file in sorted(folder.glob("fragility/*.parquet"))}
    origin = {name: t.attrs["provenance"] for name, t in {"demands": demands, **fits}.items()}
    mixed: list[str] = []
    for key in _STUDY_KEYS:
        tables: dict[str, list[str]] = {}
        for name, texts in origin.items():
            tables.setdefault(texts.get(key, "unknown"), []).append(name)
        if len(tables) > 1:
            shown = (f"{value[:12]} ({', '.join(names)})" for value, names in tables.items())
            mixed.append(f"{key} {', '.join(shown)}")
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
        text = f"{folder} has no demands.parquet: give the folder of a study that has run"
        raise InputError(text)
    return path


def _frame(path: Path) -> pd.DataFrame:
    table = read_parquet(path)
    schema, frame = table.schema, frame_of(table)
    written = {name: (schema.field(name).metadata or {}).get(_UNIT, b"") for name in schema.names}
    units = {name: unit.decode() or unit_of(name) for name, unit in written.items()}
    measures = {unit_of(str(name)) for name in frame["im"].dropna()} if "im" in frame else set()
    if len(measures) == 1:
        of_measure = measures.pop()
        units |= {name: of_measure for name in units if _MEDIAN.fullmatch(name)}
    frame.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    frame.attrs["provenance"] = texts_of(schema)
    return frame


class ColumnMap(BaseModel):
    """A file that maps the columns of a foreign table to ours."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    columns: dict[str, str] = Field(description="our column to theirs")
    factors: dict[str, float] = Field(default={}, description="factor to our unit, by our column")
    constants: dict[str, str | float] = Field(
        default={}, description="values of columns that the file lacks"
    )


def read_mapped(path: Path, column_file: Path) -> pd.DataFrame:
    """Read runs of another program by a YAML file with the content of `ColumnMap`.

    Raises:
        InputError: As `read_foreign`, or a key of the file of columns is wrong.
    """
    chosen = checked(ColumnMap, read_yaml(column_file), column_file.name)
    return read_foreign(path, chosen.columns, factors=chosen.factors, constants=chosen.constants)


def read_foreign(
    path: Path,
    columns: Mapping[str, str],
    *,
    factors: Mapping[str, float] | None = None,
    constants: Mapping[str, Any] | None = None,
) -> pd.DataFrame:
    """Read runs of another program as a demands table.

    Args:
        path: CSV or parquet with one row per run.
        columns: Our column name to the column of the file, for example
            ``{"motion_id": "record", "im_pga_rotd50_g": "PGA", "column_drift_ratio": "drift"}``.
            At least ``motion_id``, one ``im_`` column and one demand.
        factors: Factor to our unit by our column, for example ``{"deck_disp_m": 0.0254}``.
        constants: Values of columns that the file lacks; bridge, abutment, scale, incidence_deg
            and status have neutral ones.

    Returns:
        Demands table. ``variant`` is made of bridge, abutment and axes, ``complete`` derived from
        status and ``beyond_model``, unless the file has them. Missing intensities and demands stay
        NaN: `prepared` rejects such rows one by one.

    Raises:
        InputError: A column is missing, a number unreadable, a key missing, an intensity not
            positive, a status unknown, or a run occurs twice; names row and column.
    """
    source = read_table(path)
    need_columns(source, columns.values(), path.name)
    out = pd.DataFrame({ours: source[theirs] for ours, theirs in columns.items()})
    if "motion_id" not in out or not any(str(name).startswith("im_") for name in out):
        raise InputError("the column map needs motion_id and at least one im_ column")
    for name, value in (_NEUTRAL | dict(constants or {})).items():
        if name not in out:
            out[name] = value
    for name in out.columns.difference(list(_TEXTS)):
        numbers = as_column(out[name].to_numpy(), columns.get(name, name))
        out[name] = numbers > 0.0 if name == COMPLETE else numbers * (factors or {}).get(name, 1.0)
    for name in (*LOADING_COLUMNS, *axis_names(out), "status"):
        require(out[name].notna().to_numpy(), columns.get(name, name), "is missing")
    if "variant" not in out:
        parts = [out[name].map(str).tolist() for name in variant_columns(out)[1:]]
        out["variant"] = ["_".join(values) for values in zip(*parts, strict=True)]
    for name in set(_TEXTS) & set(out.columns):
        out[name] = (out[name].fillna("") if name == BEYOND_MODEL else out[name]).astype(str)
    known = out["status"].isin(STATUSES).to_numpy()
    wrong = repr(out["status"].iloc[int(np.argmin(known))]) if len(out) else ""
    require(known, "status", f"{wrong} is not known")
    for name in map(str, out.filter(regex="^im_")):
        require((out[name].isna() | (out[name] > 0.0)).to_numpy(), name, "must be > 0 and finite")
    doubled = out.duplicated(["variant", *LOADING_COLUMNS])
    if doubled.any():
        row = int(np.argmax(doubled))
        text = f"row {row} repeats variant, motion_id, scale and incidence_deg of another row"
        raise InputError(text, row=row)
    if COMPLETE not in out:
        out[COMPLETE] = is_complete(out)
    first = [*variant_columns(out), *LOADING_COLUMNS, "status"]
    return out[[*first, *(name for name in out if name not in first)]].reset_index(drop=True)


def read_demands(path: Path, im: str | None, further: Sequence[str]) -> pd.DataFrame:
    """Read a demands table; names, scale and incidence are optional and have neutral values.

    Raises:
        InputError: A column is missing or a value unusable; names row and column.
    """
    source = read_table(path)
    named = {*KEY_COLUMNS, *axis_names(source), BEYOND_MODEL, COMPLETE, "collapse_criterion"}
    named |= {*further, *(column.name for column in DEMAND_COLUMNS), *([im] if im else [])}
    kept = [c for c in map(str, source.columns) if c in named or c.startswith("im_")]
    need_columns(source, ["status"], path.name)
    return read_foreign(path, {name: name for name in kept})


def _usable_states(
    demands: Path, limit_states: Path, im: str | None
) -> tuple[pd.DataFrame, list[LimitState], list[LimitState], str]:
    """Return the demands, the limit states with and without a demand, and the intensity measure."""
    states = load_limit_states(limit_states)
    table = read_demands(demands, im, [state.demand for state in states])
    usable = [state for state in states if state.demand in table]
    if not usable:
        wanted = ", ".join(dict.fromkeys(state.demand for state in states))
        raise InputError(f"{demands.name} has none of the demands of the limit states: {wanted}")
    measures = list(map(str, table.filter(regex="^im_")))
    if im is None and DEFAULTS.im not in measures and len(measures) != 1:
        raise InputError(
            f"choose the intensity with --im: one of {', '.join(measures)}", column="im"
        )
    chosen = im or (DEFAULTS.im if DEFAULTS.im in measures else measures[0])
    if chosen not in table:
        raise InputError(f"no column {chosen!r}; intensities: {', '.join(measures)}", column=chosen)
    return table, usable, [state for state in states if state not in usable], chosen


def statistics_of(
    demands: Path,
    out: Path,
    *,
    limit_states: Path,
    im: str | None = None,
    margin: float | None = None,
) -> dict[str, Any]:
    """Write every table of results/fragility from a table of demands.

    Returns:
        ``tables`` (rows by table), ``status`` of the fits and ``verdict`` (family-wise) of the
        effects (counts), ``left_out`` (limit states whose demand the table lacks),
        ``rejected_rows`` (their number), ``notes`` (rejected rows, missing demands, equal motions),
        ``im``, ``out``.

    Raises:
        InputError: A file, column or value is unusable; names row and column.
    """
    if margin is not None and not 0.0 < margin < 1.0:
        raise InputError(f"margin must be within 0..1, got {margin:g}", column="margin")
    table, states, left_out, measure = _usable_states(demands, limit_states, im)
    margins = {} if margin is None else {"margin": margin, "median_margin": margin}
    settings = replace(DEFAULTS, im=measure, **margins)
    tables = fragility_tables(table, states, settings, jobs=cpu_count())
    write_tables(tables, writable_folder(out))
    notes = tables["input_notes"]
    return {
        "tables": {name: len(rows) for name, rows in tables.items()},
        "status": tables["curves"]["status"].value_counts().to_dict(),
        "verdict": tables["effects"]["verdict_family"].value_counts().to_dict(),
        "left_out": [f"{state.key} ({state.demand})" for state in left_out],
        "rejected_rows": int((notes["kind"] == "rejected_row").sum()),
        "notes": notes["message"].tolist(),
        "im": measure,
        "out": str(out),
    }


def paper_rows(demands: Path, limit_states: Path, im: str | None = None) -> dict[str, Any]:
    """Return the fragility table for publication; arguments as for `statistics_of`.

    Returns:
        ``rows`` (numbers, by `paper_columns`), ``shown`` (the rows as printed) and ``title``.

    Raises:
        InputError: A file, column or value is unusable; names row and column.
    """
    table, states, _, measure = _usable_states(demands, limit_states, im)
    settings = FitSettings(im=measure)
    rows = fragility_tables(table, states, settings, jobs=cpu_count())[PAPER_TABLE]
    return {
        "rows": records_of(rows),
        "shown": printed_rows(rows),
        "title": f"medians in {measure}",
    }
