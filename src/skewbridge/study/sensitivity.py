"""Numerical sensitivity: penalties and time step halved and doubled on a few analyses."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.provenance.tables import provenance, write_frame
from skewbridge.statuses import RAN
from skewbridge.study.batch import run_tasks
from skewbridge.study.journal import open_journal, read_journal
from skewbridge.study.progress import log_failure
from skewbridge.study.setup import StudySetup
from skewbridge.study.task import Task

CHANGED: Final = ("time step", "normal penalty", "tangential penalty")
CHANGES: Final = ("default", *(f"{name} x {by}" for name in CHANGED for by in ("1/2", "2")))
DEMANDS: Final = demands_for("sensitivity")


def write_sensitivity(
    setup: StudySetup, slug: str, *, count: int, n_jobs: int, output: Path
) -> None:
    """Run the changes and write the ratios of the demands to the default, mean over motions.

    What stands in the journal of the variant or in the own one is not run again.

    Args:
        setup: What the variants share.
        slug: The variant.
        count: Motions, the strongest by the largest scaled PGV; 0 writes an empty table.
        n_jobs: Worker processes.
        output: Parquet file: change, motions, status, one ratio column per demand and the
            largest deviation of a single motion.
    """
    tasks = sorted(setup.tasks(slug), key=lambda t: -t.motion.measures["im_pgv_rotd50_mps"])[:count]
    runs = [(change, changed_task(task, change)) for task in tasks for change in CHANGES]
    own = setup.folder.journal("sensitivity")
    with open_journal(own) as journal:
        rows = run_tasks(
            [task for _, task in runs],
            journal,
            read_journal(setup.folder.journal(slug)) | read_journal(own),
            n_jobs=n_jobs,
            log_folder=setup.folder.solver_logs / "sensitivity",
            on_finished=log_failure,
        )
    frame = pd.DataFrame(
        [{"change": change, **row} for (change, _), row in zip(runs, rows, strict=True)]
    )
    write_frame(sensitivity_table(frame) if count else pd.DataFrame(), output, provenance())


def sensitivity_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the ratios to the default, one row per change.

    Args:
        rows: Demands rows with a column ``change``.
    """
    demands = rows.pivot_table(index="motion_id", columns="change", values=list(DEMANDS))
    table: list[dict[str, object]] = []
    for change in CHANGES[1:]:
        ratios = {name: demands[name][change] / demands[name]["default"] for name in DEMANDS}
        of_change = rows[rows["change"] == change]
        table.append(
            {
                "change": change,
                "motions": len(of_change),
                "completed": int(of_change["status"].isin(RAN).sum()),
                **{name: float(ratio.mean()) for name, ratio in ratios.items()},
                "largest single change": max(
                    float((ratios[name] - 1).abs().max()) for name in DEMANDS[:-1]
                ),
            }
        )
    return pd.DataFrame(table)


def changed_task(task: Task, change: str) -> Task:
    """Return an analysis with one of `CHANGES` made to it."""
    settings, options = task.settings, task.options
    factor = 2.0 if change.endswith("x 2") else 0.5
    if change.startswith("time step"):
        settings = replace(settings, dt_s=settings.dt_s * factor)
    elif change.startswith("normal"):
        options = replace(options, normal_stiffness_factor=factor)
    elif change.startswith("tangential"):
        options = replace(options, tangent_stiffness_factor=factor)
    return replace(task, settings=settings, options=options)
