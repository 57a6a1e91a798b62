"""Create, describe and write all tables of results/fragility from a demands table.

With several suites of motions, each suite is also analysed separately. The motions of two suites
are different events, so the squared error of a difference is the sum of both squared errors. The
interval follows Welch (1947), Biometrika 34, 28-35.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations, permutations
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.demands import validity
from skewbridge.demands.columns import SUITE, demands_for
from skewbridge.files.digests import provenance
from skewbridge.files.tables import Row, records_of, write_frame
from skewbridge.files.text import write_text
from skewbridge.fragility import demand_table, exports, verdicts
from skewbridge.fragility.alternatives import alternative_effects
from skewbridge.fragility.curves import METHODS, fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.effects import effect_tables, median_effects, variant_pairs
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.hazard import HazardCurve
from skewbridge.fragility.joint import joint_table
from skewbridge.fragility.limit_states import COLUMN_FAILURE, States, with_column_failure
from skewbridge.fragility.rates import lacking_notes, rate_effects, rate_table
from skewbridge.fragility.settings import EFFECT_CONFIDENCE, FitSettings
from skewbridge.fragility.system import system_curves
from skewbridge.statuses import OK
from skewbridge.variant.axes import axes_of
from skewbridge.variant.options import SHEAR_MODEL_DEMANDS
from skewbridge.variant.random_properties import RANDOM_PROPERTIES, drawn_properties

PAPER_TABLE: Final = "table"
RATES: Final = ("rates", "rate_effects")
#: States whose median is the reference intensity of effects on demands, in order of preference.
REFERENCE_STATES: Final = tuple(
    f"{component}/{state}"
    for state in ("moderate", "slight")
    for component in ("column_curvature", "column_drift", "unseating")
)
ALL_SUITES: Final = "all"
#: Status of medians that contradict the order of the capacities.
NOT_ORDERED: Final = "not_ordered"
_ESTIMATES: Final = "^((theta|beta|beta_total)(_low|_high)?|var_.*|cov_.*)$"
DEPENDS: Final = "depends on the motions"
NO_DIFFERENCE: Final = "no difference shown"
#: Differences above this number of standard errors are reported; one in 20 exceeds it by chance.
LARGEST_ERRORS: Final = 2.0
_EFFECT: Final = ("bridge", "abutment", "axis", "from_value", "to_value", "quantity", "demand")
DESCRIPTIONS: Final = {
    name: demand_table.described(name)
    for name in (
        *("curves", "median_effects", "effects", "intensity_effects", "needed_motions", "joint"),
        *("system", "input_notes", "suites", "shear_models", "alternatives", *RATES),
    )
} | {PAPER_TABLE: exports.PAPER_COLUMNS}


def fragility_tables(
    demands: pd.DataFrame,
    limit_states: States,
    settings: FitSettings,
    *,
    hazard: HazardCurve | None = None,  # without it, the tables of rates are empty
    jobs: int = 1,
) -> dict[str, pd.DataFrame]:
    """Return a dict of all tables of results/fragility. An `InputError` names row and column."""
    demand_table.need_columns(demands, demand_table.KEY_COLUMNS)
    columns = validity.with_derived_columns(demands.head(0)).columns
    states = with_column_failure(limit_states, columns)
    demand_names = list(dict.fromkeys(state.demand for state in states))
    checked = demand_table.prepared(demands, demand_names, settings)
    rows = checked.table
    models = fit_models(rows, states, settings, jobs=jobs)
    curves = fit_study(models, states, settings, jobs=jobs)
    medians = median_effects(models, states, settings, curves=curves)
    joint = joint_table(models, states, settings, curves=curves, jobs=jobs)
    state_demands = [state.demand for state in limit_states if state.demand in demand_names]
    names = list(dict.fromkeys((*demands_for("effect", rows.columns), *state_demands)))
    reference = reference_intensities(curves)
    effects, intensities = effect_tables(rows, names, settings, reference_im=reference, jobs=jobs)
    system = system_curves(models, states, settings, curves=curves, hazard=hazard, jobs=jobs)
    variants = (model.variants for model in models)
    axes = ((table, axis) for table in variants for axis in demand_table.varying_axes(table))
    bound = dict.fromkeys(axis for table, axis in axes if variant_pairs(table, axis)[1].empty)
    text = "never changes alone: its effect cannot be separated"
    notes: list[tuple[object, ...]] = [("together", -1, a, f"{a} {text}") for a in bound]
    tables = {name: pd.DataFrame(columns=list(DESCRIPTIONS[name])) for name in RATES}
    if hazard is not None:
        tables["rates"] = rate_table(curves, models, states, system, hazard)
        texts = lacking_notes(records_of(tables["rates"]))
        if text := demand_table.intensity_change(rows, (), hazard.im):
            texts += [f"{text}: annual_rate is right for bridges with the T1 of the hazard"]
        notes += [("hazard", -1, "annual_rate", text) for text in texts]
        tables["rate_effects"] = rate_effects(
            models, states, hazard, settings, curves=curves, system=system
        )
    more_notes = pd.DataFrame(notes, columns=list(checked.notes))
    both = pd.concat([effects, medians], ignore_index=True)
    tables |= {
        "curves": curves,
        "median_effects": medians,
        "effects": effects,
        "intensity_effects": intensities,
        "needed_motions": verdicts.needed_motions(both, rows),
        "joint": joint,
        "system": system.drop(columns=["rate", "shares"], errors="ignore"),
        PAPER_TABLE: exports.paper_table(curves, medians, joint),
        "input_notes": pd.concat([checked.notes, more_notes], ignore_index=True),
        "shear_models": shear_model_curves(rows, curves, settings, jobs=jobs),
        "alternatives": alternative_effects(rows),
        "suites": suite_table(rows, states, names, settings, (medians, effects), jobs=jobs),
    }
    for table in tables.values():
        table.attrs[RANDOM_PROPERTIES] = ", ".join(drawn_properties(map(str, demands))) or "none"
    return tables


def shear_model_curves(
    rows: pd.DataFrame, curves: pd.DataFrame, settings: FitSettings, jobs: int = 1
) -> pd.DataFrame:
    """Return the fragility curves of column shear failure, one limit state per shear model.

    ``rows`` is a checked demands table. The demand / capacity ratios are peaks over all steps, even
    after a column failure, so a failure in one shear model does not censor the others. A failure in
    the fitted shear model itself does: its ratio becomes a lower bound. The rows of the shear model
    of the study are those of ``curves``. Variants in which no shear model predicts a failure are
    left out. Without ratios the table is empty.
    """
    failure = with_column_failure([], validity.FAILURE_DEMANDS.values())[0]
    models = {name: demand for name, demand in SHEAR_MODEL_DEMANDS.items() if demand in rows}
    any_fails = (rows[[*models.values()]] > failure.threshold).any(axis=1)
    rows = rows[rows["variant"].isin(rows.loc[any_fails, "variant"])]
    if rows.empty:
        return pd.DataFrame(columns=list(demand_table.described("shear_models")))
    ratio, complete = validity.FAILURE_DEMANDS["shear"], rows[validity.is_complete(rows)]
    of_state = (curves["component"] == COLUMN_FAILURE) & (curves["demand"] == ratio)
    of_study = curves[of_state & curves["variant"].isin(rows["variant"])]
    is_whole = validity.is_complete(rows) | validity.is_beyond_model(rows) & (rows["status"] == OK)
    rows = rows.assign(**{validity.COMPLETE: is_whole})
    fitted: list[pd.DataFrame] = []
    for name, demand in models.items():
        is_equal = complete[demand] == complete[ratio]
        if len(of_study) and len(is_equal) and is_equal.all():
            names = {"component": "column_shear", "limit_state": name, "demand": demand}
            fitted.append(of_study.assign(**names))
            continue
        failed = rows[demand] > failure.threshold
        bounds = rows[demand].mask(failed, np.nextafter(failure.threshold, np.inf))
        runs = rows.assign(**{validity.BEYOND_MODEL: np.where(failed, "shear", ""), demand: bounds})
        state = replace(failure, component="column_shear", name=name, demand=demand)
        models_of_state = fit_models(runs, [state], settings, jobs=jobs)
        fitted.append(fit_study(models_of_state, [state], settings, jobs=jobs))
    groups = pd.concat(fitted, ignore_index=True).groupby("variant", sort=False)
    tables = [_of_one_method(group, rows[rows["variant"] == name]) for name, group in groups]
    return pd.concat(tables, ignore_index=True)


def _of_one_method(curves: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """Return curves of a variant by ``cloud``, or by ``exceedance`` if any shear model prefers it.

    No median is estimated if a demand that is the larger one in every run has the larger median.
    """
    is_preferred = curves["preferred"].to_numpy(dtype=bool) & (curves["method"] == "exceedance")
    table = curves[curves["method"] == METHODS[int(is_preferred.any())]]
    table = table.assign(preferred=table["status"] == FITTED)
    if any(
        row_1["theta"] > row_2["theta"] * (1.0 + 1.0e-9)
        and ((runs[row_1["demand"]] - runs[row_2["demand"]]).dropna() >= 0.0).all()
        for row_1, row_2 in permutations(records_of(table[table["preferred"]]), 2)
    ):
        preferred = table["preferred"].copy()
        table.loc[preferred, table.filter(regex=_ESTIMATES).columns] = np.nan
        table.loc[preferred, ["status", "extrapolated", "preferred"]] = [NOT_ORDERED, False, False]
    return table


def suite_table(
    rows: pd.DataFrame,
    states: States,
    demands: Sequence[str],
    settings: FitSettings,
    all_suites: Sequence[pd.DataFrame],
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the table `suites`: effects in each suite and their differences.

    With fewer than two suites the table is empty. ``rows`` is a checked demands table.
    ``all_suites`` are the effects on medians and demands for the motions of all suites together.
    """
    names = list(dict.fromkeys(rows[SUITE].astype(str))) if SUITE in rows else []
    empty_columns = {"against": "", "verdict": "", "standard_errors": np.nan}
    effect_columns = list(demand_table.described("suites"))
    effects: list[Row] = []
    for name in [*names, ALL_SUITES] if len(names) > 1 else []:
        tables = all_suites
        if name != ALL_SUITES:
            group = rows[rows[SUITE] == name].reset_index(drop=True)
            models = fit_models(group, states, settings, jobs=jobs)
            fitted = fit_study(models, states, settings, jobs=jobs)
            medians = median_effects(models, states, settings, curves=fitted)
            tables = medians, effect_tables(group, demands, settings, jobs=jobs).effects
        for table in tables:
            usable = table[(table["scope"] == "pooled") & (table["status"] == verdicts.OK)]
            usable = usable[usable["ratio"].notna()]  # NaN if zero demands allow only a difference
            effects += [{**row, **empty_columns, SUITE: name} for row in records_of(usable)]
    if not effects:
        return pd.DataFrame(columns=effect_columns)
    compared: list[Row] = []
    for _, group in pd.DataFrame(effects).groupby(list(_EFFECT), sort=False):
        records = {row[SUITE]: row for row in records_of(group)}
        pairs = combinations([name for name in names if name in records], 2)
        compared += [_compared(records[name_1], records[name_2]) for name_1, name_2 in pairs]
    return pd.DataFrame([*effects, *compared], columns=effect_columns)


def _compared(first: dict[str, Any], second: dict[str, Any]) -> dict[str, Any]:
    """Return the row that compares an effect between suites: ratio in the second / the first."""
    degrees = np.array([second["dof"], first["dof"]], dtype=np.float64)
    widths = np.log([row["ci_high"] / row["ci_low"] for row in (second, first)])
    variances = (widths / (2.0 * special.stdtrit(degrees, 0.5 + 0.5 * first["level"]))) ** 2
    error = float(np.sqrt(variances.sum()))
    # source: degrees of freedom by Welch and Satterthwaite
    dof = float(variances.sum() ** 2 / np.sum(variances**2 / degrees))
    change = float(np.log(second["ratio"] / first["ratio"]))
    half_width = float(special.stdtrit(dof, 0.5 + 0.5 * first["level"])) * error
    ratios = np.exp([change, change - half_width, change + half_width])
    n_errors = abs(change) / error if error > 0.0 else np.inf
    row = {name: first[name] for name in (*_EFFECT, "level")}
    row |= dict(zip(verdicts.RATIOS, ratios.tolist(), strict=True))
    row |= {SUITE: second[SUITE], "against": first[SUITE], "standard_errors": n_errors}
    row["n_motions"] = int(first["n_motions"]) + int(second["n_motions"])
    return row | {"verdict": DEPENDS if n_errors > LARGEST_ERRORS else NO_DIFFERENCE}


def valid_tables(
    tables: Mapping[str, pd.DataFrame],
    demands: pd.DataFrame,
    rounds: pd.DataFrame,
    looks: Sequence[int],
) -> dict[str, pd.DataFrame]:
    """Return the tables of `fragility_tables` with intervals valid whenever a study is stopped.

    The effects on demands and medians, the needed motions and the publication table are replaced.
    Their confidence level holds jointly for all ``looks``, the numbers of motions at which verdicts
    are computed. ``rounds`` has the intervals of earlier looks.
    """
    per_motion = verdicts.runs_per_motion(demands)
    effects, medians = (
        verdicts.kept(verdicts.at_looks(tables[name], looks, per_motion), rounds)
        for name in ("effects", "median_effects")
    )
    needed = verdicts.needed_motions(pd.concat([effects, medians], ignore_index=True), demands)
    level = {"level": EFFECT_CONFIDENCE}
    valid = {"effects": effects.assign(**level), "median_effects": medians.assign(**level)}
    paper_rows = exports.paper_table(tables["curves"], valid["median_effects"], tables["joint"])
    return {**tables, **valid, "needed_motions": needed, PAPER_TABLE: paper_rows}


def reference_intensities(curves: pd.DataFrame) -> dict[tuple[str, str], float]:
    """Return the reference intensity of each bridge and abutment model; see `REFERENCE_STATES`.

    It is the geometric mean over variants of the medians of the first state with an estimate. Only
    medians below that of column failure are used, because at least half of the runs above it have
    no complete demands.
    """
    preferred = curves[curves["preferred"].to_numpy(dtype=bool)]
    state = preferred["component"] + "/" + preferred["limit_state"]
    failure_medians = preferred[state == f"{COLUMN_FAILURE}/any"].set_index("variant")["theta"]
    rank = state.map({name: number for number, name in enumerate(REFERENCE_STATES)})
    preferred = preferred.assign(rank=rank, ln_theta=np.log(preferred["theta"]))
    limits = preferred["variant"].map(failure_medians).astype(np.float64).fillna(np.inf)
    preferred = preferred[preferred["theta"].astype(np.float64) < limits]
    keys = list(demand_table.BRIDGE_COLUMNS)  # groupby drops rows without a rank
    ln_theta = preferred.groupby([*keys, "rank"])["ln_theta"].mean().groupby(level=keys).first()
    return {(str(b), str(a)): float(np.exp(value)) for (b, a), value in ln_theta.items()}


def write_described(frame: pd.DataFrame, path: Path, descriptions: Mapping[str, str]) -> None:
    """Write a table with its provenance and the descriptions of its columns, including axes."""
    axes = {axis.name: f"{axis.description}, {axis.unit}" for axis in axes_of(map(str, frame))}
    texts = provenance(**{RANDOM_PROPERTIES: str(frame.attrs.get(RANDOM_PROPERTIES, "none"))})
    write_frame(frame, path, texts, axes | dict(descriptions))


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write the publication table as CSV and LaTeX, and all other tables as parquet files."""
    for name, frame in tables.items():
        if name == PAPER_TABLE:
            write_text(folder / f"{name}.csv", frame.to_csv(index=False, float_format="%.6g"))
            write_text(folder / f"{name}.tex", exports.latex_table(frame))
        else:
            write_described(frame, folder / f"{name}.parquet", DESCRIPTIONS.get(name, {}))
