"""Figures of the histories of one analysis, or of several under the same motion."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from skewbridge.report.appearance import STYLE, VARIANT_COLOURS, shown_unit
from skewbridge.units import KN, MM, MN

#: Line styles of overlaid runs: the first is wide and light, so that it stays visible.
_OVERLAID: Final[tuple[dict[str, Any], ...]] = tuple(
    {"color": colour, "lw": 0.7 if place else 1.8, "alpha": 1.0 if place else 0.55}
    for place, colour in enumerate(VARIANT_COLOURS)
)


def run_figures(histories: pd.DataFrame, *, title: str) -> dict[str, Figure]:
    """Return a dict from file name to figure for the histories (`histories_of`) of a run."""
    # imported here: it takes a second to load, and the figures of a study do not need it
    import seaborn as sns  # also registers the colour map "flare"

    with sns.axes_style("white", rc=dict(STYLE)):
        figures = {
            "displacements": displacement_figure({title: histories}),
            "hysteresis": hysteresis_figure({title: histories}),
            "columns": column_figure(histories, title=title),
        }
        if contact_names(histories):
            figures["contacts"] = contact_figure(histories, title=title)
    return figures


@mpl.rc_context(STYLE)
def displacement_figure(runs: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw displacement and rotation of the deck's mass centre against time for all runs."""
    length, per_m, _, _ = _units()
    quantities = (
        ("deck_ux_m", per_m, f"Longitudinal ({length})"),
        ("deck_uy_m", per_m, f"Transverse ({length})"),
        ("deck_rot_rad", 1e3, "Rotation (mrad)"),
    )
    figure = Figure(figsize=(7.2, 5.6), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for axes, (column, factor, text) in zip(panels, quantities, strict=True):
        for look, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
            axes.plot(table["t_s"], factor * table[column], label=name, **look)
        axes.axhline(0.0, color="0.4", lw=0.5)
        axes.set_ylabel(text)
    panels[-1].set_xlabel("Time (s)")
    _name_runs(figure, panels[0])
    return figure


@mpl.rc_context(STYLE)
def hysteresis_figure(runs: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw forces of the first seat abutment on the deck against displacement for all runs.

    Panels are longitudinal and transverse. The first row shows the total force, the second the
    force of the pads. With contacts, a third row shows normal forces of backwall and shear keys.
    """
    length, per_m, force, per_kn = _units()
    first = next(iter(runs.values()))
    names = contact_names(first)
    has_left_pads = first.filter(regex="abutment_left_pads_._kn").any(axis=None)
    side = "left" if has_left_pads else "right"
    panels = [
        (f"{text}, {way}", direction, [f"abutment_{side}_{column}{direction}_kn"])
        for text, column in ((f"Whole {side} abutment", ""), ("Pads alone", "pads_"))
        for way, direction in (("longitudinal", "x"), ("transverse", "y"))
    ]
    for text, direction, part in (("Backwall", "x", "backwall"), ("Shear keys", "y", "key")):
        columns = [f"{name}_normal_kn" for name in names if f"_{side}_{part}" in name]
        if names:
            panels.append((f"{text} alone, normal force", direction, columns))
    rows = len(panels) // 2
    figure = Figure(figsize=(7.2, 2.5 * rows + 0.7), layout="constrained")
    grid = figure.subplots(rows, 2, squeeze=False, sharex="col")
    for axes, (text, direction, columns) in zip(grid.flat, panels, strict=True):
        axes.set_title(text, loc="left", fontsize=9)
        axes.set_ylabel(f"Force ({force})")
        for look, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
            disp = per_m * table[f"abutment_{side}_{direction}_m"]
            axes.plot(disp, per_kn * table[columns].sum(axis=1), label=name, **look)
    for axes, text in zip(grid[-1], ("longitudinal", "transverse"), strict=True):
        axes.set_xlabel(f"Deck end, {text} ({length})")
    _name_runs(figure, grid[0, 0])
    return figure


def _units() -> tuple[str, float, str, float]:
    """Return the displacement unit and its number per m, the force unit and its number per kN."""
    (length, per_mm), (force, per_mn) = shown_unit("mm"), shown_unit("MN")
    return length, per_mm / MM, force, per_mn * KN / MN


def _name_runs(figure: Figure, axes: Axes) -> None:
    """Use the name of a single run as the title, or add a legend of several runs."""
    handles, names = axes.get_legend_handles_labels()
    if len(names) == 1:
        figure.suptitle(names[0], fontsize=10)
    else:
        figure.legend(handles, names, loc="outside lower center", ncols=4)


def column_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw column shear and its ratio to the capacity against time, and the orbit of the deck."""
    length, per_m, force, per_kn = _units()
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    panels = figure.subplot_mosaic("so;ro", width_ratios=(1.15, 1.0))
    shear, ratio, orbit = panels["s"], panels["r"], panels["o"]
    ratio.sharex(shear)
    drawn = (
        (shear, histories["t_s"], per_kn * histories["column_shear_kn"]),
        (ratio, histories["t_s"], histories["column_shear_dcr"]),
        (orbit, per_m * histories["deck_ux_m"], per_m * histories["deck_uy_m"]),
    )
    for (axes, x, y), colour in zip(drawn, VARIANT_COLOURS, strict=False):
        axes.plot(x, y, lw=0.9, color=colour)
    shear.set_ylabel(f"Column shear,\nworst column ({force})")
    ratio.axhline(1.0, color="0.4", lw=0.8, ls="--")
    ratio.set(xlabel="Time (s)", ylabel="Shear demand/capacity")
    half = 1.08 * per_m * max(histories[["deck_ux_m", "deck_uy_m"]].abs().max().max(), 1e-3)
    orbit.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    orbit.set(xlabel=f"Longitudinal ({length})", ylabel=f"Transverse ({length})")
    for axis in (orbit.xaxis, orbit.yaxis):
        axis.set_major_locator(MaxNLocator(5))
    orbit.set_title("Orbit of the deck", fontsize=9)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def contact_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw the closed times of each contact, shaded by normal force, and the friction forces."""
    names, (_, _, force, per_kn) = contact_names(histories), _units()
    height_in = 0.22 * len(names)
    figure = Figure(figsize=(7.2, 3.6 + height_in), layout="constrained")
    raster, friction = figure.subplots(2, 1, sharex=True, height_ratios=(height_in + 0.4, 2.0))
    time_s = histories["t_s"].to_numpy()
    normals = histories[[f"{name}_normal_kn" for name in names]].to_numpy().T * per_kn
    bins = np.linspace(time_s[0], time_s[-1], min(len(time_s), 1200) + 1)
    at = np.clip(np.searchsorted(time_s, bins[:-1]), 0, len(time_s) - 1)
    shown = np.ma.masked_less_equal(np.maximum.reduceat(normals, at, axis=1), 0.0)
    edges = np.arange(len(names) + 1)
    mesh = raster.pcolormesh(bins, edges, shown, cmap="flare", vmin=0.0, rasterized=True)
    labels = [name.removeprefix("contact_").replace("_", " ") for name in names]
    raster.set_yticks(np.arange(len(names)) + 0.5, labels, fontsize=7)
    raster.invert_yaxis()
    raster.grid(visible=False)
    figure.colorbar(mesh, ax=raster, label=f"Normal force ({force})", pad=0.01)
    raster.set_title(title, fontsize=10, parse_math=False)
    for colour, word in zip(VARIANT_COLOURS, ("backwall", "key", "joint"), strict=False):
        if chosen := [name for name in names if word in name]:
            one, two = (histories[[f"{name}_friction_{i}_kn" for name in chosen]] for i in "12")
            total = per_kn * np.hypot(one.to_numpy(), two.to_numpy()).sum(axis=1)
            friction.plot(time_s, total, lw=0.9, color=colour, label=f"{word}s")
    friction.set(xlabel="Time (s)", ylabel=f"Friction, sum ({force})")
    friction.legend(loc="upper right", fontsize=8)
    return figure


def contact_names(histories: pd.DataFrame) -> Sequence[str]:
    """Return the column prefix of each contact, in the order of the table."""
    return histories.columns.str.extract(r"^(contact_.*)_normal_kn$")[0].dropna().tolist()
