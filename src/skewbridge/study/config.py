"""The typed configuration: these models are the one source of the schema and of the key table."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from skewbridge.errors import InputError
from skewbridge.study.variant import ABUTMENT_CODES, MAX_FRICTION_PCT, MAX_GAP_MM, MAX_SKEW_DEG


def _whole_hundredths(value: float) -> float:
    if abs(value * 100 - round(value * 100)) > 1e-9:
        msg = "friction must be a whole number of hundredths, so that it can be part of a name"
        raise ValueError(msg)
    return value


def _known_abutment(value: str) -> str:
    name = value.replace("-", "_")
    if name not in ABUTMENT_CODES:
        msg = f"unknown abutment model; known: {', '.join(ABUTMENT_CODES)}"
        raise ValueError(msg)
    return name


Skew = Annotated[int, Field(ge=-MAX_SKEW_DEG, le=MAX_SKEW_DEG)]
Gap = Annotated[int, Field(ge=0, le=MAX_GAP_MM)]
Friction = Annotated[
    float, Field(ge=0.0, le=MAX_FRICTION_PCT / 100), AfterValidator(_whole_hundredths)
]
Abutment = Annotated[str, AfterValidator(_known_abutment)]
Positive = Annotated[float, Field(gt=0.0)]
Ratio = Annotated[float, Field(ge=0.0, le=1.0)]


class _Section(BaseModel):
    # strict: "2e7", which YAML 1.1 reads as text, must not pass as a number
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class GridConfig(_Section):
    """The axes of the study; every combination is one bridge variant."""

    bridge: list[str] = Field(default=["osb1"], min_length=1, description="catalogue names")
    abutment: list[Abutment] = Field(
        default=["contact_friction"], min_length=1, description=f"of {', '.join(ABUTMENT_CODES)}"
    )
    skew_deg: list[Skew] = Field(
        default=[0, 30, 60], min_length=1, description="skew, whole degrees"
    )
    gap_mm: list[Gap] = Field(
        default=[25, 51], min_length=1, description="longitudinal gap, whole mm"
    )
    friction: list[Friction] = Field(
        default=[0.0, 0.5], min_length=1, description="Coulomb coefficient, whole hundredths"
    )


class MotionsConfig(_Section):
    """Which ground motions, how strong and from which direction."""

    folder: str = Field(default="motions", description="folder with an index.csv or with motions")
    count: int | None = Field(
        default=16, ge=1, description="the first so many motions of the suite; null for all"
    )
    level_range_g: list[Positive] = Field(
        default=[0.1, 1.5],
        min_length=2,
        max_length=2,
        description="range of Sa_avg that the factors span, g",
    )
    incidence_deg: list[Annotated[float, Field(ge=0.0, lt=360.0)]] = Field(
        default=[0.0],
        min_length=1,
        description="angle from the bridge x axis to component 1, degrees",
    )

    @model_validator(mode="after")
    def _levels_rise(self) -> "MotionsConfig":
        if self.level_range_g[0] >= self.level_range_g[1]:
            msg = f"level_range_g must rise, got {self.level_range_g}"
            raise ValueError(msg)
        return self


class ModelConfig(_Section):
    """Modelling choices that are the same for every variant."""

    arrays: Literal["rigid", "corotational"] = Field(
        default="rigid", description="transverse arrays: rigid links or stiff corotational elements"
    )
    column_integration: Literal["hinge_radau", "lobatto5"] = Field(
        default="hinge_radau",
        description="column plasticity: hinge_radau, or lobatto5 as in the paper",
    )
    transverse_gap_mm: Annotated[float, Field(ge=0.0, le=500.0)] = Field(
        default=6.4, description="gap at the shear keys, mm"
    )
    cohesion_n: Annotated[float, Field(ge=0.0)] = Field(
        default=0.0, description="cohesion per contact, N"
    )
    backwall_points: Annotated[int, Field(ge=2, le=15)] = Field(
        default=5, description="contact points along one backwall, the corners included"
    )


class AnalysisConfig(_Section):
    """The transient analysis."""

    scheme: Literal["default", "paper"] = Field(
        default="default",
        description="default, or the paper's integrator, coupling, arrays and columns",
    )
    dt_s: Annotated[float, Field(gt=0.0, le=0.02)] = Field(
        default=0.005, description="time step, s"
    )
    duration_s: Positive | None = Field(
        default=None, description="cut every motion to this window, s; null for the whole motion"
    )
    free_vibration_s: Annotated[float, Field(ge=0.0)] = Field(
        default=0.0, description="zeros after the motion, s (the shipped suite has its 5 s inside)"
    )
    collapse_drift_ratio: Positive = Field(
        default=0.10, description="column drift that counts as collapse"
    )
    collapse_deck_disp_m: Positive = Field(
        default=2.0, description="deck displacement that counts as collapse, m"
    )


class FragilityConfig(_Section):
    """The fits."""

    im: str = Field(
        default="im_saavg_rotd50_g", description="intensity measure: an im_ column of demands"
    )
    limit_states: str = Field(
        default="config/limit_states.yaml", description="file with the limit states"
    )
    confidence: Annotated[float, Field(gt=0.5, lt=1.0)] = Field(
        default=0.95, description="confidence level of the intervals of the fits"
    )
    bootstrap: Annotated[int, Field(ge=99)] = Field(
        default=999, description="record-bootstrap replicates for the paired effects"
    )
    seed: int = Field(default=20261120, ge=0, description="seed of the bootstrap")


class SensitivityConfig(_Section):
    """Numerical check: penalties and time step halved and doubled on a few analyses."""

    motions: Annotated[int, Field(ge=0)] = Field(
        default=3,
        description="strongest so many motions, on the most skewed frictional variant; 0 for none",
    )


class StudyConfig(_Section):
    """The whole configuration."""

    grid: GridConfig = Field(default_factory=GridConfig)
    motions: MotionsConfig = Field(default_factory=MotionsConfig)
    model: ModelConfig = Field(default_factory=ModelConfig)
    analysis: AnalysisConfig = Field(default_factory=AnalysisConfig)
    fragility: FragilityConfig = Field(default_factory=FragilityConfig)
    sensitivity: SensitivityConfig = Field(default_factory=SensitivityConfig)


def parse_config(raw: Mapping[str, Any]) -> StudyConfig:
    """Return the validated configuration.

    Args:
        raw: The mapping as Snakemake or YAML gives it.

    Raises:
        InputError: A key is unknown or a value is outside its limits; every finding is one line
            with the key, the limit and the value given.
    """
    try:
        return StudyConfig.model_validate(dict(raw))
    except ValidationError as error:
        lines = [_explain(finding) for finding in error.errors()]
        msg = "the configuration has {} error{}:\n  {}".format(
            len(lines), "s" if len(lines) > 1 else "", "\n  ".join(lines)
        )
        raise InputError(msg) from None


def load_config(path: Path, base: Path | None = None) -> StudyConfig:
    """Read a configuration file, merged over a base file as Snakemake merges ``--configfile``.

    Raises:
        InputError: The file is missing, no YAML mapping, or invalid.
    """
    raw = _read_yaml(base) if base is not None and base != path else {}
    return parse_config(_merged(raw, _read_yaml(path)))


def require_writable(folder: Path) -> None:
    """Raise `InputError` if results could not be written to a folder.

    The write is tried, because access rights alone say too little (the superuser, read-only file
    systems, a file of that name).
    """
    probe = folder / f".write-test-{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        msg = f"the results folder {str(folder)!r} is not writable: {error.strerror}"
        raise InputError(msg) from None


def key_table() -> list[dict[str, str]]:
    """Return one row per configuration key: key, default, meaning."""
    rows: list[dict[str, str]] = []
    for section, info in StudyConfig.model_fields.items():
        model = info.annotation
        if isinstance(model, type) and issubclass(model, BaseModel):
            for name, field in model.model_fields.items():
                default = yaml.safe_dump(field.default, default_flow_style=True).split("\n")[0]
                rows.append(
                    {
                        "key": f"{section}.{name}",
                        "default": default,
                        "meaning": field.description or "",
                    }
                )
    return rows


def _explain(finding: Any) -> str:
    where = ".".join(str(part) for part in finding["loc"])
    given = finding["input"]
    if finding["type"] == "extra_forbidden":
        return f"{where}: unknown key"
    message = finding["msg"].removeprefix("Value error, ")
    hint = ""
    if isinstance(given, str) and finding["type"].endswith(("_type", "_parsing")):
        hint = " (it is text; a number with an exponent is written like 2.0e+7)"
    return f"{where}: {message}, got {given!r}{hint}"


def _read_yaml(path: Path) -> dict[str, Any]:
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        msg = f"cannot read the configuration {str(path)!r}: {error.strerror}"
        raise InputError(msg) from None
    except yaml.YAMLError as error:
        msg = f"{path}: not valid YAML: {error}"
        raise InputError(msg) from None
    if raw is None:
        return {}
    if not isinstance(raw, dict):
        msg = f"{path}: expected keys and values, got {type(raw).__name__}"
        raise InputError(msg)
    return raw


def _merged(base: dict[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    out = dict(base)
    for key, value in over.items():
        old = out.get(key)
        out[key] = (
            _merged(old, value) if isinstance(old, dict) and isinstance(value, Mapping) else value
        )
    return out
