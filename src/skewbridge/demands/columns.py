"""Columns of the demands table, the key of its rows, and functions that find a column by name."""

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

from skewbridge.units import MN, split_unit
from skewbridge.variant.axes import AXES, Axis, axes_of
from skewbridge.variant.random_properties import CHOICE_PREFIX, DRAW_PREFIX, drawn_options
from skewbridge.variant.variant import Variant

SUITE: Final = "suite"
#: Earthquake of the motion, or no text. Motions of one event are left out together.
EVENT: Final = "event"
KEY: Final = ("variant", "motion_id", "scale", "incidence_deg")

type Kind = Literal["text", "integer", "number", "boolean"]
#: Use of a demand in a study. ``effect``: paired effects. ``headline``: also needed motions and
#: effects by intensity; its effects are in the family of adjusted verdicts, so another headline
#: demand may change them. ``sensitivity``: comparison of numerical settings. Curves and clouds
#: depend on the limit states (``config/limit_states.yaml``).
type Role = Literal["effect", "headline", "sensitivity"]


@dataclass(frozen=True, slots=True)
class Difference:
    """Unit and margin for judging the change of a demand whose values are often near zero."""

    unit: str
    per_unit: float  # number of these units in one unit of the column
    margin: float  # largest negligible difference, in this unit


@dataclass(frozen=True, slots=True)
class Column:
    """One column of the demands table."""

    name: str  # ends with the unit if there is one
    kind: Kind = "number"
    unit: str = "-"  # "-" for ratios and texts
    label: str = ""  # label in figures, without unit
    description: str = ""  # meaning and sign of the number
    roles: tuple[Role, ...] = ()
    difference: Difference | None = None  # None: the change is judged by the ratio

    @property
    def label_with_unit(self) -> str:
        """Label of a figure axis."""
        text = self.label or self.name.replace("_", " ")
        return text if self.unit == "-" else f"{text} ({self.unit})"


# ASSUME 5 mm at an abutment, a fifth of a narrow joint, is too small for a designer to act on;
# a rotation of 0.1 mrad moves the end of a deck of 90 m by as much
_DIFFERENCES: Final = {
    rule.unit: rule for rule in (Difference("mrad", 1e3, 0.1), Difference("mm", 1e3, 5.0))
}


def _listed() -> dict[str, tuple[Column, ...]]:
    """Return the columns of each group in ``columns.csv``, keyed by group, in order of the file."""
    groups: dict[str, list[Column]] = {}
    with Path(__file__).with_name("columns.csv").open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            values: dict[str, Any] = dict(row)
            values["unit"] = row["unit"] or "-"
            values["roles"] = tuple(row["roles"].split())
            values["difference"] = _DIFFERENCES.get(row["difference"])
            groups.setdefault(values.pop("group"), []).append(Column(**values))
    return {group: tuple(columns) for group, columns in groups.items()}


_COLUMNS: Final = _listed()
INTENSITY_COLUMNS: Final = _COLUMNS["intensity"]
DEMAND_COLUMNS: Final = _COLUMNS["demand"]


_OF_JOINTS: Final = {column.name: column for column in _COLUMNS["joint"]}
_JOINT: Final = re.compile(r"joint(\d*)(_unseating_m|_closures)")


def joint_columns(names: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns among ``names`` that describe joints inside the bridge.

    ``joint2_unseating_m`` is ``joint_unseating_m`` (of any joint) with the number in its texts.
    """
    columns: list[Column] = []
    for name in names:
        if match := _JOINT.fullmatch(name):
            column = replace(_OF_JOINTS[f"joint{match[2]}"], name=name)
            if number := match[1]:
                label = column.label.replace("inner joints", f"joint {number}")
                text = column.description.replace("any joint", f"joint {number}")
                column = replace(column, label=label, description=text)
            columns.append(column)
    return tuple(columns)


def option_columns(names: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns among ``names`` of modelling options that are drawn for every motion."""
    texts = {name: f"value of model.{name}, drawn once per motion" for name in drawn_options(names)}
    return tuple(Column(f"{CHOICE_PREFIX}{name}", "text", "-", "", texts[name]) for name in texts)


def columns_with(present: Iterable[str]) -> tuple[Column, ...]:
    """Return all columns of a study, with the axes and random properties named in ``present``."""
    names = list(present)
    axes = dict.fromkeys((*AXES, *axes_of(names)))
    random_columns: list[Column] = []
    for name in names:
        if name.startswith(DRAW_PREFIX):
            text = f"random property, drawn once per motion: {name.removeprefix(DRAW_PREFIX)}"
            random_columns.append(Column(name, unit=split_unit(name)[1], description=text))
    return (
        *_COLUMNS["variant"],
        *map(_axis_column, axes),
        *_COLUMNS["run"],
        *INTENSITY_COLUMNS,
        *DEMAND_COLUMNS,
        *joint_columns(names),
        *_COLUMNS["outcome"],
        *random_columns,
        *option_columns(names),
        *_COLUMNS["key"],
    )


def _axis_column(axis: Axis) -> Column:
    kind = "integer" if axis.is_whole else "number"
    return Column(axis.name, kind, axis.unit, axis.label, axis.description)


COLUMNS: Final = columns_with(())
_BY_NAME: Final = {column.name: column for column in COLUMNS}


def key_values(
    variant: Variant, motion_id: str, scale: float, incidence_deg: float
) -> dict[str, Any]:
    """Return the key columns of one analysis."""
    return {
        "variant": variant.slug,
        "bridge": variant.bridge_name,
        "abutment": variant.abutment,
        **variant.values(),
        "motion_id": motion_id,
        "scale": scale,
        "incidence_deg": incidence_deg,
    }


def demands_for(role: Role, present: Iterable[str] | None = None) -> tuple[str, ...]:
    """Return the names of demand columns with a role; ``present`` limits the choice if given."""
    present_names = None if present is None else set(present)
    columns = (*DEMAND_COLUMNS, *joint_columns(sorted(present_names or ())))
    names = (column.name for column in columns if role in column.roles)
    return tuple(name for name in names if present_names is None or name in present_names)


def column_of(name: str) -> Column | None:
    """Return the column or grid axis with this name, or None if there is none."""
    derived = (*joint_columns([name]), *map(_axis_column, axes_of([name])))
    return _BY_NAME.get(name) or next(iter(derived), None)


def label_of(name: str) -> str:
    """Return the label of a column with its unit. An unknown column is labelled with its name."""
    return (column_of(name) or Column(name)).label_with_unit


def unit_of(name: str) -> str:
    """Return the unit of a column, or an empty text for a ratio or an unknown column."""
    return (column_of(name) or Column(name)).unit.strip("-")


def choice_text(option: str, value: object) -> str:
    """Return a value of a modelling option (or its text in a table) in words, with its unit."""
    if isinstance(value, tuple):
        return " ".join(choice_text("", element) for element in value)
    try:
        number, unit = float(f"{value}"), split_unit(option)[1]
    except ValueError:
        return {"True": "yes", "False": "no"}.get(f"{value}", f"{value}".replace("_", " "))
    if unit == "N/m":
        number, unit = number / MN, "MN/m"
    return f"{number:g} {unit}".removesuffix(" -")
