"""A command as another program calls it."""

import json

from click.testing import Result
from typer.testing import CliRunner

from skewbridge.cli import build_app


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(build_app(), [*map(str, arguments)])


def run(*arguments: object) -> tuple[int, dict]:
    result = invoke(*arguments, "--json")
    return result.exit_code, json.loads(result.stdout)


def answer(*arguments: object, code: int = 0) -> dict:
    found_code, found = run(*arguments)
    assert found_code == code, found
    return found
