"""Options that several commands share: a variant, a study, modelling keys, an output folder."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

import typer

from skewbridge.analysis.accuracy import under_explicit_keys
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.files.checking import checked
from skewbridge.files.text import parse_yaml, read_yaml, shortened
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

#: The configuration of the default study; other configurations are merged over it.
DEFAULT_CONFIG: Final = Path("config/config.yaml")
ABUTMENT_NAMES: Final = tuple(name.replace("_", "-") for name in ABUTMENTS)
ABUTMENT_CHOICES: Final = f"[{'|'.join(ABUTMENT_NAMES)}]"

_STUDY_HELP: Final = (
    "Results folder of a study, or its configuration file; by default the study of "
    "config/config.yaml."
)
StudyOption = Annotated[
    Path | None, typer.Option("--study", metavar="DIR|FILE.yaml", help=_STUDY_HELP)
]
#: `plan` and `status` also take ``--config``.
PlannedStudyOption = Annotated[
    Path | None, typer.Option("--study", "--config", metavar="DIR|FILE.yaml", help=_STUDY_HELP)
]


def config_of(study: Path | None) -> Path:
    """Return the configuration file of a study named by its folder or by that file.

    Raises:
        InputError: No configuration, or several, in config/ write to the folder.
    """
    if study is None or study.suffix in (".yaml", ".yml"):
        return study or DEFAULT_CONFIG
    from skewbridge.study.folder import default_root

    writers: list[Path] = []
    for path in sorted(DEFAULT_CONFIG.parent.glob("*.yaml")):
        content = read_yaml(path)
        results = (
            content.get("results", default_root(path)) if isinstance(content, Mapping) else None
        )
        if isinstance(results, str) and Path(results).resolve() == study.resolve():
            writers.append(path)
    if len(writers) == 1:
        return writers[0]
    count = f"{len(writers)} files" if writers else "no file"
    raise InputError(
        f"{study}: {count} in {DEFAULT_CONFIG.parent}/ with `results: {study}`; name the "
        "configuration of the study instead: --study FILE.yaml"
    )


def folder_of(study: Path | None) -> Path:
    """Return the results folder of a study named by that folder or by its configuration file."""
    if study is not None and study.suffix not in (".yaml", ".yml"):
        return study
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import DEFAULT_ROOT

    if study is None and not DEFAULT_CONFIG.is_file():
        return Path(DEFAULT_ROOT)
    return Path(load_config(study or DEFAULT_CONFIG, base=DEFAULT_CONFIG).results)


def known_bridges() -> list[str]:
    """Return the names of the catalogue and of the bridges in config/bridges."""
    from skewbridge.bridge.catalogue import bridge_names
    from skewbridge.bridge.catalogue.loading import OWN_FOLDER

    return [*bridge_names(), *(path.stem for path in sorted(OWN_FOLDER.glob("*.yaml")))]


BridgeOption = Annotated[
    str,
    typer.Option(
        "--bridge",
        help="Name of a bridge (`skewbridge bridge list`), or the path of its file.",
        metavar="NAME|FILE",
        autocompletion=known_bridges,
    ),
]
AbutmentOption = Annotated[
    str,
    typer.Option(
        "--abutment",
        help="Abutment model, from the simplest to contact with friction.",
        metavar=ABUTMENT_CHOICES,
        autocompletion=lambda: list(ABUTMENT_NAMES),
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Any key of model or analysis (config/README.md), e.g. backfill=sdc; repeatable.",
    ),
]
OutOption = Annotated[Path, typer.Option("--out", help="Folder for the results.")]
LIMIT_STATES: Final = Path("config/limit_states.yaml")
LimitStatesOption = Annotated[Path, typer.Option(help="File of limit states.")]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantChoice:
    """The variant that the options of a command name.

    Attributes:
        bridge: Name or file.
        abutment: Abutment model as given.
        values: Value on every core axis.
    """

    bridge: str
    abutment: str
    values: Mapping[str, float]

    def variant(self, abutment: str | None = None) -> Variant:
        """Return the variant, or the same one with another abutment model.

        Raises:
            InputError: A value is outside its limits or has too many decimals.
        """
        return Variant.at(self.bridge, (abutment or self.abutment).replace("-", "_"), self.values)


class Opt(NamedTuple):
    """One option of a command.

    Attributes:
        name: Name of the argument; the option is that with hyphens, after `--`.
        kind: Type of the value.
        help: What it means.
        default: Default; `...` for an option that must be given.
        metavar: What the help shows for the value.
        complete: Function that returns the values for shell completion.
    """

    name: str
    kind: Any
    help: str
    default: Any = None
    metavar: str | None = None
    complete: Callable[[], list[str]] | None = None

    def parameter(self) -> Parameter:
        """Return the option as a parameter of a command."""
        flag = f"--{self.name.replace('_', '-')}"
        given = typer.Option(
            flag, help=self.help, metavar=self.metavar, autocompletion=self.complete
        )
        return _keyword(self.name, Annotated[self.kind, given], self.default)


def _keyword(name: str, annotation: Any, default: Any) -> Parameter:
    filled = Parameter.empty if default is ... else default
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=filled)


def takes(*options: Opt) -> Callable[..., Any]:
    """Give a command options that it receives together, as its last argument `**given`."""

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        *own, _ = signature(command).parameters.values()

        @wraps(command)
        def with_options(*arguments: Any, **values: Any) -> None:
            command(*arguments, **values)

        given = [option.parameter() for option in options]
        return _with_parameters(with_options, [*own[:-1], *given, own[-1]])

    return decorate


def takes_variant(*, abutment: str = "contact-friction") -> Callable[..., Any]:
    """Give a command an option per axis; its first argument is then a `VariantChoice`.

    Args:
        abutment: Default of ``--abutment``.
    """
    options = [
        _keyword("bridge", BridgeOption, "osb1"),
        _keyword("abutment", AbutmentOption, abutment),
    ]
    for axis in AXES:
        text = f"{axis.description[0].upper()}{axis.description[1:]}"
        text = f"{text}, {axis.low:g} to {axis.high:g}."
        options.append(Opt(axis.name, float, text, axis.usual).parameter())

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = list(signature(command).parameters.values())[1:]

        @wraps(command)
        def with_choice(**values: Any) -> None:
            bridge, model = values.pop("bridge"), values.pop("abutment")
            chosen = {axis.name: values.pop(axis.name) for axis in AXES}
            command(VariantChoice(bridge=bridge, abutment=model, values=chosen), **values)

        return _with_parameters(with_choice, [*options, *own])

    return decorate


def _with_parameters(
    command: Callable[..., None], parameters: Sequence[Parameter]
) -> Callable[..., None]:
    """Set the parameters that typer reads from a command."""
    keywords = [each.replace(kind=Parameter.KEYWORD_ONLY) for each in parameters]
    vars(command)["__signature__"] = Signature(keywords)
    return command


def model_options(pairs: Sequence[str] | None) -> ModelOptions:
    """Return the modelling options with the changes of ``--set``.

    Raises:
        InputError: A key is unknown, or a value outside its limits.
    """
    return checked(ModelOptions, _keys_and_values(pairs), "--set")


def settings_and_options(
    pairs: Sequence[str] | None, named: Mapping[str, Any], accuracy: str = "default"
) -> tuple[AnalysisSettings, ModelOptions]:
    """Return the settings of the analysis and the modelling options.

    Args:
        pairs: Texts of ``--set``.
        named: Keys of the analysis that have an option of their own; None where it is not given.
        accuracy: Set of numerics; explicit keys override it.

    Raises:
        InputError: A key is unknown, or a value outside its limits.
    """
    keys = {field.name for field in fields(AnalysisSettings)}
    analysis = {key: value for key, value in named.items() if value is not None}
    model: dict[str, Any] = {}
    for key, value in _keys_and_values(pairs).items():
        (analysis if key in keys else model)[key] = value
    full = under_explicit_keys({"analysis": analysis, "model": model}, accuracy)
    settings = checked(AnalysisSettings, full["analysis"], "the options")
    return settings, checked(ModelOptions, full["model"], "--set")


def _keys_and_values(pairs: Sequence[str] | None) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for pair in pairs or ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"--set takes KEY=VALUE, got {shortened(pair)}")
        values[key.strip()] = parse_yaml(text, f"--set {shortened(pair)}")
    return values
