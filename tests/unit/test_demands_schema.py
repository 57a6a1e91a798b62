"""Schema, order and contract of the demands table."""

import math

import pytest

from skewbridge.demands.columns import COLUMNS, key_values
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.demands.tables import demands_schema, to_table
from skewbridge.variant.axes import OPTION_AXES
from skewbridge.variant.variant import parse_slug

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
