"""Pages written from the code: the key table of the configuration and the data dictionary."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from skewbridge.demands.columns import COLUMNS
from skewbridge.fragility.tables.curve_rows import CURVE_COLUMNS
from skewbridge.fragility.tables.effects import EFFECT_COLUMNS
from skewbridge.fragility.tables.factors import SUMMARY_COLUMNS
from skewbridge.study.loading import key_table

ROOT: Final = Path(__file__).parents[3]

FIT_TABLES: Final = {
    "curves": CURVE_COLUMNS,
    "effects": EFFECT_COLUMNS,
    "factors": SUMMARY_COLUMNS,
}

CONFIG_HEAD: Final = """\
# Configuration

`config.yaml` is the default study; another file is merged over it:
`make study CONFIG=config/real.yaml`, or `snakemake -j2 --configfile config/real.yaml`.
`smoke.yaml` is the small study of the tests, `real.yaml` runs recorded motions, `full.yaml` a finer
grid; `stripes.yaml` scales every motion to every level and `ida.yaml` searches each motion's
capacity. An unknown key, a value outside its limits or a number read as text stops the study before
anything is computed. Write numbers with an exponent like `2.0e+7`: YAML reads `2e7` as text.

What reruns: a new skew, gap, friction or motion runs only what is new; a limit state or a
statistical key reruns the fits and what follows; a key of `model` or `analysis`, a number of a
bridge or another version of OpenSees reruns the analyses. What counts is what the files say:
comments, notes beside the motions and the times of files rerun nothing, so a study can be copied.

Everything that a study writes lies in the folder `results:` (default `results`): give every study
that is to be kept a folder of its own.

This page is written from the models in `src/skewbridge/study/config.py` by `make docs`.
"""

COLUMNS_HEAD: Final = """\
# Data dictionary

## results/demands.parquet

One row per (variant, motion_id, scale, incidence_deg), sorted by that key. SI unless the name says
otherwise. Displacements are relative to the ground and counted from the state after gravity. The
same texts stand in the metadata of the parquet fields. A row whose status is not `ok` keeps the
peaks up to the time it reached.

This page is written from the code (`src/skewbridge/demands/schema.py` and the fragility package) by
`make docs`.
"""


def config_page() -> str:
    """Return the key table of the configuration as Markdown."""
    rows = [(row["key"], f"`{row['default']}`", row["meaning"]) for row in key_table()]
    return CONFIG_HEAD + "\n" + _table(("key", "default", "meaning and unit"), rows)


def columns_page() -> str:
    """Return the data dictionary of the tables of results as Markdown."""
    rows = [(f"`{column.name}`", column.unit, column.description) for column in COLUMNS]
    page = COLUMNS_HEAD + "\n" + _table(("column", "unit", "meaning"), rows)
    for name, columns in FIT_TABLES.items():
        fits = [(f"`{column}`", meaning) for column, meaning in columns.items()]
        page += f"\n## results/fragility/{name}.parquet\n\n" + _table(("column", "meaning"), fits)
    return page


PAGES: Final = {"config/README.md": config_page, "docs/columns.md": columns_page}


def write_pages(root: Path = ROOT) -> None:
    """Write all pages below a folder."""
    for name, page in PAGES.items():
        (root / name).write_text(page(), encoding="utf-8")


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [" | ".join(head), " | ".join("---" for _ in head)]
    lines += [" | ".join(cell.replace("|", "\\|") for cell in row) for row in rows]
    return "".join(f"| {line} |\n" for line in lines)


if __name__ == "__main__":
    write_pages()
