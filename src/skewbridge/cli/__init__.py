"""Command line: arguments and output of each command; the other packages do the computing."""

import os
from importlib import import_module
from typing import Annotated, Any, Final

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_group

from skewbridge.study.processes import hush_exit_message

#: Module and summary of each command. Modules are imported when a command is called, so that the
#: help takes a tenth of a second.
COMMANDS: Final = {
    "doctor": ("run", "Check the environment: versions, OpenSees, a one-second self-test."),
    "init": ("study", "Write Snakefile, rules, configuration and motions of a study to a folder."),
    "demo": ("study", "Write the report of a small stored study to a folder, in seconds."),
    "plan": ("study", "Show the variants, analyses, cost and progress of a study."),
    "status": ("study", "Show how many analyses are done, failed and left, and the last failure."),
    "run": ("run", "Analyse one variant under one motion and draw its histories."),
    "bridge": ("bridge", "List, check, draw and push single bridges."),
    "motions": ("motions", "Read, check, measure, draw, select and synthesize ground motions."),
    "fit": ("fragility", "Fit a fragility curve: theta, beta, their intervals and a status."),
    "statistics": ("fragility", "Fit curves and effects to any table of demands."),
    "predict": ("fragility", "Predict fragility between the variants of a study."),
    "decide": ("fragility", "Find the seat length and joint gap that each skew needs."),
    "export": ("fragility", "Write fragility curves for other tools, spreadsheets and papers."),
    "compare": ("study", "Compare two studies run by run: ratios of demands and of medians."),
    "provenance": ("study", "Show where a result comes from and whether it is up to date."),
    "study": ("study", "Maintain and publish a study: retry, plot, methods, archive."),
    "contact": ("run", "Drive one contact unit along a displacement path."),
    "deck": ("run", "Run the rigid skew deck under a pulse or a record."),
    "verify": ("run", "Repeat the studies of the paper and compare with their references."),
}


class _Commands(TyperGroup):
    """Top-level command group; imports a command only when it is called."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        for name, (_, summary) in COMMANDS.items():
            self.add_command(TyperCommand(name, short_help=summary))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, imported command and remaining arguments."""
        name, _, arguments = super().resolve_command(ctx, args)
        module = import_module(f"{__name__}.{COMMANDS[str(name)][0]}")
        return name, get_group(module.commands).commands[str(name)], arguments


def new_group(**attributes: Any) -> typer.Typer:
    """Return an empty group of commands.

    Help is plain text, because importing rich, which draws boxes, takes longer than all the rest.
    """
    return typer.Typer(
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        **attributes,
    )


def build_app() -> typer.Typer:
    """Return the application with all commands."""
    app = new_group(cls=_Commands)
    app.callback()(_options)
    return app


def _show_version(is_asked: bool) -> None:
    if is_asked:
        from importlib.metadata import version

        typer.echo(f"skewbridge {version('skewbridge')}")
        raise typer.Exit


_VERSION: Final = typer.Option(
    "--version", help="Show the version and exit.", is_eager=True, callback=_show_version
)


def _options(*, version: Annotated[bool, _VERSION] = False) -> None:
    """Seismic fragility of bridges with seat-type abutments: skew, gap and contact-friction."""


def main() -> None:
    """Run the command line."""
    # the matrices of fits are small: a second thread doubles the processor time and saves nothing
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    hush_exit_message()
    build_app()()
