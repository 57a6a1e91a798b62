"""Periods of OSB1 with open gaps and elastic columns, against a beam and a rigid body by hand.

All numbers are those of its file. The beam is exact for the uniform deck (with its rotational
inertia), on the spring of the bent and those of the pads. Left out are the twist of the deck ends
and turns of the column tops: 0.1 % of the transverse period, 0.4 to 0.6 % of that in plan."""

from math import cos, cosh, pi, radians, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from bridge_variants import variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.variant.options import ModelOptions

G = 9.80665
SPAN_M, WIDTH_M = 45.72, 14.33
DECK_KG_PER_M, DIAPHRAGM_KG, CAP_KG = 186.2e3 / G, 321e3 / G, 801e3 / G
DECK_PA, COLUMN_PA = 24.86e9, 28.34e9
PADS_N_PER_M = 5 * 2208e3  # of one abutment
# two columns of 5.64 m, 7.32 m apart, pinned at the base; 1.01 m from soffit to centroid
HEIGHT_M, RIGID_M, APART_M = 5.64, 1.01, 7.32
AREA_M2, INERTIA_M4 = pi / 4 * 1.676**2, pi / 64 * 1.676**4
COLUMN_KG = 23.56e3 * AREA_M2 * HEIGHT_M / G
BENDING_NM2 = 0.45 * COLUMN_PA * INERTIA_M4
CAP_WIDTH_M, CAP_DEPTH_M = 2.29, 1.829
AXIAL_N = (1.25 * DECK_KG_PER_M * SPAN_M + CAP_KG + 2 * COLUMN_KG) * G / 2


def modes_of_osb1(skew_deg):
    return modal_properties(variant(skew_deg, "contact"), ModelOptions(elastic_columns=True))


def bent_stiffness_n_per_m():
    """Return the stiffness along the bent, at the centroid: a frame with a flexible cap."""
    level_m = HEIGHT_M + RIGID_M
    cap_nm = 6 * DECK_PA * CAP_WIDTH_M * CAP_DEPTH_M**3 / 12 / APART_M  # bent in an S
    # rolling of the cap: columns in tension and compression, and torsion of both spans
    rolling_nm = COLUMN_PA * AREA_M2 / HEIGHT_M * APART_M**2 / 2
    rolling_nm += 2 * DECK_PA / 2.4 * 11.04 / SPAN_M
    column_m_per_n = HEIGHT_M**3 / (3 * BENDING_NM2) + level_m**2 * (1 / cap_nm + 2 / rolling_nm)
    return 2 / column_m_per_n - 2 * AXIAL_N / level_m  # less P-Delta


def test_transverse_period_is_that_of_a_beam_on_three_springs():
    bent_n_per_m, bending_nm2 = bent_stiffness_n_per_m(), DECK_PA * 114.5
    gyration = WIDTH_M**2 / 12

    def determinant(speed):
        """Rows: no slope and half of the bent at the middle; no moment and the pads at the end."""
        turning = DECK_KG_PER_M * gyration * speed**2
        root = sqrt(turning**2 + 4 * bending_nm2 * DECK_KG_PER_M * speed**2)
        p, q = (sqrt((root + sign * turning) / (2 * bending_nm2)) for sign in (-1, 1))

        def terms(x):
            """Return the four functions and their three derivatives, (4, 4)."""
            ch, sh, c, s = cosh(p * x), sinh(p * x), cos(q * x), sin(q * x)
            return np.array([
                [ch, sh, c, s],
                [p * sh, p * ch, -q * s, q * c],
                [p**2 * ch, p**2 * sh, -(q**2) * c, -(q**2) * s],
                [p**3 * sh, p**3 * ch, q**3 * s, -(q**3) * c],
            ])  # fmt: skip

        middle, end = terms(0.0), terms(SPAN_M)
        bent = (bent_n_per_m - (CAP_KG + COLUMN_KG) * speed**2) / 2
        pads = PADS_N_PER_M - DIAPHRAGM_KG * speed**2
        rows = np.array([
            middle[1],
            bending_nm2 * middle[3] + turning * middle[1] + bent * middle[0],
            bending_nm2 * end[2] - DIAPHRAGM_KG * gyration * speed**2 * end[1],
            bending_nm2 * end[3] + turning * end[1] - pads * end[0],
        ])  # fmt: skip
        return np.linalg.det(rows / np.abs(rows).max(axis=1, keepdims=True))

    period_s = 2 * pi / brentq(determinant, 7.0, 11.0)
    assert modes_of_osb1(0).period_s("y") == pytest.approx(period_s, rel=0.003)
    # as a rigid body, the deck would be 3 % too fast
    mass_kg = 2 * SPAN_M * DECK_KG_PER_M + CAP_KG + COLUMN_KG + 2 * DIAPHRAGM_KG
    assert 2 * pi * sqrt(mass_kg / (bent_n_per_m + 2 * PADS_N_PER_M)) < 0.98 * period_s


@pytest.mark.parametrize(("skew_deg", "error"), [(0, 0.004), (60, 0.006)])
def test_period_in_plan_is_that_of_a_rigid_parallelogram_on_pads_and_columns(skew_deg, error):
    stretch = 1 / cos(radians(skew_deg))
    # a column normal to its bent: its top does not turn, the cap bends in plan
    lever_m, inertia_m4 = stretch * APART_M / 2, CAP_DEPTH_M * CAP_WIDTH_M**3 / 12
    m_per_n = HEIGHT_M**3 / (3 * BENDING_NM2) + lever_m**3 / (3 * DECK_PA * inertia_m4)
    axial_n = AXIAL_N + (stretch - 1) * CAP_KG * G / 2
    column_n_per_m = 1 / m_per_n - axial_n / HEIGHT_M
    torsion_nm = 0.2 * COLUMN_PA / 2.4 * 2 * INERTIA_M4 / HEIGHT_M
    pads_m2 = np.mean((stretch * 2.90 * np.arange(-2, 3)) ** 2) + SPAN_M**2
    stiffness_nm = 2 * PADS_N_PER_M * pads_m2 + 2 * (column_n_per_m * lever_m**2 + torsion_nm)
    # of a parallelogram: (length^2 + skewed edge^2) / 12 about its middle
    square_m2 = (2 * SPAN_M) ** 2 + (stretch * WIDTH_M) ** 2
    inertia_kgm2 = 2 * SPAN_M * DECK_KG_PER_M * square_m2 / 12
    # diaphragms along the skew are longer
    inertia_kgm2 += 2 * stretch * DIAPHRAGM_KG * (SPAN_M**2 + (stretch * WIDTH_M) ** 2 / 12)
    inertia_kgm2 += COLUMN_KG * lever_m**2
    period_s = 2 * pi * sqrt(inertia_kgm2 / stiffness_nm)
    assert modes_of_osb1(skew_deg).period_s("rz") == pytest.approx(period_s, rel=error)
