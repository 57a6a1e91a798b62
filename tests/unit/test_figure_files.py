"""Figures in files for a paper: width, font, one alone."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from typer.testing import CliRunner

from fragility_tables import synthetic_demands
from skewbridge.cli import build_app
from skewbridge.files.tables import write_frame
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables
from skewbridge.report.study_figures import save_figure
from skewbridge.study.config import FigureSettings
from skewbridge.study.folder import write_starter

RUNNER = CliRunner()
STATE = {
    "component": "column_drift", "demand": "column_drift_ratio", "unit": "ratio",
    "dispersion": 0.3, "citation": "made up", "states": {"slight": 0.01},
}  # fmt: skip
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
    return [
        float(size) for size in re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', svg).groups()
    ]


def label_pt(svg):
    """Return the size that the label of the axis has on paper."""
    box = [float(x) for x in re.search(r'viewBox="([^"]+)"', svg)[1].split()]
    shown = re.search(r"<text[^>]*font-size: ([\d.]+)px[^>]*>Intensity", svg)[1]
    return float(shown) * size_pt(svg)[0] / box[2]


@pytest.mark.parametrize(("width_mm", "font_size_pt"), [(150.0, 9.0), (150.0, 7.0), (250.0, 12.0)])
def test_a_file_has_the_width_and_its_labels_the_size(tmp_path, width_mm, font_size_pt):
    svg, pixels = saved(tmp_path, width_mm=width_mm, font_size_pt=font_size_pt)
    assert size_pt(svg)[0] == pytest.approx(width_mm * PT_PER_MM, rel=1e-4)
    assert pixels.shape[1] == pytest.approx(width_mm / 25.4 * 300, abs=2)
    assert label_pt(svg) == pytest.approx(font_size_pt, rel=1e-3)


def test_a_figure_that_does_not_fit_is_reduced_as_a_whole(tmp_path):
    svg, pixels = saved(tmp_path, width_mm=60.0)
    assert size_pt(svg)[0] == pytest.approx(60.0 * PT_PER_MM, rel=1e-4)
    assert pixels.shape[1] == pytest.approx(60.0 / 25.4 * 300, abs=2)
    assert label_pt(svg) == pytest.approx(9.0 * 60.0 / 25.4 / (0.8 * 6.0), rel=1e-3)


def test_texts_have_the_chosen_font(tmp_path):
    svg, _ = saved(tmp_path, font="STIXGeneral")
    assert "STIXGeneral" in re.search(r"<text[^>]*>Intensity", svg)[0]
    assert "STIXGeneral" not in saved(tmp_path)[0]


def test_equal_figures_are_equal_files(tmp_path):
    first, second = saved(tmp_path / "a", width_mm=85.0), saved(tmp_path / "b", width_mm=85.0)
    assert first[0] == second[0]
    np.testing.assert_array_equal(first[1], second[1])


@pytest.fixture(name="study")
def _study(tmp_path, monkeypatch):
    """Make the tables of a finished study with figures of 100 mm."""
    write_starter(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.yaml").write_text("results: own\nfigures: {width_mm: 100}\n")
    demands = synthetic_demands(skews=(0, 30), gaps=(25,))
    made = fragility_tables(demands, limit_states_of([STATE]), FitSettings())
    names = ("curves", "median_effects", "effects", "intensity_effects")
    tables = {
        "demands": demands,
        **{f"fragility/{name}": made[name] for name in names},
        "friction_pair": pd.DataFrame(),
        "motions/suite": pd.DataFrame(),
    }
    for name, table in tables.items():
        path = tmp_path / "own" / f"{name}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_frame(table, path, {})
    monkeypatch.setattr("skewbridge.report.study_figures.read_suite", lambda _: ())
    return tmp_path


def plot(*arguments):
    return RUNNER.invoke(build_app(), ["study", "plot", *arguments, "--study", "own.yaml"])


def test_one_figure_is_drawn_alone_with_the_look_of_the_configuration(study):
    done = plot("osb1_cf_curves_column_d*", "--out", "paper", "--json")
    assert done.exit_code == 0, done.stderr
    names = ["paper/osb1_cf_curves_column_drift." + end for end in ("svg", "png")]
    assert json.loads(done.stdout)["written"] == names
    assert sorted(path.name for path in (study / "paper").iterdir()) == sorted(
        name.removeprefix("paper/") for name in names
    )
    assert size_pt((study / names[0]).read_text("utf-8"))[0] == pytest.approx(
        100 * PT_PER_MM, rel=1e-4
    )


def test_width_and_font_options_override_the_configuration(study):
    done = plot("osb1_cf_cloud_column_drift_ratio", "--width-mm", "80", "--font", "serif")
    assert done.exit_code == 0, done.stderr
    svg = (study / "osb1_cf_cloud_column_drift_ratio.svg").read_text("utf-8")
    assert size_pt(svg)[0] == pytest.approx(80 * PT_PER_MM, rel=1e-4)
    assert "serif" in re.search(r"<text[^>]*>", svg)[0]


def test_without_a_name_all_are_listed(study):
    rows = json.loads(plot("--json").stdout)["figures"]
    names = {row["name"] for row in rows}
    assert {"osb1_cf_cloud_column_drift_ratio", "osb1_cf_curves_column_drift"} < names
    assert "suite_spectra" not in names  # there is no motion to draw


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["osb1_cf_cloud_column"], "similar names: osb1_cf_cloud_column_shear_dcr"),
        (["osb1_cf_cloud_*", "--font", "STIXGenerl"], "(did you mean STIXGeneral?)"),
        (["osb1_cf_cloud_*", "--width-mm", "4"], "width_mm: must be greater than or equal to 40"),
    ],
)
def test_unknown_names_and_options_are_refused(study, arguments, message):
    done = plot(*arguments)
    assert done.exit_code == 2
    assert message in done.stderr.replace("\n", " ")


def test_unfinished_study_is_refused(study):
    (study / "own/fragility/curves.parquet").unlink()
    done = plot("suite_spectra")
    assert done.exit_code == 2
    assert "curves.parquet is missing: finish the study first" in done.stderr.replace("\n", " ")
