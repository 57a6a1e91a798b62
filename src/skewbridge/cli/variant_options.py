"""The options that name one variant and how it is modelled, made from the axes and the keys."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from skewbridge.analysis.accuracy import under_explicit_keys
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.reading import checked, parse_yaml, shortened
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import AXES, Axis
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

ABUTMENT_NAMES: Final = tuple(name.replace("_", "-") for name in ABUTMENTS)
ABUTMENT_CHOICES: Final = f"[{'|'.join(ABUTMENT_NAMES)}]"


def bridges_of_the_user() -> list[str]:
    """Return what a shell may offer as the name of a bridge."""
    from skewbridge.bridge.catalogue import bridge_names
    from skewbridge.bridge.catalogue.loading import OWN_FOLDER

    return [*bridge_names(), *(path.stem for path in sorted(OWN_FOLDER.glob("*.yaml")))]


BridgeOption = Annotated[
    str,
    typer.Option(
        "--bridge",
        help="Name of a bridge, e.g. osb1, or path of its file.",
        metavar="NAME|FILE",
        autocompletion=bridges_of_the_user,
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


def takes_variant(*, abutment: str = "contact-friction") -> Callable[..., Any]:
    """Give a command one option per axis; it gets them as its first argument, a `VariantChoice`.

    Args:
        abutment: Default of ``--abutment``.
    """
    options = [
        _option("bridge", BridgeOption, "osb1"),
        _option("abutment", AbutmentOption, abutment),
        *(_axis_option(axis) for axis in AXES),
    ]

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = list(signature(command).parameters.values())[1:]
        parameters = [*options, *(each.replace(kind=Parameter.KEYWORD_ONLY) for each in own)]

        @wraps(command)
        def with_choice(**given: Any) -> None:
            bridge, model = given.pop("bridge"), given.pop("abutment")
            values = {axis.name: given.pop(axis.name) for axis in AXES}
            command(VariantChoice(bridge=bridge, abutment=model, values=values), **given)

        vars(with_choice)["__signature__"] = Signature(parameters)
        return with_choice

    return decorate


def model_options(pairs: Sequence[str] | None) -> ModelOptions:
    """Return the modelling options with what ``--set`` changes.

    Raises:
        InputError: A key is none of them, or a value outside its limits.
    """
    return checked(ModelOptions, _chosen(pairs), "--set")


def settings_and_options(
    pairs: Sequence[str] | None, named: Mapping[str, Any], accuracy: str = "default"
) -> tuple[AnalysisSettings, ModelOptions]:
    """Return the settings of the analysis and the modelling options with what is chosen.

    Args:
        pairs: Texts of ``--set``.
        named: Keys of the analysis that have an option of their own; None where it is not given.
        accuracy: Set of numerics below all these keys.

    Raises:
        InputError: A key is unknown, or a value outside its limits.
    """
    chosen, keys = _chosen(pairs), {field.name for field in fields(AnalysisSettings)}
    given = {key: value for key, value in named.items() if value is not None}
    analysis = given | {key: value for key, value in chosen.items() if key in keys}
    model = {key: value for key, value in chosen.items() if key not in keys}
    full = under_explicit_keys({"analysis": analysis, "model": model}, accuracy)
    settings = checked(AnalysisSettings, full["analysis"], "the options")
    return settings, checked(ModelOptions, full["model"], "--set")


def _chosen(pairs: Sequence[str] | None) -> dict[str, Any]:
    chosen: dict[str, Any] = {}
    for pair in pairs or ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"--set takes KEY=VALUE, got {shortened(pair)}")
        chosen[key.strip()] = parse_yaml(text, f"--set {shortened(pair)}")
    return chosen


def _option(name: str, annotation: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=default)


def _axis_option(axis: Axis) -> Parameter:
    text = f"{axis.description[0].upper()}{axis.description[1:]}, {axis.low:g} to {axis.high:g}."
    option = typer.Option(f"--{axis.name.replace('_', '-')}", help=text)
    return _option(axis.name, Annotated[float, option], axis.usual)
