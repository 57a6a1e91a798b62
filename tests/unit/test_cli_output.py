"""How commands answer and fail: one JSON object or one table, one message and its exit code."""

import json

import pytest
import typer
from typer.testing import CliRunner

from skewbridge.cli.output import JsonOption, clear_errors, emit
from skewbridge.errors import InputError, SolutionError


def run(body, *arguments):
    app = typer.Typer()

    @app.command()
    @clear_errors
    def command(*, as_json: JsonOption = False) -> None:
        body(as_json)

    return CliRunner().invoke(app, arguments)


def refuse(error):
    def body(as_json):
        raise error

    return body


@pytest.mark.parametrize(
    ("error", "status", "code"),
    [
        (InputError("gap_mm must be >= 0, got -1", row=3), "error", 2),
        (SolutionError("OpenSees stopped at 1 s of 2 s"), "failed", 1),
    ],
)
def test_a_failure_is_one_message_and_an_exit_code(error, status, code):
    plain = run(refuse(error))
    assert plain.exit_code == code
    assert plain.stderr.splitlines() == [f"{status}: {error}"]
    answer = json.loads(run(refuse(error), "--json").stdout)
    assert answer == {"status": status, "message": str(error)} | getattr(error, "details", {})


def test_a_table_stands_for_the_object_and_leaves_out_long_lists():
    payload = {"peaks": {"ux_m": 0.1}, "theta": None, "ci": [1.0, 2.5], "spectrum": [1.0] * 60}
    assert json.loads(run(lambda j: emit(payload, as_json=j), "--json").stdout) == payload
    table = run(lambda j: emit(payload, as_json=j)).stdout
    assert "ux_m" in table
    assert "1, 2.5" in table
    assert "None" not in table
    assert "spectrum" not in table
