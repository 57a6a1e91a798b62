"""The page as a whole (widths, print, accessibility, without JavaScript) and its explorer."""

import numpy as np
import pytest
from scipy import stats

from cli_json import invoke
from fragility_tables import IM
from skewbridge.demands.validity import is_complete
from skewbridge.fragility.fits import FITTED
from skewbridge.report.fragility_figures import curve_values
from skewbridge.report.study_figures import SECTIONS

pytestmark = pytest.mark.browser
_, CURVES, CLOUDS, *_, MOTIONS = SECTIONS
VIEWS = ("curves", "cloud")
TOO_WIDE = """() => [...document.querySelectorAll("body *")]
    .filter((each) => !each.closest(".wide") && each.getClientRects().length)
    .filter((each) => each.getBoundingClientRect().right > innerWidth + 1)
    .map((each) => each.outerHTML.slice(0, 120))"""
CUT_OFF = """() => [...document.querySelectorAll("body *")]
    .filter((each) => each.checkVisibility() && !each.closest("svg") && !each.matches(".unseen"))
    .filter((each) => each.getBoundingClientRect().right > innerWidth + 1
        || (["auto", "scroll", "hidden"].includes(getComputedStyle(each).overflowX)
            && each.scrollWidth > each.clientWidth + 1)
        || (["auto", "scroll", "hidden"].includes(getComputedStyle(each).overflowY)
            && each.scrollHeight > each.clientHeight + 1))
    .map((each) => each.outerHTML.slice(0, 120))"""
OPEN_DETAILS = "document.querySelectorAll('details').forEach((each) => { each.open = true; })"
A4_INSIDE_MARGINS_PX = round((210 - 2 * 14) / 25.4 * 96)
SHOWN = "all => all.filter(each => each.checkVisibility()).map(each => each.id)"


@pytest.mark.parametrize("view", [*VIEWS, "demo"])
def test_nothing_is_wider_than_the_screen_and_axe_finds_nothing(opened, width, view, tmp_path):
    if view == "demo":
        result = invoke("demo", "--out", tmp_path)
        assert result.exit_code == 0, result.output
        page = opened(width, file=tmp_path / "report.html")
    else:
        page = opened(width, view=view)
    assert page.evaluate(TOO_WIDE) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page.evaluate(OPEN_DETAILS)
    found = axe.run(page)
    assert found.violations_count == 0, found.generate_report()


def test_print_cuts_nothing_off_and_leaves_the_explorer_out(opened):
    page = opened(A4_INSIDE_MARGINS_PX)
    page.evaluate(OPEN_DETAILS)
    page.emulate_media(media="print")
    assert page.evaluate(CUT_OFF) == []
    assert not page.is_visible("#explore")
    # printing loads the pictures that the screen has not reached; its emulation does not
    page.eval_on_selector("#figure-f0 img",
                          "img => { img.loading = 'eager'; return img.decode(); }")  # fmt: skip
    assert page.is_visible("#figure-f0 img")
    assert page.pdf(format="A4").startswith(b"%PDF")


def test_without_javascript_figures_and_the_reason_are_shown(browser, study):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(study.page.as_uri())
    assert "needs JavaScript" in page.inner_text("#explore")
    assert page.is_visible("#figure-f0 img")
    assert not page.is_visible("#explorer")
    context.close()


def test_the_keyboard_reaches_the_skip_link_and_the_controls(opened):
    page = opened()
    page.goto(page.url.partition("#")[0])  # an address of the explorer starts the focus there
    page.wait_for_selector("#explorer")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.focus("#ex-view")
    page.keyboard.press("ArrowDown")
    assert page.input_value("#ex-view") == "cloud"
    assert page.is_visible("#ex-demand")


def shown_figures(page):
    return page.eval_on_selector_all("#figures figure:not([hidden])", SHOWN)


def test_the_gallery_shows_one_figure_by_bridge_quantity_and_component(opened):
    page = opened()
    page.goto(page.url.partition("#")[0])
    assert shown_figures(page) == ["figure-f0"]
    for control, value, figure in (
        ("item", "bearing", "f1"), ("model", "osb1_fixed, contact-friction", "f4"),
        ("section", CLOUDS, "f5"), ("section", MOTIONS, "f6"),
    ):  # fmt: skip
        page.select_option(f"#gallery-{control}", value)
        assert shown_figures(page) == [f"figure-{figure}"]
        assert page.is_disabled("#gallery-item") == (control == "section")
    page.click("#gallery-next")
    assert shown_figures(page) == ["figure-f0"]
    # the address and the search of the browser open a figure
    page.goto(page.url.partition("#")[0] + "#figure-f5")
    page.reload()
    page.wait_for_selector("#explorer")
    assert shown_figures(page) == ["figure-f5"]
    page.evaluate("document.getElementById('figure-f1').dispatchEvent(new Event('beforematch'))")
    assert shown_figures(page) == ["figure-f1"]


MODEL = "osb1_fixed, contact-friction"


def fits_of(study, component, state, method="preferred", bridge="osb1_fixed"):
    curves = study.curves
    keep = (curves["component"] == component) & (curves["limit_state"] == state)
    keep &= (curves["bridge"] == bridge) & (curves["status"] == FITTED)
    keep &= curves["preferred"] if method == "preferred" else curves["method"] == method
    return curves[keep].set_index("variant")


def test_curves_and_bands_are_those_of_python(opened, study, csv_of):
    saved = csv_of(opened(view="curves", model=MODEL, state="column_drift/moderate"))
    fits = fits_of(study, "column_drift", "moderate")
    assert set(saved["variant"]) == set(fits.index)
    for name, own in saved.groupby("variant"):
        fit, im = fits.loc[name].to_dict(), own["im"].to_numpy()
        expected = stats.norm.cdf(np.log(im / fit["theta"]) / fit["beta_total"])
        values, ends = curve_values(im, fit)
        saved_values = own[["probability", "probability", "low", "high"]].to_numpy().T
        np.testing.assert_allclose(saved_values, [expected, values, *ends], rtol=0, atol=6e-5)


def test_analyses_are_rows_of_the_demands_and_a_point_gives_its_command(opened, study, csv_of):
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
    saved = csv_of(page).drop_duplicates("variant").set_index("variant")
    fits = fits_of(study, "column_drift", "slight", "exceedance", "osb1")
    assert saved["theta"].to_dict() == fits["theta"].to_dict()


def test_the_address_keeps_what_was_chosen_and_shows_the_first_for_unknown_choices(opened):
    page = opened()
    for name, value in {"view": "cloud", "model": MODEL, "friction": "0"}.items():
        page.select_option(f"#ex-{name}", value)
    address, shown = page.url, page.inner_text("#explorer")
    again = opened()
    again.goto("about:blank")
    again.goto(address)
    again.wait_for_selector("#explorer")
    assert again.inner_text("#explorer") == shown
    page = opened(view="nothing", state="<img src=x onerror=alert(1)>")
    assert page.input_value("#ex-view") == "curves"
    assert page.is_visible("#ex-plot svg >> nth=0")
