"""Figures draw the numbers of their tables, follow limit states and axes, and fit a paper."""

import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from cli_json import answer
from fragility_tables import DRIFT_ENTRY, synthetic_demands
from skewbridge.files.tables import write_frame
from skewbridge.fragility.effects import effect_tables
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables
from skewbridge.motions.record import GroundMotion, SuiteMotion
from skewbridge.report import fragility_figures as figures
from skewbridge.report import study_figures as files
from skewbridge.report.appearance import reach_text, shown_in
from skewbridge.report.fragility_figures import demand_clouds, pooled_curves
from skewbridge.report.run_figures import hysteresis_figure, record_page
from skewbridge.study.config import FigureSettings
from skewbridge.study.folder import write_starter

SETTINGS = FitSettings()
BEARING = {"component": "bearing", "demand": "bearing_disp_m", "unit": "m", "dispersion": 0.3,
           "citation": "made up", "states": {"slight": 0.1}}  # fmt: skip
DRIFTS = DRIFT_ENTRY | {"states": {"slight": 1.0, "moderate": 2.5, "complete": 90.0}}
STATES = limit_states_of([DRIFTS, BEARING])
DRIFT = "column_drift_ratio"
NAMES = ("curves", "effects", "system", "intensity_effects")


@pytest.fixture(scope="module")
def demands():
    table = synthetic_demands(skews=(0, 30), run_scatter=0.05)
    table.loc[4, "status"] = "timeout"
    return table


@pytest.fixture(scope="module")
def fragility(demands):
    effects = effect_tables(demands, reference_im={("osb1", "contact_friction"): 0.5})
    found = fragility_tables(demands, STATES, SETTINGS)
    found["curves"] = found["curves"].query("component != 'column_failure'")
    return found | {"effects": effects.effects, "intensity_effects": effects.intensities}


def lines_of(figure, *markers):
    lines = [line for axes in figure.axes for line in axes.lines]
    return [line for line in lines if not markers or line.get_marker() in markers]


def points_of(lines):
    return sum(len(line.get_xdata()) for line in lines)


def captions_of(study, **changes):
    tables = vars(study) | changes
    drawn = files.study_figures(tables, tables.pop("suite"))
    return {caption.name: caption for caption, _ in drawn}


def test_pooled_curves_are_means_over_the_other_axes_with_the_paired_ratio(demands, fragility):
    curves = figures.with_system(fragility["curves"], fragility["system"])
    curves = curves.astype({"n_exceed": float})  # as where a state does not apply to a variant
    pooled = pooled_curves(curves, fragility["median_effects"]).query("component == 'column_drift'")
    assert pooled["n_exceed"].dtype == int  # printed as it is
    own = fragility["median_effects"].query("scope == 'pooled' and status == 'ok'")
    own = own[own["demand"].str.startswith("column_drift/")]
    largest = own.loc[np.log(own["ratio"]).abs().idxmax(), "axis"]
    assert set(pooled["axis"]) == {largest}
    fits = curves.query("preferred & component == 'column_drift'").groupby(["limit_state", largest])
    drawn = pooled.set_index(["limit_state", "value"])
    means = np.exp(fits["theta"].agg(lambda theta: np.log(theta).mean()))
    assert drawn["theta"].to_dict() == pytest.approx(means.to_dict())
    assert drawn["beta_total"].to_dict() == pytest.approx(fits["beta_total"].mean().to_dict())
    assert ((drawn["theta_low"] < drawn["theta"]) & (drawn["theta"] < drawn["theta_high"])).all()
    own = own[own["axis"] == largest].assign(state=own["demand"].str.partition("/")[2])
    ratios = ["ratio", "ci_low", "ci_high"]
    expected = own.set_index(["state", "to_value"])[ratios].reindex(drawn.index)
    assert drawn[ratios].to_numpy() == pytest.approx(expected.to_numpy(), nan_ok=True)
    figure = figures.curves_figure(pooled, curves, demands)
    lines = [line for line in lines_of(figure) if len(line.get_xdata()) == 160]
    found = sorted(float(np.interp(0.5, line.get_ydata(), line.get_xdata())) for line in lines)
    np.testing.assert_allclose(found, sorted(pooled["theta"]), rtol=0.02)
    assert set(pooled["limit_state"]) == {"slight", "moderate"}  # no run reaches complete


def test_ratios_of_the_whole_bridge_are_of_systems_with_the_same_components():
    runs = synthetic_demands(skews=(0, 30), gaps=(25, 51), frictions=(50,), motions=12)
    lacks = (runs["skew_deg"] == 0) & (runs["gap_mm"] == 51)
    runs["bearing_disp_m"] = runs["bearing_disp_m"].where(~lacks, 1e-3 * runs["bearing_disp_m"])
    found = fragility_tables(runs, STATES, SETTINGS)
    curves = figures.with_system(found["curves"], found["system"])
    effects = found["median_effects"].query("axis == 'skew_deg'")
    table = pooled_curves(curves, effects).query("component == 'whole_bridge'")
    (row,) = table.query("limit_state == 'slight' and value == 30").to_dict("records")
    thetas = found["system"].query("limit_state == 'slight' and gap_mm == 25").set_index("skew_deg")
    assert row["ratio"] == pytest.approx(thetas.loc[30, "theta"] / thetas.loc[0, "theta"])
    assert figures.value_words(row, "g").endswith(" ‡")
    alone = curves.query("gap_mm == 25").drop(columns=["gap_mm", "friction"])
    alone = pooled_curves(alone, effects).query("component == 'whole_bridge' and value == 30")
    assert alone["ratio"].iloc[0] == row["ratio"]
    # each pair has equal components, but the pairs have not
    fewer = curves["components"].where(curves["gap_mm"] == 25, "column_drift")
    table = pooled_curves(curves.assign(components=fewer), effects)
    both = table.query("component == 'whole_bridge' and limit_state == 'slight'")
    assert both["ratio"].tolist() == pytest.approx([np.nan, row["ratio"]], nan_ok=True)
    assert both["n_different"].tolist() == [1, 1]
    # a variant without a curve of the whole bridge is counted
    is_lost = (curves["limit_state"] == "slight") & (curves["skew_deg"] == 0)
    is_lost &= (curves["component"] == "whole_bridge") & (curves["gap_mm"] == 25)
    lost = curves.assign(preferred=curves["preferred"] & ~is_lost)
    table = pooled_curves(lost, effects).query("component == 'whole_bridge'")
    assert sorted(table.query("limit_state == 'slight'")["n_curves"]) == [1, 2]
    assert set(table["n_variants"]) == {2}
    # without a curve at the value nearest to zero there is no ratio
    left = curves.query("skew_deg == 30").assign(skew_deg=-30, variant="left")
    lost = pd.concat(
        [curves.assign(preferred=curves["preferred"] & (curves["skew_deg"] != 0)), left]
    )
    assert pooled_curves(lost, effects).query("component == 'whole_bridge'")["ratio"].isna().all()
    # degrees of damage with the same curves are one
    slight = found["system"].query("limit_state == 'slight'")
    more = [slight.assign(limit_state=state) for state in ("slight", "moderate", "complete")]
    curves = figures.with_system(found["curves"], pd.concat([*more, slight.assign(bridge="b")]))
    states = curves[curves["component"] == "whole_bridge"].groupby("bridge")["limit_state"].unique()
    assert states.map(list).to_dict() == {"b": ["slight"], "osb1": ["slight to complete"]}


def test_cloud_marks_runs_that_ended_early_and_demands_of_zero(demands, fragility):
    tables = fragility["curves"], fragility["effects"], DRIFT
    lead = figures.lead_axis(tables[1], {DRIFT}, demands).name
    many = demands.assign(**{lead: np.arange(len(demands)) % 12.0})  # more values than colours
    assert points_of(lines_of(demand_clouds(many, *tables), "o")) == len(many)
    assert points_of(lines_of(demand_clouds(demands, *tables), 2)) == 1  # a tick
    low = demands.assign(**{DRIFT: demands[DRIFT].where(demands["motion_id"] != "m00", 0.0)})
    assert points_of(lines_of(demand_clouds(low, *tables), "v")) == (low[DRIFT] == 0.0).sum() == 8
    assert figures.least_shown(demands.assign(**{DRIFT: 0.0}), tables[0], DRIFT) is None
    legend = demand_clouds(demands, tables[0].assign(b=np.nan), *tables[1:]).axes[0].get_legend()
    assert {line.get_linestyle() for line in legend.get_lines()} == {"None"}


@pytest.fixture(scope="module")
def study(demands, fragility):
    wave = np.sin(np.arange(400) * 0.1)
    motion = GroundMotion(motion_id="m00", dt_s=0.01, accel_1_mps2=wave, accel_2_mps2=0.5 * wave)
    tables = {name: fragility[name] for name in NAMES} | {"medians": fragility["median_effects"]}
    suite = [SuiteMotion(motion=motion, scale=1.5, measures={})]
    return SimpleNamespace(demands=demands, suite=suite, **tables)


def test_clouds_have_the_colours_of_the_largest_effect_and_its_size(study):
    figure = demand_clouds(study.demands, study.curves, study.effects, DRIFT)
    pooled = study.effects.query("scope == 'pooled' and demand == @DRIFT")
    largest = pooled.loc[np.log(pooled["ratio"]).abs().idxmax()]
    assert len(figure.axes[0].get_legend().get_texts()) == study.demands[largest["axis"]].nunique()
    fits = study.curves.query("demand == @DRIFT and method == 'cloud'").drop_duplicates("variant")
    fits = fits[fits[largest["axis"]] == largest["to_value"]]
    *_, line = [line for line in lines_of(figure) if len(line.get_xdata()) == 41]
    x, y = np.log(line.get_xydata()[0])
    assert y == pytest.approx((fits["ln_a"] + fits["b"] * x).mean())


def test_list_of_figures_follows_limit_states_and_leaves_out_empty_plots(study):
    names = [name.removeprefix("osb1_cf_") for name in captions_of(study)]
    expected = "main_whole_bridge curves_column_drift curves_bearing cloud_column_drift_ratio"
    assert names == f"{expected} cloud_bearing_disp_m effects_by_intensity suite_spectra".split()
    empty = ("system", "effects", "intensity_effects")
    nothing = {"demands": study.demands.assign(bearing_disp_m=0.0)}
    nothing |= {name: getattr(study, name).head(0) for name in empty}
    names = captions_of(study, **nothing, curves=study.curves.assign(preferred=False))
    assert list(names) == ["osb1_cf_cloud_column_drift_ratio", "suite_spectra"]


def test_captions_and_findings_have_the_numbers_of_the_tables(study):
    captions = captions_of(study)
    assert "Sa,avg RotD50 (g) 0.5." in captions["osb1_cf_effects_by_intensity"].text
    above = int((study.demands["bearing_disp_m"] > 0.1).sum())
    words = f"{above} of {len(study.demands)} analyses are known to exceed bearing, slight (100 mm)"
    assert captions["osb1_cf_cloud_bearing_disp_m"].finding == f"{words}."
    curves = pooled_curves(study.curves, study.medians)
    mild = curves.query("component == 'column_drift' and limit_state == 'slight'")["theta"]
    ends = re.findall(r"(?:is|and) (\S+) at ", captions["osb1_cf_curves_column_drift"].finding)
    assert ends == [f"{mild.iloc[end]:#.3g}" for end in (0, -1)]


def test_figures_in_us_units_have_inches(study):
    with shown_in("us"):
        captions, reach = captions_of(study), "Unseating (m): largest 0.047, state at 0.11"
        reach = reach_text({"demand": "unseating_m", "threshold": 0.114, "reach": reach})
        figure = demand_clouds(study.demands, study.curves, study.effects, "bearing_disp_m")
        speed = record_page("", 0.01, {"h1": np.full(101, 0.0254)}).axes[1]
    assert reach == "Unseating: largest 1.85 in, state at 4.49 in"
    assert "(3.94 in)" in captions["osb1_cf_cloud_bearing_disp_m"].finding
    assert "(in) (in/s)" in f"{figure.axes[0].get_ylabel()[-4:]} {speed.get_ylabel()[-6:]}"
    assert speed.lines[0].get_ydata()[-1] == pytest.approx(1.0)
    largest = max(max(line.get_ydata(), default=0.0) for line in lines_of(figure, "o"))
    assert largest * 0.0254 <= study.demands["bearing_disp_m"].max() * (1 + 1e-9)


def width_mm(svg):
    return float(re.search(r'width="([\d.]+)pt"', svg)[1]) / 72 * 25.4


def test_equal_figures_are_equal_files_reduced_as_a_whole_if_narrow(tmp_path):
    def drawn():
        latest[:] = Figure(figsize=(6.0, 3.0), layout="constrained").subplots(1, 2)
        for axes in latest:
            axes.set_xlabel("Intensity (g)", fontsize=9)
            axes.text(0.0, 1.0, title, transform=axes.transAxes)
        return axes.figure

    settings, title, latest = FigureSettings(width_mm=60.0, font_size_pt=9.0), "", []
    twice = zip(*(files.save_figure(drawn, settings, tmp_path, name) for name in "ab"), strict=True)
    (svg,), (_,) = ({path.read_text("latin-1") for path in equal} for equal in twice)
    title = 18 * "W"  # wider than the panel, neither cut off nor over that of the next panel
    wide = files.save_figure(drawn, settings, tmp_path, "c")[0].read_text()
    box_pt, wide_pt = (float(re.search(r'viewBox="0 0 ([\d.]+)', s)[1]) for s in (svg, wide))
    assert (width_mm(wide), wide_pt > box_pt) == (pytest.approx(60.0, rel=1e-4), True)
    assert latest[0].get_tightbbox().x1 < latest[1].get_tightbbox().x0
    label = float(re.search(r"<text[^>]*font-size: ([\d.]+)px[^>]*>Intensity", svg)[1])
    assert label / box_pt == pytest.approx(9.0 / 72 / (0.8 * 6.0), rel=1e-3)


@pytest.fixture
def written(study, tmp_path, monkeypatch):
    write_starter(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.yaml").write_text("results: own\nfigures: {width_mm: 100}\n")
    tables = {f"fragility/{name}": getattr(study, name) for name in NAMES}
    tables |= {"fragility/median_effects": study.medians, "demands": study.demands}
    for name, table in {**tables, "motions/suite": pd.DataFrame()}.items():
        write_frame(table, tmp_path / "own" / f"{name}.parquet", {})
    monkeypatch.setattr(files, "read_suite", lambda _: ())
    return tmp_path


def plot(*arguments, code=0):
    return answer("study", "plot", *arguments, "--study", "own.yaml", code=code)


def test_a_figure_is_drawn_alone_as_configured_or_with_the_options_given(written):
    done = plot("osb1_cf_curves_column_d*", "--out", "paper")
    names = ["paper/osb1_cf_curves_column_drift." + end for end in ("svg", "png")]
    assert done["written"] == names
    assert {f"paper/{path.name}" for path in (written / "paper").iterdir()} == set(names)
    assert width_mm((written / names[0]).read_text("utf-8")) == pytest.approx(100, rel=1e-4)
    cloud = "osb1_cf_cloud_column_drift_ratio"
    listed = {row["name"] for row in plot()["figures"]}
    assert {cloud, "suite_spectra"} & listed == {cloud}  # there is no motion to draw
    plot(cloud, "--set", "width_mm=80", "--set", "font=serif")
    svg = (written / f"{cloud}.svg").read_text("utf-8")
    assert width_mm(svg) == pytest.approx(80, rel=1e-4)
    assert "serif" in re.search(r"<text[^>]*>", svg)[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["osb1_cf_cloud_column"], "similar names: osb1_cf_cloud_column_drift_ratio"),
        (["osb1_cf_cloud_*", "--set", "font=STIXGenerl"], "(did you mean STIXGeneral?)"),
        (["osb1_cf_cloud_*", "--set", "width_mm=4"], "width_mm: must be greater than or equal"),
        (["suite_spectra"], "curves.parquet is missing: finish the study first"),
    ],
)
def test_unknown_names_options_and_unfinished_studies_are_refused(written, arguments, message):
    if "missing" in message:
        (written / "own/fragility/curves.parquet").unlink()
    assert message in plot(*arguments, code=2)["message"]


def test_forces_are_those_of_the_seat_if_the_left_end_has_none():
    ways = ("x_m", "x_kn", "y_m", "y_kn", "pads_x_kn", "pads_y_kn")
    names = [f"abutment_{side}_{way}" for side in ("left", "right") for way in ways]
    histories = pd.DataFrame(0.0, index=range(3), columns=names)
    histories["abutment_right_pads_x_kn"] = [0.0, 1.0e3, 2.0e3]
    panels = hysteresis_figure({"run": histories}).axes
    assert panels[0].get_title("left") == "Whole right abutment, longitudinal"
    assert panels[2].lines[0].get_ydata() == pytest.approx([0.0, 1.0, 2.0])  # MN
