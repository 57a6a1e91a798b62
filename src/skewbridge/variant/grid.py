"""Grid of a study (section ``grid``) and its expansion into variants."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import prod
from pathlib import Path
from typing import Annotated, Any, Final, LiteralString, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from skewbridge.files.text import OPTIONS, Number
from skewbridge.variant.axes import AXES, OPTION_AXES
from skewbridge.variant.variant import ABUTMENTS, BRIDGE_PATTERN, Variant


def _known_abutment(value: str) -> str:
    name = value.replace("-", "_")
    if name not in ABUTMENTS:
        raise ValueError(f"must be one of {', '.join(ABUTMENTS)}")
    return name


def _named_bridge(value: str) -> str:
    if not re.fullmatch(BRIDGE_PATTERN, Path(value).stem):
        raise ValueError(
            "a bridge name must start with a letter and have only lowercase letters, digits and _"
        )
    return value


def _different_names(values: tuple[str, ...]) -> tuple[str, ...]:
    if len({Path(value).stem for value in values}) < len(values):
        raise ValueError("two bridges have the same file name: rename one")
    return values


def _with_axes(schema: dict[str, Any]) -> None:
    """Add limits of skew, gap and friction to the JSON schema, and the names of other axes."""
    for axis in AXES:
        item_schema = {"type": "number", "minimum": axis.low, "maximum": axis.high}
        schema["properties"][axis.name] |= {"description": axis.description, "items": item_schema}
    names = [*schema["properties"], *(axis.name for axis in OPTION_AXES)]
    schema["propertyNames"] = {"enum": names}
    schema["additionalProperties"] = {"type": "array", "minItems": 1, "items": {"type": "number"}}


MAX_VARIANTS: Final = 20_000

AxisValues = Annotated[tuple[Number, ...], Field(min_length=1)]
_OPTION_VALUES: Final = TypeAdapter(dict[str, AxisValues])
Abutment = Annotated[
    str, AfterValidator(_known_abutment), Field(json_schema_extra={"enum": list(ABUTMENTS)})
]
Bridge = Annotated[str, AfterValidator(_named_bridge)]


class GridConfig(BaseModel):
    """The axes of the study; every combination is one bridge variant.

    In addition to the fields, any numeric key of ``model`` may be an axis.
    """

    model_config = OPTIONS | ConfigDict(extra="allow", frozen=True, json_schema_extra=_with_axes)

    bridge: Annotated[tuple[Bridge, ...], AfterValidator(_different_names)] = Field(
        default=("osb1", "osb1_fixed_era1"), min_length=1
    )
    """bridges of config/bridges/ and the catalogue, or paths"""
    abutment: tuple[Abutment, ...] = Field(default=("contact_friction",), min_length=1)
    """abutment models, the simplest first"""
    skew_deg: AxisValues = (0, 30, 60)
    gap_mm: AxisValues = (25, 51)
    friction: AxisValues = (0.0, 0.5)
    #: values on axes that a bridge itself states, by bridge and axis
    _stated: dict[str, dict[str, float]] = PrivateAttr(default_factory=dict)

    def with_stated(self, values: dict[str, dict[str, float]]) -> Self:
        """Return the grid for bridges that state values on some axes, by bridge and axis."""
        grid = self.model_copy()
        grid._stated = values
        return grid

    def variant(self, bridge: str, abutment: str, point: Mapping[str, float]) -> Variant:
        """Return the variant at a point of the axes, with the values that its bridge states."""
        stated = self._stated.get(bridge, {})
        return Variant.at(bridge, abutment, {**point, **stated}).normalised()

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the values of every axis of the grid, keyed by axis name."""
        core = {axis.name: getattr(self, axis.name) for axis in AXES}
        return core | (self.model_extra or {})

    @model_validator(mode="after")
    def _values_on_their_axes(self) -> Self:
        options, axes = self.model_extra or {}, {axis.name: axis for axis in (*AXES, *OPTION_AXES)}
        unknown = {(name,): ("no axis", options[name]) for name in options.keys() - axes.keys()}
        _refuse("extra_forbidden", unknown)
        options.update(_OPTION_VALUES.validate_python(options))
        complaints = {
            (name, number): (complaint, value)
            for name, values in self.values().items()
            for number, value in enumerate(values)
            if (complaint := axes[name].complaint(value))
        }
        _refuse("axis", complaints)
        count = prod(map(len, (self.bridge, self.abutment, *self.values().values())))
        if count > MAX_VARIANTS:
            raise ValueError(
                f"the grid has {count} variants; the limit is {MAX_VARIANTS}: give fewer values"
            )
        return self


def _refuse(kind: LiteralString, findings: Mapping[Any, tuple[str, Any]]) -> None:
    """Raise one error with message and value of each invalid position in the grid, if any."""
    errors = [
        InitErrorDetails(type=PydanticCustomError(kind, "{w}", {"w": text}), loc=path, input=value)
        for path, (text, value) in findings.items()
    ]
    if errors:
        raise ValidationError.from_exception_data("grid", errors)


def expand_grid(grid: GridConfig) -> list[Variant]:
    """Return the variants of a grid, sorted, with zero on axes that an abutment model lacks."""
    return sorted({variant for variant, _ in _points(grid)})


def cells_of(grid: GridConfig, within: Sequence[str]) -> tuple[int, dict[str, list[int]]]:
    """Return the number of cells of a grid, and the indices of the cells of each variant (slug).

    A cell is a combination of values of the axes not listed in ``within``. A variant that lacks
    some of these axes belongs to several cells.
    """
    cell_axes = [name for name in grid.values() if name not in within]
    cell_numbers: dict[tuple[float, ...], int] = {}
    cells: dict[str, set[int]] = {}
    for variant, point in _points(grid):
        cell = cell_numbers.setdefault(tuple(point[name] for name in cell_axes), len(cell_numbers))
        cells.setdefault(variant.slug, set()).add(cell)
    return len(cell_numbers), {slug: sorted(cells[slug]) for slug in sorted(cells)}


def _points(grid: GridConfig) -> Iterator[tuple[Variant, dict[str, float]]]:
    """Yield the variant and the values of the axes at every point of a grid."""
    axes = grid.values()
    for bridge, abutment, values in product(grid.bridge, grid.abutment, product(*axes.values())):
        point = dict(zip(axes, values, strict=True))
        yield grid.variant(bridge, abutment, point), point
