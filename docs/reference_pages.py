"""Configuration keys, JSON schemas and data dictionary, generated from the code.

`make docs` writes the keys and schemas, which are in the repository. `docs/conf.py` writes the data
dictionary when it builds the site.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, Final

import yaml
from pydantic import TypeAdapter

from skewbridge.bridge.catalogue import bridge_schema
from skewbridge.demands.columns import COLUMNS
from skewbridge.fragility.limit_states import LimitStateEntry
from skewbridge.fragility.study_tables import DESCRIPTIONS, PAPER_TABLE
from skewbridge.fragility.verdicts import ROUND_COLUMNS
from skewbridge.study.config import StudyConfig
from skewbridge.study.modelling_choices import CHOICE_COLUMNS
from skewbridge.study.processes import hush_exit_message

ROOT: Final = Path(__file__).parents[1]

#: Names of a column and of the ends of its interval, and the meaning of the column.
type _Columns = tuple[tuple[str, ...], str]

TABLES: Final = {
    **{
        f"fragility/{name}{'.csv' if name == PAPER_TABLE else ''}": columns
        for name, columns in DESCRIPTIONS.items()
    },
    "rounds": ROUND_COLUMNS,
    "modelling_choices": CHOICE_COLUMNS,
}

CONFIG_HEAD: Final = """\
# Configuration

`config.yaml` is the default study. Another file overrides keys: `make study
CONFIG=config/real.yaml`, or `snakemake -j2 --configfile config/real.yaml`. Results of
`config/NAME.yaml` go to `results/NAME`.

| file | study |
|---|---|
| `smoke.yaml`, `demo.yaml` | small studies for tests and `skewbridge demo` |
| `real.yaml` | recorded motions of a folder |
| `full.yaml` | finer grid |
| `stripes.yaml`, `ida.yaml` | every motion at every level; incremental dynamic analysis |
| `suites.yaml` | osb1 under four suites of motions |
| `alternatives.yaml` | the default study with alternative modelling options |

An unknown key or a value outside its limits stops the study before any analysis; editors with
`yaml-language-server` check both. Write `2.0e+7`; YAML reads `2e7` as text.

A new value of an axis or motion runs only its own analyses. A changed limit state or statistical
key reruns fits, figures and report; a changed key of `model` or `analysis`, or bridge file, all
analyses.

How to change [bridges](../docs/howto/bridge.md), [limit states](../docs/howto/limit_state.md),
[axes](../docs/howto/axis.md).

Names of variants have friction in hundredths and `p` as the decimal point: 22.5 degrees, 25.4 mm
and 0.375 give `osb1_cf_skew22p5_gap025p4_mu037p5`, -22.5 degrees `skewm22p5`.

Keys have their built-in default, which `config.yaml` overrides for `uncertainty.enabled` and keys
of `motions`, followed by other choices or limits.
"""

COLUMNS_HEAD: Final = """\
# Data dictionary

The metadata of the parquet fields contains the same descriptions.

## results/demands.parquet

One row per (variant, motion_id, scale, incidence_deg), sorted by that key. SI units unless the name
includes another. Displacements are relative to the ground and to the state after gravity. If the
status of a row is not `ok`, its demands are the peaks up to `time_reached_s`.
"""

SHARED_HEAD: Final = """
## Tables of statistics

`x[_low|_high]` are `x` and the ends of its interval; 0 and infinity mark unbounded ends. Shared
columns have the following meanings, or the meanings in `demands.parquet`:
"""


def config_page() -> str:
    """Return the page of configuration keys as Markdown, with one list per section."""
    schema = StudyConfig.model_json_schema()
    page, single = CONFIG_HEAD, dict[str, Mapping[str, Any]]()
    for name, field in schema["properties"].items():
        details = _resolved(field, schema)
        keys = dict(details.get("properties", {}))
        for key in list(keys):  # a section in a section
            parts = [_resolved(part, schema) for part in keys[key].get("anyOf", ())]
            own = next((part["properties"] for part in parts if "properties" in part), {})
            if all("default" in value for value in own.values()):
                keys |= {f"{key}.{name}": value for name, value in own.items()}
        if keys:
            page += f"\n## {name}\n\n{_key_list(keys, schema)}"
        elif "default" in details:
            single[name] = details
    return page + "\n## Keys without a section\n\n" + _key_list(single, schema)


def _key_list(keys: Mapping[str, Mapping[str, Any]], schema: Mapping[str, Any]) -> str:
    """Return the keys as a Markdown list; neighbours with similar descriptions share one item."""
    return "".join(
        f"- {', '.join(_key(key, keys[key], schema) for key in item)}: {text}\n"
        for item, text in _items([(key, field["description"]) for key, field in keys.items()])
    )


def _key(key: str, field: Mapping[str, Any], schema: Mapping[str, Any]) -> str:
    """Return the Markdown of a key with its default value, then its other choices or limits."""
    value = field["default"]
    if isinstance(value, Mapping) and "distribution" in value:  # a random property
        default = f"{value['distribution']} {value['low']:g} to {value['high']:g}"
    else:
        default = yaml.safe_dump(value, default_flow_style=True).split("\n")[0]
    limits = _limits(_resolved(field, schema))
    choices = limits.split("|")
    if default in choices:
        return f"`{key}: {'|'.join(sorted(choices, key=lambda choice: choice != default))}`"
    return f"`{key}: {default}`{limits and f' ({limits})'}"


def _resolved(field: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    named = schema["$defs"][field["$ref"].rsplit("/", 1)[1]] if "$ref" in field else {}
    return {**named, **field}


def _limits(field: Mapping[str, Any]) -> str:
    """Return a short text of the choices or limits of a value, or an empty text."""
    details = next(iter(field.get("anyOf", [field])))
    details = details.get("items", details)
    if "enum" in details:
        return "|".join(str(choice) for choice in details["enum"])
    low, above = details.get("minimum"), details.get("exclusiveMinimum")
    high, below = details.get("maximum"), details.get("exclusiveMaximum")
    if low is not None and high is not None:
        return "" if high > 1000 * (low or 1) else f"{low:g} to {high:g}"
    bounds = {"≥": low, ">": above, "≤": high, "<": below}
    return ", ".join(f"{sign} {bound:g}" for sign, bound in bounds.items() if bound is not None)


def columns_page() -> str:
    """Return the data dictionary of the result tables as Markdown."""
    rows: list[_Columns] = [
        ((column.name,), column.description + (f" ({column.unit})" if column.unit != "-" else ""))
        for column in COLUMNS
    ]
    page = COLUMNS_HEAD + "\n" + _column_list(rows)
    files: dict[tuple[_Columns, ...], list[str]] = {}
    for name, columns in TABLES.items():
        file = name if "." in name else f"{name}.parquet"
        files.setdefault(tuple(_with_ends(columns)), []).append(f"results/{file}")
    count = Counter(each for columns in files for each in columns)
    most = {
        names[0]: max(n for (a, _), n in count.items() if a[0] == names[0]) for names, _ in count
    }
    shared = [each for each, n in count.items() if n == most[each[0][0]] > 1]
    page += SHARED_HEAD + "\n" + _column_list(shared)
    described = {column.name: column.description for column in COLUMNS}
    for columns, names in files.items():
        usual = [
            (name, meaning)
            for name, meaning in columns
            if (name, meaning) in shared or meaning.startswith(described.get(name[0], "\n"))
        ]
        page += f"\n## {', '.join(names)}\n\n"
        page += f"- shared: {', '.join(_names(each) for each in usual)}\n" if usual else ""
        page += _column_list([each for each in columns if each not in usual])
    return page


def _names(column: _Columns) -> str:
    """Return the Markdown names of a column and the ends of its interval."""
    name, *ends = column[0]
    if ends == [f"{name}_low", f"{name}_high"]:
        return f"`{name}[_low|_high]`"
    return ", ".join(f"`{each}`" for each in column[0])


def _column_list(columns: Sequence[_Columns]) -> str:
    """Return the columns as a Markdown list; neighbours with similar meanings share one item."""
    return "".join(
        f"- {', '.join(_names(columns[at]) for at in item)}: {text}\n"
        for item, text in _items([(at, meaning) for at, (_, meaning) in enumerate(columns)])
    )


def _items[Name](described: Sequence[tuple[Name, str]]) -> Iterator[tuple[list[Name], str]]:
    """Yield groups of neighbouring names with similar texts, each with its merged text."""
    item: list[tuple[Name, str]] = []
    for each in described:
        if item and not _merged([text for _, text in (*item, each)]):
            yield [name for name, _ in item], _joint(item)
            item = []
        item.append(each)
    if item:
        yield [name for name, _ in item], _joint(item)


def _joint[Name](item: Sequence[tuple[Name, str]]) -> str:
    return _merged([text.replace(" (-)", "") for _, text in item])


def _merged(meanings: Sequence[str]) -> str:
    """Return the texts merged into one, or an empty text if they differ too much.

    "peak longitudinal drift" and "peak transverse drift" become "peak longitudinal/transverse
    drift".
    """
    if len(set(meanings)) == 1:
        return meanings[0]
    words = [meaning.split() for meaning in meanings]
    start = _common(words)
    end = _common([each[start:][::-1] for each in words])
    middles = [" ".join(each[start : len(each) - end]) for each in words]
    if start + end < 3 or max(len(middle.split()) for middle in middles) > 3 or "" in middles:
        return ""
    first, between = words[0], "/" if not any({" ", "/"} & set(each) for each in middles) else " / "
    return " ".join([*first[:start], between.join(middles), *first[len(first) - end :]])


def _with_ends(columns: Mapping[str, str]) -> Iterator[_Columns]:
    """Yield each column of a table with its meaning and the ends of its interval, if it has one."""
    for name, meaning in columns.items():
        base, _, end = name.rpartition("_")
        base = "ratio" if base == "ci" else base
        if base not in columns or end not in {"low", "high"}:
            stem = "ci" if name == "ratio" and "ci_low" in columns else name
            ends = [f"{stem}_{end}" for end in ("low", "high")]
            yield (name, *(each for each in ends if each in columns)), meaning


def _common(lists: Sequence[Sequence[str]]) -> int:
    """Return the number of leading elements that are equal in all lists."""
    return sum(1 for _ in takewhile(lambda same: len(set(same)) == 1, zip(*lists, strict=False)))


def _schema(make: Callable[[], dict[str, Any]]) -> Callable[[], str]:
    return lambda: json.dumps(make(), indent=1) + "\n"


PAGES: Final[dict[str, Callable[[], str]]] = {
    "config/README.md": config_page,
    "config/schema.json": _schema(StudyConfig.model_json_schema),
    "config/bridge.schema.json": _schema(bridge_schema),
    "config/limit_states.schema.json": _schema(TypeAdapter(list[LimitStateEntry]).json_schema),
}


def write_pages(root: Path = ROOT) -> None:
    """Write all pages into the repository at `root`."""
    for name, page in PAGES.items():
        (root / name).write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    hush_exit_message()
    write_pages()
