"""All tables of results/fragility from one demands table, with a description of every column."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.demands.completeness import with_derived_columns
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.files.text import write_text
from skewbridge.fragility.curves import CURVE_COLUMNS, fit_study
from skewbridge.fragility.demand_table import (
    BRIDGE_COLUMNS,
    KEY_COLUMNS,
    NOTE_COLUMNS,
    need_columns,
    prepared,
)
from skewbridge.fragility.effects import EFFECT_COLUMNS, INTENSITY_COLUMNS, effect_tables
from skewbridge.fragility.joint import JOINT_COLUMNS, joint_table
from skewbridge.fragility.limit_states import LimitState, with_column_failure
from skewbridge.fragility.measures import MEASURE_COLUMNS, measure_table
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.paper_table import latex_table, paper_columns, paper_table
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.system import SYSTEM_COLUMNS, system_curves
from skewbridge.fragility.verdicts import NEEDED_COLUMNS, needed_motions
from skewbridge.variant.axes import AXES, axes_of

PAPER_TABLE: Final = "table"
#: Degree of damage whose median is the intensity at which effects on demands are stated.
REFERENCE_STATES: Final = (
    "column_curvature/moderate",
    "column_drift/moderate",
    "unseating/moderate",
    "column_curvature/slight",
    "column_drift/slight",
    "unseating/slight",
)
_KEYS: Final = {name: CURVE_COLUMNS[name] for name in ("variant", *BRIDGE_COLUMNS)}
#: Descriptions of the columns by table.
DESCRIPTIONS: Final[dict[str, Mapping[str, str]]] = {
    "curves": CURVE_COLUMNS,
    "median_effects": EFFECT_COLUMNS,
    "effects": EFFECT_COLUMNS,
    "intensity_effects": INTENSITY_COLUMNS,
    "needed_motions": NEEDED_COLUMNS,
    "joint": JOINT_COLUMNS,
    "system": _KEYS | SYSTEM_COLUMNS,
    "measures": MEASURE_COLUMNS,
    "input_notes": NOTE_COLUMNS,
    PAPER_TABLE: paper_columns(AXES),
}


def fragility_tables(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings,
    suite: pd.DataFrame | None = None,
    *,
    jobs: int = 1,
) -> dict[str, pd.DataFrame]:
    """Return every table of results/fragility by file name.

    Raises:
        InputError: A column is missing or a value unusable; names row and column.
    """
    need_columns(demands, KEY_COLUMNS)
    states = with_column_failure(limit_states, with_derived_columns(demands.head(0)).columns)
    checked = prepared(demands, list(dict.fromkeys(state.demand for state in states)), settings)
    rows = checked.table
    curves = fit_study(rows, states, settings, jobs=jobs)
    medians = median_effects(rows, states, settings, jobs=jobs)
    joint = joint_table(rows, states, curves, settings, jobs=jobs)
    further = [state.demand for state in limit_states]
    names = list(dict.fromkeys((*demands_for("effect", rows.columns), *further)))
    reference = reference_intensities(curves)
    effects, intensities = effect_tables(rows, names, settings, reference_im=reference, jobs=jobs)
    needed = needed_motions(pd.concat([effects, medians], ignore_index=True), rows)
    ranked = {} if suite is None else {"measures": measure_table(rows, suite, settings)}
    return ranked | {
        "curves": curves,
        "median_effects": medians,
        "effects": effects,
        "intensity_effects": intensities,
        "needed_motions": needed,
        "joint": joint,
        "system": system_curves(rows, states, settings, jobs=jobs),
        PAPER_TABLE: paper_table(curves, medians, joint, settings),
        "input_notes": checked.notes,
    }


def reference_intensities(curves: pd.DataFrame) -> dict[tuple[str, str], float]:
    """Return per bridge and abutment model the intensity at which effects are stated.

    It is the geometric mean over the variants of the median of the first of `REFERENCE_STATES` that
    has one; a model without any is left out.
    """
    usable = curves[curves["preferred"].to_numpy(dtype=bool)]
    state = usable["component"] + "/" + usable["limit_state"]
    rank = state.map({name: number for number, name in enumerate(REFERENCE_STATES)})
    keys = list(BRIDGE_COLUMNS)
    first = usable.assign(rank=rank, ln_theta=np.log(usable["theta"])).dropna(subset=["rank"])
    ln_theta = first.groupby([*keys, "rank"])["ln_theta"].mean().groupby(level=keys).first()
    return {(str(b), str(a)): float(np.exp(value)) for (b, a), value in ln_theta.items()}


def write_described(frame: pd.DataFrame, path: Path, descriptions: Mapping[str, str]) -> None:
    """Write a table with its provenance and the descriptions of its columns, axes included."""
    axes = {axis.name: f"{axis.description}, {axis.unit}" for axis in axes_of(map(str, frame))}
    write_frame(frame, path, provenance(), axes | dict(descriptions))


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write tables as parquet files; the table for publication as CSV and LaTeX."""
    for name, frame in tables.items():
        if name == PAPER_TABLE:
            write_text(folder / f"{name}.csv", frame.to_csv(index=False, float_format="%.6g"))
            write_text(folder / f"{name}.tex", latex_table(frame))
        else:
            write_described(frame, folder / f"{name}.parquet", DESCRIPTIONS.get(name, {}))
