"""Figures of static studies: abutment pushes of the whole ladder, column sections."""

from itertools import cycle
from typing import Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.bridge.moment_curvature import MomentCurvature
from skewbridge.bridge.shear_capacity import (
    ShearSection,
    kowalsky_priestley_strength,
    sdc_shear_strength,
)
from skewbridge.units import KN, MM
from skewbridge.variant.abutments import ABUTMENTS

# Okabe and Ito's palette with one line style per model, in the order of the abutment models, so
# that lines on top of each other show
STYLES: Final = (
    {"color": "#999999", "linestyle": "-", "linewidth": 1.5},
    {"color": "#0072B2", "linestyle": "-", "linewidth": 1.5},
    {"color": "#E69F00", "linestyle": "-", "linewidth": 3.0},
    {"color": "#009E73", "linestyle": "--", "linewidth": 2.0},
    {"color": "#D55E00", "linestyle": ":", "linewidth": 2.0},
)


def ladder_figure(curves: pd.DataFrame, *, title: str) -> Figure:
    """Return pushes of one abutment by all models, a panel per direction.

    Args:
        curves: Columns abutment, angle_deg, disp_m, force_kn.
        title: Above the figure.
    """
    angles = sorted(curves["angle_deg"].unique())
    columns = min(3, len(angles))
    rows = -(-len(angles) // columns)
    figure = Figure(figsize=(3.8 * columns, 3.2 * rows + 0.8), layout="constrained")
    panels = np.atleast_1d(figure.subplots(rows, columns, sharex=True)).ravel()
    for panel, angle in zip(panels, angles, strict=False):
        part = curves[curves["angle_deg"] == angle]
        for abutment, style in zip(ABUTMENTS, cycle(STYLES), strict=False):
            line = part[part["abutment"] == abutment]
            if not line.empty:
                panel.plot(line["disp_m"] / MM, line["force_kn"] / KN, label=abutment, **style)
        panel.set_title(f"push at {angle:g} degrees from x", fontsize=10)
        panel.set_ylim(bottom=0.0)
    for panel in panels[len(angles) :]:
        panel.set_visible(False)
    for panel in panels[max(0, len(angles) - columns) : len(angles)]:
        panel.set_xlabel("displacement along the push (mm)")
    figure.supylabel("force along the push (MN)")
    figure.suptitle(title, parse_math=False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=len(labels), frameon=False, fontsize=9
    )
    return figure


def column_figure(
    curve: MomentCurvature, shear: ShearSection, axial_n: float, *, title: str
) -> Figure:
    """Return moment-curvature with its idealisation, and shear strength against ductility."""
    figure = Figure(figsize=(10, 4), layout="constrained")
    bending, capacity = figure.subplots(1, 2)
    bending.plot(curve.curvature_per_m, curve.moment_nm / 1e6, color="#0072B2", label="section")
    knee, end = curve.yield_curvature_per_m, curve.ultimate_curvature_per_m
    plateau = curve.plastic_moment_nm / 1e6
    bending.plot(
        [0.0, knee, end], [0.0, plateau, plateau], "--", color="#D55E00", label="idealised"
    )
    first = curve.first_yield_curvature_per_m, curve.first_yield_moment_nm / 1e6
    bending.plot(*first, "o", color="#D55E00", label="first yield")
    bending.set(xlabel="curvature (1/m)", ylabel="moment (MNm)", xlim=(0, None), ylim=(0, None))
    bending.legend(frameon=False, loc="lower right")
    ductility = np.linspace(1.0, 15.0, 141)
    for label, strength, colour in (
        ("Caltrans criteria, displacement ductility", sdc_shear_strength, "#0072B2"),
        ("Kowalsky-Priestley, curvature ductility", kowalsky_priestley_strength, "#009E73"),
    ):
        strength_mn = np.asarray(strength(shear, axial_n, ductility)) / 1e6
        capacity.plot(ductility, strength_mn, color=colour, label=label)
    demand = curve.plastic_moment_nm / shear.shear_span_m / 1e6
    capacity.axhline(demand, color="#D55E00", linestyle="--", label="plastic shear Mp / L")
    capacity.set(xlabel="ductility", ylabel="shear (MN)", ylim=(0, None), xlim=(1, 15))
    capacity.legend(frameon=False, fontsize=9)
    figure.suptitle(title, parse_math=False)
    return figure
