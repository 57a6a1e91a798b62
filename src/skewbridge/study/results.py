"""Tables of a study, fits to demands from other programs, predictions and comparisons."""

import logging
import re
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from joblib import cpu_count

from skewbridge.demands.columns import COLUMNS, demands_for, label_of, unit_of
from skewbridge.demands.validity import with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.digests import provenance
from skewbridge.files.tables import (
    Row,
    frame_of,
    positive,
    read_any,
    read_frame,
    read_stamp,
    read_table,
    records_of,
    texts_of,
    write_frame,
)
from skewbridge.files.text import writable_folder, write_text
from skewbridge.fragility import demand_table, effects, rates
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.exports import EXTRAPOLATED
from skewbridge.fragility.fits import BOUNDS_TOO_WIDE, FITTED
from skewbridge.fragility.hazard import hazard_curve
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.limit_states import (
    LimitState,
    States,
    load_limit_states,
    with_column_failure,
)
from skewbridge.fragility.motion_means import Jackknifed, covered_range
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.fragility.study_tables import fragility_tables, write_tables
from skewbridge.study.config import stored_configuration
from skewbridge.study.folder import StudyFolder, starter_files
from skewbridge.variant.random_properties import CHOICE_PREFIX, DRAW_PREFIX, RANDOM_PROPERTIES

logger = logging.getLogger(__name__)

#: Provenance of demands written by `skewbridge statistics`: the name of their source.
_STATISTICS_OF: Final = "statistics_of"
#: Columns of `Results.at` in the unit of the demand.
_AT: Final = ("median", "ci_low", "ci_high", "p16", "p84")
#: Columns of fits that have the unit of the intensity measure.
_MEDIAN: Final = re.compile(r"theta(_\w+)?")


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Results:
    """Tables of a finished study.

    Every frame has two dictionaries: ``attrs["units"]`` (unit of each column, except ratios and
    texts) and ``attrs["provenance"]``. Medians have the unit of their intensity measure.
    """

    folder: Path
    demands: pd.DataFrame  # one row per analysis
    fragility: dict[str, pd.DataFrame]  # by name: curves, effects, intensity_effects, joint ...

    def __repr__(self) -> str:
        """Return the folder, the numbers of runs, variants and motions, and names of tables."""
        names = [name for name in ("variant", "motion_id") if name in self.demands]
        counts = "".join(f", {self.demands[n].nunique()} {n.removesuffix('_id')}s" for n in names)
        tables = ", ".join(self.fragility) or "no tables of fits"
        return f"Results({self.folder}: {len(self.demands)} runs{counts}; {tables})"

    def at(self, demand: str, im: float, **chosen: Any) -> pd.DataFrame:
        """Return the median of a demand at one intensity, one row per variant.

        ``chosen`` selects variants, such as ``bridge="osb1", skew_deg=[0, 60]``. The median has its
        95 % interval (jackknife over motions); ``p16`` and ``p84`` are the range of single motions.
        Demands of runs that ended early are lower bounds. ``extrapolated`` is true if fewer than
        three motions are as strong, or as weak, as ``im``. `InputError` for a wrong name or value.
        """
        positive([im], "im")
        runs, measure = self.demands, _measure(self.folder) or DEFAULTS.im
        demand_table.need_columns(runs, (demand, measure, *chosen))
        runs = runs[(runs[measure] > 0.0) & runs[demand].notna()]
        least = float(runs[demand][runs[demand] > 0.0].min())  # zero demands lie below it
        peak: Any = {"demand": demand, "threshold": least, "dispersion": 0.0, "collapse": "peak"}
        state, ln_im, rows = LimitState(component="", name="", **peak), np.array(np.log(im)), []
        for models in fit_models(runs, [state], replace(DEFAULTS, im=measure)):
            used = models.runs[measure].to_numpy(dtype=np.float64)
            low, high = covered_range(used, demand_table.motion_codes(models.runs))
            for row in records_of(models.variants):
                row |= {"im": im, **dict.fromkeys(_AT), EXTRAPOLATED: not low <= im <= high}
                if not isinstance(fit := models.fit(state), str):
                    point = fit.model.at(row)
                    logs = Jackknifed.of_replicates(point.ln_demand(ln_im), fit.model.axes.drifts)
                    median, *ends = logs.exp_interval(DEFAULTS.confidence)
                    spread = median * np.exp(point.scatter(ln_im)[0] * np.array([-1.0, 1.0]))
                    row |= zip(_AT, (median, *ends, *spread), strict=True)
                rows.append(row)
        table = pd.DataFrame(rows)
        for name, values in chosen.items():
            known, wanted = sorted(set(table[name])), np.atleast_1d(values).tolist()
            if absent := [value for value in wanted if value not in known]:
                text = f"{name} must be one of {', '.join(map(str, known))}; got {absent[0]!r}"
                raise InputError(text, column=name)
            table = table[table[name].isin(wanted)]
        units = {str(name): unit_of(str(name)) for name in table} | {"im": unit_of(measure)}
        table.attrs["units"] = units | dict.fromkeys(_AT, unit_of(demand))
        return table


def load_results(folder: Path) -> Results:
    """Read the demands of a study and all tables of its fits.

    Warns (`UserWarning`) when tables have different configurations, motions, commits or versions.
    `InputError` without demands, or for a damaged table or another version.
    """
    demands = _frame(demands_file(folder))
    fits = {file.stem: _frame(file) for file in sorted(folder.glob("fragility/*.parquet"))}
    mixed_keys: list[str] = []
    for key in ("config_digest", "suite_digest", "git_commit", "skewbridge_version"):
        tables: dict[str, list[str]] = {}
        for name, table in {"demands": demands, **fits}.items():
            tables.setdefault(table.attrs["provenance"].get(key, "unknown"), []).append(name)
        if len(tables) > 1:
            texts = (f"{value[:12]} ({', '.join(names)})" for value, names in tables.items())
            mixed_keys.append(f"{key} {', '.join(texts)}")
    if mixed_keys:
        warnings.warn(
            f"{folder}: tables were made by different versions or inputs (expected after a change "
            "that repeats only the fits; `skewbridge provenance FILE` shows whether a table is "
            f"current): {'; '.join(mixed_keys)}",
            stacklevel=3,
        )
    return Results(folder=folder, demands=demands, fragility=fits)


def demands_file(folder: Path) -> Path:
    """Return the path of the demands of a study; `InputError` if the folder has none."""
    if (path := folder / "demands.parquet").is_file():
        return path
    raise InputError(f"{folder} has no demands.parquet: give the folder of a study that has run")


def _frame(path: Path) -> pd.DataFrame:
    table = read_table(path)
    frame = frame_of(table)
    written = {field.name: (field.metadata or {}).get(b"unit", b"") for field in table.schema}
    units = {name: unit.decode() or unit_of(name) for name, unit in written.items()}
    measures = {unit_of(str(name)) for name in frame["im"].dropna()} if "im" in frame else set()
    if len(measures) == 1:
        units |= dict.fromkeys(filter(_MEDIAN.fullmatch, units), measures.pop())
    frame.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    frame.attrs["provenance"] = texts_of(table.schema)
    return frame


def _measures(source: pd.DataFrame) -> list[str]:
    return list(map(str, source.filter(regex="^im_")))


def _default_measure(measures: Sequence[str]) -> str:
    return measures[0] if len(measures) == 1 else DEFAULTS.im


def _read_demands(
    path: Path, source: pd.DataFrame, im: str | None, states: States
) -> tuple[pd.DataFrame, str, list[str]]:
    """Return the table read by `read_foreign`, its intensity measure, a note on other columns."""
    source = source.rename(columns=demand_table.our_names(source))
    if "collapse" not in source:
        demand_table.need_columns(source, ["status"], path.name)
    measures = _measures(source)
    im_column = im or _default_measure(measures)
    if measures and im_column not in source:
        problem = f"{path.name} has {f'no column {im!r}' if im else 'several intensities'}"
        text = "choose with --hazard, in `statistics` also with --im, one of"
        raise InputError(f"{problem}: {text} {', '.join(measures)}", column=im or "im")
    wanted = {column.name for column in COLUMNS} | {*demand_table.axis_names(source), im_column}
    wanted |= {*demand_table.FLAGS, *(state.demand for state in states)}
    prefixes = ("im_", CHOICE_PREFIX, DRAW_PREFIX)
    names = {n: n for n in map(str, source) if n in wanted or n.startswith(prefixes)}
    unused = demand_table.unused_notes(set(map(str, source)) - names.keys())
    columns = demand_table.ColumnMap(columns=names)
    return demand_table.read_foreign(path, source, columns), im_column, unused


def _states_path(path: Path) -> Path:
    """Return a file of limit states, or that of the package if the default file is missing."""
    default = Path(DEFAULTS.limit_states)
    return starter_files() / default if path == default and not path.is_file() else path


def statistics_of(
    demands: Path, out: Path, limit_states: Path, im: str | None = None, hazard: Path | None = None
) -> dict[str, Any]:
    """Write demands and fragility/ of a study from a table of demands; return their summary.

    ``left_out`` are limit states without their demand. With a hazard curve, the curves are for its
    intensity measure. `InputError` for an invalid value, or a folder with a study.
    """
    folder = StudyFolder(writable_folder(out))
    if folder.demands.is_file() and not is_from_statistics(out):
        raise InputError(f"{out} is the folder of a study with demands: choose another folder")
    states_file = _states_path(limit_states)
    states = load_limit_states(states_file)
    source = read_any(demands)
    measures = [im] if im else _measures(source)
    curve = hazard_curve(hazard, measures, _default_measure(measures))
    table, measure, unused = _read_demands(demands, source, curve.im if curve else im, states)
    available = [state for state in states if state.demand in table]
    if not available:
        names = ", ".join(dict.fromkeys(state.demand for state in states))
        raise InputError(f"{demands.name} has none of the demands of the limit states: {names}")
    settings = replace(DEFAULTS, im=measure)
    tables = fragility_tables(table, available, settings, hazard=curve, jobs=cpu_count())
    notes, texts = tables["input_notes"], {name: label_of(name) for name in map(str, table)}
    write_frame(table, folder.demands, provenance(**{_STATISTICS_OF: demands.name}), texts)
    write_tables(tables, folder.fragility("curves").parent)
    write_text(folder.limit_states, states_file.read_text("utf-8"))
    return {
        "tables": {name: len(rows) for name, rows in tables.items()},
        "status": tables["curves"]["status"].value_counts().to_dict(),
        "verdict": tables["effects"]["verdict_family"].value_counts().to_dict(),
        "left_out": [f"{state.key} ({state.demand})" for state in states if state not in available],
        "rejected_rows": int((notes["kind"] == "rejected_row").sum()),
        "notes": unused + notes["message"].tolist(),
        "warnings": [
            *filter(None, (state.doubt for state in available)),
            *notes.loc[notes["kind"].isin(["percent", "together", "hazard"]), "message"],
        ],
        **{"im": measure, "out": str(out)},
    }


def is_from_statistics(folder: Path) -> bool:
    """Return whether `statistics_of` wrote the demands in a folder."""
    path = StudyFolder(folder).demands
    return path.is_file() and _STATISTICS_OF in read_stamp(path)


# ---- Comparison of two studies

#: Name of the axis of a comparison: 0 is the first study, 1 the second.
STUDY: Final = "study"


class StudyComparison(NamedTuple):
    """Tables of the changes from a first study to a second study."""

    im: str  # intensity measure of the medians
    demands: pd.DataFrame
    medians: pd.DataFrame
    rates: pd.DataFrame  # empty without a hazard curve
    counts: dict[str, int]  # pairs, runs in one only, shared variants and motions, equal pairs
    other_motions: tuple[str, ...]  # left out: same name in both studies, different files
    warnings: tuple[str, ...]  # on units of demands, intensities that differ, and hazard


def compare_studies(first: Path, second: Path, hazard: Path | None = None) -> StudyComparison:
    """Compare two studies, each given by its folder or its demands; ratios are second / first.

    Limit states are those of the first study, and so is the intensity measure without a hazard.
    Runs are paired if bridge, abutment model, axes, motion, scale and incidence agree. Motions with
    the same name are left out if their files differ. A pair in which one run ended early gives a
    bound.
    """
    states = load_limit_states(_states_path(_states_file(first)))
    paths = [study if study.is_file() else demands_file(study) for study in (first, second)]
    sources = list(map(read_any, paths))
    measures = _measures(sources[0])
    own_im = _measure(first)
    site = hazard_curve(hazard, measures, own_im or _default_measure(measures))
    im = site.im if site else own_im
    renamed_files = _other_motions(first, second)
    from_demands, measure, _ = _read_demands(paths[0], sources[0], im, states)
    to_demands, *_ = _read_demands(paths[1], sources[1], measure, states)
    tables: list[pd.DataFrame] = []
    for number, table in enumerate((from_demands, to_demands)):
        table = with_derived_columns(table[~table["motion_id"].isin(renamed_files)])
        # other variants than those of the other study: both, or neither, may have a curve
        names = f"{number} " + table["variant"].astype(str)
        tables.append(table.assign(**{STUDY: number, "variant": names}))
    settings = replace(DEFAULTS, im=measure)
    common = set(tables[0].columns) & set(tables[1].columns)
    states = [s for s in with_column_failure(states, common) if s.demand in common]
    names = list(demands_for("effect", sorted(common)))
    columns = list(dict.fromkeys([*names, *(state.demand for state in states), measure]))
    demands = pd.concat(tables, ignore_index=True)
    pairs = effects.run_pairs(demands, STUDY, columns)
    if pairs.empty:
        raise InputError(_nothing_shared(tables[0], tables[1], demand_table.axis_names(demands)))
    change = {"axis": STUDY, "from_value": 0.0, "to_value": 1.0}
    rows: list[Row] = []
    for model, model_pairs in demand_table.models_of(pairs):
        named = effects.Pairs(model | change, model_pairs)
        rows += effects.demand_effects(named, names=names, settings=settings, reference_im={})[0]
    variant_keys = [*demand_table.BRIDGE_COLUMNS, *demand_table.axis_names(demands)]
    paired = demands.merge(pairs[[*variant_keys, *demand_table.LOADING_COLUMNS]].drop_duplicates())
    runs, notes = demand_table.prepared(paired, [state.demand for state in states], settings)
    to_runs, from_runs = (pairs[[f"{name}_{end}" for name in names]] for end in ("to", "from"))
    is_equal = (to_runs == from_runs.to_numpy()) | (to_runs.isna() & from_runs.isna().to_numpy())
    is_equal["complete"] = pairs["complete_to"] == pairs["complete_from"]
    doubts = notes.loc[notes["kind"] == "percent", "message"].tolist()
    models = fit_models(runs, states, settings, further=[STUDY], jobs=cpu_count())
    curves = fit_study(models, states, settings, jobs=cpu_count())
    with_curves: Any = {"curves": curves, "axes": [STUDY]}
    site_rates = pd.DataFrame()
    if site is not None:
        site_rates = rates.rate_effects(models, states, site, settings, **with_curves)
        chosen = curves.loc[curves["preferred"], ["component", "limit_state"]]
        rated = rates.rates_of_curves(curves.loc[chosen.index], models, states, site)
        doubts += rates.lacking_notes(records_of(chosen.join(rated)))
    return StudyComparison(
        im=settings.im,
        demands=effects.effect_table(demands, rows),
        medians=effects.median_effects(models, states, settings, **with_curves),
        rates=site_rates,
        counts={
            "pairs": len(pairs),
            "only_first": len(tables[0]) - len(pairs),
            "only_second": len(tables[1]) - len(pairs),
            "variants": len(pairs[variant_keys].drop_duplicates()),
            "motions": int(pairs["motion_id"].nunique()),
            "equal_pairs": int(is_equal.all(axis=1).sum()),
        },
        other_motions=renamed_files,
        warnings=tuple(dict.fromkeys(doubts)),
    )


def _states_file(study: Path) -> Path:
    if (copied := StudyFolder(study).limit_states).is_file():
        return copied
    settings = DEFAULTS
    with suppress(InputError):  # stored by another version
        if config := stored_configuration(study):
            settings = config.fragility
    return Path(settings.limit_states)


def _measure(study: Path) -> str | None:
    curves = StudyFolder(study).fragility("curves")
    measures = read_frame(curves, ["im"])["im"] if curves.is_file() else ()
    return next(iter(measures), None)


def _other_motions(first: Path, second: Path) -> tuple[str, ...]:
    """Return the motions that have the same name in both studies but different files."""
    suites = [StudyFolder(path).suite for path in (first, second)]
    if not all(suite.is_file() for suite in suites):
        return ()
    tables = [read_frame(suite).drop_duplicates("motion_id") for suite in suites]
    same_id = tables[0].merge(tables[1], on="motion_id", suffixes=("", "_other"))
    return tuple(map(str, same_id["motion_id"][same_id["sha256"] != same_id["sha256_other"]]))


def _nothing_shared(first: pd.DataFrame, second: pd.DataFrame, axes: Sequence[str]) -> str:
    key_columns = {
        "variants": [*demand_table.BRIDGE_COLUMNS, *axes],
        "motions": ["motion_id"],
        "motions with the same scale and incidence": [*demand_table.LOADING_COLUMNS],
    }
    keys_of_studies = {
        name: [table.reindex(columns=columns).drop_duplicates() for table in (first, second)]
        for name, columns in key_columns.items()
    }
    overlap = ", ".join(f"{len(a.merge(b))} {name}" for name, (a, b) in keys_of_studies.items())
    reason = "(the scale of a motion follows from the number of motions and the range of levels)"
    return f"the studies have no run in common; they share {overlap} {reason}"


def joint_rows(
    results: Path,  # folder of a study, or one written by `skewbridge statistics`
    bridge: str | None = None,  # None if the study has only one
    abutment: str | None = None,  # None: the only one, else contact-friction
) -> list[Row]:
    """Return the rows of table `joint` with an estimate for one bridge and abutment model.

    `InputError` for a missing table, bridge or model. Each row has `RANDOM_PROPERTIES`.
    """
    path = StudyFolder(results).fragility("joint")
    if not path.is_file():
        advice = "run the study or skewbridge statistics, or name another folder (--study)"
        raise InputError(f"{path} is missing: {advice}", file=str(path))
    stored = read_table(path)
    drawn = texts_of(stored.schema).get(RANDOM_PROPERTIES, "none")
    table = _chosen(frame_of(stored), "bridge", bridge)
    table = _chosen(table, "abutment", abutment and abutment.replace("-", "_"), "contact_friction")
    estimates = records_of(table[table["status"] == FITTED].assign(**{RANDOM_PROPERTIES: drawn}))
    if not estimates:
        statuses = ", ".join(sorted(set(table["status"])))
        raise InputError(f"no limit state has a median to predict from (status {statuses})")
    if withheld := records_of(table[table["status"] == BOUNDS_TOO_WIDE]):
        names = ", ".join(f"{row['component']} {row['limit_state']}" for row in withheld)
        logger.warning("no curve in any variant (%s): %s", BOUNDS_TOO_WIDE, names)
    return estimates


_STATE_KEYS: Final = [*demand_table.BRIDGE_COLUMNS, "component", "limit_state"]


def withheld_curves(results: Path) -> dict[tuple[str, ...], int]:
    """Return the number of variants with the status `BOUNDS_TOO_WIDE`, keyed by `_STATE_KEYS`."""
    if not (path := StudyFolder(results).fragility("curves")).is_file():
        return {}
    curves = read_frame(path)
    withheld = curves[(curves["method"] == "cloud") & (curves["status"] == BOUNDS_TOO_WIDE)]
    return Counter(withheld[_STATE_KEYS].astype(str).itertuples(index=False, name=None))


def predict_states(
    results: Path,
    values: Mapping[str, float],  # value on each axis
    bridge: str | None = None,  # see `joint_rows`
    abutment: str | None = None,
    *,
    at: float | None = None,  # intensity for `p` (with beta_total), `p_records` (with beta)
    hazard: Path | None = None,  # for the columns of a rate and its shares
) -> list[Row]:
    """Return predictions at a point in the range of a study, one row per fitted limit state.

    ``extrapolated`` and ``p_extrapolated`` are true if fewer than three motions are as strong, or
    as weak, as the median or the intensity ``at``. ``n_withheld`` is the number of variants without
    a curve because unknown outcomes change its median too much. `InputError` as for `joint_rows`,
    or for a value outside the range.
    """
    if at is not None and not 0.0 < at < np.inf:
        raise InputError(f"at must be > 0 and finite, got {at:g}", column="at")
    models = joint_rows(results, bridge, abutment)
    site = hazard_curve(hazard, [models[0]["im"]], models[0]["im"])
    n_withheld, rows = withheld_curves(results), list[Row]()
    for row in models:
        model = JointModel(row)
        model.axis_range.check(values)
        theta, *ends = model.median(values)
        prediction = {"component": row["component"], "state": row["limit_state"], "theta": theta}
        curve = model.curve(values)
        prediction |= {"beta": float(curve.beta[0]), "beta_total": float(curve.total[0])}
        prediction |= {"ci_theta": ends, "level": model.level}
        for name, total in (("p_records", False), ("p", True)):
            prediction[name] = None if at is None else curve.probability(np.log(at), total=total)
        # tables of earlier versions have no range: their medians count as extrapolated
        low, high = row.get("im_low", np.inf), row.get("im_high", -np.inf)
        prediction[EXTRAPOLATED] = not low <= theta <= high
        prediction[f"p_{EXTRAPOLATED}"] = None if at is None else not low <= at <= high
        if site is not None:
            rate = rates.curve_rate(curve, site).interval(model.level)
            prediction |= rates.rate_columns(rate, site, model.level) | rates.rate_shares(
                curve, site, low, high
            )
        prediction["n_withheld"] = n_withheld.get(tuple(row[name] for name in _STATE_KEYS), 0)
        columns = (*demand_table.BRIDGE_COLUMNS, "loo_error", "im", RANDOM_PROPERTIES)
        rows.append(prediction | {name: row[name] for name in columns})
    return rows


def _chosen(table: pd.DataFrame, column: str, name: str | None, default: str = "") -> pd.DataFrame:
    names = sorted(set(table[column].astype(str)))
    if name is None:
        name = names[0] if len(names) == 1 else default
    if name not in names:
        problem = f"got {name!r}" if name else "none was given"
        raise InputError(f"{column} must be one of {', '.join(names)}; {problem}", column=column)
    return table[table[column] == name]
