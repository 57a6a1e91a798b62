"""What the figures of the fragility package share: labels, colours, ticks."""

from collections.abc import Mapping
from typing import Any, Final

import pandas as pd
import seaborn as sns
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

LABELS: Final[dict[str, str]] = {
    "column_shear_kn": "Column shear (kN)",
    "column_shear_dcr": "Column shear demand/capacity",
    "column_drift_ratio": "Column drift ratio",
    "column_curvature_ductility": "Curvature ductility",
    "column_residual_drift_ratio": "Residual drift ratio",
    "deck_disp_m": "Deck displacement (m)",
    "deck_disp_x_m": "Deck displacement, longitudinal (m)",
    "deck_disp_y_m": "Deck displacement, transverse (m)",
    "deck_rotation_rad": "Deck rotation (rad)",
    "unseating_m": "Unseating (m)",
    "bearing_disp_m": "Bearing deformation (m)",
    "abutment_passive_m": "Abutment, passive (m)",
    "abutment_active_m": "Abutment, active (m)",
    "abutment_transverse_m": "Abutment, transverse (m)",
    "backwall_force_kn": "Backwall force (kN)",
    "shear_key_force_kn": "Shear key force (kN)",
    "im_saavg_rotd50_g": r"$S_{a,\mathrm{avg}}$ RotD50 (g)",
    "im_sa_t1_rotd50_g": r"$S_a(T_1)$ RotD50 (g)",
    "im_sa_1p000_rotd50_g": r"$S_a(1.0\,\mathrm{s})$ RotD50 (g)",
    "im_pga_rotd50_g": "PGA RotD50 (g)",
    "im_pgv_rotd50_mps": "PGV RotD50 (m/s)",
    "skew_deg": "Skew (deg)",
    "gap_mm": "Gap (mm)",
    "friction": "Friction",
}
STYLE: Final[Any] = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "font.size": 9,
    "legend.frameon": False,
}
_DASHES: Final = ("-", (0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)))


def label(column: str) -> str:
    """Return the axis label of a column, with its unit."""
    return LABELS.get(column, column.replace("_", " "))


def styles_of(table: pd.DataFrame) -> dict[tuple[float, float], dict[str, Any]]:
    """Return line styles by (gap, friction): colour by friction, dashes by gap."""
    gaps, frictions = sorted(table["gap_mm"].unique()), sorted(table["friction"].unique())
    colours = sns.color_palette("colorblind", max(len(frictions), 2))
    return {
        (gap, friction): {"color": colours[j], "linestyle": _DASHES[i % len(_DASHES)]}
        for i, gap in enumerate(gaps)
        for j, friction in enumerate(frictions)
    }


def handles_of(styles: Mapping[tuple[float, float], Mapping[str, Any]]) -> list[Line2D]:
    """Return the entries of the legend of such styles."""
    return [
        Line2D([], [], label=f"gap {gap:g} mm, μ {friction:g}", **style)
        for (gap, friction), style in styles.items()
    ]


def plain_log_ticks(axis: Axis) -> None:
    """Label a logarithmic axis with plain numbers at 1, 2 and 5."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def note(text: str) -> Figure:
    """Return a figure that says why there is nothing to draw."""
    figure = Figure(figsize=(5.0, 1.2))
    figure.text(0.02, 0.5, text, va="center", fontsize=9)
    return figure
