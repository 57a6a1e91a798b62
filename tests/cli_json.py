"""A command as another program calls it."""

import json

from click.testing import Result
from typer.testing import CliRunner

from skewbridge.cli import build_app


def invoke(*arguments: object) -> Result:
    """Run a command; its outputs and exit code are in the result."""
    return CliRunner().invoke(build_app(), [*map(str, arguments)])


def run(*arguments: object) -> tuple[int, dict]:
    """Return the exit code and the JSON answer of a command."""
    result = invoke(*arguments, "--json")
    return result.exit_code, json.loads(result.stdout)


def answer(*arguments: object, code: int = 0) -> dict:
    """Return the JSON answer of a command that must end with an exit code."""
    found_code, found = run(*arguments)
    assert found_code == code, found
    return found
