"""Write the page of commands from the commands themselves: `python docs/commands_page.py`."""

import re
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

`skewbridge COMMAND --help` shows the same. Results go to stdout, with `--json` (every command) as
one JSON object; messages go to stderr. Exit codes: 0 success, 1 an analysis or a check failed, 2
bad input. `make docs` writes this page.

## Shared options

"""
EVERYWHERE = "--json"
SHARED_BY = 3  # number of commands from which on a common option is described once
_DEFAULT = re.compile(r" ?\[(default: [^]]*|required)\]$")


def page() -> str:
    """Return the page as Markdown."""
    group = get_command(build_app())
    commands = list(_commands(group, typer.Context(group, info_name="skewbridge")))
    shared = _shared([row for _, rows in commands for row in rows])
    page = HEAD + "".join(
        _line(row) for name, row in reversed(shared.items()) if name != EVERYWHERE
    )
    for context, rows in commands:
        names, own = [], []
        for row in rows:
            name, usual = _name(row), shared.get(_name(row))
            if usual is None or _meaning(row) != _meaning(usual):
                own.append(row)
            elif name != EVERYWHERE:
                default = "" if row[1] == usual[1] else row[1].removeprefix(_meaning(row))
                names.append(f"`{name}`{default}")
        page += f"\n## {context.command_path}\n\n{_text(context)}\n"
        page += "\n" if names or own else ""
        page += f"- shared: {', '.join(names)}\n" if names else ""
        page += "".join(_line(row) for row in own)
    return page


def _shared(rows: list[tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Return the most common row of each option that several commands have, by its name."""
    count = Counter((_name(row), _meaning(row)) for row in rows)
    common = Counter(rows).most_common()
    return {
        name: next(row for row, _ in common if (_name(row), _meaning(row)) == (name, meaning))
        for (name, meaning), n in reversed(count.most_common())
        if n >= SHARED_BY
    }


def _name(row: tuple[str, str]) -> str:
    return row[0].split()[0].rstrip(",")


def _meaning(row: tuple[str, str]) -> str:
    return _DEFAULT.sub("", row[1])


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


def _text(context: typer.Context) -> str:
    """Return the description of a command, with its example as code if it has an argument."""
    text, _, example = (context.command.help or "").partition("Example: ")
    example = "" if example.strip() == context.command_path else example.strip()
    return " ".join(text.split()) + (f"\n\n    {example}" if example else "")


def _row(parameter: TyperOption | TyperArgument, context: typer.Context) -> tuple[str, str] | None:
    record = parameter.get_help_record(context)
    if record is None or record[0] == "--help":
        return None
    name, meaning = (" ".join(part.split()) for part in record)
    return re.sub(r" <(str|path|float|int|list\[\w+\])>", "", name), meaning


def _line(row: tuple[str, str]) -> str:
    return f"- `{row[0]}`: {row[1]}\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
