"""Write the page of commands from the commands themselves: `python docs/commands_page.py`."""

from pathlib import Path

import typer
from typer.core import TyperArgument, TyperGroup, TyperOption
from typer.main import get_command

from skewbridge.cli import build_app

PAGE = Path(__file__).parent / "reference" / "commands.md"
HEAD = """\
# Commands

`skewbridge COMMAND --help` shows the same. Commands answer on stdout, with `--json` as one JSON
object; messages go to stderr. The exit code is 0 for an answer, 1 for an analysis or a check that
failed, and 2 for bad input. This page is written from the commands by `make docs`.
"""


def page() -> str:
    """Return the page as Markdown."""
    group = get_command(build_app())
    return HEAD + "".join(_sections(group, typer.Context(group, info_name="skewbridge")))


def _sections(group: typer.core.TyperCommand, context: typer.Context) -> list[str]:
    """Return a section for each command of a group, those of groups inside it last."""
    assert isinstance(group, TyperGroup)
    sections: list[str] = []
    for given in group.commands:
        name, command, _ = group.resolve_command(context, [given])
        inner = typer.Context(command, info_name=name, parent=context)
        if isinstance(command, TyperGroup):
            sections += _sections(command, inner)
        else:
            sections.append(_section(command, inner))
    return sections


def _section(command: typer.core.TyperCommand, context: typer.Context) -> str:
    usage = " ".join(command.collect_usage_pieces(context))
    text, _, example = (command.help or "").partition("Example: ")
    text = " ".join(text.split()) + (f" Example: `{example.strip()}`." if example else "")
    rows = [row for each in command.params if (row := _row(each, context))]
    table = "| argument or option | meaning |\n| --- | --- |\n" + "".join(rows)
    title = context.command_path
    return f"\n## {title}\n\n{text}\n\n    {title} {usage}\n" + (f"\n{table}" if rows else "")


def _row(parameter: TyperOption | TyperArgument, context: typer.Context) -> str:
    record = parameter.get_help_record(context)
    if record is None or record[0] == "--help":
        return ""
    name, meaning = (" ".join(part.split()).replace("|", "\\|") for part in record)
    return f"| `{name}` | {meaning} |\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
