"""The page and the headline of the README state what the tables of a study contain."""

import base64
import gzip
import json
import re
from dataclasses import replace
from importlib.resources import files

import headline
import numpy as np
import pandas as pd
import pytest
import yaml
from reference_pages import ROOT

from fragility_tables import IM, synthetic_demands
from report_pages import NUMBER, STATES, assert_printed, tables_of, write_page
from skewbridge.bridge.backfill import LARGEST_TESTED_SKEW_DEG
from skewbridge.bridge.library import load_structure
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import fragility_tables
from skewbridge.report import answer as answers
from skewbridge.report import fragility_figures as figures
from skewbridge.report import page as report
from skewbridge.report.answer import effect_name, run_counts
from skewbridge.report.appearance import demand_name, in_words, with_unit
from skewbridge.report.methods import methods_of
from skewbridge.report.page import bridge_words, is_at_own_period, joint_rows, sketch
from skewbridge.report.study_figures import SECTIONS
from skewbridge.study.config import parse_config
from skewbridge.variant.options import ModelOptions

SHEAR = "Shear capacity models"
TABLES = ("The answer", "Effects, all variants", "Effects, other states and demands")
AXES, ENDS = ("skew_deg", "gap_mm", "friction"), ("", "_low", "_high")
SHOWN = {"column_drift": 100.0, "bearing": 1000.0, "column_failure": 1.0}  # in per cent and mm
MEDIAN, TOTAL = ([f"{name}{end}" for end in ENDS] for name in ("theta", "beta_total"))
COUNTS = ["n_exceed", "n_runs"]
LIMITS = {"n_cells": 4, "n_without_curve": 0, "n_extrapolated": 8}
SURE = {"claim": "undecided", "sure_to": 0.3, "sure_ratio": 0.7, "sure_low": 0.6, "sure_high": 0.8}


@pytest.fixture
def render(tmp_path):
    def page_of(demands, **study):
        page, frames = write_page(tmp_path, demands, **study)
        text = re.sub(r"<style>.*?</style>", "", page.read_text("utf-8"), flags=re.S)
        return re.sub(r"\s+", " ", text), frames

    return page_of


def finite(row, names):
    return [row[name] for name in names if np.isfinite(row[name])]


def pooled_effects(frames):
    """Yield label, heading, numbers and row of every pooled effect. The only failure mode of
    columns has the numbers of any failure and no row of its own."""
    rows = pd.concat([frames["medians"], frames["effects"]]).query("scope == 'pooled'")
    any_failure = set(rows.loc[rows["demand"] == "column_failure/any", "ratio"])
    for row in rows.to_dict("records"):
        mode = row["demand"].removeprefix("column_failure/")
        if mode in ("shear", "flexure") and row["ratio"] in any_failure:
            continue
        values = [100.0 * (row[name] - 1.0) for name in ("ratio", "ci_low", "ci_high")]
        if row["judged_by"] == "difference":
            values = [row[f"difference{end}"] for end in ENDS]
        name = row["demand"]
        label = f"Median, {effect_name(name)}" if "/" in name else demand_name(name)
        change = answers.change_name(row["axis"], row["from_value"], row["to_value"])
        yield label, change, values if row["status"] == "ok" else [], row


def assert_effects(tables, frames):
    answer, *maps = (tables.get(name, []) for name in TABLES)
    demands, changes, states = frames["demands"], {row[0]: row for row in answer[1:]}, answer[0]
    names = {f"{row['component']}/{row['limit_state']}": figures.state_text(row)
             for row in frames["curves"].to_dict("records")}  # fmt: skip
    curves = frames["curves"].drop_duplicates(["variant", "component", "limit_state"])
    counts = curves.groupby(curves["component"] + "/" + curves["limit_state"])[COUNTS].sum()
    cells, margins = {}, {}
    for heads, label, *row in ((table[0], *row) for table in maps for row in table[1:]):
        name, _, margins[label.partition("±")[0].strip()] = label.partition("±")
        cells |= {(name.strip(), head): cell for head, cell in zip(heads[1:], row, strict=True)}
    effects = list(pooled_effects(frames))
    assert len(cells) >= len(effects) > 10
    for label, change, values, row in effects:
        assert_printed(cells.pop((label, change)), values)
        by_ratio = row["judged_by"] != "difference"
        margin = 100 * row["margin"] if by_ratio else row["difference_margin"]
        assert_printed(margins[label], [margin] if margins[label] else [])
        state = names.get(row["demand"])
        if change in changes and state in states:
            ends = [row["from_mean"], row["from_mean"] * row["ratio"]]
            numbers = [values[0], *ends, *values[1:]] if values else counts.loc[row["demand"]]
            assert_printed(changes[change][states.index(state)], numbers)
    assert {*cells.values()} <= {"–"}
    assert set(changes) == {change for _, change, *_ in effects}
    for label, row in changes.items():
        name = label.split()[0].lower().replace("skew", "skew_deg").replace("gap", "gap_mm")
        failed = demands.assign(failed=demands["beyond_model"] != "").groupby(name)["failed"]
        (first, *_, last), (runs, *_, runs_of_last) = failed.sum(), failed.size()
        assert_printed(row[-1], [first, *{runs} - {runs_of_last}, last, runs_of_last])


def assert_leading(tables, frames):
    curves = figures.with_system(frames["curves"], frames["system"])
    lines = iter(tables.get("Leading curves", [[]])[1:])
    for table in figures.main_curves(figures.pooled_curves(curves, frames["medians"])).values():
        for state, part in table.groupby(["bridge", "component", "limit_state"], sort=False):
            heading = next(lines)[0]
            assert heading.startswith(state[0])
            assert in_words(state[1]) in heading
            for row in part.to_dict("records"):
                cells = next(lines)
                some = row["n_curves"] < row["n_variants"]
                counts = [row["n_curves"], row["n_variants"]] if some else []
                assert_printed(cells[0], [row["value"], *counts])
                names = (*MEDIAN, "beta", "beta_total", "n_exceed", "n_runs")
                assert_printed(" ".join(cells[1:5]), [row[name] for name in names])
                assert_printed(cells[5], finite(row, ("ratio", "ci_low", "ci_high")))
    assert next(lines, None) is None


def assert_system(tables, frames):
    for cells, row in zip(tables["System"][1:], frames["system"].to_dict("records"), strict=True):
        assert row["bridge"] in cells[0]
        assert_printed(cells[1], [row[name] for name in AXES])
        assert_printed(cells[3], [row["n_exceed"], row["n_runs"]])
        names = (*MEDIAN, "beta", "theta_correlated", "theta_independent")
        assert_printed(" ".join(cells[4:8]), finite(row, names))


def assert_paper(tables, frames):
    states = frames["paper"].groupby(["bridge", "component", "limit_state"], sort=False)
    lines = iter(tables["Fragility of every variant"][1:])
    thresholds = frames["curves"].groupby(["component", "limit_state"])["threshold"].first()
    names = [*MEDIAN, "beta", *TOTAL, "n_exceed", "n_runs"]
    names += [f"{axis}_ratio{end}" for axis in ("friction", "skew") for end in ENDS]
    for (bridge, *state), part in states:
        heading = next(lines)[0]
        assert heading.startswith(bridge)
        threshold = SHOWN[state[0]] * thresholds[tuple(state)]
        assert_printed(heading.removeprefix(bridge), [threshold])
        for row in part.to_dict("records"):
            cells = next(lines)
            assert_printed(cells[0], [] if row["row"] == "joint" else [row[name] for name in AXES])
            assert_printed(" ".join(cells[1:]), finite(row, names))
    assert next(lines, None) is None


def assert_shear_models(tables, frames):
    models = frames["shear_models"].groupby("variant", sort=False)
    for cells, (_, part) in zip(tables.get(SHEAR, [])[1:], models, strict=True):
        assert part["bridge"].iloc[0] in cells[0]
        assert_printed(cells[1], [part[name].iloc[0] for name in AXES])
        assert {cells[2]} == set(part["method"])
        for cell, row in zip(cells[3:], part.to_dict("records"), strict=True):
            is_ok = row["status"] == "ok"
            assert_printed(cell, [row[name] for name in (MEDIAN if is_ok else COUNTS)])
            assert is_ok == (in_words(row["status"]) not in cell)


def assert_tables(page, frames):
    tables = tables_of(page)
    for check in (assert_effects, assert_leading, assert_system, assert_paper, assert_shear_models):
        check(tables, frames)


def assert_in(text, *words):
    assert [each for each in words if each not in text] == []


def test_counts_and_answers_are_those_of_the_study(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))[:-1]  # a value has one run less
    page, frames = render(demands)
    # friction above its limit, of the analyses that rub
    assert_in(page, f"Columns failed in 0 of {len(demands)} runs.", "a median of 3 %")
    assert "capacity models" not in page
    assert_tables(page, frames)
    pooled = frames["effects"].query("scope == 'pooled' and status == 'ok'").groupby("axis")
    ends = pooled["n_motions"].agg(["min", "max"]).loc[["skew_deg", "friction"]]
    text = re.search("pair of runs, for demands: ([^.]*)[.]", page)[1]
    assert_printed(text, [number for pair in ends.to_numpy() for number in sorted(set(pair))])
    assert tables_of(page)["The answer"][0][2] == "bearing, slight (100 mm)"


def test_failures_tables_intensities_and_links_are_those_of_the_study(render):
    demands = synthetic_demands(skews=(0, 30), gaps=(25,)).assign(scale=1.5, beyond_model="")
    demands.loc[demands.index[0], "scale"] = 0.25
    demands.loc[demands.index[:7], "beyond_model"] = ["shear"] * 5 + ["flexure"] * 2
    page, frames = render(demands)
    head = page[page.index('<section id="answer">') : page.index('<section id="effects">')]
    failed = f"Columns failed in 7 of {len(demands)} runs: 5 in shear, 2 in flexure"
    assert_in(head, failed, "None of them collapsed; the demands of all are peaks up to the fail")
    assert set(frames["curves"]["im"]) == {IM}
    assert_in(page, "Median θ of Sa,avg RotD50 (g)", "motions scaled by 0.25 to 1.5,")
    assert_tables(page, frames)
    assert {*re.findall(r'href="#([^"]+)"', page)} <= {*re.findall(r'id="([^"]+)"', page)}


def test_accuracy_suspect_rows_needed_motions_and_the_factor_of_hazus_are_stated(render):
    demands = synthetic_demands(skews=(0, 30, 60), gaps=(25,)).assign(beyond_model="")
    demands["beyond_model"] = np.where(demands["column_shear_dcr"] >= 0.6, "shear", "")

    def edit(frames):
        accuracy = {"demand": ["deck_disp_m", "slip_work_kj"], "rows": 4, "analysed_s": 6.0}
        frames["sensitivity"] = pd.DataFrame(accuracy | {"reference_largest_change": [0.01, 0.15]})
        failed = frames["demands"]["beyond_model"] != ""
        residuals = failed.map({True: 0.5, False: 0.002})
        return frames | {"demands": frames["demands"].assign(energy_residual_ratio=residuals)}

    ratio = {"component": "column_shear", "demand": "column_shear_dcr", "states": {"dcr_100": 1.0}}
    states = [*STATES, STATES[0] | ratio | {"unit": "ratio"}]
    page, frames = render(demands, states=states, edit=edit)
    failed = int((demands["beyond_model"] != "").sum())
    words = "from the reference accuracy by 8 % (median demand), 15 % at worst (slip work)"
    suspect = f"0 suspect rows, {failed} by the energy after a column failure"
    rows = "4 runs under motions up to the median strength"
    assert_in(page, f"Demands of {rows} differ {words}", suspect, "Doubts about one motion: see")
    heads, *published = (tables := tables_of(page))["Published effects of skew"]
    assert tables["Notes on the motions"][1:] == [["a", "spike?"]]
    assert report.published_rows(frames["medians"].assign(status="no_curve")) == []
    # sqrt(sin(90° - skew))
    assert [row[:2] for row in published] == [["30°", "0.93"], ["60°", "0.71"]]
    skews = frames["medians"].query("scope == 'pooled' and axis == 'skew_deg'")
    for skew, _, *cells in published:
        for head, cell in zip(heads[2:], cells, strict=True):
            demand = skews["demand"].map(effect_name) == head.partition(", ")[2]
            (row,) = skews[demand & (skews["to_value"] == float(skew[:-1]))].to_dict("records")
            assert_printed(cell, [row[name] for name in ("ratio", "ci_low", "ci_high")])
    needed = frames["needed_motions"].query("forecast == 'more motions'").to_dict("records")
    cells = tables["Motions needed"][1:]
    assert len(cells) == len(needed) > 0
    for (_, change, demand, *counts), row in zip(cells, needed, strict=True):
        assert (change, demand) == (answers.change_of(row), effect_name(row["demand"]))
        assert_printed(" ".join(counts), [row["n_motions"], row["needed_motions"]])
    # the row of any failure is also that of the only mode, and of its ratio
    effects = page[page.index('id="effects"') :].split("<section")[0]
    assert "Median, column failure" in effects
    assert not re.search(r"column failure \(shear\)|column shear \(DCR 1", effects)


def test_rate_factors_of_fewer_pairs_or_without_curves_are_marked_and_come_last():
    change = {
        "bridge": "osb1", "abutment": "contact_friction", "axis": "skew_deg", "from_value": 0.0,
        "to_value": 60.0, "limit_state": "slight", "scope": "pooled", "status": "ok", "level": 0.9,
        "direction": 1, "from_rate": 1e-3, "to_rate": 2e-3, "ci_low": 1.2, "ci_high": 3.0,
    }  # fmt: skip
    few, lack = {"component": "unseating", "ratio": 2.0}, "7 of 8 variants lack a curve"
    all_pairs = {"component": "column_failure", "limit_state": "any", "ratio": 1.5, "n_cells": 4.0}
    medians = change | {"demand": answers.LEADING_STATES[::2], "n_without_curve": [0, 7]}
    medians["verdict_family"] = "lower"
    for pairs, note in ((1.0, "1 of 4 pairs"), (4.0, f"from a model: {lack}")):
        table = pd.DataFrame([change | few | {"n_cells": pairs}, change | all_pairs])
        rates = answers.rates_on_page({"rate_effects": table, "medians": pd.DataFrame(medians)})
        assert "of column failure by 1.5" in rates["sentence"]
        assert [row["pairs"] for row in rates["rows"]] == [f" ({note})", ""]
    # an undecided change of the median is not a certain change of the rate
    medians["verdict_family"] = "undecided"
    rates = answers.rates_on_page({"rate_effects": table, "medians": pd.DataFrame(medians)})
    assert rates["sentence"].startswith("No axis changes")


def test_a_missing_exceedance_or_comparison_is_stated(render):
    beyond = [STATES[0] | {"states": {"complete": 900.0}}]
    page, _ = render(synthetic_demands(skews=(0,), gaps=(25,)), states=beyond)
    assert_in(page, "No limit state has an estimate", "no exceedance")
    page, _ = render(synthetic_demands(motions=1, skews=(30,), gaps=(25,), frictions=(50,)))
    no_pair = "No two variants of this study can be compared."
    assert_in(page, "No comparison is possible", "1 motion unscaled,", no_pair)


def test_sketch_and_words_have_the_geometry_of_the_bridge():
    bridge = load_structure("osb1").description
    drawn = sketch(bridge, [0, 60], [25, 51], ModelOptions())
    deck, (wall, *_) = np.array(drawn["decks"][0]), np.array(drawn["walls"])
    size = [bridge.length_m + bridge.width_m * np.tan(np.pi / 3), bridge.width_m]
    assert np.ptp(deck, axis=0) == pytest.approx(size)
    assert (drawn["skew"], len(drawn["others"]), len(drawn["columns"])) == (60, 1, 2)
    gap_m = (deck[0, 0] - wall[0, 0]) * np.cos(np.pi / 3)
    assert gap_m == pytest.approx(drawn["factor"] * 0.051)
    step_x, step_y = np.diff(np.mean(drawn["columns"], axis=1), axis=0)[0]
    assert (step_y, step_x / step_y) == pytest.approx((7.32, -np.tan(np.pi / 3)))
    for about, bents in ((bridge, "square"), (replace(bridge, bents_turn=False), "abutment")):
        square = sketch(about, [0, 60], [25, 51], ModelOptions(bent_skew=bents))["columns"]
        assert np.mean(square, axis=1)[:, 0] == pytest.approx([0.0, 0.0])
    one_key = replace(bridge, keys_at={"left": "none", "right": "+y"})
    _, _, key = sketch(one_key, [0], [25], ModelOptions())["walls"]
    assert min(np.array(key)[:, 1]) > bridge.width_m / 2
    joint = {"joints_m": {"bent 1": 0.0}, "seats_m": {"joint 1": 0.6}, "gaps_mm": {"joint 1": 60.0}}
    ends = {"end_kinds": {"left": "integral", "right": "roller"}, "skews_deg": {"left": 10.0}}
    drawn = sketch(other := replace(bridge, **joint, **ends), [30], [25], ModelOptions())
    # one wall that touches the deck at its own skew, and a gap between the decks
    first, second, wall = map(np.array, (*drawn["decks"], *drawn["walls"]))
    assert wall[[0, 3]] == pytest.approx(first[[0, 3]])
    assert first[0, 0] - first[3, 0] == pytest.approx(bridge.width_m * np.tan(np.pi / 18))
    gap_m = second[0, 0] - first[1, 0]
    # its own, not that of the study
    assert gap_m * np.cos(np.pi / 6) == pytest.approx(drawn["factor"] * 0.060)
    assert bridge_words(other).endswith("; integral left end and roller right end; joint at bent 1")
    for name, words in (("bridge_a", "single-column"), ("osb1", "pinned two-column"),
                        ("osb1_fixed", "91.4 m long, fixed two-column")):  # fmt: skip
        assert bridge_words(load_structure(name).description).endswith(f"{words} bent")
    on_pads = load_structure(ROOT / "docs/bridges/continuous_on_bearings.yaml").description
    assert bridge_words(on_pads).endswith("; bearings at bent 1 and bent 2")


def test_joints_of_a_bridge_are_named_with_their_demands(render):
    spans = load_structure(str(ROOT / "docs" / "bridges" / "simple_spans.yaml"))
    runs = synthetic_demands(bridge=spans.name, motions=3, skews=(0,), gaps=(25,), frictions=(0,))
    runs["status"] = ["ok", "ok", "collapse"]
    for number in (1, 2, 3):
        runs[f"joint{number}_unseating_m"] = [0.1 * number, 0.2 * number, 9.0]
        runs[f"joint{number}_closures"] = [4.0, 8.0, 99.0]
    _, second, _ = joint_rows(runs, [load_structure("osb1"), spans])
    assert [*second.values()] == ["simple_spans", "2, bent 2", "300", "368", "6", "7.36"]
    # the first table has both kinds of unseating beside the failure of columns
    runs = synthetic_demands(skews=(0, 30), gaps=(25,), frictions=(0,)).assign(beyond_model="")
    runs["joint_unseating_m"] = 1.2 * runs["unseating_m"]
    limit = {"unit": "m", "dispersion": 0.3, "citation": "a test", "states": {"slight": 0.1}}
    kinds = ("unseating", "joint_unseating")
    states = [limit | {"component": kind, "demand": f"{kind}_m"} for kind in kinds]
    heads = " ".join(tables_of(render(runs, states=states)[0])["The answer"][0])
    assert "column failure joint unseating, slight (100 mm) unseating, slight (100 mm)" in heads


def test_methods_settings_and_units_of_the_page_are_those_of_the_study(render):
    demands = synthetic_demands(motions=3, skews=(0, 60), gaps=(25, 51), frictions=(50,))
    config = {"grid": {"skew_deg": [0, 60], "gap_mm": [25, 51], "friction": [0.5]}}
    config |= {"motions": {"count": 3}, "figures": {"units": "us"}}
    other = synthetic_demands(bridge="osb1_era1", motions=3, gaps=(76,), frictions=(50,))
    page, _ = render(pd.concat([demands, other], ignore_index=True), config=config)
    abutments = "skew 0°, 60°; the joint gap 0.984 in, 2.01 in; friction 0.5: four variants"
    plan = "Plan of osb1 with skew 0°, 60°, gap 0.984 in, 2.01 in, friction 0.5"  # not of the other
    assert_in(page, abutments, plan, "motions.count</code> 3 (default ", "300.0 ft long")
    lines = {*re.findall(r'<text x="\S+" y="(\S+)"', page)}
    assert len(lines) == 4  # long texts on skew and gap would cover others
    assert "<code>analysis.dt_s</code>" not in page
    assert " mm" not in re.sub(r"<details><summary>(Methods|Provenance).*?</details>", "", page)
    # the range of intensities is that of the motions
    given = {"source": ["a"] * 2, "scale": [1.0, 2.0], "im_saavg_rotd50_g": [0.11, 0.4]}
    given |= {"motion_id": ["a", "b"], "stripe_g": [0.1, 0.8]}
    for design, words in (("scaled_cloud", "spans 0.11 to 0.8 g"), ("stripes", " (1, 1 motions),")):
        config = parse_config({"motions": {"count": 2, "design": design}})
        assert words in methods_of(config, pd.DataFrame(given)).parts["Ground motions"]
    # the first screen has the intensities of the fits, at the T1 of each bridge
    assert [is_at_own_period(IM, [name]) for name in ("osb1", "other")] == [False, True]


def answer_row(axis, demand, ratio, claim, **changes):
    given = {
        "bridge": "osb1", "abutment": "contact_friction", "axis": axis, "from_value": 0.0,
        "to_value": 0.5, "quantity": "median_capacity", "demand": demand, "status": "ok",
        "ratio": ratio, "ci_low": 0.95 * ratio, "ci_high": 1.05 * ratio, "level": 0.9,
        "margin": 0.05, "verdict": claim, "claim": claim, "from_demand": 2.0,
        "to_demand": 2.0 * ratio, "measure": "im_saavg_rotd50_g",
    }  # fmt: skip
    return dict.fromkeys(answers.ANSWER_COLUMNS, np.nan) | given | changes


def headline_of(*rows):
    return answers.headline(pd.DataFrame(rows))


def test_headline_has_one_sentence_per_axis_certain_and_large_effects_first():
    demand = {"quantity": "demand", "im": 0.5, "from_demand": 0.1, "to_demand": 0.125}
    assert headline_of(
        answer_row("friction", "unseating/slight", 1.02, "undecided"),
        answer_row("gap_mm", "unseating/slight", 1.03, "negligible"),
        answer_row("gap_mm", "column_drift/slight", 1.1, "undecided"),
        answer_row("skew_deg", "column_failure/any", 0.72, "detectable"),
        answer_row("skew_deg", "unseating/slight", 0.8, "lower"),
        answer_row("skew_deg", "deck_disp_m", 1.25, "higher", **demand),
    ) == [
        "Skew 0° to 0.5° lowers the median capacity for column failure by 0.56 g (2.00 to 1.44 g, "
        "-28 %, direction certain) and for unseating (slight) by 0.4 g (2.00 to 1.60 g, -20 %, "
        "certain) and raises deck displacement by 25 mm (100 to 125 mm at 0.5 g; certain).",
        "Gap 0 mm to 0.5 mm changes no median capacity for unseating (slight) by more than 5 % "
        "(most: 0.06 g).",
        "Not decided with these motions: friction on unseating (slight) (+2.0 %, -3.1 to +7.1 %).",
    ]
    # other bridges with the same direction are named
    row = answer_row("skew_deg", "column_failure/any", 0.8, "lower")
    other = answer_row("skew_deg", "column_failure/any", 0.88, "detectable", bridge="osb2s")
    assert headline_of(row, other) == [
        "Skew 0° to 0.5° lowers the median capacity for column failure of osb1 by 0.4 g "
        "(2.00 to 1.60 g, -20 %, certain; as in osb2s: -12 %, direction certain)."
    ]
    assert "as in" not in headline_of(row, other | {"claim": "undecided"})[0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "g, +8.0 %, certain, extrapolated)"),
        ({"n_extrapolated": 3}, "%, certain, partly extrapolated)"),
        ({"n_extrapolated": 0, "n_without_curve": 4}, "from a model: 4 of 8 variants lack a curve"),
        ({"n_extrapolated": 0}, "%, certain)"),
        (SURE, "certain up to 0.3: -30 % (-40 to -20 %)"),
    ],
)
def test_headline_states_smaller_certain_ranges_and_extrapolated_medians(changes, words):
    row = answer_row("friction", "column_failure/any", 1.08, "higher") | LIMITS | changes
    assert words in headline_of(row)[0]


def test_failures_are_counted_only_with_capacities_of_columns():
    runs = run_counts(synthetic_demands(motions=2).assign(beyond_model=""))
    first, _ = answers.failure_sentences(runs)
    assert first == f"Columns failed in 0 of {runs['n_runs'].iloc[0]} runs."
    assert "no column capacities" in answers.failure_sentences(runs, has_capacities=False)[0]
    failed = synthetic_demands(motions=2).assign(beyond_model="shear")
    failed.loc[failed.index[:3], "status"] = "collapse"
    whole = failed.assign(beyond_model="")
    tables = map(run_counts, (failed, whole, whole[:4].assign(status="timeout")))
    ends = [answers.failure_sentences(counts)[1].partition(" are peaks")[0] for counts in tables]
    assert ends[0] == "3 of them collapsed; the demands of all"
    assert ends[1] == "Three runs collapsed. In 3 runs the demands"
    assert ends[2].startswith("No runs collapsed. 4 of 4 runs stopped before their end without a")
    foreign = run_counts(synthetic_demands(motions=2).assign(drift_over_capacity=1.2))
    assert (foreign["n_failed"] == foreign["n_runs"]).all()


def test_page_states_largest_untested_skew_of_a_backfill_and_why_rounds_ended(render, tmp_path):
    cases = ((60, "roller"), (60, "my"), (-55, "spring"), (45, "spring"))
    few = {"gaps": (25,), "frictions": (0,)}
    parts = [synthetic_demands(skews=(0, s), **few).assign(abutment=name) for s, name in cases]
    sentence = "No test of backfill has a skew above 45°: the passive strength at"
    parts[0] = parts[0].assign(gap_mm=0, variant="ro_" + parts[0]["variant"])  # it lacks a gap
    page, _ = render(pd.concat(parts[:3], ignore_index=True))
    assert ("gap 25 mm" in page, "gap 0 mm" in page) == (True, False)
    assert set(re.findall(rf"{sentence} (\d+)° is extrapolated\.", page)) == {"55"}
    (tmp_path / "rounds").mkdir()
    plan = {"round": 1, "ended": "hours", "hours": 2.0, "decided": 0, "cells": []}
    (tmp_path / "rounds/round1.json").write_text(json.dumps(plan))
    page, _ = render(parts[3], config={"design": {"until": "decided"}})
    assert sentence not in page
    assert_in(page, "Rounds ended after round 0: 0 of 0 headline effects decided; the time is used")


def test_texts_of_a_user_are_shown_and_never_run(render, tmp_path, monkeypatch):
    script = "<script>alert(1)</script>"
    catalogue = files("skewbridge.bridge.catalogue") / "osb1.yaml"
    bridge = yaml.safe_load(catalogue.read_text("utf-8"))
    bridge |= {"name": "mine", "title": f"Bridge {script} & 'sons'"}
    (own := tmp_path / "config" / "bridges").mkdir(parents=True)
    (own / "mine.yaml").write_text(yaml.safe_dump(bridge), "utf-8")
    monkeypatch.chdir(tmp_path)
    demands = synthetic_demands(bridge="mine", skews=(0, 30), gaps=(25,))
    demands["motion_id"] += f"</script>{script}"
    demands["collapse_criterion"] = script
    caption = dict.fromkeys(("title", "text", "finding", "item"), script)
    caption |= {"name": "one", "section": SECTIONS[0]}
    states = [STATES[0] | {"citation": script}]
    page, _ = render(demands, states=states, bridges=("mine",), captions=(caption,))
    assert "Bridge &lt;script&gt;alert(1)&lt;/script&gt; &amp; &#39;sons&#39;" in page
    assert "<script>alert" not in page
    packed = re.search('id="explorer-data"[^>]*>([^<]*)', page)[1]
    data = json.loads(gzip.decompress(base64.b64decode(packed)))
    assert f"</script>{script}" in data["motions"][0]


def test_shear_failures_are_counted_for_every_strength_model():
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    counts = {"ucsd_tests": 2, "sdc_expected": 7, "sdc_nominal": 9, "kowalsky_priestley": 0}
    for name, count in counts.items():
        demands[f"column_shear_dcr_{name}"] = np.where(np.arange(len(demands)) < count, 1.0, 0.99)
    for status, note in (("ok", "strength. osb1"), ("collapse", "ended early). osb1")):
        text = answers.shear_model_sentence(demands.assign(status=status))
        words = f"({len(demands)} runs): 2 by UCSD, mean of tests; 7 by SDC, expected materials"
        assert_in(text, note, words, "; 0 by Kowalsky and Priestley.")


def test_the_page_prints_the_stored_medians_under_three_shear_models(render):
    """The page does not fit: other values in the stored table are printed as they are."""
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    ratio = demands["column_shear_dcr"] / demands["column_shear_dcr"].median()
    # one is never above 1
    for name, factor in (("expected", 0.95), ("nominal", 1.1), ("kowalsky_priestley", 0.02)):
        model = name if "_" in name else f"sdc_{name}"
        demands[f"column_shear_dcr_{model}"] = factor * ratio

    def edit(frames):
        models = frames["shear_models"]
        models.loc[:2, list(MEDIAN)] = [0.7531, 0.6421, 0.8642]
        models.loc[3:4, "status"] = "not_ordered"
        return frames

    page, frames = render(demands, edit=edit)
    assert_tables(page, frames)
    _, first, second, *_ = tables_of(page)[SHEAR]
    assert first[3] == "0.753 [0.642, 0.864]"
    assert re.fullmatch(r"\d+ of 16 runs fail: not ordered", second[3])
    assert first[5] == "0 of 16 runs fail: no exceedance"


def test_texts_on_a_missing_ratio_have_its_status_and_the_runs_that_exceed_the_state():
    state, axes = "column_failure/any", ("skew_deg", "gap_mm")
    known = answer_row("friction", "unseating/slight", 1.02, "undecided")
    runs = run_counts(synthetic_demands(motions=2))
    for status, text in (
        ("bounds_too_wide", "bounds too wide, 3 of 16 runs exceed it"),
        ("no_exceedance", "no exceedance in some variants, 3 of 16 runs exceed it"),
        ("all_exceed", "all exceed in some variants, 3 of 16 runs exceed it"),
        ("not_reached", "no run reaches it"),
    ):
        counts = {"status": status, "n_exceed": 3, "n_runs": 16}
        suite = pd.DataFrame({"source": ["synthetic"], "motion_id": "a"})
        missing = [answer_row(axis, state, np.nan, "", **counts) for axis in axes]
        title = "No median capacity of a headline state can be compared; osb1, column failure"
        assert headline_of(*missing) == [f"{title}: {text}."]
        further = answer_row("skew_deg", "bearing/moderate", 1.02, "undecided")
        assert headline_of(*missing, further) == [f"{title}: {text}."]
        table = pd.DataFrame([*missing, known])
        printed = headline.headline_text(table, runs, suite)
        assert f"by an unknown amount ({text}) in osb1" in printed


# statuses of the curves without and with friction, runs above the state, status of the ratio
@pytest.mark.parametrize(
    ("statuses", "exceed", "status"),
    [
        (["ok", "ok"], 4, "too_few_motions"),
        (["ok", "ok"], 4, "not_estimable"),
        (["ok", "bounds_too_wide"], 4, "bounds_too_wide"),
        (["no_exceedance", "no_exceedance"], 0, "not_reached"),
        (["no_exceedance", "ok"], 4, "no_exceedance"),
        (["not_applicable", "not_applicable"], 0, "not_applicable"),
    ],
)
def test_status_of_a_ratio_is_that_of_the_curves_without_an_estimate(statuses, exceed, status):
    assert report.with_ends({"t": 0.9, "a": 0.0, "b": np.inf}, "tab") == "0.900 [0.00, ∞]"
    tables = fragility_tables(synthetic_demands(skews=(0, 30), gaps=(25,)), [], FitSettings())
    curves = tables["curves"].query("limit_state == 'any'")
    found = np.where(curves["friction"] > 0.0, *statuses)
    medians = tables["effects"].query("demand == 'unseating_m'")
    medians = medians.assign(demand="column_failure/any", status=status)
    medians = medians.reindex(columns=tables["median_effects"].columns)
    medians = medians[medians["status"] == "not_estimable"]  # the others lack a row
    table = answers.answer_table(medians=medians,
                                 effects=tables["effects"], intensities=tables["intensity_effects"],
                                 curves=curves.assign(status=found, n_exceed=exceed,
                                                      im="im_pgv_rotd50_mps"))  # fmt: skip
    assert {with_unit("1", name) for name in table["measure"]} == {"1 m/s"}
    found = table.loc[table["quantity"] == "median_capacity", ["status", "n_exceed"]]
    assert found.drop_duplicates().to_numpy().tolist() == [[status, 4 * exceed]]


def test_skews_of_both_signs_are_compared_with_zero_and_the_largest_is_the_answer():
    table = synthetic_demands(skews=(-45, 0, 30), gaps=(25,), frictions=(50,))
    tables = fragility_tables(table, limit_states_of(STATES), FitSettings())
    steps = tables["effects"][["axis", "from_value", "to_value"]].drop_duplicates()
    assert steps.to_numpy().tolist() == [["skew_deg", 0.0, -45.0], ["skew_deg", 0.0, 30.0]]
    medians, effects, curves = (tables[n] for n in ("median_effects", "effects", "curves"))
    given = {"effects": effects, "intensities": tables["intensity_effects"], "curves": curves}
    answer = answers.answer_table(medians=medians, **given)
    assert set(answer["to_value"]) == {-45.0}
    counts = run_counts(table.assign(status=np.where(table["skew_deg"] > 0, "collapse", "ok")))
    counts["n_failed"] = counts["n_collapse"]
    rows = report.answer_rows(answer, counts, curves)["rows"]
    assert {row["failed"] for row in rows} == {"0 to 0 of 16"}
    ratios = medians.query("scope == 'pooled' and to_value == -45").set_index("demand")["ratio"]
    joint = tables["table"].query("row == 'joint'")
    states = joint["component"] + "/" + joint["limit_state"]
    assert joint["skew_ratio"].tolist() == pytest.approx(ratios[states].tolist(), rel=1e-9)


DEMO = ROOT / "src/skewbridge/cli/demo_study"
LEADING = ("column_failure/any", "unseating/slight")


def in_name(name):
    return [float(number) for number in NUMBER.findall(name)]


def headline_values(table, runs, motions):
    medians = table[table["quantity"] == "median_capacity"]
    models = list(dict.fromkeys(medians["bridge"]))
    for change, part in medians.groupby(["axis", "from_value", "to_value"], sort=False):
        yield from change[1:]
        for row in pd.concat([part[part["demand"] == name] for name in LEADING]).to_dict("records"):
            if row["status"] == "ok":
                yield from (100.0 * (row[n] - 1.0) for n in ("ratio", "ci_low", "ci_high"))
                if row["n_without_curve"] > 0 and not row["n_extrapolated"] > 0:
                    yield from (row["n_without_curve"], 2 * row["n_cells"])
            elif row["n_exceed"] > 0:
                yield from (row[name] for name in COUNTS)
            yield from in_name(row["bridge"])
    whole = runs[runs["axis"] == ""].set_index("bridge")
    yield from whole[["n_failed", "n_runs"]].sum()
    for model in models if len(models) > 1 else ():
        if in_name(model):
            yield from [*whole.loc[model, ["n_failed", "n_runs"]], *in_name(model)]
    yield from (count for count in whole[["n_shear", "n_flexure"]].sum() if count > 0)
    collapsed, ended, stopped = whole[["n_collapse", "n_bounds", "n_stopped"]].sum()
    if ended == whole["n_failed"].sum() > 0:  # all runs that ended early have a failed column
        yield from (count for count in [collapsed] if count > 0)
    else:  # counts up to eight are words
        yield from [*(count for count in [collapsed] if count > 8), ended]
    yield from (stopped, whole["n_runs"].sum())[: 2 * (stopped > 0)]
    yield from (100.0 * medians["level"].max(), len(motions))
    if motions["source"].str.startswith("recorded").all():
        yield motions["event"].nunique()
    for name in ("magnitude", "distance_km"):
        yield from sorted({motions[name].min(), motions[name].max()})
    yield from (table["first_im"].min(), table["last_im"].max())
    largest_skew = table.loc[table["axis"] == "skew_deg", "to_value"].max()
    if largest_skew > LARGEST_TESTED_SKEW_DEG:
        yield from (LARGEST_TESTED_SKEW_DEG, largest_skew)


def test_the_readme_agrees_with_its_stored_tables():
    """If not: `make headline` on a finished study writes both."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    stored = headline.stored_tables(ROOT)
    text = headline.headline_text(*stored)
    assert headline.with_headline(readme, text) == readme
    assert_printed(text, list(headline_values(*stored)))
    with pytest.raises(InputError, match="markers"):
        headline.with_headline("nothing", "text")


def test_headline_of_a_study_prints_numbers_of_its_tables(tmp_path):
    (tmp_path / "docs/images").mkdir(parents=True)
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{headline.BEGIN}\nprevious text\n{headline.END}\nafter\n")
    headline.write_headline(DEMO, tmp_path)
    stored = headline.stored_tables(tmp_path)
    text = headline.headline_text(*stored)
    assert readme.read_text() == f"before\n{headline.BEGIN}\n{text}\n{headline.END}\nafter\n"
    assert_printed(text, list(headline_values(*stored)))
    for end in (match.end() for match in NUMBER.finditer(text)):  # another last digit of a number
        wrong = f"{text[: end - 1]}{(int(text[end - 1]) + 1) % 10}{text[end:]}"
        with pytest.raises(AssertionError):
            assert_printed(wrong, list(headline_values(*stored)))
    assert (tmp_path / headline.PICTURE).stat().st_size > 10_000
    # the claim on a demand is the verdict at its intensity
    demands = stored[0].query("quantity == 'demand' and im.notna()")
    assert len(demands)
    names = ["bridge", "abutment", "demand", "axis", "from_value", "to_value"]
    lines = read_frame(DEMO / "fragility/intensity_effects.parquet").set_index(names).sort_index()
    for row in demands.to_dict("records"):
        there = lines.loc[tuple(row[name] for name in names)]
        there = there[np.isclose(there["im"], row["im"], rtol=1e-4)]
        assert len(there)
        if row["claim"] in ("lower", "higher", "negligible"):
            assert row["claim"] in set(there["verdict"])
