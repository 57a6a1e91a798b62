"""The checks of a study's tables find what a sceptical reader would look for."""

import pandas as pd
import pytest

from skewbridge.report.checks import check_tables

CURVES = pd.DataFrame({"status": ["ok", "no_exceedance"], "theta": [0.5, float("nan")]})
EFFECTS = pd.DataFrame({"ratio": [1.0, 1.1], "ci_low": [0.9, None], "ci_high": [1.1, None]})


def demands(**changed):
    """Return two good runs; a changed column replaces the values of the first."""
    row = {
        "variant": "osb1_cf_skew00_gap025_mu000",
        "scale": 1.0,
        "incidence_deg": 0.0,
        "friction": 0.0,
        "status": "ok",
        "column_shear_kn": 100.0,
        "column_shear_x_kn": 80.0,
        "column_shear_y_kn": 70.0,
        "slip_work_kj": 0.0,
        "unseating_m": 0.1,
    }
    return pd.DataFrame([{**row, "motion_id": "m00", **changed}, {**row, "motion_id": "m01"}])


def failed(table, curves=CURVES, effects=EFFECTS):
    return [check.name for check in check_tables(table, curves, effects) if not check.passed]


def test_good_tables_pass():
    assert failed(demands()) == []


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"motion_id": "m01"}, "analyses that stand there twice"),
        ({"status": "finished"}, "rows without a known status"),
        ({"status": "timeout"}, "share of rows with status ok or collapse"),
        ({"variant": "osb1_cf_skew30_gap025_mu000"}, None),
        ({"unseating_m": float("nan")}, "usable rows with a demand that is not a number"),
        ({"column_shear_x_kn": 101.0}, "usable rows whose resultant shear is below a component"),
        ({"slip_work_kj": -1.0, "friction": 0.5}, "rows with negative friction work"),
        ({"slip_work_kj": 1.0}, "rows with friction work though friction is zero"),
    ],
)
def test_a_fault_of_the_demands_is_named(changed, name):
    found = failed(demands(**changed))
    assert found == [] if name is None else name in found


def test_a_variant_with_a_motion_too_few_is_found():
    table = demands()
    fewer = table.head(1).assign(variant="osb1_cf_skew30_gap025_mu000")
    assert failed(pd.concat([table, fewer])) == ["variants with fewer motions than others"]


def test_faults_of_fits_and_effects_are_named():
    curves = CURVES.assign(theta=[0.0, None])
    effects = EFFECTS.assign(ratio=[1.2, 1.1])
    assert failed(demands(), curves, effects) == [
        "fitted curves without a positive median",
        "effects whose interval does not hold the ratio",
    ]
