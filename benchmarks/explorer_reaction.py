"""Time from a change of a control of the explorer to its finished picture, in Chromium.

`python benchmarks/explorer_reaction.py results/report.html` measures the page of a study (after
`make test-browser`, which installs Playwright); `PYTHONPATH=tests python
benchmarks/explorer_reaction.py --variants 500` makes the page of a synthetic study first. Prints
the load of the machine, and per view and control the median and the largest of ten changes in ms.
"""

import argparse
import json
import os
import shutil
import statistics
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

CHANGES = 10
SKEWS, FRICTIONS_PCT = (0, 15, 30, 45, 60), (0, 20, 30, 40, 50)
#: View -> its controls, those of the address first.
VIEWS: dict[str, dict[str, str]] = {
    "curves": {},
    "cloud": {},
    "table": {},
    "forest": {"scope": "variant"},
    "grid": {"scope": "variant"},
}
#: A change counts until the browser has drawn the picture that follows it.
MEASURE = """async ([id, values]) => {
  const control = document.getElementById("ex-" + id), slider = control.type === "range";
  const drawn = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  const times = [];
  for (const value of values) {
    const before = performance.now();
    control.value = value;
    control.dispatchEvent(new Event(slider ? "input" : "change"));
    if (slider) await drawn();
    document.body.getBoundingClientRect();
    await drawn();
    times.push(performance.now() - before);
  }
  return times;
}"""
CHOICES = """(id) => [...document.getElementById("ex-" + id).options].map((each) => each.value)"""
USABLE = """(id) => {
  const control = document.getElementById("ex-" + id);
  return control.checkVisibility() && !control.disabled;
}"""


def measured(page_file: Path) -> list[dict[str, Any]]:
    """Return a row per view and control."""
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    rows: list[dict[str, Any]] = []
    with sync_playwright() as session:
        browser = session.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto(page_file.resolve().as_uri())
        page.wait_for_selector("#explorer", timeout=120_000)
        axes = page.eval_on_selector_all(
            "#explorer select", "all => all.map(each => each.id.slice(3))"
        )
        for view, chosen in VIEWS.items():
            for control, value in {"view": view, **chosen}.items():
                page.select_option(f"#ex-{control}", value)
            for control in [*axes, "margin", "threshold"]:
                if control == "view" or not page.evaluate(USABLE, control):
                    continue
                times = page.evaluate(MEASURE, [control, _values(page, control)])
                page.wait_for_timeout(100)
                rows.append(
                    {
                        "view": view,
                        "control": control,
                        "median_ms": round(statistics.median(times)),
                        "largest_ms": round(max(times)),
                    }
                )
                _put_back(page, control, view, chosen)
        browser.close()
    return rows


def _values(page: Any, control: str) -> list[str]:
    """Return ten values, each another than the one before."""
    if control == "margin":
        return [f"{0.3 * (i + 1):.1f}" for i in range(CHANGES)]
    if control == "threshold":
        return [str(90 * (i + 1)) for i in range(CHANGES)]
    options = page.evaluate(CHOICES, control)
    return [options[(i + 1) % len(options)] for i in range(CHANGES)]


def _put_back(page: Any, control: str, view: str, chosen: dict[str, str]) -> None:
    if control == "threshold":
        page.click("#ex-threshold-reset")
    elif control not in ("margin", "scope"):
        page.select_option(f"#ex-{control}", index=0)
    for name, value in {"view": view, **chosen}.items():
        page.select_option(f"#ex-{name}", value)


def synthetic_page(folder: Path, variants: int) -> Path:
    """Return the page of a study with made-up demands under 16 motions."""
    from fragility_tables import synthetic_demands
    from report_pages import write_page

    gaps = [20 + 5 * i for i in range(max(1, variants // (len(SKEWS) * len(FRICTIONS_PCT))))]
    demands = synthetic_demands(skews=SKEWS, gaps=gaps, frictions=FRICTIONS_PCT, motions=16)
    sys.stderr.write(f"{demands['variant'].nunique()} variants, {len(demands)} analyses\n")
    page, _ = write_page(folder, demands)
    return page


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=Path, nargs="?")
    parser.add_argument("--variants", type=int, default=500)
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        page = given.page or synthetic_page(Path(folder), given.variants)
        load = os.getloadavg()[0]
        found = {"page_mb": round(page.stat().st_size / 1e6, 1), "load_before": round(load, 1)}
        found |= {"rows": measured(page), "load_after": round(os.getloadavg()[0], 1)}
    sys.stdout.write(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
