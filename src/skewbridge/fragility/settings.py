"""Settings of the fits and the site: sections ``fragility`` and ``hazard`` of the configuration."""

from typing import Annotated, Final, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.demands.columns import DEMAND_COLUMNS
from skewbridge.files.text import OPTIONS, FileName, Number

#: Level of the intervals of effects: two one-sided tests at 5 % (Schuirmann 1987).
EFFECT_CONFIDENCE: Final = 0.90
#: Dispersion assumed for one-sided bounds of medians.
ASSUMED_BETA: Final = 0.4
_COLUMNS: Final = {column.name: column for column in DEMAND_COLUMNS}


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class FitSettings:
    """Settings of curve fits and paired effects."""

    im: str = Field(default="im_saavg_rotd50_g")
    """intensity measure: an im_ column of demands"""
    limit_states: FileName = Field(default="config/limit_states.yaml")
    """file with the limit states"""
    confidence: Number = Field(default=0.95, gt=0.5, lt=1.0)
    """level of the intervals of fits"""
    # ASSUME no designer acts on a change of demand below 5 %. A median capacity changes by the
    # demand ratio to the power -1/slope; most slopes are near 1, so the same margin applies.
    margin: Number = Field(default=0.05, gt=0.0, lt=1.0)
    """negligible change of a demand or median capacity"""
    margins: dict[str, Annotated[Number, Field(gt=0.0)]] = Field(default={})
    """margins of single columns; mrad for deck rotation, mm for abutment deformations"""

    @model_validator(mode="after")
    def _margins_of_demands(self) -> Self:
        for name, margin in self.margins.items():
            if name not in _COLUMNS:
                raise ValueError(f"margins: {name!r} is not a demand column")
            if _COLUMNS[name].difference is None and margin >= 1.0:
                raise ValueError(f"margins: {name} must be < 1, got {margin:g}")
        return self

    def relative_margin(self, demand: str) -> float:
        """Return the largest relative change of a demand that counts as negligible."""
        column = _COLUMNS.get(demand)
        by_difference = column is not None and column.difference is not None
        return self.margin if by_difference else self.margins.get(demand, self.margin)


DEFAULTS: Final = FitSettings()


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class HazardConfig:
    """Hazard curve of the site, for annual rates."""

    file: FileName | None = Field(default=None)
    """CSV (columns im, rate), OpenQuake or USGS file, or a folder of OpenQuake files; null: none"""
