"""How commands answer and fail: one JSON object or one table, one message and its exit code."""

import json
import sys
from typing import Annotated

import pytest
from typer.testing import CliRunner

from skewbridge.__main__ import main
from skewbridge.cli import new_group
from skewbridge.cli.output import Answer, command, in_units, opt
from skewbridge.errors import InputError, SolutionError


def run(answer, *arguments):
    app = new_group()

    @command(app)
    def given() -> Answer:
        if isinstance(answer, Exception):
            raise answer
        return answer

    return CliRunner().invoke(app, arguments)


@pytest.mark.parametrize(
    ("error", "status", "code"),
    [
        (InputError("gap_mm must be >= 0, got -1", row=3), "error", 2),
        (SolutionError("OpenSees stopped at 1 s of 2 s"), "failed", 1),
    ],
)
def test_a_failure_is_one_message_and_an_exit_code(error, status, code):
    plain = run(error)
    assert (plain.exit_code, plain.stderr.splitlines()) == (code, [f"{status}: {error}"])
    answer = json.loads(run(error, "--json").stdout)
    assert answer == {"status": status, "message": str(error)} | getattr(error, "details", {})


def test_a_table_lists_values_noise_missing_ones_and_long_texts():
    payload = {"peaks": {"ux_m": 0.1}, "theta": None, "ci": [1.0, 2.5], "spectrum": [1.0] * 60}
    assert json.loads(run(Answer(payload), "--json").stdout) == payload
    table = run(Answer(payload)).stdout
    assert "1, 2.5" in table
    assert "None" not in table
    assert "spectrum" not in table
    rows = [{"mass_x": 0.7, "rate": 2e-9}, {"mass_x": 7e-32, "rate": 1e-9}]
    shown = run(Answer({"modes": rows})).stdout
    assert "e-32" not in shown
    assert "1e-09" in shown
    assert "3e-13" in run(Answer({"work_kj": 1e5, "residual": 3e-13})).stdout
    rows = [{"state": "slight", "theta": 0.5}, {"state": "complete", "theta": float("nan")}]
    shown = run(Answer({}, {"medians": rows}, missing="no run reached the state"))
    assert "nan" not in shown.stdout
    assert "-: no run reached the state" in shown.stderr
    assert not run(Answer({}, {"medians": rows[:1]}, missing="why")).stderr
    long = "column_residual_drift_ratio_of_a_long_name"
    assert run(Answer({"rows": [dict.fromkeys("abcdef", long)]})).stdout.count(long) == 6


def test_an_option_of_two_values_does_not_take_the_next_option():
    app = new_group()

    @command(app)
    def given(pair: Annotated[tuple[str, str], opt("")], out: Annotated[str, opt("")]) -> Answer:
        return Answer({"pair": pair, "out": out})

    refused = CliRunner().invoke(app, ["--pair", "a", "--out", "b", "--json"])
    assert refused.exit_code == 2
    assert "--pair takes two values, got 1 before --out" in json.loads(refused.stdout)["message"]
    taken = CliRunner().invoke(app, ["--pair", "a", "b", "--out", "c", "--json"])
    assert json.loads(taken.stdout) == {"pair": ["a", "b"], "out": "c"}


def test_a_table_in_us_units_has_their_names_and_numbers_and_json_stays_in_si():
    row = {
        "weight_kn": 4448.2216152605, "moment_knm": 1.3558179483314, "deck_disp_m": 0.0254,
        "initial_stiffness_kn_per_m": 175.126835, "length_m": 30.48, "gap_mm": 50.8,
        "clear_height_m": 3.048, "hinge_length_m": 0.254, "kx_mn_per_m": 175.126835,
        "deck_accel_mps2": 2.54, "yield_curvature_per_m": 1.0, "seat_m_low": 0.0254, "ok": True,
    }  # fmt: skip
    expected = {
        "weight_kip": 1000.0, "moment_kip_ft": 1.0, "deck_disp_in": 1.0, "ok": True,
        "initial_stiffness_kip_per_in": 1.0, "length_ft": 100.0, "gap_in": 2.0,
        "clear_height_ft": 10.0, "hinge_length_in": 10.0, "kx_kip_per_in": 1000.0,
        "deck_accel_in_per_s2": 100.0, "yield_curvature_per_in": 0.0254, "seat_in_low": 1.0,
    }  # fmt: skip
    assert (in_units(row, "us"), in_units(row, "si")) == (pytest.approx(expected, rel=1e-6), row)
    ends = in_units({"ends_m": [0.0254, None], "status": "ok"}, "us")
    assert ends == {"ends_in": [pytest.approx(1.0), None], "status": "ok"}
    check = {"check": "hinge 0.762 m (m)", "demand": 0.254, "capacity": 0.508, "ratio": 0.5}
    expected = {"check": "hinge 30 in (in)", "demand": 10.0, "capacity": 20.0, "ratio": 0.5}
    assert in_units(check, "us") == pytest.approx(expected)
    note = "a seat of {} m at a gap of {} mm, {} kN at 5 m/s"
    answer = Answer({"peak_kn": 100.0}, notes=[note.format(0.762, 51, 4448)])
    assert json.loads(run(answer, "--json", "--units=us").stdout) == {"peak_kn": 100.0}
    printed = run(answer, "--units", "us")
    assert "peak_kip" in printed.stdout
    assert "a seat of 30 in at a gap of 2.008 in, 1000 kip at 5 m/s\n" in printed.stderr


def test_statistics_are_printed_with_significant_digits():
    row = {"theta": 1.08163, "ci": [0.87194, 1234.5], "state": "any", "runs": 10_024}
    shown = run(Answer({"rows": [row]}, digits=3)).stdout.split()
    assert {"1.08", "0.872,", "1230", "any", "10024"} < set(shown)
    assert "0.9639" in run(Answer({"rows": [{"ratio": 0.96386}]}, digits=4)).stdout


def test_ctrl_c_while_modules_are_imported_is_one_line(monkeypatch, capsys):
    class Interrupted:
        def __getattr__(self, name):
            raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "skewbridge.cli", Interrupted())
    with pytest.raises(SystemExit, match="130"):
        main()
    assert capsys.readouterr().err == "interrupted\n"
