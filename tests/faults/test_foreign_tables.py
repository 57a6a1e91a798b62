"""Tables of runs of other programs: read and fitted, or refused with row and column."""

import numpy as np
import pandas as pd
import pytest

from cli_json import run
from fragility_tables import IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_table import prepared, read_foreign
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.settings import FitSettings

DRIFT = "column_drift_ratio"
SLIGHT = LimitState(
    component="column_drift", name="slight", demand=DRIFT, threshold=0.01, dispersion=0.35
)


def fitted(table, im):
    settings = FitSettings(im=im)
    return fit_study(prepared(table, [DRIFT], settings).table, [SLIGHT], settings).iloc[0]


def test_complete_is_derived_unless_the_table_has_it(tmp_path):
    path = tmp_path / "theirs.csv"
    data = {
        "record": ["a", "b", "c"],
        "PGA": [0.1, 0.2, 0.3],
        "end": ["ok", "collapse", "ok"],
        "failed": ["", "", "shear"],
        "all": [True, True, False],
    }
    pd.DataFrame(data).to_csv(path, index=False)
    names = {"motion_id": "record", "im_pga_g": "PGA", "status": "end", "beyond_model": "failed"}
    assert read_foreign(path, names)["complete"].tolist() == [True, False, False]
    theirs = read_foreign(path, names | {"complete": "all"})
    assert theirs["complete"].tolist() == [True, True, False]


def test_missing_numbers_reject_single_rows(tmp_path):
    """A missing intensity or demand concerns its row; the others are fitted."""
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=30)
    table.loc[3, IM] = np.nan
    table.loc[7, DRIFT] = np.nan
    path = tmp_path / "theirs.csv"
    table[["motion_id", "status", IM, DRIFT]].to_csv(path, index=False)
    ours = read_foreign(path, {name: name for name in ("motion_id", "status", IM, DRIFT)})
    notes = prepared(ours, [DRIFT], FitSettings(im=IM)).notes
    assert notes[["kind", "row"]].to_numpy().tolist() == [
        ["rejected_row", 3],
        ["missing_demand", 7],
    ]
    row = fitted(ours, IM)
    assert (row["status"], row["n_runs"]) == ("ok", 29)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"PGA": [0.1, 0.0]}, "im_pga_g must be > 0 and finite (row 1)"),
        ({"drift": ["1", "much"]}, "drift must be a number, got 'much' (row 1)"),
        ({"status": ["ok", "fine"]}, "status 'fine' is not known (row 1)"),
        ({"record": ["a", "a"]}, "row 1 repeats"),
        ({"record": ["a", None]}, "record is missing (row 1)"),
    ],
)
def test_a_bad_foreign_table_names_row_and_column(tmp_path, change, text):
    data = {"record": ["a", "b"], "PGA": [0.1, 0.2], "drift": ["0.1", "0.2"], "status": ["ok"] * 2}
    path = tmp_path / "theirs.csv"
    pd.DataFrame(data | change).to_csv(path, index=False)
    columns = {"motion_id": "record", "im_pga_g": "PGA", DRIFT: "drift", "status": "status"}
    with pytest.raises(InputError) as caught:
        read_foreign(path, columns)
    assert text in str(caught.value)


def test_a_foreign_table_is_fitted_by_its_file_of_columns(tmp_path):
    table = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=30)
    ours, theirs = tmp_path / "ours.parquet", tmp_path / "theirs.csv"
    table.to_parquet(ours)
    drift = 100 * table[DRIFT]
    pd.DataFrame({"rec": table["motion_id"], "sa": table[IM], "pct": drift}).to_csv(theirs)
    columns = tmp_path / "columns.yaml"
    columns.write_text(
        f"columns: {{motion_id: rec, {IM}: sa, column_drift_ratio: pct}}\n"
        "factors: {column_drift_ratio: 0.01}\n",
        encoding="utf-8",
    )
    options = ["--method", "cloud", "--im", IM, "--edp", DRIFT, "--threshold", 0.02]
    _, first = run("fit", ours, *options)
    _, second = run("fit", theirs, *options, "--columns", columns)
    assert second["theta"] == pytest.approx(first["theta"])
    columns.write_text("column: {}\n", encoding="utf-8")
    code, found = run("fit", theirs, *options, "--columns", columns)
    assert code == 2
    assert "columns.yaml" in found["message"]
