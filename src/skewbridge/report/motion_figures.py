"""Figures of ground motions: a page per record, the spectra of a suite."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from skewbridge.motions.intensity import arias_build_up, displacement, velocity
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.spectrum import component_psa, pair_psa
from skewbridge.report.axis_layout import plain_log_ticks
from skewbridge.units import G_MPS2

type Vector = NDArray[np.float64]

PERIODS_S: Final = np.geomspace(0.02, 10.0, 120)
APPLIED_PERIODS_S: Final = np.geomspace(0.05, 5.0, 60)
HISTORIES: Final[Mapping[str, Callable[[Vector, float], Vector]]] = {
    "Acceleration (g)": lambda accel_mps2, _: accel_mps2 / G_MPS2,
    "Velocity (m/s)": velocity,
    "Displacement (m)": displacement,
    "Arias (m/s)": arias_build_up,
}
_WIDTH_IN: Final = 10.0
_COLOURS: Final = ("#0173b2", "#de8f05")  # source: palette "colorblind" of seaborn 0.13


def record_page(title: str, dt_s: float, components: Mapping[str, Vector]) -> Figure:
    """Return the page of one record: its histories, Arias build-up and spectra.

    Components (one or two, in m/s2) are given by their labels.
    """
    figure = Figure(figsize=(_WIDTH_IN, 7.0), layout="constrained")
    grid = figure.add_gridspec(4, 2, width_ratios=(1.35, 1.0))
    first: Axes = figure.add_subplot(grid[0, 0])
    axes = [first, *(figure.add_subplot(grid[row, 0], sharex=first) for row in range(1, 4))]
    spectra: Axes = figure.add_subplot(grid[:, 1])
    for axis, (name, series) in zip(axes, HISTORIES.items(), strict=True):
        for color, accel_mps2 in zip(_COLOURS, components.values(), strict=False):
            time_s = np.arange(accel_mps2.size) * dt_s
            axis.plot(time_s, series(accel_mps2, dt_s), color=color, lw=0.7)
        axis.set_ylabel(name)
        axis.axhline(0.0, color="0.6", lw=0.5, zorder=0)
    for axis in axes[:-1]:
        axis.tick_params(labelbottom=False)
    axes[-1].set_xlabel("Time (s)")
    figure.align_ylabels(axes)
    _draw_record_spectra(spectra, dt_s, components)
    figure.suptitle(title, parse_math=False)
    _open_frames(figure)
    return figure


def _draw_record_spectra(axis: Axes, dt_s: float, components: Mapping[str, Vector]) -> None:
    for color, (label, accel_mps2) in zip(_COLOURS, components.items(), strict=False):
        psa_g = component_psa(accel_mps2, dt_s, PERIODS_S) / G_MPS2
        axis.loglog(PERIODS_S, psa_g, color=color, lw=1.0, label=label)
    if len(components) == 2:
        one, two = components.values()
        both = pair_psa(one, two, dt_s, PERIODS_S)
        axis.loglog(PERIODS_S, both.rotd50_mps2 / G_MPS2, color="black", lw=1.8, label="RotD50")
        axis.loglog(
            PERIODS_S, both.rotd100_mps2 / G_MPS2, color="black", lw=1.0, ls="--", label="RotD100"
        )
    axis.set(xlabel="Period (s)", ylabel="PSA, 5 % damping (g)", xlim=(PERIODS_S[0], PERIODS_S[-1]))
    _grid(axis, "0.9")
    axis.legend(frameon=False, loc="lower left")


def applied_spectra(suite: Sequence[SuiteMotion]) -> Figure:
    """Return the RotD50 spectra of the motions of a study, with their scale factors."""
    spectra_g: list[Vector] = []
    for item in suite:
        motion = item.motion
        pair = pair_psa(motion.accel_1_mps2, motion.accel_2_mps2, motion.dt_s, APPLIED_PERIODS_S)
        spectra_g.append(item.scale * pair.rotd50_mps2 / G_MPS2)
    title = "Motions as applied (scaled)"
    return suite_spectra(np.array(spectra_g), APPLIED_PERIODS_S, title=title)


def suite_spectra(
    rotd50_g: Vector,
    periods_s: Sequence[float] | Vector,
    *,
    title: str,
    model: tuple[str, Vector, Vector] | None = None,
) -> Figure:
    """Return the RotD50 spectra (g, motions by periods) of a suite with median and 16-84 % band.

    A ground-motion model to compare with is given by its name, median in g and standard deviation
    of the logarithm at the same periods; its dispersion goes to a second panel.
    """
    periods = np.asarray(periods_s, dtype=np.float64)
    log_psa = np.log(rotd50_g)
    with mpl.rc_context({"font.size": 9}):
        width_in = _WIDTH_IN if model else 0.72 * _WIDTH_IN
        figure = Figure(figsize=(width_in, 4.0), layout="constrained")
        panels: Any = figure.subplots(1, 2 if model else 1, squeeze=False)
        axis: Axes = panels[0, 0]
        axis.loglog(periods, rotd50_g.T, color="0.8", lw=0.5)
        low, middle, high = np.exp(np.percentile(log_psa, (16, 50, 84), axis=0))
        color, label = _COLOURS[0], f"median of {len(rotd50_g)} motions"
        axis.loglog(periods, middle, color=color, lw=2.0, label=label)
        axis.loglog(periods, low, color=color, lw=1.0, ls="--", label="16 and 84 %")
        axis.loglog(periods, high, color=color, lw=1.0, ls="--")
        axis.set(xlabel="Period (s)", ylabel="RotD50 PSA, 5 % damping (g)")
        axis.set_xlim(float(periods[0]), float(periods[-1]))
        if model:
            _draw_model(axis, panels[0, 1], periods, log_psa, model)
        _grid(axis, "0.92")  # last: drawing resets the tick labels
        axis.legend(frameon=False, loc="lower left")
        figure.suptitle(title, x=0.01, ha="left", fontsize=10, parse_math=False)
        _open_frames(figure)
    return figure


def _draw_model(
    axis: Axes,
    dispersion: Axes,
    periods: Vector,
    log_psa: Vector,
    model: tuple[str, Vector, Vector],
) -> None:
    blue, orange = _COLOURS
    name, median_g, sigma = model
    axis.loglog(periods, median_g, color=orange, lw=1.6, label=f"median of {name}")
    for sign, label in ((1.0, None), (-1.0, "its 16 and 84 %")):
        end_g = median_g * np.exp(sign * sigma)
        axis.loglog(periods, end_g, color=orange, lw=0.9, ls=":", label=label)
    dispersion.semilogx(periods, log_psa.std(axis=0, ddof=1), color=blue, lw=2.0, label="motions")
    dispersion.semilogx(periods, sigma, color=orange, lw=1.6, label=name)
    dispersion.set(xlabel="Period (s)", ylabel="standard deviation of ln PSA", ylim=(0.0, 1.0))
    dispersion.set_xlim(float(periods[0]), float(periods[-1]))
    _grid(dispersion, "0.92")
    dispersion.legend(frameon=False, loc="lower left")


def _grid(axis: Axes, grey: str) -> None:
    plain_log_ticks(axis.xaxis)
    axis.grid(visible=True, which="both", color=grey, lw=0.5)
    axis.yaxis.set_major_formatter("{x:g}")


def _open_frames(figure: Figure) -> None:
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
