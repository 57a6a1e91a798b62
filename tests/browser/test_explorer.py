"""The explorer of the page: numbers of the tables, and the effect of every control."""

import numpy as np
import pytest
from scipy import stats

from fragility_tables import IM
from skewbridge.demands.validity import is_complete
from skewbridge.fragility.fits import FITTED
from skewbridge.report.fragility_figures import curve_values

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
        np.testing.assert_allclose(saved_values, [expected, values, *ends], rtol=0, atol=6e-5)


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
    expected = f"differs from the cloud median in {differ} of {len(preferred)} curves."
    assert (expected in note) == (differ > 0)
    page.select_option("#ex-method", "exceedance")
    saved = saved_by_variant(page, csv_of)
    fits = fits_of(study, "column_drift", "slight", "exceedance", "osb1")
    assert saved["theta"].to_dict() == fits["theta"].to_dict()


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


def test_the_address_keeps_what_was_chosen(opened):
    page = opened()
    for name, value in {"view": "cloud", "model": MODEL, "friction": "0"}.items():
        page.select_option(f"#ex-{name}", value)
    address, shown = page.url, page.inner_text("#explorer")
    again = opened()
    again.goto("about:blank")
    again.goto(address)
    again.wait_for_selector("#explorer")
    assert again.inner_text("#explorer") == shown


def test_an_address_with_unknown_choices_shows_the_first(opened):
    page = opened(view="nothing", state="<img src=x onerror=alert(1)>")
    assert page.input_value("#ex-view") == "curves"
    assert page.is_visible("#ex-plot svg >> nth=0")
