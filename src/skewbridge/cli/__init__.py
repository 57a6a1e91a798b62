"""The command line: one module per group of commands, no mechanics."""

import importlib
from typing import Final

import typer

from skewbridge.analysis.exit_message import hush_exit_message

# Each module has `register(app)` and imports its package inside the commands: `--help` stays fast.
COMMAND_MODULES: Final = ("study", "run", "bridge", "contact", "motions", "fragility")


def build_app() -> typer.Typer:
    """Return the application with all commands."""
    app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    for name in COMMAND_MODULES:
        importlib.import_module(f"skewbridge.cli.{name}").register(app)
    return app


def main() -> None:
    """Run the command line."""
    hush_exit_message()
    build_app()()
