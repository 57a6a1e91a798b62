"""Small studies for tests, made without files: weak motions, set-ups, tasks and finished rows."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from bridge_variants import variant
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.demands.columns import DEMAND_COLUMNS
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.study import analyses, batch, config
from skewbridge.study.journal import open_journal
from skewbridge.study.task import Task, no_result, run_key
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.options import ModelOptions


def wave(motion_id="wave", *, duration_s=1.0, number=1, scale=1.0, peak_mps2=1.0) -> SuiteMotion:
    t_s = np.arange(0.0, duration_s, 0.01)
    motion = GroundMotion(
        motion_id=motion_id, dt_s=0.01, accel_1_mps2=peak_mps2 * np.cos(12 * t_s),
        accel_2_mps2=number * np.sin(15 * t_s), sha256=motion_id,
    )  # fmt: skip
    return SuiteMotion(motion=motion, scale=scale, measures=motion_measures(motion, 0.7))


def study_of(
    folder: Path | str, *motions: SuiteMotion, bridges=("osb1",), draws=None, **sections
) -> analyses.StudySetup:
    """Return the set-up of a study of the bridges with the motions, or with one wave."""
    suite = motions or (wave(),)
    runs = {(name, each.motion.motion_id): each for name, each in product(bridges, suite)}
    given = {"measures": {key: dict(each.measures) for key, each in runs.items()}}
    given |= {"shaken_s": {key: each.motion.duration_s for key, each in runs.items()}}
    grid = sections.pop("grid", GridConfig(bridge=bridges))
    study = config.StudyConfig(results=str(folder), grid=grid, **sections)
    return analyses.StudySetup(study=study, suite=suite, draws=draws or {}, **given)


def task_of(motion: SuiteMotion | None = None, **changes) -> Task:
    task = Task(
        variant=variant(), motion=motion or wave(), incidence_deg=0.0, settings=AnalysisSettings(),
        options=ModelOptions(),
    )  # fmt: skip
    return replace(task, **changes)


def row_of(task: Task, value: float = 1.0, cpu_s: float = 1.0) -> dict[str, object]:
    """Return the row of a finished analysis in which every demand has the same value."""
    demands = {column.name: value for column in DEMAND_COLUMNS}
    run = {**no_result("ok", ""), "duration_s": 1.0, "wall_s": cpu_s, "cpu_s": cpu_s}
    return batch.row_of_task({**demands, **run}, task, run_key(task))


def in_journal(path: Path, *rows: dict[str, object]) -> None:
    with open_journal(path) as journal:
        for row in rows:
            journal.append(row)


def without_workers(monkeypatch, answer=row_of) -> list[Task]:
    """Let a function give the rows that workers would; return the list of what they are asked."""
    asked: list[Task] = []

    def stream(_work, tasks, _count):
        asked.extend(tasks.values())
        yield from ((key, [answer(task)]) for key, task in reversed(tasks.items()))

    monkeypatch.setattr(batch, "in_workers", stream)
    return asked
