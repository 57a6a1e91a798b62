"""Look of the verification figures."""

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

# Colours that differ in print and for colour-blind readers.
# source: Okabe and Ito (2008), Color Universal Design.
BLUE: Final = "#0072B2"
ORANGE: Final = "#D55E00"
GREEN: Final = "#009E73"
PINK: Final = "#CC79A7"
GREY: Final = "0.55"
BLACK: Final = "0.1"
_WIDTH_IN: Final = 7.2


def panels(rows: int, columns: int, *, height_in: float, **options: Any) -> tuple[Figure, Any]:
    """Return a figure and its array of axes, shape (rows, columns)."""
    figure = Figure(figsize=(_WIDTH_IN, height_in), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for axis in np.ravel(axes):
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize=8)
        axis.grid(visible=True, linewidth=0.4, alpha=0.4)
    return figure, axes


def time_panels(*names: str, height_in: float, title: str = "") -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes over time, one below the other, each with the name of its y."""
    figure, grid = panels(len(names), 1, height_in=height_in, sharex=True)
    axes: list[Axes] = list(grid[:, 0])
    for axis, name in zip(axes, names, strict=True):
        label(axis, "time (s)" if axis is axes[-1] else "", name, title if axis is axes[0] else "")
    return figure, axes


def line(axis: Axes, x: ArrayLike, y: ArrayLike, colour: str, text: str = "", **look: Any) -> None:
    """Draw a line; `text` is its entry in the legend, `look` further matplotlib keywords."""
    options: dict[str, Any] = {"color": colour, "label": text or None, "lw": 1.0} | look
    axis.plot(x, y, **options)


def dots(axis: Axes, x: ArrayLike, y: ArrayLike, colour: str, text: str = "", **look: Any) -> None:
    """Draw points without a line."""
    line(axis, x, y, colour, text, **({"marker": "o", "ls": "none", "ms": 3.5} | look))


def label(axis: Axes, x: str, y: str, title: str = "") -> None:
    """Label an axis in the size of the figures."""
    axis.set_xlabel(x, fontsize=8)
    axis.set_ylabel(y, fontsize=8)
    if title:
        axis.set_title(title, fontsize=9, loc="left")


def legend(axis: Axes, **options: Any) -> None:
    """Add a small legend."""
    axis.legend(**({"fontsize": 7, "frameon": False} | options))


def legend_above(figure: Figure, axis: Axes) -> None:
    """Put the legend of an axis above the figure, in one row."""
    handles, names = axis.get_legend_handles_labels()
    figure.legend(
        handles, names, loc="outside upper center", ncols=len(names), fontsize=8, frameon=False
    )
