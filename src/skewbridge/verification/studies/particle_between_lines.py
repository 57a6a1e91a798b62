"""Figure 4 of the paper: a particle bounded by two inclined lines under a base pulse.

The particle on an isotropic support runs in OpenSees with contact units and as a rigid particle by
Moreau-Jean time stepping.
"""

from math import cos, pi, radians, sin
from typing import Final, NamedTuple

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact import ContactSet, UnitLedger
from skewbridge.contact.drives import kelvin_voigt_damping_ratio, kelvin_voigt_drive
from skewbridge.units import KN, MM
from skewbridge.verification.references import live_model as live
from skewbridge.verification.references.deck_solvers import BaseAcceleration
from skewbridge.verification.references.lcp import LcpHistory, RigidContacts, moreau_jean
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.registry import Panel, Study, drawn

_GROUND: Final = 1
_PARTICLE: Final = 2
_DURATION_S: Final = 3.0
_LCP_STEP_S: Final = 2.0e-5
_CLOSE: Final = 0.03  # of the gap: the penetration that Kn = 1e9 N/m permits

# ASSUME mass, support and restitution: the paper gives gap, slope, pulse, friction, damping.
_MASS_KG: Final = 1000.0
_STIFFNESS_N_PER_M: Final = _MASS_KG * (2.0 * pi / 1.0) ** 2  # a period of 1 s
_DASHPOT_N_S_PER_M: Final = 2.0 * 0.05 * _MASS_KG * 2.0 * pi / 1.0  # 5 % of critical
_HALF_GAP_M: Final = 0.0268  # distance of each line from the origin
_FRICTION: Final = 0.1
_KN_N_PER_M: Final = 1.0e9  # normal and tangential penalty in OpenSees
_PULSE: Final = BaseAcceleration(amplitude_mps2=(4.905, 14.715), period_s=0.5)
# Along the lines, inclined by 30 degrees, and normal to them, upwards.
TANGENT: Final = np.array([cos(radians(30.0)), sin(radians(30.0))])
NORMAL: Final = np.array([-TANGENT[1], TANGENT[0]])


class ParticleHistory(NamedTuple):
    """Response of the particle along x and y, shape (n, 2); columns of forces: lower, upper line.

    Friction acts along the lines, with the sign of slip.
    """

    t_s: Array
    position_m: Array
    friction_n: Array
    normal_n: Array
    ledgers: list[UnitLedger]


def run_particle(dt_s: float, duration_s: float) -> ParticleHistory:
    """Run the particle in OpenSees by the trapezoidal rule; keep every tenth step."""
    times = live.even_times(duration_s, dt_s)
    dashpot = 2.0 * kelvin_voigt_damping_ratio(0.6) * (_KN_N_PER_M * _MASS_KG) ** 0.5
    drive = kelvin_voigt_drive(kn_n_per_m=_KN_N_PER_M, dashpot_n_s_per_m=dashpot)
    contacts = ContactSet()
    with live.clean_domain():
        ops.model("basic", "-ndm", 2, "-ndf", 2)
        ops.node(_GROUND, 0.0, 0.0)
        ops.node(_PARTICLE, 0.0, 0.0)
        ops.fix(_GROUND, 1, 1)
        ops.mass(_PARTICLE, _MASS_KG, _MASS_KG)
        ops.uniaxialMaterial("Elastic", 1, _STIFFNESS_N_PER_M, _DASHPOT_N_S_PER_M)
        ops.element("zeroLength", 1, _GROUND, _PARTICLE, "-mat", 1, 1, "-dir", 1, 2)
        for normal, name in ((NORMAL, "lower line"), (-NORMAL, "upper line")):
            place = _GROUND, _PARTICLE, normal.tolist(), _HALF_GAP_M, _FRICTION
            contacts.add(*place, kn=_KN_N_PER_M, kt=_KN_N_PER_M, drive=drive, name=name)
        accel = _PULSE.mean(times - 0.5 * dt_s, times + 0.5 * dt_s)
        accel[:, 0] = _PULSE.amplitude_mps2
        live.shake_base(_PARTICLE, dt_s, accel)
        live.Solver(constraints="Plain").prepare()
        rows: list[list[float]] = [[0.0] * 7]
        for k in live.march(contacts, times, dt_s):
            if k % 10 == 0:
                (lower, _), (upper, _) = contacts.tangentials_n
                # The unit of the lower line counts slip along minus the tangent.
                forces = [-lower, upper, *contacts.normals_n]
                rows.append([float(times[k]), *ops.nodeDisp(_PARTICLE), *forces])
        ledgers = contacts.ledger()
    t_s, position, friction, normal = np.split(np.array(rows), (1, 3, 5), axis=1)
    return ParticleHistory(t_s[:, 0], position, friction, normal, ledgers)


def run_particle_lcp(restitution: float, h_s: float, duration_s: float) -> LcpHistory:
    """Run the particle with rigid contacts by Moreau-Jean time stepping."""
    rows = np.array([NORMAL, -NORMAL]), np.full(2, _HALF_GAP_M), np.array([TANGENT, TANGENT])
    contacts = RigidContacts(
        *rows, groups=(0, 1), friction=_FRICTION, cohesion_n=0.0, restitution=restitution
    )
    times = live.even_times(duration_s, h_s)
    loads = -_MASS_KG * _PULSE.mean(times[:-1], times[1:]).T
    mass, damping, stiffness = (
        value * np.eye(2) for value in (_MASS_KG, _DASHPOT_N_S_PER_M, _STIFFNESS_N_PER_M)
    )
    return moreau_jean((mass, damping, stiffness), contacts, loads, h_s)


def run(study: Study) -> None:
    """Run the study."""
    rigid = {e: run_particle_lcp(e, _LCP_STEP_S, _DURATION_S) for e in (0.0, 0.6, 1.0)}
    for restitution, history in rigid.items():
        name = f"LCP, restitution {restitution:g}:"
        for quantity, value in peaks_m(history.q).items():
            # Time stepping converges slowly without loss at impact: shown, not judged.
            study.tabulated(f"{name} peak {quantity} (m)", value)
        total = float(history.normal_impulses_ns.sum())
        if restitution < 1.0:
            study.tabulated(f"{name} normal impulse (N s)", total)
        if restitution == 0.6:
            ratio = float(np.abs(history.tangent_impulses_ns).sum()) / total
            study.tabulated(f"{name} friction over normal impulse", ratio)
    # Step times the frequency of the mass on the penalty: 0.05.
    dt = 0.05 * (_MASS_KG / _KN_N_PER_M) ** 0.5
    history = run_particle(dt, _DURATION_S)
    compare_with_lcp(study, history, rigid[0.6])
    _draw(study, history, rigid[0.6])


def peaks_m(positions_m: Array) -> dict[str, float]:
    """Return the largest ux, uy and displacement along the lines, ut, of positions (n, 2)."""
    peaks = np.abs(np.column_stack([positions_m, positions_m @ TANGENT])).max(axis=0)
    return dict(zip(("ux", "uy", "ut"), peaks.tolist(), strict=True))


def compare_with_lcp(study: Study, history: ParticleHistory, rigid: LcpHistory) -> None:
    """Compare the penalty particle of OpenSees with the rigid one of restitution 0.6."""
    case = "OpenSees, Kn 1e9"
    for quantity, value in peaks_m(history.position_m).items():
        study.tabulated(f"{case}: peak {quantity} (m)", value)
    normal, exact = history.position_m @ NORMAL, rigid.q @ NORMAL
    error = live.rms(normal - np.interp(history.t_s, rigid.t_s, exact)) / _HALF_GAP_M
    source = "own Moreau-Jean solver at the step of the study"
    study.at_most(f"{case}: RMS of un against LCP over gap", error, _CLOSE, source)
    depth = max(ledger.max_penetration_m for ledger in history.ledgers) / _HALF_GAP_M
    study.at_most(f"{case}: penetration over gap", depth, _CLOSE, "penalty")
    study.states("node to line", f"{case} N/m", error)
    study.states("penalties enforce", f"{case} N/m", depth)
    for name, motion in {f"{case} N/m": normal, "rigid, restitution 0.6": exact}.items():
        study.states("bounded by the lines", name, float(np.abs(motion).max()) / _HALF_GAP_M - 1.0)
    first_s = float(history.t_s[np.flatnonzero(np.abs(normal) > _HALF_GAP_M)[0]])
    study.tabulated("OpenSees: first contact (s)", first_s)
    excess = live.cone_excess(history.friction_n, history.normal_n, _FRICTION)
    text = "OpenSees: friction beyond the cone over its largest"
    study.at_most(text, excess, 0.1, "one step of the predicted compression at impact")


def _draw(study: Study, history: ParticleHistory, rigid: LcpHistory) -> None:
    """Draw the path between the lines, both displacements and the contact forces over time."""
    name, of_lcp = "OpenSees", "LCP, e = 0.6"
    t, moved, exact = history.t_s, history.position_m / MM, rigid.q / MM
    ends, offset = 200.0 * np.outer((-1.0, 1.0), TANGENT), _HALF_GAP_M / MM * NORMAL
    forces = {"N": history.normal_n, "F": history.friction_n}
    path = {"line": (ends + offset).T, "_": (ends - offset).T, name: moved.T}
    panels = [Panel("ux (mm)", "uy (mm)", path, "path of the particle")]
    for text, way in (("normal, un (mm)", NORMAL), ("along the lines, ut (mm)", TANGENT)):
        lines = {of_lcp: (rigid.t_s, exact @ way), name: (t, moved @ way)}
        panels.append(Panel("time (s)", text, lines))
    totals = {name: (t, force.sum(axis=1) / KN) for name, force in forces.items()}
    panels.append(Panel("time (s)", "force (kN)", totals, "contact forces of both lines"))
    study.figures["particle"] = drawn(panels, columns=2, height_in=4.8)
