"""Tables of runs that somebody else made: read and fitted, or refused with row and column."""

import pandas as pd
import pytest

from cli_json import run
from fragility_tables import DRIFT, IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.exchange.foreign import read_foreign
from skewbridge.fragility.tables.curves import fit_study


def test_a_table_of_somebody_else_is_read_and_fitted(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=30)
    theirs = pd.DataFrame(
        {
            "record": table["motion_id"],
            "PGA": table[IM],
            "drift_pct": 100 * table["column_drift_ratio"],
        }
    )
    path = tmp_path / "theirs.csv"
    theirs.to_csv(path, index=False)
    columns = {"motion_id": "record", "im_pga_rotd50_g": "PGA", "column_drift_ratio": "drift_pct"}
    ours = read_foreign(path, columns, factors={"column_drift_ratio": 0.01})
    fitted = fit_study(ours, DRIFT, "im_pga_rotd50_g").iloc[0]
    direct = fit_study(table, DRIFT, IM).iloc[0]
    assert fitted["theta"] == pytest.approx(direct["theta"])


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"PGA": [0.1, 0.0]}, "im_pga_g must be > 0 and finite (row 1)"),
        ({"drift": ["1", "much"]}, "drift must be a number, got 'much' (row 1)"),
        ({"status": ["ok", "fine"]}, "status 'fine' is not known (row 1)"),
        ({"record": ["a", "a"]}, "row 1 repeats"),
    ],
)
def test_a_bad_foreign_table_names_row_and_column(tmp_path, change, text):
    data = {"record": ["a", "b"], "PGA": [0.1, 0.2], "drift": ["0.1", "0.2"], "status": ["ok"] * 2}
    path = tmp_path / "theirs.csv"
    pd.DataFrame(data | change).to_csv(path, index=False)
    columns = {
        "motion_id": "record",
        "im_pga_g": "PGA",
        "column_drift_ratio": "drift",
        "status": "status",
    }
    with pytest.raises(InputError) as caught:
        read_foreign(path, columns)
    assert text in str(caught.value)


def test_a_foreign_table_is_fitted_through_its_file_of_columns(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=30)
    ours, theirs = tmp_path / "ours.parquet", tmp_path / "theirs.csv"
    table.to_parquet(ours)
    drift = 100 * table["column_drift_ratio"]
    pd.DataFrame({"rec": table["motion_id"], "sa": table[IM], "pct": drift}).to_csv(theirs)
    columns = tmp_path / "columns.yaml"
    columns.write_text(
        f"columns: {{motion_id: rec, {IM}: sa, column_drift_ratio: pct}}\n"
        "factors: {column_drift_ratio: 0.01}\n",
        encoding="utf-8",
    )
    options = ["--method", "cloud", "--im", IM, "--edp", "column_drift_ratio", "--threshold", 0.02]
    _, first = run("fit", ours, *options)
    _, second = run("fit", theirs, *options, "--columns", columns)
    assert second["theta"] == pytest.approx(first["theta"])
    columns.write_text("column: {}\n", encoding="utf-8")
    code, found = run("fit", theirs, *options, "--columns", columns)
    assert code == 2
    assert "columns.yaml" in found["message"]
