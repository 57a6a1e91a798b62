"""Figures of fragility, effects and histories draw the numbers of their tables."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.effects import effect_tables
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.settings import FitSettings
from skewbridge.report import axis_layout
from skewbridge.report.axis_layout import MARKS
from skewbridge.report.effect_figures import effects_by_intensity
from skewbridge.report.fragility_figures import (
    curve_values,
    demand_clouds,
    fragility_curves,
    least_shown,
    methods_note,
    shown_curves,
)
from skewbridge.report.run_figures import frequency_figure, moving_columns

SETTINGS = FitSettings()
STATES = limit_states_of(
    [
        {
            "component": "column_drift",
            "demand": "column_drift_ratio",
            "unit": "percent",
            "dispersion": 0.35,
            "citation": "test",
            "states": {"slight": 1.0, "moderate": 2.5, "complete": 90.0},
        }
    ]
)
DRIFT = "column_drift_ratio"


def tables_of(demands):
    intensities = effect_tables(demands, reference_im={("osb1", "contact_friction"): 0.5})
    return (
        fit_study(demands, STATES, SETTINGS),
        intensities,
        median_effects(demands, STATES, SETTINGS),
    )


@pytest.fixture(scope="module")
def demands():
    table = synthetic_demands(skews=(0, 30), run_scatter=0.05)
    table.loc[4, "status"] = "timeout"
    return table


@pytest.fixture(scope="module")
def tables(demands):
    return tables_of(demands)


def texts(figure):
    figure.canvas.draw()
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def lines_drawn(figure, variant_count):
    return [
        line
        for axes in figure.axes
        for line in axes.lines
        if len(line.get_xdata()) == variant_count
    ]


def test_drawn_curves_are_the_preferred_rows_with_the_total_dispersion(demands, tables):
    curves, _, medians = tables
    figure = fragility_curves(curves, demands, medians, "column_drift")
    preferred = curves[curves["preferred"]]
    drawn = lines_drawn(figure, 160)
    assert len(drawn) == len(preferred) == 8 * 2
    found = sorted(float(np.interp(0.5, line.get_ydata(), line.get_xdata())) for line in drawn)
    np.testing.assert_allclose(found, sorted(preferred["theta"]), rtol=0.01)
    item = preferred.iloc[0]
    im = np.array([0.1, 0.5])
    values, (low, high) = curve_values(im, item)
    expected = stats.norm.cdf(np.log(im / item["theta"]) / item["beta_total"])
    np.testing.assert_allclose(values, expected)
    assert item["beta_total"] > item["beta"]
    assert (low < values).all()
    assert (values < high).all()


def test_state_that_no_run_reached_is_listed_and_has_no_panel(demands, tables):
    curves, _, medians = tables
    figure = fragility_curves(curves, demands, medians, "column_drift")
    labels = " ".join(axes.get_ylabel() for axes in figure.axes)
    assert "moderate" in labels
    assert "complete" not in labels
    title = figure.get_suptitle()
    assert "complete, no curve: Column drift ratio: largest 0." in title
    assert "state at 0.9" in title


def test_curves_that_depend_on_the_method_are_marked(demands, tables):
    curves, medians = tables[0].copy(), tables[2]
    cloud = curves["preferred"] & (curves["limit_state"] == "slight") & (curves["skew_deg"] == 30)
    curves["methods_differ"] = False
    curves.loc[cloud, ["methods_differ", "methods_ratio"]] = [True, 1.28]
    figure = fragility_curves(curves, demands, medians, "column_drift")
    assert sum("exceedance median +28 %" in text for text in texts(figure)) == 1
    marks = [line for axes in figure.axes for line in axes.lines if line.get_marker() == "D"]
    assert len([mark for mark in marks if len(mark.get_xdata())]) == cloud.sum()
    assert methods_note(curves[~cloud]) == ""


def test_panels_without_a_curve_give_the_reason(demands, tables):
    curves, medians = tables[0].copy(), tables[2]
    lost = curves["skew_deg"] == 30
    curves.loc[lost, "preferred"] = False
    curves.loc[lost, "status"] = "bounds_too_wide"
    figure = fragility_curves(curves, demands, medians, "column_drift")
    assert any("4 of 4 without a curve: bounds too wide" in text for text in texts(figure))


def test_separated_outcomes_are_drawn_as_a_bracket_of_the_median():
    demands = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=12)
    hit = demands[IM] > 0.5
    demands[DRIFT] = np.where(hit, 0.03, 0.008) * (1 + 0.1 * demands[IM])
    curves = fit_study(demands, STATES, SETTINGS)
    curves["preferred"] = False
    shown = shown_curves(curves)
    assert len(shown)
    none = pd.DataFrame({"demand": [], "scope": [], "status": []}, dtype=str)
    figure = fragility_curves(curves, demands, none, "column_drift")
    level = [line for axes in figure.axes for line in axes.lines if set(line.get_ydata()) == {0.5}]
    spans = {tuple(np.round(line.get_xdata(), 6)) for line in level}
    ends = shown[["theta_bracket_low", "theta_bracket_high"]].iloc[0]
    assert tuple(np.round(ends, 6)) in spans


def test_cloud_draws_runs_that_ended_early_open_with_a_tick(demands, tables):
    figure = demand_clouds(demands, tables[0], DRIFT)
    ticks = [line for line in figure.axes[0].get_lines() if line.get_marker() == 2]
    assert sum(len(line.get_xdata()) for line in ticks) == 1
    assert figure.axes[0].get_ylabel() == "Column drift ratio"


def test_demands_of_zero_are_drawn_at_the_bottom_and_counted(demands, tables):
    low = demands.copy()
    low.loc[low["motion_id"] == "m00", DRIFT] = 0.0
    figure = demand_clouds(low, tables[0], DRIFT)
    marks = [line for axes in figure.axes for line in axes.get_lines() if line.get_marker() == "v"]
    assert sum(len(line.get_xdata()) for line in marks) == (low[DRIFT] == 0.0).sum() == 8
    per_panel = int((low["skew_deg"] == 0).sum())
    assert any(text.startswith(f"4 of {per_panel} analyses below") for text in texts(figure))
    assert least_shown(demands.assign(**{DRIFT: 0.0}), tables[0], DRIFT) is None


def test_large_cloud_is_a_stated_sample(demands, tables, monkeypatch):
    assert demand_clouds(demands, tables[0], DRIFT).get_suptitle() == ""
    monkeypatch.setattr(axis_layout, "MAX_SHOWN_RUNS", 20)
    figure = demand_clouds(demands, tables[0], DRIFT)
    points = [
        len(line.get_xdata())
        for axes in figure.axes
        for line in axes.get_lines()
        if line.get_marker() in (*MARKS, "v")
    ]
    assert sum(points) == 20
    assert figure.get_suptitle().startswith(f"20 of {len(demands)} runs")


def test_a_panel_of_curves_has_two_bands_at_most(demands, tables):
    figure = fragility_curves(tables[0], demands, tables[2], "column_drift")
    panels = [axes for axes in figure.axes if "P(" in axes.get_ylabel() or axes.collections]
    curves = [axes for axes in panels if len(axes.lines) > 8]
    assert [len(axes.collections) for axes in curves] == [2] * len(curves)
    assert "gap 25 mm, μ 0 and gap 25 mm, μ 0.5" in figure.get_suptitle()


def test_ratios_of_medians_are_next_to_the_curves_with_their_intervals(demands, tables):
    curves, _, medians = tables
    figure = fragility_curves(curves, demands, medians, "column_drift")
    rows = medians[(medians["scope"] == "pooled") & (medians["status"] == "ok")]
    rows = rows[rows["demand"] == "column_drift/slight"]
    panel = next(axes for axes in figure.axes if axes.get_title().startswith("Ratio of medians"))
    intervals = [list(line.get_xdata()) for line in panel.lines if len(line.get_xdata()) == 2]
    for ends in rows[["ci_low", "ci_high"]].to_numpy().tolist():
        assert ends in intervals
    points = [line.get_xdata()[0] for line in panel.lines if line.get_marker() == "o"]
    assert points == rows["ratio"].tolist()
    labels = [label.get_text() for label in panel.get_yticklabels()]
    assert labels[0] == "Skew 0° to 30°"


def test_texts_of_a_figure_do_not_overlap(demands, tables):
    figure = fragility_curves(tables[0], demands, tables[2], "column_drift")
    figure.draw_without_rendering()
    boxes = [
        text.get_window_extent().padded(-1.0)
        for axes in figure.axes
        for text in (axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts)
        if text.get_text().strip() and text.get_window_extent().width > 2
    ]  # fmt: skip
    overlaps = [(a, b) for i, a in enumerate(boxes) for b in boxes[i + 1 :] if a.overlaps(b)]
    assert len(boxes) > 6
    assert not overlaps


def test_effects_by_intensity_are_lines_with_bands_and_a_reference(tables):
    table = tables[1].intensities
    figure = effects_by_intensity(table, "Sa (g)")
    panel = figure.axes[0]
    own = table[(table["demand"] == "column_shear_dcr") & (table["axis"] == "skew_deg")]
    line = next(line for line in panel.lines if len(line.get_xdata()) == len(own))
    own = own.sort_values("im")
    np.testing.assert_allclose(line.get_xdata(), own["im"])
    np.testing.assert_allclose(line.get_ydata(), own["ratio"])
    dot = next(line for line in panel.lines if line.get_marker() == "o")
    assert dot.get_xdata()[0] == pytest.approx(0.5)
    assert len(panel.collections) == 1


def test_frequency_figure_has_an_amplitude_and_a_ratio_per_direction():
    t_s = np.arange(0, 20, 0.01)
    histories = {}
    for name, period_s in (("friction 0", 1.0), ("friction 0.5", 0.8)):
        wave = np.sin(2 * np.pi * t_s / period_s) * np.exp(-0.1 * t_s)
        histories[name] = pd.DataFrame({"t_s": t_s, "deck_ux_m": wave, "deck_uy_m": 0.0 * wave})
    assert moving_columns(histories) == ["deck_ux_m"]
    figure = frequency_figure(histories)
    assert len(figure.axes) == 2
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels[1].startswith("friction 0.5, $T_m$ = 0.8")
    assert moving_columns({}) == []
