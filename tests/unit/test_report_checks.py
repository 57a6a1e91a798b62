"""Checks of a study's tables find what a sceptical reader would look for; suspect rows."""

import json
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from skewbridge.analysis.recovery import recovery_shares, steps_as_text, steps_from_text
from skewbridge.demands.columns import COLUMNS
from skewbridge.demands.tables import write_variant
from skewbridge.demands.validity import count_reasons, reasons
from skewbridge.errors import SolutionError
from skewbridge.files.tables import read_frame
from skewbridge.report.checks import StudyTables, check_tables, require_passed, write_checks
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import read_content
from skewbridge.study.progress import study_progress
from study_parts import in_journal

SLUG = "osb1_cf_skew00_gap025_mu000"
CURVES = pd.DataFrame({
    "variant": SLUG, "component": "column_drift", "demand": "column_drift_ratio",
    "limit_state": ["slight", "moderate"], "method": "cloud", "threshold": [0.01, 0.025],
    "status": ["ok", "no_exceedance"], "theta": [0.5, float("nan")],
})  # fmt: skip
EFFECTS = pd.DataFrame({
    "variant": SLUG, "axis": "friction", "demand": "deck_disp_m", "ratio": [1.0, 1.1],
    "ci_low": [0.9, None], "ci_high": [1.1, None],
})  # fmt: skip
HEALTHY = {
    "steps_by_rung": "958 0 0", "recovery_rung": 1, "energy_residual_ratio": -0.004,
    "contact_energy_ratio": 0.002, "cone_excess_ratio": 0.009, "contact_force_ratio": 0.1,
}  # fmt: skip
NO_RESULT = "share of rows that failed before the end of the motion, a collapse or a column failure"
UNKNOWN = {"recovery_rung": 5, "energy_residual_ratio": float("nan")}


def demands(**changed):
    """Return two good runs; a changed column replaces the values of the first."""
    row = {
        "variant": SLUG, "bridge": "osb1", "abutment": "contact_friction", "skew_deg": 0,
        "gap_mm": 25, "scale": 1.0, "incidence_deg": 0.0, "friction": 0.0, "status": "ok",
        "suspect": "", "steps_by_rung": "10", "column_shear_kn": 100.0, "column_shear_x_kn": 80.0,
        "column_shear_y_kn": 70.0, "slip_work_kj": 0.0, "unseating_m": 0.1,
    }  # fmt: skip
    return pd.DataFrame([{**row, "motion_id": "m00", **changed}, {**row, "motion_id": "m01"}])


def tables(table, curves=CURVES, effects=EFFECTS):
    return StudyTables(demands=table, curves=curves, effects=effects)


def failed(*given, **asked):
    found = check_tables(replace(tables(*given), **asked))
    return {check["name"]: check["rows"] for check in found if not check["passed"]}


def test_good_tables_pass_within_the_limits_of_the_configuration():
    assert failed(demands()) == {}
    half = demands(status="timeout")
    assert failed(half, max_failed_share=0.49)
    assert failed(half, max_failed_share=0.5) == {}
    # after a column failure, the peaks up to it are the result
    assert failed(half.assign(beyond_model=["shear", ""])) == {}
    assert failed(half.assign(beyond_model=""))
    sliding = demands(slip_work_kj=1.0)  # cohesion may do work without friction
    assert failed(sliding, cohesion_n=1e5) == failed(sliding.assign(cohesion_n=1e5)) == {}


def test_a_fault_of_the_demands_is_named_with_its_row():
    for changed, name in (
        ({"motion_id": "m01"}, "analyses listed twice"),
        ({"status": "finished"}, "rows without a known status"),
        ({"status": None}, "rows without a known status"),
        ({"status": "timeout"}, NO_RESULT),
        ({"unseating_m": float("nan")}, "finished rows with a demand that is not a number"),
        ({"column_shear_x_kn": 101.0}, "finished rows whose resultant shear is below a component"),
        ({"slip_work_kj": -1.0, "friction": 0.5}, "rows with negative friction work"),
        ({"slip_work_kj": 1.0}, "rows with friction work but without friction"),
    ):
        (place,) = failed(demands(**changed))[name]
        assert place.startswith(f"{SLUG}, {changed.get('motion_id', 'm00')}")


def test_a_variant_with_an_analysis_too_few_is_found_but_searches_take_what_they_need():
    name = "rows of variants with fewer analyses than planned"
    other = demands().assign(variant="osb1_cf_skew30_gap025_mu000", skew_deg=30)
    fewer = pd.concat([demands(), other.head(1)])
    assert failed(fewer) == {name: ["osb1_cf_skew30_gap025_mu000, m00, 1, 0"]}
    numbers = fewer["variant"].value_counts().to_dict()  # blocks: unequal numbers are planned
    assert failed(fewer, planned=numbers) == {}
    assert list(failed(fewer, planned=dict.fromkeys(numbers, 3))) == [name]
    further = demands().head(1).assign(scale=1.1)
    table = pd.concat([demands(), further, other])
    assert failed(table, searched=True) == {}
    assert list(failed(table)) == [name]
    assert failed(pd.concat([further, fewer]), searched=True)


def test_faults_of_fits_and_effects_are_named_whatever_the_order_of_rows():
    effects = EFFECTS.assign(ratio=[1.2, 1.1])
    assert list(failed(demands(), CURVES.assign(theta=[0.0, None]), effects)) == [
        "fitted curves without a positive median",
        "effects whose interval does not contain the ratio",
    ]
    fitted = CURVES.assign(status="ok", theta=[0.5, 0.49])
    place = f"{SLUG}, column_drift, moderate, cloud"
    for table in (fitted, fitted[::-1]):
        words = "medians below the median of a smaller capacity"
        assert failed(demands(), table) == {words: [place]}
    for good in ({"theta": [0.5, 0.5]}, {"method": ["cloud", "exceedance"]}):
        assert failed(demands(), fitted.assign(**good)) == {}


@pytest.mark.parametrize(
    ("friction", "relative", "is_found"),
    [(0.0, 1e-10, False), (0.0, 1e-8, True), (0.5, 1.0, False)],
)
def test_no_friction_is_held_against_contact_to_nine_digits(friction, relative, is_found):
    rows = demands(unseating_m=0.1 * (1.0 + relative)).assign(friction=friction)
    contact = demands().assign(abutment="contact", variant="osb1_co_skew00_gap025_mu000")
    expected = {"rows that differ from the frictionless model": [f"{SLUG}, m00, 1, 0"]}
    assert failed(pd.concat([rows, contact])) == (expected if is_found else {})


def test_a_failed_check_stops_the_study_only_when_asked(tmp_path: Path, caplog):
    output = tmp_path / "checks.json"
    write_checks(tables(demands(unseating_m=float("nan"))), output)
    assert not json.loads(output.read_text())["passed"]
    assert f"{SLUG}, m00" in caplog.text
    with pytest.raises(SolutionError, match="not a number"):
        require_passed(output)
    write_checks(tables(demands()), output)
    require_passed(output)
    assert json.loads(output.read_text())["passed"]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({}, ""),
        ({"steps_by_rung": "958 0 42"}, "share of steps with looser test 4.20%"),
        ({"recovery_rung": 6}, "recovery step 6"),
        ({"energy_residual_ratio": -0.084}, "energy residual 8.4%"),
        ({"energy_residual_ratio": 0.084}, "energy residual 8.4%"),
        ({"contact_energy_ratio": -0.03}, "energy generated at contacts 3.0%"),
        ({"contact_energy_ratio": 0.2}, ""),  # contacts may take energy
        ({"cone_excess_ratio": 0.06}, "work above friction limit 6.0%"),
        ({"contact_force_ratio": 1.25}, "contact force / weight 1.25"),
        (UNKNOWN | {"contact_force_ratio": 0.7}, "recovery step 5; contact force / weight 0.70"),
    ],
)
def test_each_reason_is_named_with_its_number_and_unknown_values_give_none(change, text) -> None:
    assert reasons(HEALTHY | change) == text
    assert reasons({"status": "crash"}) == ""


def test_reasons_and_recovery_steps_are_counted_with_their_worst_row() -> None:
    changes = [{}, UNKNOWN, {"recovery_rung": 6, "energy_residual_ratio": -0.09}]
    changes.append({"energy_residual_ratio": 0.12})
    texts = [reasons(HEALTHY | change) for change in changes]
    steps = {"reason": "recovery step", "rows": 2, "worst": "6", "at": 2}
    energy = {"reason": "energy residual", "rows": 2, "worst": "12.0%", "at": 3}
    assert count_reasons(texts) == [steps, energy]
    shares = pd.DataFrame(recovery_shares([[90, 0, 5], [100, 0, 0], [5], []])).set_index("rung")
    assert shares["steps"].tolist()[:3] == [195, 0, 5]
    assert shares["steps_share"][2] == pytest.approx(5 / 200)
    assert shares["analyses"].tolist()[:3] == [3, 0, 1]
    assert shares["analyses_share"].sum() == pytest.approx(1.0)
    assert shares["attempt"].is_unique
    assert steps_from_text(steps_as_text([90, 0, 5])) == [90, 0, 5]
    assert steps_from_text("") == []


def test_checks_and_state_of_a_study_count_suspect_rows_and_recovery_steps(tmp_path: Path) -> None:
    empty = {"text": "x", "integer": 0, "number": 0.0, "boolean": True}
    row = {column.name: empty[column.kind] for column in COLUMNS if column.name != "suspect"}
    row |= {"status": "ok", "steps_by_rung": "500 0 1"}
    rows = [row | {"motion_id": key, "run_key": key, "recovery_rung": rung}
            for key, rung in (("a", 4), ("b", 5))]  # fmt: skip
    write_variant(rows, tmp_path / "demands.parquet")
    write_checks(tables(read_frame(tmp_path / "demands.parquet")), tmp_path / "checks.json")
    checks = json.loads((tmp_path / "checks.json").read_text())
    found = [[r[n] for n in ("reason", "rows", "worst", "motion_id")] for r in checks["suspect"]]
    assert (checks["suspect_rows"], found) == (1, [["recovery step", 1, "5", "b"]])
    assert [step["steps"] for step in checks["rungs"][:3]] == [1000, 0, 2]
    folder = StudyFolder(tmp_path)
    in_journal(folder.journal("v"), *rows)
    content = read_content(folder.journals)
    progress = study_progress({"v": ["a", "b"]}, content)
    assert (progress.summary["suspect"], progress.notes) == (1, ())
    (note,) = study_progress({"v": ["c"]}, content).notes  # of other sources
    assert note.startswith("None of the 2 stored analyses has the present sources")
