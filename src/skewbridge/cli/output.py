"""What all commands share: answers, errors and exit codes, and options on variants and studies."""

import json
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from pydantic_core import to_jsonable_python
from rich.console import Console
from rich.table import Table
from typer.core import TyperCommand

from skewbridge.analysis.settings import AnalysisSettings, under_explicit_keys
from skewbridge.errors import EXIT_BAD_INPUT, EXIT_FAILED, InputError, SolutionError
from skewbridge.files.text import (
    checked,
    parse_yaml,
    printable,
    read_json,
    read_yaml,
    shortened,
)
from skewbridge.units import Units, us_name, us_unit
from skewbridge.variant.axes import AXES, USUAL, unit_doubts
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant, lacking_axes

if TYPE_CHECKING:
    from skewbridge.study.config import StudyConfig

FILE_WIDTH: Final = 400  # characters per line in a file or pipe, so that no cell is truncated
NO_VALUE: Final = "-"  # printed for NaN; the reason follows below the table

type Row = Mapping[str, Any]

messages = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


@dataclass(frozen=True, slots=True)
class Answer:
    """Output of a command: a JSON value with ``--json``, otherwise tables or text.

    Single values are one table, each list of rows is another; long lists of numbers are not
    printed.
    """

    payload: Any  # JSON value, numbers in SI
    shown: Row | str | None = None  # printed instead of the payload; keys of lists are table titles
    notes: Sequence[str] = ()  # messages after the answer
    exit_code: int = 0
    missing: str = "not defined for these data"  # reason for missing values, printed below tables
    warnings: Sequence[str] = ()  # messages before the answer
    digits: int = 5  # significant digits of printed numbers

    def emit(self, *, as_json: bool, units: Units) -> None:
        """Print the answer, tables in ``units``, and its messages; exit with its code unless 0."""
        for text in self.warnings:
            messages.print(f"warning: {_text_in(text, units)}", style="yellow")
        shown = self.payload if self.shown is None else self.shown
        if as_json:
            emit_json(self.payload)
        elif isinstance(shown, str):
            typer.echo(shown)
        else:
            tables = _tables(shown, units).items()
            has_gaps = [emit_table(rows, title, self.digits) for title, rows in tables]
            if any(has_gaps):
                messages.print(f"{NO_VALUE}: {self.missing}")
        for note in self.notes:
            messages.print(_text_in(note, units))
        if self.exit_code:
            raise typer.Exit(self.exit_code)


def opt(text: str, metavar: str | None = None, *flags: str) -> Any:
    """Return an option with its help; without ``flags``, the parameter gives its name."""
    return typer.Option(*flags, help=text, metavar=metavar)


def arg(text: str, metavar: str | None = None) -> Any:
    """Return a positional argument with a help text."""
    return typer.Argument(help=text, metavar=metavar)


#: Type and default of the options of every command, which the help names below its own options.
_PRINTING: Final = {
    "as_json": (Annotated[bool, typer.Option("--json", hidden=True)], False),
    "units": (Annotated[Units, typer.Option("--units", hidden=True)], "si"),
}
_EPILOG: Final = "--json prints one JSON object on stdout; --units us shows kip, in and ft."


def command(group: typer.Typer, name: str | None = None) -> Callable[..., Callable[..., None]]:
    """Return a decorator that adds a function to a group as a command, which prints its `Answer`.

    A parameter whose type is a dataclass stands for one option per field. A function that draws has
    the parameter ``units``, which gets the value of ``--units``. An error is printed as one
    message; the exit code is 2 for bad input and unreadable files, 1 for a failed solution.
    """

    def decorate(function: Callable[..., Answer]) -> Callable[..., None]:
        grouped: dict[str, Any] = {}
        options: list[Parameter] = []
        parameters = dict(signature(function).parameters)
        draws = parameters.pop("units", None) is not None
        for option in parameters.values():
            kind, members = option.annotation, [option]
            if isinstance(kind, type) and is_dataclass(kind):
                grouped[option.name] = kind
                members = list(signature(kind).parameters.values())
            options += [member.replace(kind=Parameter.KEYWORD_ONLY) for member in members]

        @wraps(function)
        def called(*, as_json: bool, units: Units, **values: Any) -> None:
            status, code, details = "error", EXIT_BAD_INPUT, {}
            try:
                for option, kind in grouped.items():
                    members = {field.name: values.pop(field.name) for field in fields(kind)}
                    values[option] = kind(**members)
                if draws:
                    values["units"] = units
                return function(**values).emit(as_json=as_json, units=units)
            except InputError as error:
                message, details = str(error), error.details
            except OSError as error:
                message = f"{shortened(str(error.filename or ''))}: {error.strerror or error}"
            except SolutionError as error:
                status, code, message = "failed", EXIT_FAILED, str(error)
            if as_json:
                emit_json({"status": status, "message": message, **details})
            lines = map(printable, f"{status}: {message}".split("\n"))
            messages.print("\n".join(lines), style="red")
            raise typer.Exit(code)

        for option, (kind, default) in _PRINTING.items():
            options.append(
                Parameter(option, Parameter.KEYWORD_ONLY, default=default, annotation=kind)
            )
        vars(called)["__signature__"] = Signature(options)
        return group.command(name, cls=_Command, epilog=_EPILOG)(called)

    return decorate


class _Command(TyperCommand):
    """Command that reports invalid arguments in JSON too."""

    def make_context(self, info_name: Any, args: list[str], *extra: Any, **options: Any) -> Any:
        """Return the context of the arguments."""
        as_json = "--json" in args
        pairs = {name for option in self.params if option.nargs == 2 for name in option.opts}
        try:
            for i, option in enumerate(args):  # its two values must precede the next option
                for count, value in enumerate(args[i + 1 : i + 3] if option in pairs else ()):
                    if value.startswith("--"):
                        message = f"{option} takes two values, got {count} before {value}"
                        raise typer.BadParameter(message)
            return super().make_context(info_name, args, *extra, **options)
        except typer.TyperException as error:
            error.message = error.message.replace("Value error, ", "")
            if as_json:
                emit_json({"status": "error", "message": error.format_message()})
            raise


def emit_json(payload: object) -> None:
    """Write one JSON value and a newline to stdout; NaN and infinities become null."""
    values = to_jsonable_python(payload, inf_nan_mode="null", fallback=lambda array: array.tolist())
    sys.stdout.write(json.dumps(values) + "\n")


def _tables(shown: Row, units: Units) -> dict[str, Sequence[Row]]:
    """Return the tables of an answer by title; the table of single values has an empty title."""
    values: dict[str, Any] = {}
    tables: dict[str, Sequence[Row]] = {}
    for name, value in _flat(shown):
        if not isinstance(value, list | tuple):
            values[name] = value
        elif value and isinstance(value[0], Mapping):
            tables[name] = [in_units(row, units) for row in value]
        elif 0 < len(value) <= 12:  # in one cell
            values[name] = value
        elif value and isinstance(value[0], str):
            tables[name] = [{name: text} for text in value]
    values = {**in_units(values, units)}
    single_values = [{"quantity": name, "value": value} for name, value in values.items()]
    return {"": single_values, **tables} if single_values else tables


def _flat(values: Row, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield names and values of a nested mapping; inner names start with the outer names."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name} ")
        else:
            yield f"{prefix}{name}", value


def emit_table(rows: Sequence[Row], title: str = "", digits: int = 5) -> bool:
    """Print rows with equal keys as a table on stdout; return True if values are missing.

    With more than three times as many columns as rows, the table is transposed.
    """
    columns = {name: [_text(row[name], digits) for row in rows] for name in rows[0]}
    is_text = [isinstance(value, str) for value in rows[0].values()]
    lines = [list(columns), *zip(*columns.values(), strict=True)]
    if len(columns) > 3 * len(rows):
        lines, is_text = list(zip(*lines, strict=True)), [True, *[False] * len(rows)]
    table = Table(title=printable(title) or None)
    for heading, is_left in zip(lines[0], is_text, strict=True):
        table.add_column(
            printable(heading), justify="left" if is_left else "right", overflow="fold"
        )
    for line in lines[1:]:
        table.add_row(*map(printable, line))
    width = None if sys.stdout.isatty() else FILE_WIDTH
    Console(highlight=False, markup=False, emoji=False, width=width).print(table)
    return any(NO_VALUE in cell.split(", ") for texts in columns.values() for cell in texts)


def _text(value: object, digits: int) -> str:
    """Return a value as text: NaN as `NO_VALUE`, sizes below 1e-15 as 0, None as empty text."""
    if isinstance(value, list | tuple):
        return ", ".join(_text(element, digits) for element in value)
    if not isinstance(value, float):
        return "" if value is None else str(value)
    if isnan(value):
        return NO_VALUE
    return "0" if abs(value) < 1e-15 else f"{float(f'{value:.{digits}g}'):.5g}"


def selected(rows: Iterable[Row], *names: str) -> list[dict[str, Any]]:
    """Return the rows with only the named columns."""
    return [{name: row[name] for name in names} for row in rows]


_QUANTITY: Final = re.compile(r"\b(\d+(?:\.\d+)?) (mm|m|kN)\b(?![/2])")


def _text_in(text: str, units: Units) -> str:
    """Return a message with its lengths and forces in these units."""

    def converted(match: re.Match[str]) -> str:
        unit, factor = us_unit(match[2])
        return f"{float(f'{float(match[1]) * factor:.4g}'):g} {unit}"

    return _QUANTITY.sub(converted, text) if units == "us" else text


def in_units(row: Row, units: Units) -> Row:
    """Return a row with its numbers, and the units in its names, converted to these units.

    The name of a check has the unit of its demand and capacity, and may have a length in m.
    """
    if units == "si":
        return row
    if "check" in row:
        name, factor = us_name(row["check"])
        sizes = {key: _times(row[key], factor) for key in ("demand", "capacity")}
        return {**row, "check": _text_in(name, units), **sizes}
    converted = {key: us_name(key) for key in row}
    return {name: _times(row[key], factor) for key, (name, factor) in converted.items()}


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list | tuple):
        return [_times(element, factor) for element in value]
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * factor if is_number and factor != 1.0 else value


# --- Options that several commands share: a variant, a study, modelling keys, an output folder

#: The configuration of the default study; other configurations are merged over it.
DEFAULT_CONFIG: Final = Path("config/config.yaml")
_YAML: Final = (".yaml", ".yml")

Out = Annotated[Path, opt("Folder for the results.")]
LimitStates = Annotated[Path, opt("YAML file of limit states; default: of the study or package.")]
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
    from skewbridge.study.folder import StudyFolder, default_root

    stored = StudyFolder(study).configuration
    names = read_json(stored)["files"] if stored.is_file() else []
    paths = [path for path in map(Path, names) if path.is_file()]
    paths = paths or sorted(DEFAULT_CONFIG.parent.glob("*.yaml"))
    contents = {path: read_yaml(path) for path in paths}
    writers = [
        path
        for path, content in contents.items()
        if isinstance(content, Mapping)
        and Path(str(content.get("results", default_root(path)))).resolve() == study.resolve()
    ]
    if len(writers) == 1:
        return writers[0]
    subject = study if study.exists() else f"{study} does not exist"
    count = f"{len(writers)} files" if writers else "no file"
    raise InputError(
        f"{subject}: {count} in {DEFAULT_CONFIG.parent}/ with `results: {study}`; "
        "name the configuration of the study with --study FILE.yaml"
    )


def study_of(study: Path | None) -> "StudyConfig":
    """Return the configuration of a study, given its results folder or the file itself.

    Paths of a configuration are relative to the folder in which the study ran: `InputError` if this
    is not the working folder.
    """
    from skewbridge.study.config import load_config, stored_configuration

    config = None if study is None else stored_configuration(study)
    results = study and study.resolve()
    if config and results != Path(config.results).resolve():
        place = str(results).removesuffix(f"/{config.results}")
        place = f"in {place}" if place != str(results) else f"where it is still {config.results}"
        raise InputError(f"{study}: paths of the study are relative: run the command {place}")
    return config or load_config(config_of(study), base=DEFAULT_CONFIG)


def study_near(file: Path) -> Path:
    """Return the study that made a file: its folder or configuration, or the default one."""
    from skewbridge.study.folder import StudyFolder

    for folder in file.resolve().parents:
        if StudyFolder(folder).configuration.is_file():
            return folder
        with suppress(InputError):
            return config_of(folder)
    return DEFAULT_CONFIG


def with_ending(out: Path, ending: str) -> Path:
    """Return a path to write; `InputError` if it has another ending."""
    if out.suffix.lower() != ending:
        raise InputError(f"--out must end with {ending}, got {out.name}")
    return out


def folder_of(study: Path | None) -> Path:
    """Return the results folder of a study, given that folder or its configuration file."""
    if study is not None and study.suffix not in _YAML:
        return study
    from skewbridge.study.folder import DEFAULT_ROOT

    if study is None and not DEFAULT_CONFIG.is_file():
        return Path(DEFAULT_ROOT)
    return study_of(study).folder.root


_MODELS: Final = f"[{'|'.join(ABUTMENTS).replace('_', '-')}]"
Abutment = Annotated[str, opt("Abutment model, from simple to contact with friction.", _MODELS)]
Changes = Annotated[
    list[str] | None, opt("Value of an input key; repeatable.", "KEY=VALUE", "--set")
]
_AXIS: Final = {
    axis.name: opt(f"{axis.label_with_unit}, {axis.low:g} to {axis.high:g}.") for axis in AXES
}


DEFAULT_BRIDGE: Final = "osb1"


@dataclass(frozen=True, kw_only=True)
class VariantOptions:
    """Options of a command about one variant."""

    bridge: Annotated[
        str, opt("Name (skewbridge bridge list) or file of a bridge.", "NAME|FILE")
    ] = DEFAULT_BRIDGE
    abutment: Abutment = "contact-friction"
    skew_deg: Annotated[float, _AXIS["skew_deg"]] = USUAL["skew_deg"]
    gap_mm: Annotated[float, _AXIS["gap_mm"]] = USUAL["gap_mm"]
    friction: Annotated[float, _AXIS["friction"]] = USUAL["friction"]
    changes: Changes = None  # keys of model and analysis

    @property
    def variant(self) -> Variant:
        """The variant; raises `InputError` if a value is outside its limits."""
        from skewbridge.study.config import stated_values

        for text in unit_doubts([self.skew_deg], [self.gap_mm]):
            messages.print(f"warning: {text}", style="yellow")
        values = {axis.name: getattr(self, axis.name) for axis in AXES} | stated_values(self.bridge)
        abutment = self.abutment.replace("-", "_")
        for name in sorted(lacking_axes(abutment)):
            if values[name] != USUAL[name]:
                text = f"warning: {name} has no effect with abutment model {self.abutment}"
                messages.print(text, style="yellow")
        return Variant.at(self.bridge, abutment, values)

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


def gap_notes(bridge: str) -> list[str]:
    """Return notes on gap and skew that a bridge sets; none if it cannot be read."""
    from skewbridge.bridge.library import load_structure

    with suppress(InputError):
        return load_structure(bridge).description.axis_notes
    return []


def failure_notes(row: Row) -> list[str]:
    """Return a note that the demands of a row end at the failure of a column, if one fails."""
    if not row.get("beyond_model"):
        return []
    until = "a column fails in {beyond_model} at {beyond_model_s:.2f} s".format(**row)
    return [f"{until}: demands are peaks until then, histories and figures go on"]


def keys_and_values(option: str, pairs: list[str] | None) -> dict[str, Any]:
    """Return the KEY=VALUE pairs of a repeatable option as a dict; values are parsed as YAML."""
    values: dict[str, Any] = {}
    for pair in pairs or ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"{option} takes KEY=VALUE, got {shortened(pair)}")
        values[key.strip()] = parse_yaml(text, f"{option} {shortened(pair)}")
    return values
