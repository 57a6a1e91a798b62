"""Displacement paths of the unit studies: columns t_s, ux_m, uy_m, uz_m (positive opens)."""

from math import pi

import numpy as np

from skewbridge.verification.references.live_model import Array


def circle(
    radius_m: float, *, period_s: float, loops: int, rows_per_loop: int, opening_m: float
) -> Array:
    """Return a circle through the origin at constant speed and opening."""
    t = np.linspace(0.0, loops * period_s, loops * rows_per_loop + 1)
    angle = 2.0 * pi * t / period_s
    x, y = radius_m * np.sin(angle), radius_m * (1.0 - np.cos(angle))
    return np.column_stack([t, x, y, np.full_like(t, opening_m)])


def straight_loop(half_stroke_m: float, *, rows: int, opening_m: float) -> Array:
    """Return two cycles between -a and a along x in 2 s, from the origin."""
    t = np.linspace(0.0, 2.0, 2 * rows + 1)
    x = half_stroke_m * triangle(t, 1.0)
    return np.column_stack([t, x, np.zeros_like(t), np.full_like(t, opening_m)])


def triangle(t_s: Array, period_s: float) -> Array:
    """Return a triangle wave of amplitude one that rises from zero at zero."""
    phase = np.mod(t_s / period_s + 0.25, 1.0)
    return 1.0 - 4.0 * np.abs(phase - 0.5)


def square(t_s: Array, period_s: float) -> Array:
    """Return a square wave of amplitude one, positive in the first half of the period."""
    return np.where(np.mod(t_s, period_s) < 0.5 * period_s - 1e-9, 1.0, -1.0)


def figure_3(rows_per_s: int, *, duration_s: float = 12.0) -> Array:
    """Return the path of Figure 3 of the paper.

    Triangles of 4 s and 1 m along x and of 6 s and 2 m along y; a square wave of 2.5 s and 0.1 m
    along the normal, open in its first half.
    """
    # ASSUME the waves start together at zero, rising, and open: the paper does not say.
    t = np.arange(round(duration_s * rows_per_s) + 1) / rows_per_s
    return np.column_stack([t, triangle(t, 4.0), 2.0 * triangle(t, 6.0), 0.1 * square(t, 2.5)])
