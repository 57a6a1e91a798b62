"""Figure 3 of the paper: the unit in space under a square and two triangular waves."""

import numpy as np
import pytest

from reference_data import reference_table
from skewbridge.verification.references.driven_unit import (
    drive_unit,
    figure_3,
    follow_law,
    path_work_j,
)
from skewbridge.verification.studies.spatial_path import EXACT_N, EXACT_WORK_J, LAW, LIMIT_N


def steady(path):
    """Rows away from the jumps of the wave and from the reversals of the slip."""
    moved = np.sign(np.diff(path[:, 1:], axis=0).round(9))
    events = np.flatnonzero(np.any(np.diff(moved, axis=0) != 0.0, axis=1)) + 1
    keep = np.ones(len(path), dtype=bool)
    for shift in (-1, 0, 1, 2):
        keep[np.clip(events + shift, 0, len(path) - 1)] = False
    return keep


def test_a_live_unit_gives_the_exact_forces_and_work():
    path = figure_3(2000)
    forces = drive_unit(LAW, path, substeps=1).forces_n
    for time, exact in EXACT_N.items():
        row = forces[round(2000 * time), :2]
        assert row == pytest.approx(exact, abs=0.01 * LIMIT_N)
    assert path_work_j(path, forces) == pytest.approx(EXACT_WORK_J, rel=2e-3)


def test_one_millisecond_is_enough_for_one_percent():
    path = figure_3(1000)
    forces = drive_unit(LAW, path, substeps=1).forces_n
    exact = follow_law(LAW, path, substeps=20)
    error = np.hypot(*(forces - exact)[steady(path), :2].T) / LIMIT_N
    assert np.sqrt(np.mean(error**2)) <= 0.01
    # Every committed force lies in the cone of its own compression.
    limit = np.where(forces[:, 2] > 0.0, LAW.cohesion_n + LAW.friction * forces[:, 2], 0.0)
    inside = np.hypot(*forces[:, :2].T) <= limit * (1 + 1e-6) + 1e-6
    assert inside[steady(path)].all()


def test_the_tabulated_history_of_radial_return_is_met():
    reference = reference_table("spatial_path_forces")
    path = figure_3(1000)
    forces = drive_unit(LAW, path, substeps=2).forces_n[::10]
    keep = steady(path[::10])[::5]
    path, forces = path[::50], forces[::5]
    assert path[:, 1] == pytest.approx(reference["ux_m"].to_numpy(), abs=1e-6)
    error = (forces[:, :2] - reference[["fx_n", "fy_n"]].to_numpy())[keep] / LIMIT_N
    assert np.sqrt(np.mean(np.sum(error**2, axis=1))) <= 0.01
