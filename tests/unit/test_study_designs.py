"""Designs of a study: analyses of the next round, searches of an IDA."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fragility_tables import friction_rows
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.fragility.effects import effect_table
from skewbridge.fragility.verdicts import rounds_table
from skewbridge.motions.intensity import IM_COLUMNS
from skewbridge.motions.levels import LEVEL_MEASURE, MotionsConfig
from skewbridge.study import batch, rounds
from skewbridge.study.analyses import forecast_s
from skewbridge.study.batch import row_of_task, search_capacity, search_limits
from skewbridge.study.config import DesignConfig, parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import open_journal
from skewbridge.study.progress import other_work_s
from skewbridge.study.task import Task, run_key
from study_parts import study_of, task_of, wave

# --- rounds: selection, plan and demands


LOOKS = DesignConfig().looks
PLACES = pd.DataFrame(
    {"bridge": "b", "abutment": "a", "gap_mm": [25.0, 51.0] * 2, "friction": [0.0, 0.0, 0.5, 0.5]},
    index=["g25", "g51", "g25f", "g51f"],
)
EVEN = dict.fromkeys(PLACES.index, 12)


def asked(*parts: list[dict], cost: dict[str, float] | None = None) -> tuple:
    table = effect_table(PLACES, [row for rows in parts for row in rows])
    return rounds.targets(table, EVEN, cost or dict.fromkeys(EVEN, 1.0), PLACES, LOOKS, 0.90)


def test_only_open_cells_within_reach_ask_for_motions() -> None:
    scatters = {"deck_disp_m": 0.02, "column_drift_ratio": 0.12, "unseating_m": 1.5}
    cells = [friction_rows((sd, sd), demand=name, level=0.98) for name, sd in scatters.items()]
    table, (decided, within, beyond) = asked(*cells)
    assert table["asked"].tolist() == [False, True, False]
    assert not decided
    assert not beyond
    assert 12 < min(within.values()) <= max(within.values()) <= 64
    assert table["needed"].iloc[2] > 64


def test_pairs_that_scatter_more_get_more_motions_and_those_with_long_analyses_fewer() -> None:
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


def test_checks_fits_and_page_are_forecast_from_the_rate_of_the_analyses(tmp_path) -> None:
    # measured with two processors at 0.124 s per second of motions of 25 s: variants of the default
    # study under 12 motions 95 s, under 32 about 97 s (112 s less 15 s of fits that became faster),
    # including two analyses of 25 s that no rule repeats any more; checks 161 s at 0.121
    default = {"bridge": ["osb1", "osb1_fixed_era1"], "skew_deg": [0, 30, 60]}
    default |= {"gap_mm": [25, 51], "friction": [0.0, 0.5]}
    raw, folder = {"results": str(tmp_path), "grid": default}, StudyFolder(tmp_path)
    checked, study = parse_config(raw), parse_config(raw | {"sensitivity": {"rows": 0}})

    def work_s(study, processors: float = 2.0, rate: float = 0.121) -> float:
        per_s = forecast_s(25.0, "contact_friction", AnalysisSettings()) / 25.0
        return other_work_s(study, [25.0] * 32, rate / per_s, processors)

    assert work_s(study, rate=0.124) == pytest.approx(96.0 - 2 * 25.0 * 0.124, rel=0.03)
    tail_s, before_s = work_s(study), work_s(checked)
    assert work_s(study, 1.0) > 1.5 * tail_s
    assert work_s(study, 8.0) == tail_s
    assert before_s - tail_s == pytest.approx(161.0 / 2.0, rel=0.03)
    with open_journal(folder.journal("sensitivity")) as journal:
        journal.append({"run_key": "a", "wall_s": 30.0})
        journal.append({"run_key": "b", "wall_s": np.nan})  # its worker died
    assert work_s(checked) == pytest.approx(before_s - 15.0)
    folder.sensitivity.touch()
    assert work_s(checked) == tail_s


def plan(ended: str | None, **changes: object) -> dict[str, object]:
    content = {"round": 3, "ended": ended, "hours": 2.0, "analyses": 48, "forecast_s": 170.0}
    content |= {"motions": {"a": [12, 16], "b": [12, 12]}, "decided": 19, "cells": [{}] * 24}
    return content | changes


def test_a_plan_has_a_line_its_demands_and_motions_and_a_limit_of_time(tmp_path) -> None:
    start = "round 3: 19 of 24 decided; "
    assert rounds.round_line(plan(None)) == f"{start}next 48 analyses, about 3 min"
    assert rounds.round_line(plan("decided")) == f"{start}all headline effects are decided"
    assert "5 cannot be decided" in rounds.round_line(plan("most"))
    assert "set a larger value to resume" in rounds.round_line(plan("hours"))
    assert rounds.round_line(plan(None, cells=[])) == "round 3: next 48 analyses, about 3 min"
    folder = StudyFolder(tmp_path)
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(plan(None)))
    assert rounds.tables_of_round(folder, path) == [folder.round_demands(3, "a")]
    setup = study_of(tmp_path, *(wave(f"m{number}") for number in range(1, 6)))
    assert [each.motion.motion_id for each in setup.of_motions(1, 3).suite] == ["m2", "m3"]

    # only a plan that time ended is made again with more
    assert rounds.limit_of_round(tmp_path / "none.json", 9.0) == 9.0
    for ended, hours, limit in (("hours", 3, 3), ("hours", 1, 2), ("most", 9, 2), (None, 9, 2)):
        path.write_text(json.dumps(plan(ended)))
        assert rounds.limit_of_round(path, hours) == limit
    # a study in rounds prepares the largest number of motions
    assert parse_config({"design": {"until": "decided"}}).motions.count == 64
    chosen = {"design": {"until": "decided", "most": 40}, "motions": {"count": 32}}
    assert parse_config(chosen).motions.count == 40
    assert parse_config({"design": {"most": 40}}).motions.count == 32


def test_cells_of_all_rounds_are_one_table_and_one_figure() -> None:
    row = friction_rows((0.02, 0.02), level=0.98)[0]
    first = {"verdict": "undecided", "n_motions": 12, "needed": 30.0, "asked": True}
    first |= dict.fromkeys(("difference", "difference_low", "difference_high"))
    plans = [
        plan(None, round=1, analyses_before=0, cells=[]),
        plan(None, round=2, analyses_before=48, cells=[row | first]),
        plan("decided", analyses_before=64, cells=[row | first | {"verdict": "negligible"}]),
    ]
    table = rounds_table(plans)
    found = table[["round", "analyses", "verdict"]].to_numpy().tolist()
    assert found == [[1, 48, "undecided"], [2, 64, "negligible"]]
    assert rounds_table(plans[:1]).empty


# --- searches of capacities


IDA = MotionsConfig(level_range_g=(0.1, 2.0))  # of the column drift ratio, to 0.025
AT_1_G = 0.4  # Sa_avg of the motion at factor 1
CAPACITY_G = 0.77


def first_task(scale: float = 2.0) -> Task:
    measures = dict.fromkeys(IM_COLUMNS, 1.0) | {LEVEL_MEASURE: AT_1_G * scale}
    return task_of(replace(wave("m", scale=scale), measures=measures))


class Engine:
    """Stands for the analysis: drift in proportion to the factor, up to a collapse."""

    def __init__(self, capacity_g: float = CAPACITY_G, collapse_g: float = np.inf) -> None:
        self.capacity = capacity_g / AT_1_G
        self.collapse = collapse_g / AT_1_G
        self.factors: list[float] = []

    def analysed_row(self, task: Task, key: str, _log_folder: Path) -> dict:
        factor = task.motion.scale
        self.factors.append(factor)
        drift = IDA.ida_threshold * factor / self.capacity
        row = dict.fromkeys(("column_drift_ratio", "drift_over_capacity"), drift)
        row |= {"status": "collapse" if factor > self.collapse else "ok", "beyond_model": ""}
        return row_of_task(row, task, key)


@pytest.fixture
def engine(monkeypatch, tmp_path) -> Engine:
    made = Engine()
    monkeypatch.setattr(batch, "analysed_row", made.analysed_row)
    monkeypatch.chdir(tmp_path)
    return made


def first_factor(task: Task) -> float:
    return float(np.sqrt(np.prod(search_limits(IDA, task.motion))))


def searched(known=None, scale: float = 2.0) -> list[dict]:
    task = first_task(scale)
    first_key = run_key(first_task(first_factor(task)))
    return search_capacity(IDA, known or {}, Path("searches.jsonl"), task, first_key, Path("logs"))


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_the_capacity_is_bracketed_within_a_percent_whatever_factor_it_starts_from(engine, scale):
    rows = searched(scale=scale)
    levels_g = np.array([row[LEVEL_MEASURE] for row in rows])
    exceeds = np.array([row["column_drift_ratio"] >= IDA.ida_threshold for row in rows])
    below, above = levels_g[~exceeds].max(), levels_g[exceeds].min()
    assert below < CAPACITY_G <= above <= 1.01 * below
    np.testing.assert_allclose(levels_g, AT_1_G * np.array(engine.factors))
    low_g, high_g = IDA.level_range_g
    assert low_g <= levels_g.min() <= levels_g.max() <= high_g
    assert levels_g[0] == pytest.approx(np.sqrt(low_g * high_g))
    assert first_factor(first_task(scale)) == pytest.approx(engine.factors[0])
    assert len(rows) <= 11


def test_rows_are_those_of_analyses_at_their_own_factor_and_none_is_repeated(engine):
    rows = searched()
    tried = len(engine.factors)
    assert [row["scale"] for row in rows] == engine.factors
    assert {row["motion_id"] for row in rows} == {"m"}
    assert [row["run_key"] for row in rows] == [run_key(first_task(row["scale"])) for row in rows]
    known = {row["run_key"]: row for row in rows}
    assert len(known) == tried
    assert searched(known) == rows
    assert len(engine.factors) == tried
    assert searched(dict([*known.items()][:-2])) == rows
    assert len(engine.factors) == tried + 2


def test_a_collapse_counts_as_exceedance_below_the_threshold(engine):
    engine.collapse = 0.3 / AT_1_G  # long before the drift reaches its limit
    rows = searched()
    ended = [row[LEVEL_MEASURE] for row in rows if row["status"] == "collapse"]
    stood = [row[LEVEL_MEASURE] for row in rows if row["status"] == "ok"]
    assert max(stood) <= 0.3 <= min(ended) <= 1.01 * max(stood)


@pytest.mark.parametrize(("capacity_g", "limit_g"), [(0.01, 0.1), (50.0, 2.0)])
def test_a_capacity_outside_the_range_ends_the_search_at_the_limit(engine, capacity_g, limit_g):
    engine.capacity = capacity_g / AT_1_G
    assert searched()[-1][LEVEL_MEASURE] == pytest.approx(limit_g)


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
def test_the_search_goes_down_without_a_usable_result(row, exceeds, engine, monkeypatch):
    monkeypatch.setattr(batch, "analysed_row", lambda task, key, _: row_of_task(row, task, key))
    first, second, *_ = (each["scale"] for each in searched())
    assert (second < first) is exceeds
