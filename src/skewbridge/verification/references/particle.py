"""A particle between two parallel inclined lines, on an isotropic support: OpenSees and LCP."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact import ContactSet, UnitLedger
from skewbridge.contact.drives import kelvin_voigt_drive
from skewbridge.contact.restitution import kelvin_voigt_damping_ratio
from skewbridge.verification.references.lcp import LcpHistory, RigidContacts, moreau_jean
from skewbridge.verification.references.live_model import (
    Array,
    Solver,
    clean_domain,
    even_times,
    march,
    shake_base,
)

_GROUND: Final = 1
_PARTICLE: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Particle:
    """The study of Figure 4.

    Attributes:
        period_s: Of the isotropic support.
        damping_ratio: Of the support.
        half_gap_m: Distance of each line from the origin.
        slope_deg: Inclination of the lines.
        friction: Coulomb coefficient.
        restitution: 1 is elastic.
        kn_n_per_m: Normal and tangential penalty in OpenSees.
        pulse_s: Period and length of the cosine pulse of the base.
        pulse_mps2: Its amplitude along x and y.
    """

    # ASSUME mass, support and restitution: the paper gives gap, slope, pulse, friction, damping.
    mass_kg: float = 1000.0
    period_s: float = 1.0
    damping_ratio: float = 0.05
    half_gap_m: float = 0.0268
    slope_deg: float = 30.0
    friction: float = 0.1
    restitution: float = 0.6
    kn_n_per_m: float = 1.0e9
    pulse_s: float = 0.5
    pulse_mps2: tuple[float, float] = (4.905, 14.715)

    @property
    def normal(self) -> tuple[float, float]:
        """Normal of the lines, upwards."""
        slope = radians(self.slope_deg)
        return -sin(slope), cos(slope)

    @property
    def tangent(self) -> tuple[float, float]:
        """Direction along the lines."""
        slope = radians(self.slope_deg)
        return cos(slope), sin(slope)

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness of the support."""
        return self.mass_kg * (2.0 * pi / self.period_s) ** 2

    @property
    def dashpot_n_s_per_m(self) -> float:
        """Damping of the support."""
        return 2.0 * self.damping_ratio * self.mass_kg * 2.0 * pi / self.period_s

    def mean_accel(self, starts_s: Array, ends_s: Array) -> Array:
        """Return the mean base acceleration over intervals, shape (n, 2)."""
        w = 2.0 * pi / self.pulse_s
        low, high = np.clip(starts_s, 0.0, self.pulse_s), np.clip(ends_s, 0.0, self.pulse_s)
        shape = (np.sin(w * high) - np.sin(w * low)) / w / (ends_s - starts_s)
        return shape[:, None] * np.array(self.pulse_mps2)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleHistory:
    """Response; n times.

    Attributes:
        position_m: Along x and y, shape (n, 2).
        friction_n: Along the lines, with the sign of slip: lower and upper line, shape (n, 2).
        normal_n: Compression of the lower and upper line, shape (n, 2).
        ledgers: Accounts of the two units.
    """

    t_s: Array
    position_m: Array
    friction_n: Array
    normal_n: Array
    ledgers: list[UnitLedger]


def run_particle(
    particle: Particle, dt_s: float, duration_s: float, keep: Callable[[int], bool]
) -> ParticleHistory:
    """Run the particle in OpenSees by the trapezoidal rule; keep the steps that `keep` accepts.

    Raises:
        SolutionError: A step does not converge.
    """
    times = even_times(duration_s, dt_s)
    with clean_domain():
        contacts = _model(particle)
        accel = particle.mean_accel(times - 0.5 * dt_s, times + 0.5 * dt_s)
        accel[0] = particle.pulse_mps2
        shake_base(_PARTICLE, dt_s, accel.T)
        Solver(constraints="Plain").prepare()
        rows: list[list[float]] = [[0.0] * 7]
        for k in march(contacts, times, dt_s):
            if keep(k):
                (lower, _), (upper, _) = contacts.tangentials_n
                # The unit of the lower line counts slip along minus the tangent.
                forces = [-lower, upper, *contacts.normals_n]
                rows.append([float(times[k]), *ops.nodeDisp(_PARTICLE), *forces])
        ledgers = contacts.ledger()
    table = np.array(rows)
    return ParticleHistory(
        t_s=table[:, 0],
        position_m=table[:, 1:3],
        friction_n=table[:, 3:5],
        normal_n=table[:, 5:7],
        ledgers=ledgers,
    )


def run_particle_lcp(particle: Particle, h_s: float, duration_s: float) -> LcpHistory:
    """Run the particle with rigid contacts by Moreau-Jean time stepping."""
    m, k, c = particle.mass_kg, particle.stiffness_n_per_m, particle.dashpot_n_s_per_m
    n, t = np.array(particle.normal), np.array(particle.tangent)
    contacts = RigidContacts(
        normal_rows=np.array([n, -n]),
        gaps_m=np.full(2, particle.half_gap_m),
        tangent_rows=np.array([t, t]),
        groups=(0, 1),
        friction=particle.friction,
        cohesion_n=0.0,
        restitution=particle.restitution,
    )
    times = even_times(duration_s, h_s)
    loads = -m * particle.mean_accel(times[:-1], times[1:])
    eye = np.eye(2)
    return moreau_jean((m * eye, c * eye, k * eye), contacts, loads, h_s)


def _model(particle: Particle) -> ContactSet:
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    ops.node(_GROUND, 0.0, 0.0)
    ops.node(_PARTICLE, 0.0, 0.0)
    ops.fix(_GROUND, 1, 1)
    ops.mass(_PARTICLE, particle.mass_kg, particle.mass_kg)
    ops.uniaxialMaterial("Elastic", 1, particle.stiffness_n_per_m, particle.dashpot_n_s_per_m)
    ops.element("zeroLength", 1, _GROUND, _PARTICLE, "-mat", 1, 1, "-dir", 1, 2)
    contacts = ContactSet()
    drive = None
    if particle.restitution < 1.0:
        ratio = kelvin_voigt_damping_ratio(particle.restitution)
        dashpot = 2.0 * ratio * (particle.kn_n_per_m * particle.mass_kg) ** 0.5
        drive = kelvin_voigt_drive(kn_n_per_m=particle.kn_n_per_m, dashpot_n_s_per_m=dashpot)
    (nx, ny), kn = particle.normal, particle.kn_n_per_m
    for normal, name in (((nx, ny), "lower line"), ((-nx, -ny), "upper line")):
        contacts.add(
            _GROUND,
            _PARTICLE,
            normal,
            particle.half_gap_m,
            particle.friction,
            kn=kn,
            kt=kn,
            drive=drive,
            name=name,
        )
    return contacts
