"""The checks of a study's tables find what a sceptical reader would look for."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from skewbridge.errors import SolutionError
from skewbridge.report.checks import StudyTables, check_tables, require_passed, write_checks

CURVES = pd.DataFrame(
    {
        "variant": "osb1_cf_skew00_gap025_mu000",
        "component": "column_drift",
        "demand": "column_drift_ratio",
        "limit_state": ["slight", "moderate"],
        "method": "cloud",
        "threshold": [0.01, 0.025],
        "status": ["ok", "no_exceedance"],
        "theta": [0.5, float("nan")],
    }
)
EFFECTS = pd.DataFrame(
    {
        "variant": "osb1_cf_skew00_gap025_mu000",
        "axis": "friction",
        "demand": "deck_disp_m",
        "ratio": [1.0, 1.1],
        "ci_low": [0.9, None],
        "ci_high": [1.1, None],
    }
)
WAVE = np.array([0.0, 1.0, -2.0, 0.5])
SUITE = pd.DataFrame(
    {
        "motion_id": ["m00", "m01", "m01_mirrored"],
        "accel_1_mps2": [2.0 * WAVE, WAVE, WAVE],
        "accel_2_mps2": [WAVE, WAVE[::-1], -WAVE[::-1]],
    }
)


def demands(**changed):
    """Return two good runs; a changed column replaces the values of the first."""
    row = {
        "variant": "osb1_cf_skew00_gap025_mu000",
        "bridge": "osb1",
        "abutment": "contact_friction",
        "skew_deg": 0,
        "gap_mm": 25,
        "scale": 1.0,
        "incidence_deg": 0.0,
        "friction": 0.0,
        "status": "ok",
        "suspect": "",
        "steps_by_rung": "10",
        "column_shear_kn": 100.0,
        "column_shear_x_kn": 80.0,
        "column_shear_y_kn": 70.0,
        "slip_work_kj": 0.0,
        "unseating_m": 0.1,
    }
    return pd.DataFrame([{**row, "motion_id": "m00", **changed}, {**row, "motion_id": "m01"}])


def tables(table, curves=CURVES, effects=EFFECTS):
    return StudyTables(
        demands=table, curves=curves, effects=effects, suite=SUITE, max_unfinished_share=0.01
    )


def failed(*given, **asked):
    found = check_tables(replace(tables(*given), **asked))
    return {check.name: check.rows for check in found if not check.passed}


def test_good_tables_pass():
    assert failed(demands()) == {}


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"motion_id": "m01"}, "analyses listed twice"),
        ({"status": "finished"}, "rows without a known status"),
        ({"status": None}, "rows without a known status"),
        ({"status": "timeout"}, "share of rows with a status other than ok or collapse"),
        ({"unseating_m": float("nan")}, "finished rows with a demand that is not a number"),
        ({"column_shear_x_kn": 101.0}, "finished rows whose resultant shear is below a component"),
        ({"slip_work_kj": -1.0, "friction": 0.5}, "rows with negative friction work"),
        ({"slip_work_kj": 1.0}, "rows with friction work but without friction"),
    ],
)
def test_a_fault_of_the_demands_is_named_with_its_row(changed, name):
    rows = failed(demands(**changed))[name]
    assert len(rows) == 1
    assert changed.get("motion_id", "m00") in rows[0]
    assert "osb1_cf_skew00_gap025_mu000" in rows[0]


def test_the_share_not_finished_is_held_against_the_limit_of_the_configuration():
    half = demands(status="timeout")
    assert failed(half, max_unfinished_share=0.49)
    assert failed(half, max_unfinished_share=0.5) == {}


def test_cohesion_may_do_work_without_friction():
    sliding = demands(slip_work_kj=1.0)
    assert failed(sliding, cohesion_n=1e5) == {}
    assert failed(sliding.assign(cohesion_n=1e5)) == {}


def test_a_variant_with_an_analysis_too_few_is_found():
    fewer = demands().head(1).assign(variant="osb1_cf_skew30_gap025_mu000", skew_deg=30)
    found = failed(pd.concat([demands(), fewer]))
    assert found == {
        "rows of variants with fewer analyses than others": (
            "osb1_cf_skew30_gap025_mu000, m00, 1, 0",
        )
    }


def test_searches_of_a_capacity_take_as_many_analyses_as_they_need():
    other = demands().assign(variant="osb1_cf_skew30_gap025_mu000", skew_deg=30)
    further = demands().head(1).assign(scale=1.1)
    table = pd.concat([demands(), further, other])
    assert failed(table, searched=True) == {}
    assert list(failed(table)) == ["rows of variants with fewer analyses than others"]
    assert failed(pd.concat([demands(), further, other.head(1)]), searched=True)


def test_faults_of_fits_and_effects_are_named():
    curves = CURVES.assign(theta=[0.0, None])
    effects = EFFECTS.assign(ratio=[1.2, 1.1])
    assert list(failed(demands(), curves, effects)) == [
        "fitted curves without a positive median",
        "effects whose interval does not hold the ratio",
    ]


def test_a_median_below_that_of_a_smaller_capacity_is_found_whatever_the_order_of_rows():
    fitted = CURVES.assign(status="ok", theta=[0.5, 0.49])
    expected = {
        "medians below that of a smaller capacity": (
            "osb1_cf_skew00_gap025_mu000, column_drift, moderate, cloud",
        )
    }
    assert failed(demands(), fitted) == expected
    assert failed(demands(), fitted[::-1]) == expected
    assert failed(demands(), fitted.assign(theta=[0.5, 0.5])) == {}
    assert failed(demands(), fitted.assign(method=["cloud", "exceedance"])) == {}


def contact_rows(**changed):
    return demands(abutment="contact", variant="osb1_co_skew00_gap025_mu000", **changed).assign(
        abutment="contact", variant="osb1_co_skew00_gap025_mu000"
    )


@pytest.mark.parametrize(("relative", "is_found"), [(1e-10, False), (1e-8, True)])
def test_no_friction_is_held_against_contact_to_nine_digits(relative, is_found):
    both = pd.concat([demands(unseating_m=0.1 * (1.0 + relative)), contact_rows()])
    name = "rows without friction that differ from contact"
    assert (name in failed(both)) is is_found
    if is_found:
        assert failed(both)[name] == ("osb1_cf_skew00_gap025_mu000, m00, 1, 0",)


def test_a_row_with_friction_may_differ_from_contact():
    rubbing = demands(unseating_m=0.2).assign(friction=0.5)
    assert failed(pd.concat([rubbing, contact_rows()])) == {}


def skewed(skew_deg, motions, **changed):
    name = f"osb1_cf_skew{skew_deg}".replace("-", "m")
    rows = demands().assign(variant=name, skew_deg=skew_deg, motion_id=motions)
    return rows.assign(incidence_deg=30.0 if skew_deg > 0 else -30.0, **changed)


def test_a_mirror_image_is_found_in_the_suite_and_compared():
    plus = skewed(40, ["m00", "m01"])
    minus = skewed(-40, ["m00", "m01_mirrored"])
    name = "rows that differ from their mirror image"
    assert failed(pd.concat([plus, minus])) == {}
    # m00 is not mirrored in the suite, so that nothing is said of it
    other = minus.assign(unseating_m=[0.5, 0.102])
    assert failed(pd.concat([plus, other])) == {name: ("osb1_cf_skew40, m01, 1, 30",)}
    assert failed(pd.concat([plus, other.assign(incidence_deg=30.0)])) == {}


def test_a_failed_check_stops_the_study_only_when_asked(tmp_path: Path, caplog):
    bad = tables(demands(unseating_m=float("nan")))
    output = tmp_path / "checks.json"
    write_checks(bad, output)
    assert not json.loads(output.read_text())["passed"]
    assert "osb1_cf_skew00_gap025_mu000, m00" in caplog.text
    with pytest.raises(SolutionError, match="not a number"):
        require_passed(output)
    write_checks(tables(demands()), output)
    require_passed(output)
    assert json.loads(output.read_text())["passed"]
