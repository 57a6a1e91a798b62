"""A mass on a surface in OpenSees: slides, bounces, hangs on a spring, rides on a belt.

The plane model behind the closed forms B1 to B8: x along the surface, y along its normal, one
contact unit. Time steps and penalties are the caller's.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact import ContactSet, Coupling, Drive, Scheme, UnitLedger
from skewbridge.errors import SolutionError
from skewbridge.verification.references.live_model import (
    Array,
    History,
    Solver,
    clean_domain,
    even_times,
    hold_load,
    load_node,
    march,
    path_series,
)

_GROUND: Final = 1
_MASS: Final = 2
_ANCHOR: Final = 3
_SETTLING_S: Final = 1e-6
_G_MPS2: Final = 9.81  # source: value used in the reference computations


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A mass with one contact.

    Attributes:
        mass_kg: Mass along x; along y too if `bounces`.
        kn_n_per_m: Normal penalty; `kt_n_per_m` the tangential one.
        friction: Coulomb coefficient.
        normal_load_n: Constant load onto the surface.
        spring_n_per_m: Spring along x to an anchor.
        x0_m: Initial position along x; the spring is free at zero.
        v0_mps: Initial velocity (x, y).
        bounces: The mass has inertia along y; otherwise it rests on the surface from the start.
        drive: Drive of the contact; this, `scheme` and `coupling` as in `ContactSet`.
    """

    mass_kg: float
    kn_n_per_m: float
    kt_n_per_m: float
    friction: float = 0.0
    normal_load_n: float = 0.0
    spring_n_per_m: float = 0.0
    gap_m: float = 0.0
    x0_m: float = 0.0
    v0_mps: tuple[float, float] = (0.0, 0.0)
    bounces: bool = False
    drive: Drive | None = None
    scheme: Scheme = "vector"
    coupling: Coupling = "extrapolated"


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockHistory:
    """Response of a block; n times.

    Attributes:
        position_m: Along x and y, shape (n, 2), as is `velocity_mps`.
        friction_n: With the sign of slip, shape (n,).
        normal_n: Compression, shape (n,).
        ledger: Account of the contact.
    """

    t_s: Array
    position_m: Array
    velocity_mps: Array
    friction_n: Array
    normal_n: Array
    ledger: UnitLedger


def run_block(
    block: Block,
    dt_s: float,
    duration_s: float,
    *,
    force_n: History | None = None,
    base_mps2: History | None = None,
    anchor_m: History | None = None,
    integrator: tuple[str | float, ...] = ("Newmark", 0.5, 0.25),
) -> BlockHistory:
    """Run a block under a force along x, by the trapezoidal rule unless told otherwise.

    With an acceleration of the surface the motion is relative to it; the anchor is that of the
    spring. All three are functions of an array of times.

    Raises:
        SolutionError: A step does not converge.
    """
    times = even_times(duration_s, dt_s)
    with clean_domain():
        contacts = _model(block)
        force = np.zeros_like(times) if force_n is None else force_n(times)
        if base_mps2 is not None:
            force = force - block.mass_kg * base_mps2(times)
        hold_load(_MASS, 1, (0.0, -block.normal_load_n))
        load_node(_MASS, 2, dt_s, force, (1.0, 0.0))
        path_series(3, dt_s, np.zeros_like(times) if anchor_m is None else anchor_m(times))
        ops.pattern("Plain", 3, 3)
        ops.sp(_ANCHOR, 1, 1.0)
        Solver(tolerance_m=1e-13, integrator=integrator).prepare()
        _settle(block, contacts)
        rows = np.zeros((len(times), 6))
        rows[0] = _row(contacts)
        for k in march(contacts, times, dt_s):
            rows[k] = _row(contacts)
        ledger = contacts.ledger()[0]
    return BlockHistory(
        t_s=times,
        position_m=rows[:, :2],
        velocity_mps=rows[:, 2:4],
        friction_n=rows[:, 4],
        normal_n=rows[:, 5],
        ledger=ledger,
    )


def _model(block: Block) -> ContactSet:
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    for node in (_GROUND, _MASS, _ANCHOR):
        ops.node(node, 0.0, 0.0)
    ops.fix(_GROUND, 1, 1)
    ops.fix(_ANCHOR, 0, 1)
    ops.mass(_MASS, block.mass_kg, block.mass_kg if block.bounces else 0.0)
    ops.uniaxialMaterial("Elastic", 1, block.spring_n_per_m)
    ops.element("zeroLength", 1, _ANCHOR, _MASS, "-mat", 1, "-dir", 1)
    contacts = ContactSet(scheme=block.scheme, coupling=block.coupling)
    contacts.add(
        _GROUND,
        _MASS,
        (0.0, 1.0),
        block.gap_m,
        block.friction,
        kn=block.kn_n_per_m,
        kt=block.kt_n_per_m,
        drive=block.drive,
        name="block",
    )
    ops.setNodeDisp(_MASS, 1, block.x0_m, "-commit")
    for dof, speed in enumerate(block.v0_mps, start=1):
        ops.setNodeVel(_MASS, dof, speed, "-commit")
    return contacts


def _settle(block: Block, contacts: ContactSet) -> None:
    """Press the block onto the surface in a step too short for it to move along."""
    if block.bounces:
        return
    if ops.analyze(1, _SETTLING_S) != 0:
        raise SolutionError("the block does not settle on its surface")
    contacts.after_step(_SETTLING_S)
    contacts.start_from_rest()
    ops.setTime(0.0)


def _row(contacts: ContactSet) -> list[float]:
    # Slip is counted along the normal turned counter-clockwise, which is minus x.
    forces = [-contacts.tangentials_n[0][0], contacts.normals_n[0]]
    return [*ops.nodeDisp(_MASS), *ops.nodeVel(_MASS), *forces]


def sliding_block(friction: float, *, kt_n_per_m: float = 1e10) -> Block:
    """Return a block of 1000 kg that rests on a surface under its own weight."""
    return Block(
        mass_kg=1000.0,
        kn_n_per_m=1e9,
        kt_n_per_m=kt_n_per_m,
        friction=friction,
        normal_load_n=1000.0 * _G_MPS2,
    )


def falling_block() -> Block:
    """Return a mass of 1000 kg that meets a penalty of 10 MN/m at 1 m/s under its own weight."""
    return Block(
        mass_kg=1000.0,
        kn_n_per_m=1e7,
        kt_n_per_m=1e7,
        normal_load_n=1000.0 * _G_MPS2,
        v0_mps=(0.0, -1.0),
        bounces=True,
    )
