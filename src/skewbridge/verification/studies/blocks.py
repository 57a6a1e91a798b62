"""Studies of a single contact: units on paths, and blocks with contact units in OpenSees.

Plane models of a sliding or bouncing mass and of a rocking block: x is along the surface, y normal
to it. The closed forms (B1 to B9 in docs/theory/verification.md) hold for Coulomb friction and
rigid contact; the penalty adds an elastic slip of about friction x normal force / Kt.

`run_gate` runs the contact checks, which take a second and precede the analyses of every study.
`run` compares units, also behind a gap, with radial return (figure 1 of the paper), and blocks that
slide, tip or rock with closed forms. `run_closed_forms` has oscillators with friction, impacts and
a mass on a belt. In `run_integrators` a mass hits an elastic contact at forty instants within a
step: any loss or gain of energy is an artefact of the integrator. `run_spatial` drives the unit by
a square and two triangular waves (figure 3); `run_orders` compares both couplings on smooth paths
and on a frictional deck, over a range of time steps.

References:
    B1, B2: Den Hartog (1956), Mechanical Vibrations, section 8.2, and (1931), Transactions ASME 53;
    Shaw (1986), Journal of Sound and Vibration 108. B3: Newmark (1965), Geotechnique 15. B5:
    Goldsmith (1960), Impact, chapter 4; Johnson (1985), Contact Mechanics, section 11.4. B8: Popp
    and Stelter (1990), Philosophical Transactions A 332. B9: Housner (1963), BSSA 53.
"""

from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import asin, atan, ceil, cos, degrees, hypot, pi, sin, sqrt
from typing import Any, Final, Literal

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.contact import ContactLaw, ContactSet, Coupling, Drive, Scheme, drives
from skewbridge.contact.law import advance_pair
from skewbridge.errors import SolutionError
from skewbridge.files.tables import Floats, Row
from skewbridge.units import KN, MM
from skewbridge.verification.references import deck_solvers as solvers
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references import live_model as live
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.driven_unit import PAPER_LAW, drive_unit
from skewbridge.verification.references.live_model import History, first_crossing_s, rms
from skewbridge.verification.registry import Panel, Study, drawn

_SETTLING_S: Final = 1e-6
TABLE_G_MPS2: Final = 9.81  # source: gravity used to compute the tabulated references
MASS_KG: Final = 1000.0
_PAPER_LIMIT_N: Final = 4500.0  # friction of `PAPER_LAW` at a penetration of 0.1 m


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A mass with one contact, a constant load onto the surface and a spring along x to an anchor.

    The spring is unstressed at x = 0. If `bounces` is false, the mass rests on the surface.
    """

    mass_kg: float = MASS_KG
    kn_n_per_m: float = 1e9
    kt_n_per_m: float = 1e10
    friction: float = 0.0
    normal_load_n: float = 0.0
    spring_n_per_m: float = 0.0
    gap_m: float = 0.0
    x0_m: float = 0.0
    v0_mps: tuple[float, float] = (0.0, 0.0)
    bounces: bool = False
    drive: Drive | None = None


def run_block(
    block: Block,
    dt_s: float,
    duration_s: float,
    *,
    force_n: live.TimeFunction = np.zeros_like,
    base_mps2: live.TimeFunction | None = None,
    anchor_m: live.TimeFunction = np.zeros_like,
    integrator: tuple[str | float, ...] = ("Newmark", 0.5, 0.25),
) -> History:
    """Run a block under a force along x, a base acceleration or a motion of the spring anchor."""
    times, contacts = live.even_times(duration_s, dt_s), ContactSet()
    ground, mass, anchor = 1, 2, 3
    with live.clean_domain(2, 2):
        for node in (ground, mass, anchor):
            ops.node(node, 0.0, 0.0)
        ops.fix(ground, 1, 1)
        ops.fix(anchor, 0, 1)
        ops.mass(mass, block.mass_kg, block.mass_kg if block.bounces else 0.0)
        ops.uniaxialMaterial("Elastic", 1, block.spring_n_per_m)
        ops.element("zeroLength", 1, anchor, mass, "-mat", 1, "-dir", 1)
        contact = ground, mass, (0.0, 1.0), block.gap_m, block.friction
        contacts.add(*contact, kn=block.kn_n_per_m, kt=block.kt_n_per_m, drive=block.drive)
        ops.setNodeDisp(mass, 1, block.x0_m, "-commit")
        for dof, speed in enumerate(block.v0_mps, start=1):
            ops.setNodeVel(mass, dof, speed, "-commit")
        force = force_n(times)
        if base_mps2 is not None:
            force = force - block.mass_kg * base_mps2(times)
        live.load_node(mass, block.normal_load_n, dt_s, force)
        live.path_series(3, dt_s, anchor_m(times))
        ops.pattern("Plain", 3, 3)
        ops.sp(anchor, 1, 1.0)
        live.prepare_analysis(tolerance_m=1e-13, integrator=integrator)
        if not block.bounces:
            # Press the block onto the surface in a step too short for a motion along x.
            if ops.analyze(1, _SETTLING_S) != 0:
                raise SolutionError("no convergence while the block was pressed onto the surface")
            contacts.after_step(_SETTLING_S)
            contacts.start_from_rest()
            ops.setTime(0.0)
        return live.record(contacts, times, dt_s, [mass], [-1.0])


def sliding_block(friction: float) -> Block:
    """Return a block of 1000 kg that rests on a surface under its own weight."""
    return Block(friction=friction, normal_load_n=MASS_KG * TABLE_G_MPS2)


def run_upright(
    half_m: tuple[float, float],
    dt_s: float,
    duration_s: float,
    *,
    friction: float,
    angle_rad: float = 0.0,
    base_mps2: live.TimeFunction = np.zeros_like,
) -> History:
    """Run a block of 1000 kg that can slide, tip and rock on two corners, with large rotations.

    `half_m` is half of its width and height; it leans to the left if the angle is positive. Returns
    x, y and rotation of the centre, the left and the right corner.
    """
    times, contacts = live.even_times(duration_s, dt_s), ContactSet()
    b, h = half_m
    pivot = -b if angle_rad >= 0.0 else b
    centre, foot, left, right = 1, 2, 3, 4
    with live.clean_domain(2, 3):
        for node, x, y in ((centre, 0.0, h), (foot, 0.0, 0.0), (left, -b, 0.0), (right, b, 0.0)):
            turned_x = pivot + cos(angle_rad) * (x - pivot) - sin(angle_rad) * y
            ops.node(node, turned_x, sin(angle_rad) * (x - pivot) + cos(angle_rad) * y)
        ops.mass(centre, MASS_KG, MASS_KG, MASS_KG * hypot(b, h) ** 2 / 3.0)
        ops.geomTransf("Corotational", 1)
        for element, (i, j) in enumerate(((centre, foot), (foot, left), (foot, right)), start=1):
            # members much stiffer than the penalty
            ops.element("elasticBeamColumn", element, i, j, 1.0, 1.0e12, 1.0, 1)
        for floor, corner in ((5, left), (6, right)):
            x, y = ops.nodeCoord(corner)
            ops.node(floor, x, y)
            ops.fix(floor, 1, 1, 1)
            contact = floor, corner, (0.0, 1.0), max(0.0, y), friction
            contacts.add(*contact, kn=1.0e9, kt=1.0e9)
        push = -MASS_KG * base_mps2(times)
        live.load_node(centre, MASS_KG * TABLE_G_MPS2, dt_s, push, rotations=1)
        # Numerical damping removes oscillations of the penalty; rocking is far slower.
        solver = {"constraints": "Plain", "numberer": "RCM", "algorithm": "KrylovNewton"}
        live.prepare_analysis(**solver, tolerance_m=1e-11, integrator=("HHT", 0.8))
        return live.record(contacts, times, dt_s, [centre, left, right], [1.0, 1.0])


_SPRING_N_PER_M: Final = 4.0e4
_FRICTION_N: Final = 1962.0
# B1: each half cycle takes twice this from the amplitude.
_SLIP_M: Final = _FRICTION_N / _SPRING_N_PER_M


def run_gate(study: Study) -> None:
    """Run the short contact checks, which precede every study."""
    pressed, opened = (advance_pair(PAPER_LAW, (0.0, 0.0), (0.3, 0.4), z) for z in (-0.1, 1e-9))
    slip_n, ratio = hypot(*pressed.force_n), pressed.force_n[0] / pressed.force_n[1]
    study.relative("slip force (N)", slip_n, 1500.0 + 0.3 * 1e4, 1e-12, "cone")
    study.absolute("slip force, ratio of components", ratio, 0.75, 1e-12, "cone")
    study.absolute("friction while open (N)", opened.force_n[0], 0.0, 0.0, "cone")
    restitution = drives.kelvin_voigt_restitution(drives.kelvin_voigt_damping_ratio(0.6))
    study.absolute("restitution of the clipped damper", restitution, 0.6, 1e-9, "B4")
    _check_paths(study)
    decay = run_block(spring_block(kt_n_per_m=1e9, x0_m=0.5), 1e-3, 1.2)
    computed_m = decay.q[:, 0].min()
    study.relative("first turning point (m)", computed_m, 2.0 * _SLIP_M - 0.5, 5e-3, "B1")
    _check_rectangle(study, "slip under a rectangular pulse (m)", 0.2, (5e-4, 0.8), 1e-2)
    _check_fall(study, ("deepest penetration (m)",), 2e-4)
    history = solvers.run_deck(deck_case("C1", dt_s=2.5e-4, duration_s=1.5))
    for name, key in (("ux (m)", "ux_m"), ("uy (m)", "uy_m"), ("theta (rad)", "theta_rad")):
        study.tabulated(f"C1 peak {name}", history.peaks()[key])
    residual = abs(history.energy_residual_ratio)
    study.at_most("C1 energy residual over input", residual, 1e-6, "balance")


def _check_paths(study: Study) -> None:
    """Check the friction of a unit on a circle, a straight loop and a path that opens the unit."""
    radius, slip, limit_n = 0.2, 0.045, _PAPER_LIMIT_N  # slip: elastic
    path = unit.circle(radius, rows_per_loop=500)
    forces = drive_unit(PAPER_LAW, path, substeps=25).forces_n
    loop_2 = slice(len(path) // 2, None)
    velocity = np.gradient(path[loop_2, 1:3], axis=0)
    angle = np.arctan2(*forces[loop_2, 1::-1].T) - np.arctan2(*velocity[:, ::-1].T)
    lag_deg = degrees(float(np.median(np.angle(np.exp(-1j * angle)))))
    study.relative("lag on a circle (deg)", lag_deg, degrees(asin(slip / radius)), 5e-3, "B6")
    work = unit.path_work_j(path[loop_2], forces[loop_2])
    exact = limit_n * 2.0 * pi * sqrt(radius**2 - slip**2)
    study.relative("work per circle (J)", work, exact, 5e-3, "B6")
    t = np.linspace(0.0, 2.0, 801)  # two cycles along x
    loop = np.column_stack([t, 0.5 * unit.triangle(t, 1.0), 0.0 * t, np.full_like(t, -0.1)])
    forces, loop_2 = drive_unit(PAPER_LAW, loop, substeps=2).forces_n, slice(len(loop) // 2, None)
    work = unit.path_work_j(loop[loop_2], forces[loop_2])
    study.relative("work per straight loop (J)", work, 4.0 * limit_n * (0.5 - slip), 5e-3, "B7")
    path[:, 3] = np.where(np.sin(2 * pi * path[:, 0] / 2.5) > 0.0, 0.1, -0.1)
    computed_n = drive_unit(PAPER_LAW, path).forces_n
    exact_n = unit.follow_law(PAPER_LAW, path, substeps=20)
    error = rms(np.hypot(*(computed_n - exact_n)[:, :2].T)) / limit_n
    study.at_most("RMS error with openings, over the limit", error, 1e-2, "radial return")
    study.at_most("tension (N)", max(0.0, float(-computed_n[:, 2].min())), 0.0, "no tension")
    open_n = np.abs(computed_n[path[:, 3] > 0.0, :2]).max()
    study.at_most("friction while open (N)", open_n, 0.0, "no friction")


def _check_rectangle(
    study: Study, name: str, friction: float, times_s: tuple[float, float], tolerance: float
) -> None:
    """Check the slip of a block under a rectangular pulse; `times_s` is (step, duration)."""
    accel, limit = 0.5 * TABLE_G_MPS2, friction * TABLE_G_MPS2
    history = run_block(
        *(sliding_block(friction), *times_s),
        base_mps2=lambda t: accel * np.heaviside(np.round(0.2 - t, 9), 0.5),
    )
    exact_m = (accel * 0.2) ** 2 / (2.0 * limit) * (1.0 - limit / accel)
    study.relative(name, -history.q[-1, 0], exact_m, tolerance, "B3")


def falling_block(**changes: Any) -> Block:
    """Return a mass of 1000 kg under its weight that hits a contact of 10 MN/m at 1 m/s."""
    contact = {"kn_n_per_m": 1e7, "kt_n_per_m": 1e7, "bounces": True, "v0_mps": (0.0, -1.0)}
    return replace(sliding_block(0.0), **contact | changes)


def _check_fall(study: Study, names: tuple[str, ...], dt_s: float) -> None:
    """Check the penetration of a falling mass and, if ``names`` has two, the contact time."""
    fall = run_block(falling_block(), dt_s, 0.05)
    w, static_m = sqrt(1e7 / MASS_KG), MASS_KG * TABLE_G_MPS2 / 1e7
    exact = static_m + hypot(static_m, 1.0 / w), 2.0 / w * (pi - atan(w / TABLE_G_MPS2))
    computed = -fall.q[:, 1].min(), fall.ledgers[0].contact_time_s
    for name, value, reference, limit in zip(names, computed, exact, (5e-3, 0.01), strict=False):
        study.relative(name, value, reference, limit, "B5")


_LAW: Final = ContactLaw(kn_n_per_m=1.0e5, kt_n_per_m=1.0e5, friction=0.3)
_DEPTH_M: Final = 0.1
_STROKE_M: Final = 0.5
_LIMIT_N: Final = _LAW.friction * _LAW.kn_n_per_m * _DEPTH_M


def run(study: Study) -> None:
    """Run the study of figure 1: friction loops of a unit, and blocks that slide, tip or rock."""
    loops = {f"gap {gap / MM:g} mm": _loops(gap, study) for gap in (0.0, 0.02)}
    completed = sum(np.isfinite(f).all() for loop in loops.values() for _, f in loop.values())
    study.states("existing parts", "loops of one unit", completed)
    panels: list[Panel] = []
    for name, label_x, label_y, k in (
        ("normal", "normal displacement (mm)", "compression (kN)", 0),
        ("constant", "slip (mm)", "friction (kN)", 2),
        ("varying", "slip (mm)", "friction (kN)", 2),
    ):
        runs = {gap: loop[name] for gap, loop in loops.items()}
        lines = {g: (p[:, 3 - k] / MM, f[:, 2 - k] / KN) for g, (p, f) in runs.items()}
        panels.append(Panel(label_x, label_y, lines, name))
    study.figures["unit"] = drawn(panels, columns=3, height_in=2.9)

    def sine_mps2(t: Floats) -> Floats:
        return np.where(t <= 0.5, 0.5 * TABLE_G_MPS2 * np.sin(4.0 * pi * t), 0.0)

    for mu in (0.1, 0.2, 0.3, 0.4):
        history = run_block(sliding_block(mu), 2e-4, 0.6, base_mps2=sine_mps2)
        name = f"sliding block, sine pulse, friction {mu}: slip (m)"
        study.tabulated(name, history.q[:, 0].min())
    for mu in (0.1, 0.2, 0.3):
        name = f"sliding block, rectangular pulse, friction {mu}: slip (m)"
        _check_rectangle(study, name, mu, (2e-4, 1.3), 5e-3)
    for half_m in ((0.25, 1.0), (0.5, 1.5)):
        _check_upright(study, half_m)


def _loops(gap_m: float, study: Study) -> dict[str, tuple[Floats, Floats]]:
    """Drive a unit along three loops and check its forces by a radial return with small steps.

    Returns path and forces of each loop, by its name.
    """
    law = replace(_LAW, gap_m=gap_m)
    t = np.linspace(0.0, 2.0, 1201)
    # Constant and varying: two cycles along the surface; the varying depth follows the slip.
    # Normal: no slip; the pair closes and opens twice.
    slip, wave = _STROKE_M * np.sin(2.0 * pi * t), np.sin(2.0 * pi * t)
    opening = 0.02 * np.sin(pi * t) ** 2
    curves = {
        "normal": (0.0 * t, opening - 0.5 * (_DEPTH_M + gap_m) * (1.0 - np.cos(2.0 * pi * t))),
        "constant": (slip, -gap_m - _DEPTH_M * (1.0 + 0.0 * wave)),
        "varying": (slip, -gap_m - _DEPTH_M * (1.0 + 0.6 * wave)),
    }
    result: dict[str, tuple[Floats, Floats]] = {}
    for name, (x, z) in curves.items():
        path = np.column_stack([t, x, np.zeros_like(t), z])
        forces = drive_unit(law, path).forces_n
        exact = unit.follow_law(law, path, substeps=50)
        error = rms(np.linalg.norm(forces - exact, axis=1)) / _LIMIT_N
        quantity = f"{name} loop, gap {1000 * gap_m:g} mm: RMS error over the limit"
        study.at_most(quantity, error, 0.01, "radial return on a fine grid")
        study.states("unit behind a gap" if gap_m else "unit without gap", f"{name} loop", error)
        result[name] = (path, forces)
    path, forces = (rows[len(t) // 2 :] for rows in result["constant"])
    exact_j = 4.0 * _LIMIT_N * (_STROKE_M - _LIMIT_N / law.kt_n_per_m)
    name = f"work per cycle, gap {1000 * gap_m:g} mm (J)"
    study.relative(name, unit.path_work_j(path, forces), exact_j, 5e-3, "B7")
    return result


def _check_upright(study: Study, half_m: tuple[float, float]) -> None:
    """Check a released block, and a block under a base acceleration that grows after 1 s."""
    b, h = half_m
    angle_rad, name = 0.5 * atan(b / h), f"block {b} x {h} m"
    released = run_upright(half_m, 5e-4, 0.8, friction=1.0, angle_rad=angle_rad)
    computed_s = first_crossing_s(released.t_s, angle_rad + released.q[:, 2]) or np.nan
    study.tabulated(f"{name}: quarter period of rocking (s)", computed_s)

    def growing_mps2(t: Floats) -> Floats:
        return 1.2 * np.maximum(0.0, t - 1.0)

    push = partial(run_upright, half_m, 1e-3, 4.0, base_mps2=growing_mps2)
    rough, smooth = push(friction=1.0), push(friction=0.2)
    lifted, lifted_2 = ((h.t_s > 1.0) & (h.openings_m.max(axis=1) > 0.0) for h in (rough, smooth))
    start, text = growing_mps2(rough.t_s[lifted][:1])[0], "acceleration at uplift (m/s2)"
    study.relative(f"{name}: {text}", start, TABLE_G_MPS2 * b / h, 0.02, "B9, g b / h")
    slides = bool((np.abs(np.diff(smooth.q[:, 3])) > 1e-3).any())
    text = f"{name}, friction 0.2 < b / h: slides and does not lift"
    study.holds(text, truth=slides and not lifted_2.any(), source="B9")


_STEPS_PER_CYCLE: Final = 2000


def run_closed_forms(study: Study) -> None:
    """Compare oscillators with friction, impacts and a mass on a belt with closed forms."""
    decay = run_block(spring_block(x0_m=0.5), 5e-4, 3.0)
    v = decay.v[:, 0]
    turning_points_m = decay.q[np.flatnonzero(v[1:] * v[:-1] < 0.0), 0]
    # the mass stops once |x| <= slip: at the fifth turning point
    for k, computed in enumerate(turning_points_m[:5], start=1):
        exact = (-1) ** k * (0.5 - 2.0 * k * _SLIP_M)
        study.absolute(f"free decay: turning point {k} (m)", computed, exact, 0.5e-3, "B1")
    # frequency ratio (away from 1/2, 1/4 ... where the closed form fails), friction / force
    for ratio, friction_ratio in ((0.7, 0.3), (1.2, 0.4), (1.5, 0.3), (2.0, 0.2)):
        computed, exact = _forced_response(ratio, friction_ratio)
        text = f"forced, r = {ratio}, F/P = {friction_ratio}: amplitude (m)"
        study.relative(text, computed, exact, 5e-3, "B2")
    _check_fall(study, ("ball on penalty: depth (m)", "ball on penalty: contact time (s)"), 1e-4)
    for e in (0.45, 0.6, 0.71, 0.9):
        dashpot = 2.0 * drives.kelvin_voigt_damping_ratio(e) * (1e7 * MASS_KG) ** 0.5
        drive = drives.kelvin_voigt_drive(kn_n_per_m=1e7, dashpot_n_s_per_m=dashpot)
        rebound = bounce(drive).v[-1, 1]
        study.absolute(f"Kelvin-Voigt: restitution {e}", rebound, e, 0.01, "B4")
    # A mass pulled over a surface by a spring whose end moves at 0.1 m/s.
    speed, drop_m = 0.1, (0.4 - 0.3) * MASS_KG * TABLE_G_MPS2 / _SPRING_N_PER_M
    drive = drives.stribeck_drive(static=0.4, kinetic=0.3, stribeck_speed_mps=2e-4)
    mass = spring_block(friction=0.4, drive=drive)
    belt = run_block(mass, 2e-4, 6.0, anchor_m=lambda t: speed * t)
    w = sqrt(_SPRING_N_PER_M / MASS_KG)
    exact_s = 2.0 / w * (pi - atan(drop_m * w / speed)) + 2.0 * drop_m / speed
    # the mean time between the starts of long slips
    slip = belt.q[:, 0] - belt.tangentials_n[:, 0] / 1e10
    is_fast = np.diff(slip) / np.diff(belt.t_s) > 0.05
    starts_s = belt.t_s[np.flatnonzero(is_fast[1:] & ~is_fast[:-1]) + 1]
    computed_s, source = np.mean(np.diff(starts_s)), "B8, slip starts at kinetic friction"
    study.relative("belt: period of stick-slip (s)", computed_s, exact_s, 0.02, source)


def spring_block(**changes: Any) -> Block:
    """Return the oscillator of B1 and B2: 1000 kg, 40 kN/m, 1962 N of friction."""
    # Friction reverses while the mass moves by twice its elastic slip. Near a turning point this
    # time grows with the square root of that slip: hence the stiff kt of 1e10 N/m.
    return replace(sliding_block(0.2), spring_n_per_m=_SPRING_N_PER_M, **changes)


def _forced_response(r: float, friction_ratio: float) -> tuple[float, float]:
    """Return two amplitudes (m) under P cos(W t): computed after 30 cycles, and closed form.

    r = W / w (w: natural frequency) must not be 1, 1/2, 1/3, ...; ``friction_ratio`` is friction
    force / P.
    """
    force = _FRICTION_N / friction_ratio
    w = r * (_SPRING_N_PER_M / MASS_KG) ** 0.5
    period = 2.0 * pi / w
    # Friction reverses within a step: the error is first order and grows near resonance.
    dt = period / _STEPS_PER_CYCLE
    history = run_block(spring_block(), dt, 30 * period, force_n=lambda t: force * np.cos(w * t))
    last_cycles = history.q[-3 * _STEPS_PER_CYCLE :, 0]
    v, u = 1.0 / (1.0 - r * r), sin(pi / r) / (r * (1.0 + cos(pi / r)))
    exact = force / _SPRING_N_PER_M * sqrt(v * v - (friction_ratio * u) ** 2)
    return 0.5 * float(last_cycles.max() - last_cycles.min()), exact


def bounce(drive: Drive) -> History:
    """Return the history of an impact at 1 m/s on a contact with the given drive, no gravity."""
    options: Any = {"normal_load_n": 0.0, "v0_mps": (0.0, -1.0), "gap_m": 0.00321}
    return run_block(falling_block(**options, drive=drive), 5e-4, 0.1)


_FREE_STEPS: Final = 6


def run_integrators(study: Study) -> None:
    """Report the restitution of an elastic impact for each integrator."""
    rows: list[Row] = []
    for step in (0.1, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0):  # x contact frequency
        for integrator in ("houbolt", "newmark"):
            ratios = integrator_restitution(integrator, step)
            values = {"mean": ratios.mean(), "least": ratios.min(), "largest": ratios.max()}
            rows.append({"integrator": integrator, "step_times_frequency": step} | values)
            # The extremes depend on the phases tried; the mean of all forty less so.
            text = f"{integrator}, step x frequency {step:g}: mean restitution"
            study.tabulated(text, values["mean"])
    study.tables["integrators"] = pd.DataFrame(rows)


def integrator_restitution(integrator: str, step: float) -> Floats:
    """Return rebound / approach speed, shape (40,), for impacts at 40 instants within a step.

    `step` is the time step x circular frequency of the mass on the penalty.
    """
    count, result = _FREE_STEPS + 2 * ceil(pi / step) + 6, np.empty(40)
    block = Block(mass_kg=1.0, kn_n_per_m=1.0, kt_n_per_m=1.0, bounces=True, v0_mps=(0.0, -1.0))
    for k in range(len(result)):
        shifted = replace(block, gap_m=step * (_FREE_STEPS + (k + 0.5) / len(result)))
        history = run_block(shifted, step, count * step, integrator=solvers.INTEGRATORS[integrator])
        y = history.q[:, 1]
        result[k] = (y[-1] - y[-2]) / step
    return result


_ROWS_PER_S: Final = 2000
# source: radial return integrated with dt = 1e-5 s gave the forces and works in the table
_FORCES_AT_S: Final = (1.5, 2.0, 3.76, 4.4, 4.6, 4.9, 6.5, 7.4, 9.0, 9.2, 11.6)
_SCHEMES: Final[tuple[Scheme, ...]] = ("vector", "componentwise", "elastic")
_COUPLINGS: Final[tuple[Coupling, ...]] = ("extrapolated", "lagged")


def run_spatial(study: Study) -> None:
    """Run the study of figure 3: a contact unit on a path in space."""
    # The square wave jumps within one row: short rows keep its timing.
    path = unit.figure_3(_ROWS_PER_S)
    forces = drive_unit(PAPER_LAW, path, substeps=2).forces_n
    for time, (axis, name) in product(_FORCES_AT_S, enumerate("xy")):
        force_n = forces[round(time * _ROWS_PER_S), axis]
        study.tabulated(f"F{name} at {time:g} s (N)", force_n)
    study.tabulated("total work (J)", unit.path_work_j(path, forces))
    for start, end in ((1.25, 2.5), (3.75, 5.0), (6.25, 7.5), (8.75, 10.0)):
        rows = slice(round(start * _ROWS_PER_S) - 1, round(end * _ROWS_PER_S) + 1)
        work = unit.path_work_j(path[rows], forces[rows])
        study.tabulated(f"work from {start} to {end} s (J)", work)
    closed, friction_n = forces[:, 2] > 0.0, np.hypot(*forces[:, :2].T)
    # The rows around each jump of the square wave are left out.
    steady = np.ones(len(closed), dtype=bool)
    for jump_row in np.flatnonzero(np.diff(closed)).tolist():
        steady[jump_row : jump_row + 3] = False
    excess = friction_n - np.where(closed, 1500.0 + 0.3 * forces[:, 2], 0.0)
    largest_excess = max(0.0, float(excess[steady].max())) / _PAPER_LIMIT_N
    study.at_most("excess of force over the cone / limit", largest_excess, 1e-6, "cone")
    open_force = float(np.abs(forces[~closed & steady, :2]).max())
    study.at_most("friction while open (N)", open_force, 0.0, "no friction")
    study.states("closing decides", "vector", open_force)
    _compare_schemes(study)
    _draw_spatial(study, path[::5], forces[::5] / KN)


def _compare_schemes(study: Study) -> None:
    """Compare schemes and couplings with steps of 1 ms that are not divided."""
    path, source = unit.figure_3(1000), "radial return on a fine grid"
    exact = unit.follow_law(PAPER_LAW, path, substeps=20)
    directions = np.sign(np.diff(path[:, 1:], axis=0).round(9))
    events = int(np.count_nonzero(np.any(np.diff(directions, axis=0) != 0.0, axis=1)))
    for scheme, coupling in product(_SCHEMES, _COUPLINGS):
        options: Any = {"scheme": scheme, "coupling": coupling}
        forces = drive_unit(PAPER_LAW, path, substeps=1, **options).forces_n
        error = np.hypot(*(forces - exact)[:, :2].T) / _PAPER_LIMIT_N
        # Leave out the 3 largest errors per opening, closing or reversal: they depend on timing.
        error_ratio = rms(np.sort(error)[: -3 * events])
        largest = float(np.hypot(*forces[:, :2].T).max()) / _PAPER_LIMIT_N
        name = f"{scheme}, {coupling}"
        case = f"{name} (as in the paper)" if name == "componentwise, lagged" else name
        study.states("limit in every direction", case, largest)
        claim = "elastic springs too" if scheme == "elastic" else "components are coupled"
        study.states(claim, case, error_ratio)
        if name == "vector, extrapolated":
            study.at_most("RMS error at 1 ms steps / limit", error_ratio, 0.01, source)
            study.tabulated("work at 1 ms steps (J)", unit.path_work_j(path, forces))
        else:
            study.report(f"{name}: RMS error at 1 ms steps / limit", error_ratio, 0.0, source)


def _draw_spatial(study: Study, path: Floats, forces_kn: Floats) -> None:
    t, (fx, fy, fz) = path[:, 0], forces_kn.T
    components = {"x": (t, path[:, 1]), "y": (t, path[:, 2]), "10 uz": (t, 10.0 * path[:, 3])}
    total = {"N": (t, fz), "|F|": (t, np.hypot(fx, fy))}
    over_time = [
        Panel("time (s)", "displacement (m)", components),
        Panel("time (s)", "friction (kN)", {"x": (t, fx), "y": (t, fy)}),
        Panel("time (s)", "force (kN)", total),
    ]
    study.figures["histories"] = drawn(over_time, height_in=5.2)
    angles = np.linspace(0.0, 2.0 * pi, 181)
    cone = _PAPER_LIMIT_N / KN * np.cos(angles), _PAPER_LIMIT_N / KN * np.sin(angles)
    dots = {"ls": "none", "marker": ".", "ms": 2.5}
    planes = [
        Panel("ux (m)", "Fx (kN)", {"x": (path[:, 1], fx)}),
        Panel("uy (m)", "Fy (kN)", {"y": (path[:, 2], fy)}),
        Panel("Fx (kN)", "Fy (kN)", {"cone": cone, "|F|": (fx, fy, dots)}, "", {"aspect": "equal"}),
    ]
    study.figures["planes"] = drawn(planes, columns=3, height_in=2.9)


type PathKind = Literal["closed", "opening and closing", "reversals"]
# Paths of the study of the couplings, with the titles of their panels.
_KINDS: Final[dict[PathKind, str]] = {
    "closed": "path that stays closed",
    "opening and closing": "path that opens and closes",
    "reversals": "path with reversals",
}
_DECK: Final = "deck C5"
_DECK_S: Final = 0.6


def run_orders(study: Study) -> None:
    """Report the order of accuracy of both couplings of friction (extrapolated and lagged)."""
    rows: list[Row] = [
        {"study": kind, "coupling": coupling, "rows": rows, "step": 1.0 / rows}
        | {"error_ratio": path_error(rows, coupling, kind)}
        for kind, coupling, rows in product(_KINDS, _COUPLINGS, (125, 250, 500, 1000, 2000, 4000))
    ]
    exact = solvers.run_deck(deck_case("C5", solver="penalty", dt_s=2.5e-4, duration_s=_DECK_S))
    scale = np.abs(exact.q).max(axis=0)
    couplings = (("extrapolated", 1), ("lagged", 1), ("extrapolated", 8))
    for step, (coupling, substeps) in product((0.2, 0.1, 0.05, 0.02, 0.01), couplings):
        dt_s = step / deck_case("C5").contact_frequency_rad_per_s
        case = deck_case("C5", dt_s=dt_s, duration_s=_DECK_S, coupling=coupling)
        history = solvers.run_opensees(case, solvers.pulse_of(case), parts_on_change=substeps)
        q = np.array([np.interp(exact.t_s, history.t_s, column) for column in history.q.T]).T
        name = coupling if substeps == 1 else f"{coupling}, sub-steps"
        row = {"study": _DECK, "coupling": name, "rows": 0, "step": step}
        rows.append(row | {"error_ratio": rms((q - exact.q) / scale)})
    study.tables["errors"] = table = pd.DataFrame(rows)
    source = "radial return on a fine grid"
    panels: dict[str, dict[str, Any]] = {kind: {} for kind in (*_KINDS, _DECK)}
    for (kind, coupling), group in table.groupby(["study", "coupling"]):
        # slope of ln error over ln step
        order = float(np.polyfit(np.log(group["step"]), np.log(group["error_ratio"]), 1)[0])
        if (kind, coupling) == ("closed", "extrapolated"):
            at_1000 = float(group.loc[group["rows"] == 1000, "error_ratio"].iloc[0])
            study.at_most("closed path, 1000 rows per period: RMS error", at_1000, 0.012, source)
            study.holds("closed path: order at least 0.9", truth=order >= 0.9, source=source)
        study.report(f"{kind}, {coupling}: order", order, 1.0, source)
        panels[str(kind)][str(coupling)] = group["step"], group["error_ratio"], {"marker": "."}
    scales = {"xscale": "log", "yscale": "log"}
    titles = {**_KINDS, _DECK: "frictional deck C5, step x contact frequency"}
    labels = "step / period (-)", "RMS error (-)"
    figure = [Panel(*labels, lines, titles[kind], scales) for kind, lines in panels.items()]
    study.figures["order"] = drawn(figure, columns=2, height_in=5.2)


def smooth_path(rows: int, kind: PathKind) -> Floats:
    """Return two periods (1 s each) of a curve in space, with `rows` rows per period."""
    t = np.linspace(0.0, 2.0, 2 * rows + 1)
    if kind == "reversals":
        x, y = 0.5 * np.sin(2.0 * pi * t), 0.005 * (1.0 - np.cos(4.0 * pi * t))
        return np.column_stack([t, x, y, np.full_like(t, -0.1)])
    x = 0.5 * np.sin(2.0 * pi * t) + 0.2 * np.sin(4.0 * pi * t + 0.4) - 0.2 * np.sin(0.4)
    y = 0.4 * np.sin(2.0 * pi * t + 1.1) - 0.4 * np.sin(1.1)
    z = (-0.10 if kind == "closed" else 0.02) - 0.08 * np.sin(2.0 * pi * t + 0.3)
    return np.column_stack([t, x, y, z])


def path_error(rows: int, coupling: Coupling, kind: PathKind) -> float:
    """Return the RMS error of the friction force / largest friction limit."""
    path = smooth_path(rows, kind)
    # The reference follows the smooth curve, not the chords between the rows.
    fine_rows = max(1, 64000 // rows)
    fine_forces = unit.follow_law(PAPER_LAW, smooth_path(rows * fine_rows, kind))[::fine_rows]
    forces = drive_unit(PAPER_LAW, path, substeps=1, coupling=coupling).forces_n
    limit = PAPER_LAW.cohesion_n + PAPER_LAW.friction * float(fine_forces[:, 2].max())
    return rms(np.hypot(*(forces - fine_forces)[:, :2].T)) / limit
