"""The page as a whole: widths, print, accessibility, without JavaScript."""

import pytest

pytestmark = pytest.mark.browser
VIEWS = ("curves", "cloud", "table", "forest", "grid")
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
def test_nothing_is_wider_than_the_screen(opened, width, view):
    page = opened(width, view=view, quantity="demand", cell=0)
    assert page.evaluate(TOO_WIDE) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("view", VIEWS)
def test_axe_finds_nothing(opened, width, view):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page = opened(width, view=view, quantity="demand", cell=0)
    page.evaluate(OPEN_DETAILS)
    found = axe.run(page)
    assert found.violations_count == 0, found.generate_report()


def test_print_cuts_nothing_off_and_leaves_the_explorer_out(opened):
    page = opened(A4_INSIDE_MARGINS_PX)
    page.evaluate(OPEN_DETAILS)
    page.emulate_media(media="print")
    assert page.evaluate(CUT_OFF) == []
    heights = page.eval_on_selector_all("tr", "all => all.map(row => row.clientHeight)")
    assert max(heights) < 120  # no column so narrow that a row fills the page
    assert not page.is_visible("#explore")
    # printing loads the pictures that the screen has not reached; its emulation does not
    page.eval_on_selector("#figure-1 img", "img => { img.loading = 'eager'; return img.decode(); }")
    assert page.is_visible("#figure-1 img")
    assert page.pdf(format="A4").startswith(b"%PDF")


def test_without_javascript_the_figures_stand_and_the_reason(browser, study):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(study.page.as_uri())
    assert "needs JavaScript" in page.inner_text("#explore")
    assert page.is_visible("#figure-1 img")
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
