"""Headline of the README: its text follows from stored tables, and these from a study."""

import re
from pathlib import Path

import headline
import numpy as np
import pandas as pd
import pytest

from fragility_tables import synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables
from skewbridge.report.answer import change_name

ROOT = Path(__file__).parents[2]
SETTINGS = FitSettings(bootstrap=99)
# numbers in names of states, bridges and texts, and the level of the intervals
WORDS = r"DCR [\d.]+|osb\d\w*|p = "


def printed_numbers(text):
    """Return the numbers of a text without those in names."""
    text = re.sub(WORDS, "", text).replace("\u00a0", " ")
    return {abs(float(number)) for number in re.findall(r"[-+]?\d+(?:\.\d+)?(?:e-\d+)?", text)}


def table_numbers(table, runs, motions):
    """Return every number of the tables as it may be printed: digits, per cent and mm."""
    values = [
        frame.select_dtypes("number").to_numpy(dtype=float).ravel()
        for frame in (table, runs, motions)
    ]
    values.append(runs.loc[runs["axis"] == ""].sum(numeric_only=True).to_numpy(dtype=float))
    raw = np.concatenate(values)
    raw = raw[np.isfinite(raw)]
    ratios = table[[c for c in table if c.endswith("ratio") or c.startswith("ci_")]]
    changes = 100.0 * (ratios.to_numpy(dtype=float).ravel() - 1.0)
    forms = set()
    for value in (*raw, *(100.0 * raw), *(1000.0 * raw), *changes[np.isfinite(changes)]):
        size = abs(float(value))
        texts = (f"{size:.0f}", f"{size:.1f}", f"{size:.2f}", f"{size:.2g}", f"{size:.3g}")
        forms |= {float(text) for text in texts}
    return forms | {float(len(motions))}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Return the folder of a repository with the headline of a small study, and its tables."""
    root = tmp_path_factory.mktemp("repository")
    demands = synthetic_demands(skews=(0, 30), gaps=(51,), motions=12)
    demands["cpu_s"] = 3.0
    demands["beyond_model"] = np.where(demands["column_shear_dcr"] >= 0.6, "shear", "")
    states = load_limit_states(ROOT / "config" / "limit_states.yaml")
    wanted = ("column_curvature", "unseating", "bearing")
    states = [state for state in states if state.component in wanted]
    tables = fragility_tables(demands, states, SETTINGS)
    folder = root / "results" / "fragility"
    folder.mkdir(parents=True)
    for name in ("median_effects", "effects", "intensity_effects", "curves", "joint"):
        tables[name].to_parquet(folder / f"{name}.parquet")
    demands.to_parquet(root / "results" / "demands.parquet")
    motions = pd.DataFrame({"motion_id": sorted(demands["motion_id"].unique())})
    motions = motions.assign(source="synthetic: a test", magnitude=6.5, distance_km=8.0)
    (root / "results" / "motions").mkdir()
    motions.to_parquet(root / "results" / "motions" / "suite.parquet")
    (root / "docs" / "images").mkdir(parents=True)
    text = f"before\n{headline.BEGIN}\nprevious text\n{headline.END}\nafter\n"
    (root / "README.md").write_text(text, encoding="utf-8")
    headline.write_headline(root / "results", root)
    return root, tables


def test_readme_is_what_its_stored_tables_give():
    """If not: `make headline` on a finished study writes both."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text = headline.headline_text(*headline.stored_tables(ROOT))
    assert headline.with_headline(readme, text) == readme


def test_every_number_of_the_readme_headline_is_in_a_stored_table():
    stored = headline.stored_tables(ROOT)
    assert printed_numbers(headline.headline_text(*stored)) <= table_numbers(*stored)


def test_headline_of_a_study_prints_numbers_of_its_tables(study):
    root, tables = study
    stored = headline.stored_tables(root)
    text = headline.headline_text(*stored)
    assert printed_numbers(text) <= table_numbers(*stored)
    medians = tables["median_effects"]
    medians = medians[(medians["scope"] == "pooled") & (medians["demand"] == "unseating/slight")]
    for row in medians.to_dict("records"):
        assert f"{100.0 * (row['ratio'] - 1.0):+.1f}"[1:4] in text
        assert change_name(row["axis"], row["from_value"], row["to_value"]) in text


def test_headline_keeps_the_rest_of_the_readme(study):
    root, _ = study
    readme = (root / "README.md").read_text(encoding="utf-8")
    assert readme.startswith("before\n")
    assert readme.endswith("\nafter\n")
    assert "previous text" not in readme
    assert "Columns failed in" in readme
    assert "of one scenario, magnitude 6.5 at 8 km" in readme
    assert (root / headline.PICTURE).stat().st_size > 10_000


def test_verdict_of_a_headline_demand_is_constant_in_its_intensity_range(study):
    root, tables = study
    stored = headline.stored_tables(root)[0]
    demands = stored[(stored["quantity"] == "demand") & stored["im"].notna()]
    assert len(demands)
    lines = tables["intensity_effects"]
    names = ["bridge", "abutment", "demand", "axis", "from_value", "to_value"]
    for row in demands.to_dict("records"):
        same = (lines[names] == pd.Series({name: row[name] for name in names})).all(axis=1)
        inside = lines[same & lines["im"].between(0.999 * row["im_low"], 1.001 * row["im_high"])]
        assert len(inside)
        if row["claim"] in ("lower", "higher", "negligible"):
            assert set(inside["verdict"]) == {row["claim"]}


def test_readme_without_markers_is_refused():
    with pytest.raises(InputError, match="markers"):
        headline.with_headline("nothing", "text")
