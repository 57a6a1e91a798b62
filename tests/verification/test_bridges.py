"""Bridges: hand values, every abutment on every bridge, invariances, energy, pushes, periods.

The study `bridges` (run in `test_closed_forms`) has the weights, axial forces, periods and
strengths with their sources and tolerances (1 % on weight and axial force, 5 % on periods and
pushover strength). The deck load of the earlier models enters in the middle of the cap."""

from itertools import product
from math import cos, cosh, isfinite, isnan, pi, radians, sin, sinh, sqrt

import numpy as np
import openseespy.opensees as ops
import pytest
from reference_pages import ROOT
from scipy.optimize import brentq

from bridge_variants import analysed, variant
from skewbridge.analysis import energy
from skewbridge.analysis.modal import apply_rayleigh, modal_properties
from skewbridge.analysis.pushover import push_bridge
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import StepLoop
from skewbridge.bridge import weights
from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.structures import built_bridge
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS
from strong_motion import mirrored, strong_motion

ROLLER, ELASTIC = variant(0, "roller"), ModelOptions(elastic_columns=True)
RAMP_S = 20.0
PEAKS = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
MIRRORED = mirrored(strong_motion())
NOT_COMPARED = ("energy_residual_ratio", "numerical_dissipation_ratio", "contact_closures")
TRAPEZOIDAL = ("Newmark", 0.5, 0.25)
#: Damps by gamma > 1/2, in proportion to the step.
DAMPED = ("Newmark", 0.6, 0.3025)
BRIDGES = ("osb1", "osb2s", "bridge_a", "bridge_b", "bridge_c")
PLACES = product(BRIDGES, ABUTMENTS, (0, 20, 40, 60))
ALL = [variant(skew_deg, abutment, bridge) for bridge, abutment, skew_deg in PLACES]
CARRYING = [*ALL[::3], variant(0, bridge="osb1_era1"), variant(0, bridge="osb1_fixed")]


@pytest.mark.parametrize("name", bridge_names())
def test_dead_load_and_conditioning_period_of_every_bridge(name):
    bridge = load_bridge(name)
    rigid, result = (modal_properties(variant(0, bridge=name), ModelOptions(foundation=foundation))
                     for foundation in ("fixed", "springs"))  # fmt: skip
    # the hand values are for supports that do not settle
    axial_kn = iter(rigid.column_axial_kn)
    for number, bent in enumerate(bridge.bents):
        mean_kn = sum(next(axial_kn) for _ in range(bent.columns)) / bent.columns
        assert mean_kn == pytest.approx(weights.column_axial_n(bridge, number) / 1e3, rel=0.01)
    # the rigid-bent reactions of the end spans ignore column stiffness and pad compression
    first, *_, last = weights.deck_reactions_n(bridge)
    assert rigid.abutment_reaction_kn == pytest.approx((first / 1e3, last / 1e3), rel=0.03)
    # The conditioning period is that of the model with open gaps.
    period_s = sqrt(result.period_s("x") * result.period_s("y"))
    assert bridge.t1_s == pytest.approx(period_s, rel=0.002)


def test_cap_load_changes_the_thrust_of_a_bent_at_rest_but_not_strength_and_base_forces():
    # turns of the cap over a column: w (6 a^2 L - L^3)/24 spread, w b L^2/16 in the middle:
    # 0.128 of it, the other way, with span L, overhang a and deck width b
    for cap_load, thrust_kn in (("spread", 67.0), ("middle", 524.0)):
        with domain():
            model = build(ROLLER, ModelOptions(cap_load=cap_load, elastic_columns=True))
            thrusts_n = [ops.eleResponse(column.element, "force")[1] for column in model.columns]
        assert thrusts_n[0] == pytest.approx(-thrusts_n[1], rel=1e-6)
        assert abs(thrusts_n[0]) / 1e3 == pytest.approx(thrust_kn, rel=0.1)
    spread, middle = ModelOptions(), ModelOptions(cap_load="middle")
    push = {"angle_deg": 0.0, "max_disp_m": 0.2, "steps": 60}
    curves = [push_bridge(ROLLER, options, **push) for options in (spread, middle)]
    assert all(curve.is_complete for curve in curves)
    assert curves[0].peak_n == pytest.approx(curves[1].peak_n, rel=0.01)
    axial = modal_properties(variant(0), spread).column_axial_kn
    assert axial == pytest.approx([5_997, 5_997], rel=0.01)
    # on rollers only the torsion of the columns resists a turn
    assert 3.4 < modal_properties(ROLLER, middle).period_s("rz") < 4.5
    # The thrust of this cap load opens columns of distributed plasticity at rest; where they crack,
    # and so their state, takes a fine mesh (1.4 % of the period along x).
    fine = ModelOptions(column_integration="lobatto5", cap_load="middle", column_fibers=(12, 32, 3))
    result = modal_properties(variant(0, "roller", "bridge_b"), fine)
    assert [result.period_s(axis) for axis in "xy"] == pytest.approx([1.04, 1.04], rel=0.05)


@pytest.mark.parametrize("case", CARRYING, ids=lambda case: case.slug)
def test_every_variant_carries_its_weight_and_has_sane_modes(case):
    result = modal_properties(case)
    bridge = built_bridge(load_bridge(case.bridge), ModelOptions(), case.skew_deg)
    assert result.weight_kn == pytest.approx(weights.total_weight_n(bridge) / 1e3, rel=1e-6)
    carried = sum(result.column_axial_kn) + sum(result.abutment_reaction_kn)
    assert carried == pytest.approx(result.weight_kn, rel=1e-6)
    assert all(force > 0.0 for force in (*result.column_axial_kn, *result.abutment_reaction_kn))
    for direction in ("x", "y", "rz"):
        assert 0.2 < result.period_s(direction) < 6.0, direction
    assert all(isfinite(mode.period_s) for mode in result.modes)
    shares = np.sum([(m.mass_x, m.mass_y, m.mass_rz) for m in result.modes], axis=0)
    assert np.all(shares <= 1.0 + 1e-6)


@pytest.mark.parametrize(
    ("case", "motion", "duration_s"),
    [
        *((case, strong_motion(duration_s=3.0), None) for case in ALL[::7]),
        *(pytest.param(case, strong_motion(duration_s=10.0), 10.0, marks=pytest.mark.slow)
          for case in ALL),
    ],
    ids=lambda given: getattr(given, "slug", ""),
)  # fmt: skip
def test_variants_survive_strong_motions(case, motion, duration_s):
    result = analysed(case, motion, duration_s=duration_s)
    assert result.status in ("ok", "collapse"), result.messages
    assert (result.status == "collapse") == bool(result.collapse_criterion)
    assert all(isfinite(value) for value in result.demands.values())
    assert abs(result.demands["energy_residual_ratio"]) < 0.005


def test_every_shear_model_has_its_column_and_none_changes_the_analysis():
    case = variant(0, "contact", "osb1_era1", friction_pct=0)
    models = ("kowalsky_priestley", "ucsd_tests", "sdc_expected", "sdc_nominal")
    names = [f"column_shear_dcr_{model}" for model in models]
    ratios = []
    for model, own in zip(models, names, strict=True):
        result = analysed(case, strong_motion(duration_s=3.0), ModelOptions(shear_model=model))
        assert result.whole_history["column_shear_dcr"] == result.whole_history[own]
        # over the whole history, also after a failure
        assert result.demands[own] == result.whole_history[own] > 0.0
        ratios.append([result.whole_history[name] for name in names])
    assert (ratios[0], ratios) == (sorted(set(ratios[0])), [ratios[0]] * 4)


def test_without_friction_or_closures_there_is_no_effect_of_contact_friction():
    frictionless = analysed(variant(friction_pct=0))
    plain = analysed(variant(abutment="contact", friction_pct=0))
    # Same equations, numbering and springs: only the updates are left out.
    for name, value in frictionless.demands.items():
        assert plain.demands[name] == pytest.approx(value, rel=1e-9, abs=1e-12), name
    # Tangential springs that are a thousand times softer: as good as none.
    options = ModelOptions(tangent_stiffness_factor=1e-3)
    bare = analysed(variant(abutment="contact", friction_pct=0), options=options)
    for name in (*PEAKS, "deck_rotation_rad"):
        assert bare.demands[name] == pytest.approx(frictionless.demands[name], rel=0.01), name
    # 0.6 m at the backwalls and 5 m at the keys, against a deck that moves by decimetres.
    wide = analysed(variant(gap_mm=600), options=ModelOptions(transverse_gap_mm=5000.0))
    assert wide.status == "ok"
    assert wide.demands["deck_disp_m"] > 0.05
    for name in (
        "contact_closures", "contact_time_s", "contact_max_penetration_m", "slip_work_kj",
        "backwall_force_kn", "shear_key_force_kn", "friction_force_kn", "cone_violation_ratio",
    ):  # fmt: skip
        assert wide.demands[name] == 0.0, name


@pytest.mark.parametrize(("incidence_deg", "along", "across"), [(0.0, "x", "y"), (90.0, "y", "x")])
def test_a_motion_along_one_axis_shears_the_columns_along_this_axis(incidence_deg, along, across):
    motion = strong_motion(duration_s=3.0, peak_g=0.1)
    motion = motion.with_components(motion.accel_1_mps2, 0.0 * motion.accel_2_mps2)
    demands = analysed(variant(0, "roller"), motion, incidence_deg=incidence_deg).whole_history
    shear_kn = {axis: demands[f"column_shear_{axis}_kn"] for axis in "xy"}
    assert shear_kn[along] == pytest.approx(demands["column_shear_kn"], rel=0.02)
    # at rest the cap thrusts the columns of a bent apart
    assert shear_kn[across] < 0.2 * shear_kn[along]


def test_opposite_skew_mirrors_the_response_and_half_a_turn_reverses_the_motion():
    # steps of one size and a tight test: rounding, which differs between processors, then decides
    # neither on the size of a step nor on an iteration
    tight = {"tolerance_j": 1e-8, "reuse_tangent": False, "dt_s": 0.001, "contact_dt_s": 0.001}
    (one, other), rough = (
        (analysed(variant(60), **settings), analysed(variant(-60), MIRRORED, **settings))
        for settings in (tight | {"event_dt_s": None, "duration_s": 4.0}, {})
    )
    found = one.demands
    assert found["contact_closures"] > 10
    largest_kns = found["friction_force_kn"] * found["contact_time_s"]
    assert 0.0 < found["friction_impulse_kns"] < largest_kns
    for name, sign in (("deck_ux_m", 1.0), ("deck_uy_m", -1.0), ("deck_rot_rad", -1.0)):
        history, image = one.histories[name][:1001], sign * other.histories[name][:1001]
        # 1e-9: rounding, grown by contacts (measured 1e-14)
        np.testing.assert_allclose(image, history, rtol=0, atol=1e-9 * np.abs(history).max())
    for name, value in one.demands.items():
        if name not in NOT_COMPARED:
            assert other.demands[name] == pytest.approx(value, rel=0.01, abs=1e-9), name
    for name in PEAKS:
        assert rough[1].demands[name] == pytest.approx(rough[0].demands[name], rel=0.01), name
    motion = strong_motion(duration_s=3.0)
    reverse = motion.with_components(-motion.accel_1_mps2, -motion.accel_2_mps2)
    turned = analysed(variant(0), motion, incidence_deg=180.0).demands
    assert analysed(variant(0), reverse).demands == pytest.approx(turned, rel=1e-12)


@pytest.mark.parametrize("skew_deg", [0, 30])
def test_corotational_arrays_give_the_demands_of_rigid_links(skew_deg):
    rigid, elements = (analysed(variant(skew_deg), strong_motion(), ModelOptions(arrays=arrays))
                       for arrays in ("rigid", "corotational"))  # fmt: skip
    assert rigid.status == elements.status == "ok"
    for name in PEAKS:
        assert elements.demands[name] == pytest.approx(rigid.demands[name], rel=0.005), name


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


def test_the_balance_closes_with_elastic_columns_and_has_the_work_behind_contacts(monkeypatch):
    terms = run(options=ELASTIC).energy_kj
    # 8e-6; without the work of the dead load's fixed-end moments it would be 4.7e-4
    assert abs(terms["residual"]) < 5e-5 * terms["largest_input"]
    assert terms["damping"] > 0.0
    # the work behind contacts is that of the springs themselves, had they been read
    short = run(integrator=TRAPEZOIDAL).energy_kj
    monkeypatch.setattr(energy, "held_by_contacts", lambda _model: {})
    read = run(integrator=TRAPEZOIDAL).energy_kj
    assert short["backfill"] > 0.02 * short["input"]
    assert short["backfill"] == pytest.approx(read["backfill"], rel=1e-4)


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


def test_only_massless_nodes_stand_for_springs_and_without_a_balance_there_is_no_ratio():
    with domain():
        model = build(variant(), ModelOptions())
        springs = {element for held in energy.held_by_contacts(model).values() for element in held}
        assert springs == set(model.energy_elements["backfill"])
    with domain():
        assert energy.held_by_contacts(build(variant(), ModelOptions(wall_mass=True))) == {}
    terms = dict.fromkeys(("largest_input", "residual", "numerical", "contact_quadrature"), 0.0)
    for given in ({}, terms):
        assert all(isnan(value) for value in energy.energy_ratios(given).values())
    terms |= {"largest_input": 4.0, "residual": 1.0, "contact_quadrature": -2.0}
    names = ("energy_residual_ratio", "numerical_dissipation_ratio", "contact_energy_ratio")
    assert energy.energy_ratios(terms) == dict(zip(names, (0.25, 0.0, -0.5), strict=True))


@pytest.mark.parametrize("bridge", ["osb1", "osb2s", "bridge_a"])
def test_the_stiffness_of_spine_and_caps_gives_their_end_forces(bridge):
    with domain():
        for element in build(variant(bridge=bridge), ModelOptions()).energy_elements["deck"]:
            ends = np.hstack([ops.nodeDisp(node) for node in ops.eleNodes(element)])
            force = np.array(ops.eleForce(element))
            limit = 1e-9 * np.abs(force).max()
            np.testing.assert_allclose(energy.elastic_stiffness(element) @ ends, force, 0, limit)


def test_the_cap_below_a_steel_deck_is_of_concrete():
    steel = ROOT / "tests/data/drawings/steel.yaml"
    with domain():
        *_, cap = build(variant(0, bridge=str(steel)), ModelOptions()).energy_elements["deck"]
        modulus_pa = energy.elastic_stiffness(cap)[1, 1] * 3.0 / (1.8 * 1.5)
    assert modulus_pa == pytest.approx(load_bridge(steel).column.elastic_modulus_gpa * 1e9)


@pytest.mark.parametrize(("skew_deg", "dof"), [(30, 1), (60, 2)])
def test_a_push_with_friction_agrees_with_a_slow_ramp(skew_deg, dof):
    """The ramp is a response history with masses, damping and steps of 10 to 0.3 ms, in which
    friction is set from the predicted normal force; its inertia and damping are about 0.1 %."""
    case = variant(skew_deg, gap_mm=25)
    push = {"angle_deg": 90.0 * (dof - 1), "max_disp_m": 0.06, "steps": 80}
    curve = push_bridge(case, ModelOptions(), **push)
    assert curve.is_complete
    assert curve.disp_m[-1] == pytest.approx(0.06, rel=1e-3)
    assert curve.imbalance < 1e-6
    settings, rows, rate_n_per_s = AnalysisSettings(), [], 0.9 * curve.peak_n / RAMP_S
    with domain():
        model = build(case, ModelOptions())
        apply_rayleigh(model)
        series, centre = model.tags.series(), model.frame.centre_node
        ops.timeSeries("Linear", series, "-factor", rate_n_per_s)
        ops.pattern("Plain", model.tags.pattern(), series)
        masses = model.frame.loads.masses_kg
        for node, mass_kg in masses.items():
            share = [0.0] * 6
            share[dof - 1] = mass_kg / sum(masses.values())
            ops.load(node, *share)
        start_m = ops.nodeDisp(centre, dof)

        def read():
            rows.append((ops.nodeDisp(centre, dof) - start_m, ops.getTime() * rate_n_per_s))

        loop = StepLoop(model.contacts, settings, longest_s=0.0)
        assert loop.run(round(RAMP_S / settings.dt_s), read).status == "ok"
    disp_m, forces_n = np.array(rows).T
    # from the displacement at which the start of the ramp is forgotten
    compared_m = np.linspace(0.01, 0.95 * disp_m[-1], 20)
    expected_n = np.interp(compared_m, disp_m, forces_n)
    np.testing.assert_allclose(np.interp(compared_m, curve.disp_m, curve.force_n), expected_n, 0.02)
    if dof == 1:  # friction matters: without it, the force is far smaller
        without = push_bridge(variant(skew_deg, gap_mm=25, friction_pct=0), ModelOptions(), **push)
        assert np.interp(compared_m[-1], without.disp_m, without.force_n) < 0.92 * expected_n[-1]


@pytest.mark.parametrize("bridge", ["osb2s", str(ROOT / "docs/own_bridge.py")])
def test_lever_and_displacement_control_agree_before_contact(bridge):
    """Osb2s has no mass at its centre; the script has rigid links. Little friction: no effect."""
    push = {"angle_deg": 40.0, "max_disp_m": 0.03, "steps": 30}
    cases = [variant(30, bridge=bridge, friction_pct=mu) for mu in (0.0, 0.1)]
    curves = [push_bridge(case, ModelOptions(), **push) for case in cases]
    # along the push, although the deck also moves across it
    assert [curve.disp_m[-1] for curve in curves] == pytest.approx([0.03] * 2, rel=3e-4)
    control, lever = (np.interp([0.01, 0.03], c.disp_m, c.force_n) for c in curves)
    assert lever == pytest.approx(control, rel=5e-4)


# --- periods of OSB1 with open gaps and elastic columns, against a beam and a rigid body by hand
# All numbers are those of its file. The beam is exact for the uniform deck (with its rotational
# inertia), on the spring of the bent and those of the pads. Left out are the twist of the deck ends
# and turns of the column tops: 0.1 % of the transverse period, 0.4 to 0.6 % of that in plan.
G = 9.80665
SPAN_M, WIDTH_M = 45.72, 14.33
DECK_KG_PER_M, DIAPHRAGM_KG, CAP_KG = 186.2e3 / G, 321e3 / G, 801e3 / G
DECK_PA, COLUMN_PA = 24.86e9, 28.34e9
PADS_N_PER_M = 5 * 2208e3  # of one abutment
# two columns of 5.64 m, 7.32 m apart, pinned at the base; 1.01 m from soffit to centroid
HEIGHT_M, RIGID_M, APART_M = 5.64, 1.01, 7.32
AREA_M2, INERTIA_M4 = pi / 4 * 1.676**2, pi / 64 * 1.676**4
COLUMN_KG = 23.56e3 * AREA_M2 * HEIGHT_M / G
BENDING_NM2 = 0.45 * COLUMN_PA * INERTIA_M4
CAP_WIDTH_M, CAP_DEPTH_M = 2.29, 1.829
AXIAL_N = (1.25 * DECK_KG_PER_M * SPAN_M + CAP_KG + 2 * COLUMN_KG) * G / 2


def test_transverse_period_is_that_of_a_beam_on_three_springs():
    # stiffness along the bent, at the centroid: a frame with a flexible cap
    level_m, bending_nm2 = HEIGHT_M + RIGID_M, DECK_PA * 114.5
    cap_nm = 6 * DECK_PA * CAP_WIDTH_M * CAP_DEPTH_M**3 / 12 / APART_M  # bent in an S
    # rolling of the cap: columns in tension and compression, and torsion of both spans
    rolling_nm = COLUMN_PA * AREA_M2 / HEIGHT_M * APART_M**2 / 2
    rolling_nm += 2 * DECK_PA / 2.4 * 11.04 / SPAN_M
    column_m_per_n = HEIGHT_M**3 / (3 * BENDING_NM2) + level_m**2 * (1 / cap_nm + 2 / rolling_nm)
    bent_n_per_m = 2 / column_m_per_n - 2 * AXIAL_N / level_m  # less P-Delta
    gyration = WIDTH_M**2 / 12

    def determinant(speed):
        """Rows: no slope and half of the bent at the middle; no moment and the pads at the end."""
        turning = DECK_KG_PER_M * gyration * speed**2
        root = sqrt(turning**2 + 4 * bending_nm2 * DECK_KG_PER_M * speed**2)
        p, q = (sqrt((root + sign * turning) / (2 * bending_nm2)) for sign in (-1, 1))

        def terms(x):
            """Return the four functions and their three derivatives, (4, 4)."""
            ch, sh, c, s = cosh(p * x), sinh(p * x), cos(q * x), sin(q * x)
            return np.array([
                [ch, sh, c, s],
                [p * sh, p * ch, -q * s, q * c],
                [p**2 * ch, p**2 * sh, -(q**2) * c, -(q**2) * s],
                [p**3 * sh, p**3 * ch, q**3 * s, -(q**3) * c],
            ])  # fmt: skip

        middle, end = terms(0.0), terms(SPAN_M)
        bent = (bent_n_per_m - (CAP_KG + COLUMN_KG) * speed**2) / 2
        pads = PADS_N_PER_M - DIAPHRAGM_KG * speed**2
        rows = np.array([
            middle[1],
            bending_nm2 * middle[3] + turning * middle[1] + bent * middle[0],
            bending_nm2 * end[2] - DIAPHRAGM_KG * gyration * speed**2 * end[1],
            bending_nm2 * end[3] + turning * end[1] - pads * end[0],
        ])  # fmt: skip
        return np.linalg.det(rows / np.abs(rows).max(axis=1, keepdims=True))

    period_s = 2 * pi / brentq(determinant, 7.0, 11.0)
    modes = modal_properties(variant(0, "contact"), ELASTIC)
    assert modes.period_s("y") == pytest.approx(period_s, rel=0.003)
    # as a rigid body, the deck would be 3 % too fast
    mass_kg = 2 * SPAN_M * DECK_KG_PER_M + CAP_KG + COLUMN_KG + 2 * DIAPHRAGM_KG
    assert 2 * pi * sqrt(mass_kg / (bent_n_per_m + 2 * PADS_N_PER_M)) < 0.98 * period_s


@pytest.mark.parametrize(("skew_deg", "error"), [(0, 0.004), (60, 0.006)])
def test_period_in_plan_is_that_of_a_rigid_parallelogram_on_pads_and_columns(skew_deg, error):
    stretch = 1 / cos(radians(skew_deg))
    # a column normal to its bent: its top does not turn, the cap bends in plan
    lever_m, inertia_m4 = stretch * APART_M / 2, CAP_DEPTH_M * CAP_WIDTH_M**3 / 12
    m_per_n = HEIGHT_M**3 / (3 * BENDING_NM2) + lever_m**3 / (3 * DECK_PA * inertia_m4)
    axial_n = AXIAL_N + (stretch - 1) * CAP_KG * G / 2
    column_n_per_m = 1 / m_per_n - axial_n / HEIGHT_M
    torsion_nm = 0.2 * COLUMN_PA / 2.4 * 2 * INERTIA_M4 / HEIGHT_M
    pads_m2 = np.mean((stretch * 2.90 * np.arange(-2, 3)) ** 2) + SPAN_M**2
    stiffness_nm = 2 * PADS_N_PER_M * pads_m2 + 2 * (column_n_per_m * lever_m**2 + torsion_nm)
    # of a parallelogram: (length^2 + skewed edge^2) / 12 about its middle
    square_m2 = (2 * SPAN_M) ** 2 + (stretch * WIDTH_M) ** 2
    inertia_kgm2 = 2 * SPAN_M * DECK_KG_PER_M * square_m2 / 12
    # diaphragms along the skew are longer
    inertia_kgm2 += 2 * stretch * DIAPHRAGM_KG * (SPAN_M**2 + (stretch * WIDTH_M) ** 2 / 12)
    inertia_kgm2 += COLUMN_KG * lever_m**2
    period_s = 2 * pi * sqrt(inertia_kgm2 / stiffness_nm)
    modes = modal_properties(variant(skew_deg, "contact"), ELASTIC)
    assert modes.period_s("rz") == pytest.approx(period_s, rel=error)
