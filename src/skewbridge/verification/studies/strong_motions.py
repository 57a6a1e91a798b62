"""Analyses under strong motions: stress cases, convergence and accuracy of effects.

`run` requires that every analysis ends `ok`, or in a physical `collapse` with a criterion and an
energy balance. `run_convergence` compares demands at the default steps and mesh with those at finer
ones. `run_pairs` compares the effects of friction, gap and skew at the default accuracy with those
at the reference, as ratios of peaks under the same motion. Motions are cut to their strongest part.
Finished analyses are kept in a journal: run the same command to resume. Except in the stress cases,
peaks are taken over the analysed motion even if a column fails.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import inf
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from skewbridge.analysis.recovery import recovery_shares, steps_from_text
from skewbridge.analysis.settings import NUMERICS, Accuracy, AnalysisSettings
from skewbridge.demands.validity import MAX_ENERGY_RESIDUAL
from skewbridge.files.tables import Row
from skewbridge.files.text import read_mapping
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.motions.record import SuiteMotion
from skewbridge.statuses import COLLAPSE, OK
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.processes import hush_exit_message
from skewbridge.study.task import Task, analyse_task, run_key
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import Study
from skewbridge.verification.studies.paper_runs import first_motions, strongest_motions

REPORT_EACH: Final = 10  # analyses between two lines of progress


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseSet:
    """Cases to analyse: every variant of a grid under every chosen motion, cut to `window_s`.

    With `pga_g`, these are the strongest motions of the suite, scaled to this PGA (RotD50). Without
    it, they are the first ones of the suite, with the scale factors of a study.
    """

    grid: GridConfig
    motion_count: int
    pga_g: float | None = None
    window_s: float
    processes: int = 2

    def tasks(self, settings: AnalysisSettings, options: ModelOptions) -> list[Task]:
        """Return the analyses of all cases."""
        if self.pga_g is not None:
            motions = strongest_motions(self.motion_count, self.pga_g)
        else:
            motions = first_motions(self.motion_count)
        cut = [cut_to_strongest(motion, self.window_s, 0.0) for motion in motions]
        suite = [SuiteMotion(motion=motion, scale=1.0, measures={}) for motion in cut]
        fields: Row = {"incidence_deg": 0.0, "settings": settings, "options": options}
        cases = product(expand_grid(self.grid), suite)
        return [Task(variant=variant, motion=motion, **fields) for variant, motion in cases]


def rows_of_tasks(
    study: Study, tasks: Sequence[Task], analysed: Callable[[Task], Row], processes: int
) -> list[Row]:
    """Return the rows of tasks, in task order; tasks in the study's journal are not repeated."""
    keys = [run_key(task) for task in tasks]
    path = study.kept / f"{study.name}.jsonl"
    with open_journal(path) as journal:
        rows = read_content([path]).rows
        unfinished = {key: task for key, task in zip(keys, tasks, strict=True) if key not in rows}
        runs = Parallel(n_jobs=processes, return_as="generator_unordered")(
            delayed(_keyed_row)(key, task, analysed) for key, task in unfinished.items()
        )
        for count, row in enumerate(runs, start=len(tasks) - len(unfinished) + 1):
            rows[row["run_key"]] = row
            journal.append(row)
            if count % REPORT_EACH == 0 or not row.get("as_required", True):
                last_text = f"{unfinished[row['run_key']].variant.slug} {row.get('why', '')}"
                study.report_progress(f"{count} of {len(tasks)} analyses; last: {last_text}")
    return [rows[key] for key in keys]


def _keyed_row(key: str, task: Task, analysed: Callable[[Task], Row]) -> Row:
    hush_exit_message()
    return {"run_key": key, **analysed(task)}


_DEFAULTS: Final = AnalysisSettings()
_TABLES: Final = read_mapping(Path(__file__).parents[1] / "strong_motions.yaml")
STRESS_CASES, CONVERGENCE, ACCURACY = (
    CaseSet(**fields | {"grid": GridConfig(**fields["grid"])})
    for fields in _TABLES["cases"].values()
)


def run(
    study: Study, cases: CaseSet = STRESS_CASES, settings: AnalysisSettings = _DEFAULTS
) -> None:
    """Run the stress cases; add one comparison per bridge, abutment and skew, and a table."""
    tasks = cases.tasks(settings, ModelOptions())
    table = pd.DataFrame(rows_of_tasks(study, tasks, _ending, cases.processes))
    study.tables["rows"] = table = table.drop(columns="run_key")
    groups = table.groupby(["bridge", "abutment", "skew_deg"], sort=False)
    for (bridge, abutment, skew_deg), group in groups:
        failed = group[~group["as_required"]]
        text = f"{bridge}, {abutment}, skew {skew_deg}: analyses that end ok or in collapse"
        if len(failed):
            text += f" (failed: {'; '.join(failed['motion_id'] + ' ' + failed['why'])})"
        source = "every analysis ends ok or in a physical collapse"
        study.absolute(text, len(group) - len(failed), len(group), 0.0, source)
    steps_by_rung = map(steps_from_text, table["steps_by_rung"])
    study.tables["rungs"] = pd.DataFrame(recovery_shares(steps_by_rung))


def _ending(task: Task) -> Row:
    """Return the outcome of an analysis, whether it ended as required, and how it ended."""
    ending = analyse_task(task, Path(os.devnull), lambda time_s, duration_s: None)
    is_accounted = abs(ending.get("energy_residual_ratio", inf)) <= MAX_ENERGY_RESIDUAL
    reason = ending["collapse_criterion"]
    is_physical = ending["status"] == COLLAPSE and bool(reason) and is_accounted
    return ending | {
        "bridge": task.variant.bridge,
        "abutment": task.variant.abutment,
        "skew_deg": task.variant.skew_deg,
        "motion_id": task.motion.motion.motion_id,
        "as_required": ending["status"] == OK or is_physical,
        "why": f"{ending['status']} at {ending['time_reached_s']:.2f} s {reason}".strip(),
    }


#: Limit of the change of each demand by finer numerics, None for no limit.
CHANGES: Final[dict[str, float | None]] = {
    demand: budget["limit"] for demand, budget in _TABLES["budgets"].items()
}
EXCESS: Final = "cone_excess_ratio"
# Whole histories of all cases, even if columns fail.
_WHOLE: Final = AnalysisSettings(collapse_drift_ratio=0.5)


class Numerics(NamedTuple):
    """A named set of changes to the default numerics, used for every `interval`-th case.

    Its demands are the reference of those of the set `coarse`; `text` names the comparison.
    """

    name: str
    text: str = ""
    analysis: Mapping[str, Any] = {}
    model: Mapping[str, Any] = {}
    coarse: str = "default"
    interval: int = 1


_FINE: Final = NUMERICS["reference"]
_HALF_MS: Final = Numerics("half a millisecond", "at the default steps", _FINE["analysis"])
STEPS: Final = (
    _HALF_MS,
    Numerics(
        "a quarter of a millisecond",
        "of the reference itself",
        {**_FINE["analysis"], "dt_s": _FINE["analysis"]["dt_s"] / 2},
        coarse=_HALF_MS.name,
        interval=6,
    ),
)
MESHES: Final = tuple(
    Numerics(name, f"at the default mesh against {name}", model=model)
    for name, model in {
        **_TABLES["meshes"],
        "fine fibers": {"column_fibers": _FINE["model"]["column_fibers"]},
    }.items()
)


def _peaks(study: Study, cases: CaseSet, numerics: Sequence[Numerics]) -> pd.DataFrame:
    tasks: list[Task] = []
    keys: list[Row] = []
    for changed in numerics:
        all_tasks = cases.tasks(replace(_WHOLE, **changed.analysis), ModelOptions(**changed.model))
        for number in range(0, len(all_tasks), changed.interval):
            axes = {name: getattr(all_tasks[number].variant, name) for name in _AXES}
            keys.append({"numerics": changed.name, "case": number, **axes})
            tasks.append(all_tasks[number])
    rows = rows_of_tasks(study, tasks, _whole_peaks, cases.processes)
    return pd.DataFrame([key | row for key, row in zip(keys, rows, strict=True)])


def _whole_peaks(task: Task) -> Row:
    result = task.analyse()
    names = {*CHANGES, EXCESS, *DEMANDS}
    return {
        "variant": task.variant.slug,
        "motion_id": task.motion.motion.motion_id,
        "status": result.status,
        **{name: float(result.whole_history[name]) for name in sorted(names)},
    }


def run_convergence(study: Study, cases: CaseSet = CONVERGENCE) -> None:
    """Compare demands of all cases at default and finer numerics; add a table of all changes."""
    finer = {"convergence-steps": STEPS, "convergence-mesh": MESHES}.get(study.name, STEPS + MESHES)
    table = _peaks(study, cases, [Numerics("default"), *finer])
    peaks = {name: rows.set_index("case") for name, rows in table.groupby("numerics")}
    tables: list[pd.DataFrame] = []
    for changed in finer:
        finer_peaks = peaks[changed.name]
        coarse = peaks[changed.coarse].loc[finer_peaks.index]
        changes = coarse[["variant", "motion_id", "numerics", EXCESS]].assign(
            against=changed.name,
            **{name: relative_changes(name, coarse[name], finer_peaks[name]) for name in CHANGES},
        )
        judge_changes(study, changes, changed)
        tables.append(changes)
    study.tables["changes"] = pd.concat(tables, ignore_index=True)
    text = f"{EXCESS}, largest of {len(peaks['default'])} cases"
    # the limit is a fraction of the friction work
    study.at_most(text, peaks["default"][EXCESS].max(), 0.03, "friction law")


def judge_changes(study: Study, changes: pd.DataFrame, finer: Numerics) -> None:
    """Report the largest and the median change of each demand; judge the default numerics.

    `changes` has the relative changes, one row per case and one column per demand of `CHANGES`.
    """
    cases = f"{len(changes)} cases"
    for demand, budget in CHANGES.items():
        limit = budget if finer.coarse == "default" else None
        sizes = changes[demand].abs()
        factor = 1.0 if demand == "deck_rotation_rad" else 1.5  # rotations may not exceed the limit
        floor_text = _TABLES["budgets"][demand].get("floor_text")
        exemption = f" (changes up to {floor_text} are ignored)" if floor_text else ""
        text = f"{demand}, largest change {finer.text}, {cases}{exemption}"
        tolerance = None if limit is None else factor * limit
        study.absolute(text, sizes.max(), 0.0, tolerance, finer.name)
        text = f"{demand}, median change {finer.text}, {cases}"
        study.report(text, sizes.median(), 0.0, finer.name)
        if limit is not None:
            text = f"{demand}, share of {cases} that change by more than {limit:.1%} {finer.text}"
            study.at_most(text, float((sizes > limit).mean()), 0.05, "error budget")


def relative_changes(demand: str, values: pd.Series, exact: pd.Series) -> pd.Series:
    """Return changes relative to exact values; changes up to the floor of a demand become 0.

    If a demand is missing in both runs, the change is 0; if it is missing in one, it is infinite.
    """
    floor = _TABLES["budgets"][demand].get("floor", 0.0)
    is_same = ((values - exact).abs() <= floor) | (values.isna() & exact.isna())
    return (values / exact - 1.0).fillna(inf).mask(is_same, 0.0)


DEMANDS: Final = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
MAX_DIFFERENCE: Final = 0.005  # relative, of a pooled ratio
ALL_PLACES: Final = "all"
_AXES: Final = ("friction_pct", "gap_mm", "skew_deg")


def run_pairs(
    study: Study,
    cases: CaseSet = ACCURACY,
    accuracies: tuple[Accuracy, Accuracy] = ("default", "reference"),
) -> None:
    """Compare pooled effects (ratios of demands) of a set of cases at two accuracies."""
    numerics = [Numerics(n, "", NUMERICS[n]["analysis"], NUMERICS[n]["model"]) for n in accuracies]
    peaks = _peaks(study, cases, numerics)
    study.tables["ratios"] = table = pooled_ratios(peaks, accuracies)
    source = "the same pairs at accuracy reference"
    for row in table.to_dict("records"):
        step = f"{row['axis']} {row['from_value']} to {row['to_value']}, {row['place']}"
        text = f"{step}: {row['demand']}, ratio at {accuracies[0]} over {row['count']} pairs"
        study.relative(text, row["ratio"], row["exact_ratio"], MAX_DIFFERENCE, source)
    worst = table["difference_percent"].abs().max()
    text = f"largest difference of {len(table)} pooled ratios in percent"
    study.at_most(text, worst, 100.0 * MAX_DIFFERENCE, source)
    failed = (~peaks["status"].isin([OK, COLLAPSE])).sum()
    study.at_most(f"failed analyses of {len(peaks)}", failed, 0.0, "no analysis may fail")


def pooled_ratios(peaks: pd.DataFrame, accuracies: tuple[Accuracy, Accuracy]) -> pd.DataFrame:
    """Return the ratios of demands between neighbouring values of each axis, at both accuracies.

    The ratios are geometric means over the motions at each place (values of the other axes), and
    over all motions and places. A motion is left out if its demand is zero in a run.
    """
    keys = [*_AXES, "motion_id", "demand"]
    rows = peaks.melt(["numerics", *keys[:-1]], DEMANDS, "demand", "peak").query("peak > 0.0")
    names = dict(zip(accuracies, ("ratio", "exact_ratio"), strict=True))
    by_numerics = rows.pivot(index=keys, columns="numerics", values="peak").rename(columns=names)
    logs = by_numerics.apply(np.log)
    changes: list[pd.DataFrame] = []
    for axis in _AXES:
        other_axes = [name for name in reversed(_AXES) if name != axis]
        for low, high in pairwise(sorted(peaks[axis].unique())):
            change = logs.xs(high, level=axis) - logs.xs(low, level=axis)
            change = change.dropna().reset_index()
            change = change.assign(axis=axis, from_value=low, to_value=high)
            texts = (", ".join(f"{n} {row[n]}" for n in other_axes) for _, row in change.iterrows())
            changes += [change.assign(place=list(texts)), change.assign(place=ALL_PLACES)]
    columns = ["axis", "from_value", "to_value", "place", "demand"]
    groups = pd.concat(changes).groupby(columns, sort=False)
    pooled = groups[["ratio", "exact_ratio"]].mean().apply(np.exp)
    pooled["difference_percent"] = 100.0 * (pooled["ratio"] / pooled["exact_ratio"] - 1.0)
    return pooled.assign(count=groups.size()).reset_index()
