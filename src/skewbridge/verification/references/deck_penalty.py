"""The same deck as an ordinary differential equation with penalty contact, without OpenSees.

Runge-Kutta of fourth order with steps that resolve the contact; radial return of the tangential
springs at every stage from the stick points at the start of the step.
"""

from math import ceil
from typing import Final

import numpy as np

from skewbridge.verification.references.case_files import DeckCase
from skewbridge.verification.references.deck_model import (
    Deck,
    DeckHistory,
    EnergyBalance,
    Excitation,
    Response,
)
from skewbridge.verification.references.live_model import Array, even_times

# Step times the circular frequency of the deck on the two springs of an end.
_RESOLUTION: Final = 0.01
# Steps that are held in memory at a time.
_PART: Final = 50_000

type State = tuple[float, float, float, float, float, float]


class PenaltyDeck:
    """Right-hand side and stick points; plain floats, because it is called very often."""

    def __init__(self, case: DeckCase, deck: Deck) -> None:
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


def run_penalty(case: DeckCase, deck: Deck, excitation: Excitation) -> DeckHistory:
    """Integrate a deck case with penalty contact; output at multiples of the case's dt_s."""
    model = PenaltyDeck(case, deck)
    times = even_times(case.duration_s, case.dt_s)
    speed = (2.0 * case.normal_stiffness_n_per_m / case.mass_kg) ** 0.5
    inner = max(1, ceil(case.dt_s * speed / _RESOLUTION))
    # A jump of the pulse inside a step gets a step end of its own.
    jump = [excitation.period_s] if excitation.period_s < times[-1] else []
    parts = times[:-1, None] + case.dt_s / inner * np.arange(inner)
    fine = np.unique(np.concatenate([parts.ravel(), times[-1:], jump]))
    fine = fine[np.append(True, np.diff(fine) > 1e-12)]
    state: State = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    states, forces = [state], [model.forces(state)]
    balance = EnergyBalance(deck)
    wanted = np.searchsorted(fine, times - 1e-12)
    kept = np.zeros((len(times), 14))
    half = 0.5 * float(np.median(np.diff(fine)))
    for start in range(0, len(fine) - 1, _PART):
        part = fine[start : start + _PART + 1]
        stages = _stage_accelerations(excitation, part)
        for h, accel in zip(np.diff(part).tolist(), stages, strict=True):
            state = _runge_kutta(model, state, h, accel)
            states.append(state)
            forces.append(model.forces(state))
            model.move_stick_points(forces[-1])
        rows = _rows(states, forces)
        balance.add(_response(case, deck, rows), excitation.mean(part - half, part + half))
        inside = (wanted >= start) & (wanted < start + len(part))
        kept[inside] = rows[wanted[inside] - start]
        # Only the last state is carried on: memory does not grow with the number of steps.
        states, forces = states[-1:], forces[-1:]
    return balance.history(times, _response(case, deck, kept))


def _rows(states: list[State], forces: list[list[tuple[float, float, float]]]) -> Array:
    """Return displacements, velocities, compressions and frictions, shape (n, 14)."""
    loads = np.array(forces)
    return np.hstack([np.array(states), loads[:, :, 0], loads[:, :, 1]])


def _response(case: DeckCase, deck: Deck, rows: Array) -> Response:
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


def _stage_accelerations(excitation: Excitation, fine: Array) -> list[list[float]]:
    """Return the accelerations at start, middle and end of each step, one-sided at jumps."""
    starts, ends = fine[:-1], fine[1:]
    inside = 1e-9 * (ends - starts)
    parts = [excitation.at(t) for t in (starts + inside, 0.5 * (starts + ends), ends - inside)]
    return np.concatenate(parts).T.tolist()
