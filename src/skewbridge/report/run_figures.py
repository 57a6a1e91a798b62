"""Figures of ground motions, and of the histories of analyses under the same motion."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from skewbridge.files.tables import Floats
from skewbridge.motions.folder import list_motions
from skewbridge.motions.intensity import (
    SPECTRUM_PERIODS_S,
    arias_build_up,
    component_psa,
    displacement,
    pair_psa,
    velocity,
)
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.motions.suite import read_entries
from skewbridge.report.appearance import STYLE, VARIANT_COLOURS, plain_log_ticks, shown_unit
from skewbridge.units import G_MPS2, KN, MM, MN

#: Line styles of overlaid runs: the first is wide and light, so that it stays visible.
_OVERLAID: Final[tuple[dict[str, Any], ...]] = tuple(
    {"color": colour, "lw": 0.7 if number else 1.8, "alpha": 1.0 if number else 0.55}
    for number, colour in enumerate(VARIANT_COLOURS)
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
        normals = [f"{name}_normal_kn" for name in contact_names(histories)]
        if (histories[normals] > 0.0).any(axis=None):
            figures["contacts"] = contact_figure(histories, title=title)
    return figures


@mpl.rc_context(STYLE)
def displacement_figure(runs: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw displacement and rotation of the deck's mass centre against time for all runs."""
    length_unit, unit_per_m, _, _ = _units()
    quantities = (
        ("deck_ux_m", unit_per_m, f"Longitudinal ({length_unit})"),
        ("deck_uy_m", unit_per_m, f"Transverse ({length_unit})"),
        ("deck_rot_rad", 1e3, "Rotation (mrad)"),
    )
    figure = Figure(figsize=(7.2, 5.6), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for axes, (column, factor, text) in zip(panels, quantities, strict=True):
        for style, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
            axes.plot(table["t_s"], factor * table[column], label=name, **style)
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
    length_unit, unit_per_m, force_unit, unit_per_kn = _units()
    first_run = next(iter(runs.values()))
    names = contact_names(first_run)
    has_left_pads = first_run.filter(regex="abutment_left_pads_._kn").any(axis=None)
    side = "left" if has_left_pads else "right"
    panels = [
        (f"{text}, {axis_name}", direction, [f"abutment_{side}_{column}{direction}_kn"])
        for text, column in ((f"Whole {side} abutment", ""), ("Pads alone", "pads_"))
        for axis_name, direction in (("longitudinal", "x"), ("transverse", "y"))
    ]
    for text, direction, contact in (("Backwall", "x", "backwall"), ("Shear keys", "y", "key")):
        columns = [f"{name}_normal_kn" for name in names if f"_{side}_{contact}" in name]
        if names:
            panels.append((f"{text} alone, normal force", direction, columns))
    rows = len(panels) // 2
    figure = Figure(figsize=(7.2, 2.5 * rows + 0.7), layout="constrained")
    grid = figure.subplots(rows, 2, squeeze=False, sharex="col")
    for axes, (text, direction, columns) in zip(grid.flat, panels, strict=True):
        axes.set_title(text, loc="left", fontsize=9)
        axes.set_ylabel(f"Force ({force_unit})")
        for style, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
            disp = unit_per_m * table[f"abutment_{side}_{direction}_m"]
            axes.plot(disp, unit_per_kn * table[columns].sum(axis=1), label=name, **style)
    for axes, text in zip(grid[-1], ("longitudinal", "transverse"), strict=True):
        axes.set_xlabel(f"Deck end, {text} ({length_unit})")
    _name_runs(figure, grid[0, 0])
    return figure


def _units() -> tuple[str, float, str, float]:
    """Return the displacement unit, its factor from m, the force unit and its factor from kN."""
    (length_unit, per_mm), (force_unit, per_mn) = shown_unit("mm"), shown_unit("MN")
    return length_unit, per_mm / MM, force_unit, per_mn * KN / MN


def _name_runs(figure: Figure, axes: Axes) -> None:
    """Use the name of a single run as the title, or add a legend of several runs."""
    handles, names = axes.get_legend_handles_labels()
    if len(names) == 1:
        figure.suptitle(names[0], fontsize=10)
    else:
        figure.legend(handles, names, loc="outside lower center", ncols=4)


def column_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw column shear and its ratio to the capacity against time, and the orbit of the deck."""
    length_unit, per_m, force_unit, unit_per_kn = _units()
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    panels = figure.subplot_mosaic("so;ro", width_ratios=(1.15, 1.0))
    shear, ratio, orbit = panels["s"], panels["r"], panels["o"]
    ratio.sharex(shear)
    panels_of = (
        (shear, histories["t_s"], unit_per_kn * histories["column_shear_kn"]),
        (ratio, histories["t_s"], histories["column_shear_dcr"]),
        (orbit, per_m * histories["deck_ux_m"], per_m * histories["deck_uy_m"]),
    )
    for (axes, x, y), colour in zip(panels_of, VARIANT_COLOURS, strict=False):
        axes.plot(x, y, lw=0.9, color=colour)
    shear.set_ylabel(f"Column shear,\nworst column ({force_unit})")
    ratio.axhline(1.0, color="0.4", lw=0.8, ls="--")
    ratio.set(xlabel="Time (s)", ylabel="Shear demand/capacity")
    half_range = 1.08 * per_m * max(histories[["deck_ux_m", "deck_uy_m"]].abs().max().max(), 1e-3)
    orbit.set(xlim=(-half_range, half_range), ylim=(-half_range, half_range), aspect="equal")
    orbit.set(xlabel=f"Longitudinal ({length_unit})", ylabel=f"Transverse ({length_unit})")
    for axis in (orbit.xaxis, orbit.yaxis):
        axis.set_major_locator(MaxNLocator(5))
    orbit.set_title("Orbit of the deck", fontsize=9)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def contact_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw the closed times of each contact, shaded by normal force, and the friction forces."""
    names, (_, _, force_unit, per_kn) = contact_names(histories), _units()
    height_in = 0.22 * len(names)
    figure = Figure(figsize=(7.2, 3.6 + height_in), layout="constrained")
    raster, friction = figure.subplots(2, 1, sharex=True, height_ratios=(height_in + 0.4, 2.0))
    time_s = histories["t_s"].to_numpy()
    normals = histories[[f"{name}_normal_kn" for name in names]].to_numpy().T * per_kn
    bins = np.linspace(time_s[0], time_s[-1], min(len(time_s), 1200) + 1)
    starts = np.clip(np.searchsorted(time_s, bins[:-1]), 0, len(time_s) - 1)
    closed_forces = np.ma.masked_less_equal(np.maximum.reduceat(normals, starts, axis=1), 0.0)
    edges = np.arange(len(names) + 1)
    mesh = raster.pcolormesh(bins, edges, closed_forces, cmap="flare", vmin=0.0, rasterized=True)
    labels = [name.removeprefix("contact_").replace("_", " ") for name in names]
    raster.set_yticks(np.arange(len(names)) + 0.5, labels, fontsize=7)
    raster.invert_yaxis()
    raster.grid(visible=False)
    figure.colorbar(mesh, ax=raster, label=f"Normal force ({force_unit})", pad=0.01)
    raster.set_title(title, fontsize=10, parse_math=False)
    for colour, kind in zip(VARIANT_COLOURS, ("backwall", "key", "joint"), strict=False):
        if chosen := [name for name in names if kind in name]:
            t1, t2 = (histories[[f"{name}_friction_{i}_kn" for name in chosen]] for i in "12")
            total = per_kn * np.hypot(t1.to_numpy(), t2.to_numpy()).sum(axis=1)
            friction.plot(time_s, total, lw=0.9, color=colour, label=f"{kind}s")
    friction.set(xlabel="Time (s)", ylabel=f"Friction, sum ({force_unit})")
    friction.legend(loc="upper right", fontsize=8)
    return figure


def contact_names(histories: pd.DataFrame) -> Sequence[str]:
    """Return the column prefix of each contact, in the order of the table."""
    return histories.columns.str.extract(r"^(contact_.*)_normal_kn$")[0].dropna().tolist()


PERIODS_S: Final = np.geomspace(0.02, 10.0, 120)
APPLIED_PERIODS_S: Final = np.geomspace(0.05, 5.0, 60)
HISTORIES: Final[Mapping[str, Callable[[Floats, float], Floats]]] = {
    "Acceleration (g)": lambda accel_mps2, _: accel_mps2 / G_MPS2,
    "Velocity (*/s)": velocity,  # *: m or in
    "Displacement (*)": displacement,
    "Arias (*/s)": arias_build_up,
}
_WIDTH_IN: Final = 10.0
_COLOURS: Final = ("#0173b2", "#de8f05")  # source: palette "colorblind" of seaborn 0.13


@mpl.rc_context(STYLE)
def record_page(title: str, dt_s: float, components: Mapping[str, Floats]) -> Figure:
    """Return a figure of one record: histories, Arias build-up and spectra.

    ``components`` maps one or two labels to accelerations (m/s2).
    """
    figure = Figure(figsize=(_WIDTH_IN, 7.0), layout="constrained")
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.35, 1.0))
    left_half, right_half = halves
    panels = left_half.subplots(len(HISTORIES), 1, sharex=True)
    spectra = right_half.subplots()
    length_unit, per_m = shown_unit("m")
    for axes, (name, series) in zip(panels, HISTORIES.items(), strict=True):
        for color, accel_mps2 in zip(_COLOURS, components.values(), strict=False):
            time_s = np.arange(accel_mps2.size) * dt_s
            values = series(accel_mps2, dt_s) * (per_m if "*" in name else 1.0)
            axes.plot(time_s, values, color=color, lw=0.7)
        axes.set_ylabel(name.replace("*", length_unit))
    panels[-1].set_xlabel("Time (s)")
    left_half.align_ylabels(panels)
    for color, (label, accel_mps2) in zip(_COLOURS, components.items(), strict=False):
        psa_g = component_psa(accel_mps2, dt_s, PERIODS_S) / G_MPS2
        spectra.loglog(PERIODS_S, psa_g, color=color, lw=1.0, label=label)
    if len(components) == 2:
        accel_1, accel_2 = components.values()
        pair_spectra = pair_psa(accel_1, accel_2, dt_s, PERIODS_S)
        rotd50_g, rotd100_g = pair_spectra.rotd50_mps2 / G_MPS2, pair_spectra.rotd100_mps2 / G_MPS2
        spectra.loglog(PERIODS_S, rotd50_g, color="black", lw=1.8, label="RotD50")
        spectra.loglog(PERIODS_S, rotd100_g, color="black", lw=1.0, ls="--", label="RotD100")
    _finish(spectra, PERIODS_S, "PSA, 5 % damping (g)")
    figure.suptitle(title, parse_math=False)
    return figure


def applied_spectra(suite: Sequence[SuiteMotion]) -> Figure:
    """Return a figure of the RotD50 spectra of the scaled motions of a study."""
    motions = [scaled.motion.scaled(scaled.scale) for scaled in suite]
    spectra_g = _rotd50_g(motions, APPLIED_PERIODS_S)
    return suite_spectra(spectra_g, APPLIED_PERIODS_S, title="Motions as applied (scaled)")


def folder_spectra(folder: Path, *, title: str) -> Figure:
    """Return a figure of the RotD50 spectra of the motions of a folder.

    If all belong to one synthetic scenario, its median and dispersion by BSSA14 are drawn too.
    """
    from skewbridge.motions.synthesis import Scenario, bssa14

    motions = read_entries(list_motions(folder))
    periods_s = np.array([s for s in SPECTRUM_PERIODS_S if 0.03 <= s <= 7.5])
    model = None
    scenarios = {(m.event, m.magnitude, m.distance_km, m.vs30_mps) for m in motions}
    # the files alone, without an index, do not state the magnitude
    is_known = len(scenarios) == 1 and isfinite(motions[0].magnitude)
    if is_known and motions[0].event.startswith("DDK18"):
        event, *values = scenarios.pop()
        site = dict(zip(("magnitude", "distance_km", "vs30_mps"), values, strict=True))
        mechanism = "reverse" if "reverse" in event else "strike_slip"
        model = ("BSSA14", *bssa14(Scenario(mechanism=mechanism, **site), periods_s))
    return suite_spectra(_rotd50_g(motions, periods_s), periods_s, title=title, model=model)


def _rotd50_g(motions: Iterable[GroundMotion], periods_s: Sequence[float] | Floats) -> Floats:
    """Return the RotD50 spectra of motions in g, shape (motions, periods)."""
    pairs = (pair_psa(*motion.components, motion.dt_s, periods_s) for motion in motions)
    return np.array([pair.rotd50_mps2 for pair in pairs]) / G_MPS2


@mpl.rc_context(STYLE)
def suite_spectra(
    rotd50_g: Floats,
    periods_s: Sequence[float] | Floats,
    *,
    title: str,
    model: tuple[str, Floats, Floats] | None = None,
) -> Figure:
    """Return a figure of RotD50 spectra (g, per motion and period), their mean and scatter.

    ``model`` gives the name, median (g) and standard deviation of ln PSA of a ground-motion model
    at the same periods. A second panel then compares the standard deviations.
    """
    periods, log_psa = np.asarray(periods_s, dtype=np.float64), np.log(rotd50_g)
    blue, orange = _COLOURS
    figure = Figure(figsize=(_WIDTH_IN if model else 0.72 * _WIDTH_IN, 4.0), layout="constrained")
    axes, *second_panel = figure.subplots(1, 2 if model else 1, squeeze=False)[0]
    axes.loglog(periods, rotd50_g.T, color="0.8", lw=0.5)
    mean, scatter = log_psa.mean(axis=0), log_psa.std(axis=0, ddof=min(1, len(log_psa) - 1))
    label = f"geometric mean of {len(rotd50_g)} motions"
    axes.loglog(periods, np.exp(mean), color=blue, lw=2.0, label=label)
    ends_g, labels = np.exp([mean - scatter, mean + scatter]).T, ["± 1 standard deviation", "_"]
    axes.loglog(periods, ends_g, color=blue, lw=1.0, ls="--", label=labels)
    if model:
        name, median_g, sigma = model
        axes.loglog(periods, median_g, color=orange, lw=1.6, label=f"median of {name}")
        ends_g = np.transpose(median_g * np.exp([-sigma, sigma]))
        labels = ["± 1 standard deviation", "_"]
        axes.loglog(periods, ends_g, color=orange, lw=0.9, ls=":", label=labels)
        second_panel[0].semilogx(periods, scatter, color=blue, lw=2.0, label="motions")
        second_panel[0].semilogx(periods, sigma, color=orange, lw=1.6, label=name)
        second_panel[0].set_ylim(0.0, 1.0)
        _finish(second_panel[0], periods, "standard deviation of ln PSA")
    _finish(axes, periods, "RotD50 PSA, 5 % damping (g)")
    figure.suptitle(title, x=0.01, ha="left", fontsize=10, parse_math=False)
    return figure


def _finish(axes: Axes, periods_s: Floats, label: str) -> None:
    """Label the axes of spectra. Call it last, because plotting resets the tick labels."""
    axes.set(xlabel="Period (s)", ylabel=label, xlim=(periods_s[0], periods_s[-1]))
    plain_log_ticks(axes.xaxis)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.legend(loc="lower left")
