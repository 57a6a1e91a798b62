"""The rigid skew deck with rigid contacts: our own Moreau-Jean reference."""

from math import ceil
from typing import Final

import numpy as np

from skewbridge.verification.references.case_files import DeckCase
from skewbridge.verification.references.deck_model import (
    Deck,
    DeckHistory,
    Excitation,
)
from skewbridge.verification.references.lcp import LcpHistory, RigidContacts, moreau_jean
from skewbridge.verification.references.live_model import Array, even_times

# At this step the tabulated peaks with e <= 0.6 are within 0.05 % of the converged ones.
_LARGEST_STEP_S: Final = 2.0e-5


def run_lcp(case: DeckCase, deck: Deck, excitation: Excitation) -> DeckHistory:
    """Run a deck case with Newton restitution (1 unless given) and Coulomb friction.

    The time stepping is of first order, so it is done in parts of the case's step.

    Raises:
        SolutionError: A step has no solution.
    """
    parts = max(1, ceil(case.dt_s / _LARGEST_STEP_S - 1e-9))
    times = even_times(case.duration_s, case.dt_s)
    fine = case.model_copy(
        update={"dt_s": case.dt_s / parts, "duration_s": case.dt_s * (len(times) - 1)}
    )
    history = lcp_history(fine, deck, excitation)
    q = history.q[::parts]
    openings = case.gap_normal_m + q @ deck.normal_rows.T
    # The friction impulse of an end is shared by its corners as the compression is.
    normals = _summed(history.normal_impulses_ns, parts) / case.dt_s
    tangents = _summed(history.tangent_impulses_ns, parts) / case.dt_s
    friction = np.zeros_like(normals)
    for end, members in enumerate((slice(0, 2), slice(2, 4))):
        total = normals[:, members].sum(axis=1)
        share = normals[:, members] / np.where(total > 0.0, total, 1.0)[:, None]
        friction[:, members] = share * tangents[:, end, None]
    return DeckHistory(
        t_s=times,
        q=q,
        openings_m=openings,
        normals_n=normals,
        tangentials_n=friction,
        energy_residual_ratio=_energy_residual(fine, deck, excitation, history),
    )


def lcp_history(case: DeckCase, deck: Deck, excitation: Excitation) -> LcpHistory:
    """Return positions, velocities and impulses of a deck case."""
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
    return moreau_jean(matrices, contacts, _loads(case, deck, excitation), case.dt_s)


def _summed(impulses_ns: Array, parts: int) -> Array:
    """Return the impulses of `parts` steps each; the first row is the start."""
    start, steps = impulses_ns[:1], impulses_ns[1:]
    return np.vstack([start, steps.reshape(len(steps) // parts, parts, -1).sum(axis=1)])


def _loads(case: DeckCase, deck: Deck, excitation: Excitation) -> Array:
    times = even_times(case.duration_s, case.dt_s)
    accel = excitation.mean(times[:-1], times[1:])
    loads = np.zeros((len(times) - 1, 3))
    loads[:, :2] = -np.array(deck.mass[:2]) * accel.T
    return loads


def _energy_residual(
    case: DeckCase, deck: Deck, excitation: Excitation, history: LcpHistory
) -> float:
    step = np.diff(history.q, axis=0)
    given = np.cumsum(np.sum(_loads(case, deck, excitation) * step, axis=1))
    mean_v = 0.5 * (history.v[1:] + history.v[:-1])
    lost = float(np.sum(np.array(deck.damping) * mean_v * step)) + history.contact_work_j
    q, v = history.q[-1], history.v[-1]
    kept = 0.5 * float(np.array(deck.mass) @ v**2 + np.array(deck.stiffness) @ q**2)
    largest = float(np.abs(given).max())
    return (float(given[-1]) - lost - kept) / largest if largest > 0.0 else 0.0
