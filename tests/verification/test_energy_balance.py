"""The energy balance closes and separates the dissipation of model and integrator."""

from math import isnan

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, variant
from skewbridge.analysis import energy
from skewbridge.analysis.energy import elastic_stiffness, energy_ratios, held_by_contacts
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion

TRAPEZOIDAL = ("Newmark", 0.5, 0.25)
#: Damps by gamma > 1/2, in proportion to the step.
DAMPED = ("Newmark", 0.6, 0.3025)


def run(abutment="contact_friction", options=None, **settings):
    """Two contacts of each corner and a yielding column within 3 s."""
    case = variant(abutment=abutment, gap_mm=25).normalised()
    return analysed(case, strong_motion(duration_s=3.0), options, **settings)


@pytest.mark.parametrize("abutment", ["contact_friction", "simplified", "roller"])
@pytest.mark.parametrize("dt_s", [0.0025, 0.01])
def test_the_trapezoidal_rule_leaves_no_energy_unaccounted_for(abutment, dt_s):
    """The residual is in the damping of yielding columns: their stiffness jumps within steps."""
    result = run(abutment, integrator=TRAPEZOIDAL, dt_s=dt_s)
    terms = result.energy_kj
    assert abs(result.demands["energy_residual_ratio"]) < 4e-4
    assert result.demands["numerical_dissipation_ratio"] == 0.0
    assert all(terms[name] > 0.0 for name in ("input", "damping", "columns"))


def test_the_balance_closes_with_elastic_columns():
    terms = run(options=ModelOptions(elastic_columns=True)).energy_kj
    # 8e-6; without the work of the dead load's fixed-end moments it would be 4.7e-4
    assert abs(terms["residual"]) < 5e-5 * terms["largest_input"]
    assert terms["damping"] > 0.0


def test_the_dissipation_of_an_integrator_is_a_term_of_its_own():
    """The residual comes from other forces: that it is small proves the dissipation right."""
    for settings, least, most in (
        # HHT dissipates in proportion to the cube of the step: next to nothing here; its residual
        # goes with the step
        ({"integrator": ("HHT", 0.9), "dt_s": 0.005}, -1e-4, 1e-3),
        ({"integrator": DAMPED}, 2e-3, 2e-2),
        ({"scheme": "paper"}, 2e-3, 2e-2),
    ):
        found = run(**settings).demands
        assert abs(found["energy_residual_ratio"]) < 2e-3, settings
        assert least < found["numerical_dissipation_ratio"] < most, settings
    # that of a damped rule goes with the step
    runs = (run("roller", integrator=DAMPED, dt_s=dt_s) for dt_s in (0.01, 0.005))
    whole, half = (each.demands["numerical_dissipation_ratio"] for each in runs)
    assert whole / half == pytest.approx(2.0, rel=0.1)


def test_contacts_take_from_the_deck_what_walls_and_keys_give_to_the_ground(monkeypatch):
    """The work behind contacts is that of the springs themselves, had they been read."""
    short = run(integrator=TRAPEZOIDAL).energy_kj
    monkeypatch.setattr(energy, "held_by_contacts", lambda _model: {})
    read = run(integrator=TRAPEZOIDAL).energy_kj
    assert short["backfill"] > 0.02 * short["input"]
    assert short["backfill"] == pytest.approx(read["backfill"], rel=1e-4)


def test_only_massless_nodes_stand_for_their_springs():
    with domain():
        model = build(variant(), ModelOptions())
        springs = {element for held in held_by_contacts(model).values() for element in held}
        assert springs == set(model.energy_elements["backfill"])
    with domain():
        assert held_by_contacts(build(variant(), ModelOptions(wall_mass=True))) == {}


@pytest.mark.parametrize("bridge", ["osb1", "osb2s", "bridge_a"])
def test_the_stiffness_of_spine_and_caps_gives_their_end_forces(bridge):
    with domain():
        model = build(variant(bridge=bridge), ModelOptions())
        for element in model.energy_elements["deck"]:
            ends = np.hstack([ops.nodeDisp(node) for node in ops.eleNodes(element)])
            force = np.array(ops.eleForce(element))
            limit = 1e-9 * np.abs(force).max()
            assert elastic_stiffness(element) @ ends == pytest.approx(force, rel=1e-9, abs=limit)


def test_without_a_balance_or_an_input_there_is_no_ratio():
    terms = dict.fromkeys(("largest_input", "residual", "numerical", "contact_quadrature"), 0.0)
    for given in ({}, terms):
        assert all(isnan(value) for value in energy_ratios(given).values())
    terms |= {"largest_input": 4.0, "residual": 1.0, "contact_quadrature": -2.0}
    names = ("energy_residual_ratio", "numerical_dissipation_ratio", "contact_energy_ratio")
    assert energy_ratios(terms) == dict(zip(names, (0.25, 0.0, -0.5), strict=True))
