"""Numerical sensitivity: rows repeated at the reference accuracy and with other penalties.

A row at the reference accuracy costs as much as many rows of the study, so that both sides of every
comparison are analysed for the strongest part of the motion only.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.analysis.accuracy import at_accuracy
from skewbridge.demands.columns import demands_for
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.statuses import RAN
from skewbridge.study.analyses import PGV, StudySetup, run_in_journal
from skewbridge.study.batch import Workers
from skewbridge.study.task import Task

AS_IN_STUDY: Final = "default"
SAME_CYCLE_S: Final = 0.1  # failures this close are in the same cycle


def _reference(task: Task) -> Task:
    settings, options = at_accuracy(task.settings, task.options, "reference")
    return replace(task, settings=settings, options=options)


def _with_options(**values: float) -> Callable[[Task], Task]:
    return lambda task: replace(task, options=replace(task.options, **values))


#: Changed analyses of a row of the study; their names begin columns of the table.
REPEATS: Final[Mapping[str, Callable[[Task], Task]]] = {
    AS_IN_STUDY: lambda task: task,
    "reference": _reference,
    "kn_half": _with_options(normal_stiffness_factor=0.5),
    "kn_double": _with_options(normal_stiffness_factor=2.0),
    "kt_half": _with_options(tangent_stiffness_factor=0.5),
    "kt_double": _with_options(tangent_stiffness_factor=2.0),
}


def sampled_rows(
    setup: StudySetup, slugs: Sequence[str], count: int, window_s: float | None
) -> list[Task]:
    """Return rows of the study, spread over its variants, each with another strong motion.

    The motions are the strongest by their scaled PGV, in turn. Each is cut to its strongest
    `window_s`; a shorter analysis, and all with None, is that of the study itself.
    """
    numbers = np.linspace(0, len(slugs) - 1, count).round().tolist() if slugs else []
    rows: list[Task] = []
    for row, number in enumerate(numbers):
        tasks = setup.tasks(slugs[int(number)])
        tasks.sort(key=lambda task: -task.motion.measures[PGV])
        rows.append(in_window(tasks[row % len(tasks)], window_s))
    return rows


def in_window(task: Task, window_s: float | None) -> Task:
    """Return an analysis under the strongest part of its motion, or itself where it is as short."""
    if window_s is None or task.analysed_s <= window_s:
        return task
    whole = task.motion.motion
    cut = cut_to_strongest(whole, window_s, free_vibration_s=0.0)
    name = f"{whole.motion_id}_strongest_{window_s:g}s"
    return replace(task, motion=replace(task.motion, motion=replace(cut, motion_id=name)))


def write_sensitivity(
    setup: StudySetup,
    slugs: Sequence[str],
    *,
    count: int,
    window_s: float | None,
    workers: Workers,
    output: Path,
) -> None:
    """Run the changed analyses that no journal has and write the changes of the demands.

    The file has one row per demand with the mean ratio of the study to the reference, the largest
    change of a single row by each of `REPEATS`, and the seconds of motion that both sides were
    analysed for (the longest of the rows); it is empty with a count of 0.
    """
    rows = sampled_rows(setup, slugs, count, window_s)
    longest_first = sorted(REPEATS, key=lambda name: name != "reference")
    runs = [(number, name) for name in longest_first for number in range(len(rows))]
    tasks = [REPEATS[name](rows[number]) for number, name in runs]
    demands = pd.DataFrame(run_in_journal(setup, "sensitivity", tasks, workers))
    repeated = pd.DataFrame(runs, columns=["row", "change"]).join(demands)
    table = sensitivity_table(repeated) if count else pd.DataFrame()
    write_frame(table, output, provenance())


def sensitivity_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the changes of the demands, one row per demand.

    The rows of the demands have the columns ``row`` (of the study) and ``change``. Those that did
    not finish are left out and counted. Two rows whose columns fail in different cycles are not
    compared: their demands are peaks up to different times.
    """
    ran = rows[rows["status"].isin(RAN)]
    ends_s = ran.set_index(["row", "change"])["beyond_model_s"].unstack().fillna(np.inf)
    table: list[dict[str, object]] = []
    for demand in demands_for("sensitivity"):
        values = ran.pivot_table(index="row", columns="change", values=demand)
        row: dict[str, object] = {
            "demand": demand,
            "rows": rows["row"].nunique(),
            "not_run": len(rows) - len(ran),
            "analysed_s": float(rows["duration_s"].max()),
        }
        for change in list(REPEATS)[1:]:
            # zero over zero: a demand that this row does not have
            ends_alike = np.isclose(
                ends_s[AS_IN_STUDY], ends_s[change], rtol=0.0, atol=SAME_CYCLE_S
            )
            alike = ends_s.index[ends_alike]
            ratio = (values[AS_IN_STUDY] / values[change]).reindex(alike).dropna()
            if change == "reference":
                row["reference_mean_ratio"] = float(ratio.mean())
            row[f"{change}_largest_change"] = float((ratio - 1.0).abs().max())
        table.append(row)
    return pd.DataFrame(table)
