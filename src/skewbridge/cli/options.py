"""Options that several commands share: a variant, a study, modelling keys, an output folder."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from skewbridge.analysis.settings import AnalysisSettings, under_explicit_keys
from skewbridge.bridge.frame import require_options
from skewbridge.bridge.library import load_structure
from skewbridge.cli.output import Opt
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

OUT: Final = Opt("out", Path, "Folder for the results.", ...)
LIMIT_STATES: Final = Opt(
    "limit_states", Path, "File of limit states; outside a study folder, that of the package.",
    Path("config/limit_states.yaml"),
)  # fmt: skip
STUDY: Final = Opt(
    "study", Path | None, "Results folder of a study, or its configuration file; by default the "
    "study of config/config.yaml.", None, "DIR|FILE.yaml",
)  # fmt: skip
#: `plan` and `status` also take ``--config``.
PLANNED_STUDY: Final = STUDY._replace(flags="--study --config")


def config_of(study: Path | None) -> Path:
    """Return the configuration file of a study, given its results folder or that file.

    Raises:
        InputError: No configuration in config/, or more than one, writes to the folder.
    """
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
    """Return the study that made a file: its results folder or configuration, or the default one.

    The configuration is stored in the folder, or one in config/ writes to the folder.
    """
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


BRIDGE: Final = Opt(
    "bridge", str, "Name of a bridge (`skewbridge bridge list`), or the path of its file.",
    "osb1", "NAME|FILE",
)  # fmt: skip
ABUTMENT: Final = Opt(
    "abutment", str, "Abutment model, from the simplest to contact with friction.",
    "contact-friction", f"[{'|'.join(ABUTMENTS).replace('_', '-')}]",
)  # fmt: skip
#: Options of a command about one variant.
VARIANT: Final = (
    BRIDGE,
    ABUTMENT,
    *(
        Opt(axis.name, float, f"{axis.label_with_unit}, {axis.low:g} to {axis.high:g}.", axis.usual)
        for axis in AXES
    ),
    Opt("changes", list[str] | None, "Key of model or analysis (config/README.md); repeatable.",
        None, "KEY=VALUE", "--set"),
)  # fmt: skip


def variant_of(given: Mapping[str, Any]) -> Variant:
    """Return the variant with these values; raise `InputError` if one is outside its limits."""
    values = {axis.name: given[axis.name] for axis in AXES}
    return Variant.at(given["bridge"], given["abutment"].replace("-", "_"), values)


def model_of(given: Mapping[str, Any]) -> ModelOptions:
    """Return the options set by ``--set``; raise `InputError` for a wrong key or value."""
    values = keys_and_values("--set", given["changes"])
    require_options(load_structure(given["bridge"]), values)
    return checked(ModelOptions, values, "--set")


def settings_and_model(
    given: Mapping[str, Any], *names: str
) -> tuple[AnalysisSettings, ModelOptions]:
    """Return the settings of the analysis and the modelling options.

    The options ``names`` (keys of the analysis), if given, and ``--set`` override the values of the
    preset ``accuracy``. A wrong key or value raises `InputError`.
    """
    keys = {field.name for field in fields(AnalysisSettings)}
    analysis, model = {name: given[name] for name in names if given[name] is not None}, {}
    for key, value in keys_and_values("--set", given["changes"]).items():
        (analysis if key in keys else model)[key] = value
    require_options(load_structure(given["bridge"]), model)
    full = under_explicit_keys({"analysis": analysis, "model": model}, given["accuracy"])
    settings = checked(AnalysisSettings, full["analysis"], "the options")
    return settings, checked(ModelOptions, full["model"], "--set")


def keys_and_values(option: str, pairs: list[str] | None) -> dict[str, Any]:
    """Return the KEY=VALUE pairs of a repeatable option as a dict; values are parsed as YAML."""
    values: dict[str, Any] = {}
    for pair in pairs or ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"{option} takes KEY=VALUE, got {shortened(pair)}")
        values[key.strip()] = parse_yaml(text, f"{option} {shortened(pair)}")
    return values
