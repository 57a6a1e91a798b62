"""Results of another version are reported and not used; files are written whole or not at all."""

import json
import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from skewbridge.analysis.accuracy import NUMERICS
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.demands.suspect import SuspectLimits
from skewbridge.errors import InputError
from skewbridge.files import tables
from skewbridge.files.digests import provenance
from skewbridge.files.text import written_aside
from skewbridge.study import batch
from skewbridge.study.analyses import StudySetup, analyse_variant
from skewbridge.study.batch import Workers, run_tasks
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.sensitivity import (
    REPEATS,
    demands_for,
    in_window,
    sampled_rows,
    sensitivity_table,
    write_sensitivity,
)
from skewbridge.study.task import no_result, run_key
from study_parts import row_of, study_of, wave

SLUG = "osb1_cf_skew30_gap025_mu050"


@pytest.fixture
def setup(tmp_path: Path) -> StudySetup:
    """A study of one motion."""
    return study_of(tmp_path / "results", wave("pulse"))


def text(value: object) -> str:
    """Return what can be compared: a time that never came is no number and equals nothing."""
    return json.dumps(value, sort_keys=True)


@pytest.fixture
def no_analyses(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("an analysis runs though the journal has it")

    monkeypatch.setattr("skewbridge.study.batch._Pool.stream", refuse)


@pytest.mark.usefixtures("no_analyses")
def test_names_and_measures_of_a_row_come_from_the_task(setup: StudySetup, tmp_path: Path) -> None:
    """The journal has the result of an analysis; the task states which analysis it is."""
    task = setup.tasks(SLUG)[0]
    twin = replace(
        task, motion=replace(task.motion, motion=replace(task.motion.motion, motion_id="twin"))
    )
    old = row_of(task) | {"im_pga_rotd50_g": 99.0, "motion_id": "an older name"}
    with open_journal(tmp_path / "v.jsonl") as journal:
        rows = run_tasks(
            [task, twin],
            journal,
            {run_key(task): old},
            workers=Workers(count=1),
            log_folder=tmp_path,
            on_finished=print,
        )
    assert text(rows[0]) == text(row_of(task))
    assert [row["motion_id"] for row in rows] == ["pulse", "twin"]


@pytest.mark.usefixtures("no_analyses")
def test_sensitivity_repeats_nothing_that_a_journal_has(setup: StudySetup) -> None:
    """The row of the study comes from the journal of its variant, the changes from the own one."""
    task = setup.tasks(SLUG)[0]
    with open_journal(setup.folder.journal("a_variant")) as journal:
        journal.append(row_of(task, 2.0))
    with open_journal(setup.folder.journal("sensitivity")) as journal:
        for change, value in zip(list(REPEATS)[1:], (1.6, 1.0, 4.0, 2.0, 2.5), strict=True):
            journal.append(row_of(REPEATS[change](task), value))
    output = setup.folder.sensitivity
    write_sensitivity(setup, [SLUG], count=1, window_s=6.0, workers=Workers(count=1), output=output)
    table = pd.read_parquet(setup.folder.sensitivity).set_index("demand").loc["deck_disp_m"]
    assert table["reference_mean_ratio"] == pytest.approx(1.25)
    assert table["reference_largest_change"] == pytest.approx(0.25)
    assert table["kn_half_largest_change"] == pytest.approx(1.0)
    assert table["kn_double_largest_change"] == pytest.approx(0.5)
    assert table["not_run"] == 0


def test_sensitivity_rows_differ_and_both_sides_are_analysed_for_the_window(setup) -> None:
    rows = sampled_rows(setup, [SLUG, SLUG, SLUG], 3, None)
    assert len(rows) == 3
    reference = REPEATS["reference"](rows[0])
    assert reference.settings.dt_s == NUMERICS["reference"]["analysis"]["dt_s"]
    assert reference.settings.event_halvings == 0
    assert reference.options.backwall_points > rows[0].options.backwall_points
    # a row no longer than its window is that of the study, whose journal has it
    for window_s, duration_s in ((None, None), (30.0, None), (6.0, 0.5)):
        short = replace(setup, settings=AnalysisSettings(duration_s=duration_s))
        row = sampled_rows(short, [SLUG], 1, window_s)[0]
        assert run_key(row) == run_key(short.tasks(SLUG)[0])
    task = setup.tasks(SLUG)[0]
    whole = task.motion.motion
    t_s = np.arange(0.0, 20.0, whole.dt_s)
    strong = 0.01 + np.exp(-((t_s - 12.0) ** 2))
    long = replace(whole, accel_1_mps2=strong * np.sin(9 * t_s), accel_2_mps2=0.0 * t_s)
    task = replace(task, motion=replace(task.motion, motion=long))
    row = in_window(task, 6.0)
    assert {name: REPEATS[name](row).motion.motion.duration_s for name in REPEATS} == (
        dict.fromkeys(REPEATS, pytest.approx(6.0, abs=2 * whole.dt_s))
    )
    # the window lies where the motion is strong, and the factor stays
    kept = np.square(row.motion.motion.accel_1_mps2).sum()
    assert kept > 0.95 * np.square(long.accel_1_mps2).sum()
    assert row.motion.scale == task.motion.scale
    assert run_key(row) != run_key(task)


def test_journal_lines_of_another_version_are_reported_and_not_used(setup, caplog, monkeypatch):
    task = setup.tasks(SLUG)[0]
    path = setup.folder.journal(SLUG)
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(row_of(task)) + "\n")
    assert read_content([path]).rows == {}
    monkeypatch.setattr(
        "skewbridge.study.batch._Pool.stream",
        lambda _, pending: ((number, [row_of(task)]) for number, task, _ in pending),
    )
    output = setup.folder.variant_demands(SLUG)
    with caplog.at_level(logging.WARNING, logger="skewbridge"):
        analyse_variant(
            setup, SLUG, workers=Workers(count=1), limits=SuspectLimits(), output=output
        )
    assert "The journals hold 1 line(s) of another version" in caplog.text
    assert text(read_content([path]).rows) == text({run_key(task): row_of(task)})


def test_a_table_of_another_version_or_of_none_is_refused_by_name(tmp_path, monkeypatch):
    path, frame = tmp_path / "part.parquet", pd.DataFrame({"a": [1.0]})
    frame.to_parquet(tmp_path / "mine.parquet")  # of another program
    assert tables.read_frame(tmp_path / "mine.parquet").equals(frame)
    tables.write_frame(frame, path, provenance())
    assert tables.read_frame(path).equals(frame)
    table = pq.read_table(path)
    monkeypatch.setattr(tables, "TABLE_FORMAT", tables.TABLE_FORMAT + 1)
    with pytest.raises(InputError, match=r"part\.parquet was written by another version .* again"):
        tables.read_frame(path)
    metadata = {k: v for k, v in table.schema.metadata.items() if b"format" not in k}
    pq.write_table(table.replace_schema_metadata(metadata), path)
    with pytest.raises(InputError, match=r"part\.parquet .*table format 1"):
        tables.read_frame(path)


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    path.write_text("before")

    def break_off() -> None:
        with written_aside(path) as part:
            part.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        break_off()
    assert [each.name for each in tmp_path.iterdir()] == ["plan.json"]
    assert path.read_text() == "before"


@pytest.mark.parametrize("message", ["", "WARNING: a step failed"])
def test_a_solver_without_messages_leaves_no_log(setup, tmp_path, monkeypatch, message):
    def analysed(_task, log, _go_on):
        log.write_text(message)
        return no_result("ok", "")

    monkeypatch.setattr(batch, "analyse_task", analysed)
    batch.analysed_row(setup.tasks(SLUG)[0], "key", tmp_path / "logs")
    assert [path.read_text() for path in (tmp_path / "logs").iterdir()] == [message] * bool(message)


def test_rows_that_fail_in_different_cycles_are_not_compared() -> None:
    """Their demands are peaks up to different times: 0.8 s apart here."""
    ends_s = {"default": 4.95, "reference": 4.17}
    rows = pd.DataFrame(
        {"row": row, "change": change, "status": "ok", "duration_s": 6.0}
        | dict.fromkeys(demands_for("sensitivity"), 2.0 if change == "default" else 1.0 + row)
        | {"beyond_model_s": ends_s.get(change, 4.95) if row == 0 else float("nan")}
        for row in (0, 1)
        for change in REPEATS
    )
    table = sensitivity_table(rows).set_index("demand").loc["unseating_m"]
    assert table["reference_largest_change"] == 0.0
    assert table["kn_half_largest_change"] == 1.0
