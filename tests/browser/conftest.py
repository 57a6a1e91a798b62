"""A page of two synthetic bridges in a real browser; skipped where there is none."""

import shutil
from types import SimpleNamespace
from urllib.parse import urlencode

import pandas as pd
import pytest

from fragility_tables import synthetic_demands
from report_pages import write_page
from skewbridge.report.study_figures import SECTIONS

MAIN, CURVES, CLOUDS, *_, MOTIONS = SECTIONS
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="session")
def browser():
    reason = "Playwright is not installed: make test-browser"
    playwright = pytest.importorskip("playwright.sync_api", reason=reason)
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed: apt-get install chromium")
    with playwright.sync_playwright() as session:
        # a container's root has no sandbox
        chromium = session.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield chromium
        chromium.close()


#: Figures of the gallery: bridge, quantity and component.
FIGURES = [
    *((f"{bridge}, contact-friction", section, item) for bridge in ("osb1", "osb1_fixed")
      for section, item in ((CURVES, "drift"), (CURVES, "bearing"), (CLOUDS, "unseating"))),
    ("", MOTIONS, "response spectra"),
]  # fmt: skip
CAPTIONS = [
    {
        "name": f"f{number}", "model": model, "section": section, "item": item,
        "title": f"{model}: {section} of {item}", "text": "Of a test.", "finding": "It rises.",
    }
    for number, (model, section, item) in enumerate(FIGURES)
]  # fmt: skip


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    """Page and tables of two bridges; in some runs a column failed beyond the model."""
    runs = (synthetic_demands(bridge=name, skews=(0, 30, 60), seed=seed, run_scatter=0.05)
            for seed, name in enumerate(("osb1", "osb1_fixed")))  # fmt: skip
    demands = pd.concat(runs, ignore_index=True)
    beyond = (demands["motion_id"] == "m15") & (demands["skew_deg"] == 60)
    demands["beyond_model"] = beyond.map({True: "shear", False: ""})
    given = {"bridges": ("osb1", "osb1_fixed"), "captions": CAPTIONS}
    page, frames = write_page(tmp_path_factory.mktemp("page"), demands, **given)
    return SimpleNamespace(page=page, **frames)


@pytest.fixture(params=[1280, 390])
def width(request):
    return request.param


@pytest.fixture
def opened(browser, study):
    """Return a function that opens the page, and fails the test on an error or a request."""
    contexts, messages = [], []

    def open_page(width=1280, *, height=900, file=study.page, **chosen):
        context = browser.new_context(viewport={"width": width, "height": height})
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: messages.append(message.text))
        page.on("pageerror", lambda error: messages.append(str(error)))
        page.on("request", lambda request: messages.append(request.url) if away(request) else None)
        page.goto(f"{file.as_uri()}#explorer?{urlencode(chosen)}")
        page.wait_for_selector("#explorer")  # it unpacks its data first
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not messages


def away(request):
    return not request.url.startswith(("data:", "blob:", "file:"))


@pytest.fixture
def csv_of(tmp_path):
    """Return a function that reads what a button of the page saves."""

    def read(page, button="#ex-csv"):
        with page.expect_download() as download:
            page.click(button)
        path = tmp_path / "saved.csv"
        download.value.save_as(path)
        return pd.read_csv(path, keep_default_na=False, na_values=[""])

    return read
