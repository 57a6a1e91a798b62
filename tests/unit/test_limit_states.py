"""Limit states as data: units, what is refused, and what a doubtful dispersion gets."""

from pathlib import Path

import pytest

from skewbridge.errors import InputError
from skewbridge.fragility.limit_states import demand_unit, limit_states_of, load_limit_states

CONFIG = Path(__file__).parents[2] / "config" / "limit_states.yaml"
STATES = load_limit_states(CONFIG)
ENTRY = {
    "component": "deck",
    "demand": "deck_disp_m",
    "unit": "mm",
    "dispersion": 0.35,
    "citation": "somebody",
    "states": {"slight": 102.0},
}


def test_shipped_limit_states_are_converted_to_the_unit_of_their_column():
    found = {(state.component, state.name): state for state in STATES}
    assert found["unseating", "slight"].threshold == pytest.approx(0.038)
    assert found["column_drift", "moderate"].threshold == pytest.approx(0.025)
    assert found["column_shear", "dcr_100"].threshold == 1.0
    assert found["column_drift", "slight"].dispersion == 0.35
    shear = {state.threshold for state in STATES if state.component == "column_shear"}
    assert shear == {0.5, 0.65, 0.8, 1.0}
    assert all(state.citation for state in STATES)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"unit": "kn"}, "unit: is a force, but deck_disp_m is a length, got 'kn'"),
        ({"unit": "furlong"}, "unit: must be one of m, mm, in, ft, kn"),
        ({"states": {"slight": -1.0}}, "states.slight.median: must be greater than 0, got -1"),
        ({"states": {"slight": "2e7"}}, "a number with an exponent is written like 2.0e+7"),
        ({"states": {"slight": {"median": 1.0, "sd": 0.2}}}, "states.slight.sd: unknown key"),
        ({"states": {}}, "states: Dictionary should have at least 1 item"),
        ({"dispersion": 3.0}, "dispersion: must be less than or equal to 2, got 3"),
        ({"dispersion": None}, "states.slight.dispersion: is missing"),
        ({"colapse": "peak"}, "colapse: unknown key"),
        ({"collapse": "maybe"}, "collapse: must be 'exceeds' or 'peak', got 'maybe'"),
        ({"citation": ""}, "citation: must have at least 1 character, got ''"),
        ({"demand": "deck"}, "carries no unit"),
        ({"demand": f"{'d' * 99}_m"}, "demand: must have at most 100 characters"),
    ],
)
def test_wrong_limit_state_names_entry_and_key(change, text):
    with pytest.raises(InputError, match=r"^limit state entry 0") as caught:
        limit_states_of([ENTRY | change])
    assert text in str(caught.value)


def test_a_doubled_limit_state_is_refused():
    with pytest.raises(InputError, match="deck/slight is defined twice"):
        limit_states_of([ENTRY, ENTRY])


def test_tiny_capacity_dispersion_is_flagged_as_a_likely_unit_slip():
    assert limit_states_of([ENTRY | {"dispersion": 0.0025}])[0].warnings == (
        "small_capacity_dispersion",
    )


def test_unit_of_a_demand_column_is_in_its_name():
    assert demand_unit("column_shear_kn") == "kn"
    assert demand_unit("column_shear_dcr") == "ratio"
    assert demand_unit("column_curvature_ductility") == "ratio"
