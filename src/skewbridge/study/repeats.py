"""Analyses repeated with other numerical settings.

A row at the reference accuracy costs as much as many rows of the study. Both sides of every
comparison therefore use only the strongest part of the motion. Strong motions cost more and tell
less: their columns fail early, and later times are not compared.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.analysis.settings import at_accuracy
from skewbridge.demands.columns import demands_for
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.statuses import RAN
from skewbridge.study.analyses import (
    CHECK_WINDOW_S,
    StudySetup,
    check_plan,
    run_in_journal,
    sampled,
)
from skewbridge.study.task import Task

AS_IN_STUDY: Final = "default"


def _with_options(**values: float) -> Callable[[Task], Task]:
    return lambda task: replace(task, options=replace(task.options, **values))


def _reference(task: Task) -> Task:
    settings, options = at_accuracy(task.settings, task.options, "reference")
    return replace(task, settings=settings, options=options)


#: Changes made in a repeated row of the study; their names are prefixes of table columns.
REPEATS: Final[Mapping[str, Callable[[Task], Task]]] = {
    AS_IN_STUDY: lambda task: task,
    "reference": _reference,
    "kn_half": _with_options(normal_stiffness_factor=0.5),
    "kn_double": _with_options(normal_stiffness_factor=2.0),
    "kt_half": _with_options(tangent_stiffness_factor=0.5),
    "kt_double": _with_options(tangent_stiffness_factor=2.0),
}


def sampled_rows(setup: StudySetup, slugs: Sequence[str], count: int) -> list[Task]:
    """Return `count` tasks of the study, spread over its variants and its motions up to the median.

    Motions are cut to their strongest `CHECK_WINDOW_S`, unless the analysis is shorter.
    """
    variant_numbers = np.linspace(0, len(slugs) - 1, count).round().tolist() if slugs else []
    cut_tasks: list[Task] = []
    for row, number in enumerate(variant_numbers):
        if tasks := sampled(setup.planned_tasks(slugs[int(number)]), 2 * count):
            cut_tasks.append(in_window(tasks[row % len(tasks)], CHECK_WINDOW_S))
    return cut_tasks


def in_window(task: Task, window_s: float) -> Task:
    """Return a task under the strongest `window_s` of its motion; shorter tasks are unchanged."""
    if task.analysed_s <= window_s:
        return task
    motion = task.motion.motion
    cut_motion = cut_to_strongest(motion, window_s, free_vibration_s=0.0)
    name = f"{motion.motion_id}_strongest_{window_s:g}s"
    return replace(task, motion=replace(task.motion, motion=replace(cut_motion, motion_id=name)))


def write_sensitivity(setup: StudySetup, slugs: Sequence[str], output: Path) -> None:
    """Run the repeated analyses that are not in a journal; write the changes of the demands.

    One row per demand: mean ratio of its values at the accuracy of the study and at `reference`
    accuracy, and its largest relative change by each change of settings in `REPEATS`.
    """
    count, _ = check_plan(setup.study, setup.durations_s)
    rows = sampled_rows(setup, slugs, count)
    longest_first = sorted(REPEATS, key=lambda name: name != "reference")
    runs = [(number, name) for name in longest_first for number in range(len(rows))]
    tasks = [REPEATS[name](rows[number]) for number, name in runs]
    demands = pd.DataFrame(run_in_journal(setup, "sensitivity", tasks))
    repeated = pd.DataFrame(runs, columns=["row", "change"]).join(demands)
    write_frame(sensitivity_table(repeated) if rows else pd.DataFrame(), output, provenance())


def sensitivity_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the changes of the demands, one row per demand.

    ``rows`` is a demands table with two further columns: ``row``, the number of the repeated row,
    and ``change``, a key of `REPEATS`. Two repeats are not compared if a column fails in different
    cycles of the motion.
    """
    ran = rows[rows["status"].isin(RAN)].set_index(["row", "change"])

    def by_change(values: pd.Series) -> pd.DataFrame:
        """Return one column per change, also for a change with which no row ran."""
        return values.unstack().reindex(columns=[*REPEATS])

    ends_s = by_change(ran["beyond_model_s"].fillna(np.inf))
    # failures within 0.1 s are in the same cycle
    is_alike = np.isclose(ends_s, ends_s[[AS_IN_STUDY]], rtol=0.0, atol=0.1)
    counts: dict[str, float] = {"rows": rows["row"].nunique(), "not_run": len(rows) - len(ran)}
    counts["analysed_s"] = float(rows["duration_s"].max())
    table: list[Mapping[Any, object]] = []
    for demand in demands_for("sensitivity"):
        values = by_change(ran[demand])
        # mean and maximum leave out 0 / 0, a demand that does not occur in this row
        ratios = values.rdiv(values[AS_IN_STUDY], axis="index").where(is_alike)
        changes = (ratios - 1.0).abs().max().drop(AS_IN_STUDY).add_suffix("_largest_change")
        mean_ratio = {"reference_mean_ratio": ratios["reference"].mean()}
        table.append({"demand": demand} | counts | mean_ratio | changes.to_dict())
    return pd.DataFrame(table)
