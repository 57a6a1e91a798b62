"""Fourier amplitudes of the deck with and without friction: does friction change the period?"""

from collections.abc import Mapping
from typing import Final

import matplotlib as mpl
import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.figure import Figure

from skewbridge.fragility.tables.frequency_content import (
    DEFAULT_BAND_HZ,
    fourier_amplitude,
    fourier_ratio,
    frequency_content,
    konno_ohmachi,
)
from skewbridge.report.fragility_style import STYLE, note, plain_log_ticks

COLUMNS: Final = {
    "deck_ux_m": "longitudinal (m s)",
    "deck_uy_m": "transverse (m s)",
    "deck_rot_rad": "rotation (rad s)",
}


def frequency_figure(histories: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw smoothed Fourier amplitudes of the deck and their ratio to the first history.

    Args:
        histories: Tables with ``t_s`` and the deck's displacements by name; the first is the
            reference (no friction), all of the same motion.
    """
    names = list(histories)
    columns = [c for c in COLUMNS if all(c in table for table in histories.values())]
    columns = [c for c in columns if all(np.ptp(table[c]) > 0.0 for table in histories.values())]
    if len(names) < 2 or not columns:
        return note("Frequency content needs two histories in which the deck moves")
    grid = np.geomspace(DEFAULT_BAND_HZ[0] * 1.2, DEFAULT_BAND_HZ[1] / 1.2, 160)
    colours = sns.color_palette("colorblind", len(names))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.9 * len(columns) + 0.6, 4.2), layout="constrained")
        panels = figure.subplots(
            2, len(columns), squeeze=False, sharex=True, height_ratios=[2.0, 1.0]
        )
        first = histories[names[0]]
        for (top, bottom), column in zip(panels.T, columns, strict=True):
            for name, colour in zip(names, colours, strict=True):
                table = histories[name]
                dt_s = float(table["t_s"].iloc[1] - table["t_s"].iloc[0])
                values = table[column].to_numpy(dtype=np.float64)
                f, amplitude = fourier_amplitude(values, dt_s)
                period_s = frequency_content(values, dt_s).mean_period_s
                text = f"{name}, $T_m$ = {period_s:.2f} s"
                top.plot(grid, konno_ohmachi(f, amplitude, grid), color=colour, label=text)
                if name == names[0]:
                    continue
                size = min(values.size, len(first))
                reference = first[column].to_numpy(dtype=np.float64)[:size]
                ratio = fourier_ratio(values[:size], reference, dt_s, grid)
                bottom.plot(grid, ratio, color=colour)
            top.set_title(f"Deck, {COLUMNS[column]}", loc="left", fontsize=9)
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
