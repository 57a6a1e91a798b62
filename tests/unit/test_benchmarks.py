"""Helpers of the benchmarks, which no other test runs."""

import re
from dataclasses import replace
from statistics import median

import numpy as np
import overhead
import pytest
import speedup
from common import Case, osb1, suite_motion
from plain import PlainRun
from reference_pages import ROOT
from residual_drift import oscillator_peaks


def test_motions_of_benchmarks_have_the_factors_of_a_study():
    # peak of the file and factor that the index stored before studies computed factors
    peak_mps2 = np.abs(suite_motion("syn005").accel_1_mps2).max()
    assert peak_mps2 == pytest.approx(0.438018 * 2.4660003126, rel=1e-9)


def test_recorded_commands_solve_the_equations_of_the_analysis():
    task, *_ = overhead.tasks_of_study(1)
    found = overhead.measure(replace(task, settings=replace(task.settings, duration_s=1.0)), 1)
    assert found["largest_difference_of_last_disp_m"] < 1e-12  # rounding of displacements in mm
    assert found["overhead"]["count"] == 1


def test_speedup_compares_both_programs_with_the_reference(monkeypatch):
    demands = dict.fromkeys(speedup.DEMANDS, 1.1)
    steps = {"status": "ok", "failed_steps": 0, "steps": 1, "iterations": 1}
    run = PlainRun(**steps, time_reached_s=2.5, cpu_s=10.0, demands=demands)
    monkeypatch.setattr(speedup, "analyse_plain", lambda case: run)
    monkeypatch.setattr(speedup, "_reference", lambda *_: dict.fromkeys(demands, 1.0))
    case = Case(variant=osb1(30, 25), motion=suite_motion("syn005", 2.5), window_s=2.5)
    found = speedup.summary([speedup.measured(case, case, "fast", 1, None)])
    assert found["speedup"]["count"] == 1
    assert found["error_percent"]["unseating_m"]["plain"]["median"] == pytest.approx(10.0)


def test_oscillators_keep_the_residual_displacements_stated_in_the_theory():
    text = " ".join((ROOT / "docs/theory/bridge.md").read_text(encoding="utf-8").split())
    stated = re.search(r"Takeda's rule keep (\d+) %, bilinear ones (\d+) %", text)
    peaks = [oscillator_peaks(rule) for rule in ("takeda", "bilinear")]
    shares = [100.0 * median(ratio for ratio, _ in of_rule) for of_rule in peaks]
    assert stated
    assert [round(share) for share in shares] == [*map(int, stated.groups())]
