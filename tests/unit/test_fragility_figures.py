"""Figures: they draw what the tables say, and say why where there is nothing to draw."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.report import sampled_runs
from skewbridge.report.axis_layout import MARKS
from skewbridge.report.effect_figures import paired_ratios, verdict_map
from skewbridge.report.fragility_figures import demand_clouds, fragility_curves
from skewbridge.report.run_figures import frequency_figure

STATES = [
    state
    for state in load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
    if state.component in {"column_drift", "column_shear"}
]


@pytest.fixture(scope="module")
def tables():
    demands = synthetic_demands(skews=(0, 30))
    demands.loc[4, "status"] = "timeout"
    return demands, fit_study(demands, STATES, IM), paired_effects(demands)


def texts(figure):
    figure.canvas.draw()
    return [t.get_text() for axes in figure.axes for t in axes.texts]


def test_verdict_map_has_a_cell_per_demand_and_variant(tables):
    _, _, effects = tables
    figure = verdict_map(effects)
    rows = effects[(effects["axis"] == "friction") & (effects["scope"] == "variant")]
    assert len(figure.axes[0].patches) == len(rows)
    outside = rows["verdict"].isin(["lower", "higher"]).sum()
    bold = [t for t in figure.axes[0].texts if t.get_fontweight() == "bold"]
    assert len(bold) == outside > 0


def test_curves_have_a_panel_per_state_and_skew_with_a_band_each(tables):
    demands, curves, _ = tables
    figure = fragility_curves(curves, demands, "column_drift")
    drawn = curves[
        (curves["component"] == "column_drift")
        & (curves["method"] == "cloud")
        & (curves["status"] == "ok")
    ]
    assert len(figure.axes) == 2 * drawn["limit_state"].nunique()
    assert sum(len(axes.collections) for axes in figure.axes) == len(drawn)


def test_panels_without_a_curve_say_why(tables):
    demands, curves, _ = tables
    partly = curves.copy()
    partly.loc[partly["skew_deg"] == 30, "status"] = "no_exceedance"
    figure = fragility_curves(partly, demands, "column_drift")
    assert any("no exceedance" in text for text in texts(figure))
    nothing = fragility_curves(curves[curves["limit_state"] == "dcr_100"], demands, "column_shear")
    assert "no_exceedance" in nothing.texts[0].get_text()


def test_a_cloud_says_how_many_runs_lie_far_below_the_limit_states(tables):
    demands, curves, _ = tables
    low = demands.copy()
    low.loc[low["motion_id"] == "m00", "column_drift_ratio"] = 0.0
    figure = demand_clouds(low, curves, "column_drift_ratio")
    own = int((low["skew_deg"] == low["skew_deg"].min()).sum())
    assert any(f"of {own} analyses below" in text for text in texts(figure))
    none = demand_clouds(demands.assign(column_drift_ratio=0.0), curves, "column_drift_ratio")
    assert "in no analysis above" in none.texts[0].get_text()


def test_cloud_draws_failed_runs_open(tables):
    demands, curves, _ = tables
    figure = demand_clouds(demands, curves, "column_drift_ratio")
    marks = [line for line in figure.axes[0].get_lines() if line.get_marker() == "^"]
    assert sum(len(line.get_xdata()) for line in marks) == 1
    assert figure.axes[0].get_ylabel() == "Column drift ratio"


def test_a_large_cloud_is_a_sample_and_says_so(tables, monkeypatch):
    demands, curves, _ = tables
    assert demand_clouds(demands, curves, "column_drift_ratio").get_suptitle() == ""
    monkeypatch.setattr(sampled_runs, "MAX_SHOWN_RUNS", 20)
    figure = demand_clouds(demands, curves, "column_drift_ratio")
    points = [
        len(line.get_xdata())
        for axes in figure.axes
        for line in axes.get_lines()
        if line.get_marker() in (*MARKS, "^")
    ]
    assert sum(points) == 20
    assert figure.get_suptitle().startswith(f"20 of {len(demands)} runs")


@pytest.mark.parametrize("axis", ["friction", "gap_mm", "skew_deg"])
def test_ratios_draw_every_interval(tables, axis):
    _, _, effects = tables
    figure = paired_ratios(effects, axis)
    rows = effects[(effects["axis"] == axis) & (effects["scope"] == "variant")]
    rows = rows[rows["judged_by"] == "ratio"]
    dots = [line for line in figure.axes[0].get_lines() if line.get_marker() in (*MARKS, "<", ">")]
    assert len(dots) == len(rows)
    assert np.isfinite([dot.get_xdata()[0] for dot in dots]).all()


def test_an_axis_that_does_not_vary_is_said(tables):
    _, _, effects = tables
    figure = paired_ratios(effects[effects["axis"] != "gap_mm"], "gap_mm")
    assert "gap_mm" in figure.texts[0].get_text()


def test_frequency_figure_has_an_amplitude_and_a_ratio_per_direction():
    t_s = np.arange(0, 20, 0.01)
    histories = {}
    for name, period_s in (("friction 0", 1.0), ("friction 0.5", 0.8)):
        wave = np.sin(2 * np.pi * t_s / period_s) * np.exp(-0.1 * t_s)
        histories[name] = pd.DataFrame({"t_s": t_s, "deck_ux_m": wave, "deck_uy_m": 0.0 * wave})
    figure = frequency_figure(histories)
    assert len(figure.axes) == 2  # the deck does not move transversely
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels[1].startswith("friction 0.5, $T_m$ = 0.8")
    assert "two histories" in frequency_figure({}).texts[0].get_text()


def test_a_ratio_beyond_the_axis_is_an_arrow_with_its_value(tables):
    _, _, effects = tables
    far = effects.copy()
    own = (far["demand"] == "unseating_m") & (far["scope"] == "variant")
    far.loc[own, ["ratio", "ci_low", "ci_high"]] = [5.2, 3.0, 9.0]
    far.loc[own & (far["axis"] == "friction").to_numpy() & (far["skew_deg"] == 0), "ratio"] = 4.0
    figure = paired_ratios(far)
    assert "▶ 4 to 5.2" in texts(figure)  # one text for all arrows of a demand: none hides another
    assert figure.axes[0].get_xlim()[1] == 2.0


def test_separated_outcomes_are_drawn_as_a_bracket_of_the_median():
    demands = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=12)
    hit = demands[IM] > 0.5
    demands["column_drift_ratio"] = np.where(hit, 0.03, 0.008) * (1 + 0.1 * demands[IM])
    curves = fit_study(demands, STATES, IM)
    own = curves[(curves["component"] == "column_drift") & (curves["method"] == "exceedance")]
    apart = own[own["status"] == "complete_separation"]
    assert len(apart)
    assert (apart["theta_bound_low"] < apart["theta_bracket_low"]).all()
    assert (apart["theta_bracket_high"] < apart["theta_bound_high"]).all()
    figure = fragility_curves(curves, demands, "column_drift", "exceedance")
    level = [line for axes in figure.axes for line in axes.lines if set(line.get_ydata()) == {0.5}]
    spans = {tuple(np.round(line.get_xdata(), 6)) for line in level}
    bracket = apart[["theta_bracket_low", "theta_bracket_high"]].iloc[0]
    assert tuple(np.round(bracket, 6)) in spans
