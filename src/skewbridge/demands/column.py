"""What is known of a column of the demands table."""

from dataclasses import dataclass
from typing import Literal

type Kind = Literal["text", "integer", "number"]
#: What a study does with a demand: paired effects and factors; fragility curves and clouds in the
#: report; comparison of the numerics.
type Role = Literal["effect", "headline", "sensitivity"]


@dataclass(frozen=True, slots=True)
class Column:
    """One column of the table.

    Attributes:
        name: Name, with the unit unless it is SI and obvious.
        kind: Type of the values.
        unit: Unit, ``-`` for ratios and texts.
        label: Short name in figures, without unit.
        symbol: Mathematical symbol.
        description: What the number is, with its sign.
        roles: What a study does with it.
    """

    name: str
    kind: Kind = "number"
    unit: str = "-"
    label: str = ""
    symbol: str = ""
    description: str = ""
    roles: tuple[Role, ...] = ()

    @property
    def label_with_unit(self) -> str:
        """Label of a figure axis."""
        text = self.label or self.name.replace("_", " ")
        return text if self.unit == "-" else f"{text} ({self.unit})"
