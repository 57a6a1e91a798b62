"""Commands and their answers: tables or one JSON value on stdout, messages, exit codes."""

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from inspect import Parameter, Signature
from math import isfinite, isnan
from typing import Annotated, Any, Final, NamedTuple, Self

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text
from typer.core import TyperCommand

from skewbridge.errors import EXIT_BAD_INPUT, EXIT_FAILED, InputError, SolutionError
from skewbridge.files.text import shortened
from skewbridge.units import FOOT, INCH, KIP, KJ, KN, MM, Units

LONGEST_LIST: Final = 3  # values in one cell of a table
FILE_WIDTH: Final = 400  # characters of a line in a file or a pipe, so that nothing is cut off
ROUNDING: Final = 1e-12  # numbers below this share of the largest in a column count as zero
NO_VALUE: Final = "-"  # printed for NaN; the reason follows below the table

type Row = Mapping[str, Any]

messages = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


def warn(text: str) -> None:
    """Print a warning on stderr."""
    messages.print(f"warning: {text}", style="yellow")


class Printed(NamedTuple):
    """Rows of a printed table, all with the same keys, and the reason for missing values."""

    rows: Sequence[Row]
    title: str | None = None
    missing: str = "not defined for these data"

    @classmethod
    def of(
        cls, heads: Sequence[str], rows: Iterable[Sequence[Any]], title: str | None = None
    ) -> Self:
        """Return a table of values under some heads."""
        return cls([dict(zip(heads, row, strict=True)) for row in rows], title)


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a command: a JSON value for ``--json``, else tables or texts.

    Without ``printed``, a table has a row per number or text of the JSON value. With ``--json``
    texts go to stderr, and tables are left out.
    """

    payload: Any  # in SI
    printed: Sequence[Printed | str] | None = None
    units: Units = "si"  # of the tables
    notes: Sequence[str] = ()  # messages after the answer
    exit_code: int = 0

    def emit(self, *, as_json: bool) -> None:
        """Print the answer and its notes; leave with its exit code."""
        if as_json:
            emit_json(self.payload)
        show_text = messages.print if as_json else typer.echo
        parts = [Printed(quantities(self.payload))] if self.printed is None else self.printed
        for part in parts:
            if isinstance(part, str):
                show_text(part)
            elif not as_json:
                emit_table(part._replace(rows=in_units(part.rows, self.units)))
        for note in self.notes:
            messages.print(note)
        if self.exit_code:
            raise typer.Exit(self.exit_code)


class Opt(NamedTuple):
    """One option of a command."""

    name: str  # of the argument; the option is that with hyphens, after `--`
    kind: Any  # type of the value
    help: str
    default: Any = None  # `...` for an option that must be given
    metavar: str | None = None  # what the help shows for the value
    complete: Callable[[], list[str]] | None = None  # returns the values for shell completion
    flags: str = ""  # the option and other names of it, where it is not that of the name

    def declared(self, **shown: Any) -> Any:
        """Return the option with its flags as typer declares it."""
        flags = self.flags or f"--{self.name.replace('_', '-')}"
        return typer.Option(*flags.split(), **shown)

    def parameter(self) -> Parameter:
        """Return the option as a parameter of the function of a command."""
        given = self.declared(help=self.help, metavar=self.metavar, autocompletion=self.complete)
        default = Parameter.empty if self.default is ... else self.default
        kind = Annotated[self.kind, given]
        return Parameter(self.name, Parameter.KEYWORD_ONLY, annotation=kind, default=default)


class Arg(Opt):
    """One argument of a command, without flags."""

    def declared(self, **shown: Any) -> Any:
        """Return the argument as typer declares it."""
        return typer.Argument(**shown)


UNITS: Final = Opt(
    "units", Units, "Units of printed tables: SI, or kip, in, ft. Files stay SI.", "si"
)
_JSON: Final = Opt("as_json", bool, "Print one JSON object on stdout.", False, flags="--json")


def new_group(name: str | None = None, summary: str = "") -> typer.Typer:
    """Return an empty group of commands."""
    return typer.Typer(
        name=name,
        help=summary,
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )


def command(
    group: typer.Typer, *options: Opt, name: str | None = None
) -> Callable[[Callable[..., Answer]], Callable[..., None]]:
    """Add a function to a group as a command that prints its answer.

    Options and arguments are passed by name.
    """

    def decorate(function: Callable[..., Answer]) -> Callable[..., None]:
        @wraps(function)
        def called(*, as_json: bool, **values: Any) -> None:
            function(**values).emit(as_json=as_json)

        given = {option.name: option.parameter() for option in (*options, _JSON)}
        vars(called)["__signature__"] = Signature(list(given.values()))
        return group.command(name, cls=Command)(called)

    return decorate


class Command(TyperCommand):
    """A command that reports errors in one message, as JSON if asked, and sets the exit code.

    Bad input and unreadable files exit with 2, a solution that failed with 1.
    """

    def make_context(self, info_name: Any, args: list[str], *others: Any, **named: Any) -> Any:
        """Return the context of the arguments; report an argument that is wrong."""
        as_json = "--json" in args  # the parser empties the list
        try:
            self._check_pairs(args)
            return super().make_context(info_name, args, *others, **named)
        except typer.TyperException as error:
            error.message = error.message.replace("Value error, ", "")
            if as_json:
                emit_json({"status": "error", "message": error.format_message()})
            raise

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        status, code, details = "error", EXIT_BAD_INPUT, {}
        try:
            return super().invoke(ctx)
        except InputError as error:
            message, details = str(error), error.details
        except OSError as error:
            message = f"{shortened(str(error.filename or ''))}: {error.strerror or error}"
        except SolutionError as error:
            status, code, message = "failed", EXIT_FAILED, str(error)
        if ctx.params["as_json"]:
            emit_json({"status": status, "message": message, **details})
        messages.print(_printable(f"{status}: {message}"), style="red")
        raise typer.Exit(code)

    def _check_pairs(self, args: list[str]) -> None:
        """Refuse an option of two values if the next option follows too early."""
        pairs = {name for option in self.params if option.nargs == 2 for name in option.opts}
        for at, argument in enumerate(args):
            for given, value in enumerate(args[at + 1 : at + 3] if argument in pairs else ()):
                if value.startswith("--"):
                    message = f"{argument} takes two values, got {given} before {value}"
                    raise typer.BadParameter(message)


def emit_json(payload: object) -> None:
    """Write one JSON value and a newline to stdout; NaN and infinities become null."""
    sys.stdout.write(json.dumps(_finite(payload), allow_nan=False) + "\n")


def emit_table(table: Printed) -> None:
    """Print a table on stdout; explain missing values on stderr."""
    drawn = Table(title=None if table.title is None else Text(_printable(table.title)))
    columns: list[list[str]] = []
    for name, first in (table.rows[0] if table.rows else {}).items():
        side = "left" if isinstance(first, str) else "right"
        drawn.add_column(Text(_printable(name)), justify=side, overflow="fold")
        columns.append(_texts(name, [row[name] for row in table.rows]))
    for row in zip(*columns, strict=True):
        drawn.add_row(*(Text(_printable(cell)) for cell in row))
    Console(highlight=False, width=None if sys.stdout.isatty() else FILE_WIDTH).print(drawn)
    if any(NO_VALUE in cell.split("..") for column in columns for cell in column):
        messages.print(f"{NO_VALUE}: {table.missing}")


def _texts(name: str, values: Sequence[Any]) -> list[str]:
    """Return the values of a column as texts; numbers that are rounding errors of zero become 0."""
    sizes = [abs(value) for value in values if isinstance(value, float) and isfinite(value)]
    # in a column named value, each row is a quantity of its own
    noise = 0.0 if name == "value" else ROUNDING * max(sizes, default=0.0)
    return [number(value, noise) for value in values]


def number(value: object, noise: float = 0.0, form: str = ".5g") -> str:
    """Return a value as text: NaN as `NO_VALUE`, noise of zero as 0, None as nothing."""
    if isinstance(value, list):
        return ", ".join(number(item, noise, form) for item in value)
    if not isinstance(value, float):
        return "" if value is None else str(value)
    if isnan(value):
        return NO_VALUE
    return "0" if abs(value) < noise else f"{value:{form}}"


def quantities(payload: Row) -> list[dict[str, Any]]:
    """Return a row per value, including those of inner mappings, without long lists."""
    flat: dict[str, Any] = {}
    for name, value in payload.items():
        flat |= value if isinstance(value, Mapping) else {name: value}
    return [
        {"quantity": name, "value": value}
        for name, value in flat.items()
        if not isinstance(value, list) or 0 < len(value) <= LONGEST_LIST
    ]


def _printable(text: str) -> str:
    """Return a text without the control characters of a terminal; line breaks are kept."""
    return "".join(sign if sign.isprintable() or sign == "\n" else "?" for sign in text)


def _finite(value: Any) -> Any:
    """Return plain values with None for NaN and infinities."""
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return _finite(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value


#: Ending of a name -> ending in US units, factor; the longer endings first.
_US_UNITS: Final = {
    "_kn_per_m": ("_kip_per_in", KN / KIP * INCH),
    "_per_m": ("_per_in", INCH),
    "length_m": ("length_ft", 1.0 / FOOT),
    "_mps2": ("_in_per_s2", 1.0 / INCH),
    "_mps": ("_in_per_s", 1.0 / INCH),
    "_knm": ("_kip_ft", KN / (KIP * FOOT)),
    "_kj": ("_kip_ft", KJ / (KIP * FOOT)),
    "_kn": ("_kip", KN / KIP),
    "_mm": ("_in", MM / INCH),
    "_m": ("_in", 1.0 / INCH),
    " (m)": (" (in)", 1.0 / INCH),
}
#: Columns that name the quantity of a row; the ending of that name is the unit of its numbers.
_NAMES: Final = ("quantity", "check", "of a column")
_WITHOUT_UNIT: Final = ("ratio", "ok")


def in_units(rows: Sequence[Row], units: Units) -> Sequence[Row]:
    """Return the rows of a table with heads and numbers in these units.

    The unit of a number is the ending of its column's name, or of the name of its row where the
    rows are quantities or checks.
    """
    return rows if units == "si" else [_in_us_units(row) for row in rows]


def _in_us_units(row: Row) -> Row:
    converted: dict[str, Any] = {}
    label = next((key for key in _NAMES if key in row), None)
    if label is None:
        for key, value in row.items():
            name, factor = _us_unit(key)
            converted[name] = _times(value, factor)
        return converted
    name, factor = _us_unit(str(row[label]))
    for key, value in row.items():
        converted[key] = value if key in _WITHOUT_UNIT else _times(value, factor)
    return converted | {label: name}


def _us_unit(name: str) -> tuple[str, float]:
    for ending, (replacement, factor) in _US_UNITS.items():
        if name.endswith(ending):
            return name.removesuffix(ending) + replacement, factor
    return name, 1.0


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_times(item, factor) for item in value]
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * factor if is_number and factor != 1.0 else value
