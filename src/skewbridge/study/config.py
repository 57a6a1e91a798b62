"""Configuration of a study: typed sections read from YAML, and the variants to run."""

import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, reduce
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.analysis.settings import NUMERICS, Accuracy, AnalysisSettings, under_explicit_keys
from skewbridge.bridge.library import is_script, load_structure
from skewbridge.demands.columns import INTENSITY_COLUMNS
from skewbridge.errors import InputError, did_you_mean
from skewbridge.files.text import (
    OPTIONS,
    FileName,
    Number,
    Whole,
    checked,
    merged,
    printable,
    read_json,
    read_mapping,
    shortened,
    write_text,
)
from skewbridge.fragility.settings import FitSettings, HazardConfig
from skewbridge.motions.levels import MotionsConfig
from skewbridge.study.folder import DEFAULT_ROOT, StudyFolder, default_root
from skewbridge.units import Units
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import UncertaintyConfig

if TYPE_CHECKING:  # imported when needed: every job reads a configuration, few have rates
    from skewbridge.fragility.hazard import HazardCurve

#: The bridge whose conditioning period sets the scale factors of every study. A factor must depend
#: on the motion only, otherwise runs of different variants and bridges could not be paired.
CONDITIONING_BRIDGE: Final = "osb1"
#: Generic font families; matplotlib chooses the font for each.
GENERIC_FONTS: Final = ("sans-serif", "serif", "monospace")
#: Intensity columns of every study.
MEASURES: Final = tuple(column.name for column in INTENSITY_COLUMNS)
#: Label size for which the figures are designed.
DESIGN_FONT_PT: Final = 9.0


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class SensitivityConfig:
    """Numerical check: study rows repeated at the reference accuracy and with other penalties."""

    rows: Whole = Field(default=4, ge=0, le=10_000)
    """most rows to repeat; fewer above a quarter of the cost of the analyses"""


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class BatchesConfig:
    """Worker processes of the analyses; these keys do not affect results."""

    no_progress_s: Whole = Field(default=120, ge=1, le=86400)
    """time (s) without a step until an analysis is stopped and repeated once"""


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class DesignConfig:
    """Rounds of motions until the headline effects are decided (`make study UNTIL=decided`)."""

    until: Literal["decided"] | None = Field(default=None)
    """decided: add motions until the headline effects are decided; null: all motions"""
    first: Whole = Field(default=12, ge=5, le=10_000)
    """motions of the first round"""
    step: Whole = Field(default=4, ge=1, le=10_000)
    """motions added per round"""
    most: Whole = Field(default=64, ge=6, le=10_000)
    """largest number of motions; replaces motions.count"""
    hours: Number = Field(default=2.0, gt=0.0, le=10_000.0)
    """time limit of one command, including tables and page"""

    @model_validator(mode="after")
    def _rounds_follow(self) -> Self:
        if self.first >= self.most:
            raise ValueError(f"first must be below most ({self.most}), got {self.first}")
        return self

    @property
    def looks(self) -> tuple[int, ...]:
        """Number of motions after each round, for a variant that takes part in every round."""
        return (*range(self.first, self.most, self.step), self.most)


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class FigureSettings:
    """Units of figures and page; width and font of figures."""

    units: Units = Field(default="si")
    """units of figures and page; tables stay SI"""
    width_mm: Number | None = Field(default=None, ge=40.0, le=500.0)
    """width of figures; null: as wide as their panels need"""
    font: Annotated[str, Field(min_length=1, max_length=100)] = Field(default="sans-serif")
    """sans-serif, serif, monospace or an installed font"""
    font_size_pt: Number = Field(default=DESIGN_FONT_PT, ge=4.0, le=24.0)
    """size of axis labels"""


class StudyConfig(BaseModel):
    """Configuration of a study: all sections of its YAML file."""

    model_config = OPTIONS | ConfigDict(frozen=True)

    results: FileName = Field(default=DEFAULT_ROOT)
    """folder of the study's files"""
    accuracy: Accuracy = Field(default="default")
    """set of numerics (fast: rows often suspect); keys under model or analysis override it"""
    grid: GridConfig = Field(default_factory=GridConfig)
    motions: MotionsConfig = Field(default_factory=MotionsConfig)
    model: ModelOptions = Field(default_factory=ModelOptions)
    uncertainty: UncertaintyConfig = Field(default_factory=UncertaintyConfig)
    analysis: AnalysisSettings = Field(default_factory=AnalysisSettings)
    fragility: FitSettings = Field(default_factory=FitSettings)
    hazard: HazardConfig = Field(default_factory=HazardConfig)
    sensitivity: SensitivityConfig = Field(default_factory=SensitivityConfig)
    checks: Literal["report", "strict"] = Field(default="report")
    """a failed check of the tables is reported on the page, or stops the study"""
    design: DesignConfig = Field(default_factory=DesignConfig)
    figures: FigureSettings = Field(default_factory=FigureSettings)
    batches: BatchesConfig = Field(default_factory=BatchesConfig)

    @model_validator(mode="after")
    def _rounds_of_motions(self) -> Self:
        if self.design.until and self.motions.design == "ida":
            raise ValueError("design.until: an IDA cannot run in rounds: change motions.design")
        if self.design.until and len(self.motions.suites) > 1:
            raise ValueError("design.until: rounds need exactly one suite in motions.suites")
        if self.motions.selection:
            if self.motions.folder not in (None, str(self.folder.selected)):
                raise ValueError("motions: give selection or folder, not both")
            if self.design.until:
                raise ValueError("design.until: motions.selection cannot run in rounds; remove one")
        within, axes = self.motions.blocks and self.motions.blocks.within, self.grid.values()
        if unknown := set(within or ()) - axes.keys():
            names = printable(", ".join(sorted(unknown)))
            raise ValueError(f"motions.blocks.within: {names} is not an axis of the grid")
        for name, values in self.uncertainty.alternatives.items():
            if name in axes:
                raise ValueError(f"uncertainty.alternatives: remove {name}, an axis of the grid")
            models = [replace(self.model, **{name: value}) for value in values]
            if len(set(map(self.analysis.model_options, models))) == 1:
                raise ValueError(
                    f"uncertainty.alternatives: {name} has no effect if analysis.scheme is paper"
                )
        return self

    @property
    def folder(self) -> StudyFolder:
        """Files of the study."""
        return StudyFolder(Path(self.results))

    @cached_property
    def hazard_curve(self) -> "HazardCurve | None":
        """Hazard curve of the site for an intensity of the study, or None."""
        if self.hazard.file is None:
            return None
        from skewbridge.fragility.hazard import hazard_curve

        return hazard_curve(Path(self.hazard.file), MEASURES, self.fragility.im, warns=False)

    def bridges_with_periods(self) -> tuple[str, ...]:
        """Return the bridges whose conditioning periods the study uses, as the grid names them."""
        return tuple(dict.fromkeys((CONDITIONING_BRIDGE, *self.grid.bridge)))


def stated_values(bridge: str) -> dict[str, float]:
    """Return the values on axes that a bridge file states in place of those of a variant.

    They are the gap, the largest one, if no joint takes that of the variant, and zero without
    joints; the largest skew if no support takes that of the variant; and no friction without
    joints. The dict is empty if the bridge cannot be read or is a script.
    """
    values: dict[str, float] = {}
    with suppress(InputError):  # the check of the inputs reports it
        description = None if is_script(bridge) else load_structure(bridge).description
        if description and not description.takes_gap:
            values["gap_mm"] = round(max(description.gaps_mm.values(), default=0.0), 3)
        if description and not description.takes_skew:
            values["skew_deg"] = max(description.skews_deg.values(), key=abs)
        if description and not description.seats_m:
            values["friction"] = 0.0
    return values


def parse_config(
    raw: Mapping[str, Any],
    files: Sequence[str | Path] = (),
    where: str | Path = "the configuration",
) -> StudyConfig:
    """Return the validated configuration; omitted sections take their defaults.

    Without the key ``results``, the first of `files` sets the folder. A hazard curve sets the
    intensity measure of the curves, `motions.selection` the folder of motions. `InputError` has one
    line per wrong key or value.
    """
    with_results = {"results": default_root(files[0]) if files else DEFAULT_ROOT, **raw}
    design, motions = raw.get("design"), raw.get("motions", {})
    if isinstance(design, Mapping) and design.get("until") and isinstance(motions, Mapping):
        with_results["motions"] = {**motions, "count": design.get("most", DesignConfig().most)}
    accuracy = raw.get("accuracy")
    if isinstance(accuracy, str) and accuracy in NUMERICS:
        with_results = under_explicit_keys(with_results, accuracy)
    study = checked(StudyConfig, with_results, where)
    if study.design.until:  # the last round has all motions of a smaller suite
        from skewbridge.motions.suite import suite_sources  # here: its import takes long

        (source,) = suite_sources(study.motions)
        if source.count is not None and source.count < study.design.most:
            with_results["design"] = {**dict(design or {}), "most": source.count}
            study = checked(StudyConfig, with_results, where)
    stated = {name: stated_values(name) for name in study.grid.bridge}
    changes: dict[str, Any] = {"grid": study.grid.with_stated(stated)}
    if study.motions.selection:  # `study.inputs.select_motions` fills this folder
        selected = str(study.folder.selected)
        changes["motions"] = replace(study.motions, folder=selected, count=None)
    if hazard := study.hazard_curve:  # curves are for its intensity measure
        changes["fragility"] = replace(study.fragility, im=hazard.im)
    return study.model_copy(update=changes)


def load_config(path: Path, base: Path | None = None) -> StudyConfig:
    """Read a configuration file merged over a base file, like ``--configfile`` of Snakemake."""
    base_values = read_mapping(base) if base is not None and base != path else {}
    return parse_config(merged(base_values, read_mapping(path)), (path,), path)


def store_configuration(
    study: StudyConfig, files: Iterable[str | Path], overrides: Mapping[str, Any]
) -> None:
    """Write the configuration of a study into its results folder.

    Later `files` are merged over earlier ones; ``overrides`` has the values of `--config`.
    """
    paths = [Path(path).resolve() for path in files]
    names = [str(p.relative_to(Path.cwd()) if p.is_relative_to(Path.cwd()) else p) for p in paths]
    values = study.model_dump(mode="json")
    content = {"files": names, "given": dict(overrides), "configuration": values}
    write_text(study.folder.configuration, json.dumps(content, indent=1))


def stored_configuration(folder: Path) -> StudyConfig | None:
    """Return the configuration stored in a results folder (its files are read again), or None.

    `InputError` if it is only stored, by a version with keys that this one lacks.
    """
    path = StudyFolder(folder).configuration
    if not path.is_file():
        return None
    stored = read_json(path)
    files, values = list(map(Path, stored["files"])), stored["configuration"]
    if all(map(Path.is_file, files)):
        results = {"results": values["results"]}
        values = reduce(merged, (*map(read_mapping, files), stored["given"], results))
    elif removed := sorted(
        f"{name}.{key}"
        for name, default in parse_config({}).model_dump(exclude={"grid"}).items()
        if isinstance(default, dict) and isinstance(values.get(name), dict)
        for key in values[name].keys() - default.keys()
    ):
        text = f"{path} is of an earlier version, with keys that this one lacks"
        raise InputError(f"{text}: {', '.join(removed)}. Remove them, or run the study again")
    return parse_config(values, where=path)


def check_font(name: str) -> None:
    """Raise `InputError` if a font is neither installed nor a generic family."""
    if name in GENERIC_FONTS:
        return
    from matplotlib.font_manager import get_font_names  # here: slow, and rarely needed

    if name not in (installed := get_font_names()):
        raise InputError(
            f"figures.font must be {', '.join(GENERIC_FONTS)} or the name of an installed font"
            f"{did_you_mean(name, installed)}, got {shortened(name)}"
        )
