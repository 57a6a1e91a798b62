"""Contact checks that every study runs before its first analysis, in a few seconds.

The contact law and OpenSees units are compared with closed forms and the tabulated response of a
deck. The full comparison is `skewbridge verify`.
"""

from dataclasses import replace
from math import degrees, hypot, pi

import numpy as np
import pandas as pd

from skewbridge.contact.law import advance_pair
from skewbridge.contact.restitution import kelvin_voigt_damping_ratio, kelvin_voigt_restitution
from skewbridge.verification.references.blocks import (
    TABLE_G_MPS2,
    falling_block,
    run_block,
    sliding_block,
)
from skewbridge.verification.references.cases import C1, deck_case
from skewbridge.verification.references.closed_forms import (
    circular_path_lag_rad,
    circular_path_work_j,
    falling_mass_impact,
    free_decay_turning_points,
    rectangular_pulse_slip,
    straight_loop_work_j,
)
from skewbridge.verification.references.deck_solvers import run_deck
from skewbridge.verification.references.driven_unit import (
    PAPER_LAW,
    circle,
    drive_unit,
    follow_law,
    path_work_j,
    rms_n,
    straight_loop,
)
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.studies.comparison import Study


def verify_contact_gate() -> pd.DataFrame:
    """Check the contact law and a live unit in a few seconds; one row per comparison."""
    study = Study("gate")
    run(study)
    return study.table()


def run(study: Study) -> None:
    """Run the study."""
    _check_law(study)
    _check_paths(study)
    _check_block(study)
    _check_deck(study)


def _check_law(study: Study) -> None:
    closed = advance_pair(PAPER_LAW, (0.0, 0.0), (0.3, 0.4), -0.1)
    slip_n, ratio = hypot(closed.force_1_n, closed.force_2_n), closed.force_1_n / closed.force_2_n
    study.relative("slip force (N)", slip_n, 1500.0 + 0.3 * 1e4, 1e-12, "cone")
    study.absolute("direction of the slip force", ratio, 0.75, 1e-12, "cone")
    opened = advance_pair(PAPER_LAW, (0.0, 0.0), (0.3, 0.4), 1e-9)
    study.absolute("friction while open (N)", opened.force_1_n, 0.0, 0.0, "cone")
    restitution = kelvin_voigt_restitution(kelvin_voigt_damping_ratio(0.6))
    study.absolute("restitution of the clipped damper", restitution, 0.6, 1e-9, "B4")


def _check_paths(study: Study) -> None:
    radius, elastic_slip = 0.2, 0.045
    path = circle(radius, period_s=4.0, loops=2, rows_per_loop=500, opening_m=-0.1)
    forces = drive_unit(PAPER_LAW, path, substeps=25).forces_n
    last = slice(len(path) // 2, None)
    velocity = np.gradient(path[last, 1:3], axis=0)
    angle = np.arctan2(*forces[last, 1::-1].T) - np.arctan2(*velocity[:, ::-1].T)
    lag = float(np.median(np.angle(np.exp(-1j * angle))))
    exact = degrees(circular_path_lag_rad(radius, elastic_slip))
    study.relative("lag on a circle (deg)", degrees(lag), exact, 5e-3, "B6")
    work = path_work_j(path[last], forces[last])
    exact = circular_path_work_j(radius, elastic_slip, 4500.0)
    study.relative("work per circle (J)", work, exact, 5e-3, "B6")
    loop = straight_loop(0.5, rows=400, opening_m=-0.1)
    forces, last = drive_unit(PAPER_LAW, loop, substeps=2).forces_n, slice(len(loop) // 2, None)
    work = path_work_j(loop[last], forces[last])
    exact = straight_loop_work_j(0.5, elastic_slip, 4500.0)
    study.relative("work per straight loop (J)", work, exact, 5e-3, "B7")
    jump = path.copy()
    jump[:, 3] = np.where(np.sin(2 * pi * path[:, 0] / 2.5) > 0.0, 0.1, -0.1)
    got, expected = drive_unit(PAPER_LAW, jump).forces_n, follow_law(PAPER_LAW, jump, substeps=20)
    error = rms_n((got - expected)[:, :2]) / 4500.0
    study.at_most("RMS error with openings, over the limit", error, 1e-2, "radial return")
    study.at_most("tension (N)", max(0.0, float(-got[:, 2].min())), 0.0, "no tension")
    loose_n = float(np.abs(got[jump[:, 3] > 0.0, :2]).max())
    study.at_most("friction while open (N)", loose_n, 0.0, "no friction")


def _check_block(study: Study) -> None:
    k, friction_n = 4e4, 1962.0
    block = replace(sliding_block(0.2, kt_n_per_m=1e9), spring_n_per_m=k, x0_m=0.5)
    x = run_block(block, 1e-3, 1.2).position_m[:, 0]
    points = free_decay_turning_points(0.5, friction_n / k)
    study.relative("first turning point (m)", float(x.min()), points[1], 5e-3, "B1")
    amplitude, duration, mu = 0.5 * TABLE_G_MPS2, 0.2, 0.2

    def pulse_mps2(t: Array) -> Array:
        return amplitude * (np.sign(duration - t - 1e-9) + 1.0) / 2.0

    slid = run_block(sliding_block(mu), 5e-4, 0.8, base_mps2=pulse_mps2)
    slip_m = float(-slid.position_m[-1, 0])
    exact_m = rectangular_pulse_slip(amplitude, duration, mu * TABLE_G_MPS2)
    study.relative("slip under a rectangular pulse (m)", slip_m, exact_m, 1e-2, "B3")
    depth_m = float(-run_block(falling_block(), 2e-4, 0.05).position_m[:, 1].min())
    exact_m = falling_mass_impact(1000.0, 1e7, 1.0, TABLE_G_MPS2).penetration_m
    study.relative("deepest penetration (m)", depth_m, exact_m, 5e-3, "B5")


def _check_deck(study: Study) -> None:
    history = run_deck(deck_case(C1, solver="opensees", dt_s=2.5e-4, duration_s=1.5))
    peaks = history.peaks()
    source = "penalty ODE, docs/theory/verification.md"
    study.relative("C1 peak ux (m)", peaks["ux_m"], 18.673e-3, 0.01, source)
    study.relative("C1 peak uy (m)", peaks["uy_m"], 34.361e-3, 0.01, source)
    study.relative("C1 peak theta (rad)", peaks["theta_rad"], 3.9120e-4, 0.02, source)
    residual = abs(history.energy_residual_ratio)
    study.at_most("C1 energy residual over input", residual, 1e-6, "balance")
