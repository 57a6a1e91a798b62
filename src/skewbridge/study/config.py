"""The whole configuration: YAML in, the typed sections of the packages below out."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.analysis.accuracy import NUMERICS, Accuracy, under_explicit_keys
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.demands.suspect import SuspectLimits
from skewbridge.fragility.settings import FitSettings
from skewbridge.motions.levels import MotionsConfig
from skewbridge.reading import FileName, Number, Whole, checked, merged, read_mapping
from skewbridge.study.figure_settings import FigureSettings
from skewbridge.study.folder import DEFAULT_ROOT
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.options import ModelOptions

#: The bridge whose conditioning period sets the factors of every study: they belong to a motion
#: alone, or the pairs of variants and bridges would be lost.
CONDITIONING_BRIDGE: Final = "osb1"


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class SensitivityConfig:
    """Numerical check: rows of the study at the reference accuracy, and with other penalties."""

    rows: Whole = Field(
        default=4,
        ge=0,
        le=10_000,
        description="so many rows of the study again at the reference accuracy and with halved and "
        "doubled penalties, spread over its variants, under its strongest motions; 0 for none",
    )
    window_s: Number | None = Field(
        default=6.0,
        ge=3.0,
        le=1.0e4,
        description="strongest part of the motion (most Arias intensity) that these rows are "
        "analysed for, on both sides of every comparison; null for the whole motion",
    )


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class BatchesConfig:
    """How the analyses are shared out among jobs; it changes no result and repeats none."""

    cpu_hours: Number | None = Field(
        default=None,
        ge=1.0e-3,
        le=1.0e5,
        description="processor hours of one job by forecast, for a cluster; null for one job with "
        "all cores, best on one machine",
    )
    no_progress_s: Whole = Field(
        default=120,
        ge=1,
        le=86400,
        description="a worker whose analysis takes no step for so long is ended, and its row is "
        "`crash`; only time during which the study itself runs counts",
    )


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ModellingChoicesConfig:
    """What `make choices` analyses: options of `model` and `analysis` changed one at a time."""

    motions: Whole = Field(
        default=4,
        ge=1,
        le=10_000,
        description="so many motions of every variant, spread over their PGV",
    )
    variants: tuple[Annotated[str, Field(max_length=500)], ...] = Field(
        default=(),
        max_length=1000,
        description="names of the variants to change; none for two of each bridge of the grid: the "
        "largest friction and the smallest gap at the middle and the largest skew",
    )


class StudyConfig(BaseModel):
    """The whole configuration."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    results: FileName = Field(
        default=DEFAULT_ROOT, description="folder of everything that the study writes"
    )
    accuracy: Accuracy = Field(
        default="default",
        description="set of numerics (steps, tolerance, wall points, fibers, deck elements); a key "
        "that is written under model or analysis beats it",
    )
    grid: GridConfig = Field(default_factory=GridConfig)
    motions: MotionsConfig = Field(default_factory=MotionsConfig)
    model: ModelOptions = Field(default_factory=ModelOptions)
    analysis: AnalysisSettings = Field(default_factory=AnalysisSettings)
    suspect: SuspectLimits = Field(default_factory=SuspectLimits)
    fragility: FitSettings = Field(default_factory=FitSettings)
    sensitivity: SensitivityConfig = Field(default_factory=SensitivityConfig)
    checks: Literal["report", "strict"] = Field(
        default="report",
        description="what a failed check of the tables does: report shows it at the top of the "
        "page, strict stops the study before the page",
    )
    max_unfinished_share: Number = Field(
        default=0.01,
        ge=0.0,
        le=1.0,
        description="largest share of analyses without a usable result that passes the checks",
    )
    figures: FigureSettings = Field(default_factory=FigureSettings)
    modelling_choices: ModellingChoicesConfig = Field(default_factory=ModellingChoicesConfig)
    batches: BatchesConfig = Field(default_factory=BatchesConfig)

    def bridges_with_periods(self) -> tuple[str, ...]:
        """Return the bridges whose conditioning periods the study uses, as the grid names them."""
        return tuple(dict.fromkeys((CONDITIONING_BRIDGE, *self.grid.bridge)))


def parse_config(raw: Mapping[str, Any]) -> StudyConfig:
    """Return the validated configuration.

    Args:
        raw: The mapping as Snakemake or YAML gives it; a section left out has its defaults.

    Raises:
        InputError: A key is unknown or a value is outside its limits; every finding is one line
            with the key, the limit and the value given.
    """
    return _checked(raw, "the configuration")


def load_config(path: Path, base: Path | None = None) -> StudyConfig:
    """Read a configuration file, merged over a base file as Snakemake merges ``--configfile``.

    Raises:
        InputError: The file is missing, no YAML mapping, or invalid.
    """
    raw = read_mapping(base) if base is not None and base != path else {}
    return _checked(merged(raw, read_mapping(path)), path)


def _checked(raw: Mapping[str, Any], where: str | Path) -> StudyConfig:
    """Check a mapping with its accuracy spread over the sections."""
    chosen = raw.get("accuracy")
    is_known = isinstance(chosen, str) and chosen in NUMERICS
    full = under_explicit_keys(raw, chosen) if is_known else dict(raw)
    return checked(StudyConfig, full, where)


def plain_sections(config: StudyConfig, *names: str) -> dict[str, Any]:
    """Return sections as plain values, fit for `params` of a rule and for `parse_config`."""
    return config.model_dump(mode="json", include=set(names))


def analysis_sections(config: StudyConfig) -> dict[str, Any]:
    """Return the sections that the analyses depend on, as `plain_sections` does."""
    return plain_sections(config, "motions", "model", "analysis")
