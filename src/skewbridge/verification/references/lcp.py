"""Rigid contact with restitution and Coulomb friction by Moreau-Jean time stepping.

Linear structures M v' + C v + K q = f with frictional unilateral contacts. The smooth part is
integrated by the theta method. Contact acts by one impulse per step, with Newton's restitution of
the normal velocity and no tangential restitution. The impulses of a step solve

    0 <= P_N  perp  (U_N+ + e U_N-) >= 0,      P_T in -(mu P_N + c h) sgn(U_T+)

Contacts that share a tangent (the two corners of an end of the deck) share one friction impulse:
their tangential velocities are equal, so the split between them is undetermined. The solver tries
the possible contact states, first that of the previous solution. At most two contacts are active
at a time in these studies, so there are few states. Cohesion acts at every active contact, even
without compression; otherwise a contact that only touches might have no solution.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics;
    Jean (1999), Computer Methods in Applied Mechanics and Engineering 177;
    Acary and Brogliato (2008), Numerical Methods for Nonsmooth Dynamical Systems, chapter 10.
"""

from collections.abc import Generator
from dataclasses import dataclass
from itertools import chain, product
from typing import Final, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from skewbridge.errors import SolutionError
from skewbridge.files.tables import Floats
from skewbridge.verification.references.live_model import History

_THETA: Final = 0.5
# Allowed violation of a condition (rounding), relative to the largest velocity or impulse.
_ROUNDING: Final = 1e-10


class State(NamedTuple):
    """Trial state: active contacts, contacts with an impulse, and slip sign of each group."""

    active: tuple[int, ...]
    closed: tuple[int, ...]
    slip: dict[int, int]  # 0 sticks


@dataclass(frozen=True, slots=True)
class RigidContacts:
    """Rigid contacts of a structure; the contacts of a group share one tangent.

    Opening = gap + normal row . q, slip = tangent row . q. Cohesion is per contact.
    """

    normal_rows: Floats
    gaps_m: Floats
    tangent_rows: Floats
    groups: tuple[int, ...]
    friction: float
    cohesion_n: float
    restitution: float

    def states(self, active: tuple[int, ...]) -> Generator[State]:
        """Yield the trial states of a step: subsets of active contacts and slips of groups."""
        has_friction = self.friction > 0.0 or self.cohesion_n > 0.0
        groups = sorted({self.groups[i] for i in active}) if has_friction else []
        for flags in product((True, False), repeat=len(active)):
            closed = tuple(i for i, flag in zip(active, flags, strict=True) if flag)
            for slip in product((0, 1, -1), repeat=len(groups)):
                yield State(active, closed, dict(zip(groups, slip, strict=True)))

    def impulses(
        self, state: State, compliance: Floats, u_free: Floats, u_before: Floats, h: float
    ) -> Floats | None:
        """Return the impulses of a state; None if it is singular or violates an inequality.

        Arrays have the normals, then the groups. `compliance` is velocity per impulse; `u_free` are
        velocities after a step of length h without contact, `u_before` those before it.
        """
        count, size, closed = len(self.groups), len(u_free), list(state.closed)
        impulses, directions, unknown = np.zeros(size), np.eye(size), [*closed]
        active = [self.groups[i] for i in state.active]
        cohesion_ns = {group: self.cohesion_n * h * active.count(group) for group in state.slip}
        for group, slip in state.slip.items():
            if slip == 0:
                unknown.append(count + group)
                continue
            impulses[count + group] -= slip * cohesion_ns[group]
            for i in closed:
                if self.groups[i] == group:
                    directions[i, count + group] -= slip * self.friction
        if unknown:
            targets = np.zeros(len(unknown))
            targets[: len(closed)] = -self.restitution * u_before[closed]
            basis, rows = directions[unknown].T, compliance[unknown]
            try:
                sizes = np.linalg.solve(rows @ basis, targets - (u_free[unknown] + rows @ impulses))
            except np.linalg.LinAlgError:
                return None
            impulses = impulses + basis @ sizes
        u_after = u_free + compliance @ impulses
        u_tol = _ROUNDING * max(float(np.abs(u).max()) for u in (u_after, u_free, u_before))
        rounding = -_ROUNDING * float(np.abs(impulses).max())
        opening = u_after + self.restitution * u_before
        if impulses[closed].min(initial=0.0) < rounding or opening[[*state.active]].min() < -u_tol:
            return None
        for group, slip in state.slip.items():
            normal = float(sum(impulses[i] for i in closed if self.groups[i] == group))
            limit = self.friction * normal + cohesion_ns[group]
            is_beyond = slip == 0 and abs(impulses[count + group]) > limit - rounding
            if is_beyond or slip * u_after[count + group] < -u_tol:
                return None
        return impulses


def moreau_jean(
    matrices: tuple[Floats, Floats, Floats],
    contacts: RigidContacts,
    mean_loads_n: Floats,
    h_s: float,
) -> History:
    """Integrate a linear structure (mass, damping, stiffness) with rigid contacts from rest.

    Loads are means over the steps, shape (steps, dofs); contact forces are means over the step
    before each time, friction per group. `SolutionError` if a step has no solution.
    """
    mass, damping, stiffness = matrices
    steps, dofs = mean_loads_n.shape
    rows = np.vstack([contacts.normal_rows, contacts.tangent_rows])
    iteration = cho_factor(mass + h_s * _THETA * damping + (h_s * _THETA) ** 2 * stiffness)
    spread = np.asarray(cho_solve(iteration, rows.T))
    compliance, state = rows @ spread, State((), (), {})
    # Velocity after a step without contact = keep @ v + pull @ q + push[step].
    inverse = np.asarray(cho_solve(iteration, np.eye(dofs)))
    v_matrix = np.eye(dofs) - h_s * inverse @ (damping + _THETA * h_s * stiffness)
    q_matrix, load_terms = -h_s * inverse @ stiffness, mean_loads_n @ (h_s * inverse).T
    count = len(contacts.groups)
    q, v, impulses = (np.zeros((steps + 1, width)) for width in (dofs, dofs, len(rows)))
    for k in range(steps):
        v_next = v_matrix @ v[k] + q_matrix @ q[k] + load_terms[k]
        u_before = rows @ v[k]
        openings_mid = contacts.gaps_m + contacts.normal_rows @ q[k] + 0.5 * h_s * u_before[:count]
        if openings_mid.min() <= 0.0:
            active = tuple(np.flatnonzero(openings_mid <= 0.0).tolist())
            previous = (state,) if state.active == active else ()
            for state in chain(previous, contacts.states(active)):
                step_impulses = contacts.impulses(state, compliance, rows @ v_next, u_before, h_s)
                if step_impulses is not None:
                    break
            else:
                raise SolutionError(f"no state of the contacts {active} satisfies the contact law")
            v_next = v_next + spread @ step_impulses
            impulses[k + 1] = np.concatenate([step_impulses[:count], -step_impulses[count:]])
        v[k + 1] = v_next
        q[k + 1] = q[k] + h_s * (_THETA * v_next + (1.0 - _THETA) * v[k])
    openings, forces = contacts.gaps_m + q @ contacts.normal_rows.T, impulses / h_s
    return History(h_s * np.arange(steps + 1), q, v, openings, forces[:, :count], forces[:, count:])
