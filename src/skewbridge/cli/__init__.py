"""The command line: one module per group of commands, no mechanics."""

import typer

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.cli.deferred import DeferredGroup


class _Commands(DeferredGroup):
    modules = (
        "skewbridge.cli.study",
        "skewbridge.cli.run",
        "skewbridge.cli.bridge",
        "skewbridge.cli.design",
        "skewbridge.cli.contact",
        "skewbridge.cli.fragility",
        "skewbridge.cli.statistics",
    )


class _MotionCommands(DeferredGroup):
    modules = ("skewbridge.cli.motions",)


def build_app() -> typer.Typer:
    """Return the application with all commands.

    Its help is plain text, because the library that draws boxes takes longer to import than all
    the rest.
    """
    app = typer.Typer(
        cls=_Commands,
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    group = typer.Typer(
        cls=_MotionCommands,
        no_args_is_help=True,
        help="Read, check, measure, draw and make ground motions.",
    )
    app.add_typer(group, name="motions")
    return app


def main() -> None:
    """Run the command line."""
    hush_exit_message()
    build_app()()
