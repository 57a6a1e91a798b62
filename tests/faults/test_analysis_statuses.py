"""Every analysis returns a status and the peaks up to its end."""

import math

import numpy as np
import pytest

from bridge_variants import abutment_analysed, analysed, variant
from skewbridge.analysis.recovery import RECOVERY_STEPS
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import StepLoop
from skewbridge.errors import InputError
from strong_motion import strong_motion

VARIANT = variant()


def run(**settings):
    return analysed(VARIANT, **settings)


ENERGY = ("energy_residual_ratio", "numerical_dissipation_ratio", "contact_energy_ratio")


def assert_has_peaks(result):
    assert all(math.isfinite(v) for k, v in result.demands.items() if k not in ENERGY)
    assert result.demands["deck_disp_m"] > 0.0
    times = result.histories["t_s"]
    assert times[-1] == pytest.approx(result.time_reached_s)
    assert np.all(np.diff(times) > 0.0)


def test_a_collapse_stops_the_run_and_demands_are_those_until_a_column_fails():
    result = run(scale=4.0, dt_s=0.005)
    assert (result.status, result.collapse_criterion) == ("collapse", "column_drift_ratio")
    assert result.time_reached_s < result.duration_s
    assert_has_peaks(result)
    end, histories = result.model_end, result.histories
    assert end.mode == "flexure"
    until = histories["t_s"] <= end.time_s
    assert 0.0 < end.time_s < result.time_reached_s
    # histories are read at the regular steps, demands at all
    near = {"rel": 0.02}
    peaks = np.maximum(*(histories[f"column_{number}_drift_ratio"] for number in (1, 2)))
    assert peaks[until].max() == pytest.approx(result.demands["column_drift_ratio"], **near)
    assert peaks.max() > 2 * result.demands["column_drift_ratio"]  # the histories go on
    assert 0.10 <= peaks.max() < 0.12
    assert 1.0 <= result.demands["drift_over_capacity"] < 1.2
    shear = histories["column_shear_kn"][until].max()
    assert shear == pytest.approx(result.demands["column_shear_kn"], **near)


def test_limits_of_collapse_and_the_budget_of_iterations_are_settings():
    for setting, limit, ended in (
        ("collapse_deck_disp_m", 0.05, ("collapse", "deck_disp_m")),
        ("collapse_drift_ratio", 0.01, ("collapse", "column_drift_ratio")),
        ("mean_iterations", 1.0, ("timeout", "")),
    ):
        result = run(duration_s=2.5, **{setting: limit})
        assert (result.status, result.collapse_criterion) == ended
        assert 0.0 < result.time_reached_s < result.duration_s
        assert_has_peaks(result)
    # an abutment alone has the same budget
    settings = AnalysisSettings(mean_iterations=1.0, duration_s=1.0)
    history = abutment_analysed(VARIANT, strong_motion(duration_s=2.0), settings)
    assert not history.is_complete
    assert history.t_s[-1] < 1.0


def test_failed_steps_are_recovered_counted_and_logged(tmp_path):
    # Three iterations are too few for the steps in which contacts close.
    log = tmp_path / "opensees.log"
    result = run(log_path=log, max_iterations=3, tolerance_j=1e-8, integrator=("Houbolt",))
    assert result.effort.highest_rung >= 1
    assert result.effort.failures > 2
    assert sum(result.effort.counts[1:]) > 2
    assert "failed" in log.read_text(encoding="utf-8")
    assert_has_peaks(result)


def test_a_diverged_solution_is_a_numerical_failure_without_its_last_step(monkeypatch):
    # One percent of the bridge's weight at a contact represents the force of a lost solution.
    monkeypatch.setattr("skewbridge.analysis.transient.MAX_CONTACT_WEIGHTS", 0.01)
    result = run()
    assert (result.status, result.collapse_criterion) == ("numerical_failure", "")
    assert "the solution diverged: a contact carries" in result.messages[0]
    assert 0.0 < result.time_reached_s < result.duration_s
    assert all(math.isnan(result.demands[name]) for name in ENERGY)
    names = [name for name in result.histories if name.endswith("_normal_kn")]
    assert max(result.histories[name].max() for name in names) < 0.01 * 19_500.0
    assert_has_peaks(result)


TOO_STRICT = {
    "duration_s": 0.2, "max_iterations": 2, "tolerance_j": 1e-16, "reuse_tangent": False
}  # fmt: skip


def test_a_too_strict_tolerance_is_loosened_and_reported_and_changes_no_later_analysis(
    capfd, monkeypatch
):
    clean = run(duration_s=1.0)
    result = run(**TOO_STRICT)
    assert capfd.readouterr() == ("", ""), "OpenSees prints nothing"
    assert result.status == "ok"
    assert result.effort.highest_rung == 2
    assert result.effort.failures > 1
    assert result.loosened_ratio > 0.0
    assert run(duration_s=1.0).demands == clean.demands
    # without further recovery steps it is a failure
    monkeypatch.setattr(StepLoop, "recovery_steps", RECOVERY_STEPS[:1])
    result = run(**TOO_STRICT)
    assert result.status == "numerical_failure"
    assert result.messages[0] == "no recovery step converged"
    assert result.effort.failures == 1


def test_bad_factors_are_refused_before_anything_runs():
    for factors, words in (
        ({"scale": 0.0}, "scale must be a positive number, got 0"),
        ({"scale": -1.0}, "scale"),
        ({"scale": math.nan}, "scale"),
        ({"incidence_deg": math.inf}, "incidence_deg"),
        ({"scale": 1000.0}, "peak acceleration must be at most 1000 m/s2"),
    ):
        with pytest.raises(InputError, match=words):
            run(**factors)


def test_histories_are_equally_spaced_over_the_window_and_the_free_vibration():
    result = run(duration_s=2.0, free_vibration_s=0.5)
    assert result.duration_s == pytest.approx(2.5)
    assert result.time_reached_s == pytest.approx(2.5)
    assert result.effort.substeps > 10
    spacing = np.diff(result.histories["t_s"])
    assert spacing == pytest.approx(AnalysisSettings().dt_s, rel=1e-6)
    openings = [name for name in result.histories if name.endswith("_opening_m")]
    assert min(result.histories[name].min() for name in openings) < 0.0
    quiet = result.histories["t_s"] > 2.01
    assert np.all(result.histories["ground_ax_mps2"][quiet] == 0.0)
    assert np.any(result.histories["ground_ax_mps2"][~quiet] != 0.0)
