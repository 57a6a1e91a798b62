"""Configuration keys, JSON schemas and data dictionary, written from the code."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import yaml
from pydantic import TypeAdapter

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.bridge.catalogue.loading import bridge_schema
from skewbridge.demands.columns import COLUMNS
from skewbridge.fragility.limit_states import LimitStateEntry
from skewbridge.fragility.predict import CHECK_COLUMNS
from skewbridge.fragility.study_tables import DESCRIPTIONS, PAPER_TABLE
from skewbridge.study.config import StudyConfig
from skewbridge.study.modelling_choices import CHOICE_COLUMNS

ROOT: Final = Path(__file__).parents[3]

TABLES: Final = {
    **{
        f"fragility/{name}{'.csv' if name == PAPER_TABLE else ''}": columns
        for name, columns in DESCRIPTIONS.items()
    },
    "fragility/check_predict": CHECK_COLUMNS,
    "modelling_choices": CHOICE_COLUMNS,
}

CONFIG_HEAD: Final = """\
# Configuration

`config.yaml` is the default study; another file is merged over it:
`make study CONFIG=config/real.yaml`, or `snakemake -j2 --configfile config/real.yaml`.
`smoke.yaml` is the small study of the tests, `real.yaml` runs recorded motions, `full.yaml` a finer
grid; `stripes.yaml` scales every motion to every level and `ida.yaml` searches each motion's
capacity. An unknown key, a value outside its limits or a number read as text stops the study before
anything is computed. Keys end with the unit of their numbers. Write numbers with an exponent like
`2.0e+7`: YAML reads `2e7` as text.

What reruns: a new skew, gap, friction or motion runs only what is new; a limit state or a
statistical key reruns the fits and what follows; a key of `model` or `analysis`, a number of a
bridge or another version of OpenSees reruns the analyses. What counts is what the files say:
comments, notes beside the motions and the times of files rerun nothing, so a study can be copied.

Everything that a study writes lies in the folder `results:` (default `results`): give every study
that is to be kept a folder of its own.

- **An own bridge**: copy `bridges/template.yaml` to `bridges/NAME.yaml` and write `bridge: [NAME]`;
  or write the path of any file, whose name (without folder and ending) then names the bridge.
- **Own limit states**: copy `limit_states_template.yaml` and name the copy in
  `fragility.limit_states`.
- **Another axis**: any numeric key of `model` can stand under `grid:` with a list of values, for
  example `transverse_gap_mm: [6.4, 25.4]`; it then replaces the value under `model:`.
- **Skew, gap and friction** take any real number within their limits, with up to three decimals of
  a degree or millimetre and five of the friction coefficient. In the names of variants and files
  friction is in hundredths and `p` stands for the decimal point: 22.5 degrees, 25.4 mm and 0.375
  give `osb1_cf_skew22p5_gap025p4_mu037p5`; a negative skew is written `skewm22p5`.
- **Editors** that know `yaml-language-server` check keys and values while you write: each file
  names its schema in the first line.

This page and the schemas are written from the classes of the sections by `make docs`.
"""

COLUMNS_HEAD: Final = """\
# Data dictionary

## results/demands.parquet

One row per (variant, motion_id, scale, incidence_deg), sorted by that key. SI unless the name says
otherwise. Displacements are relative to the ground and counted from the state after gravity. The
metadata of the parquet fields has the same texts. A row whose status is not `ok` keeps the peaks up
to the time it reached; `complete` is true where every demand is the peak over the whole motion.

This page is written from the code (`src/skewbridge/demands/schema.py` and the fragility package) by
`make docs`.
"""


def config_page() -> str:
    """Return the key table of the configuration as Markdown."""
    schema = StudyConfig.model_json_schema()
    rows: list[tuple[str, ...]] = []
    for name, place in schema["properties"].items():
        told = _resolved(place, schema)
        keys = {f"{name}.{key}": field for key, field in told.get("properties", {}).items()}
        # an option that is an axis of a grid has no default there, and its row in `model`
        rows += [
            _key_row(key, field, schema)
            for key, field in (keys or {name: told}).items()
            if "default" in field
        ]
    return CONFIG_HEAD + "\n" + _table(("key", "default", "limits", "meaning"), rows)


def _key_row(key: str, field: Mapping[str, Any], schema: Mapping[str, Any]) -> tuple[str, ...]:
    default = yaml.safe_dump(field["default"], default_flow_style=True).split("\n")[0]
    return key, f"`{default}`", _limits(_resolved(field, schema)), field["description"]


def _resolved(field: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    return schema["$defs"][field["$ref"].rsplit("/", 1)[1]] if "$ref" in field else field


def _limits(field: Mapping[str, Any]) -> str:
    """Return what a value must be, in a few characters."""
    told = next(iter(field.get("anyOf", [field])))
    told = told.get("items", told)
    if "enum" in told:
        return ", ".join(str(choice) for choice in told["enum"])
    bounds = {
        "≥": told.get("minimum"),
        ">": told.get("exclusiveMinimum"),
        "≤": told.get("maximum"),
        "<": told.get("exclusiveMaximum"),
    }
    return ", ".join(f"{sign} {bound:g}" for sign, bound in bounds.items() if bound is not None)


def columns_page() -> str:
    """Return the data dictionary of the tables of results as Markdown."""
    rows = [(f"`{column.name}`", column.unit, column.description) for column in COLUMNS]
    page = COLUMNS_HEAD + "\n" + _table(("column", "unit", "meaning"), rows)
    for name, columns in TABLES.items():
        fits = [(f"`{column}`", meaning) for column, meaning in columns.items()]
        file = name if "." in name else f"{name}.parquet"
        page += f"\n## results/{file}\n\n" + _table(("column", "meaning"), fits)
    return page


def _schema(make: Callable[[], dict[str, Any]]) -> Callable[[], str]:
    return lambda: json.dumps(make(), indent=1) + "\n"


PAGES: Final[dict[str, Callable[[], str]]] = {
    "config/README.md": config_page,
    "config/schema.json": _schema(StudyConfig.model_json_schema),
    "config/bridge.schema.json": _schema(bridge_schema),
    "config/limit_states.schema.json": _schema(TypeAdapter(list[LimitStateEntry]).json_schema),
    "docs/columns.md": columns_page,
}


def write_pages(root: Path = ROOT) -> None:
    """Write all pages below a folder."""
    for name, page in PAGES.items():
        (root / name).write_text(page(), encoding="utf-8")


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [" | ".join(head), " | ".join("---" for _ in head)]
    lines += [" | ".join(cell.replace("|", "\\|") for cell in row) for row in rows]
    return "".join(f"| {line} |\n" for line in lines)


if __name__ == "__main__":
    hush_exit_message()
    write_pages()
