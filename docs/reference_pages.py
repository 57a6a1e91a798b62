"""Configuration keys, JSON schemas and data dictionary, written from the code."""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import yaml
from pydantic import TypeAdapter

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.bridge.catalogue.loading import bridge_schema
from skewbridge.demands.columns import COLUMNS
from skewbridge.fragility.limit_states import LimitStateEntry
from skewbridge.fragility.study_tables import DESCRIPTIONS, PAPER_TABLE
from skewbridge.study.config import StudyConfig
from skewbridge.study.modelling_choices import CHOICE_COLUMNS
from skewbridge.study.predict_check import CHECK_COLUMNS

ROOT: Final = Path(__file__).parents[1]

#: A column with the ends of its interval, and its meaning.
type _Columns = tuple[tuple[str, ...], str]

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

| file | study |
| --- | --- |
| `smoke.yaml` | small study of the tests |
| `real.yaml` | recorded motions |
| `full.yaml` | finer grid |
| `stripes.yaml`, `ida.yaml` | every motion at every level; capacity of each motion |

An unknown key, a value outside its limits or a number read as text stops the study before anything
is computed. Keys end with the unit of their numbers. Write numbers with an exponent like `2.0e+7`:
YAML reads `2e7` as text. A study writes to `results:`, which is `results/NAME` for a file
`config/NAME.yaml` other than `config.yaml`.

A new skew, gap, friction or motion runs only what is new; a limit state or a statistical key reruns
fits and what follows; a key of `model` or `analysis`, a number of a bridge or another version of
OpenSees reruns the analyses. Comments and times of files rerun nothing.

- **Bridge**: `bridge: [NAME]` for `bridges/NAME.yaml` (copy `bridges/template.yaml`), or the path
  of a file.
- **Limit states**: name your copy of `limit_states_template.yaml` in `fragility.limit_states`.
- **Axis**: any numeric key of `model` can be under `grid:` with a list of values, for example
  `transverse_gap_mm: [6.4, 25.4]`.
- **Skew, gap and friction** are real numbers with up to three decimals of a degree or millimetre
  and five of the friction coefficient. In names of variants friction is in hundredths and `p` is
  the decimal point: 22.5 degrees, 25.4 mm and 0.375 give `osb1_cf_skew22p5_gap025p4_mu037p5`, a
  negative skew `skewm22p5`.
- **Editors** with `yaml-language-server` check keys and values by the schema in the first line.

`make docs` writes this page and the schemas.
"""

COLUMNS_HEAD: Final = """\
# Data dictionary

The metadata of the parquet fields has the same texts. `make docs` writes this page.

## results/demands.parquet

One row per (variant, motion_id, scale, incidence_deg), sorted by that key. SI unless the name says
otherwise. Displacements are relative to the ground and start from the state after gravity. A row
whose status is not `ok` keeps the peaks up to the time it reached.
"""

SHARED_HEAD: Final = """
## Tables of statistics

`x_low` and `x_high` are the ends of the interval of column `x`, `ci_low` and `ci_high` those of
`ratio`; 0 and infinity are unbounded ends. Columns with the same meaning in several tables:
"""


def config_page() -> str:
    """Return the key table of the configuration as Markdown."""
    schema = StudyConfig.model_json_schema()
    rows: list[tuple[str, ...]] = []
    for name, place in schema["properties"].items():
        details = _resolved(place, schema)
        keys = {f"{name}.{key}": field for key, field in details.get("properties", {}).items()}
        # an option that is an axis of a grid has no default there, and its row in `model`
        rows += [
            _key_row(key, field, schema)
            for key, field in (keys or {name: details}).items()
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
    details = next(iter(field.get("anyOf", [field])))
    details = details.get("items", details)
    if "enum" in details:
        return ", ".join(str(choice) for choice in details["enum"])
    bounds = {
        "≥": details.get("minimum"),
        ">": details.get("exclusiveMinimum"),
        "≤": details.get("maximum"),
        "<": details.get("exclusiveMaximum"),
    }
    return ", ".join(f"{sign} {bound:g}" for sign, bound in bounds.items() if bound is not None)


def columns_page() -> str:
    """Return the data dictionary of the tables of results as Markdown."""
    rows = [(f"`{column.name}`", column.unit, column.description) for column in COLUMNS]
    page = COLUMNS_HEAD + "\n" + _table(("column", "unit", "meaning"), rows)
    files: dict[tuple[_Columns, ...], list[str]] = {}
    for name, columns in TABLES.items():
        file = name if "." in name else f"{name}.parquet"
        files.setdefault(tuple(_with_ends(columns)), []).append(f"results/{file}")
    count = Counter(each for columns in files for each in columns)
    most = {
        names[0]: max(n for (a, _), n in count.items() if a[0] == names[0]) for names, _ in count
    }
    shared = [each for each, n in count.items() if n == most[each[0][0]] > 1]
    page += (
        SHARED_HEAD + "\n" + _table(("column", "meaning"), [_column_row(each) for each in shared])
    )
    for columns, names in files.items():
        also = ", ".join(f"`{name}`" for (name, *_), _ in (c for c in columns if c in shared))
        page += f"\n## {', '.join(names)}\n\n" + (f"Shared columns: {also}.\n\n" if also else "")
        rows = [_column_row(each) for each in columns if each not in shared]
        page += _table(("column", "meaning"), rows)
    return page


def _with_ends(columns: Mapping[str, str]) -> Iterator[_Columns]:
    """Yield each column of a table together with the ends of its interval."""
    for name, meaning in columns.items():
        base, _, end = name.rpartition("_")
        base = "ratio" if base == "ci" else base
        if base not in columns or end not in {"low", "high"}:
            stem = "ci" if name == "ratio" and "ci_low" in columns else name
            ends = [f"{stem}_{end}" for end in ("low", "high")]
            yield (name, *(each for each in ends if each in columns)), meaning


def _column_row(columns: _Columns) -> tuple[str, str]:
    names, meaning = columns
    return ", ".join(f"`{name}`" for name in names), meaning


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
