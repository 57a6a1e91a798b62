"""Figures of ground motions: histories and spectra of a record, spectra of a suite."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.files.tables import Floats
from skewbridge.motions.intensity import arias_build_up, displacement, velocity
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.spectrum import component_psa, pair_psa
from skewbridge.report.appearance import STYLE, plain_log_ticks
from skewbridge.units import G_MPS2

PERIODS_S: Final = np.geomspace(0.02, 10.0, 120)
APPLIED_PERIODS_S: Final = np.geomspace(0.05, 5.0, 60)
HISTORIES: Final[Mapping[str, Callable[[Floats, float], Floats]]] = {
    "Acceleration (g)": lambda accel_mps2, _: accel_mps2 / G_MPS2,
    "Velocity (m/s)": velocity,
    "Displacement (m)": displacement,
    "Arias (m/s)": arias_build_up,
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
    for axes, (name, series) in zip(panels, HISTORIES.items(), strict=True):
        for color, accel_mps2 in zip(_COLOURS, components.values(), strict=False):
            time_s = np.arange(accel_mps2.size) * dt_s
            axes.plot(time_s, series(accel_mps2, dt_s), color=color, lw=0.7)
        axes.set_ylabel(name)
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
    spectra_g: list[Floats] = []
    for scaled in suite:
        motion = scaled.motion
        pair = pair_psa(motion.accel_1_mps2, motion.accel_2_mps2, motion.dt_s, APPLIED_PERIODS_S)
        spectra_g.append(scaled.scale * pair.rotd50_mps2 / G_MPS2)
    return suite_spectra(
        np.array(spectra_g), APPLIED_PERIODS_S, title="Motions as applied (scaled)"
    )


@mpl.rc_context(STYLE)
def suite_spectra(
    rotd50_g: Floats,
    periods_s: Sequence[float] | Floats,
    *,
    title: str,
    model: tuple[str, Floats, Floats] | None = None,
) -> Figure:
    """Return a figure of RotD50 spectra (g, per motion and period), their median and 16-84 % band.

    ``model`` gives the name, median (g) and standard deviation of ln PSA of a ground-motion model
    at the same periods. A second panel then compares the standard deviations.
    """
    periods, log_psa = np.asarray(periods_s, dtype=np.float64), np.log(rotd50_g)
    blue, orange = _COLOURS
    width_in = _WIDTH_IN if model else 0.72 * _WIDTH_IN
    figure = Figure(figsize=(width_in, 4.0), layout="constrained")
    axes, *second_panel = figure.subplots(1, 2 if model else 1, squeeze=False)[0]
    axes.loglog(periods, rotd50_g.T, color="0.8", lw=0.5)
    low, middle, high = np.exp(np.percentile(log_psa, (16, 50, 84), axis=0))
    axes.loglog(periods, middle, color=blue, lw=2.0, label=f"median of {len(rotd50_g)} motions")
    axes.loglog(periods, low, color=blue, lw=1.0, ls="--", label="16 and 84 %")
    axes.loglog(periods, high, color=blue, lw=1.0, ls="--")
    if model:
        name, median_g, sigma = model
        axes.loglog(periods, median_g, color=orange, lw=1.6, label=f"median of {name}")
        ends_g = np.transpose(median_g * np.exp([-sigma, sigma]))
        labels = ["its 16 and 84 %", "_"]
        axes.loglog(periods, ends_g, color=orange, lw=0.9, ls=":", label=labels)
        scatter = log_psa.std(axis=0, ddof=1)
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
