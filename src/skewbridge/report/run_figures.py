"""Figures of the histories of one analysis, or of several under the same motion.

References:
    Rathje, Abrahamson and Bray (1998), J. Geotech. Geoenviron. Eng. 124(2):150-159: mean period.
    Konno and Ohmachi (1998), BSSA 88(1):228-241: smoothing on a logarithmic frequency axis.
"""

from collections.abc import Mapping
from itertools import chain
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from skewbridge.errors import InputError
from skewbridge.fragility.columns import FloatArray
from skewbridge.report.axis_layout import STYLE, plain_log_ticks
from skewbridge.units import KN, MM, MN

_LINE: Final = 0.9
_COLOURS: Final = sns.color_palette("colorblind")
#: Lines of runs on top of each other: the first is wide and light, so that it shows below.
_OVERLAID: Final[tuple[dict[str, Any], ...]] = (
    {"color": "#7db8dc", "lw": 1.8},
    *({"color": colour, "lw": 0.7} for colour in ("#a34700", *_COLOURS[2:])),
)
DEFAULT_BAND_HZ: Final = (0.1, 10.0)
_BANDWIDTH: Final = 40.0  # source: Konno and Ohmachi (1998), their b for engineering use
SPECTRA: Final = {
    "deck_ux_m": "longitudinal (m s)",
    "deck_uy_m": "transverse (m s)",
    "deck_rot_rad": "rotation (rad s)",
}


def run_figures(histories: pd.DataFrame, *, title: str) -> dict[str, Figure]:
    """Return the figures of an analysis by file name.

    Args:
        histories: Table of `skewbridge.analysis.histories`.
        title: Variant and motion.
    """
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
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 5.6), layout="constrained")
        axes = figure.subplots(3, 1, sharex=True)
        quantities = (
            ("deck_ux_m", MM, "Longitudinal (mm)"),
            ("deck_uy_m", MM, "Transverse (mm)"),
            ("deck_rot_rad", 1e-3, "Rotation (mrad)"),
        )
        for axis, (column, unit, text) in zip(axes, quantities, strict=True):
            for look, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
                axis.plot(table["t_s"], table[column] / unit, label=name, **look)
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
    names = contact_names(next(iter(runs.values())))
    rows = [
        [
            (f"{text}, {way}", direction, [f"abutment_left_{column}{direction}_kn"])
            for way, direction in (("longitudinal", "x"), ("transverse", "y"))
        ]
        for text, column in (("All of the abutment", ""), ("Pads alone", "pads_"))
    ]
    if names:
        rows.append(
            [
                (f"{text} alone, normal force", direction, _normals(names, part))
                for text, direction, part in (
                    ("Backwall", "x", "backwall"),
                    ("Shear keys", "y", "key"),
                )
            ]
        )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 2.5 * len(rows) + 0.7), layout="constrained")
        axes = figure.subplots(len(rows), 2, squeeze=False, sharex="col")
        for axis, (text, direction, columns) in zip(axes.flat, chain(*rows), strict=True):
            axis.set_title(text, loc="left", fontsize=9)
            axis.set_ylabel("Force (MN)")
            for look, (name, table) in zip(_OVERLAID, runs.items(), strict=False):
                disp_mm = table[f"abutment_left_{direction}_m"] / MM
                force_mn = table[columns].sum(axis=1) * KN / MN
                axis.plot(disp_mm, force_mn, label=name, **look)
        for axis, text in zip(axes[-1], ("longitudinal", "transverse"), strict=True):
            axis.set_xlabel(f"Deck end, {text} (mm)")
        _name_runs(figure, axes[0][0], list(runs))
    return figure


def _normals(names: list[str], part: str) -> list[str]:
    """Return the columns of the normal forces of one part of the left abutment."""
    return [f"{name}_normal_kn" for name in names if f"_left_{part}" in name]


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

    Args:
        runs: Tables with ``t_s`` and the deck's displacements by name; the first is the
            reference (no friction), all of the same motion; `moving_columns` has one or more.
    """
    names, columns = list(runs), moving_columns(runs)
    grid = np.geomspace(DEFAULT_BAND_HZ[0] * 1.2, DEFAULT_BAND_HZ[1] / 1.2, 160)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.9 * len(columns) + 0.6, 4.2), layout="constrained")
        panels = figure.subplots(
            2, len(columns), squeeze=False, sharex=True, height_ratios=[2.0, 1.0]
        )
        first = runs[names[0]]
        for (top, bottom), column in zip(panels.T, columns, strict=True):
            for name, look in zip(names, _OVERLAID, strict=False):
                table = runs[name]
                dt_s = float(table["t_s"].iloc[1] - table["t_s"].iloc[0])
                values = table[column].to_numpy(dtype=np.float64)
                f, amplitude = fourier_amplitude(values, dt_s)
                period_s = mean_period_s(values, dt_s)
                text = f"{name}, $T_m$ = {period_s:.2f} s"
                top.plot(grid, konno_ohmachi(f, amplitude, grid), label=text, **look)
                if name == names[0]:
                    continue
                size = min(values.size, len(first))
                reference = first[column].to_numpy(dtype=np.float64)[:size]
                ratio = fourier_ratio(values[:size], reference, dt_s, grid)
                bottom.plot(grid, ratio, **look)
            top.set_title(f"Deck, {SPECTRA[column]}", loc="left", fontsize=9)
            top.set_yscale("log")
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
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
    shear = figure.add_subplot(grid[0, 0])
    ratio = figure.add_subplot(grid[1, 0], sharex=shear)
    orbit = figure.add_subplot(grid[:, 1])
    shear.plot(histories["t_s"], histories["column_shear_kn"] / 1e3, lw=_LINE, color=_COLOURS[0])
    shear.set_ylabel("Base shear,\nworst column (MN)")
    ratio.plot(histories["t_s"], histories["column_shear_dcr"], lw=_LINE, color=_COLOURS[1])
    ratio.axhline(1.0, color="0.4", lw=0.8, ls="--")
    ratio.set_ylabel("Shear demand/capacity")
    ratio.set_xlabel("Time (s)")
    x_mm, y_mm = histories["deck_ux_m"] / MM, histories["deck_uy_m"] / MM
    orbit.plot(x_mm, y_mm, lw=_LINE, color=_COLOURS[2])
    half_mm = 1.08 * max(float(x_mm.abs().max()), float(y_mm.abs().max()), 1.0)
    orbit.set(xlim=(-half_mm, half_mm), ylim=(-half_mm, half_mm), aspect="equal")
    orbit.xaxis.set_major_locator(MaxNLocator(5))
    orbit.yaxis.set_major_locator(MaxNLocator(5))
    orbit.set_xlabel("Longitudinal (mm)")
    orbit.set_ylabel("Transverse (mm)")
    orbit.set_title("Orbit of the deck", fontsize=9)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def contact_figure(histories: pd.DataFrame, *, title: str) -> Figure:
    """Draw when each contact is closed, shaded by its normal force, and the friction forces."""
    names = contact_names(histories)
    figure = Figure(figsize=(7.2, 1.6 + 0.22 * len(names) + 2.0), layout="constrained")
    raster, friction = figure.subplots(
        2, 1, sharex=True, height_ratios=(0.22 * len(names) + 0.4, 2.0)
    )
    time_s = histories["t_s"].to_numpy()
    normals = np.column_stack([histories[f"{name}_normal_kn"] for name in names]).T / 1e3
    bins = np.linspace(time_s[0], time_s[-1], min(len(time_s), 1200) + 1)
    at = np.clip(np.searchsorted(time_s, bins[:-1]), 0, len(time_s) - 1)
    peaks = np.maximum.reduceat(normals, at, axis=1)
    shown = np.ma.masked_less_equal(peaks, 0.0)
    mesh = raster.pcolormesh(
        bins, np.arange(len(names) + 1), shown, cmap="flare", vmin=0.0, rasterized=True
    )
    labels = [name.removeprefix("contact_").replace("_", " ") for name in names]
    raster.set_yticks(np.arange(len(names)) + 0.5, labels, fontsize=7)
    raster.invert_yaxis()
    raster.grid(visible=False)
    figure.colorbar(mesh, ax=raster, label="Normal force (MN)", pad=0.01)
    raster.set_title(title, fontsize=10, parse_math=False)
    for colour, word in zip(_COLOURS, ("backwall", "key"), strict=False):
        chosen = [name for name in names if word in name]
        total = sum(
            np.hypot(histories[f"{n}_friction_1_kn"], histories[f"{n}_friction_2_kn"])
            for n in chosen
        )
        if chosen:
            friction.plot(time_s, np.asarray(total) / 1e3, lw=_LINE, color=colour, label=f"{word}s")
    friction.set_ylabel("Friction, sum (MN)")
    friction.set_xlabel("Time (s)")
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


def mean_period_s(
    values: FloatArray, dt_s: float, band_hz: tuple[float, float] = DEFAULT_BAND_HZ
) -> float:
    """Return the mean period sum(A^2/f)/sum(A^2) of a history, for example of the deck, s.

    The history has shape (n,) and is equally spaced; its mean is taken off.

    Raises:
        InputError: The history is constant, too short or not finite.
    """
    frequency, amplitude = fourier_amplitude(values, dt_s, band_hz)
    power = amplitude**2
    return float(np.sum(power / frequency) / np.sum(power))


def fourier_amplitude(
    values: FloatArray, dt_s: float, band_hz: tuple[float, float] = DEFAULT_BAND_HZ
) -> tuple[FloatArray, FloatArray]:
    """Return frequencies in the band and Fourier amplitudes (unit of the history times s)."""
    if values.ndim != 1 or values.size < 16 or not np.all(np.isfinite(values)):
        raise InputError(f"a history needs 16 or more finite values, got shape {values.shape}")
    if not dt_s > 0.0:
        raise InputError(f"dt_s must be > 0, got {dt_s:g}")
    centred = values - np.mean(values)
    if np.ptp(centred) == 0.0:
        raise InputError("a constant history has no frequency content")
    # padded to a power of two above twice the length, so that the band is finely sampled
    size = 1 << (2 * centred.size - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(centred, size)) * dt_s
    frequency = np.fft.rfftfreq(size, dt_s)
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    if np.sum(inside) < 8:
        raise InputError(
            f"band {band_hz} Hz holds {int(np.sum(inside))} frequencies of the history, need 8"
        )
    return frequency[inside], spectrum[inside]


def fourier_ratio(
    with_friction: FloatArray,
    without: FloatArray,
    dt_s: float,
    grid_hz: FloatArray,
    band_hz: tuple[float, float] = DEFAULT_BAND_HZ,
) -> FloatArray:
    """Return the ratio of smoothed Fourier amplitudes of two histories at given frequencies.

    Both histories, shape (n,), are of the same motion; ``grid_hz`` lies inside the band.
    """
    f_top, top = fourier_amplitude(with_friction, dt_s, band_hz)
    f_bottom, bottom = fourier_amplitude(without, dt_s, band_hz)
    return konno_ohmachi(f_top, top, grid_hz) / konno_ohmachi(f_bottom, bottom, grid_hz)


def konno_ohmachi(frequency: FloatArray, amplitude: FloatArray, grid: FloatArray) -> FloatArray:
    """Return the smoothed amplitude: window [sin(b log10 f/fc)/(b log10 f/fc)]^4, b = 40."""
    argument = _BANDWIDTH * np.log10(frequency / grid[:, None])
    window = np.sinc(argument / np.pi) ** 4
    return window @ amplitude / np.sum(window, axis=1)
