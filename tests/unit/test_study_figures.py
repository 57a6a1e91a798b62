"""Figures of a study follow its tables: any axes, captions with computed numbers."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from fragility_tables import paired_effects, synthetic_demands
from skewbridge.files.tables import write_frame
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.effects import effect_tables
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.median_effects import median_effects
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.report.axis_layout import VariantLayout, shown_axes, shown_in
from skewbridge.report.fragility_figures import demand_clouds, fragility_curves
from skewbridge.report.study_figures import (
    FigureTables,
    draw_study,
    read_captions,
    study_figures,
)
from skewbridge.study.config import FigureSettings
from skewbridge.variant import axes as axis_table

FOURTH = "transverse_gap_mm"
STATES = limit_states_of(
    [
        {
            "component": "column_drift",
            "demand": "column_drift_ratio",
            "unit": "ratio",
            "dispersion": 0.3,
            "citation": "made up",
            "states": {"slight": 0.01, "moderate": 0.02},
        },
        {
            "component": "bearing",
            "demand": "bearing_disp_m",
            "unit": "m",
            "dispersion": 0.3,
            "citation": "made up",
            "states": {"slight": 0.1},
        },
    ]
)


@pytest.fixture
def fourth_axis(monkeypatch):
    """Return another gap beside the joint gap, in the table of axes."""
    if not axis_table.axes_of([FOURTH]):
        gap = axis_table.axes_of(["gap_mm"])[0]
        other = replace(
            gap, name=FOURTH, label="Transverse gap", title="the transverse gap", code="tgap"
        )
        monkeypatch.setattr(axis_table, "AXES", (*axis_table.AXES, other))
    return axis_table.axes_of([FOURTH])[0]


def tables_of(demands, curves, effects, **tables):
    wave = np.sin(np.arange(400) * 0.1)
    motion = GroundMotion(motion_id="m00", dt_s=0.01, accel_1_mps2=wave, accel_2_mps2=0.5 * wave)
    suite = [SuiteMotion(motion=motion, scale=1.5, measures={})]
    none = {"medians": effects.head(0), "intensity_effects": effects.head(0)}
    given = none | tables
    return FigureTables(
        demands=demands, curves=curves, effects=effects, suite=suite, pair=None, **given
    )


@pytest.fixture(scope="module")
def study():
    demands = synthetic_demands(skews=(0, 30))
    reference = {("osb1", "contact_friction"): 0.5}
    effects, intensities = effect_tables(demands, reference_im=reference)
    medians = median_effects(demands, STATES, DEFAULTS)
    curves = fit_study(demands, STATES, DEFAULTS)
    return tables_of(demands, curves, effects, medians=medians, intensity_effects=intensities)


@pytest.fixture(scope="module")
def wide_study():
    """The same with a transverse gap of 25 and 50 mm."""
    parts = []
    for gap_mm, seed in ((25, 1), (50, 2)):
        demands = synthetic_demands(skews=(0, 30), seed=seed, friction_effect=-0.004 * gap_mm)
        demands["variant"] += f"_tgap{gap_mm:03d}"
        curves = fit_study(demands, STATES, DEFAULTS)
        parts.append([t.assign(**{FOURTH: gap_mm}) for t in (demands, curves)])
        effects = paired_effects(demands)
        parts[-1].append(effects.assign(**{FOURTH: gap_mm}))
    demands, curves, effects = (
        pd.concat(own, ignore_index=True) for own in zip(*parts, strict=True)
    )
    along = effects[(effects["axis"] == "friction") & (effects[FOURTH] == 25)]
    along = along.assign(axis=FOURTH, from_value=25, to_value=50, **{FOURTH: float("nan")})
    both = [along.assign(friction=value) for value in (0.0, 0.5)]
    return tables_of(demands, curves, pd.concat([effects, *both], ignore_index=True))


def test_lines_and_marks_of_all_variants_differ(study):
    styles = list(VariantLayout.of(study.demands).styles.values())
    assert len({(style["color"], style["linestyle"], style["marker"]) for style in styles}) == 4
    own = [style for style in styles if style["linestyle"] == "-"]
    assert own[0]["linewidth"] > 2 * own[1]["linewidth"]  # drawn first, seen on both sides


def test_notes_and_names_of_states_are_outside_the_panels_of_a_cloud(study):
    demands = study.demands.copy()
    demands.loc[demands["motion_id"] == "m00", "column_drift_ratio"] = 1e-9
    figure = demand_clouds(demands, study.curves, "column_drift_ratio")
    figure.canvas.draw()
    said = {text.get_text(): text for axes in figure.axes for text in axes.texts}
    assert {"slight", "moderate"} < set(said)
    assert any(text.startswith("4 of") and "analyses below" in text for text in said)
    for text in said.values():
        box, panel = text.get_window_extent(), text.axes.get_window_extent()
        assert box.y0 >= panel.y1 or box.x0 >= panel.x1


def titles(figure):
    return [axes.get_title() for axes in figure.axes]


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_three_axes_have_panels_dashes_and_colours(study):
    figure = demand_clouds(study.demands, study.curves, "column_drift_ratio")
    assert titles(figure) == ["skew 0°", "skew 30°"]
    assert legend(figure)[:2] == ["gap 25 mm, μ 0", "gap 25 mm, μ 0.5"]
    styles = VariantLayout.of(study.demands).styles
    assert styles[25, 0.0]["color"] == styles[51, 0.0]["color"] != styles[25, 0.5]["color"]
    assert styles[25, 0.0]["linestyle"] == styles[25, 0.5]["linestyle"]


def test_varying_axes_replace_constant_ones(fourth_axis, wide_study):
    table = wide_study.demands
    assert [axis.name for axis in shown_axes(table)] == ["skew_deg", "gap_mm", "friction", FOURTH]
    assert [axis.name for axis in shown_axes(table[table["gap_mm"] == 25])] == [
        "skew_deg",
        "friction",
        FOURTH,
    ]
    assert len(shown_axes(table[table[FOURTH] == 25])) == 3


@pytest.mark.parametrize("kind", ["clouds", "curves"])
def test_a_fourth_axis_multiplies_the_panels(fourth_axis, wide_study, kind):
    if kind == "clouds":
        figure = demand_clouds(wide_study.demands, wide_study.curves, "column_drift_ratio")
    else:
        figure = fragility_curves(
            wide_study.curves, wide_study.demands, wide_study.medians, "column_drift"
        )
    assert titles(figure)[:4] == [
        "skew 0°, transverse gap 25 mm",
        "skew 0°, transverse gap 50 mm",
        "skew 30°, transverse gap 25 mm",
        "skew 30°, transverse gap 50 mm",
    ]
    assert len(legend(figure)) == 4


def test_list_of_figures_follows_limit_states_and_axes(study):
    names = [caption.name.removeprefix("osb1_cf_") for caption, _ in study_figures(study)]
    assert names == [
        "curves_column_drift",
        "curves_bearing",
        "cloud_column_drift_ratio",
        "cloud_bearing_disp_m",
        "effects_by_intensity",
        "suite_spectra",
    ]


def test_no_figure_without_a_plot(study):
    curves = study.curves.assign(preferred=False, theta_bracket_low=np.nan)
    nothing = replace(
        study,
        demands=study.demands.assign(bearing_disp_m=0.0),
        curves=curves,
        effects=study.effects.head(0),
        medians=study.medians.head(0),
        intensity_effects=study.intensity_effects.head(0),
    )
    names = [caption.name for caption, _ in study_figures(nothing)]
    assert names == ["osb1_cf_cloud_column_drift_ratio", "suite_spectra"]


def test_numbers_of_captions_are_those_of_the_tables(study):
    captions = {caption.name: caption.text for caption, _ in study_figures(study)}
    drawn = study.curves[study.curves["preferred"]]
    drawn = drawn[drawn["component"] == "column_drift"]
    clouds = int((drawn["method"] == "cloud").sum())
    assert f"{clouds} from cloud fits" in captions["osb1_cf_curves_column_drift"]
    assert "Sa,avg RotD50 (g) 0.5." in captions["osb1_cf_effects_by_intensity"]


def test_findings_are_computed_from_the_tables(study):
    captions = {caption.name: caption for caption, _ in study_figures(study)}
    assert all(caption.finding.endswith(".") for caption in captions.values())
    demands, curves = study.demands, study.curves
    least = curves.loc[curves["demand"] == "bearing_disp_m", "threshold"].min()
    above = int((demands["bearing_disp_m"] > least).sum())
    assert captions["osb1_cf_cloud_bearing_disp_m"].finding == (
        f"{above} of {len(demands)} analyses exceed bearing, slight (100 mm)."
    )
    medians = study.medians
    rows = medians[(medians["scope"] == "pooled") & medians["demand"].str.startswith("column_dr")]
    certain = rows[rows["verdict_family"].isin(["lower", "higher"])]
    finding = captions["osb1_cf_curves_column_drift"].finding
    assert ("the largest certain change" in finding) == (len(certain) > 0)


def test_figures_in_us_units_have_inches(study):
    with shown_in("us"):
        captions = {caption.name: caption for caption, _ in study_figures(study)}
        figure = demand_clouds(study.demands, study.curves, "bearing_disp_m")
    assert "(3.94 in)" in captions["osb1_cf_cloud_bearing_disp_m"].finding
    assert figure.axes[0].get_ylabel().endswith("(in)")
    drawn = [line.get_ydata() for line in figure.axes[0].lines if line.get_marker() == "o"]
    largest = study.demands.loc[study.demands["skew_deg"] == 0, "bearing_disp_m"].max() / 0.0254
    assert max(max(values) for values in drawn if len(values)) <= largest * (1 + 1e-9)
    assert "gap 0.984 in, μ 0" in legend(figure)


def test_files_do_not_depend_on_the_number_of_processes(study, tmp_path, monkeypatch):
    names = ("demands", "curves", "effects", "medians", "intensity_effects")
    small = replace(study, effects=study.effects.head(0), medians=study.medians.head(0))
    small = replace(small, intensity_effects=study.intensity_effects.head(0))
    tables = {name: getattr(small, name) for name in names} | {"friction_pair": pd.DataFrame()}
    paths = {"suite": tmp_path / "none"}
    for name, table in tables.items():
        paths[name] = tmp_path / f"{name}.parquet"
        write_frame(table, paths[name], {})
    monkeypatch.setattr("skewbridge.report.study_figures.read_suite", lambda _: study.suite)
    monkeypatch.setattr("skewbridge.report.study_figures.FIGURES_OF_A_PROCESS", 1)
    texts = []
    for n_jobs in (1, 2):
        folder, captions = tmp_path / str(n_jobs), tmp_path / f"{n_jobs}.json"
        draw_study(
            paths, folder=folder, captions=captions, settings=FigureSettings(), n_jobs=n_jobs
        )
        texts.append(captions.read_text())
        drawn = {caption.name for caption in read_captions(captions)}
        files = {f"{name}.{ending}" for name in drawn for ending in ("svg", "png")}
        assert {path.name for path in folder.iterdir()} == files
        assert "suite_spectra" in drawn
    assert texts[0] == texts[1]
