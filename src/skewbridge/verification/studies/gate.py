"""The gate of the workflow: nothing is analysed with a broken contact law.

A few seconds of the law itself and of live OpenSees units against closed forms and the tabulated
deck response. The full comparison is `skewbridge verify`.
"""

from math import degrees, pi
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.contact import ContactLaw
from skewbridge.contact.law import advance_pair
from skewbridge.contact.restitution import kelvin_voigt_damping_ratio, kelvin_voigt_restitution
from skewbridge.verification.references.block import Block, run_block
from skewbridge.verification.references.closed_forms import (
    circular_path_lag_rad,
    circular_path_work_j,
    falling_mass_impact,
    free_decay_turning_points,
    rectangular_pulse_slip,
    straight_loop_work_j,
)
from skewbridge.verification.references.deck import run_deck
from skewbridge.verification.references.deck_cases import C1, deck_case
from skewbridge.verification.references.paths import circle, straight_loop
from skewbridge.verification.references.unit_path import drive_unit, follow_law, path_work_j
from skewbridge.verification.studies.comparison import Check, Checklist, StudyResult, table_of

_G: Final = 9.81  # source: value used in the reference computations
_LAW: Final = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3, cohesion_n=1500.0)


def verify_contact_gate() -> pd.DataFrame:
    """Check the contact law and a live contact unit in a few seconds.

    Returns:
        One row per check: study, quantity, value, reference, tolerance, pass, source.
    """
    return table_of(contact_gate_checks())


def contact_gate_checks() -> list[Check]:
    """Return the checks of the gate."""
    checks = Checklist("gate")
    _check_law(checks)
    _check_paths(checks)
    _check_block(checks)
    _check_deck(checks)
    return checks.checks


def _check_law(checks: Checklist) -> None:
    closed = advance_pair(_LAW, (0.0, 0.0), (0.3, 0.4), -0.1)
    limit = 1500.0 + 0.3 * 1e4
    checks.relative(
        "slip force (N)", float(np.hypot(closed.force_1_n, closed.force_2_n)), limit, 1e-12, "cone"
    )
    checks.absolute(
        "direction of the slip force", closed.force_1_n / closed.force_2_n, 0.75, 1e-12, "cone"
    )
    opened = advance_pair(_LAW, (0.0, 0.0), (0.3, 0.4), 1e-9)
    checks.absolute("friction while open (N)", opened.force_1_n, 0.0, 0.0, "cone")
    zeta = kelvin_voigt_damping_ratio(0.6)
    checks.absolute(
        "restitution of the clipped damper", kelvin_voigt_restitution(zeta), 0.6, 1e-9, "B4"
    )


def _check_paths(checks: Checklist) -> None:
    radius, elastic_slip = 0.2, 0.045
    path = circle(radius, period_s=4.0, loops=2, rows_per_loop=500, opening_m=-0.1)
    forces = drive_unit(_LAW, path, substeps=25).forces_n
    last = slice(len(path) // 2, None)
    velocity = np.gradient(path[last, 1:3], axis=0)
    angle = np.arctan2(*forces[last, 1::-1].T) - np.arctan2(*velocity[:, ::-1].T)
    lag = float(np.median(np.angle(np.exp(-1j * angle))))
    exact = degrees(circular_path_lag_rad(radius, elastic_slip))
    checks.relative("lag on a circle (deg)", degrees(lag), exact, 5e-3, "B6")
    work = path_work_j(path[last], forces[last])
    checks.relative(
        "work per circle (J)", work, circular_path_work_j(radius, elastic_slip, 4500.0), 5e-3, "B6"
    )
    loop = straight_loop(0.5, rows=400, opening_m=-0.1)
    loop_forces = drive_unit(_LAW, loop, substeps=2).forces_n
    last_loop = slice(len(loop) // 2, None)
    checks.relative(
        *("work per straight loop (J)", path_work_j(loop[last_loop], loop_forces[last_loop])),
        *(straight_loop_work_j(0.5, elastic_slip, 4500.0), 5e-3, "B7"),
    )
    jump = path.copy()
    jump[:, 3] = np.where(np.sin(2 * pi * path[:, 0] / 2.5) > 0.0, 0.1, -0.1)
    got, expected = drive_unit(_LAW, jump).forces_n, follow_law(_LAW, jump, substeps=20).forces_n
    error = np.sqrt(np.mean(np.sum((got - expected)[:, :2] ** 2, axis=1))) / 4500.0
    checks.at_most("RMS error with openings, over the limit", float(error), 1e-2, "radial return")
    checks.at_most("tension (N)", max(0.0, float(-got[:, 2].min())), 0.0, "no tension")
    is_open = jump[:, 3] > 0.0
    checks.at_most(
        "friction while open (N)", float(np.abs(got[is_open, :2]).max()), 0.0, "no friction"
    )


def _check_block(checks: Checklist) -> None:
    k, friction_n = 4e4, 1962.0
    block = Block(
        mass_kg=1000.0,
        kn_n_per_m=1e9,
        kt_n_per_m=1e9,
        friction=0.2,
        normal_load_n=9810.0,
        spring_n_per_m=k,
        x0_m=0.5,
    )
    history = run_block(block, 1e-3, 1.2)
    x = history.position_m[:, 0]
    points = free_decay_turning_points(0.5, friction_n / k)
    checks.relative("first turning point (m)", float(x.min()), points[1], 5e-3, "B1")
    amplitude, duration, mu = 0.5 * _G, 0.2, 0.2
    slid = run_block(
        Block(
            mass_kg=1000.0,
            kn_n_per_m=1e9,
            kt_n_per_m=1e10,
            friction=mu,
            normal_load_n=1000.0 * _G,
        ),
        5e-4,
        0.8,
        base_mps2=lambda t: amplitude * (np.sign(duration - t - 1e-9) + 1.0) / 2.0,
    )
    checks.relative(
        *("slip under a rectangular pulse (m)", float(-slid.position_m[-1, 0])),
        *(rectangular_pulse_slip(amplitude, duration, mu * _G), 1e-2, "B3"),
    )
    fall = run_block(
        Block(
            mass_kg=1000.0,
            kn_n_per_m=1e7,
            kt_n_per_m=1e7,
            normal_load_n=1000.0 * _G,
            v0_mps=(0.0, -1.0),
            bounces=True,
        ),
        2e-4,
        0.05,
    )
    exact = falling_mass_impact(1000.0, 1e7, 1.0, _G)
    checks.relative(
        *("deepest penetration (m)", float(-fall.position_m[:, 1].min())),
        *(exact.penetration_m, 5e-3, "B5"),
    )


def _check_deck(checks: Checklist) -> None:
    case = deck_case(C1, solver="opensees", dt_s=2.5e-4, duration_s=1.5)
    history = run_deck(case)
    peaks = history.peaks()
    source = "penalty ODE, docs/theory/verification.md"
    checks.relative("C1 peak ux (m)", peaks["ux_m"], 18.673e-3, 0.01, source)
    checks.relative("C1 peak uy (m)", peaks["uy_m"], 34.361e-3, 0.01, source)
    checks.relative("C1 peak theta (rad)", peaks["theta_rad"], 3.9120e-4, 0.02, source)
    checks.at_most(
        "C1 energy residual over input", abs(history.energy_residual_ratio), 1e-6, "balance"
    )


def gate_study() -> StudyResult:
    """Return the gate as a study."""
    return StudyResult(checks=contact_gate_checks())
