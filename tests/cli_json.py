"""A command as another program calls it."""

import json

from typer.testing import CliRunner

from skewbridge.cli import build_app


def run(*arguments: object) -> tuple[int, dict]:
    """Return the exit code and the JSON answer of a command."""
    result = CliRunner().invoke(build_app(), [*map(str, arguments), "--json"])
    return result.exit_code, json.loads(result.stdout)
