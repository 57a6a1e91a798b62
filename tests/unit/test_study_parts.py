"""How the analyses of a study are shared out among jobs, and joined again."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.demands.suspect import SUSPECT, SuspectLimits, reasons
from skewbridge.demands.tables import to_table
from skewbridge.errors import InputError
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.provenance import tables as provenance_tables
from skewbridge.study.capacity_search import Search, at_factor
from skewbridge.study.config import parse_config
from skewbridge.study.costs import CPU_S_PER_MOTION_S, forecast_cpu_s
from skewbridge.study.folder import StudyFolder
from skewbridge.study.forecast import forecast_study, parts_of
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.keys import run_key
from skewbridge.study.plan import Plan, Planned, planned_keys, write_plan
from skewbridge.study.progress import study_state
from skewbridge.study.runs import collect_parts
from skewbridge.study.setup import StudySetup
from skewbridge.study.task import Task, no_result
from skewbridge.study.worker import identity_of
from skewbridge.variant.options import ModelOptions

SLUGS = (
    "osb1_cf_skew30_gap025_mu000",
    "osb1_cf_skew30_gap025_mu050",
    "osb1_ro_skew30_gap000_mu000",
)


def plan_of(costs_s: Sequence[float]) -> Plan:
    """Analyses of these costs, three to a variant."""
    return Plan(
        sections={},
        analyses=[
            Planned(variant=f"v{n // 3}", number=n % 3, run_key=f"key{n}", cpu_s=cost)
            for n, cost in enumerate(costs_s)
        ],
    )


@given(
    st.lists(st.sampled_from([0.0, 0.5, 3.0, 14.0]), min_size=1, max_size=30),
    st.integers(min_value=1, max_value=40),
)
def test_every_analysis_is_in_one_part(costs_s: list[float], count: int) -> None:
    plan = plan_of(costs_s)
    parts = [plan.part(number, count) for number in range(1, count + 1)]
    names = sorted(each.run_key for part in parts for each in part)
    assert names == sorted(each.run_key for each in plan.analyses)
    fair_s = sum(costs_s) / count
    for part in parts:
        costs = [each.cpu_s for each in part]
        assert sum(costs) <= fair_s + max(costs_s)
        assert costs == sorted(costs, reverse=True)


def test_small_variants_stay_together_and_a_large_one_is_cut() -> None:
    plan = plan_of([1.0] * 6 + [4.0] * 3)
    variants = [{each.variant for each in plan.part(number, 3)} for number in (1, 2, 3)]
    assert variants == [{"v0", "v1"}, {"v2"}, {"v2"}]


def test_what_is_done_weighs_nothing() -> None:
    """An extended study cuts its new analyses evenly, wherever they stand in the list."""
    plan = plan_of([0.0] * 12 + [1.0] * 6)
    new = [sum(each.cpu_s for each in plan.part(number, 2)) for number in (1, 2)]
    assert new == [3.0, 3.0]


def setup_in(folder: Path, lengths_s: Sequence[float] = (1.0, 3.0, 2.0)) -> StudySetup:
    suite: list[SuiteMotion] = []
    for length_s in lengths_s:
        t_s = np.arange(0.0, length_s, 0.01)
        motion = GroundMotion(
            motion_id=f"m{length_s:g}",
            dt_s=0.01,
            accel_1_mps2=np.cos(t_s * length_s),
            accel_2_mps2=np.sin(t_s),
        )
        measures = motion_measures(motion, 0.7)
        suite.append(SuiteMotion(motion=motion, scale=1.0, measures=measures))
    return StudySetup(
        folder=StudyFolder(folder),
        suite=tuple(suite),
        measures={("osb1", each.motion.motion_id): each.measures for each in suite},
        incidence_deg=(0.0,),
        settings=AnalysisSettings(),
        options=ModelOptions(),
    )


def row_of(task: Task, cpu_s: float = 1.0) -> dict[str, object]:
    demands = {column.name: 1.0 for column in DEMAND_COLUMNS}
    run = {**no_result("ok", ""), "duration_s": 1.0, "wall_s": cpu_s, "cpu_s": cpu_s}
    return {**demands, **run, **identity_of(task, run_key(task))}


def test_a_forecast_goes_by_length_and_by_what_was_measured(tmp_path: Path) -> None:
    setup = setup_in(tmp_path)
    tasks = [task for slug in SLUGS for task in setup.tasks(slug)]
    keys = [run_key(task) for task in tasks]
    constant = forecast_cpu_s(tasks, keys, {})
    assert constant[:3] == pytest.approx([n * CPU_S_PER_MOTION_S for n in (1, 3, 2)], rel=0.02)
    done = {keys[0]: row_of(tasks[0], 2.0), keys[6]: row_of(tasks[6], 0.1)}
    found = forecast_cpu_s(tasks, keys, done)
    assert found == pytest.approx([0.0, 6.0, 4.0, 2.0, 6.0, 4.0, 0.0, 0.3, 0.2], rel=0.02)
    short = [
        replace(task, settings=replace(task.settings, duration_s=0.5))
        for task in setup.tasks(SLUGS[0])
    ]
    assert len(set(forecast_cpu_s(short, ["a", "b", "c"], {}))) == 1
    crashed = {keys[0]: row_of(tasks[0], math.nan)}
    assert forecast_cpu_s(tasks, keys, crashed)[1:] == constant[1:]


def test_a_row_tells_its_analysis_that_of_a_search_at_its_own_factor(tmp_path: Path) -> None:
    plain = setup_in(tmp_path)
    search = Search(demand="deck_disp_m", threshold=0.1, low_g=0.1, high_g=2.0)
    searching = replace(plain, search=search)
    first = searching.tasks(SLUGS[1])[1]
    for setup, task in (
        (plain, plain.tasks(SLUGS[1])[2]),
        (searching, first),
        (searching, at_factor(first, 1.37)),
    ):
        found = setup.task_of(row_of(task))
        assert found is not None
        assert run_key(found) == run_key(task)
        assert found.motion.measures == task.motion.measures
    assert plain.task_of(row_of(at_factor(first, 1.37))) is None
    with pytest.raises(InputError, match=r"osb2s_.*: the study has the bridges osb1"):
        plain.tasks("osb2s_cf_skew30_gap025_mu050")


def write_part(plan: Plan, setup: StudySetup, number: int, count: int) -> Path:
    """Rows of a part as a job writes them, in the order in which they were analysed."""
    tasks = {slug: setup.tasks(slug) for slug in SLUGS}
    rows = [row_of(tasks[each.variant][each.number]) for each in plan.part(number, count)]
    path = setup.folder.part(number, count)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    return path


def test_one_part_and_four_make_the_same_tables(tmp_path: Path) -> None:
    found: list[list[pd.DataFrame]] = []
    digests: set[bytes] = set()
    for count in (1, 4):
        setup = setup_in(tmp_path / str(count))
        write_plan(setup, SLUGS, {})
        plan = Plan.read(setup.folder.plan)
        numbers = range(count, 0, -1)
        parts = [write_part(plan, setup, n, count) for n in numbers]
        collect_parts(setup.folder, parts, SuspectLimits())
        paths = [setup.folder.demands, *map(setup.folder.variant_demands, SLUGS)]
        found.append([pd.read_parquet(path) for path in paths])
        assert [len(table) for table in found[-1]] == [9, 3, 3, 3]
        digests.add(pq.read_schema(paths[0]).metadata[b"analyses_digest"])
    for one, four in zip(*found, strict=True):
        pd.testing.assert_frame_equal(one, four)
    assert len(digests) == 1


def test_the_joined_table_is_that_of_all_rows_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However few rows are held at a time, the file has all of them in the order of the key."""
    monkeypatch.setattr(provenance_tables, "_GROUP_ROWS", 4)
    setup, limits = setup_in(tmp_path), SuspectLimits()
    write_plan(setup, SLUGS, {})
    plan = Plan.read(setup.folder.plan)
    parts = [write_part(plan, setup, n, 2) for n in (2, 1)]
    collect_parts(setup.folder, parts, limits)
    rows = [row_of(task) for slug in reversed(SLUGS) for task in setup.tasks(slug)]
    whole = to_table([{**row, SUSPECT: reasons(row, limits)} for row in rows], {})
    file = pq.ParquetFile(setup.folder.demands)
    assert file.num_row_groups == 2
    pd.testing.assert_frame_equal(file.read().to_pandas(), whole.to_pandas(), check_exact=True)
    assert [field.metadata for field in file.schema_arrow] == [
        field.metadata for field in whole.schema
    ]


def test_a_part_of_another_plan_is_refused(tmp_path: Path) -> None:
    setup = setup_in(tmp_path)
    write_plan(setup, SLUGS, {})
    part = write_part(Plan.read(setup.folder.plan), setup, 1, 1)
    edited = replace(setup, settings=AnalysisSettings(duration_s=0.5))
    write_plan(edited, SLUGS, {})
    with pytest.raises(InputError, match=r"3 of 3 analyses have no row"):
        collect_parts(setup.folder, [part], SuspectLimits())
    assert not setup.folder.demands.exists()


def test_every_journal_of_the_folder_counts(tmp_path: Path) -> None:
    """However the analyses were cut when they ran, what is done is done."""
    setup = setup_in(tmp_path)
    tasks = setup.tasks(SLUGS[0])
    for name, task in zip(
        ("analyses_1_of_2", "analyses_1_of_1", "sensitivity"), tasks, strict=True
    ):
        with open_journal(setup.folder.journal(name)) as journal:
            journal.append(row_of(task))
    write_plan(setup, SLUGS[:2], {})
    state = study_state(planned_keys(setup.folder), read_content(setup.folder.journals))
    assert (state.analyses, state.done, state.left) == (6, 3, 3)
    assert [each.cpu_s == 0.0 for each in Plan.read(setup.folder.plan).analyses] == [True] * 3 + [
        False
    ] * 3


def test_a_plan_of_another_version_is_none(tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path)
    assert planned_keys(folder) == {}
    folder.plan.write_text(json.dumps({SLUGS[0]: ["a key"]}))
    assert planned_keys(folder) == {}


def test_a_cluster_has_as_many_parts_as_its_hours_ask_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    study = parse_config({"results": str(tmp_path)})
    hours = 768 * 25.0 * CPU_S_PER_MOTION_S / 3600
    assert parts_of(study, 2.0 * hours) == 1
    assert parts_of(study, hours / 3.9) == 4
    assert parts_of(study, 1e-6) == 768


def test_the_cost_of_a_study_of_searches_is_that_of_all_their_analyses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    given, searching = (
        forecast_study(
            parse_config(
                {
                    "results": str(tmp_path),
                    "motions": {"design": design, "level_range_g": [0.05, 5.0]},
                }
            )
        )
        for design in ("scaled_cloud", "ida")
    )
    assert searching.summary["analyses"] == given.summary["analyses"]
    assert searching.summary["core_hours"] == pytest.approx(
        10 * given.summary["core_hours"], rel=1e-3
    )
    assert searching.notes == ("Counted are searches of up to 10 analyses; the cost is of all.",)
