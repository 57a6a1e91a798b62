"""The axes of a study: what may differ between the variants of one bridge, told once."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """One axis of the grid.

    Attributes:
        name: Key under ``grid:`` and column in every table.
        unit: Unit, ``-`` for none.
        label: Short name in figures and tables, without unit.
        title: The same in the middle of a sentence.
        description: What the number is.
        code: Letters before the number in the name of a variant.
        digits: Digits of that number.
        low: Smallest value.
        high: Largest value.
        step: Values are whole multiples of it, so that names never depend on rounding.
        symbol: Stands for the label beside a value in figures.
    """

    name: str
    unit: str
    label: str
    title: str
    description: str
    code: str
    digits: int
    low: float
    high: float
    step: float
    symbol: str = ""

    @property
    def label_with_unit(self) -> str:
        """Label of a figure axis."""
        return self.label if self.unit == "-" else f"{self.label} ({self.unit})"

    @property
    def is_whole(self) -> bool:
        """Whether the values are whole numbers."""
        return self.step == 1.0


AXES: Final = (
    Axis(
        name="skew_deg",
        unit="deg",
        label="Skew",
        title="skew",
        description="skew of the abutment line from the transverse axis",
        code="skew",
        digits=2,
        low=-60.0,
        high=60.0,
        step=1.0,
    ),
    Axis(
        name="gap_mm",
        unit="mm",
        label="Gap",
        title="the joint gap",
        description="initial joint gap",
        code="gap",
        digits=3,
        low=0.0,
        high=999.0,
        step=1.0,
    ),
    Axis(
        name="friction",
        unit="-",
        label="Friction",
        title="friction",
        description="Coulomb coefficient at the contacts",
        code="mu",
        digits=3,
        low=0.0,
        high=1.5,
        step=0.01,
        symbol="μ",
    ),
)


def axes_of(columns: Iterable[str]) -> tuple[Axis, ...]:
    """Return the axes among the columns of a table, in the order of the axis table."""
    present = set(columns)
    return tuple(axis for axis in AXES if axis.name in present)
