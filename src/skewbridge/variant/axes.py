"""Axes of a study: quantities that may differ between the variants of one bridge.

Skew, gap and friction are axes of every variant. A numeric field of `ModelOptions` is an axis if
the grid names it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import degrees
from typing import Any, Final

from pydantic import TypeAdapter

from skewbridge.errors import InputError
from skewbridge.units import split_unit
from skewbridge.variant.options import AXES_TABLE, ModelOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """Axis of the grid: a quantity with limits, unit and code in the names of variants."""

    name: str  # key under ``grid:`` and column in every table
    label: str  # short name in figures and tables, without unit
    title: str  # name within a sentence
    description: str  # meaning of the value
    code: str  # letters before the number in the name of a variant
    low: float  # smallest valid value
    high: float  # largest valid value
    #: maximum number of decimals of a value, so that variant names are unique; None for modelling
    #: options without a limit
    decimals: int | None
    name_factor: int = 1  # the name contains the value times this factor (100 for friction)
    digits: int = 0  # minimum number of digits before the decimals in the name; 0: value unchanged
    usual: float = 0  # default value on the command line
    symbol: str = ""  # symbol that replaces the label before a value in figures

    @property
    def unit(self) -> str:
        """Unit at the end of the name; ``-`` if it has none."""
        return split_unit(self.name)[1]

    @property
    def label_with_unit(self) -> str:
        """Label with unit, for a figure axis."""
        return self.label if self.unit == "-" else f"{self.label} ({self.unit})"

    @property
    def is_whole(self) -> bool:
        """Whether the values are whole numbers."""
        return self.decimals == 0

    def complaint(self, value: float) -> str | None:
        """Return the requirement that a value violates, or None if the value is valid."""
        if not self.low <= value <= self.high:
            return f"must be within {self.low:g}..{self.high:g}"
        # 1e-9 is a rounding error
        if self.decimals is None or abs(value - round(value, self.decimals)) <= 1e-9:
            return None
        decimals_limit = f"have at most {self.decimals} decimals"
        return f"must {decimals_limit if self.decimals else 'be a whole number'}"

    def checked(self, value: float) -> float:
        """Return a value rounded to the decimals of the axis; `InputError` if it is invalid."""
        if complaint := self.complaint(value):
            raise InputError(f"{self.name} {complaint}, got {float(value):.10g}")
        return float(value) if self.decimals is None else round(value, self.decimals or None)

    def count(self, value: float) -> float:
        """Return a value as in variant names: times ``name_factor``, an integer if it is whole."""
        count = round(self.checked(value) * self.name_factor, self.decimals)
        return int(count) if count == int(count) else float(count)

    def in_name(self, value: float) -> str:
        """Return the value as text in the name of a variant, such as ``skew30``."""
        number = self.count(value) if self.digits else value
        text = f"{abs(number)!r}".removesuffix(".0").replace("+", "").replace(".", "p")
        integer, point, decimals = text.partition("p")
        sign = ("m" if self.digits else "-") if number < 0 else ""
        return f"{self.code}{sign}{integer.zfill(self.digits)}{point}{decimals}"


AXES: Final = tuple(Axis(name=name, **fields) for name, fields in AXES_TABLE.items())
#: Default values on these axes.
USUAL: Final = {axis.name: axis.usual for axis in AXES}


def axis(name: str) -> Axis:
    """Return skew, gap, friction or the axis of a modelling option by name, else `InputError`."""
    if name not in _BY_NAME:
        raise InputError(f"axis must be one of {', '.join(_BY_NAME)}, got {name!r}")
    return _BY_NAME[name]


def unit_doubts(skews_deg: Iterable[float], gaps_mm: Iterable[float]) -> list[str]:
    """Return a warning if all skews but zero look like radians, and all gaps like m or cm."""
    skew, gap = (max(map(abs, values), default=0.0) for values in (skews_deg, gaps_mm))
    unit, per_unit = ("m", 1000.0) if gap < 1.0 else ("cm", 10.0)
    texts = {
        f"skew_deg is in degrees: {skew:g} rad would be {degrees(skew):.4g}": 0.0 < skew < 1.6,
        f"gap_mm is in mm: {gap:g} {unit} would be {per_unit * gap:g}": 0.0 < gap < 10.0,
    }
    return [text for text, is_doubtful in texts.items() if is_doubtful]


def axes_of(columns: Iterable[str]) -> tuple[Axis, ...]:
    """Return the axes among the columns of a table: skew, gap, friction, then options."""
    names = set(columns)
    return tuple(axis for axis in _BY_NAME.values() if axis.name in names)


def _option_axis(name: str, field: Mapping[str, Any]) -> Axis | None:
    """Return the axis of a modelling option from its JSON schema, or None if not numeric."""
    kinds = field.get("anyOf", [field])
    numeric = next((kind for kind in kinds if kind.get("type") in ("number", "integer")), None)
    if numeric is None:
        return None
    title = split_unit(name)[0].replace("_", " ")
    return Axis(
        name=name,
        label=title.capitalize(),
        title=title,
        description=field["description"],
        code=name.replace("_", "-"),
        low=numeric["minimum"],
        high=numeric["maximum"],
        decimals=0 if numeric["type"] == "integer" else None,
    )


_OPTIONS: Final = TypeAdapter(ModelOptions).json_schema()["properties"]
OPTION_AXES: Final = tuple(filter(None, (_option_axis(*item) for item in _OPTIONS.items())))
_BY_NAME: Final = {axis.name: axis for axis in (*AXES, *OPTION_AXES)}
