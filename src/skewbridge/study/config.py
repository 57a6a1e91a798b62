"""The whole configuration: YAML in, the typed sections of the packages below out."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.fragility.settings import FitSettings
from skewbridge.motions.settings import MotionsConfig
from skewbridge.reading import Whole, checked, merged, read_mapping
from skewbridge.study.folder import DEFAULT_ROOT
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.options import ModelOptions


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class SensitivityConfig:
    """Numerical check: penalties and time step halved and doubled on a few analyses."""

    motions: Whole = Field(
        default=3,
        ge=0,
        description="strongest so many motions, on the most skewed frictional variant; 0 for none",
    )


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ModellingChoicesConfig:
    """What `make choices` analyses: options of `model` and `analysis` changed one at a time."""

    motions: Whole = Field(
        default=4, ge=1, description="so many motions of every variant, spread over their PGV"
    )
    variants: tuple[str, ...] = Field(
        default=(),
        description="names of the variants to change; none for two of each bridge of the grid: the "
        "largest friction and the smallest gap at the middle and the largest skew",
    )


class StudyConfig(BaseModel):
    """The whole configuration."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    results: str = Field(
        default=DEFAULT_ROOT, min_length=1, description="folder of everything that the study writes"
    )
    grid: GridConfig = Field(default_factory=GridConfig)
    motions: MotionsConfig = Field(default_factory=MotionsConfig)
    model: ModelOptions = Field(default_factory=ModelOptions)
    analysis: AnalysisSettings = Field(default_factory=AnalysisSettings)
    fragility: FitSettings = Field(default_factory=FitSettings)
    sensitivity: SensitivityConfig = Field(default_factory=SensitivityConfig)
    modelling_choices: ModellingChoicesConfig = Field(default_factory=ModellingChoicesConfig)


def parse_config(raw: Mapping[str, Any]) -> StudyConfig:
    """Return the validated configuration.

    Args:
        raw: The mapping as Snakemake or YAML gives it; a section left out has its defaults.

    Raises:
        InputError: A key is unknown or a value is outside its limits; every finding is one line
            with the key, the limit and the value given.
    """
    return checked(StudyConfig, dict(raw), "the configuration")


def load_config(path: Path, base: Path | None = None) -> StudyConfig:
    """Read a configuration file, merged over a base file as Snakemake merges ``--configfile``.

    Raises:
        InputError: The file is missing, no YAML mapping, or invalid.
    """
    raw = read_mapping(base) if base is not None and base != path else {}
    return checked(StudyConfig, merged(raw, read_mapping(path)), path)


def plain_sections(config: StudyConfig, *names: str) -> dict[str, Any]:
    """Return sections as plain values, fit for `params` of a rule and for `parse_config`."""
    return config.model_dump(mode="json", include=set(names))
