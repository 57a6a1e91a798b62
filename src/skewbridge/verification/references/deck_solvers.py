"""The rigid skew deck by three solvers: OpenSees, the penalty equation, rigid contact (LCP).

`run_opensees` uses the contact units of the package. `run_penalty` integrates the same equations
without OpenSees: Runge-Kutta of fourth order with steps that resolve the contact, and radial return
of the tangential springs at every stage from the stick points at the start of the step. `run_lcp`
has rigid contacts and Moreau-Jean time stepping. `skewbridge deck` runs a deck from a case file.
"""

from collections.abc import Callable
from math import ceil
from pathlib import Path
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops
import pyarrow as pa
import pyarrow.parquet as pq

from skewbridge.contact import ContactSet
from skewbridge.contact.drives import kelvin_voigt_drive
from skewbridge.errors import InputError, SolutionError
from skewbridge.files.text import writable_file
from skewbridge.motions.read import read_motion
from skewbridge.verification.references.cases import DeckCase, file_of_case, read_case
from skewbridge.verification.references.deck_model import (
    CORNERS,
    BaseAcceleration,
    DeckEnergy,
    DeckHistory,
    Response,
    SkewDeck,
    make_deck,
    pulse_of,
)
from skewbridge.verification.references.lcp import LcpHistory, RigidContacts, moreau_jean
from skewbridge.verification.references.live_model import (
    Array,
    Solver,
    clean_domain,
    even_times,
    march,
    shake_base,
)

CENTRE: Final = 1
_GROUND: Final = 2
CORNER_NODES: Final = (11, 12, 13, 14)
WALL_NODES: Final = (21, 22, 23, 24)
_INTEGRATORS: Final[dict[str, tuple[str | float, ...]]] = {
    "newmark": ("Newmark", 0.5, 0.25),
    "houbolt": ("Houbolt",),
    "hht": ("HHT", 0.8),
}
# Step times the circular frequency of the deck on the two springs of an end.
_PENALTY_RESOLUTION: Final = 0.01
# Number of steps held in memory.
_STEPS_IN_MEMORY: Final = 50_000
# At this step the tabulated peaks with e <= 0.6 are within 0.05 % of the converged ones.
_LARGEST_LCP_STEP_S: Final = 2.0e-5
_DESCRIPTIONS: Final = {
    "t_s": ("s", "time"),
    "ux_m": ("m", "displacement of the mass centre relative to the ground, along the deck"),
    "uy_m": ("m", "the same across the deck"),
    "theta_rad": ("rad", "rotation, counter-clockwise"),
    "gap": ("m", "opening, negative in contact"),
    "fn": ("N", "compression"),
    "ft": ("N", "friction force with the sign of slip"),
}

type Connect = Callable[[DeckCase], None]
type State = tuple[float, float, float, float, float, float]


def run_deck(case: DeckCase, excitation: BaseAcceleration | None = None) -> DeckHistory:
    """Run a deck case with its solver, under its pulse unless another excitation is given.

    Raises:
        SolutionError: The solver could not finish.
    """
    solver = {"opensees": run_opensees, "penalty": run_penalty, "lcp": run_lcp}[case.solver]
    return solver(case, excitation or pulse_of(case))


def run_deck_case(case_file: Path, out: Path) -> dict[str, Any]:
    """Run a deck case file and write its histories as parquet.

    Returns:
        Peaks, time of the first contact, energy residual.

    Raises:
        InputError: The case, a motion or the output folder is wrong.
        SolutionError: The solver could not finish.
    """
    case = read_case(case_file, DeckCase)
    excitation = None
    if case.motion is not None:
        first, second = (file_of_case(case_file, name) for name in case.motion)
        for path in (first, second):
            if not path.exists():
                raise InputError(f"motion {path} does not exist")
        motion = read_motion(first, second)
        excitation = BaseAcceleration.of_motion(motion)
    writable_file(out)
    history = run_deck(case, excitation)
    if not np.isfinite(history.q).all():
        raise SolutionError("the response is not finite: use a smaller dt_s")
    pq.write_table(_table(history), out)
    return {
        "peaks": history.peaks(),
        "first_contact_s": history.first_contact_s(),
        "energy_residual_ratio": history.energy_residual_ratio,
        "out": str(out),
    }


def _table(history: DeckHistory) -> pa.Table:
    columns = {"t_s": history.t_s}
    columns |= dict(zip(("ux_m", "uy_m", "theta_rad"), history.q.T, strict=True))
    for prefix, unit, values in (
        ("gap", "m", history.openings_m),
        ("fn", "n", history.normals_n),
        ("ft", "n", history.tangentials_n),
    ):
        columns |= {f"{prefix}_{c}_{unit}": v for c, v in zip(CORNERS, values.T, strict=True)}
    fields: list[pa.Field[Any]] = []
    for name in columns:
        unit, text = _DESCRIPTIONS.get(name) or _DESCRIPTIONS[name[:3].rstrip("_")]
        fields.append(pa.field(name, pa.float64(), metadata={"unit": unit, "description": text}))
    return pa.table([pa.array(v) for v in columns.values()], schema=pa.schema(fields))


def run_opensees(
    case: DeckCase,
    excitation: BaseAcceleration,
    *,
    connect: Connect | None = None,
    parts_on_change: int = 1,
) -> DeckHistory:
    """Run a deck case in OpenSees.

    Args:
        case: The case.
        excitation: Ground acceleration.
        connect: Function that connects the centre to the corner nodes; rigid links by default.
        parts_on_change: Number of sub-steps of a step in which a contact opens or closes.

    Raises:
        SolutionError: A step does not converge.
    """
    deck, contacts = make_deck(case), ContactSet(coupling=case.coupling)
    kn, dashpot = case.normal_stiffness_n_per_m, deck.dashpot_n_s_per_m
    drive = kelvin_voigt_drive(kn_n_per_m=kn, dashpot_n_s_per_m=dashpot) if dashpot else None
    with clean_domain():
        build_deck(deck)
        (connect or rigid_links)(case)
        for wall, node, corner in zip(WALL_NODES, CORNER_NODES, deck.corners, strict=True):
            contacts.add(
                wall,
                node,
                corner.normal,
                case.gap_normal_m,
                case.friction,
                case.cohesion_n,
                kn=kn,
                kt=case.kt_n_per_m,
                drive=drive,
                name=corner.name,
            )
        times, accel = excite_deck(case, excitation)
        prepare_analysis(case.integrator)
        q, v = np.zeros((len(times), 3)), np.zeros((len(times), 3))
        openings, normals, friction = (np.zeros((len(times), 4)) for _ in range(3))
        openings[0] = case.gap_normal_m
        # The units count slip along the normal turned counter-clockwise: the tangent at the left.
        signs = [1.0 if corner.end else -1.0 for corner in deck.corners]
        for k in march(contacts, times, case.dt_s, parts_on_change):
            q[k], v[k] = ops.nodeDisp(CENTRE), ops.nodeVel(CENTRE)
            openings[k], normals[k] = contacts.openings_m, contacts.normals_n
            forces = contacts.tangentials_n
            friction[k] = [sign * force[0] for sign, force in zip(signs, forces, strict=True)]
    balance, response = DeckEnergy(deck), (q, v, openings, normals, friction)
    balance.add(response, accel)
    return balance.history(times, response)


def build_deck(deck: SkewDeck, wall_offset_m: float = 0.0) -> None:
    """Define the mass centre on its bearings, the corners and their walls at an offset."""
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    ops.node(CENTRE, 0.0, 0.0)
    ops.node(_GROUND, 0.0, 0.0)
    ops.fix(_GROUND, 1, 1, 1)
    ops.mass(CENTRE, *deck.mass)
    for dof, (stiffness, damping) in enumerate(
        zip(deck.stiffness, deck.damping, strict=True), start=1
    ):
        ops.uniaxialMaterial("Elastic", dof, stiffness, damping)
    ops.element("zeroLength", 1, _GROUND, CENTRE, "-mat", 1, 2, 3, "-dir", 1, 2, 6)
    for wall, node, corner in zip(WALL_NODES, CORNER_NODES, deck.corners, strict=True):
        (x, y), (nx, ny) = (corner.x_m, corner.y_m), corner.normal
        ops.node(node, x, y)
        ops.node(wall, x - wall_offset_m * nx, y - wall_offset_m * ny)
        ops.fix(wall, 1, 1, 1)


def rigid_links(_case: DeckCase) -> None:
    """Connect the mass centre to the corners by rigid links."""
    for node in CORNER_NODES:
        ops.rigidLink("beam", CENTRE, node)


def excite_deck(case: DeckCase, excitation: BaseAcceleration) -> tuple[Array, Array]:
    """Apply the excitation; return the times of the steps and the accelerations at them."""
    times = even_times(case.duration_s, case.dt_s)
    half = 0.5 * case.dt_s
    # Means over the step around each time: a jump between two steps keeps its impulse.
    accel = excitation.mean(times - half, times + half)
    accel[:, 0] = excitation.at(times[:1])[:, 0]
    shake_base(CENTRE, case.dt_s, accel)
    return times, accel


def prepare_analysis(integrator: str, system: str = "ProfileSPD") -> None:
    """Define the transient analysis."""
    # The tolerance is far below every displacement of interest and far above rounding: the problem
    # is linear by pieces.
    Solver(numberer="RCM", system=system, integrator=_INTEGRATORS[integrator]).prepare()


class PenaltyDeck:
    """Right-hand side and stick points; plain floats, because it is called very often."""

    def __init__(self, case: DeckCase, deck: SkewDeck) -> None:
        self._mass, self._stiffness, self._damping = deck.mass, deck.stiffness, deck.damping
        self._rows = [(*c.normal_row, *c.tangent_row) for c in deck.corners]
        self._gap, self._kn = case.gap_normal_m, case.normal_stiffness_n_per_m
        self._kt, self._dashpot = case.kt_n_per_m, deck.dashpot_n_s_per_m
        self._friction, self._cohesion = case.friction, case.cohesion_n
        self.stick = [0.0] * len(self._rows)

    def forces(self, state: State) -> list[tuple[float, float, float]]:
        """Return compression, friction (with the sign of slip) and slip of each corner."""
        x, y, r, vx, vy, vr = state
        result: list[tuple[float, float, float]] = []
        for (nx, ny, nr, tx, ty, tr), stick in zip(self._rows, self.stick, strict=True):
            opening = self._gap + nx * x + ny * y + nr * r
            slip = tx * x + ty * y + tr * r
            normal = -self._kn * opening
            if self._dashpot and opening < 0.0:
                normal -= self._dashpot * (nx * vx + ny * vy + nr * vr)
            if opening >= 0.0 or normal <= 0.0:
                result.append((0.0, 0.0, slip))
                continue
            limit = self._cohesion + self._friction * normal
            trial = self._kt * (slip - stick)
            result.append((normal, max(-limit, min(limit, trial)), slip))
        return result

    def rate(self, state: State, ax: float, ay: float) -> State:
        """Return the time derivative of (q, v) under a ground acceleration."""
        x, y, r, vx, vy, vr = state
        (mx, my, mr), (kx, ky, kr), (cx, cy, cr) = self._mass, self._stiffness, self._damping
        fx, fy, fr = -kx * x - cx * vx - mx * ax, -ky * y - cy * vy - my * ay, -kr * r - cr * vr
        for (nx, ny, nr, tx, ty, tr), (normal, friction, _) in zip(
            self._rows, self.forces(state), strict=True
        ):
            if normal:
                fx += normal * nx - friction * tx
                fy += normal * ny - friction * ty
                fr += normal * nr - friction * tr
        return vx, vy, vr, fx / mx, fy / my, fr / mr

    def move_stick_points(self, forces: list[tuple[float, float, float]]) -> None:
        """Bring the stick points to the end of a step."""
        for k, (normal, friction, slip) in enumerate(forces):
            self.stick[k] = slip - friction / self._kt if normal else slip


def run_penalty(case: DeckCase, excitation: BaseAcceleration) -> DeckHistory:
    """Integrate a deck case with penalty contact; output at multiples of the case's dt_s."""
    deck = make_deck(case)
    model = PenaltyDeck(case, deck)
    times = even_times(case.duration_s, case.dt_s)
    inner = max(1, ceil(case.dt_s * case.contact_frequency_rad_per_s / _PENALTY_RESOLUTION))
    # A jump of the pulse inside a step gets a step end of its own.
    jump = [excitation.period_s] if excitation.period_s < times[-1] else []
    parts = times[:-1, None] + case.dt_s / inner * np.arange(inner)
    fine = np.unique(np.concatenate([parts.ravel(), times[-1:], jump]))
    fine = fine[np.append(True, np.diff(fine) > 1e-12)]
    state: State = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    states, forces = [state], [model.forces(state)]
    balance = DeckEnergy(deck)
    wanted = np.searchsorted(fine, times - 1e-12)
    kept = np.zeros((len(times), 14))
    half = 0.5 * float(np.median(np.diff(fine)))
    for start in range(0, len(fine) - 1, _STEPS_IN_MEMORY):
        part = fine[start : start + _STEPS_IN_MEMORY + 1]
        # Accelerations at start, middle and end of each step, one-sided at jumps.
        starts, ends = part[:-1], part[1:]
        inside = 1e-9 * (ends - starts)
        times_of_stages = (starts + inside, 0.5 * (starts + ends), ends - inside)
        stages = np.concatenate([excitation.at(t) for t in times_of_stages]).T.tolist()
        for h, accel in zip(np.diff(part).tolist(), stages, strict=True):
            state = _runge_kutta(model, state, h, accel)
            states.append(state)
            forces.append(model.forces(state))
            model.move_stick_points(forces[-1])
        loads = np.array(forces)
        rows = np.hstack([np.array(states), loads[:, :, 0], loads[:, :, 1]])
        balance.add(_response(case, deck, rows), excitation.mean(part - half, part + half))
        is_wanted = (wanted >= start) & (wanted < start + len(part))
        kept[is_wanted] = rows[wanted[is_wanted] - start]
        # Only the last state is carried on: memory does not grow with the number of steps.
        states, forces = states[-1:], forces[-1:]
    return balance.history(times, _response(case, deck, kept))


def _response(case: DeckCase, deck: SkewDeck, rows: Array) -> Response:
    q = rows[:, :3]
    openings = case.gap_normal_m + q @ deck.normal_rows.T
    return q, rows[:, 3:6], openings, rows[:, 6:10], rows[:, 10:]


def _runge_kutta(model: PenaltyDeck, s: State, h: float, accel: list[float]) -> State:
    ax0, ay0, ax1, ay1, ax2, ay2 = accel
    k1 = model.rate(s, ax0, ay0)
    k2 = model.rate(_moved(s, k1, 0.5 * h), ax1, ay1)
    k3 = model.rate(_moved(s, k2, 0.5 * h), ax1, ay1)
    k4 = model.rate(_moved(s, k3, h), ax2, ay2)
    w = h / 6.0
    x, y, r, vx, vy, vr = (
        value + w * (a + 2.0 * (b + c) + d)
        for value, a, b, c, d in zip(s, k1, k2, k3, k4, strict=True)
    )
    return x, y, r, vx, vy, vr


def _moved(s: State, rate: State, h: float) -> State:
    return (
        s[0] + h * rate[0],
        s[1] + h * rate[1],
        s[2] + h * rate[2],
        s[3] + h * rate[3],
        s[4] + h * rate[4],
        s[5] + h * rate[5],
    )


def run_lcp(case: DeckCase, excitation: BaseAcceleration) -> DeckHistory:
    """Run a deck case with rigid contacts, Newton restitution (1 unless given) and friction.

    The time stepping is of first order, so it divides the step of the case.

    Raises:
        SolutionError: A step has no solution.
    """
    deck = make_deck(case)
    parts = max(1, ceil(case.dt_s / _LARGEST_LCP_STEP_S - 1e-9))
    times = even_times(case.duration_s, case.dt_s)
    dt_s = case.dt_s / parts
    fine = even_times(case.dt_s * (len(times) - 1), dt_s)
    loads = np.zeros((len(fine) - 1, 3))
    loads[:, :2] = -np.array(deck.mass[:2]) * excitation.mean(fine[:-1], fine[1:]).T
    contacts = RigidContacts(
        normal_rows=deck.normal_rows,
        gaps_m=np.full(len(deck.corners), case.gap_normal_m),
        tangent_rows=deck.tangent_rows[::2],
        groups=tuple(corner.end for corner in deck.corners),
        friction=case.friction,
        cohesion_n=case.cohesion_n,
        restitution=1.0 if case.restitution is None else case.restitution,
    )
    matrices = (np.diag(deck.mass), np.diag(deck.damping), np.diag(deck.stiffness))
    history = moreau_jean(matrices, contacts, loads, dt_s)

    def mean_forces(impulses_ns: Array) -> Array:
        """Return the mean forces over the steps of the case; the first row is the start."""
        steps = impulses_ns[1:].reshape(len(times) - 1, parts, -1).sum(axis=1)
        return np.vstack([impulses_ns[:1], steps]) / case.dt_s

    # The friction impulse of an end is shared by its corners as the compression is.
    normals = mean_forces(history.normal_impulses_ns)
    tangents = mean_forces(history.tangent_impulses_ns)
    friction = np.zeros_like(normals)
    for end, members in enumerate((slice(0, 2), slice(2, 4))):
        total = normals[:, members].sum(axis=1)
        share = normals[:, members] / np.where(total > 0.0, total, 1.0)[:, None]
        friction[:, members] = share * tangents[:, end, None]
    q = history.q[::parts]
    return DeckHistory(
        t_s=times,
        q=q,
        openings_m=case.gap_normal_m + q @ deck.normal_rows.T,
        normals_n=normals,
        tangentials_n=friction,
        energy_residual_ratio=_energy_residual(deck, loads, history),
    )


def _energy_residual(deck: SkewDeck, loads: Array, history: LcpHistory) -> float:
    """Return input less works and stored energies at the end, over the largest input."""
    step = np.diff(history.q, axis=0)
    given = np.cumsum(np.sum(loads * step, axis=1))
    mean_v = 0.5 * (history.v[1:] + history.v[:-1])
    lost = float(np.sum(np.array(deck.damping) * mean_v * step)) + history.contact_work_j
    q, v = history.q[-1], history.v[-1]
    kept = 0.5 * float(np.array(deck.mass) @ v**2 + np.array(deck.stiffness) @ q**2)
    largest = float(np.abs(given).max())
    return (float(given[-1]) - lost - kept) / largest if largest > 0.0 else 0.0
