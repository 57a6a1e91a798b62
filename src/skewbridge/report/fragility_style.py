"""What figures of demands and fragility share: style, ticks, and a note in place of a figure."""

from typing import Any, Final

import numpy as np
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

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


_MANY: Final = 2000.0  # span of an axis from which 1, 2 and 5 of every decade crowd


def plain_log_ticks(axis: Axis) -> None:
    """Label a logarithmic axis with plain numbers at 1, 2 and 5, over many decades at 1 alone."""
    low, high = axis.get_view_interval()
    many = high > _MANY * low > 0.0
    axis.set_major_locator(LogLocator(subs=(1.0,) if many else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(_tick))
    axis.set_minor_formatter(NullFormatter())


def plain_number(value: float) -> str:
    """Return a tick or a limit of an axis without an exponent: 0.00002."""
    return np.format_float_positional(value, precision=2, fractional=False, trim="-")


def _tick(value: float, _place: int) -> str:
    return plain_number(value)


def note(text: str) -> Figure:
    """Return a figure that says why there is nothing to draw."""
    figure = Figure(figsize=(5.0, 1.2))
    figure.text(0.02, 0.5, text, va="center", fontsize=9)
    return figure
