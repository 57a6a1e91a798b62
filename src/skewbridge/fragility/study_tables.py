"""All tables of results/fragility: made from a demands table, described, written, read."""

import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from joblib import cpu_count

from skewbridge.demands.columns import SUITE, demands_for, unit_of
from skewbridge.demands.completeness import BEYOND_MODEL, with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.digests import provenance
from skewbridge.files.tables import frame_of, read_table, records_of, texts_of, write_frame
from skewbridge.files.text import writable_folder, write_text
from skewbridge.fragility import demand_table
from skewbridge.fragility.curves import CURVE_COLUMNS, described_as_curves, fit_study
from skewbridge.fragility.effects import EFFECT_COLUMNS, INTENSITY_COLUMNS, effect_tables
from skewbridge.fragility.joint import JOINT_COLUMNS, joint_table
from skewbridge.fragility.limit_states import (
    COLUMN_FAILURE,
    SHEAR_MODEL_DISPERSION,
    LimitState,
    load_limit_states,
    with_column_failure,
)
from skewbridge.fragility.measures import MEASURE_COLUMNS, measure_table
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.paper_table import (
    chosen_curves,
    latex_table,
    paper_columns,
    paper_table,
    printed_rows,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.suites import SUITE_COLUMNS, suite_tables
from skewbridge.fragility.system import SYSTEM_COLUMNS, system_curves
from skewbridge.fragility.verdicts import NEEDED_COLUMNS, needed_motions
from skewbridge.variant.axes import AXES, axes_of
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS
from skewbridge.variant.random_properties import RANDOM_PROPERTIES, drawn_properties

PAPER_TABLE: Final = "table"
#: Degree of damage whose median is the intensity at which effects on demands are stated.
REFERENCE_STATES: Final = tuple(
    f"{component}/{state}"
    for state in ("moderate", "slight")
    for component in ("column_curvature", "column_drift", "unseating")
)
#: Provenance that all tables of one study share.
_STUDY_KEYS: Final = ("config_digest", "suite_digest", "git_commit", "skewbridge_version")
#: Columns of a table of fits that are values of its intensity measure.
_MEDIAN: Final = re.compile(r"theta(_(?!bound_beta)\w+)?")

#: Descriptions of the columns by table.
DESCRIPTIONS: Final[dict[str, Mapping[str, str]]] = {
    "curves": CURVE_COLUMNS,
    "median_effects": EFFECT_COLUMNS,
    "effects": EFFECT_COLUMNS,
    "intensity_effects": INTENSITY_COLUMNS,
    "needed_motions": NEEDED_COLUMNS,
    "joint": JOINT_COLUMNS,
    "system": described_as_curves("variant bridge abutment") | SYSTEM_COLUMNS,
    "measures": MEASURE_COLUMNS,
    "input_notes": demand_table.NOTE_COLUMNS,
    "suites": SUITE_COLUMNS,
    "suite_curves": CURVE_COLUMNS | {SUITE: SUITE_COLUMNS[SUITE]},
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
    """Return every table of results/fragility by name; an `InputError` names row and column."""
    demand_table.need_columns(demands, demand_table.KEY_COLUMNS)
    states = with_column_failure(limit_states, with_derived_columns(demands.head(0)).columns)
    wanted = list(dict.fromkeys(state.demand for state in states))
    checked = demand_table.prepared(demands, wanted, settings)
    rows = checked.table
    curves = fit_study(rows, states, settings, jobs=jobs)
    medians = median_effects(rows, states, settings, jobs=jobs)
    joint = joint_table(rows, states, curves, settings, jobs=jobs)
    further = [state.demand for state in limit_states]
    names = list(dict.fromkeys((*demands_for("effect", rows.columns), *further)))
    reference = reference_intensities(curves)
    effects, intensities = effect_tables(rows, names, settings, reference_im=reference, jobs=jobs)
    needed = needed_motions(pd.concat([effects, medians], ignore_index=True), rows)
    by_suite, curves_by_suite = suite_tables(
        rows, states, names, settings, together=(medians, effects), jobs=jobs
    )
    ranked = {} if suite is None else {"measures": measure_table(rows, suite, settings)}
    tables = ranked | {
        "curves": curves,
        "median_effects": medians,
        "effects": effects,
        "intensity_effects": intensities,
        "needed_motions": needed,
        "joint": joint,
        "system": system_curves(rows, states, settings, jobs=jobs),
        PAPER_TABLE: paper_table(curves, medians, joint, settings),
        "input_notes": checked.notes,
        "suites": by_suite,
        "suite_curves": curves_by_suite,
    }
    for table in tables.values():
        table.attrs[RANDOM_PROPERTIES] = ", ".join(drawn_properties(map(str, demands))) or "none"
    return tables


def shear_model_medians(demands: pd.DataFrame, settings: FitSettings = DEFAULTS) -> pd.DataFrame:
    """Return the curves of shear failure of a column under each shear model, states by model.

    The demands over capacity are peaks over the same whole histories, so no model censors another.
    Variants whose columns no model lets fail are left out, as are tables without these demands.
    """
    shared: dict[str, Any] = {"component": "column_shear", "threshold": 1.0, "collapse": "peak"}
    states = [
        LimitState(name=name, demand=demand, dispersion=SHEAR_MODEL_DISPERSION, **shared)
        for name, demand in SHEAR_MODEL_DEMANDS.items()
        if demand in demands
    ]
    fails = (demands[[state.demand for state in states]] >= 1.0).any(axis=1)
    rows = demands[demands["variant"].isin(demands.loc[fails, "variant"])]
    if rows.empty:
        return pd.DataFrame(columns=[*CURVE_COLUMNS])
    return chosen_curves(fit_study(rows.assign(**{BEYOND_MODEL: ""}), states, settings))


def reference_intensities(curves: pd.DataFrame) -> dict[tuple[str, str], float]:
    """Return the intensity of the effects by model: mean median of the first `REFERENCE_STATES`.

    States whose median is not below that of column failure are left out: there, half of the runs
    have no complete demands to compare.
    """
    usable = curves[curves["preferred"].to_numpy(dtype=bool)]
    failure = (usable["component"] == COLUMN_FAILURE) & (usable["limit_state"] == "any")
    fails_at = dict(zip(usable[failure]["variant"], usable[failure]["theta"], strict=True))
    limits = np.array([fails_at.get(name, np.inf) for name in usable["variant"]])
    usable = usable[usable["theta"].to_numpy(dtype=np.float64) < limits]
    state = usable["component"] + "/" + usable["limit_state"]
    rank = state.map({name: number for number, name in enumerate(REFERENCE_STATES)})
    keys = list(demand_table.BRIDGE_COLUMNS)
    first = usable.assign(rank=rank, ln_theta=np.log(usable["theta"])).dropna(subset=["rank"])
    ln_theta = first.groupby([*keys, "rank"])["ln_theta"].mean().groupby(level=keys).first()
    return {(str(b), str(a)): float(np.exp(value)) for (b, a), value in ln_theta.items()}


def write_described(frame: pd.DataFrame, path: Path, descriptions: Mapping[str, str]) -> None:
    """Write a table with its provenance and the descriptions of its columns, axes included."""
    axes = {axis.name: f"{axis.description}, {axis.unit}" for axis in axes_of(map(str, frame))}
    texts = provenance(**{RANDOM_PROPERTIES: str(frame.attrs.get(RANDOM_PROPERTIES, "none"))})
    write_frame(frame, path, texts, axes | dict(descriptions))


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write tables as parquet files; the table for publication as CSV and LaTeX."""
    for name, frame in tables.items():
        if name == PAPER_TABLE:
            write_text(folder / f"{name}.csv", frame.to_csv(index=False, float_format="%.6g"))
            write_text(folder / f"{name}.tex", latex_table(frame))
        else:
            write_described(frame, folder / f"{name}.parquet", DESCRIPTIONS.get(name, {}))


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """Tables of a finished study.

    Every frame has ``attrs["units"]``, units by column without ratios and texts, and
    ``attrs["provenance"]``, texts by name. Medians have the unit of their intensity measure.
    """

    folder: Path
    demands: pd.DataFrame  # a row per analysis
    fragility: dict[str, pd.DataFrame]  # by name: curves, effects, intensity_effects, joint ...


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
    """Return the demands of a study; an `InputError` if the folder has none."""
    path = folder / "demands.parquet"
    if path.is_file():
        return path
    raise InputError(f"{folder} has no demands.parquet: give the folder of a study that has run")


def _frame(path: Path) -> pd.DataFrame:
    table = read_table(path)
    schema, frame = table.schema, frame_of(table)
    written = {name: (schema.field(name).metadata or {}).get(b"unit", b"") for name in schema.names}
    units = {name: unit.decode() or unit_of(name) for name, unit in written.items()}
    measures = {unit_of(str(name)) for name in frame["im"].dropna()} if "im" in frame else set()
    if len(measures) == 1:
        of_measure = measures.pop()
        units |= {name: of_measure for name in units if _MEDIAN.fullmatch(name)}
    frame.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    frame.attrs["provenance"] = texts_of(schema)
    return frame


def _tables_of(
    demands: Path, limit_states: Path, im: str | None, **margins: float
) -> tuple[dict[str, pd.DataFrame], str, list[str]]:
    """Return the tables, the intensity measure and the limit states whose demand is missing."""
    states = load_limit_states(limit_states)
    table = demand_table.read_demands(demands, im, [state.demand for state in states])
    usable = [state for state in states if state.demand in table]
    if not usable:
        wanted = ", ".join(dict.fromkeys(state.demand for state in states))
        raise InputError(f"{demands.name} has none of the demands of the limit states: {wanted}")
    measures = list(map(str, table.filter(regex="^im_")))
    if im is None and DEFAULTS.im not in measures and len(measures) != 1:
        raise InputError(f"choose --im: one of {', '.join(measures)}", column="im")
    chosen = im or (DEFAULTS.im if DEFAULTS.im in measures else measures[0])
    if chosen not in table:
        raise InputError(f"no column {chosen!r}; intensities: {', '.join(measures)}", column=chosen)
    settings = replace(DEFAULTS, im=chosen, **margins)
    left_out = [f"{state.key} ({state.demand})" for state in states if state not in usable]
    return fragility_tables(table, usable, settings, jobs=cpu_count()), chosen, left_out


def statistics_of(
    demands: Path,
    out: Path,
    *,
    limit_states: Path,
    im: str | None = None,
    margin: float | None = None,
) -> dict[str, Any]:
    """Write every table of results/fragility from a table of demands, and return their summary.

    Limit states whose demand the table lacks are ``left_out``.

    Raises:
        InputError: A file, column or value is unusable; names row and column.
    """
    if margin is not None and not 0.0 < margin < 1.0:
        raise InputError(f"margin must be within 0..1, got {margin:g}", column="margin")
    margins = {} if margin is None else {"margin": margin, "median_margin": margin}
    tables, measure, left_out = _tables_of(demands, limit_states, im, **margins)
    write_tables(tables, writable_folder(out))
    notes = tables["input_notes"]
    return {
        "tables": {name: len(rows) for name, rows in tables.items()},
        "status": tables["curves"]["status"].value_counts().to_dict(),
        "verdict": tables["effects"]["verdict_family"].value_counts().to_dict(),
        "left_out": left_out,
        "rejected_rows": int((notes["kind"] == "rejected_row").sum()),
        "notes": notes["message"].tolist(),
        "im": measure,
        "out": str(out),
    }


def paper_rows(demands: Path, limit_states: Path, im: str | None = None) -> dict[str, Any]:
    """Return the table for publication as ``rows`` of numbers and as ``shown``, with a title."""
    tables, measure, _ = _tables_of(demands, limit_states, im)
    rows = tables[PAPER_TABLE]
    title = f"medians in {measure}"
    return {"rows": records_of(rows), "shown": printed_rows(rows), "title": title}
