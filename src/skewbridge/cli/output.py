"""What every command shares: one JSON object on stdout, messages on stderr, exit codes."""

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from skewbridge.errors import InputError

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2

JsonOption = Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")]

messages = Console(stderr=True, highlight=False, soft_wrap=True)


def emit_json(payload: object) -> None:
    """Write one JSON value and a newline to stdout; NaN and infinities become null."""
    sys.stdout.write(json.dumps(_finite(payload), allow_nan=False) + "\n")


def emit_table(rows: Sequence[Mapping[str, Any]], title: str | None = None) -> None:
    """Print rows (all with the keys of the first) as a table on stdout."""
    table = Table(title=title)
    for column in rows[0] if rows else ():
        table.add_column(column, justify="left" if isinstance(rows[0][column], str) else "right")
    for row in rows:
        table.add_row(*(_cell(value) for value in row.values()))
    Console(highlight=False).print(table)


def clear_errors[**P, R](command: Callable[P, R]) -> Callable[P, R]:
    """Turn an `InputError` of a command into one message on stderr and exit code 2."""

    @wraps(command)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return command(*args, **kwargs)
        except InputError as error:
            if kwargs.get("as_json"):
                emit_json(
                    {"status": "error", "message": str(error)} | getattr(error, "details", {})
                )
            messages.print(f"error: {error}", style="red", markup=False)
            raise typer.Exit(EXIT_BAD_INPUT) from error

    return wrapped


def _cell(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


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
