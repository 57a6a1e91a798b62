"""Two studies compared run by run."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from fragility_tables import IM, synthetic_demands
from skewbridge.cli import build_app
from skewbridge.files.tables import write_frame

STATES = str(Path(__file__).parents[2] / "config" / "limit_states.yaml")
RUNNER = CliRunner()


def study(folder: Path, demands: pd.DataFrame, sha256: str = "a") -> str:
    """Write a study of these demands; all its motions have one digest."""
    (folder / "motions").mkdir(parents=True)
    write_frame(demands, folder / "demands.parquet", {})
    names = sorted(demands["motion_id"].unique())
    suite = pd.DataFrame({"motion_id": names, "sha256": [f"{sha256}{name}" for name in names]})
    write_frame(suite, folder / "motions" / "suite.parquet", {})
    return str(folder)


def compared(first: str, second: str, *options: str) -> dict:
    arguments = ["compare", first, second, "--limit-states", STATES, *options, "--json"]
    result = RUNNER.invoke(build_app(), arguments)
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def pooled(found: dict, demand: str) -> dict:
    (row,) = (
        row for row in found["demands"] if row["demand"] == demand and row["scope"] == "pooled"
    )
    return row


def test_a_known_change_is_found_in_demands_and_medians(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,))
    rng = np.random.default_rng(3)
    changed = table.assign(
        deck_disp_m=table["deck_disp_m"] * 0.8 * np.exp(0.05 * rng.normal(size=len(table)))
    )
    found = compared(study(tmp_path / "a", table), study(tmp_path / "b", changed))
    row = pooled(found, "deck_disp_m")
    assert row["ratio"] == pytest.approx(0.8, rel=0.02)
    assert row["ci_low"] < 0.8 < row["ci_high"]
    assert row["verdict"] == "lower"
    assert row["axis"] == "study"
    assert row["n_cells"] == 6
    # ln demand has slope 1 in ln im: the median moves by the inverse of the demand
    states = {row["demand"]: row for row in found["medians_by_state"]}
    assert states["deck_displacement/slight"]["ratio"] == pytest.approx(1 / 0.8, rel=0.03)
    assert states["deck_displacement/slight"]["n_cells"] == 6
    assert states["deck_displacement/slight"]["direction"] == 1
    assert pooled(found, "column_drift_ratio")["ratio"] == 1.0
    assert states["column_drift/slight"]["ratio"] == pytest.approx(1.0)


def test_only_common_runs_are_paired_and_the_rest_is_counted(tmp_path: Path) -> None:
    first = synthetic_demands(gaps=(51,), skews=(0, 30))
    second = synthetic_demands(gaps=(51,), skews=(30, 45))
    second = second[second["motion_id"] < "m12"]
    found = compared(study(tmp_path / "a", first), study(tmp_path / "b", second))
    assert found["counts"] == {
        "pairs": 24,
        "only_first": 64 - 24,
        "only_second": 48 - 24,
        "variants": 2,
        "motions": 12,
        "equal_pairs": 0,
    }
    assert {row["skew_deg"] for row in found["demands"]} == {None, 30}


def test_a_study_equals_itself_read_from_any_table(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    path = tmp_path / "demands.csv"
    table.drop(columns=["run_key"]).to_csv(path, index=False)
    found = compared(study(tmp_path / "a", table), str(path))
    assert found["counts"]["pairs"] == len(table)
    assert all(row["ratio"] == pytest.approx(1.0) for row in found["demands"])


def test_motions_of_one_name_but_other_files_are_left_out(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    first, second = study(tmp_path / "a", table), study(tmp_path / "b", table)
    suite = pd.read_parquet(tmp_path / "b/motions/suite.parquet")
    suite.loc[suite["motion_id"] == "m03", "sha256"] = "another"
    write_frame(suite, tmp_path / "b/motions/suite.parquet", {})
    found = compared(first, second)
    assert found["other_motions"] == ["m03"]
    assert found["counts"]["motions"] == 15
    result = RUNNER.invoke(build_app(), ["compare", first, second, "--limit-states", STATES])
    assert "1 motions have the same name in both studies but different files" in result.stderr


def test_studies_without_a_common_run_are_refused_with_the_reason(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    scaled = synthetic_demands(gaps=(51,), skews=(0,), scales=(2.0,))
    arguments = [study(tmp_path / "a", table), study(tmp_path / "b", scaled)]
    result = RUNNER.invoke(build_app(), ["compare", *arguments, "--limit-states", STATES])
    assert result.exit_code == 2
    message = result.stderr.replace("\n", " ")
    assert "2 variants, 16 motions, 0 motions with the same scale" in message


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--margin", "2"], "margin must be within 0..1"),
        (["--im", "im_none"], "no column 'im_none'"),
        (["--out", "x.parquet"], "--out must end with .csv"),
        (["--limit-states", "none.yaml"], "none.yaml"),
    ],
)
def test_bad_input_ends_with_2(tmp_path: Path, options: list[str], message: str) -> None:
    folder = study(tmp_path / "a", synthetic_demands(gaps=(51,), skews=(0,), motions=6))
    arguments = ["compare", folder, folder, "--limit-states", STATES, *options]
    result = RUNNER.invoke(build_app(), arguments)
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")
    missing = RUNNER.invoke(build_app(), ["compare", folder, str(tmp_path), "--im", IM])
    assert "has no demands.parquet" in missing.stderr.replace("\n", " ")


def test_all_rows_go_to_a_csv_file(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    out = tmp_path / "rows.csv"
    found = compared(study(tmp_path / "a", table), str(tmp_path / "a"), "--out", str(out))
    assert len(pd.read_csv(out)) == len(found["demands"]) + len(found["medians"])
