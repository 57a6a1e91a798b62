"""The page and the headline of the README state what the tables of a study contain."""

import base64
import gzip
import json
import re
from importlib.resources import files
from pathlib import Path

import headline
import numpy as np
import pandas as pd
import pytest
import yaml

from fragility_tables import IM, synthetic_demands
from report_pages import NUMBER, STATES, assert_printed, tables_of, write_page, wrong_numbers
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables
from skewbridge.report.answer import (
    ANSWER_COLUMNS,
    change_name,
    effect_name,
    limit_notes,
    title_of,
)
from skewbridge.report.appearance import demand_name
from skewbridge.report.methods import methods_of
from skewbridge.report.page import bridge_words, sketch
from skewbridge.report.study_figures import SECTIONS
from skewbridge.study.config import parse_config

BEYOND = [STATES[0] | {"states": {"complete": 900.0}}]


@pytest.fixture
def render(tmp_path):
    """Return a function that makes the tables of a study and its page, and gives page, tables."""

    def page_of(demands, **study):
        page, frames = write_page(tmp_path, demands, **study)
        text = re.sub(r"<style>.*?</style>", "", page.read_text("utf-8"), flags=re.S)
        return re.sub(r"\s+", " ", text), frames

    return page_of


def answer_of(page):
    return page[page.index('<section id="answer">') : page.index('<section id="effects">')]


TABLES = ("The answer", "Effects, all variants", "Effects, other states and demands", "System")


def effect_cells(frames):
    """Yield label, heading and numbers of every pooled effect."""
    for row in pd.concat([frames["medians"], frames["effects"]]).to_dict("records"):
        if row["scope"] != "pooled":
            continue
        names, factor, start = ("ratio", "ci_low", "ci_high"), 100.0, 1.0
        if row["judged_by"] == "difference":
            names = ("difference", "difference_low", "difference_high")
            factor, start = 1.0, 0.0
        values = [factor * (row[name] - start) for name in names] if row["status"] == "ok" else []
        state = "/" in row["demand"]
        label = f"Median, {effect_name(row['demand'])}" if state else demand_name(row["demand"])
        yield label, change_name(row["axis"], row["from_value"], row["to_value"]), values, row


def assert_tables(page, frames):
    """Check every number in the tables of a study of one model against its own row."""
    tables = tables_of(page)
    answer, *maps = (tables.get(name, []) for name in TABLES[:3])
    demands, changes, states = frames["demands"], {row[0]: row for row in answer[1:]}, answer[0]
    rows = [(*row[0].partition("±")[::2], table[0], row) for table in maps for row in table[1:]]
    margins = {label.strip(): margin for label, margin, *_ in rows}
    cells = {
        (label.strip(), head): cell
        for label, _, heads, row in rows
        for head, cell in zip(heads[1:], row[1:], strict=True)
    }
    effects = list(effect_cells(frames))
    assert len(cells) >= len(effects) > 10
    for label, change, values, row in effects:
        assert_printed(cells.pop((label, change)), values)
        margin = (
            row["difference_margin"] if row["judged_by"] == "difference" else 100 * row["margin"]
        )
        assert_printed(margins[label], [margin] if margins[label] else [])
        state = effect_name(row["demand"])
        if change in changes and state in states:
            ends = [row["from_mean"], row["from_mean"] * row["ratio"]] if values else []
            cell = changes[change][states.index(state)]
            assert_printed(cell, [*values[:1], *ends, *values[1:]])
    assert not [cell for cell in cells.values() if cell != "–"]
    assert set(changes) == {change for _, change, *_ in effects}
    for label, row in changes.items():
        name = label.split()[0].lower().replace("skew", "skew_deg").replace("gap", "gap_mm")
        groups = demands.assign(failed=demands["beyond_model"] != "").groupby(name)["failed"]
        assert_printed(
            row[-1], [groups.sum().iloc[0], groups.sum().iloc[-1], groups.size().iloc[0]]
        )
    system = frames["system"]
    assert len(tables["System"]) == 1 + len(system)
    for cells, row in zip(tables["System"][1:], system.to_dict("records"), strict=True):
        assert row["bridge"] in cells[0]
        assert_printed(cells[1], [row[name] for name in ("skew_deg", "gap_mm", "friction")])
        assert_printed(cells[3], [row["n_exceed"], row["n_runs"]])
        names = [
            "theta",
            "theta_low",
            "theta_high",
            "beta",
            "theta_correlated",
            "theta_independent",
        ]
        assert_printed(
            " ".join(cells[4:8]), [row[name] for name in names if row[name] == row[name]]
        )


def test_bases_axes_counts_and_answers_are_those_of_the_study(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    page, frames = render(demands)
    assert "pinned column bases" in page
    assert "skew 0°, 60° × gap 25 mm × friction 0, 0.5" in page
    assert f"Columns failed in 0 of {len(demands)} runs" in page
    assert "a median of 3 %" in page  # friction above its limit, of the analyses that rub
    assert "fixed column bases" not in page
    assert "three capacity models" not in page
    assert_tables(page, frames)
    head = answer_of(page)
    assert "<b>certain" in head or "certain</b>" in head


def test_every_wrong_number_in_the_tables_of_the_page_is_found(render):
    """A test of `assert_tables`, which the other tests use."""
    page, frames = render(synthetic_demands(skews=(0, 60), gaps=(25,)))
    for name in TABLES:
        start = page.index("<tbody>", page.index(f'aria-label="{name}"'))
        table = page[start : page.index("</table>", start)]
        cells = re.finditer(r">([^<>]+)<", table)
        mutants = [(cell, wrong) for cell in cells for wrong in wrong_numbers(cell[1])]
        assert len(mutants) >= 20
        for cell, wrong in mutants:
            text = page[: start + cell.start(1)] + wrong + page[start + cell.end(1) :]
            with pytest.raises((AssertionError, KeyError)):
                assert_tables(text, frames)


def test_failures_tables_intensities_and_links_are_those_of_the_study(render):
    demands = synthetic_demands(skews=(0, 30), gaps=(25,)).assign(scale=1.5, beyond_model="")
    demands.loc[demands.index[0], "scale"] = 0.25
    demands.loc[demands.index[:7], "beyond_model"] = ["shear"] * 5 + ["flexure"] * 2
    page, frames = render(demands)
    head = answer_of(page)
    assert f"Columns failed in 7 of {len(demands)} runs: 5 in shear, 2 in flexure" in head
    assert "No runs collapsed. In 7 runs the demands are peaks up to a failure" in head
    assert ">4 to 3 of 32</td>" in head or ">7 to 0 of 32</td>" in head
    assert set(frames["curves"]["im"]) == {IM}
    assert "motions scaled by 0.25 to 1.5," in page
    assert "Median θ of Sa,avg RotD50 (g)" in page
    assert "weakest component" in page
    assert "components independent" in page
    assert "theta correlated" not in page
    assert_tables(page, frames)
    wanted = set(re.findall(r'href="#([^"]+)"', page))
    assert wanted <= set(re.findall(r'id="([^"]+)"', page))
    # addresses inside the vendored library are texts of its messages
    own = re.sub(r"<script.*?</script>", "", re.sub(r"data:image[^\"]+", "", page), flags=re.DOTALL)
    assert "http" not in own


def test_bridges_and_abutments_of_a_mixed_study_are_named(render):
    pinned, fixed = (
        synthetic_demands(bridge=name, skews=(0, 30), gaps=(25,), motions=8, seed=seed)
        for seed, name in enumerate(("osb1", "osb1_fixed"))
    )
    page, _ = render(pd.concat([pinned, fixed], ignore_index=True), bridges=("osb1", "osb1_fixed"))
    assert "<strong>osb1</strong>: two spans, 91.4 m long, pinned two-column bent" in page
    assert "<strong>osb1_fixed</strong>: two spans, 91.4 m long, fixed two-column bent" in page
    assert "<small>osb1_fixed</small>" in page
    roller = {"abutment": "roller", "gaps": (0,), "frictions": (0,), "skews": (0, 30)}
    mixed = pd.concat([synthetic_demands(**roller, motions=8), pinned], ignore_index=True)
    page, _ = render(mixed, bridges=("osb1_fixed",))
    assert '<th scope="colgroup" colspan="1">osb1, roller</th>' in page
    assert '<th scope="colgroup" colspan="2">osb1, contact-friction</th>' in page
    assert "pinned column bases" not in page


def test_a_missing_exceedance_or_comparison_is_stated(render):
    page, _ = render(synthetic_demands(skews=(0,), gaps=(25,)), states=BEYOND)
    assert "No limit state has an estimate" in page
    assert "no exceedance" in page
    page, _ = render(synthetic_demands(motions=1, skews=(30,), gaps=(25,), frictions=(50,)))
    assert "No comparison is possible" in page
    assert "1 motion unscaled," in page
    assert "No two variants of this study can be compared." in page


def test_sketch_and_words_have_the_geometry_of_the_bridge():
    bridge = load_bridge("osb1")
    drawn = sketch(bridge, [0, 60], [25, 51], 6.4)
    assert [2 * drawn["end"], 2 * drawn["half"]] == [bridge.length_m, bridge.deck.width_m]
    assert (drawn["skew"], drawn["others"], len(drawn["columns"])) == (60, [0], 2)
    gap_m = (drawn["face"] - drawn["end"]) * np.cos(np.pi / 3)
    assert gap_m == pytest.approx(drawn["factor"] * 0.051)
    reach = drawn["back"] + drawn["half"] * np.tan(np.pi / 3)
    assert drawn["scale"] * reach <= drawn["width"] / 2
    assert bridge_words(load_bridge("bridge_a")).endswith("single-column bent")


def paragraph(page, name):
    return re.search(rf"<p><strong>{name}\.</strong> (.*?)</p>", page)[1]


def test_methods_settings_and_units_of_the_page_are_those_of_the_study(render):
    demands = synthetic_demands(motions=3, skews=(0, 60), gaps=(25, 51), frictions=(50,))
    config = {
        "grid": {"skew_deg": [0, 60], "gap_mm": [25, 51], "friction": [0.5]},
        "analysis": {"duration_s": 10.0},
        "motions": {"count": 3, "level_range_g": [0.1, 1.0]},
        "sensitivity": {"rows": 0},
        "figures": {"units": "us"},
    }
    source = "BSD-3-Clause; synthetic: model of Dabaghi and Der Kiureghian (2018)"
    page, _ = render(demands, source=source, config=config)
    abutments = "skew 0°, 60°; the joint gap 0.984 in, 2.01 in; friction 0.5: four variants"
    assert abutments in paragraph(page, "Abutments")
    assert "simulated, Dabaghi and Der Kiureghian 2018" in paragraph(page, "Ground motions")
    settings = paragraph(page, "Settings")
    assert "<code>analysis.duration_s</code> 10 (default none)" in settings
    for key in ("motions.count", "motions.level_range_g", "sensitivity.rows"):
        assert f"<code>{key}</code>" in settings
    assert "<code>analysis.dt_s</code>" not in settings
    assert "<code>column_drift_ratio</code>" in page
    assert "slight 1 %, moderate 2.5 %" in page
    assert "gap 0.984 in, 2.01 in" in page
    assert "300.0 ft long" in page
    assert " mm" not in re.sub(r"<details><summary>(Methods|Provenance).*?</details>", "", page)


def test_methods_take_the_range_of_intensities_from_the_motions():
    given = {"source": ["a"] * 2, "scale": [1.0, 2.0], "im_saavg_rotd50_g": [0.11, 0.4]}
    suite = pd.DataFrame(given)
    text = methods_of(parse_config({"motions": {"count": 2}}), suite).parts["Ground motions"]
    assert "2 two-component ground motions" in text
    assert "spans 0.11 to 0.8 g" in text


def answer_row(axis, demand, ratio, claim, verdict=None):
    given = {
        "bridge": "osb1", "abutment": "contact_friction", "axis": axis, "from_value": 0.0,
        "to_value": 0.5, "quantity": "median_capacity", "demand": demand, "status": "ok",
        "ratio": ratio, "ci_low": 0.95 * ratio, "ci_high": 1.05 * ratio, "level": 0.9,
        "margin": 0.05, "verdict": verdict or claim, "claim": claim,
    }  # fmt: skip
    return {name: given.get(name, float("nan")) for name in ANSWER_COLUMNS}


def test_title_gives_the_most_severe_median_capacity_with_a_clear_direction():
    rows = [
        answer_row("skew_deg", "column_failure/any", 0.72, "detectable", "lower"),
        answer_row("skew_deg", "unseating/slight", 0.8, "lower"),
        answer_row("gap_mm", "unseating/slight", 1.0, "negligible"),
        answer_row("friction", "unseating/slight", 1.02, "undecided"),
    ]
    assert title_of(pd.DataFrame(rows)) == (
        "Skew lowers the median capacity for column failure by 28 % (-32 to -24 %, size uncertain) "
        "and for unseating (slight) by 20 % (-24 to -16 %); the effect of friction on median "
        "capacities is uncertain; the joint gap changes no median capacity by more than 5 %"
    )


def test_title_and_notes_state_medians_that_leave_the_data():
    limits = {"im_low": 1.7, "im_high": 2.1, "n_cells": 4,
              "n_without_curve": 0, "n_extrapolated": 8}  # fmt: skip
    row = answer_row("friction", "column_failure/any", 1.08, "higher") | limits
    assert "+13 %, extrapolated)" in title_of(pd.DataFrame([row]))
    note = ("osb1, column failure: medians of 1.70 to 2.10 g are extrapolated, because fewer "
            "than three motions are that strong.")  # fmt: skip
    assert [*limit_notes(pd.DataFrame([row])).values()] == [note]
    row |= {"n_extrapolated": 3}
    assert "+13 %, partly extrapolated)" in title_of(pd.DataFrame([row]))
    row |= {"n_extrapolated": 0, "n_without_curve": 4}
    assert "4 of 8 medians without a curve" in title_of(pd.DataFrame([row]))
    assert limit_notes(pd.DataFrame([row | {"n_without_curve": 0}])) == {}


def test_texts_of_a_user_are_shown_and_never_run(render, tmp_path, monkeypatch):
    script = "<script>alert(1)</script>"
    catalogue = files("skewbridge.bridge.catalogue") / "osb1.yaml"
    bridge = yaml.safe_load(catalogue.read_text("utf-8"))
    bridge["title"] = f"Bridge {script} & 'sons'"
    own = tmp_path / "config" / "bridges"
    own.mkdir(parents=True)
    (own / "mine.yaml").write_text(yaml.safe_dump(bridge | {"name": "mine"}), "utf-8")
    monkeypatch.chdir(tmp_path)
    demands = synthetic_demands(bridge="mine", skews=(0, 30), gaps=(25,))
    demands["motion_id"] += f"</script>{script}"
    demands["collapse_criterion"] = script
    state = STATES[0] | {"citation": script}
    caption = {"name": "one", "section": SECTIONS[0], "title": script, "text": script,
               "finding": script, "item": script}  # fmt: skip
    page, _ = render(demands, states=[state], bridges=("mine",), captions=(caption,))
    assert "Bridge &lt;script&gt;alert(1)&lt;/script&gt; &amp; &#39;sons&#39;" in page
    assert "alert(1)" in page
    assert "<script>alert" not in page
    packed = re.search('id="explorer-data"[^>]*>([^<]*)', page)[1]
    data = json.loads(gzip.decompress(base64.b64decode(packed)))
    assert f"</script>{script}" in data["motions"][0]


def test_the_page_compares_the_medians_of_shear_failure_under_three_capacity_models(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    ratio = demands["column_shear_dcr"] / demands["column_shear_dcr"].median()
    factors = {"sdc_expected": 0.95, "sdc_nominal": 1.1, "kowalsky_priestley": 0.02}
    for name, factor in factors.items():
        demands[f"column_shear_dcr_{name}"] = factor * ratio
    page, _ = render(demands)
    head = "Median capacity for shear failure of a column under three capacity models (4)"
    assert head in page
    table = page[page.index(head) :].split("</table>")[0]
    assert "SDC, nominal materials, θ [interval]" in table
    assert re.search(r"<td[^>]*>0 of \d+ runs fail", table)


# --- headline of the README


ROOT = Path(__file__).parents[2]
LEADING = ("column_failure/any", "unseating/slight")


def in_name(name):
    """Return the numbers in a name."""
    return [float(number) for number in NUMBER.findall(name)]


def headline_values(table, runs, motions):
    """Return the numbers of the headline in the order of the text, each from its own rows."""
    medians = table[table["quantity"] == "median_capacity"]
    models = list(dict.fromkeys(medians["bridge"]))
    names = [in_name(model) if len(models) > 1 else [] for model in models]
    for change, part in medians.groupby(["axis", "from_value", "to_value"], sort=False):
        yield from change[1:]
        for state in LEADING:
            for row in part[part["demand"] == state].to_dict("records"):
                if row["status"] == "ok":
                    yield from (100.0 * (row[n] - 1.0) for n in ("ratio", "ci_low", "ci_high"))
                yield from in_name(row["bridge"])
    whole = runs[runs["axis"] == ""].set_index("bridge")
    yield from whole[["n_failed", "n_runs"]].sum()
    for model, name in zip(models, names, strict=True):
        yield from [*whole.loc[model, ["n_failed", "n_runs"]], *name] if name else []
    yield from whole[["n_shear", "n_flexure"]].sum()
    yield whole["n_bounds"].sum()
    yield 100.0 * medians["level"].max()
    yield len(motions)
    yield from motions[["magnitude", "distance_km"]].iloc[0]
    yield from (table["first_im"].min(), table["last_im"].max())
    rows = medians[medians["demand"].isin(LEADING) & (medians["status"] == "ok")]
    for (bridge, _), part in rows.groupby(["bridge", "demand"], sort=False):
        if part["n_extrapolated"].sum() > 0:
            yield from [*in_name(bridge), part["im_low"].min(), part["im_high"].max()]
        elif part["n_without_curve"].sum() > 0:
            yield from in_name(bridge)


def assert_headline(text, stored):
    assert_printed(text, list(headline_values(*stored)))


def assert_wrong_numbers_are_found(text, stored):
    """Check that `assert_headline` finds every wrong number; a test of the tests."""
    for wrong in wrong_numbers(text):
        with pytest.raises(AssertionError):
            assert_headline(wrong, stored)


@pytest.fixture(scope="module")
def repository(tmp_path_factory):
    """Return the folder of a repository with the headline of a small study, and its tables."""
    root = tmp_path_factory.mktemp("repository")
    demands = synthetic_demands(skews=(0, 30), gaps=(51,), motions=12)
    demands["cpu_s"] = 3.0
    demands["beyond_model"] = np.where(demands["column_shear_dcr"] >= 0.6, "shear", "")
    states = load_limit_states(ROOT / "config" / "limit_states.yaml")
    wanted = ("column_curvature", "unseating", "bearing")
    states = [state for state in states if state.component in wanted]
    tables = fragility_tables(demands, states, FitSettings(bootstrap=99))
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


def test_the_readme_agrees_with_its_stored_tables():
    """If not: `make headline` on a finished study writes both."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    stored = headline.stored_tables(ROOT)
    text = headline.headline_text(*stored)
    assert headline.with_headline(readme, text) == readme
    assert_headline(text, stored)
    assert_wrong_numbers_are_found(text, stored)
    with pytest.raises(InputError, match="markers"):
        headline.with_headline("nothing", "text")


def test_headline_of_a_study_prints_numbers_of_its_tables(repository):
    root, _ = repository
    stored = headline.stored_tables(root)
    text = headline.headline_text(*stored)
    assert_headline(text, stored)
    assert_wrong_numbers_are_found(text, stored)
    readme = (root / "README.md").read_text(encoding="utf-8")
    assert (readme[:7], readme[-7:]) == ("before\n", "\nafter\n")
    assert "previous text" not in readme
    assert "of one scenario, magnitude 6.5 at 8 km" in readme
    assert (root / headline.PICTURE).stat().st_size > 10_000


def test_claim_on_a_headline_demand_is_the_verdict_at_its_intensity(repository):
    root, tables = repository
    stored = headline.stored_tables(root)[0]
    demands = stored[(stored["quantity"] == "demand") & stored["im"].notna()]
    assert len(demands)
    lines = tables["intensity_effects"]
    names = ["bridge", "abutment", "demand", "axis", "from_value", "to_value"]
    for row in demands.to_dict("records"):
        same = (lines[names] == pd.Series({name: row[name] for name in names})).all(axis=1)
        there = lines[same & np.isclose(lines["im"], row["im"], rtol=1e-4)]
        assert len(there)
        if row["claim"] in ("lower", "higher", "negligible"):
            assert row["claim"] in set(there["verdict"])
