"""Keys of analyses, jobs of a variant and their journal, versions of tables; rounds, searches."""

import json
import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from fragility_tables import friction_rows
from motions_files import index_of, make_pairs
from skewbridge.analysis.settings import NUMERICS, AnalysisSettings
from skewbridge.bridge import catalogue, library
from skewbridge.demands.tables import join_variants, to_table
from skewbridge.demands.validity import with_suspect
from skewbridge.errors import InputError
from skewbridge.files import digests, tables
from skewbridge.files.text import merged, writable_folder, written_aside
from skewbridge.fragility import effects
from skewbridge.motions.intensity import IM_COLUMNS
from skewbridge.motions.levels import LEVEL_MEASURE, MotionsConfig
from skewbridge.motions.suite import content_digest, prepare_suite, read_suite, write_suite
from skewbridge.study import analyses, batch, progress, repeats, rounds
from skewbridge.study import task as task_module
from skewbridge.study.analyses import StudySetup, forecast_s
from skewbridge.study.batch import at_factor, row_of_task, search_capacity, search_limits
from skewbridge.study.config import DesignConfig, SensitivityConfig, parse_config
from skewbridge.study.folder import StudyFolder, limit_of_round, round_line, tables_of_round
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.task import Task, no_result, run_key
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.variant.options import ModelOptions
from study_parts import in_journal, row_of, study_of, task_of, wave, without_workers

MODELS = ("cf_skew30_gap025_mu000", "cf_skew30_gap025_mu050", "ro_skew30_gap000_mu000")
SLUGS = [f"osb1_{model}" for model in MODELS]
SLUG = SLUGS[1]
IDA = MotionsConfig(level_range_g=(0.1, 2.0))  # of the column drift ratio, to 0.025
AT_1_G, CAPACITY_G = 0.4, 0.77  # Sa_avg of the motion at factor 1, and at its capacity
LOOKS = DesignConfig().looks
PLACES = pd.DataFrame(
    {"bridge": "b", "abutment": "a", "gap_mm": [25.0, 51.0] * 2, "friction": [0.0, 0.0, 0.5, 0.5]},
    index=["g25", "g51", "g25f", "g51f"],
)
EVEN = dict.fromkeys(PLACES.index, 12)


def test_the_key_covers_the_values_of_a_motion_but_not_its_names_and_measures(tmp_path):
    motions = []
    for dt_s, unit in ((0.01, "g"), (0.02, "g"), (0.01, "m/s2")):
        index_of(tmp_path, make_pairs(tmp_path, 1), scale=[1.0], dt_s=[dt_s], unit=[unit])
        write_suite(prepare_suite(tmp_path, t1_s=0.7), tmp_path / "suite.parquet")
        motions += read_suite(tmp_path / "suite.parquet")
    one, *others = motions
    first, second = one.motion.components
    turned = replace(one, motion=one.motion.with_components(first, -second))
    assert {each.motion.sha256 for each in (*others, turned)} == {one.motion.sha256}
    assert len({run_key(task_of(each)) for each in (one, *others, turned)}) == 4
    named = replace(one, motion=replace(one.motion, motion_id="b", event="E"), measures={})
    as_numpy = replace(one, scale=np.float64(one.scale))
    assert {run_key(task_of(each)) for each in (one, named, as_numpy)} == {run_key(task_of(one))}


def test_every_setting_that_matters_and_the_solver_are_in_the_key(monkeypatch) -> None:
    task = task_of()
    changes = (
        {"incidence_deg": 90.0}, {"motion": replace(task.motion, scale=1.1)},
        {"settings": AnalysisSettings(dt_s=0.004)}, {"options": ModelOptions(cohesion_n=1.0)},
        {"variant": replace(task.variant, gap_mm=26)},
        {"variant": replace(task.variant, bridge="osb1_fixed")},
    )  # fmt: skip
    keys = {run_key(task), *(run_key(replace(task, **change)) for change in changes)}
    monkeypatch.setattr(task_module, "opensees_version", lambda: "9.9")
    assert len(keys | {run_key(task)}) == 8


def test_numbers_of_its_parent_and_no_texts_change_the_digest_of_a_bridge(tmp_path: Path) -> None:
    parent = (catalogue.FOLDER / "osb1.yaml").read_text()
    digests = []
    for period_s, title in (("0.741", "Mine"), ("0.741", "Ours"), ("0.742", "Mine")):
        (tmp_path / "parent.yaml").write_text(parent.replace("0.7192", period_s, 1))
        (tmp_path / "mine.yaml").write_text(f"extends: parent\ntitle: {title}\n")
        digests.append(library.load_structure(str(tmp_path / "mine.yaml")).digest)
    assert digests[0] == digests[1] != digests[2]


def test_values_and_index_of_the_motions_in_use_change_the_digest_of_their_folder(tmp_path):
    """Times, notes, places of files and motions that the study does not use do not count."""
    (folder := tmp_path / "motions").mkdir()
    index = index_of(folder, make_pairs(folder, 3), scale=[1.0, 1.0, 1.0])

    def digests(folder: Path, cache: str = "digest.json") -> list[str]:
        return [content_digest(folder, count, tmp_path / cache) for count in (2, None)]

    before = digests(folder)
    (folder / "README.md").write_text("a note")
    for path in folder.iterdir():
        path.touch()
    assert digests(folder) == before
    used, unused = (next(folder.glob(f"{name}*.AT2")) for name in ("q0", "q2"))
    values = " 1.0E-3\n"
    for path, old, new, same in (
        (used, "\n", values, [False, False]), (unused, "\n", values, [True, False]),
        (index, "q1,", "r1,", [False, False]),
    ):  # fmt: skip
        kept = path.read_text()
        path.write_text(new.join(kept.rsplit(old, 1)))
        assert [one == other for one, other in zip(digests(folder), before, strict=True)] == same
        path.write_text(kept)
        assert digests(folder) == before
    assert digests(folder.rename(tmp_path / "elsewhere"), "other.json") == before


def setup_in(folder: Path, lengths_s: Sequence[float] = (1.0, 3.0, 2.0), **sections) -> StudySetup:
    waves = (wave(f"m{s:g}", duration_s=s, number=s) for s in lengths_s)
    grid = GridConfig(abutment=("contact_friction", "roller"))
    return study_of(folder, *waves, grid=grid, **sections)


def test_the_analysis_of_a_row_is_found_also_in_a_search(tmp_path: Path) -> None:
    plain = setup_in(tmp_path)
    ida = MotionsConfig(design="ida", ida_demand="deck_disp_m", level_range_g=(0.1, 2.0))
    searching = setup_in(tmp_path, motions=ida)
    first = searching.tasks(SLUGS[1])[1]
    pairs = (plain, plain.tasks(SLUGS[1])[2]), (searching, first)
    for setup, task in (*pairs, (searching, at_factor(first, 1.37))):
        found = setup.task_of(row_of(task))
        assert run_key(found) == run_key(task)
        assert found.motion.measures == task.motion.measures
    assert plain.task_of(row_of(at_factor(first, 1.37))) is None
    with pytest.raises(InputError, match=r"osb2s_.*: not a variant of the grid"):
        plain.tasks("osb2s_cf_skew30_gap025_mu050")


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list:
    return without_workers(monkeypatch)


def analyse(setup: StudySetup, slug: str) -> Path:
    output = setup.folder.variant_demands(slug)
    analyses.analyse_variant(setup, slug, output)
    return output


def test_the_longest_analyses_begin_first_and_none_is_repeated(tmp_path, ran, monkeypatch) -> None:
    setup = setup_in(tmp_path)
    # names and measures come from the task
    known = setup_in(tmp_path, (1.0, 3.0)).tasks(SLUGS[0])[1]
    old = row_of(known) | {"im_pga_rotd50_g": 99.0, "motion_id": "an older name"}
    in_journal(setup.folder.journal(SLUGS[0]), old)
    first = pd.read_parquet(analyse(setup, SLUGS[0]))
    assert [task.motion.motion.motion_id for task in ran] == ["m2", "m1"]
    assert first["motion_id"].tolist() == ["m1", "m2", "m3"]
    assert first["im_pga_rotd50_g"].max() < 1.0
    again = pd.read_parquet(analyse(setup, SLUGS[0]))
    assert len(ran) == 2
    pd.testing.assert_frame_equal(first, again)
    # a variant that another process analyses is refused
    monkeypatch.setattr(analyses, "PREDECESSOR_S", 0.0)
    with (
        open_journal(setup.folder.journal(SLUGS[1])),
        pytest.raises(InputError, match="being written by another process"),
    ):
        analyse(setup, SLUGS[1])
    assert len(ran) == 2


def test_the_joined_table_is_that_of_all_rows_at_once(tmp_path, ran, monkeypatch):
    monkeypatch.setattr(tables, "_GROUP_ROWS", 4)
    setup = setup_in(tmp_path)
    join_variants([analyse(setup, slug) for slug in SLUGS], setup.folder.demands)
    rows = [row_of(task) for slug in reversed(SLUGS) for task in setup.tasks(slug)]
    whole = to_table(map(with_suspect, rows), {})
    file = pq.ParquetFile(setup.folder.demands)
    assert file.num_row_groups == 2
    pd.testing.assert_frame_equal(file.read().to_pandas(), whole.to_pandas(), check_exact=True)
    metadata = [[field.metadata for field in each] for each in (file.schema_arrow, whole.schema)]
    assert metadata[0] == metadata[1]


def test_the_cost_of_a_study_of_searches_is_that_of_all_their_analyses(tmp_path, in_the_repository):
    raw = {"results": str(tmp_path), "motions": {"level_range_g": [0.05, 5.0]}}
    raw["grid"] = {"bridge": ["docs/bridges/simple_spans.yaml"]}
    designs = ({"motions": {"design": name}} for name in ("scaled_cloud", "ida", "stripes"))
    one, ten, seven = (progress.forecast_study(parse_config(merged(raw, it))) for it in designs)
    assert ten.summary["analyses"] == one.summary["analyses"] == seven.summary["analyses"] / 7
    cost_s, ten_s = one.summary["cpu_s"], ten.summary["cpu_s"]
    assert ten_s["analyses"] == pytest.approx(10 * cost_s["analyses"], rel=1e-3)
    assert ten_s["other"] == cost_s["other"]
    assert ten.notes[0] == "Each count is a search of up to 10 analyses; the cost covers all."
    assert ten.notes[1].startswith("Analyses of docs/bridges/simple_spans.yaml can take up to 9")


def test_values_on_axes_and_bridges_from_any_path_reach_the_analyses(written) -> None:
    path = written("extends: osb1\nbase: fixed\n")
    grid = {"transverse_gap_mm": [12.5, 25.4], "backwall_points": [7], "abutment": ["roller"]}
    grid |= {"bridge": [path, "osb1"], "skew_deg": [30]}
    model = {"keys": "monolithic", "transverse_gap_mm": 3.0}
    study = parse_config({"grid": grid, "model": model})
    setup = study_of("results", bridges=study.grid.bridge, grid=study.grid, model=study.model)
    variants = expand_grid(study.grid)
    tasks = [setup.tasks(variant.slug)[0] for variant in variants]
    assert [task.variant for task in tasks] == variants
    assert {task.options.transverse_gap_m for task in tasks} == {0.0125, 0.0254}
    found = {(task.options.keys, task.options.backwall_points) for task in tasks}
    assert found == {("monolithic", 7)}


@pytest.fixture
def setup(tmp_path: Path) -> StudySetup:
    return study_of(tmp_path / "results", wave("pulse"), sensitivity=SensitivityConfig(rows=1))


def test_sensitivity_repeats_nothing_that_a_journal_has(setup: StudySetup, ran, monkeypatch):
    repeats.write_sensitivity(setup, [SLUG], setup.folder.sensitivity)
    assert pd.read_parquet(setup.folder.sensitivity).empty  # a small study repeats no row
    monkeypatch.setattr(analyses, "CHECK_SHARE", 4.0)  # as in a study of more motions
    assert analyses.check_plan(setup.study, setup.durations_s)[0] == 1
    task = setup.tasks(SLUG)[0]
    in_journal(setup.folder.journal("a_variant"), row_of(task, 2.0))
    values = zip([*repeats.REPEATS.values()][1:], (1.6, 1.0, 4.0, 2.0, 2.5), strict=True)
    rows = (row_of(repeat(task), value) for repeat, value in values)
    in_journal(setup.folder.journal("sensitivity"), *rows)
    repeats.write_sensitivity(setup, [SLUG], setup.folder.sensitivity)
    table = pd.read_parquet(setup.folder.sensitivity).set_index("demand").loc["deck_disp_m"]
    expected = {"reference_largest_change": 0.25, "reference_mean_ratio": 1.25, "not_run": 0}
    expected |= {"kn_half_largest_change": 1.0, "kn_double_largest_change": 0.5}
    assert dict(table[[*expected]]) == pytest.approx(expected)
    assert not ran


def test_sensitivity_rows_differ_and_both_sides_are_analysed_for_the_window(setup) -> None:
    rows = repeats.sampled_rows(setup, [SLUG, SLUG, SLUG], 3)
    assert len(rows) == 3
    reference = repeats.REPEATS["reference"](rows[0])
    assert reference.settings.dt_s == NUMERICS["reference"]["analysis"]["dt_s"]
    assert reference.settings.event_halvings == 0
    assert reference.options.backwall_points > rows[0].options.backwall_points
    # an analysis that is shorter than the window keeps the key that it has in the study
    short = study_of("results", wave("pulse"), analysis=AnalysisSettings(duration_s=0.5))
    assert run_key(repeats.sampled_rows(short, [SLUG], 1)[0]) == run_key(short.tasks(SLUG)[0])
    task = setup.tasks(SLUG)[0]
    whole = task.motion.motion
    t_s = np.arange(0.0, 20.0, whole.dt_s)
    strong = 0.01 + np.exp(-((t_s - 12.0) ** 2))
    long = replace(whole, accel_1_mps2=strong * np.sin(9 * t_s), accel_2_mps2=0.0 * t_s)
    task = replace(task, motion=replace(task.motion, motion=long))
    row = repeats.in_window(task, 6.0)
    durations_s = [repeat(row).motion.motion.duration_s for repeat in repeats.REPEATS.values()]
    assert durations_s == pytest.approx([6.0] * len(durations_s), abs=2 * whole.dt_s)
    # the window lies where the motion is strong, and the factor stays
    kept = np.square(row.motion.motion.accel_1_mps2).sum()
    assert kept > 0.95 * np.square(long.accel_1_mps2).sum()
    assert row.motion.scale == task.motion.scale
    assert run_key(row) != run_key(task)


def test_journal_lines_of_another_version_are_reported_and_not_used(setup, caplog, ran):
    task = setup.tasks(SLUG)[0]
    path = setup.folder.journal(SLUG)
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(row_of(task)) + "\n")
    assert read_content([path]).rows == {}
    with caplog.at_level(logging.WARNING, logger="skewbridge"):
        analyse(setup, SLUG)
    assert len(ran) == 1
    assert "The journals hold 1 line(s) of another version" in caplog.text
    assert read_content([path]).rows.keys() == {run_key(task)}


def test_a_table_of_another_version_or_of_none_is_refused_by_name(tmp_path, monkeypatch):
    path, frame = tmp_path / "part.parquet", pd.DataFrame({"a": [1.0]})
    frame.to_parquet(path)  # of another program
    assert tables.read_frame(path).equals(frame)
    tables.write_frame(frame, path, digests.provenance())
    assert tables.read_frame(path).equals(frame)
    table = pq.read_table(path)
    monkeypatch.setattr(tables, "TABLE_FORMAT", tables.TABLE_FORMAT + 1)
    with pytest.raises(InputError, match=r"part\.parquet was written by another version .* again"):
        tables.read_frame(path)
    metadata = {k: v for k, v in table.schema.metadata.items() if b"format" not in k}
    pq.write_table(table.replace_schema_metadata(metadata), path)
    with pytest.raises(InputError, match=r"part\.parquet .*table format 1"):
        tables.read_frame(path)


def test_a_file_is_written_whole_and_apart_from_that_of_another_node(tmp_path, monkeypatch):
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
    with written_aside(path) as first:
        first.write_text("first")
        monkeypatch.setattr("socket.gethostname", lambda: "another")  # with the same process id
        with written_aside(path) as second:
            second.write_text("second")
        assert first != second
        assert writable_folder(tmp_path) == tmp_path
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("message", ["", "WARNING: a step failed"])
def test_a_solver_without_messages_leaves_no_log(setup, tmp_path, monkeypatch, message):
    def analysed(_task, log, _go_on):
        log.write_text(message)
        return no_result("ok", "")

    monkeypatch.setattr(batch, "analyse_task", analysed)
    batch.analysed_row(setup.tasks(SLUG)[0], "key", tmp_path / "logs")
    assert [path.read_text() for path in (tmp_path / "logs").iterdir()] == [message] * bool(message)


def test_rows_that_fail_in_different_cycles_are_not_compared() -> None:
    ends_s = {"default": 4.95, "reference": 4.17}  # demands are peaks up to different times
    places = pd.MultiIndex.from_product([(0, 1), repeats.REPEATS], names=["row", "change"])
    rows = places.to_frame(index=False).assign(status="ok", duration_s=6.0)
    value = np.where(rows["change"] == "default", 2.0, 1.0 + rows["row"])
    rows = rows.assign(**dict.fromkeys(repeats.demands_for("sensitivity"), value))
    rows["beyond_model_s"] = rows["change"].map(ends_s).fillna(4.95).where(rows["row"] == 0)
    for status, largest in (("ok", 0.0), ("timeout", np.nan)):  # no run at the reference accuracy
        rows.loc[rows["change"] == "reference", "status"] = status
        table = repeats.sensitivity_table(rows).set_index("demand").loc["unseating_m"]
        changes = [table[f"{name}_largest_change"] for name in ("reference", "kn_half")]
        assert changes == pytest.approx([largest, 1.0], nan_ok=True)


def asked(*parts: list[dict], cost: dict[str, float] | None = None) -> tuple:
    table = effects.effect_table(PLACES, [row for rows in parts for row in rows])
    return rounds.targets(table, EVEN, cost or dict.fromkeys(EVEN, 1.0), PLACES, LOOKS, 0.90)


def test_only_open_cells_within_reach_ask_for_motions() -> None:
    scatters = {"deck_disp_m": 0.02, "column_drift_ratio": 0.12, "unseating_m": 1.5}
    cells = [friction_rows((sd, sd), demand=name, level=0.98) for name, sd in scatters.items()]
    table, (decided, within, beyond) = asked(*cells)
    assert table["asked"].tolist() == [False, True, False]
    assert decided == beyond == {}
    assert 12 < min(within.values()) <= max(within.values()) <= 64
    assert table["needed"].iloc[2] > 64
    # pairs that scatter more get more motions, and those with long analyses fewer
    _, (wanted,) = asked(friction_rows((0.06, 0.12), level=0.98))
    assert wanted["g51"] == wanted["g51f"]
    assert wanted["g51"] / wanted["g25"] == pytest.approx(2.0, rel=0.1)
    cost = dict(zip(EVEN, (1.0, 4.0, 1.0, 4.0), strict=True))
    _, (wanted,) = asked(friction_rows((0.1, 0.1), level=0.98), cost=cost)
    assert wanted["g25"] / wanted["g51"] == pytest.approx(2.0, rel=0.1)


def test_a_round_has_the_cheapest_decisions_that_fit_into_the_time() -> None:
    cost = dict.fromkeys(EVEN, 10.0)
    wanted = [{"g25": 40, "g25f": 40}, {"g51": 20, "g51f": 20}, {}]
    assert rounds.next_motions(wanted, EVEN, cost, LOOKS, 200.0) == dict.fromkeys(EVEN, 16)
    assert rounds.next_motions(wanted, EVEN, cost, LOOKS, 100.0) == EVEN | {"g51": 16, "g51f": 16}
    assert rounds.next_motions(wanted, EVEN, cost, LOOKS, 50.0) == EVEN
    # the first round is shorter where the time is short
    cases = (0, 1e6, 12), (0, 130.0, 3), (0, -1.0, 0), (3, 90.0, 5), (3, 800.0, 12)
    # nine more motions would take 360 of 400 s: half of them first
    for before, time_s, count in (*cases, (3, 400.0, 8)):
        counts = rounds.first_motions(dict.fromkeys(EVEN, before), cost, 12, time_s)
        assert counts == dict.fromkeys(EVEN, count)


def test_checks_fits_and_page_are_forecast_from_the_rate_of_the_analyses(tmp_path, monkeypatch):
    # measured on two processors at 0.121 s per s of 25 s motions: checks of 6 s 161 s; at 0.124
    # fits and page of the default study under 32 motions 96 s, with two analyses no longer repeated
    default = {"bridge": ["osb1", "osb1_fixed_era1"], "skew_deg": [0, 30, 60]}
    default |= {"gap_mm": [25, 51], "friction": [0.0, 0.5]}
    raw, folder = {"results": str(tmp_path), "grid": default}, StudyFolder(tmp_path)
    monkeypatch.setattr(analyses, "CHECK_WINDOW_S", 6.0)
    checks = {}, {"rows": 0}
    checked, study = (parse_config(raw | {"sensitivity": check}) for check in checks)

    def work_s(study, processors: float = 2.0, rate: float = 0.121) -> float:
        per_s = forecast_s(25.0, "contact_friction", AnalysisSettings()) / 25.0
        return progress.other_work_s(study, [25.0] * 32, rate / per_s, processors)

    assert work_s(study, rate=0.124) == pytest.approx(96.0 - 2 * 25.0 * 0.124, rel=0.03)
    tail_s, before_s = work_s(study), work_s(checked)
    assert work_s(study, 1.0) > 1.5 * tail_s
    assert work_s(study, 8.0) == tail_s
    assert before_s - tail_s == pytest.approx(161.0 / 2.0, rel=0.03)
    rows = {"run_key": "a", "wall_s": 30.0}, {"run_key": "b", "wall_s": np.nan}  # its worker died
    in_journal(folder.journal("sensitivity"), *rows)
    assert work_s(checked) == pytest.approx(before_s - 15.0)
    folder.sensitivity.touch()
    assert work_s(checked) == tail_s


PLAN = {"round": 3, "ended": None, "hours": 2.0, "analyses": 48, "forecast_s": 170.0, "decided": 19,
        "motions": {"a": [12, 16], "b": [12, 12]}, "cells": [{}] * 24}  # fmt: skip


def test_a_plan_has_a_line_its_demands_and_motions_and_a_limit_of_time(tmp_path) -> None:
    decided = "19 of 24 headline effects decided"
    assert round_line(PLAN) == f"round 3: {decided}; next 48 analyses, about 3 min"
    end = f"rounds ended after round 2: {decided}; the most motions (design.most, or"
    assert round_line(PLAN | {"ended": "most"}).startswith(end)
    folder = StudyFolder(tmp_path)
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(PLAN))
    assert tables_of_round(folder, path) == [folder.round_demands(3, "a")]
    setup = study_of(tmp_path, *(wave(f"m{number}") for number in range(1, 6)))
    assert [each.motion.motion_id for each in setup.of_motions(1, 3).suite] == ["m2", "m3"]
    # only a plan that time ended is made again with more
    assert limit_of_round(tmp_path / "none.json", 9.0) == 9.0
    for ended, hours, limit in (("hours", 3, 3), ("hours", 1, 2), ("most", 9, 2), (None, 9, 2)):
        path.write_text(json.dumps(PLAN | {"ended": ended}))
        assert limit_of_round(path, hours) == limit
    # a study in rounds prepares the largest number of motions
    assert parse_config({"design": {"until": "decided"}}).motions.count == 64
    chosen = {"design": {"until": "decided", "most": 40}, "motions": {"count": 32}}
    assert parse_config(chosen).motions.count == 40
    assert parse_config({"design": {"most": 40}}).motions.count == 32


def first_task(scale: float = 2.0) -> Task:
    measures = dict.fromkeys(IM_COLUMNS, 1.0) | {LEVEL_MEASURE: AT_1_G * scale}
    return task_of(replace(wave("m", scale=scale), measures=measures))


@pytest.fixture
def factors(monkeypatch, tmp_path) -> list[float]:
    analysed: list[float] = []

    def analysed_row(task: Task, key: str, _log_folder: Path) -> dict:
        analysed.append(task.motion.scale)
        level_g = AT_1_G * task.motion.scale
        drift = IDA.ida_threshold * level_g / CAPACITY_G
        row = dict.fromkeys(("column_drift_ratio", "drift_over_capacity"), drift)
        return row_of_task(row | {"status": "ok", "beyond_model": ""}, task, key)

    monkeypatch.setattr(batch, "analysed_row", analysed_row)
    monkeypatch.chdir(tmp_path)
    return analysed


def searched(known=None) -> list[dict]:
    task = first_task()
    first_factor = float(np.sqrt(np.prod(search_limits(IDA, task.motion))))
    first_key = run_key(first_task(first_factor))
    return search_capacity(IDA, known or {}, Path("searches.jsonl"), task, first_key, Path("logs"))


def test_rows_are_those_of_analyses_at_their_own_factor_and_none_is_repeated(factors):
    rows = searched()
    tried = len(factors)
    assert [row["scale"] for row in rows] == factors
    assert [row["run_key"] for row in rows] == [run_key(first_task(row["scale"])) for row in rows]
    levels_g = np.array([row[LEVEL_MEASURE] for row in rows])
    np.testing.assert_allclose(levels_g, AT_1_G * np.array(factors))
    assert levels_g[0] == pytest.approx(np.sqrt(np.prod(IDA.level_range_g)))
    exceeds = np.array([row["column_drift_ratio"] >= IDA.ida_threshold for row in rows])
    below, above = levels_g[~exceeds].max(), levels_g[exceeds].min()
    assert below < CAPACITY_G <= above <= 1.01 * below
    known = {row["run_key"]: row for row in rows}
    assert len(known) == tried
    assert searched(known) == rows
    assert len(factors) == tried
    assert searched(dict([*known.items()][:-2])) == rows
    assert len(factors) == tried + 2


@pytest.mark.parametrize(
    ("row", "exceeds"),
    [
        ({"status": "ok", "column_drift_ratio": 0.0249}, False),
        ({"status": "ok", "column_drift_ratio": 0.025}, True),
        ({"status": "ok", "beyond_model": "shear", "column_drift_ratio": 0.001}, True),
        ({"status": "collapse", "column_drift_ratio": 0.001}, True),
        ({"status": "numerical_failure", "column_drift_ratio": 0.001}, True),
        ({"status": "crash", "column_drift_ratio": float("nan")}, True),
    ],
)
def test_the_search_goes_down_without_a_usable_result(row, exceeds, factors, monkeypatch):
    monkeypatch.setattr(batch, "analysed_row", lambda task, key, _: row_of_task(row, task, key))
    first, second, *_ = (each["scale"] for each in searched())
    assert (second < first) is exceeds
