"""The rigid skew deck in OpenSees, with the contact units of the contact package."""

from collections.abc import Callable
from typing import Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact import ContactSet, Drive
from skewbridge.contact.drives import kelvin_voigt_drive
from skewbridge.verification.references.case_files import DeckCase
from skewbridge.verification.references.deck_model import (
    CORNERS,
    Deck,
    DeckHistory,
    EnergyBalance,
    Excitation,
)
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
FIRST_CORNER: Final = 11
FIRST_WALL: Final = 21
_INTEGRATORS: Final[dict[str, tuple[str | float, ...]]] = {
    "newmark": ("Newmark", 0.5, 0.25),
    "houbolt": ("Houbolt",),
    "hht": ("HHT", 0.8),
}

type Connect = Callable[[int, list[int], DeckCase], None]


def run_opensees(
    case: DeckCase,
    deck: Deck,
    excitation: Excitation,
    *,
    connect: Connect | None = None,
    parts_on_change: int = 1,
) -> DeckHistory:
    """Run a deck case in OpenSees.

    Args:
        case: The case.
        deck: Its numbers.
        excitation: Ground acceleration.
        connect: Connects the centre node to the corner nodes; by default rigid links.
        parts_on_change: Parts of a step in which a contact is expected to open or close.

    Raises:
        SolutionError: A step does not converge.
    """
    with clean_domain():
        build_deck(deck)
        (connect or rigid_links)(CENTRE, [FIRST_CORNER + k for k in range(len(CORNERS))], case)
        contacts = _contacts(case, deck)
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
    balance, response = EnergyBalance(deck), (q, v, openings, normals, friction)
    balance.add(response, accel)
    return balance.history(times, response)


def build_deck(deck: Deck, wall_offset_m: float = 0.0) -> None:
    """Define the mass centre on its bearings, the corners and, at an offset, their walls."""
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
    for k, corner in enumerate(deck.corners):
        (x, y), (nx, ny) = (corner.x_m, corner.y_m), corner.normal
        ops.node(FIRST_CORNER + k, x, y)
        ops.node(FIRST_WALL + k, x - wall_offset_m * nx, y - wall_offset_m * ny)
        ops.fix(FIRST_WALL + k, 1, 1, 1)


def rigid_links(centre: int, corners: list[int], case: DeckCase) -> None:
    """Connect the mass centre to the corners by rigid links."""
    del case
    for corner in corners:
        ops.rigidLink("beam", centre, corner)


def _contacts(case: DeckCase, deck: Deck) -> ContactSet:
    contacts = ContactSet(coupling=case.coupling)
    drive: Drive | None = None
    kn, dashpot = case.normal_stiffness_n_per_m, deck.dashpot_n_s_per_m
    if dashpot > 0.0:
        drive = kelvin_voigt_drive(kn_n_per_m=kn, dashpot_n_s_per_m=dashpot)
    for k, corner in enumerate(deck.corners):
        contacts.add(
            FIRST_WALL + k,
            FIRST_CORNER + k,
            corner.normal,
            case.gap_normal_m,
            case.friction,
            case.cohesion_n,
            kn=kn,
            kt=case.kt_n_per_m,
            drive=drive,
            name=corner.name,
        )
    return contacts


def excite_deck(case: DeckCase, excitation: Excitation) -> tuple[Array, Array]:
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
