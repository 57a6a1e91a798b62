"""Import and check demands tables; describe the columns of results/fragility (`columns.csv`)."""

import csv
import logging
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from itertools import chain, islice
from pathlib import Path
from time import perf_counter
from typing import Any, Final, NamedTuple, Self

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, model_validator

from skewbridge.demands import validity
from skewbridge.demands.columns import COLUMNS, EVENT
from skewbridge.errors import InputError, did_you_mean
from skewbridge.files.tables import Floats, Index, Mask, as_column, require
from skewbridge.files.text import OPTIONS, shortened
from skewbridge.fragility.motion_means import grouped
from skewbridge.fragility.settings import FitSettings
from skewbridge.statuses import COLLAPSE, OK, STATUSES
from skewbridge.units import split_unit
from skewbridge.variant.axes import AXES, OPTION_AXES, Axis, axes_of, unit_doubts
from skewbridge.variant.random_properties import CHOICE_PREFIX, DRAW_PREFIX

logger = logging.getLogger(__name__)

BRIDGE_COLUMNS: Final = ("bridge", "abutment")
IDENTITY_COLUMNS: Final = ("variant", *BRIDGE_COLUMNS)
LOADING_COLUMNS: Final = ("motion_id", "scale", "incidence_deg")
KEY_COLUMNS: Final = (*IDENTITY_COLUMNS, *LOADING_COLUMNS, "status")
TEXT_COLUMNS: Final = tuple(column.name for column in COLUMNS if column.kind == "text")

#: Largest plausible drift ratio of a completed run.
MAX_DRIFT: Final = 0.2
#: Largest plausible value of a column with one of these endings in a completed run, and its unit.
_LARGEST: Final = 10.0
_NEEDED: Final = {"_m": "metres are needed, not mm or in", "_g": "g is needed, not cm/s2"}
#: Columns of 0 and 1 of other programs, see `with_flags`.
FLAGS: Final = ("collapse", "censored")
#: Other names of our columns in published data sets, as lowercase letters.
ALIASES: Final = {"rightcensored": "censored"} | dict.fromkeys(
    ("record", "recordid", "recordname", "rsn", "gmid", "groundmotion"), "motion_id"
)
#: Limits of the axes in tables of other programs, whose models allow larger skews than ours.
_LIMITS: Final = {axis.name: (axis.low, axis.high) for axis in AXES} | {"skew_deg": (-89.0, 89.0)}
#: Advice for a demand that is infinite because the run collapsed.
WITHOUT_PEAK: Final = "give a collapsed run the status collapse"


@cache
def _descriptions() -> dict[str, dict[str, str]]:
    texts: dict[str, dict[str, str]] = defaultdict(dict)
    with Path(__file__).with_name("columns.csv").open(encoding="utf-8", newline="") as file:
        for table, columns, text in islice(csv.reader(file), 1, None):
            source = text.removeprefix("as in ")
            if columns == "(all)":
                texts[table] |= texts[source]
            for column in columns.split() if columns != "(all)" else ():
                name = column.removesuffix("[_low|_high]")
                texts[table][name] = text if source == text else texts[source][name]
                if name != column:
                    sides = {"low": "lower", "high": "upper"}.items()
                    meaning = f"end of the interval of {name}"
                    texts[table] |= {f"{name}_{end}": f"{side} {meaning}" for end, side in sides}
    return texts


def described(table: str, axes: Sequence[Axis] = AXES) -> dict[str, str]:
    """Return the column descriptions of a table of results/fragility, including its axes."""
    columns: dict[str, str] = {}
    for name, text in _descriptions()[table].items():
        if name != "(axes)":
            columns[name] = text.format(axes=" | ".join(axis.name for axis in axes))
            continue
        for axis in axes:
            unit = f", {axis.unit}".removesuffix(", -")
            columns[axis.name] = text.format(axis=axis, unit=unit)
    return columns


def axis_names(table: pd.DataFrame) -> list[str]:
    """Return the names of the axis columns of a table, in the order of all axes."""
    return [axis.name for axis in axes_of(map(str, table.columns))]


def varying_axes(table: pd.DataFrame) -> list[str]:
    """Return the names of the axis columns with more than one value."""
    return [name for name in axis_names(table) if table[name].nunique() > 1]


def reference_value(values: Iterable[float]) -> float:
    """Return the value of an axis with which others are compared: that nearest to zero.

    Skews of -30 and 30 degrees are compared with 0, because they are mirror images.
    """
    return min(set(values), key=lambda value: (abs(value), -value))


def farthest_value(values: Iterable[float]) -> float:
    """Return the value of an axis farthest from zero, other than its `reference_value` if any."""
    others = set(values)
    reference = reference_value(others)
    return max(others - {reference}, key=lambda value: (abs(value), value), default=reference)


def models_of(table: pd.DataFrame) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Yield bridge and abutment model (a dict), and their rows, for each combination in a table."""
    for (bridge, abutment), rows in table.groupby(list(BRIDGE_COLUMNS), sort=True):
        yield {"bridge": bridge, "abutment": abutment}, rows


def variant_columns(table: pd.DataFrame) -> list[str]:
    """Return the names of the columns that describe a variant: name, bridge, abutment and axes."""
    return [*IDENTITY_COLUMNS, *axis_names(table)]


def variant_values(rows: pd.DataFrame) -> dict[str, object]:
    """Return the values of `variant_columns` for a table with a single variant."""
    return {name: rows[name].iloc[0] for name in variant_columns(rows)}


def demand_columns(demands: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """Return the runs with only ``columns`` and those that every fit needs, for other processes."""
    ratios = validity.FAILURE_DEMANDS.values() if validity.COLUMN_FAILURE_RATIO in columns else ()
    valid = (validity.BEYOND_MODEL, validity.COMPLETE)
    names = dict.fromkeys((*KEY_COLUMNS, *axis_names(demands), *valid, EVENT, *columns, *ratios))
    selected = demands[[name for name in names if name in demands.columns]]
    # texts as Python objects: pandas takes 0.2 ms to compare a hundred of its own strings
    return selected.astype(dict.fromkeys(set(TEXT_COLUMNS) & set(selected), object))


def motion_codes(table: pd.DataFrame) -> Index:
    """Return the number of the motion of each run, 0 .. m - 1, shape (n,)."""
    require(table["motion_id"].notna().to_numpy(), "motion_id", "is missing")
    return np.unique(table["motion_id"].to_numpy(dtype=str), return_inverse=True)[1]


def shaking_codes(table: pd.DataFrame) -> Index:
    """Return the number of the motion and incidence of each run, shape (n,)."""
    return np.asarray(table.groupby(["motion_id", "incidence_deg"]).ngroup(), dtype=np.intp)


def has_common_steps(ln_im: Floats, shaking: Index) -> bool:
    """Return whether all motions have one run, or runs at the same ratios of intensity."""
    counts = np.bincount(shaking)
    if np.ptp(counts) > 0:
        return False
    by_motion = ln_im[np.lexsort((ln_im, shaking))].reshape(counts.size, -1)
    return bool(np.max(np.ptp(np.diff(by_motion), axis=0), initial=0.0) < 1e-6)


def _blocks(table: pd.DataFrame) -> NDArray[np.str_]:
    motion = table["motion_id"].to_numpy(dtype=str)
    if EVENT not in table:
        return motion
    event = table[EVENT].fillna("").to_numpy(dtype=str)
    return np.where(event == "", motion, event)


def block_codes(table: pd.DataFrame) -> Index:
    """Return the `grouped` block of each run, shape (n,): its event if known, else its motion."""
    return grouped(_blocks(table))


def block_names(table: pd.DataFrame) -> list[str]:
    """Return the name of each block: its event, or its first motion."""
    _, first_runs = np.unique(block_codes(table), return_index=True)
    return _blocks(table)[first_runs].tolist()


def need_columns(
    table: pd.DataFrame, columns: Iterable[str], source: str = "the demands table"
) -> None:
    """Check that a table has ``columns``; an `InputError` names the first missing one."""
    names = list(map(str, table.columns))
    for column in columns:
        if column not in table.columns:
            problem = f"{source} has no column {column!r}{did_you_mean(column, names)}"
            raise InputError(f"{problem}; its columns are {names_of(names)}", column=column)


def names_of(columns: Iterable[object]) -> str:
    """Return the names of up to 20 columns for a message."""
    names = list(columns)
    return ", ".join(map(shortened, names[:20])) + (", ..." if len(names) > 20 else "") or "none"


def our_names(columns: Iterable[object], aliases: Mapping[str, str] = ALIASES) -> dict[object, str]:
    """Return our name of each column; another name counts only if no column has ours."""
    names = {column: str(column) for column in columns}
    for column, name in names.items():
        ours = aliases.get(re.sub(r"[\W_]+", "", name.lower()), name)
        names[column] = name if ours in names.values() else ours
    return names


def refuse_misspelt(columns: Iterable[str], present: Iterable[str] = ()) -> None:
    """Refuse columns whose names are almost those of an axis or key that the table lacks.

    ``columns`` are those that no fit would use; ``present`` are other columns of the table. An
    `InputError` names the column. Capitals, blanks and hyphens do not distinguish names.
    """
    unused = list(columns)
    valid = {column.name for column in COLUMNS} | {axis.name for axis in OPTION_AXES}
    expected = (*(axis.name for axis in (*AXES, *OPTION_AXES)), *TEXT_COLUMNS, *KEY_COLUMNS)
    missing = [name for name in dict.fromkeys(expected) if name not in {*unused, *present}]
    for name in unused:
        spelled = re.sub(r"[\s-]+", "_", name.strip().lower())
        # ASSUME names as similar as motion and motion_id mean the same
        nearest = get_close_matches(spelled, missing, n=1, cutoff=0.8) or [
            a.name for a in AXES if a.name in missing and split_unit(a.name)[0] == spelled
        ]
        is_drawn = name.startswith((CHOICE_PREFIX, DRAW_PREFIX))
        if name not in valid and nearest and not is_drawn:
            text = f"column {shortened(name)} is not known: did you mean {nearest[0]}?"
            unit = split_unit(nearest[0])[1]
            is_same = split_unit(spelled)[1] in ("-", unit)
            todo = "Rename" if is_same else f"Convert to {unit}, rename"
            raise InputError(f"{text} {todo} or map the column", column=name)


def unused_notes(columns: Iterable[str]) -> list[str]:
    """Return a note on columns of a foreign table that have none of our names, else no text."""
    known = {column.name for column in COLUMNS} | {axis.name for axis in OPTION_AXES}
    unused = sorted(name for name in columns if name not in known)
    return [f"columns that are not used: {names_of(unused)}"] if unused else []


def percent_notes(name: str, demands: Floats) -> list[str]:
    """Return warnings if demands of completed runs have a wrong unit, or are 0 in failed runs."""
    is_drift = name.lower().endswith(("drift", "drift_ratio"))
    largest = float(np.max(demands[np.isfinite(demands)], initial=0.0))
    notes: list[str] = []
    unit_name = f"{name}_g" if re.fullmatch(r"(?i)(im_)?(pga|p?sa)", name) else name
    requirement = next((text for end, text in _NEEDED.items() if unit_name.endswith(end)), "")
    requirement = "a ratio is needed, not per cent" if is_drift else requirement
    # ASSUME no bridge completes a motion at a drift of 20 %, or at 10 m or 10 g
    if requirement and largest > (MAX_DRIFT if is_drift else _LARGEST):
        notes += [f"{name} is up to {largest:.3g} in completed runs: {requirement}"]
    if is_drift and (zeros := int(np.sum(demands == 0.0))):
        notes += [f"{name} is 0 in {zeros} completed runs: give failed runs their status"]
    return notes


class ColumnMap(BaseModel):
    """A file that maps the columns of a foreign table to those of a demands table."""

    model_config = OPTIONS | ConfigDict(frozen=True, strict=True)

    columns: dict[str, str]
    """column of the file for each column of the demands table"""
    factors: dict[str, float] = {}
    """factor that converts to the unit of the demands table, for each of its columns"""
    constants: dict[str, str | float] = {}
    """value of each column of the demands table that is not in the file"""

    @model_validator(mode="after")
    def _known_names(self) -> Self:
        if unknown := self.factors.keys() - self.columns.keys():
            raise ValueError(f"factors: {names_of(sorted(unknown))} is not a key of columns")
        if doubled := self.constants.keys() & self.columns.keys():
            raise ValueError(f"constants: {names_of(sorted(doubled))} is also in columns")
        return self


def read_foreign(path: Path, source: pd.DataFrame, names: ColumnMap) -> pd.DataFrame:
    """Return the runs of another program, the rows of a file, as a demands table.

    ``names`` need motion_id, an intensity im_... and a demand. A missing column ``variant`` is
    composed of bridge, abutment and axis values; `with_flags` gives the column ``complete``.
    Missing intensities and demands stay NaN; `prepared` handles them. An `InputError` names row and
    column of an unusable value.
    """
    columns = names.columns
    unused = [str(name) for name in source if name not in columns.values()]
    renamed = (name for name in columns if name not in source)
    used = {*columns, *names.constants}
    refuse_misspelt([*unused, *renamed], used)
    if unmapped := sorted({*_LIMITS, *LOADING_COLUMNS, "status"}.intersection(unused) - used):
        text = f"column {unmapped[0]} must be mapped, or given as a constant"
        raise InputError(text, column=unmapped[0])
    need_columns(source, columns.values(), path.name)
    out = pd.DataFrame({column: source[foreign_name] for column, foreign_name in columns.items()})
    if "motion_id" not in out or not any(str(name).startswith("im_") for name in out):
        text = "a column motion_id and an intensity column im_... are needed"
        raise InputError(f"{text}; the columns of {path.name} are {names_of(source)}")
    defaults = {"scale": 1.0, "incidence_deg": 0.0, "status": OK, **names.constants}
    for name, value in {**dict.fromkeys(BRIDGE_COLUMNS, "foreign"), **defaults}.items():
        if name not in out:
            out[name] = value
    options = [name for name in map(str, out) if name.startswith(CHOICE_PREFIX)]
    for name in out.columns.difference([*TEXT_COLUMNS, *options]):
        numbers = as_column(out[name].to_numpy(), columns.get(name, name))
        out[name] = numbers * names.factors.get(name, 1.0)
    for name in (*LOADING_COLUMNS, *axis_names(out), "status"):
        require(out[name].notna().to_numpy(), columns.get(name, name), "is missing")
    for name, (low, high) in _LIMITS.items():
        if name in out:
            in_range, values = out[name].between(low, high).to_numpy(), out[name].to_numpy()
            require(in_range, columns.get(name, name), f"must be within {low:g}..{high:g}", values)
    for text in unit_doubts(*(out.get(name, []) for name in ("skew_deg", "gap_mm"))):
        logger.warning("%s: %s", path.name, text)
    if validity.BEYOND_MODEL in out:
        in_range = np.isin(validity.failure_kinds(out), ["", *validity.FAILURE_DEMANDS])
        words = " or ".join(validity.FAILURE_DEMANDS)
        require(in_range, validity.BEYOND_MODEL, f"must be {words}, or empty")
    if "variant" not in out:
        parts = [out[name].map(str).tolist() for name in variant_columns(out)[1:]]
        out["variant"] = ["_".join(values) for values in zip(*parts, strict=True)]
    texts = [*(name for name in TEXT_COLUMNS if name in out), *options]
    out[texts] = out[texts].astype(object).fillna("").astype(str)
    out = with_flags(out)
    for name in map(str, out.filter(regex="^im_")):
        values = out[name].to_numpy()
        good = np.isnan(values) | ((values > 0.0) & (values < np.inf))
        require(good, name, "must be > 0 and finite", values)
    if EVENT in out and (several := out.groupby("motion_id")[EVENT].nunique() > 1).any():
        name = shortened(several.idxmax())
        raise InputError(f"motion {name} has several events: give it the same one in all rows")
    key = ["variant", *LOADING_COLUMNS]
    if "scale" not in used and out.duplicated(key).any():
        # ASSUME one motion was scaled, as in stripes, if its runs have several intensities
        im = next(name for name in map(str, out) if name.startswith("im_"))
        out["scale"] = (out[im] / out.groupby("motion_id")[im].transform("min")).fillna(1.0)
        text = f"a motion has several runs: scale is its {im} over the smallest one"
        logger.warning("%s: %s", path.name, text)
    if (doubled := out.duplicated(key)).any():
        row = int(np.argmax(doubled))
        text = f"row {row} repeats variant, motion_id, scale and incidence_deg of another row"
        absent = [name for name in LOADING_COLUMNS if name not in used]
        advice = f", or add {names_of(absent)} if the runs differ in them"
        text += ": remove it" + advice * bool(absent)
        text += f", or use a column as axis: {names_of(unused)}" * bool(unused)
        raise InputError(text, row=row)
    distinct = out[variant_columns(out)].drop_duplicates()
    if (same := distinct[distinct.duplicated(variant_columns(out)[1:], keep=False)]).size:
        text = f"variants {names_of(same['variant'])} have the same bridge, abutment and axes: "
        text += "give them other bridge names or the axis in which they differ"
        raise InputError(text, column="variant")
    first = [*variant_columns(out), *LOADING_COLUMNS, "status"]
    return out[[*first, *(name for name in out if name not in first)]].reset_index(drop=True)


def with_flags(runs: pd.DataFrame) -> pd.DataFrame:
    """Return runs with the columns `FLAGS`, if any, expressed by ``status`` and `COMPLETE`.

    A missing status is ok, a missing flag is 0. A failed run with a collapse keeps its status.
    """

    def is_set(name: str, default: float = 0.0) -> Mask:
        values = as_column(runs.get(name, pd.Series(default, runs.index)).to_numpy(), name)
        values = np.nan_to_num(values, nan=default)
        require(np.isin(values, (0.0, 1.0)) | (name not in FLAGS), name, "must be 0 or 1", values)
        return values > 0.0

    status = runs.get("status", pd.Series(OK, runs.index))
    require_statuses(status)
    status = status.mask(is_set("collapse") & (status == OK), COLLAPSE)
    out = runs.drop(columns=[*FLAGS], errors="ignore").assign(status=status.astype(object))
    has_flag = validity.COMPLETE in out
    complete = is_set(validity.COMPLETE, 1.0) if has_flag else validity.is_complete(out)
    return out.assign(**{validity.COMPLETE: complete & ~is_set("censored")})


def require_statuses(status: pd.Series) -> None:
    """Raise an `InputError` with the allowed words if a status is not known."""
    is_valid = status.isin(STATUSES).to_numpy()
    if not is_valid.all():
        wrong = shortened(status.iloc[int(np.argmin(is_valid))])
        require(is_valid, "status", f"must be one of {', '.join(STATUSES)}, got {wrong}")


class Prepared(NamedTuple):
    """A checked demands table and notes about it."""

    table: pd.DataFrame  # rows to fit, numbered from 0, with `COLUMN_FAILURE_RATIO`
    notes: pd.DataFrame  # table `input_notes`: rejected rows, missing demands, repeated motions


def prepared(demands: pd.DataFrame, columns: Sequence[str], settings: FitSettings) -> Prepared:
    """Check a demands table and return the rows that can be fitted.

    Rows without a positive intensity are rejected. Completed runs without a demand are not used for
    that demand. The notes list both.
    An `InputError` names a missing column, an unknown status, or an infinite or negative demand.
    """
    checked = [name for name in dict.fromkeys(columns) if name != validity.COLUMN_FAILURE_RATIO]
    need_columns(demands, (*KEY_COLUMNS, settings.im, *checked))
    refuse_misspelt(name for name in map(str, demands) if name not in checked)
    table = demands.reset_index(drop=True)
    status = table["status"].to_numpy(dtype=str)
    require_statuses(table["status"])
    for name in checked:
        values = table[name].to_numpy(dtype=np.float64)
        bad = (status == OK) & (np.isinf(values) | (values < 0.0))
        if np.any(bad):
            row = int(np.argmax(bad))
            rule = (
                f"must be >= 0 and finite where status is ok (peaks are absolute; {WITHOUT_PEAK})"
            )
            where = "row {} ({variant}, {motion_id})".format(row, **table.iloc[row])
            raise InputError(f"{name} {rule}, got {values[row]:g} in {where}", row=row, column=name)
    table = validity.with_derived_columns(table)
    im = table[settings.im].to_numpy(dtype=np.float64)
    has_im = np.isfinite(im) & (im > 0.0)
    if not has_im.any():
        raise InputError(f"no row has a finite {settings.im} above 0", column=settings.im)
    notes: list[tuple[object, ...]] = [
        ("rejected_row", row, settings.im, f"row {row}: {settings.im} is {im[row]:g}, not above 0")
        for row in np.flatnonzero(~has_im).tolist()
    ]
    table = table[has_im]
    notes += [*_missing_demands(table, checked), *_equal_motions(table, [settings.im, *checked])]
    complete = table[validity.is_complete(table)]
    largest = complete.groupby(list(BRIDGE_COLUMNS))[[*checked, settings.im]].transform("max")
    for name in (*checked, settings.im):
        # a demand that is 0 in all runs of a bridge has no meaning, such as drifts without columns
        values = complete.loc[largest[name] > 0.0, name].to_numpy(dtype=np.float64)
        notes += [("percent", -1, name, text) for text in percent_notes(name, values)]
    if text := intensity_change(table, BRIDGE_COLUMNS, settings.im):
        notes += [("percent", -1, settings.im, f"{text}: same measure, and same scale?")]
    notes_table = pd.DataFrame(notes, columns=list(described("input_notes")))
    return Prepared(table.reset_index(drop=True), notes_table)


def intensity_change(runs: pd.DataFrame, keys: Sequence[str], im: str) -> str:
    """Return how much an intensity differs under one motion, in words; empty if by rounding."""
    of_motion = runs.groupby([*keys, *LOADING_COLUMNS])[im]
    change = float((of_motion.max() / of_motion.min()).max()) - 1.0
    # ASSUME rounding changes the intensity of a motion by less than 1 %
    return f"{im} differs by up to {change:.0%} under one motion" if change > 0.01 else ""


def _missing_demands(table: pd.DataFrame, columns: Sequence[str]) -> Iterator[tuple[object, ...]]:
    """Yield a row of `input_notes` for each demand that some completed runs of a bridge lack."""
    runs = table[validity.is_complete(table)]
    models = runs.groupby(list(BRIDGE_COLUMNS))
    for name in columns:
        incomplete = runs[runs[name].isna() & (models[name].transform("count") > 0)]
        keys = zip(incomplete.index, incomplete["variant"], incomplete["motion_id"], strict=True)
        for row, variant, motion in keys:
            text = f"{name} is missing for {variant} under {motion}: {WITHOUT_PEAK}"
            yield "missing_demand", int(row), name, text


def _equal_motions(table: pd.DataFrame, columns: Sequence[str]) -> Iterator[tuple[object, ...]]:
    """Yield a row of `input_notes` for each motion whose runs are equal to those of another."""
    if len(columns) < 2:
        return
    rows = pd.util.hash_pandas_object(table[["variant", *columns]], index=False).sort_values()
    first_motions: dict[tuple[int, ...], str] = {}
    for motion, runs in rows.groupby(table["motion_id"].astype(str), sort=True):
        earlier = first_motions.setdefault(tuple(runs), str(motion))
        if earlier != motion:
            text = f"motions {earlier} and {motion} have identical runs: intervals are too "
            yield "equal_motions", -1, "motion_id", f"{text}narrow if a motion was entered twice"


def spread[Item, Result](
    function: Callable[[Item], Result],
    items: Iterable[Item],
    jobs: int,
    *,
    alone_s: float = 0.5,  # ASSUME starting processes takes about a second
) -> list[Result]:
    """Return function(item) of all items in order, in parallel after ``alone_s`` seconds."""
    results: list[Result] = []
    remaining, end = iter(items), perf_counter() + alone_s
    while following := list(islice(remaining, 2)):
        if jobs > 1 and len(following) > 1 and perf_counter() >= end:
            tasks = (delayed(function)(item) for item in chain(following, remaining))
            return results + list(Parallel(n_jobs=jobs)(tasks))
        results += map(function, following)
    return results
