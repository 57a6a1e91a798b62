"""Published fragility curves and published effects of skew, compared with ours.

`published.csv` holds the curves of Mangalathu (2017) for bridges built after 1991 (era 3: osb1) and
before 1971 (era 1: osb1_era1). Peaks are taken over the whole motion, because the published columns
fail in bending only. If a ratio of medians is outside `RANGE`, each of `CHANGES` is tried alone: it
explains the ratio if the ratio moves into the range or at least half of the way to it. Nothing is
fitted to the published values. The changes are in `published.yaml`. Pages: docs/theory/published.md
and published_skew.md.

`run_skew` compares the effect of skew on median capacities of PEER's bridges A, B and C with the
factor of Hazus. Each of `CHOICES` changes one modelling choice of bridge B.

References:
    Mangalathu (2017), PhD thesis, Georgia Institute of Technology (hdl.handle.net/1853/58291).
    Chen et al. (2025), DesignSafe PRJ-5910 version 1, doi 10.17603/ds2-c73m-nj37.
    FEMA (2022), Hazus 6.1, section 7: `hazus_factor`.
    Kaviani, Zareian and Taciroglu, PEER 2014/01.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
import yaml
from matplotlib.figure import Figure

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.demands.validity import BEYOND_MODEL, COMPLETE
from skewbridge.files.tables import Row, records_of
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.effects import effect_tables, median_effects
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.limit_states import LimitState, hazus_factor
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.system import system_curves
from skewbridge.motions.levels import MotionsConfig
from skewbridge.report.appearance import STYLE
from skewbridge.statuses import OK, RAN
from skewbridge.study.analyses import StudySetup
from skewbridge.study.batch import row_of_task
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import starter_files
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.task import Task, outcome_of
from skewbridge.units import INCH
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.variant import Variant
from skewbridge.verification.registry import Study
from skewbridge.verification.studies.paper_runs import paper_variant
from skewbridge.verification.studies.strong_motions import rows_of_tasks

BRIDGES: Final = {3: "osb1", 1: "osb1_era1"}
RANGE: Final = (0.75, 1.33)
SOURCE: Final = "Mangalathu (2017) in Chen et al. (2025), doi 10.17603/ds2-c73m-nj37"
SYSTEM: Final = "system"
SETTINGS: Final = FitSettings(im="im_sa_1p000_rotd50_g")
_FOLDER: Final = Path(__file__).parents[1]
_DATA: Final = yaml.safe_load((_FOLDER / "published.yaml").read_text("utf-8"))
DEMANDS: Final[dict[str, str]] = _DATA["demands"]
JUDGED: Final[Mapping[str, Sequence[str]]] = _DATA["judged"]
_KEYS: Final = ["component", "state"]
WHOLE: Final = "whole_"  # prefix of columns with peaks of whole motions


@dataclass(frozen=True, slots=True)
class Change:
    """A change of the compared model or capacities that may explain a difference."""

    name: str
    demands: Mapping[str, str] = field(default_factory=dict[str, str])  # replaced, by component
    capacity: str = "capacity"  # column of the published table
    weaker_bearing: bool = False  # 3 in instead of 4 in, moderate damage of era 1
    first_yield: bool = False  # curvature ductility refers to the first yield of a bar
    whole: bool = True  # peaks of the whole motion; if false, up to the failure of a column
    bridges: Mapping[int, str] = field(default_factory=lambda: dict(BRIDGES))  # by era
    gap_mm: int = 25
    keys: str = "sacrificial"


NONE: Final = Change("none")
CHANGES: Final = tuple(Change(**change) for change in _DATA["changes"])


def published_curves() -> pd.DataFrame:
    """Return the published curves: one row per era, component and state."""
    return pd.read_csv(_FOLDER / "published.csv", comment="#")


def _name(row: Mapping[str, Any]) -> str:
    return f"era {row['era']}, {row['component']} {row['state']}"


def run(study: Study) -> None:
    """Run the analyses, fit the curves of both eras with each change, and compare them."""
    published, changes = published_curves(), {change.name: change for change in (NONE, *CHANGES)}
    cases: dict[Any, tuple[Variant, dict[str, str]]] = {}
    for era, (name, change) in product(BRIDGES, changes.items()):
        if era in change.bridges:
            variant = paper_variant(bridge=change.bridges[era], gap_mm=change.gap_mm)
            cases[era, name] = variant, {"keys": change.keys}
    comparisons = [
        medians(published[published["era"] == era], table, era, changes[name])
        for (era, name), table in analysed_demands(study, cases, 24).items()  # motions: 3 blocks
    ]
    study.tables["ratios"] = table = compared(published, pd.concat(comparisons, ignore_index=True))
    unchanged = table[table["change"] == NONE.name]
    for row in records_of(unchanged):
        name, published_g = _name(row), row["median_g"]
        if row["status"] == FITTED:
            text = f"{name}: median in g, ratio {_interval(row)}"
            study.report(text, row["theta"], published_g, SOURCE)
            study.report(f"{name}: dispersion", row["beta"], row["dispersion"], SOURCE)
        else:
            text = f"{name}: lower bound of the median in g, no run reaches the state"
            study.report(text, row["theta_bound"], published_g, SOURCE)
    study.tables["explained"] = explanations(table)
    for row in records_of(study.tables["explained"]):
        name = f"{_name(row)}: ratio {row['ratio']:.2f}"
        best_text = f"best: {row['change']}, {row['changed_ratio']:.2f}"
        if row["state"] in JUDGED.get(row["component"], ()):
            text = f"{name} is inside {RANGE[0]:g} to {RANGE[1]:g} or explained ({best_text})"
            study.holds(text, truth=bool(row["is_explained"]), source=SOURCE)
        else:
            study.report(f"{name}, not judged ({best_text})", row["changed_ratio"], 1.0, SOURCE)
    study.figures["medians"] = _figure(unchanged[unchanged["status"] == FITTED])


def analysed_demands[Key](
    study: Study, cases: Mapping[Key, tuple[Variant, Mapping[str, Any]]], motions: int
) -> dict[Key, pd.DataFrame]:
    """Return a demands table for each case (variant and changed options) under the first motions.

    The tables also have the peaks over the whole motion (prefix ``whole_``).
    """
    bridges = tuple(dict.fromkeys(variant.bridge for variant, _ in cases.values()))
    with TemporaryDirectory() as results:
        config = StudyConfig(
            results=results,
            grid=GridConfig(bridge=bridges),
            motions=MotionsConfig(folder=str(starter_files() / "motions"), count=motions),
        )
        prepare_motions(config)
        setup = StudySetup.of(config)
    tasks = [
        (key, replace(task, options=replace(task.options, **options)))
        for key, (variant, options) in cases.items()
        for task in setup.tasks(variant)
    ]
    rows = rows_of_tasks(study, [task for _, task in tasks], _peaks, len(os.sched_getaffinity(0)))
    tables: dict[Key, list[Row]] = {}
    for (key, task), row in zip(tasks, rows, strict=True):
        tables.setdefault(key, []).append(row_of_task(row, task, row["run_key"]))
    return {key: pd.DataFrame(table) for key, table in tables.items()}


def _peaks(task: Task) -> Row:
    result = task.analyse()
    whole_motion = {f"{WHOLE}{name}": float(peak) for name, peak in result.whole_history.items()}
    return outcome_of(result) | whole_motion


def medians(
    published: pd.DataFrame, demands: pd.DataFrame, era: int, change: Change
) -> pd.DataFrame:
    """Return our medians and dispersions for the published components and the system.

    `theta_bound` is the lower bound of the median if no run reaches the state.
    """
    if change.whole:
        demands = _with_whole_peaks(demands)
    if change.first_yield:
        bridge = load_bridge(change.bridges[era])
        curve = bent_capacity(bridge, 0).curve
        name = DEMANDS["column_curvature"]
        factor = curve.yield_curvature_per_m / curve.first_yield_curvature_per_m
        demands = demands.assign(**{name: demands[name] * factor})
    limits = capacities(published, DEMANDS | dict(change.demands), change.capacity)
    if change.weaker_bearing and era == 1:
        key = "bearing", "moderate"
        limits[key] = replace(limits[key], threshold=0.75 * limits[key].threshold)
    states = list(limits.values())
    rows = prepared(demands, list(dict.fromkeys(state.demand for state in states)), SETTINGS).table
    models = fit_models(rows, states, SETTINGS)
    curves = fit_study(models, states, SETTINGS)
    components = curves[curves["method"] == "cloud"]  # as in the published study
    components = components.drop(columns="beta").rename(columns={"beta_total": "beta"})
    system = system_curves(models, states, SETTINGS).assign(component=SYSTEM)
    all_curves = pd.concat([components, system], ignore_index=True)
    # only counts of exceedances bound the median of a state that no run reaches
    by_outcome = curves[curves["method"] == "exceedance"]
    counts = by_outcome.set_index(["component", "limit_state"])
    keys = pd.MultiIndex.from_frame(all_curves[["component", "limit_state"]])
    bounds = counts["theta_bound_low"].reindex(keys).to_numpy()
    all_curves["theta_bound"] = np.where(all_curves["status"] == FITTED, nan, bounds)
    names = ["status", "theta", "theta_low", "theta_high", "beta", "theta_bound"]
    all_curves = all_curves.rename(columns={"limit_state": "state"})[[*_KEYS, *names]]
    return all_curves.assign(era=era, change=change.name)


def capacities(
    published: pd.DataFrame, columns: Mapping[str, str], name: str = "capacity"
) -> dict[tuple[str, str], LimitState]:
    """Return the limit states of an era for our demands, keyed by component and state.

    `columns` maps components to demands; the column `name` of `published` has the capacities.
    """
    return {
        (row["component"], row["state"]): LimitState(
            component=row["component"],
            name=row["state"],
            demand=columns[row["component"]],
            threshold=row[name] * {"in": INCH, "ratio": 1.0}[row["unit"]],
            dispersion=0.35,  # source: Chen et al. (2025), every capacity
        )
        for row in records_of(published)
        if row["component"] in columns
    }


def compared(published: pd.DataFrame, ours: pd.DataFrame) -> pd.DataFrame:
    """Return the published medians, our medians, and ratios (ours / published) with intervals."""
    table = published.merge(ours, on=["era", *_KEYS], how="inner", sort=False)
    fitted = table["status"] == FITTED
    for end, is_valid in (("", fitted), ("_low", fitted), ("_high", fitted), ("_bound", ~fitted)):
        table[f"ratio{end}"] = (table[f"theta{end}"] / table["median_g"]).where(is_valid)
    return table


def outside(ratio: pd.DataFrame | float) -> Any:
    """Return the logarithmic distance of each ratio from `RANGE`; 0 inside the range."""
    low, high = RANGE
    return np.maximum(np.maximum(np.log(low / ratio), np.log(ratio / high)), 0.0)


def explanations(table: pd.DataFrame) -> pd.DataFrame:
    """Return, for each ratio of `compared`, the change that moves it most towards `RANGE`."""
    ratio_of = table.pivot(index=["era", *_KEYS], columns="change", values="ratio")
    # "none" comes first: `idxmin` then returns it for ratios inside the range
    ratios = ratio_of[list(dict.fromkeys([NONE.name, *table["change"]]))].dropna(subset=[NONE.name])
    distances = outside(ratios)
    nearest, unchanged = distances.idxmin(axis=1), distances[NONE.name]
    closed = (1.0 - distances.min(axis=1) / unchanged).where(unchanged > 0.0)
    changed_ratios = ratios.to_numpy()[np.arange(len(nearest)), ratios.columns.get_indexer(nearest)]
    columns = {"ratio": ratios[NONE.name], "change": nearest, "changed_ratio": changed_ratios}
    is_explained = (unchanged == 0.0) | (closed >= 0.5)
    return pd.DataFrame(columns | {"closed": closed, "is_explained": is_explained}).reset_index()


def _figure(table: pd.DataFrame) -> Figure:
    """Draw the ratio of medians of each state with its interval, in one panel per era."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 4.6), layout="constrained")
        axes = figure.subplots(1, len(BRIDGES), sharex=True)
        for axis, (era, bridge) in zip(axes, BRIDGES.items(), strict=True):
            rows = table[table["era"] == era]
            names = rows["component"].str.replace("_", " ") + ", " + rows["state"]
            axis.axvspan(*RANGE, color="0.55", alpha=0.25, lw=0.0)
            axis.axvline(1.0, color="0.1", lw=0.6)
            axis.hlines(names, rows["ratio_low"], rows["ratio_high"])
            axis.plot(rows["ratio"], names, "o", ms=3.5)
            axis.invert_yaxis()
            axis.set_xscale("log")
            ticks = (0.5, 0.75, 1.33, 2.0, 3.0)
            axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
            axis.minorticks_off()
            axis.set(xlabel="ratio to published median", title=f"{bridge}, era {era}")
    return figure


SKEWS_DEG: Final = (0, 30, 60)
CHOICE_MOTIONS: Final = 8
COMPARED: Final[Sequence[str]] = _DATA["compared"]
#: Modelling choices tried on the bridge `CHOSEN`.
CHOICES: Final[Mapping[str, Mapping[str, Any]]] = _DATA["choices"]
CHOSEN: Final = "bridge_b"
_EFFECT_KEYS: Final = ("bridge", "choice", "skew_deg", "demand")
_EFFECT: Final = ("ratio", "ratio_low", "ratio_high", "n_motions")


def run_skew(study: Study) -> None:
    """Run bridges A to C at all skews, and `CHOSEN` with each choice; report effects of skew."""
    unchanged = {
        (bridge, skew, NONE.name): (paper_variant(bridge=bridge, skew_deg=skew, gap_mm=25), {})
        for bridge, skew in product(("bridge_a", "bridge_b", "bridge_c"), SKEWS_DEG)
    }
    choices = {
        (CHOSEN, skew, choice): (paper_variant(bridge=CHOSEN, skew_deg=skew, gap_mm=25), options)
        for choice, options in CHOICES.items()
        for skew in (SKEWS_DEG[0], SKEWS_DEG[-1])
        if skew or options.keys() <= {"keys"}  # the others have no effect at skew 0
    }
    demands = analysed_demands(study, unchanged, 12)
    at_zero_skew = demands[CHOSEN, 0, NONE.name].head(CHOICE_MOTIONS)
    demands |= analysed_demands(study, choices, CHOICE_MOTIONS)
    for choice in CHOICES:
        demands.setdefault((CHOSEN, 0, choice), at_zero_skew)
    tables = [runs.assign(choice=choice) for (*_, choice), runs in demands.items()]
    table = pd.concat(tables, ignore_index=True)
    ratios, medians = demand_ratios(table), median_factors(table)
    study.tables["demands"], study.tables["medians"] = ratios, medians
    for row in records_of(ratios[ratios["demand"] != "deck_rotation_rad"]):
        text = f"{_case(row)}: {row['demand']}, ratio to skew 0 {_interval(row)}"
        study.report(text, row["ratio"], 1.0, "skew 0, same motions")
    for row in records_of(medians):
        text = f"{_case(row)}: median of {row['demand']}, factor {_interval(row)}"
        source = "Hazus: sqrt(sin(90 deg - skew))"
        study.report(text, row["ratio"], float(hazus_factor(row["skew_deg"])), source)
    for (bridge, skew, choice), runs in demands.items():
        n_ended = int((runs["status"].isin(RAN)).sum())
        text = f"{bridge}, skew {skew}, choice {choice}: analyses that ended ok or in collapse"
        study.absolute(text, n_ended, len(runs), 0.0, "every analysis")


def demand_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Return the (geometric) mean ratio of each demand to its value at skew 0, motion by motion.

    `table` has one row per analysis, with its choice and the peaks over the whole motion.
    """
    # the names with the prefix for whole motions: they are judged by ratios alone
    names = [f"{WHOLE}{name}" for name in COMPARED]
    runs = table.assign(**{"status": OK, COMPLETE: True, BEYOND_MODEL: ""})
    rows = _effects_of_skew(runs, lambda group: effect_tables(group, names, SETTINGS).effects)
    rows["demand"] = rows["demand"].str.removeprefix(WHOLE)
    return rows.assign(mean=rows["from_mean"] * rows["ratio"])[[*_EFFECT_KEYS, "mean", *_EFFECT]]


def median_factors(table: pd.DataFrame) -> pd.DataFrame:
    """Return the factors of skew on median capacities, paired by motion, with their intervals.

    `table` is as in `demand_ratios`; the column `demand` of the result is component/state.
    """
    published = published_curves()
    states = list(capacities(published[published["era"] == 3], DEMANDS).values())

    def effects(group: pd.DataFrame) -> pd.DataFrame:
        rows = prepared(group, list(DEMANDS.values()), SETTINGS).table
        models = fit_models(rows, states, SETTINGS, further=["skew_deg"])
        return median_effects(models, states, SETTINGS, axes=["skew_deg"])

    return _effects_of_skew(_with_whole_peaks(table), effects)[[*_EFFECT_KEYS, *_EFFECT]]


def _with_whole_peaks(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose demands are peaks over the whole motion, even if columns fail."""
    peaks = {name: table[f"{WHOLE}{name}"] for name in DEMANDS.values()}
    return table.assign(**peaks | {BEYOND_MODEL: "", COMPLETE: table["status"] == OK})


def _effects_of_skew(
    table: pd.DataFrame, effects: Callable[[pd.DataFrame], pd.DataFrame]
) -> pd.DataFrame:
    choices = table.groupby("choice", sort=False)
    all_effects = pd.concat([effects(group).assign(choice=choice) for choice, group in choices])
    names = {"to_value": "skew_deg", "ci_low": "ratio_low", "ci_high": "ratio_high"}
    pooled = all_effects[all_effects["scope"] == "pooled"].drop(columns="skew_deg", errors="ignore")
    return pooled.rename(columns=names).reset_index(drop=True)


def _case(row: Mapping[str, Any]) -> str:
    choice = "" if row["choice"] == NONE.name else f", {row['choice']}"
    return f"{row['bridge']}, skew {row['skew_deg']:g}{choice}"


def _interval(row: Mapping[str, Any]) -> str:
    return f"{row['ratio']:.2f} ({row['ratio_low']:.2f} to {row['ratio_high']:.2f})"
