"""Statistics of a table of demands that somebody else's analyses may have made."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd
from joblib import cpu_count

from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.errors import InputError
from skewbridge.fragility.exchange.data_files import read_table
from skewbridge.fragility.exchange.foreign import read_foreign
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.all_tables import (
    PAPER_TABLE,
    effect_tables,
    fit_tables,
    write_tables,
)
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL
from skewbridge.fragility.tables.key_columns import KEY_COLUMNS, axis_names
from skewbridge.fragility.tables.limit_states import LimitState, load_limit_states
from skewbridge.fragility.tables.paper_table import PAPER_COLUMNS, printed_rows
from skewbridge.provenance.files import writable_folder

_IM: Final = "im_"


def statistics_of(
    demands: Path,
    out: Path,
    *,
    limit_states: Path,
    im: str | None = None,
    margin: float | None = None,
) -> dict[str, Any]:
    """Make every table of results/fragility from a table of demands.

    Args:
        demands: CSV or parquet; at least axes, motion_id, status, one intensity, one demand.
        out: Folder for the tables.
        limit_states: File of the limit states.
        im: Column of intensities; None for the usual one, or the only ``im_`` column.
        margin: Relative change that counts as negligible.

    Returns:
        ``tables`` (rows by table), ``status`` of the fits and ``verdict`` of the effects (counts),
        ``left_out`` (limit states whose demand the table lacks), ``im``, ``out``.

    Raises:
        InputError: A file, column or value is unusable; names row and column.
    """
    if margin is not None and not 0.0 < margin < 1.0:
        raise InputError(f"margin must be within 0..1, got {margin:g}", column="margin")
    states = load_limit_states(limit_states)
    table, known, measure = _usable(demands, states, im)
    settings = FitSettings(im=measure, margin=DEFAULTS.margin if margin is None else margin)
    columns = list(dict.fromkeys(state.demand for state in known))
    jobs = cpu_count()
    tables = fit_tables(table, known, settings, jobs=jobs)
    tables |= effect_tables(table, settings, columns, jobs=jobs)
    write_tables(tables, writable_folder(out))
    return {
        "tables": {name: len(each) for name, each in tables.items()},
        "status": _counts(tables["curves"]["status"]),
        "verdict": _counts(tables["effects"]["verdict"]),
        "left_out": [_name(state) for state in states if state not in known],
        "im": measure,
        "out": str(out),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperRows:
    """The table of a paper: all numbers, and what is shown of them."""

    rows: list[dict[str, Any]]
    shown: list[dict[str, str]]
    title: str


def paper_rows(demands: Path, limit_states: Path, im: str | None = None) -> PaperRows:
    """Return the table that a paper prints of a table of demands; arguments as `statistics_of`.

    Raises:
        InputError: A file, column or value is unusable; names row and column.
    """
    table, known, measure = _usable(demands, load_limit_states(limit_states), im)
    found = fit_tables(table, known, FitSettings(im=measure), jobs=cpu_count())[PAPER_TABLE]
    return PaperRows(
        rows=[dict(zip(PAPER_COLUMNS, row, strict=True)) for row in found.to_numpy().tolist()],
        shown=printed_rows(found),
        title=f"medians in {measure}",
    )


def _usable(
    demands: Path, states: Sequence[LimitState], im: str | None
) -> tuple[pd.DataFrame, list[LimitState], str]:
    """Return the demands, the limit states that they have a demand of, and the intensity."""
    table = read_demands(demands, im, [state.demand for state in states])
    known = [state for state in states if state.demand in table.columns]
    if not known:
        wanted = ", ".join(dict.fromkeys(state.demand for state in states))
        raise InputError(f"{demands.name} has none of the demands of the limit states: {wanted}")
    return table, known, _measure(table, im)


def read_demands(path: Path, im: str | None, further: list[str]) -> pd.DataFrame:
    """Return a table of demands in our form; names, scale and incidence have neutral values.

    ``further`` are columns of demands beside those that we know.

    Raises:
        InputError: A column is missing or a value unusable; names row and column.
    """
    source = read_table(path)
    named = [BEYOND_MODEL, "collapse_criterion", *further]
    named += [column.name for column in DEMAND_COLUMNS]
    wanted = {*KEY_COLUMNS, *axis_names(source), *named, *([] if im is None else [im])}
    kept = [c for c in map(str, source.columns) if c in wanted or c.startswith(_IM)]
    if "status" not in kept:
        raise InputError(f"{path.name} has no column 'status'", column="status")
    return read_foreign(path, {name: name for name in kept})


def _measure(table: pd.DataFrame, im: str | None) -> str:
    found = [str(name) for name in table.columns if str(name).startswith(_IM)]
    if im is not None:
        if im not in table.columns:
            raise InputError(f"no column {im!r}; intensities: {', '.join(found)}", column=im)
        return im
    if DEFAULTS.im in found:
        return DEFAULTS.im
    if len(found) != 1:
        raise InputError(f"name the intensity by --im, one of {', '.join(found)}", column="im")
    return found[0]


def _name(state: LimitState) -> str:
    return f"{state.component}/{state.name} ({state.demand})"


def _counts(values: pd.Series) -> dict[str, int]:
    return {str(name): int(count) for name, count in values.value_counts().items()}
