"""A group of commands whose modules are imported when one of their commands is called.

Each module has its commands in ``COMMANDS``, a tuple of functions. Their names and summaries, which
are all that the help of the group shows, are read from its syntax tree.
"""

import ast
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command


class DeferredGroup(TyperGroup):
    """Commands of some modules, followed by those that are there already.

    Attributes:
        modules: Dotted names of the modules, in the order of the help.
    """

    modules: ClassVar[tuple[str, ...]] = ()

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        later, self._module_of = dict(self.commands), dict[str, str]()
        self.commands.clear()
        for module in self.modules:
            for name, summary in _commands_in(module):
                self._module_of[name] = module
                self.add_command(TyperCommand(name, short_help=summary))
        self.commands.update(later)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, command and remaining arguments of what is called, now imported."""
        name, command, rest = super().resolve_command(ctx, args)
        if name in self._module_of:
            command = _imported(self._module_of[name], name)
        return name, command, rest


class _Command(TyperCommand):
    """A command that says in words what is wrong with an argument."""

    def make_context(self, info_name: Any, args: list[str], *given: Any, **named: Any) -> Any:
        """Return the context of the arguments, or refuse them: as JSON where that is asked for."""
        as_json = "--json" in args
        try:
            return super().make_context(info_name, args, *given, **named)
        except typer.BadParameter as error:
            error.message = error.message.replace("Value error, ", "")
            if as_json:
                # Here, because the help needs none of what it loads.
                from skewbridge.cli.output import emit_json

                emit_json({"status": "error", "message": error.format_message()})
            raise


def _imported(module: str, name: str) -> Any:
    functions = {_shown(each.__name__): each for each in import_module(module).COMMANDS}
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    alone.command(name, cls=_Command)(functions[name])
    return get_command(alone)


def _commands_in(module: str) -> Iterator[tuple[str, str]]:
    """Yield name and summary of each command of a module without importing it.

    Raises:
        ModuleNotFoundError: There is no such module.
    """
    spec = find_spec(module)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(module)
    tree = ast.parse(Path(spec.origin).read_bytes())
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    for node in tree.body:
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "COMMANDS":
            for element in getattr(node.value, "elts", ()):
                function = functions[ast.unparse(element)]
                yield _shown(function.name), (ast.get_docstring(function) or "").split("\n")[0]


def _shown(name: str) -> str:
    return name.replace("_", "-")
