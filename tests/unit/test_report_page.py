"""The page says of a study what its tables say: several studies, each with its own sentences."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.fragility.tables.all_tables import effect_tables, fit_tables
from skewbridge.fragility.tables.limit_states import limit_states_of
from skewbridge.provenance.tables import write_frame
from skewbridge.report.figure_cases import CURVES
from skewbridge.report.html.answer import title_of
from skewbridge.report.html.page import write_report

STATES = [
    {
        "component": "column_drift",
        "demand": "column_drift_ratio",
        "unit": "percent",
        "dispersion": 0.35,
        "citation": "a test",
        "states": {"slight": 1.0, "moderate": 2.5},
    },
    {
        "component": "bearing",
        "demand": "bearing_disp_m",
        "unit": "mm",
        "dispersion": 0.0,
        "citation": "a test",
        "states": {"slight": 100.0},
    },
]
BEYOND = [STATES[0] | {"states": {"complete": 900.0}}]
MORE = {
    "recovery_rung": 0,
    "energy_residual_ratio": 0.002,
    "cone_work_over_10pct_ratio": 0.03,
    "slip_work_kj": 1.0,
    "cpu_s": 3.0,
    "beyond_model": "",
    "suspect": "",
}
CHECKS = {
    "passed": True,
    "checks": [{"name": "rows twice", "value": 0.0, "limit": 0.0, "passed": True, "rows": []}],
    "suspect_rows": 0,
    "suspect": [],
    "rungs": [],
}


@pytest.fixture
def render(tmp_path):
    """Return a function that makes the tables of a study and its page, and gives page, tables."""

    def page_of(demands, *, states=STATES, bridges=("osb1",)):
        demands = demands.assign(**MORE)
        known = limit_states_of(states)
        columns = list(dict.fromkeys(state.demand for state in known))
        found = fit_tables(demands, known, DEFAULTS)
        found |= effect_tables(demands, DEFAULTS, columns)
        empty = pd.DataFrame({"demand": pd.Series(dtype=str)})
        frames = {
            "demands": demands,
            "curves": found["curves"],
            "medians": found["median_effects"],
            **{name: found[name] for name in ("joint", "system", "effects", "factors")},
            "needed_motions": found["needed_motions"],
            "measures": empty,
            "gate": empty,
            "sensitivity": empty,
        }
        paths = {name: tmp_path / f"{name}.parquet" for name in frames}
        for name, frame in frames.items():
            write_frame(frame, paths[name], {"made_by": "a test"})
        paths["checks"] = tmp_path / "checks.json"
        paths["checks"].write_text(json.dumps(CHECKS))
        paths["captions"] = tmp_path / "captions.json"
        caption = {"name": "one", "section": CURVES, "title": "A curve", "text": "Of a test."}
        paths["captions"].write_text(json.dumps({"figures": [caption]}))
        picture(tmp_path / "one.png")
        config = {"grid": {"bridge": list(bridges)}, "fragility": {"exclude_suspect": False}}
        write_report(tables=paths, figures=tmp_path, config=config, output=tmp_path / "page.html")
        return plain((tmp_path / "page.html").read_text("utf-8")), frames

    return page_of


def picture(path):
    from matplotlib.image import imsave

    imsave(path, np.full((8, 8, 3), 0.5))


def plain(page):
    page = re.sub(r"<style>.*?</style>", "", page, flags=re.S)
    return re.sub(r"\s+", " ", page)


def test_bases_axes_and_counts_are_those_of_the_study(render):
    demands = synthetic_demands(skews=(0, 60), gaps=(25,))
    page, frames = render(demands)
    assert "pinned column bases" in page
    assert "fixed column bases" not in page
    assert "skew 0°, 60° × gap 25 mm × friction 0, 0.5" in page
    assert f"{len(demands)} analyses: {len(demands)} ok" in page
    assert "median 3 %" in page  # friction above its limit, of the analyses that rub
    effects = frames["effects"]
    rows = effects[(effects["scope"] == "pooled") & (effects["demand"] == "unseating_m")]
    for row in rows.to_dict("records"):
        low, high = (100.0 * (row[name] - 1.0) for name in ("ci_low", "ci_high"))
        assert f"{low:+.1f} to {high:+.1f} %" in page or f"{low:+.0f} to {high:+.0f} %" in page


def test_both_bases_are_named_with_their_bridges(render):
    demands = pd.concat(
        [
            synthetic_demands(bridge=name, skews=(0, 30), gaps=(25,), seed=seed)
            for seed, name in enumerate(("osb1", "osb1_fixed"))
        ],
        ignore_index=True,
    )
    page, _ = render(demands, bridges=("osb1", "osb1_fixed"))
    assert "(<code>osb1</code>): pinned column bases" in page
    assert "(<code>osb1_fixed</code>): fixed column bases" in page
    assert "osb1_fixed, contact-friction:" in page


def test_mixed_abutments_have_maps_of_their_own(render):
    demands = pd.concat(
        [
            synthetic_demands(abutment="roller", gaps=(0,), frictions=(0,), skews=(0, 30)),
            synthetic_demands(gaps=(25,), skews=(0, 30)),
        ],
        ignore_index=True,
    )
    page, _ = render(demands, bridges=("osb1_fixed",))
    assert "Verdicts, osb1, roller" in page
    assert "Verdicts, osb1, contact-friction" in page
    assert "pinned column bases" not in page


def test_a_study_in_which_nothing_exceeds_has_no_median(render):
    page, _ = render(synthetic_demands(skews=(0, 30), gaps=(25,)), states=BEYOND)
    assert "No limit state has an estimate" in page
    assert "no exceedance" in page


def test_a_single_variant_and_motion_compare_nothing(render):
    demands = synthetic_demands(motions=1, skews=(30,), gaps=(25,), frictions=(50,))
    page, _ = render(demands)
    assert "This study compares nothing" in page
    assert "1 motion," in page
    assert 'id="answer"' not in page


def test_every_link_inside_the_page_leads_somewhere(render):
    page, _ = render(synthetic_demands(skews=(0, 30), gaps=(25,)))
    wanted = set(re.findall(r'href="#([^"]+)"', page))
    assert wanted <= set(re.findall(r'id="([^"]+)"', page))
    # addresses inside the vendored library are texts of its messages
    own = re.sub(r"<script.*?</script>", "", re.sub(r"data:image[^\"]+", "", page), flags=re.DOTALL)
    assert "http" not in own


def pooled_row(axis, demand, ratio, verdict, low, high):
    return {
        "bridge": "osb1", "abutment": "contact_friction", "axis": axis, "from_value": 0.0,
        "to_value": 0.5, "demand": demand, "ratio": ratio, "verdict": verdict, "margin": 0.05,
        "judged_by": "ratio", "n_motions": 16, "ci_low": low, "ci_high": high,
    }  # fmt: skip


def test_the_headline_says_what_the_verdicts_say():
    rows = [
        pooled_row("skew_deg", "unseating_m", 1.47, "higher", 1.3, 1.7),
        pooled_row("skew_deg", "column_shear_kn", 1.01, "negligible", 0.99, 1.02),
        pooled_row("gap_mm", "unseating_m", 1.01, "negligible", 0.99, 1.03),
        pooled_row("friction", "unseating_m", 0.95, "detectable", 0.92, 0.98),
    ]
    assert title_of(pd.DataFrame(rows)) == (
        "Skew raises unseating by 47 %; friction lowers unseating by 5.0 % (whether by over "
        "5 % is open); the joint gap changes none of the 2 headline demands by more than 5 %"
    )
    undecided = [pooled_row("friction", "unseating_m", 1.01, "undecided", 0.9, 1.2)]
    assert title_of(pd.DataFrame(undecided)) == (
        "Friction is not decided for unseating by 16 motions"
    )


def test_intensities_of_the_page_are_those_of_the_fits(render):
    demands = synthetic_demands(skews=(0, 30), gaps=(25,))
    page, frames = render(demands)
    assert set(frames["curves"]["im"]) == {IM}
    assert "Median θ of Sa,avg RotD50 (g)" in page
