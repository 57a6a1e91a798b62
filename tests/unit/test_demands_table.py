"""Demands table: schema, order, completeness of runs and columns that older tables lack."""

import math

import numpy as np
import pandas as pd
import pytest

from skewbridge.analysis.peaks import ModelEnd
from skewbridge.analysis.transient import AnalysisResult
from skewbridge.demands.columns import COLUMNS, key_values
from skewbridge.demands.completeness import (
    column_failure_ratio,
    failure_kinds,
    is_beyond_model,
    is_complete,
    with_derived_columns,
)
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.demands.tables import demands_schema, to_table
from skewbridge.study.batch import row_of_task
from skewbridge.study.task import no_result, outcome_of
from skewbridge.variant.axes import OPTION_AXES
from skewbridge.variant.variant import parse_slug
from study_parts import task_of

VALUES = {"text": "x", "integer": 1, "number": 1.0, "boolean": True}
ROW = {column.name: VALUES[column.kind] for column in COLUMNS} | {"status": "ok"}


def test_every_field_carries_unit_and_description() -> None:
    for field in demands_schema():
        assert field.metadata[b"unit"]
        assert field.metadata[b"description"]


def test_columns_with_a_unit_suffix_are_in_that_unit() -> None:
    suffixes = {"_kn": "kN", "_m": "m", "_s": "s", "_g": "g", "_rad": "rad", "_mps2": "m/s2"}
    for column in COLUMNS:
        for suffix, unit in suffixes.items():
            if column.name.endswith(suffix):
                assert column.unit == unit, column.name


def test_rows_are_sorted_by_their_key() -> None:
    rows = [ROW | {"motion_id": motion} for motion in ("c", "a", "b")]
    assert to_table(rows, {})["motion_id"].to_pylist() == ["a", "b", "c"]


def test_a_missing_demand_stays_unknown() -> None:
    row = ROW | {column.name: math.nan for column in DEMAND_COLUMNS} | {"status": "crash"}
    assert math.isnan(to_table([row], {})["column_shear_kn"][0].as_py())


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([ROW, ROW], "appears twice"),
        (
            [{k: v for k, v in ROW.items() if k != "scale"} | {"scale": 1.0, "x": 1}],
            "wrong columns",
        ),
        ([ROW | {"status": "fine"}], "unknown status 'fine'"),
    ],
)
def test_a_row_that_breaks_the_contract_is_named(rows: list[dict], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        to_table(rows, {"commit": "x"})


def test_an_axis_of_a_modelling_option_has_its_column_after_the_core_axes() -> None:
    variant = parse_slug("osb1_cf_skew30_gap051_mu050_backwall-points9_transverse-gap-mm25p4")
    table = to_table([ROW | key_values(variant, "syn001", 1.0, 0.0)], {})
    place = table.column_names.index("friction")
    assert table.column_names[place + 1 : place + 3] == ["transverse_gap_mm", "backwall_points"]
    row = table.to_pylist()[0]
    assert (row["transverse_gap_mm"], row["backwall_points"]) == (25.4, 9)
    assert table.schema.field("transverse_gap_mm").metadata[b"unit"] == b"mm"


def test_axes_and_completeness_keep_their_values_and_types() -> None:
    variant = parse_slug("osb1_cf_skew22p5_gap025p4_mu037p5")
    plain = parse_slug("osb1_cf_skew30_gap051_mu050")
    rows = [
        ROW | key_values(plain, "syn001", 1.0, 0.0) | {"complete": False},
        ROW | key_values(variant, "syn001", 1.0, 0.0),
    ]
    table = to_table(rows, {}).to_pandas()
    assert table["skew_deg"].tolist() == [22.5, 30.0]
    assert table["gap_mm"].tolist() == [25.4, 51.0]
    assert table["friction"].tolist() == [0.375, 0.5]
    assert table["complete"].dtype == bool
    assert table["complete"].tolist() == [True, False]


def test_no_modelling_option_has_the_name_of_a_column() -> None:
    assert not {axis.name for axis in OPTION_AXES} & {column.name for column in COLUMNS}


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
    row = row_of_task(outcome_of(result_of(status, mode)), task_of(), "key")
    assert row["complete"] is complete
    assert row["column_failure_ratio"] == 1.25
    assert type(row["column_failure_ratio"]) is float


def test_an_analysis_without_a_result_is_not_complete() -> None:
    assert row_of_task(no_result("crash", "it ended"), task_of(), "key")["complete"] is False
