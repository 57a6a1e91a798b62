"""Options that several commands share: a variant, a study, modelling keys, an output folder."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from skewbridge.analysis.settings import AnalysisSettings, under_explicit_keys
from skewbridge.cli.output import opt
from skewbridge.errors import InputError
from skewbridge.files.text import checked, parse_yaml, read_yaml, shortened
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant

if TYPE_CHECKING:
    from skewbridge.study.config import StudyConfig
    from skewbridge.study.folder import StudyFolder

#: The configuration of the default study; other configurations are merged over it.
DEFAULT_CONFIG: Final = Path("config/config.yaml")
_YAML: Final = (".yaml", ".yml")

Out = Annotated[Path, opt("Folder for the results.")]
LimitStates = Annotated[Path, opt("Limit states; outside a study folder, those of the package.")]
LIMIT_STATES: Final = Path("config/limit_states.yaml")
Hazard = Annotated[Path | None, opt("Hazard curve (CSV, OpenQuake, USGS): adds annual rates.")]
_STUDY: Final = "Results folder or configuration of a study; default: config/config.yaml."
Study = Annotated[Path | None, opt(_STUDY, "DIR|FILE.yaml")]
#: `plan` and `status` also take ``--config``.
PlannedStudy = Annotated[Path | None, opt(_STUDY, "DIR|FILE.yaml", "--study", "--config")]


def config_of(study: Path | None) -> Path:
    """Return the configuration of a study, given its results folder or the file itself."""
    if study is None or study.suffix in _YAML:
        return study or DEFAULT_CONFIG
    from skewbridge.study.folder import default_root

    contents = {path: read_yaml(path) for path in sorted(DEFAULT_CONFIG.parent.glob("*.yaml"))}
    writers = [
        path
        for path, content in contents.items()
        if isinstance(content, Mapping)
        and Path(str(content.get("results", default_root(path)))).resolve() == study.resolve()
    ]
    if len(writers) == 1:
        return writers[0]
    raise InputError(
        f"{study}: {f'{len(writers)} files' if writers else 'no file'} in {DEFAULT_CONFIG.parent}/ "
        f"with `results: {study}`; name the configuration of the study with --study FILE.yaml"
    )


def study_of(study: Path | None) -> "tuple[StudyConfig, StudyFolder]":
    """Return configuration and results folder of a study, given one of the two."""
    from skewbridge.study.config import load_config, stored_configuration
    from skewbridge.study.folder import StudyFolder

    config = None if study is None else stored_configuration(study)
    config = config or load_config(config_of(study), base=DEFAULT_CONFIG)
    return config, StudyFolder(Path(config.results))


def study_near(file: Path) -> Path:
    """Return the study that made a file: its folder or configuration, or the default one."""
    from skewbridge.study.folder import StudyFolder

    for folder in file.resolve().parents:
        if StudyFolder(folder).configuration.is_file():
            return folder
        with suppress(InputError):
            return config_of(folder)
    return DEFAULT_CONFIG


def folder_of(study: Path | None) -> Path:
    """Return the results folder of a study, given that folder or its configuration file."""
    if study is not None and study.suffix not in _YAML:
        return study
    from skewbridge.study.folder import DEFAULT_ROOT

    if study is None and not DEFAULT_CONFIG.is_file():
        return Path(DEFAULT_ROOT)
    return study_of(study)[1].root


Bridge = Annotated[str, opt("Name (skewbridge bridge list) or file of a bridge.", "NAME|FILE")]
_MODELS: Final = f"[{'|'.join(ABUTMENTS).replace('_', '-')}]"
Abutment = Annotated[str, opt("Abutment model, from simple to contact with friction.", _MODELS)]
Changes = Annotated[list[str] | None, opt("Set an input key; repeatable.", "KEY=VALUE", "--set")]
_AXIS: Final = {
    axis.name: opt(f"{axis.label_with_unit}, {axis.low:g} to {axis.high:g}.") for axis in AXES
}
_USUAL: Final = {axis.name: axis.usual for axis in AXES}


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantOptions:
    """Options of a command about one variant."""

    bridge: Bridge = "osb1"
    abutment: Abutment = "contact-friction"
    skew_deg: Annotated[float, _AXIS["skew_deg"]] = _USUAL["skew_deg"]
    gap_mm: Annotated[float, _AXIS["gap_mm"]] = _USUAL["gap_mm"]
    friction: Annotated[float, _AXIS["friction"]] = _USUAL["friction"]
    changes: Changes = None  # keys of model and analysis

    @property
    def variant(self) -> Variant:
        """The variant; raises `InputError` if a value is outside its limits."""
        values = {axis.name: getattr(self, axis.name) for axis in AXES}
        return Variant.at(self.bridge, self.abutment.replace("-", "_"), values)

    @property
    def model(self) -> ModelOptions:
        """The options set by ``--set``; raises `InputError` for a wrong key or value."""
        values = keys_and_values("--set", self.changes)
        _require_options(self.bridge, values)
        return checked(ModelOptions, values, "--set")

    def settings_and_model(
        self, accuracy: str, **keys_set: Any
    ) -> tuple[AnalysisSettings, ModelOptions]:
        """Return the settings of the analysis and the modelling options.

        ``keys_set`` (keys of the analysis, ignored if None) and ``--set`` override the values of
        the preset ``accuracy``. A wrong key or value raises `InputError`.
        """
        keys = {field.name for field in fields(AnalysisSettings)}
        analysis = {name: value for name, value in keys_set.items() if value is not None}
        model: dict[str, Any] = {}
        for key, value in keys_and_values("--set", self.changes).items():
            (analysis if key in keys else model)[key] = value
        _require_options(self.bridge, model)
        sections = under_explicit_keys({"analysis": analysis, "model": model}, accuracy)
        settings = checked(AnalysisSettings, sections["analysis"], "the options")
        return settings, checked(ModelOptions, sections["model"], "--set")


def _require_options(bridge: str, names: Mapping[str, Any]) -> None:
    # Imported here: the help loads no numbers.
    from skewbridge.bridge.frame import require_options
    from skewbridge.bridge.library import load_structure

    require_options(load_structure(bridge), names)


def keys_and_values(option: str, pairs: list[str] | None) -> dict[str, Any]:
    """Return the KEY=VALUE pairs of a repeatable option as a dict; values are parsed as YAML."""
    values: dict[str, Any] = {}
    for pair in pairs or ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"{option} takes KEY=VALUE, got {shortened(pair)}")
        values[key.strip()] = parse_yaml(text, f"{option} {shortened(pair)}")
    return values
