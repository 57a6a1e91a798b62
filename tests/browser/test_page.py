"""The page as a whole: widths, print, accessibility, without JavaScript."""

import pytest
from typer.testing import CliRunner

from skewbridge.cli import build_app
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


@pytest.mark.parametrize("view", VIEWS)
def test_nothing_is_wider_than_the_screen_and_axe_finds_nothing(opened, width, view):
    page = opened(width, view=view)
    assert page.evaluate(TOO_WIDE) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page.evaluate(OPEN_DETAILS)
    found = axe.run(page)
    assert found.violations_count == 0, found.generate_report()


def test_the_demo_fits_the_screen_and_its_gallery_opens(opened, width, tmp_path):
    result = CliRunner().invoke(build_app(), ["demo", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    file = tmp_path / "report.html"
    assert file.stat().st_size < 4e6
    page = opened(width, file=file)
    assert page.evaluate(TOO_WIDE) == []
    page.click("text=Figures")
    assert page.locator("#figures figure:visible").count() == 1
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    assert axe.run(page).violations_count == 0


def test_print_cuts_nothing_off_and_leaves_the_explorer_out(opened):
    page = opened(A4_INSIDE_MARGINS_PX)
    page.evaluate(OPEN_DETAILS)
    page.emulate_media(media="print")
    assert page.evaluate(CUT_OFF) == []
    heights = page.eval_on_selector_all("tr", "all => all.map(row => row.clientHeight)")
    assert max(heights) < 120  # no column so narrow that a row fills the page
    assert not page.is_visible("#explore")
    # printing loads the pictures that the screen has not reached; its emulation does not
    page.eval_on_selector(
        "#figure-f0 img", "img => { img.loading = 'eager'; return img.decode(); }"
    )
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


SHOWN = "all => all.filter(each => each.checkVisibility()).map(each => each.id)"


def shown_figures(page):
    """Return the figures of the gallery that are shown; hidden ones are found by search only."""
    return page.eval_on_selector_all("#figures figure:not([hidden])", SHOWN)


def test_the_page_is_short_and_its_first_screen_has_the_answer(opened):
    page = opened(1400, height=1000)
    assert page.evaluate("document.documentElement.scrollHeight") <= 12 * 1000
    assert page.evaluate("document.body.innerText.split(/\\s+/).length") <= 4000
    page.goto(page.url.partition("#")[0])
    for place in (".plan", ".answer", ".failures", "#figure-main_column_failure img", ".facts h3"):
        box = page.locator(place).first.bounding_box()
        assert box["y"] + min(box["height"], 400) < 1000
    facts = page.locator(".facts").bounding_box()
    assert facts["y"] + facts["height"] <= 1000
    assert "Columns failed in" in page.inner_text(".failures")


def test_navigation_stays_visible_and_every_entry_leads_to_its_section(opened, width):
    page = opened(width)
    for link in page.query_selector_all("nav a"):
        if not link.is_visible():
            continue
        link.evaluate("link => link.click()")
        page.wait_for_timeout(100)
        assert page.locator("nav").bounding_box()["y"] == pytest.approx(0, abs=1)
        target = link.get_attribute("href")
        assert page.locator(target).count() == 1


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
    assert page.input_value("#gallery-section") == CURVES
    # the address and the search of the browser open a figure
    page.goto(page.url.partition("#")[0] + "#figure-f5")
    page.reload()
    page.wait_for_selector("#explorer")
    assert shown_figures(page) == ["figure-f5"]
    page.evaluate("document.getElementById('figure-f1').dispatchEvent(new Event('beforematch'))")
    assert shown_figures(page) == ["figure-f1"]
    assert page.get_attribute("#figure-f5", "hidden") == "until-found"


def test_curves_and_their_table_come_before_effects_and_gallery(opened):
    page = opened(1400)
    order = page.eval_on_selector_all("section", "all => all.map(each => each.id)")
    wanted = ["answer", "curves", "effects", "figures", "explore", "table", "quality", "methods"]
    assert [name for name in order if name in wanted] == wanted
    table = page.locator("[aria-label='Leading curves'] table")
    assert table.is_visible()
    heads = table.locator("thead th").all_inner_texts()
    assert heads[:4] == ["value", "θ [interval] (g)", "β", "β total"]
    assert page.is_visible("#curves #figure-main_whole_bridge img")


def test_a_control_with_one_value_says_why(opened):
    page = opened()
    silent = page.eval_on_selector_all(
        "#explorer select:disabled", "all => all.filter(each => !each.title).map(e => e.id)"
    )
    assert silent == []
    assert page.is_enabled("#ex-skew_deg")
