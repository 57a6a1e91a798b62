"""Analyses repeated with other numerical settings, and pairs without and with friction.

Numerical sensitivity: a row at the reference accuracy costs as much as many rows of the study.
Both sides of every comparison therefore use only the strongest part of the motion. The friction
pair is one analysis run without and with friction; its histories are kept for the figures.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd

from skewbridge.analysis.settings import at_accuracy
from skewbridge.demands.columns import demands_for, key_values
from skewbridge.demands.validity import is_complete
from skewbridge.files.digests import provenance
from skewbridge.files.tables import read_frame, records_of, write_frame
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.statuses import RAN
from skewbridge.variant.variant import Variant

if TYPE_CHECKING:  # processes that draw the figures do not import OpenSees
    from skewbridge.study.analyses import StudySetup
    from skewbridge.study.task import Task

AS_IN_STUDY: Final = "default"


def _with_options(**values: float) -> "Callable[[Task], Task]":
    return lambda task: replace(task, options=replace(task.options, **values))


def _reference(task: "Task") -> "Task":
    settings, options = at_accuracy(task.settings, task.options, "reference")
    return replace(task, settings=settings, options=options)


#: Changes made in a repeated row of the study; their names are prefixes of table columns.
REPEATS: Final[Mapping[str, "Callable[[Task], Task]"]] = {
    AS_IN_STUDY: lambda task: task,
    "reference": _reference,
    "kn_half": _with_options(normal_stiffness_factor=0.5),
    "kn_double": _with_options(normal_stiffness_factor=2.0),
    "kt_half": _with_options(tangent_stiffness_factor=0.5),
    "kt_double": _with_options(tangent_stiffness_factor=2.0),
}


def sampled_rows(
    setup: "StudySetup", slugs: Sequence[str], count: int, window_s: float | None
) -> "list[Task]":
    """Return `count` tasks of the study, spread over its variants, under its strongest motions.

    Motions are cut to their strongest `window_s`, unless it is None or the analysis is shorter.
    """
    from skewbridge.study.analyses import PGV

    numbers = np.linspace(0, len(slugs) - 1, count).round().tolist() if slugs else []
    rows: list[Task] = []
    for row, number in enumerate(numbers):
        tasks = setup.planned_tasks(slugs[int(number)])
        tasks.sort(key=lambda task: -task.motion.measures[PGV])
        rows.append(in_window(tasks[row % len(tasks)], window_s))
    return rows


def in_window(task: "Task", window_s: float | None) -> "Task":
    """Return a task under the strongest `window_s` of its motion; shorter tasks are unchanged."""
    if window_s is None or task.analysed_s <= window_s:
        return task
    motion = task.motion.motion
    cut = cut_to_strongest(motion, window_s, free_vibration_s=0.0)
    name = f"{motion.motion_id}_strongest_{window_s:g}s"
    return replace(task, motion=replace(task.motion, motion=replace(cut, motion_id=name)))


def write_sensitivity(setup: "StudySetup", slugs: Sequence[str], output: Path) -> None:
    """Run the repeated analyses that are not in a journal; write the changes of the demands.

    One row per demand: mean ratio of default to reference, and largest changes by `REPEATS`.
    """
    from skewbridge.study.analyses import check_plan, run_in_journal

    _, count, *_ = check_plan(setup.study, setup.durations_s)
    rows = sampled_rows(setup, slugs, count, setup.study.sensitivity.window_s)
    longest_first = sorted(REPEATS, key=lambda name: name != "reference")
    runs = [(number, name) for name in longest_first for number in range(len(rows))]
    tasks = [REPEATS[name](rows[number]) for number, name in runs]
    demands = pd.DataFrame(run_in_journal(setup, "sensitivity", tasks))
    repeated = pd.DataFrame(runs, columns=["row", "change"]).join(demands)
    write_frame(sensitivity_table(repeated) if rows else pd.DataFrame(), output, provenance())


def sensitivity_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the changes of the demands, one row per demand.

    ``rows`` is a demands table with the columns ``row`` (number) and ``change`` (of `REPEATS`).
    Rows whose columns fail in different cycles are not compared.
    """
    ran = rows[rows["status"].isin(RAN)]
    ends_s = ran.set_index(["row", "change"])["beyond_model_s"].unstack().fillna(np.inf)
    same_cycle = {  # failures within 0.1 s are in the same cycle
        change: np.isclose(ends_s[AS_IN_STUDY], ends_s[change], rtol=0.0, atol=0.1)
        for change in list(REPEATS)[1:]
    }
    counts: dict[str, float] = {"rows": rows["row"].nunique(), "not_run": len(rows) - len(ran)}
    counts["analysed_s"] = float(rows["duration_s"].max())
    table: list[dict[str, object]] = []
    for demand in demands_for("sensitivity"):
        values = ran.pivot_table(index="row", columns="change", values=demand)
        row: dict[str, object] = {"demand": demand, **counts}
        for change, is_alike in same_cycle.items():
            # drops 0 / 0, a demand that does not occur in this row
            ratios = (values[AS_IN_STUDY] / values[change]).reindex(ends_s.index[is_alike]).dropna()
            if change == "reference":
                row["reference_mean_ratio"] = float(ratios.mean())
            row[f"{change}_largest_change"] = float((ratios - 1.0).abs().max())
        table.append(row)
    return pd.DataFrame(table)


# ---- Friction pair


def friction_pair(demands: pd.DataFrame) -> tuple[Variant, Variant] | None:
    """Return the variants of least and most friction at the largest skew, or None."""
    by_bridge_and_gap: dict[Variant, list[Variant]] = {}
    for variant in map(Variant.of_row, records_of(demands.drop_duplicates("variant"))):
        by_bridge_and_gap.setdefault(replace(variant, friction_pct=0), []).append(variant)
    pairs = [sorted(group) for group in by_bridge_and_gap.values() if len(group) > 1]
    best_pair = max(pairs, key=lambda pair: (abs(pair[0].skew_deg), -pair[0].gap_mm), default=None)
    return None if best_pair is None else (best_pair[0], best_pair[-1])


def typical_motion(demands: pd.DataFrame, variant: Variant) -> str:
    """Return the motion with the upper-quartile deck displacement among the completed runs."""
    runs = demands[demands["variant"] == variant.slug]
    completed = runs[is_complete(runs)]
    ordered = (completed if len(completed) else runs).sort_values("deck_disp_m")["motion_id"]
    return str(ordered.iloc[int(0.75 * (len(ordered) - 1))])


def write_friction_pair(setup: "StudySetup", demands: Path, output: Path) -> None:
    """Repeat one analysis for both variants of `friction_pair`; write their keys and histories.

    In a small study, they cover only the strongest part of the motion.
    """
    from skewbridge.study.analyses import check_plan

    rows, runs = read_frame(demands), [pd.DataFrame()]
    part_s, *_ = check_plan(setup.study, setup.durations_s)
    pair = friction_pair(rows) if part_s else None
    motion_id = typical_motion(rows, pair[-1]) if pair else ""
    for variant in pair or ():
        task = next(t for t in setup.tasks(variant) if t.motion.motion.motion_id == motion_id)
        task = in_window(task, part_s)
        histories = pd.DataFrame(task.analyse(histories=True).histories or {})
        motion = task.motion
        key = key_values(task.variant, motion.motion.motion_id, motion.scale, task.incidence_deg)
        runs.append(histories.assign(**key))
    write_frame(pd.concat(runs, ignore_index=True), output, provenance())


def read_friction_pair(path: Path) -> tuple[Variant, str, dict[str, pd.DataFrame]] | None:
    """Return the content of a file of `write_friction_pair`, or None if there was no pair.

    The variant without friction, the motion, and histories by legend text (``friction 0.5``).
    """
    table = read_frame(path)
    if table.empty:
        return None
    variant, *_ = map(Variant.of_row, records_of(table.head(1)))
    keys = key_values(variant, "", 1.0, 0.0)
    histories = {
        f"friction {friction:g}": rows.drop(columns=[*keys])
        .dropna(axis="columns", how="all")
        .reset_index(drop=True)
        for friction, rows in table.groupby("friction")
    }
    return variant, str(table["motion_id"].iloc[0]), histories
