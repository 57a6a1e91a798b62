"""Rigid contact with restitution and Coulomb friction by Moreau-Jean time stepping.

Linear structures M v' + C v + K q = f with frictional unilateral contacts. The smooth part is
stepped by the theta method, contact acts by impulses over the step, with Newton's restitution on
the velocity level and no tangential restitution. The impulses of a step solve

    0 <= P_N  perp  (U_N+ + e U_N-) >= 0,      P_T in -(mu P_N + c h) sgn(U_T+)

Contacts that share a tangent (the two corners of an end of the deck) share one friction impulse:
their tangential velocities are the same, so the split between them is not determined. The problem
is solved by trying the contact states, the last one first: at most two contacts are active at a
time in these studies, so that there are few. Cohesion acts at every contact that is active, with
or without compression: otherwise a contact that only touches could have no solution.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics;
    Jean (1999), Computer Methods in Applied Mechanics and Engineering 177;
    Acary and Brogliato (2008), Numerical Methods for Nonsmooth Dynamical Systems, chapter 10.
"""

from collections.abc import Generator
from dataclasses import dataclass, field
from itertools import product
from typing import Final

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from skewbridge.errors import SolutionError
from skewbridge.verification.references.live_model import Array

_THETA: Final = 0.5
# Relative to the largest velocity or impulse: a state may violate a condition by rounding only.
_ROUNDING: Final = 1e-10

OPEN, CLOSED = 0, 1
STICK, SLIP_FORWARD, SLIP_BACKWARD = 0, 1, -1


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
class ContactState:
    """A guess: which contacts are closed, and how each group with friction moves."""

    active: tuple[int, ...]
    normal: tuple[int, ...]
    groups: tuple[int, ...]
    tangent: tuple[int, ...]

    @property
    def closed(self) -> tuple[int, ...]:
        """Contacts that carry an impulse."""
        return tuple(i for i, s in zip(self.active, self.normal, strict=True) if s == CLOSED)


@dataclass(slots=True)
class ImpactSolver:
    """Solves the problem of a step; remembers the state that was right last time.

    Attributes:
        contacts: The contacts.
        compliance: Change of the velocities (normals, then tangents of the groups) per impulse.
    """

    contacts: RigidContacts
    compliance: Array
    _last: ContactState | None = field(default=None, init=False)

    def solve(
        self, active: tuple[int, ...], u_free: Array, u_before: Array, h: float
    ) -> tuple[Array, Array]:
        """Return the normal and tangential impulses (with the sign of slip) of a step.

        Args:
            active: Contacts whose gaps are closed.
            u_free: Velocities after the step without contact; normals, then groups.
            u_before: Velocities before the step.
            h: Time step.

        Raises:
            SolutionError: No state fits.
        """
        count = len(self.contacts.groups)
        for state in self._states(active):
            impulses = self._impulses(state, u_free, u_before, h)
            if impulses is None:
                continue
            after = u_free + self.compliance @ impulses
            if self._fits(state, impulses, after, (u_free, u_before), h):
                self._last = state
                return impulses[:count], -impulses[count:]
        raise SolutionError(f"no contact state fits the contacts {active}")

    def _states(self, active: tuple[int, ...]) -> Generator[ContactState]:
        if self._last is not None and self._last.active == active:
            yield self._last
        has_friction = self.contacts.friction > 0.0 or self.contacts.cohesion_n > 0.0
        touched = {self.contacts.groups[i] for i in active} if has_friction else ()
        groups = tuple(sorted(touched))
        for normal in product((CLOSED, OPEN), repeat=len(active)):
            for tangent in product((STICK, SLIP_FORWARD, SLIP_BACKWARD), repeat=len(groups)):
                yield ContactState(active=active, normal=normal, groups=groups, tangent=tangent)

    def _cohesion_ns(self, state: ContactState, group: int, h: float) -> float:
        members = [i for i in state.active if self.contacts.groups[i] == group]
        return self.contacts.cohesion_n * h * len(members)

    def _impulses(
        self, state: ContactState, u_free: Array, u_before: Array, h: float
    ) -> Array | None:
        """Return the impulses for which the state's equalities hold; None if there are none."""
        data, count, size = self.contacts, len(self.contacts.groups), len(u_free)
        closed = list(state.closed)
        fixed, columns, unknown = np.zeros(size), np.eye(size), [*closed]
        for group, motion in zip(state.groups, state.tangent, strict=True):
            if motion == STICK:
                unknown.append(count + group)
                continue
            fixed[count + group] -= motion * self._cohesion_ns(state, group, h)
            for i in closed:
                if data.groups[i] == group:
                    columns[i, count + group] -= motion * data.friction
        if not unknown:
            return fixed
        targets = np.zeros(len(unknown))
        targets[: len(closed)] = -data.restitution * u_before[closed]
        basis, rows = columns[unknown].T, self.compliance[unknown]
        try:
            found = np.linalg.solve(rows @ basis, targets - (u_free[unknown] + rows @ fixed))
        except np.linalg.LinAlgError:
            return None
        return fixed + basis @ found

    def _fits(
        self,
        state: ContactState,
        impulses: Array,
        after: Array,
        velocities: tuple[Array, Array],
        h: float,
    ) -> bool:
        """Return whether the inequalities of the state hold."""
        data, count = self.contacts, len(self.contacts.groups)
        before = velocities[1]
        speed = _ROUNDING * max(float(np.abs(u).max()) for u in (after, *velocities))
        size = _ROUNDING * float(np.abs(impulses).max())
        if any(impulses[i] < -size for i in state.closed):
            return False
        if any(after[i] + data.restitution * before[i] < -speed for i in state.active):
            return False
        for group, motion in zip(state.groups, state.tangent, strict=True):
            members = [i for i in state.closed if data.groups[i] == group]
            limit = data.friction * float(sum(impulses[i] for i in members))
            limit += self._cohesion_ns(state, group, h)
            if motion == STICK:
                if abs(impulses[count + group]) > limit + size:
                    return False
            elif motion * after[count + group] < -speed:
                return False
        return True


@dataclass(frozen=True, slots=True, kw_only=True)
class LcpHistory:
    """Response; n times.

    Attributes:
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


def moreau_jean(
    matrices: tuple[Array, Array, Array], contacts: RigidContacts, mean_loads_n: Array, h_s: float
) -> LcpHistory:
    """Step a linear structure with rigid contacts from rest.

    Args:
        matrices: Mass, damping and stiffness.
        contacts: The contacts.
        mean_loads_n: Mean external load over each step, shape (steps, dofs).
        h_s: Time step.

    Raises:
        SolutionError: A step has no solution.
    """
    mass, damping, stiffness = matrices
    steps, dofs = mean_loads_n.shape
    rows = np.vstack([contacts.normal_rows, contacts.tangent_rows])
    iteration = cho_factor(mass + h_s * _THETA * damping + (h_s * _THETA) ** 2 * stiffness)
    spread = np.asarray(cho_solve(iteration, rows.T))
    solver = ImpactSolver(contacts, rows @ spread)
    # Free velocity = keep @ v + pull @ q + push @ load.
    inverse = np.asarray(cho_solve(iteration, np.eye(dofs)))
    keep = np.eye(dofs) - h_s * inverse @ (damping + _THETA * h_s * stiffness)
    pull, push = -h_s * inverse @ stiffness, mean_loads_n @ (h_s * inverse).T
    count = len(contacts.groups)
    q, v, normal, tangent = (
        np.zeros((steps + 1, width)) for width in (dofs, dofs, count, len(rows) - count)
    )
    work = 0.0
    for k in range(steps):
        free = keep @ v[k] + pull @ q[k] + push[k]
        u_before = rows @ v[k]
        forecast = contacts.gaps_m + contacts.normal_rows @ q[k] + 0.5 * h_s * u_before[:count]
        if forecast.min() <= 0.0:
            active = tuple(np.flatnonzero(forecast <= 0.0).tolist())
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
