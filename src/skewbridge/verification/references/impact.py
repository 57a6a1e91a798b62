"""Impulses of one step of rigid contact: a small complementarity problem.

    0 <= P_N  perp  (U_N+ + e U_N-) >= 0,      P_T in -(mu P_N + c h) sgn(U_T+)

Contacts that share a tangent (the two corners of an end of the deck) share one friction impulse:
their tangential velocities are the same, so the split between them is not determined. The problem
is solved by trying the contact states, the last one first: at most two contacts are active at a
time in these studies, so that there are few. Cohesion acts at every contact that is active, with
or without compression: otherwise a contact that only touches could have no solution.
"""

from collections.abc import Generator
from dataclasses import dataclass, field
from itertools import product
from typing import Final

import numpy as np

from skewbridge.errors import SolutionError
from skewbridge.verification.references.live_model import Array

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

    @property
    def has_friction(self) -> bool:
        """Whether there is any tangential force."""
        return self.friction > 0.0 or self.cohesion_n > 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactState:
    """A guess: which contacts are closed, and how each group moves along its tangent."""

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
        """Return the normal and tangential impulses (with the sign of slip).

        Args:
            active: Contacts whose gaps are closed.
            u_free: Velocities after the step without contact; normals, then groups.
            u_before: Velocities before the step.
            h: Step.

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
        groups = tuple(sorted({self.contacts.groups[i] for i in active}))
        motions = (STICK, SLIP_FORWARD, SLIP_BACKWARD) if self.contacts.has_friction else (STICK,)
        for normal in product((CLOSED, OPEN), repeat=len(active)):
            for tangent in product(motions, repeat=len(groups)):
                yield ContactState(active=active, normal=normal, groups=groups, tangent=tangent)

    def _cohesion_ns(self, state: ContactState, group: int, h: float) -> float:
        members = [i for i in state.active if self.contacts.groups[i] == group]
        return self.contacts.cohesion_n * h * len(members)

    def _impulses(
        self, state: ContactState, u_free: Array, u_before: Array, h: float
    ) -> Array | None:
        """Return the impulses for which the state's equalities hold; None if there are none."""
        data, count, size = self.contacts, len(self.contacts.groups), len(u_free)
        fixed = np.zeros(size)
        columns: list[Array] = []
        rows: list[int] = []
        for i in state.closed:
            columns.append(_unit(i, size))
            rows.append(i)
        targets = [-data.restitution * float(u_before[i]) for i in rows]
        for group, motion in zip(state.groups, state.tangent, strict=True):
            if not data.has_friction:
                continue
            if motion == STICK:
                columns.append(_unit(count + group, size))
                rows.append(count + group)
                targets.append(0.0)
                continue
            fixed[count + group] -= motion * self._cohesion_ns(state, group, h)
            for k, i in enumerate(state.closed):
                if data.groups[i] == group:
                    columns[k][count + group] -= motion * data.friction
        if not columns:
            return fixed
        basis = np.array(columns).T
        system = self.compliance[rows] @ basis
        known = u_free[rows] + self.compliance[rows] @ fixed
        try:
            unknown = np.linalg.solve(system, np.array(targets) - known)
        except np.linalg.LinAlgError:
            return None
        return fixed + basis @ unknown

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
        if not data.has_friction:
            return True
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


def _unit(index: int, size: int) -> Array:
    column = np.zeros(size)
    column[index] = 1.0
    return column
