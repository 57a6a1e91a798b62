"""Masses, loads, damping and energy groups of a built model."""

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.modal import apply_rayleigh, damping_ratio, rayleigh_factors
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.deck import lumping_shares, mass_centre_m
from skewbridge.bridge.gravity import column_axial_forces_n
from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions


def test_masses_and_loads_add_up() -> None:
    with domain():
        model = build(variant(30), ModelOptions())
        columns_n = 2 * 23.56e3 * np.pi * 1.676**2 / 4 * 5.64
        # the ground carries the lower half of every column
        assert sum(model.deck_masses_kg.values()) * G_MPS2 == pytest.approx(
            model.weight_n - columns_n / 2
        )
        for node, mass in model.deck_masses_kg.items():
            assert ops.nodeMass(node, 1) == pytest.approx(mass)


def test_rayleigh_damping_meets_its_ratio_at_both_periods() -> None:
    bridge = load_bridge("osb1")
    a0, a1 = rayleigh_factors(bridge, damping_ratio(bridge, ModelOptions()))
    assert a0 == pytest.approx(0.487, rel=0.01)
    assert a1 == pytest.approx(0.00406, rel=0.01)
    for period_s in (0.94, 0.35):
        omega = 2 * np.pi / period_s
        assert a0 / (2 * omega) + a1 * omega / 2 == pytest.approx(0.05)


def test_the_damping_ratio_of_the_options_overrides_that_of_the_file() -> None:
    with domain():
        model = build(variant(30), ModelOptions(damping_ratio=0.02))
        expected = np.array(rayleigh_factors(model.bridge, model.bridge.damping.ratio)) * 0.4
        assert apply_rayleigh(model) == pytest.approx(expected)


def test_only_deck_and_columns_are_damped() -> None:
    with domain():
        model = build(variant(30), ModelOptions())
        apply_rayleigh(model)
        springs = {
            tag
            for group in ("backfill", "contact", "links", "bearings")
            for tag in model.energy_elements[group]
        }
        assert not springs & set(model.damping_elements)
        assert set(model.damping_elements) == {
            *model.energy_elements["deck"],
            *model.energy_elements["columns"],
        }


def test_every_element_is_in_one_energy_group() -> None:
    with domain():
        model = build(variant(30, "spring"), ModelOptions(arrays="corotational"))
        grouped = [tag for tags in model.energy_elements.values() for tag in tags]
        assert sorted(grouped) == sorted(ops.getEleTags())


def moving_mass_kg(options: ModelOptions, abutment: str) -> float:
    """Return the largest mass of a wall, key or body node along x."""
    with domain():
        model: BridgeModel = build(variant(0, abutment), options)
        nodes = [
            node
            for end in model.abutments
            for node in (*end.key_nodes, *(spring.nodes[1] for spring in end.wing_springs))
        ]
        return max(float(ops.nodeMass(node, 1)) for node in nodes)


@pytest.mark.parametrize(
    ("abutment", "option", "least_kg"),
    [
        ("spring", "embankment_mass", 1e5),
        ("spring", "wall_mass", 1e3),
        ("contact_friction", "wall_mass", 1e3),
    ],
)
def test_abutments_have_mass_only_on_request(abutment: str, option: str, least_kg: float) -> None:
    assert moving_mass_kg(ModelOptions(), abutment) == 0.0
    assert moving_mass_kg(ModelOptions(**{option: True}), abutment) > least_kg


@pytest.mark.parametrize("elements", [1, 2, 3, 4, 5, 8])
def test_lumped_masses_keep_the_total_and_the_moment_of_inertia(elements: int) -> None:
    shares = np.array(lumping_shares(elements))
    places = np.arange(elements + 1) - elements / 2
    assert shares.sum() == pytest.approx(elements)
    assert (shares > 0.0).all()
    if elements > 1:
        assert shares @ places**2 == pytest.approx(elements**3 / 12)


@pytest.mark.parametrize("bridge", ["osb2s", "bridge_b"])
def test_the_mass_centre_is_that_of_the_masses(bridge: str) -> None:
    with domain():
        model = build(variant(0, "roller", bridge), ModelOptions())
        masses = model.deck_masses_kg
        moment = sum(mass * ops.nodeCoord(node)[0] for node, mass in masses.items())
        found = mass_centre_m(model.bridge)
        assert found == pytest.approx(moment / sum(masses.values()), abs=1e-4)
        assert abs(found) > 0.1


def test_a_foundation_settles_by_the_force_of_its_column_over_its_stiffness() -> None:
    options = ModelOptions(foundation="springs")
    with domain():
        model = build(variant(0, "roller", "bridge_a"), options)
        for column, force_n in zip(model.columns, column_axial_forces_n(model), strict=True):
            settled_m = -ops.nodeDisp(column.base_node, 3)
            assert settled_m == pytest.approx(force_n / 597e6, rel=1e-3)


def test_the_rotational_inertia_of_the_deck_is_that_of_a_box() -> None:
    with domain():
        model = build(variant(0, "roller"), ModelOptions())
        deck = model.bridge.deck
        node = model.deck_nodes[2]  # in a span, away from caps and diaphragms
        mass = ops.nodeMass(node, 1)
        square_m2 = [deck.width_m**2 + deck.depth_m**2, deck.depth_m**2, deck.width_m**2]
        found = [ops.nodeMass(node, dof) for dof in (4, 5, 6)]
        assert found == pytest.approx([mass * each / 12 for each in square_m2])
