"""The page of a synthetic study, as the workflow makes it from the tables, and its numbers."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from matplotlib.image import imsave

from fragility_tables import DRIFT_ENTRY
from skewbridge.files.tables import write_frame
from skewbridge.files.text import merged
from skewbridge.fragility.limit_states import limit_states_of
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.fragility.study_tables import fragility_tables
from skewbridge.report.page import write_report
from skewbridge.report.study_figures import SECTIONS
from skewbridge.study.config import parse_config

STATES = [
    DRIFT_ENTRY,
    {
        "component": "bearing", "demand": "bearing_disp_m", "unit": "mm",
        "dispersion": 0.0, "citation": "a test", "states": {"slight": 100.0},
    },
]  # fmt: skip
_MORE = {
    "recovery_rung": 0, "energy_residual_ratio": 0.002, "cone_work_over_10pct_ratio": 0.03,
    "slip_work_kj": 1.0, "cpu_s": 3.0, "suspect": "",
}  # fmt: skip
_CHECKS = {
    "passed": True,
    "checks": [{"name": "rows twice", "value": 0.0, "limit": 0.0, "passed": True, "rows": []}],
    "suspect_rows": 0, "suspect": [], "rungs": [],
}  # fmt: skip
_CAPTION = {
    "name": "one", "section": SECTIONS[0], "item": "drift", "title": "A curve",
    "text": "Of a test.", "finding": "It rises.",
}  # fmt: skip
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?")


def write_page(
    folder: Path,
    demands: pd.DataFrame,
    *,
    states=STATES,
    bridges=("osb1",),
    captions=(_CAPTION,),
    source="",
    config=None,
    edit=dict,
) -> tuple[Path, dict[str, pd.DataFrame]]:
    """Make the tables of a study and its page in a folder; return the page and the tables. The
    function ``edit`` may return other tables than those of the study."""
    demands = demands.assign(**_MORE)
    if "beyond_model" not in demands:
        demands["beyond_model"] = ""
    found = fragility_tables(demands, limit_states_of(states), DEFAULTS)
    empty = pd.DataFrame({"demand": pd.Series(dtype=str)})
    frames = {"demands": demands, "medians": found["median_effects"]}
    names = "curves joint system effects intensity_effects needed_motions alternatives input_notes"
    frames |= {name: found[name] for name in (*names.split(), "suites", "shear_models")}
    frames |= dict.fromkeys(("contact_checks", "sensitivity"), empty)
    notes = {"motion_id": ["a", "a"], "messages": ["[]", '["spike?"]']}
    frames["suite"] = pd.DataFrame(notes | {"source": source})
    frames = edit(frames)
    paths = {name: folder / f"{name}.parquet" for name in frames}
    for name, frame in frames.items():
        write_frame(frame, paths[name], {"made_by": "a test"})
    paths["checks"] = folder / "checks.json"
    paths["checks"].write_text(json.dumps(_CHECKS))
    paths["captions"] = folder / "captions.json"
    paths["captions"].write_text(json.dumps({"figures": list(captions)}))
    for caption in captions:
        imsave(folder / f"{caption['name']}.png", np.full((600, 900, 3), 0.5))
    limits = folder / "states.yaml"
    limits.write_text(yaml.safe_dump(states, sort_keys=False), encoding="utf-8")
    fits = {"limit_states": str(limits)}
    given = merged({"grid": {"bridge": list(bridges)}, "fragility": fits}, config or {})
    page = folder / "page.html"
    write_report(tables=paths, figures=folder, study=parse_config(given), output=page)
    return page, frames | {"paper": found["table"]}


def assert_printed(text, values):
    """Check that a text prints these values in this order, each rounded to its last digit."""
    printed = NUMBER.findall(text)
    assert len(printed) == len(values), (text, values)
    for number, value in zip(printed, values, strict=True):
        mantissa, _, power = number.partition("e")
        last_digit = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
        assert abs(float(number) - value) <= 0.5001 * last_digit, (text, value)
        assert mantissa[0] not in "+-" or value * float(number) >= 0.0, (text, value)


def tables_of(page):
    """Return the rows of every named table of a page, as texts of cells without notes."""
    named = re.findall(r'aria-label="([^"]+)">\s*<table[^>]*>(.*?)</table>', page, re.DOTALL)
    return {
        name: [
            [re.sub(r"<sup>.*?</sup>|<svg.*?</svg>|<[^>]+>", " ", cell) for cell in cells]
            for row in re.findall(r"<tr[^>]*>(.*?)</tr>", table, re.DOTALL)
            for cells in [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, re.DOTALL)]
        ]
        for name, table in named
    }
