"""Rigid contact with restitution and Coulomb friction by Moreau-Jean time stepping.

Linear structures M v' + C v + K q = f with frictional unilateral contacts. The smooth part is
stepped by the theta method, contact acts by impulses over the step, with Newton's restitution on
the velocity level and no tangential restitution (`impact`).

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics;
    Jean (1999), Computer Methods in Applied Mechanics and Engineering 177;
    Acary and Brogliato (2008), Numerical Methods for Nonsmooth Dynamical Systems, chapter 10.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from skewbridge.verification.references.impact import ImpactSolver, RigidContacts
from skewbridge.verification.references.live_model import Array

_THETA: Final = 0.5


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
