"""The command line: one module per group of commands, no mechanics."""

import typer

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.cli import bridge, contact, design, fragility, motions, run, study


def build_app() -> typer.Typer:
    """Return the application with all commands.

    Each module has its `COMMANDS` and imports its package inside them: `--help` stays fast.
    """
    app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
    group = typer.Typer(
        no_args_is_help=True, help="Read, check, measure, draw and make ground motions."
    )
    app.add_typer(group, name="motions")
    for module in (study, run, bridge, design, contact, fragility):
        for command in module.COMMANDS:
            app.command()(command)
    for command in motions.COMMANDS:
        group.command()(command)
    return app


def main() -> None:
    """Run the command line."""
    hush_exit_message()
    build_app()()
