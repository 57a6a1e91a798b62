"""Two studies compared run by run."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from cli_json import answer, invoke
from fragility_tables import IM, synthetic_demands
from skewbridge.files.tables import write_frame

STATES = str(Path(__file__).parents[2] / "config" / "limit_states.yaml")


def study(folder: Path, demands: pd.DataFrame, sha256: str = "a") -> str:
    """Write a study of these demands; all its motions have one digest."""
    (folder / "motions").mkdir(parents=True)
    write_frame(demands, folder / "demands.parquet", {})
    names = sorted(demands["motion_id"].unique())
    suite = pd.DataFrame({"motion_id": names, "sha256": [f"{sha256}{name}" for name in names]})
    write_frame(suite, folder / "motions" / "suite.parquet", {})
    return str(folder)


def compared(first: str, second: str, *options: str) -> dict:
    return answer("compare", first, second, "--limit-states", STATES, *options)


def test_a_known_change_is_found_in_demands_and_medians(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,))
    # a table of another program has the ratio of one failure mode, but not that of any
    table["drift_over_capacity"] = table["column_drift_ratio"] / 0.02
    noise = np.exp(0.05 * np.random.default_rng(3).normal(size=len(table)))
    changed = table.assign(deck_disp_m=table["deck_disp_m"] * 0.8 * noise)
    found = compared(study(tmp_path / "a", table), study(tmp_path / "b", changed))
    pooled = {row["demand"]: row for row in found["demands"] if row["scope"] == "pooled"}
    row = pooled["deck_disp_m"]
    assert row["ratio"] == pytest.approx(0.8, rel=0.02)
    assert row["ci_low"] < 0.8 < row["ci_high"]
    assert (row["verdict"], row["axis"], row["n_cells"]) == ("lower", "study", 6)
    # ln demand has slope 1 in ln im: the median moves by the inverse of the demand
    states = {row["demand"]: row for row in found["medians_by_state"]}
    slight = states["deck_displacement/slight"]
    assert slight["ratio"] == pytest.approx(1 / 0.8, rel=0.03)
    assert (slight["n_cells"], slight["direction"]) == (6, 1)
    assert states["column_failure/any"]["ratio"] == pytest.approx(1.0)
    assert pooled["column_drift_ratio"]["ratio"] == 1.0
    assert states["column_drift/slight"]["ratio"] == pytest.approx(1.0)


def test_only_common_runs_are_paired_and_the_rest_is_counted(tmp_path: Path) -> None:
    first = synthetic_demands(gaps=(51,), skews=(0, 30))
    second = synthetic_demands(gaps=(51,), skews=(30, 45))
    second = second[second["motion_id"] < "m12"]
    found = compared(study(tmp_path / "a", first), study(tmp_path / "b", second))
    common = {"pairs": 24, "variants": 2, "motions": 12, "equal_pairs": 0}
    assert found["counts"] == common | {"only_first": 64 - 24, "only_second": 48 - 24}
    assert {row["skew_deg"] for row in found["demands"]} == {None, 30}


def test_a_study_equals_itself_but_for_motions_of_one_name_and_other_files(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    path, out = tmp_path / "demands.csv", tmp_path / "rows.csv"
    table.drop(columns=["run_key"]).to_csv(path, index=False)
    first, second = study(tmp_path / "a", table), study(tmp_path / "b", table)
    found = compared(first, str(path), "--out", str(out))
    assert found["counts"]["pairs"] == len(table)
    assert all(row["ratio"] == pytest.approx(1.0) for row in found["demands"])
    assert len(pd.read_csv(out)) == len(found["demands"]) + len(found["medians"])
    # the printed answer counts medians outside the motions
    printed = invoke("compare", first, second, "--limit-states", STATES)
    assert printed.exit_code == 0
    lines = [line for line in printed.stdout.splitlines() if "deck_displacement" in line]
    assert [" of 4 medians" in line for line in lines] == [False, True]
    suite = pd.read_parquet(tmp_path / "b/motions/suite.parquet")
    suite.loc[suite["motion_id"] == "m03", "sha256"] = "another"
    write_frame(suite, tmp_path / "b/motions/suite.parquet", {})
    found = compared(first, second)
    assert found["other_motions"] == ["m03"]
    assert found["counts"]["motions"] == 15


@pytest.mark.parametrize(
    ("other", "options", "message"),
    [
        ("a", ["--im", "im_none"], "no column 'im_none'"),
        ("a", ["--out", "x.parquet"], "--out must end with .csv"),
        ("a", ["--limit-states", "none.yaml"], "none.yaml"),
        ("", ["--im", IM], "has no demands.parquet"),
        ("scaled", [], "2 variants, 6 motions, 0 motions with the same scale"),
    ],
)
def test_bad_input_and_studies_without_a_common_run_are_refused(tmp_path, other, options, message):
    for name, scale in (("a", 1.0), ("scaled", 2.0)):
        rows = synthetic_demands(gaps=(51,), skews=(0,), motions=6, scales=(scale,))
        study(tmp_path / name, rows)
    states = [] if "--limit-states" in options else ["--limit-states", STATES]
    found = answer("compare", tmp_path / "a", tmp_path / other, *states, *options, code=2)
    assert message in found["message"]
