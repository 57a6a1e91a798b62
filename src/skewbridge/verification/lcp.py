"""Rigid contact with restitution and Coulomb friction by Moreau-Jean time stepping.

Linear structures M v' + C v + K q = f with frictional unilateral contacts. The smooth part is
stepped by the theta method, contact acts by impulses over the step, with Newton's restitution on
the velocity level and no tangential restitution:

    0 <= P_N  perp  (U_N+ + e U_N-) >= 0,      P_T in -(mu P_N + c h) sgn(U_T+)

Contacts that share a tangent (the two corners of an end of the deck) share one friction impulse:
their tangential velocities are the same, so the split between them is not determined. The small
complementarity problem is solved by trying the contact states, the last one first: at most two
contacts are active at a time in these studies, so that there are few.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics;
    Jean (1999), Computer Methods in Applied Mechanics and Engineering 177;
    Acary and Brogliato (2008), Numerical Methods for Nonsmooth Dynamical Systems, chapter 10.
"""

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

type Array = NDArray[np.float64]

_THETA: Final = 0.5
# Relative to the largest velocity of a step: a state is accepted when it violates no condition by
# more than rounding.
_ROUNDING: Final = 1e-10

OPEN, CLOSED = 0, 1
STICK, SLIP_FORWARD, SLIP_BACKWARD = 0, 1, -1


class LcpError(RuntimeError):
    """No contact state satisfies the conditions of a step."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidContacts:
    """Contacts of a structure.

    Attributes:
        normal_rows: Opening = gap + row . q, shape (contacts, dofs).
        gaps_m: Initial openings, shape (contacts,).
        tangent_rows: Slip = row . q, one row per group, shape (groups, dofs).
        groups: Group of each contact.
        friction: Coulomb coefficient.
        cohesion_n: Friction limit at zero normal force, per contact.
        restitution: Newton's coefficient.
    """

    normal_rows: Array
    gaps_m: Array
    tangent_rows: Array
    groups: tuple[int, ...]
    friction: float
    cohesion_n: float
    restitution: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LcpHistory:
    """Response; n times.

    Attributes:
        t_s: Shape (n,).
        q: Shape (n, dofs).
        v: Shape (n, dofs).
        normal_impulses_ns: Shape (n, contacts), of the step that ends at the time.
        tangent_impulses_ns: Shape (n, groups), with the sign of slip.
        contact_work_j: Energy taken by contact over all steps.
    """

    t_s: Array
    q: Array
    v: Array
    normal_impulses_ns: Array
    tangent_impulses_ns: Array
    contact_work_j: float


@dataclass(slots=True)
class _Solver:
    """Impulses of one step; remembers the state that was right last time."""

    contacts: RigidContacts
    compliance: Array
    guess: tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]] | None = None

    def solve(
        self, active: tuple[int, ...], u_free: Array, u_before: Array, h: float
    ) -> tuple[Array, Array]:
        """Return normal and tangential impulses; velocities are stacked normals, then tangents."""
        groups = tuple(sorted({self.contacts.groups[i] for i in active}))
        if self.guess and self.guess[0] == active:
            found = self._try(*self.guess, groups, u_free, u_before, h)
            if found:
                return found
        tangential = (STICK, SLIP_FORWARD, SLIP_BACKWARD) if self._has_friction() else (STICK,)
        for normal in product((CLOSED, OPEN), repeat=len(active)):
            for tangent in product(tangential, repeat=len(groups)):
                found = self._try(active, normal, tangent, groups, u_free, u_before, h)
                if found:
                    self.guess = (active, normal, tangent)
                    return found
        msg = f"no contact state fits the contacts {active}"
        raise LcpError(msg)

    def _has_friction(self) -> bool:
        return self.contacts.friction > 0.0 or self.contacts.cohesion_n > 0.0

    def _try(
        self,
        active: tuple[int, ...],
        normal: tuple[int, ...],
        tangent: tuple[int, ...],
        groups: tuple[int, ...],
        u_free: Array,
        u_before: Array,
        h: float,
    ) -> tuple[Array, Array] | None:
        """Return the impulses if the contact state satisfies all conditions."""
        data, count = self.contacts, len(self.contacts.groups)
        closed = [i for i, state in zip(active, normal, strict=True) if state == CLOSED]
        impulses = np.zeros(len(u_free))
        sticking: list[int] = []
        # Impulses = basis @ unknown + fixed: slip makes the friction depend on the compression.
        columns: list[Array] = []
        targets: list[float] = []
        rows: list[int] = []
        for i in closed:
            column = np.zeros(len(u_free))
            column[i] = 1.0
            columns.append(column)
            rows.append(i)
            targets.append(-data.restitution * u_before[i])
        limits: dict[int, list[int]] = {g: [] for g in groups}
        for k, i in enumerate(closed):
            limits[data.groups[i]].append(k)
        for g, state in zip(groups, tangent, strict=True):
            if not self._has_friction() or not limits[g]:
                continue
            if state == STICK:
                column = np.zeros(len(u_free))
                column[count + g] = 1.0
                columns.append(column)
                rows.append(count + g)
                targets.append(0.0)
                sticking.append(g)
                continue
            impulses[count + g] -= state * data.cohesion_n * h * len(limits[g])
            for k in limits[g]:
                columns[k][count + g] -= state * data.friction
        if columns:
            basis = np.array(columns).T
            system = self.compliance[rows] @ basis
            known = u_free[rows] + self.compliance[rows] @ impulses
            try:
                unknown = np.linalg.solve(system, np.array(targets) - known)
            except np.linalg.LinAlgError:
                return None
            impulses = impulses + basis @ unknown
        after = u_free + self.compliance @ impulses
        if self._fits(impulses, after, u_before, active, groups, tangent, limits, closed, h):
            return impulses[:count], -impulses[count:]
        return None

    def _fits(
        self,
        impulses: Array,
        after: Array,
        before: Array,
        active: tuple[int, ...],
        groups: tuple[int, ...],
        tangent: tuple[int, ...],
        limits: dict[int, list[int]],
        closed: list[int],
        h: float,
    ) -> bool:
        data, count = self.contacts, len(self.contacts.groups)
        speed = _ROUNDING * (float(np.abs(after).max()) + float(np.abs(before).max()))
        size = _ROUNDING * float(np.abs(impulses).max())
        if any(impulses[i] < -size for i in closed):
            return False
        if any(after[i] + data.restitution * before[i] < -speed for i in active):
            return False
        for g, state in zip(groups, tangent, strict=True):
            members = [closed[k] for k in limits[g]]
            if not members or not self._has_friction():
                continue
            limit = data.cohesion_n * h * len(members)
            limit += data.friction * float(sum(impulses[i] for i in members))
            if state == STICK:
                if abs(impulses[count + g]) > limit + size:
                    return False
            elif state * after[count + g] < -speed:
                return False
        return True


def moreau_jean(
    matrices: tuple[Array, Array, Array],
    contacts: RigidContacts,
    mean_loads_n: Array,
    h_s: float,
) -> LcpHistory:
    """Step a linear structure with rigid contacts from rest.

    Args:
        matrices: Mass, damping and stiffness.
        contacts: The contacts.
        mean_loads_n: Mean external load over each step, shape (steps, dofs).
        h_s: Step.

    Raises:
        LcpError: A step has no solution.
    """
    mass, damping, stiffness = matrices
    steps, dofs = mean_loads_n.shape
    rows = np.vstack([contacts.normal_rows, contacts.tangent_rows])
    iteration = cho_factor(mass + h_s * _THETA * damping + (h_s * _THETA) ** 2 * stiffness)
    spread = np.asarray(cho_solve(iteration, rows.T))
    solver = _Solver(contacts, rows @ spread)
    # Free velocity = keep @ v + pull @ q + push @ load.
    inverse = np.asarray(cho_solve(iteration, np.eye(dofs)))
    keep = np.eye(dofs) - h_s * inverse @ (damping + _THETA * h_s * stiffness)
    pull, push = -h_s * inverse @ stiffness, mean_loads_n @ (h_s * inverse).T
    count, group_count = len(contacts.groups), len(contacts.tangent_rows)
    q, v = np.zeros((steps + 1, dofs)), np.zeros((steps + 1, dofs))
    normal, tangent = np.zeros((steps + 1, count)), np.zeros((steps + 1, group_count))
    work = 0.0
    for k in range(steps):
        free = keep @ v[k] + pull @ q[k] + push[k]
        u_before = rows @ v[k]
        forecast = contacts.gaps_m + contacts.normal_rows @ q[k] + 0.5 * h_s * u_before[:count]
        if forecast.min() <= 0.0:
            active = tuple(int(i) for i in np.flatnonzero(forecast <= 0.0))
            p_n, p_t = solver.solve(active, rows @ free, u_before, h_s)
            normal[k + 1], tangent[k + 1] = p_n, p_t
            free = free + spread @ np.concatenate([p_n, -p_t])
            mean = 0.5 * (u_before + rows @ free)
            work += float(p_t @ mean[count:] - p_n @ mean[:count])
        v[k + 1] = free
        q[k + 1] = q[k] + h_s * (_THETA * free + (1.0 - _THETA) * v[k])
    return LcpHistory(
        t_s=h_s * np.arange(steps + 1),
        q=q,
        v=v,
        normal_impulses_ns=normal,
        tangent_impulses_ns=tangent,
        contact_work_j=work,
    )
