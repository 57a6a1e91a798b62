"""A batch of analyses: the same rows on one core and on two, nothing lost when a worker dies."""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from study_trees import TIMES

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.study.batch import Workers, run_tasks
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.task import Task, run_key
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

VARIANT = Variant(
    bridge="osb1", abutment="contact_friction", skew_deg=30, gap_mm=25, friction_pct=50
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadlyOptions(ModelOptions):
    """Options that end the process they are sent to."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os._exit, (1,)


def pulse(number: int) -> SuiteMotion:
    t_s = np.arange(0.0, 0.6, 0.01)
    motion = GroundMotion(
        motion_id=f"pulse{number}",
        dt_s=0.01,
        accel_1_mps2=4.0 * np.cos(2 * np.pi * t_s / 0.5),
        accel_2_mps2=number * np.sin(2 * np.pi * t_s / 0.4),
        sha256=f"pulse{number}",
    )
    return SuiteMotion(motion=motion, scale=1.0, measures=motion_measures(motion, 0.7))


@pytest.fixture
def tasks() -> list[Task]:
    return [
        Task(
            variant=VARIANT,
            motion=pulse(number),
            incidence_deg=0.0,
            settings=AnalysisSettings(),
            options=ModelOptions(),
        )
        for number in (1, 2, 3)
    ]


def batch(tasks: list[Task], folder: Path, n_jobs: int) -> tuple[list[dict[str, Any]], int]:
    """Rows of a batch and the number of analyses that it ran."""
    new: list[dict[str, Any]] = []
    path = folder / "v.jsonl"
    with open_journal(path) as journal:
        rows = run_tasks(
            tasks,
            journal,
            read_content([path]).rows,
            workers=Workers(count=n_jobs),
            log_folder=folder,
            on_finished=new.append,
        )
    return rows, len(new)


def without_timing(rows: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the other values as texts, so that what is no number equals itself."""
    return [{key: repr(value) for key, value in row.items() if key not in TIMES} for row in rows]


def test_one_core_and_two_give_identical_rows(tasks: list[Task], tmp_path: Path) -> None:
    one, _ = batch(tasks, tmp_path / "one", 1)
    two, _ = batch(tasks, tmp_path / "two", 2)
    assert without_timing(one) == without_timing(two)
    assert {row["status"] for row in one} == {"ok"}


def test_what_the_journal_has_is_not_run_again(tasks: list[Task], tmp_path: Path) -> None:
    first, ran_first = batch(tasks[:2], tmp_path, 1)
    again, ran_again = batch(tasks, tmp_path, 1)
    assert (ran_first, ran_again) == (2, 1)
    assert without_timing(again[:2]) == without_timing(first)


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_a_worker_that_dies_costs_only_its_own_analysis(
    tasks: list[Task], tmp_path: Path, n_jobs: int
) -> None:
    """With one worker, too, which is not the process that asks for it."""
    deadly = replace(tasks[1], options=DeadlyOptions())
    rows, _ = batch([tasks[0], deadly, tasks[2]], tmp_path, n_jobs)
    assert [row["status"] for row in rows] == ["ok", "crash", "ok"]


def test_a_motion_with_an_absurd_value_is_a_row_with_a_reason(
    tasks: list[Task], tmp_path: Path
) -> None:
    wild = replace(tasks[0], motion=replace(tasks[0].motion, scale=1e6))
    rows, _ = batch([wild], tmp_path, 1)
    assert rows[0]["status"] == "invalid_input"
    assert "peak acceleration" in rows[0]["collapse_criterion"]


def test_the_key_of_an_analysis_depends_on_all_that_matters(tasks: list[Task]) -> None:
    task = tasks[0]
    others = [
        replace(task, incidence_deg=90.0),
        replace(task, motion=replace(task.motion, scale=1.1)),
        replace(task, settings=AnalysisSettings(dt_s=0.004)),
        replace(task, options=ModelOptions(cohesion_n=1.0)),
        replace(task, variant=replace(VARIANT, gap_mm=26)),
        replace(task, variant=replace(VARIANT, bridge="osb1_fixed")),
    ]
    assert len({run_key(each) for each in (task, *others)}) == 7
