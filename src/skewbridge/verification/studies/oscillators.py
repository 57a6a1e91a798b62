"""Blocks with friction and impacts against closed forms, and the restitution of integrators.

`run` compares oscillators with friction, impacts and a belt with their closed forms. In
`run_integrators` a mass meets an elastic contact at forty positions within a step. Whatever energy
it loses or gains is an artefact of the integrator: Houbolt at two steps per contact looks like a
restitution of 0.45 to 0.8, the range reported in the paper.
"""

from dataclasses import replace
from math import ceil, pi
from typing import Any, Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.contact.drives import (
    approach_stiffness_drive,
    hunt_crossley_drive,
    kelvin_voigt_drive,
    power_law_drive,
    stribeck_drive,
)
from skewbridge.contact.restitution import hunt_crossley_damping, kelvin_voigt_damping_ratio
from skewbridge.verification.references.blocks import (
    TABLE_G_MPS2,
    Block,
    BlockHistory,
    falling_block,
    run_block,
    sliding_block,
)
from skewbridge.verification.references.closed_forms import (
    belt_stick_slip,
    falling_mass_impact,
    forced_amplitude,
    free_decay_turning_points,
    power_law_penetration,
)
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

_MASS_KG: Final = 1000.0
_SPRING_N_PER_M: Final = 4.0e4
_FRICTION_N: Final = 1962.0
_OMEGA: Final = (_SPRING_N_PER_M / _MASS_KG) ** 0.5
_STEPS_PER_CYCLE: Final = 2000
# Frequency ratio and friction over force amplitude; away from r = 1/2, 1/4 ... where it fails.
FORCED: Final = ((0.7, 0.3), (1.2, 0.4), (1.5, 0.3), (2.0, 0.2))

PHASES: Final = 40
_FREE_STEPS: Final = 6
_INTEGRATORS: Final[dict[str, tuple[str | float, ...]]] = {
    "houbolt": ("Houbolt",),
    "newmark": ("Newmark", 0.5, 0.25),
}
# By step x contact frequency: Houbolt mean, least, largest; Newmark mean, least, largest.
# source: docs/theory/verification.md, own integration without OpenSees, 40 phases.
TABLE: Final = {
    0.1: (0.9984, 0.9972, 0.9996, 1.0000, 0.9988, 1.0012),
    0.3: (0.9738, 0.9665, 0.9802, 1.0001, 0.9895, 1.0106),
    0.5: (0.9255, 0.9043, 0.9447, 1.0004, 0.9712, 1.0286),
    0.7: (0.8695, 0.8686, 0.8703, 1.0013, 0.9505, 1.0509),
    1.0: (0.7947, 0.7473, 0.8427, 1.0056, 0.9037, 1.1076),
    1.5: (0.7049, 0.6453, 0.7635, 1.0244, 0.8130, 1.2363),
    2.0: (0.6525, 0.5341, 0.7679, 1.0000, 1.0000, 1.0000),
    3.0: (0.5961, 0.5635, 0.6291, 1.1670, 0.5710, 1.7426),
    5.0: (0.6255, 0.4092, 0.8374, 1.4281, 0.4224, 2.4052),
}
_WITHOUT_OPENSEES: Final = "same integrators without OpenSees (docs/theory/verification.md)"


def run(study: Study) -> None:
    """Run the study of closed forms."""
    decay = free_decay()
    points = free_decay_turning_points(0.5, _FRICTION_N / _SPRING_N_PER_M)
    for k, (found, exact) in enumerate(
        zip(turning_points(decay)[: len(points) - 1], points[1:], strict=False), start=1
    ):
        study.absolute(f"free decay: turning point {k} (m)", found, exact, 0.5e-3, "B1")
    for ratio, friction_ratio in FORCED:
        found, exact = forced_response(ratio, friction_ratio)
        text = f"forced, r = {ratio}, F/P = {friction_ratio}: amplitude (m)"
        study.relative(text, found, exact, 5e-3, "B2")
    _check_impacts(study)
    belt = belt_ride()
    exact_s = belt_stick_slip(
        _MASS_KG, _SPRING_N_PER_M, 0.4 * _MASS_KG * TABLE_G_MPS2, 0.3 * _MASS_KG * TABLE_G_MPS2, 0.1
    ).period_s
    text, source = "belt: period of stick-slip (s)", "B8, friction falling at once"
    study.relative(text, belt_period(belt), exact_s, 0.02, source)
    study.figures["histories"] = _history_figure(decay, belt, points)


def spring_block(**changes: Any) -> Block:
    """Return the oscillator of B1 and B2: 1000 kg, 40 kN/m, 1962 N of friction."""
    # The reversal of friction takes the time in which the mass moves twice its elastic slip,
    # which near a turning point grows with the root of that slip: hence the stiff kt of 1e10 N/m.
    block = sliding_block(0.2, kt_n_per_m=1e10)
    return replace(block, spring_n_per_m=_SPRING_N_PER_M, **changes)


def free_decay() -> BlockHistory:
    """Return the decay from 0.5 m."""
    return run_block(spring_block(x0_m=0.5), 5e-4, 3.0)


def turning_points(history: BlockHistory) -> list[float]:
    """Return the displacements at which the velocity changes sign."""
    v = history.velocity_mps[:, 0]
    turns = np.flatnonzero(v[1:] * v[:-1] < 0.0)
    return [float(x) for x in history.position_m[turns, 0]]


def forced_response(ratio: float, friction_ratio: float, cycles: int = 30) -> tuple[float, float]:
    """Return the amplitude of the last cycles under P cos(W t) and the closed form."""
    force = _FRICTION_N / friction_ratio
    w = ratio * _OMEGA
    period = 2.0 * pi / w
    # Friction reverses between steps: the error is of first order, and near resonance it grows.
    dt = period / _STEPS_PER_CYCLE
    history = run_block(
        spring_block(), dt, cycles * period, force_n=lambda t: force * np.cos(w * t)
    )
    last = history.position_m[-3 * _STEPS_PER_CYCLE :, 0]
    amplitude = 0.5 * float(last.max() - last.min())
    return amplitude, force / _SPRING_N_PER_M * forced_amplitude(ratio, friction_ratio)


def bounce(drive: Any, *, speed_mps: float = 1.0, dt_s: float = 5e-4) -> BlockHistory:
    """Return one impact of the mass on a contact with a drive, without gravity."""
    weightless = replace(falling_block(), normal_load_n=0.0, v0_mps=(0.0, -speed_mps))
    return run_block(replace(weightless, gap_m=0.00321, drive=drive), dt_s, 0.1 / speed_mps)


def _check_impacts(study: Study) -> None:
    fall = run_block(falling_block(), 1e-4, 0.05)
    exact = falling_mass_impact(_MASS_KG, 1e7, 1.0, TABLE_G_MPS2)
    depth = float(-fall.position_m[:, 1].min())
    study.relative("ball on penalty: depth (m)", depth, exact.penetration_m, 5e-3, "B5")
    contact = fall.ledger.contact_time_s
    study.relative("ball on penalty: time of contact (s)", contact, exact.contact_s, 0.01, "B5")
    for e in (0.45, 0.6, 0.71, 0.9):
        dashpot = 2.0 * kelvin_voigt_damping_ratio(e) * (1e7 * _MASS_KG) ** 0.5
        drives = {"Kelvin-Voigt": kelvin_voigt_drive(kn_n_per_m=1e7, dashpot_n_s_per_m=dashpot)}
        for name, stiffness, p in (
            ("Hunt-Crossley", 1e7, 1.0),
            ("Hunt-Crossley, p = 3/2", 3e8, 1.5),
        ):
            drives[name] = hunt_crossley_drive(
                stiffness_n_per_m_p=stiffness, exponent=p, damping=hunt_crossley_damping(e)
            )
        for name, drive in drives.items():
            rebound = float(bounce(drive).velocity_mps[-1, 1])
            study.absolute(f"{name}: restitution {e}", rebound, e, 0.01, "B4")
    hertz = bounce(power_law_drive(stiffness_n_per_m_p=1e9, exponent=1.5), dt_s=1e-4)
    depth = hertz.ledger.max_penetration_m
    exact_depth = power_law_penetration(_MASS_KG, 1e9, 1.5, 1.0)
    study.relative("Hertz: depth (m)", depth, exact_depth, 5e-3, "energy")
    for speed in (0.5, 2.0):
        drive = approach_stiffness_drive(kn_n_per_m=1e7, reference_speed_mps=1.0, exponent=0.4)
        depth = bounce(drive, speed_mps=speed, dt_s=2e-4).ledger.max_penetration_m
        exact_depth = speed * (_MASS_KG / (1e7 * speed**0.4)) ** 0.5
        text = f"stiffness by approach at {speed} m/s: depth (m)"
        study.relative(text, depth, exact_depth, 5e-3, "energy")


def belt_ride(duration_s: float = 6.0) -> BlockHistory:
    """Return a mass pulled over a surface by a spring whose end moves at 0.1 m/s (B8)."""
    drive = stribeck_drive(static=0.4, kinetic=0.3, stribeck_speed_mps=2e-4)
    block = spring_block(friction=0.4, drive=drive)
    return run_block(block, 2e-4, duration_s, anchor_m=lambda t: 0.1 * t)


def belt_period(history: BlockHistory) -> float:
    """Return the mean time between the starts of long slips."""
    slip = history.position_m[:, 0] - history.friction_n / 1e10
    speed = np.diff(slip) / np.diff(history.t_s)
    fast = speed > 0.05
    starts = np.flatnonzero(fast[1:] & ~fast[:-1]) + 1
    return float(np.mean(np.diff(history.t_s[starts])))


def _history_figure(decay: BlockHistory, belt: BlockHistory, points: list[float]) -> Figure:
    figure, axes = style.panels(1, 2, height_in=2.8)
    left, right = axes[0]
    style.line(left, decay.t_s, decay.position_m[:, 0], style.BLUE, "OpenSees", lw=1.1)
    half = pi / _OMEGA
    style.dots(left, [k * half for k in range(len(points))], points, style.BLACK, "closed form")
    style.label(left, "time (s)", "x (m)", "free decay with friction")
    style.legend(left)
    style.line(right, belt.t_s, 0.1 * belt.t_s, style.GREY, "end of the spring")
    style.line(right, belt.t_s, belt.position_m[:, 0], style.ORANGE, "mass", lw=1.1)
    style.label(right, "time (s)", "x (m)", "stick-slip")
    style.legend(right)
    return figure


def run_integrators(study: Study) -> None:
    """Run the study of the restitution of integrators."""
    rows: list[dict[str, Any]] = []
    for step, reference in TABLE.items():
        for k, integrator in enumerate(_INTEGRATORS):
            found = integrator_restitution(integrator, step)
            values = {"mean": found.mean(), "least": found.min(), "largest": found.max()}
            rows.append({"integrator": integrator, "step_times_frequency": step} | values)
            text = f"{integrator}, step x frequency {step:g}: mean restitution"
            # The extremes depend on the phases tried; the mean of forty less so.
            tolerance = 0.01 + 0.05 * max(0.0, step - 1.0)
            study.absolute(text, values["mean"], reference[3 * k], tolerance, _WITHOUT_OPENSEES)
    study.tables["integrators"] = pd.DataFrame(rows)
    study.figures["integrators"] = _integrator_figure(study.tables["integrators"])


def integrator_restitution(integrator: str, step: float, phases: int = PHASES) -> np.ndarray:
    """Return rebound over approach speed for contact at evenly spread parts of a step.

    The step is the time step x circular frequency of the mass on the penalty.
    """
    mass, stiffness, speed = 1.0, 1.0, 1.0
    count = _FREE_STEPS + 2 * ceil(pi / step) + 6
    result = np.empty(phases)
    for k in range(phases):
        block = Block(
            mass_kg=mass,
            kn_n_per_m=stiffness,
            kt_n_per_m=stiffness,
            bounces=True,
            v0_mps=(0.0, -speed),
            gap_m=speed * step * (_FREE_STEPS + (k + 0.5) / phases),
        )
        history = run_block(block, step, count * step, integrator=_INTEGRATORS[integrator])
        y = history.position_m[:, 1]
        result[k] = (y[-1] - y[-2]) / step / speed
    return result


def _integrator_figure(table: pd.DataFrame) -> Figure:
    figure, axis = style.panel(height_in=3.0)
    axis.axhspan(0.45, 0.71, color=style.GREY, alpha=0.25, lw=0, label="reported in the paper")
    axis.axhline(1.0, color=style.GREY, lw=0.8)
    for (integrator, group), colour in zip(
        table.groupby("integrator"), (style.BLUE, style.ORANGE), strict=True
    ):
        x = group["step_times_frequency"]
        axis.fill_between(x, group["least"], group["largest"], color=colour, alpha=0.2, lw=0)
        style.line(axis, x, group["mean"], colour, str(integrator), marker="o", ms=3.5)
    axis.set_xscale("log")
    title = "elastic penalty, 40 phases"
    style.label(axis, "time step x contact frequency (-)", "rebound / approach (-)", title)
    style.legend(axis, loc="upper left")
    return figure
