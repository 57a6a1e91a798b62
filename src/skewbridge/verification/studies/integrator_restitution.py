"""Restitution that the integrators themselves give to an elastic penalty.

A mass meets an elastic contact at forty positions within a step. Whatever it loses or gains is an
artefact of the integrator: with Houbolt at two steps per contact it looks like a restitution of
0.45 to 0.8, the range reported in the paper.
"""

from math import ceil, pi
from typing import Any, Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.verification.references.block import Block, run_block
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

PHASES: Final = 40
_FREE_STEPS: Final = 6
_INTEGRATORS: Final[dict[str, tuple[str | float, ...]]] = {
    "houbolt": ("Houbolt",),
    "newmark": ("Newmark", 0.5, 0.25),
}
# Step x contact frequency: Houbolt mean, least, largest; Newmark mean, least, largest.
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
_SOURCE: Final = "same integrators without OpenSees (docs/theory/verification.md)"


def run(study: Study) -> None:
    """Run the study."""
    rows: list[dict[str, Any]] = []
    for step, reference in TABLE.items():
        for k, integrator in enumerate(_INTEGRATORS):
            found = integrator_restitution(integrator, step)
            values = {"mean": found.mean(), "least": found.min(), "largest": found.max()}
            rows.append({"integrator": integrator, "step_times_frequency": step} | values)
            text = f"{integrator}, step x frequency {step:g}: mean restitution"
            # The extremes depend on the phases tried; the mean of forty less so.
            tolerance = 0.01 + 0.05 * max(0.0, step - 1.0)
            study.absolute(text, values["mean"], reference[3 * k], tolerance, _SOURCE)
    study.tables["integrators"] = pd.DataFrame(rows)
    study.figures["integrators"] = _figure(study.tables["integrators"])


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


def _figure(table: pd.DataFrame) -> Figure:
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
