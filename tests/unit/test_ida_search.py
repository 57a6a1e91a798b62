"""The search of an IDA: brackets the capacity of a motion, repeats nothing, believes collapses."""

from pathlib import Path

import numpy as np
import pytest

from skewbridge.motions.intensity import IM_COLUMNS
from skewbridge.motions.levels import LEVEL_MEASURE
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.study import ida
from skewbridge.study.batch import row_of_task
from skewbridge.study.ida import Search, search_capacity
from skewbridge.study.task import Task, run_key
from study_parts import task_of

SEARCH = Search(demand="column_drift_ratio", threshold=0.025, low_g=0.1, high_g=2.0)
LOGS = Path("unused")
JOURNAL = Path("searches.jsonl")
AT_1_G = 0.4  # Sa_avg of the motion at factor 1
CAPACITY_G = 0.77


def first_task(scale: float = 2.0) -> Task:
    wave = np.array([0.0, 1.0, -1.0, 0.0])
    motion = GroundMotion(motion_id="m", dt_s=0.01, accel_1_mps2=wave, accel_2_mps2=0.5 * wave)
    measures = dict.fromkeys(IM_COLUMNS, 1.0) | {LEVEL_MEASURE: AT_1_G * scale}
    return task_of(SuiteMotion(motion=motion, scale=scale, measures=measures))


class Engine:
    """Stands for the analysis: drift in proportion to the factor, up to a collapse."""

    def __init__(self, capacity_g: float = CAPACITY_G, collapse_g: float = np.inf) -> None:
        self.capacity = capacity_g / AT_1_G
        self.collapse = collapse_g / AT_1_G
        self.factors: list[float] = []

    def analysed_row(self, task: Task, key: str, _log_folder: Path) -> dict:
        factor = task.motion.scale
        self.factors.append(factor)
        drift = SEARCH.threshold * factor / self.capacity
        status = "collapse" if factor > self.collapse else "ok"
        row = {
            "column_drift_ratio": drift,
            "drift_over_capacity": drift,
            "status": status,
            "beyond_model": "",
        }
        return row_of_task(row, task, key)


@pytest.fixture
def engine(monkeypatch, tmp_path) -> Engine:
    made = Engine()
    monkeypatch.setattr(ida, "analysed_row", made.analysed_row)
    monkeypatch.chdir(tmp_path)
    return made


def searched(known=None, scale: float = 2.0) -> list[dict]:
    task = first_task(scale)
    first_key = run_key(first_task(SEARCH.first_factor(task.motion)))
    return search_capacity(SEARCH, known or {}, JOURNAL, task, first_key, LOGS)


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_the_capacity_is_bracketed_within_a_percent_whatever_factor_it_starts_from(engine, scale):
    rows = searched(scale=scale)
    levels_g = np.array([row[LEVEL_MEASURE] for row in rows])
    below = levels_g[[row["column_drift_ratio"] < SEARCH.threshold for row in rows]].max()
    above = levels_g[[row["column_drift_ratio"] >= SEARCH.threshold for row in rows]].min()
    assert below < CAPACITY_G <= above <= 1.01 * below
    np.testing.assert_allclose(levels_g, AT_1_G * np.array(engine.factors))
    assert levels_g.min() >= SEARCH.low_g
    assert levels_g.max() <= SEARCH.high_g
    assert levels_g[0] == pytest.approx(np.sqrt(SEARCH.low_g * SEARCH.high_g))
    assert SEARCH.first_factor(first_task(scale).motion) == pytest.approx(engine.factors[0])
    assert len(rows) <= 11


def test_rows_are_those_of_analyses_at_their_own_factor(engine):
    for row, factor in zip(searched(), engine.factors, strict=True):
        assert row["scale"] == factor
        assert row["motion_id"] == "m"
    assert len({row["run_key"] for row in searched()}) == len(searched())


def test_finished_analyses_are_not_repeated(engine):
    rows = searched()
    tried = len(engine.factors)
    again = searched({row["run_key"]: row for row in rows})
    assert again == rows
    assert len(engine.factors) == tried
    part = searched({row["run_key"]: row for row in rows[:-2]})
    assert part == rows
    assert len(engine.factors) == tried + 2


def test_a_collapse_counts_as_exceedance_below_the_threshold(engine):
    engine.collapse = 0.3 / AT_1_G  # long before the drift reaches its limit
    rows = searched()
    ended = [row[LEVEL_MEASURE] for row in rows if row["status"] == "collapse"]
    stood = [row[LEVEL_MEASURE] for row in rows if row["status"] == "ok"]
    assert max(stood) <= 0.3 <= min(ended) <= 1.01 * max(stood)


@pytest.mark.parametrize(("capacity_g", "side"), [(0.01, "low_g"), (50.0, "high_g")])
def test_a_capacity_outside_the_range_ends_the_search_at_the_limit(engine, capacity_g, side):
    engine.capacity = capacity_g / AT_1_G
    levels_g = [row[LEVEL_MEASURE] for row in searched()]
    assert levels_g[-1] == pytest.approx(getattr(SEARCH, side))


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
def test_the_search_goes_down_where_an_analysis_cannot_be_believed(row, exceeds):
    assert SEARCH.exceeds(row) is exceeds


def test_the_key_of_a_trial_is_that_of_an_analysis_at_this_factor(engine):
    row = searched()[0]
    task = first_task(scale=row["scale"])
    assert row["run_key"] == run_key(task)
