"""The explorer of the page: numbers of the tables, and the effect of every control."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fragility_tables import IM
from skewbridge.demands.validity import is_complete
from skewbridge.fragility.effects import run_pairs
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.verdicts import judged
from skewbridge.report.appearance import change_text, interval_text, verdict_style
from skewbridge.report.fragility_figures import curve_values
from skewbridge.units import INCH

pytestmark = pytest.mark.browser
MODEL = "osb1_fixed, contact-friction"


def fits_of(study, component, state, method="preferred", bridge="osb1_fixed"):
    """Return the estimates of a state by variant."""
    curves = study.curves
    keep = (curves["component"] == component) & (curves["limit_state"] == state)
    keep &= (curves["bridge"] == bridge) & (curves["status"] == FITTED)
    keep &= curves["preferred"] if method == "preferred" else curves["method"] == method
    return curves[keep].set_index("variant")


def saved_by_variant(page, csv_of):
    return csv_of(page).drop_duplicates("variant").set_index("variant")


def effects_of(study, quantity="demand", scope="pooled"):
    effects = study.effects if quantity == "demand" else study.medians
    return effects[(effects["scope"] == scope) & (effects["bridge"] == "osb1_fixed")]


def test_curves_and_bands_are_those_of_python(opened, study, csv_of):
    page = opened(view="curves", model=MODEL, state="column_drift/moderate")
    saved = csv_of(page)
    fits = fits_of(study, "column_drift", "moderate")
    assert set(saved["variant"]) == set(fits.index)
    for name, own in saved.groupby("variant"):
        fit = fits.loc[name].to_dict()
        im = own["im"].to_numpy()
        expected = stats.norm.cdf(np.log(im / fit["theta"]) / fit["beta_total"])
        values, ends = curve_values(im, fit)
        saved_values = own[["probability", "probability", "low", "high"]].to_numpy().T
        np.testing.assert_allclose(saved_values, [expected, values, *ends], rtol=0, atol=1e-9)


def test_analyses_are_the_rows_of_the_demands_table(opened, study, csv_of):
    page = opened(view="cloud", model=MODEL, demand="unseating_m", skew_deg=60)
    saved = csv_of(page).set_index("run_key").sort_index()
    rows = study.demands
    rows = rows[(rows["bridge"] == "osb1_fixed") & (rows["skew_deg"] == 60)]
    rows = rows.set_index("run_key").sort_index()
    assert list(saved.index) == list(rows.index)
    for name in ("variant", "motion_id", "scale", "status", IM, "unseating_m"):
        assert saved[name].tolist() == rows[name].tolist()
    assert saved["complete"].astype(bool).tolist() == is_complete(rows).tolist()
    assert not saved["complete"].all()


def test_medians_are_those_of_the_fits_and_sort(opened, study, csv_of):
    page = opened(view="table", model=MODEL)
    names = ["variant", "component", "limit_state", "method", "theta", "beta_total", "n_exceed"]
    fits = study.curves[(study.curves["bridge"] == "osb1_fixed") & study.curves["preferred"]]
    saved, fits = (t[names].sort_values(names[:3], ignore_index=True) for t in (csv_of(page), fits))
    pd.testing.assert_frame_equal(saved, fits, check_dtype=False, rtol=0.0)
    page.click("[data-sort=theta]")
    assert page.locator("#ex-rows [aria-sort=ascending]").inner_text() == "θ ▲"
    page.keyboard.press("Enter")  # the focus stays on the head of the column
    assert csv_of(page)["theta"].is_monotonic_decreasing


@pytest.mark.parametrize("quantity", ["demand", "median_capacity"])
def test_cells_have_the_verdicts_of_the_tables_in_words(opened, study, csv_of, quantity):
    page = opened(view="grid", model=MODEL, quantity=quantity)
    cells = page.eval_on_selector_all(
        "#ex-rows .map button", "all => all.map(b => [b.parentElement.className, b.innerText])"
    )
    # demand by demand, changes in their first order
    by_demand = effects_of(study, quantity).groupby("demand", sort=False)
    rows = [row for _, part in by_demand for row in part.to_dict("records")]
    for cell, row in zip(cells, rows, strict=True):
        style = verdict_style(row)
        assert cell == [style.name, f"{style.sign} {change_text(row)}\n{interval_text(row)}"]
    page = opened(view="grid", scope="variant", model=MODEL, quantity=quantity)
    effects = effects_of(study, quantity, "variant")
    assert csv_of(page)["verdict"].tolist() == effects["verdict_family"].tolist()


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_verdicts_follow_the_margin(opened, study, csv_of, factor):
    page = opened(view="grid", scope="variant", model=MODEL, quantity="demand")
    before = csv_of(page)["verdict"]
    page.select_option("#ex-margin", f"{factor:g}")
    page.wait_for_function("value => location.hash.includes('margin=' + value)", arg=f"{factor:g}")
    saved = csv_of(page)
    margins = factor * study.effects[["margin", "difference_margin"]]
    effects = judged(study.effects.assign(**margins))
    effects = effects[(effects["scope"] == "variant") & (effects["bridge"] == "osb1_fixed")]
    assert saved["verdict"].tolist() == effects["verdict_family"].tolist()
    assert (saved["verdict"] != before).any()


def test_a_cell_opens_its_pairs(opened, study, csv_of):
    page = opened(view="grid", model=MODEL, quantity="demand")
    page.click("#ex-rows tr:has(th:text-is('Deck displacement')) button >> nth=1")
    assert page.inner_text("#ex-pairs-title").endswith("Skew 0° to 60°, all variants")
    saved = csv_of(page, "#ex-pairs-csv")
    rows = study.demands[study.demands["bridge"] == "osb1_fixed"]
    pairs = run_pairs(rows, "skew_deg", ["deck_disp_m", "run_key"])
    pairs = pairs[(pairs["to_value"] == 60) & (pairs["complete_to"] | pairs["complete_from"])]
    pairs = pairs.set_index("run_key_to").sort_index()
    saved = saved.set_index("to_run_key").sort_index()
    assert list(saved.index) == list(pairs.index)
    expected = np.log(pairs["deck_disp_m_to"] / pairs["deck_disp_m_from"])
    np.testing.assert_allclose(saved["change"], expected, rtol=0, atol=1e-12)
    assert (saved["bound"] == "at most").sum() == 0
    assert (saved["bound"].fillna("") == "at least").tolist() == (~pairs["complete_to"]).tolist()


def test_a_point_gives_the_command_that_repeats_its_analysis(opened, study):
    page = opened(view="cloud", skew_deg=0, gap_mm=25, friction=0)
    point = page.locator("#ex-plot .point >> nth=3")
    point.scroll_into_view_if_needed()
    box = point.bounding_box()
    centre = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*centre)
    page.mouse.click(*centre)
    key = page.inner_text("#ex-commands code").removeprefix("skewbridge run --row ")
    assert key in set(study.demands["run_key"])


def test_axes_model_state_and_method_choose_the_curves(opened, study, csv_of):
    page = opened(view="cloud")
    for name, value in (("skew_deg", "30"), ("gap_mm", "51"), ("friction", "0.5")):
        page.select_option(f"#ex-{name}", value)
    assert set(csv_of(page)["variant"]) == {"osb1_cf_skew30_gap051_mu050"}
    page.select_option("#ex-model", MODEL)
    assert set(csv_of(page)["variant"]) == {"osb1_fixed_cf_skew30_gap051_mu050"}
    page = opened(view="curves", state="bearing/slight")
    page.select_option("#ex-state", "column_drift/slight")
    note = page.inner_text("#ex-note")
    preferred = fits_of(study, "column_drift", "slight", bridge="osb1")
    differ = int(preferred["methods_differ"].sum())
    expected = f"differs from the cloud median in {differ} of {len(preferred)} curves"
    assert (expected in note) == (differ > 0)
    page.select_option("#ex-method", "exceedance")
    saved = saved_by_variant(page, csv_of)
    fits = fits_of(study, "column_drift", "slight", "exceedance", "osb1")
    assert saved["theta"].to_dict() == fits["theta"].to_dict()
    assert not page.is_visible("#ex-threshold")  # no log-log line to move a threshold on


def test_the_threshold_moves_the_median_within_what_was_reached(opened, study, csv_of):
    page = opened(view="curves", state="column_drift/slight", method="cloud", skew_deg=60)
    assert "(the limit state)" in page.inner_text("#ex-threshold-text")
    page.focus("#ex-threshold")
    page.keyboard.press("End")
    page.wait_for_function("location.hash.includes('threshold=1000')")
    saved = saved_by_variant(page, csv_of)
    rows = study.demands
    rows = rows[(rows["bridge"] == "osb1") & (rows["skew_deg"] == 60)]
    largest = rows.loc[is_complete(rows), "column_drift_ratio"].max()
    fits = fits_of(study, "column_drift", "slight", "cloud", "osb1").loc[saved.index]
    expected = np.exp((np.log(largest) - fits["ln_a"]) / fits["b"])
    np.testing.assert_allclose(saved["theta"], expected, rtol=1e-9)
    assert saved["low"].isna().all()
    page.click("#ex-threshold-reset")
    assert set(csv_of(page)["theta"]) == set(fits["theta"])


def test_units_change_the_numbers_and_the_labels(opened, study):
    page = opened(view="cloud", demand="unseating_m", skew_deg=0, gap_mm=25, friction=0)
    read = "document.getElementById('ex-plot').data[0].y"
    si = np.array(page.evaluate(read))
    page.select_option("#ex-units", "us")
    np.testing.assert_allclose(page.evaluate(read), si / INCH)
    assert "Unseating (in)" in page.inner_text("#ex-plot")


def test_legend_hides_a_curve_and_few_curves_have_bands(opened):
    page = opened(view="curves", skew_deg=0, gap_mm=25)
    names = "document.getElementById('ex-plot').data.map(trace => trace.name).filter(Boolean)"
    assert page.evaluate(names) == ["skew 0°, gap 25 mm, μ 0", "skew 0°, gap 25 mm, μ 0.5"]
    assert page.evaluate("document.getElementById('ex-plot').data.length") == 6
    page.click("#ex-legend button >> nth=0")
    assert page.evaluate(names) == ["skew 0°, gap 25 mm, μ 0.5"]
    assert "off=" in page.url
    page.reload()
    page.wait_for_selector("#ex-legend button")
    assert page.get_attribute("#ex-legend button >> nth=0", "aria-pressed") == "false"
    page.select_option("#ex-skew_deg", "all")
    page.select_option("#ex-gap_mm", "all")
    assert "Bands are drawn for at most 2 curves" in page.inner_text("#ex-note")


def test_the_forest_draws_the_chosen_change(opened, study, csv_of):
    page = opened(view="forest", model=MODEL, quantity="demand")
    page.select_option("#ex-change", "Skew 0° to 30°")
    saved = csv_of(page)
    rows = effects_of(study)
    rows = rows[(rows["axis"] == "skew_deg") & (rows["to_value"] == 30)]
    assert saved["demand"].tolist() == rows["demand"].tolist()
    page.select_option("#ex-scope", "variant")
    page.select_option("#ex-demand", "deck_rotation_rad")
    page.select_option("#ex-friction", "0.5")
    saved = csv_of(page)
    assert set(saved["demand"]) == {"deck_rotation_rad"}
    assert saved[["gap_mm", "friction"]].to_numpy().tolist() == [[25, 0.5], [51, 0.5]]


def test_the_address_keeps_what_was_chosen(opened):
    page = opened()
    chosen = {"view": "grid", "model": MODEL, "quantity": "demand", "scope": "variant"}
    for name, value in (chosen | {"friction": "0"}).items():
        page.select_option(f"#ex-{name}", value)
    page.click("#ex-rows .map button >> nth=5")
    address, shown = page.url, page.inner_text("#explorer")
    again = opened()
    again.goto("about:blank")
    again.goto(address)
    again.wait_for_selector("#explorer")
    assert again.inner_text("#explorer") == shown
    assert again.is_visible("#ex-pairs")


def test_an_address_with_unknown_choices_shows_the_first(opened):
    page = opened(view="nothing", state="<img src=x onerror=alert(1)>", margin="x", cell="-1")
    assert page.input_value("#ex-view") == "curves"
    assert page.is_visible("#ex-plot svg >> nth=0")
