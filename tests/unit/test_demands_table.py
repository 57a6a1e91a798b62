"""Demands table: schema, order, completeness of runs and columns that older tables lack."""

import math
from dataclasses import fields

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


def test_every_field_carries_the_unit_of_its_name_and_a_description() -> None:
    for field in demands_schema():
        assert field.metadata[b"unit"]
        assert field.metadata[b"description"]
    suffixes = {"_kn": "kN", "_m": "m", "_s": "s", "_g": "g", "_rad": "rad", "_mps2": "m/s2"}
    for column in COLUMNS:
        for suffix, unit in suffixes.items():
            if column.name.endswith(suffix):
                assert column.unit == unit, column.name
    assert not {axis.name for axis in OPTION_AXES} & {column.name for column in COLUMNS}


def test_rows_are_sorted_by_their_key_and_a_missing_demand_stays_unknown() -> None:
    lost = ROW | {column.name: math.nan for column in DEMAND_COLUMNS} | {"status": "crash"}
    table = to_table([ROW | {"motion_id": "c"}, lost | {"motion_id": "a"}], {})
    assert table["motion_id"].to_pylist() == ["a", "c"]
    assert math.isnan(table["column_shear_kn"][0].as_py())


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([ROW, ROW], "appears twice"),
        ([ROW | {"x": 1}], "wrong columns"),
        ([ROW | {"status": "fine"}], "unknown status 'fine'"),
    ],
)
def test_a_row_that_breaks_the_contract_is_named(rows: list[dict], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        to_table(rows, {"commit": "x"})


def test_axes_and_completeness_keep_their_values_types_and_order() -> None:
    fine, plain, other = (
        parse_slug(f"osb1_cf_{name}")
        for name in (
            "skew22p5_gap025p4_mu037p5",
            "skew30_gap051_mu050",
            "skew30_gap051_mu050_backwall-points9_transverse-gap-mm25p4",
        )
    )
    rows = [
        ROW | key_values(plain, "syn001", 1.0, 0.0) | {"complete": False},
        ROW | key_values(fine, "syn001", 1.0, 0.0),
    ]
    table = to_table(rows, {}).to_pandas()
    assert table["skew_deg"].tolist() == [22.5, 30.0]
    assert table["gap_mm"].tolist() == [25.4, 51.0]
    assert table["friction"].tolist() == [0.375, 0.5]
    assert table["complete"].dtype == bool
    assert table["complete"].tolist() == [True, False]
    options = to_table([ROW | key_values(other, "syn001", 1.0, 0.0)], {})
    place = options.column_names.index("friction")
    assert options.column_names[place + 1 : place + 3] == ["transverse_gap_mm", "backwall_points"]
    row = options.to_pylist()[0]
    assert (row["transverse_gap_mm"], row["backwall_points"]) == (25.4, 9)
    assert options.schema.field("transverse_gap_mm").metadata[b"unit"] == b"mm"


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
    by_status = is_complete(RUNS.drop(columns="beyond_model"))
    assert by_status.dtype == np.bool_
    assert by_status.tolist() == [True] * 3 + [False] * 4
    for dtype in (object, float):  # as its table says
        given = pd.Series([0, 1, 1, 1, 1, 1, 1], dtype=dtype)
        assert not is_complete(RUNS.assign(complete=given)).any()
    unknown = pd.Series([None] * len(RUNS), dtype="boolean")
    assert is_complete(RUNS.assign(complete=unknown)).tolist() == is_complete(RUNS).tolist()


def test_columns_that_an_older_table_lacks_are_derived_with_the_larger_known_ratio() -> None:
    table = with_derived_columns(RUNS)
    assert table["complete"].dtype == bool
    assert table["complete"].tolist() == is_complete(RUNS).tolist()
    np.testing.assert_array_equal(table["column_failure_ratio"], RATIOS)
    assert "complete" not in RUNS
    given = RUNS.assign(complete=False, column_failure_ratio=2.0)
    pd.testing.assert_frame_equal(with_derived_columns(given), given)
    assert "column_failure_ratio" not in with_derived_columns(RUNS[["status"]])
    alone = column_failure_ratio(RUNS.drop(columns="column_shear_dcr"))
    np.testing.assert_array_equal(alone, RUNS["drift_over_capacity"])
    none = column_failure_ratio(RUNS[["status"]])
    assert none.shape == (len(RUNS),)
    assert np.isnan(none).all()


def result_of(status: str, mode: str) -> AnalysisResult:
    """Return a result with the demands over capacity of columns and no others."""
    values = dict.fromkeys((field.name for field in fields(AnalysisResult)), 0) | {
        "status": status,
        "collapse_criterion": "",
        "steps_by_rung": (1,),
        "demands": {"column_shear_dcr": 0.9, "drift_over_capacity": 1.25},
        "whole_history": {},
        "energy_kj": {},
        "model_end": ModelEnd(mode=mode, time_s=0.5, rows=2),
        "messages": (),
    }
    return AnalysisResult(**values)


@pytest.mark.parametrize(
    ("status", "mode", "complete"),
    [("ok", "", True), ("ok", "flexure", False), ("collapse", "", False), ("timeout", "", False)],
)
def test_a_row_of_an_analysis_says_whether_it_is_complete(status, mode, complete) -> None:
    row = row_of_task(outcome_of(result_of(status, mode)), task_of(), "key")
    assert row["complete"] is complete
    assert row["column_failure_ratio"] == 1.25
    assert type(row["column_failure_ratio"]) is float
    assert row_of_task(no_result("crash", "it ended"), task_of(), "key")["complete"] is False
