"""The page says of a study what its tables say: several studies, each with its own sentences."""

import base64
import gzip
import json
import re
from importlib.resources import files

import numpy as np
import pandas as pd
import pytest
import yaml

from fragility_tables import IM, synthetic_demands
from report_pages import STATES, write_page
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.report.answer import ANSWER_COLUMNS, title_of
from skewbridge.report.html.sketch import bridge_words, sketch
from skewbridge.report.methods import methods_of
from skewbridge.report.study_figures import CURVES
from skewbridge.study.config import parse_config

BEYOND = [STATES[0] | {"states": {"complete": 900.0}}]


@pytest.fixture
def render(tmp_path):
    """Return a function that makes the tables of a study and its page, and gives page, tables."""

    def page_of(demands, **study):
        page, frames = write_page(tmp_path, demands, **study)
        return plain(page.read_text("utf-8")), frames

    return page_of


def plain(page):
    page = re.sub(r"<style>.*?</style>", "", page, flags=re.S)
    return re.sub(r"\s+", " ", page)


def test_bases_axes_and_counts_are_those_of_the_study(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    page, frames = render(demands)
    assert "pinned column bases" in page
    assert "fixed column bases" not in page
    assert "skew 0°, 60° × gap 25 mm × friction 0, 0.5" in page
    assert f"Columns failed in 0 of {len(demands)} runs" in page
    assert "a median of 3 %" in page  # friction above its limit, of the analyses that rub
    medians = frames["medians"]
    rows = medians[(medians["scope"] == "pooled") & (medians["status"] == "ok")]
    assert len(rows)
    for row in rows.to_dict("records"):
        low, high = (100.0 * (row[name] - 1.0) for name in ("ci_low", "ci_high"))
        assert f"{low:+.1f} to {high:+.1f} %" in page or f"{low:+.0f} to {high:+.0f} %" in page


def test_page_states_that_motions_are_scaled(render):
    demands = synthetic_demands(skews=(0,), gaps=(25,))
    demands["scale"] = 1.5
    demands.loc[demands.index[0], "scale"] = 0.25
    page, _ = render(demands)
    assert "motions scaled by 0.25 to 1.5," in page


def test_both_bases_are_named_with_their_bridges(render):
    demands = pd.concat(
        [
            synthetic_demands(bridge=name, skews=(0, 30), gaps=(25,), seed=seed)
            for seed, name in enumerate(("osb1", "osb1_fixed"))
        ],
        ignore_index=True,
    )
    page, _ = render(demands, bridges=("osb1", "osb1_fixed"))
    assert "<strong>osb1</strong>: two spans, 91.4 m long, pinned two-column bent" in page
    assert "<strong>osb1_fixed</strong>: two spans, 91.4 m long, fixed two-column bent" in page
    assert "<small>osb1_fixed</small>" in page


def test_mixed_abutments_have_columns_of_their_own(render):
    demands = pd.concat(
        [
            synthetic_demands(abutment="roller", gaps=(0,), frictions=(0,), skews=(0, 30)),
            synthetic_demands(gaps=(25,), skews=(0, 30)),
        ],
        ignore_index=True,
    )
    page, _ = render(demands, bridges=("osb1_fixed",))
    assert '<th scope="colgroup" colspan="1">osb1, roller</th>' in page
    assert '<th scope="colgroup" colspan="2">osb1, contact-friction</th>' in page
    assert "Each pair of variants: Skew, osb1, contact-friction" in page
    assert "pinned column bases" not in page


def test_a_study_in_which_nothing_exceeds_has_no_median(render):
    page, _ = render(synthetic_demands(skews=(0, 30), gaps=(25,)), states=BEYOND)
    assert "No limit state has an estimate" in page
    assert "no exceedance" in page


def test_a_single_variant_and_motion_compare_nothing(render):
    demands = synthetic_demands(motions=1, skews=(30,), gaps=(25,), frictions=(50,))
    page, _ = render(demands)
    assert "No comparison is possible" in page
    assert "1 motion unscaled," in page
    assert "No two variants of this study can be compared." in page


def test_one_motion_gives_no_estimate_and_the_page_says_so(render):
    page, _ = render(synthetic_demands(motions=1, skews=(30,), gaps=(25,)))
    assert "no median capacity to compare" in page
    assert "not estimable" in page


def test_failures_and_lower_bounds_are_on_the_first_screen(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    demands["beyond_model"] = ""
    demands.loc[demands.index[:5], "beyond_model"] = "shear"
    demands.loc[demands.index[5:7], "beyond_model"] = "flexure"
    page, _ = render(demands)
    head = page[page.index('<section id="answer">') : page.index('<section id="effects">')]
    assert f"Columns failed in 7 of {len(demands)} runs: 5 in shear, 2 in flexure" in head
    assert "0 runs collapsed; in 7 runs the demands are peaks up to a failure" in head
    assert ">4 to 3 of 32</td>" in head or ">7 to 0 of 32</td>" in head


def test_the_answer_has_sizes_intervals_and_certainty(render):
    page, frames = render(synthetic_demands(skews=(0, 60), gaps=(25,)))
    medians = frames["medians"]
    rows = medians[(medians["scope"] == "pooled") & (medians["demand"] == "bearing/slight")]
    assert len(rows) == 2
    head = page[page.index('<section id="answer">') : page.index('<section id="effects">')]
    for row in rows.to_dict("records"):
        ends = row["from_mean"], row["from_mean"] * row["ratio"]
        assert f"{ends[0]:.2f} → {ends[1]:.2f}" in head
    assert "<b>certain" in head or "certain</b>" in head


def test_the_sketch_has_the_geometry_of_the_study():
    bridge = load_bridge("osb1")
    drawn = sketch(bridge, [0, 60], [25, 51], 6.4)
    corners = np.array([point.split(",") for point in drawn["deck"].split()], dtype=float)
    along, across = np.ptp(corners, axis=0)
    width_m = bridge.deck.width_m
    skewed_m = bridge.length_m + width_m * np.tan(np.radians(60))
    assert along / across == pytest.approx(skewed_m / width_m, rel=0.01)
    assert len(drawn["outlines"]) == 1
    assert len(drawn["columns"]) == 2
    wall = np.array([point.split(",") for point in drawn["walls"][1].split()], dtype=float)
    scale = across / width_m
    gap_m = (wall[:, 0].min() - corners[corners[:, 0] > 260, 0].min()) / scale * np.cos(np.pi / 3)
    assert gap_m == pytest.approx(drawn["factor"] * 0.051, rel=0.05)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("osb1", "two spans, 91.4 m long, pinned two-column bent"),
        ("bridge_a", "single-column bent"),
    ],
)
def test_bridges_are_described_in_words_from_their_data(name, words):
    assert words in bridge_words(load_bridge(name))


def test_units_of_the_page_are_those_of_the_study(render):
    page, _ = render(synthetic_demands(skews=(0, 30)), config={"figures": {"units": "us"}})
    assert "gap 0.984 in, 2.01 in" in page
    assert "300.0 ft long" in page
    assert " mm" not in re.sub(r"<details><summary>(Methods|Provenance).*?</details>", "", page)


def test_tables_behind_the_main_one_have_words_and_their_medians(render):
    page, frames = render(synthetic_demands(skews=(0, 30), gaps=(25,)))
    system = frames["system"][frames["system"]["status"] == "ok"]
    assert len(system)
    for row in system.to_dict("records"):
        assert f"{row['theta']:.3g} [{row['theta_low']:.3g}, {row['theta_high']:.3g}]" in page
    for head in ("weakest component", "components independent"):
        assert head in page
    assert "theta correlated" not in page


def paragraph(page, name):
    return re.search(rf"<p><strong>{name}\.</strong> (.*?)</p>", page)[1]


def test_methods_of_the_page_are_those_of_the_study_and_its_motions(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    source = "BSD-3-Clause; synthetic: model of Dabaghi and Der Kiureghian (2018)"
    grid = {"skew_deg": [0, 60], "gap_mm": [25], "friction": [0.0, 0.5]}
    page, _ = render(demands, source=source, config={"grid": grid})
    assert "pinned column bases" in paragraph(page, "Bridges")
    assert "skew 0°, 60°; the joint gap 25 mm; friction 0, 0.5: four variants" in paragraph(
        page, "Abutments"
    )
    assert "simulated, Dabaghi and Der Kiureghian 2018" in paragraph(page, "Ground motions")
    assert "Dabaghi, M., Der Kiureghian, A. (2018)" in page
    assert "Houbolt" not in page
    assert "<code>column_drift_ratio</code>" in page
    assert "slight 1 %, moderate 2.5 %" in page


def test_methods_name_every_setting_that_is_not_the_default(render):
    demands = synthetic_demands(motions=3, skews=(30,), gaps=(25,), frictions=(50,))
    config = {
        "analysis": {"duration_s": 10.0},
        "motions": {"count": 3, "level_range_g": [0.1, 1.0]},
        "sensitivity": {"rows": 0},
    }
    page, _ = render(demands, config=config)
    settings = paragraph(page, "Settings")
    assert "<code>analysis.duration_s</code> 10 (default none)" in settings
    for key in ("motions.count", "motions.level_range_g", "sensitivity.rows"):
        assert f"<code>{key}</code>" in settings
    assert "<code>analysis.dt_s</code>" not in settings


def test_methods_take_the_range_of_intensities_from_the_motions():
    suite = pd.DataFrame(
        {"source": ["a"] * 2, "scale": [1.0, 2.0], "im_saavg_rotd50_g": [0.11, 0.4]}
    )
    text = methods_of(parse_config({"motions": {"count": 2}}), suite).parts["Ground motions"]
    assert "2 two-component ground motions" in text
    assert "spans 0.11 to 0.8 g" in text


def test_methods_name_all_bridges_abutments_and_choices(render):
    demands = synthetic_demands(motions=3, skews=(30,), gaps=(25,), frictions=(50,))
    config = {
        "grid": {"abutment": ["roller", "contact_friction"]},
        "analysis": {"scheme": "paper"},
        "motions": {"design": "ida"},
    }
    page, _ = render(demands, bridges=("osb1", "osb1_fixed"), config=config)
    assert "Two bridges were modelled" in paragraph(page, "Bridges")
    assert "fixed column bases" in paragraph(page, "Bridges")
    assert "modelled on rollers; as elastomeric pads" in paragraph(page, "Abutments")
    assert "Houbolt 1950" in paragraph(page, "Analyses")
    assert "jackknife over motions" in paragraph(page, "Statistics")
    assert "Houbolt, J. C." in page


def test_every_link_inside_the_page_leads_somewhere(render):
    page, _ = render(synthetic_demands(skews=(0, 30), gaps=(25,)))
    wanted = set(re.findall(r'href="#([^"]+)"', page))
    assert wanted <= set(re.findall(r'id="([^"]+)"', page))
    # addresses inside the vendored library are texts of its messages
    own = re.sub(r"<script.*?</script>", "", re.sub(r"data:image[^\"]+", "", page), flags=re.DOTALL)
    assert "http" not in own


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
        "and for unseating (slight) by 20 % (-24 to -16 %); friction changes no median capacity "
        "with certainty; the joint gap changes no median capacity by more than 5 %"
    )


def test_intensities_of_the_page_are_those_of_the_fits(render):
    demands = synthetic_demands(skews=(0, 30), gaps=(25,))
    page, frames = render(demands)
    assert set(frames["curves"]["im"]) == {IM}
    assert "Median θ of Sa,avg RotD50 (g)" in page


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
    caption = {"name": "one", "section": CURVES, "title": script, "text": script,
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
    page, _ = render(
        demands.assign(**{f"column_shear_dcr_{key}": each * ratio for key, each in factors.items()})
    )
    head = "Median capacity for shear failure of a column under three capacity models (4)"
    assert head in page
    table = page[page.index(head) :].split("</table>")[0]
    assert "SDC, nominal materials, θ [interval]" in table
    assert re.search(r"<td[^>]*>0 of \d+ runs fail", table)
    own, _ = render(demands)
    assert "three capacity models" not in own
