"""Answers of the commands: a table or one JSON object on stdout, messages and exit codes."""

import json
import sys
from collections.abc import Mapping, Sequence
from math import isfinite, isnan
from typing import Annotated, Any, Final

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
ROUNDING: Final = 1e-12  # a number smaller than this share of its column is the noise of zero
NO_VALUE: Final = "-"  # printed for NaN; the reason follows below the table

JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]
UnitsOption = Annotated[
    Units,
    typer.Option("--units", help="Units of printed tables: SI, or kip, in, ft. Files stay SI."),
]

messages = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


class Command(TyperCommand):
    """A command that reports errors in one message, as JSON if asked, and sets the exit code.

    Bad input and unreadable files exit with 2, a solution that failed with 1.
    """

    def make_context(self, info_name: Any, args: list[str], *others: Any, **named: Any) -> Any:
        """Return the context of the arguments; report an argument that is wrong."""
        as_json = "--json" in args
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
        details: Mapping[str, Any] = {}
        try:
            return super().invoke(ctx)
        except InputError as error:
            status, code, details, message = "error", EXIT_BAD_INPUT, error.details, str(error)
        except SolutionError as error:
            status, code, message = "failed", EXIT_FAILED, str(error)
        except OSError as error:
            status, code = "error", EXIT_BAD_INPUT
            message = f"{shortened(str(error.filename or ''))}: {error.strerror or error}"
        if ctx.params.get("as_json"):
            emit_json({"status": status, "message": message} | dict(details))
        messages.print(_printable(f"{status}: {message}"), style="red")
        raise typer.Exit(code)

    def _check_pairs(self, args: list[str]) -> None:
        """Refuse an option of two values whose second value is the next option."""
        pairs = {name for option in self.params if option.nargs == 2 for name in option.opts}
        for at in (at for at, argument in enumerate(args) if argument in pairs):
            values = args[at + 1 : at + 3]
            given = next((n for n, value in enumerate(values) if value.startswith("--")), None)
            if given is not None:
                message = f"{args[at]} takes two values, got {given} before {values[given]}"
                raise typer.BadParameter(message)


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


def emit_json(payload: object) -> None:
    """Write one JSON value and a newline to stdout; NaN and infinities become null."""
    sys.stdout.write(json.dumps(_finite(payload), allow_nan=False) + "\n")


def emit(
    payload: Any,
    rows: Sequence[Mapping[str, Any]] | None = None,
    *,
    as_json: bool,
    title: str | None = None,
    units: Units = "si",
    missing: str = "not defined for these data",
) -> None:
    """Print the answer of a command.

    Args:
        payload: The JSON value of the answer.
        rows: The table to print instead; by default a row per number or text of the payload.
        as_json: Whether to print the JSON value.
        title: Title of the table.
        units: Units of the table; the JSON value is in SI.
        missing: Why a value of the table may be NaN.
    """
    if as_json:
        emit_json(payload)
        return
    table = in_units(_quantities(payload) if rows is None else rows, units)
    emit_table(table, title, missing=missing)


def emit_table(
    rows: Sequence[Mapping[str, Any]],
    title: str | None = None,
    *,
    missing: str = "not defined for these data",
) -> None:
    """Print rows (all with the keys of the first) as a table on stdout; explain missing values."""
    table = Table(title=None if title is None else Text(_printable(title)))
    noise = {column: _noise(rows, column) for column in (rows[0] if rows else ())}
    for column in noise:
        table.add_column(
            Text(_printable(column)),
            justify="left" if isinstance(rows[0][column], str) else "right",
            overflow="fold",
        )
    cells = [[number(value, noise.get(key, 0.0)) for key, value in row.items()] for row in rows]
    for row in cells:
        table.add_row(*(Text(_printable(cell)) for cell in row))
    Console(highlight=False, width=None if sys.stdout.isatty() else FILE_WIDTH).print(table)
    if any(NO_VALUE in cell.split("..") for row in cells for cell in row):
        messages.print(f"{NO_VALUE}: {missing}")


def number(value: object, noise: float = 0.0, form: str = ".5g") -> str:
    """Return a value as text: NaN as `NO_VALUE`, noise of zero as 0, None as nothing."""
    if isinstance(value, list):
        return ", ".join(number(item, noise, form) for item in value)
    if value is None:
        return ""
    if isinstance(value, float):
        return NO_VALUE if isnan(value) else "0" if abs(value) < noise else f"{value:{form}}"
    return str(value)


def _quantities(payload: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row per value, including those of inner mappings, without long lists."""
    flat: dict[str, Any] = {}
    for name, value in payload.items():
        flat |= value if isinstance(value, Mapping) else {name: value}
    return [
        {"quantity": name, "value": value}
        for name, value in flat.items()
        if not isinstance(value, list) or 0 < len(value) <= LONGEST_LIST
    ]


def _noise(rows: Sequence[Mapping[str, Any]], column: str) -> float:
    """Return the size below which numbers of a column are zero with rounding errors."""
    if column == "value":  # each row is a quantity of its own
        return 0.0
    values = [row.get(column) for row in rows]
    sizes = [abs(value) for value in values if isinstance(value, float) and isfinite(value)]
    return ROUNDING * max(sizes, default=0.0)


def _printable(text: str) -> str:
    """Return a text without the control characters of a terminal; line breaks are kept."""
    return "".join(sign if sign.isprintable() or sign == "\n" else "?" for sign in text)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, str):
        return value
    if isinstance(value, Sequence):
        return [_finite(item) for item in value]
    if hasattr(value, "tolist"):
        return _finite(value.tolist())
    if isinstance(value, float) and not isfinite(value):
        return None
    return value


_KNM: Final = KN / (KIP * FOOT)
#: Ending of a name -> ending in US units, factor; the longer endings first.
_US_UNITS: Final = {
    "_kn_per_m": ("_kip_per_in", KN / KIP * INCH),
    "_per_m": ("_per_in", INCH),
    "length_m": ("length_ft", 1.0 / FOOT),
    "_mps2": ("_in_per_s2", 1.0 / INCH),
    "_mps": ("_in_per_s", 1.0 / INCH),
    "_knm": ("_kip_ft", _KNM),
    "_kj": ("_kip_ft", KJ / (KIP * FOOT)),
    "_kn": ("_kip", KN / KIP),
    "_mm": ("_in", MM / INCH),
    "_m": ("_in", 1.0 / INCH),
    " (m)": (" (in)", 1.0 / INCH),
}


def in_units(rows: Sequence[Mapping[str, Any]], units: Units) -> list[dict[str, Any]]:
    """Return the rows of a table with heads and numbers in these units.

    The unit of a number is the ending of its column's name, or of the name of its row where the
    rows are quantities or checks.
    """
    return [dict(row) if units == "si" else _in_us_units(row) for row in rows]


def _in_us_units(row: Mapping[str, Any]) -> dict[str, Any]:
    label = next((key for key in ("quantity", "check", "of a column") if key in row), None)
    if label is not None:
        name, factor = _us_unit(str(row[label]))
        without_unit = ("ratio", "ok")  # columns of a check
        return {
            key: name if key == label else value if key in without_unit else _times(value, factor)
            for key, value in row.items()
        }
    converted = ((_us_unit(key), value) for key, value in row.items())
    return {name: _times(value, factor) for (name, factor), value in converted}


def _us_unit(name: str) -> tuple[str, float]:
    for ending, (replacement, factor) in _US_UNITS.items():
        if name.endswith(ending):
            return name.removesuffix(ending) + replacement, factor
    return name, 1.0


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_times(item, factor) for item in value]
    if factor == 1.0 or isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return value * factor
