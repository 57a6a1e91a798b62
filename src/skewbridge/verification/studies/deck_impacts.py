"""Studies of the rigid skew deck: a deck of beams, impacts one by one, locked rotation."""

from typing import Final

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.verification.references.case_files import DeckCase
from skewbridge.verification.references.deck import run_deck
from skewbridge.verification.references.deck_cases import C1, SCALE_M, deck_case
from skewbridge.verification.references.deck_model import CORNERS, DeckHistory, make_deck

# Members of the deck over the penalties: stiffer than this changes nothing.
_RIGIDITY: Final = 1.0e4
# Period of rotation of a locked deck: stiff against the corner springs at their lever arms.
_LOCKED_S: Final = 1.0e-5


def perimeter_beams(centre: int, corners: list[int], case: DeckCase) -> None:
    """Connect the mass centre to the corners by a perimeter of stiff beams and four spokes."""
    # ASSUME the paper's perimeter deck has its mass at the centre, tied by members as stiff.
    half = 0.5 * case.length_m
    axial = _RIGIDITY * case.normal_stiffness_n_per_m * half
    bending = axial * half * half / 3.0
    ops.geomTransf("Linear", 1)
    right_acute, right_obtuse, left_obtuse, left_acute = corners
    members = [
        (right_acute, right_obtuse),
        (right_obtuse, left_acute),
        (left_acute, left_obtuse),
        (left_obtuse, right_acute),
        *((centre, corner) for corner in corners),
    ]
    for element, (i, j) in enumerate(members, start=max(ops.getEleTags()) + 1):
        ops.element("elasticBeamColumn", element, i, j, 1.0, axial, bending, 1)


def impacts(history: DeckHistory) -> pd.DataFrame:
    """Return every impact of every corner: time, approach and rebound speed, restitution.

    Speeds are those of the steps before closing and after opening, in free flight.
    """
    dt = float(history.t_s[1] - history.t_s[0])
    rows: list[tuple[str, float, float, float]] = []
    for corner, opening in zip(CORNERS, history.openings_m.T, strict=True):
        closed = opening < 0.0
        starts = np.flatnonzero(closed[1:] & ~closed[:-1]) + 1
        ends = np.flatnonzero(~closed[1:] & closed[:-1]) + 1
        for start in starts.tolist():
            later = ends[ends > start]
            if start < 2 or len(later) == 0 or later[0] + 1 >= len(opening):
                continue
            end = int(later[0])
            approach = float(opening[start - 2] - opening[start - 1]) / dt
            rebound = float(opening[end + 1] - opening[end]) / dt
            if approach > 0.0:
                rows.append((corner, float(history.t_s[start]), approach, rebound / approach))
    return pd.DataFrame(rows, columns=["corner", "t_s", "approach_mps", "restitution"])


def numerical_restitution(steps: tuple[float, ...] = (0.05, 0.71, 1.5, 3.0)) -> pd.DataFrame:
    """Return the impacts of the elastic case C1 under Houbolt for step x contact frequency."""
    case = deck_case(C1)
    speed = contact_speed(case)
    tables: list[pd.DataFrame] = []
    for step in steps:
        changed = case.model_copy(update={"integrator": "houbolt", "dt_s": step / speed})
        tables.append(impacts(run_deck(changed)).assign(step_times_frequency=step))
    return pd.concat(tables, ignore_index=True)


def contact_speed(case: DeckCase) -> float:
    """Return the circular frequency of the deck on the two springs of an end."""
    return (2.0 * case.normal_stiffness_n_per_m / case.mass_kg) ** 0.5


def locked_rotation(
    relative_stiffnesses: tuple[float, ...] = (1e3, 1e4, 1e5), *, resolution: float = 0.1
) -> pd.DataFrame:
    """Return the distance of the damped penalty from the rigid deck when it cannot rotate.

    With the rotation locked, both corners of an end act as one contact, and the clipped
    Kelvin-Voigt penalty has to converge to the complementarity solution with the same
    restitution, 0.6. The relative stiffness is kn* = 2 Kn / (m w_p^2), the resolution the step
    times the contact frequency.

    Returns:
        RMS and largest difference of the normal displacement over the scale, first contact.
    """
    rigid = run_deck(deck_case(C1, solver="lcp", restitution=0.6, dt_s=1e-4))
    normal = np.array(make_deck(deck_case(C1)).corners[0].normal_row[:2])
    rows: list[dict[str, float]] = []
    pulse_speed = 4.0 * np.pi
    locked = {"restitution": 0.6, "period_theta_s": _LOCKED_S}
    for ratio in relative_stiffnesses:
        stiffness = ratio * 1000.0 * pulse_speed**2 / 2.0
        dt_s = resolution / (pulse_speed * ratio**0.5)
        case = deck_case(C1, normal_stiffness_n_per_m=stiffness, dt_s=dt_s, **locked)
        history = run_deck(case)
        soft = np.interp(rigid.t_s, history.t_s, history.q[:, :2] @ normal)
        error = (soft - rigid.q[:, :2] @ normal) / SCALE_M
        rows.append(
            {
                "relative_stiffness": ratio,
                "rms_ratio": float(np.sqrt(np.mean(error**2))),
                "max_ratio": float(np.abs(error).max()),
                "first_contact_s": history.first_contact_s() or np.nan,
            }
        )
    return pd.DataFrame(rows)
