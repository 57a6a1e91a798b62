"""What every command shares: one JSON object on stdout, messages on stderr, exit codes."""

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from math import isfinite
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from skewbridge.cli.us_units import Units, in_units
from skewbridge.errors import InputError, SolutionError
from skewbridge.reading import shortened

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
LONGEST_LIST = 3  # values in one cell of a table
FILE_WIDTH = 400  # characters of a line that goes to a file or a pipe: nothing is cut off
ROUNDING = 1e-12  # of the largest number of a column, below which a number is the noise of zero

JsonOption = Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")]

messages = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


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
) -> None:
    """Answer a command.

    Args:
        payload: The JSON value of the answer.
        rows: Table in its place; by default a row per number or text of the payload, a mapping.
        as_json: Whether the answer is the JSON value.
        title: Of the table.
        units: Of the table; the JSON value is in SI.
    """
    if as_json:
        emit_json(payload)
        return
    emit_table(in_units(_quantities(payload) if rows is None else rows, units), title)


def emit_table(rows: Sequence[Mapping[str, Any]], title: str | None = None) -> None:
    """Print rows (all with the keys of the first) as a table on stdout."""
    table = Table(title=None if title is None else Text(_printable(title)))
    noise = {column: _noise(rows, column) for column in (rows[0] if rows else ())}
    for column in noise:
        table.add_column(
            Text(_printable(column)),
            justify="left" if isinstance(rows[0][column], str) else "right",
            overflow="fold",
        )
    for row in rows:
        cells = (_cell(value, noise.get(column, 0.0)) for column, value in row.items())
        table.add_row(*(Text(_printable(cell)) for cell in cells))
    Console(highlight=False, width=None if sys.stdout.isatty() else FILE_WIDTH).print(table)


def clear_errors[**P, R](command: Callable[P, R]) -> Callable[P, R]:
    """End a command with one message: exit code 2 for bad input, 1 for a solution that failed.

    A file that cannot be read or written is bad input.
    """

    @wraps(command)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return command(*args, **kwargs)
        except InputError as error:
            status, code, details = "error", EXIT_BAD_INPUT, error.details
            message = str(error)
        except SolutionError as error:
            status, code, details = "failed", EXIT_FAILED, {}
            message = str(error)
        except OSError as error:
            status, code, details = "error", EXIT_BAD_INPUT, {}
            message = f"{shortened(str(error.filename or ''))}: {error.strerror or error}"
        if kwargs.get("as_json"):
            emit_json({"status": status, "message": message} | details)
        messages.print(_printable(f"{status}: {message}"), style="red")
        raise typer.Exit(code)

    return wrapped


def _quantities(payload: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row per value, those of an inner mapping by themselves, without long lists."""
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
    if column == "value":  # rows are quantities of their own
        return 0.0
    values = [row.get(column) for row in rows]
    sizes = [abs(value) for value in values if isinstance(value, float) and isfinite(value)]
    return ROUNDING * max(sizes, default=0.0)


def _cell(value: object, noise: float) -> str:
    if isinstance(value, list):
        return ", ".join(_cell(item, noise) for item in value)
    if value is None:
        return ""
    if isinstance(value, float):
        return "0" if abs(value) < noise else f"{value:.5g}"
    return str(value)


def _printable(text: str) -> str:
    """Return a text without the control characters that steer a terminal; lines stay lines."""
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
    if isinstance(value, float) and not (float("-inf") < value < float("inf")):
        return None
    return value
