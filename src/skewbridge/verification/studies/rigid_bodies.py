"""Rigid bodies between walls: a particle (figure 4 of the paper), skew decks (figures 5 to 8).

The particle moves on an isotropic support between two inclined lines. The first deck is that of
Dimitrakopoulos (2011) under a pulse, the second is the deck of Wu et al. (2019) on a shake table.
Mass, bearings, damping and table motion of the tests are not public, and the rotation varies four-
to fivefold over their plausible range. The second deck is therefore compared with a solution of the
same equations without OpenSees, and only statements that do not need test data are judged.
"""

from functools import partial
from itertools import pairwise, product
from math import cos, isclose, pi, radians, sin
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.contact import ContactSet
from skewbridge.contact.drives import kelvin_voigt_damping_ratio, kelvin_voigt_drive
from skewbridge.files.tables import Floats
from skewbridge.units import KN, MM
from skewbridge.verification.references import cases
from skewbridge.verification.references import deck_solvers as solvers
from skewbridge.verification.references import live_model as live
from skewbridge.verification.references.cases import SCALE_M, deck_case
from skewbridge.verification.references.deck_solvers import run_deck
from skewbridge.verification.references.lcp import RigidContacts, moreau_jean
from skewbridge.verification.references.live_model import History, cone_excess, rms
from skewbridge.verification.registry import Panel, Study, drawn
from skewbridge.verification.studies.paper_runs import paper_record

_CLOSE: Final = 0.03  # fraction of the gap: the penetration allowed for Kn = 1e9 N/m

# ASSUME mass, support and restitution: the paper gives gap, slope, pulse, friction, damping.
_MASS_KG: Final = 1000.0
_STIFFNESS_N_PER_M: Final = _MASS_KG * (2.0 * pi / 1.0) ** 2  # a period of 1 s
_DASHPOT_N_S_PER_M: Final = 2.0 * 0.05 * _MASS_KG * 2.0 * pi / 1.0  # 5 % of critical
_HALF_GAP_M: Final = 0.0268  # distance of each line from the origin
_LINE_FRICTION: Final = 0.1
_KN_N_PER_M: Final = 1.0e9  # normal and tangential penalty in OpenSees
_LINE_PULSE: Final = solvers.BaseAcceleration(amplitude_mps2=(4.905, 14.715), period_s=0.5)
# Unit vectors along the lines, which are inclined by 30 degrees, and normal to them (upwards).
TANGENT: Final = np.array([cos(radians(30.0)), sin(radians(30.0))])
NORMAL: Final = np.array([-TANGENT[1], TANGENT[0]])


def run_particle(dt_s: float, duration_s: float) -> History:
    """Run the particle in OpenSees with the trapezoidal rule; contacts: lower and upper line."""
    times = live.even_times(duration_s, dt_s)
    dashpot = 2.0 * kelvin_voigt_damping_ratio(0.6) * (_KN_N_PER_M * _MASS_KG) ** 0.5
    drive = kelvin_voigt_drive(kn_n_per_m=_KN_N_PER_M, dashpot_n_s_per_m=dashpot)
    contacts, particle, ground = ContactSet(), solvers.CENTRE, 2
    with live.clean_domain(2, 2):
        for node in (particle, ground):
            ops.node(node, 0.0, 0.0)
        ops.fix(ground, 1, 1)
        ops.mass(particle, _MASS_KG, _MASS_KG)
        ops.uniaxialMaterial("Elastic", 1, _STIFFNESS_N_PER_M, _DASHPOT_N_S_PER_M)
        ops.element("zeroLength", 1, ground, particle, "-mat", 1, 1, "-dir", 1, 2)
        for normal in (NORMAL, -NORMAL):
            contact = ground, particle, normal.tolist(), _HALF_GAP_M, _LINE_FRICTION
            contacts.add(*contact, kn=_KN_N_PER_M, kt=_KN_N_PER_M, drive=drive)
        solvers.shake(times, dt_s, _LINE_PULSE)
        live.prepare_analysis(constraints="Plain")
        # The unit of the lower line measures slip along minus the tangent.
        return live.record(contacts, times, dt_s, [particle], [-1.0, 1.0])


def run_particle_lcp(restitution: float, h_s: float, duration_s: float) -> History:
    """Run the particle with rigid contacts by Moreau-Jean time stepping."""
    rows = np.array([NORMAL, -NORMAL]), np.full(2, _HALF_GAP_M), np.array([TANGENT, TANGENT])
    contacts = RigidContacts(*rows, (0, 1), _LINE_FRICTION, cohesion_n=0.0, restitution=restitution)
    times = live.even_times(duration_s, h_s)
    loads = -_MASS_KG * _LINE_PULSE.mean(times[:-1], times[1:]).T
    identity = np.eye(2)
    matrices = _MASS_KG * identity, _DASHPOT_N_S_PER_M * identity, _STIFFNESS_N_PER_M * identity
    return moreau_jean(matrices, contacts, loads, h_s)


def run_between_lines(study: Study) -> None:
    """Run the study of figure 4: a particle between two inclined lines."""
    rigid = {e: run_particle_lcp(e, 2.0e-5, 3.0) for e in (0.0, 0.6, 1.0)}
    for restitution, history in rigid.items():
        name = f"LCP, restitution {restitution:g}:"
        for quantity, value in peaks_m(history.q).items():
            # Without loss at impact, time stepping converges slowly: these peaks have no tolerance.
            study.tabulated(f"{name} peak {quantity} (m)", value)
        total = float(history.normals_n.sum() * history.t_s[1])
        if restitution < 1.0:
            study.tabulated(f"{name} normal impulse (N s)", total)
        if restitution == 0.6:
            ratio = np.abs(history.tangentials_n).sum() / history.normals_n.sum()
            study.tabulated(f"{name} friction over normal impulse", ratio)
    # Time step x circular frequency of the mass on the penalty = 0.05.
    dt = 0.05 * (_MASS_KG / _KN_N_PER_M) ** 0.5
    history = run_particle(dt, 3.0)
    compare_with_lcp(study, history, rigid[0.6])
    _draw_particle(study, history, rigid[0.6])


def peaks_m(positions_m: Floats) -> dict[str, float]:
    """Return the largest |ux|, |uy| and |ut| (ut: along the lines) in m of positions (n, 2)."""
    peaks = np.abs(np.column_stack([positions_m, positions_m @ TANGENT])).max(axis=0)
    return dict(zip(("ux", "uy", "ut"), peaks.tolist(), strict=True))


def compare_with_lcp(study: Study, history: History, rigid: History) -> None:
    """Compare the particle in OpenSees (penalty) with rigid contact of restitution 0.6."""
    case, history = "OpenSees, Kn 1e9", history.at(slice(None, None, 10))
    t_s, q = history.t_s, history.q
    for quantity, value in peaks_m(q).items():
        study.tabulated(f"{case}: peak {quantity} (m)", value)
    normal, exact = q @ NORMAL, rigid.q @ NORMAL
    error = rms(normal - np.interp(t_s, rigid.t_s, exact)) / _HALF_GAP_M
    source = "our Moreau-Jean solver at the step of the study"
    study.at_most(f"{case}: RMS difference of un from LCP / gap", error, _CLOSE, source)
    depth = max(ledger.max_penetration_m for ledger in history.ledgers) / _HALF_GAP_M
    study.at_most(f"{case}: penetration / gap", depth, _CLOSE, "penalty")
    study.states("node to line", f"{case} N/m", error)
    study.states("penalties enforce", f"{case} N/m", depth)
    for name, motion in {f"{case} N/m": normal, "rigid, restitution 0.6": exact}.items():
        study.states("bounded by the lines", name, float(np.abs(motion).max()) / _HALF_GAP_M - 1.0)
    first_s = float(t_s[np.flatnonzero(np.abs(normal) > _HALF_GAP_M)[0]])
    study.tabulated("OpenSees: first contact (s)", first_s)
    excess = cone_excess(history.tangentials_n, history.normals_n, _LINE_FRICTION)
    text = "OpenSees: excess of friction over the cone / largest limit"
    study.at_most(text, excess, 0.1, "compression predicted over one step at impact")


def _draw_particle(study: Study, history: History, rigid: History) -> None:
    name, lcp = "OpenSees", "LCP, e = 0.6"
    t, positions, exact = history.t_s[::10], history.q[::10] / MM, rigid.q / MM
    line_ends, offset = 200.0 * np.outer((-1.0, 1.0), TANGENT), _HALF_GAP_M / MM * NORMAL
    forces = {"N": history.normals_n[::10], "F": history.tangentials_n[::10]}
    path = {"line": (line_ends + offset).T, "_": (line_ends - offset).T, name: positions.T}
    panels = [Panel("ux (mm)", "uy (mm)", path, "path of the particle")]
    for text, direction in (("normal, un (mm)", NORMAL), ("along the lines, ut (mm)", TANGENT)):
        lines = {lcp: (rigid.t_s, exact @ direction), name: (t, positions @ direction)}
        panels.append(Panel("time (s)", text, lines))
    totals = {name: (t, force.sum(axis=1) / KN) for name, force in forces.items()}
    panels.append(Panel("time (s)", "force (kN)", totals, "contact forces of both lines"))
    study.figures["particle"] = drawn(panels, columns=2, height_in=4.8)


_ODE: Final = "our Runge-Kutta integration of the penalty equation"
_FRICTIONLESS: Final = ("C1", "C3")  # have tabulated elastic peaks; run with four restitutions
_AXES: Final = ("ux", "uy", "rotation x length")
_NAMES: Final = ("right acute", "right obtuse", "left obtuse", "left acute")  # order of `CORNERS`


def run(study: Study) -> None:
    """Run the study of figures 5 and 6: a rigid skew deck under a pulse."""
    elastic = {name: run_deck(deck_case(name)) for name in cases.CASES}
    rigid = {
        (name, e): run_deck(deck_case(name, solver="lcp", restitution=e))
        for name in cases.CASES
        for e in ((0.6, 0.45, 0.71, 1.0) if name in _FRICTIONLESS else (0.6,))
    }
    at_06 = {name: rigid[name, 0.6] for name in cases.CASES}
    # kn* = 1e4: impacts rotate the deck of C3 in both methods.
    stiff = {"normal_stiffness_n_per_m": 7.9e8, "dt_s": 2.5e-5, "duration_s": 1.5}
    damped = {name: run_deck(deck_case(name, restitution=0.6, **stiff)) for name in cases.CASES}
    _check_elastic(study, elastic)
    _check_rigid(study, rigid, damped)
    study.tables["locked_rotation"] = locked = locked_rotation()
    errors, text = locked["rms_ratio"].tolist(), "locked rotation: penalty converges to the LCP"
    study.holds(text, truth=bool(np.all(np.diff(errors) < 0.0)), source="monotone in kn*")
    text = "locked rotation, kn* = 1e5: RMS difference of un / scale"
    study.at_most(text, errors[-1], 0.01, "LCP, e 0.6")
    study.tabulated("locked rotation: first contact (s)", locked["first_contact_s"].iloc[-1])
    study.states("penalty converges", "C1, rotation locked", errors)
    _judge_agreement(study, elastic["C1"], at_06["C1"])
    for case, exact in at_06.items():
        peaks = [_scaled_peaks(runs[case]) for runs in (elastic, damped)]
        difference, error = (float(np.abs(scaled - _scaled_peaks(exact)).max()) for scaled in peaks)
        study.states("penalty is the cause", case, error)
        study.states("damper helps", case, error, difference)
    frequency = deck_case("C1").contact_frequency_rad_per_s
    by_step = {
        step: impacts(run_deck(deck_case("C1", integrator="houbolt", dt_s=step / frequency)))
        for step in (0.05, 0.71, 1.5, 3.0)
    }
    medians = {step: float(table["restitution"].median()) for step, table in by_step.items()}
    study.states("restitution found", "C1, Houbolt, some step of the table", medians)
    for step, table in by_step.items():
        columns = table["approach_mps"].tolist(), (-table["restitution"]).tolist()
        study.states("restitution falls", f"C1, Houbolt, step {step:g}", *columns)
    # pairs of cases that differ in one parameter only
    for name, a, b in (("width", "C1", "C3"), ("skew", "C4", "C5"), ("friction", "C3", "C4")):
        change = abs(float(_scaled_peaks(at_06[b])[2] - _scaled_peaks(at_06[a])[2]))
        study.states("depends on plan and friction", f"{name} ({a} and {b})", change)
    _draw_c1(study, at_06["C1"], elastic["C1"])


def _scaled(history: History) -> Floats:
    """Return (ux, uy, rotation x length) / displacement scale, shape (n, 3)."""
    return history.q * np.array([1.0, 1.0, cases.LENGTH_M]) / SCALE_M


def _scaled_peaks(history: History) -> Floats:
    return np.abs(_scaled(history)).max(axis=0)


def _check_elastic(study: Study, elastic: dict[str, History]) -> None:
    """Check the elastic penalty by Runge-Kutta, the exact linear response and a deck of beams."""
    tolerances = {"ux_m": 0.01, "uy_m": 0.01, "theta_rad": 0.02}
    for name, history in elastic.items():
        peaks = history.peaks()
        exact = {} if name in _FRICTIONLESS else run_deck(deck_case(name, solver="penalty")).peaks()
        for key, tolerance in tolerances.items():
            text = f"{name} elastic, OpenSees: peak {key}"
            if exact:
                study.relative(text, peaks[key], exact[key], tolerance, _ODE)
            else:
                study.tabulated(text, peaks[key])
    skew = radians(deck_case("C1").skew_deg)
    along = elastic["C1"].q[:, :2] @ np.array([sin(skew), cos(skew)])
    text = "C1: peak along the end, where no contact force acts (m)"
    peak, exact_m = float(np.abs(along).max()), sin(skew) * 2.501777 * SCALE_M
    study.relative(text, peak, exact_m, 1e-3, "exact linear response")
    for name in _FRICTIONLESS:
        case = deck_case(name)
        beams = solvers.run_opensees(case, solvers.pulse_of(case), connect=perimeter_beams).peaks()
        for key, peak in elastic[name].peaks().items():
            text = f"{name} perimeter of beams: peak {key}"
            study.relative(text, beams[key], peak, 2e-3, "rigid links")


def _check_rigid(
    study: Study, rigid: dict[tuple[str, float], History], damped: dict[str, History]
) -> None:
    """Compare the rigid deck with tabulated values, and the damped penalty with the rigid deck."""
    tolerances = {"ux": 0.10, "uy": 0.10, "theta x length": 0.15}
    for (name, e), history in rigid.items():
        for quantity, value in zip(tolerances, _scaled_peaks(history), strict=True):
            study.tabulated(f"{name} LCP, restitution {e:g}: peak {quantity} over scale", value)
    # penalty and rigid contact differ by their assumptions; neither is wrong
    for name, history in damped.items():
        peaks = zip(_scaled_peaks(history), _scaled_peaks(rigid[name, 0.6]), strict=True)
        for (quantity, limit), (value, reference) in zip(tolerances.items(), peaks, strict=True):
            text = f"{name} damped penalty, kn* = 1e4: peak {quantity} over scale"
            if name in ("C3", "C5"):
                study.relative(text, value, reference, limit, "LCP; the methods differ")
            else:
                study.report(text, value, reference, "LCP, where flat impacts leave theta = 0")


def _judge_agreement(study: Study, elastic: History, rigid: History) -> None:
    """Judge figure 5 for each axis, and whether differences grow with the number of impacts."""
    motion, exact = _scaled(elastic), _scaled(rigid)
    at_times = [np.interp(elastic.t_s, rigid.t_s, column) for column in exact.T]
    difference = motion - np.array(at_times).T
    for axis, error, peak in zip(_AXES, difference.T, _scaled_peaks(rigid), strict=True):
        scale = 1.0 if isclose(peak, 0.0, abs_tol=1e-9) else peak
        study.states("deck agrees", f"C1, elastic penalty, {axis}", rms(error) / float(scale))
    is_late = elastic.t_s > float(np.median(impacts(elastic)["t_s"]))
    before, after = (rms(difference[k, :2]) / rms(motion[k, :2]) for k in (~is_late, is_late))
    study.states("differences grow", "C1, elastic penalty", after, before)


def _draw_c1(study: Study, rigid: History, elastic: History) -> None:
    runs = {"LCP, e = 0.6": rigid, "OpenSees, elastic penalty": elastic}
    with_linear = {**runs, "Newmark, no impact": run_deck(deck_case("C1", gap_normal_m=1.0))}
    panels = [
        Panel("time (s)", text, {n: (h.t_s, 1e3 * h.q[:, row]) for n, h in with_linear.items()})
        for row, text in enumerate(("ux (mm)", "uy (mm)", "theta (mrad)"))
    ]
    title = "case C1: W/L = 1/2, skew 30 deg, no friction"
    study.figures["displacements"] = drawn(panels, height_in=5.6, title=title)
    rows = solvers.make_deck(deck_case("C1")).tangent_rows
    slips = {name: (h.t_s, 1e3 * h.q @ rows.T) for name, h in runs.items()}
    openings = {name: (h.t_s, 1e3 * h.openings_m) for name, h in runs.items()}
    panels = [
        Panel("time (s)", text, {n: (t, scaled[:, k]) for n, (t, scaled) in lines.items()}, corner)
        for text, lines in (("tangential (mm)", slips), ("opening (mm)", openings))
        for k, corner in enumerate(_NAMES[:2])
    ]
    study.figures["corners"] = drawn(panels, columns=2, height_in=4.4)


def perimeter_beams(case: cases.DeckCase) -> None:
    """Connect the mass centre to the corners by a perimeter of stiff beams and four spokes."""
    # ASSUME the mass of the paper's perimeter deck is at its centre, on equally stiff members.
    half_m = 0.5 * case.length_m
    axial = 1.0e4 * case.normal_stiffness_n_per_m * half_m  # a higher stiffness changes nothing
    bending = axial * half_m * half_m / 3.0
    ops.geomTransf("Linear", 1)
    right_acute, right_obtuse, left_obtuse, left_acute = solvers.CORNER_NODES
    members = [
        *pairwise((right_acute, right_obtuse, left_acute, left_obtuse, right_acute)),
        *((solvers.CENTRE, corner) for corner in solvers.CORNER_NODES),
    ]
    for element, (i, j) in enumerate(members, start=max(ops.getEleTags()) + 1):
        ops.element("elasticBeamColumn", element, i, j, 1.0, axial, bending, 1)


def impacts(history: History) -> pd.DataFrame:
    """Return one row per impact of a corner: time, approach speed and restitution.

    Speeds are taken in free flight, in the steps before closing and after opening.
    """
    tables: list[pd.DataFrame] = []
    for opening in history.openings_m.T:
        changes = np.diff((opening < 0.0).astype(int))
        closings, openings = (np.flatnonzero(changes == sign) + 1 for sign in (1, -1))
        # every contact is open at first, so ends follow starts; the last contact may not end
        closings = closings[: len(openings)]
        is_free = (closings >= 2) & (openings + 1 < len(opening))
        closings, openings = closings[is_free], openings[is_free]
        speeds = np.diff(opening) / float(history.t_s[1] - history.t_s[0])
        approach, rebound = -speeds[closings - 2], speeds[openings]
        columns = {"t_s": history.t_s[closings], "approach_mps": approach}
        tables.append(pd.DataFrame(columns | {"restitution": rebound / approach}))
    table = pd.concat(tables, ignore_index=True)
    return table[table["approach_mps"] > 0.0]


def locked_rotation(relative_stiffnesses: tuple[float, ...] = (1e3, 1e4, 1e5)) -> pd.DataFrame:
    """Return the difference of damped penalty and rigid contact for a deck without rotation.

    Both corners of an end act as one, so the penalty must converge to the rigid solution. Columns:
    relative_stiffness kn* = 2 Kn / (m w_p^2), rms_ratio, first_contact_s.
    """
    rigid = run_deck(deck_case("C1", solver="lcp", restitution=0.6, dt_s=1e-4))
    normal = solvers.make_deck(deck_case("C1")).normal_rows[0, :2]
    rows: list[tuple[float, ...]] = []
    pulse_speed = 4.0 * pi
    for ratio in relative_stiffnesses:
        stiffness = ratio * 1000.0 * pulse_speed**2 / 2.0
        case = {"normal_stiffness_n_per_m": stiffness, "dt_s": 0.1 / (pulse_speed * ratio**0.5)}
        # the rotational spring is much stiffer than the corner springs at their lever arms
        history = run_deck(deck_case("C1", restitution=0.6, period_theta_s=1.0e-5, **case))
        penalty_un = np.interp(rigid.t_s, history.t_s, history.q[:, :2] @ normal)
        error = rms((penalty_un - rigid.q[:, :2] @ normal) / SCALE_M)
        rows.append((ratio, error, history.first_contact_s() or np.nan))
    return pd.DataFrame(rows, columns=["relative_stiffness", "rms_ratio", "first_contact_s"])


GAPS_MM: Final = (3.18, 6.35)  # source: the paper, runs 123 and 213
FRICTION: Final = 0.4  # source: the paper
_DURATION_S: Final = 20.0
_PREDICTABLE_S: Final = 2.5


def wu_case(gap_mm: float, **changes: Any) -> cases.DeckCase:
    """Return the deck of the tests, with the gap measured normal to the end of the deck."""
    # ASSUME mass, period and damping of the bearings (not public); no scaling of time.
    fields: dict[str, Any] = {
        "mass_kg": 5000.0,
        "damping_ratio": 0.07,
        "gap_normal_m": gap_mm * MM,
        "friction": FRICTION,
        "normal_stiffness_n_per_m": 2.0e7,  # source: the paper
        "dt_s": 2.5e-4,
        "duration_s": _DURATION_S,
        "motion": ("recorded", "recorded"),
    }
    # source: plan from the paper
    plan = cases.bearing_fields(length_m=5.03, width_m=1.07, skew_deg=60.0, period_s=0.45)
    return cases.DeckCase.model_validate(plan | fields | changes)


def run_tests(study: Study) -> None:
    """Run the study of figures 7 and 8: a skew deck on a shake table."""
    for gap_mm, motion in product(GAPS_MM, paper_record("El Centro").runs()):
        ground, name = solvers.BaseAcceleration(record=motion.motion), f"gap {gap_mm:g} mm"
        history = run_deck(wu_case(gap_mm), ground)
        peaks = history.peaks()
        # ASSUME the premise of both statements: an obtuse corner hits its wall
        obtuse_hits = float(history.normals_n[:, 1:3].max()) > 0.0
        states = partial(study.states, run=motion.run, premise=obtuse_hits)
        states("skew deck rotates", name, 1e3 * peaks["theta_rad"])
        # largest openings beyond the gap
        away_mm = (history.openings_m.max(axis=0) - history.openings_m[0, 0]) / MM
        for end, corners in (("right", (0, 1)), ("left", (3, 2))):
            states("acute corner moves away", f"{name}, {end} acute", *away_mm[[*corners]].tolist())
        if not motion.is_nominal:
            continue
        penalty = run_deck(wu_case(gap_mm, solver="penalty"), ground)
        if gap_mm == GAPS_MM[1]:
            exact = penalty.peaks()
            for key in ("ux_m", "uy_m", "theta_rad"):
                text = f"{name}: peak {key} over {_DURATION_S:g} s"
                study.relative(text, peaks[key], exact[key], 0.02, _ODE)
        else:  # the motion is chaotic after some seconds: only the start is compared
            is_early = history.t_s <= _PREDICTABLE_S
            error = float(np.abs((history.q - penalty.q)[is_early, :2]).max())
            text = f"{name}: difference in the first {_PREDICTABLE_S:g} s (m)"
            study.at_most(text, error, 0.05 * MM, _ODE)
            _draw_tests(study, history, f"{motion.label}, {name}")
        text = f"{name}: excess of friction over the cone / largest limit"
        excess = cone_excess(history.tangentials_n, history.normals_n, FRICTION)
        study.at_most(text, excess, 0.1, "cone; compression predicted over one step")
    # A contact lasts half a period of the mass on its penalty; each corner has an equal mass share.
    decks = wu_case(GAPS_MM[0]), deck_case("C1")
    times_s = [(deck.mass_kg / deck.normal_stiffness_n_per_m) ** 0.5 for deck in decks]
    study.states("longer contact", "closed form", times_s[0] / times_s[1], 1.0)


def _draw_tests(study: Study, history: History, title: str) -> None:
    early = history.t_s <= 8.0
    slips = history.q @ solvers.make_deck(wu_case(GAPS_MM[0])).tangent_rows.T
    components = {"tangential": slips / MM, "opening": history.openings_m / MM}
    normals, frictions = history.normals_n / KN, history.tangentials_n / KN
    forces = {"compression (kN)": normals, "friction (kN)": frictions}
    t_s = history.t_s[early]
    panels = [
        Panel("time (s)", f"{corner} (mm)", {n: (t_s, m[early, k]) for n, m in components.items()})
        for k, corner in enumerate(_NAMES)
    ]
    study.figures["deformations"] = drawn(panels, height_in=6.4, title=title)
    panels = [
        Panel("time (s)", text, {n: (t_s, f[early, k]) for k, n in enumerate(_NAMES)})
        for text, f in forces.items()
    ]
    study.figures["forces"] = drawn(panels, height_in=4.4, title=title)
