"""Figures of the histories of one analysis, or of several under the same motion.

References:
    Rathje, Abrahamson and Bray (1998), J. Geotech. Geoenviron. Eng. 124(2):150-159: mean period.
    Konno and Ohmachi (1998), BSSA 88(1):228-241: smoothing on a logarithmic frequency axis.
"""

from collections.abc import Mapping
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats
from skewbridge.report.axis_layout import STYLE, VARIANT_COLOURS, plain_log_ticks, shown_unit
from skewbridge.units import KN, MM, MN

_LINE: Final = 0.9
#: Lines of runs on top of each other: the first is wide and light, so that it shows below.
_OVERLAID: Final[tuple[dict[str, Any], ...]] = tuple(
    {"color": colour, "lw": 0.7 if place else 1.8, "alpha": 1.0 if place else 0.55}
    for place, colour in enumerate(VARIANT_COLOURS)
)
BAND_HZ: Final = (0.1, 10.0)
_BANDWIDTH: Final = 40.0  # source: Konno and Ohmachi (1998), their b for engineering use
SPECTRA: Final = {
    "deck_ux_m": "longitudinal (m s)",
    "deck_uy_m": "transverse (m s)",
    "deck_rot_rad": "rotation (rad s)",
}


def run_figures(histories: pd.DataFrame, *, title: str) -> dict[str, Figure]:
    """Return the figures of an analysis by file name, from `skewbridge.analysis.histories`."""
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


def displacement_figure(runs: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw displacement and rotation of the deck's mass centre against time, runs overlaid."""
    length, per_m = _length()
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 5.6), layout="constrained")
        axes = figure.subplots(3, 1, sharex=True)
        quantities = (
            ("deck_ux_m", per_m, f"Longitudinal ({length})"),
            ("deck_uy_m", per_m, f"Transverse ({length})"),
            ("deck_rot_rad", 1e3, "Rotation (mrad)"),
        )
        for axis, (column, factor, text) in zip(axes, quantities, strict=True):
            for look, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
                axis.plot(table["t_s"], factor * table[column], label=name, **look)
            axis.axhline(0.0, color="0.4", lw=0.5)
            axis.set_ylabel(text)
        axes[-1].set_xlabel("Time (s)")
        _name_runs(figure, axes[0], list(runs))
    return figure


def hysteresis_figure(runs: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw forces of the left abutment on the deck against the displacement, runs overlaid.

    One row of panels for the whole force, one for the pads alone, along and across the bridge; with
    contacts a third one for the normal forces of backwall and shear keys.
    """
    (length, per_m), (force, per_kn) = _length(), _force()
    panels = [
        (f"{text}, {way}", direction, [f"abutment_left_{column}{direction}_kn"])
        for text, column in (("All of the abutment", ""), ("Pads alone", "pads_"))
        for way, direction in (("longitudinal", "x"), ("transverse", "y"))
    ]
    if names := contact_names(next(iter(runs.values()))):
        panels += [
            (f"{text} alone, normal force", direction,
             [f"{name}_normal_kn" for name in names if f"_left_{part}" in name])
            for text, direction, part in (("Backwall", "x", "backwall"), ("Shear keys", "y", "key"))
        ]  # fmt: skip
    rows = len(panels) // 2
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 2.5 * rows + 0.7), layout="constrained")
        axes = figure.subplots(rows, 2, squeeze=False, sharex="col")
        for axis, (text, direction, columns) in zip(axes.flat, panels, strict=True):
            axis.set_title(text, loc="left", fontsize=9)
            axis.set_ylabel(f"Force ({force})")
            for look, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
                disp = per_m * table[f"abutment_left_{direction}_m"]
                axis.plot(disp, per_kn * table[columns].sum(axis=1), label=name, **look)
        for axis, text in zip(axes[-1], ("longitudinal", "transverse"), strict=True):
            axis.set_xlabel(f"Deck end, {text} ({length})")
        _name_runs(figure, axes[0][0], list(runs))
    return figure


def _length() -> tuple[str, float]:
    """Return the shown unit of displacements and its number in a metre."""
    unit, factor = shown_unit("mm")
    return unit, factor / MM


def _force() -> tuple[str, float]:
    """Return the shown unit of forces and its number in a kilonewton."""
    unit, factor = shown_unit("MN")
    return unit, factor * KN / MN


def moving_columns(runs: Mapping[str, pd.DataFrame]) -> list[str]:
    """Return the displacements of the deck that vary in every one of two or more histories."""
    tables = list(runs.values())
    return [
        name
        for name in SPECTRA
        if len(tables) > 1 and all(name in t and np.ptp(t[name]) > 0.0 for t in tables)
    ]


def frequency_figure(runs: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw smoothed Fourier amplitudes of the deck and their ratio to the first history.

    The first run is the reference (no friction), all are of the same motion, and `moving_columns`
    has one or more.
    """
    names, columns = list(runs), moving_columns(runs)
    grid = np.geomspace(BAND_HZ[0] * 1.2, BAND_HZ[1] / 1.2, 160)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.9 * len(columns) + 0.6, 4.2), layout="constrained")
        panels = figure.subplots(
            2, len(columns), squeeze=False, sharex=True, height_ratios=[2.0, 1.0]
        )
        first = runs[names[0]]
        for (top, bottom), column in zip(panels.T, columns, strict=True):
            for name, look in zip(names, _OVERLAID, strict=False):
                text = f"{name}, $T_m$ = {mean_period_s(runs[name], column):.2f} s"
                top.plot(grid, _smoothed(runs[name], column, grid), label=text, **look)
                if name != names[0]:
                    rows = min(len(first), len(runs[name]))
                    with_friction, without = (
                        _smoothed(table.iloc[:rows], column, grid) for table in (runs[name], first)
                    )
                    bottom.plot(grid, with_friction / without, **look)
            top.set_title(f"Deck, {SPECTRA[column]}", loc="left", fontsize=9)
            top.set_yscale("log")
            plain_log_ticks(top.yaxis)
            top.legend(fontsize=7, loc="lower left")
            bottom.axhline(1.0, color="#777777", linewidth=0.8)
            bottom.set_ylim(0.0, 2.0)
            bottom.set_xlabel("Frequency (Hz)")
            bottom.set_xscale("log")
        panels[0][0].set_ylabel("Fourier amplitude")
        panels[1][0].set_ylabel(f"over {names[0]}")
        plain_log_ticks(panels[1][0].xaxis)
    return figure


def column_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw column shear and its ratio to the capacity against time, and the orbit of the deck."""
    (length, per_m), (force, per_kn) = _length(), _force()
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
    shear = figure.add_subplot(grid[0, 0])
    ratio = figure.add_subplot(grid[1, 0], sharex=shear)
    orbit = figure.add_subplot(grid[:, 1])
    looks: list[dict[str, Any]] = [{"lw": _LINE, "color": each} for each in VARIANT_COLOURS[:3]]
    shear.plot(histories["t_s"], per_kn * histories["column_shear_kn"], **looks[0])
    shear.set_ylabel(f"Base shear,\nworst column ({force})")
    ratio.plot(histories["t_s"], histories["column_shear_dcr"], **looks[1])
    ratio.axhline(1.0, color="0.4", lw=0.8, ls="--")
    ratio.set(xlabel="Time (s)", ylabel="Shear demand/capacity")
    moves = per_m * histories[["deck_ux_m", "deck_uy_m"]].to_numpy().T
    orbit.plot(*moves, **looks[2])
    half = 1.08 * max(float(np.abs(moves).max()), 1e-3 * per_m)
    orbit.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    orbit.set(xlabel=f"Longitudinal ({length})", ylabel=f"Transverse ({length})")
    orbit.xaxis.set_major_locator(MaxNLocator(5))
    orbit.yaxis.set_major_locator(MaxNLocator(5))
    orbit.set_title("Orbit of the deck", fontsize=9)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def contact_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw when each contact is closed, shaded by its normal force, and the friction forces."""
    names, (force, per_kn) = contact_names(histories), _force()
    height_in = 0.22 * len(names)
    figure = Figure(figsize=(7.2, 3.6 + height_in), layout="constrained")
    raster, friction = figure.subplots(2, 1, sharex=True, height_ratios=(height_in + 0.4, 2.0))
    time_s = histories["t_s"].to_numpy()
    normals = histories[[f"{name}_normal_kn" for name in names]].to_numpy().T * per_kn
    bins = np.linspace(time_s[0], time_s[-1], min(len(time_s), 1200) + 1)
    at = np.clip(np.searchsorted(time_s, bins[:-1]), 0, len(time_s) - 1)
    shown = np.ma.masked_less_equal(np.maximum.reduceat(normals, at, axis=1), 0.0)
    mesh = raster.pcolormesh(
        bins, np.arange(len(names) + 1), shown, cmap="flare", vmin=0.0, rasterized=True
    )
    labels = [name.removeprefix("contact_").replace("_", " ") for name in names]
    raster.set_yticks(np.arange(len(names)) + 0.5, labels, fontsize=7)
    raster.invert_yaxis()
    raster.grid(visible=False)
    figure.colorbar(mesh, ax=raster, label=f"Normal force ({force})", pad=0.01)
    raster.set_title(title, fontsize=10, parse_math=False)
    for colour, word in zip(VARIANT_COLOURS, ("backwall", "key"), strict=False):
        if chosen := [name for name in names if word in name]:
            parts = ([f"{name}_friction_{axis}_kn" for name in chosen] for axis in "12")
            one, two = (histories[part].to_numpy() for part in parts)
            total = per_kn * np.hypot(one, two).sum(axis=1)
            friction.plot(time_s, total, lw=_LINE, color=colour, label=f"{word}s")
    friction.set(xlabel="Time (s)", ylabel=f"Friction, sum ({force})")
    friction.legend(loc="upper right", fontsize=8)
    return figure


def contact_names(histories: pd.DataFrame) -> list[str]:
    """Return how the columns of each contact start, in the order of the table."""
    end = "_normal_kn"
    return [
        str(column).removesuffix(end)
        for column in histories.columns
        if str(column).startswith("contact_") and str(column).endswith(end)
    ]


def _name_runs(figure: Figure, axis: Axes, names: list[str]) -> None:
    """Title the figure with its one run, or give the runs a legend."""
    if len(names) == 1:
        figure.suptitle(names[0], fontsize=10)
    else:
        figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def mean_period_s(histories: pd.DataFrame, column: str) -> float:
    """Return the mean period sum(A^2/f)/sum(A^2) of a column of histories, s."""
    frequency, amplitude = fourier_amplitude(histories, column)
    power = amplitude**2
    return float(np.sum(power / frequency) / np.sum(power))


def fourier_amplitude(histories: pd.DataFrame, column: str) -> tuple[Floats, Floats]:
    """Return the frequencies in `BAND_HZ` and Fourier amplitudes (unit of the column times s).

    Raises:
        InputError: The history is constant, too short or not finite.
    """
    values = histories[column].to_numpy(dtype=np.float64)
    if values.size < 16 or not np.ptp(values) > 0.0:
        raise InputError(f"{column} needs 16 or more finite values that vary, got {values.size}")
    dt_s = float(histories["t_s"].iloc[1] - histories["t_s"].iloc[0])
    # padded to a power of two above twice the length, so that the band is finely sampled
    size = 1 << (2 * values.size - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(values - np.mean(values), size)) * dt_s
    frequency = np.fft.rfftfreq(size, dt_s)
    inside = (frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1])
    return frequency[inside], spectrum[inside]


def _smoothed(histories: pd.DataFrame, column: str, grid_hz: Floats) -> Floats:
    """Return the smoothed amplitude: window [sin(b log10 f/fc)/(b log10 f/fc)]^4, b = 40."""
    frequency, amplitude = fourier_amplitude(histories, column)
    argument = _BANDWIDTH * np.log10(frequency / grid_hz[:, None])
    window = np.sinc(argument / np.pi) ** 4
    return window @ amplitude / np.sum(window, axis=1)
