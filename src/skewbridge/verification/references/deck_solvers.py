"""Three solvers for a rigid skew deck on bearings between two abutments.

`run_opensees` uses the contact units of the package. `run_penalty` integrates the same equations
without OpenSees, by a Runge-Kutta method of fourth order with steps that resolve the contact. At
each stage, radial return of the tangential springs starts from the stick points at the start of the
step. `run_lcp` uses rigid contacts and Moreau-Jean time stepping. `skewbridge deck` runs a deck
from a case file.

The deck has three degrees of freedom at the mass centre, q = (ux, uy, theta); rotations are small.
The plan is a parallelogram with edges (L, 0) and W (tan a, 1). Each end has two contacts, one at
its acute and one at its obtuse corner. The right end has the outward normal n = (cos a, -sin a) and
the tangent t = (sin a, cos a). With s = +1 at the right end and -1 at the left end:

    opening_i = gap - s (n . u + theta (n_y x_i - n_x y_i))
    slip_i = t . u + theta (t_y x_i - t_x y_i)

References:
    Dimitrakopoulos (2011), Engineering Structures 33, 813-826 (the model and its pulse).
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, cos, inf, pi, radians, sin, tan
from pathlib import Path
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops
import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.contact import ContactSet
from skewbridge.contact.drives import kelvin_voigt_damping_ratio, kelvin_voigt_drive
from skewbridge.errors import SolutionError
from skewbridge.files.tables import Floats
from skewbridge.files.text import read_mapping, writable_file
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2
from skewbridge.verification.references import live_model as live
from skewbridge.verification.references.cases import DeckCase, file_of_case, read_case
from skewbridge.verification.references.lcp import RigidContacts, moreau_jean
from skewbridge.verification.references.live_model import History

logger = logging.getLogger(__name__)

# First letter: right or left end; second letter: acute or obtuse corner.
CORNERS: Final = ("ra", "ro", "lo", "la")
CENTRE: Final = 1
_GROUND: Final = 2
CORNER_NODES: Final = (11, 12, 13, 14)
WALL_NODES: Final = (21, 22, 23, 24)
INTEGRATORS: Final[dict[str, tuple[str | float, ...]]] = {
    "newmark": ("Newmark", 0.5, 0.25),
    "houbolt": ("Houbolt",),
    "hht": ("HHT", 0.8),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class SkewDeck:
    """Matrix diagonals of a deck case, shape (3,), and corners in the order of `CORNERS`.

    Opening = gap + normal row . q and slip = tangent row . q (rows (4, 3), positions (4, 2)). The
    dashpot of each corner gives the restitution.
    """

    mass: Floats
    stiffness: Floats
    damping: Floats
    corners_m: Floats
    normal_rows: Floats
    tangent_rows: Floats
    dashpot_n_s_per_m: float


def make_deck(case: DeckCase) -> SkewDeck:
    """Return the matrices and corners of a case."""
    length, width, skew = case.length_m, case.width_m, radians(case.skew_deg)
    inertia = case.mass_kg * (length**2 + (width / cos(skew)) ** 2) / 12.0
    mass = np.array([case.mass_kg, case.mass_kg, inertia])
    omegas = 2.0 * pi / np.array([case.period_x_s, case.period_y_s, case.period_theta_s])
    # In a flat impact both springs of an end act on the whole mass.
    zeta = kelvin_voigt_damping_ratio(case.restitution) if case.restitution else 0.0
    # The acute corner of the right end lies on the side to which the skew leans.
    side = np.array([1.0, 1.0, -1.0, -1.0])
    corner_sign = np.array([1.0, -1.0, 1.0, -1.0]) * (1.0 if skew >= 0.0 else -1.0)
    y = 0.5 * width * corner_sign
    x = side * 0.5 * length + y * tan(skew)
    (nx, ny), (tx, ty) = (cos(skew), -sin(skew)), (sin(skew), cos(skew))
    return SkewDeck(
        mass=mass,
        stiffness=mass * omegas**2,
        damping=2.0 * case.damping_ratio * omegas * mass,
        corners_m=np.column_stack([x, y]),
        normal_rows=np.column_stack([-side * nx, -side * ny, -side * (ny * x - nx * y)]),
        tangent_rows=np.column_stack([np.full(4, tx), np.full(4, ty), ty * x - tx * y]),
        dashpot_n_s_per_m=2.0 * zeta * (case.normal_stiffness_n_per_m * case.mass_kg / 2.0) ** 0.5,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseAcceleration:
    """Ground acceleration: a cosine pulse along x and y, or a record with component 1 along x.

    A record is interpolated linearly between its samples.
    """

    amplitude_mps2: tuple[float, float] = (0.0, 0.0)
    period_s: float = 1.0
    record: GroundMotion | None = None

    def at(self, times_s: Floats) -> Floats:
        """Return the acceleration (m/s2) at given times, shape (2, n)."""
        if record := self.record:
            pair = record.components
            sample_s = record.dt_s * np.arange(len(pair[0]))
            return np.array([np.interp(times_s, sample_s, accel, right=0.0) for accel in pair])
        wave = np.cos(2.0 * pi / self.period_s * times_s)
        return np.outer(self.amplitude_mps2, np.where(times_s <= self.period_s, wave, 0.0))

    def mean(self, starts_s: Floats, ends_s: Floats) -> Floats:
        """Return means over intervals (m/s2), shape (2, n); for a record, means of end values."""
        if self.record:
            return 0.5 * (self.at(starts_s) + self.at(ends_s))
        omega = 2.0 * pi / self.period_s
        starts, ends = (np.clip(times_s, 0.0, self.period_s) for times_s in (starts_s, ends_s))
        sine_changes = np.sin(omega * ends) - np.sin(omega * starts)
        return np.outer(np.array(self.amplitude_mps2) / omega, sine_changes) / (ends_s - starts_s)


def pulse_of(case: DeckCase) -> BaseAcceleration:
    """Return the pulse of a case; `ValueError` if it has none."""
    if case.pulse is None:
        raise ValueError("the case has a motion, but needs a pulse")
    amplitude = case.pulse.amplitude_g * G_MPS2
    return BaseAcceleration(amplitude_mps2=(amplitude, 0.0), period_s=case.pulse.period_s)


def _mid(values: Floats) -> Floats:
    return 0.5 * (values[1:] + values[:-1])


def _with_residual(
    deck: SkewDeck, history: History, loads_n: Floats, normals_n: Floats, tangentials_n: Floats
) -> History:
    """Return a history with its energy residual.

    Loads (steps, 3) and contact forces (steps, 4 or one per end) are means over the steps.
    """
    q, v, rows = history.q, history.v, deck.tangent_rows[:: 4 // tangentials_n.shape[1]]
    step = np.diff(q, axis=0)
    contact_j = float(np.sum(normals_n * -np.diff(history.openings_m, axis=0)))
    contact_j += float(np.sum(tangentials_n * np.diff(q @ rows.T, axis=0)))
    input_j = np.cumsum(np.sum(loads_n * step, axis=1))
    lost_j = float(np.sum(deck.damping * _mid(v) * step)) + contact_j
    stored_j = 0.5 * float(deck.mass @ v[-1] ** 2 + deck.stiffness @ q[-1] ** 2)
    residual = (float(input_j[-1]) - lost_j - stored_j) / (float(np.abs(input_j).max()) or inf)
    return history._replace(energy_residual_ratio=residual)


def _with_trapezoidal_residual(deck: SkewDeck, history: History, accel_mps2: Floats) -> History:
    force = np.zeros_like(history.q)
    force[:, :2] = -deck.mass[:2] * accel_mps2.T
    means = (_mid(forces) for forces in (force, history.normals_n, history.tangentials_n))
    return _with_residual(deck, history, *means)


def run_deck(case: DeckCase, excitation: BaseAcceleration | None = None) -> History:
    """Run a deck case with its solver; a given excitation replaces the pulse of the case."""
    solver = {"opensees": run_opensees, "penalty": run_penalty, "lcp": run_lcp}[case.solver]
    return solver(case, excitation or pulse_of(case))


def run_deck_case(case_file: Path, out: Path) -> dict[str, Any]:
    """Run a deck case file, write its histories as parquet and return peaks and first contact."""
    case = read_case(case_file, DeckCase)
    excitation = None
    if case.motion is not None:
        file_1, file_2 = (file_of_case(case_file, name) for name in case.motion)
        excitation = BaseAcceleration(record=read_motion(file_1, file_2))
    writable_file(out)
    # measured under records, against converged peaks: 1 % at 0.1, up to 15 % at 0.45
    if case.solver == "opensees" and (turn := case.dt_s * case.contact_frequency_rad_per_s) > 0.1:
        text = "dt_s x contact frequency = %.2g is above 0.1, so peaks can be off by over 1 %%"
        logger.warning(f"{text}: use dt_s = %.1g", turn, 0.05 * case.dt_s / turn)
    history = run_deck(case, excitation)
    if not np.isfinite(history.q).all():
        raise SolutionError("the response is not finite: use a smaller dt_s")
    columns = read_mapping(Path(__file__).with_name("deck_columns.yaml")).items()
    fields = [pa.field(name, pa.float64(), metadata=texts) for name, texts in columns]
    values = (history.q, history.openings_m, history.normals_n, history.tangentials_n)
    table = np.column_stack([history.t_s, *values])
    pq.write_table(pa.table(list(table.T), schema=pa.schema(fields)), out)
    return {
        "peaks": history.peaks(),
        "first_contact_s": history.first_contact_s(),
        "energy_residual_ratio": history.energy_residual_ratio,
        "out": str(out),
    }


def rigid_links(_case: DeckCase) -> None:
    """Connect the mass centre to the corners by rigid links."""
    for node in CORNER_NODES:
        ops.rigidLink("beam", CENTRE, node)


def run_opensees(
    case: DeckCase,
    excitation: BaseAcceleration,
    *,
    connect: Callable[[DeckCase], None] = rigid_links,
    parts_on_change: int = 1,
) -> History:
    """Run a deck case in OpenSees; `SolutionError` if a step does not converge.

    `connect` joins the mass centre to the corner nodes. Steps in which a contact changes are
    divided.
    """
    deck, contacts = make_deck(case), ContactSet(coupling=case.coupling)
    kn, dashpot = case.normal_stiffness_n_per_m, deck.dashpot_n_s_per_m
    drive = kelvin_voigt_drive(kn_n_per_m=kn, dashpot_n_s_per_m=dashpot) if dashpot else None
    law: Any = {"kn": kn, "kt": case.kt_n_per_m, "cohesion_n": case.cohesion_n, "drive": drive}
    with live.clean_domain(2, 3):
        build_deck(deck)
        connect(case)
        pairs = zip(WALL_NODES, CORNER_NODES, deck.normal_rows[:, :2].tolist(), strict=True)
        for wall, node, normal in pairs:
            contacts.add(wall, node, normal, case.gap_normal_m, case.friction, **law)
        times, accel = excite_deck(case, excitation)
        # the slip of units is along -t at the right end and t at the left
        slip_signs = (-1.0, -1.0, 1.0, 1.0)
        history = live.record(contacts, times, case.dt_s, [CENTRE], slip_signs, parts_on_change)
    return _with_trapezoidal_residual(deck, history, accel)


def build_deck(deck: SkewDeck, wall_offset_m: float = 0.0) -> None:
    """Define the mass centre on bearings, the corner nodes, and wall nodes offset from them."""
    ops.node(CENTRE, 0.0, 0.0)
    ops.node(_GROUND, 0.0, 0.0)
    ops.fix(_GROUND, 1, 1, 1)
    ops.mass(CENTRE, *deck.mass.tolist())
    for tag, bearing in enumerate(zip(deck.stiffness, deck.damping, strict=True), start=1):
        ops.uniaxialMaterial("Elastic", tag, *map(float, bearing))
    ops.element("zeroLength", 1, _GROUND, CENTRE, "-mat", 1, 2, 3, "-dir", 1, 2, 6)
    walls = deck.corners_m - wall_offset_m * deck.normal_rows[:, :2]
    for nodes, positions in ((CORNER_NODES, deck.corners_m), (WALL_NODES, walls)):
        for node, position in zip(nodes, positions.tolist(), strict=True):
            ops.node(node, *position)
    for wall in WALL_NODES:
        ops.fix(wall, 1, 1, 1)


def excite_deck(
    case: DeckCase, excitation: BaseAcceleration, system: str = "ProfileSPD"
) -> tuple[Floats, Floats]:
    """Define load and analysis; return the step times (s), (n,), and accelerations, (2, n)."""
    times = live.even_times(case.duration_s, case.dt_s)
    accel = shake(times, case.dt_s, excitation)
    # The default tolerance is far below every displacement of interest and far above rounding; the
    # problem is piecewise linear.
    live.prepare_analysis(numberer="RCM", system=system, integrator=INTEGRATORS[case.integrator])
    return times, accel


def shake(times_s: Floats, dt_s: float, excitation: BaseAcceleration) -> Floats:
    """Accelerate the supports of node `CENTRE`; return the accelerations (m/s2), shape (2, n)."""
    # Means over one step centred at each time: a jump between two steps keeps its impulse.
    accel = excitation.mean(times_s - 0.5 * dt_s, times_s + 0.5 * dt_s)
    accel[:, 0] = excitation.at(times_s[:1])[:, 0]
    for dof, component in enumerate(accel, start=1):
        live.path_series(dof, dt_s, component)
        ops.pattern("UniformExcitation", dof, dof, "-accel", dof)
        ops.setNodeAccel(CENTRE, dof, -float(component[0]), "-commit")
    return accel


def run_penalty(case: DeckCase, excitation: BaseAcceleration) -> History:
    """Integrate a deck case with penalty contact; return states at intervals of its `dt_s`."""
    deck = make_deck(case)
    times = live.even_times(case.duration_s, case.dt_s)
    # step x circular frequency of the deck on the two springs of an end: at most 0.01
    n_parts = max(1, ceil(case.dt_s * case.contact_frequency_rad_per_s / 0.01))
    # The pulse ends with a jump: a step ends there.
    jump_times = [excitation.period_s] if excitation.period_s < times[-1] else []
    part_times = times[:-1, None] + case.dt_s / n_parts * np.arange(n_parts)
    fine_times = np.unique(np.concatenate([part_times.ravel(), times[-1:], jump_times]))
    fine_times = fine_times[np.append(True, np.diff(fine_times) > 1e-12)]
    starts, ends = fine_times[:-1], fine_times[1:]
    # Accelerations at start, middle and end of each step, one-sided at jumps.
    margins = 1e-9 * (ends - starts)
    stage_times = (starts + margins, 0.5 * (starts + ends), ends - margins)
    accels = np.zeros((len(starts), 3, 6))  # step, stage, component of (q, v)
    accels[:, :, 3:5] = np.stack([excitation.at(t).T for t in stage_times], axis=1)
    # The state is (q, v). Without contact its rate is free @ state minus the acceleration.
    free = np.zeros((6, 6))
    free[:3, 3:] = np.eye(3)
    free[3:] = -np.hstack([np.diag(deck.stiffness / deck.mass), np.diag(deck.damping / deck.mass)])
    per_force = np.zeros((6, 8))  # rate per compression and friction of each corner
    per_force[3:] = np.vstack([deck.normal_rows, -deck.tangent_rows]).T / deck.mass[:, None]
    kn, kt, stick = case.normal_stiffness_n_per_m, case.kt_n_per_m, np.zeros(len(CORNERS))

    def contact(state: Floats) -> Floats | None:
        """Return compression and friction (sign of slip) of the corners; None if all are open."""
        openings = case.gap_normal_m + deck.normal_rows @ state[:3]
        if openings.min() >= 0.0:
            return None
        normals = -kn * openings - deck.dashpot_n_s_per_m * (deck.normal_rows @ state[3:])
        normals = np.where(openings < 0.0, np.maximum(0.0, normals), 0.0)
        limits = np.where(normals > 0.0, case.cohesion_n + case.friction * normals, 0.0)
        trial_forces = kt * (deck.tangent_rows @ state[:3] - stick)
        return np.append(normals, np.maximum(-limits, np.minimum(limits, trial_forces)))

    def rate(state: Floats, accel: Floats) -> Floats:
        forces, result = contact(state), free @ state - accel
        return result if forces is None else result + per_force @ forces

    state, rows = np.zeros(6), np.zeros((len(fine_times), 14))
    for k, h in enumerate((ends - starts).tolist()):
        start, middle, end = accels[k]
        k1 = rate(state, start)
        k2 = rate(state + 0.5 * h * k1, middle)
        k3 = rate(state + 0.5 * h * k2, middle)
        k4 = rate(state + h * k3, end)
        state = state + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        rows[k + 1, :6], forces = state, contact(state)
        stick = deck.tangent_rows @ state[:3]
        if forces is not None:
            rows[k + 1, 6:14] = forces
            stick = stick - np.where(forces[:4] > 0.0, forces[4:] / kt, 0.0)
    q, v, normals, friction = np.split(rows, (3, 6, 10), axis=1)
    openings = case.gap_normal_m + q @ deck.normal_rows.T
    half_step = 0.5 * float(np.median(ends - starts))
    accel = excitation.mean(fine_times - half_step, fine_times + half_step)
    history = History(fine_times, q, v, openings, normals, friction)
    history = _with_trapezoidal_residual(deck, history, accel)
    return history.at(np.searchsorted(fine_times, times - 1e-12))._replace(t_s=times)


def run_lcp(case: DeckCase, excitation: BaseAcceleration) -> History:
    """Run a deck case with rigid contacts, Newton restitution (1 unless given) and friction.

    Time stepping is first order, so steps of the case are divided into steps of at most 20 us.
    """
    deck = make_deck(case)
    # with these steps the tabulated peaks for e <= 0.6 are within 0.05 % of the converged ones
    n_parts = max(1, ceil(case.dt_s / 2.0e-5 - 1e-9))
    times = live.even_times(case.duration_s, case.dt_s)
    dt_s = case.dt_s / n_parts
    fine_times = live.even_times(case.dt_s * (len(times) - 1), dt_s)
    loads = np.zeros((len(fine_times) - 1, 3))
    loads[:, :2] = -deck.mass[:2] * excitation.mean(fine_times[:-1], fine_times[1:]).T
    gaps_m = np.full(len(CORNERS), case.gap_normal_m)
    contacts = RigidContacts(
        *(deck.normal_rows, gaps_m, deck.tangent_rows[::2], (0, 0, 1, 1), case.friction),
        cohesion_n=case.cohesion_n,
        restitution=1.0 if case.restitution is None else case.restitution,
    )
    matrices = np.diag(deck.mass), np.diag(deck.damping), np.diag(deck.stiffness)
    history = moreau_jean(matrices, contacts, loads, dt_s)
    history = _with_residual(deck, history, loads, history.normals_n[1:], history.tangentials_n[1:])

    def mean_forces(forces_n: Floats) -> Floats:
        """Return mean forces over the steps of the case; the first row is for time zero."""
        steps = forces_n[1:].reshape(len(times) - 1, n_parts, -1).mean(axis=1)
        return np.vstack([forces_n[:1], steps])

    # The friction of an end is divided between its corners in proportion to their compression.
    normals = mean_forces(history.normals_n)
    compression = normals.reshape(-1, 2, 2)
    totals = compression.sum(axis=2, keepdims=True)
    shares = compression / np.where(totals > 0.0, totals, 1.0)
    friction = (shares * mean_forces(history.tangentials_n)[:, :, None]).reshape(normals.shape)
    sampled = history.at(slice(None, None, n_parts))
    return sampled._replace(t_s=times, normals_n=normals, tangentials_n=friction)
