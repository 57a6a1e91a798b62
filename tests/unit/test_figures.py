"""Figures draw the numbers of their tables, follow limit states and axes, and fit a paper."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from scipy import stats
from typer.testing import CliRunner

from fragility_tables import (
    DRIFT_ENTRY,
    FAILURES,
    IM,
    curves_of,
    synthetic_demands,
    two_mode_runs,
)
from skewbridge.cli import build_app
from skewbridge.files.tables import write_frame
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.effects import effect_tables
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.settings import FitSettings
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.report import fragility_figures
from skewbridge.report.appearance import MARKS, VariantLayout, shown_axes, shown_in
from skewbridge.report.fragility_figures import (
    curve_values,
    demand_clouds,
    effects_by_intensity,
    fragility_curves,
    least_shown,
    shown_curves,
)
from skewbridge.report.study_figures import (
    FigureTables,
    draw_study,
    read_captions,
    save_figure,
    study_figures,
)
from skewbridge.study.config import FigureSettings
from skewbridge.study.folder import write_starter

SETTINGS = FitSettings()
BEARING = {"component": "bearing", "demand": "bearing_disp_m", "unit": "m", "dispersion": 0.3,
           "citation": "made up", "states": {"slight": 0.1}}  # fmt: skip
DRIFTS = DRIFT_ENTRY | {"states": {"slight": 1.0, "moderate": 2.5, "complete": 90.0}}
STATES = limit_states_of([DRIFTS, BEARING])
DRIFT = "column_drift_ratio"


@pytest.fixture(scope="module")
def demands():
    table = synthetic_demands(skews=(0, 30), run_scatter=0.05)
    table.loc[4, "status"] = "timeout"
    return table


@pytest.fixture(scope="module")
def tables(demands):
    """Return curves, and effects with those by intensity."""
    return (
        fit_study(demands, STATES, SETTINGS),
        effect_tables(demands, reference_im={("osb1", "contact_friction"): 0.5}),
    )


def texts(figure):
    figure.canvas.draw()
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def lines_of(figure, *markers):
    """Return all lines of a figure, or those with a marker."""
    lines = [line for axes in figure.axes for line in axes.lines]
    return [line for line in lines if not markers or line.get_marker() in markers]


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def points_of(lines):
    return sum(len(line.get_xdata()) for line in lines)


def test_drawn_curves_are_the_preferred_rows_with_the_total_dispersion(demands, tables):
    curves = tables[0]
    figure = fragility_curves(curves, demands, "column_drift")
    preferred = curves[curves["preferred"] & (curves["component"] == "column_drift")]
    drawn = [line for line in lines_of(figure) if len(line.get_xdata()) == 160]
    assert len(drawn) == len(preferred) == 8 * 2
    found = sorted(float(np.interp(0.5, line.get_ydata(), line.get_xdata())) for line in drawn)
    np.testing.assert_allclose(found, sorted(preferred["theta"]), rtol=0.01)
    item = preferred.iloc[0]
    im = np.array([0.1, 0.5])
    values, (low, high) = curve_values(im, item)
    expected = stats.norm.cdf(np.log(im / item["theta"]) / item["beta_total"])
    np.testing.assert_allclose(values, expected)
    assert item["beta_total"] > item["beta"]
    assert ((low < values) & (values < high)).all()
    panels = [axes for axes in figure.axes if len(axes.lines) > 8]
    assert [len(axes.collections) for axes in panels] == [2] * len(panels)  # bands
    assert "gap 25 mm, μ 0 and gap 25 mm, μ 0.5" in figure.get_suptitle()


def test_states_and_panels_without_a_curve_give_the_reason_and_no_texts_overlap(demands, tables):
    curves = tables[0]
    figure = fragility_curves(curves, demands, "column_drift")
    labels = " ".join(axes.get_ylabel() for axes in figure.axes)
    assert "moderate" in labels
    assert "complete" not in labels
    title = figure.get_suptitle()
    assert "complete, no curve: Column drift ratio: largest 0." in title
    assert "state at 0.9" in title
    curves = curves.copy()
    lost = curves["skew_deg"] == 30
    curves.loc[lost, "preferred"] = False
    curves.loc[lost, "status"] = "bounds_too_wide"
    figure = fragility_curves(curves, demands, "column_drift")
    assert any("4 of 4 without a curve: bounds too wide" in text for text in texts(figure))
    boxes = [
        text.get_window_extent().padded(-1.0)
        for axes in figure.axes
        for text in (axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts)
        if text.get_text().strip() and text.get_window_extent().width > 2
    ]  # fmt: skip
    overlaps = [(a, b) for i, a in enumerate(boxes) for b in boxes[i + 1 :] if a.overlaps(b)]
    assert len(boxes) > 6
    assert not overlaps


def test_curves_of_exceedance_fits_have_crosses_and_those_that_differ_diamonds(demands, tables):
    curves = tables[0].copy()
    curves["methods_differ"] = False
    assert not lines_of(fragility_curves(curves, demands, "column_drift"), "x", "D")
    state = (curves["component"] == "column_drift") & (curves["limit_state"] == "slight")
    state &= curves["skew_deg"] == 30
    fitted = state & (curves["method"] == "exceedance") & (curves["status"] == "ok")
    assert fitted.any()
    names = curves.loc[fitted, "variant"]
    curves.loc[state & curves["variant"].isin(names), "preferred"] = False
    curves.loc[fitted, ["preferred", "methods_differ"]] = True
    figure = fragility_curves(curves, demands, "column_drift")
    assert len(lines_of(figure, "x")) == len(lines_of(figure, "D")) == fitted.sum()
    assert {"exceedance fit", "median, other method"} < set(legend(figure))


def test_separated_outcomes_are_drawn_as_a_bracket_of_the_median():
    demands = synthetic_demands(skews=(0,), gaps=(51,), frictions=(50,), motions=12)
    hit = demands[IM] > 0.5
    demands[DRIFT] = np.where(hit, 0.03, 0.008) * (1 + 0.1 * demands[IM])
    curves = fit_study(demands, STATES, SETTINGS)
    curves["preferred"] = False
    shown = shown_curves(curves)
    assert len(shown)
    figure = fragility_curves(curves, demands, "column_drift")
    level = [line for line in lines_of(figure) if set(line.get_ydata()) == {0.5}]
    spans = {tuple(np.round(line.get_xdata(), 6)) for line in level}
    ends = shown[["theta_bracket_low", "theta_bracket_high"]].iloc[0]
    assert tuple(np.round(ends, 6)) in spans


def test_cloud_marks_runs_that_ended_early_and_demands_of_zero(demands, tables):
    figure = demand_clouds(demands, tables[0], DRIFT)
    assert points_of(lines_of(figure, 2)) == 1  # a tick
    assert figure.axes[0].get_ylabel() == "Column drift ratio"
    low = demands.copy()
    low.loc[low["motion_id"] == "m00", DRIFT] = 0.0
    figure = demand_clouds(low, tables[0], DRIFT)
    assert points_of(lines_of(figure, "v")) == (low[DRIFT] == 0.0).sum() == 8
    per_panel = int((low["skew_deg"] == 0).sum())
    assert any(text.startswith(f"4 of {per_panel} analyses below") for text in texts(figure))
    notes = [text for axes in figure.axes for text in axes.texts]
    assert {"slight", "moderate"} < {note.get_text() for note in notes}
    for note in notes:  # outside the panels
        box, panel = note.get_window_extent(), note.axes.get_window_extent()
        assert box.y0 >= panel.y1 or box.x0 >= panel.x1
    assert least_shown(demands.assign(**{DRIFT: 0.0}), tables[0], DRIFT) is None


def test_marks_of_a_large_cloud_are_pixels_in_a_vector_file(demands, tables, monkeypatch):
    def drawn_as_pixels():
        marks = lines_of(demand_clouds(demands, tables[0], DRIFT), *MARKS, "v")
        assert points_of(marks) == len(demands)
        return {bool(line.get_rasterized()) for line in marks}

    assert drawn_as_pixels() == {False}
    monkeypatch.setattr(fragility_figures, "MAX_VECTOR_RUNS", 20)
    assert drawn_as_pixels() == {True}


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


# --- figures of a study


FOURTH = "transverse_gap_mm"


@pytest.fixture(scope="module")
def study(demands, tables):
    wave = np.sin(np.arange(400) * 0.1)
    motion = GroundMotion(motion_id="m00", dt_s=0.01, accel_1_mps2=wave, accel_2_mps2=0.5 * wave)
    curves, effects = tables
    return FigureTables(
        demands=demands,
        curves=curves,
        effects=effects.effects,
        intensity_effects=effects.intensities,
        suite=[SuiteMotion(motion=motion, scale=1.5, measures={})],
        pair=None,
    )


@pytest.fixture(scope="module")
def wide_study():
    """Return demands and curves with a transverse gap of 25 and 50 mm."""
    parts = []
    for gap_mm, seed in ((25, 1), (50, 2)):
        rows = synthetic_demands(skews=(0, 30), seed=seed, friction_effect=-0.004 * gap_mm)
        rows["variant"] += f"_tgap{gap_mm:03d}"
        curves = fit_study(rows, STATES, SETTINGS)
        parts.append([table.assign(**{FOURTH: gap_mm}) for table in (rows, curves)])
    return [pd.concat(each, ignore_index=True) for each in zip(*parts, strict=True)]


def titles(figure):
    return [axes.get_title() for axes in figure.axes]


def test_three_axes_have_panels_dashes_and_colours(study):
    figure = demand_clouds(study.demands, study.curves, DRIFT)
    assert titles(figure) == ["skew 0°", "skew 30°"]
    assert legend(figure)[:2] == ["gap 25 mm, μ 0", "gap 25 mm, μ 0.5"]
    styles = VariantLayout(study.demands).styles
    looks = {(each["color"], each["linestyle"], each["marker"]) for each in styles.values()}
    assert len(looks) == len(styles) == 4
    assert styles[25, 0.0]["color"] == styles[51, 0.0]["color"] != styles[25, 0.5]["color"]
    assert styles[25, 0.0]["linestyle"] == styles[25, 0.5]["linestyle"]
    solid = [style for style in styles.values() if style["linestyle"] == "-"]
    assert solid[0]["linewidth"] > 2 * solid[1]["linewidth"]  # drawn first, seen on both sides


def test_a_fourth_axis_replaces_constant_ones_or_multiplies_the_panels(wide_study):
    demands, curves = wide_study

    def shown(table):
        return [axis.name for axis in shown_axes(table)]

    assert shown(demands) == ["skew_deg", "gap_mm", "friction", FOURTH]
    assert shown(demands[demands["gap_mm"] == 25]) == ["skew_deg", "friction", FOURTH]
    assert len(shown(demands[demands[FOURTH] == 25])) == 3
    panels = [f"skew {skew}°, transverse gap {gap} mm" for skew in (0, 30) for gap in (25, 50)]
    for figure in (
        demand_clouds(demands, curves, DRIFT),
        fragility_curves(curves, demands, "column_drift"),
    ):
        assert titles(figure)[:4] == panels
        assert len(legend(figure)) == 4


def test_list_of_figures_follows_limit_states_and_leaves_out_empty_plots(study):
    names = [caption.name.removeprefix("osb1_cf_") for caption, _ in study_figures(study)]
    curves = ["curves_column_drift", "curves_bearing"]
    clouds = ["cloud_column_drift_ratio", "cloud_bearing_disp_m"]
    assert names == [*curves, *clouds, "effects_by_intensity", "suite_spectra"]
    nothing = replace(
        study,
        demands=study.demands.assign(bearing_disp_m=0.0),
        curves=study.curves.assign(preferred=False, theta_bracket_low=np.nan),
        effects=study.effects.head(0),
        intensity_effects=study.intensity_effects.head(0),
    )
    names = [caption.name for caption, _ in study_figures(nothing)]
    assert names == ["osb1_cf_cloud_column_drift_ratio", "suite_spectra"]


def test_captions_and_findings_have_the_numbers_of_the_tables(study):
    captions = {caption.name: caption for caption, _ in study_figures(study)}
    drawn = study.curves[study.curves["preferred"]]
    drawn = drawn[drawn["component"] == "column_drift"]
    of_curves = captions["osb1_cf_curves_column_drift"]
    assert f"{(drawn['method'] == 'cloud').sum()} from cloud fits" in of_curves.text
    assert "Sa,avg RotD50 (g) 0.5." in captions["osb1_cf_effects_by_intensity"].text
    assert all(caption.finding.endswith(".") for caption in captions.values())
    above = int((study.demands["bearing_disp_m"] > 0.1).sum())
    assert captions["osb1_cf_cloud_bearing_disp_m"].finding == (
        f"{above} of {len(study.demands)} analyses exceed bearing, slight (100 mm)."
    )
    mild = drawn.loc[drawn["limit_state"] == "slight", "theta"]
    assert f"(g) for slight (1 %): {mild.min():.3g} (skew" in of_curves.finding
    assert f") to {mild.max():.3g} (skew" in of_curves.finding


def test_figures_in_us_units_have_inches(study):
    with shown_in("us"):
        captions = {caption.name: caption for caption, _ in study_figures(study)}
        figure = demand_clouds(study.demands, study.curves, "bearing_disp_m")
    assert "(3.94 in)" in captions["osb1_cf_cloud_bearing_disp_m"].finding
    assert figure.axes[0].get_ylabel().endswith("(in)")
    drawn = [line.get_ydata() for line in lines_of(figure, "o") if len(line.get_ydata())]
    largest = study.demands["bearing_disp_m"].max() / 0.0254
    assert max(max(values) for values in drawn) <= largest * (1 + 1e-9)
    assert "gap 0.984 in, μ 0" in legend(figure)


def stored(folder, **tables):
    """Write tables as parquet files and return their paths."""
    paths = {name: folder / f"{name}.parquet" for name in tables}
    for name, table in tables.items():
        paths[name].parent.mkdir(parents=True, exist_ok=True)
        write_frame(table, paths[name], {})
    return paths


def test_files_do_not_depend_on_the_number_of_processes(study, tmp_path, monkeypatch):
    bearings = study.curves["component"] == "bearing"
    paths = stored(
        tmp_path,
        demands=study.demands[study.demands["skew_deg"] == 0],
        curves=study.curves[bearings & (study.curves["skew_deg"] == 0)],
        friction_pair=pd.DataFrame(),
        effects=study.effects.head(0),
        intensity_effects=study.intensity_effects.head(0),
        suite=pd.DataFrame(),
    )
    monkeypatch.setattr("skewbridge.report.study_figures.read_suite", lambda _: study.suite)
    monkeypatch.setattr("skewbridge.report.study_figures.FIGURES_OF_A_PROCESS", 1)
    texts = []
    for n_jobs in (1, 2):
        folder, captions = tmp_path / str(n_jobs), tmp_path / f"{n_jobs}.json"
        how = {"captions": captions, "settings": FigureSettings(), "n_jobs": n_jobs}
        draw_study(paths, folder=folder, **how)
        texts.append(captions.read_text())
        drawn = {caption.name for caption in read_captions(captions)}
        files = {f"{name}.{ending}" for name in drawn for ending in ("svg", "png")}
        assert {path.name for path in folder.iterdir()} == files
        assert "suite_spectra" in drawn
        assert len(drawn) == 3
    assert texts[0] == texts[1]


# --- files for a paper


PT_PER_MM = 72 / 25.4


def drawn():
    figure = Figure(figsize=(6.0, 3.0), layout="constrained")
    axes = figure.subplots()
    axes.set_xlabel("Intensity (g)", fontsize=9)
    return figure


def saved(folder, **settings):
    folder.mkdir(exist_ok=True)
    vector, pixels = save_figure(drawn, FigureSettings(**settings), folder, "one")
    return vector.read_text("utf-8"), imread(pixels)


def size_pt(svg):
    return [float(x) for x in re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', svg).groups()]


@pytest.mark.parametrize(
    ("width_mm", "font_size_pt", "label"),
    [
        (150.0, 9.0, 9.0),
        (150.0, 7.0, 7.0),
        (250.0, 12.0, 12.0),
        (60.0, 9.0, 9.0 * 60.0 / 25.4 / (0.8 * 6.0)),  # does not fit: reduced as a whole
    ],
)
def test_a_file_has_the_width_and_its_labels_the_size(tmp_path, width_mm, font_size_pt, label):
    svg, pixels = saved(tmp_path, width_mm=width_mm, font_size_pt=font_size_pt)
    assert size_pt(svg)[0] == pytest.approx(width_mm * PT_PER_MM, rel=1e-4)
    assert pixels.shape[1] == pytest.approx(width_mm / 25.4 * 300, abs=2)
    # the size that the label of the axis has on paper
    box_width = float(re.search(r'viewBox="([^"]+)"', svg)[1].split()[2])
    shown = float(re.search(r"<text[^>]*font-size: ([\d.]+)px[^>]*>Intensity", svg)[1])
    assert shown * size_pt(svg)[0] / box_width == pytest.approx(label, rel=1e-3)


def test_texts_have_the_chosen_font_and_equal_figures_are_equal_files(tmp_path):
    svg, _ = saved(tmp_path, font="STIXGeneral")
    assert "STIXGeneral" in re.search(r"<text[^>]*>Intensity", svg)[0]
    first, second = saved(tmp_path / "a", width_mm=85.0), saved(tmp_path / "b", width_mm=85.0)
    assert "STIXGeneral" not in first[0]
    assert first[0] == second[0]
    np.testing.assert_array_equal(first[1], second[1])


@pytest.fixture
def written(study, tmp_path, monkeypatch):
    """Write the tables of a finished study with figures of 100 mm."""
    write_starter(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.yaml").write_text("results: own\nfigures: {width_mm: 100}\n")
    tables = {f"fragility/{name}": getattr(study, name) for name in ("curves", "effects")}
    tables |= {"demands": study.demands, "fragility/intensity_effects": study.intensity_effects}
    tables |= dict.fromkeys(("friction_pair", "motions/suite"), pd.DataFrame())
    stored(tmp_path / "own", **tables)
    monkeypatch.setattr("skewbridge.report.study_figures.read_suite", lambda _: ())
    return tmp_path


def plot(*arguments):
    """Run `study plot` in the folder of the study."""
    return CliRunner().invoke(build_app(), ["study", "plot", *arguments, "--study", "own.yaml"])


def test_a_figure_is_drawn_alone_as_configured_or_with_the_options_given(written):
    done = plot("osb1_cf_curves_column_d*", "--out", "paper", "--json")
    assert done.exit_code == 0, done.stderr
    names = ["paper/osb1_cf_curves_column_drift." + end for end in ("svg", "png")]
    assert json.loads(done.stdout)["written"] == names
    assert {f"paper/{path.name}" for path in (written / "paper").iterdir()} == set(names)
    svg = (written / names[0]).read_text("utf-8")
    assert size_pt(svg)[0] == pytest.approx(100 * PT_PER_MM, rel=1e-4)
    cloud = "osb1_cf_cloud_column_drift_ratio"
    listed = {row["name"] for row in json.loads(plot("--json").stdout)["figures"]}
    assert cloud in listed
    assert "suite_spectra" not in listed  # there is no motion to draw
    assert plot(cloud, "--set", "width_mm=80", "--set", "font=serif").exit_code == 0
    svg = (written / f"{cloud}.svg").read_text("utf-8")
    assert size_pt(svg)[0] == pytest.approx(80 * PT_PER_MM, rel=1e-4)
    assert "serif" in re.search(r"<text[^>]*>", svg)[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["osb1_cf_cloud_column"], "similar names: osb1_cf_cloud_column_drift_ratio"),
        (["osb1_cf_cloud_*", "--set", "font=STIXGenerl"], "(did you mean STIXGeneral?)"),
        (
            ["osb1_cf_cloud_*", "--set", "width_mm=4"],
            "width_mm: must be greater than or equal to 40",
        ),
        (["suite_spectra"], "curves.parquet is missing: finish the study first"),
    ],
)
def test_unknown_names_options_and_unfinished_studies_are_refused(written, arguments, message):
    if "missing" in message:
        (written / "own/fragility/curves.parquet").unlink()
    done = plot(*arguments)
    assert done.exit_code == 2
    assert message in done.stderr.replace("\n", " ")


def unions() -> list[dict]:
    """Return curves of column failure in any mode that are unions of both modes."""
    table = pd.concat([two_mode_runs(seed, 24) for seed in range(6)], ignore_index=True)
    found = curves_of(table, FAILURES).query("model == 'union' and preferred")
    assert len(found) > 1
    return found.to_dict("records")


def test_the_curve_of_a_union_has_the_probabilities_of_both_modes():
    im = np.geomspace(0.05, 3.0, 40)
    for row in unions():
        p, (low, high) = curve_values(im, row)
        ends = [(row[f"theta_{mode}"], row[f"beta_{mode}"]) for mode in ("shear", "flexure")]
        u = np.column_stack([np.log(im / theta) / beta for theta, beta in ends])
        rho = row["mode_correlation"]
        both = stats.multivariate_normal(cov=[[1.0, rho], [rho, 1.0]])
        assert p == pytest.approx(1.0 - both.cdf(-u), abs=1e-6)
        assert np.all((low <= p) & (p <= high))


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_the_explorer_computes_the_curve_and_band_of_a_union(tmp_path):
    rows, im = unions(), np.geomspace(0.05, 3.0, 25)
    fits = pd.DataFrame(rows).astype(object).where(pd.notna(pd.DataFrame(rows)), None)
    source = files("skewbridge.report") / "templates" / "explorer" / "statistics.js"
    script = tmp_path / "union.js"
    script.write_text(
        f"{source.read_text()}\nconst fits = {json.dumps(fits.to_dict('records'))};\n"
        f"const im = {json.dumps(im.tolist())};\n"
        "const of = (fit) => [im.map((x) => exceedance(fit, x)), "
        "...[-1, 1].map((side) => im.map((x) => bandOf(fit)(x, side)))];\n"
        "console.log(JSON.stringify(fits.map(of)));"
    )
    done = subprocess.run(["node", script], capture_output=True, text=True, check=True)
    for row, found in zip(rows, json.loads(done.stdout), strict=True):
        p, band = curve_values(im, row)
        np.testing.assert_allclose(found, [p, *band], rtol=0.0, atol=1e-9)
