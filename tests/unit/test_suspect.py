"""Suspect rows: reasons, limits, and their counts in tables and checks."""

import json
from pathlib import Path

import pandas as pd
import pytest

from fragility_tables import paired_effects, states_of, synthetic_demands
from skewbridge.analysis.recovery import rung_shares, steps_as_text, steps_from_text
from skewbridge.demands.columns import COLUMNS
from skewbridge.demands.suspect import LIMITS, SuspectLimits, count_reasons, reasons
from skewbridge.demands.tables import join_variants, write_variant
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.settings import FitSettings
from skewbridge.report.checks import read_tables, write_checks
from skewbridge.study.config import parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.progress import study_state

HEALTHY = {
    "loosened_ratio": 0.0,
    "recovery_rung": 1,
    "energy_residual_ratio": -0.004,
    "contact_energy_ratio": 0.002,
    "cone_excess_wall_ratio": 0.009,
    "cone_excess_key_ratio": 0.002,
    "contact_force_ratio": 0.1,
    "houbolt_failures": 0,
}
NAN = float("nan")


def test_a_healthy_row_is_not_suspect() -> None:
    assert reasons(HEALTHY, LIMITS) == ""


@pytest.mark.parametrize(
    ("column", "value", "text"),
    [
        ("loosened_ratio", 0.042, "loosened test, share of the steps 4.20%"),
        ("recovery_rung", 6, "recovery rung 6"),
        ("energy_residual_ratio", -0.084, "energy residual 8.4%"),
        ("energy_residual_ratio", 0.084, "energy residual 8.4%"),
        ("contact_energy_ratio", -0.03, "energy made at contacts 3.0%"),
        ("cone_excess_wall_ratio", 0.06, "excess over the cone on backwalls 6.0%"),
        ("cone_excess_key_ratio", 0.06, "excess over the cone on keys 6.0%"),
        ("contact_force_ratio", 1.25, "contact force over weight 1.25"),
        ("houbolt_failures", 3, "failed attempts under Houbolt 3"),
    ],
)
def test_each_reason_is_named_with_its_number(column: str, value: float, text: str) -> None:
    assert reasons(HEALTHY | {column: value}, LIMITS) == text


def test_contacts_may_take_energy() -> None:
    assert reasons(HEALTHY | {"contact_energy_ratio": 0.2}, LIMITS) == ""


def test_several_reasons_are_joined_and_unknown_values_give_none() -> None:
    row = HEALTHY | {"recovery_rung": 5, "energy_residual_ratio": NAN, "contact_force_ratio": 0.7}
    assert reasons(row, LIMITS) == "recovery rung 5; contact force over weight 0.70"
    assert reasons({"status": "crash"}, LIMITS) == ""


def test_a_limit_of_the_configuration_decides() -> None:
    limits = parse_config({"suspect": {"max_rung": 0}}).suspect
    assert reasons(HEALTHY, limits) == "recovery rung 1"


def test_reasons_are_counted_with_their_worst_row() -> None:
    changes = [
        {},
        {"recovery_rung": 5, "energy_residual_ratio": NAN},
        {"recovery_rung": 6, "energy_residual_ratio": -0.09},
        {"energy_residual_ratio": 0.12},
    ]
    table = pd.DataFrame([HEALTHY | change for change in changes])
    assert count_reasons(table, LIMITS) == [
        {"reason": "recovery rung", "rows": 2, "worst": "6", "at": 2},
        {"reason": "energy residual", "rows": 2, "worst": "12.0%", "at": 3},
    ]
    assert count_reasons(table.drop(columns=["energy_residual_ratio"]), LIMITS)[1:] == []


def test_shares_per_rung_count_steps_and_the_highest_rung_of_an_analysis() -> None:
    shares = pd.DataFrame(rung_shares([[90, 0, 5], [100, 0, 0], [5], []])).set_index("rung")
    assert shares["steps"].tolist()[:3] == [195, 0, 5]
    assert shares["steps_share"][2] == pytest.approx(0.025)
    assert shares["analyses"].tolist()[:3] == [3, 0, 1]
    assert shares["analyses_share"].sum() == pytest.approx(1.0)
    assert shares["attempt"].is_unique
    assert steps_from_text(steps_as_text([90, 0, 5])) == [90, 0, 5]
    assert steps_from_text("") == []


def row(**changed: object) -> dict[str, object]:
    """Return a row of an analysis: every column but the one that is decided later."""
    empty = {"text": "x", "integer": 0, "number": 0.0, "boolean": True}
    plain = {column.name: empty[column.kind] for column in COLUMNS}
    del plain["suspect"]
    return plain | {"status": "ok", "steps_by_rung": "10 0 1"} | changed


def test_the_table_of_the_study_lists_suspect_rows(tmp_path: Path) -> None:
    """Rows of analyses do not contain reasons: other limits apply to the same rows."""
    rows = [row(motion_id="a"), row(motion_id="b", recovery_rung=2)]
    found = []
    for limits in (LIMITS, SuspectLimits(max_rung=1)):
        write_variant(rows, tmp_path / "x.parquet", limits)
        join_variants([tmp_path / "x.parquet"], tmp_path / "all.parquet")
        found.append(pd.read_parquet(tmp_path / "all.parquet")["suspect"].tolist())
        assert pd.read_parquet(tmp_path / "x.parquet")["suspect"].tolist() == found[-1]
    assert found == [["", ""], ["", "recovery rung 2"]]


def test_the_checks_list_the_suspect_rows_and_the_rungs(tmp_path: Path) -> None:
    whole = tmp_path / "all.parquet"
    rows = [row(motion_id="a"), row(motion_id="b", recovery_rung=2)]
    write_variant(rows, whole, SuspectLimits(max_rung=1))
    curves, effects, suite = (tmp_path / f"{name}.parquet" for name in ("curves", "effects", "s"))
    named = {key: ["x"] for key in ("variant", "component", "method", "demand", "limit_state")}
    fit = {"status": ["ok"], "theta": [0.5], "threshold": [1.0]}
    pd.DataFrame(named | fit).to_parquet(curves)
    pd.DataFrame({"ratio": [1.0], "ci_low": [0.9], "ci_high": [1.1]}).to_parquet(effects)
    pd.DataFrame({"motion_id": ["a", "b"]}).to_parquet(suite)
    tables = read_tables(
        demands=whole, curves=curves, effects=effects, suite=suite, max_unfinished_share=0.01
    )
    limits = SuspectLimits(max_rung=1)
    write_checks(tables, tmp_path / "checks.json", suspect=limits)
    checks = json.loads((tmp_path / "checks.json").read_text())
    assert checks["suspect_rows"] == 1
    (worst,) = checks["suspect"]
    assert (worst["reason"], worst["rows"], worst["worst"]) == ("recovery rung", 1, "2")
    assert worst["motion_id"] == "b"
    assert [rung["steps"] for rung in checks["rungs"][:3]] == [20, 0, 2]


def test_the_state_of_a_study_counts_them(tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path)
    with open_journal(folder.journal("v")) as journal:
        for number in range(3):
            journal.append(row(run_key=str(number), recovery_rung=number))
    keys, content = {"v": ["0", "1", "2"]}, read_content(folder.journals)
    assert study_state(keys, content).counts["suspect"] == 0
    assert study_state(keys, content, SuspectLimits(max_rung=0)).counts["suspect"] == 2


def test_excluded_rows_are_unknown_in_the_fits_and_have_no_ratio() -> None:
    demands = synthetic_demands().assign(suspect="", beyond_model="")
    strong = demands["motion_id"] == "m15"
    demands.loc[strong, "suspect"] = "recovery rung 6"
    states = states_of("unseating")
    columns = [*{state.demand for state in states}, "deck_disp_m"]
    kept, left = (
        prepared(demands, columns, FitSettings(exclude_suspect=exclude)).table
        for exclude in (False, True)
    )
    assert fit_study(kept, states)["n_unknown"].max() == 0
    assert fit_study(left, states)["n_unknown"].max() == 1
    effects = [paired_effects(table, ["deck_disp_m"]) for table in (kept, left)]
    most = [table["n_motions"].max() for table in effects]
    assert most[1] < most[0]
