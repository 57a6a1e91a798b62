"""Contact checks that every study runs before its first analysis, in a few seconds.

The contact law and OpenSees units are compared with closed forms and the tabulated response of a
deck. The full comparison is `skewbridge verify`.
"""

from dataclasses import replace
from math import degrees, hypot, pi

import numpy as np
import pandas as pd

from skewbridge.contact.drives import kelvin_voigt_damping_ratio, kelvin_voigt_restitution
from skewbridge.contact.law import advance_pair
from skewbridge.verification.references import blocks, closed_forms
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import run_deck
from skewbridge.verification.references.driven_unit import PAPER_LAW, drive_unit
from skewbridge.verification.registry import Study


def verify_contact_gate() -> pd.DataFrame:
    """Check the contact law and a live unit in a few seconds; one row per comparison."""
    study = Study("gate")
    run(study)
    return study.table()


def run(study: Study) -> None:
    """Run the study."""
    closed = advance_pair(PAPER_LAW, (0.0, 0.0), (0.3, 0.4), -0.1)
    slip_n, ratio = hypot(*closed.force_n), closed.force_n[0] / closed.force_n[1]
    study.relative("slip force (N)", slip_n, 1500.0 + 0.3 * 1e4, 1e-12, "cone")
    study.absolute("direction of the slip force", ratio, 0.75, 1e-12, "cone")
    opened = advance_pair(PAPER_LAW, (0.0, 0.0), (0.3, 0.4), 1e-9)
    study.absolute("friction while open (N)", opened.force_n[0], 0.0, 0.0, "cone")
    restitution = kelvin_voigt_restitution(kelvin_voigt_damping_ratio(0.6))
    study.absolute("restitution of the clipped damper", restitution, 0.6, 1e-9, "B4")
    _check_paths(study)
    _check_block(study)
    history = run_deck(deck_case("C1", solver="opensees", dt_s=2.5e-4, duration_s=1.5))
    peaks = history.peaks()
    source = "penalty ODE, docs/theory/verification.md"
    study.relative("C1 peak ux (m)", peaks["ux_m"], 18.673e-3, 0.01, source)
    study.relative("C1 peak uy (m)", peaks["uy_m"], 34.361e-3, 0.01, source)
    study.relative("C1 peak theta (rad)", peaks["theta_rad"], 3.9120e-4, 0.02, source)
    residual = abs(history.energy_residual_ratio)
    study.at_most("C1 energy residual over input", residual, 1e-6, "balance")


def _check_paths(study: Study) -> None:
    radius, elastic_slip = 0.2, 0.045
    path = unit.circle(radius, period_s=4.0, loops=2, rows_per_loop=500, opening_m=-0.1)
    forces = drive_unit(PAPER_LAW, path, substeps=25).forces_n
    last = slice(len(path) // 2, None)
    velocity = np.gradient(path[last, 1:3], axis=0)
    angle = np.arctan2(*forces[last, 1::-1].T) - np.arctan2(*velocity[:, ::-1].T)
    lag = float(np.median(np.angle(np.exp(-1j * angle))))
    exact = degrees(closed_forms.circular_path_lag_rad(radius, elastic_slip))
    study.relative("lag on a circle (deg)", degrees(lag), exact, 5e-3, "B6")
    work = unit.path_work_j(path[last], forces[last])
    exact = closed_forms.circular_path_work_j(radius, elastic_slip, 4500.0)
    study.relative("work per circle (J)", work, exact, 5e-3, "B6")
    loop = unit.straight_loop(0.5, rows=400, opening_m=-0.1)
    forces, last = drive_unit(PAPER_LAW, loop, substeps=2).forces_n, slice(len(loop) // 2, None)
    work = unit.path_work_j(loop[last], forces[last])
    exact = closed_forms.straight_loop_work_j(0.5, elastic_slip, 4500.0)
    study.relative("work per straight loop (J)", work, exact, 5e-3, "B7")
    jump = path.copy()
    jump[:, 3] = np.where(np.sin(2 * pi * path[:, 0] / 2.5) > 0.0, 0.1, -0.1)
    got = drive_unit(PAPER_LAW, jump).forces_n
    expected = unit.follow_law(PAPER_LAW, jump, substeps=20)
    error = unit.rms_n((got - expected)[:, :2]) / 4500.0
    study.at_most("RMS error with openings, over the limit", error, 1e-2, "radial return")
    study.at_most("tension (N)", max(0.0, float(-got[:, 2].min())), 0.0, "no tension")
    loose_n = float(np.abs(got[jump[:, 3] > 0.0, :2]).max())
    study.at_most("friction while open (N)", loose_n, 0.0, "no friction")


def _check_block(study: Study) -> None:
    k, friction_n, g = 4e4, 1962.0, blocks.TABLE_G_MPS2
    block = replace(blocks.sliding_block(0.2, kt_n_per_m=1e9), spring_n_per_m=k, x0_m=0.5)
    x = blocks.run_block(block, 1e-3, 1.2).position_m[:, 0]
    points = closed_forms.free_decay_turning_points(0.5, friction_n / k)
    study.relative("first turning point (m)", float(x.min()), points[1], 5e-3, "B1")
    slid = blocks.run_block(
        blocks.sliding_block(0.2),
        5e-4,
        0.8,
        base_mps2=lambda t: 0.5 * g * (np.sign(0.2 - t - 1e-9) + 1.0) / 2.0,
    )
    slip_m = float(-slid.position_m[-1, 0])
    exact_m = closed_forms.rectangular_pulse_slip(0.5 * g, 0.2, 0.2 * g)
    study.relative("slip under a rectangular pulse (m)", slip_m, exact_m, 1e-2, "B3")
    depth_m = float(-blocks.run_block(blocks.falling_block(), 2e-4, 0.05).position_m[:, 1].min())
    exact_m, _ = closed_forms.falling_mass_impact(1000.0, 1e7, 1.0, g)
    study.relative("deepest penetration (m)", depth_m, exact_m, 5e-3, "B5")
