"""The command line: one module per group of commands, no mechanics."""

from typing import Annotated

import typer

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.cli.deferred import DeferredGroup


class _Commands(DeferredGroup):
    modules = (
        "skewbridge.cli.start",
        "skewbridge.cli.study",
        "skewbridge.cli.provenance",
        "skewbridge.cli.run",
        "skewbridge.cli.bridge",
        "skewbridge.cli.design",
        "skewbridge.cli.contact",
        "skewbridge.cli.fragility",
        "skewbridge.cli.statistics",
        "skewbridge.cli.compare",
        "skewbridge.cli.publish",
    )


class _MotionCommands(DeferredGroup):
    modules = ("skewbridge.cli.motions",)


class _BridgeCommands(DeferredGroup):
    modules = ("skewbridge.cli.bridge_check",)


def build_app() -> typer.Typer:
    """Return the application with all commands.

    Its help is plain text, because the library that draws boxes takes longer to import than all
    the rest.
    """
    app = typer.Typer(
        cls=_Commands,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    app.callback()(_options)
    for name, kind, told in (
        ("bridge", _BridgeCommands, "Check a bridge of your own before any study."),
        ("motions", _MotionCommands, "Read, check, measure, draw and make ground motions."),
    ):
        app.add_typer(typer.Typer(cls=kind, no_args_is_help=True, help=told), name=name)
    return app


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"skewbridge {version('skewbridge')}")
        raise typer.Exit


def _options(
    *,
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show the version and exit.", is_eager=True, callback=_show_version
        ),
    ] = False,
) -> None:
    """Seismic fragility of bridges with seat-type abutments: skew, gap and contact-friction."""


def main() -> None:
    """Run the command line."""
    hush_exit_message()
    build_app()()
