"""Completeness of runs and the demand over capacity of columns, with what older tables lack."""

import numpy as np
import pandas as pd
import pytest

from skewbridge.analysis.peaks import ModelEnd
from skewbridge.analysis.transient import AnalysisResult
from skewbridge.demands.completeness import (
    column_failure_ratio,
    failure_kinds,
    is_beyond_model,
    is_complete,
    with_derived_columns,
)
from skewbridge.study.task import no_result, outcome_of
from skewbridge.study.worker import derived_columns

RUNS = pd.DataFrame(
    {
        "status": ["ok", "ok", "ok", "collapse", "collapse", "numerical_failure", "crash"],
        "beyond_model": ["", "shear", "flexure", "", "flexure", "", None],
        "column_shear_dcr": [0.5, 1.1, 0.7, 0.4, np.nan, np.nan, np.nan],
        "drift_over_capacity": [0.2, 0.6, 1.2, np.nan, 1.3, np.nan, np.nan],
    }
)
RATIOS = [0.5, 1.1, 1.2, 0.4, 1.3, np.nan, np.nan]


def test_only_a_finished_run_without_column_failure_is_complete() -> None:
    assert is_complete(RUNS).tolist() == [True, *[False] * 6]
    assert failure_kinds(RUNS).tolist() == ["", "shear", "flexure", "", "flexure", "", ""]
    assert is_beyond_model(RUNS).tolist() == [False, True, True, False, True, False, False]


def test_a_table_without_column_failures_is_judged_by_its_status() -> None:
    complete = is_complete(RUNS.drop(columns="beyond_model"))
    assert complete.dtype == np.bool_
    assert complete.tolist() == [True, True, True, False, False, False, False]


@pytest.mark.parametrize("dtype", [object, float])
def test_a_run_that_its_table_calls_incomplete_is_incomplete(dtype: type) -> None:
    given = pd.Series([0, 1, 1, 1, 1, 1, 1], dtype=dtype)
    assert not is_complete(RUNS.assign(complete=given)).any()
    unknown = pd.Series([None] * len(RUNS), dtype="boolean")
    assert is_complete(RUNS.assign(complete=unknown)).tolist() == is_complete(RUNS).tolist()


def test_the_failure_ratio_is_the_larger_known_ratio() -> None:
    np.testing.assert_array_equal(column_failure_ratio(RUNS), RATIOS)
    alone = column_failure_ratio(RUNS.drop(columns="column_shear_dcr"))
    np.testing.assert_array_equal(alone, RUNS["drift_over_capacity"])
    none = column_failure_ratio(RUNS[["status"]])
    assert none.shape == (len(RUNS),)
    assert np.isnan(none).all()


def test_columns_that_an_older_table_lacks_are_derived() -> None:
    table = with_derived_columns(RUNS)
    assert table["complete"].dtype == bool
    assert table["complete"].tolist() == is_complete(RUNS).tolist()
    np.testing.assert_array_equal(table["column_failure_ratio"], RATIOS)
    assert "complete" not in RUNS
    given = RUNS.assign(complete=False, column_failure_ratio=2.0)
    pd.testing.assert_frame_equal(with_derived_columns(given), given)
    assert "column_failure_ratio" not in with_derived_columns(RUNS[["status"]])


def result_of(status: str, mode: str) -> AnalysisResult:
    """Return a result with the demands over capacity of columns and no others."""
    return AnalysisResult(
        status=status,
        collapse_criterion="",
        time_reached_s=1.0,
        duration_s=1.0,
        recovery_rung=0,
        steps_by_rung=(1,),
        loosened_ratio=0.0,
        substeps=0,
        failed_attempts=0,
        houbolt_failures=0,
        iterations=1,
        demands={"column_shear_dcr": 0.9, "drift_over_capacity": 1.25},
        whole_history={},
        model_end=ModelEnd(mode=mode, time_s=0.5, rows=2),
        energy_kj={},
        histories=None,
        contact_layout=None,
        messages=(),
    )


@pytest.mark.parametrize(
    ("status", "mode", "complete"),
    [("ok", "", True), ("ok", "flexure", False), ("collapse", "", False), ("timeout", "", False)],
)
def test_a_row_of_an_analysis_says_whether_it_is_complete(
    status: str, mode: str, complete: bool
) -> None:
    row = derived_columns(outcome_of(result_of(status, mode)))
    assert row["complete"] is complete
    assert row["column_failure_ratio"] == 1.25
    assert type(row["column_failure_ratio"]) is float


def test_an_analysis_without_a_result_is_not_complete() -> None:
    assert derived_columns(no_result("crash", "it ended"))["complete"] is False
