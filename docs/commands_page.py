"""Write the page of commands from the commands themselves: `python docs/commands_page.py`."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import typer
from typer.core import TyperArgument, TyperGroup, TyperOption
from typer.main import get_command

from skewbridge.cli import build_app

PAGE = Path(__file__).parent / "reference" / "commands.md"
HEAD = """\
# Commands

`skewbridge COMMAND --help` shows the same. Commands answer on stdout, with `--json` as one JSON
object; messages go to stderr. Exit codes: 0 for an answer, 1 for an analysis or a check that
failed, 2 for bad input. `make docs` writes this page.

## Shared options

"""
TABLE = "| argument or option | meaning |\n| --- | --- |\n"
SHARED_BY = 3  # commands with the same option, from which on the page describes it once


def page() -> str:
    """Return the page as Markdown."""
    group = get_command(build_app())
    commands = list(_commands(group, typer.Context(group, info_name="skewbridge")))
    count = Counter(row for _, rows in commands for row in rows)
    usual = {
        name: max((n, row) for row, n in count.items() if row[0] == name)[1] for name, _ in count
    }
    shared = [row for row, n in count.items() if n >= SHARED_BY and usual[row[0]] == row]
    page = HEAD + TABLE + "".join(_line(row) for row in shared)
    for context, rows in commands:
        names = ", ".join(f"`{name.split()[0]}`" for name, _ in rows if (name, _) in shared)
        own = "".join(_line(row) for row in rows if row not in shared)
        page += f"\n## {context.command_path}\n\n{_text(context.command)}\n"
        page += f"\nShared options: {names}.\n" if names else ""
        page += f"\n{TABLE}{own}" if own else ""
    return page


def _commands(
    group: typer.core.TyperCommand, context: typer.Context
) -> Iterator[tuple[typer.Context, list[tuple[str, str]]]]:
    """Yield each command of a group with the names and meanings of its arguments and options."""
    assert isinstance(group, TyperGroup)
    for given in group.commands:
        name, command, _ = group.resolve_command(context, [given])
        inner = typer.Context(command, info_name=name, parent=context)
        if isinstance(command, TyperGroup):
            yield from _commands(command, inner)
        else:
            rows = (_row(each, inner) for each in command.params)
            yield inner, [row for row in rows if row]


def _text(command: typer.core.TyperCommand) -> str:
    """Return the description of a command with its example as code."""
    text, _, example = (command.help or "").partition("Example: ")
    return " ".join(text.split()) + (f"\n\n    {example.strip()}" if example else "")


def _row(parameter: TyperOption | TyperArgument, context: typer.Context) -> tuple[str, str] | None:
    record = parameter.get_help_record(context)
    if record is None or record[0] == "--help":
        return None
    name, meaning = (" ".join(part.split()).replace("|", "\\|") for part in record)
    return name, meaning


def _line(row: tuple[str, str]) -> str:
    return f"| `{row[0]}` | {row[1]} |\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
