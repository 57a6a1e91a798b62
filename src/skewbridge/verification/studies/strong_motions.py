"""Analyses under strong motions: stress cases, convergence of the numerics, accuracy of effects.

`run_hard_set`: every abutment model, skew and kind of bridge under the strongest motions of the
package's suite, scaled to a PGA (RotD50) of 1.2 g. Each analysis must end `ok` or in a physical
`collapse`, with its criterion named and its energy accounted for.

`run_convergence`: the demands at the default steps against half a millisecond throughout, and those
against a quarter; the demands at the default mesh against more points of a wall and finer fibers.

`run_accuracy`: the effects of friction, gap and skew at the default accuracy against the reference:
ratios of peaks under the same motion, pooled by their geometric mean over the motions. Errors that
both members of a pair share cancel; the rest must be small compared with the effects.

Motions are cut to their strongest seconds. Finished analyses are kept in a journal: run the same
command to resume. Except for the stress cases, peaks are those of whole histories, whether or not
columns fail.
"""

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from math import inf, log
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from skewbridge.analysis.accuracy import NUMERICS, Accuracy, at_accuracy
from skewbridge.analysis.recovery import rung_shares, steps_as_text, steps_from_text
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.demands.validity import LIMITS
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.motions.suite import read_entry
from skewbridge.statuses import COLLAPSE, OK
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.processes import hush_exit_message
from skewbridge.study.task import Task, run_key
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant
from skewbridge.verification.registry import Study
from skewbridge.verification.studies.paper_runs import (
    FRICTION_PCT,
    embedded_entries,
    strongest_motions,
)

logger = logging.getLogger(__name__)

type Row = dict[str, Any]

REPORT_EACH: Final = 10  # analyses between two lines on the progress


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseSet:
    """Variants and motions of a study, each combination, cut to `window_s` unless None."""

    bridges: tuple[str, ...]
    abutments: tuple[str, ...] = ("contact_friction",)
    skews_deg: tuple[int, ...] = (0, 30, 60)
    gaps_mm: tuple[int, ...] = (25, 51)
    frictions_pct: tuple[int, ...] = (FRICTION_PCT,)
    motion_count: int
    window_s: float | None
    processes: int = 2

    def variants(self) -> list[Variant]:
        """Return the variants."""
        return [
            Variant(bridge=bridge, abutment=abutment, skew_deg=skew, gap_mm=gap, friction_pct=pct)
            for bridge, abutment in product(self.bridges, self.abutments)
            for skew, gap, pct in product(self.skews_deg, self.gaps_mm, self.frictions_pct)
        ]

    def cut(self, motions: Sequence[GroundMotion]) -> list[GroundMotion]:
        """Return the strongest parts of motions."""
        if self.window_s is None:
            return list(motions)
        return [cut_to_strongest(motion, self.window_s, 0.0) for motion in motions]


def _task(
    variant: Variant, motion: GroundMotion, settings: AnalysisSettings, options: ModelOptions
) -> Task:
    whole = SuiteMotion(motion=motion, scale=1.0, measures={})
    return Task(
        variant=variant, motion=whole, incidence_deg=0.0, settings=settings, options=options
    )


def rows_of_tasks(
    study: Study, tasks: Sequence[Task], analysed: Callable[[Task], Row], processes: int
) -> list[Row]:
    """Return the rows of tasks, in their order; those in the study's journal are not run again."""
    keys = [run_key(task) for task in tasks]
    with ExitStack() as stack:
        rows, journal = {}, None
        if study.kept is not None:
            path = study.kept / f"{study.name}.jsonl"
            rows, journal = read_content([path]).rows, stack.enter_context(open_journal(path))
        left = {key: task for key, task in zip(keys, tasks, strict=True) if key not in rows}
        began_s = time.monotonic()
        runs = Parallel(n_jobs=processes, return_as="generator_unordered")(
            delayed(_keyed_row)(key, task, analysed) for key, task in left.items()
        )
        for count, row in enumerate(runs, start=1):
            rows[row["run_key"]] = row
            if journal is not None:
                journal.append(row)
            is_shown = count % REPORT_EACH == 0 or not row.get("as_required", True)
            if study.report_progress and is_shown:
                minutes = (time.monotonic() - began_s) / count * (len(left) - count) / 60
                study.report_progress(
                    f"{len(tasks) - len(left) + count} of {len(tasks)} analyses, {minutes:.0f} min "
                    f"left; last: {left[row['run_key']].variant.slug} {row.get('why', '')}"
                )
    return [rows[key] for key in keys]


def _keyed_row(key: str, task: Task, analysed: Callable[[Task], Row]) -> Row:
    hush_exit_message()
    return {"run_key": key, **analysed(task)}


PGA_G: Final = 1.2
HARD_SET: Final = CaseSet(
    bridges=("osb1", "osb1_fixed", "osb2s"),
    abutments=tuple(ABUTMENTS),
    gaps_mm=(25,),
    motion_count=10,
    window_s=10.0,
)
_GROUP: Final = ["bridge", "abutment", "skew_deg"]


def run(study: Study) -> None:
    """Run the stress cases."""
    run_hard_set(study, HARD_SET, AnalysisSettings())


def run_hard_set(study: Study, chosen: CaseSet, settings: AnalysisSettings) -> None:
    """Run stress cases: one comparison per bridge, abutment and skew, a table of all rows."""
    motions = chosen.cut(strongest_motions(chosen.motion_count, PGA_G))
    tasks = [
        _task(variant, motion, settings, ModelOptions())
        for variant, motion in product(chosen.variants(), motions)
    ]
    table = pd.DataFrame(rows_of_tasks(study, tasks, _ending, chosen.processes))
    table = table.drop(columns="run_key")
    for (bridge, abutment, skew_deg), group in table.groupby(_GROUP, sort=False):
        failed = group[~group["as_required"]]
        text = f"{bridge}, {abutment}, skew {skew_deg}: analyses that end ok or in collapse"
        if len(failed):
            text += f" (not: {'; '.join(failed['motion_id'] + ' ' + failed['why'])})"
        source = "every analysis ends ok or in a physical collapse"
        study.absolute(text, len(group) - len(failed), len(group), 0.0, source)
    study.tables["rows"] = table
    counts = table.groupby([*_GROUP, "status"], sort=False).size()
    study.tables["statuses"] = counts.rename("analyses").reset_index()
    study.tables["rungs"] = pd.DataFrame(rung_shares(map(steps_from_text, table["steps_by_rung"])))


def _ending(task: Task) -> Row:
    """Return how an analysis ends, and whether it ends as required."""
    row: Row = {
        "bridge": task.variant.bridge,
        "abutment": task.variant.abutment,
        "skew_deg": task.variant.skew_deg,
        "motion_id": task.motion.motion.motion_id,
    }
    try:
        found = analyse(task.variant, task.excitation, task.settings, task.options)
    except Exception as error:
        logger.exception("the analysis of %s under %s crashed", task.variant.slug, row["motion_id"])
        why = f"crash: {type(error).__name__}: {error}"
        return row | {"status": "crash", "as_required": False, "why": why, "steps_by_rung": ""}
    residual = found.demands["energy_residual_ratio"]
    is_physical = bool(found.collapse_criterion) and abs(residual) <= LIMITS.max_energy_residual
    messages = "; ".join(found.messages)
    return row | {
        "status": found.status,
        "as_required": found.status == OK or (found.status == COLLAPSE and is_physical),
        "why": f"{found.status} at {found.time_reached_s:.2f} s {messages}".strip(),
        "collapse_criterion": found.collapse_criterion,
        "energy_residual_ratio": residual,
        "time_reached_s": found.time_reached_s,
        "duration_s": found.duration_s,
        "recovery_rung": found.recovery_rung,
        "steps_by_rung": steps_as_text(found.steps_by_rung),
        "substeps": found.substeps,
        "iterations": found.iterations,
    }


CONVERGENCE: Final = CaseSet(bridges=("osb1", "osb1_fixed"), motion_count=4, window_s=8.0)
CONVERGENCE_PGA_G: Final = 0.8  # closes all gaps, breaks keys, yields columns
# Error budget of the default numerics by demand: limit of a change, None for no limit. One case in
# twenty may exceed it, by up to half.
CHANGES: Final[dict[str, float | None]] = {
    "column_shear_kn": 0.01,
    "column_drift_ratio": 0.01,
    "deck_disp_x_m": 0.01,
    "deck_disp_y_m": 0.01,
    "unseating_m": 0.015,
    "abutment_passive_m": 0.015,
    "abutment_transverse_m": 0.015,
    "deck_rotation_rad": 0.03,
    "backwall_force_kn": 0.05,
    "shear_key_force_kn": 0.05,
    "friction_force_kn": 0.05,
    "slip_work_kj": None,
    "friction_impulse_kns": None,
    "contact_time_s": None,
}
# Changes up to these values count as none: 0.1 mrad moves the corners of osb1 by 0.7 mm, and the
# mildest limit states of abutments are at some 10 mm.
FLOORS: Final = {
    "deck_rotation_rad": (1.0e-4, "0.1 mrad"),
    "abutment_passive_m": (5.0e-4, "0.5 mm"),
}
WITHOUT_EXCEPTION: Final = {"deck_rotation_rad"}  # no case may exceed its limit
BEYOND_SHARE: Final = 0.05
BEYOND_FACTOR: Final = 1.5
EXCESS: Final = ("cone_excess_wall_ratio", "cone_excess_key_ratio")
MAX_EXCESS: Final = 0.03  # of the work of friction
# Whole histories of all cases, whether or not columns fail.
_WHOLE: Final = AnalysisSettings(energy=False, mean_iterations=1e4, collapse_drift_ratio=0.5)


@dataclass(frozen=True, slots=True)
class Refinement:
    """Finer numerics that those named `coarse` are compared with in every `interval`-th case.

    `name` says against what, `text` which changes these are. Only changes of the default are
    judged.
    """

    kind: Literal["steps", "mesh"]
    name: str
    text: str
    settings: AnalysisSettings = _WHOLE
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    coarse: str = "default"
    interval: int = 1


def _mesh(name: str, **options: Any) -> Refinement:
    return Refinement("mesh", name, f"at the default mesh against {name}", options=options)


_FINE: Final = replace(_WHOLE, **NUMERICS["reference"]["analysis"])
_HALF_MS: Final = Refinement("steps", "half a millisecond", "at the default steps", _FINE)
_QUARTER_MS: Final = Refinement(
    kind="steps",
    name="a quarter of a millisecond",
    text="of the reference itself",
    settings=replace(_FINE, dt_s=_FINE.dt_s / 2),
    coarse=_HALF_MS.name,
    interval=6,
)
REFINEMENTS: Final = (
    _HALF_MS,
    _QUARTER_MS,
    _mesh("9 wall points", backwall_points=9),
    _mesh("17 wall points", backwall_points=17),
    _mesh("fine fibers", column_fibers=NUMERICS["reference"]["model"]["column_fibers"]),
)


def run_convergence(study: Study) -> None:
    """Run the study of convergence; the end of its name may choose steps or mesh."""
    _, _, kind = study.name.partition("-")
    compare_with_finer(study, CONVERGENCE, [r for r in REFINEMENTS if kind in ("", r.kind)])


def compare_with_finer(study: Study, chosen: CaseSet, finer: Sequence[Refinement]) -> None:
    """Compare the demands of a set with those of finer numerics; a table of all changes."""
    motions = chosen.cut(strongest_motions(chosen.motion_count, CONVERGENCE_PGA_G))
    cases = list(product(chosen.variants(), motions))
    tasks: dict[tuple[str, int], Task] = {}
    for number, (variant, motion) in enumerate(cases):
        tasks["default", number] = _task(variant, motion, _WHOLE, ModelOptions())
        for each in finer:
            if number % each.interval == 0:
                tasks[each.name, number] = _task(
                    variant, motion, each.settings, ModelOptions(**each.options)
                )
    rows = rows_of_tasks(study, list(tasks.values()), _whole_peaks, chosen.processes)
    names = pd.DataFrame(list(tasks), columns=["numerics", "case"])
    peaks = dict(iter(pd.concat([names, pd.DataFrame(rows)], axis=1).groupby("numerics")))
    tables: list[pd.DataFrame] = []
    for each in finer:
        exact = peaks[each.name].set_index("case")
        coarse = peaks[each.coarse].set_index("case").loc[exact.index]
        changes = coarse[["variant", "motion_id", "numerics", *EXCESS]].assign(
            against=each.name,
            **{name: relative_changes(name, coarse[name], exact[name]) for name in CHANGES},
        )
        judge_changes(study, changes, each)
        tables.append(changes)
    study.tables["changes"] = pd.concat(tables, ignore_index=True)
    for excess in EXCESS:
        text = f"{excess}, largest of {len(cases)} cases"
        study.at_most(text, peaks["default"][excess].max(), MAX_EXCESS, "friction law")


def judge_changes(study: Study, changes: pd.DataFrame, finer: Refinement) -> None:
    """Report the worst and the median change of each demand; judge those of the default.

    Args:
        study: Takes the comparisons.
        changes: One row per case, one column per demand of `CHANGES` (relative change).
        finer: The finer numerics that the cases are compared with.
    """
    cases = f"{len(changes)} cases"
    for demand, budget in CHANGES.items():
        limit = budget if finer.coarse == "default" else None
        sizes = changes[demand].abs()
        factor = 1.0 if demand in WITHOUT_EXCEPTION else BEYOND_FACTOR
        floor = f" (changes up to {FLOORS[demand][1]} count as none)" if demand in FLOORS else ""
        text = f"{demand}, largest change {finer.text}, {cases}{floor}"
        largest = None if limit is None else factor * limit
        study.absolute(text, sizes.max(), 0.0, largest, finer.name)
        text = f"{demand}, median change {finer.text}, {cases}"
        study.absolute(text, sizes.median(), 0.0, None, finer.name)
        if limit is not None:
            text = f"{demand}, share of {cases} that change by more than {limit:.1%} {finer.text}"
            study.at_most(text, float((sizes > limit).mean()), BEYOND_SHARE, "error budget")


def relative_changes(demand: str, values: pd.Series, exact: pd.Series) -> pd.Series:
    """Return changes relative to exact values; 0 up to the floor of the demand.

    The change is 0 for a demand that is absent from both runs, infinite if absent from one.
    """
    floor, _ = FLOORS.get(demand, (0.0, ""))
    is_same = ((values - exact).abs() <= floor) | (values.isna() & exact.isna())
    return (values / exact - 1.0).fillna(inf).mask(is_same, 0.0)


def _whole_peaks(task: Task) -> Row:
    """Return the status of an analysis and the peaks of its whole history."""
    found = analyse(task.variant, task.excitation, task.settings, task.options)
    names = {*CHANGES, *EXCESS, *DEMANDS}
    return {
        "variant": task.variant.slug,
        "motion_id": task.motion.motion.motion_id,
        "status": found.status,
        **{name: float(found.whole_history[name]) for name in sorted(names)},
    }


#: By name of the study; the first motions of the suite at their scale factors.
ACCURACY: Final[Mapping[str, CaseSet]] = {
    name: CaseSet(bridges=("osb1",), frictions_pct=(0, 50), motion_count=8, window_s=window_s)
    for name, window_s in (("accuracy", 10.0), ("accuracy-whole", None))
}
DEMANDS: Final = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
MAX_DIFFERENCE: Final = 0.005  # of a pooled ratio
ALL_PLACES: Final = "all"
_AXES: Final = ("friction_pct", "gap_mm", "skew_deg")


def run_pairs(study: Study) -> None:
    """Run the study of the accuracy of effects."""
    run_accuracy(study, ACCURACY[study.name], ("default", "reference"))


def run_accuracy(study: Study, chosen: CaseSet, accuracies: tuple[Accuracy, Accuracy]) -> None:
    """Compare the pooled ratios of a set at the first accuracy with those at the second."""
    entries = embedded_entries()[: chosen.motion_count]
    motions = chosen.cut([read_entry(entry).scaled(entry.scale) for entry in entries])
    tasks: dict[tuple[Accuracy, Variant, str], Task] = {
        (accuracy, variant, motion.motion_id): _task(
            variant, motion, *at_accuracy(_WHOLE, ModelOptions(), accuracy)
        )
        for motion in motions
        for variant in chosen.variants()
        for accuracy in reversed(accuracies)
    }
    rows = rows_of_tasks(study, list(tasks.values()), _whole_peaks, chosen.processes)
    found = dict(zip(tasks, rows, strict=True))
    names = [motion.motion_id for motion in motions]
    table = pooled_ratios(chosen, found, names, accuracies)
    study.tables["ratios"] = table
    source = "the same pairs at accuracy reference"
    for row in table.to_dict("records"):
        step = f"{row['axis']} {row['from_value']} to {row['to_value']}, {row['place']}"
        text = f"{step}: {row['demand']}, ratio at {accuracies[0]} over {row['count']} pairs"
        study.relative(text, row["ratio"], row["exact_ratio"], MAX_DIFFERENCE, source)
    worst = table["difference_percent"].abs().max()
    text = f"largest difference of {len(table)} pooled ratios in percent"
    study.at_most(text, worst, 100.0 * MAX_DIFFERENCE, source)
    failed = sum(peaks["status"] not in {OK, COLLAPSE} for peaks in found.values())
    study.at_most(f"analyses of {len(found)} that failed", failed, 0.0, "none may fail")


def pairs(chosen: CaseSet) -> list[tuple[str, Variant, Variant]]:
    """Return axis, variant before and variant after of all pairs: neighbours on one axis."""
    values = chosen.frictions_pct, chosen.gaps_mm, chosen.skews_deg
    return [
        (axis, variant, replace(variant, **{axis: value}))
        for axis, steps in zip(_AXES, values, strict=True)
        for before, value in pairwise(steps)
        for variant in chosen.variants()
        if getattr(variant, axis) == before
    ]


def pooled_ratios(
    chosen: CaseSet,
    found: Mapping[tuple[Accuracy, Variant, str], Mapping[str, Any]],
    motions: Sequence[str],
    accuracies: tuple[Accuracy, Accuracy],
) -> pd.DataFrame:
    """Return the pooled ratios of all pairs and demands at both accuracies.

    A pair is pooled over the motions at each place (the values on the other axes), and over motions
    and places together. Motions without the demand in a member are left out. Columns: axis,
    from_value, to_value, place, demand, count, ratio, exact_ratio and difference_percent.
    """
    rows: list[Row] = []
    for axis, before, after in pairs(chosen):
        others = [name for name in reversed(_AXES) if name != axis]
        place = ", ".join(f"{name} {getattr(before, name)}" for name in others)
        values = {"from_value": getattr(before, axis), "to_value": getattr(after, axis)}
        for demand, motion_id in product(DEMANDS, motions):
            peaks = [
                float(found[accuracy, variant, motion_id][demand])
                for accuracy in accuracies
                for variant in (before, after)
            ]
            if min(peaks) > 0.0:
                logs = {"ratio": log(peaks[1] / peaks[0]), "exact_ratio": log(peaks[3] / peaks[2])}
                row = {"axis": axis, **values, "demand": demand, **logs}
                rows += [row | {"place": place}, row | {"place": ALL_PLACES}]
    names = ["axis", "from_value", "to_value", "place", "demand"]
    groups = pd.DataFrame(rows).groupby(names, sort=False)
    pooled = groups[["ratio", "exact_ratio"]].mean().apply(np.exp)
    pooled["difference_percent"] = 100.0 * (pooled["ratio"] / pooled["exact_ratio"] - 1.0)
    return pooled.assign(count=groups.size()).reset_index()
